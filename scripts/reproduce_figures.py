"""Turns the numbers of reproduce.py into files: CSV, plots, tables. One function a figure of the paper."""
import csv
import dataclasses
import math
import statistics

import numpy
from matplotlib import collections as shapes

import docs_images
import measure
import plot
from plot import BLUE, GREEN, GREY, INK, ORANGE, RED, VIOLET

# Table 1 of the paper: polygons, DF, ADF and SQ in MB, segments.
PAPER = {
    "Virtual hand": (9344, 344, 55, 4.6, 16),
    "Tiger": (8108, 312, 51, 4.3, 13),
    "Horse": (5946, 231, 37, 2.9, 17),
    "Elephant": (10272, 417, 68, 5.1, 16),
    "Camel": (4512, 196, 31, 2.4, 14),
    "Rhino": (7154, 295, 52, 3.8, 13),
}
MB = 1e6
SCENE = "Scene"


@dataclasses.dataclass
class Data:
    roles: list
    memory: dict = dataclasses.field(default_factory=dict)   # role: what sqmap_bench memory wrote
    model: dict = dataclasses.field(default_factory=dict)    # role: the default model, the paper's with A_S of 0 and 1
    series: dict = dataclasses.field(default_factory=dict)   # role, kind: a row a frame; AVX2
    records: dict = dataclasses.field(default_factory=dict)  # role, kind: a record a method
    wide: dict = dataclasses.field(default_factory=dict)     # the same with the machine's widest vectors
    wide_records: dict = dataclasses.field(default_factory=dict)
    ticks: dict = dataclasses.field(default_factory=dict)    # force, kind: a row a haptic tick on the elephant
    density: list = dataclasses.field(default_factory=list)
    sampling: list = dataclasses.field(default_factory=list)
    run: dict = dataclasses.field(default_factory=dict)


def rows_to(path, header, rows):
    with open(path, "w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(header)
        writer.writerows(rows)


# --- Fig. 3 ------------------------------------------------------------------------------------------------------------

def grids(data):
    """The two grids of Fig. 3 as rows of points: before and after eq. 9."""
    rows = int(max(r["row"] for r in data.sampling)) + 1
    columns = len(data.sampling) // rows
    cell = lambda i, j, p: tuple(data.sampling[i * columns + j][p + axis] for axis in "xyz")
    return [[[cell(i, j, p) for j in range(columns)] for i in range(rows)] for p in ("", "spaced_")]


def longest_gap(grid):
    """Longest edge between neighbouring samples, in units of their mean."""
    edges = []
    for i in range(len(grid)):
        for j in range(len(grid[i])):
            near = [grid[i][(j + 1) % len(grid[i])]] + ([grid[i + 1][j]] if i + 1 < len(grid) else [])
            edges += [sum((a - b) ** 2 for a, b in zip(grid[i][j], q)) ** 0.5 for q in near]
    return max(edges) / statistics.mean(edges)


def quads_that_face_the_eye(grid):
    """Corners of the quads of a grid[i][j] = (x, y, z), rows closed around j, seen from the front; the farthest first."""
    turn, tilt = math.radians(32), math.radians(24)

    def seen(p):
        a = math.cos(turn) * p[0] - math.sin(turn) * p[1]
        b = math.sin(turn) * p[0] + math.cos(turn) * p[1]
        return a, math.cos(tilt) * p[2] + math.sin(tilt) * b, math.sin(tilt) * p[2] - math.cos(tilt) * b

    flat, quads = [[seen(p) for p in row] for row in grid], []
    for row, above in zip(flat, flat[1:]):
        for j in range(len(row)):
            k = (j + 1) % len(row)
            quad = [row[j], row[k], above[k], above[j]]
            (ax, ay, _), (bx, by, _), (cx, cy, _), (dx, dy, _) = quad
            if (cx - ax) * (dy - by) - (cy - ay) * (dx - bx) > 0:
                quads.append((sum(p[2] for p in quad), [p[:2] for p in quad]))
    return [corners for _, corners in sorted(quads)]


def figure_3(data, images):
    figure, panels = plot.panels(("(a) equal steps of the angles of eq. 8", "", ""), ("(b) after eqs. 9 and 10", "", ""), width=4.2,
                                 height=4.5)
    for axes, grid in zip(panels, grids(data)):
        axes.add_collection(shapes.PolyCollection(quads_that_face_the_eye(grid), facecolor="#dfe9f6", edgecolor=BLUE, linewidth=0.5))
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.set_axis_off()
    plot.save(images / "fig03.svg", figure)


# --- Figs. 5 and 8: a section through a map, with and without step 3 ----------------------------------------------------------

def figures_5_and_8(coarse, fine, profile, images):
    """coarse, fine: {column: square array} of a section's points, not a number outside of the superquadric; profile: (radius, z) of
    the mesh."""
    figure, panels = plot.panels(("Fig. 5(a): step 3", "", ""), ("Fig. 5(b): no step 3", "", ""), ("Fig. 8: force at M_B", "", ""),
                                 width=2.6, height=4.2)
    for axes, section, field, frame in zip(panels, (coarse, coarse, fine), ("with", "without", "with"),
                                           ((0.84, 1.2, -0.58, 0.58), (0.84, 1.2, -0.58, 0.58), (0.93, 1.115, 0.06, 0.66))):
        x, z = section["x"], section["z"]
        solid = numpy.interp(z, [p[1] for p in profile[::-1]], [p[0] for p in profile[::-1]]) > x
        near = (section["foot_x"] > 0.9) & (x > 0.9)
        for which, colour, words in ((solid & (section[field] < 0), "#f2b08c", "collision missed"),
                                     (~solid & (section[field] > 0), "#b9a6e6", "collision reported too early")):
            axes.contourf(x, z, which.astype(float), levels=[0.5, 2], colors=[colour])
            axes.plot([], [], color=colour, linewidth=7, label=words)
        axes.plot(*zip(*sorted(zip(section["foot_x"][near], section["foot_z"][near]), key=lambda p: p[1])), color=GREY, label="superquadric")
        axes.contour(x, z, section[field], levels=[0], colors=[RED])
        axes.plot([], [], color=RED, label="surface as the map has it")
        axes.plot(*zip(*profile), color=INK, linewidth=0.8, marker="o", markersize=3, label="mesh and its vertices")
        axes.plot([], [], color=BLUE, marker="o", markersize=4, label="S, from M_B to its foot P_M")
        axes.plot([], [], color=GREEN, linewidth=2, label="force, along eq. 26's normal")
        axes.set(xlim=frame[:2], ylim=frame[2:], aspect="equal")
        axes.set_axis_off()
    for axes in panels[:2]:
        axes.text(1.1, 0.3, "E", va="center", weight="bold")
        axes.text(0.875, -0.3, "S", va="center", weight="bold")
    at = numpy.unravel_index(numpy.argmin((fine["x"] - 0.965) ** 2 + (fine["z"] - 0.35) ** 2), fine["x"].shape)
    point, foot, normal = ((fine[a][at], fine[b][at]) for a, b in (("x", "z"), ("foot_x", "foot_z"), ("normal_x", "normal_z")))
    panels[2].plot(*zip(point, foot), color=BLUE, marker="o", markersize=4)
    panels[2].annotate("", [p + 0.07 * n for p, n in zip(point, normal)], point, arrowprops={"arrowstyle": "-|>", "color": GREEN, "linewidth": 2})
    for words, where, offset in (("M_B", point, (-12, -13)), ("P_M", foot, (5, 2))):
        panels[2].annotate(words, where, offset, textcoords="offset points", color=BLUE)
    plot.save(images / "fig05.svg", figure)


# --- Figs. 6 and 7: the search as printed -------------------------------------------------------------------------------------

def figure_6(searches, images):
    """searches: {eps: rows of the search of a point of the plane z = 0}, the point itself first."""
    figure, panels = plot.panels(*((f"Fig. 6({letter}): superellipse, ε = {eps}", "", "") for letter, eps in zip("ab", searches)), width=3.9,
                                 height=3.4)
    for axes, (eps, (point, *steps)) in zip(panels, searches.items()):
        place = lambda row: (row["x"], row["y"])
        angle = lambda p: math.degrees(math.atan2(p[1] ** (1 / eps), p[0] ** (1 / eps)))  # of eq. 14
        turn = [math.radians(i / 2) for i in range(181)]
        axes.plot([math.cos(t) ** eps for t in turn], [math.sin(t) ** eps for t in turn], color=GREY)
        m, foot = place(point), place([s for s in steps if s["better"]][-1])
        onto = 1 / (m[0] ** (2 / eps) + m[1] ** (2 / eps)) ** (eps / 2)
        ray = (onto * m[0], onto * m[1])
        axes.plot([0, ray[0]], [0, ray[1]], color=GREY, linewidth=0.9, linestyle="--")
        axes.plot(*zip(m, foot), color=RED)
        for where, words, colour in ((m, "M", INK), (ray, f"on M's ray: θ = {angle(ray):.1f}°", BLUE),
                                     (foot, f"P_M: θ = {angle(foot):.1f}°", RED)):
            axes.plot(*where, label=words, **plot.marks(colour))
        axes.set(xlim=(0, 1.1), ylim=(0, 1.1), aspect="equal")
        axes.grid(False)
    plot.save(images / "fig06.svg", figure)


def figure_7(search, images):
    """search: the rows of a point's search, the point itself first; the strides of the levels fall."""
    strides = sorted({int(r["stride"]) for r in search if r["stride"]}, reverse=True)
    figure, panels = plot.panels(*((f"Fig. 7({letter}): level {level}", "ω, degrees", "" if level else "η, degrees")
                                   for level, letter in zip(range(len(strides)), "abc")), width=2.6, height=3.2)
    degrees = lambda rows: ([math.degrees(r["omega"]) for r in rows], [math.degrees(r["eta"]) for r in rows])
    foot = [r for r in search[1:] if r["better"]][-1]
    for axes, stride in zip(panels, strides):
        looked, before = ([r for r in search[1:] if test(r["stride"])] for test in (lambda s: s == stride, lambda s: s > stride))
        best = [r for r in search[1:] if r["stride"] >= stride and r["better"]][-1]
        axes.plot(*degrees(before), label="of the levels before", **plot.marks("#c9ccd0"))
        axes.plot(*degrees(looked), label="sample of the level", **plot.marks(BLUE))
        axes.plot(*degrees([best]), label="best so far", **plot.marks(RED, "s"))
        axes.plot(*degrees([foot]), label="foot, by a Newton step", **plot.marks(INK, "x"))
        axes.text(0.02, 0.98, f"every {stride}. sample, I_S = {best['collinearity']:.5f}".replace("every 1. sample", "every sample"),
                  transform=axes.transAxes, va="top")
        (left, right), (low, high) = ((min(v), max(v)) for v in degrees(search[1:]))
        axes.set(xlim=(left - 2, right + 2), ylim=(low - 1, high + 3))
    plot.save(images / "fig07.svg", figure)


# --- Section 5, corollaries 1 and 2 ------------------------------------------------------------------------------------

COROLLARY_SHAPES = {"dumbbell": ("dumbbell: injective", BLUE, "o"), "hand": ("hand: Q2", RED, "s")}  # the project's own


def draw_corollaries(errors, images):
    """Error against density, of a shape whose projection is injective and of one with Q2. errors: {shape: {grid: (share of Q2, mean,
    99th percentile)}}. Returns them as a table."""
    figure, axes = plot.panels(("Mean", "samples of the map", "error of the depth, % of R_max"),
                               ("99th percentile", "samples of the map", ""), width=4.1, height=3)
    lines = [f"{'shape':10} {'grid':>9} {'Q2, %':>7} {'mean, %':>9} {'p99, %':>9}"]
    for shape, of_grid in errors.items():
        words, colour, marker = COROLLARY_SHAPES[shape]
        samples = [math.prod(map(int, grid.split("x"))) for grid in of_grid]
        for axis, value in zip(axes, (1, 2)):
            axis.plot(samples, [e[value] for e in of_grid.values()], color=colour, marker=marker, label=words)
        lines += [f"{shape:10} {grid:>9} {q2:7.2f} {mean:9.4f} {p99:9.4f}" for grid, (q2, mean, p99) in of_grid.items()]
    for axis in axes:
        axis.set(xscale="log", yscale="log", xticks=[100, 1000, 10_000, 100_000])
    plot.save(images / "corollaries.svg", figure)
    return "\n".join(lines) + "\n"


# --- Figs. 11 and 14: times --------------------------------------------------------------------------------------------

def kinds_of(role):
    """Paths of a role. The elephant's also has one that comes near without touching, for Fig. 14b."""
    return ("light", "deep", "near") if role == "Elephant" else ("light", "deep")


def frames_of(data, series, role, kind):
    """All frames of a role; of the scene, the frames of every animal in turn."""
    roles = data.roles[1:] if role == SCENE else [role]
    return [row for r in roles for row in series[r, kind]]


def share_of_obb(data, role, kind, method, series=None):
    """Median time in percent of the OBB tree's median."""
    frames = frames_of(data, series or data.series, role, kind)
    return 100 * statistics.median(f[method + "_us"] for f in frames) / statistics.median(f["fcl_obb_all_us"] for f in frames)


LAYERS = [  # method, words, colour, marker, hollow
    ("sqmap_normal_layer1", "paper's maps, layer 1", BLUE, "o", False),
    ("sqmap_normal_printed", "paper's maps, layer 2, search as printed", GREY, "o", True),
    ("sqmap_normal_pyramid3", "paper's maps, layer 3, pyramid", GREY, "o", False),
    ("sqmap_normal_layer2", "paper's maps, layer 2", ORANGE, "o", False),
    ("sqmap_normal_layer3", "paper's maps, layer 3", RED, "o", False),
    ("sqmap_layer3", "central model, layer 3", RED, "s", True),
    ("sqmap_exact", "central model, exact layer", VIOLET, "s", True),
    ("dense128", "dense field, 128 a side", GREEN, "D", True),
    ("adf", "ADF, split to an error of 0.1 %", GREEN, "D", False),
]


def figure_11a(data, images):
    roles, x, y = [*data.roles[1:], SCENE], "object under the hand", "% of FCL's OBB tree, all contacts"
    kinds = {"light": "light contact", "deep": "deep contact"}
    figure, panels = plot.panels(*((f"Fig. 11a: time of a frame, {words}", x, y) for words in kinds.values()), width=4.1, height=4)
    for axes, kind in zip(panels, kinds):
        axes.axhline(100, color=INK, linewidth=0.9, linestyle="--")
        axes.text(0.5, 105, "OBB tree", ha="center", va="bottom")
        for method, name, colour, marker, hollow in LAYERS:
            axes.semilogy(roles, [share_of_obb(data, r, kind, method) for r in roles], label=name, **plot.marks(colour, marker, hollow))
        axes.margins(x=0.5 / len(roles))
    plot.save(images / "fig11a.svg", figure)


TIMED = [
    ("fcl_obb_all", "FCL OBB tree, all contacts", GREY),
    ("sqmap_normal_layer3", "paper's maps, layer 3", RED),
    ("sqmap_exact", "central model, exact layer", VIOLET),
    ("sqmap_layer3", "central model, layer 3", BLUE),
]
FORCES = [("paper", "the paper's force on its maps"), ("full", "the central model's force")]


def figure_14a(data, images):
    frames = data.series["Elephant", "deep"]
    ticks = [(f"Fig. 14a: a haptic tick, {name}, layer 3", "frame", "µs a tick") for _, name in FORCES]
    figure, (race, *panels) = plot.panels(("Fig. 14a: collision detection while sliding over the elephant", "frame", "µs a frame"), *ticks,
                                          width=8, height=3.4, stacked=True)
    for method, name, colour in TIMED:
        race.semilogy([f["frame"] for f in frames], [f[method + "_us"] for f in frames], color=colour, linewidth=1, label=name)
    for axes, (force, _) in zip(panels, FORCES):
        ticks = data.ticks[force, "deep"]
        for name, colour, time in (("collision detection", BLUE, lambda t: t["query_us"]),
                                   ("force, torque, friction, safety", ORANGE, lambda t: t["tick_us"] - t["query_us"]),
                                   ("whole tick", RED, lambda t: t["tick_us"])):
            axes.plot([t["tick"] for t in ticks], [time(t) for t in ticks], color=colour, linewidth=1, label=name)
        axes.set_ylim(0)
    plot.save(images / "fig14a.svg", figure)


def figure_14b(data, images):
    frames = [f for kind in kinds_of("Elephant") for f in data.series["Elephant", kind]]
    x, y = "vertices of the hand inside the elephant", "µs a frame"
    figure, panels = plot.panels(("Fig. 14b: time, the paper's maps", x, y),
                                 ("Fig. 14b: time, the central model", x, y), width=4.1, height=3.7)
    small = {"marker": "o", "linestyle": "none", "markersize": 3, "alpha": 0.6, "markeredgewidth": 0}
    for axes, methods, force in zip(panels, (TIMED[:2], TIMED[2:]), ("paper", "full")):
        for method, name, colour in methods:
            axes.plot([f["sqmap_exact_contacts"] for f in frames], [f[method + "_us"] for f in frames], color=colour, label=name, **small)
        ticks = [t for kind in kinds_of("Elephant") for t in data.ticks[force, kind]]
        axes.plot([t["contacts"] for t in ticks], [t["tick_us"] for t in ticks], color=ORANGE, label="whole haptic tick, layer 3", **small)
        axes.set_ylim(0)
    plot.save(images / "fig14b.svg", figure)


def figure_14c(data, images):
    figure, (axes,) = plot.panels(("Fig. 14c: performance against error", "error allowed: eq. 35 as a mean, % of R_max", "frames a millisecond"),
                                  width=7)
    loosest = 2 * max(d["eq35_mean_pct"] for d in data.density)  # layer 2 answers from its own error on
    for rows, colour in zip(sorted({d["rows"] for d in data.density}), (BLUE, ORANGE, GREEN, VIOLET)):
        chain = [d for d in data.density if d["rows"] == rows]
        errors, rates = [d["eq35_mean_pct"] for d in chain], [1000 / d["p50_us"] for d in chain]
        axes.semilogx([loosest, *errors], [rates[0], *rates], color=colour, marker="o", markevery=range(1, len(chain) + 1),
                      label=f"base grid {rows} x {chain[0]['columns']}: layer 3, A_S = 1 to {len(chain) - 1}")
        axes.plot(errors[:1], rates[:1], **plot.marks(colour, hollow=True), label="its layer 2")
    axes.set_ylim(0)
    plot.save(images / "fig14c.svg", figure)


# --- Fig. 12 and Table 1: memory ---------------------------------------------------------------------------------------

FIELDS = [
    ("dense_bytes", "DF: dense grid of floats", GREY, False),
    ("full_octree_bytes", "ADF, split all along the surface", ORANGE, False),
    ("adf_bytes", "ADF, split to an error of 0.1 %", ORANGE, True),
    ("tree512_bytes", "512-tree, three levels", GREEN, False),
]


def memory_curves(data, roles):
    """Points (density, MB) of each structure, summed over roles. Density: cells along the longest side."""
    curves = {}
    for key, *_ in FIELDS:
        per_role = [data.memory[r]["fields"] for r in roles]
        curves[key] = [(level[0]["cells"], sum(f[key] for f in level) / MB) for level in zip(*per_role)]
    per_role = [data.memory[r]["maps"] for r in roles]
    curves["map"] = [(statistics.geometric_mean(m["cells"] for m in level), sum(m["bytes"] for m in level) / MB)
                     for level in zip(*per_role)]
    return curves


def figure_12(data, images):
    parts = (["Tiger"], "(a) tiger"), (data.roles, "(b) whole scene")
    figure, panels = plot.panels(*((f"Fig. 12{title}", "samples along the object's longest side", "MB") for _, title in parts), width=4.1, height=3.9)
    for axes, (roles, _) in zip(panels, parts):
        curves = memory_curves(data, roles)
        for key, name, colour, dashed in FIELDS:
            axes.loglog(*zip(*curves[key]), color=colour, marker="o", linestyle="--" if dashed else "-", label=name)
        axes.loglog(*zip(*curves["map"]), color=BLUE, marker="o", linewidth=2, label="SQ-Map, the paper's maps")
        right = max(x for curve in curves.values() for x, _ in curve)
        for k, colour in ((1, GREY), (2, ORANGE), (3, BLUE)):
            axes.plot(1.35 * right, sum(PAPER[r][k] for r in roles), color=colour, marker="_", markersize=14, linestyle="none")
        axes.plot([], [], color=GREY, marker="_", markersize=14, linestyle="none", label="the paper's Table 1, unknown density")
        axes.set_xticks([m["cells"] for m in data.memory[data.roles[0]]["fields"]])
    plot.save(images / "fig12.svg", figure)


def figure_12_error(data, images):
    """Beyond the paper: the same memory against the error that it buys."""
    role = "Tiger"
    figure, (axes,) = plot.panels(("Memory against error, tiger", "mean error, % of R_max: depth of a field, eq. 35 of a map", "MB"), width=7,
                                  height=4.5)
    fields, maps, model = data.memory[role]["fields"], data.memory[role]["maps"], data.model[role]
    for key, name, colour, dashed in (FIELDS[0], FIELDS[1], FIELDS[3]):
        axes.loglog([f["error_pct"] for f in fields], [f[key] / MB for f in fields], color=colour, marker="o",
                    linestyle="--" if dashed else "-", label=name)
    axes.loglog([m["error_pct"] for m in maps], [m["bytes"] / MB for m in maps], color=BLUE, marker="o", linewidth=2,
                label="SQ-Map, the paper's maps")
    for kind, name, colour in (("default", "central model, default, without the exact layer", RED), ("paper1", "the paper's whole model, A_S = 1", BLUE)):
        axes.plot(model[kind]["eq35_mean_pct"], model[kind]["bytes_without_exact"] / MB, **plot.marks(colour, "s"), label=name)
    plot.save(images / "memory-error.svg", figure)


# --- Files -------------------------------------------------------------------------------------------------------------

def draw(data, images):
    for figure in (figure_3, figure_11a, figure_12, figure_12_error, figure_14a, figure_14b):
        figure(data, images)
    if data.density:
        figure_14c(data, images)


def write_csv(data, out):
    roles = data.roles
    for name, some in (("fig12a", ["Tiger"]), ("fig12b", roles)):
        rows_to(out / f"{name}.csv", ("structure", "samples_along_longest_side", "MB"),
                [(key, *point) for key, curve in memory_curves(data, some).items() for point in curve])
    rows_to(out / "fig11a.csv", ("object", "path", "method", "percent_of_obb"),
            [(r, kind, m, share_of_obb(data, r, kind, m)) for r in (*roles[1:], SCENE) for kind in ("light", "deep")
             for m, *_ in LAYERS])
    rows_to(out / "fig14a.csv", ("frame", *(m for m, *_ in TIMED)),
            [(f["frame"], *(f[m + "_us"] for m, *_ in TIMED)) for f in data.series["Elephant", "deep"]])
    rows_to(out / "fig14b.csv", ("path", "contacts", *(m for m, *_ in TIMED)),
            [(kind, f["sqmap_exact_contacts"], *(f[m + "_us"] for m, *_ in TIMED)) for kind in kinds_of("Elephant")
             for f in data.series["Elephant", kind]])
    rows_to(out / "fig14_ticks.csv", ("force", "path", "tick", "contacts", "query_us", "tick_us"),
            [(*which, *t.values()) for which, ticks in data.ticks.items() for t in ticks])
    if data.density:
        rows_to(out / "fig14c.csv", data.density[0], [d.values() for d in data.density])
    rows_to(out / "table1.csv", ("model", "stand_in", "polygons", "segments_paper", "segments", "DF_paper_MB", "DF_MB", "ADF_paper_MB",
                                 "ADF_full_MB", "ADF_error_MB", "tree512_MB", "SQ_paper_MB", "SQ_MB_A_S_0", "SQ_MB_A_S_1", "default_model_MB"), table_1(data))


def table_1(data):
    rows = []
    for role in data.roles:
        m, field = data.memory[role], data.memory[role]["fields"][-1]
        polygons, df, adf, sq, segments = PAPER[role]
        rows.append((role, data.run["stand_ins"][role], m["triangles"], segments, m["parts"], df, field["dense_bytes"] / MB, adf,
                     field["full_octree_bytes"] / MB, field["adf_bytes"] / MB, field["tree512_bytes"] / MB, sq,
                     *(data.model[role][kind]["bytes"] / MB for kind in ("paper0", "paper1")),
                     data.model[role]["default"]["bytes_without_exact"] / MB))
    rows.append((SCENE, "sum", *(sum(r[k] for r in rows) for k in range(2, 15))))
    return rows


def markdown(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|---|" + "---:|" * (len(header) - 1)]
    return "\n".join(lines + ["| " + " | ".join(str(c) for c in row) + " |" for row in rows])


def short(value):
    """Three significant digits, without an exponent."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def instructions(data, header, shares):
    """The paper's maps on the widest vectors, and whether every set and the reference have answered alike."""
    ours = [(m, name) for m, name, *_ in LAYERS if m.startswith("sqmap_normal")]
    hashes = lambda records: {(path, r["method"]): r["hash"] for path, rs in records.items() for r in rs}
    narrow, wide = hashes(data.records), hashes(data.wide_records)
    pairs = [(narrow[path, m], wide[path, m]) for path in data.records for m, _ in ours]
    pairs += [(wide[path, "sqmap_normal_one_lane"], wide[path, "sqmap_normal_layer3"]) for path in data.records]
    alike = sum(a == b for a, b in pairs)
    first = next(iter(data.records)), next(iter(data.wide_records))
    names = [{"AVX3": "AVX-512"}.get(name, name) for name in (data.records[first[0]][0]["instructions"],
                                                              data.wide_records[first[1]][0]["instructions"])]
    return (f"The table above is with {names[0]}. With {names[1]}:\n\n"
            + markdown(header, [(name, *shares(m, data.wide)) for m, name in ours] + [("layer 3 with one lane, the reference", *shares("sqmap_normal_one_lane", data.wide))])
            + f"\n\nHashes of all answers, {names[0]} against {names[1]} and one lane against vectors: {alike} of {len(pairs)} alike.")


def tables(data):
    """Title of a block of the page: its text."""
    cells = data.memory[data.roles[0]]["fields"][-1]["cells"]
    polygons = lambda row: f"{row[2]}"
    page = {"run": f"Last run: {data.run['date']}, commit {data.run['commit']}, {data.run['frames']} frames of each path."}
    page["table 1"] = markdown(
        ("model", "stand-in", "polygons", "segments: paper", "here", "DF: paper, MB", f"here, {cells}", "ADF: paper",
         "here, full", "here, to 0.1 %", "512-tree", "SQ: paper", "here, A_S 0", "A_S 1", "central model"),
        [(r[0], r[1], polygons(r), r[3], r[4], *(short(v) for v in r[5:]))
         for r in table_1(data)])
    medians = [statistics.median(data.model[r][kind]["bytes"] / MB for r in data.roles) for kind in ("bare0", "bare1", "paper0", "paper1")]
    page["table 1"] += ("\n\nMedian of the paper's six: {:.2f} MB with A_S = 0, {:.2f} MB with A_S = 1 without the smoothed map "
                        "(`--smoothing-radius 0`), which forces alone read; {:.2f} and {:.2f} MB with it, as in the table.").format(*medians)
    page["fig 3"] = "Longest edge of the grid in units of the mean edge: {:.1f} before eqs. 9 and 10, {:.1f} after.".format(
        *(longest_gap(g) for g in grids(data)))
    roles = [*data.roles[1:], SCENE]
    shares = lambda m, series: (f"{short(share_of_obb(data, r, 'light', m, series))} / {short(share_of_obb(data, r, 'deep', m, series))}" for r in roles)
    header = ("percent of FCL's OBB tree (medians), light / deep", *roles)
    page["fig 11a"] = markdown(header, [(name, *shares(m, data.series)) for m, name, *_ in LAYERS])
    page["instructions"] = instructions(data, header, shares)
    def median_of(kind, method, field):
        return statistics.median(next(rec for rec in data.records[r, kind] if rec["method"] == method)[field] for r in data.roles[1:])
    page["accuracy"] = markdown(
        ("medians over the animals, light / deep", "missed, %", "false, %", "mean depth error, % of R_max"),
        [(name, *("none" if "depth" in f and m == "sqmap_normal_layer1"
                  else f"{short(median_of('light', m, f))} / {short(median_of('deep', m, f))}" for f in ("missed_pct", "false_pct", "depth_error_mean_pct"))) for m, name, *_ in LAYERS])
    elephant = {kind: data.series["Elephant", kind] for kind in kinds_of("Elephant")}
    usual = lambda kind, column: statistics.median(f[column] for f in elephant[kind])
    kinds = ("near", "light", "deep")
    tick = lambda force, kind: statistics.median(t["tick_us"] for t in data.ticks[force, kind])
    page["fig 14b"] = markdown(
        ("median µs a frame on the elephant", *(f"{k} ({usual(k, 'sqmap_exact_contacts'):.0f} contacts)" for k in kinds), "deep / light"),
        [(name, *(short(usual(k, m + "_us")) for k in kinds), short(usual("deep", m + "_us") / usual("light", m + "_us")))
         for m, name, *_ in [TIMED[0], *LAYERS]]
        + [(f"whole haptic tick, {name}, layer 3", *(short(tick(force, k)) for k in kinds), short(tick(force, "deep") / tick(force, "light")))
           for force, name in FORCES])
    if data.density:
        page["fig 14c"] = markdown(
            ("base grid", "A_S", "layer", "µs a frame", "eq. 35 mean, %", "p99, %", "MB"),
            [(f"{d['rows']} x {d['columns']}", d["subdivisions"], d["layer"], short(d["p50_us"]), short(d["eq35_mean_pct"]),
              short(d["eq35_p99_pct"]), short(d["bytes"] / MB)) for d in data.density])
    page["precomputation"] = markdown(
        ("CPU seconds", *data.roles),
        [("the paper's model, A_S = 1, its own measurement included", *(f"{data.model[r]['paper1']['seconds']:.1f}" for r in data.roles)),
         ("central model, exact layer and its own measurement included", *(f"{data.model[r]['default']['seconds']:.1f}" for r in data.roles))])
    return page


ON_PAGE = ("run", "table 1", "fig 3")


def renew_page(path, page):
    """Puts each block of ON_PAGE between its marks, the others into files of data/reproduction beside the page."""
    text = path.read_text()
    for title, block in page.items():
        if title not in ON_PAGE:
            (path.parent / "data/reproduction" / f"{title.replace(' ', '')}.txt").write_text(block + "\n")
            continue
        before, mark, rest = text.partition(f"<!-- {title} -->\n")
        _, end, after = rest.partition("<!-- end -->")
        if not mark or not end:
            raise SystemExit(f"{path.relative_to(measure.ROOT)}: no place for '{title}'")
        text = before + mark + "\n" + block + "\n\n" + end + after
    path.write_text(text)
