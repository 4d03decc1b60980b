"""Sweeps over processes.

usage: sweeps.py SOURCE_FOLDER, with the package on PYTHONPATH"""
import os
import pathlib
import subprocess
import sys
import unittest

import numpy as np

import hvi

EXAMPLES = pathlib.Path(sys.argv[1]).resolve() / "examples"


class Sweeps(unittest.TestCase):
    def test_four_processes_have_the_bits_of_one(self):
        model, told = hvi.load(EXAMPLES / "slab.hvi"), []
        found = hvi.sweep(model, n=[2, 3, 4], N=[4, 8], processes=4, progress=lambda done, total: told.append((done, total)))
        self.assertEqual(found.params[:3], [{"n": 2, "N": 4}, {"n": 2, "N": 8}, {"n": 3, "N": 4}])
        self.assertEqual(found.errors, [None] * 6)
        for params, value in zip(found.params, found["reaction"]):
            self.assertEqual(value, model.run(**params).final["reaction"])
        np.testing.assert_array_equal(found["n"], [2, 2, 3, 3, 4, 4])
        self.assertEqual(told[-1], (6, 6))
        self.assertEqual(told, sorted(told))

    def test_single_values(self):
        found = hvi.load(EXAMPLES / "slab.hvi").sweep(n=np.int64(2), N=np.float64(4), processes=1, progress=False)
        self.assertEqual((found.params, found.errors), ([{"n": 2, "N": 4.0}], [None]))

    def test_results_and_failures(self):
        text = (EXAMPLES / "slab.hvi").read_text().replace("mesh slab", "param tol = 1e-10\nmesh slab", 1).replace("from u = 0\n", "from u = 0 using tolerance = tol\n", 1)
        found = hvi.loads(text, n=2, N=2).sweep(tol=[1e-10, 1e-30, 1e-9], results=True, processes=2, progress=False)
        self.assertEqual([type(error) for error in found.errors], [type(None), hvi.SolveError, type(None)])
        self.assertEqual(found.errors[1].code, "E0701")
        self.assertIsNone(found.results[1])
        self.assertTrue(found.seconds[0] > 0 and np.isnan(found.seconds[1]) and found.seconds[2] > 0, found.seconds)
        self.assertEqual(found.results[0].fields["u"].shape, (15, 2))
        self.assertTrue(np.isnan(found["reaction"][1]) and np.isfinite(found["reaction"][2]))
        with self.assertRaises(KeyError):
            found["weight"]
        self.assertTrue("tol" in found and "reaction" in found and "weight" not in found)

    def test_frames_have_parameters_and_columns_of_one_name(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("pandas is not installed")
        text = (EXAMPLES / "slab.hvi").read_text().replace("mesh slab", "param u_x = 1\nparam seconds = 1\nmesh slab", 1).replace("3*t", "u_x*seconds*3*t")
        found = hvi.loads(text, n=2, N=2).sweep(u_x=[1, 2], seconds=[1], processes=1, progress=False)
        frame = found.to_pandas()
        self.assertEqual(list(frame["u_x"]), [1, 2])
        self.assertEqual(list(frame["columns.u_x"]), [row["u_x"] for row in found.final])
        self.assertEqual(list(frame["seconds"]), [1, 1])
        self.assertEqual(list(frame["run.seconds"]), list(found.seconds))
        self.assertIn("reaction", frame)

    def test_a_bar_on_a_terminal(self):
        code = f"import hvi; hvi.load({str(EXAMPLES / 'slab.hvi')!r}, N=2).sweep(n=[2, 3, 4], processes=1)"
        master, slave = os.openpty()
        process = subprocess.Popen([sys.executable, "-c", code], stderr=slave)
        os.close(slave)
        shown = b""
        while True:
            try:
                piece = os.read(master, 4096)
            except OSError:  # nobody writes any more
                break
            shown += piece
            if not piece:
                break
        os.close(master)
        self.assertEqual(process.wait(timeout=60), 0)
        bars = shown.decode().replace("\x1b[K", "").strip("\r\n").split("\r")
        self.assertEqual(bars[0].rstrip(), "[" + 30 * "." + "] 0 of 3")
        self.assertEqual(bars[-1].rstrip(), "[" + 30 * "#" + "] 3 of 3")
        quiet = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        self.assertEqual(quiet.stderr + quiet.stdout, "")

    def test_mistakes_are_told(self):
        found = hvi.load(EXAMPLES / "slab.hvi", N=2).sweep(n=[2, 0], progress=False)
        self.assertIsInstance(found.errors[1], hvi.ScriptError)


sys.argv[1:] = sys.argv[2:]
unittest.main()
