"""Compiled integrators: one for each setup, used again, never with a memory of earlier runs."""

from dataclasses import replace
from fractions import Fraction

import pytest

from tt_precise.integration import Trajectory, integrate, system
from tt_precise.integration.equations import Equations
from tt_precise.integration.idle import Idle
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import numeric_options
from tt_precise.mechanics.formulations import integrated
from tt_precise.scene.scene import Scene

SETUP = Setup(formulation=integrated("gliding", "newton"), precision=precision_named("double"))


@pytest.fixture
def builds(monkeypatch: pytest.MonkeyPatch) -> list[Setup]:
    """Keys built during the test, which starts without idle integrators."""
    built: list[Setup] = []
    original = system.build

    def build(setup: Setup) -> system.Integrator:
        built.append(setup)
        return original(setup)

    monkeypatch.setattr(system, "_idle", Idle(build))
    return built


def test_one_integrator_serves_every_body_and_start(builds: list[Setup], half: Scene) -> None:
    heavy = replace(half, body=replace(half.body, m="1", I1="2", I3="3", alpha="1/7"))
    first, other, again = integrate(half), integrate(heavy), integrate(half)
    assert len(builds) == 1
    assert first.state.values == again.state.values != other.state.values


def test_events_of_an_earlier_run_are_forgotten(double: Trajectory, half: Scene) -> None:
    first = integrate(half, events=double.setup.events)
    second = integrate(half, events=double.setup.events)
    before = double.events[double.events["t"] <= 0.5]
    assert len(first.events) == len(second.events) == len(before) > 10
    assert first.events["t"].equals(second.events["t"])


def test_recorded_quadratures_do_not_disturb_the_state(quad: Trajectory) -> None:
    """psi grows to 450 rad, far above the rest of the state, and phi has a spike of its rate."""

    def error(tolerance: float) -> float:
        recorded = integrate(
            "reference",
            record=("phi", "psi", "x", "y"),
            tolerance=tolerance,
        )
        assert abs(recorded.state.psi) > 100
        apart = [recorded.state.values[k] - float(quad.state.values[k]) for k in ("kx", "ky", "kz")]
        return max(map(abs, apart))

    assert error(0) < 1e-13  # the bar for double without quadratures
    assert error(1e-12) > 1e-13


def test_a_numeric_option_reaches_heyoka() -> None:
    coarse = SETUP.but(tolerance=1e-6)
    assert numeric_options(coarse)["tol"] == 1e-6
    assert numeric_options(SETUP)["tol"] == 2.0**-56
    assert numeric_options(SETUP.but(options=(("tol", 0.5),)))["tol"] == 0.5
    quad = numeric_options(SETUP.but(precision=precision_named("quad")))
    assert quad["compact_mode"] is True
    assert numeric_options(SETUP)["compact_mode"] is False
    # without, the slope of g_n in the rolling model compiles for a minute
    assert numeric_options(SETUP.but(events=("extremum:g_n",)))["compact_mode"] is True
    assert quad["tol"] == precision_named("quad").fp_type(2) ** -112


def test_a_coarser_tolerance_lowers_the_order_and_loosens_conservation(half: Scene) -> None:
    fine = integrate(half)
    coarse = integrate(half, tolerance=1e-6)
    assert coarse.order < fine.order
    assert coarse.drift["jellett"] > 1000 * fine.drift["jellett"]


def test_terminal_functions_are_those_of_the_model() -> None:
    def names(model: str, coordinates: str) -> list[str]:
        form = integrated(model, coordinates)
        equations = Equations.of(form)
        return list(system.terminal_functions(form, equations.motion, equations.variables[0]))

    assert names("gliding", "newton") == ["contact_lost", "singular_contact"]
    assert names("gliding", "euler") == ["contact_lost", "singular_contact", "pole"]
    assert names("rolling", "newton") == ["contact_lost"]
    assert names("rolling", "euler") == ["contact_lost", "pole"]


def test_mu_is_exact_though_it_comes_as_a_square(reference: Scene) -> None:
    with_exact_root = replace(reference.body, g=Fraction("12.5"), mu="3")
    context = precision_named("quad").context
    body = with_exact_root.dimensionless(context, precision_named("quad").exact)
    assert body.mu == context.mpf("1.5")
