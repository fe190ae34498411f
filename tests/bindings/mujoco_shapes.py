"""Meshes and models of the MuJoCo demonstrations: a bolt and a nut of M24 coarse thread, thrice as fine a pitch, and a peg with a
hole; a pile of animals, where they are here; metres.

usage: mujoco_shapes.py FOLDER SHARED      writes nut.xml and peg.xml, and pile.xml of meshes of SHARED or of ./dev test's own
"""
import math
import os
import pathlib
import sys

PITCH, DEPTH = 0.006, 0.0022          # of the thread
RADIUS, GAP = 0.012, 0.0004           # of the bolt's core; of the nut around it
ROUND, ALONG = 48, 12                 # vertices a turn; rings a pitch


def thread(angle, z):
    """Height of the thread, 0 to DEPTH: a rounded ridge."""
    t = (z / PITCH - angle / (2 * math.pi)) % 1
    return DEPTH * (0.5 - 0.5 * math.cos(2 * math.pi * t))


def tube(outer, inner, z0, z1, rings):
    """A closed surface between two radii r(angle, z); inner None: solid."""
    vertices, triangles = [], []

    def ring(radius, z):
        first = len(vertices)
        for i in range(ROUND):
            a = 2 * math.pi * i / ROUND
            vertices.append((radius(a, z) * math.cos(a), radius(a, z) * math.sin(a), z))
        return first

    def join(a, b, flip):
        for i in range(ROUND):
            j = (i + 1) % ROUND
            for t in ((a + i, a + j, b + j), (a + i, b + j, b + i)):
                triangles.append(t[::-1] if flip else t)

    levels = [z0 + (z1 - z0) * k / rings for k in range(rings + 1)]
    outside = [ring(outer, z) for z in levels]
    for a, b in zip(outside, outside[1:]):
        join(a, b, False)
    if inner is None:
        for first, z, flip in ((outside[0], z0, True), (outside[-1], z1, False)):
            centre = len(vertices)
            vertices.append((0, 0, z))
            for i in range(ROUND):
                t = (first + i, first + (i + 1) % ROUND, centre)
                triangles.append(t[::-1] if flip else t)
        return vertices, triangles
    inside = [ring(inner, z) for z in levels]
    for a, b in zip(inside, inside[1:]):
        join(a, b, True)
    join(outside[0], inside[0], True)
    join(outside[-1], inside[-1], False)
    return vertices, triangles


def asset(name, mesh):
    vertices, triangles = mesh
    numbers = " ".join(f"{x:.7g}" for v in vertices for x in v)
    corners = " ".join(str(i) for t in triangles for i in t)
    return f'<mesh name="{name}" vertex="{numbers}" face="{corners}"/>'


def world(meshes, fixed, moving, position, friction):
    """A fixed mesh on a floor, and one that is free to move above it; gravity leans."""
    return f"""<mujoco>
  <option timestep="0.001" cone="elliptic" gravity="1.5 0.5 -9.81" iterations="50" tolerance="1e-10"/>
  <size njmax="2000" nconmax="500"/>
  <default><geom friction="{friction} 0 0" solref="0.004 1" solimp="0.95 0.99 0.0002" density="7800"/></default>
  <asset>{"".join(asset(n, m) for n, m in meshes.items())}</asset>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <geom type="mesh" mesh="{fixed}"/>
    <body name="{moving}" pos="{position}"><freejoint/><geom type="mesh" mesh="{moving}"/></body>
  </worldbody>
</mujoco>
"""


ANIMALS = ("bull", "camel", "cat", "cow", "dino", "elephant", "horse", "triceratops")


def read(path):
    """Vertices and triangles of an OBJ or OFF file."""
    lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    if path.suffix == ".obj":
        return ([tuple(map(float, w[1:4])) for w in lines if w[0] == "v"],
                [tuple(int(i.split("/")[0]) - 1 for i in w[1:4]) for w in lines if w[0] == "f"])
    count = int(lines[1][0])
    return [tuple(map(float, w[:3])) for w in lines[2:2 + count]], [tuple(map(int, w[1:4])) for w in lines[2 + count:]]


def of_size(mesh, size):
    """A mesh about the origin, as long as size."""
    vertices, triangles = mesh
    lo, hi = ([side(v[k] for v in vertices) for k in range(3)] for side in (min, max))
    scale = size / max(b - a for a, b in zip(lo, hi))
    return [tuple(scale * (x - (a + b) / 2) for x, a, b in zip(v, lo, hi)) for v in vertices], triangles


def pile(folders):
    """Six animals of 10 cm above one another, over a pit of five planes; None where there are fewer than three."""
    files = {}
    for folder in folders:
        for name in ANIMALS:
            found = sorted([*folder.glob(f"{name}_*.obj"), *folder.glob(f"{name}.off")])
            if found:
                files.setdefault(name, found[0])
    if len(files) < 3:
        return None
    names = (sorted(files) * 6)[:6]
    assets = "".join(asset(n, of_size(read(files[n]), 0.1)) for n in sorted(set(names)))
    bodies = "".join(f'<body pos="{0.02 * math.cos(2 * i):.3f} {0.02 * math.sin(2 * i):.3f} {0.08 + 0.07 * i:.2f}" euler="{50 * i} {20 * i} 0">'
                     f'<freejoint/><geom type="mesh" mesh="{n}"/></body>' for i, n in enumerate(names))
    walls = "".join(f'<geom type="plane" size="1 1 0.1" pos="{-0.06 * x:.2f} {-0.06 * y:.2f} 0" zaxis="{x} {y} 0.6"/>'
                    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)))
    return f"""<mujoco>
  <option timestep="0.002" cone="elliptic" iterations="50" tolerance="1e-10"/>
  <size njmax="12000" nconmax="4000"/>
  <default><geom friction="0.5 0.005 0.0001" solref="0.01 1" solimp="0.9 0.99 0.001" density="1000"/></default>
  <asset>{assets}</asset>
  <worldbody><geom type="plane" size="1 1 0.1"/>{walls}{bodies}</worldbody>
</mujoco>
"""


def main():
    folder = pathlib.Path(sys.argv[1])
    shared = pathlib.Path(os.environ.get("SQMAP_SHARED_DIR", sys.argv[2]))
    if animals := pile([shared / "meshes", pathlib.Path(__file__).resolve().parents[2] / "build/demo/test_meshes"]):
        (folder / "pile.xml").write_text(animals)
    length, height = 6 * PITCH, 2.5 * PITCH
    bolt = tube(lambda a, z: RADIUS + thread(a, z), None, 0, length, 6 * ALONG)
    nut = tube(lambda a, z: RADIUS + DEPTH + 0.006, lambda a, z: RADIUS + GAP + thread(a, z), 0, height, int(2.5 * ALONG))
    (folder / "nut.xml").write_text(world({"bolt": bolt, "nut": nut}, "bolt", "nut", f"0 0 {3 * PITCH}", 0.3))
    # A hole of 20.4 mm in a block, and a peg of 20 mm with its lower edge taken off.
    hole = tube(lambda a, z: 0.03, lambda a, z: 0.0102 + max(0.0, z - 0.028) * 0.5, 0, 0.03, 15)
    peg = tube(lambda a, z: 0.01 - max(0.0, 0.002 - z), None, 0, 0.05, 25)
    (folder / "peg.xml").write_text(world({"hole": hole, "peg": peg}, "hole", "peg", "0.0001 0 0.02", 0.2))


if __name__ == "__main__":
    main()
