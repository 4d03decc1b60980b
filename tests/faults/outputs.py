"""Nothing lost, and nothing of others touched: full disks and closed pipes, pictures that cannot be drawn, killed runs, folders that
are in use, outputs in the place of inputs, modes and links of files.  usage: outputs.py HVI_RUN [CASE...]"""
import fcntl
import html
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

SCRIPT = """param n = 4
param N = 8
mesh slab = rectangle(2, 1, cells = [2*n, n])
part roof = slab.top
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
kernel C(t, s) = -exp(-(t - s)/0.5) * B
superpotential layer(r) = 50*max(r, 0)^2
space V = vector P1 on slab, zero on roof
find u in V for t in [0, 1] by N steps from u = 0
such that for all v in V
    integral(slab, B : eps(u') : eps(v)) + integral(slab, B : eps(u) : eps(v))
  + integral(slab, history(C, eps(u)) : eps(v))
  + integral(ground, layer^0(u.nu; v.nu))
 >= integral(slab, dot([0, -{load}], v))
report
  table a = u.y at [1, 0], b = u.x at [2, 0]
{more}"""
FIELDS = "  fields u every 2 steps\n"
STUDY = "study vary N in [0, 2, 4] and n in [1, 2] against finest in V\n"
cases, problems, checks = [], [], 0


def case(function):
    cases.append(function)
    return function


def check(what, holds, about=""):
    global checks
    checks += 1
    if not holds:
        problems.append(what)
        print(f"WRONG {what}: {about}")


class Place:
    """A folder with a script in it."""

    def __init__(self, program, folder):
        self.program, self.folder = program, pathlib.Path(folder)
        self.write()

    def write(self, name="s.hvi", load="t", more=""):
        (self.folder / name).write_text(SCRIPT.replace("{load}", load).replace("{more}", more))

    def command(self, *words, name="s.hvi"):
        return [str(self.program), "run", name, *map(str, words)]

    def call(self, *words, limit=None, shell="", **more):
        """A run, or any command when the first word is one; `shell`: what a shell appends to it."""
        line = [str(self.program), *map(str, words)] if words and words[0] in COMMANDS else self.command(*words)
        if shell:
            line = ["/bin/bash", "-c", '"$@" ' + shell, "bash", *line]
        if limit is not None:
            more["preexec_fn"] = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        return subprocess.run(line, cwd=self.folder, capture_output=True, text=True, timeout=300, **more)

    def begin(self, *words):
        return subprocess.Popen(self.command(*words), cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def text(self, name):
        path = self.folder / name
        return path.read_text() if path.exists() else ""

    def names(self, folder="."):
        return sorted(p.name for p in (self.folder / folder).iterdir()) if (self.folder / folder).exists() else []


COMMANDS = ("run", "check", "plan", "study", "stability", "test", "fmt", "params", "mesh", "dump", "explain", "--help", "--version")
LONG = ("-D", "N=200000", "-D", "n=2")


def wait_for(holds, seconds=60):
    end = time.time() + seconds
    while not (good := holds()) and time.time() < end:
        time.sleep(0.02)
    return good


def rows(text):
    return text.splitlines()[1:]


@case
def killed(place):
    """A run that is killed leaves the rows it had: whole ones, those of the run that is not killed."""
    with place.begin("-o", "out", *LONG) as run:
        check("killed: a table while the run goes on", wait_for(lambda: len(rows(place.text("out/s.csv"))) > 200))
        run.kill()
    left = place.text("out/s.csv")
    check("killed: its last line is whole", left.endswith("\n") and len({line.count(",") for line in left.splitlines()}) == 1, left[-200:])
    whole = place.call("-o", "whole", *LONG)
    check("killed: rows reach the file in more than one go, none twice", left.count("\nt,") == 0 and len(set(rows(left))) == len(rows(left)))
    check("killed: the rows of the whole run", whole.returncode == 0 and place.text("whole/s.csv").startswith(left), left[:300])
    parts = [n for n in place.names("out") if n.endswith(".hvi-part")]
    done = place.call("-o", "out", "-D", "N=4")
    check("killed: the next run removes what was left", done.returncode == 0 and place.names("out") == ["s.csv"], (parts, place.names("out")))


@case
def leftovers(place):
    """Temporary files go when their writers are dead, and no other."""
    out = place.folder / "out"
    out.mkdir()
    for name in (".s.csv.abcdefgh.hvi-part", ".x.vtu.aaaaaaaa.hvi-part", ".living.csv.bbbbbbbb.hvi-part", "mine.hvi-part", "s.csv.backup"):
        (out / name).write_text("half")
    with open(out / ".living.csv.bbbbbbbb.hvi-part") as living:
        fcntl.flock(living, fcntl.LOCK_EX)
        done = place.call("-o", "out")
        check("leftovers: dead ones go", done.returncode == 0 and place.names("out") == [".living.csv.bbbbbbbb.hvi-part", "mine.hvi-part", "s.csv",
                                                                                         "s.csv.backup"], place.names("out"))


@case
def nothing_draws(place):
    """Pictures come last: what else there is is not lost, and only one that was asked for by name is an error."""
    nowhere, no_cairo = dict(os.environ, PATH="/nowhere"), dict(os.environ, HVI_DRAW_MODULE="/nowhere/libhvi_draw.so")
    place.write(more="  picture u\n")
    done = place.call("-o", "out", "--json", "r.json", env=no_cairo)
    check("no cairo: a warning", done.returncode == 0 and "W0601" in done.stderr and "/nowhere/libhvi_draw.so" in done.stderr,
          (done.returncode, done.stderr))
    check("no cairo: table, JSON, printed result", place.text("out/s.csv") and json.loads(place.text("r.json"))["files"] == ["s.csv"]
          and "certified" in done.stdout, done.stdout)
    place.write(more='  picture u to "named.png"\n  picture u\n')
    done = place.call("-o", "named", "--json", "n.json", env=no_cairo)
    check("no cairo: by name it is exit 3", done.returncode == 3 and "E0702" in done.stderr and "W0601" in done.stderr, done.stderr)
    check("no cairo: and nothing is lost", place.text("named/s.csv") and place.text("n.json") and "certified" in done.stdout)
    done = place.call("-o", "drawn", "--json", "d.json")
    check("cairo: drawn, and in the JSON", done.returncode == 0 and "named.png" in json.loads(place.text("d.json"))["files"]
          and (place.folder / "drawn/named.png").read_bytes().startswith(b"\x89PNG"), done.stderr)
    place.write(more='  picture u to "u.svg"\n')
    done = place.call("-o", "svg", env=no_cairo)
    check("no cairo: SVG is drawn", done.returncode == 0 and not done.stderr and "</svg>" in place.text("svg/u.svg"), done.stderr)
    place.write()
    done = place.call("stability", "s.hvi", "-o", "st", "--json", "st.json", env=nowhere)
    check("no gnuplot: stability", done.returncode == 0 and "W0601" in done.stderr and "verdict" in done.stdout and place.text("st.json"), done.stderr)
    done = place.call("stability", "s.hvi", "-o", "st2", env=dict(os.environ, TMPDIR="/nowhere"))
    check("no folder for temporary files: a warning", done.returncode == 0 and "W0601" in done.stderr, (done.returncode, done.stderr))
    place.write(more=STUDY.replace("[0, 2, 4]", "[2, 4]"))
    done = place.call("study", "s.hvi", "-o", "sy", "--json", "sy.json", env=nowhere)
    check("no gnuplot: study", done.returncode == 0 and "W0601" in done.stderr and "errors against" in done.stdout and place.text("sy/study.csv")
          and place.text("sy.json"), done.stderr)


@case
def texts_of_pictures(place):
    """Bodies of all shapes: no text of the picture lies on another one."""
    for sides in ("2, 1", "20, 1", "1, 20", "1e-6, 2e-6", "3e5, 1e5"):
        place.write(more='  picture u to "u.svg"\n')
        script = place.folder / "s.hvi"
        script.write_text(script.read_text().replace("rectangle(2, 1", f"rectangle({sides}").replace("[1, 0]", "[0, 0]").replace("[2, 0]", "[0, 0]"))
        done = place.call("-o", "out")
        boxes = []
        for x, y, size, anchor, turned, text in re.findall(
                r'<text x="(\S+)" y="(\S+)" font-size="(\S+)" text-anchor="(\w+)" fill="\S+?"( transform="[^"]*")?>(.*?)</text>', place.text("out/u.svg")):
            wide = 0.6 * float(size) * len(html.unescape(text))
            left = float(x) - {"start": 0, "middle": wide / 2, "end": wide}[anchor]
            if not turned:
                boxes.append((left, left + wide, float(y) - 0.75 * float(size), float(y), text))
        on = [(a[4], b[4]) for i, a in enumerate(boxes) for b in boxes[:i] if a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]]
        check(f"texts of a picture of a body of sides {sides}", done.returncode == 0 and len(boxes) > 6 and not on, (done.stderr, on))


@case
def ladder_with_zero(place):
    """A rung that a logarithmic axis does not show."""
    place.write(load="(t + N)", more=STUDY.replace("vary N in [0, 2, 4] and n", "vary shift in [0, 1, 2] and n"))
    text = place.text("s.hvi").replace("param N = 8", "param N = 8\nparam shift = 0").replace("(t + N)", "(t + 2 + shift)")
    (place.folder / "s.hvi").write_text(text)
    done = place.call("study", "s.hvi", "-o", "out", "--json", "r.json")
    check("a ladder with 0: the study is done and drawn", done.returncode == 0 and "W0601" not in done.stderr and place.text("r.json")
          and {"cost.svg", "order_n.png", "order_shift.png", "study.csv"} <= set(place.names("out")), (done.returncode, done.stderr, place.names("out")))


@case
def study_without_results(place):
    """Values that are all mistakes of the script: the table lists them, and the exit code says that there is nothing else."""
    place.write(more="param m = 1 in [1, 2]\nstudy vary m in [2, 3]\n")
    done = place.call("study", "s.hvi", "-o", "out")
    check("a study with one result is one", done.returncode == 0 and "failed: m = 3" in done.stdout, (done.returncode, done.stderr))
    place.write(more="param m = 1 in [1, 2]\nstudy vary m in [3, 4]\n")
    done = place.call("study", "s.hvi", "-o", "out")
    check("a study without a result: exit 3", done.returncode == 3 and "failed: m = 4" in done.stdout and "no setting" in done.stderr,
          (done.returncode, done.stderr))


@case
def no_room(place):
    """A disk that fills up when the solve is done: exit 3, everything that fits is there, nothing is half."""
    place.write(more=FIELDS)
    good = place.call("-o", "good", "-D", "N=300", "-D", "n=8")
    size = (place.folder / "good/s.csv").stat().st_size
    done = place.call("-o", "out", "--json", "r.json", "-D", "N=300", "-D", "n=8", limit=size - 1)
    check("no room: exit 3 and E0702", done.returncode == 3 and "E0702" in done.stderr and "s.csv" in done.stderr, (done.returncode, done.stderr))
    check("no room: the result is printed", done.stdout.splitlines()[:40] == good.stdout.splitlines()[:40], done.stdout[:500])
    for name in place.names("out"):
        found, whole = (place.folder.joinpath(folder, name).read_bytes() for folder in ("out", "good"))
        streamed = name == "s.csv" and found.endswith(b"\n") and whole.startswith(found)  # what there was after a second
        check(f"no room: {name} is whole", found == whole or streamed)
    check("no room: fields that fit are there", "s_00002.vtu" in place.names("out"), place.names("out"))
    done = place.call("-o", "none", "-D", "N=300", limit=0)
    check("no room from the start: nothing is computed", done.returncode == 3 and done.stdout == "" and place.names("none") == [], done.stderr)


@case
def not_to_be_written(place):
    """The folder is tried before the first step; devices, pipes and folders above are refused."""
    (place.folder / "file").write_text("")
    (place.folder / "out").mkdir()
    (place.folder / "out/s.csv").mkdir()
    os.mkfifo(place.folder / "pipe")
    os.mkfifo(place.folder / "pipe.csv")
    (place.folder / "special").mkdir()
    os.mkfifo(place.folder / "special/s.csv")
    for words, code, exit_ in ((("-o", "file"), "E0702", 3), (("-o", "file/below"), "E0702", 3), (("-o", "/proc/below"), "E0702", 3),
                               (("-o", "out"), "E0702", 3), (("-o", "special"), "E0702", 3), (("--json", "pipe", "--no-files"), "E0702", 3),
                               (("--json", "/dev/null", "--no-files"), "E0702", 3), (("--json", "/proc/x/r.json",), "E0702", 3),
                               (("-o", ".."), "E0604", 1), (("-o", "a/.."), "E0604", 1), (("-o", "pipe"), "E0702", 3)):
        done = place.call(*words, "-D", "N=100000")
        check(f"{' '.join(words)}: {code} before the first step", done.returncode == exit_ and code in done.stderr and done.stdout == "",
              (done.returncode, done.stderr, done.stdout[:200]))
    for command in ("study", "stability", "check"):
        place.write(more=STUDY.replace("[0, 2, 4]", "[2, 4]"))
        done = place.call(command, "s.hvi", "--json", "/proc/x/r.json")
        check(f"{command} --json: E0702", done.returncode == 3 and "E0702" in done.stderr and done.stdout == "", (done.returncode, done.stderr))
    for name in ("...hvi", "..hvi"):
        place.write(name)
        done = subprocess.run(place.command(name=name), cwd=place.folder, capture_output=True, text=True)
        check(f"{name}: no folder of that name", done.returncode == 1 and "E0604" in done.stderr, (done.returncode, done.stderr))


@case
def standard_output(place):
    """What cannot be printed is exit 3, in every command; the files are there all the same."""
    place.write(more=STUDY.replace("[0, 2, 4]", "[2, 4]") + "expect a = 0 within 10\n")
    shutil.copy(pathlib.Path(__file__).parents[1] / "data/plate_41_ascii.msh", place.folder / "plate.msh")
    place.write("ugly.hvi", more="\n\n\n")
    (place.folder / "ugly.hvi").write_text(place.text("ugly.hvi").replace("param n = 4", "param   n   =   4"))
    commands = [("run", "s.hvi", "-o", "out"), ("run", "s.hvi", "--no-files", "--json", "-"), ("check", "s.hvi"), ("plan", "s.hvi"),
                ("check", "s.hvi", "--json", "-"), ("study", "s.hvi", "-o", "sy"), ("stability", "s.hvi", "-o", "st"), ("test", "s.hvi"),
                ("params", "s.hvi"), ("mesh", "plate.msh"), ("fmt", "--check", "ugly.hvi"), ("explain", "E0301"), ("explain", "--all"),
                ("--help",), ("--version",), *(("dump", f"--{phase}", "s.hvi") for phase in ("tokens", "ast", "model", "plan"))]
    for words in commands:
        for shell in (">/dev/full", ">&-", "| true"):
            if shell == "| true":
                reader, writer = os.pipe()
                os.close(reader)
                done = subprocess.run([str(place.program), *words], cwd=place.folder, stdout=writer, stderr=subprocess.PIPE, text=True)
                os.close(writer)
            else:
                done = place.call(*words, shell=shell)
            check(f"{' '.join(words)} {shell}: exit 3", done.returncode == 3 and "standard output" in done.stderr, (done.returncode, done.stderr[-300:]))
    check("run > /dev/full: the table is there", len(rows(place.text("out/s.csv"))) == 8)
    check("study > /dev/full: its files are there", {"study.csv", "cost.svg"} <= set(place.names("sy")), place.names("sy"))
    done = place.call("check", "none.hvi", shell="2>/dev/full")
    check("messages that cannot be written change nothing", done.returncode == 1, done.returncode)
    done = place.call("-o", "closed", shell="2>&-")
    check("no stderr: a run as any other", done.returncode == 0 and len(rows(place.text("closed/s.csv"))) == 8)


@case
def json_to_standard_output(place):
    for words in (("run", "s.hvi", "-o", "out"), ("run", "s.hvi", "--no-files"), ("check", "s.hvi"), ("stability", "s.hvi"), ("study", "s.hvi")):
        place.write(more=STUDY.replace("[0, 2, 4]", "[2, 4]"))
        done = place.call(*words, "--json", "-")
        try:
            good = json.loads(done.stdout)["schema"].startswith("hvi-")
        except ValueError:
            good = False
        check(f"{words[0]} --json -: JSON and nothing else", good and done.returncode == 0, done.stdout[:300])
    check("no file `-`", "-" not in place.names())


@case
def two_runs(place):
    """A lock: the second run says who has the folder; killed, it is free."""
    with place.begin("-o", "out", *LONG) as run:
        check("lock: the first has it", wait_for(lambda: ".hvi-run.lock" in place.names("out") and place.text("out/.hvi-run.lock")))
        done = place.call("-o", "out")
        words = [str(run.pid), socket.gethostname(), "UTC", "out"]
        check("lock: the second says who", done.returncode == 3 and "E0608" in done.stderr and all(w in done.stderr for w in words), done.stderr)
        for command in ("stability", "study"):
            place.write(more=STUDY.replace("[0, 2, 4]", "[2, 4]"))
            done = place.call(command, "s.hvi", "-o", "out")
            check(f"lock: {command}, too", done.returncode == 3 and "E0608" in done.stderr, done.stderr)
        check("lock: another folder is free", place.call("-o", "other").returncode == 0)
        run.kill()
    done = place.call("-o", "out")
    check("lock: free when its holder was killed", done.returncode == 0 and place.names("out") == ["s.csv"], (done.stderr, place.names("out")))


@case
def pairs(place, count=50):
    """Pairs of runs at once in one folder: each has it alone, or says that it has not."""
    place.write(more=FIELDS)
    expected = {}
    for load in ("t", "2*t"):
        place.write(f"{len(load)}.hvi", load=load, more=FIELDS)
        text = place.text(f"{len(load)}.hvi")
        (place.folder / f"{len(load)}").mkdir()
        (place.folder / f"{len(load)}/s.hvi").write_text(text)
        done = subprocess.run([place.program, "run", "s.hvi", "-o", "alone"], cwd=place.folder / f"{len(load)}", capture_output=True)
        expected[len(load)] = {p.name: p.read_bytes() for p in (place.folder / f"{len(load)}/alone").iterdir()}
    refused = 0
    for i in range(count):
        out = place.folder / f"pair{i % 5}"
        runs = {load: subprocess.Popen([place.program, "run", "s.hvi", "-o", out], cwd=place.folder / str(load), stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE, text=True) for load in expected}
        ends = {load: (run.communicate()[1], run.returncode) for load, run in runs.items()}
        done = [load for load, (_, code) in ends.items() if code == 0]
        busy = [load for load, (text, code) in ends.items() if code == 3 and "E0608" in text]
        refused += len(busy)
        found = {p.name: p.read_bytes() for p in out.iterdir()}
        check(f"pair {i}: each is done or refused", done and len(done) + len(busy) == 2, ends)
        check(f"pair {i}: the results of one of them", any(found == expected[load] for load in done), sorted(found))
    print(f"pairs: {count}, {refused} runs refused")
    check("pairs: some met", refused > 0)


@case
def other_parameters(place):
    """Runs with other parameters do not mix."""
    for words in ((), ("-D", "N=4"), ("-D", "N=4", "-D", "n=2"), ("-D", "n=2", "-D", "N=4")):
        check(f"parameters {words}", place.call(*words).returncode == 0)
    check("parameters: a folder each", place.names() == ["s", "s-N=4", "s-N=4-n=2", "s.hvi"], place.names())
    check("parameters: as they were", [len(rows(place.text(f"{d}/s.csv"))) for d in ("s", "s-N=4")] == [8, 4])
    for value in ("4.0", "4e0", "0" * 200 + "4"):
        place.call("-D", f"N={value}")
    place.write(more="study vary N in [2, 4] against finest in V\n")
    place.call("study", "s.hvi", "-D", "n=2")
    inside = [n for n in place.names() if n.startswith("s-") or n == "s_study-n=2"]
    check("parameters: names that are names", len(inside) == 6 and all(re.fullmatch(r"s(_study)?-[\w.+=-]+", n) and len(n) < 200 for n in inside), inside)


@case
def inputs(place):
    """No result takes the place of a file that the script reads."""
    table = "0,0\n1,1\n"
    (place.folder / "s.csv").write_text(table)
    (place.folder / "law.hvi").write_text("fn one() = 1\n")
    (place.folder / "deep").mkdir()
    (place.folder / "deep/s_00002.vtu").write_text(table)
    place.write(load='table("s.csv", t)*one()', more=FIELDS)
    (place.folder / "s.hvi").write_text('import "law.hvi"\n' + place.text("s.hvi"))
    os.symlink(".", place.folder / "here")
    for words in (("-o", "."), ("-o", "./deep/.."), ("-o", "here"), ("--json", "s.csv"), ("--json", "s.hvi"), ("--json", "law.hvi"), ("--json", "here/law.hvi"),
                  ("-o", "out", "--json", str(place.folder / "s.csv"))):
        code, exit_ = ("E0604", 1) if words[1].endswith("..") else ("E0609", 1)
        done = place.call(*words)
        check(f"inputs: {' '.join(words)}", done.returncode == exit_ and code in done.stderr, (done.returncode, done.stderr))
        for command in ("check", "stability") if "--json" in words else ():
            done = place.call(command, "s.hvi", *words)
            check(f"inputs: {command} {' '.join(words)}", done.returncode == 1 and "E0609" in done.stderr, (done.returncode, done.stderr))
    check("inputs: as they were", place.text("s.csv") == table and place.text("law.hvi") == "fn one() = 1\n")
    place.write(load='table("s_mesh.png", t)')
    (place.folder / "s_mesh.png").write_text(table)
    for words in ((), ("-o", ".")):
        done = place.call("mesh", "s.hvi", *words)
        check(f"inputs: mesh {' '.join(words)}", done.returncode == 1 and "E0609" in done.stderr and place.text("s_mesh.png") == table, (done.returncode, done.stderr))
    check("inputs: mesh elsewhere", place.call("mesh", "s.hvi", "-o", "out").returncode == 0)
    shutil.rmtree(place.folder / "out")
    place.write(load='table("deep/s_00002.vtu", t)', more=FIELDS)
    done = place.call("-o", "deep")
    check("inputs: a table with the name of a field file", done.returncode == 1 and "E0609" in done.stderr, done.stderr)
    for words in (("--json", "out/s.csv"), ("--json", "out/s_00002.vtu"), ("--json", "out/s_monitors.csv", "--monitors"), ("--json", "here/out/s.csv")):
        done = place.call("-o", "out", *words)
        check(f"inputs: two results in one file, {' '.join(words)}", done.returncode == 1 and "E0609" in done.stderr and not (place.folder / "out").exists(),
              (done.returncode, done.stderr))
    check("inputs: another folder will do", place.call("-o", "out").returncode == 0)
    os.symlink("../s.csv", place.folder / "out/s_link")
    place.write(load='table("s.csv", t)')
    (place.folder / "s.csv").rename(place.folder / "out/real.csv")
    os.symlink("out/real.csv", place.folder / "s.csv")
    place.write("real.hvi", load='table("s.csv", t)')
    done = place.call("run", "real.hvi", "-o", "out")
    check("inputs: behind a link", done.returncode == 1 and "E0609" in done.stderr and place.text("out/real.csv") == table, done.stderr)


@case
def modes(place):
    """New files have the mode that the umask says; a formatted script keeps its own, its links and its names."""
    for mask, mode in ((0o077, 0o600), (0o022, 0o644), (0o002, 0o664)):
        place.call("-o", f"out{mask}", "--json", f"{mask}.json", preexec_fn=lambda m=mask: os.umask(m))
        modes_ = {oct(p.stat().st_mode & 0o777) for p in (place.folder / f"out{mask}/s.csv", place.folder / f"{mask}.json")}
        check(f"umask {mask:o}", modes_ == {oct(mode)}, modes_)
    ugly = place.text("s.hvi").replace("param n = 4", "param   n   =   4")
    pretty = None
    for what in ("plain", "hard link", "link", "attribute"):
        folder = place.folder / f"fmt {what}"
        folder.mkdir()
        script = folder / "u.hvi"
        script.write_text(ugly)
        os.chmod(script, 0o750)
        if os.getuid() == 0:
            os.chown(script, 1234, 4321)
        given = script
        if what == "hard link":
            os.link(script, folder / "second.hvi")
        if what == "link":
            given = folder / "to.hvi"
            os.symlink("u.hvi", given)
        if what == "attribute":
            try:
                os.setxattr(script, "user.note", b"mine")
            except OSError:
                continue
        before = script.stat()
        done = place.call("fmt", str(given))
        after = script.stat()
        same = (before.st_mode, before.st_uid, before.st_gid, before.st_nlink) == (after.st_mode, after.st_uid, after.st_gid, after.st_nlink)
        pretty = pretty or script.read_text()
        check(f"fmt {what}: written, mode and owner kept", done.returncode == 0 and same and script.read_text() == pretty != ugly, (done.stderr, before, after))
        check(f"fmt {what}: links kept", given.is_symlink() == (what == "link") and (what != "hard link" or (folder / "second.hvi").read_text() == pretty)
              and (what != "attribute" or os.getxattr(script, "user.note") == b"mine"))
        check(f"fmt {what}: nothing beside it", len(list(folder.iterdir())) == (2 if "link" in what else 1), list(folder.iterdir()))
    for what in ("plain", "hard link"):
        script = place.folder / "full.hvi"
        script.unlink(missing_ok=True)
        script.write_text(ugly)
        if what == "hard link":
            os.link(script, place.folder / "again.hvi")
        done = place.call("fmt", "full.hvi", limit=64)
        check(f"fmt {what} without room: E0610, and as it was", done.returncode == 3 and "E0610" in done.stderr and script.read_text() == ugly,
              (done.returncode, done.stderr))
    done = place.call("fmt", "none.hvi", str(place.folder))
    check("fmt of what is not there", done.returncode == 1 and "there is no file" in done.stderr and "is a folder" in done.stderr, done.stderr)


@case
def refused(place):
    """What the system refuses, in a place that nobody foresaw, is no fault of ours."""
    (place.folder / "disk.hvi").write_text(
        "mesh plate = disk(1, 0.2)\npart rim = plate.rim\ntensor B = isotropic(lambda = 1, mu = 1)\nspace V = vector P1 on plate, zero on rim\n"
        "find u in V\nsuch that for all v in V\n    integral(plate, B : eps(u) : eps(v)) = integral(plate, dot([0, -1], v))\n"
        "report\n  table a = integral(plate, u.y)\n")
    check("refused: with the module that is meant it runs", place.call("run", "disk.hvi").returncode == 0)
    module = place.program.parent / "tests" / "libhvi_refusing.so"
    check("refused: the module is there", module.exists(), module)
    for command in ("run", "check", "plan", "stability"):
        done = place.call(command, "disk.hvi", env={**os.environ, "HVI_GMSH_MODULE": str(module)})
        check(f"{command}: E0611 with the system's reason", done.returncode == 3 and "E0611" in done.stderr
              and "no thread for gmsh" in done.stderr and os.strerror(11) in done.stderr, (done.returncode, done.stderr))


@case
def signals(place):
    """A closed terminal stops a run like SIGTERM; one that was told to ignore it goes on."""
    run = place.begin("-o", "out", "--checkpoint", "10000000", "-D", "N=4000000", "-D", "n=2")
    wait_for(lambda: len(rows(place.text("out/s.csv"))) > 10)
    run.send_signal(signal.SIGHUP)
    run.communicate()
    check("SIGHUP: 130 and a checkpoint", run.returncode == 130 and "s.checkpoint" in place.names("out"), (run.returncode, place.names("out")))
    run = subprocess.Popen(place.command("-o", "ignored", "-D", "N=60000", "-D", "n=2"), cwd=place.folder, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    wait_for(lambda: ".hvi-run.lock" in place.names("ignored"))
    run.send_signal(signal.SIGHUP)
    check("SIGHUP ignored: it goes on", run.wait() == 0)


@case
def counted_on(place):
    """A resumed run looks at the files that its checkpoint counts on."""
    place.write(more=FIELDS)
    whole = place.call("-o", "whole", "-D", "N=12")
    place.call("-o", "out", "--checkpoint", "4", "-D", "N=12")
    files = {p.name: p.read_bytes() for p in (place.folder / "out").iterdir()}
    good = {n: b for n, b in files.items() if not n.endswith(".checkpoint")}
    for what, change in (("gone", lambda p: p.unlink()), ("empty", lambda p: p.write_bytes(b"")), ("changed", lambda p: p.write_bytes(p.read_bytes()[:-1] + b" "))):
        for name in (n for n in files if n.endswith(".vtu")):
            for other, content in files.items():
                (place.folder / "out" / other).write_bytes(content)
            change(place.folder / "out" / name)
            done = place.call("-o", "out", "--resume", "-D", "N=12")
            check(f"resume with {name} {what}", done.returncode == 1 and "E0704" in done.stderr and name in done.stderr and what in done.stderr, done.stderr)
    for name in ("s.csv", "s.pvd"):
        for other, content in files.items():
            (place.folder / "out" / other).write_bytes(content)
        (place.folder / "out" / name).unlink()
        done = place.call("-o", "out", "--resume", "-D", "N=12")
        found = {p.name: p.read_bytes() for p in (place.folder / "out").iterdir() if p.suffix != ".checkpoint"}
        check(f"resume without {name}: written again", done.returncode == 0 and found == good, (done.stderr, sorted(found)))
    check("counted on: the reference", whole.returncode == 0)


@case
def threads(place):
    """No thread to be had: the others do the work."""
    def few():
        resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))
        os.setgid(65534)
        os.setuid(65534)
    if os.getuid() != 0:
        return
    os.chmod(place.folder, 0o777)
    shutil.copy(pathlib.Path(__file__).parents[2] / "examples/slab_friction.hvi", place.folder / "s.hvi")
    words = ("--no-files", "--quiet", "--full")
    done = place.call(*words, "--threads", "8", preexec_fn=few)
    alone = place.call(*words)
    check("no threads: as with one", done.returncode == 0 and done.stdout == alone.stdout, (done.returncode, done.stderr))


def main():
    program, wanted = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]
    for one in cases:
        if wanted and one.__name__ not in wanted:
            continue
        with tempfile.TemporaryDirectory() as folder:
            one(Place(program, folder))
    print(f"{checks - len(problems)} of {checks} as they should be")
    sys.exit(bool(problems))


main()
