"""Runs every block marked `hvi` of a Markdown file as a script.  usage: run_blocks.py HVI_RUN FILE"""
import pathlib
import re
import subprocess
import sys
import tempfile

program, document = sys.argv[1:]
blocks = re.findall(r"```hvi\n(.*?)```", pathlib.Path(document).read_text(), re.S)
assert blocks, "no block to run"
with tempfile.TemporaryDirectory() as folder:
    for number, block in enumerate(blocks, 1):
        script = pathlib.Path(folder) / f"block{number}.hvi"
        script.write_text(block)
        done = subprocess.run([program, script, "-o", folder], capture_output=True, text=True)
        if done.returncode != 0 or "certified" not in done.stdout:
            sys.exit(f"block {number} of {document} exits with {done.returncode}\n{done.stderr}\n{block}")
print(f"{len(blocks)} blocks")
