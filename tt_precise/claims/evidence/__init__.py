"""What the claims rest on, computed once a process: runs, proofs, sweeps, formulas as text."""

from tt_precise.claims.evidence.run import (
    DEFINITIONS,
    FINE,
    MANY,
    REFERENCE,
    Run,
    SceneLike,
    Span,
    rough,
    rows_of,
    variant,
)

__all__ = [
    "DEFINITIONS",
    "FINE",
    "MANY",
    "REFERENCE",
    "Run",
    "SceneLike",
    "Span",
    "rough",
    "rows_of",
    "variant",
]
