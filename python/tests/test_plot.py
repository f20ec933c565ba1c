"""Figures are those of the report: the same numbers, colours and notes, drawn by matplotlib."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest

import tumble

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

import matplotlib.pyplot  # noqa: E402
import tumble.plot  # noqa: E402


@pytest.fixture(autouse=True)
def _close():
    yield
    import matplotlib.pyplot

    matplotlib.pyplot.close("all")


@pytest.fixture(scope="module")
def noise(imu_file):
    return tumble.identify("allan_noise", imu_file)


@pytest.fixture(scope="module")
def head(tree):
    plan = tumble.load_plan(tree / "plans/accelerometer_tumble.toml")
    return tumble.identify(plan, tumble.simulate(plan, seed=3))


pytestmark = pytest.mark.filterwarnings("ignore::tumble.TumbleWarning")


def test_figures_are_those_of_the_report(noise, command, tmp_path):
    """The drawing is the one that the command writes, byte for byte, and that the page holds."""
    noise.save(tmp_path / "noise.json")
    command("report", tmp_path / "noise.json", "--figure", tmp_path / "n.svg")
    for number, figure in enumerate(noise.figures, 1):
        figure.save(tmp_path / "ours.svg")
        assert (tmp_path / "ours.svg").read_bytes() == (tmp_path / f"n-{number}.svg").read_bytes()
        assert figure._repr_svg_() == figure.to_svg()
        assert figure.to_svg().split("<g ", 1)[1].strip() in noise.to_html()
    with pytest.raises(tumble.UsageError, match=r"must end in \.svg"):
        noise.figures[0].save(tmp_path / "ours.pdf")


def test_description(noise):
    figure = noise.figures[0]
    text = json.loads(figure._drawing.__self__.to_json())[0]
    assert (figure.name, figure.x.unit, figure.y.unit) == (text["name"], text["x"]["unit"], text["y"]["unit"])
    for series, other in zip(figure.series, text["series"], strict=True):
        assert (series.name, series.colour, series.dashes) == (other["name"], other["colour"], other["dashes"])
        np.testing.assert_allclose(series.y, other["y"], rtol=1e-8)  # nine digits there
        assert not series.y.flags.writeable


def test_allan_draws_what_the_figure_holds(noise):
    axes = tumble.plot.allan(noise)
    together, *figures = noise.figures
    assert together.name == "Allan deviation, all together"
    for figure, ax in zip(figures, axes, strict=True):
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
        assert (ax.get_xlabel(), ax.get_ylabel()) == (figure.x.title, figure.y.title)
        assert [text.get_text() for text in ax.get_legend().get_texts()] == [one.name for one in figure.series]
        for line, series in zip(ax.lines, figure.series, strict=True):
            np.testing.assert_array_equal(line.get_xdata(), series.x)
            np.testing.assert_array_equal(line.get_ydata(), series.y)
            assert matplotlib.colors.to_hex(line.get_color()) == series.colour
        bars = ax.collections[0].get_segments()
        np.testing.assert_array_equal([bar[1][1] for bar in bars], figure.series[0].upper)


def test_one_axes_for_all(noise):
    ax = matplotlib.pyplot.figure().subplots()
    assert tumble.plot.allan(noise, ax) == (ax,) * 3
    assert len(ax.lines) == sum(len(figure.series) for figure in noise.figures[1:])
    assert tumble.plot.allan(noise, channel="gyro.z")[0].lines[0].get_label().startswith("gyro.z")


def test_curve_of_an_array():
    x = np.random.default_rng(1).standard_normal(2000)
    curve = tumble.allan_deviation(x, 100.0)
    (ax,) = tumble.plot.allan(curve)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), curve.deviation)


def test_residuals_and_polar(head):
    (flat,), (around,) = tumble.plot.residuals(head), tumble.plot.polar(head)
    figure = head.figures[0]
    np.testing.assert_allclose(around.lines[0].get_xdata(), np.deg2rad(figure.series[0].x), rtol=1e-12)
    np.testing.assert_array_equal(around.lines[0].get_ydata(), flat.lines[0].get_ydata())
    assert around.name == "polar"
    with pytest.raises(tumble.UsageError, match="argument ax: rectangular axes"):
        tumble.plot.polar(head, flat)


def test_budget(head):
    (ax,) = tumble.plot.budget(head)
    widths = np.array([bar.get_width() for bar in ax.patches]).reshape(-1, len(head.parameters))
    np.testing.assert_allclose(widths.sum(axis=0), 1.0, rtol=1e-9)
    largest = max(head.budget, key=lambda source: head.budget[source]["scale_factor"])
    drawn = ax.containers[int(np.argmax(widths[:, list(head.parameters).index("scale_factor")]))]
    assert drawn.get_label() == largest


def ramp(offset=0.0):
    """Two power-ups; the rate is the temperature's slope, so each cell must show it."""
    heat = np.concatenate([np.linspace(0.0, 60.0, 3600), np.linspace(60.0, 20.0, 3600)])
    slope = np.repeat([1.0, -2.0 / 3.0], 3600)
    channels = {"gyro": (slope + offset, "deg/h"), "temperature": (heat, "degC")}
    return tumble.from_arrays(channels, rate=1.0, marks=[("up", 0.0, 1), ("down", 3600.0, 2)])


def test_thermal():
    before, after = tumble.plot.thermal(ramp(), ramp(-0.5))
    cells = before.collections[0]
    rates = cells.get_offsets()[:, 1]
    np.testing.assert_allclose(cells.get_array(), np.where(rates > 0, 1.0, -2.0 / 3.0), rtol=1e-9)
    np.testing.assert_allclose(after.collections[0].get_array(), cells.get_array() - 0.5, rtol=1e-9)
    assert before.collections[0].get_clim() == after.collections[0].get_clim()
    with pytest.raises(tumble.UsageError, match="argument channel: 'x'"):
        tumble.plot.thermal(ramp(), channel="x")
    with pytest.raises(tumble.DataError, match="argument block"):
        tumble.plot.thermal(ramp(), block=3000.0)


def test_a_map_has_its_cells_and_points(noise, tmp_path):
    """Tables NAME_map and NAME_points of a result are one figure, with the same numbers in matplotlib."""
    noise.save(tmp_path / "map.json")
    text = json.loads((tmp_path / "map.json").read_text())
    columns = [
        {"name": "temperature", "unit": "degC"},
        {"name": "speed", "unit": "K/min"},
        {"name": "drift", "unit": "deg/h"},
    ]
    cells = [[t, r, t + 10 * r] for r in (-1.0, 1.0) for t in (0.0, 20.0, 40.0)]
    points = [[5.0, 1.0, 16.0], [30.0, -1.0, None]]
    for name, rows in (("thermal_map", cells[:-1]), ("thermal_points", points)):
        text["tables"].append({"name": name, "caption": "", "columns": columns, "rows": rows, "for_programs": True})
    (tmp_path / "map.json").write_text(json.dumps(text))
    figure = tumble.load_result(tmp_path / "map.json").figures[-1]
    assert (figure.name, figure.z.title) == ("drift over temperature and speed", "drift [deg/h]")
    np.testing.assert_allclose(figure.map.x, [-10, 10, 30, 50])
    np.testing.assert_allclose(figure.map.y, [-2, 0, 2])
    np.testing.assert_allclose(figure.map.values, [[-10, 10, 30], [10, 30, np.nan]], atol=1e-12)
    np.testing.assert_allclose(figure.series[0].z, [16, np.nan])
    ax = tumble.plot.figure(figure)
    mesh, dots = ax.collections
    np.testing.assert_allclose(np.ma.filled(mesh.get_array(), np.nan).ravel(), figure.map.values.ravel())
    assert mesh.get_clim() == dots.get_clim() == (-10.0, 30.0)
    assert ax.figure.axes[1].get_ylabel() == "drift [deg/h]"
    copied = pickle.loads(pickle.dumps(figure))
    np.testing.assert_array_equal(copied.map.values, figure.map.values)


@pytest.mark.parametrize("ending", ["pdf", "svg", "png"])
def test_files_hold_no_date(noise, tmp_path, ending):
    for name in ("a", "b"):
        tumble.plot.save(tumble.plot.allan(noise, channel="gyro.x"), tmp_path / f"{name}.{ending}")
    first = (tmp_path / f"a.{ending}").read_bytes()
    assert first == (tmp_path / f"b.{ending}").read_bytes()
    if ending == "svg":
        assert b"Allan deviation [deg/h]</text>" in first  # text, not outlines


def test_what_is_not_there(head):
    with pytest.raises(tumble.UsageError, match="no figure of Allan deviation; there are 'residuals of the positions'"):
        tumble.plot.allan(head)
    with pytest.raises(tumble.ArgumentTypeError, match="argument axes"):
        tumble.plot.save(3, "x.pdf")


def test_matplotlib_is_imported_when_used():
    script = "import sys, tumble, tumble.plot; assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", script], check=True)


def test_bad_arguments_are_refused_by_name(noise, tmp_path):
    axes = tumble.plot.allan(noise, channel="gyro.x")
    x = np.arange(1e5)
    test = tumble.from_arrays({"g": (x, "deg/h"), "temperature": (20 + 10 * np.sin(x / 1e4), "degC")}, rate=10)
    for says, call in {
        "argument ax: 5": lambda: tumble.plot.allan(noise, 5),
        "argument figure: 5": lambda: tumble.plot.figure(5),
        "argument name: 5": lambda: tumble.plot.figures(noise, 5),
        "argument axes": lambda: tumble.plot.save((), tmp_path / "a.svg"),
        "argument path: .*a.zz": lambda: tumble.plot.save(axes, tmp_path / "a.zz"),
        "argument cells: 0": lambda: tumble.plot.thermal(test, cells=0),
        "argument block: 'x'": lambda: tumble.plot.thermal(test, block="x"),
        "argument recording: 5": lambda: tumble.plot.thermal(test, 5),
        "argument compensated: 'g'": lambda: tumble.plot.thermal(test, tumble.from_arrays({"q": (x, "1")}, rate=10)),
    }.items():
        with pytest.raises(tumble.UsageError, match=says):
            call()
    with pytest.raises(tumble.FileError, match="nowhere"):
        tumble.plot.save(axes, tmp_path / "nowhere" / "a.svg")


def test_a_thermal_map_of_a_channel_with_missing_samples_has_colours():
    x = np.arange(1e5)
    values = np.where((x > 500) & (x < 30000), np.nan, x)
    channels = {"g": (values, "deg/h"), "temperature": (20 + 10 * np.sin(x / 1e4), "degC")}
    (ax,) = tumble.plot.thermal(tumble.from_arrays(channels, rate=10, missing="nan"))
    assert np.isfinite(ax.collections[0].get_clim()).all()


def test_the_legend_of_a_budget_is_inside_of_the_figure(tree):
    for name in ("rlg_north_finder", "north_finding"):
        (ax,) = tumble.plot.budget(tumble.predict(tree / f"plans/{name}.toml"))
        ax.figure.canvas.draw()
        legend, whole = ax.get_legend().get_window_extent(), ax.figure.bbox
        assert whole.x0 <= legend.x0 < legend.x1 <= whole.x1
        assert whole.y0 <= legend.y0
