#!/usr/bin/env python3
"""Time against memory and against error, all methods: medians over the records that sqmap_bench frames wrote.

usage: pareto.py OUT.svg RECORDS.json...      (the same path kind in all of them)
"""
import json
import pathlib
import statistics
import sys

import plot

COLOURS = (("sqmap", plot.ORANGE), ("dense", plot.BLUE), ("fcl", plot.GREEN), ("embree", plot.VIOLET), ("bullet", plot.RED),
           ("", plot.GREY))
SHAPES = ("circle", "square", "diamond")


def medians(paths):
    """method -> field -> median over the files, where none is null."""
    records = {}
    for path in paths:
        with open(path, encoding="utf-8") as file:
            for record in json.load(file):
                records.setdefault(record["method"], []).append(record)
    fields = ("p50_us", "bytes", "depth_error_mean_pct")
    return {method: {field: statistics.median(r[field] for r in found) for field in fields
                     if all(r.get(field) is not None for r in found)} for method, found in records.items()}


def draw(out, paths):
    found = medians(paths)
    memory = plot.Chart("Time and memory", "kB kept for the object", "microseconds a frame (median)", x_log=True, y_log=True, height=460, width=560)
    error = plot.Chart("Time and error", "mean depth error, % of R_max", "microseconds a frame (median)", x_log=True, y_log=True, height=460, width=560)
    used = {}
    for method, m in found.items():
        family, colour = next((f, c) for f, c in COLOURS if method.startswith(f))
        used[family] = used.get(family, -1) + 1
        mark = {"shape": SHAPES[used[family] % len(SHAPES)], "hollow": used[family] >= len(SHAPES), "size": 5, "label": True}
        memory.dots(method, [(m["bytes"] / 1000, m["p50_us"])], colour, **mark)
        # An exact method has no place on a logarithmic axis of errors.
        if m.get("depth_error_mean_pct", 0) > 1e-6:
            error.dots(method, [(m["depth_error_mean_pct"], m["p50_us"])], colour, **mark)
    plot.save(pathlib.Path(out), memory, error)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    draw(sys.argv[1], sys.argv[2:])
