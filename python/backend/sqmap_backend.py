"""Builds the wheel of sqmap: the Python files, libsqmap.so.0 and the program, made by CMake. PEP 517, nothing but Python.

The library and the program come from SQMAP_BUILD_DIR where that is set: they are taken as they are. Else build/release of the
checkout is configured where it is not, and built.
"""
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
ROOT = PACKAGE.parent
NAME = "sqmap"
EPOCH = (1980, 1, 1, 0, 0, 0)  # the same files give the same wheel


def version():
    """The project's version, as CMake has it: the one in pyproject.toml has to agree."""
    text = (PACKAGE / "pyproject.toml").read_text(encoding="utf-8")
    own = re.search(r'^version = "(.+)"$', text, re.MULTILINE).group(1)
    lists = ROOT / "CMakeLists.txt"
    if lists.exists():
        cmake = re.search(r"project\(sqmap VERSION (\S+)", lists.read_text(encoding="utf-8")).group(1)
        if cmake != own:
            sys.exit(f"sqmap: pyproject.toml says {own}, CMakeLists.txt {cmake}")
    return own


def run(*command):
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"sqmap: {' '.join(map(str, command))} failed\n{done.stdout}\n"
                 "cure: './dev build' installs what building needs and shows more")


def built():
    """(library, program) as files."""
    named = os.environ.get("SQMAP_BUILD_DIR")
    build = pathlib.Path(named) if named else ROOT / "build" / "release"
    if not named:
        if not (ROOT / "CMakeLists.txt").exists():
            sys.exit("sqmap: the sources of the library are not beside python/: install from a checkout, or set SQMAP_BUILD_DIR")
        if not (build / "CMakeCache.txt").exists():
            run("cmake", "--preset", "release", "-DSQMAP_BUILD_BENCH=OFF")
        run("cmake", "--build", str(build), "--target", "sqmap_c", "sqmap")
    found = [build / "src" / "capi" / "libsqmap.so.0", build / "bin" / "sqmap"]
    for file in found:
        if not file.exists():
            sys.exit(f"sqmap: {file} is not there: build the targets sqmap_c and sqmap")
    return found


def stripped(file, folder):
    """A copy without symbols for debugging, or as it is where there is no strip."""
    copy = pathlib.Path(folder, file.name)
    shutil.copy(file.resolve(), copy)
    if shutil.which("strip"):
        subprocess.run(["strip", str(copy)], check=True)
    return copy


def metadata():
    readme = (PACKAGE / "README.md").read_text(encoding="utf-8")
    return (f"Metadata-Version: 2.1\nName: {NAME}\nVersion: {version()}\n"
            "Summary: Certified contact and signed distance between complex shapes\nLicense: Apache-2.0\n"
            "Requires-Python: >=3.9\nRequires-Dist: numpy\nDescription-Content-Type: text/markdown\n\n" + readme)


def tag():
    return f"py3-none-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def information():
    return {"METADATA": metadata(), "WHEEL": f"Wheel-Version: 1.0\nGenerator: sqmap\nRoot-Is-Purelib: false\nTag: {tag()}\n",
            "entry_points.txt": "[console_scripts]\nsqmap = sqmap.__main__:main\n"}


class Wheel:
    """A wheel that is written: files, and at last the record of them."""

    def __init__(self, path):
        self.zip, self.record = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED), []

    def add(self, name, data, executable=False):
        entry = zipfile.ZipInfo(name, EPOCH)
        entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, (0o100755 if executable else 0o100644) << 16
        self.zip.writestr(entry, data)
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.record.append(f"{name},sha256={digest},{len(data)}")

    def close(self, folder):
        name = f"{folder}/RECORD"
        self.zip.writestr(zipfile.ZipInfo(name, EPOCH), "\n".join([*self.record, f"{name},,", ""]))
        self.zip.close()


def write_wheel(wheel_directory, add_package):
    file = f"{NAME}-{version()}-{tag()}.whl"
    wheel, folder = Wheel(pathlib.Path(wheel_directory, file)), f"{NAME}-{version()}.dist-info"
    add_package(wheel)
    for name, text in information().items():
        wheel.add(f"{folder}/{name}", text.encode())
    wheel.close(folder)
    return file


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    library, program = built()

    def add_package(wheel):
        for file in sorted((PACKAGE / NAME).iterdir()):
            if file.suffix in (".py", ".typed"):
                wheel.add(f"{NAME}/{file.name}", file.read_bytes())
        with tempfile.TemporaryDirectory() as folder:
            wheel.add(f"{NAME}/_lib/libsqmap.so.0", stripped(library, folder).read_bytes(), executable=True)
            wheel.add(f"{NAME}/_bin/sqmap", stripped(program, folder).read_bytes(), executable=True)

    return write_wheel(wheel_directory, add_package)


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = pathlib.Path(metadata_directory, f"{NAME}-{version()}.dist-info")
    folder.mkdir(parents=True)
    for name, text in information().items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder.name


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_sdist(config_settings=None):
    return []


def build_sdist(sdist_directory, config_settings=None):
    sys.exit("sqmap: an archive of python/ alone lacks the library's sources: take one of the whole project")
