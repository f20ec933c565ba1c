"""What tables have in common: columns named `gyro.x[deg/s]`, one of which may be the time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from tumble._tumble import Unit
from tumble.importers import Column

_NAMED = re.compile(r"^(?P<name>.+?)\s*\[(?P<unit>[^\[\]]*)\]$")


def columns_of(named: Iterable[tuple[str, Any]], units: Mapping[str, str | None]) -> tuple[list[Column], list[str]]:
    """Columns of numbers with their times, and the names of those that hold none.

    Given     named  header and values (array) of each column
              units  of headers without one, as the file or the user says
    """
    import numpy as np

    numbers, skipped, times = [], [], None
    for header, values in named:
        name, unit = named_with_unit(header)
        unit = unit if unit is not None else units.get(header) or None
        array = np.asarray(values)
        if array.dtype.kind in "mM" and times is None:
            times = array
        elif array.dtype.kind not in "iuf":
            skipped.append(header)
        elif times is None and (seconds := _seconds(name, unit)):
            times = array.astype(np.float64) * seconds
        else:
            numbers.append((name, unit, header, array))
    return [Column(*one, times) for one in numbers], skipped


def named_with_unit(header: str) -> tuple[str, str | None]:
    """Name and unit of `gyro.x[deg/s]`; the unit of a name alone is None."""
    match = _NAMED.match(header)
    return (match["name"], match["unit"]) if match else (header, None)


def _seconds(name: str, unit: str | None) -> float | None:
    """The unit of a column of times [s]; None for another column, such as a temperature that is called T."""
    if name.lower() not in ("time", "t", "timestamp") or not unit:
        return None
    found = Unit.parse(unit)
    return found.factor if found.dimension == "s" else None
