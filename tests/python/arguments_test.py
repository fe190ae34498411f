"""Every public function, class and method of the package with every argument missing, closed, of another type or shape, or NaN: an
error of the package that names the argument, and never an answer that reads as free.

Functions and parameters are those that inspect sees; a parameter that the tables below do not know fails the test. Two answers that
are no errors are documented: NaN for a point that is not finite, no force and the bit "not finite" for a tick."""
import inspect
import pathlib
import tempfile
import unittest

import numpy as np
import sqmap
from support import ball

NAN, INF = np.nan, np.inf
SHAPES = [5, "here", object(), [[1, 2], [3]], [["a", "b", "c"]], np.zeros((3, 3), complex), np.zeros((3, 3), bool),
          np.array([[1, 2, 3]], object), {}, b"\0" * 24]
ROWS = [*SHAPES, np.zeros(3), np.zeros((3, 2)), np.zeros((2, 3, 3))]
LAST_AXIS = [*SHAPES, np.zeros((3, 2)), np.float64(1)]  # of shape {..., 3}
NOT_FINITE = [np.array([[0, 0, 0], [0, bad, 0.9]]) for bad in (NAN, INF, -INF)]


def changed(at, value):
    out = np.eye(4)
    out[at] = value
    return out


POSES = [*SHAPES, np.eye(3), np.zeros((4, 4)), 2 * np.eye(4), np.diag([1.0, 1, -1, 1]), changed((0, 0), 1.01), changed((0, 1), 1e-3),
         changed((3, 0), 1), *(changed((i, j), bad) for i in range(4) for j in range(4) for bad in (NAN, INF)), np.full((4, 4), NAN)]
NUMBERS = ["x", b"1", [1.0, 2.0], NAN, -INF, object(), True, 1j, 10**400]
INTEGERS = ["x", 1.5, -1, NAN, INF, 10**30, [1, 2], object(), True]
FLAGS = [1, 0, "yes", NAN, object(), []]
FACES = [*SHAPES, np.zeros((3, 3)), np.zeros(3, int), np.zeros((3, 2), int), np.array([[0, 1, 99]]), np.array([[0, 1, -1]]),
         np.array([[0, 1, 2**64 - 1]], np.uint64), np.zeros((0, 3), int)]
PATHS = [5, object(), "a\0b", 1.5, []]
VERTICES, TRIANGLES = ball(2)

# Wrong values by the name of a parameter, then by its annotation. None is tried too where a parameter is required or has a default.
BY_NAME = {
    "points": ROWS, "direction": [*SHAPES, np.zeros(2), np.zeros(3), np.array([0, NAN, 1]), np.array([INF, 0, 0])], "number": [*INTEGERS, 2**32 - 1],
    "targets": [*ROWS, *NOT_FINITE], "normals": [*ROWS, *NOT_FINITE, np.zeros((7, 3))], "query_points": LAST_AXIS,
    "poses": [*SHAPES, np.zeros((4, 4)), np.zeros((2, 3, 3)), *(p[None] for p in POSES[len(SHAPES) + 1:] if np.isfinite(p).all())],
    "pose": POSES, "model_pose": POSES, "pose_a": POSES, **dict.fromkeys(("start", "end"), [*SHAPES, np.zeros((1, 3, 3)), np.zeros((2, 4, 3))]), "separation": [*NUMBERS, -1], "path": PATHS, "data": [5, "text", object(), b"", b"x" * 99, np.zeros((4, 4))[:, ::2]],
    "mesh": [5, object(), (VERTICES,), (VERTICES, TRIANGLES, 1), "there/is/none.off", "a\0b", *((VERTICES, f) for f in FACES),
             *((v, TRIANGLES) for v in [*ROWS, *NOT_FINITE, np.zeros((0, 3))])],
    "vertices": [*ROWS, np.zeros((0, 3)), *NOT_FINITE], "triangles": FACES, "handle": [5, "x", object()],
    "max_parts": [*INTEGERS, 0, 2000], "size": [5, "x", (1, 2, 3), ("a", "b"), (1.5, 2), (-1, 9), [object(), 1]],
    "what": ["smell", 5, b"parts", object()], "key": [5, object(), b"0" * 64], "up": ["w", 5, object(), []],
    "layer": [7, 0, True, "deep", 3.5, [3], object(), NAN], "mode": ["glued", 5, [], object()], **dict.fromkeys(("force", "friction_law", "projector"), ["glued", 5, [], object()]), "gate": [*INTEGERS, 0],
    "nearest_steps": [*INTEGERS, 101], "tool": [5, "x", object(), sqmap.Probe(VERTICES)], "repair": ["glue", 5, [], object()], "solid": ["inner", 5, [], object()],
    "projection": ["mercator", 5, [], object()], "source": [5, object(), b"x"], "progress": [5, "bar", object(), []],
    "format": ["step", 5, [], object()], "shape": ["egg", "spheres:0", "spheres:5000", "spheres:x", 5, [], object()],
    "cuts": ["deep", 5, [], object()], **dict.fromkeys(("mean_curvature", "smoothing", "smoothing_kernel"), ["glued", 5, [], object()]), "paper": [5, "printed", {}, object()],
    "grid": [5, "9x9", (5,), (4, 8), (5, 7), (5, 9000), (5.5, 8), (5, 8, 9), object()],
    "nsamples": [*INTEGERS, 0, 2], "time": NUMBERS, "distance": [*NUMBERS, -1], "sample_time": NUMBERS, "sequence": INTEGERS, "acts": [*INTEGERS, 32],
    "unit": ["parsec", b"mm", 0, -1, NAN, INF, object(), True, []],
    "extents": [*SHAPES, (1, 2), (1, 0, 1), (1, -1, 1), (1, NAN, 1)], "radius": [*NUMBERS, -1], "subdivisions": [*INTEGERS, 9],
    **{name: [*NUMBERS, 0, -1] for name in ("major_radius", "half_length")}, "minor_radius": [*NUMBERS, 0, 1],
    **{name: [*INTEGERS, 2, 10**5] for name in ("major_segments", "minor_segments")}, "segments": [*INTEGERS, 0, 10**5],
}
BY_ANNOTATION = {"float": NUMBERS, "Optional[float]": NUMBERS, "int": INTEGERS, "Optional[int]": INTEGERS, "bool": FLAGS}
KINDS = {"Model": sqmap.Model, "Probe": sqmap.Probe, "Body": sqmap.Body, "Workspace": sqmap.Workspace}


class Arguments(unittest.TestCase):
    parameters = tried = named = documented = 0

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.model = sqmap.bake(ball(2))
        cls.probe, cls.workspace = sqmap.Probe(VERTICES, TRIANGLES), sqmap.Workspace(500)
        cls.file = pathlib.Path(cls.folder.name, "ball.sqmap")
        cls.model.save(cls.file)
        cls.closed = {"Model": sqmap.Model.load(cls.file), "Probe": sqmap.Probe(VERTICES), "Workspace": sqmap.Workspace(5)}
        for thing in cls.closed.values():
            thing.close()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
        print(f"\n{len(cls.callables())} callables, {cls.parameters} parameters: {cls.tried} wrong values, {cls.named} named by an "
              f"error, {cls.documented} answered as documented")

    @classmethod
    def objects(cls):
        """An object of each class that has methods."""
        normals = VERTICES / np.linalg.norm(VERTICES, axis=1, keepdims=True)
        pile = sqmap.Pile(500)
        pile.add(sqmap.Body(cls.model, cls.probe))
        return {"Pile": pile, "Model": cls.model, "Probe": cls.probe, "Workspace": cls.workspace, "Scene": sqmap.Scene(cls.model),
                "Session": sqmap.Session(cls.model), "TactilePad": sqmap.TactilePad(VERTICES, normals),
                "Body": sqmap.Body(cls.model, cls.probe)}

    @classmethod
    def callables(cls):
        """{name: callable} of all that is public and no result."""
        objects, out = cls.objects(), {f"shapes.{name}": getattr(sqmap.shapes, name) for name in sqmap.shapes.__all__}
        out["Superquadric.implicit"] = objects["Model"].superquadrics[0].implicit
        out["Shape.signed_distance"] = sqmap.shapes.box().signed_distance
        for name in sqmap.__all__:
            value = getattr(sqmap, name)
            if inspect.isfunction(value):
                out[name] = value
            if not inspect.isclass(value) or issubclass(value, (tuple, Exception)):
                continue
            out[name] = value
            for key in vars(value):
                if not key.startswith("_") and callable(getattr(value, key)):
                    out[f"{name}.{key}"] = getattr(objects[name], key)
        return out

    def good(self, name, function):
        """Good arguments for the required parameters."""
        known = {"points": VERTICES, "normals": VERTICES, "targets": np.full((5, 3), 2.0), "query_points": VERTICES,
                 "model": self.model, "probe": self.probe, "a": sqmap.Body(self.model, self.probe),
                 "b": sqmap.Body(self.model, self.probe), "start": np.zeros((1, 4, 3)), "end": np.zeros((1, 4, 3)), "vertices": (VERTICES, TRIANGLES), "mesh": (VERTICES, TRIANGLES),
                 "data": self.model.to_bytes(), "time": 0.5, "pose": np.eye(4), "distance": 0.5, "body": sqmap.Body(self.model, self.probe), "number": 0,
                 "poses": np.eye(4)[None],
                 "path": self.file if name == "Model.load" else pathlib.Path(self.folder.name, "out.obj")}
        return {p.name: known[p.name] for p in inspect.signature(function).parameters.values()
                if p.default is p.empty and p.kind is p.POSITIONAL_OR_KEYWORD and p.name in known}

    def wrong(self, name, parameter):
        """Wrong values of a parameter."""
        annotation = parameter.annotation if isinstance(parameter.annotation, str) else parameter.annotation.__name__
        kind = annotation.removeprefix("Optional[").removesuffix("]")
        if kind in KINDS:
            others = [self.model, self.probe, self.workspace, 5, "x", object(), [self.model]]
            out = [x for x in others if not isinstance(x, KINDS[kind])] + ([self.closed[kind]] if kind in self.closed else [])
        elif parameter.name in BY_NAME:
            out = list(BY_NAME[parameter.name])
        else:
            self.assertIn(annotation, BY_ANNOTATION, f"{name}: no wrong values are known for {parameter}")
            out = list(BY_ANNOTATION[annotation])
        if parameter.name == "points":
            out += [*NOT_FINITE, *([np.zeros((0, 3))] if name in ("Probe", "TactilePad") else [])]
        if parameter.name == "query_points":
            out += NOT_FINITE
        if parameter.default is not None:
            out.append(None)
        return out

    def test_every_argument(self):
        for name, function in self.callables().items():
            for parameter in inspect.signature(function).parameters.values():
                if parameter.kind is parameter.VAR_KEYWORD:
                    continue  # of sqmap.bake, which is tried itself
                type(self).parameters += 1
                for value in self.wrong(name, parameter):
                    with self.subTest(function=name, parameter=parameter.name, value=repr(value)[:60]):
                        self.try_one(name, function, parameter, value)

    def try_one(self, name, function, parameter, value):
        type(self).tried += 1
        arguments = self.good(name, function)
        if name == "Scene.add_triangles":
            arguments |= {"vertices": VERTICES, "triangles": TRIANGLES}
        if name == "TactilePad" and isinstance(value, np.ndarray) and value.shape[-1:] == (3,):
            arguments["normals"] = np.ones(value.shape)
        if name == "Session.tick":  # a new session, and the tick after its first
            function = sqmap.Session(self.model).tick
            self.assertEqual(function(np.eye(4), 0.499).acted & 1, 0)
        if parameter.kind is parameter.VAR_POSITIONAL:
            call = lambda: function(value)  # noqa: E731
        elif name == "Body":  # what is wrong with a body shows where it has a role
            call = lambda: sqmap.query_pair(sqmap.Body(**{"model": self.model, "probe": self.probe, parameter.name: value}),  # noqa: E731
                                            sqmap.Body(self.model, self.probe))
        else:
            if parameter.name == "sample_time":
                arguments["time"] = 0.5
            arguments[parameter.name] = value
            call = lambda: function(**arguments)  # noqa: E731
        try:
            answer = call()
        except sqmap.Error as e:
            self.assertTrue(e.code and e.element and e.message and e.cure)
            names = {parameter.name, parameter.name.removesuffix("s"), *(("vertices", "triangles", "mesh", "bytes", "file")
                     if parameter.name in ("mesh", "vertices", "triangles", "data") else ()), *([value] if isinstance(value, str) else [])}
            self.assertTrue(any(n and n in e.element for n in names), f"{e.element} does not name {parameter.name}: {e}")
            if isinstance(value, np.ndarray) and parameter.name.endswith("pose") and value.dtype == float and np.isnan(value).any():
                self.assertIn("NaN", e.message)
            type(self).named += 1
            return
        type(self).documented += 1
        self.assertTrue(self.is_documented(name, parameter.name, value, answer), f"answered {answer!r}"[:300])

    def is_documented(self, name, parameter, value, answer):
        if isinstance(answer, sqmap.Force):
            return answer.acted & 1 == 1 and not answer.force.any() and not answer.torque.any()
        if parameter not in ("points", "query_points") or not any(value is x for x in NOT_FINITE):
            return False
        if name == "Scene.compute_closest_points":
            return np.isnan(answer["points"][1]).all() and answer["geometry_ids"][1] == sqmap.Scene.INVALID_ID
        if isinstance(answer, sqmap.Contacts):
            return np.isnan(answer.depth[1]) and answer.status[1] & 1
        distance = answer.distance if isinstance(answer, sqmap.Distances) else answer[1] if isinstance(answer, tuple) else answer
        return np.isnan(distance[1]) and not np.isnan(distance[0])

    def test_closed_objects(self):
        calls = 0
        for cls, make in (("Model", lambda: sqmap.Model.load(self.file)), ("Session", lambda: sqmap.Session(self.model)),
                          ("TactilePad", lambda: self.objects()["TactilePad"])):
            thing = make()
            thing.close()
            for key, member in vars(getattr(sqmap, cls)).items():
                if key.startswith("_") or isinstance(member, classmethod):
                    continue
                calls += 1
                with self.subTest(cls=cls, member=key), self.assertRaises(sqmap.ClosedError) as raised:
                    function = getattr(thing, key)
                    function(**self.good(f"{cls}.{key}", function))
                self.assertIn(cls, raised.exception.element)
        self.assertGreater(calls, 18)

    def test_bodies_lack_nothing_that_their_role_needs(self):
        whole = {"model": self.model, "probe": self.probe}
        for missing in range(16):
            lacks = {key for bit, key in enumerate(("a.model", "a.probe", "b.model", "b.probe")) if missing >> bit & 1}
            a, b = (sqmap.Body(**{k: v for k, v in whole.items() if f"{side}.{k}" not in lacks}) for side in "ab")
            if lacks & {"a.model", "b.probe"} and lacks & {"b.model", "a.probe"}:
                with self.assertRaises(sqmap.ArgumentError) as raised:
                    sqmap.query_pair(a, b)
                self.assertIn(raised.exception.element, lacks)
            else:
                self.assertGreater(sqmap.query_pair(a, b).found, 0)
            b.model = 5
            with self.assertRaises(sqmap.ArgumentError):
                sqmap.query_pair(a, b)

    def test_failures_of_files_are_of_the_family(self):
        folder = pathlib.Path(self.folder.name)
        for call in (lambda: self.model.export(folder), lambda: self.model.export(folder / "none" / "a.obj"),
                     lambda: self.model.export(folder / "none" / "a.json"), lambda: self.model.save(folder / "none" / "a.sqmap"),
                     lambda: self.model.save(folder), lambda: sqmap.Model.load(folder), lambda: sqmap.bake(folder),
                     lambda: sqmap.bake(folder / "none.off"), lambda: sqmap.Model.load(folder / "none.tar", "0" * 64)):
            with self.assertRaises(sqmap.Error):
                call()


if __name__ == "__main__":
    unittest.main()
