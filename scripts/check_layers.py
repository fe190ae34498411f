#!/usr/bin/env python3
"""Checks the dependency order of the folders from the real #include lines.

A folder may include itself and the folders named for it below, nothing else; see docs/architecture.md.
usage: check_layers.py [ROOT]     exit 0 when every include is allowed, 1 with a list when not
"""
import pathlib
import re
import sys

RUNTIME = ["math", "shape", "model", "query", "haptic"]
BUILD = ["math", "shape", "mesh", "decompose", "fit", "bake"]
ALLOWED = {folder: set(RUNTIME[: i + 1]) for i, folder in enumerate(RUNTIME)}
ALLOWED["io"] = {"math", "shape", "model", "io"}
for i, folder in enumerate(BUILD):
    ALLOWED.setdefault(folder, set()).update(BUILD[: i + 1])
# Baking writes models and judges the map it has just made with the query that will read it.
ALLOWED["bake"] |= {"model", "query", "parallel"}
ALLOWED["parallel"] = {"parallel"}

ALLOWED["sim"] = {"math", "shape", "model", "query", "sim"}
ALLOWED["device"] = ALLOWED["haptic"] | {"haptic", "device"}

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]', re.MULTILINE)
SOURCES = {".h", ".hpp", ".cpp", ".inl"}


def folder_of(include, path, root):
    """Folder of the project that an include line leads to; None for anything outside it."""
    parts = pathlib.PurePosixPath(include).parts
    if parts[0] == "sqmap" and len(parts) > 2:
        return parts[1]
    if len(parts) > 1 and parts[0] in ALLOWED:
        return parts[0]
    target = (path.parent / include).resolve()
    for base in (root / "src", root / "include" / "sqmap"):
        if target.is_relative_to(base.resolve()) and target.exists():
            return target.relative_to(base.resolve()).parts[0]
    return None


def violations(root):
    for base in (root / "include" / "sqmap", root / "src"):
        for path in sorted(p for p in base.rglob("*") if p.suffix in SOURCES):
            folder = path.relative_to(base).parts[0]
            where = path.relative_to(root)
            if folder not in ALLOWED:
                yield f"{where}: folder '{folder}' has no place in the dependency order"
                continue
            for include in INCLUDE.findall(path.read_text(encoding="utf-8")):
                target = folder_of(include, path, root)
                if target is not None and target not in ALLOWED[folder]:
                    yield f"{where}: {folder}/ must not include {target}/ ({include})"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)
    found = list(violations(root))
    print("\n".join(found) if found else "layers: every include follows the order")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
