"""The table of a fleet: rows as JSON beside the results, gathered into a Parquet dataset that other programs read.

The dataset has a folder for each model and month of the tests, as Hive names them. Files are only added: a run that was
interrupted leaves rows for the next one, and one that is repeated adds none.
"""

from __future__ import annotations

import hashlib
import json
import re
from typing import Any

from tumble._text import need
from tumble.fleet._store import Store, name_of_key

TEXTS = ("recording", "serial", "model", "method", "status", "error", "verdict", "begun", "ended")
LAST = ("sha256", "plan_sha256", "tumble", "key")
NO_MONTH = "unknown"


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


def write_parts(store: Store, document: dict[str, Any]) -> int:
    """Adds rows that the dataset does not have yet; returns their number. The name of a file is that of its content."""
    pa, pq = need("pyarrow", "fleet"), need("pyarrow.parquet", "fleet")
    version = document["tumble"]
    known = {row["key"] for row in _dataset(store)}
    by_folder: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for name in store.names("rows", version, suffix=".json"):
        key = name.rsplit("/", 1)[-1][:-5]
        if key in known:
            continue
        row = store.json("rows", version, *name_of_key(key))
        month = row.get("begun", "")[:7] or NO_MONTH
        by_folder.setdefault((row.get("model") or NO_MONTH, month), []).append(row)
    for (model, month), rows in by_folder.items():
        table = arrow_table(rows, document)
        table = table.append_column("row", [[json.dumps(row, ensure_ascii=False) for row in rows]])
        buffer = pa.BufferOutputStream()
        pq.write_table(table.drop_columns(["model"]), buffer, compression="zstd")
        data = buffer.getvalue().to_pybytes()
        part = hashlib.sha256("".join(row["key"] for row in rows).encode()).hexdigest()[:16]
        store.write(data, "table", f"model={_safe(model)}", f"month={month}", f"{part}.parquet")
    return sum(map(len, by_folder.values()))


def forget(store: Store, version: str, keys: set[str]) -> None:
    """Removes rows; the other rows of their Parquet files are added again at the end of the run."""
    for name in store.names("table", suffix=".parquet") if keys else []:
        if keys.intersection(_column(store, name, "key")):
            store.fs.rm_file(store.path("table", name))
    for key in keys:
        if store.has("rows", version, *name_of_key(key)):
            store.fs.rm_file(store.path("rows", version, *name_of_key(key)))


def _safe(text: str) -> str:
    return re.sub(r"[^\w.-]", "_", text)


def _dataset(store: Store) -> list[dict[str, Any]]:
    rows = []
    for name in store.names("table", suffix=".parquet"):
        rows += [json.loads(cell) for cell in _column(store, name, "row")]
    return rows


def _column(store: Store, name: str, column: str) -> list[Any]:
    """One column of a file of the dataset. From a buffer of Arrow: its threads must not wait for those of Python."""
    pa, pq = need("pyarrow", "fleet"), need("pyarrow.parquet", "fleet")
    data = store.read("table", name)
    if data is None:
        return []
    cells: list[Any] = pq.ParquetFile(pa.BufferReader(data)).read(columns=[column])[column].to_pylist()
    return cells


def read_parts(store: Store, version: str) -> list[dict[str, Any]]:
    """All rows of a version: those of the dataset, and those that a run left beside it."""
    rows = {row["key"]: row for row in _dataset(store) if row["tumble"] == version}
    for name in store.names("rows", version, suffix=".json"):
        key = name.rsplit("/", 1)[-1][:-5]
        if key not in rows:
            rows[key] = store.json("rows", version, *name_of_key(key))
    return list(rows.values())
