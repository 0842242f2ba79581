"""Errors that are stated, against the truth, and digits that are requested."""

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.integration.conftest import against, changed
from tt_precise.integration import Trajectory, errors, integrate
from tt_precise.integration.errors import digits_of_time, digits_over_rows
from tt_precise.integration.precision import KINDS
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene, shipped

EVENTS = ("theta_min", "phi_dot_zero", "extremum:g_n")
COLUMNS = ("kx", "theta", "phi_dot", "nu_x", "g_n", "E", "xi", "tau_y", "psi_dot")


def assert_errors(stated: Any, true: Any) -> None:
    """The estimates are the errors, but for those of the finer run, thirty times less."""
    stated, true = stated.to_numpy(), abs(numpy.array(true, dtype=float))
    assert true.max() > 1e-13
    assert (abs(stated - true) < 0.1 * true.max()).all()


@pytest.mark.parametrize("precision", ["double", "double-double", "quad"])
def test_the_estimate_is_the_error(short: Scene, truth: Trajectory, precision: str) -> None:
    run, exact = integrate(short, precision), truth.precision.context.mpf
    for name, value in run.state.values.items():
        error = abs(exact(value) - truth.state.values[name])
        rounding = 1.1 * run.precision.eps * abs(value)  # of the stored value
        assert 0.99 * error <= run.error_estimate[name] <= 1.05 * error + rounding, name


def test_an_estimate_is_never_below_the_rounding_of_what_is_stored() -> None:
    """At t = 0 vy is 0.39999999999999997 in double, 0.4 exactly."""
    run = integrate("kicked", until="0.1")
    row = run.frame("vy", "error:vy").iloc[0]
    assert 0 < abs(Fraction(row["vy"]) - Fraction("0.4")) <= row["error:vy"] < 1e-16


def test_an_end_of_its_own_has_an_error_too(rough: Scene) -> None:
    lost, truth = integrate(rough), integrate(rough, "quad")
    error = abs(truth.precision.context.mpf(lost.t_end) - truth.t_end)
    assert lost.error_estimate["t_end"] == pytest.approx(float(error), abs=2e-16)
    # each run has an end of its own, and its errors are those between the ends
    last = lost.frame("error:kx", "error:vy", "error:E").iloc[-1].to_dict()
    assert 0 < last.pop("error:E") < 1e-15
    ends = {"t": lost.t_end} | {f"error:{n}": lost.error_estimate[n] for n in ("kx", "vy")}
    assert last == ends
    coarse = integrate(rough, tolerance=1e-9)
    coarse.errors.at_end["t_end"] = coarse.t_end / 100
    assert coarse.digits_throughout == pytest.approx(2)


def test_entries_that_vanish_altogether_are_compared_with_their_unit(toppling: Scene) -> None:
    """A top without spin that falls over: phi_dot and omega_3 stay 0."""
    trajectory = integrate(toppling.varied(until="0.05"))
    assert trajectory.state.phi_dot == trajectory.state.omega_3 == 0
    assert 13 < trajectory.digits < 16


def test_two_arithmetics_that_end_differently_leave_no_digits(rough: Scene) -> None:
    """A horizon so close to the loss of contact that double cannot decide which comes first."""
    ends = [Fraction(str(integrate(rough, tolerance=size).t_end)) for size in (1e-7, 0.0)]
    torn = integrate(rough.varied(until=sum(ends) / 2), tolerance=1e-7)
    assert {torn.status, torn.errors.reference.status} == {"complete", "contact_lost"}
    assert torn.digits == torn.digits_throughout == torn.frame("digits")["digits"].iloc[-1] == 0
    assert torn.error_estimate["theta"] == torn.frame("error:E")["error:E"].iloc[-1] == numpy.inf


@pytest.mark.parametrize("formulation", ["newton", "euler"])
@pytest.mark.parametrize(
    ("precision", "tolerance"),
    [("double", 1e-9), ("double-double", 1e-22), ("triple-double", 1e-33)],
)
def test_errors_all_along_are_those_beside_the_truth(
    precision: str, tolerance: float, formulation: str
) -> None:
    """Errors of first order, and columns that are compared one by one, say the same."""
    scene = load_scene("reference").varied(until="0.25")
    run, truth = (
        integrate(scene, one, tolerance=size, formulation=formulation)
        for one, size in ((precision, tolerance), ("triple-double", 0.0))
    )
    names = COLUMNS if formulation == "newton" else COLUMNS[1:]
    table = against(run, truth).over_time(names)
    assert run.digits_throughout == pytest.approx(table["digits"].min(), abs=0.1)
    ours, theirs = (one.frame(*names, numbers="exact") for one in (run, truth))
    for name in names:
        worst = max(abs(ours[name] - theirs[name]))
        assert float(worst) == pytest.approx(table[name].max(), rel=0.05), name


# ---- events -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def true_run(short: Scene) -> Trajectory:
    return integrate(short, "double-double", events=EVENTS)


@pytest.fixture(scope="module")
def rough_run(short: Scene) -> Trajectory:
    return integrate(short, events=EVENTS, tolerance=1e-7)


def test_an_estimate_is_the_error_at_an_event(rough_run: Trajectory, true_run: Trajectory) -> None:
    names = ("g_n", "phi_dot", "E")
    columns = ("error:t", *names, *(f"error:{name}" for name in names))
    events, true = (run.event_frame(*columns) for run in (rough_run, true_run))
    assert list(events["name"]) == list(true["name"])
    for name in EVENTS:
        rows = events["name"] == name
        assert_errors(events["error:t"][rows], (events["t"] - true["t"])[rows])
    for name in names:
        assert_errors(events[f"error:{name}"], events[name] - true[name])


def test_an_event_at_the_very_end_is_looked_at_from_before(short: Scene) -> None:
    """Three points around the event do not fit before the end."""
    both, names = (short, changed(short, mu="1e-6")), ("phi_dot_zero",)
    first = [integrate(scene, events=names).events["t"][0] for scene in both]
    late = Fraction(max(first)) + Fraction(1, 10**9)
    run, other = (integrate(scene.varied(until=late), events=names) for scene in both)
    expected = [abs(first[1] - first[0])]
    assert against(run, other).events()["t"] == pytest.approx(expected, rel=1e-3)


def test_digits_hold_in_events_too(rough_run: Trajectory, reference: Scene) -> None:
    """The spike of phi_dot lies between samples, and has five digits fewer than they have."""
    spike = integrate(
        reference.varied(until="3.3"), "double-double", tolerance=1e-26, events="extremum:phi_dot"
    )
    for run in (rough_run, spike):
        least = [one("digits")["digits"].min() for one in (run.event_frame, run.frame)]
        assert 3 < run.digits_throughout == min(least)
    assert least[0] < least[1]


def test_a_reference_that_ends_before_leaves_no_digits(rough_run: Trajectory, short: Scene) -> None:
    distances = against(rough_run, integrate(short.varied(until="0.05")))
    for table, times in (
        (distances.events(("theta",)), rough_run.events["t"]),
        (distances.over_time(("theta",)), rough_run.frame()["t"]),
    ):
        beyond = times.to_numpy() > 0.05
        assert 0 < beyond.sum() < len(beyond)
        for name, lost in (("digits", 0), ("theta", numpy.inf), ("t", numpy.inf)):
            assert ((table[name] == lost) == beyond).all()


@pytest.mark.parametrize("name", ["elastic-linear", "coulomb-stick-slip"])
def test_every_event_of_several_pieces_has_its_error(name: str) -> None:
    run, true = integrate(name, tolerance=1e-7), tt.golden.load(name).events
    wanted = (*run.scene.events, "stick", "slip", "separation", "landing")
    true = true[true["name"].isin(wanted)]
    events = run.event_frame("error:t", "digits")
    assert list(events["name"]) == list(true["name"])
    assert_errors(events["error:t"], events["t"] - true["t"].astype(float).to_numpy())
    assert (events["digits"] > 4).all()


# ---- digits -------------------------------------------------------------------------------------


def test_digits_are_those_of_the_worst_component_beside_the_size_of_its_vector(
    double: Trajectory,
) -> None:
    frame, unit = double.frame(), float(double.start.units.time)
    L = numpy.sqrt((frame[["Lx", "Ly", "Lz"]] ** 2).sum(axis=1)).to_numpy()
    columns = {name: frame[name].to_numpy() for name in double.run.columns.names}
    errors = {name: 0 * values for name, values in columns.items()}
    for name, error, expected in (("kx", 1e-9 + 0 * L, 9), ("Lz", 1e-6 * L, 6)):
        errors[name] = error
        digits = digits_over_rows(columns, errors, double.start, 53)
        assert digits == pytest.approx(expected, rel=1e-12)
    times = digits_of_time(numpy.full(2, 1e-9), numpy.array([0.0, 8.0]), unit)
    assert times == pytest.approx(-numpy.log10([1e-9 / unit, 1e-9 / 8]))


def test_levels_of_the_ladder(monkeypatch: pytest.MonkeyPatch, reference: Scene) -> None:
    """The first that mostly suffices; then what the estimate lacks is added."""
    tried: list[errors.Level] = []
    monkeypatch.setattr(errors, "errors_of", lambda run: run)

    def levels(
        digits: int, lost: float = 1.0, most: float = 1e9, events: Any = None
    ) -> list[errors.Level]:
        """The levels that are tried, by runs that lose digits, and have ``most`` at most.

        ``events`` are those that stay unresolved in an arithmetic.
        """

        def run(level: errors.Level) -> Any:
            tried.append(level)
            reached = min(level.digits - lost, most)
            unresolved = (events or {}).get(level.precision, ())
            return SimpleNamespace(status="complete", t_end=8.0, digits_throughout=reached,
                                   events_with=lambda kind: unresolved)  # fmt: skip

        tried.clear()
        errors.integrate_to_digits(digits, reference, run)
        return tried

    first, second, third, *_ = errors.LADDER
    assert all(levels(n)[0].digits >= n + errors.LOSS for n in range(1, 60))
    assert [levels(n)[0].precision for n in (34, 60)] == ["triple-double", "mp"]
    enough = 10 - 8 - 0.1  # the first level has 10
    for digits, lost, expected in (
        (6, 1.0, [first]), (8, 2.5, [first, second]), (8, 6.0, [first, third]),
        (8, enough - 0.01, [first]), (8, enough + 0.01, [first, second]),
    ):  # fmt: skip
        assert levels(digits, lost) == expected
    fifth, last = errors.LADDER[4], errors.LADDER[-1]  # unresolved events lead to other arithmetics
    for events, expected in (
        ({"double": "ab"}, [first, fifth]),
        ({"double": "ab", "double-double": "ab"}, [first, fifth]),
        ({"double": "ab", "double-double": "a"}, [first, fifth, last]),
    ):  # fmt: skip
        assert levels(6, events=events) == expected
    with pytest.raises(InputError, match=r"digits: got 9, but reference has 0\.0"):
        levels(9, most=0.0)
    assert [level.precision for level in tried].count("mp") == 1  # a second cannot help


@pytest.mark.parametrize("digits", [0, -3, 2.5, "12", True, float("nan")])
def test_other_numbers_of_digits_are_refused(digits: Any) -> None:
    with pytest.raises(InputError, match="digits: got"):
        integrate("reference", digits=digits)


@pytest.mark.parametrize("more", [{"tolerance": 1e-3}, {"precision": "quad"}, {"bits": 200}])
def test_digits_choose_the_arithmetic(more: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="digits: got a precision, bits or a tolerance too"):
        integrate("reference", digits=8, **more)


@pytest.mark.parametrize(
    ("digits", "expected"),
    [(3, "double"), (12, "double-double"), (40, "triple-double"), (50, "mp")],
)
def test_digits_are_delivered(short: Scene, truth: Trajectory, digits: int, expected: str) -> None:
    run = integrate(short, digits=numpy.int64(digits))  # type: ignore[arg-type]
    assert run.precision.name == expected
    assert against(run, truth).over_time()["digits"].min() >= digits
    assert run.digits_throughout >= digits


def test_a_hopeless_start_is_refused(reference: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, kind in KINDS.items():
        monkeypatch.setitem(KINDS, name, kind._replace(steps=5))
    with pytest.raises(InputError, match=r"digits: got 10, but reference has 0.* \(failed"):
        integrate(reference.varied(mu="1e300"), digits=10)


def right_digits(run: Trajectory) -> float:
    """Digits of the worst entry, at the worst golden time, that golden data confirm."""
    golden, mpf = tt.golden.load(run.scene.name, "text"), run.precision.context.mpf
    assert golden.manifest["status"] == run.status
    names = [column for column in run.state.values if column in golden.columns]
    golden = golden[[mpf(t) < mpf(run.t_end) for t in golden["t"]]]
    rows, true = run.frame(*names, times=golden["t"], numbers="exact")[names], golden[names]
    assert (rows.isna().to_numpy() <= (true == "").to_numpy()).all()
    numbers = rows.astype(object).fillna(mpf("nan")).to_numpy()
    apart = abs((numbers - true.map(lambda text: mpf(text or "nan")).to_numpy()).astype(float))
    columns, distances = (
        dict(zip(names, x.astype(float).T, strict=True)) for x in (numbers, apart)
    )
    return float(digits_over_rows(columns, distances, run.start, run.precision.bits).min())


def test_a_flight_that_ends_on_the_table_has_digits() -> None:
    """The height there is zero: its error counts beside the unit of length."""
    run = integrate("coulomb-flight", digits=9)
    assert (run.status, run.precision.name) == ("landed", "double")
    assert run.digits_throughout >= 9
    assert right_digits(run) >= 9


@pytest.mark.slow
@pytest.mark.parametrize("digits", [4, 6, 9, 12, 15, 20, 25, 30])
@pytest.mark.parametrize("name", shipped())
def test_every_scene_delivers(name: str, digits: int) -> None:
    run = integrate(name, digits=digits)
    assert run.digits_throughout >= digits
    assert right_digits(run) >= digits


def test_a_plane_motion_through_the_pole_has_digits() -> None:
    """The direction of the tilt is uncertain at the pole, and theta_dot too."""
    scene = load_scene("reference").varied(
        alpha="0.3969", I1="0.1435", I3="0.2316", g="9.8", mu="0", theta="0.02872264",
        theta_dot="-10.3735", omega_3="0", nu_x="0.0771", until="0.090351",
    )  # fmt: skip
    assert integrate(scene, digits=9, events="all").digits_throughout >= 9
