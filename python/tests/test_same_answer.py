"""One job of every method by the command line and by Python: the same result file, byte for byte."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import pytest

import tumble

# Methods whose plan has another name, or that need none.
PLANS = {"static_bias": None, "allan_noise": None, "imu_channel_calibration": None}


def arguments_of(method: str, tree: Path, folder: Path) -> tuple[str, list[str], dict[str, str]]:
    """Plan or method, recordings, settings of a job of this method."""
    if method == "imu_channel_calibration":
        return channels_of_an_imu(tree, folder)
    if method in PLANS:
        settings = {"channels.signal": "gyro.x"} if method == "static_bias" else {}
        return method, [str(tree / "examples/data/mpu6050_static.csv")], settings
    plan = str(tree / f"plans/{method}.toml")
    data = str(folder / "data.h5")
    tumble.simulate(plan, seed=1).save(data)
    return plan, [data], {}


def channels_of_an_imu(tree: Path, folder: Path) -> tuple[str, list[str], dict[str, str]]:
    """The plan names its recordings: that of each channel, and the unit as a whole."""
    for plan in sorted((tree / "plans").glob("imu_channel_*.toml")):
        (folder / plan.name).write_text(plan.read_text())
    plan = folder / "imu_channel_calibration.toml"
    for file in tumble.load_plan(plan).recordings:
        source = folder / f"imu_channel_{Path(file).stem}.toml"
        tumble.simulate(source if source.exists() else plan, seed=1).save(file)
    return str(plan), [], {}


def without_provenance(text: str) -> str:
    document = json.loads(text)
    del document["provenance"]
    return json.dumps(document)


@pytest.mark.parametrize("method", list(tumble.methods))
def test_command_and_python_write_the_same_result(method, tree, tmp_path, command):
    plan, files, settings = arguments_of(method, tree, tmp_path)
    sets = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    command("identify", plan, *files, *sets, "-o", tmp_path / "command.json", "--quiet")
    by_command = (tmp_path / "command.json").read_text()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tumble.TumbleWarning)
        by_python = tumble.identify(plan, *files, settings=settings)
        by_recordings = tumble.identify(plan, *map(tumble.read, files), settings=settings)
    by_python.save(tmp_path / "python.json")
    assert (tmp_path / "python.json").read_bytes() == (tmp_path / "command.json").read_bytes()
    assert without_provenance(by_recordings.to_json()) == without_provenance(by_command)


def test_command_and_python_simulate_the_same_file(tree, tmp_path, command):
    plan = tree / "plans/sdof_gyro_static.toml"
    command("simulate", plan, "--seed", 5, "-o", tmp_path / "command.h5")
    tumble.simulate(plan, seed=5).save(tmp_path / "python.h5")
    assert (tmp_path / "python.h5").read_bytes() == (tmp_path / "command.h5").read_bytes()


def test_command_and_python_compensate_the_same_file(tree, tmp_path, command):
    plan = tree / "plans/fog_thermal_bias.toml"
    data, result = tmp_path / "data.h5", tmp_path / "result.json"
    tumble.simulate(plan, seed=2).save(data)
    tumble.identify(plan, data).save(result)
    command("compensate", result, data, "-o", tmp_path / "command.h5")
    tumble.compensate(result, data).save(tmp_path / "python.h5")
    assert (tmp_path / "python.h5").read_bytes() == (tmp_path / "command.h5").read_bytes()


@pytest.mark.parametrize("kind", ["methods", "models", "rigs", "formats", "checks", "plans", "units"])
def test_command_and_python_list_the_same_entries(kind, command):
    entries = [dict(entry) for entry in getattr(tumble, kind).values()]
    assert entries == json.loads(command("list", kind, "--json"))


def test_command_and_python_predict_and_report_the_same(tree, tmp_path, command):
    plan = tree / "plans/sdof_gyro_static.toml"
    prediction = tumble.predict(plan)
    assert prediction.to_json() == command("predict", plan, "--json")
    prediction.save(tmp_path / "result.json")
    command("report", tmp_path / "result.json", "-o", tmp_path / "command.html")
    tumble.report(tmp_path / "result.json", tmp_path / "python.html")
    assert (tmp_path / "python.html").read_bytes() == (tmp_path / "command.html").read_bytes()


def test_command_and_python_validate_the_same(tree, command):
    plan = tree / "plans/accelerometer_tumble.toml"
    validation = tumble.validate(plan, trials=10, departure="clock_fast", size="300 ppm")
    words = ("validate", plan, "--trials", 10, "--departure", "clock_fast", "--size", "300 ppm", "--json")
    assert validation.to_json() == command(*words)


def test_command_and_python_simulate_the_same_departure(tree, tmp_path, command):
    plan = tree / "plans/accelerometer_tumble.toml"
    command("simulate", plan, "--seed", 5, "--departure", "clock_fast=300 ppm", "-o", tmp_path / "command.h5")
    tumble.simulate(plan, seed=5, departures=["clock_fast=300 ppm"]).save(tmp_path / "python.h5")
    assert (tmp_path / "python.h5").read_bytes() == (tmp_path / "command.h5").read_bytes()
