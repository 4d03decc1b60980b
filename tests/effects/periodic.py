#!/usr/bin/env python3
"""periodic.py HVI_RUN: parts whose values repeat each other (`space V = ..., periodic left = right`).

- Manufactured solutions that only periodic functions have, with orders: scalars and vectors, P1 and P2, 2D and 3D, two unknowns.
- One cell against two cells in a row, with everything that a step can have: contact, friction on the rate, memory by each route, states of laws
  and of the body, inertia with mass off the contact, pairs, bodies of revolution, one component only.
- A layered material: its modulus is the harmonic mean, exactly.
- What `plan`, `check` and the pages say of periodic parts.
- Resumed runs, to a later end; `check` and E0425 name the motions that are left.
"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

HVI_RUN = sys.argv[1]


def run(folder, text, *options, name="scene", fails=False, command="run"):
    (folder / f"{name}.hvi").write_text(text)
    words = [HVI_RUN, command, str(folder / f"{name}.hvi"), *(["--quiet", "-o", str(folder / "out")] if command in ("run", "study") else []), *options]
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder)
    assert (done.returncode != 0) == fails, f"{text}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def table(folder, name="scene"):
    return [{k: float(v) if v else None for k, v in row.items()} for row in csv.DictReader((folder / "out" / f"{name}.csv").open())]


# --- orders

SCALAR = """param n = 4
param element = P1
mesh body = rectangle(1, 1, cells = [n, n])
part left = body.left
part right = body.right
part ends = body.bottom + body.top
space W = scalar {element} on body, zero on ends, periodic left = right
fn phi() = (1 + 0.5*sin(2*pi*x) + 0.25*cos(2*pi*x))*sin(pi*y)
fn load() = (pi^2 + (0.5*sin(2*pi*x) + 0.25*cos(2*pi*x))*5*pi^2)*sin(pi*y)
find w in W such that for all q in W
    integral(body, dot(grad(w), grad(q))) = integral(body, load()*q)
report
  table middle = w at [0, 0.5]
study vary n in [{rungs}] against exact phi() in W
"""
# u = [a, b, 0] sin(pi y) with a, b of period 1 in x and z; the load is -div(2 mu eps + lambda div I) with lambda = 0, mu = 1.
SPACE = """param n = 4
mesh body = box(1, 1, 1, cells = [n, n, n])
part left = body.left
part right = body.right
part back = body.back
part front = body.front
part ends = body.bottom + body.top
tensor B = isotropic(lambda = 0, mu = 0.5)
space V = vector {element} on body, zero on ends, periodic left = right, periodic back = front
fn c() = 1 + cos(2*pi*z)
fn s() = sin(2*pi*x)
fn exact() = [s()*c()*sin(pi*y), 0, 0]
find u in V such that for all v in V
    integral(body, B : eps(u) : eps(v))
  = integral(body, dot([s()*sin(pi*y)*(4.5*pi^2*c() + 2*pi^2*cos(2*pi*z)), -pi^2*cos(2*pi*x)*c()*cos(pi*y), 2*pi^2*cos(2*pi*x)*sin(2*pi*z)*sin(pi*y)], v))
report
  table middle = u.x at [0.25, 0.5, 0]
study vary n in [{rungs}] against exact exact() in V
"""


def orders(folder):
    for text, element, rungs, order in ((SCALAR, "P1", "16, 32, 64", 1), (SCALAR, "P2", "8, 16, 32", 2), (SPACE, "P1", "6, 9, 12", 1),
                                        (SPACE, "P2", "5, 7, 10", 2)):
        run(folder, text.format(element=element, rungs=rungs), "--json", str(folder / "study.json"), command="study")
        data = json.loads((folder / "study.json").read_text())
        runs = [(setting["n"], error) for setting, error in errors_of(data)]
        (n, e), (m, f) = runs[-2:]
        seen = math.log(e / f) / math.log(m / n)
        assert abs(seen - order) < 0.12, (element, runs, seen)
        print(f"{element} {'3D' if text is SPACE else '2D'}: errors {[f'{x:.3g}' for _, x in runs]}, order {seen:.2f} of {order}")


def errors_of(data):
    for entry in data["rows"]:
        yield {k: float(v) for k, v in entry["params"].items()}, entry["error"]["V_max"]


# --- one cell and two

CELL = """param L = 1
param N = 6
param T = 1
{mesh}
part left = {left}
part right = {right}
tensor A = isotropic(lambda = 0.5, mu = 1)
tensor B = isotropic(young = 20, poisson = 0.3)
kernel C(lag) = -0.6*exp(-lag/0.4) - 0.1*lag^0.5
superpotential wall(r) with slope | r < 0.004 -> 0 | otherwise -> 1e300
superpotential soft(r) = 60*pos(r)^2
superpotential rub(w) = 0.3*norm(w)
superpotential glue(r) = 2*(1 - worn)*pos(-r)^2
fn push() = [1.5 + sin(2*pi*x), -4 - 2*cos(2*pi*x)]
{more}
find u in V for t in [0, T] by N steps from u = 0{start}
such that for all v in V
{form}
report
  table a_x = u.x at [0.25, {low}], a_y = u.y at [0.25, {low}], b_x = u.x at [0.9375, {high}], b_y = u.y at [0.9375, {high}], s = sigma.xy at [0.3, {middle}]
"""
RECT = "mesh body = rectangle(L, 1, cells = [8*L, 4])"
GROUND = "part roof = body.top\npart ground = body.bottom\nspace V = vector {element} on body, zero on roof, periodic left = right"
VISCOUS = "    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v))\n"


def cells():
    base = dict(mesh=RECT, left="body.left", right="body.right", start="", low=0, high=0.5, middle=0.3)
    plain = GROUND.format(element="P1")
    load = " >= integral(body, sin(3*t)*dot(push(), v))"
    yield "contact and friction", {**base, "more": plain, "form": VISCOUS + "  + integral(ground, wall^0(u.nu; v.nu) + rub^0(u'.tau; v.tau))\n" + load}
    yield "P2, memory", {**base, "more": GROUND.format(element="P2"),
                         "form": VISCOUS + "  + integral(body, history(C, B : eps(u)) : eps(v)) + integral(ground, soft^0(u.nu; v.nu), rule = gauss)\n" + load}
    state = plain + "\nstate worn on ground with rate 3*norm(u.tau) from worn = 0 in [0, 0.9]"
    yield "a state of a law", {**base, "more": state, "form": VISCOUS + "  + integral(ground, glue^0(u.nu; v.nu))\n" + load}
    damage = plain + "\nstate d on body with rate max(0, norm(eps(u))/0.1 - 0.5) from d = 0 in [0, 0.9]"
    yield "damage", {**base, "more": damage, "form": VISCOUS.replace("B :", "(1 - d)*B :") + load}
    for scheme in ("midpoint", "midpoint unilateral", "newmark", "hht", "bdf2"):
        yield f"inertia, {scheme}", {**base, "more": plain, "start": f", u' = [0, -(0.3 + 0.1*cos(2*pi*x))*(1 - y)] using scheme = {scheme.split()[0]}",
                                     "form": "    integral(body, 0.5*dot(u'', v)) + integral(body, B : eps(u) : eps(v)) + integral(ground, "
                                             + ("wall" if scheme in ("midpoint unilateral", "bdf2") else "soft") + "^0(u.nu; v.nu))\n" + load}
    # Where x = 1 is a plane of symmetry, it does not matter whether u.x is held there.
    yield "one component", {**base, "mesh": RECT.replace("4])", "4], pattern = crossed)"), "more": plain.replace("periodic", "periodic.y").replace("zero on roof", "zero on roof, zero.x on left, zero.x on right"),
                            "form": VISCOUS + "  + integral(ground, soft^0(u.nu; v.nu))\n >= integral(body, sin(3*t)*dot([0, -4 - 2*cos(2*pi*x)], v))"}
    pair = ("part seam = pair(upper.bottom, lower.top)\npart roof = upper.top\npart floor = lower.bottom\n"
            "space V = vector P1 on body, zero on floor, periodic left = right")
    yield "a pair", {**base, "mesh": "mesh upper = rectangle(L, 0.5, cells = [8*L, 2], at = [0, 0.5])\nmesh lower = rectangle(L, 0.5, cells = [4*L, 2])\nmesh body = upper + lower",
                     "left": "upper.left + lower.left", "right": "upper.right + lower.right", "more": pair,
                     "form": VISCOUS + "  + integral(seam, soft^0(jump(u).nu; jump(v).nu) + rub^0(jump(u').tau; jump(v).tau))\n" + load.replace("push()", "[0.2, -4]")
                             + " + integral(roof, sin(3*t)*dot([0.5*sin(2*pi*x), -2*cos(2*pi*x)], v))"}
    yield "a force that moves", {**base, "more": plain, "form": VISCOUS + "  + integral(ground, soft^0(u.nu; v.nu))\n"
                                 " >= integral(body, exp(-(y - t)^2)*dot(push(), v)) + integral(ground, sin(t*(1.5 + cos(2*pi*x)))*v.y)"}
    yield "a stiffness that changes", {**base, "more": plain, "form": VISCOUS.replace("B :", "(1 + t)*B :") + load}


def one_and_two(folder):
    for name, parts in cells():
        text = CELL.format(**parts)
        if "worn on" not in parts["more"]:
            text = text.replace("(1 - worn)*", "")
        found = []
        for length in (1, 2):
            run(folder, text, "-D", f"L={length}", "--monitors")
            found.append(table(folder))
        size = max(abs(v) for row in found[0] for k, v in row.items() if k[:2] in ("a_", "b_"))
        apart = max(abs(p[k] - q[k]) / (20.0 if k == "s" else 1.0) for p, q in zip(*found) for k in ("a_x", "a_y", "b_x", "b_y", "s")) / size
        assert len(found[0]) == len(found[1]) == 6 and size > 1e-4, (name, size)
        # Mass is taken off contact nodes onto those around them: at the ends of a cell these are others than in its middle.
        assert apart < (0.05 if "unilateral" in name else 1e-8), f"{name}: one cell and two differ by {apart:.2e} of {size:.2e}"
        print(f"one cell and two, {name}: {apart:.1e}")


def revolution(folder):
    """A tube under pressure, a slice of it and two: as long as it likes, but for nothing that depends on z."""
    text = """param L = 0.5
mesh tube = rectangle(1, L, cells = [8, 8*L], at = [1, 0], axisymmetric = true)
part bore = tube.left
part low = tube.bottom
part high = tube.top
tensor B = isotropic(young = 10, poisson = 0.3)
space V = vector P2 on tube, periodic.x low = high, zero.y on low, zero.y on high
find u in V such that for all v in V
    integral(tube, B : eps(u) : eps(v)) = integral(bore, -1*v.nu)
report
  table wide = u.x at [1, 0], end = u.x at [2, L]
"""
    run(folder, text)
    # Lame, plane strain, p = 1, a = 1, b = 2: u(r) = (1 + nu)/E p a^2/(b^2 - a^2) ((1 - 2 nu) r + b^2/r)
    u = lambda r: 1.3 / 10 / 3 * (0.4 * r + 4 / r)
    row = table(folder)[0]
    assert abs(row["wide"] - u(1)) < 2e-3 * u(1) and abs(row["end"] - u(2)) < 2e-3 * u(2), (row, u(1), u(2))
    said = run(folder, text.replace("periodic.x low = high", "periodic.x bore = outside").replace("part low", "part outside = tube.right\npart low"), fails=True)
    assert "lie above each other" in said, said



def unlike(folder):
    """Parts of different sizes, and of the same size with other nodes, are told as what they are."""
    text = """mesh lower = rectangle({wide}, 1, cells = [4, 2])
mesh upper = rectangle(1, 1, cells = [2, 2], at = [0, 2])
mesh both = lower + upper
part low = lower.bottom
part high = upper.top
part feet = upper.bottom + lower.top
space V = scalar P1 on both, zero on feet, periodic low = high
find u in V such that for all v in V
    integral(lower, dot(grad(u), grad(v))) + integral(upper, dot(grad(u), grad(v))) = integral(both, v)
report table a = u at [0.5, 0]
"""
    for wide, words in ((1.25, "the periodic parts differ in size"), (1, "the first part has 5 nodes, the second one 3")):
        said = run(folder, text.format(wide=wide), fails=True)
        assert "E0423" in said and words in said, said


def routes(folder):
    """Every way to the memory, and a kernel that ages."""
    parts = dict(next(parts for name, parts in cells() if name == "P2, memory"))
    for kernel in ("kernel C(lag) = -0.6*exp(-lag/0.4) - 0.1*lag^0.5", "kernel C(t, s) = -0.5*exp(s - t)/(1 + s)"):
        found = []
        for start, options in (("", []), ("", ["--full"]), (" using memory = direct", []), (" using memory = tree", [])):
            text = CELL.format(**{**parts, "start": start}).replace("(1 - worn)*", "")
            text = text[:text.index("kernel C")] + kernel + text[text.index("\nsuperpotential wall"):]
            run(folder, text, "-D", "N=24", *options)
            found.append(table(folder)[-1])
        for other in found[1:]:
            assert all(abs(found[0][k] - other[k]) < 1e-7 * (1 + abs(other[k])) for k in other), (kernel, found)


def resumed(folder):
    parts = dict(next(parts for name, parts in cells() if name == "contact and friction"))
    text = CELL.format(**parts).replace("(1 - worn)*", "")
    run(folder, text, "-D", "N=12")
    whole = table(folder)
    run(folder, text, "-D", "N=6", "-D", "T=0.5", "--checkpoint", "3")
    run(folder, text, "-D", "N=12", "--checkpoint", "3", "--resume")
    again = table(folder)
    assert len(again) == len(whole) == 12 and all(abs(p[k] - q[k]) < 1e-11 for p, q in zip(whole, again) for k in p), (whole, again)


def layers(folder):
    """A cell of two layers across x, stretched by the mean strain 1: the stress is the harmonic mean of lambda + 2 mu."""
    text = """mesh cell = rectangle(1, 0.5, cells = [8, 4])
part left = cell.left
part right = cell.right
part bottom = cell.bottom
part top = cell.top
part hard = cell where x < 0.25
part soft = cell - hard
tensor B = isotropic(lambda = 1, mu = 1)
fn k() = | inside(hard) -> 10 | otherwise -> 1
space V = vector P1 on cell, periodic left = right, periodic bottom = top, zero on corner
part corner = point(cell, [0, 0])
find u in V such that for all v in V
    integral(cell, k()*B : eps(u) : eps(v)) = integral(cell, -k()*(3*eps(v).xx + eps(v).yy))
report
  table stretch = integral(cell, k()*(3*(1 + eps(u).xx) + eps(u).yy))/0.5, across = u.y at [0.5, 0.25], held = reaction(corner)
"""
    run(folder, text)
    row = table(folder)[0]
    mean = 1 / (0.25 / 30 + 0.75 / 3)
    assert abs(row["stretch"] - mean) < 1e-10, (row, mean)
    assert max(abs(row["across"]), abs(row["held_x"]), abs(row["held_y"])) < 1e-10, row


def free_motions(folder):
    text = CELL.format(**dict(next(parts for name, parts in cells() if name == "a stiffness that changes"))).replace("(1 - worn)*", "")
    said = run(folder, text.replace(", zero on roof", ""), fails=True)
    assert "E0425" in said and "along x" in said and "along y" in said and "turn" not in said, said
    # A law on the ground holds it along y; friction along x.
    held = text.replace(", zero on roof", "").replace(">= integral(body, sin(3*t)*dot(push(), v))",
                                                      "+ integral(ground, wall^0(u.nu; v.nu) + rub^0(u.tau; v.tau)) >= integral(body, dot([0.2*sin(6.2831853071795862*x), -4], v))")
    held = held.replace("A : eps(u') : eps(v)) + integral(body, (1 + t)*", "")
    held = held.replace("for t in [0, T] by N steps from u = 0", "")
    said = run(folder, held, command="check")
    assert "rigid" in said, said
    run(folder, held)


def mixed(folder):
    """Two unknowns: only one repeats, or both; P1 beside P2."""
    for repeats in ("", ", periodic left = right"):
        text = f"""mesh body = rectangle(1, 1, cells = [8, 8])
part left = body.left
part right = body.right
part ends = body.bottom + body.top
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential wall(s) with slope | s < 0.05 -> 0.4*s | otherwise -> 0.02
space V = vector P2 on body, zero on ends, periodic left = right
space W = scalar P1 on body, zero on ends{repeats}
find u in V, theta in W for t in [0, 1] by 4 steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(body, B : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) - integral(body, 0.6*theta*div(v))
  + integral(body, theta'*eta) + integral(body, dot(grad(theta), grad(eta))) + integral(body, [1, 0].x*grad(theta).x*eta)
  + integral(left, wall^0(theta; eta))
 >= integral(body, dot([1, -sin(6*x)], v)) + integral(body, 10*sin(3*x)*eta)
report
  table lu = u.x at [0, 0.5], ru = u.x at [1, 0.5], lt = theta at [0, 0.5], rt = theta at [1, 0.5]
""".replace("[1, 0].x*", "")
        run(folder, text)
        row = table(folder)[-1]
        assert row["lu"] == row["ru"] and (row["lt"] == row["rt"]) == bool(repeats), row
        names = ["periodic `left` = `right` of `u`", *(["periodic `left` = `right` of `theta`"] if repeats else [])]
        told(folder, text, [(name, f"moved by (1, 0); {n} nodes repeat others") for name, n in zip(names, (17, 9))])


def told(folder, text, wanted):
    """`plan`, the result, `check` and both pages say which parts repeat, by which way, how many nodes; nothing where none do."""
    run(folder, text, "--json", str(folder / "run.json"), "--report")
    notes = [e for e in json.loads((folder / "run.json").read_text())["plan"]["effects"] if e["name"].startswith("periodic")]
    assert [(e["name"], e["state"], e["why"]) for e in notes] == [(name, "on", why) for name, why in wanted], notes
    lines = [i for i, words in enumerate(text.split("\n"), 1) for _ in range(words.count("periodic"))]
    assert [e["line"] for e in notes] == lines, (notes, lines)
    page = (folder / "out" / "scene_report.html").read_text()
    said = run(folder, text, "--report", "-o", str(folder / "out"), "--json", str(folder / "check.json"), command="check")
    rows = [h for h in json.loads((folder / "check.json").read_text())["hypotheses"] if h["name"] == "V"]
    assert [(h["bound"], h["holds"], h["note"]) for h in rows] == [(name, True, why) for name, why in wanted], rows
    checked = (folder / "out" / "scene_report.html").read_text()
    plan = run(folder, text, command="plan")
    for (name, why), line in zip(wanted, lines):
        for place in (page, checked):
            assert name in place and why in place, name
        assert name in said and why in said and f"{name}, line {line}: {why}" in plan, (said, plan)
    assert wanted or not any("nodes repeat others" in place for place in (page, checked, said, plan))


def components(folder):
    """One component; the other way round; none."""
    text = """mesh body = box(2, 1, 3, cells = [2, 2, 3])
part left = body.left
part right = body.right
part back = body.back
part front = body.front
part ends = body.bottom
tensor B = isotropic(young = 10, poisson = 0.3)
space V = vector P1 on body, zero on ends{periodic}
find u in V such that for all v in V integral(body, B : eps(u) : eps(v)) = integral(body, dot([z, x*z, 1 + x*z^2], v))
report
  table bx = u.x at [1, 1, 0], by = u.y at [1, 1, 0], bz = u.z at [1, 1, 0], fx = u.x at [1, 1, 3], fy = u.y at [1, 1, 3], fz = u.z at [1, 1, 3]
"""
    for repeats in ("", "x", "y", "z", "xyz"):
        run(folder, text.format(periodic=f", periodic{'.' + repeats if len(repeats) == 1 else ''} back = front" if repeats else ""))
        row, = table(folder)
        assert "".join(c for c in "xyz" if row[f"b{c}"] == row[f"f{c}"]) == repeats, (repeats, row)
    told(folder, text.format(periodic=", periodic.z back = front"), [("periodic.z `back` = `front`", "moved by (0, 0, 3); 9 nodes repeat others")])
    told(folder, text.format(periodic=", periodic right = left"), [("periodic `right` = `left`", "moved by (-2, 0, 0); 12 nodes repeat others")])
    told(folder, text.format(periodic=""), [])


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for check in (layers, revolution, unlike, one_and_two, routes, resumed, free_motions, mixed, components, orders):
            check(folder)
            print(f"{check.__name__}: ok")


main()
