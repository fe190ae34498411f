"""Checks what comes in as NumPy arrays: shapes, types, poses, meshes."""
from __future__ import annotations

import ctypes
import functools
import math
import os
from typing import Any, Optional, Union

import numpy as np

from . import _library as c
from ._errors import ArgumentError

LAYERS = {1: 1, 2: 2, 3: 3, "1": 1, "2": 2, "3": 3, "exact": 4, "auto": 5, "gate": 6}
Layer = Union[int, str]


def refuse(element: str, message: str, cure: str) -> ArgumentError:
    return ArgumentError("E_ARGUMENT", element, message, cure)


def instance(value: Any, kind: type, element: str) -> Any:
    """The value, which has to be one of a kind."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIO" else "a"
        raise refuse(element, _what(value), f"give {article} {kind.__name__}")
    return value


def _what(value: Any) -> str:
    return "is None" if value is None else f"is a {type(value).__name__}"


def _comes_from(value: Any, package: str) -> bool:
    """True of an object of a package, which need not be installed."""
    return type(value).__module__.partition(".")[0] == package


def is_open3d_tensor(value: Any) -> bool:
    """True of an open3d.core.Tensor."""
    return _comes_from(value, "open3d") and hasattr(value, "numpy")


def array_of(values: Any, element: str) -> np.ndarray:
    """An array of whatever type; the same memory where it is one already, or a tensor of torch or Open3D on the CPU."""
    if values is None:
        raise refuse(element, "is None", "give an array of numbers")
    try:
        if is_open3d_tensor(values):  # its iterator would give tensors of one number each
            return np.asarray(values.cpu().numpy())
        return np.asarray(values)
    except Exception as e:  # what __array__ of a foreign object raises
        cure = f"give {element}.detach().cpu()" if _comes_from(values, "torch") else "give an array of numbers"
        raise refuse(element, f"is no array: {e}", cure) from None


def numbers(values: Any, element: str) -> np.ndarray:
    """A C-contiguous array of doubles; the same memory where it is one already."""
    array = array_of(values, element)
    if array.dtype.kind not in "fiu":
        raise refuse(element, f"has the type {array.dtype}", "give real numbers")
    return np.ascontiguousarray(array, dtype=np.float64)


_DOUBLE = np.dtype(np.float64)


def rows(values: Any, element: str = "points") -> np.ndarray:
    """n x 3 doubles."""
    if type(values) is np.ndarray and values.dtype is _DOUBLE and values.flags.c_contiguous and values.ndim == 2 and values.shape[1] == 3:
        return values  # at once, as a single point's answer takes a few microseconds
    array = numbers(values, element)
    if array.ndim != 2 or array.shape[1] != 3:
        raise refuse(element, f"has the shape {array.shape}", "give n rows of three numbers: (n, 3)")
    return array


def indices(values: Any, element: str = "triangles") -> np.ndarray:
    """m x 3 64-bit integers; which are in range is for the gate to say."""
    array = array_of(values, element)
    if array.dtype.kind not in "iu":
        raise refuse(element, f"has the type {array.dtype}", "give integers")
    if array.ndim != 2 or array.shape[1] != 3:
        raise refuse(element, f"has the shape {array.shape}", "give m rows of three vertex numbers: (m, 3)")
    if array.dtype == np.uint64 and array.size and array.max() > np.iinfo(np.int64).max:
        raise refuse(element, "has a number beyond 63 bits", "give numbers of vertices")
    return np.ascontiguousarray(array, dtype=np.int64)


def _one_mesh(mesh: Any) -> Any:
    """The object that holds triangles: a trimesh Scene gives its instances as one mesh, an Open3D tensor mesh two arrays."""
    try:
        if hasattr(mesh, "geometry") and hasattr(mesh, "dump"):
            return mesh.to_mesh() if hasattr(mesh, "to_mesh") else mesh.dump(concatenate=True)
        if _comes_from(mesh, "open3d") and hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):
            return mesh.vertex["positions"], mesh.triangle["indices"]
    except Exception as e:  # what a foreign object raises: an empty scene, a tensor mesh without triangles
        raise refuse("mesh", f"has no triangles: {e!r}", "give (vertices, triangles), an object with both, or a path") from None
    return mesh


def triangles_of(mesh: Any) -> tuple[np.ndarray, np.ndarray]:
    """(vertices, triangles) of a pair of arrays, or of an object with vertices and faces or triangles: of trimesh, a Scene included,
    and of Open3D, its tensor meshes included."""
    mesh = _one_mesh(mesh)
    if isinstance(mesh, (tuple, list)):
        if len(mesh) != 2:
            raise refuse("mesh", f"has {len(mesh)} members", "give (vertices, triangles), an object with both, or a path")
        return rows(mesh[0], "vertices"), indices(mesh[1])
    vertices = getattr(mesh, "vertices", None)
    faces = getattr(mesh, "faces", None)
    if faces is None:
        faces = getattr(mesh, "triangles", None)
    if vertices is None or faces is None:
        raise refuse("mesh", _what(mesh), "give (vertices, triangles), an object with both, or a path")
    return rows(vertices, "vertices"), indices(faces)


def pose_of(pose: Optional[Any], element: str = "pose") -> Optional[c.Pose]:
    """A 4 x 4 or 3 x 4 matrix [rotation | translation]; None stays None."""
    if pose is None:
        return None
    matrix = numbers(pose, element)
    if matrix.shape not in ((4, 4), (3, 4)):
        raise refuse(element, f"has the shape {matrix.shape}", "give a matrix [rotation | translation], (4, 4) or (3, 4)")
    out = c.Pose()
    fill_pose(out, matrix, element)
    return out


def fill_pose(out: c.Pose, matrix: np.ndarray, element: str, answers_nan: bool = False) -> None:
    """Writes a matrix (4, 4) or (3, 4), whose rotation the library judges. answers_nan: the library answers what is not finite."""
    flat = matrix.ravel().tolist()
    if len(flat) == 16 and flat[12:] != [0, 0, 0, 1] and not (answers_nan and not all(map(math.isfinite, flat[:12]))):
        for k, value in enumerate(flat):
            if not math.isfinite(value):
                raise refuse(f"{element}[{k // 4}, {k % 4}]", "is NaN" if value != value else "is infinite", "give finite numbers")
        raise refuse(element, "has a last row that is not 0 0 0 1", "give a rigid motion")
    out.rotation[:] = flat[0:3] + flat[4:7] + flat[8:11]
    out.translation[:] = flat[3:12:4]


def poses_of(poses: Any, element: str = "poses") -> np.ndarray:
    """(n, 12) doubles as sqmap_pose has them, of matrices (n, 4, 4) or (n, 3, 4). The library answers those that are not finite."""
    matrices = numbers(poses, element)
    if matrices.ndim != 3 or matrices.shape[1:] not in ((4, 4), (3, 4)):
        raise refuse(element, f"has the shape {matrices.shape}", "give n matrices [rotation | translation]: (n, 4, 4) or (n, 3, 4)")
    top = matrices[:, :3]
    if matrices.shape[1] == 4:
        wrong = (matrices[:, 3] != [0, 0, 0, 1]).any(axis=1) & np.isfinite(top).all(axis=(1, 2))
        if wrong.any():
            raise refuse(f"{element}[{int(wrong.argmax())}]", "has a last row that is not 0 0 0 1", "give rigid motions")
    return np.concatenate([top[:, :, :3].reshape(-1, 9), top[:, :, 3]], axis=1)


def pointer(pose: Optional[c.Pose]) -> Any:
    return ctypes.pointer(pose) if pose is not None else None


def number(value: Any, element: str) -> float:
    """A real number; NaN is left for the library to refuse."""
    if isinstance(value, (bool, str, bytes)):
        raise refuse(element, f"is {value!r}", "give a number")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise refuse(element, f"is {value!r}", "give a number") from None


def finite(value: Any, element: str) -> float:
    """A real number that is finite."""
    out = number(value, element)
    if not math.isfinite(out):
        raise refuse(element, f"is {value!r}", "give a finite number")
    return out


def count(value: Any, element: str, most: int = 2**31 - 1) -> int:
    """An integer from 0 on."""
    if isinstance(value, (bool, str, bytes)):
        raise refuse(element, f"is {value!r}", "give an integer")
    try:
        whole = int(value)
    except (TypeError, ValueError, OverflowError):
        raise refuse(element, f"is {value!r}", "give an integer") from None
    if whole != value or not 0 <= whole <= most:
        raise refuse(element, f"is {value!r}", f"give an integer from 0 to {most}")
    return whole


def option(value: Any, name: str, whole: bool = False) -> float:
    """A number among the options of a bake as C takes it: zero, which stands for the default there, is -1. The library judges finite
    numbers above zero, this package those that have to be whole."""
    given = count(value, name) if whole else number(value, name)
    if 0 < given < math.inf and not whole:
        return given
    least, most = c.option_range(name)
    if not least <= given <= most:
        raise refuse(name, "is NaN" if given != given else f"is {given:g}", f"give a number from {least:g} to {most:g}")
    return given if given != 0 else -1


def flag(value: Any, element: str) -> bool:
    """True or False."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise refuse(element, f"is {value!r}", "give True or False")


def cores(threads: Optional[int]) -> int:
    """Threads of a batch: None is one a core."""
    return len(os.sched_getaffinity(0)) if threads is None else max(1, count(threads, "threads", 1024))


def batch_cores(threads: Optional[int], points: int) -> Optional[int]:
    """The same of a batch, where few points are one core's work."""
    return 1 if threads is None and points <= 4096 else cores(threads)


def path_of(path: Any, element: str = "path") -> bytes:
    """The bytes of a file's name."""
    try:
        out = os.fsencode(path)
    except TypeError:
        raise refuse(element, _what(path), "give a path") from None
    if b"\0" in out:
        raise refuse(element, "has a zero byte", "give a path")
    return out


PROJECTORS = ("newton", "pyramid", "printed")


def paper_reading(projector: Any, gate: Any, nearest_steps: Any, gaps: Any, pruning: Any, offset: Any) -> dict[str, int]:
    """How a paper model is read, as the structs of queries and sessions have it."""
    if not isinstance(projector, str) or projector not in PROJECTORS:
        raise refuse("projector", f"is {projector!r}", f"take one of {', '.join(PROJECTORS)}")
    if count(gate, "gate") == 0:  # zero stands for the default in C
        raise refuse("gate", "is 0", "give a number from 1 on, or take layer 2")
    return {"projector": PROJECTORS.index(projector), "gate": gate, "nearest_steps": count(nearest_steps, "nearest_steps", int(c.option_range("nearest_steps")[1])) or -1,
            "without_gaps": not flag(gaps, "gaps"), "without_pruning": not flag(pruning, "pruning"), "has_offset": flag(offset, "offset")}


def query_options(layer: Layer = 3, *, threads: Optional[int] = 1, tolerance: float = 0.0, margin: float = 0.0, band: float = 0.0,
                  smooth: bool = False, first_only: bool = False, gate: int = 10, offset: bool = False, projector: str = "newton",
                  nearest_steps: int = 2, gaps: bool = True, pruning: bool = True) -> c.QueryOptions:
    """Options of a query, to be read alone: equal ones are one object."""
    paper = projector, gate, nearest_steps, gaps, pruning, offset
    try:
        return _query_options(layer, threads, tolerance, margin, band, smooth, first_only, *paper)
    except TypeError:  # what is not hashable is no option
        return _query_options.__wrapped__(layer, threads, tolerance, margin, band, smooth, first_only, *paper)


@functools.lru_cache(maxsize=64, typed=True)
def _query_options(layer: Any, threads: Any, tolerance: Any, margin: Any, band: Any, smooth: Any, first_only: Any,
                   *paper: Any) -> c.QueryOptions:
    if isinstance(layer, bool) or not isinstance(layer, (int, str)) or layer not in LAYERS:
        raise refuse("layer", f"is {layer!r}", 'take 1, 2, 3, "exact", "auto" or "gate"')
    return c.QueryOptions(layer=LAYERS[layer], threads=cores(threads), tolerance=number(tolerance, "tolerance"),
                          margin=number(margin, "margin"), band=number(band, "band"), is_smooth=flag(smooth, "smooth"),
                          is_first_only=flag(first_only, "first_only"), **paper_reading(*paper))


def address(array: np.ndarray) -> int:
    """The first byte of an array."""
    try:
        return ctypes.addressof(ctypes.c_char.from_buffer(array))  # half the time of array.ctypes
    except (TypeError, ValueError):  # it is empty, or not to be written
        return array.ctypes.data


def points_struct(points: np.ndarray, pose: Optional[c.Pose] = None) -> c.Points:
    out = c.Points()
    out.xyz, out.count = address(points), len(points)
    if pose is not None:
        out.pose = pointer(pose)
    return out
