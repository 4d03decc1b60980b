"""BDF2 where contact states change in time: order 2 with kinks of the slope, more than 1 with jumps, never behind
backward Euler, whose order stays 1.

usage: contact_changes.py HVI_RUN SCRIPT
"""
import json
import pathlib
import subprocess
import sys
import tempfile

program, script = sys.argv[1:]
for kind, least in ((0, 1.9), (1, 1.9), (2, 1.5)):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "study.json"
        subprocess.run([program, "study", script, "-D", f"kind={kind}", "-o", folder, "--json", out, "--quiet"],
                       check=True, stdout=subprocess.DEVNULL)
        rows = json.loads(out.read_text())["rows"]
    last = {row["params"]["method"]: row for row in rows if row["params"]["N"] == "128"}
    euler, bdf2 = last["backward_euler"], last["bdf2"]
    print(f"kind {kind}: order {euler['order']:.2f} backward Euler, {bdf2['order']:.2f} bdf2")
    assert abs(euler["order"] - 1) < 0.1 and least < bdf2["order"] < 2.2
    assert bdf2["error"]["V_max"] < 0.1 * euler["error"]["V_max"]
