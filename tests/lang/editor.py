"""The language server, driven by a client of its own: what an editor asks, over pipes.

Every example is opened, its diagnostics compared with those of `hvi-run check --script-only`, every name in it is followed to its declaration
and renamed there and back; wrong scripts of tests/lang/errors are mended by the actions that are offered; positions are checked in a script with
characters of one to four bytes; random edits (own seed) end in the same text and the same diagnostics as a file that is opened at once.

usage: editor.py HVI_RUN [--edits N]"""
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile

from editor_client import Client, edited, uri_of, whole

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
program = sys.argv[1]


def place_of(text, what, offset=0):
    """Line and character of the first time that `what` stands in a text; `|` in it is the place."""
    begin = text.index(what.replace("|", "")) + what.find("|") if "|" in what else text.index(what) + offset
    before = text[:begin]
    return before.count("\n"), len(before) - before.rfind("\n") - 1


def codes_by_command(path):
    out = subprocess.run([program, "check", "--script-only", "--diagnostics", "json", str(path)],
                         capture_output=True, text=True).stderr
    return sorted((d["code"], d["line"] - 1 if d["line"] else 0) for d in map(json.loads, out.split("\n")[:-1]))


def examples(client):
    """Diagnostics as the command has them; every declared name is found, and renamed there and back."""
    names = 0
    for path in sorted((ROOT / "examples").glob("*.hvi")):
        text, uri = path.read_text(), uri_of(path)
        client.open(uri, text)
        ours = sorted((d["code"], d["range"]["start"]["line"]) for d in client.found(uri))
        assert ours == codes_by_command(path), (path, ours)
        symbols = client.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})
        assert symbols, path
        for symbol in symbols:
            start = symbol["selectionRange"]["start"]
            place = start["line"], start["character"]
            here = client.at("textDocument/definition", uri, place)
            assert here["range"] == symbol["selectionRange"], (path, symbol, here)
            assert symbol["name"] in client.at("textDocument/hover", uri, place)["contents"]["value"]
            uses = client.at("textDocument/references", uri, place, context={"includeDeclaration": True})
            assert any(u["range"] == here["range"] for u in uses)
            edits = client.at("textDocument/rename", uri, place, newName="renamed_by_test")["changes"]
            assert len(edits[uri]) == sum(u["uri"] == uri for u in uses)
            names += 1
        # Renamed, a script means the same: no new mistakes, and renamed back it is what it was.
        start = symbols[0]["selectionRange"]["start"]
        place = start["line"], start["character"]
        renamed = edited(text, client.at("textDocument/rename", uri, place, newName="renamed_by_test")["changes"][uri])
        client.change(uri, [{"text": renamed}])
        assert not [d for d in client.found(uri) if d["severity"] == 1], (path, client.found(uri))
        back = client.at("textDocument/rename", uri, place, newName=symbols[0]["name"])["changes"][uri]
        assert edited(renamed, back) == text, path
        colours = client.ask("textDocument/semanticTokens/full", {"textDocument": {"uri": uri}})["data"]
        assert len(colours) % 5 == 0 and len(colours) > 100
        client.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    return names


SCRIPT = """# a slab
import friction
param n = 4 in [2, 64] "cells across"
mesh slab = rectangle(2, 1, cells = [2*n, n])
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)   # π ∈ \U0001d49e, steel
superpotential layer(r, k = 100) with slope
  | r < 0 -> 0
  | otherwise -> k*r
superpotential rub(xi) = tresca(xi, bound = 0.1)
space V = vector P1 on slab, zero on roof
find u in V such that for all v in V
    integral(slab, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu) + rub^0(u.tau; v.tau))
 >= integral(slab, dot([0, -10], v))
report
  table tip = u.y at [1, 0]
"""


def labels(client, uri, text, where):
    client.change(uri, [{"text": text}])
    return {item["label"] for item in client.at("textDocument/completion", uri, place_of(text, where))}


def completions(client, uri):
    base = SCRIPT
    with_line = lambda line: base + line + "\n"
    assert {"left", "right", "top", "bottom", "boundary"} <= labels(client, uri, base, "slab.|top")
    assert labels(client, uri, with_line("part p = slab.b"), "part p = slab.|b") >= {"bottom"}
    assert "xi" in labels(client, uri, with_line("report table f = integral(ground, layer.x)"), "layer.|x)")
    assert {"nu", "tau", "x"} <= labels(client, uri, base, "u.|nu;")
    assert {"contact", "friction", "states"} <= labels(client, uri, with_line("import c"), "import |c")
    assert labels(client, uri, base, "on |slab,") == {"slab", "roof", "ground"}
    assert labels(client, uri, base, "find u in |V") == {"V"}
    assert {"young", "poisson", "lambda"} <= labels(client, uri, with_line("tensor C = isotropic(y)"), "isotropic(|y)")
    assert {"bound"} <= labels(client, uri, base, "tresca(xi, |bound")
    assert {"k", "r", "layer", "exp"} <= labels(client, uri, base, "-> |k*r")
    assert "mesh" in labels(client, uri, base + "me", "\nme|")
    assert not labels(client, uri, base, "# a s|lab")
    assert "scheme" in labels(client, uri, base.replace("find u in V such", "find u in V using s = 1 such"), "using |s")
    # Where a statement is half written, its own arguments are offered.
    assert "stiff" in labels(client, uri, base + "fn g(stiff) = 2*s", "2*|s")


def hovers(client, uri):
    client.change(uri, [{"text": SCRIPT}])
    said = lambda where: client.at("textDocument/hover", uri, place_of(SCRIPT, where))["contents"]["value"]
    assert "the number 4" in said("param |n") and "cells across" in said("param |n")
    assert "fourth-order tensor" in said("integral(slab, |B")
    assert "left, right" in said("mesh |slab") or "bottom" in said("mesh |slab")
    assert "Tresca" in said("|tresca(xi")
    assert "plane strain" in said("|isotropic(")
    assert "inequality" in said("|find u")
    assert "an argument of `layer`" in said("-> |k*r")
    help_ = client.at("textDocument/signatureHelp", uri, place_of(SCRIPT, "poisson = |0.3"))
    label, active = help_["signatures"][0]["label"], help_["activeParameter"]
    begin, end = help_["signatures"][0]["parameters"][active]["label"]
    assert label.startswith("isotropic(") and "poisson" in label[begin:end], (label, active)
    assert client.at("textDocument/signatureHelp", uri, place_of(SCRIPT, "param |n")) is None


def renames(client, uri):
    client.change(uri, [{"text": SCRIPT}])
    refused = lambda where, name: client.answer("textDocument/rename", {
        "textDocument": {"uri": uri}, "newName": name,
        "position": dict(zip(("line", "character"), place_of(SCRIPT, where)))})["error"]["message"]
    assert "already" in refused("param |n", "roof")
    assert "word of the language" in refused("param |n", "mesh")
    assert "no name" in refused("param |n", "2n")
    assert "library" in refused("|tresca(xi", "mine")
    change = client.at("textDocument/rename", uri, place_of(SCRIPT, "-> |k*r"), newName="stiff")["changes"][uri]
    assert edited(SCRIPT, change) == SCRIPT.replace("k = 100", "stiff = 100").replace("k*r", "stiff*r")
    measured = (SCRIPT.replace("param n", "fn pull(s) = s*n\nparam order = P1\nparam n").replace("[0, -10]", "[0, -pull(3)]").replace("k = 100", "k = n")
                .replace("vector P1", "vector order")
                + "  table force = reaction(roof), n = u.x at [1, 0]\n  plot force_x, n against force_y\nexpect force_x = 0 within 1\nexpect n = 0 within 1\n")
    client.change(uri, [{"text": measured}])
    rename = lambda where, name: edited(measured, client.at("textDocument/rename", uri, place_of(measured, where), newName=name)["changes"][uri])
    not_renamed = lambda where, name: client.answer("textDocument/rename", {
        "textDocument": {"uri": uri}, "newName": name, "position": dict(zip(("line", "character"), place_of(measured, where)))})["error"]["message"]
    # What has the name in a function or a law, where the renamed one is used, would be meant there.
    assert "argument of `pull`" in not_renamed("param |n", "s")
    assert "argument of `layer`" in not_renamed("param |n", "r") and "argument of `layer`" in not_renamed("param |n", "k")
    assert "already" in not_renamed("fn pull(|s)", "n")
    assert "something else" in not_renamed("param |n", "P1")
    assert rename("vector |order", "degree") == measured.replace("order", "degree")
    # Components of columns go with them; a column is not the parameter of its name.
    assert rename("table |force", "pulled") == measured.replace("force", "pulled")
    assert rename("expect |force_x", "pulled") == measured.replace("force", "pulled")
    assert rename("expect |n =", "gap") == measured.replace(", n = u.x", ", gap = u.x").replace("force_x, n", "force_x, gap").replace("expect n", "expect gap")
    assert rename("param |n", "cells") == (measured.replace("s*n", "s*cells").replace("param n", "param cells").replace("k = n", "k = cells")
                                           .replace("[2*n, n]", "[2*cells, cells]"))
    client.change(uri, [{"text": SCRIPT}])
    # A place behind characters of two, three and four bytes: UTF-16 counts one, one and two.
    library = client.at("textDocument/definition", uri, place_of(SCRIPT, "|tresca(xi"))
    assert library is None or library["uri"].endswith("stdlib/friction.hvi")


MEASURED = """units mm, N, s
import contact
param E = 70 [GPa] in [10, 300] [GPa]
mesh slab = rectangle(2 [cm], 10 [mm], cells = [4, 2])
part left = slab.left
part ground = slab.bottom
tensor B = isotropic(young = E, poisson = 0.3)
kernel C(lag) = -0.25/(3 [s])*exp(-lag/(3 [s]))*B
fn grow(time) = time/(10 [s])
superpotential layer(r, k = 100 [MPa/mm]) = normal_compliance(r, stiffness = k, power = 1)
state wear on ground with rate 1e-3 [mm/s] from wear = 0 [mm]
space V = vector P1 on slab, zero on left
find u in V for t in [0, 10] [s] by 4 steps from u = 0
such that for all v in V
    integral(slab, B : eps(u) : eps(v)) + integral(slab, history(C, eps(u)) : eps(v)) + integral(ground, layer^0(u.nu; v.nu))
 >= integral(slab, dot([0, -78.5 [kN/m^3]*grow(t)*x/(1 [mm])], v))
report
  table tip = u.y at [20, 10] [mm], s = sigma.yy at [10, 5] [mm], most = largest(slab, mises(sigma)), w = integral(ground, wear)
"""


def measured(client):
    """What a script with units declares is told with its unit, as `hvi-run params` and `dump --units` tell it."""
    uri, text = uri_of(ROOT / "examples/none_measured.hvi"), MEASURED
    client.open(uri, text)
    assert not client.found(uri), client.found(uri)
    whole_of = lambda where: client.at("textDocument/hover", uri, place_of(text, where))["contents"]["value"].split("```")[-1].strip()
    law = "a superpotential of an argument in [mm] with its multiplier in [MPa]\n\nunits: `layer(r [r], k [p/r]) [p]`"
    library = "units: `normal_compliance(r [r], stiffness [p/r], power [1]) [p]`"
    for where, said in (("param |E", "the number 70000 in units of mm, N, s: 70 [GPa]"), ("mesh |slab", "a mesh with lengths in [mm]; its parts: bottom, left, right, top"),
                        ("tensor |B", "a fourth-order tensor [MPa]"), ("kernel |C", "a kernel with values in [MPa/s]"), ("C(|lag)", "an argument of `C` [s]"),
                        ("fn |grow", "a function\n\nunits: `grow(time [time]) [time/s]`"), ("grow(|time)", "an argument of `grow` [time]"),
                        ("superpotential |layer", law), ("layer(|r", "an argument of `layer` [mm]"), ("layer(r, |k", "an argument of `layer` [p/r]"),
                        ("= |normal_compliance", library), ("state |wear", "a scalar [mm]"), ("find |u in", "unknown [mm]"),
                        ("table |tip", "column of the table [mm]"), ("|most =", "column of the table [MPa]"), ("= |sigma.yy", "[MPa]"), ("grow(|t)*x", "the time [s]"),
                        ("*|x/", "[mm]")):
        found = whole_of(where)
        assert found == said or said in found and said in ("[MPa]", "[mm]", library), (where, found)
    help_ = client.at("textDocument/signatureHelp", uri, place_of(text, "compliance(r|, stiff"))
    assert "stiffness [p/r]" in help_["signatures"][0]["documentation"]["value"], help_
    # Nothing of it in a script without units.
    client.change(uri, [{"text": SCRIPT}])
    assert "units" not in client.at("textDocument/hover", uri, place_of(SCRIPT, "superpotential |layer"))["contents"]["value"]


def units():
    """The same place in both ways to count."""
    text = SCRIPT.replace("# π ∈ \U0001d49e, steel", "").replace(
        'param n = 4 in [2, 64] "cells across"', 'param n = 4 in [2, 64] "\U0001d49e∈π"  param m = n')
    for name, length in (("utf-16", lambda s: len(s.encode("utf-16-le")) // 2), ("utf-8", lambda s: len(s.encode()))):
        client = Client(program, name)
        uri = uri_of(ROOT / "examples/none.hvi")
        client.open(uri, text)
        line = text.split("\n")[2]
        place = 2, length(line[:line.index("= n") + 2])
        target = client.at("textDocument/definition", uri, place)["range"]
        assert target["start"] == {"line": 2, "character": 6}, (name, target)
        uses = client.at("textDocument/references", uri, place, context={"includeDeclaration": False})
        assert {"line": 2, "character": place[1]} in [u["range"]["start"] for u in uses], (name, uses)
        client.end()


def actions(client):
    """What is offered mends slips made on purpose (the wrong scripts: editor_actions.py)."""
    slips = [("isotropic(young", "isotropc(young"), ("slab.top", "slab.tp"), ("layer^0(u.nu", "layr^0(u.nu"),
             (">= integral", "= integral"), ("zero on roof", "zero on rof"), ("poisson = 0.3", "poison = 0.3"), ("import friction", "import fricton")]
    texts = [SCRIPT.replace(a, b, 1) for a, b in slips] + [SCRIPT + "param unused = 3\n"]
    rate = (ROOT / "examples/block_on_table.hvi").read_text()  # the direction of a law on the rate has no prime
    texts.append(rate.replace("slip^0(u'.tau; v.tau)", "slip^0(u'.tau; v)"))
    assert texts[-1] != rate
    for i, text in enumerate(texts):
        uri = uri_of(ROOT / f"tests/lang/errors/action_{i}.hvi")
        client.open(uri, text)
        assert client.found(uri)
        [action] = client.ask("textDocument/codeAction", {"textDocument": {"uri": uri}, "range": whole(text), "context": {"diagnostics": []}})
        client.change(uri, [{"text": edited(text, action["edit"]["changes"][uri])}])
        assert not client.found(uri), (i, action)
        client.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    for sign in (")", "]", "+", "|", ","):  # the last letter of the text, which no line end follows
        uri, text = uri_of(ROOT / "examples/cut_off.hvi"), "find r t" + sign
        client.open(uri, text)
        client.ask("textDocument/codeAction", {"textDocument": {"uri": uri}, "range": whole(text), "context": {"diagnostics": []}})
        client.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    return len(texts)


def random_edits(client, n, seed):
    """Random edits, many of them nonsense: the text the server has is that of a client that applies them, and it goes on answering."""
    rng = random.Random(seed)
    pieces = ["(", ")", "^0(", "mesh ", "\n", "u.nu", "'", "|", "->", "\"", "#", "param q = ", "1e999", "\U0001d49e", "é", "[", "]", "\r\n", "\0", "find ", " "]
    requests = ["hover", "completion", "signatureHelp", "definition", "documentHighlight"]
    uri, text = uri_of(ROOT / "examples/edited.hvi"), SCRIPT
    client.open(uri, text)
    for i in range(n):
        lines = text.split("\n")
        line = rng.randrange(len(lines))
        a, b = sorted(rng.randrange(len(lines[line]) + 1) for _ in range(2))
        if lines[line].endswith("\r"):
            a, b = min(a, len(lines[line]) - 1), min(b, len(lines[line]) - 1)
        new = rng.choice(pieces) if rng.random() < 0.8 else "".join(rng.choices(SCRIPT, k=rng.randrange(40)))
        width = lambda s: len(s.encode("utf-16-le")) // 2
        edit = {"range": {"start": {"line": line, "character": width(lines[line][:a])},
                          "end": {"line": line, "character": width(lines[line][:b])}}, "text": new}
        lines[line] = lines[line][:a] + new + lines[line][b:]
        text = "\n".join(lines)
        client.change(uri, [edit])
        method = rng.choice(requests)
        client.answer(f"textDocument/{method}", {"textDocument": {"uri": uri}, "position": {"line": rng.randrange(len(lines) + 2),
                                                                                            "character": rng.randrange(90)}})
        client.answer("textDocument/codeAction", {"textDocument": {"uri": uri}, "range": whole(text), "context": {"diagnostics": []}})
        if i % 20 == 0:
            text = SCRIPT
            client.change(uri, [{"text": text}])
        if i % 20 == 19:
            copy = uri_of(ROOT / "examples/copied.hvi")
            client.open(copy, text)
            strip = lambda all_: [(d["code"], d["range"]) for d in all_]
            assert strip(client.found(uri)) == strip(client.found(copy)), (i, text)
            client.tell("textDocument/didClose", {"textDocument": {"uri": copy}})


def mesh_files(client):
    """Groups of a mesh file and the files themselves are offered."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(ROOT / "tests/lang/wrong/groups.msh", folder)
        pathlib.Path(folder, "table.csv").write_text("0,0\n1,1\n")
        path = pathlib.Path(folder, "own.hvi")
        text = 'mesh m = gmsh("groups.msh")\npart ground = m.group("")\npart side = m.ground\n'
        path.write_text(text)
        uri = uri_of(path)
        client.open(uri, text)
        assert "ground" in labels(client, uri, text, 'm.group("|")')
        assert "ground" in labels(client, uri, text, "= m.|ground")
        assert labels(client, uri, text, 'gmsh("|groups') == {"groups.msh"}
        assert labels(client, uri, text + 'fn f(s) = table("", s)', 'table("|"') == {"table.csv"}


def uses(client, uri):
    """Places of a name: with and without its declaration, in this file alone where an editor marks them."""
    client.change(uri, [{"text": SCRIPT}])
    places = lambda method, **more: [(u.get("uri", uri), u["range"]["start"]["line"]) for u in client.at(method, uri, place_of(SCRIPT, "part |roof"), **more)]
    assert places("textDocument/references", context={"includeDeclaration": True}) == [(uri, 4), (uri, 11)]
    assert places("textDocument/references", context={"includeDeclaration": False}) == [(uri, 11)]
    marked = client.at("textDocument/documentHighlight", uri, place_of(SCRIPT, "|tresca(xi"))
    assert [m["range"]["start"]["line"] for m in marked] == [10], marked  # not where the library declares it
    symbols = {s["name"]: s["kind"] for s in client.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})}
    assert (symbols["n"], symbols["slab"], symbols["roof"], symbols["layer"], symbols["B"]) == (14, 5, 3, 12, 13), symbols
    legend = client.capabilities["semanticTokensProvider"]["legend"]["tokenTypes"]
    data, line, at, painted = client.ask("textDocument/semanticTokens/full", {"textDocument": {"uri": uri}})["data"], 0, 0, {}
    for down, along, length, kind, _ in zip(*[iter(data)] * 5):
        line, at = line + down, along if down else at + along
        painted[line, at] = legend[kind]
    kinds = {"superpotential |layer": "function", "|mesh slab": "keyword", "mesh |slab": "type", "layer(|r": "parameter", "slab.|top": "property", "u.|nu": "property",
             "= |4 in": "number", "|# a slab": "comment", "|isotropic": "function", '|"cells': "string"}
    for where, kind in kinds.items():
        assert painted[place_of(SCRIPT, where)] == kind, (where, painted.get(place_of(SCRIPT, where)))
    nested = SCRIPT + "fn both(a) = isotropic(young = 2*max(a, 3), poisson = 0.3)\ntensor D = voigt([[3, 1, 0], [1, 3, 0], [0, 0, 1]])\npart p = point(slab, [0, 0])\n"
    client.change(uri, [{"text": nested}])
    help_ = client.at("textDocument/signatureHelp", uri, place_of(nested, "point(slab, [0|, 0]"))
    label, parameters = help_["signatures"][0]["label"], help_["signatures"][0]["parameters"]
    assert [label[b:e] for b, e in (p["label"] for p in parameters)] == ["mesh", "[x, y]"], (label, parameters)


def closed(client):
    """A script that is closed has no messages any more."""
    uri = uri_of(ROOT / "examples/closed.hvi")
    client.open(uri, "param n = \n")
    assert client.found(uri)
    client.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    while client.diagnostics[uri][1]:
        client.read()
    client.diagnostics.pop(uri)


def wrong_messages(client):
    assert client.answer("textDocument/hover", {})["error"]["code"] == -32602
    assert client.answer("no/such", {})["error"]["code"] == -32601
    assert client.answer("textDocument/hover", {"textDocument": {"uri": "file:///nowhere.hvi"},
                                                "position": {"line": 0, "character": 0}})["error"]["code"] == -32602
    client.tell("no/such", {})
    client.tell("textDocument/didChange", {"textDocument": {"uri": "file:///nowhere.hvi"}, "contentChanges": [{"text": ""}]})
    client.tell("textDocument/didOpen", {"textDocument": {}})
    early = subprocess.run([program, "serve-editor"], input=b'Content-Length: 54\r\n\r\n{"jsonrpc":"2.0","id":1,"method":"textDocument/hover"}',
                           capture_output=True, timeout=60)
    assert b"-32002" in early.stdout and early.returncode == 1
    for broken in (b"", b"Content-Length: 5\r\n\r\n{", b"Content-Length: x\r\n\r\n", b"Content-Length: 99999999999\r\n\r\n", b"\0" * 9000):
        out = subprocess.run([program, "serve-editor"], input=broken, capture_output=True, timeout=60)
        assert out.returncode == 1 and not out.stdout, (broken[:40], out)


def lenses(client):
    """The numbers of `check` stand above the inequality once they are found."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "small slab.hvi")
        path.write_text(SCRIPT)
        uri = uri_of(path)
        client.open(uri, SCRIPT)
        # A refresh does not say of which document: one that was opened before may have been judged only now.
        found = []
        while not found:
            before = client.refreshed
            found = client.ask("textDocument/codeLens", {"textDocument": {"uri": uri}})
            while not found and client.refreshed == before:
                client.read()
        [lens] = found
        client.change(uri, [{"text": SCRIPT.replace("n = 4 in", "n = 5 in")}])
        client.tell("textDocument/didSave", {"textDocument": {"uri": uri}})
        while not (again := client.ask("textDocument/codeLens", {"textDocument": {"uri": uri}})) or again == found:
            client.read()
        assert again[0]["command"]["title"].startswith("132 values"), again
        assert lens["range"]["start"]["line"] == 12 and re.search(r"step margin 1, predicted \S+ s and \S+ MB: .*one solution", lens["command"]["title"]), lens


def main():
    os.chdir(ROOT)
    client = Client(program)
    names = examples(client)
    uri = uri_of(ROOT / "examples/none.hvi")
    client.open(uri, SCRIPT)
    assert not client.found(uri), client.found(uri)
    completions(client, uri)
    hovers(client, uri)
    measured(client)
    renames(client, uri)
    uses(client, uri)
    mesh_files(client)
    closed(client)
    wrong_messages(client)
    lenses(client)
    offered = actions(client)
    formatted = client.ask("textDocument/formatting", {"textDocument": {"uri": uri}, "options": {"tabSize": 2, "insertSpaces": True}})
    assert len(formatted) <= 1
    edits = int(sys.argv[sys.argv.index("--edits") + 1]) if "--edits" in sys.argv else 200
    random_edits(client, edits, 24)
    client.end()
    units()
    print(f"{names} names followed and renamed, {offered} actions that mend, {edits} random edits")


main()
