"""Bodies that laws alone hold, on random scenes: solved where statics says so, refused with the motion where not.

usage: held.py HVI_RUN [--warm] [--scenes N] [--seed S] [--only K] [--keep FOLDER]

A block (2D or 3D, P1 or P2, any proportions and units) stands on a ground, or on a second block, with nothing imposed on
it: unilateral contact, a compliance with a bound, springs, or glue that softens; with friction of a given bound on u or
u', or Coulomb's, or a tangential spring; static, or viscoelastic with a memory by backward Euler or BDF2. Loads act on
its top at any angle and off the centre. Whether anything can hold it follows from the statics of a rigid body: resultant
inside the base (by as much as a bounded pressure needs), shear below what friction gives; scenes within 6 % of a limit are
drawn again. What is solved has to have the load's resultants as reactions, force and moment, and the values of the same
body with weak springs in all its volume, which other code solves: there K holds the body. With `--warm` a temperature is
found as well, which strains the block and is heated by its strains; a law alone holds it, too, or an imposed value. It
has no part in the statics.
"""
import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile

SPRING = 1e-7  # of the reference, by the stiffness of the block
SPRING_OF_GLUE = 3e-5  # of a static one, which softer springs would let tear; 1e-4 of the values are allowed for it


class Heat:
    """A temperature of about 1 that strains the block by 1e-4."""

    def __init__(self, draw):
        self.conducts = 10 ** draw.uniform(-4, 4)
        self.by_law = draw.random() < 0.6
        self.back = draw.choice([0.0, 30.0, 100.0])
        self.order = draw.choice(["P1", "P1", "P2"])

    def declare(self, scene):
        clamp = ", zero on base" if scene.pair else ""
        given = "" if self.by_law else ", zero on top"
        return [f"superpotential film(q) = {0.5 * self.conducts / scene.size!r}*q^2",
                f"space W = scalar {self.order if not scene.pair else scene.order} on {scene.where()}{clamp}{given}"]

    def terms(self, scene):
        where, k, s = scene.where(), self.conducts, scene.size
        out = [f"integral({where}, {k!r}*dot(grad(theta), grad(eta)))"]
        if scene.time != "static":
            out.append(f"integral({where}, {0.3 * k / s ** 2!r}*theta'*eta)")
        if self.back:
            rate = "u" if scene.time == "static" else "u'"
            out.append(f"integral({where}, {self.back * k / s ** 2!r}*div({rate})*eta)")
        if scene.pair:
            out.append("integral(ground, film^0(jump(theta); jump(eta)))")
        elif self.by_law:
            out.append("integral(top, film^0(theta; eta))")
        return out


class Scene:
    def __init__(self, seed, warm=False):
        self.heat = Heat(random.Random(seed + 7)) if warm else None
        self.draw = random.Random(seed)
        pick, real = self.draw.choice, self.draw.uniform
        self.dim = pick([2, 2, 3])
        self.order = pick(["P1", "P1", "P2"])
        self.pair = real(0, 1) < 0.3
        self.time = pick(["static", "euler", "bdf2"])
        self.memory = self.time != "static" and real(0, 1) < 0.5
        self.young = 10 ** real(-1, 5)
        self.size = 10 ** real(-2, 2)
        self.width = 1.0
        self.height = real(0.4, 1.5)
        self.depth = real(0.5, 1.0) if self.dim == 3 else 1.0
        self.normal = pick(["unilateral", "unilateral", "bounded", "winkler", "glue"])
        self.tangent = pick(["tresca", "rate", "coulomb", "spring"])
        if self.tangent == "rate" and self.time == "static":
            self.tangent = "tresca"
        if self.tangent == "coulomb" and self.normal in ("glue", "winkler"):
            self.tangent = "tresca"
        while True:
            self.load()
            distance = self.distance()
            if abs(distance) > 0.06:
                break
        self.solvable = distance > 0

    # Pressures are in units of 1e-3 Young, lengths in units of `size`.
    def load(self):
        real = self.draw.uniform
        self.press = real(0.2, 2.0) * (-1 if real(0, 1) < 0.12 else 1)
        self.shear = real(-0.8, 0.8) * abs(self.press)
        self.tilt = real(-4.5, 4.5)  # the load is press (1 + tilt (x - 1/2))
        if self.normal == "glue":
            self.press, self.shear, self.tilt = -abs(self.press), 0.0, 0.0
        self.most = real(0.4, 3.0)  # of a bounded pressure, of glue, of friction
        self.friction = real(0.1, 1.2)

    def where(self):
        return "both" if self.pair else "block"

    def distance(self):
        """From the limit of what holds the block, relative; negative: nothing holds it."""
        out = 1.0
        if self.tangent in ("tresca", "rate"):
            out = min(out, 1 - abs(self.shear) / self.friction)
        if self.tangent == "coulomb":
            out = min(out, 1 - abs(self.shear) / (self.friction * max(self.press, 1e-9)))
        if self.normal == "winkler":
            return out
        if self.normal == "glue":
            return min(out, 1 - abs(self.press) / self.most)
        if self.press <= 0:
            return -1.0
        moment = self.press * self.tilt / 12 + self.shear * self.height
        eccentric = abs(moment) / self.press
        out = min(out, 0.5 - eccentric)
        if self.normal == "bounded":
            # Stress blocks: the pressure is `most` on a strip about the resultant.
            out = min(out, 1 - eccentric * 2 - self.press / self.most)
        return out

    def script(self, springs=False):
        s, e, p = self.size, self.young, 1e-3 * self.young
        n = 8 if self.dim == 2 else 4
        x = f"(x/{s!r} - 0.5)"
        lines = ["import contact"]
        if self.dim == 2:
            lines.append(f"mesh block = rectangle({s!r}, {s * self.height!r}, cells = [{n}, 6])")
        else:
            lines.append(f"mesh block = box({s!r}, {s * self.height!r}, {s * self.depth!r}, cells = [{n}, 3, 3])")
        top = "block.top"
        if self.pair:
            floor = f"rectangle({3 * s!r}, {s!r}, cells = [23, 5], at = [{-s!r}, {-s!r}])" if self.dim == 2 else \
                f"box({2 * s!r}, {s!r}, {2 * s * self.depth!r}, cells = [7, 2, 5], at = [{-0.4 * s!r}, {-s!r}, {-0.6 * s * self.depth!r}])"
            lines += [f"mesh floor = {floor}", "mesh both = block + floor", "part ground = pair(block.bottom, floor.top)",
                      "part base = floor.bottom"]
        else:
            lines += ["part ground = block.bottom"]
        lines += [f"part top = {top}", f"tensor B = isotropic(young = {e!r}, poisson = 0.3)"]
        if self.time != "static":
            lines.append(f"tensor A = isotropic(young = {0.1 * e!r}, poisson = 0.3)")
        if self.memory:
            lines.append("kernel C(lag) = -0.3*exp(-lag)*B")
        lines.append({
            "unilateral": "superpotential across(r) = unilateral(r)",
            "bounded": f"superpotential across(r) = bounded_compliance(r, stiffness = {e / s!r}, bound = {p * self.most!r})",
            "winkler": f"superpotential across(r) = winkler(r, stiffness = {0.3 * e / s!r})",
            "glue": f"superpotential across(r) = cohesive(r, stiffness = {e / s!r}, peak_at = {1e-3 * self.most * s!r}, "
                    f"end_at = {1.4e-1 * self.most * s!r})"}[self.normal])
        lines.append({
            "tresca": f"superpotential along(xi) = {p * self.friction!r}*norm(xi)",
            "rate": f"superpotential along(xi) = {p * self.friction!r}*norm(xi)",
            "coulomb": f"superpotential along(xi) = {self.friction!r}*abs(across.xi)*norm(xi)",
            "spring": f"superpotential along(xi) = {0.2 * e / s!r}*norm(xi)^2"}[self.tangent])
        where = self.where()
        u, v, du = ("jump(u)", "jump(v)", "jump(u')") if self.pair else ("u", "v", "u'")
        clamp = ", zero on base" if self.pair else ""
        lines.append(f"space V = vector {self.order} on {where}{clamp}")
        static = self.time == "static"
        slowly = springs and static and self.normal == "glue"  # at once, the search may tear it, and the springs carry all
        t = "t*" if slowly else "" if static else "min(1, 2*t)*"
        more, starts, tests = (", theta in W", ", theta = 0", ", eta in W") if self.heat else ("", "", "")
        lines += self.heat.declare(self) if self.heat else []
        lines.append(f"find u in V{more} for t in [0, 1] by 20 steps from u = 0{starts}" if slowly else f"find u in V{more}" if static else
                     f"find u in V{more} for t in [0, 1] by 4 steps from u = 0{starts}" + (" using scheme = bdf2" if self.time == "bdf2" else ""))
        minus = "-" if self.normal == "glue" else ""
        slip = du if self.tangent == "rate" else u
        terms = [f"integral({where}, B : eps(u) : eps(v))"]
        if self.time != "static":
            terms.append(f"integral({where}, A : eps(u') : eps(v))")
        if self.memory:
            terms.append("integral(block, history(C, eps(u)) : eps(v))")
        if springs:
            terms.append(f"integral(block, {(SPRING_OF_GLUE if slowly else SPRING) * e / s ** 2!r}*dot(u, v))")
        if self.heat:
            terms += [f"- integral({where}, {1e-4 * e!r}*theta*div(v))", *self.heat.terms(self)]
        terms.append(f"integral(ground, across^0({minus}{u}.nu; {minus}{v}.nu) + along^0({slip}.tau; {v}.tau))")
        force = f"{-p * self.press!r}*(1 + {self.tilt!r}*{x})"
        vector = f"[{p * self.shear!r}, {t}{force}]" if self.dim == 2 else f"[{p * self.shear!r}, {t}{force}, 0]"
        vector = vector.replace("[", "[" + t, 1)
        warmed = f" + integral(block, {self.heat.conducts / s ** 2!r}*{t}eta)" if self.heat else ""
        lines += [f"such that for all v in V{tests}", "    " + "\n  + ".join(terms).replace("+ -", "-"),
                  f" >= integral(top, dot({vector}, v)){warmed}"]
        area = s * (s * self.depth if self.dim == 3 else 1)
        high = s * self.height
        point = (lambda a, b: f"[{a * s!r}, {b * high!r}]") if self.dim == 2 else \
                (lambda a, b: f"[{a * s!r}, {b * high!r}, {0.4 * s * self.depth!r}]")
        sign = -1 if self.normal == "glue" else 1
        lines += ["report", f"  table press = integral(ground, across.xi)/{sign * p * area!r}, "
                  f"shear = {'1' if self.normal == 'glue' else f'integral(ground, along.xi.x)/{p * area!r}'}, "
                  f"edge = integral(ground, across.xi*x)/{sign * p * area * s!r},",
                  "      " + ", ".join(f"v{i} = u.y at {point(a, b)}"
                                       for i, (a, b) in enumerate([(0.1, 0.3), (0.05, 1), (0.55, 1), (0.95, 1)]))
                  + (", warm = norm(theta)" if self.heat else "")]
        return "\n".join(lines) + "\n"


def run(program, folder, script):
    path = pathlib.Path(folder) / "scene.hvi"
    path.write_text(script)
    out = pathlib.Path(folder) / "out.json"
    out.unlink(missing_ok=True)
    done = subprocess.run([program, str(path), "--no-files", "--quiet", "--json", str(out)], capture_output=True, text=True)
    final = json.loads(out.read_text())["final"] if done.returncode == 0 else None
    return done.returncode, final, done.stderr


def judge(scene, program, folder):
    """What is wrong; empty: nothing."""
    code, final, said = run(program, folder, scene.script())
    if not scene.solvable:
        if code == 0:
            return "solved, and nothing holds the block"
        named = "moves along" in said or "turns about" in said
        return "" if named and (code in (1, 3)) else f"refused without the motion: {said}"
    if code != 0:
        return f"not solved: {said}"
    press = scene.press
    moment = scene.press * scene.tilt / 12 + scene.shear * scene.height
    shear = abs(scene.shear) if scene.normal != "glue" else 1.0
    off = max(abs(final["press"] - press), abs(abs(final["shear"]) - shear),
              abs(final["edge"] - 0.5 * press - moment))
    if not off <= 1e-6 * max(abs(press), abs(scene.shear), abs(moment), 1.0):
        return f"reactions {final} of {press}, {scene.shear}, {moment}"
    if scene.tangent == "coulomb":
        return ""  # several solutions
    code, weak, said = run(program, folder, scene.script(springs=True))
    if code != 0:
        return f"reference not solved: {said}"
    moved = [(of["v1"] - of["v0"], of["v2"] - of["v0"], of["v3"] - of["v0"]) for of in (final, weak)]
    if scene.heat and not abs(final["warm"] - weak["warm"]) <= 1e-4 * weak["warm"]:
        return f"temperature {final['warm']} against {weak['warm']}"
    off = max(abs(a - b) for a, b in zip(*moved))
    return "" if off <= 1e-4 * max(map(abs, moved[1])) else f"{final} against {weak} with weak springs"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--keep")
    parser.add_argument("--warm", action="store_true")
    args = parser.parse_args()
    failed = held = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = args.keep or folder
        for k in range(args.scenes) if args.only is None else [args.only]:
            scene = Scene(args.seed * 100003 + k, args.warm)
            held += scene.solvable
            wrong = judge(scene, args.program, folder)
            if wrong:
                failed += 1
                print(f"scene {k} ({scene.dim}D {scene.order} {scene.normal} {scene.tangent} {scene.time}"
                      f"{' pair' if scene.pair else ''}, distance {scene.distance():.3g}): {wrong}")
        total = args.scenes if args.only is None else 1
        print(f"{total} scenes, {held} to be solved, {failed} wrong")
        few = total >= 40 and not total / 4 < held < 3.6 * total / 4
    return 1 if failed or few else 0


if __name__ == "__main__":
    sys.exit(main())
