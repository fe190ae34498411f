"""Processor time of a point in batches of 10,000 and one a call, microseconds: the best of 15 rounds, a line for each call. The table of
costs in docs/guide/c.md is of this script; tests/capi/costs.c has the same points in C.

usage: costs.py MODEL"""
import sys
import time

import numpy as np
import sqmap

model = sqmap.Model.load(sys.argv[1])
facts, state, raw = model.facts, 1, []
for _ in range(30000):  # in the cube about the object's sphere
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    raw.append((state >> 11) * 2.0**-52 - 1)
points = facts.centre + facts.radius * np.array(raw).reshape(-1, 3)
single = [points[i:i + 1] for i in range(len(points))]


def best(call, over):
    taken = []
    for _ in range(15):
        start = time.process_time()
        for some in over:
            call(some)
        taken.append(time.process_time() - start)
    return 1e6 * min(taken) / len(points)


for name, call in (("signed_distance", model.signed_distance), ("contains", model.contains), ("distances", model.distances),
                   ("distances, band=0", lambda p, **o: model.distances(p, band=0, **o)), ("closest_point", model.closest_point),
                   ("query", model.query), ("query, exact", lambda p, **o: model.query(p, "exact", **o))):
    print(f"{name:27s} {best(lambda p: call(p, threads=1), [points]):.2f} in batches, {best(call, single):.2f} one a call")
