"""The folder of a fleet as a value: its table, its log, its results, its summary."""

from __future__ import annotations

import contextlib
import datetime
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from tumble import _tumble
from tumble._errors import UsageError, wrong_type
from tumble._result import Result, _from_text
from tumble._text import need, path_text, sets_of, words_of
from tumble.fleet._index import Index
from tumble.fleet._store import DOCUMENT, Store, name_of_key, run_of
from tumble.fleet._tables import arrow_table, compact, read_parts

BATCH = 100  # results in a transaction of an archive


class Status(NamedTuple):
    """What is done. `pending` recordings were given to a run that has not come to them."""

    recordings: int
    ok: int
    errors: int
    duplicates: int
    pending: int
    other_versions: int

    def __str__(self) -> str:
        text = f"{self.recordings} recordings: {self.ok} done, {self.errors} with an error"
        for count, what in ((self.duplicates, "duplicates"), (self.pending, "to do")):
            text += f", {count} {what}" if count else ""
        if self.other_versions:
            text += f"; {self.other_versions} results of other versions of the program, which are not used"
        return text


class Fleet:
    """The results of many units in one folder."""

    def __init__(self, folder: Store | str | os.PathLike[str]) -> None:
        self._store = folder if isinstance(folder, Store) else Store(path_text(folder, "folder"))
        document = self._store.json(DOCUMENT)
        if document is None:
            raise UsageError(f"{self._store.folder}: holds no fleet: tumble.fleet.run(plan, recordings, out) makes one")
        self._document: dict[str, Any] = document

    @property
    def folder(self) -> str:
        """The folder."""
        return self._store.folder

    def _rows(self) -> list[dict[str, Any]]:
        """One row a recording, in order of their names."""
        rows: dict[str | None, dict[str, Any]] = {}
        with contextlib.closing(self._index()) as index:
            rows.update((row["key"], row) for row in read_parts(self._store, self._document["tumble"]))
            return [
                {
                    **rows.get(one.key, {"sha256": "", "serial": one.serial}),
                    "recording": one.recording,
                    "status": one.status,
                    "error": one.error,
                }
                for one in index.outcomes()
            ]

    def table(self) -> Any:
        """A pyarrow Table: a row for each recording, by name, with each parameter and its sd (`NAME_sd`).

        It depends on recordings, plan and version alone: time, host and process stand in log(). A parameter's unit is
        in the metadata of its field. `status` is ok, error or duplicate.
        """
        return arrow_table(self._rows(), self._document)

    def log(self) -> Any:
        """A pyarrow Table: what was done when and where, how long it took, what was repeated."""
        pa = need("pyarrow", "fleet")
        lines = []
        for name in self._store.names("log", suffix=".jsonl"):
            for line in self._store.lines("log", name):
                lines.append({"log": name, **{key: value for key, value in line.items() if key != "stamp"}})
        lines.sort(key=lambda line: (line.get("time", 0.0), line["log"]))
        names: dict[str, None] = {}
        for line in lines:
            names.update(dict.fromkeys(line))
        columns = {}
        for name in names:
            values = [line.get(name) for line in lines]
            if len({type(value) for value in values if value is not None}) > 1:
                numbers = all(isinstance(value, (int, float)) for value in values if value is not None)
                values = [None if value is None else float(value) if numbers else str(value) for value in values]
            columns[name] = values
        return pa.table(columns)

    def errors(self) -> dict[str, str]:
        """What went wrong, by recording."""
        with contextlib.closing(self._index()) as index:
            return {one.recording: one.error for one in index.outcomes() if one.status == "error"}

    def status(self) -> Status:
        """How much is done."""
        with contextlib.closing(self._index()) as index:
            states = index.states()
        others = {
            name
            for folder in ("rows", "results")
            for version in self._store.folders(folder)
            if version != self._document["tumble"]
            for name in self._store.names(folder, version, suffix=".json")
        }
        pending = self._pending()
        ok, errors, duplicates = (states.get(state, 0) for state in ("ok", "error", "duplicate"))
        return Status(sum(states.values()) + pending, ok, errors, duplicates, pending, len(others))

    def _index(self) -> Index:
        return Index(self._store, self._document["tumble"])

    def _pending(self) -> int:
        """What the last run has not come to."""
        logs = [name for name in self._store.names("log", suffix=".jsonl") if name.startswith("run-")]
        to_do = 0
        for name in logs:
            if run_of(name) == run_of(logs[-1]):
                for line in self._store.lines("log", name):
                    to_do += int(line["to_do"]) if line.get("run") == "begins" else -("status" in line)
        return max(0, to_do)

    def result(self, recording: str) -> Result:
        """The result of one recording. Raises UsageError with the error of its row, or that it is absent."""
        row = next((row for row in self._rows() if row["recording"] == recording), None)
        if row is None:
            raise UsageError(f"argument recording: {recording!r} is not in the fleet of {self.folder}")
        if row["status"] == "error":
            raise UsageError(f"{recording}: {row['error']}")
        return self._result(row["key"])

    def _result(self, key: str) -> Result:
        return _from_text(self._text(key), key)

    def _text(self, key: str) -> str:
        data = self._store.read("results", self._document["tumble"], *name_of_key(key))
        if data is None:
            raise UsageError(f"{self.folder}: the result {key} is not there")
        return data.decode()

    def compact(self) -> tuple[int, int]:
        """Makes few Parquet files of each folder of the dataset, of 10 000 rows or a little more.

        Runs add files; after many of them this makes the folder small and quick to read. It may be interrupted, and
        runs may work in the folder meanwhile.

        Returned  how many Parquet files were removed, and how many files of rows that a killed run had left
        """
        return compact(self._store, self._document)

    def summary(self, parameters: Iterable[str] = (), limits: Mapping[str, object] | None = None) -> Result:
        """What the units have in common: the same numbers as `tumble fleet summary`.

        Given     parameters  names; empty: all
                  limits      by parameter: (lower, upper) with units, one of them may be None: for capability and risk
        Returned  a result: mean and spread of each parameter, components, outliers, batches, capability, risk and the
                  guard band that follows from the fleet
        Raises    DataError for fewer than three units
        """
        with self._local() as folder:
            return Result(_tumble.fleet_summary(folder, words_of(parameters, "parameters"), _limit_sets(limits)))

    def report(self, path: str | os.PathLike[str], **arguments: Any) -> None:
        """Writes the summary as an HTML page. Given: arguments of summary()."""
        self.summary(**arguments).save(path)

    def _local(self) -> Any:
        """The folder on this machine: a copy of the results where it is in an object store."""
        return _Local(self._store, self._document["tumble"])

    def to_archive(self, address: str, *, by: str | None = None) -> dict[str, int]:
        """Puts all results into an archive; those that it has already change nothing.

        Returned  how many results were new, and how many the archive had
        """
        from tumble import archive

        total = {"results": 0, "known": 0}
        rows = [row for row in self._rows() if row["status"] == "ok"]
        with archive.open(address) as target:
            for first in range(0, len(rows), BATCH):
                results = [
                    (
                        self._text(row["key"]),
                        f"{row['key']}.json",
                        row["model"] or self._document["method"],
                        row["serial"],
                    )
                    for row in rows[first : first + BATCH]
                ]
                done = target._ingest_results(results, archive.name_of_user(by))
                for name in total:
                    total[name] += done[name]
        return total

    def __repr__(self) -> str:
        return f"<Fleet {self.folder}: {self.status()}>"

    def _repr_html_(self) -> str:
        from html import escape

        return f"<p><b>Fleet</b> {escape(self.folder)}<br>{escape(str(self.status()))}</p>"


class _Local:
    """Context: the folder of a fleet on this machine."""

    def __init__(self, store: Store, version: str) -> None:
        self._store, self._version = store, version
        self._copy: tempfile.TemporaryDirectory[str] | None = None

    def __enter__(self) -> str:
        if self._store.is_local:
            return self._store.root
        self._copy = tempfile.TemporaryDirectory(prefix="tumble-fleet-")
        local = Store(self._copy.name)
        local.write(self._store.read(DOCUMENT) or b"", DOCUMENT)
        for folder, suffix in ((("results", self._version), ".json"), (("log",), ".jsonl")):
            for name in self._store.names(*folder, suffix=suffix):
                data = self._store.read(*folder, name)
                if data is not None:
                    local.write(data, *folder, name)
        return self._copy.name

    def __exit__(self, *_: object) -> None:
        if self._copy is not None:
            self._copy.cleanup()


def _limit_sets(limits: Mapping[str, object] | None) -> list[tuple[str, str]]:
    sets: dict[str, object] = {}
    if limits is not None and not isinstance(limits, Mapping):
        raise wrong_type("limits", limits, 'accepted is a dict such as {"x.bias": ("-1 mg", "1 mg")}')
    for name, both in (limits or {}).items():
        if not isinstance(both, (tuple, list)) or len(both) != 2:
            raise wrong_type(f"limits[{name!r}]", both, "accepted is (lower, upper), with None for no limit")
        sets.update(
            {f"{name}.{end}": value for end, value in zip(("min", "max"), both, strict=True) if value is not None}
        )
    return sets_of(sets, "limits")


def now_utc() -> str:
    """UTC, to the second."""
    return datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def rows_of(fleet: Fleet) -> Iterator[dict[str, Any]]:
    """The rows of a fleet, for what shows them."""
    yield from fleet._rows()
