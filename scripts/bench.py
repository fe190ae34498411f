#!/usr/bin/env python3
"""Races sqmap and its peers along every path of a folder, prints tables of the medians, and draws time against memory and error.

usage: bench.py [FOLDER] [--kinds light,deep,near] [options of sqmap_bench frames]

FOLDER holds meshes/ and paths/ (OBJECT.PROBE.KIND.csv); default: SQMAP_SHARED_DIR, or ../shared. Kinds of paths that it lacks
are made. Without meshes there the project's own shapes are used: a hand that slides over a bent body, a dumb-bell and a rounded box.
Records go to build/bench, one file a path; tables to build/bench/tables.md, a chart of each kind to build/bench/pareto.KIND.svg.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys

import plot

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = ROOT / "build" / "release" / "bin"
OUT = ROOT / "build" / "bench"
SHAPES = ("bent", "dumbbell", "rounded_box")  # a hand can slide over these at every depth
COLOURS = (("sqmap", plot.ORANGE), ("dense", plot.BLUE), ("fcl", plot.GREEN), ("embree", plot.VIOLET), ("bullet", plot.RED),
           ("", plot.GREY))
MARKERS = ("o", "s", "D")


def run(program, *arguments, **options):
    done = subprocess.run([BIN / program, *map(str, arguments)], text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{program} {' '.join(map(str, arguments))}: exit code {done.returncode}")
    return done.stdout


def mesh_of(folder, name):
    found = sorted(folder.glob(name + ".*"))
    if not found:
        sys.exit(f"{folder}: no mesh {name}")
    return found[0]


def cases(folder, kinds):
    """(name, object, probe, path) of every race."""
    meshes, paths = folder / "meshes", OUT / "paths"
    paths.mkdir(parents=True, exist_ok=True)
    given = [p for p in sorted((folder / "paths").glob("*.*.*.csv"))] if (folder / "paths").is_dir() else []
    if given:
        pairs = sorted({tuple(p.name.split(".")[:2]) for p in given})
    else:
        meshes = OUT / "meshes"
        meshes.mkdir(parents=True, exist_ok=True)
        for shape in (*SHAPES, "hand"):
            run("sqmap", "shapes", shape, "-o", meshes / f"{shape}.obj", stdout=subprocess.DEVNULL)
        pairs = [(shape, "hand") for shape in SHAPES]
    for kind in kinds:
        for one, other in pairs:
            obj, probe = mesh_of(meshes, one), mesh_of(meshes, other)
            name = f"{one}.{other}.{kind}"
            path = folder / "paths" / f"{name}.csv"
            if path not in given:
                path = paths / f"{name}.csv"
                run("sqmap_bench", "path", "--object", obj, "--probe", probe, "--kind", kind, "-o", path, "--cache", OUT / "cache")
            yield name, obj, probe, path


def medians(paths):
    """method -> field -> median over the records of files, where none is null."""
    records = {}
    for path in paths:
        for record in json.loads(path.read_text(encoding="utf-8")):
            records.setdefault(record["method"], []).append(record)
    fields = ("p50_us", "bytes", "depth_error_mean_pct")
    return {method: {field: statistics.median(r[field] for r in found) for field in fields
                     if all(r.get(field) is not None for r in found)} for method, found in records.items()}


def name_points(axes, points):
    """Writes the name of each (x, y, name, colour) beside its point, moved down past the names above."""
    axes.figure.canvas.draw()  # lays out the panels
    placed = []
    for x, y, name, colour in sorted(points, key=lambda p: -p[1]):
        right, top = (v * 72 / axes.figure.dpi for v in axes.transData.transform((x, y)))
        edge = axes.bbox.x1 * 72 / axes.figure.dpi
        begin = right + 8 if right + 8 + 4.6 * len(name) < edge else right - 8 - 4.6 * len(name)
        at = top
        for other_begin, other_end, other in sorted(placed, key=lambda p: -p[2]):
            if begin < other_end and other_begin < begin + 4.6 * len(name) and abs(at - other) < 8.5:
                at = other - 8.5
        placed.append((begin, begin + 4.6 * len(name), at))
        axes.annotate(name, (x, y), (begin - right, at - top), textcoords="offset points", fontsize=7.5, va="center",
                      arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.6, "shrinkA": 0, "shrinkB": 3})


def draw(path, records):
    figure, (memory, error) = plot.panels(("Time and memory", "kB kept for the object", "microseconds a frame (median)"),
                                          ("Time and error", "mean depth error, % of R_max", "microseconds a frame (median)"),
                                          width=5.6, height=4.6)
    used, named = {}, {memory: [], error: []}
    for method, m in medians(records).items():
        family, colour = next((f, c) for f, c in COLOURS if method.startswith(f))
        used[family] = used.get(family, -1) + 1
        marks = plot.marks(colour, MARKERS[used[family] % len(MARKERS)], used[family] >= len(MARKERS))
        named[memory].append((m["bytes"] / 1000, m["p50_us"], method, colour, marks))
        # An exact method has no position on a logarithmic axis of errors.
        if m.get("depth_error_mean_pct", 0) > 1e-6:
            named[error].append((m["depth_error_mean_pct"], m["p50_us"], method, colour, marks))
    for axes, points in named.items():
        for x, y, _, _, marks in points:
            axes.loglog(x, y, **marks)
    for axes, points in named.items():
        name_points(axes, [p[:4] for p in points])
    plot.save(path, figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    default = os.environ.get("SQMAP_SHARED_DIR", ROOT.parent / "shared")
    # Only in front: behind the program's own options it would take one of their values.
    given = sys.argv[1:]
    named = bool(given) and not given[0].startswith("-")
    folder = pathlib.Path(given.pop(0) if named else default)
    if named and not (folder / "meshes").is_dir():
        sys.exit(f"{folder}: no folder meshes/ in it\n  cure: name a folder that holds meshes/ and paths/, or none")
    parser.add_argument("--kinds", default="light,deep,near")
    arguments, options = parser.parse_known_args(given)
    written, kinds = [], arguments.kinds.split(",")
    for name, obj, probe, path in cases(folder, kinds):
        written.append(OUT / f"{name}.json")
        print(f"\n{name}", flush=True)
        run("sqmap_bench", "frames", "--object", obj, "--probe", probe, "--path", path, "--cache", OUT / "cache",
            "--json", written[-1], *options)
    tables = run("sqmap_bench", "table", *written, stdout=subprocess.PIPE)
    (OUT / "tables.md").write_text(tables)
    print("\n" + tables)
    for kind in kinds:
        draw(OUT / f"pareto.{kind}.svg", [path for path in written if path.suffixes[-2] == f".{kind}"])


if __name__ == "__main__":
    main()
