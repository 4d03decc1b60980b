"""Codes that no script alone gives: options, files of the system, tolerances out of reach, interruptions.  usage: codes.py HVI_RUN SLAB"""
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

failures = []

# The corner of the ground is moved down, through the obstacle or not.
THROUGH = """
mesh body = rectangle(1, 1, cells = [2, 2])
part left = body.left
part ground = body.bottom
tensor B = isotropic(young = 10, poisson = 0.3)
superpotential wall(r) with slope | r <= 0 -> 0 | otherwise -> 1e300
space V = vector P1 on body, zero on left
find u in V with u = [0, -0.1*t] on left for t in [0, 1] by 2 steps
such that for all v in V
    integral(body, B : eps(u) : eps(v))
  + integral(ground, wall^0(u.nu - {gap}; v.nu))
 >= integral(body, dot([0, -1], v))
report
  table a = u.y at [1, 0]
"""


def check(what, good, shown):
    print(f"{'ok   ' if good else 'FAILS'} {what}")
    if not good:
        failures.append(what)
        print(shown)


def told(done, code, exit_code, *words):
    return done.returncode == exit_code and f"error[{code}]" in done.stderr and all(word in done.stderr for word in words)


def main():
    program, slab = sys.argv[1], pathlib.Path(sys.argv[2]).read_text()
    with tempfile.TemporaryDirectory() as folder:
        def call(*arguments):
            return subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True)

        def write(name, text):
            (pathlib.Path(folder) / name).write_text(text)

        write("slab.hvi", slab)
        for command, exit_code in (("check", 1), ("run", 1), ("plan", 1), ("params", 1), ("test", 5)):
            done = call(command, "slab.hvi", "-D", "cells=3")
            check(f"{command}: E0320 of an unknown parameter", told(done, "E0320", exit_code, "`cells`"), done)
            done = call(command, "slab.hvi", "-D", "n=banana")
            check(f"{command}: E0321 of what is no number", told(done, "E0321", exit_code, "`banana`"), done)
        done = call("check", "slab.hvi", "-D", "n=7 MPa")
        check("a unit without brackets", told(done, "E0321", 1, "a unit stands in brackets: 7[MPa]"), done)

        done = call("run", "slab.hvi", "--no-files", "--accuracy", "1e-2", "--of", "nothing")
        check("the columns whose accuracy can be asked for", told(done, "E0423", 1, "has: u_y, u_x, strain, reaction\n"), done)
        write("old.msh", "$MeshFormat\n1 0 8\n$EndMeshFormat\n")
        write("old.hvi", slab.replace("rectangle(2, 1, cells = [2*n, n])", 'gmsh("old.msh")'))
        write("short.csv", "0,1\n1\n")
        write("short.hvi", slab.replace("[0, -10*t]", '[0, -table("short.csv", t)]'))
        for name, code, file in (("old.hvi", "E0603", "old.msh"), ("short.hvi", "E0605", "short.csv")):
            done = call("check", name)
            said = done.stderr.split("\n")[0]
            check(f"{code} names its file once", told(done, code, 1) and said.count(file) == 1, done)

        # A file of the system that has no size and refuses to be read is no empty script.
        for command in ("check", "run", "fmt"):
            done = call(command, "/proc/self/mem")
            check(f"{command}: E0601 and the system's reason", told(done, "E0601", 1, "Input/output error"), done)
        write("strict.hvi", slab.replace("from u = 0\n", "from u = 0 using tolerance = 1e-30\n"))
        done = call("run", "strict.hvi", "-D", "n=4", "-D", "N=4", "-o", "strict")
        check("a tolerance below rounding: E0701, exit code 3", told(done, "E0701", 3, "step 1", "tolerance 1e-30"), done)
        table = pathlib.Path(folder) / "strict" / "strict.csv"
        check("no row of the step without a certificate", not table.exists() or "\n0.25" not in table.read_text(), done)

        for gap, allowed in ((0.2, True), (0.06, False)):
            write("through.hvi", THROUGH.format(gap=gap))
            done = call("run", "through.hvi", "--no-files")
            good = done.returncode == 0 if allowed else told(done, "E0701", 3, "t = 1", "imposed values", "`wall` to 0.04")
            check(f"imposed values and an obstacle, gap {gap}", good, done)

        for option in (("--of", "reaction"), ("--as-written",), ("--budget", "5")):
            done = call("run", "slab.hvi", "-D", "n=2", "-D", "N=4", "--no-files", *option)
            check(f"{option[0]} without an accuracy", done.returncode == 2 and f"{option[0]} goes with --accuracy" in done.stderr, done)
        write("threads.hvi", slab.replace("from u = 0\n", "from u = 0 using threads = 3\n"))
        for words, threads in (((), 3), (("--threads", "2"), 2)):
            done = call("dump", "--plan", "threads.hvi", *words)
            check(f"threads of the script with {words}", f", threads {threads}\n" in done.stdout, done)
        timed = "expect u_y at t = 0.5 = 9 within 1e-9\n"
        write("timed.hvi", slab + timed)
        done = call("test", "timed.hvi", "-D", "n=2", "-D", "N=4")
        check("the time of an expectation is said", done.returncode == 5 and "FAIL u_y at t = 0.5 = -0.01" in done.stdout, done)
        write("bounds.hvi", slab.replace("report\n", "report table whole = 1 + x at [1, 0], below = -1 - 2*x at [0, 0]\nreport\n", 1)
              + "expect whole = 2 within 0\nexpect below = -2 within 0.5 relative\n")
        done = call("test", "bounds.hvi", "-D", "n=8", "-D", "n=2", "-D", "N=4")
        check("tolerances of nothing, and of what is below 0, with both ends", "ok   whole" in done.stdout and "ok   below" in done.stdout, done)
        done = call("params", "slab.hvi", "-D", "n=8", "-D", "n=2")
        check("of one name the last value counts", done.returncode == 0 and "n = 2" in done.stdout.replace("  ", " ") and "n = 8" not in done.stdout, done)
        write("parts.hvi", slab.replace("report\n", "report table force = reaction(roof)\nreport\n") + timed.replace("u_y at t = 0.5", "force"))
        done = call("test", "parts.hvi")
        check("a column that is a vector: E0319 names the first component", "its first column is `force_x`" in done.stderr, done)
        write("ramp.csv", "t,force\n0,0\n1,2\n")
        for column in ("table(\"ramp.csv\", t + 0.6)", "table(\"ramp.csv\", t + 0.6) at [1, 0]", "integral(slab, table(\"ramp.csv\", x))",
                       "1 + largest(slab, table(\"ramp.csv\", x))", "table(\"ramp.csv\", 4*t) at [1, 0] at t = 0.75"):
            write("column.hvi", slab.replace("report\n", f"report table late = {column}\nreport\n"))
            done = call("run", "column.hvi", "-D", "n=2", "-D", "N=4", "--no-files")
            check(f"a table outside its range: {column}", told(done, "E0423", 1, "`ramp.csv` outside its range [0, 1]"), done)
        shown = {"line {}, u.y from [0, 0] to [2, 0] by 5 points": "u.y*table(\"ramp.csv\", x)", "line u.y, {} from [0, 0] to [2, 0] by 5 points at t = 0.75": "table(\"ramp.csv\", 1.5*t)*u",
                 "fields {}": "table(\"ramp.csv\", x)*u", "fields u, {} every 2 steps": "sigma*table(\"ramp.csv\", x)", "fields {} from start": "table(\"ramp.csv\", t - 0.1)*u.x",
                 "picture {} to \"a.svg\"": "table(\"ramp.csv\", t + x)*u.x", "picture u.x, {} at t = [0.1, 0.75] to \"a.svg\"": "table(\"ramp.csv\", 1.5*t)*sigma.xx"}
        for item, wrong in shown.items():
            inside = re.sub(r"\"ramp.csv\", (.*?)\)", r'"ramp.csv", max(0, min(\1, 1)))', wrong)
            for field, range_ in ((wrong, 1), (inside, 0)):
                write("shown.hvi", slab.replace("report\n", f"report {item.format(field)}\nreport\n"))
                done = call("run", "shown.hvi", "-D", "n=2", "-D", "N=4", "-o", "shown")
                check(f"a table outside its range, shown: {item.format(field)}", told(done, "E0423", 1, "`ramp.csv` outside its range [0, 1]") if range_ else done.returncode == 0, done)
        # Where the table is not asked for, or the mesh has no such place, its range does not matter.
        for item in ("line (| x < 1 -> table(\"ramp.csv\", x) | otherwise -> 0)*u.x from [0, 0] to [2, 0] by 5 points", "fields (| x < 1 -> table(\"ramp.csv\", x) | otherwise -> 0)*u",
                     "line table(\"ramp.csv\", x)*u.x from [0, 0.5] to [-2, 0.5] by 5 points"):
            write("shown.hvi", slab.replace("report\n", f"report {item}\nreport\n"))
            done = call("run", "shown.hvi", "-D", "n=2", "-D", "N=4", "-o", "shown")
            check(f"a table within its range, shown: {item}", done.returncode == 0, done)
        for column, where in (("1/(t - 0.5)", "step 2 (t = 0.5): `late` has no finite value in this row"),
                              ("sqrt(u.x - 1) at [1, 0]", "`late` has no finite value in 4 rows"), ("table(\"ramp.csv\", t)", None)):
            write("column.hvi", slab.replace("report\n", f"report table late = {column}\nreport\n"))
            done = call("run", "column.hvi", "-D", "n=2", "-D", "N=4", "--no-files")
            said = where in done.stdout if where else "finite" not in done.stdout
            check(f"a value that is no number: {column}", done.returncode == 0 and said, done)

        command = [program, "run", "slab.hvi", "-D", "n=8", "-D", "N=1000000", "-o", "long", "--checkpoint", "50"]
        saved = pathlib.Path(folder) / "long" / "slab.checkpoint"  # its temporary file is there before the run begins
        with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            while process.poll() is None and not saved.exists():
                time.sleep(0.01)
            process.send_signal(signal.SIGINT)
            out, err = process.communicate()
        check("an interruption: E0703, exit code 130", process.returncode == 130 and "error[E0703]" in err, (process.returncode, out, err))
        check("it says how to go on", "--resume" in err, err)
    print(f"{len(failures)} failures")
    sys.exit(bool(failures))


main()
