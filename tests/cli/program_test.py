#!/usr/bin/env python3
"""The program end to end: shapes, bake, info, query, and what it says when something is wrong.

usage: program_test.py PROGRAM
"""
import csv
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import unittest

import coarse

PROGRAM = os.path.abspath(sys.argv.pop(1))
HEADER = ["contact", "part", "depth", "nx", "ny", "nz", "px", "py", "pz"]
DISTANCE_HEADER = ["distance", "known", "part", "gx", "gy", "gz", "px", "py", "pz"]


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=120)


class Made(unittest.TestCase):
    """A folder with a baked sphere, and its queries."""
    levels = 3

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        coarse.write_sphere("sphere.obj", cls.levels)
        baked = run("bake", "sphere.obj", "-o", "sphere.sqmap", "--report", "report.json")
        assert baked.returncode == 0, baked.stderr

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    def query(self, rows, *options, model="sphere.sqmap", header="x,y,z\n"):
        with open("points.csv", "w") as out:
            out.write(header + "".join(",".join(repr(v) if isinstance(v, float) else str(v) for v in row) + "\n" for row in rows))
        if os.path.exists("answers.csv"):
            os.remove("answers.csv")
        return run("query", model, "points.csv", "-o", "answers.csv", *options)

    def answers(self):
        with open("answers.csv", newline="") as text:
            return list(csv.reader(text))

    def distances(self, rows, *options, model="sphere.sqmap"):
        result = self.query(rows, "--distance", *options, model=model)
        self.assertEqual(result.returncode, 0, result.stderr)
        answers = self.answers()
        self.assertEqual(answers[0], DISTANCE_HEADER)
        self.assertEqual(len(answers), len(rows) + 1)
        return answers[1:]


class Program(Made):
    def test_version(self):
        result = run("--version")
        self.assertEqual(result.returncode, 0)
        self.assertRegex(result.stdout, r"^sqmap \d+\.\d+\.\d+")

    def test_help_is_in_words_of_the_user(self):
        overview = run("--help").stdout
        commands = re.findall(r"^  ([a-z]+)  ", overview.split("Subcommands:")[1], re.M)
        self.assertIn("bake", commands)
        for command in commands:
            result = run(command, "--help")
            self.assertEqual(result.returncode, 0, command)
            self.assertTrue(result.stdout.split("\n")[1].startswith(f"Usage: sqmap {command}"), result.stdout)
            self.assertIn("Exit code: 0 ", result.stdout, command)
            for term in ("->", "value in", "UINT", "FLOAT", "POSITIVE", "REQUIRED REQUIRED", "{"):
                self.assertNotIn(term, result.stdout, command)

    def test_numbers_out_of_range_are_named_in_a_line(self):
        for value in ("-1", "0", "nan", "inf", "1e999", "wide"):
            result = run("bake", "sphere.obj", "-o", "x.sqmap", "--target-error", value)
            self.assertEqual(result.returncode, 64, value)
            self.assertIn(f"--target-error: must be a number from 0.001 to 100, not '{value}'\n", result.stderr)
        result = run("touch", "--object", "sphere.sqmap", "--tool", "sphere", "--mu-static", "-1")
        self.assertEqual(result.returncode, 64)
        self.assertIn("--mu-static: must be a number not below zero, not '-1'", result.stderr)
        result = run("touch", "--object", "sphere.sqmap", "--stiffness", "1e308")
        self.assertEqual(result.returncode, 64)
        self.assertIn("--stiffness: is at most 1e+06, not 1e308", result.stderr)

    def test_wrong_usage_is_64(self):
        for arguments in ([], ["fly"], ["bake"], ["bake", "sphere.obj"], ["bake", "absent.obj", "-o", "a.sqmap"],
                          ["bake", "sphere.obj", "-o", "a.sqmap", "--max-parts", "0"],
                          ["bake", "sphere.obj", "-o", "a.sqmap", "--target-error", "-1"],
                          ["bake", "sphere.obj", "-o", "a.sqmap", "--projection", "oblique"],
                          ["query", "sphere.sqmap", "sphere.obj", "-o", "a.csv", "--layer", "4"]):
            result = run(*arguments)
            self.assertEqual(result.returncode, 64, arguments)
            self.assertNotEqual(result.stderr, "", arguments)
        self.assertFalse(os.path.exists("a.sqmap"))

    def test_what_is_no_model_is_refused(self):
        with open("sphere.sqmap", "rb") as good:
            data = good.read()
        for name, content in (("half", data[: len(data) // 2]), ("more", data + b"x"), ("flip", data[:-100] + bytes([data[-100] ^ 1]) + data[-99:]),
                              ("text", b"x,y,z\n"), ("empty", b"")):
            with open(name + ".sqmap", "wb") as out:
                out.write(content)
            self.assertEqual(run("info", name + ".sqmap").returncode, 2, name)
            self.assertEqual(self.query([(0, 0, 0)], model=name + ".sqmap").returncode, 2, name)
            self.assertFalse(os.path.exists("answers.csv"))

    def test_a_refused_mesh_leaves_no_file(self):
        with open("open.obj", "w") as out:
            out.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n")
        with open("broken.obj", "w") as out:
            out.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
        for name in ("open.obj", "broken.obj"):
            before = set(os.listdir())
            result = run("bake", name, "-o", "refused.sqmap", "--repair", "safe")
            self.assertEqual(result.returncode, 2)
            self.assertRegex(result.stderr, r"E_[A-Z]+")
            self.assertEqual(set(os.listdir()), before)

    def test_an_unwritable_place_is_said_so(self):
        result = run("bake", "sphere.obj", "-o", "no/such/folder/a.sqmap")
        self.assertEqual(result.returncode, 2)
        self.assertIn("there is no folder no/such/folder", result.stderr)  # said before the bake
        self.assertEqual(self.query([(0, 0, 0)], "-o", "no/such/a.csv").returncode in (2, 64), True)

    def test_what_is_read_is_never_written_over(self):
        with open("asked.csv", "w") as out:
            out.write("x,y,z\n0,0,0\n")
        kept = {name: pathlib.Path(name).read_bytes() for name in ("sphere.obj", "sphere.sqmap", "asked.csv")}
        for arguments in (("bake", "sphere.obj", "-o", "sphere.obj"), ("bake", "sphere.obj", "-o", "x.sqmap", "--report", "sphere.obj"),
                          ("query", "sphere.sqmap", "asked.csv", "-o", "asked.csv"),
                          ("query", "sphere.sqmap", "asked.csv", "-o", "./sphere.sqmap"),
                          ("render", "sphere.sqmap", "--what", "parts", "-o", "sphere.sqmap")):
            result = run(*arguments)
            self.assertEqual(result.returncode, 2, arguments)
            self.assertIn("another name", result.stderr)
        for name, bytes_ in kept.items():
            self.assertEqual(pathlib.Path(name).read_bytes(), bytes_, name)
        self.assertFalse(os.path.exists("x.sqmap"))

    def test_standard_output_is_written_on_and_not_replaced(self):
        with open("asked.csv", "w") as out:
            out.write("x,y,z\n0,0,0\n")
        with open("log", "w") as out:
            out.write("kept\n")
        with open("log", "a") as out:
            subprocess.run([PROGRAM, "query", "sphere.sqmap", "asked.csv", "-o", "/dev/stdout"], stdout=out, timeout=60, check=True)
        lines = pathlib.Path("log").read_text().splitlines()
        self.assertEqual(lines[0], "kept")
        self.assertTrue(lines[2].startswith("1,"), lines)
        piped = run("query", "sphere.sqmap", "asked.csv", "-o", "/dev/stdout")
        self.assertEqual(piped.stdout.splitlines(), lines[1:])

    def test_a_file_size_limit_leaves_nothing_behind(self):
        before = set(os.listdir())
        limited = subprocess.run([PROGRAM, "bake", "sphere.obj", "-o", "limited.sqmap"], capture_output=True, text=True, timeout=120,
                                 preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))
        self.assertEqual(limited.returncode, 2, limited.stderr)
        self.assertIn("limited.sqmap", limited.stderr)
        self.assertEqual(set(os.listdir()), before)

    def test_info_json(self):
        result = run("info", "sphere.sqmap", "--json")
        self.assertEqual(result.returncode, 0)
        info = json.loads(result.stdout)
        self.assertEqual(info["bytes"]["total"], os.path.getsize("sphere.sqmap"))
        self.assertEqual(info["source"], "sphere.obj")
        self.assertTrue(info["solid"])
        self.assertAlmostEqual(info["r_max"], 2, delta=0.01)
        self.assertEqual(len(info["parts"]), 1)
        for part in info["parts"]:
            for name in ("a1", "a2", "a3", "eps1", "eps2", "phi", "theta", "chi", "tx", "ty", "tz", "Kx", "Ky", "k", "alpha"):
                self.assertIsInstance(part[name], (int, float), name)
            self.assertTrue(part["certificate"]["bounding"])
            self.assertLessEqual(part["certificate"]["largest_f"], 1)
            self.assertGreaterEqual(part["mesh_units"]["a"][0], 0.98)
        self.assertIn("measured", info)

    def test_bounds_of_a_part_and_of_the_whole(self):
        info = json.loads(run("info", "sphere.sqmap", "--json").stdout)
        with open("report.json") as text:
            report = json.load(text)
        with open("sphere.obj") as text:
            vertices = [[float(x) for x in line.split()[1:4]] for line in text if line.startswith("v ")]
        for bounds in (info["bounds"], info["parts"][0]["bounds"], report["bounds"], report["parts"][0]["bounds"]):
            self.assertAlmostEqual(bounds["solid_volume"], 4.18, delta=0.05)
            for bound in ("superquadric", "polytope", "both"):
                self.assertGreater(bounds[bound]["volume_ratio"], 0.99, bound)
                self.assertAlmostEqual(bounds[bound]["volume"] / bounds["solid_volume"], bounds[bound]["volume_ratio"], delta=1e-9)
                self.assertAlmostEqual(100 * bounds[bound]["support_excess"] / info["r_max"], bounds[bound]["support_excess_percent"], delta=1e-9)
            self.assertLess(bounds["superquadric"]["volume_ratio"], 1.05)
            self.assertLess(bounds["both"]["volume_ratio"], bounds["polytope"]["volume_ratio"])
        sides = info["parts"][0]["polytope"]
        self.assertGreater(len(sides), 10)
        for x, y, z, offset in sides:  # in mesh units, up to the rounding of JSON's reader
            for v in vertices:
                self.assertLessEqual(x * v[0] + y * v[1] + z * v[2], offset + 1e-9)
        printed = run("info", "sphere.sqmap").stdout
        self.assertIn("bounds: superquadric, polytope, both", printed)
        self.assertRegex(printed, r"\n +0 +[01]\.\d+ +1\.\d+ +[01]\.\d+ .*20 sides\n whole")
        self.assertNotIn("hold more than", printed)

    def test_loose_parts_are_named(self):
        run("shapes", "hand", "-o", "hand.obj")
        self.assertEqual(run("bake", "hand.obj", "-o", "one.sqmap", "--max-parts", "1").returncode, 0)
        printed = run("info", "one.sqmap").stdout
        ratio = json.loads(run("info", "--json", "one.sqmap").stdout)["parts"][0]["bounds"]["superquadric"]["volume_ratio"]
        self.assertGreater(ratio, 2.5)
        self.assertIn(f"superquadrics that hold more than 2.5 times their part's solid: 0 ({ratio:.2f}); with their polytopes", printed)

    def test_labels_of_polygons_in_the_files_order(self):
        run("shapes", "torus", "-o", "torus.obj")
        self.assertEqual(run("bake", "torus.obj", "-o", "torus.sqmap").returncode, 0)
        with open("torus.obj") as text:
            lines = text.read().splitlines()
        face = next(i for i, line in enumerate(lines) if line.startswith("f "))
        first = lines[face].split()[1]
        with open("torus_and_more.obj", "w") as out:  # a face without area, which is dropped
            out.write("\n".join(lines[:face] + [f"f {first} {first} {first}"] + lines[face:]) + "\n")
        result = run("export", "torus.sqmap", "--labels", "--mesh", "torus_and_more.obj", "-o", "labels.csv")
        self.assertEqual(result.returncode, 0, result.stderr)
        with open("labels.csv") as text:
            labels = [int(line) for line in text]
        self.assertEqual(len(labels), 1 + sum(line.startswith("f ") for line in lines))
        self.assertEqual(labels[0], -1)
        names = {part["group"] for part in json.loads(run("info", "torus.sqmap", "--json").stdout)["parts"]}
        self.assertEqual(set(labels[1:]), names)
        self.assertEqual(names, set(range(len(names))))
        another = run("export", "torus.sqmap", "--labels", "--mesh", "sphere.obj", "-o", "none.csv")
        self.assertEqual(another.returncode, 2)
        self.assertIn("was not baked from sphere.obj", another.stderr)
        self.assertFalse(os.path.exists("none.csv"))
        self.assertEqual(run("export", "torus.sqmap", "--labels", "-o", "none.csv").returncode, 64)

    def test_the_report_of_a_bake(self):
        with open("report.json") as text:
            report = json.load(text)
        self.assertEqual(len(report["parts"]), 1)
        self.assertIn("cpu_seconds", report)

    def test_the_same_mesh_gives_the_same_bytes(self):
        self.assertEqual(run("bake", "sphere.obj", "-o", "again.sqmap", "--threads", "1").returncode, 0)
        with open("sphere.sqmap", "rb") as first, open("again.sqmap", "rb") as second:
            self.assertEqual(first.read(), second.read())

    def test_without_the_exact_layer(self):
        self.assertEqual(run("bake", "sphere.obj", "-o", "lean.sqmap", "--no-exact").returncode, 0)
        self.assertLess(os.path.getsize("lean.sqmap"), os.path.getsize("sphere.sqmap"))
        self.assertEqual(self.query([(0.0, 0.0, 0.0)], "--layer", "3", model="lean.sqmap").returncode, 0)
        refused = self.query([(0.0, 0.0, 0.0)], "--layer", "exact", model="lean.sqmap")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("without the exact layer", refused.stderr)

    def test_eval_measures_the_mesh_it_was_baked_from(self):
        result = run("eval", "sphere.sqmap", "sphere.obj", "--points", "2000", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        exact = json.loads(result.stdout)["layer"]["exact"]
        self.assertIsInstance(exact, dict)
        run("shapes", "torus", "-o", "torus.obj")
        self.assertEqual(run("eval", "sphere.sqmap", "torus.obj").returncode, 2)

    def test_eval_refuses_another_mesh_of_the_same_size(self):
        with open("sphere.obj") as text:
            lines = text.read().split("\n")
        corner = next(i for i, line in enumerate(lines) if line.startswith("v "))
        x, y, z = map(float, lines[corner].split()[1:])
        lines[corner] = f"v {x * 1.001!r} {y * 1.001!r} {z * 1.001!r}"
        with open("dented.obj", "w") as out:
            out.write("\n".join(lines))
        self.assertEqual(run("check", "dented.obj").returncode, 0)
        result = run("eval", "sphere.sqmap", "dented.obj", "--points", "100")
        self.assertEqual(result.returncode, 2)
        for name in ("sphere.sqmap", "dented.obj", "sphere.obj"):
            self.assertIn(name, result.stderr)
        # The same faces in another order are the same mesh.
        faces = [line for line in lines if line.startswith("f ")]
        with open("sphere.obj") as text:
            rest = [line for line in text.read().split("\n") if not line.startswith("f ")]
        with open("turned.obj", "w") as out:
            out.write("\n".join(rest + faces[::-1]) + "\n")
        self.assertEqual(run("eval", "sphere.sqmap", "turned.obj", "--points", "100").returncode, 0)


class Queries(Made):
    levels = 4  # its answers are within 0.003 of those of a smooth sphere

    def test_a_row_for_every_row_in_the_same_order(self):
        # On a line through the sphere: the depth tells which point a row answers.
        rows = [(0.001 * i, 0.0, 0.0) for i in range(0, 1500, 7)]
        for layer in ("1", "2", "3", "exact", "auto"):
            self.assertEqual(self.query(rows, "--layer", layer).returncode, 0, layer)
            answers = self.answers()
            self.assertEqual(answers[0], HEADER)
            self.assertEqual(len(answers), len(rows) + 1)
            for (x, _, _), row in zip(rows, answers[1:]):
                self.assertEqual(len(row), 9)
                if abs(x - 1) < 0.15:
                    continue  # the mesh lies within the sphere, layer 1 around it
                self.assertEqual(row[0], "1" if x < 1 else "0", (layer, x))
                if row[0] == "1":
                    # About the centre a cell of the locator sees the whole sphere, and layer 2 has one plane for it.
                    central = layer == "2" and x < 0.15
                    self.assertAlmostEqual(float(row[2]), 1 - x, delta={"1": 0.1, "2": 0.025 if central else 0.01}.get(layer, 0.01))
                    self.assertAlmostEqual(math.hypot(*map(float, row[3:6])), 1, delta=1e-5)
                    if x > 0.05 and not central:
                        self.assertGreater(float(row[3]), 0.95, "the normal points outward")
                        self.assertAlmostEqual(float(row[6]), 1, delta=0.15)
                else:
                    self.assertEqual(row[1:], ["-1"] + [""] * 7, "a free row is empty")

    def test_nine_digits(self):
        self.assertEqual(self.query([(0.31, 0.17, 0.23)], "--layer", "exact").returncode, 0)
        digits = [len(re.sub(r"^0+", "", re.sub(r"[-.]|e.*", "", v))) for v in self.answers()[1][2:]]
        self.assertLessEqual(max(digits), 9)
        self.assertGreaterEqual(max(digits), 8)

    def test_far_from_the_origin_points_keep_nine_digits_of_the_size(self):
        away = (1e8, -2e8, 3e8)
        for name, move in (("near.obj", (0, 0, 0)), ("far.obj", away)):
            with open(name, "w") as out:
                for corner in range(8):
                    out.write("v %r %r %r\n" % tuple(float(m + (corner >> k & 1)) for k, m in enumerate(move)))
                for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)):
                    out.write(f"f {a + 1} {b + 1} {c + 1} {d + 1}\n")
            result = run("bake", name, "-o", name + ".sqmap")
            self.assertEqual(result.returncode, 0, result.stderr)
        point = (0.375, 0.5, 0.9375)  # exact at either place
        self.assertEqual(self.query([point], "--layer", "exact", model="near.obj.sqmap").returncode, 0)
        near = [float(v) for v in self.answers()[1]]
        self.assertEqual(self.query([tuple(p + m for p, m in zip(point, away))], "--layer", "exact", model="far.obj.sqmap").returncode, 0)
        far = [float(v) for v in self.answers()[1]]
        self.assertAlmostEqual(near[2], 0.0625, delta=1e-6)
        for a, b in zip(near[:6], far[:6]):
            self.assertAlmostEqual(a, b, delta=1e-6)
        for a, b, m in zip(near[6:], far[6:], away):
            self.assertAlmostEqual(a, b - m, delta=2e-7)

    def test_certain_is_a_last_column(self):
        rows = [(0.0, 0.0, 0.0), (0.9, 0.0, 0.1), (5.0, 5.0, 5.0)]
        self.assertEqual(self.query(rows, "--layer", "exact", "--certain").returncode, 0)
        answers = self.answers()
        self.assertEqual(answers[0], HEADER + ["certain"])
        self.assertEqual([row[9] for row in answers[1:]], ["1", "1", "1"])
        self.assertEqual([row[0] for row in answers[1:]], ["1", "1", "0"])

    def test_status_is_a_last_column(self):
        self.assertEqual(self.query([(0.0, 0.0, 0.0), ("nan", 0.0, 0.0)], "--layer", "exact", "--certain", "--status").returncode, 0)
        answers = self.answers()
        self.assertEqual(answers[0], HEADER + ["certain", "status"])
        self.assertEqual(answers[1][10], "0")
        self.assertNotEqual(answers[2][10], "0")

    def test_no_rows_give_the_header_alone(self):
        self.assertEqual(self.query([]).returncode, 0)
        self.assertEqual(self.answers(), [HEADER])

    def test_far_and_odd_numbers_are_free(self):
        self.assertEqual(self.query([("1e300", 0, 0), ("nan", 0, 0), (0, "inf", 0), ("1e-300", 0, 0)]).returncode, 0)
        self.assertEqual([row[0] for row in self.answers()[1:]], ["0", "0", "0", "1"])

    def test_bad_points_name_the_line(self):
        for bad, line in (("1,2\n", 3), ("1,2,3,4\n", 3), ("a,b,c\n", 3), ("\n0,0,0\n", 3), ("1;2;3\n", 3)):
            with open("bad.csv", "w") as out:
                out.write("x,y,z\n0,0,0\n" + bad)
            result = run("query", "sphere.sqmap", "bad.csv", "-o", "bad_out.csv")
            self.assertEqual(result.returncode, 2, bad)
            self.assertIn(f"bad.csv:{line}:", result.stderr)
            self.assertFalse(os.path.exists("bad_out.csv"))
        self.assertEqual(self.query([(0, 0, 0)], header="a,b,c\n").returncode, 2)
        self.assertEqual(self.query([], header="").returncode, 2)

    def test_windows_line_ends_are_read(self):
        with open("crlf.csv", "w", newline="") as out:
            out.write("x,y,z\r\n0,0,0\r\n9, 9, 9\r\n")
        self.assertEqual(run("query", "sphere.sqmap", "crlf.csv", "-o", "answers.csv").returncode, 0)
        self.assertEqual([row[0] for row in self.answers()[1:]], ["1", "0"])

    def test_a_byte_order_mark_and_blank_lines_around_are_passed_over(self):
        for text in ("\ufeffx,y,z\n0,0,0\n9,9,9\n", "\n \nx,y,z\n0,0,0\n9,9,9\n", "\ufeff\r\nx,y,z\r\n0,0,0\r\n9,9,9\r\n\r\n\n"):
            with open("marked.csv", "w", newline="", encoding="utf-8") as out:
                out.write(text)
            result = run("query", "sphere.sqmap", "marked.csv", "-o", "answers.csv")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual([row[0] for row in self.answers()[1:]], ["1", "0"])

    def test_distances_on_both_sides(self):
        rows = [(0.0, 0.6 * s, 0.8 * s) for s in (0.91, 0.96, 0.999, 1.001, 1.05, 1.099)]
        for s, row in zip((0.91, 0.96, 0.999, 1.001, 1.05, 1.099), self.distances(rows)):
            # The mesh lies within the sphere.
            self.assertEqual(row[1], "exact")
            self.assertAlmostEqual(float(row[0]), s - 1, delta=0.003)
            self.assertEqual(float(row[0]) < 0, s < 0.9995, s)
            if abs(s - 1) > 0.01:
                self.assertAlmostEqual(math.hypot(*map(float, row[3:6])), 1, delta=1e-6)
                for k in range(3):
                    self.assertAlmostEqual(float(row[3 + k]), (0, 0.6, 0.8)[k], delta=0.1)
                    self.assertAlmostEqual(float(row[6 + k]), (0, 0.6, 0.8)[k], delta=0.1)
            self.assertEqual(row[2], "0")

    def test_distances_beyond_the_band_are_bounds(self):
        far = ((0, 0, 0, -1), (2, 0, 0, 1), (0, -30, 0, 29), ("1e300", 0, 0, 1e300))
        for (_, _, _, truth), row in zip(far, self.distances([p[:3] for p in far])):
            self.assertEqual(row[1:], ["bound", "-1"] + [""] * 6)
            self.assertEqual(float(row[0]) < 0, truth < 0)
            self.assertLessEqual(abs(float(row[0])), abs(truth) + 1e-9)
            self.assertGreaterEqual(abs(float(row[0])), 0.499 * abs(truth))
        for row in self.distances([("nan", 0, 0), (0, "inf", 0)]):
            self.assertEqual(row, ["", "none", "-1"] + [""] * 6)

    def test_the_band_of_a_query_and_of_a_bake(self):
        rows = [(1.25, 0.0, 0.0), (0.0, 2.5, 0.0)]
        self.assertEqual(self.distances(rows)[1][1], "bound")
        for row, s in zip(self.distances(rows, "--band", "2"), (1.25, 2.5)):
            self.assertEqual(row[1], "exact")
            self.assertAlmostEqual(float(row[0]), s - 1, delta=0.003)
        self.assertEqual(run("bake", "sphere.obj", "-o", "wide.sqmap", "--band", "30").returncode, 0)
        self.assertEqual([row[1] for row in self.distances(rows, model="wide.sqmap")], ["exact", "bound"])
        for band in ("-1", "101", "nan", "wide"):
            result = run("bake", "sphere.obj", "-o", "refused.sqmap", "--band", band)
            self.assertEqual(result.returncode, 64, band)
            self.assertIn("--band: must be a number from 0 to 100", result.stderr)
        self.assertFalse(os.path.exists("refused.sqmap"))

    def test_options_that_distances_do_not_take_are_refused(self):
        for options in (("--band", "-1"), ("--band", "nan"), ("--layer", "exact"), ("--certain",), ("--offset",), ("--smooth",),
                        ("--gate", "3"), ("--tolerance", "1")):
            self.assertEqual(self.query([(0, 0, 0)], "--distance", *options).returncode, 64, options)
            self.assertFalse(os.path.exists("answers.csv"))
        self.assertEqual(self.query([(0, 0, 0)], "--band", "1").returncode, 64, "a band is of distances")

    def test_distances_of_a_surface_are_never_negative(self):
        with open("open.obj", "w") as out:
            out.write("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0.5\nf 1 2 3\nf 1 3 4\nf 2 5 3\n")
        for options, kind, error in (((), "exact", 1e-6), (("--no-exact",), "approximate", 0.05)):
            result = run("bake", "open.obj", "--surface", "-o", "open.sqmap", *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            rows = [(0.3, 0.4, 0.02 * i) for i in (-2, -1, 0, 1, 2)] + [(0.3, 0.4, -7.0), (0.3, 0.4, 7.0)]
            for (_, _, z), row in zip(rows, self.distances(rows, model="open.sqmap")):
                self.assertGreaterEqual(float(row[0]), 0)
                if abs(z) > 1:
                    self.assertEqual(row[1], "bound")
                    self.assertTrue(3.499 <= float(row[0]) <= 7)
                else:
                    self.assertEqual(row[1], kind)
                    self.assertAlmostEqual(float(row[0]), abs(z), delta=error)

    def test_distances_without_the_exact_layer_are_approximate(self):
        self.assertEqual(run("bake", "sphere.obj", "-o", "lean.sqmap", "--no-exact").returncode, 0)
        for s, row in zip((0.95, 1.05), self.distances([(0.95, 0, 0), (1.05, 0, 0)], model="lean.sqmap")):
            self.assertEqual(row[1], "approximate")
            self.assertAlmostEqual(float(row[0]), s - 1, delta=0.01)


if __name__ == "__main__":
    unittest.main(verbosity=1)
