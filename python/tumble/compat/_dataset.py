"""The class Dataset of AllanTools."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from tumble._text import one_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

KINDS = ("theo1", "mtie", "tierms")
KEYS = ("taus", "stat", "stat_err", "stat_n")


class Dataset:
    """Data with their rate and type, and what was calculated last: `inp` and `out` as of AllanTools."""

    def __init__(
        self, data: ArrayLike | None = None, rate: float = 1.0, data_type: str = "phase", taus: Any = None
    ) -> None:
        self.out: dict[str, Any] = dict.fromkeys((*KEYS, "stat_unc", "stat_id"))
        self.inp: dict[str, Any] = {}
        self.set_input(data, rate, data_type, taus)

    def set_input(self, data: ArrayLike | None, rate: float = 1.0, data_type: str = "phase", taus: Any = None) -> None:
        """Replaces the data, the rate [Hz], the type and the averaging times [s]."""
        self.inp = {"data": data, "rate": rate, "data_type": data_type, "taus": taus}

    def compute(self, function: str) -> dict[str, Any]:
        """Calculates an estimator given by its name, for example "oadev". Returned: taus, stat, stat_err, stat_n."""
        from tumble.compat import allantools

        one_of(function, "function", [name for name in allantools.__all__ if name in KINDS or name.endswith("dev")])
        found = getattr(allantools, function)(**self.inp)
        result = dict(zip(KEYS, found, strict=True))
        self.out = {**result, "stat_id": function}
        return result

    def write_results(
        self, filename: str | os.PathLike[str], digits: int = 5, header_params: dict[str, Any] | None = None
    ) -> None:
        """Writes what was calculated as a table of text, in the columns of AllanTools."""
        from tumble._result import write_whole

        name, width = self.out["stat_id"], digits + 5
        head = [f"# Input data type: {self.inp['data_type']}", f"# Input data rate: {self.inp['rate']}"]
        head += [f"# {key}: {value}" for key, value in (header_params or {}).items()]
        head.append(
            f"{'AF':>5s} {'Tau':>{width}s} {'N':>10s} {'alpha':>5s} {'min_' + name:>{width}} {name:>{width}} "
            f"{'max_' + name:>{width}} "
        )
        rows = zip(*(self.out[key] for key in KEYS), strict=True)
        write_whole(os.fspath(filename), "\n".join([*head, *(self._row(row, digits - 1) for row in rows)]) + "\n")

    def _row(self, row: tuple[Any, ...], digits: int) -> str:
        tau, value, error, terms = row
        low, middle, high = (f"{one:.{digits}e}" for one in (value - error / 2, value, value + error / 2))
        return (
            f"{int(tau / self.out['taus'][0]):5d} {tau:.{digits}e} {int(terms):10d} {'NaN':5s} {low} {middle} {high} "
        )
