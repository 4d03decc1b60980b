"""Golden texts: dumps of every phase for two scripts, and what `run` prints for every example.

usage: golden.py HVI_RUN FOLDER [--update] [--short] [--another-sine]
Numbers agree within 1e-9 relative, and below 1e-20 all are zero (those of a certificate or an error
estimate: only their tolerance counts, so they are left out, as are the methods that found a step's
state, which rounding may decide); all other text agrees to the letter. --update rewrites the files;
the difference is to be read before it is committed. Which triangles gmsh makes in a disc depends on
the last digit of the C library's sine: where that is the one for processors without fused
multiply-add, numbers on such a mesh agree within a third of the error that the example states. --short
leaves out the examples that take half of the time; --another-sine: the processor is one of those.
"""
import difflib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

TOLERANCE, ZERO = 1e-9, 1e-20
ANOTHER_SINE = "--another-sine" in sys.argv or "AVX2" in os.environ.get("GLIBC_TUNABLES", "") or " fma " not in pathlib.Path("/proc/cpuinfo").read_text()
OF_MESH = {"seal.output.txt": 3e-3} if ANOTHER_SINE else {}
PHASES = ["tokens", "ast", "model", "plan"]
DUMPED = ["slab", "slab_friction"]
LONG = {"creep", "disc_brake"}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def call(program, *arguments, cwd=None):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, cwd=cwd)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))} exits with {done.returncode}\n{done.stderr}")
    return done.stdout


def shortened(output):
    """First and last row of the table, and the lines below without figures of rounding."""
    lines = output.splitlines()
    end = next(i for i, line in enumerate(lines) if line.startswith("certified"))
    table = lines[:end] if end <= 3 else [lines[0], lines[1], lines[end - 1]]
    text = "\n".join(table + lines[end:]) + "\n"
    text = re.sub(r", worst inclusion .*, tolerance", ", tolerance", text)
    text = re.sub(r"\d+ steps? followed .*\n|steps that only the globally .*\n", "", text)
    return re.sub(r", error [^)]*\)", ")", re.sub(r"files: .*\n", "", text))


def same(old, new, tolerance):
    """Equal but for numbers within the tolerance of the larger one in their line."""
    if len(old.splitlines()) != len(new.splitlines()):
        return False
    for a, b in zip(old.splitlines(), new.splitlines()):
        if " ".join(NUMBER.sub("#", a).split()) != " ".join(NUMBER.sub("#", b).split()):
            return False
        x, y = [float(s) for s in NUMBER.findall(a)], [float(s) for s in NUMBER.findall(b)]
        scale = max((abs(v) for v in x), default=0.0)
        for p, q in zip(x, y):
            if abs(p - q) > max(ZERO, tolerance * max(abs(p), abs(q), 1e-3 * scale)):
                return False
    return True


def texts(program, root, left_out=()):
    examples = root / "examples"
    for name in DUMPED:
        for phase in PHASES:
            yield f"{name}.{phase}.txt", call(program, "dump", f"--{phase}", f"{name}.hvi", cwd=examples)
    for script in sorted(examples.glob("*.hvi")):
        if script.stem in left_out:
            continue
        with tempfile.TemporaryDirectory() as folder:
            yield f"{script.stem}.output.txt", shortened(call(program, script.name, "-o", folder, cwd=examples))


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    update = "--update" in sys.argv
    failures, count = 0, 0
    for name, text in texts(program, folder.parent.parent, LONG if "--short" in sys.argv else ()):
        path, count = folder / name, count + 1
        if update:
            path.write_text(text)
            continue
        golden = path.read_text() if path.exists() else ""
        if same(golden, text, OF_MESH.get(name, TOLERANCE)):
            continue
        failures += 1
        sys.stdout.writelines(difflib.unified_diff(golden.splitlines(True), text.splitlines(True), name, "now"))
    print(f"{count} texts {'written' if update else f'compared, {failures} differ'}")
    sys.exit(failures > 0)


main()
