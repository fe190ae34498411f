#!/usr/bin/env python3
"""Files of sqmap export and sqmap urdf in the readers of others: libsdformat, MuJoCo, and xmllint with a schema of SRDF.

usage: readers_test.py PROGRAM MUJOCO_PACKAGE_FOLDER [SDF_READER]
"""
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import coarse

SDF_READER = os.path.abspath(sys.argv.pop(3)) if len(sys.argv) > 3 and not sys.argv[3].startswith("-") else None
MUJOCO = os.path.abspath(sys.argv.pop(2))
PROGRAM = os.path.abspath(sys.argv.pop(1))
HERE = pathlib.Path(__file__).resolve().parent
PRIMITIVES = ("box", "sphere", "cylinder", "capsule", "ellipsoid")


def run(*arguments, program=PROGRAM):
    result = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, (arguments, result.returncode, result.stdout, result.stderr)
    return result.stdout


def lacks(words):
    """Says what a part of the test needs, for the list of skipped tests."""
    print(f"skipped in part: {words}", flush=True)


class Readers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        coarse.write_dumbbell("dumbbell.obj")
        run("bake", "dumbbell.obj", "-o", "dumbbell.sqmap", "--target-error", "5")
        cls.vertices = [[float(w) for w in line.split()[1:]] for line in pathlib.Path("dumbbell.obj").read_text().splitlines()
                        if line.startswith("v ")]

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    def export(self, form, shape):
        """The file's name, and what the same shapes are as JSON."""
        path = f"{shape}.{form}"
        run("export", "dumbbell.sqmap", "--as", form, "--shape", shape, "-o", path)
        run("export", "dumbbell.sqmap", "--as", "json", "--shape", shape, "-o", "shapes.json")
        return path, json.loads(pathlib.Path("shapes.json").read_text())

    def test_libsdformat_finds_the_shapes_that_were_exported(self):
        if SDF_READER is None:
            return lacks("no libsdformat (Debian: libsdformat-dev)")
        for shape in (*PRIMITIVES, "hull", "superquadric"):
            path, made = self.export("sdf", shape)
            found = [line.split() for line in run(path, program=SDF_READER).splitlines()]
            self.assertEqual(len(found), len(made["parts"]), shape)
            for line, part in zip(found, made["parts"]):
                self.assertEqual(line[0], part["name"])
                if shape in ("hull", "superquadric"):
                    self.assertEqual(line[7], "mesh")
                    self.assertTrue(os.path.isfile(line[8]), line[8])
                    continue
                self.assertEqual([float(w) for w in line[1:4]], part["xyz"])
                # The reader keeps a quaternion: turns are compared, not angles.
                for a, b in zip(rotation([float(w) for w in line[4:7]]), part.get("rotation", [])):
                    self.assertLess(max(abs(x - y) for x, y in zip(a, b)), 1e-7)
                self.assertEqual(line[7], shape)
                want = {"box": lambda p: [2 * h for h in p["half_lengths"]], "sphere": lambda p: [p["radius"]],
                        "ellipsoid": lambda p: p["half_lengths"]}.get(shape, lambda p: [p["radius"], 2 * p["half_length"]])
                self.assertEqual([float(w) for w in line[8:]], want(part))

    def test_mujoco_rests_what_it_loads_where_the_mesh_would(self):
        if not shutil.which("node") or not os.path.isfile(f"{MUJOCO}/mujoco.js"):
            return lacks("needs npm's packages and Chromium (./dev view, then apt-get install chromium)")
        shapes = (*PRIMITIVES, "hull")
        exports = [self.export("mjcf", shape) for shape in shapes]
        answers = json.loads(run(str(HERE / "mujoco_drop.mjs"), MUJOCO, *(path for path, _ in exports), program="node"))
        extent = max(math.dist(self.vertices[0], v) for v in self.vertices)
        for shape, (_, made), answer in zip(shapes, exports, answers):
            self.assertEqual(answer["geoms"], len(made["parts"]), shape)
            self.assertLess(answer["speed"], 1e-2, shape)
            up = z_row(answer["quaternion"])
            lowest = min(sum(a * b for a, b in zip(up, v)) for v in self.vertices) + answer["position"][2]
            # A plane touches the mesh's hull where it touches the mesh; other shapes hold the mesh above it by their excess.
            overhang = 0 if shape == "hull" else made["figures"]["support_excess"]
            self.assertGreater(lowest, -0.01 * extent, shape)
            self.assertLess(lowest, overhang + 0.01 * extent, shape)

    def test_srdf_is_valid_by_the_schema_after_moveits_documentation(self):
        if not shutil.which("xmllint"):
            return lacks("no xmllint (Debian: libxml2-utils)")
        balls, _ = self.export("srdf", "spheres:7")
        link = '<link name="{}"><collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision></link>'
        joint = ('<joint name="j{0}" type="revolute"><parent link="l{1}"/><child link="l{0}"/><origin xyz="0 0 0.4"/>'
                 '<axis xyz="1 0 0"/><limit lower="-1" upper="1"/></joint>')
        pathlib.Path("arm.urdf").write_text('<robot name="arm">' + "".join(link.format(f"l{i}") for i in range(4)) +
                                            "".join(joint.format(i, i - 1) for i in range(1, 4)) + "</robot>")
        run("urdf", "arm.urdf", "--sweep", "-o", "arm.srdf")
        self.assertIn('reason="Never"', pathlib.Path("arm.srdf").read_text())
        check = lambda path: subprocess.run(["xmllint", "--noout", "--schema", str(HERE / "srdf.xsd"), path], capture_output=True)
        for path in (balls, "arm.srdf"):
            self.assertEqual(check(path).returncode, 0, check(path).stderr)
        # The schema does refuse.
        pathlib.Path("bad.srdf").write_text(pathlib.Path("arm.srdf").read_text().replace('"Never"', '"Perhaps"'))
        self.assertNotEqual(check("bad.srdf").returncode, 0)


def rotation(rpy):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in rpy)
    return [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr], [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr]]


def z_row(quaternion):
    """The last row of the rotation of w, x, y, z: heights of the turned axes."""
    w, x, y, z = quaternion
    return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


if __name__ == "__main__":
    unittest.main()
