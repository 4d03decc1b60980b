"""--accuracy keeps its word on data that jump, pulse, oscillate and have layers in time.

usage: accuracy.py HVI_RUN [--scenes N] [--seed S] [--verbose]

Draws scenes from the families of accuracy_cases.py in turn, each against a reference of its own. wrong: the true error is
above the wanted one. refused: no setting was found; all of them are solved by a few hundred steps, so none may be.
"""
import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile

import accuracy_cases as cases

parser = argparse.ArgumentParser()
parser.add_argument("program", type=pathlib.Path)
parser.add_argument("--scenes", type=int, default=len(cases.FAMILIES))
parser.add_argument("--seed", type=int, default=17)
parser.add_argument("--only", default="", help="families whose name has this")
parser.add_argument("--verbose", action="store_true")
options = parser.parse_args()

families = [f for f in cases.FAMILIES if options.only in ", ".join(f)]
random.Random(options.seed).shuffle(families)
certified = wrong = refused = 0
for n in range(options.scenes):
    draw = random.Random(f"{options.seed} {n}")
    scene = cases.scene(families[n % len(families)], draw)
    with tempfile.TemporaryDirectory() as folder:
        script, out = pathlib.Path(folder) / "scene.hvi", pathlib.Path(folder) / "result.json"
        script.write_text(scene.script)
        words = ["--of", scene.probe] if scene.probe else []
        done = subprocess.run([options.program.resolve(), script, "--accuracy", str(scene.wanted), "--quiet", "--json", out,
                               "-o", folder, *words], capture_output=True, text=True)
        if done.returncode:
            refused += 1
            why = next((line for line in done.stderr.splitlines() if line.startswith("error")), done.stderr)
            print(f"scene {n} ({scene.name}, {scene.wanted}, of {scene.probe or 'V'}): {why}", flush=True)
            continue
        result = json.loads(out.read_text())
    true, last = scene.true_error(result), result["accuracy"]["tries"][-1]
    certified += 1
    if not true <= scene.wanted:
        wrong += 1
    if options.verbose or not true <= scene.wanted:
        print(f"scene {n} ({scene.name}, {scene.wanted}, of {scene.probe or 'V'}): true {true:.2e}, estimated "
              f"{result['accuracy']['estimate']:.2e}, {last['setting']}, {result['accuracy']['cpu']:.2f} s", flush=True)
print(f"family accuracy: scenes {options.scenes}, certified {certified}, wrong {wrong}, refused {refused}")
sys.exit(wrong > 0 or refused > 0)
