"""What a worker does with one recording: copy it here, hash it, identify, write result and row."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import socket
import stat
import tempfile
import time
import warnings
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

from tumble import _tumble, archive
from tumble._errors import DataError, FileError, TumbleError, TumbleWarning, UsageError
from tumble._plan import Plan, plan_of
from tumble.archive import ArchivedRecording
from tumble.fleet._store import FORMAT, Store, filesystem_of, is_local, name_of_key

MEMORY = 2_000_000_000  # [bytes] as tumble.identify


class Job(NamedTuple):
    """What all recordings of a run share. It is small: it goes to a worker with every task."""

    out: str
    plan: str
    sets: tuple[tuple[str, str], ...]
    plan_sha256: str
    version: str
    log: str = ""  # of the run: a worker that sees it shares the folder

    def key(self, sha256: str, serial: str) -> str:
        """The name of everything that a result depends on."""
        said = [FORMAT, self.version, self.plan_sha256, sha256, serial]
        return hashlib.sha256(json.dumps(said, ensure_ascii=False).encode()).hexdigest()


class Task(NamedTuple):
    """One recording. `recording` is its name for people and for the log."""

    recording: str
    serial: str


class Stamp(NamedTuple):
    """By what it is seen that a recording has changed."""

    size: int
    changed: str


ARCHIVE = "archive::"


def name_in_archive(recording: ArchivedRecording) -> str:
    """How a recording of an archive is called: it says where it is."""
    address = recording.address if "://" in recording.address else os.path.abspath(recording.address)
    return f"{ARCHIVE}{address}::{recording.sha256}::{recording.size}::{recording.name}"


def stamp_of(recording: str) -> Stamp:
    """Raises FileError where there is no such recording."""
    if recording.startswith(ARCHIVE):
        _, sha256, length, _ = recording[len(ARCHIVE) :].rsplit("::", 3)
        return Stamp(int(length), sha256)
    fs, path = filesystem_of(recording)
    try:
        if is_local(fs):
            status = os.stat(path)
            if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):
                raise DataError(f"{recording}: is no file (a pipe, a device or a socket): write its data into a file")
            size = status.st_size
            if os.path.isdir(path):
                size = sum(os.stat(os.path.join(path, name)).st_size for name in sorted(os.listdir(path)))
            return Stamp(size, str(status.st_mtime_ns))
        info = fs.info(path)
    except OSError as error:
        raise FileError(f"{recording}: {error}") from error
    changed = info.get("ETag") or info.get("LastModified") or info.get("mtime") or ""
    return Stamp(int(info.get("size") or 0), str(changed))


@contextlib.contextmanager
def local_copy(recording: str) -> Iterator[str]:
    """The path of a recording on this machine: its own, or that of a copy, which is removed."""
    if recording.startswith(ARCHIVE):
        address, sha256, _, name = recording[len(ARCHIVE) :].rsplit("::", 3)
        with tempfile.TemporaryDirectory(prefix="tumble-fleet-") as folder, archive.open(address) as lab:
            copy = os.path.join(folder, os.path.basename(name))
            lab.save(sha256, copy)
            yield copy
        return
    fs, path = filesystem_of(recording)
    if is_local(fs):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="tumble-fleet-") as folder:
        copy = os.path.join(folder, os.path.basename(path))
        try:
            fs.get_file(path, copy)
        except OSError as error:
            raise FileError(f"{recording}: {error}") from error
        yield copy


def sha256_of(path: str) -> str:
    """SHA-256 of the bytes of a file, or of the files of a folder."""
    sha = hashlib.sha256()
    files = [os.path.join(path, name) for name in sorted(os.listdir(path))] if os.path.isdir(path) else [path]
    try:
        for name in files:
            with open(name, "rb") as file:
                while block := file.read(1 << 20):
                    sha.update(block)
    except OSError as error:
        raise FileError(f"{path}: {error}") from error
    return sha.hexdigest()


@lru_cache(maxsize=4)
def _plan(plan: str, sets: tuple[tuple[str, str], ...], plan_sha256: str) -> Plan:
    """The plan of a run. Raises UsageError, which ends the run, where it is another one or not there any more."""
    try:
        made = plan_of(plan, dict(sets))
    except TumbleError as error:
        raise UsageError([f"the plan cannot be read any more: {text}" for text in error.problems]) from error
    if sha256_of_plan(made) != plan_sha256:
        raise UsageError(f"{plan}: the plan has changed since the run began")
    return made


def sha256_of_plan(plan: Plan) -> str:
    """Of all that a plan gives a result: the bytes of its file or the name of the method, `sets`, its calibration."""
    said = [plan._core.sha256 or plan.method, sorted(plan._sets), plan._core.calibration_sha256]
    return hashlib.sha256(json.dumps(said, ensure_ascii=False).encode()).hexdigest()


@lru_cache(maxsize=4)
def _store(out: str) -> Store:
    return Store(out)


@lru_cache(maxsize=4)
def _shares(out: str, log: str) -> bool:
    """Whether this process sees the folder of the run that asks: the driver may be on another machine."""
    return _store(out).has("log", log)


def reduce(job: Job, task: Task) -> dict[str, Any]:
    """Reduces a recording unless that was done before.

    Returned  what the log needs: key, sha256, stamp, status, error, whether it was there, seconds, host, process; the
              row; and the result, where this process does not share the folder of the run: then nothing is written
    Raises    what may be different next time: a file that changes or cannot be read, a full disk, no memory
    """
    _tumble.limit_threads(1)
    if _tumble.version != job.version:
        raise UsageError(
            f"a worker on {where()['host']} has Tumble {_tumble.version}, and the run {job.version}: "
            "install the same version everywhere"
        )
    begin, work = time.monotonic(), time.process_time()
    shares = _shares(job.out, job.log)
    try:
        stamp = stamp_of(task.recording)
    except FileError as error:
        if shares:
            raise
        here = f"the worker on {where()['host']} sees neither the recording nor the folder of the fleet"
        raise FileError(f"{error} ({here})") from error
    with local_copy(task.recording) as path:
        if stamp.size == 0:
            raise DataError(f"{task.recording}: is empty")
        sha256 = sha256_of(path)
        key = job.key(sha256, task.serial)
        store = _store(job.out)
        row, result = _known_row(store, job, task, sha256, key) if shares else None, None
        known = row is not None
        if row is None:
            if shares:
                trace(store, "begins", key, task.recording)
            row, result = _compute(job, task, path, sha256, key)
            if stamp_of(task.recording) != stamp:
                raise FileError(f"{task.recording}: has changed while it was read")
            if shares:
                keep(store, job.version, row, result)
                trace(store, "ends", key, task.recording)
    return {
        "key": key,
        "sha256": sha256,
        "stamp": list(stamp),
        "status": row["status"],
        "error": row["error"],
        "known": known,
        "seconds": round(time.monotonic() - begin, 6),
        "processor_seconds": round(time.process_time() - work, 6),
        **where(),
        "row": row,
        **({} if shares else {"result": result}),
    }


def keep(store: Store, version: str, row: dict[str, Any], result: str | None) -> None:
    """Writes a result and its row."""
    name = name_of_key(row["key"])
    if result is not None:
        store.write(result.encode(), "results", version, *name)
    store.write(json.dumps(row, ensure_ascii=False).encode(), "rows", version, *name)


def where() -> dict[str, Any]:
    """Host and process."""
    return {"host": socket.gethostname(), "process": os.getpid()}


def trace(store: Store, what: str, key: str, recording: str) -> None:
    """Notes on a disk that a worker begins or ends: what is known of a run whose driver was killed."""
    if store.is_local:
        host = where()
        line = json.dumps({"time": time.time(), "work": what, "key": key, "recording": recording, **host})
        path = store.path("log", f"work-{host['host']}-{host['process']}.jsonl")
        try:
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "a", encoding="utf-8") as file:
                file.write(line + "\n")
        except OSError as error:
            raise FileError(f"{path}: {error}") from error


def _known_row(store: Store, job: Job, task: Task, sha256: str, key: str) -> dict[str, Any] | None:
    """The row of what was done before; None: it was not, or a power failure has damaged what it left.

    Where the row is not there (a process ended before it, or the row is in the table) it is made from the result.
    """
    with contextlib.suppress(ValueError):
        row: dict[str, Any] | None = json.loads(store.read("rows", job.version, *name_of_key(key)) or b"null")
        if row is not None:
            return row
    with contextlib.suppress(ValueError):
        document = json.loads(store.read("results", job.version, *name_of_key(key)) or b"null")
        if document is not None:
            return {**_row_without_result(job, task, sha256, key), **_row_of(document)}
    return None


def _row_without_result(job: Job, task: Task, sha256: str, key: str) -> dict[str, Any]:
    return {
        "key": key,
        "recording": task.recording,
        "serial": task.serial,
        "sha256": sha256,
        "plan_sha256": job.plan_sha256,
        "tumble": job.version,
        "status": "ok",
        "error": "",
    }


def _compute(job: Job, task: Task, path: str, sha256: str, key: str) -> tuple[dict[str, Any], str | None]:
    """The row and the result. What the data are to blame for is a row with its error."""
    row = _row_without_result(job, task, sha256, key)
    plan = _plan(job.plan, job.sets, job.plan_sha256)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", TumbleWarning)
            core = _tumble.identify(plan._core, [path], [], MEMORY, None)
        document = json.loads(core.to_json())
        if all(one["sha256"] != sha256 for one in document["provenance"]["inputs"]):
            raise FileError(f"{task.recording}: has changed while it was read")
        core = _tumble.of_unit(core, task.serial, sha256, task.recording)
        text = core.to_json()
        row.update(_row_of(json.loads(text)))
        return row, text
    except FileError as error:
        if not os.path.exists(path) or "has changed" in str(error):
            raise
        row.update(status="error", error=_said(error, path, task))
    except TumbleError as error:
        row.update(status="error", error=_said(error, path, task))
    return row, None


def _said(error: TumbleError, path: str, task: Task) -> str:
    return "\n".join(error.problems).replace(path, task.recording)


def _row_of(document: dict[str, Any]) -> dict[str, Any]:
    """What the table shows of a result."""
    outcomes = [one["outcome"] for one in document["verdicts"]]
    verdict = next((word for word in ("fail", "undecided", "pass") if word in outcomes), "")
    severities = [one["severity"] for one in document["findings"]]
    times = next((one for one in document["tables"] if one["name"] == "recordings"), None)
    begun, ended = "", ""
    if times is not None and times["rows"]:
        names = [column["name"] for column in times["columns"]]
        begun, ended = (str(times["rows"][0][names.index(one)] or "") for one in ("begun", "ended"))
    return {
        "method": document["method"],
        "model": document["instrument"]["model"],
        "verdict": verdict,
        "warnings": severities.count("warning") + severities.count("error"),
        "begun": begun,
        "ended": ended,
        "parameters": {one["name"]: [one["value"], one["sd"], one["unit"]] for one in document["parameters"]},
    }
