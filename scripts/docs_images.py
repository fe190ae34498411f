#!/usr/bin/env python3
"""Makes the pictures of docs/images from the demo's animals and from shapes that the program makes itself.

usage: docs_images.py [FOLDER]     FOLDER: where the animals are; default: the meshes that the demo fetched
"""
import pathlib
import struct
import sys
import tempfile
import zlib

import demo
import measure

IMAGES = measure.ROOT / "docs" / "images"
HERO = ("elephant", "camel", "triceratops")


def chunks(png):
    at = 8
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at : at + 8])
        yield kind, png[at + 8 : at + 8 + length]
        at += 12 + length


def unfiltered(data, height, stride):
    """Rows of an 8-bit RGB picture from the filtered bytes of its PNG."""
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind, row = data[y * (stride + 1)], bytearray(data[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        for x in range(stride):
            left, up, corner = (row[x - 3], above[x], above[x - 3]) if x >= 3 else (0, above[x], 0)
            if kind == 1:
                row[x] = (row[x] + left) & 255
            elif kind == 2:
                row[x] = (row[x] + up) & 255
            elif kind == 3:
                row[x] = (row[x] + (left + up) // 2) & 255
            elif kind == 4:
                guess = left + up - corner
                best = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))
                row[x] = (row[x] + best[2]) & 255
        rows.append(row)
        above = row
    return rows


def stacked(paths, path):
    """Pictures of one width, one below the other, with six bits a channel: half the bytes, and no difference to the eye."""
    coarse = bytes(min(255, (v + 2) // 4 * 4) for v in range(256))
    rows, width = [], 0
    for source in paths:
        png = list(chunks(source.read_bytes()))
        width, height = struct.unpack(">II", png[0][1][:8])
        data = zlib.decompress(b"".join(body for kind, body in png if kind == b"IDAT"))
        rows += [row.translate(coarse) for row in unfiltered(data, height, 3 * width)]
    encoded, above = bytearray(), bytes(3 * width)
    for row in rows:  # of the two filters that suit flat shading, the one with the smaller differences
        left = bytes((a - b) & 255 for a, b in zip(row, bytes(3) + row))
        up = bytes((a - b) & 255 for a, b in zip(row, above))
        cost = [sum(min(v, 256 - v) for v in filtered) for filtered in (left, up)]
        encoded += b"\x01" + left if cost[0] <= cost[1] else b"\x02" + up
        above = row
    out = b"\x89PNG\r\n\x1a\n"
    for kind, body in (
        (b"IHDR", struct.pack(">IIBBBBB", width, len(rows), 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(bytes(encoded), 9)),
        (b"IEND", b""),
    ):
        out += struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    path.write_bytes(out)
    print(f"{path.relative_to(measure.ROOT)}: {width} x {len(rows)}, {len(out) / 1000:.0f} kB")


def main():
    animals = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else demo.MESHES
    (IMAGES / "paper").mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        models = {}
        for name in HERO:
            models[name] = folder / f"{name}.sqmap"
            measure.run("bake", animals / f"{name}.off", "-o", models[name])
        for name in ("hand", "torus"):
            models[name] = folder / f"{name}.sqmap"
            measure.run("shapes", name, "-o", folder / f"{name}.obj")
            measure.run("bake", folder / f"{name}.obj", "-o", models[name])

        def row(name, kinds, size, *options):
            picture = folder / f"{name}-{kinds}.png"
            where = ("--azimuth", demo.AZIMUTH[name]) if name in demo.AZIMUTH else ()
            measure.run("render", models[name], "--what", kinds, "--size", size, *where, "-o", picture, *options)
            return picture

        stacked([row(n, "parts,superquadrics,error", "330x250") for n in HERO], IMAGES / "hero.png")
        stacked([row("hand", "parts,protrusion,curvature", "400x360")], IMAGES / "decomposition.png")
        # Of docs/guide/paper.md: the paper's own maps.
        models["paper"] = folder / "paper.sqmap"
        measure.run("bake", folder / "hand.obj", "-o", models["paper"], "--projection", "normal")
        for picture, kinds, size, *mesh in (("superquadrics", "parts,superquadrics", "450x420", folder / "hand.obj"),
                                            ("map", "map", "900x700")):
            measure.run("render", models["paper"], *mesh, "--what", kinds, "--size", size, "-o", IMAGES / "paper" / f"{picture}.png")
        measure.run("render", folder / "hand.obj", "--what", "protrusion,curvature", "--size", "450x420", "-o",
                    IMAGES / "paper" / "fields.png")
        stacked([row("triceratops", "superquadrics", "700x400")], IMAGES / "superquadrics.png")
        stacked([row("hand", "map", "1100x700")], IMAGES / "map.png")
        stacked([row("torus", "error", "600x400", "--up", "z", "--elevation", 35)], IMAGES / "error.png")


if __name__ == "__main__":
    main()
