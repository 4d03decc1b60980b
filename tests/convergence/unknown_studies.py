"""`study`, `--accuracy` and adapted meshes with several unknowns, and on meshes of several pieces: against exact solutions.

usage: unknown_studies.py HVI_RUN [CHECK...]
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from turned import PROGRAM, below, close, judge, run, table

# A warm body on a ground that softens; u and theta are given, of different sizes and units.
WARM = """
param n = 4
param element = P1
mesh body = rectangle(1, 1, cells = [n, n])
part held = body.left
part ground = body.bottom
part rim = body.top + body.right
tensor B = isotropic(young = 1000, poisson = 0.3)
fn still() = 0.001*[x*sin(2*y), -x*(1 + 0.5*x)*cos(y)]
fn warmth() = 40*sin(2*x + y)
superpotential layer(r) with slope | r < 0 -> 0 | r < 0.001 -> 500*r | otherwise -> 0.5 - 100*(r - 0.001)
fn depth() = 0.001*x*(1 + 0.5*x)
fn push() = (| depth() < 0.001 -> 500*depth() | otherwise -> 0.5 - 100*(depth() - 0.001))
space V = vector element on body, zero on held, zero on rim
space W = scalar element on body, zero on held
find u in V, theta in W with u = still() on rim, theta = warmth() on held
such that for all v in V, eta in W
    integral(body, B : eps(u) : eps(v)) - integral(body, 0.02*theta*div(v)) + integral(body, dot(grad(theta), grad(eta)))
  + integral(ground, layer^0(u.nu; v.nu), rule = gauss)
 >= integral(body, B : eps(still()) : eps(v)) - integral(body, 0.02*warmth()*div(v)) + integral(body, dot(grad(warmth()), grad(eta)))
  + integral(ground, push()*v.nu, rule = gauss)
report
  table off_u = sqrt(integral(body, (eps(u) - eps(still())) : (eps(u) - eps(still())))), off_theta = sqrt(integral(body,
      dot(grad(theta) - grad(warmth()), grad(theta) - grad(warmth())))), size_u = sqrt(integral(body, eps(still()) : eps(still()))),
      size_theta = sqrt(integral(body, dot(grad(warmth()), grad(warmth()))))
"""

# Stokes flow without laws: the error of the pressure is in L2.
FLOW = """
param n = 4
mesh flow = rectangle(1, 1, cells = [n, n])
part walls = flow.left + flow.bottom + flow.top
fn exact() = [(1 - 2*y)*(1 + x^2/2), -y*(1 - y)*x]
fn pressure() = 2*sin(2*x)*(1 + y^2)
fn stress() = 2*eps(exact()) - [[pressure(), 0], [0, pressure()]]
part open = flow.right
space V = vector P2 on flow, zero on walls
space Q = scalar P1 on flow
find u in V, p in Q with u = exact() on walls
such that for all v in V, q in Q
    integral(flow, 2*(eps(u) : eps(v)) - p*div(v)) + integral(flow, q*div(u)) >= integral(flow, stress() : eps(v))
report
  table off_u = sqrt(integral(flow, (eps(u) - eps(exact())) : (eps(u) - eps(exact())))), off_p = sqrt(integral(flow, (p - pressure())^2)),
      size_u = sqrt(integral(flow, eps(exact()) : eps(exact()))), size_p = sqrt(integral(flow, pressure()^2))
"""


def command(script, *words):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "a.hvi").write_text(script)
        done = subprocess.run([PROGRAM, *words, "a.hvi", "-o", "out", "--json", "a.json"], cwd=folder, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stdout + done.stderr
        return json.loads((folder / "a.json").read_text()), done.stdout


def study_rows(script, statement):
    data, said = command(script + f"study {statement}\n", "study")
    return data["rows"], said


def against_exact():
    """A study's errors of each unknown, and of both together, are those that integrals of the report have."""
    for script, names, exact in ((WARM, ("u", "theta"), "[still(), warmth()]"), (FLOW, ("u", "p"), "[exact(), pressure()]")):
        rows, said = study_rows(script, f"vary n in [4, 8, 16] against exact {exact}")
        assert "in its own norm" in said and "of all unknowns together" in said
        for n, row in zip((4, 8, 16), rows):
            alone = {k: v[-1] for k, v in table(script.replace("param n = 4", f"param n = {n}")).items()}
            together = 0.0
            for name in names:
                found = row["unknown_errors"][name]
                close(found["V_max"], alone["off_" + name], 1e-6, f"n = {n}: error of {name}")
                close(found["relative"], alone["off_" + name] / alone["size_" + name], 1e-6, "relative")
                together = math.hypot(together, found["relative"])
            close(row["error"]["V_max"], together, 1e-12, "together")
        order = 1 if script is WARM else 2
        assert abs(rows[-1]["order"] - order) < 0.1, rows[-1]["order"]


def against_finest():
    """Against the finest run, on nested meshes and on others, extrapolated or not, and in the norm of one unknown."""
    for script, names, order in ((WARM, ("u", "theta"), 1), (FLOW, ("u", "p"), 2)):
        exact = [{k: v[-1] for k, v in table(script.replace("param n = 4", f"param n = {n}")).items()} for n in (4, 8, 16)]
        for statement, tolerance in (("vary n in [4, 8, 16, 64] against finest", 0.08), ("vary n in [4, 8, 16, 49] against finest", 0.08),
                                     ("vary n in [4, 8, 16, 32] against richardson", 0.05)):
            rows, _ = study_rows(script, statement)
            for row, alone in zip(rows, exact):
                for name in names:
                    close(row["unknown_errors"][name]["V_max"], alone["off_" + name], tolerance, f"{statement}: {name}")
            assert abs(rows[2]["order"] - order) < 0.15, rows[2]["order"]
        space, name = ("W", "theta") if names[1] == "theta" else ("Q", "p")
        rows, said = study_rows(script, f"vary n in [4, 8, 64] against finest in {space}")
        assert f"of `{name}`" in said
        close(rows[0]["error"]["V_max"], rows[0]["unknown_errors"][name]["V_max"], 1e-14, f"in {space}")


def promised():
    """The accuracy that is asked for is had, of each unknown and of both, with elements free and as written."""
    for script, names in ((WARM, ("u", "theta")), (FLOW, ("u", "p"))):
        for wanted in (0.05, 0.005):
            data, said = command(script, "run", "--accuracy", str(wanted))
            final = {k: v[-1] for k, v in data["table"].items()}
            off = math.hypot(*(final["off_" + name] / final["size_" + name] for name in names))
            print(f"  wanted {wanted}: {off:.2e}, {data['accuracy']['tries'][-1]['setting']}")
            assert off <= wanted, off
            assert data["accuracy"]["tries"][-1]["estimate"] <= 8 * off, "the estimate is far above the error"


RING = """
param n = 4
mesh tube = rectangle(1, 1, cells = [n, n], axisymmetric = true)
part rim = tube.right + tube.top + tube.bottom
fn exact() = (1 + sin(3*t))*(1 - x^2)*sin(2*y + 0.3)
space W = scalar P1 on tube, zero on rim
superpotential wall(s) = s^2
find w in W with w = exact() on rim for t in [0, 1] by 4 steps from w = (1 - x^2)*sin(2*y + 0.3)
such that for all s in W
  integral(tube, w'*s + dot(grad(w), grad(s))) + integral(tube, wall^0(w; s)) >= integral(tube, (3*cos(3*t)*(1 - x^2)*sin(2*y + 0.3) + 2*exact() + 4*(1 + sin(3*t))*sin(2*y + 0.3) + 4*exact())*s)
report
  table size = norm(w), e = sqrt(integral(tube, dot(grad(w - exact()), grad(w - exact()))))
"""
# Heat crosses a gap between two bodies whose meshes do not match.
GAP = """
param n = 2
mesh upper = rectangle(1, 1, cells = [2*n, n], at = [0, 1.5])
mesh lower = rectangle(1, 1, cells = [3*n, 2*n])
mesh both = upper + lower
part roof = upper.top + upper.left + upper.right
part base = lower.bottom + lower.left + lower.right
part seam = pair(upper.bottom, lower.top)
fn a() = 1 + sin(3*t)
fn below() = a()*sin(x + 1)*(y + 0.5*y^2)
fn above() = a()*sin(x + 1)*(2*(y - 1.5) - 0.25*(y - 1.5)^2 + 2.5)
superpotential film(s) = s^2
space W = scalar P1 on both, zero on roof, zero on base
find w in W with w = above() on roof, w = below() on base for t in [0, 1] by 4 steps from w = sin(x + 1)*((| y > 1.2 -> 2*(y - 1.5) - 0.25*(y - 1.5)^2 + 2.5 | otherwise -> y + 0.5*y^2))
such that for all s in W
  integral(both, w'*s + dot(grad(w), grad(s))) + integral(seam, film^0(jump(w); jump(s)))
 >= integral(upper, (3*cos(3*t)*sin(x + 1)*(2*(y - 1.5) - 0.25*(y - 1.5)^2 + 2.5) + above() + 0.5*a()*sin(x + 1))*s)
  + integral(lower, (3*cos(3*t)*sin(x + 1)*(y + 0.5*y^2) + below() - a()*sin(x + 1))*s)
report
  table size = norm(w), e = sqrt(integral(upper, dot(grad(w - above()), grad(w - above()))) + integral(lower, dot(grad(w - below()), grad(w - below())))), f = integral(seam, film.xi)
"""


def promised_on_pairs_and_rings():
    """The accuracy that is asked for is had across a pair and by a body of revolution, against exact solutions."""
    for script, name in ((RING, "ring"), (GAP, "pair")):
        for wanted in (0.05, 0.005):
            data, _ = command(script, "run", "--accuracy", str(wanted))
            final = data["table"]
            off = max(e / max(final["size"]) for e in final["e"])
            print(f"  {name}: wanted {wanted}: {off:.2e}, {data['accuracy']['tries'][-1]['setting']}")
            assert 0 < off <= wanted, off
            assert data["accuracy"]["tries"][-1]["estimate"] <= 8 * off, "the estimate is far above the error"


TWO = """
mesh upper = rectangle(1, 0.5, cells = [4, 2], at = [0.25, 1])
mesh lower = rectangle(2, 1, cells = [6, 4])
mesh both = upper + lower
part roof = upper.top
part base = lower.bottom
part seam = pair(upper.bottom, lower.top)
tensor B = isotropic(young = 100, poisson = 0.3)
superpotential rigid(r) with slope | r < 0 -> 0 | otherwise -> 1e300
space V = vector P1 on both, zero on roof, zero on base
find u in V with u.y = -0.01*t on roof for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(both, B : eps(u) : eps(v)) + integral(both, 0.1*(B : eps(u') : eps(v))) + integral(seam, rigid^0(jump(u).nu - gap(seam); jump(v).nu)) >= 0
report
  table force = integral(seam, rigid.xi), work = integral(both, sigma : eps(u))
"""


def pieces():
    """A wanted accuracy on a mesh of two pieces, and adapted pieces: nearer than even ones with as many cells."""
    data, _ = command(TWO, "run", "--accuracy", "0.02", "--of", "force")
    said = data["accuracy"]["tries"][-1]["setting"]
    assert " and " in said, said
    finer = {"cells = [4, 2]": "cells = [64, 32]", "cells = [6, 4]": "cells = [96, 64]", "by 4 steps": "by 128 steps", "P1": "P2"}
    fine = TWO
    for a, b in finer.items():
        fine = fine.replace(a, b)
    reference = table(fine)
    close(data["table"]["force"][-1], reference["force"][-1], 0.02, f"force with {said}")
    even = table(TWO.replace("[4, 2]", "[20, 10]").replace("[6, 4]", "[30, 20]"))["work"][-1]  # 1,600 cells
    fitted = table(TWO.replace("[4, 2]", "[4, 2], adapted = 800").replace("[6, 4]", "[6, 4], adapted = 800"))["work"][-1]
    best = table(fine.replace("by 128 steps", "by 4 steps"))["work"][-1]
    print(f"  work: even {even - best:.2e}, adapted {fitted - best:.2e} off")
    assert abs(fitted - best) < 0.7 * abs(even - best)


def adapted():
    """Two unknowns, each with a corner of its own that is singular: bisected meshes see both."""
    script = """
mesh body = rectangle(2, 1, cells = [8, 4])
part held = body.left
part cold = body.top where x > 1.5
tensor B = isotropic(young = 100, poisson = 0.3)
space V = vector P1 on body, zero on held
space W = scalar P1 on body, zero on cold
find u in V, theta in W such that for all v in V, eta in W
    integral(body, B : eps(u) : eps(v)) - integral(body, 0.1*theta*div(v)) + integral(body, dot(grad(theta), grad(eta)))
 >= integral(body, -v.y) + integral(body, eta)
report
  table of_u = integral(body, eps(u) : eps(u)), of_theta = integral(body, dot(grad(theta), grad(theta)))
"""
    fine = table(script.replace("[8, 4]", "[128, 64]").replace("P1", "P2"))
    even, fitted = (table(script.replace("[8, 4]", cells)) for cells in ("[60, 30]", "[8, 4], adapted = 3600"))
    for name in ("of_u", "of_theta"):
        off = [abs(one[name][-1] / fine[name][-1] - 1) for one in (even, fitted)]
        print(f"  {name}: even {off[0]:.2e}, adapted {off[1]:.2e} off")
        assert off[1] < 0.7 * off[0]


if __name__ == "__main__":
    sys.exit(judge([against_exact, against_finest, promised, promised_on_pairs_and_rings, pieces, adapted]))
