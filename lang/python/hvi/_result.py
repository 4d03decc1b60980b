"""What a run found: tables, fields, certificate."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._errors import Diagnostic, diagnostics_from

if TYPE_CHECKING:
    from collections.abc import Iterator, KeysView

    import pandas
    from matplotlib.tri import Triangulation

Array = np.ndarray


@dataclass(frozen=True)
class Grid:
    """The nodes of the finite element space and its cells.

    points: (nodes, dim), coordinates in the units of the script. cells: (cells, k), indices of points in the order of VTK.
    cell_type: "triangle", "triangle6", "tetra", "tetra10", "line", "line3", as meshio names them.
    """

    points: Array
    cells: Array
    cell_type: str

    def triangulation(self, displacement: Optional[Array] = None) -> Triangulation:
        """Of a mesh in 2D, for matplotlib (`ax.tripcolor(grid.triangulation(), values)`); triangles of second order are
        divided by four. `displacement`: (nodes, 2), added to the points."""
        from matplotlib.tri import Triangulation

        if not self.cell_type.startswith("triangle"):
            raise ValueError(f"cells are {self.cell_type}, not triangles")
        at = self.points if displacement is None else self.points + displacement
        parts = [[0, 1, 2]] if self.cell_type == "triangle" else [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
        return Triangulation(at[:, 0], at[:, 1], np.concatenate([self.cells[:, part] for part in parts]))


@dataclass
class Result:
    """A certified run.

    Columns of its tables are `result["reaction"]`, arrays with one value a row, in the units of the script; `result["t"]` are
    the times of the rows.
    """

    table: dict[str, Array]  #: "t" and every column: (rows,)
    final: dict[str, float]  #: every column at the end, or at its own time
    fields: dict[str, Array]  #: at the end, at `grid.points`: (nodes,) for scalars, else (nodes, components)
    grid: Grid
    certificate: dict[str, Any]  #: certified, inclusion, equilibrium, tolerance, mode, worst_step, ...
    params: dict[str, Any]  #: what the run was made with: parameter -> number or word
    diagnostics: tuple[Diagnostic, ...] = ()  #: warnings
    monitors: dict[str, Array] = field(default_factory=dict)  #: with monitors=True: energies and works by step: (steps,)
    kept_times: Array = field(default_factory=lambda: np.empty(0))  #: with keep_every: (kept,)
    kept: dict[str, Array] = field(default_factory=dict)  #: and each unknown then: (kept, nodes) or (kept, nodes, components)
    raw: dict[str, Any] = field(default_factory=dict)  #: everything, as hvi-result/1 (docs/schema)

    def __getitem__(self, column: str) -> Array:
        try:
            return self.table[column]
        except KeyError:
            raise KeyError(f"no column {column!r}; there are {', '.join(self.table)}") from None

    def __contains__(self, column: object) -> bool:
        return column in self.table

    def __iter__(self) -> Iterator[str]:
        """The names of the columns, t first."""
        return iter(self.table)

    def keys(self) -> KeysView[str]:
        """The names of the columns, t first: with this and `result[name]`, `dict(result)` is the table."""
        return self.table.keys()

    @property
    def certified(self) -> bool:
        """Is every step certified?"""
        return bool(self.certificate["certified"])

    @property
    def units(self) -> dict[str, str]:
        """Of t, columns, unknowns, sigma, states and parameters by their names ("mm", "MPa"; "1" for a number), as far as the script
        tells; empty for scripts without units."""
        return dict(self.raw.get("units", {}))

    @property
    def points(self) -> Array:
        """(nodes, dim)"""
        return self.grid.points

    @property
    def cells(self) -> Array:
        """(cells, k)"""
        return self.grid.cells

    @property
    def steps(self) -> int:
        return int(self.raw["steps"])

    @property
    def unknowns(self) -> int:
        return int(self.raw["unknowns"])

    @property
    def notes(self) -> list[dict[str, Any]]:
        """What the run tells of single steps: points released, branches, memories."""
        return list(self.raw.get("notes", []))

    def to_pandas(self) -> pandas.DataFrame:
        """The table with t as its index; `attrs["units"]` has its units where the script has some."""
        import pandas

        frame = pandas.DataFrame(self.table).set_index("t")
        if self.units:
            frame.attrs["units"] = {name: self.units[name] for name in self.table if name in self.units}
        return frame

    def __repr__(self) -> str:
        state = "certified" if self.certified else "NOT certified"
        values = ", ".join(f"{name} = {value:.6g}" for name, value in self.final.items())
        return f"<hvi.Result: {self.steps} steps, {self.unknowns} unknowns, {state}; {values}>"


def grid_from(answer: dict[str, Any]) -> Grid:
    return Grid(answer["points"], answer["cells"], answer["cell_type"])


def result_from(answer: dict[str, Any], params: dict[str, Any]) -> Optional[Result]:
    """None where the run failed before its first step."""
    raw = answer["data"]
    if not raw or "grid" not in answer:
        return None
    final = {name: float("nan") if value is None else value for name, value in raw["final"].items()}
    return Result(answer["table"], final, answer["fields"], grid_from(answer["grid"]), raw["certificate"], params,
                  diagnostics_from(answer["diagnostics"]), answer["monitors"], answer["kept_times"], answer["kept"], raw)
