#!/usr/bin/env python3
"""sqmap touch, replay and devices end to end: recordings that replay to the bit, and what is said when something is wrong.

usage: touch_test.py PROGRAM NETWORK_CLIENT
"""
import base64
import contextlib
import csv
import importlib.util
import json
import math
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import xml.dom.minidom
import zlib

CLIENT = os.path.abspath(sys.argv.pop(2))
PROGRAM = os.path.abspath(sys.argv.pop(1))
README = os.path.join(os.path.dirname(os.path.dirname(CLIENT)), "README.md")


def run(*arguments, timeout=300):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=timeout)


def read(path):
    with open(path) as text:
        return text.read()


def write(path, text):
    with open(path, "w") as out:
        out.write(text)


def rows_of(trace):
    with open(trace, newline="") as text:
        return list(csv.DictReader(line for line in text if not line.startswith("#")))


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("it never happened")
        time.sleep(0.01)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def write_png(path, width, height, grey):
    """grey(x, y): 0 to 255."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(grey(x, y) for x in range(width)) for y in range(height))
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_hand(path):
    """A glTF of 25 joints with WebXR's names and an octahedron about each, moved by that joint alone."""
    names, places = ["wrist"], [(0, 0, 0)]
    for finger, x, y, bones in (("thumb", 0.03, 0.02, (0.03, 0.03, 0.03)), ("index-finger", 0.025, 0.02, (0.06, 0.04, 0.03, 0.02)),
                                ("middle-finger", 0.005, 0.02, (0.06, 0.045, 0.03, 0.02)), ("ring-finger", -0.015, 0.02, (0.06, 0.04, 0.03, 0.02)),
                                ("pinky-finger", -0.03, 0.02, (0.055, 0.03, 0.02, 0.02))):
        parts = ["metacarpal", "phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"]
        if finger == "thumb":
            parts.remove("phalanx-intermediate")
        for part, bone in zip(parts, (*bones, 0)):
            names.append(f"{finger}-{part}")
            places.append((x, y, -0.01 if finger == "thumb" else 0))
            x, y = x + (0.6 * bone if finger == "thumb" else 0), y + bone
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    points = [tuple(p[k] + 0.008 * c[k] for k in range(3)) for p in places for c in corners]
    arrays = [("VEC3", 5126, b"".join(struct.pack("<3f", *p) for p in points), len(points)),
              ("VEC4", 5121, b"".join(struct.pack("<4B", i // 6, 0, 0, 0) for i in range(len(points))), len(points)),
              ("VEC4", 5126, struct.pack("<4f", 1, 0, 0, 0) * len(points), len(points)),
              ("SCALAR", 5123, b"".join(struct.pack("<3H", *(6 * j + v for v in f)) for j in range(25) for f in faces), 25 * 24),
              ("MAT4", 5126, b"".join(struct.pack("<16f", 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -p[0], -p[1], -p[2], 1) for p in places), 25)]
    blob, views, accessors = b"", [], []
    for kind, component, data, count in arrays:
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind})
        blob += data + b"\0" * (-len(data) % 4)
    accessors[0] |= {"min": [min(p[k] for p in points) for k in range(3)], "max": [max(p[k] for p in points) for k in range(3)]}
    write(path, json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [*range(26)]}],
        "nodes": [{"name": n, "translation": p} for n, p in zip(names, places)] + [{"mesh": 0, "skin": 0}],
        "skins": [{"joints": [*range(25)], "inverseBindMatrices": 4}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 3}]}],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(blob), "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode()}]}))


class Touch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        for shape in ("sphere", "torus"):
            assert run("shapes", shape, "-o", shape + ".obj").returncode == 0
            baked = run("bake", shape + ".obj", "-o", shape + ".sqmap")
            assert baked.returncode == 0, baked.stderr

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    def record(self, name, *options, model="sphere.sqmap", device="slide", seconds="1"):
        if os.path.exists(name):
            os.remove(name)
        result = run("touch", "--object", model, "--device", device, "--seconds", seconds, "--record", name, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def test_ten_thousand_ticks_replay_to_the_bit_in_any_number_of_threads(self):
        self.record("long.csv", model="torus.sqmap", seconds="10")  # from z it has a hole: another side is taken
        rows = rows_of("long.csv")
        self.assertEqual(len(rows), 10000)
        self.assertGreater(sum(int(row["contacts"]) > 0 for row in rows), 9000)
        hashes = set()
        for threads in ("1", "2", "5"):
            result = run("replay", "long.csv", "--threads", threads)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertIn("10000 ticks, all bit-identical", result.stdout)
            self.assertEqual("all the same forces" in result.stdout, threads != "1")
            hashes.add(re.search(r"forces ([0-9a-f]{16})", result.stdout)[1])
        self.assertEqual(len(hashes), 1)

    def test_the_commands_of_the_readme_do_what_it_says(self):
        commands = re.findall(r"^\$ sqmap ((?:touch|replay|rtcheck) .*)$", read(README), re.MULTILINE)
        self.assertEqual([c.split()[0] for c in commands], ["touch", "replay", "rtcheck"])
        for command in commands:
            result = run(*command.replace("cow.sqmap", "sphere.sqmap").split())
            self.assertEqual(result.returncode, 0, (command, result.stdout, result.stderr))
        self.assertIn("all bit-identical", run("replay", "touch.csv").stdout)
        self.assertGreater(max(math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows_of("touch.csv")), 0.1)
        xml.dom.minidom.parse("touch.svg")

    def test_every_mode_tool_and_friction_replays_to_the_bit(self):
        write_png("grey.png", 16, 16, lambda x, y: 16 * x)
        for options in (["--tool", "point"], ["--tool", "point:0.002", "--shading", "consistent"], ["--tool", "torus.obj", "--tool-size", "0.05"],
                        ["--tool", "torus.obj", "--tool-size", "0.05", "--tool-spacing", "0.002"],
                        ["--tool", "torus.obj", "--tool-size", "0.05", "--tool-touching", "0"],
                        ["--mode", "proxy"], ["--mode", "coupled"], ["--friction", "none"], ["--friction", "paper"], ["--layer", "exact"],
                        ["--layer", "2", "--damping", "2", "--brake", "1", "--zone", "0.02"],
                        ["--mode", "coupled", "--coupling-stiffness", "300", "--coupling-damping", "0.1", "--coupling-turn-stiffness", "0.1",
                         "--coupling-turn-damping", "1e-4", "--mass", "0.01", "--inertia", "1e-5"],
                        ["--texture", "gaussian", "--texture-seed", "7"], ["--texture", "weave", "--texture-depth", "0.001"],
                        ["--texture", "image:grey.png", "--texture-wavelength", "0.001"], ["--object-mass", "0.2"],
                        ["--object-mass", "0.1", "--object-spring", "50", "--sway", "0.002/0/0.001", "--sway-period", "0.5"],
                        ["--smoothing-kernel", "shell", "--smoothing-tolerance", "0.001"]):
            self.record("mode.csv", *options)
            result = run("replay", "mode.csv")
            self.assertEqual(result.returncode, 0, (options, result.stdout, result.stderr))
            self.assertIn("1000 ticks, all bit-identical", result.stdout)
            felt = [math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows_of("mode.csv")]
            self.assertGreater(max(felt), 0.01, options)

    def test_the_papers_force_is_of_the_papers_maps(self):
        refused = run("touch", "--object", "torus.sqmap", "--device", "slide", "--seconds", "0.1", "--force", "paper")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--projection normal", refused.stderr)
        self.assertEqual(run("bake", "torus.obj", "-o", "maps.sqmap", "--projection", "normal").returncode, 0)
        for options in ([], ["--tool", "point"], ["--projector", "printed", "--layer", "2"], ["--offset", "--friction", "coulomb"]):
            self.record("paper.csv", "--force", "paper", *options, model="maps.sqmap")
            result = run("replay", "paper.csv")
            self.assertIn("1000 ticks, all bit-identical", result.stdout, (options, result.stderr))
            felt = [math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows_of("paper.csv")]
            self.assertGreater(max(felt), 0.01, options)

    def test_a_press_is_as_deep_and_as_strong_as_asked(self):
        # A ball of R_max 0.3 m pressed 2 mm deep by a point of 500 N/m: 1 N, along the press.
        self.record("press.csv", "--tool", "point", device="press:depth=0.002,direction=0/0/1", seconds="2")
        rows = rows_of("press.csv")
        middle = rows[len(rows) // 2]
        self.assertAlmostEqual(float(middle["z0_pz"]), 0.15 - 0.002, delta=0.0003)
        self.assertAlmostEqual(float(middle["z0_fz"]), 1.0, delta=0.15)
        self.assertLess(math.hypot(float(middle["z0_fx"]), float(middle["z0_fy"])), 0.1)
        sent = [math.hypot(*(float(row["z0_sent_f" + axis]) for axis in "xyz")) for row in rows]
        self.assertGreater(max(sent), 0.5, "the filter lets it through")
        self.assertLess(max(sent), 1.0 + 1e-9, "and no more than for a device that tells nothing")

    def test_the_same_path_gives_the_same_file_but_for_cpu_time(self):
        self.record("one.csv")
        self.record("two.csv")
        one, two = rows_of("one.csv"), rows_of("two.csv")
        for row in one + two:
            row.pop("cpu")
        self.assertEqual(one, two)

    def test_a_replay_finds_a_changed_digit_and_says_where(self):
        self.record("digit.csv")
        lines = read("digit.csv").split("\n")
        columns = next(line for line in lines if line.startswith("time,")).split(",")
        number = next(i for i, line in enumerate(lines) if line.startswith("0.5,"))
        cells = lines[number].split(",")
        force = columns.index("z0_fz")
        cells[force] = repr(math.nextafter(float(cells[force]), math.inf))
        lines[number] = ",".join(cells)
        write("digit.csv", "\n".join(lines))
        result = run("replay", "digit.csv")
        self.assertEqual(result.returncode, 1)
        self.assertIn("1 of 1000 ticks differ", result.stdout)
        self.assertIn(f"first on line {number + 1}, at 0.5 s: z0_fz", result.stdout)
        result = run("replay", "digit.csv", "--diff")
        self.assertEqual(result.returncode, 1)
        table = list(csv.DictReader(result.stdout.splitlines()))
        self.assertEqual([row["columns"] for row in table], ["z0_fz"])
        self.assertEqual(int(table[0]["line"]), number + 1)
        self.assertIn("1 of 1000 ticks differ", result.stderr)

    def test_against_another_model_says_how_forces_differ(self):
        self.record("ball.csv")
        result = run("replay", "ball.csv", "--against", "torus.sqmap", "--plot", "both.svg")
        self.assertIn("against torus.sqmap", read("both.svg"))
        self.assertEqual(result.returncode, 0, "differences are what was asked for")
        self.assertRegex(result.stdout, r"of 1000 ticks differ")
        self.assertGreater(float(re.search(r"largest difference: force (\S+) N", result.stdout)[1]), 0.01)
        result = run("replay", "ball.csv", "--against", "sphere.sqmap")
        self.assertIn("all bit-identical", result.stdout)

    def test_another_model_under_the_same_name_is_refused(self):
        os.link("sphere.sqmap", "thing.sqmap")
        self.record("thing.csv", model="thing.sqmap")
        os.replace("thing.sqmap", "kept.sqmap")
        os.link("torus.sqmap", "thing.sqmap")
        result = run("replay", "thing.csv")
        self.assertEqual(result.returncode, 2)
        self.assertIn("is not the model that was recorded", result.stderr)
        os.remove("thing.sqmap")
        self.assertEqual(run("replay", "thing.csv").returncode, 2)
        # Beside the trace is a place to look, for traces that travel with their models.
        os.mkdir("travelled")
        os.rename("thing.csv", "travelled/thing.csv")
        os.rename("kept.sqmap", "travelled/thing.sqmap")
        self.assertEqual(run("replay", "travelled/thing.csv").returncode, 0)
        there = subprocess.run([PROGRAM, "replay", "thing.csv"], capture_output=True, text=True, timeout=300, cwd="travelled")
        self.assertEqual(there.returncode, 0, there.stderr)

    def test_objects_stand_where_they_are_put(self):
        self.record("two_objects.csv", "--object", "torus.sqmap@1,0,0", device="press", seconds="1")
        setup = json.loads(next(line for line in read("two_objects.csv").split("\n") if line.startswith("# setup "))[8:])
        self.assertEqual([o["place"] for o in setup["objects"]], [[0, 0, 0], [1, 0, 0]])
        self.assertEqual(run("replay", "two_objects.csv").returncode, 0)
        self.assertEqual(run("touch", "--object", "sphere.sqmap@1,2", "--seconds", "0.1").returncode, 2)

    def test_units_and_scale(self):
        # The ball's radius is 1 mesh unit: a millimetre.
        self.record("unit.csv", "--unit", "mm", "--tool", "sphere:0.0001", device="press:depth=0.0001,gap=0.0002,speed=0.001")
        self.assertAlmostEqual(float(rows_of("unit.csv")[0]["z0_pz"]), 0.001 + 0.0001 + 0.0002, delta=2e-5)
        self.assertEqual(run("touch", "--object", "sphere.sqmap", "--unit", "mm", "--scale", "1").returncode, 64)

    def test_a_recorded_path_and_a_trace_are_devices(self):
        self.record("first.csv")
        self.record("again.csv", device="trace:first.csv")
        first, again = rows_of("first.csv"), rows_of("again.csv")
        self.assertEqual([row["z0_fz"] for row in first], [row["z0_fz"] for row in again])
        poses = ["r00", "r01", "r02", "r10", "r11", "r12", "r20", "r21", "r22", "px", "py", "pz"]
        with open("path.csv", "w") as out:
            out.write("r00,r01,r02,r10,r11,r12,r20,r21,r22,tx,ty,tz\n")
            for row in first:
                out.write(",".join(row["z0_" + column] for column in poses) + "\n")
        self.record("third.csv", device="path:path.csv")
        self.assertEqual([row["z0_fz"] for row in first], [row["z0_fz"] for row in rows_of("third.csv")])

    def test_seconds_end_a_recorded_path_too(self):
        self.record("whole.csv", seconds="0.5")
        self.record("part.csv", device="trace:whole.csv", seconds="0.2")
        self.assertEqual(len(rows_of("part.csv")), 200)
        run("touch", "--object", "sphere.sqmap", "--device", "trace:whole.csv", "--record", "all.csv")
        self.assertEqual(len(rows_of("all.csv")), 500)

    def test_the_summary_tells_what_was_sent(self):
        result = self.record("sent.csv", "--tool", "point", device="press:depth=0.01", seconds="4")
        asked, sent = self.forces("sent.csv"), [math.hypot(*(float(row["z0_sent_f" + axis]) for axis in "xyz"))
                                                for row in rows_of("sent.csv")]
        self.assertGreater(max(asked), 4)
        self.assertAlmostEqual(max(sent), 2, delta=1e-9)
        self.assertIn(f"largest commanded force {max(asked):.4g} N", result.stdout)
        changed = sum(any(row["z0_sent_" + c] != row["z0_" + c] for c in ("fx", "fy", "fz", "tx", "ty", "tz"))
                      for row in rows_of("sent.csv"))
        self.assertRegex(result.stdout, rf"sent: at most 2 N of 2 N allowed; the safety filter changed .* in {changed} ticks")
        self.assertNotRegex(result.stdout, r"[1-9]\d* ticks for the motors' heat", "a path has no motors")

    def test_a_proxy_that_is_pushed_is_a_touch(self):
        result = self.record("proxy.csv", "--tool", "point", "--mode", "proxy", device="press:depth=0.004", seconds="2")
        self.assertNotIn("nothing was touched", result.stderr)
        self.assertGreater(int(re.search(r"(\d+) in contact", result.stdout)[1]), 500)
        self.assertAlmostEqual(float(re.search(r"deepest (\S+) m", result.stdout)[1]), 0.004, delta=3e-4)

    def test_stiffness_that_nobody_asked_for_is_what_the_device_can_show(self):
        device = "simulated:press,delay=3"
        result = self.record("shown.csv", device=device, seconds="0.3")
        self.assertRegex(result.stdout, r"stiffness 286 N/m: as much as this device shows")
        self.assertNotIn("warning", result.stdout)
        self.assertRegex(read("shown.csv"), r'"stiffness":28[56]')
        self.assertEqual(run("replay", "shown.csv").returncode, 0)
        result = self.record("asked.csv", "--stiffness", "500", device=device, seconds="0.2")
        self.assertIn("warning: this device can show 286 N/m", result.stdout)
        self.assertIn('"stiffness":500', read("asked.csv"))

    def test_a_simulated_device_is_recorded_by_the_clock_and_replays(self):
        result = self.record("simulated.csv", device="simulated:slide,hand=firm", seconds="1.5")
        self.assertIn("no hardware", result.stdout)
        self.assertIn("no hardware", read("simulated.csv")[:2000])
        self.assertEqual(run("replay", "simulated.csv").returncode, 0)
        sent = [math.hypot(*(float(row["z0_sent_f" + axis]) for axis in "xyz")) for row in rows_of("simulated.csv")]
        self.assertLessEqual(max(sent), 2.0 + 1e-12)

    def test_a_glove_has_six_zones_and_replays(self):
        self.record("glove.csv", "--tool", "sphere:0.008", device="glove", seconds="2.5")
        rows = rows_of("glove.csv")
        self.assertIn("z5_sent_tz", rows[0])
        self.assertNotIn("z6_px", rows[0])
        for zone in range(6):  # one that begins inside has no force
            self.assertEqual([float(rows[0][f"z{zone}_f{axis}"]) for axis in "xyz"], [0, 0, 0])
        felt = [max(math.hypot(*(float(row[f"z{zone}_f{axis}"]) for axis in "xyz")) for row in rows) for zone in range(6)]
        self.assertGreater(sum(force > 0.01 for force in felt), 1, felt)
        self.assertIn("bit-identical", run("replay", "glove.csv").stdout)

    def test_what_begins_inside_is_told_with_the_cure(self):
        inside = self.record("inside.csv", device="press:gap=-0.002,depth=0.004", seconds="0.5")
        self.assertIn("the tool was inside an object when forces were to begin, and had none in 500 ticks, from 0.000 s to the end",
                      inside.stdout)
        self.assertIn("cure: start outside, or lift it out of the object once", inside.stdout)
        for row in rows_of("inside.csv"):
            self.assertEqual(int(row["filter"]) & 1024, 1024)
            self.assertEqual([float(row["z0_sent_f" + axis]) for axis in "xyz"], [0, 0, 0])
        outside = self.record("outside.csv", device="press:depth=0.004", seconds="0.5")
        self.assertNotIn("inside", outside.stdout)
        self.assertEqual([row for row in rows_of("outside.csv") if int(row["filter"]) & 1024], [])

    def forces(self, name):
        return [math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows_of(name)]

    def test_a_texture_is_carved_and_another_seed_is_another_relief(self):
        plain, textured, other, image = "plain.csv", "textured.csv", "other.csv", "image.csv"
        write_png("black.png", 8, 8, lambda x, y: 0)
        point = ["--tool", "point", "--friction", "none"]
        self.record(plain, *point)
        self.record(textured, *point, "--texture", "gaussian")
        self.record(other, *point, "--texture", "gaussian", "--texture-seed", "2")
        self.record(image, *point, "--texture", "image:black.png", "--texture-depth", "0.0005")
        smooth, rough, rough2, deep = (self.forces(name) for name in (plain, textured, other, image))
        step = lambda f: sum(abs(a - b) for a, b in zip(f, f[1:])) / len(f)
        self.assertGreater(step(rough), 1.5 * step(smooth))
        self.assertNotEqual(rough, rough2)
        # Black everywhere: 0.5 mm further in, 0.25 N less.
        self.assertAlmostEqual(smooth[500] - deep[500], 0.25, delta=0.05)
        self.assertNotIn("texture_hash\":\"0000000000000000", read(textured))
        # An image that has changed is not the one that was recorded.
        write_png("black.png", 8, 8, lambda x, y: 128)
        result = run("replay", image)
        self.assertEqual(result.returncode, 2)
        self.assertIn("is not the texture that was recorded", result.stderr)

    def test_an_object_that_moves_gives_way_and_comes_back(self):
        press = "press:depth=0.004,direction=0/0/1"
        for name, options in (("fixed.csv", []), ("gives.csv", ["--object-mass", "0.2", "--object-spring", "100"])):
            self.record(name, "--tool", "point", *options, device=press, seconds="2")
        fixed, gives = self.forces("fixed.csv"), self.forces("gives.csv")
        middle = len(fixed) // 2
        # 4 mm through 500 N/m, and through 500 and 100 N/m one after the other.
        self.assertAlmostEqual(fixed[middle], 2.0, delta=0.2)
        self.assertAlmostEqual(gives[middle], 0.004 / (1 / 500 + 1 / 100), delta=0.06)
        self.record("sways.csv", "--tool", "point", "--sway", "0/0/0.002", "--sway-period", "1", device=press, seconds="2")
        swaying = self.forces("sways.csv")[middle - 400:middle + 400]
        self.assertGreater(max(swaying) - min(swaying), 1.2)

    def test_a_coupling_is_taken_from_the_device_and_is_still(self):
        result = self.record("coupled.csv", "--mode", "coupled", device="simulated:press,hand=pen", model="torus.sqmap", seconds="3")
        self.assertRegex(result.stdout, r"coupled by 467 N/m and 0\.2 N s/m")
        self.assertEqual(run("replay", "coupled.csv").returncode, 0)
        rows = rows_of("coupled.csv")
        free = [math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows if int(row["contacts"]) == 0]
        self.assertLess(max(free, default=0), 0.2, "it does not keep the filter from engaging")
        result = self.record("stiff.csv", "--mode", "coupled", "--coupling-stiffness", "2000", device="simulated:press", seconds="0.2")
        self.assertIn("--coupling-stiffness 2000: this device carries 467 N/m", result.stdout)
        result = self.record("direct.csv", "--coupling-stiffness", "300", seconds="0.1")
        self.assertIn("warning: the coupling's options count in --mode coupled only", result.stdout)
        result = self.record("direct.csv", "--smoothing-tolerance", "0.001", "--tool", "torus.obj", seconds="0.1")
        self.assertIn("--smoothing-tolerance are of a sphere or a point", result.stdout)

    def test_a_glove_poses_a_hand_of_25_joints_and_replays(self):
        write_hand("hand.gltf")
        result = self.record("hand.csv", "--tool", "hand.gltf", device="glove:curl=0.9", seconds="2.5")
        self.assertNotIn("each of the 6 zones carries", result.stdout)
        rows = rows_of("hand.csv")
        felt = [max(math.hypot(*(float(row[f"z{zone}_f{axis}"]) for axis in "xyz")) for row in rows) for zone in range(6)]
        self.assertGreater(sum(force > 0.01 for force in felt), 1, felt)
        result = run("replay", "hand.csv", "--threads", "2")
        self.assertIn("bit-identical", result.stdout, result.stderr)
        # Any other mesh is six meshes, and that is said.
        result = self.record("six.csv", "--tool", "torus.obj", "--tool-size", "0.02", device="glove", seconds="0.2")
        self.assertIn("each of the 6 zones carries the whole of torus.obj", result.stdout)

    def test_an_impact_zone_that_holds_nothing_is_said(self):
        touch = ["touch", "--object", "sphere.sqmap", "--device", "slide", "--seconds", "0.3", "--tool-size", "0.1", "--tool", "torus.obj"]
        result = run(*touch, "--zone", "0.005")
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, r"--zone 0\.005: no point of torus\.obj is so near to its centre \(the nearest: 0\.\d+ m\)")
        self.assertIn("cure:", result.stderr)
        result = run(*touch, "--zone", "0.08")
        self.assertEqual(result.returncode, 0)
        self.assertRegex(result.stdout, r"--zone 0\.08: \d+ of the tool's \d+ points count")
        result = run("touch", "--object", "sphere.sqmap", "--device", "press:depth=-0.002,speed=0.1", "--seconds", "0.2")
        self.assertIn("warning: nothing was touched", result.stderr)

    def test_scripts_wait_for_the_filter_and_say_when_time_is_short(self):
        for script in ("press", "tap", "slide", "circle"):
            self.assertIn("changed the commanded force in 0 ticks", self.record("s.csv", device=script, seconds="2").stdout)
        result = self.record("s.csv", device="press:wait=0.2,depth=0.005,gap=0.005,speed=0.1", seconds="0.5")
        self.assertIn("warning: 0.5 s are too short for all of this script: at least 0.575 s, of which it waits 0.2 s", result.stdout)

    def test_bad_poses_are_counted(self):
        self.record("good.csv", seconds="2")
        lines = read("good.csv").split("\n")
        first = next(i for i, line in enumerate(lines) if line.startswith("time,")) + 1
        place = lines[first - 1].split(",").index("z0_px")

        def change(tick, to):
            row = lines[first + tick].split(",")
            row[place] = to(row[place])
            lines[first + tick] = ",".join(row)
        change(900, lambda x: "nan")
        for tick in range(1000, 2000):
            change(tick, lambda x: str(float(x) + 0.08))
        write("faulty.csv", "\n".join(lines))
        result = self.record("felt.csv", device="trace:faulty.csv", seconds="2")
        self.assertIn("not finite in 1 tick", result.stdout)
        self.assertIn("the pose jumped once", result.stdout)

    def test_plots_are_svg(self):
        self.record("plotted.csv", "--plot", "plotted.svg")
        text = xml.dom.minidom.parse("plotted.svg").toxml()
        for words in ("deepest", "force, N", "torque", "CPU time", "time, s", "no hardware"):
            self.assertTrue(words in text, words)
        self.assertEqual(run("replay", "plotted.csv", "--plot", "again.svg").returncode, 0)
        self.assertTrue(read("plotted.svg") == read("again.svg"))
        self.assertEqual(run("touch", "--object", "sphere.sqmap", "--plot", "x.svg").returncode, 2)

    def test_an_interrupt_ends_a_recording_and_a_kill_leaves_what_was_written(self):
        command = [PROGRAM, "touch", "--object", "sphere.sqmap", "--device", "simulated:press", "--seconds", "120"]
        for how in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            name = how.name + ".csv"
            part = name + ".recording"
            process = subprocess.Popen([*command, "--record", name], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            wait_for(lambda: os.path.exists(part) and os.path.getsize(part) > 100000)
            process.send_signal(how)
            process.communicate(timeout=60)
            self.assertEqual(os.path.exists(name), how != signal.SIGKILL)
            self.assertEqual(os.path.exists(part), how == signal.SIGKILL)
            result = run("replay", name if how != signal.SIGKILL else part)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertEqual("cut short" in result.stdout, how == signal.SIGKILL)
        # What is left of the killed one is not written over.
        result = run(*command[1:], "--record", "SIGKILL.csv")
        self.assertEqual(result.returncode, 2)
        self.assertIn("SIGKILL.csv.recording", result.stderr)

    def test_another_program_is_the_device(self):
        for own_process in ([], ["--own-process"]):
            port = str(free_port())
            process = subprocess.Popen([PROGRAM, "touch", "--object", "sphere.sqmap", "--tool", "sphere:0.01", "--device",
                                        f"network:port={port},wait=60", "--seconds", "60", "--record", "network.csv", *own_process],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            client = subprocess.run([sys.executable, CLIENT, "--port", port, "--seconds", "4"], capture_output=True,
                                    text=True, timeout=60)
            self.assertEqual(client.returncode, 0, client.stderr)
            process.send_signal(signal.SIGINT)
            out, error = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 0, error)
            self.assertIn("network client 'example'", out)
            self.assertIn("the device was gone at the end", out)
            strongest = float(re.search(r"strongest force (\S+) N", client.stdout)[1])
            self.assertGreater(strongest, 0.01, client.stdout + out)
            self.assertLessEqual(strongest, 2.0)
            self.assertEqual(run("replay", "network.csv").returncode, 0)
            # What the last poses were answered with is nothing: the client had gone, which is recorded tick by tick.
            rows = rows_of("network.csv")
            self.assertEqual(rows[-1]["input"], "4")
            self.assertEqual(len(rows), int(re.search(r"(\d+) ticks,", out)[1]), "no tick is left out")
            self.assertEqual([float(rows_of("network.csv")[-1]["z0_sent_f" + axis]) for axis in "xyz"], [0, 0, 0])
            os.remove("network.csv")

    def test_a_fault_is_told_when_it_comes_and_at_the_end(self):
        port = str(free_port())
        process = subprocess.Popen([PROGRAM, "touch", "--object", "sphere.sqmap", "--tool", "sphere:0.01", "--device",
                                    f"network:port={port},wait=60", "--seconds", "60"], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        client = subprocess.Popen([sys.executable, CLIENT, "--port", port, "--seconds", "3"], stdout=subprocess.PIPE, text=True)
        time.sleep(1.5)
        client.send_signal(signal.SIGSTOP)
        time.sleep(0.5)
        client.send_signal(signal.SIGCONT)
        client.communicate(timeout=60)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, error)
        self.assertRegex(error, r"no force from \d+\.\d+ s on: no new pose for 100 ms\n")
        self.assertRegex(out, r"let no force through in \d+ ticks, first at \S+ s: no new pose for 100 ms")

    def test_a_client_is_told_of_a_fault_and_resumes(self):
        for own_process in ([], ["--own-process"]):
            port = str(free_port())
            process = subprocess.Popen([PROGRAM, "touch", "--object", "sphere.sqmap", "--tool", "sphere:0.01", "--device",
                                        f"network:port={port},wait=60", "--seconds", "60", *own_process], stdin=subprocess.DEVNULL,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            client = subprocess.Popen([sys.executable, CLIENT, "--port", port, "--seconds", "8"], stdin=subprocess.PIPE,
                                      stdout=subprocess.PIPE, text=True)
            time.sleep(1)
            client.send_signal(signal.SIGSTOP)
            time.sleep(0.5)
            client.send_signal(signal.SIGCONT)
            said = client.stdout.readline()
            self.assertIn("no force: no new pose for 100 ms", said)
            client.stdin.write("\n")
            client.stdin.flush()
            said = client.stdout.readline() + client.communicate(timeout=60)[0]
            self.assertIn("goes on", said)
            self.assertGreater(float(re.search(r"strongest force (\S+) N", said)[1]), 0.01, said)
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.communicate(timeout=60) and process.returncode, 0)

    def test_a_device_that_goes_and_comes_back_replays_to_the_bit(self):
        spec = importlib.util.spec_from_file_location("client", CLIENT)
        client = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(client)
        for own_process in ([], ["--own-process"]):
            self.go_and_come_back(client, own_process)

    def go_and_come_back(self, client, own_process):
        port = free_port()
        process = subprocess.Popen([PROGRAM, "touch", "--object", "sphere.sqmap", "--tool", "sphere:0.01", "--device",
                                    f"network:port={port},wait=60", "--seconds", "60", "--record", "gone.csv", *own_process],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            link.connect(("127.0.0.1", port))
            link.settimeout(0.2)
            for _ in range(3):  # the ball reaches to 0.15 m
                token = client.connect(link, 30)
                for i in range(1, 1001):
                    pose = (0, 0, 0.161 - 0.000004 * i, 1, 0, 0, 0)
                    link.send(client.message(client.POSE, i, struct.pack("<Qd2I7d", token, 0, 0, 0, *pose)))
                    time.sleep(0.001)
                link.send(client.message(client.BYE, 1001, struct.pack("<Q", token)))
                time.sleep(0.1)
                link.setblocking(False)
                with contextlib.suppress(BlockingIOError):
                    while link.recv(2048):
                        pass
                link.settimeout(0.2)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, error)
        rows = rows_of("gone.csv")
        self.assertIn("not recorded: 0", out)
        self.assertEqual(len(rows), int(re.search(r"(\d+) ticks,", out)[1]), "no tick is left out")
        self.assertGreater(sum(float(row["z0_fz"]) > 0.1 for row in rows), 100)
        replayed = run("replay", "gone.csv")
        self.assertEqual(replayed.returncode, 0, replayed.stdout)
        pressed = [float(row["time"]) for row in rows if float(row["z0_fz"]) > 0.1]
        self.assertEqual(sum(b - a > 0.3 for a, b in zip(pressed, pressed[1:])), 2, "felt all three times")
        os.remove("gone.csv")

    def test_what_cannot_be_recorded_is_said_before_a_device_is_opened(self):
        for name, words in (("no/such/folder.csv", "cannot write"), (".", "folder")):
            result = run("touch", "--object", "sphere.sqmap", "--device", f"network:port={free_port()},wait=1", "--record", name)
            self.assertEqual(result.returncode, 2)
            self.assertIn(words, result.stderr)
            self.assertNotIn("no client", result.stderr)

    def test_options_without_effect_are_said(self):
        for options in (["--k-f", "5"], ["--texture-depth", "0.001"], ["--mass", "0.1"], ["--proxy-depth", "0.001"],
                        ["--mode", "proxy", "--brake", "1"], ["--tool", "sphere", "--tool-touching", "9"]):
            result = run("touch", "--object", "sphere.sqmap", "--seconds", "0.01", *options)
            self.assertIn(f"warning: {options[-2]} counts with ", result.stderr)
        self.assertNotIn("counts with", run("touch", "--object", "sphere.sqmap", "--seconds", "0.01", "--mu-static", "0.5").stderr)

    def test_dampers_near_the_devices_own_are_scaled(self):
        result = self.record("damped.csv", "--damping", "5", device="simulated:press", seconds="0.3")
        self.assertIn("--damping 5 and --brake 0 are scaled by 0.1", result.stdout)
        self.assertIn('"damping":0.5', read("damped.csv"))

    def test_wrong_input_is_2_and_says_what(self):
        write("no_trace.csv", "x,y,z\n1,2,3\n")
        self.record("short.csv", seconds="0.05")
        text = read("short.csv")
        write("no_setup.csv", "".join(line + "\n" for line in text.split("\n")[:-1] if not line.startswith("# setup")))
        write("bad_setup.csv", re.sub(r"# setup .*", "# setup {\"objects\":7}", text))
        write("bad_row.csv", text.replace("\n0.01,", "\n0.01x,"))
        rows = text.split("\n")
        first = next(i for i, row in enumerate(rows) if row.startswith("time,")) + 1

        def spoil(name, change):
            write(name, "\n".join(rows[:first + 5] + [change(rows[first + 5])] + rows[first + 6:]))
        spoil("nan_time.csv", lambda row: "nan" + row[row.index(","):])
        spoil("back.csv", lambda row: "-1" + row[row.index(","):])
        spoil("input.csv", lambda row: re.sub(r"^(([^,]*,){4})[^,]*,", r"\g<1>99,", row))
        spoil("inf_dt.csv", lambda row: re.sub(r"^([^,]*),[^,]*,", r"\1,inf,", row))
        write("negative.csv", re.sub(r'"stiffness":[^,]*', '"stiffness":-5', text))
        write("slippery.csv", re.sub(r'"mu_static":[^,]*', '"mu_static":0.1', text))
        write_png("oblong.png", 8, 4, lambda x, y: 0)
        touch = ["touch", "--object", "sphere.sqmap", "--seconds", "0.1"]
        for arguments, words in ((["replay", "nan_time.csv"], f"nan_time.csv:{first + 6}: time must be finite"),
                                 (["replay", "back.csv"], f"back.csv:{first + 6}: time must be finite and not run back"),
                                 (["replay", "inf_dt.csv"], "dt finite"),
                                 (["replay", "input.csv"], f"input.csv:{first + 6}: input is 99: it must be 0 to 7"),
                                 (["replay", "negative.csv"], "the trace's setup: stiffness is -5: it must be 0 to 1e6"),
                                 (["replay", "slippery.csv"], "mu_static 0.1 is below mu_dynamic 0.3"),
                                 (["replay", "short.csv", "--plot", "x.png"], "--plot x.png: the picture is an SVG\n  cure: --plot x.svg"),
                                 ([*touch, "--record", "x.csv", "--plot", "x.png"], "cure: --plot x.svg"),
                                 ([*touch, "--mu-static", "0.1"], "--mu-static 0.1 is below --mu-dynamic 0.3"),
                                 ([*touch, "--tool", "sphere:1e9"], "first object's R_max"),
                                 ([*touch, "--texture", "velvet"], "--texture velvet: there is no such texture"),
                                 ([*touch, "--texture", "image:absent.png"], "--texture image:absent.png: cannot be read as PNG"),
                                 ([*touch, "--texture", "image:oblong.png"], "the image is 8 by 4 pixels, it must be square"),
                                 ([*touch, "--object-mass", "0.001"], "--object-mass must be 0 (fixed) or at least 0.01 kg"),
                                 (["replay", "no_trace.csv"], "no_trace.csv:1: not a trace"),
                                 (["replay", "no_setup.csv"], "has no setup"),
                                 (["replay", "bad_setup.csv"], "setup does not read"),
                                 (["replay", "bad_row.csv"], "column 1 (time) is no number: '0.01x'"),
                                 (["replay", "short.csv", "--against", "sphere.obj"], "sphere.obj"),
                                 (["touch", "--object", "absent.sqmap"], "absent.sqmap"),
                                 ([*touch, "--tool", "sphere:0"], "radius"),
                                 ([*touch, "--tool", "absent.obj"], "absent.obj"),
                                 ([*touch, "--device", "teleporter"], "no device of kind 'teleporter'"),
                                 ([*touch, "--device", "slide:speeed=1"], "no option 'speeed'"),
                                 ([*touch, "--device", "slide:speed=fast"], "speed must be a number"),
                                 ([*touch, "--device", "press:direction=0/0"], "three numbers"),
                                 ([*touch, "--device", "press:direction="], "three numbers"),
                                 ([*touch, "--device", "press:direction=0/0/0"], "direction=0/0/0 points nowhere"),
                                 ([*touch, "--device", "slide:travel=0/0/0"], "travel=0/0/0 points nowhere"),
                                 ([*touch, "--device", "press:0.01"], "takes NAME=VALUE only, found '0.01'"),
                                 ([*touch, "--device", "glove:open"], "takes NAME=VALUE only, found 'open'"),
                                 ([*touch, "--device", "press:depth="], "depth must be a number from -1 to 1, found ''"),
                                 ([*touch, "--device", "press:depth=0.01,"], "a comma too many"),
                                 ([*touch, "--device", "press:depth=-0.01,gap=0.005"], "depth=-0.01 lies above gap=0.005"),
                                 ([*touch, "--device", "press:radius=0.01"], "press has no option 'radius'"),
                                 ([*touch, "--device", "slide:rate=1"], "rate must be a number from 60 to 10000"),
                                 ([*touch, "--device", "slide:speed=100"], "speed must be a number from 1e-05 to 10"),
                                 ([*touch, "--device", "simulated:press,delay=1.5"], "delay must be a whole number from 0 to 8"),
                                 ([*touch, "--tool", "sphere:0.5"], "the first object's R_max"),
                                 ([*touch, "--tool", "sphere:5mm"], "cure: metres"),
                                 ([*touch, "--device", "path:absent.csv"], "absent.csv"),
                                 (["replay", "absent.csv"], "absent.csv"),
                                 ([*touch, "--device", "simulated:dance"], "dance"),
                                 ([*touch, "--device", "simulated", "--force-limit", "1000"],
                                  "--force-limit 1000 is more than the device holds: "),
                                 ([*touch, "--device", "simulated", "--torque-limit", "3"],
                                  "--torque-limit 3 is more than the device holds: "),
                                 ([*touch, "--record", "x.csv", "--plot", "absent/x.svg"], "there is no folder absent"),
                                 ([*touch, "--record", "no/folder/x.csv"], "no/folder/x.csv")):
            result = run(*arguments)
            self.assertEqual(result.returncode, 2, (arguments, result.stdout, result.stderr))
            self.assertIn(words, result.stderr, arguments)

    def test_wrong_usage_is_64(self):
        for arguments in (["touch"], ["replay"], ["devices", "all"],
                          ["touch", "--object", "sphere.sqmap", "--seconds", "0"],
                          ["touch", "--object", "sphere.sqmap", "--friction", "sticky"],
                          ["touch", "--object", "sphere.sqmap", "--layer", "1"],  # no number of an enumerator
                          ["touch", "--object", "sphere.sqmap", "--mode", "1"],
                          ["touch", "--object", "sphere.sqmap", "--stiffness", "-1"]):
            self.assertEqual(run(*arguments).returncode, 64, arguments)

    def test_the_list_of_devices_has_every_kind(self):
        result = run("devices", "--json")
        self.assertEqual(result.returncode, 0)
        devices = json.loads(result.stdout)
        kinds = {device["device"].split(":")[0] for device in devices}
        self.assertLessEqual({"press", "tap", "slide", "circle", "simulated", "glove", "path", "trace", "network", "sdl", "spacenav", "haply", "openhaptics", "forcedimension", "chai3d"}, kinds)
        for device in devices:
            self.assertIn(device["presence"], ("here", "absent", "not built"))
            self.assertNotEqual(device["state"], "")
        text = run("devices").stdout
        for device in devices:
            self.assertIn(device["state"], text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
