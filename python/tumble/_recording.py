"""Recordings: channels with their times, marks and origin."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, overload

from tumble import _frames, _tumble
from tumble._channel import Channel, Parts
from tumble._errors import DataError, UsageError, shown
from tumble._finding import Finding, findings_of
from tumble._text import path_text, seconds_of

if TYPE_CHECKING:
    import os

Source = tuple[Callable[..., "Recording"], tuple[Any, ...]]
"""A function that reads the recording again, and its arguments before the checksum."""


class Mark(NamedTuple):
    """The beginning of a segment: its label, when it begins and ends [s], and which power-up it belongs to."""

    label: str
    begin: float
    run: int = 1
    end: float = float("inf")


class Recording(Mapping[str, Channel]):
    """What was measured in one file: channels by name, marks, and where it comes from. It cannot be changed.

    `recording["gyro.x"]` is a Channel, `recording[10.0:20.0]` the recording from 10 s to 20 s.
    """

    __slots__ = ("_channels", "_core", "_source")

    def __init__(self, core: _tumble.Recording, source: Source | None = None) -> None:
        self._core = core
        self._source = source  # how to read the file again: the way to pickle it
        channels = (Channel(core.channel(i)) for i in range(len(core)))
        self._channels = {channel.name: channel for channel in channels}

    @overload
    def __getitem__(self, key: str) -> Channel: ...

    @overload
    def __getitem__(self, key: slice) -> Recording: ...

    def __getitem__(self, key: str | slice) -> Channel | Recording:
        if isinstance(key, slice):
            if key.step is not None:
                raise UsageError("a recording is cut as recording[begin:end] in seconds; a step is not accepted")
            return self.between(key.start, key.stop)
        if not isinstance(key, str) or key not in self._channels:
            raise KeyError(f"no channel {shown(key)}; channels are {', '.join(self._channels)}")
        return self._channels[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._channels)

    def __len__(self) -> int:
        return len(self._channels)

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__

    @property
    def file(self) -> str:
        """The file it was read from; empty for simulated data."""
        return self._core.file

    @property
    def sha256(self) -> str:
        """SHA-256 of the file, or of the samples of a recording made in memory; empty for simulated data."""
        return self._core.sha256()

    @property
    def instrument(self) -> str:
        """Model and serial number, as the file says."""
        return self._core.instrument

    @property
    def meta(self) -> dict[str, str]:
        """All further texts of the file."""
        return self._core.meta

    @property
    def marks(self) -> tuple[Mark, ...]:
        """Where segments begin, in order of time."""
        return tuple(Mark(*mark) for mark in self._core.marks)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What the reader noticed."""
        return findings_of(json.loads(self._core.findings))

    @property
    def duration(self) -> float:
        """From the first sample to the last of any channel [s]."""
        spans = [(channel.start, channel._core.end) for channel in self.values() if len(channel)]
        return max(end for _, end in spans) - min(start for start, _ in spans) if spans else 0.0

    def check(self) -> tuple[Finding, ...]:
        """Findings of the reader and of all checks: gaps, outliers, stuck outputs ... (docs/checks.md)"""
        return findings_of(json.loads(self._core.check()))

    def between(self, begin: float | str | None, end: float | str | None) -> Recording:
        """The samples from `begin` (included) to `end` (not included) [s]; None: from the first, to the last.

        Text such as "2 min" and quantities of pint are accepted, too; and so is `recording["1 min":"2 min"]`.
        """
        bounds = _bound(begin, -math.inf, "begin"), _bound(end, math.inf, "end")
        part = Recording(self._core.between(*bounds))
        if not any(len(channel) for channel in part.values()):
            raise DataError(f"there is no sample from {bounds[0]:g} s to {bounds[1]:g} s in {self!r}")
        return part

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the recording; the end of the name selects the format (.csv, .h5)."""
        _tumble.write(self._core, path_text(path, "path"))

    def to_pandas(self) -> Any:
        """A pandas DataFrame: columns in their shown units, index in seconds, units in `attrs["units"]`.

        Raises UsageError where the channels are not sampled together.
        """
        return _frames.recording_to_pandas(self)

    def to_polars(self) -> Any:
        """A polars DataFrame with the column time and one column a channel, named `name[unit]`."""
        return _frames.recording_to_polars(self)

    def to_xarray(self) -> Any:
        """An xarray Dataset along time, with attributes unit and rate."""
        return _frames.recording_to_xarray(self, self.meta)

    def __copy__(self) -> Recording:
        return self

    def __deepcopy__(self, memo: object) -> Recording:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self._source is not None:
            again, arguments = self._source
            return again, (*arguments, self.sha256)
        parts = [channel._parts() for channel in self.values()]
        marks = [tuple(mark) for mark in self.marks]
        return rebuild, (parts, marks, self.file, self.instrument, self.meta, SIGNED if self.sha256 else UNSIGNED)

    def __repr__(self) -> str:
        names = ", ".join(self._channels)
        return f"<Recording {self.file or '(in memory)'}: {names}; {self.duration:.6g} s>"

    def _repr_html_(self) -> str:
        from tumble._html import recording_table

        return recording_table(f"{self.file or 'in memory'}, {self.duration:.6g} s", self.values())


def _bound(time: float | str | None, all_of_it: float, argument: str) -> float:
    """A time [s]; `all_of_it` for None, and for itself."""
    unbounded = time is None or (isinstance(time, float) and time == all_of_it)
    return all_of_it if unbounded else seconds_of(time, argument)


SIGNED, UNSIGNED, OF_FILE = "samples", "", "file"
"""What the checksum of a recording is of."""


def rebuild(
    parts: Sequence[Parts],
    marks: Sequence[tuple[Any, ...]],
    file: str,
    instrument: str,
    meta: dict[str, str],
    checksum: str,
    si: bool = True,
) -> Recording:
    """A recording from name, unit, values, start, rate and stamps of each channel; values in SI where `si`."""
    channels = [_tumble.ChannelParts(*part, si) for part in parts]
    full = [(mark.label, mark.begin, mark.run, mark.end) for mark in (Mark(*one) for one in marks)]
    return Recording(_tumble.make_recording(channels, full, file, instrument, meta, checksum))


def rebuilt(parts: Sequence[Parts], path: str, meta: dict[str, str]) -> Recording:
    """A recording that an importer read from a file, of name, unit, values [unit], start, rate and stamps."""
    return rebuild(parts, [], path, "", meta, OF_FILE, si=False)
