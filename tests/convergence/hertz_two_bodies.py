"""Two elastic bodies with curved sides press on each other: Hertz, in the plane and between bodies of revolution.

usage: hertz_two_bodies.py HVI_RUN

Two cylinders, and two balls, of different radii and materials; each is modelled about the contact by a graded block whose
side is an arc, 15 times as wide and as high as the contact is. The meshes do not match. Reference (analytic, H. Hertz
1882; K. L. Johnson, Contact Mechanics, 1985, 4.2): with 1/R = 1/R_1 + 1/R_2, 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2
and the force F the half width is sqrt(4 F R/(pi E*)), the radius (3 F R/(4 E*))^(1/3), the pressure p_0 sqrt(1 - (x/a)^2)
with p_0 = 2 F/(pi a), and 3 F/(2 pi a^2). On the finest mesh peak and radius are within 1 %; the force for the same
displacement converges with the order of P1 (above 1.5, against two levels on).
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

RADII, YOUNG, POISSON = (1.0, 2.0), (200.0, 100.0), (0.3, 0.2)
SIZE, GRADING = 0.6, 2.2
LEVELS = (16, 32, 64, 128)
DOWN = {"plane": 0.0075, "ball": 0.004}


def body(radius, across, up, sign):
    """A block with an arc as its lower (sign 1) or upper (-1) side, graded towards the contact, as a file in format 2.2."""
    points, cells, names = [], [], {}
    for j in range(up + 1):
        for i in range(across + 1):
            x = SIZE * (i / across) ** GRADING
            low = radius - math.sqrt(radius ** 2 - x ** 2)
            points.append((x, sign * (low + (SIZE - low) * (j / up) ** GRADING)))
    at = lambda i, j: j * (across + 1) + i + 1
    for j in range(up):
        for i in range(across):
            corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
            cells += [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    names["skin"] = [(at(i, 0), at(i + 1, 0)) for i in range(across)]
    names["back"] = [(at(i, up), at(i + 1, up)) for i in range(across)]
    names["axis"] = [(at(0, j), at(0, j + 1)) for j in range(up)]
    groups = [*names, "body"]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    lines += [f'{2 if g == "body" else 1} {k + 1} "{g}"' for k, g in enumerate(groups)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{k + 1} {x!r} {y!r} 0" for k, (x, y) in enumerate(points)]
    elements = [(1, k + 1, e) for k, g in enumerate(names) for e in names[g]] + [(2, len(groups), c) for c in cells]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{k + 1} {kind} 2 {g} {g} " + " ".join(map(str, e)) for k, (kind, g, e) in enumerate(elements)]
    return "\n".join([*lines, "$EndElements", ""])


def script(ball):
    axes = ", axisymmetric = true" if ball else ""
    zero = "" if ball else ", zero.x on lines"
    return f"""import contact
mesh upper = gmsh("upper.msh"{axes})
mesh lower = gmsh("lower.msh"{axes})
mesh both = upper + lower
part near = upper.skin where x < {SIZE / 2}
part seam = pair(near, lower.skin)
{'' if ball else 'part lines = upper.axis + lower.axis'}
part top = upper.back
part base = lower.back
tensor B_1 = isotropic(young = {YOUNG[0]}, poisson = {POISSON[0]})
tensor B_2 = isotropic(young = {YOUNG[1]}, poisson = {POISSON[1]})
superpotential rigid(r) = unilateral(r)
space V = vector P1 on both, zero.y on top, zero.y on base{zero}
find u in V with u.y = -{DOWN["ball" if ball else "plane"]} on top
such that for all v in V
    integral(upper, B_1 : eps(u) : eps(v)) + integral(lower, B_2 : eps(u) : eps(v))
  + integral(seam, rigid^0(jump(u).nu - gap(seam); jump(v).nu)) >= 0
report
  table force = integral(seam, rigid.xi), first = integral(seam, rigid.xi*x), second = integral(seam, rigid.xi*x^2),
      peak = rigid.xi at [0, 0]
"""


def solve(program, folder, ball, n):
    (folder / "upper.msh").write_text(body(RADII[0], n, n, 1))
    (folder / "lower.msh").write_text(body(RADII[1], n - n // 4 + 1, n - n // 4, -1))
    (folder / "hertz.hvi").write_text(script(ball))
    subprocess.run([program, "run", "hertz.hvi", "--quiet", "--no-files", "--json", "out.json"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    return json.loads((folder / "out.json").read_text())["final"]


def main():
    wrong = 0
    compliance = sum((1 - nu ** 2) / e for nu, e in zip(POISSON, YOUNG))
    radius = 1 / sum(1 / r for r in RADII)
    with tempfile.TemporaryDirectory() as temporary:
        for ball in (False, True):
            forces = []
            for n in LEVELS:
                r = solve(sys.argv[1], pathlib.Path(temporary), ball, n)
                force = r["force"] * (1 if ball else 2)
                forces.append(force)
                a = (0.75 * force * radius * compliance) ** (1 / 3) if ball else math.sqrt(4 * force * radius * compliance / math.pi)
                peak = 1.5 * force / (math.pi * a ** 2) if ball else 2 * force / (math.pi * a)
                # Moments of the pressure give a, too.
                by_first = r["first"] / r["force"] * (16 / (3 * math.pi) if ball else 3 * math.pi / 4)
                by_second = math.sqrt(r["second"] / r["force"] * (2.5 if ball else 4))
                off = [by_first / a - 1, by_second / a - 1, r["peak"] / peak - 1]
                print(f"{'balls' if ball else 'cylinders'} n = {n}: a = {a:.4f}, by moments {off[0]:+.2%} and {off[1]:+.2%}, peak {off[2]:+.2%}")
            wrong += not max(map(abs, off)) <= 0.01
            orders = [math.log2(abs((forces[k] - forces[k + 1]) / (forces[k + 1] - forces[k + 2]))) for k in range(len(forces) - 2)]
            print(f"  order of the force: {', '.join(f'{o:.2f}' for o in orders)}")
            wrong += not orders[-1] >= 1.5
    print(f"{wrong} wrong")
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main())
