"""scripts/docs_names.py finds public names that the site lacks or that nothing is said of."""
import pathlib
import re
import sys
import tempfile
import unittest
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import docs_names  # noqa: E402

FILES = {
    "include/sqmap.h": "// -------------------------- points\n\n/// A point.\ntypedef struct sqmap_point {\n    double x;\n} sqmap_point;\n"
                       "/// Bits.\nenum sqmap_bits {\n    SQMAP_A = 1\n};\n/// Calls back.\ntypedef int32_t (*sqmap_call)(void* context);\n"
                       "/// Moves.\nSQMAP_API sqmap_code sqmap_move(const char* path,\n                                sqmap_point* point);\n",
    "js/index.d.ts": "/** A model. */\nexport class Model {\n  readonly facts: number;\n  /** Queries. */\n  query(): void;\n"
                     "  close(): void;  // frees it\n}\n/** Loads. */\nexport function load(): Model;\n",
    "js/index.js": "class Owned {\n  close() {\n  }\n}\nexport class Model extends Owned {\n  constructor(a) {\n  }\n  get facts() {\n  }\n"
                   "  query() {\n  }\n  #own() {\n  }\n}\nexport async function load() {\n}\n",
}
THERE = ["sqmap_point", "sqmap_bits", "sqmap_call", "sqmap_move", "sqmap.Model"]
LISTING = "<pre><span>class Model</span> { facts; query(); close(); } function load()</pre>"


class Names(unittest.TestCase):
    def missing(self, files=(), there=THERE, listing=LISTING, python_names=("sqmap.Model",)):
        with tempfile.TemporaryDirectory() as folder:
            root, site = pathlib.Path(folder), pathlib.Path(folder, "site")
            for name, text in {**FILES, **dict(files), "site/reference/javascript.html": listing}.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            lines = "".join(f"{name} cpp:any 1 page.html#$ -\n" for name in there).encode()
            (site / "objects.inv").write_bytes(b"# Sphinx inventory version 2\n# a\n# 1\n# zlib\n" + zlib.compress(lines))
            return list(docs_names.missing(root, site, python_names))

    def changed(self, file, old, new):
        self.assertIn(old, FILES[file])
        return self.missing({file: FILES[file].replace(old, new)})

    def test_nothing_is_missing(self):
        self.assertEqual(self.missing(), [])

    def test_each_name_is_looked_for(self):
        for name in THERE:
            found = self.missing(there=[t for t in THERE if t != name])
            self.assertEqual([line.split(" ")[1] for line in found], [name], name)
        self.assertEqual(self.missing(listing=LISTING.replace("query()", "")), ["JavaScript: Model.query is not on the site"])

    def test_each_name_needs_a_word(self):
        self.assertEqual(self.missing(python_names=["sqmap.Model?"]), ["Python: nothing is said of sqmap.Model"])
        header, types = "include/sqmap.h", "js/index.d.ts"
        for comment, name in (("A point.", "sqmap_point"), ("Bits.", "sqmap_bits"), ("Calls back.", "sqmap_call"), ("Moves.", "sqmap_move")):
            self.assertEqual(self.changed(header, f"/// {comment}\n", ""), [f"C: nothing is said of {name}"])
        for comment, name in (("/** A model. */\n", "Model"), ("  /** Queries. */\n", "Model.query"), ("  // frees it", "Model.close"),
                              ("/** Loads. */\n", "load")):
            self.assertEqual(self.changed(types, comment, ""), [f"JavaScript: nothing is said of {name}"])

    def test_each_name_of_c_and_javascript_has_a_word(self):
        header = list(docs_names.c_names((ROOT / "include/sqmap.h").read_text()))
        types = list(docs_names.javascript_names((ROOT / "js/index.d.ts").read_text()))
        self.assertGreater(min(len(header), len(types)), 30)
        self.assertEqual([name for *_, name, documented in header if not documented] + [name for name, documented in types if not documented], [])

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

    def test_what_the_package_exports_is_declared(self):
        self.assertEqual(self.changed("js/index.js", "  query() {", "  render() {"), ["JavaScript: Model.render is not on the site"])

    def test_the_page_of_c_has_the_sections_of_the_header(self):
        page = docs_names.c_page("// sqmap from C.\n// Units: metres.\n#pragma once\n" + FILES["include/sqmap.h"])
        for text in ("sqmap from C.", "**Units:** metres.", "## Points", "```{doxygenstruct} sqmap_point", "```{doxygenenum} sqmap_bits",
                     "```{doxygentypedef} sqmap_call", "```{doxygenfunction} sqmap_move"):
            self.assertIn(text, page)


if __name__ == "__main__":
    unittest.main()
