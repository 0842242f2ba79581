"""Whole sets of starts: what is proved of them, and what must not be."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

import flint

import tt_precise as tt
from tt_precise.certify.approximation import Steps
from tt_precise.certify.balls import ball
from tt_precise.certify.enclosure import enclose
from tt_precise.certify.problem import problem_of
from tt_precise.certify.series import Fan
from tt_precise.certify.sets import SetOfStarts
from tt_precise.certify.starts import (
    BITS,
    INVERTS,
    LOST,
    UNDECIDED,
    UPRIGHT,
    Box,
    Fate,
    _above,
    _below,
    _Crossing,
    fans,
    never_inverts,
    outcome,
)  # fmt: skip
from tt_precise.certify.starts_map import MapSide, proved_map
from tt_precise.cli import main
from tt_precise.golden import proofs, store
from tt_precise.golden.manifest import scene_sha256
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Inclination

NARROW = {"theta": Fraction(1, 10**8), "omega_3": Fraction(1, 10**6), "phi_dot": Fraction(1, 10**6)}


def scene(phi_dot: int = 0) -> tt.Scene:
    whole = tt.load_scene("reference")
    start = replace(whole.start, phi_dot=Fraction(phi_dot))
    return replace(whole, start=start, until=Fraction(1, 20))


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(BITS):
        yield


def corner(box: Box, signs: tuple[int, ...]) -> tt.Scene:
    """The start in a corner of a box."""
    start = box.scene.start
    moved: dict[str, Any] = {}
    for (name, reach), sign in zip(box.reach.items(), signs, strict=True):
        if name == "theta":
            moved[name] = Inclination(start.theta.offset + sign * reach, start.theta.from_pi)
        else:
            moved[name] = getattr(start, name) + sign * reach
    return replace(box.scene, start=replace(start, **moved))


def state_of(one: tt.Scene) -> list[flint.arb]:
    return [flint.arb(x) for x in problem_of(one).start()]


def test_the_set_holds_every_corner_from_start_to_end() -> None:
    box = Box(scene(), NARROW)
    problem = problem_of(box.scene)
    enclosure = enclose(problem, BITS, starts=SetOfStarts(problem, fans(box), 3))
    assert enclosure.failure is None
    until = problem_of(box.scene).until()
    end = enclosure.at(until)
    for signs in ((1, 1, 1), (-1, 1, -1), (1, -1, 1), (-1, -1, -1)):
        alone = enclose(problem_of(corner(box, signs)), BITS)
        for whole, one in zip(end, alone.at(until), strict=True):
            assert whole.contains(one)
            # and is no wider than a few times what the corners span
    widths = [float(x.rad()) for x in end]
    spans = [
        abs(float((a - b).mid()))
        for a, b in zip(
            enclose(problem_of(corner(box, (1, 1, 1))), BITS).at(until),
            enclose(problem_of(corner(box, (-1, -1, -1))), BITS).at(until),
            strict=True,
        )
    ]
    assert max(widths) < 1.2 * max(spans)


def test_a_wrong_polynomial_of_the_set_has_a_defect() -> None:
    box = Box(scene(), NARROW)
    starts = SetOfStarts(problem_of(box.scene), fans(box), 3)
    piece = Steps(starts.stepped, BITS).step()
    right = max(starts._defects(piece))
    assert right < 1e-16
    for place in (0, 1, len(starts.keys) - 1):
        spoiled = list(piece.polynomials)
        spoiled[place] += flint.arb_poly([0, flint.arb("1e-14").mid()])
        assert max(starts._defects(replace(piece, polynomials=tuple(spoiled)))) > 9e-15
    # quadratic terms of the start are needed
    linear = SetOfStarts(problem_of(box.scene), fans(box, 1), 3)
    assert max(linear._defects(Steps(linear.stepped, BITS).step())) > 100 * right


def test_a_start_outside_is_not_in_the_set() -> None:
    # the negative control: three half-widths away in omega_3
    box = Box(scene(), NARROW)
    problem = problem_of(box.scene)
    until = problem.until()
    enclosure = enclose(problem, BITS, starts=SetOfStarts(problem, fans(box), 3))
    outside = enclose(problem_of(corner(Box(box.scene, NARROW), (0, 3, 0))), BITS)
    pairs = zip(enclosure.at(until), outside.at(until), strict=True)
    assert not all(whole.contains(one) for whole, one in pairs)


def test_the_set_at_the_start_holds_the_corners() -> None:
    box = Box(scene(), {"theta": Fraction(1, 100), "nu_y": Fraction(1, 100)})
    linear, cubic = fans(box, 1), fans(box, 3)
    assert max(a.range.rad() - b.range.rad() for a, b in zip(linear, cubic, strict=True)) > 1e-6
    for signs in ((1, 1), (-1, 1), (0, 0)):
        for of_degree in (linear, cubic):
            for one, exact in zip(of_degree, state_of(corner(box, signs)), strict=True):
                assert at(one, signs).contains(exact)
                assert at(one, signs).rad() < (1e-1 if of_degree is linear else 1e-5)
    assert not all(
        at(one, (1, -1)).contains(exact)
        for one, exact in zip(cubic, state_of(corner(box, (1, 1))), strict=True)
    )


def at(fan: Fan, u: tuple[int, ...]) -> flint.arb:
    """The value of a series at one start."""
    return sum(
        (term * math.prod(u[i] for i in key) for key, term in fan.terms.items()),
        start=flint.arb(0),
    )


def test_slow_tops_stay_upright_without_a_step() -> None:
    whole = tt.load_scene("stays-upright")
    found = outcome(Box(whole, {"theta": Fraction(1, 100), "omega_3": Fraction(1)}))
    assert (found.verdict, found.steps, found.since_s) == (UPRIGHT, 0, 0.0)


def test_a_kick_loses_contact() -> None:
    # beyond any threshold: g_n < 0 soon after the start, and at it
    fast = scene(-1000)
    found = outcome(Box(fast, {"phi_dot": Fraction(1, 10), "omega_3": Fraction(1, 10)}))
    assert found.verdict == LOST
    assert found.since_s < 0.05
    run = tt.integrate(fast)
    assert run.status == "contact_lost"


def test_a_box_with_both_outcomes_is_not_proved() -> None:
    # from a start that keeps contact to one that has none
    both = scene(-500)
    one = outcome(Box(both, {"phi_dot": Fraction(500)}))
    assert one.verdict == UNDECIDED
    assert one.reason
    # from one that stays upright to one that inverts
    slow = replace(tt.load_scene("stays-upright"), until=Fraction(1, 20))
    assert outcome(Box(slow, {"omega_3": Fraction(120)})).verdict == UNDECIDED


@pytest.mark.parametrize("reach", [{}, {"psi": Fraction(1)}, {"theta": Fraction(0)}])
def test_a_box_that_is_none(reach: dict[str, Fraction]) -> None:
    with pytest.raises(InputError, match="box: got"):
        Box(scene(), reach)


@pytest.mark.parametrize("name", ["rolling", "regularised-1e-2"])
def test_what_has_no_box(name: str) -> None:
    with pytest.raises(InputError, match="gliding top with viscous friction"):
        Box(tt.load_scene(name), NARROW)


def test_a_set_beside_the_inverted_spin_is_held() -> None:
    # a start near the inverted spin: held by its energy at once
    near = tt.load_scene("reference")
    start = replace(near.start, theta=Inclination.parse("3.1"), omega_3=Fraction(-90))
    found = outcome(Box(replace(near, start=start), NARROW))
    assert found.verdict == INVERTS
    assert "inverts, without losing contact" in found.summary
    assert found.as_dict()["within"]["omega_3"] == "0.000001"


def test_what_lacks_the_energy_never_inverts() -> None:
    # an upright spin has E = I3 omega^2/2 + m g R (1 - alpha) and lambda = R I3 omega (1 - alpha),
    # and meets energies of at least lambda^2/(2 a.I a) + m g R (1 - alpha z) on its way down
    whole = tt.load_scene("reference")
    body = whole.body
    m, R, alpha, g, I1, I3 = (
        float(x) for x in (body.m, body.R, body.alpha, body.g, body.I1, body.I3)
    )

    def surplus(spin: float) -> float:
        heights = [i / 500 - 1 for i in range(1000)]
        inertia = [R * R * (I1 * (1 - z * z) + I3 * (z - alpha) ** 2) for z in heights]
        wall = (R * I3 * spin * (1 - alpha)) ** 2 / 2
        pairs = zip(heights, inertia, strict=True)
        most = max(wall / across + m * g * R * (1 - alpha * z) for z, across in pairs)
        return I3 * spin * spin / 2 + m * g * R * (1 - alpha) - most

    def box(spin: float) -> Box:
        start = replace(whole.start, theta=Inclination.parse("0"), omega_3=Fraction(f"{spin:.6f}"))
        return Box(replace(whole, start=start), {"omega_3": Fraction(1, 1000)})

    low, high = 10.0, 155.0
    assert surplus(low) < 0 < surplus(high)
    while high - low > 1e-3:
        middle = (low + high) / 2
        low, high = (low, middle) if surplus(middle) > 0 else (middle, high)
    assert never_inverts(box(0.998 * low))
    assert not never_inverts(box(1.002 * high))


@pytest.mark.parametrize(
    ("reaches", "message"),
    [
        (["theta=1e-999999999"], "--within theta: got '1e-999999999', expected an exact number"),
        (["theta=nan"], "expected an exact number"),
        (["theta"], "expected NAME=NUMBER"),
        (["theta=1e-9", "theta=1e-7"], "each name once"),
        (["theta=-1e-900"], "box: got theta="),
        ([], "box: got nothing"),
    ],
)
def test_half_widths_that_are_none(
    capsys: pytest.CaptureFixture[str], reaches: list[str], message: str
) -> None:
    words = [word for reach in reaches for word in ("--within", reach)]
    assert main(["golden", "starts", "reference", *words]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert len(captured.err) < 300


def test_what_is_proved_is_shown_rounded_outward() -> None:
    box = Box(scene(), NARROW)
    crossings = {"Lk_equals_Lz": (3.1702285079, 3.1730207811)}
    found = Fate(box, INVERTS, "", 6.4153211, 0.27308336, crossings, BITS, 1)
    assert "held by its energy from 6.41533 s on, g_n > 0.2730 m g until then" in found.summary
    assert "Lk_equals_Lz between 3.17022850 and 3.17302079 s" in found.summary


@pytest.mark.parametrize("number", ["0", "1/3", "2/3", "-1/3", "1e-30", "155"])
def test_doubles_of_a_proof_enclose_its_balls(number: str) -> None:
    exact = Fraction(number)
    known = ball(exact)
    assert Fraction(_below(known)) <= exact <= Fraction(_above(known))
    assert math.copysign(1, _above(known)) == (1 if exact >= 0 else -1)
    # and are its neighbours: the nearest double is one of the two
    assert float(exact) in (_below(known), _above(known))


def committed(name: str) -> dict[str, Any]:
    return json.loads((store.home() / "reference" / name).read_text("utf-8"))


def test_the_committed_box_is_about_the_reference() -> None:
    found = committed("starts.json")
    assert found["verdict"] == INVERTS
    assert found["scene_sha256"] == scene_sha256(tt.load_scene("reference").text)
    start, within = tt.load_scene("reference").start, found["within"]
    assert Fraction(within["theta"]) == start.theta.offset / 10**6
    assert Fraction(within["omega_3"]) == start.omega_3 / 10**6
    first, last = found["crossings"]["Lk_equals_Lz"]
    record = proofs.read("reference")
    assert record is not None
    exact = float(record.content["inversion"]["B"]["t_init"]["middle"])
    assert first < exact < last < first + 3e-3


@pytest.mark.proofs
def test_the_committed_sets_come_out_again() -> None:
    found = committed("starts.json")
    box = Box(tt.load_scene("reference"), {k: Fraction(w) for k, w in found["within"].items()})
    again = outcome(box, list(found["crossings"])).as_dict()
    assert json.loads(json.dumps(again)) == {k: v for k, v in found.items() if k != "schema"}
    stored = committed("starts-map.json")
    across, up = (
        MapSide.parse("{name}={low}:{high}:{count}".format(**one)) for one in stored["sides"]
    )
    cells = proved_map(tt.load_scene("reference"), across, up).as_dict()
    assert cells == {k: v for k, v in stored.items() if k != "schema"}
    # what all of a cell is proved to do its middle does in a run
    whole = tt.load_scene("reference")
    x, y = ([float(one) for one in side.middles()] for side in (across, up))
    for row, letters in enumerate(stored["cells"]):
        for column, letter in enumerate(letters):
            middle = replace(whole.start, phi_dot=Fraction(x[column]), omega_3=Fraction(y[row]))
            if letter == "u":
                continue
            run = tt.integrate(replace(whole, start=middle))
            assert run.inversion.A.t_end is None
            if letter == "g":
                assert run.status == "complete"
                assert run.state.theta < 1


def passing(value: Callable[[Any], Any], slope: Callable[[Any], Any]) -> _Crossing:
    """A function of time and its slope, looked at from 0 to 1 and from 1 to 2."""
    found = _Crossing.__new__(_Crossing)
    found.seconds, found.signs, found.open, found.certain = flint.arb(1), [], [], True

    def along(_: Any) -> Any:
        polynomial = SimpleNamespace(polynomial=lambda times: value(times + begin))
        rate = SimpleNamespace(polynomial=lambda times: slope(times + begin))
        return SimpleNamespace(value=polynomial, partials=[rate])

    found.function = along
    for begin in (0, 1):
        piece = SimpleNamespace(end=flint.arb(1), unit=flint.arb(1))
        stretch: Any = SimpleNamespace(begin=flint.arb(begin), piece=piece, tube=[], rates=[])
        found.through(stretch)
    return found


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("size", [0.01, 100])
def test_a_crossing_is_between_the_times_at_which_it_may_be(way: int, size: float) -> None:
    """Of every function within 0.1 size of size (t - 1.1), and 0.04 more at both ends."""
    scale = way * size
    found = passing(
        lambda t: scale * (t - 1.1) + flint.arb(0, 0.1 * size), lambda _: flint.arb(scale)
    )
    assert found.signs == [-way, way]
    first, last = found.interval() or (0, 0)
    assert 0.96 <= first <= 1
    assert 1.2 <= last <= 1.24


def test_a_zero_at_the_very_end_counts() -> None:
    found = passing(lambda t: (t - 0.5) * (2 - t), lambda t: 2.5 - 2 * t)
    assert found.signs == [-1, 1]
    assert found.interval() is not None
    assert found.open[-1].contains(2)


@pytest.mark.parametrize(
    ("value", "slope"),
    [
        (lambda t: t - 3, lambda _: flint.arb(1)),
        (lambda t: (t - 0.5) * (t - 1.5), lambda t: 2 * t - 2),
        (lambda t: (t - 1) ** 3, lambda t: 3 * (t - 1) ** 2),
    ],
    ids=["never", "twice", "with a level slope"],
)
def test_what_does_not_cross_once_has_no_time(
    value: Callable[[Any], Any], slope: Callable[[Any], Any]
) -> None:
    assert passing(value, slope).interval() is None
