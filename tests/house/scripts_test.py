#!/usr/bin/env python3
"""A name that a script takes from another script stands there: Python itself says so only when that line runs. No function of
the project's Python exceeds 80 lines, no class 400, as clang-tidy asks of C++."""
import ast
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "scripts"
MAX_LINES = {ast.FunctionDef: 80, ast.ClassDef: 400}
TREES = {p.stem: ast.parse(p.read_text(), p.name) for p in sorted(FOLDER.glob("*.py"))}


def defined(tree):
    """Names that a module has once it is imported."""
    names = set()
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            names.update((a.asname or a.name).partition(".")[0] for a in node.names)
        else:
            names.update(n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
    return names


def missing(name, tree, known):
    """The faults of one script, a line each."""
    imported = {a.asname or a.name: a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names if a.name in known}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in imported:
            module = imported[node.value.id]
            if node.attr not in known[module]:
                yield f"scripts/{name}.py:{node.lineno}: {module} has no {node.attr}"
        if isinstance(node, ast.ImportFrom) and node.module in known:
            for a in node.names:
                if a.name not in known[node.module]:
                    yield f"scripts/{name}.py:{node.lineno}: {node.module} has no {a.name}"


def too_long():
    """Functions and classes beyond their limit, a line each."""
    for folder in ("scripts", "tests", "python", "bindings", "apps", "bench", "examples"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if "node_modules" in path.parts:
                continue
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), path.name)):
                lines = getattr(node, "end_lineno", 0) - getattr(node, "lineno", 0) + 1
                if lines > MAX_LINES.get(type(node), lines):
                    yield f"{path.relative_to(ROOT)}:{node.lineno}: {node.name} has {lines} lines, at most {MAX_LINES[type(node)]}"


known = {name: defined(tree) for name, tree in TREES.items()}
wrong = [line for name, tree in TREES.items() for line in missing(name, tree, known)]
wrong += too_long()
broken = ast.parse("import demo_meshes\nimport plot as p\nfrom measure import gone\ndemo_meshes.fetch()\ndemo_meshes.gone()\np.gone\n")
found = list(missing("broken", broken, known))
if len(found) != 3:
    wrong.append(f"three errors were put in, {len(found)} were found: {found}")
print("\n".join(wrong))
sys.exit(bool(wrong))
