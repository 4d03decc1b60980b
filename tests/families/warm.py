"""Laws that read each other's unknowns, and sources that read multipliers, on random scenes: the answers of brute force.

usage: warm.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of fields.py, whose laws have a factor 1 + c min(1, m/r) besides, m what they read at their points: the scalar,
or a part of the displacement. In most scenes a law heats: the equation of the scalar has a source h xi (of a law without
jumps) or h xi . u' (of friction on the rate). A step is solved again by a dense brute force (brute.py) with the factors
and sources of its own last solution, until they no longer change.
"""
import sys

import numpy as np

import fields
import orientation
import rates
from brute import Friction, Point, Step, Unilateral
from orientation import number
from readings import times
from solids import Fans, facet_rule, shapes

PASSES = 80  # of the reference; where it has not settled then, it has no answer
SETTLED = 1e-13
TO_P, OF_U = "abs(p)", ["abs(u.nu)", "norm(u.tau)", "norm(u)"]


class WarmTerm(fields.FieldTerm):
    """A law times 1 + c min(1, m/r), m the size of what it reads."""

    def reads(self, what, c, r):
        self.what, self.c, self.r = what, c, r

    def places(self, scene):
        """(weight, row of the scalar, values of u, normal) of every point."""
        solid, scalar = scene.solid, scene.scalar
        own = scalar if self.sees == "p" else solid
        fans = Fans(scalar.solid if self.sees == "p" else solid, scene.mesh.facets[self.part])
        for k, f in enumerate(fans.facets):
            for b, weight in facet_rule(scene.dim, own.order, self.rule):
                row = np.zeros(scalar.n)
                row[scalar.solid.nodes(f)] = shapes(scalar.order, b)
                values = np.zeros((scene.dim, solid.n))
                for node, shape in zip(solid.nodes(f), shapes(solid.order, b)):
                    for i in range(scene.dim):
                        values[i, solid.dofs([node])[i]] = shape
                yield weight * fans.sizes[k], row, values, fans.at_point(k, b, self.rule)

    def factors(self, scene, full):
        """Of every point, from the values of all unknowns."""
        if isinstance(self.law, Unilateral):
            return [1.0 for _ in self.places(scene)]
        u, p, out = full[:scene.solid.n], full[scene.solid.n:], []
        for _, row, values, normal in self.places(scene):
            w = values @ u
            along = normal * (normal @ w)
            m = {TO_P: lambda: row @ p, OF_U[0]: lambda: along, OF_U[1]: lambda: w - along, OF_U[2]: lambda: w}[self.what]()
            out.append(1 + self.c * min(1.0, np.linalg.norm(m) / self.r))
        return out

    def text(self, scene, scale):
        declaration, form = super().text(scene, scale)
        if isinstance(self.law, Unilateral):
            return declaration, form
        unit = scene.unit if self.what == TO_P else scale
        factor = f"(1 + ({number(self.c)})*min(1, {self.what}/{number(self.r * unit)}))"
        mark = "-> " if "-> " in declaration else "with slope "
        return "\n".join(f"{line.split(mark)[0]}{mark}{factor} * ({line.split(mark)[1]})" if mark in line else line
                         for line in declaration.split("\n")), form


def is_continuous(law):
    return not law.radial and not isinstance(law, Unilateral) and all(abs(a - b) <= 1e-12 * (abs(a) + abs(b)) for a, b in map(law.limits, range(len(law.breaks))))


class Scene(fields.Scene):
    def choose_laws(self):
        random, self.most = self.random, 1.0
        super().choose_laws()
        for term in self.terms:
            term.__class__ = WarmTerm
            what = TO_P if term.sees != "p" and random.random() < 0.7 else str(random.choice(OF_U))
            c = random.uniform(-0.6, 1.0)
            term.reads(what, c, self.reaches["p" if what == TO_P else "u"] * 10 ** random.uniform(-0.5, 1))
            self.most = max(self.most, 1 + c)
        while super().ratio() * self.most > orientation.CONVEX:
            orientation.Scene.soften(self, 0.5)
        self.choose_source()

    def choose_source(self):
        """Of the size of the scalar's own loads."""
        random, self.heats = self.random, None
        can = [t for t in self.terms
               if (t.law.radial and t.sees == "rate") or (t.sees != "p" and not t.law.radial and is_continuous(t.law))]
        if not can or random.random() < 0.2 or self.kind == "incompressible":
            return
        self.heats = can[int(random.integers(len(can)))]
        area = sum(self.solid.facet(f)[0] for f in self.mesh.facets["bottom"])
        in_p = float(np.abs(self.k[np.ix_(self.of_p, self.of_p)]).max()) * self.reaches["p"] / area
        size = self.heats.law.static * self.reaches["rate"] if self.heats.law.radial else self.pressure_of(self.heats)
        self.h = random.choice([-1, 1]) * 10 ** random.uniform(-2, -0.3) * in_p / (size or 1.0)

    def pressure_of(self, term):
        law, r = term.law, self.reaches[term.sees]
        return max(abs(law.slope(law.solve(y, 0.0)[1][1], y)) for y in (-r, r))

    def ratio(self):
        return super().ratio() * self.most

    def sources(self, full, before):
        """Forces on the free unknowns, from the values of all of them and those of the last step."""
        out = np.zeros(len(full))
        if self.heats is None:
            return out[self.free]
        term, law, n = self.heats, self.heats.law, self.solid.n
        u, rate = full[:n], self.steps * (full - before)[:n]
        for (weight, row, values, normal), factor in zip(term.places(self), term.factors(self, full)):
            w = values @ (rate if term.sees == "rate" else u)
            if law.radial:
                slip = np.linalg.norm(w - normal * (normal @ w))
                g = factor * law.slope(slip) * slip
            else:
                z = normal @ w
                g = factor * law.slope(law.solve(z, 0.0)[1][1], z)
            out[n:] -= weight * self.h * g * row
        return out[self.free]

    def told_besides(self, folder, turn, scale):
        """The scalar at its nodes after every step."""
        return [(grid.point_data["p"].ravel() / self.unit)[self.nodes_in(grid, turn, scale, self.scalar.solid)]
                for grid in rates.written(folder)]

    def is_solution(self, u, p, bound):
        """Laws that read what they change may have several solutions: is this one? With the factors and sources of the answer
        itself, and the answers of the steps before, a step has one solution; brute force finds it in the answer."""
        old, velocity = np.zeros(len(self.load_of_all())), np.zeros(len(self.free))
        for n in range(1, self.steps + 1):
            answer = np.concatenate([np.ravel(u[n - 1]), p[n - 1]])
            points = self.law_points(old[self.free])
            for point, factor in zip(points, [f for term in self.terms for f in term.factors(self, answer)]):
                point.law = times(point.law, factor)
            f = self.load * (n / self.steps) + self.known(old[self.free], velocity)
            new = Step(self.k, points).solve(f + self.sources(answer, old), rates.TURNS)
            if new is None:
                return False
            off, of_u = np.abs(new - answer[self.free]), self.free < self.solid.n
            for part, size in ((of_u, self.reaches["u"]), (~of_u, self.reaches["p"])):
                if off[part].max(initial=0.0) > bound * max(size, np.abs(new[part]).max(initial=0.0)):
                    return False
            velocity, old = self.steps * (answer - old)[self.free], answer
        return True

    def reference(self):
        states = [np.zeros(len(self.load_of_all()))]
        velocity = np.zeros(len(self.free))
        for n in range(1, self.steps + 1):
            old, trial = states[-1], states[-1].copy()
            f = self.load * (n / self.steps) + self.known(old[self.free], velocity)
            for _ in range(PASSES):
                points = self.law_points(old[self.free])
                factors = [f for term in self.terms for f in term.factors(self, trial)]
                for point, factor in zip(points, factors):
                    point.law = times(point.law, factor)
                new = Step(self.k, points).solve(f + self.sources(trial, old), rates.TURNS)
                if new is None:
                    return None
                full = np.zeros(len(trial))
                full[self.free] = new
                sizes = np.abs(full[:self.solid.n]).max(), np.abs(full[self.solid.n:]).max()
                moved = np.abs(full - trial)
                trial = full
                if (moved[:self.solid.n].max() <= SETTLED * max(self.reaches["u"], sizes[0])
                        and moved[self.solid.n:].max() <= SETTLED * max(self.reaches["p"], sizes[1])):
                    break
            else:
                return None
            velocity = self.steps * (trial - old)[self.free]
            states.append(trial)
        self.expected_p = np.array([s[self.solid.n:] for s in states[1:]])
        return [s[:self.solid.n].reshape(-1, self.dim) for s in states[1:]]

    def load_of_all(self):
        return np.zeros(self.solid.n + self.scalar.n)

    def script(self, turn, scale):
        text = super().script(turn, scale)
        if self.heats is None:
            return text
        term = self.heats
        what = f"dot({term.name}.xi, u'.tau)" if term.law.radial else f"{term.name}.xi"
        h = self.h * self.unit_of_row * scale / (scale if term.law.radial else 1.0)
        source = f"  + {number(abs(h))} * integral(bottom, {what}*q)"
        if h < 0:
            source = source.replace("+", "-", 1)
        return text.replace("\n >= ", f"\n{source}\n >= ", 1)

    def told(self):
        laws = [(t.what, round(t.c, 2)) for t in self.terms]
        return super().told() + f", reading {laws}, heated by {self.heats.name if self.heats else None}"


if __name__ == "__main__":
    sys.exit(rates.judge("warm", Scene))
