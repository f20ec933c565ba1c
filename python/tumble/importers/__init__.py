"""Readers in Python, for formats whose well-kept readers are Python packages.

`tumble.read` uses them by the end of the file name where the library itself does not know it. A package of yours adds
one by an entry point of the group `tumble.importers` that leads to an `Importer`.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from tumble._arrays import samples_of, times_of
from tumble._errors import DataError, TumbleError, TumbleWarning, UsageError
from tumble._recording import Recording, rebuilt
from tumble._text import rate_of

GROUP = "tumble.importers"
BUILT_IN = ("parquet", "rosbag", "tdms", "xlsx")


class Request(NamedTuple):
    """What the user says beside the file: the arguments of tumble.read."""

    channels: Sequence[str] | None = None
    rate: float | str | None = None
    units: Mapping[str, str] = {}
    missing: str | None = None


class Importer(NamedTuple):
    """A reader: `read(path, request)` returns a recording; `suffixes` are the ends of the names of its files."""

    name: str
    summary: str
    suffixes: tuple[str, ...]
    read: Callable[[str, Request], Recording]


class Column(NamedTuple):
    """A column of a file: the name and unit of its channel, its name in the file, samples, and times or rate.

    `unit` is None where the file does not say it; `times` [s] or `rate` [Hz] and `start` [s] say when the samples are.
    """

    name: str
    unit: str | None
    source: str
    values: Any
    times: Any = None
    rate: float | None = None
    start: float = 0.0


def importers() -> Iterator[Importer]:
    """All importers: those of Tumble, then those of other packages."""
    from importlib import import_module
    from importlib.metadata import entry_points

    for name in BUILT_IN:
        yield import_module(f"{__name__}.{name}").importer
    for entry in entry_points(group=GROUP):
        try:
            one = entry.load()
        except Exception as error:  # another package is broken: what others read goes on
            warnings.warn(f"importer {entry.name} ({entry.value}): {error}", TumbleWarning, stacklevel=2)
            continue
        if isinstance(one, Importer):
            yield one
        else:
            text = (
                f"importer {entry.name} ({entry.value}): {one!r} was found, where a tumble.importers.Importer is wanted"
            )
            warnings.warn(text, TumbleWarning, stacklevel=2)


def importer_of(path: str) -> Importer | None:
    """The importer for the end of the name of a file, or None."""
    suffix = os.path.splitext(path)[1].lower()
    return next((one for one in importers() if suffix in one.suffixes), None)


def recording_of(
    path: str, importer: str, columns: Sequence[Column], request: Request, skipped: Sequence[str] = ()
) -> Recording:
    """A recording of the columns of a file.

    Given     columns  all that hold numbers; request.channels selects among them
              skipped  names of what the importer cannot use
    Raises    UsageError for columns without a unit, and names that the file does not have; DataError without columns
    """
    wanted = _selected(path, columns, request, skipped)
    _refuse_without_unit(path, wanted, request)
    names = [column.name for column in wanted]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DataError(f"{path}: several columns are called {', '.join(twice)}; accepted are different names")
    rate = None if request.rate is None else rate_of(request.rate)
    parts = []
    for column in wanted:
        times = None if column.times is None else _named(path, times_of, column.times, f"times of {column.source!r}")
        hertz = column.rate or rate
        if times is None and hertz is None:
            raise UsageError(f"{path}: column {column.source!r} has no times; accepted is rate=...")
        unit = request.units.get(column.name) or request.units.get(column.source) or column.unit or "1"
        values = _named(path, samples_of, column.values, column.source, request.missing)
        if times is not None and len(times) != len(values):
            raise DataError(
                f"{path}: column {column.source!r} has {len(values)} values, and its times are {len(times)}; accepted "
                "is a time for each value, and channels=[...] to read others alone"
            )
        parts.append((column.name, unit, values, column.start, 0.0 if hertz is None else hertz, times))
    others = [column.source for column in columns if column not in wanted]
    meta = {"importer": importer, **{f"source.{column.name}": column.source for column in wanted}}
    if skipped or others:
        meta["skipped"] = ", ".join([*others, *skipped])
    try:
        return rebuilt(parts, path, meta)
    except UsageError as error:  # units
        raise UsageError([f"{path}: {one}" for one in error.problems]) from error


def _named(path: str, arrays: Callable[..., Any], *arguments: Any) -> Any:
    """What the function of _arrays returns, or its problems with the name of the file."""
    try:
        return arrays(*arguments)
    except TumbleError as error:
        problems = [one.replace("argument ", "column ", 1) for one in error.problems]
        raise type(error)([f"{path}: {one}" for one in problems]) from error


def _selected(path: str, columns: Sequence[Column], request: Request, skipped: Sequence[str]) -> list[Column]:
    if not columns:
        others = f"; its columns of something else are {', '.join(skipped)}" if skipped else ""
        raise DataError(f"{path}: holds no column of numbers{others}")
    if request.channels is None:
        return list(columns)
    known = {one.name: one for one in columns}
    absent = [name for name in request.channels if name not in known]
    if absent:
        raise UsageError(f"{path}: no column {', '.join(absent)}; columns are {', '.join(known)}")
    return [known[name] for name in request.channels]


def _refuse_without_unit(path: str, columns: Sequence[Column], request: Request) -> None:
    without = [
        one.name for one in columns if not (one.unit or one.name in request.units or one.source in request.units)
    ]
    if without:
        raise UsageError(
            f"{path}: columns {', '.join(without)} have no unit; accepted are units={{'{without[0]}': 'deg/s'}}, and "
            "channels=[...] to read others alone"
        )
