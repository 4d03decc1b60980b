"""A million steps of a problem with one unknown: no drift off the closed form, memory constant.

usage: million.py HVI_RUN solid|fractional
solid: u' + u - int_0^t 2 exp(-2 (t - s)) u(s) ds / 2 = 1, whose closed form is that of a 2 x 2 linear
system. fractional: u + int_0^t (t - s)^(-1/2) / Gamma(1/2) u(s) ds = 1, u = E_{1/2}(-sqrt(t)) =
exp(t) erfc(sqrt(t)). Reference: analytic.
"""
import json
import math
import pathlib
import resource
import subprocess
import sys
import tempfile

SCRIPT = """
param N = 1000000 in [1, 10000000]
mesh bar  = interval(1, cells = 1)
part left = bar.left
{kernel}
space V = scalar P1 on bar, zero on left
find p in V for t in [0, {end}] by N steps from p = {initial} {using}
such that for all q in V
    {terms}
  + integral(bar, dot(history(C, grad(p)), grad(q)))
  = integral(bar, dot([1], grad(q)))
report
  table value = p at [1] every 10000 steps
"""


def solid(t):
    """u' = -u + w + 1, w' = -2 w + u; u(0) = w(0) = 0."""
    root = math.sqrt(5)
    fast, slow = (-3 - root) / 2, (-3 + root) / 2
    # u = 2 + a e^{slow t} + b e^{fast t}, u(0) = 0, u'(0) = 1
    a = (1 + 2 * fast) / (slow - fast)
    return 2 + a * math.exp(slow * t) + (-2 - a) * math.exp(fast * t)


def fractional(t):
    return math.exp(t) * math.erfc(math.sqrt(t))


CASES = {
    "solid": ({"kernel": "kernel C(lag) = -exp(-2*lag)", "end": 20, "initial": 0, "using": "using scheme = bdf2",
               "terms": "integral(bar, dot(grad(p'), grad(q))) + integral(bar, dot(grad(p), grad(q)))"},
              solid, 1e-9),
    "fractional": ({"kernel": "kernel C(lag) = lag^(-0.5) / gamma(0.5)", "end": 2, "initial": 0, "using": "",
                    "terms": "integral(bar, dot(grad(p), grad(q)))"}, fractional, 2e-6),
}


def run(program, folder, case, steps):
    script, result = pathlib.Path(folder) / "long.hvi", pathlib.Path(folder) / "result.json"
    script.write_text(SCRIPT.format(**case))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, script, "--quiet", "--json", result, "-o", folder, "-D", f"N={steps}"], check=True,
                   stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return json.loads(result.read_text()), after.ru_maxrss * 1024, after.ru_utime - before.ru_utime


def main():
    program, name = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    case, exact, allowed = CASES[name]
    with tempfile.TemporaryDirectory() as folder:
        short, peak_short, _ = run(program, folder, case, 200000)
        long, peak_long, seconds = run(program, folder, case, 1000000)
    rows = list(zip(long["table"]["t"], long["table"]["value"]))
    errors = [abs(value - exact(t)) for t, value in rows]
    fields = [r["plan"]["history"][0]["fields"] for r in (short, long)]
    growth = (peak_long - peak_short) / 800000
    print(f"peak {peak_short / 1e6:.0f} MB with 200,000 steps, {peak_long / 1e6:.0f} MB with 1,000,000")
    print(f"{name}: {len(rows)} rows, largest error {max(errors):.2e}, at the end {errors[-1]:.2e}; "
          f"fields {fields[0]} and {fields[1]}, {growth:.0f} bytes more a step, {seconds:.1f} s, "
          f"audit {long['plan']['history'][0]['audit']:.1e}")
    # A grid time, its length and a few numbers more a step, but no field and no replayed unknown.
    if max(errors) > allowed or errors[-1] > allowed or abs(fields[0] - fields[1]) > 8 or growth > 64:
        sys.exit("drift, or memory that grows")


main()
