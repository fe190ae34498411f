"""Distances that torch differentiates: sqmap.torch.signed_distance, sqmap.torch.clearance.

>>> import sqmap, sqmap.torch, torch
>>> model = sqmap.bake(sqmap.shapes.torus())
>>> points = torch.zeros(1, 3, dtype=torch.float64, requires_grad=True)
>>> sqmap.torch.signed_distance(model, points).sum().backward()

`import sqmap` alone never imports torch. Tensors lie on the CPU; float32 and others are computed in double and answered in their
own type. A distance is not smooth at creases of its own, where two surface points are equally near (the medial axis, and outside
a concave edge): the derivative there is that of one of them. First derivatives only.
"""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
import torch
from torch.autograd.function import once_differentiable

from ._arrays import refuse
from ._model import Model

__all__ = ["clearance", "signed_distance"]


def _doubles(values: Any, element: str, shape: "tuple[int, ...]") -> np.ndarray:
    """The numbers of a tensor, n rows of the shape."""
    if not isinstance(values, torch.Tensor):
        raise refuse(element, f"is a {type(values).__name__}", f"give a torch.Tensor, or take the method of Model for arrays")
    if values.device.type != "cpu":
        raise refuse(element, f"lies on {values.device}", f"give {element}.cpu()")
    if not values.dtype.is_floating_point or tuple(values.shape[-len(shape):]) != shape:
        raise refuse(element, f"is {values.dtype} of the shape {tuple(values.shape)}",
                     f"give floating point numbers of the shape (..., {', '.join(map(str, shape))})")
    return np.ascontiguousarray(values.detach().reshape(-1, *shape).numpy(), dtype=np.float64)


class _SignedDistance(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, points: torch.Tensor, model: Model, band: Optional[float], threads: Optional[int]) -> torch.Tensor:
        found = model.distances(_doubles(points, "points", (3,)), band=band, threads=threads)
        ctx.save_for_backward(torch.from_numpy(-found.gradient).reshape(points.shape).to(points.dtype))
        return torch.from_numpy(-found.distance).reshape(points.shape[:-1]).to(points.dtype)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, by_distance: torch.Tensor) -> Any:
        (gradient,) = ctx.saved_tensors
        return by_distance[..., None] * gradient, None, None, None


class _Clearance(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, points: torch.Tensor, poses: torch.Tensor, model: Model, band: Optional[float], threads: Optional[int]) -> torch.Tensor:
        tool, frames = _doubles(points, "points", (3,)), _doubles(poses, "poses", (4, 4))
        found = model.clearance(tool, frames, band=band, threads=threads)
        ctx.save_for_backward(points.detach(), poses.detach(), torch.from_numpy(found.gradient[:, :3].copy()), torch.from_numpy(found.index))
        return torch.from_numpy(found.distance).reshape(poses.shape[:-2]).to(poses.dtype)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, by_distance: torch.Tensor) -> Any:
        # The distance is that of the point R p + t: its derivative is the normal n by t, n p^T by R and R^T n by p.
        points, poses, normal, index = ctx.saved_tensors
        normal = normal.to(poses.dtype) * by_distance.reshape(-1, 1)
        rotation, rows, nearest = poses.reshape(-1, 4, 4)[:, :3, :3], points.reshape(-1, 3), index.clamp(min=0)  # of a bound n is zero
        by_poses = torch.zeros_like(poses).reshape(-1, 4, 4)
        by_poses[:, :3, :3] = normal[:, :, None] * rows[nearest].to(poses.dtype)[:, None, :]
        by_poses[:, :3, 3] = normal
        by_points = torch.zeros_like(rows).index_add_(0, nearest, (rotation.transpose(1, 2) @ normal[:, :, None])[:, :, 0].to(points.dtype))
        return by_points.reshape(points.shape), by_poses.reshape(poses.shape), None, None, None


def signed_distance(model: Model, points: torch.Tensor, *, band: Optional[float] = None, threads: Optional[int] = None) -> torch.Tensor:
    """Signed distances (...) of points (..., 3), positive inside, as Model.signed_distance.

    The derivative by a point is the unit direction into the solid; zero where band gives a bound."""
    return _SignedDistance.apply(points, model, band, threads)


def clearance(model: Model, points: torch.Tensor, poses: torch.Tensor, *, band: Optional[float] = None, threads: Optional[int] = None) -> torch.Tensor:
    """Least signed distance (...) of a tool's points (m, 3) at poses (..., 4, 4), negative inside, as Model.clearance.

    poses are rigid. Derivatives by points, and by the 12 numbers of a pose as if they were free: build the pose from angles in
    torch, and the chain rule does the rest."""
    return _Clearance.apply(points, poses, model, band, threads)
