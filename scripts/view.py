#!/usr/bin/env python3
"""Opens files, or the demo scene of five animals and a hand, in the browser: what ./dev view runs once the program is built."""
import json
import os
import pathlib
import sys
import time

import demo
import demo_meshes
import measure

NAMES = measure.ROOT / "examples" / "demo_names.json"  # what the parts of the meshes are called: points of them
SCENE = ("elephant", "bull", "triceratops", "camel", "cow", "hand")  # three in front, three behind


def model_of(mesh):
    return demo_meshes.DEMO / f"{mesh.stem}.sqmap"


def is_old(model):
    return not model.exists() or model.stat().st_mtime < measure.PROGRAM.stat().st_mtime


def bake(meshes):
    """Says which of how many, and how long the rest may take: as long for each byte as those before."""
    sizes, done, began = [m.stat().st_size for m in meshes], 0, time.monotonic()
    for i, mesh in enumerate(meshes):
        left = f", about {(time.monotonic() - began) / done * (sum(sizes) - done):.0f} s left" if done else ""
        print(f"    {mesh.stem}: {i + 1} of {len(meshes)}{left}", flush=True)
        measure.run("bake", mesh, "-o", model_of(mesh))
        done += sizes[i]


def scene():
    """Models of the demo scene, baked once; none where nothing could be fetched."""
    demo.say("step 3 of 4: the meshes of the demo")
    demo_meshes.fetch()
    demo_meshes.fetch_hand()
    demo.say("step 4 of 4: their models")
    known = json.loads(NAMES.read_text())
    either = [[demo_meshes.MESHES / f"{name}.{kind}" for kind in ("off", "obj")] for name in SCENE]
    found = [next(p for p in paths if p.exists()) for paths in either if any(p.exists() for p in paths)]
    bake([m for m in found if is_old(model_of(m))])
    models = []
    for mesh in found:
        name, model = mesh.stem, model_of(mesh)
        names = model.with_suffix(".names.json")
        # Names that people have given since stay; a stand-in has other points.
        if not names.exists() and json.loads(measure.run("info", model, "--json"))["triangles"] == known[name]["triangles"]:
            names.write_text(json.dumps(known[name], indent=1) + "\n")
        models.append(str(model))
    return models


def main():
    words = sys.argv[1:]
    if any(pathlib.Path(word).is_file() for word in words):
        demo.say("steps 3 and 4 are the demo's: your own files are opened")
    else:
        words = scene() + words
    sys.stdout.flush()
    os.execv(measure.PROGRAM, [str(measure.PROGRAM), "view", *words])


if __name__ == "__main__":
    main()
