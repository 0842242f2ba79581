"""Pictures of a trajectory: angle, energies, normal force and drift over time, or any columns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from tt_precise.integration.reading import DIGITS, ERROR
from tt_precise.runtime import plotting
from tt_precise.runtime.notebook import table

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Trajectory: TypeAlias = Any  # its module imports this one

WIDTH, PANEL = 7.0, 1.55  # inches
# drawn for an exact zero, which a logarithmic axis has no place for: a part of eps
EXACT, TINIEST = 2.0**-8, 1e-300
ENERGIES = ("E", "E_rot", "E_trans", "E_pot")
SHORT_UNITS = {"kg m^2/s^2": "J", "kg m/s^2": "N", "kg m^2/s^3": "W"}
LABELS = {
    "theta": r"$\theta$", "theta_dot": r"$\dot\theta$", "phi_dot": r"$\dot\varphi$",
    "omega_3": r"$\omega_3$", "nu_x": r"$\nu_x$", "nu_y": r"$\nu_y$", "g_n": r"$g_n$",
    "E": r"$E$", "E_rot": r"$E_{rot}$", "E_trans": r"$E_{trans}$", "E_pot": r"$E_{pot}$",
    "lambda": r"$\lambda$", "psi_dot": r"$\dot\psi$", "E_tilde": r"$\tilde E$",
}  # fmt: skip


def notebook_table(trajectory: Trajectory) -> str:
    """How it ended, in HTML; nothing that would cost another integration."""
    return table(
        f"Trajectory of {trajectory.scene.name}",
        [
            ("status", trajectory.status),
            ("t_end", f"{trajectory.t_end} s"),
            ("precision", f"{trajectory.precision.name}, {trajectory.precision.bits} bits"),
            ("formulation", trajectory.formulation),
            ("steps", trajectory.steps),
            *((name, text or "undefined") for name, text in trajectory.state.as_text().items()),
            *((f"event {name}", f"{n} times") for name, n in trajectory.event_counts.most_common()),
        ],
    )


def figure(trajectory: Trajectory, names: tuple[str, ...] = ()) -> Figure:
    """A matplotlib ``Figure`` with a panel for each column, or the overview if none is named."""
    panels: tuple[tuple[str, ...], ...] = tuple((name,) for name in names)
    if not names:
        panels = (("theta",), ENERGIES, ("g_n",))
    wanted = [name for panel in panels for name in panel]
    samples = trajectory.frame(*dict.fromkeys(wanted), numbers="float")
    count = len(panels) + (not names)
    with plotting.styled():
        drawn = plotting.new_figure(WIDTH, PANEL * count + 0.5)
        axes = list(drawn.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
        for panel, place in zip(panels, axes, strict=False):
            _panel(place, trajectory, samples, panel)
        if not names:
            _drift(axes[-1], trajectory)
        _events(axes[0], trajectory)
        axes[-1].set_xlabel("t / s")
        note = "" if trajectory.status == "complete" else f" ({trajectory.status})"
        axes[0].set_title(f"{trajectory.scene.name}{note}")
        drawn.align_ylabels(axes)
    return drawn


def _panel(
    axes: Axes, trajectory: Trajectory, samples: pandas.DataFrame, names: tuple[str, ...]
) -> None:
    from tt_precise.mechanics.columns import described

    for name in names:
        at = plotting.thinned(samples["t"].to_numpy(), samples[name].to_numpy())
        axes.plot(samples["t"].to_numpy()[at], samples[name].to_numpy()[at], label=_label(name))
    first = names[0].removeprefix(ERROR)
    unit = "1" if first == DIGITS else described(first).unit
    unit = SHORT_UNITS.get(unit, unit)
    if names[0].startswith(ERROR):
        axes.set_yscale("log")
    axes.set_ylabel((f"{_label(names[0])} / " if len(names) == 1 else "") + unit)
    if len(names) > 1:
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    if names == ("g_n",):
        axes.axhline(0, color=plotting.GREY, linewidth=0.8)


def _drift(axes: Axes, trajectory: Trajectory) -> None:
    """The relative drift of everything that the scene conserves, on a logarithmic axis."""
    import numpy

    times = [float(t) for t in trajectory.sample_times]
    floor = max(float(trajectory.precision.eps) * EXACT, TINIEST)
    for name, values in trajectory.drift_over_time().items():
        floats = numpy.maximum([float(value) for value in values], floor)
        axes.semilogy(times, floats, label=name.replace("_", " "))
    axes.set_ylabel("relative drift")
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))


def _events(axes: Axes, trajectory: Trajectory) -> None:
    """A tick for each recorded event, one row a name, below the first panel's curve."""
    events = trajectory.events
    names = list(events["name"].unique())
    for row, name in enumerate(names):
        rows = events[events["name"] == name]
        axes.plot(
            rows["t"].astype(float), [0.02 + 0.05 * row] * len(rows), "|", markersize=5,
            color=plotting.CYCLE[(row + 1) % len(plotting.CYCLE)], label=f"{len(rows)} x {name}",
            transform=axes.get_xaxis_transform(),
        )  # fmt: skip
    if names:
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))


def _label(name: str) -> str:
    if name.startswith(ERROR):
        return f"error of {_label(name.removeprefix(ERROR))}"
    return LABELS.get(name, name)
