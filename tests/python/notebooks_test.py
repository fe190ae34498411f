"""The notebooks of docs/notebooks run from their first cell to their last; 77 where Jupyter's or Matplotlib's packages are missing.

A notebook whose metadata say so keeps its outputs, for readers who do not run it: its words and numbers have to come out again.

usage: notebooks_test.py FOLDER PICTURES [--update]      PICTURES: a folder for what they draw; --update: keeps this run's outputs
"""
import base64
import importlib.util
import io
import os
import pathlib
import sys

try:
    import ipykernel  # noqa: F401
    import matplotlib  # noqa: F401
    import nbclient
    import nbformat
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-nbclient python3-ipykernel python3-matplotlib)")
    sys.exit(77)

folder, drawn = map(pathlib.Path, sys.argv[1:3])
update = sys.argv[3:] == ["--update"]
os.environ.setdefault("MPLBACKEND", "module://matplotlib_inline.backend_inline")
paths = sorted(folder.glob("*.ipynb"))
if not paths:
    sys.exit(f"{folder}: no notebooks")


def words(cell):
    """All that a cell has printed, and how many pictures it has drawn."""
    return "".join(o.get("text", "") for o in cell.outputs), sum("image/png" in o.get("data", {}) for o in cell.outputs)


def keep(notebook, path):
    """Writes the notebook with its outputs; pictures have 256 colours, a third of the bytes."""
    from PIL import Image  # comes with Matplotlib
    for output in (o for c in notebook.cells if c.cell_type == "code" for o in c.outputs):
        output.pop("execution_count", None)
        if "image/png" in output.get("data", {}):
            small = io.BytesIO()
            Image.open(io.BytesIO(base64.b64decode(output.data["image/png"]))).convert("RGB").quantize(256).save(small, "png", optimize=True)
            output.data = {"image/png": base64.b64encode(small.getvalue()).decode()}
    for cell in notebook.cells:
        cell.metadata.clear()
    notebook.metadata.language_info = {"name": "python"}
    nbformat.write(notebook, path)


for path in paths:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    needed, kept = (notebook.metadata.get("sqmap", {}).get(key) for key in ("needs", "outputs"))
    if needed and importlib.util.find_spec(needed) is None:
        print(f"{path.stem}: skipped, there is no {needed} (Debian: python3-{needed})", flush=True)
        continue
    cells = [c for c in notebook.cells if c.cell_type == "code"]
    if not kept and any(c.outputs or c.execution_count for c in cells):
        sys.exit(f"{path.stem}: is kept without outputs: jupyter nbconvert --clear-output --inplace")
    before = [words(c) for c in cells]
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    if kept and update:
        keep(notebook, path)
    elif kept:
        for i, (cell, old) in enumerate(zip(cells, before)):
            if words(cell) != old:
                sys.exit(f"{path.stem}: cell {i + 1} of code says\n{words(cell)}\nand is kept with\n{old}\n  cure: --update, where the change is meant")
    outputs = [o for c in cells for o in c.outputs]
    print("".join(o.get("text", "") for o in outputs), end="")
    pictures = [o["data"]["image/png"] for o in outputs if o.output_type == "display_data" and "image/png" in o["data"]]
    for i, picture in enumerate(pictures):
        (drawn / f"{path.stem}-{i}.png").write_bytes(base64.b64decode(picture))
    if not pictures:
        sys.exit(f"{path.stem}: draws nothing")
    print(f"{path.stem}: {len(notebook.cells)} cells, {len(pictures)} pictures", flush=True)
