"""What tables have in common: columns named `gyro.x[deg/s]`, one of which may be the time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from tumble._tumble import Unit
from tumble.importers import Column

_NAMED = re.compile(r"^(?P<name>.+?)\s*\[(?P<unit>[^\[\]]*)\]$")


def columns_of(named: Iterable[tuple[str, Any]], units: Mapping[str, str]) -> tuple[list[Column], list[str]]:
    """Columns of numbers with their times, and the names of those that hold none.

    Given     named  header and values (array) of each column
              units  of headers without one, as the file says
    """
    import numpy as np

    numbers, skipped, times = [], [], None
    for header, values in named:
        match = _NAMED.match(header)
        name = match["name"] if match else header
        unit = match["unit"] if match else units.get(header)
        array = np.asarray(values)
        if array.dtype.kind in "mM" and times is None:
            times = array
        elif array.dtype.kind not in "iuf":
            skipped.append(header)
        elif name.lower() in ("time", "t", "timestamp") and times is None and unit:
            seconds = Unit.parse(unit)
            times = array.astype(np.float64) * seconds.factor
        else:
            numbers.append((name, unit, header, array))
    return [Column(*one, times) for one in numbers], skipped
