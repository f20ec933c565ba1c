"""TDMS files of LabVIEW, with npTDMS (LGPL: yours to install)."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from tumble._errors import DataError, TumbleWarning
from tumble._recording import Recording
from tumble._text import need
from tumble.importers import Column, Importer, Request, recording_of
from tumble.importers._table import columns_of, named_with_unit


def read(path: str, request: Request) -> Recording:
    """Reads all channels of numbers. Units are their property `unit_string`, times those of the waveform.

    Without a waveform the times are those of a channel of dates, or of one called time, in the same group. Waveforms
    and dates count from the first date of the file. A channel is called as in the file; where groups have channels of
    one name, `group.channel`.
    """
    file = need("nptdms", "import").TdmsFile.read(path)
    _warn_of_a_cut(path, file)
    groups = file.groups()
    columns, skipped = [], []
    channels = [channel for group in groups for channel in group.channels()]
    names = [_name(channel) for channel in channels]
    begin = min((date for channel in channels if (date := _date(channel)) is not None), default=None)
    for group in groups:
        numbers, others = _columns(path, group.channels(), begin, request.units)
        for column in numbers:
            name = column.name if names.count(column.name) == 1 else f"{group.name}.{column.name}"
            columns.append(column._replace(name=name, source=group[column.source].path))
        skipped += [group[name].path for name in others]
    return recording_of(path, importer.name, columns, request, skipped)


def _warn_of_a_cut(path: str, file: Any) -> None:
    """A TumbleWarning where the file ends within its last segment, as after a crash or a copy that was stopped."""
    if not file.file_status.incomplete_final_segment:
        return
    lengths = (file.file_status.channel_statuses or {}).items()
    cut = ", ".join(f"{name} has {one.read_length} of {one.expected_length} values there" for name, one in lengths)
    text = f"{path}: the file ends within its last segment{': ' if cut else ''}{cut}"
    warnings.warn(text, TumbleWarning, stacklevel=5)


def _columns(
    path: str, channels: Sequence[Any], begin: Any, units: Mapping[str, str]
) -> tuple[list[Column], list[str]]:
    """Columns of the channels of one group, called as in the file, and the names of those that hold no numbers."""
    waves = [channel for channel in channels if _step(channel) and len(channel) and channel.dtype.kind in "iuf"]
    rest = [channel for channel in channels if channel not in waves]
    empty = [channel.name for channel in rest if len(channel) == 0]
    named = [(channel.name, _since(channel[:], begin)) for channel in rest if len(channel)]
    given = {channel.name: units.get(channel.name) or units.get(channel.path) or _unit(channel) for channel in rest}
    numbers, others = columns_of(named, given)
    return [_wave(path, channel, begin) for channel in waves] + numbers, empty + others


def _name(channel: Any) -> str:
    return named_with_unit(channel.name)[0]


def _unit(channel: Any) -> str | None:
    return str(channel.properties.get("unit_string", "")).strip() or None


def _step(channel: Any) -> float | None:
    """Seconds between the samples of a waveform."""
    step = channel.properties.get("wf_increment")
    number = isinstance(step, (int, float)) and not isinstance(step, bool) and step > 0
    return float(step) if number and math.isfinite(1.0 / step) and math.isfinite(step) else None


def _date(channel: Any) -> Any:
    """When a channel begins: the first of its dates, or of a waveform the date that the file says.

    None where it says none, or the zero of its clock, in 1904.
    """
    import numpy as np

    said = channel.properties.get("wf_start_time") if _step(channel) else None
    if len(channel) and channel.dtype.kind == "M":
        dates = channel[:]
    else:
        dates = np.array([said] if isinstance(said, np.datetime64) else [], dtype="datetime64[us]")
    return min(dates[dates > np.datetime64("1970-01-01")], default=None)


def _since(values: Any, begin: Any) -> Any:
    """Dates as durations since the first date of the file; all else as it is."""
    return values - (values[0] if begin is None else begin) if values.dtype.kind == "M" else values


def _wave(path: str, channel: Any, begin: Any) -> Column:
    import numpy as np

    name, unit = named_with_unit(channel.name)
    step, date = _step(channel), _date(channel)
    offset = channel.properties.get("wf_start_offset", 0.0)
    if isinstance(offset, bool) or not isinstance(offset, (int, float)) or not math.isfinite(offset):
        raise DataError(
            f"{path}: channel {channel.path}: wf_start_offset is {offset!r}; accepted is a finite number of seconds"
        )
    start = float(offset) + (0.0 if date is None else float((date - begin) / np.timedelta64(1, "s")))
    rate = 1.0 / step if step else None
    return Column(name, unit or _unit(channel), channel.name, channel[:], None, rate, start)


importer = Importer("tdms", "TDMS files of LabVIEW, with npTDMS", (".tdms",), read)
