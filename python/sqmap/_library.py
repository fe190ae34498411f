"""libsqmap by ctypes: the structs and functions of sqmap.h, name by name. Calls run without the GIL."""
from __future__ import annotations

import ctypes
import os
import pathlib
from ctypes import (CFUNCTYPE, POINTER, Structure, c_char_p, c_double, c_float, c_int16, c_int32, c_size_t, c_uint8,
                    c_uint32, c_uint64, c_void_p)
from typing import Any

from ._errors import BY_CODE, Error, argument_of

HERE = pathlib.Path(__file__).resolve().parent
PROGRESS = CFUNCTYPE(c_int32, c_void_p, c_char_p, c_double)


class Sized(Structure):
    """A struct whose first member is its size."""

    def __init__(self, **members: Any) -> None:
        super().__init__(**members)
        self.size = ctypes.sizeof(self)


class ErrorStruct(Structure):
    _fields_ = [("size", c_size_t), ("code", c_int32), ("name", c_char_p), ("element", c_char_p), ("message", c_char_p),
                ("cure", c_char_p)]


class Text(Sized):
    _fields_ = [("size", c_size_t), ("text", c_char_p), ("capacity", c_size_t), ("needed", c_size_t), ("words", c_int32)]


class Handle(Structure):
    """sqmap_model, sqmap_probe, sqmap_workspace, sqmap_session, sqmap_pad, sqmap_pile."""
    _fields_ = [("id", c_uint64)]


class Mesh(Sized):
    _fields_ = [("size", c_size_t), ("vertices", c_void_p), ("vertex_count", c_size_t), ("triangles", c_void_p),
                ("triangle_count", c_size_t)]


class PaperOptions(Sized):
    _fields_ = [("size", c_size_t), ("without_taper", c_int32), ("without_bend", c_int32), ("cuts", c_int32), ("exact_geodesics", c_int32),
                ("protrusion_sources", c_uint32),
                *((name, c_double) for name in ("salient_window", "salient_prominence", "locale_width", "boundary_strength", "protrusion_ratio",
                                                "curvature_window", "hyperbolic_curvature", "boundary_concavity", "curvature_floor",
                                                "hyperbolic_share", "minimum_part", "fragment_roundness")),
                ("mean_curvature", c_int32), ("printed_strength", c_double), ("printed_curvature", c_double), ("max_looseness", c_double),
                ("max_q2", c_double), ("rows", c_uint32), ("columns", c_uint32), ("subdivisions", c_int32), ("offset_constant", c_double),
                ("offset_radius", c_int32), ("smoothing", c_int32), ("smoothing_length", c_double), ("smoothing_radius", c_int32),
                ("smoothing_kernel", c_int32)]


class BakeOptions(Sized):
    _fields_ = [("size", c_size_t), ("target_error", c_double), ("band", c_double), ("thickness", c_double),
                ("max_parts", c_uint32), ("projection", c_int32), ("repair", c_int32), ("accepts_surface", c_int32),
                ("without_exact", c_int32), ("threads", c_uint32), ("progress", PROGRESS), ("progress_context", c_void_p),
                ("source", c_char_p), ("words", c_int32), ("without_input", c_int32), ("unit", c_double),
                ("gap", c_double), ("wrap_tolerance", c_double), ("solid", c_int32), ("paper", POINTER(PaperOptions)),
                ("without_locator", c_int32)]


class Facts(Sized):
    _fields_ = [("size", c_size_t), ("r_max", c_double), ("band", c_double), ("centre", c_double * 3), ("radius", c_double),
                ("bytes", c_uint64), ("parts", c_uint32), ("vertices", c_uint32), ("triangles", c_uint32), ("is_solid", c_int32),
                ("has_exact", c_int32), ("is_normal", c_int32), ("is_doubtful", c_int32), ("has_input", c_int32),
                ("cure", c_int32)]


class ExportOptions(Sized):
    _fields_ = [("size", c_size_t), ("format", c_int32), ("shape", c_int32), ("spheres", c_uint32), ("threads", c_uint32)]


class Pose(Structure):
    _fields_ = [("rotation", c_double * 9), ("translation", c_double * 3)]


class QueryOptions(Sized):
    _fields_ = [("size", c_size_t), ("layer", c_int32), ("threads", c_uint32), ("tolerance", c_double), ("margin", c_double),
                ("band", c_double), ("is_smooth", c_int32), ("is_first_only", c_int32), ("gate", c_uint32), ("has_offset", c_int32),
                ("projector", c_int32), ("nearest_steps", c_int32), ("without_gaps", c_int32), ("without_pruning", c_int32)]


class Points(Sized):
    _fields_ = [("size", c_size_t), ("xyz", c_void_p), ("count", c_size_t), ("pose", POINTER(Pose))]


class Contacts(Sized):
    _fields_ = [("size", c_size_t), ("contact", c_void_p), ("depth", c_void_p), ("normal", c_void_p), ("closest", c_void_p),
                ("part", c_void_p), ("certain", c_void_p), ("status", c_void_p), ("contacts", c_size_t)]


class Distances(Sized):
    _fields_ = [("size", c_size_t), ("distance", c_void_p), ("gradient", c_void_p), ("closest", c_void_p), ("part", c_void_p),
                ("known", c_void_p), ("status", c_void_p), ("triangle", c_void_p)]


class Closest(Sized):
    _fields_ = [("size", c_size_t), ("closest", c_void_p), ("distance", c_void_p), ("triangle", c_void_p)]


class Poses(Sized):
    _fields_ = [("size", c_size_t), ("pose", POINTER(Pose)), ("count", c_size_t), ("threads", c_uint32), ("band", c_double), ("stops", c_int32),
                ("stop_below", c_double)]


class PoseClearances(Sized):
    _fields_ = [("size", c_size_t), ("distance", c_void_p), ("gradient", c_void_p), ("point", c_void_p), ("closest", c_void_p),
                ("index", c_void_p), ("part", c_void_p), ("known", c_void_p), ("complete", c_void_p), ("status", c_void_p)]


class Contact(Structure):
    _fields_ = [("point", c_float * 3), ("normal", c_float * 3), ("depth", c_float), ("index", c_uint32), ("part", c_int16),
                ("certain", c_uint8), ("status", c_uint8)]


class ContactList(Sized):
    _fields_ = [("size", c_size_t), ("contacts", c_void_p), ("capacity", c_size_t), ("found", c_size_t),
                ("anchor", c_double * 3), ("status", c_uint32)]


class Body(Structure):
    _fields_ = [("model", Handle), ("probe", Handle), ("pose", POINTER(Pose))]


class Bodies(Sized):
    _fields_ = [("size", c_size_t), ("a", Body), ("b", Body)]


class PairContact(Structure):
    _fields_ = [("on_a", c_double * 3), ("on_b", c_double * 3), ("normal", c_float * 3), ("depth", c_float),
                ("index", c_uint32), ("part", c_int16), ("vertex_of", c_uint8), ("certain", c_uint8), ("is_mutual", c_uint8),
                ("status", c_uint8)]


class PairList(Sized):
    _fields_ = [("size", c_size_t), ("contacts", c_void_p), ("count", c_size_t), ("found", c_size_t), ("status", c_uint32),
                ("edge_length", c_double)]


class SurfaceContact(Structure):
    _fields_ = [("on_a", c_double * 3), ("on_b", c_double * 3), ("normal", c_float * 3), ("depth", c_float),
                ("feature_a", c_uint8), ("feature_b", c_uint8), ("index_a", c_uint32), ("index_b", c_uint32),
                ("region", c_uint32), ("part_a", c_int16), ("part_b", c_int16), ("certain", c_uint8), ("status", c_uint8)]


class ContactOptions(Sized):
    _fields_ = [("size", c_size_t), ("per_region", c_uint32), ("is_first_only", c_int32)]


class SurfaceList(Sized):
    _fields_ = [("size", c_size_t), ("contacts", c_void_p), ("count", c_size_t), ("found", c_size_t), ("meetings", c_size_t),
                ("regions", c_size_t), ("status", c_uint32)]


class Clearance(Sized):
    _fields_ = [("size", c_size_t), ("within", c_double), ("distance", c_double), ("at_least", c_double), ("on_a", c_double * 3),
                ("on_b", c_double * 3), ("triangle_a", c_uint32), ("triangle_b", c_uint32), ("is_within", c_int32),
                ("status", c_uint32)]


class Overlap(Sized):
    _fields_ = [("size", c_size_t), ("volume", c_double), ("error", c_double), ("status", c_uint32)]


class Separation(Sized):
    _fields_ = [("size", c_size_t), ("along", c_double * 3), ("distance", c_double), ("at_least", c_double),
                ("direction", c_double * 3), ("is_exact", c_int32), ("status", c_uint32)]


class PileStep(Sized):
    _fields_ = [("size", c_size_t), ("pose", POINTER(Pose)), ("count", c_size_t), ("threads", c_uint32), ("per_region", c_uint32),
                ("is_first_only", c_int32)]


class PilePair(Structure):
    _fields_ = [("a", c_uint32), ("b", c_uint32), ("first", c_size_t), ("count", c_size_t), ("found", c_size_t),
                ("meetings", c_size_t), ("regions", c_size_t), ("status", c_uint8)]


class PileContacts(Sized):
    _fields_ = [("size", c_size_t), ("pairs", c_void_p), ("contacts", c_void_p), ("pair_count", c_size_t), ("count", c_size_t),
                ("near", c_size_t), ("status", c_uint32)]


class Touch(Sized):
    _fields_ = [("size", c_size_t), ("time", c_double), ("touches", c_int32), ("status", c_uint32), ("end_pose_a", POINTER(Pose))]


class MovingFeatures(Sized):
    _fields_ = [("size", c_size_t), ("start", c_void_p), ("end", c_void_p), ("count", c_size_t), ("are_edges", c_int32),
                ("separation", c_double)]


class Touches(Sized):
    _fields_ = [("size", c_size_t), ("time", c_void_p), ("touches", c_void_p)]


class SessionOptions(Sized):
    _fields_ = [("size", c_size_t), ("metres_per_unit", c_double), ("pose", POINTER(Pose)), ("radius", c_double),
                ("stiffness", c_double), ("damping", c_double), ("friction", c_double), ("layer", c_int32),
                ("max_force", c_double), ("max_torque", c_double), ("continuous_force", c_double), ("force_limit", c_double),
                ("torque_limit", c_double), ("has_dead_man", c_int32), ("side_path", c_double), ("mode", c_int32), ("force", c_int32),
                ("friction_law", c_int32), ("f_c", c_double), ("k_f", c_double), ("projector", c_int32), ("gate", c_uint32),
                ("nearest_steps", c_int32), ("without_gaps", c_int32), ("without_pruning", c_int32), ("has_offset", c_int32),
                ("tool", Handle), ("without_edges", c_int32), ("zone", c_double)]


class Tick(Sized):
    _fields_ = [("size", c_size_t), ("time", c_double), ("sample_time", c_double), ("sequence", c_uint64), ("pose", Pose),
                ("acts", c_uint32)]


class Force(Sized):
    _fields_ = [("size", c_size_t), ("force", c_double * 3), ("torque", c_double * 3), ("commanded", c_double * 3),
                ("depth", c_double), ("normal", c_double * 3), ("status", c_uint32), ("acted", c_uint32), ("faults", c_uint32),
                ("is_engaged", c_int32), ("tool", Pose)]


class Simulation(Sized):
    _fields_ = [("size", c_size_t), ("targets", c_void_p), ("count", c_size_t), ("positions", c_void_p), ("forces", c_void_p),
                ("depths", c_void_p), ("tools", c_void_p)]


class PadOptions(Sized):
    _fields_ = [("size", c_size_t), ("tactile_kn", c_double), ("tactile_kt", c_double), ("tactile_mu", c_double),
                ("tactile_damping", c_double), ("layer", c_int32)]


class PadTick(Sized):
    _fields_ = [("size", c_size_t), ("model", Handle), ("model_pose", POINTER(Pose)), ("pose", POINTER(Pose)), ("dt", c_double),
                ("restarts", c_int32)]


class Taxel(Structure):
    _fields_ = [("normal", c_float), ("shear", c_float * 3), ("depth", c_float)]


class Taxels(Sized):
    _fields_ = [("size", c_size_t), ("taxels", c_void_p), ("count", c_size_t), ("contacts", c_size_t), ("force", c_double * 3),
                ("torque", c_double * 3), ("status", c_uint32)]


# Functions that return a code: their parameters.
FUNCTIONS: dict[str, list[Any]] = {
    "sqmap_open": [c_char_p, POINTER(Handle)],
    "sqmap_open_archived": [c_char_p, c_char_p, POINTER(Handle)],
    "sqmap_open_bytes": [c_void_p, c_size_t, POINTER(Handle)],
    "sqmap_bake": [POINTER(Mesh), POINTER(BakeOptions), POINTER(Handle)],
    "sqmap_bake_file": [c_char_p, POINTER(BakeOptions), POINTER(Handle)],
    "sqmap_option_range": [c_char_p, POINTER(c_double), POINTER(c_double)],
    "sqmap_save": [Handle, c_char_p],
    "sqmap_bytes": [Handle, POINTER(c_void_p), POINTER(c_size_t)],
    "sqmap_model_facts": [Handle, POINTER(Facts)],
    "sqmap_info": [Handle, POINTER(Text)],
    "sqmap_notes": [Handle, POINTER(Text)],
    "sqmap_sources": [Handle, c_void_p, c_void_p],
    "sqmap_triangles": [Handle, c_void_p, c_void_p, c_void_p],
    "sqmap_close_model": [Handle],
    "sqmap_export": [Handle, c_char_p, POINTER(ExportOptions), POINTER(Text)],
    "sqmap_query_points": [Handle, POINTER(Points), POINTER(QueryOptions), POINTER(Contacts)],
    "sqmap_exact_distances": [Handle, POINTER(Points), POINTER(QueryOptions), POINTER(Distances)],
    "sqmap_signed_distances": [Handle, POINTER(Points), POINTER(QueryOptions), POINTER(Distances)],
    "sqmap_closest_points": [Handle, POINTER(Points), POINTER(QueryOptions), POINTER(Closest)],
    "sqmap_implicit": [Handle, c_uint32, POINTER(Points), c_void_p],
    "sqmap_query_poses": [Handle, POINTER(Points), POINTER(Poses), POINTER(PoseClearances)],
    "sqmap_make_probe": [POINTER(Points), POINTER(Handle)],
    "sqmap_close_probe": [Handle],
    "sqmap_query_probe": [POINTER(Bodies), POINTER(QueryOptions), POINTER(ContactList)],
    "sqmap_make_workspace": [c_size_t, POINTER(Handle)],
    "sqmap_close_workspace": [Handle],
    "sqmap_query_pair": [POINTER(Bodies), POINTER(QueryOptions), Handle, POINTER(PairList)],
    "sqmap_make_solid_probe": [POINTER(Mesh), POINTER(Handle)],
    "sqmap_query_contacts": [POINTER(Bodies), POINTER(ContactOptions), Handle, POINTER(SurfaceList)],
    "sqmap_first_touch": [POINTER(Bodies), POINTER(Pose), POINTER(Touch)],
    "sqmap_first_touch_features": [POINTER(MovingFeatures), POINTER(Touches)],
    "sqmap_query_clearance": [POINTER(Bodies), POINTER(Clearance)],
    "sqmap_query_overlap": [POINTER(Bodies), Handle, POINTER(Overlap)],
    "sqmap_query_separation": [POINTER(Bodies), Handle, POINTER(Separation)],
    "sqmap_make_pile": [c_size_t, POINTER(Handle)],
    "sqmap_close_pile": [Handle],
    "sqmap_add_body": [Handle, POINTER(Body), POINTER(c_uint32)],
    "sqmap_remove_body": [Handle, c_uint32],
    "sqmap_query_pile": [Handle, POINTER(PileStep), POINTER(PileContacts)],
    "sqmap_make_session": [Handle, POINTER(SessionOptions), POINTER(Handle)],
    "sqmap_tick_session": [Handle, POINTER(Tick), POINTER(Force)],
    "sqmap_simulate": [Handle, POINTER(Simulation)],
    "sqmap_close_session": [Handle],
    "sqmap_make_pad": [POINTER(Points), c_void_p, POINTER(PadOptions), POINTER(Handle)],
    "sqmap_tick_pad": [Handle, POINTER(PadTick), POINTER(Taxels)],
    "sqmap_close_pad": [Handle],
}


def _load() -> ctypes.CDLL:
    named = os.environ.get("SQMAP_LIBRARY")
    own = HERE / "_lib" / "libsqmap.so.0"
    library = ctypes.CDLL(named or (str(own) if own.exists() else "libsqmap.so.0"))
    for name, parameters in FUNCTIONS.items():
        function = getattr(library, name)
        function.argtypes, function.restype = parameters, c_int32
    library.sqmap_last_error.argtypes, library.sqmap_last_error.restype = [], POINTER(ErrorStruct)
    library.sqmap_last_cure.argtypes, library.sqmap_last_cure.restype = [c_int32], c_char_p
    library.sqmap_version.argtypes, library.sqmap_version.restype = [], c_char_p
    library.sqmap_format_version.argtypes, library.sqmap_format_version.restype = [], c_uint32
    return library


library = _load()
#: sqmap_words: names of settings in messages are those of this package.
WORDS = 1


def last_error(function: str) -> Error:
    """The exception that this thread's last failed call stands for, in the words of the package."""
    e = library.sqmap_last_error().contents
    name, element, message, cure = (text.decode("utf-8", "replace")
                                    for text in (e.name, e.element, e.message, library.sqmap_last_cure(WORDS)))
    return BY_CODE[e.code](name, argument_of(function, element), message, cure)


def call(name: str, *arguments: Any) -> None:
    """Calls a function of the library; raises what it fails with."""
    if getattr(library, name)(*arguments) != 0:
        raise last_error(name)


def text_of(name: str, handle: Handle) -> str:
    """The whole text that a function gives."""
    out = Text(words=WORDS)
    call(name, handle, out)
    buffer = ctypes.create_string_buffer(out.needed)
    out.text, out.capacity = ctypes.cast(buffer, c_char_p), out.needed
    call(name, handle, out)
    return buffer.value.decode("utf-8", "replace")


def option_range(name: str) -> tuple[float, float]:
    """The least and the greatest value of a number among the options of a bake; also of "nearest_steps"."""
    least, most = c_double(), c_double()
    call("sqmap_option_range", name.encode(), least, most)
    return least.value, most.value
