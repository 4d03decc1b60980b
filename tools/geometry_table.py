"""The geometries that gmsh meshes, from the table that the program itself reads."""
import pathlib
import re

TABLE = pathlib.Path(__file__).resolve().parent.parent / "solver/mesh/geometries.cpp"
ENTRY = re.compile(r'\{"(\w+)",\s*([23]),\s*\{([^}]*)\},\s*\{([^}]*)\},\s*\{([^}]*)\}')
CONDITION = re.compile(r'\{"(\w+)",\s*"([^"]*)",')


def words(text):
    return [w.strip().strip('"') for w in text.split(",") if w.strip()]


def geometries():
    """(name, dimension, arguments, defaults, groups) of each."""
    text = TABLE.read_text()
    found = [(m[1], m[2], *(words(m[k]) for k in (3, 4, 5))) for m in ENTRY.finditer(text[text.index("geometries() {"):])]
    assert len(found) >= 12, "the table of geometries is read wrong"
    return found


def conditions():
    """What has to hold between the numbers of each, by name."""
    text = TABLE.read_text()
    out = {}
    for name, what in CONDITION.findall(text[:text.index("geometries() {")]):
        out.setdefault(name, []).append(what)
    return out
