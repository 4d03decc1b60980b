"""Bodies that slide along round grounds: polygons and polyhedra of circles, cylinders and balls have one normal at a node.

usage: curved.py HVI_RUN [--scenes N] [--seed S]

- turns: a stiff piece of a ring, of a tube or of a shell of a ball on a wall that holds it along the normal, both ways, with springs along the
  ground, under a uniform force (2D and 3D, P1 and P2, ground inside or outside, cells of many lengths, turned, scaled and moved). Reference
  (analytic): the wall leaves the motions along it free, rigid ones of a body about its centre or axis; springs and force give them by a balance of
  moments, which is summed over the nodes of the ground. A node that two flat facets held each along its own normal could not move at all, however
  fine the mesh: the paradox of I. Babuska ("Necessary and sufficient conditions for avoiding Babuska's paradox on simplicial meshes",
  arXiv:2401.05897).
- belt: a thin belt around a part of a drum slides with Coulomb's friction. Reference (analytic; L. Euler, J. A. Eytelwein): its tensions are as
  exp(mu angle), with the moment that the belt's thickness h adds, dT (R + h/2) = mu T R dangle.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from solids import Fans, Mesh, Solid, block, facet_rule, shapes, turning

TURNS = 0.7   # of the square of the angle from facet to facet, of a displacement
STRAINS = 0.05  # of a displacement: the body is a thousand times as stiff as the springs
BELT = 0.006  # of a tension


def solve(program, script, mesh):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "a.hvi").write_text(script)
        (folder / "body.msh").write_text(mesh.msh())
        done = subprocess.run([program, "run", "a.hvi", "--quiet", "--no-files", "--json", "a.json"], cwd=folder, capture_output=True,
                              text=True, timeout=600)
        assert done.returncode == 0, script + done.stdout + done.stderr
        data = json.loads((folder / "a.json").read_text())
        assert data["certificate"]["certified"]
        return {name: values[-1] for name, values in data["table"].items()}


def vector(v):
    return "[" + ", ".join(repr(float(c)) for c in v) + "]"


class Turns:
    def __init__(self, random):
        self.dim = int(random.integers(2, 4))
        self.order = int(random.integers(1, 3))
        self.ball = self.dim == 3 and random.random() < 0.5
        self.side = ("bottom", "top")[int(random.integers(2))]
        n = int(random.integers(6, 12)) if self.dim == 2 else int(random.integers(4, 7))
        counts = [n, 2] if self.dim == 2 else [n, 2, int(random.integers(2, 5))]
        flat = block(random, counts, [1.0] * self.dim, 0.1)
        self.angle = random.uniform(0.5, 1.5)
        self.turn, self.scale = turning(random, self.dim), 10 ** random.uniform(-3, 3)
        self.centre = self.scale * random.normal(size=self.dim)
        self.steps = np.cumsum([0.0, *random.uniform(0.5, 1.5, n)])
        self.coarse = max(self.angle * np.diff(self.steps).max() / self.steps[-1], 0.7 / counts[2] if self.ball else 0.0)
        mesh = Mesh([self.bent(p) for p in flat.points], flat.cells, flat.facets)
        self.mesh = mesh.moved(self.turn, self.scale, self.centre)
        self.force, self.k = random.normal(size=self.dim), 10 ** random.uniform(-2, 2)

    def bent(self, p):
        """Of the unit box, in units of the ground's radius: y is along the radius, x and z go around."""
        r = 1.0 + 0.4 * (p[1] if self.side == "bottom" else p[1] - 1.0)
        a = self.angle * np.interp(p[0] * (len(self.steps) - 1), range(len(self.steps)), self.steps) / self.steps[-1]
        if self.dim == 2:
            return [r * np.sin(a), r * np.cos(a)]
        if not self.ball:
            return [r * np.sin(a), r * np.cos(a), p[2]]
        b = 0.7 * (p[2] - 0.5)
        return [r * np.sin(a) * np.cos(b), r * np.cos(a) * np.cos(b), r * np.sin(b)]

    def motions(self, x):
        """The rigid motions along the ground at x, as columns."""
        y = self.turn.T @ (x - self.centre) / self.scale
        if self.dim == 2:
            return self.turn @ np.array([[y[1]], [-y[0]]])
        about = np.array([[0, y[2], -y[1]], [-y[2], 0, y[0]], [y[1], -y[0], 0]])
        return self.turn @ (about if self.ball else np.column_stack([about[:, 2], [0, 0, 1]]))

    def expected(self):
        """Motions that springs and force leave: the least of k/2 int |u|^2 ds - int F . u dx, at the points of the rule."""
        solid = Solid(self.mesh, self.order)
        stiff, load = 0.0, 0.0
        fans = Fans(solid, self.mesh.facets[self.side])
        for i, f in enumerate(fans.facets):
            for b, weight in facet_rule(self.dim, self.order, "nodal"):
                g = self.motions(shapes(1, b) @ self.mesh.points[list(f)])
                stiff = stiff + self.k * weight * fans.sizes[i] * g.T @ g
        for cell in self.mesh.cells:
            x = self.mesh.points[cell]
            volume = abs(np.linalg.det((x[1:] - x[0]).T)) / (2 if self.dim == 2 else 6)
            load = load + volume * self.motions(x.mean(0)).T @ self.force
        return np.linalg.solve(stiff, load)

    def judge(self, program):
        k, motions = repr(float(self.k)), self.expected()
        at = self.mesh.points[[0, -1]]
        places = [f"u{i}{c} = u.{c} at {vector(x)}" for i, x in enumerate(at) for c in "xyz"[:self.dim]]
        found = solve(program, f"""
mesh body = gmsh("body.msh")
part ground = body.group("{self.side}")
tensor B = isotropic(young = {1e3 * self.k * self.scale!r}, poisson = 0.2)
superpotential wall(r) with slope | r < 0 -> -1e300 | otherwise -> 1e300
superpotential spring(s) = 0.5*{k}*norm(s)^2
space V = vector P{self.order} on body
find u in V such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(ground, wall^0(u.nu; v.nu) + spring^0(u.tau; v.tau))
 >= integral(body, dot({vector(self.force)}, v))
report
  table {", ".join(places)}
""", self.mesh)
        wanted = np.concatenate([self.motions(x) @ motions for x in at])
        u = np.array([found[f"u{i}{c}"] for i in range(2) for c in "xyz"[:self.dim]])
        return np.abs(u - wanted).max() / np.abs(wanted).max(), TURNS * self.coarse ** 2 + STRAINS

    def __str__(self):
        kind = "ring" if self.dim == 2 else "ball" if self.ball else "tube"
        return f"turns, {kind} P{self.order}, ground {self.side}, {np.degrees(self.coarse):.0f} degrees from facet to facet"


class Belt:
    def __init__(self, random):
        self.angle, self.mu, self.n = random.uniform(1.0, 4.0), random.uniform(0.1, 0.5), int(random.integers(60, 90))
        self.h, self.scale = 0.01, 10 ** random.uniform(-3, 3)
        c, s = np.cos(self.angle), np.sin(self.angle)
        self.turn = np.array([[c, -s], [s, c]])  # the tight end along x
        flat = block(random, [self.n, 1], [1.0, 1.0])
        around = lambda p: (1 + self.h * p[1]) * np.array([np.sin(self.angle * p[0]), np.cos(self.angle * p[0])])
        self.mesh = Mesh([around(p) for p in flat.points], flat.cells, flat.facets).moved(self.turn, self.scale, self.scale * random.normal(size=2))

    def judge(self, program):
        slack = self.turn @ [-1.0, 0.0]
        force = 0.02  # of the belt's stiffness: it bends around the drum almost as a thread
        grip = np.exp(self.mu * self.angle / (1 + self.h / 2))
        pull = 3 * force * grip * self.angle * self.scale
        found = solve(program, f"""
import contact
mesh belt = gmsh("body.msh")
part drum = belt.group("bottom")
part slack = belt.group("left")
part tight = belt.group("right")
tensor B = isotropic(young = 1, poisson = 0)
superpotential wall(r) = unilateral(r)
superpotential rub(s) = {self.mu!r}*wall.xi*norm(s)
space V = vector P2 on belt, zero.x on tight
find u in V with u.x = {float(pull)!r}*t on tight for t in [0, 1] by 1 steps from u = 0
such that for all v in V
    integral(belt, B : eps(u) : eps(v)) + integral(drum, wall^0(u.nu; v.nu) + rub^0(u'.tau; v.tau))
 >= integral(slack, dot({vector(force * slack)}, v))
report
  table held = reaction(tight)
""", self.mesh)
        tension = found["held_x"] / (force * self.h * self.scale)
        return abs(tension / grip - 1), BELT

    def __str__(self):
        return f"belt, {np.degrees(self.angle):.0f} degrees, mu {self.mu:.2f}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=24)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    wrong, worst = 0, 0.0
    for k in range(options.scenes):
        random = np.random.default_rng([options.seed, k])
        scene = (Belt if k % 4 == 3 else Turns)(random)
        error, bound = scene.judge(options.program)
        worst = max(worst, error / bound)
        if not error <= bound:
            wrong += 1
            print(f"scene {k}: off by {error:.2e}, bound {bound:.1e} ({scene})")
    print(f"family curved: scenes {options.scenes}, wrong {wrong}, worst by its bound {worst:.2e}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
