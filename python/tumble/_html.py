"""What notebooks show of a recording and a result: small tables. The whole report is Result.to_html()."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from tumble import _tumble

if TYPE_CHECKING:
    from tumble._recording import Recording
    from tumble._result import Result


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = ("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{cells}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def recording_table(recording: Recording) -> str:
    """The channels of a recording."""
    rows = ((c.name, c.shown_unit, len(c), c.missing, f"{c.rate:.6g}") for c in recording.values())
    title = escape(f"{recording.file or 'in memory'}, {recording.duration:.6g} s")
    return f"<p>{title}</p>" + _table(("channel", "unit", "samples", "missing", "rate [Hz]"), rows)


def result_table(result: Result) -> str:
    """Parameters, verdicts and findings of a result."""
    parameters = (
        (
            p.name,
            p.symbol,
            _tumble.with_uncertainty(p.value, p.sd),
            p.unit,
            f"{p.interval[0]:.6g} to {p.interval[1]:.6g}",
        )
        for p in result.parameters.values()
    )
    html = f"<p>{escape(result.title)}</p>"
    html += _table(("parameter", "symbol", "value ± sd", "unit", "95 % interval"), parameters)
    if result.verdicts:
        html += _table(("parameter", "outcome", "limit"), result.verdicts)
    if result.findings:
        html += _table(("severity", "finding", "where"), ((f.severity, f.message, f.where) for f in result.findings))
    return html
