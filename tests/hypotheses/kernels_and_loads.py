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


MOVING = """mesh slab = rectangle(2, 1, cells = [4, 2])
part roof = slab.top
part ground = slab.bottom
superpotential layer(r) = pos(r)^2
state d on {part} with rate {rate} from d = {start}
space V = vector P1 on slab, zero on roof
find u in V for t in [{t0}, {t1}] by 8 steps from u = 0 using scheme = {scheme}
such that for all v in V
    integral(slab, ({rates})*eps(u') : eps(v)) + integral(slab, ({form})*eps(u) : eps(v)) + integral(ground, layer^0(u.nu - {wear}; v.nu))
 >= integral(slab, dot([1, -2*t], v))
report
  table m = u.y at [1, 0]
"""


def both(**given):
    """Rows `given` of check, and mistakes of a run."""
    text = dict(part="slab", rate="0", start="0", t0=0, t1=1, scheme="backward_euler", rates="1", form="1", wear="0") | given
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(MOVING.format(**text)), file.flush()
        checked = subprocess.run([sys.argv[1], "check", file.name, "--json", "-"], capture_output=True, text=True)
        done = subprocess.run([sys.argv[1], "run", file.name, "--no-files", "--diagnostics", "json"], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stderr
    said = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
    return [r for r in json.loads(checked.stdout)["hypotheses"] if r["name"] == "given"], [d for d in said if d["severity"] == "error"]


def moving():
    """The same of forms that change in time, and of rates of states that read nothing that a run finds: with the place and the time."""
    for bad, given in ((0.75, {"form": "1 + sqrt(0.7 - t)"}), (0.75, {"rates": "sqrt(0.7 - t) + x"}), (0.625, {"form": "1 + 1/(t - 0.625)^2"}),
                       (0.75, {"form": "sqrt(1.2 - t - x/4)"}), (2.5, {"t0": 2, "t1": 3, "form": "3 + log(2.45 - t)/10"}),
                       (0.375, {"rates": "2 + sqrt(0.3 - t)/9", "scheme": "bdf2"}), (0.5, {"rate": "sqrt(0.4 - t)", "form": "2 - d"}),
                       (0.5, {"rate": "1/(t - 0.5)", "form": "2 + d^2"}), (0.125, {"rate": "t*log(1.5 - x)"}),
                       (0.875, {"part": "ground", "rate": "sqrt(0.8 - t)", "wear": "0.01*d"}),
                       (None, {"form": "1 + sqrt(1.01 - t)", "rate": "sqrt(1 - t/2)"}), (None, {"part": "ground", "rate": "t", "wear": "0.1*d"})):
        rows, wrong = both(**given)
        assert [r["note"] for r in rows] == [d["message"] for d in wrong] and all(r["holds"] is False for r in rows), (given, rows, wrong)
        assert bool(rows) == (bad is not None), (given, rows)
        if bad is not None:
            assert wrong[0]["code"] == "E0423" and rows[0]["note"].endswith(f", t = {bad}"), (given, wrong)
    # What reads the solution, or states, is known in a run only: which rate, where, when.
    for given in ({"rate": "sqrt(eps(u).yy - 1)", "form": "1 + d"}, {"rate": "-1/(d - 0.8)", "start": "1", "form": "1 + d"},
                  {"part": "ground", "rate": "log(u.y)", "wear": "d"}, {"part": "ground", "rate": "sqrt(-1 - layer.xi)", "wear": "d"}):
        rows, wrong = both(**given)
        assert not rows and [d["code"] for d in wrong] == ["E0701"], (given, rows, wrong)
        message = wrong[0]["message"]
        assert "the rate of the state `d` is " in message and " at step 1 (t = 0.125)" in message and "), where `d` is " in message, (given, message)


PLACES = """{mesh}
space V = scalar P1 on body{zero}
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(body, dot(grad(u'), grad(v))) + integral(body, dot(grad(u), grad(v))) + integral(body, u*v)
  = integral({part}, {load})
report
  table m = integral(body, u)
"""
MESHES = {1: "mesh body = interval(1, cells = 7)\npart left = body.left\npart right = body.right",
          2: "mesh body = rectangle(2, 1, cells = [8, 4])\npart left = body.left\npart low = body.bottom\npart mid = body where x > 0.5 and x < 1.5",
          3: "mesh body = box(1, 1, 1, cells = [3, 2, 2])\npart left = body.left\npart low = body.bottom",
          "ring": "mesh body = rectangle(2, 1, cells = [8, 4], axisymmetric = true)\npart low = body.bottom"}


def functional(load, dim=2, part="body", zero=""):
    """The exponent of the poles of a load, as `check` gives it in the row H(f); None where it holds. The warning says the same."""
    with tempfile.NamedTemporaryFile("w", suffix=".hvi") as file:
        file.write(PLACES.format(mesh=MESHES[dim], load=load if "grad" in load else f"({load})*v", part=part, zero=zero)), file.flush()
        done = subprocess.run([sys.argv[1], "check", file.name, "--json", "-", "--diagnostics", "json"], capture_output=True, text=True)
    assert done.returncode == 0, (load, done.stderr)
    found = [r for r in json.loads(done.stdout)["hypotheses"] if r["name"] == "H(f)"]
    said = [d["message"] for d in (json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")) if d["code"] == "W0108"]
    assert len(found) == 1, found
    if found[0]["holds"]:
        assert not said, (load, said)
        return None
    assert found[0]["bound"] == "f is a functional on V" and said == [f"the load is no functional on V: {found[0]['note']}"], (load, found, said)
    return float(found[0]["note"].split("d^-")[1].split()[0])


def places():
    """Analytic: d^-a on a set of codimension c is integrable where a < c; before a derivative of v it has to be square integrable, a < c/2;
    where v is 0 on a surface of poles, |v| <= d^(1/2) ||v|| makes it a < 3/2."""
    rng = random.Random(9)
    for _ in range(8):
        x, y, z = (round(rng.uniform(0.1, 0.9), 3) for _ in range(3))
        for a in (0.7, 1.0, 1.3, 1.8, 2.0, 2.4, 2.8, 3.1):
            over = lambda c: a if a >= c else None
            assert functional(f"2 + abs(x - {x})^(-{a})*cos(y)") == over(1), (x, a)
            assert functional(f"abs(x + {y}*y - {x + y})^(-{a})") == over(1), (x, y, a)
            assert functional(f"((x - {x})^2 + 3*(y - {y})^2)^(-{a}/2)") == over(2), (x, y, a)
            assert functional(f"norm([x - {x}, y - {y}])^(-{a})") == over(2)
            assert functional(f"abs((x - {x})^2 + (y - 0.5)^2 - 0.01)^(-{a})") == over(1)  # a circle
            assert functional(f"abs(x - {x})^(-{a})", 1) == over(1)
        for a in (0.9, 1.2, 1.9, 2.2, 2.9, 3.0):
            over = lambda c: a if a >= c else None
            assert functional(f"((x - {x})^2 + (y - {y})^2 + (z - {z})^2)^(-{a}/2)", 3) == over(3)
            assert functional(f"((x - {x})^2 + (z - {z})^2)^(-{a}/2)", 3) == over(2)
            assert functional(f"abs(x + y + z - {x + y + z})^(-{a})", 3) == over(1)
            assert functional(f"((x - {x})^2 + (z - {z})^2)^(-{a}/2)", 3, "low") == over(2)
            assert functional(f"abs(x - {x})^(-{a})", 2, "low") == over(1)
            assert functional(f"((x - {x})^2 + y^2)^(-{a}/2)", 2, "low") == over(1)
    for a in (0.3, 0.6, 0.9, 1.1):
        assert functional(f"dot([abs(x - 0.77)^(-{a}), 0], grad(v))") == (a if a >= 0.5 else None)
        assert functional(f"dot([0, ((x - 0.77)^2 + (y - 0.4)^2)^(-{a}/2)], grad(v))") == (a if a >= 1 else None)
    for a in (0.9, 1.0, 1.4, 1.6):
        for load in (f"x^(-{a})", f"x^(-{a})*(1 + t)"):
            assert functional(load) == (a if a >= 1 else None) and functional(load, 1) == (a if a >= 1 else None)
            assert functional(load, zero=", zero on left") == (a if a >= 1.5 else None), a
            assert functional(load, 1, zero=", zero on left") == (a if a >= 1.5 else None), a
        # a body of revolution has the weight x
        assert functional(f"x^(-{a} - 1)", "ring") == (a if a >= 1 else None) or a < 1
        assert functional(f"x^(-{a})", "ring") is None
    # poles that move are poles wherever they are at a time of the grid, and none of time
    for a in (0.3, 0.7, 0.95, 1.0, 2.5):
        assert functional(f"abs(x - t)^(-{a})") == (a if a >= 1 else None), a
        assert functional(f"abs(x - 1.5 - t)^(-{a})*(1 - t)", 1) is None
        assert functional(f"((x - t)^2 + (y - t/2)^2)^(-{a}/2)") == (a if a >= 2 else None), a
    # on parts, and beside normals
    for a in (0.8, 1.0, 1.7):
        for place, here in (("x - 0.77", True), ("x - 1.77", False), ("x - 1", True), ("x - 0.5", True), ("x - 0.4", False)):
            assert functional(f"(| inside(mid) -> abs({place})^(-{a}) | otherwise -> 2)") == (a if here and a >= 1 else None), (place, a)
            assert functional(f"(| inside(mid) -> y | otherwise -> abs({place})^(-{a}))") == (a if place not in ("x - 0.77", "x - 1") and a >= 1 else None), (place, a)
        assert functional(f"normal.y*abs(x - 0.77)^(-{a})", part="low") == (a if a >= 1 else None), a
        assert functional(f"normal.x*abs(x - 0.77)^(-{a})", part="low") is None, a
    # none at all
    for load in ("(x - 1)^3/(x - 1)^2", "sin(x - 1)/(x - 1)", "exp(-1/(x - 1)^2)", "log(abs(x - 1))", "1/(x - 2.1)", "1/(1 + (x - 1)^2 + y^2)",
                 "1/((x - 3)^2 + y^2)", "1/(0.01 + x)", "1/sqrt(x^2 + y^2)", "(| x > 0.5 -> 1/x | otherwise -> 0)", "1/(x*y + 1)"):
        assert functional(load) is None, load
    for load in ("1/(x - 1)", "(| x > 1 -> 1/(x - 1) | otherwise -> 0)", "1/sin(3*x)", "x/(x^2 - 1)", "1/(x*y)", "t/(x - 1)", "(1 - t)/(x - 1)", "1/(exp(x) - exp(1))"):
        assert functional(load) == 1, load


def main():
    given()
    moving()
    places()
    rng = random.Random(4)
    for _ in range(12):
        a = rng.choice([rng.uniform(0.05, 0.45), rng.uniform(0.55, 0.95)])
        t0 = rng.choice([0.0, -2.0, 3.0])
        c = t0 + rng.choice([0.0, 1.0, rng.uniform(0.1, 0.9)])
        load = f"2 + abs(t - {c!r})^(-{a!r})*cos(t)"
        found = row("H(f)", load=load, t0=t0, t1=t0 + 1)
        assert found["holds"] is (a < 0.5), (load, found)
    assert row("H(f)", load="sqrt(0.51 - t)")["note"].startswith("the load is nan at t = 0.625")  # no number has no sign
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
