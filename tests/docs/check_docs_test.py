#!/usr/bin/env python3
"""The check of the documentation must find broken links, anchors and paths, and pages that are too long, and nothing else."""
import pathlib
import subprocess
import sys
import tempfile

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "check_docs.py"

CASES = [  # text of docs/algorithms/page.md, whether something is wrong
    ("# Page\n[other](../other.md)\n", False),
    ("[other](../other.md#the-stiffness-k_l-of-a-device)\n", False),
    ("[web](https://example.org/a#b)\n", False),
    ("`src/a.cpp`, `src/`, `sqmap check`\n", False),
    ("```\n[none](none.md)\n```\n", False),
    ("word " * 1500, False),
    ("[other](other.md)\n", True),
    ("[other](../other.md#none)\n", True),
    ("![picture](none.png)\n", True),
    ("`src/none.cpp`\n", True),
    ("word " * 1501, True),
]

failed = 0
for text, is_bad in CASES:
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, words in (("docs/algorithms/page.md", text), ("docs/other.md", "## The stiffness `k_L` of a device\n"), ("src/a.cpp", "")):
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(words)
        found = subprocess.run([sys.executable, SCRIPT, root], capture_output=True, text=True)
        if (found.returncode == 1) != is_bad:
            failed += 1
            print(f"{text[:60]!r}: expected {'a complaint' if is_bad else 'none'}, got: {found.stdout}{found.stderr}")
print(f"{len(CASES) - failed} passed, {failed} failed")
sys.exit(1 if failed else 0)
