"""Starts: dimensionless, rounded once, exact at the poles, and only on the table."""

from fractions import Fraction
from typing import Any

import pytest

from tests.conftest import Patch
from tests.integration.conftest import changed
from tt_precise.integration import integrate
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics import newton
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene


@pytest.mark.parametrize("precision", ["double", "quad"])
def test_scaling_by_powers_of_two_changes_no_bit(half: Scene, precision: str) -> None:
    """m, R and g scaled, and the start and the horizon accordingly: the same dimensionless top."""
    body, time = half.body, Fraction(1, 8)  # sqrt(length/gravity)
    other = half.varied(
        m=body.m / 4096, R=body.R / 16, g=body.g * 4, mu=body.mu * 16 * time,
        omega_3=half.start.omega_3 / time, until=half.until * time,
    )  # fmt: skip
    one, two = integrate(half, precision), integrate(other, precision)
    for name, value in one.state.values.items():
        before, after = (
            r.start.units.of_dimension(r.run.columns.dimension(name)) for r in (one, two)
        )
        assert two.state.values[name] == value * float(after / before), name
    assert two.steps == one.steps
    wrong = changed(other, mu="1e-15")
    assert integrate(wrong, precision).state.theta != two.state.theta


@pytest.mark.parametrize(
    ("name", "entries", "message"),
    [
        ("reference", {"theta": "1", "phi_dot": "60"}, r"g_n is -.* m g at t = 0, .* lower the"),
        ("reference", {"theta": "2", "theta_dot": "-100", "mu": "0"}, "g_n is -"),
        ("rolling", {"theta": "1", "phi_dot": "100"}, "g_n is -"),
        ("reference", {"theta": "0.8", "nu_x": "1", "mu": "3"},
         r"denominator of g_n is -.* lower mu or nu_x"),
    ],
)  # fmt: skip
def test_a_start_off_the_table_is_refused(name: str, entries: dict[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        integrate(load_scene(name).varied(**entries))


def test_a_table_that_may_pull_takes_a_start_off_it(reference: Scene) -> None:
    """Below the equator, so fast that the axis would have to be pulled down."""
    wanted = reference.varied(theta="2", theta_dot="-100", mu="0", until="0.02")
    run = integrate(wanted, contact="bilateral")
    assert (run.status, run.t_end) == ("contact_ignored", 0.02)
    numerator, denominator = newton.contact_terms(run.start.body, run.start.vectors)
    weight = float(numerator / denominator) * float(wanted.body.m * wanted.body.g)
    assert run.frame("g_n")["g_n"][0] == pytest.approx(weight, rel=1e-13)
    # without friction the energy is conserved, whatever the sign of g_n
    assert weight < 0 <= run.drift["energy"] < 100 * 2.0**-52


@pytest.mark.parametrize("precision", ["double", "quad"])
@pytest.mark.parametrize("pole", ["", "pi - "])
def test_a_tilt_of_any_size_keeps_its_digits(
    reference: Scene, precision: str, pole: str, monkeypatch: Patch
) -> None:
    """Near a pole the equations are linear in it: kx/theta(0) at 0.2 s is one number."""
    eps = precision_named(precision).eps

    def spread() -> Any:
        one, other = (
            integrate(reference.varied(until="0.2", theta=f"{pole}1e-{k}"), precision).state.kx
            * 10**k
            for k in (20, 100)
        )
        return abs(one / other - 1) / eps

    assert spread() < 100  # 24 steps, about 1 eps each, margin 4
    monkeypatch.setattr("tt_precise.integration.heyoka_backend.longest_step", lambda *_: None)
    assert spread() > 1e9


def test_a_tilt_whose_last_double_underflows_is_refused_in_several_doubles() -> None:
    scene = load_scene("reference").varied(theta="1e-300", until="0.01")
    with pytest.raises(InputError, match=r"got double-double.*theta below"):
        integrate(scene, "double-double")
    delivered, exact = integrate(scene, digits=20), integrate(scene, "mp", bits=200)
    assert abs(delivered.state.theta / exact.state.theta - 1) < 1e-20
