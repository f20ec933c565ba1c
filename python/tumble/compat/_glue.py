"""Conversions of AllanTools: phase, frequency, averaging times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tumble import _tumble
from tumble._errors import UsageError
from tumble.compat._arguments import number_of, numbers_of, taus_of, values_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]


def trim_data(x: ArrayLike) -> Array:
    """The data without the NaN at both ends."""
    import numpy as np

    values = numbers_of(x, "x")
    if values.ndim != 1:
        raise UsageError(f"argument x: an array of shape {values.shape} was given; accepted is one dimension")
    there = np.flatnonzero(~np.isnan(values))
    return values[there[0] : there[-1] + 1] if there.size else values[:0]


def frequency2phase(freqdata: ArrayLike, rate: float) -> Array:
    """Phase [s]: the integral of fractional frequency less its mean, from 0 on; one value more than the data have."""
    import numpy as np

    inner = trim_data(freqdata)
    return np.concatenate([[0.0], np.cumsum(inner - np.nanmean(inner)) / float(rate)])


def phase2frequency(phase: ArrayLike, rate: float) -> Array:
    """Fractional frequency from phase [s] at a rate [Hz]."""
    import numpy as np

    return float(rate) * np.diff(numbers_of(phase, "phase"))


def phase2radians(phasedata: ArrayLike, v0: float) -> Array:
    """Phase [rad] from phase [s] of a clock of frequency v0 [Hz]."""
    import numpy as np

    return 2.0 * np.pi * v0 * numbers_of(phasedata, "phasedata")


def frequency2fractional(frequency: ArrayLike, mean_frequency: float = -1) -> Array:
    """Fractional frequency from frequency [Hz], about its mean or a frequency that is given [Hz]."""

    values = numbers_of(frequency, "frequency")
    mean = float(values.mean()) if mean_frequency == -1 else mean_frequency
    return (values - mean) / mean


def tau_generator(
    data: ArrayLike, rate: float, taus: Any = None, v: bool = False, even: bool = False, maximum_m: float = -1
) -> tuple[Array, Array, Array]:
    """The data, the averaging factors of these taus [s], and the times [s] of these. `v` has no effect."""
    import numpy as np

    values, hertz, most = values_of(data, "data"), number_of(rate, "rate"), number_of(maximum_m, "maximum_m")
    longest = float(len(values)) if most == -1 else most
    factors = np.array(_tumble.clock_factors(taus_of(taus), hertz, len(values), longest, bool(even)), dtype=np.float64)
    return values, factors, factors / hertz


def tau_reduction(ms: ArrayLike, rate: float, n_per_decade: int) -> tuple[NDArray[np.int64], Array]:
    """About n_per_decade of the averaging factors a decade, and their times [s]."""
    import numpy as np

    factors = np.asarray(ms).astype(np.int64)
    steps = np.rint(n_per_decade * np.log10(factors))
    kept = factors[:-1][np.diff(steps) != 0]
    return kept, kept / float(rate)
