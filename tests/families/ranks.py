"""Random scenes by iterations on several processes against one process, and how such runs end.

usage: ranks.py HVI_RUN [--scenes N] [--seed S] [--ranks N,M] [--only NAME] [--endings]

The scenes are those of iterative.py, a third of them of two bodies, a third of several unknowns. Every number of the table agrees to 1e-9 of its
column's largest value, and all runs are certified; a repeated run has the same bits. Larger bodies, which are dealt out
with more choice, have the same bits, too, and not many more iterations than with one process; nor have all scenes
together. With --endings: exit codes, processes that are killed, Ctrl-C, a missing module; nothing may hang. Without the
module of PETSc or mpirun the test is skipped (exit code 77).
"""
import argparse
import json
import os
import pathlib
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

import jsonschema

import iterative

REPEATED = {2: 5, 3: 3}  # runs of a larger body with so many processes
OTHERWISE = 2
SOON = 60  # seconds in which everything here ends, on a busy machine


def run(program, path, folder, ranks):
    return iterative.run(program, path, folder, "iterative", processes=ranks)


def compare(program, path, folder, ranks, repeat, times):
    """What is wrong, or nothing; and a word on the case. `times` takes iterations over those of one process."""
    one, a = run(program, path, folder, 1)
    words = []
    for n in ranks:
        several, b = run(program, path, folder, n)
        if several.returncode != one.returncode:
            return f"one process ends with {one.returncode}, {n} with {several.returncode}: {several.stderr[-600:]}", ""
        if one.returncode != 0:
            words.append("no answer")
            continue
        if not b["certificate"]["certified"]:
            return f"not certified with {n} processes", ""
        difference, column = iterative.apart(a, b)
        if difference > iterative.AGREE:
            return f"{column} apart by {difference:.2e} with {n} processes", ""
        times.append(b["plan"]["iterations"] / max(a["plan"]["iterations"], 1))
        if repeat and run(program, path, folder, n)[1]["table"] != b["table"]:
            return f"a second run with {n} processes has other bits", ""
        words.append(f"{n}: apart {difference:.1e}, {times[-1]:.2f} times the iterations")
    return None, ", ".join(words)


def scenes(program, folder, options):
    wrong = answers = 0
    times = []
    for seed in range(options.seed, options.seed + options.scenes):
        path = folder / f"scene{seed}.hvi"
        if options.only and options.only != path.stem:
            continue
        path.write_text((iterative.scene, iterative.pair_scene, iterative.several_scene)[seed % 3](seed))
        found, word = compare(program, path, folder, options.ranks, seed % 3 == 0, times)
        if found and " apart by " in found:  # as in iterative.py
            path.write_text(path.read_text().replace("\nsuch that", " using tolerance = 1e-13\nsuch that"))
            found, word = compare(program, path, folder, options.ranks, False, [])
            word += ", tolerance 1e-13"
        wrong += found is not None
        answers += "apart" in word
        print(f"{'FAILS' if found else 'ok   '} scene{seed}: {found or word}", flush=True)
    average = statistics.geometric_mean(times) if times else 1.0  # a body of 50 unknowns may take 3 times as many
    print(f"{answers} answers compared, {wrong} wrong, {average:.2f} times the iterations of one process")
    return wrong > 0 or answers == 0 or average > MORE


BODY = """mesh body = box(2, 1, 1, cells = [20, 10, 10])
part roof = body.top
tensor B = isotropic(young = 50, poisson = 0.3)
space V = vector P1 on body, zero on roof
find u in V
such that for all v in V
    integral(body, B : eps(u) : eps(v)) >= integral(body, dot([1, -3, 0.5], v))
report
  table u_y = u.y at [1, 0, 0.5]
"""

# Closed and sticking points below, 1e13 times as stiff as the body.
CONTACT = "import contact\nimport friction\n" + BODY.replace("part roof = body.top\n", """part roof = body.top
part ground = body.bottom
superpotential wall(r) = unilateral(r)
superpotential slip(s) = tresca(s, bound = 0.3)
""").replace("eps(v)) >=", "eps(v)) + integral(ground, wall^0(u.nu - 0.001; v.nu) + slip^0(u.tau; v.tau)) >=")

# Two bodies that stiff springs join.
JOINED = """mesh lower = box(2, 1, 1, cells = [14, 7, 7])
mesh upper = box(2, 1, 1, cells = [16, 8, 8], at = [0, 1, 0])
mesh both = lower + upper
part base = lower.bottom
part roof = upper.top
part seam = pair(upper.bottom, lower.top)
tensor B = isotropic(young = 50, poisson = 0.3)
superpotential glue(r) = 5e5*r^2
space V = vector P1 on both, zero on base, zero on roof
find u in V
such that for all v in V
    integral(both, B : eps(u) : eps(v)) + integral(seam, glue^0(jump(u).nu; jump(v).nu))
 >= integral(upper, dot([1, -3, 0.5], v))
report
  table u_y = u.y at [1, 1.5, 0.5]
"""

BODIES = {"held": BODY, "in contact": CONTACT, "joined by springs": JOINED}
MORE = 1.4  # times the iterations of one process, at most


def fits(name, answer):
    """Whether a JSON has its schema."""
    schema = json.loads((pathlib.Path(__file__).resolve().parents[2] / f"docs/schema/hvi-{name}-1.schema.json").read_text())
    return jsonschema.Draft202012Validator(schema).is_valid(answer)


def foretold(program, path, judge):
    """`plan` by two processes of what was run last."""
    done = subprocess.run([*iterative.launcher(2), program, "plan", path, "--solver", "iterative", "--json", "-"], capture_output=True, text=True, timeout=300)
    answer = json.loads(done.stdout)
    judge(fits("plan", answer) and answer["plan"]["communication"]["messages"] > 0, "plan by two processes: the JSON has its schema")
    judge(0 < answer["contact_unknowns"] < answer["unknowns"], f"{answer['contact_unknowns']} of {answer['unknowns']} unknowns are in laws")


def warm(folder, n, steps):
    """A block that is heated and rubs."""
    path = folder / "warm.hvi"
    bench = pathlib.Path(__file__).resolve().parents[2] / "bench/warm3d_friction.hvi"
    path.write_text(bench.read_text().replace("param n = 4", f"param n = {n}").replace("param N = 4", f"param N = {steps}"))
    return path


def several(program, folder, ranks, judge):
    """What eliminates one unknown from another one reads rows of other processes: without these it takes three times the iterations."""
    path = warm(folder, 9, 2)
    alone = run(program, path, folder, 1)[1]["plan"]["iterations"]
    for n in ranks:
        times = run(program, path, folder, n)[1]["plan"]["iterations"] / alone
        judge(times <= MORE, f"a larger body, of two unknowns, with {n} processes: {times:.2f} times the iterations of one")


def chosen(program, folder, judge):
    """Iterations that `automatic` takes are those of all processes, and one process has the same matrices."""
    path = warm(folder, 18, 1)
    answers = [iterative.run(program, path, folder, "automatic", processes=n)[1] for n in (1, 2)]
    plans = [answer["plan"] for answer in answers]
    judge([plan["solver"] for plan in plans] == ["iterative"] * 2 and plans[1]["assembled_by"] == 2 and plans[0]["matrices"] == plans[1]["matrices"],
          f"`automatic` takes iterations, {plans[1].get('assembled_by')} processes assemble {plans[1]['matrices']} matrices")
    difference, column = iterative.apart(*answers)
    judge(difference <= iterative.AGREE, f"`automatic` with two processes: {column} apart by {difference:.1e}")


def larger(program, folder, options):
    """Bodies of 4,000 to 8,000 unknowns: the same bits, iterations, what is sent, and what another process is told to hold."""
    wrong = []

    def judge(good, words):
        print(f"{'ok   ' if good else 'FAILS'} {words}", flush=True)
        if not good:
            wrong.append(words)

    for name, text in BODIES.items():
        path = folder / "body.hvi"
        path.write_text(text)
        alone = run(program, path, folder, 1)[1]["plan"]["iterations"]
        for n in options.ranks:
            of = f"a larger body, {name}, with {n} processes"
            runs = [run(program, path, folder, n) for _ in range(REPEATED.get(n, OTHERWISE))]
            failed = [done.stderr[-600:] for done, _ in runs if done.returncode != 0]
            judge(not failed, "\n".join([f"{of}: {len(failed)} of {len(runs)} runs fail", *failed[:1]]))
            if failed:
                continue
            answers = [answer for _, answer in runs]
            judge(fits("result", answers[0]), f"{of}: the JSON has its schema")
            judge(all(answer["table"] == answers[0]["table"] for answer in answers), f"{of}: the same bits each time")
            times = answers[0]["plan"]["iterations"] / alone
            judge(times <= MORE, f"{of}: {times:.2f} times the iterations of one")
            sent, all_of = answers[0]["plan"]["communication"], answers[0]["plan"]["iterations"]
            judge(2 * all_of < sent["reductions"] < 4 * all_of and sent["messages"] > 10 * all_of and sent["bytes"] > 100 * sent["messages"],
                  f"{of}: an iteration sends {sent['messages'] / all_of:.0f} messages, {sent['reductions'] / all_of:.1f} reductions")
            rows = [level["rows"] for level in answers[0]["plan"]["multigrid"]]
            judge(rows == sorted(rows, reverse=True) and rows[0] >= answers[0]["unknowns"], f"{of}: levels of {rows}")
            held = answers[0]["plan"]["bytes_of_others"]  # its part, and PETSc
            judge(2e7 < held < 2e8, f"{of}: another process holds {held / 1e6:.0f} MB")
    foretold(program, path, judge)
    several(program, folder, options.ranks, judge)
    if 2 in options.ranks:
        chosen(program, folder, judge)
    return bool(wrong)


LONG = """mesh body = rectangle(2, 1, cells = [{n}, {n}])
part roof = body.top
part ground = body.bottom
tensor A = isotropic(young = 5, poisson = 0.3)
tensor B = isotropic(young = 50, poisson = 0.3)
superpotential layer(r) with slope 100*max(r, 0)
space V = vector P1 on body, zero on roof
find u in V for t in [0, 1] by {steps} steps from u = [0, 0]
such that for all v in V
    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
    >= integral(body, dot([t, -3*t], v))
report
  table u_y = u.y at [1, 0]
"""


class Endings:
    """Runs that end in other ways than with an answer."""

    def __init__(self, program, folder):
        self.program, self.folder, self.wrong, self.launcher = program, folder, [], iterative.launcher(2)

    def judge(self, name, good, *shown):
        print(f"{'ok   ' if good else 'FAILS'} {name}", flush=True)
        if not good:
            print(*shown, sep="\n")
            self.wrong.append(name)

    def script(self, text):
        path = self.folder / "case.hvi"
        path.write_text(text)
        return path

    def ends(self, name, text, code, *words, arguments=("--solver", "iterative"), once="", **environment):
        """This exit code within the time, these words on stderr, and `once` there once only."""
        done = subprocess.run([*self.launcher, self.program, "run", self.script(text), "--quiet", "--no-files", *arguments],
                              cwd=self.folder, capture_output=True, text=True, timeout=SOON,
                              env={**os.environ, **environment})
        good = done.returncode == code and all(word in done.stderr for word in words)
        self.judge(f"{name}: exit code {done.returncode}", good and (not once or done.stderr.count(once) == 1),
                   done.stdout, done.stderr)

    def begin(self, text, *arguments):
        """A run of two processes, in a session of its own; the ids of its processes."""
        path = self.script(text)
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        run = subprocess.Popen([*self.launcher, self.program, "run", path, "--solver", "iterative", "-o", "out", *arguments],
                               cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               start_new_session=True)
        begin, ids = time.monotonic(), {}
        while len(ids) < 2 and time.monotonic() - begin < SOON and run.poll() is None:
            time.sleep(0.05)
            ids = {rank: child for child in children(run.pid) if (rank := rank_of(child)) is not None}
        return run, ids

    def start(self, *arguments):
        """The same of a long run, some steps on its way."""
        begin = time.monotonic()
        run, ids = self.begin(LONG.format(n=24, steps=100000), *arguments)
        while not self.saved() and time.monotonic() - begin < SOON and run.poll() is None:
            time.sleep(0.05)
        return run, ids

    def saved(self):
        return any(self.saved_files())

    def saved_files(self):
        return [path for path in self.folder.glob("out/*") if path.suffix == ".checkpoint" and path.stat().st_size > 0]

    def stopped(self, name, stop, codes, *words):
        """`stop` is given the run and the ids of its processes."""
        run, ids = self.start("--checkpoint", "1")
        if len(ids) < 2:
            run.kill()
            return self.judge(name + ": does not start", False, *run.communicate())
        stop(run, ids)
        try:
            out, errors = run.communicate(timeout=SOON)
        except subprocess.TimeoutExpired:
            run.kill()
            return self.judge(name + ": hangs", False)
        end = time.monotonic() + 10.0  # mpirun kills the others and may end before they are gone
        while any(map(alive, ids.values())) and time.monotonic() < end:
            time.sleep(0.05)
        left = [rank for rank, child in ids.items() if alive(child)]
        good = run.returncode in codes and all(word in errors for word in words) and not left and self.saved()
        self.judge(f"{name}: exit code {run.returncode}", good, f"processes that are left: {left}", out[-2000:], errors)

    def stopped_within_a_solve(self):
        """The only step is a thousand iterations, whose end would be E0701."""
        hard = iterative.HARD.format(poisson=0.49999999).replace("P1", "P2").replace("[6, 3, 3]", "[30, 14, 14]")
        run, ids = self.begin(hard)
        time.sleep(6)
        os.kill(ids[0], signal.SIGINT)
        out, errors = run.communicate(timeout=SOON)
        self.judge(f"Ctrl-C within a solve: exit code {run.returncode}", run.returncode == 130 and "E0703" in errors, out, errors)

    def all(self):
        hard = iterative.HARD
        self.ends("a missing module", hard.format(poisson=0.3), 1, "E0601", "libpetsc-real-dev", once="error[",
                  HVI_PETSC_MODULE="/nowhere/module.so")
        _, found = run(self.program, self.script(hard.format(poisson=0.3)), self.folder, 1)  # skips the rest without PETSc
        self.ends("an answer", hard.format(poisson=0.3), 0)
        self.ends("a mistake in the script", hard.format(poisson=0.3).replace("on body, zero", "on bodi, zero"), 1, "E0",
                  once="error[")
        self.ends("a word that is none", hard.format(poisson=0.3), 2, arguments=("--solver", "multigrid"))
        self.ends("the direct solver", hard.format(poisson=0.3), 0, "1 of 2 processes had nothing to do", arguments=("--solver", "direct"))
        self.launcher = []
        self.ends("another MPI", hard.format(poisson=0.3), 3, "the launcher has started 3 processes, and MPI finds 1", once="error[",
                  PMI_RANK="0", PMI_SIZE="3")
        self.launcher = iterative.launcher(2)
        self.ends("stagnation", hard.format(poisson=0.49999999).replace("P1", "P2"), 3, "the most iterations were reached", "E0701")
        self.stopped("a killed worker", lambda run, ids: os.kill(ids[1], signal.SIGKILL), (137,), "signal 9")
        self.stopped("a killed first process", lambda run, ids: os.kill(ids[0], signal.SIGKILL), (137,), "signal 9")
        self.stopped("Ctrl-C for the first process", lambda run, ids: os.kill(ids[0], signal.SIGINT), (130,), "E0703")
        self.stopped_within_a_solve()
        # After a second mpirun kills what has not ended by itself, also before it has said so.
        self.stopped("Ctrl-C for mpirun", lambda run, ids: run.send_signal(signal.SIGINT), (1, 130, 137))
        return self.wrong


def children(pid):
    """Of a process, and theirs."""
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True).stdout.split()
    return [int(child) for child in found] + [each for child in found for each in children(child)]


def rank_of(pid):
    """Of a process of hvi-run; None: it is none."""
    try:
        if "hvi-run" not in pathlib.Path(f"/proc/{pid}/comm").read_text():
            return None
        for word in pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0"):
            if word.startswith(b"OMPI_COMM_WORLD_RANK="):
                return int(word.split(b"=")[1])
    except OSError:
        pass
    return None


def alive(pid):
    try:
        return "\nState:\tZ" not in pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ranks", type=lambda text: [int(n) for n in text.split(",")], default=[2, 3])
    parser.add_argument("--only")
    parser.add_argument("--endings", action="store_true")
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        if options.endings:
            sys.exit(bool(Endings(program, folder).all()))
        sys.exit(scenes(program, folder, options) | larger(program, folder, options))


if __name__ == "__main__":
    main()
