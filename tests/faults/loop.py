"""Faults in loops: every allocation, write, open, rename, sync, close of a run fails once or for good, a run is killed or loses its power
at every change of the disk. Judged is what is left: an exit code that says so and one message, or the results of the run without a fault,
bit for bit; never an abort, never half a file, nothing in the way of the next run.

usage: loop.py HVI_RUN INJECT_LIBRARY [--kinds KIND,...] [--scenes NAME,...] [--commands NAME,...] [--points N] [--offset K] [--jobs J]

At most N points of each kind and mode for each command of each scene, evenly spread over those that a run without a fault has, from
the K-th on; all of them when N is 0."""
import argparse
import concurrent.futures
import dataclasses
import errno
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TIME_LIMIT = 120
ABORTED = re.compile(r"terminate called|corrupt|free\(\)|malloc\(\)|realloc\(\)|double free|Assertion|stack smashing|E0901|pure virtual|invalid pointer")
# How many ways a call can fail: the errno of each.
ERRORS = {"open": (errno.EMFILE, errno.EACCES), "read": (errno.EIO,), "write": (errno.ENOSPC, errno.EIO), "print": (errno.ENOSPC,),
          "rename": (errno.EIO,), "fsync": (errno.EIO,), "close": (errno.EIO,), "remove": (errno.EPERM,), "folder": (errno.ENOSPC,),
          "thread": (errno.EAGAIN,), "alloc": (errno.ENOMEM,)}
ENVIRONMENT = [kind for kind in ERRORS if kind != "alloc"]
STUDY = "\nstudy vary N in [2, 4] and n in [1, 2] against finest in V\n"
UGLY = "param   n   =   4\nmesh m=rectangle( 1,1,cells=[n,n] )\n"


@dataclasses.dataclass
class Scene:
    """A script of the examples, small, with what it reads."""
    name: str
    script: str
    defines: tuple = ()
    more: str = ""

    def write(self, folder):
        text = (ROOT / "examples" / self.script).read_text()
        text = re.sub(r"(?m)^study .*\n", "", text)
        (folder / "s.hvi").write_text(text + self.more)
        (folder / "u.hvi").write_text(UGLY)
        for name in set(re.findall(r'"([\w./]+\.(?:msh|csv|geo))"', text)) | {"cross_5x2.msh"}:
            shutil.copy(ROOT / "examples" / name, folder)

    def words(self, *more):
        return ("s.hvi", *(w for d in self.defines for w in ("-D", d)), *more)

    def commands(self):
        out = {"run": ("run", *self.words("--json", "r.json", "-o", "out", "--monitors", "--checkpoint", "3")),
               "killed": ("run", *self.words("--json", "r.json", "-o", "out", "--monitors", "--checkpoint", "2", "--resume")),
               "print": ("run", *self.words("--no-files", "--full", "--threads", "3")),
               "resume": ("run", *self.words("-o", "out", "--resume", "--checkpoint", "4")),
               "check": ("check", *self.words("--json", "c.json")), "plan": ("plan", *self.words("--json", "p.json")),
               "stability": ("stability", *self.words("--json", "st.json", "-o", "st")), "test": ("test", *self.words()),
               "params": ("params", "s.hvi"), "mesh": ("mesh", "cross_5x2.msh"), "fmt": ("fmt", "u.hvi"), "explain": ("explain", "E0301"),
               "help": ("--help",), "wrong": ("run", *self.words("-D", "nothing=1")),
               **{f"dump {phase}": ("dump", f"--{phase}", *self.words()) for phase in ("tokens", "ast", "model", "plan")}}
        if self.more:
            out["accuracy"] = ("run", *self.words("--accuracy", "0.2", "-o", "acc"))
            out["study"] = ("study", *(w for w in self.words("--json", "sy.json", "-o", "sy")))
        return out


SCENES = {s.name: s for s in (
    Scene("slab", "slab.hvi", ("n=2", "N=6"), STUDY), Scene("friction", "slab_friction.hvi", ("n=3", "N=5")),
    Scene("block", "block.hvi"), Scene("slab3d", "slab3d_friction.hvi", ("n=2", "N=3")), Scene("thermostat", "thermostat.hvi", ("N=8",)),
    Scene("wall", "wall.hvi", ("N=8",)), Scene("membrane", "membrane.hvi", ("n=4", "N=4")), Scene("advection", "advection.hvi", ("n=4", "N=4")),
    Scene("manufactured", "manufactured.hvi", ("n=4", "N=4")), Scene("manufactured3d", "manufactured3d.hvi", ("n=2", "N=3")),
    Scene("delamination", "delamination.hvi"), Scene("adapted", "slab_adapted.hvi", ("n=4",)), Scene("corners", "slab_corners.hvi", ("n=2",)),
    Scene("bracket", "bracket.hvi", ("N=2", "size=2")),
    # Two bodies in contact, whose sides do not match; two unknowns that act on each other, with a law of each.
    Scene("blocks", "blocks.hvi", ("n=4", "N=4")), Scene("warm_ground", "warm_ground.hvi", ("n=3", "N=4")))}


def plain(text):
    """Output without what no two runs have in common: seconds, bytes in use, process ids."""
    text = re.sub(r"\b\d[\d.e+-]*( ?(?:s|ms|min|h|CPU s|seconds))\b", r"T\1", text)
    return re.sub(r"\b\d[\d.]* (?=(?:[KMGk]i?)?(?:B|bytes)\b)", "B ", text)


# Seconds and bytes in use, and what is chosen by them.
VOLATILE = {"timing", "seconds", "cpu", "wall", "bytes", "peak_bytes", "machine", "front", "best", "shared"}


def stripped(value):
    if isinstance(value, dict):
        return {k: stripped(v) for k, v in value.items() if k not in VOLATILE}
    return [stripped(v) for v in value] if isinstance(value, list) else value


def content(path):
    """What two runs have in common of a file; None: it is half."""
    data = path.read_bytes()
    try:
        if path.suffix == ".json":
            return json.dumps(stripped(json.loads(data)))
        if path.suffix == ".jsonl":  # rows that are done; the next study goes on
            return b""  # a line that ends early counts for nothing; every line has a checksum
        if path.name == "study.csv":  # with seconds
            return b"" if data.endswith(b"\n") else None
        if path.suffix == ".svg":
            return b"" if data.rstrip().endswith(b"</svg>") else None
        if path.suffix == ".png":
            return b"" if data.startswith(b"\x89PNG") and data[-8:-4] == b"IEND" else None
    except ValueError:
        return None
    return data


PICTURES = (".png", ".svg")


def same_but_pictures(found, whole):
    """Two JSON files, which name the files of a run."""
    def without(text):
        data = json.loads(text)
        return {**data, "files": [name for name in data["files"] if not name.endswith(PICTURES)]}
    try:
        return without(found) == without(whole)
    except (ValueError, KeyError, TypeError):
        return False


def outputs(folder):
    """The files under final names, and those that are temporary."""
    files = {p.relative_to(folder).as_posix(): p for p in folder.rglob("*") if p.is_file() and not p.name.startswith("log.")}
    final = {name: path for name, path in files.items() if not path.name.startswith(".")}
    return final, [name for name in files if name not in final]


@dataclasses.dataclass
class Ending:
    code: int
    out: str
    err: str
    files: dict  # name -> content
    temporary: list


class Bench:
    """A command of a scene: where it begins, and how it ends without a fault."""

    def __init__(self, program, library, scene, name, folder):
        self.program, self.library, self.scene, self.name = program, library, scene, name
        self.words = scene.commands()[name]
        self.folder = pathlib.Path(folder)
        self.start = self.folder / "start"
        self.start.mkdir()
        scene.write(self.start)
        if name == "resume":
            with_steps = ("run", *scene.words("-o", "out", "--checkpoint", "4"))
            subprocess.run([program, *with_steps], cwd=self.start, capture_output=True)
        self.first = self.run(None, self.fresh("first"))
        again = self.run(None, self.fresh("again"))
        self.counts = self.counted(self.fresh("counted"))
        self.stable = plain(self.first.out) == plain(again.out)
        self.moving = {n for n, c in self.first.files.items() if again.files.get(n) != c}
        if name == "accuracy":  # seconds decide what is cheapest
            self.stable, self.moving = False, set(self.first.files)

    def fresh(self, name):
        folder = self.folder / name
        shutil.copytree(self.start, folder)
        return folder

    def environment(self, fault, more=()):
        # What is killed leaves its temporary files: here, where they go away with the rest.
        return {**os.environ, "TMPDIR": str(self.folder), "LD_PRELOAD": str(self.library), "HVI_FAULT": fault, **dict(more)}

    def run(self, fault, folder, words=None):
        undo = folder.parent / "undo"
        undo.mkdir(exist_ok=True)
        environment = self.environment(fault, {"HVI_FAULT_UNDO": str(undo)}) if fault else os.environ
        try:
            done = subprocess.run([self.program, *(words or self.words)], cwd=folder, capture_output=True, timeout=TIME_LIMIT, env=environment,
                                  stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            return Ending(-999, "", "", {}, [])
        final, temporary = outputs(folder)
        return Ending(done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace"),
                      {n: content(p) for n, p in final.items()}, temporary)

    def counted(self, folder):
        file = self.folder / "counts"
        environment = self.environment("alloc,0,once,0", {"HVI_FAULT_COUNTS": str(file)})
        subprocess.run([self.program, *self.words], cwd=folder, env=environment, capture_output=True, stdin=subprocess.DEVNULL)
        return {k: int(v) for k, v in (line.split() for line in file.read_text().splitlines())}

    # --- judging ---

    def half_files(self, end):
        """Final files that are neither whole nor a whole number of lines of a table."""
        out = []
        for name, found in end.files.items():
            if found is None:
                out.append(name)
            elif name in self.first.files and name not in self.moving and found != self.first.files[name] and not name.endswith(".json"):
                whole = self.first.files[name]
                lines = isinstance(found, bytes) and name.endswith((".csv", ".pvd")) and found.endswith(b"\n") and end.code != 0
                older = name in ("u.hvi",) and found == UGLY.encode()
                streamed = lines and name.endswith(".csv") and whole.startswith(found)
                fewer = lines and name.endswith(".pvd")
                saved = name.endswith(".checkpoint")  # of an earlier step; the next run reads it
                if not (older or streamed or fewer or saved):
                    out.append(name)
        return out

    def same_results(self, end):
        """Nothing where the run is that without a fault; what differs otherwise. Warnings tell of pictures and files that are not there."""
        warned = "warning" in end.err
        out = [] if not self.stable or plain(end.out) == plain(self.first.out) or (warned and self.stable) else ["printed text"]
        for name, whole in self.first.files.items():
            found = end.files.get(name)
            if name not in end.files:
                if not (warned and name.endswith(PICTURES)):
                    out.append(f"{name} is missing")
            elif name not in self.moving and found != whole and not (warned and same_but_pictures(found, whole)):
                out.append(name)
        return out

    def judge(self, kind, end, next_end):
        """A list of (class, sentence)."""
        bad = []
        errors = len(re.findall(r"(?m)^error\[|\n?error\[E\d+\]", end.err))
        if end.code == -999:
            return [("abort", "it hangs")]
        if end.code < 0 or end.code in (70, 134, 139) or ABORTED.search(end.err):
            bad.append(("abort", f"exit {end.code}: {end.err[-200:]!r}"))
        elif end.code == self.first.code and not self.same_results(end):
            pass
        elif kind in ("open", "read") and end.code == (5 if self.name == "test" else 1) and "error[E0601]" in end.err:
            pass  # of a scene whose own expectations fail, too
        elif end.code == 0 or (end.code == self.first.code and end.code != 3):
            bad.append(("wrong", f"exit {end.code}, and not the same: {self.same_results(end)} {end.err[-200:]!r}"))
        elif end.code == 3 or (kind in ("open", "read") and end.code == (5 if self.name == "test" else 1)):
            if "error[E" not in end.err and kind not in ("print",):
                bad.append(("wrong", f"exit {end.code} without a message: {end.err[-200:]!r}"))
            if kind == "alloc" and (end.err.count("error[") != 1 or "E0607" not in end.err):
                bad.append(("wrong", f"{errors} messages: {end.err[-300:]!r}"))
        else:
            bad.append(("wrong", f"exit {end.code}: {end.err[-200:]!r}"))
        bad += [("half", name) for name in self.half_files(end)]
        if next_end is not None:
            if next_end.code != self.first.code or self.same_results(next_end):
                bad.append(("wrong", f"the next run: exit {next_end.code}, differs in {self.same_results(next_end)} {next_end.err[-200:]!r}"))
            left = [n for n in next_end.temporary if n.endswith((".hvi-part", ".lock"))]
            if left:
                bad.append(("half", f"left after the next run: {left}"))
        return bad

    def judge_kill(self, kind, mode, end, next_end):
        """What a killed process leaves, and what the same command makes of it."""
        bad = [("abort", f"exit {end.code}, not killed")] if end.code not in (-signal.SIGKILL, 0, self.first.code) else []
        if kind == "kill":  # what was not synced is lost with the power, as the system has it
            bad += [("half", name) for name in self.half_files(end)]
        told = mode not in ("0", "once", "half") and next_end.code == 1 and "E0704" in next_end.err
        if not told and (next_end.code != self.first.code or self.same_results(next_end)):
            bad.append(("wrong", f"gone on: exit {next_end.code}, differs in {self.same_results(next_end)} {next_end.err[-200:]!r}"))
        left = [n for n in next_end.temporary if n.endswith((".hvi-part", ".lock"))]
        return bad + [("half", f"left after the next run: {left}")] * bool(left)

    def try_kill(self, kind, n, mode, number):
        """The process ends at change n of the disk, and when it goes on at some more."""
        fault = f"{kind},{n},{mode},{number}"
        with tempfile.TemporaryDirectory(dir=self.folder, prefix="point") as folder:
            work = pathlib.Path(folder) / "w"
            shutil.copytree(self.start, work)
            end = self.run(fault, work)
            kills = int(end.code == -signal.SIGKILL)
            for more in (n // 2, n // 3) if kind == "kill" and n % 3 == 0 else ():
                kills += self.run(f"kill,{max(more, 1)},once,0", work).code == -signal.SIGKILL
            next_end = self.run(None, work)
            found = self.judge_kill(kind, mode, end, next_end)
            return kills, [(cls, f"{self.scene.name}/{self.name} {fault}: {text}") for cls, text in found]

    def try_point(self, kind, n, mode, number):
        fault = f"{kind},{n},{mode},{number}"
        if kind in ("kill", "loss"):
            return self.try_kill(kind, n, mode, number)
        with tempfile.TemporaryDirectory(dir=self.folder, prefix="point") as folder:
            work = pathlib.Path(folder) / "w"
            shutil.copytree(self.start, work)
            end = self.run(fault, work)
            next_end = None
            if end.code != 0 and self.name not in ("resume", "study") and (end.temporary or n % 7 == 0):
                next_end = self.run(None, work)
            found = [(cls, f"{self.scene.name}/{self.name} {fault}: {text}") for cls, text in self.judge(kind, end, next_end)]
            return end.code, found


def spread(total, most, offset):
    if most == 0 or total <= most:
        return range(1, total + 1)
    return sorted({1 + (i * total // most + offset) % total for i in range(most)})


KILLED = ("killed", "fmt", "study", "stability", "print")


def points(bench, kinds, most, offset):
    for kind in kinds:
        if kind in ("kill", "loss"):
            # Only a checkpoint tells of an fsync that only pretended; a script that it was for is lost.
            lies = spread(bench.counts["fsync"], most // 4 or 3, offset) if bench.counts["fsync"] and bench.name == "killed" else ()
            for mode in ("once", "half") if kind == "kill" else ("0", *map(str, lies)):
                for n in spread(bench.counts[kind], most, offset) if bench.name in KILLED else ():
                    yield kind, n, mode, 0 if kind == "kill" else n % 2  # with and without the renames
            continue
        if bench.name == "killed":
            continue
        for mode in ("once", "on"):
            for number in ERRORS[kind]:
                for n in spread(bench.counts[kind], most, offset):
                    yield kind, n, mode, number


class Table:
    def __init__(self):
        self.rows = {}
        self.problems = []

    def add(self, kind, code, found):
        row = self.rows.setdefault(kind, {"points": 0, "survived": 0, "told": 0, "wrong": 0, "abort": 0, "half": 0})
        ends = kind in ("kill", "loss")  # then `code` is how often the run was ended
        row["points"] += code if ends else 1
        if not found:
            row["survived"] += code if ends else code == 0
            row["told"] += not ends and code != 0
        for cls in {cls for cls, _ in found}:
            row[cls] += 1
        for cls, text in found:
            self.problems.append(text)
            print(f"{cls.upper():<6} {text}", flush=True)

    def text(self):
        out = ["| fault | points tried | the same results | an error that says so | wrong results | aborts | files half |", "|---|---|---|---|---|---|---|"]
        for kind, r in self.rows.items():
            out.append(f"| {kind} | {r['points']:,} | {r['survived']:,} | {r['told']:,} | {r['wrong']} | {r['abort']} | {r['half']} |")
        return "\n".join(out)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("library", type=pathlib.Path)
    parser.add_argument("--kinds", default="alloc," + ",".join(ENVIRONMENT))
    parser.add_argument("--scenes", default="slab,friction,block,blocks,warm_ground")
    parser.add_argument("--commands", default="")
    parser.add_argument("--points", type=int, default=10)
    parser.add_argument("--offset", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    wanted = parser.parse_args()
    program, library = wanted.program.resolve(), wanted.library.resolve()
    table = Table()
    place = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with concurrent.futures.ThreadPoolExecutor(wanted.jobs) as pool:
        for scene in SCENES.values() if wanted.scenes == "all" else (SCENES[name] for name in wanted.scenes.split(",")):
            for name in wanted.commands.split(",") if wanted.commands else scene.commands():
                if name not in scene.commands():
                    continue
                with tempfile.TemporaryDirectory(dir=place) as folder:
                    bench = Bench(program, library, scene, name, folder)
                    todo = list(points(bench, wanted.kinds.split(","), wanted.points, wanted.offset))
                    for (kind, *_), (code, found) in zip(todo, pool.map(lambda p: bench.try_point(*p), todo)):
                        table.add(kind, code, found)
    print(table.text())
    total = sum(r["points"] for r in table.rows.values())
    print(f"{total} points, {len(table.problems)} findings")
    sys.exit(bool(table.problems) or total == 0)


if __name__ == "__main__":
    main()
