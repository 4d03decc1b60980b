#!/usr/bin/python3
"""The slab with GetFEM (Debian: python3-getfem), in two ways.

fixed: GetFEM assembles; one SuperLU factor, SciPy's with its symmetric settings (GetFEM's own
       Precond("superlu") crashes in Debian 12); a fixed point per step, warm-started.
model: GetFEM's model object with a nonlinear boundary term and its Newton solver per step.

Run with the system's Python, which sees Debian's module:
    OPENBLAS_NUM_THREADS=1 /usr/bin/python3 slab_getfem.py fixed -n 16 -N 64
"""
import argparse

import getfem as gf
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

ROOF, GROUND, RIGHT = 1, 2, 3


def law(r):
    """Slope of the normal law: 0, 100 r, 2 - 15 (r - .02), 1.1."""
    return np.minimum(np.maximum(100.0 * r, 0.0), np.maximum(2.3 - 15.0 * r, 1.1))


def slab_mesh(n):
    """2n x n squares, each cut by the diagonal from lower left to upper right."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(2 * n), np.arange(n)))
    lower = np.array([[i, i + 1, i + 1], [j, j, j + 1]], dtype=float) / n
    upper = np.array([[i, i + 1, i], [j, j + 1, j + 1]], dtype=float) / n
    mesh = gf.Mesh("empty", 2)
    mesh.add_convex(gf.GeoTrans("GT_PK(2,1)"), np.concatenate([lower, upper], axis=2))
    outer = mesh.outer_faces()
    normal = mesh.normal_of_faces(outer)
    mesh.set_region(ROOF, outer[:, normal[1] > 0.5])
    mesh.set_region(GROUND, outer[:, normal[1] < -0.5])
    mesh.set_region(RIGHT, outer[:, normal[0] > 0.5])
    return mesh


class Slab:
    """Matrices on all unknowns, and what the table needs."""

    def __init__(self, n, steps):
        self.k = 1.0 / steps
        self.decay = np.exp(-self.k / 0.5)
        self.w0 = 0.5 * (1.0 - self.decay)
        self.mesh = slab_mesh(n)
        self.fem = gf.MeshFem(self.mesh, 2)
        self.fem.set_fem(gf.Fem("FEM_PK(2,1)"))
        scalar = gf.MeshFem(self.mesh, 1)
        scalar.set_fem(gf.Fem("FEM_PK(2,1)"))
        self.im = gf.MeshIm(self.mesh, gf.Integ("IM_TRIANGLE(2)"))
        one = np.ones(scalar.nbdof())

        def elasticity(lam, mu):
            return gf.asm_linear_elasticity(self.im, self.fem, scalar, lam * one, mu * one)

        young, poisson = 70.0, 0.3
        self.a = elasticity(5.0, 10.0)
        self.b = elasticity(young * poisson / ((1 + poisson) * (1 - 2 * poisson)),
                            young / (2 * (1 + poisson)))
        self.gram = elasticity(0.0, 0.5)
        body = np.vstack([0 * one, -10.0 * one])
        traction = np.vstack([3.0 * one, 0 * one])
        self.load = (gf.asm_volumic_source(self.im, self.fem, scalar, body)
                     + gf.asm_boundary_source(RIGHT, self.im, self.fem, scalar, traction))
        place = self.fem.basic_dof_nodes()
        is_y = np.arange(self.fem.nbdof()) % 2 == 1
        tiny = 0.25 / n
        self.free = np.flatnonzero(place[1] < 1.0 - tiny)
        self.ground = np.flatnonzero((place[1] < tiny) & is_y)
        x = place[0][self.ground]
        self.weight = np.where((x < tiny) | (x > 2.0 - tiny), 0.5 / n, 1.0 / n)
        self.middle = self.ground[np.argmin(abs(x - 1.0))]
        self.corner = self.ground[np.argmax(x)] - 1

    def matrix(self):
        """K = A / k + (1 - w0) B."""
        k = gf.Spmat("copy", self.a)
        k.scale(1.0 / self.k)
        b = gf.Spmat("copy", self.b)
        b.scale(1.0 - self.w0)
        return gf.Spmat("add", k, b)

    def rhs(self, step, u, h):
        return step * self.k * self.load + self.a.mult(u / self.k) + self.b.mult(self.decay * h)

    def advance(self, u, h):
        return self.decay * h + self.w0 * u

    def report(self, step, u, reaction):
        strain = np.sqrt(u @ self.gram.mult(u))
        print(f"{step * self.k:.12g} {u[self.middle]:.13g} {u[self.corner]:.13g} "
              f"{strain:.13g} {reaction:.13g}")


def fixed_point(slab, steps):
    """One SuperLU factor of the free unknowns; the contact force goes to the right-hand side."""
    free = slab.free
    matrix = gf.Spmat("copy", slab.matrix(), free, free)
    matrix.to_csc()
    start, row = matrix.csc_ind()
    matrix = sparse.csc_matrix((matrix.csc_val(), row, start), shape=(len(free), len(free)))
    solver = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                  options={"SymmetricMode": True})
    u = np.zeros(slab.fem.nbdof())
    h = np.zeros_like(u)
    for step in range(1, steps + 1):
        rhs = slab.rhs(step, u, h)
        r = -u[slab.ground]
        for _ in range(200):
            total = rhs.copy()
            total[slab.ground] += slab.weight * law(r)
            u[free] = solver.solve(total[free])
            before, r = r, -u[slab.ground]
            if abs(r - before).max() <= 1e-10 * abs(r).max():
                break
        h = slab.advance(u, h)
        slab.report(step, u, (slab.weight * law(r)).sum())


def model_solver(slab, steps):
    """GetFEM's model object: K as an explicit matrix, the law as a nonlinear boundary term."""
    trapezoid = gf.MeshIm(slab.mesh, gf.Integ("IM_NC(2,1)"))
    model = gf.Model("real")
    model.add_fem_variable("u", slab.fem)
    model.add_explicit_matrix("u", "u", slab.matrix(), 1, 1)
    term = model.add_explicit_rhs("u", slab.load)
    slope = "min(max(-100*u(2),0),max(2.3+15*u(2),1.1))"
    model.add_nonlinear_term(trapezoid, f"-({slope})*Test_u(2)", GROUND)
    model.add_Dirichlet_condition_with_simplification("u", ROOF)
    u = np.zeros(slab.fem.nbdof())
    h = np.zeros_like(u)
    for step in range(1, steps + 1):
        model.set_private_rhs(term, slab.rhs(step, u, h))
        model.solve("max_res", 1e-8, "max_iter", 50)
        u = model.variable("u")
        h = slab.advance(u, h)
        slab.report(step, u, (slab.weight * law(-u[slab.ground])).sum())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("method", choices=["fixed", "model"])
    parser.add_argument("-n", type=int, default=16)
    parser.add_argument("-N", type=int, default=64)
    args = parser.parse_args()
    gf.util("trace level", 0)
    slab = Slab(args.n, args.N)
    {"fixed": fixed_point, "model": model_solver}[args.method](slab, args.N)


if __name__ == "__main__":
    main()
