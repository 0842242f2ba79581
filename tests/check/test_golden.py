"""Distance from the scene's solution: golden rows, or an integration."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check, matches, refuses
from tests.conftest import more, of_each_kind
from tests.golden.tables import edit_cell, other_digit
from tt_precise.check.checks import CHECKS
from tt_precise.golden import store
from tt_precise.mechanics.newton import NewtonState
from tt_precise.scene.scene import parse_scene

RELATIVE = [one.name for one in CHECKS if one.sense == "at most"]
MINE = replace(tt.load_scene("reference"), name="mine")
# What explains a failure is tested elsewhere.
without_causes = pytest.mark.usefixtures("no_cause")


def golden(source: Any, scene: Any = "reference", **words: Any) -> Any:
    """Return the check of the distance from golden data."""
    return check(source, scene, **words)["golden"]


@pytest.mark.parametrize("scene", of_each_kind(store.scenes()))
def test_golden_files_pass_at_the_limit_of_double(scene: str) -> None:
    path = store.home() / scene / "trajectory.csv"
    result = check(path, scene, limits=dict.fromkeys(RELATIVE, 1e-13))
    assert result.passed, str(result)
    assert result["jellett"].verdict == "pass"
    assert result["golden"].value == 34


@without_causes
@pytest.mark.parametrize("scene", ["coulomb-flight", "elastic-linear", "elastic-hunt-crossley"])
def test_a_wrong_row_of_a_top_that_lifts_is_noticed(scene: str) -> None:
    frame = pandas.DataFrame(tt.golden.load(scene))[VECTORS]
    assert check(frame, scene, digits=12).passed
    wrong = frame.assign(ky=frame["ky"] + 1e-9 * (frame.index == len(frame) // 2))
    failed = check(wrong, scene, digits=12)
    assert [finding.name for finding in failed.failures] == ["golden"]


OF_EACH_KIND = ("reference", "rolling", "upright")
MORE_KINDS = ("contact-lost", "beside-the-pole", "track")


@without_causes
@pytest.mark.parametrize(
    "scene",
    [
        *OF_EACH_KIND,
        *map(more, MORE_KINDS),
        *(
            pytest.param(scene, marks=pytest.mark.slow)
            for scene in store.scenes()
            if scene not in OF_EACH_KIND + MORE_KINDS
        ),
    ],
)
def test_digits_are_those_of_golden_compare(scene: str) -> None:
    rows = pandas.DataFrame(tt.golden.load(scene))
    rows = rows.iloc[:: min(20, len(rows) // 2)]
    others = {"t", "height", "rise"}
    if tt.load_scene(scene).model == "rolling":
        others |= {"vx", "vy", "nu_x", "nu_y"}
    names = [name for name in rows if name not in others]
    rng = numpy.random.default_rng(7)
    spoiled = rows[["t", *names]].copy()
    for name, size in zip(names, 10.0 ** rng.uniform(-16, -9, len(names)), strict=True):
        spoiled[name] += size * rng.standard_normal(len(rows))
    found, expected = golden(spoiled, scene), tt.golden.compare(spoiled, scene)
    assert found.parts == pytest.approx(dict(expected.digits.dropna()), abs=0.005)
    assert found.value == pytest.approx(expected.worst)


@without_causes
def test_exactly_the_digits_asked_for_are_enough(healthy: Healthy) -> None:
    worst = golden(healthy()).value
    for asked, verdict in ((worst, "pass"), (numpy.nextafter(worst, numpy.inf), "fail")):
        found = golden(healthy(), digits=asked)
        assert (found.value, found.verdict) == (worst, verdict)


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    return Path(shutil.copy(store.home() / "reference" / "trajectory.csv", tmp_path / "run.csv"))


@without_causes
def test_more_than_double_is_seen(copied: Path) -> None:
    edit_cell(copied, 301, "Lz", lambda cell: other_digit(cell, 29))
    found = golden(copied, digits=30)
    assert (found.verdict, found.parts["kx"]) == ("fail", 34)
    assert found.parts["Lz"] < 30


def test_sums_of_time_steps_are_matched(healthy: Healthy) -> None:
    # what an integrator knows as 0.01 * k may be off by 1e-10 s; the state is that of its time
    times = [float(t) + 1e-10 for t in healthy()["t"][:-1]]
    found = golden(tt.integrate("reference").frame(*healthy().columns[1:], times=times))
    assert found.note.startswith("799 rows compared integrated in double-double; ")
    assert found.value == pytest.approx(golden(healthy()).value, abs=3)


def test_other_bodies_and_names_have_no_golden_data(healthy: Healthy) -> None:
    """Then the scene is integrated."""
    for scene in (MINE, tt.load_scene("reference").varied(mu="0.31")):
        found = golden(healthy(), scene)
        assert found.note.startswith("800 rows compared integrated in double-double")
    assert found.value < 1
    assert golden(healthy(), MINE, digits=9).verdict == "pass"


def test_another_start_fails_and_is_named(healthy: Healthy) -> None:
    result = check(healthy("phi-dot-195"), "reference")
    assert [one.name for one in result.failures] == ["start"]
    assert "another start than the scene's" in result["start"].note
    meant = check(healthy("phi-dot-195"), "reference", start="other")
    assert meant.passed
    assert (meant["start"].verdict, meant["golden"].verdict) == ("skipped", "skipped")
    refuses("digits: the solution has the scene's start", healthy(), start="other", digits=8)


def test_a_table_that_is_left_is_named() -> None:
    """All three texts name one time, rounded down in the advice, which then helps."""
    scene = tt.load_scene("contact-lost")
    text = scene.text.replace("[start]", '[contact]\nlost = "fly"\n\n[start]')
    flying = parse_scene(text, "flying", "flying.toml")
    frame = tt.integrate(flying).frame(*NewtonState._fields, numbers="float")
    said = 'the solution leaves the table at 1.33692 s; until=1.33, or lost = "fly"'
    result = check(frame, scene)
    (cause,) = result.causes
    assert (cause.kind, cause.text[: len(said)]) == ("end", said)
    assert said in result["golden"].note
    assert said in refuses("leaves", frame, scene, digits=8)
    assert check(frame, scene, digits=8, until=1.33).passed


@pytest.mark.parametrize("scene", ["coulomb-flight", "contact-lost"])
def test_a_run_is_compared_to_its_landing_or_lift_off(scene: str) -> None:
    frame = tt.integrate(scene, digits=8).frame(numbers="text")
    found = golden(frame, scene, digits=8)
    assert found.verdict == "pass"
    assert "rows after the start in all" not in found.note
    reported = tt.golden.compare(frame, scene)
    assert (len(reported.over_time), reported.unmatched) == (len(frame), 0)


@pytest.mark.parametrize(
    ("name", "digits"), [more("coulomb-flight", 8), more("contact-lost", 8), ("contact-lost", 16)]
)
def test_a_fresh_solution_that_ends_early_is_compared_to_its_end(name: str, digits: int) -> None:
    """The last row may lie beyond the solution's own end by what its digits leave open."""
    scene = replace(tt.load_scene(name), name="mine")
    frame = tt.integrate(scene, digits=digits).frame(numbers="text")
    found = golden(frame, scene, digits=digits)
    assert found.verdict == "pass"
    assert found.note.startswith(f"{len(frame) - 1} rows compared integrated in ")
    assert "rows after the start in all" not in found.note
    t, ky = Decimal(frame["t"].iloc[-1]), Decimal(frame["ky"].iloc[-1])
    beyond, within = t * (1 + Decimal("1e-6")), t * (1 + Decimal(f"0.5e-{digits}"))
    for change in ({"t": beyond}, {"t": within, "ky": ky + Decimal("1e-6")}):
        wrong = frame.copy()
        for column, value in change.items():
            wrong.loc[len(frame) - 1, column] = str(value)
        shown = f"{len(frame) - 2} of {len(frame) - 1} rows after the start"
        # a double does not know that a row lies by less than a rounding beyond the end
        with pytest.raises((tt.InputError, AssertionError), match=f"{shown}|ky 6"):
            matches(wrong, scene, digits=digits)


@pytest.mark.parametrize("sense", [-1, 1])
def test_a_row_at_an_early_end_agrees_in_time_and_state_or_is_refused(sense: int) -> None:
    """The solution's end is a result too: it has as many digits as are asked for."""
    rows = pandas.DataFrame(tt.golden.load("coulomb-flight"))[VECTORS]
    last = numpy.arange(len(rows)) == len(rows) - 1

    def ending(later: float, wrong: float) -> pandas.DataFrame:
        return rows.assign(t=rows["t"] * (1 + last * sense * later), ky=rows["ky"] + last * wrong)

    found = golden(ending(5e-9, 1e-10), "coulomb-flight", digits=8)
    assert (found.verdict, len(rows) - 1) == ("pass", int(found.note.split()[0]))
    assert found.value == pytest.approx(10, abs=0.5)
    for later, wrong in ((2e-8, 0.0), (1e-3, 0.0), (5e-9, 1e-7)):
        # the solution has a row before the end, to which the last one is compared, and none behind
        with pytest.raises((tt.InputError, AssertionError), match=r"41 of 42 rows|golden: "):
            matches(ending(later, wrong), "coulomb-flight", digits=8)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda frame: frame[frame["t"] <= 5], "t = 5 and 8 s"),
        (lambda frame: frame.iloc[:-1], "t = 7.99 and 8 s"),
        (lambda frame: frame[(frame["t"] < 3) | (frame["t"] > 3.02)], "t = 2.99 and 3.03 s"),
        (lambda frame: frame.iloc[[0, 800]], "t = 0 and 8 s"),
        (lambda frame: frame.iloc[::200], "t = 0 and 2 s"),
    ],
)
def test_what_was_not_seen_is_not_vouched_for(
    healthy: Healthy, spoil: Callable[[pandas.DataFrame], pandas.DataFrame], message: str
) -> None:
    refused = refuses(f"there is no row between {message}", spoil(healthy()), digits=8)
    assert "--until 0 " not in refused  # which leaves no trajectory


@pytest.mark.parametrize("first", [2, 150])
def test_a_restart_has_the_digits_of_its_rows(healthy: Healthy, first: int) -> None:
    """From there on every row counts, and the horizon is the log's own."""
    rows = healthy().iloc[first:400]
    assert matches(rows, "reference", digits=9).passed
    assert f"the solution at t = {first / 100:g} s" in check(rows, "reference")["start"].note
    cut = rows.drop(index=range(200, 210))
    refuses("there is no row between", cut, digits=9)


def test_a_blow_up_is_no_lack_of_digits(healthy: Healthy) -> None:
    frame = healthy()
    frame.loc[799:, "Lx"] = numpy.nan
    with pytest.raises(AssertionError, match="the rows end at Lx = nan in row 799") as failed:
        matches(frame, "reference", digits=8)
    assert "correct digits:" not in str(failed.value)


@without_causes
def test_rows_beyond_the_end_of_golden_data_are_compared(healthy: Healthy) -> None:
    frame = healthy()
    longer = pandas.concat([frame, frame.iloc[[-1]].assign(t=8.01, kx=5.0)], ignore_index=True)
    with pytest.raises(AssertionError, match="kx 0"):
        matches(longer, "reference", digits=8)
    assert matches(longer, "reference", digits=8, until=8).passed
    whole = golden(frame, digits=8)
    assert whole.note == "800 rows compared at golden times; largest gap 0.01 s"
    early = check(frame[:101], "reference")["golden"]
    assert early.note == "100 rows compared at golden times; the rows end at 1 of 8 s"


@without_causes
def test_rows_between_golden_times_are_compared(healthy: Healthy) -> None:
    times = [0.0, *(0.0031 + 0.0171 * i for i in range(467))]
    frame = tt.integrate("reference").frame(*healthy().columns[1:], times=times)
    found = golden(frame, until=7.9, digits=9)
    assert found.verdict == "pass"
    assert found.note.startswith("462 rows compared integrated in ")
    late = frame.assign(t=frame["t"] + numpy.where(frame["t"] > 3, 1e-7, 0))
    bad = golden(late, until=7.9, digits=9)
    assert bad.verdict == "fail"
    assert bad.at > 3


@without_causes
@pytest.mark.parametrize("digits", [9, more(15), more(20)])
def test_every_row_between_golden_times_is_compared(digits: int) -> None:
    times = [f"{0.01 * i + (0.003 if i % 20 == 10 else 0):.3f}" for i in range(801)]
    frame = tt.integrate("reference", digits=22).frame(times=times, numbers="text")
    wrong = frame.copy()
    wrong.loc[10::20, "vx"] = [repr(1.1 * float(cell) + 1e-3) for cell in frame["vx"][10::20]]
    with pytest.raises(AssertionError, match="vx "):
        matches(wrong, "reference", digits=digits)
    assert matches(frame, "reference", digits=digits).passed


@without_causes
@pytest.mark.parametrize("rows", [1500, more(5000)])
def test_every_row_is_compared(rows: int) -> None:
    """Each row once, whatever its place."""
    scene = MINE.varied(until="0.5")
    t = numpy.linspace(0, 0.5, rows)
    frame = tt.integrate(scene, digits=11).frame(*EULER[1:], times=t.tolist(), numbers="float")
    right = golden(frame, scene, digits=9)
    assert right.note.startswith(f"{rows - 1} rows compared integrated in ")
    for row in (0, 1, rows // 2 + 1, rows - 2, rows - 1):
        wrong = frame.assign(omega_3=frame["omega_3"] * (1 + 1e-7 * (frame.index == row)))
        with pytest.raises(AssertionError, match="omega_3 "):
            matches(wrong, scene, digits=9)


@without_causes
@pytest.mark.evidence
def test_rows_beside_a_stick_or_a_slip_are_not_held_to_a_series_that_ends_there() -> None:
    """Golden rows are 2 ms apart, and the top sticks and slips between some of them."""
    scene, times = "coulomb-stick-slip", [0.0, *(0.0003 + 0.001 * n for n in range(100))]
    frame = tt.integrate(scene).frame(times=times)
    assert matches(frame, scene, digits=9).passed
    wrong = frame.assign(kx=frame["kx"] + 1e-8 * (frame.index == 80))
    with pytest.raises(AssertionError, match="kx"):
        matches(wrong, scene, digits=9)


def test_rows_of_a_top_that_may_lift_are_compared_at_their_own_times() -> None:
    frame = tt.integrate("elastic-linear").frame(times=[0.0, 0.0011, 0.0033, 0.0055])
    assert golden(frame, "elastic-linear").value > 9


def test_a_height_without_velocities_is_not_looked_at() -> None:
    frame = tt.integrate("flight").frame(*EULER[1:5], "height", "rise")
    assert matches(frame, "flight", digits=9).passed


@without_causes
@pytest.mark.parametrize("scene", ["track", more(replace(tt.load_scene("track"), name="mine"))])
def test_the_track_is_compared(scene: Any) -> None:
    rows = pandas.DataFrame(tt.golden.load("track"))[:201]
    words: Any = {"digits": 8, "until": 2.0}
    track = ("phi", "psi", "x", "y")
    assert {*track} <= golden(rows, scene, **words).parts.keys()
    for name in track:
        wrong = rows.assign(**{name: rows[name] + 1e-5 * (rows.index == 150)})
        with pytest.raises(AssertionError, match=f"{name} "):
            matches(wrong, scene, **words)
        assert tt.golden.compare(wrong, "track").digits[name] < 8
    # an angle may be counted within one turn
    assert matches(rows.assign(phi=rows["phi"] % (2 * numpy.pi)), scene, **words).passed


@without_causes
@pytest.mark.parametrize("text", ["nan", "inf", "", "None", "what"])
def test_no_number_where_golden_data_have_one_has_no_digits(copied: Path, text: str) -> None:
    edit_cell(copied, 301, "omega_3", lambda _: text)
    result = check(copied, "reference", digits=8)
    assert {finding.name for finding in result.failures} == {"finite", "golden"}
    assert result["golden"].parts["omega_3"] == 0
    assert result["finite"].at == result["golden"].at == 2.99


def test_a_solution_is_compared_at_the_rows_own_times() -> None:
    frame = tt.integrate("reference").frame(times=[0.001 + 0.013 * i for i in range(60)])
    found = golden(frame, MINE, digits=10, until=0.77)
    assert found.verdict == "pass"
    assert found.note.startswith("59 rows compared integrated in ")
    assert set(found.parts) == set(frame.columns) - {"t"}
    assert all(digits == round(digits, 2) for digits in found.parts.values())
    reported = golden(frame, MINE, until=0.77)
    assert (reported.verdict, reported.limit, *reported.parts) == ("pass", None, *found.parts)
    spoiled = frame.assign(kz=frame["kz"] + 1e-8)
    bad = golden(spoiled, MINE, digits=10, until=0.77)
    assert bad.verdict == "fail"
    assert bad.parts["kz"] == pytest.approx(8, abs=0.01)


def test_digits_over_time_say_where_to_stop(healthy: Healthy) -> None:
    """Errors that grow as those of a coarse integrator."""
    frame = healthy()
    growing = frame.assign(omega_3=frame["omega_3"] * (1 + 1e-10 * 10 ** (1.2 * frame["t"])))
    result = check(growing, "reference")
    assert [one.name for one in result.failures] == ["agreement"]
    assert "solution   0.4 digits: 8 digits until 1.66 s" in str(result)
    assert result["golden"].history == (
        "8 digits until 1.66 s, 4 digits until 5.07 s, 2 digits until 6.67 s, none from 7.51 s"
    )
    assert result.as_dict()["checks"][-1]["digits_over_time"] == result["golden"].history
    with pytest.raises(AssertionError, match=r"over time: 8 digits until 1\.66 s"):
        matches(growing, "reference", digits=8)
    assert matches(growing, "reference", digits=8, until=1.6).passed


@pytest.mark.parametrize("number", [float("nan"), float("inf"), "8", True, 0, -3])
def test_thresholds_are_finite(healthy: Healthy, number: Any) -> None:
    with pytest.raises(tt.InputError, match=r"digits: got .*, expected a"):
        matches(healthy(), "reference", digits=number)
    if not isinstance(number, int) or isinstance(number, bool):
        for keywords in ({"until": number}, {"limits": {"jellett": number}}):
            refuses("expected a finite number", healthy(), **keywords)


# What ``integrate(digits=N)`` delivers passes ``check --digits N``.

FEW = [("reference", 6), ("regularised-1e-2", 4), ("rolling", 9)]
MORE = [("reference", 12), ("track", 20)]
GRID = [
    *FEW,
    *(more(*case) for case in MORE),
    *(
        pytest.param(scene, digits, marks=pytest.mark.slow)
        for scene in store.scenes()
        for digits in range(4, 31)
        if (scene, digits) not in FEW + MORE
    ),
]


@without_causes
@pytest.mark.parametrize(("scene", "digits"), GRID)
def test_delivered_digits_pass_the_check(scene: str, digits: int) -> None:
    frame = tt.integrate(scene, digits=digits).frame(numbers="text")
    assert matches(frame, scene, digits=digits).passed
    # not because anything would: an error in the last digit asked for is found
    spoiled = frame.assign(kz=[repr(float(kz) + 3 * 10.0**-digits) for kz in frame["kz"]])
    if digits < 15:
        with pytest.raises(AssertionError, match="kz"):
            matches(spoiled, scene, digits=digits)


def test_golden_data_vouch_for_33_digits() -> None:
    rows = tt.golden.load("contact-lost", "text")
    assert matches(rows, "contact-lost", digits=33).passed
    message = "got 34, expected a number above 0 and at most 33"
    refuses(message, rows, "contact-lost", digits=34)
