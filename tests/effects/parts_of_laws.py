#!/usr/bin/env python3
"""parts_of_laws.py HVI_RUN: a law that acts on several parts, read where it acts.

Laws that are springs: their multipliers are known from the displacement. In 2D, 3D and bodies of revolution, P1 and P2, columns at points of each
part, with the point's part not the first one of the script, and files, one for each part, agree with stiffness times displacement, or strain."""
import json
import pathlib
import subprocess
import sys
import tempfile

import meshio
import numpy as np

HVI_RUN = sys.argv[1]
K, C = 3.0, 2.0


def scene(dim, element, ring):
    mesh = {2: "rectangle(2, 1, cells = [6, 4]" + (", axisymmetric = true" * ring) + ")", 3: "box(2, 1, 1, cells = [4, 2, 2])"}[dim]
    load, up = ("[0.2, -1]", "y") if dim == 2 else ("[0.2, -1, -0.5]", "y")
    # In 3D the points of a nodal rule of P2 are the middles of edges.
    z = 0.5 if element == "P1" else 0.25
    low, high = ([1, 0], [1, 1]) if dim == 2 else ([1, 0, z], [1, 1, z])
    left, right = ([0.6, 0.28], [1.6, 0.28]) if dim == 2 else ([0.6, 0.28, 0.31], [1.6, 0.28, 0.31])
    return f"""import contact
mesh body  = {mesh}
part low   = body.bottom
part high  = body.top
part wall  = body.right
part l = body where x < 1
part r = body where x > 1
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential bed(r) = winkler(r, stiffness = {K})
superpotential drag(xi) = 0.5*{K}*norm(xi)^2
superpotential paste(xi) = 0.5*{C}*norm(xi)^2
space V = vector {element} on body, zero on wall
find u in V
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(low, bed^0(u.nu; v.nu)) + integral(high, drag^0(u.tau; v.tau) + bed^0(u.nu; v.nu))
  + integral(l, paste^0(eps(u); eps(v))) + integral(r, paste^0(eps(u); eps(v)))
 >= integral(high, dot({load}, v))
report
  table a = bed.xi at {low}, b = bed.xi at {high}, ua = -u.{up} at {low}, ub = u.{up} at {high}, c = drag.xi at {high}, uc = u at {high},
      both = bed.xi - 2*dot(drag.xi, drag.xi) at {high}, p = paste.xi.xy at {left}, q = paste.xi.xy at {right}, ep = eps(u).xy at {left}, eq = eps(u).xy at {right},
      on_low = integral(low, bed.xi), on_high = integral(high, bed.xi)
  fields u, bed.xi, bed.xi + norm(drag.xi), paste.xi, eps(u)
"""


def close(a, b, what):
    assert np.allclose(a, b, rtol=1e-9, atol=1e-12), f"{what}: {a} {b}"


def check_columns(row, dim, element):
    close(row["a"], K * row["ua"], "below")
    close(row["b"], K * row["ub"], "above")
    along = [axis for axis in "xyz"[:dim] if axis != "y"]
    close([row[f"c_{axis}"] for axis in along], [K * row[f"uc_{axis}"] for axis in along], "along")
    close(row["both"], row["b"] - 2 * sum(row[f"c_{axis}"] ** 2 for axis in "xyz"[:dim]), "of both laws")
    if element == "P1":  # of P2 the mean over the cell
        close((row["p"], row["q"]), (C * row["ep"], C * row["eq"]), "inside")


def bare_points(file, dim, element, ring):
    """Where a nodal rule has no weight: at vertices of quadratic triangles, and of P2 on an axis."""
    if dim == 3 and element == "P2":
        return np.unique(file.cells[0].data[:, :3])
    return np.flatnonzero(file.points[:, 0] == 0) if ring and element == "P2" else []


def check_between(file, bare, dim):
    """There a file has the mean of the points beside it: middles of edges, or their other ends."""
    (cells,), values = file.cells, file.point_data["bed.xi"]
    for point in bare:
        beside = []
        for cell in cells.data:
            for e, ends in enumerate(((0, 1), (1, 2), (2, 0))[: 3 if dim == 3 else 1]):
                if point in cell[list(ends)]:
                    beside.append(cell[dim + e] if len(cell) > dim else cell[ends[0]] + cell[ends[1]] - point)
        close(values[point], np.mean(values[beside]), "between the points")


def check_files(out, dim, element, ring):
    body = meshio.read(out / "scene_00001.vtu")
    u = {tuple(np.round(x, 9)): v for x, v in zip(body.points, body.point_data["u"])}
    moved = {}
    for part, sign in (("low", -1), ("high", 1)):
        file = meshio.read(out / f"scene_bed_xi_{part}_00001.vtu")
        assert set(file.points[:, 1]) == {(sign + 1) / 2}, part
        moved[part] = np.array([u[tuple(np.round(x, 9))] for x in file.points])
        there = file.point_data["bed.xi"]
        moved[part], there = np.delete(moved[part], bare := bare_points(file, dim, element, ring), axis=0), np.delete(there, bare)
        check_between(file, bare, dim)
        close(there, K * sign * moved[part][:, 1], f"file of {part}")
    both = meshio.read(out / "scene_bed_xi_plus_norm_drag_xi_00001.vtu")  # one part: no name of it
    (name,) = both.point_data
    there, known = moved["high"], np.delete(both.point_data[name], bare_points(both, dim, element, ring))
    close(known, K * there[:, 1] + K * np.linalg.norm(there[:, [0, 2]], axis=1), "file of both laws")
    if element == "P1":
        middles = body.points[body.cells[0].data].mean(axis=1)
        strains = {tuple(np.round(x, 9)): e for x, e in zip(middles, body.cell_data["eps_u"][0])}
        count = 0
        for part in "lr":
            file = meshio.read(out / f"scene_paste_xi_{part}_00001.vtu")
            count += len(file.points)
            close(file.point_data["paste.xi"], [C * strains[tuple(np.round(x, 9))] for x in file.points], f"file of {part}")
        assert count == len(middles), count


def main():
    scenes = 0
    for dim, element, ring in ((2, "P1", 0), (2, "P2", 0), (3, "P1", 0), (3, "P2", 0), (2, "P1", 1), (2, "P2", 1)):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "scene.hvi").write_text(scene(dim, element, ring))
            done = subprocess.run([HVI_RUN, "run", "scene.hvi", "-o", "out", "--quiet", "--json", "scene.json"], cwd=folder, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            row = {column: values[0] for column, values in json.loads((folder / "scene.json").read_text())["table"].items()}
            check_columns(row, dim, element)
            check_files(folder / "out", dim, element, ring)
            scenes += 1
    print(f"{scenes} scenes: multipliers of laws on several parts are where they act")


main()
