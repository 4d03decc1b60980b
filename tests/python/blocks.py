"""The blocks of docs/python.md, one after the other, and the cells of the notebooks, whose pictures are not blank.

usage: blocks.py SOURCE_FOLDER [FOLDER_FOR_PICTURES], with the package on PYTHONPATH"""
import json
import os
import pathlib
import re
import sys
import tempfile

source = pathlib.Path(sys.argv[1]).resolve()
os.chdir(source / "examples")


def run(cells, name):
    names = {"__name__": "__main__"}
    for number, cell in enumerate(cells, 1):
        try:
            exec(compile(cell, f"{name}, cell {number}", "exec"), names)  # noqa: S102
        except Exception:
            print(f"{name}, cell {number}:\n{cell}")
            raise
    return names


blocks = re.findall(r"^```python\n(.*?)^```", (source / "docs/python.md").read_text(), re.M | re.S)
assert len(blocks) > 6, len(blocks)
run(blocks, "docs/python.md")
print(f"docs/python.md: {len(blocks)} blocks")

try:
    import matplotlib
except ImportError:
    sys.exit(print("no matplotlib: the notebooks were not run"))
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

notebooks = sorted((source / "examples/python").glob("*.ipynb"))
assert notebooks
with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else temporary)
    for notebook in notebooks:
        content = json.loads(notebook.read_text())
        assert all(not cell.get("outputs") for cell in content["cells"]), f"{notebook.name} is stored with outputs"
        cells = ["".join(cell["source"]) for cell in content["cells"] if cell["cell_type"] == "code"]
        run(cells, notebook.name)
        assert plt.get_fignums(), f"{notebook.name} draws nothing"
        for figure in plt.get_fignums():
            path = folder / f"{notebook.stem}_{figure}.png"
            plt.figure(figure).savefig(path)
            colours = np.unique((plt.imread(path)[:, :, :3] * 255).astype(np.uint8).reshape(-1, 3), axis=0)
            assert len(colours) > 50, f"{path} has {len(colours)} colours"
        print(f"{notebook.name}: {len(cells)} cells, {len(plt.get_fignums())} pictures")
        plt.close("all")
