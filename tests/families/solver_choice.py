#!/usr/bin/env python3
"""Which solver a run takes that asks for none, or for `automatic`: under any limit of memory it takes one that fits, the
answer is that of a factor without a limit, and a run that goes on from a checkpoint keeps the solver it has begun with.

usage: solver_choice.py HVI_RUN

Without the module of PETSc the test is skipped (exit code 77).
"""
import json
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time

from iterative import NO_MODULE, SKIPPED, apart

# 37,962 unknowns; its factor takes some 200 MB more than iterations do.
BLOCK = """param n = 18 in [1, 100] "cells across the height"
param N = 1 in [1, 10000]   "time steps"
mesh block  = box(2, 1, 1, cells = [2*n, n, n])
part roof   = block.top
part ground = block.bottom
tensor A = isotropic(lambda = 5, mu = 10)
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential layer(r) with slope 100*max(r, 0)
space V = vector P1 on block, zero on roof
find u in V for t in [0, 1] by N steps from u = 0{using}
such that for all v in V
    integral(block, A : eps(u') : eps(v)) + integral(block, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(block, dot([3*t, -10*t, 0], v))
report
  table u_y = u.y at [1, 0, 0.5], u_x = u.x at [2, 0, 0.5], press = integral(ground, layer.xi)
"""
PLANE = BLOCK.replace("box(2, 1, 1, cells = [2*n, n, n])", "rectangle(2, 1, cells = [2*n, n])").replace(", 0.5]", "]").replace(
    "[3*t, -10*t, 0]", "[3*t, -10*t]")
MEGABYTE = 1 << 20
ALIKE = 1e-9


class Scenes:
    def __init__(self, program, folder):
        self.program, self.folder, self.wrong = program, folder, 0

    def say(self, good, what):
        print(f"{'ok   ' if good else 'FAILS'} {what}", flush=True)
        self.wrong += not good

    def write(self, text, asked=None):
        path = self.folder / "scene.hvi"
        path.write_text(text.format(using=f" using solver = {asked}" if asked else ""))
        return path

    def run(self, path, *arguments, limit=None):
        """The finished process and its JSON; `limit`: of its addresses, in bytes."""
        out = self.folder / "out.json"
        out.unlink(missing_ok=True)
        done = subprocess.run([self.program, "run", path, "--quiet", "--json", out, *arguments], cwd=self.folder, capture_output=True,
                              text=True, timeout=600,
                              preexec_fn=limit and (lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))))
        if NO_MODULE in done.stderr:
            print("skipped: " + NO_MODULE)
            sys.exit(SKIPPED)
        return done, json.loads(out.read_text()) if out.exists() else None

    def small(self):
        """What fits without a doubt is not asked about; `automatic` says what it has found."""
        for asked in (None, "automatic"):
            _, result = self.run(self.write(PLANE, asked), "--no-files")
            told = "solver" in result["plan"]
            self.say(told == (asked == "automatic") and result["plan"].get("solver", "direct") == "direct" and
                     "iterations" not in result["plan"], f"2D, {asked or 'nothing'} asked: a factor")

    def foretold(self):
        """`plan` stops a run after eight steps of many: it tells their work, by a factor and by iterations."""
        for asked in ("direct", "iterative"):
            path = self.write(PLANE, asked)
            done = subprocess.run([self.program, "plan", path, "-D", "n=4", "-D", "N=40", "--json", "-"], cwd=self.folder, capture_output=True,
                                  text=True, timeout=600)
            answer = json.loads(done.stdout)
            plan = answer["plan"]
            self.say(answer["unknowns"] == 72 and plan["newton"] >= 40 and ("iterations" in plan) == (asked == "iterative"),
                     f"plan, {asked}: {answer['unknowns']} unknowns, {plan['newton']} Newton's steps")

    def limited(self):
        """With less and less memory."""
        for asked in (None, "automatic"):
            path, taken = self.write(BLOCK, asked), []
            _, whole = self.run(path, "--no-files", "--solver", "direct")
            for megabytes in (260, 420, 450, 480, 510, 540, 580, 700):
                done, result = self.run(path, "--no-files", limit=megabytes * MEGABYTE)
                if done.returncode != 0:  # too little for either: said in one error, and nothing is printed as a result
                    taken.append("neither")
                    self.say("error[E0607]" in done.stderr and result is None, f"{asked}, {megabytes} MB: {done.stderr.strip()[:200]}")
                    continue
                iterative = "iterations" in result["plan"]
                taken.append("iterative" if iterative else "direct")
                told = result["plan"].get("solver", "direct") == taken[-1]
                difference, _ = apart(whole, result)
                self.say(told and result["certificate"]["certified"] and difference <= ALIKE,
                         f"{asked}, {megabytes} MB: {taken[-1]}, apart {difference:.1e}")
            # near the edge it depends on what libraries reserve of addresses whether a run ends in an error
            ran = [solver for solver in taken if solver != "neither"]
            self.say(taken[0] == "neither" and "iterative" in ran and ran[-1] == "direct" and ran == sorted(ran, reverse=True),
                     f"{asked}: {' '.join(taken)}")

    def resumed(self):
        """Stopped on its way with one solver, gone on with by another word."""
        path = self.write(BLOCK)
        sizes = ["-D", "n=4", "-D", "N=400", "-o", "out"]
        _, whole = self.run(path, *sizes, "--solver", "iterative")
        child = subprocess.Popen([self.program, "run", path, "--quiet", "--solver", "iterative", "--checkpoint", "5", *sizes],
                                 cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        saved = self.folder / "out" / "scene.checkpoint"
        while child.poll() is None and not saved.exists():
            time.sleep(0.002)
        child.send_signal(signal.SIGINT)
        child.wait()
        done, _ = self.run(path, *sizes, "--resume", "--solver", "direct")
        self.say(done.returncode == 1 and "was written by a run with `solver = iterative`" in done.stderr,
                 f"a checkpoint of the other solver: {done.stderr.strip()[:200]}")
        done, result = self.run(path, *sizes, "--resume")
        self.say(done.returncode == 0 and "iterations" in result["plan"] and result["table"] == whole["table"],
                 "gone on with as it was begun: the same numbers")


def main():
    with tempfile.TemporaryDirectory() as folder:
        scenes = Scenes(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(folder))
        os.environ.pop("HVI_PETSC_MODULE", None)
        scenes.resumed()
        scenes.small()
        scenes.foretold()
        if b"__asan_init" not in pathlib.Path(scenes.program).read_bytes():  # the sanitizers take terabytes of addresses
            scenes.limited()
    sys.exit(scenes.wrong > 0)


if __name__ == "__main__":
    main()
