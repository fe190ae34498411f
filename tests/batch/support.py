"""Shared by the tests of `sqmap batch`: the program, small meshes, rows."""
import hashlib
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else "sqmap"
BAKED = ("accept", "repaired", "closed", "wrapped")
COARSE = ("--target-error", "5")  # a third of the time of the default: these tests are about libraries, not about models
SUBCOMMANDS = ("extract", "gc", "list", "merge", "report", "retry", "verify")


def take_number(default):
    """The next argument, if it is a number: how large a test is. Others are unittest's."""
    return int(sys.argv.pop(1)) if len(sys.argv) > 1 and sys.argv[1].isdigit() else default


def run(*arguments, **options):
    """The program's result."""
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, **options)


def ellipsoid(path, axes, rings=12, sides=16):
    """Writes a closed mesh of some 360 triangles as OFF."""
    points = [(0, 0, axes[2])]
    for i in range(1, rings):
        for k in range(sides):
            t, f = math.pi * i / rings, 2 * math.pi * k / sides
            points.append((axes[0] * math.sin(t) * math.cos(f), axes[1] * math.sin(t) * math.sin(f), axes[2] * math.cos(t)))
    points.append((0, 0, -axes[2]))
    ring = lambda i, k: 1 + (i - 1) * sides + k % sides
    faces = [(0, ring(1, k), ring(1, k + 1)) for k in range(sides)]
    for i in range(1, rings - 1):
        for k in range(sides):
            faces += [(ring(i, k), ring(i + 1, k), ring(i + 1, k + 1)), (ring(i, k), ring(i + 1, k + 1), ring(i, k + 1))]
    faces += [(ring(rings - 1, k), len(points) - 1, ring(rings - 1, k + 1)) for k in range(sides)]
    pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w") as out:
        out.write(f"OFF\n{len(points)} {len(faces)} 0\n")
        out.writelines("%.9g %.9g %.9g\n" % p for p in points)
        out.writelines("3 %d %d %d\n" % f for f in faces)


def ellipsoids(folder, count, seed=1, **size):
    """Meshes of different shapes, numbered; the same for the same seed."""
    chance = random.Random(seed)
    for i in range(count):
        ellipsoid(pathlib.Path(folder) / f"{i:04}.off", [chance.uniform(0.3, 1) for _ in range(3)], **size)


def rows(library):
    """Rows of a library, by path, or by path and member."""
    listed = run("batch", "list", library, "--json")
    assert listed.returncode == 0, listed.stderr
    out = {}
    for line in listed.stdout.splitlines():
        row = json.loads(line)
        out[row["path"] + ("/" + row["member"] if "member" in row else "")] = row
    return out


def digests(folder, pattern="*.tar"):
    """SHA-256 of a folder's archives, by name."""
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(pathlib.Path(folder).glob(pattern))}


def children(pid):
    """Processes that a process has started and that are alive."""
    found = subprocess.run(["ps", "--no-headers", "-o", "pid", "--ppid", str(pid)], capture_output=True, text=True).stdout
    return [int(word) for word in found.split()]


class BatchTest(unittest.TestCase):
    """Each test in a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        before = os.getcwd()
        os.chdir(folder.name)
        self.addCleanup(os.chdir, before)

    def bake(self, *arguments, code=0):
        """Its models are coarse, where the arguments do not name a subcommand."""
        done = run("batch", *arguments, *(() if arguments[:1] and arguments[0] in SUBCOMMANDS else COARSE))
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def assert_whole(self, library):
        """Nothing in it is damaged, and nothing is left over."""
        checked = run("batch", "verify", library)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        left = [p for p in pathlib.Path(library).rglob("*") if p.suffix in (".tmp", ".part") or p.name.endswith((".new", ".old"))]
        self.assertEqual(left, [])
