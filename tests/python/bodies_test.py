"""Bodies through Python: probes, pairs, complete contacts and piles, against single points and closed forms."""
import unittest

import numpy as np
import sqmap
from support import ball, ball_model, moved, torus_model


class Bodies(unittest.TestCase):
    def test_a_probe_has_the_answers_of_its_points(self):
        vertices = np.random.default_rng(7).uniform(-1.5, 1.5, (2000, 3))
        model, probe, pose = torus_model(), sqmap.Probe(vertices), moved(0.1, 0, 0)
        found = sqmap.query_probe(model, probe, pose)
        inside = np.flatnonzero(model.query(vertices + (0.1, 0, 0)).contact)
        self.assertEqual(sorted(found.contacts["index"].tolist()), inside.tolist())
        depth = model.query(vertices[found.contacts["index"]] + (0.1, 0, 0)).depth
        np.testing.assert_allclose(found.contacts["depth"], depth, atol=1e-6)
        self.assertEqual(found.points.shape, (len(inside), 3))

    def test_a_pair_has_the_contacts_of_both(self):
        vertices, _ = ball()
        model, probe = ball_model(), sqmap.Probe(vertices)
        pair = sqmap.query_pair(sqmap.Body(model, probe), sqmap.Body(model, probe, moved(1.9, 0, 0)))
        deepest = pair.contacts[pair.contacts["depth"].argmax()]
        self.assertAlmostEqual(float(deepest["depth"]), 0.1, delta=0.02)
        self.assertGreater(deepest["normal"][0], 0.9)
        np.testing.assert_allclose(deepest["on_a"] - deepest["depth"] * deepest["normal"], deepest["on_b"], atol=1e-5)
        apart = sqmap.query_pair(sqmap.Body(model, probe), sqmap.Body(model, probe, moved(2.5, 0, 0)))
        self.assertEqual((len(apart.contacts), apart.found, apart.edge_length), (0, 0, 0))
        near = sqmap.query_pair(sqmap.Body(model, probe), sqmap.Body(model, probe, moved(2.1, 0, 0)), margin=0.2)
        self.assertGreater(len(near.contacts), 0)
        self.assertAlmostEqual(near.edge_length, 0.4, delta=1e-4)  # twice the margin, less what rounding takes
        self.assertLess(near.edge_length, 0.4)

    def test_complete_contacts_without_a_workspace_are_all_there(self):
        """Two plates of many cells lie on each other, which takes all space of a small workspace, and beside them a bar crosses a bar."""
        def body(*boxes):
            shapes = [(sqmap.shapes.box(extents, segments=n), centre) for extents, n, centre in boxes]
            ends = np.cumsum([0] + [len(shape.vertices) for shape, _ in shapes])
            return sqmap.Body(probe=sqmap.Probe(np.vstack([shape.vertices + centre for shape, centre in shapes]),
                                                np.vstack([shape.triangles + end for (shape, _), end in zip(shapes, ends)])))

        # Halves and quarters, so that the plates meet to the last bit.
        lower = body(((1, 1, 0.125), 20, (0, 0, -0.0625)), ((0.25, 1, 0.125), 1, (3, 0, 0)))
        upper = body(((1, 1, 0.125), 20, (0, 0, 0.0625)), ((1, 0.25, 0.125), 1, (3, 0, 0.09375)))
        found = sqmap.query_contacts(lower, upper)
        self.assertGreater(found.meetings, 4096)
        self.assertEqual((found.regions, found.status), (2, 0))
        self.assertEqual((found.contacts["on_a"][:, 0] > 2).sum(), 4)
        self.assertEqual(sqmap.query_contacts(lower, upper, sqmap.Workspace(4096)).status & 8, 8)

    def test_no_contact_of_edges_is_missed(self):
        """Two bars of square section that cross on their ridges, 0.1 deep: no vertex is in the other one."""
        ends = [(0, -1), (1, 0), (0, 1), (-1, 0)]
        corners = [(s, y, z) for s in (-3, 3) for y, z in ends]
        sides = [q for i in range(4) for j in [(i + 1) % 4] for q in ((i, j, 4 + i), (j, 4 + j, 4 + i))]
        faces = np.array([*sides, (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)])
        lower = np.array(corners, float)
        turned = lower[:, [1, 0, 2]] * [-1, 1, 1] + [0, 0, 1.9]
        if np.linalg.det(lower[faces].astype(float)).sum() < 0:
            faces = faces[:, ::-1]
        a, b = sqmap.Body(probe=sqmap.Probe(lower, faces)), sqmap.Body(probe=sqmap.Probe(turned, faces))
        found = sqmap.query_contacts(a, b)
        self.assertEqual((len(found.contacts), found.regions), (1, 1))
        contact = found.contacts[0]
        self.assertEqual((contact["feature_a"], contact["feature_b"]), (1, 1))
        self.assertAlmostEqual(float(contact["depth"]), 0.1, delta=1e-6)
        np.testing.assert_allclose(contact["on_a"], [0, 0, 1], atol=1e-6)
        np.testing.assert_allclose(contact["normal"], [0, 0, 1], atol=1e-6)
        above = sqmap.Body(probe=b.probe, pose=moved(0, 0, 2))
        touch = sqmap.first_touch(a, above, moved(0, 0, 0))
        self.assertTrue(touch.touches)
        self.assertTrue(0.949 < touch.time <= 0.95, touch.time)
        self.assertFalse(sqmap.first_touch(a, above, moved(0, 0, 0.2)).touches)
        both = sqmap.first_touch(a, above, moved(0, 0, 1), moved(0, 0, 1))  # each goes half way
        self.assertTrue(0.949 < both.time <= 0.95, both.time)
        self.assertFalse(sqmap.first_touch(a, above, moved(0, 0, 0), moved(0, 0, -2)).touches)
        apart = sqmap.clearance(a, above)
        self.assertAlmostEqual(apart.distance, 1.9, delta=1e-12)
        self.assertTrue(1.9 - 1e-12 <= apart.at_least <= apart.distance)
        np.testing.assert_allclose((apart.on_a, apart.on_b), ([0, 0, 1], [0, 0, 2.9]), atol=1e-12)
        self.assertTrue(sqmap.is_within(a, above, 1.91))
        self.assertFalse(sqmap.is_within(a, above, 1.89))
        self.assertEqual(sqmap.clearance(a, b).distance, 0)
        self.assertAlmostEqual(sqmap.overlap(a, b).volume, 4 * 0.1**3 / 6, delta=1e-12)  # integral of 2 (1 - z) 2 (z - 0.9)
        along = sqmap.separation(a, b, (0, 0, 7))
        self.assertAlmostEqual(along.distance, 0.1, delta=1e-12)
        self.assertTrue(along.exact and 0.1 - 1e-9 <= along.at_least <= along.distance)
        least = sqmap.separation(a, b)
        self.assertAlmostEqual(least.distance, 0.1, delta=1e-12)
        np.testing.assert_allclose(least.direction, [0, 0, 1], atol=1e-9)
        self.assertEqual(sqmap.separation(a, above).distance, 0)
        with self.assertRaises(sqmap.MeshError) as raised:
            sqmap.Probe(lower, faces[1:])
        self.assertIn("triangles[", raised.exception.element)

    def test_moving_features_touch_when_they_meet(self):
        """A point falls on a triangle from height 1, an edge on a crossed one from 2, and both once more beside them."""
        triangle, edge = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(-1, 0, 0), (1, 0, 0)]
        for edges, still, high in ((False, triangle, [(0.2, 0.2, 1)]), (True, edge, [(0.1, -1, 2), (0.1, 1, 2)])):
            height = high[0][2]
            start = np.array([high + still, high + still], float)
            start[1, :len(high), 0] += 5
            end = start.copy()
            end[:, :len(high), 2] -= 4
            found = sqmap.first_touch_features(start, end, edges)
            self.assertEqual(found.touches.tolist(), [True, False])
            self.assertTrue(height / 4 - 1e-9 <= found.time[0] <= height / 4)
            self.assertEqual(found.time[1], 1)
            early = sqmap.first_touch_features(start[:1], end[:1], edges, 0.5)
            self.assertTrue((height - 0.5) / 4 - 1e-9 <= early.time[0] <= (height - 0.5) / 4)
        start[0, 0, 0] = np.nan
        self.assertEqual((*sqmap.first_touch_features(start, end, True).time,), (0, 1))

    def test_a_pile_has_space_for_all_contacts(self):
        """A pair has more than the pile was made for. More poses than there are bodies are refused."""
        block = sqmap.shapes.box((1, 1, 0.125), segments=20)
        body = sqmap.Body(probe=sqmap.Probe(block.vertices, block.triangles))
        with sqmap.Pile(16) as pile:
            for _ in range(2):
                pile.add(body)
            poses = np.array([np.eye(4)] * 2)
            poses[1, 2, 3] = 0.125
            found = pile.query(poses)
            alone = sqmap.query_contacts(body, sqmap.Body(probe=body.probe, pose=poses[1]))
            self.assertEqual((found.status, found.pairs["found"][0], len(found.contacts)), (0, alone.found, len(alone.contacts)))
            with self.assertRaises(sqmap.ArgumentError) as raised:
                pile.query(np.array([np.eye(4)] * 3))
            self.assertEqual(raised.exception.element, "poses")

    def test_a_pile_has_the_contacts_of_each_pair(self):
        model = ball_model()
        probe = sqmap.Probe(*model.mesh)
        rng = np.random.default_rng(4)
        with sqmap.Pile() as pile:
            bodies = [sqmap.Body(model if i % 2 else None, probe) for i in range(8)]
            self.assertEqual([pile.add(body) for body in bodies], list(range(8)))
            for _ in range(3):
                poses = np.repeat(np.eye(4)[None], 8, axis=0)
                poses[:, :3, 3] = rng.uniform(-1.5, 1.5, (8, 3))
                found = pile.query(poses, threads=2)
                pairs = iter(found.pairs)
                for body, pose in zip(bodies, poses):
                    body.pose = pose
                for i in range(8):
                    for j in range(i + 1, 8):
                        alone = sqmap.query_contacts(bodies[i], bodies[j])
                        if alone.found == 0:
                            continue
                        pair = next(pairs)
                        self.assertEqual((pair["a"], pair["b"], pair["found"], pair["regions"]), (i, j, alone.found, alone.regions))
                        own = found.contacts[pair["first"]:pair["first"] + pair["count"]]
                        for name in own.dtype.names:
                            np.testing.assert_array_equal(own[name], alone.contacts[name])
                self.assertEqual(list(pairs), [])
                self.assertGreater(len(found.pairs), 2)
            np.testing.assert_array_equal(pile.query().contacts["on_b"], found.contacts["on_b"])
            pile.remove(3)
            self.assertFalse((pile.query().pairs["a"] == 3).any() or (pile.query().pairs["b"] == 3).any())
            poses[0, 0, 3] = np.nan
            self.assertEqual(pile.query(poses).status & 1, 1)
            self.assertEqual(pile.add(bodies[3]), 3)

    def test_a_model_that_is_closed_serves_what_was_made_of_it(self):
        model = sqmap.Model.from_bytes(ball_model().to_bytes())
        session = sqmap.Session(model, metres_per_unit=0.05)
        model.close()
        self.assertEqual(session.tick((0, 0, 0.1), 0.001).depth, 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
