"""One function for each thing that a user wants: what the verbs of the command line do."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from tumble import _finding, _tumble
from tumble._errors import wrong_type, wrong_value
from tumble._method import Method
from tumble._method import run as run_method
from tumble._plan import Plan, plan_of
from tumble._progress import listener
from tumble._recording import Recording
from tumble._result import Result, result_of
from tumble._text import (
    count_of,
    flag_of,
    listed,
    number_of,
    one_of,
    path_text,
    sets_of,
    si_of,
    text_of,
    whole_of,
    whole_text,
    words_of,
)

if TYPE_CHECKING:
    from tumble.archive import Archive

MEMORY = 2_000_000_000


def identify(
    plan: Plan | Method | str | os.PathLike[str],
    *recordings: Recording | str | os.PathLike[str],
    settings: Mapping[str, object] | None = None,
    strict: bool = False,
    memory_limit: float = MEMORY,
    progress: object = None,
) -> Result:
    """Identifies parameters with their uncertainty.

    Given     plan          a Plan, the path of one, the name of a method that needs none ("allan_noise"), or a Method
              recordings    recordings or their paths, in addition to those of the plan
              settings      settings of the method, and values of the plan, as in Plan.with_; "instrument.serial" states
                            the unit, and a recording of another one is refused
              strict        raise LimitError where a limit of the plan failed or could not be decided
              memory_limit  [bytes] a file with more samples is worked through in blocks, if the method supports it
              progress      None, True (a bar), or a function of (done, what)
    Returned  the result; its findings of severity warning and error are also TumbleWarnings
    Raises    UsageError, DataError, FileError with every problem found
    Example   tumble.identify("allan_noise", "imu.csv").parameters["gyro.x.angle_random_walk"].in_("deg/sqrt(h)")
    """
    if isinstance(plan, Method):
        return run_method(plan, _all_read(recordings), settings)
    made, checked = plan_of(plan, settings), flag_of(strict, "strict")
    files, in_memory = [], []
    for recording in recordings:
        if isinstance(recording, Recording):
            in_memory.append(recording._core)
        elif isinstance(recording, (str, bytes, os.PathLike)):
            files.append(path_text(recording, "recordings"))
        else:
            raise wrong_type("recordings", recording, _accepted_recordings(recording))
    memory = count_of(int(number_of(memory_limit, "memory_limit")), "memory_limit")
    with listener(progress) as call:
        result = Result(_tumble.identify(made._core, files, in_memory, memory, call))
    _finding.warn(result.findings, stacklevel=2)
    if checked:
        result.require_limits()
    return result


def _all_read(recordings: Iterable[object]) -> list[Recording]:
    from tumble._read import read

    made = []
    for recording in recordings:
        if isinstance(recording, (str, bytes, os.PathLike)):
            made.append(read(path_text(recording, "recordings")))
        elif isinstance(recording, Recording):
            made.append(recording)
        else:
            raise wrong_type("recordings", recording, _accepted_recordings(recording))
    return made


def _accepted_recordings(given: object) -> str:
    text = "accepted are recordings (tumble.read, tumble.from_arrays, tumble.from_pandas) and paths"
    if isinstance(given, (list, tuple)) and given and isinstance(given[0], (Recording, str, os.PathLike)):
        return text + ", one argument each: identify(plan, *recordings)"
    if hasattr(given, "dtype") or isinstance(given, (list, tuple)):
        text += "; samples alone have no unit and no rate: tumble.from_arrays({'gyro.x': (array, 'deg/s')}, rate=100)"
    return text


def simulate(
    plan: Plan | str | os.PathLike[str],
    *,
    seed: int = 1,
    settings: Mapping[str, object] | None = None,
    departures: Iterable[str] = (),
    progress: object = None,
) -> Recording:
    """The test of a plan, simulated with rig and instrument.

    Given     plan        a Plan or its path, with [rig], [[schedule]] and [truth]
              seed        of the random numbers, 0 or more; the same seed gives the same samples
              settings    values that replace those of the plan: "truth.KEY", "rig.KEY"
              departures  in which the test departs from its plan: "clock_fast=300 ppm", "order_changed"
    Raises    UsageError with all that the plan lacks, and for a departure that divides the recording
    Example   tumble.simulate("plans/fog_thermal_bias.toml", seed=7).save("test.h5")
    """
    number = whole_of(seed, "seed", 0, (1 << 64) - 1)
    made, wanted = plan_of(plan, settings), words_of(departures, "departures")
    if wanted:
        recordings = _tumble.simulate_departed(made._core, number, wanted)
        if len(recordings) > 1:
            raise wrong_value("departures", wanted, "accepted are those that leave one recording")
        return Recording(recordings[0])
    with listener(progress) as call:
        return Recording(_tumble.simulate(made._core, number, call))


def predict(
    plan: Plan | str | os.PathLike[str],
    *,
    terms: Iterable[str] = (),
    settings: Mapping[str, object] | None = None,
) -> Result:
    """The uncertainties before the test, with the plan's truth as values.

    Given     plan   a Plan or its path, with [instrument], [rig], [[schedule]] and [truth]
              terms  only these terms of the model, the others are assumed to be known; empty: all
    Raises    UsageError with all that the plan lacks
    """
    return Result(_tumble.predict(plan_of(plan, settings)._core, words_of(terms, "terms")))


def validate(
    plan: Plan | str | os.PathLike[str],
    *,
    trials: int = 100,
    departure: str = "",
    target: str = "",
    size: str = "",
    seed: int = 1,
    settings: Mapping[str, object] | None = None,
    progress: object = None,
) -> Result:
    """Whether the test of a plan holds, and what could go wrong in it without anybody noticing.

    Given     plan       a Plan or its path, with a method, [rig], [[schedule]] and [truth]
              trials     simulated tests that are carried out as planned, ten or more
              departure  only this one, as `tumble list departures` names it; empty: all that the plan's channels allow
              target     only where it happens to this axis or channel; empty: everything that it can happen to
              size       only this size, "300 ppm"; empty: it is searched
              seed       of the first test; the same seed gives the same answer
    Returned  a Result without parameters: tables coverage, unnoticed, what_would_show_it and others, and findings
    Raises    UsageError with all that the plan lacks
    Example   tumble.validate("plans/static_bias.toml").tables["unnoticed"]
    """
    first = whole_of(seed, "seed", 0, (1 << 64) - 1)
    made, count = plan_of(plan, settings), count_of(trials, "trials")
    named = (text_of(departure, "departure"), text_of(target, "target"), text_of(size, "size"))
    with listener(progress) as call:
        return Result(_tumble.validate(made._core, count, first, *named, call))


def optimise(
    plan: Plan | str | os.PathLike[str],
    *,
    criterion: str = "A",
    total_time: object = None,
    step: object = None,
    terms: Iterable[str] = (),
    settings: Mapping[str, object] | None = None,
    progress: object = None,
) -> tuple[Result, str]:
    """The positions, rates and dwell times with the smallest uncertainties that the rig allows.

    Given     criterion   "A": mean variance; "D": determinant of the covariance
              total_time  of all power-ups, "2 h"; None: that of the plan
              step        of the grid of positions, "10 deg"; None: 15 deg
              terms       only these terms of the model; empty: all
    Returned  what is predicted for the schedule found, and the text of the plan with this schedule
    """
    one_of(criterion, "criterion", ("A", "D"))
    made = plan_of(plan, settings)
    time = None if total_time is None else si_of(text_of(total_time, "total_time"), "h", "total_time")
    angle = None if step is None else si_of(text_of(step, "step"), "deg", "step")
    with listener(progress) as call:
        estimate, text = _tumble.optimise(made._core, criterion, time, angle, words_of(terms, "terms"), call)
    return Result(estimate), text


def compensate(
    result: Result | str | os.PathLike[str],
    recording: Recording | str | os.PathLike[str],
    *,
    plan: Plan | str | os.PathLike[str] | None = None,
) -> Recording:
    """Subtracts an identified error model from a recording.

    Given     result     a Result of identify, or its file
              recording  a recording, or its path
              plan       whose rig and schedule say what was felt, where the recording does not
    Returned  the recording with the compensated channel, and `.compensation_sd` and `.extrapolated` beside it
    Raises    UsageError where the method has no error model; DataError
    """
    from tumble._read import read

    made = None if plan is None else plan_of(plan, None)._core
    given = recording if isinstance(recording, Recording) else read(recording)
    core, account = _tumble.compensate(result_of(result)._core, given._core, made)
    _finding.warn(Result(account).findings, stacklevel=2)
    return Recording(core)


def export(
    results: Result | str | os.PathLike[str] | Iterable[Result | str | os.PathLike[str]] | Mapping[str, Result],
    to: str,
    *,
    settings: Mapping[str, object] | None = None,
    drop: Iterable[str] = (),
    inflate: float = 1.0,
) -> str:
    """The calibration and the noise of results as the file of other software.

    Given     results   one or several Results or their files: a calibration, noise, or both; of single sensors a
                        mapping from the axis, {"gyro_x": result}
              to        name of the consumer: tumble.exports has them with formula, units and settings
              settings  settings of the consumer
              drop      terms that the file cannot hold and that may be lost
              inflate   factor on N and K
    Returned  the text of the file
    Raises    UsageError with every term that the consumer cannot carry and the error that its loss leaves
    Example   tumble.export([calibration, noise], "kalibr", settings={"rate": "200 Hz"})
    """
    if isinstance(results, Mapping):
        given = [(axis, one) for axis, one in results.items()]
    elif isinstance(results, (Result, str, os.PathLike)):
        given = [("", results)]
    else:
        accepted = "accepted are a Result, the path of a result file, and several of them"
        given = [("", one) for one in listed(results, "results", accepted)]
    sources = []
    for axis, one in given:
        made = result_of(one)
        name = path_text(one, "results") if isinstance(one, (str, os.PathLike)) else f"{made.method}.json"
        sources.append((name, made.to_json(), text_of(axis, "results")))
    factor = number_of(inflate, "inflate")
    return _tumble.export_results(sources, text_of(to, "to"), sets_of(settings), words_of(drop, "drop"), factor)


def report(result: Result | str | os.PathLike[str], path: str | os.PathLike[str]) -> None:
    """Writes a result as one HTML page that needs no network.

    Example   tumble.report(result, "fog.html")
    """
    if not path_text(path, "path").lower().endswith((".html", ".htm")):
        raise wrong_value("path", path, "the name must end in .html")
    result_of(result).save(path)


def convert(
    recording: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    settings: Mapping[str, object] | None = None,
    progress: object = None,
) -> None:
    """Writes a recording in another format, in blocks, so that it may be larger than memory.

    Given     settings  what the file does not say, as in `tumble convert --set`: {"rate": 100, "unit.x": "deg/h"}
    """
    with listener(progress) as call:
        _tumble.convert(path_text(recording, "recording"), path_text(output, "output"), sets_of(settings), call)


def population(
    model: str,
    *,
    archive: Archive | str | os.PathLike[str],
    method: str = "",
    without: str = "",
    components: str = "",
) -> Result:
    """What an archive says of a further unit of a model, and why results differ; docs/population.md.

    Given     model       of the units, as their results name it
              archive     an open archive, or the address of one
              method      of the results; empty: the only one that there is
              without     serial number of a unit that is not to be part of it
              components  instead: the components of variance of this parameter, from all results
    Returned  a result; its file can be the prior of a plan
    Raises    UsageError, DataError, FileError
    Example   tumble.population("imu", archive="lab.db").save("population.json")
    """
    from tumble import archive as archives

    lab = archive if isinstance(archive, archives.Archive) else archives.open(archive)
    if whole_text(components, "components"):
        return lab.components(model, components, method=method, without=without)
    return lab.population(model, method=method, without=without)
