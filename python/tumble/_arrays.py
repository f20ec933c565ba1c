"""NumPy arrays from what users give: shared where the type allows it, else copied, or refused with the reason."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tumble._errors import DataError, UsageError, wrong_type, wrong_value
from tumble._text import is_quantity, is_real

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ACCEPTED = "accepted is a one-dimensional array of real numbers"


NAN_HINT = ", or missing='nan' where NaN means a missing sample"


def samples_of(
    values: Any, argument: str, missing: str | None = None, *, look: bool = True, hint: str = NAN_HINT
) -> NDArray[np.float64]:
    """A contiguous float64 array: the array given itself, without a copy, where it is one.

    Given     values    one-dimensional: array, list, pandas or polars series; integers and other floats are converted
              argument  its name for messages
              missing   "nan": NaN means a missing sample
              look      look for what is not finite: one pass over the samples
              hint      what the message for NaN says in addition
    Raises    ArgumentTypeError (not numbers), UsageError (shape), DataError (empty, infinite; NaN unless missing="nan")
    """
    import numpy as np

    if missing is not None and not (isinstance(missing, str) and missing == "nan"):
        raise wrong_value("missing", missing, "accepted are None and 'nan'")
    if is_quantity(values) or type(values).__module__.startswith(("astropy.units", "unyt")):
        raise wrong_type(argument, values, f"{ACCEPTED}: these numbers have a unit of their own, which would be lost")
    array = _array_of(values, argument)
    if array.ndim != 1:
        raise UsageError(
            f"argument {argument}: an array with {array.ndim} dimensions, shape {array.shape}, was given; {ACCEPTED}: "
            "give each column by itself"
        )
    if array.size == 0:
        raise DataError(f"argument {argument}: the array is empty; {ACCEPTED} with one sample or more")
    numbers = np.ascontiguousarray(array, dtype=np.float64)
    if look:
        refuse_what_is_not_finite(numbers, argument, missing, hint)
    return numbers


def times_of(values: Any, argument: str) -> NDArray[np.float64]:
    """Times [s], contiguous: numbers [s], a pint quantity, or dates and durations of NumPy, pandas and polars.

    Dates count from the first of them. Raises as samples_of; DataError for a date that is absent.
    """
    import numpy as np

    if is_quantity(values):
        try:
            values = values.to("s").magnitude
        except Exception as error:
            raise wrong_type(argument, values, "accepted are times") from error
    array = _dated(values)
    if array is None:
        return samples_of(values, argument, hint="")
    if np.isnat(array).any():
        first = int(np.flatnonzero(np.isnat(array))[0])
        raise DataError(f"argument {argument}: the date of row {first} is absent; accepted is a date for each sample")
    if array.dtype.kind == "M":
        array = array - array[0]
    return np.asarray(array.astype("timedelta64[ns]").astype(np.float64) * 1e-9)


def _dated(values: Any) -> Any:
    """Dates or durations, shape (n,), n > 0, as NumPy has them; None for anything else."""
    import numpy as np

    if not hasattr(values, "__array__") and not isinstance(values, (list, tuple)):
        return None
    dates = getattr(getattr(values, "dtype", None), "kind", None) == "M"  # of pandas: with a time zone, too
    try:
        array = np.asarray(values, dtype="datetime64[ns]") if dates else np.asarray(values)
    except (ValueError, TypeError):
        return None
    if array.ndim != 1 or array.size == 0:
        return None
    if array.dtype == object and all(hasattr(one, "tzinfo") and hasattr(one, "year") for one in array):
        first = array[0]
        return np.array([one - first for one in array], dtype="timedelta64[ns]")
    return array if array.dtype.kind in "mM" else None


def _array_of(values: Any, argument: str) -> NDArray[Any]:
    import numpy as np

    if isinstance(values, (str, bytes, bytearray)) or values is None or isinstance(values, dict):
        raise wrong_type(argument, values, ACCEPTED)
    if isinstance(values, np.ma.MaskedArray):
        if values.dtype.kind not in "iuf" or values.dtype.itemsize > 8:
            raise wrong_type(argument, values, f"{ACCEPTED}, not of {values.dtype}")
        return np.ma.filled(values.astype(np.float64), np.nan)
    try:
        array = np.asarray(values)
        if array.dtype == object and hasattr(values, "to_numpy") and all(map(_is_number_or_absent, array.flat)):
            array = values.to_numpy(dtype=np.float64, na_value=np.nan)  # of pandas
    except (ValueError, TypeError, NotImplementedError, OverflowError) as error:
        raise wrong_type(argument, values, f"{ACCEPTED} ({error})") from error
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        raise wrong_type(argument, values, f"{ACCEPTED}, not of {array.dtype}")
    return array


def equal(one: tuple[Any, ...], other: object) -> bool:
    """Whether two named tuples with arrays are equal: of one type, with arrays of the same numbers; NaN equals NaN."""
    import numpy as np

    def same(a: Any, b: Any) -> bool:
        if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
            return np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
        return not isinstance(a, np.ndarray) and not isinstance(b, np.ndarray) and bool(a == b)

    return type(one) is type(other) and isinstance(other, tuple) and all(map(same, one, other))


def _is_number_or_absent(cell: object) -> bool:
    return cell is None or is_real(cell) or type(cell).__name__ == "NAType"


def refuse_what_is_not_finite(
    numbers: NDArray[np.float64], argument: str, missing: str | None, hint: str = NAN_HINT
) -> None:
    """Raises DataError for infinite values, for NaN unless missing="nan", and where all are NaN."""
    import numpy as np

    with np.errstate(all="ignore"):
        total = np.add.reduce(numbers)
    if np.isfinite(total):  # one pass; a NaN or an infinite value anywhere would show
        return
    infinite = np.flatnonzero(np.isinf(numbers))
    if infinite.size:
        raise DataError(
            f"argument {argument}: {infinite.size} of {numbers.size} values are infinite, the first is sample "
            f"{infinite[0]}; accepted are finite numbers"
        )
    absent = np.flatnonzero(np.isnan(numbers))
    if absent.size == numbers.size:
        raise DataError(f"argument {argument}: all {numbers.size} values are NaN; accepted are finite numbers")
    if absent.size and missing is None:
        raise DataError(
            f"argument {argument}: {absent.size} of {numbers.size} values are NaN, the first is sample {absent[0]}; "
            f"accepted are finite numbers{hint}"
        )
