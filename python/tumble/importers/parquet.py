"""Parquet and Arrow (feather) files, with pyarrow."""

from __future__ import annotations

from typing import Any

from tumble._recording import Recording
from tumble._text import need
from tumble.importers import Importer, Request, recording_of
from tumble.importers._table import columns_of


def _table(path: str) -> Any:
    need("pyarrow", "import")
    if path.lower().endswith((".parquet", ".pq")):
        return need("pyarrow.parquet", "import").read_table(path)
    return need("pyarrow.feather", "import").read_table(path)


def _numbers(column: Any) -> Any:
    """Decimal numbers as floats; other columns unchanged."""
    arrow = need("pyarrow", "import")
    return column.cast(arrow.float64()) if arrow.types.is_decimal(column.type) else column


def read(path: str, request: Request) -> Recording:
    """Reads a table. Units are in the names of columns or in the metadata of fields (`unit`)."""
    table = _table(path)
    units = {
        field.name: field.metadata[b"unit"].decode()
        for field in table.schema
        if field.metadata and b"unit" in field.metadata
    }
    named = ((name, _numbers(table[name]).to_numpy()) for name in table.column_names)
    columns, skipped = columns_of(named, {**units, **request.units})
    return recording_of(path, importer.name, columns, request, skipped)


importer = Importer(
    "parquet", "Parquet and Arrow tables, with pyarrow", (".parquet", ".pq", ".feather", ".arrow"), read
)
