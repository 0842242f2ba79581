"""``tt-precise check``: conservation checks on a trajectory from any program."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tt_precise.commands import options
from tt_precise.runtime.terminal import one_line, progress_bar
from tt_precise.runtime.values import InputError

if TYPE_CHECKING:
    from tt_precise.check.result import Result


@click.command("check", epilog=options.DIGITS)
@click.argument("trajectory")
@click.option("--scene", required=True, help="A shipped name or a TOML file.")
@click.option("--columns", multiple=True, help="Renames, as theirs=ours[,theirs=ours].")
@click.option(
    "--from",
    "engine",
    metavar="ENGINE",
    help="An engine's own state (.npz, .csv): mujoco, drake, bullet ...; see `columns`.",
)
@click.option(
    "--limit",
    "limits",
    multiple=True,
    help="NAME=VALUE for one check, or VALUE for all relative drifts (1e-6).",
)
@click.option("--until", type=options.FINITE, help="Leave out rows after this time (s).")
@click.option("--digits", type=options.FINITE, help="Fail if fewer digits of the solution agree.")
@click.option(
    "--friction",
    type=click.Choice(["scene", "other"]),
    default="scene",
    show_default=True,
    help="other: the contact force is not the scene's (Coulomb, elastic).",
)
@click.option(
    "--start",
    type=click.Choice(["scene", "other"]),
    default="scene",
    show_default=True,
    help="other: the motion has another start than the scene's.",
)
@click.option("--allow", multiple=True, metavar="NAME", help="Accept this check where it is open.")
@click.option(
    "--world",
    type=click.Choice(["z-up", "y-up", "left-handed-y-up", "left-handed-z-up"]),
    default="z-up",
    show_default=True,
    help="Vertical and handedness of rigid-body columns.",
)
@click.option(
    "--axis",
    type=click.Choice(["z", "y", "x"]),
    default="z",
    show_default=True,
    help="The body's symmetry axis, towards the sphere's centre.",
)
@click.option(
    "--folder",
    type=click.Path(file_okay=False),
    help="Folder of golden data; by default the package's, and ./golden.",
)
@options.JSON
@click.option("--junit", type=click.Path(dir_okay=False), help="Write JUnit XML.")
@click.option("--markdown", type=click.Path(dir_okay=False), help="Write a Markdown table.")
@click.option(
    "--plot", type=click.Path(dir_okay=False), help="Draw the residuals (.svg, .png, .pdf)."
)
@click.option("--verbose", is_flag=True, help="Print the table of all checks.")
def command(
    trajectory: str,
    scene: str,
    columns: tuple[str, ...],
    engine: str | None,
    limits: tuple[str, ...],
    until: float | None,
    digits: float | None,
    friction: str,
    start: str,
    allow: tuple[str, ...],
    world: str,
    axis: str,
    folder: str | None,
    as_json: bool,
    junit: str | None,
    markdown: str | None,
    plot: str | None,
    verbose: bool,
) -> int:
    """Check the conservation laws on TRAJECTORY.

    TRAJECTORY is a file .csv (or gzipped), .parquet, .arrow, .h5, .hdf5, .mat (7.3), .json, .jsonl
    or .npz, or - for standard input.

    Columns (SI; those in brackets if known): t and theta theta_dot phi_dot omega_3 (or psi_dot)
    [nu_x nu_y phi psi], or kx ky kz Lx Ly Lz [vx vy], or qw qx qy qz wx wy wz [vcx vcy vcz], and
    [x y z]. `tt-precise columns` lists their meanings and frames.

    Exit status 0 if every deciding check was made and none failed. These are, with the scene's
    friction, the equations, or the distance from the solution to three digits; with --friction
    other, attitude and momentum; and always the start and every known column. Exit status 1 if a
    check failed, or if the verdict is incomplete.

    Checks: time, finite, jellett, energy, energy_balance, equations, kinematics, contact_momentum,
    normal_force, friction_power, contact, contact_velocity, fall, axis_norm, quaternion_norm,
    start, agreement, golden (the solution), and the integrals of the scene's model. Input that
    cannot be used (exit status 2) is a failed check "input" in --json, --junit and --markdown.
    """
    from tt_precise.check.checks import read_limits
    from tt_precise.check.columns import renaming
    from tt_precise.check.result import unusable
    from tt_precise.check.run import examine

    if plot is not None:
        from tt_precise.runtime.plotting import require_format

        require_format(plot)
    try:
        with progress_bar(f"checking {trajectory}") as progress:
            result = examine(
                trajectory,
                scene,
                limits=read_limits(limits),
                until=until,
                digits=digits,
                friction=friction,
                start=start,
                allow=allow,
                engine=engine,
                world=world,
                axis=axis,
                columns=renaming(columns),
                folder=folder,
                progress=progress,
            )
    except InputError as error:
        refused = unusable(trajectory, scene, one_line(str(error)))
        _write(refused, junit, markdown, None)
        options.emit(as_json, refused.as_dict(), ())
        raise
    _write(result, junit, markdown, plot)
    text = result.table() if verbose else str(result)
    options.emit(as_json, result.as_dict(), text.splitlines())
    return 0 if result.passed else 1


def _write(result: Result, junit: str | None, markdown: str | None, plot: str | None) -> None:
    for path, text in ((junit, result.junit), (markdown, result.markdown)):
        if path is not None:
            from tt_precise.runtime.files import atomic_write

            atomic_write(path, text())
    if plot is not None:
        result.plot(plot)
