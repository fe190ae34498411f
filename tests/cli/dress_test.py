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

import coarse

PROGRAM = os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))

import rig  # noqa: E402: beside the program's other scripts


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=600)


class Dress(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        coarse.write_sphere("ball.obj")
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

    def dress(self, *options, seconds="0.5", **changes):
        return run("dress", "--avatar", "ball.sqmap", "--garment", self.garment(**changes), "-o", "out.glb", "--report", "report.json",
                   "--seconds", seconds, "--fps", "10", *options)

    def test_writes_an_animation_and_a_report_that_agree(self):
        done = self.dress()
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

    def test_draws_a_picture_for_each_frame(self):
        for avatar in (["ball.sqmap"], [self.skinned(), "--walk"]):
            done = run("dress", "--avatar", *avatar, "--garment", self.garment(), "-o", "out.glb", "--seconds", "0.1", "--fps", "10",
                       "--pictures", ".")
            self.assertEqual(done.returncode, 0, done.stderr)
            for picture in ("0000.png", "0001.png"):
                self.assertTrue(os.path.exists(picture))
                os.remove(picture)
            self.assertFalse(os.path.exists("0002.png"))

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

    def report(self):
        with open("report.json") as file:
            return json.load(file)

    def test_a_pull_into_the_body_stops_at_it(self):
        pull = {"at": 0.7, "until": 1.2, "near": [0, 1, 0], "by": [0.15, -0.3, 0]}
        for device in ([], ["--device", "simulated:hand=firm"]):
            done = run("dress", "--avatar", "ball.sqmap", "--garment", self.garment(pull=[pull]), "-o", "out.glb", "--report", "report.json",
                       "--seconds", "1.3", "--fps", "60", *device)
            self.assertEqual(done.returncode, 0, done.stderr)
            report = self.report()
            garment = report["garments"][0]
            felt = report["tool"] if device else garment["pulls"][0]
            self.assertGreater(felt["most_body_N"], 10)
            self.assertGreater(felt["most_cloth_N"], 0.05)
            self.assertGreater(felt["most_sent_N"], 1)
            self.assertLessEqual(felt["most_sent_N"], 2 + 1e-9)
            self.assertLess(garment["deepest_node_of_any_frame_m"], 0.01)
            if device:
                self.assertTrue(felt["simulated"])
                self.assertEqual(felt["grasps"], 1)
                self.assertIn("no hardware", done.stdout)
            else:
                self.assertAlmostEqual(felt["tip_behind_m"], 0.3, delta=0.02)

    def test_pins_hold_until_they_are_let_go(self):
        pins = [{"near": [x, 1.02, z], "radius": 0.1} for x in (-1, 1) for z in (-1, 1)]
        heights = []
        for until in (None, 0.1):
            for pin in pins:
                if until:
                    pin["until"] = until
            done = self.dress(centre=[0, 3, 0], pin=pins)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("touched nothing", done.stdout)
            garment = self.report()["garments"][0]
            heights.append(garment["energy_J"]["least"])
        self.assertLess(heights[1], heights[0] - 1, "what is let go falls")

    def test_what_is_listed_happens_or_is_said(self):
        shirt = dict(pattern="shirt", width=None, depth=None, centre=None, collar=[0, 3, 0], vertices=400)
        self.assertEqual(self.dress(seconds="1.2", **shirt).returncode, 0)
        whole = self.report()["garments"][0]["seam_gaps_m"]["sides"]
        self.assertLess(whole, 0.01)  # the sides are sewn after the shoulders, half a second each
        done = self.dress(seconds="1.2", **shirt, cut=[{"seam": "sides"}, {"seam": "shoulders", "at": 9}])
        self.assertGreater(self.report()["garments"][0]["seam_gaps_m"]["sides"], whole + 0.05)
        self.assertIn("a cut at 9 s never came", done.stdout)

    def test_what_cannot_be_written_is_told_first(self):
        for options, words in ((["-o", "absent/x.glb"], "there is no folder absent"), (["-o", "x.gltf"], "is a .glb"),
                               (["-o", "x.glb", "--report", "absent/r.json"], "there is no folder absent")):
            done = run("dress", "--avatar", "ball.sqmap", "--garment", self.garment(), *options, "--seconds", "600")
            self.assertEqual(done.returncode, 2, options)
            self.assertIn(words, done.stderr)
        done = run("dress", "--avatar", "ball.obj", "--garment", self.garment(), "-o", "x.glb")
        self.assertIn("sqmap bake", done.stderr)
        pull = {"at": 0.1, "until": 0.2, "near": [0, 1, 0]}
        for device, pulls, words in (("teleporter", [], "no device of kind"), ("simulated", [], "which have 0"),
                                     ("simulated", [pull, {**pull, "at": 0.3, "until": 0.4}], "which have 2"),
                                     ("network:wait=0.1", [pull], "a garment has a 'pull'")):
            done = self.dress("--device", device, pull=pulls)
            self.assertEqual(done.returncode, 2)
            self.assertIn(words, done.stderr)

    def test_a_pull_ends_between_two_steps_too(self):
        ends = []
        for until in (0.3, 0.303):  # of 240 steps a second
            pull = [{"at": 0.1, "until": until, "near": [9, 30, 9], "by": [0, 0.3, 0]}]
            done = run("dress", "--avatar", "ball.sqmap", "--garment", self.garment(centre=[9, 30, 9], width=0.5, depth=0.5, pull=pull),
                       "-o", "out.glb", "--report", "report.json", "--seconds", "2", "--fps", "1")
            self.assertEqual(done.returncode, 0, done.stderr)
            ends.append(self.report()["garments"][0]["rest"]["speed_m_s"])
        self.assertGreater(min(ends), 3, "what is let go falls")

    def test_a_wrong_garment_is_named_with_its_key(self):
        for changes, words in (({"pattern": "cape"}, "poncho, blanket, skirt or shirt"), ({"widht": 1}, "widht"), ({"fabric": "tin"}, "cotton"),
                               ({"width": -1}, "'width' is -1: it must be from 0.001 to 20"),
                               ({"width": 1e300}, "'width' is 1e+300"), ({"centre": [0, 1e20, 0]}, "are these metres?"),
                               ({"pattern": "poncho", "hole_x": 3}, "'hole_x' is 3"), ({"fabric": {"thickness": 1}}, "garment.json: fabric: 'thickness'"),
                               ({"pull": [{"at": 1, "until": 0.5}]}, "later than 'at'"), ({"cut": [{"seam": "back", "at": -1}]}, "'at' is -1"),
                               ({"pull": [{"at": 1, "until": 2}, {"at": 1.5, "until": 3}]}, "two at one time"),
                               ({"pin": [{"bone": "tail"}]}, "'bone' tail is none of the avatar's: world, ball"), ({"vertices": 3}, "vertices"), ({"cut": [{"seam": "back"}]}, "seam")):
            done = self.dress(**changes)
            self.assertEqual(done.returncode, 2, changes)
            self.assertIn(words, done.stderr)

    def skinned(self, triangles=None):
        """A ball of two joints, the upper half of which nods."""
        coarse.write_sphere("skinned.obj", 2)
        with open("skinned.obj") as file:
            lines = [line.split() for line in file]
        vertices = [tuple(map(float, l[1:4])) for l in lines if l[:1] == ["v"]]
        faces = [tuple(int(c.split("/")[0]) - 1 for c in l[1:4]) for l in lines if l[:1] == ["f"]]
        share = [min(max(0.5 + y / 0.6, 0), 1) for _, y, _ in vertices]
        weights = [[("root", 1 - s), ("top", s)] for s in share]
        times = [0.5 * k for k in range(5)]
        turns = [{"top": rig.about(0, 0.3 * math.sin(0.5 * math.pi * k))} for k in range(5)]
        name = "ball.glb" if triangles is None else "open.glb"
        skeleton = [("root", -1, (0, 0, 0)), ("top", 0, (0, 0, 0))]
        rig.write_glb(name, rig.Figure(vertices, faces[:triangles], skeleton, weights, times, turns, [0.0] * 5))
        return name

    def test_dresses_a_skinned_mesh_that_moves(self):
        done = run("dress", "--avatar", self.skinned(), "--walk", "--animation", "walk", "--garment", self.garment(), "-o", "out.glb",
                   "--report", "report.json", "--seconds", "2.75", "--rate", "120", "--fps", "4")
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
