"""The norm of the trace on a pair, |[u]| by |eps(u)|, that `check` prints: against dense algebra.

usage: pair_traces.py HVI_RUN

Two blocks whose meshes do not match, in 2D and 3D, u in P1 or P2, alone or with a scalar in P1 or P2 beside it. The squares of the
norms are the largest eigenvalues of sum_i w_i [u]_i . N [u]_i against int eps : eps, N = nu nu^T, 1 - nu nu^T or 1, with the mortar and
the matrices of the tests (mortar.py, solids.py, fields.py); of several unknowns the largest one of theirs.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
import scipy.linalg

from fields import Scalar
from mortar import pair_points
from pairs import together
from solids import Solid, block

AGREES = 2e-5  # five digits are printed


def largest(trace, gram, held):
    free = np.setdiff1d(np.arange(len(gram)), held)
    return scipy.linalg.eigh(trace[np.ix_(free, free)], gram[np.ix_(free, free)], eigvals_only=True)[-1]


def expected(mesh, order, of_scalar):
    dim, body = mesh.dim, Solid(mesh, order)
    points = Solid(mesh, max(order, of_scalar or 1))
    sides = mesh.facets["u_bottom"], mesh.facets["l_top"]
    out, held = [], body.dofs(sorted({*body.on("u_top"), *body.on("l_bottom")}))
    gram = body.stiffness(0.0, 0.5)
    for kind in ("normal", "tangential", "full"):
        trace = np.zeros_like(gram)
        for p in pair_points(points, *sides, body)[0]:
            along = np.outer(p.normal, p.normal)
            n = {"normal": along, "tangential": np.eye(dim) - along, "full": np.eye(dim)}[kind]
            trace += p.weight * p.jump.T @ n @ p.jump
        out.append(largest(trace, gram, held))
    if of_scalar is None:
        return out
    scalar = Scalar(mesh, of_scalar)
    trace, gram = np.zeros((scalar.n, scalar.n)), scalar.mass_and_stiffness()[1]
    for p in pair_points(points, *sides, scalar.solid)[0]:
        row = p.jump[0, ::dim]
        trace += p.weight * np.outer(row, row)
    held = sorted({*scalar.solid.on("u_top"), *scalar.solid.on("l_bottom"), *scalar.missing()})
    return [max(out[2], largest(trace, gram, held))]


def script(order, of_scalar):
    more = of_scalar is not None
    return f"""mesh upper = gmsh("upper.msh")
mesh lower = gmsh("lower.msh")
mesh both = upper + lower
part seam = pair(upper.bottom, lower.top)
part top = upper.top
part base = lower.bottom
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential spring(xi) = 0.5*norm(xi)^2
space V = vector P{order} on both, zero on top, zero on base
{f"space W = scalar P{of_scalar} on both, zero on top, zero on base" if more else ""}
find u in V{", theta in W" if more else ""} such that for all v in V{", eta in W" if more else ""}
  integral(both, B : eps(u) : eps(v)){" + integral(both, dot(grad(theta), grad(eta)))" if more else ""}
  + integral(seam, spring^0(jump(u); jump(v))) >= 0
report
  table size = norm(u)
"""


def main():
    program, wrong, worst = str(pathlib.Path(sys.argv[1]).resolve()), 0, 0.0
    cases = [(dim, order, of_scalar) for dim in (2, 3) for order in (1, 2) for of_scalar in (None, 1, 2)]
    for k, (dim, order, of_scalar) in enumerate(cases):
        random = np.random.default_rng([1, k])
        upper, lower = (block(random, [int(random.integers(1, 4)), 1, 1][:dim], random.uniform(0.7, 1.3, dim)) for _ in range(2))
        upper.points += [0.1, lower.points[:, 1].max(), 0.05][:dim]
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "upper.msh").write_text(upper.msh()), (folder / "lower.msh").write_text(lower.msh())
            (folder / "a.hvi").write_text(script(order, of_scalar))
            said = subprocess.run([program, "check", "a.hvi"], cwd=folder, capture_output=True, text=True, timeout=120).stdout
        told = " ".join(said.split())
        found = re.search(r"traces: normal (\S+), tangential (\S+), full (\S+)|full trace: ?(\S+)|trace (\S+)", told)
        values = [float(v.rstrip(",")) for v in found.groups() if v]
        known = expected(together(upper, lower), order, of_scalar)
        off = max(abs(a / b - 1) for a, b in zip(values[-len(known):], known))
        worst = max(worst, off)
        if off > AGREES:
            wrong += 1
            print(f"{dim}D P{order}, scalar {of_scalar}: {values}, expected {known}", file=sys.stderr)
    print(f"family pair_traces: scenes {len(cases)}, wrong {wrong}, worst {worst:.1e}")
    return 0 if wrong == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
