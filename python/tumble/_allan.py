"""The Allan family of an array."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from tumble import _tumble
from tumble._arrays import refuse_what_is_not_finite, samples_of, times_of
from tumble._errors import DataError, UsageError, wrong_type
from tumble._read import _rate_of
from tumble._recording import Channel
from tumble._text import is_quantity, number_of, quantity_of, seconds_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

KINDS: dict[str, str] = {
    "allan": "adev",
    "overlapping": "oadev",
    "modified": "mdev",
    "time": "tdev",
    "hadamard": "hdev",
    "overlapping_hadamard": "ohdev",
    "total": "totdev",
    "modified_total": "mtotdev",
    "time_total": "ttotdev",
    "hadamard_total": "htotdev",
    "parabolic": "pdev",
    "peak_interval_error": "mtie",
    "rms_interval_error": "tierms",
    **{one.name: one.name for one in _tumble.Stability},
}
"""The accepted words for `kind`: the names of the command line, and longer ones that mean the same."""

DATA = ("rate", "frequency", "phase", "angle", "increment")


class AllanDeviation(NamedTuple):
    """A deviation over the averaging time; all arrays have the shape (k,).

    `taus` [s]; `deviation`, `lower` and `upper` in the unit of the array (of time deviations and interval errors:
    times s); `n` terms; `alpha` the noise type that was found at each tau (2 white phase ... -2 random walk of the
    rate) and `edf` the equivalent degrees of freedom. `lower` and `upper` are NaN where limits are not known.
    """

    taus: NDArray[np.float64]
    deviation: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    n: NDArray[np.int64]
    alpha: NDArray[np.int64]
    edf: NDArray[np.float64]
    kind: str
    unit: str

    def __repr__(self) -> str:
        return f"<AllanDeviation {self.kind}: {len(self.taus)} taus from {self.taus[0]:g} s to {self.taus[-1]:g} s>"


def allan_deviation(
    x: ArrayLike | Channel,
    sample_rate: float | str | None = None,
    *,
    taus: str | Sequence[float | str] | ArrayLike = "octave",
    kind: str = "overlapping",
    data: str = "rate",
    confidence: float = 0.95,
    points_per_decade: float = 10.0,
    longest_fraction: float = 0.25,
    alpha: int | None = None,
    remove_bias: bool = True,
    mean_rate: str = "subtract",
    missing: str | None = None,
) -> AllanDeviation:
    """A stability measure with confidence limits. A float64 array is read in place, without a copy.

    Given     x                  samples, shape (n,), or a channel of a recording (its values are in SI)
              sample_rate        [Hz], or text such as "100 Hz"; of a channel None: its own
              taus               "octave" (1, 2, 4 ... samples), "log" (points_per_decade), "decade" (1, 2, 4, 10 ...),
                                 "all" (every multiple of the sampling interval), or averaging times [s]
              kind               overlapping, allan, modified, time, hadamard, overlapping_hadamard, total,
                                 modified_total, time_total, hadamard_total, parabolic, theo1, theoh, mtie, tierms;
                                 or adev, oadev ..., the words of the command line
              data               rate or frequency; phase or angle (the integral); increment (of the integral a sample)
              confidence         [1] of the limits, two-sided
              longest_fraction   longest tau as a fraction of the record, at most 0.5, for all but explicit taus
              alpha              noise type where it is known; None: found at each tau
              remove_bias        of the total deviations
              mean_rate          of mtie and tierms: "subtract" the mean rate, or "keep" it
              missing            "nan": NaN means a missing sample; None: NaN is refused
    Returned  AllanDeviation in the unit of the array, which is "1" but for channels and pint quantities
    Raises    ArgumentTypeError, UsageError, DataError that name the argument
    Accuracy  1e-10 relative, also beside a large mean or drift
    Example   tumble.allan_deviation(rate, 100.0, taus="log").deviation
    """
    word = _kind_of(kind)
    if data not in DATA:
        raise UsageError(f"argument data: {data!r} was given; accepted are {', '.join(DATA)}")
    if mean_rate not in ("subtract", "keep"):
        raise UsageError(f"argument mean_rate: {mean_rate!r} was given; accepted are 'subtract' and 'keep'")
    phase = data in ("phase", "angle")
    quick = word == "oadev" and not phase  # its sums show whether samples are missing, without a pass of their own
    values, rate, unit = _samples(x, sample_rate, missing, look=not quick)
    longest_fraction = number_of(longest_fraction, "longest_fraction")
    points_per_decade = number_of(points_per_decade, "points_per_decade")
    confidence = number_of(confidence, "confidence", "accepted are numbers between 0 and 1")
    options = (
        points_per_decade,
        longest_fraction,
        confidence,
        _noise_type(alpha),
        bool(remove_bias),
        mean_rate == "subtract",
    )
    if data == "increment":
        values = values * rate
    if isinstance(taus, str) and taus == "all" and word in ("oadev", "ohdev") and not phase:
        if quick and not isinstance(x, Channel):
            refuse_what_is_not_finite(values, "x", missing)
        return _every(values, rate, word, unit, options)
    factors = _factors(taus, rate, len(values) - phase, points_per_decade, longest_fraction)
    if phase and not factors:
        import numpy as np

        values, phase = np.diff(values) * rate, False
    try:
        columns = _tumble.deviations(values, _tumble.Stability[word], rate, phase, factors, *options)
    except DataError as error:
        refuse_what_is_not_finite(values, "x", missing)
        raise DataError([f"argument x: {problem}" for problem in error.problems]) from None
    if quick and not isinstance(x, Channel) and not _are_whole(columns, len(values)):
        refuse_what_is_not_finite(values, "x", missing)
    if not len(columns[0]):
        raise DataError(f"argument x: {len(values)} samples are too few for {word} at these averaging times")
    return _deviation(columns, word, unit)


def _kind_of(kind: object) -> str:
    if not isinstance(kind, str) or kind not in KINDS:
        raise UsageError(f"argument kind: {kind!r} was given; accepted are {', '.join(KINDS)}")
    return KINDS[kind]


def _samples(x: Any, sample_rate: object, missing: str | None, look: bool) -> tuple[NDArray[np.float64], float, str]:
    if isinstance(x, Channel):
        return x.values, x.rate if sample_rate is None else _rate_of(sample_rate, "sample_rate"), x.unit
    if sample_rate is None:
        raise UsageError("argument sample_rate: nothing was given; accepted is the sampling rate [Hz] of the array")
    unit = "1"
    if is_quantity(x):
        x, unit = quantity_of(x)
    return samples_of(x, "x", missing, look=look), _rate_of(sample_rate, "sample_rate"), unit


def _factors(taus: Any, rate: float, samples: int, points_per_decade: float, longest_fraction: float) -> list[int]:
    """Averaging factors; none where the library chooses them."""
    longest = max(1, int(longest_fraction * samples))
    if isinstance(taus, str):
        if taus == "log":
            return []
        if taus == "octave":
            return [1 << k for k in range(longest.bit_length())]
        if taus == "decade":
            steps = (part * 10**k for k in range(len(str(longest))) for part in (1, 2, 4))
            return [step for step in steps if step <= longest]
        if taus == "all":
            return list(range(1, longest + 1))
        raise UsageError(f"argument taus: {taus!r} was given; accepted are octave, log, decade, all, and times [s]")
    listed = isinstance(taus, (list, tuple))
    times = [seconds_of(one, "taus") for one in taus] if listed else times_of(taus, "taus").tolist()
    if not times:
        raise UsageError("argument taus: an empty list was given; accepted are averaging times [s], and taus='log'")
    return sorted({_factor(time, rate) for time in times})


def _noise_type(alpha: object) -> int | None:
    if alpha is None:
        return None
    if isinstance(alpha, bool) or not hasattr(alpha, "__index__") or not -4 <= alpha.__index__() <= 2:
        raise wrong_type("alpha", alpha, "accepted are None and the whole numbers from -4 to 2")
    return int(alpha.__index__())


def _factor(time: float, rate: float) -> int:
    if not 0.5 <= time * rate < 1e18:
        raise UsageError(
            f"argument taus: {time:g} s was given; accepted are averaging times of {1 / rate:g} s, the sampling "
            "interval, and more"
        )
    return max(1, round(time * rate))


def _are_whole(columns: tuple[Any, ...], samples: int) -> bool:
    """Whether the overlapping sums have all terms of a record without missing samples."""
    return len(columns[0]) > 0 and bool((columns[3] == samples + 1 - 2 * columns[0]).all())


def _every(values: Any, rate: float, word: str, unit: str, options: tuple[Any, ...]) -> AllanDeviation:
    """Every averaging factor, with limits between those of the log-spaced ones beside it."""
    import numpy as np

    deviation, n = _tumble.every(values, word)
    longest = max(1, int(options[1] * len(values)))
    factors = np.arange(1, len(deviation) + 1)[:longest]
    curve = _tumble.deviations(values, _tumble.Stability[word], rate, False, [], *options)
    at, log = np.log(curve[0]), np.log(factors)
    deviation, n, keep = deviation[:longest], n[:longest], n[:longest] > 0
    lower = deviation * np.interp(log, at, curve[6] / curve[2])
    upper = deviation * np.interp(log, at, curve[7] / curve[2])
    below = np.searchsorted(curve[0], factors, side="right") - 1
    edf = np.interp(log, at, curve[5])
    times, types = factors / rate, curve[4][below]
    return AllanDeviation(
        times[keep], deviation[keep], lower[keep], upper[keep], n[keep], types[keep], edf[keep], word, unit
    )


def _deviation(columns: tuple[Any, ...], word: str, unit: str) -> AllanDeviation:
    import numpy as np

    _, taus, deviation, count, alpha, edf, lower, upper = columns
    unknown = edf <= 0
    if unknown.any():
        lower[unknown] = np.nan
        upper[unknown] = np.nan
    return AllanDeviation(taus, deviation, lower, upper, count, alpha, edf, word, unit)
