"""The program is hardened: position independent, relocations read-only and bound at the start, no executable stack, stacks with
canaries, checked copies.  usage: hardened.py BUILD FILE..."""
import json
import pathlib
import re
import subprocess
import sys


def read(option, path):
    return subprocess.run(["readelf", option, "-W", path], capture_output=True, text=True, check=True).stdout


def findings(path):
    header, segments, dynamic, symbols = (read(option, path) for option in ("-h", "-l", "-d", "--dyn-syms"))
    stack = re.search(r"GNU_STACK.*", segments)
    imported = set(re.findall(r"UND (\w+)", symbols))
    loads = re.findall(r"LOAD\s+(?:0x\w+\s+){5}(\S[RWE ]*?)\s+0x", segments)
    return {
        "position independent (type DYN)": re.search(r"Type:\s+DYN", header),
        "relocations made read-only (RELRO)": "GNU_RELRO" in segments,
        "all of them, at the start (BIND_NOW)": re.search(r"BIND_NOW|Flags:.*\bNOW\b", dynamic),
        "no text is relocated": "TEXTREL" not in dynamic,
        "no executable stack": stack and "E" not in stack[0].split("0x")[-2],
        "no segment to write and execute": loads and not any("W" in flags and "E" in flags for flags in loads),
        "stack canaries (__stack_chk_fail)": "__stack_chk_fail" in imported,
        "no search path for libraries": "RPATH" not in dynamic and "RUNPATH" not in dynamic or not path.endswith("hvi-run"),
    }


def uncovered(build):
    """Sources of the program that are compiled without canaries or checked copies: the libraries linked in have both."""
    commands = json.loads((pathlib.Path(build) / "compile_commands.json").read_text())
    ours = [c for c in commands if re.search(r"/(solver|lang)/", c["file"]) and "/tests/" not in c["file"]]
    assert ours
    return [c["file"] for c in ours if "-fstack-protector-strong" not in c["command"] or "-D_FORTIFY_SOURCE=2" not in c["command"]]


def main():
    wrong = len(bad := uncovered(sys.argv[1]))
    print(f"{'WRONG' if bad else 'ok   '} compiled without canaries and checked copies: {bad[:5]}")
    for path in sys.argv[2:]:
        for what, holds in findings(path).items():
            wrong += not holds
            print(f"{'ok   ' if holds else 'WRONG'} {path}: {what}")
    sys.exit(wrong > 0 or len(sys.argv) < 3)


main()
