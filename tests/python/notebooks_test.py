"""The notebooks of docs/notebooks run from their first cell to their last; 77 where Jupyter's or Matplotlib's packages are missing.

usage: notebooks_test.py FOLDER PICTURES      PICTURES: a folder for what they draw
"""
import base64
import importlib.util
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

folder, drawn = map(pathlib.Path, sys.argv[1:])
os.environ.setdefault("MPLBACKEND", "module://matplotlib_inline.backend_inline")
paths = sorted(folder.glob("*.ipynb"))
if not paths:
    sys.exit(f"{folder}: no notebooks")
for path in paths:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    needed = notebook.metadata.get("sqmap", {}).get("needs")
    if needed and importlib.util.find_spec(needed) is None:
        print(f"{path.stem}: skipped, there is no {needed} (Debian: python3-{needed})", flush=True)
        continue
    cells = [c for c in notebook.cells if c.cell_type == "code"]
    if any(c.outputs or c.execution_count for c in cells):
        sys.exit(f"{path.stem}: is kept without outputs: jupyter nbconvert --clear-output --inplace")
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    outputs = [o for c in cells for o in c.outputs]
    print("".join(o.get("text", "") for o in outputs), end="")
    pictures = [o["data"]["image/png"] for o in outputs if o.output_type == "display_data" and "image/png" in o["data"]]
    for i, picture in enumerate(pictures):
        (drawn / f"{path.stem}-{i}.png").write_bytes(base64.b64decode(picture))
    if not pictures:
        sys.exit(f"{path.stem}: draws nothing")
    print(f"{path.stem}: {len(notebook.cells)} cells, {len(pictures)} pictures", flush=True)
