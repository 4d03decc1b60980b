#!/usr/bin/env python3
"""Loads that read the solution and its gradients, against closed forms, orders and themselves run in other ways.

usage: solution_loads.py HVI_RUN

A sheared block that its own dissipation heats (1D to 3D, bodies of revolution, P1 and P2, all schemes), a layer whose viscosity falls with the temperature
(by quadrature), conduction that grows with the flux, reactions that are steep, on a boundary, and a manufactured solution
whose orders in time are those of the schemes. The same runs resumed from a checkpoint and by the iterative solver.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

from scipy.integrate import quad
from scipy.optimize import brentq

HVI = str(pathlib.Path(sys.argv[1]).resolve())
failed = []


def check(what, good, shown=""):
    print(f"{'ok    ' if good else 'FAILED'} {what} {shown}")
    if not good:
        failed.append(what)


def run(folder, script, *options, code=0):
    (pathlib.Path(folder) / "scene.hvi").write_text(script)
    out = pathlib.Path(folder) / "scene.json"
    out.unlink(missing_ok=True)
    done = subprocess.run([HVI, "run", "scene.hvi", "--no-files", "--quiet", "--json", "scene.json", *options], cwd=folder,
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stderr
    return json.loads(out.read_text()) if out.exists() else done.stderr


def near(found, wanted, part=1e-9):
    return abs(found - wanted) <= part * max(abs(wanted), 1e-12)


# A block is sheared, or stretched, at a given rate: eps(u') is the same everywhere, and with it theta: theta' = c exp(-k theta), c the dissipation.
BLOCK = """
param N = 10
param P = P1
param method = backward_euler
mesh body = {mesh}
part skin = body.boundary
space V = vector P on body, zero on {held}
space W = scalar P on body
{tensor}
find u in V, theta in W with u = {imposed} on {held} for t in [0, 1] by N steps from u = {start}, {motion}theta = 0
  using scheme = method
such that for all v in V, eta in W
    {forms} + integral(body, theta'*eta)
  = integral(body, ({heat})*exp(-0.7*theta)*eta)
report
  table th = theta at {place}, m = integral(body, theta)/integral(body, 1), low = smallest(body, theta), high = largest(body, theta)
"""
TENSOR = "tensor A = isotropic(lambda = 0.4, mu = 0.7)"
FLOW = "integral(body, A : eps(u') : eps(v))"
BLOCKS = {
    "1D": (dict(mesh="interval(1.5, cells = 3)", tensor="", imposed="[0.8*t*x]", start="[0]", forms="integral(body, 2*eps(u').xx*eps(v).xx)",
                heat="2*eps(u').xx^2", place="[0.4]"), 2 * 0.8**2),
    "2D": (dict(mesh="rectangle(1.5, 1, cells = [3, 2])", tensor=TENSOR, imposed="[0.8*t*y, 0.3*t*y]", start="[0, 0]", forms=FLOW,
                heat="(A : eps(u')) : eps(u')", place="[0.4, 0.3]"), 0.4 * 0.09 + 2 * 0.7 * (0.09 + 2 * 0.16)),
    "2D by sigma": (dict(mesh="rectangle(1.5, 1, cells = [3, 2])", tensor=TENSOR, imposed="[0.8*t*y, 0.3*t*y]", start="[0, 0]", forms=FLOW,
                         heat="sigma : eps(u')", place="[0.4, 0.3]"), 0.4 * 0.09 + 2 * 0.7 * (0.09 + 2 * 0.16)),
    "3D": (dict(mesh="box(1, 1, 1, cells = [2, 2, 2])", tensor=TENSOR, imposed="[0.8*t*z, 0.3*t*y, 0]", start="[0, 0, 0]", forms=FLOW,
                heat="(A : eps(u')) : eps(u')", place="[0.4, 0.3, 0.6]"), 0.4 * 0.09 + 2 * 0.7 * (0.09 + 2 * 0.16)),
    "ring": (dict(mesh="rectangle(1, 1, cells = [3, 2], axisymmetric = true)", tensor=TENSOR, imposed="[0.8*t*x, 0.3*t*y]", start="[0, 0]", forms=FLOW,
                  heat="(A : eps(u')) : eps(u')", place="[0.4, 0.3]"), 0.4 * 1.9**2 + 2 * 0.7 * (2 * 0.64 + 0.09)),
}


def stepped(c, method, n):
    """The scheme's own equations for theta' = c exp(-0.7 theta)."""
    k, rate = 1.0 / n, lambda x: c * math.exp(-0.7 * x)
    before, now = 0.0, 0.0
    for step in range(n):
        if method == "backward_euler" or step == 0:
            known, part = now, k
        else:
            known, part = (4 * now - before) / 3, 2 * k / 3
        before, now = now, brentq(lambda x: x - known - part * rate(x), known, known + part * c + 1e-9, xtol=1e-15)
    return now


def judge_blocks(folder):
    for name, (scene, c) in BLOCKS.items():
        for order in ("P1", "P2"):
            for method in ("backward_euler", "bdf2"):
                final = run(folder, BLOCK.format(held="skin", motion="", **scene), "-D", f"P={order}", "-D", f"method={method}")["final"]
                wanted = stepped(c, method, 10)
                check(f"block {name}, {order}, {method}", all(near(final[a], wanted) for a in ("th", "m", "low", "high")), f"{final['th']} {wanted}")
        # With inertia, and the velocity of the shear from the beginning, the body follows: theta has the exact solution's order 2.
        if name in ("1D", "2D"):
            moving = dict(scene, forms=scene["forms"] + " + integral(body, 3*dot(u'', v))")
            start = "u' = " + moving["imposed"].replace("t*", "") + ", "
            exact = math.log(1 + 0.7 * c) / 0.7
            for method in ("newmark", "hht", "midpoint"):
                errors = [abs(run(folder, BLOCK.format(held="skin", motion=start, **moving), "-D", f"N={n}", "-D", f"method={method}")["final"]["th"] - exact)
                          for n in (10, 20, 40)]
                orders = [math.log2(a / b) for a, b in zip(errors, errors[1:])]
                least = 0.9 if method == "midpoint" else 1.8  # hht's own damping shows beside it
                check(f"block {name}, {method}: order", orders[-1] > least, f"{orders} {errors}")


# A layer between plates at theta = 0, of viscosity exp(-b theta): the stress s is the same at all heights, w' = s exp(b theta) and -theta'' = s w'.
LAYER = """
param n = 16
param b = 2
mesh layer = rectangle(0.25, 1, cells = [1, n])
part lid = layer.top
part bed = layer.bottom
part walls = layer.left + layer.right
part plates = lid + bed
space V = vector P2 on layer, zero on plates, zero.y on walls
space W = scalar P2 on layer, zero on plates
find w in V, theta in W with w = [3, 0] on lid
such that for all v in V, eta in W
    integral(layer, 2*eps(w) : eps(v)) + integral(layer, dot(grad(theta), grad(eta)))
  = integral(layer, 2*(1 - exp(-b*theta))*eps(w) : eps(v)) + integral(layer, 2*exp(-b*theta)*(eps(w) : eps(w))*eta)
report
  table hottest = largest(layer, theta), pull = reaction(lid), heat = integral(layer, 2*exp(-b*theta)*(eps(w) : eps(w)))
"""


def judge_layer(folder):
    b, speed = 2.0, 3.0
    # theta'^2 = 2 s^2 (exp(b m) - exp(b theta)) / b, m in the middle; with it the height and the speed of the lid.
    def half(m, s, f):
        return quad(lambda q: f(m - q * q) * 2 * q / math.sqrt(2 * s * s * math.exp(b * m) * -math.expm1(-b * q * q) / b), 0, math.sqrt(m))[0]

    def stress(m):
        return half(m, 1.0, lambda _: 1.0) / 0.5
    m = brentq(lambda m: 2 * half(m, stress(m), lambda th: stress(m) * math.exp(b * th)) - speed, 1e-3, 2.0)
    final = run(folder, LAYER)["final"]
    check("layer: the hottest place", near(final["hottest"], m, 1e-4), f"{final['hottest']} {m}")
    check("layer: log(1 + b V^2/8)/b", near(m, math.log(1 + b * speed**2 / 8) / b, 1e-9))
    check("layer: the pull on the lid", near(final["pull_x"], 0.25 * stress(m), 1e-5), f"{final['pull_x']} {0.25 * stress(m)}")
    check("layer: all heat is the lid's work", near(final["heat"], final["pull_x"] * speed, 1e-8), f"{final['heat']} {final['pull_x'] * speed}")


# A paste with a yield stress, at first at rest: what it dissipates is what drives it, and what the wall takes.
PASTE = """
mesh channel = rectangle(0.25, 1, cells = [2, 12])
part wall = channel.top
superpotential paste(xi) = 0.5*norm(xi)
{slip}
space V = scalar P1 on channel{held}
space W = scalar P1 on channel, zero on wall
find u in V, theta in W for t in [0, 1] by 4 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(channel, 2*dot(grad(u), grad(v))) + integral(channel, paste^0(grad(u); grad(v))){law}
  + integral(channel, theta'*eta + dot(grad(theta), grad(eta)))
 >= integral(channel, 1.5*t*v) + integral(channel, (2*norm(grad(u))^2 + 0.5*norm(grad(u)))*eta)
report
  table heat = integral(channel, 2*norm(grad(u))^2 + 0.5*norm(grad(u))), work = integral(channel, 1.5*t*u){taken}, th = integral(channel, theta)
"""


def judge_paste(folder):
    held = dict(slip="", held=", zero on wall", law="", taken="")
    slides = dict(slip="superpotential slip(r) = 0.8*abs(r) + r^2", held="", law=" + integral(wall, slip^0(u; v))", taken=" - integral(wall, slip.xi*u)")
    for name, scene in (("held", held), ("slides", slides)):
        table = run(folder, PASTE.format(**scene))["table"]
        gone = max(abs(a - b) for a, b in zip(table["heat"], table["work"]))
        check(f"paste, {name}: all work is heat", gone < 1e-6 * table["heat"][-1], f"{table['heat']} {gone}")
        check(f"paste, {name}: at rest at first, warm at last", abs(table["th"][0]) < 1e-15 and table["th"][-1] > 1e-4)


# (1 + c |w'|^2) w' = 1 - x where w is held at 0.
CONDUCTION = """
param P = P1
param n = 16
param c = 50
mesh bar = {mesh}
part cold = bar.left
space W = scalar P on bar, zero on cold
find w in W
such that for all v in W
    integral(bar, dot(grad(w), grad(v))) = integral(bar, v) - integral(bar, c*norm(grad(w))^2*dot(grad(w), grad(v)))
report
  table tip = w at {tip}
"""


def judge_conduction(folder):
    slope = lambda x: brentq(lambda g: g + 50 * g**3 - (1 - x), 0, 1, xtol=1e-15)
    tip = quad(slope, 0, 1, epsabs=1e-13)[0]
    for mesh, place in (("interval(1, cells = n)", "[1]"), ("rectangle(1, 0.3, cells = [n, 1])", "[1, 0.15]"), ("box(1, 0.3, 0.3, cells = [n, 1, 1])", "[1, 0.1, 0.1]")):
        for order, n, part in (("P1", 16, 5e-3), ("P2", 64, 1e-4)):
            if mesh.startswith("box") and order == "P2":
                continue
            final = run(folder, CONDUCTION.format(mesh=mesh, tip=place), "-D", f"P={order}", "-D", f"n={n}")["final"]
            check(f"conduction {mesh}, {order}", near(final["tip"], tip, part), f"{final['tip']} {tip}")


# A steep reaction beside contact with Coulomb's friction and wear: as a load, and as a law at the same points.
WEAR = """
param c = 30
mesh body = rectangle(1, 1, cells = [5, 5])
part ground = body.bottom
part roof = body.top
tensor B = isotropic(young = 100, poisson = 0.3)
superpotential layer(r) = 50*pos(r - 0.1*wear)^2
superpotential slip(xi) = 0.3*abs(layer.xi)*norm(xi)
{law}
state wear on ground with rate 0.1*abs(layer.xi)*norm(u'.tau) from wear = 0
space V = vector P1 on body, zero on roof
space W = scalar P1 on body, zero on roof
find u in V, theta in W with u = [t, -0.05] on roof for t in [0, 1] by 5 steps from u = [0, -0.05*y], theta = 0
such that for all v in V, eta in W
    integral(body, B : eps(u) : eps(v)) + integral(body, eps(u') : eps(v)) - integral(body, theta*div(v))
  + integral(body, dot(grad(theta), grad(eta)) + theta'*eta) + integral(ground, layer^0(u.nu; v.nu) + slip^0(u'.tau; v.tau)){left}
 >= integral(body, 30*eta){right}
report
  table th = theta at [0.6, 0.4], ux = u.x at [0.6, 0], w = integral(ground, wear)
"""


def judge_wear(folder):
    load = run(folder, WEAR.format(law="", left="", right=" - integral(body, c*theta^3*eta)"))["final"]
    law = run(folder, WEAR.format(law="superpotential cool(r) with slope c*r^3", left=" + integral(body, cool^0(theta; eta), rule = gauss)", right=""))["final"]
    check("a steep load beside wear is the law", all(near(load[a], law[a], 1e-8) for a in ("th", "ux", "w")) and load["w"] > 1e-3, f"{load} {law}")


# Values on a boundary, and the gradient of the cell behind it: w' = 1 - w^2 + sqrt(w') has w' = w = 1.
END = """
mesh bar = interval(1, cells = 4)
part foot = bar.left
part tip = bar.right
space W = scalar P2 on bar, zero on foot
find w in W
such that for all v in W
    integral(bar, dot(grad(w), grad(v))) = integral(tip, (1 - w^2)*v) + integral(tip, sqrt(abs(dot(normal, grad(w))))*v)
report
  table tip = w at [1]
"""

# u = t^2 x(1 - x), theta = sin(t) (1 + x): what is left of the equations is given as a load.
MADE = """
param N = 10
param method = backward_euler
mesh bar = interval(1, cells = 4)
part ends = bar.left + bar.right
space V = vector P2 on bar, zero on ends
space W = scalar P2 on bar, zero on ends
fn e(x, t) = t^2*(1 - 2*x)
fn ed(x, t) = 2*t*(1 - 2*x)
fn th(x, t) = sin(t)*(1 + x)
find u in V, theta in W with theta = sin(t)*(1 + x) on ends for t in [0, 1] by N steps from u = [0], theta = 0
  using scheme = method
such that for all v in V, eta in W
    integral(bar, (eps(u').xx + eps(u).xx)*eps(v).xx) + integral(bar, theta'*eta + dot(grad(theta), grad(eta)))
  = integral(bar, 0.3*theta*eps(u').xx*eps(v).xx) - integral(bar, 0.3*th(x, t)*ed(x, t)*eps(v).xx) + integral(bar, (ed(x, t) + e(x, t))*eps(v).xx)
  + integral(bar, (eps(u').xx^2 + grad(theta).x*u.x)*eta) + integral(bar, (cos(t)*(1 + x) - ed(x, t)^2 - sin(t)*t^2*x*(1 - x))*eta)
report
  table e = integral(bar, (theta - sin(t)*(1 + x))^2) + integral(bar, (u.x - t^2*x*(1 - x))^2)
"""


def judge_orders(folder):
    for method, order in (("backward_euler", 1), ("bdf2", 2)):
        errors = [math.sqrt(run(folder, MADE, "-D", f"N={n}", "-D", f"method={method}")["final"]["e"]) for n in (20, 40, 80, 160)]
        orders = [math.log2(a / b) for a, b in zip(errors, errors[1:])]
        check(f"manufactured, {method}: order {order}", abs(orders[-1] - order) < 0.1, f"{orders} {errors}")


def judge_ways(folder):
    script = BLOCK.format(held="skin", motion="", **BLOCKS["2D"][0]).replace("theta'*eta)", "theta'*eta + dot(grad(theta), grad(eta)))").replace(
        ")*exp(-0.7*theta)*eta", ")*(1 + x*y)*exp(-0.7*theta)*eta")
    whole = run(folder, script)["final"]
    for option in (["--solver", "iterative"], ["--factor", "single"], ["--full"]):
        other = run(folder, script, *option)["final"]
        check(f"the same with {' '.join(option)}", all(near(other[a], whole[a], 1e-8) for a in ("th", "m", "low", "high")))
    linear = script.replace("find u", "tensor B = isotropic(lambda = 3, mu = 2)\nfind u").replace(FLOW, FLOW + " + integral(body, B : eps(u) : eps(v))")
    by_sigma = run(folder, linear.replace("= integral(body, ", "= integral(body, sigma.xx*eta) + integral(body, ", 1).replace("table", "table s = sigma.xx at [0.4, 0.3],"))
    by_forms = run(folder, linear.replace("\n  = ", "\n  - integral(body, (A : eps(u')).xx*eta) - integral(body, (B : eps(u)).xx*eta)\n  = ", 1))["final"]
    check("a stress on the right is a form", all(near(by_sigma["final"][a], by_forms[a], 1e-8) for a in ("th", "m", "low", "high")))
    check("loads on the right are no stress", near(by_sigma["final"]["s"], 3 * 0.3 + 0.4 * 0.3, 1e-8), f"{by_sigma['final']['s']}")
    out = pathlib.Path(folder) / "out"
    options = [HVI, "run", "scene.hvi", "-o", str(out), "--quiet"]
    (pathlib.Path(folder) / "scene.hvi").write_text(script.replace("method = backward_euler", "method = bdf2"))
    first = subprocess.run([*options, "--checkpoint", "4", "--json", "first.json"], cwd=folder, capture_output=True, text=True, timeout=300)
    again = subprocess.run([*options, "--resume", "--json", "again.json"], cwd=folder, capture_output=True, text=True, timeout=300)
    assert first.returncode == 0 and again.returncode == 0, first.stderr + again.stderr
    one, two = (json.loads((pathlib.Path(folder) / name).read_text())["final"] for name in ("first.json", "again.json"))
    check("the same from a checkpoint", one == two, f"{one} {two}")


def judge_failures(folder):
    scene = BLOCK.format(held="skin", motion="", **BLOCKS["2D"][0])
    gone = run(folder, scene.replace("-0.7*theta", "9*theta"), code=3)
    check("no solution: E0701 at the load", "E0701" in gone and "the load of theta and the solution do not settle" in gone and "exp(9*theta)*eta" in gone, gone)
    bad = run(folder, scene.replace("exp(-0.7*theta)", "sqrt(0.3 - 0.5*t - theta)"), code=3)
    check("no number: it is told where", "what the load of theta reads is no number at" in bad, bad)


def main():
    with tempfile.TemporaryDirectory() as folder:
        judge_blocks(folder)
        judge_layer(folder)
        judge_paste(folder)
        judge_wear(folder)
        judge_conduction(folder)
        check("end: values and gradients on a boundary", near(run(folder, END)["final"]["tip"], 1.0))
        judge_orders(folder)
        judge_ways(folder)
        judge_failures(folder)
    print(f"{len(failed)} failed")
    sys.exit(bool(failed))


main()
