"""Watching a run changes nothing: with checkpoints, monitors and more threads at once, and without files, every example gives the
same bits in tables, fields and JSON (but for seconds, bytes in use, counted sweeps and the monitors' own). The files in its folder are
those that it tells.
usage: same_bits.py HVI_RUN EXAMPLES"""
import json
import pathlib
import subprocess
import sys
import tempfile

program, examples = pathlib.Path(sys.argv[1]).resolve(), sorted(pathlib.Path(sys.argv[2]).resolve().glob("*.hvi"))
SHORTER = {"disc_brake": ["-D", "N=4"], "seal": ["-D", "N=2"], "creep": ["-D", "N=40"]}
LONG = {"disc_brake"}  # not without files
WAYS = {"plain": [], "watched": ["--monitors", "--checkpoint", "3", "--threads", "3"], "no files": ["--no-files"]}
# What is counted and timed may differ: watching takes work. Monitors have a file and a key of their own.
OWN = {"timing", "monitors", "plan", "files"}


def numbers(path):
    data = json.loads(path.read_text())
    return {key: value for key, value in data.items() if key not in OWN}


def main():
    wrong = compared = 0
    for example in examples:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            for way, words in WAYS.items():
                if way == "no files" and example.stem in LONG:
                    continue
                out = [] if way == "no files" else ["-o", folder / way]
                subprocess.run([program, "run", example, "--quiet", "--json", folder / f"{way}.json", *out, *words, *SHORTER.get(example.stem, [])], cwd=example.parent, check=True,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                compared += 1
                told = set(json.loads((folder / f"{way}.json").read_text())["files"])
                there = {path.name for path in (folder / way).iterdir() if path.suffix != ".checkpoint"} if out else set()
                if told != there:
                    wrong += 1
                    print(f"{example.name} with {way}: told are not the files there: {sorted(told ^ there)}")
                first, here = numbers(folder / "plain.json"), numbers(folder / f"{way}.json")
                bad = [key for key in first if here.get(key) != first[key]]
                for path in (folder / "plain").iterdir() if out else ():
                    other = folder / way / path.name
                    if not other.exists() or other.read_bytes() != path.read_bytes():
                        bad.append(path.name)
                if bad:
                    wrong += 1
                    print(f"{example.name} with {way}: other bits in {bad}")
    print(f"{compared} runs of {len(examples)} examples, {wrong} with other bits")
    sys.exit(wrong > 0 or not examples)


main()
