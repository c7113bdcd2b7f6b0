"""Results: tables with units, errors and predictions, figures, and their merging."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _carom
from ._errors import MeasureError
from ._html import escape, rows, with_error
from ._plain import array, word
from ._scene import Scene

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas  # type: ignore[import-untyped,unused-ignore]
    import polars
    import xarray
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Column", "Figure", "Results", "Table", "estimate", "open_run"]


@dataclass(frozen=True)
class Figure:
    """A measured number with its standard error and, where theory has one, its prediction.

    Attributes
    ----------
    name : str
        Name of the quantity.
    value : float
        Measured value.
    standard_error : float or None
        Its standard error, from blocks of time and from replicas.
    unit : str
        Unit, in the scene's units of mass, length and time; ``"1"`` for a pure number.
    prediction : float or None
        Predicted value.
    source : str or None
        Source of the prediction.
    stationary : bool or None
        Whether no change was found during the measurement; ``None`` if that was not judged.

    Examples
    --------
    >>> from carom import Figure
    >>> print(Figure("pressure", 1.234567, 0.012, "mass/time²", None, None))
    pressure: 1.235 ± 0.012 mass/time²
    >>> print(Figure("pressure", 9.285, 0.029, "mass/time²", None, None, stationary=False))
    pressure: 9.285 ± 0.029 mass/time² (not stationary)
    """

    __module__ = "carom"

    name: str
    value: float
    standard_error: float | None
    unit: str
    prediction: float | None
    source: str | None
    stationary: bool | None = None

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        predicted = "" if self.prediction is None else f" (predicted: {self.prediction:.6g})"
        changing = " (not stationary)" if self.stationary is False else ""
        value = with_error(self.value, self.standard_error)
        return f"{self.name}: {value}{unit}{predicted}{changing}"

    def _repr_html_(self) -> str:
        return rows(_FIGURE, [_cells(self)])


def estimate(
    values: ArrayLike, weights: ArrayLike | None = None, *, name: str = "mean", unit: str = "1"
) -> Figure:
    """The mean of a series of your own, with the standard error of the measures.

    The error is that of blocks of time, with their correlation: samples may be closer than the
    system forgets.

    Parameters
    ----------
    values : array_like, shape (n,)
        The series, at equal intervals of time.
    weights : array_like, shape (n,), optional
        Positive weights, such as the number of bodies of each sample. Default: 1.
    name, unit : str
        Name and unit of the figure.

    Returns
    -------
    Figure
        ``standard_error`` is None with fewer than two values, ``stationary`` with fewer than 32.

    Raises
    ------
    ValueError
        The series is empty, has values that are not finite, or weights that are not positive.

    Examples
    --------
    >>> import carom
    >>> print(carom.estimate([1.0, 1.2, 0.9, 1.1], name="speed", unit="length/time"))
    speed: 1.050 ± 0.065 length/time
    """
    series = array("values", values)
    if series.ndim != 1 or not len(series):
        raise ValueError(f"`values` must be a series of at least one number, but has shape {series.shape}")
    weight = np.ones_like(series) if weights is None else array("weights", weights)
    if weight.shape != series.shape:
        raise ValueError(f"`weights` must have shape {series.shape}, but has {weight.shape}")
    if (weight <= 0).any():
        raise ValueError(f"`weights` must be positive, but the smallest is {weight.min()}")
    value, error, stationary = _carom.mean_of_series(series, weight)
    return Figure(word("name", name), value, error, word("unit", unit), None, None, stationary)


_FIGURE = ["figure", "value", "unit", "prediction", "source"]


def _cells(figure: Figure) -> list[str]:
    predicted = "" if figure.prediction is None else f"{figure.prediction:.6g}"
    value = with_error(figure.value, figure.standard_error)
    return [figure.name, value, figure.unit, predicted, figure.source or ""]


@dataclass(frozen=True)
class Column:
    """A column of a :class:`Table`.

    Attributes
    ----------
    name, label : str
        Name in files, and in the legend of a chart.
    unit : str
        Unit, in the scene's units of mass, length and time; ``"1"`` for a pure number.
    role : str
        ``"abscissa"``, ``"count"``, ``"quantity"``, ``"value"``, ``"derived"``,
        ``"standard error"`` or ``"prediction"``; an error and a prediction belong to the value
        before.
    source : str or None
        Source of a prediction.
    values : numpy.ndarray
        The values; NaN where there is none.

    Examples
    --------
    >>> import carom
    >>> sim = carom.Simulation({"gas": [{"radius": 0.02, "mass": 1, "energy": 1, "count": 20}]})
    >>> temperature = sim.measure("temperature", every=0.1)
    >>> sim.run(until=1)
    >>> column = temperature.table.columns["translation"]
    >>> column.role, column.unit
    ('value', 'mass·length²/time²')
    """

    __module__ = "carom"

    name: str
    label: str
    unit: str
    role: str
    source: str | None
    values: NDArray[np.float64]


class Table:
    """A measured curve: columns with units, standard errors and predictions.

    ``table["name"]`` is a column as an array, and ``+`` merges the runs of two tables of one
    measure.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> scene = carom.Scene(gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 50})
    >>> sim = carom.Simulation(scene)
    >>> speeds = sim.measure("velocities", every=0.1)
    >>> sim.run(until=2)
    >>> table = speeds.table
    >>> list(table)[:3]
    ['time', 'bodies', 'mean_square']
    >>> table.predictions["kurtosis"].shape == table["kurtosis"].shape
    True
    """

    __module__ = "carom"
    __slots__ = ("_levels", "_logarithmic", "_results", "caption", "columns", "name", "title")

    def __init__(self, results: Results, plain: _carom._Table) -> None:
        self._results = results
        self.name: str = plain["name"]
        self.title: str = plain["title"]
        self.caption: str = plain["caption"]
        self.columns: dict[str, Column] = {}
        for entry in plain["columns"]:
            column = Column(*entry)
            column.values.setflags(write=False)
            self.columns[column.name] = column
        self._logarithmic = plain["logarithmic"]
        self._levels = plain["levels"]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        try:
            return self.columns[name].values
        except KeyError:
            known = ", ".join(self.columns)
            raise KeyError(f"{name!r}; the columns of {self.name} are {known}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return max((len(column.values) for column in self.columns.values()), default=0)

    def __add__(self, other: Table) -> Table:
        if not isinstance(other, Table):
            return NotImplemented
        merged = self._results + other._results
        if self.name not in merged.tables or other.name != self.name:
            raise MeasureError(f"the tables {self.name} and {other.name} are not of one measure")
        return merged.tables[self.name]

    def __radd__(self, other: object) -> Table:
        # So that `sum(tables)` works, which begins with 0.
        return self if isinstance(other, int) and other == 0 else NotImplemented

    @property
    def results(self) -> Results:
        """The results that the table belongs to.

        Examples
        --------
        >>> table.name in table.results
        True
        """
        return self._results

    @property
    def abscissa(self) -> str:
        """Name of the column that the others depend on.

        Examples
        --------
        >>> table.abscissa
        'time'
        """
        return next(name for name, column in self.columns.items() if column.role == "abscissa")

    def grid(self, name: str) -> NDArray[np.float64]:
        """A column of a table over the cells of a grid, such as that of the measure ``fields``.

        Parameters
        ----------
        name : str
            Name of the column.

        Returns
        -------
        numpy.ndarray, shape (rows, columns)
            The values; the first row has the least y, the first column the least x.

        Raises
        ------
        ValueError
            The table is not over a grid.

        Examples
        --------
        >>> sim.measure("fields", columns=4, rows=3).results["fields"].grid("density").shape
        (3, 4)
        """
        places = [column for column in self.columns.values() if column.role == "abscissa"]
        if len(places) != 2:
            raise ValueError(f"the table {self.name} is not over a grid: it has {len(places)} abscissa")
        return self[name].reshape(-1, int(np.sum(places[1].values == places[1].values[0])))

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column.

        Examples
        --------
        >>> table.units["mean_square"]
        'length²/time²'
        """
        return {name: column.unit for name, column in self.columns.items()}

    @property
    def errors(self) -> dict[str, NDArray[np.float64]]:
        """Standard errors of each measured column that has them.

        Examples
        --------
        >>> list(table.results["speeds"].errors)
        ['density']
        """
        return dict(self._of_values("standard error"))

    @property
    def predictions(self) -> dict[str, NDArray[np.float64]]:
        """Prediction of each measured column that has one.

        Examples
        --------
        >>> sorted(table.predictions)
        ['h_y', 'kurtosis']
        """
        return dict(self._of_values("prediction"))

    @property
    def sources(self) -> dict[str, str]:
        """Source of the prediction of each column that has one.

        Examples
        --------
        >>> "kurtosis" in table.sources
        True
        """
        levels = {column: source for column, _, _, source in self._levels}
        return levels | {
            name: column.source or ""
            for name, column in self._belonging()
            if column.role == "prediction"
        }

    def _belonging(self) -> Iterator[tuple[str, Column]]:
        """Each error and prediction with the name of its value."""
        value = ""
        for name, column in self.columns.items():
            if column.role == "value":
                value = name
            elif column.role in ("standard error", "prediction"):
                yield value, column

    def _of_values(self, role: str) -> Iterator[tuple[str, NDArray[np.float64]]]:
        if role == "prediction":
            for column, _, level, _ in self._levels:
                yield column, np.full(len(self), level)
        yield from ((name, column.values) for name, column in self._belonging() if column.role == role)

    def to_numpy(self) -> NDArray[np.void]:
        """All columns as a structured array.

        Returns
        -------
        numpy.ndarray
            One field of type float64 for each column; NaN where there is no value.

        Examples
        --------
        >>> table.to_numpy().dtype.names == tuple(table)
        True
        """
        array = np.full(len(self), np.nan, dtype=[(name, np.float64) for name in self.columns])
        for name, column in self.columns.items():
            array[name][: len(column.values)] = column.values
        return array

    def to_pandas(self) -> pandas.DataFrame:
        """All columns as a data frame; ``attrs["units"]`` has their units. Needs pandas.

        Examples
        --------
        >>> frame = table.to_pandas()
        >>> frame.attrs["units"]["mean_square"]
        'length²/time²'
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("`to_pandas` needs pandas: pip install pandas") from error
        frame = pandas.DataFrame({name: self.to_numpy()[name] for name in self.columns})
        frame.attrs.update(units=self.units, title=self.title)
        return frame

    def to_polars(self) -> polars.DataFrame:
        """All columns as a data frame of polars, with nulls where there is no value. Needs polars.

        Examples
        --------
        >>> table.to_polars().columns == list(table.columns)
        True
        """
        try:
            import polars
        except ImportError as error:
            raise ImportError("`to_polars` needs polars: pip install polars") from error
        rows = self.to_numpy()
        return polars.DataFrame({name: rows[name] for name in self.columns}, nan_to_null=True)

    def to_xarray(self) -> xarray.Dataset:
        """All columns over the abscissa, with their units as attributes. Needs xarray.

        Over a grid, which has two, the dimension is ``"cell"``.

        Examples
        --------
        >>> table.to_xarray()["mean_square"].attrs["units"]
        'length²/time²'
        """
        try:
            import xarray
        except ImportError as error:
            raise ImportError("`to_xarray` needs xarray: pip install xarray") from error
        rows = self.to_numpy()
        places = [name for name, column in self.columns.items() if column.role == "abscissa"]
        along = places[0] if len(places) == 1 else "cell"
        of = {
            name: (along, rows[name], {"units": column.unit, "long_name": column.label})
            for name, column in self.columns.items()
        }
        coordinates = {name: of.pop(name) for name in places}
        return xarray.Dataset(of, coords=coordinates, attrs={"title": self.title})

    def plot(
        self, column: str | None = None, *, ax: matplotlib.axes.Axes | None = None
    ) -> matplotlib.axes.Axes:
        """Draws the measured columns with bands of two standard errors, and the predictions.

        It draws the neighbouring columns of one unit that a chart of the report has, or, over a
        grid, a map of one column. Needs Matplotlib.

        Parameters
        ----------
        column : str, optional
            Name of the first column to draw, such as ``"velocity_autocorrelation"``. Default: the
            first measured one.
        ax : matplotlib.axes.Axes, optional
            Axes to draw into. Default: new ones.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> ax = table.plot()
        >>> ax.get_xlabel()
        'time (time)'
        """
        drawn = {name: of for name, of in self.columns.items() if of.role in ("value", "derived")}
        if column is not None and column not in drawn:
            raise ValueError(f"`column` must be one of {', '.join(drawn)}, but is {column!r}")
        try:
            import matplotlib.pyplot as pyplot
        except ImportError as error:
            raise ImportError("`plot` needs Matplotlib: pip install matplotlib") from error
        if ax is None:
            _, ax = pyplot.subplots()
        places = [of for of in self.columns.values() if of.role == "abscissa"]
        if len(places) == 2:
            shown = drawn[column if column is not None else next(iter(drawn))]
            middles = [np.unique(of.values) for of in places]
            mesh = ax.pcolormesh(*middles, self.grid(shown.name), shading="nearest")
            ax.figure.colorbar(mesh, ax=ax, label=_axis(shown.label, shown.unit))
            ax.set_aspect("equal")
            ax.set_title(self.title)
            ax.set_xlabel(_axis(places[0].label, places[0].unit))
            ax.set_ylabel(_axis(places[1].label, places[1].unit))
            return ax
        x, unit = self.columns[self.abscissa], None
        color: Any = None
        last = np.zeros(0)
        names = list(self.columns)
        for name in names[names.index(column) if column is not None else 0 :]:
            shown = self.columns[name]
            y = shown.values
            if name in drawn:
                if unit is not None and shown.unit != unit:
                    break
                unit = shown.unit
                (line,) = ax.plot(x.values[: len(y)], y, label=shown.label)
                color = line.get_color()
                for of, label, level, _ in self._levels:
                    if of == name:
                        ax.axhline(level, color="black", linestyle="--", linewidth=1, label=label)
                last = y
            elif shown.role == "standard error" and unit is not None:
                low, high = last - 2 * y, last + 2 * y
                ax.fill_between(x.values[: len(y)], low, high, color=color, alpha=0.3, linewidth=0)
            elif shown.role == "prediction" and unit is not None:
                ax.plot(x.values[: len(y)], y, "k--", linewidth=1, label=shown.label)
        if self._logarithmic:
            ax.set_xscale("log")
        ax.set_title(self.title)
        ax.set_xlabel(_axis(x.label, x.unit))
        ax.set_ylabel("" if unit in (None, "1") else str(unit))
        ax.legend()
        return ax

    def svg(self) -> list[str]:
        """The charts of the report as SVG: one for neighbouring columns of one unit.

        Examples
        --------
        >>> "<svg" in table.svg()[0]
        True
        """
        return _carom.table_pictures(self._results._bytes, self.name)

    def __reduce__(self) -> tuple[Any, ...]:
        return (_table_of, (self._results, self.name))

    def __repr__(self) -> str:
        return f"<carom.Table {self.name}: {len(self)} rows of {', '.join(self.columns)}>"

    def _repr_html_(self) -> str:
        charts = "".join(f"<div>{svg[svg.find('<svg'):]}</div>" for svg in self.svg())
        if not charts:
            cells = [[f"{row[name]:.6g}" for name in self.columns] for row in self.to_numpy()[:20]]
            heads = [_axis(column.label, column.unit) for column in self.columns.values()]
            charts = f"<b>{escape(self.title)}</b>" + rows(heads, cells)
        return charts + (f"<p>{escape(self.caption)}</p>" if self.caption else "")


def _axis(label: str, unit: str) -> str:
    return label if unit == "1" else f"{label} ({unit})"


def _table_of(results: Results, name: str) -> Table:
    return results.tables[name]


class Results(Mapping[str, Table]):
    """Tables and figures of one run or of merged runs; a mapping from names to tables.

    ``+`` merges runs of one scene that differ in seed or replica: means have errors from the
    blocks of all runs, and no order of merging changes a digit. Results can be pickled.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> scene = carom.Scene(
    ...     gas={"radius": 0.02, "mass": 1, "energy": 1, "count": 50},
    ...     run={"until": 2, "sample_interval": 0.1, "observe": ["pressure"]},
    ... )
    >>> both = carom.run(scene) + carom.run(scene.replaced(replica=1))
    >>> both.runs
    [(0, 0), (0, 1)]
    >>> both.figures["pressure"].standard_error > 0
    True
    """

    __module__ = "carom"
    __slots__ = ("_bytes", "_runs", "_scene", "figures", "tables")

    def __init__(self, record: bytes) -> None:
        contents = _carom.record_contents(record)
        self._bytes = record
        self.tables: dict[str, Table] = {
            plain["name"]: Table(self, plain) for plain in contents["tables"]
        }
        self.figures: dict[str, Figure] = {
            entry[0]: Figure(*entry) for entry in contents["figures"]
        }
        self._runs = contents["runs"]
        self._scene = contents["scene"]

    def __getitem__(self, name: str) -> Table:
        try:
            return self.tables[name]
        except KeyError:
            raise KeyError(f"{name!r}; the tables are {', '.join(self.tables) or 'none'}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.tables)

    def __len__(self) -> int:
        return len(self.tables)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Results) and self._bytes == other._bytes

    def __hash__(self) -> int:
        return hash(self._bytes)

    def __add__(self, other: Results) -> Results:
        if not isinstance(other, Results):
            return NotImplemented
        return Results(_carom.merge_records(self._bytes, other._bytes))

    def __radd__(self, other: object) -> Results:
        # So that `sum(results)` works, which begins with 0.
        return self if isinstance(other, int) and other == 0 else NotImplemented

    @property
    def runs(self) -> list[tuple[int, int]]:
        """Seed and replica of each run, in ascending order.

        Examples
        --------
        >>> both.runs
        [(0, 0), (0, 1)]
        """
        return [run[:2] for run in self._runs]

    @property
    def collisions(self) -> int:
        """Number of collisions of all runs.

        Examples
        --------
        >>> both.collisions > 0
        True
        """
        return sum(run[2] for run in self._runs)

    @property
    def simulated_time(self) -> float:
        """Simulated time of all runs (time).

        Examples
        --------
        >>> both.simulated_time
        4.0
        """
        return math.fsum(run[3] for run in self._runs)

    @property
    def energy_drift(self) -> float:
        """Largest drift of the energy at a sample, relative to that at the start.

        Of runs, and of the measure ``"energy"``.

        Examples
        --------
        >>> both.energy_drift < 1e-10
        True
        """
        return max((run[4] for run in self._runs), default=0.0)

    @property
    def overlapping_pairs(self) -> int:
        """Largest number of pairs that overlap by more than rounding at a sample.

        Of runs, and of the measure ``"overlap"``.

        Examples
        --------
        >>> both.overlapping_pairs
        0
        """
        return max((run[5] for run in self._runs), default=0)

    @property
    def scene(self) -> Scene:
        """The scene, with seed and replica 0.

        Examples
        --------
        >>> both.scene.tables["run"]["until"]
        2.0
        """
        return Scene._of(self._scene, None)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Results, (self._bytes,))

    def __repr__(self) -> str:
        return (
            f"<carom.Results of {len(self._runs)} run(s): tables {', '.join(self.tables) or 'none'}; "
            f"{len(self.figures)} figures>"
        )

    def _repr_html_(self) -> str:
        cells = [_cells(figure) for figure in self.figures.values()]
        figures = rows(_FIGURE, cells) if cells else ""
        shown = figures + "".join(table._repr_html_() for table in self.tables.values())
        return shown or f"<p>{escape(repr(self))}</p>"


def open_run(folder: str | os.PathLike[str]) -> Results:
    """Reads the results in a folder of ``carom run`` or ``carom merge``.

    Parameters
    ----------
    folder : str or path
        The folder of a run that has ended. :func:`load` reads its last state, also of a run that
        has not ended.

    Returns
    -------
    Results

    Raises
    ------
    CheckpointError
        There is no such run, it has not ended, or another version has written it.

    Examples
    --------
    >>> import carom
    >>> carom.open_run("no/such/folder")
    Traceback (most recent call last):
        ...
    carom.CheckpointError: no/such/folder: no run that has ended: it has no file 'sums', which `carom run` and `carom merge` write
    """
    return Results(_carom.record_of_folder(folder))
