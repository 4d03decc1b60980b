"""An unknown that nothing couples to the others changes no answer of theirs.

usage: beside.py HVI_RUN

A viscoelastic body, alone or on a second one, in 2D, 3D or as one of revolution, with laws on u and u', a state, reactions, extremes and
integrals. A temperature in P1 or P2 is found beside it, named last or first. Everything that is said of u is what is said without it: to
rounding, but for P1 beside P2 in bodies of revolution, where the strain u.x/x is integrated with the points of P2.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

ALIKE, OF_QUADRATURE, NOTHING = 1e-11, 3e-3, 1e-6


def script(dim, revolved, order, of_heat, pair, rule, heat_first):
    kind, size, cells, others = ("rectangle", "1, 1", "3, 2", "2, 3") if dim == 2 else ("box", "1, 1, 1", "2, 1, 1", "1, 2, 2")
    above, corner = ("[0, 1]", "[0.5, 1]") if dim == 2 else ("[0, 1, 0]", "[0.5, 1, 0.5]")
    more = ", axisymmetric = true" if revolved else ""
    if pair:
        mesh = f"""mesh upper = {kind}({size}, cells = [{cells}], at = {above}{more})
mesh lower = {kind}({size}, cells = [{others}]{more})
mesh body = upper + lower
part seam = pair(upper.bottom, lower.top)
part roof = upper.top
part foot = lower.bottom
part flank = upper.right"""
    else:
        mesh = f"mesh body = {kind}({size}, cells = [{cells}]{more})\npart seam = body.bottom\npart roof = body.top\npart flank = body.right"
    jump = (lambda w: f"jump({w})") if pair else (lambda w: w)
    zeros = ", zero on roof" + (", zero on foot" if pair else "")
    unknowns, tests, starts, heat, space = ["u in V"], ["v in V"], ["u = 0"], "", ""
    if of_heat is not None:
        unknowns.append("theta in W"), tests.append("eta in W"), starts.append("theta = 0")
        heat = " + integral(body, theta'*eta + dot(grad(theta), grad(eta)))"
        space = f"space W = scalar P{of_heat} on body{zeros}\n"
    if heat_first:
        unknowns, tests = unknowns[::-1], tests[::-1]
    load = "[0.3*t, -2*t]" if dim == 2 else "[0.3*t, -2*t, 0.1*t]"
    told = f", rule = {rule}" if rule else ""
    return f"""{mesh}
tensor B = isotropic(young = 100, poisson = 0.3)
tensor A = isotropic(young = 10, poisson = 0.3)
superpotential press(r) = 300*max(0, r)^2
superpotential slip(w) = 0.3*(1 + wear)*abs(press.xi)*norm(w)
state wear on seam with rate 0.5*norm({jump("u")}.tau) from wear = 0
space V = vector P{order} on body{zeros}
{space}find {", ".join(unknowns)} for t in [0, 1] by 3 steps from {", ".join(starts)} such that for all {", ".join(tests)}
  integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)){heat}
  + integral(seam, press^0({jump("u")}.nu; {jump("v")}.nu) + slip^0({jump("u'")}.tau; {jump("v")}.tau){told})
 >= integral(body, dot({load}, v)) + integral(flank, dot({load}, v), rule = nodal)
report
  table across = u.x at {corner}, along = u.y at {corner}, size = norm(u), pressed = integral(seam, press.xi), rubbed = integral(seam, slip.xi.x),
    worn = integral(seam, wear), most = largest(seam, wear), held = reaction(roof).y, drag = reaction(roof).x, stress = sigma.yy at {corner},
    peak = largest(roof, sigma.yy), work = integral(body, sigma : eps(u)), side = integral(flank, u.x, rule = nodal)
"""


def final(program, text):
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "a.hvi").write_text(text)
        done = subprocess.run([program, "run", "a.hvi", "--no-files", "--quiet", "--json", "a.json"], cwd=folder, capture_output=True, text=True,
                              timeout=120)
        assert done.returncode == 0, text + done.stderr
        return json.loads((pathlib.Path(folder) / "a.json").read_text())["final"]


def main():
    program, wrong, pairs, worst = str(pathlib.Path(sys.argv[1]).resolve()), 0, 0, 0.0
    for dim, revolved, pair, order in [(d, r, p, o) for d, r in ((2, False), (2, True), (3, False)) for p in (False, True) for o in (1, 2)]:
        for rule in (None,) if pair else (None, "gauss", "midpoint"):
            alone = final(program, script(dim, revolved, order, None, pair, rule, False))
            for of_heat, first in ((1, False), (1, True), (2, False), (2, True)):
                beside = final(program, script(dim, revolved, order, of_heat, pair, rule, first))
                bound = OF_QUADRATURE if revolved and order < of_heat else ALIKE
                off = {name: abs(beside[name] - value) / (abs(value) + NOTHING) for name, value in alone.items()}
                pairs, worst = pairs + 1, max([worst, *off.values()] if bound == ALIKE else [worst])
                if max(off.values()) > bound:
                    wrong += 1
                    print(f"{dim}D{' revolved' if revolved else ''}{' pair' if pair else ''} u in P{order}, heat in P{of_heat}"
                          f"{' first' if first else ''}, rule {rule}: off by {({k: float(f'{v:.1e}') for k, v in off.items() if v > bound})}", file=sys.stderr)
    print(f"family beside: scenes {pairs}, wrong {wrong}, worst {worst:.1e}")
    return 0 if wrong == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
