"""Figures of results with matplotlib: the same axes, series, bands and colours as in the report.

    import tumble.plot
    axes = tumble.plot.allan(result)
    tumble.plot.save(axes, "noise.pdf")

matplotlib is imported when a function is called: pip install 'tumble[plot]'. Every function draws into `ax` if it is
given, else into a new figure in the style STYLE, and returns its axes as a tuple.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, cast

from tumble import _tumble
from tumble._allan import AllanDeviation
from tumble._channel import Channel
from tumble._draw import draw_around, draw_figure, draw_legend, draw_series
from tumble._errors import DataError, FileError, UsageError, wrong_type, wrong_value
from tumble._figure import Figure, Series
from tumble._recording import Recording
from tumble._result import Result, result_of
from tumble._text import count_of, need, path_text, seconds_of, whole_text

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

STYLE: dict[str, Any] = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#51606e",
    "axes.grid": True,
    "grid.color": "#e1e6eb",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "figure.figsize": (5.5, 3.6),
    "savefig.dpi": 300,
}
"""Settings of matplotlib (rcParams) of the figures that are made here."""

FILES: dict[str, Any] = {"svg.fonttype": "none", "svg.hashsalt": "tumble", "pdf.fonttype": 42}
"""Settings of the files that are written here: text stays text, and the same figure gives the same bytes."""


def allan(
    result: Result | AllanDeviation | str | os.PathLike[str], ax: Axes | None = None, *, channel: str | None = None
) -> tuple[Axes, ...]:
    """The Allan deviation with its limits, the fit and the terms found; or a curve of tumble.allan_deviation.

    Given     result   of allan_noise, or its file; or an AllanDeviation
              ax       all are drawn into it; None: one for each channel
              channel  only this one, for example "gyro.x"
    Raises    UsageError where the result has no such figure
    Example   tumble.plot.allan(result, channel="gyro.x")
    """
    if isinstance(result, AllanDeviation):
        return (_allan_curve(result, ax),)
    found = [one for one in _figures(result) if one.name.startswith("allan deviation")]
    if channel is not None:
        whole_text(channel, "channel")
        found = [one for one in found if one.name == f"allan deviation {channel}"]
    return _draw(_some(found, "Allan deviation" + (f" of {channel!r}" if channel else ""), result), ax)


def figures(result: Result | str | os.PathLike[str], name: str = "", ax: Axes | None = None) -> tuple[Axes, ...]:
    """Every figure of the report, or those whose name has `name` in it.

    Example   tumble.plot.figures(result, "power spectral density")
    """
    whole_text(name, "name")
    return _draw(_some([one for one in _figures(result) if name in one.name], repr(name), result), ax)


def figure(figure: Figure, ax: Axes | None = None) -> Axes:
    """One figure of `result.figures`."""
    if not isinstance(figure, Figure):
        raise wrong_type("figure", figure, "accepted is one of result.figures")
    return _draw([figure], ax)[0]


def residuals(result: Result | str | os.PathLike[str], ax: Axes | None = None) -> tuple[Axes, ...]:
    """What the model leaves, over time, rate or angle: the figures of the report that show residuals."""
    return _draw(_residuals(result), ax)


def polar(result: Result | str | os.PathLike[str], ax: Axes | None = None) -> tuple[Axes, ...]:
    """The figures over an angle (residuals of positions, drift of a tumble) around a circle; the dashed circle is 0.

    Given     ax  with projection="polar"
    Raises    UsageError where the result has no figure over an angle
    """
    found = [one for one in _figures(result) if _dimension(one.x.unit) == "rad"]
    if ax is not None and getattr(ax, "name", "") != "polar":
        raise UsageError("argument ax: rectangular axes were given; accepted are axes with projection='polar'")
    _some(found, "plot over an angle", result)
    with _style(ax):
        axes = _axes(len(found), ax, projection="polar")
        for one, target in zip(found, axes, strict=True):
            draw_around(one, target)
    return axes


def budget(result: Result | str | os.PathLike[str], ax: Axes | None = None) -> tuple[Axes, ...]:
    """The share of each source in the variance of each parameter, as bars; small sources share one."""
    import numpy as np

    made = result_of(result)
    names = list(made.parameters)
    lines = _tumble.budget_shares(made._core)
    if not lines:
        raise UsageError(f"{made!r} has no uncertainty budget")
    ends = np.cumsum([shares for _, shares in lines], axis=0)
    with _style(ax):
        target = _axes(1, ax, height=0.9 + 0.2 * len(names) + 0.08 * len(lines))[0]
        for k, (source, shares) in enumerate(lines):
            look: dict[str, Any] = {
                "color": _tumble.style_of_series(k).colour,
                "hatch": "////" if k >= _colours() else "",
            }
            target.barh(names, shares, 0.7, left=ends[k] - shares, label=source, edgecolor="white", **look)
        target.set(xlim=(0, 1), ylim=(len(names) - 0.5, -0.5), xlabel="share of the variance")
        target.grid(False)
        draw_legend(target, len(lines), across=ax is None)
    return (target,)


def thermal(
    recording: Recording,
    compensated: Recording | None = None,
    ax: Axes | None = None,
    *,
    channel: str | None = None,
    temperature: str | None = None,
    block: float = 100.0,
    cells: int = 24,
) -> tuple[Axes, ...]:
    """Map of a channel over temperature and its rate: the mean of each cell; beside it after compensation.

    Given     recording    with a temperature channel
              compensated  of tumble.compensate(result, recording): a second map in the same colours
              channel      None: the first that is no temperature; temperature, None: the first
              block        [s] over which samples are averaged before; cells of the map from side to side
    Raises    UsageError for absent channels; DataError where the channel is shorter than three blocks
    Example   tumble.plot.thermal(test, tumble.compensate(result, test))
    """
    import numpy as np

    maps = (
        [("", recording)]
        if compensated is None
        else [("before compensation", recording), ("after compensation", compensated)]
    )
    degrees = _channel(recording, temperature, True, "temperature")
    signal = _channel(recording, channel, False, "channel")
    count_of(cells, "cells", 2)
    both = [_channel(one, signal.name, False, "channel" if one is recording else "compensated") for _, one in maps]
    heat, signals = degrees.in_("degC"), [one.in_(signal.shown_unit) for one in both]
    blocks = max(1, round(min(seconds_of(block, "block") * degrees.rate, 1e18)))
    over, times = _means(heat, blocks), _means(degrees.times, blocks)
    rate = np.gradient(over, times) * 60.0
    means = [_means(one, blocks)[: len(over)] for one in signals]
    kept = _within_runs(recording, times) & np.isfinite(rate) & np.isfinite(means).all(axis=0)
    values = [one[kept] for one in means]
    if not kept.any():
        raise DataError(f"argument block: no power-up is longer than three blocks of {block:g} s")
    limits = min(float(one.min()) for one in values), max(float(one.max()) for one in values)
    with _style(ax):
        axes = _axes(len(maps), ax)
        for (title, _), one, target in zip(maps, values, axes, strict=True):
            look: dict[str, Any] = {
                "gridsize": cells,
                "vmin": limits[0],
                "vmax": limits[1],
                "cmap": "cividis",
                "linewidths": 0.2,
            }
            drawn = target.hexbin(over[kept], rate[kept], C=one, **look)
            target.set(xlabel=f"{degrees.name} [degC]", ylabel="its rate [K/min]", title=title)
            target.figure.colorbar(drawn, ax=target, label=f"{signal.name} [{signal.shown_unit}]")
    return axes


def save(axes: Axes | Sequence[Axes], path: str | os.PathLike[str], **options: Any) -> None:
    """Writes the figure that holds these axes: .pdf, .svg, .png ...; PDF and SVG hold no date.

    Given     options  of matplotlib's savefig, for example dpi
    Example   tumble.plot.save(tumble.plot.allan(result), "noise.pdf")
    """
    matplotlib = need("matplotlib", "plot")
    text = path_text(path, "path")
    whole: Any = axes[0] if isinstance(axes, Sequence) and len(axes) else axes
    if not hasattr(whole, "figure"):
        raise wrong_type("axes", axes, "accepted are axes of matplotlib, as the functions of tumble.plot return them")
    dates = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    try:
        with matplotlib.rc_context(FILES):
            whole.figure.savefig(text, metadata=dates.get(os.path.splitext(text)[1].lower()), **options)
    except OSError as error:
        raise FileError(f"{text}: {error}") from error
    except ValueError as error:
        raise wrong_value("path", text, str(error)) from error


def _figures(result: Result | str | os.PathLike[str]) -> tuple[Figure, ...]:
    return result_of(result).figures


def _some(found: list[Figure], wanted: str, result: Any) -> list[Figure]:
    if not found:
        names = ", ".join(repr(one.name) for one in _figures(result)) or "none"
        raise UsageError(f"argument result: it has no figure of {wanted}; there are {names}")
    return found


def _residuals(result: Any) -> list[Figure]:
    found = [one for one in _figures(result) if "residual" in f"{one.name} {one.y.name}"]
    return _some(found, "residuals", result)


def _axes(count: int, ax: Axes | None, projection: str | None = None, height: float | None = None) -> tuple[Axes, ...]:
    """The axes to draw into: `ax` as often as it is needed, or those of a new figure, one under the other."""
    if ax is not None:
        if not hasattr(ax, "set_xscale"):
            raise wrong_type("ax", ax, "accepted are axes of matplotlib")
        return (ax,) * count
    pyplot = need("matplotlib.pyplot", "plot")
    width, usual = STYLE["figure.figsize"]
    size = (width, height or count * (usual if projection is None else width))
    shape = {"squeeze": False, "layout": "constrained", "subplot_kw": {"projection": projection}}
    return tuple(pyplot.subplots(count, 1, figsize=size, **shape)[1][:, 0])


def _style(ax: Axes | None) -> AbstractContextManager[object]:
    """STYLE for a figure of our own; axes that were given keep that of their figure."""
    return (
        nullcontext()
        if ax is not None
        else cast("AbstractContextManager[object]", need("matplotlib", "plot").rc_context(STYLE))
    )


def _draw(found: Iterable[Figure], ax: Axes | None) -> tuple[Axes, ...]:
    figures = list(found)
    if ax is not None and len({(_dimension(one.x.unit), one.y.unit) for one in figures}) > 1:
        units = ", ".join(f"{one.y.name} [{one.y.unit}]" for one in figures)
        raise UsageError(f"argument ax: figures of different units cannot share axes: {units}")
    with _style(ax):
        axes = _axes(len(figures), ax)
        for k, (one, target) in enumerate(zip(figures, axes, strict=True)):
            draw_figure(one, target, sum(len(before.series) for before in figures[:k]) if ax is not None else 0)
    return axes


def _allan_curve(curve: AllanDeviation, ax: Axes | None) -> Axes:
    style = _tumble.style_of_series(0)
    known = curve.deviation > 0
    series = Series(
        curve.kind,
        True,
        curve.taus[known],
        curve.deviation[known],
        curve.lower[known],
        curve.upper[known],
        "95 %",
        style.colour,
        "",
    )
    with _style(ax):
        target = _axes(1, ax)[0]
        target.set(xscale="log", yscale="log", xlabel="averaging time [s]")
        target.set_ylabel(curve.kind if curve.unit == "1" else f"{curve.kind} [{curve.unit}]")
        draw_series(target, series, len(target.lines))
    return target


def _dimension(unit: str) -> str:
    return str(_tumble.Unit.parse(unit).dimension)


def _colours() -> int:
    first = _tumble.style_of_series(0).colour
    return next(k for k in range(1, 100) if _tumble.style_of_series(k).colour == first)


def _channel(recording: Recording, name: str | None, hot: bool, argument: str) -> Channel:
    if not isinstance(recording, Recording):
        raise wrong_type("recording", recording, "accepted is a Recording")
    if name is not None:
        whole_text(name, argument)
    fitting = [one for one in recording.values() if (one.kind == "temperature") == hot]
    chosen = [one for one in recording.values() if one.name == name] if name is not None else fitting[:1]
    if not chosen:
        raise wrong_value(argument, name, f"there are {', '.join(recording)}")
    return chosen[0]


def _means(values: NDArray[np.float64], block: int) -> NDArray[np.float64]:
    """Means of whole blocks, shape (n // block,)."""
    count = len(values) // block
    if count < 3:
        raise DataError(
            f"argument block: {len(values)} samples hold {count} blocks of {block}; accepted are three or more"
        )
    means: NDArray[np.float64] = values[: count * block].reshape(count, block).mean(axis=1)
    return means


def _within_runs(recording: Recording, times: NDArray[np.float64]) -> NDArray[np.bool_]:
    """The blocks whose neighbours belong to the same power-up: only there their difference is a rate."""
    import numpy as np

    begins = {mark.run: mark.begin for mark in reversed(recording.marks)}
    run = np.searchsorted(sorted(begins.values()), times, side="right")
    same = run[1:] == run[:-1]
    return np.concatenate([[False], same[1:] & same[:-1], [False]])
