"""Commands typed wrong: exit code 2, and a text that says what was meant.  usage: usage.py HVI_RUN"""
import subprocess
import sys

COMMANDS = "run, report, check, plan, study, stability, test, fmt, params, mesh, dump, serve-editor, new, explain"
CASES = [
    (["chek", "a.hvi"], ["`chek`", "did you mean `check`?", COMMANDS]),
    (["plna", "a.hvi", "-D", "n=2"], ["`plna`", "did you mean `plan`?"]),
    (["bridge.hv"], ["`bridge.hv`", "FILE.hvi"]),
    ([], ["run", "solve", "check", "--version"]),
    (["run"], ["FILE is required"]),
    (["check", "--bogus", "a.hvi"], ["--bogus"]),
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
    wrong = []
    for arguments, words in CASES:
        done = subprocess.run([sys.argv[1], *arguments], capture_output=True, text=True)
        missing = [word for word in words if word not in done.stderr]
        if done.returncode != 2 or missing or done.stdout:
            wrong.append(f"{arguments}: exit code {done.returncode}, not said: {missing}\n{done.stdout}{done.stderr}")
    print("\n".join(wrong))
    print(f"{len(CASES) - len(wrong)} of {len(CASES)} as they should be")
    sys.exit(bool(wrong))


main()
