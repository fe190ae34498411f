#!/usr/bin/env python3
"""Meshes that hang, crash, take all memory or are none: each has its row, and the others do not wait for them.

usage: hostile_test.py PROGRAM [ITEMS]     ITEMS: default 40; one in twenty is hostile, and one of each kind at least
"""
import contextlib
import json
import os
import pathlib
import random
import signal
import struct
import subprocess
import tarfile
import time
import unittest
import zipfile

from support import COARSE, PROGRAM, BatchTest, children, ellipsoids, rows, take_number

ITEMS = take_number(40)
UNREADABLE, REFUSED, TIMEOUT, MEMORY = ("unreadable",), ("refused",), ("timeout",), ("memory",)
BAKED = ("accept", "repaired")


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


def crowd(path, count):
    """As many triangles in one corner: a large file that is read, and takes memory."""
    with open(path, "wb") as out:
        out.write(b"\0" * 80 + struct.pack("<I", count))
        for k in range(count):
            out.write(struct.pack("<12fH", 0, 0, 1, k, 0, 0, k + 1, 0, 0, k, 1 + k % 7, 0, 0))


def written(name, data):
    """A kind of hostile mesh that is a few bytes; b"%d" in them is its number, so that no two are alike."""
    return name, lambda path, number: path.write_bytes(data.replace(b"%d", b"%d" % number)), REFUSED


def bomb(path, number):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"bomb{number}.off", b"0" * 50_000_000)


def leaving(path, number):
    with tarfile.open(path, "w") as archive:
        archive.addfile(tarfile.TarInfo(f"../../escaped{number}.off"))


KINDS = (
    ("hang{}.off", lambda path, number: grid(path, 70 + number), TIMEOUT),
    ("memory{}.stl", lambda path, number: crowd(path, 500_000 + number), MEMORY),
    written("empty{}.off", b""),
    written("zeros{}.stl", b"\0" * 5000 + b"%d"),
    written("nan{}.obj", b"# %d\nv nan 0 0\nv 1 0 0\nv 0 inf 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"),
    written("promise{}.stl", b"\0" * 80 + struct.pack("<I", 0xFFFFFFFF) + b"\0" * 50 + b"%d"),
    written("cut{}.glb", b"glTF" + struct.pack("<II", 2, 1 << 30) + b"%d"),
    written("huge{}.ply", b"ply\nformat ascii 1.0\ncomment %d\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
                          b"property float z\nelement face 4000000000\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"),
    written("flat{}.off", b"OFF\n3 1 0\n0 0 0\n%d 0 0\n0 1 0\n3 0 1 2\n"),
    written("index{}.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9999999999999\n# %d\n"),
    ("words{}.ply", lambda path, number: path.write_bytes(random.Random(number).randbytes(3000)), REFUSED),
    ("pipe{}.off", lambda path, _: os.mkfifo(path), UNREADABLE),
    ("bomb{}.zip", bomb, UNREADABLE),
    ("leaving{}.tar", leaving, UNREADABLE))


def hostile(folder, count):
    """Writes meshes of all kinds by turns; {name: verdicts that are right}."""
    out = {}
    for number in range(count):
        name, write, verdicts = KINDS[number % len(KINDS)]
        name = name.format(number)
        write(pathlib.Path(folder) / name, number)
        out[name] = verdicts
    return out


class Hostile(BatchTest):
    def test_every_item_has_a_row_and_the_good_ones_are_baked(self):
        count = max(ITEMS // 20, len(KINDS))
        ellipsoids("meshes", ITEMS - count, rings=6, sides=8)
        good = set(os.listdir("meshes"))
        wanted = hostile("meshes", count)
        names = sorted(os.listdir("meshes"))
        random.Random(1).shuffle(names)
        pathlib.Path("m.txt").write_text("\n".join(names))
        start = time.monotonic()
        self.bake("m.txt", "--root", "meshes", "-o", "out", "--jobs", "2", "--time", "2", "--memory", "200MB",
                  "--max-bytes", "40MB")
        took = time.monotonic() - start
        found = {row["path"]: row for row in rows("out").values()}
        for name, verdicts in wanted.items():
            self.assertIn(found[name]["verdict"], verdicts, found[name])
            self.assertNotEqual(found[name]["reason"], "", name)
        self.assertEqual({name: row["verdict"] for name, row in found.items() if name in good}, {name: "accept" for name in good})
        self.assertEqual(len(found), ITEMS)
        self.assertEqual(sorted(os.listdir()), ["m.txt", "meshes", "out"])
        self.assert_whole("out")
        with open("out/shards/00000-of-00001.measured.jsonl") as measured:
            busy = sum(json.loads(line)["wall_seconds"] for line in measured)
        print(f"{ITEMS} items, {count} of them hostile: {took:.1f} s; two workers were busy {50 * busy / took:.1f} % of it")

    def test_a_process_that_does_nothing_is_ended_by_the_clock(self):
        ellipsoids("meshes", 3)
        driver = subprocess.Popen([PROGRAM, "batch", "meshes", "-o", "out", "--jobs", "2", "--time", "1", *COARSE], stderr=subprocess.DEVNULL)
        worker = self.first_worker(driver)
        os.kill(worker, signal.SIGSTOP)
        self.assertEqual(driver.wait(), 0)
        verdicts = sorted(row["verdict"] for row in rows("out").values())
        self.assertEqual(verdicts, ["accept", "accept", "timeout"])
        self.assert_whole("out")

    def first_worker(self, driver):
        """One that has set its limits, and that the kernel would end before the driver where memory runs out."""
        while driver.poll() is None:
            for worker in children(driver.pid):
                with contextlib.suppress(OSError):
                    if pathlib.Path(f"/proc/{worker}/oom_score_adj").read_text() == "1000\n":
                        return worker
            time.sleep(0.002)
        self.fail("the driver ended without a worker that the kernel would end first")

    def test_a_process_that_is_killed_again_and_again_is_a_row(self):
        """As the kernel does it where memory runs out."""
        ellipsoids("meshes", 1)
        driver = subprocess.Popen([PROGRAM, "batch", "meshes", "-o", "out", *COARSE], stderr=subprocess.DEVNULL)
        while driver.poll() is None:
            for worker in children(driver.pid):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(worker, signal.SIGKILL)
        self.assertEqual(driver.returncode, 0)
        self.assertEqual(rows("out")["0000.off"]["verdict"], "killed")
        self.bake("meshes", "-o", "out")
        self.assertEqual(rows("out")["0000.off"]["verdict"], "accept")
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
        self.assertIn(rows("out")["work.off"]["verdict"], BAKED)
        self.bake("meshes", "-o", "direct", "--time", "120")
        self.assertEqual(pathlib.Path("direct/shards/00000-of-00001.tar").read_bytes(),
                         pathlib.Path("out/shards/00000-of-00001.tar").read_bytes())
        self.bake("meshes", "-o", "small", "--memory", "3MB")
        self.assertEqual({row["verdict"] for row in rows("small").values()}, {"memory"})
        self.bake("meshes", "-o", "short", "--output-size", "20000", "--time", "120")
        self.assertEqual({row["verdict"] for row in rows("short").values()}, {"output"})


if __name__ == "__main__":
    unittest.main()
