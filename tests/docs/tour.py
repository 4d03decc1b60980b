"""Every command of a page of docs/ prints what stands below it.  usage: tour.py HVI_RUN PAGE [--update]

A block marked `console` holds a line `$ command` and its output. The commands of tour.md run in examples/, in a shell; those of
other pages one after the other in one folder, beside the files of the blocks marked `hvi NAME`.
"""
import difflib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
program = pathlib.Path(sys.argv[1]).resolve()
path = ROOT / "docs" / sys.argv[2]
page = path.read_text()
started_in = tempfile.TemporaryDirectory()
current = ROOT / "examples" if path.name == "tour.md" else pathlib.Path(started_in.name)
for name, script in re.findall(r"```hvi (\S+)\n(.*?)```", page, re.S):
    (current / name).write_text(script)


def run(block):
    command = block[1].split("\n")[0]
    assert command.startswith("$ "), command
    with tempfile.TemporaryDirectory() as folder:
        # Results go into a folder that is thrown away.
        environment = {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}", "OUT": folder}
        done = subprocess.run(["bash", "-c", command[2:]], cwd=current, env=environment, capture_output=True, text=True)
    output = (done.stdout + done.stderr).replace(folder, "OUT").rstrip("\n")
    return f"```console\n{command}\n{output}\n```"


def rounded(text):
    """Eight digits of every number, and 0 for rounding errors: the rest depends on the compiler and the processor, and so does
    the width of columns."""
    text = re.sub(r"\d+\.\d+(e[-+]\d+)?", lambda m: "0" if abs(float(m[0])) < 1e-11 else f"{float(m[0]):.8g}", text)
    return re.sub(" +", " ", text)


made = re.sub(r"```console\n(.*?)\n```", run, page, flags=re.S)
if "--update" in sys.argv:
    path.write_text(made)
elif rounded(made) != rounded(page):
    sys.stdout.writelines(difflib.unified_diff(page.splitlines(True), made.splitlines(True), str(path), "now"))
    sys.exit(f"docs/{path.name} is old: run tests/docs/tour.py HVI_RUN {path.name} --update")
print(f"{page.count('```console')} commands")
