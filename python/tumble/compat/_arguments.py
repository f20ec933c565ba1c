"""The arguments of AllanTools: data, numbers, averaging times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tumble._arrays import _array_of
from tumble._errors import UsageError, wrong_type
from tumble._text import whole_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

Taus = Any  # None, a word, or averaging times [s]


def numbers_of(values: Any, argument: str) -> Array:
    """Numbers of any shape, as float64. Raises ArgumentTypeError."""
    return _array_of(values, argument).astype("float64", copy=False)


def values_of(data: Any, argument: str) -> Array:
    """The data as they are, where they are contiguous float64; else a copy."""
    import numpy as np

    array = _array_of(data, argument)
    if array.ndim != 1:
        raise UsageError(
            f"argument {argument}: an array with {array.ndim} dimensions, shape {array.shape}, was given; accepted is "
            "a one-dimensional array"
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def number_of(value: Any, argument: str) -> float:
    """A number, or the only one of an array; NaN is one. Raises ArgumentTypeError."""
    alone = value.item() if getattr(value, "size", 0) == 1 and hasattr(value, "item") else value
    if isinstance(alone, (str, bytes)):
        raise wrong_type(argument, value, "accepted is a number")
    try:
        return float(alone)
    except (TypeError, ValueError, OverflowError) as error:
        raise wrong_type(argument, value, "accepted is a number") from error


def taus_of(taus: Taus) -> str | Array:
    """A word that selects averaging times, or the times [s], shape (n,). Raises ArgumentTypeError."""
    import numpy as np

    if taus is None or (isinstance(taus, list) and not taus):
        return "octave"
    if isinstance(taus, str):
        return whole_text(taus, "taus")
    return np.ascontiguousarray(_array_of(taus, "taus"), dtype=np.float64).ravel()
