"""The set of possible errors at one time: Lohner's parallelepiped, B z with z in a box.

Turning the box with the flow, instead of boxing it anew at each step, keeps it from growing by
wrapping (R. Lohner, "Enclosing the solutions of ordinary initial and boundary value problems",
1987). B is any exact invertible matrix: where the flow takes the edges, as long as these stay
well apart, else the orthogonal factor of that, the longest edge first.
"""

from __future__ import annotations

import numpy
from flint import arb, arb_mat

from tt_precise.certify.balls import NotProved, largest

# While its edges are this far from dependent, the box is carried along as it is and nothing wraps.
LARGEST_CONDITION = 30


class LohnerSet:
    """{B z : z in box}, which contains exact minus approximate state."""

    def __init__(self, basis: arb_mat, inverse: arb_mat, box: arb_mat):
        if not all(entry.is_finite() for entry in box.entries()):
            raise NotProved("error set", "the set of errors could not be bounded")
        self._basis, self._inverse, self._box = basis, inverse, box

    @classmethod
    def of(cls, differences: list[arb]) -> LohnerSet:
        """The box itself."""
        size = len(differences)
        identity = arb_mat([[int(i == j) for j in range(size)] for i in range(size)])
        return cls(identity, identity, arb_mat(size, 1, differences))

    @property
    def hull(self) -> list[arb]:
        """A ball for each component."""
        return (self._basis * self._box).entries()

    def shifted(self, more: list[arb]) -> LohnerSet:
        """Contains x + y for every x in this set and y in the balls ``more``."""
        box = self._box + self._inverse * arb_mat(len(more), 1, more)
        return LohnerSet(self._basis, self._inverse, box)

    def moved(self, flow: arb_mat, more: list[arb]) -> LohnerSet:
        """Contains flow x + y for every x in this set and y in the balls ``more``.

        Raises ``NotProved``: no basis was found, or no bound.
        """
        image = flow * self._basis
        basis = _basis_for(image, self._box)
        try:
            inverse = basis.inv()
        except ZeroDivisionError:
            raise NotProved("error set", "no basis could be found for it") from None
        box = (inverse * image) * self._box + inverse * arb_mat(len(more), 1, more)
        return LohnerSet(basis, inverse, box)


def _basis_for(image: arb_mat, box: arb_mat) -> arb_mat:
    # any invertible matrix is right, so floats and their rounding are welcome here
    columns = numpy.array([[float(x.mid()) for x in row] for row in image.tolist()])
    lengths = numpy.linalg.norm(columns, axis=0)
    if lengths.min() > 0 and numpy.linalg.cond(columns / lengths) < LARGEST_CONDITION:
        return arb_mat((columns / lengths).tolist())
    edges = [abs(x).upper() for x in box.entries()]
    longest = largest(edges)
    scale = [float(edge / longest) if longest > 0 else 1.0 for edge in edges]
    order = numpy.argsort(-lengths * numpy.array(scale), kind="stable")
    factor, _ = numpy.linalg.qr(columns[:, order])
    return arb_mat(factor.tolist())
