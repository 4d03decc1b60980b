"""`hvi-run check --json` against the schema and against numbers computed here by dense algebra.

Usage: check.py HVI_RUN ROOT

Independent: the Gram matrix of eps : eps and the lumped boundary mass of the slab's bottom are assembled
here, triangle by triangle, and their eigenvalues are numpy's. Analytic: m_1 = 2 mu of an isotropic tensor.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import jsonschema
import numpy as np

hvi_run, root = sys.argv[1], pathlib.Path(sys.argv[2])
schema = json.loads((root / "docs/schema/hvi-check-1.schema.json").read_text())


def check(script, *options, code=0):
    run = subprocess.run([hvi_run, "check", script, "--json", "-", *options], capture_output=True, text=True)
    assert run.returncode == code, (script, run.returncode, run.stderr)
    report = json.loads(run.stdout)
    jsonschema.validate(report, schema)
    return report


FALLING = """mesh slab = rectangle(2, 1, cells = [2, 1])
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential layer(r) with slope {slope}
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 0.5] by 2 steps from u = 0
such that for all v in V
    integral(slab, B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(slab, dot([1, -t], v))
report
  table u_y = u.y at [1, 0]
"""


def slab_traces(n):
    """Largest eigenvalues of the lumped mass of the bottom (normal, tangential, full) against the Gram
    matrix, on the slab 2 x 1 in 2n x n cells cut by the lower-left/upper-right diagonal, clamped on top."""
    columns, h = 2 * n + 1, 1.0 / n
    node = lambda i, j: j * columns + i
    gram = np.zeros((2 * columns * (n + 1),) * 2)
    for j in range(n):
        for i in range(2 * n):
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            for cell, gradients in (((a, b, c), [(-1, 0), (1, -1), (0, 1)]), ((a, c, d), [(0, -1), (1, 0), (-1, 1)])):
                strain = np.zeros((3, 6))  # eps_xx, eps_yy, sqrt(2) eps_xy
                for k, (gx, gy) in enumerate(gradients):
                    strain[0, 2 * k], strain[1, 2 * k + 1] = gx / h, gy / h
                    strain[2, 2 * k], strain[2, 2 * k + 1] = gy / h / np.sqrt(2), gx / h / np.sqrt(2)
                dofs = [2 * v + component for v in cell for component in (0, 1)]
                gram[np.ix_(dofs, dofs)] += h * h / 2 * strain.T @ strain
    free = np.arange(2 * columns * n)  # all below the roof
    inverse = np.linalg.inv(gram[np.ix_(free, free)])
    weight = np.full(columns, h)
    weight[[0, -1]] /= 2

    def largest(components):
        at = np.array([2 * i + c for c in components for i in range(columns)])
        root_w = np.sqrt(np.tile(weight, len(components)))
        return np.linalg.eigvalsh(root_w[:, None] * inverse[np.ix_(at, at)] * root_w[None, :])[-1]

    return largest([1]), largest([0]), largest([0, 1])


def close(value, reference, tolerance=1e-6):
    assert abs(value - reference) <= tolerance * abs(reference), (value, reference)


normal, tangential, full = slab_traces(8)
report = check(root / "examples/slab_friction.hvi", "-D", "n=8", "-D", "N=64")
constants = report["constants"]
norms = constants["norm_M2"]
for name, reference in (("normal", normal), ("tangential", tangential), ("full", full), ("script", full)):
    close(norms[name], reference)
shear = 70 / (2 * 1.3)  # of young = 70, poisson = 0.3
close(constants["m_1"], 20), close(constants["m_2"], 2 * shear)
assert constants["m_A"] >= 20 * (1 - 1e-9) and constants["m_B"] >= 2 * shear * (1 - 1e-9)
close(constants["m_nu"], 15), close(constants["m_tau"], 4)
close(constants["margin"], constants["m_B"] - 19 * full)
assert constants["margin"] < 0 < constants["margin_split"] <= constants["m_B"]
assert report["verdict"]["discrete"]["holds"] and report["verdict"]["continuous"]["holds"]
assert "split condition" in report["verdict"]["continuous"]["says"]

# On ever finer meshes: as far again as the refined mesh is from this one.
finer = slab_traces(16)[2]
(row,) = [h for h in report["hypotheses"] if h["bound"].startswith("||M||^2 on ever finer meshes")]
close(row["value"], 2 * finer - full)

# Without friction the normal trace alone counts, as the theorem for it says.
report = check(root / "examples/slab.hvi", "-D", "n=8")
close(report["constants"]["norm_M2"]["script"], normal)
close(report["constants"]["margin_max"], report["constants"]["m_B"] - 15 * normal)

# A slope that jumps down has no m_J: under --strict nothing is run.
strip = root / "examples/delamination.hvi"
report = check(strip, "--strict", code=4)
assert report["constants"]["m_J"] == "inf" and not report["verdict"]["discrete"]["holds"]
run = subprocess.run([hvi_run, "run", strip, "--strict"], capture_output=True, text=True)
assert run.returncode == 4 and "u_y" not in run.stdout.split("verdict")[-1], run
lines = {h["name"]: h["line"] for h in report["hypotheses"] if h["holds"] is False}
assert "superpotential" in strip.read_text() and lines["H(J)"] > 0

# Nor has one that falls like a root, which jumps nowhere, or ever more steeply.
with tempfile.TemporaryDirectory() as folder:
    for slope, words in (("(| r <= 0.1 -> 0 | otherwise -> -sqrt(r - 0.1))", "falls infinitely steeply at 0.1"),
                         ("(| r <= 0 -> 0 | otherwise -> r*log(r))", "falls infinitely steeply at 0,"),
                         ("(| r <= x/10 + t -> 0 | otherwise -> -sqrt(r - x/10 - t))", "falls infinitely steeply at"),
                         ("-r^3", "falls ever more steeply far from 0")):
        script = pathlib.Path(folder) / "root.hvi"
        script.write_text(FALLING.format(slope=slope))
        report = check(script)
        assert report["constants"]["m_J"] == "inf", (slope, report["constants"])
        found = [h for h in report["hypotheses"] if "relaxed monotone" in h["bound"]]
        assert len(found) == 1 and found[0]["holds"] is False and words in found[0]["note"], (slope, found)
        assert not report["verdict"]["discrete"]["holds"]
        run = subprocess.run([hvi_run, "run", script, "--no-files"], capture_output=True, text=True)
        assert run.returncode == 0 and "falls arbitrarily steeply" in run.stdout and "jumps" not in run.stdout, (slope, run)

# Coulomb's bound is no superpotential of its own.
report = check(root / "tests/published/coulomb_shear.hvi")
assert not report["verdict"]["discrete"]["holds"] and not report["verdict"]["continuous"]["holds"]
assert any(h["holds"] is False and "Coulomb" in h["note"] for h in report["hypotheses"])

# B not symmetric: said, and no failure; A not symmetric would be one.
report = check(root / "examples/advection.hvi")
assert any("not symmetric" in h["note"] for h in report["hypotheses"] if h["name"] == "H(B)")
assert all(h["holds"] for h in report["hypotheses"] if h["name"] == "H(B)")

# A singular kernel: its Lipschitz constant is infinite, each step's problem is still judged.
report = check(root / "tests/convergence/weakly_singular.hvi")
assert report["constants"]["lipschitz_q"] == "inf" and report["verdict"]["discrete"]["holds"]

# --strict is both verdicts: here every step has one solution, and the theorem says nothing.
check(root / "tests/convergence/weakly_singular.hvi", "--strict", code=4)
run = subprocess.run([hvi_run, "run", root / "tests/convergence/weakly_singular.hvi", "--strict"], capture_output=True, text=True)
assert run.returncode == 4 and "certified" not in run.stdout, run

BAR = """mesh bar = interval(1, cells = CELLS)
part left = bar.left
part right = bar.right
HALF
superpotential soft(r) with slope | r < 0.01 -> 50*r | r < 1 -> 0.5 - M*(r - 0.01) | otherwise -> 0.5 - 0.99*M
kernel q(t, s) = -9*t^8
space V = scalar P1 on bar, zero on left
find u in V TIME
such that for all v in V
    FORMS + integral(right, soft^0(u; v))
 >= integral(right, 0.1*v)
report
  table end = u at [1]
"""


def bar(forms, *options, m=0.5, cells=4, time="for t in [0, 1] by 10 steps from u = 0", code=0, kernel=""):
    text = BAR.replace("space V", kernel + "space V").replace("FORMS", forms).replace("CELLS", str(cells)).replace("M*", f"{m}*").replace("*M", f"*{m}").replace("TIME", time)
    text = text.replace("HALF", "part half = bar where x < 0.5" if "half" in forms else "")
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(text), file.flush()
        return check(file.name, *options, code=code)


def says(report, name, bound):
    rows = [h for h in report["hypotheses"] if h["name"] == name and h["bound"].startswith(bound)]
    assert len(rows) == 1, (name, bound, report["hypotheses"])
    return rows[0]


A, B = "integral(bar, 0.001*dot(grad(u'), grad(v)))", "integral(bar, dot(grad(u), grad(v)))"
memory = "integral(bar, dot(history(q, grad(u)), grad(v)))"

# Uniqueness is judged at every step: the memory weakens with t, the last step is the worst (analytic: K = 0.001/k + 1 - 9 k t^8
# times the chain, whose end moves by 1 for a unit force).
report = bar(f"{A} + {B} + {memory}")
assert not report["verdict"]["discrete"]["holds"] and report["constants"]["worst_step"] == 10
close(1 - report["constants"]["step_margin"], 0.5 / (0.01 + 1 - 0.9))
assert bar(f"{A} + {B} + {memory}", m=0.1)["verdict"]["discrete"]["holds"]
# A graded grid: the longest step is the worst, 1/k = 1 / (1 - 0.9^2).
report = bar(f"{A} + {B}", time="for t in [0, 1] at graded(10, 2) from u = 0")
assert report["constants"]["worst_step"] == 10
close(1 - report["constants"]["step_margin"], 0.5 / (0.001 / 0.19 + 1))
# BDF2 begins with backward Euler, whose matrix is the softest.
report = bar(f"{A} + {B}", time="for t in [0, 1] by 10 steps from u = 0\n  using scheme = bdf2")
assert report["constants"]["worst_step"] == 1
close(1 - report["constants"]["step_margin"], 0.5 / 1.01)

# A is coercive in V: (H0) is not needed, and the step must be below m_A / (m_J |M|^2 - m_B) = 1/19.
viscous = "integral(bar, dot(grad(u'), grad(v)))"
report = bar(f"{viscous} + {B}", "--strict", m=20, time="for t in [0, 1] by 100 steps from u = 0")
assert report["constants"]["margin"] < 0 and "not needed" in report["verdict"]["continuous"]["says"]
close(says(report, "tau_0", "m_A/k")["value"], 1 / 19)
assert says(report, "theorem", "u in H1")["holds"]
report = bar(f"{viscous} + {B}", "--strict", m=20, time="for t in [0, 1] by 10 steps from u = 0", code=4)
assert report["verdict"]["continuous"]["holds"] and not says(report, "tau_0", "m_A/k")["holds"]

# A is coercive in H only: the parabolic theorem, without H1(0, T; V) and O(h + k).
report = bar(f"integral(bar, u'*v) + {B}", "--strict")
assert report["verdict"]["continuous"]["holds"] and "H1(0, T; V)" in report["verdict"]["continuous"]["says"]
assert says(report, "H(A)", "A is coercive in V")["holds"] is False and says(report, "H(A)", "A is coercive in H")["holds"]
close(says(report, "H(A)", "A is coercive in H")["value"], 1)
assert says(report, "theorem", "u in H1")["holds"] is False and says(report, "theorem", "error")["holds"] is False
# In a part of the body only: neither.
report = bar(f"integral(half, dot(grad(u'), grad(v))) + {B}", "--strict", code=4)
assert not report["verdict"]["continuous"]["holds"]

# So it is where a viscosity is coercive in V and the capacity of a temperature is not, in units in which that is large or small; held or not.
with tempfile.TemporaryDirectory() as warm:
    for capacity, zero in ((1, ", zero on roof"), (1e8, ", zero on roof"), (1e-8, ", zero on roof"), (1e8, "")):
        for size in (1, 1000):
            pathlib.Path(warm, "warm.hvi").write_text(f"""mesh slab = rectangle({2 * size}, {size}, cells = [4, 2])
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential p(r) with slope | r < 0 -> 0 | otherwise -> r
space V = vector P1 on slab, zero on roof
space W = scalar P1 on slab{zero}
find u in V, theta in W for t in [0, 1] by 10 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(slab, B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v)) + integral(ground, p^0(u.nu; v.nu))
  + integral(slab, {capacity}*theta'*eta + {capacity * size**2}*dot(grad(theta), grad(eta)))
 >= integral(slab, dot([0, -10*t], v))
report
  table down = u.y at [{size}, 0]
""")
            report = check(pathlib.Path(warm, "warm.hvi"))
            row = says(report, "H(A)", "A is coercive in V")
            assert row["holds"] is False and "`theta`" in row["note"], (capacity, zero, size, row)
            assert "H1(0, T; V)" in report["verdict"]["continuous"]["says"] or not zero, report["verdict"]

# Heat swells the body, however strongly: it does not act back, in K and in what is left of it on the unknowns of laws.
with tempfile.TemporaryDirectory() as warm:
    pathlib.Path(warm, "warm.hvi").write_text("""mesh slab = rectangle(0.2, 0.1, cells = [8, 4])
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 2e11, poisson = 0.3)
superpotential press(r) = 5e12*max(0, r)^2
superpotential sink(s) = 10*s^2
space V = vector P1 on slab, zero on roof
space W = scalar P1 on slab, zero on roof
find u in V, theta in W for t in [0, 1] by 4 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(slab, B : eps(u) : eps(v) - 1e11*theta*div(v)) + integral(slab, 3.6e6*theta'*eta + 50*dot(grad(theta), grad(eta)))
  + integral(ground, press^0(u.nu; v.nu) + sink^0(theta; eta))
 >= integral(ground, 1e4*t*eta)
report
  table warm = theta at [0.1, 0]
""")
    assert check(pathlib.Path(warm, "warm.hvi"))["verdict"]["discrete"]["holds"]
    run = subprocess.run([hvi_run, pathlib.Path(warm, "warm.hvi"), "--no-files", "--json", "-"], capture_output=True, text=True)
    assert json.loads(run.stdout)["uniqueness"] == "guaranteed", run

# Static problems have the static theorem, which needs (H0).
report = bar(B, "--strict", time="")
assert "static" in report["verdict"]["continuous"]["says"] and report["constants"]["tau_0"] == {}
assert not bar(B, m=2, time="")["verdict"]["continuous"]["holds"]

# One unknown; a convex law on more points than the dense solver takes: margin 1 by definition.
assert bar(f"{viscous} + {B} + {memory}", cells=1)["constants"]["c_E"] == 9
# Each memory has its own E.
other = "integral(bar, 0.25*dot(history(p, grad(u)), grad(v)))"
report = bar(f"{viscous} + {B} + {memory} + {other}", kernel="kernel p(lag) = exp(-lag)\n")
norms = [h["value"] for h in report["hypotheses"] if h["name"] == "H(E)"]
assert len(norms) == 2
close(norms[0], 9), close(norms[1], 0.25)
convex = """mesh slab = rectangle(2, 1, cells = [130, 2])
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential p(r) with slope | r < 0 -> 0 | otherwise -> 100*r
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 1] by 10 steps from u = 0
such that for all v in V
    integral(slab, B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v)) + integral(ground, p^0(u.nu; v.nu))
 >= integral(slab, dot([0, -10*t], v))
report
  table u_y = u.y at [1, 0]
"""
with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
    file.write(convex), file.flush()
    assert check(file.name, "--strict")["constants"]["step_margin"] == 1

# Two laws at one end, the larger constants first or last: of each the largest counts. Growth: the largest |s(r)|/(1 + |r|); descents
# 0.03 and 0.02; the arguments are u and 3 u, so ||M||^2 = 1 + 9 where |u(1)|^2 <= ||u'||^2. Slopes rise by 4 and 2 at most.
TWO = """mesh bar = interval(1, cells = 4)
part left = bar.left
part right = bar.right
superpotential strong(r) with slope | r < 0 -> 4*r | otherwise -> -0.03*r
superpotential weak(r) with slope | r < 0 -> 2*r | otherwise -> -0.02*r
superpotential rub(w) = 0.1*w^2
space V = scalar P1 on bar, zero on left
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(bar, dot(grad(u'), grad(v))) + integral(bar, dot(grad(u), grad(v))) + integral(right, LAWS)
 >= integral(right, 0.1*v)
report
  table end = u at [1]
"""
for laws in ("strong^0(u; v) + weak^0(3*u; 3*v)", "weak^0(u; v) + strong^0(3*u; 3*v)"):
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(TWO.replace("LAWS", laws).replace("superpotential rub(w) = 0.1*w^2\n", "")), file.flush()
        constants = check(file.name)["constants"]
    close(constants["c_J"], 4), close(constants["m_nu"], 0.03), close(constants["m_J"], 0.03)
    close(constants["norm_M2"]["full"], 1), close(constants["norm_M2"]["script"], 10)
    close(constants["margin"], 1 - 0.03 * 10)
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(TWO.replace("LAWS", laws + " + rub^0(u'; v)")), file.flush()
        close(says(check(file.name), "rates", "the slopes of the laws on u are Lipschitz")["value"], 4)

# A body that springs alone hold: one solution where their slopes rise everywhere, whatever the direction and at all times.
SPRUNG = """mesh slab = rectangle(2, 1, cells = [2, 1])
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential spring(w) = POTENTIAL
space V = vector P1 on slab
find u in V for t in [0, 1] by 2 steps from u = 0
such that for all v in V
    integral(slab, B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v)) + integral(ground, spring^0(u; v))
 >= integral(slab, dot([1, -t], v))
report
  table u_y = u.y at [1, 0]
"""
for potential, one in (("5*norm(w)^2", True), ("5*norm(w)^2 + norm(w)", True), ("5*norm(w)^2 - norm(w)", False), ("(5 - 6*t)*norm(w)^2", False),
                       ("max(norm(w) - 1, 0)^2", False)):
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(SPRUNG.replace("POTENTIAL", potential)), file.flush()
        verdict = check(file.name)["verdict"]
    assert verdict["discrete"]["holds"] == one, (potential, verdict)

# States: the rates' constants and those of the laws, analytic; what jumps is not Lipschitz.
AGED = """mesh bar = interval(1, cells = 2)
part left = bar.left
part right = bar.right
superpotential soft(r) with slope SLOPE
state beta on right with rate RATE from beta = 0 in [0, 1]
space V = scalar P1 on bar, zero on left
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(bar, dot(grad(u'), grad(v))) + integral(right, soft^0(u - SHIFT*beta; v))
 >= integral(right, 0.1*v)
report
  table end = u at [1]
"""
FADES = "| r < 0 -> 0 | r < 2 -> (1 - 0.5*beta)*r | otherwise -> 2 - beta"  # by beta: 0.5 r, at most 1; by r: at beta = 0 at most 1


def aged(rate="0", slope=FADES, shift=0.2):
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(AGED.replace("RATE", rate).replace("SLOPE", slope).replace("SHIFT", str(shift))), file.flush()
        return check(file.name)


report = aged("3*u - 2*beta")
close(says(report, "H(state)", "the rate of `beta` is Lipschitz in the state")["value"], 2)
close(says(report, "H(state)", "the rate of `beta` is Lipschitz in its inputs")["value"], 3)
close(says(report, "H(state)", "`soft` is Lipschitz in the states")["value"], 1 + 0.2 * 1)
assert "O. Chau, J. R. Fernandez, M. Shillor, M. Sofonea 2003" in report["verdict"]["continuous"]["says"]
assert "with the initial states held, a step has exactly one solution" in report["verdict"]["discrete"]["says"]
for rate, what, jumps in (("| u > 0.1 -> 5*(u - 0.1) | otherwise -> 0", "its inputs", False),
                          ("| u > 0.1 -> 1 | otherwise -> 0", "its inputs", True),
                          ("| beta < 0.5 -> 1 | otherwise -> 0", "the state", True),
                          ("| u > 5*beta -> beta | otherwise -> 0.2*u", "its inputs", False),
                          ("| u > 5*beta -> beta | otherwise -> 0.3*u", "the state", True)):
    row = says(aged(rate), "H(state)", f"the rate of `beta` is Lipschitz in {what}")
    assert (row["note"] == "it jumps", row["holds"]) == ((True, None) if jumps else (False, True)), (rate, row)
row = says(aged("u^2"), "H(state)", "the rate of `beta` is Lipschitz in its inputs")
assert row["holds"] is None and "on bounded sets only: 2 " in row["note"], row
for slope, note in (("beta^2*r", "on bounded sets only: 2 "), ("| r < beta -> 0 | otherwise -> 1", "it jumps"),
                    ("| beta < 0.5 -> r | otherwise -> 0", "it jumps")):
    row = says(aged(slope=slope, shift=0), "H(state)", "`soft` is Lipschitz in the states")
    assert row["holds"] is None and row["note"].startswith(note), (slope, row)

# Loads that read the solution: a row for each and what it stands before, with the largest of its entries (analytic).
READS = '''mesh plate = rectangle(1, 1, cells = [2, 2])
part left = plate.left
part right = plate.right
space V = scalar P1 on plate, zero on left
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(plate, u'*v + FORM*dot(grad(u), grad(v)))
  = integral(plate, dot(ENTRIES, grad(v)) + 0.5*sin(u)*v) + integral(right, tanh(u)*v)
report
  table end = u at [1, 1]
'''
for form, entries in (("1", "[2*sin(u), 3*cos(u)]"), ("(1 + t)", "[3*cos(u), 2*sin(u)]")):
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(READS.replace("FORM", form).replace("ENTRIES", entries)), file.flush()
        report = check(file.name)
    rows = [(h["line"], h["bound"], h["value"]) for h in report["hypotheses"] if h["name"] == "H(f)" and "is Lipschitz" in h["bound"]]
    assert [(line, what) for line, what, _ in rows] == [(8, "the load of the gradient of u is Lipschitz in what it reads"),
                                                        (8, "the load of u is Lipschitz in what it reads"),
                                                        (8, "the load of u is Lipschitz in what it reads")], rows
    for (_, _, value), constant in zip(rows, (3, 0.5, 1)):
        close(value, constant, 1e-6)
    assert report["verdict"]["discrete"]["says"] == "uniqueness is not guaranteed: a load reads the solution"
    assert "it knows no loads that read the solution" in report["verdict"]["continuous"]["says"]

# Inertia: rigid motions may be free of A, they have mass. Not without it, and not where A leaves out a part of the body.
for mass, part, holds in (("u''", "bar", True), ("u'", "bar", True), ("u''", "half", False)):
    text = f"""mesh bar = interval(1, cells = 4)
part right = bar.right
part half = bar where x < 0.5
superpotential soft(r) with slope | r < 1 -> 0.5*r | otherwise -> 1 - 0.5*min(r, 2)
space V = scalar P1 on bar
find u in V for t in [0, 1] by 10 steps from u = 0
such that for all v in V
    integral(bar, {mass}*v) + integral({part}, dot(grad(u'), grad(v))) + integral(right, soft^0(u; v))
 >= integral(right, 0.1*v)
report
  table end = u at [1]
"""
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(text), file.flush()
        report = check(file.name)
    assert report["verdict"]["continuous"]["holds"] is holds, (mass, part, report["verdict"])
    assert says(report, "H(A)", "A is coercive in V")["holds"] is holds

# Laws on u' may not soften faster than A, on ever finer meshes either: the norm of the tangential traces grows with n.
coarse, finer = (slab_traces(n)[1] for n in (2, 4))
for m in (0.99 / (2 * finer - coarse), 1.01 / (2 * finer - coarse)):
    text = f"""mesh slab = rectangle(2, 1, cells = [4, 2])
part roof = slab.top
part ground = slab.bottom
tensor A = isotropic(young = 1, poisson = 0)
superpotential soft(w) with slope | w < 0.1 -> 5*w | w < 1 -> 0.5 - {m}*(w - 0.1) | otherwise -> 0.5 - 0.9*{m}
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 1] by 10 steps from u = 0
such that for all v in V
    integral(slab, A : eps(u') : eps(v)) + integral(slab, A : eps(u) : eps(v)) + integral(ground, soft^0(u'.x; v.x))
 >= integral(slab, dot([0, -10*t], v))
report
  table end = u.y at [1, 0]
"""
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(text), file.flush()
        report = check(file.name)
    close(report["constants"]["margin_rates"], 1 - m * coarse)
    assert report["verdict"]["continuous"]["holds"] == (m * (2 * finer - coarse) < 1), (m, report["verdict"])

# Pointwise A sees one direction only: it is coercive on each mesh, less on each finer one.
def one_way(n):
    text = f"""mesh body = rectangle(1, 1, cells = [{n}, {n}])
part left = body.left
space V = scalar P1 on body, zero on left
find u in V for t in [0, 1] by 10 steps from u = 0
such that for all v in V
    integral(body, dot([1, 0], grad(u'))*dot([1, 0], grad(v))) + integral(body, dot(grad(u), grad(v)))
  = integral(body, v)
report
  table end = u at [1, 0]
"""
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(text), file.flush()
        return says(check(file.name), "H(A)", "A is coercive in V")


row, finer = one_way(4), one_way(8)
assert not row["holds"] and 0 < finer["value"] < 0.3 * row["value"]
assert f"pointwise m_1 = 0; on this mesh only, {finer['value']:.6g} on the refined" in row["note"], row

# Laws that read another unknown have its initial values: softening 0.1*(1 + 2) against a bar of stiffness 1.
text = """mesh bar = interval(1, cells = 4)
part left = bar.left
part right = bar.right
superpotential soft(r) with slope | r < 0.1 -> 5*r | otherwise -> 0.5 - 0.1*(1 + theta)*min(r - 0.1, 1)
space V = scalar P1 on bar, zero on left
space W = scalar P1 on bar, zero on left
find u in V, theta in W for t in [0, 1] by 10 steps from u = 0, theta = 2*x
such that for all v in V, eta in W
    integral(bar, dot(grad(u'), grad(v))) + integral(bar, dot(grad(u), grad(v)))
  + integral(bar, theta'*eta) + integral(bar, dot(grad(theta), grad(eta))) + integral(right, soft^0(u; v))
 >= integral(right, 0.1*v)
report
  table end = u at [1]
"""
with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
    file.write(text), file.flush()
    close(check(file.name)["constants"]["margin_against_B"], 1 - 0.1 * (1 + 2))

# Laws that read: Coulomb's bound changes with the multiplier by the coefficient of friction.
row = says(check(root / "tests/published/coulomb_patch.hvi"), "H(J)", "`grip` is Lipschitz in the multiplier")
close(row["value"], 1)

# Of forms that change in time the margins are those of the initial time, also where the steps have several matrices (analytic: K = 0.001/k + 1, of the first one).
report = bar("integral(bar, 0.001*dot(grad(u'), grad(v))) + integral(bar, (1 - 0.9*t)*dot(grad(u), grad(v)))", time="for t in [0, 1] by 10 steps from u = 0\n  using scheme = bdf2")
row = says(report, "step", "1 - lambda_max")
assert row["note"].startswith("K of step 1") and row["note"].endswith("with the forms of the initial time and states"), row
close(1 - row["value"], 0.5 / (0.01 + 1))

# Forms that read states have the rule of the steps: a coefficient is that of the middles of cells, the least one that of the first (analytic).
text = """mesh bar = interval(1, cells = 4)
part left = bar.left
state d on bar with rate max(0, norm(grad(u)) - 100) from d = 0.2
space V = scalar P1 on bar, zero on left
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(bar, 0.1*dot(grad(u'), grad(v))) + integral(bar, (1 - d)*(1 + x^3)*dot(grad(u), grad(v)))
  = integral(bar, v)
report
  table end = u at [1]
"""
with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
    file.write(text), file.flush()
    close(says(check(file.name), "H(B)", "B is coercive: m_B")["value"], 0.8 * (1 + 0.125 ** 3), 1e-9)

# A verdict of the continuous problem says to whom its theorem is due.
for report, authors in ((bar(B, time=""), "W. Han, M. Sofonea 2019"), (bar(f"{viscous} + {B}"), "S. Migorski, S. Zeng 2019"),
                        (bar(f"integral(bar, u''*v) + {viscous} + {B}"), "A. Kulig 2013"),
                        (bar(B), "W. Han, M. Sofonea 2019")):
    for text in (report["verdict"]["continuous"]["says"], says(report, "theorem", "one solution")["note"]):
        assert authors in text, text
