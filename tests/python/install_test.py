"""`pip install ./python` in an environment of its own, without a network, and what it leaves there.

usage: install_test.py SOURCES WORK"""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import zipfile

SOURCES, WORK = (pathlib.Path(p) for p in sys.argv[1:3])
USE = """
import numpy as np, sqmap, pathlib
assert pathlib.Path(sqmap.__file__).is_relative_to({prefix!r}), sqmap.__file__
v = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
t = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7],
              [1, 7, 3]])
model = sqmap.bake((v, t))
assert abs(model.signed_distance(np.array([[0, 0, 0.75]]))[0] - 0.25) < 1e-6
assert (model.render("mesh", size=(64, 64)) < 240).any()
"""


def main():
    for module in ("venv", "ensurepip"):
        if importlib.util.find_spec(module) is None:
            print(f"skipped: there is no {module} (Debian: python3-venv)")
            return 77
    shutil.rmtree(WORK, ignore_errors=True)
    environment = {k: v for k, v in os.environ.items()
                   if k not in ("PYTHONPATH", "SQMAP_LIBRARY", "SQMAP_PROGRAM") and not k.lower().endswith("_proxy")}
    # A network that is not there: whatever is looked for on an index fails.
    environment.update(PIP_NO_INDEX="1", PIP_DISABLE_PIP_VERSION_CHECK="1", PIP_CONFIG_FILE=os.devnull)
    run = lambda *command: subprocess.run(command, check=True, env=environment, cwd=WORK.parent)  # noqa: E731
    run(sys.executable, "-m", "venv", "--system-site-packages", str(WORK))
    python = str(WORK / "bin" / "python")
    run(python, "-m", "pip", "install", "--quiet", str(SOURCES / "python"))
    run(python, "-c", USE.format(prefix=str(WORK)))
    run(python, "-m", "sqmap", "--version")
    run(str(WORK / "bin" / "sqmap"), "--version")
    run(python, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(WORK), str(SOURCES / "python"))
    wheel = next(WORK.glob("sqmap-*.whl"))
    assert wheel.stat().st_size < 8e6, wheel.stat().st_size
    assert "sqmap/py.typed" in zipfile.ZipFile(wheel).namelist()
    print(f"{wheel.name}: {wheel.stat().st_size} bytes")
    return 0


sys.exit(main())
