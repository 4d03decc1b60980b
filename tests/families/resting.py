"""Two unknowns of which one comes to rest, or both: nothing but rounding is left of their increments.

usage: resting.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

The scenes of fields.py in three to six steps. An unknown that comes to rest has no viscosity (or capacity) and nothing of the other one
in its equation; its loads grow, then stay or go back to zero. The answers are those of brute force at every step.
"""
import sys

import numpy as np

import fields
import rates
from orientation import number


class Scene(fields.Scene):
    def choose_forms(self):
        random = self.random
        super().choose_forms()
        self.steps, self.density = int(random.integers(3, 7)), 0.0
        self.rests = str(random.choice(["u", "p", "both"]))
        if self.kind == "incompressible":  # p is the pressure of u
            self.rests = "both"
        elif self.mesh.patch:  # the capacity alone holds p there
            self.rests = "u"
        if self.rests != "p":
            self.viscous = 0.0, 0.0
        if self.rests != "u":
            self.capacity, self.to_p_rate = 0.0, 0.0
        if self.rests == "u":
            self.to_u = 0.0
        elif self.rests == "p":
            self.to_p = 0.0
        self.stop, self.goes_back = int(random.integers(1, self.steps - 1)), bool(random.random() < 0.4)
        if self.rests != "p":
            self.load_of_u = self.factor_of_time()
        if self.rests != "u":
            self.load_of_p = self.factor_of_time()

    def factor_of_time(self):
        stop = self.stop / self.steps
        return f"max(0, min(t, {number(2 * stop)} - t))" if self.goes_back else f"min(t, {number(stop)})"

    def weight(self):
        """Unknowns that are not coupled both ways need none."""
        return super().weight() or 1.0

    def load_at(self, n):
        until = max(0, min(n, 2 * self.stop - n)) if self.goes_back else min(n, self.stop)
        at_rest = {"u": ~self.of_p, "p": self.of_p, "both": np.ones(len(self.free), bool)}[self.rests]
        return self.load * np.where(at_rest, until, n) / self.steps

    def told(self):
        return f"{self.rests} at rest from step {self.stop}, {'0' if self.goes_back else 'held'}: {super().told()}"


if __name__ == "__main__":
    sys.exit(rates.judge("resting", Scene))
