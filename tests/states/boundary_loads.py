"""Loads that read states at the points of laws on a boundary, against the same loads with what these states are, written out.

usage: boundary_loads.py HVI_RUN [--scenes N] [--seed S]

A state with the rate a + b x is (a + b x) t after any steps. Bodies in the plane, in space and of revolution, pairs, P1 and P2, both schemes, with inertia and without, loads on
vectors and scalars, on the left and on the right, linear in the state and not, in products with the solution, laws by each rule; by the direct and the iterative solver.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

BODIES = {
    "plane": "mesh body = rectangle(1.3, 1, cells = [5, 3])\npart ground = body.bottom\npart roof = body.top\n",
    "space": "mesh body = box(1, 0.9, 1.2, cells = [2, 2, 2])\npart ground = body.bottom\npart roof = body.top\n",
    "ring": "mesh body = rectangle(1.3, 1, cells = [4, 3], origin = [0.4, 0], axisymmetric = true)\npart ground = body.bottom\npart roof = body.top\n",
    "pair": "mesh a = rectangle(1, 1, cells = [3, 2], at = [0, 1])\nmesh b = rectangle(1, 1, cells = [4, 2])\nmesh body = a + b\n"
            "part ground = pair(a.bottom, b.top)\npart top = a.top\npart foot = b.bottom\npart roof = top + foot\n",
}

def script(random, kind):
    """The scene, and what stands in place of the state: a known function, and that with a multiplier that counts nothing, as the sources of old."""
    a, b, c = random.uniform(0.2, 1, 3)
    order, moves, scheme = random.integers(1, 3), random.random() < 0.3, ("backward_euler", "bdf2")[random.integers(2)]
    pair = kind == "pair"
    v, eta, u, theta = ("mean(v)", "mean(eta)", "mean(u)", "mean(theta)") if pair else ("v", "eta", "u", "theta")
    law = "layer^0(jump(u).nu; jump(v).nu) + film^0(jump(theta); jump(eta))" if pair else "layer^0(u.nu; v.nu) + film^0(theta; eta)"
    load = [f"wear*{eta}", f"wear^2*{v}.x", f"exp(-wear)*{eta} + 2*wear*{v}.y", f"wear*cos({u}.x)*{eta}",
            f"wear*{theta}^2*{v}.y + wear*{eta}"][random.integers(5)]
    left = random.random() < 0.4 and u not in load and theta not in load  # what reads the solution stands on the right
    term = f"integral(ground, {load})"
    rule = "" if pair else ("", "gauss", "midpoint")[random.integers(3)]  # of the laws: the state lives at their points
    by = f", rule = {rule}" if rule else ""
    text = f"""{BODIES[kind]}tensor A = isotropic(lambda = 1, mu = 1)
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential layer(r) = {c:.3f}*r^2
superpotential film(s) = 0.3*s^2
fn known() = ({a!r} + {b!r}*x)*t
state wear on ground with rate {a!r} + {b!r}*x from wear = 0
space V = vector P{order} on body, zero on roof
space W = scalar P{order} on body, zero on roof
find u in V, theta in W for t in [0, 1] by 4 steps from u = 0, theta = 0 using scheme = {scheme}
such that for all v in V, eta in W
    {"integral(body, dot(u'', v)) + " if moves else ""}integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v))
  + integral(body, theta'*eta + dot(grad(theta), grad(eta))) + integral(ground, {law}{by}){" - " + term if left else ""}
 >= integral(body, 0.3*eta - v.y){"" if left else " + " + term}
report
  table warm = integral(body, theta), moved = norm(u), most = norm(theta), held = reaction(roof).y
"""
    of_multiplier = text.replace(load, load.replace("wear", "(known() + 1e-300*layer.xi)"))
    plain = not pair and "cos" not in load and "^2*v.y" not in load
    function = text.replace(term, f"integral(ground, {load.replace('wear', 'known()')}, rule = {rule or 'nodal'})")
    return text, [of_multiplier] + [function] * plain


def run(program, folder, text, *options):
    (folder / "scene.hvi").write_text(text)
    done = subprocess.run([program, "run", "scene.hvi", "--quiet", "--json", "-", "--no-files", *options], cwd=folder, capture_output=True, text=True,
                          timeout=300)
    if done.returncode != 0:
        raise RuntimeError(text + done.stderr)
    table = json.loads(done.stdout)["table"]
    return np.array([table[name] for name in ("warm", "moved", "most", "held")])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--scenes", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    program, wrong = options.program.resolve(), 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for k in range(options.scenes):
            random = np.random.default_rng([options.seed, k])
            kind = list(BODIES)[k % len(BODIES)]
            text, others = script(random, kind)
            found = run(program, folder, text)
            size = np.abs(found).max(1)
            references = [run(program, folder, other) for other in others]
            if kind == "space":
                try:
                    references.append(run(program, folder, text, "--solver", "iterative"))
                except RuntimeError as failure:
                    if "E0601" not in str(failure):  # PETSc is not there
                        raise
            apart = max(float((np.abs(found - other).max(1) / size).max()) for other in references)
            print(f"{'ok   ' if apart < 1e-8 else 'FAILS'} scene {k}, {kind}: apart by {apart:.1e} from {len(references)}")
            wrong += not apart < 1e-8
    return wrong


sys.exit(bool(main()))
