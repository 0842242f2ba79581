"""Test vectors and index: computed afresh, checked another way, and seen to fail."""

from __future__ import annotations

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

from tt_precise.cli import main
from tt_precise.golden.store import home
from tt_precise.mechanics import compliant, euler, flight, newton, rolling
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import formulation
from tt_precise.scene.body import SPRINGS
from tt_precise.scene.laws import LAWS
from tt_precise.scene.scene import Scene
from tt_precise.vectors import index, states, steps


def committed(name: str, folder: str = "vectors") -> Any:
    return json.loads((home() / folder / name).read_text("utf-8"))


def valid_states() -> list[dict[str, Any]]:
    return [one for one in committed("states.json")["cases"] if one["result"] == "valid"]


def test_states_are_what_is_computed_now() -> None:
    file = committed("states.json")
    assert file["cases"] == states.state_file()
    assert (file["schema"], file["digits"]) == ("tt_precise.vectors.states/3", 34)
    laws = [case["contact"].get("force", case["friction"]["law"]) for case in valid_states()]
    many = {"coulomb": 10, "sticking": 10}  # five of either stick or slip soon
    assert {law: laws.count(law) for law in states.KINDS} == dict.fromkeys(states.KINDS, 5) | many


def test_an_invalid_case_is_a_valid_one_with_a_mistake_that_shows() -> None:
    """In the force, so that whoever compares that alone notices; and flags name the mistake."""
    valid = {one["name"]: one for one in valid_states()}
    wrong = [one for one in committed("states.json")["cases"] if one["result"] == "invalid"]
    for one in wrong:
        right = valid[one["name"].partition("-mistake")[0]]
        same = ("body", "friction", "contact", "state")
        assert all(one[key] == right[key] for key in same)
        weight = float(one["body"]["m"]) * float(one["body"]["g"])
        off = numpy.subtract(floats(one["expected"]["F"]), floats(right["expected"]["F"]))
        assert numpy.linalg.norm(off) > 1e-5 * weight, one["name"]
        assert one["flags"][0] == right["friction"]["law"]
    assert {one["flags"][1] for one in wrong} == states.MISTAKES.keys()
    assert len(wrong) == len(states.MISTAKEN) * len(states.MISTAKES) - 1  # rolling has no friction


def test_the_description_says_the_force_of_every_law() -> None:
    file = committed("states.json")
    laws = {one["friction"]["law"] for one in file["cases"]}
    laws |= {one["contact"].get("force", "rigid") for one in file["cases"]}
    assert file["forces"].keys() == laws


def test_what_a_constraint_keeps_zero_is_printed_as_zero() -> None:
    """Where the contact rests no part of v_A_dot is left, and none upwards on a rigid table."""
    for case in valid_states():
        rests = case["friction"]["law"] in ("rolling", "sticking")
        if case["contact"]["law"] == "rigid":
            parts = [Fraction(part) for part in case["expected"]["v_A_dot"]]
            assert parts[2] == 0
            assert any(parts) != rests


def test_every_term_again_from_newtons_law_in_numpy() -> None:
    """m s_ddot = F - m g z, L_dot = a x F, and a contact point that stays on a rigid table."""
    for case in valid_states():
        body = {name: float(value) for name, value in case["body"].items()}
        given = {name: numpy.array(value, float) for name, value in case["state"].items()}
        want = {name: numpy.array(value, float) for name, value in case["expected"].items()}
        k, w = given["k"], given["omega"]
        inertia = body["I1"] * numpy.eye(3) + (body["I3"] - body["I1"]) * numpy.outer(k, k)
        a = body["R"] * (body["alpha"] * k - [0, 0, 1])
        close = {"rtol": 1e-12, "atol": 1e-12 * abs(want["omega_dot"]).max()}
        numpy.testing.assert_allclose(want["L"], inertia @ w, rtol=1e-13, atol=1e-18)
        numpy.testing.assert_allclose(want["torque"], numpy.cross(a, want["F"]), atol=1e-15)
        gyroscopic = numpy.cross(w, inertia @ w)
        numpy.testing.assert_allclose(
            want["omega_dot"], numpy.linalg.solve(inertia, want["torque"] - gyroscopic), **close
        )
        free = want["F"] / body["m"] - [0, 0, body["g"]]
        numpy.testing.assert_allclose(want["s_ddot"], free, rtol=1e-13, atol=1e-14)
        numpy.testing.assert_allclose(
            want["v_A"], given["s_dot"] + numpy.cross(w, a), rtol=1e-12, atol=1e-14
        )
        a_dot = body["R"] * body["alpha"] * numpy.cross(w, k)
        slip = free + numpy.cross(want["omega_dot"], a) + numpy.cross(w, a_dot)
        numpy.testing.assert_allclose(want["v_A_dot"], slip, **close)
        if case["contact"]["law"] == "rigid":
            assert abs(slip[2]) < 1e-12 * abs(slip).max() + 1e-12 * body["g"]
        w4, x, y, z = given["quaternion_wxyz"]
        assert k == pytest.approx(
            [2 * (x * z + w4 * y), 2 * (y * z - w4 * x), 1 - 2 * (x * x + y * y)], abs=1e-15
        )
        assert given["quaternion_xyzw"].tolist() == [x, y, z, w4]


def test_friction_is_that_of_the_law() -> None:
    for case in valid_states():
        law = case["friction"]["law"]
        v = numpy.array(case["expected"]["v_A"], float)[:2]
        force = numpy.array(case["expected"]["F"], float)
        if law in ("rolling", "none"):
            continue
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
        depth, sinking = -float(case["state"]["height"]), -float(case["expected"]["v_A"][2])
        force = {
            "linear": stiffness * depth + damping * sinking,
            "hunt-crossley": stiffness * depth**1.5 * (1 + damping * sinking),
        }[case["contact"]["force"]]
        assert float(case["expected"]["g_n"]) == pytest.approx(force, rel=1e-12)


def test_steps_are_those_of_another_integrator() -> None:
    """SciPy's DOP853 on Newton's equations in double, from the printed states."""
    file = {(one["name"], one["step_s"]): one for one in committed("steps.json")["cases"]}
    chosen = list(states.cases())
    assert len(file) == len(chosen) * len(steps.STEPS)
    for case in chosen:
        if case.law == "none" or joins(case):
            continue
        start = case.start.map(float)
        rates, width = rates_in_double(case, start.body)
        state = [*case.start.vectors][:width]
        times = [float(step) for step in steps.STEPS]
        run = solve_ivp(
            rates, (0, times[-1]), [float(x) for x in state], "DOP853", times, rtol=1e-12,
            atol=1e-18,
        )  # fmt: skip
        for step, row in zip(times, run.y.T, strict=True):
            want = file[case.name, str(step)]
            turned = case.turned(tuple(case.context.mpf(float(x)) for x in row[:3]))
            # 200 rad/s for 10 ms in double
            assert [float(x) for x in turned] == pytest.approx(floats(want["k"]), abs=1e-9)
            w, x, y, z = floats(want["quaternion_wxyz"])
            axis = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
            assert axis == pytest.approx(floats(want["k"]), abs=1e-14)
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
    file = {(one["name"], one["step_s"]): one for one in committed("steps.json")["cases"]}
    for case in filter(joins, states.cases()):
        body = case.start.map(float).body
        last = file[case.name, "0.01"]
        regularised = LAWS["regularised"]
        top = replace(body, friction=regularised, further=(1e-7,))
        form = formulation("gliding", "newton", regularised)
        start = [float(x) for x in case.start.vectors][:8]

        def rates(t: float, y: Any, top: Any = top, form: Any = form) -> Any:
            return form.rates(top, form.State(*y), numpy)

        run = solve_ivp(rates, (0, 0.01), start, "Radau", rtol=1e-9, atol=1e-13)
        turned = case.turned(tuple(case.context.mpf(float(x)) for x in run.y[:3, -1]))
        assert floats(last["k"]) == pytest.approx([float(x) for x in turned], abs=2e-5)
        omega, s_dot = (numpy.array(last[name], float) for name in ("omega", "s_dot"))
        arm = float(body.R) * (float(body.alpha) * numpy.array(last["k"], float) - [0, 0, 1])
        speed = float(numpy.hypot(*(s_dot + numpy.cross(omega, arm))[:2]))
        creeping = float(numpy.hypot(*run.y[6:, -1]))
        assert speed == pytest.approx(creeping, abs=1e-5)


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


def floats(texts: list[str]) -> list[float]:
    return [float(text) for text in texts]


def test_flight_keeps_angular_momentum() -> None:
    given = {case["name"]: case for case in valid_states()}
    for one in committed("steps.json")["cases"]:
        case = given[one["name"]]
        if case["friction"]["law"] != "none":
            continue
        k, w = (numpy.array(one[name], float) for name in ("k", "omega"))
        I1, I3 = (float(case["body"][name]) for name in ("I1", "I3"))
        L = I1 * w + (I3 - I1) * (w @ k) * k
        assert pytest.approx(numpy.array(case["expected"]["L"], float), rel=1e-13) == L
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
    module: ModuleType, term: str, law: str, off: str, monkeypatch: pytest.MonkeyPatch
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


def test_a_wrong_step_is_not_published(monkeypatch: pytest.MonkeyPatch) -> None:
    """The Euler run starts from another height, off by 1e-36 of it."""
    case = next(case for case in states.cases() if case.law == "linear")
    original = steps.integrate

    def spoiled(scene: Scene, *arguments: Any, **words: Any) -> Any:
        if words.get("formulation") == "euler":
            height = getattr(scene.start, "height") * (1 + Fraction(1, 10**36))  # noqa: B009
            scene = scene.varied(height=height)
        return original(scene, *arguments, **words)

    monkeypatch.setattr(steps, "integrate", spoiled)
    with pytest.raises(ArithmeticError, match=r"linear-1: .* agrees in 3[0-9] digits only"):
        list(steps._entries(case))


def test_the_index_is_that_of_the_files() -> None:
    assert list(index.stale(home())) == [], "tt-precise golden vectors --build --index-only"
    listed = committed(index.INDEX, ".")
    for entry in listed["files"]:
        if entry["path"].endswith(".json"):
            own = committed(entry["path"], ".")["schema"]
            assert entry["schema"] == own, entry["path"]
    assert {"path", "sha256", "licence", "kind", "content", "schema", "digits", "scene"} == set(
        listed["files"][0]
    )


def test_what_the_index_finds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("rolling", "vectors"):
        shutil.copytree(home() / name, tmp_path / name)
    arguments = ["golden", "vectors", "--index-only", "--folder", str(tmp_path)]
    assert main(arguments) == 1
    assert "index.json: missing" in capsys.readouterr().out
    assert main([*arguments, "--build"]) == 0
    assert main(arguments) == 0
    trajectory = tmp_path / "rolling" / "trajectory.csv"
    trajectory.write_text(trajectory.read_text().replace("1", "2", 1))
    (tmp_path / "vectors" / "steps.json").unlink()
    shutil.copytree(home() / "upright", tmp_path / "upright")
    capsys.readouterr()
    assert main(arguments) == 1
    lines = capsys.readouterr().out
    assert "rolling/trajectory.csv: not as index.json says" in lines
    assert "vectors/steps.json: listed in index.json, and missing" in lines
    assert "upright/scene.toml: not listed in index.json" in lines
    (tmp_path / "index.json").write_text("[]")
    assert main(arguments) == 1
    assert "index.json: no index" in capsys.readouterr().out


@pytest.mark.parametrize(("file", "key"), [("manifest.json", "digits"), ("proof.json", "schema")])
def test_a_file_that_says_nothing_of_itself_is_named(
    file: str, key: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(home() / "rolling", tmp_path / "rolling")
    content = json.loads((tmp_path / "rolling" / file).read_text("utf-8"))
    del content[key]
    (tmp_path / "rolling" / file).write_text(json.dumps(content))
    arguments = ["golden", "vectors", "--index-only", "--build", "--folder", str(tmp_path)]
    assert main(arguments) == 2
    shown = capsys.readouterr().err
    assert file in shown
    assert key in shown
    assert len(shown.splitlines()) == 1


def test_an_index_that_was_sealed_again_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever edits a file may write its hash anew; what can be computed is, and nothing is new."""
    for name in ("rolling", "vectors"):
        shutil.copytree(home() / name, tmp_path / name)
    texts = {one.name: one.read_text("utf-8") for one in (tmp_path / "vectors").iterdir()}
    monkeypatch.setattr(index, "vector_texts", lambda _: texts)
    file, vectors = tmp_path / "index.json", tmp_path / "vectors" / "states.json"
    whole = index.index_text(tmp_path)

    def found() -> list[str]:
        problems = index.verify(tmp_path)
        file.write_text(whole)
        vectors.write_text(texts["states.json"])
        return problems

    file.write_text(whole)
    assert found() == []
    vectors.write_text(texts["states.json"].replace("7", "8", 1))
    file.write_text(index.index_text(tmp_path))
    assert found() == ["vectors/states.json: differs from what is computed now"]
    vectors.unlink()
    file.write_text(index.index_text(tmp_path))
    assert found() == ["vectors/states.json: missing"]
    (tmp_path / "rolling" / "notes.csv").write_text("t\n")
    assert found() == ["rolling/notes.csv: no file of the reference data"]
    (tmp_path / "rolling" / "notes.csv").unlink()
    entry = json.loads(whole)["files"][0]
    for changed in (
        {"licence": "none"}, {"units": "cgs"}, {"more": 1},
        {"files": [{**entry, "sha256": 64 * "0"}, *json.loads(whole)["files"]]},
    ):  # fmt: skip
        file.write_text(json.dumps({**json.loads(whole), **changed}, indent=1) + "\n")
        assert found() == ["index.json: differs from a fresh index, except in its files"], changed
    file.write_text(whole.replace("tt_precise.index/1", "tt_precise.index/2"))
    assert "index.json: no index" in found()[0]
    for name in entry:
        files = [{**entry, name: "other"}, *json.loads(whole)["files"][1:]]
        file.write_text(json.dumps({**json.loads(whole), "files": files}))
        assert found(), name


@pytest.mark.parametrize("options", ["", "--build", "--index-only --json", "--build --index-only"])
def test_an_empty_folder_is_refused_before_the_work(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: str,
) -> None:
    monkeypatch.setattr(index, "vector_texts", lambda _: pytest.fail("a minute of work"))
    assert main(["golden", "vectors", *options.split(), "--folder", str(tmp_path)]) == 2
    captured = capsys.readouterr()
    assert "expected one with golden data" in captured.err
    assert captured.out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.golden
def test_everything_is_what_is_computed_now() -> None:
    assert index.verify(home()) == []


def test_the_wheel_has_every_file_that_the_index_lists() -> None:
    """So that `golden vectors` passes on an installed package."""
    project = tomllib.loads((home().parent / "pyproject.toml").read_text("utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert "reference_data" in wheel["only-include"]
    listed = [f"reference_data/{entry['path']}" for entry in committed(index.INDEX, ".")["files"]]
    assert not [path for path in listed for left in wheel.get("exclude", []) if fnmatch(path, left)]
