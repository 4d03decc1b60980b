"""u_tau and bar u_tau between grid times, with loads at the end of the step and averaged: order one, each.

usage: interpolants.py HVI_RUN SCRIPT
Reference: analytic. t = 1/3 stands at a third of a step for N = 10, 40, 160, 640.
"""
import json
import math
import subprocess
import sys
import tempfile

program, script = sys.argv[1:]


def final(**defines):
    with tempfile.NamedTemporaryFile(suffix=".json") as result, tempfile.TemporaryDirectory() as out:
        words = [word for pair in defines.items() for word in ("-D", "=".join(map(str, pair)))]
        subprocess.run([program, script, "--quiet", "--json", result.name, "-o", out, *words], check=True,
                       stdout=subprocess.DEVNULL)
        return json.load(open(result.name))["final"]


values = {}
for load in ("endpoint", "average"):
    for between in ("affine", "constant"):
        runs = [final(N=n, sampling=load, between=between) for n in (10, 40, 160, 640)]
        early = [abs(run["early"] - math.sin(2 / 3)) for run in runs]
        late = [abs(run["late"] - math.sin(2)) for run in runs]
        values[load, between] = runs[0]
        for name, errors in (("early", early), ("late", late)):
            order = math.log(errors[-2] / errors[-1], 4)
            print(f"{load:>9} {between:>9} {name:>6} {errors[-1]:.3e} order {order:.3f}")
            assert abs(order - 1) < 0.05, errors

# The choices are different numbers, and the interpolant changes nothing at grid times.
for load in ("endpoint", "average"):
    affine, constant = values[load, "affine"], values[load, "constant"]
    assert affine["late"] == constant["late"] and affine["early"] < constant["early"]
assert values["endpoint", "affine"]["late"] != values["average", "affine"]["late"]
