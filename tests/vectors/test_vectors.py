"""Test vectors and index: computed afresh, checked another way, and seen to fail."""

import json
import shutil
import tomllib
from collections.abc import Callable
from dataclasses import replace
from fnmatch import fnmatch
from fractions import Fraction
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy
import pytest
from scipy.integrate import solve_ivp

from tests.conftest import Patch, Said
from tests.golden.tables import edit_json
from tt_precise.golden.store import home
from tt_precise.mechanics import compliant, euler, flight, newton, rolling
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.laws import LAWS
from tt_precise.mechanics.parameters import SPRINGS
from tt_precise.vectors import index, states, steps


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


def test_friction_is_that_of_the_law() -> None:
    for case in valid_states():
        law, want = case["friction"]["law"], floats(case["expected"])
        if law in ("rolling", "none"):
            continue
        v, force = want.v_A[:2], want.F
        mu, speed = float(case["friction"]["mu"]), numpy.hypot(*v)
        if law == "sticking":
            assert speed == 0
            assert numpy.hypot(*force[:2]) < mu * force[2]
            continue
        epsilon = float(case["friction"].get("epsilon", 0))
        size = {"viscous": mu * speed, "coulomb": mu,
                "regularised": mu * speed / numpy.hypot(speed, epsilon)}[law]  # fmt: skip
        assert force[:2] == pytest.approx(-size * force[2] * v / speed, rel=1e-13)


def test_an_elastic_table_pushes_as_its_law_says() -> None:
    elastic = [c for c in valid_states() if c["contact"]["law"] == "compliant"]
    assert len(elastic) == 2 * states.STATES
    for case in elastic:
        stiffness, damping = (float(case["contact"][name]) for name in ("stiffness", "damping"))
        want = floats(case["expected"])
        depth, sinking = -float(case["state"]["height"]), -want.v_A[2]
        force = {
            "linear": stiffness * depth + damping * sinking,
            "hunt-crossley": stiffness * depth**1.5 * (1 + damping * sinking),
        }[case["contact"]["force"]]
        assert want.g_n == pytest.approx(force, rel=1e-12)


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
        pressed = here.height < 0 and compliant.reach(body, here.height, here.rise) < 0
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
        body = case.start.map(float).body
        top = replace(body, friction=law, further=(1e-7,))
        start = [float(x) for x in case.start.vectors][:8]

        def rates(t: float, y: Any, top: Any = top) -> Any:
            return form.rates(top, form.State(*y), numpy)

        run = solve_ivp(rates, (0, 0.01), start, "Radau", rtol=1e-9, atol=1e-13)
        last = floats({name: file[case.name, "0.01"][name] for name in ("k", "omega", "s_dot")})
        assert last.k == pytest.approx(turned(case, run.y[:3, -1]), abs=2e-5)
        arm = float(body.R) * (float(body.alpha) * last.k - [0, 0, 1])
        speed = float(numpy.hypot(*(last.s_dot + numpy.cross(last.omega, arm))[:2]))
        assert speed == pytest.approx(float(numpy.hypot(*run.y[6:, -1])), abs=1e-5)


def test_a_step_to_no_number_and_a_stick_outside_it_are_not_published() -> None:
    case = next(case for case in states.cases() if case.name == "coulomb-sticks-1")
    right = {"kx": case.context.mpf(1)}
    steps._require_agreement(case, right, right)
    with pytest.raises(ArithmeticError, match="coulomb-sticks-1: kx agrees in 0 digits only"):
        steps._require_agreement(case, right, {"kx": case.context.nan})
    run: Any = SimpleNamespace(pieces=[SimpleNamespace(status="stick", end=7e-6)] * 2)
    steps._require_joint(case, run)
    for other in ("coulomb-sticks-2", "sticking-slips-1", "coulomb-1"):
        with pytest.raises(ArithmeticError, match=other):
            steps._require_joint(replace(case, name=other), run)


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
        (euler, "normal_force", "viscous", "1e-38"),
        (euler, "normal_force", "viscous", "nan"),
        (rolling, "constraint_force", "rolling", "1e-38"),
        (rolling, "constraint_force", "sticking", "1e-38"),
        (newton, "axis_rate", "none", "1e-38"),
        (newton, "axis_rate", "viscous", "nan"),
        (compliant, "contact_force", "linear", "1e-38"),
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
    """The Euler run starts from another height, off by 1e-36 of it."""
    case = next(case for case in states.cases() if case.law == "linear")
    original = steps.integrate

    def spoiled(scene: Any, *arguments: Any, **words: Any) -> Any:
        if words.get("formulation") == "euler":
            scene = scene.varied(height=scene.start.height * (1 + Fraction(1, 10**36)))
        return original(scene, *arguments, **words)

    monkeypatch.setattr(steps, "integrate", spoiled)
    with pytest.raises(ArithmeticError, match=r"linear-1: .* agrees in 3[0-9] digits only"):
        list(steps._entries(case))


def test_the_index_is_that_of_the_files() -> None:
    assert list(index.stale(home())) == [], "tt-precise golden vectors --build --index-only"
    listed = committed(index.INDEX)["files"]
    for entry in listed:
        if entry["path"].endswith(".json"):
            assert entry["schema"] == committed(entry["path"])["schema"], entry["path"]
    keys = {"path", "sha256", "licence", "kind", "content", "schema", "digits", "scene"}
    assert keys == set(listed[0])
    # so that `golden vectors` passes on an installed package
    project = tomllib.loads((home().parent / "pyproject.toml").read_text("utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert "reference_data" in wheel["only-include"]
    paths = [f"reference_data/{entry['path']}" for entry in listed]
    assert not [path for path in paths for left in wheel.get("exclude", []) if fnmatch(path, left)]


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A folder with golden data and test vectors."""
    for name in ("rolling", "vectors"):
        shutil.copytree(home() / name, tmp_path / name)
    return tmp_path


def test_what_the_index_finds(data: Path, said: Said) -> None:
    look = ("golden vectors --index-only --folder", data)
    assert "index.json: missing" in said(*look, status=1)
    said(*look, "--build")
    said(*look)
    trajectory = data / "rolling" / "trajectory.csv"
    trajectory.write_text(trajectory.read_text().replace("1", "2", 1))
    (data / "vectors" / "steps.json").unlink()
    shutil.copytree(home() / "upright", data / "upright")
    lines = said(*look, status=1)
    assert "rolling/trajectory.csv: not as index.json says" in lines
    assert "vectors/steps.json: listed in index.json, and missing" in lines
    assert "upright/scene.toml: not listed in index.json" in lines
    (data / "index.json").write_text("[]")
    assert "index.json: no index" in said(*look, status=1)


@pytest.mark.parametrize(("file", "key"), [("manifest.json", "digits"), ("proof.json", "schema")])
def test_a_file_that_says_nothing_of_itself_is_named(
    file: str, key: str, data: Path, said: Said
) -> None:
    edit_json(data / "rolling" / file, lambda content: content.pop(key))
    shown = said("golden vectors --index-only --build --folder", data, status=2)
    assert file in shown
    assert key in shown
    assert len(shown.splitlines()) == 1


def test_an_index_that_was_sealed_again_is_noticed(data: Path, monkeypatch: Patch) -> None:
    """Whoever edits a file may write its hash anew; what can be computed is, and nothing is new."""
    texts = {one.name: one.read_text("utf-8") for one in (data / "vectors").iterdir()}
    monkeypatch.setattr(index, "vector_texts", lambda _: texts)
    file, vectors = data / "index.json", data / "vectors" / "states.json"
    whole = index.index_text(data)
    entry, *others = json.loads(whole)["files"]

    def found(**changes: object) -> list[str]:
        if changes:
            file.write_text(json.dumps({**json.loads(whole), **changes}, indent=1) + "\n")
        problems = index.verify(data)
        file.write_text(whole)
        vectors.write_text(texts["states.json"])
        return problems

    file.write_text(whole)
    assert found() == []
    vectors.write_text(texts["states.json"].replace("7", "8", 1))
    file.write_text(index.index_text(data))
    assert found() == ["vectors/states.json: differs from what is computed now"]
    vectors.unlink()
    file.write_text(index.index_text(data))
    assert found() == ["vectors/states.json: missing"]
    (data / "rolling" / "notes.csv").write_text("t\n")
    assert found() == ["rolling/notes.csv: no file of the reference data"]
    (data / "rolling" / "notes.csv").unlink()
    twice = [{**entry, "sha256": 64 * "0"}, entry, *others]
    for changes in ({"licence": "none"}, {"units": "cgs"}, {"more": 1}, {"files": twice}):
        assert found(**changes) == ["index.json: differs from a fresh index, except in its files"]
    file.write_text(whole.replace("tt_precise.index/1", "tt_precise.index/2"))
    assert "index.json: no index" in found()[0]
    for name in entry:
        assert found(files=[{**entry, name: "other"}, *others]), name


@pytest.mark.parametrize("options", ["", "--build", "--index-only --json", "--build --index-only"])
def test_an_empty_folder_is_refused_before_the_work(
    tmp_path: Path, said: Said, monkeypatch: Patch, options: str
) -> None:
    monkeypatch.setattr(index, "vector_texts", lambda _: pytest.fail("a minute of work"))
    refused = said("golden vectors", options, "--folder", tmp_path, status=2)
    assert "expected one with golden data" in refused
    assert list(tmp_path.iterdir()) == []


@pytest.mark.golden
def test_everything_is_what_is_computed_now() -> None:
    assert index.verify(home()) == []
