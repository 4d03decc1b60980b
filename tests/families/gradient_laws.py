"""Random bodies whose laws see gradients, against matrices and a minimisation of our own.

usage: gradient_laws.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

A law of M u = G grad u inside a body has one point for each cell of P1. Here G and the forms are assembled anew from the mesh that the script reads,
and every step is solved by the alternating direction method of multipliers, one proximal map for each cell, found by bisection (R. Glowinski,
A. Marrocco, Sur l'approximation, par elements finis d'ordre un, et la resolution, par penalisation-dualite, d'une classe de problemes de Dirichlet
non lineaires, 1975). Scenes: scalars and vectors in 1D, 2D and 3D on meshes with nodes off the lattice, turned, of sizes and stiffnesses decades apart; laws of a number (a strain, div u, a component
of grad u), of a vector (all of grad u, strains, six of them in 3D) and of a matrix (eps(u), its deviator, grad(u) of a vector: four and nine numbers), with jumps, softening, hardening; of u and of u', static and in time; sums of both;
offsets; the iterative solver, too. Runs are certified; values of u and integrals of multipliers agree to 1e-6 of the largest of their kind.
"""
import argparse
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

import numpy

from moved_lattice import lattice, msh

AGREE = 1e-6
ENOUGH = 1e-10  # of the method of multipliers
AXES = "xyz"
MATRICES = ("eps", "dev", "full")


def gradients(x, cell):
    """Of the shape functions, a row each, and the measure of the cell."""
    dim = x.shape[1]
    edges = numpy.array([x[n] - x[cell[0]] for n in cell[1:]])
    inner = numpy.linalg.inv(edges).T
    return numpy.vstack([-inner.sum(0), inner]), abs(numpy.linalg.det(edges)) / [1, 1, 2, 6][dim]


class Law:
    """A slope s(r) with what the script calls it; of a vector, s(|xi|) xi/|xi|."""

    def __init__(self, r, most):
        kind = r.choice(["yield", "soft", "cube", "friction"])
        if kind == "yield":
            g = r.uniform(0.05, 0.6)
            self.scalar, self.radial, self.slope = f"{g!r}*abs(r)", f"{g!r}*norm(xi)", lambda a: numpy.full_like(a, g)
        elif kind == "soft":  # rises to a, falls by less than the forms rise, rises
            k, a, m = r.uniform(1, 5), r.uniform(0.02, 0.1), r.uniform(0.1, 0.7) * most
            text = f"{k!r}*min(abs(r), {a!r}) - {m!r}*max(0, min(abs(r), {3 * a!r}) - {a!r})"
            self.scalar = f"with slope sign(r)*({text})"
            self.radial = f"with slope {text}".replace("abs(r)", "norm(xi)")
            self.slope = lambda v: k * numpy.minimum(v, a) - m * numpy.maximum(0, numpy.minimum(v, 3 * a) - a)
        elif kind == "cube":
            k = r.uniform(1, 20)
            self.scalar, self.radial, self.slope = f"with slope {k!r}*r^3", f"{0.25 * k!r}*norm(xi)^4", lambda a: k * a**3
        else:
            g, k = r.uniform(0.05, 0.4), r.uniform(0.1, 2)
            self.scalar, self.radial = f"{g!r}*abs(r) + {0.5 * k!r}*r^2", f"{g!r}*norm(xi) + {0.5 * k!r}*norm(xi)^2"
            self.slope = lambda a: g + k * a

    def near(self, y, weight):
        """z with weight (z - y) + (the law's force at z) = 0, row by row; by bisection on |z|."""
        size = numpy.linalg.norm(y, axis=1)
        low, high = numpy.zeros_like(size), size + 1.0  # a slope that has fallen below zero pulls on
        for _ in range(60):
            middle = 0.5 * (low + high)
            above = weight * (middle - size) + self.slope(middle) > 0
            high, low = numpy.where(above, middle, high), numpy.where(above, low, middle)
        return y * (0.5 * (low + high) / numpy.maximum(size, 1e-300))[:, None]


def rows_of(kind, dim, d):
    """The argument's text for u, and its coefficients of du_i/dx_j."""
    def unit(*entries):
        m = numpy.zeros((d, dim))
        for i, j, v in entries:
            m[i, j] += v
        return m
    if kind == "grad":
        return "grad({w})", [unit((0, j, 1.0)) for j in range(dim)]
    if kind == "part":
        return f"grad({{w}}).{AXES[dim - 1]}", [unit((0, dim - 1, 1.0))]
    if kind == "div":
        return "div({w})", [unit(*[(i, i, 1.0) for i in range(d)])]
    if kind == "shear":
        return "eps({w}).xy", [unit((0, 1, 0.5), (1, 0, 0.5))]
    if kind == "strain":
        return "[eps({w}).xx, eps({w}).yy, sqrt(2)*eps({w}).xy]", [unit((0, 0, 1.0)), unit((1, 1, 1.0)), unit((0, 1, 0.5**0.5), (1, 0, 0.5**0.5))]
    if kind == "shears":
        return "[eps({w}).xz, eps({w}).yz]", [unit((0, 2, 0.5), (2, 0, 0.5)), unit((1, 2, 0.5), (2, 1, 0.5))]
    if kind == "six":
        pairs = [(1, 2), (0, 2), (0, 1)]
        text = [f"eps({{w}}).{a}{a}" for a in AXES] + [f"sqrt(2)*eps({{w}}).{AXES[i]}{AXES[j]}" for i, j in pairs]
        return f"[{', '.join(text)}]", [unit((i, i, 1.0)) for i in range(3)] + [unit((i, j, 0.5**0.5), (j, i, 0.5**0.5)) for i, j in pairs]
    # All entries of a matrix, row by row: of a symmetric one some of them twice, whose sum of squares is that of its norm.
    entries = [(i, j) for i in range(dim) for j in range(dim)]
    if kind == "full":
        return "grad({w})", [unit((i, j, 1.0)) for i, j in entries]
    mean = [(k, k, -1.0 / dim) for k in range(dim)] if kind == "dev" else []
    return "dev(eps({w}))" if kind == "dev" else "eps({w})", [unit((i, j, 0.5), (j, i, 0.5), *(mean if i == j else [])) for i, j in entries]


def written(kind, dim, offset):
    """An offset, a number for each row, as the script has it."""
    numbers = [repr(float(v)) for v in offset]
    if kind in MATRICES:
        numbers = [f"[{', '.join(numbers[i * dim : (i + 1) * dim])}]" for i in range(dim)]
    return numbers[0] if len(numbers) == 1 else f"[{', '.join(numbers)}]"


class Unsettled(Exception):
    """The method of multipliers creeps."""


class Scene:
    def __init__(self, seed):
        r = random.Random(seed)
        self.dim = r.choice([1, 2, 2, 3])
        self.d = 1 if self.dim == 1 else r.choice([1, self.dim])
        self.x, self.cells = lattice(r, self.dim, {1: r.randint(3, 9), 2: r.randint(2, 5), 3: 2}[self.dim])
        self.held = {i for i, p in enumerate(self.x) if p[0] == 0.0}
        # Turned, of any size and stiffness; strains stay about one.
        size, stiff = 10 ** r.uniform(-3, 3), 10 ** r.uniform(-5, 5)
        turn = numpy.eye(self.dim)
        for a in range(self.dim - 1):
            angle = r.choice([0.0, r.uniform(0, 6.28)])
            about = numpy.eye(self.dim)
            about[a : a + 2, a : a + 2] = [[numpy.cos(angle), -numpy.sin(angle)], [numpy.sin(angle), numpy.cos(angle)]]
            turn = about @ turn
        self.x = size * self.x @ turn.T
        kinds = {(1, 1): ["part"], (2, 1): ["grad", "grad", "part"], (3, 1): ["grad", "grad", "part"], (2, 2): ["div", "shear", "strain", *MATRICES],
                 (3, 3): ["div", "shear", "shears", "six", *MATRICES]}[self.dim, self.d]
        self.kind = r.choice(kinds)
        self.viscosity, self.stiffness = stiff * r.uniform(0.5, 2), stiff * r.uniform(0.5, 2)
        self.steps = r.choice([0, 3])
        self.rate = self.steps > 0 and r.random() < 0.5
        self.radial = self.kind in ("grad", "strain", "shears", "six", *MATRICES)
        # A law on u may soften by less than the stiffness allows; one on the rate by less than the viscosity.
        self.law = Law(r, 0.9 / stiff * (self.viscosity if self.rate else self.stiffness) * (0.5 if self.d > 1 and self.kind != "full" else 1.0) / (self.d if self.kind == "div" else 1))
        rows = len(rows_of(self.kind, self.dim, self.d)[1])
        self.offset = r.choice([0.0, 0.0, 0.07]) * numpy.array([r.uniform(-1, 1) for _ in range(rows)] if self.radial else [1.0])
        if self.kind in ("eps", "dev"):  # one that the argument can have
            at = self.offset.reshape(self.dim, self.dim)
            self.offset = (at + at.T - (2.0 / self.dim * numpy.trace(at) * numpy.eye(self.dim) if self.kind == "dev" else 0.0)).ravel()
        self.share = stiff * r.choice([1.0, 1.0, 0.5])
        self.load = [stiff / size * r.uniform(-1.5, 1.5) for _ in range(self.d)]
        self.rests = False  # somewhere, where forces below a yield stress may be shared in many ways
        self.solver = r.choice(["direct", "iterative"])
        self.probed = sorted(r.sample(sorted(set(range(len(self.x))) - self.held), 3))

    def script(self):
        text, _ = rows_of(self.kind, self.dim, self.d)
        law = self.law.radial if self.radial else self.law.scalar
        head = f"superpotential inner({'xi' if self.radial else 'r'}) {'' if law.startswith('with') else '= '}{law}"
        vector = "scalar" if self.d == 1 else "vector"
        product = "dot(grad({0}), grad(v))" if self.d == 1 else "grad({0}) : grad(v)" if self.kind == "full" else "eps({0}) : eps(v)"
        w = "u'" if self.rate else "u"
        at, tested = text.format(w=w), text.format(w="v")
        if self.offset.any():
            at = f"{at} - {written(self.kind, self.dim, self.offset)}"
        ramp = "t*" if self.steps else ""
        source = f"{ramp}{self.load[0]!r}*v" if self.d == 1 else f"dot({ramp}[{', '.join(repr(v) for v in self.load)}], v)"
        forms = [f"integral(all, {self.stiffness!r}*{product.format('u')})", f"integral(all, {self.share}*inner^0({at}; {tested}))"]
        if self.steps:
            forms.append(f"integral(all, {self.viscosity!r}*{product.format(chr(117) + chr(39))})")
        name = "u" if self.d == 1 else "u.{}"
        columns = [f"p{k}_{i} = {name.format(AXES[i])} at [{', '.join(repr(float(v)) for v in self.x[n])}]" for k, n in enumerate(self.probed)
                   for i in range(self.d)]
        xi = [f"force{c} = integral(all, {of})" for c, of in enumerate(self.multipliers())]
        time = f" for t in [0, 1] by {self.steps} steps from u = 0" if self.steps else ""
        return "\n".join(['mesh body = gmsh("body.msh")', "part all = body.all", "part hold = body.hold", head,
                          f"space V = {vector} P1 on body, zero on hold", f"find u in V{time}", "such that for all v in V", "  " + " + ".join(forms),
                          f" >= integral(all, {source})", "report", "  table " + ", ".join(columns + xi), ""])

    def multipliers(self):
        rows = len(rows_of(self.kind, self.dim, self.d)[1])
        if not self.radial:
            return ["inner.xi"]
        if self.kind == "six":  # only three numbers of a list have names
            return [f"dot(inner.xi, {[int(c == k) for k in range(rows)]})" for c in range(rows)]
        names = [a + b for a in AXES[: self.dim] for b in AXES[: self.dim]] if self.kind in MATRICES else AXES[:rows]
        return [f"inner.xi.{name}" for name in names]

    def solve(self):
        """The columns, a row for each step."""
        n, d, dim = len(self.x), self.d, self.dim
        _, rows = rows_of(self.kind, dim, d)
        k, load, g, weight = numpy.zeros((n * d, n * d)), numpy.zeros(n * d), numpy.zeros((len(self.cells), len(rows), n * d)), []
        for c, cell in enumerate(self.cells):
            slopes, measure = gradients(self.x, cell)
            weight.append(measure)
            strain = []  # of each degree of freedom: du_i/dx_j
            dofs = [node * d + i for node in cell for i in range(d)]
            for a in range(len(cell)):
                for i in range(d):
                    e = numpy.zeros((d, dim))
                    e[i] = slopes[a]
                    strain.append(e)
                    load[cell[a] * d + i] += self.load[i] * measure / (dim + 1)
            sym = [e if d == 1 or self.kind == "full" else 0.5 * (e + e.T) for e in strain]
            for a, p in enumerate(dofs):
                for q, row in enumerate(rows):
                    g[c, q, p] += (row * strain[a]).sum()
                for b, q in enumerate(dofs):
                    k[p, q] += measure * (sym[a] * sym[b]).sum()
        free = [p for p in range(n * d) if p // d not in self.held]
        k, load, g, weight = k[numpy.ix_(free, free)], load[free], g[:, :, free], numpy.array(weight)
        out, u = [], numpy.zeros(len(free))
        for step in range(1, max(1, self.steps) + 1):
            h = 1.0 / self.steps if self.steps else 1.0
            t = step / self.steps if self.steps else 1.0
            # The unknown w of a step: u, or u' with u = u_old + h w.
            if self.rate:
                a, b = (self.viscosity + h * self.stiffness) * k, t * load - self.stiffness * (k @ u)
            elif self.steps:
                a, b = (self.viscosity / h + self.stiffness) * k, t * load + self.viscosity / h * (k @ u)
            else:
                a, b = self.stiffness * k, load
            w, force, z = self.step(a, b, g, weight)
            u = u + h * w if self.rate else w
            full = numpy.zeros(n * d)
            full[free] = u
            row = [full[node * d + i] for node in self.probed for i in range(d)]
            out.append(row + [(weight[:, None] * force).sum(0)[c] for c in range(len(rows))])
            self.rests = self.rests or bool((numpy.linalg.norm(z, axis=1) < 1e-7).any())
        return numpy.array(out)

    def step(self, a, b, g, weight, most=20000):
        rho = 2.0 * (self.stiffness + self.viscosity)
        flat = g.reshape(-1, g.shape[2])
        per_row = numpy.repeat(weight, g.shape[1])
        inverse = numpy.linalg.inv(a + rho * flat.T @ (per_row[:, None] * flat))
        z, force, y = numpy.zeros(g.shape[:2]), numpy.zeros(g.shape[:2]), numpy.zeros(len(b))
        for _ in range(most):
            y = inverse @ (b + flat.T @ (per_row * (rho * (z + self.offset) - force).ravel()))
            at = (flat @ y).reshape(z.shape) - self.offset
            new = self.share_near(at + force / rho, rho)
            force = force + rho * (at - new)
            moved = abs(new - z).max()
            z = new
            if max(moved, abs(at - z).max()) < ENOUGH:
                return y, force / self.share, z
        raise Unsettled

    def share_near(self, y, rho):
        return self.law.near(y, rho / self.share)


def compare(program, scene, folder):
    (folder / "body.msh").write_text(msh(scene.x, scene.cells, {"hold": scene.held}))
    path = folder / "scene.hvi"
    path.write_text(scene.script())
    done = subprocess.run([program, "run", path, "--solver", scene.solver, "--no-files", "--quiet", "--json", folder / "out.json"], capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        return f"exit code {done.returncode}: {done.stdout}{done.stderr}"
    judged = subprocess.run([program, "check", path], capture_output=True, text=True, timeout=300)
    if "M is not compact" not in " ".join(judged.stdout.split()):
        return "`check` takes M for compact"
    planned = subprocess.run([program, "plan", path], capture_output=True, text=True, timeout=300)
    if not re.search(r"law( on the rate)? `inner` on `all`", planned.stdout):
        return "`plan` names another effect"
    answer = json.loads((folder / "out.json").read_text())
    names = [name for name in answer["table"] if name not in ("t", "event")]
    found = numpy.array([answer["table"][name] for name in names]).T[-max(1, scene.steps):]
    try:
        expected = scene.solve()
    except Unsettled:
        return None
    values = 3 * scene.d
    shared = scene.rests and scene.dim > 1  # there are more cells than nodes
    for part in [slice(0, values)] if shared else [slice(0, values), slice(values, None)]:
        least = 1e-3 * (scene.x.max() - scene.x.min()) ** (1 if part.start == 0 else scene.dim)
        off = abs(found[:, part] - expected[:, part]).max() / max(least, abs(expected[:, part]).max())
        if not off <= AGREE:
            return f"off by {off:.2e} in {names[part]}: {found[-1][part]} and {expected[-1][part]}"
    return ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    program = pathlib.Path(options.program).resolve()
    wrong = unsettled = 0
    for k in [options.only] if options.only is not None else range(options.scenes):
        with tempfile.TemporaryDirectory() as scratch:
            folder = options.keep or pathlib.Path(scratch)
            folder.mkdir(parents=True, exist_ok=True)
            scene = Scene(1000 * options.seed + k)
            what = compare(program, scene, folder)
        unsettled += what is None
        if what:
            wrong += 1
            print(f"scene {k} ({scene.dim}D, {scene.d} components, {scene.kind}, {scene.steps} steps, {'rate' if scene.rate else 'u'}, {scene.solver}): {what}")
    print(f"{wrong} wrong, {unsettled} that the reference does not settle")
    return 1 if wrong or 10 * unsettled > options.scenes else 0


sys.exit(main())
