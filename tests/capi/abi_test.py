"""The library's interface is that of the baseline or adds functions to it: nothing is taken away, no struct has changed.

usage: abi_test.py LIBRARY BASELINE [--update]     exit 77 where there is no abidiff (Debian: abigail-tools)
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

library, baseline = sys.argv[1:3]
if shutil.which("abidiff") is None:
    print("skipped: there is no abidiff (Debian: abigail-tools)")
    sys.exit(77)
now = subprocess.run(["abidw", "--no-corpus-path", "--no-show-locs", "--no-comp-dir-path", "--no-elf-needed",
                      "--exported-interfaces-only", library], check=True, capture_output=True, text=True).stdout
if "name='is_doubtful'" not in now:  # a member of a struct
    print("the library has no debug information: types were not compared")
    sys.exit(1)
if "--update" in sys.argv:
    pathlib.Path(baseline).write_text(now, encoding="utf-8")
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder, "now.abi")
    file.write_text(now, encoding="utf-8")
    done = subprocess.run(["abidiff", "--no-added-syms", baseline, str(file)], capture_output=True, text=True, check=False)
print(done.stdout + done.stderr)
if done.returncode != 0:
    print("the interface has changed: members are added at the end of structs, with a new baseline (--update); else take a new SONAME")
sys.exit(1 if done.returncode != 0 else 0)
