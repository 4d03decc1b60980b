#!/usr/bin/python3
"""Coulomb's friction on the rate (bench/rubbing.hvi) with GetFEM's contact brick: nodal contact with friction, augmented Lagrangian, GetFEM's
Newton solver per step. The unknown is the increment of a step, on which friction acts then, with the gap that the last step has left: the
brick's argument for velocities is ignored with nodal contact in Debian 12 (5.4.2).

    OPENBLAS_NUM_THREADS=1 /usr/bin/python3 rubbing_getfem.py -n 16 -N 64
"""
import argparse

import getfem as gf
import numpy as np

from slab_getfem import GROUND, RIGHT, ROOF, slab_mesh

FRICTION = 0.2


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

    young, poisson = 70.0, 0.3
    a = elasticity(5.0, 10.0)
    b = elasticity(young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson)))
    gram = elasticity(0.0, 0.5)
    weight = gf.asm_volumic_source(im, fem, scalar, np.vstack([0 * one, -10.0 * one]))
    pull = gf.asm_boundary_source(RIGHT, im, fem, scalar, np.vstack([12.0 * one, 0 * one]))
    place = fem.basic_dof_nodes()
    is_y = np.arange(fem.nbdof()) % 2 == 1
    tiny = 0.25 / n
    ground = np.flatnonzero((place[1] < tiny) & is_y)
    nodes = len(ground)
    normal, tangential = gf.Spmat("empty", nodes, fem.nbdof()), gf.Spmat("empty", nodes, fem.nbdof())
    for i, dof in enumerate(ground):
        normal[i, int(dof)] = -1.0
        tangential[i, int(dof) - 1] = 1.0
    ka = gf.Spmat("copy", a)
    ka.scale(1.0 / k)
    model = gf.Model("real")
    model.add_fem_variable("u", fem)
    model.add_explicit_matrix("u", "u", gf.Spmat("add", ka, b), 1, 1)
    right = model.add_explicit_rhs("u", weight)
    model.add_Dirichlet_condition_with_simplification("u", ROOF)
    model.add_variable("push", nodes)
    model.add_variable("drag", nodes)
    model.add_initialized_data("r", [10.0])
    model.add_initialized_data("friction", [FRICTION])
    model.add_initialized_data("gap", np.zeros(nodes))
    model.add_initialized_data("alpha", np.ones(nodes))
    model.add_basic_contact_brick("u", "push", "drag", "r", normal, tangential, "friction", "gap", "alpha", 1)
    u = np.zeros(fem.nbdof())
    for step in range(1, args.N + 1):
        t = step * k
        model.set_private_rhs(right, weight + np.sin(6 * t) * pull - b.mult(u))
        model.set_variable("gap", -normal.mult(u))
        model.solve("max_res", 1e-9, "max_iter", 100)
        u = u + model.variable("u")
    corner = ground[np.argmax(place[0][ground])] - 1
    print(f"{t:.12g} {u[corner]:.13g} {np.sqrt(u @ gram.mult(u)):.13g} "
          f"{-model.variable('push').sum():.13g} {-model.variable('drag').sum():.13g}")


if __name__ == "__main__":
    main()
