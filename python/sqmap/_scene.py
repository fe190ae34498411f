"""Signed distance with Open3D's names, shapes and sign."""
from __future__ import annotations

import os
from typing import Any, Optional

import numpy as np

from ._arrays import count, instance, is_open3d_tensor, numbers, refuse, triangles_of
from ._answers import Distances
from ._bake import bake
from ._model import Model


class Scene:
    """Closed meshes as one solid, with the functions of open3d.t.geometry.RaycastingScene that compute distances.

    Points are arrays of shape {..., 3}; answers have the leading shape, in NumPy arrays, or in Open3D's tensors where the points are
    one. Distances are exact, in double, and negative
    inside. Several geometries count as their union. Where two of them overlap so that the union's surface cannot be told from
    theirs, a point is refused with an ArgumentError: bake these meshes as one, which finds the union."""

    INVALID_ID = 0xFFFFFFFF

    def __init__(self, *models: Model) -> None:
        self._models: list[Model] = []
        self._given: list[Optional[tuple[np.ndarray, np.ndarray]]] = []
        for model in models:
            self.add_model(model)

    def add_model(self, model: Model) -> int:
        """Adds a baked model; its number."""
        with instance(model, Model, "model").use("model"):
            self._models.append(model)
        self._given.append(None)
        return len(self._models) - 1

    def add_triangles(self, vertices: Any, triangles: Optional[Any] = None, **options: Any) -> int:
        """Bakes a mesh, (vertices, triangles) or an object with both, and adds it; its number. options: of sqmap.bake."""
        mesh = vertices if triangles is None else (vertices, triangles)
        number = self.add_model(bake(mesh, **options))
        if not isinstance(mesh, (str, bytes, os.PathLike)):
            self._given[number] = triangles_of(mesh)
        return number

    def compute_signed_distance(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """{...}: to the nearest surface, negative inside. nthreads: 0 is one a core; nsamples: Open3D's rays that vote on a sign, an
        odd number, which changes nothing here."""
        xyz, shape = self._points(query_points)
        _check_samples(nsamples)
        return _as(query_points, self._nearest(xyz, _threads(nthreads))[0].distance.reshape(shape))

    def compute_distance(self, query_points: Any, nthreads: int = 0) -> Any:
        """{...}: to the nearest surface, never negative."""
        xyz, shape = self._points(query_points)
        return _as(query_points, np.abs(self._nearest(xyz, _threads(nthreads))[0].distance).reshape(shape))

    def compute_occupancy(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """{...} float32: 1 inside, 0 outside, as the sign of the distance; nsamples as there. Raises ArgumentError for a point that is
        not finite."""
        xyz, shape = self._points(query_points)
        _check_samples(nsamples)
        out = np.zeros(len(xyz), np.bool_)
        for model in self._models:
            out |= model._contains(xyz, _threads(nthreads), "query_points")
        return _as(query_points, out.astype(np.float32).reshape(shape))

    def compute_closest_points(self, query_points: Any, nthreads: int = 0) -> dict[str, Any]:
        """points {..., 3}, geometry_ids {...}, primitive_ids {...} (uint32; of the mesh that was given, INVALID_ID where a cure made
        the surface up), primitive_uvs {..., 2} (of the triangle's corners as given to add_triangles, else as in Model.mesh),
        primitive_normals {..., 3}."""
        xyz, shape = self._points(query_points)
        found, geometry = self._nearest(xyz, _threads(nthreads))
        primitive = np.full(len(xyz), self.INVALID_ID, np.uint32)
        uv, normal = np.zeros((len(xyz), 2)), np.zeros((len(xyz), 3))
        for number, model in enumerate(self._models):
            vertices, triangles = model.mesh
            own = np.flatnonzero((geometry == number) & (found.triangle >= 0))
            corners = vertices[triangles[found.triangle[own]]]
            face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normal[own] = face / np.linalg.norm(face, axis=1, keepdims=True)
            source = (model.source_triangle if model.facts.has_input else np.arange(len(triangles)))[found.triangle[own]]
            primitive[own] = source  # -1 is INVALID_ID
            if (given := self._given[number]) is not None and model.facts.has_input:
                corners = np.where((source >= 0)[:, None, None], given[0][given[1][source]], corners)
            uv[own] = _barycentric(corners[:, 0], corners[:, 1], corners[:, 2], found.closest[own])
        points = np.where(np.isnan(found.distance)[:, None], np.nan, found.closest)
        answers = {"points": points.reshape(*shape, 3), "geometry_ids": geometry.reshape(shape),
                   "primitive_ids": primitive.reshape(shape), "primitive_uvs": uv.reshape(*shape, 2),
                   "primitive_normals": normal.reshape(*shape, 3)}
        return {name: _as(query_points, answer) for name, answer in answers.items()}

    def _nearest(self, xyz: np.ndarray, threads: Optional[int]) -> tuple[Distances, np.ndarray]:
        """Distances to the union, and the geometry of each answer."""
        best = self._models[0].distances(xyz, threads=threads)
        geometry = np.where(np.isnan(best.distance), self.INVALID_ID, 0).astype(np.uint32)
        for number, model in enumerate(self._models[1:], 1):
            other = model.distances(xyz, threads=threads)
            nearer = other.distance < best.distance  # outside the nearest, inside the one that holds most of a ball about the point
            for all_of_it, some in zip(best, other):
                all_of_it[nearer] = some[nearer]
            geometry[nearer] = number
        inside = np.flatnonzero(best.distance < 0) if len(self._models) > 1 else []
        for number, model in enumerate(self._models) if len(inside) else ():
            others = inside[geometry[inside] != number]
            hidden = others[model.signed_distance(best.closest[others], threads=threads) > 1e-9 * model.r_max]
            if len(hidden):
                raise refuse(f"query_points[{int(hidden[0])}]",
                             f"is inside where geometries {int(geometry[hidden[0]])} and {number} overlap, and the surface of their "
                             "union is not theirs", "bake the meshes as one, or leave the point out")
        return best, geometry

    def _points(self, query_points: Any) -> tuple[np.ndarray, tuple[int, ...]]:
        if not self._models:
            raise refuse("scene", "is empty", "add a model or triangles first")
        array = numbers(query_points, "query_points")
        if array.ndim < 1 or array.shape[-1] != 3:
            raise refuse("query_points", f"has the shape {array.shape}", "give points in the last axis: (..., 3)")
        return array.reshape(-1, 3), array.shape[:-1]


def _as(query_points: Any, answer: np.ndarray) -> Any:
    """An answer of the kind of the points: an Open3D tensor where they are one."""
    return type(query_points)(answer) if is_open3d_tensor(query_points) else answer


def _check_samples(nsamples: int) -> None:
    if count(nsamples, "nsamples") % 2 == 0:
        raise refuse("nsamples", f"is {nsamples}", "give an odd number, as Open3D asks")


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
