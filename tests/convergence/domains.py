"""Spaces on a piece or on a part of the mesh, against meshes that end where the space does.

usage: domains.py HVI_RUN [CHECK...]
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from turned import PROGRAM, close, judge, run, table

HEAT = """
kernel q(lag) = 0.5*exp(-2*lag)
superpotential wall(s) with slope | s < 0.2 -> 2*s | otherwise -> 0.4
"""
OF_P = """integral({0}, 0.3*p'*s) + integral({0}, (1 + y)*dot(grad(p), grad(s))) + integral({0}, dot(history(q, grad(p)), grad(s)))
  + integral(ground, wall^0(p; s))"""
BODY = """
tensor A = isotropic(young = 1, poisson = 0.3)
tensor B = isotropic(young = 10, poisson = 0.3)
"""
TIME = "for t in [0, 2] by 6 steps"


def same(found, alone, names, what):
    for name in names:
        error = np.abs(found[name] - alone[name]).max() / np.abs(alone[name]).max()
        assert error <= 1e-10, (what, name, error)
    print(f"  {what}: the same")


def on_a_part():
    """A scalar in the left half of a block, coupled with a displacement in all of it, is that of a block half as wide."""
    columns = "e = p at [0.4, 0.3], f = integral(ground, wall.xi), g = norm(p), h = integral({}, p), i = integral({}, grad(p).y^2)"
    for order, other in (("P1", "P1"), ("P2", "P2"), ("P1", "P2"), ("P2", "P1")):
        alone = table(f"""
mesh half = rectangle(1, 1, cells = [4, 4])
part roof = half.top
part ground = half.bottom
{HEAT}
space W = scalar {other} on half, zero on roof
find p in W {TIME} from p = 0 using scheme = bdf2
such that for all s in W {OF_P.format("half")} >= integral(half, 3*t*s)
report table {columns.format("half", "half")}""")
        both = table(f"""
mesh body = rectangle(2, 1, cells = [8, 4])
part patch = body where x < 1
part held = body.right
part roof = body.top
part ground = body.bottom where x < 1
{BODY}{HEAT}
space V = vector {order} on body, zero on held
space W = scalar {other} on patch, zero on roof
find u in V, p in W {TIME} from u = 0, p = 0 using scheme = bdf2
such that for all v in V, s in W
    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) - integral(patch, 0.4*p*div(v))
  + {OF_P.format("patch")} >= integral(patch, 3*t*s)
report table {columns.format("patch", "patch")}, a = u.x at [0, 0.5]""")
        same(both, alone, "efghi", f"{other} on a part beside {order}")
        assert np.abs(both["a"]).max() > 1e-3, "the scalar pushes the body"


def on_a_piece():
    """Heat in the upper of two blocks only; their contact is that of a run that is given its temperature."""
    spaces = """
mesh upper = rectangle(1, 1, cells = [4, 3], at = [0, 1])
mesh lower = rectangle(1, 1, cells = [3, 4])
mesh both = upper + lower
part roof = upper.top
part base = lower.bottom
part ground = upper.left
part seam = pair(upper.bottom, lower.top)
superpotential rigid(r) with slope | r < 0 -> 0 | otherwise -> 1e300
space V = vector P1 on both, zero on roof, zero on base
""" + BODY
    contact = """integral(both, A : eps(u') : eps(v)) + integral(both, B : eps(u) : eps(v))
  + integral(seam, rigid^0(jump(u).nu - gap(seam); jump(v).nu))"""
    found = table(spaces + f"""{HEAT}
space W = scalar P1 on upper, zero on roof
find u in V, p in W with p = 2*t on roof {TIME} from u = 0, p = 0
such that for all v in V, s in W {contact} - integral(upper, 0.4*p*div(v)) + {OF_P.format("upper")} >= integral(upper, t*s)
report
  table press = integral(seam, rigid.xi), low = u.y at [0.5, 0.5], warm = p at [0.5, 1], size = norm(p), mean = integral(upper, p)
""")
    alone = table(f"""
mesh upper = rectangle(1, 1, cells = [4, 3], origin = [0, 1])
part roof = upper.top
part ground = upper.left
{HEAT}
space W = scalar P1 on upper, zero on roof
find p in W with p = 2*t on roof {TIME} from p = 0
such that for all s in W {OF_P.format("upper")} >= integral(upper, t*s)
report
  table warm = p at [0.5, 1], size = norm(p), mean = integral(upper, p)
""")
    same(found, alone, ("warm", "size", "mean"), "heat in one of two pieces")
    assert found["press"][-1] > 0.1 and found["low"][-1] < -1e-3, "the warm block presses on the other one"


def vector_on_a_piece():
    """A displacement in one piece and heat in both: the rigid motions of the other piece are none."""
    found = table(BODY + """
mesh bar = rectangle(1, 1, cells = [4, 4])
mesh bath = rectangle(1, 1, cells = [4, 4], at = [1, 0])
mesh both = bar + bath
part held = bar.left
part cold = bath.right
part seam = pair(bar.right, bath.left)
superpotential film(s) = 1.5*s^2
space V = vector P2 on bar, zero on held
space W = scalar P2 on both, zero on cold, zero on held
find u in V, theta in W with theta = 10 on held
such that for all v in V, eta in W
    integral(bar, B : eps(u) : eps(v)) - integral(bar, 0.3*theta*div(v)) + integral(both, dot(grad(theta), grad(eta)))
  + integral(seam, film^0(jump(theta); jump(eta))) >= 0
report
  table drop = jump(theta) at [1, 0.5], there = theta at [2, 0.5], grown = u.x at [1, 0.5]
""")
    # The flow g solves 10 = g + g/3 + g.
    close(found["drop"][-1], 10 / (2 + 1 / 3) / 3, 1e-10, "drop of the temperature")
    alone = table(BODY + f"""
mesh bar = rectangle(1, 1, cells = [4, 4])
part held = bar.left
space V = vector P2 on bar, zero on held
find u in V such that for all v in V
    integral(bar, B : eps(u) : eps(v)) >= integral(bar, 0.3*(10 - {10 / (2 + 1 / 3)!r}*x)*div(v))
report
  table grown = u.x at [1, 0.5]
""")
    close(found["grown"][-1], alone["grown"][-1], 1e-10, "how it grows")


def files():
    """Outside a field is 0, in cells as at nodes."""
    import meshio
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "a.hvi").write_text("""
mesh body = rectangle(2, 1, cells = [4, 2])
part patch = body where x < 1
part roof = body.top
space V = scalar P1 on body, zero on roof
space W = scalar P1 on patch, zero on roof
find u in V, p in W such that for all v in V, s in W
    integral(body, dot(grad(u), grad(v))) + integral(patch, dot(grad(p), grad(s))) >= integral(body, v) + integral(patch, s)
report
  table size = norm(p)
  fields u, p, grad(p)
  line u, p from [0, 0.25] to [2, 0.25] by 9 points
  picture p
""")
        done = subprocess.run([PROGRAM, "run", "a.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        grid = meshio.read(next((folder / "out").glob("*.vtu")))
        outside = grid.points[:, 0] > 1 + 1e-9
        assert np.abs(grid.point_data["p"][outside]).max() == 0.0 and np.abs(grid.point_data["p"]).max() > 0.1
        centres = grid.points[grid.cells[0].data].mean(axis=1)[:, 0]
        flow, = (np.concatenate(values) for values in grid.cell_data.values())
        assert np.abs(flow[centres > 1]).max() == 0.0 and np.abs(flow).max() > 0.1
        _, *rows = (line.split(",") for line in next((folder / "out").glob("*line.csv")).read_text().splitlines())
        here, there = [float(r[-1]) for r in rows if float(r[1]) <= 1], [r[-1] or None for r in rows if float(r[1]) > 1]
        assert len(here) == 5 and all(v > 0.01 for v in here) and len(there) == 4 and all(v is None for v in there)
    print("  zero outside")


def refused():
    """What sees the unknown outside is an error where it stands."""
    script = """
mesh upper = rectangle(1, 1, cells = [2, 2], at = [0, 1])
mesh lower = rectangle(1, 1, cells = [2, 2])
mesh both = upper + lower
part roof = upper.top
part base = lower.bottom
part flank = lower.left
part seam = pair(upper.bottom, lower.top)
superpotential film(s) = 0.5*s^2
superpotential weaker(w) = (1 + p^2)*norm(w)
space V = vector P1 on both, zero on roof, zero on base
space W = scalar P1 on upper, zero on roof
tensor B = isotropic(young = 10, poisson = 0.3)
find u in V, p in W such that for all v in V, s in W
    integral(both, B : eps(u) : eps(v)) + integral({form}, dot(grad(p), grad(s))) {law}
 >= integral({load}, s)
report
  table a = p at [0.5, {at}], b = integral({mean}, p), c = largest({most}, p)
"""
    good = dict(form="upper", law="", load="upper", at=1.5, mean="upper", most="upper")
    wrong = {"form": ("lower", "a form on `lower`"), "law": ("+ integral(seam, film^0(jump(p); jump(s)))", "the law `film` on `seam`"),
             "load": ("both", "a load on `both`"), "at": (0.5, "the point (0.5, 0.5) of `a`"), "mean": ("both", "the integral on `both`"),
             "most": ("lower", "the largest value on `lower`")}
    code, said, _ = run(script.format(**good))
    assert code == 0, said
    for key, (value, words) in wrong.items():
        code, said, _ = run(script.format(**{**good, key: value}))
        assert code == 1 and "`p` lives on `upper`" in said and words in said and "E0423" in said, (key, code, said)
    law = "+ integral(flank, weaker^0(u.tau; v.tau))"
    code, said, _ = run(script.format(**{**good, "law": law}))
    assert code == 1 and "`p` lives on `upper`" in said and "the law `weaker`" in said, said
    print(f"  {len(wrong) + 1} mistakes are told")


if __name__ == "__main__":
    sys.exit(judge([on_a_part, on_a_piece, vector_on_a_piece, files, refused]))
