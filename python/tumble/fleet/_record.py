"""One record in many files: chunks on workers, joined exactly.

Each file is measured (how many samples, when), the files are laid out one after the other, each is reduced to a part
of about 1 MB a channel, and the parts are joined in their order. The sums of the Allan variance and of the likelihood's
contrasts are those of the whole record: the result is that of one machine, to rounding.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any

from tumble import _tumble
from tumble._errors import FileError, TumbleError, UsageError
from tumble._plan import Plan, plan_of
from tumble._progress import Call, listener
from tumble._result import Result
from tumble._text import count_of, number_of, path_text
from tumble.fleet._engines import Engine, Waiting, WorkerDiedError, engine_of
from tumble.fleet._names import tasks_of
from tumble.fleet._store import DOCUMENT, FORMAT, Store
from tumble.fleet._task import Job, _plan, local_copy, sha256_of_plan, stamp_of

QUEUE = 2


def record(
    plan: Plan | str | os.PathLike[str],
    files: Any,
    out: str | os.PathLike[str],
    *,
    executor: Any = "processes",
    workers: int | None = None,
    settings: dict[str, object] | None = None,
    retries: int = 2,
    patience: float = 600.0,
    progress: object = None,
) -> Result:
    """The noise of one record that many files hold together, in order of their names.

    Given     plan   a Plan of the method allan_noise, its path, or "allan_noise"
              files  paths, patterns, folders, as in run(); a list stays in its order
              out    folder of what is known of each file: a run that was interrupted goes on there
    Returned  the result of `identify` of the whole record; knocks are searched in each file by itself
    Raises    UsageError for a method that needs a whole recording; DataError with all files that do not fit: other
              channels, another rate, times that overlap
    Example   tumble.fleet.record("allan_noise", "year/*.h5", "year.fleet").save("year.json")
    """
    made = plan_of(plan, settings)
    if made.method != "allan_noise":
        raise UsageError(
            f"method '{made.method}' needs a recording as a whole; the method that works through parts is allan_noise"
        )
    listed = isinstance(files, Sequence) and not isinstance(files, (str, bytes))
    names = [task.recording for task in tasks_of(files, None)]
    if listed:
        order = {path_text(one, "files"): number for number, one in enumerate(files)}
        names.sort(key=lambda name: order.get(name, len(order)))
    store, again = Store(path_text(out, "out")), count_of(retries, "retries")
    job = _job_of_record(store, made)
    engine = engine_of(executor, None if workers is None else count_of(workers, "workers", 1))
    work = _Work(job, engine, again, number_of(patience, "patience"))
    try:
        with listener(progress) as call:
            return work.result(store, made, names, call)
    finally:
        work.engine.close()


def _job_of_record(store: Store, plan: Plan) -> Job:
    sha256 = sha256_of_plan(plan)
    document = store.json(DOCUMENT)
    if document is not None and document.get("record_of") != sha256:
        raise UsageError(f"{store.folder}: holds a fleet, or the record of another plan: name a new folder")
    if document is None:
        if store.is_local and os.path.isdir(store.root) and os.listdir(store.root):
            raise UsageError(f"{store.folder}: is not empty, and holds no record: name a new folder")
        said = {"format": FORMAT, "record_of": sha256, "method": plan.method, "tumble": _tumble.version}
        store.write((json.dumps(said, indent=1) + "\n").encode(), DOCUMENT)
    name = os.path.abspath(plan.file) if plan.file else plan.method
    folder = store.folder if "://" in store.folder else store.root
    return Job(folder, name, tuple(map(tuple, plan._sets)), sha256, _tumble.version)  # type: ignore[arg-type]


class _Work:
    """The two rounds over the files."""

    def __init__(self, job: Job, engine: Engine, retries: int, patience: float) -> None:
        self.job, self.engine, self._retries, self._patience = job, engine, retries, patience

    def result(self, store: Store, plan: Plan, names: list[str], call: Call | None) -> Result:
        measured = self._round(measure, [(name,) for name in names], call, "measured", 0.0)
        pieces = [_bytes(store, "pieces", key) for key in measured]
        places = _tumble.places_of_pieces(pieces)
        tasks = list(zip(names, measured, places, strict=True))
        reduced = self._round(reduce, tasks, call, "reduced", 0.5)
        joined, sha256 = _tumble.JoinedParts(), []
        for key in reduced:
            part = _bytes(store, "parts", key)
            sha256.append(part[:64].decode())
            joined.append(part[64:])
        result = Result(joined.identify(plan._core, pieces, sha256))
        store.write(result.to_json().encode(), "record.json")
        return result

    def _round(
        self, function: Callable[..., str], tasks: list[tuple[Any, ...]], call: Call | None, what: str, begin: float
    ) -> list[str]:
        """The keys of what each task wrote, in order. Raises the problems of all files together."""
        keys: list[str] = [""] * len(tasks)
        failed = [0] * len(tasks)
        problems: list[tuple[int, TumbleError]] = []
        waiting = deque(range(len(tasks)))
        in_flight: dict[Future[str], int] = {}
        done_count = 0

        def say(lacks: str) -> None:
            if call is not None:
                call(
                    begin + 0.5 * done_count / len(tasks),
                    f"{done_count} of {len(tasks)} files {what}; waiting for {lacks}",
                )

        answers = Waiting(self.engine, self._patience, say)
        while waiting or in_flight:
            while waiting and not answers.lacking and len(in_flight) < QUEUE * self.engine.slots:
                number = waiting.popleft()
                future = self.engine.submit(function, self.job, *tasks[number])
                in_flight[future] = number
            for future in answers.some_of(in_flight):
                number = in_flight.pop(future)
                error = future.exception()
                if error is None:
                    keys[number] = future.result()
                    done_count += 1
                    if call is not None:
                        call(begin + 0.5 * done_count / len(tasks), f"{done_count} of {len(tasks)} files {what}")
                elif failed[number] < self._retries and isinstance(error, (WorkerDiedError, FileError, OSError)):
                    failed[number] += 1
                    waiting.append(number)
                elif isinstance(error, TumbleError):
                    problems.append((number, error))
                else:
                    raise error
        if problems:
            problems.sort(key=lambda one: one[0])
            texts = [
                text if str(tasks[number][0]) in text else f"{tasks[number][0]}: {text}"
                for number, error in problems
                for text in error.problems
            ]
            raise type(problems[0][1])(texts)
        return keys


def _bytes(store: Store, folder: str, key: str) -> bytes:
    data = store.read(folder, key)
    if data is None:
        raise FileError(f"{store.path(folder, key)}: is not there any more")
    return data


def _key(*parts: object) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def measure(job: Job, name: str) -> str:
    """Measures a file, unless that was done. Returns the key of the piece."""
    _tumble.limit_threads(1)
    store = Store(job.out)
    key = _key(FORMAT, job.version, job.plan_sha256, name, stamp_of(name))
    if not store.has("pieces", key):
        with local_copy(name) as path:
            store.write(
                _tumble.measure_piece(_plan(job.plan, job.sets, job.plan_sha256)._core, path, name), "pieces", key
            )
    return key


def reduce(job: Job, name: str, measured: str, places: bytes) -> str:
    """Reduces a file, unless that was done. Returns the key of the part, which holds the SHA-256 of the file too."""
    _tumble.limit_threads(1)
    store = Store(job.out)
    if measured != _key(FORMAT, job.version, job.plan_sha256, name, stamp_of(name)):
        raise FileError(f"{name}: has changed since it was measured: run it again")
    key = _key(measured, places.hex())
    if not store.has("parts", key):
        with local_copy(name) as path:
            piece = _bytes(store, "pieces", measured)
            part, sha256 = _tumble.reduce_piece(_plan(job.plan, job.sets, job.plan_sha256)._core, path, piece, places)
        store.write(sha256.encode() + part, "parts", key)
    return key
