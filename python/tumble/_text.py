"""Quantities as the C++ library reads them: text with a unit."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Mapping, Sequence
from typing import Any

from tumble import _tumble
from tumble._errors import UsageError, wrong_type, wrong_value

Sets = list[tuple[str, str]]

ACCEPTED = 'text with a unit such as "10 deg/h", a number, True or False, a list of whole numbers, or a pint quantity'


def text_of(value: object, argument: str) -> str:
    """The text of a value that a plan or an option takes.

    Raises ArgumentTypeError for anything that is not text, a number, a list of whole numbers or a quantity.
    """
    if isinstance(value, str):
        return whole_text(value, argument)
    if isinstance(value, os.PathLike):
        return path_text(value, argument)
    if isinstance(value, bool):
        return "true" if value else "false"
    if is_quantity(value):
        magnitude, unit = quantity_of(value)
        return f"{number_text(magnitude, argument)} {unit}"
    if isinstance(value, (list, tuple)):
        return ",".join(_text_of_element(one, value, argument) for one in value)
    return number_text(value, argument)


def _text_of_element(one: object, values: object, argument: str) -> str:
    if isinstance(one, (list, tuple)):
        raise wrong_type(argument, values, f"accepted are {ACCEPTED}")
    return text_of(one, argument)


def whole_text(value: object, argument: str) -> str:
    """Text that can be written in UTF-8. Raises ArgumentTypeError for another type, UsageError for half characters."""
    if not isinstance(value, str):
        raise wrong_type(argument, value, "accepted is text")
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise wrong_value(argument, value, "accepted is text that UTF-8 can hold") from error
    return value


def one_of(value: object, argument: str, words: Sequence[str]) -> str:
    """One of these words. Raises UsageError, ArgumentTypeError."""
    if isinstance(value, str) and value in words:
        return value
    accepted = f"accepted are {', '.join(words)}"
    raise wrong_value(argument, value, accepted) if isinstance(value, str) else wrong_type(argument, value, accepted)


def words_of(values: object, argument: str) -> list[str]:
    """Names: one text, or several in a list. Raises ArgumentTypeError."""
    if isinstance(values, str):
        return [whole_text(values, argument)]
    return [whole_text(one, argument) for one in listed(values, argument, "accepted are a name and a list of names")]


def listed(values: Any, argument: str, accepted: str) -> list[Any]:
    """The elements of a list, an array or a generator. Raises ArgumentTypeError, also for texts and mappings."""
    try:
        if not isinstance(values, (str, bytes, Mapping)):
            return list(values)
    except TypeError:  # also of arrays and quantities without dimensions, which only look iterable
        pass
    raise wrong_type(argument, values, accepted)


def is_real(value: Any) -> bool:
    """Whether this is a real number of Python, NumPy, decimal or fractions."""
    return hasattr(value, "as_integer_ratio") and not isinstance(value, (bool, type)) and not is_quantity(value)


def _plain(value: Any) -> Any:
    """The number in a scalar, or in an array without dimensions, of NumPy."""
    scalar = hasattr(value, "item") and not isinstance(value, type) and getattr(value, "ndim", None) == 0
    return value.item() if scalar else value


def number_of(value: Any, argument: str, accepted: str = "accepted is a number") -> float:
    """A finite number. Raises ArgumentTypeError, UsageError."""
    plain = _plain(value)
    if not is_real(plain):
        raise wrong_type(argument, value, accepted)
    try:
        number = float(plain)
    except (OverflowError, ValueError):  # an integer or a fraction beyond all floats; sNaN of decimal
        number = math.inf
    if not math.isfinite(number):
        raise wrong_value(argument, value, accepted)
    return number


def whole_of(value: Any, argument: str, least: int, most: int) -> int:
    """A whole number from `least` to `most`. Raises ArgumentTypeError."""
    try:
        number = None if isinstance(value, bool) else operator.index(value)
    except Exception:  # TypeError, and what __index__ of a type of yours raises
        number = None
    if number is None or not least <= number <= most:
        to = f"from {least} on" if most >= (1 << 63) - 1 else f"from {least} to {most}"
        raise wrong_type(argument, value, f"accepted are whole numbers {to}")
    return number


def flag_of(value: object, argument: str) -> bool:
    """True or False. Raises ArgumentTypeError."""
    plain = _plain(value)
    if not isinstance(plain, (bool, int)):
        raise wrong_type(argument, value, "accepted are True and False")
    return bool(plain)


def count_of(value: Any, argument: str, least: int = 0) -> int:
    """A whole number, at least `least`. Raises ArgumentTypeError."""
    return whole_of(value, argument, least, (1 << 63) - 1)


def seconds_of(value: Any, argument: str) -> float:
    """A time [s] of a number [s], text with a unit, or a pint quantity. Raises ArgumentTypeError, UsageError."""
    if isinstance(value, str) or is_quantity(value):
        return si_of(text_of(value, argument), "s", argument)
    return number_of(value, argument, 'accepted are numbers [s], text such as "10 s" and pint quantities')


def rate_of(rate: object, argument: str = "rate") -> float:
    """Sampling rate [Hz]. Raises ArgumentTypeError, UsageError."""
    accepted = "accepted are a number [Hz], text such as '100 Hz', and a pint quantity"
    if isinstance(rate, str) or is_quantity(rate):
        text = text_of(rate, argument)
        bare = text.strip().lstrip("+-").replace(".", "", 1).replace("e", "", 1).replace("-", "").isdigit()
        hertz = si_of(f"{text} Hz" if bare else text, "Hz", argument)
    else:
        hertz = number_of(rate, argument, accepted)
    if not 1e-10 <= hertz <= 1e10:
        raise wrong_value(argument, rate, "accepted are rates above 0 Hz, from 1e-10 Hz to 1e10 Hz")
    return hertz


def si_of(text: str, unit: str, argument: str) -> float:
    """The quantity of a text in SI. Raises UsageError that names the argument."""
    try:
        return _tumble.parse_si(text, unit)
    except UsageError as error:
        raise UsageError([f"argument {argument}: {problem}" for problem in error.problems]) from None


def number_text(value: Any, argument: str) -> str:
    """All digits of a number of Python or NumPy."""
    plain = _plain(value)
    if isinstance(plain, bool):
        return "true" if plain else "false"
    if not is_real(plain):
        raise wrong_type(argument, value, f"accepted are {ACCEPTED}")
    try:
        return repr(plain) if isinstance(plain, (int, float)) else repr(float(plain))
    except (OverflowError, ValueError) as error:  # a number beyond all floats, or of more than 4300 digits
        raise wrong_value(argument, value, f"accepted are {ACCEPTED}") from error


def is_quantity(value: object) -> bool:
    """Whether this is a quantity of pint."""
    return hasattr(value, "magnitude") and hasattr(value, "units")


def is_unit(value: object) -> bool:
    """Whether this is a unit of pint."""
    return hasattr(value, "dimensionality") and not hasattr(value, "magnitude")


def quantity_of(quantity: Any) -> tuple[Any, str]:
    """Magnitude and unit of a pint quantity: in its own unit where that is the same unit here, else in that of SI.

    Texts alone would not do: "g" is a gram there and gravity here, and a difference of degC is no temperature.
    """
    own = unit_text(quantity.units)
    if not hasattr(quantity, "to_base_units"):
        return quantity.magnitude, own
    one = type(quantity)(1.0, quantity.units).to_base_units()
    base = unit_text(one.units)
    try:
        here, there = _tumble.Unit.parse(own), _tumble.Unit.parse(base)
        same = here.dimension == there.dimension and math.isclose(
            here.to_si(1.0), there.to_si(one.magnitude), rel_tol=1e-9
        )
    except UsageError:
        same = False
    return (quantity.magnitude, own) if same else (quantity.to_base_units().magnitude, base)


def unit_text(units: Any) -> str:
    """The unit of a pint quantity, or of any object whose text is a unit."""
    try:
        text = format(units, "~C")
    except (ValueError, TypeError):
        text = str(units)
    return text.replace("**", "^").replace("°", "deg").replace("Δ", "").replace("delta_", "") or "1"


def unit_of(unit: object, argument: str) -> _tumble.Unit:
    """A unit of text or of pint. Raises ArgumentTypeError, UsageError."""
    if isinstance(unit, str):
        text = whole_text(unit, argument)
    elif is_unit(unit):
        text = quantity_of(1.0 * unit)[1]  # type: ignore[operator]
        if text != unit_text(unit):
            raise UsageError(f"argument {argument}: {unit} is not a unit here; {text} is")
    else:
        raise wrong_type(argument, unit, 'accepted are text such as "deg/h" and units of pint')
    return _tumble.Unit.parse(text)


def _unit_name(unit: object, argument: str) -> str:
    return unit_of(unit, argument).text


def units_of(units: object, argument: str = "units") -> dict[Any, str]:
    """Units by column. Raises ArgumentTypeError."""
    if units is None:
        return {}
    if not isinstance(units, Mapping):
        raise wrong_type(argument, units, 'accepted is a dict such as {"gyro.x": "deg/s"}')
    return {
        key: whole_text(one, f"{argument}[{key!r}]")
        if isinstance(one, str)
        else unit_of(one, f"{argument}[{key!r}]").text
        for key, one in units.items()
    }


def sets_of(settings: Mapping[str, object] | None, argument: str = "settings") -> Sets:
    """Settings as the command line takes them with --set."""
    if settings is None:
        return []
    if not isinstance(settings, Mapping):
        raise wrong_type(argument, settings, 'accepted is a dict such as {"confidence": 0.9}')
    return [(whole_text(key, argument), text_of(value, f"{argument}[{key!r}]")) for key, value in settings.items()]


def path_text(path: object, argument: str) -> str:
    """The text of a path. Raises ArgumentTypeError, and UsageError for what cannot be the name of a file."""
    if not isinstance(path, (str, bytes, os.PathLike)):
        raise wrong_type(argument, path, "accepted is a path: text, bytes or pathlib.Path")
    try:
        name = os.fsdecode(path)
    except TypeError as error:  # __fspath__ of a type of yours
        raise wrong_type(argument, path, "accepted is a path: text, bytes or pathlib.Path") from error
    text = whole_text(name, argument)
    if "\0" in text:
        raise wrong_value(argument, text, "a name cannot hold the character NUL")
    return text


def need(module: str, extra: str) -> Any:
    """An optional module. Raises UsageError that says how to install it."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise UsageError(f"this needs the package {module}: pip install 'tumble[{extra}]'") from error
