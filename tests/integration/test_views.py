"""Pictures of a trajectory: columns over time, and the page on which the top moves."""

import json
import re
from pathlib import Path
from typing import Any

import numpy
import pytest

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.reading import changes
from tt_precise.runtime import plotting
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene


@pytest.fixture(scope="module")
def short(half: Scene) -> Trajectory:
    return integrate(half, events=("theta_min", "theta_max"))


def curve(axes: Any, line: int = 0) -> numpy.ndarray:
    return numpy.asarray(axes.lines[line].get_ydata(), dtype=float)


def test_the_overview(short: Trajectory) -> None:
    theta, energies, force, drift = short.plot().axes
    assert (theta.get_ylabel(), force.get_ylabel()) == (r"$\theta$ / rad", "$g_n$ / N")
    # rounding is drawn on a linear scale, an error of many decades on a logarithmic one
    assert (len(energies.lines), len(drift.lines), drift.get_yscale()) == (4, 2, "linear")
    assert short.again(tolerance=1e-6).plot().axes[-1].get_yscale() == "symlog"
    assert curve(theta)[0] == pytest.approx(0.1)
    assert max(curve(drift)) == float(short.drift["jellett"])
    ticks = {str(line.get_label()) for line in theta.lines[1:]}
    assert ticks == {f"{count} x {name}" for name, count in short.event_counts.items()}


@pytest.mark.parametrize(
    ("column", "label", "scale"),
    [
        ("g_n", "$g_n$ / N", "linear"),
        ("phi_dot", r"$\dot\varphi$ / rad/s", "linear"),
        ("drift:jellett", "relative drift\nof jellett", "linear"),
        ("drift:E", "relative change\nof $E$", "linear"),  # friction takes it: no error
        ("error:theta", r"error of $\theta$ / rad", "log"),
        ("digits", "digits / 1", "linear"),
    ],
)
def test_a_panel_has_the_column_and_its_unit(
    short: Trajectory, column: str, label: str, scale: str
) -> None:
    (axes,) = short.plot(column).axes
    assert (axes.get_ylabel(), axes.get_yscale()) == (label, scale)
    assert curve(axes) == pytest.approx(short.frame(column)[column].to_numpy(), nan_ok=True)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("lean", "column: got 'lean'"),
        ("drift:lean", "column: got 'drift:lean', expected drift: and one of: jel"),
        ("error:lean", "column: got 'lean'"),
    ],
)
def test_an_unknown_column_is_refused(short: Trajectory, name: str, message: str) -> None:
    for draw in (short.plot, short.frame):
        with pytest.raises(InputError, match=message):
            draw(name)


@pytest.mark.parametrize("names", [(), ("theta", "drift:E")])
def test_other_motions_have_curves_under_their_labels(
    short: Trajectory, names: tuple[str, ...]
) -> None:
    other = integrate(short.scene.varied(mu="0.2"))
    axes = short.plot(*names, beside={"mu = 0.2": other}, label="mu = 0.3").axes
    assert len(axes) == max(1, len(names))
    assert [line.get_label() for line in axes[0].lines[:2]] == ["mu = 0.3", "mu = 0.2"]
    assert list(curve(axes[0], 1)) == list(other.frame("theta")["theta"])
    assert len({str(line.get_color()) for line in axes[0].lines}) == 4  # and two events


def test_runs_without_labels_are_refused(short: Trajectory) -> None:
    with pytest.raises(InputError, match="beside: got a list, expected trajectories by their lab"):
        short.plot("theta", beside=[short])  # type: ignore[arg-type]


def test_a_run_that_ended_early_says_so(rough: Scene) -> None:
    assert "contact_lost" in integrate(rough).plot("theta").axes[0].get_title("left")


def test_equal_runs_make_equal_pictures(half: Scene) -> None:
    first, second = (plotting.svg_text(integrate(half).plot("theta")) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_drift_is_a_column_of_frames_in_every_kind_of_number(
    rough: Scene, precision: str
) -> None:
    run = integrate(rough, precision, until="0.05")
    names = ("drift:jellett", "theta", "drift:E", "drift:nu_x")
    energy = run.table("E", numbers="exact")["E"]
    for kind in ("float", "exact", "text"):
        table = run.table(*names, numbers=kind)
        assert list(table) == ["t", *names]
        assert [float(table[f"drift:{name}"][0]) for name in ("jellett", "E", "nu_x")] == [0, 0, 0]
        assert max(map(float, table["drift:jellett"])) == float(run.drift["jellett"])
        change = abs(float((energy[-1] - energy[0]) / energy[0]))
        assert float(table["drift:E"][-1]) == pytest.approx(change, rel=1e-9)
    assert list(run.frame("drift:lambda")["drift:lambda"]) == list(run.table(*names)[names[0]])
    with pytest.raises(InputError, match="times: got times with "):
        run.frame("drift:jellett", times=[0.01])


@pytest.mark.parametrize(
    ("name", "conserved", "others"),
    [
        ("reference", ["lambda", "axis_norm"], ["E", "omega_3", "L_z", "s_dot_x", "D"]),
        ("frictionless", ["E", "omega_3", "L_z", "s_dot_x"], ["D", "E_tilde", "theta"]),
        ("rolling", ["E", "D", "E_tilde", "E_tilde_main"], ["omega_3", "E_rot"]),
        ("flight", ["E", "E_rot", "omega_3"], ["E_pot"]),
    ],
)
def test_a_change_of_a_quantity_that_the_motion_does_not_conserve_is_no_error(
    name: str, conserved: list[str], others: list[str]
) -> None:
    run = integrate(name, until="0.1")
    columns = [f"drift:{quantity}" for quantity in (*conserved, *others)]
    note = changes(run.run, columns)
    assert note.partition(": changes since")[0] == ", ".join(columns[len(conserved) :])
    assert note.endswith(f"this motion conserves {', '.join(run.drift)}")
    table = run.frame(*columns)
    assert all(table[f"drift:{quantity}"].max() < 1e-13 for quantity in conserved)
    assert all(table[f"drift:{quantity}"].max() > 1e-9 for quantity in others)


def courses(page: Path) -> list[dict[str, Any]]:
    """The data of the tops of a page."""
    pattern = r'type="application/json" id="motion\d*">(.*?)</script>'
    return [json.loads(text) for text in re.findall(pattern, page.read_text("utf-8"))]


def test_a_page_needs_no_network_and_has_the_motion(short: Trajectory, tmp_path: Path) -> None:
    page = short.animate(tmp_path / "top.html", end=0.25)
    assert "http" not in page.read_text("utf-8").replace("http://www.w3.org", "")
    (course,) = courses(page)
    times = [course["every"] * i for i in range(len(course["theta"]))]
    assert times[-1] == pytest.approx(0.25)
    frame = short.frame("theta", "kx", times=times)
    assert course["theta"] == pytest.approx(list(frame["theta"]), abs=6e-5)
    # the sphere's centre is above the contact point: alpha k from the centre of mass
    assert course["x"][0] == pytest.approx(0.3 * numpy.sin(0.1), abs=1e-3)
    assert "lift" not in course
    assert page._repr_html_().startswith("<iframe srcdoc=")


def test_two_tops_move_at_the_same_time_under_one_set_of_controls(
    short: Trajectory,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    other = integrate(short.scene.varied(mu="0.2"), until="0.3")
    page = short.animate(beside={"mu = 0.2": other}, label="mu = 0.3")
    assert capsys.readouterr().out == "reference.html: open it in a browser\n"
    first, second = courses(page)
    spans = [course["every"] * (len(course["theta"]) - 1) for course in (first, second)]
    assert spans == pytest.approx([0.3, 0.3])
    assert first["theta"] != second["theta"]
    text = page.read_text("utf-8")
    assert len(set(re.findall(r' id="([^"]+)"', text))) == text.count(' id="')
    assert re.findall("<h1>(.*?)</h1>", text) == ["mu = 0.3: complete", "mu = 0.2: complete"]
    assert text.count('class="controls"') == 1
    assert text.rindex("</figure>") < text.index('class="controls"')


def test_a_page_names_a_law_of_friction_that_is_not_viscous(tmp_path: Path) -> None:
    coulomb = load_scene("reference").varied(friction={"law": "coulomb", "mu": "0.1"})
    page = integrate(coulomb, until="0.01").animate(tmp_path / "top.html")
    assert "<h1>reference, coulomb friction: complete</h1>" in page.read_text("utf-8")


def test_a_top_that_flies_is_drawn_above_the_table(tmp_path: Path) -> None:
    run = integrate("flight")
    (course,) = courses(run.animate(tmp_path / "top.html"))
    heights = run.frame("height", times=[0, run.t_end])["height"] / float(run.scene.body.R)
    assert [course["lift"][0], course["lift"][-1]] == pytest.approx(list(heights), abs=1e-3)
    assert max(course["lift"]) > 0.1


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("top.gif", {}, "animate: got .*, expected a name that ends in .html"),
        ("top.html", {"begin": 0.4, "end": 0.1}, "expected a span within 0 to 0.5 s"),
        ("top.html", {"end": 9.0}, "expected a span within 0 to 0.5 s"),
        ("top.html", {"begin": numpy.nan}, "expected a span within 0 to 0.5 s"),
        ("top.html", {"seconds": -1.0}, "got -1.0 s, expected a time above 0"),
    ],
)
def test_other_files_and_spans_are_refused(
    short: Trajectory, tmp_path: Path, name: str, options: dict[str, float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        short.animate(tmp_path / name, **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())
