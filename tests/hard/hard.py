"""The hard cases: every script of this folder over the values that make it hard, each with numbers.

usage: hard.py HVI_RUN [CASE ...]          prints one line a figure: case, what, figure, bound
       hard.py HVI_RUN --write FILE        all of them, and the page docs/stability.md
The kind of every reference value stands beside its case (analytic, published, property).
"""
import math
import pathlib
import random
import sys
import tempfile

import suite as shared
from suite import Suite, case, cases, certified, failures, here, judge, relative, worst


@case
def uniqueness(suite):
    """Towards the loss of uniqueness and past it, from two starts (analytic)."""
    name = "uniqueness"
    for m in (0.9, 0.99, 0.999, 1 - 1e-6):
        for script, load, exact, peaks in (("column.hvi", 0.5 + (1 - m) * 0.1, 0.2, (0.3, 2.0)),
                                           ("shear.hvi", 1 + (1 - m) * 0.3, 0.3, (0.9, 2.0))):
            ends = [suite.run(script, m=m, load=load, peak=peak, steps=20) for peak in peaks]
            if not all(certified(name, f"{script} m = {m}", e) for e in ends):
                continue
            r = [e["final"]["r"] for e in ends]
            # |u - v| <= (errors of both certificates) / (1 - m); forces are of size 1.
            errors = sum(max(e["certificate"]["equilibrium"], e["certificate"]["inclusion"]) + 4e-16 for e in ends)
            bound = 4 * errors / (1 - m)
            judge(name, f"{script} m = 1 - {1 - m:.0e}: two starts apart", abs(r[0] - r[1]), bound)
            judge(name, f"{script} m = 1 - {1 - m:.0e}: error", max(abs(x - exact) for x in r), bound)
    for m in (1.01, 2.0):
        for load in (0.2, 1.0):  # on the rising part and beyond the descent: both answers are known
            data = suite.run("column.hvi", m=m, load=load, peak=1.5, steps=20)
            if not certified(name, f"column.hvi m = {m}", data):
                continue
            far = load - 0.4 + 0.2 * m
            near = load / 5
            r, energy = data["final"]["r"], data["final"]["energy"]
            stored = 2 * near**2 if load < 0.3 else 0.1 - 0.02 * m + (0.4 - 0.2 * m) * (far - 0.3)
            exact = near if load < 0.3 else far
            past_one(name, f"column.hvi m = {m} load {load}", data, r, exact, 4 * (exact**2 / 2 + stored - load * exact))
            judge(name, f"column.hvi m = {m} load {load}: energy by the table", relative(energy, data["energy"] / 4), 1e-12)
        data = suite.run("shear.hvi", m=m, load=1.1, peak=1.6, steps=20)
        if certified(name, f"shear.hvi m = {m}", data):
            exact = 0.1 + 0.5 * m
            stored = 0.5 - 0.125 * m + (1 - 0.5 * m) * (exact - 0.5)
            past_one(name, f"shear.hvi m = {m}", data, data["final"]["r"], exact, 4 * (exact**2 / 2 + stored - 1.1 * exact))


def past_one(name, what, data, answer, exact, energy):
    judge(name, f"{what}: branch", relative(answer, exact), 1e-11)
    judge(name, f"{what}: says `not guaranteed` (0: yes)", data["uniqueness"] != "not guaranteed", 0)
    judge(name, f"{what}: energy of the branch", relative(data["energy"], energy), 1e-12)


@case
def static(suite):
    """Towards the loss of uniqueness and past it in static problems, normal law and friction (analytic)."""
    name = "static"
    for script, source, load_of, branch in (("column.hvi", "push(t)", lambda m: 0.5 + (1 - m) * 0.1, 0.2),
                                            ("shear.hvi", "pull(t)", lambda m: 1 + (1 - m) * 0.3, 0.3)):
        text = (suite.folder / script).read_text()
        still = "still_" + script
        (suite.folder / still).write_text(text.replace(" for t in [0, 1] by steps steps", "").replace(source, "load").replace("fn load =", f"fn {source} ="))
        for m in (0.9, 0.99, 0.999, 1 - 1e-6):
            data = suite.run(still, m=m, load=load_of(m))
            if certified(name, f"{still} m = {m}", data):
                errors = max(data["certificate"]["equilibrium"], data["certificate"]["inclusion"]) + 4e-16
                judge(name, f"{still} m = 1 - {1 - m:.0e}: error", abs(data["final"]["r"] - branch), 8 * errors / (1 - m))
                judge(name, f"{still} m = 1 - {1 - m:.0e}: iterations", data["plan"]["newton"], 20)
                judge(name, f"{still} m = 1 - {1 - m:.0e}: says `guaranteed` (0: yes)", data["uniqueness"] != "guaranteed", 0)
        for m in (1.01, 2.0):
            data = suite.run(still, m=m, load=1.5)
            if certified(name, f"{still} m = {m}", data):
                if script == "column.hvi":
                    exact, stored = 1.1 + 0.2 * m, lambda r: 0.1 - 0.02 * m + (0.4 - 0.2 * m) * (r - 0.3)
                else:
                    exact, stored = 0.5 + 0.5 * m, lambda r: 0.5 - 0.125 * m + (1 - 0.5 * m) * (r - 0.5)
                past_one(name, f"{still} m = {m}", data, data["final"]["r"], exact,
                         4 * (exact**2 / 2 + stored(exact) - 1.5 * exact))


@case
def strip(suite):
    """The delamination strip to 30 MPa and back (published; properties)."""
    name = "strip"
    one = suite.run("strip.hvi", F=26.2e6, back=0, steps=8)
    if certified(name, "26.2 MPa", one):
        judge(name, "26.2 MPa: u_y against .99732 mm (published)", abs(one["final"]["u_y"] - 0.99732e-3), 1e-8)
        judge(name, "26.2 MPa: energy against -.13714406 (published)", abs(one["final"]["energy"] + 0.13714406), 1e-8)
    snapped = suite.run("strip.hvi", F=27e6, back=0, steps=27)
    if certified(name, "27 MPa", snapped):
        judge(name, "27 MPa: snapped, 5 mm / u_y", 5e-3 / snapped["final"]["u_y"], 1)
        last = [n for n in snapped["notes"] if n.get("step") == 27]
        judge(name, "27 MPa: marked as an event (0: yes)", 0 if last else 1, 0)
    for steps in (60, 240, 960):
        data = suite.run("strip.hvi", steps=steps)
        if not certified(name, f"up and back in {steps} steps", data):
            continue
        judge(name, f"up and back in {steps} steps: u left at the end, m", abs(data["final"]["u_y"]), 1e-14)
        half = steps // 2
        judge(name, f"{steps} steps: u_y at 30 MPa by another path", relative(
            data["table"]["u_y"][half - 1], suite.run("strip.hvi", back=0, steps=30)["final"]["u_y"]), 1e-10)
    data = suite.run("strip.hvi", "--monitors", F=30e6, steps=60)
    if certified(name, "20 to 30 MPa and back", data):
        t, m = data["table"], data["monitors"]
        judge(name, "to 30 MPa and back: energy of the monitors against the table's integrals",
              worst(m["energy"], t["energy"]), 1e-10)
        judge(name, "to 30 MPa and back: work that is lost all in all against the work done",
              relative(m["lost"][-1], m["work"][-1]), 1e-10)
        judge(name, "to 30 MPa and back: balance of work and energies", m["balance_error"], 1e-10)
        judge(name, "the marks of the table are the events of the monitors", sum(a != b for a, b in zip(t["event"], m["events"])), 0)
        up, down = t["load"].index(20e6), len(t["load"]) - 1 - t["load"][::-1].index(20e6)
        judge(name, "20 MPa: still released on the way back (u_y before / after)", t["u_y"][up] / t["u_y"][down], 0.9)
        losses = [b - a for a, b in zip([0.0] + m["lost"], m["lost"])]
        judge(name, "steps that release many points lose energy: least loss, negative", -min(
            loss for loss, n in zip(losses, m["events"]) if n > 5), 0)
    low = suite.run("strip.hvi", F=26.2e6, back=0, steps=8, choice="least_energy")
    if certified(name, "least energy", low):
        judge(name, "least energy lies below the continued branch (J)",
              max(a - b for a, b in zip(low["table"]["energy"], one["table"]["energy"])), 1e-12)


@case
def friction(suite):
    """Set-valued friction (properties)."""
    name = "friction"
    static = dict(viscosity=0, cycles=0.5, press=0.0, weaken=0.0, steps=32)
    free, none = suite.run("slide.hvi", bound=0, **static), suite.run("slide.hvi", bound=1e-300, **static)
    if certified(name, "no bound", free) and certified(name, "bound 1e-300", none):
        judge(name, "bound 0 against bound 1e-300", worst(none["table"]["u_x"], free["table"]["u_x"]), 1e-12)
        judge(name, "retraced: u_x at t = 1/4 and 3/4", relative(free["table"]["u_x"][7], free["table"]["u_x"][23]), 1e-11)
    held = suite.run("slide.hvi", bound=1e12, **static)
    if certified(name, "bound 1e12", held):
        judge(name, "bound 1e12: slip", max(map(abs, held["table"]["g_x"])), 0)
    some = suite.run("slide.hvi", **static)
    if certified(name, "reversal", some):
        g = some["table"]["g_x"]
        judge(name, "reversal of the load: the curve is retraced", worst(g[:15], g[30:15:-1]), 1e-11)
    for decades in (4, 8):
        data = suite.run("slide.hvi", decades=decades, n=16, steps=32)
        certified(name, f"bound over {decades} decades", data)
        if data:
            judge(name, f"bound over {decades} decades: certificate", data["certificate"]["equilibrium"], 1e-10)
    many = suite.run("slide.hvi", **{**static, "cycles": 200, "steps": 3200, "n": 4})
    if certified(name, "200 cycles", many):
        u = many["table"]["u_x"]
        judge(name, "200 cycles, 3200 steps: first and last cycle", worst(u[-16:-1], u[:15]), 1e-10)
    for n, steps in ((2, 100), (4, 20)):
        turn = suite.run("turn.hvi", n=n, steps=steps)
        if not certified(name, "turning slip", turn):
            continue
        x, z = turn["table"]["g_x"], turn["table"]["g_z"]
        start = steps // 5 - 1
        half = (steps - 1 - start) // 2
        judge(name, f"full circle, n = {n}: end against start", abs(x[-1] - x[start]) / abs(x[start]), 1e-10)
        judge(name, f"full circle, n = {n}: half a turn changes the sign",
              max(abs(z[i] + z[i + half]) for i in range(start, start + half)) / max(map(abs, z)), 1e-10)


def layers_by_hand(upper, lower, spring, viscosity, T, steps):
    """Series of a Kelvin-Voigt half, an elastic half and the ground: backward Euler in closed form."""
    k, a, b = T / steps, 2 * upper, 2 * lower
    middle, out = 0.0, []
    for i in range(1, steps + 1):
        load, c = i / steps, 2 * viscosity / k
        # force in the halves: (a + c) m - c m0 = b (f - m) = load - spring f
        # eliminated without differences of large numbers
        series = spring * b / (b + spring)
        middle = (load * b / (b + spring) + c * middle) / (a + c + series)
        out.append((middle, (load + b * middle) / (b + spring)))
    return out


@case
def stiff_soft(suite):
    """Ratios of stiffness, compliance, viscosity and step (analytic)."""
    name = "stiff_soft"
    grid = [dict(upper=1e8), dict(lower=1e8), dict(upper=1e-8), dict(lower=1e-8)]
    grid += [dict(spring=10.0**e) for e in range(-6, 13, 3)]
    grid += [dict(viscosity=10.0**e) for e in (-12, -6, 6, 12)]
    grid += [dict(viscosity=1.0, T=10.0**e) for e in (-10, -5, 1)]
    base = dict(upper=1.0, lower=1.0, spring=1.0, viscosity=0.0, T=1.0, steps=4)
    for change in grid:
        values = {**base, **change}
        what = ", ".join(f"{k} {v:.0e}" for k, v in change.items())
        for n in (2, 16):
            data = suite.run("layers.hvi", n=n, **values)
            if not certified(name, what, data):
                continue
            error = max(max(relative(m, x), relative(f, y)) for m, f, (x, y) in zip(
                data["table"]["middle"], data["table"]["foot"], layers_by_hand(**values)))
            ratio = max(values["upper"] / values["lower"], values["lower"] / values["upper"], 1.0)
            judge(name, f"{what}, {n} elements high: error", error, 1e-12 * n * n * ratio)


@case
def signorini(suite):
    """Towards Signorini: the penetration falls as 1 / stiffness (slope of the theory: 1)."""
    name = "signorini"
    depth = {}
    for e in range(4, 13, 2):
        data = suite.run("slide.hvi", stiffness=10.0**e, press=0.01, pull=0.01, bound=1e-3, n=8)
        if certified(name, f"stiffness 1e{e}", data):
            depth[e] = max(abs(y) for y in data["table"]["u_y"])
    for e in range(4, 11, 2):
        if e in depth and e + 2 in depth:
            slope = math.log10(depth[e] / depth[e + 2]) / 2
            judge(name, f"stiffness 1e{e} to 1e{e + 2}: distance of the slope from 1", abs(slope - 1), 0.02)


@case
def patch(suite):
    """Nearly incompressible, thin and stretched: uniform strain is exact (analytic)."""
    name = "patch"
    for degree in ("P1", "P2"):
        for poisson in (0.3, 0.4999, 0.499999):
            for long in (1e-4, 1, 1e4):
                for spring in (1.0, 1e6):
                    data = suite.run("patch.hvi", degree=degree, poisson=poisson, long=float(long), spring=spring)
                    what = f"{degree} poisson {poisson} length {long:.0e} spring {spring:.0e}"
                    if not certified(name, what, data):
                        continue
                    foot = 0.01 / (1 + spring)
                    side = -poisson / (1 - poisson) * foot * long
                    error = max(relative(data["final"]["foot"], foot), relative(data["final"]["side"], side))
                    # Both the stretch and the bulk against the shear stiffness worsen the condition.
                    condition = max(long, 1 / long) * max(1, 1e-5 / (1 - 2 * poisson))
                    judge(name, f"{what}: error", error, 1e-10 * condition)


@case
def units(suite):
    """Units of stress and length from 1e-100 to 1e100: the same answer, scaled (property)."""
    name = "units"
    one = suite.run("slide.hvi")
    for stress, length in ((1e100, 1.0), (1e-100, 1.0), (1.0, 1e100), (1.0, 1e-100), (1e100, 1e-100), (1e-100, 1e100),
                           (1e-100, 1e-100), (1e100, 1e100), (3e9, 1e-3), (7e-5, 123.0)):
        data = suite.run("slide.hvi", stress=stress, length=length)
        what = f"stress {stress:.0e}, length {length:.0e}"
        if certified(name, what, data):
            judge(name, what, max(worst([x / length for x in data["table"][c]], one["table"][c])
                                  for c in ("u_x", "g_x", "u_y")), 1e-12)


@case
def cycles(suite):
    """Many cycles of the load with viscosity and memory: bounded, periodic in the end (property)."""
    name = "cycles"
    data = suite.run("slide.hvi", n=2, press=0.0, weaken=0.0, cycles=1000, steps=16000, T=100.0)
    if certified(name, "1000 cycles, 16000 steps", data):
        u = data["table"]["u_x"]
        judge(name, "1000 cycles: the last two differ by", worst(u[-32:-16], u[-16:]), 1e-9)
        judge(name, "1000 cycles: size of the last by the first", max(map(abs, u[-16:])) / max(map(abs, u[:16])), 1.05)


def renumbered(source, target, seed):
    """A mesh file with its nodes and elements in another order (MSH 2.2 text)."""
    lines = source.read_text().split("\n")
    nodes, elements = lines.index("$Nodes"), lines.index("$Elements")
    count = int(lines[nodes + 1])
    order = list(range(1, count + 1))
    random.Random(seed).shuffle(order)
    new = {i + 1: order[i] for i in range(count)}
    points = {new[int(line.split()[0])]: line.split()[1:] for line in lines[nodes + 2:nodes + 2 + count]}
    cells = [line.split() for line in lines[elements + 2:elements + 2 + int(lines[elements + 1])]]
    random.Random(seed + 1).shuffle(cells)
    out = lines[:nodes + 2] + [" ".join([str(i), *points[i]]) for i in range(1, count + 1)] + ["$EndNodes", "$Elements", str(len(cells))]
    for i, cell in enumerate(cells, 1):
        first = 3 + int(cell[2])
        out.append(" ".join([str(i), *cell[1:first], *(str(new[int(v)]) for v in cell[first:])]))
    target.write_text("\n".join(out + ["$EndElements", ""]))


@case
def noise(suite):
    """The last place of the input, repetition, renumbering (properties)."""
    name = "noise"
    one, again = suite.run("slide.hvi"), suite.run("slide.hvi")
    judge(name, "the same run repeated: bits that differ", sum(a != b for c in one["table"] for a, b in zip(
        one["table"][c], again["table"][c])), 0)
    for key, value in (("bound", 0.5), ("pull", 3.0), ("press", 1.0), ("length", 1.0), ("stress", 1.0), ("viscosity", 1.0)):
        moved = suite.run("slide.hvi", **{key: math.nextafter(value, 10)})
        # A step's problem amplifies by at most 1 / (1 - step ratio), about 3 here; 16 steps, n = 8.
        judge(name, f"`{key}` moved by one unit in the last place", worst(moved["table"]["u_x"], one["table"]["u_x"]), 1e-13)
    two = suite.run("slide.hvi", "--threads", 2)
    judge(name, "two threads against one: bits that differ", sum(a != b for c in one["table"] for a, b in zip(
        one["table"][c], two["table"][c])), 0)
    mesh = suite.folder / "zigzag_33x5.msh"
    kept = mesh.read_text()
    for load in (26.2e6, 30e6):
        base = suite.run("strip.hvi", F=load, back=0, steps=30)
        for seed in (1, 2, 3):
            renumbered(here.parent / "data" / "zigzag_33x5.msh", mesh, seed)
            other = suite.run("strip.hvi", F=load, back=0, steps=30)
            mesh.write_text(kept)
            if certified(name, f"renumbered ({seed}), {load:.1e} Pa", other):
                judge(name, f"nodes and elements renumbered ({seed}), {load:.1e} Pa",
                      worst(other["table"]["u_y"], base["table"]["u_y"]), 1e-10)


import broken  # noqa: E402  more cases, in files of their own
import more  # noqa: E402
import shapes  # noqa: E402

LONG = {"million", "many_cycles"}  # label `long`; not in the page


def main():
    program, *wanted = sys.argv[1:]
    page = here.parent.parent / "docs" / "stability.md"
    writes = wanted[:1] == ["--write"]
    for name in [c for c in cases if c not in LONG] if writes else wanted or cases:
        with tempfile.TemporaryDirectory() as folder:
            cases[name](Suite(program, folder))
        if not writes and name not in LONG:
            failures.extend(shared.differs_from(page, name))
    if writes:
        for name in LONG:
            cases.pop(name)
        pathlib.Path(wanted[1]).write_text(shared.document(pathlib.Path(wanted[1])))
    if failures:
        sys.exit(f"{len(failures)} failed: " + "; ".join(failures))


if __name__ == "__main__":
    main()
