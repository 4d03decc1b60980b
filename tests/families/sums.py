"""Laws whose arguments are sums of u, u' and memories, or see one of them in each component, on random scenes.

usage: sums.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of rates.py with a law that sees a u + b u' + c int q u through one M, or, where it is radial, other such sums in
each component of its argument: `rub^0([dot(u, a), dot(u', b)]; [dot(v, a), dot(v, b)])`. Then forces are those of rows G,
arguments those of rows s_k G_k: no energy, and brute force works with both. Such laws are convex here, for a step may have
several solutions where they are not.
"""
import sys

import numpy as np

import rates
from brute import Friction, Step, Unilateral, constrained
from orientation import CONVEX, number
from solids import turning

TEXT = {"u": "u", "rate": "u'", "memory": "history(Own, u)"}


class SumTerm(rates.RateTerm):
    """`seen`: for each row a list of (what, how often); `ways`: directions of the rows, or None: those of the argument."""

    def __init__(self, *of_term, sees, seen, ways=None):
        super().__init__(*of_term, sees=sees)
        self.seen, self.ways = seen, ways

    def form(self):
        if self.ways is None:
            at = " + ".join(f"({number(c)})*{TEXT[what]}{self.argument}" for what, c in self.seen[0])
            return f"  + integral({self.part}, {self.name}^0({at}; v{self.argument}), rule = {self.rule})"
        dot = lambda of, way: f"dot({of}, [" + ", ".join(number(x) for x in self.turn @ way) + "])"
        rows = [" + ".join(f"({number(c)})*{dot(TEXT[what], way)}" for what, c in seen)
                for seen, way in zip(self.seen, self.ways)]
        tested = [dot("v", way) for way in self.ways]
        return (f"  + integral({self.part}, {self.name}^0([{', '.join(rows)}]; [{', '.join(tested)}]),"
                f" rule = {self.rule})")

    def points(self, solid):
        out = super().points(solid)
        if self.ways is not None:
            for p in out:
                p.rows = np.array(self.ways) @ p.rows
        return out

    @property
    def mixed(self):
        return self.ways is not None


class MixedStep(Step):
    """Brute force where points have rows of forces besides those of arguments."""

    def __init__(self, k, points):
        super().__init__(k, points)
        self.f = np.vstack([p.force for p in self.points])
        self.c = self.g @ self.inverse @ self.f.T
        self.kappa = [p.weight * np.linalg.norm(self.c[r, r], 2) for p, r in zip(self.points, self.rows)]

    def polish(self, f):
        u = self.inverse @ (f - self.f.T @ (self.weights * self.xi))
        for _ in range(60):
            k, rhs, held, values = self.k.copy(), f.copy(), [], []
            z = self.g @ u + self.offset
            for p, rows, state in zip(self.points, self.rows, self.states):
                if state[0] in ("origin", "at"):
                    held.append(p.rows)
                    values.append((p.law.breaks[state[1]] if state[0] == "at" else 0.0) - p.offset)
                    continue
                if p.law.radial:
                    r = np.linalg.norm(z[rows])
                    e = z[rows] / r if r > 0 else self.xi[rows] / max(np.linalg.norm(self.xi[rows]), 1e-300)
                    d = p.law.growth(r) * np.outer(e, e) + p.law.slope(r) / max(r, 1e-300) * (np.eye(len(e)) - np.outer(e, e))
                    xi = p.law.slope(r) * e
                else:
                    i = state[1]
                    d, xi = np.array([[p.law.growths[i]]]), np.array([p.law.slope(i, z[rows][0])])
                k += p.weight * p.force.T @ d @ p.rows
                rhs -= p.weight * p.force.T @ (xi - d @ z[rows] + d @ p.offset)
            new = constrained(k, rhs, held, values)  # rows of forces and of arguments vanish on the same vectors
            if new is None or not np.all(np.isfinite(new)):
                return None
            moved, u = np.abs(new - u).max(), new
            if moved <= 1e-14 * self.scale:
                break
        return u if self.holds(u, f) else None

    def holds(self, u, f):
        """Step.holds with the rows of forces where forces are meant; arguments from those of their own."""
        z = self.g @ u + self.offset
        arguments = [p.rows for p in self.points]
        offsets = [p.offset for p in self.points]
        g, offset = self.g, self.offset
        try:
            for p, rows in zip(self.points, self.rows):
                p.rows = p.force
            self.g, self.offset = self.f, z - self.f @ u  # so that G u + g is the argument
            return super().holds(u, f)
        finally:
            self.g, self.offset = g, offset
            for p, rows, own in zip(self.points, arguments, offsets):
                p.rows, p.offset = rows, own


class Scene(rates.Scene):
    def choose_laws(self):
        random = self.random
        super().choose_laws()
        old = self.terms[0]
        self.mixed = random.random() < 0.5
        whats = ["u", "rate"] + (["memory"] if random.random() < 0.3 else [])
        ratio = lambda: random.uniform(0.2, 2)
        fit = {"u": 1.0, "rate": 1 / self.wave, "memory": 1.0}  # sizes of these are alike
        if self.mixed:
            law, argument = self.friction_law(), ""
            law.static = law.sliding * random.uniform(0, 1)  # convex
            ways = np.linalg.qr(random.normal(size=(self.dim, self.dim)))[0] if random.random() < 0.7 else random.normal(
                size=(self.dim, self.dim))
            seen = [[(str(random.choice(whats)), ratio())] for _ in ways]
            if random.random() < 0.5:
                seen[0] = [("u", ratio()), ("rate", ratio() * fit["rate"])]
            seen = [[(what, c * fit[what] if len(row) == 1 else c) for what, c in row] for row in seen]
            seen[-1] = [("rate", fit["rate"] * ratio())]
            if all(row[0][0] == "rate" for row in seen):
                seen[0] = [("u", ratio())]
            self.terms = [t for t in self.terms if not isinstance(t.law, Friction)]
            self.terms.append(SumTerm("mixed", "bottom", argument, old.rule, law, sees="rate", seen=seen, ways=list(ways)))
        else:
            seen = [(what, ratio() * fit[what]) for what in whats]
            self.terms[0] = SumTerm("sum", "bottom", old.argument, old.rule, old.law, sees="rate", seen=[seen])
            if isinstance(old.law, Unilateral) and self.moves is not None:
                self.terms[0].law = self.friction_law() if old.argument != ".nu" else self.normal_law()
                while isinstance(self.terms[0].law, Unilateral):
                    self.terms[0].law = self.normal_law()
        for _ in range(80):
            if self.ratio() <= CONVEX:
                return
            self.soften(0.5)
        raise AssertionError("no convex step")

    def law_points(self, n=1, known=None):
        out = []
        own = self.history(n, self.own)
        factors = {"u": 1.0, "rate": self.rate(n)[0], "memory": own[n]}
        for term in self.terms:
            one = [[(term.sees, 1.0)]]
            for p in term.points(self.solid):
                seen = getattr(term, "seen", one)
                seen = seen if len(seen) == len(p.rows) else seen * len(p.rows)
                s = np.array([sum(c * factors[what] for what, c in row) for row in seen])
                if known is not None:
                    held, states, known_rate = known
                    of = {"u": held, "rate": factors["rate"] * (held - states[-1]) + known_rate,
                          "memory": own[n] * held + sum(w * u for w, u in zip(own, states))}
                    p.offset = np.array([r @ sum(c * of[what] for what, c in row) for r, row in zip(p.rows, seen)])
                rows = p.rows[:, self.free]
                p.force, p.rows = rows, s[:, None] * rows
                if np.ptp(s) == 0.0:
                    p.force, p.weight = p.rows, p.weight / s[0]
                out.append(p)
        return out

    def solve(self, n, known, states, points):
        keep, rates.Step = rates.Step, MixedStep if self.mixed else Step
        try:
            return super().solve(n, known, states, points)
        finally:
            rates.Step = keep

    def script(self, turn, scale):
        for term in self.terms:
            term.turn = turn
        text = super().script(turn, scale)
        if "kernel Own" not in text and "history(Own" in text:
            a, tau = self.own
            text = text.replace("space V", f"kernel Own(lag) = {number(a / tau)}*exp(-lag/{number(tau)})\nspace V")
        return text

    def told(self):
        return super().told() + f", {self.terms[-1 if self.mixed else 0].seen}{' mixed' if self.mixed else ''}"


if __name__ == "__main__":
    sys.exit(rates.judge("sums", Scene, 0.15, turning))
