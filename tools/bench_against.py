"""tools/bench against REV [--pairs N] [--count] [--quick]: whole runs of this program and of another revision of it, one after the other.

Builds REV once, in build/against, the way REV builds itself, and prints a row for each scene of `tools/bench speed` that is
ours: this program's CPU time (user and system) over that of REV, medians of alternating runs, and the minima beside it. Each
side runs twice and the second run counts: in a virtual machine the first run that needs more memory than the one before it waits
for the host to find the pages (0.5 s of 2.8 s where a run of 819 MB follows one of 743 MB). Both solve the same script of
this tree, and their last table lines must agree to nine digits. `--count` runs each side once more under callgrind and prints
the ratio of instructions, which does not depend on what else the machine does.
"""
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDER = ROOT / "build" / "against"
MOST = 1.1  # times the other revision
SCENES = [("slab", "bench/slab.hvi", 64, 64), ("slab", "bench/slab.hvi", 64, 256), ("slab", "bench/slab.hvi", 128, 64),
          ("slab", "bench/slab.hvi", 256, 64), ("slab with friction", "examples/slab_friction.hvi", 64, 64),
          ("slab with friction", "examples/slab_friction.hvi", 128, 64), ("slab with friction", "examples/slab_friction.hvi", 256, 64),
          ("slab3d", "bench/slab3d.hvi", 16, 16), ("slab3d with friction", "bench/slab3d_friction.hvi", 16, 16),
          ("one tensor", "bench/slab_one_tensor.hvi", 128, 1024)]


def option(name, otherwise):
    return sys.argv[sys.argv.index(name) + 1] if name in sys.argv else otherwise


def run(*command, **more):
    return subprocess.run([str(word) for word in command], check=True, **more)


def build(revision):
    """hvi-run of a revision, made from its committed files."""
    commit = run("git", "rev-parse", "--verify", f"{revision}^{{commit}}", cwd=ROOT, capture_output=True,
                 text=True).stdout.strip()
    source = FOLDER / commit
    program = source / "build" / "release" / "hvi-run"
    if program.exists():
        return program
    source.mkdir(parents=True, exist_ok=True)
    files = run("git", "archive", commit, cwd=ROOT, stdout=subprocess.PIPE).stdout
    run("tar", "-x", "-C", source, input=files)
    print(f"building {commit[:10]} in {source}; this takes minutes", flush=True)
    run("cmake", "--preset", "release", "-DHVI_TESTS=OFF", "-DHVI_BENCH=OFF", cwd=source, stdout=subprocess.DEVNULL)
    run("ninja", "-C", source / "build" / "release", "hvi-run", stdout=subprocess.DEVNULL)
    return program


def last_line(command):
    result = FOLDER / "result.json"
    run(*command, "--quiet", "--json", result, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return json.loads(result.read_text())["final"]


def farthest(ours, theirs):
    """The largest difference of what two last lines both have, relative."""
    return max(abs(ours[name] - theirs[name]) / (abs(theirs[name]) or 1) for name in ours.keys() & theirs.keys())


def instructions(command):
    done = run("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command, "--quiet", cwd=ROOT,
               capture_output=True, text=True)
    return int(re.search(r"Collected : (\d+)", done.stderr)[1])


def against(quick, seconds_of, row, program):
    """Rows of `program`; `seconds_of` a command: its CPU time."""
    if len(sys.argv) < 3 or sys.argv[2].startswith("-"):
        sys.exit(__doc__)
    other, pairs = build(sys.argv[2]), int(option("--pairs", 3 if quick else 20))
    rows = []
    for name, script, n, steps in SCENES[:1] if quick else SCENES:
        arguments = [script, "-D", f"n={n}", "-D", f"N={steps}", "--no-files"]
        commands = [program, *arguments], [other, *arguments]
        off = farthest(*map(last_line, commands))
        times = [], []
        for pair in range(pairs):
            for side in (0, 1) if pair % 2 == 0 else (1, 0):
                seconds_of(commands[side])
                times[side].append(seconds_of(commands[side]))
        (ours, theirs), (least, their_least) = (map(of, times) for of in (statistics.median, min))
        row(rows, f"{name} n={n} N={steps} ({ours:.3f} s, {theirs:.3f} s; least {least / their_least:.2f}; {off:.0e} off)",
            ours / theirs, MOST, 1, "times", ours / theirs <= MOST and off < 1e-9)
        if "--count" in sys.argv:
            ours, theirs = map(instructions, commands)
            row(rows, f"    instructions ({ours / 1e6:.0f} M, {theirs / 1e6:.0f} M)", ours / theirs, "-", "-", "times", None)
    return rows
