"""Runs a script over a ladder and asserts the order of its column `error` (maximum over the steps).

usage: orders.py HVI_RUN SCRIPT ORDER TOLERANCE n=4,N=4 n=8,N=8 ...   each rung halves h and k
Reference: analytic (the script's exact solution).
"""
import json
import math
import subprocess
import sys
import tempfile


def largest_error(program, script, rung):
    with tempfile.NamedTemporaryFile(suffix=".json") as result, tempfile.TemporaryDirectory() as out:
        defines = [word for pair in rung.split(",") for word in ("-D", pair)]
        subprocess.run([program, script, "--quiet", "--json", result.name, "-o", out, *defines], check=True)
        data = json.load(open(result.name))
    assert data["certificate"]["certified"]
    return max(data["table"]["error"])


def main():
    program, script, order, tolerance, *rungs = sys.argv[1:]
    errors = [largest_error(program, script, rung) for rung in rungs]
    slopes = [math.log2(a / b) for a, b in zip(errors, errors[1:])]
    for rung, error, slope in zip(rungs, errors, ["-", *(f"{s:.3f}" for s in slopes)]):
        print(f"{rung:>16}  {error:.6e}  order {slope}")
    if abs(slopes[-1] - float(order)) > float(tolerance):
        sys.exit(f"the last observed order {slopes[-1]:.3f} is not {order} within {tolerance}")


main()
