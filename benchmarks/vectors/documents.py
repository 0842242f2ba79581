"""The JSON documents of the test vectors, as records."""

from __future__ import annotations

from typing import Annotated, Literal

from tt_precise.runtime.records import UNSET, Record, Unset, means

Name = Annotated[str, means("law and number of the state")]
Licence = Annotated[str, means("licence of the data")]
Number = str  # a decimal
Three = list[str]
Four = list[str]
ScalarFirst = Annotated[Four, means("orientation, scalar first")]
ScalarLast = Annotated[Four, means("orientation, scalar last")]
Axis = Annotated[Three, means("axis of symmetry")]
Omega = Annotated[Three, means("angular velocity")]
CentreVelocity = Annotated[Three, means("velocity of the centre of mass")]
Height = Annotated[Number | Unset, means("height of the lowest point above an elastic table")]


class Parameters(Record, frozen=True):
    """Parameters of a top in SI."""

    m: Annotated[Number, means("mass")]
    R: Annotated[Number, means("radius")]
    alpha: Annotated[Number, means("eccentricity")]
    I1: Annotated[Number, means("moment of inertia across the axis")]
    I3: Annotated[Number, means("moment of inertia about the axis")]
    g: Annotated[Number, means("gravity")]


class FrictionLaw(Record, frozen=True):
    """A law of friction."""

    law: Annotated[str, means("its name; sticking: Coulomb's within the cone")]
    mu: Annotated[Number | Unset, means("coefficient")] = UNSET
    epsilon: Annotated[Number | Unset, means("speed in m/s")] = UNSET


class Table(Record, frozen=True):
    """The table; of an elastic one its law of force."""

    law: Annotated[str, means("law of contact")]
    force: Annotated[str | Unset, means("normal force of an elastic table")] = UNSET
    stiffness: Annotated[Number | Unset, means("of the spring")] = UNSET
    damping: Annotated[Number | Unset, means("of the damper")] = UNSET


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

    L: Annotated[Three, means("angular momentum about the centre of mass")]
    a: Annotated[Three, means("from the centre of mass to the contact point")]
    v_A: Annotated[Three, means("velocity of the contact point")]  # noqa: N815
    g_n: Annotated[Number, means("normal force")]
    F: Annotated[Three, means("force at the contact point")]
    torque: Annotated[Three, means("a x F")]
    k_dot: Annotated[Three, means("rate of the axis")]
    L_dot: Annotated[Three, means("rate of L")]
    omega_dot: Annotated[Three, means("angular acceleration")]
    s_ddot: Annotated[Three, means("acceleration of the centre of mass")]
    v_A_dot: Annotated[Three, means("acceleration of the contact")]  # noqa: N815


class State(Record, frozen=True):
    """A state and the terms there."""

    name: Name
    body: Annotated[Parameters, means("the top")]
    friction: Annotated[FrictionLaw, means("friction; mu and epsilon if it has them")]
    contact: Annotated[Table, means("the table")]
    state: Annotated[Given, means("the state")]
    result: Annotated[Literal["valid", "invalid"], means("whether the expected numbers are right")]
    flags: Annotated[
        list[str],
        means("the law; `joins` if it soon sticks or slips; the mistake of an invalid case"),
    ]
    expected: Annotated[Terms, means("every term of the equations")]


class After(Record, frozen=True):
    """A state of states.json after a step."""

    name: Name
    step_s: Annotated[Number, means("length of the step in s")]
    quaternion_wxyz: ScalarFirst
    quaternion_xyzw: ScalarLast
    k: Axis
    omega: Omega
    s_dot: CentreVelocity
    height: Height = UNSET


class Vectors(Record, frozen=True, kw_only=True):
    """The head that both files of test vectors have."""

    licence: Licence
    digits: Annotated[int, means("significant digits of the expected numbers")]
    units: Annotated[dict[str, str], means("name to unit")]
    forces: Annotated[dict[str, str], means("law to its force: F_t along the table, g_n up")]
    frame: Annotated[str, means("frame of all vectors")]
    meaning: Annotated[str, means("content of the file")]


class States(
    Vectors, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.vectors.states/3"
):
    """`reference_data/vectors/states.json`: states and each term of the equations there."""

    cases: Annotated[list[State], means("the states")]


class Steps(
    Vectors, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.vectors.steps/2"
):
    """`reference_data/vectors/steps.json`: the states of states.json after one step."""

    cases: Annotated[list[After], means("state and step")]
