"""The parts of a result: parameters, covariance, budget, tables, curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from tumble import _frames, _tumble
from tumble._arrays import equal
from tumble._errors import UsageError, shown, wrong_type
from tumble._named import Document, Named
from tumble._text import need, unit_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

INFINITY = float("inf")


class Parameter(NamedTuple):
    """One parameter. `value`, `sd` and `interval` are in `unit`.

    `sd` is the standard uncertainty (k = 1), `interval` the 95 % interval. A number that could not be found is null in
    the result file and NaN here.
    """

    name: str
    symbol: str
    value: float
    sd: float
    unit: str
    interval: tuple[float, float]
    degrees_of_freedom: float
    description: str

    def in_(self, unit: str | object) -> Parameter:
        """The parameter in another unit, text or of pint. Raises UsageError where the unit has another dimension."""
        own, other = _tumble.Unit.parse(self.unit), unit_of(unit, "unit")
        if own.dimension != other.dimension:
            raise UsageError(
                f"argument unit: {unit!r} has the dimension [{other.dimension}]; parameter '{self.name}' is in "
                f"{self.unit} [{own.dimension}]"
            )
        if own.text == other.text:
            return self
        low, high = (other.from_si(own.to_si(end)) for end in self.interval)
        return self._replace(
            value=other.from_si(own.to_si(self.value)),
            sd=other.difference_from_si(own.difference_to_si(self.sd)),
            interval=(low, high),
            unit=other.text,
        )

    @property
    def si(self) -> Parameter:
        """The parameter in SI base units."""
        return self.in_(_tumble.Unit.parse(self.unit).dimension)

    def to_pint(self, registry: Any = None) -> Any:
        """The value as a pint quantity of `registry`, by default the application registry."""
        chosen = need("pint", "units").get_application_registry() if registry is None else registry
        if not hasattr(chosen, "Quantity"):
            raise wrong_type("registry", registry, "accepted is a UnitRegistry of pint")
        quantity = chosen.Quantity
        si = self.si
        return quantity(si.value, si.unit)

    def to_uncertainties(self) -> Any:
        """The value with its standard uncertainty, of the package uncertainties, without correlations."""
        return need("uncertainties", "units").ufloat(self.value, self.sd, self.name)

    def __str__(self) -> str:
        return f"{self.name} = {_tumble.with_uncertainty(self.value, self.sd)} {self.unit}"


def number(value: float | None, absent: float = float("nan")) -> float:
    """JSON has null where a number is not finite."""
    return absent if value is None else float(value)


def parameter_of(document: Mapping[str, Any]) -> Parameter:
    """A parameter from the JSON of a result."""
    low, high = document["interval95"] or (None, None)
    return Parameter(
        document["name"],
        document["symbol"],
        number(document["value"]),
        number(document["sd"]),
        document["unit"],
        (number(low), number(high)),
        number(document["degrees_of_freedom"], INFINITY),
        document["description"],
    )


class Covariance:
    """A covariance with names: `covariance["a", "b"]` is one element, `covariance.values` the array, shape (p, p)."""

    __slots__ = ("names", "values")

    def __init__(self, names: tuple[str, ...], rows: Sequence[Sequence[float | None]]) -> None:
        import numpy as np

        self.names = names
        numbers = np.array([[number(x) for x in row] for row in rows], dtype=np.float64)
        self.values: NDArray[np.float64] = numbers.reshape(len(names), len(names))
        self.values.flags.writeable = False

    def __getitem__(self, pair: tuple[str, str]) -> float:
        known = isinstance(pair, tuple) and len(pair) == 2 and all(name in self.names for name in pair)
        if not known:
            raise KeyError(
                f"no element {shown(pair, 200)}: write covariance[name, name] with two of {', '.join(self.names)}"
            )
        row, column = pair
        return float(self.values[self.names.index(row), self.names.index(column)])

    @property
    def correlation(self) -> NDArray[np.float64]:
        """Correlations [1], shape (p, p)."""
        import numpy as np

        sd = np.sqrt(np.diag(self.values))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.values / np.outer(sd, sd))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        import numpy as np

        return np.asarray(self.values, dtype=dtype) if copy is None else np.array(self.values, dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        return f"<Covariance of {', '.join(self.names)}>"


class Contribution(Named[float]):
    """One line of the budget: the standard uncertainty that its source gives each parameter, in the parameter's unit.

    `factor`, shape (p, q), holds with sign what one standard deviation of each of its q independent errors does.
    Results whose lines have one `key` share these errors.
    """

    __slots__ = ("factor", "key", "source")

    def __init__(self, names: tuple[str, ...], document: Mapping[str, Any]) -> None:
        import numpy as np

        super().__init__("parameter", dict(zip(names, map(number, document["sd"]), strict=True)))
        self.source: str = document["source"]
        self.key: str | None = document["key"]
        self.factor: NDArray[np.float64] = np.array(document["factor"], dtype=np.float64)
        self.factor.flags.writeable = False

    def __repr__(self) -> str:
        return f"<Contribution {self.source}>"


class Budget(Named[Contribution]):
    """The budget of uncertainty, by source. The squares of a parameter's lines add up to its variance.

    Recordings of different sites or rigs give several lines of one source: "gravity", "gravity (2)" and so on.
    """

    __slots__ = ()

    def __init__(self, names: tuple[str, ...], documents: Sequence[Mapping[str, Any]]) -> None:
        lines: dict[str, Contribution] = {}
        for one in documents:
            line = Contribution(names, one)
            alike = sum(other.source == line.source for other in lines.values())
            lines[f"{line.source} ({alike + 1})" if alike else line.source] = line
        super().__init__("source", lines)

    def __repr__(self) -> str:
        return f"<Budget: {', '.join(self)}>"


class WithPrior(NamedTuple):
    """The estimate with the prior of the plan: all parameters, also those that the schedule does not show."""

    parameters: Mapping[str, Parameter]
    covariance: Covariance
    budget: Budget


class Prior(Document):
    """The prior of a result as its file has it: from, used, verdicts, belongs, population, results and numbers."""

    __slots__ = ()

    def __init__(self, document: Mapping[str, Any]) -> None:
        super().__init__("part", document)

    def __repr__(self) -> str:
        return f"<Prior: {self['population']['units']} units of {self['model']}>"


def with_prior_of(document: Mapping[str, Any]) -> WithPrior:
    """From the block of the result file."""
    parameters = Named("parameter", {one["name"]: parameter_of(one) for one in document["parameters"]})
    names = tuple(parameters)
    return WithPrior(parameters, Covariance(names, document["covariance"]), Budget(names, document["budget"]))


class Fit(NamedTuple):
    """The fit as a whole. `condition` [1] is that of the weighted design with columns of unit length."""

    observations: int
    degrees_of_freedom: float | None
    chi_square: float | None
    condition: float | None


class Verdict(NamedTuple):
    """The comparison of a parameter with a limit: `outcome` is pass, fail or undecided."""

    parameter: str
    outcome: str
    limit: str


class Provenance(Document):
    """All that an answer depends on, as the result file has it: inputs, plans, settings, command_line, seed."""

    __slots__ = ()

    def __init__(self, document: Mapping[str, Any]) -> None:
        super().__init__("part", document)

    def __repr__(self) -> str:
        return f"<Provenance: {', '.join(one['file'] for one in self['inputs'])}>"


class Column(NamedTuple):
    """A column of a table: its name and the unit of its numbers."""

    name: str
    unit: str


class Table:
    """A table of a result: `columns`, `rows`, and one column by name as `table["tau"]`."""

    __slots__ = ("_rows", "caption", "columns", "name")

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.name: str = document["name"]
        self.caption: str = document["caption"]
        self.columns = tuple(Column(one["name"], one["unit"]) for one in document["columns"])
        self._rows = document["rows"]

    @property
    def rows(self) -> tuple[tuple[float | str | None, ...], ...]:
        """Rows of numbers, each in the unit of its column, and texts; None where there is no number."""
        return tuple(tuple(row) for row in self._rows)

    def __getitem__(self, column: str) -> Any:
        """One column: an array of numbers, NaN where there is none; or a list where it has texts."""
        import numpy as np

        names = [one.name for one in self.columns]
        if not isinstance(column, str) or column not in names:
            raise KeyError(f"no column {shown(column)}; there are {', '.join(names)}")
        cells = [row[names.index(column)] for row in self._rows]
        if any(isinstance(cell, str) for cell in cells):
            return cells
        return np.array([number(cell) for cell in cells], dtype=np.float64)

    def __len__(self) -> int:
        return len(self._rows)

    def _by_name(self) -> dict[str, Any]:
        return {one.name: self[one.name] for one in self.columns}

    def _units(self) -> dict[str, str]:
        return {one.name: one.unit for one in self.columns}

    def to_pandas(self) -> Any:
        """A pandas DataFrame with the units in `attrs["units"]`."""
        return _frames.table_to_pandas(self._by_name(), self._units())

    def to_polars(self) -> Any:
        """A polars DataFrame."""
        return _frames.table_to_polars(self._by_name())

    def to_arrow(self) -> Any:
        """A pyarrow Table; each field has its unit in the metadata."""
        return _frames.table_to_arrow(self._by_name(), self._units())

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"<Table {self.name}: {', '.join(one.name for one in self.columns)}; {len(self)} rows>"


class Axis(NamedTuple):
    """An axis of a curve: its name, the unit, and the numbers in it, shape (n,)."""

    name: str
    unit: str
    values: NDArray[np.float64]

    def __eq__(self, other: object) -> bool:
        return equal(self, other)

    def __ne__(self, other: object) -> bool:
        return not equal(self, other)


class Curve(NamedTuple):
    """A curve of the report. `lower` and `upper` [unit of y] are the band that `band` names; None: no band."""

    name: str
    figure: str
    x: Axis
    y: Axis
    lower: NDArray[np.float64] | None
    upper: NDArray[np.float64] | None
    band: str
    logarithmic: bool
    logarithmic_x: bool
    points: bool

    def __eq__(self, other: object) -> bool:
        return equal(self, other)

    def __ne__(self, other: object) -> bool:
        return not equal(self, other)


def curve_of(document: Mapping[str, Any]) -> Curve:
    """A curve from the JSON of a result."""
    import numpy as np

    def array(values: Sequence[float | None]) -> NDArray[np.float64]:
        made = np.array([number(value) for value in values], dtype=np.float64)
        made.flags.writeable = False
        return made

    def axis(one: Mapping[str, Any]) -> Axis:
        return Axis(one["name"], one["unit"], array(one["values"]))

    band = document.get("band")
    return Curve(
        document["name"],
        document["figure"],
        axis(document["x"]),
        axis(document["y"]),
        array(band["lower"]) if band else None,
        array(band["upper"]) if band else None,
        band["name"] if band else "",
        bool(document.get("logarithmic")),
        bool(document.get("logarithmic_x")),
        bool(document.get("points")),
    )
