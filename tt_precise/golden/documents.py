"""The JSON documents beside golden tables: ``manifest.json`` and ``proof.json``."""

from __future__ import annotations

from typing import Annotated

from msgspec import field

from tt_precise.runtime.records import UNSET, Meta, Record, Unset

Sha256 = Annotated[str, Meta(description="SHA-256 of the content")]
SceneName = Annotated[str, Meta(description="name of the scene")]
Digits = Annotated[int | None, Meta(description="fewest significant digits; null if all are 0")]
Bits = Annotated[int, Meta(description="working precision in bits")]
Status = Annotated[str, Meta(description="how the trajectory ended")]
Versions = Annotated[dict[str, str], Meta(description="versions of the packages used")]
Agreement = float | str  # "equal" where nothing differs


class ColumnClaims(Record, frozen=True, kw_only=True):
    """What a column of a golden table is, and what is claimed of it."""

    unit: Annotated[str, Meta(description="SI unit")]
    meaning: Annotated[str, Meta(description="what it is, with its place in the paper")]
    digits: Digits
    scale: Annotated[str | Unset, Meta(description="largest absolute value of the column")] = UNSET
    near_zero: Annotated[int | Unset, Meta(description="entries near a zero, see rule")] = UNSET
    undefined: Annotated[int | Unset, Meta(description="entries without a value")] = UNSET
    agreement: Annotated[
        dict[str, Agreement] | Unset, Meta(description="digits in which each other run agrees")
    ] = UNSET


class Hashed(Record, frozen=True):
    """A file."""

    sha256: Sha256


class TableClaims(Record, frozen=True, kw_only=True):
    """A golden table."""

    rows: Annotated[int, Meta(description="how many rows")]
    sha256: Sha256
    columns: Annotated[dict[str, ColumnClaims], Meta(description="the columns")]
    counts: Annotated[dict[str, int] | Unset, Meta(description="how often each event occurs")] = (
        UNSET
    )


class Files(Record, frozen=True, kw_only=True):
    """The files of a scene."""

    scene: Annotated[Hashed, Meta(description="the scene")] = field(name="scene.toml")
    trajectory: Annotated[TableClaims, Meta(description="samples")] = field(name="trajectory.csv")
    events: Annotated[TableClaims, Meta(description="events")] = field(name="events.csv")


class Computation(Record, frozen=True, kw_only=True):
    """A run, or a closed form."""

    name: Annotated[str, Meta(description="name")]
    formulation: Annotated[str, Meta(description="coordinates: newton or euler")]
    bits: Bits
    status: Status
    rows: Annotated[int, Meta(description="how many rows")]
    order: Annotated[int | Unset, Meta(description="order of the Taylor method")] = UNSET
    tolerance: Annotated[str | Unset, Meta(description="relative tolerance")] = UNSET


class Evidence(Record, frozen=True, kw_only=True):
    """What the digits rest on."""

    agreement: Annotated[Agreement, Meta(description="digits in which the runs agree")]
    runs: Annotated[list[Computation], Meta(description="the computations")]
    constant_over_printed_rows: Annotated[
        dict[str, Agreement],
        Meta(description="digits to which conserved quantities are constant over the rows"),
    ]
    events: Annotated[str, Meta(description="what the runs have in common of the events")]


class Change(Record, frozen=True):
    """Published digits that changed."""

    reason: Annotated[str, Meta(description="why")]
    first_change: Annotated[str, Meta(description="the first digit that changed")]


class Manifest(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.golden/2"):
    """`manifest.json` of a scene's golden data."""

    scene: SceneName
    title: Annotated[str, Meta(description="title of the scene")]
    source: Annotated[str, Meta(description="where the numbers come from")]
    model: Annotated[str, Meta(description="gliding, rolling or flight")]
    status: Status
    t_end: Annotated[str, Meta(description="where it ended, in s")]
    digits: Annotated[int, Meta(description="fewest significant digits of any column")]
    files: Annotated[Files, Meta(description="each file")]
    event_meanings: Annotated[
        dict[str, str], Meta(description="event to the function whose zero it is")
    ]
    rule: Annotated[str, Meta(description="how digits are counted")]
    evidence: Annotated[Evidence, Meta(description="what the digits rest on")]
    versions: Versions
    history: Annotated[list[Change], Meta(description="why published digits changed")]
    sha256_of_proof: Annotated[str | Unset, Meta(description="SHA-256 of the proof")] = UNSET
    sha256_of_manifest: Annotated[str, Meta(description="SHA-256 of the manifest without this key")]


class Ball(Record, frozen=True):
    """An interval that contains the exact number."""

    middle: Annotated[str, Meta(description="middle of the interval")]
    radius: Annotated[str, Meta(description="radius of the interval")]


class Prover(Record, frozen=True):
    """What made a proof."""

    version: Annotated[
        int, Meta(description="counts up with each change of the prover that affects soundness")
    ]
    sources_sha256: Annotated[str, Meta(description="SHA-256 of the prover's sources")]


class ContactForce(Record, frozen=True, kw_only=True):
    """What is proved about the contact force."""

    g_n_positive: Annotated[bool | str, Meta(description="whether g_n > 0 is proved")]
    g_n_at_least_mg: Annotated[
        str | Unset | None, Meta(description="lower bound of g_n in units of m g")
    ] = UNSET
    energy_never_grows: Annotated[
        bool | Unset, Meta(description="whether the energy is proved not to grow")
    ] = UNSET
    lost_at_s: Annotated[Ball | Unset, Meta(description="when contact is lost, in s")] = UNSET


class Climb(Record, frozen=True):
    """The climb in one definition; null where there is none up to the horizon."""

    t_init: Annotated[Ball | None, Meta(description="initiation time in s")]
    t_end: Annotated[Ball | None, Meta(description="ending time in s")]


class Inversion(Record, frozen=True, kw_only=True):
    """Times of the climb, or why nothing is proved of them."""

    failure: Annotated[str | Unset, Meta(description="why nothing is proved")] = UNSET
    equator: Annotated[
        Ball | Unset | None, Meta(description="when theta first crosses pi/2, in s")
    ] = UNSET
    A: Annotated[Climb | Unset, Meta(description="signed perigee")] = UNSET
    B: Annotated[Climb | Unset, Meta(description="L.k = L.z and L.k = -L.z")] = UNSET
    C: Annotated[Climb | Unset, Meta(description="change of sign of phi_dot")] = UNSET


class Neighbourhood(Record, frozen=True, kw_only=True):
    """A neighbourhood of a vertical spin that the solution is proved never to leave."""

    theta_tends_to: Annotated[str, Meta(description="0 or pi: the spin that it tends to")]
    since_s: Annotated[str, Meta(description="from when on it is in the neighbourhood, in s")]
    g_n_at_least_mg: Annotated[
        str, Meta(description="lower bound of g_n from then on, in units of m g")
    ]
    sin_theta_at_most: Annotated[str, Meta(description="bound of sin theta from then on")]
    limits: Annotated[dict[str, Ball], Meta(description="what the quantities tend to, in SI")]


class ProvedColumn(Record, frozen=True):
    """What is proved about one printed column."""

    digits: Digits
    entries: Annotated[int, Meta(description="printed numbers looked at")]
    rounded: Annotated[int, Meta(description="those proved to be rounded correctly")]
    wrong: Annotated[int, Meta(description="those proved not to be")]
    within: Annotated[str, Meta(description="no entry is farther from the exact number")]


class ProvedTable(Record, frozen=True):
    """What is proved about a golden table."""

    sha256: Sha256
    columns: Annotated[dict[str, ProvedColumn], Meta(description="the columns")]


class Proof(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.proof/4"):
    """`proof.json` of a scene's golden data."""

    scene: SceneName
    scene_sha256: Annotated[str, Meta(description="SHA-256 of what the scene says")]
    theorem: Annotated[str, Meta(description="where the theorem stands")]
    prover: Annotated[Prover, Meta(description="what made the proof")]
    bits: Bits
    steps: Annotated[int, Meta(description="steps taken")]
    proved_until_s: Annotated[Ball, Meta(description="until when it is enclosed, in s")]
    failure: Annotated[str | None, Meta(description="why it ended early; null if it did not")]
    digits: Digits
    entries: Annotated[int, Meta(description="printed numbers looked at")]
    rounded: Annotated[int, Meta(description="those proved to be rounded correctly")]
    unproved: Annotated[int, Meta(description="those of which nothing is proved")]
    mismatches: Annotated[
        list[str], Meta(description="what of the tables differs: names, times, counts, shapes")
    ]
    contact: Annotated[ContactForce, Meta(description="what is proved about the contact force")]
    inversion: Annotated[Inversion, Meta(description="times of the climb")]
    forever: Annotated[
        dict[str, Neighbourhood | str],
        Meta(
            description="what holds for all later times: the first neighbourhood that the energy "
            "alone keeps it in (held), the one at the end (at_the_end), or why none is known"
        ),
    ]
    conserved_within: Annotated[
        dict[str, str], Meta(description="bounds of the change of conserved quantities")
    ]
    proved_events: Annotated[
        dict[str, int],
        Meta(description="how often each event happens: each exists, and there is no other"),
    ]
    undecided_events: Annotated[
        dict[str, str], Meta(description="events that are not decided, and why")
    ]
    trajectory: Annotated[ProvedTable, Meta(description="what is proved about the trajectory")] = (
        field(name="trajectory.csv")
    )
    events: Annotated[ProvedTable, Meta(description="what is proved about the events")] = field(
        name="events.csv"
    )
    enclosure: Annotated[Hashed, Meta(description="balls of the trajectory")] = field(
        name="enclosure.csv"
    )
    events_enclosure: Annotated[Hashed, Meta(description="balls of the events")] = field(
        name="events-enclosure.csv"
    )
    versions: Versions
    sha256_of_proof: Annotated[str, Meta(description="SHA-256 of the proof without this key")]
