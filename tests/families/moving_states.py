"""Mass, memory, laws on u and on u', and states on the contact at once, on random scenes: every scheme, replayed by brute force.

usage: moving_states.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

The scenes of states.py (a block in 2D or 3D, P1 or P2, with one to three laws whose forces or arguments bonds, slips, ages and wear change) with
the mass, the initial velocities and the schemes of motion.py. The states that the program tells are put into the laws: brute force must find the
same displacements at every step, with schemes and initial accelerations of its own, and the states must satisfy their own equation with
that u': by BDF2 beside every scheme but backward Euler.
"""
import math
import sys

import motion
import states
from states import WEAKENS, weakened


class Scene(states.Scene, motion.Scene):
    def choose_laws(self):
        super().choose_laws()
        motion.Scene.begin_motion(self)

    def begin_motion(self):
        """Not before states.py has chosen its rules."""

    def choose_states(self):
        super().choose_states()
        if self.scheme in ("newmark", "hht") and self.states[0].start != 0.0:
            for term in self.terms:  # an argument that begins away from 0 is not what motion.py starts from
                term.shift = 0.0

    def points_at_start(self, term):
        points = super().points_at_start(term)
        for p in points:
            p.law = weakened(p.law, WEAKENS[term.weakens][0](self.states[0].start))
        return points

    def law_points(self, n=1, known=None):
        points = super().law_points(n, known)
        return points if known is None else self.with_states(points, self.replayed[n])

    def differences(self, n):
        k = self.grid[n] - self.grid[n - 1]
        w = k / (self.grid[n - 1] - self.grid[n - 2]) if n > 1 else math.inf
        if self.scheme == "backward_euler" or w > 100:
            return 1 / k, 0.0
        return (1 + 2 * w) / ((1 + w) * k), w * w / ((1 + w) * k)

    def speed(self, n, us):
        return self.speeds[n]


if __name__ == "__main__":
    sys.exit(states.judge("moving_states", Scene))
