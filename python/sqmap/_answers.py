"""Answers of a model, row by row."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np


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
    is_normal: bool     #: a paper model: baked with projection="normal"
    is_doubtful: bool   #: layer 3 has wrong verdicts, or a 99th percentile of its depth error above 0.5 % of R_max: layer="auto" is exact
    has_input: bool     #: the mesh's own coordinates and numbers are kept: exact distances are in double
    cure: str           #: how the mesh became a solid: "" as it was given or repaired, "closed" or "wrapped"
