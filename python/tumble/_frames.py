"""Channels and tables as data frames of pandas, polars, xarray and Arrow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tumble._errors import UsageError
from tumble._text import need

if TYPE_CHECKING:
    from tumble._channel import Channel


def _common_times(channels: Mapping[str, Channel]) -> Any:
    import numpy as np

    first, *others = channels.values()
    times = first.times
    for other in others:
        if len(other) != len(times) or not np.array_equal(other.times, times):
            raise UsageError(
                f"'{first.name}' and '{other.name}' are not sampled together; read them one at a time with "
                "tumble.read(..., channels=[...])"
            )
    return times


def recording_to_pandas(channels: Mapping[str, Channel]) -> Any:
    pandas = need("pandas", "pandas")
    index = pandas.Index(_common_times(channels), name="time")
    frame = pandas.DataFrame({name: channel.in_() for name, channel in channels.items()}, index=index)
    frame.attrs["units"] = {name: channel.shown_unit for name, channel in channels.items()}
    return frame


def recording_to_polars(channels: Mapping[str, Channel]) -> Any:
    columns = {f"{name}[{channel.shown_unit}]": channel.in_() for name, channel in channels.items()}
    return need("polars", "polars").DataFrame({"time[s]": _common_times(channels), **columns})


def recording_to_xarray(channels: Mapping[str, Channel], meta: Mapping[str, str]) -> Any:
    times = _common_times(channels)
    variables = {
        name: ("time", channel.in_(), {"unit": channel.shown_unit, "rate": channel.rate})
        for name, channel in channels.items()
    }
    coordinates = {"time": ("time", times, {"unit": "s"})}
    return need("xarray", "xarray").Dataset(variables, coords=coordinates, attrs=dict(meta))


def table_to_pandas(columns: Mapping[str, Any], units: Mapping[str, str]) -> Any:
    frame = need("pandas", "pandas").DataFrame(dict(columns))
    frame.attrs["units"] = dict(units)
    return frame


def table_to_polars(columns: Mapping[str, Any]) -> Any:
    return need("polars", "polars").DataFrame({name: _plain(cells) for name, cells in columns.items()})


def table_to_arrow(columns: Mapping[str, Any], units: Mapping[str, str]) -> Any:
    arrow = need("pyarrow", "import")
    arrays = {name: arrow.array(_plain(cells)) for name, cells in columns.items()}
    fields = [arrow.field(name, array.type, metadata={"unit": units[name]}) for name, array in arrays.items()]
    return arrow.Table.from_arrays(list(arrays.values()), schema=arrow.schema(fields))


def _plain(column: Any) -> Any:
    """Columns of texts may hold numbers too: Arrow and polars want one type."""
    return [None if cell is None else str(cell) for cell in column] if isinstance(column, list) else column
