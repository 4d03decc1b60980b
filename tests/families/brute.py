"""Brute force for one step: u with  K u + sum_p w_p G_p^T xi_p = f,  xi_p in dj_p(G_p u + g_p).

Block Gauss-Seidel on the multipliers (convex steps: each point solved exactly with the others fixed), and every so
often an attempt to solve the equations of the states found so far directly, which counts only when every point then
lies on its law. Dense algebra; nothing is shared with the program.
"""
import math

import numpy as np

NEAR = [1e-9, 1e-11, 1e-13]  # a break, relative to displacements, where the states are those of an answer
ROUNDING = 1e-9  # of displacements and multipliers in the last check, relative to the scene's own


class Law:
    """The slope of a law: pieces (low, high, slope at low or anchor, anchor, growth), jumps upwards only."""

    radial = False

    def __init__(self, breaks, anchors, starts, growths):
        self.breaks, self.anchors, self.starts, self.growths = breaks, anchors, starts, growths

    def ends(self, i):
        low = self.breaks[i - 1] if i > 0 else -math.inf
        return low, self.breaks[i] if i < len(self.breaks) else math.inf

    def slope(self, i, r):
        return self.starts[i] + self.growths[i] * (r - self.anchors[i])

    def limits(self, i):
        """The jump at break i."""
        return self.slope(i, self.breaks[i]), self.slope(i + 1, self.breaks[i])

    def descent(self):
        return max(0.0, *(-g for g in self.growths))

    def solve(self, y, kappa):
        """z and state with z + kappa xi = y: ("in", piece) or ("at", break)."""
        for i in range(len(self.starts)):
            low, high = self.ends(i)
            z = (y - kappa * (self.starts[i] - self.growths[i] * self.anchors[i])) / (1 + kappa * self.growths[i])
            if z > high:
                if i + 1 < len(self.starts) and y <= high + kappa * self.limits(i)[1]:
                    return high, ("at", i)
                continue
            return max(z, low), ("in", i)
        raise AssertionError


class Unilateral(Law):
    """Nothing up to the gap, whatever it takes there."""

    def __init__(self, gap):
        super().__init__([gap], [0.0, 0.0], [0.0, math.inf], [0.0, 0.0])

    def limits(self, i):
        return 0.0, math.inf

    def solve(self, y, kappa):
        return (y, ("in", 0)) if y <= self.breaks[0] else (self.breaks[0], ("at", 0))


class Friction:
    """Radial: the bound is sliding + (static - sliding) exp(-decay r)."""

    radial = True

    def __init__(self, static, sliding, decay):
        self.static, self.sliding, self.decay = static, sliding, decay

    def slope(self, r):
        return self.sliding + (self.static - self.sliding) * math.exp(-self.decay * r)

    def growth(self, r):
        return -self.decay * (self.static - self.sliding) * math.exp(-self.decay * r)

    def descent(self):
        return max(0.0, self.decay * (self.static - self.sliding))

    def solve(self, y, kappa):
        """The r >= 0 with r + kappa slope(r) = y."""
        if y <= kappa * self.static:
            return 0.0, ("origin",)
        low, high = 0.0, y
        r = y - kappa * self.static
        for _ in range(100):
            f = r + kappa * self.slope(r) - y
            low, high = (low, r) if f > 0 else (r, high)
            step = r - f / (1 + kappa * self.growth(r))
            new = step if low < step < high else (low + high) / 2
            if abs(new - r) <= 1e-16 * abs(r):
                break
            r = new
        return r, ("slip",)


class Point:
    def __init__(self, law, weight, rows, offset):
        self.law, self.weight, self.rows, self.offset = law, weight, np.atleast_2d(rows), np.atleast_1d(offset)


def ratio(inverse, points):
    """lambda_max of the descents against K: below 1 the step is strictly convex."""
    rows = [math.sqrt(p.weight * p.law.descent()) * p.rows for p in points if p.law.descent() > 0]
    if not rows:
        return 0.0
    g = np.vstack(rows)
    return float(np.linalg.eigvalsh(g @ inverse @ g.T).max())


def state_at(law, z, as_one):
    """As in `solve` of a law: where a jump holds z, else the piece that z lies in."""
    if law.radial:
        return ("origin",) if np.linalg.norm(z) <= as_one else ("slip",)
    for i, at in enumerate(law.breaks):
        low, high = law.limits(i)
        if abs(z[0] - at) <= as_one and high > low:
            return "at", i
    return "in", sum(z[0] > at for at in law.breaks)


class Step:
    """One step's equations condensed to the rows of the points."""

    def __init__(self, k, points):
        self.inverse = np.linalg.inv(k)
        points = [p for p in points if p.rows.any()]  # where u is given the laws have no say
        self.k, self.points = k, points
        self.g = np.vstack([p.rows for p in points])
        first = np.cumsum([0] + [len(p.rows) for p in points])
        self.rows = [slice(a, b) for a, b in zip(first, first[1:])]
        self.weights = np.concatenate([np.full(len(p.rows), p.weight) for p in points])
        self.offset = np.concatenate([p.offset for p in points])
        self.c = self.g @ self.inverse @ self.g.T
        self.kappa = [p.weight * np.linalg.eigvalsh(self.c[r, r]).max() for p, r in zip(points, self.rows)]
        self.xi = np.zeros(len(self.g))
        self.states = [None] * len(points)
        self.z = None

    def sweep(self):
        change = 0.0
        for p, rows, kappa, k in zip(self.points, self.rows, self.kappa, range(len(self.points))):
            old = self.xi[rows].copy()
            y = self.z[rows] + kappa * old
            if p.law.radial:
                size = math.sqrt(y @ y)
                r, self.states[k] = p.law.solve(size, kappa)
                new = (y - (r / size if size > 0 else 0.0) * y) / kappa
            else:
                z, self.states[k] = p.law.solve(y[0], kappa)
                new = (y - z) / kappa
            if not np.array_equal(new, old):
                self.xi[rows] = new
                self.z += self.c[:, rows] @ (p.weight * (old - new))
                change = max(change, float(np.abs(new - old).max()))
        return change

    def solve(self, f, turns=400):
        free = self.inverse @ f
        self.scale = float(np.abs(free).max()) or 1.0
        start = self.g @ free + self.offset
        for turn in range(turns):
            self.z = start - self.c @ (self.weights * self.xi)
            for _ in range(3 + turn):
                if self.sweep() == 0.0:
                    break
            u = self.polish(f)
            if u is not None:
                return u
        return None

    def accepts(self, f, u):
        """Is u, found elsewhere, a solution: has every point a multiplier on its law there, and do they balance the forces?"""
        self.scale = float(np.abs(self.inverse @ f).max()) or 1.0
        z = self.g @ u + self.offset
        for as_one in NEAR:
            self.states = [state_at(p.law, z[rows], as_one * self.scale) for p, rows in zip(self.points, self.rows)]
            if self.holds(u, f):
                return True
        return False

    def polish(self, f):
        """Newton on the equations of the states, from u of the sweeps; None where they do not hold."""
        u = self.inverse @ (f - self.g.T @ (self.weights * self.xi))
        for _ in range(30):
            k, rhs, held, values = self.k.copy(), f.copy(), [], []
            z = self.g @ u + self.offset
            for p, rows, state in zip(self.points, self.rows, self.states):
                if state[0] == "origin" or state[0] == "at":
                    held.append(p.rows)
                    at = p.law.breaks[state[1]] if state[0] == "at" else 0.0
                    values.append(at - p.offset)
                    continue
                if p.law.radial:
                    r = np.linalg.norm(z[rows])
                    e = z[rows] / r if r > 0 else self.xi[rows] / max(np.linalg.norm(self.xi[rows]), 1e-300)
                    along, across = p.law.growth(r), p.law.slope(r) / max(r, 1e-300)
                    # Across: the exact turn of the unit vector, so that Newton's method converges.
                    d = along * np.outer(e, e) + across * (np.eye(len(e)) - np.outer(e, e))
                    xi = p.law.slope(r) * e
                else:
                    i = state[1]
                    d, xi = np.array([[p.law.growths[i]]]), np.array([p.law.slope(i, z[rows][0])])
                k += p.weight * p.rows.T @ d @ p.rows
                rhs -= p.weight * p.rows.T @ (xi - d @ z[rows] + d @ p.offset)
            new = constrained(k, rhs, held, values)
            if new is None or not np.all(np.isfinite(new)):
                return None
            moved, u = np.abs(new - u).max(), new
            if moved <= 1e-14 * self.scale:
                break
        return u if self.holds(u, f) else None

    def holds(self, u, f):
        """Is there a multiplier for every point, on its law at z, that balances the forces?"""
        z = self.g @ u + self.offset
        left = f - self.k @ u
        held = []
        for n, (p, rows, state) in enumerate(zip(self.points, self.rows, self.states)):
            zp = z[rows]
            if state[0] in ("origin", "at"):
                held.append(n)
                continue
            if p.law.radial:
                r = np.linalg.norm(zp)
                if r < ROUNDING * self.scale * 1e-3:
                    return False
                xi = p.law.slope(r) * zp / r
            else:
                low, high = p.law.ends(state[1])
                if not low - 1e-12 * self.scale <= zp[0] <= high + 1e-12 * self.scale:
                    return False
                xi = np.array([p.law.slope(state[1], zp[0])])
            left = left - p.weight * p.rows.T @ xi
        size = float(np.abs(f).max() + np.abs(self.k @ u).max())
        if not held:
            return bool(np.abs(left).max() <= ROUNDING * size)
        return self.balanced([self.points[n] for n in held], [self.states[n] for n in held],
                             [self.xi[self.rows[n]] for n in held], left, size)

    def balanced(self, points, states, xi, left, size):
        """Multipliers of held points: those of the sweeps, moved the least way that balances (alternating
        projections on the forces' equation and the laws' intervals and balls)."""
        g = np.vstack([math.sqrt(p.weight) * p.rows for p in points])
        # Scaled by sqrt(w): the least change in the norm of the boundary.
        weights = [math.sqrt(p.weight) for p in points]
        back = np.linalg.pinv(g.T, rcond=1e-11)
        lengths = np.cumsum([0] + [len(x) for x in xi])
        eta = np.concatenate([w * x for w, x in zip(weights, xi)])
        for _ in range(2000):
            eta = eta + back @ (left - g.T @ eta)
            if not np.abs(left - g.T @ eta).max() <= ROUNDING * size:
                return False  # no multiplier of these points balances it
            inside = eta.copy()
            for p, w, state, a, b in zip(points, weights, states, lengths, lengths[1:]):
                if p.law.radial:
                    r = np.linalg.norm(eta[a:b])
                    if r > w * p.law.static:
                        inside[a:b] *= w * p.law.static / r
                else:
                    low, high = p.law.limits(state[1])
                    inside[a] = min(max(eta[a], w * low), w * high)
            if np.abs(g.T @ (inside - eta)).max() <= ROUNDING * size:
                return True
            eta = inside
        return False


def constrained(k, rhs, held, values):
    """K u = rhs on the subspace where the held rows have their values; None where they cannot."""
    if not held:
        return solved(k, rhs)
    a, b = np.vstack(held), np.concatenate(values)
    left, sizes, right = np.linalg.svd(a)
    rank = int((sizes > 1e-9 * sizes[0]).sum())
    u0 = right[:rank].T @ ((left[:, :rank].T @ b) / sizes[:rank])
    if np.abs(a @ u0 - b).max() > 1e-10 * (np.abs(b).max() + 1e-300):
        return None
    basis = right[rank:].T
    if basis.shape[1] == 0:
        return u0
    inside = solved(basis.T @ k @ basis, basis.T @ (rhs - k @ u0))
    return None if inside is None else u0 + basis @ inside


def solved(k, rhs):
    """None where laws soften by just as much as K has."""
    try:
        return np.linalg.solve(k, rhs)
    except np.linalg.LinAlgError:
        return None
