"""The slab's corners: order 0.8 in h on uniform meshes, 1 on graded ones, against one graded reference.

usage: corners.py HVI_RUN SCRIPT
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

program, script = sys.argv[1:]
with tempfile.TemporaryDirectory() as folder:
    out = pathlib.Path(folder) / "study.json"
    subprocess.run([program, "study", script, "-o", pathlib.Path(folder) / "out", "--json", out, "--quiet"],
                   check=True, stdout=subprocess.DEVNULL)
    rows = json.loads(out.read_text())["rows"]
orders = {}
for grade in ("1", "2"):
    errors = [(int(row["params"]["n"]), row["error"]["relative"]) for row in rows
              if row["params"]["grade"] == grade and int(row["params"]["n"]) <= 64]
    for n, error in errors:
        print(f"grade {grade}  n {n:>4}  relative error {error:.3e}")
    # From 16 to 32: nearer the reference the distance to it is less than the error.
    orders[grade] = math.log2(errors[1][1] / errors[2][1])
    print(f"grade {grade}: order {orders[grade]:.3f}")
assert 0.7 < orders["1"] < 0.88, orders
assert abs(orders["2"] - 1) < 0.05, orders
