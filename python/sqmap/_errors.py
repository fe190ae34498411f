"""Exceptions: each has a code, the element that is wrong and a cure."""
from __future__ import annotations


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


class ArgumentError(Error, ValueError):
    """A shape, type or number that is not taken."""


class ClosedError(Error, ValueError):
    """A model, probe or session that is closed."""


class FileError(Error, OSError):
    """A file that cannot be read or written."""

    def __str__(self) -> str:  # OSError has one of its own
        return str(self.args[0])


class ModelError(Error, ValueError):
    """Bytes that are no model, cut short, or damaged."""


class VersionError(ModelError):
    """A model of another format version."""


class MeshError(Error, ValueError):
    """A mesh that is refused; the code says why."""


class Cancelled(Error):
    """The progress callback stopped the bake."""


class MissingError(Error):
    """The model was baked without what the call needs."""


class NoMemoryError(Error, MemoryError):
    """There is not enough memory."""


class InternalError(Error, RuntimeError):
    """An error of the library itself."""


BY_CODE = {1: ArgumentError, 2: ClosedError, 3: FileError, 4: ModelError, 5: VersionError, 6: MeshError, 7: Cancelled,
           8: MissingError, 9: NoMemoryError, 10: InternalError}
