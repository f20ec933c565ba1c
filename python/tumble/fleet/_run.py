"""The driver of a run: which recordings are done, which are to do, and what to do when a worker dies."""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import re
import time
import uuid
import warnings
from collections import deque
from concurrent.futures import Future
from typing import Any

from tumble import _tumble
from tumble._errors import DataError, FileError, TumbleError, TumbleWarning, UsageError
from tumble._plan import Plan, plan_of
from tumble._progress import Call, listener
from tumble._text import count_of, number_of, path_text
from tumble.fleet._engines import Engine, GoneError, Waiting, WorkerDiedError, engine_of
from tumble.fleet._fleet import Fleet
from tumble.fleet._index import Index, stamp_text
from tumble.fleet._names import require_some, tasks_of
from tumble.fleet._store import DOCUMENT, FORMAT, Log, Store
from tumble.fleet._tables import BATCH, add_rows, forget, gather
from tumble.fleet._task import Job, Task, keep, reduce, sha256_of_plan, stamp_of, where

QUEUE = 2  # tasks in flight for each worker: one that it works on, one that waits


def run(
    plan: Plan | str | os.PathLike[str],
    recordings: Any,
    out: str | os.PathLike[str],
    *,
    executor: Any = "processes",
    workers: int | None = None,
    settings: dict[str, object] | None = None,
    serial: str | None = None,
    retries: int = 2,
    timeout: float | None = None,
    retry_errors: bool = False,
    patience: float = 600.0,
    archive: str | None = None,
    by: str | None = None,
    progress: object = None,
) -> Fleet:
    """Identifies the parameters of many units, one recording each.

    A run that was interrupted goes on where it ended: what is done is not computed again, for any executor. A recording
    that cannot be reduced is a row with its error; so is one that ends its worker, and one to which a run has not come
    because the cluster had ended: then there is a TumbleWarning, and the same call goes on.

    Given     plan          a Plan, the path of one, or the name of a method that needs none
              recordings    paths, patterns such as "data/*.h5", folders, a dict from serial number to path
              out           folder of the fleet, here or in an object store (s3://); of one plan
              executor      "processes", "serial", "dask" (a cluster on this machine), a distributed.Client, or any
                            object with submit(function, *arguments)
              workers       number of processes; None: one for each processor
              settings      values that replace those of the plan, as in Plan.with_
              serial        regular expression that finds the serial number in the name; None: the name without its end
              retries       how often a task is tried again whose worker died or whose file could not be read
              timeout       [s] after which a worker of executor="processes" is ended, with an error in the row
              retry_errors  also recordings again whose row is an error
              patience      [s] how long a run waits while a cluster has no worker, or its scheduler does not answer
              archive       address of an archive that takes the results, with `by`, who archives them
              progress      None, True (a bar), or a function of (done from 0 to 1, what)
    Returned  the fleet: its table, its log, its summary
    Raises    UsageError for an empty list, a name twice, a folder of another plan; FileError for a full disk
    Example   tumble.fleet.run("plan.toml", "data/*.h5", "fleet").table()
    """
    made = plan_of(plan, settings)
    _require_fleet_plan(made)
    tasks = tasks_of(recordings, serial)
    store = Store(path_text(out, "out"))
    if not store.has(DOCUMENT):
        require_some(tasks)
    job = _job(store, made)
    driver = _Driver(
        store,
        job,
        count_of(retries, "retries"),
        None if timeout is None else number_of(timeout, "timeout"),
        number_of(patience, "patience"),
        retry_errors,
    )
    count = None if workers is None else count_of(workers, "workers", 1)
    with listener(progress) as call:
        driver.run(tasks, executor, count, call)
    fleet = Fleet(store)
    if archive is not None:
        fleet.to_archive(archive, by=by)
    return fleet


def _require_fleet_plan(plan: Plan) -> None:
    if plan.recordings:
        raise UsageError(
            f"{plan.file}: names recordings itself ([[recording]]); in a fleet each recording is reduced by the plan "
            "alone: remove them, or use identify"
        )


def _job(store: Store, plan: Plan) -> Job:
    """The job of a folder, which belongs to one plan. Raises UsageError where it belongs to another."""
    sha256 = sha256_of_plan(plan)
    document = store.json(DOCUMENT)
    if document is None and store.is_local and os.path.isdir(store.root) and os.listdir(store.root):
        raise UsageError(f"{store.folder}: is not empty, and holds no fleet: name a new folder")
    if document is not None:
        if document.get("format") != FORMAT:
            raise UsageError(f"{store.folder}: was made by another version of tumble.fleet: name a new folder")
        if document["plan_sha256"] != sha256:
            raise UsageError(
                f"{store.folder}: holds the fleet of another plan or other settings ({document['plan']}"
                f"{''.join(f', {key}={value}' for key, value in document['sets'])}): name a new folder"
            )
    name = os.path.abspath(plan.file) if plan.file else plan.method
    sets = tuple((key, value) for key, value in plan._sets)
    job = Job(store.folder if "://" in store.folder else store.root, name, sets, sha256, _tumble.version)
    if document is None or document["tumble"] != job.version:
        made = {
            "format": FORMAT,
            "plan": os.path.basename(name),
            "method": plan.method,
            "plan_sha256": sha256,
            "sets": sets,
            "tumble": job.version,
        }
        store.write((json.dumps(made, indent=1, ensure_ascii=False) + "\n").encode(), DOCUMENT)
        if plan.text is not None:
            store.write(plan.text.encode(), "plan.toml")
    return job


class _Driver:
    """One run."""

    def __init__(
        self, store: Store, job: Job, retries: int, timeout: float | None, patience: float, retry_errors: bool
    ) -> None:
        self._store = store
        self._document: dict[str, Any] = store.json(DOCUMENT)
        self._retries, self._timeout, self._patience, self._retry_errors = retries, timeout, patience, retry_errors
        self._failed: dict[Task, int] = {}  # how often
        self._alone: deque[Task] = deque()  # whose worker died while others were in flight
        self._rows: list[dict[str, Any]] = []  # that are not in the table yet
        self._done = self._errors = 0
        name = self._name_of_log()
        self._log = Log(store, "log", name)
        self._job = job._replace(log=name)

    def run(self, tasks: list[Task], executor: Any, workers: int | None, call: Call | None) -> None:
        with contextlib.ExitStack() as ends:
            ends.enter_context(contextlib.closing(self._log))
            gather(self._store, self._document)
            self._index = ends.enter_context(contextlib.closing(Index(self._store, self._job.version)))
            waiting = self._to_do(tasks)
            self._all, self._done, self._call = len(tasks), len(tasks) - len(waiting), call
            self._begin = time.monotonic()
            self._say({"run": "begins", "tumble": self._job.version, "recordings": len(tasks), "to_do": len(waiting)})
            try:
                if waiting:
                    self._carry_out(waiting, executor, workers)
                self._write_rows()
            except BaseException:
                with contextlib.suppress(FileError):  # of a full disk: it is known
                    self._write_rows()
                    self._say_end("interrupted")
                raise
            self._say_end("complete")

    def _name_of_log(self) -> str:
        """Runs have numbers, because a clock may go back between two of them."""
        numbers = [
            int(name.split("-")[1])
            for name in self._store.names("log", suffix=".jsonl")
            if re.match(r"run-\d{6}-", name)
        ]
        stamp = datetime.datetime.now(datetime.timezone.utc).strftime("%Y%m%dT%H%M%SZ")
        return f"run-{max(numbers, default=0) + 1:06}-{stamp}-{os.getpid()}-{uuid.uuid4().hex[:6]}.jsonl"

    def _to_do(self, tasks: list[Task]) -> deque[Task]:
        """The recordings that no earlier run did, or that have changed since: nothing is read."""
        forgotten: set[str] = set()  # keys of errors that are to be tried again
        waiting = deque(task for task in tasks if not self._is_done(task, forgotten))
        forget(self._store, self._document, forgotten)
        self._index.forget(forgotten)
        return waiting

    def _is_done(self, task: Task, forgotten: set[str]) -> bool:
        known = self._index.entry(task.recording)
        if known is None or known.serial != task.serial or known.key is None:
            return False
        if known.status == "error" and self._retry_errors:
            forgotten.add(known.key)
            return False
        try:
            if stamp_text(stamp_of(task.recording)) != known.stamp:
                return False
        except TumbleError:
            return False
        return self._index.has_row(known.key)

    def _carry_out(self, waiting: deque[Task], executor: Any, workers: int | None) -> None:
        engine = engine_of(executor, workers, self._timeout)
        try:
            self._say({"run": "works", "executor": engine.name, "workers": engine.slots})
            self._work_with(engine, waiting)
        finally:
            engine.close()

    def _work_with(self, engine: Engine, waiting: deque[Task]) -> None:
        answers = Waiting(engine, self._patience, self._say_what_lacks)
        in_flight: dict[Future[Any], Task] = {}
        try:
            self._work(waiting, in_flight, engine, answers, False)
            self._work(self._alone, in_flight, engine, answers, True)
        except GoneError as error:
            left = [*in_flight.values(), *waiting, *self._alone]
            for task in left:
                self._settle(task, _failure(f"was not reduced: {error}"))
            warnings.warn(
                f"{len(left)} of {self._all} recordings were not reduced: {error}; the same call goes on",
                TumbleWarning,
                stacklevel=5,
            )

    def _work(
        self, waiting: deque[Task], in_flight: dict[Future[Any], Task], engine: Engine, answers: Waiting, alone: bool
    ) -> None:
        """Keeps tasks in flight until none waits."""
        while waiting or in_flight:
            while waiting and not answers.lacking and len(in_flight) < (1 if alone else QUEUE * engine.slots):
                in_flight[engine.submit(reduce, self._job, waiting[0])] = waiting[0]
                waiting.popleft()
            for future in answers.some_of(in_flight):
                task = in_flight.pop(future)
                self._take(task, future, waiting, alone=alone or engine.knows_the_culprit)

    def _take(self, task: Task, future: Future[Any], waiting: deque[Task], alone: bool) -> None:
        error = future.exception()
        if error is None:
            self._settle(task, future.result())
        elif isinstance(error, WorkerDiedError) and not alone:
            self._alone.append(task)  # one of those in flight ended the worker: which one shows when each is alone
            self._say({"recording": task.recording, "serial": task.serial, "failed": str(error), "again": "alone"})
        elif isinstance(error, DataError) and not isinstance(error, FileError):
            self._settle(task, _failure(str(error)))
        elif isinstance(error, (FileError, WorkerDiedError, OSError, MemoryError)) or not isinstance(
            error, TumbleError
        ):
            self._again(task, error, waiting)
        else:
            raise error

    def _again(self, task: Task, error: BaseException, waiting: deque[Task]) -> None:
        if _is_full_disk(error, self._job.out):
            raise error
        self._failed[task] = self._failed.get(task, 0) + 1
        words = str(error) or type(error).__name__
        if self._failed[task] <= self._retries:
            self._say(
                {"recording": task.recording, "serial": task.serial, "failed": words, "again": self._failed[task]}
            )
            waiting.append(task)
            return
        times = f", {self._failed[task]} times" if self._failed[task] > 1 else ""
        self._settle(task, _failure(words + times))

    def _settle(self, task: Task, answer: dict[str, Any]) -> None:
        row = answer.pop("row", None)
        if "result" in answer:  # of a worker that does not share the folder
            keep(self._store, self._job.version, row, answer.pop("result"))
        self._done += 1
        self._errors += answer["status"] == "error"
        self._say({"recording": task.recording, "serial": task.serial, **answer})
        if row is not None and not self._index.has_row(row["key"]):
            self._rows.append(row)
            if len(self._rows) >= BATCH:
                self._write_rows()
        if self._call is not None:
            self._call(self._done / self._all, self._how_far())

    def _write_rows(self) -> None:
        rows, self._rows = self._rows, []
        add_rows(self._store, self._document, rows)

    def _how_far(self) -> str:
        errors = f", {self._errors} with an error" if self._errors else ""
        return f"{self._done} of {self._all} recordings{errors}"

    def _say_what_lacks(self, lacks: str) -> None:
        self._say({"run": "waits", "for": lacks})
        if self._call is not None:
            self._call(self._done / self._all, f"{self._how_far()}; waiting for {lacks}")

    def _say_end(self, ending: str) -> None:
        self._say({"run": ending, "seconds": round(time.monotonic() - self._begin, 3)})

    def _say(self, line: dict[str, Any]) -> None:
        now = time.time()
        self._log.add({"time": round(now, 6), **line, **({} if "host" in line else where())}, now)


def _failure(error: str) -> dict[str, Any]:
    """The outcome of a recording of which nothing is known."""
    return {"key": None, "status": "error", "error": error, "known": False}


def _is_full_disk(error: BaseException, out: str) -> bool:
    """Whether the folder of the fleet cannot be written: no recording is to blame, and the run ends."""
    return isinstance(error, FileError) and str(error).startswith(out)
