"""A scene at its edges: what is changed, what is found, and what it is told as."""

from __future__ import annotations

from fractions import Fraction

import pytest

import tt_precise as tt
from tests.conftest import Printed, Said
from tt_precise.extremes import edges
from tt_precise.extremes.edges import (
    REFUSED,
    Edge,
    EdgeOutcome,
    findings,
    outcome,
    shortened,
    table,
)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edges, "TILTS", ("1e-1", "1e-300"))
    monkeypatch.setattr(edges, "POWERS_OF_SPIN", (-3, 1))
    monkeypatch.setattr(edges, "POWERS_OF_FRICTION", (-6, 1))


def test_every_change_is_made_in_exact_numbers() -> None:
    scene = tt.load_scene("reference")
    known = {edge.change: edge.scene for edge in edges.edges(scene)}
    assert len(known) == 1 + 2 * 8 + 7 + 8
    assert known["theta = pi - 1e-300"].start.theta == (Fraction(1, 10**300), True)
    assert known["omega_3 times 1e-6"].start.omega_3 == scene.start.omega_3 / 10**6
    assert known["mu times 1e4"].body.mu == 10**4 * scene.body.mu
    # what a model does not know is not changed
    for name, absent in (("rolling", "mu"), ("frictionless", "mu"), ("rocking", "omega_3")):
        changes = [edge.change for edge in edges.edges(tt.load_scene(name))]
        assert not any(change.startswith(absent) for change in changes), name


def test_a_horizon_is_shortened_where_the_rates_are_high() -> None:
    scene = tt.load_scene("reference")
    fast, slow = (scene.varied(omega_3=str(spin)) for spin in (155_000, 1))
    assert shortened(scene, fast).until == Fraction(8, 100)
    assert shortened(scene, slow).until == 8
    # gliding decays at mu g (1 + m R^2/I3)
    rate = 3000 * scene.body.g * Fraction("3.5")
    assert shortened(scene, scene.varied(mu="3000")).until == 80 * scene.start.omega_3 / rate
    assert {edge.scene.until <= 10 for edge in edges.edges(scene.varied(until="1000"))} == {True}


def test_the_soonest_end_is_named() -> None:
    ends = [EdgeOutcome(f"{t} s", "double", "contact_lost", 8, t, 14, 1, 100) for t in (3, 1, 2)]
    assert list(findings(ends))[1] == "contact is lost: 3 of 3, first 1 s at 1 s"


def test_contact_that_is_lost_and_digits_are_those_of_the_run() -> None:
    lost = tt.load_scene("contact-lost")
    found = outcome(Edge("", lost), "double")
    run = tt.integrate(lost)
    assert (found.status, found.t_end_s) == ("contact_lost", run.t_end)
    assert found.digits == pytest.approx(float(run.digits_throughout))
    assert found.theta == pytest.approx(run.state.theta)
    assert outcome(Edge("", lost), "double-double").digits > found.digits + 10  # type: ignore[operator]
    # a start that the table would have to pull is no motion
    pulled = lost.varied(theta="2", theta_dot="100", omega_3="0", mu="0")
    refused = outcome(Edge("pulled", pulled), "double")
    assert (refused.status, refused.digits) == (REFUSED, None)
    assert "expected" in refused.note


def row(change: str, digits: float | None, status: str = "complete", t: float = 1.0) -> EdgeOutcome:
    return EdgeOutcome(change, "double", status, 8.0, t, digits, 0.1, 10)


def test_findings_name_the_fewest_digits_and_every_end() -> None:
    rows = [row("", 12.0), row("a", 3.0), row("b", 9.0, "contact_lost"),
            EdgeOutcome("c", "double", REFUSED, 8.0, None, None, None, None, "why")]  # fmt: skip
    assert list(findings(rows)) == [
        "fewest digits in double: 3.0, a",
        "contact is lost: 1 of 4, first b at 1 s",
        "no motion, the start is refused: 1 of 4, first c (why)",
    ]
    head, first, *_, last = table(rows)
    assert head.split() == ["digits", "in", "double", "steps", "theta", "end"]
    assert first.split()[3:] == ["12.0", "10", "0.1", "complete", "at", "1", "s"]
    assert last.split() == ["c", "-", "-", "-", "refused"]
    assert max(map(len, table(rows))) < 80


@pytest.mark.usefixtures("few")
def test_the_command_explores_a_scene(printed: Printed, said: Said) -> None:
    document = printed("extremes contact-lost")
    assert (document["schema"], document["scene"]) == (
        "tt_precise.extremes.scene/1", "contact-lost"
    )  # fmt: skip
    outcomes = document["outcomes"]
    assert [one["precision"] for one in outcomes[:2]] == ["double", "double-double"]
    assert len(outcomes) == 2 * (1 + 2 * 2 + 2 + 2)
    by_change = {one["change"]: one for one in outcomes if one["precision"] == "double"}
    assert by_change[""]["status"] == "contact_lost"
    assert by_change["theta = pi - 1e-300"]["status"] == "complete"
    assert any(line.startswith("contact is lost: ") for line in document["findings"])
    assert "expected only --out" in said("extremes contact-lost --quick", status=2)
    assert "got 'nowhere'" in said("extremes nowhere", status=2)
