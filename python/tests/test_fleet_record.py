"""One record in many files: the answer of one machine."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import tumble

pytest.importorskip("fsspec")
from tumble import fleet

SAMPLES, FILES, RATE = 600_000, 7, 200.0


def samples() -> np.ndarray:
    """White noise and a random walk [deg/s]."""
    rng = np.random.default_rng(5)
    walk = np.cumsum(rng.normal(0.0, 2e-5, SAMPLES))
    return rng.normal(0.0, 0.02, SAMPLES) + walk


@pytest.fixture(scope="module")
def record(tmp_path_factory) -> tuple[Path, Path, list[Path]]:
    """Folder, the record in one file, and in files of unequal lengths whose clock goes on."""
    folder = tmp_path_factory.mktemp("record")
    rate = samples()
    whole = folder / "whole.h5"
    tumble.from_arrays({"gyro.x": (rate, "deg/s")}, rate=RATE).save(whole)
    cuts = [0, 1, 50_003, 50_010, 200_000, 333_333, 590_001, SAMPLES]
    files = []
    for number, (first, last) in enumerate(itertools.pairwise(cuts)):
        files.append(folder / f"part {number}.h5")
        part = {"gyro.x": (rate[first:last], "deg/s")}
        tumble.from_arrays(part, rate=RATE, start=first / RATE).save(files[-1])
    return folder, whole, files


def one_machine(whole: Path) -> tumble.Result:
    return tumble.identify("allan_noise", whole, memory_limit=1000)


def same(a: tumble.Result, b: tumble.Result) -> None:
    """To 1e-9, parameters, uncertainties and curves."""
    assert list(a.parameters) == list(b.parameters) and a.parameters
    assert a.values == pytest.approx(b.values, rel=1e-9)
    assert [one.sd for one in a.parameters.values()] == pytest.approx(
        [one.sd for one in b.parameters.values()], rel=1e-9
    )
    scale = np.sqrt(np.outer(np.diag(b.covariance.values), np.diag(b.covariance.values)))
    assert np.max(np.abs(a.covariance.values - b.covariance.values) / scale) < 1e-9
    for mine, other in zip(a.curves, b.curves, strict=True):
        assert mine.y.values == pytest.approx(other.y.values, rel=1e-9)
    assert [one.code for one in a.findings if "files_joined" not in one.code] == [
        one.code for one in b.findings if one.code != "processed_in_blocks"
    ]


@pytest.mark.filterwarnings("ignore::tumble.TumbleWarning")
@pytest.mark.parametrize("executor", ["serial", "processes"])
def test_files_are_the_record(record, tmp_path, executor):
    _, whole, files = record
    found = fleet.record("allan_noise", files, tmp_path / "fleet", executor=executor, workers=2)
    same(found, one_machine(whole))
    assert len(found.provenance["inputs"]) == FILES
    assert "files_joined_by_clock" in [one.code for one in found.findings]


@pytest.mark.filterwarnings("ignore::tumble.TumbleWarning")
def test_a_gap_between_files_is_one_of_the_record(record, tmp_path):
    _, _, files = record
    gone = tmp_path / "gone.h5"
    rate = samples()
    rate[50_010:200_000] = np.nan
    tumble.from_arrays({"gyro.x": (rate, "deg/s")}, rate=RATE, missing="nan").save(gone)
    found = fleet.record("allan_noise", [*files[:3], *files[4:]], tmp_path / "fleet", executor="serial")
    whole = one_machine(gone)
    assert found.values == pytest.approx(whole.values, rel=1e-9)
    assert found.curves[0].y.values == pytest.approx(whole.curves[0].y.values, rel=1e-9)
    gap = next(one for one in found.findings if one.code == "gaps_between_files")
    assert "149990 samples" in gap.message


@pytest.mark.filterwarnings("ignore::tumble.TumbleWarning")
def test_a_record_goes_on(record, tmp_path):
    _, _, files = record
    out = tmp_path / "fleet"
    first = fleet.record("allan_noise", files, out, executor="serial")
    stamps = {path: path.stat().st_mtime_ns for path in out.rglob("*") if path.parent.name in ("parts", "pieces")}
    assert len(stamps) == 2 * FILES
    again = fleet.record("allan_noise", files, out, executor="serial")
    assert again.to_json() == first.to_json()
    assert stamps == {path: path.stat().st_mtime_ns for path in stamps}
    assert json.loads((out / "record.json").read_text())["method"] == "allan_noise"


def test_files_that_do_not_fit_are_named(record, tree, tmp_path):
    _, _, files = record
    other = tmp_path / "other.h5"
    tumble.from_arrays({"gyro.y": (np.random.default_rng(1).normal(size=1000), "deg/s")}, rate=RATE).save(other)
    with pytest.raises(tumble.DataError, match=r"gyro\.y"):
        fleet.record("allan_noise", [*files, other], tmp_path / "a", executor="serial")
    with pytest.raises(tumble.DataError, match="each once"):
        fleet.record(
            "allan_noise",
            [files[1], files[4], files[2], files[6]],
            tmp_path / "b",
            executor="serial",
        )
    damaged = tmp_path / "damaged.h5"
    damaged.write_bytes(files[1].read_bytes()[:2000])
    with pytest.raises(tumble.DataError) as raised:
        fleet.record(
            "allan_noise", [*files, damaged, tmp_path / "gone.h5"], tmp_path / "c", executor="serial", retries=0
        )
    assert "damaged.h5" in str(raised.value) and "gone.h5" in str(raised.value)
    with pytest.raises(tumble.UsageError, match="allan_noise"):
        fleet.record(tree / "plans/static_bias.toml", files, tmp_path / "d", executor="serial")
    with pytest.raises(tumble.UsageError, match="deviations"):
        fleet.record(
            "allan_noise", files, tmp_path / "e", executor="serial", settings={"deviations": "mdev"}, retries=0
        )
