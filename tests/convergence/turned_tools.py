"""Hertz, `check`, `study`, adapted meshes and files for bodies of revolution, against references.

usage: turned_tools.py HVI_RUN [CHECK...]
"""
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from turned import PROGRAM, TWO_PI, Mesh, below, close, judge, run, table, wobbly


def half_ball(n):
    """The section of a half ball of radius 1 that stands on the origin, graded towards it."""
    graded = (np.exp(5.0 * np.arange(n + 1) / n) - 1) / (math.exp(5.0) - 1)
    points = [(r * math.sin(a), 1 - r * math.cos(a)) for r in 1 - graded[:-1] for a in math.pi / 2 * graded]
    points.append((0.0, 1.0))
    points = np.array(points)
    points[abs(points) < 1e-15] = 0.0
    at, centre = lambda i, j: i * (n + 1) + j, len(points) - 1
    cells = [(at(n - 1, j), at(n - 1, j + 1), centre) for j in range(n)]
    for i in range(n - 1):
        for j in range(n):
            cells += [(at(i, j), at(i, j + 1), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i + 1, j))]
    middle = [(at(i, n), at(i + 1, n)) for i in range(n - 1)] + [(at(n - 1, n), centre)]
    return Mesh(points, cells, {"skin": [(at(0, j), at(0, j + 1)) for j in range(n)], "middle": middle})


def hertz():
    """A half ball on a rigid plane: radius and peak of the pressure by the force (Hertz), a/R = 0.05."""
    for element, rungs in (("P1", (20, 40, 80, 160)), ("P2", (40, 80))):
        peaks = []
        for n in rungs:
            peak = "rigid.xi at [0, 0]" if element == "P1" else "-sigma.yy at [0, 0]"
            t = {k: v[-1] for k, v in table(f"""
import contact
mesh ball = gmsh("body.msh", axisymmetric = true)
part middle = ball.group("middle")
part skin = ball.group("skin")
tensor B = isotropic(young = 200, poisson = 0.3)
superpotential rigid(r) = unilateral(r)
space V = vector {element} on ball, zero.y on middle
find u in V with u.y = -0.0025 on middle such that for all v in V
  integral(ball, B : eps(u) : eps(v)) + integral(skin, rigid^0(-u.y - y; -v.y)) >= 0
report
  table F = integral(skin, rigid.xi), first = integral(skin, rigid.xi*x), second = integral(skin, rigid.xi*x^2),
        peak = {peak}
""", half_ball(n)).items()}
            a = (3 * t["F"] * (1 - 0.3 ** 2) / 4 / 200) ** (1 / 3)
            peaks.append(t["peak"] * TWO_PI * a * a / 3 / t["F"])
        close(t["first"] / t["F"] * 16 / 3 / math.pi, a, 2e-3, f"{element}: radius by the first moment")
        close(math.sqrt(t["second"] / t["F"] * 5 / 2), a, 2e-3, f"{element}: radius by the second moment")
        close(peaks[-1], 1, 0.01, f"{element}: peak of the pressure by that of Hertz")
        if element == "P1":
            close(math.log2((1 - peaks[0]) / (1 - peaks[2])) / 2, 1, 0.15, "its order in the size of the cells")


def hypotheses():
    """The constants of `check` are those of the weighted spaces: dense eigenvalues."""
    from axisymmetry import Ring
    for element in (1, 2):
        for away in (0.0, 0.4):
            mesh = wobbly(5, away)
            code, said, _ = run(f"""
mesh body = gmsh("body.msh", axisymmetric = true)
part roof = body.group("top")
part ground = body.group("bottom")
tensor B = orthotropic(young = [70, 50, 15], poisson = [0.3, 0.2, 0.1], shear = [30, 8, 7])
superpotential layer(r) with slope 2*max(r, 0)
superpotential slip(xi) with slope 1
space V = vector P{element} on body, zero on roof
find u in V such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu) + slip^0(u.tau; v.tau)) >= 0
report
  table size = norm(u)
""", mesh, command="check")
            assert code == 0, said
            found = re.search(r"m_B +([0-9.e+-]+) .*normal\s+([0-9.e+-]+),\s+tangential\s+([0-9.e+-]+),\s+full\s+([0-9.e+-]+)", said,
                              re.DOTALL)
            assert found, said
            pointwise = float(re.search(r"m_2 = ([0-9.e+-]+)", said)[1])
            ring = Ring(mesh, element)
            axis = [2 * v for v in range(len(ring.points)) if ring.points[v, 0] == 0.0]
            free = np.setdiff1d(np.arange(ring.n), [*ring.dofs(ring.on("top")), *axis])
            part = lambda k: k[np.ix_(free, free)]
            compliance = np.diag([1 / 70, 1 / 50, 1 / 15, 0.0])
            for i, j, v in ((0, 1, 0.3 / 70), (1, 2, 0.2 / 50), (0, 2, 0.1 / 70)):
                compliance[i, j] = compliance[j, i] = -v
            stiff = np.zeros((4, 4))
            stiff[:3, :3], stiff[3, 3] = np.linalg.inv(compliance[:3, :3]), 30.0
            gram = part(ring.stiffness(np.diag([1, 1, 1, 0.5])))
            form = part(ring.stiffness(stiff))
            inverse = np.linalg.inv(np.linalg.cholesky(gram))
            spectrum = lambda k: np.linalg.eigvalsh(inverse @ k @ inverse.T)
            traces = {"normal": 0.0, "tangential": 0.0, "full": 0.0}
            for weight, values, normal in ring.law_points("bottom", "nodal"):
                values = values[:, free]
                across = normal @ values
                along = values - np.outer(normal, across)
                traces["normal"] = traces["normal"] + weight * np.outer(across, across)
                traces["tangential"] = traces["tangential"] + weight * along.T @ along
                traces["full"] = traces["full"] + weight * values.T @ values
            close(float(found[1]), spectrum(form)[0], 1e-5, f"P{element}, from r = {away}: m_B")
            close(pointwise, np.linalg.eigvalsh(stiff * np.sqrt(np.outer([1, 1, 1, 2], [1, 1, 1, 2])))[0], 1e-5, "m_2")
            for k, (name, mass) in enumerate(traces.items()):
                close(float(found[2 + k]), spectrum(mass)[-1], 1e-5, f"trace, {name}")


def study():
    """Ladders against an exact solution, a finer mesh and the finest one: orders and the weighted norms."""
    base = """
param n = 4
mesh tube = rectangle(1, 0.5, cells = [2*n, n], origin = [1, 0], axisymmetric = true)
part bore = tube.left
part ends = tube.bottom + tube.top
tensor B = isotropic(young = 100, poisson = 0.3)
fn lame() = 30/3 * 1.3/100 * (0.4*x + 4/x)
space V = vector P1 on tube, zero.y on ends
find u in V such that for all v in V
  integral(tube, B : eps(u) : eps(v)) = integral(bore, -30 * v.nu)
report
  table size = norm(u), by_hand = sqrt(integral(tube, eps(u) : eps(u))),
        error = sqrt(integral(tube, (eps(u) - eps([lame(), 0])) : (eps(u) - eps([lame(), 0])))),
        exact = sqrt(integral(tube, eps([lame(), 0]) : eps([lame(), 0])))
"""
    t = table(base)
    close(t["size"][-1], t["by_hand"][-1], 1e-12, "norm(u) is that of the strains")
    errors = [table(base.replace("n = 4", f"n = {n}"))["error"][-1] for n in (4, 8, 16, 32)]
    # Meshes that are not nested: to the error of the finest.
    cases = [("exact [lame(), 0]", "[4, 8, 16, 32]"), ("finest", "[4, 8, 16, 32]"), ("finest", "[5, 12, 77]")]
    for against, ladder in cases:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.hvi"
            path.write_text(base + f"study vary n in {ladder} against {against} in V\n")
            done = subprocess.run([PROGRAM, "study", "a.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True,
                                  timeout=300)
            assert done.returncode == 0, done.stdout + done.stderr
            rows = [line.split() for line in done.stdout.split("\n") if re.match(r" *[0-9]+ ", line)]
            found = [float(row[2]) for row in rows if row[2] != "-"]
            close(float(rows[0][4]), found[0] / t["exact"][-1], 5e-3, "relative to the solution's norm")
            if "77" in ladder:
                alone = table(base.replace("n = 4", "n = 12"))["error"][-1]
                close(found[-1], alone, 0.03, "V error against the finest, not nested")
                continue
            # By Galerkin's orthogonality the square of the distance from the finest is the difference of the squares.
            off = 0.0 if against != "finest" else errors[-1]
            for error, expected in zip(found, errors):
                tolerance = 3e-4 if against != "finest" else 1e-3  # as printed; orthogonality but for quadrature
                close(error, math.sqrt(expected ** 2 - off ** 2), tolerance, f"V error against {against}")


def adapted():
    """Bisection where the weighted indicator is large: less error for as many cells."""
    script = """
mesh disk = rectangle(1, 1, cells = [4, 4], axisymmetric = true, adapted = 3000)
part roof = disk.top
tensor B = isotropic(young = 100, poisson = 0.3)
space V = vector P1 on disk, zero on roof
find u in V such that for all v in V
  integral(disk, B : eps(u) : eps(v)) = integral(disk, v.y)
report
  table work = integral(disk, sigma : eps(u))
"""
    fine = table(script.replace("cells = [4, 4]", "cells = [64, 64]").replace(", adapted = 3000", "")
                 .replace("P1", "P2"))["work"][-1]
    even = table(script.replace("cells = [4, 4]", "cells = [38, 38]").replace(", adapted = 3000", ""))["work"][-1]
    fitted = table(script)["work"][-1]
    print(f"  energy: even {even - fine:.2e}, adapted {fitted - fine:.2e} off")
    assert abs(fitted - fine) < 0.7 * abs(even - fine)


def files():
    """VTU files: nine components of the stress, the hoop's on (z, z); the mean over the body is the integral's."""
    import meshio
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "a.hvi").write_text("""
mesh plug = rectangle(1, 1, cells = [3, 3], axisymmetric = true)
part roof = plug.top
part side = plug.right
tensor B = isotropic(young = 100, poisson = 0.3)
space V = vector P2 on plug, zero.y on roof
find u in V such that for all v in V
  integral(plug, B : eps(u) : eps(v)) = integral(side, -2 * v.nu)
report
  table size = norm(u)
  fields u, sigma
  picture sigma.zz to "hoop.svg"
""")
        done = subprocess.run([PROGRAM, "run", "a.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        grid = meshio.read(next((folder / "out").glob("*.vtu")))
        stress = np.concatenate(grid.cell_data["sigma"])
        expected = np.array([-2, 0, 0, 0, 0, 0, 0, 0, -2.0])
        below(float(np.abs(stress.reshape(-1, 9) - expected).max()), 1e-12, "stress in the file")
        assert (folder / "out" / "hoop.svg").stat().st_size > 1000


if __name__ == "__main__":
    sys.exit(judge([hertz, hypotheses, study, adapted, files]))
