"""Punches that press into viscoelastic bodies and come back: the force of Lee and Radok while the contact grows, of Ting while it shrinks.

usage: indentation.py HVI_RUN

A rigid punch is driven in and drawn back at one speed. Poisson's ratio is constant, so the body relaxes by one function psi. Reference (analytic, by
correspondence with the elastic body): with P_e(d) the elastic force at the depth d, while the contact grows

    P(t) = int_0^t psi(t - s) dP_e(d(s))

and while it shrinks the same up to t_1(t), when it was last as large: int_{t_1}^t psi(t - s) d'(s) ds = 0; from t_1 = 0 on the punch is free, long before it is
back where it began (E. H. Lee, J. R. M. Radok; T. C. T. Ting; as in V. L. Popov, E. Willert, M. Hess, Method of dimensionality reduction in contact mechanics and
friction: a user's handbook III, Facta Universitatis, Mechanical Engineering 16, 2018). Both hold for the discrete body as well, whose contact sets are those of the elastic one.
So P_e is that of the same mesh in 1,000 depths, memories and steps are what is compared: errors fall with the order of the scheme.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

PEAK, DEPTHS = 0.06, 1000
#        mesh, punch, element, weights, times
CASES = [("graded_rectangle(8, 8, size = 0.8, size_corner = 0.04, axisymmetric = true)", "x^2/20", "P1", [0.6], [0.5]),
         ("graded_rectangle(8, 8, size = 0.8, size_corner = 0.04, axisymmetric = true)", "0.08*x", "P1", [1.0], [0.7]),
         ("graded_rectangle(8, 8, size = 0.8, size_corner = 0.08)", "x^2/20", "P2", [0.5, 0.3], [0.2, 2.0])]


def forces(program, case, scheme, steps, elastic=False):
    mesh, punch, element, weights, times = case
    memory = "" if elastic else " + integral(body, history(C, eps(u)) : eps(v))"
    kernel = "" if elastic else f"kernel C(lag) = prony_relaxation(weights = {weights}, times = {times}) * B"
    end, depth = (1, f"{PEAK}*t") if elastic else (2, f"{PEAK}*min(t, 2 - t)")
    script = f"""import contact
mesh body = {mesh}
part foot = body.top
part head = body.bottom where x < 2
part middle = body.left
tensor B = isotropic(young = 200, poisson = 0.3)
{kernel}
superpotential rigid(r) = unilateral(r)
space V = vector {element} on body, zero on foot, zero.x on middle
find u in V for t in [0, {end}] by {steps} steps from u = 0 using scheme = {scheme}
such that for all v in V
    integral(body, B : eps(u) : eps(v)){memory}
  + integral(head, rigid^0(u.nu + {depth} - {punch}; v.nu)) >= 0
report
  table F = integral(head, rigid.xi)
"""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "a.hvi").write_text(script)
        done = subprocess.run([program, "run", "a.hvi", "--quiet", "--no-files", "--json", "a.json"], cwd=folder, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stdout + done.stderr
        data = json.loads((folder / "a.json").read_text())
    assert data["certificate"]["certified"]
    return np.array(data["table"]["t"]), np.array(data["table"]["F"])


class Relaxation:
    def __init__(self, weights, times):
        self.terms, self.rest = list(zip(weights, times)), 1 - sum(weights)

    def __call__(self, a):
        return self.rest + sum(w * np.exp(-a / tau) for w, tau in self.terms)

    def integral(self, a):
        """Over lags from 0 to a."""
        return self.rest * a + sum(w * tau * (1 - math.exp(-a / tau)) for w, tau in self.terms)


def last_as_large(psi, t):
    """t_1 by bisection; below 0 the punch is free."""
    left = lambda t1: psi.integral(t - t1) - 2 * psi.integral(t - 1)
    if left(0.0) < 0:
        return -1.0
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if left(middle) > 0 else (low, middle)
    return low


def expected(psi, depths, elastic, t):
    end = t if t <= 1 else last_as_large(psi, t)
    if end <= 0:
        return 0.0
    s = np.append(depths[depths < end], end)
    force = np.interp(s, depths, elastic)
    return float(psi(t - (s[1:] + s[:-1]) / 2) @ np.diff(force))


def main():
    good = True
    for case in CASES:
        psi = Relaxation(case[3], case[4])
        depths, elastic = forces(sys.argv[1], case, "bdf2", DEPTHS, elastic=True)
        depths, elastic = np.insert(depths, 0, 0.0), np.insert(elastic, 0, 0.0)
        for scheme, order in (("backward_euler", 0.9), ("bdf2", 1.3)):
            errors = []
            for steps in (20, 160):
                t, found = forces(sys.argv[1], case, scheme, steps)
                wanted = np.array([expected(psi, depths, elastic, at) for at in t])
                errors.append(np.abs(found - wanted).max() / wanted.max())
            seen = math.log(errors[0] / errors[1], 8)
            fine = seen >= order and errors[1] <= (1e-2 if order < 1 else 1e-4)
            good = good and fine
            print(f"{case[1]}, {case[2]}, {scheme}: {errors[0]:.1e}, {errors[1]:.1e}, order {seen:.2f}, at least {order} {'ok' if fine else 'WRONG'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
