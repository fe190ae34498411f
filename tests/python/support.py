"""Meshes with known answers, and what every test of the package needs."""
import functools

import numpy as np
import sqmap

COARSE = {"target_error": 5, "max_parts": 1}  # for tests whose answers come from the triangles, not from maps and superquadrics


@functools.lru_cache(None)
def ball(levels=3):
    """(vertices, triangles) of a sphere of radius 1: a divided icosahedron."""
    g = (1 + 5 ** 0.5) / 2
    v = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1),
         (-g, 0, -1), (-g, 0, 1)]
    t = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
         (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    v = [np.array(p) / np.linalg.norm(p) for p in v]
    for _ in range(levels):
        middle, divided = {}, []

        def half(i, j):
            key = (min(i, j), max(i, j))
            if key not in middle:
                p = v[i] + v[j]
                v.append(p / np.linalg.norm(p))
                middle[key] = len(v) - 1
            return middle[key]

        for a, b, c in t:
            ab, bc, ca = half(a, b), half(b, c), half(c, a)
            divided += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        t = divided
    return np.array(v), np.array(t, np.int64)


@functools.lru_cache(None)
def torus(rows=32, columns=20, major=1.0, minor=0.4):
    """(vertices, triangles) of a ring about z."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    u, w = 2 * np.pi * i / rows, 2 * np.pi * j / columns
    vertices = np.stack([(major + minor * np.cos(w)) * np.cos(u), (major + minor * np.cos(w)) * np.sin(u), minor * np.sin(w)], -1)
    at = lambda a, b: (a % rows) * columns + b % columns  # noqa: E731
    quads = np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], -1).reshape(-1, 4)
    return vertices.reshape(-1, 3), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int64)


@functools.lru_cache(None)
def ball_model():
    return sqmap.bake(ball())


@functools.lru_cache(None)
def torus_model():
    return sqmap.bake(torus())


def moved(x, y, z):
    out = np.eye(4)
    out[:3, 3] = x, y, z
    return out
