"""How a notebook shows what has a name and values: a table in HTML."""

from __future__ import annotations

from collections.abc import Iterable


def table(caption: str, rows: Iterable[tuple[str, object]]) -> str:
    """Two columns in HTML: a name and what it is."""
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
