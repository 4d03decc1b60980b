"""Patch tests of pairs: what is linear on both bodies, with a constant jump between them, is found to rounding.

usage: patch.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

Two blocks of one width whose meshes do not match, in 2D and 3D, P1 and P2, turned by a random rotation, touch on a
plane. A spring law on jump(u), the same along and across, holds them together. With u = F x below and F x + c above,
c = -sigma nu / k, nu out of the first side, the stress is constant and balances the law. It is imposed on all other
sides, and must be found inside and on the pair; so must a scalar in P1 or P2 beside u, whose own spring law acts on its jump. Then the body rests on a rigid block in place of a law of its own
ground: one and two sides give the same answer to rounding.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import orientation
from orientation import number
from pairs import together
from solids import Mesh, block, turning

BOUND = 1e-12


def two_blocks(random, dim, order):
    most = (6, 3) if dim == 2 else (3, 2, 3) if order == 1 else (2, 1, 2)
    sizes = random.uniform(0.6, 1.6, dim)
    out = []
    for height in random.uniform(0.5, 1.5, 2):
        counts = [int(random.integers(min(m, 2), m + 1)) for m in most]
        out.append(block(random, counts, [sizes[0], height, *sizes[2:]], 0.2))
    upper, lower = out
    upper.points[:, 1] += lower.points[:, 1].max()
    return upper, lower


def sides(dim):
    return ["left", "right", "back", "front"][:2 * (dim - 1)]


def affine(row, c):
    return " + ".join(f"({number(v)})*{x}" for v, x in zip(row, "xyz")) + f" + ({number(c)})"


def linear(matrix, offset):
    return "[" + ", ".join(affine(row, c) for row, c in zip(matrix, offset)) + "]"


def script(random, dim, order, of_scalar, turn):
    """The script; u and the scalar, a last component, above and below as (matrix, offset)."""
    slope = random.normal(size=(dim, dim))
    lam, mu, spring = random.uniform(1, 5), random.uniform(1, 5), 10 ** random.uniform(-1, 3)
    strain = (slope + slope.T) / 2
    stress = lam * np.trace(strain) * np.eye(dim) + 2 * mu * strain
    first_up = random.random() < 0.5
    up = turn[:, 1]
    jump = -stress @ (-up if first_up else up) / spring
    offset = jump if first_up else -jump
    pair = "upper.bottom, lower.top" if first_up else "lower.top, upper.bottom"
    rise, conductance, film = random.normal(size=dim), random.uniform(1, 5), 10 ** random.uniform(-1, 3)
    step = conductance * rise @ up / film  # what the film leaves between the sides: above less below
    around = lambda piece, end: " + ".join(f"{piece}.{name}" for name in [*sides(dim), end])
    text = f"""mesh upper = gmsh("upper.msh")
mesh lower = gmsh("lower.msh")
mesh both = upper + lower
part above = {around("upper", "top")}
part below = {around("lower", "bottom")}
part seam = pair({pair})
tensor B = isotropic(lambda = {number(lam)}, mu = {number(mu)})
superpotential spring(xi) = {number(spring / 2)}*norm(xi)^2
superpotential film(s) = {number(film / 2)}*s^2
space V = vector P{order} on both, zero on above, zero on below
space W = scalar P{of_scalar} on both, zero on above, zero on below
find u in V, theta in W with u = {linear(slope, offset)} on above, u = {linear(slope, 0 * offset)} on below,
  theta = {affine(rise, step)} on above, theta = {affine(rise, 0.0)} on below
such that for all v in V, eta in W
  integral(both, B : eps(u) : eps(v)) + integral(both, {number(conductance)}*dot(grad(theta), grad(eta)))
  + integral(seam, spring^0(jump(u); jump(v)) + film^0(jump(theta); jump(eta))) >= 0
report
  table size = integral(seam, norm(jump(u)))
  fields u, theta
"""
    both = np.vstack([slope, rise])
    return text, (both, np.append(offset, step)), (both, np.zeros(dim + 1))


def rested(random, dim, order, two, laws):
    """A block pressed on a rigid one, or on its ground."""
    ground = "pair(upper.bottom, lower.top)" if two else "upper.bottom"
    seen = "jump(u)" if two else "u"
    tested = "jump(v)" if two else "v"
    mesh = ('mesh lower = gmsh("lower.msh")\nmesh both = upper + lower\n' if two else "")
    on = "both" if two else "upper"
    rigid = ", zero on lower" if two else ""
    return f"""mesh upper = gmsh("upper.msh")
{mesh}part ground = {ground}
part roof = upper.top
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential wall(r) with slope
  | r < 0.0 -> {laws[0]}*r
  | r < 0.05 -> 40*r
  | otherwise -> 2 + {laws[1]}*(r - 0.05)
superpotential rub(xi) with slope 0.2 + 0.1*exp(-2*norm(xi))
space V = vector P{order} on {on}, zero on roof{rigid}
find u in V for t in [0, 1] by 3 steps from u = 0 such that for all v in V
  integral({"upper"}, B : eps(u) : eps(v)) + integral(upper, 0.1*B : eps(u') : eps(v)){" + integral(lower, B : eps(u) : eps(v))" if two else ""}
  + integral(ground, wall^0({seen}.nu; {tested}.nu) + rub^0({seen}'.tau; {tested}.tau))
 >= integral(upper, t*dot({laws[2]}, v))
report
  fields u
""".replace("jump(u)'", "jump(u')")


def solve(program, folder, text, upper, lower):
    """u, and the scalar where there is one, at the nodes of the upper and of the lower body."""
    import meshio

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "upper.msh").write_text(upper.msh())
    (folder / "lower.msh").write_text(lower.msh())
    (folder / "scene.hvi").write_text(text)
    done = subprocess.run([program, "run", "scene.hvi", "--quiet", "-o", "out"], cwd=folder, capture_output=True,
                          text=True, timeout=120)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    grid = meshio.read(sorted((folder / "out").glob("*.vtu"))[-1])
    above = np.zeros(len(grid.points), bool)
    above[grid.cells[0].data[:len(upper.cells)].ravel()] = True
    dim = upper.dim
    fields = [grid.point_data["u"][:, :dim], *(grid.point_data[name][:, None] for name in ("theta",) if name in grid.point_data)]
    return grid.points[:, :dim], np.hstack(fields), above


def main():
    options = orientation.asked_for()
    worst_patch = worst_rest = 0.0
    for k in range(options.scenes) if options.only is None else options.only:
        random = np.random.default_rng([options.seed, k])
        dim, order, of_scalar = 2 + k % 2, 1 + k // 2 % 2, 1 + k // 4 % 2
        turn = turning(random, dim)
        upper, lower = (mesh.moved(turn, 1.0, 0.0) for mesh in two_blocks(random, dim, order))
        text, over, under = script(random, dim, order, of_scalar, turn)
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.keep or pathlib.Path(temporary)) / str(k)
            x, u, above = solve(options.program, folder / "patch", text, upper, lower)
            expected = np.where(above[:, None], x @ over[0].T + over[1], x @ under[0].T + under[1])
            error = float(np.abs(u - expected).max() / np.abs(expected).max())
            worst_patch = max(worst_patch, error)
            if error > BOUND:
                print(f"scene {k}: {dim}D P{order}/P{of_scalar}: patch off by {error:.1e}", file=sys.stderr)
            if dim == 3 and order == 2:
                continue  # the pair's points are corners there, those of a ground middles of edges
            laws = [number(random.uniform(0, 3)), number(-random.uniform(0, 0.5)),
                    "[" + ", ".join(map(number, turn @ (np.array([0.4, -1.5, 0.3])[:dim] * random.uniform(0.5, 2)))) + "]"]
            one = solve(options.program, folder / "one", rested(random, dim, order, False, laws), upper, lower)
            two = solve(options.program, folder / "two", rested(random, dim, order, True, laws), upper, lower)
            n = [np.where(one[2])[0], np.where(two[2])[0]]
            order_of = [i[np.lexsort(np.round(side[0][i], 9).T)] for i, side in zip(n, (one, two))]
            gap = np.abs(one[1][order_of[0]] - two[1][order_of[1]]).max() / np.abs(one[1]).max()
            worst_rest = max(worst_rest, float(gap))
            if gap > 1e-9:
                print(f"scene {k}: {dim}D P{order}: two sides are off one by {gap:.1e}", file=sys.stderr)
    print(f"patch {worst_patch:.1e}, one side against two {worst_rest:.1e}")
    return 0 if worst_patch <= BOUND and worst_rest <= 1e-9 else 1


if __name__ == "__main__":
    sys.exit(main())
