"""Exceptions: each has a code, the element that is wrong and a cure."""
from __future__ import annotations

import re
from typing import Any


class Error(Exception):
    """Base of everything that sqmap raises.

    code: "E_ARGUMENT", "E_OPEN", ...; element: where ("points", "face 12", a path); cure: what helps.
    """

    def __init__(self, code: str, element: str, message: str, cure: str) -> None:
        super().__init__(f"{code}: {element} {message}\n  cure: {cure}")
        self.code = code
        self.element = element
        self.message = message
        self.cure = cure

    def __reduce__(self) -> Any:  # out of a pool's process it comes as it is
        return type(self), (self.code, self.element, self.message, self.cure)


class ArgumentError(Error, ValueError):
    """A shape, type or number that is not taken."""


class ClosedError(Error, ValueError):
    """A model, probe or session that is closed."""


class FileError(Error, OSError):
    """A file that cannot be read or written."""

    def __str__(self) -> str:  # OSError has one of its own; the element is a path, not the subject of the sentence
        return f"{self.code} at {self.element}: {self.message}\n  cure: {self.cure}"


class ModelError(Error, ValueError):
    """Bytes that are no model, cut short, or damaged."""


class VersionError(ModelError):
    """A model of another format version."""


class MeshError(Error, ValueError):
    """A mesh that is refused; the code says why."""

    def __str__(self) -> str:  # the element is a place, not the subject of the sentence
        return f"{self.code} at {self.element}: {self.message}\n  cure: {self.cure}"


class Cancelled(Error):
    """The progress callback stopped the bake."""


class MissingError(Error):
    """The model was baked without what the call needs."""


class NoMemoryError(Error, MemoryError):
    """There is not enough memory."""


class InternalError(Error, RuntimeError):
    """An error of the library itself."""


# Names of C that a caller of the package does not know: (pattern, name), the first that fits.
_ROTATION, _TRANSLATION = re.compile(r"\.rotation\[(\d)\]$"), re.compile(r"\.translation\[(\d)\]$")
_NAMES = [(re.compile(pattern), name) for pattern, name in (
    (r"^(points|tool)\.(xyz|count)\b", "points"), (r"^tool$", "points"), (r"^poses\.(pose|count)\b", "poses"),
    (r"^step\.(pose|count)\b", "poses"), (r"^separation\.along\b", "direction"), (r"^end_pose\b", "pose"), (r"^touch\.end_pose_a\b", "pose_a"), (r"^(points|tool|poses|options|simulation|step|tick)\.", ""), (r"^accepts_surface\b", "surface"), (r"^is_smooth\b", "smooth"),
    (r"^has_dead_man\b", "dead_man"), (r"^without_gaps\b", "gaps"), (r"^without_pruning\b", "pruning"),
    (r"^without_locator\b", "locator"),
    (r"\.(rotation|translation)$", ""))]
_PROBE_NAMES = {"bodies.a.model": "model", "bodies.a.pose": "model_pose", "bodies.b.probe": "probe", "bodies.b.pose": "pose"}


def argument_of(function: str, element: str) -> str:
    """The package's name of what a function of the library refuses: "points.pose.rotation[4]" is "pose[1, 1]"."""
    element = _ROTATION.sub(lambda m: f"[{int(m[1]) // 3}, {int(m[1]) % 3}]", element)
    element = _TRANSLATION.sub(r"[\1, 3]", element)
    if function == "sqmap_query_probe":
        for name, own in _PROBE_NAMES.items():
            if element.startswith(name):
                element = own + element[len(name):]
    if function == "sqmap_make_solid_probe":
        element = re.sub(r"^mesh\.vert(ices|ex_count)\b", "points", re.sub(r"^mesh\.triangle(s|_count)\b", "triangles", element))
    element = element.removeprefix("bodies.")
    for pattern, name in _NAMES:
        element = pattern.sub(name, element)
    return element


BY_CODE = {1: ArgumentError, 2: ClosedError, 3: FileError, 4: ModelError, 5: VersionError, 6: MeshError, 7: Cancelled,
           8: MissingError, 9: NoMemoryError, 10: InternalError}
