#!/usr/bin/env python3
"""The layer check must find what it is there for: a wrong include in each form, an unknown folder, and no false alarm."""
import pathlib
import subprocess
import sys
import tempfile

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "check_layers.py"

CASES = [  # path of a file, its text, whether it breaks the order
    ("src/query/a.cpp", '#include "sqmap/model/m.h"\n#include <vector>\n', False),
    ("src/query/a.cpp", '#include "sqmap/mesh/mesh.h"\n', True),
    ("src/query/a.cpp", "#include <sqmap/bake/bake.h>\n", True),
    ("src/query/a.cpp", '  #  include "io/bytes.h"\n', True),
    ("src/mesh/a.cpp", '#include "../io/soup.h"\n', True),
    ("include/sqmap/math/a.h", '#include "sqmap/shape/superquadric.h"\n', True),
    ("include/sqmap/math/a.h", '// #include "sqmap/shape/superquadric.h"\n', False),
    ("src/bake/a.cpp", '#include "sqmap/fit/fit.h"\n#include "sqmap/query/query.h"\n', False),
    ("src/elsewhere/a.cpp", "", True),
]

failed = 0
for path, text, is_bad in CASES:
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name in (path, "src/io/soup.h", "include/sqmap/io/soup.h"):
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text if name == path else "")
        found = subprocess.run([sys.executable, SCRIPT, root], capture_output=True, text=True)
        if (found.returncode == 1) != is_bad:
            failed += 1
            print(f"{path}: {text!r}: expected {'a complaint' if is_bad else 'none'}, got: {found.stdout}{found.stderr}")
print(f"{len(CASES) - failed} passed, {failed} failed")
sys.exit(1 if failed else 0)
