#!/usr/bin/env python3
"""Checks that classes, functions and files stay small enough to be read, in src and include.

A class is counted from its name to its closing brace, a function from its signature, a file whole. Parameters are counted in
public headers, of functions and methods that a program may call.
usage: check_sizes.py [ROOT] [--list]     exit 0 when all keep the limits or are excepted; --list prints all as exceptions
"""
import sys

import cpp_source
import house

MAX_LINES = {"class": 400, "function": 80, "file": 600}
MAX_PARAMETERS = 4


def violations(root):
    for path in cpp_source.sources(root, "src", "include", "apps"):
        name, text = path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")
        lines = text.count("\n")
        if lines > MAX_LINES["file"]:
            yield house.Violation(f"{name} file", f"{name}: a file of {lines} lines, at most {MAX_LINES['file']}", lines)
        for item in cpp_source.items(text):
            size = item.last - item.first + 1
            if size > MAX_LINES.get(item.kind, size):
                yield house.Violation(f"{name} {item.kind} {item.name}",
                                      f"{name}:{item.first}: {item.kind} {item.name} has {size} lines, at most {MAX_LINES[item.kind]}", size)
            if name.startswith("include/") and item.public and item.parameters > MAX_PARAMETERS:
                yield house.Violation(f"{name} parameters {item.name}",
                                      f"{name}:{item.first}: {item.name} has {item.parameters} parameters, at most {MAX_PARAMETERS}",
                                      item.parameters)


def main():
    root = house.root_of(sys.argv[1:])
    found = list(violations(root))
    if "--list" in sys.argv:
        print("\n".join(house.as_exceptions("sizes", found)))
        return 0
    return house.settle("sizes", root, found, "classes, functions, files and lists of parameters keep their limits")


if __name__ == "__main__":
    sys.exit(main())
