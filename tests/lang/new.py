"""`hvi-run new KIND`: every script to start from runs, is certified, formatted and checked; no file is overwritten. `hvi-run mesh SCRIPT` tells
and draws the parts. A name that a module declares is told with its import.

usage: new.py HVI_RUN SOURCE_FOLDER"""
import pathlib
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
LAWS = {"winkler": "contact", "tresca": "friction", "fading": "kernels", "ramp": "loads", "young_poisson": "materials", "debond": "states"}


def call(*words, code=0, **more):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, **more)
    assert done.returncode == code, f"{words}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def kinds(folder):
    listed = [line.split()[0] for line in call("new").splitlines()]
    assert sorted(listed) == sorted(path.stem for path in (SOURCE / "examples/new").glob("*.hvi")) and len(listed) > 4, listed
    for kind in listed:
        call("new", kind, cwd=folder)
        script = folder / f"{kind}.hvi"
        assert script.read_text() == (SOURCE / f"examples/new/{kind}.hvi").read_text()
        call("fmt", "--check", script)
        assert "certified: " in call(script, "--no-files")
        call("check", script, "-D", "n=2")
        assert "is there already" in call("new", kind, code=2, cwd=folder)
    call("new", "contact", "own.hvi", cwd=folder)
    assert "did you mean `contact`" in call("new", "contakt", code=2, cwd=folder)


def meshes(folder):
    for kind, part in (("bodies", "seam"), ("solid", "ground")):
        said = call("mesh", folder / f"{kind}.hvi", "-o", folder)
        assert any(line.split()[:1] == [part] for line in said.splitlines()), said
        assert (folder / f"{kind}_mesh.png").read_bytes().startswith(b"\x89PNG"), said
    assert "area 1.5" in call("mesh", folder / "bodies.hvi", "-o", folder).replace("area 1.50", "area 1.5")


def imports(folder):
    for name, module in LAWS.items():
        script = folder / "unknown.hvi"
        script.write_text(f"param a = 1 + {name}(1)\n")
        said = call("check", script, code=1)
        assert f"E0301" in said and f"`import {module}`" in said, said
    said = call("check", SOURCE / "examples/slab.hvi", "-D", "cells=8", code=1)
    assert "E0320" in said and "n, N" in said, said
    said = call("check", SOURCE / "examples/slab.hvi", "-D", "m=8", code=1)
    assert "n, N" in said, said


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    kinds(folder)
    meshes(folder)
    imports(folder)
print("scripts to start from, meshes with parts, imports")
