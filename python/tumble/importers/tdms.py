"""TDMS files of LabVIEW, with npTDMS (LGPL: yours to install)."""

from __future__ import annotations

from typing import Any

from tumble._recording import Recording
from tumble._text import need
from tumble.importers import Column, Importer, Request, recording_of


def read(path: str, request: Request) -> Recording:
    """Reads all channels of numbers. Units are their property `unit_string`, times that of the waveform.

    A channel is called as in the file; where groups have channels of one name, `group.channel`.
    """
    file = need("nptdms", "import").TdmsFile.read(path)
    channels = [channel for group in file.groups() for channel in group.channels()]
    names = [channel.name for channel in channels]
    columns, skipped = [], []
    for channel in channels:
        if len(channel) == 0 or channel.dtype.kind not in "iuf":
            skipped.append(channel.path)
            continue
        name = channel.name if names.count(channel.name) == 1 else f"{channel.group_name}.{channel.name}"
        columns.append(_column(name, channel))
    return recording_of(path, importer.name, columns, request, skipped)


def _column(name: str, channel: Any) -> Column:
    step = channel.properties.get("wf_increment")
    rate = 1.0 / step if isinstance(step, (int, float)) and step > 0 else None
    unit = channel.properties.get("unit_string") or None
    start = float(channel.properties.get("wf_start_offset", 0.0))
    return Column(name, unit, channel.path, channel[:], None, rate, start)


importer = Importer("tdms", "TDMS files of LabVIEW, with npTDMS", (".tdms",), read)
