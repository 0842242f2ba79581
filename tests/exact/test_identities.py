"""Every identity is proved, and every one is seen to fail when a term is off by 1e-40."""

import re
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import more
from tests.exact.conftest import Spoil, wrong, wrong_quantity
from tt_precise.exact import identities
from tt_precise.mechanics import euler, friction, newton, rolling
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import InputError

ONE_BODY = Parameters(*map(Fraction, ("2", "3/5", "1/3", "7/4", "9/5", "10", "1/7")))


def _off(value: Any) -> Any:
    """A constant term of 1e-40 too much: proportional errors cost minutes of common divisors."""
    return value + (0 * value + 1) / 10**40


_wrong = partial(wrong, change=_off)
_quantity = partial(wrong_quantity, change=_off)

CONTROLS: dict[str, Spoil] = {
    "Euler form = Newton form": _wrong(euler, "rates", "omega_3"),
    "g_n Euler = g_n Newton": _wrong(euler, "contact_terms", 0),
    "the contact keeps": _wrong(newton, "rates", "vx"),
    "rate of g_n": _wrong(newton, "normal_force_slope"),
    "the axis stays a unit vector": _wrong(newton, "rates", "kz"),
    "equations turn with the frame": _wrong(newton, "rates", "Lx"),
    "Euler angles turn with the frame": _wrong(euler, "vectors_from_euler", "vx"),
    "Euler angles there and back": _wrong(euler, "vectors_from_euler", "Lz"),
    "lambda in Euler angles": _wrong(euler, "jellett"),
    "lambda is constant, vectors": _wrong(newton, "rates", "Lz"),
    "lambda is constant, Euler angles": _wrong(euler, "rates", "omega_3"),
    "E falls by friction": _quantity("E_dot"),
    "rates of the parts of E": _quantity("E_pot_dot"),
    "Main Equation": _quantity("E_tilde"),
    "rate of D": _quantity("D_dot"),
    "rate of E~": _quantity("E_tilde_dot"),
    "omega_3_dot": _quantity("omega_3_dot"),
    "rolling vectors obey Newton": _wrong(rolling, "constraint_force", 1),
    "rolling Euler = rolling vectors": _wrong(rolling, "euler_rates", "phi_dot"),
    "lambda, D, E~ are constant when rolling, vectors": _wrong(rolling, "rates", "Lz"),
    "lambda, D, E~ are constant when rolling, Euler angles": _wrong(
        rolling, "euler_rates", "omega_3"
    ),
    "integrals without friction": _wrong(newton, "rates", "kz"),
    "lambda is constant under any contact force": _wrong(newton, "axis_rate", 0),
    "E changes by the power of any contact force": _wrong(newton, "contact_velocity_rel_cm", 1),
    "momentum about the lowest point under any contact force": _wrong(
        newton, "contact_momentum_rate", 1
    ),
    "dry friction: size, direction and loss": _wrong(friction, "coefficient"),
    "Coulomb's law in polar form": _wrong(friction, "polar_rates", "ex"),
    "rolling meets gliding at the cone": _wrong(rolling, "constraint_force", 0),
}


# For all bodies at once these take a second each, as long as all others together; below they are
# proved for one body.
DEAR = ("the contact keeps", "rate of g_n", "lambda is constant, vectors", "rate of E~",
        "rates of the parts of E", "omega_3_dot", "Euler form = Newton form")  # fmt: skip


@pytest.mark.parametrize(
    "name", [more(name) if name in DEAR else name for name in identities.IDENTITIES]
)
def test_proved(name: str) -> None:
    proof = identities.prove(name)
    assert (proof.holds, proof.failed) == (True, ())
    assert proof.residuals >= 1
    assert proof.identity.statement


def test_every_identity_has_a_control() -> None:
    assert set(CONTROLS) == set(identities.IDENTITIES)


@pytest.mark.parametrize("name", [more(name) if name in DEAR else name for name in CONTROLS])
def test_spoiled_by_1e_40_it_fails(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    CONTROLS[name](monkeypatch)
    proof = identities.IDENTITIES[name].prove(ONE_BODY)
    assert not proof.holds


@pytest.mark.parametrize("name", ["Main Equation", *DEAR])
def test_for_one_body_what_holds_for_all_holds(name: str) -> None:
    """A control: the refutations above do not come from the numbers."""
    proof = identities.IDENTITIES[name].prove(ONE_BODY)
    assert proof.holds
    assert proof.residuals >= 1


def test_a_root_that_is_no_fraction_is_refused() -> None:
    assert identities.Roots.sqrt(Fraction(4, 9)) == Fraction(2, 3)
    with pytest.raises(ValueError, match="not the square of a fraction"):
        identities.Roots.sqrt(Fraction(5, 9))


def test_nothing_is_no_proof() -> None:
    with pytest.raises(ArithmeticError, match="nothing was proved"):
        identities.Identity("empty", "", lambda draws: []).prove()


def test_no_name_hides_another_identity() -> None:
    files = Path(identities.__file__).parent.glob("*.py")
    entries = re.findall(r"^@identity\(", "\n".join(f.read_text("utf-8") for f in files), re.M)
    assert len(entries) == len(identities.IDENTITIES)


def test_refuses_unknown_names() -> None:
    with pytest.raises(InputError, match=r"identity: got 'Fermat', expected one of: .*Euler form"):
        identities.prove("Fermat")


def test_every_point_is_tried_and_the_points_are_the_same_each_time() -> None:
    points: list[int] = []

    def fails_at_the_last(draws: Any) -> list[int]:
        points.append(draws.randint(0, 10**9))
        return [0, int(len(points) % identities.POINTS == 0)]

    identity = identities.Identity("once", "", fails_at_the_last)
    assert identity.prove().failed == identity.prove().failed == (1,)
    assert points[: identities.POINTS] == points[identities.POINTS :]
    assert len(set(points)) == identities.POINTS
