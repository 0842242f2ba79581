"""Pictures of a trajectory, still and moving, and what a notebook shows."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.reading import changes
from tt_precise.integration.views import (
    DPI,
    ELEVATION,
    PEG,
    PEG_END,
    _images,
    _Picture,
    _seen,
    _towards,
    peg_ends,
    playable,
    sampled,
)
from tt_precise.runtime import plotting
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene


@pytest.fixture(scope="module")
def short(half: Scene) -> Trajectory:
    return integrate(half, events=("theta_min", "theta_max"))


def test_the_overview(short: Trajectory) -> None:
    drawn = short.plot()
    theta, energies, force, drift = drawn.axes
    assert (theta.get_ylabel(), force.get_ylabel()) == (r"$\theta$ / rad", "$g_n$ / N")
    # rounding is drawn as it is, an error of many sizes by its logarithm
    assert (len(energies.lines), len(drift.lines), drift.get_yscale()) == (4, 2, "linear")
    coarse = short.again(tolerance=1e-6).plot().axes[-1]
    assert coarse.get_yscale() == "symlog"
    values = np.asarray(theta.lines[0].get_ydata(), dtype=float)
    assert values[0] == pytest.approx(0.1)
    ticks = {str(line.get_label()) for line in theta.lines[1:]}
    counts = short.events["name"].value_counts()
    assert ticks == {f"{count} x {name}" for name, count in counts.items()}


def test_other_motions_are_drawn_beside_it_under_their_labels(short: Trajectory) -> None:
    other = integrate(short.scene.varied(mu="0.2"))
    for names in ((), ("theta", "drift:E")):
        drawn = short.plot(*names, beside={"mu = 0.2": other})
        assert len(drawn.axes) == max(1, len(names))
        own, beside = drawn.axes[0].lines[:2]
        assert (own.get_label(), beside.get_label()) == ("reference", "mu = 0.2")
        assert list(np.asarray(beside.get_ydata())) == list(other.frame("theta")["theta"])
        named = short.plot(*names, beside={"mu = 0.2": other}, label="mu = 0.3")
        assert named.axes[0].lines[0].get_label() == "mu = 0.3"
        assert len({str(line.get_color()) for line in drawn.axes[0].lines}) == 4  # and two events
    with pytest.raises(InputError, match="beside: got a list, expected trajectories by their lab"):
        short.plot("theta", beside=[other])  # type: ignore[arg-type]


def test_the_drift_of_a_fine_run_is_drawn_as_it_is(half: Scene) -> None:
    run = integrate(half.varied(until="0.1"), "double-double")
    drawn = run.plot().axes[-1].lines[0].get_ydata()
    assert max(np.asarray(drawn, dtype=float)) == pytest.approx(float(run.drift["jellett"]))
    assert max(np.asarray(drawn, dtype=float)) < 1e-25


def test_columns_of_ones_choice(short: Trajectory) -> None:
    drawn = short.plot("g_n", "phi_dot")
    assert [axes.get_ylabel() for axes in drawn.axes] == ["$g_n$ / N", r"$\dot\varphi$ / rad/s"]
    assert drawn._repr_svg_().rstrip().endswith("</svg>")  # type: ignore[attr-defined]
    with pytest.raises(InputError, match="column: got 'lean'"):
        short.plot("lean")


def test_the_drift_of_every_quantity_can_be_drawn(short: Trajectory) -> None:
    jellett, energy, theta = short.plot("drift:jellett", "drift:E", "theta").axes
    assert jellett.get_ylabel() == "relative drift\nof jellett"
    assert energy.get_ylabel() == "relative change\nof $E$"  # friction takes it: no error
    assert max(np.asarray(jellett.lines[0].get_ydata(), float)) == float(short.drift["jellett"])
    E = short.frame("E")["E"]
    assert np.asarray(energy.lines[0].get_ydata(), float)[-1] == pytest.approx(
        1 - E.iloc[-1] / E.iloc[0]
    )
    scales = [axes.get_yscale() for axes in (jellett, energy, theta)]
    assert scales == ["linear", "linear", "linear"]
    assert short.again(tolerance=1e-6).plot("drift:lambda").axes[0].get_yscale() == "symlog"
    drawn = short.plot("drift:nu_x").axes[0].lines[0].get_ydata()
    assert np.asarray(drawn, float)[-1] <= 1  # as nu_x starts at 0
    with pytest.raises(
        InputError, match="column: got 'drift:lean', expected drift: and one of: jel"
    ):
        short.plot("drift:lean")


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_drift_is_a_column_of_frames_too(rough: Scene, precision: str) -> None:
    """In every kind of number: its largest value is ``drift``."""
    run = integrate(rough, precision, until="0.05")
    names = ("drift:jellett", "theta", "drift:E", "drift:nu_x")
    tables = [run.table(*names, numbers=kind) for kind in ("float", "exact", "text")]
    for table in tables:
        assert list(table) == ["t", *names]
        assert all(len(column) == len(run.sample_times) for column in table.values())
        assert [float(table[f"drift:{name}"][0]) for name in ("jellett", "E", "nu_x")] == [0, 0, 0]
        assert max(map(float, table["drift:jellett"])) == float(run.drift["jellett"])
        energy = run.table("E", numbers="exact")["E"]
        assert float(table["drift:E"][-1]) == pytest.approx(
            abs(float((energy[-1] - energy[0]) / energy[0])), rel=1e-9
        )
    assert list(run.frame("drift:lambda")["drift:lambda"]) == list(tables[0]["drift:jellett"])
    with pytest.raises(InputError, match="times: got times with estimated errors or drifts"):
        run.frame("drift:jellett", times=[0.01])


@pytest.mark.parametrize(
    ("name", "kept", "lost"),
    [
        ("reference", ["lambda", "axis_norm"], ["E", "omega_3", "L_z", "s_dot_x", "D"]),
        ("frictionless", ["E", "omega_3", "L_z", "s_dot_x"], ["D", "E_tilde", "theta"]),
        ("rolling", ["E", "D", "E_tilde", "E_tilde_main"], ["omega_3", "E_rot"]),
        ("flight", ["E", "E_rot", "omega_3"], ["E_pot"]),
    ],
)
def test_a_change_of_what_a_motion_does_not_conserve_is_no_error(
    name: str, kept: list[str], lost: list[str]
) -> None:
    run = integrate(name, until="0.1")
    asked = [f"drift:{one}" for one in (*kept, *lost)]
    note = changes(run.run, asked)
    named = note.partition(": changes since")[0]
    assert named == ", ".join(f"drift:{one}" for one in lost)
    assert note.endswith(f"this motion conserves {', '.join(run.drift)}")
    assert changes(run.run, [f"drift:{one}" for one in kept]) == ""
    table = run.frame(*asked)
    assert all(table[f"drift:{one}"].max() < 1e-13 for one in kept)
    assert all(table[f"drift:{one}"].max() > 1e-9 for one in lost)


def test_a_run_that_ended_early_says_so(rough: Scene) -> None:
    assert "contact_lost" in integrate(rough).plot("theta").axes[0].get_title("left")


def test_html_of_a_trajectory_and_a_scene(short: Trajectory) -> None:
    shown = short._repr_html_()
    for text in ("reference", "complete", "theta_dot", short.state.as_text()["theta"], "theta_min"):
        assert text in shown
    scene = short.scene._repr_html_()
    for text in ("Reference solution", "body.alpha", ">0.3<", "start.omega_3", "155"):
        assert text in scene
    assert "<b>" not in replace(short.scene, title="<b>bold</b>")._repr_html_()


def test_pictures_that_move_have_their_frames(short: Trajectory, tmp_path: Path) -> None:
    done: list[float] = []
    made = short.animate(tmp_path / "top.gif", seconds=0.3, fps=10, progress=done.append)
    with Image.open(made) as picture:
        assert getattr(picture, "n_frames", 1) == 3
        first = picture.convert("RGB").copy()
        picture.seek(2)
        assert picture.convert("RGB").tobytes() != first.tobytes()
        assert picture.size == (720, 468)
    assert done[-1] == 1


def test_a_frame_is_a_picture_of_everything(short: Trajectory) -> None:
    """Still parts are drawn once; a full drawing has the spines on top, and differs there."""

    def picture() -> tuple[Figure, _Picture]:
        drawn = plotting.new_figure(6.0, 3.9)
        drawn.set_layout_engine("none")
        return drawn, _Picture(drawn, sampled(short.run, 0.0, 0.4, 3), "a title")

    drawn, moving = picture()
    frames = [np.asarray(image) for image in _images(drawn, [moving], 3, lambda part: None)]
    drawn, moving = picture()
    for artist in moving.show(2):
        artist.set_animated(False)
    drawn.set_dpi(DPI)
    canvas = FigureCanvasAgg(drawn)
    canvas.draw()
    differ = [(np.asarray(canvas.buffer_rgba()) != frame).any(axis=2).mean() for frame in frames]
    assert differ[2] < 1e-3 < differ[1] < differ[0]


def test_an_animation_needs_no_network(short: Trajectory, tmp_path: Path) -> None:
    text = short.animate(tmp_path / "top.html", end=0.25).read_text("utf-8")
    assert "http" not in text.replace("http://www.w3.org", "")
    for part in ('type="range"', 'id="top-speed"', "track of the contact point"):
        assert part in text
    played = json.loads(re.search(r'id="motion">(.*?)</script>', text)[1])  # type: ignore[index]
    count = len(played["theta"])
    times = [played["every"] * i for i in range(count)]
    assert times[-1] == pytest.approx(0.25)
    frame = short.frame("theta", "kx", "kz", times=times)
    assert played["theta"] == pytest.approx(list(frame["theta"]), abs=6e-5)
    # the sphere's centre is above the contact point: alpha k from the centre of mass
    assert played["x"][0] == pytest.approx(0.3 * np.sin(0.1), abs=1e-3)
    assert "lift" not in played


def test_the_page_names_a_law_of_friction_that_is_not_viscous(short: Trajectory) -> None:
    coulomb = short.scene.varied(friction={"law": "coulomb", "mu": "0.1"}, until="0.01")
    titles = [
        playable(run.run, 0.0, 0.01, 1.0)["title"]
        for run in (short, integrate(coulomb, record=("phi", "psi", "x", "y")))
    ]
    name = short.scene.name
    assert titles == [f"{name}: complete", f"{name}, coulomb friction: complete"]


def test_two_tops_move_beside_each_other(
    short: Trajectory,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    other = integrate(short.scene.varied(mu="0.2"), until="0.3")
    made = short.animate(beside={"mu = 0.2": other}, label="mu = 0.3")
    assert capsys.readouterr().out == "reference.html: open it in a browser\n"
    text = made.read_text("utf-8")
    found = re.findall(r'type="application/json" id="motion\d*">(.*?)</script>', text)
    first, second = map(json.loads, found)
    spans = [one["every"] * (len(one["theta"]) - 1) for one in (first, second)]
    assert spans == pytest.approx([0.3, 0.3])
    assert first["theta"] != second["theta"]
    assert len(set(re.findall(r' id="([^"]+)"', text))) == text.count(' id="')
    assert re.findall("<h1>(.*?)</h1>", text) == ["mu = 0.3: complete", "mu = 0.2: complete"]
    shown = made._repr_html_()
    assert shown is not None
    assert shown.startswith("<iframe srcdoc=")
    both = short.animate("top.gif", beside={"mu = 0.2": other}, seconds=0.2, fps=10)
    with Image.open(both) as picture:
        assert picture.size == (1440, 468)
    assert both._repr_html_() is None


def test_a_top_that_flies_is_drawn_above_the_table(tmp_path: Path) -> None:
    run = integrate("flight")
    text = run.animate(tmp_path / "top.html").read_text("utf-8")
    played = json.loads(re.search(r'id="motion">(.*?)</script>', text)[1])  # type: ignore[index]
    heights = run.frame("height", times=[0, run.t_end])["height"] / float(run.scene.body.R)
    assert [played["lift"][0], played["lift"][-1]] == pytest.approx(list(heights), abs=1e-3)
    assert max(played["lift"]) > 0.1


@pytest.mark.parametrize("kz", [1.0, 0.3, 0.0, -0.3, -0.87, -1.0])
def test_the_peg_does_not_sink_through_the_table(kz: float) -> None:
    foot, end = peg_ends(kz)
    assert 0 < foot <= end <= 1 + PEG
    assert 1 + end * kz >= PEG_END - 1e-12


def test_words_and_panels_stand_inside_the_picture(short: Trajectory) -> None:
    drawn = plotting.new_figure(6.0, 3.9)
    drawn.set_layout_engine("none")
    _Picture(drawn, sampled(short.run, 0.0, 0.1, 2), "a title").show(0)
    for thing in (*drawn.axes, *drawn.texts):
        box = thing.get_window_extent()
        assert 0 <= box.x0 < box.x1 <= drawn.bbox.x1
        assert 0 <= box.y0 < box.y1 <= drawn.bbox.y1


def test_what_is_nearer_to_the_eye_hides_what_is_behind() -> None:
    """Seen along +Y and a little down: to the eye there is no way across or up the picture."""
    toward = np.array([[0.0], [-np.cos(ELEVATION)], [np.sin(ELEVATION)]])
    assert _towards(toward) == pytest.approx([1])
    assert np.ravel(_seen(toward)) == pytest.approx([0, 0])


def test_the_track_is_below_the_centre_of_the_sphere(short: Trajectory) -> None:
    """The contact point is the integral of v_A - omega x a."""
    frames = sampled(short.run, 0.0, 0.5, 5)
    assert frames.track[0, :2] == pytest.approx([0.3 * np.sin(0.1), 0.0], abs=1e-12)
    assert frames.theta == pytest.approx(np.arccos(frames.turn[:, 2, 2]), abs=1e-9)


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("top.avi", {}, r"expected a name that ends in \.gif, \.html, \.mp4"),
        ("top.gif", {"begin": 0.4, "end": 0.1}, "expected a span within 0 to 0.5 s"),
        ("top.gif", {"end": 9.0}, "expected a span within 0 to 0.5 s"),
        ("top.gif", {"fps": 0}, "got 12.0 s with 0 frames in each, expected both above 0"),
        ("top.gif", {"seconds": -1.0}, "got -1.0 s with 20 frames in each, expected both above 0"),
    ],
)
def test_what_cannot_be_animated(
    short: Trajectory, tmp_path: Path, name: str, options: dict[str, float], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        short.animate(tmp_path / name, **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_mp4_needs_ffmpeg(
    short: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from matplotlib.animation import FFMpegWriter

    monkeypatch.setattr(FFMpegWriter, "isAvailable", lambda: False)
    with pytest.raises(InputError, match="needs ffmpeg"):
        short.animate(tmp_path / "top.mp4")


def test_equal_runs_make_equal_pictures(half: Scene) -> None:
    first, second = (plotting.svg_text(integrate(half).plot("theta")) for _ in range(2))
    assert first == second


def test_estimated_errors_are_columns_and_can_be_drawn(half: Scene) -> None:
    run = integrate(half, digits=5)
    frame, errors = run.frame("theta", "error:theta", "digits"), run.error_over_time("theta")
    assert list(frame.columns) == ["t", "theta", "error:theta", "digits"]
    assert (frame["error:theta"] == errors["theta"]).all()
    assert (frame["digits"] == errors["digits"]).all()
    text = run.table("error:theta", numbers="text")
    assert [float(x) for x in text["error:theta"]] == list(errors["theta"])
    angle, digits = run.plot("error:theta", "digits").axes
    assert (angle.get_yscale(), angle.get_ylabel()) == ("log", r"error of $\theta$ / rad")
    assert digits.get_ylabel() == "digits / 1"
    with pytest.raises(InputError, match="expected no times; choose the samples by sample_every"):
        run.frame("error:theta", times=["0.1"])
    with pytest.raises(InputError, match="column: got 'nothing'"):
        run.frame("error:nothing")
