"""Random scenes whose loads read states of the body: what their energy report says.

usage: state_energies.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

Bars of a few cells: every column of `--monitors` is summed up again here, cell by cell, from integrals of the loads and from the
strains that the table has, for backward Euler, whose forces are those of the end of a step. Blocks and rings: where nothing but the
scheme dissipates, what is lost is of the first order in the step, and with bdf2 at least that.
"""
import json
import random
import subprocess

from orientation import seeded

AGREE = 1e-9  # of the largest of the energies
TIMES = 2.0   # less with half the step


def states_of(r, strains, up):
    lines, names = [], [f"z{i}" for i in range(r.randint(1, 2))]
    for i, name in enumerate(names):
        terms = [f"{r.uniform(0.5, 3) * r.choice([-1, 1]):.3f}*eps(u).{r.choice(strains)}", f"{r.uniform(0.3, 2):.3f}*(0.3*sin(2*t) - {name})"]
        if r.random() < 0.4:
            terms.append(f"{r.uniform(-1, 1):.3f}*{r.choice(names)}*{r.choice(names)}")
        if r.random() < 0.4:
            terms.append(f"{r.uniform(-1, 1):.3f}*u.{up}")
        lines.append(f"state {name} on body with rate {' + '.join(terms)} from {name} = {r.choice(['0', '0.1', '0.05*x'])}")
    return lines, names


def value_of(r, names):
    size = r.uniform(2, 6) * r.choice([-1, 1])
    return r.choice([f"{size:.3f}*{r.choice(names)}", f"{size:.3f}*sin(2*{r.choice(names)} + t)", f"{size:.3f}*(1 + x)*{r.choice(names)}"])


def run(program, folder, name, script, *options):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.hvi").write_text(script)
    done = subprocess.run([program, "run", f"{name}.hvi", "--no-files", "--quiet", "--monitors", "--json", f"{name}.json", *options],
                          cwd=folder, capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        raise RuntimeError(done.stderr.splitlines()[0])
    return json.loads((folder / f"{name}.json").read_text())


def bar(program, folder, seed):
    r = random.Random(seed)
    cells, length, steps = r.randint(2, 5), r.uniform(0.5, 2), r.choice([3, 6, 11])
    young, viscosity = r.uniform(20, 80), r.choice([0, r.uniform(0.5, 3)])
    lines, names = states_of(r, ["xx"], "x")
    loads = [(r.choice([1, -1]), f"({value_of(r, names)})") for _ in range(r.randint(1, 2))]  # 1: on the right
    force = f"{r.uniform(-3, 3):.3f}*sin(3*t)"
    h = length / cells
    script = [f"mesh body = interval({length}, cells = {cells})", "part hold = body.left"]
    script += [f"part c{i} = body where x > {(i - 0.1) * h} and x < {(i + 1.1) * h}" for i in range(cells)]
    script += lines + ["space V = vector P1 on body, zero on hold", f"find u in V for t in [0, 1] by {steps} steps from u = 0", "such that for all v in V"]
    left = [f"integral(body, {young}*eps(u).xx*eps(v).xx)"] + ([f"integral(body, {viscosity}*eps(u').xx*eps(v).xx)"] if viscosity else [])
    left += [f"integral(body, {value}*eps(v).xx)" for side, value in loads if side < 0]
    right = [f"integral(body, {force}*v.x)"] + [f"integral(body, {value}*eps(v).xx)" for side, value in loads if side > 0]
    script.append("    " + "\n  + ".join(left) + "\n  = " + " + ".join(right))
    columns = ["push = " + force, "whole = integral(body, u.x)"] + [f"e{i} = integral(c{i}, eps(u).xx)" for i in range(cells)]
    columns += [f"s{i} = integral(c{i}, {' + '.join(f'({side})*{value}' for side, value in loads)})" for i in range(cells)]
    script.append("report\n  table " + ", ".join(columns))
    result = run(program, folder, "bar", "\n".join(script) + "\n")
    table, told = result["table"], result["monitors"]
    work = viscous = lost = elastic = worst = 0.0
    before = [0.0] * (cells + 1)
    mine = {name: [] for name in ("work", "viscous", "elastic", "lost")}
    for n in range(len(table["t"])):
        now = [table[f"e{i}"][n] / h for i in range(cells)] + [table["whole"][n]]
        d = [a - b for a, b in zip(now, before)]
        done = table["push"][n] * d[-1] + sum(table[f"s{i}"][n] * d[i] for i in range(cells))
        rubbed = sum(viscosity * h * d[i] ** 2 for i in range(cells)) * steps
        stored = sum(0.5 * young * h * now[i] ** 2 for i in range(cells))
        work, viscous, lost = work + done, viscous + rubbed, lost + done - rubbed - (stored - elastic)
        elastic, before = stored, now
        for name, value in zip(mine, (work, viscous, elastic, lost)):
            mine[name].append(value)
    size = max(abs(v) for values in mine.values() for v in values)
    for name, values in mine.items():
        worst = max(abs(a - b) for a, b in zip(values, told[name])) / size
        if len(values) != len(told[name]) or worst > AGREE:
            return f"{name} of a bar is apart by {worst:.1e}"
    return None


def block(program, folder, seed):
    r = random.Random(seed)
    ring, scheme = r.random() < 0.4, r.choice(["backward_euler", "backward_euler", "bdf2"])
    lines, names = states_of(r, ["xx", "yy", "xy"] + (["zz"] if ring else []), "y")
    left = ["integral(body, B : eps(u) : eps(v))"]
    right = [f"integral(body, dot([{'0' if ring else '1.2*sin(2*t)'}, -2*t], v))"]
    for _ in range(r.randint(1, 2)):
        test = r.choice(["eps(v).xx", "eps(v).xy", "div(v)", "v.y"])
        (left if r.random() < 0.6 else right).append(f"integral(body, ({value_of(r, names)})*{test})")
    script = "\n".join(["param N = 8", f"mesh body = rectangle(1.5, 1, cells = [3, 2]{', axisymmetric = true' if ring else ''})", "part hold = body.top",
                        "tensor B = isotropic(young = 60, poisson = 0.3)", *lines, f"space V = vector {r.choice(['P1', 'P2'])} on body, zero on hold",
                        f"find u in V for t in [0, 1] by N steps from u = static\n  using scheme = {scheme}", "such that for all v in V",
                        "    " + "\n  + ".join(left) + "\n  = " + " + ".join(right), "report\n  table a = u.y at [0.7, 0]"]) + "\n"
    found = []
    for steps in (20, 40, 80):
        told = run(program, folder, "block", script, "-D", f"N={steps}")["monitors"]
        if scheme == "backward_euler" and min(told["lost"]) < 0:
            return f"a block gains {-min(told['lost']):.1e}"
        found.append(abs(told["lost"][-1]) / max(abs(v) for name in ("work", "elastic") for v in told[name]))
    if found[-1] < 1e-10:
        return None
    for a, b in zip(found, found[1:]):
        if not (a / b > 0.9 * TIMES and (a / b < 1.1 * TIMES or scheme == "bdf2")):
            return f"what a block loses with {scheme} is not of the first order: {found}"
    return None


def judge(program, folder, seed):
    try:
        return (block if seed % 3 == 0 else bar)(program, folder, seed)
    except RuntimeError as refused:
        return str(refused)


if __name__ == "__main__":
    seeded(judge, scenes=24)
