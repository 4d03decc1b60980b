"""Laws that read memories, on random scenes: the answers of brute force at every step.

usage: readings.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of rates.py, whose laws on u, u' and memories have a factor 1 + c min(1, m/r) besides, m a part of another memory of
the unknown at the same point. A step is solved again by a dense brute force (brute.py), with the factors of its own
last solution until they no longer change, and memories of its own.
"""
import copy
import sys

import numpy as np

import orientation
import rates
from brute import Friction, Unilateral
from orientation import number

PASSES = 80  # of the reference; where it has not found the factors then, it has no answer
SETTLED = 1e-13
PARTS = {".nu": "abs(history(Read, u).nu)", ".tau": "norm(history(Read, u).tau)", "": "norm(history(Read, u))"}


class ReadingTerm(rates.RateTerm):
    """A law times 1 + c min(1, m/r), m the size of a part of int q u."""

    def reads(self, part, c, r):
        self.part_read, self.c, self.r = part, c, r

    def declaration(self, s):
        text = super().declaration(s)
        if isinstance(self.law, Unilateral):
            return text
        factor = f"(1 + ({number(self.c)})*min(1, {PARTS[self.part_read]}/{number(self.r * s)}))"
        mark = "-> " if "-> " in text else "with slope "
        return "\n".join(f"{line.split(mark)[0]}{mark}{factor} * ({line.split(mark)[1]})" if mark in line else line
                         for line in text.split("\n"))

    def factors(self, solid, past):
        """Of every point, from the memory at all dofs."""
        out = []
        for _, values, normal in solid.law_points(self.part, self.rule):
            m = values @ past
            along = normal * (normal @ m)
            m = {".nu": along, ".tau": m - along, "": m}[self.part_read]
            out.append(1 + self.c * min(1.0, np.linalg.norm(m) / self.r))
        return out


def times(law, factor):
    if isinstance(law, Unilateral):
        return law
    out = copy.copy(law)
    if isinstance(law, Friction):
        out.static, out.sliding = factor * law.static, factor * law.sliding
    else:
        out.starts, out.growths = [factor * v for v in law.starts], [factor * v for v in law.growths]
    return out


class Scene(rates.Scene):
    def choose_laws(self):
        random = self.random
        self.read = random.uniform(-3, 3), 10 ** random.uniform(-1, 1)
        self.most = 1.0
        super().choose_laws()
        for term in self.terms:
            term.__class__ = ReadingTerm
            c = random.uniform(-0.8, 2)
            term.reads(str(random.choice(list(PARTS))), c, self.reach * 10 ** random.uniform(-1.5, 0.5))
            self.most = max(self.most, 1 + c)
        while super().ratio() * self.most > orientation.CONVEX:
            self.soften(0.5)

    def ratio(self):
        return super().ratio() * self.most

    def law_points(self, n=1, known=None):
        points = super().law_points(n, known)
        if known is not None:
            held, states, _ = known
            weights = self.history(n, self.read)
            past = sum(w * u for w, u in zip(weights, [*states, self.trial]))
            factors = [f for term in self.terms for f in term.factors(self.solid, past)]
            for point, factor in zip(points, factors):
                point.law = times(point.law, factor)
        return points

    def step(self, n, states, before):
        """u_n with the factors that it makes itself."""
        known = self.known(n, states, before)
        self.trial = states[-1].copy()
        for _ in range(PASSES):
            new = self.solve(n, known, states, self.law_points(n, known))
            if new is None:
                return None
            moved, self.trial = np.abs(new - self.trial).max(), new
            if moved <= SETTLED * max(self.reach, np.abs(new).max()):
                return new
        return None

    def script(self, turn, scale):
        a, tau = self.read
        kernel = f"kernel Read(lag) = {number(a / tau)}*exp(-lag/{number(tau)})\nspace V"
        return super().script(turn, scale).replace("space V", kernel, 1)

    def told(self):
        return super().told() + f", reading {[(t.part_read, round(t.c, 2)) for t in self.terms]}"


if __name__ == "__main__":
    sys.exit(rates.judge("readings", Scene))
