"""No two files of a folder give one name to things of their own: several files are compiled as one, and which ones changes with every file
that comes or goes (docs/decisions/0007).

usage: local_names.py ROOT
"""
import collections
import pathlib
import re
import sys

CONSTANT = re.compile(r"^(?:inline )?(?:constexpr|const) [^;({]*?\b(\w+)(?:\[[^\]]*\])*\s*(?:=|\{)", re.M)
TYPE = re.compile(r"^(?:struct|class|enum class|enum) (\w+)", re.M)
FUNCTION = re.compile(r"^(?=\w)(?!return|else|using|namespace|struct|class|enum|template)[\w:<>,&*\[\] ]+?[ &*](\w+)\(([^;{}]*?)\)"
                      r"(?: const| noexcept)* \{", re.M | re.S)


def own_text(text):
    """What stands in namespaces without a name, without comments."""
    out, inside = [], False
    for line in text.split("\n"):
        inside = line == "namespace {" or inside and line != "} // namespace"
        if inside:
            out.append(re.sub(r"//.*", "", line))
    return "\n".join(out)


def own_names(text):
    """Constants, types, and functions with the types of their arguments."""
    text = own_text(text)
    yield from (match[1] for pattern in (CONSTANT, TYPE) for match in pattern.finditer(text))
    for match in FUNCTION.finditer(text):
        types = re.sub(r"\s*\b\w+_?\s*(?=,|$)", "", match[2])
        yield f"{match[1]}({' '.join(types.split())})"


def main():
    root = pathlib.Path(sys.argv[1])
    twice, count = [], 0
    for folder in sorted({path.parent for top in ("lang", "solver") for path in (root / top).rglob("*.cpp")}):
        files = collections.defaultdict(set)
        for path in sorted(folder.glob("*.cpp")):
            for name in own_names(path.read_text()):
                files[name].add(path.name)
        count += len(files)
        twice += [f"{folder.relative_to(root)}: {name} in {', '.join(sorted(where))}" for name, where in files.items() if len(where) > 1]
    print("\n".join(twice) or f"{count} names, none twice in a folder")
    return 1 if twice or count < 1000 else 0


sys.exit(main())
