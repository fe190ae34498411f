#!/usr/bin/env python3
"""check_comments.py finds public names without a documentation comment."""
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
    ("variables and types", header("/// A.\nusing A = int (*)(int);\n/// B.\nstruct B {\n    int a = f(1), b{2}, c[2]{int(1), int(2)};\n};\ninline constexpr int k_a = f(2);  ///< a\n"), None),
    ("a struct", header("struct A {\n    int a;  ///< a member's\n};\n"), "A has no"),
    ("a class template", header("template <class T>\nclass A {};\n"), "A has no"),
    ("a struct after another", header("/// A.\nstruct A {};\nstruct B {};\n"), "B has no"),
    ("a nested struct", header("/// A.\nstruct A {\n    struct B {};\n};\n"), "A::B has no"),
    ("an enumeration", header("enum class A { B };\n"), "A has no"),
    ("an alias", header("using A = int;\n"), "A has no"),
    ("a template alias", header("template <class T>\nusing A = B<T>;\n"), "A has no"),
    ("a constant", header("inline constexpr int k_a = 1;\n"), "k_a has no"),
    ("a constant in braces", header("inline constexpr B k_a[]{{1}};\n"), "k_a has no"),
    ("aliases share one", header("/// A.\nusing A = int;\nusing B = int;\n"), None),
    ("a private type", header("/// A class.\nclass A {\n    struct B {};\n    static constexpr int k_b = 1;\n};\n"), None),
    ("declared ahead", header("struct A;\nusing B::C;\n"), None),
]
checked.run("check_comments.py", CASES)
