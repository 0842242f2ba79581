"""Changes of sign of polynomials and of solutions, where the zeros are known."""

import numpy
import pytest

from tests.taylor.problems import EPS, FN, pieces, system
from tt_precise.taylor.crossings import Watch, crossings


def with_zeros(zeros: list[float]) -> numpy.ndarray:
    return numpy.polynomial.polynomial.polyfromroots(zeros)


def found(*polynomials: numpy.ndarray) -> list[tuple[int, float, int]]:
    table = numpy.array(polynomials)
    which, position, direction = crossings(table, table[:, 0])
    return list(zip(which.tolist(), position.tolist(), direction.tolist(), strict=True))


def test_every_zero_of_a_chebyshev_polynomial_is_found() -> None:
    n = 8
    shifted = numpy.polynomial.Chebyshev.basis(n, domain=[0, 1])
    power = shifted.convert(kind=numpy.polynomial.Polynomial, domain=[-1, 1], window=[-1, 1])
    known = sorted((1 - numpy.cos((numpy.arange(n) + 0.5) * numpy.pi / n)) / 2)
    positions = [position for _, position, _ in found(power.coef)]
    # its coefficients of powers of x go up to 3e5
    assert numpy.allclose(positions, known, rtol=0, atol=1e-9)
    assert [sign for *_, sign in found(power.coef)] == [-1, 1] * 4


@pytest.mark.parametrize(
    ("zeros", "expected"),
    [
        ([0.25], [0.25]),
        ([-0.5, 1.5], []),
        ([0.3, 0.3 + 1e-6], [0.3, 0.3 + 1e-6]),
        ([0.3, 0.3], []),  # it touches and does not cross
        ([0.4, 0.4, 0.4], [0.4]),
        ([1e-12], [1e-12]),
    ],
)
def test_crossings_of_few_zeros(zeros: list[float], expected: list[float]) -> None:
    positions = [position for _, position, _ in found(with_zeros(zeros))]
    # a zero of order k is off by the k-th root of what rounding does
    assert positions == pytest.approx(expected, rel=1e-9, abs=1e-4 if len(set(zeros)) < 2 else 1e-9)


def test_several_polynomials_at_once_keep_apart() -> None:
    rows = [with_zeros([0.2, 0.7, 2.0]), with_zeros([3.0, 4.0, 5.0]), -with_zeros([0.5, 2.0, 3.0])]
    assert [(k, round(position, 9), sign) for k, position, sign in found(*rows)] == [
        (0, 0.2, 1), (0, 0.7, -1), (2, 0.5, -1),
    ]  # fmt: skip


@pytest.mark.parametrize("shift", [-1e-17, 0.0, 1e-17])
def test_a_zero_between_two_pieces_is_found_once(shift: float) -> None:
    """The function x - 1 in two pieces, whose roundings may disagree about its sign at 1."""
    pieces = numpy.array([[-1.0, 1.0 + shift], [shift, 1.0]])
    first = numpy.array([-1.0, pieces[0].sum()])
    which, position, direction = crossings(pieces, first)
    assert len(which) == 1
    assert direction.tolist() == [1]
    assert which[0] + position[0] == pytest.approx(1)


@pytest.mark.parametrize("limbs", [2, 3])
def test_zeros_of_outputs_and_of_their_rates(limbs: int) -> None:
    """x - 2 in x = exp(t^2/2), and the rate of x = cos t."""
    watch = Watch(len(system("product and quotient", limbs).graph.components), (0, 0), FN)
    found = pieces("product and quotient", limbs)
    (zero,) = [z for piece in found for z in watch.zeros(piece, FN.mpf(3)) if z.function == 0]
    assert abs(zero.time - FN.sqrt(2 * FN.log(2))) < EPS[limbs]
    assert zero.direction == 1
    name = "Kepler's circle, twelve times"
    watch = Watch(len(system(name, limbs).graph.components), (0, 0), FN)
    zeros = [z for piece in pieces(name, limbs) for z in watch.zeros(piece, FN.mpf(75))]
    inner = [zero for zero in zeros if zero.time > 1]
    assert {zero.function for zero in inner} == {1}
    assert len(inner) == int(75 / FN.pi)
    assert all(
        abs(zero.time - k * FN.pi) < 2**8 * EPS[limbs] and zero.direction == (1 if k % 2 else -1)
        for k, zero in enumerate(inner, 1)
    )
