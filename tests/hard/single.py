"""A factor in single precision where that is too little: runs that are as certain as those in double precision, and say what they did.

usage: single.py HVI_RUN"""
import json
import pathlib
import subprocess
import sys
import tempfile

# A layer that softens almost as fast as the body is stiff: what single precision leaves of the difference is rounding.
SOFT = """
param s = 0.9
mesh body = rectangle(1, 1, cells = [8, 8])
part roof = body.top
part ground = body.bottom
tensor B = isotropic(lambda = 0, mu = 0.5)
superpotential layer(r) with slope
  | r < 0.9   -> -s*r
  | otherwise -> -0.9*s
space V = vector P1 on body, zero on roof, zero.x on ground
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu)) >= integral(ground, dot([0, -1e-8*t*(1 + x^2)], v))
report
  table a = u.y at [0.5, 0], b = norm(u)
"""
# Nearly incompressible: single precision knows nothing of the shear.
HARD = """
param nu = 0.3
mesh body = box(2, 1, 1, cells = [4, 2, 2])
part roof = body.top
part ground = body.bottom
tensor B = isotropic(young = 50, poisson = nu)
superpotential layer(r) with slope 100*max(r, 0)
space V = vector P2 on body, zero on roof
find u in V for t in [0, 1] by 6 steps from u = 0
using factor = single
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(body, B : eps(u') : eps(v)) + integral(ground, layer^0(u.nu; v.nu)) >= integral(body, dot([t, -3*t, 0], v))
report
  table u_y = u.y at [1, 0, 0.5]
"""
AGAIN = "a step was not certified with the factor in single precision: started again in double precision"


class Runs:
    def __init__(self, program, folder):
        self.program, self.folder = program, pathlib.Path(folder)

    def script(self, name, text):
        (self.folder / f"{name}.hvi").write_text(text)

    def __call__(self, name, *options, code=0, command="run"):
        out = self.folder / "out.json"
        out.unlink(missing_ok=True)
        done = subprocess.run([self.program, command, f"{name}.hvi", "--json", out, *options], cwd=self.folder, capture_output=True, text=True)
        assert done.returncode == code, f"{options}: exit code {done.returncode}, {done.stderr}"
        return json.loads(out.read_text()) if out.exists() else done


def told(result):
    return [note["what"] for note in result["notes"]]


def near_the_end_of_a_branch(runs):
    runs.script("soft", SOFT)
    common = ("--full", "--no-files")
    for s, enough in (("0.9", True), ("0.999", True), ("0.9999999", False)):
        double = runs("soft", *common, "-D", f"s={s}")
        single = runs("soft", *common, "-D", f"s={s}", "--factor", "single")
        print(f"s = {s}: {'single' if 'factor' in single['plan'] else 'double'}, {single['final']}, {double['final']}")
        assert single["certificate"]["certified"] and ("factor" in single["plan"]) == enough
        assert (AGAIN in told(single)) != enough
        assert double["uniqueness"] == "guaranteed" and (single["uniqueness"] == "guaranteed") != enough
        if enough:  # no proof with a factor in single precision, and what it says is as good
            assert any("single precision does not prove" in what for what in told(single))
            assert all(abs(single["final"][c] / double["final"][c] - 1) < 1e-9 for c in double["final"])
        else:  # from the first step on, bit for bit
            assert single["table"] == double["table"]
    # A run that began anew is gone on with as it is.
    whole = runs("soft", "--full", "-D", "s=0.9999999", "--factor", "single", "--checkpoint", "2", "-o", "whole")
    again = runs("soft", "--full", "-D", "s=0.9999999", "--factor", "single", "--resume", "-o", "whole")
    assert again["table"] == whole["table"] and AGAIN in told(again)
    # And one whose factor is in single precision by another kind of factor.
    runs("soft", "--full", "--factor", "single", "--checkpoint", "2", "-o", "half")
    other = runs("soft", "--full", "--resume", "-o", "half")
    assert abs(other["final"]["a"] / runs("soft", *common)["final"]["a"] - 1) < 1e-12


def where_it_says_too_little(runs):
    runs.script("hard", HARD)
    for nu, enough in (("0.3", True), ("0.4999999", False)):
        single = runs("hard", "--no-files", "-D", f"nu={nu}")
        double = runs("hard", "--no-files", "-D", f"nu={nu}", "--factor", "double", "--full")
        print(f"nu = {nu}: {'single' if 'factor' in single['plan'] else 'double'}, {single['final']}, {double['final']}")
        assert ("factor" in single["plan"]) == enough and "factor" not in double["plan"]
        assert single["plan"]["factorisations"] == (1 if enough else 2)
        assert any("not in single precision: that is too little for the matrix" in what for what in told(single)) != enough
        assert not any("not in single precision" in what for what in told(double))
        apart = max(abs(a - b) for a, b in zip(single["table"]["u_y"], double["table"]["u_y"]))
        assert apart == 0 if not enough else 0 < apart < 1e-12 * abs(double["final"]["u_y"])
        assert single["plan"]["bytes"] < double["plan"]["bytes"] if enough else True


# Slender, pressed and rubbed, with a law that weakens.
SLENDER = """
import friction
mesh body = box(9, 1, 1, cells = [18, 2, 2])
part roof = body.top
part ground = body.bottom
part right = body.right
tensor B = isotropic(young = 50, poisson = 0.45)
superpotential layer(r) with slope 40*max(r, 0)
superpotential slip(xi) = slip_weakening(xi, static = 0.3, sliding = 0.2, decay = 20)
space V = vector P1 on body, zero on roof
find u in V for t in [0, 1] by 8 steps from u = 0
using tolerance = TOLERANCE
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + 0.1*integral(body, B : eps(u') : eps(v))
  + integral(ground, layer^0(u.nu; v.nu) + slip^0(u.tau; v.tau)) >= integral(body, dot([t, -3*t^2, 0], v)) + integral(right, dot([sin(3*t), 0, t], v))
report
  table a = u.y at [4.5, 0.5, 0.5], b = norm(u), c = u.x at [8, 0, 0.5]
"""


def where_the_state_is_known(runs):
    """Corrections end where the next one would move less than the tolerance: fewer for a usual one than for a strict one, and the same answers."""
    sweeps = {}
    for tolerance in ("1e-10", "1e-13"):
        runs.script("slender", SLENDER.replace("TOLERANCE", tolerance))
        single, double = (runs("slender", "--no-files", "--factor", factor, "--full") for factor in ("single", "double"))
        assert single["plan"]["factor"] == "single" and "factor" not in double["plan"]
        apart = max(abs(a - b) / max(map(abs, double["table"][c])) for c in "abc" for a, b in zip(single["table"][c], double["table"][c]))
        sweeps[tolerance] = single["plan"]["sweeps"]
        print(f"tolerance {tolerance}: {sweeps[tolerance]} triangular solves, {apart:.1e} apart")
        assert apart < float(tolerance)
    assert sweeps["1e-10"] < sweeps["1e-13"]


SKEW = """
mesh body = rectangle(1, 1, cells = [3, 3])
part left = body.left
space S = scalar P1 on body, zero on left
find c in S for t in [0, 1] by 2 steps from c = 0 using factor = single
such that for all d in S
    integral(body, c'*d + dot(grad(c), grad(d)) + dot([3, 1], grad(c))*d) = integral(body, d)
report table a = norm(c)
"""


def where_there_is_none(runs):
    runs.script("skew", SKEW)
    assert any(what == "the factor is not in single precision: the matrix is not symmetric" for what in told(runs("skew", "--no-files")))


def in_words(runs):
    plan = runs("hard", command="plan")
    assert plan["plan"]["factor"] == "single"
    said = subprocess.run([runs.program, "plan", "hard.hvi"], cwd=runs.folder, capture_output=True, text=True)
    assert "1 factorisation in single precision" in said.stdout and "the factor is in single precision" in said.stdout, said.stdout
    wrong = subprocess.run([runs.program, "run", "hard.hvi", "--factor", "half"], cwd=runs.folder, capture_output=True, text=True)
    assert wrong.returncode == 2 and "single" in wrong.stderr + wrong.stdout, wrong.stderr
    before = subprocess.run([runs.program, "--factor", "single", "hard.hvi", "--no-files"], cwd=runs.folder, capture_output=True, text=True)
    assert before.returncode == 0, before.stderr


def main():
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(str(pathlib.Path(sys.argv[1]).resolve()), folder)
        near_the_end_of_a_branch(runs)
        where_it_says_too_little(runs)
        where_the_state_is_known(runs)
        where_there_is_none(runs)
        in_words(runs)


main()
