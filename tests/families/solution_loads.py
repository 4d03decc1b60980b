"""Random bodies whose loads read the solution and its gradients, against matrices and a Newton's method of our own.

usage: solution_loads.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

A displacement and a temperature of P1 on meshes with nodes off the lattice, in 1D, 2D and 3D, turned, of sizes and stiffnesses decades apart. Loads of the
body and of its skin read strains, their rates, stresses, divergences, gradients of the temperature, values, a state of the body, the time and the normal,
before values and gradients of both test functions: heat of viscosity, conduction that changes with the temperature, thermal softening, advection. Here each
step is a system of equations of the definition, integrated by a rule of its own, whose Jacobian is found by complex steps, solved to rounding. Static,
backward Euler, and with inertia `newmark` and `midpoint`; the iterative solver, too. Integrands are of degree 2 at most in x, which every rule has exactly.
Runs are certified; values at nodes agree to 1e-8 of the largest of their kind.
"""
import json
import random
import subprocess

import numpy

from moved_lattice import facets_on, lattice, msh
from orientation import seeded

AGREE = 1e-8
AXES = "xyz"


def turned(r, dim):
    """A random rotation; in 1D nothing."""
    if dim == 1:
        return numpy.eye(1)
    q, _ = numpy.linalg.qr(numpy.random.default_rng(r.randrange(2**31)).normal(size=(dim, dim)))
    q[:, 0] *= numpy.sign(numpy.linalg.det(q))
    return q


def points_of_degree_two(n):
    """Barycentric points of equal weights on a simplex with n corners."""
    low = (1.0 - 1.0 / numpy.sqrt(n + 1.0)) / n
    return numpy.full((n, n), low) + (1.0 - n * low) * numpy.eye(n)


class Points:
    """Points of a part: shape functions of the cell, their gradients, weights, normals."""

    def __init__(self, x, cells, entities):
        dim = x.shape[1]
        self.nodes, self.shapes, self.slopes, self.weights, self.normals = [], [], [], [], []
        for corners, k in entities:
            cell = cells[k]
            edges = numpy.array([x[n] - x[cell[0]] for n in cell[1:]])
            inner = numpy.linalg.inv(edges).T
            slopes = numpy.vstack([-inner.sum(0), inner])
            measure = abs(numpy.linalg.det(edges)) / [1, 1, 2, 6][dim]
            normal = numpy.zeros(dim)
            if len(corners) == dim:  # a facet: the gradient of the opposite corner's function points inwards, of size 1 / height
                away = slopes[[cell.index(n) for n in cell if n not in corners][0]]
                normal = -away / numpy.linalg.norm(away)
                measure *= dim * numpy.linalg.norm(away)
            for b in points_of_degree_two(len(corners)):
                shape = numpy.zeros(dim + 1)
                shape[[cell.index(n) for n in corners]] = b
                self.nodes.append(cell), self.shapes.append(shape), self.slopes.append(slopes)
                self.weights.append(measure / len(corners)), self.normals.append(normal)
        for name in ("nodes", "shapes", "slopes", "weights", "normals"):
            setattr(self, name, numpy.array(getattr(self, name)))


def norm(a):
    """Of vectors or matrices, one for each point; complex ones as the analytic function."""
    return numpy.sqrt((a * a).reshape(len(a), -1).sum(1))


def double(a, b):
    return (a * b).reshape(len(a), -1).sum(1)


class Fields:
    """What loads may read at points, for given nodal values."""

    def __init__(self, scene, at, u, v, th, state, t):
        grad = lambda w: numpy.einsum("pna,pni->pia", at.slopes, w[at.nodes])
        sym = lambda g: 0.5 * (g + g.transpose(0, 2, 1))
        self.e, self.ed = sym(grad(u)), sym(grad(v))
        self.u, self.ud = (numpy.einsum("pn,pni->pi", at.shapes, w[at.nodes]) for w in (u, v))
        self.th = numpy.einsum("pn,pn->p", at.shapes, th[at.nodes])
        self.gt = scene.size * numpy.einsum("pna,pn->pa", at.slopes, th[at.nodes])
        self.tr, self.trd = numpy.trace(self.e, axis1=1, axis2=2), numpy.trace(self.ed, axis1=1, axis2=2)
        eye = numpy.eye(scene.dim)
        hooke = lambda e, tr, lam, mu: lam * tr[:, None, None] * eye + 2 * mu * e
        self.visc = hooke(self.ed, self.trd, *scene.viscosity)
        self.sigma = self.visc + hooke(self.e, self.tr, *scene.elasticity) - scene.coupling * self.th[:, None, None] * eye
        self.d, self.t, self.nu = state, t, at.normals


class Scene:
    def __init__(self, seed):
        r = random.Random(seed)
        self.r, self.dim = r, r.choice([1, 2, 2, 3])
        self.kind = r.choice(["backward_euler", "backward_euler", "backward_euler", "static", "newmark", "midpoint"])
        self.moves = self.kind in ("newmark", "midpoint")
        self.size, self.stiff = 10.0 ** r.uniform(-3, 3), 10.0 ** r.uniform(-2, 9)
        x, self.cells = lattice(r, self.dim, {1: 6, 2: r.choice([2, 3]), 3: 2}[self.dim])
        self.held, self.on_skin = ({i for i, p in enumerate(x) if p[0] == side} for side in (0.0, 1.0))
        turn = turned(r, self.dim)
        self.x = self.size * (x @ turn.T)
        self.across = turn[:, 0]  # the normal of what is held
        self.body = Points(self.x, self.cells, [(c, k) for k, c in enumerate(self.cells)])
        self.skin = Points(self.x, self.cells, facets_on(self.cells, self.on_skin, self.dim))
        self.elasticity = (self.stiff * r.uniform(0.3, 1), self.stiff * r.uniform(0.3, 1))
        self.viscosity = (0.0, 0.0) if self.kind == "static" else (self.stiff * r.uniform(0.1, 0.5), self.stiff * r.uniform(0.1, 0.5))
        self.heat = not self.moves
        self.coupling = self.stiff * r.choice([0.0, r.uniform(0.01, 0.1)]) if self.heat else 0.0
        self.steps = 1 if self.kind == "static" else r.choice([3, 5])
        self.state = self.kind != "static" and r.random() < 0.4
        self.force = self.stiff / self.size * numpy.array([r.uniform(-0.1, 0.1) for _ in range(self.dim)])
        # With inertia the body begins with this velocity times the distance from what is held.
        self.swing = numpy.array([r.uniform(-0.3, 0.3) for _ in range(self.dim)])
        self.choose_loads(r)

    def choose_loads(self, r):
        """(part, text with its test function, what stands before it as a function of Fields, how it is tested)."""
        s, stiff, c = self.size, self.stiff, lambda low, high: r.uniform(low, high) * r.choice([-1, 1])
        rates, i, j = self.kind != "static", AXES[r.randrange(self.dim)], AXES[r.randrange(self.dim)]
        a, b = AXES.index(i), AXES.index(j)
        heat, force = [], []

        def add(to, factor, text, value, test, part="body", needs=True):
            if needs:
                to.append((part, f"({factor!r})*{text}", lambda q: factor * value(q), test))

        g = f"{s!r}*grad(theta)"
        add(heat, c(0.5, 4) / stiff, "(A : eps(u') : eps(u'))*eta", lambda q: double(q.visc, q.ed), "eta", needs=rates)
        add(heat, c(0.5, 2), "norm(eps(u'))*(1 + theta)*eta", lambda q: norm(q.ed) * (1 + q.th), "eta", needs=rates)
        add(heat, c(0.5, 4) / stiff, "(sigma : eps(u'))*eta", lambda q: double(q.sigma, q.ed), "eta", needs=rates)
        add(heat, c(0.5, 2) / s, f"dot(u', {g})*eta", lambda q: (q.ud * q.gt).sum(1), "eta", needs=rates)
        add(heat, c(0.5, 2), "div(u)*div(u')*eta", lambda q: q.tr * q.trd, "eta", needs=rates)
        add(heat, c(0.2, 1), f"sqrt(1 + norm({g})^2)*eta", lambda q: numpy.sqrt(1 + (q.gt**2).sum(1)), "eta")
        add(heat, c(0.2, 1), "exp(-norm(eps(u)))*theta*eta", lambda q: numpy.exp(-norm(q.e)) * q.th, "eta")
        add(heat, c(0.5, 2), f"eps(u).{i}{j}*grad(theta).{i}*{s!r}*eta", lambda q: q.e[:, a, b] * q.gt[:, a], "eta")
        add(heat, c(0.2, 1) / stiff, f"abs(sigma.{i}{i})*eta" if self.coupling == 0.0 else f"sigma.{i}{i}*tr(eps(u))*eta",
            (lambda q: numpy.where(q.sigma[:, a, a].real > 0, 1, -1) * q.sigma[:, a, a]) if self.coupling == 0.0 else (lambda q: q.sigma[:, a, a] * q.tr), "eta")
        add(heat, c(0.05, 0.3), f"theta^2*{s!r}*dot({g}, grad(eta))", lambda q: q.th[:, None] ** 2 * q.gt, "grad eta")
        add(heat, -r.uniform(0.1, 1), f"norm({g})^2*{s!r}*dot({g}, grad(eta))", lambda q: (q.gt**2).sum(1)[:, None] * q.gt, "grad eta")
        add(heat, c(0.1, 0.5) / s, f"dot(normal, {g})*theta*eta*{s * s!r}", lambda q: s * s * (q.nu * q.gt).sum(1) * q.th, "eta", part="skin")
        add(heat, c(0.1, 0.5) * s, "norm(eps(u))*eta", lambda q: norm(q.e), "eta", part="skin")
        add(heat, c(0.2, 1), "(1 + d)*theta*norm(eps(u))*eta", lambda q: (1 + q.d) * q.th * norm(q.e), "eta", needs=self.state)
        if self.dim > 1:
            add(heat, c(0.5, 2), "norm(dev(eps(u)))*sin(2*t)*eta" if rates else "norm(dev(eps(u)))*eta",
                lambda q: norm(q.e - q.tr[:, None, None] / self.dim * numpy.eye(self.dim)) * (numpy.sin(2 * q.t) if rates else 1), "eta")
        warm = self.heat
        add(force, -stiff * r.uniform(1, 10), "norm(eps(u))^2*(eps(u) : eps(v))", lambda q: ((q.e**2).reshape(len(q.e), -1).sum(1))[:, None, None] * q.e, "eps v")
        add(force, stiff * c(0.05, 0.2), "theta*(eps(u) : eps(v))", lambda q: q.th[:, None, None] * q.e, "eps v", needs=warm)
        add(force, stiff * c(0.01, 0.05), "theta^2*div(v)", lambda q: q.th[:, None, None] ** 2 * numpy.eye(self.dim), "eps v", needs=warm)
        add(force, stiff / s * c(0.01, 0.05), f"norm({g})*v.{i}", lambda q: numpy.sqrt((q.gt**2).sum(1))[:, None] * numpy.eye(self.dim)[a], "v",
            needs=warm and self.steps > 1)
        add(force, -stiff * r.uniform(0.05, 0.3), "norm(eps(u'))*(eps(u') : eps(v))", lambda q: norm(q.ed)[:, None, None] * q.ed, "eps v", needs=rates)
        add(force, stiff / s * c(0.05, 0.3) / s, f"div(u)*u.{i}*v.{j}*1", lambda q: (q.tr * q.u[:, a])[:, None] * numpy.eye(self.dim)[b], "v")
        add(force, stiff * c(0.05, 0.3), "norm(eps(u))*v.nu", lambda q: norm(q.e)[:, None] * q.nu, "v", part="skin")
        add(force, stiff * c(0.05, 0.3), "d*norm(eps(u))*(eps(u) : eps(v))", lambda q: (q.d * norm(q.e))[:, None, None] * q.e, "eps v", needs=self.state)
        self.loads = r.sample(force, r.randint(1, 2)) + (r.sample(heat, r.randint(1, 3)) if warm else [])

    def script(self):
        up = AXES[: self.dim]
        time = self.kind != "static"
        lines = ['mesh body = gmsh("body.msh")', "part hold = body.hold", "part skin = body.skin"]
        lines += [f"tensor {n} = isotropic(lambda = {v[0]!r}, mu = {v[1]!r})" for n, v in (("A", self.viscosity), ("B", self.elasticity))
                  if self.dim > 1 and (time or n == "B")]
        if self.state:
            lines.append("state d on body with rate norm(eps(u)) - 0.5*d from d = 0.1")
        lines.append("space V = vector P1 on body, zero on hold")
        if self.heat:
            lines.append("space W = scalar P1 on body, zero on hold")
        span = ""
        if time:
            span = f" for t in [0, 1] by {self.steps} steps from u = [{', '.join(['0'] * self.dim)}]" + (f", u' = {self.velocity()}" if self.moves else ", theta = 0")
        lines.append(f"find u in V{', theta in W' if self.heat else ''}{span}" + (f"\n  using scheme = {self.kind}" if time else ""))
        lines.append(f"such that for all v in V{', eta in W' if self.heat else ''}")
        modulus = lambda v: repr(v[0] + 2 * v[1])
        bar = self.dim == 1
        left = [f"integral(body, {modulus(self.elasticity) + '*eps(u).xx*eps(v).xx' if bar else 'B : eps(u) : eps(v)'})"]
        if time:
            left.append(f"integral(body, {modulus(self.viscosity) + chr(42) + 'eps(u' + chr(39) + ').xx*eps(v).xx' if bar else 'A : eps(u' + chr(39) + ') : eps(v)'})")
        if self.moves:
            left.append(f"integral(body, {self.density()!r}*dot(u'', v))")
        if self.coupling:
            left.append(f"integral(body, -({self.coupling!r})*theta*div(v))")
        if self.heat:
            left.append(f"integral(body, {self.size**2!r}*dot(grad(theta), grad(eta)))")
            if time:
                left.append("integral(body, theta'*eta)")
        right = [f"integral(body, {'t*' if time else ''}dot([{', '.join(repr(float(f)) for f in self.force)}], v))"]
        if self.heat:
            right.append("integral(body, 0.5*eta)")
        for part, text, _, _ in self.loads:
            if bar:
                text = text.replace("(A : eps(u') : eps(u'))", f"({modulus(self.viscosity)}*eps(u').xx^2)")
            right.append(f"integral({part}, {text})")
        lines += ["    " + "\n  + ".join(left) + "\n  = " + "\n  + ".join(right)]
        probes = []
        for k, n in enumerate(self.seen()):
            at = "[" + ", ".join(repr(float(v)) for v in self.x[n]) + "]"
            probes += [f"u{k}{i} = u.{i} at {at}" for i in up] + ([f"th{k} = theta at {at}"] if self.heat else [])
        return "\n".join([*lines, "report\n  table " + ", ".join(probes)]) + "\n"

    def velocity(self):
        distance = " + ".join(f"({float(n)!r})*{axis}" for n, axis in zip(self.across, AXES))
        return f"[{', '.join(f'({float(s)!r})*({distance})' for s in self.swing)}]"

    def density(self):
        return self.stiff / self.size**2 * 0.3

    def seen(self):
        """Nodes whose values are reported."""
        return sorted(self.on_skin)[:3] + [n for n in range(len(self.x)) if n not in self.held and n not in self.on_skin][:3]

    # Our own solution.

    def forces(self, u, v, th, states, t, loads_only=False):
        """Loads minus the stresses of forms, as nodal forces on u and theta."""
        out_u, out_th = numpy.zeros_like(u), numpy.zeros_like(th)
        for name, at in (("body", self.body), ("skin", self.skin)):
            q = Fields(self, at, u, v, th, states if name == "body" else None, t)
            terms = [(value(q), test) for part, _, value, test in self.loads if part == name]
            if name == "body":
                ramp = 1.0 if self.kind == "static" else t
                terms.append((numpy.broadcast_to(ramp * self.force, q.u.shape), "v"))
                if self.heat:
                    terms.append((numpy.full(len(q.th), 0.5), "eta"))
                if not loads_only:
                    terms.append((-q.sigma, "eps v"))
                    if self.heat:
                        terms.append((-q.gt, "grad eta"))
            for value, test in terms:
                w = at.weights
                if test == "eta":
                    numpy.add.at(out_th, at.nodes, (w * value)[:, None] * at.shapes)
                elif test == "grad eta":
                    numpy.add.at(out_th, at.nodes, self.size * numpy.einsum("p,pa,pna->pn", w, value, at.slopes))
                elif test == "v":
                    numpy.add.at(out_u, at.nodes, numpy.einsum("p,pi,pn->pni", w, value, at.shapes))
                else:
                    numpy.add.at(out_u, at.nodes, numpy.einsum("p,pij,pnj->pni", w, value, at.slopes))
        return out_u, out_th

    def mass(self, w):
        """Of a field with values at nodes."""
        at = self.body
        out = numpy.zeros_like(w)
        value = numpy.einsum("pn,pn...->p...", at.shapes, w[at.nodes])
        numpy.add.at(out, at.nodes, numpy.einsum("p,pn,p...->pn...", at.weights, at.shapes, value))
        return out

    def solve(self):
        """Values at the nodes that are seen, step by step."""
        n, k = len(self.x), 1.0 / self.steps
        u = numpy.zeros((n, self.dim))
        v = (self.x @ self.across)[:, None] * self.swing if self.moves else u.copy()
        v[list(self.held)] = 0.0
        acc, th, rows = u.copy(), numpy.zeros(n), []
        states = numpy.full(len(self.body.weights), 0.1)
        last = [1.0, 1.0]
        sizes = numpy.concatenate([numpy.full(u.size, 1e-2 * self.size), numpy.full(n, 0.1)])
        free_u = [i for i in range(n) if i not in self.held]
        free = [i * self.dim + a for i in free_u for a in range(self.dim)] + ([u.size + i for i in free_u] if self.heat else [])
        if self.kind == "newmark":
            f = self.forces(u, v, th, states, 0.0)[0].ravel()
            own = [i for i in free if i < u.size]
            m = numpy.array([self.mass(e.reshape(u.shape)).ravel()[own] for e in numpy.eye(u.size)[own]]).T * self.density()
            acc = numpy.zeros(u.size)
            acc[own] = numpy.linalg.solve(m, f[own])
            acc = acc.reshape(u.shape)
        rate = v  # that midpoint's loads have read
        for step in range(1, self.steps + 1):
            t = step * k

            def residual(y):
                new_u, new_th = y[: u.size].reshape(u.shape), y[u.size:]
                if self.kind == "static":
                    f = self.forces(new_u, 0 * new_u, new_th, states, 1.0)
                    return numpy.concatenate([f[0].ravel(), f[1]])
                if self.kind == "backward_euler":
                    new_v = (new_u - u) / k
                elif self.kind == "newmark":
                    new_a = 4 * (new_u - u - k * v) / k**2 - acc
                    new_v = v + 0.5 * k * (acc + new_a)
                else:
                    new_v = (new_u - u) / k
                new_d = states
                if self.state:
                    grown = norm(Fields(self, self.body, new_u, new_v, new_th, None, t).e)
                    if self.kind == "backward_euler" or step == 1:
                        new_d = (states + k * grown) / (1 + 0.5 * k)
                    else:  # BDF2
                        new_d = ((4 * states - self.state_before) / 3 + 2 * k / 3 * grown) / (1 + k / 3)
                residual.state = new_d
                if self.kind == "midpoint":
                    stress = self.forces(0.5 * (u + new_u), new_v, th, states, 0.0)[0] - self.forces(0.5 * (u + new_u), new_v, th, states, 0.0, True)[0]
                    loads = 0.5 * (self.forces(new_u, new_v, th, new_d, t, True)[0] + self.forces(u, rate, th, states, t - k, True)[0])
                    end = 2 * new_v - v
                    return numpy.concatenate([(stress + loads - self.density() * self.mass((end - v) / k)).ravel(), 0 * new_th])
                f = self.forces(new_u, new_v, new_th, new_d, t)
                if self.kind == "newmark":
                    return numpy.concatenate([(f[0] - self.density() * self.mass(new_a)).ravel(), 0 * new_th])
                return numpy.concatenate([f[0].ravel(), f[1] - self.mass((new_th - th) / k)])

            # A point where nothing has moved is a kink of norms: begin beside it.
            y = numpy.concatenate([u.ravel(), th]).astype(float)
            start = numpy.random.default_rng(step).normal(size=len(free)) * sizes[free]
            y[free] += 1e-2 * start
            scale = None
            for _ in range(60):
                f = residual(y)[free]
                jacobian = numpy.empty((len(free), len(free)))
                for column, i in enumerate(free):
                    moved = y.astype(complex)
                    moved[i] += 1e-40j * sizes[i]
                    jacobian[:, column] = residual(moved)[free].imag / 1e-40
                change = -numpy.linalg.solve(jacobian, f)
                part = 1.0
                while part > 1e-3:
                    there = y.copy()
                    there[free] += part * change * sizes[free]
                    g = residual(there)[free]
                    if numpy.linalg.norm(numpy.linalg.solve(jacobian, g)) < (1 - 0.1 * part) * numpy.linalg.norm(change):
                        break
                    part /= 2
                y[free] += part * change * sizes[free]
                scale = numpy.abs(y[free] / sizes[free]).max()
                if numpy.abs(change).max() <= 1e-12 * scale:
                    break
            else:
                return None
            residual(y)
            new_u = y[: u.size].reshape(u.shape)
            if self.kind == "newmark":
                new_a = 4 * (new_u - u - k * v) / k**2 - acc
                v, acc = v + 0.5 * k * (acc + new_a), new_a
            elif self.kind == "midpoint":
                rate = (new_u - u) / k
                v = 2 * rate - v
            if self.state:
                self.state_before, states = states, residual.state.real
            u, th = new_u, y[u.size:]
            rows.append([value for node in self.seen() for value in [*u[node], *([th[node]] if self.heat else [])]])
        return numpy.array(rows)


def judge(program, folder, seed):
    scene = Scene(seed)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.hvi").write_text(scene.script())
    (folder / "body.msh").write_text(msh(scene.x, scene.cells, {"hold": scene.held, "skin": scene.on_skin}))
    options = ["--solver", "iterative"] if seed % 5 == 0 else []
    done = subprocess.run([program, "run", "scene.hvi", "--no-files", "--quiet", "--json", "scene.json", *options], cwd=folder, capture_output=True,
                          text=True, timeout=300)
    if done.returncode != 0:
        return f"exit code {done.returncode}: {done.stderr.splitlines()[0]}"
    found = json.loads((folder / "scene.json").read_text())
    if not found["certificate"]["certified"]:
        return "not certified"
    own = scene.solve()
    if own is None:
        return "our own Newton's method found nothing"
    columns = [name for name in found["table"] if name != "t" and name != "event"]
    values = numpy.array([found["table"][name][-scene.steps:] for name in columns], float).T
    worst = 0.0
    for kind in ("u", "th"):
        own_kind = [i for i, name in enumerate(columns) if name.startswith(kind)]
        if own_kind:
            size = numpy.abs(own[:, own_kind]).max()
            worst = max(worst, numpy.abs(values[:, own_kind] - own[:, own_kind]).max() / size)
    return None if worst <= AGREE else f"{scene.dim}D, {scene.kind}: apart by {worst:.1e}: {[text for _, text, _, _ in scene.loads]}"


if __name__ == "__main__":
    seeded(judge, scenes=40)
