"""A client of the language server, over pipes, for the tests of what editors ask."""
import json
import pathlib
import subprocess


class Client:
    """Speaks JSON-RPC with the server."""

    def __init__(self, program, units="utf-16"):
        self.server = subprocess.Popen([program, "serve-editor"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.number, self.diagnostics, self.refreshed = 0, {}, 0
        self.versions = {}
        self.capabilities = self.ask("initialize", {"processId": None, "rootUri": None, "capabilities": {
            "general": {"positionEncodings": [units]}, "workspace": {"codeLens": {"refreshSupport": True}}}})["capabilities"]
        assert self.capabilities["positionEncoding"] == units
        self.tell("initialized", {})

    def write(self, message):
        content = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.server.stdin.write(b"Content-Length: %d\r\n\r\n" % len(content) + content)
        self.server.stdin.flush()

    def read(self):
        length = None
        while line := self.server.stdout.readline().strip():
            name, value = line.split(b":")
            if name == b"Content-Length":
                length = int(value)
        assert length is not None, "the server has ended"
        message = json.loads(self.server.stdout.read(length))
        if message.get("method") == "textDocument/publishDiagnostics":
            p = message["params"]
            self.diagnostics[p["uri"]] = (p.get("version"), p["diagnostics"])
        if message.get("method") == "workspace/codeLens/refresh":
            self.refreshed += 1
        return message

    def answer(self, method, params):
        self.number += 1
        self.write({"id": self.number, "method": method, "params": params})
        while (message := self.read()).get("id") != self.number or "method" in message:
            pass
        return message

    def ask(self, method, params):
        message = self.answer(method, params)
        assert "error" not in message, (method, message)
        return message["result"]

    def tell(self, method, params):
        self.write({"method": method, "params": params})

    def open(self, uri, text):
        self.versions[uri] = 1
        self.tell("textDocument/didOpen",
                  {"textDocument": {"uri": uri, "languageId": "hvi", "version": 1, "text": text}})

    def change(self, uri, edits):
        self.versions[uri] += 1
        self.tell("textDocument/didChange", {"textDocument": {"uri": uri, "version": self.versions[uri]},
                                             "contentChanges": edits})

    def found(self, uri):
        """The diagnostics of the text as it is now."""
        while self.diagnostics.get(uri, (None,))[0] != self.versions[uri]:
            self.read()
        return self.diagnostics[uri][1]

    def at(self, method, uri, position, **more):
        return self.ask(method, {"textDocument": {"uri": uri},
                                 "position": {"line": position[0], "character": position[1]}, **more})

    def end(self):
        assert self.ask("shutdown", None) is None
        self.tell("exit", None)
        assert self.server.wait(20) == 0


def uri_of(path):
    return pathlib.Path(path).resolve().as_uri()


def edited(text, edits):
    """A text after edits that do not overlap."""
    starts = [0]
    for line in text.split("\n"):
        starts.append(starts[-1] + len(line) + 1)
    at = lambda p: starts[p["line"]] + p["character"]
    for edit in sorted(edits, key=lambda e: at(e["range"]["start"]), reverse=True):
        text = text[:at(edit["range"]["start"])] + edit["newText"] + text[at(edit["range"]["end"]):]
    return text


def whole(text):
    """The range of a text."""
    return {"start": {"line": 0, "character": 0}, "end": {"line": text.count("\n") + 1, "character": 0}}
