"""The jump across a pair of two sides in dense algebra, for references that share nothing with the program.

docs/theory.md has the formulas. The pieces of facets on which everything is a polynomial are found another way than in
the program: in 2D between the sorted images of nodes, in 3D as hulls of all corners that two triangles can have in
common.
"""
import itertools

import numpy as np

from solids import Fans, line_rule, shapes, triangle_rule

LARGEST_DUAL = 14.0


class PairPoint:
    def __init__(self, weight, jump, normal, gap, node):
        self.weight, self.jump, self.normal, self.gap, self.node = weight, jump, normal, gap, node


class Side(Fans):
    """The first side: its points are its nodes, with averaged normals."""

    def __init__(self, solid, facets):
        super().__init__(solid, facets)
        self.keys, self.normal_of = [], {}
        for k, f in enumerate(self.facets):
            row = []
            for node in solid.nodes(f):
                fan = self.fan(k, node)
                key = (node, fan[0])
                self.normal_of[key] = self.normal(k, node)
                row.append(key)
            self.keys.append(row)

    def direction(self, k):
        total = sum(self.normal_of[key] for key in self.keys[k][:self.solid.dim])
        return total / np.linalg.norm(total)


def pieces_2d(low_high):
    low, high = max(min(low_high), 0.0), min(max(low_high), 1.0)
    if high - low <= 1e-14:
        return []
    return [((1 - (a := low + (high - low) * b[1]), a), w * (high - low)) for b, w in line_rule(6)]


def cross_2d(u, v):
    return u[0] * v[1] - u[1] * v[0]


def pieces_3d(triangle):
    """Points and weights on what a triangle has in common with the one of (0, 0), (1, 0), (0, 1)."""
    unit = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])

    def inside(p, t):
        total = cross_2d(t[1] - t[0], t[2] - t[0])
        return all(cross_2d(t[(i + 1) % 3] - t[i], p - t[i]) / total >= -1e-13 for i in range(3))

    corners = [p for p in triangle if inside(p, unit)] + [p for p in unit if inside(p, triangle)]
    for i, j in itertools.product(range(3), range(3)):
        p, r = unit[i], unit[(i + 1) % 3] - unit[i]
        q, s = triangle[j], triangle[(j + 1) % 3] - triangle[j]
        det = cross_2d(r, s)
        if abs(det) < 1e-14:
            continue
        a, b = cross_2d(q - p, s) / det, cross_2d(q - p, r) / det
        if -1e-14 <= a <= 1 + 1e-14 and -1e-14 <= b <= 1 + 1e-14:
            corners.append(p + a * r)
    if len(corners) < 3:
        return []
    corners = np.array(corners)
    middle = corners.mean(0)
    order = np.argsort(np.arctan2(*(corners - middle).T[::-1]))
    corners, out = corners[order], []
    for p, q in zip(corners, np.roll(corners, -1, axis=0)):
        area = abs(cross_2d(p - middle, q - middle))  # of the unit triangle's 1
        if area < 1e-15:
            continue
        for b, w in triangle_rule(4):
            at = b[0] * middle + b[1] * p + b[2] * q
            out.append(((1 - at.sum(), *at), w * area))
    return out


def barycentric_in(corners, at):
    if len(corners) == 2:
        t = (at[1] - corners[0, 0]) / (corners[1, 0] - corners[0, 0])
        return 1 - t, t
    m = np.column_stack([corners[1] - corners[0], corners[2] - corners[0]])
    a, b = np.linalg.solve(m, np.array(at[1:]) - corners[0])
    return 1 - a - b, a, b


def bodies_at(mesh, place):
    """How many bodies a place is in, as far as two: cells of two have no corner in common."""
    homes = []
    for cell in mesh.cells:
        x = mesh.points[cell]
        if np.any(place < x.min(0) - 1e-6) or np.any(place > x.max(0) + 1e-6):
            continue
        b = np.linalg.solve((x[1:] - x[0]).T, place - x[0])
        if min(b.min(), 1 - b.sum()) >= -1e-9:
            homes.append(set(cell))
    return 2 if any(not p & q for p in homes for q in homes) else min(len(homes), 1)


def through_bodies(solid, facet, b, direction, distance):
    """Is what is behind a facet there for another reason than that two bodies are pressed into each other?"""
    x = solid.mesh.points[list(facet)]
    if distance >= -1e-6 * np.linalg.norm(x[1] - x[0]):
        return False
    place = lambda part: np.asarray(b) @ x + part * distance * direction
    return any(bodies_at(solid.mesh, place(part)) < n for part, n in ((-0.5, 1), (0.05, 2), (0.95, 2), (1.5, 1)))


def meetings(solid, facet, direction, second, reach):
    """(first barycentric, second facet, its barycentric, weight as a share, distance)."""
    dim, x = solid.dim, solid.mesh.points[list(facet)]
    frame = np.linalg.inv(np.column_stack([*(x[1:] - x[0]), direction]))
    out = []
    for other in second:
        if solid.facet(other)[1] @ direction >= -0.1:
            continue
        images = (frame @ (solid.mesh.points[list(other)] - x[0]).T).T
        flat = images[:, :-1]
        found = pieces_2d(flat[:, 0]) if dim == 2 else pieces_3d(flat)
        if not found:
            continue
        total = sum(w for _, w in found)
        middle = sum(w * np.array(b) for b, w in found) / total
        apart = lambda at: np.dot(barycentric_in(flat, at), images[:, -1])
        centre = flat.mean(0)
        places = [middle, (1 / dim,) * dim, (1 - centre.sum(), *centre)]  # at an edge of the bodies the way may leave them
        if abs(apart(middle)) > reach or all(through_bodies(solid, facet, at, direction, apart(at)) for at in places):
            continue
        for b, w in found:
            its = barycentric_in(flat, b)
            out.append((b, other, its, w, float(np.dot(its, images[:, -1]))))
    return out


def duals(order, found):
    """int q_i, and the functions psi_i at the points; are they biorthogonal?"""
    q = np.array([shapes(order, b) for b, *_ in found])
    w = np.array([m[3] for m in found])
    sizes, mass = q.T @ w, q.T @ (w[:, None] * q)
    scale = np.sqrt(np.diag(mass))
    if scale.min() > 0:
        psi = q @ (np.diag(sizes / scale) @ np.linalg.pinv(mass / np.outer(scale, scale), rcond=1e-15) @ np.diag(1 / scale)).T
        if np.sqrt((w @ psi ** 2).max() / w.sum()) <= LARGEST_DUAL:
            return sizes, psi
    return sizes, q


def revolved(x, found):
    """Meetings of a facet with these radii x of its ends, their weights times 2 pi x."""
    return [(b, other, its, w * 2 * np.pi * np.dot(b, x), distance) for b, other, its, w, distance in found]


def pair_points(solid, first, second, trace=None, rings=False):
    """The points of pair(first, second), facets by their vertices, and how many nodes have no partner.

    The points are those of the solid's order, the rows those of its functions, or of the functions of another one, `trace`.
    `rings`: of bodies of revolution about x = 0.
    """
    dim, side, trace = solid.dim, Side(solid, first), trace or solid
    corners = solid.mesh.points[sorted({int(v) for f in first for v in f})]
    reach = float(np.linalg.norm(corners.max(0) - corners.min(0)))
    weight, jump, gap, met = {}, {}, {}, set()
    for k, facet in enumerate(side.facets):
        direction = side.direction(k)
        found = meetings(solid, facet, direction, second, reach)
        if not found:
            continue
        met |= set(side.keys[k])
        covered = sum(m[3] for m in found)
        assert covered < 1 + 1e-6
        radii = solid.mesh.points[list(facet)][:, 0]
        at_axis = rings and radii.min() == 0.0
        if rings:
            found = revolved(radii, found)
        order = solid.order if dim == 2 and covered > 1 - 1e-9 and not at_axis else 1
        sizes, psi = duals(order, found)
        for i in range(psi.shape[1]):
            key = side.keys[k][i]
            weight[key] = weight.get(key, 0.0) + side.sizes[k] * sizes[i]
            row = jump.setdefault(key, np.zeros(trace.n // dim))
            for p, (own, other, its, w, distance) in zip(psi[:, i], found):
                share = side.sizes[k] * w * p
                row[trace.nodes(facet)] += share * shapes(trace.order, own)
                row[trace.nodes(other)] -= share * shapes(trace.order, its)
                gap[key] = gap.get(key, 0.0) + share * distance * direction
    out = []
    for key, w in weight.items():
        if w > 0:
            normal = side.normal_of[key]
            out.append(PairPoint(w, np.kron(jump[key] / w, np.eye(dim)), normal, float(gap[key] @ normal) / w, key[0]))
    alone = len({key for keys in side.keys for key in keys} - met)
    return out, alone
