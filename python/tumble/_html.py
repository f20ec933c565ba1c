"""What notebooks show of a recording and a result: small tables. The whole report is Result.to_html()."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from tumble import _tumble

if TYPE_CHECKING:
    from tumble._channel import Channel
    from tumble._finding import Finding
    from tumble._result_parts import Parameter, Verdict


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = ("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{cells}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def recording_table(title: str, channels: Iterable[Channel]) -> str:
    """The channels of a recording."""
    rows = ((c.name, c.shown_unit, len(c), c.missing, f"{c.rate:.6g}") for c in channels)
    return f"<p>{escape(title)}</p>" + _table(("channel", "unit", "samples", "missing", "rate [Hz]"), rows)


def result_table(
    title: str, parameters: Iterable[Parameter], verdicts: Sequence[Verdict], findings: Sequence[Finding]
) -> str:
    """Parameters, verdicts and findings of a result."""
    rows = (
        (
            p.name,
            p.symbol,
            _tumble.with_uncertainty(p.value, p.sd),
            p.unit,
            f"{p.interval[0]:.6g} to {p.interval[1]:.6g}",
        )
        for p in parameters
    )
    html = f"<p>{escape(title)}</p>"
    html += _table(("parameter", "symbol", "value ± sd", "unit", "95 % interval"), rows)
    if verdicts:
        html += _table(("parameter", "outcome", "limit"), verdicts)
    if findings:
        html += _table(("severity", "finding", "where"), ((f.severity, f.message, f.where) for f in findings))
    return html
