"""Names of files that are not there: what may have been meant is told, and a folder called stdlib is one's own.

usage: files_meant.py HVI_RUN"""
import pathlib
import re
import subprocess
import sys
import tempfile

PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
SCRIPT = """import "laws/own.hvi"
import friction
mesh bar = gmsh("bar.msh")
part left = bar.left
fn pull(s) = table("pull.csv", s)
space V = scalar P1 on bar, zero on left
find u in V such that for all v in V
    integral(bar, dot(grad(u), grad(v))) = integral(bar, pull(0.5)*k*v)
report
  table a = u at [1]
"""
MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
0 1 "left"
1 2 "body"
$EndPhysicalNames
$Nodes
2
1 0 0 0
2 1 0 0
$EndNodes
$Elements
2
1 15 2 1 1 1
2 1 2 2 1 1 2
$EndElements
"""
FILES = {"laws/own.hvi": "param k = 2\n", "laws/other.hvi": "fn twice(a) = 2*a\n", "bar.msh": MESH, "pull.csv": "0,1\n1,3\n", "more/deep.csv": "0,1\n1,3\n",
         "more/deep.msh": MESH}
# (what is changed, to what, code, what the help says to write)
WRONG = [
    ('"laws/own.hvi"', '"own.hvi"', "E0601", "laws/own.hvi"),
    ('"laws/own.hvi"', '"laws/owm.hvi"', "E0601", "laws/own.hvi"),
    ('"laws/own.hvi"', '"laws/own"', "E0601", "laws/own.hvi"),
    ("import friction", 'import "friction.hvi"', "E0601", "import friction"),
    ("import friction", "import beside", "E0318", 'import "beside.hvi"'),
    ('"pull.csv"', '"Pull.csv"', "E0601", "pull.csv"),
    ('"pull.csv"', '"deep.csv"', "E0601", "more/deep.csv"),
    ('"bar.msh"', '"bars.msh"', "E0601", "bar.msh"),
    ('"bar.msh"', '"deep.msh"', "E0601", "more/deep.msh"),
    ('"bar.msh"', '"nothing_like_it.msh"', "E0601", None),
    ('"laws/own.hvi"', '"lawss/own.hvi"', "E0601", "laws/own.hvi"),
    ('"laws/own.hvi"', '"lasw/owm.hvi"', "E0601", "laws/own.hvi"),
    ('"laws/own.hvi"', '"somewhere/else.hvi"', "E0601", None),
]
# (words of the command line, exit code, what it is told to write)
TYPED = [
    (["run", "--no-files", "scrpt.hvi"], 1, "script.hvi"),
    (["run", "--no-files", "script.hvl"], 1, "script.hvi"),
    (["run", "--no-files", "script"], 1, "script.hvi"),
    (["script.hv"], 2, "script.hvi"),
    (["lwas/own.hvi"], 1, "laws/own.hvi"),
    (["laws/owm"], 2, "laws/own.hvi"),
    (["lwas/extra.hvi"], 1, "laws/extra.hvi"),  # not the one of another folder
    (["check", "script.hvi", "./other.hvi"], 1, "laws/other.hvi"),
    (["plan", "pull.cs"], 1, "pull.csv"),  # any file where no script is like it
    (["fmt", "scrpt.hvi"], 1, "script.hvi"),
    (["mesh", "bra.msh"], 1, "bar.msh"),
    (["mesh", "bar.mhs"], 1, "bar.msh"),
    (["test", "scripts.hvi"], 5, "script.hvi"),
    (["run", "--no-files", "nothing_like_it.hvi"], 1, None),
    (["run", "--no-files", "none/of/these.hvi"], 1, None),
    (["run", "--no-files", "laws"], 1, None),
]


def checked(folder, text):
    (folder / "script.hvi").write_text(text)
    done = subprocess.run([PROGRAM, "run", "--no-files", "script.hvi"], cwd=folder, capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout, done.stderr


def main():
    failures = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for path, text in {**FILES, "beside.hvi": "fn thrice(a) = 3*a\n", "drafts/extra.hvi": "", "laws/extra.hvi": ""}.items():
            (folder / path).parent.mkdir(exist_ok=True)
            (folder / path).write_text(text)
        code, out, err = checked(folder, SCRIPT)
        if code != 0:
            failures.append(f"the right script: {err}")
        for old, new, wanted, meant in WRONG:
            code, out, err = checked(folder, SCRIPT.replace(old, new))
            helps = re.findall(r"help: .*`(.+)`", err)
            if code != 1 or f"error[{wanted}]" not in err or (helps[:1] != [meant] if meant else helps):
                failures.append(f"{old} => {new}: {err}")
        (folder / "script.hvi").write_text(SCRIPT)
        for words, wanted, meant in TYPED:
            done = subprocess.run([PROGRAM, *words], cwd=folder, capture_output=True, text=True, timeout=60)
            helps = re.findall(r"did you mean `(.+)`\?", done.stderr)
            if done.returncode != wanted or helps != [meant] * bool(meant):
                failures.append(f"{words}: exit code {done.returncode}\n{done.stderr}")
        (folder / "laws/other.hvi").write_text('import "third.hvi"\n')  # beside the file that imports it, not beside the script
        (folder / "laws/third.hvi").write_text("fn twice(a) = 2*a\n")
        code, out, err = checked(folder, SCRIPT.replace("laws/own", "laws/other"))
        if "did you mean `laws/third.hvi`?" not in err:
            failures.append(f"an import beside the file that imports: {err}")
        # A name of one's own stands twice in files of one's own, whatever their folder is called: no silent choice of one.
        (folder / "stdlib").mkdir()
        (folder / "stdlib/own.hvi").write_text("param k = 4\n")
        code, out, err = checked(folder, SCRIPT.replace("laws/own", "stdlib/own").replace("mesh bar", "param k = 3\nmesh bar"))
        if code != 1 or "error[E0302]" not in err:
            failures.append(f"a folder called stdlib: exit code {code}\n{out}{err}")
    print(*failures, sep="\n")
    print(f"{len(WRONG) + len(TYPED) + 3} calls, {len(failures)} failures")
    sys.exit(bool(failures))


main()
