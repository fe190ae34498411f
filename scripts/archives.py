#!/usr/bin/env python3
"""Makes what is handed out, in build/archives: the sources, the wheel, and the npm package where ./dev anywhere wasm has built it.

usage: archives.py [--out FOLDER]"""
import argparse
import importlib.util
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MAX_BYTES = {"wheel": 8_000_000, "npm": 4_000_000}


def source(out):
    """The files of the last commit."""
    name = f"sqmap-{backend().version()}"
    file = out / f"{name}.tar.gz"
    subprocess.run(["git", "archive", f"--prefix={name}/", "-o", str(file), "HEAD"], cwd=ROOT, check=True)
    return file


def backend():
    spec = importlib.util.spec_from_file_location("sqmap_backend", ROOT / "python/backend/sqmap_backend.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def wheel(out):
    return out / backend().build_wheel(str(out))


def npm(out):
    package = ROOT / "build/anywhere/npm"
    if not (package / "sqmap.wasm").exists():
        return None
    packed = subprocess.run(["npm", "pack", "--silent", "--pack-destination", str(out), str(package)], check=True, text=True,
                            stdout=subprocess.PIPE, cwd=out)
    return out / packed.stdout.split()[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/archives")
    out = parser.parse_args().out.resolve()
    os.makedirs(out, exist_ok=True)
    status = 0
    for kind, make in {"source": source, "wheel": wheel, "npm": npm}.items():
        file = make(out)
        if file is None:
            print(f"{kind:6} skipped: ./dev anywhere wasm builds it")
            continue
        size = file.stat().st_size
        print(f"{kind:6} {size / 1e6:5.2f} MB  {file}")
        if size > MAX_BYTES.get(kind, size):
            print(f"       more than {MAX_BYTES[kind] / 1e6:g} MB", file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
