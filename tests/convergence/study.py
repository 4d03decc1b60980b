"""A study of the manufactured solution: its JSON fits the schema, the orders are one, the three kinds of
reference agree, and a second call takes what the first one finished.

usage: study.py HVI_RUN ROOT
"""
import csv
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import jsonschema

program, root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
schema = json.loads((root / "docs/schema/hvi-study-1.schema.json").read_text())
script = (root / "examples/manufactured.hvi").read_text()
assert "against exact t * phi() in V" in script


def study(folder, reference):
    path = pathlib.Path(folder) / "model.hvi"
    path.write_text(script.replace("against exact t * phi() in V", f"against {reference}"))
    out = pathlib.Path(folder) / "study.json"
    subprocess.run([program, "study", path, "-o", pathlib.Path(folder) / "out", "--json", out, "--quiet"],
                   check=True, stdout=subprocess.DEVNULL)
    result = json.loads(out.read_text())
    jsonschema.validate(result, schema)
    return result


def diagonal(result):
    return [row for row in result["rows"] if row["params"]["n"] == row["params"]["N"]]


with tempfile.TemporaryDirectory() as folder:
    exact = study(folder, "exact t * phi()")
    assert len(exact["rows"]) == 16 and not any("failure" in row for row in exact["rows"])
    orders = [row["order"] for row in diagonal(exact)[1:]]
    assert all(abs(order - 1) < 0.1 for order in orders), orders
    assert (pathlib.Path(folder) / "out/cost.svg").stat().st_size > 1000
    again = study(folder, "exact t * phi()")
    assert [row["cpu"] for row in again["rows"]] == [row["cpu"] for row in exact["rows"]], "nothing ran again"
    guessed = study(folder, "richardson")
    for a, b in zip(diagonal(exact), diagonal(guessed)):
        assert abs(a["error"]["V_max"] / b["error"]["V_max"] - 1) < 0.05, (a, b)
    # Three runs, each norm by itself: errors of slopes are orthogonal to the distances, those of values add up.
    written = script
    ladder = "n, N in [[8, 8], [16, 16], [32, 32]]"
    script = script.replace("n in [4, 8, 16, 32] and N in [4, 8, 16, 32]", ladder)
    known, guessed = study(folder, "exact t * phi()"), study(folder, "richardson")
    for a, b in zip(known["rows"], guessed["rows"]):
        assert abs(a["error"]["V_max"] / b["error"]["V_max"] - 1) < 0.05, (a, b)
        for norm in ("V_final", "L2", "L2_final"):
            assert abs(a["error"][norm] / b["error"][norm] - 1) < 0.25, (norm, a, b)
    said = {entry["of"]: entry for entry in guessed["extrapolated"]}
    assert said["V error"]["along"] < 0.3 and said["L2 error"]["along"] > 0.7, said
    # Steps alone: errors in time add up. Against many steps, which leave the error of the mesh out.
    times = script.replace(ladder, "N in [4, 8, 16, 512]").replace("param n = ", "param n = 4 # ")
    script = times
    known = study(folder, "finest")
    script = times.replace("[4, 8, 16, 512]", "[4, 8, 16]")
    guessed = study(folder, "richardson")
    for a, b in zip(known["rows"][:3], guessed["rows"]):
        assert abs(a["error"]["V_max"] / b["error"]["V_max"] - 1) < 0.1, (a, b)
    # A ladder of words refines nothing: every element has its orders, and the rows of both are corrected.
    script = written.replace("n in [4, 8, 16, 32] and N in [4, 8, 16, 32]", ladder + " and element in [P1, P2]")
    script = script.replace("vector P1", "vector element").replace("param n", "param element = P1\nparam n", 1)
    known, guessed = study(folder, "exact t * phi()"), study(folder, "richardson")
    for a, b in zip(known["rows"], guessed["rows"]):
        off = abs(a["error"]["V_max"] / b["error"]["V_max"] - 1) # P1 beside the diagonal, by the mix of errors on it
        assert off < (0.05 if a["params"]["element"] == "P2" else 0.2), (a, b)
        assert (b["order"] is None) == (b["params"]["n"] == "8"), b
    # Continued without the rows of a rung that others are compared with: the same errors.
    journal = pathlib.Path(folder) / "out/study.jsonl"
    lines = journal.read_text().splitlines()
    kept = [line for line in lines if json.loads(line)["values"] == {"n": "8", "N": "8", "element": "P2"}]
    journal.write_text(kept[-1] + "\n")
    for a, b in zip(guessed["rows"], study(folder, "richardson")["rows"]):
        assert a["error"] == b["error"], (a, b)
    # A value that the script refuses is a setting that fails.
    script = written.replace("n in [4, 8, 16, 32] and N in [4, 8, 16, 32]", "n in [1, 4, 8] and N in [4]")
    rows = study(folder, "finest")["rows"]
    assert rows[0]["failure"].startswith("E0") and "`n`" in rows[0]["failure"], rows[0]
    assert all("failure" not in row for row in rows[1:]) and rows[2]["order"] is None
    script = written
    finest = study(folder, "finest")
    assert "error" not in finest["rows"][-1]
# Stopped by Ctrl-C after some settings: a second call goes on with the others.
with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    path = folder / "model.hvi"
    path.write_text(script.replace("n in [4, 8, 16, 32] and N in [4, 8, 16, 32]", "n in [8, 16, 32, 64] and N in [64, 128]"))
    command = [program, "study", path, "-o", folder / "out", "--json", folder / "study.json", "--quiet"]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    journal = folder / "out/study.jsonl"
    while running.poll() is None and not (journal.exists() and journal.read_text().count("\n") >= 3):
        time.sleep(0.01)
    running.send_signal(signal.SIGINT)
    assert running.wait() == 130, running.returncode
    first = [json.loads(line) for line in journal.read_text().splitlines()]
    assert 3 <= len(first) < 8
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    rows = json.loads((folder / "study.json").read_text())["rows"]
    assert len(rows) == 8 and len(journal.read_text().splitlines()) == 8
    for entry in first:
        assert [row["cpu"] for row in rows if row["params"] == entry["values"]] == [entry["cpu"]]

# A ladder of two parameters climbs the diagonal; runs on one mesh share what was assembled, with the same errors.
with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    path = folder / "model.hvi"
    vary = "vary n in [4, 8, 16, 32] and N in [4, 8, 16, 32]"
    path.write_text(script.replace(vary, "vary n, N in [[4, 4], [8, 8], [16, 16], [32, 32]]"))
    subprocess.run([program, "study", path, "-o", folder / "out", "--json", folder / "study.json", "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    result = json.loads((folder / "study.json").read_text())
    jsonschema.validate(result, schema)
    assert [row["params"] for row in result["rows"]] == [row["params"] for row in diagonal(exact)]
    for a, b in zip(result["rows"], diagonal(exact)):
        assert a["error"]["V_max"] == b["error"]["V_max"], "alone and with shared work: the same bits"
    assert exact["shared"]["meshes"] == 12 and exact["shared"]["matrices"] > 0 and exact["shared"]["orders"] > 0
    assert result["shared"]["meshes"] == 0
    lines = (folder / "out/study.csv").read_text().splitlines()
    assert lines[0].startswith("n,N,unknowns") and "strain_error" in lines[0] and len(lines) == 5
    # study.csv against the JSON, for errors that are largest before the end.
    path.write_text(script.replace(vary, "vary n, N in [[4, 4], [8, 8]]").replace("exact t * phi()", "exact (3*t - 2*t^2) * phi()"))
    subprocess.run([program, "study", path, "-o", folder / "other", "--json", folder / "other.json", "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    names = {"v_max": "V_max", "v_final": "V_final", "l2_max": "L2", "l2_final": "L2_final"}
    for a, b in zip(csv.DictReader((folder / "other/study.csv").open()), json.loads((folder / "other.json").read_text())["rows"], strict=True):
        assert {name: float(a[name]) for name in names} == {name: b["error"][of] for name, of in names.items()}, (a, b)
        assert len({a[name] for name in names}) == 4, a
        # The constant of the Cea type inequality: |error|^2 over the sum of its terms.
        terms = sum(float(a[f"cea_{term}"]) for term in ("interpolation", "interpolation_rate", "trace", "residual", "rate", "start", "step"))
        assert abs(float(a["cea_constant"]) * terms / float(a["v_max"]) ** 2 - 1) < 1e-7, a
    # A ladder of lengths falls where that of their numbers rises: the same orders.
    lengths = script.replace(vary, "vary h in [0.25, 0.125, 0.0625, 0.03125]").replace("param n", "param h = 0.25\nparam n", 1)
    path.write_text(lengths.replace("cells = [n, n]", "cells = [1/h, 1/h]").replace("by N steps", "by 1/h steps"))
    subprocess.run([program, "study", path, "-o", folder / "falls", "--json", folder / "falls.json", "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    falls = json.loads((folder / "falls.json").read_text())["rows"]
    assert [row["order"] for row in falls] == [row["order"] for row in result["rows"]], falls
print("orders", [round(order, 3) for order in orders])
