"""What may stand together, put together at random: every script is solved, certified, checked and planned.

usage: combinations.py HVI_RUN [--scenes N] [--seed S] [--keep FOLDER]

A block on a ground, with one choice of each: dimension, element, scheme with or without inertia, grid, viscosity, memory and its route, values
that move, one to three laws, each on u, u', a memory or a sum, through each M, by each rule, with a constant bound, Coulomb's, one that falls with the
slip rate, one that reads a memory or a state, states on the ground and in the body, a pair of bodies in place of one. Nothing is compared with
a reference, as the other families do; but no combination may be refused, and `check` and `plan` must end.
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

GRIDS = ["by 6 steps", "at [0, 0.1, 0.15, 0.4, 0.7, 1]", "at graded(6, 2)"]
ROUTES = ["automatic", "direct", "tree", "fit"]


class Scene:
    def __init__(self, random):
        pick = lambda *options: str(random.choice(options))
        self.dim, self.element = int(random.choice([2, 2, 3])), pick("P1", "P2")
        self.motion = random.random() < 0.4
        self.scheme = pick("backward_euler", "bdf2", *(("newmark", "hht", "midpoint") * self.motion))
        self.grid, self.route = pick(*GRIDS), pick(*ROUTES)
        self.memory, self.moves = random.random() < 0.5, random.random() < 0.4
        self.on_ground, self.in_body = random.random() < 0.4, random.random() < 0.3
        self.pair = random.random() < 0.2
        self.laws, self.lines = [], []
        self.normal(random, pick)
        for name in ("rub", "extra")[:int(random.integers(0, 3))]:
            self.tangential(name, random, pick)

    def see(self, random, pick):
        """(u, v) of an argument, in which {} is M."""
        kind = pick("u", "rate", "rate", "memory", "sum")
        u = "jump(u{})" if self.pair else "u{}"
        of = {"u": u.format("") + "{0}", "rate": u.format("'") + "{0}",
              "memory": ("jump(history(own, u))" if self.pair else "history(own, u)") + "{0}"}
        of["sum"] = of["u"] + " + 0.3*" + of["rate"]
        return kind, of[kind], ("jump(v)" if self.pair else "v") + "{0}"

    def rule(self, random, pick):
        return "" if self.pair else pick("", ", rule = nodal", ", rule = gauss", ", rule = midpoint")

    def normal(self, random, pick):
        kind, u, v = self.see(random, pick)
        self.lines.append("superpotential layer(r) with slope\n  | r < 0 -> 0\n  | otherwise -> "
                          + pick("20*r", "20*r/(1 + r)", "10*beta*r" if self.on_ground else "15*r"))
        self.normal_rule = self.rule(random, pick)
        self.laws.append(f"layer^0({u.format('.nu')}; {v.format('.nu')})")

    def tangential(self, name, random, pick):
        kind, u, v = self.see(random, pick)
        bounds = ["0.3", "0.3*abs(layer.xi)", "(0.3 + 0.1*exp(-norm(w)))", "(0.2 + 0.1*exp(-norm(w)))*abs(layer.xi)"]
        if not self.pair:
            bounds.append("(0.3 + 0.1*norm(history(own, u).tau))")
        if self.on_ground:
            bounds += ["(0.3*beta)", "0.2*beta*abs(layer.xi)"]
        bound = pick(*bounds)
        self.lines.append(f"superpotential {name}(w) " + pick(f"with slope {bound}", f"= {bound}*norm(w)" if "exp" not in bound
                                                               else f"with slope {bound}"))
        m = pick(".tau", ".tau", "")
        of = (u.format(m), v.format(m))
        if kind == "u" and not self.pair and random.random() < 0.3 and self.dim == 2:
            of = ("[u.x, u'.y]", "[v.x, v.y]")
        self.laws.append(f"{name}^0({of[0]}; {of[1]})")

    def script(self):
        d, zero = self.dim, ", ".join("0" * self.dim)
        shape = lambda n, at: (f"rectangle(1, 0.5, cells = [{2 * n}, {n}]{at})" if d == 2 else f"box(1, 0.5, 0.5, cells = [{n}, 1, 1]{at})")
        up = {2: ("bottom", "top"), 3: ("bottom", "top")}[d]
        place = ", at = [0, 0.5]" if d == 2 else ", at = [0, 0.5, 0]"
        lines = ([f"mesh upper = {shape(2, place)}", f"mesh lower = {shape(1, '')}", "mesh body = upper + lower",
                  f"part roof = upper.{up[1]}", f"part base = lower.{up[0]}", f"part ground = pair(upper.{up[0]}, lower.{up[1]})"] if self.pair
                 else [f"mesh body = {shape(2, '')}", f"part roof = body.{up[1]}", f"part ground = body.{up[0]}"])
        lines += ["tensor A = isotropic(lambda = 5, mu = 10)", "tensor B = isotropic(young = 70, poisson = 0.3)",
                  "kernel C(lag) = -0.3*exp(-lag)*B", "kernel own(lag) = 2*exp(-lag)"]
        u = "jump(u).nu" if self.pair else "u.nu"
        if self.on_ground and not self.pair:
            lines.append(f"state beta on ground with rate -beta*pos({u}) - 0.1*beta from beta = 1 in [0, 1]")
        if self.in_body:
            lines.append("state d on body with rate 20*(eps(u) : eps(u)) from d = 0 in [0, 0.5]")
        lines += [line.replace("beta", "1") if self.pair else line for line in self.lines]
        lines.append(f"space V = vector {self.element} on body, zero on roof" + (", zero on base" if self.pair else ""))
        pull = ["0.05*sin(3*t)", "-0.02*t", "0"] if d == 2 else ["0.05*sin(3*t)", "-0.02*t", "0.01*t"]
        moves = f" with u = [{', '.join(pull[:d])}] on roof" if self.moves else ""
        route = f", memory = {self.route}" if self.memory and self.route != "automatic" else ""
        lines.append(f"find u in V{moves} for t in [0, 1] {self.grid} from u = 0 using scheme = {self.scheme}{route}")
        weak = "(1 - d)*" if self.in_body else ""
        forms = [f"integral(body, A : eps(u') : eps(v))", f"integral(body, {weak}B : eps(u) : eps(v))"]
        if self.memory:
            forms.append("integral(body, history(C, eps(u)) : eps(v))")
        if self.motion:
            forms.append("integral(body, 0.5*dot(u'', v))")
        forms += [f"integral(ground, {law}{self.normal_rule})" for law in self.laws]
        force = ["2*sin(4*t)", "-3*t", "0"] if d == 2 else ["2*sin(4*t)", "-3*t", "1"]
        lines += ["such that for all v in V", "    " + "\n  + ".join(forms), f" >= integral(body, dot([{', '.join(force[:d])}], v))",
                  "report", "  table size = norm(u), p = integral(ground, layer.xi)"]
        return "\n".join(lines) + "\n"


def run(folder, program, *words):
    return subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, timeout=300)


def tried(program, folder, scene):
    """What went wrong: nothing, or what was said."""
    (folder / "scene.hvi").write_text(scene.script())
    for command in (["run", "scene.hvi", "--quiet", "--monitors", "-o", "whole"], ["check", "scene.hvi"], ["plan", "scene.hvi"]):
        done = run(folder, program, *command)
        if done.returncode:
            said = re.findall(r"(?:error\[E\d+\]|internal).*", done.stderr + done.stdout)
            return f"{command[0]}: exit {done.returncode}: " + " | ".join(said[:2])
    return ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    program, refused = str(pathlib.Path(options.program).resolve()), 0
    for k in range(options.scenes):
        scene = Scene(np.random.default_rng([options.seed, k]))
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.keep or pathlib.Path(temporary)) / str(k)
            folder.mkdir(parents=True, exist_ok=True)
            said = tried(program, folder, scene)
        if said:
            refused += 1
            print(f"scene {k}: {said}", file=sys.stderr)
    print(f"family combinations: scenes {options.scenes}, refused {refused}")
    return 0 if refused == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
