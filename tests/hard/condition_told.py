"""The condition number of the step's matrix is in the JSON of a run that ends well, and is that of the matrix: at least 1.

usage: condition_told.py HVI_RUN SCRIPT
"""
import json
import math
import subprocess
import sys

program, script = sys.argv[1:]
done = subprocess.run([program, "run", script, "--no-files", "--quiet", "--json", "-"], capture_output=True, text=True)
assert done.returncode == 0, (done.returncode, done.stderr)
condition = json.loads(done.stdout)["forward_error"]["condition"]
assert math.isfinite(condition) and condition >= 1, condition
print(f"exit code 0, condition number {condition:.1e}")
