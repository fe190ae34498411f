#!/usr/bin/env python3
"""sqmap touch and its devices end to end: simulated, recorded, another program, and what is said when one goes.

usage: touch_device_test.py PROGRAM NETWORK_CLIENT
"""
import contextlib
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
import time
import unittest

from touch_support import CLIENT, PROGRAM, TouchTest, free_port, read, rows_of, run, write


class TouchDevice(TouchTest):
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
            # The last poses got no answer: the client had gone, which is recorded tick by tick.
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

    def test_dampers_near_the_devices_own_are_scaled(self):
        result = self.record("damped.csv", "--damping", "5", device="simulated:press", seconds="0.3")
        self.assertIn("--damping 5 and --brake 0 are scaled by 0.1", result.stdout)
        self.assertIn('"damping":0.5', read("damped.csv"))

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
