"""glTF 2.0 in one file: arrays in one buffer, which follows the JSON (sections 3 and 4 of the specification). It needs the standard
library alone: scripts take it without the package."""
import json
import struct
from typing import Any, Optional

FLOAT, UNSIGNED_BYTE, UNSIGNED_INT = 5126, 5121, 5125  # types of components
VERTICES, INDICES = 34962, 34963  # targets of views


class Glb:
    """The arrays of a file."""

    def __init__(self) -> None:
        self._binary = bytearray()
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []

    def add(self, data: bytes, count: int, kind: str, component: int, *, bounds: Optional[tuple[list[float], list[float]]] = None,
            target: Optional[int] = None) -> int:
        """The number of a new accessor. kind: "VEC3"; bounds: least and greatest values, which positions and times need."""
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(data)}
        self._views.append(view if target is None else view | {"target": target})
        self._binary += data + b"\0" * (-len(data) % 4)
        accessor = {"bufferView": len(self._views) - 1, "componentType": component, "count": count, "type": kind}
        self._accessors.append(accessor if bounds is None else accessor | {"min": bounds[0], "max": bounds[1]})
        return len(self._accessors) - 1

    def file(self, generator: str, document: dict[str, Any]) -> bytes:
        """The whole file. document: all but the asset, buffers, views and accessors."""
        text = json.dumps({"asset": {"version": "2.0", "generator": generator}, **document, "accessors": self._accessors,
                           "bufferViews": self._views, "buffers": [{"byteLength": len(self._binary)}]}).encode()
        text += b" " * (-len(text) % 4)
        return b"".join([struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self._binary)), struct.pack("<I4s", len(text), b"JSON"),
                         text, struct.pack("<I4s", len(self._binary), b"BIN\0"), self._binary])
