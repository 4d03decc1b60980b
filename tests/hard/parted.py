"""Two bodies that part, one of which creeps back to rest over 30 orders of magnitude while the other one moves: the run is certified,
and its table is that of the bodies' unknowns on both sides.

usage: parted.py HVI_RUN"""
import subprocess
import sys
import tempfile

SCRIPT = """
param N = 300
mesh upper = rectangle(1, 0.5, cells = [9, 5], at = [0, 0.5])
mesh lower = rectangle(1, 0.5, cells = [7, 4])
mesh both = upper + lower
part seam = pair(upper.bottom, lower.top)
part lid = upper.top
part floor = lower.bottom
tensor A = isotropic(young = 5, poisson = 0.1)
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential press(r) with slope
  | r < 0 -> 0
  | otherwise -> 1000*r
space V = vector P1 on both, zero on lid, zero on floor
find u in V for t in [0, 6] by N steps from u = 0
such that for all v in V
    integral(both, B : eps(u) : eps(v)) + integral(both, A : eps(u') : eps(v)) + integral(seam, press^0(jump(u).nu; jump(v).nu))
 >= integral(upper, dot([0.3*sin(6*t), -4*max(0, 0.5 - t) + 3*max(0, t - 1)], v))
report table a = u.y at [0.5, 0.75], b = u.y at [0.5, 0.25]
"""


def table(program, folder, *options):
    out = subprocess.run([program, "parted.hvi", "--no-files", *options], cwd=folder, capture_output=True, text=True)
    assert out.returncode == 0, out.stderr
    rows = [line.split() for line in out.stdout.splitlines() if line.strip()]
    return [[float(x) for x in row] for row in rows if row[0][0].isdigit()]


def main():
    with tempfile.TemporaryDirectory() as folder:
        open(f"{folder}/parted.hvi", "w").write(SCRIPT)
        jumps, sides = table(sys.argv[1], folder), table(sys.argv[1], folder, "--both-sides")
    assert len(jumps) == len(sides) and len(jumps) > 10
    largest = max(abs(x) for row in sides for x in row[1:])
    worst = max(abs(x - y) for p, q in zip(jumps, sides) for x, y in zip(p, q))
    least = min(abs(row[2]) for row in sides)
    print(f"{len(sides)} rows, {worst / largest:.1e} apart; the lower body's last {least:.1e} of {largest:.1e}")
    assert worst < 1e-10 * largest and least < 1e-20 * largest


main()
