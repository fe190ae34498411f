"""Pictures as arrays, drawn by the program."""
from __future__ import annotations

import pathlib
import struct
import subprocess
import tempfile
import zlib
from typing import Any, Callable, Sequence

import numpy as np

from ._arrays import count, refuse
from ._errors import Error, FileError, InternalError
from ._program import program


def render(save: Callable[[pathlib.Path], None], what: str, size: Sequence[int], options: Sequence[tuple[str, Any]]) -> np.ndarray:
    """Runs `sqmap render` on the model file that save writes to a path. (height, width, 3) uint8."""
    if not isinstance(what, str):
        raise refuse("what", f"is {what!r}", "give the name of a picture")
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise refuse("size", f"is {size!r}", "give (width, height)")
    width, height = (count(n, "size") for n in size)
    with tempfile.TemporaryDirectory(prefix="sqmap-") as folder:
        source, target = pathlib.Path(folder, "model.sqmap"), pathlib.Path(folder, "picture.png")
        save(source)
        command = [program(), "render", str(source), "-o", str(target), "--what", what, "--size", f"{width}x{height}"]
        command += [option if value is True else f"{option}={value}" for option, value in options if value is not None]
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        except OSError as e:
            raise FileError("E_FILE", command[0], f"cannot be run: {e.strerror}", "name the program in SQMAP_PROGRAM") from None
        if done.returncode != 0:
            kind = InternalError if done.returncode == 70 else Error
            raise kind("E_RENDER", what, done.stderr.strip().replace(str(source), "the model"), "see `python -m sqmap render --help`")
        return decode_png(target.read_bytes())


def decode_png(data: bytes) -> np.ndarray:
    """(height, width, channels) uint8 of a PNG of 8 bits a channel that is not interlaced, as the program writes it."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise InternalError("E_RENDER", "picture", "is no PNG", "report it")
    width, height, depth, colours, _, _, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    channels = {0: 1, 2: 3, 6: 4}.get(colours)
    if depth != 8 or channels is None or interlaced:
        raise InternalError("E_RENDER", "picture", "is a PNG of another kind", "report it")
    packed, at = b"", 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += length + 12
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * channels)
    out = np.zeros((height + 1, width + 1, channels), np.uint8)  # a row and a column of zeros in front
    for y in range(height):
        _unfilter(int(lines[y, 0]), lines[y, 1:].reshape(width, channels), out, y + 1)
    return np.ascontiguousarray(out[1:, 1:])


def _unfilter(kind: int, line: np.ndarray, out: np.ndarray, y: int) -> None:
    """One line: filters 0 to 4 of the PNG specification."""
    row, above = out[y], out[y - 1]
    if kind == 0:
        row[1:] = line
    elif kind == 1:
        row[1:] = np.cumsum(line, axis=0, dtype=np.uint8)
    elif kind == 2:
        row[1:] = line + above[1:]
    elif kind in (3, 4):
        left, up, corner = row.astype(int), above.astype(int), above.astype(int)
        for x in range(1, len(row)):
            a, b, c = left[x - 1], up[x], corner[x - 1]
            if kind == 3:
                predicted = (a + b) // 2
            else:
                p = a + b - c
                pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
                predicted = np.where((pa <= pb) & (pa <= pc), a, np.where(pb <= pc, b, c))
            left[x] = (line[x - 1] + predicted) & 255
        row[:] = left
    else:
        raise InternalError("E_RENDER", "picture", f"has a line of filter {kind}", "report it")
