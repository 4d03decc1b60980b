"""Laws of numbers and their mirror images: j(r) on u.nu and j(-r) on -u.nu are one problem.

usage: mirrored.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

A block whose wall and ground share an edge, with a law that rises: straight pieces, jumps up, curved ones, walls (1e300) on
either side, at 0 as well, where held nodes touch them. Both scripts have the same one solution, and are certified. Where held
nodes are beyond a wall the program says so.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

BOUND = 1e-9  # of the largest displacement, and of the largest multiplier


def number(v):
    return repr(float(v))


def law(random, length, force):
    """Breaks, and the slope of each piece as (start, growth, curve): start + growth*s + curve*(e^s - 1), s = r/length."""
    breaks = np.unique(np.append(np.sort(random.uniform(-1, 1, random.integers(0, 3))) * length, 0.0))
    at = random.uniform(-1, 0.2) * force
    low_wall, high_wall = random.random(2) < 0.5
    pieces, before = [], breaks[0] / length
    for k in range(len(breaks) + 1):
        end = breaks[min(k, len(breaks) - 1)] / length
        growth, curve = random.choice([0.0, 1.0]) * random.uniform(0, 2) * force, random.choice([0.0, 1.0]) * random.uniform(0, 1) * force
        value = lambda s: growth * s + curve * np.expm1(s)
        at += random.choice([0.0, 1.0]) * random.uniform(0, 1) * force
        pieces.append((at - value(before), growth, curve))
        at, before = at + (value(end) - value(before) if k < len(breaks) else 0.0), end
    if low_wall:
        pieces[0] = (-1e300, 0.0, 0.0)
    if high_wall:
        pieces[-1] = (1e300, 0.0, 0.0)
    return breaks, pieces


def text(breaks, pieces, length, sign):
    """The slope of j(sign r)."""
    s = f"(r*{number(sign / length)})"
    cases = []
    for start, growth, curve in pieces:
        case = number(sign * start)
        if growth:
            case += f" + {number(sign * growth)}*{s}"
        if curve:
            case += f" + {number(sign * curve)}*(exp({s}) - 1)"
        cases.append(case)
    ends = list(breaks)
    if sign < 0:
        cases, ends = cases[::-1], [-b for b in ends[::-1]]
    return "with slope\n" + "\n".join(f"  | r < {number(b)} -> {c}" for b, c in zip(ends, cases)) + f"\n  | otherwise -> {cases[-1]}"


def script(random_of, sign):
    random = np.random.default_rng(random_of)
    dim = int(random.choice([2, 2, 3]))
    length, force = 0.3, 10.0 ** random.uniform(-0.5, 0.7) * 0.2
    breaks, pieces = law(random, length, force)
    cells = [int(n) for n in random.integers(1, 4, dim)]
    shape = f"rectangle(2, 1, cells = {cells}" if dim == 2 else f"box(2, 1, 1, cells = {cells}"
    pull = [number(v) for v in random.normal(size=dim) * 0.5]
    nodes = [[2 * i / cells[0], 0] + ([k / cells[2]] if dim == 3 else [])
             for i in range(cells[0] + 1) for k in range(cells[2] + 1 if dim == 3 else 1)]
    columns = [f"u{k}{c} = u.{c} at {[float(v) for v in p]}" for k, p in enumerate(nodes) for c in "xyz"[:dim]]
    columns += [f"xi{k} = j.xi at {[float(v) for v in p]}" for k, p in enumerate(nodes) if p[0] > 0]
    u, v = ("u.nu", "v.nu") if sign > 0 else ("-u.nu", "-v.nu")
    return f"""mesh body = {shape})
part held = body.left
part ground = body.bottom
tensor B = isotropic(lambda = {number(random.uniform(0, 1))}, mu = {number(random.uniform(0.3, 1))})
superpotential j(r) {text(breaks, pieces, length, sign)}
space V = vector P1 on body, zero on held
find u in V
such that for all v in V
  integral(body, B : eps(u) : eps(v)) + integral(ground, j^0({u}; {v})) >= integral(ground, dot([{', '.join(pull)}], v))
report
  table {', '.join(columns)}
"""


def impossible(sign):
    """A held node beyond the wall, with Coulomb's friction beside it, whose bound is what the wall cannot say."""
    laws = ["superpotential j(r) with slope | r < 0.1 -> -1e300 | otherwise -> 0", "superpotential j(r) with slope | r > -0.1 -> 1e300 | otherwise -> 0"]
    u = "u.nu" if sign > 0 else "-u.nu"
    return f"""mesh body = rectangle(2, 1, cells = [2, 1])
part held = body.left
part ground = body.bottom
tensor B = isotropic(lambda = 1, mu = 1)
{laws[sign < 0]}
superpotential rub(w) = 0.3*abs(j.xi)*norm(w)
space V = vector P1 on body, zero on held
find u in V
such that for all v in V
  integral(body, B : eps(u) : eps(v)) + integral(ground, j^0({u}; {u.replace('u.', 'v.')}) + rub^0(u.tau; v.tau)) >= integral(ground, dot([0, -1], v))
report
  table y = u.y at [2, 0]
"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--keep")
    options = parser.parse_args()
    bad = 0
    chosen = [int(k) for k in options.only.split(",")] if options.only else range(options.scenes)
    with tempfile.TemporaryDirectory() as temporary:
        for sign in (1, -1):
            path = pathlib.Path(temporary) / "impossible.hvi"
            path.write_text(impossible(sign))
            run = subprocess.run([options.program, "run", path, "--no-files", "--quiet"], capture_output=True, text=True)
            if run.returncode != 3 or "imposed values take" not in run.stderr:
                bad += 1
                print(f"impossible {sign:+}: {run.returncode}, {' '.join(run.stderr.split())[:200]}")
        for k in chosen:
            answers = []
            for sign in (1, -1):
                path = pathlib.Path(options.keep or temporary) / f"scene{k}{'+-'[sign < 0]}.hvi"
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(script([options.seed, k], sign))
                run = subprocess.run([options.program, "run", path, "--no-files", "--quiet", "--json", path.with_suffix(".json")],
                                     capture_output=True, text=True)
                if run.returncode != 0:
                    bad += 1
                    print(f"scene {k} {sign:+}: refused: {' '.join(run.stderr.split())[:200]}")
                    break
                answers.append(json.loads(path.with_suffix(".json").read_text())["final"])
            if len(answers) < 2:
                continue
            here, there = answers
            for kind, sign in (("u", 1), ("xi", -1)):
                names = [n for n in here if n.startswith(kind)]
                size = max([abs(here[n]) for n in names] + [1e-3])
                off = max([abs(here[n] - sign * there[n]) for n in names] + [0.0]) / size
                if not off <= BOUND:
                    bad += 1
                    print(f"scene {k}: {kind} differs by {off:.1e}")
    print(f"{len(chosen)} scenes, {bad} bad")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
