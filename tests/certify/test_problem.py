"""The problem of a scene: its start, and the components that stay zero."""

import flint
from flint import arb

import tt_precise as tt
from tt_precise.certify import problem_of
from tt_precise.certify.kernel import StateSet
from tt_precise.certify.models import Rates


def names(scene: tt.Scene) -> set[str]:
    """Return the names of the components that stay zero."""
    with flint.ctx.workprec(240):
        found = problem_of(scene)
        rates = Rates(found.phases[0].rates, len(found.start))
        free = StateSet.of(rates, arb(0), found.start).free
    columns = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "s_dot_x", "s_dot_y")
    return {name for i, name in enumerate(columns) if i not in free}


def test_what_stays_zero_in_the_scenes() -> None:
    assert names(tt.load_scene("upright")) == {"kx", "ky", "Lx", "Ly", "s_dot_x", "s_dot_y"}
    assert names(tt.load_scene("reference")) == set()
    rocking = tt.load_scene("rocking")
    assert names(rocking) == {"ky", "Lx", "Lz", "s_dot_y"}
    # a spin however small leaves the plane; zero at the start is not enough
    assert names(rocking.varied(omega_3="1e-60")) == set()
    rates = Rates(lambda y: [1 + 0 * y[0], y[0] - 1 + y[1]], 2)
    assert StateSet.of(rates, arb(0), [arb(1), arb(0)]).free == [0, 1]
