#!/usr/bin/env python3
"""Checks identifiers against the table of words in CONTRIBUTING.md.

The table under the heading "Words" has a row for each idea: the word, the words not to use for it, and identifiers in which
such a word means something else. Identifiers of src, include, apps, bench, examples and tests are split at underscores and
capitals, so `near_list` is found in `make_near_list` and `NearList`; comments, strings and the names of tests, which are
sentences, are not read.
usage: check_words.py [ROOT] [--list]     exit 0 when no identifier has a word that is not to be used
"""
import collections
import re
import sys

import cpp_source
import house

FOLDERS = ("include", "src", "apps", "bench", "examples", "tests")


def read_table(text):
    """[(word to use, parts of the other word)], {identifiers that may stay} of the table."""
    section = re.search(r"^## Words$(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    banned, allowed = [], set()
    for row in re.findall(r"^\|(.*)\|\s*$", section.group(1) if section else "", re.MULTILINE):
        cells = [c.strip() for c in row.split("|")]
        if len(cells) != 3 or cells[0] == "use" or set(cells[0]) <= set("-: "):
            continue
        banned += [(cells[0], tuple(word.split("_"))) for word in re.findall(r"`(\w+)`", cells[1])]
        allowed |= set(re.findall(r"`([\w*]+)`", cells[2]))
    return banned, allowed


def parts_of(identifier):
    """near_list, NearList, k_near_list, near_list_ -> near, list (k stays as a part of its own)."""
    spaced = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", identifier)
    return [p.lower() for p in spaced.split("_") if p]


def permits(allowed, identifier):
    return any(identifier == a or ("*" in a and re.fullmatch(a.replace("*", r"\w*"), identifier)) for a in allowed)


def violations(root):
    page = root / "CONTRIBUTING.md"
    banned, allowed = read_table(page.read_text(encoding="utf-8") if page.exists() else "")
    if not banned:
        yield house.Violation("table", "CONTRIBUTING.md: no table of words was found")
    by_first = collections.defaultdict(list)
    for use, parts in banned:
        by_first[parts[0]].append((use, parts))
    for path in cpp_source.sources(root, *FOLDERS):
        name, text = path.relative_to(root).as_posix(), cpp_source.code_of(path.read_text(encoding="utf-8"))
        text = re.sub(r"\b(TEST(?:_[FP])?)\(([^()]*)\)", lambda m: m.group(1) + "(" + " " * len(m.group(2)) + ")", text)
        seen = collections.OrderedDict()
        for match in re.finditer(r"\b[A-Za-z_]\w*\b", text):
            identifier = match.group(0)
            if identifier in seen:
                continue
            parts = parts_of(identifier)
            hit = next((use for i, part in enumerate(parts) for use, other in by_first.get(part, ())
                        if tuple(parts[i : i + len(other)]) == other), None)
            seen[identifier] = (text.count("\n", 0, match.start()) + 1, hit) if hit and not permits(allowed, identifier) else None
        bad = [(i, at) for i, at in seen.items() if at]
        if bad:
            shown = "\n".join(f"{name}:{line}: {identifier}: say {use}" for identifier, (line, use) in bad)
            yield house.Violation(name, shown, len(bad))


def main():
    root = house.root_of(sys.argv[1:])
    found = list(violations(root))
    if "--list" in sys.argv:
        print("\n".join(house.as_exceptions("words", found)))
        return 0
    return house.settle("words", root, found, "identifiers use the words of CONTRIBUTING.md")


if __name__ == "__main__":
    sys.exit(main())
