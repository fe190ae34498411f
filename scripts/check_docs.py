#!/usr/bin/env python3
"""Checks the documentation: links and their anchors, paths of the repository that stand in backticks, length of algorithm pages.

usage: check_docs.py [ROOT]     exit 0 when all is well, 1 with a list when not
"""
import pathlib
import re
import sys

MAX_WORDS = 1500  # of a page in docs/algorithms, without its code
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
PATH = re.compile(r"`((?:include|src|apps|bench|docs|examples|scripts|tests|cmake)/[\w./-]*[\w/])`")


def slug(heading):
    """The anchor that GitHub gives a heading."""
    text = re.sub(r"[`*]|\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def anchors(text):
    return {slug(m[1]) for m in re.finditer(r"^#+\s+(.*)$", FENCE.sub("", text), re.MULTILINE)}


def pages(root):
    return sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")])


def problems(root):
    for page in pages(root):
        where, text = page.relative_to(root), FENCE.sub("", page.read_text(encoding="utf-8"))
        for link in LINK.findall(text):
            if re.match(r"[a-z]+:", link):
                continue
            file, _, anchor = link.partition("#")
            target = (page.parent / file).resolve() if file else page
            if not target.exists():
                yield f"{where}: no file {link}"
            elif anchor and anchor not in anchors(target.read_text(encoding="utf-8")):
                yield f"{where}: no heading {link}"
        for path in PATH.findall(text):
            if not (root / path).exists():
                yield f"{where}: no file {path}"
        words = sum(bool(re.search(r"\w", word)) for word in text.split())
        if page.parent.name == "algorithms" and words > MAX_WORDS:
            yield f"{where}: {words} words, at most {MAX_WORDS}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)
    found = list(problems(root))
    print("\n".join(found) if found else "docs: links, paths and lengths are right")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
