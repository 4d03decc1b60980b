#!/usr/bin/env python3
"""Every command and every kind of argument with laws on the rate: figures that are known by other means.

usage: rates.py HVI_RUN ROOT

Script: tests/convergence/rates.hvi, a manufactured solution (analytic) with a law on u, one on u' and memory; a bar of one
unknown, whose steps are written out here (independent), and the spring and slider of published/stick_slip.hvi.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import jsonschema

PROGRAM, ROOT = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2])
SOLID = (ROOT / "tests/convergence/rates.hvi").read_text()
NORM = ("report\n  table ", "report\n  table strain = norm(u), ")
failed = []


def check(what, good, shown=""):
    print(f"{'ok    ' if good else 'FAILED'} {what}: {shown}")
    if not good:
        failed.append(what)


def call(folder, command, text, *words, code=0, name="scene"):
    (folder / f"{name}.hvi").write_text(text)
    out = folder / "out.json"
    out.unlink(missing_ok=True)
    done = subprocess.run([PROGRAM, command, f"{name}.hvi", "--json", "out.json", *words], cwd=folder, capture_output=True,
                          text=True)
    if done.returncode != code:
        sys.exit(f"{command}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout, json.loads(out.read_text()) if out.exists() else None


def run(folder, text, *words):
    return call(folder, "run", text, "--quiet", "-o", "out", *words)[1]


def schema_of(name):
    return json.loads((ROOT / f"docs/schema/hvi-{name}-1.schema.json").read_text())


def accuracy(folder):
    result = run(folder, SOLID.replace(*NORM), "--accuracy", "5e-2")
    reached, table = result["accuracy"], result["table"]
    true = max(table["error"]) / max(table["strain"])
    check("--accuracy 5e-2: the true error, and the estimate", reached["reached"] and true <= 5e-2 and
          true / 2 < reached["estimate"], f"true {true:.2e}, estimated {reached['estimate']:.2e}")


def study(folder):
    text = SOLID + "\nstudy vary n, N in [[8, 8], [16, 16], [32, 32]] against exact w(t)*phi() in V\n"
    _, result = call(folder, "study", text, "-o", "out", "--quiet")
    jsonschema.validate(result, schema_of("study"))
    orders = [row["order"] for row in result["rows"][1:]]
    check("study: order of backward Euler, of the finest rungs", abs(orders[-1] - 1) < 0.1, orders)


def plan(folder):
    """`plan` says before what a run says afterwards."""
    stdout, said = call(folder, "plan", SOLID)
    jsonschema.validate(said, schema_of("plan"))
    done = run(folder, SOLID)["plan"]
    effects = {e["name"]: e["state"] for e in done["effects"]}
    check("plan: the law on the rate is an effect, on", effects.get("law on the rate `slip` on `ground`") == "on" and
          "on       law on the rate `slip` on `ground`" in stdout, [n for n in effects if "rate" in n])
    counts = {what: said["plan"][what] for what in ("matrices", "analyses", "factorisations", "newton")}
    check("plan: what is counted", counts == {what: done[what] for what in counts}, counts)


# int a p' q' + int p_x q_x + law(p'(1)) q(1) = F(t) q(1): p = w x, a w' + w + xi = F.
BAR = """
param N = 40
param a = 0.5
param route = automatic
mesh bar  = interval(1, cells = 1)
part tip  = bar.right
part root = bar.left
kernel C(lag) = -0.4*exp(-lag)
kernel own(lag) = 2*exp(-3*lag)
superpotential drag(r) with slope
{slope}
space V = scalar P1 on bar, zero on root
find p in V for t in [0, 2] by N steps from p = 0 using memory = route
such that for all q in V
    integral(bar, a*dot(grad(p'), grad(q))) + integral(bar, dot(grad(p), grad(q)))
  + integral(bar, dot(history(C, grad(p)), grad(q)))
  + integral(tip, drag^0({argument}; q))
 >= integral(tip, sin(4*t)*q)
report
  table w = p at [1], xi = drag.xi at [1]
"""
WEAKENS = "  | r < 0     -> -0.1 - 0.2*exp(r)\n  | otherwise -> 0.1 + 0.2*exp(-r)"
VALVE = "  | r < 0     -> 0\n  | otherwise -> 3*r"  # it resists one way only
READS = "  | r < 0     -> -0.1 - 0.3*abs(history(own, p))\n  | otherwise -> 0.1 + 0.3*abs(history(own, p))"


def bar(slope, argument="p'"):
    return BAR.format(slope=slope, argument=argument)


def by_hand(law, seen, n=40, a=0.5):
    """w after every step of backward Euler: `law(z, h)` gives the interval of forces, `seen` what z is; by bisection."""
    k, e1, e3 = 2 / n, math.exp(-2 / n), math.exp(-6 / n)
    w = past = own = 0.0
    out = []
    for j in range(1, n + 1):
        def parts(new):
            memory = e1 * past + 0.4 * (1 - e1) * new
            mine = e3 * own + 2 / 3 * (1 - e3) * new
            z = {"rate": (new - w) / k, "memory": mine}[seen]
            low, high = law(z, mine)
            rest = math.sin(4 * j * k) - a * (new - w) / k - new + memory
            return rest, low, high, memory, mine
        left, right = -10.0, 10.0
        for _ in range(200):
            middle = (left + right) / 2
            rest, low, high, *_ = parts(middle)
            if rest > high:
                left = middle
            elif rest < low:
                right = middle
            else:
                break
        # Where it rests the state is the break itself, which bisection reaches to rounding.
        _, _, _, past_new, own_new = parts(middle)
        w, past, own = middle, past_new, own_new
        out.append(w)
    return out


def rub(bound):
    def law(z, h):
        g = bound(abs(z), h)
        return (g, g) if z > 1e-14 else (-g, -g) if z < -1e-14 else (-g, g)
    return law


LAWS = {"scalar problem, a law on p' that weakens": (bar(WEAKENS), rub(lambda r, h: 0.1 + 0.2 * math.exp(-r)), "rate"),
        "scalar problem, a valve": (bar(VALVE), lambda z, h: (3 * max(z, 0),) * 2, "rate"),
        "a law of an integral": (bar(WEAKENS, "history(own, p)"), rub(lambda r, h: 0.1 + 0.2 * math.exp(-r)), "memory"),
        "a memory inside a bound": (bar(READS), rub(lambda r, h: 0.1 + 0.3 * abs(h)), "rate")}


def arguments(folder):
    """All routes of the memory, too."""
    for name, (text, law, seen) in LAWS.items():
        expected = by_hand(law, seen)
        size = max(map(abs, expected))
        for route in ("automatic", "direct", "tree", "fit"):
            table = run(folder, text, "-D", f"route={route}")["table"]
            off = max(abs(x - y) for x, y in zip(table["w"][-40:], expected)) / size
            check(f"{name}, memory = {route}", off <= (1e-12 if route in ("automatic", "direct") else 1e-8), f"{off:.1e}")


def hypotheses(folder):
    """m_A - m_J |M|^2 and the step's margin of the slider (analytic): |M|^2 = 1, K = eta/k + 1."""
    text = (ROOT / "tests/published/stick_slip.hvi").read_text()
    for eta, holds in ((0.02, False), (3.0, True)):
        stdout, _ = call(folder, "check", text, "-D", f"eta={eta}")
        rows = [line.split() for line in stdout.split("\n")]
        line = next(i for i, r in enumerate(rows) if r[:1] == ["rates"])
        own, against = float(rows[line][-4]), float(rows[line + 2][-4])
        step = next(float(r[-4]) for r in rows if " ".join(r).startswith("step 1 - lambda_max"))
        exact = eta - 2.5, 1 - 2.5 / eta, 1 - 2.5 / 0.001 / (eta / 0.001 + 1)
        off = max(abs(x / y - 1) for x, y in zip((own, against, step), exact))
        verdict = ("every step has exactly one solution" if holds else "uniqueness is not guaranteed") in stdout and (
            "the theorem does not apply: the laws on u' soften faster than A" in stdout) != holds
        check(f"check, eta = {eta}: m_A - m_J |M|^2, against A, the step's margin, verdicts", off < 1e-5 and verdict,
              f"off by {off:.1e}, {own} {against} {step}")


def stability(folder):
    stdout, _ = call(folder, "stability", SOLID, "-o", "out")
    check("stability: one solution", "stable: every step has one solution" in stdout,
          next(line for line in stdout.split("\n") if line.startswith("verdict"))[:90])
    slider = (ROOT / "tests/published/stick_slip.hvi").read_text()
    done = run(folder, slider)
    notes = done["notes"]
    snap = next(n for n in notes if n["what"].startswith("snap"))
    check("beyond uniqueness: it is said, and where the branch ends", done["uniqueness"] == "not guaranteed" and
          "uniqueness is not guaranteed" in notes[0]["what"] and "the branch ended at t = 2 (a limit point)" in snap["what"] and
          snap["step"] == 2001, snap["what"][:80])


def main():
    with tempfile.TemporaryDirectory() as name:
        for test in (accuracy, study, plan, arguments, hypotheses, stability):
            folder = pathlib.Path(name) / test.__name__
            folder.mkdir()
            test(folder)
    print("all hold" if not failed else f"{len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
