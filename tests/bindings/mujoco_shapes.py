"""Meshes and models of the MuJoCo demonstrations: a bolt and a nut of M24 coarse thread, thrice as fine a pitch, and a peg with a
hole; metres.

usage: mujoco_shapes.py FOLDER      writes nut.xml and peg.xml
"""
import math
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


def main():
    folder = pathlib.Path(sys.argv[1])
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
