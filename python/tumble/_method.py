"""Methods written in Python, and whether their intervals hold the truth."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from tumble import _tumble
from tumble._errors import UsageError, shown, wrong_type
from tumble._recording import Recording
from tumble._result import Result
from tumble._text import count_of, number_of, whole_text

Answer = tuple[Mapping[str, tuple[float, str]], Any]


class Method(NamedTuple):
    """A method given by functions.

    `identify(recordings, settings)` returns parameters, {name: (value, unit)}, and their covariance, shape (p, p), in
    products of these units. `trial(seed)` returns simulated recordings and the truth, {name: value [unit of the
    parameter]}; noise and repeatability are new with every seed, the truth is not. `options` are the settings with
    their defaults; others are refused.
    """

    name: str
    summary: str
    identify: Callable[[Sequence[Recording], Mapping[str, Any]], Answer]
    trial: Callable[[int], tuple[Sequence[Recording], Mapping[str, float]]] | None = None
    options: Mapping[str, Any] = {}


class Coverage(NamedTuple):
    """How often the 95 % interval of a parameter held the truth; `holds`: `fraction` is within `allowed`."""

    parameter: str
    fraction: float
    allowed: tuple[float, float]

    @property
    def holds(self) -> bool:
        """Whether the fraction is what 95 % gives with this number of seeds, within four standard deviations."""
        return self.allowed[0] <= self.fraction <= self.allowed[1]


def run(method: Method, recordings: Iterable[Recording], settings: Mapping[str, Any] | None) -> Result:
    """Runs a method and makes a result of its answer, checked as a result file is."""
    given = list(recordings)
    for recording in given:
        if not isinstance(recording, Recording):
            raise wrong_type(f"recordings of method {method.name}", recording, "accepted are recordings")
    for name, function in (("identify", method.identify), ("trial", method.trial)):
        if not callable(function) and (name == "identify" or function is not None):
            raise wrong_type(f"{name} of method {method.name}", function, "accepted is a function")
    for one in (settings, method.options):
        if one is not None and not isinstance(one, Mapping):
            raise wrong_type("settings", one, 'accepted is a dict such as {"settling": "5 s"}')
        for key in one or {}:
            whole_text(key, "settings")
    method = method._replace(name=whole_text(method.name, "name"), options=method.options or {})
    unknown = set(settings or {}) - set(method.options)
    if unknown:
        raise UsageError(
            f"method {method.name}: unknown settings {', '.join(sorted(unknown))}; accepted are "
            f"{', '.join(method.options) or 'none'}"
        )
    resolved = {**method.options, **(settings or {})}
    answer = method.identify(given, resolved)
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise wrong_type(f"identify of method {method.name}", answer, "accepted is (parameters, covariance)")
    document = _document(method, *answer, given, resolved)
    return Result(_tumble.Estimate.from_json(json.dumps(document), f"answer of method {method.name}"))


def _document(
    method: Method, parameters: Any, covariance: Any, recordings: list[Recording], settings: Mapping[str, Any]
) -> dict[str, Any]:
    import numpy as np

    if not isinstance(parameters, Mapping) or not parameters:
        raise wrong_type(f"parameters of method {method.name}", parameters, 'accepted is {"bias": (value, "deg/h")}')
    try:
        if np.iscomplexobj(covariance):
            raise TypeError("complex numbers")
        matrix = np.asarray(covariance, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise wrong_type(f"covariance of method {method.name}", covariance, "accepted is a matrix (p, p)") from error
    if matrix.shape != (len(parameters), len(parameters)):
        raise UsageError(
            f"method {method.name}: the covariance of {len(parameters)} parameters has the shape {matrix.shape}; "
            f"accepted is {(len(parameters), len(parameters))}"
        )
    factor = _factor(matrix, method.name)
    return {
        "tumble": _tumble.version,
        "method": method.name,
        "title": method.name,
        "instrument": {"model": "", "serial": ""},
        "parameters": [
            _parameter(method.name, name, given, math.sqrt(matrix[i, i]))
            for i, (name, given) in enumerate(parameters.items())
        ],
        "covariance": matrix.tolist(),
        "budget": [
            {"source": "the method", "key": None, "sd": np.sqrt(np.diag(matrix)).tolist(), "factor": factor.tolist()}
        ],
        "tables": [],
        "curves": [],
        "fit": {"observations": 0, "degrees_of_freedom": None, "chi_square": None, "condition": None},
        "findings": [],
        "verdicts": [],
        "provenance": {
            "inputs": [{"file": one.file, "sha256": one.sha256} for one in recordings],
            "plans": [],
            "settings": {key: _said(value) for key, value in settings.items()},
            "command_line": {},
            "seed": None,
        },
    }


def _said(value: object) -> str:
    try:
        return str(value)
    except Exception:  # of whoever wrote that type
        return shown(value)


def _factor(matrix: Any, method: str) -> Any:
    """B with B B' = matrix. Raises UsageError where there is none."""
    import numpy as np

    if not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T, rtol=1e-12, atol=0.0):
        raise UsageError(f"method {method}: the covariance is not finite and symmetric")
    sd = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    scale = np.where(sd > 0.0, sd, 1.0)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    if values.min() < -1e-9:
        raise UsageError(f"method {method}: the covariance has a negative eigenvalue")
    return scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))


def _parameter(method: str, name: object, given: Any, sd: float) -> dict[str, Any]:
    where = f"parameter {name!r} of method {method}"
    if not isinstance(name, str) or not name or not isinstance(given, (tuple, list)) or len(given) != 2:
        raise wrong_type(where, given, 'accepted are a name and (value, unit), such as {"bias": (0.1, "deg/h")}')
    value = number_of(given[0], where, "accepted is a finite number")
    half = 1.959963984540054 * sd  # of the normal distribution, 95 %
    return {
        "name": whole_text(name, where),
        "symbol": name,
        "value": value,
        "sd": sd,
        "unit": whole_text(given[1], where),
        "description": "",
        "degrees_of_freedom": None,
        "interval95": [value - half, value + half],
    }


def coverage(method: Method, *, seeds: int = 100, settings: Mapping[str, Any] | None = None) -> list[Coverage]:
    """How often the 95 % intervals of a method hold the truth of its trial.

    Given     seeds  number of trials, 20 or more
    Returned  one line a parameter; `allowed` is 0.95 -+ 4 sqrt(0.95 0.05/seeds)
    Raises    UsageError where the method has no trial
    """
    if not isinstance(method, Method):
        raise wrong_type("method", method, "accepted is a tumble.Method")
    if method.trial is not None and not callable(method.trial):
        raise wrong_type(f"trial of method {method.name}", method.trial, "accepted is a function")
    if method.trial is None:
        raise UsageError(f"method {method.name} has no trial: coverage needs recordings whose truth is known")
    if (seeds := count_of(seeds, "seeds")) < 20:
        raise UsageError(f"argument seeds: {seeds} was given; accepted are 20 or more")
    held: dict[str, int] = {}
    for seed in range(1, seeds + 1):
        drawn = method.trial(seed)
        known = isinstance(drawn, tuple) and len(drawn) == 2 and isinstance(drawn[1], Mapping)
        if not known or not isinstance(drawn[0], (Recording, list, tuple)):
            raise wrong_type(f"trial of method {method.name}", drawn, "accepted is (recordings, {name: truth})")
        recordings, truth = drawn
        if isinstance(recordings, Recording):
            recordings = [recordings]
        result = run(method, recordings, settings)
        for name, value in truth.items():
            if name not in result.parameters:
                raise UsageError(f"method {method.name}: the trial names {name!r}, which identify does not return")
            low, high = result.parameters[name].interval
            truly = number_of(value, f"truth of {name!r} of method {method.name}")
            held[name] = held.get(name, 0) + (low <= truly <= high)
    width = 4.0 * math.sqrt(0.95 * 0.05 / seeds)
    return [Coverage(name, count / seeds, (0.95 - width, 0.95 + width)) for name, count in held.items()]
