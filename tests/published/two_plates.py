"""How heat made between two plates divides itself: the reference of examples/disc_brake.hvi, in one dimension by finite volumes.
usage: two_plates.py SCRIPT

Each plate is insulated behind; half of the heat goes into either surface, and what their temperatures differ by drives heat through the
contact. Material, sizes and the course of the heat are read from the script; the number in its `expect share` must be ours."""
import pathlib
import re
import sys

import numpy as np

TEXT = pathlib.Path(sys.argv[1]).read_text()
param = lambda name: float(re.search(rf"param {name} += ([\d.]+)", TEXT)[1])
FORCE, SPEED, STOP = param("force"), param("speed"), param("stop")
CAPACITY = [float(re.search(rf"integral\({body}, ([\d.]+)\*theta'", TEXT)[1]) for body in ("rotor", "lining")]
CONDUCTIVITY = [float(re.search(rf"integral\({body}, ([\d.]+)\*dot\(grad\(theta", TEXT)[1]) for body in ("rotor", "lining")]
FILM = 2 * float(re.search(r"film\(s\) = ([\d.]+)\*s\^2", TEXT)[1])
MU, FADING = map(float, re.search(r"mu\(T\) = ([\d.]+)\*\(1 - ([\d.]+)\*T\)", TEXT).groups())
THICK, RADIUS = (10.0, 8.0), 110.0  # of the mesh


def edges(thick, first, n):
    """Of n cells that grow by one ratio from the first one."""
    low, high = 1.0, 3.0
    for _ in range(100):
        ratio = (low + high) / 2
        low, high = (ratio, high) if first * (ratio ** n - 1) / (ratio - 1) < thick else (low, ratio)
    return thick * (ratio ** np.arange(n + 1) - 1) / (ratio ** n - 1)


def share(cells, steps):
    """Unknowns: the cells of the rotor, its surface, that of the lining, its cells; surfaces have no capacity."""
    size = 2 * cells + 2
    capacity, matrix = np.zeros(size), np.zeros((size, size))

    def link(i, j, conductance):
        for a, b in ((i, j), (j, i)):
            matrix[a, a] += conductance
            matrix[a, b] -= conductance

    for body, surface, way in ((0, cells, -1), (1, cells + 1, 1)):
        e = edges(THICK[body], 0.004, cells)
        middles = (e[1:] + e[:-1]) / 2
        capacity[[surface + way * (k + 1) for k in range(cells)]] = CAPACITY[body] * np.diff(e)
        for k in range(cells):
            link(surface + way * (k + 1), surface + way * k, CONDUCTIVITY[body] / (middles[k] - (middles[k - 1] if k else 0.0)))
    link(cells, cells + 1, FILM)
    end, both = 0.9 * STOP, [cells, cells + 1]
    times = end * (np.arange(steps + 1) / steps) ** 2
    theta = np.zeros(size)
    for before, now in zip(times, times[1:]):
        inverse = np.linalg.inv(np.diag(capacity / (now - before)) + matrix)
        heat, after = np.zeros(size), theta
        for _ in range(3):  # friction fades with the mean of both surfaces
            heat[both] = 0.5 * MU * (1 - FADING * after[both].mean()) * FORCE * SPEED * RADIUS * (1 - now / STOP)
            after = inverse @ (capacity / (now - before) * theta + heat)
        theta = after
    rotor, lining = (capacity * theta)[:cells].sum(), (capacity * theta)[cells + 2:].sum()
    return lining / rotor


stated = float(re.search(r"expect share = ([\d.]+)", TEXT)[1])
coarse, fine = share(30, 100), share(60, 200)
assert abs(fine - coarse) < 1e-4, (coarse, fine)
assert abs(fine - stated) < 5e-5, (fine, stated)
print(f"the heat of the lining is {fine:.6f} of that of the rotor ({coarse:.6f} on half as many cells and steps); the script says {stated}")
