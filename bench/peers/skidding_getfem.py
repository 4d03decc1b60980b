#!/usr/bin/python3
"""A block that lands and skids (bench/skidding.hvi) with GetFEM: its mass and elasticity, backward Euler, and its nodal brick of contact with
friction, augmented Lagrangian, GetFEM's Newton solver per step. As in rubbing_getfem.py the unknown is the increment of a step, on which
friction acts then.

    OPENBLAS_NUM_THREADS=1 /usr/bin/python3 skidding_getfem.py -n 16 -N 64

Prints t u_x(2, 0) u_y(2, 1) push drag at every step.
"""
import argparse

import getfem as gf
import numpy as np

from slab_getfem import slab_mesh

FRICTION, GAP, VELOCITY = 0.3, 0.05, (2.0, -1.0)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("-n", type=int, default=16)
    parser.add_argument("-N", type=int, default=64)
    args = parser.parse_args()
    gf.util("trace level", 0)
    n, k = args.n, 1.0 / args.N
    mesh = slab_mesh(n)
    fem = gf.MeshFem(mesh, 2)
    fem.set_fem(gf.Fem("FEM_PK(2,1)"))
    scalar = gf.MeshFem(mesh, 1)
    scalar.set_fem(gf.Fem("FEM_PK(2,1)"))
    im = gf.MeshIm(mesh, gf.Integ("IM_TRIANGLE(2)"))
    one = np.ones(scalar.nbdof())

    def elasticity(lam, mu):
        return gf.asm_linear_elasticity(im, fem, scalar, lam * one, mu * one)

    def scaled(matrix, factor):
        out = gf.Spmat("copy", matrix)
        out.scale(factor)
        return out

    young, poisson = 70.0, 0.3
    a = elasticity(0.05, 0.1)
    b = elasticity(young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson)))
    mass = gf.asm_mass_matrix(im, fem)
    weight = gf.asm_volumic_source(im, fem, scalar, np.vstack([0 * one, -10.0 * one]))
    place = fem.basic_dof_nodes()
    is_y = np.arange(fem.nbdof()) % 2 == 1
    tiny = 0.25 / n
    ground = np.flatnonzero((place[1] < tiny) & is_y)
    nodes = len(ground)
    normal, tangential = gf.Spmat("empty", nodes, fem.nbdof()), gf.Spmat("empty", nodes, fem.nbdof())
    for i, dof in enumerate(ground):
        normal[i, int(dof)] = -1.0
        tangential[i, int(dof) - 1] = 1.0
    model = gf.Model("real")
    model.add_fem_variable("u", fem)
    stiffness = gf.Spmat("add", gf.Spmat("add", scaled(mass, 1.0 / k**2), scaled(a, 1.0 / k)), b)
    model.add_explicit_matrix("u", "u", stiffness, 1, 1)
    right = model.add_explicit_rhs("u", weight)
    model.add_variable("push", nodes)
    model.add_variable("drag", nodes)
    model.add_initialized_data("r", [10.0])
    model.add_initialized_data("friction", [FRICTION])
    model.add_initialized_data("gap", np.full(nodes, GAP))
    model.add_initialized_data("alpha", np.ones(nodes))
    model.add_basic_contact_brick("u", "push", "drag", "r", normal, tangential, "friction", "gap", "alpha", 1)
    u, velocity = np.zeros(fem.nbdof()), np.where(is_y, VELOCITY[1], VELOCITY[0])
    corner, top = (np.argmin((place[0] - 2) ** 2 + (place[1] - y) ** 2) // 2 * 2 for y in (0, 1))
    for step in range(1, args.N + 1):
        model.set_private_rhs(right, weight - b.mult(u) + mass.mult(velocity) / k)
        model.set_variable("gap", GAP - normal.mult(u))
        model.solve("max_res", 1e-11, "max_iter", 100)
        moved = model.variable("u")
        u, velocity = u + moved, moved / k
        print(f"{step * k:.12g} {u[corner]:.13g} {u[top + 1]:.13g} {-model.variable('push').sum():.13g} "
              f"{-model.variable('drag').sum():.13g}")


if __name__ == "__main__":
    main()
