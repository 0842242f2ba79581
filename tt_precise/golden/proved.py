"""Which shipped scenes have digits that are proved, so that no proof is deleted unnoticed."""

from __future__ import annotations

PROVED = frozenset(
    {
        "below-threshold", "beside-the-pole", "contact-lost", "coulomb-gliding", "frictionless",
        "from-initiation", "inverted", "just-above-threshold", "just-below-threshold", "kicked",
        "phi-dot-195", "phi-dot-83", "phi-dot-minus-10", "reference", "regularised-1e-2",
        "regularised-1e-4", "rocking", "rolling", "smoothest", "stays-upright", "steep",
        "tippetopsim", "track", "upright"
    }
)  # fmt: skip
