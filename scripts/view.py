#!/usr/bin/env python3
"""Opens files, or the demo scene of five animals and a hand, in the browser: what ./dev view runs once the program is built."""
import json
import os
import pathlib
import sys

import animals
import demo
import measure

NAMES = pathlib.Path(__file__).resolve().parent / "demo_names.json"  # what their parts are called: points of the meshes
SCENE = ("elephant", "bull", "triceratops", "camel", "cow", "hand")  # three in front, three behind


def scene():
    """Models of the demo scene, baked once; none where nothing could be fetched."""
    animals.fetch()
    demo.fetch_hand()
    known = json.loads(NAMES.read_text())
    models = []
    for name in SCENE:
        mesh = next((p for p in (demo.MESHES / f"{name}.off", demo.MESHES / f"{name}.obj") if p.exists()), None)
        if mesh is None:
            continue
        model = demo.DEMO / f"{name}.sqmap"
        if not model.exists() or model.stat().st_mtime < measure.PROGRAM.stat().st_mtime:
            demo.say(f"{name}: bake")
            measure.run("bake", mesh, "-o", model)
        names = model.with_suffix(".names.json")
        # What people have named since stays; a stand-in has other points.
        if not names.exists() and json.loads(measure.run("info", model, "--json"))["triangles"] == known[name]["triangles"]:
            names.write_text(json.dumps(known[name], indent=1) + "\n")
        models.append(str(model))
    return models


def main():
    words = sys.argv[1:]
    if not any(pathlib.Path(word).is_file() for word in words):
        words = scene() + words
    sys.stdout.flush()
    os.execv(measure.PROGRAM, [str(measure.PROGRAM), "view", *words])


if __name__ == "__main__":
    main()
