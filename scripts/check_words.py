#!/usr/bin/env python3
"""Checks identifiers against the table of words in CONTRIBUTING.md.

The table under the heading "Words" has a row for each idea: the word, the words not to use for it, and identifiers in which
such a word means something else. Identifiers of src, include, apps, bench, examples and tests are split at underscores and
capitals, so `near_list` is found in `make_near_list` and `NearList`; comments, strings and the names of tests, which are
sentences, are not read.
Comments are sentences: each has a subject and a verb. One that opens with What, Those, Whether, Where, Who or Of leaves the reader
to guess its subject.
usage: check_words.py [ROOT]     exit 0 when no identifier has a word that is not to be used, and no comment opens so
"""
import collections
import re
import sys

import cpp_source

FOLDERS = ("include", "src", "apps", "bench", "examples", "tests")
RIDDLE = re.compile(r'(\s*(//|#|/\*\*|"""|\'\'\')|.*///<)/?!?<?\s*(What|Those|Whether|Where|Whose|Who|Of|And|Again)\b')
RIDDLE_SUFFIXES = {".h", ".cpp", ".c", ".ts", ".mjs", ".js", ".css", ".py", ".sh"}


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
        yield "CONTRIBUTING.md: no table of words was found"
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
        yield from (f"{name}:{at[0]}: {identifier}: say {at[1]}" for identifier, at in seen.items() if at)


def riddles(root):
    """Comment lines that open without a subject."""
    for folder in (*FOLDERS, "scripts", "python", "js", "bindings"):
        for path in sorted(p for p in (root / folder).rglob("*") if p.suffix in RIDDLE_SUFFIXES and "node_modules" not in p.parts):
            for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), 1):
                if RIDDLE.match(line):
                    yield f"{path.relative_to(root).as_posix()}:{number}: {line.strip()}: name the subject"


def main():
    root = cpp_source.root_of(sys.argv[1:])
    found = [*violations(root), *riddles(root)]
    print("\n".join(found) if found else "words: identifiers use the words of CONTRIBUTING.md, and comments name their subject")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
