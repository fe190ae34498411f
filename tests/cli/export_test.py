#!/usr/bin/env python3
"""sqmap export: every shape, as a reader finds it in the file, holds its part; an oracle of 50 decimal digits decides.

usage: export_test.py PROGRAM
"""
import decimal
import itertools
import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import coarse

PROGRAM = os.path.abspath(sys.argv.pop(1))
decimal.getcontext().prec = 50
D = decimal.Decimal
UNIT = 2**200  # doubles of the files as integers: whole()
PRIMITIVES = ("box", "sphere", "ellipsoid", "capsule", "cylinder")
SHAPES = (*PRIMITIVES, "hull", "superquadric")


def run(*arguments, code=0):
    result = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=300)
    assert result.returncode == code, (arguments, result.stdout, result.stderr)
    return result


def sine(x):
    """Taylor's series to the last digit of the context, for |x| up to some turns."""
    term = total = x
    n = 1
    while abs(term) > D(10) ** -48:
        term *= -x * x / ((n + 1) * (n + 2))
        n += 2
        total += term
    return total


PI = D("3.14159265358979323846264338327950288419716939937510582097494459")


def cosine(x):
    return sine(PI / 2 - x)


def lines(path):
    return pathlib.Path(path).read_text().splitlines()


def exact(word):
    """The double that a reader makes of a word, exactly."""
    return D(float(word))


def numbers(text):
    return [exact(word) for word in text.split()]


def rotation_of_rpy(rpy):
    (cr, sr), (cp, sp), (cy, sy) = ((cosine(a), sine(a)) for a in rpy)
    return [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr], [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr]]


def rotation_of_quaternion(q):
    n = sum(v * v for v in q).sqrt()
    w, x, y, z = (v / n for v in q)
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


class Primitive:
    """A shape as its file has it; half lengths, or radius and half length."""

    def __init__(self, kind, at, rotation, size):
        self.kind, self.at, self.rotation, self.size = kind, at, rotation, size

    def holds(self, p):
        d = [a - b for a, b in zip(p, self.at)]
        x, y, z = (sum(self.rotation[i][k] * d[i] for i in range(3)) for k in range(3))
        s = self.size
        if self.kind == "box":
            return abs(x) <= s[0] and abs(y) <= s[1] and abs(z) <= s[2]
        if self.kind == "sphere":
            return x * x + y * y + z * z <= s[0] ** 2
        if self.kind == "ellipsoid":
            return (x / s[0]) ** 2 + (y / s[1]) ** 2 + (z / s[2]) ** 2 <= 1
        if self.kind == "capsule":
            return x * x + y * y + max(abs(z) - s[1], 0) ** 2 <= s[0] ** 2
        return x * x + y * y <= s[0] ** 2 and abs(z) <= s[1]


def whole(v):
    """A double as an integer number of UNITs: exact, and far quicker than a fraction."""
    over, under = float(v).as_integer_ratio()
    assert UNIT % under == 0, v
    return over * (UNIT // under)


class Hull:
    """Planes of a convex mesh as its file has it; exact arithmetic of integers."""

    def __init__(self, vertices, triangles):
        self.mesh = (tuple(map(tuple, vertices)), tuple(map(tuple, triangles)))
        corners = [[whole(c) for c in v] for v in vertices]
        self.planes = []
        for t in triangles:
            a, b, c = (corners[i] for i in t)
            u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
            n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            self.planes.append((n, sum(p * q for p, q in zip(n, a))))
        # Ten roundings, each of at most half a unit of the last place of what is summed, decide most points in floats.
        self.reach = 2 * max(abs(float(c)) for v in vertices for c in v)
        self.rounded = []
        for i, (n, offset) in enumerate(self.planes):
            a, b, c, d = (*(v / UNIT**2 for v in n), offset / UNIT**3)
            self.rounded.append((i, a, b, c, d - 2e-15 * (self.reach * (abs(a) + abs(b) + abs(c)) + abs(d))))
        # A closed surface that bends outwards at each edge is convex (van Heijenoort 1952).
        across = {(t[i], t[(i + 1) % 3]): t[(i + 2) % 3] for t in triangles for i in range(3)}
        self.is_convex = all((j, i) in across and self.below(k // 3, corners[across[j, i]]) for k, (i, j) in enumerate(
            (t[i], t[(i + 1) % 3]) for t in triangles for i in range(3)))

    def below(self, plane, p):
        n, offset = self.planes[plane]
        return n[0] * p[0] + n[1] * p[1] + n[2] * p[2] <= offset

    def holds(self, p):
        x, y, z = map(float, p)
        if max(abs(x), abs(y), abs(z)) > self.reach:
            doubtful = range(len(self.planes))
        else:
            doubtful = [i for i, a, b, c, d in self.rounded if a * x + b * y + c * z > d]
        exactly = [whole(v) for v in p] if doubtful else None
        return all(self.below(i, exactly) for i in doubtful)


def read_obj(path):
    """{name of an object: Hull}"""
    vertices, faces, name = [], {}, None
    for line in pathlib.Path(path).read_text().splitlines():
        words = line.split()
        if words[:1] == ["o"]:
            name = words[1]
            faces[name] = []
        elif words[:1] == ["v"]:
            vertices.append([float(w) for w in words[1:]])
        elif words[:1] == ["f"]:
            faces[name].append([int(w) - 1 for w in words[1:]])
    out = {}
    for name, triangles in faces.items():
        used = sorted({v for t in triangles for v in t})
        index = {v: i for i, v in enumerate(used)}
        out[name] = Hull([vertices[v] for v in used], [[index[v] for v in t] for t in triangles])
    return out


def halves(text):
    return [v / 2 for v in numbers(text)]


def read_urdf(path):
    out = {}
    for collision in ElementTree.parse(path).getroot().iter("collision"):
        shape = collision.find("geometry")[0]
        if shape.tag == "mesh":
            out.update(read_obj(pathlib.Path(path).parent / shape.get("filename")))
            continue
        origin = collision.find("origin")
        size = {"box": lambda: halves(shape.get("size")),
                "sphere": lambda: numbers(shape.get("radius")),
                "cylinder": lambda: [exact(shape.get("radius")), exact(shape.get("length")) / 2]}[shape.tag]()
        out[collision.get("name")] = Primitive(shape.tag, numbers(origin.get("xyz")),
                                               rotation_of_rpy(numbers(origin.get("rpy"))), size)
    return out


def read_sdf(path):
    out = {}
    for collision in ElementTree.parse(path).getroot().iter("collision"):
        shape = collision.find("geometry")[0]
        if shape.tag == "mesh":
            out.update(read_obj(pathlib.Path(path).parent / shape.find("uri").text))
            continue
        pose = numbers(collision.find("pose").text)
        find = lambda tag: numbers(shape.find(tag).text)
        size = {"box": lambda: halves(shape.find("size").text), "sphere": lambda: find("radius"),
                "ellipsoid": lambda: find("radii")}.get(shape.tag, lambda: [find("radius")[0], find("length")[0] / 2])()
        out[collision.get("name")] = Primitive(shape.tag, pose[:3], rotation_of_rpy(pose[3:]), size)
    return out


def read_mjcf(path):
    root = ElementTree.parse(path).getroot()
    meshes = {m.get("name"): [[float(w) for w in m.get("vertex").split()][i:i + 3] for i in range(0, len(m.get("vertex").split()), 3)]
              for m in root.iter("mesh")}
    out = {}
    for geom in root.iter("geom"):
        if geom.get("type") != "mesh":
            out[geom.get("name")] = Primitive(geom.get("type"), numbers(geom.get("pos")),
                                              rotation_of_quaternion(numbers(geom.get("quat"))), numbers(geom.get("size")))
    return out, meshes


def read_json(path):
    out = {}
    for part in json.loads(pathlib.Path(path).read_text(), parse_float=exact, parse_int=D)["parts"]:
        kind = part["shape"]
        if kind == "hull":
            out[part["name"]] = Hull(part["vertices"], [[int(i) for i in t] for t in part["triangles"]])
        elif kind == "superquadric":
            out[part["name"]] = part
        elif kind == "sphere":
            out[part["name"]] = Primitive(kind, part["xyz"], rotation_of_rpy([D(0)] * 3), [part["radius"]])
        else:
            size = part["half_lengths"] if "half_lengths" in part else [part["radius"], part["half_length"]]
            out[part["name"]] = Primitive(kind, part["xyz"], rotation_of_rpy(part["rpy"]), size)
    return out


def read_glb(path):
    data = pathlib.Path(path).read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    gltf, binary = json.loads(data[20:20 + length]), data[28 + length:]

    def accessor(i):
        a = gltf["accessors"][i]
        view = gltf["bufferViews"][a["bufferView"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        size = {"SCALAR": 1, "VEC3": 3}[a["type"]]
        code = {5126: "f", 5125: "I", 5123: "H"}[a["componentType"]]
        return struct.unpack_from(f"<{size * a['count']}{code}", binary, start)

    out = {}
    for node in gltf["nodes"]:
        if "mesh" not in node:
            continue
        primitive = gltf["meshes"][node["mesh"]]["primitives"][0]
        flat, indices = accessor(primitive["attributes"]["POSITION"]), accessor(primitive["indices"])
        out[node["name"]] = Hull([flat[i:i + 3] for i in range(0, len(flat), 3)],
                                 [indices[i:i + 3] for i in range(0, len(indices), 3)])
    return out


class Balls:
    """Balls as their file has them. The power of a point, the least of |p - c|^2 - r^2, is convex in the cell of each ball (Aurenhammer
    1987). So a union of balls holds a solid if and only if the power is not positive at the corners of the cells' pieces of it."""

    def __init__(self, balls):
        self.balls = balls
        self.near = [([float(v) for v in c], float(r)) for c, r in balls]
        # |p - c|^2 - r^2 less |p|^2, which is linear in p.
        self.linear = [([-2 * v for v in c], sum(v * v for v in c) - r * r) for c, r in balls]

    def power(self, i, p):
        """The power of p for one ball, less |p|^2."""
        n, d = self.linear[i]
        return n[0] * p[0] + n[1] * p[1] + n[2] * p[2] + d

    def is_held(self, i, p):
        # Corners of pieces are rounded to 50 digits; balls leave far more room.
        return sum(v * v for v in p) + self.power(i, p) <= D(10) ** -40

    def piece(self, triangle, i):
        """The part of a triangle in the cell of ball i, as a polygon."""
        polygon = triangle
        for j in range(len(self.balls)):
            if j == i or not polygon:
                continue
            over = [self.power(i, p) - self.power(j, p) for p in polygon]
            clipped = []
            for (p, a), (q, b) in zip(zip(polygon, over), zip(polygon[1:] + polygon[:1], over[1:] + over[:1])):
                if a <= 0:
                    clipped.append(p)
                if (a < 0 < b) or (b < 0 < a):
                    t = a / (a - b)
                    clipped.append([u + t * (v - u) for u, v in zip(p, q)])
            polygon = clipped
        return polygon

    def owners(self, triangle):
        """The balls whose cells may meet a triangle: the others have more power than one of them at all its corners."""
        rough = [[sum((u - v) ** 2 for u, v in zip(p, c)) - r * r for p in triangle] for c, r in self.near]
        return [i for i, mine in enumerate(rough) if not any(all(a > b + 1e-9 for a, b in zip(mine, other)) for other in rough)]

    def corners(self):
        """Corners of cells that are in no ball."""
        for four in itertools.combinations(range(len(self.balls)), 4):
            (first, d), *others = (self.linear[i] for i in four)
            rows = [[a - b for a, b in zip(n, first)] for n, _ in others]
            right = [d - e for _, e in others]
            cross = lambda u, v: [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            across = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])]
            volume = sum(a * b for a, b in zip(rows[0], across[0]))
            if volume == 0:  # their cells have no corner, or a whole line of them, which others end
                continue
            p = [sum(right[k] * across[k][axis] for k in range(3)) / volume for axis in range(3)]
            rough = [sum((float(u) - v) ** 2 for u, v in zip(p, c)) - r * r for c, r in self.near]
            if rough[four[0]] <= min(rough) + 1e-9 and rough[four[0]] > -1e-12:
                yield p


def turns_about(p, vertices, triangles):
    """How often a closed mesh winds about a point: the solid angles of its triangles (van Oosterom, Strackee 1983)."""
    total = 0
    for t in triangles:
        a, b, c = ([u - float(v) for u, v in zip(vertices[i], p)] for i in t)
        la, lb, lc = (math.hypot(*v) for v in (a, b, c))
        dot = lambda u, v: sum(x * y for x, y in zip(u, v))
        volume = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        total += math.atan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    return total / (2 * math.pi)


def write_in_float(path):
    """Rounds the coordinates of an OBJ to float, as models keep them. Its vertices and triangles."""
    vertices, triangles, out = [], [], []
    for line in lines(path):
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([struct.unpack("f", struct.pack("f", float(w)))[0] for w in words[1:]])
            line = "v " + " ".join(map(repr, vertices[-1]))
        elif words[:1] == ["f"]:
            triangles.append([int(w.split("/")[0]) - 1 for w in words[1:]])
        out.append(line + "\n")
    pathlib.Path(path).write_text("".join(out))
    return vertices, triangles


class Export(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        coarse.write_dumbbell("dumbbell.obj")
        run("bake", "dumbbell.obj", "-o", "dumbbell.sqmap", "--max-parts", "4", "--target-error", "5")
        # The model's triangles by part: from a hull of each, whose corners are those of the part and of what closes it.
        run("export", "dumbbell.sqmap", "--as", "json", "--shape", "hull", "-o", "hulls.json")
        parts = json.loads(pathlib.Path("hulls.json").read_text(), parse_float=exact, parse_int=D)["parts"]
        cls.held = set()  # (part, mesh of a hull) that were judged
        cls.points = {p["name"]: p["vertices"] for p in parts}

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    def check(self, shapes, context):
        self.assertEqual(set(shapes), set(self.points), context)
        for name, shape in shapes.items():
            if isinstance(shape, Hull):
                if (name, shape.mesh) in self.held:  # several formats name the same OBJ
                    continue
                self.held.add((name, shape.mesh))
                self.assertTrue(shape.is_convex, (context, name))
            for p in self.points[name]:
                self.assertTrue(shape.holds(p), (context, name, p))

    def test_every_vertex_of_the_mesh_is_in_the_hull_of_some_part(self):
        hulls = read_json("hulls.json")
        self.check(hulls, "hulls")
        mesh = [[float(w) for w in line.split()[1:]] for line in lines("dumbbell.obj") if line.startswith("v ")]
        # The model keeps vertices in float: half a unit of their last place off.
        planes = {name: [([v / UNIT**2 for v in n], o / UNIT**3) for n, o in h.planes] for name, h in hulls.items()}
        for p in mesh[::7]:
            q = [float(v) for v in p]
            def outside(sides):
                return max((sum(a * b for a, b in zip(n, q)) - o) / math.hypot(*n) for n, o in sides)
            self.assertLess(min(outside(sides) for sides in planes.values()), 1e-6)

    def test_every_shape_of_every_format_holds_its_part(self):
        for shape in SHAPES:
            for format, read in (("urdf", read_urdf), ("sdf", read_sdf), ("obj", read_obj), ("glb", read_glb)):
                path = f"{shape}.{format}"
                run("export", "dumbbell.sqmap", "--as", format, "--shape", shape, "-o", path)
                self.check(read(path), (shape, format))
        for shape in (*PRIMITIVES, "hull"):
            run("export", "dumbbell.sqmap", "--shape", shape, "-o", f"{shape}.json")
            self.check(read_json(f"{shape}.json"), (shape, "json"))

    def test_mjcf_holds_the_parts_or_lists_the_vertices_of_the_obj(self):
        for shape in SHAPES:
            run("export", "dumbbell.sqmap", "--as", "mjcf", "--shape", shape, "-o", f"{shape}.xml")
            primitives, meshes = read_mjcf(f"{shape}.xml")
            if shape in PRIMITIVES:
                self.check(primitives, shape)
                continue
            run("export", "dumbbell.sqmap", "--as", "obj", "--shape", shape, "-o", "same.obj")
            written = [[float(w) for w in line.split()[1:]] for line in lines("same.obj") if line.startswith("v ")]
            self.assertEqual([v for m in meshes.values() for v in m], written)

    def test_superquadrics_hold_their_parts_by_their_equation(self):
        run("export", "dumbbell.sqmap", "--shape", "superquadric", "-o", "superquadrics.json")
        parts = {p["name"]: p for p in json.loads(pathlib.Path("superquadrics.json").read_text())["parts"]}
        for name, s in parts.items():
            self.assertTrue(s["certified"])
            for point in self.points[name]:
                p = [float(v) - t for v, t in zip(point, s["translation"])]
                x, y, z = (sum(a * b for a, b in zip(row, p)) for row in s["rotation"])
                if s["bend"] > 0:
                    k, ca, sa = s["bend"], math.cos(s["bend_angle"]), math.sin(s["bend_angle"])
                    along = ca * x + sa * y
                    shift = along - (1 / k - math.hypot(z, 1 / k - along))
                    x, y, z = x - ca * shift, y - sa * shift, math.atan2(z, 1 / k - along) / k
                a1, a2, a3 = s["a"]
                x, y = x / (1 + s["taper"][0] * z / a3), y / (1 + s["taper"][1] * z / a3)
                e1, e2 = s["eps1"], s["eps2"]
                f = ((abs(x / a1) ** (2 / e2) + abs(y / a2) ** (2 / e2)) ** (e2 / e1) + abs(z / a3) ** (2 / e1)) ** e1
                # The room that is left for floats decides in spite of rounding, which is some 1e-14 here.
                self.assertLess(f, 1 - 1e-12, name)

    def test_spheres_hold_the_whole_solid(self):
        run("export", "dumbbell.sqmap", "--as", "spheres", "--shape", "spheres:24", "-o", "ball.yaml", "--report", "report.json")
        text = pathlib.Path("ball.yaml").read_text()
        balls = [([exact(v) for v in c.split(",")], exact(r))
                 for c, r in re.findall(r'- "center": \[([^\]]*)\]\n      "radius": (\S+)', text)]
        self.assertTrue(8 <= len(balls) <= 24)
        run("export", "dumbbell.sqmap", "--as", "srdf", "--shape", "spheres:24", "-o", "dumbbell.srdf")
        approximation = ElementTree.parse("dumbbell.srdf").getroot().find("link_sphere_approximation")
        self.assertEqual(approximation.get("link"), "dumbbell")
        self.assertEqual([(numbers(s.get("center")), exact(s.get("radius"))) for s in approximation], balls)
        report = json.loads(pathlib.Path("report.json").read_text())
        self.assertEqual(report["whole"]["coverage"], 1)
        self.assertGreater(report["whole"]["protrusion"], 0)
        # A ball holds no part by itself: it has no figures but its volume.
        self.assertEqual({(s["support_excess"], s["coverage"]) for s in report["shapes"]}, {(None, None)})
        self.assertLess(report["whole"]["protrusion"], 0.03)
        self.assertIn(f"{len(balls)} balls, together certified to hold the solid", pathlib.Path("ball.yaml").read_text())

    def test_balls_as_written_are_proven_to_hold_the_solid(self):
        coarse.write_dumbbell("bell.obj", sides=8, rings=14)
        coarse.write_torus("ring.obj", around=16, across=8)
        for name, count in (("bell", 24), ("bell", 5), ("ring", 16)):
            vertices, triangles = write_in_float(f"{name}.obj")
            run("bake", f"{name}.obj", "-o", f"{name}.sqmap", "--max-parts", "4", "--target-error", "5")
            run("export", f"{name}.sqmap", "--as", "json", "--shape", f"spheres:{count}", "-o", "balls.json")
            written = json.loads(pathlib.Path("balls.json").read_text(), parse_float=exact, parse_int=D)["parts"]
            balls = Balls([(b["xyz"], b["radius"]) for b in written])
            self.assertTrue(1 < len(balls.balls) <= count)
            corners = [[exact(v) for v in p] for p in vertices]
            pieces = 0
            for t in triangles:
                for i in balls.owners([vertices[k] for k in t]):
                    piece = balls.piece([corners[k] for k in t], i)
                    pieces += len(piece) > 0
                    for p in piece:
                        self.assertTrue(balls.is_held(i, p), (name, count, i, p))
            self.assertGreaterEqual(pieces, len(triangles))
            for p in balls.corners():
                self.assertLess(turns_about(p, vertices, triangles), 0.5, (name, count, p))
            # The proof fails where the balls lack a thirtieth of their radii.
            shrunk = Balls([(c, r * 29 / 30) for c, r in balls.balls])
            self.assertFalse(all(shrunk.is_held(i, p) for t in triangles for i in shrunk.owners([vertices[k] for k in t])
                                 for p in shrunk.piece([corners[k] for k in t], i)))

    def test_figures_are_those_of_the_shapes(self):
        figures = {}
        for shape in SHAPES:
            out = run("export", "dumbbell.sqmap", "--shape", shape, "-o", "f.json", "--report", "r.json").stdout
            self.assertIn("support excess", out)
            figures[shape] = json.loads(pathlib.Path("r.json").read_text())["whole"]
        self.assertLess(figures["hull"]["support_excess"], 1e-9)
        for shape in SHAPES:
            self.assertGreaterEqual(figures[shape]["volume_ratio"], 0.999 * figures["hull"]["volume_ratio"], shape)
            self.assertGreaterEqual(figures[shape]["support_excess"], figures["hull"]["support_excess"], shape)
        self.assertGreater(figures["sphere"]["volume_ratio"], figures["ellipsoid"]["volume_ratio"])

    def test_check_says_what_a_collider_would_lose(self):
        run("shapes", "torus", "-o", "torus.obj")
        colliders = json.loads(run("check", "torus.obj", "--collider", "--json").stdout)["colliders"]
        # A torus of radii 1 and 1/4: its hull is a disc of volume 4.1 with rounded rims, and fills the one handle.
        solid = 2 * math.pi ** 2 / 16
        hull = math.pi * 0.5 + math.pi ** 2 / 16 + 4 * math.pi / 3 / 64
        self.assertAlmostEqual(colliders["hull"]["volume_ratio"], hull / solid, delta=0.05)
        # The mesh's own box along the axes has a volume of 3.125; the least box is not larger.
        self.assertLessEqual(colliders["box"]["volume"], 1.02 * 2.5 * 2.5 * 0.5)
        self.assertEqual(colliders["hull"]["handles_filled"], 1)
        self.assertLess(colliders["hull"]["support_excess"], 1e-9)
        self.assertAlmostEqual(colliders["hull"]["protrusion"], math.hypot(1, 0.25) - 0.25, delta=0.03)
        self.assertIn("as a collider", run("check", "torus.obj", "--collider").stdout)
        self.assertIn("--collider: is of one mesh", run("check", ".", "--collider", code=64).stderr)

    def test_the_same_model_gives_the_same_bytes_on_any_number_of_threads(self):
        for threads in ("1", "3"):
            run("export", "dumbbell.sqmap", "--shape", "capsule", "-o", f"t{threads}.json", "--threads", threads)
        self.assertEqual(*(pathlib.Path(f"t{t}.json").read_text() for t in "13"))

    def test_wrong_input_is_named_and_writes_nothing(self):
        before = sorted(os.listdir("."))
        for arguments, code, words in (
                (("dumbbell.sqmap", "-o", "a.xyz"), 64, "does not say which file it is"),
                (("dumbbell.sqmap", "--as", "usd", "-o", "a"), 64, "'usd' is none of urdf|mjcf"),
                (("dumbbell.sqmap", "--shape", "cone", "-o", "a.json"), 64, "'cone' is none of superquadric|"),
                (("dumbbell.sqmap", "--shape", "spheres:0", "-o", "a.json"), 64, "N from 1 to 4096"),
                (("dumbbell.sqmap", "--as", "spheres", "--shape", "box", "-o", "a.yaml"), 2, "take --shape sphere or spheres:N"),
                (("dumbbell.sqmap", "--as", "json", "-o", "dumbbell.sqmap"), 2, "dumbbell.sqmap"),
                (("dumbbell.sqmap", "-o", "a.json", "--report", "./a.json"), 2, "choose another name"),
                (("dumbbell.sqmap", "-o", "a.csv", "--labels", "--mesh", "dumbbell.obj", "--shape", "box"), 64, "--shape: --labels"),
                (("dumbbell.sqmap", "-o", "a.json", "--mesh", "dumbbell.obj"), 64, "--mesh: give --labels too"),
                (("dumbbell.sqmap", "-o", "a.json", "--surface"), 64, "--surface: give --labels too"),
                (("dumbbell.obj", "-o", "a.json"), 2, "dumbbell.obj")):
            result = run("export", *arguments, code=code)
            self.assertIn(words, result.stderr)
        run("bake", "dumbbell.obj", "-o", "small.sqmap", "--max-parts", "2", "--target-error", "5", "--no-exact")
        self.assertIn("bake it with --exact", run("export", "small.sqmap", "-o", "a.json", code=2).stderr)
        os.remove("small.sqmap")
        self.assertEqual(sorted(os.listdir(".")), before)

    @unittest.skipUnless(shutil.which("check_urdf"), "check_urdf is missing: apt-get install liburdfdom-tools")
    def test_check_urdf_takes_the_file(self):
        for shape in SHAPES:
            run("export", "dumbbell.sqmap", "--as", "urdf", "--shape", shape, "-o", "check.urdf")
            result = subprocess.run(["check_urdf", "check.urdf"], capture_output=True, text=True, timeout=60)
            self.assertEqual(result.returncode, 0, result.stderr + result.stdout)
            self.assertIn("Successfully Parsed XML", result.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
