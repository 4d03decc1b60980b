#!/usr/bin/env python3
"""reactions.py HVI_RUN [--scenes N] [--seed S]: reaction(part) against nodal forces assembled here.

Random bodies of triangles (uneven, turned, from 1e-3 to 1e3 in size, stiffnesses over ten decades) with
viscosity, memory, inertia, springs, friction on the rate and moving supports, P1. By backward Euler the stiffness
matrix is assembled here by itself, the nodal values come from the tables, and the forces on the held nodes are
A u' + B u + w + M u'' - f, row by row. Reactions of laws are compared with what their multipliers integrate to, and all
reactions with the loads. By the other schemes (bdf2, and with inertia newmark, hht, midpoint) all reactions together are compared
with the loads, mixed as the scheme mixes them, and with mass times acceleration; and reactions of laws, unilateral ones on u too, with
what their multipliers integrate to. There midpoint takes the mass off nodes, and what is left of the balance is that the parts add up.
By the last three half of the bodies lose stiffness: the forces of the step before are then those of the states that it ended with.
"""
import argparse
import csv
import math
import pathlib
import subprocess
import tempfile

import numpy as np


def grid(rng, n, m, size, angle):
    """Nodes and triangles of an uneven grid of n x m quadrilaterals, turned."""
    x = np.array([[i / n * 1.5, j / m] for j in range(m + 1) for i in range(n + 1)])
    inner = (x[:, 0] > 0) & (x[:, 0] < 1.5) & (x[:, 1] > 0) & (x[:, 1] < 1)
    x[inner] += rng.uniform(-0.1, 0.1, (inner.sum(), 2)) / max(n, m)
    cells = []
    for j in range(m):
        for i in range(n):
            a, b, c, d = j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i + 1, (j + 1) * (n + 1) + i
            cells += [[a, b, c], [a, c, d]] if rng.random() < 0.5 else [[a, b, d], [b, c, d]]
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    sides = {"left": [[(j + 1) * (n + 1), j * (n + 1)] for j in range(m)],
             "right": [[j * (n + 1) + n, (j + 1) * (n + 1) + n] for j in range(m)],
             "bottom": [[i, i + 1] for i in range(n)],
             "top": [[m * (n + 1) + i + 1, m * (n + 1) + i] for i in range(n)]}
    return size * x @ turn.T, np.array(cells), sides


def write_msh(path, x, cells, sides):
    names = list(sides)
    out = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
    out += [f'1 {k + 1} "{name}"' for k, name in enumerate(names)] + [f'2 {len(names) + 1} "body"', "$EndPhysicalNames"]
    out += ["$Nodes", str(len(x))] + [f"{i + 1} {p[0]!r} {p[1]!r} 0" for i, p in enumerate(x.tolist())] + ["$EndNodes"]
    elements = [f"1 2 {k + 1} {k + 1} {a + 1} {b + 1}" for k, name in enumerate(names) for a, b in sides[name]]
    elements += [f"2 2 {len(names) + 1} {len(names) + 1} {a + 1} {b + 1} {c + 1}" for a, b, c in cells.tolist()]
    out += ["$Elements", str(len(elements))] + [f"{i + 1} {e}" for i, e in enumerate(elements)] + ["$EndElements", ""]
    path.write_text("\n".join(out))


def stiffness(x, cells, lam, mu):
    k = np.zeros((2 * len(x), 2 * len(x)))
    c = np.array([[lam + 2 * mu, lam, 0], [lam, lam + 2 * mu, 0], [0, 0, mu]])
    for cell in cells:
        m = np.column_stack([np.ones(3), x[cell]])
        grad = np.linalg.inv(m)[1:].T
        b = np.zeros((3, 6))
        b[0, 0::2], b[1, 1::2], b[2, 0::2], b[2, 1::2] = grad[:, 0], grad[:, 1], grad[:, 1], grad[:, 0]
        dofs = np.ravel([[2 * i, 2 * i + 1] for i in cell])
        k[np.ix_(dofs, dofs)] += abs(np.linalg.det(m)) / 2 * b.T @ c @ b
    return k


def mass(x, cells):
    out = np.zeros((2 * len(x), 2 * len(x)))
    for cell in cells:
        area = abs(np.linalg.det(np.column_stack([np.ones(3), x[cell]]))) / 2
        for i in cell:
            for j in cell:
                for c in range(2):
                    out[2 * i + c, 2 * j + c] += area / 12 * (2 if i == j else 1)
    return out


def load(x, cells, sides, body, pull):
    f = np.zeros(2 * len(x))
    for cell in cells:
        area = abs(np.linalg.det(np.column_stack([np.ones(3), x[cell]]))) / 2
        for i in cell:
            f[2 * i:2 * i + 2] += area / 3 * body
    for a, b in sides["top"]:
        for i in (a, b):
            f[2 * i:2 * i + 2] += np.linalg.norm(x[a] - x[b]) / 2 * pull
    return f


def totals(rows, scheme, loads, moves, stops):
    """All reactions and the loads together against the mass times the acceleration; those of laws against their multipliers."""
    of = lambda row, name: np.array([float(row[f"{name}_{c}"]) for c in "xy"])
    old = {"hht": 0.1, "midpoint": 0.5}.get(scheme, 0.0)  # the share of the forces of the step before
    worst, t_before, law_before = 0.0, 0.0, None
    for row in rows:
        t = float(row["t"])
        if t == 0:
            continue
        f = (1 - old) * loads(t) + old * loads(t_before)
        moved = of(row, "inertia") if moves else np.zeros(2)
        scale = max(np.abs(f).max(), np.abs(of(row, "all")).max(), np.abs(moved).max())
        if not stops:
            worst = max(worst, np.abs(of(row, "all") + f.reshape(-1, 2).sum(0) - moved).max() / scale)
        parts = [of(row, name) for name in ("left", "right", "bottom") if f"{name}_x" in row]
        worst = max(worst, np.abs(sum(parts) - of(row, "all")).max() / scale)
        if "by_law_x" in row:
            law = of(row, "by_law")
            if scheme != "hht":
                worst = max(worst, np.abs(of(row, "bottom") - law).max() / scale)
            elif law_before is not None:
                worst = max(worst, np.abs(of(row, "bottom") - (1 - old) * law - old * law_before).max() / scale)
            law_before = law
        t_before = t
    return worst


def scene(rng, folder, hvi_run):
    n, m = int(rng.integers(2, 5)), int(rng.integers(1, 4))
    size, angle = 10.0 ** rng.uniform(-3, 3), rng.uniform(0, 2 * math.pi)
    x, cells, sides = grid(rng, n, m, size, angle)
    stiff = 10.0 ** rng.uniform(-3, 7)
    lam, mu = stiff * rng.uniform(0.1, 3), stiff
    viscous, memory, moves = rng.random() < 0.5, rng.random() < 0.5, rng.random() < 0.4
    spring, rub, driven = rng.random() < 0.6, rng.random() < 0.5, rng.random() < 0.5
    eta, tau, steps, end = rng.uniform(0.1, 2), rng.uniform(0.2, 2), int(rng.integers(2, 6)), 1.0
    scheme = str(rng.choice(["backward_euler", "backward_euler", *(["newmark", "hht", "midpoint"] if moves else ["bdf2"])]))
    stops = scheme == "midpoint" and not driven and rng.random() < 0.7
    rho = stiff / size ** 2 * rng.uniform(0.01, 1)
    body, pull = stiff / size * rng.uniform(-0.1, 0.1, 2), stiff * rng.uniform(-0.1, 0.1, 2)
    fades = scheme not in ("backward_euler", "bdf2") and rng.random() < 0.5
    write_msh(folder / "body.msh", x, cells, sides)
    on_right = f"[{size * 0.01!r}*t^2, {-size * 0.02!r}*t^2]"
    terms = [f"integral(body, {'(1 - lost)*' if fades else ''}B : eps(u) : eps(v))"]
    terms += ["integral(body, A : eps(u') : eps(v))"] if viscous else []
    terms += ["integral(body, history(C, eps(u)) : eps(v))"] if memory else []
    terms += [f"integral(body, {rho!r}*dot(u'', v))"] if moves else []
    laws = (["stop^0(u.nu; v.nu)"] if stops else []) + (["spring^0(u.nu; v.nu)"] if spring else []) + (["rub^0(u'.tau; v.tau)"] if rub else [])
    terms += [f"integral(bottom, {' + '.join(laws)})"] if laws else []
    points = ", ".join(f"n{i} = u at [{p[0]!r}, {p[1]!r}]" for i, p in enumerate(x.tolist()))
    table = [points, "left = reaction(left)"]
    zero = "zero on left" + (", zero on right" if driven else "")
    if driven:
        table += ["right = reaction(right)"]
    xi = []
    for law, of in [("stop", "-stop.xi*normal.{}"), ("spring", "-spring.xi*normal.{}"), ("rub", "-rub.xi.{}")]:
        if (law == "stop" and stops) or (law == "spring" and spring) or (law == "rub" and rub):
            xi.append(of)
    if xi:
        table += ["bottom = reaction(bottom)"] + [f"by_law_{c} = integral(bottom, {' + '.join(xi).replace('{}', c)})" for c in "xy"]
    table += ["all = reaction(solid)"]
    if moves:
        table += [f"inertia_{c} = integral(body, {rho!r}*u''.{c})" for c in "xy"]
    script = f"""
import contact
mesh solid = gmsh("body.msh")
part body = solid.group("body")
part left = solid.group("left")
part top = solid.group("top")
part bottom = solid.group("bottom")
part right = solid.group("right")
tensor B = isotropic(lambda = {lam!r}, mu = {mu!r})
tensor A = isotropic(lambda = {eta * lam!r}, mu = {2 * eta * mu!r})
kernel C(lag) = -{0.03 if fades else 1}*exp(-lag/{tau!r}) * B
superpotential stop(r) = unilateral(r - {size * 0.001!r})
superpotential spring(r) = {stiff / size * 0.3!r}*r^2
superpotential rub(w) = {stiff * 0.01!r}*norm(w)
{"state lost on body with rate 400*(eps(u) : eps(u)) from lost = 0.1 in [0, 0.9]" if fades else ""}
space V = vector P1 on solid, {zero}
find u in V {f"with u = {on_right} on right" if driven else ""} for t in [0, {end!r}] by {steps} steps from u = 0 using scheme = {scheme}{', hht_alpha = -0.1' if scheme == 'hht' else ''}
such that for all v in V
  {' + '.join(terms)} >= integral(body, dot([{body[0]!r}*t, {body[1]!r}], v)) + integral(top, dot([{pull[0]!r}, {pull[1]!r}*t], v))
report table {", ".join(table)} to "all.csv"
"""
    (folder / "scene.hvi").write_text(script)
    run = subprocess.run([hvi_run, str(folder / "scene.hvi"), "-o", str(folder / "out"), "--quiet"], capture_output=True, text=True)
    assert run.returncode == 0, script + run.stderr
    rows = list(csv.DictReader((folder / "out" / "all.csv").open()))
    if scheme != "backward_euler":
        return totals(rows, scheme, lambda t: load(x, cells, sides, body * np.array([t, 1]), pull * np.array([1, t])), moves, stops)
    u = np.array([[[float(r[f"n{i}_{c}"]) for c in "xy"] for i in range(len(x))] for r in rows]).reshape(len(rows), -1)
    t = np.array([float(r["t"]) for r in rows])
    if t[0] > 0:  # the initial state, at rest
        u, t, rows = np.vstack([np.zeros(u.shape[1]), u]), np.append(0.0, t), [None, *rows]
    b, a, mass_matrix = stiffness(x, cells, lam, mu), stiffness(x, cells, eta * lam, 2 * eta * mu), rho * mass(x, cells)
    worst, k = 0.0, end / steps
    rates = np.zeros_like(u)
    for i in range(1, len(t)):
        rates[i] = (u[i] - u[i - 1]) / k
        parts = [b @ u[i]]
        parts += [a @ rates[i]] if viscous else []
        parts += [mass_matrix @ (rates[i] - rates[i - 1]) / k] if moves else []
        if memory:
            w = [-tau * (math.exp(-(t[i] - t[j]) / tau) - math.exp(-(t[i] - t[j - 1]) / tau)) for j in range(1, i + 1)]
            parts += [b @ sum(weight * u[j] for weight, j in zip(w, range(1, i + 1)))]
        f = load(x, cells, sides, body * np.array([t[i], 1]), pull * np.array([1, t[i]]))
        force = sum(parts) - f
        scale = max(np.abs(p).max() for p in [*parts, f])
        row = rows[i]
        of = lambda name: np.array([float(row[f"{name}_{c}"]) for c in "xy"])
        nodes = {name: sorted({i for edge in sides[name] for i in edge}) for name in sides}
        on_left = force.reshape(-1, 2)[nodes["left"]].sum(0)
        on_right = force.reshape(-1, 2)[nodes["right"]].sum(0)
        law = of("by_law") if xi else np.zeros(2)
        if xi:  # what laws do to nodes that are held is carried by the supports: the tables know it in sums only
            worst = max(worst, np.abs(of("bottom") - law).max() / scale)
        else:
            worst = max(worst, np.abs(of("left") - on_left).max() / scale)
            if driven:
                worst = max(worst, np.abs(of("right") - on_right).max() / scale)
        together = of("left") + (of("right") if driven else 0) + (of("bottom") if xi else 0)
        total = force.reshape(-1, 2).sum(0)  # internal forces add up to nothing but inertia
        worst = max(worst, np.abs(of("all") - total).max() / scale, np.abs(together - of("all")).max() / scale)
    return worst


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("hvi_run")
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=23)
    options = parser.parse_args()
    worst = 0.0
    for i in range(options.scenes):
        rng = np.random.default_rng([options.seed, i])
        with tempfile.TemporaryDirectory() as folder:
            off = scene(rng, pathlib.Path(folder), options.hvi_run)
        assert off < 1e-9, (i, off)
        worst = max(worst, off)
    print(f"{options.scenes} scenes, worst difference {worst:.1e} of the largest nodal force")


main()
