#!/usr/bin/env python3
"""start.py HVI_RUN: how runs begin, and forms that change in time.

- `from u = static`, random scenes: the first row against the static problem as a script of its own; reactions against loads.
- The same where laws see sums of u and its rate, and vectors of which some components move: the force against the law's slope at the argument that is printed, and against the load.
- Reactions where forms change in time, in every scheme with mass: with loads and inertia they add up to zero.
- Forms that change in time against the same ones without time, with coefficients that vary in space, and laws on the same cells.
- What follows a static start: creep with a memory against the scalar equation it is, rest where nothing changes, with mass too; of bodies with states in their forms, of revolution as well, by the rules of each.
- Columns with a time of their own in the first step: what the rows of its ends say, where the initial state is known.
- Tables and fields `from start`: the rows of the steps are the same bytes, what is not known is empty, resumed runs are the same.
- `from u = static` where the only laws at the points of states see rates, and where bounds and sources read the multipliers of such laws: the first row against a static script without them. The same laws times 0.
- Values at times between those of the steps against the rows at both ends, in the first step from what is known at its start; two unknowns of which one has no known rate there.
- Stiffness and viscosity that change in time, random scenes: each step against a script without time.
"""
import csv
import itertools
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

HVI_RUN = sys.argv[1]

SCENE = """param t0 = {t0}
mesh body = rectangle(2, 1, cells = [{cells}, {cells}])
part wall = body.left
part ground = body.bottom
part tip = body.right
tensor A = isotropic(lambda = 5, mu = 10)
tensor B = isotropic(young = {young}, poisson = 0.3)
kernel C(lag) = -0.5*exp(-lag/0.7)
superpotential layer(r) = {stiff}*pos(r)^2
superpotential rub(xi) = {friction}*norm(xi)
superpotential slip(w) = 0.3*abs(layer.xi)*norm(w)
space V = vector {element} on body, zero on wall
find u in V {time}
such that for all v in V
    {rates}integral(body, B : eps(u) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu){slides} + rub^0(u.tau; v.tau))
 >= integral(tip, dot([{pull}*{t}, -{load}*(1 + {t})], v))
report
  table end_x = u.x at [2, 1], end_y = u.y at [2, 0.5], clamp = reaction(wall), bed = reaction(ground), pressed = integral(ground, layer.xi), size = norm(u), worst = largest(body, mises(sigma)){start}
"""
RATES = "integral(body, A : eps(u') : eps(v)) + integral(body, history(C, B : eps(u)) : eps(v)) + "


def run(folder, text, *options, name="scene", succeeds=True):
    (folder / f"{name}.hvi").write_text(text)
    done = subprocess.run([HVI_RUN, str(folder / f"{name}.hvi"), "-o", str(folder / "out"), "--quiet", *options], capture_output=True, text=True)
    assert (done.returncode == 0) == succeeds, f"{text}\n{done.stderr}"
    return done.stderr


def rows(folder, name="scene"):
    return [{k: float(v) if v else None for k, v in row.items()} for row in csv.DictReader((folder / "out" / f"{name}.csv").open())]


def near(a, b, size, what, within=1e-9):
    assert a is not None and b is not None and abs(a - b) <= within * size, f"{what}: {a} and {b}"


def check_static_start(folder, scenes=10):
    rng = random.Random(23)
    for scene in range(scenes):
        some = {"t0": rng.choice([0.0, 1.5, -2.0]), "cells": rng.randint(3, 6), "young": 10 ** rng.uniform(0, 4), "element": rng.choice(["P1", "P2"])}
        some |= {"stiff": some["young"] * 10 ** rng.uniform(-1, 1), "friction": some["young"] * 10 ** rng.uniform(-5, -3),
                 "pull": some["young"] * rng.uniform(-0.01, 0.01), "load": some["young"] * rng.uniform(0.001, 0.01)}
        static = SCENE.format(**some, time="", rates="", slides="", t="t0", start="")
        moving = SCENE.format(**some, time=f"for t in [t0, t0 + 1] by 3 steps from u = static using scheme = {rng.choice(['backward_euler', 'bdf2'])}",
                              rates=RATES, slides=" + slip^0(u'.tau; v.tau)", t="t", start=" from start")
        run(folder, static)
        expected = rows(folder)[-1]
        run(folder, moving)
        found = rows(folder)
        assert len(found) == 4 and found[0]["t"] == some["t0"], found
        for group in (("end_x", "end_y"), ("clamp_x", "clamp_y", "bed_x", "bed_y", "pressed"), ("size",), ("worst",)):
            size = max(abs(expected[name]) for name in group)
            for name in group:
                near(found[0][name], expected[name], size, f"scene {scene}, {name}")
        for row in found:  # the traction on a side of length 1, in the first row, too
            force = [some["pull"] * row["t"], -some["load"] * (1 + row["t"])]
            for axis, f in zip("xy", force):
                near(row["clamp_" + axis] + row["bed_" + axis] + f, 0, max(map(abs, force)), f"scene {scene}, balance along {axis}", 1e-7)


BAR = """mesh body = rectangle(2, 1, cells = [4, 2])
part wall = body.left
part tip = body.right
tensor B = isotropic(young = 100, poisson = 0.3)
kernel q(lag) = -0.8*exp(-lag/0.5)
space V = vector P1 on body, zero on wall
find u in V for t in [1, 3] by 20 steps from u = static{more}
such that for all v in V
    integral(body, B : eps(u) : eps(v)){terms}
  = integral(tip, dot([1, -0.1], v))
report
  table a = u.y at [2, 0], b = u.x at [2, 1]{columns} from start
"""


def check_creep(folder):
    """All of B: u_n = c_n u_0, c_n + sum_j c_j int q = 1."""
    run(folder, BAR.format(more="", terms=" + integral(body, history(q, B : eps(u)) : eps(v))", columns=""))
    found, tau, c = rows(folder), 0.5, []
    for n in range(1, 21):
        weight = [-0.8 * tau * (math.exp(-0.1 * (n - j) / tau) - math.exp(-0.1 * (n - j + 1) / tau)) for j in range(1, n + 1)]
        c.append((1 - sum(w * x for w, x in zip(weight, c))) / (1 + weight[-1]))
    assert c[-1] > 1.3
    for row, factor in zip(found, [1.0, *c]):
        for name in "ab":
            near(row[name], factor * found[0][name], abs(found[0][name]), f"creep at {row['t']}", 1e-10)


def check_start_beside_mean_loads(folder):
    """A static start is under the load of its time, also where steps take means over theirs."""
    text = """mesh body = rectangle(2, 1, cells = [4, 2])
part wall = body.left
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on body, zero on wall
find u in V for t in [1, 2] by 4 steps from u = static using load = {load}
such that for all v in V
  integral(body, B : eps(u) : eps(v)) + integral(body, B : eps(u') : eps(v)) = integral(body, dot([0, -t^2], v))
report
  table a = u.y at [2, 1] from start
"""
    starts = []
    for load in ("endpoint", "average"):
        run(folder, text.replace("{load}", load))
        starts.append(rows(folder)[0]["a"])
    near(*starts, abs(starts[0]), "the start beside mean loads", 1e-12)


def check_columns_at_the_first_time(folder):
    """A column with the first time as its own has the initial value in all rows, whether there is one of the start or not."""
    for more, count in (("", 4), (" from start", 5)):
        run(folder, f"""mesh plate = rectangle(1, 1, cells = [2, 2])
part wall = plate.left
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on plate, zero on wall
find u in V for t in [0, 1] by 4 steps from u = [0.1*x, 0]
such that for all v in V
  integral(plate, B : eps(u) : eps(v)) + integral(plate, B : eps(u') : eps(v)) = 0
report
  table a = u.x at [1, 1], b = u.x at [1, 1] at t = 0{more}
""")
        found = rows(folder)
        assert len(found) == count
        for row in found:
            near(row["b"], 0.1, 0.1, "the first time", 1e-14)
            near(row["a"], 0.1 / 1.25 ** round(4 * row["t"]), 0.1, "backward Euler", 1e-12)


def check_rest(folder):
    """Nothing changes: with viscosity, and with mass in every scheme, where rates and accelerations are zero from the start."""
    run(folder, BAR.format(more="", terms=" + integral(body, isotropic(lambda = 1, mu = 2) : eps(u') : eps(v))", columns=", rate = u'.y at [2, 0]"))
    still = rows(folder)
    for scheme in ("newmark", "hht", "midpoint", "bdf2"):
        run(folder, BAR.format(more=f" using scheme = {scheme}", terms=" + integral(body, 3*dot(u'', v))",
                               columns=", rate = u'.y at [2, 0], force = u''.y at [2, 0]"))
        still += rows(folder)
    for row in still:
        near(row["a"], still[0]["a"], abs(still[0]["a"]), "rest", 1e-9)
        near(row["rate"], 0, abs(still[0]["a"]), "rate at rest", 1e-7)
        near(row.get("force", 0), 0, abs(still[0]["a"]), "acceleration at rest", 1e-5)


SUM = """mesh body = rectangle(2, 1, cells = [{cells}, {cells}])
part roof = body.top
part ground = body.bottom
tensor B = isotropic(young = {young}, poisson = 0.3)
tensor A = isotropic(lambda = 5, mu = 10)
superpotential bed(r) = {stiff}*r^2
superpotential rub(w) = {friction}*norm(w) + {stiff}*norm(w)^2
space V = vector P1 on body, zero on roof
find u in V for t in [0, 1] by 3 steps from u = static
such that for all v in V
    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v))
  + integral(ground, bed^0({times}*u.nu + 0.1*u'.nu; v.nu) + rub^0([{first}, {second}]; [v.x, v.y]))
 >= integral(ground, dot([{pull}, {load}], v))
report
  table u = u at [1, 0], bed = bed.xi at [1, 0], rub = rub.xi at [1, 0], roof = reaction(roof), ground = reaction(ground) from start
"""


STILL = """mesh body = rectangle(1, 0.5, cells = [4, 2]{more})
part roof = body.top
part rim = body.right
tensor A = isotropic(lambda = 5, mu = 10)
tensor B = isotropic(young = 100, poisson = 0.3)
state d on body with rate {rate} from d = {initial} in [0, 0.9]
space V = vector {element} on body, zero on roof
find u in V for t in [0, 0.2] by 4 steps from u = static using scheme = {scheme}
such that for all v in V
    {mass}integral(body, A : eps(u') : eps(v)) + integral(body, (1 - d)*{factor}*B : eps(u) : eps(v)){bed}
  = integral(rim, dot([{pull}, 3], v))
report
  table a = u.x at [1, 0], b = u.y at [0.5, 0], rate = largest(body, norm(u')), x = u.x at [0.5, 0.25], held = reaction(roof) from start
"""


def check_rest_of_states(folder):
    """States that nothing moves, whatever their rates read: the start is a balance of the very forms of the steps, whose rules depend on what rates read."""
    schemes = [("bdf2", ""), ("newmark", "integral(body, 0.5*dot(u'', v)) + ")]
    choices = itertools.product(["", ", axisymmetric = true"], ["P1", "P2"], ["max(0, norm(eps(u)) - 100)", "max(0, abs(u.y) - 100)"],
                                ["0.2", "0.2 + 0.3*x*y"], ["", " + integral(body, (1 + d)*30*dot(u, v))"])
    for k, (more, element, rate, initial, bed) in enumerate(choices):
        scheme, mass = schemes[k % 2]
        what = f"{more} {element} {rate} {initial} {bed} {scheme}"
        run(folder, STILL.format(more=more, element=element, rate=rate, scheme=scheme, mass=mass, initial=initial, bed=bed, factor="(1 + 0.7*x^3)", pull=8))
        found = rows(folder)
        assert len(found) == 5
        for row in found[1:]:
            for name in ("a", "b", "x", "held_x", "held_y"):
                near(row[name], found[0][name], max(abs(found[0][name]), 0.01), f"{name} of {what}", 1e-9)
            near(row["rate"], 0, abs(found[0]["a"]), f"rate of {what}", 1e-7)


def check_sums(folder, scenes=30):
    rng = random.Random(29)
    for scene in range(scenes):
        some = {"cells": 2 * rng.randint(1, 3), "young": 10 ** rng.uniform(0, 3), "times": rng.choice([0.3, 1, 2, 5]), "pull": rng.uniform(-1, 1), "load": rng.uniform(-3, -1)}
        some |= {"stiff": some["young"] * 10 ** rng.uniform(-1, 1), "friction": 0.1 * rng.random()}
        moves = [rng.choice([("u'", 0), ("u", 1)]) for _ in range(2)]
        some |= {"first": moves[0][0] + ".x", "second": moves[1][0] + ".y"}
        run(folder, SUM.format(**some))
        row = rows(folder)[0]
        at = [row["u_x"], row["u_y"]]
        size = abs(some["load"]) + some["stiff"] * sum(map(abs, at))
        near(row["bed"], -2 * some["stiff"] * some["times"] * at[1], size, f"scene {scene}, bed")
        seen = [moves[i][1] * at[i] for i in range(2)]
        norm = math.hypot(*seen)
        for i, name in enumerate(("rub_x", "rub_y")):
            slope = seen[i] * (some["friction"] / norm + 2 * some["stiff"]) if norm > 0 else 0
            near(row[name], slope, size, f"scene {scene}, {name}")
        for i, axis in enumerate("xy"):
            near(row["roof_" + axis] + row["ground_" + axis] + 2 * (some["pull"], some["load"])[i], 0, size, f"scene {scene}, balance along {axis}", 1e-8)


MOVING = """mesh body = rectangle(1, 1, cells = [2, 2])
part roof = body.top
tensor B = isotropic(lambda = {lame}, mu = 5)
tensor A = isotropic(lambda = 0, mu = 0.5)
space V = vector P1 on body, {held} on roof
find u in V for t in [0, 1] by {steps} steps from u = 0 using scheme = {scheme}
such that for all v in V
    integral(body, dot(u'', v)) + integral(body, (1 + {faster}*t)*B : eps(u) : eps(v)) + integral(body, (2 - t)*A : eps(u') : eps(v))
  = integral(body, dot([0.3*t, -1], v))
report
  table held = reaction(roof), x = integral(body, u''.x), y = integral(body, u''.y)
"""


def check_changing_reactions(folder, scenes=25):
    rng = random.Random(31)
    for scene in range(scenes):
        scheme = rng.choice(["newmark", "hht", "bdf2", "backward_euler"])
        some = {"lame": rng.uniform(0, 9), "held": "zero", "steps": rng.randint(2, 9), "scheme": scheme + (", hht_alpha = -0.3" if scheme == "hht" else ""), "faster": rng.uniform(-0.9, 5)}
        run(folder, MOVING.format(**some))
        step, before = 1 / some["steps"], [0.0, -1.0]
        for row in rows(folder):
            now = [0.3 * row["t"], -1.0]
            share = -0.3 if scheme == "hht" else 0.0
            for i, axis in enumerate("xy"):
                load = (1 + share) * now[i] - share * before[i]
                near(row["held_" + axis] + load - row[axis], 0, 10, f"scene {scene}, {scheme} at {row['t']}, {axis}")
            before = now


SHAPES = """mesh body = {mesh}
part wall = body.left
tensor B = isotropic(lambda = 1, mu = 2)
superpotential bed(r) = 2*r^2
space V = vector {element} on body, zero on wall
find u in V {time}
such that for all v in V
    integral(body, {factor}*({shape})*B : eps(u) : eps(v)) + integral(body, {factor}*x^{power}*dot(u, v)) + integral(body, bed^0(u.x; v.x))
 >= integral(body, dot([1, -1], v))
report
  table a = u at [1, 1], size = norm(u)
"""


def check_changing_quadrature(folder, scenes=20):
    """A form that changes in time is integrated as it is without time; a law may act on the same cells."""
    rng = random.Random(37)
    for scene in range(scenes):
        mesh = rng.choice(["rectangle(1, 1, cells = [2, 2])", "rectangle(1, 1, cells = [3, 4])"])
        some = {"mesh": mesh, "element": rng.choice(["P1", "P2"]), "power": rng.randint(0, 6), "shape": f"{rng.uniform(0.1, 1)} + {rng.uniform(0, 3)}*x^{rng.randint(1, 4)}*y"}
        run(folder, SHAPES.format(**some, factor="3", time=""))
        expected = rows(folder)[-1]
        run(folder, SHAPES.format(**some, factor="(1 + t)", time="for t in [0, 2] by 2 steps from u = 0"))
        found = rows(folder)[-1]
        for name in ("a_x", "a_y", "size"):
            near(found[name], expected[name], abs(expected["size"]), f"scene {scene}, {name}: {some}")
    run(folder, SHAPES.format(mesh="rectangle(1, 1, cells = [2, 2])", element="P1", power=0, shape="1", factor="0", time="").replace("0*(1)*B", "2*B"))
    expected = rows(folder)[-1]
    run(folder, SHAPES.format(mesh="rectangle(1, 1, cells = [2, 2])", element="P1", power=0, shape="1", factor="0", time="for t in [0, 2] by 2 steps from u = 0").replace("0*(1)*B", "t*B"))
    for name in ("a_x", "a_y", "size"):  # no stiffness at the initial time, where no step is taken
        near(rows(folder)[-1][name], expected[name], abs(expected["size"]), f"from no stiffness, {name}")


def check_refusals(folder):
    belt = SCENE.format(t0=0, cells=3, young=100, stiff=100, friction=1, pull=0, load=1, element="P1", rates=RATES, t="t", start="",
                        time="for t in [0, 1] by 2 steps from u = static", slides=" + rub^0(u'.tau - [0.1, 0]; v.tau)").replace(" + rub^0(u.tau; v.tau)", "")
    said = run(folder, belt, succeeds=False)
    assert "exerts a force" in said and "rub" in said, said
    loose = BAR.format(more="", terms="", columns="").replace(", zero on wall", "")
    said = run(folder, loose, succeeds=False)
    assert "E0425" in said, said


GIVEN = """mesh body = rectangle(2, 1, cells = [4, 2])
part wall = body.left
part tip = body.right
part ground = body.bottom
tensor A = isotropic(lambda = 5, mu = 10)
tensor B = isotropic(young = 100, poisson = 0.3)
superpotential layer(r) = 50*pos(r)^2
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] by 6 steps from u = [0.01*x, -0.02*x]
such that for all v in V
    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(tip, dot([0, -t], v))
report
  table a = u.y at [2, 0], b = integral(body, x*u.x), strain = largest(body, eps(u) : eps(u)), rate = u'.y at [2, 0], held = reaction(wall), pressed = integral(ground, layer.xi), sum = integral(body, u.x) + t, late = u.y at [2, 0] at t = 0.5{first} to "one.csv"
  table a2 = u.y at [2, 0] every 4 steps{second} to "two.csv"
  fields u, layer.xi every 3 steps{second} to "fields.vtu"
"""


def check_rows(folder):
    def files(first, second, *options):
        run(folder, GIVEN.format(first=first, second=second), *options)
        out = folder / "out"
        return (out / "one.csv").read_bytes().splitlines(), (out / "two.csv").read_bytes().splitlines(), (out / "fields.pvd").read_text()

    plain, with_start = files("", ""), files(" from start", " from start")
    for without, first in zip(plain[:2], with_start[:2]):
        assert [first[0], *first[2:]] == without, "the rows of the steps are others"
    assert files(" from start", "")[1] == plain[1], "a table has a row that another one asked for"
    run(folder, GIVEN.format(first=" from start", second=" from start"))
    row = rows(folder, "one")[0]
    for name, value in {"t": 0, "a": -0.04, "b": 0.01 * 8 / 3, "strain": 0.01 ** 2 + 2 * 0.01 ** 2, "sum": 0.02}.items():
        near(row[name], value, 1, name, 1e-15)
    assert all(row[name] is None for name in ("rate", "held_x", "held_y", "pressed", "late")), row
    assert [r["t"] for r in rows(folder, "two")] == [0, 4 / 6, 1]
    times = [line.split('"')[1] for line in with_start[2].splitlines() if "timestep" in line and 'part="0"' in line]
    assert [float(t) for t in times] == [0, 0.5, 1], times
    assert 'timestep="0"' not in plain[2]
    text = GIVEN.format(first=" from start", second=" from start").replace("by 6", "by 4").replace("every 3", "every 2")
    longer = text.replace("[0, 1] by 4", "[0, 2] by 8")
    names = ["one.csv", "two.csv", "fields.pvd"]
    run(folder, text, "--checkpoint", "1")
    run(folder, longer, "--resume")
    resumed = [(folder / "out" / name).read_bytes() for name in names]
    run(folder, longer)
    assert resumed == [(folder / "out" / name).read_bytes() for name in names]


RESTING = """mesh body = rectangle(2, 1, cells = [{cells}, {cells}])
part wall = body.left
part ground = body.bottom
part tip = body.right
tensor B = isotropic(young = {young}, poisson = 0.3)
kernel q(lag) = exp(-lag)
superpotential layer(r) = {stiff}*pos(r)^2
superpotential damp(r) = {times}*{stiff}*pos(r)^2
superpotential grip(w) = {bound}*norm(w)
superpotential rub(w) = {times}*(0.1 + path)*norm(w)
superpotential slow(w) = norm(w)^2
{state}
space V = vector {element} on body, zero on wall
find u in V {time}
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu) + grip^0(u.tau; v.tau)){moving}
 >= integral(body, dot([{pull}, -1 - {t}], v))
report
  table end = u at [2, 1], held = reaction(wall), pressed = integral(ground, layer.xi), size = norm(u){more}
"""


def check_laws_at_rest(folder, scenes=8):
    rng = random.Random(53)
    path = "state path on tip with rate norm(u') + 0.1*abs(rub.xi.x) from path = 0.25 + 0.1*y"
    moving = " + integral(ground, damp^0({of}; v.nu)) + integral(tip, rub^0({seen}; v)) + integral(tip, slow^0(u'; v)) - integral(ground, damp.xi*v.x)"
    for scene in range(scenes):
        some = {"cells": rng.randint(2, 5), "young": 10 ** rng.uniform(1, 3), "element": rng.choice(["P1", "P2"]), "pull": rng.uniform(-1, 1)}
        some |= {"stiff": some["young"] * 10 ** rng.uniform(-1, 1)}
        seen = rng.choice(["u'", "history(q, u)"])
        run(folder, RESTING.format(**some, times=1, bound=0.02, time="", t=0, moving="", state="fn path() = 0", more="").replace("+ path)", "+ path())"))
        expected = rows(folder)[-1]
        time = f"for t in [0, 1] by 3 steps from u = static using scheme = {rng.choice(['backward_euler', 'bdf2'])}"
        run(folder, RESTING.format(**some, bound="(0.02 + abs(damp.xi))", times=1, time=time, t="t", moving=moving.format(of=rng.choice(["u'.nu", "history(q, u).nu"]), seen=seen), state=path,
                                   more=", kept = integral(tip, path) from start"))
        first = rows(folder)[0]
        for group in (("end_x", "end_y"), ("held_x", "held_y", "pressed"), ("size",)):
            size = max(abs(expected[name]) for name in group)
            for name in group:
                near(first[name], expected[name], size, f"scene {scene}, {name}")
        near(first["kept"], 0.3, 1, f"scene {scene}, the state")
        found = []
        for times in ("0", "1e-25"):
            run(folder, RESTING.format(**some, times=times, bound="(0.02 + abs(damp.xi))", time=time, t="t", state=path, more=", kept = integral(tip, path)",
                                       moving=moving.format(of="u'.nu", seen=seen).replace(" + integral(tip, slow^0(u'; v))", "")))
            found.append(rows(folder)[-1])
        assert found[0]["kept"] > 0.3, found
        for name in found[0]:
            near(found[0][name], found[1][name], max(abs(found[1]["held_x"]), 1), f"scene {scene}, no law and hardly any, {name}", 1e-7)
    belt = RESTING.format(t="t", times=1, cells=2, young=100, element="P1", pull=0, stiff=100, bound=0.02, state=path, time="for t in [0, 1] by 2 steps from u = static", moving=moving.format(of="u'.nu", seen="u' - [0.1, 0]"), more="")
    said = run(folder, belt, succeeds=False)
    assert "exerts a force" in said and "rub" in said, said


BETWEEN = """mesh body = rectangle(2, 1, cells = [4, 2])
part wall = body.left
part ground = body.bottom
tensor A = isotropic(lambda = 1, mu = 2)
tensor B = isotropic(young = 100, poisson = 0.3)
superpotential layer(r) = 50*pos(r)^2
space V = vector P1 on body, zero on wall
space W = scalar P1 on body, zero on wall
find u in V, theta in W for t in [0, 1] by 5 steps from {start} using scheme = {scheme}, interpolant = {interpolant}
such that for all v in V, eta in W
    {mass}integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
  + integral(body, theta'*eta + dot(grad(theta), grad(eta)))
 >= integral(body, dot([0, -1 - t], v)) + integral(body, 3*eta)
report
  table u = u.y at [2, 0], rate = u'.y at [2, 0], theta = theta at [2, 0], change = theta' at [2, 0], force = layer.xi at [2, 0], held = reaction(wall).y, pressed = integral(ground, layer.xi) from start
  table {timed} to "timed.csv"
"""


def check_between_steps(folder):
    """In the first step from what is known at its start, else what holds at its end; at the start what is known there."""
    columns = {"u": "u.y at [2, 0]", "rate": "u'.y at [2, 0]", "theta": "theta at [2, 0]", "change": "theta' at [2, 0]", "force": "layer.xi at [2, 0]",
               "held": "reaction(wall).y", "pressed": "integral(ground, layer.xi)"}
    times = [0, 0.05, 0.2, 0.33, 0.95]
    timed = ", ".join(f"{name}{i} = {what} at t = {t}" for name, what in columns.items() for i, t in enumerate(times))
    given, static = "u = 0, u' = [0, -0.1*x], theta = 0", "u = static, theta = static"
    for scheme, start, known in (("newmark", given, set(columns)), ("newmark", static, set(columns)), ("bdf2", given, {"u", "rate", "theta"}), ("midpoint", given, {"u", "rate", "theta"}),
                                 ("hht", given, set(columns) - {"held"}), ("backward_euler", "u = 0, theta = 0", {"u", "theta"}), ("bdf2", static, set(columns))):
        for interpolant in ("affine", "constant"):
            mass = "integral(body, dot(u'', v)) + " if "u'" in start or scheme == "newmark" else ""
            run(folder, BETWEEN.format(start=start, scheme=scheme, interpolant=interpolant, mass=mass, timed=timed))
            ends, found = rows(folder), rows(folder, "timed")[-1]
            for name in columns:
                assert (ends[0][name] is not None) == (name in known), f"{scheme}, {name} at the start: {ends[0][name]}"
                of_step = name == "held" and scheme in ("hht", "midpoint")
                for i, t in enumerate(times):
                    n = max(1, math.ceil(t * 5 - 1e-9))
                    before, after = ends[n - 1][name], ends[n][name]
                    share = 1.0 if t > 0 and (interpolant == "constant" or of_step or before is None) else 5 * t - (n - 1)
                    told = f"{scheme} from {start}, {interpolant}: {name} at {t}"
                    if share == 0 and before is None:
                        assert found[f"{name}{i}"] is None, told
                        continue
                    near(found[f"{name}{i}"], after if share == 1 else (1 - share) * before + share * after, max(abs(row[name] or 0) for row in ends), told, 1e-12)


TIMED = """mesh body = rectangle(2, 1, cells = [4, 2])
part wall = body.left
part ground = body.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential layer(r) = 20*pos(r)^2
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] by 4 steps from {start}
such that for all v in V
    {inertia}integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(body, dot([0, -1 - t], v))
report
  table {columns}
  line {values} from [0, 0.5] to [2, 0.5] by 3 points at t = 0 to "line.csv"
"""
ASKED = {"place": "u.y at [2, 0]", "rate": "u'.y at [2, 0]", "held": "reaction(wall).y", "pressed": "integral(ground, layer.xi)", "worst": "largest(body, mises(sigma))"}


def check_columns_of_the_start(folder):
    """Columns with a time of their own in the first step against the rows of its ends."""
    mass = "integral(body, dot(u'', v)) + "
    balanced = [("u = static", ""), ("u = 0, u' = [0, 0.3*x] using scheme = newmark", mass)]
    others = [("u = [0, 0.001*x]", ""), ("u = 0, u' = [0, 0.3*x] using scheme = bdf2", mass), ("u = 0, u' = [0, 0.3*x] using scheme = midpoint", mass)]
    for start, inertia in balanced + others:
        columns = [f"{name} = {what}" for name, what in ASKED.items()]
        for name, when in (("begins", 0), ("between", 0.05)):
            columns += [f"{key}_{name} = {what} at t = {when}" for key, what in ASKED.items()]
        text = TIMED.format(start=start, inertia=inertia, columns=", ".join(columns) + " from start", values="u.y, u'.y")
        run(folder, text)
        first, second, *_ = rows(folder)
        for key in ASKED:
            known = first[key] is not None
            assert known or (start, inertia) in others and key in ("rate", "held", "pressed"), f"{start}: {key} is not known"
            if known:
                near(first[f"{key}_begins"], first[key], 1, f"{start}: {key} at t = 0", 1e-13)
            else:
                assert first[f"{key}_begins"] is None, f"{start}: {key} at t = 0 is not known"
            if key == "worst":
                continue  # no affine function of the solution
            of_step = not known or key == "held" and "midpoint" in start
            between = second[key] if of_step else 0.8*first[key] + 0.2*second[key]
            near(second[f"{key}_between"], between, 1 + abs(between), f"{start}: {key} within the first step", 1e-12)
        if inertia:
            end = [float(v) for v in (folder / "out" / "line.csv").read_text().splitlines()[-1].split(",")]
            near(end[-1], 0.6, 1, f"{start}: the velocity of a line at the initial time", 1e-13)


CHANGES = """param now = 0
mesh body = rectangle(2, 1, cells = [{cells}, 3])
part wall = body.left
part tip = body.right
part ground = body.bottom
tensor B = {tensor}
fn g(s) = {g}
superpotential layer(r) = {stiff}*pos(r)^2
space V = vector {element} on body, zero on wall
find u in V {time}
such that for all v in V
    {factor}*integral(body, g({s}) * B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(tip, dot([0.3, -1 - {s}], v))
report
  table a = u.y at [2, 0.5], b = u.x at [1, 1], c = integral(ground, layer.xi), held = reaction(wall), s = integral(body, sigma.xx)
"""


def check_changing_stiffness(folder, scenes=6):
    """Without rates each step is a problem of its own: that of the stiffness then."""
    rng = random.Random(413)
    for scene in range(scenes):
        some = {"cells": rng.randint(3, 6), "stiff": 10 ** rng.uniform(0, 3), "element": rng.choice(["P1", "P2"]), "factor": rng.choice(["1", "2.5"]),
                "g": rng.choice(["1 + s^2", "exp(-s)*(1 + x)", "2 - cos(5*s)"]),
                "tensor": rng.choice(["isotropic(young = 100, poisson = 0.3)", "orthotropic(E1 = 200, E2 = 50, E3 = 50, nu12 = 0.3, nu23 = 0.2, nu13 = 0.3, G12 = 30, G23 = 20, G13 = 30)"])}
        t0, end = rng.choice([(0, 1), (0.5, 2), (-1, 1)])
        run(folder, CHANGES.format(**some, s="t", time=f"for t in [{t0}, {end}] by 4 steps from u = static using scheme = {rng.choice(['backward_euler', 'bdf2'])}"))
        for row in rows(folder):
            run(folder, CHANGES.format(**some, s="now", time=""), "-D", f"now={row['t']!r}", name="one")
            expected = rows(folder, "one")[-1]
            for group in (("a", "b"), ("c", "held_x", "held_y"), ("s",)):
                size = max(abs(expected[name]) for name in group)
                for name in group:
                    near(row[name], expected[name], size, f"scene {scene} at {row['t']}, {name}", 1e-8)


def check_changing_viscosity(folder):
    """a(t) B : eps(u') + b(t) B : eps(u) = f: a scalar recurrence, and with BDF2 order 2 to the solution of the equation."""
    text = BAR.replace("integral(body, B :", "integral(body, (2 + sin(3*t)) * B :").replace("from u = static", "from u = 0").replace("by 20 steps", "by N steps")
    text = "param N = 20\nparam f = 1\n" + text.format(more=" using scheme = {scheme}", terms=" + integral(body, (1 + t^2) * B : eps(u') : eps(v))", columns="")
    static = BAR.format(more="", terms="", columns="")
    run(folder, static)
    unit = rows(folder)[0]["a"]
    run(folder, text.format(scheme="backward_euler"), "--json", str(folder / "told.json"))
    notes = json.loads((folder / "told.json").read_text())["notes"]
    assert notes == [], notes  # one solution: each step's matrix has a factor, and there are no laws
    u, k = 0.0, 0.1
    for n, row in enumerate(rows(folder)[1:], 1):
        t = 1 + n * k
        u = (1 + (1 + t * t) / k * u) / ((1 + t * t) / k + 2 + math.sin(3 * t))
        near(row["a"], u * unit, abs(unit), "viscosity that changes", 1e-10)
    exact, steps = 0.0, 20000
    for n in range(steps):  # Runge and Kutta's, of order 4
        t, h = 1 + 2 * n / steps, 2 / steps
        rate = lambda s, x: (1 - (2 + math.sin(3 * s)) * x) / (1 + s * s)  # noqa: E731
        k1 = rate(t, exact)
        k2 = rate(t + h / 2, exact + h / 2 * k1)
        k3 = rate(t + h / 2, exact + h / 2 * k2)
        k4 = rate(t + h, exact + h * k3)
        exact += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    errors = []
    for n in (20, 40):
        run(folder, text.format(scheme="bdf2"), "-D", f"N={n}")
        errors.append(abs(rows(folder)[-1]["a"] / unit - exact))
    assert 1.8 < math.log2(errors[0] / errors[1]) < 2.3, errors


def check_notes_of_changing_forms(folder):
    """Laws that soften are not compared with the matrix of every step, and a run says so; convex ones need no note."""
    some = dict(cells=4, tensor="isotropic(young = 100, poisson = 0.3)", g="1 + s^2", stiff="2", element="P1", factor="1", s="t",
                time="for t in [0, 1] by 4 steps from u = 0")
    text = CHANGES.format(**some)
    softening = text.replace("superpotential layer(r) = 2*pos(r)^2", "superpotential layer(r) with slope\n  | r < 0 -> 0\n  | r < 0.01 -> 4*r\n  | otherwise -> 0.05 - r")
    assert softening != text
    for script, expected in ((text, []), (softening, ["laws soften while the forms change in time"])):
        run(folder, script, "--json", str(folder / "told.json"))
        notes = [note["what"] for note in json.loads((folder / "told.json").read_text())["notes"]]
        found = [words for words in ("laws soften while the forms change in time", "the forms change in time and are not symmetric")
                 if any(words in note for note in notes)]
        assert found == expected, notes


def main():
    for check in (check_changing_reactions, check_changing_quadrature, check_static_start, check_sums, check_creep, check_start_beside_mean_loads, check_columns_at_the_first_time, check_rest, check_rest_of_states, check_refusals, check_rows, check_laws_at_rest, check_between_steps, check_columns_of_the_start, check_changing_stiffness, check_changing_viscosity, check_notes_of_changing_forms):
        with tempfile.TemporaryDirectory() as folder:
            check(pathlib.Path(folder))
            print("ok", check.__name__)


main()
