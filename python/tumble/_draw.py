"""One figure of a result in axes of matplotlib, which are given: its series, bands, points and colours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tumble import _tumble
from tumble._figure import Figure, FigureAxis, Series
from tumble._text import need

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINE, POINT = 1.2, 3.5


def draw_figure(one: Figure, ax: Axes, before: int) -> None:
    """`before` series of other figures have their colours already."""
    if one.x.logarithmic:
        ax.set_xscale("log")
    if one.y.logarithmic:
        ax.set_yscale("log")
    if one.z is not None:
        _draw_colours(one, one.z, ax)
    for k, series in enumerate(one.series):
        if series.z is not None:
            continue
        style = _tumble.style_of_series(k + before)
        draw_series(ax, series._replace(colour=style.colour, dashes=style.dashes), k + before)
    if one.y.logarithmic:
        _end_two_decades_below(one, ax, before)
    ax.set(xlabel=one.x.title, ylabel=one.y.title)
    if one.notes:
        ax.set_title("\n".join(one.notes), fontsize=6, loc="left", wrap=True)
    draw_legend(ax, len(one.series) + before)


def _draw_colours(one: Figure, z: FigureAxis, ax: Axes) -> None:
    """The cells of a map and the points of one scale of colours, with that scale."""
    import numpy as np

    points = [series for series in one.series if series.z is not None]
    numbers = [series.z for series in points if series.z is not None]
    if one.map is not None:
        numbers.append(one.map.values.ravel())
    known = np.concatenate(numbers)
    known = known[np.isfinite(known)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    look: dict[str, Any] = {"cmap": "cividis", "vmin": low, "vmax": high}
    drawn: Any = None
    if one.map is not None:
        drawn = ax.pcolormesh(one.map.x, one.map.y, np.ma.masked_invalid(one.map.values), **look)
    for series in points:
        edge: dict[str, Any] = {"s": 4 * POINT**2, "edgecolors": "white", "linewidths": 0.6, "label": series.name}
        drawn = ax.scatter(series.x, series.y, c=series.z, **edge, **look)
    ax.figure.colorbar(drawn, ax=ax, label=z.title)


def draw_series(ax: Axes, series: Series, index: int) -> None:
    look: dict[str, Any] = {"color": series.colour, "label": series.name}
    if series.points:
        ax.plot(series.x, series.y, "os"[index % 2], markersize=POINT, linestyle="none", **look)
    else:
        ax.plot(series.x, series.y, linewidth=LINE, linestyle=_dashes(series.dashes), **look)
    if series.lower is None or series.upper is None:
        return
    if series.points:
        ax.vlines(series.x, series.lower, series.upper, color=series.colour, linewidth=0.8)
    else:
        ax.fill_between(series.x, series.lower, series.upper, color=series.colour, alpha=0.18, linewidth=0)


def _dashes(text: str) -> Any:
    """Dashes of CSS for a line of 1.6 pixels, in widths of the line."""
    lengths = [float(word) / 1.6 for word in text.split()]
    return (0, lengths) if lengths else "solid"


def _end_two_decades_below(one: Figure, ax: Axes, before: int) -> None:
    """A band may go on far below the values of a logarithmic axis, where nothing is to be seen."""
    import numpy as np

    lines = [series.y[np.isfinite(series.y)] for series in one.series]
    edges = [series.lower[series.lower > 0] for series in one.series if series.lower is not None]
    least = min((float(line.min()) for line in lines if line.size), default=1.0)
    lowest = min([least, *(float(edge.min()) for edge in edges if edge.size)])
    bottom = 0.9 * max(lowest, 0.01 * least)
    ax.set_ylim(bottom=min(bottom, ax.get_ylim()[0]) if before else bottom)


def draw_around(one: Figure, ax: Axes) -> None:
    import numpy as np

    turn = _tumble.Unit.parse(one.x.unit).factor
    values = np.concatenate([series.y for series in one.series])
    reach = float(np.nanmax(np.abs(values))) or 1.0
    for k, series in enumerate(one.series):
        angle = series.x * turn
        draw_series(ax, series._replace(x=angle), k)
    circle = np.linspace(0, 2 * np.pi, 181)
    ax.plot(circle, np.zeros_like(circle), color="#51606e", linewidth=0.8, linestyle="dashed")
    ax.set_ylim(-1.6 * reach, 1.2 * reach)
    ax.set_xlabel(f"{one.x.name}; radius: {one.y.title}")
    draw_legend(ax, len(one.series))


def draw_legend(ax: Axes, entries: int, across: bool = False) -> None:
    """Under the plot, where its labels end; `across`: in the middle of the figure, which has room for long names."""
    if entries:
        transforms = need("matplotlib.transforms", "plot")
        shift = transforms.ScaledTranslation(0, -0.4, ax.figure.dpi_scale_trans)
        middle = ax.figure.transFigure if across else ax.transAxes
        below = transforms.blended_transform_factory(middle, ax.transAxes) + shift
        place = {"bbox_to_anchor": (0.5, 0.0), "bbox_transform": below}
        ax.legend(loc="upper center", ncols=2, frameon=False, fontsize="small", **place)
