"""Parameters from noisy curves.

usage: fits.py SOURCE_FOLDER, with the package on PYTHONPATH"""
import pathlib
import sys
import unittest
import warnings

import numpy as np

import hvi

EXAMPLES = pathlib.Path(sys.argv[1]).resolve() / "examples"
# The slab with the peak of its law and the time of its memory as parameters.
TEXT = ((EXAMPLES / "slab.hvi").read_text().split("expect")[0]
        .replace("mesh slab", "param stiffness = 100\nparam relaxation = 0.5\n\nmesh slab", 1)
        .replace("exp(-lag/0.5)", "exp(-lag/relaxation)").replace("100*r", "stiffness*r").replace("2 - 15*(r", "0.02*stiffness - 15*(r"))
TRUE = {"stiffness": 100.0, "relaxation": 0.5}


def curves(noise, seed):
    """Two columns at the rows of a run, with noise that is a part of their largest values."""
    result, draw = MODEL.run(), np.random.default_rng(seed)
    out = {}
    for column in ("u_x", "reaction"):
        y = result[column]
        out[column] = (result["t"], y + noise * np.abs(y).max() * draw.standard_normal(len(y)))
    return out


MODEL = hvi.loads(TEXT, n=4, N=32)


class Fits(unittest.TestCase):
    def test_exact_curves_give_the_parameters(self):
        found = MODEL.fit({"stiffness": 60, "relaxation": 1.2}, curves(0.0, 1))
        for name, value in TRUE.items():
            self.assertAlmostEqual(found.values[name] / value, 1.0, places=6)

    def test_exact_curves_leave_nothing_and_say_nothing(self):
        result = MODEL.run()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = MODEL.fit({"stiffness": 100}, {"u_x": (result["t"], result["u_x"])})
        low, high = found.intervals["stiffness"]
        self.assertAlmostEqual(low, 100, places=6)
        self.assertAlmostEqual(high, 100, places=6)

    def test_curves_that_begin_at_the_initial_time(self):
        """A measured curve begins at 0. The table has a row there by `from start`; a reaction has no value in it."""
        early = {"u_x": ([0, 0.5, 1], [0, 0.02, 0.05])}
        with self.assertRaisesRegex(ValueError, "data from 0 to 1.*from start"):
            MODEL.fit({"stiffness": 60}, early)
        text = TEXT.replace("integral(ground, layer.xi)", "integral(ground, layer.xi) from start")
        model = hvi.loads(text, n=4, N=32)
        result = model.run()
        self.assertEqual(result["t"][0], 0)
        self.assertTrue(np.isnan(result["reaction"][0]), "else this tests nothing")
        self.assertAlmostEqual(model.fit({"stiffness": 60}, {"u_x": (result["t"], result["u_x"])}).values["stiffness"], 100, places=5)
        known = (result["t"][1:], result["reaction"][1:])
        self.assertAlmostEqual(model.fit({"stiffness": 60}, {"reaction": known}).values["stiffness"], 100, places=5)
        with self.assertRaisesRegex(ValueError, r"times from 0\.03125 to 1, the data from 0 to 1$"):
            model.fit({"stiffness": 60}, {"reaction": ([0, 0.5, 1], [0, 1, 2])})

    def test_a_far_guess(self):
        found = MODEL.fit({"stiffness": 5, "relaxation": 6}, curves(0.0, 1))
        for name, value in TRUE.items():
            self.assertAlmostEqual(found.values[name] / value, 1.0, places=6)
        found = MODEL.fit({"stiffness": (2000, 1, 1e4), "relaxation": (0.02, 0.01, 10)}, curves(0.01, 1))
        for name, value in TRUE.items():
            low, high = found.intervals[name]
            self.assertTrue(low < value < high, f"{name}: {found}")

    def test_a_run_that_fails_is_a_shorter_step(self):
        """`less` takes so much from the elasticity that a step of the search leaves what has a solution: mu = 27 - less."""
        text = TEXT.replace("isotropic(young = 70, poisson = 0.3)", "isotropic(lambda = 40, mu = 27 - less)").replace(
            "param stiffness", "param less = 26.5\nparam stiffness", 1)
        model, failed = hvi.loads(text, n=2, N=8), []
        original = hvi.Model._run

        def run(self, params, **more):
            try:
                return original(self, params, **more)
            except hvi.Error as error:
                failed.append((params["less"], error.code))
                raise
        made = model.run()
        hvi.Model._run = run
        try:
            found = model.fit({"less": 15}, {"u_x": (made["t"], made["u_x"])})
        finally:
            hvi.Model._run = original
        self.assertTrue(failed and all(less > 27 for less, _ in failed), failed)
        self.assertAlmostEqual(found.values["less"], 26.5, places=6)
        with self.assertRaises(hvi.Error):  # the first guess
            model.fit({"less": 30}, {"u_x": (made["t"], made["u_x"])})

    def test_a_value_beyond_its_bound(self):
        found = MODEL.fit({"stiffness": (80, 50, 90), "relaxation": 0.6}, curves(0.005, 2))
        self.assertEqual(found.at_bounds, ("stiffness",))
        self.assertAlmostEqual(found.values["stiffness"], 90, places=3)
        self.assertTrue(np.isnan(found.stderr["stiffness"]) and found.stderr["relaxation"] > 0)
        self.assertIn("stiffness is at its bound", str(found))

    def test_the_range_of_the_script_is_a_bound(self):
        model = hvi.loads(TEXT.replace("param stiffness = 100", "param stiffness = 80 in [50, 90]"), n=4, N=32)
        self.assertEqual(model.params["stiffness"].limits, (50.0, 90.0))
        self.assertEqual(model.fit({"stiffness": 80}, curves(0.005, 2)).at_bounds, ("stiffness",))
        with self.assertRaisesRegex(ValueError, "not between 50 and 90"):
            model.fit({"stiffness": 95}, curves(0.005, 2))

    def test_a_parameter_that_changes_its_sign(self):
        """A load to the side, from the right to the left; and one whose guess is zero."""
        text = TEXT.replace("[3*t, 0]", "[push*t, 0]").replace("param stiffness", "param push = -3\nparam stiffness", 1)
        model = hvi.loads(text, n=4, N=16)
        made = model.run()
        for start in ((1, -10, 10), 0.0, -1):
            found = model.fit({"push": start}, {"u_x": (made["t"], made["u_x"])})
            self.assertAlmostEqual(found.values["push"], -3, places=6)
            low, high = found.intervals["push"]
            self.assertLessEqual(low, high)

    def test_a_curve_with_much_noise_weighs_little(self):
        """The noise of each column is found, so the good one decides, as if it had been told."""
        result, draw = MODEL.run(), np.random.default_rng(5)
        data, told = {}, {}
        for column, noise in (("u_x", 0.3), ("reaction", 0.002)):
            y, size = result[column], noise * np.abs(result[column]).max()
            data[column] = (result["t"], y + size * draw.standard_normal(len(y)))
            told[column] = (*data[column], size)
        found, known = (MODEL.fit({"stiffness": 90, "relaxation": 0.6}, d) for d in (data, told))
        for name in TRUE:
            self.assertLess(abs(found.values[name] - known.values[name]), 0.3 * known.stderr[name], name)
            self.assertAlmostEqual(found.stderr[name] / known.stderr[name], 1.0, delta=0.3)

    def test_noise_and_predictions(self):
        found = MODEL.fit({"stiffness": (90, 10, 1000), "relaxation": (0.6, 0.01, 10)}, curves(0.02, 3))
        largest = np.abs(MODEL.run()["reaction"]).max()
        self.assertLess(abs(found.noise["reaction"] / (0.02 * largest) - 1.0), 0.5)
        np.testing.assert_array_equal(found.predicted["reaction"], found.model.run()["reaction"])
        self.assertIn("95 % interval", str(found))
        self.assertLess(abs(found.correlation[0, 1]), 1.0)

    def test_runs_that_share_have_the_bits_of_others(self):
        """Parameters of laws and kernels, and one of the mesh."""
        from hvi import _hvi

        shared = _hvi.Shared()
        for params in ({"stiffness": 80}, {"relaxation": 1.0}, {"n": 3}, {"stiffness": 80, "n": 3}, {}):
            mine, own = MODEL._run(params, shared=shared), MODEL.run(**params)
            for column in own.table:
                np.testing.assert_array_equal(mine[column], own[column], err_msg=f"{params} {column}")

    def test_what_is_not_determined_is_said(self):
        text = TEXT.replace("param stiffness = 100", "param stiffness = 100\nparam more = 1").replace("stiffness*r", "stiffness*more*r").replace(
            "0.02*stiffness -", "0.02*stiffness*more -")
        with self.assertRaisesRegex(ValueError, "do not determine"):
            hvi.loads(text, n=4, N=16).fit({"stiffness": 90, "more": 1.1}, curves_of(text))

    def test_wrong_questions(self):
        t = np.array([0.5, 1.0])
        for params, data, said in (({"strength": 1}, {"u_x": (t, t)}, "no parameter"), ({"stiffness": 1}, {"force": (t, t)}, "no column"),
                                   ({"stiffness": 1}, {"u_x": (t + 1, t)}, "times from"), ({"stiffness": (1, 2, 3)}, {"u_x": (t, t)}, "guess"),
                                   ({"stiffness": 1, "relaxation": 1}, {"u_x": (t, t)}, "do not determine"),
                                   ({"stiffness": 1}, {"u_x": (t, t[:1])}, "same length"), ({"stiffness": 1}, {"u_x": (t, t * np.nan)}, "number")):
            with self.assertRaisesRegex((KeyError, ValueError), said):
                MODEL.fit(params, data)
        with self.assertRaisesRegex(ValueError, "no parameters"):
            MODEL.fit({}, {"u_x": (t, t)})
        with self.assertRaisesRegex(ValueError, "no measured curves"):
            MODEL.fit({"stiffness": 1}, {})
        for wrong in (hvi.fit, lambda model, *_: hvi.sweep(model, n=[2])):
            with self.assertRaisesRegex(TypeError, "a model is loaded first"):
                wrong("slab.hvi", {"stiffness": 1}, {"u_x": (t, t)})


def curves_of(text):
    result = hvi.loads(text, n=4, N=16).run()
    return {"u_x": (result["t"], result["u_x"])}


sys.argv[1:] = sys.argv[2:]
unittest.main()
