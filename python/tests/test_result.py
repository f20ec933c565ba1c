"""Plans, results, tasks: what the values say, and what is refused."""

from __future__ import annotations

import json
import os
import pickle
import signal
import threading
import time
import warnings

import numpy as np
import pytest
from tumble._result_parts import Budget

import tumble


@pytest.fixture(scope="module")
def result(tree):
    plan = tree / "plans/sdof_gyro_static.toml"
    return tumble.identify(plan, tumble.simulate(plan, seed=3))


def test_parameters_say_value_sd_interval_and_unit(result):
    document = json.loads(result.to_json())
    for one in document["parameters"]:
        parameter = result.parameters[one["name"]]
        assert [parameter.value, parameter.sd, parameter.unit] == [one["value"], one["sd"], one["unit"]]
        assert list(parameter.interval) == one["interval95"]
        assert parameter.interval[0] <= parameter.value <= parameter.interval[1]
    with pytest.raises(KeyError, match="no parameter 'nothing'; there are"):
        result.parameters["nothing"]


def test_parameters_are_given_in_other_units(result):
    name = next(name for name, one in result.parameters.items() if one.unit == "deg/h/g")
    parameter = result.parameters[name]
    other = parameter.in_("deg/h/mg")
    assert other.value == pytest.approx(parameter.value / 1000, rel=1e-14)
    assert other.sd == pytest.approx(parameter.sd / 1000, rel=1e-14)
    assert other.interval == pytest.approx([end / 1000 for end in parameter.interval], rel=1e-13)
    assert parameter.in_(parameter.unit) is parameter
    assert parameter.si.unit == "s/m*rad" or parameter.si.value == pytest.approx(
        parameter.value * np.pi / 180 / 3600 / 9.80665, rel=1e-14
    )
    with pytest.raises(tumble.UsageError, match=r"argument unit: 'm' has the dimension \[m\]"):
        parameter.in_("m")


def test_a_temperature_keeps_its_zero():
    parameter = tumble.Parameter("T", "T", 20.0, 0.1, "degC", (19.8, 20.2), 10.0, "")
    kelvin = parameter.in_("K")
    assert kelvin.value == pytest.approx(293.15)
    assert kelvin.sd == pytest.approx(0.1)


def test_budget_sums_to_the_covariance(result):
    total = sum(line.factor @ line.factor.T for line in result.budget.values())
    np.testing.assert_allclose(total, result.covariance.values, rtol=1e-9, atol=1e-9 * np.abs(total).max())
    for name, parameter in result.parameters.items():
        variance = sum(line[name] ** 2 for line in result.budget.values())
        assert variance == pytest.approx(parameter.sd**2, rel=1e-9)
        assert result.covariance[name, name] == pytest.approx(parameter.sd**2, rel=1e-9)


def test_lines_of_one_source_are_kept_apart():
    given = (("gravity", "site A", 3.0), ("noise", None, 1.0), ("gravity", "site B", 4.0))
    lines = [{"source": source, "key": key, "sd": [sd], "factor": [[sd]]} for source, key, sd in given]
    budget = Budget(("bias",), lines)
    assert list(budget) == ["gravity", "noise", "gravity (2)"]
    assert sum(line["bias"] ** 2 for line in budget.values()) == 26.0


def test_a_result_is_pickled_saved_and_loaded(result, tmp_path):
    assert pickle.loads(pickle.dumps(result)).to_json() == result.to_json()
    result.save(tmp_path / "r.json")
    assert tumble.load_result(tmp_path / "r.json").to_json() == result.to_json()
    with pytest.raises(tumble.UsageError, match=r"must end in .json or .html"):
        result.save(tmp_path / "r.txt")
    with pytest.raises(tumble.FileError, match=r"nowhere.json"):
        tumble.load_result(tmp_path / "nowhere.json")
    (tmp_path / "bad.json").write_text('{"parameters": 3}')
    with pytest.raises(tumble.FileError, match=r"bad.json"):
        tumble.load_result(tmp_path / "bad.json")


def test_what_is_written_through_a_link_or_to_a_pipe_leaves_both(result, tmp_path):
    link, file, pipe = tmp_path / "link.json", tmp_path / "file.json", tmp_path / "pipe.json"
    link.symlink_to(file)
    result.save(link)
    assert link.is_symlink()
    assert file.read_text() == result.to_json()
    os.mkfifo(pipe)
    received: list[str] = []
    reader = threading.Thread(target=lambda: received.append(pipe.read_text()))
    reader.start()
    result.save(pipe)
    reader.join(timeout=20)
    assert received == [result.to_json()]
    assert pipe.is_fifo()
    with pytest.raises(tumble.FileError, match=r"nowhere/r.json"):
        result.save(tmp_path / "nowhere" / "r.json")


def test_a_result_says_when_its_recordings_were_made(tmp_path):
    values = np.random.default_rng(2).normal(size=400)
    table = tmp_path / "dated.csv"
    for begin, zone in (("2026-11-20T23:59:58", "Z"), ("2026-11-20T23:59:58", "")):
        start = np.datetime64(begin)
        stamps = [str(start + np.timedelta64(10 * k, "ms")) + zone for k in range(values.size)]
        rows = "".join(f"{stamp},{value}\n" for stamp, value in zip(stamps, values, strict=True))
        table.write_text("time,gyro.x[deg/h]\n" + rows)
        files = tumble.identify("allan_noise", str(table))
        files.save(tmp_path / "r.json")
        saved = tumble.load_result(tmp_path / "r.json")
        for result in (files, tumble.identify("allan_noise", tumble.read(table)), saved):
            recordings = result.tables["recordings"]
            assert [column.name for column in recordings.columns] == ["recording", "begun", "ended"]
            # 400 samples, 10 ms apart, to the second
            assert recordings.rows == ((str(table), begin + zone, "2026-11-21T00:00:01" + zone),)
    undated = tumble.from_arrays({"gyro.x": (values, "deg/h")}, rate=100)
    assert "recordings" not in tumble.identify("allan_noise", undated).tables


def test_a_notebook_shows_tables(result, imu_file):
    assert all(name in result._repr_html_() for name in result.parameters)
    assert "gyro.x" in tumble.read(imu_file)._repr_html_()


def test_a_plan_is_changed_by_making_another(tree):
    plan = tumble.load_plan(tree / "plans/fog_thermal_bias.toml")
    changed = plan.with_({"truth.angle_random_walk": "1 deg/sqrt(h)"}, startup_time="6 min")
    assert changed.settings["startup_time"] == "360 s"
    assert changed.truth["angle_random_walk"] == "1 deg/sqrt(h)"
    assert plan.settings["startup_time"] == "300 s"
    assert pickle.loads(pickle.dumps(changed)).settings == changed.settings
    with pytest.raises(tumble.UsageError, match="statup_time.*did you mean 'startup_time'"):
        plan.with_(statup_time="5 min")
    with pytest.raises(tumble.UsageError, match="startup_time"):
        plan.with_(startup_time=5.0)  # a number without its unit
    with pytest.raises(tumble.ArgumentTypeError, match=r"settings\['startup_time'\]"):
        plan.with_(startup_time=object())


def test_a_wrong_plan_is_refused_with_all_lines(tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text('method = "allan_noise"\n[settings]\nconfidense = "0.9"\nsignificance = 7\n')
    with pytest.raises(tumble.UsageError) as refused:
        tumble.load_plan(plan)
    assert len(refused.value.problems) == 2
    assert (refused.value.file, refused.value.line, refused.value.status) == (str(plan), 3, 2)
    copy = pickle.loads(pickle.dumps(refused.value))
    assert (type(copy), copy.problems, copy.line) == (tumble.UsageError, refused.value.problems, 3)
    first = refused.value.errors[0]
    assert (first["code"], first["message"]) == ("bad_input", refused.value.problems[0])
    assert first["pattern"] == "unknown key '{}'{}"
    assert first["values"][0] == {"name": "confidense"}
    assert (first["where"]["file"], first["where"]["line"]) == (str(plan), 3)
    assert copy.errors == refused.value.errors


def test_limits_that_fail_are_an_error_on_request(tree):
    plan = tumble.load_plan(tree / "plans/fog_thermal_bias.toml").with_({"truth.angle_random_walk": "1 deg/sqrt(h)"})
    recording = tumble.simulate(plan, seed=1)
    result = tumble.identify(plan, recording)
    assert [verdict.outcome for verdict in result.verdicts] == ["fail"]
    with pytest.raises(tumble.LimitError, match=r"bias_sd_held_out: fail \(<= 0.02 deg/h\)") as failed:
        result.require_limits()
    assert failed.value.status == 1


def test_warnings_are_warned(imu_file):
    with pytest.warns(tumble.TumbleWarning, match="periodic disturbance") as caught:
        result = tumble.identify("allan_noise", imu_file)
    assert caught[0].filename == __file__
    assert len(caught) == sum(finding.severity != "info" for finding in result.findings)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ((np.zeros(10),), "samples alone have no unit and no rate"),
        (([1, 2],), "samples alone have no unit and no rate"),
        ((None,), "accepted are recordings"),
    ],
)
def test_what_is_no_recording_is_refused(given, says):
    with pytest.raises(tumble.ArgumentTypeError, match=says):
        tumble.identify("allan_noise", *given)


def test_bad_requests_are_refused(imu_file):
    with pytest.raises(tumble.UsageError, match="did you mean 'allan_noise'"):
        tumble.identify("alan_noise", imu_file)
    with pytest.raises(tumble.ArgumentTypeError, match="argument plan: 3 of type int"):
        tumble.identify(3, imu_file)
    with pytest.raises(tumble.UsageError, match="name one or more"):
        tumble.identify("allan_noise")
    with pytest.raises(tumble.ArgumentTypeError, match="argument seed: -1"):
        tumble.simulate("plan.toml", seed=-1)
    with pytest.raises(tumble.ArgumentTypeError, match="argument progress"):
        tumble.identify("allan_noise", imu_file, progress=3)
    recording = tumble.from_arrays({"gyro.x": (np.arange(10.0), "m")}, rate=1)
    with pytest.raises(tumble.DataError, match="arrays"):
        tumble.identify("allan_noise", recording)


def test_the_lock_of_the_interpreter_is_released():
    """A Python thread goes on counting while the library works."""
    x = np.random.default_rng(1).normal(size=2_000_000)
    done = threading.Event()
    counted = [0]

    def count() -> None:
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.perf_counter()
    tumble.allan_deviation(x, 100.0, taus="all")
    took = time.perf_counter() - begin
    done.set()
    thread.join()
    assert took > 0.05
    assert counted[0] > 10  # with the lock held it would be 0 or 1


def test_progress_is_told_and_an_exception_in_it_stops_the_work(tree):
    plan = tumble.load_plan(tree / "plans/fog_thermal_bias.toml")
    heard = []
    tumble.simulate(plan, progress=lambda done, what: heard.append((done, what)))
    assert heard
    assert all(0.0 <= done <= 1.0 and what for done, what in heard)

    def refuse(done: float, what: str) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        tumble.simulate(plan, progress=refuse)


@pytest.mark.usefixtures("keyboard")
def test_ctrl_c_stops_the_work(tree):
    plan = tumble.load_plan(tree / "plans/fog_thermal_bias.toml")
    threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            tumble.simulate(plan)


def test_catalogues_have_names_and_options():
    assert "allan_noise" in tumble.methods
    assert tumble.methods["allan_noise"].options["taus"]["default"] == "log"
    with pytest.raises(KeyError, match=r"no method 'alan'; there are accelerometer"):
        tumble.methods["alan"]


def test_results_of_files_and_recordings_share_all_but_provenance(imu_file):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tumble.TumbleWarning)
        by_file = tumble.identify("allan_noise", imu_file)
        by_recording = tumble.identify("allan_noise", tumble.read(imu_file))
    assert by_file.to_json() == by_recording.to_json()
