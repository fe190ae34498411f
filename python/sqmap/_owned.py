"""Handles of the library that objects own."""
from __future__ import annotations

import threading
from typing import Any

from . import _library as c
from ._arrays import refuse
from ._errors import ClosedError


class Owned:
    """A handle of the library: closed by close(), at the end of a with statement, or with the object.

    Any thread may close it: calls that are under way on others finish first.
    """

    _closes = ""

    def __init__(self, handle: c.Handle) -> None:
        if not isinstance(handle, c.Handle):
            raise refuse("handle", f"is a {type(handle).__name__}", "make one with sqmap.bake, Model.load or Model.from_bytes")
        self._handle = handle
        self._lock = threading.Lock()
        self.turn = threading.Lock()  # of what one thread at a time may use
        self._users = 0
        self._closed = False

    def __reduce__(self) -> Any:
        """A session belongs to its process, as all do that do not say what they are made of."""
        name = type(self).__name__
        raise refuse(name, "belongs to the process that made it", f"make a {name} in each process")

    def use(self, element: str = "") -> "_Use":
        """The open handle, for the length of a call. element: the argument that it came as, for errors."""
        return _Use(self, element)

    def _refusal(self, element: str = "") -> ClosedError:
        return ClosedError("E_HANDLE", element or type(self).__name__, "is closed", "open it again")

    def _leave(self) -> None:
        """Ends a call; the last one frees what was closed meanwhile."""
        with self._lock:
            self._users -= 1
            free = self._closed and self._users == 0
        if free:
            c.call(self._closes, self._handle)

    @property
    def closed(self) -> bool:
        return self._closed

    def close(self) -> None:
        """Closes it; a second time does nothing."""
        with self._lock:
            was, self._closed = self._closed, True
            free = not was and self._users == 0
        if free:
            c.call(self._closes, self._handle)

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __del__(self) -> None:
        try:
            self.close()
        except Exception:  # made half, or the interpreter is going down
            pass


class _Use:
    def __init__(self, owned: Owned, element: str) -> None:
        self._owned = owned
        self._element = element

    def __enter__(self) -> c.Handle:
        o = self._owned
        with o._lock:
            if o._closed:
                raise o._refusal(self._element)
            o._users += 1
        return o._handle

    def __exit__(self, *_: Any) -> None:
        self._owned._leave()
