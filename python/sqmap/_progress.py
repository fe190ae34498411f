"""Bakes that can be watched and stopped."""
from __future__ import annotations

import queue
import sys
import threading
from typing import Any, Callable, Optional, Union

from . import _library as c
from ._arrays import refuse
from ._errors import Cancelled

Progress = Callable[[str, float], Any]


class _Bar:
    """A bar on standard error; where that is no terminal and no notebook, a line a stage."""

    _WIDTH = 30

    def __init__(self) -> None:
        self._redraws = sys.stderr.isatty() or "ipykernel" in sys.modules
        self._stage = ""

    def __call__(self, stage: str, done: float) -> None:
        if self._redraws:
            filled = round(self._WIDTH * done)
            print(f"\r{stage:<10} [{'#' * filled}{' ' * (self._WIDTH - filled)}] {done:4.0%}", end="", file=sys.stderr, flush=True)
        elif stage != self._stage:
            print(stage, file=sys.stderr, flush=True)
        self._stage = stage

    def end(self) -> None:
        """Ends the line."""
        if self._redraws and self._stage:
            print(file=sys.stderr, flush=True)


class _Bake:
    """A bake on a thread of its own: the caller's thread waits for it, calls the callback and takes signals."""

    def __init__(self, callback: Optional[Progress]) -> None:
        self._callback = callback
        self._events: queue.SimpleQueue[Any] = queue.SimpleQueue()  # (stage, done), in the end the model or an exception
        self._answers: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._is_left = False  # the caller has gone: the next stage stops

    def step(self, _context: Any, stage: bytes, done: float) -> int:
        """The library's callback."""
        if self._is_left or self._callback is None:
            return int(self._is_left)
        self._events.put((stage.decode(), done))
        return self._answers.get()

    def work(self, bake: Callable[[], Any]) -> None:
        """The bake's thread."""
        try:
            self._events.put(bake())  # a model that nobody waits for closes itself
        except BaseException as e:
            self._events.put(e)

    def wait(self) -> Any:
        """The caller's thread."""
        raised: Optional[BaseException] = None
        try:
            while isinstance(event := self._events.get(), tuple):
                answer = 1
                try:
                    assert self._callback is not None
                    answer = 1 if self._callback(*event) else 0
                except BaseException as e:
                    raised = e
                finally:
                    self._answers.put(answer)
        except BaseException:  # Ctrl-C
            self._is_left = True
            self._answers.put(1)
            raise
        if isinstance(event, Cancelled) and raised is not None:
            raise raised from None
        if isinstance(event, BaseException):
            raise event
        return event


def run(bake: Callable[[Any], Any], progress: Union[bool, Progress, None]) -> Any:
    """The result of bake, a function that is given the library's callback."""
    bar = _Bar() if progress is True else None
    callback = bar or (None if progress is False else progress)
    if callback is not None and not callable(callback):
        raise refuse("progress", f"is {progress!r}", "give True for a bar, or a function of a stage's name and the share that is done")
    job = _Bake(callback)
    thread = threading.Thread(target=job.work, args=(lambda: bake(c.PROGRESS(job.step)),), name="sqmap.bake")
    thread.start()
    try:
        return job.wait()
    finally:
        if bar is not None:
            bar.end()
