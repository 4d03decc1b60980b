"""What a study keeps is used again only while everything that decides it is the same: each ingredient is changed in turn, and the
rows are counted that were taken from the journal.  usage: stale.py HVI_RUN ROOT"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

program, root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
SCRIPT = """import "law.hvi"
param n = 1
param pull = 1
mesh slab = gmsh("slab.msh", refinements = n)
part left = slab.boundary where x < 1e-9
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on slab, zero on left
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(slab, stiff()*B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v))
  = integral(slab, dot([0, -pull*table("load.csv", t)], v))
report
  table a = norm(u)
study vary n in [1, 2, 3] against finest in V
"""


def write(folder, **changes):
    mesh = (root / "tests/data/cross_5x2.msh").read_text()
    files = {"model.hvi": SCRIPT, "law.hvi": "fn stiff() = 1\n", "load.csv": "0,0\n1,1\n", "slab.msh": mesh, **changes}
    for name, text in files.items():
        (folder / name).write_text(text)


def study(folder, *options):
    """The errors, and how many rows came from the journal."""
    journal = folder / "out/study.jsonl"
    before = len(journal.read_text().splitlines()) if journal.exists() else 0
    subprocess.run([program, "study", folder / "model.hvi", "-o", folder / "out", "--json", folder / "study.json", "--quiet", *options],
                   check=True, stdout=subprocess.DEVNULL)
    rows = json.loads((folder / "study.json").read_text())["rows"]
    fresh = len(journal.read_text().splitlines()) - before
    return [row["error"]["V_max"] for row in rows if "error" in row], fresh


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    write(folder)
    first, fresh = study(folder)
    assert fresh >= 3, fresh
    again, fresh = study(folder)
    assert fresh == 0 and again == first, "the same study runs nothing"
    nodes = (folder / "slab.msh").read_text()
    at = nodes.index("2.5")
    changes = {"a value of a table": ({"load.csv": "0,0\n1,7\n"}, []),
               "a node of the mesh": ({"slab.msh": nodes[:at] + "2.6" + nodes[at + 3:]}, []),
               "an import": ({"law.hvi": "fn stiff() = 3\n"}, []),
               "the script": ({"model.hvi": SCRIPT.replace("by 4 steps", "by 5 steps")}, []),
               "a parameter": ({}, ["-D", "pull=2"])}
    for what, (files, options) in changes.items():
        write(folder, **files)
        errors, fresh = study(folder, *options)
        assert fresh >= 3, f"{what}: {fresh} rows ran"
        shutil.rmtree(folder / "out")
        alone, _ = study(folder, *options)
        assert errors == alone, f"{what}: {errors} against {alone} without a journal"
    # The file of a mesh that is one of several pieces decides, too.
    pieces = SCRIPT.replace('mesh slab = gmsh("slab.msh", refinements = n)', """mesh upper = gmsh("slab.msh", refinements = n)
mesh lower = rectangle(1, 1, cells = [1, 1], at = [0, -9])
mesh slab = upper + lower""")
    write(folder, **{"model.hvi": pieces})
    study(folder)
    write(folder, **{"model.hvi": pieces, "slab.msh": nodes[:at] + "2.6" + nodes[at + 3:]})
    _, fresh = study(folder)
    assert fresh >= 3, f"a node of a piece: {fresh} rows ran"
    # A row that was changed by hand, or half written, counts for nothing.
    write(folder)
    shutil.rmtree(folder / "out")
    study(folder)
    journal = folder / "out/study.jsonl"
    for damage in (lambda text: text.replace('"V_max"', '"W_max"').replace('"cpu":', '"cpu":1'),
                   lambda text: text.replace('"unknowns":', '"unknowns":1'), lambda text: text[:len(text) // 2]):
        good = journal.read_text()
        journal.write_text(damage(good))
        errors, fresh = study(folder)
        assert fresh >= 1 and errors == first, (fresh, errors, first)
        journal.write_text(good)
print("stale: nothing")
