"""One name, one type: no class, struct, union or enum of the two libraries is defined in two files.

The linker keeps one of two inline functions of the same name without a word, whichever it meets first. Types in unnamed
namespaces are a file's own.   usage: one_definition.py SOURCE_FOLDER"""
import collections
import pathlib
import re
import sys

WORDS = re.compile(
    r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])+'"  # left out
    r"|(?P<namespace>\bnamespace\b(?P<path>[\s\w:]*)\{)"
    r"|(?P<type>\b(?:class|struct|union|enum(?:\s+class)?)\s+(?P<name>\w+(?:::\w+)*)(?:\s+final)?\s*(?::(?!:)[^;{()]*)?\{)"
    r"|[{}]", re.S)


def types(text):
    """Full names of the types that `text` defines outside of functions, other types and unnamed namespaces."""
    scopes = []  # names of open namespaces; None: anything else in braces
    for word in WORDS.finditer(re.sub(r"^\s*#.*(?:\\\n.*)*", "", text, flags=re.M)):
        if word["namespace"]:
            scopes.append(word["path"].strip() or None)
        elif word["type"]:
            if None not in scopes:
                yield "::".join([*scopes, word["name"]])
            scopes.append(None)
        elif word[0] == "{":
            scopes.append(None)
        elif word[0] == "}" and scopes:
            scopes.pop()


def main():
    source = pathlib.Path(sys.argv[1])
    places = collections.defaultdict(list)
    for family in ("solver", "lang"):
        for path in sorted((source / family).rglob("*.[ch]pp")):
            for name in types(path.read_text()):
                places[name].append(str(path.relative_to(source)))
    twice = {name: where for name, where in places.items() if len(where) > 1}
    for name, where in twice.items():
        print(f"{name} is defined in {', '.join(where)}")
    assert len(places) > 300, f"only {len(places)} types found"
    print(f"{len(places)} types, {len(twice)} of them defined twice")
    sys.exit(bool(twice))


main()
