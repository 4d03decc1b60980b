"""The command line is known in lang/cli only: no other source names one of its options, the catalogue of diagnostics neither. What the
catalogue leaves to the caller, examples that are command lines, lang/cli has.

usage: options.py SOURCE_FOLDER"""
import pathlib
import re
import sys


def examples_left_out(source):
    """Codes of the entries without an example, and of the examples in lang/cli."""
    left = set()
    for path in (source / "lang/diag").glob("catalogue_*.cpp"):
        for entry in re.split(r"\n    (?=\{\"[EWN]\d{4}\")", path.read_text())[1:]:
            if re.search(r"\{\},\s*\{\}\}", entry):
                left.add(entry[2:7])
    return left, set(re.findall(r"\{\"([EWN]\d{4})\"", (source / "lang/cli/example_calls.cpp").read_text()))


def main():
    source = pathlib.Path(sys.argv[1])
    main_file = (source / "lang/cli/main.cpp").read_text()
    options = sorted(set(re.findall(r'"(--?[A-Za-z][a-z-]*)"', main_file)) - {"-"})
    named = re.compile(r"(?<![\w-])(" + "|".join(options) + r")(?![\w-])")
    wrong, files = [], 0
    for family in ("solver", "lang"):
        for path in sorted([*(source / family).rglob("*.hpp"), *(source / family).rglob("*.cpp")]):
            where = path.relative_to(source)
            if where.parts[:2] == ("lang", "cli"):
                continue
            files += 1
            for line, text in enumerate(path.read_text().split("\n"), 1):
                if found := named.search(text):
                    wrong.append(f"{where}:{line}: names the option {found[1]}")
    left, given = examples_left_out(source)
    wrong += [f"{code}: an example in one of the catalogue and lang/cli/example_calls.cpp" for code in sorted(left ^ given)]
    print("\n".join(wrong))
    print(f"{len(options)} options, {files} sources, {len(given)} examples, {len(wrong)} places that are wrong")
    sys.exit(bool(wrong) or len(options) < 15 or files < 300 or len(given) < 5)


main()
