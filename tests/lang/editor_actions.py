"""Quick fixes of the language server: for every help that says what to write there is one, and each one mends.

All wrong scripts of tests/lang/wrong and tests/lang/errors are opened. Their helps are sorted by kind (code and words); each kind that says what
to write has an action for one script at least, but for those named below with the reason why nothing can be written.

usage: editor_actions.py HVI_RUN"""
import json
import pathlib
import re
import shutil
import sys
import tempfile

from editor_client import Client, edited, uri_of, whole
from wrong import scripts

HERE = pathlib.Path(__file__).resolve().parent
SAYS = re.compile(r"did you mean|\b(write|add|use|take) `|is written|leave it out|^one of:|take P2|`import ")
# What to write depends on what is meant: the help shows an example, or a shape to be filled in.
OPEN = [("E0104", "0*x46"),  # a number in another base
        ("E0201", "an integral is written"), ("E0201", "is written `mesh"), ("E0201", "write `rectangle(...)`"), ("E0306", "write `sqrt(...)`"),
        ("E0306", "write `j^0"), ("E0307", "write `exact"), ("E0308", "use `norm(...)`"), ("E0308", "use `grad`"), ("E0308", "written with a prime"),
        ("E0308", "take `norm"), ("E0309", "a kernel of time"), ("E0330", "write temperatures"),  # the number is another one, too
        ("E0414", "write `u.nu`, `u.tau`"), ("E0415", "write `u.nu"), ("E0432", "write `u.nu`"), ("E0441", "write `jump(u)`"), ("E0447", "write two"),
        ("E0502", "write it as")]


def without_marks(text):
    return "\n".join(line for line in text.split("\n") if not re.match(r"#[< ]*\^+ [EW]\d", line))


def texts(folder):
    yield from scripts(folder)
    for path in sorted((HERE / "errors").glob("*.hvi")):
        yield path.stem, path.read_text()


def tried(client, uri, text):
    """Diagnostics with a help, and the action for each: [(code, help, title or None)]; each action is applied."""
    client.open(uri, text)
    before = client.found(uri)
    found = {}
    for action in client.ask("textDocument/codeAction", {"textDocument": {"uri": uri}, "range": whole(text), "context": {"diagnostics": []}}):
        [of] = action["diagnostics"]
        found.setdefault((of["code"], json.dumps(of["range"])), action["title"])
        client.change(uri, [{"text": edited(text, action["edit"]["changes"][uri])}])
        now = client.found(uri)
        count = lambda all_: sum(d["code"] == of["code"] for d in all_)
        assert count(now) < count(before) and len(now) <= len(before), (uri, action, now)
    client.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    helps = [(d, re.search(r"help: (.*)", d["message"])) for d in before]
    return [(d["code"], said[1], found.get((d["code"], json.dumps(d["range"])))) for d, said in helps if said]


def main():
    client, kinds, helps, mended = Client(sys.argv[1]), {}, 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        for path in list((HERE / "wrong").iterdir()) + list((HERE / "errors").iterdir()):
            if path.suffix in (".csv", ".msh", ".geo"):
                shutil.copy(path, temporary)
        for name, text in texts(HERE / "wrong"):
            for code, said, title in tried(client, uri_of(pathlib.Path(temporary, f"{name}.hvi")), without_marks(text)):
                if not SAYS.search(said) or any(code == c and part in said for c, part in OPEN):
                    continue
                helps, mended = helps + 1, mended + (title is not None)
                kind = kinds.setdefault((code, re.sub(r"`[^`]*`|\d[\d.]*", "_", said)), [said, name, None])
                kind[2] = kind[2] or title
    client.end()
    without = [f"{code}: {said} ({name})" for (code, _), (said, name, title) in kinds.items() if title is None]
    print(*without, sep="\n")
    print(f"{mended} of {helps} helps that say what to write have a quick fix; of {len(kinds)} kinds of them all but {len(without)}")
    sys.exit(bool(without))


main()
