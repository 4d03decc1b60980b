"""tools/bench solvers: a factor against iterations, what `plan` predicts of each, and which one `automatic` takes.

Fifteen scenes around the sizes where one takes over from the other: cubes, bars and plates, P1 and P2, with and without
friction, in 2D and 3D, of one unknown and of two. The choice must not cost more than 1.5 times the better one, predictions must be within a factor
of 2.
"""
import re
import subprocess

SLAB, FRICTION, PLANE = "bench/slab3d.hvi", "bench/slab3d_friction.hvi", "bench/slab.hvi"
WARM, CHANNEL = "bench/warm3d_friction.hvi", "examples/channel.hvi"
BOX = "box(2, 1, 1, cells = [2*n, n, n])"
CUBE = {}
BAR = {BOX: "box(20, 1, 1, cells = [20*n, n, n])"}
PLATE = {BOX: "box(2, 0.1, 2, cells = [10*n, n, 10*n])"}
ORDER = {"vector P1": "vector P2"}
SCENES = (  # name, script, what is other in it, n, steps
    ("plane", PLANE, CUBE, 96, 16), ("block", SLAB, CUBE, 8, 16), ("block", SLAB, CUBE, 14, 16), ("block", SLAB, CUBE, 20, 16),
    ("block, 2 steps", SLAB, CUBE, 14, 2), ("block, 128 steps", SLAB, CUBE, 12, 128), ("bar", SLAB, BAR, 8, 16),
    ("plate", SLAB, PLATE, 3, 16), ("block, P2", SLAB, ORDER, 6, 16), ("block, friction", FRICTION, CUBE, 8, 16),
    ("block, friction", FRICTION, CUBE, 14, 16), ("block, friction", FRICTION, CUBE, 20, 16),
    ("warm block", WARM, CUBE, 8, 4), ("warm block", WARM, CUBE, 16, 4), ("flow", CHANNEL, CUBE, 48, None))
DEAREST = 1.5  # CPU of the choice over the better one's
WITHIN = 2.0


def changed_script(root, script, changes):
    text = (root / script).read_text()
    for old, new in changes.items():
        if old not in text:
            raise SystemExit(f"{script} has no `{old}`")
        text = text.replace(old, new)
    path = root / "build" / "bench-out" / "solvers.hvi"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def predicted(root, build, path, arguments):
    """Seconds, bytes at most, and the solver of `plan`."""
    out = subprocess.run([build / "hvi-run", "plan", path, *arguments], check=True, cwd=root, capture_output=True, text=True).stdout
    size, unit = re.search(r"^memory: ([0-9.]+) (\w+) at most", out, re.M).groups()
    chosen = re.search(r"^linear systems: (a factor|iterations)", out, re.M)
    return (float(re.search(r"^predicted: ([0-9.]+) s", out, re.M)[1]), float(size) * {"kB": 1e-3, "MB": 1, "GB": 1e3}[unit],
            {None: None, "a factor": "direct", "iterations": "iterative"}[chosen and chosen[1]])


def solvers(quick, row, measured, sizes, root, build):
    rows = []
    for name, script, changes, n, steps in SCENES[1:3] if quick else SCENES:
        path = changed_script(root, script, changes)
        arguments, cost = sizes(n=n) if steps is None else sizes(n=n, N=steps), {}
        for solver in ("direct", "iterative"):
            asked = [*arguments, "--solver", solver]
            cost[solver] = measured(path, *asked)
            seconds, megabytes, _ = predicted(root, build, path, asked)
            case = f"{name} n={n}, {cost[solver]['unknowns']} unknowns, {solver}"
            for what, figure, was in (("seconds", seconds, cost[solver]["timing"]["total"]), ("memory", megabytes, 1.048576 * cost[solver]["megabytes"])):
                row(rows, f"{case}: {what} ({figure:.3g} predicted, {was:.3g})", figure / was, WITHIN, 1, "times",
                    1 / WITHIN <= figure / was <= WITHIN)
        chosen = predicted(root, build, path, [*arguments, "--solver", "automatic"])[2]
        best = min(one["seconds"] for one in cost.values())
        row(rows, f"{name} n={n}, automatic: {chosen}", cost[chosen]["seconds"] / best, DEAREST, 1, "times",
            cost[chosen]["seconds"] <= DEAREST * best)
    return rows
