"""Quantities as the C++ library reads them: text with a unit."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from tumble._errors import UsageError, wrong_type

Sets = list[tuple[str, str]]

ACCEPTED = 'text with a unit such as "10 deg/h", a number, True or False, a list of whole numbers, or a pint quantity'


def text_of(value: object, argument: str) -> str:
    """The text of a value that a plan or an option takes.

    Raises ArgumentTypeError for anything that is not text, a number, a list of whole numbers or a quantity.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if isinstance(value, bool):
        return "true" if value else "false"
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        return f"{number_text(value.magnitude, argument)} {unit_text(value.units)}"
    if isinstance(value, (list, tuple)):
        return ",".join(text_of(one, argument) for one in value)
    return number_text(value, argument)


def number_text(value: Any, argument: str) -> str:
    """All digits of a number of Python or NumPy."""
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if not isinstance(value, (int, float)):
        raise wrong_type(argument, value, f"accepted are {ACCEPTED}")
    return repr(value)


def unit_text(units: Any) -> str:
    """The unit of a pint quantity, or of any object whose text is a unit."""
    try:
        text = format(units, "~C")
    except (ValueError, TypeError):
        text = str(units)
    return text.replace("**", "^").replace("°", "deg").replace("Δ", "").replace("delta_", "") or "1"


def sets_of(settings: Mapping[str, object] | None, argument: str = "settings") -> Sets:
    """Settings as the command line takes them with --set."""
    if settings is None:
        return []
    if not isinstance(settings, Mapping):
        raise wrong_type(argument, settings, 'accepted is a dict such as {"confidence": 0.9}')
    return [(key, text_of(value, f"{argument}[{key!r}]")) for key, value in settings.items()]


def path_text(path: object, argument: str) -> str:
    """The text of a path. Raises ArgumentTypeError for anything else."""
    if isinstance(path, str):
        return path
    if isinstance(path, os.PathLike):
        text = os.fspath(path)
        return text.decode() if isinstance(text, bytes) else text
    raise wrong_type(argument, path, "accepted is a path: text or pathlib.Path")


def need(module: str, extra: str) -> Any:
    """An optional module. Raises UsageError that says how to install it."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise UsageError(f"this needs the package {module}: pip install 'tumble[{extra}]'") from error
