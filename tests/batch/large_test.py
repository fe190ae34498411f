#!/usr/bin/env python3
"""A library of 100,000 rows that is made up: merged, its index verified and reported on within 500 MB of memory; and a model in an archive of
10 GB, which is opened by its key.

usage: large_test.py PROGRAM [ROWS]
"""
import hashlib
import json
import os
import pathlib
import random
import resource
import time
import unittest

from support import BatchTest, ellipsoids, rows, run, take_number

ROWS = take_number(100_000)
LINE = 194  # of an index, bytes
FINGERPRINT = f"{ROWS} items, SHA-256 made up"


def padded(size):
    return (size + 511) // 512 * 512


def header(name, size):
    """The header of a member, as POSIX ustar has it."""
    out = bytearray(512)
    for at, text in ((0, name.encode()), (100, b"0000644"), (108, b"0000000"), (116, b"0000000"), (124, b"%011o" % size),
                     (136, b"00000000000"), (148, b" " * 8), (156, b"0"), (257, b"ustar\x0000")):
        out[at:at + len(text)] = text
    out[148:155] = b"%06o\0" % sum(out)
    return bytes(out)


def member(name, data):
    return header(name, len(data)) + data.ljust(padded(len(data)), b"\0")


def outcome(chance, number):
    if number % 20 == 0:
        return {"verdict": "refused", "code": chance.choice(["E_FORMAT", "E_OPEN", "E_FLAT"]), "element": "mesh",
                "reason": f"no solid can be made of it ({number % 7})", "cure": "mend it"}
    error = chance.lognormvariate(-2.6, 0.6)
    return {"verdict": chance.choice(["accept"] * 6 + ["repaired", "closed", "wrapped"]), "format": "OFF", "notes": [], "moved": None,
            "triangles": chance.randrange(500, 50000), "r_max": 1.5, "parts": chance.randrange(1, 24),
            "bytes": int(chance.lognormvariate(13, 0.4)), "target_met": True, "doubtful": False,
            "measured": {"points": 4000, "missed": 0, "false_contacts": 0,
                         "eq35_percent": {"mean": error / 3, "p99": error * 1.2, "max": error * 5},
                         "depth_percent": {"median": error / 8, "p95": error / 2, "p99": error, "max": error * 3},
                         "normal_degrees_median": 3.1, "q2_percent": 2.5}}


def dumped(value):
    return json.dumps(value, separators=(",", ":"))


def write_shard(folder, number, shards, picture):
    """A finished shard whose models are 512 bytes of nothing."""
    chance = random.Random(number)
    items = sorted((hashlib.sha256(b"%d" % i).hexdigest(), f"shelf{i % 97:02}/object{i:06}.off", outcome(chance, i))
                   for i in range(number, ROWS, shards))
    table = "".join(sorted(dumped({"path": path, "key": key, **what}) + "\n" for key, path, what in items)).encode()
    models = [key for key, _, what in items if "bytes" in what]
    at, index, body = 1024 + padded(LINE * len(models)) + padded(len(table)), b"", []
    for key in models:
        model = hashlib.sha512(key.encode()).digest() * 8
        first, second = at + 512, at + 1024 + padded(len(picture))
        index += b"%s %015d %015d %s %015d %015d\n" % (key.encode(), second, len(model), hashlib.sha256(model).hexdigest().encode(), first,
                                                       len(picture))
        body += [member(key + ".png", picture), member(key + ".sqmap", model)]
        at = second + padded(len(model))
    archive = folder / f"{number:05}-of-{shards:05}.tar"
    archive.write_bytes(b"".join([member("index", index), member("rows.jsonl", table), *body, bytes(1024)]))
    archive.with_suffix(".manifest.txt").write_text(FINGERPRINT + "\n")
    archive.with_suffix(".measured.jsonl").write_text("".join(
        dumped({"key": key, "seconds": chance.lognormvariate(0.3, 0.5), "wall_seconds": 3.1, "peak_bytes": 30_000_000,
                "host": f"node{number % 8}"}) + "\n" for key, _, _ in items))


class Large(BatchTest):
    def test_many_rows(self):
        ellipsoids("meshes", 1)
        self.bake("meshes", "-o", "one")
        archive = pathlib.Path("one/shards/00000-of-00001.tar").read_bytes()
        line = archive[512:512 + LINE].split()
        picture = archive[int(line[4]):][:int(line[5])]
        shards = pathlib.Path("many/shards")
        shards.mkdir(parents=True)
        recipe = json.loads(pathlib.Path("one/batch.json").read_text())
        pathlib.Path("many/batch.json").write_text(dumped({**recipe, "shards": 20, "fingerprint": FINGERPRINT}))
        for i in range(20):
            write_shard(shards, i, 20, picture)
        for command in (("merge", "many"), ("verify", "many", "--index"), ("report", "many")):
            start, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
            self.bake(*command)
            used = resource.getrusage(resource.RUSAGE_CHILDREN)
            print(f"{command[0]}: {used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime:.1f} s of CPU time, "
                  f"{time.monotonic() - start:.1f} s, largest process so far {used.ru_maxrss / 1024:.0f} MB")
        self.assertLess(used.ru_maxrss * 1024, 500e6)
        with open("many/report/rows.csv") as table:
            self.assertEqual(sum(1 for _ in table), ROWS + 1)
        self.assertLess(pathlib.Path("many/report/index.html").stat().st_size, 120 * ROWS + 50_000)
        self.assertEqual(len(list(pathlib.Path("many/report/items").iterdir())), (ROWS + 63) // 64)

    def test_a_model_far_into_an_archive(self):
        ellipsoids("meshes", 1)
        self.bake("meshes", "-o", "one")
        key = rows("one")["0000.off"]["key"]
        archive = pathlib.Path("one/shards/00000-of-00001.tar").read_bytes()
        line = archive[512:512 + LINE].split()
        model = archive[int(line[1]):][:int(line[2])]
        far = 10_000_000_000 // 512 * 512
        line[1] = b"%015d" % far
        with open("one/shards/00000-of-00001.tar", "r+b") as out:
            out.seek(512)
            out.write(b" ".join(line) + b"\n")
            out.seek(far)
            out.write(model)
        self.bake("extract", "one", key, "-o", "far.sqmap")
        self.assertEqual(pathlib.Path("far.sqmap").read_bytes(), model)
        self.bake("verify", "one")
        os.truncate("one/shards/00000-of-00001.tar", far + 512)
        self.bake("extract", "one", key, "-o", "cut.sqmap", code=2)
        self.assertFalse(os.path.exists("cut.sqmap"))


if __name__ == "__main__":
    unittest.main()
