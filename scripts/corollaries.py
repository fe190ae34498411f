#!/usr/bin/env python3
"""Corollaries 1 and 2 of the paper's section 5: error against density, of a shape whose projection is injective and of one with Q2.
Both are the project's own shapes, each in one superquadric. `./dev reproduce` calls it; alone:

usage: corollaries.py"""
import json
import pathlib

import measure
import plot

ROOT = pathlib.Path(__file__).resolve().parent.parent
GRIDS = ("9x16", "17x32", "33x64", "65x128", "129x256", "257x512", "513x1024")
SHAPES = (("dumbbell", "dumbbell: injective", plot.BLUE, "o"), ("hand", "hand: Q2", plot.RED, "s"))
AS_ONE_PART = ("--projection", "normal", "--max-parts", "1", "--max-looseness", "1000000", "--max-q2", "1", "--subdivisions", "0",
               "--smoothing-radius", "0", "--no-exact")


def errors_of(shape, grids, out):
    """(samples, share of Q2, mean, 99th percentile of the depth's error) a grid; percent of the area and of R_max."""
    mesh, model = out / f"corollary.{shape}.obj", out / f"corollary.{shape}.sqmap"
    measure.run("shapes", shape, "-o", mesh)
    rows = []
    for grid in grids:
        measure.run("bake", mesh, "-o", model, "--grid", grid, *AS_ONE_PART)
        q2 = json.loads(measure.run("info", model, "--json"))["measured"]["q2_percent"]
        depth = json.loads(measure.run("eval", model, mesh, "--layer", "3", "--json"))["layer"]["3"]["depth_percent"]
        lines, columns = map(int, grid.split("x"))
        rows.append((lines * columns, q2, depth["mean"], depth["p99"]))
    return rows


def draw(out, images, table, grids=GRIDS):
    """Measures both shapes; writes the picture and, where a file is given, the table."""
    figure, (means, tails) = plot.panels(("Mean", "samples of the map", "error of the depth, % of R_max"),
                                         ("99th percentile", "samples of the map", ""), width=5.6, height=3.4)
    lines = [f"{'shape':10} {'grid':>9} {'Q2, %':>7} {'mean, %':>9} {'p99, %':>9}"]
    for shape, words, colour, marker in SHAPES:
        rows = errors_of(shape, grids, out)
        for axis, value in ((means, 2), (tails, 3)):
            axis.plot([r[0] for r in rows], [r[value] for r in rows], color=colour, marker=marker, label=words)
        lines += [f"{shape:10} {grid:>9} {q2:7.2f} {mean:9.4f} {p99:9.4f}" for grid, (_, q2, mean, p99) in zip(grids, rows)]
    for axis in (means, tails):
        axis.set(xscale="log", yscale="log")
    plot.save(images / "corollaries.svg", figure)
    if table is not None:
        table.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    out = ROOT / "build" / "reproduce"
    out.mkdir(parents=True, exist_ok=True)
    draw(out, ROOT / "docs" / "images" / "reproduction", ROOT / "docs" / "data" / "reproduction" / "corollaries.txt")


if __name__ == "__main__":
    main()
