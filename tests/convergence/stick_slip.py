"""A slider without mass, pulled by a spring at constant speed over ground whose friction falls with the velocity.

usage: stick_slip.py HVI_RUN

It sticks until the spring takes it to the static bound, slips, and sticks again. Reference: independent, an integration located at its
events. While it moves F - w = c(v), c(v) = eta v + d(v), F = pull t, so that with v as the variable dt = c'(v)/(pull - v) dv, dw = v dt. It
creeps from v = 0 to the first maximum of c, if c grows there (Stribeck), jumps to the velocity with the same c beyond, slips to the minimum
of c, and sticks until F - w = d(0) again. The integrals are Gauss's on 2,000 intervals; 1,000 give the same to 1e-12.

The period, the amplitude (the displacement of a cycle) and the peak force must agree to 1e-4 with 4,000 steps, and their errors fall with
the order asked for, in two ways. In the first the grid has the events of the reference among its times: order 1 of backward Euler; bdf2 has less
than 2, because the velocity ends like a square root where the branch ends. In the second nobody knows the events: a first run of a fifth of the
steps, even ones, over a cycle finds when the slider moves, and the other steps divide that time, with one step of the first run before and
after it; both runs count. There the errors of both schemes fall without a clear order: where in a step the jump lies changes with its length. While the slider sticks the
length of steps does not matter.

With even steps the jump is late by a part of a step that looks random: one run says nothing of an order. So the errors of a period and of an
amplitude are averaged over grids whose numbers of steps differ a little, and these averages fall with order 1 with both schemes: no scheme
knows the moment of a jump better than its steps. What 4,000 of them over four units of time do is in published/stick_slip.hvi.
"""
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ETA = 0.02
STEPS = 500, 1000, 2000, 4000
WITHIN = 1e-4  # at the largest number of steps
ORDERS = {"backward_euler": 0.9, "bdf2": 1.2}
CREEPS = 400  # steps, so short that bdf2 begins anew with the slip
EVEN = 500, 1000, 2000, 4000, 8000  # steps
GRIDS = 10  # with up to so many fortieths more steps
EVEN_ORDER = 1.0, 0.15  # of the average errors, within


class Weakening:
    pull = 0.5
    text = "0.5 + 0.5*exp(-5*s)"

    def d(self, v):
        return 0.5 + 0.5 * np.exp(-5 * v)

    def slope(self, v):
        return -2.5 * np.exp(-5 * v)


class Stribeck:
    pull = 0.25  # slower than the velocity at which the slip ends, or it would slide for ever
    text = "0.5 + 0.5*exp(-(s/0.2)^2) + 0.01*s"

    def d(self, v):
        return 0.5 + 0.5 * np.exp(-((v / 0.2) ** 2)) + 0.01 * v

    def slope(self, v):
        return -25 * v * np.exp(-((v / 0.2) ** 2)) + 0.01


def root(f, low, high):
    sign = f(low) < 0
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if (f(middle) < 0) == sign else (low, middle)
    return (low + high) / 2


def way(law, start, end, intervals=2000):
    """Time and displacement while v goes from start to end; more intervals where c is nearly level."""
    x, weights = np.polynomial.legendre.leggauss(20)
    ends = end + (start - end) * np.linspace(0, 1, intervals + 1) ** 2
    time = moved = 0.0
    for a, b in zip(ends[1:], ends):
        v = (a + b) / 2 + (b - a) / 2 * x
        f = (b - a) / 2 * weights * (ETA + law.slope(v)) / (law.pull - v)
        time, moved = time + f.sum(), moved + (f * v).sum()
    return time, moved


def cycle(law, intervals=2000):
    """(creep, slip) times, displacement of both, peak force."""
    c = lambda v: ETA * v + law.d(v)
    rate = lambda v: ETA + law.slope(v)
    first, peak = 0.0, law.d(0.0)
    if rate(0.0) > 0:
        first, most = root(rate, 0.0, 0.05), root(law.slope, 0.0, 0.05)
        peak = law.d(most)
    fast = root(lambda v: c(v) - c(first), 1.0, 1000.0)
    last = root(rate, 0.1, fast)
    creep = way(law, 0.0, first, intervals) if first > 0 else (0.0, 0.0)
    slip = way(law, fast, last, intervals)
    return creep[0], slip[0], creep[1] + slip[1], peak


def grid(law, creep, slip, moved, steps):
    """Times of a cycle and of the stick after it: the events are among them."""
    start, period = first_slip(law), moved / law.pull
    ends = [(start, 4)]
    if creep > 0:
        ends.append((start + creep, CREEPS))
    ends += [(start + creep + slip, steps - 8 - (CREEPS if creep > 0 else 0)), (start + 0.9 * period, 4)]
    out, at = [0.0], 0.0
    for end, n in ends:
        out += list(np.linspace(at, end, n + 1)[1:])
        at = end
    return out


def scouted(program, law, steps, folder):
    """Times of a cycle and of the stick after it, whose events a run with even steps has found."""
    start, scouts = first_slip(law), steps // 5
    even = [0.0, *np.linspace(0.97 * start, start + 2.5 / law.pull * 0.5, scouts)]
    table = run(program, law, even, "backward_euler", folder)
    moves = np.diff(table["w"]) > 1e-9
    times, k = table["t"][1:], even[2] - even[1]
    begins = [n for n in range(1, len(moves)) if moves[n] and not moves[n - 1]]
    ends = next(n for n in range(begins[0], len(moves)) if not moves[n])
    low, high, again = times[begins[0]] - 2 * k, times[ends], times[begins[1]] - 2 * k
    rest = steps - scouts - 5
    return [0.0, *np.linspace(low, high, rest + 1), *np.linspace(high, again, 5)[1:]]


def first_slip(law):
    return 1.0 / law.pull  # the static bounds are 1


def run(program, law, times, method, folder):
    script = f"""
param eta = {ETA}
mesh bar  = interval(1, cells = 1)
part tip  = bar.right
part root = bar.left
fn d(s)   = {law.text}
superpotential drag(r) with slope
  | r < 0     -> -d(-r)
  | otherwise -> d(r)
space V = scalar P1 on bar, zero on root
find p in V for t in [0, {times[-1]!r}] at [{", ".join(repr(float(t)) for t in times)}] from p = 0 using scheme = {method}
such that for all q in V
    integral(bar, eta * dot(grad(p'), grad(q)))
  + integral(bar, dot(grad(p), grad(q)))
  + integral(tip, drag^0(p'; q))
 >= integral(tip, {law.pull}*t * q)
report
  table w = p at [1], xi = drag.xi at [1] to "cycle.csv"
"""
    (folder / "slider.hvi").write_text(script)
    done = subprocess.run([program, "run", "slider.hvi", "--quiet", "-o", "."], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return np.genfromtxt(folder / "cycle.csv", delimiter=",", names=True)


def measured(law, table):
    """Period, amplitude and peak force of a run: the next slip begins where its last stick reaches the static bound."""
    (t1, t2), (f1, f2) = table["t"][-2:], table["xi"][-2:]
    again = t2 + (1.0 - f2) * (t2 - t1) / (f2 - f1)
    return again - first_slip(law), table["w"][-1], table["xi"].max()


def measured_on_even_steps(law, table):
    """Period and amplitude from the first slip to the second, each of which begins where a stick reaches the static bound."""
    t, w, xi = table["t"], table["w"], table["xi"]
    moves = np.diff(w) > 1e-9
    first, second = [n for n in range(1, len(moves)) if moves[n] and not moves[n - 1]][:2]
    begins = lambda n: t[n] + (1.0 - xi[n]) * (t[n] - t[n - 1]) / (xi[n] - xi[n - 1])
    return begins(second) - begins(first), w[second - 1] - w[first - 1]


def on_even_steps(program, law):
    """Do the average errors on even steps fall with their order?"""
    creep, slip, moved, _ = cycle(law)
    end, good = first_slip(law) + creep + slip + 1.2 * moved / law.pull, True
    print("  even steps, averages of so many grids:", GRIDS)
    for method in ORDERS:
        averages = []
        for n in EVEN:
            errors = []
            for j in range(GRIDS):
                times = np.linspace(0, end, n + n * j // 40 + 1)
                with tempfile.TemporaryDirectory() as name:
                    got = measured_on_even_steps(law, run(program, law, times, method, pathlib.Path(name)))
                errors.append([abs(g / e - 1) for g, e in zip(got, (moved / law.pull, moved))])
            averages.append(np.mean(errors, axis=0))
            print(f"  {method} N = {n}: period {averages[-1][0]:.2e}, amplitude {averages[-1][1]:.2e}")
        orders = -np.polyfit(np.log(EVEN), np.log(averages), 1)[0]
        held = bool(np.all(np.abs(orders - EVEN_ORDER[0]) <= EVEN_ORDER[1]))
        print(f"  {method}: orders {orders[0]:.2f} and {orders[1]:.2f} {'ok' if held else 'WRONG'}")
        good = good and held
    return good


def main():
    program, good = str(pathlib.Path(sys.argv[1]).resolve()), True
    for law in (Weakening(), Stribeck()):
        creep, slip, moved, peak = cycle(law)
        coarse = cycle(law, 1000)
        assert max(abs(a - b) for a, b in zip(coarse, (creep, slip, moved, peak))) < 1e-12
        print(f"{type(law).__name__}: creeps {creep:.6g}, slips {slip:.10g}, moves {moved:.10g}, peak {peak:.10g}")
        for known, method in ((known, method) for known in (True, False) for method in ORDERS):
            errors = []
            print("  events " + ("known" if known else "found by a first run"))
            for n in STEPS:
                with tempfile.TemporaryDirectory() as name:
                    folder = pathlib.Path(name)
                    times = grid(law, creep, slip, moved, n) if known else scouted(program, law, n, folder)
                    got = measured(law, run(program, law, times, method, folder))
                errors.append([abs(g / e - 1) for g, e in zip(got, (moved / law.pull, moved, peak))])
                print(f"  {method} N = {n}: period {errors[-1][0]:.2e}, amplitude {errors[-1][1]:.2e}, peak {errors[-1][2]:.2e}")
            order = math.log2(errors[-3][0] / errors[-1][0]) / 2
            falls = order >= ORDERS[method] if known else errors[-1][0] < errors[0][0] / 2
            held = max(errors[-1]) <= WITHIN and falls
            print(f"  {method}: order {order:.2f}{f', at least {ORDERS[method]}' if known else ''} {'ok' if held else 'WRONG'}")
            good = good and held
        good = on_even_steps(program, law) and good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
