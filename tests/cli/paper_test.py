#!/usr/bin/env python3
"""Tests what the paper describes, section by section, as a user reaches it: by commands on a paper model.

usage: paper_test.py PROGRAM
"""
import csv
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import unittest

import coarse

PROGRAM = os.path.abspath(sys.argv.pop(1))


def run(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=300)


def done(*arguments):
    result = run(*arguments)
    if result.returncode != 0:
        raise AssertionError(f"{arguments}: {result.stdout}{result.stderr}")
    return result


def rows_of(name):
    with open(name, newline="") as text:
        return list(csv.DictReader(line for line in text if not line.startswith("#")))


def setup_of(trace):
    with open(trace) as text:
        return json.loads(next(line for line in text if line.startswith("# setup ")).removeprefix("# setup "))


def triple(row, *names):
    return tuple(float(row[name]) for name in names)


def vertices_of(name):
    with open(name) as text:
        return [tuple(map(float, line.split()[1:4])) for line in text if line.startswith("v ")]


def parts_of(model):
    return json.loads(done("info", model, "--json").stdout)["parts"]


def query(model, points, *options):
    with open("points.csv", "w") as out:
        out.write("x,y,z\n" + "".join(f"{x:.9g},{y:.9g},{z:.9g}\n" for x, y, z in points))
    done("query", model, "points.csv", "-o", "answers.csv", *options)
    return rows_of("answers.csv")


def touching(rows):
    return {i for i, row in enumerate(rows) if row["contact"] == "1"}


class Paper(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        os.chdir(cls.folder.name)
        for shape in ("hand", "bent"):
            done("shapes", shape, "-o", f"{shape}.obj")
        coarse.write_dumbbell("dumbbell.obj")
        cls.bake("hand.sqmap", mesh="hand.obj")
        cls.bake("bent.sqmap")
        cls.points, cls.bent_points = (cls.points_about(vertices_of(f"{shape}.obj")) for shape in ("hand", "bent"))

    @staticmethod
    def points_about(vertices):
        """Points in the box, and within a hundredth of its side of the surface."""
        low, high = ([pick(v[k] for v in vertices) for k in range(3)] for pick in (min, max))
        generator = random.Random(7)
        points = [tuple(generator.uniform(low[k], high[k]) for k in range(3)) for _ in range(3000)]
        return points + [tuple(c + generator.uniform(-0.01, 0.01) * (high[0] - low[0]) for c in v) for v in generator.sample(vertices, 1500)]

    @classmethod
    def bake(cls, model, *options, mesh="bent.obj"):
        grid = () if "--grid" in options else ("--grid", "33x64")
        done("bake", mesh, "-o", model, "--projection", "normal", *grid, *options)

    def assert_within(self, few, many, words=""):
        self.assertEqual(len(few - many), 0, words)
        self.assertGreater(len(many), len(few), words)

    # --- Section 3: decomposition

    def test_boundary_strength_of_locales_makes_cuts_and_their_curvature_where_it_makes_none(self):
        def parts(strength, curvature, *options):
            self.bake("printed.sqmap", "--cuts", "printed", "--max-q2", "1", "--max-looseness", "1e6", "--grid", "17x32", "--subdivisions", "0",
                      "--printed-curvature", curvature, *strength, *options, mesh="dumbbell.obj")
            return len(parts_of("printed.sqmap"))

        none = ("--printed-strength", "1e6")
        uncut = parts(none, "1e6")
        self.assertGreater(parts((), "1e6"), uncut)
        curved = parts(none, "1")
        self.assertGreater(curved, uncut, "t_h")
        self.assertGreater(curved, parts(none, "1", "--hyperbolic-share", "1"), "k_h")

    # --- Section 4: preprocessing

    def test_spheres_bound_the_object_and_its_parts(self):
        info = json.loads(done("info", "hand.sqmap", "--json").stdout)
        spheres = [part["bounding_sphere"] for part in info["parts"]]
        for vertex in vertices_of("hand.obj"):
            p = [(c - o) / info["unit"] for c, o in zip(vertex, info["origin"])]
            self.assertTrue(any(math.dist(p, s[:3]) <= s[3] * 1.0001 for s in spheres))

    def test_the_grid_of_eq_8_is_the_users(self):
        self.bake("coarse.sqmap", "--grid", "17x32")
        grids = lambda model: {(part["map"]["rows"], part["map"]["columns"]) for part in parts_of(model)}
        self.assertEqual((grids("bent.sqmap"), grids("coarse.sqmap")), ({(33, 64)}, {(17, 32)}))
        refused = run("bake", "hand.obj", "-o", "no.sqmap", "--projection", "normal", "--grid", "2x2")
        self.assertEqual(refused.returncode, 64)
        self.assertIn("--grid", refused.stderr)

    def test_the_offset_of_eq_12_moves_the_surface_out(self):
        self.bake("moved.sqmap", "--offset-constant", "100", "--offset-radius", "8")
        plain, moved = (touching(query("moved.sqmap", self.bent_points, *o)) for o in ((), ("--offset",)))
        self.assert_within(plain, moved)
        self.bake("level.sqmap", "--offset-constant", "0")
        self.assertTrue(query("level.sqmap", self.bent_points, "--offset") == query("level.sqmap", self.bent_points))

    def test_what_changes_nothing_or_is_out_of_range_is_told_by_its_option(self):
        for wrong in (("--salient-window", "nan"), ("--hyperbolic-share", "2"), ("--minimum-part", "-1"), ("--max-looseness", "0.5"),
                      ("--max-q2", "2"), ("--smoothing-kernel", "box"), ("--printed-strength", "2"),
                      ("--boundary-strength", "0.3", "--cuts", "printed"), ("--protrusion-sources", "9", "--exact-geodesics"),
                      ("--smoothing-kernel", "box", "--projection", "normal"),
                      ("--smoothing-length", "0.02", "--projection", "normal", "--smoothing-radius", "0"),
                      ("--grid", "4097x8192", "--projection", "normal", "--subdivisions", "1"),
                      ("--smoothing-radius", "4", "--smoothing", "distances", "--grid", "9x16", "--projection", "normal"), ("--no-locator", "--exact")):
            refused = run("bake", "hand.obj", "-o", "no.sqmap", *wrong)
            self.assertEqual(refused.returncode, 64, wrong)
            self.assertIn(wrong[0], refused.stderr)
        self.assertFalse(os.path.exists("no.sqmap"))

    def test_a_model_says_what_it_was_baked_with(self):
        self.bake("said.sqmap", "--smoothing-radius", "0", "--grid", "17x32", "--subdivisions", "2")
        info = json.loads(done("info", "said.sqmap", "--json").stdout)
        self.assertEqual(set(info["options"].split()),
                         {"--projection=normal", "--smoothing-radius=0", "--grid=17x32", "--subdivisions=2"})
        self.assertEqual({json.dumps(part["map"]) for part in info["parts"]},
                         {json.dumps({"rows": 17, "columns": 32, "subdivisions": 2, "smoothed": False})})
        self.assertIn("layer 2 17 x 32 samples, layer 3 65 x 128 (A_S 2), no smoothed map", done("info", "said.sqmap").stdout)
        query("said.sqmap", self.bent_points)
        refused = run("query", "said.sqmap", "points.csv", "-o", "no.csv", "--smooth")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--smoothing-radius", refused.stderr)
        told = done("touch", "--object", "said.sqmap", "--device", "press", "--seconds", "0.1", "--force", "paper")
        self.assertIn("unsmoothed", told.stdout + told.stderr)

    def test_central_maps_answer_alone(self):
        done("bake", "bent.obj", "-o", "charts.sqmap", "--no-locator")
        info = json.loads(done("info", "charts.sqmap", "--json").stdout)
        self.assertEqual((info["bytes"]["locator"], info["bytes"]["exact_mesh"]), (0, 0))
        measured = json.loads(done("eval", "charts.sqmap", "bent.obj", "--layer", "3", "--points", "4000", "--json").stdout)["layer"]["3"]
        self.assertEqual(measured["missed"] + measured["false_contacts"], 0)
        self.assertLess(measured["depth_percent"]["p99"], 0.5)

    def test_eq_35_of_layer_2_is_that_of_the_sample_it_reads(self):
        layers = json.loads(done("eval", "hand.sqmap", "hand.obj", "--points", "4000", "--json").stdout)["layer"]
        self.assertGreater(layers["2"]["eq35_percent"]["mean"], 2 * layers["3"]["eq35_percent"]["mean"])

    # --- Section 4.2: layers

    def test_the_gate_opens_layer_3_where_k_l_says_so(self):
        two, three = (query("hand.sqmap", self.points, "--layer", layer) for layer in ("2", "3"))
        self.assertFalse(two == three)
        self.assertTrue(query("hand.sqmap", self.points, "--layer", "gate", "--gate", "0") == two)
        self.assertTrue(query("hand.sqmap", self.points, "--layer", "gate", "--gate", "4000000000") == three)

    def test_every_layer_takes_contacts_away_from_the_one_before(self):
        one, two, three = (touching(query("hand.sqmap", self.points, "--layer", layer)) for layer in ("1", "2", "3"))
        self.assert_within(two, one)
        self.assert_within(three, one)
        # Layer 1 claims points between superquadric and surface; they move freely.
        self.assertGreater(len(one - two), 20)
        self.assertLess(len(two ^ three), len(one ^ three))

    def test_the_search_of_eqs_15_to_19_finds_feet_as_printed_and_corrected(self):
        newton, pyramid, printed = (query("hand.sqmap", self.points, "--layer", "2", "--projector", p)
                                    for p in ("newton", "pyramid", "printed"))
        whole = touching(newton)
        self.assertLess(len(touching(pyramid) ^ whole), 0.02 * len(whole))
        self.assertLess(len(touching(printed) ^ whole), 0.25 * len(whole))
        depth = lambda rows: sum(abs(float(r["depth"]) - float(n["depth"])) for r, n in zip(rows, newton) if r["contact"] == n["contact"] == "1")
        self.assertLess(depth(pyramid), depth(printed))

    def test_the_printed_searchs_range_follows_the_grid_by_eqs_17_and_18(self):
        # One level of eq. 18 at 33 x 64, three at 129 x 256: with one level there too, feet would be lost.
        self.bake("fine.sqmap", "--grid", "129x256", "--subdivisions", "0")
        for model in ("bent.sqmap", "fine.sqmap"):
            found = {p: touching(query(model, self.bent_points, "--layer", "2", "--projector", p)) for p in ("newton", "pyramid", "printed")}
            whole = found["newton"]
            self.assertLess(len(found["pyramid"] ^ whole), 0.02 * len(whole), model)
            self.assertLess(len(found["printed"] ^ whole), 0.25 * len(whole), model)

    def test_what_the_paper_lacks_can_be_left_out(self):
        three = query("hand.sqmap", self.points)
        claimed = touching(query("hand.sqmap", self.points, "--no-pruning"))
        self.assert_within(touching(three), claimed)
        self.assertEqual(len(touching(three) - touching(query("hand.sqmap", self.points, "--no-gaps"))), 0)
        # Steps lead to nearer surfaces, and find one where the foot's line shows none.
        line = query("hand.sqmap", self.points, "--nearest-steps", "0")
        self.assertTrue(touching(line) == touching(three))
        depths = [(float(a["depth"]), float(b["depth"])) for a, b in zip(three, line) if a["contact"] == "1"]
        self.assertLess(sum(near for near, far in depths if far > 0), sum(far for _, far in depths))
        self.assertLess(sum(near == 0 for near, _ in depths), sum(far == 0 for _, far in depths))
        done("bake", "bent.obj", "-o", "central.sqmap", "--no-exact")
        for option in (("--no-pruning",), ("--no-gaps",), ("--nearest-steps", "1")):
            refused = run("query", "central.sqmap", "points.csv", "-o", "no.csv", *option)
            self.assertEqual(refused.returncode, 2)
            self.assertIn(option[0], refused.stderr)

    def test_options_of_queries_and_pictures_that_change_nothing_are_told_with_their_cure(self):
        self.bake("both.sqmap", "--exact")
        for wrong, cure in ((("--nearest-steps", "1", "--layer", "2"), "layer 3"), (("--no-gaps", "--layer", "exact"), "layers 2 and 3"),
                            (("--nearest-steps", "1", "--projector", "printed"), "--projector to newton"),
                            (("--gate", "5", "--layer", "3"), "--layer to gate"), (("--gate", "-5"), "from 0 to")):
            refused = run("query", "both.sqmap", "points.csv", "-o", "no.csv", *wrong)
            self.assertIn(refused.returncode, (2, 64), wrong)
            self.assertIn(wrong[0], refused.stderr)
            self.assertIn(cure, refused.stderr)
            if wrong[0] != "--gate" or wrong[1] != "-5":
                layer = () if "--layer" in wrong else ("--layer", "3")
                touched = done("touch", "--object", "both.sqmap", "--seconds", "0.01", *wrong, *layer)
                self.assertIn(f"{wrong[0]} ", touched.stdout + touched.stderr)
                self.assertIn(cure, touched.stdout + touched.stderr)
        for wrong in (("--what", "strength", "--boundary-strength", "0.5"), ("--what", "parts", "--locale-width", "0.1")):
            refused = run("render", "both.sqmap", "-o", "no.png", *wrong)
            self.assertEqual(refused.returncode, 64)
            self.assertIn(wrong[0 if wrong[1] == "parts" else 2], refused.stderr)

    def test_nearest_steps_count_for_the_papers_force(self):
        felt = [[triple(row, "z0_fx", "z0_fy", "z0_fz") for row in self.touch("steps.csv", "--nearest-steps", n)] for n in ("0", "2")]
        self.assertNotEqual(felt[0], felt[1])

    def test_the_exact_layer_searches_no_foot(self):
        self.bake("both.sqmap", "--exact")
        query("both.sqmap", self.bent_points, "--layer", "exact")
        refused = run("query", "both.sqmap", "points.csv", "-o", "no.csv", "--layer", "exact", "--projector", "printed")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--projector", refused.stderr)

    # --- Section 6: forces

    def test_the_point_of_eq_22_is_on_the_surface(self):
        known = [row for row in query("hand.sqmap", self.points) if row["contact"] == "1" and float(row["depth"]) > 0]
        surface = [triple(row, "px", "py", "pz") for row in known]
        normals = [triple(row, "nx", "ny", "nz") for row in known]
        at = lambda h: [tuple(c + h * n for c, n in zip(p, q)) for p, q in zip(surface, normals)]
        outside, inside = (len(touching(query("hand.sqmap", at(h)))) for h in (0.01, -0.01))
        self.assertLess(outside, 0.05 * len(known))
        self.assertGreater(inside, 0.95 * len(known))

    def touch(self, trace, *options, device="slide", model="hand.sqmap"):
        tool = () if "--tool" in options else ("--tool", "point")
        done("touch", "--object", model, "--device", device, "--seconds", "1", "--force", "paper", "--friction", "none", "--record",
             trace, *tool, *options)
        return rows_of(trace)

    def test_the_force_is_eqs_21_26_and_32_on_the_smoothed_map(self):
        rows = [row for row in self.touch("force.csv", "--stiffness", "300") if row["contacts"] == "1"]
        self.assertGreater(len(rows), 100)
        per_unit = setup_of("force.csv")["objects"][0]["metres_per_unit"]
        origin = json.loads(done("info", "hand.sqmap", "--json").stdout)["origin"]  # is where the object stands
        points = [tuple(o + c / per_unit for o, c in zip(origin, triple(row, "z0_px", "z0_py", "z0_pz"))) for row in rows]
        answers = query("hand.sqmap", points, "--smooth")
        for row, answer in zip(rows, answers):
            size = 300 * per_unit * float(answer["depth"] or 0)
            force = triple(row, "z0_fx", "z0_fy", "z0_fz")
            expected = [size * n for n in triple(answer, "nx", "ny", "nz")] if size > 0 else (0, 0, 0)
            self.assertLess(math.dist(force, expected), 2e-3 + 0.01 * size)

    def test_a_doubtful_model_is_named_on_every_layer_of_its_maps(self):
        self.bake("doubtful.sqmap", "--grid", "5x8", "--subdivisions", "0", "--max-parts", "1", mesh="hand.obj")
        self.assertIn("W_LAYER3", done("info", "doubtful.sqmap").stdout)
        for layer in ("auto", "2", "3", "gate"):
            told = done("touch", "--object", "doubtful.sqmap", "--device", "press", "--seconds", "0.3", "--force", "paper", "--layer", layer)
            self.assertIn("W_LAYER3", told.stdout + told.stderr, layer)

    def test_smoothing_the_map_smooths_the_force(self):
        # Section 6: how far the force turns, from tick to tick of a slide.
        def turns(model):
            felt = [triple(row, "z0_fx", "z0_fy", "z0_fz") for row in self.touch("slide.csv", model=model) if row["contacts"] == "1"]
            unit = [tuple(c / math.hypot(*f) for c in f) for f in felt]
            return sum(math.dist(a, b) for a, b in zip(unit, unit[1:]))
        self.bake("rough.sqmap", "--smoothing-radius", "0", "--grid", "17x32", "--subdivisions", "2",
                  mesh="hand.obj")
        self.bake("smooth.sqmap", "--smoothing", "distances", "--smoothing-radius", "2", "--smoothing-kernel", "gaussian", "--grid", "17x32", "--subdivisions", "2",
                  mesh="hand.obj")
        self.assertLess(turns("smooth.sqmap"), 0.95 * turns("rough.sqmap"))

    def test_an_impact_zone_averages_and_every_tick_is_timed(self):
        # Section 6.1 and Fig. 14a: the mean over a small sphere, whatever the number of its points that touch.
        rows = self.touch("ball.csv", "--tool", "sphere:0.005", "--plot", "ball.svg", device="press:depth=0.002")
        deepest = max(float(row["depth"]) for row in rows)
        for row in rows:
            self.assertLessEqual(math.hypot(*triple(row, "z0_fx", "z0_fy", "z0_fz")), 500 * 1.5 * deepest + 1e-6)
            self.assertGreater(float(row["cpu"]), 0)
        self.assertGreater(max(int(row["contacts"]) for row in rows), 1)
        self.assertIn("ticks, all bit-identical", done("replay", "ball.csv").stdout)
        self.assertTrue(os.path.getsize("ball.svg") > 1000)

    # --- One model, one projection: whole commands

    def test_pictures_of_the_maps_are_drawn(self):
        done("render", "hand.sqmap", "hand.obj", "--what", "map,superquadrics", "--size", "200x160", "-o", "map.png")
        self.assertGreater(os.path.getsize("map.png"), 500)


if __name__ == "__main__":
    unittest.main(verbosity=2)
