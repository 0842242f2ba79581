"""The JSON documents of golden tables: ``manifest.json`` and ``proof.json``."""

from __future__ import annotations

from typing import Annotated

from tt_precise.golden.table import FORMAT
from tt_precise.runtime.records import UNSET, Record, Unset, means

Sha256 = Annotated[str, means("SHA-256 of the content")]
SceneName = Annotated[str, means("name of the scene")]
Digits = Annotated[int | None, means("fewest significant digits; null if all are 0")]
Bits = Annotated[int, means("working precision in bits")]
Status = Annotated[str, means("how the trajectory ended")]
Versions = Annotated[dict[str, str], means("versions of the packages used")]
Agreement = float | str  # "equal" where nothing differs
FILES = {"trajectory": "trajectory.csv", "events": "events.csv"}


class ColumnClaims(Record, frozen=True, kw_only=True):
    """The meaning of a column of a golden table, and its claims."""

    unit: Annotated[str, means("SI unit")]
    meaning: Annotated[str, means("meaning, with the place in the paper")]
    digits: Digits
    scale: Annotated[str | Unset, means("largest absolute value of the column")] = UNSET
    near_zero: Annotated[int | Unset, means("entries near a zero, see rule")] = UNSET
    undefined: Annotated[int | Unset, means("entries without a value")] = UNSET
    agreement: Annotated[dict[str, Agreement] | Unset, means("digits shared with other runs")] = (
        UNSET
    )


class Hashed(Record, frozen=True):
    """A file."""

    sha256: Sha256


class TableClaims(Record, frozen=True, kw_only=True):
    """A golden table."""

    rows: Annotated[int, means("number of rows")]
    sha256: Sha256
    columns: Annotated[dict[str, ColumnClaims], means("the columns")]
    counts: Annotated[dict[str, int] | Unset, means("how often each event occurs")] = UNSET


class Files(Record, frozen=True, rename={**FILES, "scene": "scene.toml", "proof": "proof.json"}):
    """The files of a scene, with their hashes."""

    scene: Annotated[Hashed, means("the scene")]
    trajectory: Annotated[TableClaims, means("samples")]
    events: Annotated[TableClaims, means("events")]
    proof: Annotated[Hashed | Unset, means("statements proved about the tables")] = UNSET


class Computation(Record, frozen=True, kw_only=True):
    """A run."""

    name: Annotated[str, means("name")]
    formulation: Annotated[str, means("coordinates: newton or euler")]
    bits: Bits
    status: Status
    rows: Annotated[int, means("number of rows")]
    order: Annotated[int | Unset, means("order of the Taylor method")] = UNSET
    tolerance: Annotated[str | Unset, means("relative tolerance")] = UNSET


class Evidence(Record, frozen=True, kw_only=True):
    """The evidence for the digits."""

    agreement: Annotated[Agreement, means("digits in which the runs agree")]
    runs: Annotated[list[Computation], means("the computations")]
    constant_over_printed_rows: Annotated[
        dict[str, Agreement], means("digits to which each integral is constant")
    ]
    events: Annotated[str, means("agreement of the runs on the events")]


class Manifest(Record, frozen=True, kw_only=True, tag_field="schema", tag=FORMAT):
    """`manifest.json` of a scene's golden data."""

    scene: SceneName
    title: Annotated[str, means("title of the scene")]
    source: Annotated[str, means("where the numbers come from")]
    model: Annotated[str, means("gliding, rolling or flight")]
    status: Status
    t_end: Annotated[str, means("end in s")]
    digits: Annotated[int, means("fewest significant digits of any column")]
    files: Annotated[Files, means("each file")]
    event_meanings: Annotated[dict[str, str], means("event to the function whose zero it is")]
    rule: Annotated[str, means("how digits are counted")]
    evidence: Annotated[Evidence, means("evidence for the digits")]
    versions: Versions


class Ball(Record, frozen=True):
    """An interval that contains the exact number."""

    middle: Annotated[str, means("middle of the interval")]
    radius: Annotated[str, means("radius of the interval")]


class ContactForce(Record, frozen=True, kw_only=True):
    """The proved statement about the contact force."""

    g_n_positive: Annotated[bool | str, means("whether g_n > 0 is proved")]
    g_n_at_least_mg: Annotated[str | Unset | None, means("lower bound of g_n in units of m g")] = (
        UNSET
    )
    energy_never_grows: Annotated[bool | Unset, means("whether it is proved")] = UNSET
    lost_at_s: Annotated[Ball | Unset, means("time of the loss of contact in s")] = UNSET


class Climb(Record, frozen=True):
    """The climb in one definition; null where there is none up to the horizon."""

    t_init: Annotated[Ball | None, means("initiation time in s")]
    t_end: Annotated[Ball | None, means("ending time in s")]


class Inversion(Record, frozen=True, kw_only=True):
    """Times of the climb, or the reason why nothing is proved about them."""

    failure: Annotated[str | Unset, means("reason why nothing is proved")] = UNSET
    equator: Annotated[
        Ball | Unset | None, means("first time at which theta crosses pi/2, in s")
    ] = UNSET
    A: Annotated[Climb | Unset, means("signed perigee")] = UNSET
    B: Annotated[Climb | Unset, means("L.k = L.z and L.k = -L.z")] = UNSET
    C: Annotated[Climb | Unset, means("change of sign of phi_dot")] = UNSET


class Neighbourhood(Record, frozen=True, kw_only=True):
    """A neighbourhood of a vertical spin that the solution is proved never to leave."""

    theta_tends_to: Annotated[str, means("limit of theta: 0 or pi")]
    since_s: Annotated[str, means("time in s from which the solution is in the neighbourhood")]
    g_n_at_least_mg: Annotated[str, means("lower bound of g_n from then on, in units of m g")]
    sin_theta_at_most: Annotated[str, means("bound of sin theta from then on")]
    limits: Annotated[dict[str, Ball], means("limits of the quantities, in SI")]


class Proof(Record, frozen=True, tag_field="schema", tag="tt_precise.proof/5", rename=FILES):
    """`proof.json`: what is proved about a scene's golden data."""

    scene: SceneName
    scene_sha256: Annotated[str, means("SHA-256 of the scene's content")]
    trajectory: Annotated[Hashed, means("the table of samples that was proved")]
    events: Annotated[Hashed, means("the table of events that was proved")]
    theorem: Annotated[str, means("place of the theorem")]
    bits: Bits
    steps: Annotated[int, means("verified steps")]
    entries: Annotated[int, means("compared printed numbers")]
    rounded: Annotated[int, means("printed numbers proved to be correctly rounded: all")]
    proved_events: Annotated[
        dict[str, int],
        means("number of occurrences of each event; each exists, and there is no other"),
    ]
    contact: Annotated[ContactForce, means("the proved statement about the contact force")]
    inversion: Annotated[Inversion, means("times of the climb")]
    forever: Annotated[
        dict[str, Neighbourhood | str],
        means("all later times: the first neighbourhood (held), the last (at_the_end); or failure"),
    ]
    conserved_within: Annotated[dict[str, str], means("bounds of the change of integrals")]
    versions: Versions


PROOF_SCHEMA = str(Proof.__struct_config__.tag)
