"""One refused and one cured mesh through every door: the same notes, each with the door's own names of settings.

usage: doors_test.py PROGRAM DOORS PYTHON_PACKAGE      SQMAP_LIBRARY names the library that Python and C take"""
import json
import pathlib
import subprocess
import sys
import tempfile

program, doors, package = sys.argv[1:4]
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


SHEET = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"


def through_c(path, words):
    """Notes or the refusal with the words of C (0), Python (1) or JavaScript (2)."""
    handle, options = c.Handle(), c.BakeOptions(words=words)
    try:
        c.call("sqmap_bake_file", str(path).encode(), options, handle)
    except sqmap.Error as e:
        return {"code": e.code, "element": e.element, "message": e.message, "cure": e.cure}
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


def through_program(path, folder):
    report = folder / "report.json"
    run = subprocess.run([program, "bake", path, "-o", folder / "a.sqmap", "--report", report], capture_output=True, text=True)
    if run.returncode == 0:
        return {"notes": json.loads(report.read_text())["notes"]}
    verdict = json.loads(subprocess.run([program, "check", path, "--json"], capture_output=True, text=True).stdout)
    return {k: verdict[k] for k in ("code", "element", "message", "cure")}


def through_batch(folder):
    """Answers by name of file."""
    library = folder / "library"
    subprocess.run([program, "batch", folder, "-o", library, "--no-pictures"], capture_output=True, check=True)
    listed = subprocess.run([program, "batch", "list", library, "--json"], capture_output=True, text=True, check=True).stdout
    rows = {r["path"]: r for r in map(json.loads, listed.splitlines())}
    return {name: {"notes": r["notes"]} if "notes" in r
            else {"code": r["code"], "element": r["element"], "message": r["reason"], "cure": r["cure"]}
            for name, r in rows.items()}


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    cured, refused = folder / "cured.off", folder / "refused.off"
    cured.write_text(grid(6, True))
    refused.write_text(SHEET)
    batch = through_batch(folder)
    for path in (cured, refused):
        answers = json.loads(subprocess.run([doors, path], capture_output=True, text=True, check=True).stdout)
        answers |= {"program": through_program(path, folder), "c": through_c(path, 0), "python": through_python(path),
                    "batch": batch[path.name],
                    "javascript's words": through_c(path, 2)}
        first = answers["program"]
        for door, answer in answers.items():
            same = {k: v for k, v in answer.items() if k != "cure"}
            wanted = {k: v for k, v in first.items() if k != "cure"}
            assert same == wanted, (path.name, door, answer, first)
        if path == cured:
            assert any(n.startswith("moved: ") for n in first["notes"]), first
            assert any(n.startswith("made up: ") for n in first["notes"]), first
        else:
            assert "--thickness T" in first["cure"], first
            for door, own in (("cpp", "AdmitOptions::thickness = T"), ("c", "thickness = T"), ("python", "thickness=T"),
                              ("javascript's words", "thickness: T"), ("page", "\u201cSheets are\u201d: T")):
                assert own in answers[door]["cure"] and "--" not in answers[door]["cure"], answers[door]
print("every door says the same")
