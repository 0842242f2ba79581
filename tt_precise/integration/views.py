"""A solution as pictures: columns over time, and a moving top with its track."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from html import escape
from pathlib import Path, PosixPath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy

from tt_precise.integration.columns import Name, expanded
from tt_precise.integration.errors import DIGITS, ERROR, table_with_errors
from tt_precise.integration.reading import (
    DRIFT,
    changes,
    drift_over_time,
    event_columns,
    is_drift,
    with_quadratures,
)
from tt_precise.integration.solution import Solution
from tt_precise.mechanics.laws import VISCOUS
from tt_precise.mechanics.quantities import described
from tt_precise.runtime import player, plotting
from tt_precise.runtime.files import atomic_write, replacing
from tt_precise.runtime.terminal import Progress, progress_bar
from tt_precise.runtime.values import Array, InputError, Json, Scalar, shortened
from tt_precise.scene.numerals import as_fraction

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from PIL.Image import Image

    from tt_precise.scene.scene import Scene


WIDTH, PANEL = 7.0, 1.55  # inches
ENERGIES = ("E", "E_rot", "E_trans", "E_pot")


def columns_of(
    run: Solution, names: Sequence[Name], times: Sequence[float] | None = None
) -> dict[str, Array]:
    """Columns in double by their shown names, also of estimated errors; ``times`` in s."""
    exact = None if times is None else list(map(as_fraction, times))
    columns = table_with_errors(run, names, exact, "float")
    return {getattr(name, "name", name): column for name, column in columns.items()}


def figure(
    run: Solution,
    names: tuple[Name, ...] = (),
    others: Mapping[str, Solution] = MappingProxyType({}),
    label: str = "",
) -> Figure:
    """A matplotlib ``Figure`` with a panel for each column, or the overview if none is named.

    Every panel of a column has the curves of the ``others`` too, under their labels, next to
    this run's ``label``.
    """
    if others and not names:
        names = ("theta",)
    panels: tuple[tuple[Name, ...], ...] = tuple((name,) for name in names)
    if not names:
        panels = (("theta",), ENERGIES, ("g_n",))
    samples = columns_of(run, [name for panel in panels for name in panel])
    count = len(panels) + (not names)
    with plotting.styled():
        drawn = plotting.new_figure(WIDTH, PANEL * count + 0.5)
        axes = list(drawn.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
        for panel, place in zip(panels, axes, strict=False):
            if is_drift(panel[0]):
                name = str(panel[0])
                _drifts(place, run, {name.removeprefix(DRIFT): samples[name]})
            else:
                _panel(place, samples, panel)
            for its_label, other in others.items():
                curve = columns_of(other, panel)
                name = str(getattr(panel[0], "name", panel[0]))
                place.plot(curve["t"], curve[name], label=its_label)
        if others:
            axes[0].lines[0].set_label(label)
            axes[0].legend(loc="center left", bbox_to_anchor=(1, 0.5))
        if not names:
            _drifts(axes[-1], run, drift_over_time(run))
        _events(axes[0], run, 1 + len(others))
        axes[-1].set_xlabel("t / s")
        note = "" if run.status == "complete" else f" ({run.status})"
        axes[0].set_title(f"{run.scene.name}{note}")
        drawn.align_ylabels(axes)
    return drawn


def _panel(axes: Axes, samples: Mapping[str, Array], columns: tuple[Name, ...]) -> None:
    names = [str(getattr(column, "name", column)) for column in columns]
    for name in names:
        at = plotting.thinned(samples["t"], samples[name])
        axes.plot(samples["t"][at], samples[name][at], label=_label(name))
    first = names[0].removeprefix(ERROR)
    unit = "1"
    if first != DIGITS:
        unit = getattr(columns[0], "unit", None) or described(first).unit
    if names[0].startswith(ERROR):
        axes.set_yscale("log")
    axes.set_ylabel((f"{_label(names[0])} / " if len(names) == 1 else "") + unit)
    if len(names) > 1:
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    if names == ["g_n"]:
        axes.axhline(0, color=plotting.GREY, linewidth=0.8)


def _drifts(axes: Axes, run: Solution, drifts: Mapping[str, Sequence[Scalar]]) -> None:
    times = [float(t) for t in run.sample_times]
    floats = {name: numpy.array(values, dtype=float) for name, values in drifts.items()}
    for name, values in floats.items():
        axes.plot(times, values, label=name.replace("_", " "))
    one = next(iter(drifts)) if len(drifts) == 1 else ""
    what = "change" if changes(run, [f"{DRIFT}{name}" for name in drifts]) else "drift"
    eps = float(run.precision.eps)
    largest = max(numpy.nanmax(values) for values in floats.values())
    # three decades above rounding and more are drawn logarithmically down to eps
    if what == "drift" and largest > 1000 * eps:
        axes.set_yscale("symlog", linthresh=eps)
        locator: Any = axes.yaxis.get_major_locator()
        locator.set_params(numticks=6)
    axes.set_ylim(bottom=0)
    axes.set_ylabel(f"relative {what}\nof {_label(one)}" if one else "relative drift")
    if not one:
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))


def _events(axes: Axes, run: Solution, curves: int) -> None:
    """A tick for each event, one row for each name, below the first panel's ``curves``."""
    times: dict[str, list[float]] = {}
    events = event_columns(run, ())
    for name, t in zip(events["name"], events["t"], strict=True):
        times.setdefault(name, []).append(float(t))
    for row, (name, there) in enumerate(times.items()):
        colour = plotting.CYCLE[(row + curves) % len(plotting.CYCLE)]
        axes.plot(
            there, [0.02 + 0.05 * row] * len(there), "|", markersize=5, color=colour,
            label=f"{len(there)} x {name}",
            transform=axes.get_xaxis_transform(),
        )  # fmt: skip
    if times:
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))


def _label(name: str) -> str:
    if name.startswith(ERROR):
        return f"error of {_label(name.removeprefix(ERROR))}"
    return plotting.SYMBOLS.get(name, name)


FORMATS = (".gif", ".html", ".mp4")
ELEVATION = 0.30  # rad above the table, from where it is seen
PEG = 0.12  # The drawn stem ends this far beyond the sphere, in R; the model has none.
PEG_END = 0.15  # Half the width of its line, in R, which stays above the table.
# Values of each course in a page of 0.1 MB: a nutation is round, and a screen has fewer pixels.
LEAST_PLAYED, MOST_PLAYED = 1500, 4000
PLAYED_EVERY_S = 0.01
CIRCLE_POINTS = 73
MOST_FRAMES = 20_000  # Frames of a moving picture, which stay in memory: 11 min at 30 a second.
FINER = 8  # points of the track for each frame
DPI = 120  # 720 x 468 pixels


class Frames(NamedTuple):
    """The data of n frames: times (s), orientations (n, 3, 3), inclinations (rad).

    ``track`` has the contact point, in units of R, FINER times as often.
    """

    t: numpy.ndarray
    turn: numpy.ndarray
    theta: numpy.ndarray
    track: numpy.ndarray


class Animation(PosixPath):
    """The file of an animation; a notebook shows a page (.html) below the cell."""

    def _repr_html_(self) -> str | None:
        if self.suffix.lower() != ".html":
            return None
        page = escape(self.read_text(encoding="utf-8"))
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 640px; border: 0"></iframe>'


def animate(
    run: Solution,
    path: str | Path,
    *,
    others: Mapping[str, Solution] = MappingProxyType({}),
    label: str = "",
    seconds: float = 12.0,
    fps: int = 20,
    begin: float = 0.0,
    end: float | None = None,
    progress: Progress | None = None,
) -> Animation:
    """Write the animation of ``run`` and of ``others`` from ``begin`` to ``end`` (s).

    A page (.html) plays in a browser without a network, with a slider and several speeds; ``fps``
    is of no importance there, and ``seconds`` chooses the first speed.

    Raises ``InputError``: an unknown suffix, an empty span of time, no frames, a trajectory without
    a pose, or .mp4 without ffmpeg.
    """
    target = Animation(path)
    named = {label or _name_of(run.scene): run, **others}
    if not (0 < fps <= MOST_FRAMES and 0 < seconds <= MOST_FRAMES / fps):
        raise InputError(
            f"animate: got {shortened(seconds)} s with {shortened(fps)} frames in each, expected "
            f"both above 0, and at most {MOST_FRAMES} frames"
        )
    require_animation(target)
    # the runs that have the pose: an early end may differ in its last bits
    runs = {name: with_quadratures(one) for name, one in named.items()}
    last = min(float(one.t_end) for one in runs.values()) if end is None else end
    if target.suffix.lower() == ".html":
        motions = [playable(one, begin, last, seconds, name) for name, one in runs.items()]
        atomic_write(target, player.page(motions))
        return target
    count = max(2, round(seconds * fps))
    bar = progress_bar("frames") if progress is None else nullcontext(progress)
    with plotting.styled():
        drawn = plotting.new_figure(6.0 * len(runs), 3.9)
        drawn.set_layout_engine("none")
        pictures = [
            _Picture(part, sampled(one, begin, last, count), f"{name}  ({one.scene.title})")
            for part, (name, one) in zip(
                drawn.subfigures(1, len(runs), squeeze=False)[0], runs.items(), strict=True
            )
        ]
        with replacing(target) as temporary, bar as report:
            images = _images(drawn, pictures, count, report)
            if target.suffix.lower() == ".gif":
                _save_gif(temporary, images, fps)
            else:
                _save_mp4(temporary, images, fps, drawn)
    return target


def _images(
    drawn: Figure, pictures: Sequence[_Picture], count: int, report: Progress
) -> Iterator[Image]:
    """The frames as images; what does not move is drawn once."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    drawn.set_dpi(DPI)
    canvas = FigureCanvasAgg(drawn)
    canvas.draw()
    still = canvas.copy_from_bbox(drawn.bbox)
    for number in range(count):
        canvas.restore_region(still)
        for picture in pictures:
            for artist in picture.show(number):
                artist.draw(canvas.get_renderer())
        yield Image.fromarray(numpy.array(canvas.buffer_rgba()))
        report((number + 1) / count)


def _save_gif(path: Path, images: Iterator[Image], fps: int) -> None:
    """Write images in the colours of the first, which has every artist."""
    from PIL.Image import Dither, Quantize

    first = next(images).convert("RGB").quantize(method=Quantize.FASTOCTREE)
    others = (image.convert("RGB").quantize(palette=first, dither=Dither.NONE) for image in images)
    first.save(path, "GIF", save_all=True, append_images=others, duration=int(1000 / fps), loop=0)


def _save_mp4(path: Path, images: Iterator[Image], fps: int, drawn: Any) -> None:
    from matplotlib import animation

    writer = animation.FFMpegWriter(fps)
    with writer.saving(drawn, path, DPI):
        for image in images:
            # the writer takes what the figure saves, which would draw all of it again
            drawn.savefig = lambda file, of=image, **_: file.write(of.tobytes())
            writer.grab_frame()


def playable(
    run: Solution, begin: float, end: float, seconds: float, label: str = ""
) -> dict[str, Json]:
    """The data of the page that plays, see ``runtime.player``."""
    _require_span(run, begin, end)
    count = min(MOST_PLAYED, max(LEAST_PLAYED, round((end - begin) / PLAYED_EVERY_S)))
    times = numpy.linspace(begin, end, count + 1)
    names = ("theta", "phi", "psi", "x", "y", "z", "kx", "ky", "kz")
    table = columns_of(with_quadratures(run), names, times.tolist())
    scene = run.scene
    R, alpha = float(scene.body.R), float(scene.body.alpha)
    course = {name: table[name] for name in ("theta", "phi", "psi")}
    # the point below the sphere's centre, which lies alpha R along the axis from the centre of mass
    for name in ("x", "y"):
        course[name] = table[name] / R + alpha * table[f"k{name}"]
    above = table["z"] / R + alpha * table["kz"] - 1
    if scene.further_columns:
        course["lift"] = numpy.maximum(above, 0)
    words = (
        f"{scene.title or scene.name}: theta over {begin:g} to {end:g} s, and the track of the "
        "point below the sphere's centre, in radii of the top. The model is a sphere: the drawn "
        "stem ends where the table is."
    )
    return player.drawing(
        (end - begin) / count,
        {name: values.tolist() for name, values in course.items()},
        title=f"{label or _name_of(scene)}: {run.status}",
        words=words,
        begin=begin,
        seconds=seconds,
    )


def _name_of(scene: Scene) -> str:
    """The scene's name, with the law of friction where it is not the viscous one."""
    law = scene.body.friction
    return scene.name if law is VISCOUS else f"{scene.name}, {law.name} friction"


def _require_span(run: Solution, begin: float, end: float) -> None:
    """Refuse a span of an animation that is empty or not in the run."""
    if not 0 <= begin < end <= float(run.t_end):
        raise InputError(
            f"animate: got {shortened(begin)} to {shortened(end)} s, expected a span within 0 to "
            f"{float(run.t_end):g} s"
        )


def sampled(run: Solution, begin: float, end: float, count: int) -> Frames:
    """``count`` poses, equally spaced in time.

    Raises ``InputError``: the span is empty or reaches beyond the run.
    """
    from scipy.spatial.transform import Rotation

    _require_span(run, begin, end)
    times = numpy.linspace(begin, end, FINER * (count - 1) + 1).tolist()
    table = columns_of(run, expanded(["theta", "pose"]), times)
    body = run.scene.body
    R, alpha = float(body.R), float(body.alpha)
    quaternions = numpy.column_stack([table[name] for name in ("qw", "qx", "qy", "qz")])
    turn = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    # below the sphere's centre, which lies alpha R along the axis from the centre of mass
    track = numpy.column_stack([table[name] for name in "xyz"]) / R + alpha * turn[:, :, 2]
    track[:, 2] = 0
    return Frames(table["t"][::FINER], turn[::FINER], table["theta"][::FINER], track)


def require_animation(path: Path) -> None:
    """Refuse a file that cannot be made, before anything is computed.

    Raises ``InputError``: another ending than ``FORMATS``, or .mp4 without ffmpeg.
    """
    from matplotlib import animation

    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise InputError(f"animate: got {path}, expected a name that ends in {', '.join(FORMATS)}")
    if ending == ".mp4" and not animation.FFMpegWriter.isAvailable():
        raise InputError(f"animate: got {path}, which needs ffmpeg; expected .gif or .html without")


class _Picture:
    """The artists of one drawing: a close view of the top, and the track from above."""

    def __init__(self, drawn: Figure | SubFigure, frames: Frames, title: str):
        from matplotlib.patches import Circle

        self.frames = frames
        self.track = frames.track
        drawn.suptitle(title, x=0.03, y=0.97, ha="left", fontsize="medium")
        self.clock = drawn.text(0.03, 0.875, "", ha="left", family="monospace", fontsize=9)
        self.near = drawn.add_axes((0.0, 0.0, 0.58, 0.86))
        above = drawn.add_axes((0.66, 0.16, 0.32, 0.66))
        for axes in (self.near, above):
            axes.set_aspect("equal")
        self.near.axis("off")
        self.near.set_xlim(-2.1, 2.1)
        self.near.set_ylim(-0.9, 2.9)
        above.set_title("track, from above / R", fontsize=9)
        above.plot(self.track[:, 0], self.track[:, 1], color="#e2e2e2", linewidth=1)
        orange, grey = plotting.ORANGE, plotting.GREY
        (self.path,) = above.plot([], [], color=orange, linewidth=1.1)
        (self.spot,) = above.plot([], [], "o", color=orange, markersize=4)
        (self.grid,) = self.near.plot([], [], color="#dddddd", linewidth=0.6)
        (self.trail,) = self.near.plot([], [], color=orange, linewidth=1.2, zorder=1)
        self.ball = Circle((0, 0), 1, facecolor="#eef4fa", edgecolor=grey, linewidth=1, zorder=3)
        self.near.add_patch(self.ball)
        self.back, self.front = (
            [self.near.plot([], [], color=colour, linewidth=width, zorder=z)[0] for _ in range(4)]
            for colour, width, z in (("#c9d6e2", 0.7, 4), (plotting.BLUE, 1.4, 6))
        )
        (self.peg,) = self.near.plot(
            [], [], color=plotting.RED, linewidth=9, solid_capstyle="round", zorder=5
        )
        angle = numpy.linspace(0, 2 * numpy.pi, CIRCLE_POINTS)
        c, s, none = numpy.cos(angle), numpy.sin(angle), 0 * angle
        self.moving: list[Artist] = [
            self.clock, self.path, self.spot, self.grid, self.trail, self.ball,
            *self.back, *self.front, self.peg,
        ]  # fmt: skip
        for artist in self.moving:
            artist.set_animated(True)
        # two meridians, the equator and a circle round the peg, fixed in the body
        self.circles = [
            numpy.stack(points)
            for points in (
                (c, none, s), (none, c, s), (c, s, none), (0.35 * c, 0.35 * s, none + 0.937),
            )
        ]  # fmt: skip

    def show(self, number: int) -> list[Artist]:
        """Move everything to frame ``number``; returns what moves, the farthest first."""
        turn, now = self.frames.turn[number], FINER * number
        place, past = self.track[now], self.track[: now + 1]
        middle = numpy.array([[0.0], [0.0], [1.0]])  # of the sphere, seen by an eye that follows
        self.ball.center = tuple(float(v[0]) for v in _seen(middle))
        for circle, front, back in zip(self.circles, self.front, self.back, strict=True):
            points = turn @ circle
            across, up = _seen(points + middle)
            near = _towards(points) >= 0
            front.set_data(numpy.where(near, across, numpy.nan), numpy.where(near, up, numpy.nan))
            back.set_data(numpy.where(near, numpy.nan, across), numpy.where(near, numpy.nan, up))
        k = turn[:, 2:]
        self.peg.set_data(*_seen(middle + k * numpy.array(peg_ends(float(k[2, 0])))))
        # the peg in front of the ball, or behind it
        self.peg.set_zorder(5 if float(_towards(k)[0]) > 0 else 2.5)
        self._table(place)
        self.trail.set_data(*_seen((past - place).T))
        self.path.set_data(past[:, 0], past[:, 1])
        self.spot.set_data([place[0]], [place[1]])
        self.clock.set_text(
            f"t = {self.frames.t[number]:.3f} s, theta = {self.frames.theta[number]:.3f} rad"
        )
        return sorted(self.moving, key=lambda artist: artist.get_zorder())

    def _table(self, position: Array) -> None:
        """Lines on the table, half a radius apart, as seen by an eye that follows the top."""
        reach = 3.0
        ends = numpy.array([-reach, reach, numpy.nan])  # NaN between two lines
        steady = numpy.arange(-reach, reach + 0.5, 0.5)
        x, y = (numpy.repeat(steady - place % 0.5, 3) for place in position[:2])
        along = numpy.tile(ends, len(steady))
        points = numpy.stack([numpy.append(x, along), numpy.append(along, y)])
        self.grid.set_data(*_seen(numpy.vstack([points, 0 * points[:1]])))


def peg_ends(kz: float) -> tuple[float, float]:
    """The ends of the peg from the sphere's centre, in radii; its round end is above the table."""
    end = 1 + PEG if kz >= 0 else min(1 + PEG, (1 - PEG_END) / -kz)
    return min(0.97, end), end


def _seen(points: Array) -> tuple[Array, Array]:
    """The positions of points (3, n) in the picture, seen along +Y and slightly from above."""
    return points[0], points[2] * numpy.cos(ELEVATION) + points[1] * numpy.sin(ELEVATION)


def _towards(points: Array) -> Array:
    """The distance of points (3, n) towards the eye."""
    return points[2] * numpy.sin(ELEVATION) - points[1] * numpy.cos(ELEVATION)
