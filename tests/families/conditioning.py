#!/usr/bin/python3
"""Forward error estimates against true errors: slender, nearly incompressible and layered bodies, turned and scaled.

usage: conditioning.py HVI_RUN [--scenes N] [--seed S] [--only N,N,..] [--keep FOLDER] [--verbose]

Two kinds of scenes:
  bending  pure bending of a beam (plane strain or 3D), exact in P2: the solution is known in closed form (analytic);
  discrete random bodies of triangles or tetrahedra (P1) with one to three materials, static or over a few steps of backward
           Euler with viscosity: the same discrete problem is assembled and solved here in 80-bit arithmetic, dense, by Gauss
           elimination with refinement (an independent program; nothing of hvi-run is used but the mesh file both read).
The bounds: a certified run states for each column an error that is at most 10 times below the true one (else: wrong), and
for the scene's most moved column at most 1,000 times above the true one, where errors below a few units in the last place
count as these. Where entries of the matrix happen to be exact in binary (regular meshes of round lengths) the true error is
by luck far below what is usual: a scene that states too much is compared with the largest true error of itself and of six
neighbours, whose lengths and moduli differ by about 1e-3. A certified scene whose true error is above a tenth is wrong whatever it states. The scenes go on purpose to
where double precision ends: refusals have a reason where the true condition number times the unit in the last place is above
1e-4 (bending: L above 100 or Poisson's ratio above 0.4998); one without a reason fails the family, and so do refusals of
more than 45 % of the scenes.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

LD = np.longdouble
EPS = float(np.finfo(float).eps)


def solve_ld(k, rhs):
    """k x = rhs in 80-bit arithmetic: elimination without pivoting (k is coercive, scaled before), refined twice."""
    n = len(k)
    s = 1 / np.sqrt(np.abs(np.diag(k)))
    a = k * s[:, None] * s[None, :]
    lu = a.copy()
    for j in range(n - 1):
        lu[j + 1:, j] /= lu[j, j]
        lu[j + 1:, j + 1:] -= np.outer(lu[j + 1:, j], lu[j, j + 1:])

    def sweep(b):
        x = b.copy()
        for j in range(n):
            x[j + 1:] -= lu[j + 1:, j] * x[j]
        for j in range(n - 1, -1, -1):
            x[j] /= lu[j, j]
            x[:j] -= lu[:j, j] * x[j]
        return x

    def solve(b):
        b = b * s
        x = sweep(b)
        for _ in range(2):
            x += sweep(b - a @ x)
        return x * s

    return solve(rhs) if rhs is not None else solve


def grid_mesh(dim, cells, lengths, rng, jitter):
    """Nodes and simplices of a box; inner nodes are moved by a part of their cell."""
    counts = [c + 1 for c in cells]
    index = np.indices(counts).reshape(dim, -1).T
    nodes = index / np.array(cells) * np.array(lengths)
    inner = np.all((index > 0) & (index < np.array(cells)), axis=1)
    nodes[inner] += (rng.random((inner.sum(), dim)) - 0.5) * jitter * np.array(lengths) / np.array(cells)
    def at(i):
        return int(np.ravel_multi_index(i, counts))
    simplices = []
    for cell in np.ndindex(*cells):
        if dim == 2:
            a, b, c, d = (at((cell[0] + i, cell[1] + j)) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
            simplices += [[a, b, c], [a, c, d]]
        else:  # Kuhn: one simplex for each order of the axes
            for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
                corner, path = list(cell), [at(tuple(cell))]
                for axis in order:
                    corner[axis] += 1
                    path.append(at(tuple(corner)))
                simplices.append(path)
    return nodes, index, simplices


def turn(nodes, dim, rng):
    q, _ = np.linalg.qr(rng.normal(size=(dim, dim)))
    if np.linalg.det(q) < 0:
        q[:, 0] *= -1
    return nodes @ q.T, q


def write_msh(path, dim, nodes, groups):
    """groups: name -> (dimension, list of node lists)"""
    out = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    out += [f'{d} {i + 1} "{name}"' for i, (name, (d, _)) in enumerate(groups.items())]
    out += ["$EndPhysicalNames", "$Nodes", str(len(nodes))]
    for i, x in enumerate(nodes):
        out.append(" ".join([str(i + 1)] + [repr(float(v)) for v in list(x) + [0.0] * (3 - dim)]))
    elements = [(d, i + 1, e) for i, (d, es) in enumerate(groups.values()) for e in es]
    out += ["$EndNodes", "$Elements", str(len(elements))]
    kind = {1: 1, 2: 2, 3: 4}
    for i, (d, tag, e) in enumerate(elements):
        out.append(" ".join(map(str, [i + 1, kind[d], 2, tag, tag] + [n + 1 for n in e])))
    out += ["$EndElements", ""]
    path.write_text("\n".join(out))


def gradients(x):
    """Gradients of the barycentric coordinates (vertices by components) and the signed measure times dim!."""
    edges = x[1:] - x[0]
    dim = len(edges)
    if dim == 2:
        det = edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0]
        inverse = np.array([[edges[1, 1], -edges[0, 1]], [-edges[1, 0], edges[0, 0]]], dtype=LD) / det
    else:
        cofactor = np.array([np.cross(edges[1], edges[2]), np.cross(edges[2], edges[0]), np.cross(edges[0], edges[1])],
                            dtype=LD).T
        det = edges[0] @ cofactor[:, 0]
        inverse = cofactor / det
    g = inverse.T  # rows: gradients of the coordinates 1..dim
    return np.vstack([-g.sum(axis=0), g]), det


def stiffness(nodes, simplices, material, dim):
    """K of isotropic tensors (young, poisson), 80 bits; `material`: by simplex."""
    n = len(nodes) * dim
    k = np.zeros((n, n), dtype=LD)
    x = nodes.astype(LD)
    for e, (young, poisson) in zip(simplices, material):
        young, poisson = LD(young), LD(poisson)
        lam = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
        mu = young / (2 * (1 + poisson))
        g, det = gradients(x[e])
        volume = abs(det) / math.factorial(dim)
        gg = g @ g.T
        block = lam * np.einsum("ai,bj->aibj", g, g) + mu * np.einsum("aj,bi->aibj", g, g)
        for i in range(dim):
            block[:, i, :, i] += mu * gg
        dofs = [v * dim + c for v in e for c in range(dim)]
        k[np.ix_(dofs, dofs)] += volume * block.reshape(len(dofs), len(dofs))
    return k


def measure(nodes, simplices, dim):
    """Integrals of the shape functions and the mass matrix of scalar P1."""
    n = len(nodes)
    weight, mass = np.zeros(n, dtype=LD), np.zeros((n, n), dtype=LD)
    x = nodes.astype(LD)
    for e in simplices:
        volume = abs(gradients(x[e])[1]) / math.factorial(dim)
        weight[e] += volume / (dim + 1)
        mass[np.ix_(e, e)] += volume / ((dim + 1) * (dim + 2)) * (np.ones((dim + 1, dim + 1), dtype=LD) + np.eye(dim + 1, dtype=LD))
    return weight, mass


def number(v):
    return repr(float(v))


def bending(rng, folder, near):
    """Pure bending with the axis in the middle, of a bar (u_x = k x y, u_y = -k (x^2 + nu (y^2 - z^2)) / 2, u_z = -nu k y z)
    or of a plate in plane strain (nu / (1 - nu) y^2 instead); closed form."""
    solid = rng.random() < 0.3
    length = float(round(10 ** rng.uniform(1, 3.3 if solid else 3.7))) * near()
    poisson = float(rng.choice([0.0, 0.2, 0.3, 0.45, 0.4999, 0.499999, 0.4999999]))
    cells = [int(rng.choice([4, 8])), 1, 1] if solid else [int(rng.choice([8, 16, 32])), int(rng.choice([1, 2, 4]))]
    steps = int(rng.choice([1, 5, 40, 200]))
    young = 10.0 ** rng.integers(-3, 6) * near()
    kappa = 1.0 / length ** 2
    modulus = young if solid else young / (1 - poisson ** 2)
    ratio = poisson if solid else poisson / (1 - poisson)
    if solid:
        mesh = f"box({number(length)}, 1, 1, cells = {cells})"
        held = f"[0, -{number(ratio * kappa / 2)}*((y-0.5)^2 - (z-0.5)^2)*t, -{number(ratio * kappa)}*(y-0.5)*(z-0.5)*t]"
        more = ", 0.5"
    else:
        mesh = f"rectangle({number(length)}, 1, cells = {cells})"
        held, more = f"[0, -{number(ratio * kappa / 2)}*(y-0.5)^2*t]", ""
    text = f"""mesh b = {mesh}
part w = b.left
part e = b.right
tensor B = isotropic(young = {number(young)}, poisson = {number(poisson)})
tensor A = isotropic(young = {number(young / 10)}, poisson = {number(poisson)})
space V = vector P2 on b, zero on w
find u in V with u = {held} on w for t in [0,1] by {steps} steps from u = 0 such that for all v in V
  integral(b, A : eps(u') : eps(v)) + integral(b, B : eps(u) : eps(v)) = integral(e, {number(modulus * kappa)}*(t+0.1)*(y-0.5)*v.x)
report table tip = u.y at [{number(length)}, 0.5{more}], mean = integral(b, u.y), corner = u.x at [{number(length)}, 1{more}]
"""
    lx, k, poisson_ld = LD(length), LD(kappa), LD(poisson)
    of_mean = LD(0) if solid else poisson_ld / (1 - poisson_ld) / 12
    true = {"tip": -k * lx ** 2 / 2, "mean": -k * (lx ** 3 / 3 + of_mean * lx) / 2, "corner": k * lx / 2}
    what = f"bending {'3D' if solid else '2D'} L {length:g} nu {poisson} cells {cells} steps {steps}"
    return text, {name: float(v) for name, v in true.items()}, what, 0.0, length > 100 or poisson > 0.4998


def discrete(rng, folder, near):
    dim = 2 if rng.random() < 0.7 else 3
    cells = [int(rng.integers(3, 13)), int(rng.integers(1, 4))] if dim == 2 else [int(rng.integers(2, 7)), 1, 1]
    slender = 10 ** rng.uniform(0, 3.2 if dim == 2 else 2.5) * near()
    scale = 10.0 ** rng.integers(-3, 4) * near()
    lengths = [slender * scale] + [scale] * (dim - 1)
    nodes, index, simplices = grid_mesh(dim, cells, lengths, rng, rng.choice([0.0, 0.4]))
    nodes = nodes + rng.choice([0.0, 1.0]) * scale * rng.normal(size=dim)
    turned = rng.random() < 0.6
    if turned:
        nodes, _ = turn(nodes, dim, rng)
    n_materials = min(int(rng.choice([1, 1, 2, 3])), cells[0])
    contrast = 10 ** rng.uniform(0, 12)
    materials = []
    for m in range(n_materials):
        young = 10.0 ** rng.integers(-2, 5) * (contrast if m == 1 else 1.0) * near()
        poisson = float(rng.choice([0.0, 0.3, 0.45, 0.5 - 10 ** rng.uniform(-6.5, -2)]))
        materials.append((float(young), poisson))
    column = [min(index[v][0] for v in e) * n_materials // cells[0] for e in simplices]
    of = [materials[c] for c in column]
    # groups
    left = [i for i in range(len(nodes)) if index[i][0] == 0]
    right_facets, left_facets = [], []
    for e in simplices:
        for skip in range(dim + 1):
            facet = [v for j, v in enumerate(e) if j != skip]
            if all(index[v][0] == 0 for v in facet):
                left_facets.append(facet)
            if all(index[v][0] == cells[0] for v in facet):
                right_facets.append(facet)
    groups = {"left": (dim - 1, left_facets), "right": (dim - 1, right_facets)}
    for m in range(n_materials):
        groups[f"m{m}"] = (dim, [e for e, c in zip(simplices, column) if c == m])
    write_msh(folder / "body.msh", dim, nodes, groups)
    # the load: a constant force on the body and a moment-free end traction, growing in time
    f = rng.normal(size=dim)
    q = rng.normal(size=dim)
    steps = int(rng.choice([0, 1, 4, 16, 300]))
    a = 10.0 ** rng.integers(-3, 3)
    probe = int(np.argmax(index[:, 0] * 1000 + index[:, 1]))
    at = "[" + ", ".join(number(v) for v in nodes[probe]) + "]"
    forms = [f"integral(m{m}, B{m} : eps(u) : eps(v))" for m in range(n_materials)]
    if steps:
        forms += [f"integral(m{m}, A{m} : eps(u') : eps(v))" for m in range(n_materials)]
    time = f"for t in [0,1] by {steps} steps from u = 0" if steps else ""
    grow = "*(0.25 + t)" if steps else ""
    vector = lambda v: "[" + ", ".join(number(c) + grow for c in v) + "]"
    text = "mesh b = gmsh(\"body.msh\")\n"
    text += "part left = b.group(\"left\")\npart right = b.group(\"right\")\n"
    text += "".join(f"part m{m} = b.group(\"m{m}\")\n" for m in range(n_materials))
    for m, (young, poisson) in enumerate(materials):
        text += f"tensor B{m} = isotropic(young = {number(young)}, poisson = {number(poisson)})\n"
        if steps:
            text += f"tensor A{m} = isotropic(young = {number(a * young)}, poisson = 0.25)\n"
    text += f"""space V = vector P1 on b, zero on left
find u in V {time} such that for all v in V
  {" + ".join(forms)} = integral(b, dot({vector(f)}, v)) + integral(right, dot({vector(q)}, v))
report table ux = u.x at {at}, uy = u.y at {at}, mean = integral(b, u.x + 2*u.y), square = integral(b, u.y*u.y)
"""
    # the same in 80 bits
    kb = stiffness(nodes, simplices, of, dim)
    weight, mass = measure(nodes, simplices, dim)
    load = np.zeros(len(nodes) * dim, dtype=LD)
    for c in range(dim):
        load[c::dim] += LD(f[c]) * weight
    x = nodes.astype(LD)
    for facet in right_facets:
        edges = x[facet[1:]] - x[facet[0]]
        area = np.sqrt(edges[0] @ edges[0]) if dim == 2 else np.sqrt(np.sum(np.cross(edges[0], edges[1]) ** 2)) / 2
        for v in facet:
            for c in range(dim):
                load[v * dim + c] += LD(q[c]) * area / dim
    free = np.array([i * dim + c for i in range(len(nodes)) for c in range(dim) if i not in set(left)])
    kb = kb[np.ix_(free, free)]
    u = np.zeros(len(free), dtype=LD)
    if steps:
        step = LD(1) / steps
        ka = stiffness(nodes, simplices, [(LD(float(a * y)), 0.25) for y, _ in of], dim)[np.ix_(free, free)] / step
        solve = solve_ld(ka + kb, None)
        for n in range(1, steps + 1):
            u = u + solve(load[free] * (LD(0.25) + n * step) - kb @ u)
        k = ka + kb
    else:
        k = kb
        u = solve_ld(k, load[free])
    full = np.zeros(len(nodes) * dim, dtype=LD)
    full[free] = u
    ux, uy = full[0::dim], full[1::dim]
    true = {"ux": ux[probe], "uy": uy[probe], "mean": weight @ (ux + 2 * uy), "square": uy @ (mass @ uy)}
    what = (f"discrete {dim}D cells {cells} slender {slender:.3g} scale {scale:g} turned {turned} materials "
            f"{[(f'{y:.1e}', f'{p:.8g}') for y, p in materials]} steps {steps}")
    condition = float(np.linalg.cond(k.astype(float) , 1)) if len(k) < 400 else 0.0
    return text, {name: float(v) for name, v in true.items()}, what, condition


def judge(out, true):
    """(largest true / stated, stated / true of the scene, largest true, largest stated)"""
    stated, final = out["forward_error"]["columns"], out["final"]
    worst_below, largest_stated, largest_true = 0.0, 0.0, 0.0
    for name, exact in true.items():
        value, estimate = final[name], stated[name]["absolute"]
        size = max(abs(exact), abs(value), 1e-300)
        floor = estimate / max(stated[name]["relative"], 1e-300)  # what the column is judged by
        error = abs(value - exact)
        if error > 8 * EPS * max(size, floor):
            worst_below = max(worst_below, error / estimate)
        largest_stated = max(largest_stated, stated[name]["relative"])
        largest_true = max(largest_true, error / max(size, floor))
    above = largest_stated / max(largest_true, 4 * EPS)
    return worst_below, above, largest_true, largest_stated


def run(program, folder, text):
    """(finished process, its JSON)"""
    script, result = folder / "scene.hvi", folder / "out.json"
    script.write_text(text)
    done = subprocess.run([program, "run", str(script), "--quiet", "--no-files", "--json", str(result)], capture_output=True,
                          text=True, timeout=300)
    return done, json.loads(result.read_text()) if done.returncode == 0 else None


def make(seed, scene, folder, near=lambda: 1.0):
    rng = np.random.default_rng([seed, scene])
    return (bending if scene % 3 == 0 else discrete)(rng, folder, near)


def neighbours_error(program, seed, scene, folder):
    """The largest true error of six neighbours."""
    rng = np.random.default_rng([seed, scene, 1])
    largest = 0.0
    for _ in range(6):
        text, true = make(seed, scene, folder, lambda: 1 + 1e-3 * rng.uniform(-1, 1))[:2]
        done, out = run(program, folder, text)
        if out:
            largest = max(largest, judge(out, true)[2])
    return largest


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("hvi_run")
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=lambda s: [int(n) for n in s.split(",")], help="scenes by their numbers")
    parser.add_argument("--keep")
    parser.add_argument("--verbose", action="store_true")
    args = parser.parse_args()
    certified = wrong = refused = unfounded = 0
    below, above = [], []
    asked = args.only or range(args.scenes)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(args.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for scene in asked:
            made = make(args.seed, scene, folder)
            text, true, what = made[:3]
            done, out = run(args.hvi_run, folder, text)
            if done.returncode == 3:
                refused += 1
                condition = made[3]
                founded = condition * EPS > 1e-4 if condition else made[4]
                unfounded += not founded
                if args.verbose or not founded:
                    print(f"{scene}: refused{'' if founded else ' WITHOUT REASON'}: {what} (condition {condition:.1e})\n"
                          f"   {[line for line in done.stderr.splitlines() if line.startswith('error')][:1]}")
                continue
            if done.returncode != 0:
                print(f"{scene}: exit {done.returncode}: {what}\n{done.stderr}")
                wrong += 1
                continue
            b, a, error, stated = judge(out, true)
            if a > 1e3:
                a = stated / max(error, neighbours_error(args.hvi_run, args.seed, scene, folder), 4 * EPS)
            certified += 1
            below.append(b)
            above.append(a)
            bad = b > 10 or a > 1e3 or error > 0.1
            wrong += bad
            if bad or args.verbose:
                print(f"{scene}: {'WRONG ' if bad else ''}true/stated {b:.2g}, stated/true {a:.2g}, true {error:.1e}, stated "
                      f"{stated:.1e}, refined {out['forward_error']['refined']}: {what}")
            if bad and args.keep:
                (folder / f"bad{scene}.hvi").write_text(text)
    if below:
        print(f"true / stated at most {max(below):.2g}; stated / true: median {np.median(above):.3g}, at most {max(above):.3g}")
    print(f"refused without reason: {unfounded}")
    print(f"family conditioning: scenes {len(asked)}, certified {certified}, wrong {wrong}, refused {refused}")
    sys.exit(1 if wrong or unfounded or refused > 0.45 * len(asked) else 0)


if __name__ == "__main__":
    main()
