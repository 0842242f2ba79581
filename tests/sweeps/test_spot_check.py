"""The spot check: rows again in a finer arithmetic, and what differs."""

from typing import Any

import numpy
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps import SweepSpec, run_sweep, spot_check
from tt_precise.sweeps.spot_check import differences, sampled_rows


@pytest.mark.slow
def test_the_spot_check_ends_beside_the_pole_too() -> None:
    scene = SweepSpec.of("reference", until="120").scene.varied(omega_3="80")
    assert spot_check.recomputed(scene, ())["outcome"] == "inverts"


@pytest.mark.parametrize(
    ("changes", "ended"),
    [
        ({"nu_x": "1000", "mu": "100"}, "singular_contact"),
        ({"theta": "3", "theta_dot": "400"}, "contact_lost"),
    ],
)
def test_the_spot_check_tells_how_a_start_ends(changes: dict[str, str], ended: str) -> None:
    scene = load_scene("reference").varied(**changes)
    found = spot_check.recomputed(scene, ())
    assert found.pop("min_g_n") < 0
    assert found == {"outcome": ended, "t_stop": 0.0}


SPEC = SweepSpec.of("reference", until="0.5", vary={"phi_dot": "-20:20:41"})


def test_one_row_of_each_thousand_is_drawn() -> None:
    rows = list(sampled_rows(10_500, seed=1))
    assert [row // 1000 for row in rows] == list(range(11))
    assert rows[-1] < 10_500
    assert rows == list(sampled_rows(10_500, seed=1)) != list(sampled_rows(10_500, seed=2))
    assert not list(sampled_rows(100, seed=1, one_in=0))
    with pytest.raises(InputError, match="recheck: got -1"):
        run_sweep(SPEC, recheck=-1)


def refusing(*given: object) -> dict[str, Any]:
    raise InputError("it cannot be integrated so")


def test_the_spot_check_finds_what_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = SweepSpec.of("reference", until="0.2", vary={"phi_dot": "90,95,100"})
    found = run_sweep(spec, recheck=1).summary["recheck"]
    assert found["rows"] == 3
    assert not any(found[name] for name in ("other_outcome", "only_in_one", "errors"))
    # g_n of size 0.2 N over 40 steps: some eps of it, which the stiff force enlarges tenfold
    assert found["largest_difference"]["min_g_n"]["value"] < 1e3 * 0.2 * 2.0**-52
    right = spot_check.recomputed
    wrong = {"min_g_n": 0.1, "t_init_A": 0.5, "outcome": "inverts"}
    monkeypatch.setattr(spot_check, "recomputed", lambda *given: {**right(*given), **wrong})
    spoiled = run_sweep(spec, recheck=3).summary["recheck"]
    assert spoiled["largest_difference"]["min_g_n"]["value"] > 1e-3
    assert spoiled["other_outcome"]
    assert spoiled["only_in_one"]
    monkeypatch.setattr(spot_check, "recomputed", refusing)
    assert set(run_sweep(spec, recheck=1).summary["recheck"]["errors"]) == {"0", "1", "2"}


@pytest.mark.slow
@pytest.mark.parametrize("row", [{}, {"mu": "3", "until": "1"}, {"phi_dot": "195"}])
def test_the_spot_check_finds_what_quad_finds(
    row: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, record = load_scene("reference").varied(**row), ("max_phi_dot", "start_E", "end_g_n")
    found = spot_check.recomputed(scene, record)
    monkeypatch.setattr(spot_check, "FINE", "quad")
    apart = differences(found, spot_check.recomputed(scene, record))
    # g_n of size 0.2 N where contact is lost, which is zero: some eps, as in double above
    assert apart.pop("end_g_n") < 1e3 * 0.2 * 2.0**-104
    assert set(apart.values()) == {0.0}  # the same doubles


def test_what_several_doubles_lack_is_done_in_quad(monkeypatch: pytest.MonkeyPatch) -> None:
    used: list[str] = []
    right = spot_check.row_of

    def noting(scene: Scene, record: tuple[str, ...], **how: Any) -> Any:
        used.append(how["precision"])
        return right(scene, record, **how)

    monkeypatch.setattr(spot_check, "row_of", noting)
    for name, precision in (("reference", "double-double"), ("coulomb-stick-slip", "quad")):
        spot_check.recomputed(load_scene(name).varied(until="0.001"), ())
        assert used.pop() == precision
        assert not used
    thrown = load_scene("reference").varied(phi_dot="400")
    assert spot_check.recomputed(thrown, ())["outcome"] == "contact_lost"


def test_differences_tell_missing_values() -> None:
    row = {"outcome": "inverts", "t_init_A": 1.0, "t_end_A": numpy.nan, "t_end_B": 2.0}
    fine = {"outcome": "inverts", "t_init_A": 1.25, "t_end_A": None, "t_end_B": None}
    assert differences(row, fine) == {"t_init_A": 0.25, "t_end_B": numpy.inf}


def test_rows_that_go_on_without_contact_have_nothing_to_be_compared_with() -> None:
    frictions = {"mu": "0.3,3"}
    spec = SweepSpec.of("reference", until="0.7", vary=frictions, contact="bilateral")
    swept = run_sweep(spec, recheck=1)
    assert [force > 0 for force in swept.rows["min_g_n"]] == [True, False]
    assert swept.summary["recheck"]["rows"] == 1
