"""Random bodies whose matrices several processes assemble, each on its own cells, against one process and a factor.

usage: own_cells.py HVI_RUN [--scenes N] [--seed S] [--ranks N,M] [--only NAME] [--keep FOLDER]

Bodies in 1D, 2D, 3D and of revolution, P1 and P2, vectors and scalars, of sizes and stiffnesses decades apart; stiffnesses
that change with the place, by tables and from part to part, tensors in axes that are turned, springs on facets and in bodies,
supports that move, memories of a lag and of two times, uneven steps, laws on u and u', friction, two bodies, tensors without
symmetry, inertia by all schemes, bodies that laws alone or springs hold, periodic parts, heat beside a body, no laws,
slender bodies, masses that `midpoint` takes off walls, damage and ageing by states that are functions of the place, of the
strain, of the solution or of the time. Every number of the table agrees with the direct solver's and with those of one process to 1e-9 of its column's
largest value, and all runs are certified. The JSON says who assembles: all of them.
Without the module of PETSc or mpirun the test is skipped (exit code 77).
"""
import argparse
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

import iterative

TABLE = "z,factor\n-1e9,1\n0,1.5\n0.5,2.5\n1e9,3\n"
LAWS = ("| r < 0 -> 0 | otherwise -> 50*r", "20*r", "| r < 0 -> 0 | r < 0.01 -> 80*r | r < 0.2 -> 0.8 - 2*(r - 0.01) | otherwise -> 0.42",
        "| r < 0 -> -0.1 | otherwise -> 0.3 + r")
SPECIAL = ("without symmetry", "inertia", "on springs", "on laws", "periodic", "heat", "no laws", "slender", "states", "states")


class Scene:
    """Lengths are in units of `size`, stresses in those of `stiff`."""

    def __init__(self, seed):
        self.draw = draw = random.Random(f"own cells {seed}")
        self.kind = draw.choice(SPECIAL) if draw.random() < 0.6 else "own cells"
        self.scheme = draw.choice(("newmark", "hht", "bdf2", "midpoint", "midpoint", "")) if self.kind == "inertia" else ""
        self.dim, self.ring = draw.choice([(1, False), (2, False), (2, False), (2, True), (3, False)])
        if self.kind in ("without symmetry", "heat", "slender"):
            self.dim, self.ring = 2, False
        if self.kind in ("on springs", "on laws"):
            self.dim, self.ring = draw.choice([2, 2, 3]), False
        if self.kind == "periodic":
            self.dim, self.ring = draw.choice([2, 3]), False
        self.order = 2 if self.kind == "slender" else draw.choice([1, 1, 2])
        self.size, self.stiff = 10 ** draw.uniform(-3, 3), 10 ** draw.uniform(-4, 5)
        self.vector = self.dim > 1 and (self.ring or draw.random() < 0.8 or self.kind in ("without symmetry", "on springs", "on laws", "slender"))
        self.two = self.dim == 2 and self.kind in ("own cells", "states", "inertia") and draw.random() < 0.3
        self.lines = ["fn rise(z) = table(\"rise.csv\", z)"]

    def mesh(self):
        draw = self.draw
        cells = {1: [draw.randint(5, 30)], 2: [draw.randint(2, 7), draw.randint(2, 5)], 3: [3, 2, draw.randint(1, 2)]}[self.dim]
        sides = [self.size * draw.uniform(0.6, 2) for _ in cells]
        if self.kind == "slender":
            cells, sides = [40, 2], [self.size, self.size * draw.uniform(60, 80)]
            cells.reverse()
        name = ("interval", "rectangle", "box")[self.dim - 1]
        more = ", axisymmetric = true" if self.ring else ""

        def block(called, at):
            return f"mesh {called} = {name}({', '.join(map(repr, sides))}, cells = {cells}{at}{more})"

        if self.two:
            self.lines += [block("low", f", at = [0, {-sides[1]!r}]"), block("high", ""), "mesh body = low + high",
                           "part roof = high.top", "part ground = high.bottom", "part base = low.bottom", "part seam = pair(high.bottom, low.top)"]
        else:
            top, foot = ("right", "left") if self.dim == 1 else ("top", "bottom")
            self.lines += [block("body", ""), f"part roof = body.{top}", f"part ground = body.{foot}"]
        if self.kind == "periodic":
            self.lines += ["part low = body.left", "part high = body.right"]
        self.lines.append(f"part far = body where x > {0.5 * sides[0]!r}")
        self.length = sides[0]

    def factor(self):
        """What makes a stiffness more than a number."""
        x = f"(x/{self.size!r})"
        return self.draw.choice(["1", "2.5", f"(1 + {x}^2)", f"(1.5 + sin(3*{x}))", f"rise({x})", "patchy()", f"exp(-{x})"])

    def form(self, of, tensor, factor):
        number = {"A": 2, "B": 30}[tensor] * self.stiff
        if self.vector:
            return f"integral(body, {factor}*{tensor} : eps({of}) : eps(v))"
        return f"integral(body, {number!r}*{factor}*dot(grad({of}), grad(v)))"

    def materials(self):
        draw, k = self.draw, self.stiff
        self.lines.append("fn patchy() = | inside(far) -> 3 | otherwise -> 1")
        if not self.vector:
            return
        self.lines.append(f"tensor A = isotropic(lambda = {k!r}, mu = {2 * k!r})")
        if self.dim == 2 and not self.ring and draw.random() < 0.3:
            angle = draw.uniform(0, 3)
            self.lines.append(f"tensor B = orthotropic(E1 = {40 * k!r}, E2 = {9 * k!r}, E3 = {9 * k!r}, nu12 = 0.2, nu23 = 0.2, nu13 = 0.2, "
                              f"G12 = {7 * k!r}, G23 = {4 * k!r}, G13 = {7 * k!r}, axes = [[{math.cos(angle)!r}, {math.sin(angle)!r}], [{-math.sin(angle)!r}, {math.cos(angle)!r}]])")
        else:
            self.lines.append(f"tensor B = isotropic(young = {30 * k!r}, poisson = {draw.choice((0.0, 0.3, 0.45))})")

    def terms(self):
        draw, k = self.draw, self.stiff
        both = "dot(u, v)" if self.vector else "u*v"
        out = [self.form("u", "B", self.factor()), self.form("u'", "A", self.factor())]
        if self.kind == "states":
            out += self.changing()
        if draw.random() < 0.6:
            name, kernel = draw.choice([("q(lag)", "exp(-2*lag)"), ("q(lag)", "1/(1 + lag)^2"), ("q(t, s)", "exp(s - t)*(1 + 0.2*s)")])
            self.lines.append(f"kernel {name} = -0.3*{kernel}")
            out.append(self.form("history(q, u)", "B", "1"))
        if draw.random() < 0.5 and self.kind != "on laws":
            out.append(f"integral(ground, {0.1 * k / self.size!r}*{self.factor()}*{both})")
        if self.kind == "on springs" or (draw.random() < 0.3 and self.kind != "on laws"):
            out.append(f"integral(far, {0.2 * k / self.size ** 2!r}*{both})")
        if self.kind == "without symmetry":
            out.append(f"integral(body, {0.5 * k / self.size!r}*grad(u).xx*v.y)")
        if self.kind == "inertia":
            out.append(f"integral(body, {0.01 * k / self.size ** 2!r}*{'dot(u' + 2 * chr(39) + ', v)' if self.vector else 'u' + 2 * chr(39) + '*v'})")
        return out if self.kind in ("no laws", "slender") else out + [self.laws()]

    def changing(self):
        """Forms that one or two states change; those of the second live on a half of the body."""
        draw, k = self.draw, self.stiff
        x = f"(x/{self.size!r})"
        strain = "norm(eps(u))" if self.vector else f"norm(grad(u))*{self.size!r}"
        value = f"{'norm(u)' if self.vector else 'abs(u)'}/{self.size!r}"
        rate, low = draw.choice([("0.2", "0.1"), ("1", "0"), (f"0.3*sin(2*{x})", f"0.2*cos({x})^2"), (f"5*{strain}*(1 - d)", "0"), (f"8*{value}", f"0.1*{x}^2/9")])
        self.lines.append(f"state d on body with rate {rate} from d = {low} in [0, 2]")
        out = [self.form(draw.choice(("u", "u'")), "B", "(1 + d)" if draw.random() < 0.3 else "(1.2 - 0.5*d)")]
        if draw.random() < 0.4 and not self.two:
            self.lines.append(f"state e on far with rate 3*{strain} + 0.1 from e = 0.1 in [0, 1]")
            out.append(self.form("u", "B", "(2 - e)").replace("integral(body", "integral(far"))
        if draw.random() < 0.3:
            self.lines.append("kernel aged(lag) = -0.2*exp(-lag)")
            out.append(self.form("history(aged, u)", "B", "(1 - 0.3*d)"))
        if draw.random() < 0.3:
            out.append(f"integral(body, (1 + d)*{0.2 * k / self.size ** 2!r}*{'dot(u, v)' if self.vector else 'u*v'})")
        return out

    def laws(self):
        draw, k = self.draw, self.stiff
        if self.kind == "inertia" and draw.random() < 0.7:
            self.lines.insert(0, "import contact")
            self.lines.append(f"superpotential layer(r) = unilateral(r, gap = {draw.choice((0, 0.002))})")
            return self.applied()
        pieces = draw.choice(LAWS if self.kind not in ("on springs", "on laws") else LAWS[:2]).replace("->", "-> @").split("@")
        scaled = [pieces[0], *(f" {k!r}*({value})" for value in (p.split("|")[0].strip() for p in pieces[1:]))]
        rest = ["", *("|" + p.split("|", 1)[1] if "|" in p else "" for p in pieces[1:])]
        slope = "".join(a + (" " + b if b else "") for a, b in zip(scaled, rest)) if len(pieces) > 1 else f"{k!r}*({pieces[0]})"
        self.lines.append(f"superpotential layer(r) with slope {slope}")
        return self.applied()

    def applied(self):
        """The law `layer` where it acts, perhaps with friction beside it."""
        draw, k = self.draw, self.stiff
        rate = chr(39) if draw.random() < 0.3 and self.kind not in ("inertia", "on springs", "on laws") else ""
        if not self.vector:
            return f"integral(ground, layer^0(u{rate}/{self.size!r}; v/{self.size!r}))" if not self.two else \
                f"integral(seam, layer^0(jump(u{rate})/{self.size!r}; jump(v)/{self.size!r}))"
        part, of = ("seam", lambda w: f"jump({w})") if self.two else ("ground", lambda w: w)
        laws = [f"layer^0({of('u' + rate)}.nu/{self.size!r}; {of('v')}.nu/{self.size!r})"]
        if self.kind == "on laws":
            self.lines.append(f"superpotential hold(w) = {3 * k!r}*norm(w)^2")
            laws.append(f"hold^0(u/{self.size!r}; v/{self.size!r})")
        elif draw.random() < 0.5 and self.kind != "on springs":
            self.lines.append(f"superpotential slip(w) = {0.02 * k!r}*norm(w)")
            laws.append(f"slip^0({of('u' + draw.choice(('', chr(39))))}.tau/{self.size!r}; {of('v')}.tau/{self.size!r})")
        return f"integral({part}, {' + '.join(laws)})"

    def vectors(self, *numbers):
        return "[" + ", ".join(numbers[:self.dim]) + "]" if self.vector else numbers[-1] if self.dim == 1 else numbers[0]

    def script(self):
        draw, k = self.draw, self.stiff
        self.mesh()
        self.materials()
        terms = self.terms()
        zeros = self.vectors("0", "0", "0")
        moves = draw.random() < 0.4 and not self.ring and self.kind == "own cells"
        held = [] if self.kind in ("on springs", "on laws") else ["zero on base"] * self.two + ["zero on roof"] + ["periodic low = high"] * (self.kind == "periodic")
        space = f"space V = {'vector' if self.vector else 'scalar'} P{self.order} on body" + "".join(f", {one}" for one in held)
        load = self.vectors(f"{0.1 * k / self.size!r}*t", f"{-0.2 * k / self.size!r}*t", f"{0.05 * k / self.size!r}*t")
        find = f"find u in V"
        if moves:
            find += f" with u = {self.vectors(*[f'{0.01 * self.size!r}*t'] * 3)} on roof"
        find += f" for t in [0, 1] {draw.choice(('by 4 steps', 'at graded(5, 2)'))} from u = {zeros}"
        if self.kind == "inertia":
            find += f", u' = {zeros}"
        n = 3 if self.ring else self.dim  # in units of the body, lest small numbers count as rounding
        strained = "norm(eps(u))" if self.vector else f"norm(grad(u))*{self.size!r}"
        columns = [f"strain = integral(body, {strained})/{self.size ** n!r}",
                   f"total = integral(body, {'u.x' if self.vector else 'u'})/{self.size ** (n + 1)!r}"]
        if self.kind not in ("no laws", "slender"):
            columns.append(f"press = integral({'seam' if self.two else 'ground'}, layer.xi)/{k * self.size ** (n - 2)!r}")
        if self.kind == "heat":
            self.lines += [f"space W = scalar P1 on body, zero on roof"]
            find = find.replace("find u in V", "find u in V, theta in W").replace(f"from u = {zeros}", f"from u = {zeros}, theta = 0")
            terms.insert(0, "integral(body, theta'*eta + dot(grad(theta), grad(eta)))")
        if self.scheme:
            find += f" using scheme = {self.scheme}"
        such = "such that for all v in V" + (", eta in W" if self.kind == "heat" else "")
        right = f" >= integral(body, {'dot(' + load + ', v)' if self.vector else load + '*v'})" + (" + integral(ground, eta)" if self.kind == "heat" else "")
        return "\n".join([*self.lines, space, find, such, "    " + "\n  + ".join(terms), right, "", "report", "  table " + ", ".join(columns)]) + "\n"


def judge(program, path, folder, ranks, kind):
    """What is wrong, or nothing; and a word on the case. Slender bodies, which are refined with residuals in twice the
    precision, agree to what rounding may have changed, as the run says; one process has rows that are others to rounding."""
    direct, a = iterative.run(program, path, folder, "direct")
    if direct.returncode != 0:
        return None, f"no answer ({direct.returncode}): {direct.stderr[:300]}"
    words, effects = [], None
    for n in ranks if kind == "slender" else [1, *ranks]:
        done, b = iterative.run(program, path, folder, "iterative", processes=n)
        if done.returncode != 0:
            return f"{n} processes end with {done.returncode}: {done.stderr[-600:]}", ""
        if not b["certificate"]["certified"]:
            return f"not certified with {n} processes", ""
        found = [(effect["name"], effect["state"]) for effect in b["plan"]["effects"]]  # symmetry is one of them
        effects = effects or found
        if found != effects:
            return f"other effects with {n} processes: {set(found) ^ set(effects)}", ""
        by = b["plan"].get("assembled_by", 1)
        if by != n:
            return f"{by} of {n} processes assemble", ""
        difference, column = iterative.apart(a, b)
        if difference > max(iterative.AGREE, a["forward_error"]["solution"] if kind == "slender" else 0):
            return f"{column} apart by {difference:.2e} with {n} processes", ""
        words.append(f"{n}: {difference:.1e}{', refined' * b['forward_error']['refined']}")
    return None, "apart " + ", ".join(words)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ranks", default="2,3")
    parser.add_argument("--only")
    parser.add_argument("--keep")
    options = parser.parse_args()
    if shutil.which("mpirun") is None:
        print("no mpirun")
        sys.exit(iterative.SKIPPED)
    ranks = [int(n) for n in options.ranks.split(",")]
    wrong = answers = 0
    with tempfile.TemporaryDirectory() as room:
        folder = pathlib.Path(options.keep or room)
        folder.mkdir(exist_ok=True)
        (folder / "rise.csv").write_text(TABLE)
        for seed in range(options.seed, options.seed + options.scenes):
            scene = Scene(seed)
            path = folder / f"scene{seed}.hvi"
            path.write_text(scene.script())
            if options.only and options.only != path.stem:
                continue
            found, word = judge(options.program, path, folder, ranks, scene.kind)
            if found and " apart by " in found:  # as in iterative.py
                path.write_text(path.read_text().replace("\nsuch that", " using tolerance = 1e-13\nsuch that"))
                found, word = judge(options.program, path, folder, ranks, scene.kind)
                word += ", tolerance 1e-13"
            if found and iterative.NO_MODULE in found:
                sys.exit(iterative.SKIPPED)
            wrong += found is not None
            answers += word.startswith("apart")
            what = f"{scene.kind}{' ' * bool(scene.scheme)}{scene.scheme}, {scene.dim}D"
            print(f"{'FAILS' if found else 'ok   '} scene{seed} ({what}): {found or word}", flush=True)
    print(f"{answers} answers compared, all assembled by all processes, {wrong} wrong")
    sys.exit(wrong > 0 or 2 * answers < options.scenes and not options.only)


main()
