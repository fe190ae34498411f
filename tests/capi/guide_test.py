"""Compiles and runs the C of the guide: each block in a function of its own, and what the text behind it shows is what it prints.

usage: guide_test.py GUIDE CC INCLUDE_DIR LIBRARY"""
import pathlib
import re
import subprocess
import sys
import tempfile

guide, cc, include, library = sys.argv[1:5]
blocks = re.findall(r"^```c\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", pathlib.Path(guide).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
assert len(blocks) >= 2 and any(text for _, text in blocks), blocks
for code, text in blocks:
    with tempfile.TemporaryDirectory() as folder:
        source, program = pathlib.Path(folder, "block.c"), pathlib.Path(folder, "block")
        source.write_text('#include "sqmap.h"\n#include <stdio.h>\n'
                          "static int block(const char* path, sqmap_model model)\n{\n    (void)path;\n    (void)model;\n" + code +
                          "    return 0;\n}\nint main(void)\n{\n    const sqmap_model none = {0};\n    return block(\"ring.sqmap\", none) & 2;\n}\n")
        lib = pathlib.Path(library).absolute()
        subprocess.run([cc, "-std=c11", "-Wno-unused-variable", "-I", include, source, lib, f"-Wl,-rpath,{lib.parent}", "-o", program], check=True)
        run = subprocess.run([program], cwd=folder, capture_output=True, text=True, check=True)
        assert run.stdout + run.stderr == text, f"the guide shows\n{text}and the program prints\n{run.stdout}{run.stderr}"
print(f"{len(blocks)} blocks")
