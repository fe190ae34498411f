"""Signed distance with Open3D's names, shapes and sign."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from ._arrays import count, instance, numbers, refuse
from ._model import Model, bake


class Scene:
    """Closed meshes as one solid, with the functions of open3d.t.geometry.RaycastingScene that compute distances.

    Points are arrays of shape {..., 3}; answers have the leading shape, in NumPy arrays. Distances are negative inside. Several
    geometries count as their union: the least distance, exact outside and where they do not overlap."""

    INVALID_ID = 0xFFFFFFFF

    def __init__(self, *models: Model) -> None:
        self._models: list[Model] = []
        for model in models:
            self.add_model(model)

    def add_model(self, model: Model) -> int:
        """Adds a baked model; its number."""
        with instance(model, Model, "model").use("model"):
            self._models.append(model)
        return len(self._models) - 1

    def add_triangles(self, vertices: Any, triangles: Optional[Any] = None, **options: Any) -> int:
        """Bakes a mesh, (vertices, triangles) or an object with both, and adds it; its number. options: of sqmap.bake."""
        return self.add_model(bake(vertices if triangles is None else (vertices, triangles), **options))

    def compute_signed_distance(self, query_points: Any, nthreads: int = 0) -> np.ndarray:
        """{...}: to the nearest surface, negative inside. nthreads: 0 is one a core."""
        xyz, shape = self._points(query_points)
        out = np.full(len(xyz), np.inf)
        for model in self._models:
            out = np.minimum(out, -model.signed_distance(xyz, threads=_threads(nthreads)))
        return out.reshape(shape)

    def compute_distance(self, query_points: Any, nthreads: int = 0) -> np.ndarray:
        """{...}: to the nearest surface, never negative."""
        return np.abs(self.compute_signed_distance(query_points, nthreads))

    def compute_occupancy(self, query_points: Any, nthreads: int = 0) -> np.ndarray:
        """{...} float32: 1 inside, 0 outside, by the triangles. Raises ArgumentError for a point that is not finite."""
        xyz, shape = self._points(query_points)
        out = np.zeros(len(xyz), np.bool_)
        for model in self._models:
            out |= model._contains(xyz, _threads(nthreads), "query_points")
        return out.astype(np.float32).reshape(shape)

    def compute_closest_points(self, query_points: Any, nthreads: int = 0) -> dict[str, np.ndarray]:
        """points {..., 3}, geometry_ids {...}, primitive_ids {...} (uint32; of Model.mesh), primitive_uvs {..., 2},
        primitive_normals {..., 3}."""
        xyz, shape = self._points(query_points)
        n = len(xyz)
        points, best = np.full((n, 3), np.nan), np.full(n, np.inf)
        geometry, primitive = np.full(n, self.INVALID_ID, np.uint32), np.full(n, self.INVALID_ID, np.uint32)
        uv, normal = np.zeros((n, 2)), np.zeros((n, 3))
        for number, model in enumerate(self._models):
            closest, distance, triangle = model.closest_point(xyz, threads=_threads(nthreads))
            nearer = distance < best
            best[nearer], points[nearer], geometry[nearer] = distance[nearer], closest[nearer], number
            primitive[nearer] = triangle[nearer]
            vertices, triangles = model.mesh
            a, b, c = (vertices[triangles[triangle[nearer], k]] for k in range(3))
            uv[nearer] = _barycentric(a, b, c, closest[nearer])
            face = np.cross(b - a, c - a)
            normal[nearer] = face / np.linalg.norm(face, axis=1, keepdims=True)
        return {"points": points.reshape(*shape, 3), "geometry_ids": geometry.reshape(shape),
                "primitive_ids": primitive.reshape(shape), "primitive_uvs": uv.reshape(*shape, 2),
                "primitive_normals": normal.reshape(*shape, 3)}

    def _points(self, query_points: Any) -> tuple[np.ndarray, tuple[int, ...]]:
        if not self._models:
            raise refuse("scene", "is empty", "add a model or triangles first")
        array = numbers(query_points, "query_points")
        if array.ndim < 1 or array.shape[-1] != 3:
            raise refuse("query_points", f"has the shape {array.shape}", "give points in the last axis: (..., 3)")
        return array.reshape(-1, 3), array.shape[:-1]


def _threads(nthreads: int) -> Optional[int]:
    return count(nthreads, "nthreads", 1024) or None


def _barycentric(a: np.ndarray, b: np.ndarray, c: np.ndarray, p: np.ndarray) -> np.ndarray:
    """(n, 2): p = (1 - u - v) a + u b + v c."""
    e, f, g = b - a, c - a, p - a
    ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
    ge, gf = (g * e).sum(1), (g * f).sum(1)
    area = ee * ff - ef * ef
    with np.errstate(divide="ignore", invalid="ignore"):
        uv = np.stack([(ff * ge - ef * gf) / area, (ee * gf - ef * ge) / area], axis=1)
    return np.where(area[:, None] > 0, uv, 0)
