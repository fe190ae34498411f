#!/usr/bin/env python3
"""Homer of CGAL's data on the skeleton and with the gait of the project's own figure, as a skinned glTF file to dress.
usage: rig.py HOMER.off OUT.glb      HOMER.off: in metres, soles at y = 0, looking along +z, 1.80 m tall
"""
import math
import pathlib
import struct
import sys
import typing

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python" / "sqmap"))
import _glb  # noqa: E402: the package's writer, without the package's library

# Joint, joint above it, where it is, m.
SKELETON = [
    ("pelvis", -1, (0.0, 0.66, 0.0)), ("chest", 0, (0.0, 0.86, 0.0)), ("head", 1, (0.0, 1.20, 0.0)),
    ("left upper arm", 1, (0.18, 1.07, 0.0)), ("left forearm", 3, (0.40, 0.96, 0.02)),
    ("right upper arm", 1, (-0.18, 1.07, 0.0)), ("right forearm", 5, (-0.40, 0.96, 0.02)),
    ("left thigh", 0, (0.14, 0.56, 0.0)), ("left shin", 7, (0.14, 0.33, 0.0)), ("left foot", 8, (0.14, 0.11, 0.0)),
    ("right thigh", 0, (-0.14, 0.56, 0.0)), ("right shin", 10, (-0.14, 0.33, 0.0)), ("right foot", 11, (-0.14, 0.11, 0.0)),
]
PERIOD, FRAMES = 1.1, 44


def eased(share):
    s = min(max(share, 0.0), 1.0)
    return s * s * (3 - 2 * s)


def weights_of(p):
    """Which joints move a place: shares along the limbs, blended about the joints. The four largest."""
    x, y, z = p
    side = "left" if x > 0 else "right"
    out = {}
    # Below the crotch legs are apart.
    leg = eased((0.62 - y) / 0.18) * (1 if y < 0.44 else eased(abs(x) / 0.12))
    knee, ankle = eased((0.40 - y) / 0.14), eased((0.14 - y) / 0.07)
    out[f"{side} foot"] = leg * ankle
    out[f"{side} shin"] = leg * knee * (1 - ankle)
    out[f"{side} thigh"] = leg * (1 - knee)
    rest = 1 - leg
    arm = rest * eased((abs(x) - 0.13 - 0.25 * max(0.0, 1.02 - y)) / 0.14) * eased((y - 0.86) / 0.08) * eased((1.34 - y) / 0.12)
    elbow = eased((z - 0.02) / 0.12) * eased((abs(x) - 0.26) / 0.08)
    out[f"{side} forearm"] = arm * elbow
    out[f"{side} upper arm"] = arm * (1 - elbow)
    rest -= arm
    head, chest = eased((y - 1.10) / 0.16), eased((y - 0.72) / 0.24)
    out["head"] = rest * head
    out["chest"] = rest * (1 - head) * chest
    out["pelvis"] = rest * (1 - head) * (1 - chest)
    largest = sorted(((w, n) for n, w in out.items() if w > 1e-4), reverse=True)[:4]
    total = sum(w for w, _ in largest)
    return [(n, w / total) for w, n in largest]


def about(axis, angle):
    q = [0.0, 0.0, 0.0, math.cos(angle / 2)]
    q[axis] = math.sin(angle / 2)
    return tuple(q)


def gait(phase):
    """The turn of each joint, and the lift of the first, at a phase of two steps (src/sim/walker.cpp, with shorter steps)."""
    swing, turns = 0.30 * math.sin(phase), {}
    turns["pelvis"] = about(1, -0.06 * math.sin(phase))
    turns["chest"] = about(1, 0.12 * math.sin(phase))
    turns["head"] = about(1, -0.06 * math.sin(phase))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        leg = sign * swing
        turns[f"{side} thigh"] = about(0, -leg)
        turns[f"{side} shin"] = about(0, 0.08 + 0.45 * max(0.0, sign * math.cos(phase)) ** 2)
        turns[f"{side} foot"] = about(0, 0.15 * leg)
        turns[f"{side} upper arm"] = about(0, 0.6 * leg)
        turns[f"{side} forearm"] = about(0, -0.15 * abs(leg))
    return turns, 0.015 * math.cos(2 * phase)


class Glb(_glb.Glb):
    """The arrays of a glTF file, of tuples."""

    def add_values(self, values, form, kind, component, bounded=False):
        """The number of a new accessor; form: of struct, for one value. bounded: with its least and greatest values."""
        packed = [struct.pack("<" + form, *value) for value in values]
        columns = list(zip(*(struct.unpack("<" + form, value) for value in packed))) if bounded else []
        bounds = ([min(c) for c in columns], [max(c) for c in columns]) if bounded else None
        return self.add(b"".join(packed), len(values), kind, component, bounds=bounds)


class Figure(typing.NamedTuple):
    """A mesh that a skeleton moves."""
    places: list
    triangles: list
    skeleton: list  # joint, number of the joint above it or -1, where it is
    weights: list   # of each place (joint, weight), at most four
    times: list     # s
    turns: list     # at each time the quaternions of joints that are turned
    lifts: list     # at each time how far the first joint is lifted


def primitive_of(glb, figure):
    """The mesh with its weights."""
    number = {name: i for i, (name, _, _) in enumerate(figure.skeleton)}
    four = [(list(w) + [("", 0.0)] * 4)[:4] for w in figure.weights]
    return {
        "attributes": {
            "POSITION": glb.add_values(figure.places, "3f", "VEC3", 5126, bounded=True),
            "JOINTS_0": glb.add_values([[number.get(n, 0) if w > 0 else 0 for n, w in v] for v in four], "4B", "VEC4", 5121),
            "WEIGHTS_0": glb.add_values([[w for _, w in v] for v in four], "4f", "VEC4", 5126)
        },
        "indices": glb.add_values([[c] for t in figure.triangles for c in t], "I", "SCALAR", 5125)
    }


def nodes_of(skeleton):
    """The nodes of the joints, each where it is from the joint above it."""
    nodes = []
    for name, parent, at in skeleton:
        above = skeleton[parent][2] if parent >= 0 else (0, 0, 0)
        nodes.append({"name": name, "translation": [a - b for a, b in zip(at, above)]})
    for i, (_, parent, _) in enumerate(skeleton):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(i)
    return nodes


def animation_of(glb, figure):
    at, samplers, channels = glb.add_values([[t] for t in figure.times], "f", "SCALAR", 5126, bounded=True), [], []

    def channel(joint, path, output):
        channels.append({"sampler": len(samplers), "target": {"node": joint, "path": path}})
        samplers.append({"input": at, "output": output, "interpolation": "LINEAR"})

    for i, (name, _, _) in enumerate(figure.skeleton):
        channel(i, "rotation", glb.add_values([t.get(name, (0, 0, 0, 1)) for t in figure.turns], "4f", "VEC4", 5126))
    x, y, z = figure.skeleton[0][2]
    channel(0, "translation", glb.add_values([(x, y + lift, z) for lift in figure.lifts], "3f", "VEC3", 5126))
    return {"name": "walk", "channels": channels, "samplers": samplers}


def write_glb(path, figure):
    glb, nodes = Glb(), nodes_of(figure.skeleton)
    primitive = primitive_of(glb, figure)
    binds = glb.add_values([[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1] for _, _, (x, y, z) in figure.skeleton], "16f", "MAT4", 5126)
    animation = animation_of(glb, figure)
    nodes.append({"name": "body", "mesh": 0, "skin": 0})
    document = {"scene": 0, "scenes": [{"nodes": [0, len(nodes) - 1]}], "nodes": nodes, "meshes": [{"primitives": [primitive]}],
                "skins": [{"joints": list(range(len(figure.skeleton))), "inverseBindMatrices": binds}], "animations": [animation]}
    pathlib.Path(path).write_bytes(glb.file("sqmap, rig.py", document))


def read_off(path):
    with open(path) as file:
        words = file.read().split()
    vertices, triangles = int(words[1]), int(words[2])
    numbers = words[4:]
    places = [tuple(map(float, numbers[3 * i:3 * i + 3])) for i in range(vertices)]
    corners = numbers[3 * vertices:]
    return places, [tuple(map(int, corners[4 * i + 1:4 * i + 4])) for i in range(triangles)]


def rig(mesh, target):
    places, triangles = read_off(mesh)
    times = [PERIOD * k / FRAMES for k in range(FRAMES + 1)]
    turns, lifts = zip(*(gait(2 * math.pi * t / PERIOD) for t in times))
    write_glb(target, Figure(places, triangles, SKELETON, [weights_of(p) for p in places], times, turns, lifts))


if __name__ == "__main__":
    rig(*sys.argv[1:3])
