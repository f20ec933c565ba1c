"""TDMS files of LabVIEW, with npTDMS (LGPL: yours to install)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tumble._recording import Recording
from tumble._text import need
from tumble.importers import Column, Importer, Request, recording_of
from tumble.importers._table import columns_of


def read(path: str, request: Request) -> Recording:
    """Reads all channels of numbers. Units are their property `unit_string`, times those of the waveform.

    Waveforms that say when they begin count from the first of them. Without a waveform the times are those of a channel
    of dates, or of one called time, in the same group. A channel is called as in the file; where groups have channels
    of one name, `group.channel`.
    """
    groups = need("nptdms", "import").TdmsFile.read(path).groups()
    columns, skipped = [], []
    channels = [channel for group in groups for channel in group.channels()]
    names = [channel.name for channel in channels]
    begin = min((date for channel in channels if (date := _date(channel)) is not None), default=None)
    for group in groups:
        numbers, others = _columns(group.channels(), begin)
        for column in numbers:
            alone = names.count(group[column.source].name) == 1
            name = column.name if alone else f"{group.name}.{column.name}"
            columns.append(column._replace(name=name, source=group[column.source].path))
        skipped += [group[name].path for name in others]
    return recording_of(path, importer.name, columns, request, skipped)


def _columns(channels: Sequence[Any], begin: Any) -> tuple[list[Column], list[str]]:
    """Columns of the channels of one group, called as in the file, and the names of those that hold no numbers."""
    waves = [channel for channel in channels if _step(channel) and len(channel) and channel.dtype.kind in "iuf"]
    rest = [channel for channel in channels if channel not in waves]
    empty = [channel.name for channel in rest if len(channel) == 0]
    named = [(channel.name, channel[:]) for channel in rest if len(channel)]
    numbers, others = columns_of(named, {channel.name: channel.properties.get("unit_string") for channel in rest})
    return [_wave(channel, begin) for channel in waves] + numbers, empty + others


def _step(channel: Any) -> float | None:
    """Seconds between the samples of a waveform."""
    step = channel.properties.get("wf_increment")
    return float(step) if isinstance(step, (int, float)) and step > 0 else None


def _date(channel: Any) -> Any:
    """When a waveform begins; None where the file does not say it, or says the zero of its clock, in 1904."""
    import numpy as np

    date = channel.properties.get("wf_start_time") if _step(channel) else None
    return date if isinstance(date, np.datetime64) and date > np.datetime64("1970-01-01") else None


def _wave(channel: Any, begin: Any) -> Column:
    import numpy as np

    unit, step, date = channel.properties.get("unit_string") or None, _step(channel), _date(channel)
    start = float(channel.properties.get("wf_start_offset", 0.0))
    if date is not None:
        start += float((date - begin) / np.timedelta64(1, "s"))
    return Column(channel.name, unit, channel.name, channel[:], None, 1.0 / step if step else None, start)


importer = Importer("tdms", "TDMS files of LabVIEW, with npTDMS", (".tdms",), read)
