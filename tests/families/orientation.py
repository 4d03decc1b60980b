"""Well-posed scenes turned, scaled and moved: the same answers, and those of brute force.

usage: orientation.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

Each scene is an elastic or viscoelastic block in 2D or 3D, P1 or P2, with random laws on its ground (each rule) whose
steps are strictly convex. It runs as it is, and turned by a random angle, scaled by up to a million either way and
moved; both displacements are compared with a dense brute force (brute.py) of the scene as it is, or, in the few scenes
where that gives up, with each other.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from brute import Friction, Law, Point, Step, Unilateral, ratio
from solids import Solid, block, turning

TOLERANCE = 1e-10  # the program's own
CONVEX = 0.8  # largest ratio of softening to stiffness
REFUSED_3D = 0.005
UNJUDGED = 0.02  # of the scenes brute force finds no multipliers: points that stick and depend on each other


def number(v):
    return repr(float(v))


class Term:
    """A law on a part, as numbers and as text at any length scale."""

    def __init__(self, name, part, argument, rule, law):
        self.name, self.part, self.argument, self.rule, self.law = name, part, argument, rule, law

    def declaration(self, s):
        law = self.law
        if isinstance(law, Friction):
            weakening = f" + ({number(law.static - law.sliding)})*exp(-({number(law.decay / s)})*norm(xi))"
            return (f"superpotential {self.name}(xi) with slope {number(law.sliding)}"
                    + (weakening if law.static != law.sliding else ""))
        lines = []
        for i, start in enumerate(law.starts):
            slope = number(min(start, 1e300))
            if law.growths[i] != 0.0:
                slope += f" + ({number(law.growths[i] / s)})*(r - ({number(law.anchors[i] * s)}))"
            when = f"r < {number(law.breaks[i] * s)}" if i < len(law.breaks) else "otherwise"
            lines.append(f"  | {when} -> {slope}")
        if len(lines) == 1:
            return f"superpotential {self.name}(r) with slope {lines[0].split('-> ')[1]}"
        return f"superpotential {self.name}(r) with slope\n" + "\n".join(lines)

    def form(self):
        return (f"  + integral({self.part}, {self.name}^0(u{self.argument}; v{self.argument}),"
                f" rule = {self.rule})")

    def points(self, solid):
        out = []
        for weight, values, normal in solid.law_points(self.part, self.rule):
            if self.argument == ".nu":
                rows = normal[None, :] @ values
            elif self.argument == ".tau":
                rows = np.linalg.svd(normal[None, :])[2][1:] @ values
            else:
                rows = values
            out.append(Point(self.law, weight, rows, np.zeros(len(rows))))
        return out


class Scene:
    """Mesh, element, laws and loads; all random."""

    def __init__(self, random):
        self.random = random
        self.dim = self.choose_dim()
        self.order = 1 if random.random() < 0.7 else 2
        most = (6, 4) if self.dim == 2 else (3, 2, 2) if self.order == 1 else (2, 1, 1)
        counts = [int(random.integers(1, m + 1)) for m in most]
        bumps = 0.2 if random.random() < 0.25 else 0.0
        self.mesh = block(random, counts, random.uniform(0.5, 2.0, self.dim), 0.2, bumps)
        self.solid = self.make_solid()
        young = 10 ** random.uniform(0, 3)
        poisson = 0.0 if random.random() < 0.15 else random.uniform(0.05, 0.42)
        self.elastic = young * poisson / (1 + poisson) / (1 - 2 * poisson), young / 2 / (1 + poisson)
        self.viscous = tuple(v * 10 ** random.uniform(-2, 0) for v in self.elastic) if random.random() < 0.4 else None
        self.steps = int(random.integers(1, 4))
        self.clamped = str(random.choice(["top", "left"]))
        self.assemble()
        self.choose_loads()
        self.choose_laws()

    def choose_dim(self):
        return 2 if self.random.random() < 0.7 else 3

    def make_solid(self):
        return Solid(self.mesh, self.order)

    def assemble(self):
        solid, clamped = self.solid, self.solid.on(self.clamped)
        self.free = np.setdiff1d(np.arange(solid.n), solid.dofs(clamped))
        grid = np.ix_(self.free, self.free)
        self.b = solid.stiffness(*self.elastic)[grid]
        self.a = solid.stiffness(*self.viscous)[grid] if self.viscous else np.zeros_like(self.b)
        self.k = self.a * self.steps + self.b
        self.inverse = np.linalg.inv(self.k)

    def choose_loads(self):
        """A force on the body, a traction on the right, each times t; sometimes there is none across the ground."""
        random, dim = self.random, self.dim
        self.force, self.traction = (random.normal(size=dim) * 10 ** random.uniform(-1, 1) for _ in range(2))
        kind = random.random()
        if kind < 0.15:
            self.force, self.traction = 0 * self.force, self.traction * (np.arange(dim) != 1)
        elif kind < 0.35:
            self.force = -np.abs(self.force) * (np.arange(dim) == 1)  # pressed down
        elif kind < 0.45:
            self.traction = 0 * self.traction
        load = self.solid.body_load(self.force) + self.solid.facet_load("right", self.traction)
        self.load = load[self.free]

    def choose_laws(self):
        random = self.random
        free = np.abs(self.inverse @ self.load)
        self.reach = float(free.max()) or 1.0  # a displacement without laws
        area = sum(self.solid.facet(f)[0] for f in self.mesh.facets["bottom"])
        self.pressure = float(np.abs(self.load).sum()) / area
        self.terms = []
        rules = ["nodal", "midpoint", "gauss"]
        kinds = random.random()
        if kinds < 0.75:
            self.terms.append(Term("ground", "bottom", ".nu", str(random.choice(rules)), self.normal_law()))
        if kinds > 0.3:
            argument = "" if random.random() < 0.15 else ".tau"
            self.terms.append(Term("slip", "bottom", argument, str(random.choice(rules)), self.friction_law()))
        for _ in range(60):
            if self.ratio() <= CONVEX:
                return
            self.soften(0.5)
        raise AssertionError("no convex step")

    def normal_law(self):
        random, r, p = self.random, self.reach, self.pressure
        length = r * 10 ** random.uniform(-4, 0)
        stiff = p / r * 10 ** random.uniform(-2, 3)
        kind = random.choice(["unilateral", "compliance", "bounded", "softening", "jump"])
        if kind == "unilateral":
            return Unilateral(0.0 if random.random() < 0.6 else length)
        if kind == "compliance":
            return Law([0.0], [0.0, 0.0], [0.0, 0.0], [0.0, stiff])
        if kind == "bounded":
            return Law([0.0, length], [0.0, 0.0, 0.0], [0.0, 0.0, stiff * length], [0.0, stiff, 0.0])
        if kind == "jump":
            at = 0.0 if random.random() < 0.5 else length
            height = p * 10 ** random.uniform(-8, 8)
            return Law([at], [0.0, 0.0], [-height if random.random() < 0.3 else 0.0, height], [0.0, 0.0])
        fall = p / r * 10 ** random.uniform(-1, 1)
        end = length * random.uniform(1.5, 4)
        return Law([0.0, length, end], [0.0, 0.0, length, 0.0],
                   [0.0, 0.0, stiff * length, stiff * length - fall * (end - length)], [0.0, stiff, -fall, 0.0])

    def friction_law(self):
        random = self.random
        bound = self.pressure * 10 ** (random.uniform(-1.5, 1) if random.random() < 0.6 else random.uniform(-8, 8))
        if random.random() < 0.5:
            return Friction(bound, bound, 0.0)
        return Friction(bound, bound * random.uniform(0.3, 1), 10 ** random.uniform(-1, 2) / self.reach)

    def soften(self, factor):
        """Less descent."""
        for term in self.terms:
            law = term.law
            if isinstance(law, Friction):
                law.decay *= factor
            elif min(law.growths) < 0:
                fall = law.growths[2] * factor
                law.growths[2] = fall
                law.starts[3] = law.starts[2] + fall * (law.breaks[2] - law.breaks[1])

    def law_points(self):
        points = [p for term in self.terms for p in term.points(self.solid)]
        for p in points:
            p.rows = p.rows[:, self.free]
        return points

    def ratio(self):
        return ratio(self.inverse, self.law_points())

    def reference(self):
        """u of the last step on all unknowns, or None where brute force gives up."""
        step = Step(self.k, self.law_points())
        u = np.zeros(len(self.free))
        for n in range(1, self.steps + 1):
            u = step.solve(self.load * (n / self.steps) + self.steps * (self.a @ u))
            if u is None:
                return None
        out = np.zeros(self.solid.n)
        out[self.free] = u
        return out.reshape(-1, self.dim)

    def script(self, turn, scale):
        vector = lambda v: "[" + ", ".join(number(x) for x in turn @ v) + "]"
        lines = ['mesh body = gmsh("body.msh")']
        lines += [f'part {name} = body.group("{name}")' for name in ("bottom", "right", self.clamped)]
        lines.append("tensor B = isotropic(lambda = {}, mu = {})".format(*map(number, self.elastic)))
        if self.viscous:
            lines.append("tensor A = isotropic(lambda = {}, mu = {})".format(*map(number, self.viscous)))
        lines += [t.declaration(scale) for t in self.terms]
        lines.append(f"space V = vector P{self.order} on body, zero on {self.clamped}")
        lines.append(f"find u in V for t in [0, 1] by {self.steps} steps from u = 0 such that for all v in V")
        lines.append("    integral(body, B : eps(u) : eps(v))")
        if self.viscous:
            lines.append("  + integral(body, A : eps(u') : eps(v))")
        lines += [t.form() for t in self.terms]
        lines.append(f" >= integral(body, t * dot({vector(self.force / scale)}, v))")
        lines.append(f"  + integral(right, t * dot({vector(self.traction)}, v))")
        lines.append("report\n  table size = norm(u)\n  fields u")
        return "\n".join(lines) + "\n"


def run(program, folder, scene, turn, scale, shift):
    """u at the nodes of the reference, or what was said instead of an answer."""
    import meshio

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "body.msh").write_text(scene.mesh.moved(turn, scale, shift).msh())
    (folder / "scene.hvi").write_text(scene.script(turn, scale))
    done = subprocess.run([program, "run", "scene.hvi", "--quiet", "-o", "out"], cwd=folder, capture_output=True,
                          text=True, timeout=120)
    if done.returncode != 0:
        return None, f"exit {done.returncode}: " + " ".join(done.stderr.split())[:300]
    grid = meshio.read(sorted((folder / "out").glob("*.vtu"))[-1])
    dim = scene.dim
    at = (grid.points[:, :dim] - shift) @ turn / scale
    u = grid.point_data["u"][:, :dim] @ turn / scale
    nearest = [int(np.argmin(((at - x) ** 2).sum(1))) for x in scene.solid.points]
    return u[nearest], ""


def asked_for(scenes=200):
    """The options of a family."""
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=lambda p: str(pathlib.Path(p).resolve()))
    parser.add_argument("--scenes", type=int, default=scenes)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=lambda text: [int(k) for k in text.split(",")])
    parser.add_argument("--keep", type=pathlib.Path)
    return parser.parse_args()


def seeded(judge, scenes):
    """A family whose scenes have seeds of their own: judge(program, folder, seed) says what is wrong. Exits."""
    options = asked_for(scenes)
    seeds = range(options.seed, options.seed + options.scenes) if options.only is None else options.only
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            found = judge(options.program, (options.keep or pathlib.Path(folder)) / str(seed), seed)
            if found:
                wrong += 1
                print(f"FAILS scene {seed}: {found}", flush=True)
    print(f"{len(seeds)} scenes, {wrong} wrong")
    sys.exit(bool(wrong))


def main():
    options = asked_for()
    certified = wrong = refused = skipped = 0
    refused_in, scenes_in = {2: 0, 3: 0}, {2: 0, 3: 0}
    worst = 0.0
    for k in range(options.scenes) if options.only is None else options.only:
        random = np.random.default_rng([options.seed, k])
        scene = Scene(random)
        turn, scale = turning(random, scene.dim), 10 ** random.uniform(-6, 6)
        shift = scale * random.normal(size=scene.dim) * (0 if random.random() < 0.3 else 10 ** random.uniform(-1, 2))
        expected = scene.reference()
        if expected is None:
            skipped += 1
            print(f"scene {k}: no reference", file=sys.stderr)
        # Certified residuals reach the displacements through the matrix; the laws' softening adds to that.
        bound = 10 * TOLERANCE * np.linalg.cond(scene.k) / (1 - scene.ratio())
        for what, moves in (("as it is", (np.eye(scene.dim), 1.0, 0.0)), ("moved", (turn, scale, shift))):
            with tempfile.TemporaryDirectory() as temporary:
                folder = (options.keep or pathlib.Path(temporary)) / f"{k}_{what.replace(' ', '_')}"
                u, said = run(options.program, folder, scene, *moves)
            scenes_in[scene.dim] += 1
            if u is None:
                refused += 1
                refused_in[scene.dim] += 1
                print(f"scene {k} {what}: refused ({scene.dim}D P{scene.order} "
                      f"{[(t.name, t.rule) for t in scene.terms]}): {said}", file=sys.stderr)
                continue
            certified += 1
            if expected is None:
                expected = u
            error = float(np.abs(u - expected).max()) / scene.reach
            worst = max(worst, error / bound)
            if error > bound:
                wrong += 1
                print(f"scene {k} {what}: off by {error:.2e}, bound {bound:.2e}", file=sys.stderr)
    print(f"worst error by its bound {worst:.2e}, without reference {skipped}, refused in 2D {refused_in[2]}, "
          f"in 3D {refused_in[3]}")
    print(f"family orientation: scenes {sum(scenes_in.values())}, certified {certified}, wrong {wrong}, "
          f"refused {refused}")
    good = wrong == 0 and refused_in[2] == 0 and refused_in[3] <= REFUSED_3D * scenes_in[3] and skipped <= UNJUDGED * options.scenes
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
