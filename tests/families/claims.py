"""Random small problems whose forms are not symmetric, with walls, jumps and laws that soften: is one solution promised only where there is one?

usage: claims.py HVI_RUN [--scenes N] [--seed S]

One to three scalars on a block, each with diffusion and a mass, that act on each other or are carried along by a flow, of any size and
sign, at one time or in steps of different lengths; a rigid wall, a bounded force that jumps or one that falls acts on some of them at
nodes of one side. The matrices are assembled here, S = K_cc - K_cI K_II^-1 K_Ic on the points c of laws. With walls a step has one solution
for every load if and only if each principal minor of S is positive (as M. Kojima and R. Saigal, On the number of solutions to a class of
linear complementarity problems, 1979, tell); where forces fall with the slope -m, so must be those minors with all of these points and -m w
added or not on the diagonal, for the forces that loads need are linear on pieces which have these determinants, and one of another sign is
a fold. Wrong: `check` says "exactly one solution" or a run "guaranteed" where one is not, or both do not say so where one or two unknowns
act on each other and sym W (K - D) is positive definite, D the steepest falls, W those weights of the equations for which couplings of
different signs cancel (of three the program's weights are not the best ones). References: independent.
"""
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import orientation
from fields import Scalar
from orientation import number
from solids import block, shapes, slopes

NAMES, TESTS = ("u", "p", "q"), ("v", "eta", "zeta")


class Scene:
    def __init__(self, random):
        self.count = int(random.integers(1, 4))
        self.mesh = block(random, [int(n) for n in random.integers(1, 4, 2)], random.uniform(0.5, 2.0, 2), 0.2)
        self.scalar = Scalar(self.mesh, 1)
        self.diffusion, self.capacity = 10 ** random.uniform(-1, 1, (2, self.count))
        self.couplings = random.normal(size=(self.count, self.count)) * 10 ** random.uniform(-2, 2) * (1 - np.eye(self.count))
        if random.random() < 0.5:
            self.couplings *= 10 ** random.uniform(-2, 2, self.couplings.shape)
        elif random.random() < 0.5:
            self.couplings = self.couplings + self.couplings.T
        elif random.random() < 0.4:
            self.couplings = self.couplings - self.couplings.T
        self.flow = random.normal(size=2) * 10 ** random.uniform(-1, 3) if self.count == 1 else np.zeros(2)
        self.laws = [str(random.choice(["unilateral(r)", "with slope | r < 0 -> -1 | otherwise -> 1"])) for _ in range(self.count)]
        self.falls = np.zeros(self.count)
        for b in range(self.count):
            if random.random() < 0.3:
                m = self.falls[b] = (self.capacity[b] + self.diffusion[b]) * 10 ** random.uniform(-2, 1)
                self.laws[b] = f"with slope | r < 0 -> 0 | r < 1 -> {number(-m)}*r | otherwise -> {number(-m)}"
        self.rates, self.steps = np.zeros(self.count), np.ones(1)
        if random.random() < 0.4:
            self.rates, self.steps = 10 ** random.uniform(-2, 0, self.count), np.round(10 ** random.uniform(-1, 0, int(random.integers(2, 5))), 3)
        self.with_law = [b for b in range(self.count) if random.random() < 0.8] or [0]

    def carried(self):
        """int (flow . grad u) v"""
        out = np.zeros((self.scalar.n, self.scalar.n))
        for cell, volume, barycentric in self.scalar.cells():
            for b, weight in self.scalar.rule:
                out[np.ix_(cell, cell)] += weight * volume * np.outer(shapes(1, b), (slopes(1, b) @ barycentric) @ self.flow)
        return out

    def matrix(self, step):
        """Of a step of this length."""
        mass, stiffness = self.scalar.mass_and_stiffness()
        blocks = [[self.couplings[a, b] * mass for b in range(self.count)] for a in range(self.count)]
        for a in range(self.count):
            blocks[a][a] = self.diffusion[a] * stiffness + (self.capacity[a] + self.rates[a] / step) * mass + self.carried()
        return np.block(blocks)

    def is_unique(self):
        """And whether sym W (K - D) is positive definite, at every step."""
        return tuple(map(all, zip(*(self.has_one_solution(self.matrix(step)) for step in self.steps))))

    def has_one_solution(self, k):
        at = self.scalar.solid.on("bottom")
        points = np.concatenate([b * self.scalar.n + np.array(at) for b in self.with_law])
        inner = np.setdiff1d(np.arange(len(k)), points)
        s = k[np.ix_(points, points)] - k[np.ix_(points, inner)] @ np.linalg.solve(k[np.ix_(inner, inner)], k[np.ix_(inner, points)])
        falls = self.falls_of_nodes()
        determinants = []
        for choice in itertools.product((False, True), repeat=len(points)):  # of walls: held; of laws that fall: on the slope
            choice, falling = np.array(choice), falls[points] > 0
            left = np.flatnonzero(falling | ~choice)
            one = (s - np.diag(np.where(falling & choice, falls[points], 0.0)))[np.ix_(left, left)]
            determinants.append(np.linalg.det(one) if len(left) else 1.0)
        rest = self.weighted(k - np.diag(falls))
        return min(determinants) > 0, np.linalg.eigvalsh(rest + rest.T)[0] > 0

    def falls_of_nodes(self):
        """Of all unknowns: the steepest fall of a force, with the weight of its node."""
        weights = sum(w * row for w, row in self.scalar.law_points("bottom", "nodal"))
        return np.concatenate([self.falls[b] * weights * (b in self.with_law) for b in range(self.count)])

    def weighted(self, k):
        """Two equations: the couplings cancel, or are alike."""
        one, other = np.abs(self.couplings[:2, :2].flat[[1, 2]]) if self.count == 2 else (0.0, 0.0)
        weights = np.ones(self.count)
        if one > 0 and other > 0:
            weights[1] = one / other
        return np.repeat(weights, self.scalar.n)[:, None] * k

    def script(self):
        forms, laws = [], []
        for a, v in enumerate(TESTS[:self.count]):
            u = NAMES[a]
            forms.append(f"integral(body, {number(self.diffusion[a])}*dot(grad({u}), grad({v})) + {number(self.capacity[a])}*{u}*{v})")
            if self.rates.any():
                forms.append(f"integral(body, {number(self.rates[a])}*{u}'*{v})")
            if self.flow.any():
                forms.append(f"integral(body, dot([{number(self.flow[0])}, {number(self.flow[1])}], grad({u}))*{v})")
            for b in range(self.count):
                if self.couplings[a, b] != 0:
                    forms.append(f"integral(body, {number(self.couplings[a, b])}*{NAMES[b]}*{v})")
            if a in self.with_law:
                laws.append(f"superpotential law{a}(r) {'= ' if self.laws[a][0] == 'u' else ''}{self.laws[a]}")
                forms.append(f"integral(bottom, law{a}^0({u}; {v}), rule = nodal)")
        spaces = [f"space V{a} = scalar P1 on body" for a in range(self.count)]
        found = ", ".join(f"{NAMES[a]} in V{a}" for a in range(self.count))
        times = ""
        if self.rates.any():
            ends = np.concatenate([[0.0], np.round(np.cumsum(self.steps), 3)])
            times = f" for t in [0, {ends[-1]}] at [{', '.join(map(repr, map(float, ends)))}] from " + ", ".join(f"{u} = 0" for u in NAMES[:self.count])
        tests = ", ".join(f"{v} in V{a}" for a, v in enumerate(TESTS[:self.count]))
        return "\n".join(["import contact", 'mesh body = gmsh("body.msh")', 'part bottom = body.group("bottom")', *laws, *spaces,
                          f"find {found}{times}", f"such that for all {tests}", "    " + "\n  + ".join(forms), " >= integral(body, 1e-3*v)",
                          "report", "  table size = norm(u)"]) + "\n"


def promises(program, folder):
    """Of `check` and of a run; None where there is no answer."""
    out = []
    for command in ("check", "run"):
        subprocess.run([program, command, "scene.hvi", "--quiet", "--json", f"{command}.json"], cwd=folder, capture_output=True, timeout=120)
        file = folder / f"{command}.json"
        report = json.loads(file.read_text()) if file.exists() else None
        out.append(None if report is None else report["verdict"]["discrete"]["holds"] if command == "check" else report["uniqueness"] == "guaranteed")
    return out


def main():
    options = orientation.asked_for()
    wrong = refused = certified = several = 0
    for k in range(options.scenes) if options.only is None else options.only:
        scene = Scene(np.random.default_rng([options.seed, k]))
        unique, definite = scene.is_unique()
        several += not unique
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.keep or pathlib.Path(temporary)) / str(k)
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "body.msh").write_text(scene.mesh.msh())
            (folder / "scene.hvi").write_text(scene.script())
            checked, ran = promises(options.program, folder)
        certified += bool(checked) and bool(ran)
        wrong += not unique and bool(checked or ran)
        expected = definite and scene.count < 3
        refused += expected and not (checked and ran)
        if (not unique and (checked or ran)) or (expected and not (checked and ran)):
            print(f"scene {k}: one solution {unique}, sym W (K - D) positive definite {definite}, check {checked}, run {ran}", file=sys.stderr)
    print(f"{several} scenes with several solutions")
    print(f"family claims: scenes {options.scenes if options.only is None else len(options.only)}, certified {certified}, wrong {wrong}, refused {refused}")
    return 0 if wrong == refused == 0 and (options.only or several >= options.scenes // 5 and certified >= options.scenes // 5) else 1


sys.exit(main())
