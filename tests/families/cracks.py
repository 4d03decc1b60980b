"""Meshes cut along inner groups: the answers of meshes whose nodes were doubled by hand, and of whole ones.

usage: cracks.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

A turned block in 2D or 3D, P1 or P2, with a crack from its left side to the middle or right through. Without a law it is
free, as it is where the nodes are two from the beginning; glued by a stiff law it is whole, to one part in its
stiffness. In 3D with P2, where the law acts at corners only, it is so to the error of the mesh.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import orientation
from orientation import number
from solids import Mesh, block, turning

STIFF = 1e7


def cracked(random, dim):
    """The block with the group `crack`, and one with its nodes doubled."""
    counts = [int(random.integers(2, 5)), 2 * int(random.integers(1, 3)), 2][:dim]
    mesh = block(random, counts, random.uniform(0.5, 1.5, dim))
    middle = mesh.points[:, 1].max() / 2
    through = random.random() < 0.3
    end = mesh.points[:, 0].max() * (1.0 if through else 0.5 if counts[0] % 2 == 0 else 1 / counts[0])
    on = (np.abs(mesh.points[:, 1] - middle) < 1e-9) & (mesh.points[:, 0] < end + 1e-9)
    above = np.array([mesh.points[c].mean(0)[1] > middle for c in mesh.cells])
    facets = set()
    for c in mesh.cells[above]:
        for k in range(dim + 1):
            f = tuple(sorted(int(v) for v in [*c[:k], *c[k + 1:]]))
            if on[list(f)].all():
                facets.add(f)
    mesh.facets["crack"] = sorted(facets)
    opens = on & (through | (mesh.points[:, 0] < end - 1e-9))
    twin = {int(v): len(mesh.points) + k for k, v in enumerate(np.where(opens)[0])}
    double = lambda nodes: [twin.get(int(v), int(v)) for v in nodes]
    cells = np.array([double(c) if up else c for c, up in zip(mesh.cells, above)])
    belongs = lambda f: any(up and set(f) <= set(int(v) for v in c) for c, up in zip(mesh.cells, above))
    sides = {name: [tuple(double(f)) if belongs(f) else f for f in found]
             for name, found in mesh.facets.items() if name != "crack"}
    return mesh, Mesh(np.vstack([mesh.points, mesh.points[opens]]), cells, sides)


def script(order, split, law, force):
    cut = ', split = ["crack"]' if split else ""
    glue = " + integral(seam, glue^0(jump(u); jump(v)))" if law else ""
    part = 'part seam = body.crack\n' if law else ""
    return f"""mesh body = gmsh("body.msh"{cut})
part top = body.top
part bottom = body.bottom
{part}tensor B = isotropic(young = 10, poisson = 0.3)
superpotential glue(xi) = {number(STIFF * 5)}*norm(xi)^2
space V = vector P{order} on body, zero on top, zero on bottom
find u in V such that for all v in V
  integral(body, B : eps(u) : eps(v)){glue} >= integral(body, dot({force}, v))
report
  fields u
"""


def corners(program, folder, mesh, text):
    """u at the corners of every cell."""
    import meshio

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "body.msh").write_text(mesh.msh())
    (folder / "scene.hvi").write_text(text)
    done = subprocess.run([program, "run", "scene.hvi", "--quiet", "-o", "out"], cwd=folder, capture_output=True,
                          text=True, timeout=120)
    if done.returncode != 0:
        raise RuntimeError(text + done.stderr)
    grid = meshio.read(sorted((folder / "out").glob("*.vtu"))[-1])
    cells = grid.cells[0].data[:, :mesh.dim + 1]
    points, u = grid.points[cells][..., :mesh.dim], grid.point_data["u"][cells][..., :mesh.dim]
    order = np.argsort(np.round(points, 9).view([("", float)] * mesh.dim).squeeze(-1), axis=1)
    return np.take_along_axis(u, order[..., None], axis=1)


def main():
    options = orientation.asked_for()
    worst_free = worst_glued = worst_of_corners = 0.0
    for k in range(options.scenes) if options.only is None else options.only:
        random = np.random.default_rng([options.seed, k])
        dim, order = 2 + k % 2, 1 + k // 2 % 2
        mesh, doubled = cracked(random, dim)
        turn = turning(random, dim)
        mesh, doubled = mesh.moved(turn, 1.0, 0.0), doubled.moved(turn, 1.0, 0.0)
        force = "[" + ", ".join(number(v) for v in random.normal(size=dim)) + "]"
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.keep or pathlib.Path(temporary)) / str(k)
            free = corners(options.program, folder / "free", mesh, script(order, True, False, force))
            by_hand = corners(options.program, folder / "by_hand", doubled, script(order, False, False, force))
            whole = corners(options.program, folder / "whole", mesh, script(order, False, False, force))
            glued = corners(options.program, folder / "glued", mesh, script(order, True, True, force))
        size = np.abs(free).max()
        worst_free = max(worst_free, float(np.abs(free - by_hand).max() / size))
        off = float(np.abs(glued - whole).max() / size)
        if dim == 3 and order == 2:
            worst_of_corners = max(worst_of_corners, off)
        else:
            worst_glued = max(worst_glued, off)
        if np.abs(free - whole).max() < 1e-6 * size:
            print(f"scene {k}: the crack does not show", file=sys.stderr)
            return 1
    print(f"free cracks {worst_free:.1e}, glued ones {worst_glued:.1e}, at corners {worst_of_corners:.1e}")
    return 0 if worst_free <= 1e-11 and worst_glued <= 100 / STIFF and worst_of_corners <= 0.1 else 1


if __name__ == "__main__":
    sys.exit(main())
