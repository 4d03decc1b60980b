"""An unknown that comes to rest beside one that does not: its increments are rounding, which is no error of the forces.

usage: at_rest.py HVI_RUN EXAMPLES

The pad of `brake.hvi` slides under a constant force and stands still at the last time, so that its displacement does not
change, while its temperature does. How much rounding is left depends on the processor and on the steps. A body that was pressed goes back
to where it was. A tolerance finer than rounding is no reason to certify what rounding left.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

FINER_THAN_ROUNDING = """
mesh body = rectangle(1, 0.7, cells = [5, 4])
part held = body.bottom
part top  = body.top
tensor B = isotropic(young = 70, poisson = 0.31)
space V = vector P1 on body, zero on held
find u in V for t in [0, 1] by 4 steps from u = [0.01*y, 0.003*x*y] using tolerance = 1e-30
such that for all v in V
    integral(body, B : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) = integral(top, dot([0.1, 0.3*t], v))
report
  table size = norm(u)
"""

BACK = """import contact
param T = 1
param N = 8
param stiff = 12
mesh lower = box(2, 0.9021359417756656, 1, cells = [4, 1, 1])
mesh upper = box(1.1691238074463355, 0.7, 0.9887725934273596, cells = [2, 2, 2], at = [0.17188103775233787, 0.9034101400384498, 0.026472993583974282])
mesh both = lower + upper
part base = lower.bottom
part seam = pair(upper.bottom, lower.top)
tensor B = isotropic(young = stiff, poisson = 0.3)
superpotential layer(r) = unilateral(r)
space V = vector P1 on both, zero on base
find u in V for t in [0, T] by N steps from u = 0
such that for all v in V
    integral(both, B : eps(u) : eps(v)) + integral(upper, 647.0590415845572*dot(u, v))
  + integral(seam, layer^0(jump(u).nu - gap(seam); jump(v).nu))
 >= integral(upper, dot(min(2*t, 2 - 2*t)*[0.06536689283656573, -1.099308675607805, 0.02], v))
report
  table c = u.y at [1, 0.9, 0.3], d = integral(seam, layer.xi)
"""


def back_where_it_was(program):
    """What is wrong where a body is pressed and goes back: its increments on the contact unknowns leave rounding, which the check on all rows may
    refuse, so that the run begins anew on all unknowns; which of twelve bodies do depends on the processor. A run that is gone on from has
    the same numbers, and the same bits where both are on the same unknowns."""
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "back.hvi").write_text(BACK)

        def run(*words):
            done = subprocess.run([program, "run", "back.hvi", "-o", "out", "--quiet", "--json", "told.json", *words], cwd=folder, capture_output=True, text=True)
            told = json.loads((folder / "told.json").read_text()) if done.returncode == 0 else None
            return told and (told["plan"]["evolution"], told["table"]["c"])

        for k in range(12):
            stiff = ["-D", f"stiff={10 ** (1 + k / 6)!r}"]
            whole = run(*stiff)
            run(*stiff, "-D", "T=0.75", "-D", "N=6", "--checkpoint", "1")
            resumed = run(*stiff, "--checkpoint", "1", "--resume")
            if whole is None or resumed is None:
                wrong.append(f"a body that goes back, {stiff[1]}: refused")
            elif max(abs(a - b) for a, b in zip(whole[1], resumed[1])) > (0 if whole[0] == resumed[0] else 1e-9 * max(map(abs, whole[1]))):
                wrong.append(f"a body that goes back, {stiff[1]}: {resumed} instead of {whole}")
    return wrong


def certified_finer(program):
    """Of a body that creeps back: the terms of a step are larger than their sum."""
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as script:
        script.write(FINER_THAN_ROUNDING)
        script.flush()
        done = subprocess.run([program, "run", script.name, "--no-files", "--quiet"], capture_output=True, text=True)
    return not (done.returncode == 3 and "E0701" in done.stderr and "at step 1" in done.stderr)


def main():
    program, examples = str(pathlib.Path(sys.argv[1]).resolve()), sys.argv[2]
    refused = []
    for steps in range(10, 30):
        done = subprocess.run([program, "run", f"{examples}/brake.hvi", "-D", f"N={steps}", "--no-files", "--quiet", "--json", "-"],
                              capture_output=True, text=True)
        if done.returncode != 0 or not json.loads(done.stdout)["certificate"]["certified"]:
            refused.append(f"N = {steps}: {done.stderr.strip()[:200]}")
    print("\n".join(refused) or "20 runs, all certified")
    back = back_where_it_was(program)
    print("\n".join(back) or "12 bodies that go back, all certified")
    refused += back
    if certified_finer(program):
        refused.append("a tolerance of 1e-30")
        print("a tolerance of 1e-30 was met")
    return 1 if refused else 0


sys.exit(main())
