"""`./dev archives`: the wheel keeps its size, and the sources that it packs can be configured.

usage: archives_test.py SOURCES WORK     the build to take the wheel's library from: SQMAP_BUILD_DIR"""
import pathlib
import shutil
import subprocess
import sys
import tarfile

SOURCES, WORK = (pathlib.Path(p) for p in sys.argv[1:3])
if shutil.which("git") is None or not (SOURCES / ".git").exists():
    print("skipped: no git checkout")
    sys.exit(77)
shutil.rmtree(WORK, ignore_errors=True)
subprocess.run([sys.executable, SOURCES / "scripts/archives.py", "--out", WORK], check=True)
[archive], [_] = WORK.glob("*.tar.gz"), WORK.glob("*.whl")
with tarfile.open(archive) as tar:
    tar.extractall(WORK)
unpacked = WORK / archive.name.removesuffix(".tar.gz")
subprocess.run(["cmake", "-S", unpacked, "-B", WORK / "build", "-G", "Ninja", "-DSQMAP_BUILD_TESTS=OFF", "-DSQMAP_BUILD_BENCH=OFF"],
               check=True, stdout=subprocess.DEVNULL)
