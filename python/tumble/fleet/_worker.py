"""A worker process of the pool. Its arguments are two pipes of the process that started it.

Each message is its length [8 bytes] and a pickle: (function, arguments) comes in, (True, value) or (False, exception)
goes out. The worker ends when its pipe does: a driver that dies leaves no worker behind after its present task.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import sys
from typing import Any, BinaryIO

LENGTH = 8  # [bytes]


def send(stream: BinaryIO, message: Any) -> None:
    """Writes one message."""
    data = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(len(data).to_bytes(LENGTH, "little") + data)
    stream.flush()


def receive(stream: BinaryIO) -> Any:
    """Reads one message. Raises EOFError where the other side has ended."""
    head = _exactly(stream, LENGTH)
    return pickle.loads(_exactly(stream, int.from_bytes(head, "little")))


def _exactly(stream: BinaryIO, size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        some = stream.read(size - len(data))
        if not some:
            raise EOFError
        data += some
    return bytes(data)


def answer(message: Any) -> tuple[bool, Any]:
    """Calls the function; an exception that cannot be pickled becomes one that can."""
    function, arguments = message
    try:
        return True, function(*arguments)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            return False, RuntimeError(f"{type(error).__name__}: {error}")
        return False, error


def main() -> None:
    """Works until the pipe ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the driver, which then ends the pipes
    # The driver may have been killed: what nobody reads is no error, when it is sent or when the pipe is closed.
    with (
        contextlib.suppress(BrokenPipeError),
        os.fdopen(int(sys.argv[1]), "rb") as source,
        os.fdopen(int(sys.argv[2]), "wb") as target,
    ):
        while True:
            try:
                message = receive(source)
            except EOFError:
                return
            send(target, answer(message))
