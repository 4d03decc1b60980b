"""Modules include what they stand on: no file of the two libraries includes a header that cmake/Floors.cmake does not allow.

usage: floors.py SOURCE_FOLDER"""
import pathlib
import re
import sys


def floors(text):
    """Module: all modules it stands on, directly or not."""
    on = {m[1]: (m[2] or "").split() for m in re.finditer(r"^hvi_floor\((\S+?)(?: ON ([^)]*))?\)", text, re.M)}
    below = {}
    for module, direct in on.items():  # in order: a module stands on those above it in the list
        unknown = [d for d in direct if d not in below]
        assert not unknown, f"{module} stands on {unknown}, which the list does not have before it"
        below[module] = set(direct).union(*(below[d] for d in direct))
    return below


def module_of(path, below):
    """The deepest folder of the list that the file lies in, else its own."""
    return next((str(folder) for folder in path.parents if str(folder) in below), str(path.parent))


def main():
    source = pathlib.Path(sys.argv[1])
    below = floors((source / "cmake/Floors.cmake").read_text())
    includes, wrong = 0, []
    for family in ("solver", "lang"):
        for path in sorted([*(source / family).rglob("*.hpp"), *(source / family).rglob("*.cpp")]):
            module = module_of(path.relative_to(source), below)
            if module not in below:
                wrong.append(f"{path.relative_to(source)}: cmake/Floors.cmake has no {module}")
                continue
            for line, text in enumerate(path.read_text().split("\n"), 1):
                if not (found := re.match(r'\s*#\s*include\s*"((?:solver|lang)/[^"]+)"', text)):
                    continue
                includes += 1
                used = module_of(pathlib.PurePath(found[1]), below)
                if used != module and used not in below[module]:
                    wrong.append(f"{path.relative_to(source)}:{line}: {module} does not stand on {used}")
                if not (source / found[1]).is_file():
                    wrong.append(f"{path.relative_to(source)}:{line}: there is no {found[1]}")
    print("\n".join(wrong))
    print(f"{len(below)} modules, {includes} includes, {len(wrong)} that are not allowed")
    sys.exit(bool(wrong) or includes < 500)


main()
