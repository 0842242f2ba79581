"""Figures 2 to 8 of the paper, redrawn from runs with every extremum."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy

from tt_precise.claims.evidence.motions import minima
from tt_precise.claims.evidence.run import REFERENCE, Run, SceneLike
from tt_precise.claims.paper import LAMBDA_KEPT
from tt_precise.claims.rauch_rutstam.section23_curve import PRINTED
from tt_precise.mechanics.quantities import effective_potential
from tt_precise.report import style
from tt_precise.report.precision import precision_runs
from tt_precise.report.prose import short
from tt_precise.report.style import Words
from tt_precise.runtime.values import Array
from tt_precise.scene.scene import load_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


EVERY = 0.004  # Spacing in s between the extrema; a nutation lasts 0.037 s.
TIME = "$t$ (s)"


def course(*names: str, scene: SceneLike = "reference") -> dict[str, Array]:
    """Float columns by name, and "t": the samples and every extremum of each column."""
    run = Run(scene)
    times = numpy.arange(run.whole.begin, run.whole.end, EVERY)
    for moments in (run.turning_points["t"].astype(float), *(run.extrema(n)[0] for n in names)):
        times = numpy.union1d(times, moments)
    return run.columns(names, numpy.union1d(times, run.whole.end))


def climb_marks(scene: SceneLike = "reference") -> dict[str, float]:
    """Initiation and ending time in definition A, by the label drawn."""
    begin, end = Run(scene).climb
    return {r"$t_{\theta\approx0}$": begin, r"$t_{\theta\approx\pi}$": end}


def over_time(axes: list[Axes]) -> None:
    """Limits and label of the common axis of time."""
    axes[-1].set_xlim(0, 8.0)
    axes[-1].set_xlabel(TIME)


def angles_of(panel: Axes) -> None:
    """Label and ticks of a vertical axis of theta."""
    panel.set(ylabel=r"$\theta$ (rad)", yticks=[0, math.pi / 2, math.pi])
    panel.set_yticklabels(["0", "π/2", "π"])


@style.figure("figure-2", [1.5, 1.5, 2.2])
def figure_2(axes: list[Axes]) -> Words:
    """theta, theta_dot, and phi_dot with psi_dot on a scale that shows spikes and rest."""
    angle, rate = course("theta_dot", "theta"), course("phi_dot", "psi_dot")
    style.curve(axes[0], angle["t"], angle["theta"], r"$\theta$", style.BLUE)
    angles_of(axes[0])
    style.curve(axes[1], angle["t"], angle["theta_dot"], "", style.ORANGE)
    axes[1].set_ylabel(r"$\dot\theta$ (rad/s)")
    style.curve(axes[2], rate["t"], rate["psi_dot"], r"$\dot\psi$", style.GREY)
    style.curve(axes[2], rate["t"], rate["phi_dot"], r"$\dot\varphi$", style.BLUE)
    axes[2].set_yscale("symlog", linthresh=100, linscale=1.5)
    axes[2].set_ylabel(r"$\dot\varphi$, $\dot\psi$ (rad/s)")
    axes[2].set_yticks([-1e4, -1e3, -100, 0, 100, 1e3, 1e4])
    style.legend(axes[2])
    style.moments(axes, climb_marks())
    over_time(axes)
    peak = rate["phi_dot"].max()
    return Words(
        caption="Figure 2 redrawn: the reference solution with all extrema. The last panel is "
        "linear up to 100 rad/s and logarithmic beyond. A sampled graph cuts off the spike of "
        f"{peak:,.0f} rad/s at the initiation time; its height is ill conditioned. theta "
        "oscillates about a logistic curve, and phi_dot reverses from - to + at the initiation "
        "time but from + to - at the ending time. Related claims: QUAL-01 to QUAL-05, QUAL-08, "
        "QUAL-26, NUM-08 and NUM-13.",
        alt="Three panels over 0 to 8 s: theta rises from near 0 to pi in an S shape with "
        "small oscillations; theta_dot oscillates, widest before theta passes pi/2; phi_dot "
        "and psi_dot mirror each other with large spikes at the two dashed moments.",
    )


@style.figure("figure-3", [1.6, 1.2, 1.4, 1.5])
def figure_3(axes: list[Axes]) -> Words:
    """nu_x and nu_y, omega_3, its derivative, g_n."""
    glide, spin, force = course("nu_x", "nu_y"), course("omega_3", "omega_3_dot"), course("g_n")
    weight = float(REFERENCE.weight)
    before = glide["t"] < REFERENCE.equator
    negative = glide["t"][(glide["nu_y"] < 0) & before].max()
    style.curve(axes[0], glide["t"], glide["nu_x"], r"$\nu_x$", style.BLUE)
    style.curve(axes[0], glide["t"], glide["nu_y"], r"$\nu_y$", style.GREEN)
    axes[0].set_ylabel(r"$\nu_x$, $\nu_y$ (m/s)")
    axes[0].legend(loc="upper left")
    style.curve(axes[1], spin["t"], spin["omega_3"], "", style.BLUE)
    axes[1].set_ylabel(r"$\omega_3$ (rad/s)")
    style.curve(axes[2], spin["t"], spin["omega_3_dot"], "", style.GREY)
    axes[2].set_yscale("symlog", linthresh=0.5, linscale=0.8)
    axes[2].set_yticks([-100, -10, -1, 0, 0.5])
    axes[2].set_yticklabels(["−100", "−10", "−1", "0", "0.5"])
    axes[2].set_ylabel(r"$\dot\omega_3$ (rad/s²)")
    style.curve(axes[3], force["t"], force["g_n"], "", style.RED)
    axes[3].axhline(weight, color=style.BLACK, linewidth=0.8)
    axes[3].annotate("$mg$", (0.08, weight), xytext=(0, 3), textcoords="offset points")
    axes[3].set(ylabel="$g_n$ (N)", ylim=(0, None))
    style.moments(axes, climb_marks())
    over_time(axes)
    return Words(
        caption="Figure 3 redrawn with all extrema; the derivative of the spin is logarithmic "
        f"beyond 0.5. nu_y reaches {glide['nu_y'].max():.4f} m/s, which section 2.2 rounds to 0.8. "
        "Around the initiation time nu_y crosses nu_x many times, not once. Until "
        f"{negative:.2f} s nu_y is negative at times, and then the derivative of the spin is "
        f"positive. The normal force stays above {force['g_n'].min():.4f} N. Related claims: "
        "NUM-11, NUM-12, NUM-14, NUM-36, QUAL-10 to QUAL-16, QUAL-19 to QUAL-24 and QUAL-35 to "
        "QUAL-39.",
        alt="Four panels over 0 to 8 s: nu_x and nu_y oscillate, nu_y rises in the climb; "
        "omega_3 falls from positive to negative; its derivative has small positive spikes "
        "around the first moment; g_n oscillates about m g, most in the middle of the climb.",
    )


MAGNIFIED = (5.2, 5.6)  # Magnified interval in s.
MILLI = 1e3


@style.figure("figure-4", [2.4, 1.0, 1.0], shared_time=False)
def figure_4(axes: list[Axes]) -> Words:
    """E and its three parts, and a magnification."""
    parts = {
        "E": (style.BLACK, "$E$"),
        "E_rot": (style.BLUE, "$E_{rot}$"),
        "E_pot": (style.SKY, "$E_{pot}$"),
        "E_trans": (style.GREEN, "$E_{trans}$"),
    }
    data = course(*parts)
    near = numpy.linspace(*MAGNIFIED, 801)
    closer = REFERENCE.columns(["E_pot", "E_trans"], list(near))
    for name, (colour, label) in parts.items():
        style.curve(axes[0], data["t"], MILLI * data[name], label, colour)
    for panel, name in ((axes[1], "E_pot"), (axes[2], "E_trans")):
        colour, label = parts[name]
        panel.plot(near, MILLI * closer[name], color=colour)
        panel.set(ylabel=f"{label} (mJ)", xlim=MAGNIFIED)
    axes[0].axvspan(*MAGNIFIED, color="#eeeeee", zorder=0)
    axes[0].set(ylabel="energy (mJ)", ylim=(0, None))
    axes[0].legend(loc="upper right")
    style.moments(axes[:1], climb_marks())
    over_time(axes[:1])
    axes[0].set_xlabel("")
    axes[2].set_xlabel(f"{TIME}, magnified")
    return Words(
        caption="Figure 4 redrawn, with a magnification of the shaded interval. The parts add up "
        "to E; E falls monotonically and is mostly rotational at all times; E_pot rises only on "
        "average over a nutation. Related claims: FIG-01 to FIG-05, FIG-20, NUM-20 to NUM-25.",
        alt="Energy against time: E and E_rot fall in an S shape to less than half, E_pot "
        "nearly doubles, E_trans falls to zero. Two small panels magnify the oscillation of "
        "E_pot and E_trans in the shaded interval.",
    )


@style.figure("figure-5", [1.7, 1.2, 1.7])
def figure_5(axes: list[Axes]) -> Words:
    """The rates of E, E_trans and E_pot, and below the rate of E_rot."""
    total = (style.BLUE, r"$\dot E$")
    shown = (
        {"E_dot": total, "E_trans_dot": (style.GREEN, r"$\dot E_{trans}$")},
        {"E_pot_dot": (style.RED, r"$\dot E_{pot}$")},
        {"E_rot_dot": (style.PURPLE, r"$\dot E_{rot}$"), "E_dot": total},
    )
    data = course("E_dot", "E_trans_dot", "E_pot_dot", "E_rot_dot")
    for panel, curves in zip(axes, shown, strict=True):
        for name, (colour, label) in curves.items():
            style.curve(panel, data["t"], MILLI * data[name], label, colour)
        panel.set_ylabel("rate (mW)")
        panel.legend(loc="lower left")
    style.moments(axes, climb_marks())
    over_time(axes)
    return Words(
        caption="Figure 5 redrawn (first two panels), and the rate of the rotational energy, "
        "which the paper does not show (last panel). During the climb the rate of E_trans is as "
        "often positive as negative, and its shape differs from that of the rate of E. The rate "
        "of E_rot has a shape similar to that of E. Related claims: FIG-06 to FIG-08.",
        alt="Rates of energy against time: the rate of E is negative, with a deep trough in "
        "the climb; the rates of E_trans and E_pot oscillate about zero in the climb; in the last "
        "panel the rate of E_rot follows the rate of E.",
    )


# Instants in s; the next maximum of theta after each is shown.
INSTANTS = (3.2, 4.7, 5.3, 5.75, 6.1, 7.7)
COLOURS = (style.BLACK, style.BLUE, style.GREEN, style.PURPLE, style.RED, style.ORANGE)
ABOVE = 6e-3  # J of a well's walls drawn above the level of E~


@style.figure("deforming-potential", [3.2, 2.0], shared_time=False)
def deforming_potential(axes: list[Axes]) -> Words:
    """V over theta with E~ at six pairs of turning points; theta(t) and the minimum of V."""
    body = load_scene("reference").body.numbers(float)
    lambda_ = float(REFERENCE.thresholds.quantities["lambda"].value)
    angles = numpy.linspace(0.002, math.pi - 0.002, 1200)
    data = course("theta")
    turns = REFERENCE.turning_points
    lows, highs = (
        turns["t"][turns["name"] == name].to_numpy(dtype=float)
        for name in ("theta_min", "theta_max")
    )
    beyond, bottoms = _bottoms(lows, lambda_)
    (wells, motion) = axes
    for t, colour in zip(INSTANTS, COLOURS, strict=True):
        high = float(highs[highs > t][0])
        low = float(lows[lows > high][0])
        there = REFERENCE.columns(["theta", "D", "E_tilde"], [high, low])
        for i, dashes, filling in ((0, "-", colour), (1, "--", "white")):
            V = effective_potential(body, numpy.cos(angles), there["D"][i], lambda_, numpy)
            reached = there["E_tilde"][0] + ABOVE > V
            label = f"{high:.2f} s" if i == 0 else None
            wells.plot(angles[reached], MILLI * V[reached], dashes, color=colour, label=label)
            wells.plot(there["theta"][i], MILLI * there["E_tilde"][i], "o", color=colour,
                       markerfacecolor=filling, markersize=5)  # fmt: skip
    wells.set(xlabel=r"$\theta$ (rad)", ylabel=r"$V$, $\tilde E$ (mJ)",
              xticks=[0, math.pi / 2, math.pi])  # fmt: skip
    wells.set_xticklabels(["0", "π/2", "π"])
    wells.legend(loc="upper right", ncols=2)
    style.curve(motion, data["t"], data["theta"], r"$\theta(t)$", style.BLUE)
    motion.plot(lows, bottoms, ".", color=style.RED, markersize=3, label="minimum of $V$")
    angles_of(motion)
    motion.legend(loc="upper left")
    style.moments([motion], climb_marks())
    over_time([motion])
    return Words(
        caption="The Main Equation during the climb. Above: the effective potential V(cos theta, "
        "D(t), lambda) at six maxima of theta (solid) and at the minimum after each (dashed). Dots "
        "show E~ at the maximum (filled) and at the minimum (open). Below: theta(t), and the "
        "minimum of V, which moves from pole to pole as D falls. Between "
        f"{beyond[0]:.2f} and {beyond[-1]:.2f} s even the minima of theta lie beyond the minimum "
        "of V: theta turns back without a wall of V, because D and E~ change within each nutation. "
        "Related claims: the Proposition, the picture of a particle reflected between the walls of "
        "V, QUAL-01, FIG-10 to FIG-13, FIG-21.",
        alt="Above, six pairs of potential wells in the plane of theta and energy, moving from "
        "small theta and high energy to theta near pi and low energy, each with a filled "
        "dot on its right wall and an open dot further down. Below, theta against time with the "
        "minima of V as red dots, first within its oscillation, later below it.",
    )


def _bottoms(lows: Array, lambda_: float) -> tuple[list[float], list[float]]:
    """The minima of theta beyond the minimum of V, and the minimum of V at all minima of theta."""
    body = load_scene("reference").body.numbers(float)
    there = REFERENCE.columns(["theta", "D"], list(lows))
    bottoms = [minima(body, float(D), lambda_) for D in there["D"]]
    nearest = [
        min((abs(angle - theta), angle) for angle in some)[1] if some else math.nan
        for some, theta in zip(bottoms, there["theta"], strict=True)
    ]
    pairs = zip(lows, there["theta"], nearest, strict=True)
    return [float(t) for t, theta, angle in pairs if theta > angle], nearest


@style.figure("figure-6", [1.2, 1.2, 1.2])
def figure_6(axes: list[Axes]) -> Words:
    """The components of the torque along x, y and z of the moving frame."""
    names = {"tau_x": style.BLUE, "tau_y": style.ORANGE, "tau_z": style.GREEN}
    data = course(*names)
    shares = ", ".join(f"{100 * REFERENCE.share_below_zero(name):.1f} %" for name in names)
    for panel, (name, colour) in zip(axes, names.items(), strict=True):
        style.curve(panel, data["t"], MILLI * data[name], "", colour)
        panel.axhline(0, color=style.BLACK, linewidth=0.8)
        panel.set_ylabel(rf"$\tau_{name[-1]}$ (mN m)")
    style.moments(axes, climb_marks())
    over_time(axes)
    return Words(
        caption="Figure 6 redrawn. The components along x, y and z are negative for "
        f"{shares} of the time. Related claim: FIG-09.",
        alt="Three panels over 0 to 8 s: tau_x, tau_y and tau_z oscillate below zero in the "
        "climb; before it tau_x and tau_z oscillate about zero.",
    )


@style.figure("figure-7", [2.2, 1.2, 1.8], shared_time=False)
def figure_7(axes: list[Axes]) -> Words:
    """The curve (D, E~) with its limits, D over time, E and E~ over time."""
    data = course("D", "E_tilde", "E")
    limits = {name: one.value for name, one in REFERENCE.thresholds.quantities.items()}
    # the curve turns back and forth, so it must not be thinned
    axes[0].plot(MILLI * data["D"], MILLI * data["E_tilde"], color=style.BLUE, linewidth=0.6)
    for ends, mark, colour, label in (
        (limits, "o", style.BLACK, "limits for its λ"), (PRINTED, "X", style.RED, "printed")
    ):  # fmt: skip
        both = ([MILLI * float(ends[name + end]) for end in "01"] for name in "DE")
        axes[0].plot(*both, mark, color=colour, markersize=6, label=label)
    axes[0].set(xlabel="$D$ (g m²/s)", ylabel=r"$\tilde E$ (mJ)")
    axes[0].legend(loc="upper left")
    style.curve(axes[1], data["t"], MILLI * data["D"], "", style.BLUE)
    axes[1].set_ylabel("$D$ (g m²/s)")
    style.curve(axes[2], data["t"], MILLI * data["E_tilde"], r"$\tilde E$", style.BLUE)
    style.curve(axes[2], data["t"], MILLI * data["E"], "$E$", style.GREEN)
    axes[2].set_ylabel(r"$E$, $\tilde E$ (mJ)")
    axes[2].legend(loc="upper right")
    axes[1].sharex(axes[2])
    axes[1].tick_params(labelbottom=False)
    style.moments(axes[1:], climb_marks())
    over_time(axes[1:])
    axes[2].set_xlabel(TIME)
    return Words(
        caption="Figure 7 redrawn: the curve (D, E~), D(t), and E~(t) with E(t). The boundary "
        "values printed in section 2.3 (crosses) lie neither on this curve nor at its limits "
        "(dots). E~ exceeds E most in the middle of the climb, but not at every instant. Related "
        "claims: FIG-10 to FIG-13, FIG-21 and NUM-26 to NUM-30.",
        alt="Above, the curve of E~ against D runs from upper right to lower left with loops; "
        "two black dots lie at its ends, two red crosses away from it. Below, D falls from "
        "positive to negative, and E~ oscillates about and above E.",
    )


SCENE = "phi-dot-195"


@style.figure("figure-8", [1.2, 1.2, 1.6, 1.2, 1.2])
def figure_8(axes: list[Axes]) -> Words:
    """theta, theta_dot, phi_dot with psi_dot, nu_x with nu_y, and g_n."""
    data = course("theta", "theta_dot", "nu_x", "nu_y", "g_n", scene=SCENE)
    rate = course("phi_dot", "psi_dot", scene=SCENE)
    style.curve(axes[0], data["t"], data["theta"], "", style.BLUE)
    angles_of(axes[0])
    style.curve(axes[1], data["t"], data["theta_dot"], "", style.ORANGE)
    axes[1].set_ylabel(r"$\dot\theta$ (rad/s)")
    style.curve(axes[2], rate["t"], rate["psi_dot"], r"$\dot\psi$", style.GREY)
    style.curve(axes[2], rate["t"], rate["phi_dot"], r"$\dot\varphi$", style.BLUE)
    axes[2].set_yscale("symlog", linthresh=300, linscale=2)
    axes[2].set_yticks([-1e4, -1e3, -200, 0, 200, 1e3, 1e4])
    axes[2].set_yticklabels(["−10⁴", "−10³", "−200", "0", "200", "10³", "10⁴"])
    axes[2].set_ylabel(r"$\dot\varphi$, $\dot\psi$ (rad/s)")
    style.legend(axes[2])
    style.curve(axes[3], data["t"], data["nu_x"], r"$\nu_x$", style.BLUE)
    style.curve(axes[3], data["t"], data["nu_y"], r"$\nu_y$", style.GREEN)
    axes[3].set_ylabel(r"$\nu_x$, $\nu_y$ (m/s)")
    axes[3].legend(loc="upper right")
    style.curve(axes[4], data["t"], data["g_n"], "", style.RED)
    axes[4].set_ylabel("$g_n$ (N)")
    marks = {label: t for label, t in climb_marks(SCENE).items() if t > 0}
    style.moments(axes, marks)
    over_time(axes)
    return Words(
        caption="Figure 8 redrawn: phi_dot(0) = 195 rad/s, everything else as in the reference "
        "start. The solution is smooth until the end of the climb, where phi_dot reverses as in "
        "the reference solution. Related claims: FIG-15 and NUM-31 to NUM-34.",
        alt="Five panels over 0 to 8 s: theta rises smoothly from near 0 to pi; "
        "theta_dot, nu_x, nu_y and g_n change slowly with tiny ripples; phi_dot falls from 195 "
        "and has spikes at the end of the climb.",
    )


BEFORE, AFTER = 0.17, 0.17  # s around the passage: four and a half nutations each way
PASSAGE_EVERY = 2e-4  # Spacing in s near the passage of the pole.
MICRO = 1e-3  # Half the width of the magnification in rad.


@style.figure("axis-at-the-pole", [5.0], shared_time=False)
def axis_at_the_pole(axes: list[Axes]) -> Words:
    """kx, ky from shortly before to shortly after the initiation time, and the pole magnified."""
    turns = REFERENCE.events("theta_min")
    passage = float(turns["t"].iloc[int(turns["theta"].astype(float).argmin())])
    times = numpy.arange(passage - BEFORE, passage + AFTER, PASSAGE_EVERY)
    path = REFERENCE.columns(["kx", "ky"], list(times))
    near = numpy.linspace(passage - 3e-4, passage + 3e-4, 400)
    close = REFERENCE.columns(["kx", "ky"], list(near))
    lows = [float(t) for t in turns["t"] if abs(float(t) - passage) < BEFORE]
    dots = REFERENCE.columns(["kx", "ky", "phi_dot"], lows)
    (panel,) = axes
    for chosen, colour, label in (
        (times <= passage, style.GREY, "before"),
        (times >= passage, style.BLUE, "after"),
    ):
        panel.plot(path["kx"][chosen], path["ky"][chosen], color=colour, label=label)
    for sign, colour, label in (
        (-1, style.RED, r"nearest to the pole, $\dot\varphi<0$"),
        (1, style.GREEN, r"nearest to the pole, $\dot\varphi>0$"),
    ):
        those = dots["phi_dot"] * sign > 0
        panel.plot(dots["kx"][those], dots["ky"][those], "o", color=colour, markersize=4,
                   label=label)  # fmt: skip
    panel.plot(0, 0, "+", color=style.BLACK, markersize=14, label="pole")
    panel.set(xlabel="$k_x$ (rad)", ylabel="$k_y$ (rad)", aspect="equal")
    panel.legend(loc="upper left", bbox_to_anchor=(0, -0.13), ncols=2)
    inset = panel.inset_axes((0.36, 0.22, 0.27, 0.27))
    inset.plot(1e6 * close["kx"], 1e6 * close["ky"], color=style.PURPLE)
    inset.plot(0, 0, "+", color=style.BLACK, markersize=10)
    inset.set(xlim=(-1e6 * MICRO, 1e6 * MICRO), ylim=(-1e6 * MICRO, 1e6 * MICRO),
              aspect="equal", xticks=[-500, 0, 500], yticks=[-500, 0, 500])  # fmt: skip
    inset.set_title("magnified (µrad)", fontsize=8)
    inset.tick_params(labelsize=7)
    least = 1e6 * float(numpy.hypot(close["kx"], close["ky"]).min())
    return Words(
        caption="The initiation: the path of the symmetry axis on the unit sphere, seen from "
        f"above, from {BEFORE} s before to {AFTER} s after it passes the pole at {passage:.4f} s. "
        "Each loop before the passage leaves the pole outside, so phi_dot changes sign; each loop "
        "after the passage encloses the pole, so phi_dot stays positive. The smallest distance, "
        f"{least:.0f} µrad, and the height of the spike of phi_dot depend sensitively on the "
        "start. Related claims: QUAL-03, QUAL-04, QUAL-17, QUAL-18, QUAL-33, NUM-04.",
        alt="A spiral of growing loops near the origin. The points of the loops nearest to the "
        "pole move past the pole: red dots before the passage, with the pole outside the loops, "
        "green dots after the passage, with the pole inside. An inset magnifies the passage.",
    )


DRIFT_COLOURS = (style.RED, style.ORANGE, style.SKY, style.GREEN, style.BLUE)


@style.figure("jellett-drift", [3.4])
def jellett_drift(axes: list[Axes]) -> Words:
    """Relative drift of lambda over time in every precision, and the paper's 1e-6."""
    worst = {}
    panel = axes[0]
    panel.axhline(LAMBDA_KEPT, color=style.BLACK, linewidth=1, linestyle="--")
    panel.annotate("section 2.1: 1e−6", (0.1, LAMBDA_KEPT), xytext=(0, 4),
                   textcoords="offset points")  # fmt: skip
    for run, colour in zip(precision_runs(), DRIFT_COLOURS, strict=False):
        drift = run.drift["jellett"]
        worst[run.label] = max(drift)
        # log10 before the float: a fine drift may underflow, and zero has no logarithm
        sizes = numpy.array(
            [float(run.trajectory.precision.context.log10(x)) if x else numpy.nan
             for x in drift]
        )  # fmt: skip
        times = numpy.array([float(t) for t in run.trajectory.sample_times])
        panel.plot(times, 10.0**sizes, color=colour, linewidth=0.7)
        panel.annotate(run.label, (8, 10.0 ** numpy.nanmax(sizes)), xytext=(-2, 4),
                       textcoords="offset points", ha="right", color=colour)  # fmt: skip
    panel.set_yscale("log")
    panel.set_ylabel(r"$|\lambda(t)/\lambda(0)-1|$")
    over_time(axes)
    shown = ", ".join(f"{short(value)} in {label}" for label, value in worst.items())
    return Words(
        caption="The reference solution in every precision: relative drift of Jellett's "
        f"integral, the largest {shown}. The dashed line is the precision of order 1e-6 that the "
        "paper reports. Related claim: NUM-03.",
        alt="Drift of lambda against time on a logarithmic axis: a band for each precision, "
        "decades below the previous band, all far below the dashed line at 1e-6.",
    )
