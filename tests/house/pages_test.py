#!/usr/bin/env python3
"""No page of the documentation is longer than a reader reads, and files of the repository that a page names are there. Sphinx
checks links (docs.site)."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
MAX_WORDS = 1500  # of a page, code and tables included
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
wrong = []
for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
    whole = page.read_text(encoding="utf-8")
    paths = re.findall(r"`((?:include|src|apps|bench|docs|examples|scripts|tests|cmake)/[\w./-]*[\w/])`", FENCE.sub("", whole))
    wrong += [f"{page.relative_to(ROOT)}: no file {path}" for path in paths if not (ROOT / path).exists()]
    if page.name != "CHANGELOG.md" and len(whole.split()) > MAX_WORDS:
        wrong.append(f"{page.relative_to(ROOT)}: {len(whole.split())} words, at most {MAX_WORDS}")
print("\n".join(wrong))
sys.exit(bool(wrong))
