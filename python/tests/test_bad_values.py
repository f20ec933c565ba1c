"""Values of every kind that somebody may give: each is understood, or refused by the name of its argument."""

from __future__ import annotations

import datetime
import decimal
import fractions
import pickle
import warnings

import numpy as np
import pytest

import tumble

X = np.random.default_rng(3).normal(size=1000)
HUNDRED = {"rate": 100}


def refused(error, says, call):
    with pytest.raises(error, match=says):
        call()


def arrays(**options):
    return tumble.from_arrays({"gyro": (X, "deg/s")}, **options)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        ({"points_per_decade": "a"}, tumble.ArgumentTypeError, "argument points_per_decade: 'a'"),
        ({"longest_fraction": float("nan")}, tumble.UsageError, "argument longest_fraction: nan"),
        ({"longest_fraction": float("inf")}, tumble.UsageError, "argument longest_fraction: inf"),
        ({"longest_fraction": None}, tumble.ArgumentTypeError, "argument longest_fraction: None"),
        ({"confidence": "0.9"}, tumble.ArgumentTypeError, "argument confidence: '0.9'"),
        ({"alpha": 0.5}, tumble.ArgumentTypeError, "argument alpha: 0.5"),
        ({"alpha": 7}, tumble.ArgumentTypeError, "argument alpha: 7"),
        ({"taus": []}, tumble.UsageError, "argument taus: an empty list"),
        ({"taus": [True]}, tumble.ArgumentTypeError, "argument taus: True"),
        ({"taus": ["10 deg"]}, tumble.UsageError, "argument taus: '10 deg'"),
    ],
)
def test_options_of_allan_deviation(options, error, says):
    refused(error, says, lambda: tumble.allan_deviation(X, 100.0, **options))


def test_half_a_sampling_interval_is_one():
    with pytest.warns(tumble.TumbleWarning, match=r"1 of 1 averaging times have no answer within 5 % \(0.005 s\)"):
        assert tumble.allan_deviation(X, 100.0, taus=[0.005]).taus == pytest.approx([0.01])


def test_averaging_times_that_have_no_answer_are_named():
    with pytest.warns(tumble.TumbleWarning, match=r"3 of 5 .*\(0.015 s, 6 s, 1e\+06 s\): .* 0.01 s, up to 2 s"):
        found = tumble.allan_deviation(X, 100.0, taus=[0.015, "2 s", 6.0, 1e6, 1.004])
    np.testing.assert_allclose(found.taus, [0.02, 1.0, 2.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tumble.allan_deviation(X, 100.0, taus=[0.01, 0.102, 1.0049, "2 s"])  # within 5 %
        tumble.allan_deviation(X, 100.0, taus=[0.1, 1.0], kind="theo1")  # strides


@pytest.mark.parametrize("rate", [fractions.Fraction(100), decimal.Decimal(100), np.float32(100), np.array(100), "1e2"])
def test_numbers_of_every_kind_are_rates(rate):
    assert tumble.allan_deviation(X, rate).taus[0] == 0.01


@pytest.mark.parametrize("values", [np.ma.array(["a", "b"]), np.ma.array(X + 1j), np.ma.array(X > 0)])
def test_masked_arrays_of_something_else(values):
    refused(tumble.ArgumentTypeError, "argument x: masked_array", lambda: tumble.allan_deviation(values, 100.0))


def test_times_may_be_dates_and_durations():
    steps = np.arange(1000) * np.timedelta64(10, "ms")
    naive = [datetime.datetime(2024, 1, 1) + datetime.timedelta(milliseconds=10 * k) for k in range(1000)]
    zone = datetime.timezone(datetime.timedelta(hours=2))
    for times in (steps, np.datetime64("2024-01-01") + steps, naive, [one.replace(tzinfo=zone) for one in naive]):
        gyro = arrays(time=times)["gyro"]
        assert gyro.times[-1] == pytest.approx(9.99, rel=1e-12)
        assert gyro.rate == pytest.approx(100.0)
    absent = np.datetime64("2024-01-01") + steps
    absent[5] = "NaT"
    refused(tumble.DataError, "argument time: the date of row 5 is absent", lambda: arrays(time=absent))


def test_absent_times_have_no_word_that_means_missing():
    with pytest.raises(tumble.DataError) as caught:
        arrays(time=np.where(np.arange(1000) == 5, np.nan, np.arange(1000.0)))
    assert "missing=" not in str(caught.value)


@pytest.mark.parametrize("start", [None, True, "x", "3 deg", float("nan"), float("inf"), datetime.datetime(2024, 1, 1)])
def test_start(start):
    refused(tumble.UsageError, "argument start", lambda: arrays(**HUNDRED, start=start))
    assert arrays(**HUNDRED, start="2 min")["gyro"].start == 120.0


@pytest.mark.parametrize(
    "marks",
    [None, "a", {"a": 1}, ["a"], [("a",)], [(1, 0.0)], [("a", "x")], [("a", float("nan"))], [("a", 0.0, 1.5)]],
)
def test_marks(marks):
    refused(tumble.UsageError, "argument marks", lambda: arrays(**HUNDRED, marks=marks))


def test_marks_are_in_order_of_time():
    marks = arrays(**HUNDRED, marks=[("b", "5 s"), ("a", 0.0, 2), tumble.Mark("c", 2.0)]).marks
    assert [(one.label, one.begin, one.run) for one in marks] == [("a", 0.0, 2), ("c", 2.0, 1), ("b", 5.0, 1)]


@pytest.mark.parametrize("key", ["name", "instrument"])
@pytest.mark.parametrize("text", [1, None, "\ud800"])
def test_texts(key, text):
    refused(tumble.UsageError, f"argument {key}", lambda: arrays(**HUNDRED, **{key: text}))


def test_names_and_units_of_channels():
    refused(tumble.UsageError, "argument channels", lambda: tumble.from_arrays({"\ud800": (X, "1")}, rate=1))
    refused(tumble.UsageError, "argument channels", lambda: tumble.from_arrays({"a": (X, "\ud800")}, rate=1))
    twice = {"a[deg/s]": X, "a": (X, "deg/h")}
    refused(tumble.UsageError, "the name 'a' is given twice", lambda: tumble.from_arrays(twice, rate=1))


@pytest.mark.parametrize("name", ["a\0.csv", "\udcff.csv"])
def test_names_that_no_file_has(name):
    for call in (tumble.read, tumble.load_plan, tumble.load_result, arrays(**HUNDRED).save):
        refused(tumble.UsageError, "argument path", lambda call=call: call(name))


def test_bytes_are_paths(tmp_path):
    arrays(**HUNDRED).save(bytes(tmp_path / "ü 测试.h5"))
    assert len(tumble.read(str(tmp_path / "ü 测试.h5").encode())["gyro"]) == 1000


def test_one_name_is_a_list_of_one(imu_file, tree):
    assert list(tumble.read(imu_file, channels="gyro.x")) == ["gyro.x"]
    refused(tumble.ArgumentTypeError, "argument channels: 5", lambda: tumble.read(imu_file, channels=5))
    plan = tree / "plans/sdof_gyro_static.toml"
    assert list(tumble.predict(plan, terms="D_F").parameters) == list(tumble.predict(plan, terms=["D_F"]).parameters)
    refused(tumble.ArgumentTypeError, "argument units: 'deg/s'", lambda: tumble.read(imu_file, units="deg/s"))


def test_cuts_take_times_with_units():
    recording = arrays(**HUNDRED)
    assert len(recording["2 s" : np.float32(3.0)]["gyro"]) == 100
    refused(tumble.UsageError, "argument begin", lambda: recording[True:5])


def test_units_that_are_none():
    gyro = arrays(**HUNDRED)["gyro"]
    refused(tumble.ArgumentTypeError, "argument unit: 5", lambda: gyro.in_(5))


def test_channels_and_what_is_simulated_survive_a_pickle(tree):
    gyro = arrays(time=np.cumsum(1.0 + 0.1 * np.abs(X)))["gyro"]
    again = pickle.loads(pickle.dumps(gyro))
    assert (again.name, again.shown_unit) == (gyro.name, gyro.shown_unit)
    np.testing.assert_array_equal(again.values, gyro.values)
    np.testing.assert_array_equal(again.times, gyro.times)
    plan = tumble.load_plan(tree / "plans/sdof_gyro_static.toml")
    test = tumble.simulate(plan, seed=3)
    copied = pickle.loads(pickle.dumps(test))
    assert tumble.identify(plan, copied).to_json() == tumble.identify(plan, test).to_json()


def test_arrays_are_not_copied_where_that_is_forbidden():
    if np.lib.NumpyVersion(np.__version__) < "2.0.0":
        pytest.skip("NumPy 1 copies where it must")
    refused(ValueError, "copy", lambda: np.asarray(arrays(**HUNDRED)["gyro"], dtype=np.float32, copy=False))


def test_settings_of_plans(tree):
    plan = tumble.load_plan(tree / "plans/sdof_gyro_static.toml")
    refused(tumble.ArgumentTypeError, "argument settings: 'x'", lambda: plan.with_("x"))
    refused(tumble.ArgumentTypeError, "argument settings: 5", lambda: plan.with_({5: 1}))
    refused(tumble.UsageError, "UTF-8", lambda: plan.with_({"settling": "\udcff"}))
    refused(tumble.ArgumentTypeError, "memory_limit", lambda: tumble.identify(plan, memory_limit="x"))
    refused(tumble.ArgumentTypeError, "memory_limit", lambda: tumble.identify(plan, memory_limit=-1))


def test_results_cannot_be_changed(imu_file):
    with pytest.warns(tumble.TumbleWarning):
        result = tumble.identify("allan_noise", imu_file)
    for change in ("method", "parameters", "anything"):
        with pytest.raises(AttributeError):
            setattr(result, change, None)
    result.document["method"] = "another"
    result.provenance["inputs"].clear()
    assert result.method == "allan_noise"
    assert result.provenance["inputs"]
    tumble.methods["allan_noise"]["options"].clear()
    assert tumble.methods["allan_noise"].options


def test_unknown_parts_of_a_result_are_key_errors_that_list_the_known(imu_file):
    with pytest.warns(tumble.TumbleWarning):
        result = tumble.identify("allan_noise", imu_file)
    name = next(iter(result.parameters))
    refused(KeyError, name, lambda: result.covariance[name, "b"])
    refused(KeyError, name, lambda: result.covariance[name])
    refused(KeyError, "no source 'b'; there are", lambda: result.budget["b"])
    refused(KeyError, "no parameter 'b'; there are", lambda: next(iter(result.budget.values()))["b"])


def test_figures_survive_a_pickle(imu_file):
    with pytest.warns(tumble.TumbleWarning):
        figure = tumble.identify("allan_noise", imu_file).figures[0]
    again = pickle.loads(pickle.dumps(figure))
    assert again.to_svg() == figure.to_svg()
    np.testing.assert_array_equal(again.series[0].y, figure.series[0].y)


VARIANCE = [[1.0]]


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (({"b": 1.0}, VARIANCE), r"parameter 'b' of method m: 1\.0"),
        (({"b": ("x", "rad/s")}, VARIANCE), "parameter 'b' of method m: 'x'"),
        (({"b": (float("nan"), "rad/s")}, VARIANCE), "parameter 'b' of method m: nan"),
        (({"b": (X, "rad/s")}, VARIANCE), "parameter 'b' of method m: array"),
        (({5: (1.0, "rad/s")}, VARIANCE), "parameter 5 of method m"),
        (({}, np.zeros((0, 0))), "parameters of method m: {}"),
        (([("b", 1.0)], VARIANCE), "parameters of method m"),
        (({"b": (1.0, "rad/s")}, "x"), "covariance of method m: 'x'"),
    ],
)
def test_answers_of_methods(answer, says):
    method = tumble.Method("m", "", lambda recordings, settings: answer)
    refused(tumble.UsageError, says, lambda: tumble.identify(method, arrays(**HUNDRED)))


def test_methods_that_are_none():
    answer = ({"b": (1.0, "1")}, VARIANCE)
    good = tumble.Method("m", "", lambda recordings, settings: answer, lambda seed: None)
    refused(tumble.ArgumentTypeError, "identify of method m: 5", lambda: tumble.identify(good._replace(identify=5)))
    refused(tumble.ArgumentTypeError, "trial of method m: None", lambda: tumble.coverage(good))
    refused(tumble.ArgumentTypeError, "argument method", lambda: tumble.coverage("allan_noise"))
    refused(tumble.ArgumentTypeError, "argument seeds", lambda: tumble.coverage(good, seeds="x"))
    other = good._replace(trial=lambda seed: ([], {"c": 1.0}))
    refused(tumble.UsageError, "the trial names 'c'", lambda: tumble.coverage(other, seeds=20))


def test_terms_that_the_model_has_not(tree):
    plan = tree / "plans/sdof_gyro_static.toml"
    refused(
        tumble.UsageError, "has no term 'D_FF'; did you mean 'D_F'", lambda: tumble.predict(plan, terms=["D_FF", "D_I"])
    )
