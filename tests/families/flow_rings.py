"""The scenes of flow_pairs.py in bodies of revolution.

usage: flow_rings.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

Taylor and Hood's elements on two sections, with slip and a leak between the bodies; the reference is that of warm_rings.py.
"""
import sys

import numpy as np

import flow_pairs
import pairs
import rates
import warm_rings


class Scene(warm_rings.OfRings, flow_pairs.Scene):
    pass


if __name__ == "__main__":
    sys.exit(rates.judge("flow_rings", Scene, without_reference=0.2, turning=lambda random, dim: np.eye(dim), run=pairs.run))
