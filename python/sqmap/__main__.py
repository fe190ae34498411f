"""`python -m sqmap` is the program: its arguments, its output, its exit code."""
from __future__ import annotations

import os
import sys

from ._errors import FileError
from ._program import program


def main() -> int:
    try:
        path = program()
    except FileError as e:
        print(e, file=sys.stderr)
        return 70
    os.execv(path, ["sqmap", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
