"""The superquadric that bounds a part."""
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Superquadric(NamedTuple):
    """A superquadric that holds a part of a model: eq. 1 and 2 of the paper. Lengths in mesh units.

    A local point is rotation (p - translation); tapering and bending are undone before F is taken."""

    model: Any                #: the Model
    part: int                 #: its number
    a: np.ndarray             #: (3,) semi-axes
    eps1: float               #: exponent, north-south
    eps2: float               #: exponent, east-west
    rotation: np.ndarray      #: (3, 3): its rows are the local axes
    translation: np.ndarray   #: (3,) centre
    taper: np.ndarray         #: (2,) along the local z axis
    bend: float               #: curvature, 1 / length; 0 is straight
    bend_angle: float         #: of the bend's plane about the local z axis, radians

    def implicit(self, points: Any, *, pose: Any = None) -> np.ndarray:
        """(n,) F of eq. 1 at points (n, 3): below 1 within the superquadric, 1 on its surface, above 1 outside; NaN of a point that is
        not finite. It is no distance. pose: from the mesh's frame to that of the points."""
        return self.model._implicit(self.part, points, pose)

    def __repr__(self) -> str:
        axes = ", ".join(f"{length:.4g}" for length in self.a)
        return f"<sqmap.Superquadric of part {self.part}, a ({axes}), eps ({self.eps1:.3g}, {self.eps2:.3g})>"


def _constant(values: Any) -> np.ndarray:
    """An array that many share, so that none may write it."""
    array = np.array(values, float)
    array.flags.writeable = False
    return array


def superquadrics_of(parts: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
    """The values of a Superquadric beside its model, of each part as Model.parts has it."""
    out: list[tuple[Any, ...]] = []
    for number, part in enumerate(parts):
        units = part["mesh_units"]
        out.append((number, _constant(units["a"]), float(part["eps1"]), float(part["eps2"]), _constant(part["rotation"]),
                    _constant(units["translation"]), _constant([part["Kx"], part["Ky"]]), float(units["k"]), float(part["alpha"])))
    return out
