#!/usr/bin/env python3
"""Random small scenes whose uniqueness is decided here, by dense eigenvalues at every step.

Usage: verdicts.py HVI_RUN [--scenes N] [--seed S] [--rates SHARE]

Each scene has a viscosity (or none), an elasticity, memories q(t, s) (or none) and a law whose steepest descent m is
known by construction, on a chain or on a slab of triangles, over a uniform grid, a graded one or random times, by
backward Euler or BDF2, or it is static. Independent of the program: stiffness matrices are assembled here, the weights
of the memories are Gauss-Legendre sums, and the problem of step n has one solution for every load iff
K_n - m sum_p w_p g_p g_p^T is positive definite (the law is as steep everywhere on an interval of arguments, and the load is free). In a share of the scenes the law sees u', and
m counts as much more as u' grows with the increment.

Wrong: `check` says "exactly one solution" or `run` "guaranteed" where a step has several, or the step margin is more than
0.5 % of the ratio off. Refused: one of them says no where every step is unique with 1 % to spare. Both must be 0.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

nodes, weights = np.polynomial.legendre.leggauss(60)


def chain(cells):
    """Stiffness of grad . grad on (0, 1), clamped on the left, and the law's vectors with their weights."""
    h, k = 1 / cells, np.zeros((cells + 1, cells + 1))
    for i in range(cells):
        k[i:i + 2, i:i + 2] += np.array([[1, -1], [-1, 1]]) / h
    tip = np.zeros(cells)
    tip[-1] = 1
    return (lambda lam, mu: (lam + 2 * mu) * k[1:, 1:]), [(1.0, tip)]


def slab(n):
    """The same on the slab 2 x 1 in 2n x n cells for isotropic tensors, clamped on top; nodal normal law at the bottom."""
    columns, h = 2 * n + 1, 1.0 / n
    size = 2 * columns * (n + 1)
    parts = [np.zeros((size, size)), np.zeros((size, size))]
    laws = (np.array([[1, 1, 0], [1, 1, 0], [0, 0, 0]]), 2 * np.eye(3))  # lambda, mu on (xx, yy, sqrt 2 xy)
    for j in range(n):
        for i in range(2 * n):
            a, b, c, d = (y * columns + x for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
            for cell, gradients in (((a, b, c), [(-1, 0), (1, -1), (0, 1)]), ((a, c, d), [(0, -1), (1, 0), (-1, 1)])):
                strain = np.zeros((3, 6))
                for k, (gx, gy) in enumerate(gradients):
                    strain[0, 2 * k], strain[1, 2 * k + 1] = gx / h, gy / h
                    strain[2, 2 * k], strain[2, 2 * k + 1] = gy / h / np.sqrt(2), gx / h / np.sqrt(2)
                dofs = [2 * v + component for v in cell for component in (0, 1)]
                for part, law in zip(parts, laws):
                    part[np.ix_(dofs, dofs)] += h * h / 2 * strain.T @ law @ strain
    free = 2 * columns * n
    parts = [p[:free, :free] for p in parts]
    points = []
    for i in range(columns):
        g = np.zeros(free)
        g[2 * i + 1] = -1
        points.append((h if 0 < i < columns - 1 else h / 2, g))
    return (lambda lam, mu: lam * parts[0] + mu * parts[1]), points


def kernel(random):
    """A kernel as text and as a function of (t, lag)."""
    c, a, w, p = random.uniform(-6, 6), random.uniform(0.2, 8), random.uniform(1, 30), random.integers(1, 9)
    return [
        (f"q(lag) = {c}*exp(-{a}*lag)", lambda t, lag: c * np.exp(-a * lag) + 0 * t),
        (f"q(t, s) = {c}*t^{p}", lambda t, lag: c * t**p + 0 * lag),
        (f"q(t, s) = {c}*exp(-{a}*(t - s))*(1 + 0.9*sin({w}*t))", lambda t, lag: c * np.exp(-a * lag) * (1 + 0.9 * np.sin(w * t))),
        (f"q(t, s) = {c}*cos({w}*s)", lambda t, lag: c * np.cos(w * (t - lag))),
        (f"q(t, s) = {c}/(1 + {a}*t)*exp(-(t - s))", lambda t, lag: c / (1 + a * t) * np.exp(-lag)),
    ][random.integers(5)]


def grid(random):
    """A time grid as text and as numbers."""
    n = int(random.integers(2, 25))
    kind = random.integers(4)
    if kind == 0:
        power = random.choice([1.5, 2, 3])
        return f"at graded({n}, {power})", (np.arange(n + 1) / n)**power
    if kind == 1:
        times = np.round(np.cumsum(random.uniform(0.02, 1, n)), 4)
        times = np.round(times / times[-1], 6)
        return "at [" + ", ".join(repr(float(t)) for t in times) + "]", np.concatenate([[0], times])
    return f"by {n} steps", np.arange(n + 1) / n


def step_matrices(stiff, tensors, kernels, times, bdf2):
    a, b, memories = tensors
    for n in range(1, len(times)):
        k = times[n] - times[n - 1]
        rate = 1 / k
        if bdf2 and n > 1:
            ratio = k / (times[n - 1] - times[n - 2])
            rate *= (1 + 2 * ratio) / (1 + ratio)
        lag = k * (nodes + 1) / 2
        shape = 1 - lag / k if bdf2 else 1
        matrix = stiff(*b) + (rate * stiff(*a) if a else 0)
        for (_, q), e in zip(kernels, memories):
            matrix = matrix + k / 2 * np.sum(weights * q(times[n], lag) * shape) * stiff(*e)
        yield matrix, rate


def ratio(matrix, form):
    """lambda_max(form, matrix); infinite where the matrix is not positive definite."""
    if np.linalg.eigvalsh(matrix)[0] <= 1e-12 * np.abs(matrix).max():
        return np.inf
    inverse = np.linalg.inv(np.linalg.cholesky(matrix))
    return np.linalg.eigvalsh(inverse @ form @ inverse.T)[-1]


def scene(random, rates):
    """Script, and lambda_max of every step with the law's m. `rates`: how likely it acts on u'."""
    on_rate = rates > 0 and random.random() < rates
    flat = random.random() < 0.3
    cells = int(random.integers(1, 3) if flat else random.integers(1, 9))
    stiff, points = slab(cells) if flat else chain(cells)
    constants = lambda scale: tuple(float(v) for v in scale * np.exp(random.uniform(-1.5, 1.5, 2)))
    static = random.random() < 0.1 and not on_rate
    a = None if static or random.random() < 0.2 else constants(random.choice([1e-3, 0.05, 1]))
    b = constants(1)
    kernels = [] if static else [kernel(random) for _ in range(random.integers(0, 3))]
    memories = [constants(0.5) if random.random() < 0.6 else b for _ in kernels]
    text, times = grid(random)
    bdf2 = not static and random.random() < 0.25
    times = np.array([0.0, 1.0]) if static else times
    form = sum(w * np.outer(g, g) for w, g in points)
    ratios = np.array([ratio(k, rate * form if on_rate else form)
                       for k, rate in step_matrices(stiff, (a, b, memories), kernels, times, bdf2)])
    if static:
        ratios = np.array([ratio(stiff(*b), form)])
    worst = ratios.max()
    aim = random.choice([random.uniform(0.3, 0.985), random.uniform(0.985, 0.9999), random.uniform(1.0001, 1.02), random.uniform(1.02, 4)])
    if not np.isfinite(worst):  # m for one of the other steps
        worst = ratios[np.isfinite(ratios)].max() if np.isfinite(ratios).any() else 1.0
    m = aim / worst
    if flat:
        space, grad, arg = "vector P1 on body, zero on held", lambda c, u: f"isotropic(lambda = {c[0]!r}, mu = {c[1]!r}) : eps({u}) : eps(v)", "u.nu; v.nu"
        head = f"mesh body = rectangle(2, 1, cells = [{2 * cells}, {cells}])\npart held = body.top\npart touched = body.bottom\n"
        load = "integral(body, dot([0, -1e-6], v))"
    else:
        space, arg = "scalar P1 on body, zero on held", "u; v"
        grad = lambda c, u: f"{c[0] + 2 * c[1]!r}*dot(grad({u}), grad(v))"
        head = f"mesh body = interval(1, cells = {cells})\npart held = body.left\npart touched = body.right\n"
        load = "integral(touched, 1e-6*v)"
    if on_rate:
        arg = arg.replace("u", "u'", 1)
    tensors, forms = "", []

    def form_of(c, u):
        nonlocal tensors
        if not flat:
            forms.append(f"integral(body, {grad(c, u)})")
            return
        name = f"T{len(forms)}"
        tensors += f"tensor {name} = isotropic(lambda = {c[0]!r}, mu = {c[1]!r})\n"
        forms.append(f"integral(body, {name} : eps({u}) : eps(v))")

    if a:
        form_of(a, "u'")
    form_of(b, "u")
    for i, ((q, _), e) in enumerate(zip(kernels, memories)):
        tensors += f"kernel {q.replace('q(', f'q{i}(', 1)}\n"
        if flat:
            name = f"E{i}"
            tensors += f"tensor {name} = isotropic(lambda = {e[0]!r}, mu = {e[1]!r})\n"
            forms.append(f"integral(body, {name} : eps(history(q{i}, u)) : eps(v))")
        else:
            forms.append(f"integral(body, {e[0] + 2 * e[1]!r}*dot(history(q{i}, grad(u)), grad(v)))")
    top = 0.5 * m
    law = f"superpotential soft(r) with slope | r < 0.01 -> {100 * top!r}*r | r < 0.51 -> {top!r} - {m!r}*(r - 0.01) | otherwise -> {top - m * 0.5!r}\n"
    when = "" if static else f" for t in [0, 1] {text} from u = 0" if text.startswith("by") else f" for t in [0, 1] {text} from u = 0"
    using = "\n  using scheme = bdf2" if bdf2 else ""
    body = "\n  + ".join(forms + [f"integral(touched, soft^0({arg}))"])
    end = "u at [1]" if not flat else "u.y at [1, 0]"
    return (f"{head}{tensors}{law}space V = {space}\nfind u in V{when}{using}\nsuch that for all v in V\n    {body}\n >= {load}\n"
            f"report\n  table end = {end}\n", m * ratios)


def ask(hvi_run, command, folder):
    """Exit code, report and standard error of a command on scene.hvi in the folder."""
    out = folder / f"{command}.json"
    out.unlink(missing_ok=True)
    run = subprocess.run([hvi_run, command, "scene.hvi", "--json", out.name, "--quiet"], capture_output=True, text=True, timeout=120, cwd=folder)
    return run.returncode, json.loads(out.read_text()) if out.exists() else None, run.stderr


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("hvi_run")
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1706)
    parser.add_argument("--rates", type=float, default=0.0)
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    unique = wrong = refused = solved = 0
    hvi_run = pathlib.Path(options.hvi_run).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for number in range(options.scenes):
            script, ratios = scene(random, options.rates)
            (folder / "scene.hvi").write_text(script)

            def tell(what):
                keep = pathlib.Path(tempfile.gettempdir()) / f"verdicts_{options.seed}_{number}.hvi"
                keep.write_text(script)
                print(f"scene {number} ({keep}): {what}; worst ratio here {ratios.max():.6g} at step {ratios.argmax() + 1}")

            code, report, error = ask(hvi_run, "check", folder)
            if report is None:
                if np.isfinite(ratios).all():
                    tell(f"no report, exit {code}: {error.strip()[:200]}")
                    refused += 1
                continue  # a matrix that is not positive definite: the first step says so
            several, sure = ratios.max() >= 1 + 1e-9, ratios.max() <= 0.99
            says = report["verdict"]["discrete"]["holds"]
            unique += says
            if says and several:
                tell("check: exactly one solution"), (wrong := wrong + 1)
            if not says and sure:
                tell("check refuses"), (refused := refused + 1)
            margin = report["constants"]["step_margin"]
            if np.isfinite(ratios).all() and not isinstance(margin, str):
                if margin is None or abs(1 - margin - ratios.max()) > 5e-3 * ratios.max():
                    tell(f"step margin {margin}"), (wrong := wrong + 1)
            code, result, error = ask(hvi_run, "run", folder)
            if result is None:
                continue  # no certified solution is no verdict
            solved += 1
            says = result["uniqueness"] == "guaranteed"
            if says and several:
                tell("run: guaranteed"), (wrong := wrong + 1)
            if not says and sure:
                tell("run refuses"), (refused := refused + 1)
    print(f"{solved} scenes run, too")
    print(f"family verdicts: scenes {options.scenes}, certified {unique}, wrong {wrong}, refused {refused}")
    return 1 if wrong or refused else 0


if __name__ == "__main__":
    sys.exit(main())
