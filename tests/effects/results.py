#!/usr/bin/env python3
"""results.py HVI_RUN EXAMPLES: what reports ask for, against values from elsewhere.

- Reactions of all examples: the force on all that is held, against the inequality itself with a constant as test function.
- Reactions in motion: against the rate of the momentum, of every scheme.
- largest, smallest: against values at the points where they are taken.
- mises: in plane strain against a slice of a body in space, by several tensors, and against its formula.
- line: against columns of a table at the same places.
- The sweep of a parameter, against runs one by one; plots and pictures are there.
"""
import base64
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import zlib

import meshio
import numpy as np

HVI_RUN, EXAMPLES = sys.argv[1], pathlib.Path(sys.argv[2])


def run(folder, text, *options, name="scene", command="run"):
    (folder / f"{name}.hvi").write_text(text)
    done = subprocess.run([HVI_RUN, command, str(folder / f"{name}.hvi"), "-o", str(folder / "out"), "--quiet", *options],
                          capture_output=True, text=True)
    assert done.returncode == 0, f"{text}\n{done.stderr}"
    return done.stdout


def rows(folder, name="scene"):
    return [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader((folder / "out" / f"{name}.csv").open())]


# --- examples ----------------------------------------------------------------------------------

# Small enough for a test; the terms do not care.
SMALLER = {"bracket": ["size=2"], "slab3d_friction": ["n=2", "N=4"], "joint": ["N=16"], "seal": ["size=0.1"], "ball_on_block": ["m=16", "fine=0.01"],
           "brake": ["N=10"], "lap_joint": ["N=12"], "damage": ["N=8"], "consolidation": ["N=10"], "cantilever": ["N=10"], "disc_brake": ["N=4"], "sphere": ["fine=0.02"], "laminate": ["N=5"]}
LEFT_OUT = {"bounce": "its momentum is that of a mass moved off the contact: check_motion"}


def closing(text, at):
    depth = 0
    for i in range(at, len(text)):
        depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(text[i], 0)
        if depth == 0:
            return i
    raise ValueError(text[at:])


def terms_of(form):
    """(sign and factor, part, integrand) of every integral of a form."""
    out, last = [], 0
    for match in re.finditer(r"\bintegral\(", form):
        if match.start() < last:
            continue
        end = closing(form, match.end() - 1)
        inside, factor = form[match.end():end], form[last:match.start()].strip()
        last = end + 1
        comma = inside.index(",")
        integrand = inside[comma + 1:]
        rule = re.search(r",\s*rule\s*=\s*\w+\s*$", integrand)
        out.append((factor, inside[:comma].strip(), integrand[:rule.start()] if rule else integrand, rule[0] if rule else ""))
    return out


def top_level_summands(text):
    depth, start, out = 0, 0, []
    for i, c in enumerate(text):
        depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(c, 0)
        if depth == 0 and c in "+-" and text[start:i].strip() and text[:i].rstrip()[-1] not in "*/^(,":
            out.append(text[start:i])
            start = i
    return [*out, text[start:]]


def balance_columns(text):
    """Columns `balance_c`: the form with v = e_c and without laws; what holds the body; and a size of its forces, the mean
    stress times a section, since loads and reactions may add up to zero by symmetry."""
    code = re.sub(r"#.*", "", text)
    find = re.search(r"\bfind\b.*?(?=\n\s*(?:report|expect|study|param|fn|part|tensor|kernel|superpotential|space|mesh|state|import)\b|\Z)",
                     code, re.S)[0]
    unknowns = re.findall(r"(\w+)(?: \[[^\]]*\])? in (\w+)", re.split(r"\bfor\b|\bwith\b|\busing\b|\bsuch\b", find, maxsplit=1)[0])
    tests = re.findall(r"(\w+) in \w+", re.search(r"for all ((?:\w+ in \w+(?:,\s*)?)+)", find)[1])
    kinds = {name: kind for name, kind in re.findall(r"space\s+(\w+)\s*=\s*(scalar|vector)", code)}
    unknown = next((i for i, (_, space) in enumerate(unknowns) if kinds[space] == "vector"), 0)
    vector = kinds[unknowns[unknown][1]] == "vector"
    mesh = re.search(rf"space\s+{unknowns[unknown][1]}\s*=\s*\w+\s+\w+\s+on\s+(\w+)", code)[1]
    form = find[re.search(r"for all (?:\w+ in \w+(?:,\s*)?)+", find).end():]
    left, right = re.split(r">=|(?<![<>=!^])=(?!=)(?![^()]*\))", form, maxsplit=1)
    first = re.search(r"\bmesh\s+\w+\s*=.*?(?=\n\s*\w+\s+\w+\s*[=(])", code, re.S)[0]
    dim = 3 if re.search(r"\bbox\(|bracket|ball\(|cylinder\(", first) or "zero.z" in code else 1 if "interval(" in first else 2
    zero = lambda n: "[" + ", ".join("0" for _ in range(n)) + "]"
    columns = []
    # The unit vector along the radius is no test function of a body of revolution: on the axis these are zero.
    for c in range(1 if "axisymmetric" in code and vector else 0, dim if vector else 1):
        unit = "[" + ", ".join("1" if i == c else "0" for i in range(dim)) + "]" if vector else "1"
        sum_of = []
        for side, sign in ((left, "+"), (right, "-")):
            for factor, part, integrand, rule in terms_of(side):
                for summand in top_level_summands(integrand):
                    if "^0(" in summand:
                        continue
                    for i, (test, (_, space)) in enumerate(zip(tests, unknowns)):
                        other = zero(dim) if kinds[space] == "vector" else "0"
                        summand = re.sub(rf"\b{test}\b(?!\s*\()", unit if i == unknown else other, summand)
                    summand = re.sub(r"\bmean\(0\)", "0", summand)
                    summand = re.sub(r"\[([0, 1]+)\]\.([xyz])", lambda m: m[1].split(", ")["xyz".index(m[2])], summand)
                    summand = re.sub(r"\[([0, 1]+)\]\.nu", lambda m: f"dot([{m[1]}], normal)", summand)
                    own = factor.lstrip("+").strip()
                    negative = own.startswith("-")
                    own = own.lstrip("-").strip().rstrip("*").strip()
                    sign_of = sign if not negative else {"+": "-", "-": "+"}[sign]
                    sum_of.append(f"{sign_of} {own + ' * ' if own else ''}integral({part}, {summand.strip().lstrip('+')}{rule})")
        columns.append(f"balance_{'xyz'[c]} = 0 {' '.join(sum_of)}")
    columns.append(f"forces = integral({mesh}, norm(sigma))/integral({mesh}, 1)^(1/{dim})")
    return columns, f"all = reaction({mesh}{', ' + unknowns[unknown][0] if len(unknowns) > 1 else ''})", vector


def check_examples():
    worst, n = 0.0, 0
    for path in sorted(EXAMPLES.glob("*.hvi")):
        if path.stem in LEFT_OUT:
            continue
        text = path.read_text()
        columns, of_all, vector = balance_columns(text)
        by_parts = []
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            for other in [*EXAMPLES.glob("*.msh"), *EXAMPLES.glob("*.csv")]:
                (folder / other.name).write_bytes(other.read_bytes())
            body = re.sub(r"(?m)^\s*(expect|study)\b.*$", "", text)
            body = re.sub(r"(?s)\breport\b.*?(?=\n(?:fn|param|part|find)\b|\Z)", "", body)
            defines = [f for d in SMALLER.get(path.stem, []) for f in ("-D", d)]
            run(folder, f"{body}\nreport table {', '.join([*columns, of_all])}\n", *defines, name=path.stem)
            table = rows(folder, path.stem)
            size = max(abs(v) for row in table for k, v in row.items() if k not in ("t", "event"))
            assert size > 0, path.stem
            for row in table:
                for c in "xyz":
                    if f"balance_{c}" not in row:
                        continue
                    reaction = row[f"all_{c}"] if vector else row["all"]
                    off = abs(reaction - row[f"balance_{c}"]) / size
                    worst = max(worst, off)
                    assert off < 1e-10, (path.stem, off, row)
        n += 1
    print(f"{n} examples: reactions and loads differ by {worst:.1e} of the largest force of the run")


def momenta(points, cells, massless, rho):
    """Weights m with sum_i m_i v_i the momentum of velocities v: the integral of rho P v, P as solver/discrete/inertia.hpp says, P1 in the plane. At nodes
    without mass P is the shortest combination of the others around that is exact for affine functions."""
    mass, around = np.zeros(len(points)), [set() for _ in points]
    for cell in cells:
        a, b, c = points[list(cell)]
        area = abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) / 2
        for i in cell:
            mass[i] += rho * area / 3
            around[i] |= set(cell)
    out = np.where(massless, 0.0, mass)
    for i in np.flatnonzero(massless):
        ring = {i}
        while True:
            ring = set().union(*(around[j] for j in ring))
            others = sorted(j for j in ring if not massless[j])
            rows = np.vstack([np.ones(len(others)), (points[others] - points[i]).T])
            if np.linalg.matrix_rank(rows) == 3:
                break
        out[others] += mass[i] * np.linalg.lstsq(rows, np.array([1.0, 0, 0]), rcond=None)[0]  # of least norm
    return out


def check_motion(folder):
    """Reactions and loads are the rate of the momentum as the scheme has it: the mass times u'' at the end of a step, and with `midpoint` the
    difference of momenta at both ends, whose mean is that of u' = d_n/k, of the mass that is moved off the contact. The load goes where the mass is:
    on a block of two cells across, held above, some of it to the side that is held."""
    text = re.sub(r"(?s)\nreport\n.*", "\n", (EXAMPLES / "bounce.hvi").read_text())
    n, N, weight, rho = 3, 60, -2 * 9.81 * 2, 2
    sums = ", ".join(["table r = reaction(block)", *(f"{k}{c} = integral(block, {rho}*{of}.{c})" for k, of in (("p", "u'"), ("a", "u''")) for c in "xy")])
    for scheme in ("newmark", "hht", "bdf2", "backward_euler"):
        run(folder, f"{text.replace('midpoint', scheme)}report {sums}\n", "-D", f"n={n}", "-D", f"N={N}")
        table = rows(folder)
        size = max(abs(row["r_y"]) for row in table)
        assert size > 10 and max(abs(row["ax"]) for row in table) > 1
        for row in table:
            assert max(abs(row["ax"] - row["r_x"]), abs(row["ay"] - row["r_y"] - weight)) < 1e-10 * size, (scheme, row)

    soft = text.replace("unilateral^0", "spring^0").replace("space V", "superpotential spring(r) = 2000*pos(r)^2\nspace V")
    held = re.sub("u' = .*", "u' = 0", re.sub(r"(space V .*)", r"part roof = block.top\n\1, zero on roof", text)).replace("u.nu - 0.1;", "u.nu - 0.001;")
    for script, n, lost, start in ((text, 3, True, (2.0, -4.0)), (soft, 3, False, (2.0, -4.0)), (held, 2, True, (0.0, 0.0))):
        check_midpoint(folder, f"{script}report\n  {sums}", n, N, lost, start, weight, rho)


def check_midpoint(folder, script, n, N, lost, start, weight, rho):
    places = [(i / n, j / n) for j in range(n + 1) for i in range(2 * n + 1)]
    columns = ", ".join(f"v{k} = u'.{c} at [{x!r}, {y!r}]".replace("v", f"v{c}", 1) for k, (x, y) in enumerate(places) for c in "xy")
    run(folder, f"{script}, {columns}\n  fields u every {N} steps to \"mesh.vtu\"\n", "-D", f"n={n}", "-D", f"N={N}")
    grid = meshio.read(next((folder / "out").glob("mesh*.vtu")))
    points, cells = grid.points[:, :2], grid.cells[0].data
    order = [int(np.argmin(np.abs(points - place).sum(axis=1))) for place in places]
    weights = momenta(points, cells, (points[:, 1] == 0) if lost else np.zeros(len(points), bool), rho)[order]
    table = rows(folder)
    size, k = max(abs(row["r_y"]) for row in table), 0.6 / N
    before, worst = start, 0.0
    for row in table:
        means = [sum(w * row[f"v{c}{i}"] for i, w in enumerate(weights)) for c in "xy"]
        now = [2 * mean - last for mean, last in zip(means, before)]
        for j, c in enumerate("xy"):
            worst = max(worst, abs((now[j] - before[j]) / k - row[f"r_{c}"] - (0, weight)[j]))
            assert lost or abs(means[j] - row[f"p{c}"]) < 1e-12 * max(map(abs, means))
        before = now
    assert size > 10 and worst < 1e-10 * size, (script, worst, size)


def check_pairs(folder):
    """Action and reaction on a pair: on its first side, on its second one, on all that a piece is held by; laws on jumps, and what brings heat to both."""
    text = """
mesh lower = rectangle(2, 1, cells = [4, 2])
mesh upper = rectangle(2, 1, cells = [3, 2], at = [0, 1])
mesh both  = lower + upper
part floor = lower.bottom
part roof  = upper.top
part seam  = pair(upper.bottom, lower.top)
part foot  = upper.bottom
part head  = lower.top
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential glue(w) = 40*norm(w)^2
space V = vector P1 on both, zero on floor
space W = scalar P1 on both, zero on roof, zero on floor
find u in V, theta in W such that for all v in V, eta in W
    integral(lower, B : eps(u) : eps(v)) + integral(upper, B : eps(u) : eps(v))
  + integral(lower, dot(grad(theta), grad(eta))) + integral(upper, dot(grad(theta), grad(eta)))
  + integral(seam, glue^0(jump(u); jump(v))) - integral(seam, dot(glue.xi, jump(u))*mean(eta))
 >= integral(upper, dot([1, -2], v)) + integral(lower, 5*eta)
report
  table on = reaction(seam), first = reaction(foot), second = reaction(head), held = reaction(upper), base = reaction(floor),
    gx = integral(seam, glue.xi.x), gy = integral(seam, glue.xi.y), heat = integral(seam, dot(glue.xi, jump(u))),
    q = reaction(seam, theta), q1 = reaction(foot, theta), q2 = reaction(head, theta)
"""
    run(folder, text)
    row, = rows(folder)
    for c, load in (("x", 2.0), ("y", -4.0)):  # the upper block hangs on the seam alone, the floor carries all
        for name, wanted in (("on", -load), ("first", -load), ("second", load), ("held", -load), ("base", -load)):
            close(row[f"{name}_{c}"], wanted, 1e-11, 4.0)
        close(row[f"g{c}"], load, 1e-11, 4.0)
    for name, share in (("q", 0.5), ("q1", 0.5), ("q2", 0.5)):  # half of the heat on either side; of a pair that of its first
        close(row[name], share*row["heat"], 1e-9)
    assert abs(row["heat"]) > 0.1


# --- values --------------------------------------------------------------------------------------

PLATE = """
mesh plate  = rectangle(1, 1, cells = [4, 3])
part wall   = plate.left
part ground = plate.bottom
part tip    = plate.right
tensor B = {tensor}
kernel C(lag) = -0.5*exp(-lag) * B
superpotential layer(r) = 30*pos(r)^2
space V = vector {element} on plate, zero on wall
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
  integral(plate, B : eps(u) : eps(v)) + integral(plate, 0.3*B : eps(u') : eps(v)) + integral(plate, history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu)) >= integral(tip, dot([sin(2*t), -3*t], v))
report {report}
"""
ISOTROPIC = "isotropic(young = 70, poisson = 0.3)"


def close(a, b, tolerance=1e-12, size=None):
    assert abs(a - b) <= tolerance * (size or max(abs(a), abs(b), 1e-300)), (a, b)


def check_extremes(folder):
    nodes = [(i / 4, j / 3) for j in range(4) for i in range(5)]
    centres = [((3 * i + k) / 12, (3 * j + k) / 9) for j in range(3) for i in range(4) for k in (1, 2)] + \
              [((3 * i + 3 - k) / 12, (3 * j + k) / 9) for j in range(3) for i in range(4) for k in (1, 2)]
    columns = [f"u{i} = u.y at [{x!r}, {y!r}]" for i, (x, y) in enumerate(nodes)]
    columns += [f"s{i} = sigma.xy at [{x!r}, {y!r}]" for i, (x, y) in enumerate(centres)]
    columns += [f"xi{i} = layer.xi at [{i / 4!r}, 0]" for i in range(5)]
    columns += [f"{name} = {name}(plate, {of})".replace(f"{name} =", f"{name}_{k} =") for name in ("largest", "smallest")
                for k, of in (("u", "u.y"), ("s", "sigma.xy"))]
    columns += ["most = largest(ground, layer.xi)", "least = smallest(ground, layer.xi)", "on_side = largest(tip, u.y*normal.x)"]
    run(folder, PLATE.format(tensor=ISOTROPIC, element="P1", report="table " + ", ".join(columns)))
    for row in rows(folder):
        for kind, count, suffix in (("u", len(nodes), "u"), ("s", len(centres), "s")):
            values = [row[f"{kind}{i}"] for i in range(count)]
            close(row[f"largest_{suffix}"], max(values), 1e-9, max(map(abs, values)))
            close(row[f"smallest_{suffix}"], min(values), 1e-9, max(map(abs, values)))
        multipliers = [row[f"xi{i}"] for i in range(5)]
        close(row["most"], max(multipliers))
        close(row["least"], min(multipliers))
        close(row["on_side"], max(row[f"u{i}"] for i, (x, _) in enumerate(nodes) if x == 1))


TRANSVERSE = "E1 = 90, E2 = 20, nu12 = 0.25, nu23 = 0.3, G12 = 12"
OBLIQUE = (f"transverse({TRANSVERSE}, axis = [1, 0, 1])", f"transverse({TRANSVERSE}, axis = [1, 2, -3])",
           f"2*{ISOTROPIC} + transverse({TRANSVERSE}, axis = [1, 2, 3])")


def check_mises(folder):
    """A slice in space, held between two planes, has the stresses of plane strain: with P1 where u is affine."""
    affine = "[0.01*x + 0.004*y, -0.003*x + 0.006*y]"
    in_space = "[0.01*x + 0.004*y, -0.003*x + 0.006*y, 0]"
    of_strain, of_stress = "history(C, eps(u))", "history(q, B : eps(u))"
    for tensor, memory in ((ISOTROPIC, of_strain), (ISOTROPIC, of_stress),
                           ("orthotropic(E1 = 70, E2 = 30, E3 = 10, nu12 = 0.3, nu23 = 0.2, nu13 = 0.1, G12 = 9, G23 = 8, G13 = 7)", of_strain),
                           ("transverse(E1 = 90, E2 = 20, nu12 = 0.25, nu23 = 0.3, G12 = 12, axis = [1, 2, 0])", of_stress),
                           (f"2*{ISOTROPIC} + isotropic(lambda = 3, mu = 1)", of_strain),
                           *((oblique, memory) for oblique in OBLIQUE for memory in (of_strain, of_stress))):
        found = []
        for mesh, edge, value, at in (("rectangle(1, 1, cells = [2, 2])", "body.boundary", affine, "[0.4, 0.3]"),
                                      ("box(1, 1, 1, cells = [2, 2, 2])", "body.boundary", in_space, "[0.4, 0.3, 0.45]")):
            text = f"""
mesh body = {mesh}
part edge = {edge}
tensor B = {tensor}
kernel C(lag) = -0.5*exp(-lag) * B
kernel q(lag) = -0.5*exp(-lag)
fn pushed() = {value}
space V = vector P1 on body, zero on edge
find u in V with u = t*pushed() on edge for t in [0, 1] by 3 steps from u = 0
such that for all v in V
  integral(body, B : eps(u) : eps(v)) + integral(body, 2*(B : eps(u')) : eps(v)) + integral(body, {memory} : eps(v)) = 0
report table m = mises(sigma) at {at}, zz = sigma.zz at {at}, xx = sigma.xx at {at}, yy = sigma.yy at {at}, xy = sigma.xy at {at}
"""
            run(folder, text)
            found.append(rows(folder)[-1])
        plane, space = found
        for name in plane:
            close(plane[name], space[name], 1e-10, space["m"] if name != "t" else None)
        xx, yy, zz, xy = (plane[k] for k in ("xx", "yy", "zz", "xy"))
        in_plane = math.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy ** 2)
        if tensor in OBLIQUE:
            assert plane["m"] > 1.001 * in_plane, "shears across the plane"
        else:
            close(plane["m"], in_plane, 1e-12)
    # A material that stands oblique in one half is none of the other's.
    halves = []
    for of_half in (f"transverse({TRANSVERSE}, axis = [1, 0, 1])", ISOTROPIC):
        run(folder, f"""
mesh body = rectangle(2, 1, cells = [4, 2])
part half = body where x < 1
part other = body - half
part edge = body.boundary
tensor B = isotropic(young = 70, poisson = 0.3)
tensor D = {of_half}
fn pushed() = {affine}
space V = vector P1 on body, zero on edge
find u in V with u = pushed() on edge such that for all v in V
  integral(half, D : eps(u) : eps(v)) + integral(other, B : eps(u) : eps(v)) = integral(other, 1e-9*v.x)
report table m = mises(D : eps(u)) at [0.4, 0.3], s = mises(sigma) at [0.4, 0.3], b = mises(B : eps(u)) at [1.6, 0.3], o = mises(sigma) at [1.6, 0.3]
""")
        halves.append(rows(folder)[-1])
        close(halves[-1]["m"], halves[-1]["s"], 1e-12)
        close(halves[-1]["b"], halves[-1]["o"], 1e-12)
    assert abs(halves[0]["m"] - halves[1]["m"]) > 0.1 * halves[0]["m"]
    # Other unknowns beside u, whose gradients stand in integrals of their own or in one with those of u, change nothing.
    alone = """
mesh body = rectangle(1, 1, cells = [3, 3])
part floor = body.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on body, zero on floor
space W = {space} P1 on body, zero on floor
find u in V{find} such that for all v in V{test}
  {beside}integral(body, B : eps(u) : eps(v){within}) = integral(body, dot([1, -2], v){load})
report table m = mises(sigma) at [0.4, 0.3], zz = sigma.zz at [0.4, 0.3]
"""
    nothing = {"space": "scalar", "find": "", "test": "", "beside": "", "within": "", "load": ""}
    run(folder, alone.format(**nothing))
    expected = rows(folder)[-1]
    scalar = {"find": ", T in W", "test": ", q in W", "load": " + q"}
    vector = {"space": "vector", "find": ", w in W", "test": ", q in W", "load": " + dot([3, 1], q)"}
    for other in ({**scalar, "beside": "integral(body, dot(grad(T), grad(q))) + "}, {**scalar, "within": " + dot(grad(T), grad(q))"},
                  {**vector, "beside": "integral(body, B : eps(w) : eps(q)) + "}, {**vector, "within": " + B : eps(w) : eps(q)"}):
        run(folder, alone.format(**{**nothing, **other}))
        for name, value in expected.items():
            close(rows(folder)[-1][name], value, 1e-9)
    ring = """
mesh tube = rectangle(1, 1, at = [1, 0], cells = [2, 2], axisymmetric = true)
part inner = tube.left
part flat = tube.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P2 on tube, zero.y on flat
find u in V such that for all v in V integral(tube, B : eps(u) : eps(v)) = integral(inner, dot([1, 0], v))
report table m = mises(sigma) at [1.2, 0.4], xx = sigma.xx at [1.2, 0.4], yy = sigma.yy at [1.2, 0.4], zz = sigma.zz at [1.2, 0.4],
  xy = sigma.xy at [1.2, 0.4]
"""
    run(folder, ring)
    xx, yy, zz, xy = (rows(folder)[-1][k] for k in ("xx", "yy", "zz", "xy"))
    close(rows(folder)[-1]["m"], math.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy ** 2), 1e-12)


def check_lines(folder):
    places = [(0.1 + 0.08 * k, 0.9 - 0.07 * k) for k in range(11)]
    columns = ", ".join(f"u{k} = u.y at [{x!r}, {y!r}], s{k} = sigma.xy at [{x!r}, {y!r}]" for k, (x, y) in enumerate(places))
    for when, row in (("", -1), (" at t = 0.5", 1)):
        at = ", ".join(f"w{k} = u.y at [{x!r}, {y!r}]{when}" for k, (x, y) in enumerate(places))
        run(folder, PLATE.format(tensor=ISOTROPIC, element="P2", report=f"""table {columns}, {at}
  line u.y, u, sigma from [0.1, 0.9] to [0.9, 0.2] by 11 points{when} to "along.csv"
  line u.y from [0.5, 0.5] to [1.5, 0.5] by 3 points to "out.csv" """))
        table, line = rows(folder), rows(folder, "along")
        assert len(line) == 11
        for k, (x, y) in enumerate(places):
            close(line[k]["x"], x, 1e-12, 1.0)
            close(line[k]["y"], y, 1e-12, 1.0)
            close(line[k]["distance"], math.hypot(x - 0.1, y - 0.9), 1e-12, 1.0)
            close(line[k]["u.y"], table[-1][f"w{k}"], 1e-12)
            if not when:
                close(line[k]["u.y"], table[-1][f"u{k}"], 1e-12)
                close(line[k]["sigma.xy"], table[-1][f"s{k}"], 1e-9, 1.0)
        outside = list(csv.DictReader((folder / "out" / "out.csv").open()))
        assert [bool(r["u.y"]) for r in outside] == [True, True, False], outside


# Damage of one of two bodies, and stiffness that grows in time.
CHANGING = """
param N = 8
mesh body = rectangle(2, 1, cells = [8, 4])
part soft = body where x < 1
part stiff = body - soft
part floor = body.bottom
part roof = body.top
tensor B = isotropic(young = 70, poisson = 0.3)
state d on soft with rate 5*norm(eps(u)) from d = 0 in [0, 0.95]
space V = vector {element} on body, zero on floor
find u in V for t in [0, 1] by N steps from u = 0
such that for all v in V
    integral(soft, (1 + 0.2*t)*(1 - d)*B : eps(u) : eps(v)) + integral(stiff, (1 + 0.2*t)*B : eps(u) : eps(v))
 = integral(roof, dot([0.8*t, 0.4*t], v))
report
  {report}
"""


def check_lines_of_what_changes(folder):
    """Stresses that read the time and a state, and the state itself: the bits of columns at the same places, in cells and between."""
    places = [((13 + 22 * k) / 128, (109 - 8 * k) / 128) for k in range(9)]  # sums of them have no rounding
    begin, end = list(places[0]), list(places[-1])
    for element in ("P1", "P2"):
        for when in ("", " at t = 0.55"):
            columns = ", ".join(f"s{k} = sigma.xx at [{x!r}, {y!r}]{when}, m{k} = mises(sigma) at [{x!r}, {y!r}]{when}"
                                + (f", d{k} = d at [{x!r}, {y!r}]{when}" if x < 1 else "") for k, (x, y) in enumerate(places))
            run(folder, CHANGING.format(element=element, report=f"""table {columns}
  line sigma.xx, mises(sigma), u.y from {begin} to {end} by 9 points{when} to "along.csv"
  line d from {begin} to {end} by 9 points{when} to "damage.csv" """))
            table, line, damage = rows(folder)[-1], rows(folder, "along"), rows(folder, "damage")
            assert max(d.get("d", 0) for d in damage) > 0.01
            for k, (x, y) in enumerate(places):
                assert (line[k]["x"], line[k]["y"]) == (x, y)
                assert (line[k]["sigma.xx"], line[k]["mises_sigma"]) == (table[f"s{k}"], table[f"m{k}"])
                assert damage[k].get("d") == table.get(f"d{k}"), (k, damage[k])  # none beyond the soft part
    (folder / "away.hvi").write_text(CHANGING.format(element="P1", report="line d from [1.2, 0.5] to [1.8, 0.5] by 3 points"))
    done = subprocess.run([HVI_RUN, str(folder / "away.hvi"), "-o", str(folder / "out")], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 1 and "no point of the line lies where `d` lives" in done.stderr, done.stderr


GROWING = """
mesh body = rectangle(2, 1, cells = [6, 3])
part floor = body.bottom
part roof = body.top
part half = body where x < 1
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P2 on body, zero on floor
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(body, {factor}B : eps(u) : eps(v)) = integral(roof, dot([2*t, -t], v))
report
  table most = largest(roof, sigma.yy), least = smallest(roof, mises(sigma)), whole = integral(roof, sigma.xy), cells = integral(half, sigma.xx),
    inside = largest(half, sigma.xy), here = sigma.yy at [1.3, 0.4], early = mises(sigma) at [1.3, 0.4] at t = 0.6, held = reaction(floor), tip = u.y at [2, 1]
  line sigma from [0.1, 0.5] to [1.9, 0.5] by 7 points to "along.csv"
  fields sigma
  picture mises(sigma) to "grown.svg"
"""


def check_lines_of_memories(folder):
    """A memory whose term is zero is left out and the others get its number, in lines and fields, too: their stresses are those of a
    table, whose columns have all of their own."""
    run(folder, """mesh plate = rectangle(1, 1, cells = [3, 3])
part wall = plate.left
tensor B = isotropic(young = 70, poisson = 0.3)
kernel none(lag) = exp(-lag)*B
kernel fading(lag) = -exp(-2*lag)*B
space V = vector P1 on plate, zero on wall
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(plate, B : eps(u) : eps(v))
  + 0*integral(plate, history(none, eps(u)) : eps(v)) + integral(plate, history(fading, eps(u)) : eps(v))
  = integral(plate, dot([1, -2*t], v))
report
  table a = sigma.xy at [0.2, 0.3], b = sigma.xy at [0.8, 0.5], c = sigma.xx + sigma.yy at [0.2, 0.3]
  line sigma.xy from [0.2, 0.3] to [0.8, 0.5] by 2 points to "along.csv"
  fields sigma every 4 steps to "end"
""")
    end, line = rows(folder)[-1], rows(folder, "along")
    close(line[0]["sigma.xy"], end["a"], 1e-13)
    close(line[1]["sigma.xy"], end["b"], 1e-13)
    mesh = meshio.read(sorted((folder / "out").glob("end*.vtu"))[-1])
    values = mesh.cell_data["sigma"][0].reshape(-1, 3, 3)[:, 0, 1]
    for column in ("a", "b"):
        assert np.min(np.abs(values - end[column])) <= 1e-12 * np.abs(values).max(), (column, end, values)
    here = mesh.cell_data["sigma"][0].reshape(-1, 3, 3)[int(np.argmin(np.abs(values - end["a"])))]
    close(here[2, 2], 0.3 * end["c"], 1e-12)  # without viscosity: Poisson's ratio times the stresses in the plane


def check_certificates(folder):
    """The certificate has the worst of the rows that monitors have of each step, and where they stand. What a memory is off is its
    relative error times its norm and the largest value of its field, here a strain of some percent."""
    run(folder, """mesh plate = rectangle(1, 1, cells = [4, 4])
part wall = plate.top
part ground = plate.bottom
tensor A = isotropic(lambda = 5, mu = 10)
tensor B = isotropic(young = 70, poisson = 0.3)
kernel C(lag) = -0.3/(lag + 0.1)*B
superpotential layer(r) with slope | r < 0 -> 0 | r < 0.01 -> 100*r | otherwise -> 1 + 20*(r - 0.01)
space V = vector P1 on plate, zero on wall
find u in V for t in [0, 1] by 100 steps from u = 0 using memory = tree, memory_tolerance = 1e-6
such that for all v in V
    integral(plate, A : eps(u') : eps(v)) + integral(plate, B : eps(u) : eps(v)) + integral(plate, history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu))
 >= integral(plate, dot([1, -9*sin(7*t)], v))
report
  table a = u.y at [0.5, 0]
""", "--monitors", "--json", str(folder / "all.json"))
    result = json.loads((folder / "all.json").read_text())
    certificate, monitors = result["certificate"], result["monitors"]
    steps = {}
    for name in ("inclusion", "equilibrium"):
        worst = max(monitors[name])
        close(certificate[name], worst)
        steps[name] = certificate[f"{name}_step"]
        assert monitors[name][steps[name] - 1] == worst, (name, certificate)
    assert steps["inclusion"] != steps["equilibrium"], "which of them is which would not be seen"
    [memory] = result["plan"]["history"]
    strain = memory["bound"] / (memory["error"] * memory["norm"])
    assert 0 < memory["error"] <= 1e-6 and abs(memory["norm"] - math.log(11)) < 1e-6 and 1e-3 < strain < 1, memory


def check_certificates_of_states(folder):
    """The states' error is the worst of all steps: with more of the same steps it does not fall."""
    worst = 0.0
    for steps in range(1, 9):
        run(folder, f"""mesh body = rectangle(1, 1, cells = [3, 3])
part roof = body.top
part glue = body.bottom
tensor B = isotropic(lambda = 10, mu = 10)
superpotential bond(r) = 0.5*beta^2*10*r^2
state beta on glue with rate -max(0, 50*beta*pos(u.nu)^2 - 0.01) from beta = 1 in [0, 1]
space V = vector P1 on body, zero on roof
find u in V for t in [0, {steps}/8] at {[(k + 1) / 8 for k in range(steps)]} from u = 0
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(glue, bond^0(u.nu; v.nu))
 >= integral(body, dot([0, -9*t], v))
report
  table b = integral(glue, beta)
""", "--json", str(folder / "all.json"))
        states = json.loads((folder / "all.json").read_text())["certificate"]["states"]
        assert states >= worst, (steps, states, worst)
        worst = states
    assert worst > 0


def check_files_of_matrices(folder):
    """Entry ij of a matrix stands in row i of the arrays in VTU files: d u_i/d x_j of a field that is known."""
    run(folder, """mesh plate = rectangle(1, 1, cells = [2, 2])
part edge = plate.boundary
space V = vector P1 on plate, zero on edge
find u in V with u = [2*x + 3*y, 5*x + 7*y] on edge
such that for all v in V
  integral(plate, grad(u) : grad(v)) = 0
report
  fields grad(u), u to "matrix"
""")
    mesh = meshio.read(next((folder / "out").glob("matrix*.vtu")))
    slopes = mesh.cell_data["grad_u"][0].reshape(-1, 3, 3)
    assert np.abs(slopes - [[2, 3, 0], [5, 7, 0], [0, 0, 0]]).max() < 1e-12, slopes
    # Shears across the plane, of a tensor whose axis lies askew, against those of the same strain in space.
    stresses = []
    for mesh, value in (("rectangle(1, 1, cells = [2, 2])", ""), ("box(1, 1, 1, cells = [2, 2, 2])", ", 0")):
        run(folder, f"""mesh plate = {mesh}
part edge = plate.boundary
tensor B = {OBLIQUE[1]}
space V = vector P1 on plate, zero on edge
find u in V with u = [2*x + 3*y, 5*x + 7*y{value}] on edge
such that for all v in V
  integral(plate, B : eps(u) : eps(v)) = 0
report
  fields sigma to "askew"
""")
        stresses.append(meshio.read(next((folder / "out").glob("askew*.vtu"))).cell_data["sigma"][0].reshape(-1, 3, 3)[0])
    assert np.abs(stresses[0] - stresses[1]).max() < 1e-10 * np.abs(stresses[1]).max(), stresses
    assert abs(stresses[1][0, 2] - stresses[1][1, 2]) > 1


def check_rules_of_integrals(folder):
    """On the sides of cells of length h, by the rules themselves: their points and weights on [0, 1]."""
    run(folder, """mesh plate = rectangle(2, 1, cells = [4, 2])
part wall = plate.left
part roof = plate.top
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on plate, zero on wall
find u in V
such that for all v in V
  integral(plate, B : eps(u) : eps(v)) = 0
report
  table e = integral(roof, x^4), g = integral(roof, x^4, rule = gauss), m = integral(roof, x^4, rule = midpoint), n = integral(roof, x^4, rule = nodal)
""")
    row, h = rows(folder)[-1], 0.5
    root = math.sqrt(1 / 12)
    for name, rule in (("g", [(0.5 - root, 0.5), (0.5 + root, 0.5)]), ("m", [(0.5, 1)]), ("n", [(0, 0.5), (1, 0.5)])):
        close(row[name], sum(h * w * (h * (k + s)) ** 4 for k in range(4) for s, w in rule), 1e-13)
    close(row["e"], 2 ** 5 / 5, 1e-13)
    # In a body of revolution gauss is exact for products of two shape functions around the axis, too.
    run(folder, """mesh ring = rectangle(1, 1, cells = [1, 1], origin = [1, 0], axisymmetric = true)
part wall = ring.left
part half = ring where x - 1 > y
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on ring, zero on wall
find u in V
such that for all v in V
  integral(ring, B : eps(u) : eps(v)) = 0
report
  table a = integral(half, x*y, rule = gauss), b = integral(half, y^2, rule = gauss), c = integral(half, x^2, rule = gauss)
""")
    row = rows(folder)[-1]
    for name, exact in (("a", 31 / 60), ("b", 3 / 20), ("c", 49 / 20)):
        close(row[name], 2 * math.pi * exact, 1e-13)


def check_stiffness_that_grows(folder):
    """The stress does not know by which number of the time a whole material is multiplied, wherever it is asked for; the displacement does."""
    found = []
    for factor in ("", "(1 + 0.5*t^2)*"):
        run(folder, GROWING.format(factor=factor))
        found.append((rows(folder)[-1], rows(folder, "along"), meshio.read(sorted((folder / "out").glob("scene*_00004.vtu"))[-1])))
    (plain, line, field), (grown, grown_line, grown_field) = found
    for name in plain.keys() - {"tip", "early"}:
        close(plain[name], grown[name], 1e-12, abs(plain["most"]))
    close(plain["tip"], 1.5 * grown["tip"], 1e-12)
    for a, b in zip(line, grown_line):
        for name in a:
            close(a[name], b[name], 1e-11, abs(plain["most"]))
    (a,), (b,) = field.cell_data["sigma"], grown_field.cell_data["sigma"]
    assert abs(a - b).max() < 1e-11 * abs(a).max()


def check_reactions_of_parts_that_overlap(folder):
    """What two conditions hold counts once: reactions of all parts add up to the load, and a part that has all of another one has what
    that leaves. Where it leaves nothing, that is said."""
    plate = """mesh plate = rectangle(2, 1, cells = [4, 3])
part wall = plate.left
part frame = plate.left + plate.bottom
part top = plate.top
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on plate, ZERO
find u in V
such that for all v in V
  integral(plate, B : eps(u) : eps(v)) = integral(top, dot([0.3, -0.5], v))
report
  table w = reaction(wall), f = reaction(frame), all = reaction(plate)
"""
    for zero in ("zero on wall, zero on frame", "zero on frame"):
        run(folder, plate.replace("ZERO", zero))
        row = rows(folder)[-1]
        close(row["all_x"], -0.6, 1e-12), close(row["all_y"], 1, 1e-12)
        assert abs(row["w_x"]) > 0.1, row
        for c in "xy":
            close(row[f"f_{c}"] + (row[f"w_{c}"] if "wall" in zero else 0), row[f"all_{c}"], 1e-12)
    (folder / "late.hvi").write_text(plate.replace("ZERO", "zero on frame, zero on wall"))
    done = subprocess.run([HVI_RUN, "check", str(folder / "late.hvi")], capture_output=True, text=True)
    assert done.returncode == 1 and "all nodes of `wall` have their values from conditions on other parts" in done.stderr, done.stderr


def check_reactions_at_the_start(folder):
    """Known where the run starts from accelerations, but for schemes whose reactions are those of a step."""
    for scheme, known in (("newmark", True), ("hht", False), ("midpoint", False), ("backward_euler", False)):
        run(folder, f"""mesh body = rectangle(2, 1, cells = [3, 2])
part wall = body.left
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] by 4 steps from u = 0 using scheme = {scheme}
such that for all v in V
  integral(body, 0.3*dot(u'', v)) + integral(body, B : eps(u) : eps(v)) = integral(body, dot([0, -1 - t], v))
report
  table force = reaction(wall), rate = integral(body, 0.3*u''.y) from start
""")
        table = rows(folder)
        assert table[0]["t"] == 0 and ("force_y" in table[0]) == known, (scheme, table[0])
        if known:
            close(table[0]["force_y"] - 2, table[0]["rate"], 1e-10)
        assert all("force_y" in row for row in table[1:]), (scheme, table)


def check_reactions_of_what_begins(folder):
    """Reactions count forms that are zero at the initial time, by whatever makes them grow (a program that looks at that time alone
    has no rates at hand later): in equilibrium with the load, and those of the same forms written otherwise."""
    for state, factors in (("", ("t", "max(0, t - 0.6)", "| t < 0.5 -> 0 | otherwise -> 1")), ("state d on body with rate 1 + 0*norm(eps(u)) from d = 0", ("d",))):
        for factor in factors:
            for scheme in ("backward_euler", "bdf2", "midpoint", "newmark", "hht"):
                if state and scheme not in ("backward_euler", "bdf2"):
                    continue
                mass = "integral(body, 0.001*dot(u'', v)) + " if scheme in ("midpoint", "newmark", "hht") else ""
                run(folder, f"""mesh body = rectangle(2, 1, cells = [3, 2])
part wall = body.left
tensor B = isotropic(young = 70, poisson = 0.3)
{state}
fn g() = {factor}
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] by 6 steps from u = 0 using scheme = {scheme}
such that for all v in V
  {mass}integral(body, g()*B : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) = integral(body, dot([0, -t], v))
report
  table force = reaction(wall)
""")
                table = rows(folder)
                assert len(table) == 6, (factor, scheme, table)
                for row in table if not mass else ():
                    close(row["force_y"], 2 * row["t"], 1e-10)
                    assert abs(row["force_x"]) < 1e-10, (factor, scheme, row)


def check_names_of_plans(folder):
    """What keeps a run from the contact unknowns alone is told by the names of the script: a column, not the parts that it is made of."""
    for form, columns, said in (("B : eps(u)", "held = reaction(wall).y + reaction(ground).y", "the table reads `held` in the interior at every step"),
                                ("B : eps(u)", "early = 2*reaction(wall).y at t = 0.3", "`early` reads the interior between two steps"),
                                ("(1 + t)*B : eps(u)", "tip = u.y at [2, 0]", "forms change from step to step")):
        done = run(folder, f"""mesh body = rectangle(2, 1, cells = [6, 3])
part wall = body.left
part ground = body.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential bed(r) = 20*max(r, 0)^2
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
  integral(body, {form} : eps(v)) + integral(ground, bed^0(u.nu; v.nu)) >= integral(body, dot([0, -t], v))
report
  table {columns}
""", command="plan")
        assert said in done, (said, done)


def check_sweep(folder):
    text = PLATE.replace("mesh plate", "param k = 1\nparam degree = P1\nmesh plate").replace("sin(2*t)", "k*sin(2*t)").format(
        tensor=ISOTROPIC, element="degree", report="table tip = u.y at [1, 1], held = reaction(wall)\nstudy vary k in [1, 2, 3] and degree in [P1, P2]")
    run(folder, text, command="study")
    table = list(csv.DictReader((folder / "out" / "study.csv").open()))
    assert len(table) == 6 and (folder / "out" / "sweep_tip.svg").exists(), table
    for row in table:
        run(folder, text, "-D", f"k={row['k']}", "-D", f"degree={row['degree']}", "--json", str(folder / "one.json"))
        final = json.loads((folder / "one.json").read_text())["final"]
        for name in ("tip", "held_x", "held_y"):
            assert float(row[name]) == final[name], (row, final)


def check_names_of_studies(folder):
    """No two columns of study.csv have one name, whatever parameters and columns of tables are called."""
    text = PLATE.replace("mesh plate", "param drop = 1\nparam order = P1\nparam k = 1\nmesh plate").replace("sin(2*t)", "drop*k*sin(2*t)").format(
        tensor=ISOTROPIC, element="order", report="table drop = u.y at [1, 1], steps = u.x at [1, 1], free = u.x at [1, 0.5]\n")
    for end in ("", " against finest"):
        run(folder, text + "study vary drop in [1, 2] and order in [P1, P2]" + end, command="study")
        lines = list(csv.reader((folder / "out" / "study.csv").open()))
        head, rows = lines[0], [dict(zip(lines[0], line, strict=True)) for line in lines[1:]]
        assert len(set(head)) == len(head), head
        assert head[:2] == ["drop", "params.order"] and {"order", "steps", "columns.drop", "columns.drop_error", "columns.steps", "free", "free_error"} <= set(head), head
        for row in rows[::3]:
            run(folder, text, "-D", f"drop={row['drop']}", "-D", f"order={row['params.order']}", "--json", str(folder / "one.json"))
            result = json.loads((folder / "one.json").read_text())
            assert float(row["columns.drop"]) == result["final"]["drop"] and int(row["steps"]) == result["steps"] and float(row["free"]) == result["final"]["free"], (row, result["final"])


def check_pictures(folder):
    run(folder, PLATE.format(tensor=ISOTROPIC, element="P2", report="""table tip = u.y at [1, 1], held = reaction(wall)
  plot held_y, held_x against tip to "loop.svg"
  picture mises(sigma) deformed = 5 to "stress.png"
  picture u'.y at t = 0.6 to "rate.png" """))
    loop = (folder / "out" / "loop.svg").read_text()
    assert "held_x" in loop and "held_y" in loop and "tip" in loop
    for name in ("stress.png", "rate.png"):
        assert (folder / "out" / name).read_bytes()[-8:-4] == b"IEND", name
    check_bar(folder)
    check_row(folder)
    check_pictures_of_a_part(folder)


def check_words(folder):
    """Titles are the script's words, files and arrays have names; what is another picture or field has another name."""
    run(folder, PLATE.format(tensor=ISOTROPIC, element="P1", report="""table most = largest(plate, u.y)
  picture mises(sigma), u'.y,  2*u.x +
     u.y to "titles.svg"
  picture mises(sigma)
  picture max(u.x, u.y)
  picture max(u.x, -u.y)
  picture u deformed = 3
  picture u deformed = 5
  picture 2*u.x
  picture 3*u.x
  picture LONG
  picture LONG to "long.svg"
  fields mises(sigma), 2*u.x, 3*u.x""").replace("LONG", " + ".join(["u.x", "u.y"] * 40)))  # no file has a name of 1000 letters
    svg = (folder / "out" / "titles.svg").read_text()
    titles = [t.replace("&apos;", "'").replace("&#39;", "'") for t in re.findall(r'font-size="15"[^>]*>([^<]*)</text>', svg)]
    assert titles == ["mises(sigma)", "u'.y", "2*u.x + u.y"], titles
    assert svg.count(">mises(sigma)<") == 2 and svg.count("2*u.x + u.y") == 2, "over the bar, too"
    long_name = "_plus_".join(["u.x", "u.y"] * 40)[:100]
    images = [f"scene_{name}.png" for name in (long_name, "mises_sigma", "max_u.x", "max_u.x_2", "u_deformed", "u_deformed_2", "2_times_u.x", "3_times_u.x")]
    assert sorted(p.name for p in (folder / "out").glob("scene_*.png")) == sorted(images), sorted(p.name for p in (folder / "out").glob("*.png"))
    assert len({(folder / "out" / name).read_bytes() for name in images}) == len(images)
    long_title, = re.findall(r'font-size="15"[^>]*>([^<]*)</text>', (folder / "out" / "long.svg").read_text())
    assert long_title == " + ".join(["u.x", "u.y"] * 40)[:57] + "...", long_title
    mesh = meshio.read(max((folder / "out").glob("scene_0*.vtu")))
    assert list(mesh.cell_data) == ["mises_sigma"] and list(mesh.point_data) == ["2_times_u.x", "3_times_u.x"], (mesh.cell_data.keys(), mesh.point_data.keys())


def check_pictures_of_a_part(folder):
    """An unknown that lives on one piece has no value elsewhere: the bar begins with its own least value."""
    run(folder, """
mesh upper = rectangle(1, 1, at = [0, 1], cells = [2, 2])
mesh lower = rectangle(1, 1, cells = [2, 2])
mesh both  = upper + lower
part roof = upper.top
part foot = upper.bottom
part floor = lower.bottom
space S = scalar P1 on both, zero on roof, zero on floor
space W = scalar P1 on upper, zero on roof, zero on foot
find s in S, T in W with T = 2 on roof, T = 1 on foot
such that for all q in S, w in W
  integral(both, dot(grad(s), grad(q))) + integral(upper, dot(grad(T), grad(w))) = integral(both, q)
report
  table most = largest(upper, T)
  picture T to "values.svg"
  picture grad(T) to "slopes.svg"
""")
    for name, least in (("values", "1 to 2"), ("slopes", "1 to 1")):
        svg = (folder / "out" / f"{name}.svg").read_text()
        assert f">{least}<" in svg, name


def check_pictures_of_states(folder):
    """A damage that does not grow, on a part or on all, changes no picture of the stress; the damage itself is drawn on the moved body."""
    found = {}
    for name, state, form in (("none", "", "integral(body, B : eps(u) : eps(v))"),
                              ("all", "state d on body with rate 0*norm(eps(u)) from d = 0", "integral(body, (1 - d)*B : eps(u) : eps(v))"),
                              ("half", "state d on soft with rate 0*norm(eps(u)) from d = 0",
                               "integral(soft, (1 - d)*B : eps(u) : eps(v)) + integral(stiff, B : eps(u) : eps(v))")):
        for mesh, space in (("rectangle(2, 1, cells = [6, 3])", "vector"), ("interval(2, cells = 6)", "scalar")):
            plane = space == "vector"
            stress, force = ("sigma.xx", "dot([t, t], v)") if plane else ("(1-d)*grad(u).x" if state else "grad(u).x", "t*v")
            if not plane:
                form = form.replace("B : eps(u) : eps(v)", "dot(grad(u), grad(v))").replace("B : ", "")
                state = state.replace("norm(eps(u))", "abs(grad(u).x)")
            if name == "half" and not plane:
                continue  # the expression is nothing on the other half
            run(folder, f"""mesh body = {mesh}
part soft = body where x < 1
part stiff = body where x > 1
part wall = body.left
tensor B = isotropic(young = 70, poisson = 0.3)
{state}
space V = {space} P1 on body, zero on wall
find u in V for t in [0, 1] by 2 steps from u = 0
such that for all v in V
  {form} = integral(body, {force})
report
  picture {stress}{" deformed = 4" if plane else ""} to "stress.svg"
""")
            svg = (folder / "out" / "stress.svg").read_text().replace("(1-d)*", "")
            texts = re.findall(r">([^<>]+)</text>", svg)
            assert found.setdefault(space, texts) == texts, (found[space], texts)
            shapes, places = shapes_of(svg)
            assert found.setdefault(space + " shapes", shapes) == shapes, name
            off = abs(found.setdefault(space + " places", places) - places).max()
            assert off <= 0.011, (name, off)  # rounding of the displacements may change the last of two digits
            if plane:
                pixels = pixels_of(svg)
                assert abs(found.setdefault("pixels", pixels) - pixels).max() <= 2 and pixels.std() > 10, abs(found["pixels"] - pixels).max()


def shapes_of(svg):
    """What is drawn, without numbers and images; and the numbers."""
    drawn = re.sub(r'href="[^"]*"', "", svg)
    number = r"-?\d+(?:\.\d+)?"
    return re.sub(number, "#", drawn), np.array([float(n) for n in re.findall(number, drawn)])


def pixels_of(svg):
    """The body's image, an embedded PNG with eight bits a colour."""
    data = base64.b64decode(re.search(r'href="data:image/png;base64,([^"]*)"', svg)[1])
    at, packed, wide, high = 8, b"", 0, 0
    while at < len(data):
        size, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        if kind == b"IHDR":
            wide, high = (int.from_bytes(data[at + 8 + 4 * k:at + 12 + 4 * k], "big") for k in range(2))
            each = {2: 3, 6: 4}[data[at + 17]]
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += size + 12
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(high, 1 + wide * each)
    assert (lines[:, 0] == 2).all(), "each line is a difference to the one above"
    return np.cumsum(lines[:, 1:], axis=0, dtype=np.uint8).astype(int)


def check_row(folder):
    """Several fields, or one at several times, side by side; of one field the same colours at all times and the same window."""
    run(folder, PLATE.format(tensor=ISOTROPIC, element="P1", report="""table most = largest(plate, u.y)
  picture sigma.xx, u.y, layer.xi at t = 0.5 to "row.svg"
  picture u.y deformed = 40 at t = [0.25, 0.5, 1] to "times.svg"
  picture u.x, u.y to "pair.png"
  picture u.x, sigma.yy """))
    number = lambda text: float(text.replace("\u2212", "-"))
    texts = lambda svg, size: [(number(m[1]), m[2]) for m in re.finditer(rf'<text x="(\S+)" y="\S+" font-size="{size}"[^>]*>([^<]*)</text>', svg)]
    row, times = ((folder / "out" / f"{name}.svg").read_text() for name in ("row", "times"))
    assert [t for _, t in sorted(texts(row, 15))] == [f"{f}, t = 0.5" for f in ("sigma.xx", "u.y", "layer.xi")], texts(row, 15)
    heads = texts(times, 15)
    assert [t for _, t in heads] == [f"u.y, t = {t}, deformed 40 times" for t in ("0.25", "0.5", "1")] and heads == sorted(heads), heads
    for svg, ranges in ((row, 3), (times, 1)):  # the image of the body and that of its bar, each three times
        assert svg.count("<image") == 6 and len({t for _, t in texts(svg, 11) if " to " in t}) == ranges, texts(svg, 11)
    sizes = re.findall(r'<image x="\S+" y="(\S+)" width="(\S+)" height="(\S+)"', times)
    assert len(set(sizes)) == 2, sizes  # of the bodies, and of the bars
    for name in ("pair.png", "scene_u.x_row.png"):
        assert (folder / "out" / name).read_bytes()[-8:-4] == b"IEND", name


def check_bar(folder):
    """The bar of a picture of stresses ends at what `largest` and `smallest` say: nothing is smoothed away."""
    run(folder, PLATE.format(tensor=ISOTROPIC, element="P1", report="""table most = largest(plate, sigma.xy), least = smallest(plate, sigma.xy)
  picture sigma.xy to "cells.svg" """))
    table, svg = rows(folder)[-1], (folder / "out" / "cells.svg").read_text()
    assert "cell by cell" in svg
    shown = [float(text) for text in re.search(r">(\S+) to (\S+)</text>", svg.replace("\u2212", "-")).groups()]
    for value, number in zip((table["least"], table["most"]), shown):
        assert abs(value - number) < 2e-3 * max(map(abs, shown)), (table, shown)


def check_resume(folder):
    """Reactions, lines, plots and pictures (one that moves, too) of a run that is stopped and goes on, byte for byte."""
    text = PLATE.replace("[0, 1] by 4 steps", "[0, T] by N steps").replace("mesh plate", "param T = 1\nparam N = 4\nmesh plate").format(
        tensor=ISOTROPIC, element="P1", report="""table tip = u.y at [1, 1], held = reaction(wall), pressed = reaction(ground), most = largest(plate, mises(sigma))
  line u.y, sigma from [0.1, 0.9] to [0.9, 0.2] by 11 points to "end.csv"
  line u.y from [0.1, 0.9] to [0.9, 0.2] by 5 points at t = 0.4 to "early.csv"
  plot held_y, pressed_y against tip to "loop.svg"
  picture u deformed = 3 at t = 0.4 to "early.svg"
  picture sigma.xy to "late.svg"
  picture u'.y deformed = 3 to "moving.apng" """)
    names = ["scene.csv", "end.csv", "early.csv", "loop.svg", "early.svg", "late.svg", "moving.apng"]
    run(folder, text, "-D", "T=2", "-D", "N=8")
    whole = {name: (folder / "out" / name).read_bytes() for name in names}
    for name in names:
        (folder / "out" / name).unlink()
    run(folder, text, "--checkpoint", "1")
    run(folder, text, "-D", "T=2", "-D", "N=8", "--resume")
    for name in names:
        assert (folder / "out" / name).read_bytes() == whole[name], name
    frames = whole["moving.apng"]
    at = frames.index(b"acTL") + 4
    assert int.from_bytes(frames[at:at + 4], "big") == 8 and frames.count(b"fcTL") == 8


def check_negative_bounds(folder):
    """A layer of springs under a body that is lifted pulls, and friction with its multiplier for a bound pushes. This is said once."""
    for slip, argument in (("norm(w)", "u.tau"), ("abs(w)", "u.x")):
        for pull, bound, expected in ((1, "layer.xi", 1), (1, "max(layer.xi, 0)", 0), (1, "abs(layer.xi)", 0), (-1, "layer.xi", 0)):
            text = f"""import contact
mesh body = rectangle(1, 1, cells = [2, 2])
part ground = body.bottom
part roof = body.top
tensor B = isotropic(young = 100, poisson = 0.2)
superpotential layer(r) = winkler(r, stiffness = 50)
superpotential slip(w) = 0.3*{bound}*{slip}
space V = vector P1 on body, zero on roof
find u in V for t in [0, 1] by 3 steps from u = 0
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu) + slip^0({argument}; {argument.replace('u.', 'v.')}))
 >= integral(body, dot([0.1*t, {pull}*t], v))
report
  table a = u.y at [0, 0]
"""
            run(folder, text, "--json", folder / "told.json")
            notes = json.loads((folder / "told.json").read_text())["notes"]
            said = [note["step"] for note in notes if note["what"].startswith("the bound of `slip` is below 0 where `layer` pulls")]
            assert said == [1] * expected, (slip, pull, bound, notes)
            if (pull, bound) != (-1, "layer.xi"):
                continue
            run(folder, text.replace("0.3*layer.xi", "-0.3*layer.xi"), "--json", folder / "told.json")
            notes = json.loads((folder / "told.json").read_text())["notes"]
            assert any("`layer` presses" in note["what"] and "a coefficient of friction is positive" in note["what"] for note in notes), notes


def main():
    for check in (check_negative_bounds, check_motion, check_pairs, check_extremes, check_mises, check_lines, check_lines_of_what_changes, check_lines_of_memories, check_certificates, check_certificates_of_states, check_files_of_matrices, check_rules_of_integrals, check_stiffness_that_grows, check_reactions_of_parts_that_overlap, check_reactions_at_the_start, check_reactions_of_what_begins, check_names_of_plans, check_sweep, check_names_of_studies, check_pictures, check_words, check_pictures_of_states, check_resume):
        with tempfile.TemporaryDirectory() as folder:
            check(pathlib.Path(folder))
    check_examples()


main()
