"""The notebooks of docs/notebooks run from their first cell to their last; 77 where Jupyter's or Matplotlib's packages are missing.

usage: notebooks_test.py FOLDER NOTEBOOK [PICTURES]      PICTURES: a folder for what they draw
"""
import base64
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

folder, name = pathlib.Path(sys.argv[1]), sys.argv[2]
os.environ.setdefault("MPLBACKEND", "module://matplotlib_inline.backend_inline")
notebook = nbformat.read(folder / f"{name}.ipynb", as_version=4)
nbformat.validate(notebook)
outputs = [c for c in notebook.cells if c.cell_type == "code" and (c.outputs or c.execution_count)]
if outputs:
    sys.exit(f"{name}: is kept without outputs: jupyter nbconvert --clear-output --inplace")
nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
pictures = [o["data"]["image/png"] for c in notebook.cells if c.cell_type == "code" for o in c.outputs
            if o.output_type == "display_data" and "image/png" in o["data"]]
if len(sys.argv) > 3:
    for i, picture in enumerate(pictures):
        pathlib.Path(sys.argv[3], f"{name}-{i}.png").write_bytes(base64.b64decode(picture))
for cell in notebook.cells:
    for output in cell.get("outputs", []):
        print(output.get("text", ""), end="")
if not pictures:
    sys.exit(f"{name}: draws nothing")
print(f"{name}: {len(notebook.cells)} cells, {len(pictures)} pictures")
