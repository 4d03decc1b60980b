"""The slab on meshes that follow its corners: the error falls like the number of unknowns to the power -1/2 with P1
and -1 with P2, against the finest adapted run.

usage: adapted.py HVI_RUN SCRIPT
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

program, script = sys.argv[1:]
text = pathlib.Path(script).read_text()
vary = "n in [8, 16, 32, 64, 192]"
assert vary in text
for element, rungs, power in (("P1", (8, 16, 32, 128), -0.5), ("P2", (8, 16, 32, 96), -1.0)):
    with tempfile.TemporaryDirectory() as folder:
        path, out = pathlib.Path(folder) / "slab.hvi", pathlib.Path(folder) / "study.json"
        path.write_text(text.replace(vary, f"n in {list(rungs)}").replace("param element = P1", f"param element = {element}"))
        subprocess.run([program, "study", path, "-o", pathlib.Path(folder) / "out", "--json", out, "--quiet"], check=True,
                       stdout=subprocess.DEVNULL)
        rows = json.loads(out.read_text())["rows"][:-1]
    for row in rows:
        print(f"{element}: {row['unknowns']:>7} unknowns, relative error {row['error']['relative']:.3e}")
    a, b = rows[0], rows[-1]
    seen = math.log(b["error"]["relative"] / a["error"]["relative"]) / math.log(b["unknowns"] / a["unknowns"])
    print(f"{element}: power {seen:.3f}")
    assert abs(seen / power - 1) < 0.12, (element, seen)
