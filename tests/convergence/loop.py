"""The loop of a joint with friction: the work of the pull over one period is the heat of friction (analytic).

usage: loop.py HVI_RUN LAP_JOINT
Steps of backward Euler dissipate besides, in proportion to their length; the area between the points of the loop does not have that.
"""
import csv
import pathlib
import subprocess
import sys
import tempfile

program, script = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()


def period(steps):
    """Work by the pull at the end of each step, area of the loop and heat, from the first turn on."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, script, "--quiet", "-o", folder, "-D", f"N={steps}"], check=True)
        with open(pathlib.Path(folder) / "lap_joint.csv", encoding="utf-8") as file:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    rows = [row for row in rows if row["t"] > 2 - 1e-9]
    pairs = list(zip(rows, rows[1:]))
    work = sum(b["pull"] * (b["slid"] - a["slid"]) for a, b in pairs)
    area = sum((a["pull"] + b["pull"]) / 2 * (b["slid"] - a["slid"]) for a, b in pairs)
    return work, area, rows[-1]["heat"] - rows[0]["heat"]


excess = []
for n in (60, 120, 240):
    work, area, heat = period(n)
    excess.append(work / heat - 1)
    print(f"{n} steps: work {work:.6g}, area {area:.6g}, heat {heat:.6g}, work/heat - 1 = {excess[-1]:.4f}")
assert abs(area / heat - 1) < 5e-4, "the area of the loop is not the heat"
for a, b in zip(excess, excess[1:]):
    assert 0 < b < 0.55 * a, "what the steps dissipate is not of order 1"
