"""The reference names every module of the standard library.   usage: modules.py SOURCE_FOLDER"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
row = next(line for line in (source / "docs/language.md").read_text().split("\n") if line.startswith("| `import name`"))
named = re.findall(r"`(\w+)`", row[row.index("standard library"):])
modules = sorted(path.stem for path in (source / "stdlib").glob("*.hvi"))
assert named == modules, f"the reference names {named}, stdlib has {modules}"
titles = re.findall(r"^## (\w+)$", (source / "docs/stdlib.md").read_text(), re.M)
assert sorted(titles) == modules, f"docs/stdlib.md has {titles}"
print(f"{len(modules)} modules")
