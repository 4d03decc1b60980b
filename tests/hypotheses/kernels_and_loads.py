"""What `hvi-run check` says about kernels and loads in time, on random ones. Usage: kernels_and_loads.py HVI_RUN

References are analytic: |t - c|^-a is square integrable when a < 1/2; a kernel that jumps, or is a root of the lag, is
not Lipschitz in t; c exp(-lag/tau) has the constant c/tau; after a jump the modulus is 1 + int q.
"""
import json
import random
import subprocess
import sys
import tempfile

SCRIPT = """mesh bar = interval(1, cells = 4)
part left = bar.left
kernel q({lag}) = {kernel}
space V = scalar P1 on bar, zero on left
find u in V for t in [{t0}, {t1}] by 8 steps from u = 0 using load = average
such that for all v in V
    integral(bar, dot(grad(u'), grad(v))) + integral(bar, dot(grad(u), grad(v)))
  + integral(bar, dot(history(q, grad(u)), grad(v)))
  = integral(bar, ({load})*v)
report
  table m = u at [1]
"""


def rows(kernel="-0.1*exp(-lag)", load="1", lag="lag", t0=0.0, t1=1.0):
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(SCRIPT.format(kernel=kernel, load=load, lag=lag, t0=t0, t1=t1)), file.flush()
        done = subprocess.run([sys.argv[1], "check", file.name, "--json", "-"], capture_output=True, text=True)
    assert done.returncode == 0, (kernel, load, done.stderr)
    return json.loads(done.stdout)["hypotheses"]


def row(name, start="", **given):
    found = [r for r in rows(**given) if r["name"] == name and start in r["bound"]]
    assert len(found) <= 1, found
    return found[0] if found else None


GIVEN = """mesh bar = rectangle(1, 1, cells = [4, 2])
part left = bar.left
part low = bar.bottom
superpotential layer(r) = 20*pos(r)^2
space V = scalar P1 on bar, zero on left
find u in V with u = {value} on left for t in [0, 1] by 8 steps from u = 0
such that for all v in V
    integral(bar, dot(grad(u'), grad(v))) + integral(bar, dot(grad(u), grad(v))) + integral(low, layer^0(u - {offset}; v))
 >= integral(bar, v)
report
  table m = u at [1, 0]
"""


def given():
    """What a run says of an offset or an imposed value that is no number at a later time, `check` says, too."""
    for value, offset, bad in (("0", "0.1*sqrt(0.5 - t)", True), ("0", "log(1 - t + x)", True), ("sqrt(0.7 - t) - sqrt(0.7)", "0.1*t", True),
                               ("t/(y + 1 - t)", "0", True), ("t", "0.1*sqrt(1 - t)", False), ("0", "x*t", False)):
        with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
            file.write(GIVEN.format(value=value, offset=offset)), file.flush()
            checked = subprocess.run([sys.argv[1], "check", file.name, "--json", "-"], capture_output=True, text=True)
            done = subprocess.run([sys.argv[1], "run", file.name, "--no-files", "--diagnostics", "json"], capture_output=True, text=True)
        assert checked.returncode == 0, checked.stderr
        ours = [r for r in json.loads(checked.stdout)["hypotheses"] if r["name"] == "given"]
        said = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
        wrong = [d["message"] for d in said if d["severity"] == "error"]
        assert [r["note"] for r in ours] == wrong and all(r["holds"] is False for r in ours), (value, offset, ours, wrong)
        assert bool(ours) == bad, (value, offset, ours)


def main():
    given()
    rng = random.Random(4)
    for _ in range(12):
        a = rng.choice([rng.uniform(0.05, 0.45), rng.uniform(0.55, 0.95)])
        t0 = rng.choice([0.0, -2.0, 3.0])
        c = t0 + rng.choice([0.0, 1.0, rng.uniform(0.1, 0.9)])
        load = f"2 + abs(t - {c!r})^(-{a!r})*cos(t)"
        found = row("H(f)", load=load, t0=t0, t1=t0 + 1)
        assert found["holds"] is (a < 0.5), (load, found)
    assert row("H(f)", load="1/(t + 5)")["holds"]  # bounded on the time of the run
    assert row("H(f)", load="log(abs(t - 0.3))")["holds"]

    for _ in range(12):
        size, tau, at = rng.uniform(0.05, 0.2), rng.uniform(0.2, 3), rng.uniform(0.1, 0.9)
        found = row("H(q)", kernel=f"-{size!r}*exp(-lag/{tau!r})")
        assert abs(found["value"] - 1 / tau) <= 1e-9 * found["value"], found
        for kernel in (f"(| lag < {at!r} -> -{size!r} | otherwise -> 0)", f"-{size!r}*sqrt(lag)",
                       f"-{size!r}*abs(lag - {at!r})^0.6", f"-{size!r}*lag^(-0.3)"):
            found = row("H(q)", kernel=kernel)
            assert found["holds"] is False, (kernel, found)
        width = 10 ** rng.uniform(-5, -0.7)
        for of in ("t - s", "t", "s"):
            window = f"(| {of} < {at!r} -> 0 | {of} < {at + width!r} -> -{size!r} | otherwise -> 0)"
            found = row("H(q)", kernel=window, lag="t, s")
            assert found["holds"] is (of == "s"), (window, found)
        kink = row("H(q)", kernel=f"-{size!r}*abs(lag - {at!r})")
        assert kink["holds"] and abs(kink["value"] - 1) <= 1e-6, kink

    assert row("memory") is None
    prony = row("memory", "relaxes", kernel="0.3*exp(-lag)")
    assert prony and abs(prony["value"] - (1 + 0.3 * (1 - 0.36787944117144233))) < 1e-6, prony
    for strength, end in ((0.5, 0.9), (0.5, 1.1), (0.2, 6.2), (0.2, 6.4)):
        # 1 - 2 strength sqrt(lag) is positive up to 1/(4 strength^2)
        found = row("memory", "positive modulus", kernel=f"-{strength}*lag^(-0.5)", t1=end)
        assert (found is not None) == (end > 1 / (4 * strength ** 2)), (strength, end, found)


main()
