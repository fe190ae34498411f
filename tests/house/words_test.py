#!/usr/bin/env python3
"""check_words.py finds words of the table in identifiers, and only there."""
import checked

COMMON = {"CONTRIBUTING.md": "## Words\n\n| use | not | identifiers that may stay |\n|---|---|---|\n| workspace | `room` | |\n"
                             "| candidate list | `near_list` | |\n| max | `most` | `at_most`, `left*` |\n\n## Tests\n\n| a | `b` | |\n"}
CASES = [
    ("a word by itself", {"src/a.cpp": "int room;\n"}, "src/a.cpp:1: room: say workspace"),
    ("in capitals", {"src/a.h": "struct ProbeRoom {};\n"}, "ProbeRoom"),
    ("between underscores", {"tests/a.cpp": "int a = k_most_zones;\n"}, "say max"),
    ("two words in a row", {"src/a.cpp": "auto x = make_near_list();\n"}, "make_near_list: say candidate list"),
    ("two words apart", {"src/a.cpp": "int near_the_list;\n"}, None),
    ("part of a longer word", {"src/a.cpp": "int mushroom, almost, rooms_;\n"}, None),
    ("comments and strings", {"src/a.cpp": '// a room\nconst char* a = "room";\n#include "room.h"\n'}, None),
    ("the name of a test", {"tests/a.cpp": "TEST(Ball, HasMostRoom)\n{\n}\n"}, None),
    ("an identifier that may stay", {"src/a.cpp": "int at_most, left_most;\n"}, None),
    ("words of another table", {"src/a.cpp": "int b;\n"}, None),
    ("no table", {"CONTRIBUTING.md": "nothing\n"}, "no table"),
]
checked.run("check_words.py", CASES, COMMON)
