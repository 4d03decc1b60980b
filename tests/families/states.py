"""Laws with states on random scenes: what the program certifies is replayed by brute force.

usage: states.py HVI_RUN [--scenes N] [--seed S] [--only K,K,..] [--keep FOLDER]

Each scene is one of rates.py: a viscoelastic block in 2D or 3D, P1 or P2, some with memory, turned and scaled, with laws
on u and u' on its ground whose steps are strictly convex for states held. One or two states live there (bonding, total
slip, age of a contact, wear, two that read each other) and weaken laws or move their arguments, with rates from slow to
settled within a step; bonds break. Schemes are backward Euler and BDF2 on any grid.

The states that the program tells at every point and step are put into the laws: brute force then must find the same
displacements at every step, and with these the states must satisfy their own equation, written here again. So any
certified answer is judged, whether or not it is the only one.
"""
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

import orientation
import rates
from brute import Friction, Law, Unilateral
from orientation import CONVEX, number
from rates import AGREES
from solids import turning

WITHOUT_REFERENCE = 0.15
REFUSED = 0.03
EPS = float(np.finfo(float).eps)


class State:
    """z' = rate(z, other, a), kept in [low, high]; by_z: its derivative. a: u.nu, |u'.tau|, multipliers, all by their sizes."""

    def __init__(self, name, kind, c, start, low, high):
        self.name, self.kind, self.c, self.start, self.low, self.high = name, kind, c, start, low, high

    def rate(self, z, other, a):
        return self.c * {"bond": lambda: -np.maximum(0, 5 * z * np.maximum(a["nu"], 0) ** 2 - 0.05) - 0.3 * z * a["slip"],
                         "slip": lambda: a["slip"],
                         "age": lambda: 1 - z * a["slip"],
                         "wear": lambda: np.abs(a["xi"]) * a["slip"],
                         "pair": lambda: other - z + a["nu"] ** 2,
                         "partner": lambda: a["slip"] - 2 * z + 0.5 * np.sin(other)}[self.kind]()

    def by_z(self, z, other, a):
        return self.c * {"bond": lambda: -np.where(5 * z * np.maximum(a["nu"], 0) ** 2 > 0.05, 5 * np.maximum(a["nu"], 0) ** 2, 0)
                                         - 0.3 * a["slip"],
                         "slip": lambda: 0 * z, "age": lambda: -a["slip"], "wear": lambda: 0 * z,
                         "pair": lambda: -1 + 0 * z, "partner": lambda: -2 + 0 * z}[self.kind]()

    def text(self, nu, slip, xi, other):
        body = {"bond": f"-max(0, 5*{self.name}*pos({nu})^2 - 0.05) - 0.3*{self.name}*{slip}", "slip": slip,
                "age": f"1 - {self.name}*{slip}", "wear": f"abs({xi})*{slip}", "pair": f"{other} - {self.name} + ({nu})^2",
                "partner": f"{slip} - 2*{self.name} + 0.5*sin({other})"}[self.kind]
        ends = "" if math.isinf(self.low) and math.isinf(self.high) else f" in [{number(max(self.low, -1e300))}, {number(min(self.high, 1e300))}]"
        return f"state {self.name} on bottom with rate {number(self.c)}*({body}) from {self.name} = {number(self.start)}{ends}"


WEAKENS = {"square": (lambda z: z ** 2, "{z}^2"), "falls": (lambda z: 0.5 + 0.5 * np.exp(-z), "(0.5 + 0.5*exp(-{z}))"),
           "fades": (lambda z: 1 / (1 + z), "(1/(1 + {z}))"), "": (lambda z: 1 + 0 * z, "1")}


def weakened(law, m):
    if isinstance(law, Unilateral):
        return law
    if isinstance(law, Friction):
        return Friction(m * law.static, m * law.sliding, law.decay)
    return Law(law.breaks, law.anchors, [m * s for s in law.starts], [m * g for g in law.growths])


class Scene(rates.Scene):
    def choose_laws(self):
        super().choose_laws()
        random = self.random
        # The sizes that rates read arguments by.
        self.force_size = self.pressure
        flat = len({tuple(np.round(n, 9)) for _, _, n in self.solid.law_points("bottom", "midpoint")}) == 1
        rule = str(random.choice(["nodal", "midpoint", "gauss"] if flat else ["midpoint", "gauss"]))
        for term in self.terms:
            term.rule = rule
            if term.sees == "memory":
                term.sees = "rate"
        for _ in range(80):
            if self.ratio() <= CONVEX:
                break
            self.soften(0.5)
        self.choose_states()

    def choose_states(self):
        random = self.random
        scalars = [t.name for t in self.terms if not t.law.radial]
        kinds = ["bond", "slip", "age", "pair"] + (["wear"] if scalars else [])
        kind = str(random.choice(kinds))
        c = 10 ** random.uniform(-1, 2.5 if kind in ("age", "pair", "bond") else 0.7)
        inf = math.inf
        ends = {"bond": (1.0, 0.0, 1.0), "slip": (0.0, -inf, inf), "age": (float(random.uniform(0.2, 2)), 0.0, inf),
                "wear": (0.0, -inf, 3.0), "pair": (0.5, 0.0, inf)}[kind]
        self.states = [State("beta", kind, c, *ends)]
        self.read_xi = scalars[0] if scalars else None
        if kind == "pair":
            self.states.append(State("w", "partner", 10 ** random.uniform(-1, 1), 0.2, 0.0, inf))
        for term in self.terms:
            term.weakens = str(random.choice(["square", "fades", "falls"] if kind == "bond" else ["falls", "fades", ""]))
            term.shift = 0.0
            if not term.law.radial and random.random() < 0.4:
                term.shift = self.reach * 10 ** random.uniform(-2, -0.3) * (self.wave if term.sees == "rate" else 1)

    def places(self):
        """Of the points of the ground, facet by facet."""
        at = self.solid.points.reshape(-1)
        return [values @ at for _, values, _ in self.solid.law_points("bottom", self.terms[0].rule)]

    def with_states(self, points, z):
        """The points of all laws with these values of the first state."""
        n = len(z)
        for k, p in enumerate(points):
            term, value = self.terms[k // n], z[k % n]
            p.law = weakened(p.law, WEAKENS[term.weakens][0](value))
            p.offset = p.offset - term.shift * value
        return points

    def replay(self, told):
        """u after every step from brute force with the states of the program, or None."""
        self.replayed = told["beta"]
        return self.reference()

    def step(self, n, states, before):
        known = self.known(n, states, before)
        return self.solve(n, known, states, self.with_states(self.law_points(n, known), self.replayed[n]))

    def differences(self, n):
        """(s, carry) of z' in step n."""
        return self.rate(n)

    def speed(self, n, us):
        """u' in step n."""
        s, carry = self.rate(n)
        return s * (us[n] - us[n - 1]) - (carry * (us[n - 1] - us[n - 2]) if n > 1 else 0.0)

    def errors_of_states(self, us, told):
        """The largest error of a state's equation, by how much of its size the state would have to change."""
        worst = 0.0
        points = self.solid.law_points("bottom", self.terms[0].rule)
        names = [s.name for s in self.states]
        for n in range(1, len(self.grid)):
            s, carry = self.differences(n)
            rate = self.speed(n, us)
            nu = np.array([normal @ values @ us[n] for _, values, normal in points])
            v = [values @ rate for _, values, _ in points]
            slip = np.array([np.linalg.norm(x - (normal @ x) * normal) for x, (_, _, normal) in zip(v, points)])
            a = {"nu": nu / self.reach, "slip": slip / (self.reach * self.wave), "xi": told["xi"][n] / self.force_size}
            # Points that stick under large multipliers: a slip of the size of what u is known to wears them here.
            sizes = [np.abs(u).max() for u in us]
            rounding = s * max(4 * EPS * max(sizes[:n + 1]), self.known_to * max(sizes))
            rounded = {**a, "slip": a["slip"] + rounding / (self.reach * self.wave)}
            for i, state in enumerate(self.states):
                z, other = told[state.name][n], told[names[1 - i]][n] if len(names) > 1 else None
                last = told[state.name][n - 1]
                older = told[state.name][n - 2] if n > 1 else last
                moved = last + carry / s * (last - older) + state.rate(z, other, a) / s
                left = np.abs(z - np.clip(moved, state.low, state.high))
                left = np.maximum(0, left - np.abs(state.rate(z, other, rounded) - state.rate(z, other, a)) / s)
                left /= np.maximum(1, np.abs(state.by_z(z, other, a)) / s)
                size = max(np.abs(z).max(), np.abs(last).max(), 1e-3 * state.c / s)  # where a body sticks: rounding
                if left.max() > 0:
                    worst = max(worst, float(left.max()) / size)
        return worst

    def script(self, turn, scale):
        text = super().script(turn, scale)
        nu = f"u.nu/{number(self.reach * scale)}"
        slip = f"norm(u'.tau)/{number(self.reach * self.wave * scale)}"
        xi = f"{self.read_xi}.xi/{number(self.force_size)}"
        lines = [s.text(nu, slip, xi, self.states[1 - i].name if len(self.states) > 1 else "") for i, s in enumerate(self.states)]
        for term in self.terms:
            name = term.name
            text = text.replace(f"superpotential {name}(", f"superpotential {name}_plain(")
            argument = "xi" if term.law.radial else "r"
            factor = WEAKENS["" if isinstance(term.law, Unilateral) else term.weakens][1].format(z="beta")
            lines.append(f"superpotential {name}({argument}) = {factor}*{name}_plain({argument})")
            if term.shift:
                form = term.form()
                shifted = form.replace("; v", f" - {number(term.shift * scale)}*beta; v")
                text = text.replace(form, shifted)
        text = text.replace("space V", "\n".join(lines) + "\nspace V")
        columns = []
        for k, x in enumerate(self.places()):
            at = "[" + ", ".join(number(v) for v in turn @ x * scale) + "]"
            columns += [f"{s.name}{k} = {s.name} at {at}" for s in self.states]
            if self.read_xi:
                columns.append(f"xi{k} = {self.read_xi}.xi at {at}")
        return text.replace("  fields u", "  table " + ", ".join(columns) + "\n  fields u")

    def told_states(self, columns):
        """By name: the values at all points after every step, those of step 0 first."""
        n = len(self.places())
        out = {}
        for s in self.states:
            values = np.array([columns[f"{s.name}{k}"] for k in range(n)]).T
            out[s.name] = np.vstack([np.full(n, s.start), values])
        xi = np.array([columns[f"xi{k}"] for k in range(n)]).T if self.read_xi else np.zeros_like(out["beta"][1:])
        out["xi"] = np.vstack([np.zeros(n), xi])
        return out

    def told(self):
        return (f"{super().told()}, states {[(s.name, s.kind, round(s.c, 3)) for s in self.states]}, "
                f"{[(t.weakens, t.shift > 0) for t in self.terms]}")


def judge(name, make_scene):
    options = orientation.asked_for()
    certified = wrong = refused = skipped = 0
    largest = worst_state = 0.0
    asked = range(options.scenes) if options.only is None else options.only
    for k in asked:
        random = np.random.default_rng([options.seed, k])
        scene = make_scene(random)
        turn, scale = turning(random, scene.dim), 10 ** random.uniform(-6, 6)
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.keep or pathlib.Path(temporary)) / str(k)
            more = ["--full"] if k % 3 == 0 else []
            u, said = rates.run(options.program, folder, scene, turn, scale, [*more, "--json", "out.json"])
            result = json.loads((folder / "out.json").read_text()) if u is not None else None
        if u is None:
            refused += 1
            print(f"scene {k}: refused ({scene.told()}): {said}", file=sys.stderr)
            continue
        told = scene.told_states(result["table"])
        scene.known_to = result["forward_error"]["solution"]  # of the largest u
        expected = scene.replay(told)
        if expected is None:
            skipped += 1
            continue
        certified += 1
        bound = scene.bound()
        size = max(scene.size(), max(float(np.abs(e).max()) for e in expected))
        error = max(float(np.abs(a - e).max()) for a, e in zip(u, expected)) / size
        own = [np.zeros(scene.solid.n)] + [a.reshape(-1) for a in u]
        of_states = scene.errors_of_states(own, told)
        largest, worst_state = max(largest, error), max(worst_state, of_states)
        if error > bound or of_states > AGREES:
            wrong += 1
            print(f"scene {k}: u off by {error:.2e}, bound {bound:.2e}, states by {of_states:.2e} ({scene.told()})",
                  file=sys.stderr)
    print(f"largest error of u {largest:.1e}, of states {worst_state:.1e}, without reference {skipped}")
    print(f"family {name}: scenes {len(asked)}, certified {certified}, wrong {wrong}, refused {refused}")
    good = wrong == 0 and refused <= REFUSED * len(asked) and skipped <= WITHOUT_REFERENCE * len(asked)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(judge("states", Scene))
