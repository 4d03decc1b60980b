"""Units beside numbers: in the metadata of tables, in VTU files, in pictures, in the data of reports. Names in the files stay those of
the script, and a script without units gets none of it.  usage: units_told.py HVI_RUN"""
import csv
import html
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET

import meshio

PROGRAM = sys.argv[1]
failures = []
SCRIPT = """units mm, N, s
import contact
param E = 70 [GPa]
mesh slab = rectangle(20 [mm], 10 [mm], cells = [4, 2])
part left = slab.left
part ground = slab.bottom
tensor B = isotropic(young = E, poisson = 0.3)
kernel fading(lag) = -0.5 [MPa/(mm*s)]*exp(-lag/(4 [s]))
superpotential layer(r) = normal_compliance(r, stiffness = 100 [MPa/mm], power = 1)
space V = vector P1 on slab, zero on left
find u in V for t in [0, 10] [s] by 2 steps from u = 0
such that for all v in V
    integral(slab, B : eps(u) : eps(v)) + integral(slab, 1 [GPa*s]*(eps(u') : eps(v))) + integral(ground, dot(history(fading, u), v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(slab, dot([0, -78.5 [kN/m^3]*t/(1 [s])], v))
report
  table tip = u.y at [20, 10] [mm], s = sigma.yy at [10, 5] [mm], R = reaction(left), N = norm(u), ratio = u.y/x at [20, 10] [mm]
  table depth = u.y at [10, 0] [mm] to "some,where.csv"
  fields u, sigma, eps(u), u', layer.xi
  line u, sigma.yy from [0, 5] [mm] to [20, 5] [mm] by 3 points
  picture sigma to "stress.svg"
  picture u' at t = 5 [s] to "rate.svg"
  picture layer, fading to "law.svg"
study vary E in [70, 80] [GPa]
"""
PLAIN = [(" [mm]", ""), (" [s]", ""), ("70 [GPa]", "70e3"), ("100 [MPa/mm]", "100"), ("-78.5 [kN/m^3]*t/(1)", "-78.5e-6*t"), ("1 [GPa*s]", "1e3"), ("0.5 [MPa/(mm*s)]", "0.5"), ("[70, 80] [GPa]", "[70e3, 80e3]")]
TABLE = {"t": "s", "tip": "mm", "s": "MPa", "R_x": "N/mm", "R_y": "N/mm", "N": "mm", "ratio": "1"}
LINE = {"distance": "mm", "x": "mm", "y": "mm", "u.x": "mm", "u.y": "mm", "sigma.yy": "MPa"}
FIELDS = {"u": "mm", "sigma": "MPa", "eps_u": "1", "u_rate": "mm/s", "TimeValue": "s", "Points": "mm", "layer.xi": "MPa"}


def check(what, good, more=""):
    if not good:
        failures.append(f"{what}: {more}")


def plain():
    out = SCRIPT.replace("units mm, N, s\n", "")
    for old, new in PLAIN:
        out = out.replace(old, new)
    assert "[" not in re.sub(r"\[[-\d, .e*t]*\]|dot\(\[[^\]]*\]", "", out), out
    return out


def run(folder, text):
    (folder / "slab.hvi").write_text(text)
    done = subprocess.run([PROGRAM, "run", "--quiet", "--report", "-o", "out", "--json", "out.json", "slab.hvi"], cwd=folder, capture_output=True, text=True)
    check("the run ends well", done.returncode == 0, done.stderr)
    return folder / "out", json.loads((folder / "out.json").read_text())


def heads(path):
    with open(path, newline="") as file:
        return next(csv.reader(file))


def told(path):
    """Units of a table by its columns, as a reader of the W3C's recommendation finds them."""
    about = json.loads(path.with_name(path.name + "-metadata.json").read_text())
    check("the context of the metadata", about["@context"] == "http://www.w3.org/ns/csvw", about)
    check("the metadata are of this table", path.with_name(about["url"]) == path, about["url"])
    columns = about["tableSchema"]["columns"]
    check("columns in their order", [c["titles"] for c in columns] == heads(path), columns)
    return {c["titles"]: c.get("schema:unitText") for c in columns}


def labels(path):
    """Of a VTU file; the values must come right behind the tag, where VTK's reader looks for them."""
    out = {}
    for array in ET.parse(path).getroot().iter("DataArray"):
        keys = array.findall("InformationKey")
        check(f"values of {array.get('Name')} first", array.text and array.text.strip(), path.name)
        if keys:
            check("keys of VTK", [(k.get("name"), k.get("location")) for k in keys] == [("UNITS_LABEL", "vtkDataArray")], path.name)
            out[array.get("Name")] = keys[0].text
    return out


def with_units(out, result):
    check("names of the table", heads(out / "slab.csv") == list(TABLE), heads(out / "slab.csv"))
    check("the table's units", told(out / "slab.csv") == TABLE, told(out / "slab.csv"))
    check("a table with a name of its own", told(out / "some,where.csv") == {"t": "s", "depth": "mm"})
    check("a line's units", told(out / "slab_line.csv") == LINE, told(out / "slab_line.csv"))
    monitors = told(out / "slab_monitors.csv")
    energies = {"energy", "elastic", "contact", "work", "viscous", "memory", "lost"}
    check("energies, for one unit of thickness", {name for name, unit in monitors.items() if unit == "N"} == energies and monitors["t"] == "s", monitors)
    check("what has no unit of its own gets none", {unit for name, unit in monitors.items() if name not in energies | {"t"}} == {None}, monitors)
    files = sorted(out.glob("*.vtu"))
    check("files of two steps, of the body and of the contact", len(files) == 4, files)
    found = {}
    for file in files:
        found.update(labels(file))
        check("meshio reads it", len(meshio.read(file).points) > 0)
    check("units in VTU", found == FIELDS, found)
    metadata = {f"{name}-metadata.json" for name in ("slab.csv", "some,where.csv", "slab_line.csv", "slab_monitors.csv")}
    check("the files are told", metadata <= set(result["files"]), result["files"])
    stress, rate, law = ((out / name).read_text() for name in ("stress.svg", "rate.svg", "law.svg"))
    check("a picture's bar and axes", all(word in stress for word in ("|sigma| [MPa]", "x [mm]", "y [mm]")))
    check("a picture of a rate, and its time", "|u'| [mm/s], t = 5 s" in html.unescape(rate))
    check("the graph of a law", "z [mm]" in law and "[MPa]" in law)
    check("the graph of a kernel", "s [s]" in law and "q [mW/mm^4]" in law and ">\u22120.5<" in law, re.findall(r">([^<\n]+)<", law))
    page = report(out)
    check("the report's units", page["units"] == {"columns": {**{name: f" [{unit}]" if unit and unit != "1" else "" for name, unit in TABLE.items() if name != "t"}, "depth": " [mm]"},
                                                  "time": " [s]", "length": " [mm]", "energy": " [N]"}, page["units"])
    check("the report's fields", {a["name"]: a["unit"] for a in page["fields"]["arrays"]} == {"displacement": " [mm]", "u_rate": " [mm/s]", "sigma": " [MPa]", "eps_u": ""},
          page["fields"]["arrays"])
    check("the report's laws", [(l["argument"], l["multiplier"]) for l in page["model"]["laws"]] == [("r [mm]", "ξ [MPa]")], page["model"]["laws"][0])


def report(out):
    [data] = re.findall(r'<script type="application/json" id="report-data">(.*?)</script>', (out / "slab_report.html").read_text(), re.S)
    return json.loads(data)


def without(out, result):
    """In the same folder: nothing of the run before is left beside the new tables."""
    check("names of the table without units", heads(out / "slab.csv") == list(TABLE), heads(out / "slab.csv"))
    check("no metadata", not list(out.glob("*-metadata.json")), list(out.glob("*-metadata.json")))
    check("no labels", not any(labels(file) for file in out.glob("*.vtu")))
    check("no units in the report", report(out)["units"] == {} and {a["unit"] for a in report(out)["fields"]["arrays"]} == {""})
    check("no units in pictures", not any("[" in re.sub(r"<[^>]*>", "", (out / name).read_text()) for name in ("stress.svg", "rate.svg", "law.svg")))
    check("nothing of it is told", not any("metadata" in name for name in result["files"]), result["files"])


def studied(folder, text):
    """The head of a study's table, and study.csv with its metadata."""
    (folder / "slab.hvi").write_text(text)
    done = subprocess.run([PROGRAM, "study", "--quiet", "-o", "study", "--json", "study.json", "slab.hvi"], cwd=folder, capture_output=True, text=True)
    check("the study ends well", done.returncode == 0, done.stderr)
    return done.stdout.split("\n")[1].split("  "), json.loads((folder / "study.json").read_text()), folder / "study"


def studies(folder):
    head, result, out = studied(folder, SCRIPT)
    check("heads of a study", [name.strip() for name in head if name][:6] == ["E [GPa]", "tip [mm]", "s [MPa]", "R_x [N/mm]", "R_y [N/mm]", "N [mm]"], head)
    units = {name: unit for name, unit in told(out / "study.csv").items() if unit}
    columns = {**{name: unit for name, unit in TABLE.items() if name != "t" and unit}, "depth": "mm"}
    check("units of study.csv", units == {"E": "GPa", "cpu": "s", "wall": "s", **columns, **{name + "_error": unit for name, unit in columns.items()}}, units)
    check("units in its JSON", result["units"]["E"] == "GPa" and result["units"]["tip"] == "mm", result.get("units"))
    check("axes of its pictures", ">E [GPa]<" in (out / "sweep_tip.svg").read_text() and ">tip [mm]<" in (out / "sweep_tip.svg").read_text())
    head, result, out = studied(folder, plain())
    check("heads of a study without units", not any("[" in name for name in head), head)
    check("no metadata of a study without units", not list(out.glob("*-metadata.json")) and "units" not in result)


def stable(folder):
    """Energies of the report of stability."""
    for text, energy in ((SCRIPT, r"energy +-?[\d.e+-]+ \[N\] at the end"), (plain(), r"energy +-?[\d.e+-]+ at the end")):
        (folder / "slab.hvi").write_text(text)
        done = subprocess.run([PROGRAM, "stability", "-o", "stability", "--json", "stability.json", "slab.hvi"], cwd=folder, capture_output=True, text=True)
        check("the report of stability", done.returncode == 0 and re.search(energy, done.stdout), done.stdout + done.stderr)
        units = json.loads((folder / "stability.json").read_text()).get("units")
        check("its units", units == ({"t": "s", "energy": "N"} if text == SCRIPT else None), units)


def several(folder):
    """Unknowns whose energies are of two kinds have no sum with a unit."""
    warm = SCRIPT.replace("space V", "space W = scalar P1 on slab, zero on left\nspace V").replace("find u in V", "find u in V, theta [K] in W").replace("for all v in V", "for all v in V, q in W")
    warm = warm.replace("    integral(slab, B", "    integral(slab, 1 [W/(m*K)]*dot(grad(theta), grad(q))) + integral(slab, B")
    out, _ = run(folder, warm.replace("norm(u)", "norm(u), warmth = theta at [10, 5] [mm], flow = reaction(left, theta), again = reaction(of = theta, part = left), "
                                                  "heat = integral(of = theta, part = left), force = reaction(left, u)"))
    check("no unit of energies of two kinds", report(out)["units"]["energy"] == "" and "N" not in told(out / "slab_monitors.csv").values(), report(out)["units"])
    units = told(out / "slab.csv")
    check("by position and by name", [units[c] for c in ("flow", "again", "heat", "force_x")] == ["mW/mm", "mW/mm", "mm*K", "N/mm"], units)
    check("each column has its own", told(out / "slab.csv")["warmth"] == "K" and told(out / "slab.csv")["tip"] == "mm")


def norms(folder):
    """The root of an integral of squares of gradients: so it depends on the dimension, and of a scalar that nothing holds there are values beside them."""
    solid = SCRIPT.replace("rectangle(20 [mm], 10 [mm], cells = [4, 2])", "box(20 [mm], 10 [mm], 10 [mm], cells = [2, 1, 1])").replace("dot([0, -78.5 [kN/m^3]*t/(1 [s])], v)", "dot([0, -78.5 [kN/m^3]*t/(1 [s]), 0], v)")
    solid = re.sub(r"\[(\d+), (\d+)\] \[mm\]", r"[\1, \2, 0] [mm]", re.sub("  (line|picture|table depth).*\n", "", solid))
    for held, unit in (("", None), (", zero on left", "mm^(1/2)*K")):
        warm = solid.replace("space V", f"space W = scalar P1 on slab{held}\nspace V").replace("find u in V", "find u in V, theta [K] in W").replace("for all v in V", "for all v in V, q in W")
        warm = warm.replace("    integral(slab, B", "    integral(slab, 1 [W/(m*K)]*dot(grad(theta), grad(q)) + 1 [W/(m^3*K)]*theta*q) + integral(slab, B").replace("norm(u)", "norm(u), heat = norm(theta)")
        out, _ = run(folder, warm)
        units = told(out / "slab.csv")
        check(f"norms in space {held}", (units["N"], units["heat"]) == ("mm^(3/2)", unit), units)


def same_names(folder):
    """Columns may be called as a parameter, an unknown or a state is: each has its own unit."""
    text = SCRIPT.replace("tip = u.y", "E = u.y").replace("norm(u)", "norm(u), u = integral(ground, u.y), wear = layer.xi at [10 [mm], 0]")
    text = text.replace("space V", "state wear on ground with rate 0.01 [1/(MPa*s)]*layer.xi*u.y from wear = 0 [mm]\nspace V")
    text = text.replace("fields u,", "plot u, wear against E\n  fields u,")
    out, result = run(folder, text)
    names = {"E": "mm", "u": "mm^2", "wear": "MPa"}
    by_kind = result["units_by_kind"]
    check("units of columns", {name: by_kind["columns"][name] for name in names} == names, by_kind)
    check("units of what they are called as", (by_kind["params"]["E"], by_kind["variables"]["u"], by_kind["variables"]["wear"], by_kind["variables"]["t"]) == ("GPa", "mm", "mm", "s"), by_kind)
    check("units by name alone are there, too", (result["units"]["E"], result["units"]["s"]) == ("GPa", "MPa"), result["units"])
    check("units of the table", {name: told(out / "slab.csv")[name] for name in names} == names, told(out / "slab.csv"))
    check("the axis of the plot", ">E [mm]<" in (out / "slab_plot.svg").read_text(), re.findall(r">([^<\n]+)<", (out / "slab_plot.svg").read_text()))
    page = report(out)
    check("the unknown in the report", {a["name"]: a["unit"] for a in page["fields"]["arrays"]}["displacement"] == " [mm]", page["fields"]["arrays"])
    head, study, folder = studied(folder, text)
    check("heads of its study", [name.strip() for name in head if name][:2] == ["E [GPa]", "E [mm]"], head)
    check("units of its JSON", study["units_by_kind"] == by_kind, study["units_by_kind"])


def overwritten(folder):
    """The metadata of a table would take the place of a file that the script reads."""
    (folder / "slab.csv-metadata.json").write_text("0,0\n1,1\n")
    (folder / "slab.hvi").write_text(SCRIPT.replace("*t/(1 [s])", "*table(\"slab.csv-metadata.json\", t/(10 [s]))"))
    done = subprocess.run([PROGRAM, "run", "--quiet", "-o", ".", "slab.hvi"], cwd=folder, capture_output=True, text=True)
    check("inputs are kept", done.returncode == 1 and "E0609" in done.stderr, (done.returncode, done.stderr))


with tempfile.TemporaryDirectory() as place:
    FOLDER = pathlib.Path(place)
    with_units(*run(FOLDER, SCRIPT))
    without(*run(FOLDER, plain()))
    studies(FOLDER)
    stable(FOLDER)
    several(FOLDER)
    norms(FOLDER)
    same_names(FOLDER)
    overwritten(FOLDER)
print("units told:", "ok" if not failures else "\n".join(failures))
sys.exit(bool(failures))
