"""Every kernel by every route that serves it against the direct sum, N = 2,000, from scripts.

usage: routes.py HVI_RUN uniform|graded|listed [kernel ...]   (all kernels when none is named)
Reference: the direct sum of the same program (independent of the other routes; tests/solver/history
holds it against brute force). All steps of all columns must agree within the memory tolerance, and
with more than the tolerance no result may come out.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

from kernels import FIELDS, KERNELS, write

LISTED = [0.0]  # 600 steps of six lengths, without a pattern
for i in range(1, 600):
    LISTED.append(LISTED[-1] + (1, 2, 0.5, 3, 1.5, 0.2)[i * i % 13 % 6])
GRIDS = {"uniform": "by N steps", "graded": "at graded(N, 2)",
         "listed": "at [" + ", ".join(f"{t / (LISTED[-1] + 1):.9f}" for t in LISTED) + ", 1]"}
TOLERANCE = 1e-8


def run(program, folder, name, grid, route):
    script = write(folder, name, GRIDS[grid], route)
    result = pathlib.Path(folder) / "result.json"
    done = subprocess.run([program, script, "--quiet", "--json", result, "-o", folder], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{name} by {route}: exit {done.returncode}\n{done.stderr}")
    return json.loads(result.read_text())


def difference(a, b):
    worst = 0.0
    for column, values in a["table"].items():
        size = max(abs(v) for v in values)
        worst = max(worst, max(abs(x - y) for x, y in zip(values, b["table"][column])) / size)
    return worst


def checked(program, folder, name, grid):
    wrong = []
    direct = run(program, folder, name, grid, "direct")
    for wanted in ["automatic", *KERNELS[name][1]]:
        found = run(program, folder, name, grid, wanted)
        history = found["plan"]["history"]
        off = difference(direct, found)
        routes = ", ".join(f"{h['route']} {h['fields']}" for h in history)
        audit = max(h["audit"] for h in history)
        print(f"{name:<26} {grid:<8} {wanted:<10} {routes:<32} difference {off:.1e}  audit {audit:.1e}", flush=True)
        if len(history) != FIELDS.get(name, 1):
            wrong.append(f"{name}: {len(history)} memory fields")
        if not off <= TOLERANCE:
            wrong.append(f"{name} by {wanted}: {off:.1e} off the direct sum")
        for h in history:
            if h["route"] == "direct":
                continue
            if wanted not in ("automatic", h["route"]) and len(history) == 1:
                wrong.append(f"{name}: asked for {wanted}, got {h['route']}: {h['why']}")
            if h["audits"] < 20 or h["audited_until"] != found["steps"] or not h["audit"] <= TOLERANCE:
                wrong.append(f"{name} by {wanted}: audit {h['audit']} in {h['audits']} sums")
            if not 0 <= h["error"] <= TOLERANCE or not h["norm"] > 0:
                wrong.append(f"{name} by {wanted}: error {h['error']}")
    return wrong


def main():
    program, grid, *names = sys.argv[1:]
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for name in names or KERNELS:
            wrong += checked(pathlib.Path(program).resolve(), folder, name, grid)
    print("\n".join(wrong))
    sys.exit(bool(wrong))


main()
