"""Test vectors: computed afresh, checked another way, and seen to fail."""

import json
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import jsonschema
import numpy
import pytest
from scipy.integrate import solve_ivp

from benchmarks.vectors import __main__ as made
from benchmarks.vectors import states, steps
from tests.conftest import Patch
from tt_precise.golden.store import home
from tt_precise.mechanics import compliant, euler, flight, newton, rolling
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import Formulation, formulation
from tt_precise.mechanics.laws import LAWS
from tt_precise.mechanics.parameters import SPRINGS
from tt_precise.mechanics.quantities import Motion


@cache
def committed(name: str) -> Any:
    return json.loads((home() / name).read_text("utf-8"))


def valid_states() -> list[dict[str, Any]]:
    cases = committed("vectors/states.json")["cases"]
    return [one for one in cases if one["result"] == "valid"]


def floats(numbers: dict[str, Any]) -> SimpleNamespace:
    """A record's numbers and vectors as doubles."""
    arrays = {name: numpy.array(value, float) for name, value in numbers.items() if value != ""}
    return SimpleNamespace(**{n: float(a) if a.ndim == 0 else a for n, a in arrays.items()})


def test_states_are_what_is_computed_now() -> None:
    file = committed("vectors/states.json")
    assert file["cases"] == states.state_file()
    laws = {case["friction"]["law"] for case in file["cases"]}
    tables = {case["contact"].get("force", "rigid") for case in file["cases"]}
    assert file["forces"].keys() == laws | tables


def test_an_invalid_case_is_a_valid_one_with_a_mistake_that_shows_in_the_force() -> None:
    valid = {case["name"]: case for case in valid_states()}
    invalid = [c for c in committed("vectors/states.json")["cases"] if c["result"] == "invalid"]
    for case in invalid:
        right, body = valid[case["name"].partition("-mistake")[0]], floats(case["body"])
        assert all(case[key] == right[key] for key in ("body", "friction", "contact", "state"))
        error = floats(case["expected"]).F - floats(right["expected"]).F
        assert numpy.linalg.norm(error) > 1e-5 * body.m * body.g, case["name"]
    assert {case["flags"][1] for case in invalid} == states.MISTAKES.keys()


def test_every_term_again_from_newtons_law_in_numpy() -> None:
    """m s_ddot = F - m g z, L_dot = a x F, and a contact point that stays on a rigid table.

    ``examples/readers`` compute F by the laws of friction and of the table.
    """
    for case in valid_states():
        body, given, want = map(floats, (case["body"], case["state"], case["expected"]))
        k, w, z = given.k, given.omega, numpy.array([0, 0, 1])
        inertia = body.I1 * numpy.eye(3) + (body.I3 - body.I1) * numpy.outer(k, k)
        a = body.R * (body.alpha * k - z)
        turned = numpy.linalg.solve(inertia, want.torque - numpy.cross(w, inertia @ w))
        free = want.F / body.m - body.g * z
        a_dot = body.R * body.alpha * numpy.cross(w, k)
        slip = free + numpy.cross(want.omega_dot, a) + numpy.cross(w, a_dot)
        close = 1e-12 * abs(want.omega_dot).max()
        for found, exact, rtol, atol in (
            (want.L, inertia @ w, 1e-13, 1e-18),
            (want.torque, numpy.cross(a, want.F), 1e-7, 1e-15),
            (want.omega_dot, turned, 1e-12, close),
            (want.s_ddot, free, 1e-13, 1e-14),
            (want.v_A, given.s_dot + numpy.cross(w, a), 1e-12, 1e-14),
            (want.v_A_dot, slip, 1e-12, close),
            (k, axis(case["state"]), 0, 1e-15),
        ):
            numpy.testing.assert_allclose(found, exact, rtol=rtol, atol=atol)
        if case["friction"]["law"] == "sticking":
            assert numpy.hypot(*want.F[:2]) < float(case["friction"]["mu"]) * want.F[2]
        if case["contact"]["law"] == "rigid":
            assert abs(slip[2]) < 1e-12 * abs(slip).max() + 1e-12 * body.g
            # a component that a constraint keeps zero is printed as zero
            *horizontal, vertical = map(float, case["expected"]["v_A_dot"])
            assert vertical == 0
            assert any(horizontal) != (case["friction"]["law"] in ("rolling", "sticking"))


def axis(state: dict[str, Any]) -> list[float]:
    """The axis that the quaternion says."""
    w, x, y, z = map(float, state["quaternion_wxyz"])
    return [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]


def lifted_rates(body: Any, state: Any, fn: Any) -> Any:
    """Time derivatives in flight and on an elastic table, which pushes and never pulls."""
    pressed = body.spring and state.height < 0 and compliant.pull(body, *state[-2:]) < 0
    g_n = compliant.normal_force(body, state, fn) if pressed else 0.0
    return flight.rates(body, state, fn, compliant.contact_force(body, state, g_n, fn))


def in_double(case: states.StateCase, body: Any, method: Any, rtol: float) -> list[Motion]:
    """The motion after each step by SciPy, in double, from Newton's equations."""
    model = "rolling" if case.law == "sticking" and not switches(case) else case.scene.model
    form = formulation(model, "newton", body.friction)
    if case.law in (*SPRINGS, "none"):
        form = Formulation("flight", LiftedState, lifted_rates, body.friction)
    start = [*case.start.vectors, 0, 0][: len(form.columns)]
    times = [float(step) for step in steps.STEPS]
    run = solve_ivp(
        lambda t, y: form.rates(body, form.State(*y), numpy), (0, times[-1]),
        [float(x) for x in start], method, times, rtol=rtol, atol=1e-18,
    )  # fmt: skip
    return [form.motion(body, row, numpy) for row in run.y.T]


def switches(case: states.StateCase) -> bool:
    """Test whether the top sticks or slips within a step."""
    return case.name.rpartition("-")[0] in states.JOINED


def largest_errors(case: states.StateCase, motions: list[Motion]) -> dict[str, float]:
    """The largest error of the axis and of the velocity of the centre of mass at the steps."""
    file = {(one["name"], one["step_s"]): one for one in committed("vectors/steps.json")["cases"]}
    largest = {"k": 0.0, "s_dot": 0.0}
    for step, motion in zip(steps.STEPS, motions, strict=True):
        printed = file[case.name, str(float(step))]
        assert axis(printed) == pytest.approx([float(x) for x in printed["k"]], abs=1e-14)
        for name in largest:
            x, y, z = (case.context.mpf(float(value)) for value in getattr(motion, name))
            error = numpy.array(printed[name], float) - numpy.array(case.turned((x, y, z)), float)
            largest[name] = max(largest[name], abs(error).max())
    return largest


def test_steps_are_those_of_another_integrator() -> None:
    """Compare with DOP853; 1e-9 is what 200 rad/s for 10 ms leave of double."""
    for case in states.cases():
        if not switches(case):
            motions = in_double(case, case.start.map(float).body, "DOP853", 1e-12)
            assert max(largest_errors(case, motions).values()) < 1e-9, case.name


@pytest.mark.slow
def test_sticks_and_slips_are_those_of_friction_that_is_hardly_regularised() -> None:
    """Compare with epsilon = 1e-7 m/s; the difference is some epsilon^(4/5), 2.5e-6."""
    for case in filter(switches, states.cases()):
        body = replace(case.start.map(float).body, friction=LAWS["regularised"], further=(1e-7,))
        error = largest_errors(case, in_double(case, body, "Radau", 1e-9))
        assert error["k"] < 2e-5
        assert error["s_dot"] < 2e-5


@pytest.mark.parametrize(
    ("module", "term", "law", "off"),
    [
        (euler, "normal_force", "viscous", "nan"),
        (rolling, "constraint_force", "sticking", "1e-38"),
        (newton, "axis_rate", "none", "1e-38"),
        (compliant, "contact_force", "hunt-crossley", "1e-38"),
    ],
)
def test_a_wrong_term_is_not_published(
    module: ModuleType, term: str, law: str, off: str, monkeypatch: Patch
) -> None:
    case = replace(next(case for case in states.cases() if case.law == law))  # nothing cached
    original = getattr(module, term)

    def spoiled(*arguments: Any) -> Any:
        found = original(*arguments)
        little = 1 + case.context.mpf(off)
        return (*found[:2], found[2] * little) if isinstance(found, tuple) else found * little

    monkeypatch.setattr(module, term, spoiled)
    with pytest.raises(ArithmeticError, match=f"{law}-1: two formulations differ by"):
        states.expected(case)


def test_a_wrong_step_is_not_published(monkeypatch: Patch) -> None:
    """The run in fewer bits starts from another height, off by 1e-36 of it."""
    case = next(case for case in states.cases() if case.law == "linear")
    original = steps.integrate

    def spoiled(scene: Any, *arguments: Any, **words: Any) -> Any:
        if words["bits"] == steps.BITS[1]:
            scene = scene.varied(height=scene.start.height * (1 + Fraction(1, 10**36)))
        return original(scene, *arguments, **words)

    monkeypatch.setattr(steps, "integrate", spoiled)
    with pytest.raises(ArithmeticError, match=r"linear-1: .* agrees in 3[0-9] digits only"):
        list(steps.documents_of(case))


def test_files_are_as_their_schemas_and_an_edited_or_missing_file_is_named(
    monkeypatch: Patch, tmp_path: Path
) -> None:
    # the committed vectors in place of a minute of work
    texts = {name: (home() / "vectors" / name).read_text("utf-8") for name in made.FILES}
    monkeypatch.setattr(made, "vector_texts", lambda _: dict(texts))
    assert made.problems(home() / "vectors") == []
    for name in texts:
        schema = committed(f"vectors/{name.replace('.json', '.schema.json')}")
        jsonschema.validate(committed(f"vectors/{name}"), schema)
    assert made.main(["--folder", str(tmp_path)]) == 0
    (tmp_path / "states.json").write_text(texts["states.json"].replace("7", "8", 1))
    (tmp_path / "steps.schema.json").unlink()
    assert made.main(["--check", "--folder", str(tmp_path)]) == 1
    names = [line.partition(":")[0] for line in made.problems(tmp_path)]
    assert names == ["states.json", "steps.schema.json"]


@pytest.mark.golden
def test_everything_is_what_is_computed_now() -> None:
    assert made.problems(home() / "vectors") == []
