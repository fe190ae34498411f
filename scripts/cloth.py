#!/usr/bin/env python3
"""Fig. 11b repeated: a skirt and a shirt on a figure, blankets on a bull and on a human figure of CGAL's data, and every method on
the same frames; and a skirt on that human figure as it walks, skinned to the project's skeleton. Writes build/cloth/fig11b.json and .csv, docs/images/cloth/fig11b.svg, and pictures of the garments.
usage: cloth.py [--vertices 10000] [--quick: 1500 vertices, the project's own figure alone]
"""
import argparse
import csv
import json
import pathlib
import subprocess

import demo_meshes
import measure
import plot
import rig

OUT = measure.ROOT / "build" / "cloth"
IMAGES = measure.ROOT / "docs" / "images" / "cloth"
GARMENTS = measure.ROOT / "examples" / "garments"
HEIGHT = {"bull": 1.36, "homer": 1.80}  # metres

# Row of the record -> the chart's words, colour, marker, hollow.
METHODS = [
    ("paper's maps, layer 1", "paper's maps, layer 1: superquadrics", plot.BLUE, "o", False),
    ("paper's maps, layer 2", "paper's maps, layer 2", plot.ORANGE, "o", False),
    ("paper's maps, layer 3", "paper's maps, layer 3", plot.RED, "o", False),
    ("sqmap, layer 3", "central model, layer 3", plot.RED, "s", True),
    ("sqmap, exact layer", "central model, exact layer", plot.VIOLET, "s", True),
    ("dense field", "dense field", plot.GREEN, "D", False),
]
TREE = "OBB tree with refit, all pairs"


def metres(name):
    """The mesh standing on y = 0, as tall as HEIGHT says."""
    lines = [l for l in (demo_meshes.MESHES / f"{name}.off").read_text().split("\n") if l.strip() and not l.startswith("#")]
    counts = list(map(int, lines[1].split()))
    points = [list(map(float, l.split()[:3])) for l in lines[2:2 + counts[0]]]
    low = min(p[1] for p in points)
    scale = HEIGHT[name] / (max(p[1] for p in points) - low)
    target = OUT / f"{name}.off"
    with target.open("w") as out:
        out.write(f"OFF\n{counts[0]} {counts[1]} 0\n")
        for x, y, z in points:
            out.write(f"{scale * x!r} {scale * (y - low)!r} {scale * z!r}\n")
        out.write("\n".join(lines[2 + counts[0]:2 + counts[0] + counts[1]]) + "\n")
    return target


def short(case):
    """"skirt, walking" or "bull, at rest": the words that tell cases apart."""
    garment, _, place = case["name"].partition(" on ")
    body, _, state = pathlib.PurePath(place).name.rpartition(", ")
    return f"{garment if body.endswith('figure') else body.replace('.off', '')}, {state}"


def draw(cases):
    figure, (axes,) = plot.panels(("Fig. 11b: cloth against an avatar", "", f"% of the {TREE}"), width=8, height=4.8)
    for method, words, colour, marker, hollow in METHODS:
        share = [100 * c["methods"][method]["us_median"] / c["methods"][TREE]["us_median"] for c in cases]
        axes.semilogy([short(c) for c in cases], share, label=words, **plot.marks(colour, marker, hollow))
    axes.margins(x=0.5 / len(cases))
    plot.save(IMAGES / "fig11b.svg", figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vertices", type=int, default=10000)
    parser.add_argument("--quick", action="store_true")
    args = parser.parse_args()
    for folder in (OUT, IMAGES):
        folder.mkdir(parents=True, exist_ok=True)
    meshes = []
    if not args.quick:
        demo_meshes.fetch(tuple(HEIGHT))
        meshes = [metres(name) for name in HEIGHT if (demo_meshes.MESHES / f"{name}.off").exists()]
    record = OUT / "fig11b.json"
    program = measure.ROOT / "build" / "release" / "bin" / "sqmap_measure"
    subprocess.run([program, "cloth", record, str(1500 if args.quick else args.vertices), *meshes], check=True)
    cases = json.loads(record.read_text())["cases"]
    with (OUT / "fig11b.csv").open("w", newline="") as out:
        rows = csv.writer(out)
        rows.writerow(("case", "vertices", "method", "us_median", "us_p99", "found"))
        for case in cases:
            for method, m in case["methods"].items():
                rows.writerow((short(case), case["vertices"], method, m["us_median"], m["us_p99"], m["found"]))
    if not args.quick:
        draw(cases)
    for garment in ("skirt", "poncho", "shirt"):
        pictures = OUT / garment
        pictures.mkdir(exist_ok=True)
        measure.run("dress", "--figure", "1.75", "--walk", "--garment", GARMENTS / f"{garment}.json", "--seconds", "3.3", "--fps", "2",
                    "--thinnest", "0.04", "--pictures", pictures, "-o", OUT / f"{garment}.glb", "--report", OUT / f"{garment}.json")
        last = sorted(pictures.glob("*.png"))[-1]
        if garment == "shirt" and not args.quick:
            (IMAGES / "shirt.png").write_bytes(last.read_bytes())
    if (OUT / "homer.off").exists():
        rig.rig(OUT / "homer.off", OUT / "homer_skinned.glb")
        worn = {"pattern": "skirt", "fabric": "cotton", "centre": [0, 0.84, -0.055], "waist_radius": 0.25, "length": 0.42,
                "vertices": 1500 if args.quick else args.vertices, "waist_bone": "chest"}
        (OUT / "homer_skirt.json").write_text(json.dumps(worn))
        pictures = OUT / "homer"
        pictures.mkdir(exist_ok=True)
        measure.run("dress", "--avatar", OUT / "homer_skinned.glb", "--walk", "--garment", OUT / "homer_skirt.json", "--seconds", "4", "--fps",
                    "4", "--pictures", pictures, "-o", OUT / "homer.glb", "--report", OUT / "homer.json")
        if not args.quick:
            (IMAGES / "homer.png").write_bytes(sorted(pictures.glob("*.png"))[-1].read_bytes())
    print(f"numbers in {OUT}, animations beside them")


if __name__ == "__main__":
    main()
