"""Clusters with faults: workers without the folder of the fleet, workers and schedulers that are gone."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import tumble

pytest.importorskip("pyarrow")
from tumble.fleet._engines import Dask, Waiting

from tumble import fleet

distributed = pytest.importorskip("distributed")

UNITS = 12


@pytest.fixture(scope="module")
def units(tmp_path_factory) -> Path:
    import numpy as np

    folder = tmp_path_factory.mktemp("units")
    for number in range(UNITS):
        rate = np.random.default_rng(number).normal(0.0, 0.02, 4000)
        tumble.from_arrays({"gyro.x": (rate, "deg/s")}, rate=100).save(folder / f"u{number:02}.h5")
    return folder


@pytest.fixture(scope="module")
def serial_table(units, tmp_path_factory):
    return fleet.run("allan_noise", units, tmp_path_factory.mktemp("serial") / "fleet", executor="serial").table()


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """A second is long for a test."""
    monkeypatch.setattr(Waiting, "TICK", 0.1)


class Cluster:
    """A scheduler and workers as processes of their own."""

    def __init__(self, folder: Path, stack: contextlib.ExitStack) -> None:
        self.folder, self._stack = folder, stack
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self.address = ""

    def scheduler(self) -> None:
        file = self.folder / "scheduler.json"
        self._start("scheduler", ["scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)])
        deadline = time.monotonic() + 60
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        import json

        self.address = json.loads(file.read_text())["address"]

    def worker(self, name: str, prefix: tuple[str, ...] = (), cwd: Path | None = None) -> None:
        words = ["worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--name", name]
        self._start(name, words, prefix, cwd)

    def _start(self, name: str, words: list[str], prefix: tuple[str, ...] = (), cwd: Path | None = None) -> None:
        local = self.folder / f"{name}.space"
        local.mkdir()
        if words[0] == "worker":
            words += ["--local-directory", str(local)]
        with open(self.folder / f"{name}.log", "wb") as log:
            process = subprocess.Popen(
                [*prefix, sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]],
                stdout=log,
                stderr=log,
                cwd=cwd or self.folder,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(os.path.abspath(one) for one in sys.path if one)},
                start_new_session=True,
            )
        self.processes[name] = process
        self._stack.callback(process.wait)
        self._stack.callback(self.kill, name)

    def kill(self, name: str, how: int = signal.SIGKILL) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.processes[name].pid, how)

    def client(self, workers: int, timeout: float = 60.0) -> distributed.Client:
        """Given: timeout [s] for which it tries to reach the scheduler again."""
        client = self._stack.enter_context(distributed.Client(self.address, timeout=timeout))
        client.wait_for_workers(workers, timeout=60)
        return client


@pytest.fixture
def cluster(tmp_path) -> Iterator[Cluster]:
    with contextlib.ExitStack() as stack:
        made = Cluster(tmp_path, stack)
        made.scheduler()
        yield made


def hidden(folder: Path) -> tuple[str, ...]:
    """A command's prefix: in a room of its own, where this folder is another, empty one."""
    prefix = ("unshare", "--mount", "sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', str(folder))
    if subprocess.run([*prefix, "true"], check=False, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    return prefix


def test_a_worker_that_does_not_share_the_folder_loses_no_unit(cluster, units, serial_table, tmp_path):
    """In a mount namespace of its own."""
    out = tmp_path / "fleet"
    out.mkdir()
    cluster.worker("here")
    cluster.worker("elsewhere", hidden(out))
    made = fleet.run("allan_noise", units, out, executor=cluster.client(2), retries=0)
    assert made.table().equals(serial_table)
    assert str(made.status()) == f"{UNITS} recordings: {UNITS} done, 0 with an error"
    processes = {line["process"] for line in made.log().to_pylist() if line.get("status") == "ok"}
    assert len(processes) == 2, "both did some"
    assert made.result(serial_table["recording"].to_pylist()[0]).method == "allan_noise"
    again = fleet.run("allan_noise", units, out, executor="serial")
    assert again.log().to_pylist()[-1]["run"] == "complete" and again.table().equals(serial_table)
    assert not [line for line in again.log().to_pylist() if line.get("to_do")][1:], "nothing was left to do"


def test_two_folders_of_one_machine_lose_no_unit_either(cluster, units, serial_table, tmp_path, monkeypatch):
    """The same path is another folder for each process: what needs no rights."""
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir(), there.mkdir()
    monkeypatch.chdir(here)
    cluster.worker("here", cwd=here)
    cluster.worker("there", cwd=there)
    made = fleet.run("allan_noise", units, "/proc/self/cwd/fleet", executor=cluster.client(2), retries=0)
    assert made.table().equals(serial_table)
    assert not (there / "fleet").exists(), "nothing is written where nobody looks"


def test_a_worker_that_sees_neither_folder_nor_recording_says_so(cluster, units, tmp_path):
    out = tmp_path / "fleet"
    out.mkdir()
    prefix = hidden(out)
    nested = ("unshare", "--mount", "sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', str(units))
    cluster.worker("blind", (*prefix, *nested))
    made = fleet.run("allan_noise", units, out, executor=cluster.client(1), retries=0)
    errors = made.errors()
    assert len(errors) == UNITS
    assert all("sees neither the recording nor the folder of the fleet" in error for error in errors.values())


def gone(made: fleet.Fleet, words: str) -> None:
    """Each recording is a row or has this error."""
    status = made.status()
    assert (status.recordings, status.pending) == (UNITS, 0)
    errors = made.errors()
    assert errors and status.ok + len(errors) == UNITS
    assert all(words in error for error in errors.values()), errors


def test_a_run_whose_workers_are_gone_ends_with_what_is_done(cluster, units, serial_table, tmp_path):
    cluster.worker("only")
    client = cluster.client(1)
    said = []

    def kill(done, what):
        said.append(what)
        if done >= 2 / UNITS:
            cluster.kill("only")

    begin = time.monotonic()
    with pytest.warns(tumble.TumbleWarning, match="the same call goes on"):
        made = fleet.run("allan_noise", units, tmp_path / "fleet", executor=client, patience=2.0, progress=kill)
    assert time.monotonic() - begin < 60
    gone(made, "without workers of the scheduler")
    assert any("waiting for workers of the scheduler" in words for words in said)
    assert any(line.get("run") == "waits" for line in made.log().to_pylist())
    cluster.worker("another")
    client.wait_for_workers(1, timeout=60)
    again = fleet.run("allan_noise", units, tmp_path / "fleet", executor=client)
    assert again.table().equals(serial_table)


def test_workers_that_come_back_in_time_go_on(cluster, units, serial_table, tmp_path):
    cluster.worker("first")
    client = cluster.client(1)

    def change(done, what):
        if done >= 2 / UNITS and "second" not in cluster.processes:
            cluster.kill("first")
            cluster.worker("second")

    made = fleet.run("allan_noise", units, tmp_path / "fleet", executor=client, patience=60.0, progress=change)
    assert made.table().equals(serial_table)


@pytest.mark.parametrize(("how", "patience"), [(signal.SIGKILL, 3.0), (signal.SIGKILL, 600.0), (signal.SIGSTOP, 3.0)])
def test_a_run_whose_scheduler_is_gone_ends_with_what_is_done(cluster, units, tmp_path, how, patience, monkeypatch):
    """With much patience the run ends when the client of Dask gives up."""
    monkeypatch.setattr(Dask, "PATIENCE", 1.0)
    cluster.worker("only")
    client = cluster.client(1, timeout=6.0)

    def kill(done, what):
        if done >= 2 / UNITS:
            cluster.kill("scheduler", how)

    begin = time.monotonic()
    with pytest.warns(tumble.TumbleWarning, match="the same call goes on"):
        made = fleet.run("allan_noise", units, tmp_path / "fleet", executor=client, patience=patience, progress=kill)
    assert time.monotonic() - begin < 60
    gone(made, "the scheduler at ")
    again = fleet.run("allan_noise", units, tmp_path / "fleet", executor="serial")
    assert again.status().ok == UNITS


def test_a_worker_of_another_version_ends_the_run(cluster, units, tmp_path, monkeypatch):
    from tumble import _tumble

    cluster.worker("only")
    client = cluster.client(1)
    monkeypatch.setattr(_tumble, "version", "0.0.1")
    with pytest.raises(tumble.UsageError, match=r"has Tumble .*, and the run 0\.0\.1"):
        fleet.run("allan_noise", units, tmp_path / "fleet", executor=client)
