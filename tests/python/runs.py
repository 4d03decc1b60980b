"""Runs, their results, mistakes, Ctrl-C, threads.

usage: runs.py HVI_RUN SOURCE_FOLDER, with the package on PYTHONPATH"""
import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import hvi

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
EXAMPLES = SOURCE / "examples"


def command(script, *words):
    done = subprocess.run([PROGRAM, script, "--json", "-", "--quiet", *words], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


class Runs(unittest.TestCase):
    def test_a_run_has_the_bits_of_the_command(self):
        """In 2D and 3D, with friction, memory, several unknowns (MUMPS), inertia, and a mesh of gmsh."""
        for name, params in (("slab", {"n": 4, "N": 16}), ("slab3d_friction", {"n": 2, "N": 4}), ("warm_ground", {"n": 4, "N": 4}),
                             ("bounce", {}), ("bracket", {})):
            with self.subTest(name):
                words = [word for item in params.items() for word in ("-D", "{}={}".format(*item))]
                with tempfile.TemporaryDirectory() as folder:
                    there = command(EXAMPLES / f"{name}.hvi", *words, "--allow-geo", "-o", folder)
                here = hvi.load(EXAMPLES / f"{name}.hvi", allow_geo=True).run(**params)
                self.assertTrue(here.certified)
                for column, values in there["table"].items():
                    numbers = np.array([np.nan if v is None else v for v in values], dtype=float)
                    np.testing.assert_array_equal(here[column], numbers, err_msg=column)
                self.assertEqual({k: v for k, v in here.certificate.items()}, there["certificate"])

    def test_units_are_told_where_the_script_has_them(self):
        model = hvi.load(EXAMPLES / "units.hvi")
        self.assertEqual({name: p.unit for name, p in model.params.items()},
                         {"young": "MPa", "nu": "", "height": "cm", "press": "kN/cm^2", "bed": "N/cm^3", "n": ""})
        self.assertEqual((model.params["young"].value, model.params["young"].limits), (6.0, (0.1, 100.0)))
        self.assertIn("height = 5.0 [cm]", repr(model))
        before = dict(model.units)
        result = model.run(height=10, n=2)  # in cm, as declared
        self.assertEqual(before, result.units)
        told = {name: result.units[name] for name in ("t", "top_sinks", "pressed", "stress", "u", "height")}
        self.assertEqual(told, {"t": "s", "top_sinks": "mm", "pressed": "MPa", "stress": "MPa", "u": "mm", "height": "cm"})
        modulus = 6*0.6/(1.4*0.2)  # MPa; by hand: a bed of 0.05 MPa/mm and the lower 50 mm of the block under 0.2 MPa
        self.assertAlmostEqual(result.final["top_sinks"], -0.2/0.05 - 0.2*50/modulus, places=9)
        try:
            attributes = result.to_pandas().attrs
        except ImportError:
            attributes = None  # pandas is an extra
        if attributes is not None:
            self.assertEqual(attributes["units"], {name: result.units[name] for name in result.table})
        plain = hvi.load(EXAMPLES / "slab.hvi")
        self.assertEqual({p.unit for p in plain.params.values()}, {""})
        self.assertEqual((plain.units, plain.run(n=2, N=2).units), ({}, {}))

    def test_fields_are_where_the_probes_see_them(self):
        result = hvi.load(EXAMPLES / "slab.hvi").run(n=4, N=8)
        self.assertEqual(result.points.shape, (9 * 5, 2))
        self.assertEqual(result.cells.shape, (2 * 8 * 4, 3))
        at = int(np.flatnonzero((result.points == [1, 0]).all(axis=1))[0])
        self.assertEqual(result.fields["u"][at, 1], result.final["u_y"])
        self.assertEqual(result.fields["sigma"].shape, (45, 4))
        np.testing.assert_array_equal(result.fields["u"][result.points[:, 1] == 1], 0.0)
        corners = result.points[result.cells]
        areas = 0.5 * np.linalg.det(corners[:, 1:] - corners[:, :1])
        self.assertAlmostEqual(areas.sum(), 2.0, places=13)
        self.assertTrue((areas > 0).all())

    def test_quadratic_cells_are_in_the_order_of_vtk(self):
        text = (EXAMPLES / "slab.hvi").read_text().replace("vector P1", "vector P2")
        result = hvi.loads(text).run(n=2, N=2)
        self.assertEqual(result.grid.cell_type, "triangle6")
        corners, middles = result.points[result.cells[:, :3]], result.points[result.cells[:, 3:]]
        np.testing.assert_allclose(middles, (corners + np.roll(corners, -1, axis=1)) / 2, atol=1e-15)
        try:
            drawn = result.grid.triangulation()
        except ImportError:
            return  # matplotlib is an extra
        x, y = (drawn.x[drawn.triangles], drawn.y[drawn.triangles])
        areas = 0.5 * ((x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0]))
        np.testing.assert_allclose(areas, np.full(4 * len(result.cells), 2 / (4 * len(result.cells))), rtol=1e-12)

    def test_an_unknown_on_a_part_has_values_there_alone(self):
        """A temperature in the left half of a body in P2, in P1 and in P2: linear in the height, so that the middles of edges are known."""
        for order in ("P1", "P2"):
            result = hvi.loads(f"""
mesh body = rectangle(2, 1, cells = [4, 2])
part patch = body where x < 1
part held = body.right
part roof = body.top
part ground = body.bottom where x < 1
tensor B = isotropic(young = 10, poisson = 0.3)
space V = vector P2 on body, zero on held
space W = scalar {order} on patch, zero on roof
find u in V, p in W for t in [0, 1] by 2 steps from u = 0, p = 0
such that for all v in V, s in W
    integral(body, B : eps(u) : eps(v)) + integral(patch, dot(grad(p), grad(s))) - integral(patch, 0.1*p*div(v)) >= integral(ground, t*s)
report table a = p at [0.5, 0]""").run()
            x, y = result.points.T
            np.testing.assert_array_equal(np.isnan(result.fields["p"]), x > 1)
            np.testing.assert_allclose(result.fields["p"][x <= 1], (1 - y)[x <= 1], atol=1e-12)
            self.assertFalse(np.isnan(result.fields["u"]).any())

    def test_fields_of_a_body_with_damage(self):
        """In the damaged half, and nowhere else; with files and step by step, too. A mean at a node is that of the column there."""
        text = """
mesh bar = rectangle(2, 1, cells = [8, 4])
part worn = bar where x < 1
part rest = bar where x > 1
part wall = bar.left
part grip = bar.right
tensor A = isotropic(young = 1, poisson = 0.3)
tensor B = isotropic(lambda = 40, mu = 30)
state d on worn with rate 5*norm(eps(u)) from d = 0.1*x in [0, 0.95]
space V = vector P1 on bar, zero on wall
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(bar, A : eps(u') : eps(v)) + integral(worn, (1 - d)*B : eps(u) : eps(v)) + integral(rest, B : eps(u) : eps(v))
 = integral(grip, dot([2*t, 0], v))
report
  table s = sigma.xx at [0.5, 0.5], most = largest(worn, d), e = eps(u).xx at [0.1, 0.1]
  fields u, d, sigma, eps(u)
"""
        plain = hvi.loads(text).run()
        with tempfile.TemporaryDirectory() as folder:
            written = hvi.loads(text).run(output=folder)
        steps = hvi.loads(text).steps()
        for _ in steps:
            pass
        for result in (plain, written, steps.result()):
            self.assertEqual(set(result.fields), {"u", "d", "sigma", "eps_u"})
            x = result.points[:, 0]
            np.testing.assert_array_equal(np.isnan(result.fields["d"]), x > 1)
            self.assertFalse(np.isnan(result.fields["sigma"]).any())
            np.testing.assert_array_equal(result.fields["d"], plain.fields["d"])
            strains = [np.linalg.solve(np.column_stack([result.points[cell], np.ones(3)]), result.fields["u"][cell, 0])[0] for cell in result.cells]
            corner = int(np.flatnonzero((result.points == [0, 0]).all(axis=1))[0])
            around = [strain for strain, cell in zip(strains, result.cells) if corner in cell]
            self.assertAlmostEqual(result.fields["eps_u"][corner, 0], np.mean(around), places=13)
            self.assertLess(np.nanmax(result.fields["d"]), plain.final["most"] + 1e-15)
            self.assertGreater(np.nanmax(result.fields["d"]), 0.6 * plain.final["most"])
            at = int(np.flatnonzero((result.points == [0.5, 0.5]).all(axis=1))[0])
            self.assertAlmostEqual(result.fields["sigma"][at, 0], plain.final["s"], places=12)

    def test_kept_steps(self):
        result = hvi.load(EXAMPLES / "slab.hvi").run(n=2, N=8, keep_every=4)
        np.testing.assert_allclose(result.kept_times, [0.5, 1.0])
        np.testing.assert_array_equal(result.kept["u"][-1], result.fields["u"])
        self.assertEqual(result.kept["u"].shape, (2, 15, 2))

    def test_a_run_that_starts_again_keeps_its_own_steps(self):
        """A spike that the first route of the memory misses: an audit finds it in the middle of the run."""
        text = (EXAMPLES / "slab.hvi").read_text()
        spike = text.replace("kernel C(lag) = -exp(-lag/0.5) * B",
                             "kernel C(lag) = -(exp(-lag) + 1000*exp(-((lag - 0.30025)/0.000001)^2)) * B")
        self.assertNotEqual(spike, text)
        result = hvi.loads(spike, n=2, N=2000).run(keep_every=100)
        self.assertTrue(any("started again" in note["what"] or "off the direct sum" in note["what"] for note in result.notes), result.notes)
        np.testing.assert_allclose(result.kept_times, np.arange(1, 21) / 20)
        self.assertEqual(len(result.kept["u"]), 20)

    def test_words_of_a_run_that_are_none(self):
        model = hvi.load(EXAMPLES / "slab.hvi", n=2, N=2)
        for wrong in ({"keep_every": 2.5}, {"keep_every": "x"}, {"accuracy": "x"}, {"accuracy_of": 3}, {"progress": 3}):
            with self.assertRaisesRegex(TypeError, next(iter(wrong))):
                model.run(**wrong)
        for wrong in ({"keep_every": -1}, {"accuracy": -1}, {"accuracy": float("nan")}, {"budget": 0}):
            with self.assertRaisesRegex(ValueError, next(iter(wrong))):
                model.run(**wrong)
        self.assertEqual(len(model.run(keep_every=np.int64(1)).kept_times), 2)

    def test_files_and_energies(self):
        with tempfile.TemporaryDirectory() as folder:
            result = hvi.load(EXAMPLES / "slab.hvi").run(n=2, N=16, output=folder, monitors=True)
            self.assertTrue({"slab.csv", "slab.pvd", "slab_monitors.csv"} <= set(os.listdir(folder)))
            saved = np.genfromtxt(os.path.join(folder, "slab.csv"), delimiter=",", names=True)
            np.testing.assert_array_equal(saved["reaction"], result["reaction"])
        self.assertEqual(len(result.monitors["elastic"]), 16)

    def test_tables_for_pandas(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("pandas is not installed")
        frame = hvi.load(EXAMPLES / "slab.hvi").run(n=2, N=4).to_pandas()
        self.assertEqual(list(frame.columns), ["u_y", "u_x", "strain", "reaction"])
        self.assertEqual(list(frame.index), [0.25, 0.5, 0.75, 1.0])

    def test_check_plan_study(self):
        model = hvi.load(EXAMPLES / "slab.hvi", n=4, N=8)
        check = model.check()
        self.assertTrue(check.discrete)
        self.assertIn("H(J)", str(check))
        plan = model.plan()
        self.assertEqual((plan["schema"], plan["steps"]), ("hvi-plan/1", 8))
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "own.hvi"
            script.write_text((EXAMPLES / "slab.hvi").read_text() + "\nstudy vary n in [2, 4] and N in [4, 8] against finest\n")
            study = hvi.load(script).study()
            self.assertEqual((study["schema"], len(study["rows"])), ("hvi-study/1", 4))
        with self.assertRaisesRegex(hvi.ScriptError, "no `study` statement"):
            model.study()

    def test_accuracy(self):
        result = hvi.load(EXAMPLES / "slab.hvi").run(accuracy=0.05, accuracy_of="reaction")
        self.assertTrue(result.certified)
        self.assertIn("accuracy", result.raw)
        with self.assertRaises(hvi.Error) as caught:
            hvi.load(EXAMPLES / "slab.hvi").run(accuracy=1e-6, accuracy_of="reaction", budget=1e-6)
        self.assertIn("budget=SECONDS", str(caught.exception))
        with self.assertRaisesRegex(hvi.ScriptError, "accuracy of `reaction`"):
            hvi.load(EXAMPLES / "slab.hvi").run(accuracy_of="reaction")

    def test_parameters(self):
        model = hvi.load(EXAMPLES / "slab.hvi", n=np.int64(3))
        self.assertEqual(model.params["n"].value, 3)
        self.assertEqual((model.params["N"].range, model.params["N"].doc), ("[1, 1000000]", "time steps"))
        self.assertEqual(model.at(N=2).run().steps, 2)
        again = pickle.loads(pickle.dumps(model))
        self.assertEqual(again.params, model.params)


class Mistakes(unittest.TestCase):
    def test_a_mistake_has_its_place(self):
        with self.assertRaises(hvi.ScriptError) as caught:
            hvi.loads((EXAMPLES / "slab.hvi").read_text().replace("young = 70", "young = yuong"))
        first = caught.exception.diagnostics[0]
        self.assertEqual((first.code, first.line, first.column), ("E0301", 15, 35))
        self.assertIn("^^^^^", str(caught.exception))
        again = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual(again.diagnostics, caught.exception.diagnostics)
        with self.assertRaises(hvi.ScriptError) as caught:
            hvi.loads((EXAMPLES / "slab.hvi").read_text().replace("= isotropic(young", "= isotropc(young"))
        self.assertIn("isotropic", caught.exception.diagnostics[0].help)

    def test_values_of_parameters(self):
        for params in ({"n": 0}, {"n": 2.5}, {"m": 1}):
            with self.assertRaises(hvi.ScriptError) as caught:
                hvi.load(EXAMPLES / "slab.hvi", **params)
            self.assertTrue(caught.exception.code.startswith("E0"), caught.exception.code)

    def test_no_file(self):
        with self.assertRaises(hvi.ScriptError) as caught:
            hvi.load("/there/is/none.hvi")
        self.assertEqual(caught.exception.code, "E0601")

    def test_geometry_files_are_asked_for(self):
        script = SOURCE / "tests/lang/errors/geo_file.hvi"
        with self.assertRaises(hvi.ScriptError) as caught:
            hvi.load(script).run()
        self.assertIn("allow_geo=True", str(caught.exception))
        with self.assertRaises(hvi.ScriptError) as caught:  # another one
            hvi.load(script, allow_geo=True).run()
        self.assertNotIn("allow_geo", str(caught.exception))

    def test_a_step_without_certificate(self):
        """The tolerance cannot be met: what came before is kept."""
        text = (EXAMPLES / "slab.hvi").read_text().replace("from u = 0\n", "from u = 0 using tolerance = 1e-30\n", 1)
        with self.assertRaises(hvi.SolveError) as caught:
            hvi.loads(text).run(n=2, N=4)
        self.assertEqual(caught.exception.code, "E0701")

    def test_unknown_columns(self):
        result = hvi.load(EXAMPLES / "slab.hvi").run(n=2, N=2)
        with self.assertRaisesRegex(KeyError, "reaction"):
            result["reakction"]

    def test_names_of_columns(self):
        """As of a dictionary: `in`, loops, and copies."""
        result = hvi.load(EXAMPLES / "slab.hvi").run(n=2, N=2)
        self.assertTrue("reaction" in result and "reakction" not in result)
        self.assertEqual(list(result), ["t", "u_y", "u_x", "strain", "reaction"])
        np.testing.assert_array_equal(dict(result)["reaction"], result["reaction"])


class Process(unittest.TestCase):
    def test_two_threads_have_the_bits_of_one(self):
        """Scripts whose parts are not made for threads: gmsh, METIS (3D) and MUMPS have one state in a process."""
        work = [("slab", {"n": 8, "N": 32}), ("slab3d_friction", {"n": 6, "N": 2}), ("warm_ground", {"n": 6, "N": 4}), ("bracket", {}),
                ("slab", {"n": 7, "N": 32})]
        models = [hvi.load(EXAMPLES / f"{name}.hvi", allow_geo=True, **params) for name, params in work]
        alone = [model.run() for model in models]
        found = {}

        def all_of(thread):
            order = range(len(models)) if thread % 2 == 0 else reversed(range(len(models)))
            for i in order:
                found[thread, i] = models[i].run()

        threads = [threading.Thread(target=all_of, args=(k,)) for k in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(found), 2 * len(models))
        for (_, i), result in found.items():
            for column in alone[i].table:
                np.testing.assert_array_equal(result[column], alone[i][column], err_msg=f"{work[i]} {column}")
            np.testing.assert_array_equal(result.fields["u"], alone[i].fields["u"])

    def test_many_short_runs_in_two_threads(self):
        """Two threads that begin each run together, often: where OpenBLAS is its serial build, which is not made for
        threads, one run in ten went wrong before runs took turns."""
        models = [hvi.load(EXAMPLES / "slab.hvi", n=n, N=32) for n in (7, 8)]
        alone = [model.run() for model in models]
        together, wrong = threading.Barrier(2), []

        def repeat(i):
            for _ in range(150):
                together.wait()
                try:
                    result = models[i].run()
                    wrong.extend(column for column in alone[i].table if not np.array_equal(result[column], alone[i][column]))
                except hvi.Error as error:
                    wrong.append(error.code)

        threads = [threading.Thread(target=repeat, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_other_threads_go_on(self):
        """The lock of Python is released: a counter counts while a run is made."""
        counted, over = [0], threading.Event()

        def count():
            while not over.is_set():
                counted[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        hvi.load(EXAMPLES / "slab.hvi").run(n=24, N=1024)
        after = counted[0]
        over.set()
        thread.join()
        self.assertGreater(after - before, 10)

    def test_nothing_of_the_process_changes(self):
        signals = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE, signal.SIGXFSZ, signal.SIGABRT]
        before = [signal.getsignal(one) for one in signals]
        status = lambda: [line for line in pathlib.Path("/proc/self/status").read_text().splitlines() if line.startswith(("SigBlk", "SigIgn", "SigCgt"))]  # noqa: E731
        masks = status()
        hvi.load(EXAMPLES / "slab3d_friction.hvi").run(n=6, N=1)
        hvi.load(EXAMPLES / "bracket.hvi", allow_geo=True).run()
        self.assertEqual([signal.getsignal(one) for one in signals], before)
        self.assertEqual(status(), masks)
        self.assertEqual(repr(1.5), "1.5")

    def test_progress(self):
        seen = []
        hvi.load(EXAMPLES / "slab.hvi").run(n=24, N=1024, progress=lambda *now: seen.append(now))
        self.assertEqual(seen[-1][:2], (1024, 1024))
        self.assertEqual(seen, sorted(seen))
        short = []  # a run that is over before anybody has looked
        hvi.load(EXAMPLES / "slab.hvi").run(n=2, N=3, progress=lambda *now: short.append(now))
        self.assertEqual(short[-1][:2], (3, 3))

    def test_what_a_callback_throws_ends_the_run(self):
        def refuse(step, steps, seconds):
            raise LookupError("enough")

        with self.assertRaisesRegex(LookupError, "enough"):
            hvi.load(EXAMPLES / "slab.hvi").run(n=24, N=1000000, progress=refuse)

    def test_control_c(self):
        code = (f"import hvi, sys\nmodel = hvi.load({str(EXAMPLES / 'slab.hvi')!r})\n"
                "try:\n    model.run(n=16, N=1000000, progress=lambda *now: print(now, flush=True))\n"
                "except KeyboardInterrupt:\n    print('stopped', model.run(n=2, N=2).certified)\n")
        process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
        process.stdout.readline()  # it runs
        process.send_signal(signal.SIGINT)
        self.assertIn("stopped True", process.communicate(timeout=120)[0])
        self.assertEqual(process.returncode, 0)

    def test_control_c_while_another_thread_runs(self):
        """It may be waiting for its turn, so it begins after the other, which goes on until it is asked to stop."""
        code = (f"import hvi, threading\nlong, short = (hvi.load({str(EXAMPLES / 'slab.hvi')!r}) for _ in range(2))\n"
                "begun, over = threading.Event(), threading.Event()\n"
                "def progress(*now):\n    begun.set()\n    if over.is_set(): raise LookupError('enough')\n"
                "def other():\n    try:\n        long.run(n=16, N=1000000, progress=progress)\n"
                "    except LookupError:\n        print('other stopped', flush=True)\n"
                "thread = threading.Thread(target=other)\nthread.start()\nbegun.wait()\n"
                "try:\n    print('begins', flush=True)\n    short.run(n=16, N=1000000)\nexcept KeyboardInterrupt:\n    print('stopped', flush=True)\n"
                "print('goes on', thread.is_alive(), flush=True)\nover.set()\nthread.join()\n")
        process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
        process.stdout.readline()  # the other one runs
        process.send_signal(signal.SIGINT)
        output = process.communicate(timeout=120)[0]
        for line in ("stopped", "goes on True", "other stopped"):
            self.assertIn(line, output)
        self.assertEqual(process.returncode, 0)


sys.argv[1:] = sys.argv[3:]
unittest.main()
