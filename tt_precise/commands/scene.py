"""``tt-precise scene``: write a new scene file, list the shipped scenes, summarise a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import click

from tt_precise.commands.options import JSON, emit
from tt_precise.runtime.values import InputError, Json
from tt_precise.scene.scene import Scene, load_scene, shipped

SCHEMA = "tt_precise.scene/1"
DIGITS = 20  # digits of lambda and its thresholds
NEAR = 0.05  # relative distance from a threshold that deserves a warning
LIGHT = 0.3  # normal force in m g below which contact may be lost soon
FORCES = {"flight": "nothing touches the top", "rolling": "a force that keeps it rolling"}


@click.group("scene")
def scene_command() -> None:
    """Scenes: bodies, starts and horizons, one TOML file each."""


@scene_command.command("new")
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
    atomic_write(file, new_file(file.stem))
    click.echo(f"{file}: change it, then `tt-precise scene show {file}`")


@scene_command.command("list")
@JSON
def list_command(as_json: bool) -> None:
    """List the shipped scenes."""
    scenes = [load_scene(name) for name in shipped()]
    content = [{"name": scene.name, "model": scene.model, "title": scene.title} for scene in scenes]
    lines = [f"{s.name:<22} {s.model:<8} {float(s.until):>6g} s  {s.title}" for s in scenes]
    emit(as_json, {"schema": "tt_precise.scene.list/1", "scenes": content}, lines)


@scene_command.command("show")
@click.argument("scene")
@JSON
def show(scene: str, as_json: bool) -> None:
    """Show derived numbers and warnings of SCENE, a shipped name or a TOML file.

    The numbers are gamma, lambda over its thresholds and the verdict of Theorem 1.1 on the start.
    Nothing is integrated; for the motion of the axis use `tt-precise run`.
    """
    loaded = load_scene(scene)
    content = summary(loaded)
    emit(as_json, content, lines(loaded, content))


def summary(scene: Scene) -> dict[str, Json]:
    """Return derived numbers and warnings of a scene, for JSON."""
    from tt_precise.exact.thresholds import thresholds

    results, body = thresholds(scene, DIGITS), scene.body
    values = {name: quantity.value for name, quantity in results.quantities.items()}
    ratios = {
        name: None if values.get(name) is None else float(values["lambda"] / values[name])
        for name in ("lambda_thres", "lambda_up")
    }
    return {
        "schema": SCHEMA, "scene": scene.name, "title": scene.title, "source": scene.source,
        "model": scene.model, "spring": body.spring, "flies": scene.flies,
        "friction": body.law if scene.model == "gliding" and body.mu else "none",
        "body": {name: str(value) for name, value in body.in_file_units().items()},
        "start": {name: str(value) for name, value in scene.start.components().items()},
        "given": {name: str(value) for name, value in scene.derived_from.items()},
        "at_rest": scene.at_rest, "until": str(scene.until),
        "gamma": float(body.gamma), "lambda": float(values["lambda"]), "lambda_over": ratios,
        "theorem": results.theorem.as_dict(), "warnings": list(warnings(scene, ratios)),
    }  # fmt: skip


def warnings(scene: Scene, ratios: Mapping[str, float | None]) -> Iterator[str]:
    """Yield a warning for each unusual property."""
    from tt_precise.integration.precision import precision_named
    from tt_precise.scene.scene import InitialState

    body, low, high = scene.body, 1 - scene.body.alpha, 1 + scene.body.alpha
    if max(body.I1, body.I3) > body.m * body.R**2:
        yield "a moment of inertia is above m R^2, impossible for mass inside the sphere"
    if scene.model == "flight":
        return
    if not low < body.gamma < high:
        never = "inverted spin is never" if body.gamma > 1 else "upright spin is always"
        yield (
            f"gamma = {float(body.gamma):.4g} lies outside 1 - alpha to 1 + alpha "
            f"({float(low):.4g} to {float(high):.4g}): the {never} stable"
        )
    elif any(ratio is not None and abs(abs(ratio) - 1) < NEAR for ratio in ratios.values()):
        yield "lambda is within 5 % of a threshold: the motion may take very long"
    if scene.start.theta.at_pole:
        yield "the axis is vertical: Euler angles are undefined, and an exact top stays vertical"
    if scene.model != "rolling" and body.mu == 0:
        yield "no friction: nothing drives the top to the inverted spin"
    if scene.rest_warning:
        yield scene.rest_warning
    if scene.lifts:
        return  # there need be no contact
    double = precision_named("double")
    force = InitialState.of(scene, double.arithmetic).motion(double.context).force[2]
    if force < LIGHT:
        off = "the top is not on the table" if force <= 0 else "contact may be lost soon"
        yield f"g_n is only {float(force):.3g} m g at t = 0: {off}"


def lines(scene: Scene, content: dict[str, Json]) -> Iterator[str]:
    """Yield the text of ``scene show``."""
    from tt_precise.exact.thresholds import IN_WORDS

    friction, spring, theorem = content["friction"], content["spring"], content["theorem"]
    force = "no friction" if friction == "none" else f"{friction} friction"
    force = FORCES.get(scene.model, force) + (f", {spring} elastic table" if spring else "")
    flies = ", flying where contact is lost" if scene.flies else ""
    ratios = "   ".join(
        f"lambda/{name} = {value:.6g}" if value is not None else f"{name} does not exist"
        for name, value in content["lambda_over"].items()
    )
    yield f"{scene.name}: {scene.title}"
    yield f"  model      {scene.model}, {force}{flies}, until {scene.until} s"
    for table, texts in (("body", scene.body.texts()), ("start", scene.start.texts())):
        if friction == "none":
            texts.pop("mu", None)
        yield f"  {table:<10} {', '.join(f'{name} {text}' for name, text in texts.items())}"
    if entries := content["given"]:
        yield f"  given      {', '.join(f'{name} = {value}' for name, value in entries.items())}"
    if scene.at_rest:
        yield f"  at rest    {scene.at_rest}"
    yield f"  gamma      {content['gamma']:.6g}"
    yield f"  lambda     {content['lambda']:.10g} kg m^3/s; {ratios}"
    yield f"  theorem    {IN_WORDS[theorem['verdict']]}: {theorem['reason']}"
    yield from (f"  WARNING    {warning}" for warning in content["warnings"])
