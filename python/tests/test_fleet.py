"""Many units: the same table from every executor, whatever is killed, changes or is damaged on the way."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import tumble

pytest.importorskip("pyarrow")
pytest.importorskip("fsspec")
from tumble.fleet._engines import Processes

from tumble import fleet

UNITS = 8


@pytest.fixture(scope="module")
def units(tmp_path_factory) -> Path:
    """Eight noise records with awkward names."""
    import numpy as np

    folder = tmp_path_factory.mktemp("units")
    for number in range(UNITS):
        rate = np.random.default_rng(number).normal(0.0, 0.02, 4000)
        name = ["陀螺 {}", "unit {}", "Größe-{}", "u{}"][number % 4].format(number)
        tumble.from_arrays({"gyro.x": (rate, "deg/s")}, rate=100).save(folder / f"{name}.h5")
    return folder


@pytest.fixture(scope="module")
def serial_table(units, tmp_path_factory):
    return fleet.run("allan_noise", units, tmp_path_factory.mktemp("serial") / "fleet", executor="serial").table()


def computed(out: Path, work: str = "ends") -> list[str]:
    """Keys of the results that workers finished (or began), each time that they did."""
    lines = [json.loads(line) for log in (out / "log").glob("work-*.jsonl") for line in log.read_text().splitlines()]
    return [line["key"] for line in lines if line["work"] == work]


def test_the_table_is_in_order_and_knows_no_time(units, serial_table):
    names = serial_table["recording"].to_pylist()
    assert len(names) == UNITS and names == sorted(names)
    assert set(serial_table["status"].to_pylist()) == {"ok"}
    assert serial_table.schema.field("gyro.x.angle_random_walk").metadata == {b"unit": b"deg/sqrt(h)"}
    assert not {"time", "host", "process", "seconds"} & set(serial_table.column_names)
    sd = serial_table["gyro.x.angle_random_walk_sd"].to_pylist()
    truth = 0.02 * 60 / 10
    for value, error in zip(serial_table["gyro.x.angle_random_walk"].to_pylist(), sd, strict=True):
        assert abs(value - truth) < 5 * error


def test_processes_give_the_same_table(units, serial_table, tmp_path):
    made = fleet.run("allan_noise", units, tmp_path / "fleet", workers=2)
    assert made.table().equals(serial_table)
    log = made.log().to_pylist()
    assert sum(line.get("status") == "ok" for line in log) == UNITS
    assert all(line["host"] and line["process"] for line in log)
    assert str(made.status()) == f"{UNITS} recordings: {UNITS} done, 0 with an error"


def test_a_run_goes_on_and_computes_nothing_twice(units, serial_table, tmp_path):
    out = tmp_path / "fleet"
    fleet.run("allan_noise", sorted(units.iterdir())[:3], out, executor="serial")
    made = fleet.run("allan_noise", units, out, executor="serial")
    assert made.table().equals(serial_table)
    assert sorted(computed(out)) == sorted(set(computed(out)))
    os.utime(next(units.iterdir()))  # the bytes are the same: read again, not computed again
    parts = parquet_files(out)
    fleet.run("allan_noise", units, out, executor="serial")
    assert len(computed(out)) == UNITS and parquet_files(out) == parts, "no row is added twice"


def test_a_dask_client_gives_the_same_table(units, serial_table, tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    import dask

    monkeypatch.setitem(dask.config.get("distributed.scheduler"), "allowed-failures", 1)  # a worker less to restart
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        made = fleet.run("allan_noise", units, tmp_path / "fleet", executor=client)
        assert made.table().equals(serial_table)
        many = _with_killer(units, tmp_path)
        killer = fleet.run("allan_noise", many, tmp_path / "killer", executor=client, retries=0)
    assert list(killer.errors()) == [str(tmp_path / "poison/poison.h5")]


def test_any_executor_with_submit_works(units, serial_table, tmp_path):
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(2) as pool:
        made = fleet.run("allan_noise", units, tmp_path / "fleet", executor=pool, workers=2)
    assert made.table().equals(serial_table)


def _with_killer(units: Path, folder: Path) -> list[Path]:
    """All units, and a recording that ends the process that reads it (see sitecustomize below)."""
    poison = folder / "poison/poison.h5"
    poison.parent.mkdir()
    shutil.copy(next(units.iterdir()), poison)
    with open(poison, "ab") as file:
        file.write(b"poison")
    return [*units.iterdir(), poison]


@pytest.fixture(autouse=True)
def poison(tmp_path, monkeypatch):
    """In workers the hash of a file called poison.h5 ends the process, as a reader might that runs out of memory."""
    code = """
import os, signal, sys, time
from importlib import abc, util
class Finder(abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name != "tumble.fleet._task":
            return None
        sys.meta_path.remove(self)
        spec = util.find_spec(name)
        run = spec.loader.exec_module
        def poisoned(module):
            run(module)
            hashed = module.sha256_of
            def sha256_of(path):
                if path.endswith("poison.h5"):
                    os.kill(os.getpid(), signal.SIGKILL)
                if path.endswith("poison-slow.h5"):
                    time.sleep(600)
                return hashed(path)
            module.sha256_of = sha256_of
        spec.loader.exec_module = poisoned
        return spec
sys.meta_path.insert(0, Finder())
"""
    folder = tmp_path / "site"
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(code)
    monkeypatch.setenv("PYTHONPATH", f"{folder}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.syspath_prepend(str(folder))


def test_a_recording_that_kills_its_worker_is_a_row_with_its_error(units, serial_table, tmp_path):
    made = fleet.run("allan_noise", _with_killer(units, tmp_path), tmp_path / "fleet", workers=2, retries=1)
    assert made.errors() == {
        str(tmp_path / "poison/poison.h5"): "the worker was ended by signal 9 (often: out of memory), 2 times"
    }
    good = made.table().filter([status == "ok" for status in made.table()["status"].to_pylist()])
    assert good.drop_columns(["recording"]).equals(serial_table.drop_columns(["recording"]))


DRIVER = """
import sys
from tumble import fleet
fleet.run("allan_noise", sys.argv[1], sys.argv[2], workers=2)
"""


@pytest.mark.parametrize("rows", [0, 2, 5])
def test_a_driver_that_is_killed_loses_nothing(units, serial_table, tmp_path, rows):
    out = tmp_path / "fleet"
    driver = subprocess.Popen([sys.executable, "-c", DRIVER, str(units), str(out)], stdout=subprocess.PIPE)
    wait_for_rows(out, rows)
    driver.send_signal(signal.SIGKILL)
    driver.communicate(timeout=60)  # until the workers too have ended, which hold the other end of this pipe
    before = computed(out)
    assert fleet.run("allan_noise", units, out, executor="serial").table().equals(serial_table)
    after = computed(out)
    assert (len(after) == len(set(after)) == UNITS and after[: len(before)]) or not before


def wait_for_rows(out: Path, rows: int) -> None:
    deadline = time.monotonic() + 60
    while len(list(out.glob("rows/*/*/*.json"))) < rows and time.monotonic() < deadline:
        time.sleep(0.01)


@pytest.mark.parametrize("rows", [1, 4])
def test_a_worker_that_is_killed_costs_its_own_task_only(units, serial_table, tmp_path, rows, monkeypatch):
    pools: list[Processes] = []
    made = Processes.__init__

    def noted(pool, *arguments):
        made(pool, *arguments)
        pools.append(pool)

    monkeypatch.setattr(Processes, "__init__", noted)
    done = []

    def kill(_, what):
        done.append(what)
        if len(done) == rows:
            os.kill(pools[0].processes()[0], signal.SIGKILL)

    table = fleet.run("allan_noise", units, tmp_path / "fleet", workers=2, progress=kill).table()
    assert table.equals(serial_table)
    begun = computed(tmp_path / "fleet", "begins")
    assert len(set(begun)) == UNITS and len(begun) <= UNITS + 1


def test_what_data_are_to_blame_for_is_a_row(units, tmp_path):
    damaged, empty, gone = tmp_path / "damaged.h5", tmp_path / "empty.csv", tmp_path / "gone.h5"
    damaged.write_bytes(next(units.iterdir()).read_bytes()[:1000])
    empty.write_bytes(b"")
    good = next(units.iterdir())
    made = fleet.run("allan_noise", [damaged, empty, gone, good], tmp_path / "fleet", executor="serial", retries=0)
    errors = made.errors()
    assert sorted(errors) == sorted(map(str, [damaged, empty, gone]))
    assert "is empty" in errors[str(empty)]
    assert made.status().ok == 1
    with pytest.raises(tumble.UsageError, match="is empty"):
        made.result(str(empty))
    assert made.result(str(good)).method == "allan_noise"
    again = fleet.run("allan_noise", [damaged, good], tmp_path / "fleet", executor="serial")
    assert len(computed(tmp_path / "fleet")) == 2, "a damaged file is not reduced again"
    assert again.status().errors == 3
    fleet.run("allan_noise", [damaged], tmp_path / "fleet", executor="serial", retry_errors=True)
    assert len(computed(tmp_path / "fleet")) == 3


def test_wrong_requests_say_what_is_wrong(units, tree, tmp_path):
    with pytest.raises(tumble.UsageError, match="there is none"):
        fleet.run("allan_noise", [], tmp_path / "fleet")
    with pytest.raises(tumble.UsageError, match="finds no file"):
        fleet.run("allan_noise", str(tmp_path / "*.none"), tmp_path / "fleet")
    with pytest.raises(tumble.UsageError, match="there is no file nowhere$"):
        fleet.run("allan_noise", "nowhere", tmp_path / "fleet")
    assert not (tmp_path / "fleet").exists()
    one = next(units.iterdir())
    with pytest.raises(tumble.UsageError, match="given twice"):
        fleet.run("allan_noise", [one, one], tmp_path / "fleet")
    with pytest.raises(tumble.UsageError, match="accepted are serial, processes and dask"):
        fleet.run("allan_noise", one, tmp_path / "fleet", executor="spark")
    shutil.rmtree(tmp_path / "fleet", ignore_errors=True)
    fleet.run("allan_noise", one, tmp_path / "fleet", executor="serial")
    with pytest.raises(tumble.UsageError, match="another plan or other settings"):
        fleet.run("allan_noise", one, tmp_path / "fleet", executor="serial", settings={"confidence": 0.9})
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.txt").write_text("mine")
    with pytest.raises(tumble.UsageError, match="holds no fleet"):
        fleet.run("allan_noise", one, other, executor="serial")
    with pytest.raises(tumble.UsageError, match="holds no fleet"):
        fleet.Fleet(other)
    with pytest.raises(tumble.UsageError, match="regular expression"):
        fleet.run("allan_noise", one, tmp_path / "new", serial="(")


def test_the_same_bytes_under_two_names_count_once(units, tmp_path):
    folder = tmp_path / "units"
    shutil.copytree(units, folder)
    first = min(folder.iterdir())
    shutil.copy(first, folder / "zz copy.h5")
    made = fleet.run("allan_noise", folder, tmp_path / "fleet", executor="serial")
    status = made.status()
    assert (status.ok, status.duplicates) == (UNITS, 1)
    row = next(row for row in made.table().to_pylist() if row["status"] == "duplicate")
    assert (row["recording"], row["error"]) == (str(folder / "zz copy.h5"), f"the same bytes as {first}")


def test_a_recording_that_changes_is_read_again(units, tmp_path, monkeypatch):
    path = tmp_path / "grows.h5"
    shutil.copy(next(units.iterdir()), path)
    from tumble.fleet import _task

    compute = _task._compute
    times = []

    def changed(*arguments):
        row = compute(*arguments)
        times.append(1)
        if len(times) == 1:
            os.utime(path, (1, 1))
        return row

    monkeypatch.setattr(_task, "_compute", changed)
    made = fleet.run("allan_noise", path, tmp_path / "fleet", executor="serial")
    assert len(times) == 2 and made.status().ok == 1
    assert "has changed while it was read" in str(made.log().to_pylist())


def test_results_of_another_version_are_not_used(units, tmp_path, monkeypatch):
    from tumble import _tumble

    out = tmp_path / "fleet"
    monkeypatch.setattr(_tumble, "version", "0.0.1")
    fleet.run("allan_noise", sorted(units.iterdir())[:2], out, executor="serial")
    monkeypatch.undo()
    made = fleet.run("allan_noise", sorted(units.iterdir())[:3], out, executor="serial")
    assert made.status().ok == 3 and made.status().other_versions == 2
    assert set(made.table()["tumble"].to_pylist()) == {tumble.__version__}


def test_a_full_disk_ends_the_run_and_says_so(units, tmp_path):
    out = tmp_path / "fleet"
    out.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(out)], check=False, capture_output=True
    ).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        with pytest.raises(tumble.FileError, match="No space left"):
            fleet.run("allan_noise", units, out, executor="serial")
    finally:
        subprocess.run(["umount", str(out)], check=True)


def test_an_object_store_is_a_folder_too(units, serial_table, tmp_path):
    pytest.importorskip("s3fs")
    server = pytest.importorskip("moto.server").ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        host, port = server.get_host_and_port()
        environment = {
            "AWS_ENDPOINT_URL": f"http://{host}:{port}",
            "AWS_ACCESS_KEY_ID": "test",
            "AWS_SECRET_ACCESS_KEY": "test",
            "AWS_DEFAULT_REGION": "us-east-1",
        }
        with pytest.MonkeyPatch.context() as patch:
            for name, value in environment.items():
                patch.setenv(name, value)
            import s3fs

            store = s3fs.S3FileSystem()
            store.mkdir("lab")
            store.put(str(units), "lab/units", recursive=True)
            made = fleet.run("allan_noise", "s3://lab/units/*.h5", "s3://lab/fleet", workers=2)
            columns = [name for name in serial_table.column_names if name != "recording"]
            assert made.table().select(columns).equals(serial_table.select(columns))
            assert made.table()["recording"].to_pylist()[0].startswith("s3://lab/units/")
            assert fleet.Fleet("s3://lab/fleet").status().ok == UNITS
            assert "tumble-fleet-" not in made.result(made.table()["recording"].to_pylist()[0]).to_json()
            again = fleet.run("allan_noise", "s3://lab/units/*.h5", "s3://lab/fleet", executor="serial")
            assert not any(line.get("known") is False for line in again.log().to_pylist()[UNITS + 4 :])
    finally:
        server.stop()


def test_the_dataset_is_plain_parquet(units, serial_table, tmp_path):
    import pyarrow.dataset as ds

    fleet.run("allan_noise", units, tmp_path / "fleet", executor="serial")
    table = ds.dataset(tmp_path / "fleet/table", partitioning="hive").to_table()
    assert table.num_rows == UNITS
    assert sorted(table["gyro.x.angle_random_walk"].to_pylist()) == sorted(
        serial_table["gyro.x.angle_random_walk"].to_pylist()
    )


def test_the_command_line_runs_and_shows(units, tmp_path):
    out = str(tmp_path / "fleet")
    command = [sys.executable, "-m", "tumble.fleet"]
    done = subprocess.run(
        [*command, "run", "allan_noise", str(units), "-o", out, "--workers", "2"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, f"{UNITS} recordings: {UNITS} done, 0 with an error\n"), done.stderr
    done = subprocess.run([*command, "status", out], capture_output=True, text=True, check=False)
    assert done.stdout == f"{UNITS} recordings: {UNITS} done, 0 with an error\n"
    done = subprocess.run(
        [*command, "run", "allan_noise", str(tmp_path / "*.none"), "-o", out],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2 and done.stderr.startswith("error: argument recordings:")


@pytest.mark.filterwarnings("ignore::tumble.TumbleWarning")
def test_recordings_of_an_archive(tree, tmp_path):
    from tumble import archive

    plan = tree / "plans/static_bias.toml"
    with archive.make(tmp_path / "lab.db", by="Li Wei") as lab:
        for seed in (1, 2):
            recording = tmp_path / f"test {seed}.h5"
            tumble.simulate(plan, seed=seed).save(recording)
            lab.ingest(tumble.identify(plan, recording), recording, by="Li Wei")
        recordings = lab.recordings()
        assert len(recordings) == 2
        made = fleet.run(plan, recordings, tmp_path / "fleet", workers=2)
    assert made.status().ok == 2, made.errors()
    assert set(made.table()["serial"].to_pylist()) == {recordings[0].serial}
    again = fleet.run(plan, recordings, tmp_path / "fleet", executor="serial")
    assert len(computed(tmp_path / "fleet")) == 2 and again.status().ok == 2


@pytest.fixture(scope="module")
def production(tmp_path_factory) -> fleet.Fleet:
    """Thirty gyros whose random walks differ by 5 %; the last one does not belong to them."""
    import numpy as np

    folder = tmp_path_factory.mktemp("production")
    spread = np.random.default_rng(0).normal(1.0, 0.05, 30)
    spread[-1] = 2.0
    for number, factor in enumerate(spread):
        rate = np.random.default_rng(100 + number).normal(0.0, 0.02 * factor, 20_000)
        tumble.from_arrays({"gyro.x": (rate, "deg/s")}, rate=100).save(folder / f"SN{number:03}.h5")
    shutil.copy(folder / "SN000.h5", folder / "SN900.h5")
    return fleet.run("allan_noise", folder, tmp_path_factory.mktemp("fleet") / "out", executor="serial")


NAME = "gyro.x.angle_random_walk"


def test_the_summary_says_what_the_units_have_in_common(production, tmp_path):
    limits = {NAME: (None, "0.135 deg/sqrt(h)")}
    found = production.summary(limits=limits)
    mean, spread = found.parameters[f"{NAME}_mean"], found.parameters[f"{NAME}_unit_sd"]
    # 29 units of mean 0.12 and sd 0.006 deg/sqrt(h): known to 0.006/sqrt(29), and 13 %
    assert abs(mean.value - 0.12) < 4 * mean.sd + 0.01
    outliers = found.tables[f"{NAME} outliers"]
    assert [row[0] for row in outliers.rows] == ["allan_noise/SN029"]
    assert spread.value > 0.003
    risk = found.tables[f"{NAME} risk"]
    rules = {row[0]: row for row in risk.rows}
    assert set(rules) == {"simple", "guarded", "fleet, 0.5 %"}
    # A guard band takes from the consumer's risk and gives to the producer's; that of the fleet keeps its target.
    assert rules["guarded"][3] < rules["simple"][3] and rules["guarded"][4] > rules["simple"][4]
    assert rules["fleet, 0.5 %"][3] <= 0.5 * (1 + 1e-6)
    assert found.parameters[f"{NAME}_capability"].value > 0
    codes = [one.code for one in found.findings]
    assert "same_recording_of_units" in codes
    assert f"{NAME}, distribution" in {curve.figure for curve in found.curves}
    production.report(tmp_path / "fleet.html", parameters=[NAME], limits=limits)
    page = (tmp_path / "fleet.html").read_text()
    assert "SN029" in page and "<svg" in page


def test_a_summary_has_the_last_result_of_a_recording_that_changed(units, tmp_path):
    folder = tmp_path / "units"
    shutil.copytree(units, folder)
    fleet.run("allan_noise", folder, tmp_path / "fleet", executor="serial")
    first, second, *_ = sorted(folder.iterdir())
    tumble.from_arrays({"gyro.x": (tumble.read(second)["gyro.x"].values * 3, "rad/s")}, rate=100).save(first)
    made = fleet.run("allan_noise", folder, tmp_path / "fleet", executor="serial")
    assert len(computed(tmp_path / "fleet")) == UNITS + 1
    assert made.summary().fit.observations == UNITS == made.table().num_rows


def test_the_program_gives_the_same_summary(production, command):
    said = command("fleet", "summary", production.folder, "--json", "--max", f"{NAME}=0.135 deg/sqrt(h)")
    assert json.loads(said) == production.summary(limits={NAME: (None, "0.135 deg/sqrt(h)")}).document


def test_wrong_summaries_say_what_is_wrong(production, units, tmp_path):
    with pytest.raises(tumble.UsageError, match="did you mean"):
        production.summary(["gyro.x.angle_random_wok"])
    with pytest.raises(tumble.UsageError):
        production.summary(limits={NAME: ("1 mg", None)})
    with pytest.raises(tumble.UsageError, match="is not below"):
        production.summary(limits={NAME: ("2 deg/sqrt(h)", "1 deg/sqrt(h)")})
    two = fleet.run("allan_noise", sorted(units.iterdir())[:2], tmp_path / "two", executor="serial")
    with pytest.raises(tumble.DataError, match="needs 3 or more"):
        two.summary()


def test_results_go_into_an_archive(production, tmp_path):
    from tumble import archive

    address = str(tmp_path / "lab.db")
    archive.make(address, by="Li Wei").close()
    assert production.to_archive(address, by="Li Wei") == {"results": 30, "known": 0}
    assert production.to_archive(address, by="Li Wei") == {"results": 0, "known": 30}


def test_a_worker_that_takes_too_long_is_ended(units, tmp_path):
    """A recording that gives no answer (a file system that hangs, an endless loop) is a row with its error."""
    slow = tmp_path / "slow/poison-slow.h5"
    slow.parent.mkdir()
    shutil.copy(next(units.iterdir()), slow)
    with open(slow, "ab") as file:
        file.write(b"slow")
    made = fleet.run("allan_noise", slow, tmp_path / "fleet", workers=1, retries=1, timeout=1)
    assert made.errors() == {str(slow): "the worker was ended: it gave no answer within 1 s, 2 times"}
    again = fleet.run("allan_noise", [*units.iterdir(), slow], tmp_path / "fleet", executor="serial")
    assert again.status().ok == UNITS + 1 and not again.errors(), "the next run repeats it"
    with pytest.raises(tumble.UsageError, match="only executor='processes'"):
        fleet.run("allan_noise", slow, tmp_path / "serial", executor="serial", timeout=1)


def parquet_files(out: Path) -> list[Path]:
    return sorted(out.glob("table/*/*/*.parquet"))


def test_a_folder_is_compacted_and_goes_on(units, serial_table, tmp_path):
    out = tmp_path / "fleet"
    names = sorted(units.iterdir())
    for last in (2, 5, UNITS):
        fleet.run("allan_noise", names[:last], out, executor="serial")
    damaged = tmp_path / "damaged.h5"
    damaged.write_bytes(names[0].read_bytes()[:1000])
    made = fleet.run("allan_noise", [*names, damaged], out, executor="serial")
    before = made.table()
    removed = made.compact()
    assert removed == (4, 0) and made.compact() == (0, 0)
    assert len(list(out.glob("rows/*/*/*.json"))) == 1, "that of the damaged one, which has no result"
    assert len(parquet_files(out)) == 1
    assert made.table().equals(before)
    assert made.status().ok == UNITS and made.status().errors == 1
    count = len(computed(out))
    os.utime(names[0])
    again = fleet.run("allan_noise", [*names, damaged], out, executor="serial", retry_errors=True)
    assert again.table().equals(before)
    assert len(computed(out)) == count + 1, "only the damaged one is reduced again"


def test_a_compaction_that_is_killed_loses_nothing(units, tmp_path, monkeypatch):
    """Killed before each removal in turn: the table stays, and the next call ends the work."""
    from tumble.fleet._store import Store

    whole = tmp_path / "whole"
    names = sorted(units.iterdir())[:4]
    remove = Store.remove
    for last in (1, 2, 4):
        monkeypatch.setattr(Store, "remove", lambda *_: None)  # as of a run that is killed at this moment
        fleet.run("allan_noise", names[:last], whole, executor="serial")
    monkeypatch.setattr(Store, "remove", remove)
    assert len(list(whole.glob("rows/*/*/*.json"))) == 4
    table = fleet.Fleet(whole).table()
    for number in range(3 + 4):
        out = tmp_path / f"killed {number}"
        shutil.copytree(whole, out)
        calls: list[int] = []

        def stops(store, *parts, calls=calls, number=number):
            if len(calls) == number:
                raise KeyboardInterrupt
            calls.append(1)
            remove(store, *parts)

        monkeypatch.setattr(Store, "remove", stops)
        with pytest.raises(KeyboardInterrupt):
            fleet.Fleet(out).compact()
        monkeypatch.setattr(Store, "remove", remove)
        assert fleet.Fleet(out).table().equals(table)
        assert fleet.run("allan_noise", names, out, executor="serial").table().equals(table)
        fleet.Fleet(out).compact()
        assert len(parquet_files(out)) == 1 and not list(out.glob("rows/*/*/*.json"))
        assert fleet.Fleet(out).table().equals(table)
        assert len(computed(out)) == 4


def test_a_plan_that_changes_ends_the_run(tree, tmp_path):
    plan = tmp_path / "plan.toml"
    shutil.copy(tree / "plans/static_bias.toml", plan)
    for seed in (1, 2, 3):
        tumble.simulate(plan, seed=seed).save(tmp_path / f"unit {seed}.h5")
    text = plan.read_text()

    def changes(_, what):
        plan.write_text(text + "\n# changed\n")
        from tumble.fleet import _task

        _task._plan.cache_clear()

    with pytest.raises(tumble.UsageError, match="has changed since the run began"):
        fleet.run(plan, str(tmp_path / "*.h5"), tmp_path / "fleet", executor="serial", progress=changes)
    with pytest.raises(tumble.UsageError, match="another plan"):
        fleet.run(plan, str(tmp_path / "*.h5"), tmp_path / "fleet", executor="serial")
    plan.write_text(text)
    made = fleet.run(plan, str(tmp_path / "*.h5"), tmp_path / "fleet", executor="serial")
    assert made.status().ok == 3 and not made.errors()


def test_a_clock_that_goes_back_makes_no_old_error_the_last_word(units, tmp_path, monkeypatch):
    from tumble.fleet import _run

    (one, other), path = sorted(units.iterdir())[:2], tmp_path / "unit.h5"

    class Later(_run.datetime.datetime):
        @classmethod
        def now(cls, zone=None):
            return super().now(zone) + _run.datetime.timedelta(days=3000)

    with monkeypatch.context() as patch:
        patch.setattr(_run.datetime, "datetime", Later)
        first = fleet.run("allan_noise", [one, path], tmp_path / "fleet", executor="serial", retries=0)
    assert first.status().errors == 1
    shutil.copy(other, path)
    made = fleet.run("allan_noise", [one, path], tmp_path / "fleet", executor="serial")
    assert made.status().ok == 2 and not made.errors()


def test_what_is_no_file_is_a_row(units, tmp_path):
    pipe = tmp_path / "pipe.h5"
    os.mkfifo(pipe)
    made = fleet.run("allan_noise", [pipe, next(units.iterdir())], tmp_path / "fleet", executor="serial")
    assert "is no file" in made.errors()[str(pipe)] and made.status().ok == 1


def test_a_name_that_is_no_text_is_refused(units, tmp_path):
    folder = tmp_path / "mixed"
    folder.mkdir()
    shutil.copy(next(units.iterdir()), os.fsencode(folder) + b"/\xff.h5")
    with pytest.raises(tumble.UsageError, match="not in UTF-8"):
        fleet.run("allan_noise", folder, tmp_path / "fleet", executor="serial")


@pytest.mark.parametrize("left", [b"", b'{"key": "ab'])
def test_rows_that_a_power_failure_cut_are_made_again(units, serial_table, tmp_path, left, monkeypatch):
    from tumble.fleet import _run

    out = tmp_path / "fleet"

    def ends(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(_run, "add_rows", ends)
        fleet.run("allan_noise", units, out, executor="serial")
    first, second, *_ = sorted(out.glob("rows/*/*/*.json"))
    first.write_bytes(left)
    second.write_bytes(left)
    result = out / "results" / second.relative_to(out / "rows")
    result.write_bytes(result.read_bytes()[:100])
    made = fleet.run("allan_noise", units, out, executor="serial")
    assert made.table().equals(serial_table)
    assert len(computed(out)) == UNITS + 1, "only the one whose result was cut too"


def test_two_drivers_in_one_folder(units, serial_table, tmp_path):
    out = tmp_path / "fleet"
    drivers = [
        subprocess.Popen([sys.executable, "-c", DRIVER, str(units), str(out)], stderr=subprocess.PIPE) for _ in range(2)
    ]
    said = [driver.communicate(timeout=300)[1] for driver in drivers]
    assert [driver.returncode for driver in drivers] == [0, 0], said
    assert fleet.Fleet(out).table().equals(serial_table)
    assert len(set(computed(out))) == UNITS
