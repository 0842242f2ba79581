"""The reference solution: figures 2 to 8 of the paper redrawn, and lambda in every precision.

The figures are drawn from runs with every extremum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.claims.claim import LAMBDA_KEPT
from tt_precise.claims.evidence.motions import minima
from tt_precise.claims.evidence.run import REFERENCE, Run, SceneLike
from tt_precise.claims.rauch_rutstam.section23_curve import PRINTED
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.precision import KINDS
from tt_precise.integration.reading import drift_over_time
from tt_precise.mechanics.quantities import effective_potential
from tt_precise.report import style
from tt_precise.report.document import Block, PageTable, Section
from tt_precise.report.prose import short
from tt_precise.report.style import Numbers, figure
from tt_precise.runtime.plotting import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, SYMBOLS
from tt_precise.runtime.values import Array, Scalar
from tt_precise.scene.scene import load_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCENE = "reference"
EVERY = 0.004  # Spacing in s between the extrema; a nutation lasts 0.037 s.
TIME = "$t$ (s)"
MILLI = 1e3
# The symbol and the colour of each column.
CURVES = {
    **{name: (SYMBOLS[name], colour) for name, colour in {
        "theta": BLUE, "theta_dot": ORANGE, "phi_dot": BLUE, "psi_dot": GREY, "nu_x": BLUE,
        "nu_y": GREEN, "omega_3": BLUE, "g_n": RED, "E": BLACK, "E_rot": BLUE, "E_pot": SKY,
        "E_trans": GREEN, "E_tilde": BLUE,
    }.items()},
    "omega_3_dot": (r"$\dot\omega_3$", GREY), "D": ("$D$", BLUE), "E_dot": (r"$\dot E$", BLUE),
    "E_trans_dot": (r"$\dot E_{trans}$", GREEN), "E_pot_dot": (r"$\dot E_{pot}$", RED),
    "E_rot_dot": (r"$\dot E_{rot}$", PURPLE), "tau_x": (r"$\tau_x$", BLUE),
    "tau_y": (r"$\tau_y$", ORANGE), "tau_z": (r"$\tau_z$", GREEN),
}  # fmt: skip


def course(*names: str, scene: SceneLike = "reference") -> dict[str, Array]:
    """Float columns by name, and "t": the samples and every extremum of each column."""
    run = Run(scene)
    times = numpy.arange(run.whole.begin, run.whole.end, EVERY)
    for moments in (run.turning_points["t"].astype(float), *(run.extrema(n)[0] for n in names)):
        times = numpy.union1d(times, moments)
    return run.columns(names, numpy.union1d(times, run.whole.end))


def draw(
    panel: Axes, data: dict[str, Array], *names: str, unit: str, what: str = "", scale: float = 1.0
) -> None:
    """Draw columns over time; the label has their symbols, or ``what``, and the unit."""
    for name in names:
        symbol, colour = CURVES[name]
        style.curve(panel, data["t"], scale * data[name], symbol, colour)
    panel.set_ylabel(f"{what or ', '.join(CURVES[name][0] for name in names)} ({unit})")


def draw_tilt(panel: Axes, data: dict[str, Array]) -> None:
    """Draw theta."""
    draw(panel, data, "theta", unit="rad")
    mark_angles(panel.yaxis)


def mark_angles(axis: Any) -> None:
    """Mark 0, pi/2 and pi on an axis of theta."""
    axis.set_ticks([0, math.pi / 2, math.pi], labels=["0", "π/2", "π"])


def draw_precession(panel: Axes, rate: dict[str, Array], linear: float, share: float) -> None:
    """Draw phi_dot and psi_dot on a scale that shows spikes and rest."""
    draw(panel, rate, "psi_dot", "phi_dot", what=r"$\dot\varphi$, $\dot\psi$", unit="rad/s")
    panel.set_yscale("symlog", linthresh=linear, linscale=share)
    panel.set_yticks([-1e4, -1e3, -linear, 0, linear, 1e3, 1e4])
    style.legend(panel)


def over_time(axes: list[Axes], scene: SceneLike = "reference") -> None:
    """Mark the initiation and the ending time (definition A), and label the axis of time."""
    begin, end = Run(scene).climb
    marks = {SYMBOLS["t_init"]: begin, SYMBOLS["t_end"]: end}
    style.moments(axes, {label: t for label, t in marks.items() if t > 0})
    axes[-1].set_xlim(0, 8.0)
    axes[-1].set_xlabel(TIME)


@figure("figure-2", [1.5, 1.5, 2.2])
def figure_2(axes: list[Axes]) -> Numbers:
    """theta, theta_dot, and phi_dot with psi_dot."""
    angle, rate = course("theta_dot", "theta"), course("phi_dot", "psi_dot")
    draw_tilt(axes[0], angle)
    draw(axes[1], angle, "theta_dot", unit="rad/s")
    draw_precession(axes[2], rate, 100, 1.5)
    over_time(axes)
    return {"peak": rate["phi_dot"].max()}


@figure("figure-3", [1.6, 1.2, 1.4, 1.5])
def figure_3(axes: list[Axes]) -> Numbers:
    """nu_x and nu_y, omega_3, its derivative, g_n."""
    glide, spin, force = course("nu_x", "nu_y"), course("omega_3", "omega_3_dot"), course("g_n")
    draw(axes[0], glide, "nu_x", "nu_y", unit="m/s")
    axes[0].legend(loc="upper left")
    draw(axes[1], spin, "omega_3", unit="rad/s")
    draw(axes[2], spin, "omega_3_dot", unit="rad/s²")
    axes[2].set_yscale("symlog", linthresh=0.5, linscale=0.8)
    axes[2].set_yticks([-100, -10, -1, 0, 0.5], ["−100", "−10", "−1", "0", "0.5"])
    draw(axes[3], force, "g_n", unit="N")
    axes[3].set_ylim(0, None)
    weight = float(REFERENCE.weight)
    axes[3].axhline(weight, color=BLACK, linewidth=0.8)
    style.note(axes[3], "$mg$", (0.08, weight), (0, 3))
    over_time(axes)
    before = glide["t"] < REFERENCE.equator
    return {
        "nu_y": glide["nu_y"].max(),
        "negative": glide["t"][(glide["nu_y"] < 0) & before].max(),
        "g_n": force["g_n"].min(),
    }


MAGNIFIED = (5.2, 5.6)  # Magnified interval in s.


@figure("figure-4", [2.4, 1.0, 1.0], shared_time=False)
def figure_4(axes: list[Axes]) -> Numbers:
    """E and its three parts, and a magnification."""
    names = ("E", "E_rot", "E_pot", "E_trans")
    draw(axes[0], course(*names), *names, what="energy", unit="mJ", scale=MILLI)
    axes[0].axvspan(*MAGNIFIED, color="#eeeeee", zorder=0)
    axes[0].set_ylim(0, None)
    axes[0].legend(loc="upper right")
    over_time(axes[:1])
    axes[0].set_xlabel("")
    near = numpy.linspace(*MAGNIFIED, 801)
    close = REFERENCE.columns(["E_pot", "E_trans"], list(near))
    for panel, name in zip(axes[1:], ("E_pot", "E_trans"), strict=True):
        symbol, colour = CURVES[name]
        panel.plot(near, MILLI * close[name], color=colour)
        panel.set(ylabel=f"{symbol} (mJ)", xlim=MAGNIFIED)
    axes[2].set_xlabel(f"{TIME}, magnified")
    return {}


@figure("figure-5", [1.7, 1.2, 1.7])
def figure_5(axes: list[Axes]) -> Numbers:
    """The rates of E, E_trans and E_pot, and below the rate of E_rot."""
    data = course("E_dot", "E_trans_dot", "E_pot_dot", "E_rot_dot")
    curves = (("E_dot", "E_trans_dot"), ("E_pot_dot",), ("E_rot_dot", "E_dot"))
    for panel, names in zip(axes, curves, strict=True):
        draw(panel, data, *names, what="rate", unit="mW", scale=MILLI)
        panel.legend(loc="lower left")
    over_time(axes)
    return {}


# Instants in s, with their colours; the next maximum of theta after each is drawn.
INSTANTS = {3.2: BLACK, 4.7: BLUE, 5.3: GREEN, 5.75: PURPLE, 6.1: RED, 7.7: ORANGE}
ABOVE = 6e-3  # J of a well's walls drawn above the level of E~.


@figure("deforming-potential", [3.2, 2.0], shared_time=False)
def deforming_potential(axes: list[Axes]) -> Numbers:
    """V over theta with E~ at six pairs of turning points; theta(t) and the minimum of V."""
    body = load_scene("reference").body.numbers(float)
    lambda_ = float(REFERENCE.thresholds.quantities["lambda"].value)
    angles = numpy.linspace(0.002, math.pi - 0.002, 1200)
    turns = REFERENCE.turning_points
    lows, highs = (
        turns["t"][turns["name"] == name].to_numpy(dtype=float)
        for name in ("theta_min", "theta_max")
    )
    (wells, motion) = axes
    for t, colour in INSTANTS.items():
        high = float(highs[highs > t][0])
        low = float(lows[lows > high][0])
        there = REFERENCE.columns(["theta", "D", "E_tilde"], [high, low])
        top = there["E_tilde"][0] + ABOVE
        for i, dashes, filling in ((0, "-", colour), (1, "--", "white")):
            V = effective_potential(body, numpy.cos(angles), there["D"][i], lambda_, numpy)
            label = f"{high:.2f} s" if i == 0 else None
            below = top > V
            wells.plot(angles[below], MILLI * V[below], dashes, color=colour, label=label)
            wells.plot(there["theta"][i], MILLI * there["E_tilde"][i], "o", color=colour,
                       markerfacecolor=filling, markersize=5)  # fmt: skip
    wells.set(xlabel=r"$\theta$ (rad)", ylabel=r"$V$, $\tilde E$ (mJ)")
    mark_angles(wells.xaxis)
    wells.legend(loc="upper right", ncols=2)
    data = course("theta")
    style.curve(motion, data["t"], data["theta"], r"$\theta(t)$", BLUE)
    tilts, bottoms = _bottoms(lows, lambda_)
    motion.plot(lows, bottoms, ".", color=RED, markersize=3, label="minimum of $V$")
    motion.set_ylabel(r"$\theta$ (rad)")
    mark_angles(motion.yaxis)
    motion.legend(loc="upper left")
    over_time([motion])
    beyond = lows[tilts > bottoms]
    return {"first": beyond[0], "last": beyond[-1]}


def _bottoms(lows: Array, lambda_: float) -> tuple[Array, Array]:
    """Return theta at its minima, and the minimum of V next to each (NaN without one)."""
    body = load_scene("reference").body.numbers(float)
    there = REFERENCE.columns(["theta", "D"], list(lows))
    nearest = [
        min(minima(body, float(D), lambda_), key=lambda angle: abs(angle - theta), default=math.nan)
        for theta, D in zip(there["theta"], there["D"], strict=True)
    ]
    return there["theta"], numpy.array(nearest)


@figure("figure-6", [1.2, 1.2, 1.2])
def figure_6(axes: list[Axes]) -> Numbers:
    """The components of the torque along x, y and z of the moving frame."""
    names = ("tau_x", "tau_y", "tau_z")
    data = course(*names)
    for panel, name in zip(axes, names, strict=True):
        draw(panel, data, name, unit="mN m", scale=MILLI)
        panel.axhline(0, color=BLACK, linewidth=0.8)
    over_time(axes)
    shares = (f"{100 * REFERENCE.share_below_zero(name):.1f} %" for name in names)
    return {"shares": ", ".join(shares)}


@figure("figure-7", [2.2, 1.2, 1.8], shared_time=False)
def figure_7(axes: list[Axes]) -> Numbers:
    """The curve (D, E~) with its limits, D over time, E and E~ over time."""
    data = course("D", "E_tilde", "E")
    quantities = REFERENCE.thresholds.quantities
    limits = {name: quantity.value for name, quantity in quantities.items()}
    # the curve turns back and forth, so it must not be thinned
    axes[0].plot(MILLI * data["D"], MILLI * data["E_tilde"], color=BLUE, linewidth=0.6)
    for ends, mark, colour, label in (
        (limits, "o", BLACK, "limits for its λ"), (PRINTED, "X", RED, "printed")
    ):  # fmt: skip
        both = ([MILLI * float(ends[name + end]) for end in "01"] for name in "DE")
        axes[0].plot(*both, mark, color=colour, markersize=6, label=label)
    axes[0].set(xlabel="$D$ (g m²/s)", ylabel=r"$\tilde E$ (mJ)")
    axes[0].legend(loc="upper left")
    draw(axes[1], data, "D", unit="g m²/s", scale=MILLI)
    draw(axes[2], data, "E_tilde", unit="mJ", what=r"$E$, $\tilde E$", scale=MILLI)
    style.curve(axes[2], data["t"], MILLI * data["E"], "$E$", GREEN)
    axes[2].legend(loc="upper right")
    axes[1].sharex(axes[2])
    axes[1].tick_params(labelbottom=False)
    over_time(axes[1:])
    return {}


PASSES_THE_POLE = "phi-dot-195"


@figure("figure-8", [1.2, 1.2, 1.6, 1.2, 1.2])
def figure_8(axes: list[Axes]) -> Numbers:
    """theta, theta_dot, phi_dot with psi_dot, nu_x with nu_y, and g_n."""
    data = course("theta", "theta_dot", "nu_x", "nu_y", "g_n", scene=PASSES_THE_POLE)
    draw_tilt(axes[0], data)
    draw(axes[1], data, "theta_dot", unit="rad/s")
    draw_precession(axes[2], course("phi_dot", "psi_dot", scene=PASSES_THE_POLE), 300, 2)
    axes[2].set_yticks([-1e4, -1e3, -200, 0, 200, 1e3, 1e4],
                       ["−10⁴", "−10³", "−200", "0", "200", "10³", "10⁴"])  # fmt: skip
    draw(axes[3], data, "nu_x", "nu_y", unit="m/s")
    axes[3].legend(loc="upper right")
    draw(axes[4], data, "g_n", unit="N")
    over_time(axes, PASSES_THE_POLE)
    return {}


AROUND = 0.17  # Seconds drawn before and after the passage: four and a half nutations each way.
PASSAGE_EVERY = 2e-4  # Spacing in s near the passage of the pole.
HALF_WIDTH = 1e3  # Half the width of the magnification, in µrad.


@figure("axis-at-the-pole", [5.0], shared_time=False)
def axis_at_the_pole(axes: list[Axes]) -> Numbers:
    """kx, ky from shortly before to shortly after the initiation time, and the pole magnified."""
    turns = REFERENCE.events("theta_min")
    passage = float(turns["t"].iloc[int(turns["theta"].astype(float).argmin())])
    times = numpy.arange(passage - AROUND, passage + AROUND, PASSAGE_EVERY)
    path = REFERENCE.columns(["kx", "ky"], list(times))
    lows = [float(t) for t in turns["t"] if abs(float(t) - passage) < AROUND]
    dots = REFERENCE.columns(["kx", "ky", "phi_dot"], lows)
    (panel,) = axes
    for half, colour, label in (
        (times <= passage, GREY, "before"), (times >= passage, BLUE, "after")
    ):  # fmt: skip
        panel.plot(path["kx"][half], path["ky"][half], color=colour, label=label)
    for rows, colour, sign in ((dots["phi_dot"] < 0, RED, "<"), (dots["phi_dot"] > 0, GREEN, ">")):
        label = rf"nearest to the pole, $\dot\varphi{sign}0$"
        panel.plot(dots["kx"][rows], dots["ky"][rows], "o", color=colour, markersize=4, label=label)
    panel.plot(0, 0, "+", color=BLACK, markersize=14, label="pole")
    panel.set(xlabel="$k_x$ (rad)", ylabel="$k_y$ (rad)", aspect="equal")
    panel.legend(loc="upper left", bbox_to_anchor=(0, -0.13), ncols=2)
    near = numpy.linspace(passage - 3e-4, passage + 3e-4, 400)
    close = {n: 1e6 * x for n, x in REFERENCE.columns(["kx", "ky"], list(near)).items()}
    inset = panel.inset_axes((0.36, 0.22, 0.27, 0.27))
    inset.plot(close["kx"], close["ky"], color=PURPLE)
    inset.plot(0, 0, "+", color=BLACK, markersize=10)
    inset.set(xlim=(-HALF_WIDTH, HALF_WIDTH), ylim=(-HALF_WIDTH, HALF_WIDTH), aspect="equal",
              xticks=[-500, 0, 500], yticks=[-500, 0, 500])  # fmt: skip
    inset.set_title("magnified (µrad)", fontsize=8)
    inset.tick_params(labelsize=7)
    least = float(numpy.hypot(close["kx"], close["ky"]).min())
    return {"around": AROUND, "passage": passage, "least": least}


DRIFT_COLOURS = (RED, ORANGE, SKY, GREEN, BLUE)


@figure("jellett-drift", [3.4])
def jellett_drift(axes: list[Axes]) -> Numbers:
    """Relative drift of lambda over time in every precision, and the paper's 1e-6."""
    (panel,) = axes
    panel.axhline(LAMBDA_KEPT, color=BLACK, linewidth=1, linestyle="--")
    style.note(panel, "section 2.1: 1e−6", (0.1, LAMBDA_KEPT), (0, 4))
    worst = []
    for run, colour in zip(precision_runs(), DRIFT_COLOURS, strict=False):
        drift = run.drift["jellett"]
        worst.append(f"{short(max(drift))} in {run.label}")
        # log10 before the float: a fine drift may underflow, and zero has no logarithm
        log10 = run.trajectory.precision.context.log10
        sizes = 10.0 ** numpy.array([float(log10(x)) if x else numpy.nan for x in drift])
        times = numpy.array([float(t) for t in run.trajectory.sample_times])
        panel.plot(times, sizes, color=colour, linewidth=0.7)
        label = style.note(panel, run.label, (8, numpy.nanmax(sizes)), (-2, 4))
        label.set(ha="right", color=colour)
    panel.set(yscale="log", ylabel=r"$|\lambda(t)/\lambda(0)-1|$", xlim=(0, 8.0), xlabel=TIME)
    return {"drifts": ", ".join(worst)}


# ---- precisions ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class PrecisionRun:
    """The reference scene in one precision; the distance of its end from the finest run's."""

    trajectory: Trajectory
    state_error: Scalar | None

    @property
    def label(self) -> str:
        """The name of the precision."""
        return self.trajectory.precision.name

    @cached_property
    def drift(self) -> dict[str, Sequence[Scalar]]:
        """Relative drift of the scene's conserved quantities, at each sample."""
        return drift_over_time(self.trajectory.run)


@cache
def precision_runs() -> tuple[PrecisionRun, ...]:
    """Integrate the reference scene in every precision but mp, the finest last."""
    runs = [integrate(SCENE, name) for name in KINDS if name != "mp"]
    finest = runs[-1]
    errors = [*(state_distance(run, finest) for run in runs[:-1]), None]
    return tuple(PrecisionRun(run, error) for run, error in zip(runs, errors, strict=True))


def precisions() -> str:
    """Return the precisions and their steps, in words."""
    return ", ".join(f"{run.label} ({run.trajectory.steps} steps)" for run in precision_runs())


def state_distance(run: Trajectory, reference: Trajectory) -> Scalar:
    """Return the largest difference of the vector components at the end, dimensionless."""
    context, units = reference.precision.context, reference.start.units
    return max(
        abs(context.mpf(run.state.values[name]) - reference.state.values[name])
        / units.of_dimension(reference.run.columns.dimension(name))
        for name in VECTOR_COLUMNS
    )


# ---- sections ------------------------------------------------------------------------------------


def reference() -> Section:
    """The reference solution in pictures."""
    return Section.of_figures(
        "figures", figure_2(), figure_3(), figure_4(), figure_5(), figure_6(), figure_7(),
        figure_8(), deforming_potential(), axis_at_the_pole(),
    )  # fmt: skip


def conservation() -> Section:
    """Drift of lambda and error of the state on the reference scene, in every precision."""
    rows, results = [], {}
    for run in precision_runs():
        drift, error = run.drift["jellett"], run.state_error
        steps = run.trajectory.steps
        rows.append(
            {
                "precision": run.label,
                "steps": str(steps),
                "largest drift of lambda": short(max(drift)),
                "error of the state at 8 s": "reference run" if error is None else short(error),
            }
        )
        results[run.label] = {
            "steps": steps,
            "jellett_drift": short(max(drift), 3),
            "jellett_drift_at_end": short(drift[-1], 3),
            "state_error": None if error is None else short(error, 3),
        }
    blocks: dict[str, Block] = {
        "jellett-drift": jellett_drift(),
        "runs": PageTable.of(rows),
    }
    return Section.of("conservation", blocks, results, samples=len(drift))
