"""Bodies of revolution with random tensors, loads and laws: the answers of brute force at every step.

usage: axisymmetry.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of rates.py (laws on u, u' and memories, viscosity, memory, moving supports, each rule, P1 and P2) in 2D, each
the section of a body that reaches the axis or does not, with random positive tensors on (rr, zz, hoop, rz). The dense
reference integrates with 2 pi r by quadrature of its own, of the degrees that docs/language.md names.
"""
import itertools
import math
import sys

import numpy as np

import rates
from orientation import number
from solids import Mesh, Solid, line_rule, permuted, shapes, slopes, triangle_rule


def radon():
    """Degree 5 on triangles."""
    s = math.sqrt(15)
    out = [((1 / 3,) * 3, 9 / 40)]
    for weight, a in (((155 - s) / 1200, (6 - s) / 21), ((155 + s) / 1200, (6 + s) / 21)):
        out += [(p, weight) for p in permuted(a, a, 1 - 2 * a)]
    return out


def voigt(elastic):
    """A tensor as a matrix on (rr, zz, hoop, 2 rz): isotropic numbers or the matrix itself."""
    if isinstance(elastic, np.ndarray):
        return elastic
    lam, mu = elastic
    out = np.full((4, 4), lam) + 2 * mu * np.eye(4)
    out[3] = out[:, 3] = 0
    out[3, 3] = mu
    return out


def nodal(order, a, b):
    """Nodes of an edge with the means of f r for affine r: a and b at its ends."""
    ends, middle = [(1.0, 0.0), (0.0, 1.0)], (0.5, 0.5)
    if order == 1:
        return list(zip(ends, [a / 3 + b / 6, a / 6 + b / 3]))
    return [p for p in zip([*ends, middle], [a / 6, b / 6, (a + b) / 3]) if p[1] > 0]  # Simpson; none on the axis


class Ring(Solid):
    """A solid whose first coordinate is the distance from the axis."""

    def rule(self):
        return triangle_rule(4) if self.order == 1 else radon()

    def stiffness(self, *elastic):
        matrix = voigt(elastic[0] if len(elastic) == 1 else elastic)
        k = np.zeros((self.n, self.n))
        for cell in self.mesh.cells:
            x = self.mesh.points[cell]
            edges = (x[1:] - x[0]).T
            inner = np.linalg.inv(edges)
            barycentric = np.vstack([-inner.sum(0), inner])
            dofs = self.dofs(self.nodes(cell))
            for b, weight in self.rule():
                g, v, r = slopes(self.order, b) @ barycentric, shapes(self.order, b), np.dot(b, x[:, 0])
                strain = np.zeros((4, len(dofs)))
                strain[0, 0::2], strain[1, 1::2], strain[2, 0::2] = g[:, 0], g[:, 1], v / r
                strain[3, 0::2], strain[3, 1::2] = g[:, 1], g[:, 0]
                volume = 2 * math.pi * r * weight * abs(np.linalg.det(edges)) / 2
                k[np.ix_(dofs, dofs)] += volume * strain.T @ matrix @ strain
        return k

    def body_load(self, force):
        out = np.zeros(self.n)
        for cell in self.mesh.cells:
            x = self.mesh.points[cell]
            area = abs(np.linalg.det((x[1:] - x[0]).T)) / 2
            values = sum(2 * math.pi * np.dot(b, x[:, 0]) * w * shapes(self.order, b) for b, w in radon())
            out[self.dofs(self.nodes(cell))] += np.kron(area * values, force)
        return out

    def facet_load(self, name, force):
        out = np.zeros(self.n)
        for f in self.mesh.facets[name]:
            size, _ = self.facet(f)
            r = self.mesh.points[list(f)][:, 0]
            values = sum(2 * math.pi * np.dot(b, r) * w * shapes(self.order, b) for b, w in line_rule(3))
            out[self.dofs(self.nodes(f))] += np.kron(size * values, force)
        return out

    def law_points(self, name, rule):
        out = []
        for f in self.mesh.facets[name]:
            size, normal = self.facet(f)
            r = self.mesh.points[list(f)][:, 0]
            if rule == "nodal":
                points = nodal(self.order, *r)
            else:
                plain = [((0.5, 0.5), 1.0)] if rule == "midpoint" else line_rule(self.order + 1)
                points = [(b, w * np.dot(b, r)) for b, w in plain]
            for b, weight in points:
                values = np.zeros((2, self.n))
                for node, v in zip(self.nodes(f), shapes(self.order, b)):
                    values[0, 2 * node] = values[1, 2 * node + 1] = v
                out.append((2 * math.pi * weight * size, values, normal))
        return out


class Scene(rates.Scene):
    def choose_dim(self):
        return 2

    def make_solid(self):
        random = self.random
        self.on_axis = random.random() < 0.6
        away = 0.0 if self.on_axis else 10 ** random.uniform(-2, 1)
        self.mesh = Mesh(self.mesh.points + [away, 0.0], self.mesh.cells, self.mesh.facets)
        return Ring(self.mesh, self.order)

    def random_tensor(self, lam, mu):
        """Isotropic, or any positive one on (rr, zz, hoop, rz) of that size."""
        if self.random.random() < 0.3:
            return lam, mu
        q = np.linalg.qr(self.random.normal(size=(4, 4)))[0]
        mandel = q @ np.diag(2 * mu * 10 ** self.random.uniform(-0.5, 0.7, 4)) @ q.T
        scale = np.array([1, 1, 1, math.sqrt(0.5)])  # 2 rz instead of sqrt(2) rz
        return (mandel + mandel.T) / 2 * np.outer(scale, scale)

    def assemble(self):
        random, solid = self.random, self.solid
        part = 10 ** random.uniform(-2, 0)
        self.viscous = self.random_tensor(*(v * part for v in self.elastic))
        self.elastic = self.random_tensor(*self.elastic)
        if self.on_axis:
            self.clamped = "top"  # the axis is inside the body
            if self.moves is not None:
                self.moves[0] = 0.0
        axis = [2 * v for v in range(len(solid.points)) if solid.points[v, 0] == 0.0]
        self.clamped_dofs = solid.dofs(solid.on(self.clamped))
        self.free = np.setdiff1d(np.arange(solid.n), [*self.clamped_dofs, *axis])
        self.all_a, self.all_b = solid.stiffness(*self.tensor(self.viscous)), solid.stiffness(*self.tensor(self.elastic))
        self.all_q = self.all_b  # of the memory
        self.k = self.matrix(1)
        self.inverse = np.linalg.inv(self.k)

    @staticmethod
    def tensor(elastic):
        return (elastic,) if isinstance(elastic, np.ndarray) else elastic

    def script(self, turn, scale):
        known = self.elastic, self.viscous
        self.elastic = self.viscous = 1.0, 1.0
        text = super().script(turn, scale)
        self.elastic, self.viscous = known
        text = text.replace('gmsh("body.msh")', 'gmsh("body.msh", axisymmetric = true)')
        for name, elastic in (("A", self.viscous), ("B", self.elastic)):
            rows = ", ".join("[" + ", ".join(map(number, row)) + "]" for row in voigt(elastic))
            written = f"voigt([{rows}])"
            if not isinstance(elastic, np.ndarray) and self.order == 1:
                written = "isotropic(lambda = {}, mu = {})".format(*map(number, elastic))
            text = text.replace(f"tensor {name} = isotropic(lambda = 1.0, mu = 1.0)", f"tensor {name} = {written}")
        return text

    def told(self):
        return super().told() + (", on the axis" if self.on_axis else "")


if __name__ == "__main__":
    sys.exit(rates.judge("axisymmetry", Scene, turning=lambda random, dim: np.eye(dim)))
