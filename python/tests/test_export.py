"""Exports: the text that the command line writes, read by the consumer itself where its package is here."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import tumble


@pytest.fixture(scope="module")
def test(tree):
    return tumble.simulate(tree / "plans/imu_ferraris.toml", seed=3)


@pytest.fixture(scope="module")
def calibration(tree, test):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return tumble.identify(tree / "plans/imu_ferraris.toml", test)


@pytest.mark.parametrize("to", ["imucal", "psins", "c"])
def test_the_text_is_that_of_the_command_line(to, calibration, tmp_path, command):
    calibration.save(tmp_path / "calibration.json")
    printed = command("export", tmp_path / "calibration.json", "--to", to)
    assert tumble.export(tmp_path / "calibration.json", to) == printed


def test_several_results_are_joined(calibration, tree):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        noise = tumble.identify("allan_noise", tumble.simulate(tree / "plans/imu_at_rest.toml", seed=3))
    settings = {"rate": "200 Hz", "accelerometer_walk": "50 ug/sqrt(h)"}
    one = tumble.export([calibration, noise], "kalibr", settings=settings)
    ten = tumble.export([calibration, noise], "kalibr", settings=settings, inflate=10)
    value = {text: float(text.split("gyroscope_noise_density: ")[1].split()[0]) for text in (one, ten)}
    assert value[ten] == pytest.approx(10 * value[one], rel=1e-12)
    assert "model: scale-misalignment" in one


def test_imucal_itself_gives_what_compensate_gives(calibration, test):
    imucal = pytest.importorskip("imucal")
    info = imucal.CalibrationInfo.from_json(tumble.export(calibration, "imucal"))
    force = np.column_stack([test[f"accelerometer_{axis}"].in_("m/s^2") for axis in "xyz"])
    rate = np.column_stack([test[f"gyro_{axis}"].in_("deg/s") for axis in "xyz"])
    acc, gyr = info.calibrate(force, rate, "m/s^2", "deg/s")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ours = tumble.compensate(calibration, test)
    for i, axis in enumerate("xyz"):
        np.testing.assert_allclose(acc[:, i], ours[f"accelerometer_{axis}"].in_("m/s^2"), rtol=0, atol=1e-12)
        np.testing.assert_allclose(gyr[:, i], ours[f"gyro_{axis}"].in_("deg/s"), rtol=0, atol=1e-11)


def test_what_a_consumer_cannot_carry_is_named(calibration):
    with pytest.raises(tumble.UsageError, match="px4 cannot carry gyro_misalignment"):
        tumble.export(calibration, "px4", settings={"accelerometer_id": 1, "gyro_id": 1})
    text = tumble.export(
        calibration,
        "px4",
        settings={"accelerometer_id": 1, "gyro_id": 1},
        drop=[
            "accelerometer_misalignment",
            "gyro_misalignment",
            "gyro_scale_factor",
            "gyro_acceleration_sensitivity",
        ],
    )
    assert "# dropped: gyro_misalignment" in text


def test_what_it_cannot_be(calibration):
    with pytest.raises(tumble.UsageError, match="there is no export 'kalibra'; did you mean 'kalibr'"):
        tumble.export(calibration, "kalibra")
    with pytest.raises(tumble.ArgumentTypeError, match="argument results: 5"):
        tumble.export(5, "kalibr")
    with pytest.raises(tumble.ArgumentTypeError, match="argument inflate"):
        tumble.export(calibration, "kalibr", inflate="much")


def test_the_catalogue_is_here():
    assert "formula" in tumble.exports["openvins"]
    assert "rate" in tumble.exports["kalibr"].options
