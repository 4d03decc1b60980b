"""What plan and result say of memories, and what their steps cost.

usage: said.py HVI_RUN
Tables: the Prony sum through the points and its error stand in the plan and in the result whether
the sum is taken or the table itself, the same figures each time. A kernel q(t, s), which changes
the matrix of every step: one factor, one pair of sweeps a step, as many Newton iterations as a
convolution needs.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import kernels

FIGURES = re.compile(r"(\d+) exponentials.*largest error ([0-9.e+-]+) of the largest value, root mean square ([0-9.e+-]+)")


def run(program, folder, name, *more):
    script, result = kernels.write(folder, name, "by N steps", "automatic"), pathlib.Path(folder) / "result.json"
    done = subprocess.run([program, "run", script, "--json", result, "-o", folder, *more], check=True, capture_output=True,
                          text=True)
    return json.loads(result.read_text()), done.stdout + done.stderr


def tables(program, folder):
    found = {}
    for name, state in (("table_linear", "off"), ("table_cubic", "off"), ("prony_fitted_to_data", "on")):
        result, printed = run(program, folder, name, "-D", "N=300")
        planned = subprocess.run([program, "plan", pathlib.Path(folder) / "memory.hvi"], check=True, capture_output=True,
                                 text=True).stdout
        effects = [e for e in result["plan"]["effects"] if e["name"].startswith("Prony sum")]
        assert len(effects) == 1 and effects[0]["state"] == state and effects[0]["line"] > 0, effects
        for text in (effects[0]["why"], printed, planned):
            found.setdefault(FIGURES.search(text).groups(), []).append(name)
        assert ("the table itself is taken" in printed) == (state == "off")
    assert len(found) == 1, found
    terms, largest, mean = next(iter(found))
    print(f"tables: {terms} exponentials, largest error {largest}, mean {mean}")
    assert 0 < float(mean) <= float(largest) < 1e-3


def moving_matrices(program, folder):
    steady, _ = run(program, folder, "power_05")
    for name in ("aging", "aging_singular", "aging_time", "times_t"):
        result, _ = run(program, folder, name)
        steps, plan = result["steps"], result["plan"]
        print(f"{name}: {plan['factorisations']} factors, {plan['sweeps'] / steps:.3f} sweeps and "
              f"{plan['newton'] / steps:.3f} Newton iterations a step (steady matrix {steady['plan']['newton'] / steps:.3f})")
        assert plan["factorisations"] == 1
        assert plan["sweeps"] <= 2.1 * steps and plan["newton"] <= 1.05 * steady["plan"]["newton"]


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        tables(program, folder)
        moving_matrices(program, folder)


main()
