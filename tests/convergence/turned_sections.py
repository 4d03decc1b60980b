"""Bodies of revolution against closed forms and against the same bodies in 3D.

usage: turned_sections.py HVI_RUN [CHECK...]

Every check is a script of its own on a mesh of the section, written here where it is not a rectangle.
"""
import math
import pathlib
import re
import sys
import tempfile

import numpy as np

from turned import TWO_PI, Mesh, below, block, close, judge, run, table, wobbly


def patch():
    """u = (c r, d z) has a uniform stress where the tensor turns with the body: reproduced to rounding."""
    tensors = ["isotropic(young = 70, poisson = 0.3)",
               "transverse(young = 70, poisson = 0.3, young_axis = 20, poisson_axis = 0.1, shear_axis = 9, axis = [0, 1])",
               "voigt([[50, 20, 10, 0], [20, 60, 20, 0], [10, 20, 50, 0], [0, 0, 0, 11]])"]
    for seed, tensor in enumerate(tensors):
        for element in ("P1", "P2"):
            for away in (0.0, 0.7):
                script = f"""
mesh body = gmsh("body.msh", axisymmetric = true)
part foot = body.group("bottom")
part load = body.group("top") + body.group("right") + body.group("left")
part side = body.group("top") + body.group("right"){' + body.group("left")' if away else ''}
tensor B = {tensor}
fn exact() = [0.01*x, -0.02*y]
space V = vector {element} on body, zero.y on foot
find u in V such that for all v in V
    integral(body, B : eps(u) : eps(v))
 >= integral(side, dot(dot(B : eps(exact()), normal), v)) + integral(foot, dot(B : eps(exact()), normal).x * v.x)
report
  table error = sqrt(integral(body, dot(u - exact(), u - exact()))),
        strain = sqrt(integral(body, (eps(u) - eps(exact())) : (eps(u) - eps(exact())))),
        hoop = sigma.zz at [{away}, 0.45], hoop_inside = sigma.zz at [{away + 0.4}, 0.3],
        size = sqrt(integral(body, eps(exact()) : eps(exact())))
"""
                t = table(script, wobbly(seed, away))
                below(t["strain"][-1] / t["size"][-1], 1e-12, f"{tensor[:12]} {element}, from r = {away}: strain")
                below(t["error"][-1], 1e-13, "displacement")
                below(abs(t["hoop"][-1] / t["hoop_inside"][-1] - 1), 1e-11, "hoop stress at the inner side or on the axis")


def measures():
    """Volumes, areas and lengths of what turns; integrals of polynomials."""
    for element in ("P1", "P2"):
        script = f"""
mesh body = gmsh("body.msh", axisymmetric = true)
part foot = body.group("bottom")
part side = body.group("right")
part edge = point(body, [1.3, 0])
part pole = point(body, [0, 0])
space V = vector {element} on body, zero on foot
find u in V such that for all v in V
  integral(body, eps(u) : eps(v)) >= integral(side, v.x)
report
  table volume = integral(body, 1), inertia = integral(body, x^2*y), foot = integral(foot, x),
        side = integral(side, y, rule = nodal), length = integral(edge, 2), single = integral(pole, 3),
        middle = integral(foot, 1, rule = midpoint), nodal = integral(foot, 1 + x, rule = nodal),
        gauss = integral(foot, x^{1 if element == 'P1' else 3}, rule = gauss), lumped = integral(body, 1, rule = nodal)
"""
        t = {k: v[-1] for k, v in table(script, wobbly(7)).items()}
        r, h = 1.3, 0.9
        close(t["volume"], math.pi * r * r * h, 1e-13, "volume")
        close(t["lumped"], math.pi * r * r * h, 1e-13, "volume, nodal rule")
        close(t["inertia"], TWO_PI * r ** 4 / 4 * h * h / 2, 1e-13, "int r^2 z")
        close(t["foot"], TWO_PI * r ** 3 / 3, 1e-13, "int r over the foot")
        close(t["side"], TWO_PI * r * h * h / 2, 1e-13, "int z over the side")
        close(t["length"], 2 * TWO_PI * r, 1e-13, "twice the circle")
        close(t["single"], 3, 1e-13, "a point of the axis stands for itself")
        close(t["middle"], math.pi * r * r, 1e-13, "area, midpoint rule")
        close(t["nodal"], math.pi * r * r + TWO_PI * r ** 3 / 3, 0.02 if element == "P1" else 1e-2, "nodal rule")
        k = 2 + (1 if element == "P1" else 3)
        close(t["gauss"], TWO_PI * r ** k / k, 1e-13, "gauss rule")


def scalar():
    """Heat through a tube: p = log r; only the weight enters."""
    errors = []
    for n in (4, 8, 16):
        t = table(f"""
mesh tube = rectangle(1, 1, cells = [{n}, {n}], origin = [1, 0], axisymmetric = true)
part hot = tube.left
part cold = tube.right
space V = scalar P1 on tube, zero on hot
find p in V such that for all q in V
  integral(tube, dot(grad(p), grad(q))) >= integral(cold, 0.5*q)
report
  table error = sqrt(integral(tube, (p - log(x))^2)), flux = integral(hot, dot(sigma, normal))
""")
        errors.append(t["error"][-1])
    order = math.log2(errors[-2] / errors[-1])
    close(order, 2, 0.02, "order in L2")


def resultants():
    """A cylinder pressed on the ground: the ground's force is pressure times the area of the disk, for every rule."""
    for element in ("P1", "P2"):
        for rule in ("nodal", "midpoint", "gauss"):
            t = table(f"""
mesh body = gmsh("body.msh", axisymmetric = true)
part roof = body.group("top")
part ground = body.group("bottom")
tensor B = isotropic(young = 100, poisson = 0.3)
superpotential layer(r) with slope 1000*max(r, 0)
superpotential weak(r) with slope 1e-9*r
space V = vector {element} on body, zero.y on roof
find u in V with u.y = -0.05*t on roof for t in [0, 1] by 2 steps from u = 0 such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu), rule = {rule})
 >= 0 
report
  table ground = integral(ground, layer.xi), energy = integral(body, sigma : eps(u)), pull = integral(ground, layer.xi * u.nu)
""", wobbly(3))
            # The plate's work is the body's energy and the layer's: all of it with 2 pi r.
            plate = (t["energy"][-1] + t["pull"][-1]) / 0.05
            close(t["ground"][-1], plate, 1e-9, f"{element} {rule}: force of the ground by the work of the plate")
            if rule == "midpoint":
                continue  # one point for an edge cannot take a uniform pressure
            exact = 100 * 0.05 / 0.9 / (1 + 100 / 0.9 / 1000) * math.pi * 1.3 ** 2
            close(t["ground"][-1], exact, 1e-9, "and the closed form (uniform stress)")


def free_motion():
    """Only the translation along the axis is rigid; a ring is held by its own hoop stress."""
    script = """
mesh ring = rectangle(1, 1, cells = [3, 3], origin = [1, 0], axisymmetric = true)
part inner = ring.left
part foot = ring.bottom
tensor B = isotropic(young = 100, poisson = 0.3)
space V = vector P1 on ring
find u in V such that for all v in V
  integral(ring, B : eps(u) : eps(v)) >= integral(inner, -v.nu)
report
  table size = norm(u)
"""
    code, said, _ = run(script)
    print("  ", [line for line in said.split("\n") if "rigid" in line])
    assert code == 1 and "E0425" in said and "the body moves along y" in said
    assert "along x" not in said and "turns" not in said
    table(script.replace("on ring\n", "on ring, zero.y on foot\n"))


def axis():
    """u.x on the axis is 0 by itself; other values there, and integrals over the axis, are refused."""
    base = """
mesh plug = rectangle(1, 1, cells = [3, 3], axisymmetric = true)
part centre = plug.left
part roof = plug.top
part side = plug.right
tensor B = isotropic(young = 100, poisson = 0.3)
space V = vector P2 on plug, zero.y on roof
find u in V such that for all v in V
  integral(plug, B : eps(u) : eps(v)) >= integral(side, -2 * v.nu)
report
  table axis = u.x at [0, 0.3], hoop = sigma.zz at [0, 0.4], side = u.x at [1, 0.3],
        limit = eps([0.1*x + x^2, y]).zz at [0, 1]
"""
    t = table(base)
    assert t["axis"][-1] == 0.0
    close(t["hoop"][-1], -2, 1e-12, "hoop stress on the axis, uniform pressure")
    close(t["side"][-1], -2 * 0.7 / 100, 1e-12, "radial displacement, plane stress")
    close(t["limit"][-1], 0.1, 1e-12, "the limit of a function's own hoop strain")
    same = table(base.replace("zero.y on roof", "zero.y on roof, zero.x on centre"))
    assert all(np.array_equal(t[k], same[k]) for k in t), "the condition written out is the same"
    wrong = [
        (base.replace("zero.y on roof", "zero.y on roof, zero.x on centre")
             .replace("find u in V such", "find u in V with u.x = 0.1 on centre such"), "E0419"),
        (base.replace("find u in V such", "find u in V with u.x = 0.1 on roof such")
             .replace("zero.y on roof", "zero on roof"), "E0419"),
        (base.replace(">= integral(side", ">= integral(centre"), "E0418"),
        (base.replace("table axis", "table area = integral(centre, 1), axis"), "E0418"),
        (base.replace("cells = [3, 3]", "cells = [3, 3], origin = [-0.1, 0]"), "E0442"),
        (base.replace("rectangle(1, 1, cells = [3, 3],", "box(1, 1, 1, cells = [3, 3, 3],"), "E0442"),
        (base.replace("isotropic(young = 100, poisson = 0.3)",
                      "transverse(young = 70, poisson = 0.3, young_axis = 20, poisson_axis = 0.1, shear_axis = 9, "
                      "axis = [1, 0, 1])"), "E0442"),
        (base.replace("isotropic(young = 100, poisson = 0.3)", "voigt([[3, 1, 0], [1, 3, 0], [0, 0, 1]])"), "E0307"),
        (base.replace("= true)", "= maybe)"), "E0316"),
    ]
    for script, code in wrong:
        exit_code, said, _ = run(script)
        found = [word.strip("[]:") for line in said.split("\n") if line.startswith("error") for word in line.split()[:1]]
        print("  ", code, [line for line in said.split("\n") if line.startswith("error")][:2])
        assert exit_code == 1 and said.count(code) == 1 and len(found) == 1, (code, said)
    across = """
mesh body = gmsh("body.msh", axisymmetric = true)
part roof = body.group("top")
space V = scalar P1 on body, zero on roof
find u in V such that for all v in V
  integral(body, dot(grad(u), grad(v))) = integral(body, v)
report
  table size = norm(u)
"""
    for command in ("check", "run"):
        exit_code, said, _ = run(across, wobbly(2, -0.4), command=command)
        assert exit_code == 1 and said.count("E0442") == 1 and "beyond the axis" in said, said
    table(across, wobbly(2, -1e-12))  # rounding: put on the axis


def bits():
    """`axisymmetric = false` is the script without the word."""
    script = """
mesh plug = rectangle(1, 1, cells = [5, 5], origin = [0.5, 0])
part roof = plug.top
tensor B = isotropic(young = 100, poisson = 0.3)
space V = vector P2 on plug, zero on roof
find u in V such that for all v in V
  integral(plug, B : eps(u) : eps(v)) >= integral(plug, v.y)
report
  table a = norm(u), b = integral(plug, sigma : eps(u))
"""
    one, other = table(script), table(script.replace("0])", "0], axisymmetric = false)"))
    assert all(np.array_equal(one[k], other[k]) for k in one)


def sphere():
    """A hollow sphere under pressure from inside: u = A R + B/R^2 (Lame)."""
    young, poisson, a, b, p = 100.0, 0.3, 1.0, 2.0, 10.0
    factor = p * a ** 3 / (b ** 3 - a ** 3) / young
    first, second = factor * (1 - 2 * poisson), factor * (1 + poisson) / 2 * b ** 3
    errors = []
    for n in (8, 16, 32):
        mesh = block(np.random.default_rng(1), [n, 2 * n], [1.0, math.pi / 2])
        radius, angle = 1 + mesh.points[:, 0], mesh.points[:, 1]
        points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
        points[abs(points) < 1e-15] = 0.0
        names = {"left": "inner", "right": "outer", "bottom": "middle", "top": "axis"}
        t = table(f"""
mesh ball = gmsh("body.msh", axisymmetric = true)
part inner = ball.group("inner")
part middle = ball.group("middle")
tensor B = isotropic(young = {young}, poisson = {poisson})
fn R() = sqrt(x^2 + y^2)
fn exact() = [x*({first!r} + {second!r}/R()^3), y*({first!r} + {second!r}/R()^3)]
space V = vector P1 on ball, zero.y on middle
find u in V such that for all v in V
  integral(ball, B : eps(u) : eps(v)) >= integral(inner, dot([{p}*x/R(), {p}*y/R()], v))
report
  table error = sqrt(integral(ball, dot(u - exact(), u - exact()))), size = sqrt(integral(ball, dot(exact(), exact()))),
        along = u.y at [0, 1], across = u.x at [1, 0]
""", Mesh(points, mesh.cells, {names[k]: v for k, v in mesh.facets.items()}))
        errors.append(t["error"][-1] / t["size"][-1])
    print("  errors", errors)
    close(math.log2(errors[-2] / errors[-1]), 2, 0.06, "order in L2")
    below(errors[-1], 2e-3, "error")


def creep():
    """The tube of Kelvin and Voigt: order 1 in the step, and sums of both errors."""
    script = (pathlib.Path(__file__).parent / "tube.hvi").read_text()
    errors = []
    for steps in (8, 16, 32):
        code, said, data = run(script, options=["-D", "n=12", "-D", "element=P2", "-D", f"N={steps}", "-D", "T=1"])
        assert code == 0, said
        errors.append(max(data["table"]["error"]))
    close(math.log2(errors[-2] / errors[-1]), 1, 0.05, "order in the step")


def tube():
    """Lame's tube: orders of the elements in L2 and in energy, the hoop stress."""
    script = (pathlib.Path(__file__).parent / "tube.hvi").read_text()
    for element, orders in (("P1", (2, 1)), ("P2", (3, 2))):
        found = []
        for n in (4, 8, 16):
            code, said, data = run(script, options=["-D", f"n={n}", "-D", f"element={element}", "-D", "T=1e12"])
            assert code == 0, said
            found.append([data["table"][k][-1] for k in ("error", "energy")])
        for k, what in enumerate(("L2", "energy")):
            close(math.log2(found[-2][k] / found[-1][k]), orders[k], 0.03, f"{element}, order in {what}")
        if element == "P2":
            close(data["table"]["hoop"][-1], 30 / 3 * (1 + 4 / 1.5 ** 2), 1e-3, "hoop stress in the middle")
            close(data["table"]["grip"][-1], 2 * 0.3 * 2 * 30 / 3 * math.pi * 3, 1e-4, "force of the plates")


def turned():
    """A cylinder with friction pressed on the ground: the section against the body in 3D."""
    section = table("""
mesh peg = rectangle(0.5, 1, cells = [16, 32], axisymmetric = true)
part roof = peg.top
part ground = peg.bottom
tensor B = isotropic(young = 100, poisson = 0.3)
superpotential layer(r) with slope 800*max(r, 0)
superpotential slip(xi) with slope 0.6
space V = vector P2 on peg, zero on roof
find u in V with u.y = -0.1*t on roof for t in [0, 1] by 2 steps from u = 0 such that for all v in V
    integral(peg, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu) + slip^0(u'.tau; v.tau)) >= 0
report
  table force = integral(ground, layer.xi), bulge = u.x at [0.49, 0.5], rim = u.x at [0.5, 0], work = integral(peg, sigma : eps(u)), size = norm(u)
""")
    body = table("""
mesh peg = cylinder(0.5, 1, size = 0.13, size_bottom = 0.1)
part roof = peg.top
part ground = peg.bottom
tensor B = isotropic(young = 100, poisson = 0.3)
superpotential layer(r) with slope 800*max(r, 0)
superpotential slip(xi) with slope 0.6
space V = vector P2 on peg, zero on roof
find u in V with u = [0, -0.1*t, 0] on roof for t in [0, 1] by 2 steps from u = 0 such that for all v in V
    integral(peg, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu) + slip^0(u'.tau; v.tau)) >= 0
report
  table force = integral(ground, layer.xi), bulge = u.x at [0.49, 0.5, 0], work = integral(peg, sigma : eps(u)), size = norm(u)
""")
    for what in ("force", "work", "size", "bulge"):
        close(body[what][-1], section[what][-1], 0.02, f"{what}: 3D against the section")


def inertia():
    """A plug thrown along its axis: its momentum is that of its mass; the energies balance."""
    script = """
mesh plug = rectangle(0.5, 1, cells = [3, 5], axisymmetric = true)
tensor B = isotropic(young = 100, poisson = 0.3)
part foot = plug.bottom
superpotential layer(r) with slope -2*r + 3*max(r, 0)
space V = vector P1 on plug
find u in V for t in [0, 1] by 8 steps from u = 0, u' = [0, 2] using scheme = newmark such that for all v in V
  integral(plug, 3*dot(u'', v)) + integral(plug, B : eps(u) : eps(v)) >= integral(plug, dot([0, -4], v))
report
  table kinetic = integral(plug, 1.5*dot(u', u')), height = u.y at [0.2, 0.4]
"""
    t = table(script.replace("superpotential layer(r) with slope -2*r + 3*max(r, 0)\n", ""))
    speed = 2 - 4 / 3
    close(t["kinetic"][-1], 1.5 * speed ** 2 * math.pi * 0.25, 1e-10, "kinetic energy")
    close(t["height"][-1], 2 - 4 / 3 / 2, 1e-10, "height")
    # The axis, where u.x = 0, does not hold it: the norm of V has the mass in it, and B is not coercive.
    script = script.replace(" >= integral(plug, dot(", " + integral(foot, layer^0(u.nu; v.nu)) >= integral(plug, dot(")
    code, said, _ = run(script, command="check")
    assert code == 0 and re.search(r"m_B +0 +FAILS", said), said
    trace = float(re.search(r"normal\s+([0-9.e+-]+)", said)[1])
    assert 1 < trace < 2, f"trace norm {trace}: at least that of a translation, 1 by the height"


def damage():
    """A state in the body of revolution, uniform tension: z' = -z e, stress (1 - (1 - z)) E eps of a bar."""
    t = table("""
mesh bar = rectangle(0.5, 1, cells = [2, 3], axisymmetric = true)
part foot = bar.bottom
part head = bar.top
tensor B = isotropic(young = 100, poisson = 0.3)
state whole on bar with rate -whole*(eps(u).yy + eps(u).zz + eps(u).xx)*10 from whole = 1 in [0, 1]
space V = vector P1 on bar, zero.y on foot, zero.y on head
find u in V with u.y = 0.1*t on head for t in [0, 1] by 16 steps from u = 0 such that for all v in V
  integral(bar, whole * (B : eps(u)) : eps(v)) = 0
report
  table whole = integral(bar, whole), force = integral(bar, sigma.yy)
""")
    z = 1.0
    for n in range(1, 17):
        z = z / (1 + 10 * 0.1 * n / 16 * 0.4 / 16)  # implicit: the sum of strains is (1 - 2 nu) eps
    close(t["whole"][-1], z * math.pi * 0.25, 1e-8, "state")
    close(t["force"][-1], z * 10 * math.pi * 0.25, 1e-8, "force")


def corners():
    """Where facets meet at an angle a law on u.y has two points with one argument: integrals read their mean, as files do. 24 scenes."""
    import meshio

    random = np.random.default_rng(17)
    for k in range(24):
        element, ring = ("P1", "P2")[k % 2], k % 4 < 2
        scale = 10 ** random.uniform(-4, 4)  # of lengths
        argument = "u.y" if random.random() < 0.5 else "0.6*u.x + u.y"
        script = f"""
mesh bead = {f"disk({4 * scale}, 0, {scale}" if ring else f"disk(0, 0, {scale}"}, size = {random.uniform(0.15, 0.4) * scale}{", axisymmetric = true" if ring else ""})
part foot = bead.rim where y < {-0.6 * scale}
part lid  = bead.rim where y > {0.5 * scale}
tensor B  = isotropic(young = {10 ** random.uniform(-3, 6)}, poisson = {random.uniform(0, 0.45)})
superpotential pressed(r) with slope | r < 0 -> 0 | otherwise -> 1e300
space V = vector {element} on bead, zero on foot
find u in V such that for all v in V
  integral(bead, B : eps(u) : eps(v)) + integral(lid, pressed^0({argument} + y - {random.uniform(0.75, 0.95) * scale}; {argument.replace("u", "v")})) >= 0
report
  table force = integral(lid, pressed.xi), square = integral(lid, pressed.xi^2)
  fields pressed.xi
"""
        with tempfile.TemporaryDirectory() as folder:
            code, said, results = run(script, keep=folder)
            assert code == 0 and results["certificate"]["certified"], said
            grid = meshio.read(next(pathlib.Path(folder, "out").glob("*pressed_xi*.vtu")))
        xi = grid.point_data["pressed.xi"].ravel()
        force = square = 0.0
        for cell in grid.cells[0].data:
            a, b = grid.points[cell[0]], grid.points[cell[1]]
            r = TWO_PI * np.array([a[0], b[0]]) if ring else np.ones(2)
            weights = [r[0] / 3 + r[1] / 6, r[0] / 6 + r[1] / 3] if element == "P1" else [r[0] / 6, r[1] / 6, (r[0] + r[1]) / 3]
            measured = np.linalg.norm(a - b) * np.array(weights)
            force, square = force + measured @ xi[cell], square + measured @ xi[cell] ** 2
        values = results["table"]
        assert force > 0, "nothing touches"
        close(values["force"][-1], force, 1e-12, f"scene {k}, {element}: force")
        close(values["square"][-1], square, 1e-12, "integral of the square")


def pairs():
    """Two rings, or cylinders, of other meshes pressed on each other: a uniform stress, by a spring law and by a wall with a gap."""
    laws = {"spring": ("0.5*40*r^2", "jump(u).nu", 1 / 40, 0.0),
            "wall": ("0", "jump(u).nu - gap(seam)", 0.0, 0.01)}
    for name, (potential, argument, give, gap) in laws.items():
        law = "superpotential layer(r) with slope | r < 0 -> 0 | otherwise -> 1e300" if name == "wall" else f"superpotential layer(r) = {potential}"
        for element in ("P1", "P2"):
            for inner in (0.0, 0.7):
                t = table(f"""
mesh upper = rectangle(1, 0.5, cells = [5, 2], at = [{inner}, {1 + gap}], axisymmetric = true)
mesh lower = rectangle(1, 1, cells = [3, 4], origin = [{inner}, 0], grading = [1.5, 1], axisymmetric = true)
mesh both  = upper + lower
part head = upper.top
part foot = lower.bottom
part seam = pair(upper.bottom, lower.top)
tensor B = isotropic(young = 100, poisson = 0.3)
{law}
space V = vector {element} on both, zero.y on foot, zero.y on head
find u in V with u.y = -0.1*t on head for t in [0, 1] by 2 steps from u = 0 such that for all v in V
  integral(both, B : eps(u) : eps(v)) + integral(seam, layer^0({argument}; jump(v).nu)) >= 0
report
  table stress = sigma.yy at [{inner + 0.3}, 0.4], wide = u.x at [{inner + 1}, 0.2], hoop = sigma.zz at [{inner + 0.5}, 0.6],
        pressed = integral(seam, layer.xi), area = integral(seam, 1, rule = nodal), held = integral(foot, sigma.yy)
""")
                stress = (0.1 - gap) / (1.5 / 100 + give)
                area = math.pi * ((1 + inner) ** 2 - inner ** 2)
                said = f"{name}, {element}, from r = {inner}"
                close(-t["stress"][-1], stress, 1e-12, f"{said}: stress")
                close(t["wide"][-1], 0.3 * stress / 100 * (1 + inner), 1e-12, "u.x at the outside")
                below(abs(t["hoop"][-1]) / stress, 1e-12, "hoop stress")
                close(t["pressed"][-1], stress * area, 1e-12, "force between them")
                close(-t["held"][-1], stress * area, 1e-12, "force below")


if __name__ == "__main__":
    sys.exit(judge([patch, measures, scalar, resultants, free_motion, axis, bits, sphere, creep, tube, turned, inertia, damage, corners, pairs]))
