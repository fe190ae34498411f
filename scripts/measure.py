#!/usr/bin/env python3
"""Measures meshes with the sqmap program and writes the table of docs/measurements.md.

usage: measure.py [FOLDER...] [-o docs/measurements.md]     default folder: the meshes that the demo fetched

Every mesh of the folders is checked; those that are closed are baked at default options on one thread and measured by
`sqmap eval` against the exact oracle: layer 3 and the exact layer.
"""
import argparse
import datetime
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "build" / "release" / "bin" / "sqmap"
MESH_ENDINGS = {".off", ".obj", ".stl", ".ply", ".gltf", ".glb"}


def run(*arguments):
    """Output of a sqmap command; stops with its own words where it fails."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"sqmap {' '.join(map(str, arguments))}\n{done.stdout}{done.stderr}")
    return done.stdout


def check(mesh):
    """Answer of `sqmap check --json`, refusals included."""
    return json.loads(subprocess.run([PROGRAM, "check", mesh, "--json"], capture_output=True, text=True).stdout)


def measure(mesh, folder, *bake_options):
    """Bakes a mesh into folder and measures it. Everything the tables need, as one dictionary."""
    model = folder / (mesh.stem + ".sqmap")
    report = folder / (mesh.stem + ".bake.json")
    run("bake", mesh, "-o", model, "--report", report, *bake_options)
    baked = json.loads(report.read_text())
    return {
        "name": mesh.stem,
        "model": model,
        "check": check(mesh),
        "seconds": sum(baked["cpu_seconds"].values()),
        "target_met": baked["target_met"],
        "info": json.loads(run("info", model, "--json")),
        "eval": json.loads(run("eval", model, mesh, "--json")),
    }


def shape_of(columns, rows):
    """Rows of values -> lines of a Markdown table; columns: (title, value of a row)."""
    lines = ["| " + " | ".join(title for title, _ in columns) + " |", "|---|" + "---:|" * (len(columns) - 1)]
    lines += ["| " + " | ".join(str(value(row)) for _, value in columns) + " |" for row in rows]
    return lines


def layer(row, name):
    return row["eval"]["layer"][name]


COLUMNS = [
    ("mesh", lambda r: r["name"]),
    ("triangles", lambda r: r["info"]["triangles"]),
    ("parts", lambda r: len(r["info"]["parts"])),
    ("kB", lambda r: f'{r["info"]["bytes"]["total"] / 1000:.0f}'),
    ("kB w/o exact", lambda r: f'{r["info"]["bytes"]["without_exact"] / 1000:.0f}'),
    ("bake s", lambda r: f'{r["seconds"]:.1f}'),
    ("contained", lambda r: f'{r["eval"]["containment"]["certified_parts"]}/{r["eval"]["containment"]["parts"]}'
                            f', {r["eval"]["containment"]["triangles_outside"]} out'),
    ("L1 missed", lambda r: layer(r, "3")["layer1_missed"]),
    ("L3 missed + false", lambda r: f'{layer(r, "3")["missed"]} + {layer(r, "3")["false_contacts"]}'),
    ("certain wrong", lambda r: layer(r, "3")["certain_wrong"] + layer(r, "exact")["certain_wrong"]),
    ("eq. 35 mean", lambda r: f'{layer(r, "3")["eq35_percent"]["mean"]:.4f}'),
    ("eq. 35 p99", lambda r: f'{layer(r, "3")["eq35_percent"]["p99"]:.3f}'),
    ("left out %", lambda r: f'{layer(r, "3")["eq35_left_out_percent"]:.2f}'),
    ("L3 depth median", lambda r: f'{layer(r, "3")["depth_percent"]["median"]:.4f}'),
    ("L3 depth p95", lambda r: f'{layer(r, "3")["depth_percent"]["p95"]:.3f}'),
    ("L3 depth p99", lambda r: f'{layer(r, "3")["depth_percent"]["p99"]:.3f}'),
    ("normal median", lambda r: f'{layer(r, "3")["normal_degrees"]["median"]:.2f}'),
    ("exact missed + false", lambda r: f'{layer(r, "exact")["missed"]} + {layer(r, "exact")["false_contacts"]}'),
]

# Target, and what a row must satisfy for it. Targets by kind of mesh are judged at their strict value for every row.
TARGETS = [
    ("every triangle held by a superquadric, certified",
     lambda r: r["eval"]["containment"]["certified_parts"] == r["eval"]["containment"]["parts"]
     and r["eval"]["containment"]["triangles_outside"] == 0),
    ("layer 1 misses nothing", lambda r: layer(r, "3")["layer1_missed"] == 0),
    ("layer 3: no verdict wrong beyond 0.5 % of R_max (mechanical parts and tori: at most 4)",
     lambda r: layer(r, "3")["missed"] + layer(r, "3")["false_contacts"] == 0),
    ("exact layer: no verdict wrong beyond 0.001 % of R_max",
     lambda r: layer(r, "exact")["missed"] + layer(r, "exact")["false_contacts"] == 0),
    ("answers called certain are never wrong, nor contradicted by layers 2 and 3",
     lambda r: all(layer(r, k)["certain_wrong"] == 0 and layer(r, k)["contradictions"] == 0 for k in ("2", "3", "exact"))),
    ("eq. 35: mean <= 0.05 %, p99 <= 0.5 %",
     lambda r: layer(r, "3")["eq35_percent"]["mean"] <= 0.05 and layer(r, "3")["eq35_percent"]["p99"] <= 0.5),
    ("layer 3 depth: median <= 0.03 %, p95 <= 0.3 %, p99 <= 0.5 %",
     lambda r: layer(r, "3")["depth_percent"]["median"] <= 0.03 and layer(r, "3")["depth_percent"]["p95"] <= 0.3
     and layer(r, "3")["depth_percent"]["p99"] <= 0.5),
    ("layer 3 normal: median <= 5 degrees", lambda r: layer(r, "3")["normal_degrees"]["median"] <= 5),
    ("exact depth: median <= 0.001 %, p95 <= 0.05 %",
     lambda r: layer(r, "exact")["depth_percent"]["median"] <= 0.001 and layer(r, "exact")["depth_percent"]["p95"] <= 0.05),
    ("model of up to 10,300 triangles: at most 1 MB, 0.5 MB without the exact layer",
     lambda r: r["info"]["triangles"] > 10300
     or (r["info"]["bytes"]["total"] <= 1e6 and r["info"]["bytes"]["without_exact"] <= 5e5)),
    ("bake on one core: at most 5 s for 10,000 triangles (in proportion below and above; 40 s for 100,000)",
     lambda r: r["seconds"] <= (5 if r["info"]["triangles"] <= 10000 else 5 * r["info"]["triangles"] / 1e4
                                if r["info"]["triangles"] < 8e4 else 40)),
]

MEANING = """\
## What the columns mean

Lengths are percent of R_max, the largest distance between two vertices. Each mesh is measured at 20,000 pseudo-random
points, three quarters of them within 4 % of the surface, one quarter in the bounding box, against an exact oracle in
double precision (winding number above 0 is inside, true distance to the boundary).

- **kB**, **kB w/o exact**: size of the model file, and its size without the exact layer's lists and triangles.
- **bake s**: CPU seconds of the whole bake on one thread, its own measurement included; more beside other work.
- **contained**: parts whose stored certificate proves that the superquadric holds the part's surface and the caps that
  close it, and triangles found outside every superquadric when checked again.
- **L1 missed**: points of the solid that layer 1 calls free.
- **L3 missed + false**: wrong verdicts of layer 3 at points farther than 0.5 % from the surface.
- **certain wrong**: answers that the model calls proven and the oracle contradicts, layer 3 and exact together.
- **eq. 35**: the difference between map and mesh along the projection; *left out* is the share of the points inside a
  superquadric whose ray does not cross both map and mesh.
- **L3 depth**, **normal median**: of contacts, against the true distance and the direction of the true nearest point,
  in degrees.
- **exact missed + false**: wrong verdicts of the exact layer at points farther than 0.001 % from the surface.

Point queries and probe queries of the same positions have the same answers, so these figures hold for both.
"""


def falls_short(rows):
    for title, holds in TARGETS:
        failing = [r["name"] for r in rows if not holds(r)]
        yield f"- {title}: " + ("met by all" if not failing else f"**not met** by {', '.join(failing)}")


def commit(root=ROOT):
    """The commit checked out, "-dirty" where tracked files differ from it. Pages that runs write do not count."""
    def git(*arguments):
        return subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True).stdout.strip()
    name = git("log", "-1", "--format=%h")
    if not name:
        return "unknown"
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", ":(exclude)docs", ":(exclude)*.md")
    return name + "-dirty" if changed else name


def document(groups, skipped, failed, made_from):
    lines = ["# Measurements", "",
             f"Made by `./dev table` on {datetime.date.today().isoformat()}, from commit {made_from}. Default options "
             "throughout.", ""]
    for title, rows in groups:
        lines += [f"## {title}", "", *shape_of(COLUMNS, rows), ""]
    lines += ["## Targets", "", "Over all meshes above:", "",
              *falls_short([r for _, rows in groups for r in rows]), ""]
    if failed:
        lines += ["Not baked:", "", *(f"- {name}: {why}" for name, why in failed), ""]
    if skipped:
        lines += ["Left out, because they are not closed solids (answer of `sqmap check`): " +
                  ", ".join(f"{name} ({code})" for name, code in skipped) + ".", ""]
    return "\n".join(lines) + "\n" + MEANING


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="*", type=pathlib.Path, default=[ROOT / "build" / "demo" / "meshes"])
    parser.add_argument("-o", "--output", type=pathlib.Path, default=ROOT / "docs" / "measurements.md")
    parser.add_argument("--title", action="append", default=[], help="heading of a folder's table, in order")
    parser.add_argument("--most", type=int, default=200000, help="leave out meshes with more triangles")
    options = parser.parse_args()
    made_from = commit()  # of the program that is measured, whatever happens to the sources meanwhile
    groups, skipped, failed = [], [], []
    for i, folder in enumerate(options.folders):
        rows = []
        for mesh in sorted(p for p in folder.iterdir() if p.suffix.lower() in MESH_ENDINGS):
            verdict = check(mesh)
            if verdict["code"] or not verdict["facts"]["solid"]:
                skipped.append((mesh.stem, verdict["code"]))
                continue
            if verdict["facts"]["triangles"] > options.most:
                continue
            with tempfile.TemporaryDirectory() as work:
                try:
                    row = measure(mesh, pathlib.Path(work), "--threads", "1")
                except SystemExit as e:
                    failed.append((mesh.stem, str(e).strip().splitlines()[-1]))
                    print(f"{mesh.stem}: {failed[-1][1]}", flush=True)
                    continue
            print(" ".join(f"{value(row)}" for _, value in COLUMNS), flush=True)
            rows.append(row)
        if rows:
            groups.append((options.title[i] if i < len(options.title) else f"Meshes of `{folder.name}`", rows))
    if not groups:
        sys.exit("no closed mesh to measure; './dev demo' fetches some")
    options.output.write_text(document(groups, skipped, failed, made_from))
    print(options.output)


if __name__ == "__main__":
    main()
