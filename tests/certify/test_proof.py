"""Scenes: proved states, events, signs and times against heyoka, and against each other."""

import doctest
import resource
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import flint
import pytest
from flint import arb

import tt_precise as tt
import tt_precise.certify
from tests.conftest import Patch
from tt_precise.certify import Enclosure, NotProved, Proof, problem_of, prove
from tt_precise.certify.onset import onset
from tt_precise.certify.prover_problem import units_of
from tt_precise.golden import store
from tt_precise.integration import catalogue
from tt_precise.integration.events import event_named
from tt_precise.mechanics.compliant import reach
from tt_precise.runtime.values import InputError

SHORT = Fraction(1, 10)
TIMES = [Fraction(k, 40) for k in range(5)]


@pytest.fixture(scope="module", autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(400):
        yield


@pytest.fixture(scope="module")
def short() -> tt.Scene:
    return replace(tt.load_scene("reference"), until=SHORT)


@pytest.fixture(scope="module")
def proof(short: tt.Scene) -> Proof:
    return prove(short, bits=200)


def test_the_proof_reaches_the_horizon(proof: Proof) -> None:
    assert proof.complete
    assert proof.finish_s.overlaps(arb("0.1"))
    assert proof.lost is None
    assert len(list(proof.rows())) == 11
    frame = tt.integrate(proof.scene).frame("g_n", numbers="float")
    weight = float(proof.scene.body.m * proof.scene.body.g)
    assert 0.9 < float(proof.normal_force_bound) <= frame["g_n"].min() / weight
    bounds = proof.drift_bounds
    assert set(bounds) == {"jellett", "axis_norm"}
    assert all(bound < 1e-50 for bound in bounds.values())


def holds(proof: Proof, finer: Any, time: Fraction, width: float, near: float) -> None:
    """Balls so narrow hold what an integration gives that is right to ``near``."""
    other = finer.at(time).values
    enclosed: Any
    for name, enclosed in proof.state(time).items():
        assert enclosed.rad() < width
        assert enclosed.overlaps(arb(str(other[name]), near))


@pytest.mark.parametrize("name", ["reference", "rolling"])
def test_a_finer_integration_lies_in_the_enclosure(name: str, proof: Proof) -> None:
    if name == "rolling":
        proof = prove(replace(tt.load_scene(name), until=SHORT))
    finer = tt.integrate(proof.scene, precision="mp", bits=320)
    for time in TIMES:
        holds(proof, finer, time, 1e-48, 1e-80)
    # negative control: quad is right to about 33 digits, and the enclosure shows it
    state, coarser = proof.state(SHORT), tt.integrate(proof.scene, precision="quad").at(SHORT)
    assert not any(state[n].overlaps(arb(str(coarser.values[n]))) for n in ("kx", "ky", "Lx"))  # type: ignore[union-attr]


@pytest.mark.parametrize("name", ["regularised-1e-2", "regularised-1e-4", "coulomb-gliding"])
def test_dry_friction_is_enclosed_as_printed(name: str) -> None:
    until = Fraction(1, 50)
    found = prove(replace(tt.load_scene(name), until=until)).state(until)
    table = store.read(name).trajectory
    row = next(row for row in table.rows if Fraction(row[0]) == until)
    for column, text in zip(table.columns[1:], row[1:], strict=True):
        exact: Any = found[column]
        assert exact.rad() < 1e-40
        assert abs(exact / arb(text) - 1) < 1e-33
        # the negative control: the next number that could be printed
        assert abs(exact / (arb(text) * (1 + arb("1e-32"))) - 1) > 5e-33


@pytest.mark.parametrize(
    ("name", "changes", "why"),
    [
        ("coulomb-flight", {}, "that proofs do not cover"),
        ("elastic-hunt-crossley", {}, "that proofs do not cover"),
        ("stribeck", {}, "stribeck friction needs exp"),
        ("flight", {"height": "0"}, "the height is not proved to be positive"),
        ("reference", {"theta": "2", "theta_dot": "400"}, "contact"),  # not on the table
        *(
            pytest.param(name, {}, "where a contact sticks Coulomb", marks=pytest.mark.proofs)
            for name in ("coulomb-small-top", "coulomb-stick-slip")
        ),
    ],
)
def test_what_is_not_proved(name: str, changes: dict[str, str], why: str) -> None:
    with pytest.raises(NotProved, match=why):
        prove(tt.load_scene(name).varied(**changes))


def test_a_flight_ends_where_the_top_comes_down() -> None:
    scene = tt.load_scene("flight").varied(rise="-2")
    proof, run = prove(scene), tt.integrate(scene, precision="quad")
    assert run.status == "landed"
    (landed,) = proof.enclosed.events["landed"]
    assert landed.direction == -1
    assert abs(landed.time - arb(str(run.t_end))) < 1e-28
    assert landed.state["height"].contains(0)  # type: ignore[union-attr]


@pytest.fixture(scope="module")
def pressed() -> tt.Scene:
    return replace(tt.load_scene("elastic-linear"), until=Fraction(1, 25))


def agree_on_events(proof: Proof, width: float) -> None:
    """With those that heyoka finds, no more and no fewer; times in balls so narrow."""
    run = tt.integrate(proof.scene, precision="quad", events=catalogue("gliding"))
    for name, found in proof.all_events.items():
        assert found.failure is None
        rows = run.events[run.events["name"] == name]
        assert [zero.direction for zero in found.zeros] == list(rows["direction"])
        for zero, time in zip(found.zeros, rows["t"], strict=True):
            seconds, state = proof.event_state(zero)
            assert abs(seconds - arb(str(time))) < 1e-28
            assert state["kz"] is not None
            assert seconds.rad() < width


def test_an_elastic_table_lets_go_and_takes_again(pressed: tt.Scene) -> None:
    proof = prove(pressed)
    assert proof.complete
    agree_on_events(proof, 1e-36)
    assert len(proof.enclosed.events["separation"]) == len(proof.enclosed.events["landing"]) == 1
    finer = tt.integrate(pressed, precision="mp", bits=240)
    holds(proof, finer, pressed.until, 1e-36, 1e-60)


def test_a_table_that_would_push_before_the_top_is_above_it_proves_nothing(
    pressed: tt.Scene, monkeypatch: Patch
) -> None:
    # as if it fell to zero at a height of -1e-6 R, soon after the table let go
    monkeypatch.setattr(
        "tt_precise.certify.proof.reach",
        lambda body, height, rise: reach(body, height, rise) * (-height - 1e-6),
    )
    proof = prove(pressed)
    assert "may push before" in str(proof.enclosure.failure)


def test_coulombs_law_is_not_blamed_without_the_reason(monkeypatch: Patch) -> None:
    problem = problem_of(tt.load_scene("coulomb-gliding"))
    failed = Enclosure(problem, 200, (), NotProved("S1", "bad luck"))
    monkeypatch.setattr("tt_precise.certify.proof.enclose", lambda *given, **options: failed)
    with pytest.raises(NotProved, match=r"t = 0 sqrt\(R/g\): bad luck; where a contact sticks"):
        prove("coulomb-gliding")


def test_other_precision_and_steps_intersect(short: tt.Scene, proof: Proof) -> None:
    other = prove(short, bits=150)
    begins = {str(step.begin) for step in proof.enclosure.steps[1:]}
    assert not begins & {str(step.begin) for step in other.enclosure.steps[1:]}
    for time in TIMES:
        a, b = proof.state(time), other.state(time)
        assert all(a[name].overlaps(b[name]) for name in a)  # type: ignore[union-attr]


def test_events_are_those_that_heyoka_finds(proof: Proof) -> None:
    agree_on_events(proof, 1e-44)
    with pytest.raises(InputError, match=r"event: got 'eclipse', expected one of: .*equator"):
        proof.events("eclipse")


def begun(proof: Proof, steps: int) -> Proof:
    """As if it had failed after so many steps."""
    why, cut = NotProved("S4", "as if"), proof.enclosure.steps[:steps]
    return replace(proof, enclosure=replace(proof.enclosure, steps=cut, failure=why))


def test_what_is_said_of_a_truncated_proof(proof: Proof) -> None:
    with pytest.raises(NotProved, match="the proof ends at 0"):
        begun(proof, 0).enclosure.at(arb(0))
    alone = begun(proof, 1)
    assert len(list(alone.rows())) == 1
    assert alone.drift_bounds == {}
    with pytest.raises(NotProved, match=r"inversion.*the proof ends at 0\.0"):
        _ = begun(proof, 5).inversion


def test_an_enclosure_of_something_else_excludes_it(proof: Proof) -> None:
    # negative control: the same enclosure, read with another position of the centre of mass
    body = replace(proof.scene.body, alpha=proof.scene.body.alpha + Fraction(1, 10**45))
    with pytest.raises(NotProved, match="jellett"):
        _ = replace(proof, scene=replace(proof.scene, body=body)).drift_bounds


def test_lost_contact_ends_the_proof(short: tt.Scene) -> None:
    # a fast nutation lifts the top off within milliseconds
    scene = short.varied(theta="0.3", theta_dot="40")
    found = tt.integrate(scene, precision="quad")
    assert found.status == "contact_lost"
    proof = prove(scene)
    assert proof.lost is not None
    seconds, _ = proof.event_state(proof.lost)
    assert abs(seconds - arb(str(found.t_end))) < 1e-25
    assert proof.lost.direction == -1
    assert proof.finish_s.overlaps(seconds)
    assert len(list(proof.rows())) < 11


def test_nothing_is_said_of_what_follows_the_horizon() -> None:
    # in the last step, which reaches beyond it, contact is lost: at 1.33692 s, 36.92 ms from 1.3 s
    late = tt.integrate("contact-lost", digits=15).at("1.3")
    scene = tt.load_scene("contact-lost").from_state(late, until="0.0367")
    proof = prove(scene)
    assert proof.lost is None
    assert proof.finish_s.overlaps(arb("0.0367"))
    assert proof.enclosure.finish * units_of(scene).time > arb("0.03693")
    assert proof.state("0.0367")["kx"] is not None
    assert proof.normal_force_bound > 0
    for seconds in ("0.0368", "0.03693"):
        with pytest.raises(NotProved, match=r"time.*0.0367|horizon"):
            proof.state(seconds)


def test_a_climb_that_precesses_backwards_has_no_times_in_definition_c(short: tt.Scene) -> None:
    start = {"theta": "1.5", "theta_dot": "8", "phi_dot": "-2", "omega_3": "-30"}
    proof = prove(short.varied(**start, until="1/60"))
    assert proof.all_events["phi_dot_zero"].zeros == []
    assert all(state["phi_dot"] < 0 for _, state in proof.rows())  # type: ignore[operator]
    times = proof.inversion
    assert times.equator > 0
    assert (times.C.t_init, times.C.t_end) == (None, None)
    assert times.B.t_init == 0


def test_one_undecidable_event_leaves_the_others(proof: Proof, monkeypatch: Patch) -> None:
    whole = proof.all_events

    def undecided(scene: tt.Scene, evaluate: Any) -> Any:
        if evaluate is event_named("nu_y_zero", "gliding").function:
            raise NotProved("onset", "as if")
        return onset(scene, evaluate)

    monkeypatch.setattr("tt_precise.certify.proof.onset", undecided)
    found = replace(proof).all_events
    assert found["nu_y_zero"].failure
    assert {name for name, one in found.items() if one.failure} == {"nu_y_zero"}
    assert len(found["theta_max"].zeros) == len(whole["theta_max"].zeros)


def test_the_docstring_is_true() -> None:
    found = doctest.testmod(tt_precise.certify)
    assert (found.failed, found.attempted > 3) == (0, True)


@pytest.fixture(scope="module")
def whole() -> Proof:
    """All 8 s of the reference scene: minutes."""
    made = prove("reference")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 2 * 1024**2  # KiB
    assert len(list(made.rows())) == 801
    return made


@pytest.mark.proofs
def test_all_8_s_with_other_steps(whole: Proof) -> None:
    other = prove("reference", bits=170)
    for seconds in whole.scene.sample_times[::20]:
        a, b = whole.state(seconds), other.state(seconds)
        assert all(a[name].overlaps(b[name]) for name in a)  # type: ignore[union-attr]


@pytest.mark.proofs
def test_times_of_the_climb_are_those_of_heyoka(whole: Proof) -> None:
    found = tt.integrate("reference", precision="quad").inversion
    for definition, name in product("ABC", ("t_init", "t_end")):
        ball = getattr(getattr(whole.inversion, definition), name)
        assert ball.rad() < arb("1e-26")
        assert abs(ball - arb(str(getattr(getattr(found, definition), name)))) < arb("1e-26")
