"""Models: files, facts, queries of points."""
from __future__ import annotations

import ctypes
import json
import os
from typing import Any, Optional

import numpy as np

from . import _library as c
from ._answers import Clearances, Contacts, Distances, Facts
from ._arrays import (Layer, address, batch_cores, cores, finite, flag, instance, number, path_of, points_struct, pose_of, poses_of,
                      query_options, refuse, rows)
from ._export import export
from ._one_point import OnePoint, give_back, taken
from ._owned import Owned
from ._paper_options import PaperOptions
from ._render import render
from ._superquadric import Superquadric, superquadrics_of

CURES = ("", "closed", "wrapped")
DEFAULT_OPTIONS = ctypes.byref(query_options())
_IS_IN = np.array([False]), np.array([True])
FORMATS = {"urdf": 1, "mjcf": 2, "sdf": 3, "srdf": 4, "spheres": 5, "json": 6, "obj": 7, "glb": 8}
SHAPES = {"box": 1, "sphere": 2, "ellipsoid": 3, "capsule": 4, "cylinder": 5, "hull": 6, "superquadric": 7}


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
              smooth: bool = False, threads: Optional[int] = None, gate: int = 10, offset: bool = False, projector: str = "newton",
              nearest_steps: int = 2, gaps: bool = True, pruning: bool = True) -> Contacts:
        """Which points (n, 3) are inside, how deep, and in which direction out.

        layer: 1, 2, 3, "exact", "gate" (2 or 3 by gate, k_L, from 1), or "auto": the cheapest whose measured error is within
        tolerance. margin: the surface is moved out by so much, offset: by eq. 12. threads: None is one a core; the answers do not
        depend on it. Of a paper model, as in Session: projector "newton", "pyramid" or "printed",
        nearest_steps (layer 3 with newton, 0 to 100), gaps (layer 3) and pruning. Raises ArgumentError for an option that changes
        none of the answers."""
        xyz = rows(points)
        n = len(xyz)
        how = {"tolerance": tolerance, "margin": margin, "smooth": smooth, "gate": gate, "offset": offset, "projector": projector,
               "nearest_steps": nearest_steps, "gaps": gaps, "pruning": pruning}
        if n == 1 and pose is None and threads is None:
            one = self._one("sqmap_query_points", xyz, query_options(layer, **how), "contacts")
            answer = Contacts(one.contact.copy(), one.depth.copy(), one.direction.copy(), one.closest.copy(), one.part.copy(),
                              one.certain.copy(), one.status.copy())
            give_back(one)
            return answer
        contact, certain, status = np.empty(n, np.bool_), np.empty(n, np.bool_), np.empty(n, np.uint8)
        depth, normal, closest, part = np.empty(n), np.empty((n, 3)), np.empty((n, 3)), np.empty(n, np.int32)
        options = query_options(layer, threads=batch_cores(threads, n), **how)
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
               elevation: Optional[float] = None, up: str = "y", paper: Optional[PaperOptions] = None) -> np.ndarray:
        """A picture, (height, width, 3) uint8, as `sqmap render` draws it.

        what: parts, superquadrics, protrusion, features, locales, strength, curvature, hyperbolic, regions (convex, Q1 and Q2),
        mesh, bounds, map or error; several with commas stand side by side.
        azimuth, elevation: degrees. paper: thresholds of section 3, for its fields (protrusion to hyperbolic)."""
        if up not in ("x", "y", "z", "-x", "-y", "-z"):
            raise refuse("up", f"is {up!r}", "take x, y, z, -x, -y or -z")
        angles = [(f"--{name}", None if value is None else finite(value, name))
                  for name, value in (("azimuth", azimuth), ("elevation", elevation))]
        thresholds = [] if paper is None else instance(paper, PaperOptions, "paper")._of_section_three()
        return render(self.save, what, size, [*angles, ("--up", up), *thresholds])

    def __repr__(self) -> str:
        if self.closed:
            return "<sqmap.Model, closed>"
        f = self.facts
        return f"<sqmap.Model, {f.parts} parts, {f.triangles} triangles, {f.bytes} bytes>"
