"""Pairs of scripts that state the same problem in two ways have the same certified results.

usage: same.py HVI_RUN FOLDER [NAME]     (the format of FOLDER/*.txt is that of wrong.py, without marks)
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile


def changed(text, changes, name):
    for change in changes.strip("\n").split("\n&&\n"):
        old, new = (part.replace("\\n", "\n") for part in change.split(" => "))
        assert text.count(old) == 1, f"{name}: `{old}` stands {text.count(old)} times"
        text = text.replace(old, new)
    return text


def result(program, folder, name, text):
    script = folder / f"{name}.hvi"
    script.write_text(text)
    done = subprocess.run([program, script, "-o", folder / name, "--json", folder / f"{name}.json"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{name} exits with {done.returncode}\n{done.stderr}\n{text}")
    answer = json.loads((folder / f"{name}.json").read_text())
    assert answer["certificate"]["certified"], name
    return answer["table"]


def main():
    program, source = sys.argv[1], pathlib.Path(sys.argv[2])
    blocks = [block for path in sorted(source.glob("*.txt"))
              for block in path.read_text().split("\n---\n")[1:]]
    only = sys.argv[3] if len(sys.argv) > 3 else None
    n_moved = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for path in source.iterdir():
            shutil.copy(path, folder)
        for block in blocks:
            head, _, changes = block.strip("\n").partition("\n")
            name, base = head.split()
            if only and name != only:
                continue
            text = (source / f"{base}.hvi").read_text()
            one, other = (changed(text, part, name) for part in changes.split("\n===\n"))
            assert one != other, name
            a, b = result(program, folder, name + "_one", one), result(program, folder, name + "_other", other)
            assert a.keys() == b.keys()
            for column in a:
                scale = max(abs(x) for x in a[column])
                worst = max(abs(x - y) for x, y in zip(a[column], b[column], strict=True))
                n_moved += column != "t" and scale > 0
                if worst > 1e-8 * scale:
                    sys.exit(f"{name}: column {column} differs by {worst:.3g} of {scale:.3g}")
    print(f"{len(blocks)} pairs, {n_moved} columns that are not zero")


main()
