"""tools/bench scale: large bodies by the iterative solver, and against the direct one.

--quick: up to n = 16 only. The largest runs take a quarter of an hour and 6 GiB.
"""
FAMILIES = {  # scripts in 3D, and what n = 64 must stay below: CPU seconds and GiB
    "slab3d": ("bench/slab3d.hvi", (240, 6), (120, 4)),
    "slab3d with friction": ("bench/slab3d_friction.hvi", (900, 6), (400, 6)),
}
STEPS = 16
AGAINST = {"slab3d": (1.0, 0.5), "slab3d with friction": (1.2, 0.5)}  # CPU over the direct one's at n = 32: must, aim
GROWTH = 1.4  # of iterations a step at a doubling


def run_of(measured, sizes, script, n, solver):
    result = measured(script, *sizes(n=n, N=STEPS), "--solver", solver)
    work = result["plan"]
    print(f"    {script} n={n} {solver}: {result['unknowns']} unknowns, {result['seconds']:.1f} s, {result['megabytes']:.0f} MB, "
          f"{work['newton'] / STEPS:.1f} Newton and {work.get('iterations', 0) / STEPS:.1f} iterations a step, equilibrium "
          f"{result['certificate']['equilibrium']:.1e}, inclusion {result['certificate']['inclusion']:.1e}", flush=True)
    return result


def against_direct(row, rows, name, direct, iterative):
    must, aim = AGAINST[name]
    figure = iterative["seconds"] / direct["seconds"]
    row(rows, f"{name} n=32: CPU, iterative over direct", figure, must, aim, "times", figure <= must)
    saved = direct["megabytes"] / iterative["megabytes"]
    row(rows, f"{name} n=32: memory, direct over iterative", saved, 5, "-", "times", saved >= 5)
    apart = max(abs(a - b) / max(map(abs, direct["table"][column]))
                for column in direct["table"] if any(direct["table"][column])
                for a, b in zip(direct["table"][column], iterative["table"][column]))
    row(rows, f"{name} n=32: answers apart, in 1e-9", 1e9 * apart, 1, "-", "", apart <= 1e-9)


def largest(row, rows, name, result):
    _, (seconds, room), (aim_seconds, aim_room) = FAMILIES[name]
    certified = result["certificate"]["certified"]
    figures = f"{name} n=64, {result['unknowns']} unknowns"
    row(rows, f"{figures}: CPU", result["seconds"], seconds, aim_seconds, "s", certified and result["seconds"] <= seconds)
    used = result["megabytes"] / 1024
    row(rows, f"{figures}: peak memory", used, room, aim_room, "GiB", certified and used <= room)


def scale(quick, row, measured, sizes):
    rows = []
    for name, (script, _, _) in FAMILIES.items():
        a_step = {}
        for n in (8, 16) if quick else (16, 32, 64):
            result = run_of(measured, sizes, script, n, "iterative")
            a_step[n] = result["plan"]["iterations"] / STEPS
            if n == 32:
                against_direct(row, rows, name, run_of(measured, sizes, script, n, "direct"), result)
            if n == 64:
                largest(row, rows, name, result)
        for n in list(a_step)[1:]:
            growth = a_step[n] / a_step[n // 2]
            row(rows, f"{name}: iterations a step, n={n} over n={n // 2} ({a_step[n]:.0f}, {a_step[n // 2]:.0f})", growth, GROWTH,
                1, "times", growth <= GROWTH)
    return rows
