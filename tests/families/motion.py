"""Inertia with laws on u, on u' and on memories, on random scenes: the answers of brute force at every step.

usage: motion.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of rates.py with a mass, an initial velocity or none, with or without viscosity, and each scheme: backward
Euler, BDF2, Newmark's, HHT with any alpha, and the midpoint rule, which takes the mass off nodes of unilateral laws.
Schemes, initial accelerations and that mass are worked out again here, on dense matrices.
"""
import math
import sys

import numpy as np

import rates
from brute import Friction, Law, Point, Step, Unilateral
from orientation import number
from rates import TURNS
from solids import shapes

SCHEMES = ["backward_euler", "bdf2", "newmark", "hht", "midpoint"]


def mass(solid):
    """int u . v."""
    out = np.zeros((solid.n, solid.n))
    for cell in solid.mesh.cells:
        x = solid.mesh.points[cell]
        volume = abs(np.linalg.det((x[1:] - x[0]).T)) / math.factorial(solid.dim)
        dofs = solid.dofs(solid.nodes(cell))
        for b, weight in product_rule(solid.dim):
            n = shapes(solid.order, b)
            out[np.ix_(dofs, dofs)] += weight * volume * np.kron(np.outer(n, n), np.eye(solid.dim))
    return out


def product_rule(dim):
    """Exact for products of quadratic functions: Gauss on a cube, collapsed to the simplex."""
    x, w = np.polynomial.legendre.leggauss(5)
    x, w = (1 + x) / 2, w / 2
    if dim == 2:
        return [((1 - a, a * (1 - b), a * b), 2 * u * v * a) for a, u in zip(x, w) for b, v in zip(x, w)]
    return [((1 - a, a * (1 - b), a * b * (1 - c), a * b * c), 6 * u * v * r * a * a * b)
            for a, u in zip(x, w) for b, v in zip(x, w) for c, r in zip(x, w)]


def extended(solid, massless):
    """P: values at massless nodes follow affinely, by the shortest weights, from nodes of as few rings as will do."""
    near = [set() for _ in solid.points]
    for cell in solid.mesh.cells:
        nodes = solid.nodes(cell)
        for i in nodes:
            near[i].update(nodes)
    p = np.eye(len(solid.points))
    for c in sorted(massless):
        ring = {c}
        for _ in range(4):
            ring = set().union(*(near[i] for i in ring))
            others = sorted(ring - massless)
            if len(others) <= solid.dim:
                continue
            v = solid.points[others] - solid.points[c]
            v = np.hstack([np.ones((len(others), 1)), v / np.abs(v).max()])
            values = np.linalg.eigvalsh(v.T @ v)
            if values[0] > 1e-4 * values[-1]:
                p[c] = 0
                p[c, others] = np.linalg.pinv(v.T) @ np.eye(solid.dim + 1)[0]
                break
    return np.kron(p, np.eye(solid.dim))


class Scene(rates.Scene):
    def __init__(self, random):
        self.scheme = str(random.choice(SCHEMES))
        self.alpha = -random.uniform(0, 1 / 3) if random.random() < 0.7 else -0.1
        self.damped = random.random() < 0.6
        self.pushed = random.random() < 0.5
        super().__init__(random)

    @property
    def bdf2(self):
        """Are memories those of functions affine on the steps?"""
        return self.scheme != "backward_euler"

    @bdf2.setter
    def bdf2(self, _):
        pass

    def assemble(self):
        random, solid = self.random, self.solid
        self.density = sum(self.elastic) * 10 ** random.uniform(-3, 1)
        self.moved_mass = self.density * mass(solid)
        super().assemble()

    def choose_laws(self):
        super().choose_laws()
        self.begin_motion()

    def begin_motion(self):
        """The mass that laws leave, and the initial velocity."""
        solid = self.solid
        if self.scheme == "midpoint":
            massless = set()
            for term in self.terms:
                if isinstance(term.law, Unilateral) and term.sees == "u":
                    for p in term.points(solid):
                        massless |= {int(i) // self.dim for i in np.nonzero(np.abs(p.rows).max(0))[0]}
            p = extended(solid, massless)
            self.moved_mass = p.T @ self.moved_mass @ p
            self.load = p[np.ix_(self.free, self.free)].T @ self.load
        self.velocity = np.zeros(solid.n)
        self.push = None
        self.jolt = 0.0  # what the initial acceleration does in the first step: the scale of its rounding
        if self.pushed and self.moves is None:
            # c (distance from what is held)
            axis, at = (0, 0.0) if self.clamped == "left" else (1, solid.points[:, 1].max())
            self.push = axis, at, self.random.normal(size=self.dim) * self.reach * 10 ** self.random.uniform(-1, 1)
            self.velocity = np.kron(solid.points[:, axis] - at, self.push[2])
            held = np.abs(self.velocity[self.clamped_dofs]).max()
            if held > 1e-12 * np.abs(self.velocity).max():
                self.push, self.velocity = None, np.zeros(solid.n)
        if self.moves is not None:
            self.velocity[self.clamped_dofs] = self.held_at(1e-3) / 1e-3 / (1.3 - 1e-3) * 1.3

    def newmark(self):
        if self.scheme == "newmark":
            return 0.25, 0.5
        return (1 - self.alpha) ** 2 / 4, 0.5 - self.alpha

    def shares(self):
        """Of u and memories, of u', of u'' at t_n; of u, memories and u' at t_{n-1}; of multipliers there."""
        if self.scheme == "midpoint":
            return 0.5, 1.0, 1.0, (0.5, 0.0), 0.0
        if self.scheme == "hht":
            q = -self.alpha / (1 + self.alpha)
            return 1.0, 1.0, 1 / (1 + self.alpha), (q, q), q
        return 1.0, 1.0, 1.0, (0.0, 0.0), 0.0

    def rate(self, n):
        k = self.grid[n] - self.grid[n - 1]
        if self.scheme in ("newmark", "hht"):
            beta, gamma = self.newmark()
            return gamma / (beta * k), 0.0
        if self.scheme == "bdf2" and n > 1:
            w = k / (self.grid[n - 1] - self.grid[n - 2])
            if w <= 100:
                return (1 + 2 * w) / ((1 + w) * k), w * w / ((1 + w) * k)
        return 1 / k, 0.0

    def acceleration(self, n):
        """s in u'' = s d + known."""
        k = self.grid[n] - self.grid[n - 1]
        if self.scheme in ("newmark", "hht"):
            return 1 / (self.newmark()[0] * k * k)
        return 2 / k**2 if self.scheme == "midpoint" else self.rate(n)[0] ** 2

    def known_rates(self, n, now):
        """What is known of u' and of u''."""
        k = self.grid[n] - self.grid[n - 1]
        if self.scheme in ("newmark", "hht"):
            beta, gamma = self.newmark()
            return ((1 - gamma / beta) * now.v + k * (1 - gamma / (2 * beta)) * now.a,
                    -now.v / (beta * k) - (1 / (2 * beta) - 1) * now.a)
        if self.scheme == "midpoint":
            return 0 * now.v, -2 / k * now.v
        s, c = self.rate(n)
        return -c * now.d, s * (-c * now.d - now.v) - c * now.gained

    def imposed_jump(self, n):
        """Imposed entries of a step that is more than 100 times as long as the one before, which stands for a jump of theirs: d/k is their velocity."""
        lengths = np.diff(self.grid)
        jumps = self.moves is not None and n > 1 and lengths[n - 1] > 100 * lengths[n - 2]
        return self.clamped_dofs if jumps and self.scheme in ("newmark", "hht", "midpoint") else self.clamped_dofs[:0]

    def matrix(self, n):
        u, v, a, _, _ = self.shares()
        memory = self.history(n, self.memory)[n] if self.memory else 0.0
        viscous = self.all_a if self.damped else 0 * self.all_a
        k = a * self.acceleration(n) * self.moved_mass + v * self.rate(n)[0] * viscous + u * (1 + memory) * self.all_b
        return k[np.ix_(self.free, self.free)]

    def points_at_start(self, term):
        return term.points(self.solid)

    def open_forces(self):
        """At t = 0: the known forces of the laws on all unknowns, and points whose forces are open."""
        force, points = np.zeros(self.solid.n), []
        for term in self.terms:
            for p in self.points_at_start(term):
                z = p.rows @ self.velocity if term.sees == "rate" else np.zeros(len(p.rows))
                moves = p.rows @ self.velocity if term.sees == "u" else np.zeros(len(p.rows))
                moves = moves * (np.abs(moves).max() > 1e-12 * np.abs(self.velocity).max())
                law, xi = p.law, None
                if isinstance(law, Friction):
                    direction = z if np.abs(z).max() > 1e-12 * np.abs(self.velocity).max() else moves
                    if np.abs(direction).max() > 0:
                        xi = law.slope(np.linalg.norm(z)) * direction / np.linalg.norm(direction)
                    else:
                        law = Friction(law.slope(0.0), law.slope(0.0), 0.0)
                else:
                    z, moves = float(z[0]), float(moves[0])
                    if abs(z) <= 1e-12 * np.abs(self.velocity).max():
                        z = 0.0
                    at = [i for i, b in enumerate(law.breaks) if b == z]
                    if at and law.limits(at[0])[0] != law.limits(at[0])[1]:
                        low, high = law.limits(at[0])
                        if moves > 0 and high < 1e200:
                            xi = [high]
                        elif moves < 0:
                            xi = [low]
                        else:
                            law = Unilateral(0.0) if high > 1e200 else Law([0.0], [0.0, 0.0], [low, high], [0.0, 0.0])
                    elif isinstance(law, Unilateral):
                        xi = [0.0]
                    else:
                        piece = next(i for i in range(len(law.starts)) if law.ends(i)[0] <= z <= law.ends(i)[1])
                        xi = [law.slope(piece, z)]
                if xi is None:
                    points.append(Point(law, p.weight, p.rows[:, self.free], 0 * p.offset))
                else:
                    force += p.weight * p.rows.T @ np.array(xi)
        return force, points

    def start(self):
        """u''(0) and the forces of the laws there."""
        out = np.zeros(self.solid.n)
        if self.moves is not None:
            out[self.clamped_dofs] = -2 * np.tile(self.reach * self.moves[:self.dim], len(self.clamped_dofs) // self.dim)
        viscous = self.all_a if self.damped else 0 * self.all_a
        force, points = self.open_forces()
        points = [p for p in points if np.abs(p.rows).max() > 0]
        f = (-viscous @ self.velocity - self.moved_mass @ out - force)[self.free]
        m = self.moved_mass[np.ix_(self.free, self.free)]
        a = Step(m, points).solve(f, TURNS) if points else np.linalg.solve(m, f)
        if a is None:
            return None, None
        out[self.free] = a
        force[self.free] += f - m @ a
        self.jolt = self.grid[1] ** 2 * float(np.abs(out).max())
        return out, force[self.free]

    def reference(self):
        u, v, a, (q_u, q_v), q_laws = self.shares()
        viscous = self.all_a if self.damped else 0 * self.all_a
        zero = np.zeros(self.solid.n)
        now = Now(self.velocity.copy(), zero, zero, zero)
        reaction, memory_before, load_before = np.zeros(len(self.free)), zero, self.load * self.load_at(0.0)
        if self.scheme in ("newmark", "hht"):
            now.a, reaction = self.start()
            if now.a is None:
                return None
        states = [zero]
        self.speeds = [self.velocity]  # u' as laws see it
        for n in range(1, len(self.grid)):
            t, last, k = self.grid[n], states[-1], self.grid[n] - self.grid[n - 1]
            s, c = self.rate(n)
            s2 = self.acceleration(n)
            known_v, known_a = self.known_rates(n, now)
            held = np.zeros(self.solid.n)
            held[self.clamped_dofs] = self.held_at(t)
            jumps = self.imposed_jump(n)
            moved = (held - last)[jumps]
            known_v[jumps], known_a[jumps] = moved * (1 / k - s), (moved / k - now.v[jumps]) / k - moved * s2
            weights = self.history(n, self.memory) if self.memory else np.zeros(n + 1)
            memory_known = sum(w * state for w, state in zip(weights, states)) + weights[n] * held
            # All that does not move with the unknowns; u_n = held + (0 on what is held, the unknowns elsewhere).
            known = (a * self.moved_mass @ (s2 * (held - last) + known_a) + v * viscous @ (s * (held - last) + known_v)
                     + u * self.all_b @ (held + memory_known)
                     + q_u * self.all_b @ (last + memory_before) + q_v * viscous @ now.v)
            load = self.load * self.load_at(t)
            points = self.law_points(n, (held, states, known_v))
            right = u * load + q_u * load_before - known[self.free] - q_laws * reaction
            matrix = self.matrix(n)
            x = Step(matrix, points).solve(right, TURNS)
            if x is None:
                return None
            new = held.copy()
            new[self.free] = x
            reaction = right - matrix @ x
            d = new - last
            rate = s * d + known_v
            self.speeds.append(rate)
            if self.scheme == "midpoint":
                velocity = 2 * d / k - now.v
                velocity[jumps] = moved / k
            else:
                velocity = rate
            now = Now(velocity, s2 * d + known_a, d, velocity - now.v)
            memory_before = sum(w * state for w, state in zip(weights, [*states, new]))
            load_before = load
            states.append(new)
        return [x.reshape(-1, self.dim) for x in states[1:]]

    def script(self, turn, scale):
        text = super().script(turn, scale)
        text = text.replace(" using scheme = bdf2", "")
        start = "from u = 0"
        if self.push is not None:
            axis, at, speed = self.push
            along = turn[:, axis]
            distance = " + ".join(f"({number(along[i] / scale)})*{'xyz'[i]}" for i in range(self.dim))
            values = ", ".join(f"{number(scale * c)}*({distance} - ({number(at)}))" for c in turn @ speed)
            start += f", u' = [{values}]"
        scheme = f" using scheme = {self.scheme}"
        if self.scheme == "hht":
            scheme += f", hht_alpha = {number(self.alpha)}"
        text = text.replace("from u = 0", start + scheme)
        inertia = f"integral(body, {number(self.density / scale**2)}*dot(u'', v))\n  + integral(body, B : eps(u) : eps(v))"
        text = text.replace("integral(body, B : eps(u) : eps(v))", inertia)
        if not self.damped:
            text = text.replace("  + integral(body, A : eps(u') : eps(v))\n", "")
            text = "\n".join(line for line in text.split("\n") if not line.startswith("tensor A"))
        return text

    def size(self):
        return max(self.reach, self.jolt)

    def told(self):
        return f"{self.scheme}{' pushed' if self.push else ''}{' damped' if self.damped else ''}: {super().told()}"


class Now:
    """u', u'', the last increment and that of u'."""

    def __init__(self, v, a, d, gained):
        self.v, self.a, self.d, self.gained = v, a, d, gained


if __name__ == "__main__":
    sys.exit(rates.judge("motion", Scene))
