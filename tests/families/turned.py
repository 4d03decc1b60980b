"""Every example and test scene that can be turned, turned by random angles, with each rule: the same answers.

usage: turned.py HVI_RUN [ROOT] [--scenes N] [--seed S] [--only NAME]

A script is turned as text: its mesh becomes a file with turned nodes, coordinates become functions of the turned ones,
vectors and components are turned with it. N counts pairs of runs (0: all scripts with all rules). Left out: scripts
that clamp single components or read components of tensors, and meshes whose parts are no sides of a box.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from solids import Mesh, turning

TOLERANCE = 1e-7  # of a value; the certificate's 1e-10 times what condition and softening make of it
SMALL = {"n": "5", "m": "5", "N": "4", "steps": "4", "size": "1"}  # no node where data jump in x
SIDES = [["left", "right"], ["bottom", "top"], ["back", "front"]]
STATEMENT = re.compile(r"^(?=(?:import|param|mesh|part|tensor|kernel|superpotential|fn|space|find|report|expect|study)\b)",
                       re.M)


class CannotTurn(Exception):
    pass


def closing(text, start):
    """Behind the bracket that closes the one at start."""
    depth = 0
    for k in range(start, len(text)):
        depth += (text[k] in "([") - (text[k] in ")]")
        if depth == 0:
            return k + 1
    raise CannotTurn("brackets")


def split(text):
    """At commas outside of brackets."""
    out, depth = [""], 0
    for c in text:
        depth += (c in "([") - (c in ")]")
        if c == "," and depth == 0:
            out.append("")
        else:
            out[-1] += c
    return out


class Turner:
    def __init__(self, turn, shift):
        self.turn, self.shift, self.dim = turn, shift, len(turn)

    def combined(self, row, entries):
        return " + ".join(f"({v!r})*({e.strip()})" for v, e in zip(map(float, row), entries))

    def vector(self, entries):
        return "[" + ", ".join(self.combined(row, entries) for row in self.turn) + "]"

    def place(self, entries):
        return "[" + ", ".join(f"{self.combined(row, entries)} + ({float(s)!r})"
                               for row, s in zip(self.turn, self.shift)) + "]"

    def axis(self, letter):
        return "[" + ", ".join(repr(float(v)) for v in self.turn[:, "xyz".index(letter)]) + "]"

    def coordinates(self):
        lines = []
        for k in range(self.dim):
            sum_ = " + ".join(f"({float(self.turn[j, k])!r})*({'xyz'[j]} - ({float(self.shift[j])!r}))"
                              for j in range(self.dim))
            lines.append(f"fn was_{'xyz'[k]}() = {sum_}\n")
        return "".join(lines)

    def brackets(self, text, places):
        """Lists of as many entries as dimensions: vectors, or where something is read."""
        out, k = "", 0
        while k < len(text):
            if text[k] != "[":
                out, k = out + text[k], k + 1
                continue
            end = closing(text, k)
            entries = [self.brackets(e, places) for e in split(text[k + 1:end - 1])]
            before = out.rstrip()
            if re.search(r"\bin$", before) or (re.search(r"\bat$", before) and not places):
                out += "[" + ", ".join(entries) + "]"
            elif re.search(r"\bat$", before):
                out += self.place(entries)
            elif len(entries) == self.dim:
                out += self.vector(entries)
            else:
                raise CannotTurn("a list of another length")
            k = end
        return out

    def expression(self, text, arguments=(), places=False):
        if re.search(r"\bsigma\b|\.(xx|xy|yy|xz|yz|zz)\b", text):
            raise CannotTurn("components of a tensor")
        # Coordinates first: components and vectors are written with numbers only.
        for letter in "xyz"[:self.dim]:
            if letter not in arguments:
                text = re.sub(rf"(?<![\w.]){letter}(?!\w)", f"was_{letter}()", text)
        text = self.brackets(text, places)
        return re.sub(r"(?<![\w.])(\w+'?(?:\.xi)?|reaction\(\w+\))\.([xyz])\b", lambda m: f"dot({m[1]}, {self.axis(m[2])})", text)


def with_rule(text, rule):
    """The statement with `rule` for its laws, where it has none."""
    out, k = "", 0
    for m in iter(lambda: re.compile(r"\bintegral\(").search(text, k), None):
        start, end = m.end() - 1, closing(text, m.end() - 1)
        inside = text[start + 1:end - 1]
        if "^0" in inside and "rule" not in inside and rule:
            inside += f", rule = {rule}"
        out, k = out + text[k:start] + "(" + inside + ")", end
    return out + text[k:]


def statements(path):
    text = re.sub(r"#.*", "", path.read_text())
    return [s.rstrip() + "\n" for s in STATEMENT.split(text) if s.strip()]


def turned(path, turner, rule):
    """The script with everything turned, on `turned.msh`."""
    out = []
    for s in statements(path):
        word = s.split()[0]
        if word in ("expect", "study"):
            continue
        if word == "mesh":
            s = f'mesh {s.split()[1]} = gmsh("turned.msh")\n'
        elif word == "part":
            s = re.sub(r"= (\w+)\.(left|right|bottom|top|front|back)\b", r'= \1.group("\2")', s)
            if "point(" in s:
                raise CannotTurn("a part of one point")
            s = turner.expression(s)
        elif rule == "gauss" and re.search(r"superpotential .*\.xi\b.*norm", s):
            raise CannotTurn("Coulomb's bound at more points than there are nodes: multipliers are not unique")
        elif word in ("fn", "superpotential"):
            arguments = re.findall(r"\w+", s[s.index("(") + 1:s.index(")")])
            head, body = s[:closing(s, s.index("("))], s[closing(s, s.index("(")):]
            s = head + turner.expression(body, arguments)
        elif word == "space" and re.search(r"zero\.\w", s):
            raise CannotTurn("a component is clamped")
        elif word == "tensor" and re.search(r"orthotropic|transverse|voigt|\[|\b[xyz]\b", s):
            raise CannotTurn("a tensor with directions")
        elif word == "find":
            if re.search(r"with \w+\.\w", s):
                raise CannotTurn("a component is imposed")
            s = with_rule(turner.expression(s), rule)
        elif word == "report":
            tables = re.findall(r"table\s+(.*?)(?=\b(?:table|fields|picture)\b|\Z)", s, re.S)
            if not tables:
                raise CannotTurn("no table")
            s = "report\n" + "".join("  table " + turner.expression(t, (), True).strip() + "\n" for t in tables)
        out.append(s)
    return turner.coordinates() + "".join(out)


def call(program, folder, script, values):
    options = [w for k, v in values.items() for w in ("-D", f"{k}={v}")]
    done = subprocess.run([program, "run", script, "--quiet", "--json", "result.json", "-o", "out", *options],
                          cwd=folder, capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        said = " ".join(done.stderr.split())
        return None, f"exit {done.returncode}: " + said[max(said.find("error["), 0):][:300]
    return json.loads((folder / "result.json").read_text()), ""


def small(path):
    """Parameters that make the scene a small one."""
    text = path.read_text()
    return {k: v for k, v in SMALL.items() if re.search(rf"^param {k}\s+=", text, re.M)}


def mesh_of(program, folder, path, values):
    """The mesh of a script, out of the field it writes, with the sides of its box as groups."""
    import meshio

    text = "".join(s for s in statements(path) if s.split()[0] not in ("expect", "study", "report"))
    unknown = re.search(r"^find\s+(\w+)", text, re.M)[1]
    (folder / "probe.hvi").write_text(text + f"report\n  table size = norm({unknown})\n  fields {unknown}\n")
    result, said = call(program, folder, "probe.hvi", values)
    if result is None:
        raise CannotTurn("does not run alone: " + said)
    grid = meshio.read(sorted((folder / "out").glob("*.vtu"))[-1])
    if grid.cells[0].type.startswith("line"):
        raise CannotTurn("one dimension")
    cells = grid.cells[0].data
    dim = 3 if grid.cells[0].type.startswith("tetra") else 2
    cells = cells[:, :dim + 1]
    used = np.unique(cells)
    points, cells = grid.points[used, :dim], np.searchsorted(used, cells)
    low, high = points.min(0), points.max(0)
    count = {}
    for c in cells:
        for k in range(dim + 1):
            f = tuple(sorted(np.delete(c, k).tolist()))
            count[f] = count.get(f, 0) + 1
    facets = {name: [] for pair in SIDES[:dim] for name in pair}
    for f, n in count.items():
        for axis in range(dim):
            for name, wall in zip(SIDES[axis], (low[axis], high[axis])):
                if n == 1 and all(abs(points[v, axis] - wall) <= 1e-9 * (high - low)[axis] for v in f):
                    facets[name].append(f)
    if sum(map(len, facets.values())) != sum(n == 1 for n in count.values()):
        raise CannotTurn("no box")
    return Mesh(points, cells, facets)


def scripts(root):
    for folder in ("examples", "tests/hard", "tests/published", "tests/convergence"):
        yield from sorted((root / folder).glob("*.hvi"))


def compared(one, other):
    """The largest difference of two results by their values, small ones by the largest."""
    worst = 0.0
    largest = max(abs(v) for v in one.values())
    for name, value in one.items():
        worst = max(worst, abs(value - other[name]) / max(abs(value), 1e-3 * largest, 1e-300))
    return worst


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=lambda p: str(pathlib.Path(p).resolve()))
    parser.add_argument("root", type=pathlib.Path, nargs="?", default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("--scenes", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only")
    options = parser.parse_args()
    pairs = [(p, rule) for p in scripts(options.root) for rule in ("", "midpoint", "gauss")
             if options.only in (None, p.stem) and (not rule or "^0" in p.read_text())]
    random = np.random.default_rng(options.seed)
    if options.scenes:
        pairs = [pairs[k] for k in sorted(random.permutation(len(pairs))[:options.scenes])]
    scenes = certified = wrong = refused = both = 0
    left_out, meshes = {}, {}
    for path, rule in pairs:
        if path.stem in left_out:
            continue
        values = small(path)
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            for data in [*path.parent.glob("*.msh"), *path.parent.glob("*.csv")]:
                (folder / data.name).write_bytes(data.read_bytes())
            try:
                mesh = meshes[path] = meshes.get(path) or mesh_of(options.program, folder, path, values)
                turn = turning(random, mesh.dim)
                shift = random.normal(size=mesh.dim) * np.ptp(mesh.points)
                results = []
                for q, s in ((np.eye(mesh.dim), 0 * shift), (turn, shift)):
                    (folder / "turned.msh").write_text(mesh.moved(q, 1.0, s).msh())
                    (folder / "turned.hvi").write_text(turned(path, Turner(q, s), rule))
                    results.append(call(options.program, folder, "turned.hvi", values))
            except CannotTurn as why:
                left_out[path.stem] = str(why)
                continue
        (one, said_one), (other, said_other) = results
        scenes += 1
        name = f"{path.stem} {rule or 'as written'}"
        if one is None and other is None and said_one.split("error[")[-1][:5] == said_other.split("error[")[-1][:5]:
            both += 1
            print(f"{name}: refused either way: {said_one}", file=sys.stderr)
        elif one is None or other is None:
            refused += 1
            print(f"{name}: refused {'as it is' if one is None else 'turned'}: {said_one or said_other}",
                  file=sys.stderr)
        else:
            certified += 1
            error = compared(one["final"], other["final"])
            if not error <= TOLERANCE:
                wrong += 1
                print(f"{name}: turned it differs by {error:.2e}", file=sys.stderr)
    for stem, why in left_out.items():
        print(f"left out: {stem}: {why}")
    print(f"refused either way {both}")
    print(f"family turned: scenes {scenes}, certified {certified}, wrong {wrong}, refused {refused}")
    return 0 if wrong == 0 and refused == 0 and (scenes > 0) else 1


if __name__ == "__main__":
    sys.exit(main())
