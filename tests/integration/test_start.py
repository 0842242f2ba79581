"""Starts: dimensionless, rounded once, exact at the poles, and only on the table."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.integration import integrate
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics import newton
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Inclination, Scene

QUAD = precision_named("quad")


def starting(scene: Scene, **entries: Any) -> Scene:
    theta = Inclination.parse(entries.pop("theta", str(scene.start.theta)))
    values = {name: Fraction(value) for name, value in entries.items()}
    return replace(scene, start=replace(scene.start, theta=theta, **values))


def test_dimensionless_numbers_of_the_reference_scene(reference: Scene) -> None:
    start = InitialState.of(starting(reference, nu_y="0.1"), QUAD.arithmetic)
    with mpmath.workdps(60):
        second = mpmath.sqrt(mpmath.mpf("0.02") / mpmath.mpf("9.82"))
        speed = mpmath.sqrt(mpmath.mpf("9.82") * mpmath.mpf("0.02"))
        expected = {
            "alpha": mpmath.mpf("0.3"),
            "I1": mpmath.mpf(131) / 350,
            "I3": mpmath.mpf(2) / 5,
            "mu": mpmath.mpf("0.3") * speed,
        }
        found = {name: getattr(start.body, name) for name in expected}
        expected |= {"until": 8 / second, "omega_3": 155 * second}
        expected["nu_y"] = mpmath.mpf("0.1") / speed
        found |= {"until": start.until, "omega_3": start.euler.omega_3, "nu_y": start.euler.nu_y}
        # a few roundings of the guarded context, 64 bits finer than quad
        bound = mpmath.ldexp(1, -113 - 60)
        for name, value in expected.items():
            assert abs(mpmath.mpf(found[name]) / value - 1) < bound, name
        assert abs(mpmath.mpf(start.vectors.kx) - mpmath.sin(mpmath.mpf("0.1"))) < bound


def test_a_start_1e_300_from_the_inverted_pole_keeps_its_digits(reference: Scene) -> None:
    start = InitialState.of(starting(reference, theta="pi - 1e-300"), QUAD.arithmetic)
    assert start.vectors.kz == -1
    assert abs(start.vectors.kx / mpmath.mpf("1e-300") - 1) < mpmath.mpf("1e-15")
    assert start.vectors.kx > 0


@pytest.mark.parametrize(("theta", "kz"), [("0", 1), ("pi", -1)])
def test_the_poles_are_exact(reference: Scene, theta: str, kz: int) -> None:
    vectors = InitialState.of(starting(reference, theta=theta), QUAD.arithmetic).vectors
    assert (vectors.kx, vectors.ky, vectors.kz) == (0, 0, kz)
    assert vectors.Lx == vectors.Ly == 0


@pytest.mark.parametrize("precision", ["double", "quad"])
def test_scaling_by_powers_of_two_changes_no_bit(half: Scene, precision: str) -> None:
    """m, R and g scaled, and the start and the horizon accordingly: the same dimensionless top."""
    mass, length, gravity = Fraction(8), Fraction(1, 4), Fraction(16)
    time = Fraction(1, 8)  # sqrt(length/gravity)
    body = half.body
    inertia = mass * length**2
    other = replace(
        half,
        body=replace(
            body,
            m=body.m * mass,
            R=body.R * length,
            g=body.g * gravity,
            I1=body.I1 * inertia,
            I3=body.I3 * inertia,
            mu=body.mu / (length / time),
        ),
        start=replace(half.start, omega_3=half.start.omega_3 / time),
        until=half.until * time,
    )
    one, two = integrate(half, precision), integrate(other, precision)
    factors = {
        "k": Fraction(1),
        "L": inertia / time,
        "v": length / time,
        "nu": length / time,
        "theta": Fraction(1),
        "theta_dot": 1 / time,
        "phi_dot": 1 / time,
        "omega_3": 1 / time,
    }
    for name, value in one.state.values.items():
        factor = factors.get(name) or factors.get(name.split("_")[0]) or factors[name[0]]
        assert two.state.values[name] == value * float(factor), name
    assert two.steps == one.steps
    wrong = replace(other, body=replace(other.body, mu=other.body.mu * (1 + Fraction(1, 10**15))))
    assert integrate(wrong, precision).state.theta != two.state.theta


@pytest.mark.parametrize(
    ("entries", "mu", "message"),
    [
        ({"theta": "1", "phi_dot": "60"}, "0.3", r"g_n is -.* m g at t = 0, .* lower the start's"),
        ({"theta": "0.8", "nu_x": "1"}, "3", r"denominator of g_n is -.* lower mu or nu_x"),
    ],
)
def test_a_start_off_the_table_is_refused(
    reference: Scene, entries: dict[str, str], mu: str, message: str
) -> None:
    scene = starting(replace(reference, body=replace(reference.body, mu=mu)), **entries)
    with pytest.raises(InputError, match=message):
        integrate(scene)


def test_a_rolling_start_off_the_table_is_refused() -> None:
    from tt_precise.scene.scene import load_scene

    with pytest.raises(InputError, match="g_n is -"):
        integrate(starting(load_scene("rolling"), theta="1", phi_dot="100"))


def test_a_start_off_the_table_is_refused_unless_the_table_may_pull(reference: Scene) -> None:
    """Below the equator, so fast that the axis would have to be pulled down."""
    body = replace(reference.body, mu="0")
    fast = starting(reference, theta="2", theta_dot="-100")
    wanted = replace(fast, body=body, until=Fraction("0.02"))
    with pytest.raises(InputError, match=r"g_n is -.* m g at t = 0, expected above 0"):
        integrate(wanted)
    trajectory = integrate(wanted, contact="bilateral")
    assert trajectory.status == "contact_ignored"
    assert trajectory.t_end == 0.02
    g_n = trajectory.frame("g_n")["g_n"]
    numerator, denominator = newton.contact_terms(trajectory.start.body, trajectory.start.vectors)
    weight = float(numerator / denominator) * float(body.m * body.g)
    assert g_n[0] == pytest.approx(weight, rel=1e-13)
    assert g_n[0] < 0
    # without friction the energy is conserved, whatever the sign of g_n
    assert trajectory.drift["energy"] < 100 * 2.0**-52


@pytest.mark.parametrize("precision", ["double", "quad"])
@pytest.mark.parametrize("pole", ["", "pi - "])
def test_a_tilt_of_any_size_keeps_its_digits(
    reference: Scene, precision: str, pole: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Near a pole the equations are linear in it: kx/theta(0) at 0.2 s is one number."""
    short = replace(reference, until=Fraction("0.2"))
    eps = precision_named(precision).eps

    def spread() -> Any:
        one, other = (
            integrate(starting(short, theta=f"{pole}1e-{k}"), precision).state.kx * 10**k
            for k in (20, 100)
        )
        return abs(one / other - 1) / eps

    assert spread() < 100  # 24 steps, about 1 eps each, margin 4
    monkeypatch.setattr("tt_precise.integration.heyoka_backend.longest_step", lambda *_: None)
    assert spread() > 1e9


def test_a_push_of_any_size_keeps_its_digits(reference: Scene) -> None:
    """A top that stands still, and is pushed: the tilt grows as a hyperbolic sine of time."""
    falling = starting(replace(reference, until=Fraction(1)), theta="pi - 1e-30", omega_3="0")
    one, other = (
        integrate(starting(falling, theta=f"pi - 1e-{k}", theta_dot=f"1e-{k}")).state.kx * 10.0**k
        for k in (20, 100)
    )
    assert one == pytest.approx(other, rel=1e-13)


def test_contact_lost_later_is_reported_when_it_is_ignored(rough: Scene) -> None:
    """The guarded run ends where g_n reaches 0; the other goes on and says that it was there."""
    scene = replace(rough, until=Fraction("0.66"))
    assert integrate(scene).status == "contact_lost"
    ignored = integrate(scene, contact="bilateral")
    assert (ignored.status, ignored.t_end) == ("contact_ignored", 0.66)
    earlier = replace(scene, until=Fraction("0.6"))
    assert integrate(earlier, contact="bilateral").status == "complete"


def test_only_two_kinds_of_contact(half: Scene) -> None:
    with pytest.raises(InputError, match="contact: got 'none', expected one of"):
        integrate(half, contact="none")
