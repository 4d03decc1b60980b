"""An unknown that comes to rest beside one that does not: its increments are rounding, which is no error of the forces.

usage: at_rest.py HVI_RUN EXAMPLES

The pad of `brake.hvi` slides under a constant force and stands still at the last time, so that its displacement does not
change, while its temperature does. How much rounding is left depends on the processor and on the steps. A tolerance finer than
rounding is no reason to certify what rounding left.
"""
import json
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


def certified_finer(program):
    """Of a body that creeps back: the terms of a step are larger than their sum."""
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as script:
        script.write(FINER_THAN_ROUNDING)
        script.flush()
        done = subprocess.run([program, "run", script.name, "--no-files", "--quiet"], capture_output=True, text=True)
    return not (done.returncode == 3 and "E0701" in done.stderr and "at step 1" in done.stderr)


def main():
    program, examples = sys.argv[1:]
    refused = []
    for steps in range(10, 30):
        done = subprocess.run([program, "run", f"{examples}/brake.hvi", "-D", f"N={steps}", "--no-files", "--quiet", "--json", "-"],
                              capture_output=True, text=True)
        if done.returncode != 0 or not json.loads(done.stdout)["certificate"]["certified"]:
            refused.append(f"N = {steps}: {done.stderr.strip()[:200]}")
    print("\n".join(refused) or "20 runs, all certified")
    if certified_finer(program):
        refused.append("a tolerance of 1e-30")
        print("a tolerance of 1e-30 was met")
    return 1 if refused else 0


sys.exit(main())
