#!/usr/bin/env python3
"""sqmap dress end to end on a ball: the animation, the report, and what it says when a garment file is wrong.

usage: dress_test.py PROGRAM
"""
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))


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

    def test_usage(self):
        self.assertEqual(run("dress", "--garment", self.garment(), "-o", "x.glb").returncode, 64)


if __name__ == "__main__":
    unittest.main()
