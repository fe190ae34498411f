"""Signed distances, closest points and occupancy as their users test them: the cases of trimesh's tests/test_proximity.py and of the
distances in Open3D's test_raycasting_scene.py, with their tolerances, on closed solids and on the triangles that both use; distances in
double against the definition; which triangle of the caller's is named; one sign behind every door; SciPy without derivatives."""
import tempfile
import unittest
import warnings

import numpy as np
import sqmap
from support import COARSE, ball, ball_model, torus

TOL_MERGE = 1e-8  # trimesh.constants.tol.merge


def box(lo, hi):
    """(vertices, triangles) of a box, outwards."""
    vertices = np.array([[x, y, z] for x in (lo[0], hi[0]) for y in (lo[1], hi[1]) for z in (lo[2], hi[2])], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def not_alone(vertices, triangles):
    """With a triangle far below, as sqmap refuses what lies in one plane (E_FLAT), and a single triangle does."""
    below = np.array([[0.0, 0, -40], [1, 0, -40], [1, 1, -41]])
    return np.vstack([vertices, below]), np.vstack([triangles, [[len(vertices) + k for k in range(3)]]])


def naive_closest(vertices, triangles, points):
    """(closest, distance) over all triangles, in double: Ericson's regions, as trimesh.proximity.closest_point_naive."""
    best, closest = np.full(len(points), np.inf), np.zeros((len(points), 3))
    for a, b, c in vertices[triangles]:
        ab, ac, ap, bp, cp = b - a, c - a, points - a, points - b, points - c
        d1, d2, d3, d4, d5, d6 = ap @ ab, ap @ ac, bp @ ab, bp @ ac, cp @ ab, cp @ ac
        vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
        with np.errstate(divide="ignore", invalid="ignore"):
            total = va + vb + vc
            q = a + np.outer(vb / total, ab) + np.outer(vc / total, ac)
            w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
            for at, where in ((b + np.outer(w, c - b), (va <= 0) & (d4 - d3 >= 0) & (d5 - d6 >= 0)),
                              (a + np.outer(d2 / (d2 - d6), ac), (vb <= 0) & (d2 >= 0) & (d6 <= 0)),
                              (np.broadcast_to(c, q.shape), (d6 >= 0) & (d5 <= d6)),
                              (a + np.outer(d1 / (d1 - d3), ab), (vc <= 0) & (d1 >= 0) & (d3 <= 0)),
                              (np.broadcast_to(b, q.shape), (d3 >= 0) & (d4 <= d3)), (np.broadcast_to(a, q.shape), (d1 <= 0) & (d2 <= 0))):
                q = np.where(where[:, None], at, q)
        distance = np.linalg.norm(q - points, axis=1)
        nearer = distance < best
        best[nearer], closest[nearer] = distance[nearer], q[nearer]
    return closest, best


def points_on_circle(count):
    angle = np.linspace(0, 2 * np.pi, count + 1)[:count]
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)


class Trimesh(unittest.TestCase):
    """Cases of tests/test_proximity.py."""

    def test_a_sphere_of_radius_one_from_radius_two(self):
        points = 2 * ball(2)[0]
        closest, distance, _ = ball_model().closest_point(points)
        self.assertTrue((np.abs(distance - 1) < 0.01).all())
        self.assertTrue((np.abs((closest * points / 2).sum(1) - 1) < 0.01).all())

    def test_a_triangle_answers_as_the_naive_search(self):
        rng = np.random.default_rng(3)
        query = points_on_circle(63) * 2
        query[:, 2] = 10
        query = np.vstack((query, query * 0.1))
        for k in range(10):
            triangle = rng.uniform(-0.5, 0.5, (3, 3)) * [1, 1, 0] if k else points_on_circle(3)
            faces = np.array([[0, 1, 2]])
            model = sqmap.bake(not_alone(triangle, faces), surface=True)
            closest, distance, number = model.closest_point(query)
            naive, truth = naive_closest(triangle, faces, query)
            self.assertLess(np.ptp([closest, naive], axis=0).max(), TOL_MERGE)
            self.assertLess(np.ptp([distance, truth], axis=0).max(), TOL_MERGE)
            self.assertTrue((model.source_triangle[number] == 0).all())

    def test_coplanar_and_other_points_outside_a_box_are_outside(self):
        model = sqmap.bake(box((-0.5,) * 3, (0.5,) * 3))
        corner = np.full(3, -0.5)
        for far in ([100, 0, 0], [100, 100, 100]):
            self.assertLess(model.signed_distance([corner + far])[0], 0)

    def test_a_box_holds_a_grid_of_its_points(self):  # of tests/test_primitives.py
        grid = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 9)] * 3), -1).reshape(-1, 3)
        self.assertTrue((sqmap.bake(box((-0.5,) * 3, (0.5,) * 3)).signed_distance(grid) > -1e-6).all())

    def test_an_acute_edge_names_the_face_that_faces_the_point(self):
        vertices = np.array([[-1, 0.5, 0], [1, 0.5, 0], [0, -1, -0.5], [0, -1, 0.5]])
        faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]])
        model = sqmap.bake((vertices, faces))
        points = np.stack([np.zeros(20), np.ones(20), np.linspace(-1, 1, 20)], 1)
        for number in (model.closest_point(points)[2], model.distances(points).triangle):
            one, other = np.split(number, 2)
            self.assertTrue((one == one[0]).all() and (other == other[0]).all() and one[0] != other[0])
            given = model.source_triangle[number]
            self.assertEqual((given[0], given[-1]), (0, 2))

    def test_a_triangle_that_is_farther_by_rounding_alone_is_named_where_it_faces_the_point(self):
        # trimesh lets 1e-8 of distance tie, here it is what double tells: 1e-9 in test_returns_correct_point_in_ambiguous_cases is none.
        vertices = np.array([[0.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, -1]])
        model = sqmap.bake((vertices, np.array([[0, 1, 2], [0, 1, 3]])), surface=True)
        closest, distance, number = model.closest_point([[-0.25 - 1e-9, 0, -0.25]])
        np.testing.assert_allclose(closest[0], [-0.25 - 1e-9, 0, 0], atol=1e-15)
        self.assertEqual((distance[0], model.source_triangle[number[0]]), (0.25, 0))

    def test_vertices_that_no_face_uses_are_no_part_of_the_surface(self):
        vertices = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [-0.5, -0.5, -0.5]])
        model = sqmap.bake(not_alone(vertices, np.array([[0, 1, 2]])), surface=True)
        closest, distance, number = model.closest_point([[-1.0, -1, -1]])
        np.testing.assert_allclose(closest[0], np.full(3, 1 / 3), atol=1e-15)
        self.assertEqual(sorted(model.source_vertex.tolist()), [0, 1, 2, 4, 5, 6])


class Open3d(unittest.TestCase):
    """Cases of test_raycasting_scene.py."""

    def triangle(self):
        scene = sqmap.Scene()
        scene.add_triangles(*not_alone(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), np.array([[0, 1, 2]])), surface=True)
        return scene

    def cube(self):
        scene = sqmap.Scene()
        scene.add_triangles(*box((0, 0, 0), (1, 1, 1)))
        return scene

    def test_compute_closest_points(self):
        answer = self.triangle().compute_closest_points(np.array([[0.2, 0.1, 1], [10, 10, 10]], np.float32))
        self.assertTrue((answer["geometry_ids"] == 0).all() and (answer["primitive_ids"] == 0).all())
        np.testing.assert_allclose(answer["points"], [[0.2, 0.1, 0.0], [1, 1, 0]], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(answer["primitive_uvs"], [[0.1, 0.1], [0, 1]], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(np.abs(answer["primitive_normals"]), [[0, 0, 1], [0, 0, 1]])

    def test_compute_lots_of_closest_points(self):
        points = np.random.RandomState(123).rand(123456, 3).astype(np.float32)
        self.assertEqual(self.triangle().compute_closest_points(points)["points"].shape, points.shape)

    def test_compute_distance_signed_distance_and_occupancy(self):
        points = np.array([[0.5, 0.5, 0.5], [-0.5, -0.5, -0.5], [0, 0, 0]], np.float32)
        np.testing.assert_allclose(self.cube().compute_distance(points), [0.5, np.sqrt(3 * 0.5**2), 0])
        np.testing.assert_allclose(self.cube().compute_signed_distance(points), [-0.5, np.sqrt(3 * 0.5**2), 0])
        np.testing.assert_allclose(self.cube().compute_occupancy(points[:2]), [1, 0])

    def test_output_shapes(self):
        scene = self.triangle()
        for shape in ([11], [1, 2, 3], [32, 14]):
            points = np.random.RandomState(123).uniform(size=shape + [3]).astype(np.float32)
            for answer in (scene.compute_distance(points), scene.compute_signed_distance(points), scene.compute_occupancy(points)):
                self.assertEqual(list(answer.shape), shape)
            last = {"geometry_ids": [], "primitive_ids": [], "primitive_uvs": [2], "primitive_normals": [3], "points": [3]}
            self.assertEqual({k: list(v.shape) for k, v in scene.compute_closest_points(points).items()},
                             {k: shape + end for k, end in last.items()})

    def test_sphere_wrong_occupancy(self):
        vertices, triangles = ball()
        scene = sqmap.Scene()
        scene.add_triangles(0.8 * vertices, triangles)
        axis = np.linspace(-0.88, 0.88, 6)
        points = np.stack(np.meshgrid(axis, axis, axis), -1)
        np.testing.assert_array_equal(scene.compute_occupancy(points), np.linalg.norm(points, axis=-1) < 0.8)


class Double(unittest.TestCase):
    def test_distances_are_the_definition_in_double_up_to_ten_sizes_away(self):
        rng = np.random.default_rng(7)
        for vertices, triangles in (ball(2), torus(16, 10), box((0.1, 0.2, 0.3), (1.4, 0.7, 0.9))):
            model = sqmap.bake((vertices, triangles), **COARSE)
            self.assertTrue(model.facts.has_input)
            size = model.r_max
            self.assertEqual(sorted(map(tuple, model.mesh[0])), sorted(map(tuple, vertices)))
            points = np.concatenate([rng.uniform(-1.5, 1.5, (300, 3)), size * rng.uniform(-10, 10, (300, 3)), vertices[:20]])
            naive = naive_closest(vertices, triangles, points)[1]
            answer = model.distances(points)
            self.assertLess(np.abs(np.abs(answer.distance) - naive).max(), 1e-12 * size)
            self.assertTrue((answer.known == 0).all())
            self.assertLess(np.abs(np.linalg.norm(answer.closest - points, axis=1) - naive).max(), 1e-12 * size)
            lean = sqmap.bake((vertices, triangles), keep_input=False, **COARSE)
            self.assertFalse(lean.facts.has_input)
            self.assertLess(lean.facts.bytes, model.facts.bytes)
            rounded = lean.distances(points[:300])
            self.assertTrue((rounded.known == 3).all())
            self.assertLess(np.abs(rounded.distance - answer.distance[:300]).max(), 1e-6 * size)

    def test_bfgs_without_derivatives_pushes_points_out_and_grippers_away(self):
        try:
            from scipy.optimize import minimize
        except ImportError:
            self.skipTest("needs libraries of others (Debian: python3-scipy python3-torch; PyPI: trimesh)")
        rng = np.random.default_rng(11)
        fingers = rng.uniform(-0.1, 0.1, (40, 3)) + np.where(rng.random((40, 1)) < 0.5, 0.3, -0.3) * [1, 0, 0]
        for vertices, triangles in (ball(), torus(), box((-0.7, -0.4, -0.3), (0.6, 0.5, 0.4))):
            model = sqmap.bake((vertices, triangles), **COARSE)

            def energy(x):  # of a point that is to be 0.2 outside
                return (model.distances(x[None]).distance[0] - 0.2) ** 2

            def slope(x):
                d = model.distances(x[None])
                return 2 * (d.distance[0] - 0.2) * d.gradient[0]

            def moved(x):
                angle = np.linalg.norm(x[3:])
                axis = x[3:] / angle if angle > 0 else x[3:]
                k = np.cross(np.eye(3), axis)
                turn = np.eye(3) - np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
                return fingers @ turn.T + x[:3]

            def clash(x):  # of a gripper that is to be 0.05 away
                return (np.minimum(model.distances(moved(x)).distance - 0.05, 0) ** 2).sum()

            def clash_slope(x):  # by the gradients of the distances and the motion alone
                d = model.distances(moved(x))
                weight = 2 * np.minimum(d.distance - 0.05, 0)[:, None] * d.gradient
                return np.array([(weight * (moved(x + step) - moved(x - step))).sum() / 2e-6 for step in 1e-6 * np.eye(6)])

            with_jac, without = 0, 0
            for start in 0.9 * vertices[rng.integers(0, len(vertices), 6)] + 0.01 * rng.standard_normal((6, 3)):
                for f, jac, x in ((energy, slope, start), (clash, clash_slope, np.concatenate([start, [0.1, 0.2, 0.3]]))):
                    a, b = minimize(f, x, jac=jac, method="BFGS"), minimize(f, x, method="BFGS")
                    self.assertLess(max(a.fun, b.fun), 1e-6)
                    with_jac, without = with_jac + a.nit, without + b.nit
            print(f"BFGS: {with_jac} iterations with jac, {without} without")
            self.assertLessEqual(without, 1.2 * with_jac)


class Sources(unittest.TestCase):
    def test_face_centres_and_contacts_name_the_faces_that_were_given(self):
        rng, stretch, shapes = np.random.default_rng(5), np.array([2.0, 0.7, 1.1]), sqmap.shapes
        two = np.vstack([ball(1)[0], ball(1)[0] + [3, 0, 0]]), np.vstack([ball(1)[1], ball(1)[1] + len(ball(1)[0])])
        capsule = shapes.capsule(segments=12)
        meshes = [(ball(2)[0] * stretch, ball(2)[1]), two, torus(16, 10), (capsule.vertices, capsule.triangles),
                  box((-1e3, 5e3, 7e3), (-1e3 + 0.3, 5e3 + 0.5, 7e3 + 0.1))]
        centres_named, contacts_named = 0, 0
        for vertices, triangles in meshes:
            order, turned = rng.permutation(len(triangles)), np.array([np.roll(t, rng.integers(3)) for t in triangles])
            loose = vertices[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)  # as STL has them
            shuffled = rng.permutation(len(vertices))
            for given in ((vertices, triangles), (vertices, turned[order]), loose, (vertices[shuffled], np.argsort(shuffled)[triangles])):
                model = sqmap.bake(given, **COARSE)
                centres = given[0][given[1]].mean(1)
                expected = np.arange(len(given[1]))
                np.testing.assert_array_equal(model.source_triangle[model.distances(centres).triangle], expected)
                np.testing.assert_array_equal(model.source_triangle[model.closest_point(centres)[2]], expected)
                np.testing.assert_array_equal(given[0][model.source_vertex], model.mesh[0])
                answer = sqmap.Scene(model).compute_closest_points(centres)
                np.testing.assert_array_equal(answer["primitive_ids"], expected)
                centres_named += len(centres)
                contacts_named += self.contacts_named(model, given)
            scene = sqmap.Scene()
            scene.add_triangles(*given, **COARSE)
            np.testing.assert_allclose(scene.compute_closest_points(centres)["primitive_uvs"], 1 / 3, atol=1e-9)
        print(f"{centres_named} face centres and {contacts_named} contacts, each under the number in the mesh that was given")
        self.assertGreater(contacts_named, 1000)

    def contacts_named(self, model, given):
        """Contacts of a mesh with itself, moved by a little: those of points and complete ones. A vertex that is named is the one that
        touches; a face and an edge's line hold the point of contact."""
        probe, step = sqmap.Probe.of(model), model.r_max * np.array([0.011, 0.017, 0.007])
        pose = np.vstack([np.column_stack([np.eye(3), step]), [0, 0, 0, 1]])
        found = sqmap.query_probe(model, probe, pose, layer="exact")
        reach = np.linalg.norm(found.points - (given[0][probe.source_vertex[found.contacts["index"]]] + step), axis=1)
        np.testing.assert_allclose(reach, found.contacts["depth"], atol=1e-6 * max(model.r_max, np.abs(given[0]).max() * 1e-3))
        both, named = sqmap.query_contacts(sqmap.Body(model, probe), sqmap.Body(model, probe, pose)).contacts, len(found.contacts)
        for side, feature, index, shift in (("on_a", "feature_a", "index_a", 0), ("on_b", "feature_b", "index_b", step)):
            corners, edges, faces = (both[(both[feature] == k) & (both[index] != 2**32 - 1)] for k in range(3))
            for face in faces:
                triangle = given[1][probe.source_triangle[face[index]]]
                nearest = naive_closest(given[0][triangle] + shift, np.array([[0, 1, 2]]), face[side][None])[1][0]
                self.assertLess(nearest, 1e-6 * model.r_max)
            for edge in edges:
                triangle, k = divmod(int(edge[index]), 3)
                from_, to = given[0][probe.source_vertex[model.mesh[1][triangle, [k, (k + 1) % 3]]]] + shift
                off_line = np.linalg.norm(np.cross(edge[side] - from_, to - from_)) / np.linalg.norm(to - from_)
                self.assertLess(off_line, 1e-6 * model.r_max)
            np.testing.assert_allclose(corners[side], given[0][probe.source_vertex[corners[index]]] + shift, atol=1e-6 * model.r_max)
            named += len(corners) + len(edges) + len(faces)
        return named

    def test_numbers_and_coordinates_survive_a_file(self):
        model = ball_model()
        again = sqmap.Model.from_bytes(model.to_bytes())
        np.testing.assert_array_equal(model.source_triangle, again.source_triangle)
        np.testing.assert_array_equal(model.mesh[0], again.mesh[0])
        with self.assertRaises(sqmap.MissingError) as caught:
            sqmap.bake(ball(2), keep_input=False).source_triangle
        self.assertIn("keep_input=True", caught.exception.cure)

    def test_what_a_cure_made_up_has_no_number_and_says_so(self):
        vertices, triangles = ball(2)
        with self.assertWarns(sqmap.CuredWarning):
            model = sqmap.bake((vertices, triangles[:-5]))
        made_up = model.source_triangle < 0
        self.assertTrue(0 < made_up.sum() < len(made_up) - 300)
        centres = model.mesh[0][model.mesh[1]].mean(1)
        answer = model.distances(1.01 * centres)
        np.testing.assert_array_equal((answer.status & 16) != 0, made_up[answer.triangle])
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            sqmap.bake((vertices, triangles))


class OneMeaning(unittest.TestCase):
    def test_sign_inside_and_occupancy_agree_and_a_surface_has_no_inside(self):
        points = np.random.default_rng(2).uniform(-1.6, 1.6, (20000, 3))
        lo, hi = ball(2), box((-0.2, -1.5, -0.3), (0.3, 1.5, 0.2))
        crossing = np.vstack([lo[0], hi[0]]), np.vstack([lo[1], hi[1] + len(lo[0])])
        for model in (sqmap.bake(torus(), **COARSE), sqmap.bake(crossing, target_error=5), sqmap.bake(torus(16, 10), exact=False),
                      sqmap.bake((ball(2)[0], ball(2)[1][:-30]), surface=True)):
            inside = model.contains(points)
            np.testing.assert_array_equal(inside, model.signed_distance(points) > 0)
            np.testing.assert_array_equal(inside, model.distances(points).distance < 0)
            np.testing.assert_array_equal(inside, sqmap.Scene(model).compute_occupancy(points) == 1)
            self.assertEqual(inside.any(), model.facts.is_solid)
            if model.facts.is_solid and model.facts.has_exact:
                np.testing.assert_array_equal(inside, model.query(points, "exact").contact)
            if not model.facts.is_solid:  # contact is behind it, and proven nowhere
                for layer in (1, 2, 3, "exact"):
                    self.assertFalse(model.query(points, layer).certain.any())

    def test_the_exact_layer_agrees_within_the_rounding_of_float(self):
        rng = np.random.default_rng(8)
        for vertices, triangles in (ball(2), torus(), box((-0.2, -1.5, -0.3), (0.3, 1.5, 0.2))):
            vertices = vertices @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T + rng.normal(size=3)
            model = sqmap.bake((vertices, triangles), **COARSE)
            t, b = rng.integers(0, len(triangles), 20000), rng.dirichlet([1, 1, 1], 20000)
            points = (vertices[triangles[t]] * b[:, :, None]).sum(1)
            points += 10.0 ** rng.uniform(-11, -6, (20000, 1)) * rng.normal(size=(20000, 3))
            inside = model.contains(points)
            self.assertTrue(8000 < inside.sum() < 12000)
            for layer in ("exact", "auto"):
                answer = model.query(points, layer)
                np.testing.assert_array_equal(answer.contact, inside)
                self.assertTrue((answer.part[~inside] == -1).all() and (answer.depth[~inside] == 0).all())
                np.testing.assert_allclose(np.linalg.norm(answer.normal[inside], axis=1), 1, atol=1e-6)
            for k in rng.integers(0, 20000, 50):
                self.assertEqual(model.query(points[k:k + 1], "exact").contact[0], inside[k])

    def test_a_scene_is_the_union_or_refuses(self):
        a, b = box((-1, -1, -1), (1, 1, 1)), box((0.5, -0.5, -0.5), (3, 0.5, 0.5))
        scene = sqmap.Scene(sqmap.bake(a), sqmap.bake(b))
        union = sqmap.bake((np.vstack([a[0], b[0]]), np.vstack([a[1], b[1] + len(a[0])])))
        points = np.random.default_rng(4).uniform(-1.5, 3.5, (5000, 3))
        outside = points[~union.contains(points)]
        np.testing.assert_allclose(scene.compute_signed_distance(outside), union.distances(outside).distance, atol=1e-9)
        np.testing.assert_array_equal(scene.compute_occupancy(points) == 1, union.contains(points))
        told, refused = 0, 0
        for point in points[union.contains(points)][:300]:
            try:
                answer = scene.compute_signed_distance(point)
            except sqmap.ArgumentError as error:
                self.assertIn("overlap", str(error))
                refused += 1
                continue
            self.assertAlmostEqual(float(answer), union.distances(point[None]).distance[0], delta=1e-6)
            told += 1
        self.assertTrue(told > 100 and refused > 0, (told, refused))

    def test_facts_are_values(self):
        facts = ball_model().facts
        self.assertIs(facts.is_solid, True)
        self.assertEqual(facts.centre.shape, (3,))
        self.assertIn("r_max=", repr(facts))
        with tempfile.NamedTemporaryFile(suffix=".sqmap") as file:
            ball_model().save(file.name)
            self.assertEqual(repr(sqmap.Model.load(file.name).facts), repr(facts))


if __name__ == "__main__":
    unittest.main(verbosity=2)
