#!/usr/bin/env python3
"""The page without a server: a folder for any static host, with the viewer's program in a worker and models to begin with.

./dev anywhere page builds the program and calls this; the documentation site takes the folder for its live models."""
import pathlib
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
WEB = ROOT / "apps/viewer/web"
NATIVE = ROOT / "build/release"
FOLDER = ROOT / "build/anywhere/page"
SHAPES = ("hand", "dumbbell")  # the page begins with the first


def can_build():
    """Whether npm's packages are here."""
    return shutil.which("npm") is not None and all((WEB / "node_modules" / name).is_dir() for name in ("vite", "iwer"))


def bake_shapes(folder):
    """Shapes that the project makes itself, as models."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in SHAPES:
        mesh = folder / f"{name}.obj"
        for command in (["shapes", name, "-o", mesh], ["bake", mesh, "-o", folder / f"{name}.sqmap", "--exact"]):
            subprocess.run([NATIVE / "bin/sqmap", *command], check=True, stdout=subprocess.DEVNULL)
        mesh.unlink()


def assemble(program):
    """program: the folder with program.mjs and program.wasm. The finished folder."""
    subprocess.run(["npm", "run", "--silent", "build", "--", "--outDir", FOLDER, "--emptyOutDir", "--logLevel", "error"], cwd=WEB,
                   check=True, stderr=subprocess.DEVNULL)
    for file in (program / "program.mjs", program / "program.wasm", ROOT / "apps/viewer/page/worker.js", ROOT / "LICENSE"):
        shutil.copy(file, FOLDER)
    bake_shapes(FOLDER / "models")
    index = FOLDER / "index.html"
    text = index.read_text()
    begin = '<html lang="en">'
    if begin not in text:
        raise SystemExit(f"{index}: has no {begin}")
    index.write_text(text.replace(begin, f'<html lang="en" data-worker="worker.js" data-models="models/{SHAPES[0]}.sqmap">'))
    return FOLDER
