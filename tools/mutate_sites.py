"""Where a source file can be made wrong on purpose: sites found in the syntax tree that libclang reads.

A site is a piece of source text and what to write instead. All mutants of a file are compiled into it at once:
`a < b` becomes `(hvi_mutant::on(17) ? (a <= b) : (a < b))`, and one program holds them all, one of them
switched on when it starts. (Untch, Offutt, Harrold, "Mutation analysis using mutant schemata", 1993.)

What is not drawn, by rule (docs/mutants.md gives the reasons): arguments of calls in TEXT_AND_ROOM, statements that
mention a name in TIMING, the files in PRINTING.
"""
import dataclasses
import pathlib
import re

import clang.cindex as clang

Kind = clang.CursorKind
ARITHMETIC = {clang.TypeKind.DOUBLE, clang.TypeKind.FLOAT, clang.TypeKind.INT, clang.TypeKind.LONG, clang.TypeKind.UINT,
              clang.TypeKind.ULONG, clang.TypeKind.LONGDOUBLE, clang.TypeKind.LONGLONG, clang.TypeKind.ULONGLONG}
FLOATING = {clang.TypeKind.DOUBLE, clang.TypeKind.FLOAT, clang.TypeKind.LONGDOUBLE}
COMPARISONS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",)}
OPERATIONS = {"+": "-", "-": "+", "*": "/", "/": "*"}
LOGIC = {"&&", "||"}
# Calls that make text for people, or room in memory ahead of need: no number of a result depends on their arguments.
TEXT_AND_ROOM = {"format", "format_to", "print", "reserve", "shrink_to_fit", "prefetch", "release_pages"}
TIMING = re.compile(rb"\b(PhaseClock|cpu_seconds|seconds_of|wall_seconds|Stopwatch|clock\.charge|profile\w*)\b")
PRINTING = re.compile(r"solver/plan/print\.cpp|lang/check/print_model\.cpp|solver/time/clock\.hpp")
ASSIGNMENTS = {"=", "+=", "-=", "*=", "/="}


@dataclasses.dataclass
class Site:
    file: str
    line: int
    start: int  # bytes of the file
    end: int
    kind: str
    before: str
    after: str
    form: str = "expression"  # "statement": left out; "constant": a declaration, no longer constexpr; "list": of numbers
    head: str = ""  # of a constant: what stands before its value
    number: int = -1  # the value of HVI_MUTANT that switches it on

    def key(self):
        return f"{self.file}:{self.line}:{self.start}: {self.kind}: {self.before} -> {self.after}"

    def text(self):
        """What the file says instead, on as many lines."""
        number, before, after = self.number, flat(self.before), flat(self.after)
        if self.form == "statement":
            text = f"if (!hvi_mutant::on({number})) {before}"
        elif self.form == "list":
            pairs = zip(before.split(", "), after.split(", "))
            text = ", ".join(f"(hvi_mutant::on({number}) ? ({b}) : ({a}))" for a, b in pairs)
        else:
            text = f"{self.head}(hvi_mutant::on({number}) ? ({after}) : ({before}))"
        return text + "\n" * self.before.count("\n")


def flat(text):
    return re.sub(r"\s*\n\s*", " ", text)


class Finder:
    def __init__(self, path, root, arguments):
        self.file = str(pathlib.Path(path).relative_to(root))
        self.source = pathlib.Path(path).read_bytes()
        self.path = str(path)
        language = ["-x", "c++"] if self.path.endswith(".hpp") else []
        unit = clang.Index.create().parse(self.path, args=language + arguments)
        self.sites = []
        for cursor in unit.cursor.get_children():
            if self.inside(cursor):
                self.walk(cursor, None, False)

    def inside(self, cursor):
        return cursor.location.file is not None and cursor.location.file.name == self.path

    def span(self, cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def piece(self, cursor):
        start, end = self.span(cursor)
        return self.source[start:end].decode()

    def add(self, cursor, kind, after, form="expression"):
        start, end = self.span(cursor)
        before = self.source[start:end].decode()
        if re.search(r"#|//|/\*", before) or before.count("(") != before.count(")"):
            return
        if form == "statement":
            if self.source[end:end + 1] != b";":
                return
        self.sites.append(Site(self.file, cursor.extent.start.line, start, end, kind, before, after, form))

    def walk(self, cursor, parent, body):
        kind = cursor.kind
        if kind == Kind.CALL_EXPR and cursor.spelling in TEXT_AND_ROOM:
            return
        if parent is not None and parent.kind == Kind.COMPOUND_STMT and TIMING.search(self.source, *self.span(cursor)):
            return
        if kind in (Kind.STATIC_ASSERT, Kind.CASE_STMT, Kind.TEMPLATE_TYPE_PARAMETER, Kind.ENUM_DECL):
            children = list(cursor.get_children())[1:] if kind == Kind.CASE_STMT else []
        else:
            children = list(cursor.get_children())
        if kind in (Kind.FUNCTION_DECL, Kind.CXX_METHOD, Kind.CONSTRUCTOR, Kind.FUNCTION_TEMPLATE):
            head = self.piece(cursor).split("{")[0]
            if "constexpr" in head or "consteval" in head:
                return
            children = [c for c in children if c.kind == Kind.COMPOUND_STMT]
            body = True
        if kind == Kind.VAR_DECL and re.search(r"\bconstexpr\b", self.piece(cursor).split("=")[0]):
            self.constant(cursor)
            return
        if body:
            self.visit(cursor, parent, children)
        for child in children:
            self.walk(child, cursor, body)

    def constant(self, cursor):
        """A named number: a thousand times larger or smaller."""
        if cursor.type.get_canonical().kind not in FLOATING:
            return
        match = re.match(rb"((?:inline |static )?)constexpr( double \w+ = )([^;,]+)$", self.source[slice(*self.span(cursor))])
        if not match:
            return
        start, end = self.span(cursor)
        value = match.group(3).decode()
        if "infinity" in value or "NaN" in value:
            return  # the same, times anything
        for factor in ("1e3", "1e-3"):
            head = (match.group(1) or b"").decode() + "const" + match.group(2).decode()
            self.sites.append(Site(self.file, cursor.extent.start.line, start, end, "constant", value, f"({value}) * {factor}",
                                   "constant", head))

    def visit(self, cursor, parent, children):
        kind = cursor.kind
        number = cursor.type.get_canonical().kind in ARITHMETIC
        if kind == Kind.BINARY_OPERATOR and len(children) == 2:
            self.binary(cursor, children, number)
        elif kind in (Kind.FLOATING_LITERAL, Kind.INTEGER_LITERAL) and parent is not None and number:
            self.literal(cursor, parent)
        elif kind == Kind.UNARY_OPERATOR and number and self.piece(cursor).startswith("-"):
            if children and children[0].kind not in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL):
                self.add(cursor, "sign", self.piece(children[0]))
        elif kind == Kind.CALL_EXPR and number:
            self.swap(cursor)
        if kind == Kind.IF_STMT and children and children[0].type.get_canonical().kind == clang.TypeKind.BOOL:
            if children[0].kind != Kind.DECL_STMT and children[0].kind != Kind.VAR_DECL:
                self.add(children[0], "condition", f"!({self.piece(children[0])})")
        if parent is not None and parent.kind == Kind.COMPOUND_STMT:
            self.statement(cursor, children)

    def operator(self, children):
        """What stands between the two operands."""
        return self.source[self.span(children[0])[1]:self.span(children[1])[0]].decode().strip()

    def binary(self, cursor, children, number):
        sign = self.operator(children)
        left, right = map(self.piece, children)
        plain = all(c.type.get_canonical().kind in ARITHMETIC for c in children)
        if sign in LOGIC and all(c.type.get_canonical().kind == clang.TypeKind.BOOL for c in children):
            self.add(cursor, "dropped condition", left)
            self.add(cursor, "dropped condition", right)
        if sign in COMPARISONS and plain:
            for other in COMPARISONS[sign]:
                self.add(cursor, "comparison", f"{left} {other} {right}")
        elif sign in OPERATIONS and plain and number:
            self.add(cursor, "operator", f"{left} {OPERATIONS[sign]} {right}")
            if sign in "+-":
                self.add(cursor, "dropped term", left)

    def literal(self, cursor, parent):
        if parent.kind in (Kind.INIT_LIST_EXPR, Kind.ARRAY_SUBSCRIPT_EXPR, Kind.VAR_DECL, Kind.TEMPLATE_REF, Kind.DECL_REF_EXPR):
            return
        text = self.piece(cursor)
        if not re.fullmatch(r"[0-9.]+(?:[eE][+-]?[0-9]+)?", text):
            return
        if cursor.kind == Kind.INTEGER_LITERAL:
            self.add(cursor, "number", f"{text} + 1")
            return
        value = float(text)
        self.add(cursor, "number", "1.0" if value == 0 else f"{text} * {'1e3' if value < 1e-3 else '1.05'}")

    def swap(self, cursor):
        arguments = list(cursor.get_arguments())
        for a, b in zip(arguments, arguments[1:]):
            if a is None or b is None or a.type.get_canonical().spelling != b.type.get_canonical().spelling:
                continue
            one, two, whole = self.piece(a), self.piece(b), self.piece(cursor)
            if not one or one == two or self.span(a)[1] > self.span(b)[0]:
                continue
            if cursor.spelling in ("max", "min", "hypot"):
                continue  # symmetric
            start = self.span(cursor)[0]
            head, between = whole[:self.span(a)[0] - start], whole[self.span(a)[1] - start:self.span(b)[0] - start]
            self.add(cursor, "swapped arguments", head + two + between + one + whole[self.span(b)[1] - start:])

    def statement(self, cursor, children):
        assignment = cursor.kind in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR) and len(children) == 2
        if assignment and self.operator(children) not in ASSIGNMENTS:
            return
        if assignment or cursor.kind == Kind.CALL_EXPR:
            self.add(cursor, "dropped statement", "", "statement")


def arguments_of(entry):
    """What libclang needs of a compile command."""
    words = entry["command"].split()
    keep = []
    for i, word in enumerate(words):
        if word.startswith(("-I", "-D", "-std")):
            keep.append(word.replace('\\"', '"'))
        elif word == "-isystem":
            keep += [word, words[i + 1]]
    return keep + ["-fno-math-errno", "-w", "-D_Bool=bool"]  # the last: headers of C


def overlap(a, b):
    return a.start < b.end and b.start < a.end


def rewrite(source, chosen):
    """The file with these mutants in it; sites do not overlap."""
    out = source
    for site in sorted(chosen, key=lambda s: -s.start):
        out = out[:site.start] + site.text().encode() + out[site.end:]
    if b"#pragma once" in out:
        return out.replace(b"#pragma once", b'#pragma once\n#include "hvi_mutant.hpp"', 1)
    return b'#include "hvi_mutant.hpp"\n#line 1\n' + out
