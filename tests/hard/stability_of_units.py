"""What `stability` finds does not depend on units, and parameters at the ends of their ranges are moved inward.

usage: stability_of_units.py HVI_RUN
A load 1024 times as large makes all displacements so much larger, bit for bit: the changes, which are relative, are the same.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

PROGRAM = pathlib.Path(sys.argv[1]).resolve()
SCRIPT = """param load = 1 in [1, 1024]
mesh plate = rectangle(1, 1, cells = [4, 4])
part wall = plate.left
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on plate, zero on wall
find u in V
such that for all v in V
  integral(plate, B : eps(u) : eps(v)) = integral(plate, dot([1, -2]*load, v))
report
  table a = u.x at [1, 1]
"""


def variations(folder, load):
    (folder / "plate.hvi").write_text(SCRIPT)
    subprocess.run([PROGRAM, "stability", "plate.hvi", "-D", f"load={load}", "--quiet", "--json", "out.json"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    return json.loads((folder / "out.json").read_text())["variations"]


with tempfile.TemporaryDirectory() as name:
    small, large = (variations(pathlib.Path(name), load) for load in (1, 1024))
    one, other = (next(v for v in found if "`load`" in v["what"]) for found in (small, large))
    assert one["moved"] == 2.0 ** -52 and other["moved"] == 2.0 ** -53, "up from the least value, down from the greatest"
    assert not one["failure"] and not other["failure"] and 0 < other["change"] < 1e-14, (one, other)
    rest = [[v["change"] for v in found if v is not chosen] for found, chosen in ((small, one), (large, other))]
    assert rest[0] == rest[1] and len(rest[0]) > 4 and max(rest[0]) > 0, rest
