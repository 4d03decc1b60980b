"""Wrong scripts made by changing right ones: each gives exactly the errors that are marked.

usage: wrong.py HVI_RUN FOLDER [OUTPUT] [--part K/N]
FOLDER holds right scripts (NAME.hvi) and changes to them (*.txt), separated by lines `---`:

    name_of_the_wrong_script NAME
    old text => new text with <<E0301|what is underlined>>

Further changes of one script are separated by `&&`. `\\n` is a line break; `<<E0204|~>>` marks a place where something is
missing, `<<W0604,W0605|...>>` two codes, `<<E0229/>>` a bar and `<<E0213|GT>>` a `>`. The scripts are written with comment lines below the marked places, and
check_errors.py compares. With OUTPUT they are kept there, with --part every N-th is
tried, from the K-th on.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SIGNS = {"~": "", "GT": ">"}


def marked_line(line):
    """The line without its marks, and below it a comment line for each."""
    marks, plain, rest = [], "", line
    while mark := re.search(r"<<([EW]\d{4}(?:,[EW]\d{4})*)(/>>|\|(.+?)>>(?!>))", rest):
        plain += rest[: mark.start()]
        text = "|" if mark[2] == "/>>" else SIGNS.get(mark[3], mark[3])
        marks += [(len(plain), max(1, len(text)), code) for code in mark[1].split(",")]
        plain += text
        rest = rest[mark.end():]
    plain += rest
    if any(start >= len(plain.rstrip()) for start, *_ in marks):
        plain = plain.rstrip()
    below = ["#" + ("<" + "^" * (n - 1) if start == 0 else " " * (start - 1) + "^" * n) + " " + code
             for start, n, code in marks]
    return [plain, *below]


def changed(block, folder):
    head, *rest = block.strip("\n").split("\n")
    name, base = head.split()
    text = (folder / f"{base}.hvi").read_text()
    for change in "\n".join(rest).split("\n&&\n"):
        old, new = (part.replace("\\n", "\n") for part in change.split(" => "))
        assert text.count(old) == 1, f"{name}: `{old}` stands {text.count(old)} times in {base}.hvi"
        text = text.replace(old, new)
    return name, "\n".join(line for plain in text.split("\n") for line in marked_line(plain))


def scripts(folder):
    """Name and text of each wrong script."""
    for path in sorted(folder.glob("*.txt")):
        for block in path.read_text().split("\n---\n"):
            yield changed(block, folder)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("output", nargs="?")
    parser.add_argument("--part", default="1/1")
    options = parser.parse_args()
    program, folder = options.program, options.folder
    first, step = map(int, options.part.split("/"))
    with tempfile.TemporaryDirectory() as temporary:
        output = pathlib.Path(options.output or temporary)
        output.mkdir(exist_ok=True)
        for path in folder.iterdir():
            if path.suffix in (".csv", ".msh", ".geo"):
                shutil.copy(path, output)
        names = set()
        for name, text in scripts(folder):
            assert name not in names, f"{name} is there twice"
            names.add(name)
            if (len(names) - first) % step == 0:
                (output / f"{name}.hvi").write_text(text)
        judge = pathlib.Path(__file__).with_name("check_errors.py")
        sys.exit(subprocess.run([sys.executable, judge, program, output]).returncode)


if __name__ == "__main__":
    main()
