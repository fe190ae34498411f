"""Models: baking, files, queries of points."""
from __future__ import annotations

import ctypes
import json
import os
import threading
import warnings
from typing import Any, NamedTuple, Optional, Tuple, Union

import numpy as np

from . import _library as c
from ._arrays import (Layer, batch_cores, cores, count, finite, flag, instance, number, path_of, pointer, pose_of, poses_of, query_options, refuse, rows,
                      triangles_of)
from ._errors import ClosedError
from ._export import export
from ._one_point import OnePoint, give_back, taken
from ._progress import Progress, run
from ._render import render
from ._superquadric import Superquadric, superquadrics_of

REPAIRS = {"auto": 0, "none": 1, "safe": 2, "close": 3, "wrap": 4}
#: Metres per unit of a mesh.
UNITS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "dm": 0.1, "m": 1.0, "km": 1e3, "in": 0.0254, "ft": 0.3048}
SOLIDS = {"as-is": 0, "outer": 1}
CURES = ("", "closed", "wrapped")
DEFAULT_OPTIONS = ctypes.byref(query_options())
_IS_IN = np.array([False]), np.array([True])
FORMATS = {"urdf": 1, "mjcf": 2, "sdf": 3, "srdf": 4, "spheres": 5, "json": 6, "obj": 7, "glb": 8}
SHAPES = {"box": 1, "sphere": 2, "ellipsoid": 3, "capsule": 4, "cylinder": 5, "hull": 6, "superquadric": 7}


class CuredWarning(UserWarning):
    """A mesh that bounds no solid was closed or wrapped, so that the model is of another surface."""


class Owned:
    """A handle of the library: closed by close(), at the end of a with statement, or with the object.

    Any thread may close it: calls that are under way on others finish first.
    """

    _closes = ""

    def __init__(self, handle: c.Handle) -> None:
        if not isinstance(handle, c.Handle):
            raise refuse("handle", f"is a {type(handle).__name__}", "make one with sqmap.bake, Model.load or Model.from_bytes")
        self._handle = handle
        self._lock = threading.Lock()
        self.turn = threading.Lock()  # of what one thread at a time may use
        self._users = 0
        self._closed = False

    def __reduce__(self) -> Any:
        """A session belongs to its process, as all do that do not say what they are made of."""
        name = type(self).__name__
        raise refuse(name, "belongs to the process that made it", f"make a {name} in each process")

    def use(self, element: str = "") -> "_Use":
        """The open handle, for the length of a call. element: the argument that it came as, for errors."""
        return _Use(self, element)

    def _refusal(self, element: str = "") -> ClosedError:
        return ClosedError("E_HANDLE", element or type(self).__name__, "is closed", "open it again")

    def _leave(self) -> None:
        """Ends a call; the last one frees what was closed meanwhile."""
        with self._lock:
            self._users -= 1
            free = self._closed and self._users == 0
        if free:
            c.call(self._closes, self._handle)

    @property
    def closed(self) -> bool:
        return self._closed

    def close(self) -> None:
        """Closes it; a second time does nothing."""
        with self._lock:
            was, self._closed = self._closed, True
            free = not was and self._users == 0
        if free:
            c.call(self._closes, self._handle)

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __del__(self) -> None:
        try:
            self.close()
        except Exception:  # made half, or the interpreter is going down
            pass


class _Use:
    def __init__(self, owned: Owned, element: str) -> None:
        self._owned = owned
        self._element = element

    def __enter__(self) -> c.Handle:
        o = self._owned
        with o._lock:
            if o._closed:
                raise o._refusal(self._element)
            o._users += 1
        return o._handle

    def __exit__(self, *_: Any) -> None:
        self._owned._leave()


class Contacts(NamedTuple):
    """Answers of n points, row by row. Lengths in the mesh's units."""

    contact: np.ndarray  #: (n,) bool: inside
    depth: np.ndarray    #: (n,) penetration depth, 0 where free, NaN of a point that is not finite
    normal: np.ndarray   #: (n, 3) unit, outward at the closest point; zero where free
    closest: np.ndarray  #: (n, 3) the nearest surface point; the point itself where free
    part: np.ndarray     #: (n,) int32, that owns it; -1 where free
    certain: np.ndarray  #: (n,) bool: the verdict is proven
    status: np.ndarray   #: (n,) uint8, bits: 1 not finite, 2 no exact layer, 4 no surface, 16 made up, 128 not given


class Distances(NamedTuple):
    """Signed distances of n points, row by row. Lengths in the mesh's units."""

    distance: np.ndarray  #: (n,) negative inside; NaN of a point that is not finite
    gradient: np.ndarray  #: (n, 3) unit, away from the solid; zero of a bound
    closest: np.ndarray   #: (n, 3) the nearest surface point; the point itself of a bound
    part: np.ndarray      #: (n,) int32, that owns it; -1 of a bound
    known: np.ndarray     #: (n,) uint8: 0 exact, 1 approximate, 2 a bound: no farther than the truth, at least half of it, 3 exact in
                          #: float, of a model that was baked with keep_input=False
    status: np.ndarray    #: (n,) uint8, bits as in Contacts
    triangle: np.ndarray  #: (n,) int64, of Model.mesh, that holds the closest point; -1 of a bound


class Clearances(NamedTuple):
    """How near each of n poses brings a tool, row by row. Lengths in the mesh's units."""

    distance: np.ndarray  #: (n,) least signed distance of the tool's points, negative inside; NaN of a pose that is not finite
    gradient: np.ndarray  #: (n, 6) its derivative by the pose's translation, then by turns about it, axis times radians; zero of a bound
    point: np.ndarray     #: (n, 3) the tool's point at that distance; of a bound the tool's middle
    closest: np.ndarray   #: (n, 3) the surface point nearest to it
    index: np.ndarray     #: (n,) int64, number of the point; -1 of a bound
    part: np.ndarray      #: (n,) int32, that owns the surface there; -1 of a bound
    known: np.ndarray     #: (n,) uint8 as in Distances; 2: no point is nearer
    complete: np.ndarray  #: (n,) bool; False where stop_below ended the search
    status: np.ndarray    #: (n,) uint8, bits as in Contacts


class Facts(NamedTuple):
    """Facts of a model; lengths in mesh units."""

    r_max: float        #: largest distance between two vertices
    band: float         #: within it the distances of band=0 are exact
    centre: np.ndarray  #: (3,) of a sphere that holds the object
    radius: float       #: of that sphere
    bytes: int          #: of the model file
    parts: int
    vertices: int       #: of the baked mesh
    triangles: int      #: of the baked mesh
    is_solid: bool      #: False: a surface without inside
    has_exact: bool     #: the triangles are in the model
    is_normal: bool     #: of the normal projection
    is_doubtful: bool   #: layer 3 has wrong verdicts, or a 99th percentile of its depth error above 0.5 % of R_max: layer="auto" is exact
    has_input: bool     #: the mesh's own coordinates and numbers are kept: exact distances are in double
    cure: str           #: how the mesh became a solid: "" as it was given or repaired, "closed" or "wrapped"


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


def _shape_of(shape: Any) -> tuple[int, int]:
    """The number of a shape, and of how many balls."""
    if isinstance(shape, str) and shape in SHAPES:
        return SHAPES[shape], 0
    number_of = shape.removeprefix("spheres:") if isinstance(shape, str) else ""
    if not number_of.isdecimal() or not 1 <= int(number_of) <= 4096 or not shape.startswith("spheres:"):
        raise refuse("shape", f"is {shape!r}", f"take one of {', '.join(SHAPES)}, or spheres:N with N from 1 to 4096")
    return 0, int(number_of)


class Model(Owned):
    """A baked model. Any number of threads may query it at once.

    Make one with sqmap.bake, Model.load or Model.from_bytes. Points are arrays of shape (n, 3) in the mesh's own frame and
    units; with pose, a matrix (4, 4) from the mesh's frame to theirs, in that frame. C-contiguous float64 is not copied.
    """

    _closes = "sqmap_close_model"
    _superquadrics: Optional[list[tuple[Any, ...]]] = None

    # Files

    @classmethod
    def load(cls, path: "os.PathLike[str] | str", key: Optional[str] = None, *, copy: bool = False) -> "Model":
        """Maps a model file; with key, the model of that key in an archive of `sqmap batch`.

        The system reads a mapped file when it is needed. One that another program shortens or overwrites in place meanwhile ends
        this process; replacing it, as save does, leaves the model whole. copy: read all of it now, and be safe from both.
        Raises FileError, ModelError, VersionError; ArgumentError where the archive holds no such model.
        """
        if flag(copy, "copy"):
            with cls.load(path, key) as mapped:
                return cls.from_bytes(mapped.to_bytes())
        handle = c.Handle()
        if key is None:
            c.call("sqmap_open", path_of(path), handle)
        else:
            c.call("sqmap_open_archived", path_of(path), instance(key, str, "key").encode(errors="replace"), handle)
        return cls(handle)

    @classmethod
    def from_bytes(cls, data: bytes) -> "Model":
        """A model from a file's bytes. Raises ModelError, VersionError."""
        try:
            view = np.frombuffer(data, dtype=np.uint8)
        except Exception as e:  # what a foreign object's buffer raises
            raise refuse("data", f"is no buffer of bytes: {e}", "give bytes") from None
        handle = c.Handle()
        c.call("sqmap_open_bytes", address(view), view.size, handle)
        return cls(handle)

    def save(self, path: "os.PathLike[str] | str") -> None:
        """Writes the model file, whole or not at all. Raises FileError."""
        with self.use() as handle:
            c.call("sqmap_save", handle, path_of(path))

    def to_bytes(self) -> bytes:
        """The bytes that save writes."""
        with self.use() as handle:
            first, size = ctypes.c_void_p(), ctypes.c_size_t()
            c.call("sqmap_bytes", handle, first, size)
            return ctypes.string_at(first, size.value)

    def __reduce__(self) -> Any:
        return Model.from_bytes, (self.to_bytes(),)

    # Facts

    @property
    def facts(self) -> Facts:
        """Sizes, counts and what the model holds."""
        out = c.Facts()
        with self.use() as handle:
            c.call("sqmap_model_facts", handle, out)
        values = {name: getattr(out, name) for name in Facts._fields}
        values["centre"] = np.array(out.centre)
        values["cure"] = CURES[out.cure]
        return Facts(**{name: bool(value) if name.startswith(("is_", "has_")) else value for name, value in values.items()})

    @property
    def r_max(self) -> float:
        """Largest distance between two vertices, mesh units."""
        return self.facts.r_max

    @property
    def band(self) -> float:
        """Within this distance of the surface the baked signed distances are exact, mesh units."""
        return self.facts.band

    @property
    def info(self) -> dict[str, Any]:
        """All that `sqmap info --json` prints."""
        with self.use() as handle:
            return json.loads(c.text_of("sqmap_info", handle))

    @property
    def notes(self) -> list[str]:
        """Repairs, how far they moved the surface and warnings of the bake, a line each: of a model that was loaded too. info["notes"]
        has their numbers."""
        with self.use() as handle:
            return c.text_of("sqmap_notes", handle).splitlines()

    @property
    def superquadrics(self) -> list[Superquadric]:
        """The superquadric of each part, in mesh units; their arrays are not to be written."""
        with self.use():
            if self._superquadrics is None:  # they stand in a text, which takes milliseconds to make and to read
                self._superquadrics = superquadrics_of(self.parts)
            return [Superquadric(self, *values) for values in self._superquadrics]

    def _implicit(self, part: int, points: Any, pose: Any) -> np.ndarray:
        xyz = rows(points)
        values = np.empty(len(xyz))
        with self.use() as handle:
            c.call("sqmap_implicit", handle, part, points_struct(xyz, pose_of(pose)), address(values))
        return values

    @property
    def parts(self) -> list[dict[str, Any]]:
        """The superquadric, certificate and counts of each part; lengths in model space, `mesh_units` in the mesh's."""
        return self.info["parts"]

    @property
    def named_parts(self) -> np.ndarray:
        """(p,) int32: the number of the named part that each part belongs to: what a person would name one thing, such as the handle of
        a mug, may have several superquadrics. Answers name parts: model.named_parts[model.query(points).part]."""
        return np.array([part["group"] for part in self.parts], np.int32)

    @property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """(vertices (v, 3), triangles (t, 3) uint32) as they were baked, in the order to which triangle numbers refer.

        Coordinates are those that were given, to the bit; rounded to float where the model has no input. Raises MissingError of a model without the exact layer."""
        return self._triangles()[:2]

    @property
    def part_of_triangle(self) -> np.ndarray:
        """(t,) int32: the part of each triangle of mesh."""
        return self._triangles()[2]

    @property
    def source_triangle(self) -> np.ndarray:
        """(t,) int64: the number of each triangle of mesh in the mesh that was given, faces of a file from 0; -1 where a cure made it
        up. Raises MissingError of a model without its input."""
        return self._sources()[0]

    @property
    def source_vertex(self) -> np.ndarray:
        """(v,) int64: the same of each vertex of mesh."""
        return self._sources()[1]

    def _sources(self) -> tuple[np.ndarray, np.ndarray]:
        facts = self.facts
        triangles, vertices = np.empty(facts.triangles, np.int64), np.empty(facts.vertices, np.int64)
        with self.use() as handle:
            c.call("sqmap_sources", handle, address(triangles), address(vertices))
        return triangles, vertices

    def _triangles(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        facts = self.facts
        vertices = np.empty((facts.vertices, 3))
        triangles = np.empty((facts.triangles, 3), np.uint32)
        parts = np.empty(facts.triangles, np.int32)
        with self.use() as handle:
            c.call("sqmap_triangles", handle, address(vertices), address(triangles), address(parts))
        return vertices, triangles, parts

    def export(self, path: "os.PathLike[str] | str", format: Optional[str] = None, shape: Optional[str] = None, *,
               threads: Optional[int] = None) -> Optional[dict[str, Any]]:
        """Encloses each part in a shape that is certified to hold it and writes them, as `sqmap export --as` does; returns their figures.

        format: urdf, mjcf, sdf, srdf, spheres (cuRobo), json, obj, glb; without it the path's ending says. shape: hull (the default), box,
        sphere, ellipsoid, capsule, cylinder, superquadric, or spheres:N, N balls that hold the whole. Meshes that the file refers to are
        written beside it. Figures of the whole and of each shape: volume, support_excess, protrusion, in mesh units. With neither format
        nor shape .obj and .glb hold the model's triangles, a group for each part (GLB in float, from the object's centre), and .json what
        info has; then None is returned. All files appear whole or not at all. Raises FileError, MissingError of a model without
        triangles, ArgumentError for a shape that the format does not hold."""
        name = path_of(path)
        if format is not None and (not isinstance(format, str) or format not in FORMATS):
            raise refuse("format", f"is {format!r}", f"take one of {', '.join(FORMATS)}")
        kind, spheres = _shape_of("hull" if shape is None else shape)
        count_of_threads = 0 if threads is None else cores(threads)
        if format is None and shape is None and name.endswith((b".glb", b".json", b".obj")):
            export(self, os.fsdecode(name))
            return None
        report = c.Text()
        buffer = ctypes.create_string_buffer(1024 * ((spheres or self.facts.parts) + 2))
        report.text, report.capacity = ctypes.cast(buffer, ctypes.c_char_p), len(buffer)
        options = c.ExportOptions(format=FORMATS.get(format or "", 0), shape=kind, spheres=spheres, threads=count_of_threads)
        with self.use() as handle:
            c.call("sqmap_export", handle, name, options, report)
        return json.loads(buffer.value.decode("utf-8", "replace"))

    # Points

    def query(self, points: Any, layer: Layer = 3, *, pose: Any = None, margin: float = 0.0, tolerance: float = 0.0,
              smooth: bool = False, threads: Optional[int] = None) -> Contacts:
        """Which points (n, 3) are inside, how deep, and in which direction out.

        layer: 1, 2, 3, "exact", "gate" (of a paper model, 2 or 3 by k_L = 10), or "auto": the cheapest whose measured error is within tolerance. margin: the surface is moved
        out by so much. threads: None is one a core; the answers do not depend on it."""
        xyz = rows(points)
        n = len(xyz)
        if n == 1 and pose is None and threads is None:
            one = self._one("sqmap_query_points", xyz, query_options(layer, tolerance=tolerance, margin=margin, smooth=smooth), "contacts")
            answer = Contacts(one.contact.copy(), one.depth.copy(), one.direction.copy(), one.closest.copy(), one.part.copy(),
                              one.certain.copy(), one.status.copy())
            give_back(one)
            return answer
        contact, certain, status = np.empty(n, np.bool_), np.empty(n, np.bool_), np.empty(n, np.uint8)
        depth, normal, closest, part = np.empty(n), np.empty((n, 3)), np.empty((n, 3)), np.empty(n, np.int32)
        options = query_options(layer, threads=batch_cores(threads, n), tolerance=tolerance, margin=margin, smooth=smooth)
        out = c.Contacts(contact=address(contact), depth=address(depth), normal=address(normal), closest=address(closest),
                         part=address(part), certain=address(certain), status=address(status))
        self._call("sqmap_query_points", points_struct(xyz, pose_of(pose)), options, out)
        return Contacts(contact, depth, normal, closest, part, certain, status)

    def distances(self, points: Any, *, band: Optional[float] = None, pose: Any = None,
                  threads: Optional[int] = None) -> Distances:
        """Signed distances (negative inside) of points (n, 3), with gradient, closest point and its triangle.

        Exact in double, at any distance, so that finite differences are derivatives. With band, quicker and in float (errors of
        1e-7 of r_max): exact up to so far from the surface, mesh units, beyond it a lower bound; 0: as the model was baked. The
        gradient jumps where the nearest point does: on the medial axis inside, above concave edges outside."""
        xyz = rows(points)
        n = len(xyz)
        if n == 1 and pose is None and threads is None:
            one = self._one_distance(xyz, band, "distances")
            answer = Distances(one.distance.copy(), one.direction.copy(), one.closest.copy(), one.part.copy(), one.known.copy(),
                               one.status.copy(), one.triangle.astype(np.int64))
            give_back(one)
            return answer
        distance, gradient, closest = np.empty(n), np.empty((n, 3)), np.empty((n, 3))
        part, known, status = np.empty(n, np.int32), np.empty(n, np.uint8), np.empty(n, np.uint8)
        triangle = np.empty(n, np.uint32)
        self._distances(xyz, band, pose, threads,
                        c.Distances(distance=address(distance), gradient=address(gradient), closest=address(closest),
                                    part=address(part), known=address(known), status=address(status), triangle=address(triangle)))
        return Distances(distance, gradient, closest, part, known, status, triangle.view(np.int32).astype(np.int64))

    def signed_distance(self, points: Any, *, band: Optional[float] = None, threads: Optional[int] = None) -> np.ndarray:
        """Signed distances (n,) of points (n, 3): positive inside, as trimesh.proximity.signed_distance; of a surface never.

        Exact in double; band as in distances."""
        xyz = rows(points)
        if len(xyz) == 1 and threads is None:
            one = self._one_distance(xyz, band, "length")
            answer = np.empty(1)
            answer[0] = -one.number.value
            give_back(one)
            return answer
        distance = np.empty(len(xyz))
        self._distances(xyz, band, None, threads, c.Distances(distance=address(distance)))
        return np.negative(distance, out=distance)

    def _one(self, function: str, xyz: np.ndarray, options: Any, answer: str) -> OnePoint:
        """The answer of a function of one point, to be given back."""
        one = taken(xyz)
        with self._lock:  # as use does, without an object of its own
            if self._closed:
                raise self._refusal()
            self._users += 1
        try:
            if getattr(c.library, function)(self._handle, one.points, options, getattr(one, answer)) != 0:
                raise c.last_error(function)
        finally:
            self._leave()
        return one

    def _one_distance(self, xyz: np.ndarray, band: Optional[float], answer: str) -> OnePoint:
        if band is None:
            return self._one("sqmap_exact_distances", xyz, DEFAULT_OPTIONS, answer)
        return self._one("sqmap_signed_distances", xyz, query_options(band=number(band, "band")), answer)

    def _distances(self, xyz: np.ndarray, band: Optional[float], pose: Any, threads: Optional[int], out: c.Distances) -> None:
        options = query_options(threads=batch_cores(threads, len(xyz)), band=0.0 if band is None else number(band, "band"))
        function = "sqmap_exact_distances" if band is None else "sqmap_signed_distances"
        self._call(function, points_struct(xyz, pose_of(pose)), options, out)

    def clearance(self, points: Any, poses: Any, *, band: Optional[float] = None, stop_below: Optional[float] = None, pose: Any = None,
                  threads: Optional[int] = None) -> Clearances:
        """How near each pose (n, 4, 4) brings a tool of points (m, 3): its least signed distance, with the derivative by the pose.

        poses lead from the tool's frame to the mesh's, or with pose to the frame that it leads to. band: farther than so much a
        lower bound suffices, which is quicker. stop_below: a pose is done when one point is found to be this near. Exact in double
        as distances; where two points are equally near the derivative is that of one of them."""
        xyz, frames = rows(points), poses_of(poses)
        n = len(frames)
        distance, gradient, point, closest = np.empty(n), np.empty((n, 6)), np.empty((n, 3)), np.empty((n, 3))
        index, part, known = np.empty(n, np.int64), np.empty(n, np.int32), np.empty(n, np.uint8)
        complete, status = np.empty(n, np.bool_), np.empty(n, np.uint8)
        given = c.Poses(pose=ctypes.cast(address(frames), ctypes.POINTER(c.Pose)), count=n, threads=cores(threads), band=0.0 if band is None else number(band, "band"),
                        stops=stop_below is not None, stop_below=0.0 if stop_below is None else finite(stop_below, "stop_below"))
        out = c.PoseClearances(distance=address(distance), gradient=address(gradient), point=address(point), closest=address(closest),
                           index=address(index), part=address(part), known=address(known), complete=address(complete),
                           status=address(status))
        with self.use() as handle:
            c.call("sqmap_query_poses", handle, points_struct(xyz, pose_of(pose)), given, out)
        return Clearances(distance, gradient, point, closest, index, part, known, complete, status)

    def _call(self, function: str, points: c.Points, options: c.QueryOptions, out: c.Sized) -> None:
        with self.use() as handle:
            if getattr(c.library, function)(handle, ctypes.byref(points), ctypes.byref(options), ctypes.byref(out)) != 0:
                raise c.last_error(function)

    def contains(self, points: Any, *, threads: Optional[int] = None) -> np.ndarray:
        """(n,) bool: which points (n, 3) are inside: where signed_distance is above zero, so nowhere of a surface.

        Raises ArgumentError for a point that is not finite, which signed_distance and query answer with NaN."""
        return self._contains(rows(points), threads, "points")

    def _contains(self, xyz: np.ndarray, threads: Optional[int], element: str) -> np.ndarray:
        if len(xyz) == 1 and threads is None:
            one = self._one_distance(xyz, None, "length")
            distance = one.number.value
            give_back(one)
            if distance != distance:
                raise self._not_finite(element, 0)
            return _IS_IN[distance < 0].copy()
        distance = np.empty(len(xyz))
        self._distances(xyz, None, None, threads, c.Distances(distance=address(distance)))
        wrong = np.isnan(distance)
        if wrong.any():
            raise self._not_finite(element, int(wrong.argmax()))
        return distance < 0

    @staticmethod
    def _not_finite(element: str, row: int) -> Exception:
        return refuse(f"{element}[{row}]", "is not finite", "leave it out, or take signed_distance, which answers NaN")

    def closest_point(self, points: Any, *, threads: Optional[int] = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(closest (n, 3), distances (n,), triangle numbers (n,) int64) as trimesh.proximity.closest_point.

        In double precision on the triangles of mesh, to which the numbers refer; of a point that is not finite NaN and -1."""
        xyz = rows(points)
        n = len(xyz)
        if n == 1 and threads is None:
            one = self._one("sqmap_closest_points", xyz, DEFAULT_OPTIONS, "nearest")
            answer = one.closest.copy(), one.distance.copy(), one.triangle.astype(np.int64)
            give_back(one)
            return answer
        closest, distance, triangle = np.empty((n, 3)), np.empty(n), np.empty(n, np.uint32)
        self._call("sqmap_closest_points", points_struct(xyz), query_options(threads=batch_cores(threads, n)),
                   c.Closest(closest=address(closest), distance=address(distance), triangle=address(triangle)))
        return closest, distance, triangle.view(np.int32).astype(np.int64)

    def render(self, what: str = "parts", *, size: tuple[int, int] = (900, 700), azimuth: Optional[float] = None,
               elevation: Optional[float] = None, up: str = "y") -> np.ndarray:
        """A picture, (height, width, 3) uint8, as `sqmap render` draws it.

        what: parts, superquadrics, protrusion, features, locales, strength, curvature, hyperbolic, regions (convex, Q1 and Q2),
        mesh, bounds, map or error; several with commas stand side by side.
        azimuth, elevation: degrees."""
        if up not in ("x", "y", "z", "-x", "-y", "-z"):
            raise refuse("up", f"is {up!r}", "take x, y, z, -x, -y or -z")
        angles = [(f"--{name}", None if value is None else finite(value, name))
                  for name, value in (("azimuth", azimuth), ("elevation", elevation))]
        return render(self.save, what, size, [*angles, ("--up", up)])

    def __repr__(self) -> str:
        if self.closed:
            return "<sqmap.Model, closed>"
        f = self.facts
        return f"<sqmap.Model, {f.parts} parts, {f.triangles} triangles, {f.bytes} bytes>"


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


_PAPER_WORDS = {"cuts": ("passes", "printed"), "mean_curvature": ("area", "count"), "smoothing": ("surface", "distances"),
                "smoothing_kernel": ("binomial", "box", "gaussian")}
_PAPER_FROM_ZERO = ("boundary_concavity", "curvature_floor", "hyperbolic_share", "minimum_part", "fragment_roundness", "max_q2",
                    "offset_constant")
_PAPER_MOST = {"protrusion_sources": 100000, "subdivisions": 5, "offset_radius": 8, "smoothing_radius": 8}


class PaperOptions:
    """Thresholds that the paper leaves unstated, for bake(paper=...): the options of `sqmap bake`, of the same names, defaults, ranges
    and effects (docs/paper-claims.md). None: the default.

    Sections 2 and 3, of models of either projection: taper, bend. cuts: "passes" or "printed", which has thresholds of its own.
    exact_geodesics: eq. 4 over every triangle, else over protrusion_sources. mean_curvature ("area", "count"), printed_strength and
    printed_curvature are of printed cuts. Section 4.1, of the normal projection: grid is (rows, columns) of layer 2, subdivisions A_S,
    offset_constant a_N. smoothing: "surface", or "distances" as section 6 has it; smoothing_length is of the surface,
    smoothing_radius and smoothing_kernel ("binomial", "box", "gaussian") are of distances; radius 0: no smoothed map."""

    def __init__(self, *, taper: bool = True, bend: bool = True, cuts: str = "passes", exact_geodesics: bool = False,
                 protrusion_sources: Optional[int] = None, salient_window: Optional[float] = None,
                 salient_prominence: Optional[float] = None, locale_width: Optional[float] = None,
                 boundary_strength: Optional[float] = None, protrusion_ratio: Optional[float] = None,
                 curvature_window: Optional[float] = None, hyperbolic_curvature: Optional[float] = None,
                 boundary_concavity: Optional[float] = None, curvature_floor: Optional[float] = None,
                 hyperbolic_share: Optional[float] = None, minimum_part: Optional[float] = None,
                 fragment_roundness: Optional[float] = None, mean_curvature: str = "area", printed_strength: Optional[float] = None,
                 printed_curvature: Optional[float] = None, max_looseness: Optional[float] = None, max_q2: Optional[float] = None,
                 grid: Optional[Tuple[int, int]] = None, subdivisions: Optional[int] = None, offset_constant: Optional[float] = None,
                 offset_radius: Optional[int] = None, smoothing: str = "surface", smoothing_length: Optional[float] = None,
                 smoothing_radius: Optional[int] = None, smoothing_kernel: str = "binomial") -> None:
        given = dict(locals())
        self._struct = out = c.PaperOptions(without_taper=not flag(taper, "taper"), without_bend=not flag(bend, "bend"),
                                            exact_geodesics=flag(exact_geodesics, "exact_geodesics"))
        for name, words in _PAPER_WORDS.items():
            if not isinstance(given[name], str) or given[name] not in words:
                raise refuse(name, f"is {given[name]!r}", f"take one of {', '.join(words)}")
            setattr(out, name, words.index(given[name]))
        if grid is not None:
            if not isinstance(grid, (tuple, list)) or len(grid) != 2:
                raise refuse("grid", f"is {grid!r}", "give (rows, columns)")
            out.rows, out.columns = (count(side, "grid", 8192) for side in grid)
            if not 5 <= out.rows <= 4097 or not 8 <= out.columns:
                raise refuse("grid", f"is {grid!r}", "give 5 to 4097 rows and 8 to 8192 columns")
        for name, kind in c.PaperOptions._fields_:
            value = given.get(name)
            if value is None or name in _PAPER_WORDS or name == "exact_geodesics":
                continue
            if kind is c.c_double:
                value = number(value, name)
                if not (0 < value < float("inf") or value == 0 and name in _PAPER_FROM_ZERO):
                    raise refuse(name, f"is {value:g}", f"give a number {'from 0 on' if name in _PAPER_FROM_ZERO else 'above zero'}")
            else:
                value = count(value, name, _PAPER_MOST[name])
            # Zero stands for the default in C, below zero for none.
            setattr(out, name, value if value != 0 or name == "protrusion_sources" else -1)
        if cuts != "printed" and (mean_curvature != "area" or printed_strength is not None or printed_curvature is not None):
            raise refuse("cuts", f"is {cuts!r}, and a threshold of printed cuts is given", 'take "printed"')
        if protrusion_sources == 0:
            raise refuse("protrusion_sources", "is 0", "give a number from 1 to 100000")


def bake(mesh: Any, *, target_error: float = 0.5, max_parts: int = 24, band: float = 5.0, projection: str = "central",
         exact: bool = True, keep_input: bool = True, repair: str = "auto", surface: bool = False, thickness: float = 0.0,
         solid: str = "as-is", gap: float = 0.01, wrap_tolerance: float = 0.002,
         unit: Union[str, float, None] = None, threads: Optional[int] = None, source: Optional[str] = None, progress: Union[bool, Progress, None] = None,
         paper: Optional[PaperOptions] = None) -> Model:
    """Bakes a closed triangle mesh into a Model.

    mesh: a path (OFF, OBJ, STL, PLY, glTF, GLB), a pair (vertices (v, 3), triangles (t, 3)), or an object with vertices and
    faces or triangles (trimesh, Open3D). target_error: percent of R_max, 0.001 to 100. max_parts: 1 to 1000. band: percent of R_max within which signed distances
    are baked exactly, above 0. projection: "central" or "normal". exact: keep the triangles. keep_input: keep their coordinates and
    numbers as given, up to 18 bytes a triangle, so that distances are in double. repair: "auto", "none", "safe",
    "close", "wrap". surface: take an open mesh as it is. thickness: make open meshes plates, units of the model.
    solid: "outer" is one body about all triangles, proven to hold them, of what cannot be reached from outside: repair, surface
    and thickness have no effect then. gap: share of R_max, narrower gaps of an outer solid are closed. wrap_tolerance: share of
    R_max that outer and wrapped solids may be off.
    unit: of the mesh, "um", "mm", "cm", "dm", "m", "km", "in", "ft" or metres per unit: the model and all that it answers are in metres;
    None: in the mesh's own unit. progress: True
    shows a bar; a function is called with a stage's name and the share that is done, and true from it stops the bake (Cancelled).
    Ctrl-C stops it too, within a stage. The bytes do not depend on threads. paper: the paper's thresholds.

    Warns (CuredWarning) of a mesh that was closed or wrapped. Raises MeshError with a cure and what is wrong, "triangles[3]" of arrays, "face 4" of a file; ArgumentError."""
    if not isinstance(repair, str) or repair not in REPAIRS:
        raise refuse("repair", f"is {repair!r}", f"take one of {', '.join(REPAIRS)}")
    if not isinstance(projection, str) or projection not in ("central", "normal"):
        raise refuse("projection", f"is {projection!r}", "take central or normal")
    if not isinstance(solid, str) or solid not in SOLIDS:
        raise refuse("solid", f"is {solid!r}", f"take one of {', '.join(SOLIDS)}")
    for name, share, least, most in (("gap", number(gap, "gap"), 1e-9, 0.2),
                                     ("wrap_tolerance", number(wrap_tolerance, "wrap_tolerance"), 0.0016, 0.1)):
        if not least <= share <= most:  # zero stands for the default in C
            raise refuse(name, f"is {share:g}", f"give a number from {least:g} to {most:g}")
    error, width = number(target_error, "target_error"), number(band, "band")
    if error == 0 or width == 0:  # zero stands for the default in C
        raise refuse("target_error" if error == 0 else "band", "is 0", "give a number above zero")
    if max_parts == 0:
        raise refuse("max_parts", "is 0", "give a number from 1 to 1000")
    if source is not None:
        instance(source, str, "source")
    options = c.BakeOptions(target_error=error, band=width, thickness=number(thickness, "thickness"),
                            max_parts=count(max_parts, "max_parts"), projection=int(projection == "normal"), repair=REPAIRS[repair],
                            accepts_surface=flag(surface, "surface"), without_exact=not flag(exact, "exact"),
                            without_input=not flag(keep_input, "keep_input"), threads=cores(threads),
                            source=None if source is None else source.encode(errors="replace"),
                            words=c.WORDS, unit=_metres_per(unit), gap=number(gap, "gap"),
                            wrap_tolerance=number(wrap_tolerance, "wrap_tolerance"), solid=SOLIDS[solid],
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
