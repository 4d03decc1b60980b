"""An incompressible fluid or solid in two bodies, with slip and a leak between them, on random scenes: the answers of brute force.

usage: flow_pairs.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The bodies of pairs.py with a velocity in P2 and a pressure in P1, Taylor and Hood's elements, in the equations of fields.py: no volume
changes, or as much as a storage takes up. Laws act across the pair on jump(u) or jump(u'), slip that weakens among them, and in most
scenes on jump(p): what leaks through at the difference of pressure, with kinks and jumps, falling only where there is storage. Laws
read each other's unknowns as in warm_pairs.py: slip the mean of the pressure or its jump, a leak the opening. The reference is that
of warm_pairs.py: a dense brute force with a mortar of its own.
"""
import sys

import pairs
import rates
import warm_pairs
from brute import Unilateral


class Scene(warm_pairs.Scene):
    def choose_kind(self):
        self.kind, self.order = "incompressible", 2
        self.leaks, self.stores = self.random.random() < 0.75, self.random.random() < 0.4

    def order_of_scalar(self):
        return 1

    def choose_forms(self):
        super().choose_forms()
        if self.leaks or self.stores:  # their signs are those of div u
            self.to_p = 1.0
        if self.stores:
            size = 10 ** self.random.uniform(-3, 1) / self.elastic[1]
            self.capacity, self.diffusion = size, size * float(self.random.choice([0.0, 1.0]))

    def seen_by_a_law(self):
        if self.leaks and not self.terms:
            return "p"
        return str(self.random.choice(["u", "rate"]))

    def may_act_on_p(self, law):
        return not isinstance(law, Unilateral) and (self.stores or law.descent() == 0)

    def told(self):
        return super().told() + (", leaking" if self.leaks else "") + (", storing" if self.stores else "")


if __name__ == "__main__":
    sys.exit(rates.judge("flow_pairs", Scene, run=pairs.run))
