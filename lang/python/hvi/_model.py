"""Scripts, their runs, and runs taken step by step."""
from __future__ import annotations

import json
import operator
import os
import pathlib
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping, Optional, Union

from . import _hvi
from ._errors import EXIT_INTERRUPTED, EXIT_SCRIPT, EXIT_USAGE, Error, ScriptError, SolveError, diagnostics_from, refuse
from ._result import Array, Grid, Result, grid_from, result_from

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._fit import Fit
    from ._sweep import Sweep

Value = Union[int, float, str]
Progress = Callable[[int, int, float], None]  #: step, steps, CPU seconds so far


def as_given(name: str, value: Value) -> str:
    """A value of a parameter as a script reads it, with all its digits."""
    if isinstance(value, str):
        return value
    number = value.item() if getattr(value, "size", 0) == 1 else value  # of NumPy
    if isinstance(number, (bool, int)):
        return repr(int(number))
    try:
        return repr(float(number))
    except TypeError:
        raise TypeError(f"the parameter {name!r} is a number or a word, not {value!r}") from None


def as_count(name: str, value: Any) -> int:
    """A number of steps; 0: none."""
    try:
        count = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is a whole number of steps, not {value!r}") from None
    if not 0 <= count < 2**31:
        raise ValueError(f"{name} is a number of steps, not {value!r}")
    return count


def as_positive(name: str, value: Any) -> float:
    """A number above zero."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is a number, not {value!r}") from None
    if not number > 0.0:
        raise ValueError(f"{name} is a number above 0, not {value!r}")
    return number


def as_name(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name} is a name, not {value!r}")
    return value


@dataclass(frozen=True)
class Parameter:
    """A parameter of a script. `range` and `doc` as written there, "" where there is none; `value` and `range` are in `unit`, the one
    in which it is declared ("GPa"), "" for numbers and in scripts without units."""

    name: str
    value: Union[float, str]
    range: str = ""
    doc: str = ""
    unit: str = ""

    @property
    def limits(self) -> Optional[tuple[float, float]]:
        """The range as numbers; None where there is none."""
        if not self.range:
            return None
        least, greatest = json.loads(self.range)
        return float(least), float(greatest)


@dataclass(frozen=True)
class Check:
    """The hypotheses of the existence theorem as numbers: what `hvi-run check` prints."""

    discrete: bool  #: has every step exactly one solution on this mesh, by proof?
    continuous: bool  #: does a theorem apply, as far as a mesh and its refinement can tell?
    text: str
    raw: dict[str, Any]  #: everything, as hvi-check/1

    def __str__(self) -> str:
        return self.text


class Model:
    """A script with values of its parameters. Models do not change: `model.at(n=32)` is another one.

    It may be used by several threads at once, each run is by itself. Runs release Python's lock; while they go on OpenBLAS has one
    thread in this process.
    """

    def __init__(self, path: str, text: Optional[str] = None, allow_geo: bool = False, params: Optional[Mapping[str, Value]] = None):
        self.path, self.text, self.allow_geo = path, text, allow_geo
        self._given = dict(params or {})
        self._model = _hvi.Model(path, text, allow_geo)
        self._described = self._model.describe(self._defines())
        refuse(self._described)

    def __getstate__(self) -> dict[str, Any]:
        return {"path": self.path, "text": self.text, "allow_geo": self.allow_geo, "params": self._given}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(**state)  # type: ignore[misc]

    def __repr__(self) -> str:
        values = "".join(f", {p.name} = {p.value}" + (f" [{p.unit}]" if p.unit else "") for p in self.params.values())
        return f"<hvi.Model {self.path}{values}>"

    def _defines(self, params: Optional[Mapping[str, Value]] = None) -> dict[str, str]:
        return {name: as_given(name, value) for name, value in {**self._given, **(params or {})}.items()}

    @property
    def params(self) -> dict[str, Parameter]:
        """Parameters by name."""
        return {p["name"]: Parameter(**p) for p in self._described["data"]["params"]}

    @property
    def columns(self) -> list[str]:
        """Names of the columns of its tables, without t."""
        return list(self._described["data"]["columns"])

    @property
    def units(self) -> dict[str, str]:
        """Of t, columns, unknowns, sigma, states and parameters by their names ("mm", "MPa"; "1" for a number), as far as the script
        tells; empty for scripts without units. Those of a run are in `result.units`."""
        return dict(self._described["data"]["units"])

    def at(self, **params: Value) -> Model:
        """The same script with other values of these parameters."""
        return Model(self.path, self.text, self.allow_geo, {**self._given, **params})

    def run(self, *, progress: Optional[Progress] = None, output: Union[str, os.PathLike[str], None] = None, monitors: bool = False,
            keep_every: int = 0, accuracy: float = 0.0, accuracy_of: str = "", budget: float = 3600.0, **params: Value) -> Result:
        """All steps, certified. Raises ScriptError, SolveError (with `partial`), or KeyboardInterrupt after the step in which
        Ctrl-C came.

        params: parameters of the script, `model.run(n=32)`. progress: called with (step, steps, CPU seconds) some twenty times a
        second. output: a folder for the files that the command writes. monitors: energies by step. keep_every: the unknowns at
        every so many steps, in `result.kept`. accuracy, accuracy_of, budget: as `hvi-run --accuracy --of --budget`; the run is then
        the cheapest that has this relative error.
        """
        return self._run(params, progress, output, monitors, keep_every, accuracy, accuracy_of, budget)

    def _run(self, params: Mapping[str, Value], progress: Optional[Progress] = None, output: Any = None, monitors: bool = False,
             keep_every: int = 0, accuracy: float = 0.0, accuracy_of: str = "", budget: float = 3600.0, shared: Any = None) -> Result:
        if progress is not None and not callable(progress):
            raise TypeError(f"progress is a function of (step, steps, seconds), not {progress!r}")
        how = {"output": os.fsdecode(output) if output is not None else "", "monitors": bool(monitors),
               "keep_every": as_count("keep_every", keep_every), "accuracy": as_positive("accuracy", accuracy) if accuracy != 0 else 0.0,
               "accuracy_of": as_name("accuracy_of", accuracy_of), "budget": as_positive("budget", budget)}
        answer = self._model.run(self._defines(params), how, progress, shared)
        result = result_from(answer, answer["data"].get("params", {}) if answer["data"] else {})
        refuse(answer, result)
        assert result is not None
        return result

    def steps(self, **params: Value) -> Steps:
        """A run that is taken step by step: `for step in model.steps(): ...`"""
        defines = self._defines(params)
        return Steps(self._model.steps(defines), defines)

    def check(self, **params: Value) -> Check:
        """Judges the hypotheses of the theorem for these parameters."""
        answer = self._model.check(self._defines(params))
        refuse(answer)
        data = answer["data"]
        verdict = data["verdict"]
        return Check(verdict["discrete"]["holds"], verdict["continuous"]["holds"], data.pop("text"), data)

    def plan(self, **params: Value) -> dict[str, Any]:
        """What a run would do and cost, from its first steps, as hvi-plan/1 (docs/schema): effects, matrices, predicted CPU seconds
        and bytes."""
        answer = self._model.plan(self._defines(params))
        refuse(answer)
        return dict(answer["data"])

    def study(self, *, output: Union[str, os.PathLike[str], None] = None, **params: Value) -> dict[str, Any]:
        """The study of the script, as hvi-study/1 (docs/schema). It is `hvi-run study` in a process of its own, since it measures CPU
        time and memory, which a process has once. output: a folder for its files and its journal, from which a study that was stopped
        goes on."""
        if self.text is not None:
            raise ValueError("a study needs a script in a file")
        with tempfile.TemporaryDirectory() as folder:
            words = [program(), "study", self.path, "-o", os.fspath(output) if output is not None else folder, "--json", "-",
                     "--diagnostics", "json"]
            for name, value in self._defines(params).items():
                words += ["-D", f"{name}={value}"]
            done = subprocess.run(words + (["--allow-geo"] if self.allow_geo else []), capture_output=True, text=True, check=False)
        if done.returncode != 0:
            rows = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
            kind = ScriptError if done.returncode in (EXIT_SCRIPT, EXIT_USAGE) else SolveError  # it has no study
            said = "\n".join(str(d) for d in diagnostics_from(rows)) or done.stderr
            raise kind(said, diagnostics_from(rows))
        return dict(json.loads(done.stdout))

    def sweep(self, **ladders: Any) -> Sweep:
        """See hvi.sweep."""
        from ._sweep import sweep

        return sweep(self, **ladders)

    def fit(self, params: Mapping[str, Any], data: Mapping[str, tuple[ArrayLike, ArrayLike]], **more: Any) -> Fit:
        """See hvi.fit."""
        from ._fit import fit

        return fit(self, params, data, **more)


def as_model(model: Any) -> Model:
    if not isinstance(model, Model):
        raise TypeError(f"a model is loaded first, as hvi.load('slab.hvi'): this is {model!r}")
    return model


def program() -> str:
    """Where hvi-run is: beside this package in the build tree or where it is installed, else on the path."""
    package = pathlib.Path(_hvi.__file__).resolve().parent
    beside = (package.parents[1] / "hvi-run", package.parents[3] / "bin" / "hvi-run")
    found = next((str(path) for path in beside if path.is_file()), None) or shutil.which("hvi-run")
    if found is None:
        raise FileNotFoundError("hvi-run is neither beside the package hvi nor on the path")
    return found


@dataclass(frozen=True)
class Step:
    """A certified step. `values`: every column of the tables here, NaN where its own time has not come. `fields`: each unknown at
    the points of `steps.grid`."""

    number: int
    t: float
    values: dict[str, float]
    fields: dict[str, Array]

    def __getitem__(self, column: str) -> float:
        return self.values[column]

    def __contains__(self, column: object) -> bool:
        return column in self.values


class Steps:
    """The steps of a run, one after the other: the next one is computed when it is asked for, so that another program can use each
    before the next, and answer with `set`. A loop that is left early leaves the run where it is: it can go on, or be concluded.
    """

    def __init__(self, stepping: Any, defines: Mapping[str, str]):
        self._stepping = stepping
        self._defines = dict(defines)
        self._failed = False
        self._error: Optional[Error] = None
        self._result: Optional[Result] = None
        self._described = stepping.start()
        refuse(self._described)
        self.grid: Grid = grid_from(stepping.grid())  #: of all fields

    @property
    def params(self) -> dict[str, Parameter]:
        """Parameters by name, with the values that the next step has."""
        return {p["name"]: Parameter(**p) for p in self._described["data"]["params"]}

    def set(self, **params: Value) -> None:
        """Values of parameters from the next step on, each in the unit in which the script declares it: `steps.set(load=2.5)`. Others
        stay as they are.

        Free to change is what enters loads, imposed values, bounds and other numbers of laws, coefficients of forms, and rates of
        states. The past stays what it was: displacements, states, and what memories have summed up. Certificates judge each step with
        the values it had. Where only loads or imposed values change, matrices and factors are kept.

        Raises ScriptError, and changes nothing, where the script has no such parameter (with the names of those it has), where a value
        is no value of its kind or out of its range, and where it would change what a run cannot change on its way: the mesh, the
        unknowns, the times, initial values, a memory's kernel. Set before the first step where a parameter will be set at all: a run
        that held its contact unknowns only takes its steps once more.
        """
        if self._failed or self._result is not None:
            raise ValueError("the run has ended: begin another with model.steps()")
        given = {**self._defines, **{name: as_given(name, value) for name, value in params.items()}}
        answer = self._stepping.set(given)
        refuse(answer)
        self._defines, self._described = given, answer

    def __len__(self) -> int:
        """How many steps the run has."""
        return int(self._stepping.steps)

    def __iter__(self) -> Iterator[Step]:
        return self

    def __next__(self) -> Step:
        step = self.advance()
        if step is None:
            raise StopIteration
        return step

    def advance(self) -> Optional[Step]:
        """The next step; None when there is none. Raises SolveError at a step without a certificate, with the result so far."""
        if self._failed or self._result is not None:
            return None
        try:
            answer, more = self._stepping.advance()
            if answer["exit"] != 0:
                self._failed = True
                so_far = self._conclude()[1]
                if answer["exit"] == EXIT_INTERRUPTED:
                    self._result = so_far
                refuse(answer, so_far)
        except KeyboardInterrupt:
            self._failed = True
            raise
        except Error as error:
            self._error = error
            raise
        if not more:
            return None
        return Step(self._stepping.step, self._stepping.t, dict(self._stepping.values()), self._stepping.fields())

    def _conclude(self) -> tuple[dict[str, Any], Optional[Result]]:
        answer = self._stepping.conclude()
        return answer, result_from(answer, answer["data"].get("params", {}) if answer["data"] else {})

    def result(self) -> Result:
        """What is known after the steps so far, as of Model.run; no step can be taken after it. Certified where all were taken. Raises
        what a step has failed with."""
        if self._error is not None:
            raise self._error
        if self._result is None:
            answer, found = self._conclude()
            refuse(answer, found)
            if found is None:
                raise ValueError("no step has been taken")
            self._result = found
        return self._result


def load(path: Union[str, os.PathLike[str]], *, allow_geo: bool = False, **params: Value) -> Model:
    """Reads a script. Raises ScriptError, with every mistake in it, where it has one. `allow_geo`: it may mesh geometry files of
    gmsh, which can run programs."""
    return Model(os.fspath(path), None, allow_geo, params)


def loads(text: str, *, folder: Union[str, os.PathLike[str]] = ".", allow_geo: bool = False, **params: Value) -> Model:
    """A script as a text. Files that it reads lie below `folder`."""
    return Model(os.path.join(os.fspath(folder), "script.hvi"), text, allow_geo, params)


__all__ = ["Check", "Error", "Model", "Parameter", "Step", "Steps", "load", "loads", "program"]
