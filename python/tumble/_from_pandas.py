"""Recordings of data frames of pandas."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from tumble._arrays import samples_of, times_of
from tumble._errors import DataError, UsageError, wrong_type, wrong_value
from tumble._read import from_arrays
from tumble._recording import Recording
from tumble._text import rate_of, units_of

_NAMED = re.compile(r"^(?P<name>.+?)\s*\[(?P<unit>[^\[\]]*)\]$")


def from_pandas(
    df: Any,
    *,
    units: Mapping[str, str] | None = None,
    rate: float | str | None = None,
    time: str | None = None,
    missing: str | None = None,
    instrument: str = "",
    name: str = "dataframe",
) -> Recording:
    """A recording of a pandas DataFrame.

    Given     df       columns named "gyro.x[deg/s]", or "gyro.x" with a unit in `units` or df.attrs["units"]
              units    by column; columns without a unit are refused. Columns of a MultiIndex are called "gyro.x"
              rate     [Hz] of even samples; else the times come from
              time     the name of a column with stamps; None: the index (seconds, or date and time)
              missing  "nan": NaN means a missing sample; None: NaN is refused
    Raises    ArgumentTypeError, UsageError, DataError that name the column, what was given and what is accepted
    Example   tumble.from_pandas(df, units={"gyr_x": "deg/s", "acc_x": "m/s^2"}, rate=204.8)
    """
    if not hasattr(df, "columns") or not hasattr(df, "iloc") or isinstance(df, type):
        raise wrong_type("df", df, "accepted is a pandas DataFrame")
    known = {**units_of(df.attrs.get("units"), 'df.attrs["units"]'), **units_of(units)}
    if time is not None and not isinstance(time, (str, int, tuple)):
        raise wrong_type("time", time, "accepted is the name of a column")
    channels: dict[str, Any] = {}
    without = []
    for position, column in enumerate(df.columns):
        if time is not None and column == time:
            continue
        plain = ".".join(map(str, column)) if isinstance(column, tuple) else str(column)
        named = _NAMED.match(plain)
        unit = known.get(column) or known.get(plain) or (named["unit"] if named else None)
        channel = named["name"] if named and column not in known and plain not in known else plain
        if unit is None:
            without.append(plain)
        elif channel in channels:
            raise UsageError(f"argument df: two columns are called {channel!r}; accepted are different names")
        else:
            channels[channel] = (df.iloc[:, position], unit)
    if without:
        raise UsageError(
            f"argument units: columns {', '.join(without)} have no unit; accepted are "
            f"units={{'{without[0]}': 'deg/s'}} and columns named '{without[0]}[deg/s]'"
        )
    if not channels or not len(df):
        raise DataError(
            f"argument df: {len(channels)} columns and {len(df)} rows of samples were given; accepted are more"
        )
    stamps = _stamps(df, time, rate)
    return from_arrays(channels, rate=rate, time=stamps, missing=missing, instrument=instrument, name=name)


def _stamps(df: Any, time: str | None, rate: float | str | None) -> Any:
    """Stamps [s]; None with a rate, which the index must not contradict."""
    if time is not None and time not in df.columns:
        raise wrong_value("time", time, f"there is no such column; columns are {', '.join(map(str, df.columns))}")
    index = df.index if time is None else df[time]
    numbers = getattr(index.dtype, "kind", "O") in "iuf" if hasattr(index, "dtype") else False
    counts = time is None and numbers and index.name is None and index.dtype.kind in "iu"
    if rate is None:
        if counts:
            raise UsageError(
                "argument rate: the index only counts rows; accepted are rate, time, and an index of times"
            )
        return times_of(index, "time")
    if counts:
        _refuse_gap(samples_of(index, "df.index"), None)
    elif time is not None or getattr(index.dtype, "kind", "O") in "mM":
        _refuse_gap(times_of(index, "time"), rate)
    return None


def _refuse_gap(stamps: Any, rate: float | str | None) -> None:
    """Raises DataError where rows are missing; with a rate, also where the stamps say another one or run backwards."""
    import numpy as np

    if len(stamps) < 3:
        return
    steps = np.diff(stamps)
    longest, usual = int(np.argmax(steps)), float(np.median(steps))
    if rate is None:
        if steps.min() > 0 and steps[longest] > 1.5 * usual:
            raise DataError(
                f"argument df: the index goes from {stamps[longest]:g} to {stamps[longest + 1]:g} after row {longest}: "
                "rows are missing; accepted are all rows (missing='nan' for NaN), or df.reset_index(drop=True) where "
                "the samples are even all the same"
            )
        return
    expected = 1.0 / rate_of(rate)
    if steps[longest] > 1.5 * expected and steps[longest] > 1.5 * usual:
        raise DataError(
            f"argument rate: {rate} was given, but the stamps have a gap of {steps[longest]:.6g} s after row {longest};"
            " without rate the stamps are used and the gap becomes a finding"
        )
    if not 0.5 * expected < usual < 2.0 * expected:
        raise DataError(
            f"argument rate: {rate} was given, but the stamps are {usual:.6g} s apart; without rate the stamps are used"
        )
