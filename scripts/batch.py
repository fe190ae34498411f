#!/usr/bin/env python3
"""A real library, from meshes to its report: what ./dev batch runs once the program is built.

The meshes are those of the demonstration and shapes of shape_families.py. The run is killed half way and goes on.
usage: batch.py [SHAPES]     how many shapes to make beside the fetched meshes; default 300
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys

import demo_meshes
import measure
import shape_families

FOLDER = measure.ROOT / "build" / "batch"
MESHES, LIBRARY = FOLDER / "meshes", FOLDER / "library"


def say(text):
    print(f"\n==> {text}", flush=True)


def gather(shapes):
    MESHES.mkdir(parents=True, exist_ok=True)
    demo_meshes.fetch()
    demo_meshes.fetch_hand()
    for mesh in [*demo_meshes.MESHES.glob("*.off"), *demo_meshes.MESHES.glob("hand.obj")]:
        if not (MESHES / mesh.name).exists():
            shutil.copy(mesh, MESHES)
    shape_families.make(MESHES, shapes)


def bake_half(count):
    """Ends the run and all it has started, as a machine that goes down would."""
    run = subprocess.Popen([measure.PROGRAM, "batch", MESHES, "-o", LIBRARY, "--progress", "json"], stdout=subprocess.PIPE, text=True)
    for line in run.stdout:
        if json.loads(line)["done"] >= count // 2:
            break
    run.kill()
    run.wait()


def main():
    shapes = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    say(f"meshes: the animals, a hand, and {shapes} shapes of {len(shape_families.FAMILIES)} families")
    gather(shapes)
    count = sum(1 for p in MESHES.rglob("*") if p.is_file())
    if not list((LIBRARY / "shards").glob("*.tar")):
        say(f"baking {count} meshes on {os.cpu_count()} cores, and killing it half way (kill -9)")
        bake_half(count)
    say("going on: what is finished is not baked again")
    for command in ((MESHES, "-o", LIBRARY), ("merge", LIBRARY), ("verify", LIBRARY), ("report", LIBRARY)):
        done = subprocess.run([measure.PROGRAM, "batch", *command])
        if done.returncode != 0:
            return done.returncode
    page = LIBRARY / "report" / "index.html"
    say(f"the report: {page.relative_to(measure.ROOT)}")
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        opener = shutil.which("xdg-open")
        if opener:
            subprocess.Popen([opener, page], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return 0


if __name__ == "__main__":
    sys.exit(main())
