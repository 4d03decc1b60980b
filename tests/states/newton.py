#!/usr/bin/env python3
"""A body that loses stiffness: how many passes, each with a factor of its own, a step takes.

usage: newton.py HVI_RUN EXAMPLES

Property: with the consistent tangent (solver/step/body_tangent.hpp) the states of a body settle as Newton's method does. damage.hvi took 9 to
13 passes a step by plain passes and mixing; the answer is the same.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

MOST = {8: 6, 16: 6, 32: 5}  # steps: passes
# With 32 steps; regression value of a second algorithm: plain passes and mixing, the program before it had a tangent.
LOST = 0.02179153086761


def main():
    program, good = str(pathlib.Path(sys.argv[1]).resolve()), True
    with tempfile.TemporaryDirectory() as folder:
        for steps, most in MOST.items():
            done = subprocess.run([program, "run", str(pathlib.Path(sys.argv[2]).resolve() / "damage.hvi"), "-D", f"N={steps}", "--no-files", "--quiet",
                                   "--monitors", "--json", "-"], cwd=folder, capture_output=True, text=True)
            if done.returncode:
                sys.exit(done.stderr)
            result = json.loads(done.stdout)
            passes = [int(n) for n in result["monitors"]["iterations"]]
            right = max(passes) <= most and (steps != 32 or abs(result["final"]["lost"] / LOST - 1) < 1e-10)
            print(f"{'ok    ' if right else 'WRONG '} {steps} steps: passes {passes}")
            good = good and right
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
