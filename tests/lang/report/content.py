"""The file of `hvi-run report`: its blocks are unpacked and compared with the VTU files and the JSON of the same run; it loads nothing
and holds no markup of a script's texts.  usage: content.py HVI_RUN"""
import base64
import html.parser
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zlib

import meshio
import numpy as np

PROGRAM = sys.argv[1]
EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)>&amp;"
PLANE = f"""param n = 4
param N = 6 in [1, 1000] "{EVIL}"
mesh slab = rectangle(2, 1, cells = [2*n, n])
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
kernel C(t, s) = -exp(-(t - s)/0.5) * B
superpotential layer(r) with slope | r < 0 -> 0 | r < 0.02 -> 100*r | r < 0.06 -> 2 - 40*(r - 0.02) | otherwise -> 0.1
superpotential slip(w) = 0.05 * norm(w)
space V = vector ELEMENT on slab, zero on roof
find u in V for t in [0, 1] by N steps from u = 0
such that for all v in V
    integral(slab, B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v)) + integral(slab, history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu) + slip^0(u.tau; v.tau))
 >= integral(slab, dot([2*t, -6*t], v))
report
  table a = u.y at [1, 0], f = integral(ground, layer.xi)
  fields u, sigma, layer.xi, slip.xi
"""
SPACE = """mesh block = box(1, 1, 1, cells = [2, 2, 2])
part top = block.top
part bottom = block.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
import contact
superpotential floor(r) = unilateral(r)
space V = vector ELEMENT on block, zero on top
find u in V such that for all v in V
    integral(block, B : eps(u) : eps(v)) + integral(bottom, floor^0(u.nu - 0.002; v.nu)) >= integral(block, dot([0, -2, 0], v))
report
  table a = u.y at [0, 0, 0]
  fields u, sigma, floor.xi
"""
WORN = """mesh body = rectangle(2, 1, cells = [8, 4])
part wall = body.left
part grip = body.right
part soft = body where x < 1
part hard = body where x > 1
tensor B = isotropic(lambda = 40, mu = 30)
state d on soft with rate 5*norm(eps(u)) from d = 0.1*y in [0, 0.95]
superpotential pad(r) = 10*r^2
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] by 4 steps from u = 0
such that for all v in V
    integral(soft, (1 - d)*B : eps(u) : eps(v)) + integral(hard, B : eps(u) : eps(v)) + integral(grip, pad^0(u.nu; v.nu))
 >= integral(body, dot([0.8*t, 0.4*t], v))
report
  fields u, eps(u), d, 2*d - 1, pad.xi
"""
PULLED = """mesh strip = rectangle(1, 0.01, cells = [8, 1], grading = [11, 1])
part left = strip.left
part right = strip.right
part ground = strip.bottom
tensor B = isotropic(young = 1, poisson = 0)
superpotential slip(w) = 1e-9 * norm(w)
space V = vector P1 on strip, zero.x on left, zero.y on ground
find u in V such that for all v in V
    integral(strip, B : eps(u) : eps(v)) + integral(ground, slip^0(u.tau; v.tau)) >= integral(right, dot([0.001, 0], v))
report
  table a = u.x at [1, 0]
"""
BAR = """mesh bar = interval(1, cells = 8)
part left = bar.left
part right = bar.right
space V = scalar P1 on bar, zero on left
superpotential spring(r) = 0.5*r^2
find u in V such that for all v in V
  integral(bar, dot(grad(u), grad(v))) + integral(right, spring^0(u; v)) >= integral(bar, v)
report
  table a = u at [1]
"""
failures = 0


def check(what, good, more=""):
    global failures
    if not good:
        failures += 1
        print("FAIL", what, more)


class Page(html.parser.HTMLParser):
    """Scripts by id, all other elements and their attributes."""

    def __init__(self, text):
        super().__init__()
        self.scripts, self.elements, self.inside = {}, [], None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.elements.append((tag, attributes))
        if tag == "script":
            self.inside = attributes.get("id", "code")
            self.scripts[self.inside] = ""

    def handle_endtag(self, tag):
        if tag == "script":
            self.inside = None

    def handle_data(self, data):
        if self.inside is not None:
            self.scripts[self.inside] += data

    @property
    def data(self):
        return json.loads(self.scripts["report-data"])

    def numbers(self, name, kind="<f4"):
        return np.frombuffer(zlib.decompress(base64.b64decode(self.scripts[name])), kind)


def page_of(folder):
    [path] = folder.glob("*_report.html")
    text = path.read_text()
    page = Page(text)
    check("scripts with a name are data, one is the code", set(page.scripts) - {"report-data", "code"} == {f"b{i}" for i in range(len(page.scripts) - 2)})
    check("no element of the script's", not [e for e in page.elements if e[0] in ("img", "iframe", "link", "object")])
    check("nothing is loaded", not [e for e in page.elements if "src" in e[1] or e[1].get("href", "#")[0] != "#"])
    check("no address of a network in the code", not re.search(r"https?://(?!www\.w3\.org/)", page.scripts["code"]))
    check("no handler in an attribute", not [e for e in page.elements if any(k.startswith("on") for k in e[1])])
    return page


def run(folder, script, *words, name="scene"):
    path = folder / f"{name}.hvi"
    path.write_text(script)
    out = folder / "out"
    done = subprocess.run([PROGRAM, *(words or ["report"]), path.name, "-o", "out", "--json", "r.json"], cwd=folder, capture_output=True, text=True)
    check(f"{words or 'report'} ends well", done.returncode == 0, done.stdout + done.stderr)
    return out, page_of(out), json.loads((folder / "r.json").read_text())


def at_nodes(mesh, values):
    """Means of cells by their sizes, worked out here once more."""
    cells = mesh.cells[0].data
    corners = mesh.points[cells[:, :cells.shape[1] if cells.shape[1] < 5 else 4]] if mesh.cells[0].type.startswith("tetra") else mesh.points[cells[:, :3]]
    if corners.shape[1] == 4:
        size = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    else:
        size = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total, weight = np.zeros((len(mesh.points), 9)), np.zeros(len(mesh.points))
    for k in range(cells.shape[1]):
        np.add.at(total, cells[:, k], size[:, None] * values)
        np.add.at(weight, cells[:, k], size)
    return total / weight[:, None]


def same(what, a, b):
    a, b = np.asarray(a, float).ravel(), np.asarray(b, float).ravel()
    check(what, a.shape == b.shape and np.abs(a - b).max() <= 2e-7 * max(np.abs(b).max(), 1e-300), (a.shape, b.shape))


def fields(folder, script, stem="scene", laws=()):
    out, page, result = run(folder, script)
    data = page.data["fields"]
    files = sorted(out.glob(f"{stem}_[0-9]*.vtu"))
    check("a frame for each step", len(files) == len(data["frames"]), (len(files), len(data["frames"])))
    for file, frame in zip(files, data["frames"]):
        mesh = meshio.read(file)
        same("points", page.numbers(data["points"]), mesh.points)
        names = {array["name"]: block for array, block in zip(data["arrays"], frame["data"])}
        check("arrays of cells say that they are means", {a["name"]: a["means"] for a in data["arrays"]}.items() >= {"displacement": False, "sigma": True}.items())
        same("displacement", page.numbers(names["displacement"]), mesh.point_data["u"])
        same("stress", page.numbers(names["sigma"]), at_nodes(mesh, mesh.cell_data["sigma"][0].reshape(-1, 9)))
        for law in frame["laws"]:
            of_law = meshio.read(str(file).replace(f"{stem}_0", f"{stem}_{law['name']}_xi_0"))
            xi = page.numbers(law["xi"])
            points = page.numbers(law["points"]).reshape(-1, 3)
            order = [int(np.argmin(np.linalg.norm(of_law.points - p, axis=1))) for p in points]
            same("multipliers", xi, of_law.point_data[f"{law['name']}.xi"][order])
            judge_branches(law, xi, page.numbers(law["branch"]), page.numbers(law["force"]).reshape(-1, 3))
            if law["name"] == "slip":
                judge_slip(page.numbers(law["branch"]), points, mesh)
    cells = page.numbers(data["cells"], "<u4").reshape(-1, data["dim"] + 1)
    x = page.numbers(data["points"]).reshape(-1, 3)[cells].astype(float)
    edges = (x[:, 1:] - x[:, :1])[:, :, :data["dim"]]
    check("cells fill the body", abs(np.linalg.det(edges).sum() / (2 if data["dim"] == 2 else 6) - VOLUME[stem]) < 1e-6)
    check("names of laws", {law["name"] for law in data["frames"][-1]["laws"]} == set(laws))
    table = page.data["result"]["table"]
    check("the table is that of the JSON", table == result["table"])
    return page


def states(folder):
    """Fields that read the states of a part: on the body, with what the stress is away from it; what is nothing there has no value."""
    out, page, _ = run(folder, WORN)
    data = page.data["fields"]
    check("the script's own fields are there", [a["name"] for a in data["arrays"]] == ["displacement", "eps_u", "sigma", "d", "2_times_d_minus_1"], data["arrays"])
    check("states are no laws", [law["name"] for law in data["frames"][-1]["laws"]] == ["pad"])
    mesh = meshio.read(out / "scene_00004.vtu")
    part = meshio.read(out / "scene_d_00004.vtu")
    shown = {array["name"]: page.numbers(block).astype(float) for array, block in zip(data["arrays"], data["frames"][-1]["data"])}
    middles = lambda m: m.points[m.cells[0].data].mean(axis=1)
    worn = np.full(len(mesh.cells[0].data), np.nan)
    for middle, value in zip(middles(part), part.cell_data["d"][0]):
        worn[np.argmin(np.linalg.norm(middles(mesh) - middle, axis=1))] = value
    eps = mesh.cell_data["eps_u"][0].reshape(-1, 3, 3)
    stress = (1 - np.nan_to_num(worn))[:, None, None] * (40 * (eps[:, 0, 0] + eps[:, 1, 1])[:, None, None] * np.eye(3) + 60 * eps)
    wanted = at_nodes(mesh, stress.reshape(-1, 9))
    for k in (0, 1, 3, 4, 8):
        same("stress of a damaged body", shown["sigma"].reshape(-1, 9)[:, k], wanted[:, k])
    soft = mesh.points[:, 0] <= 1
    check("a state has no value away from its part", (np.isnan(shown["d"]) == ~soft).all())
    inside = np.flatnonzero(~np.isnan(worn))
    sums, weights = np.zeros(len(mesh.points)), np.zeros(len(mesh.points))
    for cell in inside:  # all cells have one size
        np.add.at(sums, mesh.cells[0].data[cell], worn[cell])
        np.add.at(weights, mesh.cells[0].data[cell], 1.0)
    same("damage", shown["d"][soft], (sums[soft] / weights[soft]))
    same("an expression of the damage", shown["2_times_d_minus_1"][soft], 2 * (sums[soft] / weights[soft]) - 1)


VOLUME = {"scene": 2.0, "block": 1.0}


def judge_branches(law, xi, branch, force):
    """open 0, loaded 1, softened 2, held 3, stick 4, slip 5: by what the laws above say of xi."""
    if law["name"] == "layer":
        check("open where nothing presses", ((branch == 0) == (xi == 0)).all())
        check("branches of layer", set(branch) <= {0, 1, 2})
        # On the ground nu = (0, -1): the force on the body is xi upwards.
        same("force of layer", force, np.outer(xi, [0, 1, 0]))
    if law["name"] == "slip":
        size = np.abs(xi) if xi.size == branch.size else np.linalg.norm(xi.reshape(branch.size, -1), axis=1)
        check("slip at the bound", np.allclose(size[branch == 5], 0.05, rtol=1e-6))
        check("stick below it", (size[branch == 4] <= 0.05 * (1 + 1e-6)).all() and set(branch) <= {4, 5})
    if law["name"] == "floor":
        check("held where it presses", ((branch == 3) == (xi > 0)).all() and (branch == 3).any())


def judge_slip(branch, points, mesh):
    """What slides has moved along the ground; corners of cells alone are in the file."""
    away = np.linalg.norm(mesh.points[None, :, :] - points[:, None, :], axis=2)
    known = away.min(axis=1) < 1e-6
    slid = np.abs(mesh.point_data["u"][away.argmin(axis=1), 0])
    check("stick where nothing slid", known.sum() > 3 and ((branch == 5) == (slid > 1e-9 * slid.max()))[known].all() and (branch == 5).any(), (branch, slid))


def pulled(folder):
    """A strip that is pulled along a ground that hardly holds it, u = x/1000: what has moved by 2e-7 of the largest slips, too."""
    _, page, _ = run(folder, PULLED)
    (law,) = page.data["fields"]["frames"][-1]["laws"]
    points, branch = page.numbers(law["points"]).reshape(-1, 3), page.numbers(law["branch"])
    near = (points[:, 0] > 0) & (points[:, 0] < 1e-6)
    check("stick at the end that is held", near.any() and ((branch == 5) == (points[:, 0] > 0)).all(), (points, branch))


def resumed(folder):
    """The page of a run that goes on from a checkpoint has the fields since then, and says since when; tables are of all steps."""
    steps = lambda page: [frame["step"] for frame in page.data["fields"]["frames"]]
    text = BAR.replace("find u in V", "param T = 2\nfind u in V for t in [0, T] by 4*T steps")
    _, page, _ = run(folder, text, "report")
    check("frames of a whole run", steps(page) == list(range(1, 9)) and page.data["fields"]["since"] == 0, steps(page))
    whole = page.data["result"]["table"]
    shutil.rmtree(folder / "out")
    run(folder, text, "report", "-D", "T=1", "--checkpoint", "3")
    _, page, _ = run(folder, text, "report", "--resume", "--checkpoint", "3")
    check("frames of a resumed run", steps(page) == [5, 6, 7, 8] and page.data["fields"]["since"] == 4, steps(page))
    check("tables of a resumed run", page.data["result"]["table"] == whole)
    _, page, _ = run(folder, text, "report", "--resume")
    check("frames of a run that is over", steps(page) == [8] and page.data["fields"]["since"] == 8, steps(page))


def main():
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place) / "worn"
        folder.mkdir()
        states(folder)
        folder = pathlib.Path(place) / "resumed"
        folder.mkdir()
        resumed(folder)
        folder = pathlib.Path(place) / "pulled"
        folder.mkdir()
        pulled(folder)
        for k, element in enumerate(("P1", "P2")):
            folder = pathlib.Path(place) / f"plane{k}"
            folder.mkdir()
            page = fields(folder, PLANE.replace("ELEMENT", element), laws=("layer", "slip"))
            check("hypotheses", len(page.data["hypotheses"]["hypotheses"]) > 5)
            check("the documentation of a parameter is data", page.data["parameters"][1]["doc"] == EVIL)
            graph = np.array(page.data["model"]["laws"][0]["graph"])
            check("the graph of the law", np.allclose(np.interp([0.01, 0.04, 0.07], graph[:, 0], graph[:, 1]), [1, 1.2, 0.1], atol=0.05))
            check("a jump is vertical", any(np.allclose(graph[i, 0], 0.06) and np.allclose(graph[i + 1, 0], 0.06) for i in range(len(graph) - 1)))
            kernel = np.array(page.data["model"]["kernels"][0]["graph"])
            check("the graph of the kernel", len(kernel) > 50 and np.allclose(kernel[:, 1], -np.exp(-kernel[:, 0]/0.5), atol=1e-5))
            check("energies", "energy" in page.data["monitors"]["names"] and page.data["monitors"]["balance_error"] < 1e-10)
            check("mathematics", "∫" in json.dumps(page.data["model"]["find"], ensure_ascii=False))
        folder = pathlib.Path(place) / "space"
        folder.mkdir()
        VOLUME["scene"] = 1.0
        fields(folder, SPACE.replace("ELEMENT", "P1"), laws=("floor",))
        for k, words in enumerate((["check", "--report"], ["stability", "--report"])):
            folder = pathlib.Path(place) / f"other{k}"
            folder.mkdir()
            _, page, result = run(folder, PLANE.replace("ELEMENT", "P1"), *words)
            part = "hypotheses" if words[0] == "check" else "stability"
            check(f"page of {words[0]}", page.data[part] and set(page.data[part]) == set(result))
        folder = pathlib.Path(place) / "study"
        folder.mkdir()
        _, page, result = run(folder, PLANE.replace("ELEMENT", "P1") + "study vary N in [2, 4, 8] against finest in V\n", "study", "--report")
        check("page of study", page.data["study"] == result)
        folder = pathlib.Path(place) / "bar"
        folder.mkdir()
        name = "<img src=x onerror=alert(3)>&\"'"
        _, page, result = run(folder, BAR, name=name)
        check("a script's name is data", page.data["title"] == name and page.data["fields"]["dim"] == 1)
        bar = page.data["fields"]
        end = int(np.argmax(page.numbers(bar["points"])[::3]))
        same("a bar", page.numbers(bar["frames"][-1]["data"][0])[end], result["final"]["a"])
    print("report:", "ok" if failures == 0 else f"{failures} failures")
    sys.exit(failures > 0)


main()
