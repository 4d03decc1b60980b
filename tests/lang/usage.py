"""Commands typed wrong: exit code 2, and a text that says what was meant.  usage: usage.py HVI_RUN"""
import pathlib
import subprocess
import sys
import tempfile

COMMANDS = "run, report, check, plan, study, stability, test, fmt, params, mesh, dump, serve-editor, new, explain"
CASES = [
    (["chek", "a.hvi"], ["`chek`", "did you mean `check`?", COMMANDS]),
    (["plna", "a.hvi", "-D", "n=2"], ["`plna`", "did you mean `plan`?"]),
    (["bridge.hv"], ["`bridge.hv`", "FILE.hvi"]),
    ([], ["run", "solve", "check", "--version"]),
    (["run"], ["FILE is required"]),
    (["check", "--bogus", "a.hvi"], ["`check` has no option `--bogus`; hvi-run check --help"]),
    (["a.hvi", "--no-file"], ["`run` has no option `--no-file`: did you mean `--no-files`?"]),
    (["a.hvi", "-n", "4"], ["`run` has no option `-n`"]),
    (["plan", "a.hvi", "--resume=3"], ["`plan` has no option `--resume`"]),
    (["a.hvi", "n=4"], ["`n=4` is no script", "-D name=value"]),
    (["a.hvi", "-D", "n", "=", "4"], ["`=` is no script", "-D name=value"]),
    (["a.hvi", "b.hvi", "--json", "c", "-Dn=3"], ["`run` takes one script, and `b.hvi` is one more word"]),
    (["--quiet", "check", "a.hvi"], ["options stand behind the command: hvi-run check ... --quiet"]),
    (["-v"], ["neither a command nor a script is named"]),
    (["-D", "n=4"], ["neither a command nor a script is named"]),
    (["usage"], ["`usage`", "FILE.hvi"]),
    (["a.hvi", "-D", "n"], ["-D takes name=value", "`n`"]),
    (["a.hvi", "-o", ""], ["-o", "an empty name"]),
    (["a.hvi", "--json", ""], ["--json", "an empty name"]),
    (["a.hvi", "--threads", "none"], ["--threads"]),
    (["a.hvi", "--checkpoint", "0"], ["--checkpoint: not a positive number: 0\n"]),
    (["a.hvi", "--checkpoint", "1.5"], ["--checkpoint"]),
    *[(["a.hvi", option, value], [option, value]) for option in ("--accuracy", "--budget") for value in ("nan", "inf", "0", "-1", "1e-2x")],
    (["a.hvi", "--of", "", "--accuracy", "0.1"], ["--of", "an empty name"]),
    *[([command, "a.hvi", "--json", "b"], ["--json: this command writes no JSON"]) for command in ("test", "fmt", "params", "mesh", "dump")],
    (["check", "a.hvi", "b.hvi", "--json", "c"], ["--json writes the result of one script, not of 2"]),
    *[(["check", "a.hvi", "--script-only", *option], [option[0], "--script-only"]) for option in (["--json", "b"], ["--strict"], ["--report"])],
    (["explain"], ["explain takes a code"]),
]


def main():
    wrong, program = [], str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "beam.hvi").write_text("")
        done = subprocess.run([program, "beam"], cwd=folder, capture_output=True, text=True)
        if done.returncode != 2 or "did you mean `beam.hvi`?" not in done.stderr:
            wrong.append(f"a script without its ending: exit code {done.returncode}\n{done.stderr}")
    for arguments, words in CASES:
        done = subprocess.run([sys.argv[1], *arguments], capture_output=True, text=True)
        missing = [word for word in words if word not in done.stderr]
        if done.returncode != 2 or missing or done.stdout:
            wrong.append(f"{arguments}: exit code {done.returncode}, not said: {missing}\n{done.stdout}{done.stderr}")
    print("\n".join(wrong))
    print(f"{len(CASES) - len(wrong)} of {len(CASES)} as they should be")
    sys.exit(bool(wrong))


main()
