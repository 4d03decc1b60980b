"""The language server says of a script what `check` says: the same codes at the same places, those of the mesh and of the first step too.

usage: editor_check.py HVI_RUN [--part K/N]
Scripts: tests/lang/errors and every N-th of tests/lang/wrong, from the K-th on. Each is opened, and its messages are read when the server
has judged it. Then one is changed while the editor has it open: what is said behind the plan goes and comes with it.
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

from editor_client import Client, uri_of
from wrong import scripts

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = sys.argv[1]
FIRST, STEP = map(int, (sys.argv[sys.argv.index("--part") + 1] if "--part" in sys.argv else "1/1").split("/"))
SLAB = """mesh slab = rectangle(2, 1, cells = [4, 2])
part roof = slab.top
tensor B = isotropic(young = 70, poisson = 0.3)
space V = vector P1 on slab, zero.x on roof
find u in V
such that for all v in V
    integral(slab, B : eps(u) : eps(v))
  = integral(slab, dot([0, -1], v))
report
  table a = u.y at [1, 0]
"""


def by_command(path):
    """Code, line and columns of each message, from 0."""
    done = subprocess.run([PROGRAM, "check", "--quiet", "--diagnostics", "json", str(path)], capture_output=True, text=True)
    rows = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
    return sorted((r["code"], r["severity"], max(r["line"] - 1, 0), max(r["column"] - 1, 0), max(r["end_column"] - 1, 0)) for r in rows)


def by_editor(client, path):
    text = path.read_text()
    before = client.refreshed
    client.open(uri_of(path), text)
    while client.refreshed == before:
        client.read()
    return shown(client, uri_of(path))


def shown(client, uri):
    severity = {1: "error", 2: "warning", 3: "note"}
    return sorted((d["code"], severity[d["severity"]], d["range"]["start"]["line"], d["range"]["start"]["character"],
                   d["range"]["end"]["character"]) for d in client.found(uri))


def close(client, path):
    client.tell("textDocument/didClose", {"textDocument": {"uri": uri_of(path)}})


def wait(client, uri, codes):
    while [d["code"] for d in client.found(uri)] != codes:
        client.read()


def edited(client, folder):
    """A body that moves along y: said when the script is judged, not while it is changed, again when it is saved."""
    path = folder / "slab.hvi"
    path.write_text(SLAB)
    uri = uri_of(path)
    assert [row[0] for row in by_command(path)] == ["E0425"], by_command(path)
    client.open(uri, SLAB)
    wait(client, uri, ["E0425"])
    client.change(uri, [{"text": SLAB.replace("young = 70", "young = 71")}])
    assert client.found(uri) == [], client.found(uri)
    client.tell("textDocument/didSave", {"textDocument": {"uri": uri}})
    wait(client, uri, ["E0425"])
    client.change(uri, [{"text": SLAB.replace("zero.x", "zero")}])
    assert client.found(uri) == [], client.found(uri)
    # Another script that is opened meanwhile comes first; the one before it is judged all the same.
    client.change(uri, [{"text": SLAB}])
    other = folder / "other.hvi"
    client.tell("textDocument/didSave", {"textDocument": {"uri": uri}})
    client.open(uri_of(other), SLAB)
    wait(client, uri_of(other), ["E0425"])
    wait(client, uri, ["E0425"])


def main():
    client = Client(PROGRAM)
    failures, compared, behind = [], 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for source in (HERE / "errors", HERE / "wrong"):
            for path in source.iterdir():
                if path.suffix in (".csv", ".msh", ".geo"):
                    shutil.copy(path, folder)
        texts = [(path.name, path.read_text()) for path in sorted((HERE / "errors").glob("*.hvi"))]
        texts += [(f"{name}.hvi", text) for i, (name, text) in enumerate(scripts(HERE / "wrong")) if (i + 1 - FIRST) % STEP == 0]
        for name, text in texts:
            path = folder / name
            path.write_text(text)
            ours, theirs = by_editor(client, path), by_command(path)
            close(client, path)
            compared += 1
            only_script = subprocess.run([PROGRAM, "check", "--script-only", path], capture_output=True, text=True)
            behind += only_script.returncode == 0 and any(row[1] == "error" for row in theirs)
            if ours != theirs:
                failures.append(f"{name}: the editor says {ours}, check {theirs}")
        edited(client, folder)
    client.end()
    assert compared >= 60 and behind >= 5, (compared, behind)
    print(*failures, sep="\n")
    print(f"{compared - len(failures)} of {compared} scripts have the messages of `check` in an editor; {behind} of them have mistakes behind the plan")
    sys.exit(bool(failures))


main()
