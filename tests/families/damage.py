"""States inside bodies on random scenes: the answers of brute force at every step.

usage: damage.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

Each scene is one of rates.py: a viscoelastic block in 2D or 3D, some with memory, turned and scaled, with laws on u, u'
and memories on its ground. One or two states live in the block (damage by strain, by its energy, by its rate or by the
stress; ageing; wear by displacement) and weaken the elastic, the viscous form or the memory, with rates from slow to
settled within a step. P1 with one point in a cell or, where displacements are read, the points of degree 2, P2 in 2D.
A step is solved again by brute force: the dense matrix of the states, the laws, and the states of the solution in turn,
each point's equation by bisection, until nothing changes.
"""
import json
import math
import sys

import numpy as np

import rates
from orientation import number
from rates import AGREES
from solids import Solid, cell_rule, shapes, slopes, triangle_rule

PASSES = 400
SETTLED = 1e-13
WITHOUT_REFERENCE = 0.15


class CellPoint:
    """A point in a cell: its dofs, eps (dim x dim x local), N (dim x local), and weight."""

    def __init__(self, solid, cell, b, weight):
        x = solid.mesh.points[cell]
        edges = (x[1:] - x[0]).T
        inner = np.linalg.inv(edges)
        g = slopes(solid.order, b) @ np.vstack([-inner.sum(0), inner])
        dim, m = solid.dim, len(g)
        grad, self.values = np.zeros((dim, dim, m * dim)), np.zeros((dim, m * dim))
        for a in range(m):
            for c in range(dim):
                grad[c, :, a * dim + c] = g[a]
                self.values[c, a * dim + c] = shapes(solid.order, b)[a]
        self.strain = (grad + grad.transpose(1, 0, 2)) / 2
        self.dofs = solid.dofs(solid.nodes(cell))
        self.place = np.asarray(b) @ x
        self.weight = weight * abs(np.linalg.det(edges)) / math.factorial(dim)

    def stiffness(self, lam, mu):
        div = np.einsum("iik->k", self.strain)
        return self.weight * (lam * np.outer(div, div) + 2 * mu * np.einsum("ijk,ijl->kl", self.strain, self.strain))


def stress(eps, lam, mu):
    return lam * np.einsum("pii->p", eps)[:, None, None] * np.eye(eps.shape[1]) + 2 * mu * eps


def size_of(m):
    return np.sqrt(np.einsum("pij,pij->p", m, m))


# What a state does to a tensor, and what that is at most.
WEAKENS = {"falls": (lambda z: 1 - z, "(1 - {z})"), "square": (lambda z: (1 - z) ** 2, "(1 - {z})^2"),
           "fades": (lambda z: 1 / (1 + z), "(1/(1 + {z}))"), "hardens": (lambda z: 1 + z, "(1 + {z})")}
FORMS = ("viscous", "elastic", "memory")


class Scene(rates.Scene):
    def assemble(self):
        random = self.random
        if self.dim == 3 and self.order == 2:  # the program's points are its own there
            self.order, self.solid = 1, Solid(self.mesh, 1)
        part = 10 ** random.uniform(-2, 0)
        self.viscous = tuple(v * part for v in self.elastic)
        self.kind = str(random.choice(["strain", "energy", "rate", "stress", "ageing", "moved"]))
        if self.order == 2:
            rule = triangle_rule(4)
        else:
            rule = cell_rule(self.dim) if self.kind == "moved" else [((1 / (self.dim + 1),) * (self.dim + 1), 1.0)]
        self.per_cell = len(rule)
        self.inside = [CellPoint(self.solid, cell, b, w) for cell in self.mesh.cells for b, w in rule]
        self.places = np.array([p.place for p in self.inside])
        self.hard = bool(random.random() < 0.2)
        self.most = float(random.uniform(0.1, 0.7))
        forms = [f for f in FORMS if f != "memory" or self.memory]
        self.weakens = {f: str(random.choice(["hardens"] if self.hard else ["falls", "square", "fades"]))
                        for f in forms if f == "elastic" or random.random() < 0.4}
        self.second = bool(random.random() < 0.3)
        self.clamped_dofs = self.solid.dofs(self.solid.on(self.clamped))
        self.free = np.setdiff1d(np.arange(self.solid.n), self.clamped_dofs)
        worst = np.full(len(self.inside), 0.0 if self.hard else self.most)
        self.all_a, self.all_b, self.all_q = (self.of_states(f, worst) for f in FORMS)
        self.k = self.matrix(1)
        self.inverse = np.linalg.inv(self.k)

    def of_states(self, form, z):
        """The matrix of a form, all unknowns, with the first state z at the points."""
        out = np.zeros((self.solid.n, self.solid.n))
        lame = self.viscous if form == "viscous" else self.elastic
        factors = WEAKENS[self.weakens[form]][0](z) if form in self.weakens else np.ones(len(z))
        for p, factor in zip(self.inside, factors):
            out[np.ix_(p.dofs, p.dofs)] += factor * p.stiffness(*lame)
        return out

    def choose_laws(self):
        super().choose_laws()  # convex with the weakest matrices
        random = self.random
        self.told_first, self.told_second = [np.zeros(len(self.inside))], [np.zeros(len(self.inside))]
        steps = np.diff(self.grid)
        self.c = 10 ** random.uniform(-1, 1.5) / steps.max()
        self.c2 = 10 ** random.uniform(-1, 1)
        u = np.zeros(self.solid.n)
        u[self.free] = np.linalg.solve(self.all_b[np.ix_(self.free, self.free)], self.load)
        eps, _ = self.read(u)
        self.strain_size = float(size_of(eps).max()) or 1.0
        self.stress_size = float(size_of(stress(eps, *self.elastic)).max()) or 1.0
        self.threshold = float(random.uniform(0, 0.5))

    def read(self, u):
        eps = np.array([p.strain @ u[p.dofs] for p in self.inside])
        return eps, np.array([p.values @ u[p.dofs] for p in self.inside])

    def inputs(self, n, states, new, before):
        """What the rates read: strain, its rate, displacement and memory at the points."""
        s, carry = self.rate(n)
        eps, moved = self.read(new)
        slow, _ = self.read(s * (new - states[-1]) - carry * before)
        remembered = np.zeros_like(eps)
        if self.memory:
            weights = self.history(n, self.memory)
            remembered, _ = self.read(sum(w * u for w, u in zip(weights, [*states, new])))
        return {"eps": eps, "rate": slow, "moved": moved, "memory": remembered}

    def of_rate(self, z, other, a):
        e = size_of(a["eps"]) / self.strain_size
        if self.kind == "strain":
            out = np.maximum(0, e - self.threshold)
        elif self.kind == "energy":
            out = e ** 2 * (1.5 - z)
        elif self.kind == "rate":
            out = (size_of(a["rate"]) / self.strain_size / self.wave) ** 2
        elif self.kind == "ageing":
            out = 0.3 * (1.5 - z)
        elif self.kind == "moved":
            out = np.einsum("pi,pi->p", a["moved"], a["moved"]) / self.reach ** 2 * (2 - z)
        else:
            total = stress(a["eps"], *self.elastic) * self.factor("elastic", z)
            total = total + stress(a["rate"], *self.viscous) * self.factor("viscous", z)
            if self.memory:
                total = total + stress(a["memory"], *self.elastic) * self.factor("memory", z)
            out = size_of(total) / self.stress_size
        return self.c * (out * (1 / (1 + other ** 2) if self.second else 1.0))

    def factor(self, form, z):
        g = WEAKENS[self.weakens[form]][0](z) if form in self.weakens else np.ones(len(z))
        return g[:, None, None]

    def rate_of_second(self, other, a):
        return self.c2 * (size_of(a["eps"]) / self.strain_size - other)

    def local(self, known, second, weight, a):
        """z and the second state at the points: of the step's equations, by bisection."""
        other = np.zeros(len(known))
        if self.second:  # linear in itself, and it does not read the first
            e = size_of(a["eps"]) / self.strain_size
            other = (second + weight * self.c2 * e) / (1 + weight * self.c2)
        low, high = np.zeros(len(known)), np.full(len(known), self.most)
        left = lambda z: z - np.clip(known + weight * self.of_rate(z, other, a), 0.0, self.most)
        for _ in range(60):
            middle = (low + high) / 2
            above = left(middle) > 0
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        z = (low + high) / 2
        z = np.where(left(np.zeros(len(known))) >= 0, 0.0, z)
        return np.where(left(np.full(len(known), self.most)) <= 0, self.most, z), other

    def step(self, n, states, before):
        """u_n with the states of its own; these are kept."""
        weight, carry = 1 / self.rate(n)[0], self.rate(n)[1]
        kept = (self.told_first, self.told_second)
        of_states = [of[-1] + weight * carry * (of[-1] - of[-2] if n > 1 else 0.0) for of in kept]
        known = self.known(n, states, before)
        z, part, last_change = self.told_first[-1], 1.0, math.inf
        for _ in range(PASSES):
            self.all_a, self.all_b, self.all_q = (self.of_states(f, z) for f in FORMS)
            u = self.solve(n, known, states, self.law_points(n, known))
            if u is None:
                return None
            new, other = self.local(*of_states, weight, self.inputs(n, states, u, before))
            change = float(np.abs(new - z).max())
            if change <= SETTLED:
                self.told_first.append(new)
                self.told_second.append(other)
                return u
            if change > 0.9 * last_change:
                part = max(0.05, 0.7 * part)
            last_change = change
            z = z + part * (new - z)
        return None

    def script(self, turn, scale):
        text = super().script(turn, scale)
        norm = lambda e: f"sqrt({e} : {e})"
        strain = f"({norm('eps(u)')}/{number(self.strain_size)})"
        slow = f"(eps(u') : eps(u'))/{number((self.strain_size * self.wave) ** 2)}"
        body = {"strain": f"max(0, {strain} - {number(self.threshold)})", "energy": f"{strain}^2*(1.5 - d)", "rate": slow,
                "ageing": "0.3*(1.5 - d)", "moved": f"dot(u, u)/{number((self.reach * scale) ** 2)}*(2 - d)",
                "stress": f"{norm('sigma')}/{number(self.stress_size)}"}[self.kind]
        more = "*(1/(1 + w^2))" if self.second else ""
        lines = [f"state d on body with rate {number(self.c)}*({body}{more}) from d = 0 in [0, {number(self.most)}]"]
        if self.second:
            lines.append(f"state w on body with rate {number(self.c2)}*({strain} - w) from w = 0")
        text = text.replace("space V", "\n".join(lines) + "\nspace V")
        of_form = {"elastic": ("(body, B :", "(body, {}*B :"), "viscous": ("(body, A :", "(body, {}*A :"),
                   "memory": ("(body, history(Q, eps(u)) :", "(body, {}*history(Q, eps(u)) :")}
        for form, kind in self.weakens.items():
            old, new = of_form[form]
            text = text.replace(old, new.format(WEAKENS[kind][1].format(z="d")))
        columns = [f"d{k} = d at [" + ", ".join(number(v) for v in turn @ x * scale) + "]" for k, x in enumerate(self.cells())]
        columns.append("total = integral(body, d)")
        return text.replace("  fields u", "  table " + ", ".join(columns) + "\n  fields u, d")

    def cells(self):
        return [self.mesh.points[cell].mean(0) for cell in self.mesh.cells]

    def options(self, k):
        return ["--json", "out.json"]

    def bound(self):
        return AGREES

    def error_besides(self, folder, scale):
        """Of the states' means on cells, and of the integral."""
        columns = json.loads((folder / "out.json").read_text())["table"]
        weights = np.array([p.weight for p in self.inside]).reshape(-1, self.per_cell)
        worst = 0.0
        for n in range(1, len(self.grid)):
            z = self.told_first[n].reshape(-1, self.per_cell)
            mean = (weights * z).sum(1) / weights.sum(1)
            told = np.array([columns[f"d{k}"][n - 1] for k in range(len(mean))])
            total = (weights * z).sum()
            worst = max(worst, float(np.abs(told - mean).max()),
                        abs(columns["total"][n - 1] / scale ** self.dim - total) / weights.sum())
        return worst

    def told(self):
        return (f"{super().told()}, damage by {self.kind}, {self.weakens}, c {self.c:.3g}"
                f"{', two states' if self.second else ''}, up to {self.most:.2g}")


if __name__ == "__main__":
    sys.exit(rates.judge("damage", Scene, WITHOUT_REFERENCE))
