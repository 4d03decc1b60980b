#!/usr/bin/env python3
"""files_and_columns.py HVI_RUN: what VTU files have, as another reader (meshio) finds it, is what columns say at the same points.

In 2D, 3D, bodies of revolution, two bodies that a pair joins, P1 and P2: u and a memory at every node, strains, stresses and rates in the middles of
cells; the entry of sigma across the plane of plane strain, and the equivalent stress made from all nine. Multipliers: parts_of_laws.py."""
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile

import meshio
import numpy as np

HVI_RUN = sys.argv[1]
MESHES = {
    "plane": ("mesh body = rectangle(2, 1, cells = [4, 2], pattern = crossed)\npart wall = body.left\npart roof = body.top", 2),
    "hole": ("mesh body = plate_with_hole(width = 2, height = 2, hole_radius = 0.5, size = 0.6)\npart wall = body.left\npart roof = body.top", 2),
    "space": ("mesh body = box(2, 1, 1, cells = [2, 1, 1])\npart wall = body.left\npart roof = body.top", 3),
    "ring": ("mesh body = rectangle(2, 1, cells = [4, 2], axisymmetric = true)\npart wall = body.top\npart roof = body.bottom", 2),
    "pair": ("mesh below = rectangle(2, 1, cells = [3, 2])\nmesh above = rectangle(2, 1, cells = [4, 2], at = [0, 1])\nmesh body = below + above\n"
             "part wall = below.bottom\npart roof = above.top\npart seam = pair(above.bottom, below.top)", 2),
}


def scene(name, element, columns):
    mesh, dim = MESHES[name]
    law = "superpotential glue(w) = 20*norm(w)^2\n" if name == "pair" else ""
    joined = " + integral(seam, glue^0(jump(u); jump(v)))" if law else ""
    load = "[3*t, -2, 1]" if dim == 3 else "[3*t, -2]"
    return f"""{mesh}
tensor B = isotropic(young = 100, poisson = 0.3)
tensor A = isotropic(young = 20, poisson = 0.1)
kernel fading(lag) = -0.5*exp(-lag)*B
{law}space V = vector {element} on body, zero on wall
find u in V for t in [0, 1] by 3 steps from u = 0
such that for all v in V
    integral(body, A : eps(u') : eps(v) + B : eps(u) : eps(v) + history(fading, eps(u)) : eps(v)){joined}
 {">=" if law else "="} integral(roof, dot({load}, v))
report
  table {columns}
  fields u, u', eps(u), sigma, mises(sigma), eps(u') every 3 steps
"""


def run(folder, text):
    (folder / "scene.hvi").write_text(text)
    done = subprocess.run([HVI_RUN, "run", "scene.hvi", "-o", "out", "--quiet", "--json", "scene.json"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {column: values[-1] for column, values in json.loads((folder / "scene.json").read_text())["table"].items()}


def names(quantity, dim):
    return [f"{quantity}.{a}{b}" for a, b in itertools.product("xyz"[:dim], repeat=2)]


def check(name, element, folder):
    dim, ring = MESHES[name][1], name == "ring"
    run(folder, scene(name, element, "first = norm(u)"))
    (file,) = (folder / "out").glob("scene_0*3.vtu")
    mesh = meshio.read(file)
    (cells,) = mesh.cells
    middles = mesh.points[cells.data[:, : dim + 1]].mean(axis=1)
    asked, wanted, sizes = [], [], []
    for array, quantity in (("u", "u"), ("u_rate", "u'")):
        values = mesh.point_data[array]
        for x, value in list(zip(mesh.points, values))[::3]:
            if name == "pair" and x[1] == 1:
                continue  # both bodies have the place, and a column is of one of them
            for i in range(dim):
                asked.append((f"{quantity}.{'xyz'[i]}", x[:dim]))
                wanted.append(value[i])
                sizes.append(np.abs(values).max())
    entries = [] if ring else [("eps_u", "eps(u)"), ("sigma", "sigma"), ("eps_u_rate", "eps(u')")]
    for array, quantity in entries:  # rings: means of u.x/x
        values = mesh.cell_data[array][0].reshape(-1, 3, 3)
        assert dim == 3 or array == "sigma" or not values[:, 2].any(), "no strain across the plane"
        for x, value in list(zip(middles, values))[::5]:
            ask = [(f"{quantity}.{'xyz'[i]}{'xyz'[j]}", value[i, j]) for i in range(dim) for j in range(dim)]
            for what, entry in ask + [("sigma.zz", value[2, 2])] * (array == "sigma"):
                asked.append((what, x[:dim]))
                wanted.append(entry)
                sizes.append(np.abs(values).max())
    columns = ",\n      ".join(f"c{k} = {what} at [{', '.join(repr(float(a)) for a in x)}]" for k, (what, x) in enumerate(asked))
    row = run(folder, scene(name, element, columns))
    for k, (what, x) in enumerate(asked):
        assert abs(row[f"c{k}"] - wanted[k]) <= 1e-9 * sizes[k], f"{name} {element}: {what} at {x}: {row[f'c{k}']}, file: {wanted[k]}"
    if element == "P1" and not ring:
        s = mesh.cell_data["sigma"][0].reshape(-1, 3, 3)
        d = s - np.trace(s, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3
        assert np.allclose(np.sqrt(1.5 * (d * d).sum(axis=(1, 2))), mesh.cell_data["mises_sigma"][0], rtol=1e-9), name
    return len(asked)


def main():
    values = 0
    for name, element in itertools.product(MESHES, ("P1", "P2")):
        with tempfile.TemporaryDirectory() as folder:
            values += check(name, element, pathlib.Path(folder))
    print(f"{values} values in files are those of columns")


main()
