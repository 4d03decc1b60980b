"""tools/bench scale: large bodies by the iterative solver, and against the direct one.

--quick: up to n = 16 only. The largest runs take a quarter of an hour and 6 GiB. Wall times of two processes mean something on an
idle machine with two processors only.
"""
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "families"))
import iterative as family  # noqa: E402  which knows how to start several processes

from bench_scale_model import on_paper  # noqa: E402

FAMILIES = {  # scripts in 3D, and what n = 64 must stay below: CPU seconds and GiB
    "slab3d": ("bench/slab3d.hvi", (240, 6), (120, 4)),
    "slab3d with friction": ("bench/slab3d_friction.hvi", (900, 6), (400, 6)),
}
STEPS = 16
AGAINST = {"slab3d": (1.0, 0.5), "slab3d with friction": (1.2, 0.5)}  # CPU over the direct one's at n = 32: must, aim
SINGLE = {"slab3d": (20, 2.1), "slab3d with friction": (20, 3.0)}  # CPU seconds and GiB at n = 32: half the memory of a factor of 2026
WORTH = {"double": 1.3, "single": 1.1}  # what two threads of OpenBLAS have to gain with such a factor
GROWTH = 1.4  # of iterations a step at a doubling
PAIRS = 3  # of runs, of which the median counts
FASTER = (1.6, 1.8)  # two processes over one: must, aim
WEAK = {1: 20, 2: 25, 4: 32, 8: 40}  # n for each number of processes: 50,000 unknowns each
EVEN = (1.2, 1.1)  # iterations of eight over one


def run_of(measured, sizes, script, n, solver, processes=1, more=()):
    result = measured(script, *sizes(n=n, N=STEPS), "--solver", solver, *more, launcher=family.launcher(processes))
    work = result["plan"]
    print(f"    {script} n={n} {' '.join([solver, *more])}, processes {processes}: {result['unknowns']} unknowns, {result['seconds']:.1f} s, wall {result['wall']:.1f}, {result['megabytes']:.0f} MB, "
          f"{work['newton'] / STEPS:.1f} Newton and {work.get('iterations', 0) / STEPS:.1f} iterations a step, equilibrium "
          f"{result['certificate']['equilibrium']:.1e}, inclusion {result['certificate']['inclusion']:.1e}", flush=True)
    return result


def answers_apart(a, b):
    """Of two runs: the largest difference of a column, in 1e-9 of its largest value."""
    return 1e9 * max(abs(x - y) / max(map(abs, a["table"][column]))
                     for column in a["table"] if any(a["table"][column]) for x, y in zip(a["table"][column], b["table"][column]))


def in_single_precision(row, rows, name, double, single):
    """The factor with half the bits: CPU seconds and GiB must be below these of the direct path at its best."""
    seconds, room = SINGLE[name]
    figures = f"{name} n=32, a factor in single precision"
    certified = single["certificate"]["certified"] and single["plan"].get("factor") == "single"
    row(rows, f"{figures}: CPU", single["seconds"], seconds, "-", "s", certified and single["seconds"] <= seconds)
    used = single["megabytes"] / 1024
    row(rows, f"{figures}: peak memory", used, room, "-", "GiB", certified and used <= room)
    row(rows, f"{figures}: CPU, over double precision", single["seconds"] / double["seconds"], 1, "-", "times", single["seconds"] <= double["seconds"])
    apart = answers_apart(double, single)
    row(rows, f"{figures}: answers apart, in 1e-9", apart, 1, "-", "", apart <= 1)


def with_threads(row, rows, name, one, two, factor):
    """Two threads of OpenBLAS: wall time. Its serial build takes one, and has the same bits."""
    if one["table"] == two["table"]:
        print(f"    {name} n=32: OpenBLAS is its serial build here; with LD_LIBRARY_PATH=/usr/lib/x86_64-linux-gnu/openblas-pthread two threads are measured")
        return
    times = one["wall"] / two["wall"]
    figures = f"{name} n=32, a factor in {factor} precision, two threads of OpenBLAS ({one['wall']:.1f} and {two['wall']:.1f} s)"
    row(rows, f"{figures}: wall time, one over two", times, WORTH[factor], "-", "times", times >= WORTH[factor])
    apart = answers_apart(one, two)
    row(rows, f"{figures}: answers apart, in 1e-9", apart, 1, "-", "", apart <= 1)


def against_direct(row, rows, name, direct, iterative):
    must, aim = AGAINST[name]
    figure = iterative["seconds"] / direct["seconds"]
    row(rows, f"{name} n=32: CPU, iterative over direct", figure, must, aim, "times", figure <= must)
    saved = direct["megabytes"] / iterative["megabytes"]
    row(rows, f"{name} n=32: memory, direct over iterative", saved, 5, "-", "times", saved >= 5)
    apart = answers_apart(direct, iterative)
    row(rows, f"{name} n=32: answers apart, in 1e-9", apart, 1, "-", "", apart <= 1)


def largest(row, rows, name, result):
    _, (seconds, room), (aim_seconds, aim_room) = FAMILIES[name]
    certified = result["certificate"]["certified"]
    figures = f"{name} n=64, {result['unknowns']} unknowns"
    row(rows, f"{figures}: CPU", result["seconds"], seconds, aim_seconds, "s", certified and result["seconds"] <= seconds)
    used = result["megabytes"] / 1024
    row(rows, f"{figures}: peak memory", used, room, aim_room, "GiB", certified and used <= room)


def two_processes(row, rows, measured, sizes, name, n):
    """Wall time of one process over two, in pairs of runs."""
    script = FAMILIES[name][0]
    pairs = [[run_of(measured, sizes, script, n, "iterative", processes)["wall"] for processes in (1, 2)] for _ in range(PAIRS)]
    times = statistics.median(one / two for one, two in pairs)
    row(rows, f"{name} n={n}: wall time, one process over two", times, *FASTER, "times", times >= FASTER[0])


def weak(row, rows, measured, sizes, name, most):
    """As many unknowns for each process: iterations and the memory of the others."""
    script = FAMILIES[name][0]
    runs = {processes: run_of(measured, sizes, script, n, "iterative", processes) for processes, n in WEAK.items() if processes <= most}
    plans = {processes: run["plan"] for processes, run in runs.items()}
    counts = {processes: plan["iterations"] / STEPS for processes, plan in plans.items()}
    grown = counts[most] / counts[1]
    told = ", ".join(f"{count:.0f}" for count in counts.values())
    row(rows, f"{name}, 50,000 unknowns a process: iterations ({told})", grown, *EVEN, "times", grown <= EVEN[0])
    held = {processes: plan["bytes_of_others"] for processes, plan in plans.items() if processes > 1}
    grown = held[most] / held[2]
    row(rows, f"the same: memory of another process, {most} over 2 ({held[most] / 1e6:.0f} MB)", grown, *EVEN, "times", grown <= EVEN[0])
    if most == max(WEAK):
        on_paper(plans, runs[1]["timing"]["inequality"] / plans[1]["iterations"])


def scale(quick, row, measured, sizes):
    rows = []
    for name, (script, _, _) in FAMILIES.items():
        a_step = {}
        for n in (8, 16) if quick else (16, 32, 64):
            result = run_of(measured, sizes, script, n, "iterative")
            a_step[n] = result["plan"]["iterations"] / STEPS
            if n == 32:
                direct = run_of(measured, sizes, script, n, "direct")
                against_direct(row, rows, name, direct, result)
                single = run_of(measured, sizes, script, n, "direct", more=("--factor", "single"))
                in_single_precision(row, rows, name, direct, single)
                threads = ("--blas-threads", "2")
                with_threads(row, rows, name, direct, run_of(measured, sizes, script, n, "direct", more=threads), "double")
                with_threads(row, rows, name, single, run_of(measured, sizes, script, n, "direct", more=("--factor", "single", *threads)), "single")
            if n == 64:
                largest(row, rows, name, result)
        for n in list(a_step)[1:]:
            growth = a_step[n] / a_step[n // 2]
            row(rows, f"{name}: iterations a step, n={n} over n={n // 2} ({a_step[n]:.0f}, {a_step[n // 2]:.0f})", growth, GROWTH,
                1, "times", growth <= GROWTH)
        two_processes(row, rows, measured, sizes, name, 16 if quick else 32)
        weak(row, rows, measured, sizes, name, 2 if quick else max(WEAK))
    return rows
