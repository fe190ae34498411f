#!/usr/bin/env python3
"""Builds sqmap for other systems and compares their answers with this machine's, bit by bit: ./dev anywhere [DOOR...].

Doors: python, arm64 (run by qemu), windows (run by wine), wasm (run by Node; the npm package is build/anywhere/npm), debian13 (a
bare root made by mmdebstrap, in which ./dev test quick and pip run), page (build/anywhere/page: the viewer without a server, for any
static host; tested with the npm package in Chromium). A door whose programs or packages are not here is
skipped, and the last lines say why. Exit 0 unless a door that ran fails."""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/anywhere"
NATIVE = ROOT / "build/release"
PROGRAMS = ROOT / "tests/anywhere"
WEB = ROOT / "apps/viewer/web"
PAGE = BUILD / "page"  # a folder for any static host, with the viewer's program in a worker; the documentation site takes it too
SHAPES = ("hand", "dumbbell")  # the page begins with the first
HEADERS = ("hwy", "flatbuffers", "nlohmann", "CLI", "fast_float", "eigen3")


class Skip(Exception):
    """A door that cannot be tried here."""


class Failed(Exception):
    """A door whose answers differ."""


def run(*command, cwd=ROOT, env=None):
    """The output of a command. Raises Failed with its last lines."""
    done = subprocess.run([str(c) for c in command], cwd=cwd, env={**os.environ, **(env or {})}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if done.returncode != 0:
        raise Failed(f"{' '.join(map(str, command))} ended with {done.returncode}:\n" + "\n".join(done.stdout.splitlines()[-20:]))
    return done.stdout


def need(packages, *programs):
    """Raises Skip where one of the programs is not here."""
    if any(shutil.which(program) is None for program in programs):
        raise Skip(f"missing here: apt-get install {packages}")


def gather_headers():
    """Headers and CMake packages that belong to no processor, apart from this machine's C headers."""
    prefix = BUILD / "prefix"
    (prefix / "include").mkdir(parents=True, exist_ok=True)
    for name in HEADERS:
        source, link = pathlib.Path("/usr/include") / name, prefix / "include" / name
        if not source.exists():
            raise Skip(f"/usr/include/{name} is not here: apt-get install libhwy-dev libflatbuffers-dev nlohmann-json3-dev "
                       "libcli11-dev libfast-float-dev libeigen3-dev")
        if not link.exists():
            link.symlink_to(source)
    for folder in ("cmake/nlohmann_json", "cmake/CLI11", "eigen3/cmake"):
        shutil.copytree(pathlib.Path("/usr/share") / folder, prefix / "share" / folder, dirs_exist_ok=True)
    return prefix


def build(door, *targets):
    """Configures a door's build with its toolchain file and builds targets."""
    folder = BUILD / door
    run("cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", f"-DSQMAP_PREFIX={gather_headers()}",
        f"-DCMAKE_TOOLCHAIN_FILE={ROOT}/cmake/toolchains/{door}.cmake", "-DSQMAP_BUILD_TESTS=OFF", "-DSQMAP_BUILD_BENCH=OFF",
        f"-DSQMAP_BUILD_APPS={'ON' if 'sqmap' in targets else 'OFF'}")
    run("cmake", "--build", folder, "-j", os.environ.get("SQMAP_JOBS", "1"), "--target", *targets)
    return folder


def native_programs():
    """answers and bake on this machine."""
    for name in ("answers", "bake"):
        run("cc", "-std=c11", "-O1", "-Iinclude", PROGRAMS / f"{name}.c", "-o", BUILD / name, f"-L{NATIVE}/src/capi", "-lsqmap",
            f"-Wl,-rpath,{NATIVE}/src/capi", "-lm")


def prepare():
    """Meshes, what bakes are told of them, this machine's models and their answers: [((mesh, option...), model, answers)]."""
    BUILD.mkdir(parents=True, exist_ok=True)
    native_programs()
    program = NATIVE / "bin/sqmap"
    torus = BUILD / "torus.obj"
    run(program, "shapes", "torus", "-o", torus)
    meshes = [torus]
    shared = pathlib.Path(os.environ.get("SQMAP_SHARED_DIR", ROOT.parent / "shared")) / "meshes"
    for folder in (shared, ROOT / "build/demo/meshes"):
        meshes += [m for m in sorted(folder.glob("hand_*.obj"))[:1] + sorted(folder.glob("cow*.off"))[:1]]
    cases = []
    for mesh, *options in [*((mesh,) for mesh in meshes), (torus, "normal")]:
        model = BUILD / f"{'_'.join([mesh.stem, *options])}.sqmap"
        run(BUILD / "bake", mesh, model, *options)
        cases.append(((mesh, *options), model, run(BUILD / "answers", model)))
    return cases


def compare_answers(cases, *command, env=None, path=str):
    for _, model, expected in cases:
        found = run(*command, path(model), env=env).replace("\r", "")
        if found != expected:
            raise Failed(f"{model.name}: this machine\n{expected}\nthere\n{found}")
    return f"the same bits on {len(cases)} models, 100,000 points, all layers and distances"


def depth_error(model):
    """The 99th percentile of layer 3's depth error and its wrong verdicts, measured again by this machine."""
    for line in run(NATIVE / "bin/sqmap", "info", model).splitlines():
        if line.strip().startswith("depth:"):
            return line.strip()
    raise Failed(f"{model}: sqmap info prints no depth")


def compare_bakes(cases, door, bake):
    """Bakes every mesh there; bake(model, mesh, option...)."""
    said = []
    for subject, model, _ in cases:
        there = BUILD / door / model.name
        begin = time.monotonic()
        bake(there, *subject)
        seconds = time.monotonic() - begin
        same = there.read_bytes() == model.read_bytes()
        if not same and depth_error(there).split(";")[0] != depth_error(model).split(";")[0]:
            said.append(f"{model.stem}: here {depth_error(model)}, there {depth_error(there)}")
        said.append(f"{model.stem} baked in {seconds:.1f} s: {'the same bytes' if same else 'other bytes'}")
    return said


def compile_programs(folder, compiler, *libraries):
    for name in ("answers", "bake"):
        suffix = ".exe" if "mingw" in compiler else ""
        run(compiler, "-std=c11", "-O1", "-Iinclude", PROGRAMS / f"{name}.c", "-o", folder / f"bin/{name}{suffix}", *libraries)


def door_python(cases):
    if subprocess.run(["/usr/bin/python3", "-c", "import numpy"], check=False, capture_output=True).returncode != 0:
        raise Skip("missing here: apt-get install python3-numpy")
    env = {"SQMAP_LIBRARY": str(NATIVE / "src/capi/libsqmap.so"), "PYTHONPATH": str(ROOT / "python")}
    return [compare_answers(cases, "/usr/bin/python3", PROGRAMS / "answers.py", env=env)]


def door_arm64(cases):
    need("g++-aarch64-linux-gnu qemu-user", "aarch64-linux-gnu-g++", "qemu-aarch64")
    folder = build("arm64", "sqmap_c")
    (folder / "bin").mkdir(exist_ok=True)
    compile_programs(folder, "aarch64-linux-gnu-gcc", f"-L{folder}/src/capi", "-lsqmap", f"-Wl,-rpath,{folder}/src/capi", "-lm")
    emulator = ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu")
    said = [compare_answers(cases, *emulator, folder / "bin/answers")]
    said += compare_bakes(cases, "arm64", lambda model, mesh, *options: run(*emulator, folder / "bin/bake", mesh, model, *options))
    if any("other bytes" in line for line in said):
        raise Failed("\n".join(said))
    return said


def windows_path(path):
    return "Z:" + str(path).replace("/", "\\")


def door_windows(cases):
    need("g++-mingw-w64-x86-64-posix wine wine64", "x86_64-w64-mingw32-g++-posix", "wine")
    folder = build("windows", "sqmap_c", "sqmap")
    compile_programs(folder, "x86_64-w64-mingw32-gcc-posix", folder / "src/capi/libsqmap.dll.a", "-static")
    env = {"WINEPREFIX": str(BUILD / "wine"), "WINEDEBUG": "-all"}
    run("wine", "cmd", "/c", "exit", env=env)  # makes its folder, and says so
    said = [compare_answers(cases, "wine", folder / "bin/answers.exe", env=env, path=windows_path)]
    said += compare_bakes(cases, "windows", lambda model, mesh, *options: run("wine", folder / "bin/bake.exe", windows_path(mesh),
                                                                              windows_path(model), *options, env=env))
    program = folder / "bin/sqmap.exe"
    for command in ("shapes torus -o shape.obj", "check shape.obj", "bake shape.obj -o shape.sqmap"):
        run("wine", program, *command.split(), cwd=folder, env=env)
    there = run("wine", program, "info", "shape.sqmap", cwd=folder, env=env).replace("\r", "")
    here = run(NATIVE / "bin/sqmap", "info", "shape.sqmap", cwd=folder)
    if there != here:
        raise Failed(f"sqmap info says there\n{there}\nand here\n{here}")
    return [*said, "the program makes a shape, checks and bakes it, and sqmap info says there of that model what it says here"]


def build_wasm(target):
    need("emscripten nodejs", "emcc", "node")
    # Debian's emscripten finds its modules of Node there, whoever's Node runs it.
    os.environ.setdefault("NODE_PATH", "/usr/share/nodejs:/usr/lib/nodejs")
    return build("wasm", target) / "bin"


def npm_package():
    """The npm package, in its folder."""
    built, package = build_wasm("sqmap_core"), BUILD / "npm"
    shutil.copytree(ROOT / "js", package, dirs_exist_ok=True)
    shutil.copy(ROOT / "LICENSE", package)
    shutil.copy(built / "core.mjs", package / "core.js")
    shutil.copy(built / "core.wasm", package / "sqmap.wasm")
    return package


def door_wasm(cases):
    package = npm_package()
    size = sum(f.stat().st_size for f in package.iterdir())
    said = [f"the npm package is {size / 1e6:.2f} MB: {package}",
            compare_answers(cases, "node", PROGRAMS / "answers.mjs", package)]
    said += compare_bakes(cases, "wasm", lambda model, mesh, *options: run("node", PROGRAMS / "bake.mjs", package, mesh, model, *options))
    for test in ("package_test", "arguments"):
        said += run("node", PROGRAMS / f"{test}.mjs", package).splitlines()[-1:]
    said += run("node", PROGRAMS / "guide_test.mjs", package, ROOT / "docs/guide/javascript.md").splitlines()[-1:]
    return [*said, *run("node", PROGRAMS / "building_test.mjs", package, ROOT / "build/readers/node_modules/web-ifc",
                        ROOT / "examples/14_building.mjs").splitlines()[-1:]]


def can_build_page():
    """True where npm's packages are here."""
    return shutil.which("npm") is not None and all((WEB / "node_modules" / name).is_dir() for name in ("vite", "iwer"))


def bake_shapes(folder):
    """Shapes that the project makes itself, as models."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in SHAPES:
        mesh = folder / f"{name}.obj"
        for command in (["shapes", name, "-o", mesh], ["bake", mesh, "-o", folder / f"{name}.sqmap", "--exact"]):
            subprocess.run([NATIVE / "bin/sqmap", *command], check=True, stdout=subprocess.DEVNULL)
        mesh.unlink()


def assemble_page(program):
    """program: the folder with program.mjs and program.wasm. The finished folder."""
    subprocess.run(["npm", "run", "--silent", "build", "--", "--outDir", PAGE, "--emptyOutDir", "--logLevel", "error"], cwd=WEB,
                   check=True, stderr=subprocess.DEVNULL)
    for file in (program / "program.mjs", program / "program.wasm", ROOT / "apps/viewer/page/worker.js", ROOT / "LICENSE"):
        shutil.copy(file, PAGE)
    bake_shapes(PAGE / "models")
    index = PAGE / "index.html"
    text = index.read_text()
    begin = '<html lang="en">'
    if begin not in text:
        raise SystemExit(f"{index}: has no {begin}")
    index.write_text(text.replace(begin, f'<html lang="en" data-worker="worker.js" data-models="models/{SHAPES[0]}.sqmap">'))
    return PAGE


def door_page(cases):
    if not can_build_page():
        raise Skip("missing here: npm's packages, which ./dev view installs")
    package, page = npm_package(), assemble_page(build_wasm("sqmap_page"))
    size = sum(f.stat().st_size for f in page.rglob("*") if f.is_file())
    said = [f"the page is {size / 1e6:.2f} MB, models included: {page}"]
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        return [*said, "not tested: apt-get install chromium"]
    for model, answers in [(model, answers) for _, model, answers in cases]:
        model.with_suffix(".answers").write_text(answers)
    said += run("node", ROOT / "tests/browser/static_test.mjs", page, chromium, BUILD / "browser", package,
                *[model for _, model, _ in cases]).splitlines()
    return said


def door_debian13(cases):
    need("mmdebstrap", "mmdebstrap", "unshare")
    if os.geteuid() != 0:
        raise Skip("needs root")
    root = BUILD / "debian13"
    if not (root / "etc/os-release").exists():
        source = "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian trixie main"
        try:
            run("mmdebstrap", "--variant=minbase", "--mode=root", "trixie", root, source)
        except Failed as e:
            raise Skip(f"no Debian 13 can be made here: {str(e).splitlines()[-1]}") from e
    inside = root / "sqmap"
    for name in run("git", "ls-files", "--cached", "--others", "--exclude-standard").split("\n")[:-1]:
        (inside / name).parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).exists():
            shutil.copy2(ROOT / name, inside / name)
    enter = ("unshare", "--mount", "bash", "-c", 'mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$0" "$@"', root,
             "env", "-i", "HOME=/root", "PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
             *(f"SQMAP_JOBS={jobs}" for jobs in [os.environ.get("SQMAP_JOBS")] if jobs))  # nothing else of this system
    run(*enter, "bash", "-c", "cd /sqmap && ./dev test quick > /test.log 2>&1 || { tail -30 /test.log; exit 1; }")
    said = [line for line in (root / "test.log").read_text().splitlines() if " tests passed" in line]
    script = ("set -e; cd /sqmap; rm -rf /venv; python3 -m venv --system-site-packages /venv; "
              "SQMAP_LIBRARY=/sqmap/build/release/src/capi/libsqmap.so /venv/bin/pip install --no-index --no-build-isolation -q ./python; "
              "build/release/bin/sqmap shapes torus -o /torus.obj; "
              "/venv/bin/python -c \"import sqmap; print(sqmap.bake('/torus.obj').signed_distance([[1, 0, 0]]))\"")
    said.append(f"pip install ./python; it bakes a torus, and 1 0 0 is inside by {run(*enter, 'bash', '-c', script).split()[-1]}")
    for _, model, _ in cases:
        shutil.copy(model, root / model.name)
    answers = (*enter, "/sqmap/build/release/bin/capi_answers_c")
    return [compare_answers(cases, *answers, path=lambda model: f"/{model.name}"), *said]


DOORS = {"python": door_python, "arm64": door_arm64, "windows": door_windows, "wasm": door_wasm, "page": door_page,
         "debian13": door_debian13}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("doors", nargs="*", metavar="DOOR", help=f"of {', '.join(DOORS)}; none: all")
    wanted = parser.parse_args().doors or list(DOORS)
    if unknown := [d for d in wanted if d not in DOORS]:
        parser.error(f"there is no door {unknown[0]}; there are {', '.join(DOORS)}")
    cases = prepare()
    lines, status = [], 0
    for door in wanted:
        print(f"==> {door}", flush=True)
        try:
            said = DOORS[door](cases)
            lines += [f"{door:9} passed   {line}" if i == 0 else f"{'':9}          {line}" for i, line in enumerate(said)]
        except Skip as e:
            lines.append(f"{door:9} skipped  {e}")
        except Failed as e:
            lines.append(f"{door:9} FAILED   {e}")
            status = 1
    print("\n".join(lines))
    return status


if __name__ == "__main__":
    sys.exit(main())
