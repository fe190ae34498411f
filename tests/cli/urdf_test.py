#!/usr/bin/env python3
"""sqmap urdf: a robot of twenty links that this test makes gets shapes that hold its meshes, and nothing else of its file changes.

usage: urdf_test.py PROGRAM
"""
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import coarse

PROGRAM = os.path.abspath(sys.argv.pop(1))
LINKS = 20


def run(*arguments, code=0):
    result = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=600)
    assert result.returncode == code, (arguments, result.returncode, result.stdout, result.stderr)
    return result


def rotation(rpy):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in rpy)
    return [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr], [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr]]


def times(m, p):
    return [sum(a * b for a, b in zip(row, p)) for row in m]


def numbers(text):
    return [float(w) for w in text.split()]


def link_text(i):
    """Each link has another mesh, attitude and scale; every fourth a box beside it, every fifth a scale that mirrors."""
    mesh = ("dumbbell", "torus", "sphere")[i % 3]
    scale = f"{0.1 + 0.01 * i} 0.12 {-0.1 if i % 5 == 4 else 0.1}"
    extra = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>' if i % 4 == 0 else ""
    return f'''  <!-- link {i} &amp; its friends -->
  <link name="link{i}">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision name="shell{i}">
      <!-- as the maker drew it -->
      <origin xyz="0.0{i % 7} -0.02 0.3" rpy="{0.1 * i} 0.2 -0.{i % 9}"/>
      <geometry>
        <mesh filename="package://twenty/meshes/{mesh}.obj" scale="{scale}"/>
      </geometry>
      <verbose value="kept"/>
    </collision>
    {extra}
  </link>
'''


def joint_text(i, kind="revolute"):
    return f'''  <joint name="joint{i}" type="{kind}">
    <parent link="link{i - 1}"/><child link="link{i}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
'''


def robot_text(links=LINKS, extra=""):
    return ('<?xml version="1.0"?>\n<robot name="twenty" xmlns:xacro="http://ros.org/wiki/xacro">\n  <unknown a="1"/>\n' +
            "".join(link_text(i) for i in range(links)) + "".join(joint_text(i) for i in range(1, links)) + extra + "</robot>\n")


class Urdf(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        os.makedirs("twenty/meshes")
        run("shapes", "torus", "-o", "twenty/meshes/torus.obj")
        coarse.write_dumbbell("twenty/meshes/dumbbell.obj")
        coarse.write_sphere("twenty/meshes/sphere.obj")
        cls.vertices = {name: [numbers(line[2:]) for line in pathlib.Path(f"twenty/meshes/{name}.obj").read_text().splitlines()
                               if line.startswith("v ")] for name in ("dumbbell", "torus", "sphere")}
        pathlib.Path("twenty/robot.urdf").write_text(robot_text())

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    def points(self, i):
        """The vertices of a link's mesh in its frame."""
        collision = ElementTree.fromstring(link_text(i)).find("collision")
        mesh, origin = collision.find("geometry/mesh"), collision.find("origin")
        scale, xyz, m = numbers(mesh.get("scale")), numbers(origin.get("xyz")), rotation(numbers(origin.get("rpy")))
        name = pathlib.PurePath(mesh.get("filename")).stem
        return [[a + b for a, b in zip(times(m, [s * v for s, v in zip(scale, p)]), xyz)] for p in self.vertices[name]]

    def test_shapes_hold_every_vertex_and_the_rest_of_the_file_stays(self):
        for shape in ("box", "cylinder", "sphere"):
            out = run("urdf", "twenty/robot.urdf", "-o", f"twenty/{shape}.urdf", "--shape", shape, "--report", "report.json").stdout
            self.assertIn("20 of 20 collision meshes replaced", out)
            root = ElementTree.parse(f"twenty/{shape}.urdf").getroot()
            for i, link in enumerate(root.iter("link")):
                collision = link.find("collision")
                self.assertEqual(collision.get("name"), f"shell{i}")
                self.assertEqual(collision.find("verbose").get("value"), "kept")
                found, origin = collision.find("geometry")[0], collision.find("origin")
                m, t = rotation(numbers(origin.get("rpy"))), numbers(origin.get("xyz"))
                for p in self.points(i):
                    x, y, z = times(zip(*m), [a - b for a, b in zip(p, t)])
                    if shape == "box":
                        held = max(2 * abs(v) / s for v, s in zip((x, y, z), numbers(found.get("size"))))
                    elif shape == "sphere":
                        held = math.hypot(x, y, z) / float(found.get("radius"))
                    else:
                        held = max(math.hypot(x, y) / float(found.get("radius")), 2 * abs(z) / float(found.get("length")))
                    self.assertLessEqual(held, 1, (shape, i))
            # Without collisions both files say the same, comments and unknown elements too.
            text = pathlib.Path(f"twenty/{shape}.urdf").read_text()
            for kept in ("<!-- link 3 &amp; its friends -->", "<!-- as the maker drew it -->", '<unknown a="1"', "xmlns:xacro",
                         '<box size="0.1 0.1 0.1"'):
                self.assertEqual(text.count(kept), robot_text().count(kept), kept)
            before, after = ElementTree.fromstring(robot_text()), root
            for r in (before, after):
                for link in r.iter("link"):
                    for collision in link.findall("collision"):
                        link.remove(collision)
            self.assertEqual([(e.tag, e.attrib) for e in before.iter()], [(e.tag, e.attrib) for e in after.iter()])
        rows = json.loads(pathlib.Path("report.json").read_text())
        self.assertEqual(len(rows), LINKS)
        self.assertTrue(all(r["problem"] is None and r["support_excess"] > 0 and r["verdict"] == "ACCEPT" for r in rows))

    def test_hulls_are_files_that_the_robot_names_and_parts_get_a_shape_each(self):
        pathlib.Path("twenty/one.urdf").write_text(robot_text(1))
        run("urdf", "twenty/one.urdf", "-o", "twenty/hulls.urdf", "--package", "twenty=twenty", "--max-parts", "4")
        collisions = ElementTree.parse("twenty/hulls.urdf").getroot().find("link").findall("collision")
        meshes = [c.find("geometry/mesh").get("filename") for c in collisions if c.find("geometry/mesh") is not None]
        self.assertGreaterEqual(len(meshes), 2)
        self.assertEqual(len(set(c.get("name") for c in collisions)), len(collisions))
        for name in meshes:
            self.assertTrue(name.startswith("package://twenty/"), name)
            self.assertTrue(os.path.isfile(name[len("package://"):]), name)

    def test_faults_are_named_with_their_line_and_write_nothing(self):
        two = robot_text(2)
        line = lambda text, part: 1 + text[:text.index(part)].count("\n")
        faults = (
            (two.replace("</robot>", ""), "this is no XML", None),
            (two.replace('scale="0.1 0.12 0.1"', 'scale="0.1 0 0.1"'), "a scale of zero", 'scale="0.1 0 0.1"'),
            (two.replace('<child link="link1"/>', '<child link="link7"/>'), "there is no link 'link7'", '<parent link="link0"/>'),
            (two.replace("</robot>", joint_text(1).replace("joint1", "back").replace('"link0"', '"x"').replace('"link1"', '"link0"')
                         .replace('"x"', '"link1"') + "</robot>"), "circle", None),
            (two.replace('<axis xyz="0 0 1"/>', '<mimic joint="joint1"/>'), "mimics itself", "<mimic"),
            (two.replace('xyz="0.00', 'xyz="wide 0.00'), "is not three numbers", 'xyz="wide'),
            (two.replace("  <unknown", "  <xacro:macro/><unknown"), "run 'xacro", "<xacro:macro"),
            (two.replace('scale="0.1 0.12 0.1"', 'scale="${s} 1 1"'), "run 'xacro", 'scale="${s}'),
            (two.replace("package://twenty/", "$(find twenty)/"), "run 'xacro", "$(find"),
            (two.replace('name="link1"', 'name="link0"'), "a second link is named 'link0'", None),
            ("<sdf/>", "not 'robot'", "<sdf"))
        for text, words, at in faults:
            pathlib.Path("twenty/bad.urdf").write_text(text)
            result = run("urdf", "twenty/bad.urdf", "-o", "twenty/never.urdf", code=2)
            self.assertIn(words, result.stderr)
            self.assertRegex(result.stderr, r"twenty/bad\.urdf:\d+: ")
            if at is not None:
                self.assertIn(f"twenty/bad.urdf:{line(text, at)}: ", result.stderr)
            self.assertFalse(os.path.exists("twenty/never.urdf"))

    def test_a_missing_mesh_is_named_and_its_link_left(self):
        pathlib.Path("twenty/gap.urdf").write_text(robot_text(2).replace("torus.obj", "gone.obj"))
        result = run("urdf", "twenty/gap.urdf", "-o", "twenty/filled.urdf", "--shape", "box", code=2)
        self.assertIn("link 'link1' keeps its collision element", result.stderr)
        self.assertIn("gone.obj", result.stderr)
        self.assertIn("no such file", result.stderr)
        self.assertIn("give its package's folder: --package NAME=DIR", result.stderr)
        self.assertIn("1 of 2 collision meshes replaced", result.stdout)
        self.assertIn("meshes/gone.obj", pathlib.Path("twenty/filled.urdf").read_text())

    def test_a_mesh_that_cannot_be_read_is_refused_as_check_refuses_it(self):
        pathlib.Path("twenty/meshes/cut.stl").write_bytes(b" " * 80 + (5).to_bytes(4, "little") + b"\0" * 60)
        pathlib.Path("twenty/cut.urdf").write_text(robot_text(1).replace("dumbbell.obj", "cut.stl"))
        said = run("urdf", "twenty/cut.urdf", "-o", "twenty/cut_out.urdf", "--shape", "box", code=2).stderr
        code, message = re.search(r"REFUSED (E_\w+).*?: (.*)\n", run("check", "twenty/meshes/cut.stl", code=2).stdout).groups()
        self.assertNotEqual(code, "E_FORMAT")
        self.assertIn(code, said)
        self.assertIn(message, said)

    def test_shapes_hold_what_a_cure_drops(self):
        coarse.write_sphere("twenty/meshes/fin.obj")
        text = pathlib.Path("twenty/meshes/fin.obj").read_text()
        points = [numbers(line[2:]) for line in text.splitlines() if line.startswith("v ")]
        a, b = text[text.index("\nf ") + 3:].split()[:2]
        tip = [1.5 * v for v in points[int(a) - 1]]
        # A third triangle at an edge: it bounds nothing, and stands out.
        faces = [line for line in text.splitlines() if line.startswith("f ")] + [f"f {a} {b} {len(points) + 1}"]
        points.append(tip)
        pathlib.Path("twenty/meshes/fin.obj").write_text(
            "".join("v {!r} {!r} {!r}\n".format(*p) for p in points) + "\n".join(faces) + "\n")
        pathlib.Path("twenty/fin.urdf").write_text(
            '<robot name="fin"><link name="l"><collision><geometry><mesh filename="meshes/fin.obj"/></geometry></collision></link></robot>')
        for shape in ("sphere", "spheres:1", "spheres:8"):
            out = run("urdf", "twenty/fin.urdf", "-o", "twenty/held.urdf", "--shape", shape).stdout
            self.assertIn("CLOSED", out)
            balls = [(numbers(c.find("origin").get("xyz")), float(c.find("geometry/sphere").get("radius")))
                     for c in ElementTree.parse("twenty/held.urdf").getroot().iter("collision")]
            self.assertTrue(1 <= len(balls) <= int(shape[8:] or 1), shape)
            for p in points:
                self.assertTrue(any(math.dist(p, c) <= r for c, r in balls), (shape, p))
        text = pathlib.Path("twenty/held.urdf").read_text()
        self.assertEqual(text.count("balls that are certified to hold the mesh together"), len(balls))
        self.assertEqual(text.count("protrusion"), 1)  # of all together

    def test_the_file_around_the_robot_stays_to_the_byte(self):
        around = ('<?xml version="1.0" ?>\n<!-- made by hand -->\n\n', "\n\n")
        pathlib.Path("twenty/around.urdf").write_text(around[0] + robot_text(1).split("\n", 1)[1].rstrip() + around[1])
        run("urdf", "twenty/around.urdf", "-o", "twenty/kept.urdf", "--shape", "box")
        text = pathlib.Path("twenty/kept.urdf").read_text()
        self.assertTrue(text.startswith(around[0] + "<robot "), text[:80])
        self.assertTrue(text.endswith("</robot>" + around[1]), text[-20:])

    def test_no_file_that_is_read_or_written_is_written_over(self):
        pathlib.Path("twenty/one.urdf").write_text(robot_text(1))
        shutil.copy("twenty/meshes/dumbbell.obj", "twenty/made_link0.obj")
        pathlib.Path("twenty/own.urdf").write_text(robot_text(1).replace("meshes/dumbbell.obj", "made_link0.obj"))
        before = pathlib.Path("twenty/made_link0.obj").read_bytes()
        for robot, output, report in (("one", "one.urdf", "r.json"), ("one", "new.urdf", "new.urdf"), ("own", "made.urdf", "r.json")):
            for sweep in ((), ("--sweep",)) if robot == "one" else ((),):
                said = run("urdf", f"twenty/{robot}.urdf", "-o", f"twenty/{output}", "--report", f"twenty/{report}", *sweep, code=2)
                self.assertIn("choose another name to write", said.stderr)
        self.assertEqual(pathlib.Path("twenty/made_link0.obj").read_bytes(), before)
        self.assertFalse(os.path.exists("twenty/new.urdf"))

    def test_an_open_mesh_is_held_without_a_solid(self):
        pathlib.Path("twenty/meshes/sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0.2\nf 1 2 3\n")
        pathlib.Path("twenty/sheet.urdf").write_text(robot_text(1).replace("dumbbell.obj", "sheet.obj"))
        out = run("urdf", "twenty/sheet.urdf", "-o", "twenty/held.urdf", "--shape", "cylinder").stdout
        self.assertIn("1 of 1 collision meshes replaced", out)

    def test_a_sweep_prints_writes_srdf_and_says_the_same_as_json(self):
        pairs = "link0:link1,link0:link2,link3:link5"
        out = run("urdf", "twenty/robot.urdf", "--sweep", "--pairs", pairs, "-o", "robot.srdf", "--report", "sweep.json").stdout
        report = json.loads(pathlib.Path("sweep.json").read_text())
        self.assertEqual(report, json.loads(run("urdf", "twenty/robot.urdf", "--sweep", "--pairs", pairs, "--json").stdout))
        self.assertEqual([l["name"] for l in report["links"]], ["link0", "link1", "link2", "link3", "link5"])
        verdicts = {(p["link1"], p["link2"]): p for p in report["pairs"]}
        self.assertEqual(verdicts["link0", "link1"]["verdict"], "adjacent")
        disabled = {(e.get("link1"), e.get("link2")): e.get("reason") for e in ElementTree.parse("robot.srdf").getroot()}
        for names, pair in verdicts.items():
            self.assertIn(pair["verdict"], out)
            self.assertEqual(disabled.get(names), {"adjacent": "Adjacent", "free": "Never"}.get(pair["verdict"]))
            if pair["verdict"] == "free":
                self.assertLess(0, pair["proven_clearance"])
                self.assertLess(pair["proven_clearance"], pair["clearance_seen"])
            if pair["verdict"] == "colliding":
                self.assertTrue(all(-1 <= v <= 1 for v in pair["pose"].values()))

    def test_a_sweep_says_what_time_and_missing_meshes_leave_open(self):
        pathlib.Path("twenty/gap.urdf").write_text(robot_text(3).replace("torus.obj", "gone.obj").replace("<box", "<capsule"))
        result = run("urdf", "twenty/gap.urdf", "--sweep", "--json", code=2)
        self.assertIn("link 'link1' is not swept whole", result.stderr)
        self.assertIn("<capsule> is no shape of URDF", result.stderr)
        pair = json.loads(result.stdout)["pairs"][1]
        self.assertEqual((pair["link1"], pair["link2"]), ("link0", "link2"))
        self.assertIn(pair["verdict"], ("open", "colliding"))
        long = robot_text(3).replace("<axis", '<origin xyz="0 0 1"/><axis')
        pathlib.Path("twenty/long.urdf").write_text(long)
        out = run("urdf", "twenty/long.urdf", "--sweep", "--pairs", "link0:link2", "--seconds", "0.000001", "-o", "none.srdf").stdout
        self.assertIn("1 open", out)
        self.assertIn("the time ended the search; open are 100 %", out)
        self.assertNotIn("disable_collisions", pathlib.Path("none.srdf").read_text())
        self.assertIn("no link 'nobody'", run("urdf", "twenty/robot.urdf", "--sweep", "--pairs", "link0:nobody", code=2).stderr)
        for wrong in (("--sweep", "--pairs", "link0"), ("--sweep", "--shape", "box"), ("--json", "-o", "x.urdf"), ()):
            run("urdf", "twenty/robot.urdf", *wrong, code=64)

    @unittest.skipUnless(shutil.which("check_urdf"), "check_urdf is missing: apt-get install liburdfdom-tools")
    def test_check_urdf_takes_what_is_written(self):
        run("urdf", "twenty/robot.urdf", "-o", "twenty/checked.urdf")
        result = subprocess.run(["check_urdf", "twenty/checked.urdf"], capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("Successfully Parsed XML", result.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
