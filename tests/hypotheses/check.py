"""`hvi-run check --json` against the schema and against numbers computed here by dense algebra.

Usage: check.py HVI_RUN ROOT

Independent: the Gram matrix of eps : eps and the lumped boundary mass of the slab's bottom are assembled
here, triangle by triangle, and their eigenvalues are numpy's. Analytic: m_1 = 2 mu of an isotropic tensor.
"""
import json
import pathlib
import subprocess
import sys

import jsonschema
import numpy as np

hvi_run, root = sys.argv[1], pathlib.Path(sys.argv[2])
schema = json.loads((root / "docs/schema/hvi-check-1.schema.json").read_text())


def check(script, *options, code=0):
    run = subprocess.run([hvi_run, "check", script, "--json", "-", *options], capture_output=True, text=True)
    assert run.returncode == code, (script, run.returncode, run.stderr)
    report = json.loads(run.stdout)
    jsonschema.validate(report, schema)
    return report


def slab_traces(n):
    """Largest eigenvalues of the lumped mass of the bottom (normal, tangential, full) against the Gram
    matrix, on the slab 2 x 1 in 2n x n cells cut by the lower-left/upper-right diagonal, clamped on top."""
    columns, h = 2 * n + 1, 1.0 / n
    node = lambda i, j: j * columns + i
    gram = np.zeros((2 * columns * (n + 1),) * 2)
    for j in range(n):
        for i in range(2 * n):
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            for cell, gradients in (((a, b, c), [(-1, 0), (1, -1), (0, 1)]), ((a, c, d), [(0, -1), (1, 0), (-1, 1)])):
                strain = np.zeros((3, 6))  # eps_xx, eps_yy, sqrt(2) eps_xy
                for k, (gx, gy) in enumerate(gradients):
                    strain[0, 2 * k], strain[1, 2 * k + 1] = gx / h, gy / h
                    strain[2, 2 * k], strain[2, 2 * k + 1] = gy / h / np.sqrt(2), gx / h / np.sqrt(2)
                dofs = [2 * v + component for v in cell for component in (0, 1)]
                gram[np.ix_(dofs, dofs)] += h * h / 2 * strain.T @ strain
    free = np.arange(2 * columns * n)  # all below the roof
    inverse = np.linalg.inv(gram[np.ix_(free, free)])
    weight = np.full(columns, h)
    weight[[0, -1]] /= 2

    def largest(components):
        at = np.array([2 * i + c for c in components for i in range(columns)])
        root_w = np.sqrt(np.tile(weight, len(components)))
        return np.linalg.eigvalsh(root_w[:, None] * inverse[np.ix_(at, at)] * root_w[None, :])[-1]

    return largest([1]), largest([0]), largest([0, 1])


def close(value, reference, tolerance=1e-6):
    assert abs(value - reference) <= tolerance * abs(reference), (value, reference)


normal, tangential, full = slab_traces(8)
report = check(root / "examples/slab_friction.hvi", "-D", "n=8", "-D", "N=64")
constants = report["constants"]
norms = constants["norm_M2"]
for name, reference in (("normal", normal), ("tangential", tangential), ("full", full), ("script", full)):
    close(norms[name], reference)
shear = 70 / (2 * 1.3)  # of young = 70, poisson = 0.3
close(constants["m_1"], 20), close(constants["m_2"], 2 * shear)
assert constants["m_A"] >= 20 * (1 - 1e-9) and constants["m_B"] >= 2 * shear * (1 - 1e-9)
close(constants["m_nu"], 15), close(constants["m_tau"], 4)
close(constants["margin"], constants["m_B"] - 19 * full)
assert constants["margin"] < 0 < constants["margin_split"] <= constants["m_B"]
assert report["verdict"]["discrete"]["holds"] and report["verdict"]["continuous"]["holds"]
assert "split condition" in report["verdict"]["continuous"]["says"]

# Without friction the normal trace alone counts, as the theorem for it says.
report = check(root / "examples/slab.hvi", "-D", "n=8")
close(report["constants"]["norm_M2"]["script"], normal)
close(report["constants"]["margin_max"], report["constants"]["m_B"] - 15 * normal)

# A slope that jumps down has no m_J: under --strict nothing is run.
strip = root / "examples/delamination.hvi"
report = check(strip, "--strict", code=4)
assert report["constants"]["m_J"] == "inf" and not report["verdict"]["discrete"]["holds"]
run = subprocess.run([hvi_run, "run", strip, "--strict"], capture_output=True, text=True)
assert run.returncode == 4 and "u_y" not in run.stdout.split("verdict")[-1], run
lines = {h["name"]: h["line"] for h in report["hypotheses"] if h["holds"] is False}
assert "superpotential" in strip.read_text() and lines["H(J)"] > 0

# Coulomb's bound is no superpotential of its own.
report = check(root / "tests/published/coulomb_shear.hvi")
assert not report["verdict"]["discrete"]["holds"] and not report["verdict"]["continuous"]["holds"]
assert any(h["holds"] is False and "Coulomb" in h["note"] for h in report["hypotheses"])

# B not symmetric: said, and no failure; A not symmetric would be one.
report = check(root / "examples/advection.hvi")
assert any("not symmetric" in h["note"] for h in report["hypotheses"] if h["name"] == "H(B)")
assert all(h["holds"] for h in report["hypotheses"] if h["name"] == "H(B)")

# A singular kernel: its Lipschitz constant is infinite, each step's problem is still judged.
report = check(root / "tests/convergence/weakly_singular.hvi")
assert report["constants"]["lipschitz_q"] == "inf" and report["verdict"]["discrete"]["holds"]
