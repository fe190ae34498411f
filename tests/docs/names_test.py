"""Public names of C and JavaScript have a word of what they are, and the pages show the examples."""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import docs_site  # noqa: E402

HEADER = ("// -------------------------- points\n\n/// A point.\ntypedef struct sqmap_point {\n    double x;\n} sqmap_point;\n"
          "/// Bits.\nenum sqmap_bits {\n    SQMAP_A = 1\n};\n/// Calls back.\ntypedef int32_t (*sqmap_call)(void* context);\n"
          "/// Moves.\nSQMAP_API sqmap_code sqmap_move(const char* path,\n                                sqmap_point* point);\n")
TYPES = ("/** A model. */\nexport class Model {\n  readonly facts: number;\n  /** Queries. */\n  query(): void;\n"
         "  close(): void;  // frees it\n}\n/** Loads. */\nexport function load(): Model;\n")
MODULE = ("class Owned {\n  close() {\n  }\n}\nexport class Model extends Owned {\n  constructor(a) {\n  }\n  get facts() {\n  }\n"
          "  query() {\n  }\n  #own() {\n  }\n}\nexport async function load() {\n}\n")


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
    """Exports of index.js, with methods and getters of the classes among them and of Sqmap, which load gives."""
    scope = ""
    for line in text.split("\n"):
        if begins := re.match(r"(export )?(?:async )?(class|function|const) (\w+)", line):
            scope = begins[3] if begins[2] == "class" and (begins[1] or begins[3] == "Sqmap") else ""
            if begins[1]:
                yield begins[3]
        elif scope and (method := re.match(r"  (?:get )?([a-z]\w*)\(.*\{$", line)) and method[1] != "constructor":
            yield f"{scope}.{method[1]}"


def wordless(header, types):
    return ([name for *_, name, documented in docs_site.c_names(header) if not documented]
            + [name for name, documented in javascript_names(types) if not documented])


def undeclared(module, types):
    """Exports of the module that its types lack."""
    return [name for name in javascript_exports(module) if not re.search(rf"\b{name.split('.')[-1]}\b", types)]


class Names(unittest.TestCase):
    def test_a_name_without_a_word_is_found(self):
        self.assertEqual(wordless(HEADER, TYPES), [])
        for comment, name in (("/// A point.\n", "sqmap_point"), ("/// Bits.\n", "sqmap_bits"), ("/// Calls back.\n", "sqmap_call"),
                              ("/// Moves.\n", "sqmap_move")):
            self.assertEqual(wordless(HEADER.replace(comment, ""), TYPES), [name])
        for comment, name in (("/** A model. */\n", "Model"), ("  /** Queries. */\n", "Model.query"), ("  // frees it", "Model.close"),
                              ("/** Loads. */\n", "load")):
            self.assertEqual(wordless(HEADER, TYPES.replace(comment, "")), [name])

    def test_an_export_that_is_not_declared_is_found(self):
        self.assertEqual(undeclared(MODULE, TYPES), [])
        self.assertEqual(undeclared(MODULE.replace("  query() {", "  render() {"), TYPES), ["Model.render"])

    def test_each_name_of_c_and_javascript_has_a_word(self):
        header, types = (ROOT / "include/sqmap.h").read_text(), (ROOT / "js/index.d.ts").read_text()
        self.assertGreater(min(len(list(docs_site.c_names(header))), len(list(javascript_names(types)))), 30)
        self.assertEqual(wordless(header, types), [])
        self.assertEqual(undeclared((ROOT / "js/index.js").read_text(), types), [])

    def test_each_example_is_on_its_page(self):
        page = (ROOT / "docs/examples.md").read_text()
        examples = [*(ROOT / "examples").glob("*.cpp"), *(ROOT / "examples").glob("*.c")]
        self.assertGreater(len(examples), 10)
        self.assertEqual([e.name for e in examples if f"<!-- include examples/{e.name} -->" not in page], [])

    def test_the_code_of_the_readme_stands_in_an_example(self):
        readme = (ROOT / "README.md").read_text()
        for language, example in (("cpp", "01_bake.cpp"), ("python", "01_bake.py")):
            (block,) = re.findall(rf"^```{language}\n(.*?)^```", readme, re.MULTILINE | re.DOTALL)
            lines = iter([line.strip() for line in (ROOT / "examples" / example).read_text().splitlines()])
            self.assertEqual([line for line in block.splitlines() if line not in lines], [], example)  # in this order

    def test_the_page_of_c_has_the_sections_of_the_header(self):
        page = docs_site.c_page("// sqmap from C.\n// Units: metres.\n#pragma once\n" + HEADER)
        for text in ("sqmap from C.", "**Units:** metres.", "## Points", "```{doxygenstruct} sqmap_point", "```{doxygenenum} sqmap_bits",
                     "```{doxygentypedef} sqmap_call", "```{doxygenfunction} sqmap_move"):
            self.assertIn(text, page)


if __name__ == "__main__":
    unittest.main()
