"""Arguments that nobody would write on purpose: what 250 values for every argument of every public function found."""

from __future__ import annotations

import decimal
import fractions
import io
import warnings

import numpy as np
import pytest
from tumble.compat import allantools, imucal

import tumble

USAGE, TYPE = tumble.UsageError, tumble.ArgumentTypeError
X = np.random.default_rng(3).normal(size=1000)
MATRIX = np.ones((3, 4))
IMMENSE = 10**5000  # beyond all floats, and Python refuses to write it as text


def refused(error, says, call):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(error, match=says):
            call()


def kind(value):
    """The name of a test: not every value has a text."""
    return type(value).__name__


class NoText:
    def __repr__(self):
        raise RuntimeError("no text")


class NoIndex:
    def __index__(self):
        raise ZeroDivisionError


@pytest.mark.parametrize(
    "value",
    [IMMENSE, fractions.Fraction(10**400), decimal.Decimal("sNaN"), np.float64, NoText(), MATRIX, "x", True],
    ids=kind,
)
def test_numbers(value):
    refused(USAGE, "argument sample_rate", lambda: tumble.allan_deviation(X, value))
    refused(USAGE, "argument confidence", lambda: tumble.allan_deviation(X, 1.0, confidence=value))
    refused(USAGE, "argument alpha", lambda: tumble.allan_deviation(X, 1.0, alpha=value))


@pytest.mark.parametrize("value", [NoIndex(), MATRIX, 1.5, -1, True, IMMENSE, np.array([1, 2])], ids=kind)
def test_whole_numbers(tree, value):
    refused(USAGE, "argument seed", lambda: tumble.simulate(tree / "plans/sdof_gyro_static.toml", seed=value))


@pytest.mark.parametrize("value", [5, b"nan", MATRIX, NoText(), "maybe", [], {}], ids=kind)
def test_words(value):
    for name in ("kind", "data", "mean_rate", "missing"):
        refused(USAGE, f"argument {name}", lambda name=name: tumble.allan_deviation(X, 1.0, **{name: value}))


@pytest.mark.parametrize("value", [1e300, -0.1, 0.0, 0.6])
def test_fractions_of_the_record(value):
    for taus in ("octave", "all", "log"):
        says = "argument longest_fraction"
        refused(USAGE, says, lambda taus=taus: tumble.allan_deviation(X, 1.0, taus=taus, longest_fraction=value))


@pytest.mark.parametrize("value", [2.0**63, -1.0])
def test_points_per_decade(value):
    says = "argument points_per_decade"
    refused(USAGE, says, lambda: tumble.allan_deviation(X, 1.0, taus="log", points_per_decade=value))


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (bytearray(b"abc"), "argument x: bytearray"),
        (np.array([np.inf, -np.inf, 1.0]), "2 of 3 values are infinite"),
        (np.full(9, 1.7e308), "overflowing value at sample 9"),  # finite, their sum is not
    ],
)
def test_samples(values, says):
    refused(tumble.TumbleError, says, lambda: tumble.allan_deviation(values, 1.0))


def test_columns_of_objects():
    pandas = pytest.importorskip("pandas")
    for cells in (["1.5", "2.5"], [True, False], [1.0, "2"], [1.0, pandas.Timestamp("2024")]):
        series = pandas.Series(cells * 20, dtype=object)
        refused(TYPE, "argument x", lambda series=series: tumble.allan_deviation(series, 1.0))
    refused(
        TYPE,
        "argument x",
        lambda: tumble.allan_deviation(pandas.Series([True, None] * 20, dtype="boolean"), 1.0),
    )
    numbers = pandas.Series([decimal.Decimal("1.5"), None, 2, 3.5] * 20, dtype=object)
    recording = tumble.from_arrays({"g": (numbers, "1")}, rate=1, missing="nan")
    assert recording["g"].missing == 20


def test_a_quantity_has_one_unit():
    pint = pytest.importorskip("pint")
    rate = pint.UnitRegistry().Quantity(X, "rad/s")
    refused(USAGE, "a quantity has its unit already", lambda: tumble.from_arrays({"g": (rate, "deg/s")}, rate=1))
    assert tumble.from_arrays({"g": rate}, rate=1)["g"].shown_unit == "rad/s"


def test_every_averaging_time_of_samples_that_do_not_vary():
    for values in (np.ones(50), np.array([1.0, 2.0] * 20)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = tumble.allan_deviation(values, 100.0, taus="all")
        still = found.deviation == 0
        assert still.any()
        assert (found.lower[still] == 0).all()
        assert np.isfinite(found.upper).all()


def test_arrays_where_a_word_or_a_flag_is_wanted(tree, imu_file):
    plan = tumble.load_plan(tree / "plans/sdof_gyro_static.toml")
    refused(TYPE, "argument settings", lambda: tumble.predict(plan, settings=MATRIX))
    refused(TYPE, "argument strict", lambda: tumble.identify(plan, strict=MATRIX))
    refused(TYPE, "argument marks", lambda: tumble.from_arrays({"g[1]": X}, rate=1, marks=np.array(1)))
    refused(TYPE, "argument format", lambda: tumble.read(io.BytesIO(b"x"), format=5))
    refused(TYPE, "argument begin", lambda: tumble.from_arrays({"g[1]": X}, rate=1)[MATRIX:])
    refused(KeyError, "no channel", lambda: tumble.from_arrays({"g[1]": X}, rate=1)[MATRIX])
    refused(KeyError, "no method", lambda: tumble.methods[IMMENSE])
    refused(TYPE, r"identify\(plan, \*recordings\)", lambda: tumble.identify(plan, [imu_file]))
    refused(tumble.FileError, "File name too long", lambda: tumble.archive.open("x" * 300))


def test_a_folder_with_the_name_of_a_method(tmp_path, monkeypatch, imu_file):
    (tmp_path / "allan_noise").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.warns(tumble.TumbleWarning):
        assert tumble.identify("allan_noise", imu_file).method == "allan_noise"


def test_methods_of_python():
    recording = tumble.from_arrays({"g[1]": X}, rate=1)

    def method(covariance=((1.0,),), trial=None, options=None):
        return tumble.Method("m", "", lambda r, s: ({"b": (1.0, "1")}, covariance), trial, options or {})

    refused(USAGE, "covariance of method m", lambda: tumble.identify(method([[1j]]), recording))
    refused(USAGE, "argument settings: 5", lambda: tumble.identify(method(), recording, settings={5: 1}))
    refused(USAGE, "trial of method m: 5", lambda: tumble.coverage(method(trial=5), seeds=20))
    drawn = {"recordings of method m": ([5], {"b": 1.0}), "truth of 'b'": ([recording], {"b": "x"})}
    for says, answer in {**drawn, "trial of method m": (5, {"b": 1.0})}.items():
        refused(USAGE, says, lambda answer=answer: tumble.coverage(method(trial=lambda seed: answer), seeds=20))


def test_compat_names_its_arguments():
    for call, name in {
        "rate": lambda: allantools.oadev(X, rate="fast"),
        "data_type": lambda: allantools.oadev(X, data_type=MATRIX),
        "taus": lambda: allantools.oadev(X, taus="\ud800"),
        "phase": lambda: allantools.phase2frequency(["a"], 1.0),
        "x": lambda: allantools.trim_data(MATRIX),
        "function": lambda: allantools.Dataset(X).compute(None),
    }.items():
        refused(USAGE, f"argument {call}", name)
    low, high = allantools.confidence_interval(np.array([1.0, 2.0]), 5.0)
    assert high[1] / high[0] == low[1] / low[0] == 2.0
    assert allantools.edf_simple(1000, np.array([1, 40]), 2)[1] == allantools.edf_simple(1000, 40, 2)
    assert np.isnan(allantools.confidence_interval(1.0, float("inf"))[0])


def test_calibrations(tmp_path):
    refused(FileNotFoundError, "absent.json", lambda: imucal.CalibrationInfo.from_json_file(tmp_path / "absent.json"))
    refused(TYPE, "argument json_str: 5", lambda: imucal.CalibrationInfo.from_json(5))
    refused(TYPE, "argument sensor_id: 5", lambda: imucal.find_calibration_info_for_sensor(5, tmp_path))
    one = imucal.FerrarisCalibrationInfo(
        from_acc_unit="g",
        from_gyr_unit="deg/s",
        **{name: np.eye(3) if name[0] != "b" else np.zeros(3) for name in imucal.FerrarisCalibrationInfo._cal_paras},
    )
    acc, gyr = one.calibrate([1.0, 2.0, 3.0], [0.0, 0.0, 0.0], "g", "deg/s")  # one sample, as in imucal
    np.testing.assert_array_equal(acc, [1.0, 2.0, 3.0])
    assert gyr.shape == (3,)
    refused(USAGE, "argument acc_unit", lambda: one.calibrate(acc, gyr, MATRIX, "deg/s"))
