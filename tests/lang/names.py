"""Names that are commands elsewhere, typed into every place that takes a name: a script's file, output folders, report files, titles,
groups of meshes, parameters. Nothing is run, nothing is written outside the output folder, pictures are whole.
usage: names.py HVI_RUN"""
import pathlib
import subprocess
import sys
import tempfile

EVIL = ["|touch PWNED;", "`touch PWNED`", "$(touch PWNED)", "it's", "a'; system('touch PWNED'); '", 'a"; system("touch PWNED"); "',
        "a\nset output '|touch PWNED'", "a b", "-n", "--help", "%s%n", "a\x1b[31mb", "..a", "~", "a&touch PWNED&"]
SCRIPT = """param n = 2
mesh slab = {mesh}
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential layer(r) = 50*max(r, 0)^2
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 1] by 2 steps from u = 0
such that for all v in V
    integral(slab, B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu))
 >= integral(slab, dot([0, -t], v))
report
  table a = u.y at [1, 0]{table}
  picture u{picture}
{study}"""
MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
1 1 "top"
1 2 "bottom"
2 3 "{name}"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 2 0 0
3 2 1 0
4 0 1 0
$EndNodes
$Elements
4
1 1 2 1 1 3 4
2 1 2 2 2 1 2
3 2 2 3 3 1 2 3
4 2 2 3 3 1 3 4
$EndElements
"""
PNG = b"\x89PNG\r\n\x1a\n"
problems, places = [], 0


def check(what, holds, about=""):
    if not holds:
        problems.append(f"{what} {about}")


def go(program, folder, *words):
    global places
    places += 1
    return subprocess.run([program, *words], cwd=folder, capture_output=True, timeout=120)


def whole(folder):
    """Every picture in a folder ends as it should."""
    for path in folder.rglob("*"):
        if path.suffix == ".png" and path.is_file():
            content = path.read_bytes()
            check(f"{path.name!r} is a whole PNG", content.startswith(PNG) and b"IEND" in content[-12:])


def script(**changes):
    return SCRIPT.format(**{"mesh": "rectangle(2, 1, cells = [2*n, n])", "table": "", "picture": "", "study": "", **changes})


def file_names(program, folder):
    """The script's own name is the title and the stem of all outputs."""
    for k, name in enumerate(EVIL):
        home = folder / f"file{k}"
        home.mkdir()
        path = home / f"{name}.hvi"
        path.write_text(script())
        before = {p.name for p in home.iterdir()}
        done = go(program, home, "run", f"./{name}.hvi")
        check(f"run of {name!r}", done.returncode == 0, done.stderr[-300:])
        made = {p.name for p in home.iterdir()} - before
        check(f"run of {name!r} makes its folder only", made == {name}, made)
        check(f"run of {name!r} draws", any(p.suffix == ".png" for p in (home / name).rglob("*")))
        if k < 4:
            check(f"stability of {name!r}", go(program, home, "stability", "--quiet", f"./{name}.hvi").returncode == 0)


def folders(program, folder):
    """The output folder of the command line."""
    for k, name in enumerate(EVIL):
        home = folder / f"folder{k}"
        home.mkdir()
        (home / "a.hvi").write_text(script())
        done = go(program, home, "run", "a.hvi", "-o", f"./{name}")
        check(f"-o {name!r}", done.returncode == 0, done.stderr[-300:])
        check(f"-o {name!r} makes its folder only", {p.name for p in home.iterdir()} == {"a.hvi", name})


def report_files(program, folder):
    """Files that the script names: written under that name, or refused."""
    home = folder / "files"
    home.mkdir()
    for name in EVIL:
        if '"' in name or "\n" in name:
            continue
        (home / "a.hvi").write_text(script(table=f' to "{name}.csv"', picture=f' to "{name}.png"'))
        done = go(program, home, "run", "a.hvi", "-o", "out")
        check(f"files {name!r}", done.returncode in (0, 1), done.stderr[-300:])
        if done.returncode == 0:
            check(f"files {name!r} are there", (home / "out" / f"{name}.csv").exists() and (home / "out" / f"{name}.png").exists())


def group_names(program, folder):
    """Groups of a mesh are printed without what a terminal would obey."""
    home = folder / "groups"
    home.mkdir()
    for name in EVIL:
        if '"' in name:
            continue
        (home / "m.msh").write_text(MESH.format(name=name.replace("\n", " ")))
        (home / "a.hvi").write_text(script(mesh='gmsh("m.msh")'))
        for words in (["mesh", "m.msh"], ["mesh", "a.hvi"], ["run", "a.hvi", "-o", "out"]):
            done = go(program, home, *words)
            check(f"group {name!r} in {words}", b"\x1b" not in done.stdout + done.stderr)
        (home / "b.hvi").write_text(script(mesh='gmsh("m.msh")').replace("slab.top", 'slab.group("none")'))
        done = go(program, home, "check", "--no-color", "b.hvi")
        check(f"group {name!r} in the list of an error", done.returncode == 1 and b"\x1b" not in done.stderr, done.stderr[-200:])


def studies(program, folder):
    home = folder / "study"
    home.mkdir()
    for name in EVIL[:4]:
        (home / f"{name}.hvi").write_text(script(study="study vary n in [1, 2] against finest in V\n"))
        done = go(program, home, "study", "--quiet", f"./{name}.hvi")
        check(f"study of {name!r}", done.returncode == 0, done.stderr[-300:])


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "scripts"
        folder.mkdir()
        for part in (file_names, folders, report_files, group_names, studies):
            part(program, folder)
        ran = [str(p) for p in pathlib.Path(temporary).rglob("*") if "PWNED" == p.name]
        check("nothing ran", not ran and not pathlib.Path("PWNED").exists(), ran)
        whole(folder)
    print("\n".join(problems) or f"{places} places")
    sys.exit(bool(problems))


main()
