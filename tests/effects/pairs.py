#!/usr/bin/env python3
"""pairs.py HVI_RUN: an effect that is absent, present with the value zero, or removed by hand.

Every pair must give the same final values to the last bits that matter and the same counted work:
matrices, analyses, factorisations, sweeps, products, Newton iterations, stored fields and how often they are read. A contact
part that never touches costs no Newton iteration, a script without an effect says so in its plan.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

COUNTED = ["matrices", "analyses", "factorisations", "sweeps", "products", "newton", "fields", "field_reads"]

SCRIPT = """
mesh slab   = rectangle(2, 1, cells = [12, 6])
part roof   = slab.top
part flank  = slab.right
part ground = slab.bottom
tensor A      = isotropic(lambda = 5, mu = 10)
tensor B      = isotropic(young = 70, poisson = 0.3)
kernel C(lag) = -exp(-lag/0.5) * B
kernel q(lag) = exp(-lag)
superpotential layer(r) with slope
  | r < 0     -> 0
  | r < 0.02  -> 100*r
  | otherwise -> 2
superpotential slip(xi) = 0.4 * norm(xi)
superpotential reader(r) = abs(history(q, u).x) * r^2
superpotential spring(r) with slope
  | r < 0.5   -> 50*r
  | otherwise -> 25
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 1] by 12 steps from u = 0
such that for all v in V
{terms}
 >= {loads}
report
  table  u_y = u.y at [1, 0], u_x = u.x at [2, 0], strain = norm(u)
"""

VISCOSITY = "integral(slab, A : eps(u') : eps(v))"
ELASTICITY = "integral(slab, B : eps(u) : eps(v))"
MEMORY = "integral(slab, history(C, eps(u)) : eps(v))"
LAYER = "integral(ground, layer^0(u.nu; v.nu))"
BODY = "integral(slab, dot([0, -10*t], v))"
PULL = "integral(flank, dot([3*t, 0], v))"
BASE = [VISCOSITY, ELASTICITY, MEMORY, LAYER]

# name, terms and loads without the effect, terms and loads with it at zero
PAIRS = [
    ("viscosity", [ELASTICITY, MEMORY, LAYER], [BODY, PULL],
     ["0 * " + VISCOSITY, ELASTICITY, MEMORY, LAYER], [BODY, PULL]),
    ("elasticity", [VISCOSITY, MEMORY, LAYER], [BODY, PULL],
     [VISCOSITY, "0 * " + ELASTICITY, MEMORY, LAYER], [BODY, PULL]),
    ("memory", [VISCOSITY, ELASTICITY, LAYER], [BODY, PULL],
     [VISCOSITY, ELASTICITY, "0 * " + MEMORY, LAYER], [BODY, PULL]),
    ("inertia", BASE, [BODY, PULL], ["0 * integral(slab, dot(u'', v))", *BASE], [BODY, PULL]),
    ("body force", BASE, [PULL], BASE, ["integral(slab, dot([0, 0*t], v))", PULL]),
    ("traction", BASE, [BODY], BASE, [BODY, "integral(flank, dot([0, 0], v))"]),
    ("normal law", [VISCOSITY, ELASTICITY, MEMORY], [BODY, PULL],
     [VISCOSITY, ELASTICITY, MEMORY, "0 * " + LAYER], [BODY, PULL]),
    ("friction", BASE, [BODY, PULL],
     BASE + ["0 * integral(ground, slip^0(u.tau; v.tau))"], [BODY, PULL]),
    ("friction on the rate", BASE, [BODY, PULL],
     BASE + ["0 * integral(ground, slip^0(u'.tau; v.tau))"], [BODY, PULL]),
    ("law on a memory", BASE, [BODY, PULL],
     BASE + ["0 * integral(ground, spring^0(history(q, u).nu; v.nu))"], [BODY, PULL]),
    ("law that reads a memory", BASE, [BODY, PULL],
     BASE + ["0 * integral(ground, reader^0(u.nu; v.nu))"], [BODY, PULL]),
    ("state that nothing reads and that stands still", BASE, [BODY, PULL], BASE, [BODY, PULL],
     "state beta on ground with rate 0 from beta = 1\n"),
    ("state before a law at zero", BASE, [BODY, PULL],
     BASE + ["0 * integral(ground, weak^0(u.nu; v.nu))"], [BODY, PULL],
     "superpotential weak(r) = beta*r^2\nstate beta on ground with rate -beta from beta = 1\n"),
    ("one tensor in two terms", BASE, [BODY, PULL],
     [VISCOSITY, "0.25 * " + ELASTICITY, "0.75 * " + ELASTICITY, MEMORY, LAYER], [BODY, PULL]),
]
# friction at zero keeps the law's points out of the run as well
SLEEPING = ([VISCOSITY, ELASTICITY, MEMORY, LAYER], ["integral(slab, dot([0, 10*t], v))"])


def run(hvi, folder, terms, loads, more=""):
    script = pathlib.Path(folder) / "effect.hvi"
    script.write_text(SCRIPT.format(terms="    " + "\n  + ".join(terms), loads="\n  + ".join(loads)).replace("space V", more + "space V"))
    out = pathlib.Path(folder) / "effect.json"
    done = subprocess.run([hvi, "run", script, "--quiet", "--json", out, "-o", folder], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{script.read_text()}\n{done.stdout}{done.stderr}")
    return json.loads(out.read_text())


def whys(result):
    return {e["name"]: (e["state"], e["why"]) for e in result["plan"]["effects"]}


def said(hvi, folder):
    """What a run says of dimensions, symmetry, loads and a law that is a line where it was reached."""
    spring = "integral(ground, 3 * spring^0(u.nu; v.nu))"
    effects = whys(run(hvi, folder, [VISCOSITY, ELASTICITY, spring], [BODY, "integral(flank, dot([1/(1 + x*t), 0], v))"]))
    constant = whys(run(hvi, folder, [VISCOSITY, ELASTICITY], ["integral(slab, dot([0, -10], v))"]))
    wanted = [
        (effects, "space dimension y", "on", ""), (effects, "space dimension z", "off", "the mesh has 2 dimensions"),
        (effects, "symmetry", "on", "Cholesky"), (effects, "load on `slab`", "on", "once for each function of time"),
        (effects, "load on `flank`", "on", "not separable in time"),
        (constant, "load on `slab`", "on", "assembled once"),
        (effects, "law `spring` on `ground`", "on", "linear on the range reached: 50 times"),
    ]
    return [f"{name}: {of.get(name)}" for of, name, state, why in wanted
            if name not in of or of[name][0] != state or why not in of[name][1]]


def differences(a, b):
    out = [f"{key}: {a['plan'][key]} and {b['plan'][key]}" for key in COUNTED if a["plan"][key] != b["plan"][key]]
    for name, value in a["final"].items():
        other = b["final"][name]
        if abs(value - other) > 1e-13 * max(abs(value), abs(other)):
            out.append(f"{name}: {value!r} and {other!r}")
    return out


def main():
    hvi, failed = str(pathlib.Path(sys.argv[1]).resolve()), 0
    with tempfile.TemporaryDirectory() as folder:
        for name, terms, loads, with_terms, with_loads, *more in PAIRS:
            found = differences(run(hvi, folder, terms, loads), run(hvi, folder, with_terms, with_loads, *more))
            failed += bool(found)
            print(f"{'FAILED' if found else 'ok'}  {name}", *found, sep="\n    " if found else " ")
        asleep = run(hvi, folder, *SLEEPING)
        found = said(hvi, folder)
        failed += bool(found)
        print("FAILED" if found else "ok", " what a run says", *found, sep="\n    " if found else " ")
        state = [e["state"] for e in asleep["plan"]["effects"] if "layer" in e["name"]]
        ok = asleep["plan"]["newton"] == 0 and state == ["asleep"]
        failed += not ok
        print("ok" if ok else "FAILED", f" a part that never touches: {asleep['plan']['newton']} Newton iterations, {state}")
    sys.exit(failed > 0)


main()
