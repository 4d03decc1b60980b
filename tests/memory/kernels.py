"""Every kind of memory kernel, as a script writes it, and the problem they are tested in.

A kernel is (declaration, routes that must serve it). `tree` and `direct` serve all of them.
"""
import math
import pathlib

RECURSION = ["recursion", "fit", "tree"]
FIT = ["fit", "tree"]
TREE = ["tree"]

KERNELS = {
    # one exponential, in several spellings
    "exponential": ("kernel C(lag) = -exp(-lag/0.5) * B", RECURSION),
    "exponential_of_t_and_s": ("kernel C(t, s) = -exp(-(t - s)*2) * B", RECURSION),
    "exponentials_of_t_and_of_s": ("kernel C(t, s) = -exp(-2*t) * exp(2*s) * B", RECURSION),
    "exponential_by_power": ("kernel C(lag) = -2^(-3*lag) / exp(lag) * B", RECURSION),
    "exponential_by_root": ("kernel C(lag) = -sqrt(exp(-4*lag)) * B", RECURSION),
    "prony": ("kernel C(lag) = -prony(weights = [0.2, 0.3], times = [0.1, 1]) * B", RECURSION),
    "prony_fitted_to_data": ("kernel C(lag) = -table(\"relaxation.csv\", interpolation = prony) * B", RECURSION),
    "oscillating": ("kernel C(lag) = -exp(-lag) * cos(20*lag) * B", RECURSION),
    "power_times_exponential": ("kernel C(lag) = -lag^2 * exp(-3*lag) * B", RECURSION),
    "stretched_exponential": ("kernel C(lag) = -exp(-(lag/0.5)^0.4) * B", FIT),
    "power_01": ("kernel C(lag) = -0.3 * lag^(-0.1) * B", FIT),
    "power_05": ("kernel C(lag) = -0.3 * lag^(-0.5) * B", FIT),
    "power_09": ("kernel C(lag) = -0.03 * lag^(-0.9) * B", FIT),
    "mittag_leffler": ("kernel C(lag) = -mittag_leffler(0.5, -sqrt(lag)) * B", FIT),
    "erfcx": ("kernel C(lag) = -erfcx(sqrt(lag)) * B", FIT),
    "erfc": ("kernel C(lag) = -erfc(3*lag - 1) * B", FIT),
    "logarithm": ("kernel C(lag) = 0.2 * log(lag) * B", FIT),
    "bessel": ("kernel C(lag) = -bessel_j(0, 10*lag) * B", FIT),
    "table_linear": ("kernel C(lag) = -table(\"relaxation.csv\") * B", TREE),
    "table_cubic": ("kernel C(lag) = -table(\"relaxation.csv\", interpolation = cubic) * B", TREE),
    "piecewise": ("kernel C(lag) = (| lag < 0.2 -> -exp(-lag) | lag < 0.5 -> -0.5 | otherwise -> 0) * B", TREE),
    "kink": ("kernel C(lag) = -exp(-abs(lag - 0.3)) * B", FIT),
    "delay": ("kernel C(lag) = (| lag < 0.25 -> 0 | lag < 0.35 -> -5 | otherwise -> 0) * B", TREE),
    "hat": ("kernel C(lag) = -max(0, 1 - lag/0.3) * B", TREE),
    "aging": ("kernel C(t, s) = -B / (1 + 2*t - s)", TREE),
    "aging_singular": ("kernel C(t, s) = -(t - s)^(-0.5) / (1 + s^2*(t - s)) * B", TREE),
    "aging_time": ("kernel C(t, s) = -exp(-(t - s)/(0.2 + s)) * B", TREE),
    "times_t": ("kernel C(t, s) = -(1 + sin(3*t)) * (t - s)^(-0.3) * B", TREE),
    "times_s": ("kernel C(t, s) = -(1 + s) * exp(-(t - s)) * B", ["recursion", "tree"]),
    "tensors": ("kernel C(lag) = -exp(-lag) * B - 0.1*lag^(-0.5) * A - 0.1*exp(-lag^0.5) * D", FIT),
}
FIELDS = {"tensors": 3}  # memory fields where it is not one

SCRIPT = """
param N = 2000 in [1, 1000000]
mesh slab   = rectangle(2, 1, cells = [2, 1])
part roof   = slab.top
part ground = slab.bottom
tensor A = isotropic(lambda = 5, mu = 10)
tensor B = isotropic(young = 70, poisson = 0.3)
tensor D = isotropic(young = 20, poisson = 0.1)
{kernel}
superpotential layer(r) with slope
  | r < 0     -> 0
  | r < 0.02  -> 100*r
  | r < 0.08  -> 2 - 15*(r - 0.02)
  | otherwise -> 1.1
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 1] {grid} from u = 0 using memory = {route}
such that for all v in V
    integral(slab, A : eps(u') : eps(v))
  + integral(slab, B : eps(u) : eps(v))
  + integral(slab, history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu))
 >= integral(slab, dot([5*sin(3*t), -10*t], v))
report
  table u_y = u.y at [1, 0], u_x = u.x at [2, 0], strain = norm(u), stress = integral(slab, sigma.xx)
"""


def write(folder, name, grid, route):
    """The script of a kernel in `folder`, with its data."""
    lags = [0.05 * i for i in range(25)]
    data = "".join(f"{x:.2f},{0.7 * math.exp(-2 * x) + 0.3 * math.exp(-20 * x):.6f}\n" for x in lags)
    folder = pathlib.Path(folder)
    (folder / "relaxation.csv").write_text("lag,modulus\n" + data)
    script = folder / "memory.hvi"
    script.write_text(SCRIPT.format(kernel=KERNELS[name][0], grid=grid, route=route))
    return script
