"""Random calls, so many or for so many seconds: every one answers or raises sqmap.Error, and no force is beyond its limit.

usage: random_calls.py CALLS|SECONDSs [SEED]"""
import itertools
import random
import sys
import time

import numpy as np
import sqmap
from support import ball, ball_model, moved, torus, torus_model

CHOICES = [None, 0, 1, -1, 3, 1e300, -1e300, float("nan"), float("inf"), True, "exact", "auto", "", "x", b"\0", [], [[]], (), {},
           object(), np.zeros(3), np.zeros((0, 3)), np.zeros((5, 3)), np.full((5, 3), np.nan), np.eye(4), np.eye(3),
           np.full((4, 4), np.nan), moved(1, 2, 3), np.zeros((2, 3), np.float32)[:, ::-1], np.arange(12).reshape(4, 3)]


def value(rng, things):
    if things and rng.random() < 0.5:
        return rng.choice(things)
    if rng.random() < 0.4:
        return np.array([[rng.uniform(-2, 2) for _ in range(3)] for _ in range(rng.randrange(20))]).reshape(-1, 3)
    return rng.choice(CHOICES)


def main():
    length, seed = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1
    rng = random.Random(seed)
    data = torus_model().to_bytes()
    things = [ball_model(), torus_model(), sqmap.Probe(ball()[0]), sqmap.Probe(*ball()), sqmap.Workspace(100), sqmap.Session(ball_model()),
              sqmap.Body(ball_model()), sqmap.Scene(torus_model())]
    keep = len(things)
    doors = [sqmap.Probe, sqmap.Workspace, sqmap.Session, sqmap.Body, sqmap.Scene, sqmap.query_probe, sqmap.query_pair,
             sqmap.query_contacts, sqmap.first_touch, sqmap.clearance, sqmap.is_within, sqmap.overlap, sqmap.separation,
             sqmap.Model.load, sqmap.bake, sqmap.Model.from_bytes]
    methods = ["query", "distances", "signed_distance", "contains", "closest_point", "tick", "simulate", "compute_occupancy",
               "compute_signed_distance", "compute_closest_points", "add_model", "mesh", "info", "facts", "close"]
    answered, refused = 0, 0
    begin = time.monotonic()
    for done in itertools.count():
        if (time.monotonic() - begin > float(length[:-1])) if length.endswith("s") else done >= int(length):
            break
        if rng.random() < 0.1:  # a model whose bytes were changed
            changed = bytearray(data[: rng.randrange(len(data) + 1)] if rng.random() < 0.5 else data)
            for _ in range(rng.randrange(4)):
                if changed:
                    changed[rng.randrange(len(changed))] = rng.randrange(256)
            door, arguments = sqmap.Model.from_bytes, [bytes(changed)]
        elif rng.random() < 0.5:
            thing = rng.choice(things)
            name = rng.choice([m for m in methods if hasattr(type(thing), m)] or ["__class__"])
            if name == "close" and (things.index(thing) < keep):
                continue
            door, arguments = (lambda *a, t=thing, n=name: getattr(t, n)(*a) if callable(getattr(t, n)) else getattr(t, n)), \
                [value(rng, things) for _ in range(rng.randrange(3))]
        else:
            door, arguments = rng.choice(doors), [value(rng, things) for _ in range(rng.randrange(4))]
        try:
            answer = door(*arguments)
            answered += 1
        except (sqmap.Error, TypeError):  # TypeError: of a wrong number of arguments
            refused += 1
            continue
        if isinstance(answer, sqmap.Force):
            assert np.isfinite(answer.force).all() and np.linalg.norm(answer.force) <= 2 + 1e-12, answer
        if isinstance(answer, (sqmap.Model, sqmap.Probe, sqmap.Session, sqmap.Workspace)):
            things.append(answer)
            if len(things) > 40:
                things.pop(rng.randrange(keep, len(things)))
    print(f"{answered} calls answered, {refused} refused (seed {seed})")
    assert answered > 20 and refused > 20


if __name__ == "__main__":
    main()
