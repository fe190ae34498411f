#!/usr/bin/env python3
"""Real meshes that anybody can fetch: the animals in the data of CGAL, which Debian packages as libcgal-demo (24 MB, once).

They are kept in build/demo and never committed. The demonstration bakes them, and tests of real meshes take them where the
meshes that they were written for are not.
usage: animals.py     exit 0 when the animals are there, 1 when they could not be fetched
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile

DEMO = pathlib.Path(__file__).resolve().parent.parent / "build" / "demo"
CACHE = DEMO / "cache"
MESHES = DEMO / "meshes"
PACKAGE = "libcgal-demo"
NAMES = ("elephant", "camel", "bull", "triceratops", "dino", "cow")


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


def fetch(names=NAMES):
    """Puts NAME.off of each mesh of the package into MESHES; whether all are there."""
    names = [n for n in names if not (MESHES / f"{n}.off").exists()]
    if not names:
        return True
    for folder in (CACHE, MESHES):
        folder.mkdir(parents=True, exist_ok=True)
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
                    (MESHES / f"{name}.off").write_bytes(source.read())
        shutil.rmtree(CACHE / "cgal")
        return True
    return False


if __name__ == "__main__":
    sys.exit(0 if fetch() else 1)
