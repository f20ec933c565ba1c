"""Results: parameters with a full covariance, and all that a reader needs to judge them."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from tumble import _tumble
from tumble._errors import FileError, LimitError, wrong_type, wrong_value
from tumble._figure import Figure, figures_of
from tumble._finding import Finding, findings_of
from tumble._named import Named
from tumble._result_parts import (
    Budget,
    Covariance,
    Curve,
    Fit,
    Parameter,
    Prior,
    Provenance,
    Table,
    Verdict,
    WithPrior,
    curve_of,
    parameter_of,
    with_prior_of,
)
from tumble._text import need, path_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Result:
    """The result of identify, predict or optimise. It cannot be changed.

    Every number has the unit that stands beside it, as in the result file; `in_` gives another unit.
    """

    _core: _tumble.Estimate

    def __init__(self, core: _tumble.Estimate) -> None:
        self.__dict__["_core"] = core

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Result cannot be changed: {name!r}")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a Result cannot be changed: {name!r}")

    @property
    def document(self) -> dict[str, Any]:
        """The result file (docs/report.md) as Python values: a copy, which is yours."""
        document: dict[str, Any] = json.loads(self._core.to_json())
        return document

    @cached_property
    def _document(self) -> dict[str, Any]:
        return self.document

    @property
    def method(self) -> str:
        """Name of the method."""
        return str(self._document["method"])

    @property
    def title(self) -> str:
        """Title of the test."""
        return str(self._document["title"])

    @cached_property
    def parameters(self) -> Mapping[str, Parameter]:
        """Parameters by name: `result.parameters["K_1"].value`, `.sd`, `.interval`, `.in_("ug/g^2")`."""
        return Named("parameter", {one["name"]: parameter_of(one) for one in self._document["parameters"]})

    @property
    def values(self) -> NDArray[np.float64]:
        """Values of all parameters, shape (p,), each in the unit of its parameter."""
        import numpy as np

        return np.array([one.value for one in self.parameters.values()], dtype=np.float64)

    @cached_property
    def covariance(self) -> Covariance:
        """Covariance of the parameters, all contributions together, with names: `result.covariance["K_0", "K_1"]`."""
        return Covariance(tuple(self.parameters), self._document["covariance"])

    @cached_property
    def budget(self) -> Budget:
        """What each source of uncertainty gives each parameter: `result.budget["rig: level"]["K_0"]`."""
        return Budget(tuple(self.parameters), self._document["budget"])

    @cached_property
    def fit(self) -> Fit:
        """Observations, degrees of freedom, chi-square and condition of the fit."""
        return Fit(**self._document["fit"])

    @cached_property
    def tables(self) -> Mapping[str, Table]:
        """Tables by name."""
        return Named("table", {one["name"]: Table(one) for one in self._document["tables"]})

    @cached_property
    def curves(self) -> tuple[Curve, ...]:
        """The curves of the report; those with the same `figure` are drawn in one figure."""
        return tuple(curve_of(one) for one in self._document["curves"])

    @cached_property
    def figures(self) -> tuple[Figure, ...]:
        """The figures of the report: `result.figures[0].to_svg()`, or tumble.plot for matplotlib."""
        return figures_of(self._core)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """What is suspicious in the data or weak in the answer."""
        return findings_of(self._document["findings"])

    @cached_property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Pass, fail or undecided for each limit of the plan."""
        return tuple(Verdict(one["parameter"], one["outcome"], one["limit"]) for one in self._document["verdicts"])

    @cached_property
    def provenance(self) -> Provenance:
        """All that the answer depends on: files with SHA-256, plans, settings, seed."""
        return Provenance(self._document["provenance"])

    @cached_property
    def prior(self) -> Prior | None:
        """The prior that the plan asks for: `result.prior["population"]["units"]`; None without one."""
        return Prior(self._document["prior"]) if "prior" in self._document else None

    @cached_property
    def with_prior(self) -> WithPrior | None:
        """The estimate with prior; None without one, or where the unit does not fit its population."""
        return with_prior_of(self._document["with_prior"]) if "with_prior" in self._document else None

    def require_limits(self) -> None:
        """Raises LimitError where a limit failed or could not be decided, as `tumble identify --strict` does."""
        problems = [
            f"{one.parameter}: {one.outcome} ({one.limit})"
            for one in self.verdicts
            if one.outcome == "fail" or one.parameter not in self.parameters
        ]
        if problems:
            raise LimitError(problems)

    def to_json(self) -> str:
        """Text of the result file."""
        return self._core.to_json()

    def to_html(self) -> str:
        """The report: one page that needs no network."""
        return self._core.to_html()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the result: .json for the result file, .html for the report; whole or not at all."""
        text = path_text(path, "path")
        if text.lower().endswith(".json"):
            _tumble.write_whole(text, self.to_json())
        elif text.lower().endswith((".html", ".htm")):
            _tumble.write_whole(text, self.to_html())
        else:
            raise wrong_value("path", text, "the name must end in .json or .html")

    def to_uncertainties(self) -> dict[str, Any]:
        """Parameters as correlated numbers of the package uncertainties, each in the unit of its parameter."""
        correlated = need("uncertainties", "units").correlated_values
        return dict(zip(self.parameters, correlated(self.values, self.covariance.values), strict=True))

    def __str__(self) -> str:
        return self._core.to_text()

    def __repr__(self) -> str:
        return f"<Result of {self.method}: {len(self.parameters)} parameters, {len(self.findings)} findings>"

    def _repr_html_(self) -> str:
        from tumble._html import result_table

        return result_table(self.title, self.parameters.values(), self.verdicts, self.findings)

    def __copy__(self) -> Result:
        return self

    def __deepcopy__(self, memo: object) -> Result:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_text, (self.to_json(), "pickled result")


def _from_text(text: str, file: str) -> Result:
    return Result(_tumble.Estimate.from_json(text, file))


def load_result(path: str | os.PathLike[str]) -> Result:
    """Reads a result file (.json) of identify, predict or `tumble identify -o`.

    Raises FileError with what is missing or wrong.
    """
    text = path_text(path, "path")
    try:
        if stat.S_ISCHR(os.stat(text).st_mode):
            raise FileError(f"{text}: is a device, and no result file")
        with open(text, encoding="utf-8") as file:
            return _from_text(file.read(), text)
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"{text}: {error}") from error


def result_of(given: object) -> Result:
    """A result, or the path of a result file."""
    if isinstance(given, Result):
        return given
    if isinstance(given, (str, bytes, os.PathLike)):
        return load_result(path_text(given, "result"))
    raise wrong_type("result", given, "accepted are a Result and the path of a result file")
