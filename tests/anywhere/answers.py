#!/usr/bin/env python3
"""The hashes of answers.c through the Python package.

usage: answers.py MODEL
"""
import sys
import zlib

import numpy as np

import sqmap

COUNT = 100000


def uniform(i: np.ndarray) -> np.ndarray:
    """In [0, 1): of the i-th number, by integers alone."""
    h = i.astype(np.uint32) * np.uint32(0x9E3779B1)
    h = (h ^ (h >> np.uint32(16))) * np.uint32(0x85EBCA6B)
    h = (h ^ (h >> np.uint32(13))) * np.uint32(0xC2B2AE35)
    return (h ^ (h >> np.uint32(16))) / 4294967296.0


def points_of(model: sqmap.Model) -> np.ndarray:
    facts = model.facts
    i = np.arange(COUNT)
    u = 2 * uniform(3 * i[:, None] + np.arange(3)) - 1
    xyz = np.array(facts.centre[:]) + 1.25 * facts.radius * u
    if facts.has_exact:
        vertices = model.mesh[0]
        near = vertices[i % facts.vertices] + 0.03125 * facts.r_max * u
        xyz = np.where((i % 4 == 0)[:, None], xyz, near)
    xyz[1, 2], xyz[2, 1] = np.inf, 1e30
    return xyz


def crc(*arrays: np.ndarray) -> int:
    h = 0
    for a in arrays:
        if a.dtype == np.float64:
            a = np.where(np.isnan(a), -1e308, a)
        h = zlib.crc32(a.tobytes(), h)
    return h


def main() -> int:
    if len(sys.argv) != 2:
        return 64
    model = sqmap.Model.load(sys.argv[1])
    points = points_of(model)
    for number, layer in enumerate((1, 2, 3, "exact"), 1):
        a = model.query(points, layer)
        h = crc(a.contact, a.depth, a.normal, a.closest, a.part, a.certain, a.status)
        print(f"layer {number}    {h:08x}  {a.contact.sum()} inside")
    for band, name in ((0, "baked"), (np.inf, "infinite")):
        d = model.distances(points, band=band)
        print(f"distances  {crc(d.distance, d.gradient, d.closest, d.part, d.known, d.status):08x}  band {name}")
    if model.facts.has_exact:
        closest, distance, triangle = model.closest_point(points)
        print(f"closest    {crc(closest, distance, triangle.astype(np.uint32)):08x}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
