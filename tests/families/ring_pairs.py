"""Two bodies of revolution on each other, on random scenes: the answers of brute force at every step.

usage: ring_pairs.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of pairs.py in 2D, each body the section of one of revolution that reaches the axis or does not, with the tensors, the dense
assembly and the quadrature of axisymmetry.py; the mortar of the reference carries 2 pi x as well. One body may be wider than the other,
so that facets have partners on a part of them.
"""
import sys

import numpy as np

import axisymmetry
import pairs
import rates
from mortar import pair_points


class Scene(pairs.Scene, axisymmetry.Scene):
    make_solid = rates.Scene.make_solid  # of the one block that the two replace

    def place(self, upper, lower):
        """Both begin on the axis, or neither does."""
        on_axis = self.random.random() < 0.5
        for mesh in (upper, lower):
            mesh.points[:, 0] -= mesh.points[:, 0].min()
            if not on_axis:
                mesh.points[:, 0] += self.random.uniform(0.1, 0.5)
        self.reaches_axis, self.on_axis = on_axis, False  # what is held is chosen by pairs.py
        if self.moves is not None:
            self.moves[0] = 0.0

    def solid_of_bodies(self):
        return axisymmetry.Ring(self.mesh, self.order)

    def pair_points(self, first, second):
        return pair_points(self.solid, first, second, rings=True)

    def script(self, turn, scale):
        return super().script(turn, scale).replace('.msh")', '.msh", axisymmetric = true)')

    def told(self):
        return super().told() + (", reaching the axis" if self.reaches_axis else "")


if __name__ == "__main__":
    sys.exit(rates.judge("ring_pairs", Scene, without_reference=0.2, turning=lambda random, dim: np.eye(dim), run=pairs.run))
