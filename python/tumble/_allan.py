"""The Allan family of an array."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from tumble import _tumble
from tumble._arrays import equal, refuse_what_is_not_finite, samples_of, times_of
from tumble._channel import Channel
from tumble._errors import DataError, TumbleWarning, UsageError, wrong_value
from tumble._text import flag_of, is_quantity, number_of, one_of, quantity_of, rate_of, seconds_of, whole_of

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

    def __eq__(self, other: object) -> bool:
        return equal(self, other)

    def __ne__(self, other: object) -> bool:
        return not equal(self, other)

    def __repr__(self) -> str:
        taus = f" from {self.taus[0]:g} s to {self.taus[-1]:g} s" if len(self.taus) else ""
        return f"<AllanDeviation {self.kind}: {len(self.taus)} taus{taus}>"


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
                                 "all" (every multiple of the sampling interval), or averaging times [s], which are
                                 rounded to multiples of it; of theo1 strides, 4/3 of the averaging times. "log"
                                 takes half the time of as many of your own: its sums are made of each other
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
    Returned  AllanDeviation in the unit of the array, which is "1" but for channels and pint quantities; a warning
              names times of `taus` that have no answer within 5 %
    Raises    ArgumentTypeError, UsageError, DataError that name the argument
    Accuracy  1e-10 relative, also beside a large mean or drift
    Example   tumble.allan_deviation(rate, 100.0, taus="log").deviation
    """
    word = KINDS[one_of(kind, "kind", tuple(KINDS))]
    one_of(mean_rate, "mean_rate", ("subtract", "keep"))
    phase = one_of(data, "data", DATA) in ("phase", "angle")
    quick = word == "oadev" and not phase  # its sums show whether samples are missing, without a pass of their own
    values, rate, unit = _samples(x, sample_rate, missing, look=not quick)
    longest_fraction = number_of(longest_fraction, "longest_fraction")
    if not 0.0 < longest_fraction <= 0.5:
        raise wrong_value("longest_fraction", longest_fraction, "accepted are numbers above 0 and at most 0.5")
    points_per_decade = number_of(points_per_decade, "points_per_decade")
    if not 0.0 <= points_per_decade <= 1e4:
        raise wrong_value("points_per_decade", points_per_decade, "accepted are numbers from 0 (octaves) to 10 000")
    confidence = number_of(confidence, "confidence", "accepted are numbers between 0 and 1")
    options = (
        points_per_decade,
        longest_fraction,
        confidence,
        _noise_type(alpha),
        flag_of(remove_bias, "remove_bias"),
        mean_rate == "subtract",
    )
    if data == "increment":
        values = values * rate
    if isinstance(taus, str) and taus == "all" and word in ("oadev", "ohdev") and not phase:
        if quick and not isinstance(x, Channel):
            refuse_what_is_not_finite(values, "x", missing)
        return _every(values, rate, word, unit, options)
    times = _listed(taus)
    factors = _factors(times, rate, len(values) - phase, longest_fraction)
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
    if not isinstance(times, str):
        _warn_of_times_without_answer(times, columns[0] / rate, rate)
    return _deviation(columns, word, unit)


def _samples(x: Any, sample_rate: object, missing: str | None, look: bool) -> tuple[NDArray[np.float64], float, str]:
    if isinstance(x, Channel):
        return x.values, x.rate if sample_rate is None else rate_of(sample_rate, "sample_rate"), x.unit
    if sample_rate is None:
        raise UsageError("argument sample_rate: nothing was given; accepted is the sampling rate [Hz] of the array")
    unit = "1"
    if is_quantity(x):
        x, unit = quantity_of(x)
    return samples_of(x, "x", missing, look=look), rate_of(sample_rate, "sample_rate"), unit


def _factors(taus: Any, rate: float, samples: int, longest_fraction: float) -> list[int]:
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
        raise wrong_value("taus", taus, "accepted are octave, log, decade, all, and times [s]")
    return sorted({_factor(time, rate) for time in taus})


def _listed(taus: Any) -> Any:
    """A word; or averaging times [s]."""
    if isinstance(taus, str):
        return taus
    listed = isinstance(taus, (list, tuple))
    times = [seconds_of(one, "taus") for one in taus] if listed else times_of(taus, "taus").tolist()
    if not times:
        raise UsageError("argument taus: an empty list was given; accepted are averaging times [s], and taus='log'")
    return times


def _warn_of_times_without_answer(times: Sequence[float], answered: NDArray[np.float64], rate: float) -> None:
    """A TumbleWarning for times of which the answer has none within 5 %, by which no deviation changes much."""
    import numpy as np

    wanted, found = np.array(times), np.sort(answered)
    after = np.searchsorted(found, wanted).clip(1, len(found) - 1) if len(found) > 1 else np.zeros(len(wanted), int)
    distance = np.minimum(np.abs(found[after] - wanted), np.abs(found[after - 1] - wanted))
    absent = wanted[distance > 0.05 * wanted]
    if absent.size:
        some = ", ".join(f"{time:g} s" for time in absent[:3]) + (" ..." if absent.size > 3 else "")
        text = (
            f"argument taus: {absent.size} of {wanted.size} averaging times have no answer within 5 % ({some}): it has "
            f"multiples of the sampling interval, {1 / rate:g} s, up to {found[-1]:g} s; its taus says which"
        )
        warnings.warn(text, TumbleWarning, stacklevel=3)


def _noise_type(alpha: object) -> int | None:
    return None if alpha is None else whole_of(alpha, "alpha", -4, 2)


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
    known = curve[2] > 0  # of even integers, a deviation may be 0: its limits are 0, and say nothing of those beside it
    lower, upper = (
        deviation * np.interp(log, at[known], end[known] / curve[2][known]) if known.any() else deviation
        for end in (curve[6], curve[7])
    )
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
