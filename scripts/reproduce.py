#!/usr/bin/env python3
"""Repeats the paper's evaluation (its section 7): what ./dev reproduce runs once the programs are built.

usage: reproduce.py [FOLDER] [--quick] [--redraw] [--frames N] [--only memory,models,races,ticks,density]

FOLDER holds meshes/ and paths/ (default: SQMAP_SHARED_DIR, or ../shared) with stand-ins for the paper's five animals and its
hand; without them the demo's meshes stand in. Numbers go to build/reproduce as JSON and CSV, plots to
docs/images/reproduction, tables into docs/reproduction.md. --quick: shapes that the program makes itself, coarse and short,
all in build/reproduce/quick. --redraw: pictures, plots and tables again from the numbers of the last run. --only: some of the
measurements, the others' numbers are those of the last run. --frames: so many of each path.
"""
import argparse
import csv
import dataclasses
import json
import math
import os
import pathlib
import subprocess
import sys
import time

import numpy

import demo
import demo_meshes
import docs_images
import measure
import reproduce_figures as figures

ROOT = measure.ROOT
BENCH = measure.PROGRAM.parent / "sqmap_bench"
MEASURE = measure.PROGRAM.parent / "sqmap_measure"
START = time.monotonic()


@dataclasses.dataclass
class Subject:
    """One of the paper's models and what stands in for it."""
    role: str
    mesh: pathlib.Path
    up: str = "y"
    azimuth: str = ""


# Role in the paper: stem of the shared stand-in, upward axis, the demo's stand-in.
ROLES = {
    "Virtual hand": ("hand_9344", "y", "hand"),
    "Tiger": ("cat_8108", "y", "dino"),
    "Horse": ("horse_5946", "z", "triceratops"),
    "Elephant": ("elephant_10272", "y", "elephant"),
    "Camel": ("camel_4512", "y", "camel"),
    "Rhino": ("bull_7154", "y", "bull"),
}
QUICK_ROLES = {"Virtual hand": "hand", "Tiger": "rounded_box", "Horse": "dumbbell", "Elephant": "bent"}

FIGURE_10 = ("Elephant", "Tiger", "Horse")

# The races run these methods. The paper's projection is asked as section 4.2 does; "printed" follows eqs. 16 to 19 to the letter.
METHODS = ("sqmap_normal_layer1", "sqmap_normal_printed", "sqmap_normal_pyramid3", "sqmap_normal_layer2", "sqmap_normal_layer3",
           "sqmap_layer3", "sqmap_exact", "fcl_obb_all", "dense128", "adf")
# The same maps on the machine's widest vectors, and by the kernel's reference: the same bits.
WIDE_METHODS = ("sqmap_normal_layer1", "sqmap_normal_printed", "sqmap_normal_pyramid3", "sqmap_normal_layer2", "sqmap_normal_layer3",
                "sqmap_normal_one_lane", "fcl_obb_all")


@dataclasses.dataclass
class Scale:
    """How much is measured."""
    frames: int = 120
    cells: str = "64,128,256,512"
    levels: str = "3,4,5,6,7"
    density_levels: str = "4,5,6"
    density_frames: int = 25
    grid: str = "65x128"


def say(text):
    print(f"[{time.monotonic() - START:5.0f} s] {text}", flush=True)


def bench(*arguments, program=BENCH):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{program.name} {' '.join(map(str, arguments))}\n{done.stdout}{done.stderr}")


def subjects(folder, quick, out):
    """The paper's models as far as they are there; the hand first."""
    if quick:
        for shape in QUICK_ROLES.values():
            measure.run("shapes", shape, "-o", out / f"{shape}.obj")
        return [Subject(role, out / f"{shape}.obj", "z") for role, shape in QUICK_ROLES.items()]
    if all((folder / "meshes" / f"{stem}.obj").exists() for stem, _, _ in ROLES.values()):
        return [Subject(role, folder / "meshes" / f"{stem}.obj", up) for role, (stem, up, _) in ROLES.items()]
    say(f"no stand-ins in {folder}: the demo's meshes are used")
    demo_meshes.fetch()
    demo_meshes.fetch_hand()
    found = {role: next(iter(sorted(demo_meshes.MESHES.glob(f"{stem}.o*"))), None) for role, (_, _, stem) in ROLES.items()}
    missing = [role for role, mesh in found.items() if mesh is None]
    if missing:
        sys.exit(f"no mesh for: {', '.join(missing)}\n  cure: run where apt-get reaches a Debian mirror, or give a FOLDER")
    return [Subject(role, mesh, demo.SUBJECTS[mesh.stem], str(demo.AZIMUTH.get(mesh.stem, ""))) for role, mesh in found.items()]


def path_of(folder, subject, hand, kind, frames, out):
    """A path along which the hand slides over the subject, thinned evenly."""
    name = f"{subject.mesh.stem}.{hand.mesh.stem}.{kind}.csv"
    whole = folder / "paths" / name
    if not whole.exists():
        whole = out / f"whole.{name}"
        if not whole.exists():
            bench("path", "--object", subject.mesh, "--probe", hand.mesh, "--kind", kind, "-o", whole)
    rows = whole.read_text().splitlines()
    stride = max(1, (len(rows) - 1) // frames)
    path = out / name
    path.write_text("\n".join(rows[:1] + rows[1::stride]) + "\n")
    return path


# --- What is measured --------------------------------------------------------------------------------------------------

def measure_memory(models, folder, scale, out):
    """Table 1 and Fig. 12: bytes of the fields and of the paper's maps at several densities."""
    for subject in models:
        say(f"memory of {subject.role}: {subject.mesh.stem}")
        bench("memory", "--object", subject.mesh, "--cells", scale.cells, "--levels", scale.levels, "--json",
              out / f"memory.{subject.role}.json")


def measure_models(models, folder, scale, out):
    """Table 1: bytes of whole models."""
    for subject in models:
        say(f"models of {subject.role}: {subject.mesh.stem}")
        found = {}
        paper = ("--projection", "normal", "--grid", scale.grid, "--subdivisions")
        bare = ("--smoothing-radius", "0")
        for kind, options in (("default", ()), ("paper0", (*paper, "0")), ("paper1", (*paper, "1")), ("bare0", (*paper, "0", *bare)),
                              ("bare1", (*paper, "1", *bare))):
            report, model = out / f"{subject.role}.{kind}.json", out / f"{subject.role}.{kind}.sqmap"
            measure.run("bake", subject.mesh, "-o", model, "--report", report, *options)
            baked, info = json.loads(report.read_text()), json.loads(measure.run("info", model, "--json"))
            found[kind] = {"bytes": info["bytes"]["total"], "bytes_without_exact": info["bytes"]["without_exact"],
                           "parts": len(info["parts"]), "eq35_mean_pct": info["measured"]["eq35_percent"]["mean"],
                           "seconds": sum(baked["cpu_seconds"].values())}
        (out / f"model.{subject.role}.json").write_text(json.dumps(found))


def measure_races(models, folder, scale, out):
    """Figs. 11a, 14a and 14b: every method's time in every frame."""
    hand, others = models[0], models[1:]
    for subject in others:
        for kind in figures.kinds_of(subject.role):
            say(f"the hand slides over {subject.role}, {kind}")
            path = path_of(folder, subject, hand, kind, scale.frames, out)
            for name, methods, limit in (("race", METHODS, ("--instructions", "avx2")), ("wide", WIDE_METHODS, ())):
                bench("frames", "--object", subject.mesh, "--probe", hand.mesh, "--path", path, "--methods", ",".join(methods),
                      "--json", out / f"{name}.{subject.role}.{kind}.json", "--series",
                      out / f"{name}.{subject.role}.{kind}.csv", "--quiet", *limit)


def measure_ticks(models, folder, scale, out):
    """The force curves of Figs. 14a and 14b: a whole haptic tick beside the query that it makes."""
    hand, subject = models[0], next(m for m in models if m.role == "Elephant")
    for kind in figures.kinds_of(subject.role):
        say(f"the hand feels {subject.role}, {kind}")
        for force, options in (("paper", ("--paper",)), ("full", ())):
            bench("haptic", "tick", path_of(folder, subject, hand, kind, scale.frames, out), "--meshes", subject.mesh.parent, "--series",
                  out / f"tick.{force}.{kind}.csv", *options, program=MEASURE)


def measure_density(models, folder, scale, out):
    """Fig. 14c: time and eq. 35 at several densities and subdivisions."""
    hand, subject = models[0], next(m for m in models if m.role == "Elephant")
    say(f"densities on {subject.role}")
    bench("density", "--object", subject.mesh, "--probe", hand.mesh, "--path",
          path_of(folder, subject, hand, "deep", scale.frames, out), "--levels", scale.density_levels, "--frames",
          scale.density_frames, "--json", out / "density.json")


def lathe(path, profile, segments=96):
    """A closed surface of revolution about z: profile has (radius, z) from the upper pole to the lower, both of radius 0."""
    (_, top), *rings, (_, bottom) = profile
    lines = [f"v 0 0 {top}"]
    for r, z in rings:
        lines += [f"v {r * math.cos(2 * math.pi * j / segments):.9g} {r * math.sin(2 * math.pi * j / segments):.9g} {z:.9g}"
                  for j in range(segments)]
    lines.append(f"v 0 0 {bottom}")
    last = 2 + len(rings) * segments
    for j in range(segments):
        k = (j + 1) % segments
        lines.append(f"f 1 {2 + j} {2 + k}")
        for i in range(len(rings) - 1):
            a, b = 2 + i * segments, 2 + (i + 1) * segments
            lines += [f"f {a + j} {b + j} {b + k}", f"f {a + j} {b + k} {a + k}"]
        lines.append(f"f {last} {last - segments + k} {last - segments + j}")
    path.write_text("\n".join(lines) + "\n")


def two_spheres(path, apart=0.75, segments=96):
    """Two unit spheres that overlap, as one surface: the object of Fig. 4."""
    rim = math.acos(-apart)  # from a pole to where the spheres meet
    half = [(math.sin(t), apart + math.cos(t)) for t in (rim * i / 40 for i in range(41))]
    lathe(path, half + [(r, -z) for r, z in reversed(half[:-1])], segments)


def ridge_and_groove(path):
    """A body with a ridge and a groove that lie between the samples of a coarse map: arcs E and S of Fig. 5. Returns its profile."""
    tent = lambda z: max(0, 1 - abs(z - 0.3) / 0.12) - max(0, 1 - abs(z + 0.3) / 0.12)
    radius = lambda z: (1 - abs(z / 1.3) ** (10 / 3)) ** 0.3 * (1 + 0.07 * tent(z))
    edges = {c + d for c in (-0.3, 0.3) for d in (-0.12, 0, 0.12)}
    heights = edges | {z for z in (1.3 * (i / 30 - 1) for i in range(1, 60)) if min(abs(z - 0.3), abs(z + 0.3)) > 0.13}
    profile = [(0, 1.3), *((radius(z), z) for z in sorted(heights, reverse=True)), (0, -1.3)]
    lathe(path, profile, 32)
    return profile


def section_of(model, out, low=-0.75, side=1.5, points=301):
    """Figs. 5 and 8: a section's points as {column: square array}."""
    bench("vertices", model, "--low", low, "--side", side, "--points", points, "-o", out / "fig05.csv")
    found = numpy.genfromtxt(out / "fig05.csv", delimiter=",", names=True)
    columns = {name: numpy.full((points, points), numpy.nan) for name in found.dtype.names}
    row, column = (numpy.rint((found[name] - start) / side * (points - 1)).astype(int) for name, start in (("z", low), ("x", 0)))
    for name, values in columns.items():
        values[row, column] = found[name]
    columns["x"], columns["z"] = numpy.meshgrid(numpy.linspace(0, side, points), numpy.linspace(low, low + side, points))
    return columns


def search_of(eps1, eps2, point, out):
    """Figs. 6 and 7: the rows of a point's search on a superquadric."""
    bench("search", "--eps1", eps1, "--eps2", eps2, "--point", point, "-o", out / "search.csv")
    with open(out / "search.csv", newline="") as rows:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(rows)]


def draw_step_three_and_search(out, images):
    """Figs. 5 to 8."""
    mesh, model, sections = out / "ridge.obj", out / "ridge.sqmap", []
    profile = ridge_and_groove(mesh)
    for grid in ("17x32", "129x256"):
        measure.run("bake", mesh, "-o", model, "--grid", grid, *AS_ONE_PART)
        sections.append(section_of(model, out))
    figures.figures_5_and_8(*sections, profile, images)
    figures.figure_6({eps: search_of(1, eps, point, out) for eps, point in ((0.4, "0.35,0.55,0"), (1.6, "0.15,0.5,0"))}, images)
    figures.figure_7(search_of(0.6, 0.4, "0.35,0.55,0.25", out), images)


def draw_pictures(models, out, images):
    """Figs. 3, 4 and 10: what the project's own renderer draws, and the samples of a superquadric."""
    say("pictures")
    bench("sampling", "-o", out / "fig03.csv")
    spheres, model = out / "two_spheres.obj", out / "two_spheres.sqmap"
    two_spheres(spheres)
    measure.run("bake", spheres, "-o", model, "--projection", "normal", "--max-parts", "1", "--no-exact", "--grid", "100x200",
                "--subdivisions", "0")
    for name, kinds, size in (("fig04", "parts,superquadrics", "400x300"), ("fig04.map", "map", "800x440")):
        measure.run("render", model, spheres, "--what", kinds, "--up", "z", "--size", size, "-o", out / f"{name}.png")
    rows = []
    for role in FIGURE_10:
        subject = next(m for m in models if m.role == role)
        rows.append(out / f"fig10.{role}.png")
        measure.run("render", out / f"{role}.paper1.sqmap", subject.mesh, "--what", "parts,superquadrics", "--up", subject.up, "--size",
                    "400x320", *(["--azimuth", subject.azimuth] if subject.azimuth else []), "-o", rows[-1])
    docs_images.sheet([out / "fig04.png", out / "fig04.map.png"], 1, images / "fig04.png",
                      ("(a) object, (b) its superquadric", "(c) the map: 100 x 200 samples, latitude up, longitude across"))
    docs_images.sheet(rows, 1, images / "fig10.png", [f"({letter}) {role}: parts, superquadrics" for letter, role in zip("abc", FIGURE_10)])
    draw_section_three(models, out, images)
    draw_step_three_and_search(out, images)


def draw_section_three(models, out, images):
    """Fig. 1, the fields of section 3 on the elephant, and the cuts as printed of all models, before any other cut."""
    def drawn(subject, kinds, size, name, cuts="printed"):
        picture = out / name
        measure.run("render", subject.mesh, "--what", kinds, "--cuts", cuts, "--up", subject.up, "--size", size,
                    *(["--azimuth", subject.azimuth] if subject.azimuth else []), "-o", picture)
        return picture

    docs_images.sheet([drawn(models[0], "parts,superquadrics", "400x330", "fig01.png", "passes")], 1, images / "fig01.png",
                      ["Parts of section 3, and their superquadrics"])
    elephant = next(m for m in models if m.role == "Elephant")
    fields = {"features": "protrusion and salient features", "locales": "locales", "strength": "Boundary Strength",
              "curvature": "Gaussian curvature", "hyperbolic": "hyperbolic surface", "parts": "parts, cut as printed"}
    docs_images.sheet([drawn(elephant, kind, "320x260", f"section3.{kind}.png") for kind in fields], 3, images / "section3.png",
                      list(fields.values()))
    docs_images.sheet([drawn(m, "parts", "266x220", f"printed.{m.role}.png") for m in models], 3, images / "fig10_printed.png",
                      [m.role for m in models])


# --- What is made of it ------------------------------------------------------------------------------------------------

def load(models, out):
    """All numbers of a run, by role."""
    data = figures.Data(roles=[m.role for m in models])
    for role in data.roles:
        data.memory[role] = json.loads((out / f"memory.{role}.json").read_text())
        data.model[role] = json.loads((out / f"model.{role}.json").read_text())
    for role in data.roles[1:]:
        for kind in figures.kinds_of(role):
            for name, series, records in (("race", data.series, data.records), ("wide", data.wide, data.wide_records)):
                with open(out / f"{name}.{role}.{kind}.csv", newline="") as rows:
                    series[role, kind] = [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(rows)]
                records[role, kind] = json.loads((out / f"{name}.{role}.{kind}.json").read_text())
    for kind in figures.kinds_of("Elephant"):
        for force in ("paper", "full"):
            with open(out / f"tick.{force}.{kind}.csv", newline="") as rows:
                data.ticks[force, kind] = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(rows)]
    if (out / "density.json").exists():  # not measured, Fig. 14c stays as it is
        data.density = json.loads((out / "density.json").read_text())
    with open(out / "fig03.csv", newline="") as rows:
        data.sampling = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(rows)]
    return data


COROLLARY_GRIDS = ("9x16", "17x32", "33x64", "65x128", "129x256", "257x512", "513x1024")
AS_ONE_PART = ("--projection", "normal", "--max-parts", "1", "--max-looseness", "1000000", "--max-q2", "1", "--subdivisions", "0",
               "--smoothing-radius", "0", "--no-exact")


def corollary_errors(shape, quick, out):
    """{grid: (share of Q2, mean, 99th percentile of the depth's error)}; percent of the area and of R_max."""
    mesh, model = out / f"corollary.{shape}.obj", out / f"corollary.{shape}.sqmap"
    measure.run("shapes", shape, "-o", mesh)
    errors = {}
    for grid in COROLLARY_GRIDS[:3] if quick else COROLLARY_GRIDS:
        measure.run("bake", mesh, "-o", model, "--grid", grid, *AS_ONE_PART)
        q2 = json.loads(measure.run("info", model, "--json"))["measured"]["q2_percent"]
        depth = json.loads(measure.run("eval", model, mesh, "--layer", "3", "--json"))["layer"]["3"]["depth_percent"]
        errors[grid] = q2, depth["mean"], depth["p99"]
    return errors


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", nargs="?", type=pathlib.Path,
                        default=pathlib.Path(os.environ.get("SQMAP_SHARED_DIR", ROOT.parent / "shared")))
    parser.add_argument("--quick", action="store_true", help="the project's own shapes, coarse and short; docs stay as they are")
    parser.add_argument("--redraw", action="store_true", help="from the numbers of the last run")
    parser.add_argument("--only", default="memory,models,races,ticks,density", help="measurements, by comma")
    parser.add_argument("--frames", type=int, default=Scale.frames, help="of each path")
    arguments = parser.parse_args()
    out = ROOT / "build" / "reproduce" / ("quick" if arguments.quick else "")
    images = out / "images" if arguments.quick else ROOT / "docs" / "images" / "reproduction"
    for folder in (out, images):
        folder.mkdir(parents=True, exist_ok=True)
    scale = Scale(20, "32,64", "3,4", "3,4", 5, "17x32") if arguments.quick else Scale(frames=arguments.frames)
    models = subjects(arguments.folder, arguments.quick, out)
    only = arguments.only.split(",")
    if "models" not in only and not arguments.redraw and not all((out / f"{m.role}.paper1.sqmap").exists() for m in models):
        sys.exit("--only: the pictures need the models of an earlier run\n  cure: name models too")
    if not arguments.redraw:
        commit = measure.commit()  # of the programs that run, whatever happens to the sources meanwhile
        for name, measurement in {"memory": measure_memory, "models": measure_models, "races": measure_races,
                                  "ticks": measure_ticks, "density": measure_density}.items():
            if name in only:
                measurement(models, arguments.folder, scale, out)
        (out / "run.json").write_text(json.dumps({"date": time.strftime("%Y-%m-%d"), "commit": commit, "frames": scale.frames,
                                                  "stand_ins": {m.role: m.mesh.stem for m in models}}))
    draw_pictures(models, out, images)
    say("corollaries of section 5")
    text = figures.draw_corollaries({shape: corollary_errors(shape, arguments.quick, out) for shape in figures.COROLLARY_SHAPES},
                                    images)
    if not arguments.quick:
        (ROOT / "docs" / "data" / "reproduction" / "corollaries.txt").write_text(text, encoding="utf-8")
    say("tables and plots")
    data = load(models, out)
    data.run = json.loads((out / "run.json").read_text())
    figures.write_csv(data, out)
    figures.draw(data, images)
    page = figures.tables(data)
    (out / "tables.md").write_text("\n\n".join(f"{title}\n\n{text}" for title, text in page.items()) + "\n")
    if not arguments.quick:
        figures.renew_page(ROOT / "docs" / "reproduction.md", page)
    say(f"done: numbers in {out.relative_to(ROOT)}, plots in {images.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
