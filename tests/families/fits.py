"""A family of fits: a law's and a kernel's parameters from noisy curves of scripts drawn at random (1D and 2D, normal laws and friction, kernels of
stdlib/kernels.hvi), each with a first guess that is off by up to a factor of two. Counted is how often the intervals of 95 % hold what the
curves were made with: were the intervals right, 95 % of them would, so fewer than their binomial share with one chance in 10,000 is a failure.

usage: fits.py [--scenes N] [--seed S] [--only I], with the package hvi on PYTHONPATH"""
import argparse
import random

import numpy as np
from scipy.stats import binom

import hvi

# name: (law's declaration, its parameters with the ends they are drawn between, where it acts in 2D)
LAWS = {
    "winkler": ("winkler(r, stiffness = p1)", {"p1": (0.5, 5)}, "u.nu", "v.nu"),
    "power": ("normal_compliance(r, stiffness = p1, power = p2)", {"p1": (1, 5), "p2": (1, 2)}, "u.nu", "v.nu"),
    "bound": ("bounded_compliance(r, stiffness = p1, bound = p2)", {"p1": (2, 8), "p2": (0.15, 0.3)}, "u.nu", "v.nu"),
    "softening": ("softening(r, stiffness = p1, peak_at = 0.1, softening = p2, end_at = 0.5)", {"p1": (1, 4), "p2": (0.05, 0.3)}, "u.nu", "v.nu"),
    "tresca": ("tresca(r, bound = p1)", {"p1": (0.05, 0.3)}, "u'.tau", "v.tau"),
    "weakening": ("slip_weakening(r, static = p1, sliding = 0.05, decay = p2)", {"p1": (0.1, 0.3), "p2": (0.5, 2)}, "u'.tau", "v.tau"),
}
KERNELS = {
    "fading": ("weight*fading(lag, time)", {"weight": (0.2, 0.6), "time": (0.3, 1.5)}),
    "stretched": ("0.5*stretched(lag, time, 0.7)", {"time": (0.3, 1.5)}),
    "fractional": ("0.5*fractional_relaxation(lag, time, 0.6)", {"time": (0.3, 1.5)}),
    "abel": ("0.3*abel(lag, order)", {"order": (0.4, 0.9)}),
    "logarithmic": ("0.4*logarithmic(lag, time)", {"time": (0.5, 2)}),
}
BAR = """
kernel C(lag) = -{kernel}
mesh bar  = interval(1, cells = 1)
part tip  = bar.right
part root = bar.left
space V = scalar P1 on bar, zero on root
find p in V for t in [0, 2] by N steps from p = 0
such that for all q in V
    integral(bar, 0.3*dot(grad(p'), grad(q))) + integral(bar, dot(grad(p), grad(q)))
  + integral(bar, dot(history(C, grad(p)), grad(q)))
  + integral(tip, law^0({u}; {v}))
 >= integral(tip, {load}*q)
report
  table  moved = p at [1], force = law.xi at [1]
"""
SLAB = """
kernel C(lag) = -({kernel})*B
tensor A = isotropic(lambda = 0.1, mu = 0.2)
tensor B = isotropic(young = 2, poisson = 0.3)
mesh slab = rectangle(1, 1, cells = [2, 2])
part ground = slab.bottom
part roof = slab.top
part flank = slab.right
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 2] by N steps from u = 0
such that for all v in V
    integral(slab, A : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v))
  + integral(slab, history(C, eps(u)) : eps(v))
  + integral(ground, law^0({u}; {v}))
 >= integral(ground, dot([{load}, -{load}], v))
report
  table  moved = {column} at [1, 0], force = integral(ground, law.xi{part})
"""


def scene(seed):
    """A script, the values it was drawn with and first guesses."""
    draw = random.Random(seed)
    law, kernel = draw.choice(list(LAWS)), draw.choice(list(KERNELS))
    declaration, of_law, u, v = LAWS[law]
    formula, of_kernel = KERNELS[kernel]
    true = {name: low * (high / low) ** draw.random() for name, (low, high) in {**of_law, **of_kernel}.items()}
    bar = draw.random() < 0.6
    load = draw.choice(["sin(3*t)", "(1.5*t*exp(-0.3*t))", "min(2*t, 1.2)"])
    normal = u == "u.nu"
    if bar:
        u, v = ("p" if normal else "p'"), "q"
    text = (BAR if bar else SLAB).format(kernel=formula, u=u, v=v, load=load, column="u.y" if normal else "u.x", part="" if normal else ".x")
    header = "import contact\nimport friction\nimport kernels\nparam N = 30\n" + "".join(f"param {n} = {v!r}\n" for n, v in true.items())
    argument = "r" if normal else "xi"
    header += f"superpotential law({argument}) = {declaration.replace('(r', '(' + argument)}\n"
    guess = {name: value * 2 ** draw.uniform(-1, 1) for name, value in true.items()}
    return f"{law}, {kernel}, {'1D' if bar else '2D'}, {load}", header + text, true, guess, draw.uniform(0.002, 0.02)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=24)
    parser.add_argument("--only", type=int)
    given = parser.parse_args()
    inside = asked = refused = runs = 0
    errors = []
    for i in range(given.scenes) if given.only is None else [given.only]:
        seed = 1000 * given.seed + i
        name, text, true, guess, noise = scene(seed)
        model, draw = hvi.loads(text), np.random.default_rng(seed)
        made = model.run()
        data = {}
        for column in ("moved", "force"):
            y = made[column]
            data[column] = (made["t"], y + noise * np.abs(y).max() * draw.standard_normal(len(y)))
        try:
            found = model.fit(guess, data)
        except ValueError as error:
            refused += 1
            print(f"{i}: {name}: {error}")
            continue
        runs += found.runs
        for one, value in true.items():
            asked += 1
            low, high = found.intervals[one]
            inside += low <= value <= high
            errors.append((found.values[one] - value) / found.stderr[one])
            if not low <= value <= high or given.only is not None:
                print(f"{i}: {name}: {one} = {value:.4g}, found {found.values[one]:.4g}, [{low:.4g}, {high:.4g}]; {found.runs} runs, {found.message}")
    least = int(binom.ppf(1e-4, asked, 0.95))
    size = float(np.nanmedian(np.abs(errors)) / 0.6745) if errors else np.nan
    print(f"{given.scenes} scenes, {runs} runs: {inside} of {asked} intervals of 95 % hold ({100 * inside / max(asked, 1):.1f} %, at least {least} wanted), "
          f"{refused} refused; errors are {size:.2f} of what they are said to be")
    return 0 if inside >= least and refused <= 0.1 * given.scenes and 0.6 < size < 1.5 else 1


if __name__ == "__main__":
    raise SystemExit(main())
