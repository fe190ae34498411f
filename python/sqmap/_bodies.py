"""Probes and pairs: many points of a moving body per call."""
from __future__ import annotations

import ctypes
from typing import Any, NamedTuple, Optional

import numpy as np

from . import _library as c
from ._arrays import Layer, count, pointer, pose_of, query_options, refuse, rows
from ._model import Model, Owned, address, points_struct



def _rows_of(struct: type[ctypes.Structure], formats: dict[str, Any]) -> np.dtype:
    """The struct as NumPy sees it."""
    return np.dtype({"names": list(formats), "formats": list(formats.values()),
                     "offsets": [getattr(struct, name).offset for name in formats], "itemsize": ctypes.sizeof(struct)})


#: Rows of ProbeContacts.contacts. point: from anchor; index: of the probe's point.
CONTACT = _rows_of(c.Contact, {"point": ("f4", 3), "normal": ("f4", 3), "depth": "f4", "index": "u4", "part": "i2",
                               "certain": "?", "status": "u1"})
#: Rows of PairContacts.contacts. on_b = on_a - depth normal; vertex_of: 0 a vertex of a, 1 of b.
PAIR_CONTACT = _rows_of(c.PairContact, {"on_a": ("f8", 3), "on_b": ("f8", 3), "normal": ("f4", 3), "depth": "f4", "index": "u4",
                                        "part": "i2", "vertex_of": "u1", "certain": "?", "is_mutual": "?", "status": "u1"})


class Probe(Owned):
    """Points (n, 3) prepared once and queried many times: the vertices of a tool. Any number of threads may query it."""

    _closes = "sqmap_close_probe"

    def __init__(self, points: Any) -> None:
        xyz = rows(points)
        handle = c.Handle()
        c.call("sqmap_make_probe", points_struct(xyz), handle)
        super().__init__(handle)
        self._size = len(xyz)

    def __len__(self) -> int:
        return self._size


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


class Body:
    """A solid where it is: its model is touched, its probe touches; either may be None. Both are of one mesh.

    pose: a matrix (4, 4) from the mesh's frame to that of the poses; None: the same."""

    def __init__(self, model: Optional[Model] = None, probe: Optional[Probe] = None, pose: Any = None) -> None:
        if model is not None and not isinstance(model, Model):
            raise refuse("model", f"is a {type(model).__name__}", "give a Model")
        if probe is not None and not isinstance(probe, Probe):
            raise refuse("probe", f"is a {type(probe).__name__}", "give a Probe")
        self.model, self.probe, self.pose = model, probe, pose


class _Bodies:
    """Two bodies as the library takes them; their handles are open as long as this is entered."""

    def __init__(self, a: Body, b: Body) -> None:
        for body in (a, b):
            if not isinstance(body, Body):
                raise refuse("body", f"is a {type(body).__name__}", "give a Body")
        self._bodies = (a, b)
        self._poses = [pose_of(body.pose) for body in self._bodies]
        self._uses = [thing.use() for body in self._bodies for thing in (body.model, body.probe) if thing is not None]

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
        for body, pose in zip(self._bodies, self._poses):
            handles = [c.Handle(0) if thing is None else thing._handle for thing in (body.model, body.probe)]
            structs.append(c.Body(handles[0], handles[1], pointer(pose)))
        return c.Bodies(a=structs[0], b=structs[1])

    def __exit__(self, *_: Any) -> None:
        for use in self._uses:
            use.__exit__()


def query_probe(model: Model, probe: Probe, pose: Any = None, *, model_pose: Any = None, layer: Layer = 3, margin: float = 0.0,
                tolerance: float = 0.0, first_only: bool = False) -> ProbeContacts:
    """Which points of the probe are inside the model. pose, model_pose: matrices (4, 4) to the frame of the answers."""
    options = query_options(layer, margin=margin, tolerance=tolerance, first_only=first_only)
    contacts = np.empty(len(probe) if isinstance(probe, Probe) else 0, CONTACT)
    out = c.ContactList(contacts=address(contacts), capacity=len(contacts))
    with _Bodies(Body(model=model, pose=model_pose), Body(probe=probe, pose=pose)) as bodies:
        c.call("sqmap_query_probe", bodies, options, out)
    return ProbeContacts(contacts[: min(out.found, len(contacts))], np.array(out.anchor[:]), out.status)


class Workspace(Owned):
    """What pairs are computed in, best one for each thread. contacts: the largest number found in one direction."""

    _closes = "sqmap_close_workspace"

    def __init__(self, contacts: int = 65536) -> None:
        handle = c.Handle()
        c.call("sqmap_make_workspace", count(contacts, "contacts"), handle)
        super().__init__(handle)


def query_pair(a: Body, b: Body, workspace: Optional[Workspace] = None, *, layer: Layer = 3, margin: float = 0.0,
               tolerance: float = 0.0, first_only: bool = False) -> PairContacts:
    """Contacts of two bodies: each one's probe in the other's model, each contact once. Calls with one workspace take turns."""
    options = query_options(layer, margin=margin, tolerance=tolerance, first_only=first_only)
    if workspace is None:
        with Workspace(max([1, *(len(x.probe) for x in (a, b) if isinstance(x, Body) and x.probe is not None)])) as own:
            return query_pair(a, b, own, layer=layer, margin=margin, tolerance=tolerance, first_only=first_only)
    if not isinstance(workspace, Workspace):
        raise refuse("workspace", f"is a {type(workspace).__name__}", "give a Workspace")
    out = c.PairList()
    with _Bodies(a, b) as bodies, workspace.turn, workspace.use() as handle:
        c.call("sqmap_query_pair", bodies, options, handle, out)
        data = ctypes.string_at(out.contacts, out.count * ctypes.sizeof(c.PairContact)) if out.count else b""
    return PairContacts(np.frombuffer(data, PAIR_CONTACT), out.found, out.status)
