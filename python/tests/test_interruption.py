"""Ctrl+C, and exceptions of progress callbacks, end long calls soon, and leave nothing behind."""

from __future__ import annotations

import os
import signal
import threading
import time

import numpy as np
import pytest
from tumble.compat import allantools

import tumble

X = np.random.default_rng(1).normal(size=100_000)
LONGER = np.tile(X, 3)
LONG = {
    "mtotdev of compat": lambda: allantools.mtotdev(X[:6000], taus="all"),
    "mdev of compat": lambda: allantools.mdev(LONGER, taus="all"),
    "gradev of compat": lambda: allantools.gradev(LONGER, taus="all"),
    "gcodev of compat": lambda: allantools.gcodev(LONGER, LONGER, taus="all"),
    "mtotdev": lambda: tumble.allan_deviation(X[:6000], 1.0, kind="modified_total", taus="all"),
    "theo1": lambda: tumble.allan_deviation(X, 1.0, kind="theo1", taus="all"),
}


@pytest.mark.usefixtures("keyboard")
@pytest.mark.parametrize("name", LONG)
def test_ctrl_c_ends_a_long_call(name):
    interrupted(LONG[name])


@pytest.mark.usefixtures("keyboard")
@pytest.mark.parametrize("name", ["a.csv", "a.h5"])
def test_ctrl_c_ends_a_file_that_is_written_and_leaves_nothing(name, tmp_path):
    long = tumble.from_arrays({"g": (np.tile(X, 80), "deg/s")}, rate=100)
    interrupted(lambda: [long.save(tmp_path / name) for _ in range(100)])
    assert list(tmp_path.glob("*.tmp*")) == []


def interrupted(call):
    """Ctrl+C during a call ends it soon."""
    sent = []
    ended = threading.Event()

    def press():
        if not ended.is_set():  # else it would end the tests
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.2, press)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        call()
        ended.set()
    assert time.monotonic() - sent[0] < 5.0  # some ms; the machine may be busy. Each takes longer alone
    timer.join()


def test_other_threads_go_on_meanwhile():
    done = threading.Event()
    ticks = []

    def tick():
        while not done.wait(0.01):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    allantools.gradev(X, taus=np.arange(1.0, 2000.0))
    passed = time.monotonic() - begin
    done.set()
    thread.join()
    assert len(ticks) > 5 or passed < 0.2


def test_an_exception_of_a_callback_comes_out(tree):
    class StopError(Exception):
        pass

    def refuse(done, what):
        raise StopError

    with pytest.raises(StopError):
        tumble.simulate(tree / "plans/fog_thermal_bias.toml", progress=refuse)
