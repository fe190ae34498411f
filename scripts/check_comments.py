#!/usr/bin/env python3
"""Checks that every public name of include/ has a documentation comment, and that every header speaks of threads.

Names are those of functions, types, aliases and constants; members of structs are their structs' affair. Documented is what
stands under a /// comment, or has ///< behind it. Of a paragraph (lines without an empty line between them) that begins with a
/// comment, overloads of one name, operators, special members, aliases, constants and definitions of one line share that
comment; anything else needs its own. What the comment says is for readers to judge.
usage: check_comments.py [ROOT] [--list]     exit 0 when all have one
"""
import re
import sys

import cpp_source
import house


def documented(lines, item, previous):
    """lines: of the file; previous: the item before this one in the same paragraph, documented or not, or None."""
    above = lines[item.first - 2].strip() if item.first >= 2 else ""
    if above.startswith("///"):
        return True
    if item.kind not in ("class", "enum") or item.first == item.last:  # else it is a member's
        if any("///<" in line for line in lines[item.first - 1 : item.last]):
            return True
    if previous is None:
        return False
    name = item.name.split("::")[-1]
    if item.kind == "class" or previous.kind == "class":
        return False
    if item.kind == previous.kind and item.kind in ("alias", "constant"):
        return True
    special = name.startswith(("~", "operator")) or re.search(r"=\s*(default|delete)\s*$", item.signature) is not None
    return special or name == previous.name.split("::")[-1] or (item.kind == "function" and item.first == item.last)


def trivial(item):
    """Special members, and overrides, whose base says what they do."""
    *scope, name = item.name.split("::")
    own = scope[-1] if scope else ""
    return (re.search(r"=\s*(default|delete)\s*$|\boverride\b", item.signature) is not None or name.startswith("~")
            or (name == own and item.parameters == 0)
            or (name in (own, "operator=") and re.search(rf"\(\s*(const\s+)?{own}\s*&&?\s*\w*\s*\)", item.signature) is not None))


def violations(root):
    for path in cpp_source.sources(root, "include"):
        if path.stem.endswith("_impl"):
            continue  # bodies of templates that another header declares
        name, text = path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")
        lines, previous, last = text.split("\n"), None, 0
        if path.name != "sqmap.h" and "thread" not in text.lower():
            yield house.Violation(f"{name} threads", f"{name}:1: says nothing of threads: which may call it, how many at once")
        for item in cpp_source.items(text):
            if not item.public:
                continue
            between = lines[last : item.first - 1]
            if any(not line.strip() for line in between) or any(line.strip().startswith("///") for line in between):
                previous = None
            ok = documented(lines, item, previous) or trivial(item)
            if not ok:
                yield house.Violation(f"{name} {item.name}", f"{name}:{item.first}: {item.name} has no documentation comment")
            previous, last = (item if ok else None), (item.first if item.kind == "class" else item.last)


def main():
    root = house.root_of(sys.argv[1:])
    found = list({v.key: v for v in violations(root)}.values())
    if "--list" in sys.argv:
        print("\n".join(house.as_exceptions("comments", found)))
        return 0
    return house.settle("comments", root, found, "every public name has a documentation comment")


if __name__ == "__main__":
    sys.exit(main())
