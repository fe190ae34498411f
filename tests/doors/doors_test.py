"""A refused mesh, a cured one and one whose model is doubtful through every door: the same notes, each with the door's own names
of settings. Each bake option that has a range is refused by its name where a value is out of it.

usage: doors_test.py PROGRAM DOORS PYTHON_PACKAGE NPM_PACKAGE      SQMAP_LIBRARY names the library that Python and C take.
NPM_PACKAGE is the folder that ./dev anywhere wasm makes. Where it or Node is missing, the C library gives npm's words in its place,
and the test says so."""
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

program, doors, package, npm = sys.argv[1:5]
sys.path.insert(0, package)
import sqmap  # noqa: E402
from sqmap import _library as c  # noqa: E402


def grid(n, lifted):
    """A cube of n x n squares a side, without its lid where it is not lifted from the refused one: text of an OFF file."""
    points, faces = {}, []

    def vertex(p):
        return points.setdefault(p, len(points))

    for axis in range(3):
        for side in (0, n):
            if axis == 2 and side == n and not lifted:
                continue
            for i in range(n):
                for j in range(n):
                    quad = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        p = [0, 0, 0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, i + di, j + dj
                        quad.append(vertex(tuple(p)))
                    faces.append(quad if side else quad[::-1])
    if lifted:  # a hole of one square in a side that a cure fills
        faces.pop(n * n // 2)
    rows = [f"OFF\n{len(points)} {len(faces)} 0"] + [f"{x} {y} {z}" for x, y, z in points]
    return "\n".join(rows + [f"4 {a} {b} {d} {e}" for a, b, d, e in faces]) + "\n"


def plates(count):
    """Thin crossing boxes: maps see little of their surface, so that the model misses its target. Text of an OFF file."""
    points, faces = [], []
    for box in range(count):
        centre = [0.5 * math.sin(a * box + b) for a, b in ((7.1, 1), (3.7, 2), (5.3, 0))]
        half = [0.02 if (k + box) % 3 == 1 else 1 for k in range(3)]
        corners = [[c + h * s for c, h, s in zip(centre, half, (x, y, z))] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        faces += [[len(points) + i for i in quad]
                  for quad in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))]
        points += corners
    rows = [f"OFF\n{len(points)} {len(faces)} 0"] + [f"{x} {y} {z}" for x, y, z in points]
    return "\n".join(rows + [f"4 {a} {b} {d} {e}" for a, b, d, e in faces]) + "\n"


# Meshes that no door takes, a robot's link neither, with the beginnings of their refusals.
UNREADABLE = {
    "nan.off": ("OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "E_NONFINITE", "vertex 2"),
    "index.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "E_INDEX", "face 1"),
    "empty.off": ("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "E_EMPTY", "mesh"),
    "cut.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n", "E_TRUNCATED", ""),
}
SHEET = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"


def through_c(path, words):
    """Notes or the refusal with the words of C (0), Python (1) or JavaScript (2)."""
    handle, options = c.Handle(), c.BakeOptions(words=words)
    try:
        c.call("sqmap_bake_file", str(path).encode(), options, handle)
    except sqmap.Error as e:
        cure = c.library.sqmap_last_cure(words).decode()
        assert words != 0 or cure == c.library.sqmap_last_error().contents.cure.decode()
        return {"code": e.code, "element": e.element, "message": e.message, "cure": cure}
    try:
        return {"notes": c.text_of("sqmap_notes", handle).splitlines()}
    finally:
        c.call("sqmap_close_model", handle)


def through_python(path):
    try:
        with sqmap.bake(path) as model:
            return {"notes": model.notes}
    except sqmap.MeshError as e:
        return {"code": e.code, "element": e.element, "message": e.message, "cure": e.cure}


def through_npm(path):
    """The package itself under Node; the C library with the package's words where either is missing."""
    if shutil.which("node") is None or not (pathlib.Path(npm) / "sqmap.wasm").exists():
        return through_c(path, 2)
    script = pathlib.Path(__file__).with_name("doors.mjs")
    return json.loads(subprocess.run(["node", script, npm, path], capture_output=True, text=True, check=True).stdout)


def through_program(path, folder):
    """The report's notes, all of which stand in what is printed too."""
    report = folder / "report.json"
    run = subprocess.run([program, "bake", path, "-o", folder / "a.sqmap", "--report", report], capture_output=True, text=True)
    if run.returncode == 0:
        notes = json.loads(report.read_text())["notes"]
        assert all(note in run.stdout for note in notes), (notes, run.stdout)
        return {"notes": notes}
    verdict = json.loads(subprocess.run([program, "check", path, "--json"], capture_output=True, text=True).stdout)
    return {k: verdict[k] for k in ("code", "element", "message", "cure")}


def through_urdf(path, folder):
    """The refusal of a mesh that a robot's link names: one sentence, which names the file beside the element."""
    robot, report = folder / "robot.urdf", folder / "robot.json"
    robot.write_text(f'<robot name="r"><link name="l"><collision><geometry><mesh filename="{path.name}"/></geometry></collision>'
                     "</link></robot>")
    subprocess.run([program, "urdf", robot, "-o", folder / "made.urdf", "--report", report], capture_output=True)
    found = re.fullmatch(r"(E_\w+) at (.*): (.*) \((.*)\)", json.loads(report.read_text())[0]["problem"])
    code, where, message, cure = found.groups()
    assert where.startswith(f"{path}, "), where
    return {"code": code, "element": where[len(f"{path}, "):], "message": message, "cure": cure}


def through_batch(folder):
    """Answers by name of file."""
    library = folder / "library"
    subprocess.run([program, "batch", folder, "-o", library, "--no-pictures"], capture_output=True, check=True)
    listed = subprocess.run([program, "batch", "list", library, "--json"], capture_output=True, text=True, check=True).stdout
    rows = {r["path"]: r for r in map(json.loads, listed.splitlines())}
    return {name: {"notes": r["notes"]} if "notes" in r
            else {"code": r["code"], "element": r["element"], "message": r["reason"], "cure": r["cure"]}
            for name, r in rows.items()}


# Each member of BakeRanges (sqmap/bake/bake_types.h) as the program, Python, JavaScript and the page call it; None where a door leaves
# it out on purpose: the paper's thresholds are set in C, Python and the program alone, and the page draws no distances to set a band for.
OPTIONS = {
    "target_error": ("--target-error", "target_error", "targetError", "target_error"),
    "max_parts": ("--max-parts", "max_parts", "maxParts", "max_parts"),
    "max_looseness": ("--max-looseness", "paper.max_looseness", None, None),
    "max_q2_share": ("--max-q2", "paper.max_q2", None, None),
    "band": ("--band", "band", "band", None),
}


def check_options(mesh):
    """Every range has a row, and a value beyond it is refused by its name at each door that can be opened here."""
    root = pathlib.Path(__file__).resolve().parents[2]
    source = lambda path: (root / path).read_text(encoding="utf-8")
    ranges = re.search(r"struct BakeRanges \{(.*?)\};", source("include/sqmap/bake/bake_types.h"), re.DOTALL)[1]
    assert set(re.findall(r"(\w+)\{", ranges)) == set(OPTIONS), "a range of BakeRanges has no row in OPTIONS"
    settings = re.search(r"const bakeSettings = \[(.*?)\];", source("js/index.js"), re.DOTALL)[1]
    types, reader, form = source("js/index.d.ts"), source("apps/viewer/server/scene/uploads.cpp"), source(
        "apps/viewer/web/src/panels/files.ts")
    for option, python, javascript, page in OPTIONS.values():
        run = subprocess.run([program, "bake", mesh, "-o", mesh.with_suffix(".sqmap"), option, "1e9"], capture_output=True, text=True)
        assert run.returncode == 64 and option in run.stderr, (option, run)
        *of_paper, keyword = python.split(".")
        wrong = {"paper": sqmap.PaperOptions(**{keyword: 10**9})} if of_paper else {keyword: 10**9}
        try:
            sqmap.bake(mesh, **wrong)
            raise AssertionError(f"{python} takes 1e9")
        except sqmap.ArgumentError as e:
            assert e.element == python, (e.element, python)
        if javascript is not None:
            assert f'"{javascript}"' in settings and f"{javascript}?:" in types, javascript
        if page is not None:
            assert f'take_setting(target, "{page}", bake::k_bake_ranges.' in reader and re.search(rf"\b{page}\b", form), page


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    cured, refused, doubtful = folder / "cured.off", folder / "refused.off", folder / "doubtful.off"
    cured.write_text(grid(6, True))
    refused.write_text(SHEET)
    doubtful.write_text(plates(6))
    for bad, (text, _, _) in UNREADABLE.items():
        (folder / bad).write_text(text)
    check_options(cured)
    batch = through_batch(folder)
    expected = {cured: ("moved: ", "made up: "), doubtful: ("W_SELFX: ", "W_TARGET: ", "W_LAYER3: "), refused: ()}
    expected |= {folder / bad: () for bad in UNREADABLE}
    for path, beginnings in expected.items():
        answers = json.loads(subprocess.run([doors, path], capture_output=True, text=True, check=True).stdout)
        answers |= {"program": through_program(path, folder), "c": through_c(path, 0), "python": through_python(path),
                    "batch": batch[path.name], "javascript": through_npm(path)}
        first = answers["program"]
        if path.name in UNREADABLE:
            _, code, element = UNREADABLE[path.name]
            assert first["code"] == code and first["element"].startswith(element), first
            answers["urdf"] = through_urdf(path, folder)
            assert answers["urdf"]["cure"] == first["cure"], (answers["urdf"], first)
        for door, answer in answers.items():
            same = {k: v for k, v in answer.items() if k != "cure"}
            wanted = {k: v for k, v in first.items() if k != "cure"}
            assert same == wanted, (path.name, door, answer, first)
        for beginning in beginnings:
            assert any(note.startswith(beginning) for note in first["notes"]), (path.name, beginning, first)
        if path == refused:
            assert "--thickness T" in first["cure"], first
            for door, own in (("cpp", "AdmitOptions::thickness = T"), ("c", "thickness = T"), ("python", "thickness=T"),
                              ("javascript", "thickness: T"), ("page", "\u201cSheets are\u201d: T")):
                assert own in answers[door]["cure"] and "--" not in answers[door]["cure"], answers[door]
print("every door says the same")
if shutil.which("node") is None or not (pathlib.Path(npm) / "sqmap.wasm").exists():
    print("skipped in part: npm's door, whose words the C library gave: install nodejs and emscripten, run ./dev anywhere wasm")
