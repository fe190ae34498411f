#!/usr/bin/env python3
"""Tests what sqmap touch, replay and devices say: summaries, plots, warnings, and what is wrong with input and options.

usage: touch_words_test.py PROGRAM NETWORK_CLIENT
"""
import math
import os
import re
import unittest
import xml.dom.minidom

from touch_support import README, TouchTest, free_port, read, rows_of, run, write, write_png


class TouchWords(TouchTest):
    def test_the_commands_of_the_readme_do_what_it_says(self):
        commands = re.findall(r"^\$ sqmap ((?:touch|replay|rtcheck) .*)$", read(README), re.MULTILINE)
        self.assertEqual([c.split()[0] for c in commands], ["touch", "replay", "rtcheck"])
        for command in commands:
            result = run(*command.replace("torus.sqmap", "sphere.sqmap").split())
            self.assertEqual(result.returncode, 0, (command, result.stdout, result.stderr))
        self.assertIn("all bit-identical", run("replay", "touch.csv").stdout)
        self.assertGreater(max(math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows_of("touch.csv")), 0.1)
        xml.dom.minidom.parse("touch.svg")

    def test_the_readme_shows_what_a_bake_prints(self):
        command, shown = re.search(r"^\$ sqmap (bake torus\.obj .*)\n((?:[^$\n].*\n)+)", read(README), re.MULTILINE).groups()
        self.assertEqual(run("shapes", "torus", "-o", "torus.obj").returncode, 0)
        without_time = lambda text: re.sub(r"in \S+ s of CPU", "in s of CPU", text)
        self.assertEqual(without_time(run(*command.split()).stdout), without_time(shown))

    def test_a_layer_that_the_model_lacks_is_told(self):
        run("shapes", "sphere", "-o", "bare.obj")
        for options in (["--no-exact"], ["--projection", "normal", "--grid", "17x32"]):
            self.assertEqual(run("bake", "bare.obj", "-o", "bare.sqmap", *options).returncode, 0)
            done = run("touch", "--object", "bare.sqmap", "--layer", "exact", "--record", "bare.csv")
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn("bake it with --exact", done.stderr)
            self.assertFalse(os.path.exists("bare.csv"))
            self.assertEqual(run("touch", "--object", "bare.sqmap", "--device", "press:depth=0.01", "--seconds", "0.2",
                                 "--record", "auto.csv").returncode, 0)
            self.assertIn('"layer":"3"', read("auto.csv"))

    def test_units_and_scale(self):
        # The ball's radius is 1 mesh unit: a millimetre.
        self.record("unit.csv", "--unit", "mm", "--tool", "sphere:0.0001", device="press:depth=0.0001,gap=0.0002,speed=0.001")
        self.assertAlmostEqual(float(rows_of("unit.csv")[0]["z0_pz"]), 0.001 + 0.0001 + 0.0002, delta=2e-5)
        self.assertEqual(run("touch", "--object", "sphere.sqmap", "--unit", "mm", "--scale", "1").returncode, 64)

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

    def test_plots_are_svg(self):
        self.record("plotted.csv", "--plot", "plotted.svg")
        text = xml.dom.minidom.parse("plotted.svg").toxml()
        for words in ("deepest", "force, N", "torque", "CPU time", "time, s", "no hardware"):
            self.assertTrue(words in text, words)
        self.assertEqual(run("replay", "plotted.csv", "--plot", "again.svg").returncode, 0)
        self.assertTrue(read("plotted.svg") == read("again.svg"))
        self.assertEqual(run("touch", "--object", "sphere.sqmap", "--plot", "x.svg").returncode, 2)

    def test_what_cannot_be_recorded_is_said_before_a_device_is_opened(self):
        for name, words in (("no/such/folder.csv", "cannot write"), (".", "folder")):
            result = run("touch", "--object", "sphere.sqmap", "--device", f"network:port={free_port()},wait=1", "--record", name)
            self.assertEqual(result.returncode, 2)
            self.assertIn(words, result.stderr)
            self.assertNotIn("no client", result.stderr)

    def test_options_without_effect_are_said(self):
        for options in (["--k-f", "5"], ["--texture-depth", "0.001"], ["--mass", "0.1"], ["--proxy-depth", "0.001"],
                        ["--mode", "proxy", "--brake", "1"], ["--tool", "sphere", "--tool-touching", "9"], ["--tool", "sphere", "--edges"]):
            result = run("touch", "--object", "sphere.sqmap", "--seconds", "0.01", *options)
            self.assertTrue(any(f"warning: {option} counts with " in result.stderr for option in options), result.stderr)
        self.assertNotIn("counts with", run("touch", "--object", "sphere.sqmap", "--seconds", "0.01", "--mu-static", "0.5").stderr)

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


if __name__ == "__main__":
    unittest.main(verbosity=2)
