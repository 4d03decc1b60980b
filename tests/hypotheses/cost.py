"""What `check` costs: no more than some runs, also where V is large, and where a body is held by nothing but laws.

usage: cost.py HVI_RUN EXAMPLES

In CPU time, as the program counts its own. With a form whose least eigenvalue is 0, or one of a cluster at its bound, `check`
took 50 to 400 runs; the mesh refined once, that it asks as well, is worth ten.
"""
import os
import resource
import subprocess
import sys

MOST = 30  # runs


def seconds(*command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime


def main():
    program, examples = sys.argv[1:]
    wrong = 0
    for name in ("asperities", "seal"):
        script = os.path.join(examples, f"{name}.hvi")
        run = min(seconds(program, "run", script, "--no-files", "--quiet") for _ in range(2))
        check = seconds(program, "check", script)
        print(f"{name}: run {run:.2f} s, check {check:.2f} s, {check / run:.1f} runs")
        wrong += check > MOST * run
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
