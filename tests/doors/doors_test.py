"""A refused mesh, a cured one and one whose model is doubtful through every door: the same notes, each with the door's own names
of settings. Every member of the structs of options is set by every door, or the table here says why not; out of its range it is
refused by its name. A file that is not there is refused in the same words.

usage: doors_test.py PROGRAM DOORS PYTHON_PACKAGE NPM_PACKAGE      SQMAP_LIBRARY names the library that Python and C take.
NPM_PACKAGE is the folder that ./dev anywhere wasm makes. Where it or Node is missing, the C library gives npm's words in its place,
and the test says so."""
import inspect
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


# Each member of a struct of options: the program's option, the member in C, the keyword of Python, that of JavaScript, the setting of
# the page. None where a door leaves it out: C++, the program, C and Python alone set the paper's thresholds; the page draws no
# distances, bakes the exact layer always and has limits of its own; JavaScript has one thread. A text says why no door has it.
paper = lambda name, program=None: (program or "--" + name.replace("_", "-"), name, f"paper.{name}", None, None)
limit = lambda program: (program, None, None, None, None)  # of a machine, not of a model: C++ and the program alone
every = lambda name: ("--" + name.replace("_", "-"), name, name, re.sub(r"_(\w)", lambda m: m[1].upper(), name), name)
but_page = lambda name: (*every(name)[:4], None)
of_pipeline = "the target error decides"
OPTIONS = {
    "bake/bake_types.h BakeOptions": {
        "target_error": every("target_error"), "max_parts": every("max_parts"), "band": but_page("band"),
        "max_looseness": paper("max_looseness"), "max_q2_share": paper("max_q2"),
        "exact": ("--no-exact", "without_exact", "exact", "exact", None),
        "locator": ("--no-locator", "without_locator", "locator", "locator", None),
        "keep_input": ("--no-input", "without_input", "keep_input", "keepInput", None),
        "threads": (None, "threads", "threads", None, None), "progress": (None, "progress", "progress", "progress", None),
        "decompose": "a struct of its own", "fit": "a struct of its own", "partition": "parts edited by hand", "cured": "filled in",
        "source": "filled in"},
    "decompose/decompose.h DecomposeOptions": {
        "protrusion": paper("exact_geodesics"), "protrusion_sources": paper("protrusion_sources"),
        **{name: paper(name) for name in (
            "salient_window", "salient_prominence", "locale_width", "boundary_strength", "protrusion_ratio", "boundary_concavity",
            "curvature_window", "curvature_floor", "hyperbolic_share", "hyperbolic_curvature", "fragment_roundness",
            "printed_strength", "printed_curvature")},
        "minimum_part_area": paper("minimum_part"), "cutting": paper("cuts"), "curvature_mean": paper("mean_curvature"),
        "max_parts": "BakeOptions::max_parts bounds it"},
    "fit/fit.h FitOptions": {
        "allow_taper": ("--no-taper", "without_taper", "paper.taper", None, None),
        "allow_bend": ("--no-bend", "without_bend", "paper.bend", None, None),
        **dict.fromkeys(("residual", "max_iterations", "max_samples", "min_exponent", "max_exponent", "max_overhang", "taper_gain",
                         "bend_gain"), "of one fit; tests and measurements set it")},
    "paper/bake.h MapOptions": {
        "grid": ("--grid", "rows", "paper.grid", None, None), "subdivisions": paper("subdivisions"),
        "offset_constant": paper("offset_constant"), "offset_radius": paper("offset_radius"), "smoothing": paper("smoothing"),
        "smoothing_length": paper("smoothing_length"), "smoothing_radius": paper("smoothing_radius"),
        "smoothing_kernel": paper("smoothing_kernel"), "target_error": of_pipeline, "min_level": of_pipeline,
        "max_level": of_pipeline, "correction_threshold": of_pipeline, "jump_slope": of_pipeline,
        "corrections": "step 3 of the paper is no choice", "gaps": "a query's option leaves them out"},
    "mesh/admission.h AdmitOptions": {
        "repair": every("repair"), "accept_surface": ("--surface", "accepts_surface", "surface", "surface", "surface"),
        "thickness": every("thickness"), "unit": every("unit"), "solid": but_page("solid"), "gap": but_page("gap"),
        "max_filled": limit("--max-filled"), "max_cured_faces": limit("--max-cured-faces"),
        "max_components": limit("--max-components"), "wrap": "a struct of its own", "refine_fillings": "tests alone set it",
        "max_intersections": "a count in a warning"},
    "mesh/wrap.h WrapOptions": {
        "tolerance": but_page("wrap_tolerance"), "max_triangles": limit("--max-wrapped-faces"), "max_cells": limit("--max-cells"),
        "thickness": "follows from the tolerance"},
}


def members_of(struct):
    """Names of the members of a public header's struct."""
    header, kind = struct.split()
    body = re.search(rf"struct {kind} \{{\n(.*?)\n\}};", source(f"include/sqmap/{header}"), re.DOTALL)[1]
    statements = re.sub(r"//[^\n]*", "", body).split(";")
    return [re.search(r"(\w+)\s*$", re.split(r"=|\{", s)[0])[1] for s in statements if s.strip() and "operator" not in s]


root = pathlib.Path(__file__).resolve().parents[2]
source = lambda path: (root / path).read_text(encoding="utf-8")


def check_doors():
    """Every member has a row, and every door has the row's name of it."""
    settings = re.search(r"const bakeSettings = \[(.*?)\];", source("js/index.js"), re.DOTALL)[1]
    types, header = source("js/index.d.ts"), source("include/sqmap.h")
    in_c = "".join(re.search(rf"typedef struct {s} \{{(.*?)\}} {s};", header, re.DOTALL)[1]
                   for s in ("sqmap_bake_options", "sqmap_paper_options"))
    reader, form = source("apps/viewer/server/scene/uploads.cpp"), source("apps/viewer/web/src/panels/files.ts")
    help_text = subprocess.run([program, "bake", "--help"], capture_output=True, text=True, check=True).stdout
    python = {*inspect.signature(sqmap.bake).parameters,
              *(f"paper.{name}" for name in inspect.signature(sqmap.PaperOptions).parameters)}
    for struct, rows in OPTIONS.items():
        assert set(members_of(struct)) == set(rows), (struct, set(members_of(struct)) ^ set(rows))
        for member, row in rows.items():
            if isinstance(row, str):
                continue
            option, c_name, keyword, javascript, page = row
            assert option is None or re.search(rf"^ *{option}\b", help_text, re.MULTILINE), (member, option)
            assert c_name is None or re.search(rf"\b{c_name}\b", in_c), (member, c_name)
            assert keyword is None or keyword in python, (member, keyword)
            assert javascript is None or (f'"{javascript}"' in settings and f"{javascript}?:" in types), (member, javascript)
            assert page is None or (f'"{page}"' in reader and re.search(rf"\b{page}\b", form)), (member, page)


def check_ranges(mesh):
    """Every number of the library has a row; a value beyond its range is refused by its name at each door that can be opened here."""
    ranges = json.loads(subprocess.run([doors, "--options"], capture_output=True, text=True, check=True).stdout)
    rows = {row[1] or row[0].lstrip("-").replace("-", "_"): row for rows in OPTIONS.values() for row in rows.values() if len(row) == 5}
    rows["columns"] = rows["rows"]
    for name, (least, greatest) in ranges.items():
        option, c_name, keyword, *_ = rows[name]
        assert c.option_range(name) == (least, greatest), name
        for value in (2 * greatest + 1, *([least / 2] if 0 < least < 1 else [])):
            given = f"{value:.0f}x{value:.0f}" if option == "--grid" else f"{value:.17g}"
            run = subprocess.run([program, "bake", mesh, "-o", mesh.with_suffix(".sqmap"), option, given], capture_output=True, text=True)
            assert run.returncode == 64 and option in run.stderr, (option, run)
            if keyword is None:
                continue
            *of_paper, word = keyword.split(".")
            whole = (int(value), int(value)) if word == "grid" else int(value) if greatest < 1e5 + 1 and value == int(value) else value
            try:
                sqmap.bake(mesh, **({"paper": sqmap.PaperOptions(**{word: whole})} if of_paper else {word: whole}))
                raise AssertionError(f"{word} takes {value}")
            except sqmap.ArgumentError as e:
                assert e.element.split(".")[-1] == word, (e.element, word)
    check_page(ranges)


def check_page(ranges):
    """The ranges that docs/paper-claims.md lists are the library's."""
    names = {row[0]: row[1] or row[0].lstrip("-").replace("-", "_") for rows in OPTIONS.values() for row in rows.values() if len(row) == 5}
    column, found = None, set()
    for line in source("docs/paper-claims.md").splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if "range" in cells:
            column = cells.index("range")
        elif column and len(cells) > column and (range_ := re.fullmatch(r"([\d.]+)(?: \([\w ]+\))? to ([\d.^]+)", cells[column])):
            least, greatest = (float(end.replace("10^6", "1e6")) for end in range_.groups())
            for option in re.findall(r"`(--[\w-]+)`", cells[2]):
                if names.get(option) in ranges:
                    assert tuple(ranges[names[option]]) == (least, greatest), (option, line)
                    found.add(option)
    assert len(found) > 20, found


def check_zero(mesh):
    """A band of zero is one at each door, and no default."""
    model = mesh.with_suffix(".sqmap")
    subprocess.run([program, "bake", mesh, "-o", model, "--band", "0"], capture_output=True, check=True)
    with sqmap.Model.load(model) as baked, sqmap.bake(mesh, band=0) as own:
        assert baked.facts.band == own.facts.band == 0, (baked.facts.band, own.facts.band)
    handle, options, facts = c.Handle(), c.BakeOptions(band=-1), c.Facts()
    c.call("sqmap_bake_file", str(mesh).encode(), options, handle)
    c.call("sqmap_model_facts", handle, facts)
    c.call("sqmap_close_model", handle)
    assert facts.band == 0, facts.band


def check_locator(mesh):
    """Without its locator a model has no exact layer and is smaller, from each door; a paper model has none to leave out."""
    model, saved = mesh.with_suffix(".sqmap"), mesh.with_suffix(".own.sqmap")
    subprocess.run([program, "bake", mesh, "-o", model, "--no-locator"], capture_output=True, check=True)
    with sqmap.Model.load(model) as baked, sqmap.bake(mesh, locator=False) as own, sqmap.bake(mesh) as whole:
        assert not baked.facts.has_exact and not own.facts.has_exact and whole.facts.has_exact
        own.save(saved)
        sizes = [saved.stat().st_size, model.stat().st_size, whole.facts.bytes]
        assert max(sizes[:2]) < 0.5 * sizes[2], sizes
    try:
        sqmap.bake(mesh, projection="normal", locator=False)
        raise AssertionError("a paper model is baked without what it never has")
    except sqmap.ArgumentError as e:
        assert e.element == "locator" and e.cure == "leave it out", e


def check_missing(path):
    """No file: its path, the same words and the same cure at each door; the program's exit code is that of wrong usage."""
    run = subprocess.run([program, "bake", path, "-o", path.with_suffix(".sqmap")], capture_output=True, text=True)
    assert run.returncode == 64 and f"{path}: no such file (check the path)" in run.stderr, run
    wanted = {"code": "E_FILE", "element": str(path), "message": "no such file", "cure": "check the path"}
    answers = json.loads(subprocess.run([doors, path], capture_output=True, text=True, check=True).stdout)
    answers |= {"c": through_c(path, 0), "javascript": through_c(path, 2)}
    try:
        sqmap.bake(path)
    except sqmap.FileError as e:
        answers["python"] = {"code": e.code, "element": e.element, "message": e.message, "cure": e.cure}
    for door, answer in (answers | {"python": answers.get("python")}).items():
        assert answer == wanted, (door, answer)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    cured, refused, doubtful = folder / "cured.off", folder / "refused.off", folder / "doubtful.off"
    cured.write_text(grid(6, True))
    refused.write_text(SHEET)
    doubtful.write_text(plates(6))
    for bad, (text, _, _) in UNREADABLE.items():
        (folder / bad).write_text(text)
    check_doors()
    check_ranges(cured)
    check_zero(cured)
    check_locator(cured)
    check_missing(folder / "none.off")
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
