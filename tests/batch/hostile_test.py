#!/usr/bin/env python3
"""Meshes that hang, crash, take all memory or are none: each has its row, and the others do not wait for them.

usage: hostile_test.py PROGRAM
"""
import json
import os
import pathlib
import struct
import unittest

from support import BatchTest, ellipsoids, rows, run


def grid(path, n):
    """A closed box of 12 n^2 triangles: more work than the test's limit allows."""
    index, points, faces = {}, [], []

    def at(p):
        if p not in index:
            index[p] = len(points)
            points.append(p)
        return index[p]

    for axis in range(3):
        for side in (0, n):
            for i in range(n):
                for k in range(n):
                    corner = lambda a, b: at(tuple([side if x == axis else (a if x == (axis + 1) % 3 else b) for x in range(3)]))
                    a, b, c, d = corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)
                    faces += [(a, b, c), (a, c, d)] if side else [(a, c, b), (a, d, c)]
    with open(path, "w") as out:
        out.write(f"OFF\n{len(points)} {len(faces)} 0\n")
        out.writelines("%d %d %d\n" % p for p in points)
        out.writelines("3 %d %d %d\n" % f for f in faces)


def hostile(folder):
    """Writes the meshes; {name: verdicts that are right}."""
    folder = pathlib.Path(folder)
    (folder / "empty.off").write_bytes(b"")
    (folder / "zeros.stl").write_bytes(b"\0" * 5000)
    (folder / "nan.obj").write_text("v nan 0 0\nv 1 0 0\nv 0 inf 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n")
    (folder / "promise.stl").write_bytes(b"\0" * 80 + struct.pack("<I", 0xFFFFFFFF) + b"\0" * 50)
    (folder / "cut.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 1 << 30))
    (folder / "huge.ply").write_text("ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n"
                                     "element face 4000000000\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n")
    (folder / "flat.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    (folder / "index.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9999999999999\n")
    (folder / "words.ply").write_bytes(os.urandom(3000))
    refused = {name: ("refused",) for name in os.listdir(folder) if not name[:4].isdigit()}
    grid(folder / "work.off", 70)
    return refused | {"work.off": ("timeout",)}


class Hostile(BatchTest):
    def test_every_item_has_a_row_and_the_good_ones_are_baked(self):
        ellipsoids("meshes", 6)
        wanted = hostile("meshes")
        os.mkfifo("meshes/pipe.off")
        pathlib.Path("m.txt").write_text("\n".join(sorted(os.listdir("meshes"))))
        self.bake("m.txt", "--root", "meshes", "-o", "out", "--jobs", "2", "--time", "2")
        found = rows("out")
        for name, verdicts in wanted.items():
            self.assertIn(found[name]["verdict"], verdicts, found[name])
            self.assertNotEqual(found[name]["reason"], "", name)
        self.assertEqual(found["pipe.off"]["verdict"], "unreadable")
        self.assertEqual([found[f"{i:04}.off"]["verdict"] for i in range(6)], 6 * ["accept"])
        self.assertEqual(len(found), len(wanted) + 7)
        self.assert_whole("out")

    def test_caps_are_verdicts_that_can_be_tried_again(self):
        ellipsoids("meshes", 2)
        grid("meshes/work.off", 40)
        self.bake("meshes", "-o", "out", "--time", "1")
        self.assertEqual(rows("out")["work.off"]["verdict"], "timeout")
        self.bake("meshes", "-o", "out", "--time", "60")
        self.assertEqual(rows("out")["work.off"]["verdict"], "timeout", "a verdict is final until it is retried")
        again = self.bake("retry", "out", "--verdict", "timeout,memory", "--time", "120", "--progress", "json")
        seconds = {row["path"]: row["seconds"] for row in map(json.loads, again.stdout.splitlines())}
        self.assertEqual([seconds["0000.off"], seconds["0001.off"]], [0, 0])
        self.assertIn(rows("out")["work.off"]["verdict"], ("accept", "repaired"))
        self.bake("meshes", "-o", "direct", "--time", "120")
        self.assertEqual(pathlib.Path("direct/shards/00000-of-00001.tar").read_bytes(),
                         pathlib.Path("out/shards/00000-of-00001.tar").read_bytes())
        self.bake("meshes", "-o", "small", "--memory", "3MB")
        self.assertEqual({row["verdict"] for row in rows("small").values()}, {"memory"})
        self.bake("meshes", "-o", "short", "--output-size", "20000", "--time", "120")
        self.assertEqual({row["verdict"] for row in rows("short").values()}, {"output"})


if __name__ == "__main__":
    unittest.main()
