"""A generated document is what the program prints.  usage: compare.py FILE HVI_RUN ARGUMENT..."""
import difflib
import pathlib
import subprocess
import sys

path = pathlib.Path(sys.argv[1])
now = subprocess.run(sys.argv[2:], capture_output=True, text=True, check=True).stdout
if path.read_text() != now:
    sys.stdout.writelines(difflib.unified_diff(path.read_text().splitlines(True), now.splitlines(True),
                                               path.name, "now"))
    sys.exit(f"{path} is old: write it anew with  hvi-run {' '.join(sys.argv[3:])} > {path}")
