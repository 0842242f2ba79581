"""Tables in HTML for notebooks."""

from __future__ import annotations

from collections.abc import Iterable


def table(caption: str, rows: Iterable[tuple[str, object]]) -> str:
    """Two columns in HTML: names and values."""
    from html import escape  # here, because every scene imports this

    body = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(str(value))}</td></tr>'
        for name, value in rows
    )
    return (
        f'<table><caption style="text-align:left">{escape(caption)}</caption>'
        f"<tbody>{body}</tbody></table>"
    )
