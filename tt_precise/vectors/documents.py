"""The JSON documents of the test vectors and of the index, as records."""

from __future__ import annotations

from typing import Annotated, Literal

from tt_precise.runtime.records import UNSET, Meta, Record, Unset

Name = Annotated[str, Meta(description="law and number of the state")]
Licence = Annotated[str, Meta(description="licence of the data")]
Number = str  # a decimal
Three = list[str]
Four = list[str]
ScalarFirst = Annotated[Four, Meta(description="orientation, scalar first")]
ScalarLast = Annotated[Four, Meta(description="orientation, scalar last")]
Axis = Annotated[Three, Meta(description="axis of symmetry")]
Omega = Annotated[Three, Meta(description="angular velocity")]
CentreVelocity = Annotated[Three, Meta(description="velocity of the centre of mass")]
Height = Annotated[
    Number | Unset, Meta(description="height of the lowest point above an elastic table")
]


class Listed(Record, frozen=True):
    """A file of the reference data."""

    path: Annotated[str, Meta(description="path below reference_data")]
    sha256: Annotated[str, Meta(description="SHA-256 in hex")]
    licence: Licence
    kind: Annotated[str, Meta(description="what kind of file")]
    content: Annotated[str, Meta(description="what stands in it")]
    scene: Annotated[str | None, Meta(description="the scene it belongs to")]
    schema: Annotated[str, Meta(description="name and version of its format")]
    digits: Annotated[int | None, Meta(description="significant digits of its numbers")]


class Index(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.index/1"):
    """`reference_data/index.json`: every file of the reference data."""

    licence: Licence
    units: Annotated[str, Meta(description="where units stand")]
    files: Annotated[list[Listed], Meta(description="one a file")]


class Parameters(Record, frozen=True):
    """Parameters of a top in SI."""

    m: Annotated[Number, Meta(description="mass")]
    R: Annotated[Number, Meta(description="radius")]
    alpha: Annotated[Number, Meta(description="eccentricity")]
    I1: Annotated[Number, Meta(description="moment of inertia across the axis")]
    I3: Annotated[Number, Meta(description="moment of inertia about the axis")]
    g: Annotated[Number, Meta(description="gravity")]


class FrictionLaw(Record, frozen=True):
    """A law of friction."""

    law: Annotated[
        str,
        Meta(description="sticking: Coulomb's where v_A = 0 and the force lies within the cone"),
    ]
    mu: Annotated[Number | Unset, Meta(description="coefficient")] = UNSET
    epsilon: Annotated[Number | Unset, Meta(description="speed in m/s")] = UNSET


class Table(Record, frozen=True):
    """The table; of an elastic one its law of force."""

    law: Annotated[str, Meta(description="law of contact")]
    force: Annotated[str | Unset, Meta(description="normal force of an elastic table")] = UNSET
    stiffness: Annotated[Number | Unset, Meta(description="of the spring")] = UNSET
    damping: Annotated[Number | Unset, Meta(description="of the damper")] = UNSET


class Given(Record, frozen=True):
    """A state, 50 digits."""

    quaternion_wxyz: ScalarFirst
    quaternion_xyzw: ScalarLast
    k: Axis
    omega: Omega
    s_dot: CentreVelocity
    height: Height = UNSET


class Terms(Record, frozen=True):
    """Every term of the equations."""

    L: Annotated[Three, Meta(description="angular momentum about the centre of mass")]
    a: Annotated[Three, Meta(description="from the centre of mass to the contact point")]
    v_A: Annotated[Three, Meta(description="velocity of the contact point")]  # noqa: N815
    g_n: Annotated[Number, Meta(description="normal force")]
    F: Annotated[Three, Meta(description="force at the contact point")]
    torque: Annotated[Three, Meta(description="a x F")]
    k_dot: Annotated[Three, Meta(description="rate of the axis")]
    L_dot: Annotated[Three, Meta(description="rate of L")]
    omega_dot: Annotated[Three, Meta(description="angular acceleration")]
    s_ddot: Annotated[Three, Meta(description="acceleration of the centre of mass")]
    v_A_dot: Annotated[Three, Meta(description="acceleration of the contact")]  # noqa: N815


class State(Record, frozen=True):
    """A state and the terms there."""

    name: Name
    body: Annotated[Parameters, Meta(description="the top")]
    friction: Annotated[FrictionLaw, Meta(description="friction; mu and epsilon if it has them")]
    contact: Annotated[Table, Meta(description="the table")]
    state: Annotated[Given, Meta(description="the state")]
    result: Annotated[
        Literal["valid", "invalid"], Meta(description="whether what is expected is right")
    ]
    flags: Annotated[
        list[str],
        Meta(
            description="the law; `joins` where the top sticks or slips soon; the mistake of an "
            "invalid case"
        ),
    ]
    expected: Annotated[Terms, Meta(description="every term of the equations")]


class After(Record, frozen=True):
    """A state of states.json after a step."""

    name: Name
    step_s: Annotated[Number, Meta(description="length of the step in s")]
    quaternion_wxyz: ScalarFirst
    quaternion_xyzw: ScalarLast
    k: Axis
    omega: Omega
    s_dot: CentreVelocity
    height: Height = UNSET


class Vectors(Record, frozen=True, kw_only=True):
    """What both files of test vectors say first."""

    licence: Licence
    digits: Annotated[int, Meta(description="significant digits of what is expected")]
    units: Annotated[dict[str, str], Meta(description="name to unit")]
    forces: Annotated[
        dict[str, str],
        Meta(description="law of friction or of contact to its force: F_t along the table, g_n up"),
    ]
    frame: Annotated[str, Meta(description="frame of all vectors")]
    meaning: Annotated[str, Meta(description="what the file holds")]


class States(
    Vectors, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.vectors.states/3"
):
    """`reference_data/vectors/states.json`: states and each term of the equations there."""

    cases: Annotated[list[State], Meta(description="the states")]


class Steps(
    Vectors, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.vectors.steps/2"
):
    """`reference_data/vectors/steps.json`: the states of states.json after one step."""

    cases: Annotated[list[After], Meta(description="state and step")]
