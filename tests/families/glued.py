"""Two glued pieces whose meshes do not match converge to one body with its order.  usage: glued.py HVI_RUN

-div grad p = f on a rectangle, p = sin(pi x) sin(pi y / 2) (3D: sin(pi z) more) on pieces that meet at y = 0.9 and are
held together by a stiff law on jump(p); and the same on one mesh. The L2 errors fall with the order of the element,
and those of the pieces are at most twice those of one mesh.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile


def script(dim, order, n, glued):
    z, cells_z = (", 1", f", {n}") if dim == 3 else ("", "")
    kind = "box" if dim == 3 else "rectangle"
    if glued:
        at = "[0, 0.9, 0]" if dim == 3 else "[0, 0.9]"
        mesh = (f"mesh upper = {kind}(1, 1.1{z}, cells = [{n}, {n}{cells_z}], at = {at})\n"
                f"mesh lower = {kind}(1, 0.9{z}, cells = [{n + n // 2}, {n}{cells_z}])\n"
                "mesh body = upper + lower\npart seam = pair(upper.bottom, lower.top)\n"
                "part around = body.boundary - upper.bottom - lower.top")
    else:
        mesh = f"mesh body = {kind}(1, 2{z}, cells = [{n}, {2 * n}{cells_z}])\npart around = body.boundary"
    exact = "sin(pi*x)*sin(pi*y/2)" + ("*sin(pi*z)" if dim == 3 else "")
    factor = 1.25 + (dim == 3)
    law = "superpotential glue(r) = 0.5e7*r^2\n" if glued else ""
    term = " + integral(seam, glue^0(jump(p); jump(q)))" if glued else ""
    return f"""{mesh}
{law}fn exact() = {exact}
space W = scalar P{order} on body, zero on around
find p in W such that for all q in W
  integral(body, dot(grad(p), grad(q))){term} {">=" if glued else "="} integral(body, {factor}*pi^2*exact()*q)
report
  table off = integral(body, (p - exact())^2)
"""


def error(program, folder, *case):
    (folder / "glued.hvi").write_text(script(*case))
    done = subprocess.run([program, "run", "glued.hvi", "--quiet", "--no-files", "--json", "out.json"], cwd=folder,
                          capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return math.sqrt(json.loads((folder / "out.json").read_text())["final"]["off"])


def main():
    program, good = str(pathlib.Path(sys.argv[1]).resolve()), True
    with tempfile.TemporaryDirectory() as temporary:
        for dim, order, sizes in ((2, 1, (8, 16, 32)), (2, 2, (4, 8, 16)), (3, 1, (4, 8)), (3, 2, (2, 4))):
            glued, whole = ([error(program, pathlib.Path(temporary), dim, order, n, g) for n in sizes]
                            for g in (True, False))
            found = math.log2(glued[-2] / glued[-1])
            expected = math.log2(whole[-2] / whole[-1])
            ratio = glued[-1] / whole[-1]
            fits = found > expected - 0.35 and ratio < 2.0
            good = good and fits
            print(f"{'ok   ' if fits else 'FAILS'} {dim}D P{order}: error {glued[-1]:.2e}, of one mesh "
                  f"{whole[-1]:.2e}, orders {found:.2f}, {expected:.2f}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
