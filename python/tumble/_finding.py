"""Findings: what is suspicious in the data or weak in the answer."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from tumble._errors import TumbleWarning


class Finding(NamedTuple):
    """One finding. `severity` is info, warning or error; `code` is the same in every language (docs/findings.md).

    `values` are the numbers and names that the sentence `message` contains: a number is a tuple (value, unit).
    """

    severity: str
    code: str
    message: str
    where: str
    occurrences: int
    values: Mapping[str, Any]

    def __str__(self) -> str:
        return f"{self.severity}: {self.message}" + (f" ({self.where})" if self.where else "")


def findings_of(documents: Sequence[Mapping[str, Any]]) -> tuple[Finding, ...]:
    """Findings from the JSON of a result."""
    return tuple(
        Finding(
            one["severity"],
            one.get("code", ""),
            one["message"],
            one.get("where", ""),
            one.get("count", 1),
            {name: _value(value) for name, value in one.get("values", {}).items()},
        )
        for one in documents
    )


def _value(value: Any) -> Any:
    return (value["value"], value["unit"]) if isinstance(value, dict) and "unit" in value else value


def warn(findings: Sequence[Finding], stacklevel: int) -> None:
    """Passes findings of severity warning and error on as TumbleWarning."""
    for finding in findings:
        if finding.severity != "info":
            warnings.warn(str(finding), TumbleWarning, stacklevel=stacklevel + 1)
