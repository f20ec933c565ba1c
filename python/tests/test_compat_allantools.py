"""tumble.compat.allantools beside AllanTools itself: 1e-9 of every number it returns."""

from __future__ import annotations

import contextlib
import inspect
import io

import numpy as np
import pytest
from tumble.compat import allantools as ours

import tumble

QUICK = ["adev", "oadev", "mdev", "tdev", "hdev", "ohdev", "totdev", "mtie", "tierms"]
SLOW = ["pdev", "mtotdev", "ttotdev", "htotdev", "theo1"]  # loops of Python there
NOISES = {"white phase": 0, "flicker phase": -1, "white frequency": -2, "flicker frequency": -3, "random walk": -4}
TAUS = [None, [], "octave", "decade", "all", "log10", [0.4, 1.0, 1.3, 2.0, 7.0, 1e6], np.array([4.0, 2.0, 2.0])]
RATE = 2.5


@pytest.fixture(scope="module")
def theirs():
    return pytest.importorskip("allantools")


@pytest.fixture(autouse=True)
def _quiet():
    """AllanTools prints, and divides by zero on the way."""
    with contextlib.redirect_stdout(io.StringIO()), np.errstate(all="ignore"):
        yield


def phase(points, power, seed=1):
    """Phase with a power spectral density of f^power."""
    spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(4 * points))
    frequency = np.maximum(np.fft.rfftfreq(4 * points), 0.25 / points)
    return np.fft.irfft(spectrum * frequency ** (power / 2.0))[:points]


def answer(module, name, *arguments, **options):
    """What is returned; or that nothing remained."""
    try:
        return getattr(module, name)(*arguments, **options)
    except UserWarning:
        return None


def agree(theirs, name, *arguments, **options):
    expected, found = (answer(module, name, *arguments, **options) for module in (theirs, ours))
    assert (expected is None) == (found is None), (name, options)
    if expected is not None:
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=0.0, err_msg=f"{name} {options}")


@pytest.mark.parametrize("data_type", ["phase", "freq"])
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("name", QUICK)
def test_equal(theirs, name, noise, data_type):
    for points in (100, 101, 255, 256, 257):
        x = phase(points, NOISES[noise])
        for taus in TAUS:
            agree(theirs, name, x, rate=RATE, data_type=data_type, taus=taus)


@pytest.mark.parametrize("data_type", ["phase", "freq"])
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("name", SLOW)
def test_equal_to_the_loops(theirs, name, noise, data_type):
    for points in (64, 101):
        agree(theirs, name, phase(points, NOISES[noise]), rate=RATE, data_type=data_type, taus="decade")
    for taus in TAUS:
        agree(theirs, name, phase(41, NOISES[noise]), rate=RATE, data_type=data_type, taus=taus)


@pytest.mark.parametrize("name", QUICK + SLOW)
def test_short_and_plain(theirs, name):
    for points in range(2, 12):
        agree(theirs, name, phase(points, 0))
        agree(theirs, name, phase(points, 0), data_type="freq")


@pytest.mark.parametrize("name", ["adev", "oadev", "mdev", "ohdev", "totdev", "mtie"])
def test_long(theirs, name):
    """On all threads, and every factor by transforms."""
    x = phase(30_001, -2)
    agree(theirs, name, x, rate=100.0)
    if name in ("oadev", "ohdev"):
        agree(theirs, name, x[:5001], rate=100.0, taus="all")


@pytest.mark.parametrize("name", QUICK)
def test_integers_lists_and_strides(theirs, name):
    x = np.rint(1000.0 * phase(200, 0)).astype(np.int32)
    agree(theirs, name, x.astype(np.float64)[::2])
    agree(theirs, name, [float(value) for value in x])
    np.testing.assert_array_equal(getattr(ours, name)(x), getattr(ours, name)(x.astype(np.float64)))


@pytest.mark.parametrize("name", QUICK)
def test_missing_at_the_ends_of_frequency(theirs, name):
    x = phase(120, -2)
    x[:3], x[-2:] = np.nan, np.nan
    agree(theirs, name, x, data_type="freq")


@pytest.mark.parametrize("data_type", ["phase", "freq"])
@pytest.mark.parametrize("noisetype", ["wp", "wf", "fp", "pink"])
def test_gaps(theirs, noisetype, data_type):
    for gaps in ([], [0, 1], [50], list(range(30, 60)), list(range(3, 400, 7))):
        x = phase(401, -2)
        x[gaps] = np.nan
        for taus in TAUS:
            agree(theirs, "gradev", x, rate=RATE, data_type=data_type, taus=taus, ci=0.9, noisetype=noisetype)
    agree(theirs, "gradev", phase(11, 0), taus=[1.0, 4.0, 5.0], ci=0.5, noisetype=noisetype)


def test_two_and_three_series(theirs):
    a, b, c = (phase(300, -1, seed) for seed in (1, 2, 3))
    for data_type in ("phase", "freq"):
        for taus in TAUS:
            agree(theirs, "gcodev", a, b, rate=RATE, data_type=data_type, taus=taus)
    hats = [m.three_cornered_hat_phase(a - b, b - c, c - a, RATE, "decade", m.oadev) for m in (theirs, ours)]
    for one, other in zip(*hats, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-9)
    agree(theirs, "mtie_phase_fast", a)


def test_conversions(theirs):
    x = phase(50, -2)
    x[[0, 1, 49]] = np.nan
    for name, arguments in {
        "trim_data": (x,),
        "frequency2phase": (x, RATE),
        "phase2frequency": (x[2:], RATE),
        "phase2radians": (x, 1e6),
        "frequency2fractional": (x[2:-1] + 1e3,),
        "tau_reduction": (np.arange(1, 2000), RATE, 7),
    }.items():
        agree(theirs, name, *arguments)
    for taus in TAUS:
        for options in ({}, {"even": True}, {"maximum_m": 12.5}):
            agree(theirs, "tau_generator", x, RATE, taus=taus, **options)


def test_limits(theirs):
    for edf in (0.7, 3.0, 250.0):
        for ci in (0.1, 0.6826894921370859, 0.95, 1.4, 3.0):
            expected = theirs.confidence_interval(2.5, edf, ci)
            np.testing.assert_allclose(ours.confidence_interval(2.5, edf, ci), expected, rtol=1e-9)
    for alpha in (2, 1, 0, -1, -2, 3):
        for m in (1, 2, 40):
            assert ours.edf_simple(1000, m, alpha) == pytest.approx(theirs.edf_simple(1000, m, alpha), rel=1e-12)


@pytest.mark.parametrize("name", [*QUICK, *SLOW, "gradev", "gcodev", "three_cornered_hat_phase", "tau_generator"])
def test_same_arguments_and_defaults(theirs, name):
    expected, found = (inspect.signature(getattr(module, name)).parameters for module in (theirs, ours))
    assert {key: one.default for key, one in found.items()} == {key: one.default for key, one in expected.items()}


def test_dataset(theirs, tmp_path):
    made = []
    for module in (theirs, ours):
        one = module.Dataset(phase(200, -1), rate=RATE, data_type="freq", taus="decade")
        one.compute("ohdev")
        one.write_results(tmp_path / "table.txt", digits=6, header_params={"sensor": 1})
        made.append((one, (tmp_path / "table.txt").read_text().splitlines()))
    assert made[1][1] == made[0][1][1:]  # theirs begins with the name of the program
    assert made[1][0].out["stat_id"] == "ohdev"
    with pytest.raises(tumble.UsageError, match="argument function: 'noise'"):
        made[1][0].compute("noise")


@pytest.mark.parametrize(
    ("arguments", "error", "says"),
    [
        ({"data": [1.0, np.nan, 2.0, 5.0]}, tumble.DataError, "argument data: value 1 is not a finite number"),
        ({"data": [1.0, 2.0, np.inf, 5.0]}, tumble.DataError, "argument data: value 2"),
        ({"data": np.ones((4, 2))}, tumble.UsageError, "argument data: an array with 2 dimensions"),
        ({"data": ["a", "b"]}, tumble.ArgumentTypeError, "argument data"),
        ({"data": []}, UserWarning, "argument taus: no averaging time has two terms in 0 values"),
        ({"data": np.arange(9.0), "taus": [100.0]}, UserWarning, "in 9 values"),
        ({"data": np.arange(9.0), "taus": "weekly"}, tumble.UsageError, "argument taus: 'weekly'"),
        ({"data": np.arange(9.0), "taus": ["x"]}, tumble.ArgumentTypeError, "argument taus"),
        ({"data": np.arange(9.0), "rate": 0.0}, tumble.UsageError, "argument rate: 0"),
        ({"data": np.arange(9.0), "data_type": "rate"}, tumble.UsageError, "argument data_type: 'rate'"),
    ],
)
def test_bad_input(arguments, error, says):
    with pytest.raises(error, match=says):
        ours.oadev(**arguments)


def test_what_is_not_here():
    with pytest.raises(AttributeError, match="has no 'psd2allan'"):
        ours.psd2allan  # noqa: B018
