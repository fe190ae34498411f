#!/usr/bin/env python3
"""Makes docs/images/hand_joints.png: where verdicts of a bent hand are wrong; prints at which joints.

usage: joints.py [HAND.glb]     default: the hand that the demo fetched
"""
import pathlib
import subprocess
import sys
import tempfile

import demo
import docs_images
import measure


def main():
    hand = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else demo.CACHE / "hand.glb"
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / "joints.png"
        subprocess.run([measure.PROGRAM.with_name("sqmap_measure"), "joints", hand, picture], check=True)
        docs_images.stacked([picture], docs_images.IMAGES / "hand_joints.png")


if __name__ == "__main__":
    main()
