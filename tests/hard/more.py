"""Hard cases: kernels, jumps, element sizes, compliance towards zero, long runs, the bounds of Lemma 3.2."""
import math

from suite import case, certified, judge, relative, worst


def direct_sum(weights, steps, T, eta, b):
    """(eta/k) (u_n - u_{n-1}) + b u_n + sum_j w[n - j] u_j = f(t_n), u_0 = 0."""
    k, u = T / steps, []
    for n in range(1, steps + 1):
        past = math.fsum(weights[n - j] * u[j - 1] for j in range(1, n))
        last = u[-1] if u else 0.0
        u.append((math.sin(3 * (n / steps) + 0.5) + eta / k * last - past) / (eta / k + b + weights[0]))
    return u


def exponential(size, rate, k, steps):
    return [size * math.exp(-rate * i * k) * -math.expm1(-rate * k) / rate for i in range(steps)]


def singular(size, power, k, steps):
    p = 1 - power  # lag^p grows so slowly for power .99 that differences need expm1
    return [size * k**p / p if i == 0 else size * (i * k)**p * math.expm1(p * math.log1p(1 / i)) / p for i in range(steps)]


def cosine(size, rate, k, steps):
    return [size * 2 / rate * math.cos(rate * (i + 0.5) * k) * math.sin(rate * k / 2) for i in range(steps)]


@case
def kernels(suite):
    """Kernels that are stiff, growing, alternating, singular, fast, or cancel the elasticity (analytic)."""
    name = "kernels"
    steps, T = 64, 1.0
    k = T / steps
    grid = [(f"relaxation time 1e{e} of the step", dict(kind=1, size=-0.5, rate=10.0**-e / k), 1.0,
             exponential(-0.5, 10.0**-e / k, k, steps)) for e in range(-8, 9, 4)]
    grid += [(f"growing exp({g} lag)", dict(kind=1, size=-0.1, rate=-float(g)), 1.0, exponential(-0.1, -g, k, steps)) for g in (1, 20)]
    grid += [("alternating, changes sign every step", dict(kind=3, size=0.9, rate=math.pi / k), 1.0, cosine(0.9, math.pi / k, k, steps))]
    grid += [(f"fast oscillation, {w:.0e} a step", dict(kind=3, size=0.9, rate=w / k), 1.0, cosine(0.9, w / k, k, steps)) for w in (1e2, 1e4)]
    grid += [(f"lag^-{p}", dict(kind=2, size=-0.005, power=p), 1.0, singular(-0.005, p, k, steps)) for p in (0.5, 0.9, 0.99)]
    grid += [("a weight of the whole elasticity within 1e-8 of the step", dict(kind=1, size=-0.5e8 / k, rate=1e8 / k), 1.0,
              exponential(-0.5e8 / k, 1e8 / k, k, steps))]
    # long-time modulus b - size/rate towards 0: what the memory takes off leaves ever less
    grid += [(f"long-time modulus {left:.0e} of the elasticity", dict(kind=1, size=-100 * (1 - left), rate=100.0), 1.0,
              exponential(-100 * (1 - left), 100.0, k, steps)) for left in (1e-2, 1e-6, 1e-12)]
    for what, values, b, weights in grid:
        exact = direct_sum(weights, steps, T, 0.0, b)
        # Rounding of a weight moves u by up to the growth of the recursion: sum of |w| against the modulus.
        growth = max(map(abs, exact)) * max(1.0, sum(map(abs, weights)))
        for route in ("automatic", "direct", "tree"):
            data = suite.run("kernels.hvi", steps=steps, route=route, **values)
            if not certified(name, f"{what}, {route}", data):
                continue
            loose = any(h["route"] == "fit" for h in data["plan"]["history"])
            judge(name, f"{what}, {route}: error", worst(data["table"]["u"], exact), max(min(1e-12 * growth, 1e-6), 1e-7 if loose else 0))


@case
def jumps(suite):
    """A jump up at zero on which contact rests, a jump down at which it is released, both met in one step (analytic)."""
    name = "jumps"
    data = suite.run("jumps.hvi", steps=40)
    if certified(name, "up and back", data):
        t, far, error, rest = data["table"], False, 0.0, 0
        for load, r in zip(t["load"], t["r"]):
            far = load > 0.7 - 1e-9 if not far else load > 0.3 + 1e-9
            exact = load - 0.1 if far else max(0.0, (load - 0.3) / 2)
            at_a_jump = min(abs(load - 0.7), abs(load - 0.3)) < 1e-9  # there both answers are solutions
            error = max(error, 0.0 if at_a_jump else abs(r - exact))
            rest += load < 0.3 - 1e-9 and r == 0.0
        judge(name, "up and back in 40 steps: error", error, 1e-12)
        judge(name, "contact rests at the jump exactly: steps that do not, of 12", 12 - rest, 1)
        judge(name, "release and return are marked: events missing", 2 - sum(e != 0 for e in t["event"]), 0)
    for load in (0.1, 0.5, 1.0, 5.0):
        data = suite.run("jumps.hvi", load=load, back=0, steps=1)
        if certified(name, f"one step to {load}", data):
            exact = load - 0.1 if load > 0.7 else max(0.0, (load - 0.3) / 2)
            judge(name, f"all jumps on the way in one step to load {load}: error", abs(data["final"]["r"] - exact), 1e-12)


def write_graded(path, xs, ys):
    """MSH 2.2 of a rectangle cut into triangles on given lines."""
    n, m = len(xs), len(ys)
    node = lambda i, j: j * n + i + 1
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "5", '1 1 "bottom"', '1 2 "right"', '1 3 "top"',
             '1 4 "left"', '2 5 "body"', "$EndPhysicalNames", "$Nodes", str(n * m)]
    lines += [f"{node(i, j)} {xs[i]!r} {ys[j]!r} 0" for j in range(m) for i in range(n)] + ["$EndNodes", "$Elements"]
    cells = [f"1 2 1 1 {node(i, 0)} {node(i + 1, 0)}" for i in range(n - 1)]
    cells += [f"1 2 3 3 {node(i, m - 1)} {node(i + 1, m - 1)}" for i in range(n - 1)]
    cells += [f"1 2 4 4 {node(0, j)} {node(0, j + 1)}" for j in range(m - 1)]
    cells += [f"1 2 2 2 {node(n - 1, j)} {node(n - 1, j + 1)}" for j in range(m - 1)]
    for j in range(m - 1):
        for i in range(n - 1):
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            cells += [f"2 2 5 5 {a} {b} {c}", f"2 2 5 5 {a} {c} {d}"]
    lines += [str(len(cells))] + [f"{i} {cell}" for i, cell in enumerate(cells, 1)] + ["$EndElements", ""]
    path.write_text("\n".join(lines))


@case
def sizes(suite):
    """Element sizes that differ by 1e5 in one mesh, with the aspects that brings (analytic: uniform strain)."""
    name = "sizes"
    for decades in (2, 5):
        for both in (False, True):
            fine = [0.0] + [10.0**(decades * (i / 12 - 1)) for i in range(13)]
            write_graded(suite.folder / "graded.msh", fine if both else [i / 4 for i in range(5)], fine)
            for degree in ("P1", "P2"):
                for poisson in (0.3, 0.4999):
                    data = suite.run("graded.hvi", degree=degree, poisson=poisson)
                    what = f"sizes over 1e{decades} in {'both directions' if both else 'the height'}, {degree}, poisson {poisson}"
                    if certified(name, what, data):
                        foot = 0.01 / 2
                        error = max(relative(data["final"]["foot"], foot),
                                    relative(data["final"]["side"], -poisson / (1 - poisson) * foot))
                        judge(name, f"{what}: error", error, 1e-15 * 10**(decades + 1) * max(1, 1 / (1 - 2 * poisson)))


@case
def compliance(suite):
    """Compliance towards zero: the error against the exact unilateral law falls as the compliance (theory: slope 1)."""
    name = "compliance"
    exact = suite.run(suite.changed("punch.hvi", "unilateral.hvi", ("layer^0(", "hard^0("), (
        "superpotential layer(r) with slope stiffness*max(r, 0)", "superpotential hard(r) = unilateral(r)")))
    if not certified(name, "unilateral", exact):
        return
    error = {}
    for e in range(2, 11):
        data = suite.run("punch.hvi", stiffness=10.0**e)
        if certified(name, f"stiffness 1e{e}", data):
            error[e] = math.sqrt(sum((data["final"][c] - exact["final"][c])**2 for c in exact["final"]))
    for e in range(3, 8):
        if e in error and e + 1 in error:
            judge(name, f"compliance 1e-{e} to 1e-{e + 1}: distance of the slope from 1",
                  abs(math.log10(error[e] / error[e + 1]) - 1), 0.05)
    for e in (8, 9, 10):
        if e in error:
            judge(name, f"compliance 1e-{e}: error", error[e], 1e-1 * 10.0**-e + 1e-14)


@case
def lemma(suite):
    """The four quantities of Lemma 3.2 over k, k/2, ..., k/64: bounded, the same within 5 % (property)."""
    name = "lemma"
    base, first = None, 64
    for halvings in range(7):
        steps = first << halvings
        data = suite.run("slide.hvi", "--monitors", n=4, steps=steps)
        if not certified(name, f"k/{1 << halvings}", data):
            continue
        now = {q: data["monitors"][f"lemma_{q}"][-1] for q in ("u", "xi", "rate", "jumps")}
        now["jumps"] *= 1 << halvings  # the sum of squares itself falls as k: bounded a fortiori
        base = base or now
        for q, what in (("u", "max |u|"), ("xi", "max |xi|"), ("rate", "sum k |du/k|^2"), ("jumps", "sum |du|^2 / k")):
            judge(name, f"k/{1 << halvings}: {what}, change against k", abs(now[q] / base[q] - 1), 0.05)
        judge(name, f"k/{1 << halvings}: balance of work and energies", data["monitors"]["balance_error"], 1e-11)


@case
def health(suite):
    """What a run says of itself: energies against closed forms, the line of health, events (analytic)."""
    name = "health"
    data = suite.run("column.hvi", "--monitors", m=0.9, load=1.0, peak=0.5, steps=20)
    if certified(name, "column", data):
        m, t = data["monitors"], data["table"]
        judge(name, "column.hvi: energy against the script's own integrals", worst(m["energy"], [4 * e for e in t["energy"]]), 1e-13)
        judge(name, "column.hvi: a convex problem loses no energy to events: steps marked", sum(m["events"]) + sum(m["snap"]), 0)
        judge(name, "column.hvi: says `guaranteed` (0: yes)", data["uniqueness"] != "guaranteed", 0)
    said = suite.call("column.hvi", "-o", "out", m=0.9, steps=20).stdout
    judge(name, "the line of health is printed (0: yes)", "certified: all 20 steps, worst inclusion" not in said, 0)
    said = suite.call("column.hvi", "-o", "out", m=1.5, load=1.0, peak=1.5, steps=20).stdout
    for words in ("not guaranteed", "snap", "energy of this branch", "1 step followed its branch"):
        judge(name, f"past one the report says `{words}` (0: yes)", words not in said, 0)


@case
def stability(suite):
    """`hvi-run stability`: conditioning, margins, sensitivity and a verdict for the scripts of this folder (properties)."""
    import json

    import jsonschema

    from suite import here
    name = "stability"
    schema = json.loads((here.parent.parent / "docs" / "schema" / "hvi-stability-1.schema.json").read_text())
    for script, values, verdict, margin in (("column.hvi", dict(m=0.9, steps=10), "stable", 0.1),
                                            ("shear.hvi", dict(m=0.99, steps=10), "stable", 0.01),
                                            ("column.hvi", dict(m=2.0, steps=10, peak=1.5, load=0.7), "not guaranteed", -1.0),
                                            ("jumps.hvi", dict(steps=10), "not guaranteed", None)):
        what = f"{script} {' '.join(f'{k} {v}' for k, v in values.items())}"
        done = suite.call(script, "--json", "stability.json", "-o", "out", command="stability", **values)
        judge(name, f"{what}: exit code", done.returncode, 0)
        if done.returncode != 0:
            print(done.stderr)
            continue
        report = json.loads((suite.folder / "stability.json").read_text())
        jsonschema.validate(report, schema)
        judge(name, f"{what}: the verdict begins with `{verdict}` (0: yes)", not report["verdict"].startswith(verdict + ":"), 0)
        if margin is not None:
            judge(name, f"{what}: step margin against 1 - m", abs(report["margins"]["step"] - margin), 1e-9)
        moved = [v["change"] for v in report["variations"] if v["of"] == "input"]
        judge(name, f"{what}: inputs moved by one unit in the last place, none (0: some)", not moved, 0)
        if verdict == "stable":
            judge(name, f"{what}: condition 1 / margin times that bounds the change", max(moved), 2e-15 / margin)
        picture = suite.folder / "out" / f"{script[:-4]}_stability.png"
        judge(name, f"{what}: the picture is a PNG (0: yes)", picture.read_bytes()[:4] != b"\x89PNG", 0)


@case
def million(suite):
    """A million steps with memory: no drift from the closed form of the recursion (analytic)."""
    name = "million"
    steps, T, rate, size = 1_000_000, 1.0, 50.0, -25.0
    data = suite.run("kernels.hvi", steps=steps, rate=rate, size=size, every=1000)
    if certified(name, "a million steps", data):
        k, s, u = T / steps, 0.0, []
        weight, decay = size * -math.expm1(-rate * k) / rate, math.exp(-rate * k)
        for n in range(1, steps + 1):
            s *= decay
            now = (math.sin(3 * (n / steps) + 0.5) - s) / (1 + weight)
            s += weight * now
            if n % 1000 == 0:
                u.append(now)
        judge(name, "a million steps: error", worst(data["table"]["u"], u), 1e-10)


@case
def many_cycles(suite):
    """1e4 cycles of the load with friction, viscosity and memory: bounded energy, the same cycle for ever (property)."""
    name = "many_cycles"
    per, cycles = 8, 10_000
    data = suite.run("slide.hvi", "--monitors", n=2, press=0.0, weaken=0.0, cycles=cycles, steps=per * cycles, T=1000.0)
    if certified(name, "1e4 cycles", data):
        energy, u = data["monitors"]["energy"], data["table"]["u_x"]
        early = max(map(abs, energy[:20 * per]))
        judge(name, "energy of all cycles by that of the first twenty", max(map(abs, energy)) / early, 1.001)
        judge(name, "the last two cycles differ by", worst(u[-2 * per:-per], u[-per:]), 1e-9)
        judge(name, "balance of work and energies", data["monitors"]["balance_error"], 1e-11)
