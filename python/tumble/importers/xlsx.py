"""Excel sheets (.xlsx), with openpyxl."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from tumble._errors import DataError
from tumble._recording import Recording
from tumble._text import need
from tumble.importers import Importer, Request, recording_of
from tumble.importers._table import columns_of


def read(path: str, request: Request) -> Recording:
    """Reads the first sheet: one header row with `name[unit]`, then one row a sample; a blank cell is missing."""
    book = need("openpyxl", "import").load_workbook(path, read_only=True, data_only=True)
    try:
        sheet = book.worksheets[0]
        rows = list(sheet.iter_rows(values_only=True))
    finally:
        book.close()
    while rows and all(cell is None for cell in rows[-1]):
        rows.pop()
    if len(rows) < 2:
        raise DataError(f"{path}: the sheet {sheet.title!r} holds no rows below a header")
    columns, skipped = columns_of(_named(rows), request.units)
    return recording_of(path, importer.name, columns, request._replace(missing="nan"), skipped)


def _named(rows: Sequence[Sequence[Any]]) -> Iterator[tuple[str, Any]]:
    import numpy as np

    for k, header in enumerate(rows[0]):
        cells = [row[k] if k < len(row) else None for row in rows[1:]]
        if header is None:
            continue
        if all(cell is None or (isinstance(cell, (int, float)) and not isinstance(cell, bool)) for cell in cells):
            yield str(header), np.array([np.nan if cell is None else cell for cell in cells], dtype=np.float64)
        elif all(hasattr(cell, "isoformat") and hasattr(cell, "year") for cell in cells):
            yield str(header), np.array(cells, dtype="datetime64[us]")
        else:
            yield str(header), np.array([str(cell) for cell in cells])


importer = Importer("xlsx", "Excel sheets, with openpyxl", (".xlsx", ".xlsm"), read)
