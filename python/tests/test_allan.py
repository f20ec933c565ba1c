"""The Allan family of arrays: against definitions, against the command line, and bad input."""

from __future__ import annotations

import numpy as np
import pytest

import tumble

RATE = 100.0
KINDS = "adev oadev mdev tdev hdev ohdev totdev mtotdev ttotdev htotdev pdev theo1 theoh mtie tierms".split()


def noise(count: int = 3000) -> np.ndarray:
    return np.random.default_rng(7).normal(size=count)


def test_deviation_is_that_of_its_definition():
    x, m = noise(), 12
    phase = np.concatenate([[0.0], np.cumsum(x)]) / RATE
    second = phase[2 * m :] - 2 * phase[m:-m] + phase[: -2 * m]
    expected = np.sqrt(np.mean(second**2) / 2) / (m / RATE)
    found = tumble.allan_deviation(x, RATE, taus=[m / RATE])
    assert found.deviation[0] == pytest.approx(expected, rel=1e-10)  # the accuracy that allan.hpp states
    assert found.n[0] == len(second)
    assert found.lower[0] < found.deviation[0] < found.upper[0]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_answers_for_rate_phase_and_increments(kind):
    x = noise(400)
    options = {"mean_rate": "keep"} if kind in ("mtie", "tierms") else {}
    taus = np.array([10, 20, 40]) / RATE
    rate = tumble.allan_deviation(x, RATE, kind=kind, taus=taus, **options)
    assert len(rate.taus) == 3
    increment = tumble.allan_deviation(x / RATE, RATE, kind=kind, taus=taus, data="increment", **options)
    np.testing.assert_allclose(increment.deviation, rate.deviation, rtol=1e-9)
    phase = np.concatenate([[0.0], np.cumsum(x)]) / RATE
    by_phase = tumble.allan_deviation(phase, RATE, kind=kind, taus=taus, data="phase", **options)
    np.testing.assert_allclose(by_phase.deviation, rate.deviation, rtol=1e-9)
    assert rate.kind == kind


def test_averaging_times_are_chosen_as_the_command_line_does(tmp_path, command):
    x = noise()
    file = tmp_path / "x.csv"
    tumble.from_arrays({"gyro.x": (x, "deg/h")}, rate=RATE).save(file)
    for taus in ("log", "octave", "decade", "all"):
        ours = tumble.allan_deviation(tumble.read(file)["gyro.x"], taus=taus)
        result = tumble.identify("allan_noise", file, settings={"taus": taus})
        name = "every_averaging_time" if taus == "all" else "allan_deviation"
        curve = next(curve for curve in result.curves if curve.name == f"gyro.x {name}")
        factor = np.pi / 180 / 3600
        np.testing.assert_allclose(ours.taus, curve.x.values, rtol=1e-12)
        np.testing.assert_allclose(ours.deviation, curve.y.values * factor, rtol=1e-12)
        np.testing.assert_allclose(ours.lower, curve.lower * factor, rtol=1e-12)
        np.testing.assert_allclose(ours.upper, curve.upper * factor, rtol=1e-12)


def test_an_array_is_read_in_place():
    x = noise()
    x.flags.writeable = False
    assert tumble.allan_deviation(x, RATE).deviation[0] == pytest.approx(1.0, abs=4 / np.sqrt(3000))


def test_missing_samples_are_bridged_on_request():
    x = noise()
    x[100:110] = np.nan
    with pytest.raises(tumble.DataError, match="argument x: 10 of 3000 values are NaN, the first is sample 100"):
        tumble.allan_deviation(x, RATE)
    found = tumble.allan_deviation(x, RATE, missing="nan")
    assert found.deviation[0] == pytest.approx(1.0, abs=4 / np.sqrt(3000))
    assert found.n[0] < 2999


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"kind": "adve"}, "argument kind: 'adve' was given; accepted are allan, overlapping"),
        ({"data": "speed"}, "argument data: 'speed'"),
        ({"taus": "some"}, "argument taus: 'some'"),
        ({"taus": [1e-6]}, "argument taus: 1e-06 s was given; accepted are averaging times of 0.01 s"),
        ({"taus": [None]}, "argument taus: None of type NoneType"),
        ({"taus": ["1 m"]}, "'1 m'"),
        ({"sample_rate": 0}, "argument sample_rate: 0 was given"),
        ({"sample_rate": None}, "argument sample_rate: nothing was given"),
        ({"confidence": 2.0}, "confidence must lie between 0 and 1"),
        ({"mean_rate": "no"}, "argument mean_rate: 'no'"),
        ({"missing": "NA"}, "argument missing: 'NA'"),
        ({"x": noise().reshape(-1, 3)}, "argument x: an array with 2 dimensions"),
        ({"x": ["a", "b"]}, "argument x: .* of type list was given"),
    ],
)
def test_bad_arguments_are_refused_by_name(arguments, says):
    given = {"x": noise(), "sample_rate": RATE, **arguments}
    with pytest.raises(tumble.UsageError, match=says):
        tumble.allan_deviation(given.pop("x"), given.pop("sample_rate"), **given)


def test_too_short_records_are_refused():
    with pytest.raises(tumble.DataError, match="3 samples"):
        tumble.allan_deviation([1.0, 2.0], RATE, taus="log")
    with pytest.raises(tumble.DataError, match="argument x: 300 samples are too few for hdev at these averaging times"):
        tumble.allan_deviation(noise(300), RATE, kind="hdev", taus=[2.0])


def test_a_missing_sample_is_found_wherever_it_is():
    for place in (0, 1500, 2999):
        x = noise()
        x[place] = np.nan
        for taus in ("octave", "log", "all", [5.0]):
            with pytest.raises(tumble.DataError, match=f"the first is sample {place}"):
                tumble.allan_deviation(x, RATE, taus=taus)
