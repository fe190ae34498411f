"""Files of a model's triangles, a group for each part."""
from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from ._arrays import refuse
from ._errors import FileError
from ._glb import FLOAT, INDICES, UNSIGNED_INT, VERTICES, Glb

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
    """One node moves to the object's centre, from which floats count; below it a node for each part."""
    (vertices, triangles), parts, centre = model.mesh, model.part_of_triangle, model.facts.centre
    positions = (vertices - centre).astype("<f4")
    numbers = np.unique(parts).tolist()
    glb = Glb()
    points = glb.add(positions.tobytes(), len(positions), "VEC3", FLOAT, bounds=(positions.min(0).tolist(), positions.max(0).tolist()),
                     target=VERTICES)
    meshes = []
    for part in numbers:
        corners = np.ascontiguousarray(triangles[parts == part], "<u4")
        indices = glb.add(corners.tobytes(), corners.size, "SCALAR", UNSIGNED_INT, target=INDICES)
        meshes.append({"name": f"part_{part}", "primitives": [{"attributes": {"POSITION": points}, "indices": indices}]})
    nodes = [{"name": "model", "translation": centre.tolist(), "children": list(range(1, len(numbers) + 1))},
             *({"name": f"part_{part}", "mesh": k} for k, part in enumerate(numbers))]
    return glb.file("sqmap", {"scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes, "meshes": meshes})


_BYTES = {".obj": _obj, ".glb": _glb, ".json": _json}
