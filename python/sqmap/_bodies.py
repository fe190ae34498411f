"""Probes and pairs: many points of a moving body per call."""
from __future__ import annotations

import ctypes
from typing import Any, NamedTuple, Optional

import numpy as np

from . import _library as c
from ._arrays import (address, points_struct, Layer, cores, count, flag, indices, instance, number, numbers, pointer, pose_of, poses_of, query_options, refuse,
                      rows)
from ._model import Model
from ._owned import Owned



def _rows_of(struct: type[ctypes.Structure], formats: dict[str, Any]) -> np.dtype:
    """The struct as NumPy sees it."""
    return np.dtype({"names": list(formats), "formats": list(formats.values()),
                     "offsets": [getattr(struct, name).offset for name in formats], "itemsize": ctypes.sizeof(struct)})


_FULL = 8  # SQMAP_FULL
_MAX_SLOTS = 1 << 24  # of a workspace that a call makes for itself

#: Rows of ProbeContacts.contacts. point: from anchor; index: of the probe's point.
CONTACT = _rows_of(c.Contact, {"point": ("f4", 3), "normal": ("f4", 3), "depth": "f4", "index": "u4", "part": "i2",
                               "certain": "?", "status": "u1"})
#: Rows of PairContacts.contacts. on_b = on_a - depth normal; vertex_of: 0 a vertex of a, 1 of b.
PAIR_CONTACT = _rows_of(c.PairContact, {"on_a": ("f8", 3), "on_b": ("f8", 3), "normal": ("f4", 3), "depth": "f4", "index": "u4",
                                        "part": "i2", "vertex_of": "u1", "certain": "?", "is_mutual": "?", "status": "u1"})


#: Rows of SurfaceContacts.contacts. feature_a, feature_b: 0 a vertex, 1 an edge, 2 a face; index_a, index_b: a vertex or a face by
#: its number, an edge as 3 t + k, from corner k of triangle t to the next one; 4294967295: the face that a vertex is below.
SURFACE_CONTACT = _rows_of(c.SurfaceContact, {"on_a": ("f8", 3), "on_b": ("f8", 3), "normal": ("f4", 3), "depth": "f4",
                                              "feature_a": "u1", "feature_b": "u1", "index_a": "u4", "index_b": "u4",
                                              "region": "u4", "part_a": "i2", "part_b": "i2", "certain": "?", "status": "u1"})

#: Rows of PileContacts.pairs. a, b: numbers of bodies, a < b; its contacts are contacts[first : first + count].
PILE_PAIR = _rows_of(c.PilePair, {"a": "u4", "b": "u4", "first": "u8", "count": "u8", "found": "u8", "meetings": "u8",
                                  "regions": "u8", "status": "u1"})


class Probe(Owned):
    """Points (n, 3) prepared once and queried many times: the vertices of a tool. Any number of threads may query it.

    triangles: (t, 3) between the points, of a closed mesh, which complete contacts need: ``Probe(*model.mesh)``. Raises MeshError with
    the triangle and a cure where they are open, turned round or inside out."""

    _closes = "sqmap_close_probe"

    def __init__(self, points: Any, triangles: Any = None) -> None:
        xyz = rows(points)
        corners = None if triangles is None else indices(triangles)
        handle = c.Handle()
        if corners is None:
            c.call("sqmap_make_probe", points_struct(xyz), handle)
        else:
            c.call("sqmap_make_solid_probe", c.Mesh(vertices=address(xyz), vertex_count=len(xyz), triangles=address(corners),
                                                    triangle_count=len(corners)), handle)
        super().__init__(handle)
        self._made_of = (xyz.copy(), corners if corners is None else corners.copy())
        #: (v,) and (t,) int64: numbers in the mesh that Probe.of's model was given, -1 where a cure made it up; else None.
        self.source_vertex: Optional[np.ndarray] = None
        self.source_triangle: Optional[np.ndarray] = None

    @classmethod
    def of(cls, model: Model, triangles: bool = True) -> "Probe":
        """The vertices of a model's mesh, and its triangles unless told otherwise. Where the model has its input, source_vertex and
        source_triangle number them as the mesh that was given: source_vertex[found.contacts["index"]]."""
        with instance(model, Model, "model").use("model"):
            vertices, corners = model.mesh
            out = cls(vertices, corners if flag(triangles, "triangles") else None)
            if model.facts.has_input:
                out.source_vertex, out.source_triangle = model.source_vertex, model.source_triangle if triangles else None
        return out

    def __reduce__(self) -> Any:
        with self.use():
            return Probe, self._made_of, {"source_vertex": self.source_vertex, "source_triangle": self.source_triangle}

    def __len__(self) -> int:
        return len(self._made_of[0])


class ProbeContacts(NamedTuple):
    """Contacts of a probe with a model, in the frame of the poses."""

    contacts: np.ndarray  #: rows of CONTACT
    anchor: np.ndarray    #: (3,) what contacts["point"] is relative to
    status: int           #: bits, as in Contacts

    @property
    def points(self) -> np.ndarray:
        """(n, 3) float64: witness points."""
        return self.anchor + self.contacts["point"]


class PairContacts(NamedTuple):
    """Contacts of two bodies, in the frame of the poses."""

    contacts: np.ndarray  #: rows of PAIR_CONTACT
    found: int            #: in both directions, before those seen twice were merged
    status: int
    edge_length: float    #: edges no longer that cross the other surface have an end among the contacts; 0: edges are missed


class SurfaceContacts(NamedTuple):
    """Complete contacts of two bodies, in the frame of the poses."""

    contacts: np.ndarray  #: rows of SURFACE_CONTACT
    found: int            #: kept or not
    meetings: int         #: pairs of triangles that have a point in common
    regions: int          #: of such pairs, each one connected; every one has a contact
    status: int           #: bits as in Contacts, and 8: the workspace was too small, and contacts are missing


class FirstTouch(NamedTuple):
    """The first touch of a motion."""

    touches: bool
    time: float  #: share of the motion, not after the first touch; 1 where there is none
    status: int


class FeatureTouches(NamedTuple):
    """First touches of moving features."""

    touches: np.ndarray  #: (n,) bool
    time: np.ndarray     #: (n,) not after the first touch; 1 where there is none


class Clearance(NamedTuple):
    """The least distance of two solids, in the frame and units of the poses."""

    distance: float   #: of the two points; 0 where the solids have a point in common
    at_least: float   #: the truth is not below it
    on_a: np.ndarray  #: (3,) nearest to b
    on_b: np.ndarray  #: (3,) nearest to a
    triangle_a: int   #: that holds on_a; 4294967295 where one solid is in the other
    triangle_b: int
    status: int


class Overlap(NamedTuple):
    """The intersection of two solids."""

    volume: float  #: in the cube of the poses' unit
    error: float   #: what the shift of faces in special position changes at most, without rounding
    status: int


class Separation(NamedTuple):
    """A translation of b after which two solids only touch, in the frame and units of the poses."""

    distance: float        #: along the direction; 0 where the solids have no point in common
    at_least: float        #: no shorter translation of those in question separates them
    direction: np.ndarray  #: (3,) unit
    exact: bool            #: the two bounds differ by rounding alone
    status: int


class PileContacts(NamedTuple):
    """Complete contacts of a pile, in the frame of the poses."""

    pairs: np.ndarray     #: rows of PILE_PAIR, in the order of a, then b
    contacts: np.ndarray  #: rows of SURFACE_CONTACT, pair after pair
    near: int             #: pairs whose spheres touch
    status: int           #: bits of all


class Body:
    """A solid where it is: its model is touched, its probe touches. Both are of one mesh; either may be None where a call does not
    need it.

    pose: a matrix (4, 4) from the mesh's frame to that of the poses; None: the same."""

    def __init__(self, model: Optional[Model] = None, probe: Optional[Probe] = None, pose: Any = None) -> None:
        self.model = None if model is None else instance(model, Model, "model")
        self.probe = None if probe is None else instance(probe, Probe, "probe")
        self.pose = pose


class _Named(NamedTuple):
    """A body as a call has it: its members and the names of them that the caller knows."""

    model: Optional[Model]
    probe: Optional[Probe]
    pose: Optional[c.Pose]
    names: tuple[str, str]  #: of model and probe


def _named(body: Any, name: str) -> _Named:
    instance(body, Body, name)
    model, probe, names = body.model, body.probe, (f"{name}.model", f"{name}.probe")
    return _Named(None if model is None else instance(model, Model, names[0]),
                  None if probe is None else instance(probe, Probe, names[1]), pose_of(body.pose, f"{name}.pose"), names)


class _Bodies:
    """Two bodies as the library takes them; their handles are open as long as this is entered."""

    def __init__(self, a: _Named, b: _Named) -> None:
        self._bodies = (a, b)
        self._uses = [thing.use(name) for body in self._bodies for thing, name in zip(body[:2], body.names) if thing is not None]

    def __enter__(self) -> c.Bodies:
        entered = []
        try:
            for use in self._uses:
                use.__enter__()
                entered.append(use)
        except Exception:
            for use in entered:
                use.__exit__()
            raise
        structs = []
        for body in self._bodies:
            handles = [c.Handle(0) if thing is None else thing._handle for thing in (body.model, body.probe)]
            structs.append(c.Body(handles[0], handles[1], pointer(body.pose)))
        return c.Bodies(a=structs[0], b=structs[1])

    def __exit__(self, *_: Any) -> None:
        for use in self._uses:
            use.__exit__()


def query_probe(model: Model, probe: Probe, pose: Any = None, *, model_pose: Any = None, layer: Layer = 3, margin: float = 0.0,
                tolerance: float = 0.0, first_only: bool = False) -> ProbeContacts:
    """Which points of the probe are inside the model. pose, model_pose: matrices (4, 4) to the frame of the answers. status: bits as in
    Contacts. Cost: microseconds for thousands of points, most of which are culled in groups."""
    instance(model, Model, "model")
    instance(probe, Probe, "probe")
    options = query_options(layer, margin=margin, tolerance=tolerance, first_only=first_only)
    contacts = np.empty(len(probe), CONTACT)
    out = c.ContactList(contacts=address(contacts), capacity=len(contacts))
    with _Bodies(_Named(model, None, pose_of(model_pose, "model_pose"), ("model", "")),
                 _Named(None, probe, pose_of(pose), ("", "probe"))) as bodies:
        c.call("sqmap_query_probe", bodies, options, out)
    return ProbeContacts(contacts[: min(out.found, len(contacts))], np.array(out.anchor[:]), out.status)


class Workspace(Owned):
    """The memory that pairs are computed in; give each thread its own. contacts: the largest number found in one direction."""

    _closes = "sqmap_close_workspace"

    def __init__(self, contacts: int = 65536) -> None:
        handle = c.Handle()
        c.call("sqmap_make_workspace", count(contacts, "contacts"), handle)
        super().__init__(handle)
        self._contacts = contacts

    def __reduce__(self) -> Any:
        with self.use():
            return Workspace, (self._contacts,)


def query_pair(a: Body, b: Body, workspace: Optional[Workspace] = None, *, layer: Layer = 3, margin: float = 0.0,
               tolerance: float = 0.0, first_only: bool = False) -> PairContacts:
    """Contacts of two bodies: each one's probe in the other's model, each contact once; one direction alone where the other lacks
    model or probe, and an error where both do. Calls with one workspace take turns. status: bits as in Contacts; 8 where a workspace
    that is given has too little space. Cost: two probe queries, and a workspace where none is given."""
    options = query_options(layer, margin=margin, tolerance=tolerance, first_only=first_only)
    first, second = _named(a, "a"), _named(b, "b")
    if (first.model is None or second.probe is None) and (second.model is None or first.probe is None):
        missing = "b.probe" if first.model is not None else "a.probe" if second.model is not None else "a.model"
        raise refuse(missing, "is None, so that neither body's probe meets the other's model",
                     "give one body a model and the other a probe, or each both")
    if workspace is None:
        with Workspace(max(len(x.probe) for x in (first, second) if x.probe is not None)) as own:
            return query_pair(a, b, own, layer=layer, margin=margin, tolerance=tolerance, first_only=first_only)
    instance(workspace, Workspace, "workspace")
    out = c.PairList()
    with _Bodies(first, second) as bodies, workspace.turn, workspace.use("workspace") as handle:
        c.call("sqmap_query_pair", bodies, options, handle, out)
        data = ctypes.string_at(out.contacts, out.count * ctypes.sizeof(c.PairContact)) if out.count else b""
    return PairContacts(np.frombuffer(data, PAIR_CONTACT), out.found, out.status, out.edge_length)


def query_contacts(a: Body, b: Body, workspace: Optional[Workspace] = None, *, per_region: int = 0,
                   first_only: bool = False) -> SurfaceContacts:
    """Contacts of two closed meshes, none missed: vertices, edges and faces. Both probes need triangles; where a model is None, no
    vertices in it are found. per_region: of a region that many are kept, the deepest and those that span the largest area; 0: all.
    Without a workspace the call makes one, larger until all contacts fit; one that is given and too small loses contacts (status 8).
    Calls with one workspace take turns. Cost: microseconds for thousands of triangles, and a workspace where none is given."""
    options = c.ContactOptions(per_region=count(per_region, "per_region"), is_first_only=flag(first_only, "first_only"))
    first, second = _with_probes(a, b)
    if workspace is None:
        slots = max(4096, len(first.probe), len(second.probe))
        while True:
            with Workspace(slots) as own:
                found = query_contacts(a, b, own, per_region=per_region, first_only=first_only)
            if not found.status & _FULL or slots >= _MAX_SLOTS:
                return found
            slots = min(4 * slots, _MAX_SLOTS)
    instance(workspace, Workspace, "workspace")
    out = c.SurfaceList()
    with _Bodies(first, second) as bodies, workspace.turn, workspace.use("workspace") as handle:
        c.call("sqmap_query_contacts", bodies, options, handle, out)
        data = ctypes.string_at(out.contacts, out.count * ctypes.sizeof(c.SurfaceContact)) if out.count else b""
    return SurfaceContacts(np.frombuffer(data, SURFACE_CONTACT), out.found, out.meetings, out.regions, out.status)


def first_touch(a: Body, b: Body, pose: Any, pose_a: Any = None) -> FirstTouch:
    """When b touches a on its way from its own pose to another one, a matrix (4, 4): in a straight line and about one axis. pose_a: where
    a moves to in the same time; None: it rests. Never late, early by at most a thousandth of the motion where surfaces approach at 8
    degrees or steeper. Both probes need triangles. status: bits as in Contacts. Cost: some queries of contacts."""
    first, second = _with_probes(a, b)
    end = pose_of(pose)
    if end is None:
        raise refuse("pose", "is None", "give a matrix (4, 4), where b's motion ends")
    end_a = pose_of(pose_a, "pose_a")
    out = c.Touch(end_pose_a=pointer(end_a))
    with _Bodies(first, second) as bodies:
        c.call("sqmap_first_touch", bodies, end, out)
    return FirstTouch(bool(out.touches), out.time, out.status)


def first_touch_features(start: Any, end: Any, edges: bool = False, separation: float = 0.0) -> FeatureTouches:
    """When points and triangles first touch, or edges and edges, that move in straight lines at a steady rate. start, end: (n, 4, 3) at
    time 0 and at time 1, each a point and a triangle's corners, or with edges the ends of one edge, then of the other. separation: how far
    apart counts as touching. Never missed nor late, early by 1e-9 where they do not pass at grazing distance; a coordinate that is
    not finite touches at time 0. Cost: a tenth of a microsecond in the median for two that stay apart, some ten for two that come
    close."""
    first, last = (np.ascontiguousarray(numbers(value, name)) for value, name in ((start, "start"), (end, "end")))
    if first.shape[1:] != (4, 3) or last.shape != first.shape:
        raise refuse("start, end", f"have the shapes {first.shape} and {last.shape}", "give (n, 4, 3) of both times")
    apart = number(separation, "separation")
    if not apart >= 0:
        raise refuse("separation", f"is {apart}", "give a number that is not below zero")
    out = FeatureTouches(np.empty(len(first), bool), np.empty(len(first)))
    features = c.MovingFeatures(start=address(first), end=address(last), count=len(first), are_edges=flag(edges, "edges"),
                                separation=apart)
    c.call("sqmap_first_touch_features", features, c.Touches(time=address(out.time), touches=address(out.touches)))
    return out


def clearance(a: Body, b: Body) -> Clearance:
    """The least distance of two closed meshes, between any of their points. Both probes need triangles. One solid within the other is
    found by their models; a body whose model is None has no inside. status: bits as in Contacts. Cost: tens of microseconds for
    thousands of triangles."""
    out = c.Clearance()
    with _Bodies(*_with_probes(a, b)) as bodies:
        c.call("sqmap_query_clearance", bodies, out)
    return Clearance(out.distance, out.at_least, np.array(out.on_a[:]), np.array(out.on_b[:]), out.triangle_a, out.triangle_b,
                     out.status)


def is_within(a: Body, b: Body, distance: float) -> bool:
    """True where the bodies are at most this far apart, as clearance would find: it stops at the first triangles that are. Cost: less than
    clearance takes, much less where the answer is clear."""
    reach = number(distance, "distance")
    if not reach >= 0:
        raise refuse("distance", f"is {reach}", "give a number that is not below zero")
    if reach == 0:
        return clearance(a, b).distance == 0
    out = c.Clearance(within=reach)
    with _Bodies(*_with_probes(a, b)) as bodies:
        c.call("sqmap_query_clearance", bodies, out)
    return bool(out.is_within)


def overlap(a: Body, b: Body, workspace: Optional[Workspace] = None) -> Overlap:
    """The volume that two closed meshes share, exact from their triangles. Both probes need triangles. Calls with one workspace take
    turns. status: bits as in Contacts. Cost: linear in all triangles."""
    first, second = _with_probes(a, b)
    if workspace is None:
        with Workspace(1) as own:
            return overlap(a, b, own)
    instance(workspace, Workspace, "workspace")
    out = c.Overlap()
    with _Bodies(first, second) as bodies, workspace.turn, workspace.use("workspace") as handle:
        c.call("sqmap_query_overlap", bodies, handle, out)
    return Overlap(out.volume, out.error, out.status)


def separation(a: Body, b: Body, direction: Any = None, workspace: Optional[Workspace] = None) -> Separation:
    """How far b has to be moved until it is free of a: along a direction (3,), to the first gap; or, for None, the shortest
    translation in any direction that is known, of two convex solids the least of all. Both probes need triangles. Calls with one
    workspace take turns. status: bits as in Contacts. Cost: a millisecond for thousands of triangles along a direction, some ten
    without one."""
    first, second = _with_probes(a, b)
    along = np.zeros(3) if direction is None else numbers(direction, "direction")
    if along.shape != (3,):
        raise refuse("direction", f"has the shape {along.shape}", "give three numbers")
    if direction is not None and not (np.isfinite(along).all() and along.any()):
        raise refuse("direction", f"is {along.tolist()}", "give three finite numbers, not all zero")
    if workspace is None:
        with Workspace(1) as own:
            return separation(a, b, direction, own)
    instance(workspace, Workspace, "workspace")
    out = c.Separation()
    out.along[:] = along.tolist()
    with _Bodies(first, second) as bodies, workspace.turn, workspace.use("workspace") as handle:
        c.call("sqmap_query_separation", bodies, handle, out)
    return Separation(out.distance, out.at_least, np.array(out.direction[:]), bool(out.is_exact), out.status)


class Pile(Owned):
    """Many bodies in one world that move: poses in, complete contacts of all pairs out. Calls take turns.

    contacts: of a pair in one direction, for which there is space at first; it grows where a pair has more."""

    _closes = "sqmap_close_pile"

    def __init__(self, contacts: int = 4096) -> None:
        handle = c.Handle()
        c.call("sqmap_make_pile", count(contacts, "contacts"), handle)
        super().__init__(handle)

    def add(self, body: Body) -> int:
        """The body's number, the lowest that is free. Its probe needs triangles, and may be closed afterwards, as its model."""
        named = _named(body, "body")
        if named.probe is None:
            raise refuse("body.probe", "is None", "give a probe with triangles")
        out = ctypes.c_uint32()
        with _Bodies(named, _Named(None, None, None, ("", ""))) as bodies, self.turn, self.use() as handle:
            c.call("sqmap_add_body", handle, bodies.a, out)
        return out.value

    def remove(self, number: int) -> None:
        """Takes a body out; its number is given out again."""
        with self.turn, self.use() as handle:
            c.call("sqmap_remove_body", handle, count(number, "number", 2**32 - 1))

    def query(self, poses: Any = None, *, per_region: int = 0, first_only: bool = False, threads: Optional[int] = None) -> PileContacts:
        """Contacts of all pairs that are near each other, to the bit what query_contacts gives of each pair, whatever was queried
        before. poses: (n, 4, 4) of the bodies by their numbers; those from n on stay, as all do for None, and more poses than there are
        numbers are refused. per_region, first_only: as in query_contacts, of each pair. threads: None: one a core. status: bits of
        all pairs; 1 where a pose is not finite, whose body is near nothing. Cost: query_contacts of each pair, shared by the
        threads."""
        step = c.PileStep(threads=cores(threads), per_region=count(per_region, "per_region"),
                          is_first_only=flag(first_only, "first_only"))
        frames = None if poses is None else poses_of(poses)
        if frames is not None:
            step.pose, step.count = ctypes.cast(address(frames), ctypes.POINTER(c.Pose)), len(frames)
        out = c.PileContacts()
        with self.turn, self.use() as handle:
            c.call("sqmap_query_pile", handle, step, out)
            pairs = ctypes.string_at(out.pairs, out.pair_count * ctypes.sizeof(c.PilePair)) if out.pair_count else b""
            contacts = ctypes.string_at(out.contacts, out.count * ctypes.sizeof(c.SurfaceContact)) if out.count else b""
        return PileContacts(np.frombuffer(pairs, PILE_PAIR), np.frombuffer(contacts, SURFACE_CONTACT), out.near, out.status)


def _with_probes(a: Any, b: Any) -> tuple[_Named, _Named]:
    """Bodies that have probes."""
    named = _named(a, "a"), _named(b, "b")
    for body in named:
        if body.probe is None:
            raise refuse(body.names[1], "is None", "give a probe with triangles")
    return named
