#!/usr/bin/env python3
"""check_comments.py finds public functions without a documentation comment."""
import checked


def header(text):
    return {"include/sqmap/a.h": "// Any thread.\n#pragma once\n\nnamespace sqmap {\n\n" + text + "\n}  // namespace sqmap\n"}


CASES = [
    ("none", header("int f(int a);\n"), "f has no documentation comment"),
    ("a plain comment is none", header("// What it does.\nint f(int a);\n"), "f has no"),
    ("one above", header("/// What it does.\n[[nodiscard]] int f(int a);\n"), None),
    ("one behind", header("int f(int a);  ///< what it does\n"), None),
    ("above a template", header("/// What it does.\ntemplate <class T>\nT f(T a)\n{\n    return a;\n}\n"), None),
    ("a method", header("/// A class.\nclass A {\npublic:\n    int f() const;\n};\n"), "A::f has no"),
    ("a private method", header("/// A class.\nclass A {\n    int f() const;\n};\n"), None),
    ("a method of a struct", header("/// A struct.\nstruct A {\n    int f() const { return 1; }\n};\n"), "A::f has no"),
    ("special members", header("/// A class.\nclass A {\npublic:\n    A();\n    ~A();\n    A(const A&) = delete;\n    A& operator=(A&&) noexcept;\n};\n"), None),
    ("a constructor with arguments", header("/// A class.\nclass A {\npublic:\n    explicit A(int n);\n};\n"), "A::A has no"),
    ("overloads share one", header("/// What it does.\nint f(int a);\nint f(double a);\n"), None),
    ("another function does not", header("/// What it does.\nint f(int a);\nint g(int a);\n"), "g has no"),
    ("an empty line ends the paragraph", header("/// What it does.\nint f(int a);\n\nint f(double a);\n"), "f has no"),
    ("an override has its base's", header("/// A class.\nstruct A : B {\n    int f() override;\n};\n"), None),
    ("a detail", header("namespace detail {\nint f(int a);\n}\n"), None),
    ("no word of threads", {"include/sqmap/a.h": "// What it holds.\n#pragma once\n"}, "says nothing of threads"),
    ("variables and types", header("using A = int (*)(int);\nstruct B {\n    int a = f(1), b{2}, c[2]{int(1), int(2)};\n};\ninline constexpr int k_a = f(2);\n"), None),
]
checked.run("check_comments.py", CASES)
