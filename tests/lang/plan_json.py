"""`plan --json` keeps its schema and foretells what a run does.  usage: plan_json.py HVI_RUN SOURCE_FOLDER"""
import json
import pathlib
import subprocess
import sys
import tempfile

import jsonschema

CASES = {"slab": ["-D", "n=8", "-D", "N=40"], "slab_friction": ["-D", "n=8", "-D", "N=12"], "membrane": [], "wall": []}


def main():
    program, source = sys.argv[1], pathlib.Path(sys.argv[2])
    schema = json.loads((source / "docs/schema/hvi-plan-1.schema.json").read_text())
    with tempfile.TemporaryDirectory() as folder:
        def call(command, name, *more):
            words = [program, command, str(source / "examples" / f"{name}.hvi"), *CASES[name], *more]
            return subprocess.run(words, cwd=folder, capture_output=True, text=True)

        for name in CASES:
            alone = call("plan", name, "--json", "-")
            assert alone.returncode == 0, alone
            call("plan", name, "--json", "plan.json")
            foretold = json.loads((pathlib.Path(folder) / "plan.json").read_text())
            printed = json.loads(alone.stdout)  # nothing but the JSON
            for one in (foretold, printed):
                jsonschema.validate(one, schema)
                one["plan"].pop("seconds"), one["plan"].pop("bytes")
            assert foretold == printed, name
            done = call("run", name, "--json", "run.json", "--no-files")
            assert done.returncode == 0, done
            ran = json.loads((pathlib.Path(folder) / "run.json").read_text())
            for key in ("unknowns", "contact_unknowns", "steps", "params"):
                assert foretold[key] == ran[key], (name, key, foretold[key], ran[key])
            for key in ("matrices", "analyses", "factorisations", "fields", "evolution"):
                assert foretold["plan"][key] == ran["plan"][key], (name, key, foretold["plan"][key], ran["plan"][key])
            routes = [[h["route"] for h in one["plan"]["history"]] for one in (foretold, ran)]
            assert routes[0] == routes[1], (name, routes)
            assert ran["plan"]["sweeps"] / 3 <= foretold["plan"]["sweeps"] <= 3 * ran["plan"]["sweeps"], (name, foretold["plan"]["sweeps"], ran["plan"]["sweeps"])
        late = pathlib.Path(folder) / "late.hvi"  # the first steps end before the first row
        late.write_text((source / "examples" / "together.hvi").read_text().replace("every 4 steps", "every 40 steps"))
        done = subprocess.run([program, "plan", str(late)], capture_output=True, text=True)
        assert done.returncode == 0, done
        refused = call("plan", "slab", "--json", "/dev/full")
        assert refused.returncode == 3 and "E0702" in refused.stderr, refused
    print(f"{len(CASES)} plans")


main()
