#!/usr/bin/env python3
"""Random scenes with Coulomb's friction, in 2D and 3D, judged by an assembly of our own.

    coulomb.py HVI_RUN [--scenes N] [--seed S] [--turned SHARE] [--only N,N,..] [--keep DIR] [--rates]

A body of P1 triangles or tetrahedra, its nodes shaken, most of them turned by a random angle, is held on one side, loaded at random and
meets rigid or compliant ground with a friction coefficient up to 4, constant or weakening with slip, at the points of each rule; Poisson's
ratio goes up to .45, some bodies are viscous, some remember. The script's mesh is written by this program, and every node's displacement is
printed.

Wrong: a certified answer that breaks one of the laws. Stiffness, loads and the weights of memories are computed here; what is left of the
equations must vanish off the ground, and there be the forces of multipliers that the laws allow at these displacements: none at a gap, a push
in contact, friction inside the cone where a point rests and on its rim against the slip where not. These multipliers are a convex cone of
each point (or, with compliant ground, a ball), and they are searched by projections. Nothing else of the program is believed.

Displacements are known up to a part of the largest one, and of what the loads of the step make of the body alone: where all points stick and
no other node is free, all of them are rounding.

Refused: no certified answer. Every scene has at least one solution: for given bounds g the discrete problem has one solution c(g), its size
does not depend on g because friction and contact at zero gap do no positive work, so g -> mu |xi_n(c(g))| maps a ball into itself
and has a fixed point (Brouwer); the earlier steps only add to the load of this one. Not one scene in 2D may be refused, and less than one in
200 in 3D.

With --rates friction acts on u'. Then a point that slipped may be held where it is and pressed on by it, so that for a large mu a step need
not have a solution; no certified answer may be wrong, and at most RATES_REFUSED are refused.
"""
import argparse, json, math, os, subprocess, sys, tempfile
import numpy as np
from solids import facet_rule

BOUND_3D = 0.005
RATES_REFUSED = 0.02
TOLERANCE = 1e-7  # of the largest force and of the largest displacement: thousand times what is certified
ALONE = 1e-9  # of what the loads make of the body without ground: ten times what is certified


def rotation(dim, rng):
    if dim == 2:
        a = rng.uniform(0, 2 * math.pi)
        return np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def simplices(dim, cells, rng):
    """Cells of a grid cut into simplices; in 2D each along a random diagonal, in 3D all along one (Kuhn)."""
    shape = [c + 1 for c in cells]
    number = np.arange(np.prod(shape)).reshape(shape)
    out = []
    for cell in np.ndindex(*cells):
        at = lambda *d: number[tuple(np.add(cell, d))]
        if dim == 2:
            a, b, c, d = at(0, 0), at(1, 0), at(1, 1), at(0, 1)
            out += [(a, b, c), (a, c, d)] if rng.random() < .5 else [(a, b, d), (b, c, d)]
            continue
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            d, corners = [0, 0, 0], [at(0, 0, 0)]
            for axis in order:
                d[axis] = 1
                corners.append(at(*d))
            out.append(tuple(corners))
    return number, np.array(out)


def facets_in(cells, inside):
    """Facets with all corners inside a set of nodes that belong to one simplex only."""
    seen = {}
    for k, simplex in enumerate(cells):
        for leave in range(len(simplex)):
            facet = tuple(sorted(np.delete(simplex, leave)))
            if all(inside[v] for v in facet):
                seen.setdefault(facet, []).append(k)
    return [f for f, owners in seen.items() if len(owners) == 1]


class Scene:
    def __init__(self, rng, dim, turned, rates):
        self.dim, self.rates = dim, rates
        if dim == 2:
            self.cells = [int(rng.integers(2, 9)), int(rng.integers(2, 6))]
            self.size = np.array([rng.uniform(.5, 4), rng.uniform(.5, 3)])
        else:
            self.cells = [int(rng.integers(1, 4)), int(rng.integers(1, 4)), int(rng.integers(1, 4))]
            self.size = np.array([rng.uniform(.5, 3), rng.uniform(.5, 3), rng.uniform(.5, 2)])
        number, self.simplices = simplices(dim, self.cells, rng)
        up = dim - 1
        grid = np.stack(np.meshgrid(*[np.linspace(0, 1, c + 1) for c in self.cells], indexing='ij'), -1)
        self.x = grid.reshape(-1, dim)
        shake = rng.uniform(-1, 1, self.x.shape) * .2 / np.array(self.cells)
        edge = (self.x == 0) | (self.x == 1)
        self.x = np.where(edge, self.x, self.x + shake)
        on_ground, on_roof = self.x[:, up] == 0, self.x[:, up] == 1
        side = self.x[:, 0] == 1
        self.x = self.x * self.size
        self.turn = rotation(dim, rng) if rng.random() < turned else np.eye(dim)
        self.held_side = rng.random() < .2  # the left side in place of the roof
        held = self.x[:, 0] == 0 if self.held_side else on_roof
        self.ground = facets_in(self.simplices, on_ground)
        self.roof = facets_in(self.simplices, held)
        self.flank = facets_in(self.simplices, side)
        self.held = held
        if self.held_side:  # their contact would be held, too
            self.ground = [f for f in self.ground if not any(held[v] for v in f)]
            if not self.ground:
                self.held_side, self.held = False, on_roof
                self.ground, self.roof = facets_in(self.simplices, on_ground), facets_in(self.simplices, on_roof)
        self.points = self.x @ self.turn.T
        self.normal = self.turn @ -np.eye(dim)[up]
        self.young = 10 ** rng.uniform(0, 3)
        self.nu = rng.uniform(0, .45)
        self.mu = rng.uniform(.1, 1.2) if rng.random() < .5 else rng.uniform(1, 4)
        scale = 10 ** rng.uniform(-2, 1)
        direction = rng.uniform(-1, 1, dim)
        direction[up] = -rng.uniform(0, 1.5)
        self.body = self.turn @ direction * scale * 10
        self.traction = self.turn @ rng.uniform(-1, 1, dim) * scale * 15
        self.stiffness = None if rng.random() < .75 else self.young * 10 ** rng.uniform(0, 2)
        self.weakens = None if rng.random() < .8 else 10 ** rng.uniform(0, 3)
        self.rule = 'midpoint' if dim == 2 and rng.random() < .2 else 'nodal'
        self.steps = int(rng.integers(1, 4))
        if rng.random() < .3:
            self.rule = ('midpoint', 'gauss')[rng.integers(2)]
        self.viscosity = None if rng.random() < .8 else 10 ** rng.uniform(-2, .5)  # A = viscosity B
        self.memory = None if rng.random() < .8 else (rng.uniform(-.5, 1), 10 ** rng.uniform(-1.5, 1))  # a exp(-lag/tau)/tau

    def told(self):
        what = {'viscous': self.viscosity, 'memory': self.memory, 'compliant': self.stiffness, 'weakens': self.weakens,
                'turned': not np.array_equal(self.turn, np.eye(self.dim))}
        return f', {self.rule}' + ''.join(f', {name}' for name, there in what.items() if there)

    def coefficient(self, slip):
        return self.mu if self.weakens is None else self.mu * (.5 + .5 * np.exp(-self.weakens * slip))

    def write(self, folder):
        names = {'roof': self.roof, 'flank': self.flank, 'ground': self.ground}
        kind = {2: 1, 3: 2}[self.dim]
        with open(os.path.join(folder, 'body.msh'), 'w') as f:
            f.write('$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n')
            for i, name in enumerate(names):
                f.write(f'{self.dim - 1} {i + 1} "{name}"\n')
            f.write(f'{self.dim} 4 "body"\n$EndPhysicalNames\n$Nodes\n{len(self.points)}\n')
            for i, p in enumerate(self.points):
                f.write(f'{i + 1} ' + ' '.join(repr(float(v)) for v in list(p) + [0.0] * (3 - self.dim)) + '\n')
            lines = [f'{kind} 2 {i + 1} {i + 1} ' + ' '.join(str(v + 1) for v in facet)
                     for i, name in enumerate(names) for facet in names[name]]
            lines += [f'{kind * 2} 2 4 4 ' + ' '.join(str(v + 1) for v in s) for s in self.simplices]
            f.write(f'$EndNodes\n$Elements\n{len(lines)}\n')
            f.write(''.join(f'{i + 1} {line}\n' for i, line in enumerate(lines)) + '$EndElements\n')
        vector = lambda v: '[' + ', '.join(f't*({float(c)!r})' for c in v) + ']'
        columns = [f'u{i}{"xyz"[k]} = u.{"xyz"[k]} at [{", ".join(repr(float(v)) for v in p)}]'
                   for i, p in enumerate(self.points) for k in range(self.dim)]
        layer = ('| r <= 0 -> 0 | otherwise -> 1e300' if self.stiffness is None
                 else f'| r <= 0 -> 0 | otherwise -> {self.stiffness!r}*r')
        grip = (f'grip(xi) = {self.mu!r}*abs(layer.xi)*norm(xi)' if self.weakens is None else
                f'grip(xi) with slope {self.mu!r}*abs(layer.xi)*(0.5 + 0.5*exp(-{self.weakens!r}*norm(xi)))')
        extra = declared = ''
        if self.viscosity:
            extra += f" + integral(body, {self.viscosity!r} * (B : eps(u')) : eps(v))\n"
        if self.memory:
            a, tau = self.memory
            declared = f'kernel q(lag) = {a / tau!r}*exp(-lag/{tau!r})*B\n'
            extra += ' + integral(body, history(q, eps(u)) : eps(v))\n'
        start = ' from u = 0' if extra or self.rates else ''
        script = f'''mesh body = gmsh("body.msh")
part roof = body.group("roof")
part flank = body.group("flank")
part ground = body.group("ground")
tensor B = isotropic(young = {self.young!r}, poisson = {self.nu!r})
{declared}superpotential layer(r) with slope {layer}
superpotential {grip}
space V = vector P1 on body, zero on roof
find u in V for t in [0,1] by {self.steps} steps{start} such that for all v in V
   integral(body, B : eps(u) : eps(v))
{extra} + integral(ground, layer^0(u.nu; v.nu) + grip^0(u{"'" if self.rates else ''}.tau; v.tau), rule = {self.rule})
 >= integral(body, dot({vector(self.body)}, v)) + integral(flank, dot({vector(self.traction)}, v))
report
  table {", ".join(columns)}
'''
        with open(os.path.join(folder, 'scene.hvi'), 'w') as f:
            f.write(script)

    # ---- an assembly that shares nothing with the program's

    def volume_and_gradients(self, simplex):
        p = self.points[list(simplex)]
        edges = (p[1:] - p[0]).T
        inner = np.linalg.inv(edges)
        gradients = np.vstack([-inner.sum(0), inner])
        return abs(np.linalg.det(edges)) / math.factorial(self.dim), gradients

    def system(self):
        d, n = self.dim, len(self.points)
        lam = self.young * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))
        mu = self.young / (2 * (1 + self.nu))
        k, f = np.zeros((n * d, n * d)), np.zeros(n * d)
        for simplex in self.simplices:
            volume, g = self.volume_and_gradients(simplex)
            for a, i in enumerate(simplex):
                f[i * d:i * d + d] += volume / (d + 1) * self.body
                for b, j in enumerate(simplex):
                    k[i * d:i * d + d, j * d:j * d + d] += volume * (
                        lam * np.outer(g[a], g[b]) + mu * np.outer(g[b], g[a]) + mu * (g[a] @ g[b]) * np.eye(d))
        for facet in self.flank:
            for v in facet:
                f[v * d:v * d + d] += self.area(facet) / d * self.traction
        return k, f

    def area(self, facet):
        p = self.points[list(facet)]
        return np.linalg.norm(p[1] - p[0]) if self.dim == 2 else .5 * np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0]))

    def contact_points(self):
        """Rows of weights by nodes: displacement of a point = row @ u; and the weight of each point."""
        n = len(self.points)
        rows, weights = [], []
        for facet in self.ground:
            for where, share in facet_rule(self.dim, 1, self.rule):
                row = np.zeros(n)
                row[list(facet)] = where
                rows.append(row), weights.append(share * self.area(facet))
        rows, weights = np.array(rows), np.array(weights)
        if self.rule == 'nodal':  # one point for each node
            rows, which = np.unique(rows, axis=0, return_inverse=True)
            weights = np.bincount(which.ravel(), weights)
        return rows, weights

    def on_bases(self, states, times):
        """What acts on the stiffness in the last of the steps: u, its rate and its memory."""
        u, t = states[-1].copy(), times[-1]
        if self.viscosity:
            u += self.viscosity * (states[-1] - states[-2]) / (times[-1] - times[-2])
        if self.memory:
            a, tau = self.memory  # int q over a step, exactly
            for state, start, end in zip(states[1:], times, times[1:]):
                u += a * (math.exp(-(t - end) / tau) - math.exp(-(t - start) / tau)) * state
        return u

    def prepare(self):
        """What all steps share."""
        self.k, self.f = self.system()
        free = np.repeat(~self.held, self.dim)
        alone = np.zeros(len(self.f))
        alone[free] = np.linalg.solve(self.k[np.ix_(free, free)], self.f[free])
        self.alone = np.abs(alone).max()

    def mistakes(self, states, times):
        """What the laws and equilibrium say against the last of the states (nodes by components)."""
        u, t = states[-1], times[-1]
        acting = self.on_bases(states, times)
        forces = (t * self.f - self.k @ acting.ravel()).reshape(u.shape)[~self.held]
        rows, weights = self.contact_points()
        z = rows @ u
        opening = z @ self.normal
        length = times[-1] - times[-2] if self.rates else 1.0
        moved = rows @ (u - states[-2]) / length if self.rates else z
        slip = moved - np.outer(moved @ self.normal, self.normal)
        size = np.linalg.norm(slip, axis=1)
        sum_of_sizes = (np.abs(self.k) @ np.abs(acting.ravel()) + t * np.abs(self.f)).max()
        force_eps, length_eps = TOLERANCE * sum_of_sizes, TOLERANCE * np.abs(u).max() + ALONE * t * self.alone
        if self.stiffness is None and opening.max() > length_eps:
            return [f'penetration: {opening.max():.2e} > {length_eps:.1e}']
        push = np.zeros(len(z))
        if self.stiffness is not None:
            push = self.stiffness * np.maximum(opening, 0)
            force_eps += self.stiffness * length_eps * weights.max() * (1 + self.mu)
        laws = Laws(self, opening, slip, size, push, length_eps, length_eps / length)
        reach = (rows.T * weights)[~self.held]
        left = unbalanced(reach, forces, laws, force_eps)
        return [f'no multipliers on the laws: {left:.2e} > {force_eps:.1e}'] if left > force_eps else []


class Laws:
    """The multipliers that the laws allow at given displacements, and the nearest of them."""

    def __init__(self, scene, opening, slip, size, push, length_eps, slip_eps):
        self.normal, self.rigid, self.push = scene.normal, scene.stiffness is None, push
        self.gap = opening < -length_eps
        self.rests = size <= 10 * slip_eps
        self.e = slip / np.maximum(size, 1e-300)[:, None]
        self.mu = np.where(self.rests, scene.mu, scene.coefficient(size))
        # A slip is known up to rounding: so are its direction, and the bound that weakens with it.
        self.turn = np.where(self.rests, 0, slip_eps / np.maximum(size, 1e-300))
        self.turn += scene.coefficient(np.maximum(size - slip_eps, 0)) / self.mu - 1

    def nearest(self, xi):
        """Each row of xi (pressure and drag together) on the law of its point."""
        p = xi @ self.normal
        drag = xi - np.outer(p, self.normal)
        length = np.linalg.norm(drag, axis=1)
        if self.rigid:
            p_rest = np.where(length <= self.mu * p, p, np.maximum(0, (p + self.mu * length) / (1 + self.mu ** 2)))
            p_slip = np.maximum(0, (p + self.mu * (drag * self.e).sum(1)) / (1 + self.mu ** 2))
            p = np.where(self.gap, 0, np.where(self.rests, p_rest, p_slip))
        else:
            p = self.push
        bound = self.mu * p
        inside = drag * np.minimum(1, bound / np.maximum(length, 1e-300))[:, None]
        return np.outer(p, self.normal) + np.where(self.rests[:, None], inside, self.e * bound[:, None])

    def slack(self, xi):
        """Forces that rounding of the slip may hide."""
        return np.linalg.norm(xi - np.outer(xi @ self.normal, self.normal), axis=1) * self.turn


def unbalanced(reach, forces, laws, enough):
    """The least max |forces - reach xi| that a search over xi on the laws finds.

    With P the nearest multipliers on the laws, xi = P(reach^T y) of least size solves the equations where
    y minimises the convex phi(y) = v . P(v) - |P(v)|^2 / 2 - forces . y, v = reach^T y: Newton's method with
    a line search. Without such xi, or with one on the rim only, y grows and what is left falls to its least.
    """
    ratio = np.sqrt((reach ** 2).sum(0))[:, None]  # xi = eta / ratio: rows of one point keep their directions
    scaled, size = reach / ratio.T, np.abs(forces).max() or 1.0
    dim = forces.shape[1]
    on_laws = lambda v: laws.nearest(size * v / ratio) * ratio / size
    target = forces / size

    def at(y):
        v = scaled.T @ y
        eta = on_laws(v)
        return v, eta, (v * eta).sum() - .5 * (eta ** 2).sum() - (target * y).sum()

    y, best = np.zeros_like(forces), math.inf
    for _ in range(2000):  # where only multipliers on the rim do, y grows without end
        v, eta, value = at(y)
        xi = size * eta / ratio
        gap = target - scaled @ eta
        left = size * np.abs(gap) - np.abs(reach) @ laws.slack(xi)[:, None]
        best = min(best, left.max())
        if best <= enough:
            break
        step = 1e-9 * max(np.abs(v).max(), 1e-3)
        slopes = np.stack([(on_laws(v + step * np.eye(dim)[k]) - eta) / step for k in range(dim)], -1)
        matrix = np.einsum('ip,pab,jp->iajb', scaled, slopes, scaled).reshape(y.size, y.size)
        matrix += max(1e-3 * np.linalg.norm(gap), 1e-12) * np.eye(y.size)
        move = np.linalg.solve(matrix, gap.ravel()).reshape(y.shape)
        length, fall = 1.0, (gap * move).sum()
        rounding = 1e-14 * (np.abs(v * eta).sum() + np.abs(target * y).sum())
        while length > 1e-10 and not at(y + length * move)[2] <= value - 1e-4 * length * fall + rounding:
            length /= 2
        y = y + length * move
    return best


def judge(program, seed, index, turned, keep, rates):
    rng = np.random.default_rng([seed, index])
    scene = Scene(rng, 3 if index % 3 == 2 else 2, turned, rates)
    with tempfile.TemporaryDirectory() as folder:
        folder = os.path.join(keep, str(index)) if keep else folder
        os.makedirs(folder, exist_ok=True)
        scene.write(folder)
        try:
            run = subprocess.run([program, 'run', 'scene.hvi', '--no-files', '--threads', '1', '--json', 'out.json'], cwd=folder,
                                 capture_output=True, text=True, timeout=60)
        except subprocess.TimeoutExpired:
            return scene, 'refused', 'no answer within a minute'
        if run.returncode == 3:
            return scene, 'refused', run.stderr.split('\n')[0]
        if run.returncode != 0:
            return scene, 'wrong', f'exit {run.returncode}: ' + run.stderr.split('\n')[0]
        result = json.load(open(os.path.join(folder, 'out.json')))
    table = result['table']
    scene.prepare()
    states = [np.array([[table[f'u{i}{"xyz"[k]}'][n] for k in range(scene.dim)] for i in range(len(scene.points))])
              for n in range(len(table['t']))]
    states, times = [np.zeros_like(states[0])] + states, [0.0] + table['t']
    for n in range(1, len(states)):
        if found := scene.mistakes(states[:n + 1], times[:n + 1]):
            return scene, 'wrong', f't = {times[n]}: ' + '; '.join(found)
    return scene, 'certified', ''


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument('program')
    arguments.add_argument('--scenes', type=int, default=300)
    arguments.add_argument('--seed', type=int, default=17)
    arguments.add_argument('--turned', type=float, default=.7, help='share of the scenes')
    arguments.add_argument('--keep', help='folder for the scenes')
    arguments.add_argument('--only', type=lambda s: [int(n) for n in s.split(',')], help='scenes by their numbers')
    arguments.add_argument('--rates', action='store_true', help='friction on the rate')
    a = arguments.parse_args()
    program = os.path.abspath(a.program)
    count = {'certified': 0, 'wrong': 0, 'refused': 0}
    refused = {2: 0, 3: 0}
    asked = a.only or range(a.scenes)
    spatial = 0
    for i in asked:
        scene, verdict, why = judge(program, a.seed, i, a.turned, a.keep, a.rates)
        count[verdict] += 1
        spatial += scene.dim == 3
        if verdict == 'refused':
            refused[scene.dim] += 1
        if verdict != 'certified':
            print(f'scene {i} ({scene.dim}D, mu {scene.mu:.2f}, nu {scene.nu:.2f}{scene.told()}): {verdict}: {why}')
    print(f'family coulomb: scenes {len(asked)}, certified {count["certified"]}, wrong {count["wrong"]}, refused {count["refused"]}')
    if a.rates:
        sys.exit(count['wrong'] > 0 or count['refused'] > RATES_REFUSED * len(asked))
    sys.exit(count['wrong'] > 0 or refused[2] > 0 or refused[3] > BOUND_3D * spatial)


main()
