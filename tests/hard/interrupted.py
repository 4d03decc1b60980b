"""Runs that are killed, interrupted and resumed give the bits of a run that was not.

usage: interrupted.py HVI_RUN KILLS     about so many kills in all, at random moments
Every route of the memory, both schemes, ageing kernels, imposed values. Compared are tables, fields,
monitors and JSON, the latter without CPU seconds and bytes of memory in use.
"""
import json
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

here = pathlib.Path(__file__).parent
SCENES = {
    "recursion": [],
    "direct": ["-D", "route=direct", "-D", "steps=600"],
    "tree": ["-D", "route=tree"],
    "fit": ["-D", "route=fit", "-D", "power=0.5"],
    "ageing": ["-D", "ageing=1"],
    "bdf2": ["-D", "order=bdf2"],
    "lifted": ["-D", "lift=0.01"],
}
failures = []
most_seconds = 60  # a run of the test takes one or two


def check(good, what):
    print(f"{'ok   ' if good else 'FAILS'} {what}")
    if not good:
        failures.append(what)


class Scene:
    def __init__(self, program, folder, arguments):
        self.folder = pathlib.Path(folder)
        shutil.copy(here / "longer.hvi", self.folder)
        self.base = [str(program), "run", "longer.hvi", "--monitors", "--quiet", "-D", "steps=1500", *arguments]

    def command(self, out, *more):
        return [*self.base, "-o", out, "--json", f"{out}.json", *more]

    def call(self, out, *more):
        return subprocess.run(self.command(out, *more), cwd=self.folder, capture_output=True, text=True, timeout=10 * most_seconds)

    def killed(self, out, delay, sign, *more):
        """Starts, sends the signal after the delay; the return code."""
        with subprocess.Popen(self.command(out, *more), cwd=self.folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as process:
            time.sleep(delay)
            process.send_signal(sign)
            try:
                return process.wait(timeout=most_seconds)
            except subprocess.TimeoutExpired:
                process.kill()
                sys.exit(f"FAILS {sign.name} does not end a run within {most_seconds} s")

    def differences(self, out, reference):
        """Files that are not the reference's bit for bit."""
        names = [p.name for p in (self.folder / reference).iterdir() if p.suffix != ".checkpoint"]
        bad = [n for n in names if (self.folder / out / n).read_bytes() != (self.folder / reference / n).read_bytes()]
        one, two = (self.numbers(f) for f in (out, reference))
        return bad + [f"JSON: {k}" for k in two if one.get(k) != two[k]]

    def numbers(self, out):
        data = json.loads((self.folder / f"{out}.json").read_text())
        del data["timing"], data["plan"]["seconds"], data["plan"]["bytes"]
        for history in data["plan"]["history"]:
            del history["bytes"]
        return data


def kills(scene, name, wanted, random_):
    start = time.time()
    done = scene.call("whole")
    length = time.time() - start
    assert done.returncode == 0, done.stderr
    killed = rounds = 0
    while killed < wanted:
        rounds += 1
        shutil.rmtree(scene.folder / "cut", ignore_errors=True)
        code = -signal.SIGKILL
        while code == -signal.SIGKILL:
            code = scene.killed("cut", random_.uniform(0, 0.8 * length), signal.SIGKILL, "--checkpoint", "37", "--resume")
            killed += code == -signal.SIGKILL
        check(code == 0, f"{name}: the last part ends with exit {code}")
        bad = scene.differences("cut", "whole")
        check(not bad, f"{name}: killed {killed} times in {rounds} runs, resumed: the same bits {bad}")
        left = [p.name for p in (scene.folder / "cut").glob("*.checkpoint.*")]
        check(not left, f"{name}: nothing of killed writes is left {left}")
    return length


def stops(scene, name, length):
    for sign in (signal.SIGINT, signal.SIGTERM):
        shutil.rmtree(scene.folder / "cut", ignore_errors=True)
        part = 0.6
        tries = 0
        code, saved = 0, False
        while tries < 30 and not (code == 130 and saved) and code in (0, 130, -sign):
            code = scene.killed("cut", part * length, sign, "--checkpoint", "100000")
            saved = (scene.folder / "cut" / "longer.checkpoint").exists()
            part *= 0.7 if code == 0 else 1.2  # it was done, or had not taken a step yet
            tries += 1
        check(code == 130 and saved, f"{name}: {sign.name} in the middle: exit {code}, checkpoint {saved}")
        done = scene.call("cut", "--resume")
        check(done.returncode == 0 and not scene.differences("cut", "whole"), f"{name}: resumed after {sign.name}")


def refusals(scene, random_):
    """Damaged and foreign checkpoints: a clear error, nothing computed."""
    shutil.rmtree(scene.folder / "cut", ignore_errors=True)
    assert scene.call("cut", "--checkpoint", "700").returncode == 0
    path = scene.folder / "cut" / "longer.checkpoint"
    good = path.read_bytes()

    def refused(what, bytes_, *more, said=""):
        path.write_bytes(bytes_)
        (scene.folder / "cut.json").unlink(missing_ok=True)
        done = scene.call("cut", "--resume", *more)
        fine = done.returncode == 1 and "E0704" in done.stderr and said in done.stderr and not (scene.folder / "cut.json").exists()
        check(fine, f"{what}: exit {done.returncode}")
        if not fine:
            print(done.stderr)

    for _ in range(8):
        place = random_.randrange(len(good))
        refused(f"bit flipped in byte {place} of {len(good)}",
                good[:place] + bytes([good[place] ^ (1 << random_.randrange(8))]) + good[place + 1:])
    for size in (0, 7, 40, 48, len(good) // 2, len(good) - 1):
        refused(f"cut to {size} bytes", good[:size])
    refused("a byte more", good + b"x")
    refused("a text", b"no checkpoint at all, but long enough to have room for a header of one")
    refused("another parameter", good, "-D", "lift=0.001")
    refused("another mesh", good, "-D", "n=9")
    refused("another number of steps", good, "-D", "steps=1501")
    refused("another way to the same steps", good, "--full", said="how it is to be solved")
    path.write_bytes(good)
    script = scene.folder / "longer.hvi"
    text = script.read_text()
    script.write_text(text.replace("1 - ", "1.0000000000000002 - "))
    refused("a script changed by one unit in the last place", good)
    script.write_text(text + "\n# a comment changes nothing\n")
    done = scene.call("cut", "--resume")
    check(done.returncode == 0, "a comment more in the script")
    lost = next((scene.folder / "cut").glob("*.vtu"))
    lost.unlink()
    refused("a field file is gone", good)


def main():
    program, wanted = pathlib.Path(sys.argv[1]).resolve(), int(sys.argv[2])
    random_ = random.Random(20)
    for name, arguments in SCENES.items():
        with tempfile.TemporaryDirectory() as folder:
            scene = Scene(program, folder, arguments)
            length = kills(scene, name, max(1, wanted // len(SCENES)), random_)
            if name == "recursion":
                stops(scene, name, length)
                refusals(scene, random_)
    if failures:
        sys.exit(f"{len(failures)} failed: " + "; ".join(failures))


main()
