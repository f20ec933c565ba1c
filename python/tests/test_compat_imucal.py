"""tumble.compat.imucal beside imucal itself: 1e-9 of every matrix, and each reads the files of the other."""

from __future__ import annotations

import datetime
import json

import numpy as np
import pytest
from tumble.compat import imucal as ours

import tumble

pd = pytest.importorskip("pandas")

MATRICES = ("K_a", "R_a", "b_a", "K_g", "R_g", "K_ga", "b_g")
UNITS = {"from_acc_unit": "a.u.", "from_gyr_unit": "a.u."}


@pytest.fixture(scope="module")
def theirs():
    return pytest.importorskip("imucal")


@pytest.fixture(scope="module")
def session(tree):
    """A real sensor at 204.8 Hz, published with imucal."""
    return pd.read_csv(tree / "tests/reference/imucal/annotated_session.csv").set_index("part")


def random_session(seed):
    """Sections of odd lengths, in two parts each, of an IMU with any axes; columns in another order and of float32."""
    rng = np.random.default_rng(seed)
    matrix, parts = 200.0 * (np.eye(3) + 0.1 * rng.standard_normal((3, 3))), []
    for label in ours.FerrarisCalibration.FERRARIS_SECTIONS:
        axis, sign = "xyz".index(label[0]), -1.0 if label[2] == "a" else 1.0
        count = int(rng.integers(3, 60))
        force = matrix @ np.eye(3)[axis] * sign * 9.81 + rng.standard_normal((count, 3))
        turn = -90.0 * np.eye(3)[axis] if label.endswith("rot") else np.zeros(3)
        rate = 16.0 * turn + rng.standard_normal((count, 3)) + 2.0
        columns = ["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
        parts.append(pd.DataFrame(np.hstack([force, rate]), columns=columns, index=[label] * count))
    return pd.concat([one[:2] for one in parts] + [one[2:] for one in reversed(parts)])[sorted(columns)[::-1]]


def calibrated(module, df, rate=204.8, kind="FerrarisCalibration", **options):
    return getattr(module, kind)(**options).compute(module.ferraris_regions_from_df(df), rate, **UNITS)


def same(one, other):
    for name in MATRICES:
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-9, atol=1e-12, err_msg=name)


def test_published_session(session, tree):
    cal = calibrated(ours, session)
    expected = json.loads((tree / "tests/reference/imucal/annotated_session_expected_cal.json").read_text())
    for name in MATRICES:
        np.testing.assert_allclose(getattr(cal, name), expected[name], rtol=1e-9, atol=1e-12, err_msg=name)


@pytest.mark.parametrize("seed", range(5))
def test_equal(theirs, seed):
    df = random_session(seed)
    for kind, options in {
        "FerrarisCalibration": {"grav": -9.8, "expected_angle": 360},
        "TurntableCalibration": {},
    }.items():
        one, other = (calibrated(module, df, 97.3, kind, **options) for module in (ours, theirs))
        same(one, other)
        assert {**json.loads(one.to_json()), **dict.fromkeys(MATRICES)} == {
            **json.loads(other.to_json()),
            **dict.fromkeys(MATRICES),
        }
        acc, gyr = df[["acc_x", "acc_y", "acc_z"]].to_numpy(), df[["gyr_x", "gyr_y", "gyr_z"]].to_numpy()
        for a, b in zip(
            one.calibrate(acc, gyr, "a.u.", "a.u."), other.calibrate(acc, gyr, "a.u.", "a.u."), strict=True
        ):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)
        pd.testing.assert_frame_equal(one.calibrate_df(df, "a.u.", "a.u."), other.calibrate_df(df, "a.u.", "a.u."))


def test_section_list(theirs, session):
    flat = session.reset_index()
    runs = flat.groupby("part").apply(lambda part: pd.Series({"start": part.index[0], "end": part.index[-1] + 1}))
    regions = [m.ferraris_regions_from_section_list(flat.drop(columns="part"), runs) for m in (ours, theirs)]
    for one, other in zip(*regions, strict=True):
        np.testing.assert_array_equal(one, other)


def test_files_of_each_other(theirs, session, tmp_path):
    file = tmp_path / "cal.json"
    one = calibrated(ours, session)
    one.to_json_file(file)
    read = theirs.CalibrationInfo.from_json_file(file)
    same(one, read)
    assert read.to_json() == one.to_json()  # digit by digit
    read.to_json_file(file)
    again = ours.CalibrationInfo.from_json_file(file)
    assert type(again) is ours.FerrarisCalibrationInfo
    assert again == one
    again.comment = "another"
    assert again != one


def test_hdf5_of_each_other(theirs, session, tmp_path):
    pytest.importorskip("h5py")
    one = calibrated(ours, session)
    one.comment = "both"
    one.to_hdf5(tmp_path / "a.h5")
    same(one, theirs.CalibrationInfo.from_hdf5(tmp_path / "a.h5"))
    theirs.CalibrationInfo.from_json(one.to_json()).to_hdf5(tmp_path / "b.h5")
    assert ours.CalibrationInfo.from_hdf5(tmp_path / "b.h5") == one


def test_class_of_ones_own(session):
    class Mine(ours.FerrarisCalibrationInfo):
        CAL_TYPE = "Mine"

    cal = ours.FerrarisCalibration(calibration_info_class=Mine).compute(
        ours.ferraris_regions_from_df(session), 204.8, comment="by hand", **UNITS
    )
    assert type(ours.CalibrationInfo.from_json(cal.to_json())) is Mine
    assert cal.comment == "by hand"


def test_same_answer_as_the_method(session, tree):
    """imu_ferraris gives the same matrices, in its table."""
    flat = session.reset_index().rename(
        columns=lambda name: name.replace("acc_", "accelerometer_").replace("gyr_", "gyro_")
    )
    names = [name for name in flat.columns if name[-2] == "_"]
    begins = flat.index[flat["part"] != flat["part"].shift()]
    marks = [(str(flat["part"][row]), row / 204.8) for row in begins]
    recording = tumble.from_arrays({name: (flat[name].to_numpy(), "LSB") for name in names}, rate=204.8, marks=marks)
    settings = {"gravity": "9.81 m/s^2", "rotation_angle": "-360 deg", "axes": "any"}
    with pytest.warns(tumble.TumbleWarning):
        table = tumble.identify("imu_ferraris", recording, settings=settings).tables["matrices"]
    k_a = [row[-3:] for row in table.rows if row[0] == "K_a"]
    np.testing.assert_allclose(calibrated(ours, session).K_a, np.array(k_a, dtype=float), rtol=1e-9, atol=1e-12)


def test_bad_input(session):
    with pytest.raises(tumble.DataError, match="no section z_rot") as caught:
        ours.ferraris_regions_from_df(session.drop("z_rot").rename(index={"x_p": "up"}))
    assert len(caught.value.problems) == 3
    with pytest.raises(tumble.UsageError, match="argument acc_cols"):
        ours.ferraris_regions_from_df(session, acc_cols=("ax", "ay", "az"))
    with pytest.raises(tumble.ArgumentTypeError, match="argument df"):
        ours.ferraris_regions_from_df([1, 2])
    regions = ours.ferraris_regions_from_df(session)
    with pytest.raises(tumble.DataError, match="section acc_x_p"):
        ours.FerrarisCalibration().compute(regions._replace(acc_x_p=np.empty((0, 3))), 100.0, **UNITS)
    with pytest.raises(tumble.DataError, match="do not show three axes"):
        ours.FerrarisCalibration().compute(regions._replace(acc_x_p=regions.acc_x_a), 100.0, **UNITS)
    with pytest.raises(tumble.UsageError, match="argument sampling_rate_hz"):
        ours.FerrarisCalibration().compute(regions, 0.0, **UNITS)
    cal = calibrated(ours, session)
    acc, gyr = np.ones((4, 3)), np.ones((5, 3))
    with pytest.raises(tumble.UsageError, match="argument gyr: 5 rows were given"):
        cal.calibrate(acc, gyr, "a.u.", "a.u.")
    with pytest.raises(tumble.UsageError, match="argument acc_unit: 'g' was given"):
        cal.calibrate(acc, acc, "g", "a.u.")
    for text in ("{", "[]", '{"cal_type": "Ferraris", "_format_version": "2.0"}', '{"cal_type": "New"}'):
        with pytest.raises(tumble.DataError):
            ours.CalibrationInfo.from_json(text)


def test_folders_of_calibrations(theirs, session, tmp_path):
    management = pytest.importorskip("imucal.management")
    begin = datetime.datetime(2024, 1, 2, 3, 4)
    dates = [begin, begin + datetime.timedelta(days=60), begin + datetime.timedelta(days=90)]
    for module, folder, source in ((ours, "ours", ours), (management, "theirs", theirs)):
        for date in dates:
            module.save_calibration_info(calibrated(source, session), "Abc1", date, tmp_path / folder)
    names = [sorted(str(p.relative_to(tmp_path / f)) for p in (tmp_path / f).rglob("*")) for f in ("ours", "theirs")]
    assert names[0] == names[1]
    folder = tmp_path / "ours"
    for options in ({}, {"filter_cal_type": "ferraris"}, {"custom_validator": lambda info: True}):
        expected = management.find_calibration_info_for_sensor("abc1", folder, **options)
        assert ours.find_calibration_info_for_sensor("abc1", folder, **options) == sorted(expected)
    for days in (-5, 0, 20, 40, 75, 100):
        for side in (None, "before", "after"):
            date = begin + datetime.timedelta(days=days)
            if (side, days) in (("before", -5), ("after", 100)):
                with pytest.raises(tumble.DataError, match="no calibration of 'abc1'"):
                    ours.find_closest_calibration_info_to_date("abc1", date, folder, before_after=side)
                continue
            arguments = ("abc1", date, folder, True, None, None, side, datetime.timedelta(days=1000))
            expected = management.find_closest_calibration_info_to_date(*arguments)
            assert ours.find_closest_calibration_info_to_date(*arguments) == expected
    with pytest.warns(ours.CalibrationWarning, match="40 days"):
        ours.find_closest_calibration_info_to_date("abc1", dates[2] + datetime.timedelta(days=40), folder)
    found = ours.find_closest_calibration_info_to_date("abc1", begin, folder)
    assert ours.load_calibration_info(found) == calibrated(ours, session)
    with pytest.raises(tumble.DataError, match="no calibration of the sensor 'none'"):
        ours.find_calibration_info_for_sensor("none", folder)
    assert ours.find_closest_calibration_info_to_date("none", begin, folder, ignore_file_not_found=True) is None
    with pytest.raises(tumble.UsageError, match="argument sensor_id"):
        ours.save_calibration_info(calibrated(ours, session), "a_b", begin, folder)
