"""What the checks of bodies of revolution share: scripts that are run, tables, meshes of sections."""
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "families"))
from solids import Mesh, block  # noqa: E402

PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
TWO_PI = 2 * math.pi


def run(script, mesh=None, command="run", options=(), keep=None):
    """(exit code, what was said, the results). `keep`: a folder for the files."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(keep or folder)
        (folder / "a.hvi").write_text(script)
        if mesh is not None:
            (folder / "body.msh").write_text(mesh.msh())
        words = ["a.hvi", *options]
        if command == "run":
            words += ["--quiet", "-o", "out", "--json", "a.json"]
        done = subprocess.run([PROGRAM, command, *words], cwd=folder, capture_output=True, text=True, timeout=300)
        data = json.loads((folder / "a.json").read_text()) if (folder / "a.json").exists() else None
        return done.returncode, done.stdout + done.stderr, data


def table(script, mesh=None):
    code, said, data = run(script, mesh)
    assert code == 0 and data["certificate"]["certified"], said
    return {name: np.array(values) for name, values in data["table"].items()}


def close(found, expected, tolerance, what):
    error = abs(found - expected) / max(abs(expected), 1e-300)
    print(f"  {what}: {found:.12g}, expected {expected:.12g}, relative {error:.1e}")
    assert error <= tolerance, what


def below(value, bound, what):
    print(f"  {what}: {value:.2e}, at most {bound:.1e}")
    assert value <= bound, what


def wobbly(seed, away=0.0):
    """A mesh without symmetries of the section (away, away + 1.3) x (0, 0.9)."""
    mesh = block(np.random.default_rng(seed), [5, 4], [1.3, 0.9], 0.25)
    return Mesh(mesh.points + [away, 0.0], mesh.cells, mesh.facets)


def judge(checks):
    """Runs those that are asked for; the exit code."""
    wanted = sys.argv[2:]
    failed = []
    for check in checks:
        if wanted and check.__name__ not in wanted:
            continue
        print(f"{check.__name__}: {check.__doc__.splitlines()[0]}")
        try:
            check()
        except AssertionError as problem:
            failed.append(check.__name__)
            print(f"  FAILED: {str(problem)[:1500]}")
    return f"failed: {', '.join(failed)}" if failed else 0
