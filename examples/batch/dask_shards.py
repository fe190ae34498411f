#!/usr/bin/env python3
"""Shards as tasks of a Dask cluster; a task that its worker loses is done again by another one.

usage: dask_shards.py MANIFEST OUT SHARDS [ADDRESS OF A SCHEDULER]     without one: as many processes as this machine has cores
"""
import os
import subprocess
import sys

from distributed import Client, LocalCluster

PROGRAM = os.environ.get("SQMAP", "sqmap")


def bake(shard, shards, manifest, out):
    subprocess.run([PROGRAM, "batch", manifest, "-o", out, "--shard", f"{shard}/{shards}", "--jobs", "1", "--progress", "none"],
                   check=True)


def main():
    manifest, out, shards = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), int(sys.argv[3])
    cluster = sys.argv[4] if len(sys.argv) > 4 else LocalCluster(n_workers=os.cpu_count(), threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        tasks = client.map(bake, range(shards), shards=shards, manifest=manifest, out=out, retries=3, pure=False)
        client.gather(tasks)


if __name__ == "__main__":
    main()
