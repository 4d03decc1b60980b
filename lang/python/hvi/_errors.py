"""What goes wrong, as exceptions that carry the diagnostics of the script."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:
    from ._result import Result


@dataclass(frozen=True)
class Diagnostic:
    """One message about a script, as `hvi-run check` prints it.

    `code` ("E0301") has a section in docs/diagnostics.md. `line` and `column` count from 1 and are None where the message
    has no place; the end is the place behind the last character.
    """

    code: str
    severity: str  #: "error", "warning" or "note"
    message: str
    file: Optional[str] = None
    line: Optional[int] = None
    column: Optional[int] = None
    end_line: Optional[int] = None
    end_column: Optional[int] = None
    label: str = ""
    notes: tuple[str, ...] = ()
    help: str = ""
    secondary: tuple[dict[str, Any], ...] = field(default=(), hash=False)

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}: " if self.line is not None else ""
        return f"{place}{self.severity}[{self.code}]: {self.message}" + (f" (help: {self.help})" if self.help else "")


def diagnostics_from(rows: list[dict[str, Any]]) -> tuple[Diagnostic, ...]:
    names = Diagnostic.__dataclass_fields__
    tuples = ("notes", "secondary")
    return tuple(Diagnostic(**{k: tuple(v or ()) if k in tuples else v for k, v in row.items() if k in names}) for row in rows)


class Error(Exception):
    """A script, or a run of it, that failed. `str(error)` is what the command prints, with the lines of the script."""

    def __init__(self, text: str, diagnostics: tuple[Diagnostic, ...], partial: Optional[Result] = None):
        super().__init__(text, diagnostics, partial)  # all of them, so that it can be pickled
        self.text = text
        self.diagnostics = diagnostics  #: all of them, warnings too
        self.partial = partial  #: of a run that failed: the result up to its last good step, else None

    def __str__(self) -> str:
        return self.text.rstrip()

    @property
    def code(self) -> str:
        """The code of the first error."""
        return next((d.code for d in self.diagnostics if d.severity == "error"), "")


class ScriptError(Error):
    """The script has a mistake: it would fail on every machine."""


class SolveError(Error):
    """The script is right, and this run of it has no certified result."""


EXIT_SCRIPT, EXIT_USAGE, EXIT_SOLVE, EXIT_INTERRUPTED = 1, 2, 3, 130


def refuse(answer: dict[str, Any], partial: Optional[Result] = None) -> None:
    """Raises what an answer of the module says."""
    if answer["exit"] == 0:
        return
    if answer["exit"] == EXIT_INTERRUPTED:
        raise KeyboardInterrupt
    kind = ScriptError if answer["exit"] == EXIT_SCRIPT else SolveError
    raise kind(answer["text"], diagnostics_from(answer["diagnostics"]), partial)
