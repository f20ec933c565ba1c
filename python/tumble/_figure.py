"""The figures of a report: one description, which every renderer draws."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from tumble import _tumble
from tumble._arrays import equal
from tumble._errors import wrong_value
from tumble._text import path_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class FigureAxis(NamedTuple):
    """An axis: what it shows, the unit of its numbers, and the text that stands beside it."""

    name: str
    unit: str
    title: str
    logarithmic: bool


class Series(NamedTuple):
    """A line, or points, in the units of the axes; NaN is a gap.

    `lower` and `upper` are the band, or bars where the series is points; None: there is none. `dashes` are lengths of
    strokes and gaps in pixels as of CSS, "" for a whole line. `z` is the quantity of the axis z of the figure at each
    point, shown by its colour; None: the points have the colour of the series.
    """

    name: str
    points: bool
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    lower: NDArray[np.float64] | None
    upper: NDArray[np.float64] | None
    band: str
    colour: str
    dashes: str
    z: NDArray[np.float64] | None = None

    def __eq__(self, other: object) -> bool:
        return equal(self, other)

    def __ne__(self, other: object) -> bool:
        return not equal(self, other)


class FigureMap(NamedTuple):
    """Cells of a map: edges of columns and rows in the units of the axes, values (rows, columns) in the unit of z.

    The first row is that of the smallest y; NaN is no cell.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    values: NDArray[np.float64]

    def __eq__(self, other: object) -> bool:
        return equal(self, other)

    def __ne__(self, other: object) -> bool:
        return not equal(self, other)


class Figure:
    """A plot as the report has it, in numbers (`x`, `y`, `series`, `notes`) and as a drawing (`to_svg`).

    `notes` are sentences on what the plot does not show. Where colours show a quantity, `z` is its axis, and `map` are
    cells with these colours; else both are None. tumble.plot draws it with matplotlib.
    """

    __slots__ = ("_drawing", "map", "name", "notes", "series", "x", "y", "z")

    def __init__(
        self,
        name: str,
        x: FigureAxis,
        y: FigureAxis,
        series: tuple[Series, ...],
        notes: tuple[str, ...],
        drawing: Callable[[], str] | str,
        z: FigureAxis | None = None,
        map: FigureMap | None = None,
    ) -> None:
        self.name = name
        self.x = x
        self.y = y
        self.series = series
        self.notes = notes
        self._drawing = drawing
        self.z = z
        self.map = map

    def to_svg(self) -> str:
        """The drawing of the report: an SVG that needs no style sheet, no script and no network."""
        return self._drawing if isinstance(self._drawing, str) else self._drawing()

    def __reduce__(self) -> tuple[Any, ...]:
        return Figure, (self.name, self.x, self.y, self.series, self.notes, self.to_svg(), self.z, self.map)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the drawing of the report; the name ends in .svg. For PDF: tumble.plot.save."""
        text = path_text(path, "path")
        if not text.lower().endswith(".svg"):
            raise wrong_value("path", text, "the name must end in .svg")
        _tumble.write_whole(text, self.to_svg())

    def _repr_svg_(self) -> str:
        return self.to_svg()

    def __repr__(self) -> str:
        names = ", ".join(one.name for one in self.series)
        if self.z is not None:
            return f"<Figure {self.name}: {self.z.title} over {self.x.title} and {self.y.title}: {names}>"
        return f"<Figure {self.name}: {self.y.title} over {self.x.title}: {names}>"


def _axis(core: _tumble.Figure.Axis) -> FigureAxis:
    return FigureAxis(core.name, core.unit, core.title, core.logarithmic)


def _series(core: _tumble.Figure.Series, index: int) -> Series:
    style = _tumble.style_of_series(index)
    lower, upper = (core.lower, core.upper) if len(core.lower) else (None, None)
    z = core.z if len(core.z) else None
    return Series(core.name, core.points, core.x, core.y, lower, upper, core.band, style.colour, style.dashes, z)


def _map(core: _tumble.Figure.Map) -> FigureMap:
    return FigureMap(core.x, core.y, core.values.reshape(len(core.y) - 1, len(core.x) - 1))


def figures_of(core: _tumble.Estimate) -> tuple[Figure, ...]:
    """The figures of a result, in the order of the report."""
    return tuple(_figure(one) for one in _tumble.figures_of(core))


def _figure(core: _tumble.Figure) -> Figure:
    series = tuple(_series(one, i) for i, one in enumerate(core.series))
    z = None if core.z is None else _axis(core.z)
    cells = None if core.map is None else _map(core.map)
    return Figure(core.name, _axis(core.x), _axis(core.y), series, tuple(core.notes), core.to_svg, z, cells)
