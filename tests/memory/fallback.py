"""A kernel that defeats every route but the direct sum: the run must notice, say so and fall back.

usage: fallback.py HVI_RUN
The kernel has a spike that is narrower than any sample taken of it, in the middle of a step where the
exact weights see it: the fit and the tree miss it, the audit finds that. Asked for a fit
of an aging kernel, the program takes the tree and says why. Reference: the direct sum.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import kernels

SPIKE = "kernel C(lag) = -(exp(-lag) + 1000*exp(-((lag - 0.30025)/0.000001)^2)) * B"


def run(program, folder, name, route):
    script, result = kernels.write(folder, name, "by N steps", route), pathlib.Path(folder) / "result.json"
    subprocess.run([program, script, "--quiet", "--json", result, "-o", folder], check=True, stderr=subprocess.DEVNULL)
    return json.loads(result.read_text())


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    kernels.KERNELS["spike"] = (SPIKE, [])
    with tempfile.TemporaryDirectory() as folder:
        direct = run(program, folder, "spike", "direct")
        found = run(program, folder, "spike", "automatic")
        aging = run(program, folder, "aging", "fit")
    said = [note["what"] for note in found["notes"] if "off the direct sum" in note["what"]]
    print("\n".join(said))
    assert found["table"] == direct["table"], "the result is not the direct sum's"
    assert len(said) == 2 and "route `tree`" in said[0] and "route `direct`" in said[1]
    assert aging["plan"]["history"][0]["route"] == "tree"
    assert any("`fit` does not serve" in note["what"] for note in aging["notes"])


main()
