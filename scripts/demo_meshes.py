#!/usr/bin/env python3
"""Fetches real meshes that anybody can have: animals from the data of CGAL, which Debian packages as libcgal-demo (24 MB, once), and
the open glTF hand of the WebXR input profiles, from npm, subdivided once.

They are kept in build/demo and never committed. The demonstration bakes the animals and the hand. Tests of real meshes take
the animals, and other meshes of CGAL, where the meshes that the tests were written for are missing.
usage: demo_meshes.py     fetches the meshes of the tests; exit 0 when they are there, 1 when they could not be fetched
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile

import measure

DEMO = measure.ROOT / "build" / "demo"
CACHE, MESHES, TEST_MESHES = DEMO / "cache", DEMO / "meshes", DEMO / "test_meshes"
PACKAGE = "libcgal-demo"
NAMES = ("elephant", "camel", "bull", "triceratops", "dino", "cow")
STAND_INS = ("bear_bis", "elk", "fandisk", "homer", "knot1")  # tests/support/shared_folder.h says what each stands in for
HAND = "@webxr-input-profiles/assets@1.0.20"
HAND_FILE = "package/dist/profiles/generic-hand/right.glb"


def tried(*command, cwd=None):
    """True if a command succeeded; its words are shown where it did not."""
    try:
        done = subprocess.run(command, cwd=cwd, capture_output=True, text=True)
    except OSError as error:
        print(f"    {' '.join(command)}: {error}")
        return False
    if done.returncode != 0:
        print(f"    {' '.join(command)}: {(done.stderr or done.stdout).strip().splitlines()[-1:]}")
    return done.returncode == 0


def fetch(names=NAMES, folder=MESHES):
    """Puts NAME.off of each mesh of the package into a folder; true if all are there."""
    names = [n for n in names if not (folder / f"{n}.off").exists()]
    if not names:
        return True
    for needed in (CACHE, folder):
        needed.mkdir(parents=True, exist_ok=True)
    print(f"\n==> fetching {', '.join(names)} (Debian package {PACKAGE}, 24 MB, once)", flush=True)
    if not list(CACHE.glob(f"{PACKAGE}_*.deb")):
        if not tried("apt-get", "download", PACKAGE, cwd=CACHE):
            update = ["apt-get", "update", "-qq"]
            tried(*(update if os.geteuid() == 0 else ["sudo", "-n", *update]))
            tried("apt-get", "download", PACKAGE, cwd=CACHE)
    for package in CACHE.glob(f"{PACKAGE}_*.deb"):
        if not tried("dpkg-deb", "-x", str(package), str(CACHE / "cgal")):
            return False
        with tarfile.open(next((CACHE / "cgal").rglob("data.tar.gz"))) as archive:
            for name in names:
                with archive.extractfile(f"data/meshes/{name}.off") as source:
                    (folder / f"{name}.off").write_bytes(source.read())
        shutil.rmtree(CACHE / "cgal")
        return True
    return False


def fetch_hand():
    """Puts hand.obj into MESHES; where npm or the network is missing, a hand that the program makes itself stands in."""
    target = MESHES / "hand.obj"
    if target.exists():
        return
    for needed in (CACHE, MESHES):
        needed.mkdir(parents=True, exist_ok=True)
    packages = list(CACHE.glob("webxr-input-profiles-assets-*.tgz"))
    if not packages and shutil.which("npm"):
        print("\n==> fetching the hand (npm package @webxr-input-profiles/assets, 94 MB for a file of 94 kB, once)", flush=True)
        tried("npm", "pack", "--silent", HAND, cwd=CACHE)
        packages = list(CACHE.glob("webxr-input-profiles-assets-*.tgz"))
    if packages:
        with tarfile.open(packages[0]) as archive, archive.extractfile(HAND_FILE) as source:
            (CACHE / "hand.glb").write_bytes(source.read())
        print(measure.run("shapes", CACHE / "hand.glb", "--subdivide", "1", "-o", target), end="")
    else:
        print("\n==> no npm here: the hand is one that the program makes itself", flush=True)
        print(measure.run("shapes", "hand", "-o", target), end="")


if __name__ == "__main__":
    sys.exit(0 if fetch(NAMES + STAND_INS, TEST_MESHES) else 1)
