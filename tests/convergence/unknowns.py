"""Several unknowns against closed forms, against runs of one unknown, and against themselves in other units.

usage: unknowns.py HVI_RUN [CHECK...]
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from turned import PROGRAM, below, close, judge, run, table


def tube():
    """An incompressible tube under pressure in an elastic soil: u = c/r. Its error in P2 is of order 3 at least."""
    errors = []
    for n in (4, 8):
        found = table(f"""
mesh tube = rectangle(1, 1, cells = [{n}, {n}], origin = [1, 0], axisymmetric = true)
part inner = tube.left
part outer = tube.right
part ends = tube.top + tube.bottom
superpotential soil(r) with slope | r < 0 -> 0 | otherwise -> 3*r
space V = vector P2 on tube, zero.y on ends
space Q = scalar P1 on tube
find u in V, p in Q
such that for all v in V, q in Q
    integral(tube, 2*(eps(u) : eps(v))) - integral(tube, p*div(v)) + integral(tube, q*div(u)) + integral(outer, soil^0(u.nu; v.nu))
 >= integral(inner, 1.5*v.x)
report
  table inside = u.x at [1, 0.5], outside = u.x at [2, 0.5], pressure = p at [1.5, 0.5]
""")
        # sigma_rr = -2 c/r^2 - p is -1.5 at r = 1 and -3 c/2, the soil's force, at r = 2: c = p = 0.5.
        errors.append(max(abs(found["inside"][-1] - 0.5), abs(found["outside"][-1] - 0.25), abs(found["pressure"][-1] - 0.5)))
    order = np.log2(errors[0] / errors[1])
    print(f"  errors {errors}, order {order:.2f}")
    assert order > 2.5 and errors[1] < 1e-4


BODY = """
mesh body = rectangle(1.5, 1, cells = [6, 4])
part held = body.left
part ground = body.bottom
part roof = body.top
tensor A = isotropic(young = 1, poisson = 0.3)
tensor B = isotropic(young = 10, poisson = 0.3)
kernel C(lag) = -0.3*exp(-lag)*B
kernel q(lag) = 0.5*exp(-2*lag)
superpotential layer(r) with slope | r < 0 -> 0 | r < 0.01 -> 20*r | otherwise -> 0.2
superpotential rub(w) = 0.05*norm(w)
superpotential wall(s) with slope | s < 0.2 -> 2*s | otherwise -> 0.4
"""
OF_U = """integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) + integral(body, history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu)) + integral(ground, rub^0(u'.tau; v.tau))"""
OF_P = """integral(body, 0.3*p'*s) + integral(body, dot(grad(p), grad(s))) + integral(body, dot(history(q, grad(p)), grad(s)))
  + integral(ground, wall^0(p; s))"""
LOAD_U, LOAD_P = "integral(body, dot([0.2, -0.5]*sin(3*t), v))", "integral(body, 3*t*s)"
COLUMNS_U = "a = u.y at [1.5, 0], b = u.x at [0.7, 0.3], c = integral(ground, layer.xi), d = norm(u)"
COLUMNS_P = "e = p at [0.7, 0.3], f = integral(ground, wall.xi), g = norm(p), h = integral(body, p)"
TIME = "for t in [0, 2] by 12 steps"


def apart():
    """Unknowns that no form couples are those of two runs, also with elements of different orders and coupled by a form times zero."""
    for scheme in ("backward_euler", "bdf2"):
        for element, other in (("P1", "P1"), ("P2", "P2"), ("P2", "P1"), ("P1", "P2")):
            spaces = f"space V = vector {element} on body, zero on held\n", f"space W = scalar {other} on body, zero on roof\n"
            using = f"using scheme = {scheme}"
            first = table(BODY + spaces[0] + f"find u in V {TIME} from u = 0 {using} such that for all v in V {OF_U} >= {LOAD_U}\nreport table {COLUMNS_U}")
            second = table(BODY + spaces[1] + f"find p in W {TIME} from p = 0 {using} such that for all s in W {OF_P} >= {LOAD_P}\nreport table {COLUMNS_P}")
            for coupling in ("", "+ integral(body, 1e-300*p*div(v))"):
                both = table(BODY + "".join(spaces) + f"find u in V, p in W {TIME} from u = 0, p = 0 {using} such that for all v in V, s in W "
                             f"{OF_U} + {OF_P} {coupling} >= {LOAD_U} + {LOAD_P}\nreport table {COLUMNS_U}, {COLUMNS_P}")
                for alone in (first, second):
                    for name in "abcdefgh":
                        if name in alone:
                            error = np.abs(both[name] - alone[name]).max() / np.abs(alone[name]).max()
                            assert error <= 1e-9, (scheme, element, other, coupling, name, error)
    print("  16 problems with two unknowns are two problems with one")


def units():
    """The unit of one unknown, and of its equation, change nothing but rounding."""
    reference = None
    random = np.random.default_rng(3)
    for k in range(6):
        p, row = (1.0, 1.0) if k == 0 else 10 ** random.uniform(-9, 9, 2)
        found = table(BODY.replace("s < 0.2 -> 2*s", f"s < {0.2 * p} -> {2 / p}*s") + f"""
space V = vector P2 on body, zero on held
space W = scalar P1 on body, zero on roof
find u in V, p in W {TIME} from u = 0, p = 0
such that for all v in V, s in W
    {OF_U} - integral(body, {0.4 / p}*p*div(v)) + integral(body, {0.3 * row / p}*p'*s) + integral(body, {row / p}*dot(grad(p), grad(s)))
  + integral(body, {0.6 * row}*div(u')*s) + {row} * integral(ground, wall^0(p; s))
 >= {LOAD_U} + integral(body, {3 * row}*t*s)
report table {COLUMNS_U}, e = p at [0.7, 0.3], f = integral(ground, wall.xi)""")
        found["e"] = found["e"] / p
        if reference is None:
            reference = found
            continue
        for name in "abcdef":
            below(np.abs(found[name] - reference[name]).max() / np.abs(reference[name]).max(), 1e-9, f"units {p:.1e}, {row:.1e}: {name}")


def resumed():
    """A run that goes on beyond its end has the bits of one to the later end."""
    script = BODY + f"""
param T = 2
param N = 12
space V = vector P2 on body, zero on held
space W = scalar P1 on body, zero on roof
find u in V, p in W for t in [0, T] by N steps from u = 0, p = 0
such that for all v in V, s in W
    {OF_U} - integral(body, 0.4*p*div(v)) + {OF_P} + integral(body, 0.6*div(u')*s)
 >= {LOAD_U} + {LOAD_P}
report table {COLUMNS_U}, {COLUMNS_P}"""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "a.hvi").write_text(script)

        def go(out, steps, *words):
            subprocess.run([PROGRAM, "run", "a.hvi", "--quiet", "-o", out, "-D", f"T={steps / 6}", "-D", f"N={steps}", "--checkpoint", "1", *words],
                           cwd=folder, check=True, capture_output=True)

        go("whole", 12)
        go("parts", 6)
        go("parts", 12, "--resume")
        whole, parts = ((folder / name / "a.csv").read_text() for name in ("whole", "parts"))
        assert whole == parts, "a resumed run has other bits"
    print("  the same bits")


def heat_between():
    """Two bars that touch: displacement and temperature both jump at the pair, which conducts by a law."""
    found = table("""
mesh first = rectangle(1, 1, cells = [4, 3])
mesh second = rectangle(1, 1, cells = [3, 5], at = [1, 0])
mesh both = first + second
part hot = first.left
part cold = second.right
part flanks = first.top + first.bottom + second.top + second.bottom
part seam = pair(first.right, second.left)
tensor B = isotropic(young = 5, poisson = 0.3)
superpotential wall(r) with slope | r < 0 -> 0 | otherwise -> 1e300
superpotential film(s) = 1.5*s^2
space V = vector P1 on both, zero.x on hot, zero.x on cold, zero.y on flanks
space W = scalar P1 on both, zero on hot, zero on cold
find u in V, theta in W with theta = 100 on hot
such that for all v in V, eta in W
    integral(both, B : eps(u) : eps(v)) - integral(both, 0.01*theta*div(v)) + integral(both, 2*dot(grad(theta), grad(eta)))
  + integral(seam, wall^0(jump(u).nu; jump(v).nu)) + integral(seam, film^0(jump(theta); jump(eta)))
 >= 0
report
  table push = integral(seam, wall.xi), flux = integral(seam, film.xi)
""")
    # Flux 100/(1/2 + 1/2 + 1/3); the stress of held bars is 0.01 times their mean temperature, which is 50.
    close(found["flux"][-1], 75.0, 1e-12, "flux")
    close(found["push"][-1], 0.5, 1e-12, "push")


def at_rest():
    """A fluid in a closed box carries its weight by pressure and does not move: a speed that is rounding is no error."""
    for weight in (1e-6, 2.0, 1e7):
        found = table(f"""
mesh flow = rectangle(2, 1, cells = [4, 2])
part walls = flow.boundary
part corner = point(flow, [0, 0])
space V = vector P2 on flow, zero on walls
space Q = scalar P1 on flow, zero on corner
find u in V, p in Q such that for all v in V, q in Q
    integral(flow, 2*(eps(u) : eps(v)) - p*div(v)) + integral(flow, q*div(u)) = integral(flow, {-weight}*v.y)
report
  table speed = norm(u), here = u.x at [0.6, 0.4], above = p at [1, 1]
""")
        close(found["above"][-1], -weight, 1e-10, "pressure")
        below(found["speed"][-1], 1e-12 * weight, "speed")


def hoop():
    """Displacements in P1 beside a temperature in P2 on a body of revolution are those of a run of their own: the rows
    of u.x/x stand where mixed spaces have them. In a ring that slides the heat has a closed form."""
    ring = """
mesh ring = rectangle(1, 0.5, cells = [6, 3], origin = [1, 0], axisymmetric = true)
part inner = ring.left
part outer = ring.right
part foot = ring.bottom
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential soil(r) with slope | r < 0 -> 0 | r < 0.05 -> 20*r | otherwise -> 1
"""
    forms = "integral(ring, B : eps(u) : eps(v)) + integral(outer, soil^0(u.nu; v.nu))"
    heat = "integral(ring, dot(grad(theta), grad(eta)))"
    columns = "a = u.x at [1, 0.5], b = u.x at [1.5, 0.25], c = u.y at [2, 0.5], d = integral(outer, soil.xi), e = norm(u)"
    space, other = "space V = vector P1 on ring, zero.y on foot\n", "space W = scalar P2 on ring, zero on inner, zero on outer\n"
    find = "in W with theta = 3 on inner such that for all v in V, eta in W"
    alone = table(ring + space + f"find u in V such that for all v in V {forms} >= integral(inner, 1.5*v.x)\nreport table {columns}")
    for coupling in ("", "- integral(ring, 1e-300*theta*div(v))"):
        both = table(ring + space + other + f"find u in V, theta {find} {forms} + {heat} {coupling} >= integral(inner, 1.5*v.x)\n"
                     f"report table {columns}, warm = theta at [1.5, 0.25]")
        for name in "abcde":
            # Not to rounding: (u.x/x)^2 x is rational, and the rule for P2 has more points.
            close(both[name][-1], alone[name][-1], 1e-7, f"hoop: {name}")
        close(both["warm"][-1], 3 * np.log(2 / 1.5) / np.log(2), 1e-4, "hoop: heat")


def reads():
    """A state whose rate reads the other unknown, and a law that reads a memory of it: sums of the implicit Euler method."""
    n = 40
    known = (("worn", "", "state worn on tip with rate 2*theta from worn = 0"), ("history(q, theta)", "kernel q(lag) = 2*exp(-lag)", ""))
    for orders, (worn, kernel, state) in [(o, k) for o in ((1, 1), (2, 1), (1, 2)) for k in known]:
        found = table(f"""
mesh bar = rectangle(1, 1, cells = [2, 2])
part tip = bar.right
part held = bar.left
part flanks = bar.top + bar.bottom
tensor B = isotropic(young = 8, poisson = 0)
{kernel}
superpotential glue(r) = 0.5*(1 + {worn})*r^2
{state}
space V = vector P{orders[0]} on bar, zero.x on held, zero.y on flanks
space W = scalar P{orders[1]} on bar, zero on held
find u in V, theta in W with theta = 3*t on held for t in [0, 1] by {n} steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(bar, B : eps(u) : eps(v)) + integral(bar, dot(grad(theta), grad(eta))) + integral(tip, glue^0(u.nu; v.nu))
 >= integral(tip, 5*v.x)
report
  table u = u.x at [1, 0.5]
""")
        # theta = 3 t everywhere, taken at the ends of the steps; 8 u + (1 + worn) u = 5.
        t = found["t"]
        if state:
            expected = 3 * t * (t + 1 / n)
        else:
            ends = np.arange(1, n + 1) / n
            expected = np.array([sum(6 * s * (np.exp(s - at) - np.exp(s - 1 / n - at)) for s in ends if s < at + 1e-9) for at in t])
        below(np.abs(found["u"] - 5 / (9 + expected))[1:].max(), 1e-10, f"{worn}, P{orders[0]}/P{orders[1]}")


def two_orders():
    """A column in P2 with its heat in P1, or the other way round, on a ground and on a second one: the heat that goes across grows
    with the pressure and with a state that both laws read. All is uniform, so that springs and films in series say what comes out."""
    steps, young, poisson, spring, film, conducts = 4, 100.0, 0.3, 500.0, 0.2, 3.0
    stiff = young / (1 - poisson ** 2)  # one side is free
    for dim, orders, two in [(d, o, t) for d in (2, 3) for o in ((2, 1), (1, 2)) for t in (False, True)]:
        kind, size, cells = ("rectangle", "1, 1", "3, 2") if dim == 2 else ("box", "1, 1, 1", "2, 2, 1")
        other = "2, 3" if dim == 2 else "3, 1, 2"
        at = "[0, 1]" if dim == 2 else "[0, 1, 0]"
        jump = (lambda w: f"jump({w})") if two else (lambda w: w)
        mesh = (f"mesh upper = {kind}({size}, cells = [{cells}], at = {at})\nmesh lower = {kind}({size}, cells = [{other}])\n"
                "mesh body = upper + lower\npart foot = lower.bottom\npart roof = upper.top\npart seam = pair(upper.bottom, lower.top)\n"
                "part sides = upper.left + lower.left" if two else
                f"mesh body = {kind}({size}, cells = [{cells}])\npart roof = body.top\npart seam = body.bottom\npart sides = body.left")
        if dim == 3:
            mesh += "\npart ends = " + (" + ".join(f"{b}.{s}" for b in (("upper", "lower") if two else ("body",)) for s in ("front", "back")))
        zeros = ", zero.x on sides" + (", zero.z on ends" if dim == 3 else "") + (", zero.y on foot" if two else "")
        found = table(f"""
{mesh}
tensor B = isotropic(young = {young}, poisson = {poisson})
superpotential press(r) = {spring / 2}*(1 + worn)*r^2
superpotential heat(s) = {film / 2}*press.xi*(1 + worn)*s^2
state worn on seam with rate 0.1*press.xi from worn = 0
space V = vector P{orders[0]} on body{zeros}, zero.y on roof
space W = scalar P{orders[1]} on body, zero on roof{", zero on foot" if two else ""}
find u in V, theta in W with u.y = -0.1*t on roof, theta = 10*t on roof for t in [0, 1] by {steps} steps from u = 0, theta = 0
such that for all v in V, eta in W
    integral(body, B : eps(u) : eps(v)) + integral(body, {conducts}*dot(grad(theta), grad(eta)))
  + integral(seam, press^0({jump("u")}.nu; {jump("v")}.nu) + heat^0({jump("theta")}; {jump("eta")})) >= 0
report
  table p = integral(seam, press.xi), q = integral(seam, heat.xi), worn = integral(seam, worn), x = largest(seam, worn)
""")
        t, bodies = found["t"], 2 if two else 1
        pressed = lambda at, w: 0.1 * at / (1 / (spring * (1 + w)) + bodies / stiff)
        worn = np.zeros(steps + 1)
        for n in range(1, steps + 1):
            for _ in range(100):
                worn[n] = worn[n - 1] + 0.1 * pressed(n / steps, worn[n]) / steps
        worn = worn[1:]
        pressure = pressed(t, worn)
        heat = 10 * t / (bodies / conducts + 1 / (film * pressure * (1 + worn)))
        said = f"{dim}D P{orders[0]}/P{orders[1]}, {'two bodies' if two else 'on a ground'}"
        for name, expected in (("p", pressure), ("q", heat), ("worn", worn), ("x", worn)):
            below(np.abs(found[name] / expected - 1).max(), 1e-9, f"{said}: {name}")


def either_first():
    """Which unknown is named first makes no difference, with a state in the body that reads both, one in P1 and one in P2."""
    def found(unknowns, tests):
        return table(f"""
mesh body = rectangle(1, 1, cells = [3, 2])
part roof = body.top
part base = body.bottom
tensor B = isotropic(young = 100, poisson = 0.3)
state d on body with rate 3*(1 + theta)*dot(u, u) from d = 0 in [0, 0.9]
space V = vector P2 on body, zero on base, zero on roof
space W = scalar P1 on body, zero on base, zero on roof
find {unknowns} with u = [0.1*t, -0.1*t*x] on roof, theta = (10 + x)*t on roof for t in [0, 1] by 4 steps from u = 0, theta = 0
such that for all {tests}
    integral(body, (1 - d)*B : eps(u) : eps(v)) + integral(body, dot(grad(theta), grad(eta))) = 0
report
  table lost = integral(body, d), size = norm(u)
""")
    one, other = found("u in V, theta in W", "v in V, eta in W"), found("theta in W, u in V", "eta in W, v in V")
    for name in ("lost", "size"):
        close(other[name][-1], one[name][-1], 1e-11, name)


def verdicts():
    """What `check` says of multipliers, and of rates whose forms are not symmetric."""
    def script(space, forms, time=""):
        start = " from u = 0, p = 0" if time else ""
        return f"""
mesh body = rectangle(1, 1, cells = [3, 3])
part held = body.left
{space}
find u in V, p in Q {time}{start}
such that for all v in V, q in Q
    {forms}
 >= integral(body, v.y)
report
  table a = norm(u)
"""

    high = "space V = vector P2 on body, zero on held\nspace Q = scalar P1 on body"
    low = "space V = vector P1 on body, zero on held\nspace Q = scalar P1 on body, zero on held"
    steps = "for t in [0, 1] by 4 steps"
    stokes = "integral(body, 2*(eps(u) : eps(v)) - p*div(v)) + integral(body, q*div(u))"
    porous = ("integral(body, eps(u') : eps(v)) + integral(body, 5*(eps(u) : eps(v)) - 0.1*p*div(v))"
              " + integral(body, p'*q) + integral(body, dot(grad(p), grad(q)))")
    for text, says in (
            (script(high, stokes), "the static theorem applies: B is coercive and (H0) holds, one solution"),
            (script(high, stokes + " + integral(body, eps(u') : eps(v))", steps),
             "an unknown has no form of its own, and the problem changes in time: of the continuous problem nothing is claimed"),
            (script(low, "integral(body, 2*(eps(u) : eps(v)) - p*v.x) + integral(body, q*u.x)"),
             "uniqueness is not guaranteed: the inf-sup condition fails"),
            (script(low, porous + " + integral(body, 0.1*div(u')*q)", steps),
             "A is not symmetric (H(A)): of the continuous problem nothing is claimed"),
            (script(low, porous, steps), "the parabolic theorem applies")):
        code, said, _ = run(text, command="check")
        print("  ", says)
        assert code == 0 and says in said, said


def on_springs():
    """A pad that soft springs hold is pressed on a stiff ground, and heat that hardly strains it moves it in tiny steps: its
    strains are not lost beside its rigid motion. Forces balance, and the heat, which nothing acts on, is that of its equation alone."""
    def script(spring, couples, of_u=True):
        u, v, start = ("u in V, ", "v in V, ", "u = 0, ") if of_u else ("", "", "")
        elastic = f"""integral(pad, B : eps(u) : eps(v)) - integral(pad, {couples}*theta*div(v)) + integral(back, {spring}*u.y*v.y)
  + integral(foot, press^0(u.nu; v.nu)) + """ if of_u else ""
        more = f", left = 4 - integral(foot, press.xi) + {spring}*integral(back, u.y), p = integral(foot, press.xi)" if of_u else ""
        space = "space V = vector P1 on pad, zero.x on back" if of_u else ""
        return f"""
mesh pad = rectangle(4, 1, cells = [32, 8])
part back = pad.top
part foot = pad.bottom
tensor B = isotropic(young = 200, poisson = 0.3)
superpotential press(r) = 5000*max(0, r)^2
{space}
space W = scalar P1 on pad, zero on back
find {u}theta in W for t in [0, 1] by 5 steps from {start}theta = 0
such that for all {v}eta in W
    {elastic}integral(pad, theta'*eta + 0.02*dot(grad(theta), grad(eta)))
 >= {"integral(back, -v.y) + " if of_u else ""}integral(foot, eta)
report
  table warm = theta at [2, 0]{more}
"""
    alone = table(script(0, 0, False))["warm"]
    for spring in (0.01, 1, 100):
        for couples in (1e-6, 1e-4, 0.01):
            found = table(script(spring, couples))
            below(np.abs(found["left"]).max(), 1e-9, f"springs {spring}, coupling {couples}: forces left")
            below(np.abs(found["warm"] / alone - 1).max(), 1e-10, "heat")


sys.exit(judge([tube, apart, units, resumed, heat_between, at_rest, hoop, reads, two_orders, either_first, verdicts, on_springs]))
