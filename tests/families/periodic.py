"""Periodic parts with laws, rates and memories, on random scenes: the answers of brute force at every step.

usage: periodic.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of rates.py, held at the top, whose right side repeats the left one (in 3D often the front repeats the back, too). The reference has
no conditions: the nodes of both sides are one node, a torus in dense algebra. Scenes are turned and
scaled, so that the translation has any direction.
"""
import sys

import numpy as np

import rates
from solids import Solid


class Torus(Solid):
    """Nodes that repeat others have their numbers: everything is that of the whole solid with columns and rows added up."""

    def __init__(self, mesh, order, sides):
        super().__init__(mesh, order)
        self.whole, every, size = Solid(mesh, order), self.points, np.ptp(self.points, axis=0)
        first = np.arange(len(every))
        for name, axis in sides:
            low, high = self.whole.on(name[0]), self.whole.on(name[1])
            for v in high:
                place = every[v].copy()
                place[axis] -= size[axis]
                nearest = min(low, key=lambda w: float(np.abs(every[w] - place).max()))
                assert np.abs(every[nearest] - place).max() < 1e-12
                first[v] = nearest
        for _ in sides:
            first = first[first]
        kept, self.number = np.unique(first, return_inverse=True)
        self.pairs = [(v, int(w)) for v, w in enumerate(first) if v != w]
        self.points, self.n = every[kept], len(kept) * self.dim
        self.z = np.kron(np.eye(len(kept))[self.number], np.eye(self.dim))  # from values of the torus to those of the solid

    def on(self, name):
        return sorted({int(self.number[v]) for v in self.whole.on(name)})

    def stiffness(self, lam, mu):
        return self.z.T @ self.whole.stiffness(lam, mu) @ self.z

    def body_load(self, force):
        return self.z.T @ self.whole.body_load(force)

    def facet_load(self, name, force):
        return self.z.T @ self.whole.facet_load(name, force)

    def law_points(self, name, rule):
        return [(weight, values @ self.z, normal) for weight, values, normal in self.whole.law_points(name, rule)]


class Scene(rates.Scene):
    def make_solid(self):
        mesh = self.mesh
        self.sides = [(("left", "right"), 0)]
        if self.dim == 3 and self.random.random() < 0.6:
            self.sides.append((("back", "front"), 2))
        for (low, high), axis in self.sides:  # what was moved at random is the same on both
            size = np.ptp(mesh.points[:, axis])
            of = {tuple(np.round(np.delete(mesh.points[v], [axis, 1]), 12)): [] for f in mesh.facets[low] for v in f}
            for f in mesh.facets[low]:
                for v in f:
                    of[tuple(np.round(np.delete(mesh.points[v], [axis, 1]), 12))].append(v)
            for v in {v for f in mesh.facets[high] for v in f}:
                near = of[tuple(np.round(np.delete(mesh.points[v], [axis, 1]), 12))]
                partner = min(near, key=lambda w: abs(mesh.points[w, 1] - mesh.points[v, 1]))
                mesh.points[v] = mesh.points[partner]
                mesh.points[v, axis] += size
        return Torus(mesh, self.order, self.sides)

    def assemble(self):
        self.clamped = "top"
        super().assemble()

    def script(self, turn, scale):
        text = super().script(turn, scale)
        names = {name for pair, _ in self.sides for name in pair} - {"right"}
        text = text.replace("part bottom", "".join(f'part {n} = body.group("{n}")\n' for n in sorted(names)) + "part bottom")
        first = ", ".join(f"periodic {a} = {b}" if self.random.random() < 0.5 else f"periodic {b} = {a}" for (a, b), _ in self.sides)
        text = text.replace(", zero on top", f", {first}, zero on top" if self.random.random() < 0.5 else f", zero on top, {first}")
        return text.replace("report\n", "report\n  table force = reaction(top)\n")

    def error_besides(self, folder, scale):
        """Values that repeat are the same bits."""
        import meshio

        grid = meshio.read(sorted((folder / "out").glob("scene_[0-9]*.vtu"))[-1])
        u = grid.point_data["u"]
        mesh = meshio.read(folder / "body.msh")
        at = {tuple(np.round(x / np.abs(mesh.points).max(), 9)): k for k, x in enumerate(grid.points)}
        apart = 0.0
        for v, w in self.solid.pairs:
            if max(v, w) >= len(mesh.points):
                continue  # middles of edges are compared with the torus
            a, b = (at[tuple(np.round(mesh.points[k] / np.abs(mesh.points).max(), 9))] for k in (v, w))
            apart = max(apart, float(np.abs(u[a] - u[b]).max()))
        return apart / (float(np.abs(u).max()) or 1.0)


if __name__ == "__main__":
    sys.exit(rates.judge("periodic", Scene))
