#!/usr/bin/env python3
"""Races sqmap and its peers along every path of a folder, and prints tables of the medians.

usage: bench.py [FOLDER] [--kinds light,deep,near] [options of sqmap_bench frames]

FOLDER holds meshes/ and paths/ (OBJECT.PROBE.KIND.csv); default: SQMAP_SHARED_DIR, or ../shared. Kinds of paths that it lacks
are made. Without meshes there the project's own shapes are used: a hand that slides over a torus, a dumb-bell and an ellipsoid.
Records go to build/bench, one file a path; tables to build/bench/tables.md.
"""
import argparse
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = ROOT / "build" / "release" / "bin"
OUT = ROOT / "build" / "bench"
SHAPES = ("torus", "dumbbell", "ellipsoid")


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
    written = []
    for name, obj, probe, path in cases(folder, arguments.kinds.split(",")):
        written.append(OUT / f"{name}.json")
        print(f"\n{name}", flush=True)
        run("sqmap_bench", "frames", "--object", obj, "--probe", probe, "--path", path, "--cache", OUT / "cache",
            "--json", written[-1], *options)
    tables = run("sqmap_bench", "table", *written, stdout=subprocess.PIPE)
    (OUT / "tables.md").write_text(tables)
    print("\n" + tables)


if __name__ == "__main__":
    main()
