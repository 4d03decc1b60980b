"""Two bodies on each other, on random scenes: the answers of brute force at every step.

usage: pairs.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

Each scene is two viscoelastic blocks in 2D or 3D, P1 or P2, whose meshes do not match, one of them shifted, wider or
narrower, with a gap, touching or pressed in, in 2D sometimes with uneven sides; as two files or as two groups of one;
turned and scaled. One to three laws act on the jump of u, of u' or of a memory, some with the gap, whose steps are
strictly convex. A step is solved again by a dense brute force (brute.py) with a mortar of its own (mortar.py), and by
the program with the contact unknowns of both sides, where it would take jumps for them (`--both-sides`), and by iterations,
where their module is there.
"""
import re
import subprocess
import sys

import numpy as np

import iterative
import rates
from brute import Point
from mortar import pair_points
from orientation import number
from solids import Mesh, Solid, block


class PairTerm(rates.RateTerm):
    """A law on a jump, perhaps less the gap."""

    def __init__(self, *of_term, sees):
        super().__init__(*of_term, sees=sees)
        self.with_gap = False

    def points(self, solid):
        out = []
        for p in solid.pairing:
            rows = p.jump
            if self.argument == ".nu":
                rows = p.normal[None, :] @ p.jump
            elif self.argument == ".tau":
                rows = np.linalg.svd(p.normal[None, :])[2][1:] @ p.jump
            out.append(Point(self.law, p.weight, rows, np.zeros(len(rows))))
        return out

    def form(self):
        seen = {"u": "u", "rate": "u'", "memory": "history(Own, u)"}[self.sees]
        gap = " - gap(seam)" if self.with_gap else ""
        return f"  + integral(seam, {self.name}^0(jump({seen}){self.argument}{gap}; jump(v){self.argument}))"


def together(upper, lower):
    """One mesh; facets are called `u_top`, `l_top`."""
    n = len(upper.points)
    facets = {f"u_{name}": f for name, f in upper.facets.items()}
    facets |= {f"l_{name}": [tuple(v + n for v in f) for f in found] for name, found in lower.facets.items()}
    return Mesh(np.vstack([upper.points, lower.points]), np.vstack([upper.cells, lower.cells + n]), facets)


def on_two_bodies(scene, text):
    """The script of a scene on one block, on its two."""
    begin, end = text.index("part bottom"), text.index("tensor B")
    group = {"u": 'upper.group("{}")', "l": 'lower.group("{}")'}
    if scene.one_file:
        group = {"u": 'body.group("u_{}")', "l": 'body.group("l_{}")'}
    at = lambda name: group[name[0]].format(name[2:])
    meshes = ('mesh body = gmsh("body.msh")' if scene.one_file else
              'mesh upper = gmsh("upper.msh")\nmesh lower = gmsh("lower.msh")\nmesh body = upper + lower')
    parts = [f"part u_top = {at('u_top')}", f"part l_bottom = {at('l_bottom')}", f"part right = {at('u_right')}",
             f"part one = {at(scene.sides[0])}", f"part two = {at(scene.sides[1])}", "part seam = pair(one, two)"]
    text = meshes + "\n" + "\n".join(parts) + "\n" + text[end:]
    return text.replace(", zero on held", ", zero on l_bottom, zero on u_top").replace("on held for t", "on u_top for t")


class Scene(rates.Scene):
    term_type = PairTerm

    def nodes_in(self, grid, turn, scale, solid):
        return nodes_in(self, grid, turn, scale, solid)

    def assemble(self):
        self.choose_bodies()
        super().assemble()

    def choose_bodies(self):
        """In place of one block: two, one above the other."""
        random, dim = self.random, self.dim
        most = (5, 3) if dim == 2 else (3, 2, 2) if self.order == 1 else (2, 1, 1)
        bumpy = dim == 2 and random.random() < 0.3
        bodies = []
        for _ in range(2):
            counts = [int(random.integers(1, m + 1)) for m in most]
            sizes = random.uniform(0.7, 1.5, dim)
            bodies.append(block(random, counts, sizes, 0.2, 0.08 if bumpy else 0.0))
        upper, lower = bodies
        height = lower.points[:, 1].max()
        if bumpy:  # its uneven side up
            lower.points[:, 1] = height - lower.points[:, 1]
            lower.facets["top"], lower.facets["bottom"] = lower.facets["bottom"], lower.facets["top"]
        shift = random.uniform(-0.4, 0.4, dim)
        kind = random.random()
        shift[1] = lower.points[:, 1].max() + (0.0 if kind < 0.5 else random.uniform(-0.02, 0.1))
        if random.random() < 0.3:
            shift[0] = 0.0
        upper.points += shift
        self.place(upper, lower)
        self.upper, self.lower = upper, lower
        self.mesh = together(upper, lower)
        self.solid = self.solid_of_bodies()
        self.one_file = random.random() < 0.4
        self.sides = ("u_bottom", "l_top") if random.random() < 0.6 else ("l_top", "u_bottom")
        self.clamped = "held"
        self.mesh.facets["held"] = self.mesh.facets["u_top"] + self.mesh.facets["l_bottom"]
        points, self.alone = self.pair_points(*(self.mesh.facets[s] for s in self.sides))
        self.solid.pairing = points
        self.mesh.facets["right"] = self.mesh.facets["u_right"]
        self.mesh.facets["bottom"] = self.mesh.facets[self.sides[0]]  # for sizes
        if not points:
            self.choose_bodies()

    def place(self, upper, lower):
        """Moves both to where they are."""

    def solid_of_bodies(self):
        return Solid(self.mesh, self.order)

    def pair_points(self, first, second):
        return pair_points(self.solid, first, second)

    def choose_laws(self):
        super().choose_laws()
        for term in self.terms:
            term.part, term.rule = "seam", "nodal"
            term.with_gap = term.sees == "u" and term.argument == ".nu" and self.random.random() < 0.7

    def held_at(self, t):
        """The upper body's top may move, the lower one's bottom stays."""
        out = super().held_at(t)
        out[~np.isin(self.clamped_dofs, self.solid.dofs(self.solid.on("u_top")))] = 0.0
        return out

    def law_points(self, n=1, known=None):
        out = super().law_points(n, known)
        if known is not None:
            pairing = self.solid.pairing
            for k, p in enumerate(out):
                if self.terms[k // len(pairing)].with_gap:
                    p.offset = p.offset - pairing[k % len(pairing)].gap
        return out

    def script(self, turn, scale):
        return on_two_bodies(self, super().script(turn, scale))

    def told(self):
        return (super().told() + f", pair {self.sides} of {len(self.solid.pairing)} points, {self.alone} alone, "
                f"{'one file' if self.one_file else 'two files'}, gaps {[t.with_gap for t in self.terms]}")


WAYS = [], ["--both-sides"], ["--solver", "iterative"]
ALIKE = 1e-10  # of all ways: as much as certificates leave; where slip weakens they may leave more, and then
FINER = "tolerance = 1e-13"  # all are solved to this


def run(program, folder, scene, turn, scale, options):
    """u at the reference's nodes after every step, or what was said instead."""
    folder.mkdir(parents=True, exist_ok=True)
    move = lambda mesh: mesh.moved(turn, scale, 0.0)
    plain = {name: f for name, f in scene.mesh.facets.items() if name[:2] in ("u_", "l_")}
    (folder / "body.msh").write_text(move(Mesh(scene.mesh.points, scene.mesh.cells, plain)).msh())
    (folder / "upper.msh").write_text(move(scene.upper).msh())
    (folder / "lower.msh").write_text(move(scene.lower).msh())
    text = scene.script(turn, scale)
    first, said, off = in_all_ways(program, folder, scene, turn, scale, options, text)
    if first is not None and off > ALIKE:
        using = ", " if " using " in text else " using "
        finer, said, off = in_all_ways(program, folder, scene, turn, scale, options, re.sub(r"\s+such that", f"{using}{FINER} such that", text))
        if finer is not None and off > ALIKE:
            said = f"jumps as unknowns, both sides and iterations differ by {off:.1e}"
    return (None, said) if said else (first, "")


def in_all_ways(program, folder, scene, turn, scale, options, text):
    """u with jumps as unknowns, or None; what was said instead; how far from it u is that was found in other ways."""
    (folder / "scene.hvi").write_text(text)
    out = []
    for more in WAYS:
        done = subprocess.run([program, "run", "scene.hvi", "--quiet", "-o", "out", *options, *more], cwd=folder,
                              capture_output=True, text=True, timeout=120)
        if done.returncode != 0 and iterative.NO_MODULE in done.stderr:
            continue
        if done.returncode != 0:
            return None, f"exit {done.returncode}{' '.join(['', *more])}: " + " ".join(done.stderr.split())[:400], 0.0
        out.append(rates.displacements(folder, scene, turn, scale))
    size = max(float(np.abs(u).max()) for u in out[0])
    return out[0], "", max(float(np.abs(u - v).max()) for other in out[1:] for u, v in zip(out[0], other)) / size


def nodes_in(scene, grid, turn, scale, solid):
    """As in rates.py; the bodies touch, and their nodes are told apart."""
    split, ours = len(scene.upper.cells), np.zeros(len(solid.points), bool)
    for cell in scene.mesh.cells[:split]:
        ours[solid.nodes(cell)] = True
    theirs = np.zeros(len(grid.points), bool)
    theirs[grid.cells[0].data[:split].ravel()] = True
    at = grid.points[:, :scene.dim] @ turn / scale
    return [int(np.argmin(((at - x) ** 2).sum(1) + 1e3 * (theirs != mine))) for x, mine in zip(solid.points, ours)]


if __name__ == "__main__":
    sys.exit(rates.judge("pairs", Scene, run=run))
