"""Small elastic solids in dense algebra, for references that share nothing with the program.

Meshes of simplices that can be turned, scaled and moved; P1 and P2 stiffness matrices, loads, and the points of
boundary laws with the program's three rules (docs/language.md).
"""
import itertools
import math

import numpy as np

CREASE = 0.7071  # facets at a node whose normals have a smaller cosine have a crease between them


class Mesh:
    """points (n x dim), cells (n x dim + 1), facets: name -> vertices of facets, patch: numbers of the cells of a group."""

    def __init__(self, points, cells, facets, patch=()):
        self.points, self.cells, self.facets = np.array(points, float), np.array(cells), facets
        self.patch = patch
        self.dim = self.points.shape[1]

    def moved(self, turn, scale, shift):
        return Mesh(scale * self.points @ turn.T + shift, self.cells, self.facets, self.patch)

    def msh(self):
        """The mesh as text in format 2.2, a group for each name, `patch` where there is one, and `body`, the other cells."""
        dim = self.dim
        names = [*self.facets, *(["patch"] if self.patch else []), "body"]
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
        lines += [f'{dim - (name in self.facets)} {k + 1} "{name}"' for k, name in enumerate(names)]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.points))]
        for k, p in enumerate(self.points):
            lines.append(" ".join([str(k + 1), *(repr(float(v)) for v in [*p, *[0.0] * (3 - dim)])]))
        kind = {2: 1, 3: 2, 4: 4}
        elements = [(names.index(name) + 1, f) for name, facets in self.facets.items() for f in facets]
        elements += [(names.index("patch" if k in self.patch else "body") + 1, c) for k, c in enumerate(self.cells)]
        lines += ["$EndNodes", "$Elements", str(len(elements))]
        for k, (group, nodes) in enumerate(elements):
            lines.append(" ".join(map(str, [k + 1, kind[len(nodes)], 2, group, group, *(int(v) + 1 for v in nodes)])))
        return "\n".join([*lines, "$EndElements", ""])


def block(random, counts, sizes, wobble=0.0, bumps=0.0):
    """A box of simplices: inner points moved by `wobble` of a cell, those of the ground by `bumps`."""
    dim = len(counts)
    grid = list(itertools.product(*(range(n + 1) for n in counts)))
    index = {g: k for k, g in enumerate(grid)}
    cell = np.array(sizes) / np.array(counts)
    points = np.array(grid) * cell
    up = 1  # y is up
    for g, k in index.items():
        if all(0 < g[a] < counts[a] for a in range(dim)):
            points[k] += wobble * cell * random.uniform(-1, 1, dim)
        elif g[up] == 0:
            points[k, up] += bumps * cell[up] * random.uniform(-1, 1)
    cells = []
    for corner in itertools.product(*(range(n) for n in counts)):
        flip = random.integers(2) if dim == 2 else 0  # diagonals of boxes have to fit
        for order in itertools.permutations(range(dim)):
            at, path = list(corner), []
            if flip:
                at[0] += 1
            path.append(index[tuple(at)])
            for axis in order:
                at[axis] += -1 if flip and axis == 0 else 1
                path.append(index[tuple(at)])
            cells.append(path)
    count = {}
    for c in cells:
        for k in range(dim + 1):
            f = tuple(sorted(c[:k] + c[k + 1:]))
            count[f] = count.get(f, 0) + 1
    names = [["left", "right"], ["bottom", "top"], ["back", "front"]]
    facets = {name: [] for pair in names[:dim] for name in pair}
    for f, n in count.items():
        if n > 1:
            continue
        for axis in range(dim):
            for side in (0, 1):
                if all(grid[v][axis] == side * counts[axis] for v in f):
                    facets[names[axis][side]].append(f)
    return Mesh(points, cells, facets)


def turning(random, dim):
    """A random proper rotation."""
    q, r = np.linalg.qr(random.normal(size=(dim, dim)))
    q = q * np.sign(np.diag(r))
    if np.linalg.det(q) < 0:
        q[:, 0] = -q[:, 0]
    return q


# --- elements


def shapes(order, b):
    """Values at barycentric b: vertices, then edges (i < j)."""
    if order == 1:
        return np.array(b)
    edges = [4 * b[i] * b[j] for i, j in itertools.combinations(range(len(b)), 2)]
    return np.array([v * (2 * v - 1) for v in b] + edges)


def slopes(order, b):
    """Derivatives with respect to the barycentric coordinates."""
    n = len(b)
    if order == 1:
        return np.eye(n)
    out = [(4 * b[i] - 1) * np.eye(n)[i] for i in range(n)]
    for i, j in itertools.combinations(range(n), 2):
        out.append(4 * (b[i] * np.eye(n)[j] + b[j] * np.eye(n)[i]))
    return np.array(out)


def permuted(*values):
    return sorted(set(itertools.permutations(values)))


def triangle_rule(degree):
    """Degree 1, 2 (Hammer, Stroud) and 4 (Strang, Fix), weights of sum 1."""
    if degree <= 1:
        return [((1 / 3,) * 3, 1.0)]
    if degree == 2:
        return [(p, 1 / 3) for p in permuted(1 / 6, 1 / 6, 2 / 3)]
    root, s = math.sqrt(38 - 44 * math.sqrt(0.4)), math.sqrt(10)
    split = math.sqrt(213125 - 53320 * s)
    out = []
    for weight, a in (((620 + split) / 3720, (8 - s + root) / 18), ((620 - split) / 3720, (8 - s - root) / 18)):
        out += [(p, weight) for p in permuted(a, a, 1 - 2 * a)]
    return out


def line_rule(n):
    x, w = np.polynomial.legendre.leggauss(n)
    return [((1 - (1 + t) / 2, (1 + t) / 2), v / 2) for t, v in zip(x, w)]


def cell_rule(dim):
    """Exact for products of P2 gradients."""
    if dim == 2:
        return triangle_rule(2)
    a = (5 - math.sqrt(5)) / 20
    return [(p, 0.25) for p in permuted(a, a, a, 1 - 3 * a)]


def facet_rule(dim, order, rule):
    """Points and weights of a boundary law (`nodal`, `midpoint`, `gauss`) on facets of a solid."""
    corners = dim
    if rule == "midpoint":
        return [((1 / corners,) * corners, 1.0)]
    if rule == "gauss":
        return line_rule(order + 1) if dim == 2 else triangle_rule(2 * order)
    vertices = [tuple(np.eye(corners)[k]) for k in range(corners)]
    middles = [tuple((np.eye(corners)[i] + np.eye(corners)[j]) / 2)
               for i, j in itertools.combinations(range(corners), 2)]
    if order == 1:
        return [(p, 1 / corners) for p in vertices]
    if dim == 2:
        return [(p, 1 / 6) for p in vertices] + [(middles[0], 2 / 3)]
    return [(p, 1 / 3) for p in middles]


class Solid:
    """A vector space of order 1 or 2 on a mesh."""

    def __init__(self, mesh, order):
        self.mesh, self.order, self.dim = mesh, order, mesh.dim
        self.edges = {}
        points = list(mesh.points)
        if order == 2:
            for cell in mesh.cells:
                for i, j in itertools.combinations(cell, 2):
                    key = (min(i, j), max(i, j))
                    if key not in self.edges:
                        self.edges[key] = len(points)
                        points.append((mesh.points[i] + mesh.points[j]) / 2)
        self.points = np.array(points)
        self.n = len(points) * self.dim

    def nodes(self, simplex):
        out = list(simplex)
        if self.order == 2:
            out += [self.edges[min(i, j), max(i, j)] for i, j in itertools.combinations(simplex, 2)]
        return out

    def on(self, name):
        return sorted({v for f in self.mesh.facets[name] for v in self.nodes(f)})

    def dofs(self, nodes):
        return np.array([self.dim * v + k for v in nodes for k in range(self.dim)])

    def stiffness(self, lam, mu):
        """int lam div u div v + 2 mu eps(u) : eps(v)."""
        dim, k = self.dim, np.zeros((self.n, self.n))
        for cell in self.mesh.cells:
            x = self.mesh.points[cell]
            edges = (x[1:] - x[0]).T
            volume = abs(np.linalg.det(edges)) / math.factorial(dim)
            inner = np.linalg.inv(edges)
            barycentric = np.vstack([-inner.sum(0), inner])
            dofs = self.dofs(self.nodes(cell))
            for b, weight in cell_rule(dim):
                g = slopes(self.order, b) @ barycentric  # node x direction
                m = len(g)
                grad = np.zeros((dim, dim, m * dim))
                for a in range(m):
                    for c in range(dim):
                        grad[c, :, a * dim + c] = g[a]
                strain = (grad + grad.transpose(1, 0, 2)) / 2
                div = np.einsum("iik->k", strain)
                local = lam * np.outer(div, div) + 2 * mu * np.einsum("ijk,ijl->kl", strain, strain)
                k[np.ix_(dofs, dofs)] += weight * volume * local
        return k

    def body_load(self, force):
        out = np.zeros(self.n)
        rule = cell_rule(self.dim)
        for cell in self.mesh.cells:
            x = self.mesh.points[cell]
            volume = abs(np.linalg.det((x[1:] - x[0]).T)) / math.factorial(self.dim)
            values = sum(w * shapes(self.order, b) for b, w in rule)
            out[self.dofs(self.nodes(cell))] += np.kron(volume * values, force)
        return out

    def facet(self, f):
        """Size and outer normal; the cell behind it tells which side is out."""
        x = self.mesh.points[list(f)]
        cell = next(c for c in self.mesh.cells if set(f) <= set(c))
        if self.dim == 2:
            t = x[1] - x[0]
            normal = np.array([t[1], -t[0]])
            size = np.linalg.norm(normal)
        else:
            normal = np.cross(x[1] - x[0], x[2] - x[0])
            size = np.linalg.norm(normal) / 2
        normal = normal / np.linalg.norm(normal)
        inside = self.mesh.points[cell].mean(0) - x.mean(0)
        return size, (-normal if normal @ inside > 0 else normal)

    def facet_load(self, name, force):
        out = np.zeros(self.n)
        rule = line_rule(3) if self.dim == 2 else triangle_rule(4)
        for f in self.mesh.facets[name]:
            size, _ = self.facet(f)
            values = sum(w * shapes(self.order, b) for b, w in rule)
            out[self.dofs(self.nodes(f))] += np.kron(size * values, force)
        return out

    def law_points(self, name, rule):
        """(weight, N, normal): N (dim x n) takes u to its value at the point."""
        out = []
        fans = Fans(self, self.mesh.facets[name])
        for k, f in enumerate(fans.facets):
            for b, weight in facet_rule(self.dim, self.order, rule):
                values = np.zeros((self.dim, self.n))
                for node, v in zip(self.nodes(f), shapes(self.order, b)):
                    for c in range(self.dim):
                        values[c, self.dim * node + c] = v
                out.append((weight * fans.sizes[k], values, fans.at_point(k, b, rule)))
        return out


class Fans:
    """Facets of a side, and normals at their nodes: means over the facets that no crease parts from each other."""

    def __init__(self, solid, facets):
        self.solid, self.facets = solid, [tuple(int(v) for v in f) for f in facets]
        self.sizes, self.normals = zip(*(solid.facet(f) for f in self.facets))
        self.at = {}
        for k, f in enumerate(self.facets):
            for node in solid.nodes(f):
                self.at.setdefault(node, []).append(k)
        self.corners = {}  # key -> normal
        known = set()
        for k, f in enumerate(self.facets):
            for v in f:
                fan = self.fan(k, v)
                total = sum(self.share(i, v) * self.normals[i] for i in fan)
                self.corners[v, fan[0]] = total / np.linalg.norm(total)
                sides = [w for i in fan for w in self.facets[i] if w != v]
                if len(fan) > 1 if solid.dim == 2 else all(sides.count(w) == 2 for w in sides):
                    known.add((v, fan[0]))
        while ends := {key: self.end(key, known) for key in self.corners if key not in known}:
            ends = {key: end for key, end in ends.items() if end}
            whole = any(full for _, full in ends.values())
            for key, (normal, full) in ends.items():
                if full == whole:
                    self.corners[key] = normal
                    known.add(key)
            if not ends:
                break

    def end(self, key, known):
        """The mean turned so that its sum with that of known neighbours is across the edge; are these in all directions?"""
        v, m, x = key[0], self.corners[key], self.solid.mesh.points
        rows, right = [], []
        for i in self.fan(key[1], v):
            for w in self.facets[i]:
                other = (w, self.fan(i, w)[0])
                if w != v and other in known:
                    edge = (x[w] - x[v]) / np.linalg.norm(x[w] - x[v])
                    rows.append(edge - edge @ m * m)
                    right.append(-edge @ m - edge @ self.corners[other])
        if not rows:
            return None
        sizes = np.linalg.svd(rows, compute_uv=False)
        total = m + np.linalg.lstsq(np.array(rows), np.array(right), rcond=0.1)[0]
        return total / np.linalg.norm(total), self.solid.dim == 2 or (len(sizes) > 1 and sizes[1] > 0.1 * sizes[0])

    def fan(self, k, node):
        found, grows = {k}, True
        while grows:
            more = {i for i in self.at[node] if i not in found and
                    any(self.normals[i] @ self.normals[j] >= CREASE for j in found)}
            found, grows = found | more, bool(more)
        return sorted(found)

    def share(self, i, node):
        """Of a facet in the normal at its corner: exact on circles and balls (N. Max)."""
        if self.solid.dim == 2:
            return 1 / self.sizes[i]
        a, b = (self.solid.mesh.points[v] - self.solid.mesh.points[node] for v in self.facets[i] if v != node)
        return np.linalg.norm(np.cross(a, b)) / (a @ a) / (b @ b)

    def normal(self, k, node):
        """Of facet k at a node of it; in the middle of an edge that between its ends."""
        f = self.facets[k]
        ends = [node] if node in f else next(e for e in itertools.combinations(f, 2) if self.solid.edges[tuple(sorted(e))] == node)
        total = sum(self.corners[v, self.fan(k, v)[0]] for v in ends)
        return total / np.linalg.norm(total)

    def at_point(self, k, b, rule):
        """Of facet k at barycentric b: that of the node, where the rule's points are nodes."""
        if rule != "nodal":
            return self.normals[k]
        return self.normal(k, self.solid.nodes(self.facets[k])[int(np.argmax(shapes(self.solid.order, b)))])
