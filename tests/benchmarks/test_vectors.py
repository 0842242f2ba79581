"""Test vectors: computed afresh, checked another way, and seen to fail."""

import json
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
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
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.laws import LAWS
from tt_precise.mechanics.parameters import SPRINGS


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
    assert (file["schema"], file["digits"]) == ("tt_precise.vectors.states/3", 34)
    laws = [case["contact"].get("force", case["friction"]["law"]) for case in valid_states()]
    many = {"coulomb": 10, "sticking": 10}  # five of either stick or slip soon
    assert {law: laws.count(law) for law in states.KINDS} == dict.fromkeys(states.KINDS, 5) | many
    # the description says the force of every law
    described = {one["friction"]["law"] for one in file["cases"]}
    described |= {one["contact"].get("force", "rigid") for one in file["cases"]}
    assert file["forces"].keys() == described


def test_an_invalid_case_is_a_valid_one_with_a_mistake_that_shows() -> None:
    """In the force, so that whoever compares that alone notices; and flags name the mistake."""
    valid = {one["name"]: one for one in valid_states()}
    cases = committed("vectors/states.json")["cases"]
    wrong = [one for one in cases if one["result"] == "invalid"]
    for one in wrong:
        right = valid[one["name"].partition("-mistake")[0]]
        assert all(one[key] == right[key] for key in ("body", "friction", "contact", "state"))
        off = floats(one["expected"]).F - floats(right["expected"]).F
        body = floats(one["body"])
        assert numpy.linalg.norm(off) > 1e-5 * body.m * body.g, one["name"]
        assert one["flags"][0] == right["friction"]["law"]
    assert {one["flags"][1] for one in wrong} == states.MISTAKES.keys()
    assert len(wrong) == len(states.MISTAKEN) * len(states.MISTAKES) - 1  # rolling has no friction


def test_every_term_again_from_newtons_law_in_numpy() -> None:
    """m s_ddot = F - m g z, L_dot = a x F, and a contact point that stays on a rigid table."""
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
        w4, *vector = given.quaternion_wxyz
        assert given.quaternion_xyzw.tolist() == [*vector, w4]
        if case["contact"]["law"] == "rigid":
            assert abs(slip[2]) < 1e-12 * abs(slip).max() + 1e-12 * body.g
            # where the contact rests no part of v_A_dot is left, and none upwards on the table:
            # what a constraint keeps zero is printed as zero
            parts = [Fraction(part) for part in case["expected"]["v_A_dot"]]
            assert parts[2] == 0
            assert any(parts) != (case["friction"]["law"] in ("rolling", "sticking"))


def axis(state: dict[str, Any]) -> list[float]:
    """The axis that the quaternion says."""
    w, x, y, z = map(float, state["quaternion_wxyz"])
    return [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]


def test_friction_and_an_elastic_table_push_as_their_laws_say() -> None:
    for case in valid_states():
        law, want, contact = case["friction"]["law"], floats(case["expected"]), case["contact"]
        v, force = want.v_A[:2], want.F
        mu, speed = float(case["friction"].get("mu", 0)), numpy.hypot(*v)
        epsilon = float(case["friction"].get("epsilon", 0))
        if law == "sticking":
            assert speed == 0
            assert numpy.hypot(*force[:2]) < mu * force[2]
        elif law not in ("rolling", "none"):
            size = {"viscous": mu * speed, "coulomb": mu,
                    "regularised": mu * speed / numpy.hypot(speed, epsilon)}[law]  # fmt: skip
            assert force[:2] == pytest.approx(-size * force[2] * v / speed, rel=1e-13)
        if contact["law"] == "compliant":
            stiffness, damping = float(contact["stiffness"]), float(contact["damping"])
            depth, sinking = -float(case["state"]["height"]), -want.v_A[2]
            normal = {
                "linear": stiffness * depth + damping * sinking,
                "hunt-crossley": stiffness * depth**1.5 * (1 + damping * sinking),
            }[contact["force"]]
            assert want.g_n == pytest.approx(normal, rel=1e-12)


def committed_steps() -> dict[tuple[str, str], dict[str, Any]]:
    return {(one["name"], one["step_s"]): one for one in committed("vectors/steps.json")["cases"]}


def turned(case: states.StateCase, k: Any) -> list[float]:
    """The axis of a run in double, as it is published."""
    return [float(x) for x in case.turned(tuple(case.context.mpf(float(x)) for x in k))]


def test_steps_are_those_of_another_integrator() -> None:
    """SciPy's DOP853 on Newton's equations in double, from the printed states."""
    file, chosen = committed_steps(), list(states.cases())
    assert len(file) == len(chosen) * len(steps.STEPS)
    for case in chosen:
        if case.law == "none" or joins(case):
            continue
        start = case.start.map(float)
        rates, width = rates_in_double(case, start.body)
        state = [float(x) for x in [*case.start.vectors][:width]]
        times = [float(step) for step in steps.STEPS]
        run = solve_ivp(rates, (0, times[-1]), state, "DOP853", times, rtol=1e-12, atol=1e-18)
        for step, row in zip(times, run.y.T, strict=True):
            want = file[case.name, str(step)]
            k = [float(x) for x in want["k"]]
            # 200 rad/s for 10 ms in double
            assert turned(case, row[:3]) == pytest.approx(k, abs=1e-9)
            assert axis(want) == pytest.approx(k, abs=1e-14)
            assert want["quaternion_xyzw"][-1] == want["quaternion_wxyz"][0]


def rates_in_double(case: states.StateCase, body: Any) -> tuple[Callable[..., Any], int]:
    """Newton's equations of a case, and how many entries their state has."""

    def on_a_table(t: float, y: Any) -> Any:
        here = LiftedState(*y)
        pressed = here.height < 0 and compliant.pull(body, here.height, here.rise) < 0
        g_n = compliant.normal_force(body, here, numpy) if pressed else 0.0
        return flight.rates(body, here, numpy, compliant.contact_force(body, here, g_n, numpy))

    if case.law in SPRINGS:
        return on_a_table, len(LiftedState._fields)
    sticks = case.law == "sticking"
    form = formulation(
        "rolling" if sticks else case.scene.model, "newton", case.scene.body.friction
    )
    return lambda t, y: form.rates(body, form.State(*y), numpy), len(form.columns)


def joins(case: states.StateCase) -> bool:
    return case.name.rpartition("-")[0] in states.JOINED


@pytest.mark.slow
def test_sticks_and_slips_are_those_of_friction_that_is_hardly_regularised() -> None:
    """SciPy's Radau, with epsilon = 1e-7 m/s; the difference is some epsilon^(4/5), 2.5e-6."""
    law, file = LAWS["regularised"], committed_steps()
    form = formulation("gliding", "newton", law)
    for case in filter(joins, states.cases()):
        body = replace(case.start.map(float).body, friction=law, further=(1e-7,))
        start = [float(x) for x in case.start.vectors][:8]
        rates = partial(lambda body, t, y: form.rates(body, form.State(*y), numpy), body)
        run = solve_ivp(rates, (0, 0.01), start, "Radau", rtol=1e-9, atol=1e-13)
        last = floats({name: file[case.name, "0.01"][name] for name in ("k", "omega", "s_dot")})
        assert last.k == pytest.approx(turned(case, run.y[:3, -1]), abs=2e-5)
        arm = body.R * (body.alpha * last.k - [0, 0, 1])
        speed = numpy.hypot(*(last.s_dot + numpy.cross(last.omega, arm))[:2])
        assert speed == pytest.approx(numpy.hypot(*run.y[6:, -1]), abs=1e-5)


def test_flight_keeps_angular_momentum() -> None:
    given = {case["name"]: case for case in valid_states()}
    flying = [one for one in committed_steps().values() if one["name"].startswith("none-")]
    assert flying
    for one in flying:
        case = given[one["name"]]
        assert case["friction"]["law"] == "none"
        body, moved = floats(case["body"]), floats({name: one[name] for name in ("k", "omega")})
        k, w = moved.k, moved.omega
        L = body.I1 * w + (body.I3 - body.I1) * (w @ k) * k
        assert pytest.approx(floats(case["expected"]).L, rel=1e-13) == L
        fall = Fraction(case["state"]["s_dot"][2]) - Fraction("9.81") * Fraction(one["step_s"])
        assert abs(Fraction(one["s_dot"][2]) / fall - 1) < Fraction(1, 10**33)


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
    case = next(case for case in states.cases() if case.law == law)
    states.expected(case)
    case.__dict__.pop("motion")
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


def test_committed_files_are_as_their_schemas_and_a_file_that_was_edited_or_is_missing_is_named(
    monkeypatch: Patch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # the committed vectors in place of a minute of work
    texts = {name: (home() / "vectors" / name).read_text("utf-8") for name in made.FILES}
    monkeypatch.setattr(made, "vector_texts", lambda _: dict(texts))
    assert made.problems(home() / "vectors") == []
    for name, text in texts.items():
        schema = committed(f"vectors/{name.replace('.json', '.schema.json')}")
        jsonschema.validate(json.loads(text), schema)
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**json.loads(text), "digits": "34"}, schema)
    assert made.main(["--folder", str(tmp_path)]) == 0
    assert made.main(["--check", "--folder", str(tmp_path)]) == 0
    (tmp_path / "states.json").write_text(texts["states.json"].replace("7", "8", 1))
    (tmp_path / "steps.schema.json").unlink()
    assert made.main(["--check", "--folder", str(tmp_path)]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert [line.partition(":")[0] for line in lines] == ["states.json", "steps.schema.json"]


@pytest.mark.golden
def test_everything_is_what_is_computed_now() -> None:
    assert made.problems(home() / "vectors") == []
