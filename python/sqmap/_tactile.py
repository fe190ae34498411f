"""Tactile pads: normal and shear force of each taxel."""
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from . import _library as c
from ._arrays import address, points_struct, Layer, flag, instance, number, pointer, pose_of, query_options, refuse, rows
from ._bodies import _rows_of
from ._model import Model
from ._owned import Owned

#: Rows of Touch.taxels.
TAXEL = _rows_of(c.Taxel, {"normal": "f4", "shear": ("f4", 3), "depth": "f4"})


class Touch(NamedTuple):
    """The readings of a pad of n taxels in one tick; in the pad's frame."""

    taxels: np.ndarray  #: (n,) rows of TAXEL: normal, never negative; shear (3,), perpendicular to the taxel's normal; depth
    contacts: int       #: taxels inside the model
    force: np.ndarray   #: (3,) on the pad
    torque: np.ndarray  #: (3,) about its origin
    status: int         #: bits, as in Contacts


class TactilePad(Owned):
    """Taxels at points (n, 3) with outward normals (n, 3), in the pad's frame. Calls of one pad take turns.

    tactile_kn: force per depth; tactile_kt: per speed of slip, up to tactile_mu times the normal force; tactile_damping: per speed
    along the surface's normal. Names and model are TacSL's."""

    _closes = "sqmap_close_pad"

    def __init__(self, points: Any, normals: Any, *, tactile_kn: float = 1.0, tactile_kt: float = 0.1, tactile_mu: float = 0.5,
                 tactile_damping: float = 0.0, layer: Layer = 3) -> None:
        at, outward = rows(points), rows(normals, "normals")
        if at.shape != outward.shape:
            raise refuse("normals", f"has the shape {outward.shape}", f"give one for each point: {at.shape}")
        options = c.PadOptions(layer=query_options(layer).layer, tactile_damping=number(tactile_damping, "tactile_damping"))
        for name, given in (("tactile_kn", tactile_kn), ("tactile_kt", tactile_kt), ("tactile_mu", tactile_mu)):
            value = number(given, name)
            if not value >= 0:
                raise refuse(name, f"is {value}", "give a number from 0")
            setattr(options, name, value if value > 0 else -1.0)  # zero stands for the library's default
        handle = c.Handle()
        c.call("sqmap_make_pad", points_struct(at), address(outward), options, handle)
        super().__init__(handle)
        self._size = len(at)

    def __len__(self) -> int:
        return self._size

    def tick(self, model: Model, pose: Any = None, dt: float = 0.0, *, model_pose: Any = None, restart: bool = False) -> Touch:
        """One tick. pose, model_pose: matrices (4, 4) to a common frame; dt: since the tick before, s. Slip is the motion over the
        model since then; restart: the pad was lifted and set elsewhere, there is none."""
        instance(model, Model, "model")
        taxels = np.empty(self._size, TAXEL)
        out = c.Taxels(taxels=address(taxels), count=self._size)
        own, other = pose_of(pose), pose_of(model_pose, "model_pose")
        with model.use("model") as touched, self.turn, self.use() as handle:
            tick = c.PadTick(model=touched, model_pose=pointer(other), pose=pointer(own), dt=number(dt, "dt"),
                             restarts=flag(restart, "restart"))
            c.call("sqmap_tick_pad", handle, tick, out)
        return Touch(taxels, out.contacts, np.array(out.force[:]), np.array(out.torque[:]), out.status)
