"""Recordings: from files, arrays and data frames; views, cuts, pickles, bad input."""

from __future__ import annotations

import io
import pickle

import numpy as np
import pytest

import tumble

RATE = 50.0


def samples(count: int = 1000) -> np.ndarray:
    return np.random.default_rng(1).normal(size=count)


def test_a_file_is_read_with_units_and_times(imu_file):
    recording = tumble.read(imu_file)
    assert list(recording) == ["gyro.x", "gyro.y", "gyro.z", "temperature"]
    channel = recording["gyro.x"]
    assert (channel.unit, channel.shown_unit, channel.kind) == ("rad/s", "deg/s", "angular_rate")
    by_numpy = np.loadtxt(imu_file, delimiter=",", skiprows=1, usecols=0)
    assert len(channel) == len(by_numpy)
    np.testing.assert_array_equal(channel.times, by_numpy)


def test_values_share_the_memory_of_the_recording(imu_file):
    channel = tumble.read(imu_file)["gyro.x"]
    assert np.shares_memory(channel.values, channel.values)
    assert np.shares_memory(channel.values, np.asarray(channel))
    assert np.shares_memory(channel.times, channel.times)  # stamps
    with pytest.raises(ValueError, match="read-only"):
        channel.values[0] = 0.0


def test_a_view_outlives_its_recording(imu_file):
    values = tumble.read(imu_file)["gyro.x"].values
    expected = np.deg2rad(np.loadtxt(imu_file, delimiter=",", skiprows=1, usecols=1))
    np.testing.assert_allclose(values, expected, rtol=1e-15)  # one rounding of the factor, one of the product


def test_a_name_may_carry_the_unit_as_in_a_table():
    x = samples()
    given = tumble.from_arrays({"gyro.x[deg/h]": x}, rate=RATE)
    plain = tumble.from_arrays({"gyro.x": (x, "deg/h")}, rate=RATE)
    assert np.array_equal(given["gyro.x"].values, plain["gyro.x"].values)
    with pytest.raises(tumble.UsageError, match="unknown unit"):
        tumble.from_arrays({"gyro.x[furlongs]": x}, rate=RATE)


def test_arrays_become_a_recording_in_si():
    x = samples()
    recording = tumble.from_arrays({"gyro.x": (x, "deg/h"), "temperature": (x, "degC")}, rate="50 Hz", start=2.0)
    assert recording["gyro.x"].rate == RATE
    np.testing.assert_array_equal(recording["gyro.x"].times, 2.0 + np.arange(1000) / RATE)
    np.testing.assert_allclose(recording["gyro.x"].values, x * np.pi / 180 / 3600, rtol=4e-16)
    np.testing.assert_allclose(recording["temperature"].values, x + 273.15, rtol=2e-16)
    np.testing.assert_allclose(recording["gyro.x"].in_("deg/s"), x / 3600, rtol=6e-16)


@pytest.mark.parametrize(
    "given",
    [
        pytest.param(np.arange(20)[::2], id="not contiguous"),
        pytest.param(np.arange(10, dtype=np.int16), id="integers"),
        pytest.param(np.arange(10, dtype=np.float32), id="single precision"),
        pytest.param(np.arange(10, dtype=">f8"), id="other byte order"),
        pytest.param(list(range(10)), id="list"),
        pytest.param(np.asfortranarray(np.arange(20.0).reshape(10, 2))[:, 0] / 2, id="column"),
    ],
)
def test_other_arrays_are_converted(given):
    recording = tumble.from_arrays({"gyro.x": (given, "rad/s")}, rate=RATE)
    np.testing.assert_array_equal(recording["gyro.x"].values, np.asarray(given, dtype=float))


@pytest.mark.parametrize(
    ("values", "error", "says"),
    [
        ([1.0, np.nan, 3.0], tumble.DataError, "1 of 3 values are NaN, the first is sample 1.*missing='nan'"),
        ([1.0, np.inf], tumble.DataError, "1 of 2 values are infinite, the first is sample 1"),
        (np.zeros((10, 3)), tumble.UsageError, r"2 dimensions, shape \(10, 3\).*one-dimensional"),
        ([], tumble.DataError, "is empty"),
        (["1.0", "2.0"], tumble.ArgumentTypeError, "of type list was given; accepted is a one-dimensional array"),
        ("1.0", tumble.ArgumentTypeError, "'1.0' of type str"),
        (None, tumble.ArgumentTypeError, "None of type NoneType"),
        (np.array([1j]), tumble.ArgumentTypeError, "complex128"),
        (np.array([True]), tumble.ArgumentTypeError, "bool"),
        (np.array([object()]), tumble.ArgumentTypeError, "object"),
        ([[1.0], [1.0, 2.0]], tumble.ArgumentTypeError, "of type list"),
    ],
)
def test_bad_arrays_are_refused_by_name(values, error, says):
    with pytest.raises(error, match=r"channels\['gyro.x'\]: .*" + says):
        tumble.from_arrays({"gyro.x": (values, "deg/s")}, rate=RATE)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (({"gyro.x": samples()},), "the unit is absent; accepted are"),
        (({"gyro.x": (samples(), "deg/q")},), "'gyro.x': .*'q'"),
        (({1: (samples(), "deg")},), "names of channels as text"),
        ((samples(),), "accepted is a dict"),
        (({},), "accepted is a dict"),
    ],
)
def test_arrays_without_names_or_units_are_refused(arguments, says):
    with pytest.raises(tumble.UsageError, match=says):
        tumble.from_arrays(*arguments, rate=RATE)


def test_rate_or_time_is_wanted():
    channels = {"gyro.x": (samples(), "deg/s")}
    with pytest.raises(tumble.UsageError, match="rate and time: give one of them"):
        tumble.from_arrays(channels)
    with pytest.raises(tumble.UsageError, match="999 stamps were given for the 1000 samples of 'gyro.x'"):
        tumble.from_arrays(channels, time=np.arange(999))
    with pytest.raises(tumble.UsageError, match="rate: -1 was given"):
        tumble.from_arrays(channels, rate=-1)
    with pytest.raises(tumble.ArgumentTypeError, match="argument rate"):
        tumble.from_arrays(channels, rate=[1])


def test_nan_may_mean_a_missing_sample():
    recording = tumble.from_arrays({"gyro.x": ([1.0, np.nan, 3.0], "deg/s")}, rate=RATE, missing="nan")
    assert recording["gyro.x"].missing == 1
    masked = np.ma.masked_equal([1.0, -999.0, 3.0], -999.0)
    assert tumble.from_arrays({"x": (masked, "deg/s")}, rate=RATE, missing="nan")["x"].missing == 1


def test_a_recording_is_cut_by_seconds():
    recording = tumble.from_arrays(
        {"gyro.x": (samples(), "deg/s")}, rate=RATE, marks=[("a", 0.0), ("b", 4.0), ("c", 12.0, 2)]
    )
    part = recording[5.0:13.0]
    assert len(part["gyro.x"]) == 8 * RATE
    assert part["gyro.x"].start == 5.0
    assert [(mark.label, mark.begin, mark.run) for mark in part.marks] == [("b", 5.0, 1), ("c", 12.0, 2)]
    np.testing.assert_array_equal(part["gyro.x"].values, recording["gyro.x"].values[250:650])
    with pytest.raises(tumble.DataError, match="no sample from 90 s"):
        recording[90.0:]


def test_recordings_are_pickled(imu_file, tmp_path):
    made = tumble.from_arrays({"gyro.x": (samples(), "deg/s")}, rate=RATE, marks=[("a", 1.0)])
    copy = pickle.loads(pickle.dumps(made))
    np.testing.assert_array_equal(copy["gyro.x"].values, made["gyro.x"].values)
    assert (copy.marks, copy.sha256, copy["gyro.x"].rate) == (made.marks, made.sha256, RATE)
    file = tmp_path / "x.csv"
    made.save(file)
    pickled = pickle.dumps(tumble.read(file))
    assert len(pickled) < 1000  # the name of the file, not the samples
    assert pickle.loads(pickled)["gyro.x"].rate == RATE
    file.write_text("time[s],gyro.x[deg/s]\n0,1\n1,2\n")
    with pytest.raises(tumble.DataError, match="has changed since"):
        pickle.loads(pickled)


def test_an_open_file_is_read(imu_file):
    with open(imu_file, "rb") as file:
        content = file.read()
    recording = tumble.read(io.BytesIO(content), format="csv")
    np.testing.assert_array_equal(recording["gyro.x"].values, tumble.read(imu_file)["gyro.x"].values)


def test_a_bad_file_is_refused_with_file_and_line(tmp_path):
    bad = tmp_path / "bad.csv"
    bad.write_text("time[s],gyro.x[deg/s]\n0,1\n1,oops\n")
    with pytest.raises(tumble.FileError, match="oops") as refused:
        tumble.read(bad)
    assert refused.value.file is not None and refused.value.file.endswith("bad.csv")
    assert refused.value.line == 3
    assert refused.value.status == 3
    with pytest.raises(tumble.FileError, match="nowhere.csv"):
        tumble.read("nowhere.csv")
    with pytest.raises(tumble.ArgumentTypeError, match="argument path: 3 of type int"):
        tumble.read(3)
    with pytest.raises(tumble.UsageError, match="no format 'cvs'; did you mean 'csv'"):
        tumble.read(bad, format="cvs")


def test_what_a_file_does_not_say_is_given(tmp_path):
    plain = tmp_path / "plain.csv"
    plain.write_text("gyro.x,note\n1,NA\n2,4\n")
    recording = tumble.read(plain, rate=RATE, units={"gyro.x": "deg/s", "note": "1"}, missing="NA")
    assert recording["note"].missing == 1
    assert recording["gyro.x"].rate == RATE
    assert list(tumble.read(plain, rate=RATE, units={"gyro.x": "deg/s"}, channels=["gyro.x"])) == ["gyro.x"]


def test_a_table_that_is_unclear_is_read_as_told(tmp_path):
    table = tmp_path / "table.csv"
    rows = "".join(f"03/04/2026 12:00:{second:02d},{second},{second * second}\n" for second in range(20))
    table.write_bytes("Ger\xe4t 7\nclock,counter,rate[deg/s]\n".encode("latin-1") + rows.encode())
    given = {"time": "clock", "encoding": "windows-1252", "skip": 1, "units": {"counter": "1"}}
    first = tumble.read(table, date="dmy", **given)
    np.testing.assert_array_equal(first["rate"].times, np.arange(20.0))
    np.testing.assert_allclose(first["rate"].in_("deg/s"), np.arange(20.0) ** 2, rtol=1e-15)
    starts = [tumble.read(table, date=order, **given).meta["clock_start"] for order in ("dmy", "mdy")]
    assert [start[5:7] for start in starts] == ["04", "03"]
    with pytest.raises(tumble.UsageError, match="date"):
        tumble.read(table, date="ddm", **given)
    with pytest.raises(tumble.UsageError, match="skip"):
        tumble.read(table, skip=-1)


def test_raw_bytes_are_read_by_the_frames_of_their_instrument(tmp_path):
    # One frame of format A as the manual prints it: without the number of a second frame a rate has to be given.
    frame = bytes.fromhex("FE81FF5537A96A6E38586C1FB75BF862BF803E78BB650D283B0A37AC773D00284BFA34D8")
    stream = tmp_path / "stream.bin"
    stream.write_bytes(frame)
    recording = tumble.read(stream, frames="kvh_1775:gyro_rate", rate=1000)
    np.testing.assert_allclose(recording["gyro.x"].values, [2.019593e-5], rtol=1e-6)
    np.testing.assert_allclose(recording["acc.x"].in_("g"), [-1.0019064], rtol=1e-6)
    with pytest.raises(tumble.UsageError, match="kvh_1775"):
        tumble.read(stream, frames="kvh_1757", rate=1000)


def test_the_checks_are_run_on_request():
    x = samples()
    x[500] = 1e6
    recording = tumble.from_arrays({"gyro.x": (x, "deg/s")}, rate=RATE)
    assert "outlier" in {finding.code for finding in recording.check()}
    assert recording.findings == ()
