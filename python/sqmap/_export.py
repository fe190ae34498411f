"""Files of a model's triangles, a group for each part."""
from __future__ import annotations

import json
import os
import struct
from typing import Any

import numpy as np

from ._arrays import refuse
from ._errors import FileError

Model = Any  # sqmap.Model, whose module imports this one


def export(model: Model, path: str) -> None:
    """Writes the kind of file that the name's ending says."""
    kind = os.path.splitext(path)[1]
    if kind not in _BYTES:
        raise refuse("path", f"ends in {kind!r}", f"take one of {', '.join(_BYTES)}")
    _replace(path, _BYTES[kind](model))


def _replace(path: str, data: bytes) -> None:
    """Writes a file beside the one of that name and puts it there when it is whole."""
    own = f"{path}.{os.getpid()}.tmp"
    try:
        try:
            with open(own, "xb") as out:
                out.write(data)
            os.replace(own, path)
        except BaseException:
            if os.path.exists(own):
                os.unlink(own)
            raise
    except OSError as e:
        raise FileError("E_FILE", path, f"cannot be written: {e.strerror}",
                        "look at the folder, its rights and the space that is left") from None


def _json(model: Model) -> bytes:
    return (json.dumps(model.info, indent=2) + "\n").encode()


def _obj(model: Model) -> bytes:
    (vertices, triangles), parts = model.mesh, model.part_of_triangle
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    for part in np.unique(parts).tolist():
        lines.append(f"g part_{part}")
        lines += [f"f {i} {j} {k}" for i, j, k in (triangles[parts == part].astype(np.int64) + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


def _glb(model: Model) -> bytes:
    """glTF 2.0, sections 3 and 4: one node moves to the object's centre, from which floats count; below it a node for each part."""
    (vertices, triangles), parts, centre = model.mesh, model.part_of_triangle, model.facts.centre
    positions = (vertices - centre).astype("<f4")
    numbers = np.unique(parts).tolist()
    indices = [np.ascontiguousarray(triangles[parts == part], "<u4") for part in numbers]
    counts = [array.size for array in indices]
    first = positions.nbytes + 4 * np.concatenate([[0], np.cumsum(counts)])
    gltf = {
        "asset": {"version": "2.0", "generator": "sqmap"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "model", "translation": centre.tolist(), "children": list(range(1, len(numbers) + 1))},
                  *({"name": f"part_{part}", "mesh": k} for k, part in enumerate(numbers))],
        "meshes": [{"name": f"part_{part}", "primitives": [{"attributes": {"POSITION": 0}, "indices": k + 1}]}
                   for k, part in enumerate(numbers)],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
                       "min": positions.min(0).tolist(), "max": positions.max(0).tolist()},
                      *({"bufferView": k + 1, "componentType": 5125, "count": n, "type": "SCALAR"} for k, n in enumerate(counts))],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": positions.nbytes, "target": 34962},
                        *({"buffer": 0, "byteOffset": int(first[k]), "byteLength": 4 * n, "target": 34963}
                          for k, n in enumerate(counts))],
        "buffers": [{"byteLength": int(first[-1])}],
    }
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join([positions.tobytes(), *(array.tobytes() for array in indices)])
    return b"".join([struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)), struct.pack("<I4s", len(text), b"JSON"), text,
                     struct.pack("<I4s", len(binary), b"BIN\0"), binary])


_BYTES = {".obj": _obj, ".glb": _glb, ".json": _json}
