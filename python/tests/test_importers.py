"""Importers: files written by the reference packages are read back; what they lack is asked for."""

from __future__ import annotations

import io
import os
import pickle
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tumble.importers import importers

import tumble

RATE = 200.0


def samples(seed: int = 1, count: int = 500) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=count)


def in_unit(recording: tumble.Recording, name: str, unit: str) -> np.ndarray:
    return recording[name].in_(unit)


def test_parquet_is_read_with_units_of_fields_and_names(tmp_path):
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    x, y = samples(1), samples(2)
    schema = arrow.schema(
        [
            arrow.field("time[s]", arrow.float64()),
            arrow.field("gyro.x", arrow.float64(), metadata={"unit": "deg/s"}),
            arrow.field("temperature[degC]", arrow.float32()),
            arrow.field("note", arrow.string()),
        ]
    )
    arrays = [np.arange(500) / RATE, x, y.astype(np.float32), ["a"] * 500]
    parquet.write_table(
        arrow.table(dict(zip(schema.names, arrays, strict=True)), schema=schema), tmp_path / "a.parquet"
    )
    recording = tumble.read(tmp_path / "a.parquet")
    np.testing.assert_allclose(in_unit(recording, "gyro.x", "deg/s"), x, rtol=4e-16)
    np.testing.assert_array_equal(recording["gyro.x"].times, np.arange(500) / RATE)
    assert recording["temperature"].shown_unit == "degC"
    assert recording.meta["skipped"] == "note"
    assert recording.file.endswith("a.parquet")
    assert len(recording.sha256) == 64


def test_xlsx_is_read_with_blank_cells_as_missing(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["time[ms]", "gyro.x[deg/h]", "comment"])
    for k in range(20):
        book.active.append([5 * k, None if k == 7 else 0.1 * k, "ok"])
    book.save(tmp_path / "a.xlsx")
    recording = tumble.read(tmp_path / "a.xlsx")
    assert recording["gyro.x"].missing == 1
    np.testing.assert_allclose(recording["gyro.x"].times, np.arange(20) / RATE, rtol=1e-15)
    assert recording.meta["skipped"] == "comment"


def test_tdms_is_read_with_the_units_and_the_clock_of_its_waveforms(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    x = samples()
    properties = {"unit_string": "deg/s", "wf_increment": 1 / RATE, "wf_start_offset": 0.0}
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("table", "gyro.x", x, properties),
                nptdms.ChannelObject("table", "volts", x, {"wf_increment": 1 / RATE}),
            ]
        )
    with pytest.raises(tumble.UsageError, match=r"columns volts have no unit; accepted are units=\{'volts'"):
        tumble.read(tmp_path / "a.tdms")
    recording = tumble.read(tmp_path / "a.tdms", channels=["gyro.x"])
    np.testing.assert_allclose(in_unit(recording, "gyro.x", "deg/s"), x, rtol=4e-16)
    assert recording["gyro.x"].rate == pytest.approx(RATE)
    assert "volts" in recording.meta["skipped"]
    both = tumble.read(tmp_path / "a.tdms", units={"volts": "mV"})
    assert both["volts"].shown_unit == "mV"


def test_tdms_waveforms_keep_the_time_between_them(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    noon = np.datetime64("2026-03-01T12:00:00.000000")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        for name, date in [("late", noon + np.timedelta64(500, "ms")), ("early", noon)]:
            properties = {"unit_string": "V", "wf_increment": 1 / RATE, "wf_start_time": date}
            writer.write_segment([nptdms.ChannelObject(name, "x", samples(), properties)])
    recording = tumble.read(tmp_path / "a.tdms")
    assert [recording[name].times[0] for name in ("early.x", "late.x")] == [0.0, 0.5]


@pytest.mark.parametrize("dates", [True, False])
def test_tdms_without_waveforms_takes_the_times_of_a_channel(tmp_path, dates):
    nptdms = pytest.importorskip("nptdms")
    x, times = samples(), np.arange(len(samples())) / RATE
    stamps = np.datetime64("2026-03-01T12:00:00.000000") + np.round(1e6 * times).astype("timedelta64[us]")
    clock = ("Stamp", stamps, {}) if dates else ("Time", 1e3 * times, {"unit_string": "ms"})
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("log", *clock),
                nptdms.ChannelObject("log", "gyro.x", x, {"unit_string": "deg/s"}),
                nptdms.ChannelObject("log", "note", ["a"] * len(x)),
            ]
        )
    recording = tumble.read(tmp_path / "a.tdms")
    assert list(recording) == ["gyro.x"]
    np.testing.assert_allclose(recording["gyro.x"].times, times, atol=2e-9)
    assert "note" in recording.meta["skipped"]


def test_tdms_groups_with_dates_count_from_the_first_date_of_the_file(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    x = samples()
    noon = np.datetime64("2026-03-01T12:00:00.000000")
    stamps = noon + np.arange(len(x)) * np.timedelta64(10, "ms")
    volts = {"unit_string": "V"}
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("one", "Stamp", stamps + np.timedelta64(3, "s")),
                nptdms.ChannelObject("one", "a", x, volts),
                nptdms.ChannelObject("two", "Stamp", stamps + np.timedelta64(5, "s")),
                nptdms.ChannelObject("two", "b", x, volts),
                nptdms.ChannelObject("three", "c[mV]", x, {"wf_increment": 1 / RATE, "wf_start_time": noon}),
            ]
        )
    recording = tumble.read(tmp_path / "a.tdms")
    assert {name: recording[name].times[0] for name in recording} == {"a": 3.0, "b": 5.0, "c": 0.0}
    assert recording["c"].shown_unit == "mV"


@pytest.mark.parametrize(
    ("properties", "length", "said"),
    [
        ({"unit_string": "V"}, 20, "column \"/'log'/'a'\" has 20 values, and its times are {n}; "),
        ({"unit_string": "V"}, 2000, "column \"/'log'/'a'\" has 2000 values, and its times are {n}; "),
        ({"unit_string": "V", "wf_increment": 0.01, "wf_start_offset": "late"}, 20, "wf_start_offset is 'late'; "),
        ({"unit_string": "V", "wf_increment": 0.01, "wf_start_offset": float("nan")}, 20, "wf_start_offset is nan; "),
        ({"unit_string": 3, "wf_increment": 0.01}, 20, "'a': unit '3'"),
        ({"unit_string": "  ", "wf_increment": 0.01}, 20, "columns a have no unit; "),
    ],
)
def test_tdms_channels_that_cannot_be_read_are_named(tmp_path, properties, length, said):
    nptdms = pytest.importorskip("nptdms")
    times = np.arange(len(samples())) / RATE
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("log", "Time", times, {"unit_string": "s"}),
                nptdms.ChannelObject("log", "a", np.ones(length), properties),
            ]
        )
    with pytest.raises(tumble.TumbleError) as caught:
        tumble.read(tmp_path / "a.tdms")
    assert "a.tdms: " in str(caught.value)
    assert said.format(n=len(times)) in str(caught.value)


@pytest.mark.parametrize("step", [0, 0.0, -0.01, "0.01", float("nan"), float("inf"), 1e-320, True])
def test_tdms_steps_that_are_none_are_no_waveform(tmp_path, step):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment([nptdms.ChannelObject("g", "a", samples(), {"unit_string": "V", "wf_increment": step})])
    with pytest.raises(tumble.UsageError, match=r"a\.tdms: column \"/'g'/'a'\" has no times; accepted is rate="):
        tumble.read(tmp_path / "a.tdms")
    assert tumble.read(tmp_path / "a.tdms", rate=RATE)["a"].rate == RATE


def test_a_tdms_file_that_was_cut_off_is_told(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "a.tdms"
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.ChannelObject("g", "a", samples(), {"unit_string": "V", "wf_increment": 0.01})])
    path.write_bytes(path.read_bytes()[:-80])
    with pytest.warns(
        tumble.TumbleWarning, match=r"a\.tdms: the file ends within its last segment: /'g'/'a' has"
    ) as told:
        recording = tumble.read(path)
    assert [one.filename for one in told] == [__file__]
    np.testing.assert_array_equal(recording["a"].values, samples()[:-10])


@pytest.mark.parametrize("version", [1, 2])
def test_bags_are_read_with_the_stamps_of_their_headers(tmp_path, version):
    pytest.importorskip("rosbags")
    recording = tumble.read(write_bag(tmp_path, version), format="rosbags")
    assert set(recording) == {f"{kind}.{axis}" for kind in ("accelerometer", "gyro") for axis in "xyz"}
    np.testing.assert_array_equal(recording["gyro.x"].values, samples(1, 50))
    np.testing.assert_allclose(recording["gyro.x"].times, np.arange(50) / RATE, atol=1e-6)  # of seconds since 1970
    assert recording["accelerometer.z"].shown_unit == "m/s^2"
    assert "orientation.x" in recording.meta["skipped"]


@pytest.mark.parametrize("version", [1, 2])
def test_bags_of_an_imu_are_read_by_the_library_itself(tmp_path, version):
    pytest.importorskip("rosbags")
    path = write_bag(tmp_path, version)
    recording = tumble.read(path)
    np.testing.assert_array_equal(recording["gyro.x"].values, samples(1, 50))
    np.testing.assert_array_equal(recording["gyro.x"].times, np.arange(50) / RATE)
    assert recording.meta["topic /imu/data"] == "sensor_msgs/Imu"
    again = tumble.read(path, topics="/imu/data")
    np.testing.assert_array_equal(again["accelerometer.z"].values, recording["accelerometer.z"].values)
    with pytest.raises(tumble.FileError, match="did you mean '/imu/data'"):
        tumble.read(path, topics=["/imu/dta"])


def write_bag(folder: Path, version: int) -> Path:
    """A bag of 50 messages of an IMU; of ROS 2 its data file."""
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    path = folder / "a.bag" if version == 1 else folder / "a"
    writer = rosbag1.Writer(path) if version == 1 else rosbag2.Writer(path, version=8)
    with writer:
        connection = writer.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for k, x in enumerate(samples(1, 50)):
            nanoseconds = 1_700_000_000_000_000_000 + k * 5_000_000
            message = imu_message(store.types, nanoseconds, float(x), version)
            serialize = store.serialize_ros1 if version == 1 else store.serialize_cdr
            writer.write(connection, nanoseconds, bytes(serialize(message, "sensor_msgs/msg/Imu")))
    return path if version == 1 else next(path.glob("*.db3"))


def imu_message(types, nanoseconds: int, rate: float, version: int):
    header, time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    stamp = time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    unknown = np.zeros(9)
    return types["sensor_msgs/msg/Imu"](
        header(seq=0, stamp=stamp, frame_id="imu") if version == 1 else header(stamp=stamp, frame_id="imu"),
        quaternion(0.0, 0.0, 0.0, 1.0),
        unknown,
        vector(rate, 0.0, 0.0),
        unknown,
        vector(0.0, 0.0, 9.8),
        unknown,
    )


def test_the_command_of_python_converts(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["gyro.x"])
    for k in range(20):
        book.active.append([0.1 * k])
    book.save(tmp_path / "a.xlsx")
    convert = [sys.executable, "-m", "tumble", "convert", str(tmp_path / "a.xlsx"), "-o", str(tmp_path / "a.h5")]
    failed = subprocess.run(convert, capture_output=True, text=True, check=False)
    assert failed.returncode == 2
    assert "gyro.x have no unit" in failed.stderr
    sets = ["--set", "unit.gyro.x=deg/h", "--set", "rate=50"]
    done = subprocess.run([*convert, *sets], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    np.testing.assert_allclose(tumble.read(tmp_path / "a.h5")["gyro.x"].in_(), 0.1 * np.arange(20), rtol=4e-16)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_a_list_that_cannot_be_written_is_an_error():
    with open("/dev/full", "w") as full:
        listed = subprocess.run(
            [sys.executable, "-m", "tumble", "importers"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (listed.returncode, listed.stderr) == (3, "error: standard output: No space left on device\n")


def test_a_list_whose_reader_has_enough_ends_quietly():
    reading, writing = os.pipe()
    os.close(reading)
    listed = subprocess.run(
        [sys.executable, "-m", "tumble", "importers"], stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    assert (listed.returncode, listed.stderr) == (128 + signal.SIGPIPE, "")


def test_a_recording_is_unpickled_in_another_folder(tmp_path, monkeypatch):
    tumble.from_arrays({"gyro.x[deg/s]": samples()}, rate=RATE).save(tmp_path / "a.csv")
    monkeypatch.chdir(tmp_path)
    kept = pickle.dumps(tumble.read("a.csv"))
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    np.testing.assert_array_equal(pickle.loads(kept)["gyro.x"].values, tumble.read("../a.csv")["gyro.x"].values)


def test_every_importer_names_itself():
    names = [one.name for one in importers()]
    assert names == sorted(set(names), key=names.index)
    assert all(one.suffixes and one.summary for one in importers())


@pytest.mark.parametrize("name", ["a.parquet", "a.feather", "a.xlsx", "a.bag", "a.mcap", "a.db3"])
def test_broken_files_are_file_errors_that_name_them(tmp_path, name):
    for package in ("pyarrow", "openpyxl", "rosbags"):
        pytest.importorskip(package)
    (tmp_path / name).write_bytes(b"PK and nothing more")
    with pytest.raises(tumble.FileError, match=name):
        tumble.read(tmp_path / name)


def test_tables_with_dates_that_are_absent_and_durations(tmp_path):
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    steps = np.arange(10) * np.timedelta64(10, "ms")
    parquet.write_table(pa.table({"t": steps, "g[1]": np.arange(10.0)}), tmp_path / "a.parquet")
    assert tumble.read(tmp_path / "a.parquet")["g"].rate == pytest.approx(100.0)
    dates = pa.array([None, *(np.datetime64("2024-01-01", "ms") + steps[1:])], pa.timestamp("ms"))
    parquet.write_table(pa.table({"t": dates, "g[1]": np.arange(10.0)}), tmp_path / "b.parquet")
    with pytest.raises(tumble.DataError, match="the date of row 0 is absent"):
        tumble.read(tmp_path / "b.parquet")


def test_two_columns_of_one_name_are_refused(tmp_path):
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    parquet.write_table(pa.table({"g[1]": np.arange(10.0), "g[deg/s]": np.arange(10.0)}), tmp_path / "a.parquet")
    with pytest.raises(tumble.DataError, match="several columns are called g"):
        tumble.read(tmp_path / "a.parquet", rate=1)


def test_blank_rows_at_the_end_of_a_sheet(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in [["time[s]", "g[1]"], *([k / 10, 1.0] for k in range(5))]:
        book.active.append(row)
    book.active["A9"] = 0.0
    book.active["A9"] = None
    book.save(tmp_path / "a.xlsx")
    assert len(tumble.read(tmp_path / "a.xlsx")["g"]) == 5


def test_a_broken_importer_of_another_package_warns(tmp_path, monkeypatch):
    folder = tmp_path / "broken-1.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1\n")
    (folder / "entry_points.txt").write_text("[tumble.importers]\nabsent = no_such_module:importer\nwrong = math:pi\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.warns(tumble.TumbleWarning) as caught:
        names = [one.name for one in importers()]
    assert "parquet" in names
    assert len(caught) == 2


@pytest.mark.parametrize("name", [3, "", ".", "..", "a\0.csv", None])
def test_open_files_may_have_odd_names(imu_file, name):
    class Open(io.BytesIO):
        pass

    file = Open(Path(imu_file).read_bytes())
    file.name = name
    assert len(tumble.read(file)) == 4


def test_open_files_that_cannot_be_read(tmp_path):
    closed = io.BytesIO(b"")
    closed.close()
    with pytest.raises(tumble.FileError, match="argument path: the open file cannot be read"):
        tumble.read(closed)
    with open(tmp_path / "a.csv", "w") as writing, pytest.raises(tumble.FileError, match="not readable"):
        tumble.read(writing)

    class Nothing:
        def read(self):
            return None

    with pytest.raises(tumble.ArgumentTypeError, match="argument path"):
        tumble.read(Nothing())


def test_columns_of_a_table_that_look_like_others(tmp_path):
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    steps, x = np.arange(10), samples(1, 10).round(3)
    parquet.write_table(pa.table({"T[degC]": x, "g[1]": x}), tmp_path / "a.parquet")
    assert tumble.read(tmp_path / "a.parquet", rate=10)["T"].shown_unit == "degC"  # a temperature, no time
    parquet.write_table(pa.table({"timestamp": 10**8 * steps, "g[1]": x}), tmp_path / "b.parquet")
    found = tumble.read(tmp_path / "b.parquet", units={"timestamp": "ns"})
    assert list(found) == ["g"]
    np.testing.assert_allclose(found["g"].times, steps / 10)
    decimals = pa.array(x).cast(pa.decimal128(30, 20))
    parquet.write_table(pa.table({"time[s]": steps / 10, "g[1]": decimals}), tmp_path / "c.parquet")
    np.testing.assert_allclose(tumble.read(tmp_path / "c.parquet")["g"].values, x)


def test_faults_of_a_column_name_the_file(tmp_path):
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    for name, column in {"g[furlong]": 1.0, "g[1]": np.nan, "note": "x"}.items():
        parquet.write_table(pa.table({name: [column] * 10}), tmp_path / "a.parquet")
        with pytest.raises(tumble.TumbleError, match=r"a\.parquet: .*(unknown unit|are NaN|something else are note)"):
            tumble.read(tmp_path / "a.parquet", rate=1)


def test_rows_of_a_sheet_may_be_short(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in [["time[s]", "g[1]"], [0.0, 1.0], [0.1], [0.2, 3.0]]:
        book.active.append(row)
    book.save(tmp_path / "a.xlsx")
    assert tumble.read(tmp_path / "a.xlsx")["g"].missing == 1
