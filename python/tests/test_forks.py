"""Forks while the library works on other threads; copies; threads that are alive when the interpreter ends."""

from __future__ import annotations

import copy
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable

import numpy as np
import pytest

import tumble

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # from 3.12 on: a fork beside threads


def holds_in_a_child(work: Callable[[], bool]) -> bool:
    """Whether work() is true in the child of a fork, within a minute."""
    child = os.fork()
    if child == 0:
        signal.alarm(60)  # a deadlock ends the child
        status = 1
        try:
            status = 0 if work() else 1
        finally:
            os._exit(status)
    return os.waitpid(child, 0)[1] == 0


@pytest.fixture(scope="module")
def long_file(tmp_path_factory):
    """48 MB, whose checksum takes longer than a fork."""
    x = np.random.default_rng(1).normal(size=6_000_000)
    path = tmp_path_factory.mktemp("long") / "long.h5"
    tumble.from_arrays({"gyro.x": (x, "deg/s")}, rate=100).save(path)
    return path


def test_a_fork_while_the_checksum_is_calculated(long_file):
    for _ in range(3):
        recording = tumble.read(long_file)
        assert holds_in_a_child(lambda recording=recording: len(recording.sha256) == 64)


def test_a_child_may_drop_a_recording_whose_checksum_is_calculated(long_file):
    recordings = [tumble.read(long_file)]
    assert holds_in_a_child(lambda: recordings.clear() is None)


def test_a_fork_while_other_threads_work():
    x = np.random.default_rng(1).normal(size=500_000)
    expected = tumble.allan_deviation(x, 1.0, taus="log").deviation
    done = threading.Event()

    def work():
        while not done.is_set():
            tumble.allan_deviation(x, 1.0, taus="log")

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(10):
            assert holds_in_a_child(lambda: np.array_equal(tumble.allan_deviation(x, 1.0, taus="log")[1], expected))
    finally:
        done.set()
        for thread in threads:
            thread.join()


LOOPS = """
import sys, threading, time
import numpy as np
import tumble
x = np.random.default_rng(1).normal(size=40_000)
recording = tumble.from_arrays({{"gyro.x[deg/h]": x[:5000]}}, rate=100)
def loop():
    while True:
        {call}
for _ in range(3):
    threading.Thread(target=loop, daemon=True).start()
time.sleep(0.3)
print("done", end="")
sys.exit(3)
"""

CALLS = (
    "tumble.allan_deviation(x, 1.0, kind='theo1', taus='all')",
    "tumble.allan_deviation(x, 1.0, taus='octave')",
    "tumble.identify('allan_noise', recording)",  # reads tables and texts that are destroyed at the end
)


@pytest.mark.parametrize("call", CALLS)
def test_the_interpreter_may_end_while_threads_work(call):
    for _ in range(3):
        script = [sys.executable, "-W", "ignore", "-c", LOOPS.format(call=call)]
        done = subprocess.run(script, capture_output=True, text=True, timeout=60, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (3, "done", "")


def test_copies_of_what_cannot_be_changed_are_itself(tree, imu_file):
    plan = tumble.load_plan(tree / "plans/sdof_gyro_static.toml")
    recording = tumble.read(imu_file)
    for one in (plan, recording, recording["gyro.x"], tumble.predict(plan)):
        assert copy.copy(one) is one
        assert copy.deepcopy([one])[0] is one


def test_values_with_arrays_can_be_compared(imu_file):
    x = np.random.default_rng(1).normal(size=1000)
    curve = tumble.allan_deviation(x, 100.0)
    again = pickle.loads(pickle.dumps(curve))
    assert curve == again
    assert not (curve != again)  # noqa: SIM202 - its own method
    assert curve != again._replace(kind="adev")
    assert curve != again._replace(taus=2.0 * curve.taus)
    assert curve != tuple(curve)
    assert curve != 5
    with pytest.warns(tumble.TumbleWarning):
        result = tumble.identify("allan_noise", imu_file)
    for values in (result.curves, result.figures[0].series):
        assert list(values) == pickle.loads(pickle.dumps(list(values)))
        assert values[0] != values[1]
