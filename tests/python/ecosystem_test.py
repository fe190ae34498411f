"""Objects of other libraries as points and meshes, and models in other processes."""
import copy
import importlib.util
import pathlib
import pickle
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import sqmap
from support import ball, ball_model, moved, torus, torus_model

POINTS = np.random.default_rng(5).uniform(-1.5, 1.5, (50, 3))
POOL = """
import multiprocessing, sys
import numpy as np, sqmap

def clearance(body, tool, pose):
    return len(sqmap.query_probe(body, tool, pose).contacts)

if __name__ == "__main__":
    body, tool = sqmap.Model.load(sys.argv[1]), sqmap.Probe([[1.0, 0, 0], [3, 0, 0]])
    poses = [np.array([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]) for x in (0, 0.05, 0.9)]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        print(pool.starmap(clearance, [(body, tool, pose) for pose in poses]))
        try:
            pool.apply(body.signed_distance, ([1, 2],))
        except sqmap.ArgumentError as e:
            print(e.code, e.element)
"""


class Foreign:
    """An object that has nothing but __array_interface__."""

    def __init__(self, array):
        self._array = array
        self.__array_interface__ = array.__array_interface__


class SceneOfTwo:
    """The members of a trimesh.Scene that are read: two instances of a ball."""

    geometry = {"ball": None}

    def dump(self, concatenate):
        assert concatenate
        v, t = ball(2)
        mesh = type("Mesh", (), {})()
        mesh.vertices, mesh.faces = np.concatenate([v, v + [4, 0, 0]]), np.concatenate([t, t + len(v)])
        return mesh


class Ecosystem(unittest.TestCase):
    def test_arrays_of_other_libraries_are_taken(self):
        model, (vertices, triangles) = ball_model(), ball()
        np.testing.assert_array_equal(model.signed_distance(Foreign(POINTS)), model.signed_distance(POINTS))
        self.assertEqual(sqmap.bake((Foreign(vertices), Foreign(triangles))).to_bytes(), sqmap.bake((vertices, triangles)).to_bytes())
        self.assertIs(sqmap._arrays.rows(POINTS), POINTS)

    def test_a_scene_is_baked_with_all_its_instances(self):
        model = sqmap.bake(SceneOfTwo())
        np.testing.assert_array_equal(model.contains([[0, 0, 0], [2, 0, 0], [4, 0, 0]]), [True, False, True])

    def test_a_scene_of_trimesh(self):
        try:
            import trimesh
        except ImportError:
            print("skipped in part: needs libraries of others (Debian: python3-scipy python3-torch; PyPI: trimesh)")
            return
        mesh = trimesh.Trimesh(*ball(2), process=False)
        scene = trimesh.Scene([mesh])
        scene.add_geometry(mesh, transform=moved(4, 0, 0))
        self.assertTrue(sqmap.bake(scene).contains([[4.9, 0, 0]])[0])
        self.assertEqual(sqmap.bake(mesh).to_bytes(), sqmap.bake(ball(2)).to_bytes())
        with self.assertRaises(sqmap.MeshError):
            sqmap.bake(trimesh.Scene())

    def test_tensors_of_torch_are_taken_without_a_copy(self):
        self.assertNotIn("torch", sys.modules)
        if importlib.util.find_spec("torch") is None:
            print("skipped in part: needs libraries of others (Debian: python3-scipy python3-torch; PyPI: trimesh)")
            return
        import torch
        points, model = torch.from_numpy(POINTS.copy()), ball_model()
        self.assertEqual(sqmap._arrays.rows(points).ctypes.data, points.data_ptr())
        np.testing.assert_array_equal(model.signed_distance(points), model.signed_distance(POINTS))
        self.assertEqual(torch.from_numpy(model.signed_distance(points)).dtype, torch.float64)
        self.assertEqual(sqmap.bake(tuple(torch.from_numpy(a) for a in ball(2))).to_bytes(), sqmap.bake(ball(2)).to_bytes())
        for wrong in (points.clone().requires_grad_(), points.to("meta")):
            with self.assertRaises(sqmap.ArgumentError) as raised:
                model.contains(wrong)
            self.assertEqual((raised.exception.element, raised.exception.cure), ("points", "give points.detach().cpu()"))

    def test_models_probes_and_errors_are_pickled(self):
        model = torus_model()
        probe = sqmap.Probe.of(model)
        body = pickle.loads(pickle.dumps(sqmap.Body(model, probe, moved(0.1, 0, 0))))
        self.assertEqual(body.model.to_bytes(), model.to_bytes())
        np.testing.assert_array_equal(body.probe.source_triangle, probe.source_triangle)
        there, here = (sqmap.query_contacts(sqmap.Body(model, probe), b) for b in (body, sqmap.Body(model, probe, moved(0.1, 0, 0))))
        np.testing.assert_array_equal(there.contacts, here.contacts)
        twin = copy.deepcopy(model)
        twin.close()
        self.assertFalse(model.closed)
        for wrong in (lambda: model.query([1, 2]), lambda: model.save("/none/a.sqmap"), lambda: sqmap.bake((np.eye(3), [[0, 1, 5]]))):
            with self.assertRaises(sqmap.Error) as raised:
                wrong()
            again = pickle.loads(pickle.dumps(raised.exception))
            self.assertEqual((type(again), str(again), again.cure), (type(raised.exception), str(raised.exception), again.cure))
        for one in (sqmap.Session(model), sqmap.TactilePad([[0, 0, 0]], [[0, 0, 1]])):
            with self.assertRaises(sqmap.ArgumentError) as raised:
                pickle.dumps(one)
            self.assertEqual(raised.exception.element, type(one).__name__)
        self.assertEqual(len(pickle.loads(pickle.dumps(sqmap.Probe(POINTS)))), len(POINTS))
        self.assertFalse(pickle.loads(pickle.dumps(sqmap.Workspace(7))).closed)

    def test_a_spawned_pool_queries(self):
        with tempfile.TemporaryDirectory() as folder:
            model, script = pathlib.Path(folder, "ring.sqmap"), pathlib.Path(folder, "pool.py")
            torus_model().save(model)
            script.write_text(POOL)
            done = subprocess.run([sys.executable, script, model], capture_output=True, text=True, check=False)
        self.assertEqual(done.stdout, "[1, 1, 0]\nE_ARGUMENT points\n", done.stderr)

    def test_a_copied_model_survives_its_file(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "ring.sqmap")
            torus_model().save(file)
            model = sqmap.Model.load(file, copy=True)
            file.write_bytes(b"")
            np.testing.assert_array_equal(model.signed_distance(POINTS), torus_model().signed_distance(POINTS))

    def test_contacts_are_named_as_in_the_mesh_that_was_given(self):
        vertices, triangles = torus()
        order = np.random.default_rng(2).permutation(len(vertices))
        back = np.argsort(order)
        model = sqmap.bake((vertices[order], back[triangles]))
        probe = sqmap.Probe.of(model)
        found = sqmap.query_probe(model, probe, moved(0.2, 0, 0))
        self.assertGreater(len(found.contacts), 20)
        given = vertices[order][probe.source_vertex[found.contacts["index"]]]
        distance = np.linalg.norm(found.points - (given + [0.2, 0, 0]), axis=1)
        np.testing.assert_allclose(distance, found.contacts["depth"], atol=1e-5)
        self.assertIsNone(sqmap.Probe.of(sqmap.bake(ball(2), keep_input=False)).source_vertex)


if __name__ == "__main__":
    unittest.main()
