"""The program is hardened: position independent, relocations read-only and bound at the start, no executable stack.  usage: hardened.py FILE..."""
import re
import subprocess
import sys


def read(option, path):
    return subprocess.run(["readelf", option, "-W", path], capture_output=True, text=True, check=True).stdout


def findings(path):
    header, segments, dynamic = (read(option, path) for option in ("-h", "-l", "-d"))
    stack = re.search(r"GNU_STACK.*", segments)
    loads = re.findall(r"LOAD\s+(?:0x\w+\s+){5}(\S[RWE ]*?)\s+0x", segments)
    return {
        "position independent (type DYN)": re.search(r"Type:\s+DYN", header),
        "relocations made read-only (RELRO)": "GNU_RELRO" in segments,
        "all of them, at the start (BIND_NOW)": re.search(r"BIND_NOW|Flags:.*\bNOW\b", dynamic),
        "no text is relocated": "TEXTREL" not in dynamic,
        "no executable stack": stack and "E" not in stack[0].split("0x")[-2],
        "no segment to write and execute": loads and not any("W" in flags and "E" in flags for flags in loads),
        "no search path for libraries": "RPATH" not in dynamic and "RUNPATH" not in dynamic or not path.endswith("hvi-run"),
    }


def main():
    wrong = 0
    for path in sys.argv[1:]:
        for what, holds in findings(path).items():
            wrong += not holds
            print(f"{'ok   ' if holds else 'WRONG'} {path}: {what}")
    sys.exit(wrong > 0 or len(sys.argv) < 2)


main()
