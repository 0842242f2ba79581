"""The adapters of other people's engines, each run for real."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pandas
import pytest

import tt_precise as tt
from benchmarks.engines import ADAPTERS, ENGINES, NODE, Engine, main, measure
from tests.engines.conftest import PATIENCE_S, ladder_test, measured_on
from tt_precise.engines.ladder import LadderTest, ladder_tests, run_ladder
from tt_precise.engines.protocol import run
from tt_precise.engines.results import LadderResult

STEPS = (Fraction(1, 1000), Fraction(1, 2000), Fraction(1, 4000))


def test_there_is_an_adapter_for_each_engine() -> None:
    files = {path.stem for path in ADAPTERS.glob("*_adapter.py")}
    files |= {path.name for path in NODE.glob("*.mjs") if path.name != "program.mjs"}
    assert {engine.program for engine in ENGINES} == files


def test_an_engine_that_is_not_installed_is_skipped_with_a_line() -> None:
    lines: list[str] = []
    gone = Engine("Gone", "no-such-package", "no_adapter", "", "")
    board = measure([gone], STEPS, time_limit=1, workers=1, note=lines.append)
    assert lines == ['skipped: Gone: not installed; pip install "tt-precise[engines]"']
    assert board["rows"] == []
    assert board["skipped"]


def test_progress_goes_forward_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(
        name: str, _: object, ladder: list[LadderTest], *rest: object, **more: object
    ) -> Any:
        return (LadderResult(name, test.name, "refused") for test in ladder)

    monkeypatch.setattr("benchmarks.engines.run_ladder", refused)
    here = [Engine(name, "numpy", "no_adapter", "", "") for name in ("One", "Other")]
    seen: list[float] = []
    measure(here, STEPS, time_limit=1, workers=1, progress=seen.append)
    assert seen == pytest.approx([i / 14 for i in range(1, 15)])


@pytest.mark.parametrize("steps", [STEPS[:2], (Fraction(1, 100), *STEPS[1:])])
def test_an_order_takes_three_halved_steps(steps: tuple[Fraction, ...]) -> None:
    with pytest.raises(ValueError, match="expected three or more, each half of the one before"):
        next(run_ladder("Gone", ["no-such-program"], ladder_tests(), steps))


@pytest.mark.clients
@pytest.mark.parametrize("engine", ENGINES, ids=lambda engine: engine.name)
def test_engines_fly(engine: Engine) -> None:
    if engine.version is None:
        pytest.skip(engine.missing)
    found = measured_on(engine.command, ladder_test("flight", engine.law), steps=STEPS)
    # cannon-es leaves out the gyroscopic term, which is what this test is for
    expected = {"cannon-es": {"no order", "floor"}}.get(engine.name, {"converges", "floor"})
    if engine.precision == "single":
        expected = {"converges", "floor", "no order"}
    assert found.verdict in expected, found.message
    assert found.digits[-1] > (0 if engine.name == "cannon-es" else 1)


@pytest.mark.clients
def test_the_scoreboard_is_the_same_when_it_is_measured_again() -> None:
    engines = [one for one in ENGINES if one.name in ("Bullet", "MuJoCo") and one.version]
    if not engines:
        pytest.skip("neither Bullet nor MuJoCo is installed")
    boards = [
        measure(
            engines, STEPS, chosen=lambda test: test.name in ("gliding", "rolling"),
            time_limit=PATIENCE_S, workers=2,
        )
        for _ in range(2)
    ]  # fmt: skip
    assert boards[0] == boards[1]


@pytest.mark.clients
def test_what_an_engine_wrote_goes_through_the_check() -> None:
    engine = next(one for one in ENGINES if one.name == "MuJoCo")
    if engine.version is None:
        pytest.skip(engine.missing)
    test = ladder_test("gliding")
    found = run(engine.command, test.job(STEPS[-1]), PATIENCE_S)
    assert found.status == "done", found.message
    frame = pandas.DataFrame(found.columns)
    limits = {"jellett": 5e-6, "energy": 1e-4, "contact_velocity": 0.1}
    assert tt.check.conservation(frame, test.scene, friction="other", limits=limits).passed
    # a centre of mass that lies 1e-3 of its offset elsewhere
    spoiled = test.scene.perturbed(alpha="1e-3")
    checked = tt.check.conservation(frame, spoiled, friction="other", limits=limits)
    assert "jellett" in {finding.name for finding in checked.failures}


def test_an_unknown_engine_is_refused_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["Havok"])
    assert "got 'Havok', expected one of: MuJoCo" in capsys.readouterr().err
