"""A frictional joint: an elastic block with a curved foot, pressed on rough rigid ground by a constant force, sheared to and fro.

usage: joint.py HVI_RUN

The block's head is held by soft springs, pressed by a constant traction and sheared by one that comes and goes, less than would make all of it
slide: the slip enters from the edges of the contact and goes on inward (partial slip, as in the contacts of Cattaneo and Mindlin). Signorini's
condition with a gap and Coulomb's friction on the rate. The drag of the head against its displacement is a loop.

Reference: independent, an assembly of its own (solids.py) condensed to the ground, every step by the states of its nodes, found from the forces
that they make, or by sweeps with both laws of a node solved exactly. (a) With the same mesh and steps displacements of the head, drag and what
friction dissipates agree to 1e-8 of the largest. (b) Against 24 cells across and 600 steps, runs of 240 steps on 6, 12 and 24 cells: at
24 the head's displacement along the loop within 0.1 % of the largest and the dissipation of a cycle, which is the loop's area, within 3 %; from
6 on the former falls with the mesh.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from solids import Solid, block

YOUNG, POISSON, MU = 70.0, 0.3, 0.5
SPRING, PRESS, SHEAR = 1.0, 3.0, 1.3
SIZES = (2.0, 1.0)
RADIUS = 2.5  # of the foot
SAME, DISPLACED, DISSIPATED = 1e-8, 0.001, 0.03


def shear(t):
    """Pressed until t = 1, then up, down, up."""
    return SHEAR * np.interp(t, [0, 1, 2, 4, 6], [0, 0, 1, -1, 1])


def press(t):
    return PRESS * min(t, 1.0)


class Mirrored:
    """Diagonals for `block` that are mirrored at the middle of 2 n columns of n cells."""

    def __init__(self, n):
        self.n, self.cell = n, 0

    def uniform(self, *_):
        return 0.0

    def integers(self, _):
        self.cell += 1
        return int(self.cell > self.n * self.n)


class Joint:
    def __init__(self, n):
        self.mesh = block(Mirrored(n), [2 * n, n], SIZES)
        self.solid = Solid(self.mesh, 1)
        lam, mu = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON), YOUNG / 2 / (1 + POISSON)
        k = self.solid.stiffness(lam, mu)
        for a, b in self.mesh.facets["top"]:
            length = np.linalg.norm(self.solid.points[a] - self.solid.points[b])
            for i, j, share in ((a, a, 2), (b, b, 2), (a, b, 1), (b, a, 1)):
                for c in range(2):
                    k[2 * i + c, 2 * j + c] += SPRING * length * share / 6
        points = self.solid.law_points("bottom", "nodal")
        nodes = {}
        for weight, values, _ in points:
            node = int(np.argmax(values[0])) // 2
            nodes[node] = nodes.get(node, 0.0) + weight
        self.nodes, self.weights = np.array(list(nodes)), np.array(list(nodes.values()))
        ground = np.concatenate([2 * self.nodes, 2 * self.nodes + 1])  # x of all, then y of all
        inverse = np.linalg.inv(k)
        self.c = inverse[np.ix_(ground, ground)]
        down, along = (self.solid.facet_load("top", np.array(f)) for f in ((0.0, -1.0), (1.0, 0.0)))
        self.free_down, self.free_along = (inverse[ground] @ f for f in (down, along))
        across = (self.solid.points[self.nodes, 0] - 1.0) ** 2 / (2 * RADIUS)
        self.gap = np.concatenate([np.zeros(len(self.nodes)), across])
        head = int(np.argmin(((self.solid.points - [1.0, 1.0]) ** 2).sum(1)))
        self.head_of = inverse[2 * head, ground]
        self.head_down, self.head_along = inverse[2 * head] @ down, inverse[2 * head] @ along

    def run(self, steps):
        """Times, displacement of the head along the ground, drag (the sum of what friction takes), work of friction so far."""
        m = len(self.nodes)
        force = np.zeros(2 * m)  # of the ground on the body
        last, work = np.zeros(m), 0.0
        out = [(0.0, 0.0, 0.0, 0.0)]
        for t in np.linspace(0, 6, steps + 1)[1:]:
            free = press(t) * self.free_down + shear(t) * self.free_along + self.gap
            force = self.step(free, force, last)
            u = free + self.c @ force
            work -= force[:m] @ (u[:m] - last)
            last = u[:m]
            head = press(t) * self.head_down + shear(t) * self.head_along + self.head_of @ force
            out.append((t, head, -force[:m].sum(), work))
        return np.array(out)

    def step(self, free, force, last):
        """The forces of states that are guessed and guessed again from their own forces; sweeps where that turns in circles."""
        m = len(self.nodes)
        stiff = 1 / np.diag(self.c)
        for _ in range(40):
            u = free + self.c @ force
            pressed = force[m:] - stiff[m:] * u[m:]
            along = force[:m] - stiff[:m] * (u[:m] - last)
            states = np.where(pressed <= 0, 0, np.where(np.abs(along) <= MU * pressed, 1, np.where(along > 0, 2, 3)))
            new = self.of_states(states, free, last)
            if np.abs(new - force).max() <= 1e-13 * np.abs(new).max():
                return new
            force = new
        return self.sweeps(free, force, last)

    def of_states(self, states, free, last):
        """Forces where every node is off the ground (0), sticks (1), or slips against a force along x (2) or -x (3)."""
        m = len(self.nodes)
        a, b = np.eye(2 * m), np.zeros(2 * m)
        for i, state in enumerate(states):
            if state == 0:
                continue
            a[m + i], b[m + i] = self.c[m + i], -free[m + i]
            if state == 1:
                a[i], b[i] = self.c[i], last[i] - free[i]
            else:
                a[i, m + i] = -MU if state == 2 else MU
        return np.linalg.solve(a, b)

    def sweeps(self, free, force, last):
        m = len(self.nodes)
        force, u = force.copy(), free + self.c @ force
        for _ in range(20000):
            change = 0.0
            for i in range(m):
                here = [i, m + i]
                c = self.c[np.ix_(here, here)]
                z = u[here] - c @ force[here]  # without this node's force
                new = node_force(c, z, last[i])
                moved = new - force[here]
                if moved.any():
                    u += self.c[:, here] @ moved
                    force[here] = new
                    change = max(change, np.abs(moved).max())
            if change <= 1e-13 * max(1e-9, np.abs(force).max()):
                return force
        raise AssertionError("the sweeps did not end")


def node_force(c, z, last):
    """(tangential, normal) force on a node with u = z + c f: u_y >= 0, f_y >= 0, |f_x| <= MU f_y, f_x against u_x - last."""
    if z[1] >= 0:
        return np.zeros(2)
    stick = np.linalg.solve(c, [last - z[0], -z[1]])
    if stick[1] >= 0 and abs(stick[0]) <= MU * stick[1]:
        return stick
    for sign in (1.0, -1.0):  # of the force
        normal = -z[1] / (c[1, 1] + sign * MU * c[1, 0])
        f = np.array([sign * MU * normal, normal])
        if normal > 0 and sign * (z[0] + c[0] @ f - last) <= 0:
            return f
    raise AssertionError("no force of this node")


SCRIPT = """
mesh body   = gmsh("body.msh")
part head   = body.group("top")
part ground = body.group("bottom")
tensor B    = isotropic(young = {young}, poisson = {poisson})
superpotential layer(r) with slope
  | r < 0     -> 0
  | otherwise -> 1e300
superpotential rub(w) = {mu} * abs(layer.xi) * norm(w)
fn shear(t) =
  | t < 1     -> 0
  | t < 2     -> t - 1
  | t < 4     -> 3 - t
  | otherwise -> t - 5
space V = vector P1 on body
find u in V for t in [0, 6] by {steps} steps from u = 0
such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(head, {spring} * dot(u, v))
  + integral(ground, layer^0(u.nu - (x - 1)^2/(2*{radius}); v.nu) + rub^0(u'.tau; v.tau))
 >= integral(head, dot([{shear}*shear(t), -{press}*min(t, 1)], v))
report
  table u = u.x at [1, 1], drag = integral(ground, rub.xi.x) to "joint.csv"
"""


def program(hvi, joint, steps):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "body.msh").write_text(joint.mesh.msh())
        (folder / "joint.hvi").write_text(SCRIPT.format(young=YOUNG, poisson=POISSON, mu=MU, spring=SPRING, shear=SHEAR,
                                                        press=PRESS, radius=RADIUS, steps=steps))
        done = subprocess.run([hvi, "run", "joint.hvi", "--quiet", "--monitors", "-o", "."], cwd=folder, capture_output=True,
                              text=True)
        if done.returncode:
            sys.exit(done.stderr)
        table = np.genfromtxt(folder / "joint.csv", delimiter=",", names=True)
        work = np.genfromtxt(next(folder.glob("*monitors*.csv")), delimiter=",", names=True)["friction_rub"]
    return np.column_stack([table["t"], table["u"], table["drag"], work[-len(table):]])


def compared(what, got, expected, within):
    error = float(np.abs(got - expected).max() / np.abs(expected).max())
    print(f"  {what}: {error:.2e}, within {within:g} {'ok' if error <= within else 'WRONG'}")
    return error, error <= within


def main():
    hvi, good = str(pathlib.Path(sys.argv[1]).resolve()), True
    joint = Joint(4)
    got = program(hvi, joint, 60)
    same = joint.run(60)[-len(got):]
    print("the same mesh and steps")
    for i, what in ((1, "displacement of the head"), (2, "drag"), (3, "work of friction")):
        good &= compared(what, got[:, i], same[:, i], SAME)[1]
    fine = Joint(24).run(600)
    cycle = lambda table: np.interp(6, table[:, 0], table[:, 3]) - np.interp(2, table[:, 0], table[:, 3])
    errors = []
    for n in (6, 12, 24):
        got = program(hvi, Joint(n), 240)
        reference = np.interp(got[:, 0], fine[:, 0], fine[:, 1])
        print(f"{n} cells across, 240 steps, against 24 and 600")
        loop, held = compared("displacement of the head", got[:, 1], reference, DISPLACED if n == 24 else 0.1)
        _, right = compared("dissipation of a cycle", np.array(cycle(got)), np.array(cycle(fine)),
                               DISSIPATED if n == 24 else 0.1)
        errors.append(loop)
        good &= held and right
    falls = errors[2] < errors[1] < errors[0]
    print(f"  the error of the displacement falls: {'ok' if falls else 'WRONG'}")
    return 0 if good and falls else 1


if __name__ == "__main__":
    sys.exit(main())
