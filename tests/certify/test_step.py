"""One step, and what must not pass: spoiled polynomials, other equations, steps too long."""

import random
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any
from unittest.mock import Mock

import flint
import pytest
from flint import arb, arb_mat, arb_poly

import tt_precise as tt
from tests.conftest import Patch
from tt_precise.certify import NotProved, Problem, balls, problem_of, step
from tt_precise.certify.enclosure import Piece, Steps
from tt_precise.certify.error_set import LohnerSet
from tt_precise.certify.step import Crossing, cross

BITS = 200
MU = 3  # position of mu among the parameters


@pytest.fixture(scope="module", autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(BITS + 32):
        yield


@pytest.fixture(scope="module")
def problem() -> Problem:
    return problem_of(tt.load_scene("reference"))


@pytest.fixture(scope="module")
def piece(problem: Problem) -> Piece:
    return Steps(problem, BITS).step()


def crossed(problem: Problem, piece: Piece) -> Crossing:
    differences = [x - c for x, c in zip(problem.start(), piece.first, strict=True)]
    return cross(problem, piece, LohnerSet.of(differences))


def ends(crossing: Crossing, piece: Piece) -> list[arb]:
    return [p + e for p, e in zip(piece.last, crossing.after.hull, strict=True)]


def worst(crossing: Crossing) -> float:
    return max(float(radius) for radius in crossing.radius)


def spoiled(piece: Piece, order: int, by: Any) -> Piece:
    first, *others = piece.polynomials
    sums = (first + arb_poly([0] * order + [arb(by).mid()])).coeffs()
    return replace(piece, polynomials=(arb_poly([c.mid() for c in sums]), *others))


def test_one_step_of_the_reference_scene(problem: Problem, piece: Piece) -> None:
    crossing = crossed(problem, piece)
    assert worst(crossing) < 1e-55
    # the exact state lies in the tube as well
    for model, exact in zip(crossing.tube, ends(crossing, piece), strict=True):
        assert model.polynomial(piece.end).overlaps(exact)


@pytest.mark.parametrize("order", [0, 1, 7])
def test_a_polynomial_spoiled_in_the_40th_digit(problem: Problem, piece: Piece, order: int) -> None:
    honest, bad = crossed(problem, piece), spoiled(piece, order, "1e-40")
    crossing = crossed(problem, bad)
    # no more digits are claimed than there are, and the truth is not lost
    assert crossing.radius[0] > arb("1e-40") * piece.end**order
    for a, b in zip(ends(honest, piece), ends(crossing, bad), strict=True):
        assert b.overlaps(a)
    # at the end no more is lost than was allowed for on the way
    for error, most in zip(crossing.after.hull, crossing.radius, strict=True):
        assert error.rad() < 2 * most
    # what the spoiled polynomial says is excluded by the honest enclosure
    assert not ends(honest, piece)[0].overlaps(bad.last[0])


def test_what_is_not_proved(problem: Problem, piece: Piece) -> None:
    with pytest.raises(NotProved, match="S4"):
        crossed(problem, spoiled(piece, 3, "1e-12"))
    for factor in (4, 40):
        with pytest.raises(NotProved):
            crossed(problem, replace(piece, end=piece.end * factor))

    def a_term_dropped(parameters: Any, state: Any, fn: Any) -> Any:
        return (*problem.rates(parameters, state, fn)[:-1], 0 * state[0])

    with pytest.raises(NotProved, match="S4"):
        crossed(problem, Steps(replace(problem, rates=a_term_dropped), BITS).step())
    # the theorem is about one polynomial, not about a ball of them
    first, *others = piece.polynomials
    for change, why in (
        ({"polynomials": (first + arb(0, "1e-70"), *others)}, "S1"),
        ({"end": arb(1) / 3}, "S1"),
        ({"end": -piece.end}, "forward"),
    ):
        with pytest.raises(NotProved, match=why):
            replace(piece, **change)


def test_a_parameter_wrong_in_the_45th_digit(problem: Problem, piece: Piece) -> None:
    def parameters() -> list[arb]:
        right = list(problem.parameters())
        right[MU] *= 1 + arb("1e-45")
        return right

    wrong = replace(problem, parameters=parameters)
    other = Steps(wrong, BITS).step(piece.end * piece.unit)
    assert worst(crossed(wrong, other)) < 1e-55
    # the friction moves vx by mu g_n vx: what the wrong one says about the end is excluded
    honest = ends(crossed(problem, piece), piece)
    assert not all(a.overlaps(b) for a, b in zip(honest, other.last, strict=True))
    # and compared with the right equations it proves fewer digits
    assert worst(crossed(problem, other)) > 1e-48


def test_weights_that_are_not_positive_prove_nothing(
    problem: Problem, piece: Piece, monkeypatch: Patch
) -> None:
    # with all of them negative the bounds of the errors would be negative, and pass
    monkeypatch.setattr(step, "_weights", lambda bound, sizes: [arb(-1) for _ in sizes])
    with pytest.raises(NotProved, match="positive weights"):
        crossed(problem, piece)


def test_every_entry_that_the_norm_of_the_flow_admits_is_allowed_for(
    problem: Problem, piece: Piece, monkeypatch: Patch
) -> None:
    """max_i sum_j |Q_ij| w_j/w_i <= q holds of a matrix with a single entry q w_i/w_j."""
    after, weigh = Mock(wraps=step._after), step._weights
    weights: list[arb] = []

    def weighed(*given: Any) -> list[arb]:
        weights[:] = weigh(*given)
        return weights

    monkeypatch.setattr(step, "_after", after)
    monkeypatch.setattr(step, "_weights", weighed)
    crossed(problem, piece)
    bent = after.call_args.args[2]
    found = [
        bound * weights[j] / weights[i] for i, row in enumerate(bent) for j, bound in enumerate(row)
    ]
    assert all(abs(one / found[0] - 1) < 1e-12 for one in found)


# Lohner sets contain what moves, and balls round outward.


def test_a_moved_set_contains_the_moved_points() -> None:
    dice = random.Random(1)
    point = [arb(dice.uniform(-1, 1)) for _ in range(4)]
    errors = LohnerSet.of([arb(0, 1)] * 4)
    for _ in range(40):
        flow = arb_mat([[arb(dice.uniform(-1, 1)) for _ in range(4)] for _ in range(4)])
        more = arb(dice.uniform(-1, 1))
        point = [x + more for x in (flow * arb_mat(4, 1, point)).entries()]
        errors = errors.moved(flow, [arb(0, 1)] * 4)
        assert all(h.contains(x) for h, x in zip(errors.hull, point, strict=True))


def test_a_rotated_box_does_not_grow_by_wrapping() -> None:
    c, s = arb(1).cos(), arb(1).sin()
    errors = LohnerSet.of([arb(0, 1), arb(0, 1)])
    for _ in range(100):
        errors = errors.moved(arb_mat([[c, -s], [s, c]]), [arb(0), arb(0)])
    assert max(h.rad() for h in errors.hull) < 1.42


def test_a_flat_set_stays_flat_whichever_edge_is_the_long_one() -> None:
    """Nearly parallel edges: the long one keeps its direction, or its length would go across."""
    for edges, across in (((1, 1e-6), (0, 1)), ((1e-6, 1), (-1e-8, 1))):
        errors = LohnerSet.of([arb(0, edge) for edge in edges])
        moved = errors.moved(arb_mat([[1, 1], [0, 1e-8]]), [arb(0), arb(0)])
        along = arb_mat([[arb(x) for x in across]]) * moved._basis * moved._box
        assert along[0, 0].rad() < 1e-13


def test_what_is_not_finite_is_not_proved() -> None:
    with pytest.raises(NotProved):
        LohnerSet.of([arb("nan")])
    with pytest.raises(NotProved):
        LohnerSet.of([arb(1)] * 2).moved(arb_mat([[0, 0], [0, 0]]), [arb("inf")] * 2)
    with pytest.raises(NotProved, match="not finite"):
        balls.largest([arb(1), arb("nan")])
    assert balls.largest([arb(1), arb(2, 1)]) >= 3


def test_balls_round_outward_and_their_bounds_lose_nothing() -> None:
    balls.require_outward_rounding()
    low, high = balls.bounds(arb(3, 0.5))
    assert Fraction(5, 2) - Fraction(1, 10**8) < low <= Fraction(5, 2)
    assert high == 6 - low
