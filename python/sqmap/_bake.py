"""Baking a mesh into a model."""
from __future__ import annotations

import ctypes
import os
import warnings
from typing import Any, Optional, Union

from . import _library as c
from ._arrays import address, cores, flag, instance, number, option, path_of, refuse, triangles_of
from ._model import Model
from ._paper_options import PaperOptions
from ._progress import Progress, run

REPAIRS = {"auto": 0, "none": 1, "safe": 2, "close": 3, "wrap": 4}
#: Metres per unit of a mesh.
UNITS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "dm": 0.1, "m": 1.0, "km": 1e3, "in": 0.0254, "ft": 0.3048}
SOLIDS = {"as-is": 0, "outer": 1}


class CuredWarning(UserWarning):
    """A mesh that bounds no solid was closed or wrapped, so that the model is of another surface."""


def _metres_per(unit: Union[str, float, None]) -> float:
    """Metres per unit; 0 where the mesh's own is kept."""
    if unit is None:
        return 0.0
    if isinstance(unit, str):
        if unit not in UNITS:
            raise refuse("unit", f"is {unit!r}", f"take one of {', '.join(UNITS)}, or metres per unit")
        return UNITS[unit]
    metres = number(unit, "unit")
    if metres == 0:  # it stands for no unit in C
        raise refuse("unit", "is 0", f"take one of {', '.join(UNITS)}, or metres per unit")
    return metres


def bake(mesh: Any, *, target_error: float = 0.5, max_parts: int = 24, band: float = 5.0, projection: str = "central",
         exact: bool = True, keep_input: bool = True, repair: str = "auto", surface: bool = False, thickness: float = 0.0,
         solid: str = "as-is", gap: float = 0.01, wrap_tolerance: float = 0.002,
         unit: Union[str, float, None] = None, threads: Optional[int] = None, source: Optional[str] = None, progress: Union[bool, Progress, None] = None,
         paper: Optional[PaperOptions] = None, locator: bool = True) -> Model:
    """Bakes a closed triangle mesh into a Model.

    mesh: a path (OFF, OBJ, STL, PLY, glTF, GLB), a pair (vertices (v, 3), triangles (t, 3)), or an object with vertices and
    faces or triangles (trimesh, Open3D). target_error: percent of R_max. max_parts: at most so many by cuts. band: percent of R_max within which signed distances
    are baked exactly. projection: "central" or "normal". exact: keep the triangles. keep_input: keep their coordinates and
    numbers as given, up to 18 bytes a triangle, so that distances are in double. repair: "auto", "none", "safe",
    "close", "wrap". surface: take an open mesh as it is. thickness: make open meshes plates, units of the model.
    solid: "outer" is one body about all triangles, proven to hold them, of what cannot be reached from outside: repair, surface
    and thickness have no effect then. gap: share of R_max, narrower gaps of an outer solid are closed. wrap_tolerance: share of
    R_max that outer and wrapped solids may be off.
    unit: of the mesh, "um", "mm", "cm", "dm", "m", "km", "in", "ft" or metres per unit: the model and all that it answers are in metres;
    None: in the mesh's own unit. progress: True
    shows a bar; a function is called with a stage's name and the share that is done, and true from it stops the bake (Cancelled).
    Ctrl-C stops it too, within a stage. The bytes do not depend on threads. paper: the paper's thresholds. locator: False leaves out the
    locator and the triangles: superquadrics and central maps alone answer. `sqmap bake --help` has the ranges.

    Warns (CuredWarning) of a mesh that was closed or wrapped. Raises FileError where there is no file; MeshError with a cure and what is wrong, "triangles[3]" of arrays, "face 4" of a file; ArgumentError."""
    if not isinstance(repair, str) or repair not in REPAIRS:
        raise refuse("repair", f"is {repair!r}", f"take one of {', '.join(REPAIRS)}")
    if not isinstance(projection, str) or projection not in ("central", "normal"):
        raise refuse("projection", f"is {projection!r}", "take central or normal")
    if not isinstance(solid, str) or solid not in SOLIDS:
        raise refuse("solid", f"is {solid!r}", f"take one of {', '.join(SOLIDS)}")
    if source is not None:
        instance(source, str, "source")
    options = c.BakeOptions(target_error=option(target_error, "target_error"), band=option(band, "band"),
                            thickness=number(thickness, "thickness"), max_parts=option(max_parts, "max_parts", True), projection=int(projection == "normal"), repair=REPAIRS[repair],
                            accepts_surface=flag(surface, "surface"), without_exact=not flag(exact, "exact"),
                            without_input=not flag(keep_input, "keep_input"), threads=cores(threads),
                            source=None if source is None else source.encode(errors="replace"),
                            words=c.WORDS, unit=_metres_per(unit), gap=option(gap, "gap"),
                            wrap_tolerance=option(wrap_tolerance, "wrap_tolerance"), without_locator=not flag(locator, "locator"), solid=SOLIDS[solid],
                            paper=None if paper is None else ctypes.pointer(instance(paper, PaperOptions, "paper")._struct))
    if isinstance(mesh, (str, bytes, os.PathLike)):
        function, given = "sqmap_bake_file", path_of(mesh, "mesh")
    else:
        vertices, triangles = triangles_of(mesh)
        function, given = "sqmap_bake", c.Mesh(vertices=address(vertices), vertex_count=len(vertices), triangles=address(triangles),
                                               triangle_count=len(triangles))
        given.arrays = (vertices, triangles)  # a bake outlives a caller who is interrupted

    def baked(callback: Any) -> Model:
        handle = c.Handle()
        options.progress = callback
        c.call(function, given, options, handle)
        return Model(handle)

    model = run(baked, progress)
    if solid == "as-is" and (cure := model.facts.cure):  # an outer solid was asked for
        warnings.warn(f"the mesh bounds no solid and was {cure}: see Model.notes, or forbid it with repair=\"safe\"", CuredWarning,
                      stacklevel=2)
    return model
