"""Recordings from files and arrays."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import IO, TYPE_CHECKING, Any

from tumble import _tumble
from tumble._arrays import samples_of, times_of
from tumble._errors import DataError, FileError, TumbleError, UsageError, wrong_type, wrong_value
from tumble._progress import listener
from tumble._recording import SIGNED, Mark, Recording, Source, rebuild
from tumble._text import (
    count_of,
    is_quantity,
    is_unit,
    listed,
    path_text,
    quantity_of,
    rate_of,
    seconds_of,
    text_of,
    units_of,
    whole_text,
    words_of,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def read(
    path: str | os.PathLike[str] | IO[bytes],
    *,
    format: str | None = None,
    channels: Iterable[str] | None = None,
    topics: Iterable[str] | None = None,
    rate: float | str | None = None,
    units: Mapping[str, str] | None = None,
    columns: Sequence[str] | None = None,
    segment_column: str | None = None,
    missing: str | None = None,
    decimal: str | None = None,
    time: str | None = None,
    date: str | None = None,
    encoding: str | None = None,
    skip: int | None = None,
    frames: str | os.PathLike[str] | None = None,
    progress: object = None,
) -> Recording:
    """Reads a recording.

    Given     path            file, or an open binary file
              format          name in tumble.formats, or of an importer; None: by content
              channels        names of those to read; None: all
              topics          of a log, those to read: ["/imu/data_raw"]; None: as the format chooses
              rate            [Hz] where the file has no time
              units           of columns without a unit: {"gyro.x": "deg/h"}
              columns         of a text file without a header: ["time[s]", "x[deg/s]"]; "-" skips one
              segment_column  of a text file: the column with the labels of segments
              missing         a word that means a missing sample, beside the blank cell: "NaN"
              decimal         decimal mark of a text file: "point" or "comma"
              time            of a text file: the column of the clock; "-": it has none
              date            of a text file: order in its dates: "dmy", "mdy" or "ymd"
              encoding        of a text file: "gb18030", "windows-1252"; None: by its bytes
              skip            of a text file: lines before its header
              frames          of raw bytes: the instrument that sent them, "stim300", or a file that declares its
                              frames; variants follow: "kvh_1775:gyro_rate"
              progress        None, True (a bar), or a function of (done, what)
    Raises    FileError that says file and line; UsageError; ArgumentTypeError
    Example   tumble.read("data.csv", rate=100, units={"gyro.x": "deg/s"})
    """
    given: dict[str, Any] = {
        "format": None if format is None else whole_text(format, "format"),
        "channels": None if channels is None else words_of(channels, "channels"),
        "topics": None if topics is None else words_of(topics, "topics"),
        "rate": rate,
        "units": None if units is None else units_of(units),
        "columns": None if columns is None else words_of(columns, "columns"),
        "segment_column": segment_column,
        "missing": missing,
        "decimal": decimal,
        "time": time,
        "date": date,
        "encoding": encoding,
        "skip": skip,
        "frames": frames,
    }
    if hasattr(path, "read"):
        return _read_open_file(path, given, progress)
    text = path_text(path, "path")
    if (imported := _imported(text, given)) is not None:
        return imported
    with listener(progress) as call:
        core = _tumble.read(text, _sets(given), given["channels"] or [], format, call)
    return Recording(core, _source_of(text, given))


PLAIN = ("rate", "segment_column", "missing", "decimal", "time", "date", "encoding", "skip", "frames")
"""The arguments of read() that --set takes as they are."""


def _imported(path: str, given: Mapping[str, Any]) -> Recording | None:
    """The recording of a file that only an importer in Python reads, or that it is to read; None for all others."""
    from tumble._catalogue import formats

    suffix, name = os.path.splitext(path)[1].lower(), given["format"]
    known = any(suffix in entry["extensions"] for entry in formats.values()) if name is None else name in formats
    if known or not os.path.exists(path):
        return None
    from tumble.importers import Request, importer_of, importers

    importer = importer_of(path) if name is None else next((one for one in importers() if one.name == name), None)
    if importer is None:
        return None
    missing = "nan" if str(given["missing"]).lower() == "nan" else None
    request = Request(given["channels"], given["rate"], given["units"] or {}, missing)
    try:
        recording = importer.read(path, request)
    except (TumbleError, MemoryError):
        raise
    except Exception as error:  # of whatever package reads the file
        raise FileError(f"{path}: {importer.name} cannot read it: {error}") from error
    recording._source = _source_of(path, given)
    return recording


def _source_of(path: str, given: Mapping[str, Any]) -> Source:
    """How to read the file again, from any folder."""
    return read_again, (os.path.abspath(path), {key: value for key, value in given.items() if value is not None})


def read_again(path: str, arguments: dict[str, Any], sha256: str) -> Recording:
    """The recording of a pickle: its file is read again. Raises DataError where the file is another one now."""
    recording = read(path, **arguments)
    if recording.sha256 != sha256:
        raise DataError(f"{path}: the file has changed since the recording was pickled")
    return recording


def _sets(given: Mapping[str, Any]) -> list[tuple[str, str]]:
    sets = []
    if given["columns"] is not None:
        sets.append(("columns", ",".join(given["columns"])))
    for topic in given["topics"] or ():
        sets.append(("topic", topic))
    for key in PLAIN:
        if given[key] is not None:
            sets.append((key, text_of(given[key], key)))
    sets += [(f"unit.{column}", unit) for column, unit in (given["units"] or {}).items()]
    return sets


def _read_open_file(file: Any, given: Mapping[str, Any], progress: object) -> Recording:
    """Of an open file the bytes are copied to a temporary one: formats are recognised by content and read by name."""
    import tempfile

    try:
        content = file.read()
    except Exception as error:  # of whatever unpacks it
        raise FileError(f"argument path: the open file cannot be read: {error}") from error
    if isinstance(content, str):
        content = content.encode()
    if not isinstance(content, (bytes, bytearray, memoryview)):
        raise wrong_type("path", file, "accepted are a path and an open file, whose read() gives bytes")
    named = getattr(file, "name", None)  # a number, where the file was opened by one
    name = os.path.basename(named) if isinstance(named, str) and "\0" not in named else ""
    name = "recording" if name in ("", ".", "..") else name
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, name)
        with open(copy, "wb") as target:
            target.write(content)
        if (imported := _imported(copy, given)) is not None:
            imported.sha256  # noqa: B018 - while the file is there
            imported._source = None
            return imported
        with listener(progress) as call:
            core = _tumble.read(copy, _sets(given), given["channels"] or [], given["format"], call)
        core.sha256()
    return Recording(core)


def from_arrays(
    channels: Mapping[str, tuple[ArrayLike, str] | Any],
    *,
    rate: float | str | None = None,
    time: ArrayLike | None = None,
    start: float | str = 0.0,
    marks: Sequence[tuple[Any, ...]] = (),
    missing: str | None = None,
    instrument: str = "",
    name: str = "arrays",
) -> Recording:
    """A recording of arrays that you have. The samples are copied once.

    Given     channels    by name: (array, unit), or a pint quantity; by "name[unit]": array; each array
                          one-dimensional, shape (n,)
              rate        [Hz] of even samples, or text such as "100 Hz"; else
              time        [s] stamp of each sample, shape (n,); or dates, which count from the first
              start       [s] time of the first sample, with rate; also "2 min"
              marks       (label, begin [s]) or (label, begin [s], power-up) of each segment
              missing     "nan": NaN means a missing sample; None: NaN is refused
              instrument  model and serial number
              name        what messages call it
    Raises    ArgumentTypeError, UsageError, DataError that name the channel, what was given and what is accepted
    Example   tumble.from_arrays({"gyro.x": (x, "deg/s"), "temperature": (t, "degC")}, rate=100)
    """
    if not isinstance(channels, Mapping) or not channels:
        raise wrong_type("channels", channels, 'accepted is a dict such as {"gyro.x": (array, "deg/s")}')
    if (rate is None) == (time is None):
        raise UsageError("arguments rate and time: give one of them: the sampling rate [Hz], or a stamp [s] a sample")
    hertz = 0.0 if rate is None else rate_of(rate)
    begin = seconds_of(start, "start")
    stamps = None if time is None else times_of(time, "time")
    parts: list[tuple[str, str, Any, float, float, Any]] = []
    for key, given in channels.items():
        channel, values, unit = _with_unit(key, given)
        if any(channel == before[0] for before in parts):
            raise UsageError(f"argument channels: the name {channel!r} is given twice; accepted are different names")
        numbers = samples_of(values, f"channels[{key!r}]", missing)
        if stamps is not None and len(stamps) != len(numbers):
            raise UsageError(
                f"argument time: {len(stamps)} stamps were given for the {len(numbers)} samples of {key!r}; accepted "
                "is one stamp a sample"
            )
        parts.append((channel, unit, numbers, begin, hertz, stamps))
    texts = whole_text(name, "name"), whole_text(instrument, "instrument")
    return rebuild(parts, _marks_of(marks), *texts, {}, SIGNED, si=False)


def _marks_of(marks: object) -> list[Mark]:
    """Marks in order of time. Raises ArgumentTypeError."""
    accepted = "accepted is a list of (label, begin [s]), (label, begin, power-up) or tumble.Mark"
    made = []
    for one in listed(marks, "marks", accepted):
        if not isinstance(one, (tuple, list)) or not 2 <= len(one) <= 4 or not isinstance(one[0], str):
            raise wrong_type("marks", one, accepted)
        label, begin = one[0], one[1]
        run, end = one[2] if len(one) > 2 else 1, one[3] if len(one) > 3 else math.inf
        until = math.inf if isinstance(end, float) and end == math.inf else seconds_of(end, "marks")
        made.append(Mark(whole_text(label, "marks"), seconds_of(begin, "marks"), count_of(run, "marks", 1), until))
    return sorted(made, key=lambda mark: mark.begin)


def _with_unit(key: object, given: Any) -> tuple[str, Any, str]:
    """Name, samples and unit of a channel: {"gyro": (x, "deg/s")}, {"gyro[deg/s]": x}, or a pint quantity."""
    if not isinstance(key, str):
        raise wrong_type("channels", key, "accepted are names of channels as text")
    whole_text(key, "channels")
    if is_quantity(given):
        return key, *quantity_of(given)
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str):
        if is_quantity(given[0]):
            raise wrong_value(
                f"channels[{key!r}]", given, "a quantity has its unit already: give it without another one"
            )
        return key, given[0], whole_text(given[1], f"channels[{key!r}]")
    if isinstance(given, tuple) and len(given) == 2 and is_unit(given[1]):
        return key, *quantity_of(given[0] * given[1])
    name, bracket, unit = key.partition("[")
    if name and bracket and unit.endswith("]"):
        return name, given, unit[:-1]
    raise wrong_type(
        f"channels[{key!r}]",
        given,
        'the unit is absent; accepted are {"gyro": (x, "deg/s")} and, as in the header of a table, {"gyro[deg/s]": x}, '
        'with "1" for numbers without a dimension',
    )
