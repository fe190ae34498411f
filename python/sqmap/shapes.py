"""Closed meshes with known answers, to try the package on: bake(shapes.torus()).

Each is about the origin, counter-clockwise seen from outside, with its vertices on the exact surface, and says the signed distance of
that surface in closed form. Lengths are in any unit."""
from __future__ import annotations

from typing import Any, Callable

import numpy as np

from ._arrays import count, finite, numbers, refuse, rows

__all__ = ["box", "capsule", "sphere", "torus"]


class Shape:
    """A mesh: vertices (v, 3), triangles (t, 3) int64."""

    def __init__(self, vertices: Any, triangles: Any, distance: Callable[[np.ndarray], np.ndarray], volume: float, name: str) -> None:
        self.vertices: np.ndarray = vertices
        self.triangles: np.ndarray = triangles
        self.volume: float = volume  #: of the exact solid
        self._distance = distance
        self._name = name

    def signed_distance(self, points: Any) -> np.ndarray:
        """(n,) distances of points (n, 3) from the exact surface, positive inside. A mesh of flat triangles lies beside a round
        surface by the height of its arcs, so answers about it differ by as much. NaN of a point that is not finite."""
        xyz = rows(points)
        wrong = ~np.isfinite(xyz).all(axis=1)
        out = self._distance(np.where(wrong[:, None], 0.0, xyz))
        out[wrong] = np.nan
        return out

    def __repr__(self) -> str:
        return f"<sqmap.shapes.{self._name}, {len(self.vertices)} vertices, {len(self.triangles)} triangles>"


def _length(value: Any, element: str) -> float:
    out = finite(value, element)
    if out <= 0:
        raise refuse(element, f"is {value!r}", "give a length above 0")
    return out


def _number(value: Any, element: str, least: int, most: int) -> int:
    out = count(value, element, most)
    if out < least:
        raise refuse(element, f"is {value!r}", f"give an integer from {least} to {most}")
    return out


def _divided(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Four triangles for one; the new vertices are the middles of the edges."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = triangles.T
    ab, bc, ca = len(vertices) + number.reshape(3, -1)
    middle = (vertices[unique[:, 0]] + vertices[unique[:, 1]]) / 2
    divided = np.concatenate([np.stack(corners, 1) for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return np.concatenate([vertices, middle]), divided


def sphere(radius: float = 1.0, subdivisions: int = 4) -> Shape:
    """A sphere: an icosahedron split into 20 * 4^subdivisions triangles."""
    r = _length(radius, "radius")
    g = (1 + 5**0.5) / 2
    vertices = np.array([(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1),
                         (g, 0, 1), (-g, 0, -1), (-g, 0, 1)])
    triangles = np.array([(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
                          (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
                          (8, 6, 7), (9, 8, 1)], np.int64)
    for _ in range(_number(subdivisions, "subdivisions", 0, 8)):
        vertices, triangles = _divided(vertices, triangles)
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    vertices *= r / np.linalg.norm(vertices, axis=1, keepdims=True)
    return Shape(vertices, triangles, lambda p: r - np.linalg.norm(p, axis=1), 4 / 3 * np.pi * r**3, "sphere")


def torus(major_radius: float = 1.0, minor_radius: float = 0.25, major_segments: int = 96, minor_segments: int = 24) -> Shape:
    """A ring about z. major_radius: from the axis to the middle of the tube; minor_radius: of the tube, smaller."""
    major, minor = _length(major_radius, "major_radius"), _length(minor_radius, "minor_radius")
    if minor >= major:
        raise refuse("minor_radius", f"is {minor_radius!r}", "give less than major_radius")
    n, m = _number(major_segments, "major_segments", 3, 10**4), _number(minor_segments, "minor_segments", 3, 10**4)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    u, w = 2 * np.pi * i / n, 2 * np.pi * j / m
    radius = major + minor * np.cos(w)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), minor * np.sin(w)], -1).reshape(-1, 3)
    quads = _quads(i, j, n, m)
    return Shape(vertices, quads, lambda p: minor - np.hypot(np.hypot(p[:, 0], p[:, 1]) - major, p[:, 2]),
                 2 * np.pi**2 * major * minor**2, "torus")


def _quads(i: np.ndarray, j: np.ndarray, n: int, m: int) -> np.ndarray:
    """Two triangles for each square between rows i and columns j of a grid that closes both ways."""
    def at(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a % n) * m + b % m

    corners = np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], -1).reshape(-1, 4)
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]).astype(np.int64)


def box(extents: Any = (1.0, 1.0, 1.0), segments: int = 4) -> Shape:
    """A box of three extents, segments squares along each edge: flat, so that answers about the mesh are those in closed form."""
    lengths = numbers(extents, "extents")
    if lengths.shape != (3,):
        raise refuse("extents", f"has the shape {lengths.shape}", "give three lengths")
    half = np.array([_length(value, f"extents[{k}]") for k, value in enumerate(lengths.tolist())]) / 2
    n = _number(segments, "segments", 1, 500)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    corners = []
    for axis in range(3):
        for side in (0, n):
            square = np.zeros((len(i), 4, 3), np.int64)
            for k, (di, dj) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
                square[:, k, axis], square[:, k, (axis + 1) % 3], square[:, k, (axis + 2) % 3] = side, i + di, j + dj
            corners.append(square if side else square[:, ::-1])
    unique, number = np.unique(np.concatenate(corners).reshape(-1, 3), axis=0, return_inverse=True)
    quads = number.reshape(-1, 4)

    def distance(p: np.ndarray) -> np.ndarray:
        q = np.abs(p) - half
        return -np.linalg.norm(np.maximum(q, 0), axis=1) - np.minimum(q.max(axis=1), 0)

    return Shape((2 * unique / n - 1) * half, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int64), distance,
                 float(8 * half.prod()), "box")


def capsule(radius: float = 0.5, half_length: float = 1.0, segments: int = 48) -> Shape:
    """All points within radius of the segment from -half_length to half_length along z; segments: around the axis."""
    r, half = _length(radius, "radius"), _length(half_length, "half_length")
    n = _number(segments, "segments", 3, 10**4)
    latitudes = np.pi * np.arange(1, n // 2) / (2 * (n // 2))  # from a pole to the equator, both left out
    rings = np.concatenate([latitudes, [np.pi / 2]]) if n > 3 else np.array([np.pi / 2])
    z = np.concatenate([half + r * np.cos(rings), -half - r * np.cos(rings[::-1])])
    around = np.concatenate([r * np.sin(rings), r * np.sin(rings[::-1])])
    u = 2 * np.pi * np.arange(n) / n
    grid = np.stack(np.broadcast_arrays(around[:, None] * np.cos(u), around[:, None] * np.sin(u), z[:, None]), -1).reshape(-1, 3)
    vertices = np.concatenate([grid, [[0, 0, half + r], [0, 0, -half - r]]])
    last = (len(z) - 1) * n
    a, b = np.arange(n), (np.arange(n) + 1) % n
    caps = [np.stack([np.full(n, len(grid)), a, b], 1), np.stack([np.full(n, len(grid) + 1), last + b, last + a], 1)]
    for ring in range(len(z) - 1):
        upper, lower = ring * n, ring * n + n
        caps += [np.stack([upper + a, lower + a, lower + b], 1), np.stack([upper + a, lower + b, upper + b], 1)]

    def distance(p: np.ndarray) -> np.ndarray:
        return r - np.sqrt(p[:, 0]**2 + p[:, 1]**2 + np.maximum(np.abs(p[:, 2]) - half, 0)**2)

    return Shape(vertices, np.concatenate(caps).astype(np.int64), distance, float(np.pi * r**2 * (2 * half + 4 / 3 * r)), "capsule")
