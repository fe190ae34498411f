#!/usr/bin/env python3
"""Untested. Shards as tasks of a Ray cluster.

usage: ray_shards.py MANIFEST OUT SHARDS
"""
import subprocess
import sys

import ray


@ray.remote(num_cpus=1, max_retries=3)
def bake(shard, shards, manifest, out):
    subprocess.run(["sqmap", "batch", manifest, "-o", out, "--shard", f"{shard}/{shards}", "--jobs", "1"], check=True)


ray.init()
manifest, out, shards = sys.argv[1], sys.argv[2], int(sys.argv[3])
ray.get([bake.remote(i, shards, manifest, out) for i in range(shards)])
