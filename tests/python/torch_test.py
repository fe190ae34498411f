"""sqmap.torch: derivatives against torch's own finite differences, and what descent makes of them."""
import importlib.util
import sys
import unittest

import numpy as np
import sqmap
from support import ball_model, torus_model

if importlib.util.find_spec("torch") is None:
    print("skipped: needs libraries of others (Debian: python3-scipy python3-torch; PyPI: trimesh)")
    sys.exit(77)
assert "torch" not in sys.modules  # sqmap does without

import torch

import sqmap.torch

RANDOM = np.random.default_rng(11)


def turned(angles):
    """Rotations (n, 3, 3) by angles (n, 3) about x, y and z."""
    c, s, zero, one = angles.cos(), angles.sin(), torch.zeros(len(angles), dtype=angles.dtype), torch.ones(len(angles), dtype=angles.dtype)

    def about(k):
        i, j = (k + 1) % 3, (k + 2) % 3
        rows = [[zero] * 3 for _ in range(3)]
        rows[k][k], rows[i][i], rows[j][j], rows[i][j], rows[j][i] = one, c[:, k], c[:, k], -s[:, k], s[:, k]
        return torch.stack([torch.stack(row, -1) for row in rows], -2)

    return about(2) @ about(1) @ about(0)


def poses(angles, shifts):
    upper = torch.cat([turned(angles), shifts[:, :, None]], 2)
    last = torch.tensor([0, 0, 0, 1], dtype=angles.dtype).expand(len(angles), 1, 4)
    return torch.cat([upper, last], 1)


class Torch(unittest.TestCase):
    def test_distances_are_those_of_the_model_in_every_shape_and_type(self):
        model, points = torus_model(), RANDOM.uniform(-2, 2, (24, 3))
        expected = model.signed_distance(points)
        np.testing.assert_array_equal(sqmap.torch.signed_distance(model, torch.from_numpy(points)).numpy(), expected)
        block = sqmap.torch.signed_distance(model, torch.from_numpy(points.astype(np.float32)).reshape(2, 3, 4, 3))
        self.assertEqual((block.dtype, tuple(block.shape)), (torch.float32, (2, 3, 4)))
        np.testing.assert_allclose(block.numpy().ravel(), expected, atol=1e-6)

    def test_derivatives_by_points_are_those_of_finite_differences(self):
        points = torch.from_numpy(RANDOM.uniform(-2, 2, (200, 3))).requires_grad_()
        self.assertTrue(torch.autograd.gradcheck(lambda p: sqmap.torch.signed_distance(torus_model(), p), (points,), eps=1e-7, atol=1e-4))

    def test_derivatives_by_poses_and_tool_are_those_of_finite_differences(self):
        tool = torch.from_numpy(RANDOM.uniform(-0.3, 0.3, (12, 3))).requires_grad_()
        angles = torch.from_numpy(RANDOM.uniform(-3, 3, (20, 3))).requires_grad_()
        shifts = torch.from_numpy(RANDOM.uniform(-2, 2, (20, 3))).requires_grad_()
        model = torus_model()
        of = lambda a, s, t: sqmap.torch.clearance(model, t, poses(a, s))
        expected = model.clearance(tool.detach().numpy(), poses(angles, shifts).detach().numpy()).distance
        np.testing.assert_array_equal(of(angles, shifts, tool).detach().numpy(), expected)
        self.assertTrue(torch.autograd.gradcheck(of, (angles, shifts, tool), eps=1e-7, atol=1e-4))

    def test_descent_pushes_a_tool_out(self):
        model, tool = ball_model(), torch.from_numpy(RANDOM.uniform(-0.2, 0.2, (50, 3)))
        angles, shifts = torch.zeros(8, 3, dtype=torch.float64, requires_grad=True), torch.from_numpy(RANDOM.uniform(-0.5, 0.5, (8, 3))).requires_grad_()
        descent = torch.optim.SGD([angles, shifts], lr=0.02)
        for _ in range(300):
            descent.zero_grad()
            depth = torch.relu(0.01 - sqmap.torch.clearance(model, tool, poses(angles, shifts))).sum()
            depth.backward()
            descent.step()
        least = model.clearance(tool.numpy(), poses(angles, shifts).detach().numpy()).distance
        self.assertGreater(least.min(), 0)
        self.assertLess(least.max(), 0.1)

    def test_a_bound_has_no_derivative(self):
        points = torch.full((1, 3), 50.0, dtype=torch.float64, requires_grad=True)
        sqmap.torch.signed_distance(ball_model(), points, band=0).sum().backward()
        self.assertEqual(points.grad.abs().sum().item(), 0)

    def test_wrong_tensors_are_named(self):
        model = ball_model()
        for points, word in ((np.zeros((1, 3)), "ndarray"), (torch.zeros(4), "(4,)"), (torch.zeros(1, 3, dtype=torch.int64), "int64")):
            with self.assertRaises(sqmap.ArgumentError) as caught:
                sqmap.torch.signed_distance(model, points)
            self.assertEqual(caught.exception.element, "points")
            self.assertIn(word, str(caught.exception))
        with self.assertRaises(sqmap.ArgumentError) as caught:
            sqmap.torch.clearance(model, torch.zeros(2, 3), torch.zeros(3, 3))
        self.assertEqual(caught.exception.element, "poses")


if __name__ == "__main__":
    unittest.main()
