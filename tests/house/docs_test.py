#!/usr/bin/env python3
"""check_docs.py finds broken links, anchors and paths, and pages that are too long, and nothing else."""
import checked

PAGE = "docs/algorithms/page.md"
COMMON = {"docs/other.md": "## The stiffness `k_L` of a device\n", "src/a.cpp": ""}
CASES = [
    ("a link to a file", {PAGE: "[other](../other.md)\n"}, None),
    ("a link to a heading", {PAGE: "[other](../other.md#the-stiffness-k_l-of-a-device)\n"}, None),
    ("a link to the web", {PAGE: "[web](https://example.org/a#b)\n"}, None),
    ("paths and commands", {PAGE: "`src/a.cpp`, `src/`, `sqmap check`\n"}, None),
    ("code", {PAGE: "```\n[none](none.md)\n```\n"}, None),
    ("a page of the greatest length", {PAGE: "word " * 1500}, None),
    ("a link to no file", {PAGE: "[other](other.md)\n"}, "no file other.md"),
    ("a link to no heading", {PAGE: "[other](../other.md#none)\n"}, "no heading ../other.md#none"),
    ("a picture that is missing", {PAGE: "![picture](none.png)\n"}, "no file none.png"),
    ("a path that is missing", {PAGE: "`src/none.cpp`\n"}, "no file src/none.cpp"),
    ("a page that is too long", {PAGE: "word " * 1501}, "1501 words, at most 1500"),
]
checked.run("check_docs.py", CASES, COMMON)
