"""The command line is known in lang/cli only: no other source names one of its options. The catalogue of diagnostics is left out: its
examples are command lines.

usage: options.py SOURCE_FOLDER"""
import pathlib
import re
import sys


def main():
    source = pathlib.Path(sys.argv[1])
    main_file = (source / "lang/cli/main.cpp").read_text()
    options = sorted(set(re.findall(r'"(--?[A-Za-z][a-z-]*)"', main_file)) - {"-"})
    named = re.compile(r"(?<![\w-])(" + "|".join(options) + r")(?![\w-])")
    wrong, files = [], 0
    for family in ("solver", "lang"):
        for path in sorted([*(source / family).rglob("*.hpp"), *(source / family).rglob("*.cpp")]):
            where = path.relative_to(source)
            if where.parts[:2] == ("lang", "cli") or where.name.startswith("catalogue_"):
                continue
            files += 1
            for line, text in enumerate(path.read_text().split("\n"), 1):
                if found := named.search(text):
                    wrong.append(f"{where}:{line}: names the option {found[1]}")
    print("\n".join(wrong))
    print(f"{len(options)} options, {files} sources, {len(wrong)} places that name one")
    sys.exit(bool(wrong) or len(options) < 15 or files < 300)


main()
