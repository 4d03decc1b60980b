"""The inf-sup constant that `check` prints, against dense algebra on matrices assembled here.

usage: inf_sup.py HVI_RUN

The least of sup_v c(v, p) / |v|_V over p of size 1 in L2 is the root of the least eigenvalue of C G^-1 C^T against the
mass M of p, G the Gram matrix eps : eps. Stokes flow with Taylor and Hood's elements keeps its constant on finer
meshes; a multiplier in P1, for displacements in P1 that it sees by p*u.x, has one that falls. A multiplier of the rates, p*div(v) and q*div(u'), has
the constant of one of u. In a closed vessel no flow sees the mean of the pressure, and a value at one point fixes it: the constant is that of
pressures without means. References: independent.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from fields import Scalar
from solids import Solid, block, shapes

SIDES = "left", "right", "bottom", "top"
PROGRAM = pathlib.Path(sys.argv[1]).resolve()


def values(scalar, body):
    """int p v.x: rows p, columns v."""
    out = np.zeros((scalar.n, body.n))
    for cell, volume, _ in scalar.cells():
        nodes, dofs = scalar.solid.nodes(cell), body.dofs(body.nodes(cell))
        for b, weight in scalar.rule:
            v = np.kron(shapes(body.order, b), [1.0, 0.0])
            out[np.ix_(nodes, dofs)] += weight * volume * np.outer(shapes(scalar.order, b), v)
    return out


def dense(mesh, order, stable):
    body, scalar = Solid(mesh, order), Scalar(mesh, 1)
    walls = "left", "right", "bottom"
    free = np.setdiff1d(np.arange(body.n), np.concatenate([body.dofs(body.on(name)) for name in walls]))
    seen = np.arange(scalar.n)
    if not stable:
        seen = np.setdiff1d(seen, np.concatenate([scalar.solid.on(name) for name in walls]))
    gram = body.stiffness(0.0, 0.5)[np.ix_(free, free)]
    couplings = (scalar.divergence(body) if stable else values(scalar, body))[np.ix_(seen, free)]
    mass = scalar.mass_and_stiffness()[0][np.ix_(seen, seen)]
    inner = np.linalg.inv(np.linalg.cholesky(mass))
    return np.sqrt(np.linalg.eigvalsh(inner @ couplings @ np.linalg.solve(gram, couplings.T) @ inner.T)[0])


def dense_closed(mesh):
    """Of a vessel with walls on all sides: the least but that of the constants, which is 0."""
    body, scalar = Solid(mesh, 2), Scalar(mesh, 1)
    free = np.setdiff1d(np.arange(body.n), np.concatenate([body.dofs(body.on(name)) for name in SIDES]))
    gram, couplings = body.stiffness(0.0, 0.5)[np.ix_(free, free)], scalar.divergence(body)[:, free]
    inner = np.linalg.inv(np.linalg.cholesky(scalar.mass_and_stiffness()[0]))
    return np.sqrt(np.linalg.eigvalsh(inner @ couplings @ np.linalg.solve(gram, couplings.T) @ inner.T)[1])


def printed(mesh, order, stable, rates=False, closed=False):
    """On this mesh, whether it holds, and on the refined mesh. `rates`: p holds u', the velocity of a body that creeps."""
    coupled = ("- p*div(v) + q*div(u)" if stable else "- p*v.x + q*u.x").replace("(u)", "(u')" if rates else "(u)")
    times, u = (" for t in [0, 1] by 2 steps from u = 0, p = 0", "u'") if rates else ("", "u")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "body.msh").write_text(mesh.msh())
        (folder / "a.hvi").write_text(f"""
mesh flow  = gmsh("body.msh")
part walls = {" + ".join(f'flow.group("{name}")' for name in (SIDES if closed else SIDES[:3]))}
part place = point(flow, [{mesh.points[1][0]!r}, {mesh.points[1][1]!r}])
space V = vector P{order} on flow, zero on walls
space Q = scalar P1 on flow{", zero on place" if closed else "" if stable else ", zero on walls"}
find u in V, p in Q{times}
such that for all v in V, q in Q
    integral(flow, 2*(eps({u}) : eps(v)) {coupled})
 >= integral(flow, v.y)
report
  table speed = norm(u)
""")
        subprocess.run([PROGRAM, "check", "a.hvi", "--json", "a.json"], cwd=folder, check=True, capture_output=True)
        rows = json.loads((folder / "a.json").read_text())["hypotheses"]
    row, = (r for r in rows if "inf-sup" in r["bound"])
    return row["value"], row["holds"], float(re.match(r"([\d.e+-]+) on the refined mesh", row["note"])[1])


def main():
    random, wrong = np.random.default_rng(4), 0
    for order, stable in ((2, True), (1, False)):
        last = None
        for n in (2, 4, 8):
            mesh = block(random, (n, n), (1.3, 1.0), wobble=0.2 if n == 2 else 0.0)
            expected = dense(mesh, order, stable)
            value, holds, finer = printed(mesh, order, stable)
            if stable and n == 4:
                of_rates = printed(mesh, order, stable, rates=True)
                wrong += not (abs(of_rates[0] - value) <= 1e-9 * value and of_rates[1] and abs(of_rates[2] - finer) <= 1e-5 * finer)
                print(f"of rates: {of_rates}")
            falls = last is not None and expected < 0.7 * last
            print(f"P{order}/P1, n {n}: {value:.6g}, dense {expected:.6g}; refined {finer:.6g}; {'holds' if holds else 'fails'}")
            wrong += not abs(value - expected) <= 1e-5 * expected
            wrong += holds != (finer > 0.7 * value) or holds != stable
            wrong += last is not None and falls == stable
            last = expected
    for n in (2, 4, 8):
        mesh = block(random, (n, n), (1.3, 1.0), wobble=0.2 if n == 4 else 0.0)
        expected, (value, holds, finer) = dense_closed(mesh), printed(mesh, 2, True, closed=True)
        print(f"closed, n {n}: {value:.6g}, dense {expected:.6g}; refined {finer:.6g}; {'holds' if holds else 'fails'}")
        wrong += not (abs(value - expected) <= 1e-5 * expected and holds == (finer > 0.7 * value) and holds)
    print(f"{wrong} faults")
    return int(wrong > 0)


sys.exit(main())
