"""Two bodies of revolution that rub and heat each other, in elements of two orders, on random scenes: the answers of brute force.

usage: warm_rings.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of warm_orders.py in 2D, and some with one order, each body the section of one of revolution that reaches the axis or does not,
as in ring_pairs.py. Forms, couplings, loads and the mortar of the reference carry 2 pi x, the divergence u.x/x; the strain u.x/x is
integrated with the points that the higher of the two orders asks for.
"""
import math
import sys

import numpy as np

import axisymmetry
import fields
import pairs
import rates
import ring_pairs
import warm_orders
from solids import shapes


class Ring(axisymmetry.Ring):
    """Beside an unknown in P2, or in it."""

    def rule(self):
        return axisymmetry.radon()


class RingScalar(fields.Scalar):
    """A scalar on a body of revolution."""

    def points_in(self, cell):
        radii = self.mesh.points[cell][:, 0]
        return [(b, w * 2 * math.pi * float(np.dot(b, radii))) for b, w in axisymmetry.radon()]

    def divergences(self, body, cell, barycentric, b):
        out = super().divergences(body, cell, barycentric, b)
        out[::2] += shapes(body.order, b) / np.dot(b, self.mesh.points[cell][:, 0])
        return out


class OfRings:
    """A scene of warm_pairs.py whose bodies are bodies of revolution."""

    rings, moves = True, None
    place = ring_pairs.Scene.place
    pair_points = ring_pairs.Scene.pair_points

    def choose_kind(self):
        self.dim = 2
        super().choose_kind()

    def solid_of_bodies(self):
        highest = max(self.order, self.order_of_scalar())
        return Ring(self.mesh, self.order) if highest == 2 else axisymmetry.Ring(self.mesh, self.order)

    def make_scalar(self, order):
        return RingScalar(self.mesh, order)

    def mass(self):
        return np.kron(RingScalar(self.mesh, self.order).mass_and_stiffness()[0], np.eye(2))

    def leave_free(self, free):
        """u.x is zero on the axis."""
        super().leave_free(np.setdiff1d(free, [2 * v for v, x in enumerate(self.solid.points) if x[0] == 0.0]))

    def script(self, turn, scale):
        return super().script(turn, scale).replace('.msh")', '.msh", axisymmetric = true)')

    def told(self):
        return super().told() + (", reaching the axis" if self.reaches_axis else "")


class Scene(OfRings, warm_orders.Scene):
    def choose_kind(self):
        super().choose_kind()
        self.one_order = self.random.random() < 0.2

    def order_of_scalar(self):
        return self.order if self.one_order else super().order_of_scalar()


if __name__ == "__main__":
    sys.exit(rates.judge("warm_rings", Scene, without_reference=0.2, turning=lambda random, dim: np.eye(dim), run=pairs.run))
