#!/usr/bin/env python3
"""What a batch on all cores takes beside single bakes one after another, by the clock and in CPU time. No test: it wants an idle machine.

usage: cost.py PROGRAM [ITEMS]     ITEMS: default 200
"""
import json
import os
import pathlib
import subprocess
import tempfile
import time

from support import PROGRAM, ellipsoids, take_number


def timed(*arguments):
    """Seconds by the clock, and of CPU time with all that it has started."""
    start = time.monotonic()
    process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = status
    assert status == 0, arguments
    return time.monotonic() - start, used.ru_utime + used.ru_stime


def batch(meshes, library, cores, *options):
    """Seconds by the clock, of CPU time, and of that the driver's own."""
    clock, cpu = timed("batch", meshes, "-o", library, "--jobs", cores, "--progress", "none", *options)
    with open(library / "shards" / "00000-of-00001.measured.jsonl") as measured:
        return clock, cpu, cpu - sum(json.loads(line)["seconds"] for line in measured)


def main():
    items, cores = take_number(200), len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        ellipsoids(folder / "meshes", items)
        clock = cpu = 0
        for mesh in sorted((folder / "meshes").iterdir()):
            took = timed("bake", mesh, "-o", folder / "one.sqmap", "--threads", 1)
            clock, cpu = clock + took[0], cpu + took[1]
        print(f"{items} single bakes: {clock:.2f} s by the clock, {cpu:.2f} s of CPU time; over {cores} cores {clock / cores:.2f} s")
        for options in ((), ("--no-pictures",)):
            took = batch(folder / "meshes", folder / "-".join(["library", *options]), cores, *options)
            print(f"batch{' '.join(['', *options])}: {took[0]:.2f} s ({100 * (took[0] * cores / clock - 1):+.1f} %), {took[1]:.2f} s of CPU time "
                  f"({100 * (took[1] / cpu - 1):+.1f} %), driver {1000 * took[2] / items:.2f} ms an item")


if __name__ == "__main__":
    main()
