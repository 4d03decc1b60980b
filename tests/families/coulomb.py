#!/usr/bin/env python3
"""Random scenes with Coulomb's friction, in 2D and 3D, judged by an assembly of our own.

    coulomb.py HVI_RUN [--scenes N] [--seed S] [--turned SHARE] [--keep DIR]

A body of P1 triangles or tetrahedra, its nodes shaken, most of them turned by a random angle, is held on one side, loaded at random and
meets rigid or compliant ground with a friction coefficient up to 4, constant or weakening with slip; Poisson's ratio goes up to
.45. The script's mesh is written by this program, and every node's displacement is printed.

Wrong: a certified answer that breaks one of the laws. Stiffness and loads are assembled here; the forces K u - f that are left at the ground
are the multipliers times the weights of the points, and they must vanish elsewhere, push, stay inside the cone, and fill it against the slip
where there is one. Nothing else of the program is believed.

Refused: no certified answer. Every scene has at least one solution: for given bounds g the discrete problem has one solution c(g), its size
does not depend on g because friction and contact at zero gap do no positive work, so g -> mu |xi_n(c(g))| maps a ball into itself
and has a fixed point (Brouwer). Not one scene in 2D may be refused, and less than one in 200 in 3D.
"""
import argparse, json, math, os, subprocess, sys, tempfile
import numpy as np

BOUND_3D = 0.005
TOLERANCE = 1e-7  # of the largest force and of the largest displacement: thousand times what is certified


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
    def __init__(self, rng, dim, turned):
        self.dim = dim
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
        self.midpoint = dim == 2 and rng.random() < .2
        self.steps = int(rng.integers(1, 4))

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
        rule = ', rule = midpoint' if self.midpoint else ', rule = nodal'
        script = f'''mesh body = gmsh("body.msh")
part roof = body.group("roof")
part flank = body.group("flank")
part ground = body.group("ground")
tensor B = isotropic(young = {self.young!r}, poisson = {self.nu!r})
superpotential layer(r) with slope {layer}
superpotential {grip}
space V = vector P1 on body, zero on roof
find u in V for t in [0,1] by {self.steps} steps such that for all v in V
   integral(body, B : eps(u) : eps(v))
 + integral(ground, layer^0(u.nu; v.nu) + grip^0(u.tau; v.tau){rule})
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
        """Rows of weights by nodes: argument of a point = row @ u; and the weight of each point."""
        n = len(self.points)
        if self.midpoint:
            rows, weights = np.zeros((len(self.ground), n)), np.array([self.area(f) for f in self.ground])
            for i, facet in enumerate(self.ground):
                rows[i, list(facet)] = 1 / len(facet)
            return rows, weights
        weight = np.zeros(n)
        for facet in self.ground:
            weight[list(facet)] += self.area(facet) / len(facet)
        nodes = np.flatnonzero(weight)
        return np.eye(n)[nodes], weight[nodes]

    def mistakes(self, u, t):
        """What the laws and equilibrium say against the displacements u (nodes by components)."""
        k, f = self.system()
        forces = t * f - k @ u.ravel()  # of the ground's multipliers, G^T W xi
        forces = forces.reshape(u.shape)
        rows, weights = self.contact_points()
        xi = np.linalg.lstsq(rows.T * weights, forces * ~self.held[:, None], rcond=None)[0]
        left = (forces - (rows.T * weights) @ xi)[~self.held]
        z = rows @ u
        pressure, opening = xi @ self.normal, z @ self.normal
        drag, slip = xi - np.outer(pressure, self.normal), z - np.outer(opening, self.normal)
        force = max(np.abs(k * u.ravel()).sum(1).max() / weights.min(), np.abs(xi).max())
        length = np.abs(u).max()
        force_eps, length_eps = TOLERANCE * force, TOLERANCE * length
        out = []
        def no_more(what, value, eps):
            if np.size(value) and not np.max(value) <= eps:
                out.append(f'{what}: {np.max(value):.2e} > {eps:.1e}')
        no_more('equilibrium', np.abs(left), force_eps * weights.min())
        if self.stiffness is None:
            no_more('penetration', opening, length_eps)
            no_more('pulls', -pressure, force_eps)
            no_more('pressure at a gap', np.abs(pressure[opening < -length_eps]), force_eps)
        else:
            no_more('compliance', np.abs(pressure - self.stiffness * np.maximum(opening, 0)),
                    force_eps + self.stiffness * length_eps)
        size = np.linalg.norm(slip, axis=1)
        bound = self.coefficient(size) * np.abs(pressure)
        eps = force_eps * (1 + self.mu)
        no_more('outside the cone', np.linalg.norm(drag, axis=1) - bound, eps)
        moving = size > length_eps * 10
        if moving.any():
            e = slip[moving] / size[moving][:, None]
            slack = eps + bound[moving] * length_eps / size[moving]
            no_more('slips below the bound', np.linalg.norm(drag[moving] - bound[moving][:, None] * e, axis=1) - slack, 0.0)
        return out


def judge(program, seed, index, turned, keep):
    rng = np.random.default_rng([seed, index])
    scene = Scene(rng, 3 if index % 3 == 2 else 2, turned)
    with tempfile.TemporaryDirectory() as folder:
        folder = os.path.join(keep, str(index)) if keep else folder
        os.makedirs(folder, exist_ok=True)
        scene.write(folder)
        run = subprocess.run([program, 'run', 'scene.hvi', '--no-files', '--threads', '1', '--json', 'out.json'], cwd=folder,
                             capture_output=True, text=True, timeout=60)
        if run.returncode == 3:
            return scene, 'refused', run.stderr.split('\n')[0]
        if run.returncode != 0:
            return scene, 'wrong', f'exit {run.returncode}: ' + run.stderr.split('\n')[0]
        result = json.load(open(os.path.join(folder, 'out.json')))
    table = result['table']
    for n, t in enumerate(table['t']):
        u = np.array([[table[f'u{i}{"xyz"[k]}'][n] for k in range(scene.dim)] for i in range(len(scene.points))])
        if t > 0 and (found := scene.mistakes(u, t)):
            return scene, 'wrong', f't = {t}: ' + '; '.join(found)
    return scene, 'certified', ''


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument('program')
    arguments.add_argument('--scenes', type=int, default=300)
    arguments.add_argument('--seed', type=int, default=17)
    arguments.add_argument('--turned', type=float, default=.7, help='share of the scenes')
    arguments.add_argument('--keep', help='folder for the scenes')
    arguments.add_argument('--only', type=int, help='one scene, by its number')
    a = arguments.parse_args()
    program = os.path.abspath(a.program)
    count = {'certified': 0, 'wrong': 0, 'refused': 0}
    refused = {2: 0, 3: 0}
    asked = range(a.scenes) if a.only is None else [a.only]
    spatial = 0
    for i in asked:
        scene, verdict, why = judge(program, a.seed, i, a.turned, a.keep)
        count[verdict] += 1
        spatial += scene.dim == 3
        if verdict == 'refused':
            refused[scene.dim] += 1
        if verdict != 'certified':
            print(f'scene {i} ({scene.dim}D, mu {scene.mu:.2f}, nu {scene.nu:.2f}{", midpoint" if scene.midpoint else ""}): {verdict}: {why}')
    print(f'family coulomb: scenes {len(asked)}, certified {count["certified"]}, wrong {count["wrong"]}, refused {count["refused"]}')
    sys.exit(count['wrong'] > 0 or refused[2] > 0 or refused[3] > BOUND_3D * spatial)


main()
