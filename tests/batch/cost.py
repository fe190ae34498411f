#!/usr/bin/env python3
"""Measures what a batch on all cores takes beside single bakes one after another, by the clock and in CPU time. No test: it wants an idle machine.

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
    """Seconds by the clock, of CPU time with all that it has started, and by the clock after its last words."""
    start = last = time.monotonic()
    process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE)
    for _ in process.stdout:
        last = time.monotonic()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = status
    assert status == 0, arguments
    end = time.monotonic()
    return end - start, used.ru_utime + used.ru_stime, end - last


def driver_seconds(library, cpu):
    """CPU time of a run without that of its workers."""
    with open(library / "shards" / "00000-of-00001.measured.jsonl") as measured:
        return cpu - sum(json.loads(line)["seconds"] for line in measured)


def main():
    items, cores = take_number(200), len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory(dir=".") as name:
        meshes = pathlib.Path(name, "meshes")
        ellipsoids(meshes, items)
        single = [timed("bake", mesh, "-o", pathlib.Path(name, "one.sqmap"), "--threads", 1) for mesh in sorted(meshes.iterdir())]
        clock, cpu, _ = map(sum, zip(*single))
        print(f"{items} single bakes: {clock:.2f} s by the clock, {cpu:.2f} s of CPU time; over {cores} cores {clock / cores:.2f} s")
        for options in ((), ("--no-pictures",)):
            library = pathlib.Path(name, "-".join(["library", *options]))
            took, used, end = timed("batch", meshes, "-o", library, "--jobs", cores, "--progress", "json", *options)
            print(f"batch{' '.join(['', *options])}: {took:.2f} s ({100 * (took * cores / clock - 1):+.1f} %), of which {end:.2f} s after the "
                  f"last mesh; {used:.2f} s of CPU time ({100 * (used / cpu - 1):+.1f} %), driver "
                  f"{1000 * driver_seconds(library, used) / items:.2f} ms an item")


if __name__ == "__main__":
    main()
