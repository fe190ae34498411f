#!/usr/bin/env python3
"""Draws the schematic figures of docs/algorithms from plane geometry: one plane section stands for the solid.

usage: docs_drawings.py     writes docs/images/{chart,layers,locator,candidates,pair,cover,refine,safety,answers}.svg
"""
import math
import pathlib

from matplotlib import lines, patches, text

import plot

IMAGES = pathlib.Path(__file__).resolve().parent.parent / "docs/images"
POINTS = 0.75  # of a pixel
TINT = {"free": "#ffffff", "inside": "#dbe6f5", "flat": "#f7dccd", "chart": "#e3daf3"}


def outline(t):
    """The section: a closed curve with a bulge and a hollow."""
    r = 1 + 0.22 * math.cos(2 * t - 0.5) + 0.13 * math.cos(3 * t + 0.8)
    return (r * math.cos(t), r * math.sin(t))


CURVE = [outline(2 * math.pi * i / 720) for i in range(720)]


def radius_along(direction, points=None):
    """The largest multiple of direction that meets the closed polyline, seen from the origin."""
    points = points or CURVE
    best = 0
    for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1]):
        ex, ey = bx - ax, by - ay
        det = direction[0] * -ey + direction[1] * ex
        if abs(det) < 1e-12:
            continue
        rho = (ax * -ey + ay * ex) / det
        u = (direction[0] * ay - direction[1] * ax) / det
        if rho > 0 and 0 <= u < 1:
            best = max(best, rho)
    return best


def inside(p, points=None):
    points = points or CURVE
    crossings = 0
    for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1]):
        if (ay > p[1]) != (by > p[1]) and p[0] < ax + (p[1] - ay) / (by - ay) * (bx - ax):
            crossings += 1
    return crossings % 2 == 1


def nearest_on(p, a, b):
    ex, ey = b[0] - a[0], b[1] - a[1]
    f = max(0, min(1, ((p[0] - a[0]) * ex + (p[1] - a[1]) * ey) / (ex * ex + ey * ey)))
    return (a[0] + f * ex, a[1] + f * ey)


class Panel:
    """Draws in plane coordinates, y up, at a position of the picture; all sizes are pixels."""

    def __init__(self, x, y, scale):
        self.x, self.y, self.scale, self.artists = x, y, scale, []

    def at(self, p):
        return (self.x + self.scale * p[0], self.y - self.scale * p[1])

    def path(self, points, stroke=plot.INK, fill="none", width=1.5, closed=False, dash=(), opacity=1):
        self.artists.append(patches.Polygon([self.at(p) for p in points], closed=closed, facecolor=fill, edgecolor=stroke, alpha=opacity,
                                            linewidth=POINTS * width, joinstyle="round", linestyle=(0, dash) if dash else "-"))

    def dot(self, p, colour=plot.INK, size=3):
        self.artists.append(lines.Line2D(*([v] for v in self.at(p)), color=colour, marker="o", markersize=2 * POINTS * size, markeredgewidth=0))

    def square(self, corner, side, fill):
        self.path([corner, (corner[0] + side, corner[1]), (corner[0] + side, corner[1] + side), (corner[0], corner[1] + side)],
                  stroke=plot.GRID, fill=fill, width=0.8, closed=True)

    def arrow(self, a, b, colour, width=1.6):
        self.artists.append(patches.FancyArrowPatch(self.at(a), self.at(b), arrowstyle="->", mutation_scale=9, shrinkA=0, shrinkB=0,
                                                    color=colour, linewidth=POINTS * width))

    def text(self, p, words, colour=plot.INK, anchor="center", size=12):
        self.artists.append(text.Text(*self.at(p), words, color=colour, ha=anchor, fontsize=POINTS * size))


def save(name, width, height, *panels):
    figure = plot.pyplot.figure(figsize=(width / 96, height / 96), layout="none")
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.set_axis_off()
    for panel in panels:
        for artist in panel.artists:
            axes.add_artist(artist)
    plot.save(IMAGES / name, figure)


def face_point(s, rho):
    """A point of the chart's +x face."""
    return (rho, rho * s)


def chart():
    a = Panel(170, 165, 105)
    a.path(CURVE, fill=TINT["inside"], closed=True)
    b = 6
    nodes = [-1 + 2 * i / b for i in range(b + 1)]
    for k in range(4):
        c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][k]
        for u in nodes if k == 0 else nodes[1:-1]:
            d = (c - s * u, s + c * u)
            rho = radius_along(d)
            a.path([(0, 0), (1.06 * rho * d[0], 1.06 * rho * d[1])], plot.FAINT if k == 0 else plot.GRID, width=0.8)
    for u in nodes:
        a.dot(face_point(u, radius_along((1, u))), plot.BLUE, 3.2)
    a.dot((0, 0))
    a.text((-0.3, -0.04), "centre c")
    a.text((0, -1.42), "rays of one face, samples w = 1 / rho", plot.FAINT)
    lo, hi = nodes[4], nodes[5]
    fine = [lo + (hi - lo) * i / 40 for i in range(41)]
    w = [1 / radius_along((1, s)) for s in fine]
    flat = [w[0] + (w[-1] - w[0]) * i / 40 for i in range(41)]
    e = max(abs(x - y) for x, y in zip(w, flat))
    band = [face_point(s, 1 / (f + e)) for s, f in zip(fine, flat)] + [face_point(s, 1 / (f - e)) for s, f in zip(fine, flat)][::-1]
    mean = 1 / flat[20]
    z = Panel(500 - 620 * mean, 165 + 620 * mean * fine[20], 620)
    z.path(band, "none", TINT["flat"], closed=True)
    for s, f in ((fine[0], flat[0]), (fine[-1], flat[-1])):
        z.path([face_point(s, 0.84 / f), face_point(s, 1.13 / f)], plot.FAINT, width=0.8)
        z.dot(face_point(s, 1 / f), plot.BLUE, 4)
    z.path([face_point(s, 1 / f) for s, f in zip(fine, flat)], plot.BLUE, width=1.5)
    z.path([face_point(s, 1 / x) for s, x in zip(fine, w)], plot.INK, width=2)
    t = Panel(482, 314, 1)
    t.text((0, 0), "one cell: surface (black), interpolant (blue), band of deviation e", plot.FAINT)
    save("chart.svg", 680, 325, a, z, t)


def superellipse(centre, a, b, eps, turn, n=180):
    points = []
    for i in range(n):
        t = 2 * math.pi * i / n
        c, s = math.cos(t), math.sin(t)
        x, y = a * math.copysign(abs(c) ** eps, c), b * math.copysign(abs(s) ** eps, s)
        points.append((centre[0] + x * math.cos(turn) - y * math.sin(turn), centre[1] + x * math.sin(turn) + y * math.cos(turn)))
    return points


def bound(points, eps, turn):
    """The superellipse of these exponents and axes that holds the points: scaled box."""
    c, s = math.cos(turn), math.sin(turn)
    local = [(x * c + y * s, -x * s + y * c) for x, y in points]
    low = [min(p[k] for p in local) for k in (0, 1)]
    high = [max(p[k] for p in local) for k in (0, 1)]
    m, h = [(u + v) / 2 for u, v in zip(low, high)], [(v - u) / 2 for u, v in zip(low, high)]
    grow = max((abs((p[0] - m[0]) / h[0]) ** (2 / eps) + abs((p[1] - m[1]) / h[1]) ** (2 / eps)) ** (eps / 2) for p in local)
    return superellipse((m[0] * c - m[1] * s, m[0] * s + m[1] * c), grow * h[0], grow * h[1], eps, turn)


def rays(count):
    """The map of the section with so many cells a face."""
    points = []
    for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        for i in range(count):
            u = -1 + 2 * i / count
            d = (c - s * u, s + c * u)
            rho = radius_along(d)
            points.append((rho * d[0], rho * d[1]))
    return points


def layers():
    panels = []
    drawn = [("1: superquadric", bound(CURVE, 0.85, -0.45), plot.RED), ("2: base map", rays(3), plot.BLUE),
             ("3: refined map", rays(9), plot.BLUE), ("exact: triangles", CURVE[::20], plot.VIOLET)]
    for i, (words, points, colour) in enumerate(drawn):
        p = Panel(95 + 165 * i, 100, 54)
        p.path(CURVE, "none", TINT["inside"], closed=True)
        p.path(points, colour, width=1.6, closed=True)
        if i in (1, 2, 3):
            for q in points:
                p.dot(q, colour, 1.7)
        p.text((0, -1.72), words)
        panels.append(p)
    save("layers.svg", 690, 205, *panels)


def locator():
    a = Panel(180, 155, 100)
    side = 0.25
    kinds = {}
    for i in range(-7, 7):
        for j in range(-6, 6):
            corner = (i * side, j * side)
            grid = [(corner[0] + side * u / 4, corner[1] + side * v / 4) for u in range(5) for v in range(5)]
            verdicts = {inside(p) for p in grid}
            centre = (corner[0] + side / 2, corner[1] + side / 2)
            near = min(CURVE, key=lambda q: math.dist(q, centre))
            k = CURVE.index(near)
            tangent = (CURVE[(k + 1) % 720][0] - CURVE[k - 1][0], CURVE[(k + 1) % 720][1] - CURVE[k - 1][1])
            length = math.hypot(*tangent)
            normal = (tangent[1] / length, -tangent[0] / length)
            if verdicts == {False}:
                kind = "free"
            else:
                worst = 0
                for p in grid:
                    if not inside(p):
                        continue
                    true = min(math.dist(q, p) for q in CURVE)
                    plane = abs((near[0] - p[0]) * normal[0] + (near[1] - p[1]) * normal[1])
                    worst = max(worst, abs(true - plane))
                kind = "flat" if worst < 0.02 else ("chart" if len(verdicts) > 1 or worst < 0.2 else "inside")
            kinds[i, j] = kind
            a.square(corner, side, TINT[kind])
    a.path(CURVE, closed=True)
    a.text((0, -1.62), "white: free; orange: one tangent plane is the surface;", plot.FAINT, size=11)
    a.text((0, -1.77), "violet: several planes, or the maps; blue: inside", plot.FAINT, size=11)
    i, j = min((cell for cell, kind in kinds.items() if kind == "flat"),
               key=lambda cell: min(math.dist(q, (side * (cell[0] + 0.5), side * (cell[1] + 0.5))) for q in CURVE))
    c = (side * (i + 0.5), side * (j + 0.5))
    b = Panel(520 - 620 * c[0], 140 + 620 * c[1], 620)
    b.square((side * i, side * j), side, TINT["flat"])
    for p in ((c[0] - 0.32 * side, c[1] - 0.3 * side), (c[0] + 0.3 * side, c[1] - 0.1 * side)):
        q = min(CURVE, key=lambda q: math.dist(q, p))
        k = CURVE.index(q)
        e = (CURVE[(k + 1) % 720][0] - CURVE[k - 1][0], CURVE[(k + 1) % 720][1] - CURVE[k - 1][1])
        n = math.hypot(*e)
        b.path([(q[0] - 0.16 * e[0] / n, q[1] - 0.16 * e[1] / n), (q[0] + 0.16 * e[0] / n, q[1] + 0.16 * e[1] / n)], plot.ORANGE)
        b.path([p, q], plot.FAINT, dash=(3, 3))
        b.dot(p, plot.INK)
        b.dot(q, plot.ORANGE)
    near = [q for q in CURVE if abs(q[0] - c[0]) < 0.75 * side and abs(q[1] - c[1]) < 0.75 * side]
    b.path(near, width=2)
    t = Panel(520, 302, 1)
    t.text((0, 0), "one cell: points, nearest surface points, tangent planes", plot.FAINT, size=11)
    save("locator.svg", 690, 345, a, b, t)


def candidates():
    coarse = CURVE[::36]
    p = Panel(210, 160, 105)
    p.path(coarse, fill=TINT["inside"], closed=True)
    corner, side = (0.42, 0.02), 0.36
    p.square(corner, side, TINT["flat"])
    found = set()
    edges = list(zip(coarse, coarse[1:] + coarse[:1]))
    for u in range(61):
        for v in range(61):
            q = (corner[0] + side * u / 60, corner[1] + side * v / 60)
            found.add(min(range(len(edges)), key=lambda k: math.dist(q, nearest_on(q, *edges[k]))))
    for k in found:
        p.path(edges[k], plot.ORANGE, width=3)
    for q in coarse:
        p.dot(q, size=2)
    q = (corner[0] + 0.2 * side, corner[1] + 0.7 * side)
    best = min((nearest_on(q, *e) for e in edges), key=lambda n: math.dist(n, q))
    p.arrow(q, best, plot.BLUE)
    p.dot(q, plot.BLUE)
    t = Panel(470, 130, 1)
    for i, words in enumerate(("square: one cell of the locator", f"orange: its candidate list, {len(found)} of {len(edges)}",
                               "each is nearest to some point", "of the cell", "blue: depth of one point")):
        t.text((0, -20 * i), words, plot.FAINT, "left")
    save("candidates.svg", 690, 320, p, t)


def distance():
    """The tree of bounds about the curve, the band, a point in it and one beyond."""
    p = Panel(210, 175, 78)
    away = lambda q: min(math.dist(q, c) for c in CURVE[::3])
    band = 0.24

    def divide(centre, half, depth):
        d, reach = away(centre), half * math.sqrt(2)
        if d - reach > band and reach <= d / 3:
            p.square((centre[0] - half, centre[1] - half), 2 * half, TINT["inside" if inside(centre) else "free"])
        elif depth < 5 and d - reach < 4 * half + band and not (d + reach < band):
            for i in range(4):
                divide((centre[0] + half * (i % 2 - 0.5), centre[1] + half * (i // 2 - 0.5)), half / 2, depth + 1)

    divide((0, 0), 2.1, 0)
    p.path(CURVE, closed=True, width=2)
    for side in (1, -1):
        offset = []
        for k in range(0, 720, 4):
            e = (CURVE[(k + 1) % 720][0] - CURVE[k - 1][0], CURVE[(k + 1) % 720][1] - CURVE[k - 1][1])
            n = math.hypot(*e)
            q = (CURVE[k][0] + side * band * e[1] / n, CURVE[k][1] - side * band * e[0] / n)
            if away(q) > 0.97 * band:
                offset.append(q)
        p.path(offset, plot.ORANGE, closed=True, dash=(4, 3))
    near = (1.15, 0.75)
    best = min(CURVE, key=lambda q: math.dist(q, near))
    k = CURVE.index(best)
    e = (CURVE[(k + 1) % 720][0] - CURVE[k - 1][0], CURVE[(k + 1) % 720][1] - CURVE[k - 1][1])
    n = math.hypot(*e)
    sign = 1 if not inside((best[0] + 0.05 * e[1] / n, best[1] - 0.05 * e[0] / n)) else -1
    near = (best[0] + sign * 0.21 * e[1] / n, best[1] - sign * 0.21 * e[0] / n)
    p.arrow(near, best, plot.BLUE)
    p.dot(near, plot.BLUE)
    far = (-1.35, 1.2)
    bound = 0.7 * away(far)
    p.path([(far[0] + bound * math.cos(a / 30 * math.pi), far[1] + bound * math.sin(a / 30 * math.pi)) for a in range(60)],
           plot.BLUE, closed=True, dash=(2, 3))
    p.dot(far, plot.BLUE)
    t = Panel(430, 120, 1)
    for i, words in enumerate(("orange: the band, exact on either side", "blue arrow: distance, gradient, nearest point",
                               "squares: leaves of the tree of bounds,", "smaller near the surface", "blue circle: nothing is nearer than this",
                               "bound, at least half of the distance")):
        t.text((0, -20 * i), words, plot.FAINT, "left")
    save("distance.svg", 730, 350, p, t)


def pair():
    a = Panel(180, 150, 100)
    block = [(-1.3, -1.0), (1.3, -1.0), (1.3, 0.0), (-1.3, 0.0)]
    a.path(block, fill=TINT["inside"], closed=True)
    b = [(-0.1, -0.35), (0.75, 0.55), (0.3, 1.1), (-0.7, 0.75)]
    a.path(b, fill=TINT["flat"], closed=True, opacity=0.9)
    a.path(block, closed=True)
    a.arrow((-0.1, -0.35), (-0.1, 0.35), plot.GREEN)
    a.dot((-0.1, -0.35), plot.ORANGE, 4)
    a.dot((-0.1, 0), plot.BLUE, 4)
    a.text((-0.2, -0.55), "vertex of b: witness point on b", plot.ORANGE)
    a.text((-0.2, 0.06), "witness point on a", plot.BLUE, "right", 11)
    a.text((0.0, 0.4), "normal", plot.GREEN, "left")
    a.text((-0.8, -0.85), "a")
    a.text((0.2, 0.8), "b")
    c = Panel(520, 150, 100)
    flat = [(-1.1, -0.22), (1.1, -0.22), (1.1, 0.22), (-1.1, 0.22)]
    tall = [(-0.25, -1.0), (0.25, -1.0), (0.25, 1.0), (-0.25, 1.0)]
    c.path(flat, fill=TINT["inside"], closed=True)
    c.path(tall, fill=TINT["flat"], closed=True, opacity=0.85)
    c.path(flat, closed=True)
    for q in flat + tall:
        c.dot(q, size=3)
    c.text((0, -1.25), "overlap, but every vertex is outside", plot.FAINT)
    a.text((0, -1.25), "one contact of query_pair", plot.FAINT)
    save("pair.svg", 700, 300, a, c)


def cover():
    left = [q for q in CURVE if q[0] < 0.1]
    right = [q for q in CURVE if q[0] >= 0.1]
    panels = []
    for i, (points, words) in enumerate(((left, "part A with its cap"), (right, "part B with its cap"))):
        p = Panel(190 + 320 * i + (30 if i == 0 else -40), 150, 95)
        k = max(range(len(points)), key=lambda k: math.dist(points[k], points[k - 1]))
        chain = points[k:] + points[:k]
        p.path(chain + chain[:1], "none", TINT["inside"] if i == 0 else TINT["flat"], closed=True)
        p.path(chain, plot.BLUE if i == 0 else plot.ORANGE, width=2.2)
        p.arrow(chain[-1], chain[0], plot.RED, 2)
        p.path(bound(chain, 0.7, 0.0 if i else 0.35), plot.FAINT, dash=(5, 4), closed=True)
        p.text((-0.5 if i == 0 else 0.65, -1.4), words, plot.FAINT)
        panels.append(p)
    save("cover.svg", 700, 310, *panels)


def refine():
    bent = [(-1.2, -0.25), (0.15, -0.25), (0.95, 0.95), (0.55, 1.2), (-0.15, 0.2), (-1.2, 0.2)]
    one, two = Panel(170, 170, 95), Panel(500, 170, 95)
    for p in (one, two):
        p.path(bent, fill=TINT["inside"], closed=True)
    one.path(bound(bent, 0.6, 0.35), plot.RED, closed=True)
    two.path(bound([(-1.2, -0.25), (0.15, -0.25), (-0.15, 0.2), (-1.2, 0.2)], 0.45, 0.0), plot.GREEN, closed=True)
    two.path(bound([(0.15, -0.25), (0.95, 0.95), (0.55, 1.2), (-0.15, 0.2)], 0.45, 0.98), plot.GREEN, closed=True)
    two.path([(0.15, -0.25), (-0.15, 0.2)], plot.INK, dash=(4, 3))
    one.text((0, -1.2), "before: one loose bound", plot.FAINT)
    two.text((0, -1.2), "after: two tight bounds", plot.FAINT)
    save("refine.svg", 680, 310, one, two)


def safety():
    figure, (stale, slew) = plot.panels(("a. Samples stop at 0 ms", "ms since the last sample", "N"),
                                        ("b. A step of 3 N, limit 2 N", "ms", "N"), height=3)
    stale.plot([0, 30], [1.5, 1.5], color=plot.GREY, linestyle="--", label="commanded")
    stale.plot([0, 5, 20, 30], [1.5, 1.5, 0, 0], color=plot.ORANGE, linewidth=2, label="sent")
    slew.plot([0, 2, 2, 18, 18, 24], [0, 0, 3, 3, 0.5, 0.5], color=plot.GREY, linestyle="--", label="commanded")
    slew.plot([0, 2, 10, 18, 18, 24], [0, 0, 2, 2, 0.5, 0.5], color=plot.ORANGE, linewidth=2, label="sent")
    for axes in (stale, slew):
        axes.set_ylim(0)
    plot.save(IMAGES / "safety.svg", figure)


def answers():
    """Four meshes and what the gate answers."""
    square = [(-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6)]
    panels = []
    for i, (title, words) in enumerate((("ACCEPT", "closed"), ("REPAIRED", "two vertices at one position"),
                                        ("E_OPEN", "an edge with one face"), ("E_NONMANIFOLD", "an edge with three faces"))):
        p = Panel(95 + 170 * i, 90, 70)
        if i == 0:
            p.path(square, fill=TINT["inside"], closed=True)
        elif i == 1:
            p.path([(0.52, 0.6), *square[3:], *square[:2], (0.6, 0.52)], fill=TINT["inside"])
            for q in ((0.52, 0.6), (0.6, 0.52)):
                p.dot(q, plot.ORANGE)
        elif i == 2:
            p.path([(0.6, 0.1), *square[1::-1], square[3], square[2]], plot.INK)
            for q in ((0.6, 0.1), (0.6, 0.6)):
                p.dot(q, plot.RED)
        else:
            p.path(square, fill=TINT["inside"], closed=True)
            p.path([(0, 0.6), (0, -0.05)], plot.RED)
            p.dot((0, 0.6), plot.RED)
        p.text((0, -0.95), title)
        p.text((0, -1.2), words, plot.FAINT, size=11)
        panels.append(p)
    save("answers.svg", 690, 190, *panels)


if __name__ == "__main__":
    for draw in (chart, layers, locator, candidates, distance, pair, cover, refine, safety, answers):
        draw()
