"""``tt-precise scene``: write a new scene file, list the shipped scenes, summarise a scene."""

from __future__ import annotations

from dataclasses import fields
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tt_precise.commands.options import JSON, Group, emit
from tt_precise.mechanics.laws import law_named
from tt_precise.mechanics.quantities import described
from tt_precise.runtime.values import InputError, Json

if TYPE_CHECKING:
    from tt_precise.scene.scene import Scene

SCHEMA = "tt_precise.scene/1"
DIGITS = 20


@click.group("scene", cls=Group)
def command() -> None:
    """Scenes: bodies, starts and horizons, one TOML file each."""


@command.command("new")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--force", is_flag=True, help="Replace an existing file.")
def new(file: Path, force: bool) -> None:
    """Write a commented, valid scene to FILE (.toml)."""
    from tt_precise.runtime.files import atomic_write
    from tt_precise.scene.entries import new_file

    if file.suffix != ".toml":
        raise InputError(f"scene new: got {file}, expected a name that ends in .toml")
    if file.exists() and not force:
        raise InputError(f"scene new: {file} exists, expected a new name, or --force")
    if not file.parent.is_dir():
        raise InputError(f"scene new: got {file}, expected a file in a folder that exists")
    atomic_write(file, new_file(file.stem))
    click.echo(f"{file}: change it, then `tt-precise scene show {file}`")


@command.command("list")
@JSON
def list_command(as_json: bool) -> None:
    """List the shipped scenes."""
    from tt_precise.scene.scene import load_scene, shipped

    scenes = [load_scene(name) for name in shipped()]
    content = [{"name": scene.name, "model": scene.model, "title": scene.title} for scene in scenes]
    emit(
        as_json,
        {"schema": "tt_precise.scene.list/1", "scenes": content},
        (
            f"{scene.name:<22} {scene.model:<8} {float(scene.until):>6g} s  {scene.title}"
            for scene in scenes
        ),
    )


@command.command("show", short_help="Show derived numbers and warnings of a scene.")
@click.argument("scene")
@JSON
def show(scene: str, as_json: bool) -> None:
    """Show derived numbers and warnings of SCENE, a shipped name or a TOML file.

    The numbers are gamma, lambda over its thresholds, the verdict of Theorem 1.1 on the start, and
    the static balance. Nothing is integrated; for the motion of the axis use `tt-precise run`.
    """
    from tt_precise.scene.scene import load_scene

    content = summary(load_scene(scene))
    emit(as_json, content, lines(content))


def summary(scene: Scene) -> dict[str, Json]:
    """Return derived numbers and warnings of a scene, for JSON."""
    from tt_precise.exact.thresholds import thresholds

    known = thresholds(scene, DIGITS)
    values = {name: quantity.value for name, quantity in known.quantities.items()}

    def over(name: str) -> float | None:
        below = values.get(name)
        return None if below is None else float(values["lambda"] / below)

    body = scene.body
    shown = {name: str(value) for name, value in body.in_file_units().items()}
    if body.spring:
        shown |= {"law": body.law, "spring": body.spring}
    start = {field.name: str(getattr(scene.start, field.name)) for field in fields(scene.start)}
    ratios = {name: over(name) for name in ("lambda_thres", "lambda_up")}
    return {
        "schema": SCHEMA,
        "scene": scene.name,
        "title": scene.title,
        "source": scene.source,
        "model": scene.model,
        "friction": body.law if scene.model == "gliding" and body.mu else "none",
        "flies": scene.flies,
        "body": shown,
        "start": start,
        "given": {name: str(value) for name, value in scene.derived_from.items()},
        "at_rest": scene.at_rest,
        "until": str(scene.until),
        "gamma": float(body.gamma),
        "lambda": float(values["lambda"]),
        "lambda_over": ratios,
        "theorem": known.theorem.as_dict(),
        "static_balance": balance(scene),
        "warnings": warnings(scene, ratios),
    }


def balance(scene: Scene) -> str:
    """Return the words for the static balance: the place of a top without spin."""
    if scene.model == "flight":
        return "none: nothing carries the top"
    height = float(scene.body.alpha * scene.body.R) * 1000
    return (
        f"rests at theta = 0, with the centre of mass {height:.3g} mm below the centre of the "
        "sphere; theta = pi is its unstable balance"
    )


def warnings(scene: Scene, ratios: dict[str, float | None]) -> list[str]:
    """Return a warning for each unusual property."""
    from tt_precise.integration.precision import precision_named
    from tt_precise.scene.initial_state import InitialState
    from tt_precise.scene.start import LiftedStart

    unusual = []
    body, start = scene.body, scene.start
    unit = body.m * body.R**2
    if max(body.I1, body.I3) > unit:
        unusual.append("a moment of inertia is above m R^2, impossible for mass inside the sphere")
    if scene.model == "flight":
        return unusual
    if not 1 - body.alpha < body.gamma < 1 + body.alpha:
        never = "inverted spin is never" if body.gamma > 1 else "upright spin is always"
        unusual.append(
            f"gamma = {float(body.gamma):.4g} lies outside 1 - alpha to 1 + alpha "
            f"({float(1 - body.alpha):.4g} to {float(1 + body.alpha):.4g}): the {never} stable"
        )
    elif any(ratio is not None and abs(abs(ratio) - 1) < 0.05 for ratio in ratios.values()):
        unusual.append("lambda is within 5 % of a threshold: the motion may take very long")
    if start.theta.at_pole:
        unusual.append(
            "the axis is vertical: Euler angles are undefined, and an exact top stays vertical"
        )
    if scene.model != "rolling" and body.mu == 0:
        unusual.append("no friction: nothing drives the top to the inverted spin")
    unusual += [scene.rest_warning] if scene.rest_warning else []
    if isinstance(start, LiftedStart):
        return unusual  # there need be no contact
    double = precision_named("double")
    motion = InitialState.of(scene, double.arithmetic).motion(double.context)
    force = motion.force[2]
    if force <= 0:
        unusual.append(f"g_n = {float(force):.3g} m g at t = 0: the top is not on the table")
    elif force < 0.3:
        unusual.append(f"g_n is only {float(force):.3g} m g at t = 0: contact may be lost soon")
    return unusual


def lines(content: dict[str, Json]) -> list[str]:
    """Return the text of ``scene show``."""
    body = {name: _short(value) for name, value in content["body"].items()}
    from tt_precise.exact.thresholds import IN_WORDS

    theorem = content["theorem"]
    ratios = "   ".join(
        f"lambda/{name} = {value:.6g}" if value is not None else f"{name} does not exist"
        for name, value in content["lambda_over"].items()
    )
    given = ", ".join(f"{name} = {_short(value)}" for name, value in content["given"].items())
    return [
        f"{content['scene']}: {content['title']}",
        f"  model      {content['model']}, {_forces(content, body)}, until {content['until']} s",
        f"  body       m {body['m']} kg, R {body['R']} m, alpha {body['alpha']}, "
        f"I1 {body['I1']} and I3 {body['I3']} (m R^2), g {body['g']} m/s^2",
        "  start      "
        + ", ".join(
            f"{name} {_short(value)} {described(name).unit}"
            for name, value in content["start"].items()
        ),
        *([f"  given      {given}"] if given else []),
        *([f"  at rest    {content['at_rest']}"] if content["at_rest"] else []),
        f"  gamma      {content['gamma']:.6g}",
        f"  lambda     {content['lambda']:.10g} kg m^3/s; {ratios}",
        f"  theorem    {IN_WORDS[theorem['verdict']]}: {theorem['reason']}",
        f"  balance    {content['static_balance']}",
        *(f"  WARNING    {warning}" for warning in content["warnings"]),
    ]


def _forces(content: dict[str, Json], body: dict[str, str]) -> str:
    """Describe the forces on the top, without its weight."""
    if content["model"] == "flight":
        return "nothing touches the top"
    if content["model"] == "rolling":
        return "with the force that keeps it rolling"
    friction = content["friction"]
    forces = "without friction"
    if friction != "none":
        units = {
            parameter.name: "" if parameter.unit == "1" else f" {parameter.unit}"
            for parameter in law_named(friction).parameters
        }
        listed = (f"{name} {body[name]}{unit}" for name, unit in units.items())
        forces = f"{friction} friction {', '.join(listed)}"
    if "spring" in body:
        power = "" if body["spring"] == "linear" else "^(3/2)"
        damping = "N s/m" if body["spring"] == "linear" else "s/m"
        forces += (
            f", an elastic table ({body['spring']}, stiffness {body['stiffness']} N/m{power}, "
            f"damping {body['damping']} {damping})"
        )
    return forces + (", flying where contact is lost" if content["flies"] else "")


def _short(value: str) -> str:
    """A fraction as a decimal where that is short and exact."""
    try:
        number = Fraction(value)
    except ValueError:  # pi - 1e-9
        return value
    decimal = f"{float(number):.12g}"
    return decimal if Fraction(decimal) == number or len(value) > 24 else value
