#!/usr/bin/env python3
"""sqmap dress end to end on a ball: the animation, the report, and what it says when a garment file is wrong.

usage: dress_test.py PROGRAM
"""
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))

import rig  # noqa: E402: beside the program's other scripts


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=120)


class Dress(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        assert run("shapes", "sphere", "-o", "ball.obj").returncode == 0
        assert run("bake", "ball.obj", "-o", "ball.sqmap").returncode == 0

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    def garment(self, **changes):
        garment = {"pattern": "blanket", "fabric": "wool", "centre": [0, 1.02, 0], "width": 2, "depth": 2, "vertices": 300}
        garment.update(changes)
        with open("garment.json", "w") as out:
            json.dump({k: v for k, v in garment.items() if v is not None}, out)
        return "garment.json"

    def dress(self, *options, **changes):
        return run("dress", "--avatar", "ball.sqmap", "--garment", self.garment(**changes), "-o", "out.glb", "--report", "report.json",
                   "--seconds", "0.5", "--fps", "10", *options)

    def test_writes_an_animation_and_a_report_that_agree(self):
        done = self.dress("--pictures", ".")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open("report.json") as file:
            garment = json.load(file)["garments"][0]
        self.assertLess(garment["penetration_at_end"]["nodes_percent_of_height"], 0.2)
        self.assertGreater(garment["most_contacts"], 10)
        self.assertEqual(len(garment["strain"]["vertices"]), garment["vertices"])
        self.assertGreater(garment["us_per_step"]["query"]["mean"], 0)
        with open("out.glb", "rb") as file:
            data = file.read()
        length = struct.unpack("<I", data[12:16])[0]
        gltf = json.loads(data[20:20 + length])
        cloth = next(m for m in gltf["meshes"] if m["name"] == "garment")
        self.assertEqual(len(cloth["primitives"][0]["targets"]), 5)
        self.assertEqual(gltf["accessors"][cloth["primitives"][0]["attributes"]["POSITION"]]["count"], garment["vertices"])
        self.assertTrue(os.path.exists("0005.png"))

    def test_says_whether_the_drape_came_to_rest(self):
        for seconds, reached in (("0.2", False), ("4", True)):
            done = run("dress", "--avatar", "ball.sqmap", "--garment", self.garment(vertices=200), "-o", "out.glb", "--report", "report.json",
                       "--seconds", seconds, "--fps", "1")
            self.assertEqual(done.returncode, 0, done.stderr)
            with open("report.json") as file:
                garment = json.load(file)["garments"][0]
            rest = garment["rest"]
            self.assertEqual(rest["reached"], reached)
            self.assertEqual(rest["speed_m_s"] > rest["threshold_m_s"], not reached)
            self.assertLess(rest["fastest_vertex"], garment["vertices"])
            words = f"at rest after {rest['since_s']:.2f} s" if reached else \
                f"did not come to rest: fastest vertex {rest['fastest_vertex']} at {rest['speed_m_s']:.2f} m/s"
            self.assertEqual(rest["status"], words)
            self.assertIn(words, done.stdout)

    def test_a_pull_feels_the_cloth(self):
        done = self.dress(pull=[{"at": 0.1, "until": 0.5, "near": [1, 1.02, 1], "by": [0.2, 0.3, 0.2]}])
        self.assertEqual(done.returncode, 0, done.stderr)
        with open("report.json") as file:
            self.assertGreater(json.load(file)["garments"][0]["pulls"][0]["most_cloth_N"], 0.1)

    def test_a_wrong_garment_is_named_with_its_key(self):
        for changes, words in (({"pattern": "cape"}, "poncho, blanket, skirt or shirt"), ({"widht": 1}, "widht"), ({"fabric": "tin"}, "cotton"),
                               ({"width": -1}, "positive"), ({"vertices": 3}, "vertices"), ({"cut": [{"seam": "back"}]}, "seam")):
            done = self.dress(**changes)
            self.assertEqual(done.returncode, 2, changes)
            self.assertIn(words, done.stderr)

    def skinned(self, triangles=None):
        """A ball of two joints, the upper half of which nods."""
        with open("ball.obj") as file:
            lines = [line.split() for line in file]
        vertices = [tuple(map(float, l[1:4])) for l in lines if l[:1] == ["v"]]
        faces = [tuple(int(c.split("/")[0]) - 1 for c in l[1:4]) for l in lines if l[:1] == ["f"]]
        share = [min(max(0.5 + y / 0.6, 0), 1) for _, y, _ in vertices]
        weights = [[("root", 1 - s), ("top", s)] for s in share]
        times = [0.5 * k for k in range(5)]
        turns = [{"top": rig.about(0, 0.3 * math.sin(0.5 * math.pi * k))} for k in range(5)]
        name = "ball.glb" if triangles is None else "open.glb"
        rig.write_glb(name, vertices, faces[:triangles], [("root", -1, (0, 0, 0)), ("top", 0, (0, 0, 0))], weights, times, turns,
                      [0.0] * 5)
        return name

    def test_dresses_a_skinned_mesh_that_moves(self):
        done = run("dress", "--avatar", self.skinned(), "--walk", "--animation", "walk", "--garment", self.garment(), "-o", "out.glb",
                   "--report", "report.json", "--seconds", "2.75", "--rate", "120", "--fps", "4", "--pictures", ".")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open("report.json") as file:
            report = json.load(file)
        garment = report["garments"][0]
        self.assertEqual(garment["status"], [])
        self.assertLess(garment["penetration_at_end"]["nodes_percent_of_height"], 0.2)
        self.assertGreater(garment["most_contacts"], 10)
        with open("out.glb", "rb") as file:
            data = file.read()
        gltf = json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])
        body = next(m for m in gltf["meshes"] if m["name"] == "ball")
        self.assertEqual(len(body["primitives"][0]["targets"]), 11)
        # It stands for a second, and nods from the third on.
        moves = [max(map(abs, gltf["accessors"][t["POSITION"]]["min"] + gltf["accessors"][t["POSITION"]]["max"]))
                 for t in body["primitives"][0]["targets"]]
        self.assertEqual(moves[3], 0)
        self.assertGreater(moves[9], 0.2)

    def test_a_skirt_rides_a_joint(self):
        done = run("dress", "--avatar", self.skinned(), "--walk", "--garment",
                   self.garment(pattern="skirt", waist_radius=1.1, length=0.5, waist_bone="top", width=None, depth=None), "-o", "out.glb",
                   "--seconds", "0.1", "--fps", "10")
        self.assertEqual(done.returncode, 0, done.stderr)
        done = run("dress", "--avatar", "ball.glb", "--garment",
                   self.garment(pattern="skirt", waist_radius=1.1, length=0.5, waist_bone="hip", width=None, depth=None), "-o", "out.glb",
                   "--seconds", "0.1")
        self.assertEqual(done.returncode, 2)
        self.assertIn("hip", done.stderr)

    def test_what_cannot_be_dressed_says_why(self):
        for arguments, code, words in ((["--avatar", self.skinned(triangles=100)], 2, "closed"),
                                       (["--avatar", self.skinned(), "--walk", "--animation", "run"], 2, "'walk'"),
                                       (["--avatar", "ball.sqmap", "--walk"], 64, "no joints"),
                                       (["--avatar", "ball.glb", "--animation", "walk"], 64, "--walk")):
            done = run("dress", *arguments, "--garment", self.garment(), "-o", "x.glb", "--seconds", "0.1")
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(words, done.stderr)
        self.assertFalse(os.path.exists("x.glb"))

    def test_usage(self):
        self.assertEqual(run("dress", "--garment", self.garment(), "-o", "x.glb").returncode, 64)


if __name__ == "__main__":
    unittest.main()
