#!/usr/bin/env python3
"""Links of the documentation lead to files of the repository, and no page is longer than a reader reads. Sphinx checks anchors too,
where it is installed (./dev docs)."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
MAX_WORDS = 1500  # of a page, code and tables included
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
wrong = []
for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
    whole = page.read_text(encoding="utf-8")
    text = FENCE.sub("", whole)
    links = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text) if not re.match(r"[a-z]+:|#", link)]
    paths = re.findall(r"`((?:include|src|apps|bench|docs|examples|scripts|tests|cmake)/[\w./-]*[\w/])`", text)
    wrong += [f"{page.relative_to(ROOT)}: no file {link}" for link in links if not (page.parent / link).exists()]
    wrong += [f"{page.relative_to(ROOT)}: no file {path}" for path in paths if not (ROOT / path).exists()]
    if page.name != "CHANGELOG.md" and len(whole.split()) > MAX_WORDS:
        wrong.append(f"{page.relative_to(ROOT)}: {len(whole.split())} words, at most {MAX_WORDS}")
print("\n".join(wrong))
sys.exit(bool(wrong))
