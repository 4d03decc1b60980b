"""Laws on u, on u' and on memories together, on random scenes: the answers of brute force at every step.

usage: rates.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

Each scene is a viscoelastic block in 2D or 3D, P1 or P2, some with memory, turned and scaled, with one to three laws on
its ground (each rule), at least one of them on the rate or on a memory, whose steps are strictly convex. Loads come and go, and what
holds the block may move. Grids are even, uneven or graded, schemes backward Euler and BDF2. A step is solved again by a
dense brute force (brute.py) with derivatives and memories of its own; where that does not settle, its last check is made of the answer.
"""
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import orientation
from brute import Friction, Step, Unilateral, ratio
from orientation import CONVEX, TOLERANCE, Term, number
from solids import turning

TURNS = 60  # of brute force: where many points stick, multipliers are not unique, and it may not find any
WITHOUT_REFERENCE = 0.1
AGREES = 1e-8  # of displacements, at most


class RateTerm(Term):
    """A law on u, on u' or on int q u."""

    def __init__(self, *of_term, sees):
        super().__init__(*of_term)
        self.sees = sees

    def form(self):
        return super().form().replace("^0(u", "^0(" + {"u": "u", "rate": "u'", "memory": "history(Own, u)"}[self.sees])


class Scene(orientation.Scene):
    term_type = RateTerm
    answers = None  # of the program, where brute force does not settle by itself: does it hold there?

    def __init__(self, random):
        self.random = random
        self.grid = self.choose_grid()
        self.bdf2 = random.random() < 0.4
        self.memory = (random.uniform(-0.5, 0.5), 10 ** random.uniform(-1, 1)) if random.random() < 0.4 else None
        self.moves = random.normal(size=3) * 10 ** random.uniform(-2, 0) if random.random() < 0.4 else None
        self.wave = random.uniform(1, 12)
        self.own = random.uniform(0.2, 3), 10 ** random.uniform(-1, 1)  # the kernel that laws see
        super().__init__(random)

    def choose_grid(self):
        random = self.random
        steps = int(random.integers(2, 7))
        kind = random.choice(["even", "uneven", "graded"])
        if kind == "even":
            self.times = f"in [0, 1] by {steps} steps"
            return np.linspace(0, 1, steps + 1)
        if kind == "graded":
            self.times = f"in [0, 1] at graded({steps}, 2)"
            return np.linspace(0, 1, steps + 1) ** 2
        inner = np.sort(random.uniform(0.05, 0.95, steps - 1))
        grid = np.array([0, *inner, 1])
        self.times = "in [0, 1] at [" + ", ".join(map(number, grid)) + "]"
        return grid

    def rate(self, n):
        """(s, carry): u'(t_n) = s d_n - carry d_{n-1}."""
        k = self.grid[n] - self.grid[n - 1]
        w = k / (self.grid[n - 1] - self.grid[n - 2]) if n > 1 else math.inf
        if not self.bdf2 or w > 100:
            return 1 / k, 0.0
        return (1 + 2 * w) / ((1 + w) * k), w * w / ((1 + w) * k)

    def history(self, n, kernel):
        """Weights of u_0 .. u_n in int_0^t_n a/tau exp(-(t_n - s)/tau) u(s) ds: constant or linear between grid times."""
        out = np.zeros(n + 1)
        a, tau = kernel
        x, w = np.polynomial.legendre.leggauss(24)
        for j in range(1, n + 1):
            low, high = self.grid[j - 1], self.grid[j]
            for p, weight in zip((1 + x) / 2, w / 2):
                q = a / tau * math.exp(-(self.grid[n] - low - p * (high - low)) / tau) * weight * (high - low)
                out[j] += q * (p if self.bdf2 else 1.0)
                out[j - 1] += q * (1 - p if self.bdf2 else 0.0)
        return out

    def assemble(self):
        random, solid = self.random, self.solid
        part = 10 ** random.uniform(-2, 0)
        self.viscous = tuple(v * part * (1 if random.random() < 0.5 else random.uniform(0.5, 2)) for v in self.elastic)
        self.clamped_dofs = solid.dofs(solid.on(self.clamped))
        self.free = np.setdiff1d(np.arange(solid.n), self.clamped_dofs)
        self.all_a, self.all_b = solid.stiffness(*self.viscous), solid.stiffness(*self.elastic)
        self.all_q = self.all_b  # of the memory
        self.k = self.matrix(1)
        self.inverse = np.linalg.inv(self.k)

    def matrix(self, n):
        k = self.rate(n)[0] * self.all_a + self.all_b
        if self.memory:
            k = k + self.history(n, self.memory)[n] * self.all_q
        return k[np.ix_(self.free, self.free)]

    def load_at(self, t):
        return math.sin(self.wave * t)

    def held_at(self, t):
        """The displacement of what is held."""
        moves = np.zeros(self.dim) if self.moves is None else self.reach * self.moves[:self.dim]
        return np.tile(moves * t * (1.3 - t), len(self.clamped_dofs) // self.dim)

    def choose_laws(self):
        random = self.random
        free = np.linalg.solve(self.all_b[np.ix_(self.free, self.free)], self.load)
        self.reach = float(np.abs(free).max()) or 1.0
        area = sum(self.solid.facet(f)[0] for f in self.mesh.facets["bottom"])
        self.pressure = float(np.abs(self.load).sum()) / area
        self.terms = []
        for name in ("first", "second", "third")[:1 + int(random.integers(3))]:
            draw = random.random()
            sees = "memory" if draw < 0.25 else "rate" if draw < 0.6 or not self.terms else "u"
            reach, self.reach = self.reach, self.reach * (self.wave if sees == "rate" else 1.0)  # of what the law sees
            rubs = any(isinstance(t.law, Friction) for t in self.terms)  # two leave brute force no end of multipliers
            if rubs or random.random() < 0.5:
                law, arguments = self.normal_law(), [".nu"]
            else:
                law, arguments = self.friction_law(), [".tau", ".tau", ""]
            while isinstance(law, Unilateral) and self.moves is not None and self.clamped == "left":
                law = self.normal_law()  # a corner of the ground may be moved through the obstacle
            self.reach = reach
            rule = str(random.choice(["nodal", "midpoint", "gauss"]))
            self.terms.append(self.term_type(name, "bottom", str(random.choice(arguments)), rule, law, sees=sees))
        for _ in range(80):
            if self.ratio() <= CONVEX:
                return
            self.soften(0.5)
        raise AssertionError("no convex step")

    def law_points(self, n=1, known=None):
        """Of step n. `known`: u_n where it is given, 0 elsewhere; u_0 .. u_{n-1}; of u'(t_n) what these say."""
        out = []
        own = self.history(n, self.own)
        factors = {"u": 1.0, "rate": self.rate(n)[0], "memory": own[n]}
        for term in self.terms:
            s = factors[term.sees]
            for p in term.points(self.solid):
                if known is not None:
                    held, states, known_rate = known
                    if term.sees == "rate":
                        p.offset = p.rows @ (s * (held - states[-1]) + known_rate)
                    else:
                        p.offset = p.rows @ (s * held)
                    if term.sees == "memory":
                        p.offset = p.offset + p.rows @ sum(w * u for w, u in zip(own, states))
                p.rows, p.weight = s * p.rows, p.weight / s
                p.rows = p.rows[:, self.free]
                out.append(p)
        return out

    def ratio(self):
        return max(ratio(np.linalg.inv(self.matrix(n)), self.law_points(n)) for n in range(1, len(self.grid)))

    def reference(self):
        """u after every step at the nodes, or None where brute force gives up."""
        states, before = [np.zeros(self.solid.n)], np.zeros(self.solid.n)
        for n in range(1, len(self.grid)):
            new = self.step(n, states, before)
            if new is None:
                return None
            before = new - states[-1]
            states.append(new)
        return [u.reshape(-1, self.dim) for u in states[1:]]

    def step(self, n, states, before):
        """u_n on all unknowns from u_0 .. u_{n-1} and the last increment, or None."""
        known = self.known(n, states, before)
        return self.solve(n, known, states, self.law_points(n, known))

    def known(self, n, states, before):
        """u_n where it is held, 0 elsewhere; u_0 .. u_{n-1}; of u'(t_n) what the last increment says."""
        held = np.zeros(self.solid.n)
        held[self.clamped_dofs] = self.held_at(self.grid[n])
        return held, states, -self.rate(n)[1] * before

    def solve(self, n, known, states, points):
        """u_n on all unknowns, with these points of laws, or None."""
        held, _, known_rate = known
        right = -self.all_a @ (self.rate(n)[0] * (held - states[-1]) + known_rate) - self.all_b @ held
        if self.memory:
            weights = self.history(n, self.memory)
            right -= self.all_q @ (sum(w * u for w, u in zip(weights, states)) + weights[n] * held)
        step, f = Step(self.matrix(n), points), self.load * self.load_at(self.grid[n]) + right[self.free]
        u = step.solve(f, TURNS)
        if u is None and self.answers is not None and len(self.answers) >= n:
            answer = self.answers[n - 1].ravel()[self.free]
            u = answer if step.accepts(f, answer) else None
        if u is None:
            return None
        new = held.copy()
        new[self.free] = u
        return new

    def script(self, turn, scale):
        text = super().script(turn, scale)
        begin, end = text.index("find u"), text.index(" such that")
        values = ""
        if self.moves is not None:
            total = turn @ (self.reach * scale * self.moves[:self.dim])
            values = " with u = [" + ", ".join(f"{number(v)}*t*(1.3 - t)" for v in total) + f"] on {self.clamped}"
        scheme = " using scheme = bdf2" if self.bdf2 else ""
        text = text[:begin] + f"find u in V{values} for t {self.times} from u = 0{scheme}" + text[end:]
        text = text.replace(", t * dot(", f", sin({number(self.wave)}*t) * dot(")
        if self.memory:
            a, tau = self.memory
            text = text.replace("space V", f"kernel Q(lag) = {number(a / tau)}*exp(-lag/{number(tau)})*B\nspace V")
            text = text.replace("(body, B : eps(u) : eps(v))",
                                "(body, B : eps(u) : eps(v))\n  + integral(body, history(Q, eps(u)) : eps(v))")
        if any(t.sees == "memory" for t in self.terms):
            a, tau = self.own
            text = text.replace("space V", f"kernel Own(lag) = {number(a / tau)}*exp(-lag/{number(tau)})\nspace V")
        return text

    def bound(self):
        """Of displacements: certified residuals reach them through the matrix; softening and earlier steps add to that. Of laws that
        soften faster than the body is stiff, of which brute force finds a solution all the same, nothing less is known."""
        if self.ratio() >= 1:
            return AGREES
        steps = range(1, len(self.grid))
        of_matrices = sum(np.linalg.cond(self.matrix(n)) for n in steps)
        return min(AGREES, 10 * TOLERANCE * of_matrices / (1 - self.ratio()))

    def size(self):
        """What errors are compared with, where the answer is smaller."""
        return self.reach

    def options(self, k):
        """Of the program, for the k-th scene."""
        return ["--full"] if k % 3 == 0 else []

    def error_besides(self, folder, scale):
        """The largest error of what else the run in a folder has told, compared with AGREES."""
        return 0.0

    def nodes_in(self, grid, turn, scale, solid):
        return nodes_in(self, grid, turn, scale, solid)

    def told_besides(self, folder, turn, scale):
        """What `is_solution` needs besides u, or None where a scene has one solution."""
        return None

    def told(self):
        laws = [(t.name, t.sees, t.argument, t.rule, type(t.law).__name__) for t in self.terms]
        return (f"{self.dim}D P{self.order}, {'BDF2' if self.bdf2 else 'Euler'} {self.times}"
                f"{', memory' if self.memory else ''}{', moved' if self.moves is not None else ''}, {laws}")


def written(folder):
    """What a run wrote after every step."""
    import meshio

    return [meshio.read(file) for file in sorted((folder / "out").glob("scene_[0-9]*.vtu"))]


def nodes_in(scene, grid, turn, scale, solid):
    """Of each node of a solid: which one it is of a file."""
    at = grid.points[:, :scene.dim] @ turn / scale
    return [int(np.argmin(((at - x) ** 2).sum(1))) for x in solid.points]


def displacements(folder, scene, turn, scale):
    """u at the reference's nodes after every step."""
    return [(grid.point_data["u"][:, :scene.dim] @ turn / scale)[scene.nodes_in(grid, turn, scale, scene.solid)]
            for grid in written(folder)]


def run(program, folder, scene, turn, scale, options):
    """u at the reference's nodes after every step, or what was said instead."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "body.msh").write_text(scene.mesh.moved(turn, scale, 0.0).msh())
    (folder / "scene.hvi").write_text(scene.script(turn, scale))
    done = subprocess.run([program, "run", "scene.hvi", "--quiet", "-o", "out", *options], cwd=folder,
                          capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        return None, f"exit {done.returncode}: " + " ".join(done.stderr.split())[:300]
    return displacements(folder, scene, turn, scale), ""


def judge(name, make_scene, without_reference=WITHOUT_REFERENCE, turning=turning, run=run):
    """The scenes of a family, whose answers are those of their references; the program's exit code."""
    options = orientation.asked_for()
    certified = wrong = refused = skipped = others = alone = 0
    worst = largest = most_besides = 0.0
    asked = range(options.scenes) if options.only is None else options.only
    for k in asked:
        random = np.random.default_rng([options.seed, k])
        scene = make_scene(random)
        turn, scale = turning(random, scene.dim), 10 ** random.uniform(-6, 6)
        expected = scene.reference()
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.keep or pathlib.Path(temporary)) / str(k)
            u, said = run(options.program, folder, scene, turn, scale, scene.options(k))
            if expected is None and u is not None and hasattr(scene, "answers"):
                scene.answers = u
                expected = scene.reference()
            told = scene.told_besides(folder, turn, scale) if u is not None else None
            if expected is None and told is not None and scene.is_solution(u, told, scene.bound()):
                certified, alone = certified + 1, alone + 1
                continue
            if expected is None:
                skipped += 1
                print(f"scene {k}: without a reference ({scene.told()}){': ' + said if said else ''}", file=sys.stderr)
                continue
            besides = scene.error_besides(folder, scale) if u is not None else 0.0
        if u is None or len(u) != len(expected):
            refused += 1
            print(f"scene {k}: refused ({scene.told()}): {said}", file=sys.stderr)
            continue
        certified += 1
        bound = scene.bound()
        size = max(scene.size(), max(float(np.abs(e).max()) for e in expected))
        error = max(float(np.abs(a - b).max()) for a, b in zip(u, expected)) / size
        apart = error > bound or not besides <= AGREES
        if apart and told is not None and scene.is_solution(u, told, bound):
            others += 1
            print(f"scene {k}: another solution than that of brute force ({scene.told()})", file=sys.stderr)
            continue
        worst, largest, most_besides = max(worst, error / bound), max(largest, error), max(most_besides, besides)
        if apart:
            wrong += 1
            print(f"scene {k}: off by {error:.2e}, bound {bound:.2e}, besides by {besides:.2e} ({scene.told()})", file=sys.stderr)
    print(f"largest error {largest:.1e}, worst by its bound {worst:.2e}, besides {most_besides:.1e}, without reference {skipped}, "
          f"other solutions {others}, found by the program alone {alone}")
    print(f"family {name}: scenes {len(asked)}, certified {certified}, wrong {wrong}, refused {refused}")
    return 0 if wrong == refused == 0 and skipped <= without_reference * len(asked) else 1


if __name__ == "__main__":
    sys.exit(judge("rates", Scene))
