"""Completion, man page and TextMate grammar are made, are valid, and know the language.  usage: editor.py HVI_RUN"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
program = sys.argv[1]


def completions(folder, *words):
    """What bash offers for the last of the words."""
    line = f"""source {folder}/hvi-run.bash; COMP_WORDS=({' '.join(f"'{w}'" for w in words)}); COMP_CWORD={len(words) - 1}
               PATH={pathlib.Path(program).parent}:$PATH; cd {ROOT}/examples; _hvi_run; printf '%s\\n' "${{COMPREPLY[@]}}" """
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=True).stdout.split()


with tempfile.TemporaryDirectory() as folder:
    subprocess.run([ROOT / "tools/editor_files", program, folder], check=True)
    assert completions(folder, "hvi-run", "che") == ["check"]
    assert "--script-only" in completions(folder, "hvi-run", "check", "--s")
    assert "slab.hvi" in completions(folder, "hvi-run", "check", "sl")
    assert completions(folder, "hvi-run", "--diagnostics", "j") == ["json"]
    assert "N=" in completions(folder, "hvi-run", "slab.hvi", "-D", "")
    man = pathlib.Path(folder, "hvi-run.1").read_text()
    for word in ("check", "study", "explain", "\\-\\-strict", "NO_COLOR", "130"):
        assert word in man, word
    if shutil.which("man"):
        shown = subprocess.run(["man", "--warnings", "-l", f"{folder}/hvi-run.1"], capture_output=True, text=True)
        assert shown.returncode == 0 and not shown.stderr, shown.stderr
    grammar = json.loads(pathlib.Path(folder, "hvi.tmLanguage.json").read_text())
    rules = {rule["name"].split(".")[0] + "." + rule["name"].split(".")[1]: re.compile(rule["match"])
             for rule in grammar["patterns"]}
    for kind, text in {"keyword.control": "superpotential", "keyword.other": "such", "support.function": "isotropic",
                       "support.constant": "bdf2", "variable.language": "lag", "constant.numeric": "1.5e-3",
                       "string.quoted": '"a"', "comment.line": "# a"}.items():
        assert rules[kind].fullmatch(text), (kind, text)
    for text in ("70 [GPa]", "[0, 10] [s]", "(1 + 2)[kg/m^3]", "1 [1/s]"):
        assert rules["storage.type"].search(text), text
    for text in ("[0, 10]", "cells = [n, m]", "at [x, y]"):
        assert not rules["storage.type"].search(text), text
        assert not rules["keyword.control"].fullmatch("slab")
print("completion, man page and grammar")
