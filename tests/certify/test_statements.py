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
from tests.conftest import more
from tt_precise.certify import NotProved, Proof, prove
from tt_precise.golden import store
from tt_precise.integration import catalogue

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
    assert proof.observations.end is None
    assert len(proof.observations.rows) == 11
    finer = proof.scene.varied(sample_every="0.0001")
    frame = tt.integrate(finer).frame("g_n", numbers="float")
    weight = float(proof.scene.body.m * proof.scene.body.g)
    least = frame["g_n"].min() / weight
    assert least - 1e-5 < float(proof.normal_force_bound) <= least
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


@pytest.mark.parametrize("name", ["reference", more("rolling")])
def test_a_finer_integration_lies_in_the_enclosure(name: str, proof: Proof) -> None:
    if name == "rolling":
        proof = prove(replace(tt.load_scene(name), until=SHORT))
    finer = tt.integrate(proof.scene, precision="mp", bits=320)
    for time in TIMES:
        holds(proof, finer, time, 1e-48, 1e-80)
    # negative control: quad is right to about 33 digits, and the enclosure shows it
    state, coarser = proof.state(SHORT), tt.integrate(proof.scene, precision="quad").at(SHORT)
    assert not any(state[n].overlaps(arb(str(coarser.values[n]))) for n in ("kx", "ky", "Lx"))  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "name", ["regularised-1e-2", "regularised-1e-4", "coulomb-gliding", "stribeck"]
)
def test_dry_friction_is_enclosed_as_printed(name: str) -> None:
    until = Fraction(1, 50)
    found = prove(replace(tt.load_scene(name), until=until)).state(until)
    table = store.read_files(name).trajectory
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
        ("flight", {"height": "0"}, "not proved to begin before landed"),
        ("reference", {"theta": "2", "theta_dot": "400"}, "contact"),  # not on the table
        pytest.param("coulomb-small-top", {}, "may end here", marks=pytest.mark.proofs),
        pytest.param("coulomb-stick-slip", {}, "may end here", marks=pytest.mark.proofs),
    ],
)
def test_what_is_not_proved(name: str, changes: dict[str, str], why: str) -> None:
    with pytest.raises(NotProved, match=why):
        prove(tt.load_scene(name).varied(**changes))


@pytest.fixture(scope="module")
def pressed() -> tt.Scene:
    return replace(tt.load_scene("elastic-linear"), until=Fraction(1, 25))


def agree_on_events(proof: Proof, width: float) -> None:
    """With those that heyoka finds, no more and no fewer; times in balls so narrow."""
    run = tt.integrate(proof.scene, precision="quad", events=catalogue("gliding"))
    for name in catalogue("gliding"):
        found = proof.observations.events[name]
        rows = run.events[run.events["name"] == name]
        assert [one.direction for one in found] == list(rows["direction"])
        for one, time in zip(found, rows["t"], strict=True):
            assert abs(one.time - arb(str(time))) < 1e-28
            assert one.state["kz"] is not None
            assert one.time.rad() < width


@pytest.mark.evidence
def test_an_elastic_table_lets_go_and_takes_again(pressed: tt.Scene) -> None:
    proof = prove(pressed)
    agree_on_events(proof, 1e-36)
    assert [len(proof.observations.events[name]) for name in ("separation", "landing")] == [1, 1]
    finer = tt.integrate(pressed, precision="mp", bits=240)
    holds(proof, finer, pressed.until, 1e-36, 1e-60)


def test_events_are_those_that_heyoka_finds(proof: Proof) -> None:
    agree_on_events(proof, 1e-44)


def test_beyond_the_horizon_nothing_is_enclosed(proof: Proof) -> None:
    for seconds in ("0.1001", "-0.01"):
        with pytest.raises(NotProved, match="is not enclosed"):
            proof.state(seconds)


def test_an_enclosure_of_something_else_excludes_it(proof: Proof) -> None:
    # negative control: the same enclosure with one sample that is off by 1e-45
    samples = list(proof.enclosure.samples)
    with flint.ctx.workprec(240):
        phase, state = samples[5]
        samples[5] = phase, [x + (arb("1e-45") if i == 3 else 0) for i, x in enumerate(state)]
        other = replace(proof, enclosure=replace(proof.enclosure, samples=samples))
        with pytest.raises(NotProved, match="jellett"):
            _ = other.drift_bounds


def test_lost_contact_ends_the_proof(short: tt.Scene) -> None:
    # a fast nutation lifts the top off within milliseconds
    scene = short.varied(theta="0.3", theta_dot="40")
    found = tt.integrate(scene, precision="quad")
    assert found.status == "contact_lost"
    proof = prove(scene)
    assert proof.observations.end is not None
    assert abs(proof.observations.end.time - arb(str(found.t_end))) < 1e-25
    (lost,) = proof.observations.events["contact_lost"]
    assert lost.direction == -1
    assert len(proof.observations.rows) < 11


def test_nothing_is_said_of_what_follows_the_horizon() -> None:
    # in the last step, which reaches beyond it, contact is lost: at 1.33692 s, 36.92 ms from 1.3 s
    late = tt.integrate("contact-lost", digits=15).at("1.3")
    scene = tt.load_scene("contact-lost")
    start = {name: str(getattr(late, name)) for name in scene.start.components()}
    proof = prove(scene.varied(**start, until="0.0367"))
    assert proof.observations.end is None
    assert proof.state("0.0367")["kx"] is not None
    assert proof.normal_force_bound > 0
    for seconds in ("0.0368", "0.03693"):
        with pytest.raises(NotProved, match="not enclosed"):
            proof.state(seconds)


def test_a_climb_that_precesses_backwards_has_no_times_in_definition_c(short: tt.Scene) -> None:
    start = {"theta": "1.5", "theta_dot": "8", "phi_dot": "-2", "omega_3": "-30"}
    proof = prove(short.varied(**start, until="1/60"))
    assert proof.observations.events["phi_dot_zero"] == []
    assert all(state["phi_dot"] < 0 for _, state in proof.observations.rows)  # type: ignore[operator]
    times = proof.inversion
    assert times.equator > 0
    assert (times.C.t_init, times.C.t_end) == (None, None)
    assert times.B.t_init == 0


def test_undecided_comparisons_of_the_definitions_prove_nothing(proof: Proof) -> None:
    events = dict(proof.observations.events)
    first, *rest = events["theta_min"]
    blurred = {**first.state, "phi_dot": arb(0, 1)}
    climb = first._replace(direction=-1, time=arb("0.09999"))
    found = {"equator": [climb], "theta_min": [first._replace(state=blurred), *rest]}
    other = replace(proof)
    other.__dict__["observations"] = proof.observations._replace(events={**events, **found})
    with pytest.raises(NotProved, match="sign of phi_dot"):
        _ = other.inversion


def test_examples_of_the_docstring_run() -> None:
    found = doctest.testmod(tt_precise.certify)
    assert (found.failed, found.attempted > 3) == (0, True)


@pytest.mark.proofs
def test_times_of_the_climb_are_those_of_heyoka() -> None:
    whole, run = prove("reference"), tt.integrate("reference", precision="quad")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 2 * 1024**2  # KiB
    for definition, name in product("ABC", ("t_init", "t_end")):
        ball = getattr(getattr(whole.inversion, definition), name)
        assert ball.rad() < arb("1e-26")
        assert run.inversion_errors[f"{name}_{definition}"] < 1e-27
        time, _, _ = str(getattr(getattr(run.inversion, definition), name)).partition(" +- ")
        assert abs(ball - arb(time)) < arb("1e-26")
