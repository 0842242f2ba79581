"""What holds a motion for ever by its energy: the algebra of the proof, and what denies it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest
import sympy

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

import flint

import tt_precise as tt
from tt_precise.certify import NotProved
from tt_precise.certify.energy_well import held
from tt_precise.certify.forever import BITS
from tt_precise.golden.enclosures import Enclosures
from tt_precise.golden.table import Table
from tt_precise.mechanics.thresholds import least_energy, tumbling_lambda_squared
from tt_precise.scene.body import Parameters


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(BITS):
        yield


def row_at(enclosures: Enclosures, t: str) -> int:
    return enclosures.rows.column("t").index(t)


def test_what_never_glides_keeps_its_inclination() -> None:
    # the bracket of the proof: B'(theta) - phi_dot R (1 - alpha cos theta)
    theta, alpha, R, I1, I3, Lz, spin = sympy.symbols(
        "theta alpha R I1 I3 Lz omega_3", positive=True
    )
    s, c = sympy.sin(theta), sympy.cos(theta)
    phi_dot = (Lz - I3 * spin * c) / (I1 * s**2)
    B = R * s * (spin + (alpha - c) * phi_dot)
    bracket = sympy.diff(B, theta) - phi_dot * R * (1 - alpha * c)
    assert sympy.simplify(bracket - spin * R * (c + (alpha - c) * I3 / I1)) == 0


def test_the_least_energy_is_stationary_where_the_top_tumbles() -> None:
    names = ("m", "R", "alpha", "I1", "I3", "g", "mu")
    body = Parameters(*sympy.symbols(" ".join(names), positive=True))
    z, lambda_ = sympy.symbols("z lambda")
    slope = sympy.diff(least_energy(body, z, lambda_), z)
    there = slope.subs(lambda_, sympy.sqrt(tumbling_lambda_squared(body, z)))
    assert sympy.simplify(there) == 0


def test_no_state_has_less_than_the_least_energy() -> None:
    # all rows of the golden data, whose lambda is one number
    scene = tt.load_scene("reference")
    run = tt.integrate(replace(scene, until=Fraction(8)))
    frame = run.frame("E", "lambda", "kz", numbers="float")
    least = least_energy(scene.body.numbers(float), frame["kz"], frame["lambda"])
    assert (frame["E"] >= least * (1 - 1e-12)).all()
    # and it is closed in on: at the end little is left
    assert frame["E"].iloc[-1] / least.iloc[-1] < 1.001


def test_strong_friction_is_held_long_before_it_contracts(
    enclosures_of: Callable[[str], Enclosures],
) -> None:
    scene, known = tt.load_scene("tippetopsim"), enclosures_of("tippetopsim")
    found = held(scene, known, row_at(known, "1.5"))
    assert found.rate is None
    assert found.force > 0.4
    run = tt.integrate(replace(scene, until=Fraction(8)))
    later = run.frame("theta", "g_n", numbers="float").query("t >= 1.5")
    weight = float(scene.body.m * scene.body.g)
    assert later["g_n"].min() >= float(found.force) * weight
    assert (later["theta"] > 3.14159265 - 1.01 * float(found.tilt)).all()


@pytest.mark.parametrize(
    ("name", "t", "why"),
    [
        ("reference", "5", "W"),
        ("tippetopsim", "1", "W"),
        ("just-below-threshold", "60", "W1"),
        ("contact-lost", "1", "W"),
    ],
)
def test_what_is_not_held(
    name: str, t: str, why: str, enclosures_of: Callable[[str], Enclosures]
) -> None:
    known = enclosures_of(name)
    with pytest.raises(NotProved, match=why):
        held(tt.load_scene(name), known, row_at(known, t))


def moved(known: Enclosures, t: str, column: str, by: str) -> Enclosures:
    """One number of a row changed where it is printed; its last digits stay."""
    table = known.stored.trajectory
    row, place = row_at(known, t), table.columns.index(column)
    cells = list(table.rows[row])
    cells[place] = str(Decimal(cells[place]) + Decimal(by))
    rows = (*table.rows[:row], tuple(cells), *table.rows[row + 1 :])
    return replace(known, stored=replace(known.stored, trajectory=Table(table.columns, rows)))


def test_more_energy_than_there_is_is_noticed(enclosures_of: Callable[[str], Enclosures]) -> None:
    # the same row with the contact point gliding at 0.5 m/s
    known, scene = enclosures_of("reference"), tt.load_scene("reference")
    row = row_at(known, "7")
    assert held(scene, known, row).force > 0
    with pytest.raises(NotProved, match="W"):
        held(scene, moved(known, "7", "vx", "0.5"), row)
