"""Shapes with fewer triangles than those of sqmap shapes: tests of the program take a quarter of the time with them."""
import math


def write_sphere(path, levels=3):
    """Writes an icosahedron of radius 1 as OBJ, divided so many times: 20 * 4^levels triangles."""
    g = (1 + 5 ** 0.5) / 2
    vertices = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1),
                (-g, 0, -1), (-g, 0, 1)]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
                 (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]

    def on_sphere(p):
        length = sum(c * c for c in p) ** 0.5
        return tuple(c / length for c in p)

    vertices = [on_sphere(p) for p in vertices]
    for _ in range(levels):
        middles = {}

        def middle(i, j):
            key = min(i, j), max(i, j)
            if key not in middles:
                middles[key] = len(vertices)
                vertices.append(on_sphere([a + b for a, b in zip(vertices[i], vertices[j])]))
            return middles[key]

        divided = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            divided += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = divided
    with open(path, "w") as out:
        out.write("".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices))
        out.write("".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in triangles))


def write_dumbbell(path, sides=20, rings=40):
    """Writes two balls of radius 0.5 on a bar of radius 0.2, turned about z, as OBJ."""
    def radius(z):
        return max(math.sqrt(max(0.25 - (abs(z) - 1) ** 2, 0)), 0.2 if abs(z) < 1 else 0)

    heights = [1.5 * math.sin(math.pi * (i / rings - 0.5)) for i in range(1, rings)]
    with open(path, "w") as out:
        for z in heights:
            for k in range(sides):
                angle = 2 * math.pi * k / sides
                out.write(f"v {radius(z) * math.cos(angle)!r} {radius(z) * math.sin(angle)!r} {z!r}\n")
        out.write("v 0 0 -1.5\nv 0 0 1.5\n")
        at = lambda ring, k: ring * sides + k % sides + 1
        last = len(heights) - 1
        for k in range(sides):
            out.write(f"f {at(0, k + 1)} {at(0, k)} {len(heights) * sides + 1}\n")
            out.write(f"f {at(last, k)} {at(last, k + 1)} {len(heights) * sides + 2}\n")
            for ring in range(last):
                out.write(f"f {at(ring, k)} {at(ring, k + 1)} {at(ring + 1, k + 1)}\nf {at(ring, k)} {at(ring + 1, k + 1)} {at(ring + 1, k)}\n")


def write_torus(path, around=24, across=10):
    """Writes a torus of radii 1 and 0.35 about z as OBJ."""
    with open(path, "w") as out:
        for i in range(around):
            for k in range(across):
                u, v = 2 * math.pi * i / around, 2 * math.pi * k / across
                r = 1 + 0.35 * math.cos(v)
                out.write(f"v {r * math.cos(u)!r} {r * math.sin(u)!r} {0.35 * math.sin(v)!r}\n")
        at = lambda i, k: i % around * across + k % across + 1
        for i in range(around):
            for k in range(across):
                a, b, c, d = at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)
                out.write(f"f {a} {b} {c}\nf {a} {c} {d}\n")
