"""What became of a top: a statement about its state at the end.

- ``inverts``: the axis has crossed the equator and is below it at the end.
- ``does_not_invert``: it will never reach the equator. The energy does not rise and lambda is
  constant, and to get there takes more energy than the top has at the end.
- ``undecided``: neither, at the horizon.
- ``contact_lost``, ``singular_contact``: the model ended there. ``failed``: the integration did.
"""

from __future__ import annotations

import numpy

from tt_precise.mechanics.thresholds import least_energy
from tt_precise.runtime.arithmetic import Array
from tt_precise.scene.body import Parameters

OUTCOMES = {
    "inverts": "has crossed the equator, and the axis is below it at the end",
    "does_not_invert": "energy and lambda at the end exclude that the axis reaches the equator",
    "undecided": "neither is known at the horizon",
    "contact_lost": "the normal force g_n reached 0",
    "singular_contact": "the denominator of g_n reached 0",
    "failed": "the integration failed",
}
WALLS = 129  # inclinations between the axis and the equator at which the energy is compared
SURE = 2.0**-40  # of the energy: far more than its rounding errors


def outcomes(
    body: Parameters,
    z: Array,
    lambda_: Array,
    energy: Array,
    crossed: Array,
    falling: bool = True,
) -> list[str]:
    """The outcomes of tops that kept contact.

    Parameters
    ----------
    body
        Numbers, or an array with a body for each top.
    z, lambda_, energy
        cos theta, Jellett's integral and energy of each top at the end, in the units of ``body``.
    crossed
        Whether theta has risen through pi/2.
    falling
        Whether the energy cannot rise from there: with g_n < 0 it may.
    """
    with numpy.errstate(all="ignore"):
        walls = z * numpy.linspace(0, 1, WALLS)[:, None]
        highest = numpy.asarray(least_energy(body, walls, lambda_)).max(axis=0)
        held = (highest - energy > SURE * numpy.abs(energy)) & falling
    names = numpy.where(held, "does_not_invert", "undecided")
    return numpy.where(crossed & (z < 0), "inverts", names).tolist()
