"""Laws that fall and drop beside laws of vectors: no step is refused, and every answer holds by the definition.

usage: torn.py HVI_RUN [--sharp] [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

A block in 2D or 3D, static or viscoelastic over three steps, on glue that pulls or repels: a law of the normal displacement or
of its rate, of straight pieces that rise, fall (much faster than the body is stiff, in most scenes), jump up and drop.
Friction on the whole displacement or along the ground, constant, weakening or in steps, stands beside it. No curve of
solutions is followed there. The energy of every step grows without end with the displacement, so that each has a solution, at
least where the energy is lowest: none may be refused (of those with --sharp a few are). From the displacements and multipliers that the program prints an
assembly of the tests' own (solids.py) tells what is left of the equations, and each multiplier is looked for in Clarke's
subdifferential of its law, as near to the argument as printed digits say.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from solids import Solid, block, turning

EQUATIONS, MULTIPLIERS = 1e-9, 1e-7  # of the largest term, of the largest multiplier
NEAR = 1e-9  # of the displacements
REFUSED_SHARP = 0.03  # of the scenes with --sharp, in which nothing but a search for the least energy is sure to end


def number(v):
    return repr(float(v))


class Glue:
    """Straight pieces start + growth*(r - anchor) between breaks."""

    def __init__(self, random, length, force):
        n = int(random.integers(1, 5))
        self.breaks = np.sort(random.uniform(-1, 1.5, n)) * length
        self.anchors = np.append(self.breaks[0], self.breaks)
        self.starts = random.uniform(-1, 1, n + 1) * force
        inner = random.choice([0.0, 1.0, -4.0, -12.0], n + 1) * random.uniform(0.3, 1, n + 1)
        inner[[0, n]] = np.maximum(inner[[0, n]], 0.0)  # far out it falls no more
        self.growths = inner * force / length

    def text(self):
        cases = [f"{number(s)} + {number(g)}*(r - ({number(a)}))" for s, g, a in zip(self.starts, self.growths, self.anchors)]
        lines = [f"  | r < {number(b)} -> {c}" for b, c in zip(self.breaks, cases)]
        return "(r) with slope\n" + "\n".join([*lines, f"  | otherwise -> {cases[-1]}"])

    def off(self, z, xi, near):
        values = []
        for low, high, s, g, a in zip([-math.inf, *self.breaks], [*self.breaks, math.inf], self.starts, self.growths, self.anchors):
            ends = max(low, z[0] - near), min(high, z[0] + near)
            if ends[0] <= ends[1]:
                values += [s + g * (r - a) for r in ends]
        return max(min(values) - xi[0], xi[0] - max(values), 0.0)


class Rub:
    """Friction: a bound by the length of its argument."""

    def __init__(self, random, length, force, sharp):
        kind, a, b, d = random.integers(3), *(random.uniform(0.05, 0.5, 2) * force), random.uniform(0.2, 1) * length
        if sharp:
            kind, d = random.choice([1, 3]), length * 10.0 ** random.uniform(-7, -1)
        if kind == 0:
            self.bound, self.breaks, text = (lambda r: a), [], number(a)
        elif kind == 1:
            self.bound, self.breaks = (lambda r: b + a * math.exp(-r / d)), []
            text = f"{number(b)} + {number(a)}*exp(-norm(w)*{number(1 / d)})"
        elif kind == 3:
            self.bound, self.breaks = (lambda r: (a + b) - a * math.sqrt(min(r / d, 1.0))), [d]
            text = f"{number(a + b)} - {number(a)}*sqrt(min(norm(w)*{number(1 / d)}, 1))"
        else:
            self.bound, self.breaks = (lambda r: a if r < d else b), [d]
            text = f"| norm(w) < {number(d)} -> {number(a)} | otherwise -> {number(b)}"
        self.words = f"(w) with slope {text}"

    def text(self):
        return self.words

    def off(self, z, xi, near):
        r, size = np.linalg.norm(z), np.linalg.norm(xi)
        ends = [max(r - near, 0.0), r, r + near]
        ends += [np.nextafter(b, s) for b in self.breaks for s in (0, math.inf) if ends[0] <= b <= ends[2]]
        values = [self.bound(e) for e in ends]
        best = max(0.0, size - max(values)) if r <= near else math.inf
        if r > 0.0:
            along = xi @ z / r
            across = np.linalg.norm(xi - along * z / r)
            best = min(best, max(min(values) - along, along - max(values), 0.0) + max(0.0, across - size * near / r))
        return best


class Scene:
    def __init__(self, random, sharp):
        dim = int(random.choice([2, 2, 3]))
        counts = random.integers(1, 4 if dim == 2 else 3, dim)
        mesh = block(random, list(counts), list(random.uniform(0.5, 2, dim)), 0.2)
        if random.random() < 0.5:
            mesh = mesh.moved(turning(random, dim), 10.0 ** random.uniform(-2, 2), random.uniform(-1, 1, dim))
        self.solid, self.dim = Solid(mesh, 1), dim
        size = np.ptp(mesh.points, axis=0).max()
        self.steps = int(random.choice([1, 3]))
        self.b, self.a = random.uniform(0.2, 1.5, 2), random.uniform(0.05, 0.5, 2)
        self.u_size = u = 0.2 * size
        self.force = force = 0.2 * random.uniform(0.5, 4)
        self.rate = bool(self.steps > 1 and random.random() < 0.4)
        self.laws = [("glue", Glue(random, u * (3 if self.rate else 1), force), "'" * self.rate, ".nu")]
        self.laws.append(("rub", Rub(random, u, force, sharp), "", str(random.choice(["", ".tau"]))))
        self.pull = random.normal(size=dim) * 0.2 * random.uniform(0.5, 4)

    def vector(self, v):
        return "[" + ", ".join(map(number, v)) + "]"

    def script(self):
        mesh, many = self.solid.mesh, self.steps > 1
        nodes, names = self.solid.on("bottom"), "xyz"[:self.dim]
        columns = [f"u{v}{c} = u.{c} at {self.vector(p)}" for v, p in enumerate(mesh.points) for c in names]
        columns += [f"glue{v} = glue.xi at {self.vector(mesh.points[v])}" for v in nodes]
        columns += [f"rub{v}{c} = rub.xi.{c} at {self.vector(mesh.points[v])}" for v in nodes for c in names]
        laws = " + ".join(f"{name}^0(u{rate}{of}; v{of})" for name, _, rate, of in self.laws)
        terms = ["integral(all, B : eps(u) : eps(v))", *(["integral(all, A : eps(u') : eps(v))"] if many else []), f"integral(ground, {laws})"]
        return "\n".join([
            'mesh all = gmsh("mesh.msh")', 'part roof = all.group("top")', 'part ground = all.group("bottom")',
            f"tensor B = isotropic(lambda = {number(self.b[0])}, mu = {number(self.b[1])})",
            *([f"tensor A = isotropic(lambda = {number(self.a[0])}, mu = {number(self.a[1])})"] if many else []),
            *(f"superpotential {name}{law.text()}" for name, law, *_ in self.laws), "space V = vector P1 on all, zero on roof",
            "find u in V" + (f" for t in [0, 1] by {self.steps} steps from u = 0" if many else ""), "such that for all v in V",
            "  " + " + ".join(terms), f" >= integral(ground, {'t*' if many else ''}dot({self.vector(self.pull)}, v))",
            "report", "  table " + ", ".join(columns), ""])

    def judge(self, table):
        """The worst error of an equation and of a multiplier."""
        solid, dim, names = self.solid, self.dim, "xyz"[:self.dim]
        k_b, k_a = solid.stiffness(*self.b), solid.stiffness(*self.a)
        held = set(solid.on("top"))
        free = solid.dofs([v for v in range(len(solid.points)) if v not in held])
        load = solid.facet_load("bottom", self.pull)
        weights, normals = {}, {}
        for f in solid.mesh.facets["bottom"]:
            size, normal = solid.facet(f)
            for v in f:
                weights[v] = weights.get(v, 0.0) + size / dim
                normals[v] = normal  # the ground is straight
        before, k, equations, multipliers = np.zeros(solid.n), 1.0 / self.steps, 0.0, 0.0
        for row, t in enumerate(table["t"]):
            at = lambda name: float(table[name][row])
            u = np.array([at(f"u{v}{c}") for v in range(len(solid.points)) for c in names])
            if self.steps > 1 and t == 0:
                continue
            f = load * (t if self.steps > 1 else 1.0)
            forces, terms = f - k_b @ u, np.abs(k_b) @ np.abs(u) + np.abs(f)
            if self.steps > 1:
                forces, terms = forces - k_a @ (u - before) / k, terms + np.abs(k_a) @ np.abs(u - before) / k
            # Where all sticks, displacements are rounding of what the forces would do to the body.
            length, found = max(np.abs(u).max(), np.abs(before).max(), 0.01 * self.u_size), []
            for v, w in weights.items():
                n, own = normals[v], slice(dim * v, dim * v + dim)
                for name, law, rate, of in self.laws:
                    y, near = (u[own] - before[own]) / k if rate else u[own], NEAR * length / (k if rate else 1.0)
                    xi = np.array([at(f"glue{v}")]) if of == ".nu" else np.array([at(f"rub{v}{c}") for c in names])
                    z = np.array([n @ y]) if of == ".nu" else y - (n @ y) * n if of == ".tau" else y
                    pushes = w * (xi[0] * n if of == ".nu" else xi)
                    forces[own], terms[own] = forces[own] - pushes, terms[own] + np.abs(pushes)
                    found.append((law.off(z, xi, near) if v not in held else 0.0, np.linalg.norm(xi)))
            equations = max(equations, np.abs(forces[free]).max() / terms[free].max())
            multipliers = max(multipliers, max(e for e, _ in found) / max(self.force, max(x for _, x in found)))
            before = u
        return equations, multipliers


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sharp", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--keep")
    options = parser.parse_args()
    bad = refused = 0
    chosen = [int(k) for k in options.only.split(",")] if options.only else range(options.scenes)
    with tempfile.TemporaryDirectory() as temporary:
        for k in chosen:
            scene = Scene(np.random.default_rng([options.seed, k]), options.sharp)
            folder = pathlib.Path(options.keep or temporary) / f"scene{k}"
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "mesh.msh").write_text(scene.solid.mesh.msh())
            (folder / "scene.hvi").write_text(scene.script())
            run = subprocess.run([options.program, "run", folder / "scene.hvi", "--no-files", "--quiet", "--json", folder / "out.json"],
                                 capture_output=True, text=True)
            if run.returncode != 0:
                refused += 1
                print(f"scene {k}: refused: {' '.join(run.stderr.split())[:200]}")
                continue
            equations, multipliers = scene.judge(json.loads((folder / "out.json").read_text())["table"])
            if not (equations <= EQUATIONS and multipliers <= MULTIPLIERS):
                bad += 1
                print(f"scene {k}: wrong: equations {equations:.1e}, multipliers {multipliers:.1e}")
    print(f"{len(chosen)} scenes, {bad} wrong, {refused} refused")
    return 1 if bad or refused > (REFUSED_SHARP * len(chosen) if options.sharp else 0) else 0


if __name__ == "__main__":
    sys.exit(main())
