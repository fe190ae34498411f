"""Bad input through every door of the package: an exception with code, element and cure, never anything else."""
import os
import pathlib
import pty
import re
import signal
import subprocess
import sys
import tempfile
import threading
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
        self.assertNotIn("sqmap_", str(error), "a name of C")
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
        for options in ({"target_error": 0}, {"target_error": -1}, {"target_error": np.nan}, {"band": 101}, {"band": -1},
                        {"max_parts": 0.5}, {"max_parts": -1}, {"max_parts": 10**9}, {"threads": 5000}, {"repair": "glue"},
                        {"projection": "mercator"}, {"thickness": -1}, {"thickness": np.nan}, {"solid": "inner"}, {"solid": None},
                        {"gap": -1}, {"gap": 0.21}, {"gap": np.nan}, {"wrap_tolerance": 0.001}, {"wrap_tolerance": "fine"}):
            self.refused(sqmap.ArgumentError, sqmap.bake, ball(), **options)
        for options in ({"metres_per_unit": 0}, {"metres_per_unit": -1}, {"metres_per_unit": np.nan}, {"radius": -1}, {"radius": 5},
                        {"stiffness": 0}, {"stiffness": 1e9}, {"stiffness": np.nan}, {"damping": -1}, {"friction": -0.1},
                        {"friction": np.nan}, {"max_force": -1}, {"max_force": np.nan}, {"force_limit": -1},
                        {"max_force": 1, "force_limit": 2}, {"layer": 9}, {"mode": "glued"}, {"mode": []},
                        {"side_path": -1}, {"side_path": np.nan}, {"force": "paper"}, {"projector": "printed"}, {"gaps": False},
                        {"pruning": False}, {"nearest_steps": 0}, {"gate": 0}, {"f_c": -1}, {"k_f": np.nan}):
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
            self.assertIsInstance(self.refused(sqmap.FileError, sqmap.bake, path), OSError)
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
                     lambda: sqmap.query_pair(sqmap.Body(ball_model()), sqmap.Body(probe=sqmap.Probe(POINTS)), workspace),
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

    def test_the_callback_runs_on_the_callers_thread(self):
        threads = set()
        sqmap.bake(ball(1), progress=lambda stage, done: threads.add(threading.get_ident()) or False)
        self.assertEqual(threads, {threading.get_ident()})

    def test_control_c_stops_a_bake(self):
        interrupt = lambda *_: os.kill(os.getpid(), signal.SIGINT)  # noqa: E731
        with self.assertRaises(KeyboardInterrupt):
            sqmap.bake(torus(), progress=interrupt)
        timer = threading.Timer(0.05, interrupt)
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            sqmap.bake(ball(5))
        sqmap.bake(ball(1))  # and the next one goes through

    def test_a_bar_on_a_terminal_and_a_line_a_stage_elsewhere(self):
        code = "import sqmap, support; sqmap.bake(support.ball(1), progress=True)"
        piped = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        self.assertIn("decompose\nfit\n", piped.stderr)
        self.assertEqual(piped.stdout, "")
        ours, theirs = pty.openpty()
        subprocess.run([sys.executable, "-c", code], stderr=theirs, check=True)
        drawn = os.read(ours, 1 << 16).decode()
        self.assertRegex(drawn, r"\rdecompose +\[ +\]   0%\r")
        self.assertTrue(drawn.endswith("100%\r\n"), drawn)

    def test_elements_count_from_zero_in_the_callers_words(self):
        vertices, triangles = ball(2)
        wrong = triangles.copy()
        wrong[7, 2] = 10**6
        for mesh, element in (((vertices, wrong), "triangles[7]"), ((np.where(np.arange(len(vertices))[:, None] == 5, np.nan, vertices),
                                                                     triangles), "vertices[5]")):
            self.assertEqual(self.refused(sqmap.MeshError, sqmap.bake, mesh).element, element)
        opened = self.refused(sqmap.MeshError, sqmap.bake, (vertices, triangles[1:]), repair="none")
        edge = re.fullmatch(r"edge vertices\[(\d+)\]-vertices\[(\d+)\]", opened.element)
        self.assertLessEqual({int(edge[1]), int(edge[2])}, set(triangles[0].tolist()))
        self.assertIn("surface=True", opened.cure)
        self.assertEqual(self.refused(sqmap.ArgumentError, sqmap.Probe, [[0, 0, 0], [0, np.inf, 0]]).element, "points[1]")
        self.assertEqual(self.refused(sqmap.ArgumentError, sqmap.Probe, vertices, wrong).element, "triangles[7]")
        self.assertEqual(self.refused(sqmap.ArgumentError, sqmap.Probe, vertices, triangles[:0]).element, "triangles")
        self.assertRegex(self.refused(sqmap.MeshError, sqmap.Probe, vertices, triangles[1:]).element, r"^triangles\[\d+\]$")
        self.assertEqual(self.refused(sqmap.MeshError, sqmap.Probe, 1e-13 * vertices, triangles).element, "points")
        pile = sqmap.Pile()
        self.assertEqual(self.refused(sqmap.ArgumentError, pile.query, np.eye(4)[None]).element, "poses")
        self.assertEqual(self.refused(sqmap.ArgumentError, pile.remove, 3).element, "number")
        pose = np.eye(4)
        pose[1, 2] = np.nan
        error = self.refused(sqmap.ArgumentError, sqmap.query_probe, ball_model(), sqmap.Probe(POINTS), model_pose=pose)
        self.assertEqual((error.element, error.message), ("model_pose[1, 2]", "is NaN"))
        pose[1, 2] = 1e-3
        self.assertIn("tolerance is 0.0001", self.refused(sqmap.ArgumentError, ball_model().query, POINTS, pose=pose).message)
        self.assertEqual(self.refused(sqmap.ArgumentError, sqmap.Session, ball_model(), force_limit=np.nan).element, "force_limit")
        self.assertIn("exact=True", self.refused(sqmap.MissingError, sqmap.bake(ball(2), exact=False).closest_point, POINTS).cure)
        with tempfile.TemporaryDirectory() as folder:  # the elements of a file are counted as its format does, from one
            path = pathlib.Path(folder, "bad.off")
            path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n")
            self.assertEqual(self.refused(sqmap.MeshError, sqmap.bake, path).element, "face 1")

    def test_pictures_that_cannot_be_drawn(self):
        self.refused(sqmap.Error, ball_model().render, "smell")
        self.refused(sqmap.Error, ball_model().render, size=(10, 10))
        self.refused(sqmap.ArgumentError, ball_model().render, size=(10, 10, 10))


if __name__ == "__main__":
    unittest.main()
