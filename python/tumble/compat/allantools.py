"""The estimators of AllanTools 2024.6 with its arguments, defaults and return values, calculated by Tumble.

    import tumble.compat.allantools as allantools
    taus, devs, errs, ns = allantools.oadev(rate, rate=100.0, data_type="freq", taus="decade")

`errs` is what AllanTools returns: the deviation over the square root of the number of terms. It is not an uncertainty;
`tumble.allan_deviation` gives limits for the noise type that it finds. docs/allantools.md has more on the differences.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tumble import _tumble
from tumble._arrays import _array_of
from tumble._errors import DataError, UsageError, wrong_type
from tumble._text import one_of
from tumble.compat._arguments import Taus, number_of, taus_of, values_of
from tumble.compat._glue import (
    frequency2fractional,
    frequency2phase,
    phase2frequency,
    phase2radians,
    tau_generator,
    tau_reduction,
    trim_data,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]
    Answer = tuple[Array, Array, Array, Array]

__all__ = [
    "Dataset",
    "NothingRemainsError",
    "adev",
    "confidence_interval",
    "edf_simple",
    "frequency2fractional",
    "frequency2phase",
    "gcodev",
    "gradev",
    "hdev",
    "htotdev",
    "mdev",
    "mtie",
    "mtie_phase_fast",
    "mtotdev",
    "oadev",
    "ohdev",
    "pdev",
    "phase2frequency",
    "phase2radians",
    "tau_generator",
    "tau_reduction",
    "tdev",
    "theo1",
    "three_cornered_hat_phase",
    "tierms",
    "totdev",
    "trim_data",
    "ttotdev",
]

KINDS = ("theo1", "mtie", "tierms")
KEYS = ("taus", "stat", "stat_err", "stat_n")


class NothingRemainsError(DataError, UserWarning):
    """No averaging time has two terms. It is a UserWarning too, which AllanTools raises here."""


def adev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Allan deviation, of terms tau apart.

    Given     data       phase [s] or fractional frequency, shape (n,); of a gyro: angle or rate in any unit
              rate       [Hz]
              data_type  "phase" or "freq"
              taus       None or "octave", "decade", "all", "log10", or averaging times [s]
    Returned  taus [s], deviations, `errs`, numbers of terms: arrays of one length
    Raises    NothingRemainsError, DataError (NaN, infinite), UsageError that name the argument
    Accuracy  1e-9 of AllanTools, which the tests compare with
    Example   adev(rate, rate=100.0, data_type="freq")
    """
    return _deviations("adev", data, rate, data_type, taus)


def oadev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Overlapping Allan deviation. Arguments and answer as of adev."""
    return _deviations("oadev", data, rate, data_type, taus)


def mdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Modified Allan deviation. Arguments and answer as of adev."""
    return _deviations("mdev", data, rate, data_type, taus)


def tdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Time deviation [unit of the phase]: tau mdev/sqrt(3). Arguments and answer as of adev."""
    return _deviations("tdev", data, rate, data_type, taus)


def hdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Hadamard deviation, of terms tau apart. Arguments and answer as of adev."""
    return _deviations("hdev", data, rate, data_type, taus)


def ohdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Overlapping Hadamard deviation. Arguments and answer as of adev."""
    return _deviations("ohdev", data, rate, data_type, taus)


def pdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Parabolic deviation. Arguments and answer as of adev."""
    return _deviations("pdev", data, rate, data_type, taus)


def totdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Total deviation. Its bias is not removed. Arguments and answer as of adev."""
    return _deviations("totdev", data, rate, data_type, taus)


def mtotdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Modified total deviation. Its bias is not removed. Arguments and answer as of adev."""
    return _deviations("mtotdev", data, rate, data_type, taus)


def ttotdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Time total deviation: tau mtotdev/sqrt(3). Arguments and answer as of adev."""
    return _deviations("ttotdev", data, rate, data_type, taus)


def htotdev(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Hadamard total deviation; at one sample ohdev. Its bias is not removed. Arguments and answer as of adev."""
    return _deviations("htotdev", data, rate, data_type, taus)


def theo1(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Theo1 of even strides. `taus` are strides: 4/3 of the averaging times. Arguments and answer as of adev."""
    return _deviations("theo1", data, rate, data_type, taus)


def mtie(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Maximum time interval error [unit of the phase]. Arguments and answer as of adev."""
    return _deviations("mtie", data, rate, data_type, taus)


def tierms(data: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Time interval error rms [unit of the phase]; `errs` are 0. Arguments and answer as of adev."""
    return _deviations("tierms", data, rate, data_type, taus)


def mtie_phase_fast(phase: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None) -> Answer:
    """Maximum time interval error of windows of 2, 4, 8 ... points of the first 2^k points.

    `taus` holds 1, 2, 4 ... whatever the rate, and `errs` 0, as of AllanTools. `data_type` and `taus` have no effect.
    """
    import numpy as np

    values = values_of(phase, "phase")
    octaves = max(values.size, 1).bit_length() - 1
    factors = np.exp2(np.arange(1.0, octaves + 1)) - 1
    _, peaks, _, terms = _tumble.clock_deviations(values[: 1 << octaves], _tumble.Stability.mtie, 1.0, True, factors)
    return _some((np.exp2(np.arange(float(len(peaks)))), peaks, np.zeros(len(peaks)), terms), values)


def gradev(
    data: ArrayLike,
    rate: float = 1.0,
    data_type: str = "phase",
    taus: Taus = None,
    ci: float = 0.9,
    noisetype: str = "wp",
) -> tuple[Array, Array, list[Array], Array]:
    """Overlapping Allan deviation of phase with gaps (NaN): the terms that all three points have.

    Given     as of adev; ci, confidence of the limits; noisetype "wp", "wf" or "fp"
    Returned  taus [s], deviations, [lower limits, upper limits], numbers of terms. AllanTools 2024.6 interchanges two
              arguments, so its limits are NaN unless edf is below 3; these are equal to them. For limits:
              tumble.allan_deviation(..., missing="nan")
    """
    alpha = {"wp": 2, "wf": 0, "fp": -2}.get(str(noisetype), 9)
    values = values_of(data, "data")
    columns, upper = _tumble.clock_gap_robust(
        values, number_of(rate, "rate"), _of_phase(data_type), taus_of(taus), number_of(ci, "ci"), alpha
    )
    found, deviations, lower, terms = _some(columns, values)
    return found, deviations, [lower, upper], terms


def gcodev(
    data_1: ArrayLike, data_2: ArrayLike, rate: float = 1.0, data_type: str = "phase", taus: Taus = None
) -> Answer:
    """Groslambert codeviation of two series of one length. Arguments and answer as of adev."""
    one, two = values_of(data_1, "data_1"), values_of(data_2, "data_2")
    return _some(_tumble.clock_codeviation(one, two, number_of(rate, "rate"), _of_phase(data_type), taus_of(taus)), one)


def three_cornered_hat_phase(
    phasedata_ab: ArrayLike,
    phasedata_bc: ArrayLike,
    phasedata_ca: ArrayLike,
    rate: float,
    taus: Taus,
    function: Callable[..., Answer],
) -> tuple[Array, Array, list[float], Array]:
    """Deviation of the first of three clocks from the phases of their pairs; 0 where its variance is negative.

    Given     phases of a - b, b - c, c - a; rate [Hz]; taus as of adev; function, for example oadev
    Returned  taus [s], deviations, `errs`, numbers of terms of the first pair
    """
    import numpy as np

    if not callable(function):
        raise wrong_type("function", function, "accepted is an estimator, for example oadev")
    pairs = [
        function(data, rate=rate, data_type="phase", taus=taus) for data in (phasedata_ab, phasedata_bc, phasedata_ca)
    ]
    if len({len(pair[0]) for pair in pairs}) > 1:
        raise UsageError("arguments phasedata: series of different lengths were given; accepted is one length")
    ab, bc, ca = (pair[1] ** 2 for pair in pairs)
    deviations = np.sqrt(np.maximum(0.5 * (ab + ca - bc), 0.0))
    return pairs[0][0], deviations, list(deviations / np.sqrt(pairs[0][3])), pairs[0][3]


def confidence_interval(dev: Any, edf: float, ci: float = 0.6826894921370859) -> tuple[Any, Any]:
    """Limits of a deviation, or of an array of them, by chi-square with edf degrees of freedom; ci 0.683: one sigma."""
    import numpy as np

    lower, upper = _tumble.chi_square_limits(1.0, number_of(edf, "edf"), number_of(ci, "ci"))
    size = np.abs(_array_of(dev, "dev").astype(np.float64)) if np.ndim(dev) else abs(number_of(dev, "dev"))
    return size * lower, size * upper


def edf_simple(N: Any, m: Any, alpha: int) -> Any:  # noqa: N803
    """Equivalent degrees of freedom of oadev by the simple formulas.

    Given     N      phase points; m  averaging factor: numbers, or arrays of them
              alpha  noise, from 2 (white phase) to -2 (random walk of frequency); else none is known
    """
    import numpy as np

    named = number_of(alpha, "alpha")
    kind = int(named) if named in (-2.0, -1.0, 0.0, 1.0, 2.0) else 9
    if np.ndim(N) == np.ndim(m) == 0:
        return _tumble.simple_edf(number_of(N, "N"), number_of(m, "m"), kind)
    pairs = np.broadcast(_array_of(N, "N").astype(np.float64), _array_of(m, "m").astype(np.float64))
    return np.array([_tumble.simple_edf(float(n), float(k), kind) for n, k in pairs]).reshape(pairs.shape)


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
        one_of(function, "function", [name for name in __all__ if name in KINDS or name.endswith("dev")])
        found = globals()[function](**self.inp)
        result = dict(zip(KEYS, found, strict=True))
        self.out = {**result, "stat_id": function}
        return result

    def write_results(
        self, filename: str | os.PathLike[str], digits: int = 5, header_params: dict[str, Any] | None = None
    ) -> None:
        """Writes what was calculated as a table of text, in the columns of AllanTools."""
        name, width = self.out["stat_id"], digits + 5
        head = [f"# Input data type: {self.inp['data_type']}", f"# Input data rate: {self.inp['rate']}"]
        head += [f"# {key}: {value}" for key, value in (header_params or {}).items()]
        head.append(
            f"{'AF':>5s} {'Tau':>{width}s} {'N':>10s} {'alpha':>5s} {'min_' + name:>{width}} {name:>{width}} "
            f"{'max_' + name:>{width}} "
        )
        rows = zip(*(self.out[key] for key in KEYS), strict=True)
        _tumble.write_whole(
            os.fspath(filename), "\n".join([*head, *(self._row(row, digits - 1) for row in rows)]) + "\n"
        )

    def _row(self, row: tuple[Any, ...], digits: int) -> str:
        tau, value, error, terms = row
        low, middle, high = (f"{one:.{digits}e}" for one in (value - error / 2, value, value + error / 2))
        return (
            f"{int(tau / self.out['taus'][0]):5d} {tau:.{digits}e} {int(terms):10d} {'NaN':5s} {low} {middle} {high} "
        )


def _deviations(measure: str, data: Any, rate: float, data_type: str, taus: Taus) -> Answer:
    values = values_of(data, "data")
    return _some(
        _tumble.clock_deviations(
            values, _measure(measure), number_of(rate, "rate"), _of_phase(data_type), taus_of(taus)
        ),
        values,
    )


def _measure(name: str) -> _tumble.Stability:
    measure: _tumble.Stability = getattr(_tumble.Stability, name)
    return measure


def _of_phase(data_type: str) -> bool:
    return one_of(data_type, "data_type", ("phase", "freq")) == "phase"


def _some(answer: Answer, values: Array) -> Answer:
    if len(answer[0]) == 0:
        raise NothingRemainsError(
            f"argument taus: no averaging time has two terms in {len(values)} values; accepted are averaging times "
            "from one sample up to a part of the record"
        )
    return answer


def __getattr__(name: str) -> object:
    raise AttributeError(f"tumble.compat.allantools has no {name!r}: it has {', '.join(__all__)}")
