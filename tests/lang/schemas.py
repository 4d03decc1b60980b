"""What commands write as JSON has the keys that the schemas have, and no others.  usage: schemas.py HVI_RUN SOURCE_FOLDER

The schemas let other keys pass where a later version may add some; here objects whose keys are listed are closed."""
import json
import pathlib
import subprocess
import sys
import tempfile

import jsonschema

STUDIES = ("study vary n in [2, 3, 4] against finest", "study vary n in [2, 4, 8] against richardson", "study vary n in [2, 4] and N in [2, 2000000]",
           "study vary n in [2, 4] against exact [x, 0]")
CASES = [  # script, command, more words
    *[(name, command, words) for name, words in (("slab", ["-D", "n=3", "-D", "N=6"]), ("hot_slider", []), ("units", []), ("peel", []), ("blocks", []), ("wall", []))
      for command in ("check", "plan", "run")],
    ("slab", "run", ["-D", "n=3", "-D", "N=6", "--monitors", "--profile"]),
    ("peel", "run", ["--monitors"]),
    ("slab", "run", ["--accuracy", "0.1", "--of", "reaction"]),
    ("slab", "run", ["-D", "n=3", "--solver", "automatic"]),
    ("slab", "plan", ["-D", "n=3", "--factor", "single"]),
    ("slab", "stability", ["-D", "n=2", "-D", "N=4"]),
    ("units", "stability", []),
    *[(study, "study", ["-D", "N=4"]) for study in STUDIES],
]


def closed(schema):
    if isinstance(schema, list):
        return [closed(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    out = {key: closed(value) for key, value in schema.items()}
    if isinstance(schema.get("properties"), dict) and "type" in schema:
        out.setdefault("additionalProperties", False)
    return out


def no_number(word):
    raise ValueError(f"{word} is no JSON")


def main():
    program, source = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    schemas = {path.name.replace("-1.schema.json", "/1"): closed(json.loads(path.read_text())) for path in (source / "docs/schema").glob("*.json")}
    wrong, seen = [], set()
    with tempfile.TemporaryDirectory() as folder:
        for name, command, words in CASES:
            script = source / "examples" / f"{name}.hvi"
            if command == "study":
                script = pathlib.Path(folder) / "own.hvi"
                script.write_text((source / "examples/slab.hvi").read_text() + name + "\n")
            done = subprocess.run([program, command, str(script), "--json", "out.json", "-o", "out", *words], cwd=folder, capture_output=True, text=True)
            if done.returncode != 0:
                wrong.append(f"{command} {name} {words}: exit code {done.returncode}\n{done.stderr}")
                continue
            result = json.loads((pathlib.Path(folder) / "out.json").read_text(), parse_constant=no_number)
            seen.add(result["schema"])
            for error in jsonschema.Draft202012Validator(schemas[result["schema"]]).iter_errors(result):
                wrong.append(f"{command} {name} {words}: {'/'.join(map(str, error.absolute_path))}: {error.message[:300]}")
    missing = set(schemas) - seen
    print(f"{len(CASES)} results of {len(seen)} schemas", *wrong, *(f"nothing written for {name}" for name in missing), sep="\n")
    sys.exit(bool(wrong or missing))


main()
