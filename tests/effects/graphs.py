#!/usr/bin/env python3
"""graphs.py HVI_RUN: what is drawn is what is computed.

The curves of `picture LAW, KERNEL to "NAME.svg"`, read back from the file by its axes, against the laws and kernels written once more here: pieces,
jumps as vertical lines, walls, bounds that change in time, sums with parameters, laws that begin at zero, kernels against the lag; random ones, too.
"""
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

HVI_RUN = sys.argv[1]
SCENE = """mesh m = interval(1, cells = 4)
part l = m.left
part r = m.right
{declarations}
space W = scalar P1 on m, zero on l
find p in W for t in [{begin}, {end}] by 4 steps from p = 0 such that for all q in W
    integral(m, dot(grad(p'), grad(q))) + integral(m, dot(grad(p), grad(q))){terms}
 >= integral(m, 0.01*t*q)
report
  table a = p at [1]
  picture {names} to "graphs.svg"
"""
SVG = "{http://www.w3.org/2000/svg}"


def spots(line):
    return [tuple(map(float, pair.split(","))) for pair in line.get("points").split()]


def panels(path):
    """By panel its title and its curve in the units of its axes."""
    root = xml.etree.ElementTree.parse(path).getroot()
    out, last = [], None
    for mark in root:
        if mark.tag == SVG + "text" and mark.get("font-size") == "15" and mark.get("text-anchor") == "start":
            out.append({"title": mark.text, "x": [], "y": [], "curve": None})
        if mark.tag == SVG + "polyline":
            if mark.get("stroke") not in ("#dbdbdb", "#000000"):
                out[-1]["curve"] = spots(mark)
            last = spots(mark)
        if mark.tag == SVG + "text" and mark.get("font-size") == "12" and last and len(last) == 2:
            try:
                number = float(mark.text.replace("\N{MINUS SIGN}", "-"))
            except ValueError:
                continue
            (x0, y0), (x1, y1) = last
            if x0 == x1:
                out[-1]["x"].append((x0, number))
            elif y0 == y1:
                out[-1]["y"].append((y0, number))
    for panel in out:
        along, up = (scale(panel[axis]) for axis in "xy")
        panel["curve"] = [(along(x), up(y)) for x, y in panel["curve"]]
        panel["pixel"] = abs(along(1) - along(0)), abs(up(1) - up(0))
    return out


def scale(ticks):
    """Of pixels the numbers of an axis; all its ticks are on one line."""
    assert len(ticks) >= 2, ticks
    (p, a), (q, b) = ticks[0], ticks[-1]
    to = lambda pixel: a + (pixel - p) * (b - a) / (q - p)
    for pixel, number in ticks:
        assert abs(to(pixel) - number) <= 2e-2 * abs(b - a) / max(1, len(ticks) - 1), ticks
    return to


def picture(declarations, terms, names, begin=0, end=1):
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "scene.hvi").write_text(SCENE.format(declarations=declarations, terms=terms, names=names, begin=begin, end=end))
        done = subprocess.run([HVI_RUN, "scene.hvi", "--quiet", "-o", "out"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return panels(folder / "out" / "graphs.svg")


def check_law(panel, slope, jumps=(), walls=()):
    """slope(r) between the jumps: (place, left, right); walls: where it goes without bound, drawn up to 1.25 of the rest."""
    dx, dy = panel["pixel"]
    curve = panel["curve"]
    places = [at for at, *_ in jumps] + list(walls)
    checked = 0
    for r, value in curve:
        if any(abs(r - at) < 1.5 * dx for at in places):
            continue
        steep = max(abs(slope(r + dx) - slope(r)), abs(slope(r - dx) - slope(r)))
        assert abs(value - slope(r)) <= 0.02 * dy + steep + 1e-12, (panel["title"], r, value, slope(r))
        checked += 1
    assert checked > 40, (panel["title"], checked)
    for at, left, right in jumps:
        pairs = [(a, b) for a, b in zip(curve, curve[1:]) if abs(a[0] - b[0]) < 0.02 * dx and abs(a[0] - at) < 0.6 * dx and abs(a[1] - b[1]) > dy]
        assert len(pairs) == 1, (panel["title"], at, pairs)  # one vertical line, from the one value to the other
        (_, low), (_, high) = pairs[0]
        assert abs(low - left) < dy and abs(high - right) < dy, (panel["title"], at, pairs, left, right)
    for at in walls:
        finite = abs(slope(at - 1e-9)) or 1.0
        assert max(r for r, _ in curve) < at + dx, panel["title"]  # the graph ends there
        top = max(v for r, v in curve if abs(r - at) < dx)
        assert abs(top - 1.25 * finite) < 1.5 * dy, (panel["title"], top, finite)


def chosen():
    declarations = """superpotential layer(r) with slope
  | r < 0 -> 0
  | r < 0.02 -> 100*r
  | r < 0.05 -> -1 - 20*(r - 0.02)
  | otherwise -> 3
superpotential rub(w) = (0.4 + 0.2*t)*norm(w) + 0.3*exp(-norm(w))
superpotential bent(r, k = 2) = k*r^4 + 0.5*k*pos(r - 0.3)^2
superpotential twice(r) = bent(r, k = 3)
superpotential wall(r) with slope | r < 0.5 -> 2*pos(r) | otherwise -> 1e300
kernel C(lag) = -exp(-lag/0.3)/0.3
kernel D(t, s) = sin(t)*exp(s - t)
kernel E(lag) = -2.5*exp(-lag/0.7)
kernel F(lag) = 0.5*exp(-lag/0.7)
"""
    terms = (" + integral(m, history(C, grad(p)).x*grad(q).x) + integral(m, history(D, grad(p)).x*grad(q).x) + integral(m, 0.01*history(E, p)*q + 0.01*history(F, p)*q)"
             " + integral(r, layer^0(p; q) + twice^0(p; q) + wall^0(p; q))")
    found = {p["title"]: p for p in picture(declarations, terms, "layer, twice, wall, C, D, E, F", end=2)}
    assert list(found) == ["layer", "twice", "wall", "C", "D", "E", "F"], list(found)

    def layer(r):
        return 0 if r < 0 else 100 * r if r < 0.02 else -1 - 20 * (r - 0.02) if r < 0.05 else 3
    check_law(found["layer"], layer, [(0.02, 2, -1), (0.05, -1.6, 3)])
    check_law(found["twice"], lambda r: 12 * r**3 + 3 * max(r - 0.3, 0))
    check_law(found["wall"], lambda r: 2 * max(r, 0), walls=[0.5])
    kernels(found["C"], lambda lag: -math.exp(-lag / 0.3) / 0.3, 2)
    kernels(found["D"], lambda lag: math.sin(2) * math.exp(-lag), 2)
    kernels(found["E"], lambda lag: -2.5 * math.exp(-lag / 0.7), 2)
    kernels(found["F"], lambda lag: 0.5 * math.exp(-lag / 0.7), 2)  # one memory with E's
    with_vector = SCENE.replace("mesh m = interval(1, cells = 4)", "mesh m = rectangle(1, 1, cells = [2, 2])").replace("scalar", "vector") \
        .replace("dot(grad(p'), grad(q))", "A : eps(p') : eps(q)").replace("dot(grad(p), grad(q))", "A : eps(p) : eps(q)").replace("0.01*t*q", "0.01*t*q.x") \
        .replace("p at [1]", "p.x at [1, 1]").replace("{declarations}", "tensor A = isotropic(lambda = 1, mu = 1)\n{declarations}")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "scene.hvi").write_text(with_vector.format(declarations="superpotential rub(w) with slope 0.4 + 0.2*t + 0.3*exp(-3*norm(w))", terms=" + integral(r, rub^0(p.tau; q.tau))",
                                                             names="rub", begin=0, end=2))
        done = subprocess.run([HVI_RUN, "scene.hvi", "--quiet", "-o", "out"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        (rub,) = panels(folder / "out" / "graphs.svg")
    assert rub["curve"][0] == min(rub["curve"]) and abs(rub["curve"][0][0]) < rub["pixel"][0]
    check_law(rub, lambda w: 0.8 + 0.3 * math.exp(-3 * w), [(0, 0, 1.1)])  # at the end, t = 2


def tensors():
    """A kernel that is a tensor: its factor of time as a curve, and beside its name the constants that it is times of."""
    scene = """mesh m = rectangle(1, 1, cells = [2, 2])
part l = m.left
tensor A = isotropic(lambda = 1, mu = 2)
tensor B = isotropic(young = 70, poisson = 0.3)
tensor O = orthotropic(young = [3, 1, 1], poisson = [0.1, 0.1, 0.1], shear = [1, 1, 0.5])
kernel C(lag) = -3*exp(-lag/0.3) * B
kernel D(lag) = cos(lag) * O
kernel F(t, s) = exp(s - t)*A + exp(s - t)*O
space V = vector P1 on m, zero on l
find u in V for t in [0, 2] by 4 steps from u = 0 such that for all v in V
    integral(m, B : eps(u) : eps(v)) + 0.01*integral(m, history({kernel}, eps(u)) : eps(v)) >= integral(m, 0.01*t*v.x)
report
  table a = u.x at [1, 1]
  picture {kernel} to "graphs.svg"
"""
    lame = 70 * 0.3 / (1.3 * 0.4), 70 / 2.6
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        found = {}
        for kernel in "CDF":
            (folder / "scene.hvi").write_text(scene.replace("{kernel}", kernel))
            done = subprocess.run([HVI_RUN, "scene.hvi", "--quiet", "-o", "out"], cwd=folder, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            (found[kernel],) = panels(folder / "out" / "graphs.svg")
    assert re.fullmatch(r"C = q isotropic\(\u03bb = \S+, \u03bc = \S+\)", found["C"]["title"]), found["C"]["title"]
    number = r"([-+.e\d]+)"
    constants = {kernel: {k: float(v) for k, v in dict(re.findall(r"(\w+) = " + number, panel["title"])).items()} for kernel, panel in found.items()}
    assert list(constants["D"])[:2] == ["xxxx", "xxyy"] and "xyxy" in constants["D"], found["D"]["title"]

    def of_kernel(kernel, entry, value):
        kernels(found[kernel], lambda lag: value(lag) / constants[kernel][entry], 2, tolerance=1e-3)

    for entry, declared in zip(("\u03bb", "\u03bc"), lame):
        of_kernel("C", entry, lambda lag: -3 * math.exp(-lag / 0.3) * declared)
    of_kernel("D", "xyxy", lambda lag: math.cos(lag) * 1)
    of_kernel("F", "xyxy", lambda lag: math.exp(-lag) * 3)
    # Memories of K and of -K are one; each kernel has the sign that it was declared with, and its tensor's constants theirs.
    both = scene.replace("kernel C(lag) = -3*exp(-lag/0.3) * B", "kernel C(lag) = (3 - lag)*exp(-lag) * B").replace("cos(lag) * O", "-(3 - lag)*exp(-lag) * O")
    both = both.replace("0.01*integral(m, history({kernel}, eps(u)) : eps(v))",
                        "0.01*integral(m, history(C, eps(u)) : eps(v)) + 0.01*integral(m, history(D, eps(u)) : eps(v))")
    for kernel, sign in (("C", 1), ("D", -1)):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            (folder / "scene.hvi").write_text(both.replace("{kernel}", kernel))
            done = subprocess.run([HVI_RUN, "scene.hvi", "--quiet", "-o", "out"], cwd=folder, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            (panel,) = panels(folder / "out" / "graphs.svg")
        first = float(re.search(r"\w+ = " + number + r"[,)]", panel["title"].split("q ", 1)[1])[1])
        lag, q = min(panel["curve"])
        assert first > 0 and q * sign > 0 and lag < 0.1, (panel["title"], lag, q)


def kernels(panel, value, last, tolerance=0.0):
    dx, dy = panel["pixel"]
    assert abs(max(lag for lag, _ in panel["curve"]) - last) < dx and min(lag for lag, _ in panel["curve"]) > 0
    for lag, q in panel["curve"]:
        assert abs(q - value(lag)) <= 0.02 * dy + abs(value(lag + 0.02 * dx) - value(lag)) + tolerance * abs(q) + 1e-12, (panel["title"], lag, q, value(lag))


def drawn_at_random(scenes=12):
    for scene in range(scenes):
        rng = random.Random(scene)
        size = 10 ** rng.uniform(-6, 6)
        breaks = sorted(rng.uniform(-1, 2) for _ in range(rng.randint(1, 4)))
        if min((b - a for a, b in zip(breaks, breaks[1:])), default=1) < 0.15:
            continue
        pieces = [(rng.uniform(-2, 2), rng.uniform(-1, 3)) for _ in range(len(breaks) + 1)]
        height = 10 ** rng.uniform(-6, 6)
        slope_of = lambda r: next((a + b * r / size for (a, b), at in zip(pieces, breaks) if r < at * size), pieces[-1][0] + pieces[-1][1] * r / size) * height
        cases = [f"  | r < {at * size!r} -> {a * height!r} + {b * height / size!r}*r" for (a, b), at in zip(pieces, breaks)]
        a, b = pieces[-1]
        text = "superpotential any(r) with slope\n" + "\n".join([*cases, f"  | otherwise -> {a * height!r} + {b * height / size!r}*r"])
        (panel,) = picture(text, f" + 1e-30*integral(r, any^0(p; q))", "any")
        jumps = [(at * size, (pieces[i][0] + pieces[i][1] * at) * height, (pieces[i + 1][0] + pieces[i + 1][1] * at) * height) for i, at in enumerate(breaks)]
        dy = panel["pixel"][1]
        check_law(panel, slope_of, [j for j in jumps if abs(j[1] - j[2]) > 2 * dy])


chosen()
tensors()
drawn_at_random()
print("curves in pictures are those of the laws and kernels")
