#!/usr/bin/env python3
"""one_way.py HVI_RUN: an unknown that laws alone hold, which another one drives and which drives none.

- A temperature on a Robin law with a kink or on one that softens, warmed by the strain of a body whose strain is known; a body on
  a table, lifted by a temperature that is known; both against the same problem for the one unknown alone, the other one's part
  being a load. One step and several.
- A temperature that a flow carries, in either form of the equation, against the flux that the balance asks for.
- What laws cannot hold is refused, all the same.
"""
import json
import pathlib
import random
import subprocess
import sys
import tempfile

HVI_RUN = sys.argv[1]
FOLDER = pathlib.Path(tempfile.mkdtemp())

LAWS = {
    "kink": "(s) with slope | s < {a} -> {b}*s | otherwise -> {a}*{b} + 0.2*{b}*(s - {a})",
    "softening": "(s) with slope | s < {a} -> {b}*s | s < 2*{a} -> {a}*{b} - 0.05*(s - {a}) | otherwise -> {a}*{b} - 0.05*{a} + {b}*(s - 2*{a})",
}

HEATED = """mesh body = rectangle(2, 1, cells = [6, 3])
part ground = body.bottom
{sides}tensor B = isotropic(young = 10, poisson = 0)
superpotential sink{law}
{v}space W = scalar P1 on body
find {u}theta in W{with_} {time}such that for all {v_}eta in W
    {b}integral(body, {k}*dot(grad(theta), grad(eta)))
  {plus}
  + integral(ground, sink^0(theta; eta))
 >= integral(body, {load}*eta)
report
  table warmth = theta at [1, 0], top = theta at [0, 1], heat = integral(ground, sink.xi)
"""

LIFTED = """import contact
mesh body = rectangle(2, 1, cells = [6, 3])
part ground = body.bottom
part left = body.left
part roof = body.top
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential desk(r) = unilateral(r)
space V = vector P1 on body, zero.x on left
{w}find u in V{theta} {time}such that for all v in V{eta}
    integral(body, B : eps(u) : eps(v))
  {plus}
  + integral(ground, desk^0(u.nu; v.nu))
 >= integral(body, {load}*v.y)
report
  table pressure = integral(ground, desk.xi), lift = u.y at [2, 1], crest = desk.xi at [1, 0]
"""

CARRIED = """mesh body = rectangle(2, 1, cells = [32, 2])
part outlet = body.right
space W = scalar P2 on body
superpotential sink(s) with slope | s < 1 -> 3*s | otherwise -> 3
find theta in W
such that for all eta in W
    integral(body, dot(grad(theta), grad(eta)))
  {transport}
  + integral(outlet, sink^0(theta; eta))
 >= integral(body, {load}*eta)
report
  table heat = integral(outlet, sink.xi)
"""


def run(script, code=0):
    path, out = FOLDER / "scene.hvi", FOLDER / "out.json"
    path.write_text(script)
    found = subprocess.run([HVI_RUN, "run", path, "--no-files", "--quiet", "--json", out], capture_output=True, text=True)
    if found.returncode != code:
        sys.exit(f"exit code {found.returncode}, not {code}\n{script}\n{found.stderr}")
    return json.loads(out.read_text())["table"] if code == 0 else found.stderr


def same(what, one, other):
    for name in set(one) - {"event"}:
        for a, b in zip(one[name], other[name], strict=True):
            size = max(max(map(abs, one[name])), 1e-3)
            if abs(a - b) > 1e-9 * size:
                sys.exit(f"{what}: {name} is {a}, alone {b}")


def heated(draw, law):
    rate, swell, k = draw.uniform(0.05, 0.3), draw.choice([-1, 1]) * draw.uniform(0.5, 3), draw.uniform(0.5, 2)
    steps = draw.choice([0, 3])
    t, time = ("t", f"for t in [0, 1] by {steps} steps ") if steps else ("1", "")
    text = LAWS[law].format(a=round(draw.uniform(0.1, 0.4), 3), b=round(draw.uniform(1, 3), 3))
    common = {"law": text, "k": k, "time": time}
    both = HEATED.format(sides="part ends = body.boundary where abs(x - 1) > 0.999\n", v="space V = vector P1 on body, zero on ends\n", u="u in V, ", v_="v in V, ",
                         with_=f" with u = [{t}*{rate}*x, 0] on ends", b="integral(body, B : eps(u) : eps(v)) + ",
                         plus=f"+ integral(body, {swell}*div(u)*eta)", load="0", **common)
    alone = HEATED.format(sides="", v="", u="", v_="", with_="", b="", plus="", load=f"-{swell}*{t}*{rate}" if swell > 0 else f"{-swell}*{t}*{rate}", **common)
    same("heated", run(both), run(alone))


def lifted(draw):
    warmth, lift = draw.uniform(0.5, 2), draw.uniform(0.1, 0.4)
    steps = draw.choice([0, 3])
    t, time = ("t", f"for t in [0, 1] by {steps} steps ") if steps else ("1", "")
    both = LIFTED.format(w="space W = scalar P1 on body, zero on roof\n", theta=f", theta in W with theta = {t}*{warmth} on roof", eta=", eta in W", time=time,
                         plus=f"+ integral(body, dot(grad(theta), grad(eta))) - integral(body, {lift}*theta*v.y)", load="-2")
    alone = LIFTED.format(w="", theta="", eta="", time=time, plus="", load=f"({lift}*{t}*{warmth} - 2)")
    same("lifted", run(both), run(alone))


def main():
    draw = random.Random(3)
    for _ in range(4):
        heated(draw, "kink")
        heated(draw, "softening")
        lifted(draw)
    # Analytic: -theta'' + theta' = 0.4, theta'(0) = 0, so that theta'(2) = 0.4 (1 - e^2).
    heat = run(CARRIED.format(transport="+ integral(body, dot([1, 0], grad(theta))*eta)", load="0.4"))["heat"][-1]
    assert abs(heat - 0.4 * (2.718281828459045**2 - 1)) < 1e-4, heat
    # Carried away from the outlet, more is made than the law there can take, which has to take 2 (1 - e^-2) only.
    heat = run(CARRIED.format(transport="- integral(body, dot([1, 0], grad(theta))*eta)", load="2"))["heat"][-1]
    assert abs(heat - 2 * (1 - 2.718281828459045**-2)) < 1e-4, heat
    # In the form that keeps what is carried all of it leaves through the law.
    heat = run(CARRIED.format(transport="- integral(body, theta*dot([1, 0], grad(eta)))", load="0.4"))["heat"][-1]
    assert abs(heat - 0.8) < 1e-10, heat
    run(CARRIED.format(transport="+ integral(body, dot([1, 0], grad(theta))*eta)", load="0.6"), code=3)
    assert "cannot balance" in run(CARRIED.format(transport="- integral(body, theta*dot([1, 0], grad(eta)))", load="1.6"), code=1)
    print("26 runs")


if __name__ == "__main__":
    main()
