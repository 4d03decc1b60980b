"""Checks every script under tests/lang/errors: exactly the errors written under the wrong code.

usage: check_errors.py HVI_RUN FOLDER
A comment line `#    ^^^^ E0301` below a line says: error E0301 at these columns of that line;
`#<^^^ E0301` says the same from column 1 on, the `<` standing for one more caret. One caret stands for a place without
width too: where something is missing. Warnings that come with an error are compared when the script names a warning.
"""
import json
import pathlib
import re
import subprocess
import sys


def expected(path):
    found, line = set(), 0
    for number, text in enumerate(path.read_text().split("\n"), 1):
        mark = re.fullmatch(r"#( *)(\^+) ([EW]\d+)", text)
        edge = re.fullmatch(r"#(<\^*) ([EW]\d+)", text)
        if edge:
            found.add((line, 1, 1 + len(edge[1]), edge[2]))
        elif mark:
            column = len(mark[1]) + 2
            found.add((line, column, column + len(mark[2]), mark[3]))
        else:
            line = number
    return found


def reported(program, path, warnings):
    done = subprocess.run([program, "check", "--diagnostics", "json", path], capture_output=True, text=True)
    rows = [json.loads(line) for line in done.stderr.splitlines()]
    found = [(d["line"], d["column"], max(d["end_column"], d["column"] + 1), d["code"]) for d in rows
             if warnings or d["code"][0] == "E"]
    assert len(found) == len(set(found)), f"{path}: an error is reported twice"
    return set(found), done.returncode


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    scripts = sorted(folder.glob("*.hvi"))
    assert len(scripts) >= 30
    failures = 0
    for path in scripts:
        want = expected(path)
        codes = {code[0] for *_, code in want}
        got, code = reported(program, path, "W" in codes)
        if want and want == got and code == (1 if "E" in codes else 0):
            continue
        failures += 1
        print(f"{path.name}: exit code {code}\n  expected {sorted(want)}\n  reported {sorted(got)}")
    print(f"{len(scripts) - failures} of {len(scripts)} scripts give exactly the expected errors")
    sys.exit(failures > 0)


main()
