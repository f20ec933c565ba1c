"""Recordings: channels with their times, marks and origin, and the ways to get one."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, overload

from tumble import _tumble
from tumble._errors import DataError, UsageError, shown
from tumble._finding import Finding, findings_of
from tumble._text import path_text, seconds_of, unit_of

if TYPE_CHECKING:
    import os

    import numpy as np
    from numpy.typing import NDArray


class Mark(NamedTuple):
    """The beginning of a segment: its label, when it begins and ends [s], and which power-up it belongs to."""

    label: str
    begin: float
    run: int = 1
    end: float = float("inf")


class Channel:
    """One signal of a recording.

    `values` are in SI, in the unit `unit`. The file or you wrote them in `shown_unit`; `in_()` gives them so.
    """

    __slots__ = ("_core",)

    def __init__(self, core: _tumble.Channel) -> None:
        self._core = core

    @property
    def name(self) -> str:
        """Name, for example gyro.x."""
        return self._core.name

    @property
    def kind(self) -> str:
        """What it measures: angular_rate, specific_force, temperature ..."""
        return self._core.kind

    @property
    def unit(self) -> str:
        """Unit of `values`, in SI base units: rad/s, m/s^2, K."""
        return self._core.unit.dimension

    @property
    def shown_unit(self) -> str:
        """Unit in which the file has the values."""
        return self._core.unit.text

    @property
    def values(self) -> NDArray[np.float64]:
        """The samples [unit], shape (n,). A read-only view that shares the memory of the recording; NaN is missing."""
        return self._core.values

    @property
    def times(self) -> NDArray[np.float64]:
        """Time of each sample [s], shape (n,). Stamps are shared; the times of even samples are calculated."""
        return self._core.times

    @property
    def rate(self) -> float:
        """Sampling rate [Hz]; lost samples do not change it."""
        return self._core.rate

    @property
    def start(self) -> float:
        """Time of the first sample [s]."""
        return self._core.start

    @property
    def uniform(self) -> bool:
        """Whether start and rate give all times; else each sample has a stamp."""
        return self._core.uniform

    @property
    def missing(self) -> int:
        """Number of missing samples."""
        return self._core.missing

    def in_(self, unit: str | object | None = None) -> NDArray[np.float64]:
        """A copy of the samples in `unit`, text or a unit of pint, by default in `shown_unit`.

        Raises UsageError where the unit has another dimension. Example: `recording["gyro.x"].in_("deg/h")`
        """
        target = self._core.unit if unit is None else unit_of(unit, "unit")
        if target.dimension != self._core.unit.dimension:
            raise UsageError(
                f"argument unit: {unit!r} has the dimension [{target.dimension}]; channel '{self.name}' is in "
                f"{self.shown_unit} [{self.unit}]"
            )
        return (self.values - target.offset) / target.factor

    def __len__(self) -> int:
        return len(self._core)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        import numpy as np

        return np.asarray(self.values, dtype=dtype) if copy is None else np.array(self.values, dtype=dtype, copy=copy)

    def __copy__(self) -> Channel:
        return self

    def __deepcopy__(self, memo: object) -> Channel:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _channel_of, (self._parts(),)

    def _parts(self) -> tuple[Any, ...]:
        times = None if self.uniform else self.times
        return self.name, self.shown_unit, self.values, self.start, self.rate, times

    def __repr__(self) -> str:
        return f"<Channel {self.name} [{self.shown_unit}], {len(self)} samples at {self.rate:.6g} Hz>"


class Recording(Mapping[str, Channel]):
    """What was measured in one file: channels by name, marks, and where it comes from. It cannot be changed.

    `recording["gyro.x"]` is a Channel, `recording[10.0:20.0]` the recording from 10 s to 20 s.
    """

    __slots__ = ("_channels", "_core", "_source")

    def __init__(self, core: _tumble.Recording, source: tuple[str, dict[str, Any]] | None = None) -> None:
        self._core = core
        self._source = source  # path and arguments of read(): the way to pickle it
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
        from tumble._frames import recording_to_pandas

        return recording_to_pandas(self)

    def to_polars(self) -> Any:
        """A polars DataFrame with the column time and one column a channel, named `name[unit]`."""
        from tumble._frames import recording_to_polars

        return recording_to_polars(self)

    def to_xarray(self) -> Any:
        """An xarray Dataset along time, with attributes unit and rate."""
        from tumble._frames import recording_to_xarray

        return recording_to_xarray(self)

    def __copy__(self) -> Recording:
        return self

    def __deepcopy__(self, memo: object) -> Recording:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self._source is not None:
            return _read_again, (*self._source, self.sha256)
        parts = [channel._parts() for channel in self.values()]
        marks = [tuple(mark) for mark in self.marks]
        return _rebuild, (parts, marks, self.file, self.instrument, self.meta, SIGNED if self.sha256 else UNSIGNED)

    def __repr__(self) -> str:
        names = ", ".join(self._channels)
        return f"<Recording {self.file or '(in memory)'}: {names}; {self.duration:.6g} s>"

    def _repr_html_(self) -> str:
        from tumble._html import recording_table

        return recording_table(self)


def _bound(time: float | str | None, all_of_it: float, argument: str) -> float:
    """A time [s]; `all_of_it` for None, and for itself."""
    unbounded = time is None or (isinstance(time, float) and time == all_of_it)
    return all_of_it if unbounded else seconds_of(time, argument)


Parts = Sequence[tuple[str, str, Any, float, float, Any]]


SIGNED, UNSIGNED, OF_FILE = "samples", "", "file"
"""What the checksum of a recording is of."""


def _rebuild(
    parts: Parts,
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


def _channel_of(part: tuple[Any, ...]) -> Channel:
    """What a pickled channel becomes."""
    made: Channel = _rebuild([part], [], "", "", {}, UNSIGNED)[str(part[0])]
    return made


def rebuilt(parts: Parts, path: str, meta: dict[str, str]) -> Recording:
    """A recording that an importer read from a file, of name, unit, values [unit], start, rate and stamps."""
    return _rebuild(parts, [], path, "", meta, OF_FILE, si=False)


def _read_again(path: str, arguments: dict[str, Any], sha256: str) -> Recording:
    """What a pickled recording becomes: its file is read again. Raises DataError where the file is another one now."""
    from tumble._read import read

    recording = read(path, **arguments)
    if recording.sha256 != sha256:
        raise DataError(f"{path}: the file has changed since the recording was pickled")
    return recording
