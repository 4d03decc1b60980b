"""The Cea type inequality of the paper: along the ladder its constant stays bounded, and its terms fall as the
paper says (orders in h and k); the same against an exact solution and against a fine run.

usage: cea.py HVI_RUN ROOT
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

program, root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
script = (root / "examples/manufactured.hvi").read_text()
ladder = "study vary n in [4, 8, 16, 32] and N in [4, 8, 16, 32] against exact t * phi() in V"
assert ladder in script


def diagonal(study, text):
    with tempfile.TemporaryDirectory() as folder:
        path, out = pathlib.Path(folder) / "model.hvi", pathlib.Path(folder) / "study.json"
        path.write_text(text.replace(ladder, study))
        subprocess.run([program, "study", path, "-o", pathlib.Path(folder) / "out", "--json", out, "--quiet"],
                       check=True, stdout=subprocess.DEVNULL)
        rows = json.loads(out.read_text())["rows"]
    rows = [row for row in rows if row["params"]["n"] == row["params"]["N"] and "error" in row]
    for row in rows:
        c = row["cea"]
        print(f"n = N = {row['params']['n']:>3}: |e|^2 {row['error']['V_max'] ** 2:.2e}",
              {name: float(f"{value:.2e}") for name, value in c.items()})
        bound = sum(c[t] for t in ("interpolation", "interpolation_rate", "trace", "residual", "rate", "start", "step"))
        assert abs(row["error"]["V_max"] ** 2 / bound - c["constant"]) < 1e-6 * c["constant"]
    return rows


def order(rows, term):
    return math.log2(rows[-2]["cea"][term] / rows[-1]["cea"][term])


exact = diagonal(ladder, script)
constants = [row["cea"]["constant"] for row in exact]
assert max(constants) < 1.0 and max(constants) < 3 * min(constants), constants
for term, expected in (("interpolation", 2), ("trace", 2), ("step", 2)):
    seen = order(exact, term)
    print(term, "order", round(seen, 2))
    assert abs(seen - expected) < 0.35, (term, seen)
# |S_n(v)| <= C ||M(u - v)||, and where the law has one value only S_n vanishes: what is left is the rounding of
# the fine space that stands for u, of a higher order.
assert all(row["cea"]["residual"] <= row["cea"]["trace"] for row in exact) and order(exact, "residual") > 1.9
assert all(row["cea"]["rate"] < 1e-15 for row in exact), "u = t phi is exact for difference quotients"

# Against the finest run: the same terms, its own interpolation error aside.
fine = diagonal("study vary n in [4, 8, 16, 64] and N in [4, 8, 16, 64] against finest", script)
for a, b in zip(exact, fine):
    ratio = b["cea"]["interpolation"] / a["cea"]["interpolation"]
    assert 0.7 < ratio < 1.3, ratio
assert max(row["cea"]["constant"] for row in fine) < 1.0

# A law without a bound (unilateral contact) has no J^0 to compare with: no terms.
unilateral = """import contact
param N = 4
mesh bar = interval(1, cells = 8)
part left = bar.left
part right = bar.right
superpotential wall(r) = unilateral(r, gap = 0.1)
space V = scalar P1 on bar, zero on left
find u in V for t in [0, 1] by N steps from u = 0
such that for all v in V
    integral(bar, dot(grad(u'), grad(v))) + integral(bar, dot(grad(u), grad(v))) + integral(right, wall^0(u; v)) >= integral(right, 2*t*v)
report
  table end = u at [1], twice = 2*integral(right, wall.xi)
study vary N in [4, 8, 16] against finest
"""
with tempfile.TemporaryDirectory() as folder:
    path, out = pathlib.Path(folder) / "model.hvi", pathlib.Path(folder) / "study.json"
    path.write_text(unilateral)
    subprocess.run([program, "study", path, "-o", pathlib.Path(folder) / "out", "--json", out, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    rows = json.loads(out.read_text())["rows"]
    assert all("error" in row for row in rows[:2]) and not any("cea" in row for row in rows), rows
    # Parts of a column (the integral in `twice`) are no columns of their own.
    subprocess.run([program, "run", path, "-o", pathlib.Path(folder) / "out", "--json", out, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    assert set(json.loads(out.read_text())["final"]) == {"end", "twice"}

# A static start is a start like others: the same terms as of the same values given, against a run and an exact solution.
begun = """param N = 4
mesh bar = interval(1, cells = 4)
part left = bar.left
part right = bar.right
space V = scalar P1 on bar, zero on left
fn tip(t) = 0.5 + 0.75*(t - 0.1*(1 - exp(-10*t)))
find u in V for t in [{first}, {first} + 1] by N steps from u = {start}
such that for all v in V
    integral(bar, 0.2*dot(grad(u'), grad(v))) + integral(bar, 2*dot(grad(u), grad(v)))
  = integral(right, (1 + 1.5*(t - ({first})))*v)
report
  table end = u at [1], wanted = tip(t - ({first}))
study vary N in [8, 16, 32, 64] against {against}
"""
for against in ("finest", "exact tip(t - ({first}))*x"):
    seen = []
    for start, first in (("0.5*x", 0), ("static", 0), ("static", -1)):
        with tempfile.TemporaryDirectory() as folder:
            path, out = pathlib.Path(folder) / "model.hvi", pathlib.Path(folder) / "study.json"
            path.write_text(begun.format(start=start, first=first, against=against.format(first=first)))
            subprocess.run([program, "study", path, "-o", pathlib.Path(folder) / "out", "--json", out, "--quiet"], check=True,
                           stdout=subprocess.DEVNULL)
            seen.append([row["cea"] for row in json.loads(out.read_text())["rows"][:3]])
    for other in seen[1:]:
        for given, static in zip(seen[0], other):
            for term in ("rate", "start", "step", "constant"):
                assert abs(given[term] - static[term]) <= 1e-6 * given[term] + 1e-15, (against, term, given, static)
    assert seen[0][0]["rate"] > 3 * seen[0][-1]["rate"], seen[0]
