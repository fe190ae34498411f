"""Tactile pads: forces of pressing and slipping in closed form, and bad input."""
import time
import unittest

import numpy as np
import sqmap
from support import ball_model

KN, KT, MU = 300.0, 4.0, 0.6


def pad(count=9, **options):
    """A flat pad of count x count taxels that looks down."""
    x, y = np.meshgrid(np.linspace(-0.1, 0.1, count), np.linspace(-0.1, 0.1, count))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(count * count)])
    return sqmap.TactilePad(points, np.tile([0.0, 0.0, -1.0], (len(points), 1)), layer="exact", tactile_kn=KN, tactile_kt=KT,
                            tactile_mu=MU, **options), points


def at(x, y, z):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


class Tactile(unittest.TestCase):
    def test_pressed_on_a_ball_force_is_stiffness_times_depth(self):
        taxels, points = pad()
        touch = taxels.tick(ball_model(), at(0, 0, 0.95))
        depth = np.maximum(0, 1 - np.linalg.norm(points + [0, 0, 0.95], axis=1))
        self.assertEqual(touch.contacts, len(points))
        np.testing.assert_allclose(touch.taxels["depth"], depth, atol=0.005)  # the ball has faces
        size = np.sqrt(touch.taxels["normal"] ** 2 + (touch.taxels["shear"] ** 2).sum(axis=1))
        np.testing.assert_allclose(size, KN * touch.taxels["depth"], rtol=1e-5)
        np.testing.assert_allclose(touch.taxels["shear"][:, 2], 0, atol=1e-6)
        self.assertGreater(touch.force[2], 0)

    def test_slip_adds_coulombs_shear_against_the_motion(self):
        taxels, _ = pad()
        still = taxels.tick(ball_model(), at(0, 0, 0.95))
        slid = taxels.tick(ball_model(), at(1e-4, 0, 0.95), 1e-6)  # 100 units a second
        middle = len(taxels) // 2
        self.assertAlmostEqual(slid.taxels["shear"][middle, 0] - still.taxels["shear"][middle, 0],
                               -MU * KN * slid.taxels["depth"][middle], delta=0.05)
        rest = taxels.tick(ball_model(), at(1e-4, 0, 0.95), 1e-3)
        self.assertAlmostEqual(rest.taxels["shear"][middle, 0], still.taxels["shear"][middle, 0], delta=0.05)

    def test_without_friction_there_is_none(self):
        points = np.array([[0.0, 0.0, 0.0]])
        taxels = sqmap.TactilePad(points, -np.eye(3)[2:], tactile_mu=0, layer="exact")
        taxels.tick(ball_model(), at(0, 0, 0.9))
        touch = taxels.tick(ball_model(), at(0, 0.01, 0.9), 1e-3)
        self.assertLess(np.abs(touch.taxels["shear"]).max(), 0.01)

    def test_bad_input_is_refused_with_a_cure(self):
        taxels, points = pad()
        for call in (lambda: sqmap.TactilePad(points, points[:3]), lambda: sqmap.TactilePad(points, points, tactile_kn=-1),
                     lambda: sqmap.TactilePad(points * np.nan, points), lambda: sqmap.TactilePad(points[:0], points[:0]),
                     lambda: taxels.tick("model"), lambda: taxels.tick(ball_model(), np.ones((4, 4))),
                     lambda: taxels.tick(ball_model(), dt=-1.0), lambda: taxels.tick(ball_model(), dt=float("nan")),
                     lambda: sqmap.TactilePad(points, points, layer=9)):
            with self.assertRaises(sqmap.ArgumentError) as caught:
                call()
            self.assertTrue(caught.exception.element and caught.exception.cure)
        taxels.close()
        with self.assertRaises(sqmap.ClosedError):
            taxels.tick(ball_model())

    def test_a_thousand_taxels_are_queried(self):
        taxels, _ = pad(32)
        touch = taxels.tick(ball_model(), at(0, 0, 0.99))
        self.assertEqual(len(touch.taxels), 1024)
        begin = time.perf_counter()
        for _ in range(200):
            taxels.tick(ball_model(), at(0, 0, 0.99), 1e-3)
        print(f"1,024 taxels, exact layer: {1e6 * (time.perf_counter() - begin) / 200:.1f} us a tick through Python")


if __name__ == "__main__":
    unittest.main()
