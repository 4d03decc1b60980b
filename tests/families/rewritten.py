"""The same model in other words: the same answer.

usage: rewritten.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

The scenes of units.py, with some of these changes to the script, drawn at random: terms in another order, terms in two shares, bodies and grounds in two
halves with a term each, unknowns in another order, another start of time, other names, superpotentials by their slopes, declarations in another
order, terms that are zero. Each column of the table must be the same.
"""
import argparse
import pathlib
import re
import sys
import tempfile

import numpy as np

import units

TERM = re.compile(r"^ *([+-]|>=)? *(-?)(integral\(.*\))$")
START = 5.0  # of a time that begins later


class Script:
    """A script of units.py in parts: lines before `find`, the line of `find`, terms with signs, loads, lines of the report."""

    def __init__(self, text):
        lines = text.strip().split("\n")
        find = next(i for i, line in enumerate(lines) if line.startswith("find"))
        end = next(i for i, line in enumerate(lines) if line.startswith(" >="))
        self.declared, self.find, self.such = lines[:find], lines[find], lines[find + 1]
        self.terms = []
        for line in lines[find + 2:end]:
            sign, minus, term = TERM.match(line).groups()
            self.terms.append(("-" if (sign == "-") != (minus == "-") else "+", term))
        self.loads = lines[end][4:]
        self.report = lines[end + 1:]

    def text(self):
        (sign, first), *rest = self.terms
        terms = [f"    {'-' if sign == '-' else ''}{first}"] + [f"  {sign} {term}" for sign, term in rest]
        return "\n".join([*self.declared, self.find, self.such, *terms, f" >= {self.loads}", *self.report]) + "\n"

    def change(self, pattern, by, everywhere=True):
        def put(line):
            return re.sub(pattern, by, line)
        if everywhere:
            self.declared = [put(line) for line in self.declared]
        self.find, self.such, self.loads = put(self.find), put(self.such), put(self.loads)
        self.terms = [(sign, put(term)) for sign, term in self.terms]
        self.report = [put(line) for line in self.report]


def shuffled(script, random):
    """Terms in another order."""
    script.terms = [script.terms[i] for i in random.permutation(len(script.terms))]


def shared(script, random):
    """Terms in two shares; laws stay."""
    out = []
    for sign, term in script.terms:
        share = round(random.uniform(0.1, 0.9), 3)
        out += [(sign, term)] if "^0" in term else [(sign, f"{share} * {term}"), (sign, f"{1 - share!r} * {term}")]
    script.terms = out


def halves_of(part, script):
    """Each term on the part, and each integral of it that is asked for, is a sum over its halves."""
    def put(text):
        return re.sub(rf"integral\({part}, ", f"integral({part}_west, ", text), re.sub(rf"integral\({part}, ", f"integral({part}_east, ", text)
    out = []
    for sign, term in script.terms:
        west, east = put(term)
        out += [(sign, term)] if west == term else [(sign, west), (sign, east)]
    script.terms = out
    last = max(i for i, line in enumerate(script.declared) if line.startswith("part "))
    script.declared[last + 1:last + 1] = [f"part {part}_west = {part} where x < 0.5", f"part {part}_east = {part} where x > 0.5"]
    script.report = [re.sub(rf"= (integral\({part}, [^,]*\))", lambda m: "= " + " + ".join(put(m[1])), line) for line in script.report]


def halved_body(script, random):
    """The body in two halves; a state's forms are on its own part (E0429)."""
    if not re.search("mesh upper|state d on body", "\n".join(script.declared)):
        halves_of("body", script)


def halved_ground(script, random):
    """The ground in two halves; a state's laws are on its own part (E0429)."""
    if not re.search("mesh upper|state bond on ground", "\n".join(script.declared)):
        halves_of("ground", script)


def other_unknown_first(script, random):
    """Unknowns in another order."""
    head, conditions = re.match(r"find (.*?)((?: with| for|$).*)", script.find).groups()
    unknowns = re.split(r", (?=\w+ in)", head)
    tests = re.match(r"such that for all (.*)", script.such)[1].split(", ")
    order = random.permutation(len(unknowns))
    script.find = "find " + ", ".join(unknowns[i] for i in order) + conditions
    script.such = "such that for all " + ", ".join(tests[i] for i in order)


def later(script, random):
    """Time begins later."""
    if " for t in " not in script.find:
        return
    script.change(r"\bt\b(?! in)", f"(t - {START})", everywhere=False)
    script.find = script.find.replace("[0, 1.0]", f"[{START}, {START + 1.0}]")


def renamed(script, random):
    """Other names of functions, laws and parts."""
    for name in ("u", "v", "p", "q", "theta", "eta", "phi", "psi", "ground", "rub", "press", "layer", "slip"):
        if random.random() < 0.7 and name not in ("p", "q", "phi", "psi"):
            script.change(rf"(?<![.\w]){name}\b", f"{name}_2")


def by_slopes(script, random):
    """Superpotentials by their slopes."""
    for i, line in enumerate(script.declared):
        radial = re.match(r"(superpotential \w+\(w\)) = (.*)\*norm\(w\)$", line)
        square = re.match(r"(superpotential \w+)\(r\) = ([\d.]+)\*max\(0.0, r\)\^2$", line)
        if radial:
            script.declared[i] = f"{radial[1]} with slope {radial[2]}"
        elif square:
            script.declared[i] = f"{square[1]}(r) with slope\n  | r < 0 -> 0\n  | otherwise -> 2*{square[2]}*r"


def declared_otherwise(script, random):
    """Spaces first among what follows the parts."""
    last = max(i for i, line in enumerate(script.declared) if line.startswith("part "))
    rest = script.declared[last + 1:]
    spaces = [line for line in rest if line.startswith("space ")]
    script.declared[last + 1:] = spaces + [line for line in rest if not line.startswith("space ")]


def with_zeros(script, random):
    """Terms that are zero."""
    script.terms.append(("+", "integral(body, 0*" + ("dot(u, v)" if "vector" in "\n".join(script.declared) else "u*v") + ")"))


CHANGES = [with_zeros, shuffled, shared, halved_body, halved_ground, other_unknown_first, by_slopes, declared_otherwise, later, renamed]


def main():
    parse = argparse.ArgumentParser()
    parse.add_argument("program", type=pathlib.Path)
    parse.add_argument("--scenes", type=int, default=30)
    parse.add_argument("--seed", type=int, default=1)
    parse.add_argument("--only", type=int)
    parse.add_argument("--keep", type=pathlib.Path)
    words = parse.parse_args()
    program, wrong, worst = words.program.resolve(), 0, 0.0
    for k in range(words.scenes) if words.only is None else [words.only]:
        random = np.random.default_rng([words.seed, k])
        scene = units.Scene(random)
        plain = units.written(scene.text, dict.fromkeys(units.REACH, 0))
        script = Script(plain)
        drawn = [change for change in CHANGES if random.random() < 0.4]
        for change in drawn:
            change(script, random)
        with tempfile.TemporaryDirectory() as name:
            said, apart = units.compared(program, words.keep or pathlib.Path(name), scene, plain, script.text(), lambda dimension: 1.0)
        worst = max(worst, apart)
        if said:
            wrong += 1
            print(f"scene {k} ({scene.kind.__name__}, {scene.dim}D, {scene.solver}, {[change.__name__ for change in drawn]}): {said}")
    print(f"{words.scenes} scenes, worst {worst:.1e}; {wrong} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
