"""Where things are: the tree, the command, real recordings."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

TREE = Path(os.environ.get("TUMBLE_TREE", Path(__file__).resolve().parents[2]))


@pytest.fixture(scope="session")
def tree() -> Path:
    return TREE


@pytest.fixture(scope="session")
def imu_file() -> str:
    """An MPU-6050 at rest: three gyros and a temperature, stamped by a computer."""
    return str(TREE / "examples/data/mpu6050_static.csv")


@pytest.fixture(scope="session")
def command() -> Callable[..., str]:
    """The program `tumble`: what it prints."""
    program = os.environ.get("TUMBLE_COMMAND") or shutil.which("tumble")
    if program is None:
        pytest.skip("there is no command tumble")

    def run(*arguments: object) -> str:
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def keyboard():
    """Ctrl+C raises KeyboardInterrupt: a process that was started in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
