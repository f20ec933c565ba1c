"""pandas, polars, xarray, Arrow, pint, uncertainties: there and back."""

from __future__ import annotations

import numpy as np
import pytest

import tumble

pandas = pytest.importorskip("pandas")
RATE = 50.0


def frame(count: int = 400) -> pandas.DataFrame:
    random = np.random.default_rng(3)
    return pandas.DataFrame({"gyro.x[deg/s]": random.normal(size=count), "acc": random.normal(size=count)})


def test_a_frame_becomes_a_recording_and_back():
    df = frame()
    recording = tumble.from_pandas(df, units={"acc": "m/s^2"}, rate=RATE)
    assert {name: channel.shown_unit for name, channel in recording.items()} == {"gyro.x": "deg/s", "acc": "m/s^2"}
    back = recording.to_pandas()
    assert back.attrs["units"] == {"gyro.x": "deg/s", "acc": "m/s^2"}
    np.testing.assert_allclose(back["gyro.x"], df["gyro.x[deg/s]"], rtol=4e-16)
    again = tumble.from_pandas(back)  # units from attrs, times from the index
    np.testing.assert_array_equal(again["acc"].times, recording["acc"].times)


def test_a_frame_with_dates_keeps_its_stamps():
    df = frame()
    df.index = pandas.date_range("2026-01-02", periods=len(df), freq="20ms")
    recording = tumble.from_pandas(df, units={"acc": "m/s^2"})
    np.testing.assert_allclose(recording["acc"].times, np.arange(len(df)) / RATE, atol=1e-9)


def test_a_frame_with_a_gap_is_refused_or_found():
    df = frame()
    df.index = pandas.date_range("2026-01-02", periods=len(df), freq="20ms")
    df = df.drop(df.index[100:150])
    with pytest.raises(
        tumble.DataError, match=r"rate: 50.0 was given, but the stamps have a gap of 1.02 s after row 99"
    ):
        tumble.from_pandas(df, units={"acc": "m/s^2"}, rate=RATE)
    found = tumble.from_pandas(df, units={"acc": "m/s^2"}).check()
    assert "gap" in {finding.code for finding in found}
    df.iloc[7, 1] = np.nan
    with pytest.raises(tumble.DataError, match=r"channels\['acc'\]: 1 of 350 values are NaN"):
        tumble.from_pandas(df, units={"acc": "m/s^2"})


def test_frames_without_units_or_times_are_refused():
    with pytest.raises(tumble.UsageError, match="columns acc have no unit"):
        tumble.from_pandas(frame(), rate=RATE)
    with pytest.raises(tumble.UsageError, match="the index only counts rows"):
        tumble.from_pandas(frame(), units={"acc": "m/s^2"})
    with pytest.raises(tumble.UsageError, match="argument time: 't' was given; there is no such column"):
        tumble.from_pandas(frame(), units={"acc": "m/s^2"}, time="t")
    with pytest.raises(tumble.ArgumentTypeError, match="accepted is a pandas DataFrame"):
        tumble.from_pandas([1, 2])


def test_channels_of_different_rates_fit_no_frame():
    one = tumble.from_arrays({"x": (np.arange(9.0), "deg/s")}, rate=RATE)
    two = tumble.from_arrays({"x": (np.arange(9.0), "deg/s")}, rate=2 * RATE)
    assert not np.array_equal(one["x"].times, two["x"].times)
    recording = tumble.from_pandas(frame(), units={"acc": "m/s^2"}, rate=RATE)
    assert len(recording.to_pandas()) == 400


def test_polars_xarray_and_arrow_take_what_we_have(imu_file):
    polars, xarray, arrow = (pytest.importorskip(name) for name in ("polars", "xarray", "pyarrow"))
    recording = tumble.read(imu_file)[0.0:10.0]
    assert recording.to_polars().columns[:2] == ["time[s]", "gyro.x[deg/s]"]
    dataset = recording.to_xarray()
    assert dataset["gyro.x"].attrs["unit"] == "deg/s"
    assert isinstance(dataset, xarray.Dataset)
    table = tumble.identify("allan_noise", recording).tables["terms"]
    by_arrow = arrow.table(table)
    assert by_arrow.num_rows == len(table)
    assert polars.from_arrow(by_arrow).columns == table.to_pandas().columns.tolist()


def test_pint_goes_in_and_comes_out():
    pint = pytest.importorskip("pint")
    registry = pint.UnitRegistry()
    random = np.random.default_rng(5).normal(size=4000)
    given = tumble.from_arrays({"gyro.x": random * registry("deg/hour")}, rate=100 * registry.hertz)
    plain = tumble.from_arrays({"gyro.x": (random, "deg/h")}, rate=100)
    np.testing.assert_allclose(given["gyro.x"].values, plain["gyro.x"].values, rtol=4e-16)
    noise = tumble.identify("allan_noise", given).parameters["gyro.x.angle_random_walk"]
    assert noise.to_pint(registry).to("deg/hour**0.5").magnitude == pytest.approx(
        noise.in_("deg/sqrt(h)").value, rel=1e-12
    )


def test_uncertainties_are_correlated(tree):
    pytest.importorskip("uncertainties")
    result = tumble.predict(tree / "plans/sdof_gyro_static.toml")
    numbers = result.to_uncertainties()
    for name, parameter in result.parameters.items():
        assert numbers[name].std_dev == pytest.approx(parameter.sd, rel=1e-9)
    first, second = list(numbers)[:2]
    variance = sum(result.covariance[a, b] for a in (first, second) for b in (first, second))
    assert (numbers[first] + numbers[second]).std_dev ** 2 == pytest.approx(variance, rel=1e-6)


U = {"a": "deg/s"}


def test_an_index_may_be_dates_with_a_zone_durations_or_a_column_of_either():
    dates = pandas.date_range("2024-03-31 01:59:55", periods=1000, freq="10ms", tz="Europe/Berlin")  # over the change
    df = pandas.DataFrame({"a": np.arange(1000.0)})
    for index in (dates, dates - dates[0], pandas.Index(list(dates), dtype=object)):
        assert tumble.from_pandas(df.set_axis(index), units=U)["a"].times[-1] == pytest.approx(9.99)
        assert tumble.from_pandas(df.assign(t=index.to_series(df.index)), units=U, time="t")["a"].times[
            -1
        ] == pytest.approx(9.99)


def test_dates_that_are_absent_are_refused():
    dates = pandas.DatetimeIndex([pandas.NaT, *pandas.date_range("2024", periods=9, freq="10ms")])
    df = pandas.DataFrame({"a": np.arange(10.0)}, index=dates)
    for options in ({}, {"rate": 100}):
        with pytest.raises(tumble.DataError, match="the date of row 0 is absent"):
            tumble.from_pandas(df, units=U, **options)


@pytest.mark.parametrize(
    ("index", "says"),
    [
        (np.r_[0:40, 47:107], "rows are missing"),  # of dropna()
        (pandas.date_range("2024", periods=100, freq="1s"), "the stamps are 1 s apart"),
        (pandas.date_range("2024", periods=100, freq="20ms")[::-1], "the stamps are -0.02 s apart"),
    ],
)
def test_an_index_that_contradicts_the_rate_is_refused(index, says):
    df = pandas.DataFrame({"a": np.arange(100.0)}, index=index)
    with pytest.raises(tumble.DataError, match=says):
        tumble.from_pandas(df, units=U, rate=RATE)
    assert len(tumble.from_pandas(df.reset_index(drop=True), units=U, rate=RATE)["a"]) == 100


def test_every_second_row_is_no_gap():
    df = pandas.DataFrame({"a": np.arange(100.0)})[::2]
    assert len(tumble.from_pandas(df, units=U, rate=RATE)["a"]) == 50


def test_columns_of_one_name_and_of_several_levels():
    twice = pandas.DataFrame(np.ones((4, 2)), columns=["a", "a"])
    with pytest.raises(tumble.UsageError, match="two columns are called 'a'"):
        tumble.from_pandas(twice, units=U, rate=1)
    levels = pandas.DataFrame(np.ones((4, 2)), columns=pandas.MultiIndex.from_product([["gyro"], ["x", "y"]]))
    units = {"gyro.x": "deg/s", ("gyro", "y"): "deg/h"}
    assert list(tumble.from_pandas(levels, units=units, rate=1)) == ["gyro.x", "gyro.y"]


@pytest.mark.parametrize("rows", [0, 4])
def test_frames_without_samples(rows):
    df = pandas.DataFrame({"a": np.ones(4)}, index=pandas.date_range("2024", periods=4, freq="1s"))
    with pytest.raises(tumble.DataError, match="argument df"):
        tumble.from_pandas(df.iloc[:rows][["a"] if not rows else []], units=U)
    with pytest.raises(tumble.ArgumentTypeError, match="argument units: 'deg/s'"):
        tumble.from_pandas(df, units="deg/s")


def test_quantities_of_pint_keep_their_meaning():
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    x = np.arange(1.0, 101.0)
    stamps = np.arange(100) * 10.0 * unit.ms
    recording = tumble.from_arrays({"a": x * unit("deg/hour")}, time=stamps, start=0 * unit.s)
    assert recording["a"].times[-1] == pytest.approx(0.99)
    assert recording["a"].shown_unit == "deg/h"
    assert recording["a"].in_(unit("rad/s").units)[0] == recording["a"].values[0]
    for quantity, si in ((unit.Quantity(x, "delta_degC"), 1.0), (unit.Quantity(x, "g"), 1e-3), (x * unit.g_0, 9.80665)):
        assert tumble.from_arrays({"a": quantity}, rate=1)["a"].values[0] == pytest.approx(si, rel=1e-12)
    curve = tumble.allan_deviation(x * unit("deg/s"), 100.0, taus=np.array([20.0, 40.0]) * unit.ms)
    assert curve.taus == pytest.approx([0.02, 0.04])
    assert curve.unit == "deg/s"
    assert tumble.allan_deviation(x, 0.1 * unit.kHz, taus=[20 * unit.ms]).taus == pytest.approx([0.02])


def test_tables_of_texts_and_numbers_go_to_polars(imu_file):
    polars = pytest.importorskip("polars")
    random = np.random.default_rng(0).normal(size=20000)
    result = tumble.identify("allan_noise", tumble.from_arrays({"gyro.x": (random, "deg/s")}, rate=100))
    for table in result.tables.values():
        assert table.to_polars().shape == (len(table), len(table.columns))
        assert isinstance(table.to_polars(), polars.DataFrame)
