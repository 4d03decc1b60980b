"""A script reads nothing outside its folder, writes nothing outside the output folder, runs nothing, and meets limits as
errors: exit code 1 and the named code, never a crash.  usage: safety.py HVI_RUN"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

LONGEST = 300  # seconds that a mistake may take with sanitizers on a busy machine: what takes that long does not end
SLAB = """mesh slab = {mesh}
part roof = slab.top
tensor B = {tensor}
space V = vector P1 on slab, zero on roof
find u in V{time}
such that for all v in V
    integral(slab, B : eps(u) : eps(v))
  = integral(slab, dot([0, {load}], v))
report
  table a = u.y at [1, 0]{to}
"""
PLAIN = {"mesh": "rectangle(2, 1, cells = [2, 2])", "tensor": "isotropic(young = 1, poisson = 0.3)", "time": "", "load": "-1",
         "to": ""}
MSH = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"


def codes(program, folder, text, *arguments, command="run"):
    script = folder / "script.hvi"
    script.write_bytes(text if isinstance(text, bytes) else text.encode())
    done = subprocess.run([program, command, script, "--diagnostics", "json", *arguments], capture_output=True, text=True,
                          cwd=folder, timeout=LONGEST)
    found = [json.loads(line)["code"] for line in done.stderr.splitlines() if line.startswith("{")]
    return done.returncode, [code for code in found if code[0] == "E"]


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as temporary:
        outside, folder = pathlib.Path(temporary), pathlib.Path(temporary) / "scripts"
        folder.mkdir()
        (outside / "secret.csv").write_text("0,1\n1,2\n")
        (outside / "secret.msh").write_text(MSH)
        (outside / "secret.hvi").write_text("param k = 1\n")
        (folder / "link.csv").symlink_to(outside / "secret.csv")
        (folder / "link.msh").symlink_to(outside / "secret.msh")
        (folder / "link.hvi").symlink_to(outside / "secret.hvi")
        os.mkfifo(folder / "pipe.csv")
        os.mkfifo(folder / "pipe.msh")
        os.mkfifo(folder / "pipe.hvi")
        (folder / "sparse.csv").touch()
        os.truncate(folder / "sparse.csv", 300 << 20)
        geo = f'SystemCall "touch {outside}/ran";\nPoint(1) = {{0, 0, 0}};\n'
        (folder / "evil.geo").write_text(geo)
        (folder / "evil.msh").write_text(geo)
        (folder / "evil.GEO").write_text(geo)
        (folder / "a.hvi").write_text('import "b.hvi"\nfn fa(r) = r\n')
        (folder / "b.hvi").write_text('import "a.hvi"\nfn fb(r) = r\n')
        for word, rest in {"find": " w in V such that for all z in V integral(slab, w.x*z.x) = 0", "report": " fields u", "expect": " a = 0 within 1",
                           "study": " vary n in [2, 4] against finest in V"}.items():
            (folder / f"{word}.hvi").write_text(f"param of_{word} = 1\n{word}{rest}\n")
        slab = lambda **changes: SLAB.format(**{**PLAIN, **changes})
        nested = lambda n: slab(load="(" * n + "1" + ")" * n)
        cases = {
            "plain": (slab(), None),
            "an import through a link": ('import "link.hvi"\n' + slab(load="-k"), "E0604"),
            "an import from a pipe": ('import "pipe.hvi"\n' + slab(), "E0601"),
            "a table through a link": (slab(load='table("link.csv", x/2)'), "E0604"),
            "a table from a pipe": (slab(load='table("pipe.csv", x/2)'), "E0601"),
            "a table too large": (slab(load='table("sparse.csv", x/2)'), "E0607"),
            "a mesh through a link": (slab(mesh='gmsh("link.msh")'), "E0604"),
            "a mesh from a pipe": (slab(mesh='gmsh("pipe.msh")'), "E0601"),
            "a mesh that is a geometry": (slab(mesh='gmsh("evil.msh")'), "E0603"),
            "a geometry by another case": (slab(mesh='gmsh("evil.GEO")'), "E0606"),
            "a geometry": (slab(mesh='gmsh("evil.geo")'), "E0606"),
            "a folder as a table": (slab(load='table(".", x/2)'), "E0601"),
            "an output above": (slab(to=' to "../a.csv"'), "E0604"),
            "an output of the system": (slab(to=' to "/etc/a.csv"'), "E0604"),
            "files that import each other": ('import "a.hvi"\n' + slab(load="-fa(fb(1))"), None),
            **{f"an import with a {word}": (f'import "{word}.hvi"\n' + slab(), "E0405") for word in ("find", "report", "expect", "study")},
            "200 levels": (nested(200), None),
            "100,000 levels": (nested(100_000), "E0216"),
            "a sum of 100,000": (slab(load="1" + " + 1" * 100_000), "E0216"),
            "a script of 5 MB": ("#" * (5 << 20) + "\n" + slab(), "E0109"),
            "a hundred million cells": (slab(mesh="rectangle(2, 1, cells = [10000, 10000])"), "E0607"),
            "a thousand million steps": (slab(time=" for t in [0, 1] by 1000000000 steps from u = 0"), "E0607"),
            "a tower of functions": ("fn f0(a) = a\n" + "".join(f"fn f{i + 1}(a) = f{i}(f{i}(a)) + f{i}(a)\n" for i in range(40))
                                     + slab(load="f40(1)"), "E0607"),
            "a chain of 20,000 parameters": ("".join(f"param p{i} = p{i + 1}\n" for i in range(20_000)) + "param p20000 = 1\n"
                                             + slab(load="p0"), "E0216"),
            "a chain of 20,000 parts": ("".join(f"part p{i} = p{i + 1}\n" for i in range(20_000)) + "part p20000 = slab.left\n"
                                        + slab(), "E0216"),
            "a chain of 20,000 laws": ("".join(f"superpotential l{i}(r) = l{i + 1}(r)\n" for i in range(20_000))
                                       + "superpotential l20000(r) = r^2\n" + slab(), "E0216"),
            "3,000 parameters side by side": ("".join(f"param p{i} = {i} + 1\n" for i in range(3_000)) + slab(load="p2999"), None),
            "a sine of a sine": ("fn s(a) = " + "sin(" * 200 + "a" + ")" * 200 + "\n"
                                 + slab(load="s(" * 100 + "1" + ")" * 100), None),
            "a deep function of the place": ("fn s(a) = " + "sin(" * 200 + "a" + ")" * 200 + "\n"
                                             + slab(load="s(" * 100 + "x" + ")" * 100), "E0216"),
            "bytes that are no text": (bytes(range(128, 256)) * 40, "E0108"),
        }
        for name, (text, code) in cases.items():
            try:
                status, found = codes(program, folder, text, "-o", str(folder / "out"))
            except subprocess.TimeoutExpired:
                sys.exit(f"{name}: no end after {LONGEST} s")
            want = (1, [code]) if code else (0, [])
            if (status, found) != want and not (code == "E0108" and status == 1 and code in found):
                sys.exit(f"{name}: {status} {found}, not {want}")
        before = sorted(str(path) for path in outside.rglob("*") if folder / "out" not in path.parents)
        assert not (outside / "ran").exists(), "a mesh file ran a program"
        assert not [path for path in before if path.endswith("a.csv")], before
        alone = outside / "alone"
        alone.mkdir()
        assert codes(program, alone, slab(), "--no-files") == (0, []) and [path.name for path in alone.iterdir()] == ["script.hvi"]
        for other in (["-o", "out"], ["--resume"], ["--checkpoint", "1"]):
            assert codes(program, alone, slab(), "--no-files", *other)[0] == 2, other
    print(f"{len(cases)} scripts")


main()
