#!/usr/bin/env python3
"""Branches of softening laws with drops: N from 5 to 1,000 steps, against exact path following.

    branches.py HVI_RUN [--scenes N] [--seed S] [--most STEPS]

Random elastic bodies (2D; every eighth 3D), turned, scaled, long or stiff, pulled and pushed by their
roof, every third by a wall, too, so that nothing is left to solve for at ends of the ground; on the
ground a random law of straight pieces that softens, jumps up and drops. The reference assembles the
body itself, condenses it to the ground's free nodes (dense Schur complement) and follows the equilibrium
curve from event to event by the sign of the determinant, with no step at all: where the
load turns back a branch has ended, and the state after it is the next stable one at that load.

wrong: a certified answer that is not the reference's, or differs between two N. refused: exit code
other than 0, though the reference has a solution. Times within 1e-6 of an end of a branch, where
rounding decides, are left out.
"""
import argparse, json, math, pathlib, subprocess, sys, tempfile
import numpy as np

TIMES = [0.2, 0.4, 0.6, 0.8, 1.0]  # common to all N, and where the load's slope changes


# ---------------------------------------------------------------- the body
def box(counts, lengths):
    """Nodes and simplices (Kuhn's) of a box; node numbers on its bottom and top."""
    dim = len(counts)
    grid = np.array(list(np.ndindex(*[c + 1 for c in counts])))
    number = {tuple(g): i for i, g in enumerate(grid)}
    import itertools
    cells = []
    for corner in np.ndindex(*counts):
        for order in itertools.permutations(range(dim)):
            at, cell = list(corner), [number[tuple(corner)]]
            for axis in order:
                at[axis] += 1
                cell.append(number[tuple(at)])
            cells.append(cell)
    nodes = grid / np.array(counts) * np.array(lengths)
    up = dim - 1
    return nodes, np.array(cells), np.where(grid[:, up] == 0)[0], np.where(grid[:, up] == counts[up])[0]


def facets_on(cells, chosen):
    chosen = set(chosen.tolist())
    out = {tuple(sorted(int(v) for v in c if int(v) in chosen)) for c in cells}
    return [f for f in out if len(f) == cells.shape[1] - 1]


def stiffness(nodes, cells, lam, mu):
    dim = nodes.shape[1]
    k = np.zeros((nodes.size, nodes.size))
    for cell in cells:
        d = np.hstack([np.ones((dim + 1, 1)), nodes[cell]])
        volume = abs(np.linalg.det(d)) / math.factorial(dim)
        grad = np.linalg.inv(d)[1:, :].T  # a row a node
        local = np.zeros((dim * (dim + 1),) * 2)
        for a in range(dim + 1):
            for b in range(dim + 1):
                ga, gb = grad[a], grad[b]
                local[a * dim:(a + 1) * dim, b * dim:(b + 1) * dim] = volume * (
                    lam * np.outer(ga, gb) + mu * np.outer(gb, ga) + mu * ga @ gb * np.eye(dim))
        index = (cell[:, None] * dim + np.arange(dim)).ravel()
        k[np.ix_(index, index)] += local
    return k


def write_mesh(path, nodes, cells, groups):
    dim = nodes.shape[1]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups) + 1)]
    for i, name in enumerate(groups, 1):
        lines.append(f'{dim - 1} {i} "{name}"')
    lines += [f'{dim} 9 "body"', "$EndPhysicalNames", "$Nodes", str(len(nodes))]
    for i, x in enumerate(nodes, 1):
        lines.append(f"{i} " + " ".join(repr(float(v)) for v in list(x) + [0.0] * (3 - dim)))
    elements = [(dim - 1, i, f) for i, fs in enumerate(groups.values(), 1) for f in fs]
    elements += [(dim, 9, c) for c in cells]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    kinds = {1: 1, 2: 2, 3: 4}
    for i, (d, tag, e) in enumerate(elements, 1):
        lines.append(f"{i} {kinds[d]} 2 {tag} {tag} " + " ".join(str(int(v) + 1) for v in e))
    path.write_text("\n".join(lines + ["$EndElements", ""]))


def rotation(rng, dim):
    q, r = np.linalg.qr(rng.normal(size=(dim, dim)))
    q = q * np.sign(np.diag(r))
    if np.linalg.det(q) < 0:
        q[:, 0] = -q[:, 0]
    return q


# ---------------------------------------------------------------- the law
def random_law(rng, width, stress):
    """Breaks, and per piece (value at its inner end, slope): straight pieces from 0 on."""
    breaks, pieces = [0.0], [(0.0, 0.0)]
    if rng.random() < 0.3:
        pieces = [(0.0, stress / width * 10 ** rng.uniform(-1, 1.5))]
    at, value = 0.0, 0.0
    for k in range(int(rng.integers(2, 6))):
        length = width * 10 ** rng.uniform(-1.0, 0.4)
        kind = rng.random()
        if k == 0:
            slope = stress / length * rng.uniform(0.3, 1.5)
        elif kind < 0.55:
            slope = -value / length * rng.uniform(0.2, 1.0)
        else:
            slope = stress / length * rng.uniform(0.0, 0.6)
        pieces.append((value, slope))
        at, value = at + length, value + slope * length
        breaks.append(at)
        jump = rng.random()
        if jump < 0.35:
            value *= rng.uniform(0.0, 0.8)  # a drop
        elif jump < 0.45:
            value += stress * rng.uniform(0.05, 0.5)
    pieces.append((value, 0.0))
    return np.array(breaks), pieces


def law_text(breaks, pieces):
    lines = []
    for i, (v, s) in enumerate(pieces):
        x = breaks[max(i - 1, 0)]
        head = f"r < {breaks[i]!r}" if i < len(breaks) else "otherwise"
        lines.append(f"  | {head} -> {v!r} + {s!r}*(r - {x!r})")
    return "\n".join(lines).replace("np.float64(", "").replace(")!", "")


# ---------------------------------------------------------------- the reference
class Curve:
    """z + C W xi(z) = b on [piece i: xi = v + s (z - x_i)] or on the upright part of break i."""

    def __init__(self, c, w, breaks, pieces):
        self.a, self.breaks, self.n = c * w, breaks, len(w)
        self.c, self.w = c, w
        self.x = np.array([breaks[max(i - 1, 0)] for i in range(len(pieces))])
        self.v = np.array([p[0] for p in pieces])
        self.s = np.array([p[1] for p in pieces])
        self.below = self.v[:-1] + self.s[:-1] * (breaks - self.x[:-1])
        self.above = self.v[1:]
        kink = np.isclose(self.below, self.above, rtol=1e-12, atol=1e-12 * np.abs(self.v).max())
        self.above = np.where(kink, self.below, self.above)
        self.place = np.zeros(self.n, int)
        self.y = -1e-11 * np.abs(breaks[1]) * (1 + np.arange(self.n) / self.n)  # z, or xi upright
        self.b = self.z() + self.a @ self.xi()
        self.ends = []  # (time, stable state found)

    def upright(self):
        return self.place % 2 == 1

    def z(self):
        return np.where(self.upright(), self.breaks[np.minimum(self.place // 2, len(self.breaks) - 1)], self.y)

    def xi(self):
        i = self.place // 2
        i = np.minimum(i, len(self.v) - 1)
        return np.where(self.upright(), self.y, self.v[i] + self.s[i] * (self.y - self.x[i]))

    def falls(self):
        b = np.minimum(self.place // 2, len(self.breaks) - 1)
        return self.upright() & (self.below[b] > self.above[b])

    def jacobian(self):
        i = np.minimum(self.place // 2, len(self.v) - 1)
        return np.where(self.upright(), self.a, np.eye(self.n) + self.a * self.s[i])

    def stable(self):
        if self.falls().any():
            return False
        free = ~self.upright()
        i = self.place // 2
        # S + H on the free directions: C^-1 + W D with the upright points held
        k = np.linalg.inv(self.c)[np.ix_(free, free)] + np.diag((self.w * self.s[np.minimum(i, len(self.v) - 1)])[free])
        return free.sum() == 0 or np.linalg.eigvalsh(0.5 * (k + k.T))[0] > 0

    def bounds(self):
        i = self.place // 2
        low = np.concatenate([[-np.inf], self.breaks])[i]
        high = np.concatenate([self.breaks, [np.inf]])[i]
        b = np.minimum(i, len(self.breaks) - 1)
        up = self.upright()
        return (np.where(up, np.minimum(self.below[b], self.above[b]), low),
                np.where(up, np.maximum(self.below[b], self.above[b]), high))

    def sign(self):
        """Of the determinant, along the graph (xi falls on the way up a drop)."""
        return np.linalg.slogdet(self.jacobian() * np.where(self.falls(), -1.0, 1.0))[0]

    def cross(self, p, side):
        i = self.place[p] // 2
        if self.upright()[p]:
            if self.falls()[p]:
                side = -side
            self.place[p] = 2 * (i + 1 if side > 0 else i)
            self.y[p] = self.breaks[i]
        else:
            b = i if side > 0 else i - 1
            if self.below[b] == self.above[b]:
                self.place[p] = 2 * (i + side)
                self.y[p] = self.breaks[b]
            else:
                self.place[p] = 2 * b + 1
                self.y[p] = self.below[b] if side > 0 else self.above[b]

    def go(self, to, start_time, end_time):
        """From b to `to`; the load's part l of it. None: the curve is lost."""
        start, db = self.b, to - self.b
        load, target = 0.0, 1.0
        ended = None
        orientation = 1.0
        for _ in range(20000):
            way = np.linalg.solve(self.jacobian(), db) * (orientation * self.sign())
            dl = orientation * self.sign()
            if ended is None and dl < 0:
                ended = load
                target = load
            low, high = self.bounds()
            with np.errstate(divide="ignore", invalid="ignore"):
                room = np.where(way > 0, (high - self.y) / way, np.where(way < 0, (low - self.y) / way, np.inf))
            room = np.maximum(np.nan_to_num(room, nan=np.inf, posinf=np.inf), 0.0)
            p = int(np.argmin(room))
            to_load = (target - load) / dl
            if 0 < to_load <= room[p] or (to_load == 0 and ended is None):
                self.y = self.y + to_load * way
                load = target
                if ended is None:
                    self.b = to
                    return True
                if dl > 0 and self.stable():
                    self.ends.append(start_time + ended * (end_time - start_time))
                    ended, target = None, 1.0
                continue
            if not np.isfinite(room[p]):
                return None
            self.y = self.y + room[p] * way
            load += room[p] * dl
            self.cross(p, 1 if way[p] > 0 else -1)
        return None


# ---------------------------------------------------------------- a scene
def scene(rng, folder, number):
    dim = 3 if number % 8 == 7 else 2
    counts = [int(rng.integers(1, 4)), int(rng.integers(1, 3)), 1] if dim == 3 else [int(rng.integers(2, 9)), int(rng.integers(1, 4))]
    unit = 10 ** rng.uniform(-3, 3)
    lengths = unit * np.array([rng.uniform(0.5, 6)] + [rng.uniform(0.3, 1.5) for _ in counts[1:]])
    nodes, cells, ground, roof = box(counts, lengths)
    inner = np.setdiff1d(np.arange(len(nodes)), np.concatenate([ground, roof]))
    nodes[inner] += rng.uniform(-0.05, 0.05, (len(inner), dim)) * lengths / np.array(counts) * (nodes[inner] > 0) * (nodes[inner] < lengths * (1 - 1e-9))
    turn = rotation(rng, dim)
    if rng.random() < 0.25:
        turn = np.eye(dim)
    local = nodes.copy()
    nodes = nodes @ turn.T
    young, poisson = 10 ** rng.uniform(-3, 6), rng.uniform(0.0, 0.45)
    lam = young * poisson / (1 + poisson) / (1 - 2 * poisson)
    mu = young / 2 / (1 + poisson)
    k = stiffness(nodes, cells, lam, mu)
    up = turn[:, dim - 1]
    wall = np.where(local[:, 0] == 0)[0] if number % 3 == 2 else np.array([], int)
    ground_facets = facets_on(cells, ground)
    held_facets = facets_on(cells, roof) + facets_on(cells, wall)
    held = np.union1d(roof, wall)
    ground = np.setdiff1d(ground, held)  # where the law has something to say
    weight = dict.fromkeys(range(len(nodes)), 0.0)
    for f in ground_facets:
        e = nodes[list(f[1:])] - nodes[f[0]]
        area = math.sqrt(np.linalg.det(e @ e.T)) / math.factorial(dim - 1)
        for v in f:
            weight[v] += area / dim
    w = np.array([weight[int(v)] for v in ground])
    fixed = np.concatenate([held * dim + i for i in range(dim)])
    free = np.setdiff1d(np.arange(nodes.size), fixed)
    g = np.zeros((len(ground), nodes.size))
    for row, v in enumerate(ground):
        g[row, v * dim:(v + 1) * dim] = up  # -u.nu: the ground's normal points down
    inverse = np.linalg.inv(k[np.ix_(free, free)])
    c = g[:, free] @ inverse @ g[:, free].T
    # a law about as stiff as the body at a point, softening up to far steeper
    width = unit * 10 ** rng.uniform(-3, -1)
    stress = width / np.median(np.diag(c) * w) * 10 ** rng.uniform(-0.7, 1.0)
    breaks, pieces = random_law(rng, width, stress)
    breaks = [float(b) for b in breaks]
    pieces = [(float(v), float(s)) for v, s in pieces]
    # pulled up by the roof: straight between TIMES, up and partly back, tilted
    levels = np.concatenate([[0.0], rng.uniform(0.2, 1.0, len(TIMES))])
    if rng.random() < 0.5:
        levels = np.sort(levels)
    reach = breaks[-1] + np.median(np.diag(c) * w) * max(abs(v) for v, _ in pieces)
    pull = reach * rng.uniform(0.5, 2.5)
    tilt, side = rng.uniform(-0.6, 0.6), rng.uniform(-0.5, 0.5)
    axis, across = turn[:, 0], turn[:, 0]
    direction = up + side * across
    shape = 1 + tilt * (2 * local[held, 0] / lengths[0] - 1)
    moved = np.zeros(nodes.size)
    for i, v in enumerate(held):
        moved[v * dim:(v + 1) * dim] = direction * shape[i] * pull
    response = np.zeros(nodes.size)
    response[fixed] = moved[fixed]
    response[free] = -inverse @ (k[np.ix_(free, fixed)] @ moved[fixed])
    b = g @ response
    names = "xyz"[:dim]
    place = " + ".join(f"{float(axis[i])!r}*{names[i]}" for i in range(dim))
    form = f"(1 + {tilt!r}*(2*({place})/{float(lengths[0])!r} - 1))"
    cases = ""
    for i, t in enumerate(TIMES):
        before, start = levels[i], ([0.0] + TIMES)[i]
        slope = (levels[i + 1] - before) / 0.2
        cases += f"\n  | {'t < ' + repr(t) if i < 4 else 'otherwise'} -> {float(before)!r} + {float(slope)!r}*(t - {start!r})"
    write_mesh(folder / f"m{number}.msh", nodes, cells, {"ground": ground_facets, "held": held_facets})
    probes = [int(v) for v in ground]
    columns = ", ".join(f"u{i}{names[a]} = u.{names[a]} at [{', '.join(repr(float(x)) for x in nodes[v])}]"
                        for i, v in enumerate(probes) for a in range(dim))
    script = f"""param N = 5
mesh body = gmsh("m{number}.msh")
part held = body.group("held")
part ground = body.group("ground")
tensor B = isotropic(lambda = {float(lam)!r}, mu = {float(mu)!r})
superpotential glue(r) with slope
{law_text(breaks, pieces)}
fn level(t) ={cases}
space V = vector P1 on body, zero on held
find u in V with u = [{', '.join(f'{float(direction[i] * pull)!r}*level(t)*{form}' for i in range(dim))}] on held for t in [0, 1] by N steps
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(ground, glue^0(-u.nu; -v.nu)) >= 0
report
  table {columns}
"""
    (folder / f"s{number}.hvi").write_text(script)
    curve = Curve(c, w, np.array(breaks), pieces)
    expected = []
    for i, t in enumerate(TIMES):
        if curve.go(b * levels[i + 1], ([0.0] + TIMES)[i], t) is None:
            break
        expected.append((t, curve.z()))
    return folder / f"s{number}.hvi", dim, up, len(probes), expected, curve.ends, reach


def run(hvi, script, steps):
    out = script.with_suffix(f".{steps}.json")
    done = subprocess.run([hvi, "run", str(script), "-D", f"N={steps}", "--json", str(out), "--no-files"],
                          capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        return None, done.stderr.strip().splitlines()[:1]
    return json.loads(out.read_text()), None


def heights(data, t, dim, up, count):
    times = np.array(data["table"]["t"])
    row = int(np.argmin(np.abs(times - t)))
    assert abs(times[row] - t) < 1e-9
    return np.array([sum(up[a] * data["table"][f"u{i}{'xyz'[a]}"][row] for a in range(dim)) for i in range(count)])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("hvi")
    parser.add_argument("--scenes", type=int, default=24)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--most", type=int, default=100)
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--only", type=int)
    options = parser.parse_args()
    certified = wrong = refused = ended = compared = 0
    with tempfile.TemporaryDirectory() as name:
        folder = options.keep or pathlib.Path(name)
        folder.mkdir(exist_ok=True)
        for number in range(options.scenes):
            if options.only is not None and number != options.only:
                continue
            rng = np.random.default_rng([options.seed, number])
            script, dim, up, count, expected, ends, reach = scene(rng, folder, number)
            ended += len(ends) > 0
            bad = None
            for steps in [s for s in (5, 20, 100, 1000) if s <= options.most]:
                data, said = run(options.hvi, script, steps)
                if data is None:
                    if len(expected) == len(TIMES):
                        refused += 1
                        bad = f"N = {steps} refused: {said}"
                        break
                    continue
                certified += 1
                for t, z in expected:
                    if any(abs(t - e) < 1e-6 for e in ends):
                        continue
                    compared += 1
                    off = np.abs(heights(data, t, dim, up, count) - z).max() / np.abs(z).max()
                    if not off <= 1e-6:
                        wrong += 1
                        bad = f"N = {steps}, t = {t}: off by {off:.1e}; ends {ends[:4]}"
                        break
                if bad:
                    break
            if bad:
                print(f"scene {number} ({dim}D, {count} points): {bad}", flush=True)
    print(f"{ended} scenes in which branches end, {compared} states compared")
    print(f"family branches: scenes {options.scenes}, certified {certified}, wrong {wrong}, refused {refused}")
    return 1 if wrong or refused or not compared else 0


if __name__ == "__main__":
    sys.exit(main())
