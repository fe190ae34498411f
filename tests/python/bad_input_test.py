"""Bad input through every door of the package: an exception with code, element and cure, never anything else."""
import pathlib
import tempfile
import unittest

import numpy as np
import sqmap
from support import ball, ball_model, torus

POINTS = np.zeros((3, 3))


class BadInput(unittest.TestCase):
    def refused(self, kind, call, *arguments, **options):
        with self.assertRaises(kind) as raised:
            call(*arguments, **options)
        error = raised.exception
        self.assertTrue(error.code.startswith("E_"), error.code)
        self.assertTrue(error.element and error.message and error.cure, str(error))
        self.assertIn(error.cure, str(error))
        return error

    def test_points_of_wrong_shape_or_type(self):
        model = ball_model()
        for bad in (np.zeros(3), np.zeros((3, 2)), np.zeros((2, 3, 3)), 5, "points", None, [["a", "b", "c"]],
                    np.zeros((3, 3), complex), np.zeros((3, 3), bool), np.array([[1, 2, 3]], object), [[1, 2], [3]]):
            for door in (model.query, model.distances, model.signed_distance, model.contains, model.closest_point, sqmap.Probe):
                error = self.refused(sqmap.ArgumentError, door, bad)
                self.assertEqual(error.element, "points")

    def test_numbers_out_of_range(self):
        model = ball_model()
        for band in (-1, np.nan, "wide"):
            self.refused(sqmap.ArgumentError, model.distances, POINTS, band=band)
        for options in ({"margin": -1}, {"margin": np.inf}, {"tolerance": np.nan}, {"layer": 7}, {"layer": "deep"}, {"layer": True},
                        {"layer": [3]}, {"threads": -1}, {"threads": 1e9}, {"threads": 1.5}):
            self.refused(sqmap.ArgumentError, model.query, POINTS, **options)
        for options in ({"target_error": 0}, {"target_error": -1}, {"target_error": np.nan}, {"band": 101}, {"band": 0},
                        {"max_parts": 0.5}, {"max_parts": -1}, {"max_parts": 10**9}, {"threads": 5000}, {"repair": "glue"},
                        {"projection": "mercator"}, {"thickness": -1}, {"thickness": np.nan}):
            self.refused(sqmap.ArgumentError, sqmap.bake, ball(), **options)
        for options in ({"metres_per_unit": 0}, {"metres_per_unit": -1}, {"metres_per_unit": np.nan}, {"radius": -1}, {"radius": 5},
                        {"stiffness": 0}, {"stiffness": 1e9}, {"stiffness": np.nan}, {"damping": -1}, {"friction": -0.1},
                        {"friction": np.nan}, {"max_force": -1}, {"max_force": np.nan}, {"force_limit": -1},
                        {"max_force": 1, "force_limit": 2}, {"layer": 9}, {"mode": "glued"}, {"mode": []},
                        {"side_path": -1}, {"side_path": np.nan}):
            self.refused(sqmap.ArgumentError, sqmap.Session, model, **options)

    def test_poses_that_are_no_rigid_motion(self):
        model = ball_model()
        scaled, mirrored, projective = np.eye(4) * 2, np.diag([1.0, 1, -1, 1]), np.eye(4)
        scaled[3, 3] = 1
        projective[3] = 1
        for pose in (scaled, mirrored, projective, np.eye(3), np.full((4, 4), np.nan), np.zeros((4, 4)), "here"):
            self.refused(sqmap.ArgumentError, model.query, POINTS, pose=pose)
            self.refused(sqmap.ArgumentError, sqmap.query_probe, model, sqmap.Probe(POINTS), pose)

    def test_meshes_that_are_none(self):
        vertices, triangles = ball()
        for bad in ((vertices,), (vertices, triangles, 1), object(), 5, (vertices[:, :2], triangles), (vertices, triangles[:, :2]),
                    (vertices, triangles.astype(float)), (vertices, [["a", "b", "c"]])):
            self.refused(sqmap.ArgumentError, sqmap.bake, bad)
        nan = vertices.copy()
        nan[5, 1] = np.nan
        far = triangles.copy()
        far[7, 2] = 10**12
        negative = triangles.copy()
        negative[7, 2] = -1
        flat = (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float), np.array([[0, 1, 2]]))
        for bad, code in (((nan, triangles), "E_NONFINITE"), ((vertices, far), "E_INDEX"), ((vertices, negative), "E_INDEX"),
                          ((vertices, triangles[:0]), "E_EMPTY"), ((vertices[:0], triangles[:0]), "E_EMPTY")):
            self.assertEqual(self.refused(sqmap.MeshError, sqmap.bake, bad).code, code)
        self.refused(sqmap.MeshError, sqmap.bake, flat, repair="none")
        self.refused(sqmap.MeshError, sqmap.bake, (vertices, triangles[1:]), repair="none")

    def test_files_that_are_no_models(self):
        data = ball_model().to_bytes()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "model.sqmap")
            self.refused(sqmap.FileError, sqmap.Model.load, path)
            self.refused(sqmap.FileError, sqmap.Model.load, folder)
            self.refused(sqmap.ArgumentError, sqmap.Model.load, 5)
            self.refused(sqmap.ArgumentError, sqmap.Model.load, "a\0b")
            self.refused(sqmap.MeshError, sqmap.bake, path)
            for bad in (data[:10], data[: len(data) // 2], data[:-1], b"x" * 100, bytes(len(data))):
                path.write_bytes(bad)
                self.refused(sqmap.ModelError, sqmap.Model.load, path)
                self.refused(sqmap.ModelError, sqmap.Model.from_bytes, bad)
            path.write_bytes(b"")
            self.refused(sqmap.FileError, sqmap.Model.load, path)
            self.refused(sqmap.ModelError, sqmap.Model.from_bytes, b"")
            self.refused(sqmap.FileError, ball_model().save, pathlib.Path(folder, "none", "model.sqmap"))
            self.refused(sqmap.ArgumentError, ball_model().export, pathlib.Path(folder, "ball.step"))
        self.refused(sqmap.ArgumentError, sqmap.Model.from_bytes, "text")
        self.refused(sqmap.ArgumentError, sqmap.Model.from_bytes, None)

    def test_a_model_of_another_version(self):
        data = bytearray(ball_model().to_bytes())
        # The version is a 32-bit number of the root table: the file with the next one has one byte that differs.
        found = 0
        for at in range(0, 400, 4):
            if int.from_bytes(data[at:at + 4], "little") == sqmap.FORMAT_VERSION:
                other = bytearray(data)
                other[at] += 1
                try:
                    sqmap.Model.from_bytes(bytes(other))
                except sqmap.VersionError as e:
                    found += 1
                    self.assertIn("bake", e.cure)
                except sqmap.ModelError:
                    pass
        self.assertEqual(found, 1)

    def test_what_is_closed(self):
        model = sqmap.Model.from_bytes(ball_model().to_bytes())
        probe, workspace, session = sqmap.Probe(POINTS), sqmap.Workspace(8), sqmap.Session(model)
        for thing in (model, probe, workspace, session):
            thing.close()
            thing.close()
            self.assertTrue(thing.closed)
        for call in (lambda: model.query(POINTS), lambda: model.signed_distance(POINTS), lambda: model.info, lambda: model.mesh,
                     model.to_bytes, lambda: model.save("x"), lambda: sqmap.Session(model),
                     lambda: sqmap.query_probe(ball_model(), probe), lambda: sqmap.query_probe(model, sqmap.Probe(POINTS)),
                     lambda: sqmap.query_pair(sqmap.Body(ball_model()), sqmap.Body(), workspace),
                     lambda: session.tick((0, 0, 0), 0.1), lambda: session.simulate(POINTS)):
            self.refused(sqmap.ClosedError, call)
        self.assertIn("closed", repr(model))

    def test_a_model_without_triangles(self):
        model = sqmap.bake(ball(2), exact=False)
        self.refused(sqmap.MissingError, lambda: model.mesh)
        self.refused(sqmap.MissingError, model.closest_point, POINTS)
        self.assertEqual(set(model.distances(np.array([[0, 0, 0.9]])).known.tolist()), {1})

    def test_bodies_scenes_sessions(self):
        model = ball_model()
        for call in (lambda: sqmap.Body(5), lambda: sqmap.Body(model, model), lambda: sqmap.query_pair(model, model),
                     lambda: sqmap.query_pair(sqmap.Body(), sqmap.Body(), workspace=3), lambda: sqmap.query_probe(model, POINTS),
                     lambda: sqmap.query_probe(5, sqmap.Probe(POINTS)), lambda: sqmap.Workspace(0), lambda: sqmap.Workspace(10**12),
                     lambda: sqmap.Probe(np.zeros((0, 3))), lambda: sqmap.Probe([[0, 0, np.nan]]),
                     lambda: sqmap.Scene().compute_signed_distance(POINTS), lambda: sqmap.Scene(5),
                     lambda: sqmap.Scene(model).compute_occupancy(np.zeros((3, 2))), lambda: sqmap.Session(5),
                     lambda: sqmap.Session(model).tick("here", 0.1), lambda: sqmap.Session(model).tick((0, 0, 0), "now"),
                     lambda: sqmap.Session(model).simulate([[0, 0, np.nan]]), lambda: sqmap.Session(model).simulate(np.zeros(3))):
            self.refused(sqmap.ArgumentError, call)

    def test_progress_stops_a_bake(self):
        stages = []
        sqmap.bake(torus(), progress=lambda stage, done: stages.append((stage, done)))
        self.assertGreater(len({s for s, _ in stages}), 2)
        self.assertTrue(all(0 <= done <= 1 for _, done in stages))
        self.refused(sqmap.Cancelled, sqmap.bake, torus(), progress=lambda stage, done: True)
        with self.assertRaises(ZeroDivisionError):
            sqmap.bake(torus(), progress=lambda stage, done: 1 / 0)

    def test_pictures_that_cannot_be_drawn(self):
        self.refused(sqmap.Error, ball_model().render, "smell")
        self.refused(sqmap.Error, ball_model().render, size=(10, 10))
        self.refused(sqmap.ArgumentError, ball_model().render, size=(10, 10, 10))


if __name__ == "__main__":
    unittest.main()
