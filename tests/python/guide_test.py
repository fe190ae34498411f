"""Runs the code of the guide, block after block, in one session: what a block prints is what the text behind it shows.

usage: guide_test.py GUIDE [--update]      --update writes what is printed into the guide"""
import contextlib
import importlib.util
import io
import os
import pathlib
import re
import sys
import tempfile

path = pathlib.Path(sys.argv[1]).resolve()
guide = path.read_text(encoding="utf-8")
blocks = list(re.finditer(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", guide, re.DOTALL | re.MULTILINE))
assert len(blocks) >= 7, len(blocks)
os.environ["MPLBACKEND"] = "Agg"  # no window
shown = 0
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    session = {}
    for number, block in enumerate(blocks, 1):
        if "matplotlib" in block[1] and importlib.util.find_spec("matplotlib") is None:
            print(f"skipped in part: block {number} draws, and there is no matplotlib (Debian: python3-matplotlib)")
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(block[1], f"block {number}", "exec"), session)
        printed = "".join(line.rstrip() + "\n" for line in out.getvalue().splitlines())
        if "--update" in sys.argv:
            assert (block[2] is not None) == bool(printed), f"block {number} prints {printed!r}"
            guide = guide.replace(block[0], block[0].replace(f"```text\n{block[2]}", f"```text\n{printed}"))
            continue
        assert printed == (block[2] or ""), f"block {number} prints\n{printed}and the guide shows\n{block[2]}"
        shown += bool(printed)
    os.chdir("/")
if "--update" in sys.argv:
    path.write_text(guide, encoding="utf-8")
print(f"{len(blocks)} blocks, {shown} with what they print")
