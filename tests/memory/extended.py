"""A run that is done goes on to a later end: `--resume` with a longer time.

usage: extended.py HVI_RUN
Memories are kept as they are and verify themselves beyond the end they were made for; one that is not
within its tolerance there (the fit of a power of the lag, kinks beyond the first end) makes the run
begin again, which it says. Reference: the direct sum of a run to the later end from the start; within
the memory tolerance, at all steps. Other steps than before and an earlier end are refused with E0704.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import kernels

TOLERANCE = 1e-8
BEGUN_AGAIN = {("power_05", "fit"), ("stretched_exponential", "fit"), ("tensors", "automatic"), ("late_kink", "automatic")}
CASES = {  # kernel: routes
    "exponential": ["recursion", "fit", "tree"],
    "oscillating": ["recursion", "tree"],
    "power_05": ["fit", "tree"],
    "stretched_exponential": ["fit"],
    "delay": ["direct"],
    "aging": ["tree"],
    "aging_singular": ["tree"],
    "tensors": ["automatic"],
    "late_kink": ["automatic"],
}
LATE_KINK = "kernel C(lag) = -exp(-lag) * max(0, 1 - max(0, lag - 1.2)) * B"


class Scene:
    def __init__(self, program, folder):
        self.program, self.folder = program, pathlib.Path(folder)

    def write(self, name, route, scheme):
        script = kernels.write(self.folder, name, "by N steps", f"{route}, scheme = {scheme}")
        text = script.read_text().replace("t in [0, 1]", "t in [0, T]")
        script.write_text("param T = 1 in [0, 10]\n" + text)

    def run(self, out, end, steps, *more):
        """The result, or the message of a run that was refused."""
        done = subprocess.run([self.program, "run", "memory.hvi", "--quiet", "-o", out, "--json", f"{out}.json", "-D", f"T={end}",
                               "-D", f"N={steps}", *more], cwd=self.folder, capture_output=True, text=True)
        return json.loads((self.folder / f"{out}.json").read_text()) if done.returncode == 0 else done.stderr


def difference(a, b):
    worst = 0.0
    for column, values in a["table"].items():
        size = max(abs(v) for v in values)
        assert len(values) == len(b["table"][column])
        worst = max(worst, max(abs(x - y) for x, y in zip(values, b["table"][column])) / size)
    return worst


def goes_on(scene, name, route, scheme):
    scene.write(name, "direct", scheme)
    reference = scene.run("direct", 2.5, 1000)
    scene.write(name, route, scheme)
    first = scene.run("longer", 1, 400, "--checkpoint", "100000")
    assert first["steps"] == 400
    longer = scene.run("longer", 2.5, 1000, "--checkpoint", "300", "--resume")
    assert not isinstance(longer, str), longer
    again = scene.run("longer", 2.5, 1000, "--resume")  # it is done: the same result
    off, history = difference(reference, longer), longer["plan"]["history"]
    print(f"{name} by {route}, {scheme}: {off:.1e} off the direct sum; {'+'.join(h['route'] for h in history)}, error "
          f"{max(h['error'] for h in history):.1e}, audit {max(h['audit'] for h in history):.1e} up to {history[0]['audited_until']}",
          flush=True)
    assert off <= TOLERANCE and longer["steps"] == 1000 and longer["certificate"]["certified"]
    assert again["table"] == longer["table"]
    said = [note["what"] for note in longer["notes"] if "started again from the first step" in note["what"]]
    for what in said:
        print(f"    {what}")
    assert len(said) == ((name, route) in BEGUN_AGAIN)
    for h in history:
        if h["route"] != "direct":
            assert h["error"] <= TOLERANCE and h["audit"] <= TOLERANCE and h["audited_until"] == 1000
    for a, b in zip(history, again["plan"]["history"]):
        assert a["route"] == b["route"] and a["norm"] == b["norm"] and a["fields"] == b["fields"]


def is_refused(scene, what, said):
    print(f"{what}: refused: {next(iter(re.findall(r'E0704.*', said)), said) if isinstance(said, str) else 'no'}", flush=True)
    assert isinstance(said, str) and "E0704" in said


def main():
    kernels.KERNELS["late_kink"] = (LATE_KINK, [])
    with tempfile.TemporaryDirectory() as folder:
        scene = Scene(pathlib.Path(sys.argv[1]).resolve(), folder)
        for name, routes in CASES.items():
            for route in routes:
                goes_on(scene, name, route, "backward_euler")
        goes_on(scene, "power_05", "fit", "bdf2")
        goes_on(scene, "aging_singular", "tree", "bdf2")
        scene.write("power_05", "automatic", "backward_euler")
        scene.run("cut", 1, 400, "--checkpoint", "100000")
        is_refused(scene, "longer steps", scene.run("cut", 2.5, 800, "--resume"))
        is_refused(scene, "an earlier end", scene.run("cut", 0.5, 200, "--resume"))
        scene.write("power_09", "automatic", "backward_euler")
        is_refused(scene, "another kernel", scene.run("cut", 2.5, 1000, "--resume"))


main()
