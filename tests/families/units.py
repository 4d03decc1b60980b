"""The same scene in other units: the same answer, as many decades as the units are apart.

usage: units.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

A scene is written with the dimension of each number, `<3;F L-2>`, and solved twice: as it stands, and with other units of length L, force F, time T,
temperature K and voltage V. These are powers of two, so that no number is rounded in being written. Bodies with friction, memories, inertia and
states; pastes; flows that slip; pore water; heat that friction makes, in one body or two; heated pastes; currents through contacts; bodies that laws alone hold;
piezoelectric and damaged ones. Each column of the table must be the same but for its own unit, and so must what `check` says of A, the laws, the loads,
and what theorems and steps have one solution. (m_B, and what follows from it, depends on units where two unknowns act on each other, by u and by u'.)
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

SAME = 1e-8  # of the largest value of a column
REST = 1e-6  # as it stands; columns are larger, or rounding
REACH = {"L": 10, "F": 20, "T": 10, "K": 10, "V": 10}  # powers of two
NUMBER = re.compile(r"<([^;<>]+);([^;<>]*)>")


def factor(dimension, units):
    """Of a dimension such as "F L-2"."""
    out = 1.0
    for name, power in re.findall(r"([A-Z])(-?\d*)", dimension):
        out *= 2.0 ** (units[name] * int(power or "1"))
    return out


def written(text, units):
    return NUMBER.sub(lambda m: repr(float(m[1]) * factor(m[2], units)), text)


class Scene:
    """A script with dimensions, and the columns of its table with theirs."""

    def __init__(self, random):
        self.random = random
        self.dim = int(random.choice([2, 2, 3]))
        kinds = [self.block, self.paste, self.flow, self.pores, self.warm, self.warm_paste, self.current, self.table, self.sandwich, self.piezo, self.damaged]
        self.kind = kinds[int(random.integers(len(kinds)))]
        self.columns = {}
        self.text = self.kind()
        self.solver = "iterative" if random.random() < 0.25 else "direct"

    def pick(self, *options):
        return options[int(self.random.integers(len(options)))]

    def size(self, least, most):
        """A number between, in decades."""
        return f"{10 ** self.random.uniform(np.log10(least), np.log10(most)):.3g}"

    def vector(self, *parts):
        return "[" + ", ".join(([*parts, "0"])[:self.dim]) + "]"

    def body(self, cells):
        shape = ("rectangle(<1;L>, <0.5;L>, cells = [{0}, {1}])" if self.dim == 2
                 else "box(<1;L>, <0.5;L>, <0.5;L>, cells = [{0}, {1}, {1}])").format(2 * cells, cells)
        return f"mesh body = {shape}\npart ground = body.bottom\npart roof = body.top\npart flank = body.right\npart wall = body.left\n"

    def near(self, *shares):
        """A point of the body."""
        return "[" + ", ".join(f"<{s * l};L>" for s, l in zip((*shares, 0.5), (1, 0.5, 0.5)[:self.dim])) + "]"

    def report(self, **columns):
        self.columns = {name: dimension for name, (_, dimension) in columns.items()}
        return "report\n  table " + ", ".join(f"{name} = {what}" for name, (what, _) in columns.items()) + "\n"

    def find(self, what, forms, loads, start, static=False):
        grid = "" if static else f" for t in [0, <1;T>] by {self.pick(3, 5)} steps from {start}"
        return (f"find {what}{grid}\nsuch that for all v in V{self.tests}\n    " + "\n  + ".join(forms)
                + f"\n >= {loads}\n").replace("+ -", "- ")

    def block(self):
        """A viscoelastic body on a layer that softens, with friction; a memory, inertia, or a state at choice."""
        self.tests, d = "", self.dim
        state, moves = self.random.random() < 0.4, self.random.random() < 0.3
        forms = [f"integral(body, A : eps(u') : eps(v))", "integral(body, B : eps(u) : eps(v))"]
        text = self.body(2) + (f"tensor A = isotropic(lambda = <5;F L-2 T>, mu = <{self.size(0.1, 10)};F L-2 T>)\n"
                               f"tensor B = isotropic(young = <{self.size(50, 500)};F L-2>, poisson = 0.3)\n")
        if self.random.random() < 0.5:
            text += "kernel C(lag) = " + self.pick("-<0.3;T-1>*exp(-lag/<0.5;T>)*B", "-<0.2;T-1>/(1 + lag/<0.3;T>)^2*B") + "\n"
            forms.append("integral(body, history(C, eps(u)) : eps(v))")
        if moves:
            forms.append("integral(body, <0.5;F T2 L-4>*dot(u'', v))")
        text += ("superpotential layer(r) with slope\n  | r < <0;L> -> <0;F L-2>\n  | r < <0.02;L> -> <100;F L-3>*r\n"
                 "  | r < <0.08;L> -> <2;F L-2> - <15;F L-3>*(r - <0.02;L>)\n  | otherwise -> <1.1;F L-2>\n")
        text += "superpotential rub(w) = " + self.pick("<0.3;F L-2>", "0.3*abs(layer.xi)") + "*norm(w)\n"
        slip = self.pick("u", "u'")
        forms.append(f"integral(ground, layer^0(u.nu; v.nu) + rub^0({slip}.tau; v.tau))")
        columns = dict(down=(f"u.y at {self.near(1, 1)}", "L"), push=("integral(ground, layer.xi)", f"F L{d - 3}"),
                       drag=("integral(ground, rub.xi.x)", f"F L{d - 3}"))
        if state:
            text += "state bond on ground with rate -max(<0;T-1>, <2e4;L-2 T-1>*bond*u.nu^2 - <0.002;T-1>) from bond = 1 in [0, 1]\n"
            text += "superpotential glue(r) = <200;F L-3>*bond^2*max(-r, <0;L>)^2\n"
            forms.append("integral(ground, glue^0(u.nu; v.nu))")
            columns["bonded"] = ("integral(ground, bond)", f"L{d - 1}")
        text += f"space V = vector {self.pick('P1', 'P2')} on body, zero on wall\n"
        loads = f"integral(roof, dot({self.vector('<1;F L-2 T-1>*t', '-<4;F L-2 T-1>*t')}, v))"
        return text + self.find("u in V", forms, loads, "u = 0") + self.report(**columns)

    def paste(self):
        """With a yield stress, between walls that slip, driven by a shear of the roof."""
        self.tests, self.dim = ", q in Q", 2
        g = self.size(0.1, 3)
        text = self.body(int(self.random.integers(2, 5))) + (f"superpotential paste(xi) = <{g};F L-2>*norm(xi)\n"
                               f"superpotential slip(w) = <{self.size(0.05, 1)};F L-2>*norm(w)\n"
                               "space V = vector P2 on body, zero.y on ground, zero on wall, zero.y on roof\nspace Q = scalar P1 on body\n")
        forms = ["integral(body, <2;F L-2 T>*eps(u) : eps(v) + paste^0(eps(u); eps(v)))", "-integral(body, p*div(v))",
                 "integral(body, q*div(u))", "integral(ground, slip^0(u.tau; v.tau))"]
        loads = f"integral(roof, dot([<{self.size(1, 9)};F L-2>, <0;F L-2>], v))"
        return text + self.find("u in V, p in Q", forms, loads, "", static=True) + self.report(
            flows=("u.x at [<0.5;L>, <0.5;L>]", "L T-1"), power=("integral(body, eps(u) : eps(u))", "T-2 L2"))

    def flow(self):
        """Stokes flow through a channel whose wall slips beyond a bound."""
        self.tests, d = ", q in Q", self.dim
        text = self.body(2 if d == 2 else 1) + (f"superpotential slip(w) = <{self.size(0.05, 1)};F L-2>*norm(w) + <{self.size(0.1, 3)};F L-3 T>*norm(w)^2\n"
                               "space V = vector P2 on body, zero.y on ground, zero on roof\nspace Q = scalar P1 on body\n")
        if d == 3:
            text = text.replace("zero on roof\n", "zero on roof, zero.z on front, zero.z on back\n").replace(
                "part wall", "part front = body.front\npart back = body.back\npart wall")
        forms = ["integral(body, <2;F L-2 T>*eps(u) : eps(v))", "-integral(body, p*div(v))", "integral(body, q*div(u))",
                 "integral(ground, slip^0(u.tau; v.tau))"]
        loads = f"integral(wall, <{self.size(0.5, 9)};F L-2>*v.x)"
        return text + self.find("u in V, p in Q", forms, loads, "", static=True) + self.report(
            flows=("u.x at " + self.near(0.5, 0), "L T-1"), drag=("integral(ground, slip.xi.x)", f"F L{d - 3}"), pressed=("p at " + self.near(0.5, 0.5), "F L-2"))

    def pores(self):
        """Pore water in a body on a layer that softens."""
        self.tests, d = ", q in Q", self.dim
        k = self.size(0.01, 1)
        text = self.body(2) + (f"tensor B = isotropic(young = <{self.size(10, 100)};F L-2>, poisson = 0.25)\n"
                               "superpotential layer(r) with slope\n  | r < <0;L> -> <0;F L-2>\n  | r < <0.05;L> -> <50;F L-3>*r\n"
                               "  | otherwise -> <2.5;F L-2> - <3;F L-3>*min(r - <0.05;L>, <0.3;L>)\n"
                               "space V = vector P2 on body, zero on wall\nspace Q = scalar P1 on body, zero on roof\n")
        forms = ["integral(body, B : eps(u) : eps(v))", "-integral(body, p*div(v))", "integral(body, div(u')*q)",
                 f"integral(body, <{k};L4 F-1 T-1>*dot(grad(p), grad(q)))", "integral(ground, layer^0(u.nu; v.nu))"]
        loads = f"integral(roof, -<{self.size(0.5, 3)};F L-2>*v.y)"
        return text + self.find("u in V, p in Q", forms, loads, "u = 0, p = 0") + self.report(
            down=("u.y at " + self.near(1, 1), "L"), pore=("p at " + self.near(0.5, 0), "F L-2"), push=("integral(ground, layer.xi)", f"F L{d - 3}"))

    def warm(self):
        """Friction that heats, and becomes weaker with heat; a ground that takes heat where it is pressed."""
        self.tests, d = ", eta in W", self.dim
        text = self.body(2) + ("tensor A = isotropic(lambda = <5;F L-2 T>, mu = <10;F L-2 T>)\n"
                               f"tensor B = isotropic(young = <{self.size(50, 300)};F L-2>, poisson = 0.3)\n"
                               "superpotential press(r) = <200;F L-3>*max(<0;L>, r)^2\n"
                               f"superpotential rub(w) = 0.3*(1 - <{self.size(0.01, 0.2)};K-1>*min(abs(theta), <4;K>))*abs(press.xi)*norm(w)\n"
                               f"superpotential sink(s) = <{self.size(0.05, 2)};F L-1 T-1 K-1>*s^2\n"
                               "space V = vector P1 on body, zero on roof\nspace W = scalar P1 on body, zero on roof\n")
        moved = self.vector("<0.1;L T-1>*t", "-<0.05;L T-1>*t")
        forms = ["integral(body, A : eps(u') : eps(v))", "integral(body, B : eps(u) : eps(v))",
                 f"-integral(body, <{self.size(0.1, 3)};F L-2 K-1>*theta*div(v))", "integral(body, <1;F L-2 K-1>*theta'*eta)",
                 "integral(body, <1;F T-1 K-1>*dot(grad(theta), grad(eta)))", "integral(ground, press^0(u.nu; v.nu) + rub^0(u'.tau; v.tau))",
                 "integral(ground, sink^0(theta; eta))", "-integral(ground, dot(rub.xi, u'.tau)*eta)"]
        return text + self.find(f"u in V, theta in W with u = {moved} on roof", forms, "0", "u = 0, theta = 0") + self.report(
            warmth=("theta at " + self.near(0.5, 0), "K"), drag=("integral(ground, rub.xi.x)", f"F L{d - 3}"), push=("integral(ground, press.xi)", f"F L{d - 3}"))

    def warm_paste(self):
        """Flow along one axis beyond a yield stress that heat lowers."""
        self.tests, self.dim = ", eta in W", 2
        text = self.body(3) + (f"superpotential paste(xi) = <{self.size(0.2, 1)};F L-2>*(1 - <0.1;K-1>*min(abs(theta), <3;K>))*norm(xi)\n"
                               "space V = scalar P1 on body, zero on ground\nspace W = scalar P1 on body, zero on ground\n")
        forms = ["integral(body, <2;F L-2 T>*dot(grad(u), grad(v)))", "integral(body, paste^0(grad(u); grad(v)))",
                 "integral(body, <1;F L-2 K-1>*theta'*eta)", "integral(body, <0.3;F T-1 K-1>*dot(grad(theta), grad(eta)))"]
        loads = f"integral(roof, <{self.size(1, 5)};F L-2 T-1>*t*v) + integral(body, <2;F L-2 T>*dot(grad(u), grad(u))*eta)"
        return text + self.find("u in V, theta in W", forms, loads, "u = 0, theta = 0") + self.report(
            flows=("u at " + self.near(0.5, 1), "L T-1"), warmth=("theta at " + self.near(0.5, 1), "K"))

    def current(self):
        """Through a ground that conducts where it is pressed, beyond a voltage; currents heat, and heat swells the body."""
        self.tests, d = ", psi in Q, eta in W", self.dim
        text = self.body(2) + (f"tensor B = isotropic(young = <{self.size(50, 300)};F L-2>, poisson = 0.3)\n"
                               "superpotential press(r) = <200;F L-3>*max(<0;L>, r)^2\n"
                               # a conductivity has F T-1 V-2: power is F L T-1
                               f"superpotential leak(s) = (1 + min(abs(u.nu), <0.02;L>)/<0.01;L>)*<{self.size(0.1, 3)};F L-1 T-1 V-2>*s^2 + <{self.size(0.05, 1)};F L-1 T-1 V-1>*abs(s)\n"
                               "space V = vector P1 on body, zero on roof\nspace Q = scalar P1 on body, zero on roof\nspace W = scalar P1 on body, zero on roof\n")
        moved = self.vector("<0;L T-1>*t", "-<0.02;L T-1>*t")
        forms = ["integral(body, B : eps(u) : eps(v))", f"-integral(body, <{self.size(0.1, 3)};F L-2 K-1>*theta*div(v))",
                 "integral(body, <2;F T-1 V-2>*dot(grad(phi), grad(psi)))", "integral(body, <1;F L-2 K-1>*theta'*eta)",
                 "integral(body, <1;F T-1 K-1>*dot(grad(theta), grad(eta)))", "integral(ground, press^0(u.nu; v.nu) + leak^0(phi; psi))",
                 "-integral(ground, leak.xi*phi*eta)"]
        return text + self.find(f"u in V, phi in Q, theta in W with u = {moved} on roof, phi = <3;V T-1>*t on roof", forms, "0",
                                "u = 0, phi = 0, theta = 0") + self.report(
            current=("integral(ground, leak.xi)", f"F L{d - 2} T-1 V-1"), warmth=("theta at " + self.near(0.5, 0), "K"),
            push=("integral(ground, press.xi)", f"F L{d - 3}"))


    def table(self):
        """A body that nothing holds but a rigid ground and its friction."""
        self.tests, d = "", self.dim
        text = self.body(2) + ("tensor A = isotropic(lambda = <1;F L-2 T>, mu = <2;F L-2 T>)\n"
                               f"tensor B = isotropic(young = <{self.size(20, 300)};F L-2>, poisson = 0.3)\n"
                               "superpotential rigid(r) with slope\n  | r < <0;L> -> <0;F L-2>\n  | otherwise -> 1e300\n"
                               "superpotential rub(w) = 0.4*rigid.xi*norm(w)\nspace V = vector P1 on body\n")
        forms = ["integral(body, A : eps(u') : eps(v))", "integral(body, B : eps(u) : eps(v))",
                 "integral(ground, rigid^0(u.nu; v.nu) + rub^0(u'.tau; v.tau))"]
        push = self.vector("<0.3;F L-2 T-1>*t", "-<0.2;F L-2 T-1>*t")
        loads = f"integral(body, -<2;F L-3>*v.y) + integral(roof, dot({push}, v))"
        return text + self.find("u in V", forms, loads, "u = 0") + self.report(
            aside=("u.x at " + self.near(1, 1), "L"), push=("integral(ground, rigid.xi)", f"F L{d - 3}"),
            drag=("integral(ground, rub.xi.x)", f"F L{d - 3}"))

    def sandwich(self):
        """Two bodies that rub and heat each other, with a film that conducts."""
        self.tests, d = ", eta in W", self.dim
        one, other = (("rectangle(<1;L>, <0.5;L>, cells = [3, 2])", "rectangle(<1;L>, <0.5;L>, cells = [2, 2], at = [<0;L>, <0.5;L>])") if d == 2 else
                      ("box(<1;L>, <0.5;L>, <0.5;L>, cells = [2, 1, 1])", "box(<1;L>, <0.5;L>, <0.5;L>, cells = [2, 1, 1], at = [<0;L>, <0.5;L>, <0;L>])"))
        text = (f"mesh lower = {one}\nmesh upper = {other}\nmesh body = lower + upper\npart base = lower.bottom\npart roof = upper.top\n"
                "part seam = pair(upper.bottom, lower.top)\n"
                "tensor A = isotropic(lambda = <5;F L-2 T>, mu = <10;F L-2 T>)\n"
                f"tensor B = isotropic(young = <{self.size(50, 300)};F L-2>, poisson = 0.3)\n"
                f"superpotential press(r) = <{self.size(50, 5000)};F L-3>*max(<0;L>, r)^2\n"
                f"superpotential rub(w) = 0.3*(1 - <{self.size(0.01, 0.2)};K-1>*min(abs(mean(theta)), <4;K>))*abs(press.xi)*norm(w)\n"
                f"superpotential film(s) = <{self.size(0.05, 20)};F L-1 T-1 K-1>*s^2\n"
                "space V = vector P1 on body, zero on base, zero on roof\nspace W = scalar P1 on body, zero on base\n")
        moved = self.vector("<0.1;L T-1>*t", "-<0.05;L T-1>*t")
        forms = ["integral(body, A : eps(u') : eps(v))", "integral(body, B : eps(u) : eps(v))",
                 f"-integral(body, <{self.size(0.1, 3)};F L-2 K-1>*theta*div(v))", "integral(body, <1;F L-2 K-1>*theta'*eta)",
                 "integral(body, <1;F T-1 K-1>*dot(grad(theta), grad(eta)))",
                 "integral(seam, press^0(jump(u).nu; jump(v).nu) + rub^0(jump(u').tau; jump(v).tau) + film^0(jump(theta); jump(eta)))",
                 "-integral(seam, dot(rub.xi, jump(u').tau)*mean(eta))"]
        return text + self.find(f"u in V, theta in W with u = {moved} on roof", forms, "0", "u = 0, theta = 0") + self.report(
            warmth=("theta at " + self.near(0.5, 0.5), "K"), drag=("integral(seam, rub.xi.x)", f"F L{d - 3}"), push=("integral(seam, press.xi)", f"F L{d - 3}"))

    def piezo(self):
        """A voltage bends a body until it meets a stop."""
        self.tests, d = ", psi in Q", self.dim
        e = self.size(0.1, 10)
        text = self.body(2) + (f"tensor B = isotropic(young = <{self.size(20, 300)};F L-2>, poisson = 0.3)\n"
                               f"superpotential stop(r) = <{self.size(1, 300)};F L-3>*max(<0;L>, r - <0.001;L>)^2\n"
                               f"space V = vector {self.pick('P1', 'P2')} on body, zero on wall\nspace Q = scalar P1 on body, zero on ground, zero on roof\n")
        forms = ["integral(body, B : eps(u) : eps(v))", f"-integral(body, <{e};F L-1 V-1>*grad(phi).y*(eps(v).xx))",
                 f"integral(body, <{e};F L-1 V-1>*(eps(u).xx)*grad(psi).y)", "integral(body, <1;F V-2>*dot(grad(phi), grad(psi)))",
                 "integral(flank, stop^0(u.nu; v.nu))"]
        return text + self.find("u in V, phi in Q with phi = <2;V T-1>*t on roof", forms, f"integral(roof, <{self.size(0.1, 3)};F L-2 T-1>*t*v.x)",
                                "u = 0, phi = 0") + self.report(
            far=("u.x at " + self.near(1, 1), "L"), push=("integral(flank, stop.xi)", f"F L{d - 3}"), half=("phi at " + self.near(0.5, 0.5), "V"))

    def damaged(self):
        """A body that strains damage, on a ground with friction."""
        self.tests, d = "", self.dim
        text = self.body(2) + ("tensor A = isotropic(lambda = <2;F L-2 T>, mu = <4;F L-2 T>)\n"
                               f"tensor B = isotropic(young = <{self.size(50, 300)};F L-2>, poisson = 0.3)\n"
                               f"state d on body with rate <{self.size(5, 500)};T-1>*(eps(u) : eps(u)) from d = 0 in [0, 0.9]\n"
                               "superpotential press(r) = <100;F L-3>*max(<0;L>, r)^2\nsuperpotential rub(w) = <0.2;F L-2>*norm(w)\n"
                               f"space V = vector {self.pick('P1', 'P2')} on body, zero on wall\n")
        forms = ["integral(body, A : eps(u') : eps(v))", "integral(body, (1 - d)*B : eps(u) : eps(v))",
                 "integral(ground, press^0(u.nu; v.nu) + rub^0(u'.tau; v.tau))"]
        loads = f"integral(roof, dot({self.vector('<1;F L-2 T-1>*t', '-<4;F L-2 T-1>*t')}, v))"
        return text + self.find("u in V", forms, loads, "u = 0") + self.report(
            down=("u.y at " + self.near(1, 1), "L"), push=("integral(ground, press.xi)", f"F L{d - 3}"), lost=("integral(body, d)", f"L{d}"))


def table(program, folder, name, script, solver):
    """Columns by name; or what was said."""
    (folder / f"{name}.hvi").write_text(script)
    done = subprocess.run([program, f"{name}.hvi", "--no-files", "--quiet", "--solver", solver], cwd=folder, capture_output=True, text=True, timeout=300)
    if done.returncode:
        return " | ".join(re.findall(r"error\[E\d+\].*", done.stderr)[:2]) or f"exit {done.returncode}: {done.stderr[-300:]}"
    lines = [line.split() for line in done.stdout.strip().split("\n")]
    return dict(zip(lines[0], np.array(lines[1:], float).T))


def compared(program, folder, scene, plain, other, unit):
    """What is wrong with the other script, or nothing; and how far apart the worst column is. `unit`: of a dimension, in the other script."""
    first = table(program, folder, "plain", plain, scene.solver)
    second = table(program, folder, "other", other, scene.solver)
    if isinstance(first, str):
        return f"refused as it stands: {first}", 0.0
    if isinstance(second, str):
        return f"refused otherwise: {second}", 0.0
    worst = 0.0
    for name, dimension in scene.columns.items():
        apart = np.abs(second[name] / unit(dimension) - first[name]).max()
        worst = max(worst, apart / max(np.abs(first[name]).max(), REST))
    return (f"another answer, {worst:.1e}" if worst > SAME else ""), worst


def verdicts(program, folder, name, scene):
    """What `check` says that does not depend on units."""
    done = subprocess.run([program, "check", f"{name}.hvi", "--json", f"{name}.json"], cwd=folder, capture_output=True, text=True, timeout=300)
    rows = json.loads((folder / f"{name}.json").read_text())["hypotheses"]
    judged = ("H(A)", "H(J)", "H(f)", "rates", "theorem") + (() if scene.kind == scene.pores else ("H(B)", "(H0)"))
    return ([(row["name"], row["holds"]) for row in rows if row["name"] in judged]
            + [re.sub(r"k < [-+.e\d]+", "k", line) for line in done.stdout.split("\n") if line.startswith(("discrete problem", "continuous problem"))])


def main():
    parse = argparse.ArgumentParser()
    parse.add_argument("program", type=pathlib.Path)
    parse.add_argument("--scenes", type=int, default=30)
    parse.add_argument("--seed", type=int, default=1)
    parse.add_argument("--only", type=int)
    parse.add_argument("--keep", type=pathlib.Path)
    words = parse.parse_args()
    program, wrong, worst = words.program.resolve(), 0, 0.0
    for k in range(words.scenes) if words.only is None else [words.only]:
        random = np.random.default_rng([words.seed, k])
        scene = Scene(random)
        units = {name: int(random.integers(-reach, reach + 1)) for name, reach in REACH.items()}
        with tempfile.TemporaryDirectory() as name:
            plain, other = written(scene.text, dict.fromkeys(REACH, 0)), written(scene.text, units)
            folder = words.keep or pathlib.Path(name)
            said, apart = compared(program, folder, scene, plain, other, lambda dimension: factor(dimension, units))
            first, second = (verdicts(program, folder, script, scene) for script in ("plain", "other"))
        if first != second:
            said += "; other verdicts: " + ", ".join(f"{a} and {b}" for a, b in zip(first, second) if a != b)
        worst = max(worst, apart)
        if said:
            wrong += 1
            print(f"scene {k} ({scene.kind.__name__}, {scene.dim}D, {scene.solver}, {units}): {said}")
    print(f"{words.scenes} scenes, worst {worst:.1e}; {wrong} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
