"""Two bodies that rub and heat each other, the displacement and the scalar in elements of two orders: the answers of brute force.

usage: warm_orders.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of warm_pairs.py with P2 beside P1, and P1 beside P2. A law on a jump acts at the points of its own unknown's order; what
it reads of the other unknown is that one's own jump, or mean, by the functions of these points, and a source has the points of the law
that it reads. The reference takes each from a mortar whose points and whose functions have orders of their own.
"""
import sys

import pairs
import rates
import warm_pairs


class Scene(warm_pairs.Scene):
    def order_of_scalar(self):
        return 3 - self.order

    def told(self):
        return super().told() + f", scalar in P{self.scalar.order}"


if __name__ == "__main__":
    sys.exit(rates.judge("warm_orders", Scene, run=pairs.run))
