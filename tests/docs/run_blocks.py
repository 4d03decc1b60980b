"""Runs every block marked `hvi` of a Markdown file as a script, beside the files of the blocks marked `csv NAME`.

usage: run_blocks.py HVI_RUN FILE
"""
import pathlib
import re
import subprocess
import sys
import tempfile

program, document = sys.argv[1:]
text = pathlib.Path(document).read_text()
blocks = re.findall(r"```hvi\n(.*?)```", text, re.S)
assert blocks, "no block to run"
with tempfile.TemporaryDirectory() as folder:
    for name, data in re.findall(r"```csv (\S+)\n(.*?)```", text, re.S):
        pathlib.Path(folder, name).write_text(data)
    for number, block in enumerate(blocks, 1):
        script = pathlib.Path(folder) / f"block{number}.hvi"
        script.write_text(block)
        done = subprocess.run([program, "test" if "expect" in block else "run", script, "-o", folder],
                              capture_output=True, text=True)
        certified = "certified" in done.stdout or re.search(r"\b[1-9]\d* passed, 0 failed", done.stdout)
        if done.returncode != 0 or not certified or "warning" in done.stderr:
            sys.exit(f"block {number} of {document} exits with {done.returncode}\n{done.stderr}{done.stdout}\n{block}")
print(f"{len(blocks)} blocks")
