#!/usr/bin/env python3
"""The documentation as a site: build/docs/site/index.html. Guides and references of C++, C, Python and JavaScript, notebooks with
their output, the format, the changelog, and live models where ./dev anywhere page has built the page. A broken link fails.

usage: docs_site.py [--without-notebooks]     exit 77 where a package is missing
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import anywhere

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/docs"
SOURCE = BUILD / "source"
PYTHON = "/usr/bin/python3"  # Debian's, which has Sphinx

CONF = '''
project = "sqmap"
author = "the sqmap authors"
copyright = "the sqmap authors, Apache-2.0"
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = "sqmap"
exclude_patterns = []
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]
breathe_projects = {"sqmap": "XML"}
breathe_default_project = "sqmap"
breathe_domain_by_file_pattern = {"*/include/sqmap.h": "c"}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
highlight_language = "none"
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
cpp_id_attributes = ["SQMAP_API"]
c_id_attributes = ["SQMAP_API"]
'''

DOXYFILE = '''
PROJECT_NAME = sqmap
INPUT = "{include}/sqmap" "{include}/sqmap.h"
RECURSIVE = YES
FILE_PATTERNS = *.h
OUTPUT_DIRECTORY = "{out}"
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
JAVADOC_AUTOBRIEF = YES
ENABLE_PREPROCESSING = YES
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = SQMAP_API=
TYPEDEF_HIDES_STRUCT = YES
EXTRACT_ALL = NO
QUIET = YES
AUTOLINK_SUPPORT = NO
WARN_IF_UNDOCUMENTED = NO
WARN_AS_ERROR = FAIL_ON_WARNINGS
ALIASES = "pre=@par Precondition:^^" "throw=@par Throws:^^"
'''

INDEX = '''# sqmap

```{{toctree}}
:maxdepth: 1
:caption: Start

README
docs/examples
docs/guide/python
docs/guide/c
docs/guide/javascript
docs/guide/anywhere
docs/guide/view
docs/guide/dress
docs/guide/paper
{guides}
```

```{{toctree}}
:maxdepth: 1
:caption: Notebooks

{notebooks}
```

```{{toctree}}
:maxdepth: 1
:caption: Reference

reference/cpp
reference/c
reference/python
reference/javascript
{reference}
CHANGELOG
CONTRIBUTING
```

```{{toctree}}
:maxdepth: 1
:caption: How it works

docs/architecture
{algorithms}
```

```{{toctree}}
:maxdepth: 1
:caption: Measurements

{measurements}
```
'''


# A live model: nothing of it is loaded before the click.
LIVE = '''
```{{raw}} html
<div style="border:1px solid #8888;border-radius:8px;padding:1em;text-align:center">
<button data-live="{page}" onclick="const f=document.createElement('iframe');f.src=this.dataset.live;f.title='A model to touch';
f.allow='xr-spatial-tracking; gamepad; fullscreen';f.style='width:100%;height:520px;border:0';this.parentNode.replaceChildren(f)"
style="font-size:1.1em;padding:.5em 1em">Touch the model here</button><br><small>Loads {megabytes:.1f} MB, once.</small></div>
```
'''


C_SECTION = re.compile(r"^// -{20,} (.+)$", re.MULTILINE)
C_NAME = re.compile(r"^typedef (?P<kind>struct|enum) (?P<type>\w+) \{|^enum (?P<bits>\w+) \{|^typedef [^;{]*\(\*(?P<callback>\w+)\)"
                    r"|^SQMAP_API [^;]*?(?P<function>\w+)\(", re.MULTILINE)


def run(*command, **options):
    done = subprocess.run([str(c) for c in command], text=True, capture_output=True, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-6000:]}{done.stderr[-6000:]}")
    return done.stdout


def live(model, up):
    """A model in a frame; nothing where the page was not built."""
    page = anywhere.PAGE
    if not (page / "program.wasm").exists():
        return ""
    if not (page / model).exists():
        sys.exit(f"live {model}: the page has no such file")
    loaded = sum(f.stat().st_size for f in page.iterdir() if f.is_file()) + (page / model).stat().st_size
    return LIVE.format(page=f"{up}live/index.html?model={model}", megabytes=loaded / 1e6)


def included(match):
    """The file of the repository that the comment names; Sphinx fails where there is none."""
    path = match.group(1)
    return f"```{{literalinclude}} /{os.path.relpath(ROOT / path, SOURCE)}\n:language: {pathlib.Path(path).suffix.lstrip('.').replace('py', 'python').replace('mjs', 'js')}\n```"


def copy_pages():
    """Pages keep their folders, so that links between them hold; links to sources become their names."""
    pages = [ROOT / n for n in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")] + sorted((ROOT / "docs").rglob("*.md"))
    for page in pages:
        target = SOURCE / page.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)

        def link(match, page=page):
            text, address = match.groups()
            path = (page.parent / address.split("#")[0]).resolve()
            if re.match(r"[a-z]+:|#", address) or path in pages or path.suffix in (".png", ".svg", ".gif", ".jpg"):
                return match.group(0)
            if not path.exists():
                sys.exit(f"{page.relative_to(ROOT)}: {address} does not exist")
            return text if text.startswith("`") else f"`{text}`"

        text = re.sub(r"(?<!!)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)", link, page.read_text())
        up = "../" * len(page.relative_to(ROOT).parent.parts)
        text = re.sub(r"<!-- live (\S+) -->", lambda match, up=up: live(match.group(1), up), text)
        target.write_text(re.sub(r"<!-- include (\S+) -->", included, text))
    shutil.copytree(ROOT / "docs/images", SOURCE / "docs/images", dirs_exist_ok=True)


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


def write_cpp_reference():
    """A page for each public folder: what its headers declare."""
    folder = SOURCE / "reference"
    folder.mkdir(parents=True, exist_ok=True)
    names = []
    top = ROOT / "include/sqmap"  # the front door's headers; sqmap.h declares nothing
    for group in [top, *sorted(p for p in top.iterdir() if p.is_dir())]:
        names.append(f"cpp_{group.name}")
        parts = [f"# {group.name}\n"]
        for header in sorted(h for h in group.glob("*.h") if h.name != "sqmap.h"):
            path = header.relative_to(ROOT / "include")
            parts.append(f"## {path}\n\n```{{doxygenfile}} {path}\n:project: sqmap\n```\n")
        (folder / f"cpp_{group.name}.md").write_text("\n".join(parts))
    listed = "\n".join(names)
    (folder / "cpp.md").write_text(f"# C++\n\nOne page for each folder of `include/sqmap`.\n\n```{{toctree}}\n:maxdepth: 2\n\n{listed}\n```\n")
    (folder / "c.md").write_text(c_page((ROOT / "include/sqmap.h").read_text()))
    (folder / "javascript.md").write_text("# JavaScript\n\n```{literalinclude} index.d.ts\n:language: typescript\n```\n")
    shutil.copy(ROOT / "js/index.d.ts", folder)
    (folder / "python.md").write_text("# Python\n\n```{eval-rst}\n.. automodule:: sqmap\n   :members:\n   :imported-members:\n```\n")


def write_notebooks(env):
    """Each notebook executed, as a page with its pictures."""
    names = []
    for notebook in sorted((ROOT / "docs/notebooks").glob("*.ipynb")):
        needed = json.loads(notebook.read_text())["metadata"].get("sqmap", {}).get("needs")
        execute = ["--execute"] if not needed or subprocess.run([PYTHON, "-c", f"import {needed}"], capture_output=True).returncode == 0 else []
        run(PYTHON, "-m", "nbconvert", "--to", "markdown", *execute, "--output-dir", SOURCE / "notebooks", notebook, env=env)
        page = SOURCE / "notebooks" / f"{notebook.stem}.md"
        page.write_text(re.sub(r"!\[png\]", "![what the cell draws]", page.read_text()))
        names.append(f"notebooks/{notebook.stem}")
    return names


def pages_of(pattern, but=()):
    return [str(p.relative_to(SOURCE).with_suffix("")) for p in sorted(SOURCE.glob(pattern)) if p.stem not in but]


def main():
    modules = subprocess.run([PYTHON, "-c", "import sphinx, breathe, furo, myst_parser"], capture_output=True, check=False)
    if modules.returncode != 0 or shutil.which("doxygen") is None:
        print("skipped: doxygen python3-sphinx furo python3-myst-parser python3-breathe are not all here")
        sys.exit(77)
    if not (ROOT / "build/release/src/capi/libsqmap.so").exists():
        sys.exit("first ./dev build")
    env = {**os.environ, "PYTHONPATH": str(ROOT / "python"), "SQMAP_LIBRARY": str(ROOT / "build/release/src/capi/libsqmap.so"),
           "SQMAP_PROGRAM": str(ROOT / "build/release/bin/sqmap")}
    shutil.rmtree(SOURCE, ignore_errors=True)
    SOURCE.mkdir(parents=True)
    copy_pages()
    write_cpp_reference()
    notebooks = [] if "--without-notebooks" in sys.argv else write_notebooks(env)
    (BUILD / "Doxyfile").write_text(DOXYFILE.format(include=ROOT / "include", out=BUILD))
    run("doxygen", BUILD / "Doxyfile", cwd=ROOT / "include")
    for xml in (BUILD / "xml").glob("*.xml"):  # doxygen takes a digit separator for a character
        xml.write_text(re.sub(r"(\d) &apos;(\d)|(\d) '(\d)", r"\1\3\2\4", xml.read_text()))
    guides = pages_of("docs/guide/*.md", ("python", "c", "javascript", "anywhere", "view", "pictures", "dress", "paper"))
    measured = ("measurements", "bench", "bench-methods", "haptics-figures", "reproduction")
    (SOURCE / "index.md").write_text(INDEX.format(
        guides="\n".join(guides), notebooks="\n".join(notebooks),
        reference="\n".join(pages_of("docs/*.md", ("architecture", "examples", *measured))),
        algorithms="\n".join(pages_of("docs/algorithms/*.md")),
        measurements="\n".join(f"docs/{m}" for m in measured)))
    (SOURCE / "conf.py").write_text(CONF.replace('"XML"', repr(str(BUILD / "xml"))))
    warnings = BUILD / "warnings.txt"
    run(PYTHON, "-m", "sphinx", "-q", "-w", warnings, "-b", "html", SOURCE, BUILD / "site", env=env)
    # Breathe names a namespace once for every header of it, and Sphinx reports each; Sphinx shows a lambda as plain text.
    wrong = [line for line in warnings.read_text().splitlines()
             if re.search("WARNING|ERROR|CRITICAL", line)
             and not ("/reference/cpp_" in line and re.search("uplicate|Using fallback parser", line))]
    if wrong:
        sys.exit("\n".join(wrong))
    if (anywhere.PAGE / "program.wasm").exists():
        shutil.copytree(anywhere.PAGE, BUILD / "site/live", dirs_exist_ok=True)
    else:
        print("without live models: ./dev anywhere page builds them")
    print(f"{len(list((BUILD / 'site').rglob('*.html')))} pages: {BUILD / 'site/index.html'}")


if __name__ == "__main__":
    main()
