"""Laws of gradients whose slope is linear, against the forms that they are: other matrices, no law.

usage: gradients.py HVI_RUN

j(r) = 1.5 r^2 of M u is the form 3 Mu Mv. Every scheme, laws of u, u', memories and sums of them, P1 and P2, 2D and 3D, rings, strains, div u, coefficients,
parts of the body, a second unknown, a start at rest, beside a law on the boundary, and up to nine numbers: eps(u) and grad(u) of vectors, their deviators, lists
of their entries. All columns of both tables agree to 1e-12 of the largest value of each.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

AGREE = 1e-12
SQUARE, BLOCK = "rectangle(1, 1, cells = [4, 3])", "box(1, 1, 1, cells = [2, 2, 2])"
SIZE = "size = norm(u)"
STEPS = "for t in [0, 1] by 5 steps from u = 0"
STRAIN = "[eps({0}).xx, eps({0}).yy, sqrt(2)*eps({0}).xy]"
SIX = "[eps({0}).xx, eps({0}).yy, eps({0}).zz, sqrt(2)*eps({0}).yz, sqrt(2)*eps({0}).xz, sqrt(2)*eps({0}).xy]"

SCRIPT = """mesh body = {mesh}
part hold = body.{held}
part far = body.right
part inner = body where x < 0.5
kernel q(lag) = exp(-2*lag)
superpotential lin(r) = 1.5*r^2
superpotential vec(xi) = 1.5*norm(xi)^2
superpotential wall(r) with slope 4*max(r - 0.1, 0)
{spaces}
{find} {time}
such that for all {tests}
    {forms} + {term}
 >= {load}
report
  table {table}
"""


def scalar(order, term, form, forms="", time=STEPS, **other):
    return {"spaces": f"space V = scalar P{order} on body, zero on hold", "load": "integral(body, (1 + t)*v)", "term": term, "form": form,
            "forms": "integral(body, 2*dot(grad(u), grad(v)))" + forms, "time": time, **other}


def vector(order, dim, term, form, **other):
    return {"spaces": f"space V = vector P{order} on body, zero on hold", "mesh": SQUARE if dim == 2 else BLOCK, "term": term, "form": form,
            "forms": "integral(body, 2*eps(u) : eps(v)) + integral(far, wall^0(u.nu; v.nu))",
            "load": f"integral(body, dot((1 + t)*{[1, 0.5, 0.5][:dim]}, v))", **other}


def matrix(order, dim, of, seen="u", **other):
    """A law of all of a matrix, `of` with a place for the function; its multiplier is that matrix three times."""
    u, v = of.format(seen), of.format("v")
    names = {"xy": "{0}.xy", "yx": "{0}.yx", "power": "{0} : (" + u + ")"}
    most = ["most = largest(body, norm({0}))"] if order == 1 else []  # at the points of the law, and at nodes
    table = ", ".join([SIZE, *[f"{name} = integral(body, {what})" for name, what in names.items()], *most])
    return vector(order, dim, f"integral(body, vec^0({u}; {v}))", f"integral(body, 3*({u}) : ({v}))", table=table.format("vec.xi"),
                  of_form={"table": table.format(f"(3*({u}))")}, **other)


def aged(dim):
    """A law that grows with what the size of its own multiplier, a matrix, has added up to, and a form that does."""
    case = vector(1, dim, "integral(body, aged^0(eps(u); eps(v)))", "integral(body, 3*(1 + d)*eps(u) : eps(v))", table=SIZE + ", most = largest(body, d)")
    state = "\nstate d on body with rate norm({0}) + abs({0}.xy) from d = 0"
    case["of_form"] = {"spaces": case["spaces"] + state.format("(3*(1 + d)*eps(u))")}
    case["spaces"] += state.format("aged.xi") + "\nsuperpotential aged(xi) = 1.5*(1 + d)*norm(xi)^2"
    return case


def on_two_parts():
    """One law of a vector on the boundary and of a matrix in the body: its multiplier has the shape that it has where it is asked."""
    table = SIZE + ", most = largest(body, norm({inside})), pull = integral(far, {outside}.x), xy = integral(body, {inside}.xy)"
    return vector(1, 3, "integral(far, vec^0(u; v)) + integral(body, vec^0(eps(u); eps(v)))", "integral(far, 3*dot(u, v), rule = nodal) + integral(body, 3*eps(u) : eps(v))",
                  table=table.format(inside="vec.xi", outside="vec.xi"), of_form={"table": table.format(inside="(3*eps(u))", outside="(3*u)")})


def gradient(of):
    return f"integral(body, vec^0(grad({of}); grad(v)))", f"integral(body, 3*dot(grad({of}), grad(v)))"


def cases(order):
    viscous = " + integral(body, dot(grad(u'), grad(v)))"
    for scheme in ("backward_euler", "bdf2"):
        for of in ("u", "u'"):
            yield f"{scheme}, {of}", scalar(order, *gradient(of), viscous, f"{STEPS} using scheme = {scheme}")
    for scheme in ("newmark", "hht"):
        yield scheme, scalar(order, *gradient("u"), " + integral(body, u''*v)", f"for t in [0, 1] by 5 steps from u = 0, u' = 0 using scheme = {scheme}")
    yield "a start at rest", scalar(order, *gradient("u"), viscous, STEPS.replace("u = 0", "u = static"))
    yield "a sum", scalar(order, "integral(body, vec^0(grad(u) + 0.2*grad(u'); grad(v)))", "integral(body, 3*dot(grad(u) + 0.2*grad(u'), grad(v)))")
    yield "a memory", scalar(order, *gradient("history(q, u)"))
    yield "a part", scalar(order, "integral(inner, 2*vec^0(grad(u); grad(v)))", "integral(inner, 6*dot(grad(u), grad(v)))")
    yield "rings", scalar(order, *gradient("u"), mesh=SQUARE.replace("])", "], axisymmetric = true)"), held="top")
    if order == 1:  # the middles of cells, for both
        yield "coefficients", scalar(order, "integral(body, 2*lin^0((1 + x)*grad(u).x + u; (1 + x)*grad(v).x + v), rule = midpoint)",
                                     "integral(body, 6*((1 + x)*grad(u).x + u)*((1 + x)*grad(v).x + v), rule = midpoint)")
        yield "a law on two parts", on_two_parts()
        for dim in (2, 3):
            yield f"{dim}D, a law with a state of its stress", aged(dim)
        yield "rings of vectors", vector(order, 2, "integral(body, vec^0(eps(u); eps(v)))", "integral(body, 3*eps(u) : eps(v), rule = midpoint)",
                                         mesh=SQUARE.replace("])", "], axisymmetric = true)"), held="top")
    for dim in (2, 3):
        yield f"{dim}D, div u", vector(order, dim, "integral(body, lin^0(div(u); div(v)))", "integral(body, 3*div(u)*div(v))")
        yield f"{dim}D, a strain", vector(order, dim, "integral(body, lin^0(eps(u).xy; eps(v).xy))", "integral(body, 3*eps(u).xy*eps(v).xy)")
        yield f"{dim}D, strains", vector(order, dim, f"integral(body, vec^0({STRAIN.format('u')}; {STRAIN.format('v')}))",
                                         "integral(body, 3*(eps(u).xx*eps(v).xx + eps(u).yy*eps(v).yy + 2*eps(u).xy*eps(v).xy))")
        for of in ("eps({0})", "grad({0})", "dev(eps({0}))", "grad({0}) - eps({0})"):
            yield f"{dim}D, {of.format('u')}", matrix(order, dim, of)
    yield "a matrix of the rate", matrix(order, 3, "eps({0})", "u'")
    yield "six numbers", vector(order, 3, f"integral(body, vec^0({SIX.format('u')}; {SIX.format('v')}))", "integral(body, 3*eps(u) : eps(v))")
    yield "a sum of matrices", vector(order, 3, "integral(body, vec^0(eps(u) + 0.2*eps(u'); eps(v)))", "integral(body, 3*(eps(u) + 0.2*eps(u')) : eps(v))")
    yield "a memory of a matrix", vector(order, 3, "integral(body, vec^0(eps(history(q, u)); eps(v)))", "integral(body, 3*eps(history(q, u)) : eps(v))")
    yield "a second unknown", {
        "spaces": f"space V = vector P2 on body, zero on hold\nspace W = scalar P{order} on body, zero on hold", "find": "find u in V, th in W",
        "time": "for t in [0, 1] by 5 steps from u = 0, th = 0", "tests": "v in V, et in W", "table": "a = u.x at [1, 0.5], b = th at [1, 0.5]",
        "forms": "integral(body, 2*eps(u) : eps(v)) + integral(body, th'*et) + integral(body, dot(grad(th), grad(et))) - integral(body, th*div(v))",
        "term": "integral(body, vec^0(grad(th); grad(et)))", "form": "integral(body, 3*dot(grad(th), grad(et)))",
        "load": "integral(body, et + dot([1, 0], v))"}


def table(program, folder, case, term):
    values = {"mesh": SQUARE, "held": "left", "find": "find u in V", "tests": "v in V", "time": STEPS, "table": SIZE}
    values |= case | {"term": term}
    path = folder / "scene.hvi"
    path.write_text(SCRIPT.format(**values))
    done = subprocess.run([program, "run", path, "--no-files", "--quiet", "--json", folder / "out.json"], capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        return done.stdout + done.stderr, {}
    columns = json.loads((folder / "out.json").read_text())["table"]
    return "", {name: column for name, column in columns.items() if name not in ("t", "event")}


def main():
    program, wrong = pathlib.Path(sys.argv[1]).resolve(), 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        for order in (1, 2):
            for name, case in cases(order):
                error, law = table(program, folder, case, case["term"])
                other_error, form = table(program, folder, case | case.get("of_form", {}), case["form"])
                off = max((abs(a - b) / max(map(abs, form[c])) for c in form for a, b in zip(law.get(c, []), form[c])), default=1.0)
                if error or other_error or not off <= AGREE or len(law) != len(form):
                    wrong += 1
                    print(f"P{order}, {name}: {off:.1e} {error} {other_error}")
    print(f"{wrong} wrong")
    return 1 if wrong else 0


sys.exit(main())
