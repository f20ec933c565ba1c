"""Plans: which instrument on which rig, how the rig moves, which method reduces the data."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from tumble import _tumble
from tumble._errors import UsageError, wrong_type
from tumble._text import Sets, path_text, sets_of


class Plan:
    """A plan, read and checked. It cannot be changed; `with_` gives another one."""

    __slots__ = ("_core", "_sets", "_what")

    def __init__(self, what: str, sets: Sets, core: _tumble.Plan) -> None:
        self._what = what
        self._sets = sets
        self._core = core

    def with_(self, settings: Mapping[str, object] | None = None, /, **more: object) -> Plan:
        """The plan with other values, as `--set` of the command line gives them.

        Given     settings  by key: a setting of the method, "rig.KEY", "truth.KEY", "channels.ROLE", "unit.COLUMN"
        Returned  another plan; this one does not change
        Raises    UsageError with every unknown key, wrong unit and bare number
        Example   plan.with_(confidence=0.9), plan.with_({"rig.radius": "2.5 m"})
        """
        if settings is not None and not isinstance(settings, Mapping):
            raise wrong_type("settings", settings, 'accepted is a dict such as {"confidence": 0.9}')
        added = sets_of({**(settings or {}), **more})
        if not added:
            return self
        keys = {key for key, _ in added}
        sets = [one for one in self._sets if one[0] not in keys] + added
        if self._core.method and not self._core.file:
            return Plan(self._what, sets, _tumble.plan_for_method(self._what, sets))
        core = _tumble.load_plan(self._what, sets)
        if core.sha256 != self._core.sha256:
            raise UsageError(f"{self._what}: the file has changed since it was loaded; load the plan again")
        return Plan(self._what, sets, core)

    @property
    def file(self) -> str:
        """File of the plan; empty for a method without one."""
        return self._core.file

    @property
    def text(self) -> str | None:
        """Text of the file, up to 100 kB."""
        return self._core.text

    @property
    def title(self) -> str:
        """Title of the test."""
        return self._core.title

    @property
    def method(self) -> str:
        """Name of the method, one of tumble.methods."""
        return self._core.method

    @property
    def instrument_model(self) -> str:
        """Name of the model, one of tumble.models; empty where the plan names none."""
        return self._core.instrument_model

    @property
    def instrument_serial(self) -> str:
        """Serial number of the instrument."""
        return self._core.instrument_serial

    @property
    def rig(self) -> str:
        """Name of the rig, one of tumble.rigs; empty where the plan names none."""
        return self._core.rig

    @property
    def sample_rate(self) -> float:
        """Sampling rate of the simulation [Hz]."""
        return self._core.sample_rate

    @property
    def settings(self) -> dict[str, str]:
        """Settings of the method, defaults included, as text with units."""
        return self._core.settings

    @property
    def rig_settings(self) -> dict[str, str]:
        """Settings of the rig, defaults included, as text with units."""
        return self._core.rig_settings

    @property
    def truth(self) -> dict[str, str]:
        """Truth of the simulation, defaults included, as text with units."""
        return self._core.truth

    @property
    def recordings(self) -> tuple[str, ...]:
        """Files that the plan names."""
        return tuple(self._core.recordings)

    def __copy__(self) -> Plan:
        return self

    def __deepcopy__(self, memo: object) -> Plan:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self._what, self._sets, self._core.sha256)

    def __repr__(self) -> str:
        changes = "".join(f", {key}={value}" for key, value in self._sets)
        return f"<Plan {self._what}{changes}>"


def load_plan(path: str | os.PathLike[str], settings: Mapping[str, object] | None = None) -> Plan:
    """Reads and checks a plan.

    Given     path      .toml file (docs/plan.md)
              settings  values that replace those of the file, as in Plan.with_
    Raises    UsageError with every problem of the file, each with its line; FileError
    Example   tumble.load_plan("plans/fog_thermal_bias.toml")
    """
    text = path_text(path, "path")
    sets = sets_of(settings)
    return Plan(text, sets, _tumble.load_plan(text, sets))


def plan_of(what: object, settings: Mapping[str, object] | None) -> Plan:
    """A plan from a plan, the path of one, or the name of a method that needs none."""
    if isinstance(what, Plan):
        return what if settings is None else what.with_(settings)
    if not isinstance(what, (str, bytes, os.PathLike)):
        raise wrong_type("plan", what, "accepted are a Plan, the path of a plan, and the name of a method")
    text = path_text(what, "plan")
    if text.endswith(".toml") or os.path.dirname(text) or (os.path.exists(text) and not os.path.isdir(text)):
        return load_plan(text, settings)
    sets = sets_of(settings)
    return Plan(text, sets, _tumble.plan_for_method(text, sets))


def _again(what: str, sets: Sets, sha256: str) -> Plan:
    """What a pickled plan becomes: its file is read again. Raises UsageError where the file is another one now."""
    plan = plan_of(what, dict(sets))
    if plan._core.sha256 != sha256:
        raise UsageError(f"{what}: the file has changed since the plan was pickled")
    return plan
