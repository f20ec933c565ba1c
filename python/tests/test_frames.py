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
    with pytest.raises(tumble.UsageError, match="no column 't'"):
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
