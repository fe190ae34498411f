#!/usr/bin/env python3
"""sqmap touch and replay end to end: what is felt, and recordings that replay to the bit.

usage: touch_test.py PROGRAM NETWORK_CLIENT
"""
import csv
import json
import math
import os
import re
import signal
import subprocess
import unittest

from touch_support import PROGRAM, TouchTest, read, rows_of, run, wait_for, write, write_hand, write_png


class Touch(TouchTest):
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

    def test_every_mode_tool_and_friction_replays_to_the_bit(self):
        write_png("grey.png", 16, 16, lambda x, y: 16 * x)
        for options in (["--tool", "point"], ["--tool", "point:0.002", "--shading", "consistent"], ["--tool", "torus.obj", "--tool-size", "0.05"],
                        ["--tool", "torus.obj", "--tool-size", "0.05", "--tool-spacing", "0.002"],
                        ["--tool", "torus.obj", "--tool-size", "0.05", "--tool-touching", "0"],
                        ["--tool", "torus.obj", "--tool-size", "0.05", "--edges"],
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

    def test_a_proxy_that_is_pushed_is_a_touch(self):
        result = self.record("proxy.csv", "--tool", "point", "--mode", "proxy", device="press:depth=0.004", seconds="2")
        self.assertNotIn("nothing was touched", result.stderr)
        self.assertGreater(int(re.search(r"(\d+) in contact", result.stdout)[1]), 500)
        self.assertAlmostEqual(float(re.search(r"deepest (\S+) m", result.stdout)[1]), 0.004, delta=3e-4)

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
        # The run does not write over what is left of the killed one.
        result = run(*command[1:], "--record", "SIGKILL.csv")
        self.assertEqual(result.returncode, 2)
        self.assertIn("SIGKILL.csv.recording", result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
