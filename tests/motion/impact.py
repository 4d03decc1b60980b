"""Impact of an elastic bar, a bar that bounces ten times, and two bars: every scheme against the exact solution, in one table.

usage: impact.py HVI_RUN [--cells N]

Reference: analytic. Waves of speed 1 in a bar of length 1 are the sum of two travelling functions; leapfrog with steps as
long as cells moves them exactly, and the obstacle at the foot with them, where the bar meets the wall at times of the
grid.
"""
import argparse
import csv
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).parent
SCHEMES = ["backward_euler", "bdf2", "newmark", "hht", "midpoint"]


def exact(cells, steps, gap, speed, weight):
    """Times, u of foot and tip, the force of the wall: leapfrog with c k = h."""
    k = 1 / cells
    before = np.full(cells + 1, speed * k - weight * k * k / 2)  # u(-k): thrown from rest at t = 0
    now = np.zeros(cells + 1)
    foot, tip, push = [0.0], [0.0], [0.0]
    for _ in range(steps):
        inner = np.concatenate([[now[1]], now, [now[-2]]])  # both ends free
        after = inner[2:] + inner[:-2] - before - weight * k * k
        lowest = max(after[0], -gap)
        push.append((lowest - after[0]) / (2 * k))  # half a cell's mass is pushed
        after[0] = lowest
        before, now = now, after
        foot.append(now[0]), tip.append(now[-1])
    return k * np.arange(steps + 1), np.array(foot), np.array(tip), np.array(push)


def solved(program, folder, cells, steps, end, method, *sums, **values):
    """The table, and the sum of these columns of the monitors, after every step."""
    defines = [w for key, v in dict(n=cells, N=steps, end=end, method=method, **values).items() for w in ("-D", f"{key}={v}")]
    subprocess.run([program, str(HERE / "bar.hvi"), "--quiet", "--monitors", "-o", str(folder), *defines], check=True,
                   capture_output=True)
    read = lambda name: list(csv.DictReader(open(folder / name)))
    table, energy = read("bar.csv"), read("bar_monitors.csv")
    column = lambda rows, name: np.array([float(r[name]) for r in rows])
    total = sum(column(energy, name) for name in sums)
    return {name: column(table, name) for name in ("t", "foot", "tip", "push")}, total


def at(times, reference, values):
    return np.interp(times, reference, values)


def thrown(program, folder, cells, method):
    """Contact time / 2, speed after it, mean force, worst error of foot and tip, the largest energy and the last."""
    gap, speed, end = 0.25, 1.0, 3.0
    times, foot, tip, _ = exact(400, round(400 * end), gap, speed, 0.0)
    out, total = solved(program, folder, cells, round(1.5 * cells * end), end, method, "kinetic",
                        "elastic", gap=gap, speed=speed, weight=0)
    touching = out["t"][out["push"] > 1e-3]
    k = out["t"][1] - out["t"][0]
    contact = touching[-1] - touching[0] + k
    free = out["t"] > 2.6
    line = np.polyfit(out["t"][free], (out["foot"][free] + out["tip"][free]) / 2, 1)
    error = max(np.abs(out[name] - at(out["t"], times, e)).max() for name, e in (("foot", foot), ("tip", tip)))
    loaded = (out["t"] > 0.5) & (out["t"] < 2.0)
    force = out["push"][loaded].mean()
    return contact / 2, line[0], force, error, total.max() / (speed**2 / 2), total[-1] / (speed**2 / 2)


def bounced(program, folder, cells, method):
    """Ten rebounds under weight: how many there were, the worst error of the tip by the gap up to the fifth, and the
    energy, with that of weight, by what the fall sets free: the largest and the last."""
    gap, weight, end = 0.5, 1 / 9, 90.0  # as in the paper, where the bar has length 10 and waves speed 30
    times, _, tip, _ = exact(400, round(400 * end), gap, 0.0, weight)
    out, energy = solved(program, folder, cells, round(1.5 * cells * end), end, method, "energy", gap=gap, speed=0,
                         weight=weight)
    touching = np.convolve(out["push"] > 0, np.ones(cells // 4), "same") > 0  # forces flicker within a contact
    rebounds = int((touching[:-1] & ~touching[1:]).sum())
    early = out["t"] < end / 2
    error = np.abs(out["tip"] - at(out["t"], times, tip))[early].max() / gap
    scale = gap * weight
    return rebounds, error, 1 + energy.max() / scale, 1 + energy[-1] / scale


def collided(program, folder, method):
    """A bar and one at rest: contact time / 2, force over the exact one, both speeds after it over that before, the largest energy."""
    subprocess.run([program, str(HERE / "two_bars.hvi"), "--quiet", "--monitors", "-o", str(folder), "-D", f"method={method}"],
                   check=True, capture_output=True)
    read = lambda name: list(csv.DictReader(open(folder / name)))
    table, monitors = read("two_bars.csv"), read("two_bars_monitors.csv")
    column = lambda rows, name: np.array([float(r[name]) for r in rows])
    t, push = column(table, "t"), column(table, "push")
    touching = t[push > 1e-3]
    energy = column(monitors, "energy")
    steady = (t > 0.5) & (t < 1.7)
    return ((touching[-1] - touching[0] + t[1] - t[0]) / 2, push[steady].mean() / 0.05,
            column(table, "v_left")[-1] / 0.1, column(table, "v_right")[-1] / 0.1, energy.max() / 0.0005)


def require(bad, what, holds):
    if not holds:
        bad.append(what)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=lambda p: str(pathlib.Path(p).resolve()))
    parser.add_argument("--cells", type=int, default=100)
    options = parser.parse_args()
    bad = []
    print("thrown at a wall       contact/2L  speed after  force  error of u  energy: largest    last")
    for method in SCHEMES:
        with tempfile.TemporaryDirectory() as folder:
            row = thrown(options.program, pathlib.Path(folder), options.cells, method)
        contact, after, force, error, most, last = row
        print(f"  {method:<20} {contact:10.4f} {after:12.4f} {force:6.3f} {error:11.4f} {most:15.4f} {last:7.4f}")
        require(bad, f"{method}: contact time", abs(contact - 1) < 0.02)
        require(bad, f"{method}: speed after it", abs(after - 1) < 0.005)
        require(bad, f"{method}: force", abs(force - 1) < 0.005)
        if method == "midpoint":
            require(bad, "midpoint: displacements", error < 0.01)
            require(bad, "midpoint: energy", most < 1 + 1e-12 and last > 0.998)
    print("dropped, ten rebounds    rebounds   error of u  energy: largest    last")
    for method in SCHEMES:
        with tempfile.TemporaryDirectory() as folder:
            rebounds, error, most, last = bounced(options.program, pathlib.Path(folder), options.cells, method)
        print(f"  {method:<20} {rebounds:10d} {error:14.4f} {most:15.4f} {last:7.4f}")
        if method == "midpoint":
            require(bad, "midpoint: ten rebounds", rebounds >= 10)
            require(bad, "midpoint: energy of rebounds", most < 1 + 1e-12 and last > 0.98)
        if method in ("backward_euler", "bdf2"):
            require(bad, f"{method}: gains no energy", most < 1 + 1e-12)
    print("at a bar at rest       contact/2L  force  speeds after it  energy: largest")
    for method in SCHEMES:
        with tempfile.TemporaryDirectory() as folder:
            contact, force, first, second, most = collided(options.program, pathlib.Path(folder), method)
        print(f"  {method:<20} {contact:10.4f} {force:6.3f} {first:7.4f} {second:7.4f} {most:15.4f}")
        # `midpoint` takes the mass off the nodes that touch, so that the integral of u' is not quite its momentum.
        require(bad, f"{method}: momentum", abs(first + second - 1) < (1e-4 if method == "midpoint" else 1e-9))
        if method in ("bdf2", "hht", "midpoint"):
            require(bad, f"{method}: the bars exchange their speeds", abs(first) < 0.02)
        if method == "midpoint":
            require(bad, "midpoint: contact time of two bars", abs(contact - 1) < 0.02)
            require(bad, "midpoint: force of two bars", abs(force - 1) < 0.02)
            require(bad, "midpoint: energy of two bars", most < 1 + 1e-11)
    for what in bad:
        print("missed:", what)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
