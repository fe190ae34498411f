"""The structs, handles and functions of the package are those of include/sqmap.h, and npm's structs begin as they do; the library
exports exactly those functions, and each public name of the package has a docstring, which the documentation shows.

usage: header_test.py HEADER LIBRARY NM"""
import ctypes
import inspect
import pathlib
import re
import subprocess
import sys
import unittest

import sqmap
from sqmap import _library as c

HEADER, LIBRARY, NM = sys.argv[1:4]
del sys.argv[1:]
with open(HEADER, encoding="utf-8") as file:
    TEXT = re.sub(r"//[^\n]*", "", file.read())
SCRIPT = pathlib.Path(HEADER).resolve().parents[1].joinpath("js", "structs.js").read_text(encoding="utf-8")
C_TYPES = {"double": ctypes.c_double, "float": ctypes.c_float, "size_t": ctypes.c_size_t, "int16_t": ctypes.c_int16,
           "int32_t": ctypes.c_int32, "uint8_t": ctypes.c_uint8, "uint32_t": ctypes.c_uint32, "uint64_t": ctypes.c_uint64}
HANDLES = ("sqmap_model", "sqmap_probe", "sqmap_workspace", "sqmap_session", "sqmap_pad", "sqmap_pile")
NAMES = {"sqmap_error": "ErrorStruct"}


def class_of(struct):
    return getattr(c, NAMES.get(struct, "".join(word.title() for word in struct.split("_")[1:])))


def members(body):
    """[(name, C type)] of a struct's body."""
    out = []
    for line in filter(None, (part.strip() for part in body.split(";"))):
        kind, names = re.fullmatch(r"((?:const )?\w+)\s*(.*)", line, re.DOTALL).groups()
        for name in names.split(","):
            stars, plain, length = re.fullmatch(r"\s*(\**)\s*(\w+)\s*(?:\[(\d+)\])?", name).groups()
            if stars:
                expected = "pointer"
            elif kind in HANDLES:
                expected = c.Handle
            elif kind in C_TYPES:
                expected = C_TYPES[kind]
            else:
                expected = "pointer" if kind == "sqmap_progress" else class_of(kind)
            out.append((plain, expected * int(length) if length else expected))
    return out


class Header(unittest.TestCase):
    def test_structs_have_the_members_of_the_header(self):
        structs = re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", TEXT, re.DOTALL)
        self.assertGreater(len(structs), 20)
        for name, body in structs:
            if name in HANDLES:
                self.assertEqual(members(body), [("id", ctypes.c_uint64)])
                continue
            own = class_of(name)._fields_
            self.assertEqual([n for n, _ in own], [n for n, _ in members(body)], name)
            for (member, ours), (_, theirs) in zip(own, members(body)):
                if theirs == "pointer":
                    self.assertEqual(ctypes.sizeof(ours), ctypes.sizeof(ctypes.c_void_p), f"{name}.{member}")
                else:
                    self.assertTrue(ours is theirs or (ours._type_ is theirs._type_ and ours._length_ == theirs._length_),
                                    f"{name}.{member}")

    def test_structs_of_javascript_begin_with_the_members_of_the_header(self):
        """A struct may end earlier than the header's: its size tells the library, and what is left out is zero."""
        layouts = dict(re.findall(r"(\w+): layout\(\s*[\"`](.*?)[\"`]", SCRIPT, re.DOTALL))
        camel = lambda name: re.sub(r"_(\w)", lambda m: m[1].upper(), name)
        bodies = {camel(name.removeprefix("sqmap_")): body for name, body in
                  re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", TEXT, re.DOTALL)}
        width = {"f64": 8, "u64": 8, "f32": 4, "i32": 4, "u32": 4, "i16": 2, "u8": 1}

        def flat(name, kind):
            """A struct within a struct is written out: member a of a pair as modelA, probeA, poseA; a pose as its twelve numbers."""
            if kind is c.Pose:
                return [(camel(name), ctypes.c_double * 12)]
            if kind == "pointer" or kind is c.Handle or not issubclass(kind, ctypes.Structure):
                return [(camel(name), kind)]
            return [(camel(inner) + name.capitalize(), k) for inner, k in kind._fields_]

        for name, text in layouts.items():
            theirs = [both for n, kind in members(bodies[name]) if n != "size" for both in flat(n, kind)]
            self.assertLessEqual(len(text.split()), len(theirs), name)
            for word, (member, kind) in zip(text.split(), theirs):
                ours, type_, count = re.fullmatch(r"(\w+):(\w+)(?:\[(\d+)\])?", word).groups()
                self.assertEqual(ours, member, name)
                if kind != "pointer" and type_ in width:
                    length = getattr(kind, "_length_", None)
                    self.assertEqual(int(count) if count else None, length, f"{name}.{member}")
                    self.assertEqual(width[type_], ctypes.sizeof(kind) // (length or 1), f"{name}.{member}")

    def test_functions_have_the_parameters_of_the_header(self):
        declared = dict(re.findall(r"SQMAP_API sqmap_code (\w+)\(([^)]*)\);", TEXT))
        self.assertEqual(set(declared), set(c.FUNCTIONS))
        for name, parameters in declared.items():
            self.assertEqual(len(parameters.split(",")), len(c.FUNCTIONS[name]), name)

    def test_the_library_exports_what_the_header_declares(self):
        declared = set(re.findall(r"^SQMAP_API [\w *]*?(\w+)\(", TEXT, re.MULTILINE))
        listed = subprocess.run([NM, "-D", "--defined-only", LIBRARY], capture_output=True, text=True, check=True).stdout
        exported = {line.split()[-1].split("@")[0] for line in listed.splitlines()} - {"SQMAP_0"}
        self.assertEqual(exported, declared)

    def test_codes_are_those_of_the_header(self):
        codes = {int(n): name for name, n in re.findall(r"SQMAP_(E_\w+) = (\d+)", TEXT)}
        self.assertEqual(set(codes), set(c.BY_CODE))


class Docstrings(unittest.TestCase):
    def test_every_public_name_has_one(self):
        bare = []
        for name in sqmap.__all__:
            value = getattr(sqmap, name)
            if inspect.isclass(value) or inspect.isfunction(value):
                bare += [] if inspect.getdoc(value) else [name]
            for key, member in vars(value).items() if inspect.isclass(value) else ():
                member = getattr(member, "fget", None) or getattr(member, "__func__", member)
                if not key.startswith("_") and inspect.isfunction(member) and not inspect.getdoc(member):
                    bare.append(f"{name}.{key}")
        self.assertEqual(bare, [])


if __name__ == "__main__":
    unittest.main()
