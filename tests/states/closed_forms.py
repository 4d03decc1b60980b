#!/usr/bin/env python3
"""States against closed forms and an integrator of its own: orders, stiff steps, bonds that break, turned scenes, damage of bodies.

usage: closed_forms.py HVI_RUN
"""
import functools
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

HVI = str(pathlib.Path(sys.argv[1]).resolve())
failed = []


def check(what, good, shown=""):
    print(f"{'ok    ' if good else 'FAILED'} {what} {shown}")
    if not good:
        failed.append(what)


def run(folder, script, *options, name="scene"):
    path = pathlib.Path(folder) / f"{name}.hvi"
    path.write_text(script)
    out = pathlib.Path(folder) / f"{name}.json"
    out.unlink(missing_ok=True)
    done = subprocess.run([HVI, "run", path.name, "--quiet", "--json", out.name, "-o", "out", *options], cwd=folder,
                          capture_output=True, text=True, timeout=300)
    return done, json.loads(out.read_text()) if out.exists() else None


def orders(errors):
    return [math.log2(a / b) for a, b in zip(errors, errors[1:])]


# The bottom of a block is held open by d: beta' = -max(0, c beta d^2 - e) from 1 gives
# beta = e/(c d^2) + (1 - e/(c d^2)) exp(-c d^2 t).
HELD = """
param N = 20
param method = backward_euler
mesh body = rectangle(1, 1, cells = [2, 2])
part roof = body.top
part glue = body.bottom
tensor B = isotropic(lambda = 10, mu = 10)
superpotential bond(r) = 0.5*beta^2*10*r^2
state beta on glue with rate -max(0, 5*beta*pos(u.nu)^2 - 0.1) from beta = 1 in [0, 1]
space V = vector P1 on body, zero on roof, zero.y on glue
find u in V with u.y = -0.5 on glue for t in [0, 2] by N steps from u = [0, -0.5*(1 - y)]
  using scheme = method
such that for all v in V
    integral(body, B : eps(u) : eps(v))
  + integral(glue, bond^0(u.nu; v.nu))
 >= 0
report
  table b = beta at [0.5, 0], whole = integral(glue, beta), xi = bond.xi at [0.5, 0]
"""


def held_bond(folder):
    a = 5 * 0.25
    exact = 0.1 / a + (1 - 0.1 / a) * math.exp(-a * 2)
    for method, order in (("backward_euler", 1), ("bdf2", 2)):
        errors = []
        for n in (40, 80, 160, 320):
            done, out = run(folder, HELD, "-D", f"N={n}", "-D", f"method={method}")
            assert done.returncode == 0, done.stderr
            errors.append(abs(out["final"]["b"] - exact))
        found = orders(errors)
        check(f"bond under held opening, {method}: order {order}", all(abs(o - order) < 0.1 for o in found[1:]),
              f"errors {errors[-1]:.1e}, orders {[round(o, 2) for o in found]}")
    done, out = run(folder, HELD, "-D", "N=10")
    k, b = 0.2, 1.0
    for _ in range(10):
        b = (b + k * 0.1) / (1 + k * a)
    check("bond: the formula of backward Euler to rounding", abs(out["final"]["b"] - b) < 1e-15 and
          abs(out["final"]["whole"] - b) < 1e-15 and abs(out["final"]["xi"] - b * b * 10 * 0.5) < 1e-14,
          f"{out['final']['b'] - b:.1e}")
    check("the certificate has the states' error", out["certificate"]["states"] <= 1e-14)


# A block pressed on its ground slides at the speed 1; springs in series make the pressure p = c (0.01 - worn gap),
# c = 1/(1/1000 + 1/100): wear' = 0.02 p.
WEAR = """
param N = 10
param method = backward_euler
mesh body = {mesh}
part roof = body.top
part ground = body.bottom
tensor B = isotropic(lambda = 0, mu = 50)
superpotential press(r) = 0.5*1000*pos(r)^2
state wear on ground with rate 0.02*abs(press.xi)*norm(u'.tau) from wear = 0
state path on ground with rate norm(u'.tau) from path = 0
space V = vector P1 on body, zero on roof, {zero}
find u in V with {held} for t in [0, 1] by N steps from u = {held0}
  using scheme = method
such that for all v in V
    integral(body, B : eps(u) : eps(v))
  + integral(ground, press^0(u.nu{worn}; v.nu))
 >= 0
report
  table w = wear at {at}, s = path at {at}, p = press.xi at {at}
"""
SLIDING = {2: dict(mesh="rectangle(1, 1, cells = [2, 2])", zero="zero.x on ground",
                   held="u = [t, -0.01] on roof, u.x = t on ground", held0="[0, -0.01*y]", at="[0.5, 0]"),
           3: dict(mesh="box(1, 1, 1, cells = [1, 2, 1])", zero="zero.x on ground, zero.z on ground",
                   held="u = [0.6*t, -0.01, 0.8*t] on roof, u.x = 0.6*t on ground, u.z = 0.8*t on ground",
                   held0="[0, -0.01*y, 0]", at="[0, 0, 0]")}


def wear(folder):
    c = 1 / (1 / 1000 + 1 / 100)
    for dim, made in SLIDING.items():
        done, out = run(folder, WEAR.format(worn="", **made))
        assert done.returncode == 0, done.stderr
        last, want = [out["final"][k] for k in "wsp"], [0.02 * 0.01 * c, 1, 0.01 * c]
        check(f"wear under a held pressure, {dim}D", all(abs(a - b) < 1e-13 for a, b in zip(last, want)),
              f"{[f'{a - b:.0e}' for a, b in zip(last, want)]}")
        # The worn gap relieves the pressure; the law's argument moves, or the law itself.
        for where in (" - wear", ""):
            script = WEAR.format(worn=where, **made)
            if not where:
                script = script.replace("pos(r)", "pos(r - wear)")
            done, out = run(folder, script)
            w = 0.0
            for _ in range(10):
                w = (w + 0.1 * 0.02 * c * 0.01) / (1 + 0.1 * 0.02 * c)
            check(f"wear that relieves the pressure, {dim}D", done.returncode == 0 and abs(out["final"]["w"] - w) < 1e-14 and
                  abs(out["final"]["p"] - c * (0.01 - w)) < 1e-12, done.stderr[:300] or f"{out['final']['w'] - w:.0e}")
    exact = 0.01 * (1 - math.exp(-0.02 * c))
    for method, order in (("backward_euler", 1), ("bdf2", 2)):
        errors = []
        for n in (20, 40, 80, 160):
            done, out = run(folder, WEAR.format(worn=" - wear", **SLIDING[2]), "-D", f"N={n}", "-D", f"method={method}")
            errors.append(abs(out["final"]["w"] - exact))
        found = orders(errors)
        check(f"wear that relieves the pressure, {method}: order {order}", all(abs(o - order) < 0.1 for o in found[1:]),
              f"errors {errors[-1]:.1e}, orders {[round(o, 2) for o in found]}")


# A slider on a spring with rate-and-state friction: velocity steps.
FAULT = """
import states
param N = 400
param method = backward_euler
param stiff = 4
param last = 2
param L = 0.01
mesh body = rectangle(1, 1, cells = [1, 1])
part roof = body.top
part fault = body.bottom
tensor B = isotropic(lambda = 0, mu = stiff)
superpotential slip(xi) with slope {slope}
{state}
space V = vector P1 on body, zero on roof, zero.y on fault
find u in V with u.x = (| t < 1 -> t | otherwise -> 1 + 3*(t - 1)) on roof for t in [0, last] by N steps from u = 0
  using scheme = method
such that for all v in V
    integral(body, B : eps(u) : eps(v))
  + integral(fault, slip^0(u'.tau; v.tau))
 >= 0
report
  table a = theta at [0, 0], x = u.x at [0, 0], tau = integral(fault, slip.xi.x)
"""
LAWS = {"ageing": "state theta on fault with rate 1 - norm(u'.tau)*theta/L from theta = L",
        "slip": "state theta on fault with rate -norm(u'.tau)*theta/L*log(max(norm(u'.tau)*theta/L, 1e-200)) from theta = L"}
SLOPES = {"threshold": "0.6 + 0.02*log(1 + norm(xi)/0.001) + 0.03*log(1 + 0.1*theta/L)",
          "regularised": "regularised(norm(xi), theta, 0.6, 0.02, 0.03, 0.001, L)"}


L = 0.01  # the length over which the state forgets


def speed_at(slope, tau, theta):
    """The slip rate that bears the traction tau."""
    if slope == "regularised":
        return 2 * 0.001 * math.sinh(tau / 0.02) * math.exp(-(0.6 + 0.03 * math.log(0.001 * theta / 0.01)) / 0.02)
    level = (tau - 0.6 - 0.03 * math.log(1 + 0.1 * theta / 0.01)) / 0.02
    return 0.001 * (math.exp(level) - 1) if level > 0 else 0.0


def fault_reference(law, slope, stiff, last):
    """x and theta at the last time: the slider's speed follows from the balance at every moment; classical Runge-Kutta, with the start
    of sliding and the jump of the pull at ends of steps."""
    y, _ = slide(law, slope, stiff, (0.0, L), 0.0, 1.0, 1.0, 200000)
    y, peak = slide(law, slope, stiff, y, 1.0, last, 3.0, 20000)
    return *y, peak


@functools.cache
def slide(law, slope, stiff, y, start, end, speed, steps):
    """x and theta at the end, and the largest pull, where the pull's end moves from `start` on with that speed."""
    h, peak = (end - start) / steps, 0.0

    def pull(t):
        return start + speed * (t - start)

    def rate(t, y):
        x, theta = y
        v = speed_at(slope, stiff * (pull(t) - x), theta)
        q = v * theta / L
        return v, (1 - q if law == "ageing" else -q * math.log(max(q, 1e-200)))

    for j in range(steps):
        t = start + j * h
        k1 = rate(t, y)
        k2 = rate(t + h / 2, [a + h / 2 * b for a, b in zip(y, k1)])
        k3 = rate(t + h / 2, [a + h / 2 * b for a, b in zip(y, k2)])
        k4 = rate(t + h, [a + h * b for a, b in zip(y, k3)])
        y = [a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(y, k1, k2, k3, k4)]
        peak = max(peak, stiff * (pull(t + h) - y[0]))
    return tuple(y), peak


def after_the_jump(steps):
    """Times to 1.02: a tenth of the steps before the jump of the pull at 1, the others after it, short ones first."""
    before, after = steps // 10, steps - steps // 10
    return [j / before for j in range(before + 1)] + [1 + 0.02 * (j / after) ** 1.5 for j in range(1, after + 1)]


def jump_of_the_pull(folder):
    """Peak force, slip and state after the velocity has trebled, within 1e-4 in 4,000 steps."""
    for law, slope in ((law, slope) for law in LAWS for slope in SLOPES):
        truth = fault_reference(law, slope, 4, 1.02)
        for method, order in (("backward_euler", 1), ("bdf2", 2)):
            errors = []
            for n in (2000, 4000):
                times = ", ".join(repr(t) for t in after_the_jump(n))
                script = FAULT.format(state=LAWS[law], slope=SLOPES[slope]).replace("by N steps", f"at [{times}]")
                done, _ = run(folder, script + ' to "jump.csv"', "-D", "last=1.02", "-D", f"method={method}")
                assert done.returncode == 0, done.stderr
                rows = np.genfromtxt(pathlib.Path(folder) / "out" / "jump.csv", delimiter=",", names=True)
                peak = rows["tau"][rows["t"] > 1].max()
                errors.append([abs(g / t - 1) for g, t in zip((rows["x"][-1], rows["a"][-1], peak), truth)])
            found = [orders(column)[0] for column in zip(*errors)][:2]
            check(f"jump of the pull, {law} law, {slope}, {method}", max(errors[-1]) <= 1e-4 and all(abs(o - order) < 0.1 for o in found),
                  f"slip, state, peak force {[f'{e:.1e}' for e in errors[-1]]}, orders {[round(o, 2) for o in found]}")


def fault(folder):
    for law, slope in ((law, slope) for law in LAWS for slope in SLOPES):
        x, theta, _ = fault_reference(law, slope, 4, 1.005)
        script = FAULT.format(state=LAWS[law], slope=SLOPES[slope])
        for method, order in (("backward_euler", 1), ("bdf2", 2)):
            errors = []
            for n in (804, 1608, 3216) if slope == "threshold" else (3216, 6432, 12864):
                done, out = run(folder, script, "-D", "last=1.005", "-D", f"N={n}", "-D", f"method={method}")
                assert done.returncode == 0, done.stderr
                errors.append(abs(out["final"]["x"] - x) / x + abs(out["final"]["a"] - theta) / theta)
            found = orders(errors)
            # Its start of sliding at the threshold costs BDF2 its order, not its accuracy.
            good = errors[-1] < (2e-2 if slope == "threshold" else {1: 3e-2, 2: 2e-3}[order]) and (
                abs(found[-1] - order) < 0.15 or slope == "threshold" and order == 2)
            check(f"velocity step, {law} law, {slope}, {method}", good,
                  f"errors {[f'{e:.1e}' for e in errors]}, orders {[round(o, 2) for o in found]}")
        # The state settles within a step: steps of ten and a hundred times its own time.
        for n in (2, 4, 20):
            done, out = run(folder, script, "-D", f"N={n}")
            good = done.returncode == 0 and abs(out["final"]["a"] - 0.01 / 3) < 0.01 / 3 * (1e-2 if n == 20 else 0.5)
            check(f"{law} law, {slope}, in {n} steps", good, done.stderr[:200] if done.returncode else f"{out['final']['a']:.6f}")


# A bond that breaks when the pull passes what it bears: all in one step, or over many.
BREAKS = """
param N = 10
param fast = 1000
mesh body = rectangle(1, 1, cells = [4, 4])
part roof = body.top
part glue = body.bottom
tensor B = isotropic(lambda = 10, mu = 10)
superpotential bond(r) = 0.5*beta^2*40*r^2
state beta on glue with rate -fast*max(0, 40*pos(u.nu)^2 - 0.3) from beta = 1 in [0, 1]
space V = vector P1 on body, zero on roof
find u in V for t in [0, 1] by N steps from u = 0
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(glue, bond^0(u.nu; v.nu))
 >= integral(glue, dot([0, -24*t], v))
report
  table low = integral(glue, beta), b = beta at [0.5, 0], open = -integral(glue, u.y)
"""


def breaks(folder):
    done, out = run(folder, BREAKS.replace("from beta = 1", "from beta = 0"))
    free = out["final"]["open"]  # of the block alone
    for fast in (1, 1000, 1e6):
        for n in (1, 2, 10, 1000):
            done, out = run(folder, BREAKS, "-D", f"N={n}", "-D", f"fast={fast}")
            good = done.returncode == 0
            if good:
                good = out["final"]["low"] == 0 and abs(out["final"]["open"] - free) < 1e-12
            check(f"bond that breaks, rate {fast:g}, {n} steps", good, done.stderr[:300] if done.returncode else
                  f"bond {out['final']['low']:.3e}, open {out['final']['open']:.4f}")


def turned(folder):
    """Turned by an angle: the same bond and wear."""
    out = []
    for angle in (0.0, 0.7):
        c, s = math.cos(angle), math.sin(angle)
        mesh = pathlib.Path(folder) / "turned.msh"
        n = 4
        nodes = [(i / n, j / n) for j in range(n + 1) for i in range(n + 1)]
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "3", '1 1 "roof"', '1 2 "glue"', '2 3 "all"',
                 "$EndPhysicalNames", "$Nodes", str(len(nodes))]
        lines += [f"{k + 1} {c * x - s * y!r} {s * x + c * y!r} 0" for k, (x, y) in enumerate(nodes)]
        at = lambda i, j: j * (n + 1) + i + 1
        elements = [f"1 2 1 1 {at(i, n)} {at(i + 1, n)}" for i in range(n)] + [f"1 2 2 2 {at(i, 0)} {at(i + 1, 0)}" for i in range(n)]
        for j in range(n):
            for i in range(n):
                elements += [f"2 2 3 3 {at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)}", f"2 2 3 3 {at(i, j)} {at(i + 1, j + 1)} {at(i, j + 1)}"]
        lines += ["$EndNodes", "$Elements", str(len(elements))] + [f"{k + 1} {e}" for k, e in enumerate(elements)] + ["$EndElements"]
        mesh.write_text("\n".join(lines) + "\n")
        force = [c * 4 + s * 9, s * 4 - c * 9]
        script = f"""
mesh body = gmsh("turned.msh")
part roof = body.group("roof")
part glue = body.group("glue")
tensor B = isotropic(lambda = 10, mu = 10)
tensor A = isotropic(lambda = 1, mu = 1)
superpotential bond(r) = 0.5*beta^2*40*r^2
superpotential drag(xi) = (1 + path)*norm(xi)
state beta on glue with rate -max(0, 20*(beta*pos(u.nu)^2 - 0.01*path)) from beta = 1 in [0, 1]
state path on glue with rate norm(u'.tau) from path = 0.1
space V = vector P2 on body, zero on roof
find u in V for t in [0, 1] by 12 steps from u = 0
such that for all v in V
    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v))
  + integral(glue, bond^0(u.nu; v.nu) + drag^0(u'.tau; v.tau))
 >= integral(glue, t*dot([{force[0]!r}, {force[1]!r}], v))
report
  table b = integral(glue, beta), p = integral(glue, path), size = norm(u)
"""
        done, result = run(folder, script)
        assert done.returncode == 0, done.stderr
        out.append(result["final"])
    check("turned", all(abs(out[0][k] - out[1][k]) < 1e-9 * abs(out[0][k]) for k in out[0]) and out[0]["b"] < 0.999, str(out[0]))


# A bar is pulled: eps_xx = t/10, and d' = 5 max(0, eps_xx - 0.02) gives d = (t - 0.2)^2/4 from t = 0.2 on.
PULLED = """
param N = 20
param method = backward_euler
mesh bar = rectangle(1, 1, cells = [2, 2])
part wall = bar.left
part base = bar.bottom
part grip = bar.right
tensor B = isotropic(young = 100, poisson = 0)
state d on bar with rate 5*max(0, norm(eps(u)) - 0.02) from d = 0 in [0, 0.9]
space V = vector P1 on bar, zero.x on wall, zero.y on base, zero.x on grip
find u in V with u.x = 0.1*t on grip for t in [0, 1] by N steps from u = 0
  using scheme = method
such that for all v in V
    integral(bar, (1 - d)*B : eps(u) : eps(v))
 = 0
report
  table d = d at [0.4, 0.6], whole = integral(bar, d), s = sigma.xx at [0.4, 0.6]
"""


def ladder(folder, script, *options):
    """What runs with ever more steps say."""
    for steps in (40, 80, 160, 320):
        done, result = run(folder, script, "-D", f"N={steps}", *options)
        assert done.returncode == 0, done.stderr
        yield result


def check_order(folder, name, script, truth, close):
    """Of the damage at the end, with both schemes."""
    for method, order in (("backward_euler", 1), ("bdf2", 2)):
        errors = [abs(result["final"]["d"] - truth) for result in ladder(folder, script, "-D", f"method={method}")]
        check(f"{name}, order of {method}", abs(orders(errors)[-1] - order) < 0.1 and errors[-1] < close, str(errors))


def pulled(folder):
    """Damage by strain: exact in the step, its orders, and what is dissipated: int E/2 eps^2 d' dt."""
    n = 20
    d = sum(5 / n * max(0, 0.1 * j / n - 0.02) for j in range(1, n + 1))
    exact = {"d": d, "whole": d, "s": (1 - d) * 10}
    box = (PULLED.replace("rectangle(1, 1, cells = [2, 2])", "box(1, 1, 1, cells = [1, 2, 1])").replace("vector P1", "vector P2")
           .replace("zero.y on base", "zero on base").replace("[0.4, 0.6]", "[0.4, 0.6, 0.3]"))
    box = box.replace("zero on base", "zero.y on base, zero.z on back").replace("tensor", "part back = bar.back\ntensor")
    for name, script in (("P1", PULLED), ("P2", PULLED.replace("vector P1", "vector P2")), ("P2 in space", box)):
        done, result = run(folder, script)
        good = done.returncode == 0 and all(abs(result["final"][k] - exact[k]) < 1e-11 * exact[k] for k in exact)
        check(f"pulled, {name}, backward Euler as written out", good, str(result["final"]) if result else done.stderr)
    check_order(folder, "pulled", PULLED, 0.16, 4e-3)
    truth = 50 * 0.1 ** 2 * 0.5 * ((1 - 0.2 ** 4) / 4 - 0.2 * (1 - 0.2 ** 3) / 3)
    tables = [result["monitors"] for result in ladder(folder, PULLED, "--monitors")]
    errors = [table["lost"][-1] - truth for table in tables]
    check("pulled, balance of work", max(table["balance_error"] for table in tables) < 1e-11)
    check("pulled, dissipation", abs(2 * errors[-1] - errors[-2]) < 1e-4 * truth and abs(orders(errors)[-1] - 1) < 0.1,
          f"{errors} of {truth}")


def moving_bar():
    """The bar with a mass, pulled by a force."""
    return (PULLED.replace("zero.x on grip", "zero.x on wall").replace("with u.x = 0.1*t on grip ", "")
              .replace("zero.x on wall, zero.y on base, zero.x on wall", "zero.x on wall, zero.y on base")
              .replace("such that for all v in V\n", "such that for all v in V\n    integral(bar, dot(u'', v)) +\n")
              .replace(" = 0\nreport", " = integral(grip, dot([4*t, 0], v))\nreport").replace("0.9]", "0.99]"))


def dropped(folder):
    """A bar with mass and damage: the schemes of second order agree ever better."""
    ends = {method: [result["final"]["d"] for result in ladder(folder, moving_bar(), "-D", f"method={method}")]
            for method in ("bdf2", "newmark", "hht", "midpoint")}
    for method in ("newmark", "hht", "midpoint"):
        apart = [abs(a - b) for a, b in zip(ends["bdf2"], ends[method])]
        check(f"dropped, bdf2 and {method} agree", apart[-1] < 1e-3 * ends["bdf2"][-1] and orders(apart)[-1] > 1.5,
              f"{ends[method]}, orders {[round(o, 2) for o in orders(apart)]}")


# Creep damage under a constant load (stdlib/states.hvi): (1 - d)^(r+1) = 1 - (r + 1) (s/S)^r t.
CREEP = """
import states
param N = 20
param method = backward_euler
mesh bar = rectangle(1, 1, cells = [2, 1])
part wall = bar.left
part base = bar.bottom
part grip = bar.right
tensor B = isotropic(young = 100, poisson = 0)
state d on bar with rate creep_damage(d, sigma.xx, 1.5, 3) from d = 0 in [0, 0.99]
space V = vector P2 on bar, zero.x on wall, zero.y on base
find u in V for t in [0, 0.5] by N steps from u = [0.01*x, 0]
  using scheme = method
such that for all v in V
    integral(bar, (1 - d)*B : eps(u) : eps(v))
 = integral(grip, dot([1, 0], v))
report
  table d = d at [0.4, 0.6], end = u.x at [1, 0.5]
"""


def creep(folder):
    check_order(folder, "creep", CREEP, 1 - (1 - 4 * 1.5 ** -3 * 0.5) ** 0.25, 4e-4)
    for result in ladder(folder, CREEP):
        final = result["final"]
        check("creep, strain", abs(final["end"] * 100 * (1 - final["d"]) - 1) < 1e-9, str(final))


def released(folder):
    """What states take from stored energies, and with it the balance of work: closed to rounding."""
    done, out = run(folder, HELD, "--monitors")
    assert done.returncode == 0, done.stderr
    told = {name: column[-1] for name, column in out["monitors"].items() if isinstance(column, list)}
    exact = 5 * 0.25 * (1 - out["final"]["b"] ** 2)
    check("bond: what it releases", abs(told["released_bond"] - exact) < 1e-13,
          f"{told['released_bond']:.6g}, by hand {exact:.6g}")
    n, c = 10, 1 / (1 / 1000 + 1 / 100)
    for where in (" - wear", ""):
        script = WEAR.format(worn=where, **SLIDING[2])
        if not where:
            script = script.replace("pos(r)", "pos(r - wear)")
        done, out = run(folder, script, "--monitors")
        assert done.returncode == 0, done.stderr
        told = {name: column[-1] for name, column in out["monitors"].items() if isinstance(column, list)}
        w = opened = taken = scheme = 0.0  # opened: u.nu
        for step in range(1, n + 1):
            new = (w + 0.1 * 0.02 * c * 0.01) / (1 + 0.1 * 0.02 * c)
            moved = c * (0.01 - new) / 1000 + new  # p = 1000 (u.nu - wear)
            potential = lambda u, worn: 500 * max(0.0, u - worn) ** 2
            taken += potential(opened, w) - potential(opened, new)
            # The rest: of elastic energy, 50 eps^2, and of the potential what convexity leaves.
            slope = 1000 * max(0.0, moved - new)
            scheme += 50 * (moved - opened) ** 2 + slope * (moved - opened) - potential(moved, new) + potential(opened, new)
            w, opened = new, moved
        name = "in the argument" if where else "in the law"
        check(f"wear {name}: what it releases", abs(told["released_press"] - taken) < 1e-13, f"{told['released_press']} by hand {taken}")
        check(f"wear {name}: balance of work", abs(told["lost"] - taken - scheme) < 1e-13, f"{told['lost']} by hand {taken + scheme}")
    done, out = run(folder, PULLED, "--monitors")
    assert done.returncode == 0, done.stderr
    told = {name: column[-1] for name, column in out["monitors"].items() if isinstance(column, list)}
    strains, damage, taken, scheme = [0.1 * j / 20 for j in range(21)], 0.0, 0.0, 0.0
    for before, now in zip(strains, strains[1:]):
        new = damage + 5 / 20 * max(0, now - 0.02)
        taken += 50 * before ** 2 * (new - damage)
        scheme += 50 * (1 - new) * (now - before) ** 2
        damage = new
    check("damage: what it releases", abs(told["released_forms"] - taken) < 1e-13, f"{told['released_forms']} by hand {taken}")
    check("damage: balance of work", abs(told["lost"] - taken - scheme) < 1e-13, f"{told['lost']} by hand {taken + scheme}")
    for method in ("newmark", "midpoint"):
        done, out = run(folder, moving_bar(), "-D", f"method={method}", "-D", "N=60", "--monitors")
        assert done.returncode == 0, done.stderr
        told = {name: column[-1] for name, column in out["monitors"].items() if isinstance(column, list)}
        check(f"damage in motion, {method}: lost is what is released", told["released_forms"] > 1e-3 * told["work"] and
              abs(told["lost"] - told["released_forms"]) < 1e-11 * told["work"],
              f"{told['released_forms']:.3e} of {told['work']:.3e}, left {told['lost'] - told['released_forms']:.1e}")


# A block whose halves are damaged by states of their own, or by one state; its last quarter bears what it is.
HALVES = """
import states
param l = 40
param m = 40
mesh block = rectangle(2, 1, cells = [8, 4])
part wall = block.left
part a = block where x < 1
part b = block where x > 1 and x < 1.5
part c = block where x > 1.5
part both = block where x < 1.5
part middle = block where x > 0.75 and x < 1.75
tensor B = isotropic(lambda = l, mu = m)
{states}
space V = vector P{order} on block, zero on wall
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    {forms}
  + integral(c, B : eps(u) : eps(v))
  = integral(block, dot([0.3*t, -0.24*t], v))
report
  table in_a = sigma.xx at [0.3, 0.9], in_b = sigma.xx at [1.2, 0.9], in_c = sigma.xx at [1.8, 0.9],
      whole = integral(block, sigma.xx), some = integral(middle, sigma.xy), most = largest(block, mises(sigma)),
      most_b = largest(b, mises(sigma)), least = smallest(middle, sigma.xx), worst = d at [0.05, 0.95]
  table by_hand = {by_hand} + integral(c, l*div(u) + 2*m*eps(u).xx)
  fields sigma
"""
OF_STATES = "state {0} on {1} with rate strain_damage(norm(eps(u)), 0.03, 1) from {0} = 0.2 in [0, 0.95]"
OF_FORMS = "integral({1}, (1 - {0})*B : eps(u) : eps(v))"
BY_HAND = "integral({1}, (1 - {0})*(l*div(u) + 2*m*eps(u).xx))"


def halves(folder):
    """What is known of the stress does not depend on how many states say it."""
    for order in (1, 2):
        finals = []
        for owners in ([("d", "a"), ("g", "b")], [("d", "both")]):
            script = HALVES.format(states="\n".join(OF_STATES.format(*o) for o in owners), order=order,
                                   **{key: " + ".join(form.format(*o) for o in owners) for key, form in (("forms", OF_FORMS), ("by_hand", BY_HAND))})
            done, out = run(folder, script, name=f"halves{order}{len(owners)}")
            assert done.returncode == 0, done.stderr
            finals.append(out["final"])
            names = sorted(p.name for p in (pathlib.Path(folder) / "out").glob(f"halves{order}{len(owners)}_sigma*00004.vtu"))
            check(f"stress of {len(owners)} states, P{order}: files", len(names) == len(owners), f"{names}")
        two, one = finals
        off = max(abs(two[k] - one[k]) / abs(one[k]) for k in one)
        check(f"stress of two states, P{order}, is that of one", off < 1e-11 and one["worst"] > 0.25 and abs(two["whole"] - two["by_hand"]) < 1e-11 * abs(two["whole"]),
              f"{off:.1e}, damage {one['worst']:.2f}, by hand {two['by_hand']:.12g}, {two['whole']:.12g}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        for test in (held_bond, wear, fault, jump_of_the_pull, breaks, turned, pulled, dropped, creep, released, halves):
            test(folder)
    print("all hold" if not failed else f"{len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
