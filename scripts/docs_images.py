#!/usr/bin/env python3
"""Makes the pictures of docs/images from the demo's animals and hand and from shapes that the program makes itself.

usage: docs_images.py [FOLDER]     FOLDER: where the animals are; default: the meshes that the demo fetched
"""
import pathlib
import subprocess
import sys
import tempfile

from PIL import Image, ImageDraw, ImageFont

import demo
import demo_meshes
import measure

IMAGES = measure.ROOT / "docs" / "images"
HERO = ("elephant", "camel", "triceratops")


def stacked(paths, path):
    """Pictures of one width, one below the other."""
    sheet(paths, 1, path)


def sheet(paths, columns, path, names=()):
    """Pictures of one size in rows, each below its name, with six bits a channel: half the bytes, and no difference to the eye."""
    pictures = [Image.open(p).convert("RGB") for p in paths]
    above = 20 if names else 0
    rows = [pictures[i:i + columns] for i in range(0, len(pictures), columns)]
    out = Image.new("RGB", (columns * pictures[0].width, sum(row[0].height + above for row in rows)), "white")
    for i, row in enumerate(rows):
        top = sum(r[0].height + above for r in rows[:i])
        for k, picture in enumerate(row):
            out.paste(picture, (k * pictures[0].width, top + above))
            if names:
                from matplotlib import font_manager  # its own font, on every machine that draws charts
                font = ImageFont.truetype(font_manager.findfont("DejaVu Sans"), 14)
                ImageDraw.Draw(out).text((k * pictures[0].width + 8, top + 4), names[i * columns + k], fill="#22252a", font=font)
    out.point([min(255, (v + 2) // 4 * 4) for v in range(256)] * 3).save(path, optimize=True)
    print(f"{path.relative_to(measure.ROOT)}: {out.width} x {out.height}, {path.stat().st_size / 1000:.0f} kB")


def wrong_at_joints(folder):
    """Draws where verdicts of a bent hand are wrong; prints at which joints."""
    hand = demo_meshes.CACHE / "hand.glb"
    if not hand.exists():
        return print("hand_joints.png stays as it is: the demo has fetched no hand")
    picture = folder / "joints.png"
    subprocess.run([measure.PROGRAM.with_name("sqmap_measure"), "joints", hand, picture], check=True)
    stacked([picture], IMAGES / "hand_joints.png")


def main():
    animals = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else demo_meshes.MESHES
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

        stacked([row(n, "parts,bounds,error", "330x250") for n in HERO], IMAGES / "hero.png")
        stacked([row("hand", "parts,protrusion,curvature", "400x360")], IMAGES / "decomposition.png")
        # Draws docs/guide/paper.md: the paper's own maps.
        models["paper"] = folder / "paper.sqmap"
        measure.run("bake", folder / "hand.obj", "-o", models["paper"], "--projection", "normal")
        for picture, kinds, size, *mesh in (("superquadrics", "parts,superquadrics", "450x420", folder / "hand.obj"),
                                            ("map", "map", "900x700", folder / "hand.obj")):
            measure.run("render", models["paper"], *mesh, "--what", kinds, "--size", size, "-o", IMAGES / "paper" / f"{picture}.png")
        measure.run("render", folder / "hand.obj", "--what", "protrusion,curvature", "--size", "450x420", "-o",
                    IMAGES / "paper" / "fields.png")
        # Draws docs/guide/robots.md: shapes that hold the parts of a hand.
        models["fingers"], pictures = folder / "fingers.sqmap", []
        measure.run("bake", folder / "hand.obj", "-o", models["fingers"], "--max-parts", "12", "--target-error", "2")
        for shape in ("hull", "capsule"):
            measure.run("export", models["fingers"], "--shape", shape, "-o", folder / f"{shape}.obj")
            pictures.append(folder / f"{shape}.png")
            measure.run("render", folder / f"{shape}.obj", "--what", "parts", "--size", "600x380", "--azimuth", 0, "-o",
                        pictures[-1])
        stacked(pictures, IMAGES / "colliders.png")
        stacked([row("triceratops", "superquadrics,bounds", "500x300")], IMAGES / "superquadrics.png")
        stacked([row("hand", "map", "1100x700")], IMAGES / "map.png")
        stacked([row("torus", "error", "600x400", "--up", "z", "--elevation", 35)], IMAGES / "error.png")
        wrong_at_joints(folder)


if __name__ == "__main__":
    main()
