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


def superquadrics_of(model: Any) -> list[Superquadric]:
    """The superquadrics of all parts."""
    out = []
    for number, part in enumerate(model.parts):
        units = part["mesh_units"]
        out.append(Superquadric(model, number, np.array(units["a"], float), float(part["eps1"]), float(part["eps2"]),
                                np.array(part["rotation"], float), np.array(units["translation"], float),
                                np.array([part["Kx"], part["Ky"]], float), float(units["k"]), float(part["alpha"])))
    return out
