"""lambda, thresholds and asymptotic values to any digits; what Theorem 1.1 decides of inversion."""

from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

import mpmath
import pytest

import tt_precise as tt
from tests.conftest import RATIOS, more, top
from tests.exact.conftest import Spoil, wrong, wrong_quantity
from tt_precise.exact import thresholds as module
from tt_precise.exact.stability import MarginalMomentum
from tt_precise.exact.thresholds import Theorem, inversion, thresholds
from tt_precise.mechanics import euler
from tt_precise.mechanics import thresholds as formulas
from tt_precise.runtime.values import InputError
from tt_precise.scene.body import top_of
from tt_precise.scene.scene import Inclination, Scene, load_scene

NAMES = ["lambda", "lambda_thres", "lambda_up", "D0", "D1", "E0", "E1", "gamma", "sigma"]


def with_body(**changes: str) -> Scene:
    return replace(load_scene("reference"), body=top(**changes))


def with_start(scene: str = "reference", **changes: Any) -> Scene:
    loaded = load_scene(scene)
    return replace(loaded, start=replace(loaded.start, **changes))


@pytest.mark.parametrize("digits", [1, 20, 200])
def test_all_digits_agree_in_the_reference_scene(digits: int) -> None:
    result = tt.thresholds("reference", digits)
    assert list(result.quantities) == NAMES
    assert {each.digits_agreed for each in result.quantities.values()} == {digits}
    assert not any(each.reason for each in result.quantities.values())
    assert result.inverts is True


@pytest.mark.parametrize("digits", [0, 2001, 50.0, "50", True, None])
def test_numbers_of_digits_out_of_range_are_refused(digits: Any) -> None:
    with pytest.raises(InputError, match=r"digits: got .*, expected a whole number between 1 and"):
        thresholds("reference", digits)


def test_values_are_what_the_printed_formulas_give() -> None:
    """Computed here from the numbers of section 2.1, in mpmath's global context."""
    with mpmath.workdps(60):
        m, R, alpha, g = map(mpmath.mpf, ("0.02", "0.02", "0.3", "9.82"))
        I3, gamma, sigma = mpmath.mpf(2) / 5 * m * R**2, mpmath.mpf(131) / 140, mpmath.mpf(5) / 2
        scale = mpmath.sqrt(m * g * R**3 * alpha * I3)
        start = R * (-I3 * 155 * (alpha - mpmath.cos(mpmath.mpf("0.1"))))
        low, high = 1 - alpha, 1 + alpha
        expected = {
            "lambda": start,
            "gamma": gamma,
            "sigma": sigma,
            "lambda_thres": scale * high**2 / mpmath.sqrt(high - gamma),
            "lambda_up": scale * low**2 / mpmath.sqrt(gamma - low),
            "E0": start**2 / (2 * R**2 * I3 * low**2) + m * g * R * low,
            "E1": start**2 / (2 * R**2 * I3 * high**2) + m * g * R * high,
        }
        quantities = thresholds("reference").as_dict()["quantities"]
        for name, value in expected.items():
            result = mpmath.mpf(quantities[name]["value"])
            assert abs(result / value - 1) < mpmath.mpf(10) ** -48, name


@pytest.mark.parametrize(
    "scene", ["rolling", more("frictionless"), "upright", more("inverted"), more("phi-dot-195")]
)
def test_other_scenes_agree_too(scene: str) -> None:
    result = thresholds(load_scene(scene), 40)
    assert {each.digits_agreed for each in result.quantities.values()} == {40}
    borrowed = "an auxiliary mu = 1 s/m" in result.quantities["lambda_thres"].how
    assert borrowed is (scene in ("rolling", "frictionless"))
    assert result.inverts is {"upright": False, "phi-dot-195": True}.get(scene)


def test_lambda_is_accurate_beside_the_inverted_pole() -> None:
    """Only phi_dot sin^2 theta = 1e-80 phi_dot is left where omega_3 = 0."""
    theta = Inclination(Fraction(1, 10**40), from_pi=True)
    scene = with_start(theta=theta, omega_3="0", phi_dot="1")
    result = thresholds(scene, 50).quantities["lambda"]
    assert result.digits_agreed == 50
    body = scene.body
    assert abs(result.value / float(body.R * body.I1) * 10**80 - 1) < 1e-14


@pytest.mark.parametrize(
    ("I1", "missing", "other", "verb", "inverts"),
    [
        ("0.28", "lambda_up", "lambda_thres", "decay", None),
        ("0.52", "lambda_thres", "lambda_up", "grow", False),
    ],
)
def test_a_threshold_that_does_not_exist(
    I1: str, missing: str, other: str, verb: str, inverts: bool | None
) -> None:
    result = thresholds(with_body(I1=I1), 30)
    absent = result.quantities[missing]
    assert (absent.value, absent.independent, absent.digits_agreed) == (None, None, None)
    assert f"perturbations {verb} at every" in absent.reason
    assert result.quantities[other].digits_agreed == 30
    assert result.inverts is inverts
    assert result.as_dict()["quantities"][missing]["value"] is None


@pytest.mark.parametrize("changes", [{"mu": "1e-300"}, {"alpha": "1e-100", "I1": "0.4"}])
def test_extreme_tops_are_decided(changes: dict[str, str]) -> None:
    quantities = thresholds(with_body(**changes), 30).quantities
    assert {name: each.digits_agreed for name, each in quantities.items()} == dict.fromkeys(
        NAMES, 30
    )


def with_friction(law: str, mu: str, nu_x: str, **more: str) -> Scene:
    body = {name: value for name, value in RATIOS.items() if name != "mu"}
    rubbing, _ = top_of(body, {"law": law, "mu": mu, **more})
    return replace(with_start(nu_x=Fraction(nu_x)), body=rubbing)


def test_the_contact_force_at_the_start_is_that_of_the_law() -> None:
    # g_n has a negative denominator under mu/sqrt(v^2 + epsilon^2) = 25, and none under 25 s/m v
    rough = with_friction("regularised", "25", "0.01", epsilon="0.001")
    result = thresholds(rough, 20)
    assert result.inverts is None
    assert "needs g_n > 0" in result.theorem.reason
    smooth = with_friction("regularised", "0.3", "0.01", epsilon="0.001")
    assert thresholds(smooth, 20).inverts is True


def test_the_spin_is_linearised_with_the_friction_that_it_has() -> None:
    # beside v_A = 0 a regularised law is viscous with mu/epsilon, and Coulomb's is nothing
    smooth = with_friction("regularised", "0.3", "0", epsilon="0.001")
    assert "the scene's own mu/epsilon" in thresholds(smooth, 20).quantities["lambda_thres"].how
    dry = thresholds(with_friction("coulomb", "0.3", "0.01"), 20).quantities["lambda_thres"]
    assert "the scene's own" not in dry.how
    assert dry.digits_agreed == 20


def test_the_friction_that_moves_a_threshold_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    """The worse agreement of the two frictions is reported."""
    right = module.marginal_momentum

    def wrong_without_friction(body: Any, side: int, digits: int, fn: Any, mu: Any = None) -> Any:
        marginal = right(body, side, digits, fn, mu)
        return replace(marginal, momentum=marginal.momentum * (1 + (not mu) * fn.mpf(10) ** -7))

    monkeypatch.setattr(module, "marginal_momentum", wrong_without_friction)
    assert thresholds("reference", 30).quantities["lambda_up"].digits_agreed == 7
    monkeypatch.setattr(module, "marginal_momentum", lambda *_: MarginalMomentum(None, "lost"))
    assert thresholds("reference", 30).quantities["lambda_up"].digits_agreed == 0


def _larger(value: Any) -> Any:
    return value + value / 10**30


_wrong = partial(wrong, change=_larger)
_quantity = partial(wrong_quantity, change=_larger)


@pytest.mark.parametrize(
    ("spoil", "name"),
    [
        (_wrong(euler, "jellett"), "lambda"),
        *((_wrong(formulas, name), name) for name in NAMES[1:7]),
        (_quantity("D"), "D1"),
        (_quantity("E_tilde"), "E0"),
        (_wrong(euler, "rates", "phi_dot"), "gamma"),
        (_wrong(euler, "rates", "omega_3"), "sigma"),
    ],
)
def test_a_difference_in_the_30th_digit_is_seen(
    spoil: Spoil, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not name.startswith("lambda_"):  # the search takes time and is not what is spoiled
        monkeypatch.setattr(module, "marginal_momentum", lambda *given: MarginalMomentum())
    assert thresholds(load_scene("reference"), 40).quantities[name].digits_agreed == 40
    spoil(monkeypatch)
    result = thresholds(load_scene("reference"), 40).quantities[name].digits_agreed
    assert result in (29, 30)


def test_a_notebook_shows_values_and_the_theorem() -> None:
    result = thresholds("reference", 40)
    assert repr(result).startswith("<Thresholds, 40 digits: lambda 6.8944413e-06, lambda_thres")
    assert repr(result.quantities["E0"]) == "<Determination: 0.0406428725676 J, 40 digits agree>"
    page = result._repr_html_()
    assert "theorem" in page
    assert result.as_dict()["quantities"]["E0"]["value"] in page


def verdict(
    size: float, thres: float | None = 3, up: float | None = 1, scene: str | Scene = "reference"
) -> Theorem:
    return inversion(load_scene(scene), size, (thres, up), True, 1e-12)


@pytest.mark.parametrize(
    ("size", "thres", "up", "inverts", "reason"),
    [
        (4, 3, 1, True, "Theorem 1.1"),
        (4, 1, 3, True, "Theorem 1.1"),
        *(
            (*sizes, False, "the inverted spin is unstable")
            for sizes in ((2, 3, 1), (0, 3, 1), (0.5, 1, 3), (1, 3, 1), (2, 3, None))
        ),
        (2, 1, 3, None, "lambda_thres < |lambda| < lambda_up: upright and inverted spin are both"),
        (3, 3, 1, None, "the inverted spin is marginal"),
        (3, 1, 3, None, "the upright spin is marginal"),
        (9, None, 1, False, "gamma >= 1 + alpha"),
        (4, 3, None, None, "gamma <= 1 - alpha"),
        # just off the threshold it is decided
        (3 * (1 + 1e-11), 3, 1, True, ""),
        (3 * (1 - 1e-11), 3, 1, False, ""),
    ],
)
def test_by_lambda(
    size: float, thres: float | None, up: float | None, inverts: bool | None, reason: str
) -> None:
    for mirrored in (size, -size):
        result = verdict(mirrored, thres, up)
        assert result.inverts is inverts
        assert reason in result.reason


@pytest.mark.parametrize(
    ("scene", "inverts", "reason"),
    [
        ("rolling", None, "gliding with friction"),
        ("frictionless", None, "gliding with friction"),
        ("elastic-linear", None, "rigid table"),
        ("upright", False, "starts as the upright spin"),
        ("inverted", None, "starts as the inverted spin"),
    ],
)
def test_by_scene(scene: str, inverts: bool | None, reason: str) -> None:
    result = verdict(100, scene=scene)
    assert result.inverts is inverts
    assert reason in result.reason


@pytest.mark.parametrize("moving", ["theta_dot", "nu_x", "nu_y"])
def test_the_slightest_motion_leaves_the_steady_spin(moving: str) -> None:
    assert verdict(100, scene=with_start("upright", **{moving: "1e-300"})).inverts is True
    assert verdict(100, scene=with_start("upright", phi_dot="5")).inverts is False


@pytest.mark.parametrize(
    ("apart", "inverts"), [("5e-51", None), ("2e-50", True), ("-2e-50", False)]
)
def test_a_start_is_marginal_in_all_digits(apart: str, inverts: bool | None) -> None:
    values = {name: each.value for name, each in thresholds("reference", 70).quantities.items()}
    with mpmath.workdps(70):
        share = values["lambda_thres"] / values["lambda"] * (1 + mpmath.mpf(apart))
        spin = mpmath.nstr(155 * share, 65)
    assert thresholds(with_start(omega_3=spin), 50).inverts is inverts


def test_off_the_table_nothing_is_claimed() -> None:
    assert verdict(100).inverts is True
    assert inversion(load_scene("reference"), 100, (3, 1), False, 1e-12).inverts is None
