"""Runs the code of the guide, block after block, in one session that has a mesh of its own; what a comment says is printed is.

usage: guide_test.py GUIDE"""
import os
import pathlib
import re
import sys
import tempfile

from support import ball_model, torus_model

guide = pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")
blocks = re.findall(r"^```python\n(.*?)^```", guide, re.DOTALL | re.MULTILINE)
assert len(blocks) >= 6, len(blocks)
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    torus_model().export("ring.obj")
    ball_model().export("ball.obj")
    session = {}
    for number, block in enumerate(blocks, 1):
        exec(compile(block, f"block {number}", "exec"), session)
    os.chdir("/")
print(f"{len(blocks)} blocks")
