"""Random scenes whose loads read states of the body, against the same scenes with a second unknown that is 1 everywhere.

usage: state_loads.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

A load F(z) D(v) is the form F(z) w D(v) of an unknown w = 1: that problem has other matrices (of two unknowns, factored by
LU), another Newton's method for its states (by the forms), and no load that reads a state. Both runs are certified, and
every number of their tables agrees to 1e-8 of its column's largest value. Scenes: 1D, 2D, 3D and bodies of revolution, P1
and P2, one to three states whose rates read strains, values, stresses, time and each other, loads before v and before its
gradient, on either side, on the whole body or a part of it; all schemes, means of loads, memories, laws with and without
friction, supports that move.
"""
import json
import random
import subprocess

from orientation import seeded

AGREE = 1e-8


def mesh(r, dim):
    if dim == 1:
        return "interval(1.5, cells = 5)"
    if dim == 2:
        return f"rectangle(1.5, 1, cells = [{r.randint(2, 4)}, {r.randint(2, 3)}])"
    if dim == 3:
        return "box(1, 1, 1, cells = [2, 2, 2])"
    return "rectangle(1, 1, cells = [3, 2], axisymmetric = true)"


def scene(seed):
    r = random.Random(seed)
    dim = r.choice([1, 2, 2, 2, 3, "ring"])
    d = {1: 1, 3: 3}.get(dim, 2)
    order = r.choice(["P1", "P1", "P2"]) if dim != 3 else "P1"
    up = "xyz"[d - 1]
    strains = {1: ["xx"], 2: ["xx", "yy", "xy"], 3: ["xx", "yy", "zz", "xy", "xz"]}[d] + (["zz"] if dim == "ring" else [])
    scheme = r.choice(["backward_euler", "backward_euler", "bdf2", "newmark", "hht", "midpoint"])
    moves = scheme in ("newmark", "hht", "midpoint")
    part = "inner" if d > 1 and dim != "ring" and r.random() < 0.3 else "body"
    n_states = r.randint(1, 3)
    states = [f"z{i}" for i in range(n_states)]
    rates = []
    for i in range(n_states):
        terms = [f"{r.uniform(-3, 3):.3f}*eps(u).{r.choice(strains)}", f"{r.uniform(0.1, 4):.3f}*(0.2*sin(3*t) - {states[i]})"]
        if r.random() < 0.4:
            terms.append(f"{r.uniform(-1, 1):.3f}*{r.choice(states)}*{r.choice(states)}")
        if i == 0 or r.random() < 0.3:  # a value: both problems have Gauss's points
            terms.append(f"{r.uniform(-2, 2):.3f}*u.{up}")
        if r.random() < 0.2:
            terms.append(f"{r.uniform(0.01, 0.1):.3f}*pos(abs(sigma.{r.choice(strains)}) - 0.5)")
        if r.random() < 0.2:
            terms.append(f"{r.uniform(-1, 1):.3f}*u'.{up}")
        rates.append(" + ".join(terms))
    # The start of the motion has the forms at the initial states, which are integrated exactly.
    initial, place = ("0.05", "1.3") if moves else ("0.05*x", "(1 + x)")
    loads = []
    for _ in range(r.randint(1, 3)):
        value = r.choice([f"{r.uniform(-6, 6):.3f}*{r.choice(states)}", f"{r.uniform(-4, 4):.3f}*sin(2*{r.choice(states)} + t)",
                          f"{r.uniform(-4, 4):.3f}*{place}*{r.choice(states)}*{r.choice(states)}"])
        test = r.choice([f"eps(v).{r.choice(strains)}", "div(v)", f"v.{up}", f"2*v.{'xyz'[r.randrange(d)]}"])
        # What stands on the right is no stress: no rate would be the same.
        loads.append((r.choice([True, False]) or "sigma" in " ".join(rates), f"({value})", test))
    law = r.choice(["", "", "unilateral", "compliance", "friction"]) if d > 1 else r.choice(["", "compliance"])
    average = r.random() < 0.2
    memory = r.random() < 0.3
    moving = r.random() < 0.3
    n = r.choice([4, 7, 10])

    def along(values):  # nothing moves away from the axis
        return ["0"] + values[1:] if dim == "ring" else values

    def script(unit):
        lines = [f"mesh body = {mesh(random.Random(seed + 1), dim)}", "part hold = body." + ("right" if d == 1 else "top"),
                 "part ground = body." + ("left" if d == 1 else {2: "bottom", 3: "bottom"}[d])]
        if part == "inner":
            lines.append("part inner = body where x < 0.8")
        if d > 1:
            lines.append("tensor B = isotropic(young = 60, poisson = 0.3)\ntensor A = isotropic(young = 2, poisson = 0.2)")
        if memory:
            lines.append("kernel q(lag) = -1.5*exp(-2*lag)")
        for name, rate in zip(states, rates):
            lines.append(f"state {name} on {part} with rate {rate} from {name} = {initial}")
        if law == "unilateral":
            lines.append("import contact\nsuperpotential layer(r) = unilateral(r, gap = 0.002)")
        elif law:
            lines.append("superpotential layer(r) = 30*pos(r)^2")
        if law == "friction":
            lines.append("superpotential slip(w) = 0.05*norm(w)")
        lines.append(f"space V = vector {order} on body, zero on hold")
        if unit:
            lines.append("space W = scalar P1 on body")
        held = f" with u = [{', '.join(along(['0.01*t'] * d))}] on hold" if moving else ""
        motion = ", u' = 0" if moves and not moving else ""
        start = "u = 0" if not moving else f"u = [{', '.join(['0'] * d)}]"
        if moves and moving:
            motion = f", u' = [{', '.join(along(['0.01'] * d))}]"
        lines.append(f"find u in V{', w in W' if unit else ''}{held} for t in [0, 1] by {n} steps from {start}{motion}"
                     f"{', w = 1' if unit else ''}\n  using scheme = {scheme}{', load = average' if average else ''}")
        lines.append(f"such that for all v in V{', q1 in W' if unit else ''}")
        elastic = "integral(body, B : eps(u) : eps(v))" if d > 1 else "integral(body, 60*eps(u).xx*eps(v).xx)"
        viscous = "integral(body, A : eps(u') : eps(v))" if d > 1 else "integral(body, 2*eps(u').xx*eps(v).xx)"
        left = [elastic, viscous]
        if moves:
            left.append("integral(body, 0.7*dot(u'', v))")
        if memory:
            left.append("integral(body, dot(history(q, u), v))")
        if law:
            left.append("integral(ground, layer^0(%s; %s))" % (("-u.x", "-v.x") if d == 1 else (f"-u.{up}", f"-v.{up}")))
        if law == "friction":
            left.append("integral(ground, slip^0(u'.tau; v.tau))")
        right = [f"integral(body, {'dot([%s], v)' % ', '.join(['1.2*sin(2*t)'] * (d - 1) + ['-2*t'])})"]
        for on_left, value, test in loads:
            (left if on_left else right if not unit else left).append(
                f"integral({part}, {'' if on_left or not unit else '-'}{value}*{'w*' if unit else ''}{test})")
        if unit:
            left.append("integral(body, w*q1)")
            right.append("integral(body, q1)")
        sign = ">=" if law else "="
        lines.append("    " + "\n  + ".join(left) + f"\n {sign} " + " + ".join(right))
        middle = {1: "[0.4]", 2: "[0.4, 0.3]", 3: "[0.4, 0.3, 0.6]"}[d]
        probes = [f"a{i} = u.{c} at {middle}" for i, c in enumerate("xyz"[:d])] + \
                 [f"s{i} = integral({part}, {name})" for i, name in enumerate(states)] + ["r = reaction(hold)"]
        if law:
            probes.append("xi = integral(ground, layer.xi)")
        lines.append("report\n  table " + ", ".join(probes))
        return "\n".join(lines) + "\n"

    return script(False), script(True)


def run(program, folder, name, script):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.hvi").write_text(script)
    done = subprocess.run([program, "run", f"{name}.hvi", "--no-files", "--quiet", "--json", f"{name}.json"], cwd=folder,
                          capture_output=True, text=True, timeout=300)
    path = folder / f"{name}.json"
    return done, json.loads(path.read_text()) if path.exists() else None


def compare(program, folder, seed):
    loads, forms = scene(seed)
    (done, a), (other, b) = run(program, folder, "loads", loads), run(program, folder, "forms", forms)
    if done.returncode != 0 or other.returncode != 0:
        return f"exit codes {done.returncode} and {other.returncode}: {(done.stderr or other.stderr).splitlines()[0]}"
    if not (a["certificate"]["certified"] and b["certificate"]["certified"]):
        return "not certified"
    # What the report holds from the initial state on: the first row is before the first step.
    worst = 0.0
    for column, values in a["table"].items():
        size = max([abs(v) for v in values if v is not None] + [1e-6])
        for one, two in zip(values, b["table"][column]):
            if one is not None and two is not None:
                worst = max(worst, abs(one - two) / size)
    return None if worst <= AGREE else f"apart by {worst:.1e}"


if __name__ == "__main__":
    seeded(compare, scenes=40)
