"""Methods written in Python."""

from __future__ import annotations

import numpy as np
import pytest

import tumble


def mean_of(recordings, settings):
    x = recordings[0]["gyro.x"].in_("deg/h")
    return {"bias": (x.mean(), "deg/h")}, [[settings["widen"] ** 2 * x.var(ddof=1) / len(x)]]


def trial(seed):
    x = np.random.default_rng(seed).normal(3.0, 0.5, 400)
    return [tumble.from_arrays({"gyro.x": (x, "deg/h")}, rate=10)], {"bias": 3.0}


METHOD = tumble.Method("my_bias", "mean", mean_of, trial, {"widen": 1.0})


def test_a_method_of_python_is_identified(tmp_path):
    recordings, _ = trial(1)
    result = tumble.identify(METHOD, *recordings)
    x = recordings[0]["gyro.x"].in_("deg/h")
    assert result.parameters["bias"].value == pytest.approx(x.mean(), rel=1e-12)
    assert result.parameters["bias"].sd == pytest.approx(x.std(ddof=1) / 20, rel=1e-12)
    assert result.provenance["inputs"][0]["sha256"] == recordings[0].sha256
    result.save(tmp_path / "r.html")
    assert "my_bias" in (tmp_path / "r.html").read_text()


def test_honest_intervals_hold_the_truth_and_narrow_ones_are_found():
    (honest,) = tumble.coverage(METHOD, seeds=100)
    assert honest.holds
    (narrow,) = tumble.coverage(METHOD, seeds=100, settings={"widen": 0.3})
    assert not narrow.holds  # intervals of 0.6 sd hold the truth in 44 %


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (({"a": (1.0, "1")}, [[1.0, 0.0]]), r"has the shape \(1, 2\)"),
        (({"a": (1.0, "1"), "b": (1.0, "1")}, [[1.0, 2.0], [2.0, 1.0]]), "negative eigenvalue"),
        (({"a": (1.0, "1")}, [[np.nan]]), "not finite"),
        (3, "accepted is"),
    ],
)
def test_answers_that_are_none_are_refused(answer, says):
    method = tumble.Method("bad", "", lambda recordings, settings: answer)
    with pytest.raises(tumble.UsageError, match=says):
        tumble.identify(method, *trial(1)[0])


def test_wrong_settings_and_missing_trials_are_refused():
    with pytest.raises(tumble.UsageError, match="unknown settings wide; accepted are widen"):
        tumble.identify(METHOD, *trial(1)[0], settings={"wide": 2})
    with pytest.raises(tumble.UsageError, match="has no trial"):
        tumble.coverage(METHOD._replace(trial=None))
