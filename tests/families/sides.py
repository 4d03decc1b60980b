"""Values at points where two sides meet, `u at [..] on part`: of a crack, against the nodes of the cells in field files.

usage: sides.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

A turned and scaled block in 2D or 3D, P1 or P2, with a free crack (cracks.py), whose halves are parts of its cells. Asked is at corners of the
crack and, with P1, at the centre of one of its facets, with `on` either half and without: that warns (W0613) there, and nowhere else.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

import meshio
import numpy as np

import orientation
from cracks import cracked
from orientation import number
from solids import turning


def script(order, dim, turn, size, middle, points):
    up = " + ".join(f"({number(turn[i, 1])})*{'xyz'[i]}" for i in range(dim))
    columns = []
    for k, x in enumerate(points):
        at = "[" + ", ".join(number(v) for v in x) + "]"
        columns += [f"above{k} = u at {at} on above", f"below{k} = u at {at} on below", f"any{k} = u at {at}"]
    force = "[" + ", ".join(number(v) for v in turn[:, 1] + 0.5 * turn[:, 0]) + "]"
    return f"""mesh body = gmsh("body.msh", split = ["crack"])
part top = body.top
part bottom = body.bottom
part above = body where {up} > {number(size * middle)}
part below = body - above
tensor B = isotropic(young = 10, poisson = 0.3)
space V = vector P{order} on body, zero on top, zero on bottom
find u in V such that for all v in V
  integral(body, B : eps(u) : eps(v)) = integral(above, dot({force}, v)) - integral(below, dot({force}, v))
report
  table {", ".join(columns)} to "values.csv"
  fields u
"""


def of_cells(grid, dim, cells, points):
    """The mean of u over these corners, in one of the cells that have them all."""
    for c in cells:
        of_corner = [[v for v in c if np.abs(grid.points[v, :dim] - x).max() < 1e-7] for x in points]
        if all(of_corner):
            return np.mean([grid.point_data["u"][v[0], :dim] for v in of_corner], axis=0)
    raise RuntimeError("no cell has them")


def scene(program, folder, random, k):
    dim, order = 2 + k % 2, 1 + k // 2 % 2
    mesh, _ = cracked(random, dim)
    middle, turn, size = mesh.points[:, 1].max() / 2, turning(random, dim), 10 ** random.uniform(-3, 3)
    mesh = mesh.moved(turn, size, 0.0)
    facets = [list(f) for f in mesh.facets["crack"]]
    # The leftmost corners are on the boundary, where the crack opens.
    along = mesh.points @ turn[:, 0]
    corner = min((v for f in facets for v in f), key=lambda v: along[v])
    asked = [[mesh.points[corner]]] + ([mesh.points[facets[0]]] if order == 1 else [])
    points = [np.mean(corners, axis=0) for corners in asked] + [mesh.points[mesh.cells[0]].mean(0)]
    (folder / "body.msh").write_text(mesh.msh())
    (folder / "scene.hvi").write_text(script(order, dim, turn, size, middle, points[:-1]).replace(
        "to \"values.csv\"", "to \"values.csv\"\n  table inside = u at [" + ", ".join(number(v) for v in points[-1]) + "]"))
    done = subprocess.run([program, "run", "scene.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    lines = (folder / "scene.hvi").read_text().splitlines()
    told = [re.findall(r"\w+ = ", lines[int(line) - 1][:int(column)])[-1][:-3]
            for line, column in re.findall(r"W0613.*\n *--> scene.hvi:(\d+):(\d+)", done.stderr)]
    names, values = (folder / "out/values.csv").read_text().splitlines()[:2]
    row = dict(zip(names.split(","), map(float, values.split(","))))
    grid = meshio.read(next((folder / "out").glob("*.vtu")))
    cells = grid.cells[0].data[:, :dim + 1]
    high = np.array([grid.points[c, :dim].mean(0) @ turn[:, 1] > size * middle for c in cells])
    worst = 0.0
    for i, corners in enumerate(asked):
        for name, side in (("above", high), ("below", ~high)):
            expected = of_cells(grid, dim, cells[side], corners)
            found = np.array([row[f"{name}{i}_{'xyz'[c]}"] for c in range(dim)])
            worst = max(worst, float(np.abs(found - expected).max() / np.abs(grid.point_data["u"]).max()))
    return worst, told == [f"any{i}" for i in range(len(asked))] or f"told of {told}"


def main():
    options = orientation.asked_for()
    wrong = 0
    for k in range(options.scenes) if options.only is None else options.only:
        with tempfile.TemporaryDirectory() as temporary:
            folder = options.keep or pathlib.Path(temporary)
            folder.mkdir(parents=True, exist_ok=True)
            worst, told = scene(options.program, folder, np.random.default_rng([options.seed, k]), k)
        good = worst < 1e-8 and told is True
        print(f"{'ok   ' if good else 'FAILS'} scene {k}: apart by {worst:.1e}{'' if told is True else ', ' + told}")
        wrong += not good
    return wrong


sys.exit(bool(main()))
