"""The same script at many values of its parameters, in several processes."""
from __future__ import annotations

import itertools
import numbers
import os
import pathlib
import pickle
import subprocess
import sys
import threading
import time
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Callable, Iterable, Optional, Union

import numpy as np

from ._errors import Error
from ._model import Model, Value, as_model
from ._result import Array, Result

if TYPE_CHECKING:
    import pandas


@dataclass
class Sweep:
    """Runs of a sweep, in the order of the combinations: the last parameter varies fastest."""

    params: list[dict[str, Value]]  #: of each run
    final: list[dict[str, float]]  #: every column at the end; empty for a run that failed
    errors: list[Optional[Exception]]  #: why a run failed; None: it is certified
    seconds: Array  #: CPU seconds of each run; NaN for one that failed
    results: list[Optional[Result]] = field(default_factory=list)  #: with results=True

    def __len__(self) -> int:
        return len(self.params)

    def __getitem__(self, name: str) -> Array:
        """A parameter, or a column at the end, over the runs: (runs,); NaN where a run failed."""
        if self.params and name in self.params[0]:
            return np.array([p[name] for p in self.params])
        if not any(name in row for row in self.final):
            raise KeyError(f"neither a parameter of this sweep nor a column of a run: {name!r}")
        return np.array([row.get(name, np.nan) for row in self.final])

    def __contains__(self, name: object) -> bool:
        return any(name in row for row in (*self.params, *self.final))

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each run: parameters, columns at the end, CPU seconds. A column with the name of a parameter is `columns.NAME`;
        what is called `seconds` keeps its name, and the CPU seconds are `run.seconds`."""
        import pandas

        rows = [{**p, **{f"columns.{name}" if name in p else name: value for name, value in row.items()}} for p, row in zip(self.params, self.final)]
        own = "run.seconds" if any("seconds" in row for row in rows) else "seconds"
        return pandas.DataFrame([{**row, own: s} for row, s in zip(rows, self.seconds)])


class _Bar:
    """A bar on a terminal; nothing elsewhere."""

    def __init__(self, total: int):
        self.total, self.start = total, time.monotonic()

    def __call__(self, done: int, total: int) -> None:
        if not sys.stderr.isatty():
            return
        passed = time.monotonic() - self.start
        left = f"{passed / done * (total - done):.0f} s left" if 0 < done < total else ""
        filled = 30 * done // max(total, 1)
        print(f"\r\033[K[{'#' * filled}{'.' * (30 - filled)}] {done} of {total} {left}", end="" if done < total else "\n", file=sys.stderr,
              flush=True)


class _Processes:
    """One process for each thread that asks."""

    def __init__(self) -> None:
        self._own, self._all, self._guard = threading.local(), [], threading.Lock()  # type: ignore[var-annotated]

    def _process(self) -> subprocess.Popen[bytes]:
        if not hasattr(self._own, "process"):
            here = str(pathlib.Path(__file__).resolve().parent.parent)
            paths = os.pathsep.join(p for p in (here, os.environ.get("PYTHONPATH", "")) if p)
            process = subprocess.Popen([sys.executable, "-m", "hvi._worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                       env={**os.environ, "PYTHONPATH": paths})
            self._own.process = process
            with self._guard:
                self._all.append(process)
        return self._own.process  # type: ignore[no-any-return]

    def run(self, model: Model, params: dict[str, Value], keeps: bool) -> Any:
        process = self._process()
        assert process.stdin and process.stdout
        try:
            pickle.dump((model, params, keeps), process.stdin)
            process.stdin.flush()
            return pickle.load(process.stdout)
        except (EOFError, BrokenPipeError, pickle.UnpicklingError):
            code = process.wait()
            del self._own.process
            return RuntimeError(f"the process of this run ended with code {code}" + (" (out of memory?)" if code == -9 else ""))

    def end(self) -> None:
        with self._guard:
            for process in self._all:
                process.kill()  # it writes no files
                process.communicate()


def combinations(ladders: dict[str, Iterable[Value]]) -> list[dict[str, Value]]:
    def is_one(value: Any) -> bool:
        return isinstance(value, (str, numbers.Number)) or getattr(value, "ndim", None) == 0  # of NumPy

    values = {name: [one] if is_one(one) else list(one) for name, one in ladders.items()}
    return [dict(zip(values, chosen)) for chosen in itertools.product(*values.values())]


def sweep(model: Model, *, processes: Optional[int] = None, progress: Union[bool, Callable[[int, int], None]] = True,
          results: bool = False, **ladders: Any) -> Sweep:
    """Runs every combination: `hvi.sweep(model, n=[8, 16], E=[70, 210])`.

    processes: how many at once; as many as there are processors. progress: a bar on the terminal, or a function of (done, total).
    results: keep every Result (`sweep.results`), with its fields. Each run has the bits it has by itself. A run that fails is
    in `errors`, the others go on; a mistake of the script that is there for all runs was raised when the model was loaded.
    """
    as_model(model)
    all_params = combinations(ladders)
    tell = _Bar(len(all_params)) if progress is True else progress or (lambda done, total: None)
    workers = _Processes()
    at_once = max(1, min(processes or len(os.sched_getaffinity(0)), len(all_params)))
    with ThreadPoolExecutor(at_once) as pool:
        futures: list[Future[Any]] = []
        try:
            tell(0, len(all_params))
            futures = [pool.submit(workers.run, model, params, results) for params in all_params]
            waiting = set(futures)
            while waiting:
                _, waiting = wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED)
                tell(len(futures) - len(waiting), len(futures))
        finally:  # Ctrl-C too
            for future in futures:
                future.cancel()
            workers.end()
    return _gathered(all_params, [future.result() for future in futures], results)


def _gathered(all_params: list[dict[str, Value]], answers: list[Any], results: bool) -> Sweep:
    out = Sweep(all_params, [], [], np.full(len(answers), np.nan))
    for i, answer in enumerate(answers):
        failed = isinstance(answer, Exception)
        if failed and not isinstance(answer, (Error, RuntimeError, MemoryError)):
            raise answer
        out.errors.append(answer if failed else None)
        if results:
            out.results.append(None if failed else answer)
        if failed:
            out.final.append({})
        elif results:
            out.final.append(answer.final)
            out.seconds[i] = answer.raw["timing"]["total"]
        else:
            out.final.append(answer[0])
            out.seconds[i] = answer[2]
    return out
