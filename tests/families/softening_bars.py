"""Bars in a row that lose their stiffness under a pull, on random scenes: each bar by its own cubic equation.

usage: softening_bars.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

All bars of a row have the same stress s(t), and bar i loses d_i' = a_i (s / (1 - d_i))^2 of its stiffness, up to a limit. A step of
backward Euler, d = d_before + k a_i s^2 / (1 - d)^2, has the smallest root from d_before on for the solution that continues the last one;
where there is none (beyond 4/27 of a bar without losses) the bar goes to its limit. The program must find these, tell that the states
may have jumped where a bar did after a long way, and must not tell it where none did. In 1D, 2D and 3D, by both solvers.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from orientation import asked_for, number

AGREES = 1e-8
SURELY_LONG = 3.5  # ways over what the states wanted at first: beyond 3 the program asks for their branch


class Scene:
    def __init__(self, random):
        self.dim, self.bars = int(random.choice([1, 1, 2, 3])), int(random.integers(1, 6))
        self.size, self.stiff = 10 ** random.uniform(-4, 4), 10 ** random.uniform(-6, 9)
        self.limit = random.uniform(0.7, 0.97)
        inner = np.sort(random.uniform(0.1, 0.9, int(random.integers(0, 5))))
        self.times = np.array([0.0, *inner, 1.0]) if random.random() < 0.5 else np.linspace(0, 1, len(inner) + 2)
        self.pull = 10 ** random.uniform(-3, 0)  # strain without losses at the end
        # Of a step at the end: on both sides of 4/27.
        k = self.times[-1] - self.times[-2]
        self.a = 10 ** random.uniform(-2.5, 0.5, self.bars) / (k * self.pull**2)
        self.solver = str(random.choice(["direct", "direct", "iterative"])) if self.dim > 1 else "direct"

    def step(self, before, a, force):
        """The smallest root of d = before + force / (1 - d)^2 from `before` on, or the limit."""
        f = lambda d: d - before - force / (1 - d) ** 2
        top = min(max(1 - (2 * force) ** (1 / 3), before), self.limit)  # f grows up to there
        if f(top) < 0:
            return self.limit
        low, high = before, top
        for _ in range(200):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if f(middle) < 0 else (low, middle)
        return high

    def reference(self):
        """Losses after every step; in which steps a bar jumped, and in which of them the way was long."""
        d, out, jumps, long = np.zeros(self.bars), [], [], []
        for n in range(1, len(self.times)):
            force = (self.times[n] - self.times[n - 1]) * self.a * (self.pull * self.times[n]) ** 2
            new = np.array([self.step(x, a, f) for x, a, f in zip(d, self.a, force)])
            wants = np.clip(d + force / (1 - d) ** 2, 0, self.limit) - d
            jumped = new - d - force / (1 - new) ** 2 < -1e-9
            jumped &= [self.step_ends(x, f) for x, f in zip(d, force)]
            way = new - d
            if jumped.any():
                jumps.append(n)
                if way @ way > SURELY_LONG * abs(way @ wants):
                    long.append(n)
            out.append(new)
            d = new
        return np.array(out), jumps, long

    def step_ends(self, before, force):
        """Is there no root below the limit?"""
        top = min(max(1 - (2 * force) ** (1 / 3), before), self.limit)
        return top < self.limit and top - before - force / (1 - top) ** 2 < 0

    def script(self):
        cells, box = f"cells = {self.bars}", f"interval({number(self.size)}"
        if self.dim == 2:
            cells, box = f"cells = [{self.bars}, 2]", f"rectangle({number(self.size)}, {number(self.size)}"
        if self.dim == 3:
            cells, box = f"cells = [{self.bars}, 1, 1]", f"box({number(self.size)}, {number(self.size)}, {number(self.size)}"
        at = lambda i: number(self.size * (i + 1) / self.bars)
        cases = "".join(f"  | x < {at(i)} -> {number(self.a[i] * self.size**2)}\n" for i in range(self.bars - 1))
        last = number(self.a[-1] * self.size**2)
        strength = f"fn a() =\n{cases}  | otherwise -> {last}\n" if cases else f"fn a() = {last}\n"
        middle = ["[" + ", ".join(number(v) for v in [self.size * (i + 0.4) / self.bars, *[0.3 * self.size] * (self.dim - 1)]) + "]"
                  for i in range(self.bars)]
        columns = ", ".join(f"d{i} = d at {m}" for i, m in enumerate(middle))
        times = ", ".join(number(t) for t in self.times)
        pull = number(self.pull / self.size * self.stiff)
        return f"""mesh row = {box}, {cells})
part hold = row.left
part grip = row.right
{strength}state d on row with rate a()*norm(grad(u))^2 from d = 0 in [0, {number(self.limit)}]
space V = scalar P1 on row, zero on hold
find u in V for t in [0, 1] at [{times}] from u = 0 using solver = {self.solver}
such that for all v in V
    integral(row, {number(self.stiff)}*(1 - d)*dot(grad(u), grad(v)))
  = integral(grip, {pull}*t*v)
report
  table {columns}
"""


def judge(program, folder, scene):
    """What is wrong, or None; the number of jumps."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.hvi").write_text(scene.script())
    done = subprocess.run([program, "run", "scene.hvi", "--no-files", "--quiet", "--json", "out.json"], cwd=folder, capture_output=True, text=True)
    expected, jumps, long = scene.reference()
    if done.returncode != 0:
        return f"exit {done.returncode}: {' '.join(done.stderr.split())[:300]}", len(jumps)
    result = json.loads((folder / "out.json").read_text())
    found = np.array([result["table"][f"d{i}"] for i in range(scene.bars)]).T
    error = float(np.abs(found - expected).max())
    if not error <= AGREES:
        return f"losses off by {error:.1e}: {found.tolist()}, expected {expected.tolist()}", len(jumps)
    told = [note["step"] for note in result["notes"] if "was not followed from" in note["what"]]
    if not set(long) <= set(told) <= set(jumps):
        return f"jumps in steps {jumps}, long ones {long}, told {told}", len(jumps)
    return None, len(jumps)


def main():
    options = asked_for()
    wrong = jumped = 0
    asked = range(options.scenes) if options.only is None else options.only
    for k in asked:
        scene = Scene(np.random.default_rng([options.seed, k]))
        with tempfile.TemporaryDirectory() as temporary:
            said, jumps = judge(options.program, (options.keep or pathlib.Path(temporary)) / str(k), scene)
        jumped += jumps > 0
        if said:
            wrong += 1
            print(f"scene {k}: {scene.dim}D, {scene.bars} bars, {scene.solver}: {said}", file=sys.stderr)
    print(f"{jumped} scenes with jumps")
    print(f"family softening_bars: scenes {len(asked)}, wrong {wrong}")
    return 0 if wrong == 0 and (options.only or jumped >= len(asked) // 4) else 1


if __name__ == "__main__":
    sys.exit(main())
