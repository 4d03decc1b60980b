"""tools/bench people: what waits for whom. Milliseconds (wall clock, medians) from a change in an editor to the messages about the whole
script, and of a hover and a completion, with clients that people use: Neovim's own, and the node library under VS Code's
(vscode-languageserver-protocol; `npm install` in tools/vscode brings it). Neovim's client collects changes for 150 ms before it sends
them; here it sends each at once, so that it is the server which is measured. A client that is not installed is said and left out.
"""
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
LIMITS = {1_000: (50, 20), 10_000: (300, 150)}  # lines: must, aim


def long_script(lines):
    """A right script of about so many lines about which there is nothing to say: every declaration is used."""
    out = ["mesh slab = rectangle(2, 1, cells = [4, 2])", "part roof = slab.top", "part ground = slab.bottom", "tensor A = isotropic(lambda = 5, mu = 10)"]
    terms, group = [], []
    for i in range(1, lines // 4):
        out += [f"# Quantity {i}", f'param p{i} = {i} in [0, 100000] "number {i}"', f"fn f{i}(a) = a*p{i} + sin(a)/(1 + a^2) - min(a, {i})",
                f"tensor T{i} = f{i}(0.5)^2 * A + isotropic(young = 70 + {i}, poisson = 0.3)"]
        group.append(f"T{i}")
        if len(group) == 40 or i == lines // 4 - 1:
            out.append(f"tensor S{i} = {' + '.join(group)}")
            terms.append(f"  + integral(slab, S{i} : eps(u) : eps(v))")
            group = []
    out += ["space V = vector P1 on slab, zero on roof", "find u in V for t in [0, 1] by 4 steps from u = 0", "such that for all v in V",
            "    integral(slab, A : eps(u') : eps(v))", *terms, " >= integral(slab, dot([0, -1], v)) + integral(ground, dot([0, 1], v))", "report",
            "  table a = u.y at [1, 0]"]
    return "\n".join(out) + "\n"


def place(text):
    """A name that is used in the middle of a script: line, column behind it; a wrong letter there makes one mistake."""
    lines = text.split("\n")
    middle = next(i for i in range(len(lines) // 2, len(lines)) if lines[i].startswith("fn f"))
    return middle, lines[middle].index("*p") + 2 + len(lines[middle].split("*p")[1].split(" ")[0])


def neovim(program, script, at, times, folder):
    out = folder / "neovim.json"
    words = ["nvim", "--headless", "--clean", "-c", f"luafile {HERE / 'bench_people.lua'}", str(script)]
    facts = {"HVI_RUN": str(program), "OUT": str(out), "LINE": str(at[0]), "COLUMN": str(at[1]), "TIMES": str(times), "HOME": str(folder),
             "XDG_STATE_HOME": str(folder)}
    done = subprocess.run(words, capture_output=True, text=True, timeout=300, cwd=folder, env={**os.environ, **facts})
    if not out.is_file():
        raise RuntimeError(done.stdout + done.stderr)
    return json.loads(out.read_text())


def node(program, script, at, times, folder):
    done = subprocess.run(["node", HERE / "bench_people.js", program, script, *map(str, (*at, times))], capture_output=True, text=True, timeout=300,
                          env={**os.environ, "NODE_PATH": os.pathsep.join([str(HERE / "vscode/node_modules"), os.environ.get("NODE_PATH", "")])})
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


def has_node():
    if not shutil.which("node"):
        return False
    found = subprocess.run(["node", "-e", "require('vscode-languageserver-protocol/node')"], capture_output=True,
                           env={**os.environ, "NODE_PATH": os.pathsep.join([str(HERE / "vscode/node_modules"), os.environ.get("NODE_PATH", "")])})
    return found.returncode == 0


def people(quick, row, program):
    rows, clients = [], []
    if shutil.which("nvim"):
        clients.append(("Neovim", neovim))
    else:
        print("no Neovim: its rows are left out (Debian: neovim)")
    if has_node():
        clients.append(("node", node))
    else:
        print("no vscode-languageserver-protocol for node: its rows are left out (npm install in tools/vscode)")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for lines, (must, aim) in LIMITS.items():
            script = folder / f"long{lines}.hvi"
            script.write_text(long_script(lines))
            for client, drive in clients:
                found = drive(program.resolve(), script, place(script.read_text()), 5 if quick else 25, folder)
                for what, values in found.items():
                    figure = statistics.median(values)
                    row(rows, f"{client}, {lines} lines: {what}", figure, must, aim, "ms", figure < must)
    return rows
