"""The motion for all times: hypotheses on committed enclosures, and what denies them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction

import numpy
import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

import flint
from flint import arb

import tt_precise as tt
from tt_precise.certify import NotProved
from tt_precise.certify.forever import BITS, forever
from tt_precise.certify.vertical_spin import Reduced, TrappingBlock
from tt_precise.golden import proofs, store
from tt_precise.golden.enclosures import Enclosures
from tt_precise.golden.table import Table

STATE = ("0.003", "-0.007", "-0.004", "0.006", "0.0063", "-0.0041")


@pytest.fixture(scope="module", autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(BITS):
        yield


@pytest.fixture(scope="module")
def enclosures(enclosures_of: Callable[[str], Enclosures]) -> Enclosures:
    return enclosures_of("reference")


@pytest.fixture(scope="module")
def blocks(enclosures: Enclosures) -> dict[str, TrappingBlock]:
    return forever(tt.load_scene("reference"), enclosures)


def test_the_reference_inverts_for_ever(blocks: dict[str, TrappingBlock]) -> None:
    held, entered, final = (blocks[name] for name in ("held", "entered", "at_the_end"))
    assert held.pole == entered.pole == final.pole == -1
    assert 6 < float(held.since_s) < 7 < float(entered.since_s) < 8 == float(final.since_s)
    assert held.rate is None
    assert entered.rate is not None
    assert final.rate is not None
    assert 0 < entered.rate < final.rate
    assert held.force > 0
    assert entered.force > 0.99


def test_a_longer_integration_obeys_it(blocks: dict[str, TrappingBlock]) -> None:
    # heyoka in double, to 16 s: theta against the bound, D and E~ against their limits
    trajectory = tt.integrate(replace(tt.load_scene("reference"), until=Fraction(16)))
    frame = trajectory.frame("theta", "D", "E_tilde", "g_n", numbers="float")
    weight = float(trajectory.scene.body.m * trajectory.scene.body.g)
    for block in blocks.values():
        since, rate = float(block.since_s), float(block.rate or 0)
        later = frame[frame["t"] >= since]
        bound = float(block.tilt * block.reached) * numpy.exp(-rate * (later["t"] - since))
        assert (numpy.sin(later["theta"]) <= bound).all()
        assert (later["g_n"] >= float(block.force) * weight).all()
        for name in ("D", "E_tilde"):
            limit = float(block.limits[name])
            assert abs(later[name].iloc[-1] / limit - 1) < 1e-4
            assert abs(later[name].iloc[-1] - limit) < abs(later[name].iloc[0] - limit)


def test_the_reduced_equations_are_the_mechanics() -> None:
    # a state of the golden data, whose rates are compared with differences of its neighbours
    reduced = Reduced(tt.load_scene("reference"), -1)
    x = [arb(text) for text in STATE]
    state = reduced.state(x)
    assert (state.kx * state.kx + state.ky * state.ky + state.kz * state.kz - 1).contains(0)
    turned = reduced.rates([-one for one in x])
    for a, b in zip(reduced.rates(x), turned, strict=True):
        assert (a + b).contains(0)
        assert not a.contains(0)


@pytest.mark.parametrize(("until", "proved"), [("3", set()), ("6", set()), ("7.5", {"held"})])
def test_too_early_less_is_proved(enclosures: Enclosures, until: str, proved: set[str]) -> None:
    # still upright; with too much energy left; and too far from the inverted spin to contract
    table, scene = enclosures.rows, tt.load_scene("reference")
    rows = tuple(row for row in table.rows if float(row[0]) <= float(until))
    early = replace(enclosures, rows=Table(table.columns, rows))
    if proved:
        assert forever(scene, early).keys() == proved
    else:
        with pytest.raises(NotProved, match="W"):
            forever(scene, early)


def test_a_slow_spin_is_not_held_up(enclosures: Enclosures) -> None:
    # below the threshold the inverted spin is unstable, wherever the state lies
    scene = tt.load_scene("just-below-threshold")
    with pytest.raises(NotProved, match="W"):
        forever(scene, enclosures)


@pytest.mark.parametrize("name", ["frictionless", "rolling", "upright"])
def test_what_tends_nowhere(name: str, enclosures: Enclosures) -> None:
    with pytest.raises(NotProved, match=r"friction|vertical from"):
        forever(tt.load_scene(name), enclosures)


def test_upright_the_other_way(enclosures_of: Callable[[str], Enclosures]) -> None:
    found = forever(tt.load_scene("stays-upright"), enclosures_of("stays-upright"))
    assert found["held"].since_s == "0"
    assert {one.as_dict()["theta_tends_to"] for one in found.values()} == {"0"}


ONE_OF_EACH_KIND = ("reference", "tippetopsim", "contact-lost", "frictionless")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name in ONE_OF_EACH_KIND else pytest.mark.slow)
        for name in store.scenes()
        if proofs.read(name) is not None
    ],
)
def test_committed_proofs_say_the_same(
    name: str, enclosures_of: Callable[[str], Enclosures]
) -> None:
    record = proofs.read(name)
    assert record is not None
    enclosures, stated = enclosures_of(name), record.content["forever"]
    if "lost_at_s" in record.content["contact"]:
        assert stated == {"failure": "not proved (F3): contact is lost"}
    elif "failure" in stated:
        with pytest.raises(NotProved):
            forever(tt.load_scene(name), enclosures)
    else:
        found = forever(tt.load_scene(name), enclosures)
        assert {key: one.as_dict() for key, one in found.items()} == stated
