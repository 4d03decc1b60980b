"""Two bodies that rub and heat each other, on random scenes: the answers of brute force.

usage: warm_pairs.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The bodies of pairs.py with a displacement and a scalar, coupled as in fields.py. Laws act on jumps across the pair, of u, of
u' and of the scalar, and have a factor 1 + c min(1, m/r), m the mean or the jump of the scalar, or a part of the jump of u. In
most scenes a law heats both sides, the equation of the scalar has a source h xi (of a law without jumps) or h xi . jump(u') (of
friction on the rate), of which either side gets its share. A step is solved again by a dense brute force (brute.py) with a mortar
of its own (mortar.py) and the factors and sources of its own last solution, until they no longer change.
"""
import sys

import numpy as np

import fields
import orientation
import pairs
import rates
import warm
from brute import Point, Unilateral
from mortar import pair_points
from orientation import number
from solids import Solid

OF_P = ["abs(mean(p))", "abs(jump(p))"]
OF_U = ["abs(jump(u).nu)", "norm(jump(u).tau)", "norm(jump(u))"]


class PairTerm(warm.WarmTerm):
    def places_of(self, scene):
        """Points of the order of what the law sees, with the rows of the scalar's jump and mean there."""
        return scene.places[scene.scalar.order if self.sees == "p" else scene.order]

    def points_of(self, scene):
        out = []
        for p, jump, _ in self.places_of(scene):
            if self.sees == "p":
                rows = np.concatenate([np.zeros(scene.solid.n), jump])[None, :]
            else:
                rows = (p.normal[None, :] if self.argument == ".nu" else np.linalg.svd(p.normal[None, :])[2][1:]) @ p.jump
                rows = np.hstack([rows, np.zeros((len(rows), scene.scalar.n))])
            out.append(Point(self.law, p.weight, rows, np.zeros(len(rows))))
        return out

    def factors(self, scene, full):
        """Of every point, from the values of all unknowns."""
        u, scalar, out = full[:scene.solid.n], full[scene.solid.n:], []
        for p, jump, mean in self.places_of(scene):
            w = p.jump @ u
            along = p.normal * (p.normal @ w)
            m = [mean @ scalar, jump @ scalar, along, w - along, w][(OF_P + OF_U).index(self.what)]
            out.append(1.0 if isinstance(self.law, Unilateral) else 1 + self.c * min(1.0, np.linalg.norm(m) / self.r))
        return out

    def text(self, scene, scale):
        unit, factor = (scene.unit, scene.unit_of_row * scale) if self.sees == "p" else (scale, None)
        declaration = self.declaration(unit)
        if not isinstance(self.law, Unilateral):
            times = f"(1 + ({number(self.c)})*min(1, {self.what}/{number(self.r * (scene.unit if self.what in OF_P else scale))}))"
            mark = "-> " if "-> " in declaration else "with slope "
            declaration = "\n".join(f"{line.split(mark)[0]}{mark}{times} * ({line.split(mark)[1]})" if mark in line else line
                                    for line in declaration.split("\n"))
        seen, test = {"u": ("u", "v"), "rate": ("u'", "v"), "p": ("p", "q")}[self.sees]
        form = f"integral(seam, {self.name}^0(jump({seen}){self.argument}; jump({test}){self.argument}))"
        return declaration, "  + " + (f"{number(factor)} * " if factor is not None else "") + form


class Scene(warm.Scene):
    choose_bodies, place = pairs.Scene.choose_bodies, pairs.Scene.place
    solid_of_bodies, pair_points, nodes_in = pairs.Scene.solid_of_bodies, pairs.Scene.pair_points, pairs.Scene.nodes_in
    rings = False  # bodies of revolution

    def __init__(self, random):
        self.random = random
        self.dim = 2 if random.random() < 0.75 else 3
        self.order = 2 if random.random() < 0.35 else 1
        self.choose_kind()
        self.choose_bodies()
        self.scalar = self.make_scalar(self.order_of_scalar())
        self.places = {order: self.places_of_order(order) for order in {self.order, self.scalar.order}}
        self.given = "held"
        self.steps = int(random.integers(1, 4))
        self.density = 10 ** random.uniform(-2, 2) if random.random() < 0.2 else 0.0
        self.unit, self.unit_of_row = 10 ** random.uniform(-5, 5), 10 ** random.uniform(-5, 5)
        self.choose_forms()
        self.assemble()
        self.choose_loads()
        self.choose_laws()

    def choose_kind(self):
        self.kind = "coupled"

    def order_of_scalar(self):
        return self.order

    def make_scalar(self, order):
        return fields.Scalar(self.mesh, order)

    def places_of_order(self, order):
        """Points of the pair with rows of u; rows of the scalar's jump and of its mean there."""
        sides, out = [self.mesh.facets[s] for s in self.sides], []
        second = self.scalar.solid.on(self.sides[1])
        for p, q in zip(*(pair_points(Solid(self.mesh, order), *sides, trace, self.rings)[0]
                          for trace in (self.solid, self.scalar.solid))):
            jump = q.jump[0, ::self.dim]
            mean = jump / 2
            mean[second] = -jump[second] / 2
            out.append((p, jump, mean))
        return out

    def choose_laws(self):
        super().choose_laws()
        random = self.random
        for term in self.terms:
            term.__class__, term.part, term.rule = PairTerm, "seam", "nodal"
            if term.what == warm.TO_P:
                term.what = str(random.choice(OF_P))
            else:
                term.what = OF_U[warm.OF_U.index(term.what)]
        self.share = float(random.choice([0.0, 0.5, -0.5, random.uniform(-0.5, 0.5)]))
        while self.ratio() > orientation.CONVEX:
            orientation.Scene.soften(self, 0.5)

    def sources(self, full, before):
        out = np.zeros(len(full))
        if self.heats is None:
            return out[self.free]
        law, n = self.heats.law, self.solid.n
        u, rate = full[:n], self.steps * (full - before)[:n]
        for (p, jump, mean), factor in zip(self.heats.places_of(self), self.heats.factors(self, full)):
            w = p.jump @ (rate if self.heats.sees == "rate" else u)
            z = p.normal @ w
            slip = np.linalg.norm(w - p.normal * z)
            g = law.slope(slip) * slip if law.radial else law.slope(law.solve(z, 0.0)[1][1], z)
            out[n:] -= p.weight * self.h * factor * g * (mean + self.share * jump)
        return out[self.free]

    def script(self, turn, scale):
        text = pairs.on_two_bodies(self, fields.Scene.script(self, turn, scale))
        if self.heats is None:
            return text
        term = self.heats
        what = f"dot({term.name}.xi, jump(u').tau)" if term.law.radial else f"{term.name}.xi"
        h = self.h * self.unit_of_row * (1.0 if term.law.radial else scale)
        source = f"  {'-' if h < 0 else '+'} {number(abs(h))} * integral(seam, {what}*(mean(q) + ({number(self.share)})*jump(q)))"
        return text.replace("\n >= ", f"\n{source}\n >= ", 1)

    def told(self):
        return super().told() + f", share {self.share:.2f}, pair {self.sides} of {len(self.solid.pairing)} points"


if __name__ == "__main__":
    sys.exit(rates.judge("warm_pairs", Scene, run=pairs.run))
