#!/usr/bin/env python3
"""Random memory kernels on random grids, against the memory equation solved with independent weights.

usage: memory.py HVI_RUN [--scenes N] [--seed S] [--keep FOLDER]

Scene: -u'' plus its memory on (0, 1), load f(t): u(1, t) = y(t)/2 with y_n + sum_j w_nj y_j = f(t_n), where w_nj is
the integral of q(t_n, s) over the j-th step. Reference: y by forward substitution, w in long double from closed
forms, or by composite Gauss rules graded to both ends of a step (nothing of the program's). Kernels: exponentials,
separable, ageing in a reduced time, windows, peaks, weakly singular, products of powers; up to 1e12 relaxation
times; uniform, graded and random grids; t0 of both signs; every route. Wrong: certified and further from y than
30 memory tolerances. Refused: any other exit where every step is coercive and errors
of the data grow less than a million times; none may be.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

L = np.longdouble
TOLERANCE = 1e-8
GAUSS = [v.astype(L) for v in np.polynomial.legendre.leggauss(24)]


def erf(x):
    return np.array([L(math.erf(float(v))) for v in np.atleast_1d(x)])


class Convolution:
    """Weights from an antiderivative in the lag, as a function of (low, high)."""

    def __init__(self, text, over):
        self.text, self.over = text, over

    def weights(self, t, times):
        high, low = t - times[:-1], t - times[1:]
        return self.over(low, high)


class OfTimes:
    """Weights from an antiderivative in s for fixed t."""

    def __init__(self, text, over):
        self.text, self.over = text, over

    def weights(self, t, times):
        return self.over(t, times)


def composite(f, low, high, cuts=()):
    """int f over [low, high] in x, panels grown twofold from both ends and from the cuts."""
    ends = {low, high}
    for c in [low, high, *cuts]:
        for j in range(1, 100):
            for side in (-1, 1):
                x = c + side * (high - low) * L(2) ** -j
                if low < x < high and (c == 0 or abs(x - c) > 1e-17 * abs(c)):
                    ends.add(x)
    ends = np.array(sorted(ends), dtype=L)
    half, middle = (ends[1:] - ends[:-1]) / 2, (ends[1:] + ends[:-1]) / 2
    x = middle[:, None] + half[:, None] * GAUSS[0][None, :]
    return np.sum(f(x) * GAUSS[1][None, :] * half[:, None])


def exponentials(rng, span):
    count = rng.integers(1, 4)
    times = span * 10.0 ** rng.uniform(-12, 0.5, count)
    weights = rng.uniform(0.05, 0.3, count)
    text = "-(" + " + ".join(f"{w!r}/{tau!r}*exp(-lag/{tau!r})" for w, tau in zip(weights, times)) + ")"

    def over(low, high):
        total = 0
        for w, tau in zip(weights, times):
            total = total + L(w) * np.exp(-low / L(tau)) * np.expm1(-(high - low) / L(tau))
        return total
    return Convolution(f"kernel q(lag) = {text}", over)


def separable(rng, span):
    tau, age = span * 10.0 ** rng.uniform(-10, 0), span * 10.0 ** rng.uniform(-6, 0)
    shift = float(max(0.0, -rng.t0)) # s + shift is never negative
    text = (f"kernel q(t, s) = -0.3/{tau!r}*exp((s - t)/{tau!r})*(1 + (s + {shift!r})/(s + {shift + age!r}))")

    def over(t, times):
        out = []
        for a, b in zip(times[:-1], times[1:]):
            low, high = t - b, t - a
            if low > 11000 * L(tau):
                out.append(L(0))
                continue

            def f(lag):
                s = t - lag + L(shift)
                return L(-0.3) / L(tau) * np.exp(-lag / L(tau)) * (1 + s / (s + L(age)))
            out.append(composite(f, low, min(high, low + 200 * L(tau)))
                       + (0 if high <= low + 200 * L(tau) else L(0)))
        return np.array(out)
    return OfTimes(text, over)


def ageing(rng, span):
    """dG(xi(t) - xi(s)) xi'(s), xi(a) = a + c (a - d log(1 + a/d)): the integral is a difference of G."""
    count = rng.integers(1, 4)
    taus = span * 10.0 ** rng.uniform(-11, 0, count)
    weights = rng.uniform(0.05, 0.2, count)
    c, d = float(rng.uniform(1, 9)), float(span * 10.0 ** rng.uniform(-6, 0))
    shift = float(max(0.0, -rng.t0))
    terms = " + ".join(f"{w!r}/{tau!r}*exp(-r/{tau!r})" for w, tau in zip(weights, taus))
    text = (f"fn xi(a) = a + {c!r}*(a - {d!r}*log(1 + (a + {shift!r})/{d!r}))\n"
            f"fn rate(a) = 1 + {c!r}*(a + {shift!r})/(a + {shift + d!r})\n"
            f"fn g(r) = -({terms})\nkernel q(t, s) = g(xi(t) - xi(s))*rate(s)")

    def reduced(t, s):
        lag = t - s
        then = L(d) + s + L(shift)
        return lag + L(c) * (lag - L(d) * np.log1p(lag / then))

    def over(t, times):
        r = np.array([reduced(t, s) for s in times], dtype=L)
        total = L(0)
        for w, tau in zip(weights, taus):
            total = total + L(w) * np.exp(-r[1:] / L(tau)) * np.expm1(-(r[:-1] - r[1:]) / L(tau))
        return total
    return OfTimes(text, over)


def window(rng, span):
    a, b = sorted(rng.uniform(0.0, 1.0, 2) * span)
    if rng.random() < 0.5:
        b = a + span * 10.0 ** rng.uniform(-6, -1)
    size = 0.4 / (b - a)
    if rng.random() < 0.5:  # of the lag
        text = f"kernel q(lag) = (| lag < {a!r} -> 0 | lag < {b!r} -> {-size!r} | otherwise -> 0)"
        over = lambda low, high: -L(size) * np.maximum(0, np.minimum(high, L(b)) - np.maximum(low, L(a)))
        return Convolution(text, over)
    a, b = a + rng.t0, b + rng.t0
    if rng.random() < 0.5:  # of the time, and of the source before b: it leaves while the run goes on
        size = 0.4 / span
        text = f"kernel q(t, s) = (| t < {a!r} -> 0 | s < {b!r} -> {-size!r} | otherwise -> 0)"
        return OfTimes(text, lambda t, times: -L(size) * (t >= a) * np.maximum(
            0, np.minimum(times[1:], L(b)) - times[:-1]))
    size = 0.4 / (b - a)  # of the source
    text = f"kernel q(t, s) = (| s < {a!r} -> 0 | s < {b!r} -> {-size!r} | otherwise -> 0)"
    return OfTimes(text, lambda t, times: -L(size) * np.maximum(
        0, np.minimum(times[1:], L(b)) - np.maximum(times[:-1], L(a))))


def peak(rng, span):
    place, width = span * rng.uniform(0.05, 0.95), span * 10.0 ** rng.uniform(-6, -1)
    if rng.random() < 0.5:
        size = 0.4 / (width * math.sqrt(math.pi))
        text = f"kernel q(lag) = {-size!r}*exp(-((lag - {place!r})/{width!r})^2)"
        primitive = lambda x: L(0.2) * erf((x - L(place)) / L(width))
    else:
        size = 0.4 / (width * math.pi)
        text = f"kernel q(lag) = {-size!r}/(1 + ((lag - {place!r})/{width!r})^2)"
        primitive = lambda x: L(0.4) / L(math.pi) * np.arctan((x - L(place)) / L(width))
    return Convolution(text, lambda low, high: primitive(low) - primitive(high))


def weakly_singular(rng, span):
    e = float(rng.uniform(0.05, 0.9))
    size = 0.4 * (1 - e) / span ** (1 - e)
    text = f"kernel q(lag) = {-size!r}*lag^(-{e!r})"
    power = lambda x: x ** (1 - L(e)) / (1 - L(e))
    return Convolution(text, lambda low, high: -L(size) * (power(high) - power(low)))


def arcsine(rng, span):
    if rng.t0 < 0:
        return weakly_singular(rng, span)
    text = "kernel q(t, s) = -0.25*(t^2 - s^2)^(-0.5)"

    def over(t, times):
        # asin(b/t) - asin(a/t), without losing digits near s = t
        angle = 2 * np.arctan2(np.sqrt(np.maximum(t - times, 0)), np.sqrt(t + times))
        return -L(0.25) * (angle[:-1] - angle[1:])
    return OfTimes(text, over)


def powers(rng, span):
    """t^a s^b (t - s)^(-c)."""
    if rng.t0 < 0:
        return exponentials(rng, span)
    a, b, c = float(rng.uniform(-0.5, 1)), float(rng.uniform(-0.5, 1.5)), float(rng.uniform(0.1, 0.8))
    size = 0.2 / (span + rng.t0) ** (a + b + 1 - c)
    text = f"kernel q(t, s) = {-size!r}*t^({a!r})*s^({b!r})*(t - s)^(-{c!r})"

    def over(t, times):
        out = []
        for s0, s1 in zip(times[:-1], times[1:]):
            middle = (s0 + s1) / 2
            near = composite(lambda lag: (t - lag) ** L(b) * lag ** -L(c), t - s1, t - middle)
            if s1 == t:  # the same by lag = h v^m
                h, m = t - middle, 1 / (1 - L(c))
                near = composite(lambda v: (t - h * v ** m) ** L(b) * m, L(0), L(1)) * h ** (1 - L(c))
            if s0 == 0:  # s = h v^m
                m = 1 / (1 + L(b))
                far = composite(lambda v: (t - middle * v ** m) ** -L(c) * m, L(0), L(1)) * middle ** (1 + L(b))
            else:
                far = composite(lambda s: s ** L(b) * (t - s) ** -L(c), s0, middle)
            out.append(-L(size) * t ** L(a) * (near + far))
        return np.array(out)
    return OfTimes(text, over)


KINDS = [exponentials, separable, ageing, window, peak, weakly_singular, arcsine, powers]


def scene(rng):
    span = float(10.0 ** rng.uniform(-3, 6))
    rng.t0 = float(rng.choice([0.0, 0.0, rng.uniform(0.1, 3), -rng.uniform(0.1, 3)]) * span)
    kernel = KINDS[rng.integers(len(KINDS))](rng, span)
    t0, t1, n = rng.t0, rng.t0 + span, int(rng.integers(3, 30))
    kind = rng.integers(3)
    if kind == 0:
        grid, times = f"by {n} steps", [t0 + (t1 - t0) * k / n for k in range(n + 1)]
    elif kind == 1:
        p = int(rng.integers(2, 13))
        if t0 != 0.0:
            p = min(p, 3)  # shorter steps than the rounding of t0 are refused
        grid, times = f"at graded({n}, {p})", [t0 + (t1 - t0) * (k / n) ** p for k in range(n + 1)]
    else:
        inner = sorted(t0 + (t1 - t0) * float(x) for x in rng.uniform(0.001, 0.999, n - 1))
        times = [t0, *inner, t1]
        grid = "at [" + ", ".join(repr(t) for t in times) + "]"
    route = str(rng.choice(["automatic", "direct", "tree", "fit"]))
    swing = float(rng.choice([0.5, 0.5, 0.0])) # a constant load: increments that vanish
    text = f"""mesh j = interval(1, cells = 2)
part base = j.left
{kernel.text}
space V = scalar P1 on j, zero on base
find u in V for t in [{t0!r}, {t1!r}] {grid} from u = 0 using memory = {route}
such that for all v in V
    integral(j, dot(grad(u), grad(v))) + integral(j, dot(history(q, grad(u)), grad(v)))
  = integral(j, (1 + {swing!r}*sin(7*(t - {t0!r})/{span!r}))*v)
report
  table m = u at [1]
"""
    load = lambda t: 1 + L(swing) * np.sin(7 * (L(t) - L(t0)) / L(span))
    return text, kernel, times, load


def reference(kernel, times, load):
    """m at the grid times, and by how much more than relative errors of load and stiffness, drawn at random, it changes
    (infinite where a step is not coercive)."""
    t = np.array(times, dtype=L)
    noise = np.random.default_rng(1).uniform(-1, 1, (2, len(t))).astype(L)
    y, moved, coercive = [], [], True
    for n in range(1, len(t)):
        w = kernel.weights(t[n], t[:n + 1])
        coercive = coercive and 1 + w[n - 1] > 0
        for values, change in ((y, L(0)), (moved, L(1e-8))):
            past = sum((w[j] * values[j] for j in range(n - 1)), L(0))
            values.append((load(t[n]) * (1 + change * noise[0, n]) - past) / (1 + change * noise[1, n] + w[n - 1]))
    y, moved = np.array(y, dtype=L), np.array(moved, dtype=L)
    growth = float(np.max(np.abs(moved - y)) / np.max(np.abs(y))) / 1e-8
    return y / 2, growth if coercive else math.inf


def run(program, text, folder):
    script, result = folder / "scene.hvi", folder / "result.json"
    script.write_text(text)
    done = subprocess.run([program, script, "--quiet", "--json", result, "-o", folder], capture_output=True, text=True,
                          timeout=120)
    if done.returncode != 0:
        return None, done.stderr
    found = json.loads(result.read_text())
    return found, ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep")
    given = parser.parse_args()
    certified = wrong = refused = rightly = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for i in range(given.scenes):
            rng = Draw(np.random.default_rng([given.seed, i]))
            text, kernel, times, load = scene(rng)
            try:
                found, said = run(str(pathlib.Path(given.program).resolve()), text, folder)
            except subprocess.TimeoutExpired:
                found, said = None, "no end within 120 s"
            y, growth = reference(kernel, times, load)
            off = 0.0
            if found is None:
                badly_posed = growth > 1e6
                rightly += badly_posed
                refused += not badly_posed
                print(f"scene {i} refused (errors of the data grow {growth:.0e} times): {said.strip().splitlines()[:1]}")
            else:
                certified += 1
                u = np.array(found["table"]["m"][-len(y):], dtype=L)
                off = float(np.max(np.abs(u - y)) / np.max(np.abs(y)))
                if not off <= 30 * TOLERANCE:
                    wrong += 1
                    memory = found["plan"]["history"][0]
                    print(f"scene {i} WRONG by {off:.1e}: {memory['route']}, audit {memory['audit']}")
            if given.keep and (found is None or not off <= 30 * TOLERANCE):
                pathlib.Path(given.keep).mkdir(parents=True, exist_ok=True)
                (pathlib.Path(given.keep) / f"scene{i}.hvi").write_text(text)
    print(f"refused rightly: {rightly}, of problems with a step that is not coercive or in which errors of the data grow more than a million times")
    print(f"family memory: scenes {given.scenes}, certified {certified}, wrong {wrong}, refused {refused}")
    sys.exit(wrong > 0 or refused > 0)


class Draw:
    """A random generator that also carries the start of the scene."""

    def __init__(self, rng):
        self._rng, self.t0 = rng, 0.0

    def __getattr__(self, name):
        return getattr(self._rng, name)


if __name__ == "__main__":
    main()
