"""A certificate: the starts and lengths of the pieces of an approximate solution.

Of each piece: its unit of time as a power of two, its length in that unit, and the state at its
beginning, exact (mantissa, hexadecimal, and exponent of two). ``checker`` computes the rest.
"""

from __future__ import annotations

import hashlib
import json
import lzma
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flint import arb, fmpz

from tt_precise.golden.store import Stored, scene_sha256
from tt_precise.runtime import records
from tt_precise.runtime.values import Json

if TYPE_CHECKING:
    from tt_precise.certify.proof import Proof

SCHEMA = "tt_precise.certificate/1"
FILE = "certificate.json.xz"
FIELDS = {"schema", "scene", "scene_sha256", "bits", "order", "pieces"}
MOST_BITS, MOST_ORDER, MOST_POWER = 10_000, 10_000, 100_000
MOST_BYTES = 100_000_000  # unpacked; that of the reference scene has 0.8 MB


class Refused(ArithmeticError):  # noqa: N818 - a verdict, not a mistake
    """The certificate does not prove the golden data; the message says where."""


class TooWide(Refused):
    """The enclosure is too wide to decide whether the numbers are right: more bits may help."""


@dataclass(frozen=True)
class Accepted:
    """What a certificate proves: so many pieces, printed numbers and events.

    ``lost`` says that contact is lost, at the last of these.
    """

    scene: str
    pieces: int
    numbers: int
    events: int
    lost: bool = False

    @property
    def summary(self) -> str:
        contact = ", at the last of which contact is lost" if self.lost else ""
        return (
            f"{self.scene}: accepted: {self.pieces} pieces prove {self.numbers} printed numbers, "
            f"{self.events} events at their times{contact}"
        )


def content_of(stored: Stored, proof: Proof) -> dict[str, Json]:
    """The certificate of a proof: the pieces that it went through."""
    steps = proof.enclosure.steps
    return {
        "schema": SCHEMA,
        "scene": stored.name,
        "scene_sha256": scene_sha256(stored.scene_text),
        "bits": proof.enclosure.bits,
        "order": max(p.degree() for p in steps[0].piece.polynomials),
        "pieces": [
            [
                int(step.piece.unit.man_exp()[1]),
                *(_dyadic(x) for x in (step.piece.end, *step.piece.first)),
            ]
            for step in steps
        ],
    }


def packed(content: dict[str, Json]) -> bytes:
    """The certificate's file: JSON with its own hash, compressed."""
    text = json.dumps(content, separators=(",", ":"))
    hashed = hashlib.sha256(text.encode()).hexdigest() + text
    return lzma.compress(hashed.encode(), preset=6)


def unpacked(data: bytes) -> dict[str, Json]:
    """The content of a certificate's file.

    Raises ``Refused``: it has changed since it was written.
    """
    try:
        unpacking = lzma.LZMADecompressor()
        hashed = unpacking.decompress(data, MOST_BYTES).decode()
        if not unpacking.eof or unpacking.unused_data:
            raise Refused(
                f"the certificate is cut off, more than one, or more than {MOST_BYTES / 1e6:g} MB"
            )
        content = records.parse(hashed[64:])
    except (lzma.LZMAError, EOFError, UnicodeDecodeError, ValueError) as error:
        raise Refused(f"the certificate cannot be read ({type(error).__name__})") from None
    if hashlib.sha256(hashed[64:].encode()).hexdigest() != hashed[:64]:
        raise Refused("the certificate was changed after it was written")
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise Refused(f"the certificate has another schema, expected {SCHEMA}")
    if content.keys() != FIELDS:
        raise Refused(f"the certificate has other fields, expected {', '.join(sorted(FIELDS))}")
    return content


def bounded(number: Json, least: int, most: int) -> int:
    """A whole number of a certificate, which says how much work and memory it takes.

    Raises ``Refused``: it is not a whole number, or is out of bounds.
    """
    if type(number) is not int or not least <= number <= most:
        raise Refused(f"got {str(number)[:20]}, expected a whole number from {least} to {most}")
    return number


def _dyadic(number: arb) -> str:
    mantissa, exponent = number.man_exp()
    return f"{int(mantissa):x}p{int(exponent)}"


def exactly(text: str) -> arb:
    """The number that is written in this way.

    Raises ``Refused``: the text is not such a number.
    """
    try:
        mantissa, exponent = text.split("p")
        power = bounded(int(exponent), -MOST_POWER, MOST_POWER)
        return arb(fmpz(int(mantissa, 16))) * arb(2) ** power
    except (ValueError, AttributeError):
        raise Refused(f"got {str(text)[:50]!r}, expected a mantissa and an exponent") from None
