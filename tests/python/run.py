"""Runs a test of this folder; 77, skipped, where Debian's NumPy is missing.

usage: run.py TEST [ARGUMENT...]"""
import importlib.util
import pathlib
import runpy
import sys

if importlib.util.find_spec("numpy") is None:
    print("skipped: there is no NumPy (Debian: python3-numpy)")
    sys.exit(77)
del sys.argv[0]
sys.argv[0] = str(pathlib.Path(__file__).resolve().parent / sys.argv[0])
runpy.run_path(sys.argv[0], run_name="__main__")
