#!/usr/bin/python3
"""A block that slides on a block (bench/ironing.hvi) with GetFEM: its elasticity, its contact brick with friction (augmented Lagrangian)
on rows that join both bodies, its Newton solver per step. The rows are the mortar projection with dual functions on the upper side,
integrated here between the sorted nodes of both sides. As in rubbing_getfem.py the unknown is the increment of a step.

    OPENBLAS_NUM_THREADS=1 /usr/bin/python3 ironing_getfem.py -n 8 -m 13 -N 24
"""
import argparse

import getfem as gf
import numpy as np

FRICTION, APART, BACK, BASE = 0.3, 1.0, 1, 2  # the lower block lies a length lower: GetFEM joins points at one place


def block(mesh, origin, sizes, counts):
    """Rectangles, each cut by the diagonal from lower left to upper right."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(counts[0]), np.arange(counts[1])))
    for corners in ((i, i + 1, i + 1), (j, j, j + 1)), ((i, i + 1, i), (j, j + 1, j + 1)):
        points = [o + s / c * np.array(k, dtype=float) for o, s, c, k in zip(origin, sizes, counts, corners)]
        mesh.add_convex(gf.GeoTrans("GT_PK(2,1)"), np.array(points))


def projection(first, second):
    """Weights of the first side's nodes, and the matrix that takes values on the second side to them."""
    weights, out = np.zeros(len(first)), np.zeros((len(first), len(second)))
    for a in range(len(first) - 1):
        low, high = first[a], first[a + 1]
        weights[a:a + 2] += (high - low) / 2
        cuts = np.array([low, *second[(second > low) & (second < high)], high])
        for p, q in zip(cuts, cuts[1:]):
            b = min(np.searchsorted(second, (p + q) / 2) - 1, len(second) - 2)
            for x in (p + q) / 2 + (q - p) / np.sqrt(12) * np.array([-1.0, 1.0]):  # Gauss, exact for products of linear functions
                s, r = (x - low) / (high - low), (x - second[b]) / (second[b + 1] - second[b])
                out[a:a + 2, b:b + 2] += (q - p) / 2 * np.outer([2 - 3 * s, 3 * s - 1], [1 - r, r])
    return weights, out / weights[:, None]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("-n", type=int, default=8)
    parser.add_argument("-m", type=int, default=13)
    parser.add_argument("-N", type=int, default=24)
    args = parser.parse_args()
    gf.util("trace level", 0)
    n, m, k = args.n, args.m, 1.0 / args.N
    mesh = gf.Mesh("empty", 2)
    block(mesh, (0.0, 0.0), (1.0, 0.5), (2 * n, n))
    block(mesh, (-0.5, -0.5 - APART), (2.0, 0.5), (m, n // 2))
    outer = mesh.outer_faces()
    middle = np.array([mesh.pts_from_cvid(c)[0][:, [i for i in range(3) if i != f]].mean(1) for c, f in outer.T])
    mesh.set_region(BACK, outer[:, middle[:, 1] > 0.5 - 1e-9])
    mesh.set_region(BASE, outer[:, middle[:, 1] < -1 - APART + 0.5 + 1e-9])
    fem = gf.MeshFem(mesh, 2)
    fem.set_fem(gf.Fem("FEM_PK(2,1)"))
    cells = gf.MeshFem(mesh, 1)
    cells.set_fem(gf.Fem("FEM_PK(2,0)"))
    im = gf.MeshIm(mesh, gf.Integ("IM_TRIANGLE(2)"))
    above = cells.basic_dof_nodes()[1] > -0.25 * APART

    def elasticity(upper, lower):
        young = np.where(above, upper, lower)
        return gf.asm_linear_elasticity(im, fem, cells, young * 0.3 / (1.3 * 0.4), young / 2.6)

    b, whole = elasticity(100.0, 60.0), elasticity(2.0, 0.0)
    whole.scale(1.0 / k)
    place = fem.basic_dof_nodes()
    along = np.arange(fem.nbdof()) % 2 == 0
    on = lambda height: np.array(sorted(np.flatnonzero((abs(place[1] - height) < 1e-9) & along), key=lambda i: place[0][i]))
    foot, top = on(0.0), on(-APART)
    weights, takes = projection(place[0][foot], place[0][top])
    nodes = len(foot)
    normal, tangential = gf.Spmat("empty", nodes, fem.nbdof()), gf.Spmat("empty", nodes, fem.nbdof())
    for i in range(nodes):
        normal[i, int(foot[i]) + 1], tangential[i, int(foot[i])] = -1.0, 1.0
        for j in np.flatnonzero(takes[i]):
            normal[i, int(top[j]) + 1], tangential[i, int(top[j])] = takes[i, j], -takes[i, j]
    model = gf.Model("real")
    model.add_fem_variable("u", fem)
    model.add_explicit_matrix("u", "u", gf.Spmat("add", whole, b), 1, 1)
    right = model.add_explicit_rhs("u", np.zeros(fem.nbdof()))
    model.add_initialized_data("moved", [0.0, 0.0])
    model.add_Dirichlet_condition_with_simplification("u", BACK, "moved")
    model.add_Dirichlet_condition_with_simplification("u", BASE)
    model.add_variable("push", nodes)
    model.add_variable("drag", nodes)
    for name, value in (("r", [10.0]), ("friction", [FRICTION]), ("gap", np.zeros(nodes)), ("alpha", np.ones(nodes))):
        model.add_initialized_data(name, value)
    model.add_basic_contact_brick("u", "push", "drag", "r", normal, tangential, "friction", "gap", "alpha", 1)

    def given(t):
        slid = 0.0 if t < 0.25 else 4 * (t - 0.25) if t < 0.75 else 2 - 16 * (t - 0.75)
        return np.array([0.02 * slid, -0.02 * min(1.0, 4 * t)])

    probe = int(np.argmin(abs(place[0] - 1.0) + abs(place[1] - 0.25) + ~along))
    u = np.zeros(fem.nbdof())
    for step in range(1, args.N + 1):
        t = step * k
        model.set_private_rhs(right, -b.mult(u))
        model.set_variable("gap", -normal.mult(u))
        model.set_variable("moved", given(t) - given(t - k))
        model.solve("max_res", 1e-11, "max_iter", 100)
        u = u + model.variable("u")
        push, drag = -model.variable("push"), -model.variable("drag")
        print(f"{t:.12g} {push.sum():.13g} {drag.sum():.13g} {push @ place[0][foot]:.13g} {u[probe]:.13g}")


if __name__ == "__main__":
    main()
