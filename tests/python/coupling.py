"""Values of parameters that another program sets between two steps: a run has the steps of a script that says the same by functions
of t, and two models that answer each other those of one script of both.

usage: coupling.py SOURCE_FOLDER, with the package on PYTHONPATH"""
import math
import pathlib
import sys
import tempfile
import unittest

import numpy as np

import hvi

SOURCE = pathlib.Path(sys.argv[1]).resolve()
EXAMPLES = SOURCE / "examples"

#: A slab with memory that slides on a layer, and is pushed and pulled; words in <> differ between scripts.
SLAB = """
import friction
param n = 3
param N = 16
<params>
mesh slab   = rectangle(2, 1, cells = [2*n, n])
part roof   = slab.top
part flank  = slab.right
part ground = slab.bottom
tensor A      = isotropic(lambda = 5, mu = 10)
tensor B      = isotropic(young = 70, poisson = 0.3)
kernel C(lag) = -exp(-lag/0.5) * B
superpotential layer(r) with slope
  | r < 0     -> 0
  | r < 0.02  -> 100*r
  | otherwise -> 2
superpotential slip(xi) = <bound>*norm(xi)
space V = vector P1 on slab, zero on roof
find u in V<held> for t in [0, 1] by N steps from u = 0<using>
such that for all v in V
    integral(slab, A : eps(u') : eps(v))
  + integral(slab, <stiff>*B : eps(u) : eps(v))
  + integral(slab, <fading>*history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu) + slip^0(u.tau; v.tau))
 >= integral(slab, dot([0, -10*t], v))
  + integral(flank, dot([<push>, 0], v))
report
  table u_y = u.y at [1, 0], u_x = u.x at [2, 0], stress = <stiff>*sigma.xx at [1.9, 0.6]<strain>,
      reaction = integral(ground, layer.xi), shear = integral(ground, slip.xi.x)
"""
PLAIN = {"params": "", "bound": "0.3", "held": "", "using": "", "stiff": "1", "fading": "1", "push": "3", "strain": ""}
#: Functions of t, and the parameter that takes their place.
FUNCTIONS = {
    "push": ("3*t + 6*sin(9*t)", lambda t: 3 * t + 6 * math.sin(9 * t)),
    "bound": ("(0.5 - 0.4*t)", lambda t: 0.5 - 0.4 * t),
    "stiff": ("(1 + t)", lambda t: 1 + t),
    "fading": ("(1 - t/2)", lambda t: 1 - t / 2),
    "held": (" with u = [0.01*t, 0.02*t] on roof", lambda t: t),
}


def script(**words):
    text = SLAB
    for word, written in {**PLAIN, **words}.items():
        text = text.replace(f"<{word}>", written)
    return text


def coupled(words):
    """The script in which parameters stand for these functions."""
    out = {"params": "\n".join(f"param {name} = {value(0)}" for name, (_, value) in FUNCTIONS.items() if name in words)}
    for name in words:
        out[name] = " with u = [0.01*held, 0.02*held] on roof" if name == "held" else name
    return out


def stepped(steps, functions, of_t):
    """The columns of a run to which another program tells its values before each step."""
    times = of_t
    rows = []
    for t in times:
        steps.set(**{name: value(t) for name, value in functions.items()})
        rows.append(steps.advance())
    return {column: np.array([row[column] for row in rows]) for column in rows[0].values}


class AnotherProgram(unittest.TestCase):
    def compare(self, names, more=None, tolerance=1e-11, steps=16):
        more = more or {}
        whole = hvi.loads(script(**{**{name: FUNCTIONS[name][0] for name in names}, **more}), N=steps).run()
        run = hvi.loads(script(**{**coupled(names), **more}), N=steps).steps()
        mine = stepped(run, {name: FUNCTIONS[name][1] for name in names}, whole["t"])
        for column, values in mine.items():
            np.testing.assert_allclose(values, whole[column], rtol=tolerance, atol=tolerance * np.abs(whole[column]).max(), err_msg=column)
        result = run.result()
        self.assertTrue(result.certified)
        for column, values in mine.items():
            np.testing.assert_array_equal(result[column], values)
        return whole, result

    def test_loads(self):
        whole, mine = self.compare(["push"], {"strain": ", support = reaction(roof)"})
        self.assertEqual(mine.raw["plan"]["factorisations"], whole.raw["plan"]["factorisations"])  # matrices stay as they are

    def test_imposed_values(self):
        self.compare(["held"], {"bound": "0.01", "strain": ", support = reaction(roof)"})

    def test_bounds_of_laws(self):
        self.compare(["bound"])

    def test_coefficients_that_change_the_matrix(self):
        self.compare(["stiff"])

    def test_coefficients_of_memories(self):
        self.compare(["fading"])

    def test_all_at_once(self):
        self.compare(list(FUNCTIONS), {"strain": ", support = reaction(roof)"})

    def test_a_scheme_of_second_order(self):
        self.compare(["push", "bound"], {"using": " using scheme = bdf2"})

    def test_a_run_on_its_contact_unknowns(self):
        """Its states hold no more than these until a value is set; then its steps are taken once more, with the values they had."""
        plain = {"params": "param push = 0.5", "push": "push*t"}
        one = ("isotropic(lambda = 5, mu = 10)", "0.2*B")
        jump = "fn pull(t) =\n  | t < 0.52   -> 0.5\n  | otherwise -> 2"
        whole = hvi.loads(script(params=jump, push="pull(t)*t").replace(*one)).run()
        for early in (False, True):
            model = hvi.loads(script(**plain).replace(*one))
            self.assertIn("contact rows", model.run().certificate["mode"])
            steps = model.steps()
            if early:
                steps.set(push=0.5)
            rows = [steps.advance() for _ in range(8)]
            steps.set(push=2)
            self.assertEqual(steps.params["push"].value, 2)
            rows += list(steps)
            np.testing.assert_allclose([row["u_x"] for row in rows], whole["u_x"], rtol=1e-10)
            result = steps.result()
            self.assertTrue(result.certified)
            np.testing.assert_allclose(result["reaction"], whole["reaction"], rtol=1e-10)
            self.assertEqual(result.params["push"], 2)

    def test_states_keep_their_past(self):
        """A glue that debonds goes on from what is left of it, with another rate."""
        text = (EXAMPLES / "peel.hvi").read_text()
        call, fast = "debond(beta, u.nu, stiffness, 0.05, 0.05)", "debond(beta, u.nu, stiffness, 0.05, {})"
        self.assertIn(call, text)
        jump = "fn slowness(t) =\n  | t < 0.51   -> 0.05\n  | otherwise -> 0.2\n"
        whole = hvi.loads(jump + text.replace(call, fast.format("slowness(t)")), N=40).run()
        steps = hvi.loads("param slowness = 0.05\n" + text.replace(call, fast.format("slowness")), N=40).steps()
        rows = [steps.advance() for _ in range(20)]
        steps.set(slowness=0.2)
        rows += list(steps)
        for column in rows[0].values:
            np.testing.assert_allclose([row[column] for row in rows], whole[column], rtol=1e-9, atol=1e-12, err_msg=column)


BARS = """
param N = 8
<params>
mesh bar = interval(1, cells = 4)
part held = bar.left
part end  = bar.right
space V = scalar P1 on bar, zero on held
<spaces>
find <unknowns> for t in [0, 1] by N steps from <from>
such that for all <tests>
<forms>
report
  table <columns>
"""
#: Two bars side by side that creep, the ends joined by a spring of stiffness 4; the first is pulled by 3 t.
FIRST = "    integral(bar, 2*dot(grad(u'), grad(v)) + 5*dot(grad(u), grad(v))) + integral(end, 4*(u - {other})*v)"
SECOND = "    integral(bar, dot(grad(w'), grad(q)) + 3*dot(grad(w), grad(q))) + integral(end, 4*(w - {other})*q)"


def bars(**words):
    text = BARS
    for word, written in words.items():
        text = text.replace(f"<{word}>", written)
    return text


class TwoModels(unittest.TestCase):
    both = bars(params="", spaces="space W = scalar P1 on bar, zero on held", unknowns="u in V, w in W", **{"from": "u = 0, w = 0"},
                tests="v in V, q in W", columns="u_end = u at [1], w_end = w at [1]",
                forms=FIRST.format(other="w") + "\n  + " + SECOND.format(other="u").strip() + "\n >= integral(end, 3*t*v)")
    first = bars(params="param other = 0", spaces="", unknowns="u in V", **{"from": "u = 0"}, tests="v in V",
                 columns="u_end = u at [1]", forms=FIRST.format(other="other") + "\n >= integral(end, 3*t*v)")
    second = bars(params="param other = 0", spaces="", unknowns="w in V", **{"from": "w = 0"}, tests="q in V",
                  columns="w_end = w at [1]", forms=SECOND.format(other="other") + "\n >= 0")

    def staggered(self, n):
        """Each bar's step sees where the other one was last."""
        one, two = hvi.loads(self.first, N=n).steps(), hvi.loads(self.second, N=n).steps()
        w = 0.0
        rows = []
        for step in one:
            two.set(other=step["u_end"])
            w = two.advance()["w_end"]
            one.set(other=w) if step.number < n else None
            rows.append((step["u_end"], w))
        self.assertTrue(one.result().certified and two.result().certified)
        return np.array(rows)

    def test_two_models_that_answer_each_other(self):
        whole = hvi.loads(self.both, N=512).run()
        errors = []
        for n in (16, 32, 64):
            mine = self.staggered(n)
            exact = np.column_stack([whole["u_end"], whole["w_end"]])[512 // n - 1::512 // n]
            errors.append(np.abs(mine - exact).max())
        self.assertLess(errors[-1], 0.02)
        for coarse, fine in zip(errors, errors[1:]):
            self.assertAlmostEqual(coarse / fine, 2, delta=0.25)

    def test_the_same_splitting_in_numpy(self):
        """The two bars are two springs with dashpots: 1/2 and 1 at their ends, which any program can step."""
        n, k = 16, 1 / 16
        u = w = 0.0
        for (mine_u, mine_w), t in zip(self.staggered(n), np.arange(1, n + 1) * k):
            u = (3 * t + 2 * u / k + 4 * w) / (2 / k + 5 + 4)
            w = (w / k + 4 * u) / (1 / k + 3 + 4)
            np.testing.assert_allclose((mine_u, mine_w), (u, w), rtol=1e-12)


class Tables(unittest.TestCase):
    def test_a_field_by_a_table(self):
        """What a script reads is read again: the load along the flank at the points that another program has."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            text = script(push='table("push.csv", y)')

            def write(factor):
                rows = [f"{y},{factor * (1 + y * y)!r}" for y in (0, 0.25, 0.5, 1)]
                (folder / "push.csv").write_text("\n".join(rows) + "\n")

            write(1.0)
            steps = hvi.loads(text, folder=folder, N=4).steps()
            rows = [steps.advance() for _ in range(2)]
            write(3.0)
            rows.append(steps.advance())  # a file that has changed is none of the run's until it is told
            steps.set()
            rows.append(steps.advance())
            write(1.0)
            whole = hvi.loads(script(params="fn size(t) =\n  | t < 0.8 -> 1\n  | otherwise -> 3", push='size(t)*table("push.csv", y)'),
                              folder=folder, N=4).run()
            np.testing.assert_allclose([row["u_x"] for row in rows], whole["u_x"], rtol=1e-11)


class Refused(unittest.TestCase):
    def setUp(self):
        text = script(params="param push = 1 in [0, 10]  \"the pull\"\nparam bound = 0.3\nparam begin = 0\nparam fade = 0.5\nparam T = 1\n"
                             "param way = backward_euler", push="push", bound="bound", using=" using scheme = way")
        text = text.replace("from u = 0", "from u = [0, 0*begin]").replace("lag/0.5", "lag/fade").replace("[0, 1]", "[0, T]")
        self.model = hvi.loads(text, N=6)
        self.steps = self.model.steps()

    def refused(self, expected, kind=hvi.ScriptError, **params):
        with self.assertRaisesRegex(kind, expected):
            self.steps.set(**params)

    def test_a_refused_value_changes_nothing(self):
        whole = self.model.run()
        rows = [self.steps.advance() for _ in range(2)]
        self.refused("E0320.*no parameter `pusch`", pusch=2)
        self.refused("its parameters: n, N, push, bound, begin, fade, T, way", zzz=2)
        self.refused(r"E0408(.|\n)*outside", push=11)
        self.refused("push", push="much")
        self.refused("'push' is a number or a word", kind=TypeError, push=[1, 2])
        self.refused("mesh", n=4)
        self.refused("times of the steps", N=7)
        self.refused("times of the steps", T=2)
        self.refused("a kernel, with which the past", fade=0.6)
        self.refused("begun with", way="bdf2")
        self.refused("left out", bound=0)
        self.assertEqual(self.steps.params, self.model.params)
        rows += list(self.steps)
        np.testing.assert_array_equal([row["u_x"] for row in rows], whole["u_x"])
        self.refused("last step has been taken", push=2)
        self.assertTrue(self.steps.result().certified)
        self.refused("has ended", kind=ValueError, push=2)

    def test_a_step_that_has_no_certificate_with_the_new_value(self):
        """The side that is pressed down ends in a corner of the ground: once the gap is too small nothing holds it back."""
        text = script(params="param gap = 0.2\nimport contact", bound="0.01", held=" with u.y = -0.1*t on flank")
        text = text.replace("layer^0(u.nu; v.nu)", "layer^0(u.nu; v.nu) + unilateral^0(u.nu - gap; v.nu)").replace("zero on roof", "zero on roof, zero.y on flank")
        steps = hvi.loads(text.replace("roof   = slab.top", "roof   = slab.left"), N=4).steps()
        steps.advance()
        steps.set(gap=0.1)
        self.assertIsNotNone(steps.advance())
        steps.set(gap=0.06)
        with self.assertRaises(hvi.SolveError) as caught:
            steps.advance()
        self.assertEqual((caught.exception.code, caught.exception.partial.steps), ("E0701", 2))
        self.assertIn("t = 0.75", str(caught.exception))
        self.assertIsNone(steps.advance())

    def test_units(self):
        """Values are in the unit in which a parameter is declared, or have another one."""
        model = hvi.load(EXAMPLES / "units.hvi")
        for value in (0.05, "0.5[MPa]", "500 [kPa]"):
            steps = model.steps()
            steps.set(press=value)
            step = steps.advance()
            whole = model.run(press=0.05)
            for column, mine in step.values.items():
                self.assertAlmostEqual(mine / whole.final[column], 1, places=12)
        with self.assertRaisesRegex(hvi.ScriptError, "E0331"):
            model.steps().set(press="3 [mm]")



sys.argv[1:] = sys.argv[2:]
if __name__ == "__main__":
    unittest.main()
