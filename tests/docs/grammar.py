"""The grammar in docs/language.md is the one above the parser's functions.  usage: grammar.py [--update]"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FILES = ["parser", "parse_decl", "parse_region", "parse_find", "parse_report", "parse_condition", "parse_expr", "parse_postfix",
         "lexer"]


def productions(text):
    """Comments of the form `// name = ... ;`, over several lines."""
    for block in re.findall(r"((?:^// .*\n)+)", text, re.M):
        joined = " ".join(line[3:].strip() for line in block.strip().split("\n"))
        if match := re.fullmatch(r"([a-z-]+) = (.*) ;", joined):
            yield match[1], match[2]


def wrapped(name, body):
    lines, line = [], f"{name} ="
    for word in body.split(" "):
        if len(line) + len(word) > 108:
            lines.append(line)
            line = "     "
        line += " " + word
    return "\n".join([*lines, line + " ;"])


grammar = {}
for file in FILES:
    for name, body in productions((ROOT / f"lang/syntax/{file}.cpp").read_text()):
        assert name not in grammar, name
        grammar[name] = body
named = set(re.findall(r"[a-z]+(?:-[a-z]+)*", " ".join(re.sub(r"\"[^\"]*\"|'[^']*'", "", body) for body in grammar.values())))
missing = named - set(grammar) - {"letter", "digit", "any", "character", "but", "and", "newline"}
assert len(grammar) > 40 and not missing, missing
text = "\n".join(wrapped(name, body) for name, body in grammar.items())
path = ROOT / "docs/language.md"
page = path.read_text()
made = re.sub(r"```ebnf\n.*?```", lambda _: f"```ebnf\n{text}\n```", page, count=1, flags=re.S)
if "--update" in sys.argv:
    path.write_text(made)
elif made != page:
    sys.exit("the grammar in docs/language.md is old: run tests/docs/grammar.py --update")
print(f"{len(grammar)} productions")
