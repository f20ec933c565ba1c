"""Quantities as the C++ library reads them: text with a unit."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

from tumble import _tumble
from tumble._errors import UsageError, wrong_type

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
        return ",".join(text_of(one, argument) for one in value)
    return number_text(value, argument)


def whole_text(value: object, argument: str) -> str:
    """Text that can be written in UTF-8. Raises ArgumentTypeError for another type, UsageError for half characters."""
    if not isinstance(value, str):
        raise wrong_type(argument, value, "accepted is text")
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise UsageError(f"argument {argument}: {value!r} was given; accepted is text that UTF-8 can hold") from error
    return value


def words_of(values: object, argument: str) -> list[str]:
    """Names: one text, or several in a list. Raises ArgumentTypeError."""
    if isinstance(values, str):
        return [whole_text(values, argument)]
    if not isinstance(values, Iterable) or isinstance(values, (bytes, Mapping)):
        raise wrong_type(argument, values, "accepted are a name and a list of names")
    return [whole_text(one, argument) for one in values]


def is_real(value: Any) -> bool:
    """Whether this is a real number of Python, NumPy, decimal or fractions."""
    return hasattr(value, "as_integer_ratio") and not isinstance(value, bool) and not is_quantity(value)


def number_of(value: Any, argument: str, accepted: str = "accepted is a number") -> float:
    """A finite number. Raises ArgumentTypeError, UsageError."""
    plain = value.item() if hasattr(value, "item") and getattr(value, "ndim", 0) == 0 else value
    if not is_real(plain):
        raise wrong_type(argument, value, accepted)
    if not math.isfinite(number := float(plain)):
        raise UsageError(f"argument {argument}: {value!r} was given; {accepted}")
    return number


def count_of(value: Any, argument: str, least: int = 0) -> int:
    """A whole number, at least `least`. Raises ArgumentTypeError."""
    if isinstance(value, bool) or not hasattr(value, "__index__") or not least <= value.__index__() < 1 << 63:
        raise wrong_type(argument, value, f"accepted are whole numbers from {least} on")
    return int(value.__index__())


def seconds_of(value: Any, argument: str) -> float:
    """A time [s] of a number [s], text with a unit, or a pint quantity. Raises ArgumentTypeError, UsageError."""
    if isinstance(value, str) or is_quantity(value):
        return si_of(text_of(value, argument), "s", argument)
    return number_of(value, argument, 'accepted are numbers [s], text such as "10 s" and pint quantities')


def si_of(text: str, unit: str, argument: str) -> float:
    """The quantity of a text in SI. Raises UsageError that names the argument."""
    try:
        return _tumble.parse_si(text, unit)
    except UsageError as error:
        raise UsageError([f"argument {argument}: {problem}" for problem in error.problems]) from None


def number_text(value: Any, argument: str) -> str:
    """All digits of a number of Python or NumPy."""
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if not is_real(value):
        raise wrong_type(argument, value, f"accepted are {ACCEPTED}")
    return repr(value) if isinstance(value, (int, float)) else repr(float(value))


def is_quantity(value: object) -> bool:
    """Whether this is a quantity of pint."""
    return hasattr(value, "magnitude") and hasattr(value, "units")


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
    elif hasattr(unit, "dimensionality"):
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
    text = whole_text(os.fsdecode(path), argument)
    if "\0" in text:
        raise UsageError(f"argument {argument}: {text!r} was given; a name cannot hold the character NUL")
    return text


def need(module: str, extra: str) -> Any:
    """An optional module. Raises UsageError that says how to install it."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise UsageError(f"this needs the package {module}: pip install 'tumble[{extra}]'") from error
