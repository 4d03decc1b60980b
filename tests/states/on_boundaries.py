#!/usr/bin/env python3
"""States of a body as a report reads them on boundaries, at points, on lines and on parts of the body: against what the VTU files have in the
cells, with meshio's numbers of nodes and cells only.

usage: on_boundaries.py HVI_RUN
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

import meshio
import numpy as np

HVI = str(pathlib.Path(sys.argv[1]).resolve())
failed = []

SCENE = """mesh bar = {mesh}
part wall = bar.left
part grip = bar.right
part end = bar where x > 1.5
part tip = bar.right where {tip}
tensor B = isotropic(lambda = 40, mu = 30)
state d on bar with rate 5*norm(eps(u)) from d = 0.1*x in [0, 0.95]
superpotential pad(r) = 40*r^2
space V = vector P{order} on bar, zero on wall
find u in V for t in [0, 1] by 5 steps from u = 0
such that for all v in V
    integral(bar, (1 - d)*B : eps(u) : eps(v)) + integral(grip, pad^0(u.nu; v.nu))
 >= integral(bar, {load})
report
  {report}
"""
BODY = {2: {"mesh": "rectangle(2, 1, cells = [6, 3])", "tip": "y > 0.5", "load": "dot([0.8*t, -0.4*t], v)"},
        3: {"mesh": "box(2, 1, 1, cells = [4, 2, 2])", "tip": "y > 0.5", "load": "dot([0.8*t, -0.4*t, 0.2*t], v)"}}


def check(what, good, shown=""):
    print(f"{'ok    ' if good else 'FAILED'} {what} {shown}")
    if not good:
        failed.append(what)


def run(folder, report, dim=2, order=1):
    (folder / "scene.hvi").write_text(SCENE.format(report=report, order=order, **BODY[dim]))
    done = subprocess.run([HVI, "run", "scene.hvi", "--quiet", "--json", "scene.json", "-o", "out"], cwd=folder, capture_output=True, text=True, timeout=300)
    return done, json.loads((folder / "scene.json").read_text())["final"] if done.returncode == 0 else None


def cells_behind(mesh, at):
    """(cell, measure of its face, outer cells only) of all faces whose nodes are on the plane x = at, once a cell."""
    kind = mesh.cells[0]
    dim = {3: 2, 6: 2, 4: 3, 10: 3}[kind.data.shape[1]]
    for number, cell in enumerate(kind.data[:, :dim + 1]):
        on = [node for node in cell if abs(mesh.points[node, 0] - at) < 1e-12]
        if len(on) == dim:
            p = mesh.points[on]
            yield number, float(np.linalg.norm(p[1] - p[0]) if dim == 2 else np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0])) / 2), p.mean(axis=0)


def boundary(folder, dim):
    """P1: stress and damage are one number a cell, so that all is known to rounding."""
    done, final = run(folder, """table most = largest(grip, sigma.xx), least = smallest(grip, sigma.xx), pulled = integral(grip, sigma.xx), worn = largest(grip, d),
      both = integral(grip, d*sigma.xx), mixed = integral(grip, d + 0*pad.xi), tips = largest(tip, mises(sigma)), inner = largest(end, d), sum = integral(end, d)
  fields sigma, mises(sigma), d""", dim)
    if not check_run(f"in {dim}D", done):
        return
    mesh = lambda name: meshio.read(sorted((folder / "out").glob(f"scene_{name}_0*5.vtu"))[0])
    parts = {name: mesh(name) for name in ("sigma", "mises_sigma", "d")}
    value = lambda name: np.asarray(parts[name].cell_data[name][0])
    grip = list(cells_behind(parts["sigma"], 2.0))
    cells, area = [c for c, _, _ in grip], np.array([a for _, a, _ in grip])
    xx, d = value("sigma").reshape(len(value("d")), -1)[cells, 0], value("d")[cells]
    tip = [c for c, _, middle in grip if middle[1] > 0.5]
    body = parts["d"].points[parts["d"].cells[0].data][:, :, 0].mean(axis=1) > 1.5
    for name, wanted in (("most", xx.max()), ("least", xx.min()), ("pulled", area @ xx), ("worn", d.max()), ("both", area @ (d * xx)), ("mixed", area @ d),
                         ("tips", value("mises_sigma")[tip].max()), ("inner", value("d")[body].max())):
        check(f"{name} in {dim}D", abs(final[name] - wanted) <= 1e-12 * abs(wanted), f"{final[name]:.12g} by the files {wanted:.12g}")
    check(f"there is damage, not everywhere the same, in {dim}D", 0.05 < d.min() < 0.99 * d.max() and d.max() < 0.95, f"{d.min():.3g} {d.max():.3g}")


def check_run(what, done):
    check(f"runs {what}", done.returncode == 0, done.stderr)
    return done.returncode == 0


def quadratic(folder):
    """P2: on the boundary the nearest of the points of its cell, of which there are several."""
    done, final = run(folder, "table worn = largest(grip, d), least = smallest(grip, d), pulled = integral(grip, sigma.xx), all = largest(end, d), none = smallest(end, d)", order=2)
    if check_run("P2", done):
        check("P2: the boundary has values of the body", final["none"] <= final["least"] < final["worn"] <= final["all"], f"{final}")
        check("P2: the force on the boundary", abs(final["pulled"]) > 1e-3, f"{final['pulled']:.6g}")


def two_halves(path):
    """A rectangle 2 x 1 of 2 x 8 x 4 triangles, in Gmsh's format 2.2, with the facets between its halves as a group."""
    nx, ny = 8, 4
    node = lambda i, j: i * (ny + 1) + j + 1
    nodes = [f"{node(i, j)} {2 * i / nx} {j / ny} 0" for i in range(nx + 1) for j in range(ny + 1)]
    entities = [f"1 2 {group} {group} {a} {b}" for group, i in ((1, 0), (2, nx), (3, nx // 2)) for a, b in ((node(i, j), node(i, j + 1)) for j in range(ny))]
    for i in range(nx):
        for j in range(ny):
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            entities += [f"2 2 {4 + 2 * i // nx} 4 {x} {y} {z}" for x, y, z in ((a, b, c), (a, c, d))]
    names = ['1 1 "left"', '1 2 "right"', '1 3 "seam"', '2 4 "near"', '2 5 "far"']
    block = lambda name, lines: "\n".join([f"${name}", str(len(lines)), *lines, f"$End{name}"])
    path.write_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + "\n".join([block("PhysicalNames", names), block("Nodes", nodes),
                    block("Elements", [f"{k} {entity}" for k, entity in enumerate(entities, 1)])]) + "\n")


SEAM = """mesh bar = gmsh("halves.msh")
part wall = bar.group("left")
part grip = bar.group("right")
part seam = bar.group("seam")
part near = bar.group("near")
part far = bar.group("far")
tensor B = isotropic(lambda = 40, mu = 30)
state d on {home} with rate 5*norm(eps(u)) from d = 0.1*y in [0, 0.95]
space V = vector P1 on bar, zero on wall
find u in V for t in [0, 1] by 5 steps from u = 0
such that for all v in V
    integral({home}, (1 - d)*B : eps(u) : eps(v)) + integral({other}, B : eps(u) : eps(v))
 = integral(bar, dot([0.8*t, -0.4*t], v))
report
  {report}
"""


def seam(folder):
    """A facet between the part that has the state and one that has none is read from the side that has it."""
    two_halves(folder / "halves.msh")

    def go(home, other, report):
        (folder / "scene.hvi").write_text(SEAM.format(home=home, other=other, report=report))
        return subprocess.run([HVI, "run", "scene.hvi", "--quiet", "--json", "scene.json", "-o", "out"], cwd=folder, capture_output=True, text=True)

    for home, other, outside in (("near", "far", "grip"), ("far", "near", "wall")):
        done = go(home, other, 'table worn = largest(seam, d), sum = integral(seam, d)\n  fields d to "d.pvd"')
        if not check_run(f"at a seam of {home}", done):
            continue
        final = json.loads((folder / "scene.json").read_text())["final"]
        mesh = meshio.read(max((folder / "out").glob("d*.vtu")))
        d, behind = np.asarray(mesh.cell_data["d"][0]), list(cells_behind(mesh, 1.0))
        check(f"the seam is read in {home}, which has the state", len(behind) == 4 and abs(final["worn"] - max(d[c] for c, _, _ in behind)) < 1e-13, f"{final['worn']}")
        check("its integral", abs(final["sum"] - sum(a * d[c] for c, a, _ in behind)) < 1e-13, f"{final['sum']}")
        done = go(home, other, f"table worn = largest({outside}, d)")
        check("a boundary of another body is refused, with a way out", done.returncode != 0 and "`d` does not live in the cell at" in done.stderr and "on a boundary of it" in done.stderr, done.stderr)


def line(folder):
    done, final = run(folder, 'table a = sigma.xx at [2, 0.4], b = d at [2, 0.4], c = pad.xi + d at [2, 0]\n  line sigma.xx, d from [2, 0.4] to [2, 0.9] by 2 points to "line.csv"\n  fields d')
    if not check_run("with a line", done):
        return
    first = next(csv.DictReader((folder / "out" / "line.csv").open()))
    check("a line along the boundary", all(abs(float(first[k]) - final[c]) < 1e-13 for k, c in (("sigma.xx", "a"), ("d", "b"))), f"{first}")


HALF = """mesh bar = {mesh}
part wall = bar.left
part grip = bar.right
part ground = bar.bottom
part soft = bar where x < 1
part rest = bar - soft
part beyond = ground where x > 1
tensor B = isotropic(lambda = 40, mu = 30)
superpotential layer(r) = 50*pos(r)^2
{d}
space V = vector P{order} on bar, zero on wall
find u in V for t in [0, 1] by 2 steps from u = 0
such that for all v in V
    integral(soft, (1 - {of})*B : eps(u) : eps(v)) + integral(rest, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(bar, {load})
report
  table far = layer.xi + sigma.yy at [1.5, {zeros}], near = layer.xi + sigma.yy at [0.5, {zeros}], whole = integral(ground, layer.xi + sigma.yy), most = largest(ground, layer.xi - sigma.xy),
    beyond = integral(beyond, layer.xi*sigma.yy), home = layer.xi*{of} at [0.5, {zeros}]
"""


def with_laws(folder):
    """A stress and a multiplier in one column, where the state of the stress lives on one half only: a state that stays as it is against a number."""
    for dim in (2, 3):
        for order in (1, 2):
            found = []
            for d, of in (("state d on soft with rate 0 from d = 0.3 in [0, 0.9]", "d"), ("fn d() = 0.3", "d()")):
                mesh, zeros = BODY[dim]["mesh"].replace("6, 3", "8, 3"), "0" if dim == 2 else "0, 0.5" if order == 1 else "0, 0.25"
                (folder / "scene.hvi").write_text(HALF.format(d=d, of=of, order=order, mesh=mesh, zeros=zeros, load=BODY[dim]["load"].replace("-0.4", "-3")))
                done = subprocess.run([HVI, "run", "scene.hvi", "--quiet", "--json", "scene.json", "-o", "out"], cwd=folder, capture_output=True, text=True)
                if not check_run(f"a stress with a multiplier in {dim}D by P{order}", done):
                    return
                found.append(json.loads((folder / "scene.json").read_text())["final"])
            size = max(map(abs, found[1].values()))
            check(f"a stress with a multiplier in {dim}D by P{order}", all(abs(found[0][name] - value) <= 1e-9 * size for name, value in found[1].items()), f"{found}")


def main():
    with tempfile.TemporaryDirectory() as place:
        for name, test in (("plane", lambda f: boundary(f, 2)), ("space", lambda f: boundary(f, 3)), ("p2", quadratic), ("seam", seam), ("line", line), ("laws", with_laws)):
            folder = pathlib.Path(place) / name
            folder.mkdir()
            test(folder)
    print("all hold" if not failed else f"{len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
