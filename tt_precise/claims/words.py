"""The words of a claim, which are the docstring of its function, and texts with numbers in them.

The first paragraph of the docstring is the statement, the second has the place in the paper and the
quote, and may have a definition and a note: see the example in ``claim``. Braces take a number by
its name: ``{x:3}`` has three significant digits, ``{x:.1%}`` is such as "12.3 %", and
``{rows[theta]:.4g}`` and ``{point.t:4}`` look into a value.
"""

from __future__ import annotations

import inspect
import re
import string
from collections.abc import Mapping
from typing import Any, NamedTuple

from tt_precise.claims.part import decimal

_DOCSTRING = re.compile(
    r'(?P<statement>.+?)\n\n(?P<where>[^"]+): "(?P<quote>[^"]+)"'
    r"(\nDefinition: (?P<definition>.+?))?(\nNote: (?P<note>.+))?",
    re.DOTALL,
)


class Wording(NamedTuple):
    """Statement, place, quote, definition and note of a claim; the last two may be empty."""

    statement: str
    where: str
    quote: str
    definition: str
    note: str

    @classmethod
    def of(cls, docstring: str) -> Wording:
        """Read a docstring.

        Raises
        ------
        ValueError
            The docstring has another form.
        """
        words = _DOCSTRING.fullmatch(inspect.cleandoc(docstring))
        if words is None:
            raise ValueError(
                f"words: got {docstring!r}, expected a statement, and in the next paragraph "
                'where: "quote", Definition: ..., Note: ...'
            )
        return cls(
            **{name: " ".join((text or "").split()) for name, text in words.groupdict().items()}
        )


class _Filler(string.Formatter):
    def format_field(self, value: Any, spec: str) -> str:
        if spec.isdigit():
            return decimal(value, int(spec))
        if isinstance(value, tuple):  # of texts
            return ", ".join(value)
        text: str = super().format_field(value, spec)
        return text.replace("%", " %") if spec.endswith("%") else text


def fill(text: str, names: Mapping[str, Any]) -> str:
    """Return ``text`` with the numbers and texts of ``names`` in place of the braces.

    Raises
    ------
    ValueError
        A name in braces is not in ``names``.
    """
    try:
        return _Filler().vformat(text, (), names)
    except (LookupError, AttributeError, TypeError) as error:
        raise ValueError(
            f"got the name {error} in braces in {text!r}, expected a known one"
        ) from error
