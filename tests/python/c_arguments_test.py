"""Every function of include/sqmap.h with every argument missing, closed, of another kind, wrong or NaN: an error that names it.

Functions, arguments, members and which of them may be null are read from the header, so that a new function is tried without a
line here. Two answers that are no errors are documented: NaN for a point that is not finite, no force and the bit "not finite" for a tick.

usage: c_arguments_test.py HEADER"""
import ctypes
import itertools
import math
import pathlib
import re
import sys
import tempfile
import unittest

import numpy as np
import sqmap
from sqmap import _library as c
from support import ball

with open(sys.argv[1], encoding="utf-8") as file:
    TEXT = file.read()
del sys.argv[1:]
HANDLES = ("model", "probe", "workspace", "session", "pad", "pile")
NAN, INF = math.nan, math.inf


def declarations():
    """{function: ([(type, name)], comment)}."""
    out = {}
    for comment, name, parameters in re.findall(r"((?:^///[^\n]*\n)*)^SQMAP_API sqmap_code (\w+)\(([^)]*)\);", TEXT, re.MULTILINE):
        pairs = [re.fullmatch(r"\s*(.*?)\s*(\w+)\s*", p).groups() for p in parameters.split(",")]
        out[name] = pairs, comment
    return out


def struct_members():
    """{struct: ({member: (type, comment)}, comment of the struct)}."""
    out = {}
    for comment, name, body in re.findall(r"((?:^///[^\n]*\n)*)^typedef struct (\w+) \{\n(.*?)^\} \2;", TEXT, re.MULTILINE | re.DOTALL):
        members = {}
        for kind, names, said in re.findall(r"^ +((?:const )?\w+\*?) ([\w, \[\]]+);(?: *///< ([^\n]*))?", body, re.MULTILINE):
            for member in names.split(","):
                members[re.sub(r"\[.*", "", member).strip()] = kind, said
        out[name] = members, comment
    return out


FUNCTIONS, STRUCTS = declarations(), struct_members()
ENUMS = set(re.findall(r"^(?:typedef )?enum (\w+)", TEXT, re.MULTILINE))


class World:
    """An open handle of each kind, a closed one of each, and good arguments."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        vertices, triangles = ball(2)
        self.kept, self.positions = [], itertools.count()
        self.vertices, self.faces = self.array(vertices), self.array(triangles)
        self.model_file, self.mesh_file = self.folder / "ball.sqmap", self.folder / "ball.off"
        model = sqmap.bake(ball(2))
        model.save(self.model_file)
        self.bytes = model.to_bytes()
        self.mesh_file.write_text("OFF\n%d %d 0\n" % (len(vertices), len(triangles)) + "".join(f"{x} {y} {z}\n" for x, y, z in vertices)
                                  + "".join(f"3 {i} {j} {k}\n" for i, j, k in triangles))
        self.points = [[0, 0, 0], [0, 0, 0.9], [0, 0.1, 0.8], [2, 0, 0]]
        self.open = self.opened()
        self.closed = self.opened()
        self.solid = c.Handle()
        c.call("sqmap_make_solid_probe", self.struct("sqmap_mesh"), self.solid)
        for _ in self.points:
            self.body()
        for kind in HANDLES:
            c.call(f"sqmap_close_{kind}", self.closed[kind])

    def array(self, values, dtype=None):
        self.kept.append(np.ascontiguousarray(values, dtype))
        return self.kept[-1]

    def opened(self):
        out = {}
        for kind, make in (("model", lambda h: c.call("sqmap_open", str(self.model_file).encode(), h)),
                           ("probe", lambda h: c.call("sqmap_make_probe", self.struct("sqmap_points"), h)),
                           ("workspace", lambda h: c.call("sqmap_make_workspace", 16, h)),
                           ("session", lambda h: c.call("sqmap_make_session", out["model"], None, h)),
                           ("pad", lambda h: c.call("sqmap_make_pad", self.struct("sqmap_points"),
                                                    self.array([[0, 0, 1.0]] * 4).ctypes.data, None, h)),
                           ("pile", lambda h: c.call("sqmap_make_pile", 16, h))):
            out[kind] = c.Handle()
            make(out[kind])
        return out

    def poses(self, second):
        """As many as there are points, of which the second is this one."""
        array = (c.Pose * len(self.points))(*(second if i == 1 else pose_with(0, 1) for i in range(len(self.points))))
        self.kept.append(array)
        return ctypes.cast(array, ctypes.POINTER(c.Pose))

    def struct(self, name):
        """A good struct."""
        n = len(self.points)
        space = lambda *shape: self.array(np.full(shape, 7.0)).ctypes.data  # noqa: E731
        if name == "sqmap_points":
            return c.Points(xyz=self.array(self.points, float).ctypes.data, count=n)
        if name == "sqmap_mesh":
            return c.Mesh(vertices=self.vertices.ctypes.data, vertex_count=len(self.vertices), triangles=self.faces.ctypes.data,
                          triangle_count=len(self.faces))
        if name == "sqmap_pose":
            return pose_with(0, 1)
        if name == "sqmap_bodies":
            a, b = (c.Body(self.open["model"], self.open["probe"], None) for _ in range(2))
            return c.Bodies(a=a, b=b)
        if name == "sqmap_pad_tick":
            return c.PadTick(model=self.open["model"], dt=0.001)
        if name == "sqmap_tick":
            out = c.Tick(time=1, sample_time=1, sequence=1)
            out.pose.rotation[:] = [1, 0, 0, 0, 1, 0, 0, 0, 1]
            return out
        if name == "sqmap_simulation":
            return c.Simulation(targets=self.array(self.points, float).ctypes.data, count=n)
        if name == "sqmap_body":
            return c.Body(self.open["model"], self.solid, None)
        if name == "sqmap_moving_features":
            corners = self.array(self.points, float)  # of one feature
            return c.MovingFeatures(start=corners.ctypes.data, end=corners.ctypes.data, count=1)
        if name == "sqmap_pile_step":
            return c.PileStep(pose=self.poses(pose_with(0, 1)), count=n)
        if name == "sqmap_poses":
            return c.Poses(pose=self.poses(pose_with(0, 1)), count=n)
        if name == "sqmap_contact_list":
            return c.ContactList(contacts=space(8 * n), capacity=n)
        if name == "sqmap_taxels":
            return c.Taxels(taxels=space(8 * n), count=n)
        if name == "sqmap_text":
            return c.Text(text=ctypes.cast(ctypes.create_string_buffer(8), ctypes.c_char_p), capacity=8)
        own = getattr(c, "".join(word.title() for word in name.split("_")[1:]))
        out = own()
        if name in ("sqmap_contacts", "sqmap_distances", "sqmap_closest", "sqmap_pose_clearances", "sqmap_touches"):
            for member, kind in own._fields_:
                if kind is ctypes.c_void_p:
                    setattr(out, member, space(n, 6))
        return out

    def body(self):
        """The number of a new one in the pile, far from the others: bodies in one place would touch each other everywhere."""
        out, pose = ctypes.c_uint32(), pose_with(9, 10.0 * next(self.positions))
        c.call("sqmap_add_body", self.open["pile"], c.Body(c.Handle(0), self.solid, ctypes.pointer(pose)), out)
        return out.value

    def argument(self, function, kind, name):
        """A good argument."""
        if kind.startswith("sqmap_") and kind.endswith("*"):
            return c.Handle()  # where a new one is written
        if kind.startswith("const sqmap_"):
            return self.struct(kind[6:-1])
        if kind.startswith("sqmap_"):
            return c.Handle(self.open[kind[6:]].id)
        if name == "number":
            return ctypes.c_uint32() if "*" in kind else self.body()
        paths = {"sqmap_bake_file": self.mesh_file, "sqmap_save": self.folder / "out.sqmap", "sqmap_export": self.folder / "out.json"}
        return {"path": str(paths.get(function, self.model_file)).encode(),
                "archive": str(self.folder / "none.tar").encode(), "key": b"0" * 64,
                "bytes": ctypes.c_void_p() if "**" in kind else self.bytes,
                "size": ctypes.c_size_t() if "*" in kind else len(self.bytes), "contacts": 16, "part": 0,
                "values": self.array(np.full(len(self.points), 7.0)).ctypes.data,
                "normals": self.array([[0, 0, 1.0]] * 4).ctypes.data,
                "name": b"band", "least": ctypes.c_double(), "greatest": ctypes.c_double()}.get(name)


SOLIDS = ("sqmap_query_contacts", "sqmap_first_touch", "sqmap_query_clearance", "sqmap_query_overlap",
          "sqmap_query_separation")  # both probes have triangles


def pose_with(at, value):
    out = c.Pose()
    out.rotation[:] = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    if at < 9:
        out.rotation[at] = value
    else:
        out.translation[at - 9] = value
    return out


class Arguments(unittest.TestCase):
    tried = named = documented = 0
    arguments = set()

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.world = World(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
        print(f"\n{len(FUNCTIONS)} functions, {len(cls.arguments)} arguments and members: {cls.tried} wrong values, {cls.named} named "
              f"by an error, {cls.documented} answered as documented")

    def good(self, function):
        out = {}
        for kind, name in FUNCTIONS[function][0]:
            if kind.startswith("sqmap_") and kind.endswith("*") and kind[6:-1] not in HANDLES:
                out[name] = self.world.struct(kind[:-1])
            else:
                out[name] = self.world.argument(function, kind, name)
        if function in SOLIDS:
            out["bodies"].a.probe = out["bodies"].b.probe = self.world.solid
        if function == "sqmap_tick_session":  # a new session, and the tick after its first
            c.call("sqmap_make_session", self.world.open["model"], None, out["session"])
            self.assertEqual((self.call(function, out), out["force"].acted & 1), (0, 0))
            out["tick"].time, out["tick"].sample_time, out["tick"].sequence = 1.001, 1.001, 2
        return out

    def call(self, function, arguments):
        return getattr(c.library, function)(*arguments.values())

    def refused(self, function, arguments, element, codes=(1, 2), detail=None):
        """Calls with arguments of which the element is wrong."""
        type(self).tried += 1
        self.arguments.add((function, re.sub(r"\[.*", "", element)))
        code = self.call(function, arguments)
        with self.subTest(function=function, element=element, detail=detail):
            if code == 0 and self.is_documented(function, arguments, element):
                type(self).documented += 1
                return
            self.assertIn(code, codes)
            e = c.library.sqmap_last_error().contents
            self.assertEqual(e.element.decode()[:len(element)], element)
            self.assertTrue(e.message and e.cure)
            for name, argument in arguments.items():  # no handle is left, and no force
                if isinstance(argument, c.Handle) and (f"sqmap_{name}*", name) in FUNCTIONS[function][0]:
                    self.assertEqual(argument.id, 0)
                if isinstance(argument, c.Force):
                    self.assertEqual([*argument.force, *argument.torque], [0] * 6)
            type(self).named += 1

    def is_documented(self, function, arguments, element):
        """A point that is not finite has no depth and no distance; a tick that is not finite has no force and says so in acted."""
        row = lambda member, kind, at=1: ctypes.cast(getattr(arguments[member[0]], member[1]), ctypes.POINTER(kind))[at]  # noqa: E731
        if function == "sqmap_tick_session":
            force = arguments["force"]
            return force.acted & 1 == 1 and [*force.force, *force.torque] == [0] * 6
        if function == "sqmap_query_poses":
            return (element.startswith("poses.pose[1]") and math.isnan(row(("clearances", "distance"), ctypes.c_double))
                    and row(("clearances", "status"), ctypes.c_uint8) & 1 == 1)
        if function == "sqmap_first_touch_features":
            return element in ("features.start[1]", "features.end[1]") and row(("touches", "time"), ctypes.c_double, 0) == 0
        if function == "sqmap_query_pile":
            return element.startswith("step.pose[1]") and arguments["contacts"].status & 1 == 1
        if element != "points.xyz[1]":
            return False
        if function == "sqmap_query_points":
            return math.isnan(row(("contacts", "depth"), ctypes.c_double)) and row(("contacts", "status"), ctypes.c_uint8) & 1 == 1
        if function in ("sqmap_signed_distances", "sqmap_exact_distances"):
            return math.isnan(row(("distances", "distance"), ctypes.c_double))
        if function == "sqmap_implicit":
            return math.isnan(ctypes.cast(arguments["values"], ctypes.POINTER(ctypes.c_double))[1])
        return function == "sqmap_closest_points" and row(("closest", "triangle"), ctypes.c_uint32) == 0xffffffff

    def test_good_arguments_are_taken(self):
        for function in FUNCTIONS:
            if "close" not in function:
                code = self.call(function, self.good(function))
                self.assertEqual(code, 3 if function == "sqmap_open_archived" else 0,
                                 f"{function}: {c.library.sqmap_last_error().contents.message}")

    def test_null_pointers(self):
        for function, (parameters, comment) in FUNCTIONS.items():
            every = "each may be null" in comment.replace("\n/// ", " ")
            for kind, name in parameters:
                if not kind.endswith("*"):
                    continue
                arguments = self.good(function) | {name: None}
                if f"{name} may be null" in comment or (every and kind in ("double*", "uint32_t*", "int32_t*", "int64_t*")):
                    self.assertEqual(self.call(function, arguments), 0, (function, name))
                else:
                    self.refused(function, arguments, name, (1,))

    def test_handles(self):
        for function, (parameters, comment) in FUNCTIONS.items():
            for kind, name in parameters:
                if kind[6:] in HANDLES:
                    for handle in self.wrong_handles(kind[6:]):
                        if handle.id != 0 or "close" not in function:
                            self.refused(function, self.good(function) | {name: handle}, name, (2,), handle.id)
                members = STRUCTS.get(kind.removeprefix("const ").removesuffix("*"), ({},))[0]
                for member, (inner, _) in members.items():
                    for handle in self.wrong_handles(inner[6:]) if inner[6:] in HANDLES else ():
                        arguments = self.good(function)
                        setattr(arguments[name], member, handle)
                        if handle.id == 0 and f"{name}.{member} may be {{0}}" in comment:
                            self.assertEqual(self.call(function, arguments), 0, (function, name, member))
                            continue
                        self.refused(function, arguments, f"{name}.{member}", (2,), handle.id)

    def wrong_handles(self, kind):
        others = [self.world.open[other] for other in HANDLES if other != kind]
        return [c.Handle(0), self.world.closed[kind], *others, c.Handle(99), c.Handle(2**64 - 1)]

    def test_bodies(self):
        for function in ("sqmap_query_probe", "sqmap_query_pair"):
            for side in "ab":
                for member in ("model", "probe"):
                    for handle in self.wrong_handles(member)[1:]:
                        arguments = self.good(function)
                        setattr(getattr(arguments["bodies"], side), member, handle)
                        self.refused(function, arguments, f"bodies.{side}.{member}", (2,), handle.id)
                for at, pose in self.wrong_poses():
                    arguments = self.good(function)
                    getattr(arguments["bodies"], side).pose = ctypes.pointer(pose)
                    self.refused(function, arguments, f"bodies.{side}.pose.{at}", (1,))
        # Each set of members that are missing: only what a role needs may not.
        for missing in range(16):
            lacks = {key for bit, key in enumerate(("a.model", "a.probe", "b.model", "b.probe")) if missing >> bit & 1}
            for function in ("sqmap_query_probe", "sqmap_query_pair"):
                arguments = self.good(function)
                for key in lacks:
                    setattr(getattr(arguments["bodies"], key[0]), key[2:], c.Handle(0))
                there, back = lacks & {"a.model", "b.probe"}, lacks & {"b.model", "a.probe"}
                if there and (back or function == "sqmap_query_probe"):
                    self.refused(function, arguments, "bodies.", (2,), lacks)
                    self.assertIn(c.library.sqmap_last_error().contents.element.decode()[7:], lacks)
                else:
                    self.assertEqual(self.call(function, arguments), 0, (function, lacks))
                    self.assertGreater(arguments["contacts"].found, 0)

    def test_solids(self):
        for at, pose in self.wrong_poses():
            self.refused("sqmap_first_touch", self.good("sqmap_first_touch") | {"end_pose": pose}, f"end_pose.{at}", (1,))
            arguments = self.good("sqmap_first_touch")
            arguments["touch"].end_pose_a = ctypes.pointer(pose)
            self.refused("sqmap_first_touch", arguments, f"touch.end_pose_a.{at}", (1,))
        for within in (-1, float("nan")):
            arguments = self.good("sqmap_query_clearance")
            arguments["clearance"].within = within
            self.refused("sqmap_query_clearance", arguments, "clearance.within", (1,), within)
        for k, bad in enumerate((NAN, INF, -INF)):
            arguments = self.good("sqmap_query_separation")
            arguments["separation"].along[k] = bad
            self.refused("sqmap_query_separation", arguments, f"separation.along[{k}]", (1,), bad)
        for function in SOLIDS:
            for side in "ab":
                for handle in self.wrong_handles("probe"):
                    arguments = self.good(function)
                    getattr(arguments["bodies"], side).probe = handle
                    self.refused(function, arguments, f"bodies.{side}.probe", (2,), handle.id)
                arguments = self.good(function)
                getattr(arguments["bodies"], side).probe = self.world.open["probe"]
                self.refused(function, arguments, f"bodies.{side}.probe", (8,), "no triangles")
        faces = self.world.faces.astype(np.int64)
        for wrong, element in ((faces[1:], "mesh.triangles["), (faces[:, ::-1], "mesh.triangles"),
                               (np.vstack([faces[:1, ::-1], faces[1:]]), "mesh.triangles[")):
            arguments = self.good("sqmap_make_solid_probe")
            kept = self.world.array(wrong)
            arguments["mesh"].triangles, arguments["mesh"].triangle_count = kept.ctypes.data, len(kept)
            self.refused("sqmap_make_solid_probe", arguments, element, (6,))
        for member in ("vertex_count", "triangle_count"):
            arguments = self.good("sqmap_make_solid_probe")
            setattr(arguments["mesh"], member, 0)
            self.refused("sqmap_make_solid_probe", arguments, f"mesh.{member}", (1,))

    def test_bodies_of_a_pile(self):
        for member in ("model", "probe"):
            for handle in self.wrong_handles(member)[member == "model":]:
                arguments = self.good("sqmap_add_body")
                setattr(arguments["body"], member, handle)
                self.refused("sqmap_add_body", arguments, f"body.{member}", (2,), handle.id)
        arguments = self.good("sqmap_add_body")
        arguments["body"].probe = self.world.open["probe"]
        self.refused("sqmap_add_body", arguments, "body.probe", (8,), "no triangles")
        for at, pose in self.wrong_poses():
            arguments = self.good("sqmap_add_body")
            arguments["body"].pose = ctypes.pointer(pose)
            self.refused("sqmap_add_body", arguments, f"body.pose.{at}", (1,))

    def wrong_poses(self):
        for k in range(12):
            for bad in (NAN, INF, -INF):
                yield f"rotation[{k}]" if k < 9 else f"translation[{k - 9}]", pose_with(k, bad)
        for k, bad in ((0, 2.0), (0, -1.0), (4, 1 + 1e-4), (1, 1e-3), (8, 0.0)):
            yield "rotation", pose_with(k, bad)

    def test_structs(self):
        for function, (parameters, _) in FUNCTIONS.items():
            for kind, name in parameters:
                struct = kind.removeprefix("const ").removesuffix("*")
                if not kind.endswith("*") or "size" not in STRUCTS.get(struct, ({},))[0]:
                    continue
                for size in (0, 3, 12, 5000, 2**63):
                    arguments = self.good(function)
                    arguments[name].size = size
                    self.refused(function, arguments, f"{name}.size", (1,), size)
                members, comment = STRUCTS[struct]
                for member, (inner, said) in members.items():
                    for where, value in self.wrong_members(inner, member, said, kind.startswith("const "), "null" in comment):
                        arguments = self.good(function)
                        if struct == "sqmap_points" and member == "pose" and function in ("sqmap_make_probe", "sqmap_make_pad"):
                            continue  # documented as not read
                        if struct == "sqmap_query_options" and member in self.not_read(function):
                            continue
                        if struct in ("sqmap_poses", "sqmap_pile_step") and member == "pose" and value:
                            value, where = self.world.poses(value.contents), f"[1]{where}"
                        setattr(arguments[name], member, value)
                        self.refused(function, arguments, f"{name}.{member}{where}", (1, 6), value)

    def not_read(self, function):
        """Members of options that the comment of a function says are not read."""
        comment = FUNCTIONS[function][1].replace("\n/// ", " ")
        if "only threads is read" in comment:
            return {"layer", "tolerance", "margin", "band", "projector", "nearest_steps"}
        if "are not read" in comment:
            return {"layer", "tolerance", "margin", "projector", "nearest_steps"}
        return {"band", "threads"} if function in ("sqmap_query_probe", "sqmap_query_pair") else \
            {"band"} if function == "sqmap_query_points" else set()

    def wrong_members(self, kind, name, said, is_input, may_be_null):
        """(suffix of the element, value)."""
        if kind.endswith("*") and not said.startswith("written") and "null" not in said and not may_be_null:
            yield "", None
        if kind == "sqmap_text":
            return
        if not is_input:
            return
        if kind == "double":
            yield from (("", NAN), ("", -INF))
        if kind == "const sqmap_pose*":
            yield from ((f".{at}", ctypes.pointer(pose)) for at, pose in self.wrong_poses())
        if kind == "sqmap_pose":
            yield from (("", pose) for _, pose in self.wrong_poses())
        if kind == "int32_t" and (said.split(" ")[0].rstrip(",:") in ENUMS or name == "projection"):
            yield from (("", 99), ("", -1))
        if kind == "uint32_t" and name in ("threads", "max_parts"):
            yield "", 2**32 - 1
        if kind == "const double*":
            for bad in (NAN, INF):
                rows = np.array(self.world.points if name != "vertices" else self.world.vertices, float)
                rows[1, 2] = bad
                yield "[1]", self.world.array(rows).ctypes.data
        if kind == "const int64_t*":
            for bad in (-1, 10**12):
                rows = self.world.faces.copy()
                rows[1, 2] = bad
                yield "[1]", self.world.array(rows).ctypes.data

    def test_arrays_and_numbers(self):
        bad = self.world.array([[0, 0, 1.0], [0, NAN, 1], [0, 0, 1], [0, 0, 1]]).ctypes.data
        self.refused("sqmap_make_pad", self.good("sqmap_make_pad") | {"normals": bad}, "normals[1]", (1,))
        self.refused("sqmap_option_range", self.good("sqmap_option_range") | {"name": b"smell"}, "name", (1,))
        for part in (1, 2**32 - 1):
            self.refused("sqmap_implicit", self.good("sqmap_implicit") | {"part": part}, "part", (1,), part)
        for words in (-1, 3):
            arguments = self.good("sqmap_notes")
            arguments["lines"].words = words
            self.refused("sqmap_notes", arguments, "lines.words", (1,), words)
        for count in (0, 2**63):
            self.refused("sqmap_make_workspace", self.good("sqmap_make_workspace") | {"contacts": count}, "contacts", (1,))
        for count in (0, 2**63):
            self.refused("sqmap_make_pile", self.good("sqmap_make_pile") | {"contacts": count}, "contacts", (1,))
        self.refused("sqmap_remove_body", self.good("sqmap_remove_body") | {"number": 2**32 - 1}, "number", (1,))
        for function in ("sqmap_make_probe", "sqmap_make_pad"):
            arguments = self.good(function)
            arguments["points"].count = 0
            self.refused(function, arguments, "points.count", (1,))
        arguments = self.good("sqmap_tick_pad")
        arguments["taxels"].count = 3
        self.refused("sqmap_tick_pad", arguments, "taxels.count", (1,))
        for size in (0, 10):
            self.refused("sqmap_open_bytes", self.good("sqmap_open_bytes") | {"size": size}, "bytes", (4,))


if __name__ == "__main__":
    unittest.main()
