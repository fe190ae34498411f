#!/usr/bin/env python3
"""Measures haptic rendering on a folder of meshes and hand paths; writes the tables into docs/data/haptics.

usage: haptics.py [--meshes FOLDER] [--paths FOLDER] [--program FILE] [--only NAME,...] [--quick]
NAMEs: slide, ball, paper_slide, tick, paper_tick, density, points, points_tick, energy, paper, picture.
FOLDERs default to ../shared/meshes and ../shared/paths beside the repository. --quick: shapes that the program makes itself, few
places, no hand; tables and picture go to build/haptics/quick.
"""
import argparse
import csv
import math
import pathlib
import subprocess
import tempfile

import measure
import plot

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLES = ROOT / "docs/data/haptics"
PICTURE_MESH = "horse_5946.obj"
ANIMALS = {"bull_7154", "camel_4512", "cat_8108", "elephant_10272", "horse_5946"}
QUICK = ROOT / "build/haptics/quick"
QUICK_SHAPES = ("torus", "bent")
METHODS = (("mesh", "mesh: nearest triangle", plot.GREY), ("shaded", "force shading", plot.BLUE),
           ("unsmoothed", "the paper's map", plot.VIOLET), ("smoothed", "the paper's smoothed map", plot.RED),
           ("ours", "central model, stencil", plot.ORANGE))


def vector(row, name):
    return tuple(float(row[f"{name}_{axis}"]) for axis in "xyz")


def distance(a, b):
    return math.dist(a, b)


def window(rows, reach=80):
    """The ticks about the greatest step of the mesh's force on ground without sharp edges."""
    best, at = 0, 0
    for i in range(reach, len(rows) - reach):
        near = rows[i - reach:i + reach]
        if near[0]["way"] != near[-1]["way"] or any(r["sharp"] == "1" for r in near) or not any(map(float, vector(rows[i], "smoothed"))):
            continue
        step = distance(vector(rows[i], "mesh"), vector(rows[i - 1], "mesh"))
        if step > best:
            best, at = step, i
    return rows[at - reach:at + reach]


def picture(trace, out):
    with open(trace, encoding="utf-8") as file:
        rows = window(list(csv.DictReader(file)))
    figure, (turn, step) = plot.panels(("a. Direction of the force", "way, mm", "angle to its mean direction, degrees"),
                                       ("b. |F_i - F_(i-1)|, k = 500 N/m, 1 mm deep", "way, mm", "N"), width=4.1, height=3.4)
    # One plane for all: the mean direction, and the way that the mesh's force turns most.
    forces = [vector(r, "mesh") for r in rows]
    mean = [sum(f[k] for f in forces) for k in range(3)]
    size = math.hypot(*mean)
    mean = [m / size for m in mean]
    jump = max(range(1, len(rows)), key=lambda i: distance(forces[i], forces[i - 1]))
    side = [b - a for a, b in zip(forces[jump - 1], forces[jump])]
    along = sum(s * m for s, m in zip(side, mean))
    side = [s - along * m for s, m in zip(side, mean)]
    size = math.hypot(*side)
    side = [s / size for s in side]
    for name, words, colour in METHODS:
        f = [vector(r, name) for r in rows]
        angle = [math.degrees(math.atan2(sum(a * b for a, b in zip(v, side)), sum(a * b for a, b in zip(v, mean)))) for v in f]
        way = [0.1 * i for i in range(len(f))]
        turn.plot(way, angle, color=colour, label=words)
        step.plot(way[1:], [distance(a, b) for a, b in zip(f, f[1:])], color=colour, label=words)
    plot.save(out, figure)


def draw(program, mesh, out):
    with tempfile.TemporaryDirectory() as folder:
        trace = pathlib.Path(folder) / "trace.csv"
        subprocess.run([program, "haptic", "slide", "--paper", mesh, "--csv", trace], check=True, stdout=subprocess.DEVNULL)
        picture(trace, out)


def quick(program):
    """Every force on shapes of the program's own: that all of it runs."""
    QUICK.mkdir(parents=True, exist_ok=True)
    meshes = [QUICK / f"{shape}.obj" for shape in QUICK_SHAPES]
    for shape, mesh in zip(QUICK_SHAPES, meshes):
        measure.run("shapes", shape, "-o", mesh)
    for name, arguments in {"slide": ["slide", "--planes", "1", "--positions", "20"],
                            "paper_slide": ["slide", "--paper", "--planes", "1"], "energy": ["energy", "--positions", "5"],
                            "paper": ["energy", "--paper", "--positions", "5"]}.items():
        print(name, flush=True)
        found = subprocess.run([program, "haptic", *arguments, *map(str, meshes)], check=True, capture_output=True, text=True)
        (QUICK / f"{name}.txt").write_text(found.stdout, encoding="utf-8")
    draw(program, meshes[0], QUICK / "edges.svg")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meshes", type=pathlib.Path, default=ROOT.parent / "shared/meshes")
    parser.add_argument("--paths", type=pathlib.Path, default=ROOT.parent / "shared/paths")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/bin/sqmap_measure")
    parser.add_argument("--only", default="slide,ball,paper_slide,tick,paper_tick,density,points,points_tick,energy,paper,picture")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    if options.quick:
        quick(options.program)
        return
    meshes, paths = sorted(options.meshes.glob("*.obj")), sorted(options.paths.glob("*.csv"))
    hand = ["--meshes", options.meshes]
    runs = {
        "slide": ["slide", "--positions", "300", *meshes],
        "ball": ["slide", "--sphere", "--tolerance", "0.0003", "--planes", "2", "--positions", "100", *meshes],
        "paper_slide": ["slide", "--paper", *meshes],
        # The paper's scene: five animals and the hand.
        "tick": ["tick", "--passes", "5", *hand, *paths, "--by", *sorted(ANIMALS)],
        "paper_tick": ["tick", "--paper", "--passes", "5", *hand, *paths, "--by", *sorted(ANIMALS)],
        "density": ["density", *hand, *paths],
        "points": ["density", "--touching", "1200", *hand, *paths],
        "points_tick": ["tick", "--touching", "1200", "--passes", "5", *hand, *paths, "--by", *sorted(ANIMALS)],
        "energy": ["energy", "--positions", "200", *meshes],
        "paper": ["energy", "--paper", "--positions", "200", *meshes],
    }
    wanted = options.only.split(",")
    for name, arguments in runs.items():
        if name in wanted:
            print(name, flush=True)
            found = subprocess.run([options.program, "haptic", *map(str, arguments)], check=True, capture_output=True, text=True)
            (TABLES / f"{name}.txt").write_text(found.stdout.rstrip() + "\n", encoding="utf-8")
    if "picture" in wanted:
        draw(options.program, options.meshes / PICTURE_MESH, ROOT / "docs/images/haptic_edges.svg")


if __name__ == "__main__":
    main()
