"""The archive of units from Python: what the command `tumble archive` shows."""

from __future__ import annotations

import json
import warnings

import pytest

import tumble
from tumble import archive


@pytest.fixture(scope="module")
def test(tree, tmp_path_factory):
    """A simulated test: its recording and its result."""
    folder = tmp_path_factory.mktemp("test")
    plan = tree / "plans/static_bias.toml"
    recording, result = folder / "bias.h5", folder / "bias.json"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tumble.TumbleWarning)
        tumble.simulate(plan, seed=1).save(recording)
        tumble.identify(plan, recording).save(result)
    return plan, recording, result


def test_it_keeps_results_once(test, tmp_path, command):
    plan, recording, result = test
    address = tmp_path / "lab.db"
    with archive.make(address, by="Li Wei") as lab:
        done = lab.ingest(result, recording, plan, by="Li Wei")
        assert (done["results"], done["files"], done["known"]) == (1, 2, 0)
        again = lab.ingest(tumble.load_result(result), by="Li Wei")
        assert (again["results"], again["known"]) == (0, 1)
    with archive.open(address) as lab:
        (unit,) = lab.units()
        assert lab.list() == lab.units(unit.model) and lab.units("other") == ()
        assert unit.results == 1
        record = lab.history(unit.serial)
        shown = lab.result(record["results"][0]["sha256"])
        assert shown.to_json() == tumble.load_result(result).to_json()
    assert json.loads(command("archive", "history", unit.serial, "--json", "--archive", address)) == record


def test_wrong_requests_say_what_is_wrong(test, tmp_path):
    with pytest.raises(tumble.UsageError, match="nothing"):
        archive.open(tmp_path / "nothing.db")
    lab = archive.make(tmp_path / "lab.db", by="Li Wei")
    with pytest.raises(tumble.UsageError):
        archive.make(tmp_path / "lab.db", by="Li Wei")
    with pytest.raises(tumble.UsageError, match="0173"):
        lab.history("0173")
    with pytest.raises(tumble.ArgumentTypeError, match="Results and paths"):
        lab.ingest(3)  # type: ignore[arg-type]
    with pytest.raises(tumble.UsageError, match="MODEL/SERIAL"):
        lab.ingest(test[2], unit="0173", by="Li Wei")
    with pytest.raises(tumble.FileError):
        lab.ingest(tmp_path / "gone.json", by="Li Wei")
    lab.close()
    with pytest.raises(tumble.UsageError, match="closed"):
        lab.units()


def test_population_is_that_of_the_command(tree, tmp_path, command):
    plan = tree / "plans/accelerometer_tumble.toml"
    address = tmp_path / "lab.db"
    with archive.make(address, by="Li Wei") as lab:
        for seed in range(1, 7):
            path = tmp_path / f"unit {seed}.toml"
            path.write_text(plan.read_text().replace('"demo-1"', f'"A-{seed}"'))
            made = tumble.load_plan(path).with_(**{"truth.bias": f"3.{seed} mg"})
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", tumble.TumbleWarning)
                result = tumble.identify(made, tumble.simulate(made, seed=seed))
            lab.ingest(result, unit=f"pendulous_accelerometer/A-{seed}", by="Li Wei")
        found = tumble.population("pendulous_accelerometer", archive=lab)
    words = ("population", "pendulous_accelerometer", "--archive", address, "--json")
    assert json.loads(command(*words)) == found.document
    without = tumble.population("pendulous_accelerometer", archive=address, without="A-6")
    assert json.loads(command(*words, "--without", "A-6")) == without.document != found.document
    parts = tumble.population("pendulous_accelerometer", archive=address, components="bias")
    assert json.loads(command(*words, "--components", "bias")) == parts.document
    with pytest.raises(tumble.UsageError, match="no result of the model"):
        tumble.population("gyro", archive=address)
