"""One signal of a recording, with its times and its units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tumble import _tumble
from tumble._errors import UsageError
from tumble._text import unit_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Parts = tuple[str, str, Any, float, float, Any]
"""Name, unit, values, start [s], rate [Hz] and stamps [s] of a channel; None: even samples."""


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

    def _parts(self) -> Parts:
        """Name, shown unit, values [unit], start [s], rate [Hz] and stamps [s]: what a channel is made of."""
        times = None if self.uniform else self.times
        return self.name, self.shown_unit, self.values, self.start, self.rate, times

    def __repr__(self) -> str:
        return f"<Channel {self.name} [{self.shown_unit}], {len(self)} samples at {self.rate:.6g} Hz>"


def _channel_of(parts: Parts) -> Channel:
    """The channel of a pickle."""
    return Channel(_tumble.make_recording([_tumble.ChannelParts(*parts, True)], [], "", "", {}, "").channel(0))
