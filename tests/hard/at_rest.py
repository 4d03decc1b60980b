"""An unknown that comes to rest beside one that does not: its increments are rounding, which is no error of the forces.

usage: at_rest.py HVI_RUN EXAMPLES

The pad of `brake.hvi` slides under a constant force and stands still at the last time, so that its displacement does not
change, while its temperature does. How much rounding is left depends on the processor and on the steps.
"""
import json
import subprocess
import sys


def main():
    program, examples = sys.argv[1:]
    refused = []
    for steps in range(10, 30):
        done = subprocess.run([program, "run", f"{examples}/brake.hvi", "-D", f"N={steps}", "--no-files", "--quiet", "--json", "-"],
                              capture_output=True, text=True)
        if done.returncode != 0 or not json.loads(done.stdout)["certificate"]["certified"]:
            refused.append(f"N = {steps}: {done.stderr.strip()[:200]}")
    print("\n".join(refused) or "20 runs, all certified")
    return 1 if refused else 0


sys.exit(main())
