"""Two unknowns that act on each other, on random scenes: the answers of brute force at every step.

usage: fields.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

Each scene is a block in 2D or 3D, with inertia or none, with a displacement in P1 or P2 and a scalar in P1 or P2: a temperature or a pressure
that acts on the body and is acted on (couplings of u, u' and of the scalar, of either sign and of any size against each
other), or the pressure of an incompressible body (P2 with P1). The scalar lives in the whole block or in some of its cells. One to three laws act on the ground, on u, on u' or on the
scalar, whose steps are convex; turned and scaled, the scalar with units of its own. A step is solved again by a dense
brute force (brute.py) on matrices assembled here.
"""
import json
import math
import sys

import numpy as np

import orientation
import rates
from brute import Friction, Point, Step, Unilateral, ratio
from orientation import CONVEX, number
from motion import mass as mass_of
from solids import Solid, block, facet_rule, shapes, slopes, triangle_rule


def tetrahedron_rule():
    """Exact for degree 4: a product of line rules, collapsed."""
    x, w = np.polynomial.legendre.leggauss(5)
    x, w = (1 + x) / 2, w / 2
    out = []
    for a, wa in zip(x, w):
        for b, wb in zip(x, w):
            for c, wc in zip(x, w):
                p = (a, b * (1 - a), c * (1 - a) * (1 - b))
                out.append(((1 - sum(p), *p), 6 * wa * wb * wc * (1 - a) ** 2 * (1 - b)))
    return out


class Scalar:
    """A scalar space of order 1 or 2, and its products with a solid's divergence."""

    def __init__(self, mesh, order):
        self.solid = Solid(mesh, order)
        self.mesh, self.order, self.dim = mesh, order, mesh.dim
        self.own_cells = mesh.cells[sorted(mesh.patch)] if mesh.patch else mesh.cells
        self.n = len(self.solid.points)
        self.rule = triangle_rule(4) if mesh.dim == 2 else tetrahedron_rule()

    def points_in(self, cell):
        """Barycentric coordinates and weights as shares of the cell."""
        return self.rule

    def cells(self):
        for cell in self.own_cells:
            x = self.mesh.points[cell]
            edges = (x[1:] - x[0]).T
            inner = np.linalg.inv(edges)
            yield cell, abs(np.linalg.det(edges)) / math.factorial(self.dim), np.vstack([-inner.sum(0), inner])

    def missing(self):
        """Nodes without a function."""
        return np.setdiff1d(np.arange(self.n), np.concatenate([self.solid.nodes(cell) for cell in self.own_cells]))

    def mass_and_stiffness(self):
        mass, stiffness = np.zeros((2, self.n, self.n))
        for cell, volume, barycentric in self.cells():
            nodes = self.solid.nodes(cell)
            for b, weight in self.points_in(cell):
                v, g = shapes(self.order, b), slopes(self.order, b) @ barycentric
                mass[np.ix_(nodes, nodes)] += weight * volume * np.outer(v, v)
                stiffness[np.ix_(nodes, nodes)] += weight * volume * g @ g.T
        return mass, stiffness

    def divergence(self, body):
        """int p div u: rows p, columns u."""
        out = np.zeros((self.n, body.n))
        for cell, volume, barycentric in self.cells():
            nodes, dofs = self.solid.nodes(cell), body.dofs(body.nodes(cell))
            for b, weight in self.points_in(cell):
                div = self.divergences(body, cell, barycentric, b)
                out[np.ix_(nodes, dofs)] += weight * volume * np.outer(shapes(self.order, b), div)
        return out

    def divergences(self, body, cell, barycentric, b):
        """Of the body's functions at a point of a cell."""
        return (slopes(body.order, b) @ barycentric).ravel()

    def law_points(self, name, rule):
        """(weight, row of values)"""
        out = []
        for f in self.mesh.facets[name]:
            size, _ = self.solid.facet(f)
            for b, weight in facet_rule(self.dim, self.order, rule):
                row = np.zeros(self.n)
                row[self.solid.nodes(f)] = shapes(self.order, b)
                out.append((weight * size, row))
        return out


def has_jumps(law):
    if isinstance(law, Friction):
        return law.static > 0
    return isinstance(law, Unilateral) or any(a != b for a, b in map(law.limits, range(len(law.breaks))))


class FieldTerm(orientation.Term):
    """A law on u, on u' or on the scalar."""

    def __init__(self, *of_term, sees):
        super().__init__(*of_term)
        self.sees = sees

    def points_of(self, scene):
        """Points with rows on all unknowns of a scene, and whose equation they stand in."""
        wide = lambda rows: np.hstack([rows, np.zeros((len(rows), scene.scalar.n))])
        if self.sees != "p":
            return [Point(p.law, p.weight, wide(p.rows), p.offset) for p in self.points(scene.solid)]
        before = np.zeros(scene.solid.n)
        return [Point(self.law, w, np.concatenate([before, row])[None, :], np.zeros(1))
                for w, row in scene.scalar.law_points(self.part, self.rule)]

    def text(self, scene, scale):
        """Declaration and form at a length scale, with the scene's units of p and of its equation."""
        if self.sees == "p":
            form = f"  + {number(scene.unit_of_row * scale)} * integral(bottom, {self.name}^0(p; q), rule = {self.rule})"
            return self.declaration(scene.unit), form
        prime = "'" if self.sees == "rate" else ""
        return self.declaration(scale), self.form().replace("^0(u", f"^0(u{prime}")


class Scene:
    load_of_u = load_of_p = "t"  # their factors of time

    def __init__(self, random):
        self.random = random
        self.dim = 2 if random.random() < 0.75 else 3
        self.kind = str(random.choice(["coupled", "coupled", "incompressible"]))
        high = self.dim == 2 or random.random() < 0.4
        self.order = 2 if self.kind == "incompressible" or (high and random.random() < 0.5) else 1
        order_p = 1 if self.kind == "incompressible" or not high else int(random.integers(1, 3))
        most = (4, 3) if self.dim == 2 else (2, 1, 1) if max(self.order, order_p) == 2 else (3, 2, 2)
        counts = [int(random.integers(1, m + 1)) for m in most]
        self.mesh = block(random, counts, random.uniform(0.5, 2.0, self.dim), 0.2, 0.2 if random.random() < 0.25 else 0.0)
        self.choose_patch()
        self.solid, self.scalar = Solid(self.mesh, self.order), Scalar(self.mesh, order_p)
        self.steps = int(random.integers(1, 4))
        self.density = 10 ** random.uniform(-2, 2) if random.random() < 0.3 else 0.0
        self.unit, self.unit_of_row = 10 ** random.uniform(-5, 5), 10 ** random.uniform(-5, 5)
        self.clamped, self.given = random.choice(["left", "top"]), random.choice(["right", "top"])
        self.choose_forms()
        self.assemble()
        self.choose_loads()
        self.choose_laws()

    def choose_patch(self):
        """All cells at the ground, where laws on the scalar act, and some others; or all."""
        random = self.random
        if random.random() < 0.65:
            return
        ground = {int(v) for f in self.mesh.facets["bottom"] for v in f}
        self.mesh.patch = {k for k, cell in enumerate(self.mesh.cells)
                           if len(ground.intersection(map(int, cell))) >= self.dim or random.random() < 0.4}
        if len(self.mesh.patch) == len(self.mesh.cells):
            self.mesh.patch = ()

    def choose_forms(self):
        random = self.random
        young, poisson = 10 ** random.uniform(0, 3), random.uniform(0.0, 0.42)
        self.elastic = young * poisson / (1 + poisson) / (1 - 2 * poisson), young / 2 / (1 + poisson)
        self.viscous = tuple(v * 10 ** random.uniform(-2, 0) for v in self.elastic)
        if self.kind == "incompressible":
            self.elastic, self.viscous = (0.0, self.elastic[1]), (0.0, self.viscous[1])
            self.to_u, self.to_p, self.to_p_rate = 1.0, float(random.choice([-1.0, 1.0])), 0.0
            self.capacity = self.diffusion = 0.0
            return
        self.to_u = 10 ** random.uniform(-2, 2) * random.choice([-1, 1])
        self.to_p = random.choice([0.0, 1.0]) * 10 ** random.uniform(-2, 1) * np.sign(self.to_u)
        self.to_p_rate = random.choice([0.0, 1.0]) * 10 ** random.uniform(-2, 1) * np.sign(self.to_u)
        self.capacity = random.choice([0.0, 1.0]) * 10 ** random.uniform(-3, 1)
        if self.mesh.patch and self.capacity == 0.0:  # nothing else may hold the scalar there
            self.capacity = 10 ** random.uniform(-3, 1)
        self.diffusion = 10 ** random.uniform(-3, 1)

    def assemble(self):
        solid, scalar = self.solid, self.scalar
        n, m = solid.n, scalar.n
        mass, stiffness = scalar.mass_and_stiffness()
        div = scalar.divergence(solid)
        self.b, self.a = np.zeros((2, n + m, n + m))
        self.b[:n, :n], self.a[:n, :n] = solid.stiffness(*self.elastic), solid.stiffness(*self.viscous)
        self.b[:n, n:] = -self.to_u * div.T
        self.b[n:, :n], self.a[n:, :n] = self.to_p * div, self.to_p_rate * div
        self.b[n:, n:], self.a[n:, n:] = self.diffusion * stiffness, self.capacity * mass
        held = [solid.dofs(solid.on(self.clamped)), n + scalar.missing()]
        if self.kind != "incompressible":
            held.append(n + np.array(scalar.solid.on(self.given)))
        self.m = np.zeros_like(self.a)
        if self.density:
            self.m[:n, :n] = self.density * self.mass()
        self.leave_free(np.setdiff1d(np.arange(n + m), np.concatenate(held)))

    def mass(self):
        return mass_of(self.solid)

    def leave_free(self, free):
        self.free, self.of_p, k = free, free >= self.solid.n, 1 / self.steps
        self.k = (self.m / k ** 2 + self.a / k + self.b)[np.ix_(free, free)]

    def weight(self):
        """Of the scalar's equation, with which the couplings cancel."""
        back = self.to_p + self.to_p_rate * self.steps
        return self.to_u / back if back != 0 else 1.0

    def choose_loads(self):
        random, dim = self.random, self.dim
        self.force, self.traction = (random.normal(size=dim) * 10 ** random.uniform(-1, 1) for _ in range(2))
        self.source = 0.0 if self.kind == "incompressible" else float(random.normal()) * 10 ** random.uniform(-2, 1)
        solid, scalar = self.solid, self.scalar
        of_u = solid.body_load(self.force) + solid.facet_load("right", self.traction)
        of_p = np.zeros(scalar.n)
        for cell, volume, _ in scalar.cells():
            values = sum(w * shapes(scalar.order, b) for b, w in scalar.points_in(cell))
            of_p[scalar.solid.nodes(cell)] += self.source * volume * values
        self.load = np.concatenate([of_u, of_p])[self.free]

    def choose_laws(self):
        random = self.random
        free = np.linalg.solve(self.k, self.load)
        area = sum(self.solid.facet(f)[0] for f in self.mesh.facets["bottom"])
        reaches = {"u": float(np.abs(free[~self.of_p]).max()) or 1.0, "p": float(np.abs(free[self.of_p]).max()) or 1.0}
        self.reaches = dict(reaches, rate=reaches["u"] * self.steps)
        pressures = {"u": float(np.abs(self.load[~self.of_p]).sum()) / area, "p": float(np.abs(self.load[self.of_p]).sum()) / area}
        pressures["p"] = pressures["p"] or reaches["u"]  # of an incompressible body: what flows out
        pressures = {key: v or 1.0 for key, v in dict(pressures, rate=pressures["u"]).items()}
        self.terms = []
        for name in ("first", "second", "third")[:1 + int(random.integers(3))]:
            sees = self.seen_by_a_law()
            self.reach, self.pressure = self.reaches[sees], pressures[sees]
            rubs = any(isinstance(t.law, Friction) for t in self.terms)
            if sees == "p":
                law, argument = orientation.Scene.normal_law(self), ""
                while not self.may_act_on_p(law):
                    law = orientation.Scene.normal_law(self)
            elif rubs or random.random() < 0.6:
                law, argument = orientation.Scene.normal_law(self), ".nu"
            else:
                law, argument = orientation.Scene.friction_law(self), ".tau"
            rule = str(random.choice(["nodal", "midpoint", "gauss"]))
            self.terms.append(FieldTerm(name, "bottom", argument, rule, law, sees=sees))
        for _ in range(80):
            if self.ratio() <= CONVEX:
                return
            orientation.Scene.soften(self, 0.5)
        raise AssertionError("no convex step")

    def seen_by_a_law(self):
        return str(self.random.choice(["u", "rate"] if self.kind == "incompressible" else ["u", "rate", "p"]))

    def may_act_on_p(self, law):
        return not isinstance(law, Unilateral)  # nothing is known to hold p there

    def law_points(self, before=None):
        """Of a step: rows on the free unknowns; `before`: those of the last one."""
        out = []
        for term in self.terms:
            s = self.steps if term.sees == "rate" else 1.0
            for p in term.points_of(self):
                rows = s * p.rows[:, self.free]
                offset = np.zeros(len(rows)) if term.sees != "rate" or before is None else -rows @ before
                out.append(Point(p.law, p.weight / s, rows, offset))
                out[-1].of_p = term.sees == "p"
        return out

    def ratio(self):
        """Of softening to stiffness, in the form that the weight of the scalar's equation makes of the couplings."""
        weights = np.where(self.of_p, self.weight(), 1.0)
        k = (weights[:, None] * self.k + (weights[:, None] * self.k).T) / 2
        seen = np.ones(len(k), bool) if self.capacity or self.diffusion else ~self.of_p
        points = self.law_points()
        for p in points:
            p.rows, p.weight = p.rows[:, seen], p.weight * (self.weight() if p.of_p else 1.0)
        return ratio(np.linalg.inv(k[np.ix_(seen, seen)]), points)

    def known(self, last, velocity):
        """Forces of the last step on the free unknowns."""
        a, m = (matrix[np.ix_(self.free, self.free)] for matrix in (self.a, self.m))
        return self.steps * (a @ last) + m @ (self.steps ** 2 * last + self.steps * velocity)

    def load_at(self, n):
        return self.load * (n / self.steps)

    def reference(self):
        states, velocity = [np.zeros(len(self.free))], np.zeros(len(self.free))
        for n in range(1, self.steps + 1):
            step = Step(self.k, self.law_points(states[-1]))
            new = step.solve(self.load_at(n) + self.known(states[-1], velocity), rates.TURNS)
            if new is None:
                return None
            velocity = self.steps * (new - states[-1])
            states.append(new)
        full = np.zeros((self.steps, self.solid.n + self.scalar.n))
        full[:, self.free] = states[1:]
        self.expected_p = full[:, self.solid.n:]
        return [u.reshape(-1, self.dim) for u in full[:, :self.solid.n]]

    def script(self, turn, scale):
        vector = lambda v: "[" + ", ".join(number(x) for x in turn @ v) + "]"
        p, row = self.unit, self.unit_of_row
        texts = [t.text(self, scale) for t in self.terms]
        zero_p = f", zero on {self.given}" if self.kind != "incompressible" else ""
        where = "patch" if self.mesh.patch else "body"
        parts = sorted({"bottom", "right", str(self.clamped), str(self.given)} | ({"patch"} if self.mesh.patch else set()))
        lines = ['mesh body = gmsh("body.msh")'] + [f'part {name} = body.group("{name}")' for name in parts]
        tensors = {"B": (self.elastic, "u"), "A": (self.viscous, "u'")}
        tensors = {name: of for name, of in tensors.items() if any(of[0])}
        lines += [f"tensor {name} = isotropic(lambda = {number(values[0])}, mu = {number(values[1])})"
                  for name, (values, _) in tensors.items()]
        lines += [declaration for declaration, _ in texts]
        lines += [f"space V = vector P{self.order} on body, zero on {self.clamped}",
                  f"space Q = scalar P{self.scalar.order} on {where}{zero_p}",
                  f"find u in V, p in Q for t in [0, 1] by {self.steps} steps from u = 0, p = 0",
                  "such that for all v in V, q in Q",
                  "    " + " + ".join(f"integral(body, {name} : eps({of}) : eps(v))" for name, (_, of) in tensors.items()),
                  f"  - integral({where}, {number(self.to_u / p)}*p*div(v))"]
        if self.density:  # a mass by length in the scene's units
            lines.append(f"  + integral(body, {number(self.density / scale ** 2)}*dot(u'', v))")
        for factor, what in ((self.to_p * row, "div(u)*q"), (self.to_p_rate * row, "div(u')*q"),
                             (self.capacity * row / p, "p'*q"), (self.diffusion * row * scale ** 2 / p, "dot(grad(p), grad(q))")):
            if factor != 0.0:
                lines.append(f"  + integral({where}, {number(factor)}*{what})")
        lines += [form for _, form in texts]
        lines.append(f" >= integral(body, {self.load_of_u} * dot({vector(self.force / scale)}, v))")
        lines.append(f"  + integral(right, {self.load_of_u} * dot({vector(self.traction)}, v))")
        lines.append(f"  + integral({where}, {self.load_of_p} * {number(self.source * row)} * q)")
        lines.append("report\n  table size = norm(u), other = norm(p)\n  fields u, p")
        return "\n".join(lines) + "\n"

    def bound(self):
        equilibrated = self.k / np.sqrt(np.outer(np.abs(self.k).max(1), np.abs(self.k).max(0)))
        return min(rates.AGREES, 10 * orientation.TOLERANCE * self.steps * np.linalg.cond(equilibrated) / (1 - self.ratio()))

    def size(self):
        return self.reaches["u"]

    def options(self, k):
        return ["--json", "scene.json"]

    def rows_at_rest(self):
        """On the displacements: of the points whose laws have jumps, which hold what rests there."""
        rows = [p.rows[:, ~self.of_p] for p in self.law_points() if has_jumps(p.law)]
        return np.vstack(rows) if rows else np.zeros((0, int((~self.of_p).sum())))

    def ratio_of_p(self):
        """Of softening to stiffness in the scalar's own equation, where displacements do not feel the scalar: then its laws alone decide
        how many scalars there are, and `ratio` with a weight of 0 has left them out."""
        points = [p for p in self.law_points() if p.of_p]
        if self.to_u != 0 or not points:
            return 0.0
        for p in points:
            p.rows = p.rows[:, self.of_p]
        own = self.k[np.ix_(self.of_p, self.of_p)]
        return ratio(np.linalg.inv((own + own.T) / 2), points)

    def determines_p(self):
        """The least part of a pressure that displacements feel, of those that vanish where points may rest: 0 where the pressure and
        forces of laws may share what holds the body."""
        if self.kind != "incompressible":
            return 1.0
        rows = self.rows_at_rest()
        _, sizes, basis = np.linalg.svd(rows)
        free = basis[(sizes > 1e-9 * max(sizes, default=0.0)).sum():]
        felt = self.k[np.ix_(self.of_p, ~self.of_p)]
        least = np.linalg.svd(felt @ free.T)[1] if len(free) >= len(felt) else np.zeros(1)
        return float(least.min() / np.linalg.svd(felt)[1].max())

    def error_besides(self, folder, scale):
        """Of p at the vertices, where it is the only one; then a run may promise one solution, and else not."""
        import meshio

        least = self.determines_p()
        promised = json.loads((folder / "scene.json").read_text())["uniqueness"] == "guaranteed"
        if least < 1e-12 or self.ratio_of_p() >= 1:
            return math.inf if promised else 0.0

        size = max(self.reaches["p"], float(np.abs(self.expected_p).max()))
        worst = 0.0
        for file, p in zip(sorted((folder / "out").glob("scene_[0-9]*.vtu")), self.expected_p):
            grid = meshio.read(file)
            n = len(self.mesh.points)
            worst = max(worst, float(np.abs(grid.point_data["p"].ravel()[:n] / self.unit - p[:n]).max()) / size)
        return worst

    nodes_in = rates.Scene.nodes_in
    told_besides = rates.Scene.told_besides

    def told(self):
        laws = [(t.name, t.sees, t.argument, t.rule, type(t.law).__name__) for t in self.terms]
        besides = (" in a patch" if self.mesh.patch else "") + (" with mass" if self.density else "")
        return f"{self.dim}D {self.kind}{besides} P{self.order}/P{self.scalar.order}, {self.steps} steps, {laws}"


if __name__ == "__main__":
    sys.exit(rates.judge("fields", Scene))
