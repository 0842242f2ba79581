"""The claims of S. Rauch-Wojciechowski and N. Rutstam on the dynamics of the tippe top.

Here: the answer to "does the paper hold?", and the sentences that no claim tests.

Each sentence of the answer has the claims on which it depends, and a form for either outcome. The
other table lists the sentences of the paper that the list of claims does not cover.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class AnswerSentence(NamedTuple):
    """A sentence of the answer to "does the paper hold?", and the claims on which it depends."""

    claims: Sequence[str]
    holding: str
    failing: str


class Untested(NamedTuple):
    """A sentence of the paper that no claim tests, and the reason."""

    where: str
    quote: str
    reason: str


ANSWERS = (
    AnswerSentence(
        ("EQ-05", "EQ-08", "EQ-09", "EQ-10", "EQ-11", "EQ-12", "EQ-13"),
        "The equations of motion are right.",
        "The equations of motion are not all right.",
    ),
    AnswerSentence(
        ("TH-01", "TH-03", "TH-16"),
        "Theorem 1.1 holds for tops that keep contact.",
        "Theorem 1.1 does not hold in all its assertions.",
    ),
    AnswerSentence(
        ("QUAL-01", "QUAL-02", "QUAL-25"),
        "The mechanism holds: the top waits, then climbs in many small oscillations.",
        "The mechanism, a top that waits and then climbs in oscillations, does not hold.",
    ),
    AnswerSentence(
        ("NUM-03",),
        "The paper's method keeps lambda to the stated 1e-6; far smaller drifts are possible.",
        "The paper's method does not keep lambda to the stated 1e-6.",
    ),
    AnswerSentence(
        ("NUM-23", "NUM-24"),
        "The energy ratio is as close to theory as the paper states.",
        "The energy ratio is not as close to theory as the paper states.",
    ),
    AnswerSentence(
        ("NUM-26", "NUM-27", "NUM-28", "NUM-29"),
        "The boundary values of section 2.3 are right.",
        "The boundary values of section 2.3 belong to other values of lambda.",
    ),
    AnswerSentence(
        ("NUM-05",),
        "The climb ends at the paper's time.",
        "The climb does not end at the paper's time.",
    ),
    AnswerSentence(
        ("SWP-12",),
        "All tested starts invert.",
        "All tested starts that keep contact invert; of those that lose it, not all have inverted.",
    ),
)

UNTESTED = (
    Untested(
        "Sec. 1", "It continues spinning for some time until it falls down due to frictional loss "
        "of energy.", "About the real toy: the model has no spinning friction (NT-02)."),
    Untested(
        "Sec. 1", "This frame is not fully fixed in the body.", "A definition."),
    Untested(
        "Sec. 1", "The axes 1 and 2 will be principal axes due to the axial symmetry.",
        "True for every axially symmetric body; the inertia tensor of EQ-33 uses it."),
    Untested(
        "Remark 2", "a direct application of the LaSalle theorem would require specification of an "
        "initial compact invariant set, which is difficult to define", "About a proof, not a "
        "statement about motions; solutions with g_n < 0 are TH-07."),
    Untested(
        "Sec. 1", "this condition is useful for explaining rising of a rotating egg",
        "About other papers and another body."),
    Untested(
        "Sec. 1", "no suitable definition of an averaged angle theta(t) is available",
        "An opinion. The middle of the nutation band (QUAL-02) is one such definition."),
    Untested(
        "Sec. 1", "the equation is not separable or explicitly solvable",
        "Not provable by computation."),
    Untested(
        "Sec. 1", "a particle with variable mass 2g(cos theta) moving in a potential well V",
        "A picture of the Main Equation, which EQ-22 and EQ-23 prove."),
    Untested(
        "Sec. 1", "each inverting solution draws a curve (D,E~) that is moving in finite time from "
        "a small neighborhood of (D0,E~0) to one of (D1,E~1)", "The ends are NUM-30, the limits "
        "TH-14 and SUM-03; small has no measure."),
    Untested(
        "Sec. 1", "The motion of the symmetry axis can be seen as nutational motion within a belt",
        "Repeated in section 2.1, where QUAL-08 and QUAL-25 test it."),
    Untested(
        "Sec. 1", "such derivation is a daunting challenge", "An opinion."),
    Untested(
        "Sec. 2.1", "a typical demonstration of a toy TT that is initially started with strong "
        "spin", "About the use of the toy; the numbers are NUM-35 and NT-01."),
    Untested(
        "Sec. 2.1", "Zeros of theta_dot(t) correspond to subsequent local maximum and minimum "
        "points of the theta(t)-curve", "True of every differentiable curve whose zeros of the "
        "derivative are simple (QUAL-01)."),
    Untested(
        "Sec. 2.1", "also visible in corresponding graphs published in [Coh, Ued]",
        "The cited graphs are not available."),
    Untested(
        "Sec. 2.1", "A climbing time is the quantity T_inv", "A definition without a number "
        "(NUM-07)."),
    Untested(
        "Sec. 2.2", "it is natural to consider first", "An opinion."),
    Untested(
        "Sec. 2.3", "This does not contradict the conservation of energy", "Follows from EQ-36."),
    Untested(
        "Sec. 3", "a nonlinear, nonintegrable dynamical system", "That the system has no further "
        "integral is neither shown in the paper nor decided by computation; the degrees of freedom "
        "are TH-22."),
    Untested(
        "Sec. 3", "Analysis of dynamical behaviour of inverting solutions is indeed difficult",
        "An opinion."),
    Untested(
        "Sec. 3", "the torque that changes the components of angular velocity",
        "L_dot = a x F of eq (1), from which EQ-08 to EQ-12 are derived."),
    Untested(
        "Sec. 3", "the curve (D(t),E~(t)) controls deformation of the effective potential",
        "A summary of EQ-22, TH-10 and TH-13."),
    Untested(
        "captions", "the colours of the curves", "The source has no pictures (FIG-16)."),
)  # fmt: skip
