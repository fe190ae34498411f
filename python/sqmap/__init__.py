"""sqmap: contact, penetration depth and signed distance of complex shapes, from small baked models.

>>> import numpy as np, sqmap
>>> model = sqmap.bake(sqmap.shapes.torus())     # or a path, arrays, an object of trimesh or Open3D
>>> model.signed_distance(np.zeros((1, 3)))      # positive inside
>>> model.query(np.zeros((1, 3))).depth

Points are (n, 3) arrays in the mesh's own frame and units; distances are positive inside in signed_distance (as trimesh's) and
negative inside in distances and Scene (as Open3D's). Batches use all cores and run without the GIL.
"""
from __future__ import annotations

from . import _library, shapes
from ._answers import Clearances, Contacts, Distances, Facts
from ._bake import CuredWarning, bake
from ._bodies import (CONTACT, PAIR_CONTACT, PILE_PAIR, SURFACE_CONTACT, Body, Clearance, FirstTouch, Overlap, PairContacts, Pile,
                      PileContacts, Probe, ProbeContacts, Separation, SurfaceContacts, Workspace, clearance, first_touch, first_touch_features, is_within,
                      overlap, query_contacts, query_pair, query_probe, separation)
from ._errors import (ArgumentError, Cancelled, ClosedError, Error, FileError, InternalError, MeshError, MissingError, ModelError,
                      NoMemoryError, VersionError)
from ._model import Model
from ._paper_options import PaperOptions
from ._program import program
from ._scene import Scene
from ._session import DISCONNECTED, HELD, RESTART, RESUME, STOP, Force, Session, Simulation
from ._superquadric import Superquadric
from ._tactile import TAXEL, TactilePad, Touch

__version__: str = _library.library.sqmap_version().decode()
#: Of the models that are read and written.
FORMAT_VERSION: int = _library.library.sqmap_format_version()

__all__ = ["ArgumentError", "Body", "CONTACT", "Cancelled", "Clearance", "Clearances", "ClosedError", "Contacts", "CuredWarning", "DISCONNECTED", "Distances",
           "Error", "FORMAT_VERSION", "Facts", "FileError", "FirstTouch", "Force", "HELD", "InternalError", "MeshError", "MissingError", "Model", "ModelError",
           "NoMemoryError", "Overlap", "PAIR_CONTACT", "PILE_PAIR", "PairContacts", "PaperOptions", "Pile", "PileContacts", "Probe", "ProbeContacts", "RESTART", "RESUME", "STOP", "Scene",
           "SURFACE_CONTACT", "Separation", "Session", "Simulation", "Superquadric", "SurfaceContacts", "TAXEL", "TactilePad", "Touch", "VersionError", "Workspace",
           "bake", "clearance", "first_touch", "first_touch_features", "is_within", "overlap", "program", "query_contacts", "query_pair", "query_probe", "separation", "shapes"]
