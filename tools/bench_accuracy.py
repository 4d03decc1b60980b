"""tools/bench accuracy: does --accuracy keep its word, and what is a digit worth in seconds?

HVI_CASES sets the number of cases. Three families of manufactured problems, parameters drawn with the seeds below: the true error must be below the
wanted one in at least 95 of 100 cases and the announced CPU time within a factor 2. Then all families of data that jump,
pulse, oscillate and have layers in time (tests/families/accuracy_cases.py): every promise must be kept and every case solved.
Then the paper's scheme (P1, backward Euler) against the setting that --accuracy picks, to the same true error, for a
solution linear in time and for one that is not.
"""
import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "families"))
import accuracy_cases  # noqa: E402  the families of the tests

BUILD = pathlib.Path(os.environ.get("HVI_BUILD", ROOT / "build" / "release"))
OUT = ROOT / "build" / "bench-out"
SEEDS = {"2D smooth": 6001, "2D with contact changes": 6002, "3D": 6003}

# u = g(t) phi(x), g = sin(w t); its memory int_0^t exp(-(t - s)/q) g(s) ds in closed form.
COMMON = """
tensor A = isotropic(lambda = {la:.6g}, mu = {mu:.6g})
tensor B = isotropic(young = {young:.6g}, poisson = {poisson:.6g})
kernel C(lag) = -exp(-lag/{q:.6g}) * B
fn g()      = sin({w:.6g}*t)
fn rate()   = {w:.6g}*cos({w:.6g}*t)
fn memory() = ({q:.6g}*sin({w:.6g}*t) - {w:.6g}*{q:.6g}^2*(cos({w:.6g}*t) - exp(-t/{q:.6g})))/(1 + ({w:.6g}*{q:.6g})^2)
fn stress() = rate() * (A : eps(phi())) + (g() - memory()) * (B : eps(phi()))
"""
PROBLEM = """
space V = vector P1 on body, zero on roof
find u in V for t in [0, 1] by 1024 steps from u = 0
such that for all v in V
    integral(body, A : eps(u') : eps(v))
  + integral(body, B : eps(u) : eps(v))
  + integral(body, history(C, eps(u)) : eps(v))
  + {laws}
 >= integral(body, stress() : eps(v))
  + {reactions}
report
  table error = sqrt(integral(body, (eps(u) - g()*eps(phi())) : (eps(u) - g()*eps(phi())))),
        size = sqrt(integral(body, g()*g()*(eps(phi()) : eps(phi()))))
"""
LAYER = """
superpotential layer(r) with slope | r < 0 -> 0 | r < {a:.6g} -> {k:.6g}*r | r < {b:.6g} -> {k:.6g}*{a:.6g} - {s:.6g}*(r - {a:.6g}) | otherwise -> {k:.6g}*{a:.6g} - {s:.6g}*({b:.6g} - {a:.6g})
fn pressure(r) = | r < 0 -> 0 | r < {a:.6g} -> {k:.6g}*r | r < {b:.6g} -> {k:.6g}*{a:.6g} - {s:.6g}*(r - {a:.6g}) | otherwise -> {k:.6g}*{a:.6g} - {s:.6g}*({b:.6g} - {a:.6g})
superpotential slip(xi) = slip_weakening(xi, static = 0.7, sliding = 0.5, decay = 20)
"""


def material(draw):
    return COMMON.format(la=draw.uniform(1, 10), mu=draw.uniform(3, 20), young=draw.uniform(30, 120),
                         poisson=draw.uniform(0.1, 0.4), q=draw.uniform(0.2, 1.0), w=draw.uniform(0.8, 2.8))


def layer(draw):
    a = draw.uniform(0.01, 0.04)
    return LAYER.format(a=a, b=a + draw.uniform(0.02, 0.06), k=draw.uniform(50, 120), s=draw.uniform(5, 15))


def smooth(draw):
    """Waves in both directions on a ground with a smooth law."""
    c = [draw.uniform(0.5, 3.5) for _ in range(4)]
    wanted = 10 ** draw.uniform(-3, -1.3)
    k = draw.uniform(5, 40)
    text = "mesh body = rectangle(1, 1, cells = [16, 16])\npart roof = body.top\npart ground = body.bottom\n"
    text += (f"fn phi() = [0.05*sin({c[0]:.6g}*x + {c[1]:.6g})*(1 - y), "
             f"-0.06*cos({c[2]:.6g}*x)*sin({0.5 * c[3]:.6g}*(1 - y))]\n")
    text += f"superpotential spring(r) with slope {k:.6g}*tanh(3*r)\n" + material(draw)
    depth = f"0.06*cos({c[2]:.6g}*x)*sin({0.5 * c[3]:.6g})*g()"
    return wanted, text + PROBLEM.format(
        laws="integral(ground, spring^0(u.nu; v.nu), rule = gauss)",
        reactions=f"integral(ground, {k:.6g}*tanh(3*{depth}) * v.nu, rule = gauss)")


def contact(draw):
    """The normal law is met in all its branches, the ground sticks on one half and slips on the other."""
    wanted, depth = 10 ** draw.uniform(-3, -1.3), draw.uniform(0.05, 0.15)
    text = "import friction\nmesh body = rectangle(1, 1, cells = [16, 16])\npart roof = body.top\n"
    text += "part ground = body.bottom\n"
    text += f"fn phi() = [0.05 * max(x - 0.5, 0)^2 * (1 - y), -{depth:.6g} * x * (1 - y)]\n" + layer(draw) + material(draw)
    text += "fn drag() = | x < 0.5 -> 0.2 | otherwise -> 0.5 + 0.2*exp(-20*0.05*(x - 0.5)^2*g())\n"
    return wanted, text + PROBLEM.format(
        laws="integral(ground, layer^0(u.nu; v.nu) + slip^0(u.tau; v.tau))",
        reactions=f"integral(ground, pressure({depth:.6g}*x*g()) * v.nu, rule = nodal)\n"
                  "  + integral(ground, drag() * v.x, rule = nodal)")


def solid(draw):
    """A cube: waves, contact with a softening layer at its bottom."""
    wanted, depth = 10 ** draw.uniform(-1.7, -1), draw.uniform(0.05, 0.15)
    c = [draw.uniform(0.5, 2.0) for _ in range(2)]
    text = "import friction\nmesh body = box(1, 1, 1, cells = [4, 4, 4])\npart roof = body.top\npart ground = body.bottom\n"
    text += (f"fn phi() = [0.03*sin({c[0]:.6g}*z)*(1 - y), -{depth:.6g} * x * (1 - y), 0.03*sin({c[1]:.6g}*x)*(1 - y)]\n"
             + layer(draw) + material(draw))
    return wanted, text + PROBLEM.format(
        laws="integral(ground, layer^0(u.nu; v.nu))",
        reactions=f"integral(ground, pressure({depth:.6g}*x*g()) * v.nu, rule = nodal)")


FAMILIES = {"2D smooth": smooth, "2D with contact changes": contact, "3D": solid}


def run(script, *words):
    result = OUT / "accuracy.json"
    done = subprocess.run([BUILD / "hvi-run", script, "--quiet", "--json", result, "-o", OUT, *map(str, words)],
                          capture_output=True, text=True)
    if done.returncode:
        return None, done.stderr
    return json.loads(result.read_text()), ""


def true_error(result):
    return max(result["table"]["error"]) / max(result["table"]["size"])


def family(rows, row, name, cases):
    draw = random.Random(SEEDS[name])
    good = timely = 0
    records, script = [], OUT / "accuracy.hvi"
    for case in range(cases):
        wanted, text = FAMILIES[name](draw)
        script.write_text(text)
        result, why = run(script, "--accuracy", wanted)
        if result is None:
            records.append({"case": case, "wanted": wanted, "failure": why})
            print(f"    case {case}: {why.strip().splitlines()[0] if why else 'failed'}", flush=True)
            continue
        last, true = result["accuracy"]["tries"][-1], true_error(result)
        ratio = last["cpu"] / last["predicted"]["cpu"]
        good += true <= wanted
        timely += 0.5 <= ratio <= 2
        records.append({"case": case, "wanted": wanted, "true": true, "estimate": result["accuracy"]["estimate"],
                        "setting": last["setting"], "cpu": last["cpu"], "predicted": last["predicted"]["cpu"],
                        "tries": len(result["accuracy"]["tries"]), "total": result["accuracy"]["cpu"]})
        if true > wanted:
            print(f"    case {case}: true {true:.2e} above {wanted:.2e}: {last['setting']}", flush=True)
    kept = [r for r in records if "true" in r]
    row(rows, f"{name} (seed {SEEDS[name]}, {cases} cases): true error below the wanted", 100 * good / cases, 95, 100,
        "%", good >= 0.95 * cases)
    row(rows, f"{name}: CPU time within a factor 2 of the announced", 100 * timely / cases, 95, 100, "%",
        timely >= 0.95 * cases)
    if kept:
        middle = sorted(r["true"] / r["wanted"] for r in kept)[len(kept) // 2]
        row(rows, f"{name}: median of true over wanted error", middle, "-", "-", "", None)
    (ROOT / "build" / f"bench-accuracy-{name.replace(' ', '-')}.json").write_text(json.dumps(records, indent=1))


def draw(name, title, xlabel, curves, slopes=()):
    """OUT/name.svg and .png by gnuplot: curves are (title, style, points), slopes (power, x0, x1, y0)."""
    blocks, plots, labels = "", [], ""
    for k, (label, style, points) in enumerate(curves):
        blocks += f"$c{k} << HVI\n" + "".join(f"{x:.6g} {y:.6g}\n" for x, y in points) + "HVI\n"
        plots.append(f"$c{k} with {style} title '{label}' noenhanced")
    for k, (power, x0, x1, y0) in enumerate(slopes):
        y1 = y0 * (x1 / x0) ** power
        blocks += f"$s{k} << HVI\n{x0} {y0}\n{x1} {y1:.6g}\n{x0} {y1:.6g}\n{x0} {y0}\nHVI\n"
        plots.append(f"$s{k} with lines lc rgb 'gray40' notitle")
        labels += f"set label '{power:g}' at {math.sqrt(x0 * x1):.6g},{y1:.6g} offset 0,0.6 tc rgb 'gray30'\n"
    for kind, terminal in (("svg", "svg size 900,600 background 'white'"), ("png", "pngcairo size 900,600")):
        subprocess.run(["gnuplot"], check=True, text=True, input=(
            f"set terminal {terminal}\nset output '{OUT / name}.{kind}'\nset title '{title}'\nset logscale xy\nset grid\n"
            f"set key outside right top\nset format xy '10^{{%T}}'\nset xlabel '{xlabel}'\n"
            f"set ylabel 'relative error in V, largest over time'\n{blocks}{labels}plot {', '.join(plots)}\n"))


def families_in_time(rows, row, quick):
    """Every kind of data in time on every kind of scene, drawn anew so often; a reference of each case's own."""
    seed, times = 6004, 1 if quick else max(1, int(os.environ.get("HVI_CASES", "100")) // 25)
    families = accuracy_cases.FAMILIES[::9] if quick else accuracy_cases.FAMILIES
    script, records = OUT / "accuracy_time.hvi", []
    for n, family_ in enumerate(families * times):
        case = accuracy_cases.scene(family_, random.Random(f"{seed} {n}"))
        script.write_text(case.script)
        result, why = run(script, "--accuracy", case.wanted, *(["--of", case.probe] if case.probe else []))
        record = {"name": case.name, "wanted": case.wanted, "of": case.probe or "V"}
        if result is None:
            record["failure"] = why
        else:
            record |= {"true": case.true_error(result), "setting": result["accuracy"]["tries"][-1]["setting"],
                       "steps": result["accuracy"]["tries"][-1]["steps"], "total": result["accuracy"]["cpu"]}
        records.append(record)
        if result is None or record["true"] > case.wanted:
            print(f"    {case.name}: wanted {case.wanted:.0e}, {record.get('true', 'refused')}", flush=True)
    found = [r for r in records if "true" in r]
    kept = sum(r["true"] <= r["wanted"] for r in found)
    title = f"{len(families)} families in time (seed {seed}, {len(records)} cases)"
    row(rows, f"{title}: promises kept", 100 * kept / max(1, len(found)), 100, "-", "%", kept == len(found))
    row(rows, f"{title}: refused", 100 * (1 - len(found) / len(records)), 0, "-", "%", len(found) == len(records))
    for label, key in (("true over wanted error", lambda r: r["true"] / r["wanted"]), ("steps", lambda r: r["steps"]),
                       ("CPU seconds of the search", lambda r: r["total"])):
        values = sorted(map(key, found))
        print(f"    {label}: median {values[len(values) // 2]:.3g}, largest {values[-1]:.3g}", flush=True)
    (ROOT / "build" / "bench-accuracy-time.json").write_text(json.dumps(records, indent=1))


def not_linear_in_time(rows, row, quick):
    """A known solution with a kink, a wave and a layer in time: uniform steps against those that are found."""
    script = ROOT / "bench" / "accuracy_time.hvi"

    def error(result):
        return max(result["table"]["error"]) / max(result["table"]["size"])

    measured = []
    for n in (16, 32, 64) if quick else (16, 32, 64, 128, 256):
        result, _ = run(script, "-D", f"n={n}", "-D", f"N={n}")
        measured.append((n, error(result), solved(result)))
        print(f"    P1/backward Euler n = N = {n}: error {measured[-1][1]:.2e}, {measured[-1][2]:.3f} s", flush=True)
    points = []
    for wanted in (3e-2, 1e-2) if quick else (3e-2, 1e-2, 3e-3):
        best, _ = run(script, "-D", "N=4096", "--accuracy", wanted)
        setting, seconds, search = best["accuracy"]["tries"][-1]["setting"], solved(best), best["accuracy"]["cpu"]
        points.append((error(best), seconds, search))
        print(f"    wanted {wanted:.0e}: {setting}: error {points[-1][0]:.2e}, {seconds:.3f} s, search {search:.2f} s", flush=True)
        row(rows, f"a solution not linear in time, relative error {wanted:.0e}: true error", points[-1][0] / wanted, 1, "-",
            "of it", points[-1][0] <= wanted)
    draw("accuracy_time", "a kink, a wave and a layer in time: seconds to an error", "CPU seconds", [
        ("P1, backward Euler, n = N", "linespoints pt 7 lw 2", [(s, e) for _, e, s in measured]),
        ("the setting of --accuracy", "linespoints pt 7 lw 2", [(s, e) for e, s, _ in points]),
        ("the same with its search", "linespoints pt 6 dt 3", [(s, e) for e, _, s in points])])


def solved(result):
    """CPU seconds of a run without its table, which here integrates the exact solution in every step."""
    return result["timing"]["total"] - result["timing"]["output"]


def best_of(script, wanted):
    """The run that --accuracy finds, three times: the median of its seconds."""
    runs = [run(script, "--accuracy", wanted)[0] for _ in range(3)]
    return sorted(runs, key=solved)[1]


def paper_scheme(rows, row, quick):
    """Seconds of P1/backward Euler with n = N to a true error, against the setting found for it."""
    script = ROOT / "examples" / "manufactured.hvi"
    measured = []
    for n in (40, 80) if quick else (40, 80, 160, 270):
        result, _ = run(script, "-D", f"n={n}", "-D", f"N={n}")
        size = max(result["table"]["strain"])
        measured.append((n, max(result["table"]["error"]) / size, solved(result)))
        order = "" if len(measured) == 1 else (
            f", order {math.log(measured[-2][1] / measured[-1][1]) / math.log(n / measured[-2][0]):.2f}, seconds grow "
            f"like n^{math.log(measured[-1][2] / measured[-2][2]) / math.log(n / measured[-2][0]):.2f}")
        print(f"    P1/backward Euler n = N = {n}: error {measured[-1][1]:.2e}, {measured[-1][2]:.3f} s{order}", flush=True)
    (n1, e1, s1), (n2, e2, s2) = measured[-2:]
    growth = math.log(s2 / s1) / math.log(n2 / n1)
    points = []
    for wanted, must, aim in ((1e-2, "-", "-"), (3e-3, 100, "-"), (1e-3, "-", 1000), (1e-4, "-", "-")):
        enough = [m for m in measured if m[1] <= wanted]
        if enough:
            n, error, slow = enough[0]
            how = "measured"
        else:  # error like 1/n, seconds as they grew
            n = math.ceil(n2 * e2 / wanted)
            error, slow, how = wanted, s2 * (n / n2) ** growth, "extrapolated"
        best = best_of(script, wanted)
        true, fast = max(best["table"]["error"]) / max(best["table"]["strain"]), solved(best)
        print(f"    {wanted:.0e}: P1/backward Euler n = N = {n}: {slow:.3g} s, error {error:.2e} ({how}); "
              f"{best['accuracy']['tries'][-1]['setting']}: {fast:.3g} s, error {true:.2e}, search "
              f"{best['accuracy']['cpu']:.2f} s", flush=True)
        holds = true <= wanted and (must == "-" or how == "measured" and slow / fast >= must)
        row(rows, f"relative error {wanted:.0e}: P1/backward Euler ({how}) over the best setting", slow / fast, must, aim,
            "times", None if quick else holds)
        row(rows, f"relative error {wanted:.0e}: the same over the whole search", slow / best["accuracy"]["cpu"], "-", "-",
            "times", None)
        points.append({"wanted": wanted, "n": n, "paper": slow, "how": how, "best": fast, "true": true,
                       "setting": best["accuracy"]["tries"][-1]["setting"], "search": best["accuracy"]["cpu"]})
    draw("accuracy_paper", "manufactured solution: seconds to an error", "CPU seconds", [
        ("P1, backward Euler, measured", "linespoints pt 7 lw 2", [(s, e) for _, e, s in measured]),
        ("the same, extrapolated", "linespoints pt 6 dt 2",
         [measured[-1][:0:-1]] + [(p["paper"], p["wanted"]) for p in points if p["how"] == "extrapolated"]),
        ("the setting of --accuracy", "linespoints pt 7 lw 2", [(p["best"], p["true"]) for p in points]),
        ("the same with its search", "linespoints pt 6 dt 3", [(p["search"], p["true"]) for p in points])])
    (ROOT / "build" / "bench-accuracy-paper.json").write_text(
        json.dumps({"measured": measured, "growth": growth, "points": points}, indent=1))


def study_row(best):
    """The setting of a search as a rung of bench/slab_accuracy.hvi."""
    last = best["accuracy"]["tries"][-1]
    text = last["setting"]
    mesh = re.search(r"(\d+) x (\d+) cells(?: graded ([\d.]+))?", text)
    adapted = re.search(r"adapted to (\d+) cells", text)
    n, grade = (4, "1") if adapted else (int(mesh[2]), mesh[3] or "1")
    return f"[{n}, {last['steps']}, {grade}, {adapted[1] if adapted else 0}, P{last['order']}, {last['scheme']}]"


def corners(rows, row):
    """The slab, whose corners are singular: both sides in one study against a graded reference."""
    text, wanted = (ROOT / "bench" / "slab_accuracy.hvi").read_text(), 1e-2
    best = best_of(ROOT / "bench" / "slab_accuracy.hvi", wanted)
    paper = [f"[{n}, {steps}, 1, 0, P1, backward_euler]" for n, steps in ((128, 64), (192, 128), (208, 128), (224, 128))]
    rungs = ", ".join([*paper, study_row(best), "[64, 400, 3, 0, P2, bdf2]"])
    script = OUT / "slab_accuracy.hvi"
    script.write_text(text[:text.index("study vary")] +
                      f"study vary n, N, grade, cells, element, method in [{rungs}] against finest\n")
    result = OUT / "slab_study.json"
    subprocess.run([BUILD / "hvi-run", "study", script, "--quiet", "--json", result, "-o", OUT / "slab_study"], check=True,
                   stdout=subprocess.DEVNULL)
    found = json.loads(result.read_text())["rows"]
    for r in found[:-1]:
        p = r["params"]
        print(f"    slab: {p['element']}, {p['method']}, n = {p['n']}, N = {p['N']}, grade {p['grade']}, adapted {p['cells']}: "
              f"relative error {r['error']['relative']:.2e}, {r['cpu']:.3f} s", flush=True)
    slow = min((r["cpu"] for r in found[:-2] if r["error"]["relative"] <= wanted), default=math.nan)
    last = found[-2]
    row(rows, f"slab, relative error {wanted:.0e}: uniform P1/backward Euler over the best setting", slow / last["cpu"], 30,
        "-", "times", last["error"]["relative"] <= wanted and slow / last["cpu"] >= 30)
    row(rows, f"slab, relative error {wanted:.0e}: the same over the whole search", slow / best["accuracy"]["cpu"], "-", "-",
        "times", None)


def orders_at_corners():
    """Errors against unknowns on uniform, graded and adapted meshes: a picture and its numbers."""
    graded, adapted = ROOT / "examples" / "slab_corners.hvi", (ROOT / "examples" / "slab_adapted.hvi").read_text()
    curves = []

    def study(script):
        result = OUT / "corners.json"
        subprocess.run([BUILD / "hvi-run", "study", script, "--quiet", "--json", result, "-o", OUT / script.stem], check=True,
                       stdout=subprocess.DEVNULL)
        return [r for r in json.loads(result.read_text())["rows"] if "error" in r]

    def curve(label, rows):
        points = [(r["unknowns"], r["error"]["relative"]) for r in rows]
        curves.append((label, "linespoints pt 7 lw 2", points))
        print(f"    corners, {label}: " + ", ".join(f"{n}: {e:.2e}" for n, e in points), flush=True)

    found = [r for r in study(graded) if int(r["params"]["n"]) <= 64]
    for label, grade in (("P1, uniform", "1"), ("P1, graded with power 2", "2")):
        curve(label, [r for r in found if r["params"]["grade"] == grade])
    for element, rungs in (("P1", [8, 16, 32, 64, 192]), ("P2", [8, 16, 32, 96])):
        script = OUT / "slab_adapted.hvi"
        script.write_text(adapted.replace("n in [8, 16, 32, 64, 192]", f"n in {rungs}")
                          .replace("param element = P1", f"param element = {element}"))
        curve(f"{element}, adapted", study(script))
    draw("accuracy_corners", "the slab, singular at the ends of its clamped roof", "unknowns", curves,
         [(-0.5, 300, 1500, 5e-3), (-1.0, 300, 1500, 5e-3)])


def accuracy(quick):
    row = sys.modules["__main__"].row
    OUT.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in FAMILIES:
        family(rows, row, name, 4 if quick else int(os.environ.get("HVI_CASES", "100")))
    families_in_time(rows, row, quick)
    paper_scheme(rows, row, quick)
    not_linear_in_time(rows, row, quick)
    if not quick:
        corners(rows, row)
        orders_at_corners()
    return rows
