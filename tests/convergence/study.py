"""A study of the manufactured solution: its JSON fits the schema, the orders are one, the three kinds of
reference agree, and a second call takes what the first one finished.

usage: study.py HVI_RUN ROOT
"""
import json
import pathlib
import subprocess
import sys
import tempfile

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
    finest = study(folder, "finest")
    assert "error" not in finest["rows"][-1]
print("orders", [round(order, 3) for order in orders])
