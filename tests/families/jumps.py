"""Jumps and means of unknowns of different orders on a pair: what probes and integrals say is what the mortar says of the fields.

usage: jumps.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

Two blocks whose meshes do not match, in 2D or 3D, turned, scaled, one of them shifted beyond the other or not, with u in P1 or P2 and a
scalar theta in P1 or P2 beside it, which the forms couple. A spring holds the jump of the one with the higher order; the other one
jumps as it likes. From the fields of the file the rows of a mortar of the tests' own (mortar.py), for points of the higher order, give
`jump` and `mean` of both at every point of the pair, and the integrals of theirs.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import orientation
from mortar import pair_points
from orientation import number
from pairs import together
from solids import Solid, block, turning

BOUND = 1e-10


class Scene:
    def __init__(self, random):
        self.dim = 2 if random.random() < 0.6 else 3
        self.orders = [(2, 1), (1, 2), (2, 2), (1, 1)][int(random.choice(4, p=[0.4, 0.3, 0.15, 0.15]))]
        most = (4, 2) if self.dim == 2 else (2, 1, 2)
        upper, lower = (block(random, [int(random.integers(1, m + 1)) for m in most], random.uniform(0.7, 1.4, self.dim), 0.2)
                        for _ in range(2))
        shift = random.uniform(-0.3, 0.3, self.dim)
        shift[1] = lower.points[:, 1].max()
        upper.points += shift
        self.turn, self.scale = turning(random, self.dim), 10 ** random.uniform(-3, 3)
        self.upper, self.lower = (m.moved(self.turn, self.scale, 0.0) for m in (upper, lower))
        self.mesh = together(self.upper, self.lower)
        self.solid = Solid(self.mesh, max(self.orders))
        self.sides = ("u_bottom", "l_top") if random.random() < 0.6 else ("l_top", "u_bottom")
        self.points, _ = pair_points(self.solid, *(self.mesh.facets[s] for s in self.sides))
        self.second = self.solid.on(self.sides[1])
        self.slope = random.normal(size=2 * self.dim)

    def script(self):
        of_u = self.orders[0] >= self.orders[1]
        linear = lambda k: " + ".join(f"({number(v / self.scale)})*{x}" for v, x in zip(self.slope[k:], "xyz"[:self.dim]))
        given = "[" + ", ".join(f"{number(0.1 * (i + 1))}*({linear(i)})" for i in range(self.dim)) + "]"
        names = {"u": "upper", "l": "lower"}
        side = lambda s: f"{names[s[0]]}.{s[2:]}"
        columns = []
        for k, p in enumerate(self.points):
            at = "[" + ", ".join(number(v) for v in self.solid.points[p.node]) + "]"
            for i, what in enumerate(("jump(theta)", "mean(theta)", *(f"jump(u).{x}" for x in "xyz"[:self.dim]))):
                columns.append(f"c{k}_{i} = {what} at {at}")
        columns += ["total = integral(seam, jump(theta))", "square = integral(seam, mean(theta)^2)",
                    "mixed = integral(seam, jump(theta)*jump(u).x)", "most = largest(seam, jump(theta))"]
        law = "spring^0(jump(u); jump(v))" if of_u else "film^0(jump(theta); jump(eta))"
        return f"""mesh upper = gmsh("upper.msh")
mesh lower = gmsh("lower.msh")
mesh both = upper + lower
part seam = pair({side(self.sides[0])}, {side(self.sides[1])})
part top = upper.top
part base = lower.bottom
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential {"spring(xi) = 0.5*norm(xi)^2" if of_u else "film(s) = 0.5*s^2"}
space V = vector P{self.orders[0]} on both, zero on top, zero on base
space W = scalar P{self.orders[1]} on both, zero on top, zero on base
find u in V, theta in W with u = {given} on top, theta = 3 + {linear(self.dim)} on top such that for all v in V, eta in W
    integral(both, B : eps(u) : eps(v) - theta*div(v)) + integral(both, dot(grad(theta), grad(eta)))
  + integral(seam, {law}) >= integral(lower, {number(self.scale ** -2)}*eta)
report
  table {", ".join(columns)}
  fields u, theta
"""

    def fields(self, folder):
        """u and theta at the nodes of the higher order, from the file: corners, and middles where it has them or else their means."""
        import meshio

        grid = meshio.read(sorted((folder / "out").glob("*.vtu"))[-1])
        split, dim = len(self.upper.cells), self.dim
        cells = np.vstack([c.data for c in grid.cells])
        theirs = np.zeros(len(grid.points), bool)
        theirs[cells[:split].ravel()] = True
        ours = np.zeros(len(self.solid.points), bool)
        for cell in self.mesh.cells[:split]:
            ours[self.solid.nodes(cell)] = True
        values = np.column_stack([grid.point_data["u"][:, :dim], grid.point_data["theta"]])
        out = np.full((len(ours), dim + 1), np.nan)
        for k, x in enumerate(self.solid.points):
            far = np.linalg.norm(grid.points[:, :dim] - x, axis=1) + 1e9 * self.scale * (theirs != ours[k])
            if far.min() < 1e-9 * self.scale:
                out[k] = values[int(np.argmin(far))]
        for order, columns in zip(self.orders, (slice(0, dim), slice(dim, dim + 1))):
            for (a, b), middle in self.solid.edges.items():
                if order == 1:
                    straight = (out[a, columns] + out[b, columns]) / 2
                    written = out[middle, columns]
                    assert np.isnan(written).any() or np.allclose(written, straight, rtol=1e-6), "a function of order 1 is straight"
                    out[middle, columns] = straight
        return out[:, :dim], out[:, dim]

    def expected(self, u, theta):
        rows = np.array([p.jump[0, ::self.dim] for p in self.points])
        ours = np.where(np.isin(np.arange(rows.shape[1]), self.second), -0.5, 0.5)
        weights = np.array([p.weight for p in self.points])
        jump, mean, slip = rows @ theta, (rows * ours) @ theta, rows @ u
        out = {f"c{k}_{i}": v for k in range(len(rows)) for i, v in enumerate((jump[k], mean[k], *slip[k]))}
        sizes = [np.abs(theta).max(), np.abs(theta).max(), *[np.abs(u).max()] * self.dim]
        size = {f"c{k}_{i}": s for k in range(len(rows)) for i, s in enumerate(sizes)}
        area, t, w = weights.sum(), np.abs(theta).max(), np.abs(u).max()
        out |= {"total": weights @ jump, "square": weights @ mean ** 2, "mixed": weights @ (jump * slip[:, 0]), "most": jump.max()}
        size |= {"total": area * t, "square": area * t ** 2, "mixed": area * t * w, "most": t}
        return out, size


def judge(program, scene, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "upper.msh").write_text(scene.upper.msh())
    (folder / "lower.msh").write_text(scene.lower.msh())
    (folder / "scene.hvi").write_text(scene.script())
    done = subprocess.run([program, "run", "scene.hvi", "--quiet", "-o", "out", "--json", "a.json"], cwd=folder,
                          capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        return np.inf, " ".join(done.stderr.split())[:600]
    final = json.loads((folder / "a.json").read_text())["final"]
    expected, size = scene.expected(*scene.fields(folder))
    off = {name: abs(final[name] - value) / size[name] for name, value in expected.items()}
    worst = max(off, key=off.get)
    return off[worst], f"{worst}: {final[worst]!r}, expected {expected[worst]!r}"


STATES = """mesh upper = rectangle(1, 1, cells = [3, 3], at = [0.2, 1])
mesh lower = rectangle(2, 1, cells = [7, 3])
mesh both = upper + lower
part base = lower.bottom
part top = upper.top
part seam = pair(upper.bottom, lower.top)
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential spring(r) = 0.5*r^2
state s on seam with rate jump(theta)^2 from s = 0
space V = vector P2 on both, zero on base, zero on top
space W = scalar P1 on both, zero on base, zero on top
find u in V, theta in W with theta = t*(3 + x^2) on top for t in [0, 1] by 1 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(both, B : eps(u) : eps(v) - 0.1*theta*div(v)) + integral(both, dot(grad(theta), grad(eta)))
  + integral(seam, spring^0(jump(u).nu; jump(v).nu)) >= 0
report
  table grown = integral(seam, s), read = integral(seam, jump(theta)^2)
"""


def off_in_states(program):
    """In one step of length 1 a state is its rate, which reads the jump."""
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "a.hvi").write_text(STATES)
        subprocess.run([program, "run", "a.hvi", "--quiet", "--no-files", "--json", "a.json"], cwd=folder, check=True, timeout=120)
        final = json.loads((pathlib.Path(folder) / "a.json").read_text())["final"]
    return abs(final["grown"] / final["read"] - 1)


def main():
    options = orientation.asked_for()
    worst = off_in_states(options.program)
    wrong = 0 if worst <= BOUND else 1
    if wrong:
        print(f"a state that reads a jump is off by {worst:.1e}", file=sys.stderr)
    scenes = range(options.scenes) if options.only is None else options.only
    for k in scenes:
        scene = Scene(np.random.default_rng([options.seed, k]))
        if not scene.points:
            continue
        with tempfile.TemporaryDirectory() as temporary:
            off, said = judge(options.program, scene, (options.keep or pathlib.Path(temporary)) / str(k))
        worst = max(worst, off)
        if not off <= BOUND:
            wrong += 1
            print(f"scene {k}: {scene.dim}D P{scene.orders[0]} beside P{scene.orders[1]}, off by {off:.1e}: {said}", file=sys.stderr)
    print(f"family jumps: scenes {len(scenes)}, wrong {wrong}, worst {worst:.1e}")
    return 0 if wrong == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
