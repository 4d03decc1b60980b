"""Runs that are taken step by step.

usage: steps.py SOURCE_FOLDER, with the package on PYTHONPATH"""
import pathlib
import sys
import unittest

import numpy as np

import hvi

SOURCE = pathlib.Path(sys.argv[1]).resolve()
EXAMPLES = SOURCE / "examples"


class Steps(unittest.TestCase):
    def test_steps_are_those_of_a_run(self):
        for name, params in (("slab", {"n": 4, "N": 16}), ("slab_friction", {"n": 4, "N": 8}), ("peel", {"N": 10}), ("bounce", {}),
                             ("blocks", {})):
            with self.subTest(name):
                model = hvi.load(EXAMPLES / f"{name}.hvi", **params)
                whole = model.run()
                steps = model.steps()
                taken = list(steps)
                self.assertEqual(len(taken), len(steps))
                for column in model.columns:
                    mine = np.array([step[column] for step in taken])
                    rows = np.searchsorted([step.t for step in taken], whole["t"] - 1e-12)
                    np.testing.assert_array_equal(mine[rows], whole[column], err_msg=column)
                for unknown, values in taken[-1].fields.items():
                    np.testing.assert_array_equal(values, whole.fields[unknown])
                result = steps.result()
                self.assertTrue(result.certified)
                self.assertEqual(result.certificate["inclusion"], whole.certificate["inclusion"])
                self.assertIsNone(steps.advance())

    def test_two_runs_side_by_side(self):
        """A coupling: each looks at the other's last step, and neither disturbs it."""
        soft, stiff = (hvi.load(EXAMPLES / "slab.hvi", n=4, N=8).at(n=k) for k in (3, 4))
        pairs = list(zip(soft.steps(), stiff.steps()))
        self.assertEqual(len(pairs), 8)
        for side, model in enumerate((soft, stiff)):
            np.testing.assert_array_equal([pair[side]["reaction"] for pair in pairs], model.run()["reaction"])

    def test_a_loop_that_is_left_goes_on(self):
        steps = hvi.load(EXAMPLES / "slab.hvi", n=3, N=8).steps()
        for step in steps:
            if step.number == 3:
                break
        self.assertEqual(next(steps).number, 4)
        self.assertTrue("reaction" in step and "reakction" not in step)
        early = steps.result()
        self.assertFalse(early.certified)
        self.assertEqual(early.steps, 4)
        whole = hvi.load(EXAMPLES / "slab.hvi", n=3, N=8).run()
        np.testing.assert_array_equal(early["reaction"], whole["reaction"][:4])

    def test_times_of_their_own(self):
        text = (EXAMPLES / "slab.hvi").read_text().replace("u_y = u.y at [1, 0]", "u_y = u.y at [1, 0] at t = 0.5")
        model = hvi.loads(text, n=2, N=4) if "at t" in text else None
        values = [step["u_y"] for step in model.steps()]
        self.assertTrue(np.isnan(values[0]))
        self.assertEqual(values[1], values[3])

    def test_a_step_without_certificate(self):
        text = (EXAMPLES / "slab.hvi").read_text().replace("from u = 0\n", "from u = 0 using tolerance = 1e-30\n", 1)
        steps = hvi.loads(text, n=2, N=4).steps()
        with self.assertRaises(hvi.SolveError) as caught:
            list(steps)
        self.assertEqual(caught.exception.code, "E0701")
        self.assertIsNone(steps.advance())  # it has ended
        with self.assertRaises(hvi.SolveError) as again:
            steps.result()
        self.assertEqual((again.exception.code, str(again.exception)), ("E0701", str(caught.exception)))

    def test_a_table_has_the_rows_that_it_asks_for(self):
        text = (EXAMPLES / "slab.hvi").read_text()
        seldom = text.replace("reaction = integral(ground, layer.xi)", "reaction = integral(ground, layer.xi) every 3 steps")
        self.assertNotEqual(seldom, text)
        model = hvi.loads(seldom, n=2, N=8)
        steps = model.steps()
        values = [step["reaction"] for step in steps]
        found, expected = steps.result(), model.run()
        np.testing.assert_array_equal(found["t"], expected["t"])
        np.testing.assert_array_equal(found["reaction"], expected["reaction"])
        self.assertEqual(values, list(hvi.loads(text, n=2, N=8).run()["reaction"]))  # each step has its values

    def test_mistakes(self):
        with self.assertRaises(hvi.ScriptError):
            hvi.load(EXAMPLES / "slab.hvi").steps(n=-1)
        with self.assertRaisesRegex(ValueError, "no step"):
            hvi.load(EXAMPLES / "slab.hvi").steps(n=2, N=2).result()


sys.argv[1:] = sys.argv[2:]
unittest.main()
