#!/usr/bin/env python3
"""sqmap touch, replay and devices end to end: recordings that replay to the bit, and what is said when something is wrong.

usage: touch_test.py PROGRAM NETWORK_CLIENT
"""
import csv
import json
import math
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import xml.dom.minidom

CLIENT = os.path.abspath(sys.argv.pop(2))
PROGRAM = os.path.abspath(sys.argv.pop(1))


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

    def test_every_mode_tool_and_friction_replays_to_the_bit(self):
        for options in (["--tool", "point"], ["--tool", "point:0.002", "--shading", "consistent"], ["--tool", "torus.obj", "--tool-size", "0.05"],
                        ["--tool", "torus.obj", "--tool-size", "0.05", "--tool-spacing", "0.002"],
                        ["--mode", "proxy"], ["--mode", "coupled"], ["--friction", "none"], ["--friction", "paper"], ["--layer", "exact"],
                        ["--layer", "2", "--damping", "2", "--brake", "1", "--zone", "0.02"]):
            self.record("mode.csv", *options)
            result = run("replay", "mode.csv")
            self.assertEqual(result.returncode, 0, (options, result.stdout, result.stderr))
            self.assertIn("1000 ticks, all bit-identical", result.stdout)
            felt = [math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows_of("mode.csv")]
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
        result = run("replay", "ball.csv", "--against", "torus.sqmap")
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
        felt = [max(math.hypot(*(float(row[f"z{zone}_f{axis}"]) for axis in "xyz")) for row in rows) for zone in range(6)]
        self.assertGreater(sum(force > 0.01 for force in felt), 1, felt)
        self.assertIn("bit-identical", run("replay", "glove.csv").stdout)

    def test_plots_are_svg(self):
        self.record("plotted.csv", "--plot", "plotted.svg")
        text = xml.dom.minidom.parse("plotted.svg").toxml()
        for words in ("deepest", "force, N", "torque", "CPU time", "time, s", "no hardware"):
            self.assertTrue(words in text, words)
        self.assertEqual(run("replay", "plotted.csv", "--plot", "again.svg").returncode, 0)
        self.assertTrue(read("plotted.svg") == read("again.svg"))
        self.assertEqual(run("touch", "--object", "sphere.sqmap", "--plot", "x.svg").returncode, 2)

    def test_an_interrupt_ends_a_recording_and_a_kill_leaves_what_was_written(self):
        command = [PROGRAM, "touch", "--object", "sphere.sqmap", "--device", "simulated:slide", "--seconds", "120"]
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
            client = subprocess.run([sys.executable, CLIENT, "--port", port, "--seconds", "3", "--to", "0.155"], capture_output=True,
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
            # What the last poses were answered with is nothing: the client had gone.
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

    def test_wrong_input_is_2_and_says_what(self):
        write("no_trace.csv", "x,y,z\n1,2,3\n")
        self.record("short.csv", seconds="0.05")
        text = read("short.csv")
        write("no_setup.csv", "".join(line + "\n" for line in text.split("\n")[:-1] if not line.startswith("# setup")))
        write("bad_setup.csv", re.sub(r"# setup .*", "# setup {\"objects\":7}", text))
        write("bad_row.csv", text.replace("\n0.01,", "\n0.01x,"))
        touch = ["touch", "--object", "sphere.sqmap", "--seconds", "0.1"]
        for arguments, words in ((["replay", "no_trace.csv"], "no_trace.csv:1: not a trace"),
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
                                 ([*touch, "--device", "path:absent.csv"], "absent.csv"),
                                 ([*touch, "--device", "simulated:dance"], "dance"),
                                 ([*touch, "--force-limit", "1000"], "more than the device"),
                                 ([*touch, "--record", "no/folder/x.csv"], "no/folder/x.csv")):
            result = run(*arguments)
            self.assertEqual(result.returncode, 2, (arguments, result.stdout, result.stderr))
            self.assertIn(words, result.stderr, arguments)

    def test_wrong_usage_is_64(self):
        for arguments in (["touch"], ["replay"], ["replay", "absent.csv"], ["devices", "all"],
                          ["touch", "--object", "sphere.sqmap", "--seconds", "0"],
                          ["touch", "--object", "sphere.sqmap", "--friction", "sticky"],
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
