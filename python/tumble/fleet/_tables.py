"""The table of a fleet: rows as JSON beside the results, gathered into a Parquet dataset that other programs read.

The dataset has a folder for each model and month of the tests, as Hive names them. A run adds files of up to BATCH
rows, and removes the row files that they replace: one that was interrupted leaves rows for the next one; one that is
repeated adds none. compact() makes few files of each folder.
What takes the place of other files is written before they are removed, so a process that ends between the two loses
nothing: rows that are there twice count once, and the next call removes the second ones.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from typing import Any

from tumble._errors import FileError
from tumble._text import need
from tumble.fleet._store import Store, name_of_key

TEXTS = ("recording", "serial", "model", "method", "status", "error", "verdict", "begun", "ended")
LAST = ("sha256", "plan_sha256", "tumble", "key")
NO_MONTH = "unknown"
BATCH = 2000  # rows that a run keeps in memory: some 35 kB each
LARGE = 10_000  # rows of a file that compact() leaves as it is


def arrow_table(rows: list[dict[str, Any]], document: dict[str, Any]) -> Any:
    """The pyarrow Table of rows. Parameters of one name in different units are in the unit of the first; SI decides."""
    pa = need("pyarrow", "fleet")
    units: dict[str, str] = {}
    for row in rows:
        for name, (_, _, unit) in (row.get("parameters") or {}).items():
            units.setdefault(name, unit)
    fields, columns = [], []

    def add(name: str, kind: Any, values: list[Any], unit: str | None = None) -> None:
        fields.append(pa.field(name, kind, metadata=None if unit is None else {"unit": unit}))
        columns.append(pa.array(values, kind))

    fixed = {"plan_sha256": document["plan_sha256"], "tumble": document["tumble"], "method": document["method"]}
    for name in TEXTS:
        add(name, pa.string(), [row.get(name) or fixed.get(name, "") for row in rows])
    add("warnings", pa.int64(), [row.get("warnings") for row in rows])
    for name, unit in units.items():
        cells = [_in(unit, (row.get("parameters") or {}).get(name)) for row in rows]
        add(name, pa.float64(), [one[0] for one in cells], unit)
        add(f"{name}_sd", pa.float64(), [one[1] for one in cells], unit)
    for name in LAST:
        add(name, pa.string(), [row.get(name) or fixed.get(name, "") for row in rows])
    return pa.Table.from_arrays(columns, schema=pa.schema(fields))


def _in(unit: str, cell: list[Any] | None) -> tuple[float | None, float | None]:
    """Value and sd of a parameter in a unit."""
    if cell is None:
        return None, None
    value, sd, own = cell
    if own == unit or value is None:
        return value, sd
    from tumble import _tumble

    here, there = _tumble.Unit.parse(own), _tumble.Unit.parse(unit)
    if here.dimension != there.dimension:
        return None, None
    spread = None if sd is None else there.difference_from_si(here.difference_to_si(sd))
    return there.from_si(here.to_si(value)), spread


def add_rows(store: Store, document: dict[str, Any], rows: list[dict[str, Any]]) -> None:
    """Adds rows to the dataset, and removes their files.

    A row whose recording has no result (an error) keeps its file: by it a worker sees that the recording was looked at.
    """
    for (model, month), some in _by_folder(rows).items():
        _write_part(store, document, _folder(model, month), some)
    for row in rows:
        if row["status"] == "ok":
            store.remove("rows", document["tumble"], *name_of_key(row["key"]))


def gather(store: Store, document: dict[str, Any]) -> int:
    """Adds the rows that a run left beside the dataset; returns how many files of rows are there no more."""
    version = document["tumble"]
    keys = _keys_of_files(store, "rows", version)
    if not keys:
        return 0
    before, beside = len(keys), set(keys)
    known = {key for key, *_ in _columns(store, version) if key in beside}
    for first in range(0, len(keys), BATCH):
        found = (_row_of_file(store, version, key) for key in keys[first : first + BATCH])
        rows = [row for row in found if row is not None]
        add_rows(store, document, [row for row in rows if row["key"] not in known])
        for row in rows:  # a run ended between the two steps
            if row["key"] in known and row["status"] == "ok":
                store.remove("rows", version, *name_of_key(row["key"]))
    return before - len(_keys_of_files(store, "rows", version))


def compact(store: Store, document: dict[str, Any]) -> tuple[int, int]:
    """Makes few files of each folder of the dataset, of LARGE rows or a little more, and gathers rows beside it.

    Returned: files removed of the dataset, and of rows
    """
    removed = gather(store, document)
    merged = 0
    for folder, names in _parts_by_folder(store).items():
        some: dict[str, dict[str, Any]] = {}
        their: list[str] = []
        for name in [*names, None]:
            if name is not None:
                rows = _rows_of_part(store, name) or []
                if len(rows) < LARGE:
                    some.update((row["key"], row) for row in rows)
                    their.append(name)
            if name is None or len(some) >= LARGE:
                if len(their) > 1:
                    kept = _write_part(store, document, folder, list(some.values()))
                    for one in their:
                        if one != kept:
                            store.remove("table", one)
                            merged += 1
                some, their = {}, []
    return merged, removed


def _parts_by_folder(store: Store) -> dict[str, list[str]]:
    by_folder: dict[str, list[str]] = {}
    for name in store.names("table", suffix=".parquet"):
        by_folder.setdefault(name.rpartition("/")[0], []).append(name)
    return by_folder


def forget(store: Store, document: dict[str, Any], keys: set[str]) -> None:
    """Removes rows, from the dataset too."""
    for name in store.names("table", suffix=".parquet") if keys else []:
        rows = _rows_of_part(store, name) or []
        others = [row for row in rows if row["key"] not in keys]
        if len(others) == len(rows):
            continue
        if others:
            _write_part(store, document, name.rpartition("/")[0], others)
        store.remove("table", name)
    for key in keys:
        store.remove("rows", document["tumble"], *name_of_key(key))


def columns_of_rows(store: Store, version: str) -> Iterator[tuple[str, str, str, str]]:
    """Key, status, error and SHA-256 of each row of a version, those beside the dataset first."""
    for key in _keys_of_files(store, "rows", version):  # before the dataset: what leaves here is there
        row = _row_of_file(store, version, key)
        if row is not None:
            yield row["key"], row["status"], row["error"], row["sha256"]
    yield from _columns(store, version)


def _columns(store: Store, version: str) -> Iterator[tuple[str, str, str, str]]:
    """The same of the dataset; where another run puts files together meanwhile, some twice."""
    seen: set[str] = set()
    while names := [name for name in store.names("table", suffix=".parquet") if name not in seen]:
        for name in names:
            seen.add(name)
            columns = _read_part(store, name, ["key", "status", "error", "sha256", "tumble"])
            if columns is not None:
                for key, status, error, sha256, tumble in zip(*columns, strict=True):
                    if tumble == version:
                        yield key, status, error, sha256


def _keys_of_files(store: Store, *folder: str) -> list[str]:
    return [name.rsplit("/", 1)[-1][:-5] for name in store.names(*folder, suffix=".json")]


def _row_of_file(store: Store, version: str, key: str) -> dict[str, Any] | None:
    """A row; None where it is in the dataset by now, or a power failure has cut it: then it is made again."""
    try:
        row: dict[str, Any] | None = json.loads(store.read("rows", version, *name_of_key(key)) or b"null")
    except ValueError:
        return None
    return row


def _folder(model: str, month: str) -> str:
    return f"model={_safe(model)}/month={month}"


def _by_folder(rows: list[dict[str, Any]]) -> dict[tuple[str, str], list[dict[str, Any]]]:
    """Rows by model and month of the test."""
    by_folder: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        month = row.get("begun", "")[:7] or NO_MONTH
        by_folder.setdefault((row.get("model") or NO_MONTH, month), []).append(row)
    return by_folder


def _write_part(store: Store, document: dict[str, Any], folder: str, rows: list[dict[str, Any]]) -> str:
    """Writes rows as one file; its name, which is returned, is that of its content."""
    pa, pq = need("pyarrow", "fleet"), need("pyarrow.parquet", "fleet")
    rows = sorted(rows, key=lambda row: str(row["key"]))
    table = arrow_table(rows, document)
    table = table.append_column("row", [[json.dumps(row, ensure_ascii=False) for row in rows]])
    buffer = pa.BufferOutputStream()
    pq.write_table(table.drop_columns(["model"]), buffer, compression="zstd")
    part = hashlib.sha256("".join(row["key"] for row in rows).encode()).hexdigest()[:16]
    name = f"{folder}/{part}.parquet"
    store.write(buffer.getvalue().to_pybytes(), "table", name)
    return name


def _safe(text: str) -> str:
    return re.sub(r"[^\w.-]", "_", text)


def _dataset(store: Store) -> list[dict[str, Any]]:
    """All rows of the dataset, read again where another run puts files together meanwhile."""
    while True:
        parts = [_rows_of_part(store, name) for name in store.names("table", suffix=".parquet")]
        if all(part is not None for part in parts):
            return [row for part in parts for row in part or ()]


def _rows_of_part(store: Store, name: str) -> list[dict[str, Any]] | None:
    """The rows of a file of the dataset; None where it is not there any more."""
    columns = _read_part(store, name, ["row"])
    return None if columns is None else [json.loads(cell) for cell in columns[0]]


def _read_part(store: Store, name: str, columns: list[str]) -> list[list[str]] | None:
    """Columns of a file of the dataset. From a buffer of Arrow: its threads must not wait for those of Python."""
    pa, pq = need("pyarrow", "fleet"), need("pyarrow.parquet", "fleet")
    data = store.read("table", name)
    if data is None:
        return None
    try:
        table = pq.ParquetFile(pa.BufferReader(data)).read(columns=columns)
        return [table[column].to_pylist() for column in columns]
    except (pa.ArrowException, KeyError) as error:
        raise FileError(f"{store.path('table', name)}: {error}; remove it, and run the fleet again") from error


def read_parts(store: Store, version: str) -> list[dict[str, Any]]:
    """All rows of a version: those of the dataset, and those that a run left beside it."""
    keys = _keys_of_files(store, "rows", version)  # before the dataset: what leaves here is there
    rows = {row["key"]: row for row in _dataset(store) if row["tumble"] == version}
    for key in keys:
        if key not in rows:
            row = _row_of_file(store, version, key)
            if row is not None:
                rows[key] = row
    return list(rows.values())
