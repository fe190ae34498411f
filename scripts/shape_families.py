#!/usr/bin/env python3
"""Families of shapes for a library: superquadrics, gears, bottles, chains, and scans with noise and holes. Every file is made by
this script; the same number gives the same shape.

usage: shape_families.py FOLDER COUNT
"""
import math
import pathlib
import random
import sys


class Mesh:
    def __init__(self):
        self.points, self.faces = [], []

    def point(self, *p):
        self.points.append(p)
        return len(self.points) - 1

    def quad(self, a, b, c, d):
        self.faces += [(a, b, c), (a, c, d)]

    def write(self, path):
        with open(path, "w") as out:
            out.write(f"OFF\n{len(self.points)} {len(self.faces)} 0\n")
            out.writelines("%.7g %.7g %.7g\n" % p for p in self.points)
            out.writelines("3 %d %d %d\n" % f for f in self.faces)


def sphere_like(surface, rings, sides):
    """A closed surface over latitude and longitude; surface(latitude, longitude): a point."""
    mesh = Mesh()
    rows = [[mesh.point(*surface(-math.pi / 2 + math.pi * i / rings, 2 * math.pi * k / sides)) for k in range(sides)]
            for i in range(1, rings)]
    south, north = mesh.point(*surface(-math.pi / 2, 0)), mesh.point(*surface(math.pi / 2, 0))
    for k in range(sides):
        n = (k + 1) % sides
        mesh.faces += [(south, rows[0][n], rows[0][k]), (rows[-1][k], rows[-1][n], north)]
        for low, high in zip(rows, rows[1:]):
            mesh.quad(low[k], low[n], high[n], high[k])
    return mesh


def power(x, e):
    return math.copysign(abs(x) ** e, x)


def superquadric(chance):
    e, f = chance.uniform(0.2, 2), chance.uniform(0.2, 2)
    a = [chance.uniform(0.3, 1) for _ in range(3)]

    def surface(t, w):
        return (a[0] * power(math.cos(t), e) * power(math.cos(w), f), a[1] * power(math.cos(t), e) * power(math.sin(w), f),
                a[2] * power(math.sin(t), e))
    return sphere_like(surface, 24, 36)


def prism(outline, hole, height):
    """Between an outline and a hole about its middle that has as many points; both counter-clockwise."""
    mesh, n = Mesh(), len(outline)
    low, high = [[[mesh.point(x, y, z) for x, y in ring] for ring in (outline, hole)] for z in (0, height)]
    for k in range(n):
        m = (k + 1) % n
        mesh.quad(low[0][k], low[0][m], high[0][m], high[0][k])
        mesh.quad(low[1][m], low[1][k], high[1][k], high[1][m])
        mesh.quad(high[0][k], high[0][m], high[1][m], high[1][k])
        mesh.quad(low[0][m], low[0][k], low[1][k], low[1][m])
    return mesh


def gear(chance):
    teeth, depth, hole = chance.randint(7, 24), chance.uniform(0.08, 0.25), chance.uniform(0.15, 0.45)
    outline, inner = [], []
    for k in range(4 * teeth):
        angle = 2 * math.pi * (k + (0.2 if k % 4 in (1, 3) else -0.2 if k % 4 == 0 else 0)) / (4 * teeth)
        radius = 1 if k % 4 in (0, 1) else 1 - depth
        outline.append((radius * math.cos(angle), radius * math.sin(angle)))
        inner.append((hole * math.cos(angle), hole * math.sin(angle)))
    return prism(outline, inner, chance.uniform(0.1, 0.5))


def bottle(chance):
    """A wall of some thickness, open at its neck: one closed surface, outside and inside."""
    body, neck, shoulder = chance.uniform(0.25, 0.45), chance.uniform(0.08, 0.15), chance.uniform(0.5, 0.7)
    wall = chance.uniform(0.02, 0.05)

    def radius(z):
        s = min(1, max(0, (z - shoulder) / 0.2))
        return body + (neck - body) * s * s * (3 - 2 * s)
    outside = [(radius(i / 20), i / 20) for i in range(21)]
    inside = [(radius(z) - wall, z) for _, z in reversed(outside) if z > wall] + [(radius(0) - wall, wall)]
    profile = outside + inside
    mesh, sides = Mesh(), 28
    rings = [[mesh.point(r * math.cos(2 * math.pi * k / sides), r * math.sin(2 * math.pi * k / sides), z) for k in range(sides)]
             for r, z in profile]
    bottom, floor = mesh.point(0, 0, 0), mesh.point(0, 0, wall)
    for k in range(sides):
        n = (k + 1) % sides
        for a, b in zip(rings, rings[1:]):
            mesh.quad(a[k], a[n], b[n], b[k])
        mesh.faces += [(rings[0][n], rings[0][k], bottom), (rings[-1][k], rings[-1][n], floor)]
    return mesh


def chain(chance):
    """Links that hold each other and do not touch."""
    mesh, thin, stretch = Mesh(), chance.uniform(0.09, 0.14), chance.uniform(1.2, 1.8)
    for link in range(chance.randint(2, 4)):
        start, sides, around = len(mesh.points), 28, 10
        for i in range(sides):
            u = 2 * math.pi * i / sides
            for k in range(around):
                v = 2 * math.pi * k / around
                radius = 0.5 + thin * math.cos(v)
                p = (stretch * radius * math.cos(u) + link * (2 * stretch * 0.5 - 3 * thin), radius * math.sin(u), thin * math.sin(v))
                mesh.point(*(p if link % 2 == 0 else (p[0], p[2], -p[1])))
        at = lambda i, k: start + (i % sides) * around + k % around
        for i in range(sides):
            for k in range(around):
                mesh.quad(at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1))
    return mesh


def scan(chance):
    """A blob as a scanner sees it: noise on every point, pieces of the surface missing."""
    waves = [(chance.uniform(-1, 1), chance.randint(1, 4), chance.uniform(0, 6)) for _ in range(4)]
    noise = chance.choice((0.001, 0.003, 0.01))

    def surface(t, w):
        r = 1 + 0.12 * sum(a * math.cos(t) * math.sin(n * w + p) * math.sin(n * t) for a, n, p in waves)
        r *= 1 + noise * chance.gauss(0, 1)
        return (r * math.cos(t) * math.cos(w), 0.8 * r * math.cos(t) * math.sin(w), 0.7 * r * math.sin(t))
    mesh = sphere_like(surface, 26, 40)
    for _ in range(chance.randint(0, 5)):
        middle, size = mesh.points[chance.randrange(len(mesh.points))], chance.uniform(0.05, 0.3)
        mesh.faces = [f for f in mesh.faces if math.dist(mesh.points[f[0]], middle) > size]
    return mesh


FAMILIES = (superquadric, gear, bottle, chain, scan)


def make(folder, count):
    """Writes the first `count` shapes, all families in turn; those that are there stay."""
    for i in range(count):
        family = FAMILIES[i % len(FAMILIES)]
        path = pathlib.Path(folder) / family.__name__ / f"{i // len(FAMILIES):04}.off"
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            family(random.Random(i)).write(path)


if __name__ == "__main__":
    make(sys.argv[1], int(sys.argv[2]))
