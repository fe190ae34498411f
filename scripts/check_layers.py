#!/usr/bin/env python3
"""Checks what may use what, from the real #include lines and CMake files.

1. Folders: a folder includes itself and the folders to its left in the list of docs/architecture.md (the fenced block whose
   lines are "a < b < c"). A folder of that list holds its sub-folders unless the list names them too.
2. Knots: no two folders include one another, directly or through others, however deep they are. Files that stand in a
   folder beside its sub-folders count one by one (headers that the sub-folders share, sources that join them). A header
   counts with its source wherever that lies, since who includes the one needs the other. The source bears the header's name,
   or else it defines what the header declares; a function of a private header that another folder defines binds the header
   to that folder too. Modules of the Python package and of the page count one by one.
3. Targets: a CMakeLists.txt compiles files of its own folder only, no file is compiled by two targets, and no two libraries
   link one another.
4. Public headers: an include of "sqmap/..." names one that is there.
usage: check_layers.py [ROOT]     exit 0 when all is in order, 1 with a list when not
"""
import collections
import functools
import os
import pathlib
import re
import sys

import cpp_source

ROOTS = ("include/sqmap", "src", "apps", "bench", "examples")
# Folders from which targets include files without naming a folder, beside the file's own.
INCLUDE_BASES = ("include", "src", "apps", "apps/common", "apps/sqmap", "apps/viewer", "apps/viewer/server", "bench")
# Targets that compile files of another folder, each for a reason.
FOREIGN_SOURCES = {
    # Devices of makers' SDKs against declarations of our own: compiled, never linked or run.
    "vendor_declarations": "src/device/",
}


def read_order(text):
    """{folder: all folders that it may include} from the fenced block of the architecture page."""
    for block in re.findall(r"```[^\n]*\n(.*?)```", text, re.DOTALL):
        lines = [line.strip() for line in block.strip().split("\n")]
        if all(re.fullmatch(r"[\w/-]+( < [\w/-]+)+", line) for line in lines):
            direct = collections.defaultdict(set)
            for line in lines:
                names = line.split(" < ")
                for left, right in zip(names, names[1:]):
                    direct[right].add(left)
                    direct[left] |= set()
            return {name: closure(name, direct) for name in direct}
    return {}


def closure(name, direct):
    seen, waiting = {name}, [name]
    while waiting:
        for other in direct.get(waiting.pop(), ()):
            if other not in seen:
                seen.add(other)
                waiting.append(other)
    return seen


class Tree:
    """The project's C++ files and which of them each includes."""

    def __init__(self, root):
        self.root = root
        self.files = {p.relative_to(root).as_posix(): p for base in ROOTS for p in cpp_source.sources(root, base)}
        self.edges = []  # (file, included file)
        for name, path in self.files.items():
            for _, included in cpp_source.includes(path.read_text(encoding="utf-8")):
                target = self.resolve(name, included)
                if target is not None:
                    self.edges.append((name, target))

    def resolve(self, name, included):
        """The project's file that an include line leads to; None for anything outside it."""
        own = [pathlib.PurePosixPath(name).parent, *pathlib.PurePosixPath(name).parent.parents]
        for base in [own[0], *map(pathlib.PurePosixPath, INCLUDE_BASES)]:
            parts = []
            for part in (base / included).parts:
                if part == "..":
                    parts = parts[:-1]
                else:
                    parts.append(part)
            candidate = "/".join(parts)
            if candidate in self.files:
                return candidate
        return None


def folder(name):
    """Folder of a file as the list of the architecture page calls it: query/point, apps/sqmap/render."""
    for base in ("include/sqmap/", "src/"):
        if name.startswith(base):
            return pathlib.PurePosixPath(name[len(base) :]).parent.as_posix()
    return pathlib.PurePosixPath(name).parent.as_posix()


def declared(where, order):
    """The longest folder of the list that holds this one."""
    while where not in ("", "."):
        if where in order:
            return where
        where = pathlib.PurePosixPath(where).parent.as_posix()
    return None


def within(inner, outer):
    return inner == outer or inner.startswith(outer + "/")


def order_violations(tree, order):
    if not order:
        yield "docs/architecture.md: no list of the order was found"
    for name in tree.files:
        if declared(folder(name), order) is None and folder(name) != ".":
            yield f"{name}: folder '{folder(name)}' has no place in the order of docs/architecture.md"
    for name, target in tree.edges:
        own, other = declared(folder(name), order), declared(folder(target), order)
        if own is None or other is None or within(own, other):
            continue
        allowed = set().union(*(order[o] for o in order if within(own, o)))
        if not any(within(other, a) and (a == other or a not in (own, *(o for o in order if within(own, o)))) for a in allowed):
            yield f"{name}: {own}/ must not include {other}/ ({target})"


def knots(nodes, edges):
    """Strongly connected sets of more than one node (Tarjan), each sorted."""
    after = collections.defaultdict(set)
    for a, b in edges:
        after[a].add(b)
    index, low, stack, on, found = {}, {}, [], set(), []
    for start in sorted(nodes):
        if start in index:
            continue
        work = [(start, iter(sorted(after[start])))]
        index[start] = low[start] = len(index)
        stack.append(start)
        on.add(start)
        while work:
            node, rest = work[-1]
            for other in rest:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    on.add(other)
                    work.append((other, iter(sorted(after[other]))))
                    break
                if other in on:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    group = set()
                    while True:
                        other = stack.pop()
                        on.discard(other)
                        group.add(other)
                        if other == node:
                            break
                    if len(group) > 1:
                        found.append(sorted(group))
    return found


def sources_of(header, including, functions):
    """The files that include a header and bear its name in its top folder; else those that define what it declares."""
    top = folder(header).split("/")[0]
    sources = [f for f in including if f.endswith(".cpp") and folder(f).split("/")[0] == top]
    named = [f for f in sources if pathlib.PurePosixPath(f).stem == pathlib.PurePosixPath(header).stem]
    if named:
        return named
    return [f for f in sources if functions(header)[";"] & functions(f)["{"]]


# A function at namespace scope, which is not indented: its name, and whether its body follows.
FUNCTION = re.compile(r"^\w[^\n(;{}=]*?[\s&*](\w+)\([^;{}]*?\)[^;{}()]*([;{])", re.MULTILINE)


def functions_of(path):
    """{";": names of functions that a file declares, "{": of those that it defines}"""
    found = {";": set(), "{": set()}
    for name, end in FUNCTION.findall(re.sub(r"\[\[[^\]]*\]\] ?", "", cpp_source.code_of(path.read_text(encoding="utf-8")))):
        found[end].add(name)
    return found


def nodes_of(tree):
    """{file: what it counts as for knots}: its folder, or itself where sub-folders stand beside it; a header as its source does."""
    folders = {folder(name) for name in tree.files}
    parents = {p.as_posix() for f in folders for p in pathlib.PurePosixPath(f).parents} & folders
    node = {name: name if folder(name) in parents else folder(name) for name in tree.files}
    functions = functools.cache(lambda name: functions_of(tree.files[name]))
    including = collections.defaultdict(list)
    for name, target in tree.edges:
        including[target].append(name)
    for header in filter(lambda name: name.endswith(".h"), tree.files):
        sources = sources_of(header, including[header], functions)
        homes = {node[f] for f in sources} - {node[header]}
        if node[header] == header and len(homes) == 1:
            node[header] = homes.pop()
        elif node[header] != header:
            node.update((f, node[header]) for f in sources if node[f] == f)
    return node


def strays(tree):
    """(header, source, functions) where a private header declares functions that none of its folder defines, but a source of
    another folder below the same one does: who includes the header needs that folder too."""
    functions = functools.cache(lambda name: functions_of(tree.files[name]))
    in_folder = collections.defaultdict(set)
    for name in filter(lambda name: name.startswith("src/"), tree.files):
        in_folder[folder(name)] |= functions(name)["{"]
    for source, header in tree.edges:
        if header.startswith("src/") and header.endswith(".h") and source.endswith(".cpp"):
            names = (functions(header)[";"] - in_folder[folder(header)]) & functions(source)["{"]
            if names and folder(header) != folder(source) and folder(header).split("/")[0] == folder(source).split("/")[0]:
                yield header, source, names


def folder_knots(tree):
    node = nodes_of(tree)
    edges = {}
    for a, b in tree.edges:
        if node[a] != node[b]:
            edges.setdefault((node[a], node[b]), f"{a} includes {b}")
    for header, source, names in strays(tree):
        if node[header] != node[source]:
            edges.setdefault((node[header], node[source]), f"{source} defines {', '.join(sorted(names))} of {header}")
    for group in knots(set(node.values()), edges):
        why = [words for (a, b), words in sorted(edges.items()) if a in group and b in group]
        yield f"knot of {', '.join(group)}: {'; '.join(why)}"


# Modules that import one another: folder, suffix, how a module names another of the project.
MODULES = (("python/sqmap", ".py", re.compile(r"^\s*from \.(\w*) import ([\w, ]*)", re.MULTILINE)),
           ("apps/viewer/web/src", ".ts", re.compile(r"""^(?:import|export)\b[^'"]*['"](\.[^'"]*)['"]()""", re.MULTILINE)))


def module_knots(root):
    for base, suffix, imports in MODULES:
        files = {p: p.relative_to(root).as_posix() for p in (root / base).rglob(f"*{suffix}")}
        edges = set()
        for path, name in files.items():
            for module, imported in imports.findall(path.read_text(encoding="utf-8")):
                for other in [module] if module else re.findall(r"\w+", imported):
                    target = pathlib.Path(os.path.normpath(path.parent / f"{other}{suffix}"))
                    if target in files:
                        edges.add((name, files[target]))
        for group in knots(set(files.values()), edges):
            yield f"knot of {', '.join(group)}"


COMMAND = re.compile(r"^[ \t]*(add_library|add_executable|target_sources|target_link_libraries|sqmap_add_tests)\s*\(([^()]*(?:\([^()]*\)[^()]*)*)\)",
                     re.MULTILINE)
WORDS = re.compile(r'"[^"]*"|[^\s"]+')


def target_violations(root):
    compiled, links = collections.defaultdict(set), []
    lists = sorted(p for base in ("src", "apps", "bench", "examples", "tests") for p in (root / base).rglob("CMakeLists.txt"))
    for path in lists:
        here = path.parent.relative_to(root).as_posix()
        text = re.sub(r"#[^\n]*", "", path.read_text(encoding="utf-8"))
        for command, body in COMMAND.findall(text):
            words = [w.strip('"') for w in WORDS.findall(body)]
            if not words:
                continue
            target = words[0]
            if command == "target_link_libraries":
                links += [(target, w.replace("::", "_")) for w in words[1:] if w.startswith("sqmap")]
                continue
            for word in words[1:]:
                if not re.search(r"\.(cpp|c|cc)$", word) or "BINARY_DIR" in word:
                    continue
                word = word.replace("${CMAKE_CURRENT_SOURCE_DIR}", str(path.parent)).replace("${PROJECT_SOURCE_DIR}", str(root))
                if "${" in word:
                    continue
                source = pathlib.Path(path.parent, word).resolve()
                if not source.is_relative_to(root):
                    continue
                source = source.relative_to(root).as_posix()
                foreign = FOREIGN_SOURCES.get(target)
                if foreign and source.startswith(foreign):
                    continue
                compiled[source].add(target)
                if not source.startswith(here + "/"):
                    yield f"{here}/CMakeLists.txt: {target} compiles {source}, a file of another folder"
    for source, targets in sorted(compiled.items()):
        if len(targets) > 1:
            yield f"{source}: compiled by {', '.join(sorted(targets))}"
    for group in knots({t for link in links for t in link}, set(links)):
        yield "knot of targets: " + ", ".join(group)


def lost_includes(root, tree):
    for base in (*ROOTS, "tests", "bindings"):
        for path in cpp_source.sources(root, base):
            name = path.relative_to(root).as_posix()
            for _, included in cpp_source.includes(path.read_text(encoding="utf-8")):
                if included.startswith("sqmap/") and tree.resolve(name, included) is None:
                    yield f"{name}: there is no public header {included} (src may have it)"


def violations(root):
    page = root / "docs" / "architecture.md"
    tree = Tree(root)
    yield from order_violations(tree, read_order(page.read_text(encoding="utf-8") if page.exists() else ""))
    yield from folder_knots(tree)
    yield from module_knots(root)
    yield from target_violations(root)
    yield from lost_includes(root, tree)


def main():
    found = list(violations(cpp_source.root_of(sys.argv[1:])))
    print("\n".join(found) if found else "layers: every include follows the order, and nothing is knotted")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
