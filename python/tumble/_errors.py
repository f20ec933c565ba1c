"""Exceptions and warnings. They mirror the exit statuses of the command `tumble`."""

from __future__ import annotations

import json
import re
import reprlib
from collections.abc import Sequence
from typing import Any

_LINE = re.compile(r"^(?P<file>[^\n:]+\.[A-Za-z0-9]+):(?P<line>\d+):")
_FILE = re.compile(r"^'?(?P<file>[^\n:']+\.[A-Za-z0-9]+)'?\b")
_LINE_ALONE = re.compile(r"\bline (?P<line>\d+)\b")
_TIME = re.compile(r"\bat (?P<time>-?\d+(?:\.\d+)?) s\b")


class TumbleError(Exception):
    """A request that cannot be carried out.

    `problems` holds every problem found, not only the first. `file`, `line` and `time` [s] say where the first of them
    is; each is None where the message does not say it. `status` is the exit status of the command for such an error.
    `errors` holds each problem as values: a dictionary with `code`, `message`, `pattern`, `values` and `where`; empty
    where the package itself has refused.
    """

    status = 4

    def __init__(self, problems: str | Sequence[str], errors: Sequence[dict[str, Any]] = ()) -> None:
        self.errors: tuple[dict[str, Any], ...] = tuple(errors)
        self.problems: tuple[str, ...] = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems))
        first = self.problems[0] if self.problems else ""
        placed = _LINE.match(first)
        file = placed or _FILE.match(first)
        line = placed or _LINE_ALONE.search("\n".join(self.problems))
        time = _TIME.search(first)
        self.file: str | None = file["file"] if file else None
        self.line: int | None = int(line["line"]) if line else None
        self.time: float | None = float(time["time"]) if time else None
        where = self.errors[0]["where"] if self.errors else {}
        self.file, self.line = where.get("file", self.file), where.get("line", self.line)
        self.time = where.get("time", self.time)

    def __reduce__(self) -> tuple[type[TumbleError], tuple[tuple[str, ...], tuple[dict[str, Any], ...]]]:
        return type(self), (self.problems, self.errors)


class LimitError(TumbleError):
    """A limit of the plan failed or could not be decided (exit status 1)."""

    status = 1


class UsageError(TumbleError, ValueError):
    """The request itself is wrong: a plan, a setting, an argument (exit status 2)."""

    status = 2


class ArgumentTypeError(UsageError, TypeError):
    """An argument has a type that is not accepted (exit status 2)."""


class DataError(TumbleError, ValueError):
    """The data cannot answer the question: missing values, too short, the wrong unit (exit status 3)."""

    status = 3


class FileError(DataError):
    """A file cannot be read, understood or written (exit status 3)."""


class InternalError(TumbleError):
    """A defect of Tumble (exit status 4). Please report it."""


class TumbleWarning(UserWarning):
    """A finding of severity warning or error: the answer is weak, or the data have a fault."""


_KINDS: dict[str, type[TumbleError]] = {
    "bad_input": UsageError,
    "unsupported": UsageError,
    "bad_data": DataError,
    "bad_file": FileError,
    "internal": InternalError,
}


def error_of(kind: str, problems: list[str], errors: str = "[]") -> TumbleError:
    """The exception for an error of the C++ library, whose problems are given as JSON, too."""
    return _KINDS[kind](problems, json.loads(errors))


def wrong_type(argument: str, given: object, accepted: str) -> ArgumentTypeError:
    """The exception for an argument of a wrong type. `accepted` says what would be right."""
    return ArgumentTypeError(
        f"argument {argument}: {shown(given)} of type {type(given).__name__} was given; {accepted}"
    )


def wrong_value(argument: str, given: object, accepted: str) -> UsageError:
    """The exception for an argument of the right type with a wrong value. `accepted` says what would be right."""
    return UsageError(f"argument {argument}: {shown(given, 300)} was given; {accepted}")


def shown(given: object, most: int = 60) -> str:
    """What was given, for a message: at most so many characters of its repr; the type of an object that has none."""
    try:
        text = reprlib.repr(given) if isinstance(given, (list, tuple, dict, set, frozenset)) else repr(given)
    except Exception:  # of whoever wrote that type; and integers of more than 4300 digits have no text
        return f"<{type(given).__name__}>"
    return text if len(text) <= most else text[: most - 3] + "..."
