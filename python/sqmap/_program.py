"""The program `sqmap` that comes with the package."""
from __future__ import annotations

import os
import pathlib
import shutil

from ._errors import FileError


def program() -> str:
    """Path of the program: SQMAP_PROGRAM, the package's own, or the one on PATH. Raises FileError."""
    own = pathlib.Path(__file__).resolve().parent / "_bin" / "sqmap"
    named = os.environ.get("SQMAP_PROGRAM")
    found = named or (str(own) if own.exists() else shutil.which("sqmap"))
    if found is None:
        raise FileError("E_FILE", "sqmap", "the program is not in this package, and not on PATH",
                        "install the package with the program, or name it in SQMAP_PROGRAM")
    return found
