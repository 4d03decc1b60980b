"""--accuracy on problems with known solutions: the true error is below the wanted one, the estimate is near
it, and what cannot be reached is said.

usage: accuracy.py HVI_RUN ROOT
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import jsonschema

program, root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
schema = json.loads((root / "docs/schema/hvi-result-1.schema.json").read_text())


def reach(script, *words, code=0):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "result.json"
        done = subprocess.run([program, script, "--quiet", "--json", out, "-o", folder, *map(str, words)],
                              capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        if code:
            return done.stderr
        result = json.loads(out.read_text())
    jsonschema.validate(result, schema)
    return result


# `strain` of u is within the error of u itself: what the error is relative to.
for name, wanted in (("examples/manufactured.hvi", 3e-2), ("examples/manufactured.hvi", 1e-3),
                     ("examples/manufactured3d.hvi", 3e-2), ("examples/membrane.hvi", 1e-2)):
    result = reach(root / name, "--accuracy", wanted)
    table, accuracy = result["table"], result["accuracy"]
    if "strain" in table:
        true = max(table["error"]) / max(table["strain"])
    else:  # membrane: || grad phi || by hand: int 256 ((1-2x)^2 y^2(1-y)^2 + ...) = 256 * 2 / 90
        true = max(table["error"]) / (256 * 2 / 90) ** 0.5
    print(f"{name} wanted {wanted:.0e}: true {true:.2e}, estimated {accuracy['estimate']:.2e}, "
          f"{accuracy['tries'][-1]['setting']}")
    assert accuracy["reached"] and true <= wanted
    assert 0.5 * true < accuracy["estimate"], "the estimate is no guess"

# A column: the slab's reference is the setting of FreeFEM and others, extrapolated by our own fine run.
fine = reach(root / "examples/slab.hvi", "--accuracy", 2e-4, "--of", "reaction")
rough = reach(root / "examples/slab.hvi", "--accuracy", 1e-2, "--of", "reaction")
off = abs(rough["final"]["reaction"] / fine["final"]["reaction"] - 1)
print(f"reaction: off by {off:.1e}, wanted 1e-2")
assert off <= 1e-2

# In the script; an unknown column; out of reach.
with tempfile.TemporaryDirectory() as folder:
    text = (root / "examples/manufactured.hvi").read_text()
    assert "from u = 0\n" in text
    script = pathlib.Path(folder) / "model.hvi"
    script.write_text(text.replace("from u = 0\n", "from u = 0 using accuracy = 2e-2, accuracy_of = strain\n"))
    assert reach(script)["accuracy"]["of"] == "strain"
assert "no column `nothing`" in reach(root / "examples/manufactured.hvi", "--accuracy", 0.1, "--of", "nothing",
                                      code=1)
message = reach(root / "examples/slab.hvi", "--accuracy", 1e-7, "--budget", 5, code=3)
assert "E0705" in message and "out of reach" in message, message

# What it compares are all steps of a run, which one that goes on has not.
assert "excludes" in reach(root / "examples/slab.hvi", "--accuracy", 1e-2, "--resume", code=2)

# A run begins where it begins: the search sees a static start as it sees the same values given.
begun = """mesh bar = interval(1, cells = 4)
part left = bar.left
part right = bar.right
space V = scalar P1 on bar, zero on left
find u in V for t in [0, 1] by 64 steps from u = {}
such that for all v in V
    integral(bar, 0.05*dot(grad(u'), grad(v))) + integral(bar, 2*dot(grad(u), grad(v)))
  = integral(right, (1 + exp(-((t - 0.6)/0.01)^2))*v)
report
  table tip = u at [1]
"""
with tempfile.TemporaryDirectory() as folder:
    script, ladders = pathlib.Path(folder) / "model.hvi", []
    for start in ("static", "0.5*x"):
        script.write_text(begun.format(start))
        runs = reach(script, "--accuracy", 1e-4)["accuracy"]["runs"]  # what is chosen goes by measured times, the ladder does not
        ladders.append([(run["setting"], run.get("distance", 0.0)) for run in runs if run["purpose"].startswith("time ladder")])
    assert min(map(len, ladders)) > 6 and all(a[0] == b[0] and abs(a[1] - b[1]) <= 1e-9 for a, b in zip(*ladders)), ladders

# Two runs of the ladder are near each other by chance here, where the error in the middle changes its sign: the check says
# what the law of the ladder does not, and the search goes on to a finer mesh (it tried one mesh twelve times).
# `sideways` is zero by symmetry: its error is compared with what its rounding is relative to.
by_chance = """mesh plate = rectangle(1, 1, cells = [4, 4])
part ends = plate.boundary
space V = scalar P2 on plate, zero on ends
space W = scalar P1 on plate, zero on ends
fn phi() = sin(pi*x)*sin(pi*y)
fn g() = sin(9.409*t)
find u in V, h in W for t in [0, 1] by 64 steps from u = 0, h = 0
such that for all v in V, q in W
    integral(plate, dot(grad(u), grad(v))) - integral(plate, 0.19849*h*v) + integral(plate, h'*q) + integral(plate, 1.2861*dot(grad(h), grad(q)))
  = integral(plate, (2*pi^2 - 0.19849)*g()*phi()*v) + integral(plate, (9.409*cos(9.409*t) + 1.2861*2*pi^2*g())*phi()*q)
report
  table middle = u at [0.5, 0.5], exact = g()
"""
pulled = """mesh bar = rectangle(1, 0.5, cells = [4, 2])
part left = bar.left
part right = bar.right
tensor B = isotropic(lambda = 0, mu = 0.5)
kernel C(lag) = -0.8*exp(-lag/0.7)*B
space V = vector P1 on bar, zero on left, zero on right
find u in V with u = [min(t, 0.4), 0] on right for t in [0, 1] by 64 steps from u = 0
such that for all v in V
    integral(bar, B : eps(u) : eps(v)) + integral(bar, history(C, eps(u)) : eps(v)) = 0
report
  table sideways = reaction(right).y
"""
with tempfile.TemporaryDirectory() as folder:
    script = pathlib.Path(folder) / "model.hvi"
    script.write_text(by_chance)
    result = reach(script, "--accuracy", 1e-3, "--of", "middle")
    off = max(abs(a - b) for a, b in zip(result["table"]["middle"], result["table"]["exact"]))
    assert off <= 1e-3 and len(result["accuracy"]["tries"]) <= 3, (off, result["accuracy"]["tries"])
    script.write_text(pulled)
    result = reach(script, "--accuracy", 1e-3, "--of", "sideways")
    assert max(map(abs, result["table"]["sideways"])) < 1e-13 and len(result["accuracy"]["tries"]) == 1

# Points between the nodes, whose errors change with their places in their cells: u'' = -1 left of 3/4, -1/k right of it.
between = """mesh bar = interval(1, cells = 4)
part ends = bar.boundary
part hard = bar where x > 0.75
part soft = bar - hard
space V = scalar P1 on bar, zero on ends
find u in V
such that for all v in V
    integral(soft, dot(grad(u), grad(v))) + integral(hard, {k}*dot(grad(u), grad(v))) = integral(bar, v)
report
  table middle = u at [{x}]
"""
with tempfile.TemporaryDirectory() as folder:
    script = pathlib.Path(folder) / "model.hvi"
    for i in range(24):
        x, k = round(0.1 + 0.026 * i, 4), 0.05 + 0.04 * i
        slope = (0.5 / k + 0.75**2 / 2 * (1 - 1 / k)) / (0.75 + 0.25 / k)
        script.write_text(between.format(x=x, k=k))
        for wanted in (1e-3, 3e-3):
            result = reach(script, "--accuracy", wanted, "--of", "middle")
            exact = slope * x - x**2 / 2
            assert abs(result["final"]["middle"] / exact - 1) <= wanted, (x, k, wanted, result["accuracy"]["tries"])

# Where rounding decides, finer meshes have more of it: ladders end, and what is told is why the first run failed.
beam = """mesh beam = rectangle(100000, 1, cells = [8, 4])
part wall = beam.left
part tip = beam.right
tensor B = isotropic(young = 100, poisson = 0.3)
space V = vector P1 on beam, zero on wall
find u in V
such that for all v in V
    integral(beam, B : eps(u) : eps(v)) = integral(tip, dot([0, 1], v))
"""
with tempfile.TemporaryDirectory() as folder:
    script = pathlib.Path(folder) / "beam.hvi"
    script.write_text(beam)
    done = subprocess.run([program, script, "--no-files", "--accuracy", "1e-2"], capture_output=True, text=True, timeout=600)
    assert done.returncode == 3 and "error[E0705]" in done.stderr and "certified: rounding may have changed" in done.stderr, done.stderr
    assert done.stderr.count("accuracy: space ladder, P1: ") == 2, done.stderr
