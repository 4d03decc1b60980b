"""Pairs of bodies against other ways to state the same problem: a strip on its ground, bodies in 3D, another program's matrices.

usage: two_bodies.py HVI_RUN [CHECK...]
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from turned import PROGRAM, close, judge
from solids import Mesh  # its folder is known since then

ROOT = pathlib.Path(__file__).parent.parent.parent


def table(script, meshes=()):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "a.hvi").write_text(script)
        for name, mesh in dict(meshes).items():
            (folder / name).write_text(mesh.msh())
        done = subprocess.run([PROGRAM, "run", "a.hvi", "--no-files", "--json", "a.json"], cwd=folder, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stdout + done.stderr
        data = json.loads((folder / "a.json").read_text())
        assert data["certificate"]["certified"]
        return {name: np.array(values) for name, values in data["table"].items()}


def read(path):
    """A mesh of triangles in format 2.2 with its groups of edges."""
    lines = path.read_text().split("\n")
    at = {line: k for k, line in enumerate(lines) if line.startswith("$")}
    names = {int(n): name.strip('"') for _, n, name in (line.split() for line in lines[at["$PhysicalNames"] + 2:at["$EndPhysicalNames"]])}
    points = [[float(x) for x in line.split()[1:3]] for line in lines[at["$Nodes"] + 2:at["$EndNodes"]]]
    cells, facets = [], {}
    for line in lines[at["$Elements"] + 2:at["$EndElements"]]:
        e = [int(x) for x in line.split()]
        vertices = [v - 1 for v in e[3 + e[2]:]]
        if e[1] == 2:
            cells.append(vertices)
        else:
            facets.setdefault(names[e[3]], []).append(vertices)
    return Mesh(points, cells, facets)


LAYER = """
param S = 4e-4
param F = 26.2e6
fn pull(a) =
  | a > 0.0099 -> F * S
  | otherwise  -> 0
superpotential adhesive(r) with slope
  | r <= 0    -> 0
  | r < 5e-4  -> 60e9 * S * r
  | r < 1e-3  -> 20e9 * S * r + 10e6 * S
  | r < 2e-3  -> 10e9 * S * r + 5e6 * S
  | otherwise -> 0
tensor B = isotropic(young = 1.378e11 * S, poisson = 0.3)
"""


def strip():
    """The strip of Makela, Miettinen, Luksan and Vlcek (examples/delamination.hvi) as a laminate: two strips that mirror each
    other, with the layer between them twice as long, are pulled apart. Each is the strip on its ground: the same numbers with
    the layer at the nodes, where a pair has its points; beside the published ones (conmech) what that rule changes."""
    upper = read(ROOT / "examples" / "zigzag_33x5.msh")
    lower = Mesh(upper.points * [1.0, -1.0], upper.cells[:, [0, 2, 1]], upper.facets)
    alone = table(f"""mesh strip = gmsh("upper.msh")
part clamp = strip.group("left")
part glue = strip.group("bottom")
part top = strip.group("top")
part edge = strip.group("right")
{LAYER}
space V = vector P1 on strip, zero on clamp
find u in V for t in [0, 1] by 8 steps from u = 0
such that for all v in V
    integral(strip, B : eps(u) : eps(v)) + integral(glue, adhesive^0(-u.nu; -v.nu), rule = nodal)
 >= integral(top, dot([0, F*S*t], v), rule = nodal) + integral(edge, dot([0, pull(y)*t], v), rule = nodal)
report
  table u_x = u.x at [0.08, 0], u_y = u.y at [0.08, 0], held = integral(glue, adhesive.xi)
""", {"upper.msh": upper})
    both = table(f"""mesh upper = gmsh("upper.msh")
mesh lower = gmsh("lower.msh")
mesh both = upper + lower
part clamps = upper.left + lower.left
part seam = pair(upper.bottom, lower.bottom)
part top = upper.top
part under = lower.top
part edge = upper.right
part edge_under = lower.right
{LAYER}
superpotential layer(s) with slope
  | s <= 0    -> 0
  | s < 1e-3  -> 30e9 * S * s
  | s < 2e-3  -> 10e9 * S * s + 10e6 * S
  | s < 4e-3  -> 5e9 * S * s + 5e6 * S
  | otherwise -> 0
space V = vector P1 on both, zero on clamps
find u in V for t in [0, 1] by 8 steps from u = 0
such that for all v in V
    integral(both, B : eps(u) : eps(v)) + integral(seam, layer^0(-jump(u).nu; -jump(v).nu))
 >= integral(top, dot([0, F*S*t], v), rule = nodal) + integral(edge, dot([0, pull(y)*t], v), rule = nodal)
  + integral(under, dot([0, -F*S*t], v), rule = nodal) + integral(edge_under, dot([0, -pull(-y)*t], v), rule = nodal)
report
  table u_y = jump(u).nu at [0.08, 0], held = integral(seam, layer.xi)
""", {"upper.msh": upper, "lower.msh": lower})
    for k in range(len(alone["u_y"])):
        close(-both["u_y"][k] / 2, alone["u_y"][k], 1e-9, f"opening, step {k}")
        close(both["held"][k], alone["held"][k], 1e-9, f"force, step {k}")
    close(alone["u_y"][-1], 0.00099732, 0.02, "beside the published displacement")


def pulled(polygon):
    """Triangles of a convex polygon, all from the vertex with the least number: two polyhedra cut their common face alike."""
    polygon = [v for k, v in enumerate(polygon) if v != polygon[k - 1]]
    if len(polygon) < 3:
        return []
    least = polygon.index(min(polygon))
    polygon = polygon[least:] + polygon[:least]
    return [(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, len(polygon) - 1)]


def revolved(section, sectors):
    """A quarter of the body that a section makes about the y-axis, with sides `front` (z = 0) and `side` (x = 0)."""
    number, points = {}, []
    for j in range(sectors + 1):
        angle = 0.5 * math.pi * j / sectors
        for i, (r, y) in enumerate(section.points):
            if r == 0.0 and j > 0:
                number[i, j] = number[i, 0]
                continue
            number[i, j] = len(points)
            points.append((r * math.cos(angle) if j < sectors else 0.0, y, r * math.sin(angle)))
    points = np.array(points)
    cells, facets = [], {name: [] for name in section.facets}
    for j in range(sectors):
        for cell in section.cells:
            low, high = [number[int(i), j] for i in cell], [number[int(i), j + 1] for i in cell]
            faces = [low, high] + [[low[k], low[k - 1], high[k - 1], high[k]] for k in range(3)]
            first = min(low + high)
            for face in faces:
                for triangle in pulled(face) if first not in face else []:
                    edges = points[list(triangle)] - points[first]
                    size = np.linalg.det(edges)
                    if abs(size) > 1e-18:
                        cells.append((first, *triangle) if size > 0 else (first, triangle[0], triangle[2], triangle[1]))
        for name, edges in section.facets.items():
            for a, b in edges:
                facets[name] += pulled([number[int(a), j], number[int(b), j], number[int(b), j + 1], number[int(a), j + 1]])
    for name, j in (("front", 0), ("side", sectors)):
        facets[name] = [tuple(number[int(i), j] for i in cell) for cell in section.cells]
    return Mesh(points, cells, {name: f for name, f in facets.items() if f})


def curved_block(radius, across, up, sign, size=0.5, grading=2.2):
    """The section of a ball (of a half space: an infinite radius) near its lowest (sign 1) or highest point, graded towards it."""
    points, cells = [], []
    for j in range(up + 1):
        for i in range(across + 1):
            x = size * (i / across) ** grading
            low = 0.0 if math.isinf(radius) else radius - math.sqrt(radius ** 2 - x ** 2)
            points.append((x, sign * (low + (size - low) * (j / up) ** grading)))
    at = lambda i, j: j * (across + 1) + i
    for j in range(up):
        for i in range(across):
            corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)][::sign]
            cells += [corners[:3], [corners[0], corners[2], corners[3]]]
    facets = {"skin": [(at(i, 0), at(i + 1, 0)) for i in range(across)], "back": [(at(i, up), at(i + 1, up)) for i in range(across)]}
    return Mesh(points, cells, facets)


def ball():
    """An elastic ball on an elastic half space: the pair of bodies in 3D against the pair of their sections, and Hertz."""
    young, poisson, down = (200.0, 100.0), (0.3, 0.2), 0.004
    body = """import contact
mesh upper = gmsh("upper.msh"{axes})
mesh lower = gmsh("lower.msh"{axes})
mesh both = upper + lower
part near = upper.skin where {radius} < 0.15
part seam = pair(near, lower.skin)
part top = upper.back
part base = lower.back
{parts}tensor B_1 = isotropic(young = {young[0]}, poisson = {poisson[0]})
tensor B_2 = isotropic(young = {young[1]}, poisson = {poisson[1]})
superpotential rigid(r) = unilateral(r)
space V = vector P1 on both, zero.y on top, zero.y on base{zero}
find u in V with u.y = -{down} on top such that for all v in V
    integral(upper, B_1 : eps(u) : eps(v)) + integral(lower, B_2 : eps(u) : eps(v))
  + integral(seam, rigid^0(jump(u).nu - gap(seam); jump(v).nu)) >= 0
report
  table force = integral(seam, rigid.xi), second = integral(seam, rigid.xi*({radius})^2)
"""
    sections = {"upper.msh": curved_block(1.0, 22, 16, 1), "lower.msh": curved_block(math.inf, 18, 16, -1)}
    given = dict(young=young, poisson=poisson, down=down)
    flat = table(body.format(axes=", axisymmetric = true", radius="x", parts="", zero="", **given), sections)
    compliance = sum((1 - nu ** 2) / e for nu, e in zip(poisson, young))
    a = (0.75 * flat["force"][-1] * compliance) ** (1 / 3)
    close(math.sqrt(2.5 * flat["second"][-1] / flat["force"][-1]), a, 0.03, "radius of the sections' contact against Hertz")
    off = []
    for sectors in (4, 8, 16):
        solids = {name: revolved(section, sectors) for name, section in sections.items()}
        body_3d = body.format(axes="", radius="sqrt(x^2 + z^2)", zero=", zero.z on fronts, zero.x on sides",
                              parts="part fronts = upper.front + lower.front\npart sides = upper.side + lower.side\n", **given)
        solid = table(body_3d, solids)
        off.append([4 * solid["force"][-1] / flat["force"][-1] - 1,
                    math.sqrt(solid["second"][-1] / solid["force"][-1] / flat["second"][-1] * flat["force"][-1]) - 1])
        print(f"  {sectors} sectors: force {off[-1][0]:+.2%}, radius {off[-1][1]:+.2%} off the section's")
    assert abs(off[0][0]) > 2 * abs(off[1][0]) > 3 * abs(off[2][0]) and abs(off[2][0]) < 0.005, "force"
    assert max(abs(radius) for _, radius in off) < 0.003, "radius"


SLIDES = """
superpotential press(r) with slope | r < 0 -> 0 | otherwise -> 1e300
superpotential rub(w) = 0.3*abs(press.xi)*norm(w)
fn pushed() = min(1, 4*t)
fn slid() = | t < 0.25 -> 0 | t < 0.75 -> 4*(t - 0.25) | otherwise -> 2 - 16*(t - 0.75)
tensor A = isotropic(young = 2, poisson = 0.3)
tensor B = isotropic(young = 100, poisson = 0.3)
"""
MOVED = "u = [0.02*slid(), -0.02*pushed()] on back for t in [0, 1] by 24 steps from u = 0"
COLUMNS = "pressed = integral({0}, press.xi), drag = integral({0}, rub.xi.x), tilt = integral({0}, press.xi*x), moved = u.x at [0.9, 0.3]"


def on_a_block(n, m, young, first="upper.bottom", second="lower.top", sign=1):
    """The iron on a block of this stiffness, with n and m cells along each side."""
    return table(f"""
mesh upper = rectangle(1, 0.5, cells = [{2 * n}, {n}])
mesh lower = rectangle(2, 0.5, cells = [{m}, {(m + 3) // 4}], at = [-0.5, -0.5])
mesh both = upper + lower
part back = upper.top
part base = lower.bottom
part seam = pair({first}, {second})
{SLIDES}
tensor L = isotropic(young = {young}, poisson = 0.3)
space V = vector P1 on both, zero on back, zero on base
find u in V with {MOVED}
such that for all v in V
    integral(upper, A : eps(u') : eps(v)) + integral(upper, B : eps(u) : eps(v)) + integral(lower, L : eps(u) : eps(v))
  + integral(seam, press^0(jump(u).nu; jump(v).nu) + rub^0(jump(u').tau; jump(v).tau)) >= 0
report
  table {COLUMNS.format("seam").replace("rub.xi.x", f"{sign}*rub.xi.x")}
""")


def ironing():
    """A block is pressed on another one and slides on it to and fro, with Coulomb's friction. On a block that hardly gives it
    is the block on a rigid ground, one mesh without pairs: the difference goes with the ground's compliance. On one as soft
    as itself, with meshes that do not match, it nears what fine meshes give whose sides have changed parts."""
    rigid = table(f"""
mesh upper = rectangle(1, 0.5, cells = [16, 8])
part back = upper.top
part foot = upper.bottom
{SLIDES}
space V = vector P1 on upper, zero on back
find u in V with {MOVED}
such that for all v in V
    integral(upper, A : eps(u') : eps(v)) + integral(upper, B : eps(u) : eps(v))
  + integral(foot, press^0(u.nu; v.nu) + rub^0(u'.tau; v.tau)) >= 0
report
  table {COLUMNS.format("foot")}
""")
    assert max(rigid["drag"]) > 0.2 * max(rigid["pressed"]) and min(rigid["drag"]) < -0.2 * max(rigid["pressed"]), "it slides both ways"
    off = []
    for young in (1e6, 1e8):
        found = on_a_block(8, 13, young)
        off.append(max(np.abs(found[k] - rigid[k]).max() / np.abs(rigid[k]).max() for k in ("pressed", "drag", "tilt", "moved")))
    print(f"  from the rigid ground: {off[0]:.1e} and {off[1]:.1e}, ground 1e4 and 1e6 times as stiff")
    close(off[1], off[0] / 100, 0.05, "the difference goes with the compliance")
    assert off[1] < 1e-5
    best = on_a_block(64, 100, 60, "lower.top", "upper.bottom", -1)
    errors = []
    for n, m in ((4, 7), (8, 13), (16, 27)):
        found = on_a_block(n, m, 60)
        errors.append(max(np.abs(found[k] - best[k]).max() / np.abs(best[k]).max() for k in ("pressed", "drag", "tilt", "moved")))
    print(f"  from fine meshes with changed sides: {', '.join(f'{e:.1e}' for e in errors)}")
    assert errors[0] > 1.5 * errors[1] > 2.25 * errors[2] and errors[2] < 0.02


if __name__ == "__main__":
    sys.exit(judge([strip, ball, ironing]))
