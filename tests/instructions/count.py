#!/usr/bin/env python3
"""Instructions a frame of each layer takes, counted by valgrind (which has no AVX-512: the next best set is counted), against
those of counts.json. More by 3 % fails; fewer asks for --update, which writes what was counted.

usage: count.py --programs FOLDER --build NAME [--update]
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
COUNTS = HERE / "counts.json"
LAYERS = {"1": "layer 1", "2": "layer 2", "3": "layer 3", "4": "exact layer"}
ROOM = 0.03


def run(*arguments):
    done = subprocess.run([str(a) for a in arguments], text=True, capture_output=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout, done.stderr


def count(programs, folder):
    counts = {}
    for shape in ("dumbbell", "hand"):
        run(programs / "sqmap", "shapes", shape, "-o", folder / f"{shape}.obj")
    run(programs / "sqmap", "bake", folder / "dumbbell.obj", "-o", folder / "dumbbell.sqmap")
    for layer, name in LAYERS.items():
        out, told = run("valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/callgrind.out", "--collect-atstart=no",
                        "--toggle-collect=measured_frames", programs / "measured_frames", folder / "dumbbell.sqmap",
                        folder / "hand.obj", layer)
        contacts, target = out.split()
        instructions = int(re.search(r"Collected : (\d+)", told).group(1))
        counts[name] = {"instructions": instructions, "contacts": int(contacts)}
    return target, counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--build", required=True, help="compiler, version and build type: counts hold for it alone")
    parser.add_argument("--update", action="store_true")
    arguments = parser.parse_args()
    if shutil.which("valgrind") is None:
        print("skipped: valgrind is not installed")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        target, counts = count(arguments.programs, pathlib.Path(folder))
    key = f"{arguments.build}, {target}"
    known = json.loads(COUNTS.read_text()) if COUNTS.exists() else {}
    if arguments.update:
        known[key] = counts
        COUNTS.write_text(json.dumps(known, indent=2) + "\n")
    for name, now in counts.items():
        print(f"{name}: {now['instructions']:,} instructions, {now['contacts']} contacts")
    if key not in known:
        print(f"skipped: no counts are known for {key}; --update adds them")
        sys.exit(77)
    worse = []
    for name, now in counts.items():
        was = known[key][name]
        change = now["instructions"] / was["instructions"] - 1
        if now["contacts"] != was["contacts"]:
            worse.append(f"{name}: {now['contacts']} contacts, where {was['contacts']} were: look why, then --update")
        if change > ROOM:
            worse.append(f"{name}: {100 * change:.1f} % more instructions; --update if that is meant")
        elif change < -ROOM:
            print(f"{name}: {-100 * change:.1f} % fewer instructions; --update keeps them")
    sys.exit("\n".join(worse) if worse else 0)


if __name__ == "__main__":
    main()
