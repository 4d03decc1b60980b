"""The same model in other programs: the blocks of docs/coming_from.md give the number that its page expects, in each program that is here.
usage: coming_from.py SOURCE_FOLDER"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

page = (pathlib.Path(sys.argv[1]) / "docs/coming_from.md").read_text()
expected = float(re.search(r"expect tip = (\S+)", page)[1])


def block(tag):
    return re.search(rf"```{tag}\n(.*?)```", page, re.S)[1]


def mesh():
    """The rectangle's 64 triangles as MSH 2.2: regions 1 body, 2 left, 3 bottom."""
    n, m = 8, 4
    node = lambda i, j: j * (n + 1) + i + 1
    elements = []
    for i in range(n):
        for j in range(m):
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            elements += [(2, 1, a, b, c), (2, 1, a, c, d)]
    elements += [(1, 2, node(0, j), node(0, j + 1)) for j in range(m)] + [(1, 3, node(i, 0), node(i + 1, 0)) for i in range(n)]
    out = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str((n + 1) * (m + 1))]
    out += [f"{node(i, j)} {i / 4} {j / 4} 0" for j in range(m + 1) for i in range(n + 1)] + ["$EndNodes", "$Elements", str(len(elements))]
    out += [f"{k} {kind} 2 {tag} {tag} {' '.join(map(str, nodes))}" for k, (kind, tag, *nodes) in enumerate(elements, 1)]
    return "\n".join(out) + "\n$EndElements\n"


def run(folder, *words):
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, (words, done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout


def freefem(folder):
    (folder / "plate.edp").write_text(block("freefem"))
    return float(re.search(r"tip (\S+)", run(folder, "FreeFem++-nw", "-v", "0", "plate.edp"))[1])


def getfem(folder):
    (folder / "plate.py").write_text(block("getfem"))
    return float(re.search(r"tip (\S+)", run(folder, "/usr/bin/python3", "plate.py"))[1])


def getdp(folder):
    (folder / "plate.pro").write_text(block("getdp"))
    (folder / "plate.msh").write_text(mesh())
    run(folder, "getdp", "plate.pro", "-msh", "plate.msh", "-solve", "Solve", "-pos", "Tip", "-v", "2")
    return float((folder / "tip.txt").read_text().split()[-1])


def has_getfem():
    return subprocess.run(["/usr/bin/python3", "-c", "import getfem"], capture_output=True).returncode == 0


ran = 0
for name, program, here in (("FreeFEM", freefem, shutil.which("FreeFem++-nw")), ("GetFEM", getfem, has_getfem()),
                            ("GetDP", getdp, shutil.which("getdp"))):
    if not here:
        print(f"{name}: not on this machine")
        continue
    with tempfile.TemporaryDirectory() as folder:
        tip = program(pathlib.Path(folder))
    print(f"{name}: {tip!r}")
    assert abs(tip - expected) < 1e-12, (name, tip, expected)
    ran += 1
if ran == 0:
    print("skipped: none of these programs is on this machine")
    sys.exit(77)
