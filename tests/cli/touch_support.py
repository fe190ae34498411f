"""Shared by the tests of sqmap touch: the program, files that they write, and two baked shapes in a folder of their own."""
import base64
import csv
import json
import math
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

import coarse

CLIENT = os.path.abspath(sys.argv.pop(2))
PROGRAM = os.path.abspath(sys.argv.pop(1))
README = os.path.join(os.path.dirname(os.path.dirname(CLIENT)), "README.md")


def run(*arguments, timeout=300):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=timeout)


def read(path):
    with open(path) as text:
        return text.read()


def write(path, text):
    with open(path, "w") as out:
        out.write(text)


def rows_of(trace):
    with open(trace, newline="") as text:
        return list(csv.DictReader(line for line in text if not line.startswith("#")))


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("it never happened")
        time.sleep(0.01)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def write_png(path, width, height, grey):
    """grey(x, y): 0 to 255."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(grey(x, y) for x in range(width)) for y in range(height))
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_hand(path):
    """A glTF of 25 joints with WebXR's names and an octahedron about each, moved by that joint alone."""
    names, places = ["wrist"], [(0, 0, 0)]
    for finger, x, y, bones in (("thumb", 0.03, 0.02, (0.03, 0.03, 0.03)), ("index-finger", 0.025, 0.02, (0.06, 0.04, 0.03, 0.02)),
                                ("middle-finger", 0.005, 0.02, (0.06, 0.045, 0.03, 0.02)), ("ring-finger", -0.015, 0.02, (0.06, 0.04, 0.03, 0.02)),
                                ("pinky-finger", -0.03, 0.02, (0.055, 0.03, 0.02, 0.02))):
        parts = ["metacarpal", "phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"]
        if finger == "thumb":
            parts.remove("phalanx-intermediate")
        for part, bone in zip(parts, (*bones, 0)):
            names.append(f"{finger}-{part}")
            places.append((x, y, -0.01 if finger == "thumb" else 0))
            x, y = x + (0.6 * bone if finger == "thumb" else 0), y + bone
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    points = [tuple(p[k] + 0.008 * c[k] for k in range(3)) for p in places for c in corners]
    arrays = [("VEC3", 5126, b"".join(struct.pack("<3f", *p) for p in points), len(points)),
              ("VEC4", 5121, b"".join(struct.pack("<4B", i // 6, 0, 0, 0) for i in range(len(points))), len(points)),
              ("VEC4", 5126, struct.pack("<4f", 1, 0, 0, 0) * len(points), len(points)),
              ("SCALAR", 5123, b"".join(struct.pack("<3H", *(6 * j + v for v in f)) for j in range(25) for f in faces), 25 * 24),
              ("MAT4", 5126, b"".join(struct.pack("<16f", 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -p[0], -p[1], -p[2], 1) for p in places), 25)]
    blob, views, accessors = b"", [], []
    for kind, component, data, count in arrays:
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind})
        blob += data + b"\0" * (-len(data) % 4)
    accessors[0] |= {"min": [min(p[k] for p in points) for k in range(3)], "max": [max(p[k] for p in points) for k in range(3)]}
    write(path, json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [*range(26)]}],
        "nodes": [{"name": n, "translation": p} for n, p in zip(names, places)] + [{"mesh": 0, "skin": 0}],
        "skins": [{"joints": [*range(25)], "inverseBindMatrices": 4}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 3}]}],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(blob), "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode()}]}))


class TouchTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        coarse.write_sphere("sphere.obj")
        assert run("shapes", "torus", "-o", "torus.obj").returncode == 0
        for shape in ("sphere", "torus"):
            baked = run("bake", shape + ".obj", "-o", shape + ".sqmap")
            assert baked.returncode == 0, baked.stderr

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    def record(self, name, *options, model="sphere.sqmap", device="slide", seconds="1"):
        if os.path.exists(name):
            os.remove(name)
        result = run("touch", "--object", model, "--device", device, "--seconds", seconds, "--record", name, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def forces(self, name):
        return [math.hypot(*(float(row["z0_f" + axis]) for axis in "xyz")) for row in rows_of(name)]
