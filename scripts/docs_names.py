"""Public names of C, Python and JavaScript, and which of them the documentation site has, with a word of what they are.

Doxygen lists the names of C++, and the test house.comments fails where a header says nothing of one."""
import re
import zlib

# Run by a Python that imports the package: every public name, with a "?" behind those that have no docstring.
PYTHON_NAMES = """
import inspect, sqmap
for name in sqmap.__all__:
    value = getattr(sqmap, name)
    if not (inspect.isclass(value) or inspect.isfunction(value)): continue
    print(f"sqmap.{name}" + ("" if inspect.getdoc(value) else "?"))
    for key, member in vars(value).items() if inspect.isclass(value) else ():
        member = getattr(member, "fget", None) or getattr(member, "__func__", member)
        if not key.startswith("_") and inspect.isfunction(member):
            print(f"sqmap.{name}.{key}" + ("" if inspect.getdoc(member) else "?"))
"""
C_SECTION = re.compile(r"^// -{20,} (.+)$", re.MULTILINE)
C_NAME = re.compile(r"^typedef (?P<kind>struct|enum) (?P<type>\w+) \{|^enum (?P<bits>\w+) \{|^typedef [^;{]*\(\*(?P<callback>\w+)\)"
                    r"|^SQMAP_API [^;]*?(?P<function>\w+)\(", re.MULTILINE)


def c_names(text):
    """[(directive of Breathe, name, whether a /// comment stands above it)] of the header of C, in order."""
    directives = {"struct": "doxygenstruct", "enum": "doxygenenum"}
    for m in C_NAME.finditer(text):
        documented = text[: m.start()].rstrip("\n").rsplit("\n", 1)[-1].startswith("///")
        directive = directives.get(m["kind"] or "", "doxygenenum" if m["bits"] else "doxygentypedef" if m["callback"] else "doxygenfunction")
        yield directive, m["type"] or m["bits"] or m["callback"] or m["function"], documented


def c_page(text):
    """The reference of C: what the header says of itself, then its sections."""
    begin, *sections = C_SECTION.split(text)
    introduction = re.sub(r"^// ?", "", begin.split("#pragma")[0], flags=re.MULTILINE).strip()
    page = ["# C\n", re.sub(r"^(\w+):", r"\n**\1:**", introduction, flags=re.MULTILINE) + "\n"]
    for title, body in zip(sections[::2], sections[1::2]):
        page.append(f"## {title.capitalize()}\n")
        for directive, name, _ in c_names(body):
            members = ":members:\n:undoc-members:\n" if directive == "doxygenstruct" else ""
            page.append(f"```{{{directive}}} {name}\n:project: sqmap\n{members}```\n")
    return "\n".join(page)


def javascript_names(text):
    """[(name, whether a comment stands above or behind it)] of index.d.ts: what is exported, and its methods."""
    documented, scope = False, ""
    for line in text.split("\n"):
        if begins := re.match(r"export (?:class|interface|type|function) (\w+)", line):
            scope = begins[1]
            yield scope, documented
        elif method := re.match(r"  (\w+)\??\(", line):
            yield f"{scope}.{method[1]}", documented or "//" in line
        documented = line.rstrip().endswith("*/")


def javascript_exports(text):
    """What index.js gives away: its exports, methods and getters of the classes among them and of Sqmap, which load gives."""
    scope = ""
    for line in text.split("\n"):
        if begins := re.match(r"(export )?(?:async )?(class|function|const) (\w+)", line):
            scope = begins[3] if begins[2] == "class" and (begins[1] or begins[3] == "Sqmap") else ""
            if begins[1]:
                yield begins[3]
        elif scope and (method := re.match(r"  (?:get )?([a-z]\w*)\(.*\{$", line)) and method[1] != "constructor":
            yield f"{scope}.{method[1]}"


def inventory(site):
    """All that Sphinx has an entry for: C++ with namespaces, Python with the package."""
    listed = zlib.decompress((site / "objects.inv").read_bytes().split(b"\n", 4)[4]).decode()
    return {line.split(" ", 1)[0] for line in listed.splitlines()}


def missing(root, site, python_names):
    """A line for each public name that the site lacks or that nothing is said of."""
    there = inventory(site)
    for _, name, documented in c_names((root / "include/sqmap.h").read_text(encoding="utf-8")):
        if name not in there:
            yield f"C: {name} is not on the site"
        if not documented:
            yield f"C: nothing is said of {name}"
    for name in python_names:
        if name.rstrip("?") not in there:
            yield f"Python: {name.rstrip('?')} is not on the site"
        if name.endswith("?"):
            yield f"Python: nothing is said of {name[:-1]}"
    declared = dict(javascript_names((root / "js/index.d.ts").read_text(encoding="utf-8")))
    yield from (f"JavaScript: nothing is said of {name}" for name, documented in declared.items() if not documented)
    listing = re.sub(r"<[^>]*>", "", (site / "reference/javascript.html").read_text(encoding="utf-8"))
    for name in dict.fromkeys([*declared, *javascript_exports((root / "js/index.js").read_text(encoding="utf-8"))]):
        if not re.search(rf"\b{name.split('.')[-1]}\b", listing):
            yield f"JavaScript: {name} is not on the site"
