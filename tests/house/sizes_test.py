#!/usr/bin/env python3
"""check_sizes.py counts classes, functions, files and parameters as a reader does."""
import checked

BODY = "".join(f"    i += {k};\n" for k in range(78))  # with the signature and two braces: 81 lines
LONG = "int f(int i)\n{\n" + BODY + "}\n"
CASES = [
    ("a function of 81 lines", {"src/a.cpp": LONG}, "function f has 81 lines"),
    ("of 80 lines", {"src/a.cpp": LONG.replace("    i += 3;\n", "")}, None),
    ("in a namespace and a class", {"src/a.cpp": "namespace a {\nclass B {\n" + LONG + "};\n}\n"}, "function B::f has 81 lines"),
    ("a template with a constraint", {"src/a.cpp": "template <class T>\n    requires(sizeof(T) > 2)\nT " + LONG[4:]}, "function f has 83 lines"),
    ("an operator", {"src/a.cpp": LONG.replace("int f(int i)", "int B::operator()(int i) const")}, "operator_call has 81"),
    ("a constructor with initialisers", {"src/a.cpp": LONG.replace("int f(int i)", "B::B(int i) : a_(i), b_{i}")}, "81 lines"),
    ("lines of a string are no braces", {"src/a.cpp": 'const char* a = "{";\n' + LONG.replace("    i += 3;\n", "")}, None),
    ("two functions of 79 lines are two", {"src/a.cpp": (LONG.replace("    i += 3;\n", "") + "\n") * 2}, None),
    ("a class of 401 lines", {"src/a.cpp": "class A {\n" + "    int a;\n" * 399 + "};\n"}, "class A has 401 lines"),
    ("a file of 601 lines", {"include/sqmap/a.h": "//\n" * 601}, "a file of 601 lines"),
    ("five parameters in public", {"include/sqmap/a.h": "int f(int a, std::map<int, int> b, int c = g(1, 2), int d = {}, int e = 5);\n"},
     "f has 5 parameters"),
    ("four, one of them a function", {"include/sqmap/a.h": "int f(int a, int (*b)(int, int), std::array<int, 3> c, int d);\n"}, None),
    ("five in a private part", {"include/sqmap/a.h": "class A {\n    int f(int, int, int, int, int);\n};\n"}, None),
    ("an exception of that size", {"src/a.cpp": LONG, "scripts/house_exceptions.txt": "sizes: src/a.cpp function f = 81\n"}, None),
    ("an exception that has grown", {"src/a.cpp": LONG, "scripts/house_exceptions.txt": "sizes: src/a.cpp function f = 80\n"}, "81 lines"),
]
checked.run("check_sizes.py", CASES)
