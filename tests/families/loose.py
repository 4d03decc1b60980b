"""Bodies that laws alone hold, turned and scaled: on an incline, on a second body, hinged to each other, worn.

usage: loose.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER] [-- OPTION...]

Three kinds of scenes, each turned by a random rotation, in random units, with meshes that do not match where there are
two. Which of them can be solved, and with which forces, follows from the statics of rigid bodies:

- incline: a block on a slope, which is a law's ground or a second body (2D and 3D, P1 and P2), held by Coulomb's
  friction or by one of a given bound; it slides beyond the angle of friction and tips over beyond the edge of its base.
- arch: two bars that lean against each other and have one node in common, their hinge, on two feet with friction. The
  thrust follows from the moments of each bar about the hinge, for a resultant anywhere in a foot.
- worn: a block pressed on the ground, or on a second body, which wears off in proportion to the pressure. Without
  Poisson's effect the pressure is even, and how far the block sinks is a sum over the steps.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from solids import Mesh, block, turning

NEAR = 0.06  # scenes this near to a limit are drawn again


def number(v):
    return repr(float(v))


def vector(v):
    return "[" + ", ".join(number(x) for x in v) + "]"


class Scene:
    """Lengths are in `size`, stresses in `young`; the first axis lies along the ground, the second one points up."""

    can_hold = True

    def __init__(self, random):
        self.random = random
        self.dim = 2 if random.random() < 0.55 else 3
        self.order = 1 if random.random() < 0.7 or self.dim == 3 and random.random() < 0.5 else 2
        self.pair = random.random() < 0.6
        self.young, self.size = 10.0 ** random.uniform(-2, 6), 10.0 ** random.uniform(-3, 3)
        while not self.draw():
            pass
        self.turn = turning(random, self.dim)

    def counts(self):
        """Of cells, of a block."""
        most = (5, 3) if self.dim == 2 else (4, 2, 3) if self.order == 1 else (2, 1, 2)
        return [int(self.random.integers(2 if k != 1 else 1, m + 1)) for k, m in enumerate(most)]

    def along(self, v):
        """A vector in the scene's axes, turned."""
        return self.turn @ np.array(v)

    def place(self, mesh):
        return mesh.moved(self.turn, self.size, 0.0)

    def floor(self, sizes, counts, wider):
        """A second block under one of these sizes; its top is at height 0."""
        more = np.array([s * (1 + 2 * wider) if k != 1 else 0.5 * s for k, s in enumerate(sizes)])
        mesh = block(self.random, counts, more, 0.15)
        mesh.points -= np.array([s * wider if k != 1 else 0.5 * s for k, s in enumerate(sizes)])
        return mesh

    def bodies(self, folder, upper, lower=None):
        (folder / "upper.msh").write_text(self.place(upper).msh())
        if lower is None:
            return ['mesh body = gmsh("upper.msh")', 'part ground = body.group("bottom")',
                    'part top = body.group("top")', f"space V = vector P{self.order} on body"]
        (folder / "lower.msh").write_text(self.place(lower).msh())
        return ['mesh upper = gmsh("upper.msh")', 'mesh lower = gmsh("lower.msh")', "mesh body = upper + lower",
                'part ground = pair(upper.group("bottom"), lower.group("top"))', 'part top = upper.group("top")',
                'part base = lower.group("bottom")', f"space V = vector P{self.order} on body, zero on base"]

    @property
    def jump(self):
        return ("jump(u)", "jump(v)") if self.pair else ("u", "v")

    def components(self, name):
        return [f"integral(ground, {name}.xi.{c})" for c in "xyz"[:self.dim]]


class Incline(Scene):
    name = "incline"

    def draw(self):
        real = self.random.uniform
        self.sizes = real(0.5, 1.5, self.dim)
        self.slope = real(0.0, 0.8)
        azimuth = real(0, 2 * math.pi) if self.dim == 3 else 0.0
        self.downhill = np.array([math.cos(azimuth), 0.0, math.sin(azimuth)][:self.dim])
        self.friction, self.coulomb = real(0.1, 1.0), self.random.random() < 0.6
        weight = 1e-3 * np.prod(self.sizes)
        self.press, self.shear = weight * math.cos(self.slope), weight * math.sin(self.slope)
        base = np.prod(self.sizes) / self.sizes[1]
        bound = self.friction * (self.press if self.coulomb else 1e-3 * base)
        slides = 1 - self.shear / bound
        off = 0.5 * self.sizes[1] * math.tan(self.slope) * np.abs(self.downhill)
        tips = min(1 - 2 * off[k] / self.sizes[k] for k in range(self.dim) if k != 1)
        self.distance = min(slides, tips)
        self.can_hold = self.distance > 0
        return abs(self.distance) > NEAR

    def script(self, folder):
        e, s = self.young, self.size
        upper = block(self.random, self.counts(), self.sizes, 0.15)
        lower = self.floor(self.sizes, self.counts(), 0.2) if self.pair else None
        u, v = self.jump
        density = 1e-3 * e / s * self.along(math.sin(self.slope) * self.downhill - math.cos(self.slope) * np.eye(self.dim)[1])
        most = f"{number(self.friction)}*abs(across.xi)" if self.coulomb else number(1e-3 * e * self.friction)
        unit = number(e * s ** (self.dim - 1))
        loaded = "upper" if self.pair else "body"
        return ["import contact", *self.bodies(folder, upper, lower),
                f"tensor B = isotropic(young = {number(e)}, poisson = 0.3)",
                "superpotential across(r) = unilateral(r)", f"superpotential along(xi) = {most}*norm(xi)",
                "find u in V", "such that for all v in V", "    integral(body, B : eps(u) : eps(v))",
                f"  + integral(ground, across^0({u}.nu; {v}.nu) + along^0({u}.tau; {v}.tau))",
                f" >= integral({loaded}, dot({vector(density)}, v))", "report",
                f"  table press = integral(ground, across.xi)/{unit}, " +
                ", ".join(f"t{k} = {c}/{unit}" for k, c in enumerate(self.components("along")))]

    def wrong(self, final):
        shear = self.along(self.shear * self.downhill)
        off = max(abs(final["press"] - self.press), *(abs(final[f"t{k}"] - shear[k]) for k in range(self.dim)))
        return "" if off <= 1e-8 * self.press else f"forces {final} of {self.press}, {shear}"

    def told(self):
        return f"slope {self.slope:.3g}, {'Coulomb' if self.coulomb else 'bound'} {self.friction:.3g}, distance {self.distance:.3g}"


class Arch(Scene):
    name = "arch"

    def draw(self):
        real = self.random.uniform
        self.dim, self.pair = 2, False
        self.order = 1 if self.random.random() < 0.7 else 2
        self.length, self.thick, self.lean = real(1.0, 3.0), real(0.1, 0.5), real(0.3, 1.2)
        self.friction = real(0.05, 0.8)
        self.can_hold = self.holds(self.friction * (1 - NEAR))
        return self.can_hold == self.holds(self.friction * (1 + NEAR))

    def holds(self, mu):
        """A resultant at s in the foot, N along the bar and T across it, for the weight 1 of a bar."""
        c, s = math.cos(self.lean), math.sin(self.lean)
        for at in np.linspace(0.0, self.thick, 2001):
            down = self.length * s / c - at
            if abs(down) < 1e-9:
                continue
            n = (self.length / c - (self.length * c + self.thick * s) / 2) / down
            t = (1 - n * s) / c
            if n >= 0 and abs(t) <= mu * n:
                return True
        return False

    def bars(self):
        """Both, with the corners at the ends of their lower sides as one node."""
        c, s = math.cos(self.lean), math.sin(self.lean)
        out = []
        for side in (1, -1):
            mesh = block(self.random, [int(self.random.integers(3, 9)), int(self.random.integers(1, 4))],
                         [self.length, self.thick], 0.15)
            corner = int(np.argmin(np.linalg.norm(mesh.points - [self.length, 0.0], axis=1)))
            x, y = mesh.points.T
            mesh.points = np.column_stack([side * (x * c - y * s - self.length * c), x * s + y * c])
            out.append((mesh, corner))
        (left, at_left), (right, at_right) = out
        n = len(left.points)
        index = np.array([at_left if k == at_right else n + k - (k > at_right) for k in range(len(right.points))])
        points = np.vstack([left.points, np.delete(right.points, at_right, axis=0)])
        facets = {"left": left.facets["left"], "right": [tuple(index[list(f)]) for f in right.facets["left"]]}
        return Mesh(points, np.vstack([left.cells, index[right.cells]]), facets), points[at_left]

    def script(self, folder):
        e, s = self.young, self.size
        mesh, hinge = self.bars()
        (folder / "arch.msh").write_text(self.place(mesh).msh())
        # A bar's weight is 1e-4 young size.
        density = 1e-4 * e / s / (self.length * self.thick) * self.along([0.0, -1.0])
        hx, hy = s * self.along(hinge)
        unit = 1e-4 * e * s
        columns = []
        for foot, side in (("left", 1), ("right", -1)):
            nx, ny = self.along([-side * math.cos(self.lean), -math.sin(self.lean)])
            fx, fy = (f"(-{foot}_across.xi*({number(n)}) - {foot}_along.xi.{c})" for n, c in ((nx, "x"), (ny, "y")))
            columns += [f"{foot}_x = integral({foot}, {fx})/{number(unit)}",
                        f"{foot}_y = integral({foot}, {fy})/{number(unit)}",
                        f"{foot}_turn = integral({foot}, (x - ({number(hx)}))*{fy} - (y - ({number(hy)}))*{fx})/{number(unit * s)}"]
        lines = ["import contact", 'mesh body = gmsh("arch.msh")', 'part left = body.group("left")',
                 'part right = body.group("right")', f"space V = vector P{self.order} on body",
                 f"tensor B = isotropic(young = {number(e)}, poisson = 0.3)"]
        for foot in ("left", "right"):
            lines += [f"superpotential {foot}_across(r) = unilateral(r)",
                      f"superpotential {foot}_along(xi) = {number(self.friction)}*abs({foot}_across.xi)*norm(xi)"]
        lines += ["find u in V", "such that for all v in V", "    integral(body, B : eps(u) : eps(v))"]
        lines += [f"  + integral({foot}, {foot}_across^0(u.nu; v.nu) + {foot}_along^0(u.tau; v.tau))"
                  for foot in ("left", "right")]
        return lines + [f" >= integral(body, dot({vector(density)}, v))", "report", "  table " + ", ".join(columns)]

    def wrong(self, final):
        """Sums of forces, and each bar's moment about the hinge with that of its weight."""
        up = self.along([0.0, 1.0])
        force = np.array([final["left_x"] + final["right_x"], final["left_y"] + final["right_y"]]) - 2 * up
        arm = (self.length * math.cos(self.lean) + self.thick * math.sin(self.lean)) / 2
        handed = np.linalg.det(self.turn)
        turns = [final["left_turn"] + handed * arm, final["right_turn"] - handed * arm]
        off = max(*np.abs(force), *(abs(t) / self.length for t in turns))
        return "" if off <= 1e-7 else f"forces are off by {force}, moments about the hinge by {turns}"

    def told(self):
        return f"lean {self.lean:.3g}, length {self.length:.3g}, thick {self.thick:.3g}, friction {self.friction:.3g}"


class Worn(Scene):
    name = "worn"

    def draw(self):
        real = self.random.uniform
        self.sizes = real(0.5, 1.5, self.dim)
        self.steps, self.wear, self.press = int(self.random.integers(2, 7)), 10.0 ** real(-1, 1), 1e-3 * real(0.5, 2.0)
        return True

    def pressures(self):
        return [self.press * math.sin(2.0 * (n + 1) / self.steps) ** 2 for n in range(self.steps)]

    def script(self, folder):
        e, s = self.young, self.size
        upper = block(self.random, self.counts(), self.sizes, 0.15)
        lower = self.floor(self.sizes, self.counts(), 0.0) if self.pair else None
        u, v = self.jump
        down = vector(self.along(-np.eye(self.dim)[1]))
        at = self.sizes * np.array([0.4, 1.0, 0.7][:self.dim])
        sink = [f"u.{c} at {vector(s * self.along(at))}" for c in "xyz"[:self.dim]]
        return ["import contact", *self.bodies(folder, upper, lower),
                f"tensor B = isotropic(young = {number(e)}, poisson = 0)",
                "superpotential across(r) = unilateral(r)", f"superpotential along(xi) = {number(1e-3 * e)}*norm(xi)",
                f"state worn on ground with rate {number(self.wear * s / e)}*abs(across.xi) from worn = 0",
                f"find u in V for t in [0, 1] by {self.steps} steps from u = 0", "such that for all v in V",
                "    integral(body, B : eps(u) : eps(v))",
                f"  + integral(ground, across^0({u}.nu - worn; {v}.nu) + along^0({u}.tau; {v}.tau))",
                f" >= integral(top, dot({number(self.press * e)}*sin(2*t)^2*{down}, v))", "report",
                "  table " + ", ".join(f"u{k} = {c}" for k, c in enumerate(sink))]

    def wrong(self, final):
        pressures = self.pressures()
        strained = self.sizes[1] * (1.5 if self.pair else 1.0) * pressures[-1]
        down = -(self.wear * sum(pressures) / self.steps + strained) * self.along(np.eye(self.dim)[1])
        off = max(abs(final[f"u{k}"] / self.size - down[k]) for k in range(self.dim))
        return "" if off <= 1e-7 * np.abs(down).max() else f"sinks by {final} instead of {down}"

    def told(self):
        return f"{self.steps} steps, wear {self.wear:.3g}"


def run(program, folder, lines, options):
    (folder / "scene.hvi").write_text("\n".join(lines) + "\n")
    out = folder / "out.json"
    out.unlink(missing_ok=True)
    done = subprocess.run([program, "run", "scene.hvi", "--no-files", "--quiet", "--json", "out.json", *options],
                          cwd=folder, capture_output=True, text=True, timeout=300)
    return done.returncode, json.loads(out.read_text())["final"] if done.returncode == 0 else None, done.stderr


def judge(scene, program, folder, options):
    """What is wrong; empty: nothing."""
    code, final, said = run(program, folder, scene.script(folder), options)
    if scene.can_hold:
        return scene.wrong(final) if code == 0 else f"not solved: {said}"
    if code == 0:
        return "solved, and nothing holds it"
    named = "moves along" in said or "turns about" in said
    return "" if named and code in (1, 3) else f"refused without the motion: {said}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--keep")
    parser.add_argument("options", nargs="*")
    args = parser.parse_args()
    failed, count = 0, {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(args.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for k in range(args.scenes) if args.only is None else [args.only]:
            random = np.random.default_rng([args.seed, k])
            scene = (Incline, Arch, Worn)[int(random.choice(3, p=[0.5, 0.25, 0.25]))](random)
            count[scene.name, bool(scene.can_hold)] = count.get((scene.name, bool(scene.can_hold)), 0) + 1
            wrong = judge(scene, args.program, folder, args.options)
            if wrong:
                failed += 1
                print(f"scene {k} ({scene.name} {scene.dim}D P{scene.order}{' pair' if scene.pair else ''}, "
                      f"young {scene.young:.3g}, size {scene.size:.3g}, {scene.told()}): {wrong}")
    told = ", ".join(f"{name} {n} {'solved' if holds else 'refused'}" for (name, holds), n in sorted(count.items()))
    print(f"{told}; {failed} wrong")
    few = args.scenes >= 40 and args.only is None and len(count) < 5
    return 1 if failed or few else 0


if __name__ == "__main__":
    sys.exit(main())
