"""Friction on the rate with steps from a millionth to a million times the relaxation time: slip, stick, slip back.

usage: relaxation.py HVI_RUN

Reference: analytic, the closed form of every step. A column with rollers rubs on its end: the state is affine, u = [w x, 0], its modulus is 3:
3 (tau w' + w - a h) + xi = F(t), xi in g Sign(w'), h the memory of w with relaxation time tau. Each step gives w' as F less what the past
makes, shrunk by g, over a positive number. F comes and goes, so that the end slips both ways and sticks between. Displacements must agree to
1e-12 of the largest for every step length, with backward Euler (with and without memory) and bdf2; where the closed form
sticks, nothing may move by more than rounding of the largest displacement.
"""
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

STEPS, BOUND, WITHIN, ROUNDING = 60, 0.15, 1e-12, 1e-13
SCRIPT = """
mesh block = rectangle(2, 1, cells = [4, 2])
part left  = block.left
part right = block.right
part low   = block.bottom + block.top
tensor C   = isotropic(lambda = 1, mu = 1)
kernel q(lag) = -{a}/{tau}*exp(-lag/{tau})
superpotential slip(r) = {bound} * abs(r)
space V = vector P1 on block, zero.x on left, zero.y on low
find u in V for t in [0, 6] by {steps} steps from u = 0 using scheme = {method}
such that for all v in V
    integral(block, {tau} * (C : eps(u')) : eps(v)) + integral(block, C : eps(u) : eps(v))
  + integral(block, C : eps(history(q, u)) : eps(v))
  + integral(right, slip^0(u'.x; v.x))
 >= integral(right, dot([{size}*sin(2*t), 0], v))
report
  table w = u.x/2 at [2, 1] to "w.csv"
"""


def shrunk(f):
    return math.copysign(max(0.0, abs(f) - BOUND), f)


def closed(tau, a, method, size):
    """w after every step, and whether it stuck."""
    k = 6 / STEPS
    w = d = h = 0.0
    out, rests = [], []
    fade = math.exp(-k / tau)
    keeps = -math.expm1(-k / tau)
    for n in range(1, STEPS + 1):
        s, carry = (1.5 / k, 0.5 / k) if method == "bdf2" and n > 1 else (1 / k, 0.0)
        f = size * math.sin(2 * n * k)
        present = 1 - a * keeps  # what 3 (w - a h) has of w_n
        past = 3 * (present * (w + carry * d / s) - a * fade * h)
        rate = shrunk(f - past) / (3 * (tau + present / s))
        d = (rate + carry * d) / s
        w += d
        h = fade * h + keeps * w
        out.append(w)
        rests.append(rate == 0.0)
    return np.array(out), np.array(rests)


def main():
    program, good, stuck = str(pathlib.Path(sys.argv[1]).resolve()), True, 0
    for method, a in (("backward_euler", 0.0), ("backward_euler", 0.4), ("bdf2", 0.0)):
        worst = moved = 0.0
        for decade in range(-6, 7):
            tau = 6 / STEPS * 10.0**-decade
            expected, rests = closed(tau, a, method, 0.6)
            with tempfile.TemporaryDirectory() as folder:
                script = SCRIPT.format(a=a, tau=repr(tau), bound=BOUND, steps=STEPS, method=method, size=0.6)
                (pathlib.Path(folder) / "column.hvi").write_text(script)
                done = subprocess.run([program, "run", "column.hvi", "--quiet", "-o", "."], cwd=folder, capture_output=True,
                                      text=True)
                if done.returncode:
                    sys.exit(f"k = 1e{decade} tau: {done.stderr}")
                w = np.genfromtxt(pathlib.Path(folder) / "w.csv", delimiter=",", names=True)["w"][-STEPS:]
            size = np.abs(expected).max()
            worst = max(worst, np.abs(w - expected).max() / size)
            if method != "bdf2":  # whose last rate before a stick goes on to move it
                moved = max(moved, np.abs(np.diff(w)[rests[1:]]).max(initial=0.0) / size)
            stuck += rests.sum()
        held = worst <= WITHIN and moved <= ROUNDING
        print(f"{method}{', memory' if a else ''}: displacements to {worst:.1e}, moves while it sticks {moved:.1e}"
              f" {'ok' if held else 'WRONG'}")
        good = good and held
    print(f"steps that stick: {stuck}")
    return 0 if good and stuck > 100 else 1


if __name__ == "__main__":
    sys.exit(main())
