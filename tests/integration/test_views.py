"""Pictures of a trajectory: columns over time, and the page on which the top moves."""

import json
import re
from pathlib import Path
from typing import Any

import numpy
import pytest

from tests.conftest import Captured, Patch
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.reading import changes
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene


@pytest.fixture(scope="module")
def run(half: Scene) -> Trajectory:
    return integrate(half, events=("theta_min", "theta_max"))


@pytest.fixture(scope="module")
def other(half: Scene) -> Trajectory:
    return integrate(half.varied(mu="0.2"), until="0.3")


def curve(axes: Any, line: int = 0) -> numpy.ndarray:
    return numpy.asarray(axes.lines[line].get_ydata(), dtype=float)


def test_the_overview(run: Trajectory) -> None:
    theta, energies, force, drift = run.plot().axes
    assert (theta.get_ylabel(), force.get_ylabel()) == (r"$\theta$ / rad", "$g_n$ / N")
    # rounding is drawn on a linear scale, an error of many decades on a logarithmic one
    assert (len(energies.lines), len(drift.lines), drift.get_yscale()) == (4, 2, "linear")
    assert run.again(tolerance=1e-6).plot().axes[-1].get_yscale() == "symlog"
    assert curve(theta)[0] == pytest.approx(0.1)
    assert max(curve(drift)) == float(run.drift["jellett"])
    ticks = {str(line.get_label()) for line in theta.lines[1:]}
    assert ticks == {f"{count} x {name}" for name, count in run.event_counts.items()}


@pytest.mark.parametrize(
    ("column", "label", "scale"),
    [
        ("phi_dot", r"$\dot\varphi$ / rad/s", "linear"),
        ("drift:jellett", "relative drift\nof jellett", "linear"),
        ("drift:E", "relative change\nof $E$", "linear"),  # friction takes it: no error
        ("error:theta", r"error of $\theta$ / rad", "log"),
        ("digits", "digits / 1", "linear"),
    ],
)
def test_a_panel_has_the_column_and_its_unit(
    run: Trajectory, column: str, label: str, scale: str
) -> None:
    (axes,) = run.plot(column).axes
    assert (axes.get_ylabel(), axes.get_yscale()) == (label, scale)
    assert curve(axes) == pytest.approx(run.frame(column)[column].to_numpy(), nan_ok=True)


@pytest.mark.parametrize("names", [(), ("theta", "drift:E")])
def test_other_motions_have_curves_under_their_labels(
    run: Trajectory, other: Trajectory, names: tuple[str, ...]
) -> None:
    axes = run.plot(*names, beside={"mu = 0.2": other}, label="mu = 0.3").axes
    assert len(axes) == max(1, len(names))
    assert [line.get_label() for line in axes[0].lines[:2]] == ["mu = 0.3", "mu = 0.2"]
    assert list(curve(axes[0], 1)) == list(other.frame("theta")["theta"])
    assert len({str(line.get_color()) for line in axes[0].lines}) == 4  # and two events


@pytest.mark.parametrize("precision", ["double", "double-double"])
@pytest.mark.parametrize(
    ("name", "conserved", "others"),
    [
        ("reference", ["lambda", "axis_norm"], ["E", "omega_3", "L_z", "s_dot_x", "D"]),
        ("frictionless", ["E", "omega_3", "L_z", "s_dot_x"], ["D", "E_tilde", "theta"]),
        ("rolling", ["E", "D", "E_tilde", "E_tilde_main"], ["omega_3", "E_rot"]),
        ("flight", ["E", "E_rot", "omega_3"], ["E_pot"]),
        ("upright", ["lambda"], ["theta_dot"]),  # undefined at the pole
    ],
)
def test_a_change_of_a_quantity_that_the_motion_does_not_conserve_is_no_error(
    name: str, conserved: list[str], others: list[str], precision: str
) -> None:
    run = integrate(name, precision, until="0.1")
    columns = [f"drift:{quantity}" for quantity in (*conserved, *others)]
    note = changes(run.run, columns)
    assert note.partition(": changes since")[0] == ", ".join(columns[len(conserved) :])
    table = run.frame(*columns, others[0])
    drifts, end = table[columns].max(), table.iloc[-1]
    assert max(drifts.iloc[: len(conserved)]) < 1e-13
    if name == "upright":
        assert table[columns[-1]].isna().all()
        return
    assert (table[columns].iloc[0] == 0).all()
    assert min(drifts.iloc[len(conserved) :]) > 1e-9
    change = abs(end[others[0]] / table[others[0]][0] - 1)
    assert end[columns[len(conserved)]] == pytest.approx(change, rel=1e-9)


def courses(page: Path) -> list[dict[str, Any]]:
    """The data of the tops of a page."""
    pattern = r'type="application/json" id="motion\d*">(.*?)</script>'
    return [json.loads(text) for text in re.findall(pattern, page.read_text("utf-8"))]


def test_a_page_needs_no_network_and_has_the_motion(run: Trajectory, tmp_path: Path) -> None:
    page = run.animate(tmp_path / "top.html", end=0.25)
    assert "http" not in page.read_text("utf-8").replace("http://www.w3.org", "")
    assert page._repr_html_().startswith("<iframe srcdoc=")
    (course,) = courses(page)
    times = [course["every"] * i for i in range(len(course["theta"]))]
    assert times[-1] == pytest.approx(0.25)
    theta = run.frame("theta", times=times)["theta"].to_list()
    assert course["theta"] == pytest.approx(theta, abs=6e-5)
    # the sphere's centre is above the contact point: alpha k from the centre of mass
    assert course["x"][0] == pytest.approx(0.3 * numpy.sin(0.1), abs=1e-3)
    flown = integrate("flight")
    (course,) = courses(flown.animate(tmp_path / "flight.html"))
    heights = flown.frame("height", times=[0, flown.t_end])["height"] / 0.02
    assert course["lift"][:: len(course["lift"]) - 1] == pytest.approx(list(heights), abs=1e-3)
    assert max(course["lift"]) > 0.1


def test_two_tops_move_at_the_same_time_under_one_set_of_controls(
    run: Trajectory, other: Trajectory, tmp_path: Path, monkeypatch: Patch, capsys: Captured
) -> None:
    monkeypatch.chdir(tmp_path)
    page = run.animate(beside={"mu = 0.2": other}, label="mu = 0.3")
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


def test_other_files_and_spans_are_refused(run: Trajectory, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"expected a name that ends in \.html"):
        run.animate(tmp_path / "top.gif")
    for begin, end in ((0.4, 0.1), (numpy.nan, None), (0.0, 0.6)):
        with pytest.raises(InputError, match=r"expected a span within 0 to 0.5 s"):
            run.animate(tmp_path / "top.html", begin=begin, end=end)
    with pytest.raises(InputError, match=r"got -1.0 s, expected a time above 0"):
        run.animate(tmp_path / "top.html", seconds=-1.0)
    assert not list(tmp_path.iterdir())
