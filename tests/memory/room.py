"""Predicted memory over what runs take, and runs that do not fit.

usage: room.py HVI_RUN [--all]

Each scene runs three times. Without a limit: its peak of resident memory (getrusage). `plan`: what it predicts. With a
limit on its addresses that it does not fit in: E0607 with a predicted total, what sets the limit and what helps, exit
code 3, before the factor is made or the memories grow; limits that not even the analysis fits in end with E0607 too. Both predictions lie within a factor 1.5 of the peak. `--all`
takes larger scenes and prints the table; no time is judged.
"""
import re
import resource
import subprocess
import sys
import tempfile

BASE = 230e6  # addresses that a program with its libraries takes before it has done anything


def scene(dim, order, n, steps=0, route=None, law=False, tensors=0, friction=False, lopsided=False, singular=False):
    sizes, counts = ", ".join(["1"] * dim), ", ".join([str(n)] * dim)
    lines = [f"mesh body = {'rectangle' if dim == 2 else 'box'}({sizes}, cells = [{counts}])", "part ground = body.bottom",
             "part roof = body.top", "tensor B = isotropic(lambda = 1, mu = 1)"]
    if tensors:
        lines.append(f"tensor A = isotropic(lambda = {1 if tensors == 1 else 3}, mu = 1)")
    if route:
        lines.append("kernel C(lag) = -0.1*" + ("lag^(-0.5)" if singular else "1/(1 + lag)") + " * B")
    if law:
        lines.append("superpotential soft(r) with slope\n  | r < 0 -> 0\n  | otherwise -> 10*r")
    if friction:
        lines.append("superpotential slip(xi) = 0.01*norm(xi)")
    lines.append(f"space V = vector P{order} on body, zero on roof")
    lines.append("find u in V" + (f" for t in [0, 1] by {steps} steps from u = 0" if steps else ""))
    if route:
        lines.append(f"using memory = {route}")
    lines.append("such that for all v in V\n    integral(body, B : eps(u) : eps(v))")
    if tensors:
        lines.append("  + integral(body, A : eps(u') : eps(v))")
    if route:
        lines.append("  + integral(body, history(C, eps(u)) : eps(v))")
    if lopsided:
        lines.append("  + integral(body, 0.1*u.x*v.y)")
    if law:
        lines.append("  + integral(ground, soft^0(u.nu; v.nu))")
    if friction:
        lines.append("  + integral(ground, slip^0(u.tau; v.tau))")
    down = "[0, -1]" if dim == 2 else "[0, -1, 0]"
    lines.append(f"{' >=' if law or friction else '  ='} integral(body, dot({down}, v))")
    lines.append("report\n  table size = norm(u)" + (" at t = 1" if steps else ""))
    return "\n".join(lines) + "\n"


def several(n, pressure):
    """A displacement with the pressure of an incompressible body, or with heat."""
    own = "" if pressure else " + integral(body, dot(grad(p), grad(q)))"
    return f"""mesh body = rectangle(1, 1, cells = [{n}, {n}])
part roof = body.top
space V = vector P2 on body, zero on roof
space Q = scalar P1 on body{"" if pressure else ", zero on roof"}
find u in V, p in Q
such that for all v in V, q in Q
    integral(body, 2*(eps(u) : eps(v)) - p*div(v)) + integral(body, q*div(u)){own}
  = integral(body, v.x)
report
  table size = norm(u)
"""


SMALL = {
    "3D P1, n 18": scene(3, 1, 18),
    "3D P2, n 8": scene(3, 2, 8),
    "2D P2, n 90": scene(2, 2, 90),
    "2D P1, n 110, not symmetric": scene(2, 1, 110, lopsided=True),
    "2D P2 and P1, n 70, pressure": several(70, True),
    "2D P2 and P1, n 80, heat": several(80, False),
    "3D P1, n 20, friction, 6 steps": scene(3, 1, 20, 6, law=True, friction=True, tensors=1),
    "2D P1, n 70, direct, 600 steps": scene(2, 1, 70, 600, "direct", tensors=1),
}
LARGE = SMALL | {
    "3D P1, n 30": scene(3, 1, 30),
    "3D P2, n 14": scene(3, 2, 14),
    "2D P1, n 400": scene(2, 1, 400),
    "2D P2, n 250": scene(2, 2, 250),
    "2D P1, n 200, two tensors, 40 steps": scene(2, 1, 200, 40, tensors=2),
    "3D P1, n 18, not symmetric": scene(3, 1, 18, lopsided=True),
    "3D P1, n 24, law, 30 steps": scene(3, 1, 24, 30, law=True, tensors=1),
    "3D P1, n 22, friction, 10 steps": scene(3, 1, 22, 10, law=True, friction=True, tensors=1),
    "2D P1, n 60, direct, 1500 steps": scene(2, 1, 60, 1500, "direct", tensors=1),
    "2D P1, n 60, direct, law, 1500 steps": scene(2, 1, 60, 1500, "direct", tensors=2, law=True),
    "2D P1, n 150, tree, 2000 steps": scene(2, 1, 150, 2000, "tree", tensors=2, singular=True),
    "2D P1, n 150, fit, 500 steps": scene(2, 1, 150, 500, "fit", tensors=2),
    "3D P1, n 12, direct, 500 steps": scene(3, 1, 12, 500, "direct", tensors=2),
}
UNITS = {"MB": 1e6, "GB": 1e9}


def call(program, command, limit=None):
    """The finished process and its peak in bytes."""
    def limited():
        if limit:
            resource.setrlimit(resource.RLIMIT_AS, (int(limit), int(limit)))

    # A process of its own in between, so that the peak is that of this run.
    code = ("import resource, subprocess, sys\n"
            "done = subprocess.run(sys.argv[1:])\n"
            "print('PEAK', resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024, file=sys.stderr)\n"
            "sys.exit(done.returncode)")
    done = subprocess.run([sys.executable, "-c", code, program, command, "scene.hvi", "--solver", "direct",
                           *(["--no-files"] if command == "run" else [])],
                          capture_output=True, text=True, preexec_fn=limited)
    return done, float(re.search(r"PEAK (\d+)", done.stderr)[1])


def size(text, pattern):
    found = re.search(pattern + r" ([\d.e+]+) (MB|GB)", text)
    return float(found[1]) * UNITS[found[2]] if found else None


def main():
    program, table = sys.argv[1], "--all" in sys.argv
    faults = 0
    if table:
        print(f"{'scene':40}{'peak MB':>9}{'plan':>7}{'E0607':>7}")
    with tempfile.TemporaryDirectory() as folder:
        import os
        os.chdir(folder)
        for name, text in (LARGE if table else SMALL).items():
            open("scene.hvi", "w").write(text)
            done, peak = call(program, "run")
            planned = size(call(program, "plan")[0].stdout, "memory:")
            wrong, said = [], None
            # Somewhere between, the matrices and their order of elimination fit, and the factor or the memories do not.
            # With a pressure, MUMPS must not take another order where there is hardly room to find one.
            for part in [0.4 + 0.03 * i for i in range(16)] if "pressure" in name else (0.4, 0.55, 0.7, 0.85):
                refused, _ = call(program, "run", BASE + part * peak)
                if refused.returncode not in (0, 3) or refused.returncode == 3 and "E0607" not in refused.stderr:
                    wrong.append(f"limit {part}: exit code {refused.returncode}: {refused.stderr[:300]}")
                said = size(refused.stderr, "needs about")
                if said is not None and ("pressure" not in name or not 1 / 1.5 <= said / peak <= 1.5):
                    break
            plan_too, _ = call(program, "plan", BASE + part * peak)
            if done.returncode != 0:
                wrong.append(f"exit code {done.returncode}: {done.stderr[:300]}")
            for what, bytes_ in (("plan", planned), ("E0607", said)):
                if bytes_ is None or not 1 / 1.5 <= bytes_ / peak <= 1.5:
                    wrong.append(f"{what}: {bytes_} of {peak}")
            for which in (refused, plan_too):
                if which.returncode != 3 or "E0607" not in which.stderr or "ulimit -v" not in which.stderr \
                        or "= help" not in which.stderr:
                    wrong.append(f"with a limit: exit code {which.returncode}: {which.stderr[:400]}")
            if table or wrong:
                ratio = lambda b: "none" if b is None else f"{b / peak:.2f}"
                print(f"{name:40}{peak / 1e6:9.0f}{ratio(planned):>7}{ratio(said):>7}", *wrong, flush=True)
            faults += len(wrong)
    print(f"{faults} faults")
    sys.exit(faults > 0)


main()
