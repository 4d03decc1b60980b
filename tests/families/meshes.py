"""Meshes with faults that are known by construction, and meshes without: what `check` and `run` say of each.

usage: meshes.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER] [--data FOLDER ...]

A scene is one or two blocks of simplices in 2D or 3D, sometimes stretched to slivers, turned, scaled by up to a million
either way and moved: split along an interface, wholly or as a crack; apart; overlapping by any vector or by whole cells;
one inside the other; side by side with other nodes; of second order with curved or straight edges; with a cell on
either side of the limit of degenerate ones; joined in a corner; or
nothing of that. Wrong: a code that is missing, or too many, or a number
that is not the one of the construction. `--data`: folders whose .msh files are all good, or two bodies that touch.
"""
import argparse
import itertools
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from solids import Mesh, block, turning

KINDS = ["good", "split", "crack", "apart", "overlap", "whole_cells", "inside", "beside", "curved", "straight", "flat", "hinge"]
TWO_BODIES = {"disc_brake.msh": {"W0605"}, "rounds.msh": {"W0603", "W0605"}}  # what is said of them; the round ones touch in a point


def joined(a, b):
    """Two meshes in one; the groups of the second get names that end in 2."""
    n = len(a.points)
    facets = dict(a.facets)
    facets |= {name + "2": [tuple(int(v) + n for v in f) for f in fs] for name, fs in b.facets.items()}
    return Mesh(np.vstack([a.points, b.points]), np.vstack([a.cells, b.cells + n]), facets)


def shifted(mesh, vector):
    return Mesh(mesh.points + vector, mesh.cells, mesh.facets)


def volume(points):
    return abs(np.linalg.det(points[1:] - points[0])) / (2 if points.shape[1] == 2 else 6)


class Scene:
    def __init__(self, random, kind):
        self.random, self.kind = random, kind
        self.dim = 2 if random.random() < 0.6 else 3
        self.codes, self.facts, self.middles, self.held = set(), {}, None, True
        most = 6 if self.dim == 2 else 3
        self.counts = [int(random.integers(2, most + 1)) for _ in range(self.dim)]
        self.sizes = random.uniform(0.5, 2.0, self.dim)
        if random.random() < 0.25 and kind in ("good", "split", "apart", "straight"):
            self.sizes[random.integers(self.dim)] *= 10 ** random.uniform(-5, -1)  # slivers
        self.wobble = 0.0 if kind == "whole_cells" else 0.2
        self.mesh = block(random, self.counts, self.sizes, self.wobble)
        getattr(self, kind)()

    def other(self):
        return block(self.random, self.counts, self.sizes, self.wobble)

    def pieces(self, held):
        self.codes.add("W0605")
        self.facts["pieces"] = 2
        self.held = held
        if not held:
            self.codes.add("E0425")

    # --- kinds

    def good(self):
        pass

    def cut(self, stays):
        """The cells beyond the middle of the first axis get nodes of their own on the interface, but for `stays`."""
        m, n = self.mesh, self.counts[0] // 2
        grid = np.array(list(itertools.product(*(range(c + 1) for c in self.counts))))
        centres = np.array([grid[c][:, 0].mean() for c in m.cells])
        new, points, cells = {}, list(m.points), m.cells.copy()
        for c in np.flatnonzero(centres > n):
            for k, v in enumerate(m.cells[c]):
                if grid[v][0] != n or stays(grid[v]):
                    continue
                if v not in new:
                    new[v] = len(points)
                    points.append(points[v])
                cells[c, k] = new[v]
        facets = {name: [] for name in m.facets}
        sides = {tuple(sorted(np.delete(c, k))) for c in cells for k in range(self.dim + 1)}
        for name, fs in m.facets.items():
            for f in fs:
                f = tuple(sorted(f))
                facets[name].append(f if f in sides else tuple(sorted(new.get(v, v) for v in f)))
        self.mesh = Mesh(points, cells, facets)
        self.codes.add("W0603")
        self.facts["doubled"] = len(new)

    def split(self):
        self.cut(lambda g: False)
        self.pieces(held=self.random.random() < 0.5)
        if self.held:
            self.clamp = ["left", "right"]

    def crack(self):
        self.counts[1] = max(3, self.counts[1])
        self.mesh = block(self.random, self.counts, self.sizes, self.wobble)
        end = int(self.random.integers(1, self.counts[1]))  # open below
        self.cut(lambda g: g[1] >= end)

    def apart(self):
        gap = np.zeros(self.dim)
        gap[0] = self.sizes[0] * (1 + 10 ** self.random.uniform(-3, 1))
        self.mesh = joined(self.mesh, shifted(self.other(), gap))
        self.pieces(held=self.random.random() < 0.5)

    def overlap(self):
        reach = 10 ** self.random.uniform(-4, 0) * 0.95
        vector = self.sizes * (1 - reach) * self.random.choice([-1, 1], self.dim)
        for axis in range(1, self.dim):
            vector[axis] = self.sizes[axis] * self.random.uniform(0.02, 0.9) * self.random.choice([-1, 1])
        self.mesh = joined(self.mesh, shifted(self.other(), vector))
        self.codes.add("W0604")
        self.facts["depth"] = float(np.min(self.sizes - np.abs(vector)))
        self.pieces(held=True)

    def whole_cells(self):
        axis = int(self.random.integers(self.dim))
        vector = np.zeros(self.dim)
        vector[axis] = self.sizes[axis] / self.counts[axis] * self.random.integers(0, self.counts[axis])
        # diagonals may differ, nodes are the same
        self.mesh = joined(self.mesh, shifted(self.other(), vector))
        self.codes |= {"W0603", "W0604"}
        self.pieces(held=True)

    def inside(self):
        small = block(self.random, [1] * self.dim, self.sizes * self.random.uniform(0.01, 0.3))
        place = self.sizes * self.random.uniform(0.1, 0.6, self.dim)
        self.mesh = joined(self.mesh, shifted(small, place))
        self.codes.add("W0604")
        self.pieces(held=True)

    def beside(self):
        """Faces that touch with other nodes: some of each lie inside sides of the other."""
        vector = self.sizes * self.random.uniform(0.15, 0.35, self.dim)
        vector[0] = self.sizes[0]
        self.mesh = joined(self.mesh, shifted(self.other(), vector))
        self.codes.add("W0603")
        self.facts["doubled"] = 0
        self.pieces(held=True)

    def hinge(self):
        """Two blocks with one corner in common: the second one's value is the corner's."""
        first, second = self.mesh, shifted(self.other(), self.sizes)
        last, n = len(first.points) - 1, len(first.points)  # the corner is the first node of the second
        both = joined(first, second)
        new = np.array([*range(n), last, *range(n, len(both.points) - 1)])
        self.mesh = Mesh(np.delete(both.points, n, axis=0), new[both.cells],
                         {name: [tuple(int(new[v]) for v in f) for f in fs] for name, fs in both.facets.items()})
        self.codes.add("W0605")
        self.facts["pieces"] = 2
        self.clamp = ["left"]

    def second_order(self, move):
        m, edges = self.mesh, {}
        order = [(0, 1), (1, 2), (2, 0)] if self.dim == 2 else [(0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3)]
        self.middles = []
        points = []
        self.facts |= {"offset": 0.0, "relative": 0.0, "curved": 0}
        for c in m.cells:
            row = []
            for i, j in order:
                key = tuple(sorted((c[i], c[j])))
                if key not in edges:
                    a, b = m.points[key[0]], m.points[key[1]]
                    off = move(np.linalg.norm(b - a))
                    size = np.linalg.norm(off)
                    if size > 0:
                        self.facts["offset"] = max(self.facts["offset"], size)
                        self.facts["relative"] = max(self.facts["relative"], size / np.linalg.norm(b - a))
                        self.facts["curved"] += 1
                    edges[key] = len(points)
                    points.append((a + b) / 2 + off)
                row.append(edges[key])
            self.middles.append(row)
        self.middle_points = np.array(points)
        self.facts["edges"] = len(edges)

    def curved(self):
        size = 10 ** self.random.uniform(-7, -0.7)

        def move(length):
            if self.random.random() < 0.7:
                return np.zeros(self.dim)
            v = self.random.normal(size=self.dim)
            return size * self.random.uniform(0.2, 1) * length * v / np.linalg.norm(v)

        self.second_order(move)
        if self.facts["curved"] > 0:
            self.codes.add("W0602")

    def straight(self):
        self.second_order(lambda length: np.zeros(self.dim))

    def flat(self):
        """One cell more, apart, just above or below the limit of 1e-14."""
        above = self.random.random() < 0.5
        want = 1e-14 * (1.05 if above else 0.95)
        height = want * (2 if self.dim == 2 else 12)
        corners = [[0, 0], [1, 0], [0.5, height]] if self.dim == 2 else \
            [[0, 0, 0], [1, 0, 0], [0.5, 0.5, 0], [0.5, 0.25, height]]
        alone = Mesh(corners, [list(range(self.dim + 1))], {})
        self.mesh = Mesh(np.vstack([alone.points, self.mesh.points + 3]),
                         np.vstack([alone.cells, self.mesh.cells + self.dim + 1]),
                         {n: [tuple(int(v) + self.dim + 1 for v in f) for f in fs] for n, fs in self.mesh.facets.items()})
        if above:
            self.codes |= {"W0605", "E0425"}
            self.facts["pieces"] = 2
        else:
            self.codes = {"E0603"}

    # --- files

    def msh(self, turn, scale, shift):
        mesh = self.mesh.moved(turn, scale, shift)
        text = mesh.msh()
        if self.middles is None:
            return text
        n = len(mesh.points)
        more = scale * self.middle_points @ turn.T + shift
        nodes = "".join(" ".join([str(n + k + 1), *(repr(float(v)) for v in [*p, *[0.0] * (3 - self.dim)])]) + "\n"
                        for k, p in enumerate(more))
        text = text.replace(f"$Nodes\n{n}\n", f"$Nodes\n{n + len(more)}\n").replace("$EndNodes", nodes + "$EndNodes")
        out, cell = [], 0
        kind, second = ("2", "9") if self.dim == 2 else ("4", "11")
        in_elements = False
        for line in text.split("\n"):
            words = line.split()
            in_elements = in_elements and line != "$EndElements" or line == "$Elements"
            if in_elements and len(words) > 5 and words[1] == kind and self.is_cell(words):
                words[1] = second
                line = " ".join(words + [str(n + m + 1) for m in self.middles[cell]])
                cell += 1
            out.append(line)
        assert cell == len(self.mesh.cells)
        return "\n".join(out)

    def is_cell(self, words):
        return len(words) == 5 + self.dim + 1

    def script(self):
        names = list(self.mesh.facets)
        clamp = ["left"]
        if self.held and "left2" in names:
            clamp.append("left2")
        clamp = getattr(self, "clamp", clamp)
        lines = ['mesh body = gmsh("body.msh")', *(f'part {c} = body.group("{c}")' for c in clamp)]
        zero = ", ".join(f"zero on {c}" for c in clamp)
        lines += [f"space V = scalar P1 on body, {zero}", "find u in V such that for all v in V",
                  "  integral(body, dot(grad(u), grad(v))) = integral(body, v)", "report", "  table size = norm(u)"]
        return "\n".join(lines) + "\n"


def judge(scene, scale, found):
    """What is wrong with the findings ({code: message}); empty: nothing."""
    looked_at = {c for c in found if c.startswith("W060") and c != "W0601"} | {c for c in found if c[0] == "E"}
    if looked_at != scene.codes:
        return f"said {sorted(looked_at)}, true {sorted(scene.codes)}"
    facts = scene.facts

    def number(code, pattern):
        match = re.search(pattern, found[code])
        return float(match[1]) if match else None

    if "pieces" in facts and "W0605" in found and number("W0605", r"in (\d+) pieces") != facts["pieces"]:
        return "pieces: " + found["W0605"]
    if facts.get("doubled"):
        said = 1 if "a node stands" in found["W0603"] else number("W0603", r"(\d+) nodes stand")
        if said != facts["doubled"]:
            return f"{facts['doubled']} double nodes: " + found["W0603"]
    if "depth" in facts:
        depth = number("W0604", r"by up to (\S+) at") / scale
        if not 0 < depth <= 1.01 * facts["depth"]:
            return f"depth at most {facts['depth'] * scale}: " + found["W0604"]
    if "W0602" in scene.codes:
        text = found["W0602"]
        numbers = re.search(r"straight: (\d+) of (\d+) edges .* by up to (\S+) at .* up to (\S+) % of", text)
        want = facts["curved"], facts["edges"], facts["offset"] * scale, 100 * facts["relative"]
        for said, true, error in zip(map(float, numbers.groups()), want, (0, 0, 6e-3, 6e-2)):
            if abs(said - true) > error * true:
                return f"{want}: " + text
        gain = float(re.search(r"changes by (\S+) %", text)[1]) / 100
        if abs(gain - scene_gain(scene)) > 6e-2 * abs(gain) + 1e-13:
            return f"gain {scene_gain(scene)}: " + text
    return ""


def scene_gain(scene):
    """(straight - curved) / curved, from the map's determinant at a 4 x 4 (x 4) tensor Gauss rule on the cell."""
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = (x + 1) / 2, w / 2
    dim, total, straight = scene.dim, 0.0, 0.0
    order = [(0, 1), (1, 2), (2, 0)] if dim == 2 else [(0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3)]
    rule = []
    for at in itertools.product(range(4), repeat=dim):  # Duffy's map of the cube to the simplex
        s = [x[i] for i in at]
        weight = np.prod([w[i] for i in at])
        left, bary = 1.0, []
        for k in range(dim):
            bary.append(left * s[k])
            weight *= left if k < dim else 1.0
            left *= 1 - s[k]
        rule.append((np.array([left, *bary]), weight))
    slopes = np.vstack([-np.ones(dim), np.eye(dim)])
    for c, row in zip(scene.mesh.cells, scene.middles):
        p = scene.mesh.points[c]
        straight += volume(p)
        offs = [scene.middle_points[m] - (p[i] + p[j]) / 2 for m, (i, j) in zip(row, order)]
        sign = np.sign(np.linalg.det(p[1:] - p[0]))
        for bary, weight in rule:
            jac = p.T @ slopes
            for off, (i, j) in zip(offs, order):
                jac = jac + 4 * np.outer(off, bary[i] * slopes[j] + bary[j] * slopes[i])
            total += sign * weight * np.linalg.det(jac)
    return (straight - total) / total


def findings(program, folder, command):
    done = subprocess.run([program, command, "scene.hvi", "--diagnostics", "json", "--quiet"]
                          + (["--no-files"] if command == "run" else []),
                          cwd=folder, capture_output=True, text=True, timeout=120)
    return {d["code"]: d["message"] for d in map(json.loads, done.stderr.splitlines())}, done.returncode


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=lambda p: str(pathlib.Path(p).resolve()))
    parser.add_argument("--scenes", type=int, default=220)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--data", type=pathlib.Path, nargs="*", default=[])
    options = parser.parse_args()
    certified = wrong = refused = count = 0
    for k in range(options.scenes) if options.only is None else [options.only]:
        random = np.random.default_rng([options.seed, k])
        scene = Scene(random, KINDS[k % len(KINDS)])
        turn, scale = turning(random, scene.dim), 10 ** random.uniform(-6, 6)
        shift = scale * random.normal(size=scene.dim) * (0 if random.random() < 0.4 else 10 ** random.uniform(-1, 2))
        if scene.kind == "flat":  # rounding of a moved cell would be of the size of its height
            turn, scale, shift = np.eye(scene.dim), 1.0, 0.0
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.keep or pathlib.Path(temporary)) / str(k)
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "body.msh").write_text(scene.msh(turn, scale, shift))
            (folder / "scene.hvi").write_text(scene.script())
            for command in ("check", "run"):
                count += 1
                found, code = findings(options.program, folder, command)
                fault = judge(scene, scale, found)
                if not fault and (code == 0) != (not any(c[0] == "E" for c in scene.codes)):
                    fault = f"exit code {code}"
                certified += not fault
                wrong += bool(fault)
                if fault:
                    print(f"scene {k} ({scene.kind}, {scene.dim}D), {command}: {fault}", file=sys.stderr)
    for path in sorted(p for folder in options.data for p in folder.glob("**/*.msh")):
        done = subprocess.run([options.program, "mesh", path], capture_output=True, text=True, timeout=120)
        if done.returncode != 0:
            continue  # made to be refused
        count += 1
        alarm = set(re.findall(r"warning\[(\w+)\]", done.stderr)) != TWO_BODIES.get(path.name, set())
        wrong, certified = wrong + alarm, certified + (not alarm)
        if alarm:
            print(f"{path}: {done.stderr}", file=sys.stderr)
    print(f"family meshes: scenes {count}, certified {certified}, wrong {wrong}, refused {refused}")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
