"""Hard cases: slivers between the cells of a body in space, loads that jump in time."""
import math

from suite import case, certified, judge, relative, worst


def tetrahedra(n, flat):
    """Nodes and tetrahedra of the unit cube, n cells each way, each cut from its centre. Between two layers the nodes of
    a square lie `flat` above and below its plane by turns, so the square is a sliver of four nearly coplanar nodes."""
    nodes, cells, number = [], [], {}

    def node(i, j, k):
        if (i, j, k) not in number:
            nodes.append((i / n, j / n, k / n + (flat / n * (-1)**(i + j) if 0 < k < n else 0.0)))
            number[i, j, k] = len(nodes)
        return number[i, j, k]

    def cut(a, b, c, d, across_a):
        return [(a, b, c), (a, c, d)] if across_a else [(b, c, d), (b, d, a)]

    def add(a, b, c, d):
        p, q, r, s = (nodes[v - 1] for v in (a, b, c, d))
        u, v, w = ([x - y for x, y in zip(z, p)] for z in (q, r, s))
        volume = (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]))
        cells.append((a, b, c, d) if volume > 0 else (a, b, d, c))

    for i in range(n):
        for j in range(n):
            for k in range(n + 1):
                square = [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)]
                if 0 < k < n:
                    add(*square)
            for k in range(n):
                nodes.append(((i + 0.5) / n, (j + 0.5) / n, (k + 0.5) / n))
                centre = len(nodes)
                p = {(x, y, z): node(i + x, j + y, k + z) for x in (0, 1) for y in (0, 1) for z in (0, 1)}
                even = (i + j) % 2 == 0
                # Seen from above a sliver ends in its two high nodes, seen from below in its two low ones.
                faces = cut(p[0, 0, 0], p[1, 0, 0], p[1, 1, 0], p[0, 1, 0], even)
                faces += cut(p[0, 0, 1], p[1, 0, 1], p[1, 1, 1], p[0, 1, 1], not even)
                for x in (0, 1):
                    faces += cut(p[x, 0, 0], p[x, 1, 0], p[x, 1, 1], p[x, 0, 1], True)
                    faces += cut(p[0, x, 0], p[1, x, 0], p[1, x, 1], p[0, x, 1], True)
                for face in faces:
                    add(centre, *face)
    return nodes, cells


def write(path, nodes, cells):
    """MSH 2.2 of a body without named boundary."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "1", '3 1 "body"', "$EndPhysicalNames", "$Nodes",
             str(len(nodes))]
    lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(nodes, 1)] + ["$EndNodes", "$Elements", str(len(cells))]
    lines += [f"{i} 4 2 1 1 {a} {b} {c} {d}" for i, (a, b, c, d) in enumerate(cells, 1)] + ["$EndElements", ""]
    path.write_text("\n".join(lines))


@case
def slivers(suite):
    """Tetrahedra of four nearly coplanar nodes between the layers of a body, to a height of 1e-6 (analytic: uniform strain)."""
    name = "slivers"
    for flat in (1e-2, 1e-4, 1e-6):
        write(suite.folder / "slivers.msh", *tetrahedra(3, flat))
        for degree in ("P1", "P2"):
            for poisson in (0.3, 0.4999):
                data = suite.run("slivers.hvi", degree=degree, poisson=poisson)
                what = f"height {flat:.0e}, {degree}, poisson {poisson}"
                if certified(name, what, data):
                    error = max(relative(data["final"]["foot"], 0.005), relative(data["final"]["side"], -poisson * 0.005))
                    judge(name, f"{what}: error", error, 1e-14 / flat / (1 - 2 * poisson))


def moduli(load, steps, eta, size, rate):
    """(eta/k) (u_n - u_{n-1}) + u_n + memory + max(u_n, 0) = f_n: Kelvin-Voigt with relaxation on a ground that only pushes."""
    k, u, memory = 1 / steps, [0.0], 0.0
    decay, weight = math.exp(-rate * k), size * -math.expm1(-rate * k) / rate
    for n in range(1, steps + 1):
        memory *= decay
        free, stiff = load(n, k) + eta / k * u[-1] - memory, eta / k + 1 + weight
        u.append(free / (stiff + 1 if free > 0 else stiff))
        memory += weight * u[-1]
    return u[1:]


@case
def blows(suite):
    """Loads that jump in time, at a grid time and within a step, taken at the end of a step and averaged (analytic)."""
    name = "blows"
    steps, eta, size, rate = 64, 0.02, -0.5, 4.0
    for what, at in (("on a grid time", (0.25, 0.5, 0.75)), ("within a step", (0.2532, 0.5091, 0.7777))):
        pulse = lambda t, at=at: 1.0 if at[0] <= t < at[1] else -3.0 if at[1] <= t < at[2] else 0.0
        mean = lambda n, k, at=at: math.fsum(s * max(0.0, min(n * k, b) - max((n - 1) * k, a)) for s, a, b in (
            (1.0, at[0], at[1]), (-3.0, at[1], at[2]))) / k
        for choice, load in (("endpoint", lambda n, k: pulse(n * k)), ("average", mean)):
            data = suite.run("blows.hvi", steps=steps, eta=eta, size=size, rate=rate, a=at[0], b=at[1], c=at[2], choice=choice)
            if certified(name, f"{what}, {choice}", data):
                judge(name, f"jump {what}, load {choice}: error",
                      worst(data["table"]["u"], moduli(load, steps, eta, size, rate)), 1e-12 if choice == "endpoint" else 1e-10)
