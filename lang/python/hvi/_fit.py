"""Parameters of a script from measured curves."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np

from . import _hvi
from ._errors import Error
from ._model import Model, as_model
from ._result import Array, Result

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Start = Union[float, Sequence[float]]  #: a first guess, or (guess, least, most)


@dataclass
class Fit:
    """Parameters that fit, and how well they are known.

    Errors and intervals are those of linear least squares at the solution, with the noise that the residuals of each column show
    (Student's t, with the degrees of freedom of Satterthwaite where columns with noise of their own tell of one parameter). They are made for the logarithm of a parameter that keeps
    its sign, so an interval of a stiffness has no negative end. They are right as far as the curves depend on the logarithms almost
    linearly within the intervals and the noise of one value is independent of that of another.
    """

    values: dict[str, float]
    stderr: dict[str, float]
    intervals: dict[str, tuple[float, float]]  #: with the wanted confidence
    confidence: float
    covariance: Array  #: (parameters, parameters), in the order of `values`
    noise: dict[str, float]  #: standard deviation of the residuals, in the units of each column
    predicted: dict[str, Array]  #: by column, at the times of the data
    residuals: dict[str, Array]  #: data less predicted
    runs: int  #: how many were made
    message: str  #: why the search ended
    at_bounds: tuple[str, ...]  #: parameters that would go on beyond their bounds: they have no error (NaN)
    model: Model  #: with these values

    @property
    def correlation(self) -> Array:
        """(parameters, parameters); near 1 or -1 where the curves tell two parameters hardly apart."""
        sizes = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(sizes, sizes)

    def __str__(self) -> str:
        lines = [f"{'parameter':<16}{'value':>14}{'std. error':>14}   {100 * self.confidence:g} % interval"]
        for name, value in self.values.items():
            low, high = self.intervals[name]
            lines.append(f"{name:<16}{value:>14.6g}{self.stderr[name]:>14.2g}   [{low:.6g}, {high:.6g}]")
        for name in self.at_bounds:
            lines.append(f"{name} is at its bound: the data ask for a value beyond it, or do not determine it")
        return "\n".join([*lines, f"{self.runs} runs; {self.message}"])


WEIGHINGS = 8  #: at most; the noise that a fit shows is mostly that of the next one after two
ALONE = 10  #: so many values show the noise of their column


class _Curves:
    """The data. Residuals are divided by `sizes`: the noise, or, where none is given, the largest value of the curve. A column without
    given noise that is long enough to show its own is a group by itself, all the others together are one: a fit shows the noise of each
    group, and its sizes are multiplied by that."""

    def __init__(self, model: Model, data: Mapping[str, Sequence[ArrayLike]]):
        self.times: dict[str, Array] = {}
        self.values: dict[str, Array] = {}
        self.sizes: dict[str, Array] = {}
        own: list[str] = []  # columns that are a group
        for column, curve in data.items():
            if column not in model.columns:
                raise KeyError(f"no column {column!r}; the tables have {', '.join(model.columns)}")
            t, y = (np.asarray(part, dtype=float) for part in curve[:2])
            if t.ndim != 1 or t.shape != y.shape or not t.size:
                raise ValueError(f"{column}: times and values are two arrays of the same length")
            if not (np.isfinite(t).all() and np.isfinite(y).all()):
                raise ValueError(f"{column}: not a number among times and values")
            size = np.asarray(curve[2], dtype=float) if len(curve) > 2 else np.max(np.abs(y))
            if not np.all(size > 0):
                raise ValueError(f"{column}: the noise has to be positive" if len(curve) > 2 else f"{column}: all values are zero")
            if len(curve) <= 2 and len(y) >= ALONE:
                own.append(column)
            self.times[column], self.values[column], self.sizes[column] = t, y, np.broadcast_to(size, y.shape)
        self.own = own
        self.groups = np.concatenate([np.full(len(y), own.index(c) + 1 if c in own else 0) for c, y in self.values.items()])

    def __len__(self) -> int:
        return sum(map(len, self.values.values()))

    def predicted(self, result: Result) -> dict[str, Array]:
        out = {}
        for column, times in self.times.items():
            known = np.isfinite(result[column])  # of a table `from start` some have no value at the initial time
            t, values = result["t"][known], result[column][known]
            if not t.size:
                raise ValueError(f"{column}: the run has no value of it in any row")
            near = 1e-9 * abs(t[-1])
            if times.min() < t[0] - near or times.max() > t[-1] + near:
                early = times.min() < t[0] - near and bool(known[0])
                raise ValueError(f"{column}: the rows of a run have times from {t[0]:g} to {t[-1]:g}, the data from {times.min():g} to "
                                 f"{times.max():g}" + ("; `table .. from start` has a row at the initial time, too" if early else ""))
            out[column] = np.interp(times, t, values)
        return out

    def residuals(self, predicted: dict[str, Array]) -> Array:
        return np.concatenate([(self.values[c] - predicted[c]) / self.sizes[c] for c in self.values])

    def noise(self, r: Array, basis: Array) -> tuple[Array, Array]:
        """Of each value, as a multiple of its size, and its degrees of freedom: those of its group, less its part of the parameters. `basis`:
        orthonormal, of the space that the derivatives span."""
        taken = np.sum(basis**2, axis=1)
        sizes, freedom = np.empty_like(r), np.empty_like(r)
        for group in np.unique(self.groups):
            of = self.groups == group
            free = float(np.sum(of) - np.sum(taken[of]))
            if free < 1.0:  # it shows nothing of its own
                of_all = float(len(r) - np.sum(taken))
                sizes[of], freedom[of] = np.sqrt(float(r @ r) / of_all), of_all
            else:
                sizes[of], freedom[of] = np.sqrt(float(r[of] @ r[of]) / free), free
        return sizes, freedom

    def weigh(self, r: Array, basis: Array) -> bool:
        """Multiplies the sizes by the noise, but for 1e-6 of the largest value, below which it may be rounding. Have the weights of groups
        changed by more than a tenth against each other?"""
        noise, at, factors = self.noise(r, basis)[0], 0, []
        for c, y in self.values.items():
            factor = max(noise[at], 1e-6 * float(np.max(np.abs(y) / self.sizes[c]))) if c in self.own else max(noise[at], 1e-6)
            self.sizes[c] = factor * self.sizes[c]
            factors.append(factor)
            at += len(y)
        return max(factors) > 1.1 * min(factors)


class _Unknowns:
    """Parameters p as numbers z without units, 0 at the first guess: p = guess exp(z) where p keeps the sign of its guess, and
    p = guess + size z where its bounds let it change it."""

    FARTHEST = float(np.log(1e6))  #: a parameter without bounds stays within a factor of a million

    def __init__(self, model: Model, params: Mapping[str, Start]):
        self.names = list(params)
        self.guess, self.low, self.high = (np.empty(len(params)) for _ in range(3))
        for i, (name, start) in enumerate(params.items()):
            if name not in model.params:
                raise KeyError(f"no parameter {name!r}; the script has {', '.join(model.params)}")
            g, *bounds = np.atleast_1d(np.asarray(start, dtype=float)).tolist()
            least, most = bounds if bounds else (-np.inf, np.inf)
            limits = model.params[name].limits
            if limits is not None:
                least, most = max(least, limits[0]), min(most, limits[1])
            if not (least <= g <= most and least < most):
                raise ValueError(f"{name}: the guess {g:g} is not between {least:g} and {most:g}")
            self.guess[i], self.low[i], self.high[i] = g, least, most
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        self.signed = (self.guess != 0.0) & ~(bounded & (self.low < 0.0) & (self.high > 0.0))
        width = np.where(bounded, 0.5 * (self.high - self.low), 1.0)
        self.size = np.where(self.guess != 0.0, np.abs(self.guess), width)

    def values(self, z: Array) -> Array:
        return np.where(self.signed, self.guess * np.exp(z), self.guess + self.size * z)

    def params(self, z: Array) -> dict[str, float]:
        inside = np.clip(self.values(z), self.low, self.high)  # rounding at a bound
        return dict(zip(self.names, map(float, inside)))

    def slopes(self, z: Array) -> Array:
        """dp/dz"""
        return np.where(self.signed, self.values(z), self.size)

    def bounds(self) -> tuple[Array, Array]:
        """Of z."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([np.where(self.signed, np.log(np.maximum(end / self.guess, 0.0)), (end - self.guess) / self.size)
                             for end in (self.low, self.high)])
        ends.sort(axis=0)  # a negative guess
        return (np.where(self.signed, np.maximum(ends[0], -self.FARTHEST), ends[0]),
                np.where(self.signed, np.minimum(ends[1], self.FARTHEST), ends[1]))


class _Problem:
    """Residuals and their derivatives. The runs share mesh, matrices and factors, as far as the parameters leave them as they are."""

    def __init__(self, model: Model, unknowns: _Unknowns, curves: _Curves, tell: Callable[[int, float], None]):
        self.model, self.unknowns, self.curves, self.tell = model, unknowns, curves, tell
        self.low, self.high = unknowns.bounds()
        self.shared, self.runs = _hvi.Shared(), 0
        self.error = 0.0  #: of the columns, relative to their largest values
        self.known: Optional[tuple[Array, dict[str, Array]]] = None  #: the last run that was not for a derivative

    def run(self, z: Array) -> dict[str, Array]:
        self.runs += 1
        result = self.model._run(self.unknowns.params(z), shared=self.shared)
        predicted = self.curves.predicted(result)
        self.error = max(self.error, *(result_error(result, column) for column in predicted))
        return predicted

    def predicted(self, z: Array) -> dict[str, Array]:
        if self.known is None or not np.array_equal(self.known[0], z):
            self.known = (z.copy(), self.run(z))
        return self.known[1]

    def residuals(self, z: Array) -> Array:
        try:
            r = self.curves.residuals(self.predicted(z))
        except Error:
            if self.known is None:
                raise  # the first guess
            return np.full(len(self.curves), np.inf)  # too far: the trust region shrinks
        self.tell(self.runs, float(r @ r))
        return r

    def moved(self, z: Array, i: int, h: float) -> Optional[tuple[float, Array]]:
        """Residuals at z_i + h; None where a bound is nearer or the run fails."""
        there = z.copy()
        there[i] += h
        if not self.low[i] <= there[i] <= self.high[i]:
            return None
        try:
            return there[i], self.curves.residuals(self.run(there))
        except Error:
            return None

    def derivatives(self, z: Array, central: bool = False) -> Array:
        """By differences, whose step h weighs the runs' own relative error e against what is left out: h = e^(1/2) for one side, whose
        error is e/h + h, and h = e^(1/3) for both, with e/h + h^2; z has the size one."""
        here = self.curves.residuals(self.predicted(z))
        h = float(np.clip(self.error, 1e-14, 1e-6)) ** (1 / 3 if central else 1 / 2)
        columns = []
        for i in range(len(z)):
            ahead = self.moved(z, i, h)
            behind = self.moved(z, i, -h) if central or ahead is None else None
            if ahead is None and behind is None:
                raise ValueError(f"runs fail on both sides of {self.unknowns.names[i]} = {self.unknowns.values(z)[i]:g}, or its bounds are "
                                 "closer to each other than the steps of differences")
            (right, there), (left, back) = ahead or (z[i], here), behind or (z[i], here)
            columns.append((there - back) / (right - left))
        return np.stack(columns, axis=1)


def result_error(result: Result, column: str) -> float:
    """Of a column, by its largest value: what rounding makes of it, or what the steps' inequalities are certified to."""
    largest = float(np.nanmax(np.abs(result[column]))) or 1.0
    rounding = result.raw["forward_error"]["columns"].get(column, {}).get("absolute") or 0.0
    return max(rounding / largest, result.certificate["inclusion"], result.certificate["equilibrium"])


def _covariance(problem: _Problem, z: Array, free: Array) -> tuple[Array, Array]:
    """Of z, and the degrees of freedom of each standard error: NaN for parameters at their bounds. Satterthwaite's sum (Biometrics
    Bulletin 2 (1946) 110-114): a variance that is a sum of v_g, each estimated with n_g, has (sum v_g)^2 / sum v_g^2/n_g of them."""
    names = [name for name, one in zip(problem.unknowns.names, free) if one]
    out, freedom = np.full((len(z), len(z)), np.nan), np.full(len(z), np.nan)
    if not names:
        return out, freedom
    curves = problem.curves
    r = curves.residuals(problem.predicted(z))
    basis, s, v = np.linalg.svd(problem.derivatives(z, central=True)[:, free], full_matrices=False)
    if s[-1] <= max(1e-7, 10 * problem.error ** (2 / 3)) * s[0]:
        loose = [f"{weight:+.2g} {name}" for weight, name in zip(v[-1], names) if abs(weight) > 0.1]
        raise ValueError(f"the data do not determine the parameters: along {' '.join(loose)} (relative changes) nothing changes")
    noise, own = curves.noise(r, basis)
    of_value = (v.T / s) @ basis.T * noise  # what the noise of each value does to each parameter
    out[np.ix_(free, free)] = of_value @ of_value.T
    parts = np.stack([np.sum(of_value[:, curves.groups == g] ** 2, axis=1) for g in np.unique(curves.groups)], axis=1)
    each = np.array([own[curves.groups == g][0] for g in np.unique(curves.groups)])
    total = np.sum(parts, axis=1)[:, None]
    shares = np.divide(parts, total, out=np.full_like(parts, 1.0 / parts.shape[1]), where=total > 0)  # of exact data nothing is left
    freedom[free] = 1.0 / np.sum(shares**2 / each, axis=1)
    return out, freedom


def fit(model: Model, params: Mapping[str, Start], data: Mapping[str, Sequence[ArrayLike]], *, confidence: float = 0.95,
        progress: Optional[Callable[[int, float], None]] = None, **options: Any) -> Fit:
    """Finds parameters of a script by least squares, so that columns of its tables fit measured curves.

    params: {name: guess} or {name: (guess, least, most)}; the range that the script gives a parameter holds, too. A parameter keeps the
    sign of its guess, and without bounds stays within a factor of a million of it; bounds on both sides of zero let it change its sign.
    data: {column: (t, values)} or {column: (t, values, noise)}, arrays of one length, times within those of the run, in the units of
    the script; between the rows of a run its columns are linear. noise: the standard deviation of the values, or of each: how
    much they weigh; errors come from what is left. Columns without it get what a first fit leaves of them. progress: called with (runs, sum of squares). options: of
    scipy.optimize.least_squares (loss="soft_l1" forgives outliers, but intervals then do not hold).

    The trust region method of Branch, Coleman and Li (SIAM J. Sci. Comput. 21 (1999) 1-23), of SciPy, for the logarithms of parameters
    that keep their sign; the steps of finite differences come from the errors that the runs certify. A run that fails, for values far
    away, shortens the step. Raises ValueError where the data do not determine the parameters, and what the run at the first guess raises.
    """
    from scipy.optimize import least_squares
    from scipy.stats import t as student

    for what, given in (("parameters to find", params), ("measured curves", data)):
        if not given:
            raise ValueError(f"there are no {what}")
    unknowns, curves = _Unknowns(as_model(model), params), _Curves(model, data)
    if len(curves) <= len(params):
        raise ValueError(f"{len(curves)} values do not determine {len(params)} parameters and their errors")
    problem = _Problem(model, unknowns, curves, progress or (lambda runs, squares: None))

    def search(start: Array) -> Any:
        return least_squares(problem.residuals, start, jac=problem.derivatives, bounds=(problem.low, problem.high),
                             **{"xtol": 1e-8, "ftol": 1e-8, "gtol": 1e-10, **options})

    found = search(np.zeros(len(params)))
    for _ in range(WEIGHINGS if len(set(curves.groups)) > 1 else 0):
        basis = np.linalg.svd(found.jac, full_matrices=False)[0]
        if not curves.weigh(curves.residuals(problem.predicted(found.x)), basis):
            break
        found = search(found.x)
    predicted, free = problem.predicted(found.x), found.active_mask == 0
    covariance, freedom = _covariance(problem, found.x, free)
    stderr, slopes = np.sqrt(np.diag(covariance)), unknowns.slopes(found.x)
    reach = student.ppf(0.5 + confidence / 2, freedom) * stderr
    ends = np.sort(np.stack([unknowns.values(found.x - reach), unknowns.values(found.x + reach)]), axis=0)
    residuals = {c: curves.values[c] - predicted[c] for c in curves.values}
    values = unknowns.params(found.x)
    return Fit(values, dict(zip(unknowns.names, map(float, stderr * np.abs(slopes)))),
               {name: (float(low), float(high)) for name, low, high in zip(unknowns.names, *ends)}, confidence,
               covariance * np.outer(slopes, slopes), {c: float(np.sqrt(np.mean(rest**2))) for c, rest in residuals.items()}, predicted,
               residuals, problem.runs, found.message, tuple(n for n, one in zip(unknowns.names, free) if not one), model.at(**values))
