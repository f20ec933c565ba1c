"""Where tasks are carried out: in this process, in processes of this machine, on a Dask cluster, or by any object with
`submit(function, *arguments)` that returns a future.
"""

from __future__ import annotations

import contextlib
import os
import queue
import select
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any, Protocol

from tumble._errors import TumbleError, UsageError, wrong_type
from tumble._text import need
from tumble.fleet._worker import receive, send


class WorkerDiedError(TumbleError):
    """A process ended in the middle of a task."""


class GoneError(TumbleError):
    """Who was to carry out tasks will not come back."""


class Engine(Protocol):
    """Carries out tasks. `slots` tasks are worked on at the same time."""

    name: str
    knows_the_culprit: bool  # whether WorkerDiedError names the task that the worker had

    @property
    def slots(self) -> int:
        """How many."""
        ...

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """The future of a call. Its exception is WorkerDiedError where the process ended."""
        ...

    def lacks(self) -> str:
        """Who is not there that could carry out tasks; empty: nobody. Raises GoneError where that is for ever."""
        ...

    def close(self) -> None:
        """Ends what was started for this run."""
        ...


class Local:
    """What does not depend on others."""

    def lacks(self) -> str:
        """Nobody."""
        return ""


class Serial(Local):
    """In this process, one after the other."""

    name, slots, knows_the_culprit = "serial", 1, True

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Calls at once."""
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    def close(self) -> None:
        """Nothing to end."""


class Processes(Local):
    """Processes of this machine. One that dies fails its own task only, and another one takes its place."""

    name, knows_the_culprit = "processes", True

    def __init__(self, workers: int, timeout: float | None = None) -> None:
        self.slots = workers
        self._timeout = timeout
        self._tasks: queue.SimpleQueue[tuple[Future[Any], Any] | None] = queue.SimpleQueue()
        self._running: set[subprocess.Popen[bytes]] = set()
        self._closed = False
        self._threads = [threading.Thread(target=self._serve, daemon=True) for _ in range(workers)]
        for thread in self._threads:
            thread.start()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Waits for a free process."""
        future: Future[Any] = Future()
        self._tasks.put((future, (function, arguments)))
        return future

    def close(self) -> None:
        """Ends all processes."""
        self._closed = True
        for _ in self._threads:
            self._tasks.put(None)
        for process in list(self._running):
            process.kill()
        for thread in self._threads:
            thread.join(5.0)

    def processes(self) -> list[int]:
        """Process numbers of the workers."""
        return [process.pid for process in list(self._running)]

    def _serve(self) -> None:
        worker: _Worker | None = None
        while (taken := self._tasks.get()) is not None:
            future, message = taken
            if not future.set_running_or_notify_cancel():
                continue
            try:
                if worker is None:
                    worker = _Worker()
                    self._running.add(worker.process)
                good, value = worker.ask(message, self._timeout)
            except (EOFError, BrokenPipeError, TimeoutError) as error:
                assert worker is not None
                self._running.discard(worker.process)
                future.set_exception(WorkerDiedError(worker.ended(error)))
                worker = None
                continue
            except Exception as error:  # the message cannot be pickled, or no process can be started
                future.set_exception(error)
                continue
            if good:
                future.set_result(value)
            else:
                future.set_exception(value)
        if worker is not None:
            worker.close()
            self._running.discard(worker.process)


class _Worker:
    """One process and its two pipes."""

    def __init__(self) -> None:
        theirs_in, ours_out = os.pipe()
        ours_in, theirs_out = os.pipe()
        code = "from tumble.fleet._worker import main; main()"
        command = [sys.executable, "-c", code, str(theirs_in), str(theirs_out)]
        paths = [one for one in sys.path if one]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        try:
            self.process = subprocess.Popen(
                command, pass_fds=(theirs_in, theirs_out), env=environment, stdin=subprocess.DEVNULL
            )
        finally:
            os.close(theirs_in)
            os.close(theirs_out)
        self._out = os.fdopen(ours_out, "wb")
        self._in = os.fdopen(ours_in, "rb", buffering=0)

    def ask(self, message: Any, timeout: float | None) -> Any:
        """The answer. Raises EOFError where the process has ended, TimeoutError where it takes too long."""
        send(self._out, message)
        if timeout is not None and not select.select([self._in], [], [], timeout)[0]:
            raise TimeoutError(f"it gave no answer within {timeout:g} s")
        return receive(self._in)

    def ended(self, error: Exception) -> str:
        """Why there is no answer."""
        if isinstance(error, TimeoutError):
            self.process.kill()
        self.close()
        code = self.process.wait()
        if isinstance(error, TimeoutError):
            return f"the worker was ended: {error}"
        if code < 0:
            hint = " (often: out of memory)" if code == -9 else ""
            return f"the worker was ended by signal {-code}{hint}"
        return f"the worker ended with status {code}"

    def close(self) -> None:
        """Ends the pipes, and with them the process."""
        for stream in (self._out, self._in):
            with contextlib.suppress(OSError):
                stream.close()
        self.process.wait()


class Dask:
    """A distributed.Client. `own` is the cluster to close at the end, if it was made for this run."""

    name, knows_the_culprit = "dask", False

    PATIENCE = 10.0  # [s] for a result that a worker has; longer: the worker died with it

    def __init__(self, client: Any, own: Any = None) -> None:
        self._client, self._own = client, own
        self._workers: dict[str, int] = client.ncores()
        self._address = client.scheduler.address
        self._fetching = ThreadPoolExecutor(4)
        self._asked: tuple[float, Future[dict[str, int]]] | None = None

    @property
    def slots(self) -> int:
        """Processors of the workers that are there: some may come later."""
        return max(1, sum(self._workers.values()))

    def _require_scheduler(self) -> None:
        if self._client.status in ("closing", "closed"):
            raise GoneError(f"the scheduler at {self._address} has ended")

    def lacks(self) -> str:
        """The scheduler, or workers."""
        self._require_scheduler()
        silent = f"the scheduler at {self._address}, which does not answer"
        if self._client.status != "running":
            return silent
        if self._asked is None:
            self._asked = time.monotonic(), _beside(self._client.ncores)
        begun, asked = self._asked
        if asked.done():
            self._asked = None
            if asked.exception() is not None:
                return silent
            self._workers = asked.result()
        elif time.monotonic() - begun > self.PATIENCE:
            return silent
        return "" if self._workers else f"workers of the scheduler at {self._address}, which has none"

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Sends the call to the scheduler. Raises GoneError where it has ended."""
        self._require_scheduler()
        future: Future[Any] = Future()
        try:
            remote = self._client.submit(function, *arguments, pure=False)
        except Exception as error:  # between two states of the client
            future.set_exception(WorkerDiedError(f"no scheduler took the task: {type(error).__name__}: {error}"))
            return future
        remote.add_done_callback(lambda one: self._fetching.submit(self._settle, one, future))
        return future

    def _settle(self, remote: Any, future: Future[Any]) -> None:
        """Gives the future what the remote one has. What is lost with a worker is as if the worker died at the task."""
        try:
            if remote.status == "error":
                raised = remote.exception(timeout=self.PATIENCE)
                died = type(raised).__name__ == "KilledWorker"
                future.set_exception(WorkerDiedError("workers that had this task ended") if died else raised)
            elif remote.status in ("lost", "cancelled"):
                future.set_exception(WorkerDiedError("the worker that had the result ended"))
            else:
                future.set_result(remote.result(timeout=self.PATIENCE))
        except BaseException as error:  # a worker or the scheduler is not there any more
            future.set_exception(WorkerDiedError(f"the result was lost: {type(error).__name__}: {error}"))
        finally:
            remote.release()

    def close(self) -> None:
        """Closes the cluster that was made for this run."""
        self._fetching.shutdown(wait=False, cancel_futures=True)
        if self._own is not None:
            self._client.close()
            self._own.close()


def _beside(call: Callable[[], Any]) -> Future[Any]:
    """Calls in a thread that may go on for ever: the end of the program does not wait for it."""
    future: Future[Any] = Future()

    def answer() -> None:
        try:
            future.set_result(call())
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=answer, daemon=True).start()
    return future


class Foreign(Local):
    """Any object with `submit`: an executor of concurrent.futures, or one that looks like it."""

    knows_the_culprit = False

    def __init__(self, executor: Any, slots: int) -> None:
        self._executor, self.slots = executor, slots
        self.name = type(executor).__name__

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Submits to it."""
        future: Future[Any] = self._executor.submit(function, *arguments)
        return future

    def close(self) -> None:
        """The executor is the user's."""


class Waiting:
    """Waits for answers as long as there is somebody who could give them."""

    TICK = 1.0  # [s] between two looks
    WORDS = 30.0  # [s] between two words about it

    def __init__(self, engine: Engine, patience: float, say: Callable[[str], None]) -> None:
        self._engine, self._patience, self._say = engine, patience, say
        self._looked = self._said = time.monotonic()
        self._since: float | None = None  # when somebody was missed first

    @property
    def lacking(self) -> bool:
        """Whether somebody is missed, so that no task should be given away now."""
        return self._since is not None

    def some_of(self, futures: Collection[Future[Any]]) -> set[Future[Any]]:
        """Those that are done, one or more; where none is given, a while later none.

        Raises GoneError where nobody has come for as long as is waited.
        """
        while True:
            if not futures:
                time.sleep(self.TICK)
            done = wait(futures, timeout=self.TICK, return_when=FIRST_COMPLETED).done
            if time.monotonic() - self._looked >= self.TICK:
                self._look(bool(done))
            if done or not futures:
                return done

    def _look(self, answered: bool) -> None:
        now = self._looked = time.monotonic()
        try:
            lacks = self._engine.lacks()
        except GoneError:
            if answered:
                return  # what is there first
            raise
        if not lacks:
            self._since = None
            return
        if self._since is None:
            self._since, self._said = now, now - self.WORDS
        if now - self._since > self._patience:
            raise GoneError(f"after {now - self._since:.0f} s without {lacks}")
        if now - self._said >= self.WORDS:
            self._said = now
            self._say(lacks)


def engine_of(executor: Any, workers: int | None, timeout: float | None = None) -> Engine:
    """The engine of an argument `executor`. Raises ArgumentTypeError, UsageError."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    count = cores if workers is None else workers
    if timeout is not None and executor != "processes":
        raise UsageError("argument timeout: only executor='processes' can end a task that takes too long")
    if executor == "serial":
        return Serial()
    if executor == "processes":
        return Processes(count, timeout)
    if executor == "dask":
        distributed = need("distributed", "fleet")
        cluster = distributed.LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=":0")
        return Dask(distributed.Client(cluster), cluster)
    if isinstance(executor, str):
        raise UsageError(f"argument executor: {executor!r} was given; accepted are serial, processes and dask")
    if hasattr(executor, "scheduler_info") and hasattr(executor, "ncores"):
        return Dask(executor)
    if callable(getattr(executor, "submit", None)):
        return Foreign(executor, count)
    raise wrong_type(
        "executor",
        executor,
        "accepted are 'serial', 'processes', 'dask', a distributed.Client, and an object with submit(function, ...)",
    )
