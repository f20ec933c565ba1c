"""What a folder holds, as a database in a temporary file: a fleet may have more units than fit in memory."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from typing import Any, NamedTuple

from tumble.fleet._store import Store, run_of
from tumble.fleet._tables import columns_of_rows

SCHEMA = """
PRAGMA journal_mode = OFF;
CREATE TABLE entry (recording TEXT PRIMARY KEY, serial TEXT, run TEXT, key TEXT, status TEXT, error TEXT, stamp TEXT)
  WITHOUT ROWID;
CREATE TABLE row (key TEXT PRIMARY KEY, status TEXT, error TEXT, sha256 TEXT) WITHOUT ROWID;
"""
# Of the same bytes under several names the first of the latest run counts.
OUTCOMES = """
SELECT recording, serial, key, CASE WHEN status = 'ok' AND place > 1 THEN 'duplicate' ELSE status END AS status,
  CASE WHEN status = 'ok' AND place > 1 THEN 'the same bytes as ' || first ELSE error END AS error FROM (
  SELECT e.recording, e.serial, e.key, coalesce(r.status, 'error') AS status, coalesce(r.error, e.error) AS error,
    CASE WHEN r.sha256 IS NULL OR r.sha256 = '' THEN 1 ELSE row_number() OVER same END AS place,
    first_value(e.recording) OVER same AS first
  FROM entry e LEFT JOIN row r ON e.key = r.key WHERE e.key IS NULL OR r.key IS NOT NULL
  WINDOW same AS (PARTITION BY r.sha256 ORDER BY e.run DESC, e.recording))
"""


class Outcome(NamedTuple):
    """Which row a recording has, and how it ended: ok, error or duplicate."""

    recording: str
    serial: str
    key: str | None
    status: str
    error: str


class Entry(NamedTuple):
    """The last line of the logs on a recording."""

    serial: str
    key: str | None
    status: str
    stamp: str


class Index:
    """Rows and log of one folder and one version of the program, as they were when it was read."""

    def __init__(self, store: Store, version: str) -> None:
        self._database = sqlite3.connect("")  # a file without name, which ends with the connection
        self._database.executescript(SCHEMA)
        for run, lines in _by_run(store):
            self._database.executemany(
                "INSERT OR REPLACE INTO entry VALUES (?, ?, ?, ?, ?, ?, ?)",
                ((*_named(line), run, *_outcome(line)) for line in lines if "status" in line),
            )
        self._database.executemany("INSERT OR REPLACE INTO row VALUES (?, ?, ?, ?)", columns_of_rows(store, version))

    def entry(self, recording: str) -> Entry | None:
        """What the logs say last of a recording; None: nothing."""
        found = self._database.execute(
            "SELECT serial, key, status, stamp FROM entry WHERE recording = ?", (recording,)
        ).fetchone()
        return None if found is None else Entry(*found)

    def has_row(self, key: str) -> bool:
        """Whether the folder has the row of a key."""
        return self._database.execute("SELECT 1 FROM row WHERE key = ?", (key,)).fetchone() is not None

    def forget(self, keys: set[str]) -> None:
        """As if the folder had no such rows."""
        self._database.executemany("DELETE FROM row WHERE key = ?", ((key,) for key in keys))

    def states(self) -> dict[str, int]:
        """How many recordings are ok, error and duplicate."""
        return dict(self._database.execute(f"SELECT status, count(*) FROM ({OUTCOMES}) GROUP BY status"))

    def outcomes(self) -> Iterator[Outcome]:
        """Of all recordings, in order of their names."""
        return map(Outcome._make, self._database.execute(f"{OUTCOMES} ORDER BY recording"))

    def close(self) -> None:
        """Ends the database, and with it its file."""
        self._database.close()


def _by_run(store: Store) -> Iterator[tuple[str, Iterator[dict[str, Any]]]]:
    for name in store.names("log", suffix=".jsonl"):
        yield run_of(name), store.lines("log", name)


def _named(line: dict[str, Any]) -> tuple[str, str]:
    return line["recording"], line["serial"]


def _outcome(line: dict[str, Any]) -> tuple[str | None, str, str, str]:
    stamp = line.get("stamp") or ["", ""]
    return line.get("key"), line["status"], line["error"], stamp_text(stamp)


def stamp_text(stamp: Any) -> str:
    """Size and time of change of a recording as one text."""
    size, changed = stamp
    return f"{size} {changed}"
