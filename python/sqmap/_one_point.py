"""Calls of one point: memory that is kept between calls, because making and addressing arrays would cost more than the answer does."""
from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from . import _library as c


class OnePoint:
    """The point, the structs of a call and the arrays of its answers."""

    def __init__(self) -> None:
        self.xyz = np.empty((1, 3))
        self.distance, self.depth = np.empty(1), np.empty(1)
        self.direction, self.closest = np.empty((1, 3)), np.empty((1, 3))
        self.part, self.triangle = np.empty(1, np.int32), np.empty(1, np.int32)
        self.contact, self.certain = np.empty(1, np.bool_), np.empty(1, np.bool_)
        self.known, self.status = np.empty(1, np.uint8), np.empty(1, np.uint8)
        at = {name: array.ctypes.data for name, array in vars(self).items()}
        self.points = ctypes.byref(c.Points(xyz=at["xyz"], count=1))
        self.number = ctypes.c_double()  # read in a tenth of the time that an array takes
        self.length = ctypes.byref(c.Distances(distance=ctypes.addressof(self.number)))
        self.distances = ctypes.byref(c.Distances(distance=at["distance"], gradient=at["direction"], closest=at["closest"], part=at["part"],
                                                  known=at["known"], status=at["status"], triangle=at["triangle"]))
        self.nearest = ctypes.byref(c.Closest(closest=at["closest"], distance=at["distance"], triangle=at["triangle"]))
        self.contacts = ctypes.byref(c.Contacts(contact=at["contact"], depth=at["depth"], normal=at["direction"], closest=at["closest"],
                                                part=at["part"], certain=at["certain"], status=at["status"]))


#: Those that no call is using. A list's pop and append are one step each, so that threads and signal handlers never share one.
_FREE: list[OnePoint] = []


def taken(xyz: np.ndarray) -> OnePoint:
    """One that no other call has, with the point (1, 3) in it. give_back it when the answers are copied; one that is not is lost."""
    try:
        one = _FREE.pop()
    except IndexError:
        one = OnePoint()
    one.xyz[:] = xyz
    return one


def give_back(one: OnePoint) -> Any:
    _FREE.append(one)
