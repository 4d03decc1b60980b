"""Random whole scripts with units: each is written in mm, N and s, in SI units, in a system of inches, and with a unit drawn anew for every
quantity; converted, their answers agree to rounding. Then one unit is made wrong, or left out, at a random place, which the program must find.

usage: units_family.py HVI_RUN [SCRIPTS [SEED]]
A wrong unit of a literal that stands in its place (a length of a mesh, a time, a point, a sum) is underlined itself. One that travels by a
name (a parameter, a law, a kernel) shows where the name meets something else: the message's places must be on a line that the name reaches.
"""
import concurrent.futures
import fractions
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1]
SCRIPTS = int(sys.argv[2]) if len(sys.argv) > 2 else 10
SEED = int(sys.argv[3]) if len(sys.argv) > 3 else 2024
ROUNDING = 2e-9  # of conditions up to some 1e6: lengths in inches are other binary numbers than those in metres

INCH, POUND, FORCE = 0.0254, 0.45359237, 4.4482216152605
#        powers of m, kg, s, K, and how many of the SI's it is
UNITS = {"m": ((1, 0, 0, 0), 1.0), "mm": ((1, 0, 0, 0), 1e-3), "cm": ((1, 0, 0, 0), 1e-2), "um": ((1, 0, 0, 0), 1e-6), "inch": ((1, 0, 0, 0), INCH),
         "kg": ((0, 1, 0, 0), 1.0), "t": ((0, 1, 0, 0), 1e3), "g": ((0, 1, 0, 0), 1e-3), "s": ((0, 0, 1, 0), 1.0), "ms": ((0, 0, 1, 0), 1e-3),
         "min": ((0, 0, 1, 0), 60.0), "N": ((1, 1, -2, 0), 1.0), "kN": ((1, 1, -2, 0), 1e3), "lbf": ((1, 1, -2, 0), FORCE), "lb": ((0, 1, 0, 0), POUND),
         "Pa": ((-1, 1, -2, 0), 1.0), "kPa": ((-1, 1, -2, 0), 1e3), "MPa": ((-1, 1, -2, 0), 1e6), "GPa": ((-1, 1, -2, 0), 1e9), "bar": ((-1, 1, -2, 0), 1e5),
         "psi": ((-1, 1, -2, 0), FORCE / INCH**2), "J": ((2, 1, -2, 0), 1.0), "mJ": ((2, 1, -2, 0), 1e-3), "W": ((2, 1, -3, 0), 1.0), "mW": ((2, 1, -3, 0), 1e-3), "K": ((0, 0, 0, 1), 1.0)}
PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 0.1, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
#                       in SI          mm, N, s          inches             others that fit
KINDS = {"length": (["m"], ["mm"], ["inch"], ["cm", "um"]), "time": (["s"], ["s"], ["s"], ["ms", "min"]), "pressure": (["Pa"], ["MPa", "N/mm^2"], ["psi", "lbf/inch^2"], ["GPa", "bar", "kPa"]),
         "viscosity": (["Pa*s"], ["MPa*s"], ["psi*s"], ["bar*min", "GPa*ms"]), "stiffness": (["Pa/m", "N/m^3"], ["N/mm^3", "MPa/mm"], ["psi/inch"], ["kPa/mm", "GPa/cm"]),
         "weight": (["N/m^3"], ["N/mm^3"], ["lbf/inch^3"], ["kN/m^3", "MPa/cm"]), "density": (["kg/m^3"], ["t/mm^3", "N*s^2/mm^4"], ["lbf*s^2/inch^4"], ["g/cm^3", "lb/inch^3"]),
         "acceleration": (["m/s^2", "N/kg"], ["mm/s^2"], ["inch/s^2"], ["cm/s^2", "um/ms^2"]), "speed": (["m/s"], ["mm/s"], ["inch/s"], ["um/ms", "cm/min"]), "rate": (["1/s"], ["1/s"], ["1/s"], ["1/min", "1/ms"]),
         "wear": (["1/Pa"], ["mm^2/N"], ["1/psi"], ["1/bar"]), "per length": (["1/m"], ["1/mm"], ["1/inch"], ["1/um"]), "number": ([""], [""], [""], [""]),
         "temperature": (["K"], ["K"], ["K"], ["K"]), "per temperature": (["1/K"], ["1/K"], ["1/K"], ["1/K"]), "conductivity": (["W/(m*K)"], ["N/(s*K)"], ["lbf/(s*K)"], ["mW/(mm*K)"]),
         "drag": (["Pa*s/m"], ["N*s/mm^3"], ["psi*s/inch"], ["bar*s/cm"])}
SYSTEMS = ("units SI\n", "units mm, N, s\n", "units inch, lbf, s\n", "units cm, kN, s\n")
failures = []


def unit(text):
    """Powers of m, kg, s, K and the value: products and quotients, one parenthesis behind a slash."""
    text, dims, size = re.sub(r"/\(([^)]*)\)", lambda m: "/" + m[1].replace("*", "/"), text or "1"), [0.0] * 4, 1.0
    for sign, name, power in re.findall(r"([*/]?)([A-Za-z]+|1)(?:\^(\(-?\d+/\d+\)|-?\d+))?", text):
        if name == "1":
            continue
        p = float(fractions.Fraction(power.strip("()"))) if power else 1.0
        p = -p if sign == "/" else p
        of, value = UNITS[name] if name in UNITS else (UNITS[name[1:]][0], UNITS[name[1:]][1] * PREFIXES[name[0]])
        dims, size = [d + p * o for d, o in zip(dims, of)], size * value**p
    return tuple(round(d, 6) for d in dims), size


assert unit("W/(m*K)") == ((1, 1, -3, -1), 1.0) and unit("1/s")[0] == (0, 0, -1, 0) and abs(unit("N*s^2/mm^4")[1] - 1e12) < 1
for kind, choices in KINDS.items():
    assert len({unit(u)[0] for column in choices for u in column}) == 1, kind


class Quantity:
    """A literal: its value in the SI and what it measures."""

    def __init__(self, value, kind, typed=False):
        self.value, self.kind, self.typed = value, kind, typed

    def text(self, name):
        return f"{self.value / unit(name)[1]!r} [{name}]" if name else repr(self.value)


def script(rng):
    """Lines of texts and quantities."""
    q = lambda value, kind, typed=False: Quantity(value, kind, typed)
    some = lambda low, high: round(rng.uniform(low, high), 3)
    here = lambda value: q(value, "length", True)
    dim = rng.choice([2, 2, 2, 3])
    ring = dim == 2 and rng.random() < 0.2
    wide, high, deep, end = some(0.5, 2), some(0.3, 1), some(0.4, 1), some(1, 20)
    modulus, lines, terms, loads, columns = some(1, 200) * 1e9, [], [], [], []
    moves, slow, remembers = rng.random() < 0.2, rng.random() < 0.4, rng.random() < 0.4
    lines += [["import contact"], ["import friction"], ["import states"], ["import materials"], ["import loads"]]
    lines.append(["param E = ", q(modulus, "pressure"), " in [", q(modulus / 10, "pressure", True), ", ", q(modulus * 10, "pressure", True), "] \"modulus\""])
    lines.append(["param ratio = ", q(some(0.1, 0.4), "number")])
    lines.append(["param T = ", q(end, "time")])
    size = [here(wide), ", ", here(high)] + ([", ", here(deep)] if dim == 3 else [])
    cells = "[3, 2]" if dim == 2 else "[2, 2, 2]"
    lines.append(["mesh body = ", "rectangle(" if dim == 2 else "box("] + size + [f", cells = {cells}" + (", axisymmetric = true" if ring else "") + ")"])
    for part, of in (("roof", "top"), ("ground", "bottom"), ("side", "right")):
        lines.append([f"part {part} = body.{of}"])
    lines.append(["part middle = body where x > ", here(0.4 * wide), " and y < ", here(2 * high)])
    solid = ["tensor B = isotropic(young = E, poisson = ratio)", "tensor B = young_poisson(E, ratio)", "tensor B = bulk_shear(0.8*E, 0.4*E)", None]
    chosen = rng.choice(solid)
    lines.append([chosen] if chosen else ["tensor B = isotropic(lambda = ", q(modulus / 2, "pressure"), ", mu = ", q(modulus / 3, "pressure", True), ")"])
    terms.append(["integral(body, B : eps(u) : eps(v))"])
    if slow:
        lines.append(["tensor A = isotropic(lambda = ", q(0.1 * modulus * end, "viscosity"), ", mu = ", q(0.2 * modulus * end, "viscosity", True), ")"])
        terms.append(["integral(body, A : eps(u') : eps(v))"])
    if remembers:
        tau, share = some(0.2, 2) * end, some(0.05, 0.3)
        kernels = [["-", q(share / tau, "rate"), "*exp(-lag/(", q(tau, "time"), "))*B"], [f"standard_linear_solid(lag, {share}, ", q(tau, "time"), ")*B"],
                   [f"prony_relaxation(weights = [{share}], times = [", q(tau, "time", True), "])*B"], [f"-{share}*T/(T + lag)^2*B"]]
        lines.append(["kernel C(lag) = "] + rng.choice(kernels))
        terms.append(["integral(body, history(C, eps(u)) : eps(v))"])
    if moves:
        lines.append(["param rho = ", q(some(1e3, 8e3), "density")])
        terms.append(["integral(body, rho*dot(u'', v))"])
    push = modulus * 1e-4 * some(0.5, 2)
    stiff, gap = modulus / high * some(0.05, 0.5), high * 1e-5 * some(0.1, 1)
    normal = [["normal_compliance(r, stiffness = ", q(stiff, "stiffness"), ", power = 1)"], ["winkler(r, stiffness = ", q(stiff, "stiffness"), ")"],
              ["bounded_compliance(r, stiffness = ", q(stiff, "stiffness"), ", bound = ", q(push, "pressure"), ")"], ["unilateral(r, gap = ", q(gap, "length"), ")"]]
    lines.append(["superpotential layer(r) = "] + rng.choice(normal) if rng.random() < 0.8 else
                 ["superpotential layer(r) with slope | r < ", q(gap, "length"), " -> 0 | otherwise -> ", q(stiff, "stiffness"), "*(r - ", q(gap, "length", True), ")"])
    terms.append(["integral(ground, layer^0(u.nu; v.nu))"])
    rubs = rng.random() < 0.5 and not moves
    if rubs:
        bound = push / 10
        laws = [["tresca(xi, bound = ", q(bound, "pressure"), ")"], ["bounded_friction(xi, bound = ", q(bound, "pressure"), ", range = ", q(wide * 1e-4, "length"), ")"]]
        lines.append(["superpotential slip(xi) = "] + rng.choice(laws))
        terms.append(["integral(ground, slip^0(u.tau; v.tau))"])
    elif rng.random() < 0.4:
        lines.append(["superpotential drag(w) = ", q(modulus * end / wide * 1e-2, "drag"), "/2*norm(w)^2"])
        terms.append(["integral(ground, drag^0(u'.tau; v.tau))"])
    if rng.random() < 0.3:
        lines.append(["state worn on ground with rate archard(layer.xi, u'.tau, coefficient = ", q(1e-4 / push, "wear"), ") from worn = ", q(wide * 1e-6, "length")])
        columns.append(["w = worn at [", here(wide), ", ", here(0.0)] + ([", ", here(deep)] if dim == 3 else []) + ["]"])
    zero, down = "0, " * (dim - 2), "dot([0, -{}" + ", 0" * (dim - 2) + "], v)"
    loads.append(["integral(body, dot([0, -", q(some(1e3, 8e3), "density"), "*", q(9.81, "acceleration")] + [", 0" * (dim - 2) + "], v))"]
                 if rng.random() < 0.5 else ["integral(body, dot([0, -", q(some(2e4, 8e4), "weight"), ", 0" * (dim - 2) + "], v))"])
    growth = rng.choice([["t/T"], ["ramp(t, T)"], ["ramp(t, ", q(end / 2, "time"), ")"], ["sin(t/(", q(end, "time"), "))"]])
    lines.append(["param push = ", q(push, "pressure")])
    loads.append(["integral(side, dot([push*"] + growth + [", 0" + ", 0" * (dim - 2) + "], v))"])
    lines.append(["space V = vector P1 on body, zero on roof"])
    start = " from u = 0, u' = 0" if moves else " from u = 0"
    held = [" with u.y = -", q(high * 1e-4, "length"), "*t/T on roof"] if rng.random() < 0.5 and not moves else []
    lines.append(["find u in V", *held, " for t in [", q(0.0, "time", True), ", ", q(end, "time", True), "] by 3 steps" + start])
    lines.append(["such that for all v in V"])
    for i, term in enumerate(terms):
        lines.append(["  + " if i else "    "] + term)
    for i, load in enumerate(loads):
        lines.append(["  + " if i else " >= "] + load)
    point = lambda *xs: ["["] + sum(([", "] * (i > 0) + [here(x)] for i, x in enumerate(xs)), []) + ["]"]
    corner = lambda: point(wide, 0.0, *([deep] if dim == 3 else []))
    inside = lambda: point(0.37 * wide, 0.61 * high, *([0.3 * deep] if dim == 3 else []))
    columns += [["tip = u.y at "] + corner(), ["p = layer.xi at "] + corner(), ["s = sigma.yy at "] + inside(), ["R = reaction(roof)"], ["F = integral(ground, layer.xi)"],
                ["e = eps(u).xy at "] + inside(), ["most = largest(middle, mises(sigma))"], ["sum = u.x + ", q(wide * 1e-6, "length", True), " at "] + corner(), ["work = integral(body, (sigma : eps(u)))"]]
    rng.shuffle(columns)
    lines.append(["report"])
    for i, column in enumerate(columns):
        lines.append(["  table "] + column)
    lines.append(["expect tip = ", q(0.0, "length", True), " within ", q(wide, "length", True), " \"it holds\""])
    return lines


def written(rng, lines, system, free, wrong=None):
    """The text, in units of the system or, with `free`, in any; `wrong`: this quantity in another dimension. Also its line and what stands there."""
    out, place = [], None
    for number, line in enumerate(lines):
        text = ""
        for piece in line:
            if isinstance(piece, str):
                text += piece
                continue
            choices = KINDS[piece.kind]
            name = rng.choice(sum(choices, []) if free else choices[system])
            one = piece.text(name)
            if piece is wrong:
                other = rng.choice([k for k in KINDS if unit(KINDS[k][0][0])[0] != unit(name)[0]])
                one = f"{piece.value / unit(name)[1]!r} [{rng.choice(sum(KINDS[other], []))}]" if rng.random() < 0.75 or not name else repr(piece.value / unit(name)[1])
                one = one.replace(" []", "")
                place = (number, len(text), one)
            text += one
        out.append(text)
    return out, place


def answer(name, text):
    """Columns in the SI; a text where there are none."""
    path = FOLDER / name
    path.mkdir()
    (path / "s.hvi").write_text(text)
    done = subprocess.run([PROGRAM, "run", "--quiet", "--no-files", "--json", "out.json", "s.hvi"], cwd=path, capture_output=True, text=True)
    if done.returncode != 0:
        return done.stderr
    result = json.loads((path / "out.json").read_text())
    return {column: [v * unit(result["units"][column])[1] for v in values if v is not None] for column, values in result["table"].items() if column in result["units"]}


def differ(name, reference, other):
    """The largest difference of a column by its largest number. Zeros of one are rounding of the other: against the largest of its kind."""
    worst = (0.0, "")
    if set(reference) != set(other):
        return f"{name}: columns {set(reference) ^ set(other)}"
    for column, values in reference.items():
        family = [c for c in reference if c.startswith("R_")] if column.startswith("R_") else [column]
        size = max(max(map(abs, reference[c]), default=0.0) for c in family) or 1.0
        off = max(abs(a - b) / size for a, b in zip(values, other[column]))
        worst = max(worst, (off, column))
    return f"{name}: {worst[1]} differs by {worst[0]:.1e}" if worst[0] > ROUNDING else None


def reached(lines, number):
    """Lines that a name declared on this line reaches, by other names, too."""
    found, names = {number}, set()
    declared = lambda line: (re.match(r"(?:param|tensor|kernel|superpotential|fn|state|mesh|part) (\w+)", line) or [None, None])[1]
    names.add(declared(lines[number]))
    if lines[number].startswith("find"):  # of u, whose lines are all others
        names.add("u")
    for _ in range(4):
        for i, line in enumerate(lines):
            if any(name and re.search(rf"\b{name}\b", line) for name in names):
                found.add(i)
                names.add(declared(line))
    return found


def found(name, lines, place, quantity):
    """Is a wrong unit told at its place?"""
    path = FOLDER / name
    path.mkdir()
    (path / "s.hvi").write_text("\n".join(lines) + "\n")
    done = subprocess.run([PROGRAM, "check", "--diagnostics", "json", "s.hvi"], cwd=path, capture_output=True, text=True)
    rows = [json.loads(row) for row in done.stderr.splitlines() if row.startswith("{")]
    errors = [r for r in rows if r["severity"] == "error"]
    number, column, text = place
    said = [(r["code"], r["line"], r["message"]) for r in errors]
    # A value that its unit has made impossible (a Poisson's ratio of 3) is told before units are compared.
    codes = ("E0331", "E0332") + (() if quantity.typed else ("E0504",))
    if not errors or any(r["code"] not in codes for r in errors):
        return f"{name}: `{text}` on line {number + 1}: told {said or done.stdout[-200:]}"
    spans = [(s["line"] - 1, s["column"] - 1, s["end_column"] - 1) for r in errors for s in (r, *r["secondary"]) if s["file"].endswith("s.hvi")]
    if quantity.typed:
        inside = any(line == number and begin < column + len(text) and end > column for line, begin, end in spans)
        return None if inside and len(errors) == 1 else f"{name}: `{text}` on line {number + 1} is not underlined: {said}"
    near = reached(lines, number)
    return None if any(line in near for line, *_ in spans) else f"{name}: `{text}` on line {number + 1} reaches {sorted(n + 1 for n in near)}: {said}"


def one(index):
    rng = random.Random(SEED * 1000 + index)
    lines = script(rng)
    texts = {"mm": (1, False), "SI": (0, False), "inches": (2, False), "mixed": (rng.choice([0, 1, 3]), True)}
    answers = {}
    for name, (system, free) in texts.items():
        text, _ = written(rng, lines, min(system, 2), free)
        answers[name] = answer(f"{index}_{name}", SYSTEMS[system] + "\n".join(text) + "\n")
        if isinstance(answers[name], str):
            return [f"{index}, {name}: {answers[name]}\n" + SYSTEMS[system] + "\n".join(text)], 0
    problems = [differ(f"{index}, {name}", answers["mm"], answers[name]) for name in texts if name != "mm"]
    text, _ = written(rng, lines, 0, False)
    idle = lambda i: text[i].startswith("param") and len(reached(text, i)) == 1  # a number that nobody uses has any unit
    literals = [p for i, line in enumerate(lines) for p in line if isinstance(p, Quantity) and p.value != 0 and not (idle(i) and not p.typed)]
    wrong = rng.choice(literals)
    text, place = written(rng, lines, rng.choice([0, 1, 2]), rng.random() < 0.5, wrong)
    problems.append(found(f"{index}_wrong", ["units mm, N, s"] + text, (place[0] + 1, *place[1:]), wrong))
    return [p for p in problems if p], wrong.typed


with tempfile.TemporaryDirectory() as place_of_runs:
    FOLDER = pathlib.Path(place_of_runs)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        outcomes = list(pool.map(one, range(SCRIPTS)))
failures = [p for problems, _ in outcomes for p in problems]
print(f"{SCRIPTS} scripts in four ways, {SCRIPTS} wrong units, {sum(bool(t) for _, t in outcomes)} of them where their place is known to the letter; {len(failures)} failures")
for failure in failures:
    print(failure)
sys.exit(bool(failures))
