"""The formatter over every script of the repository: idempotent, comments and tokens kept; ours are formatted.

usage: fmt.py HVI_RUN SOURCE_FOLDER
A script with errors of syntax stays as it is. What a comment is is read off here without the program's lexer.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

FORMATTED = ["examples", "stdlib"]
COMMENT = re.compile(r'"[^"\n]*"|#[^\n]*')


def comments(text):
    return [m[0].rstrip() for m in COMMENT.finditer(text) if m[0][0] == "#"]


def tokens(text):
    """The text without comments and blanks outside of quotes."""
    bare = COMMENT.sub(lambda m: m[0] if m[0][0] == '"' else "", text.lstrip("\ufeff"))
    return re.sub(r'("[^"\n]*")|\s+', lambda m: m[1] or "", bare)


def main():
    program, source = sys.argv[1], pathlib.Path(sys.argv[2])
    folders = ["examples", "stdlib", "tests", "bench"]
    scripts = [p for f in folders for p in sorted((source / f).rglob("*.hvi")) if "corpus" not in p.parts]
    wrong, n_formatted = [], 0
    with tempfile.TemporaryDirectory() as temporary:
        copy = pathlib.Path(temporary) / "script.hvi"
        for path in scripts:
            before = path.read_bytes().decode("utf-8", "replace")
            shutil.copy(path, copy)
            code = subprocess.run([program, "fmt", copy], capture_output=True).returncode
            once = copy.read_bytes().decode("utf-8", "replace")
            if code != 0:
                wrong += [f"{path}: exit code {code}, and the file is not what it was"] if once != before else []
                continue
            n_formatted += 1
            again = subprocess.run([program, "fmt", "--check", copy], capture_output=True).returncode
            if again != 0:
                wrong.append(f"{path}: formatting twice changes it again")
            if comments(once) != comments(before):
                wrong.append(f"{path}: comments are not kept")
            if tokens(once) != tokens(before):
                wrong.append(f"{path}: the tokens differ")
            if path.relative_to(source).parts[0] in FORMATTED and once != before:
                wrong.append(f"{path}: not formatted, run `hvi-run fmt`")
    print("\n".join(wrong))
    print(f"{n_formatted} of {len(scripts)} scripts formatted, the others have errors of syntax")
    assert n_formatted >= 100
    sys.exit(bool(wrong))


main()
