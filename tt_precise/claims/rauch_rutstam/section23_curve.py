"""Section 2.3: the curve (D, E~), its ends, and its distance from the energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.run import MANY, REFERENCE, Run, Span
from tt_precise.claims.part import Part, decimal, statement, statements
from tt_precise.claims.verdicts import Grounds
from tt_precise.exact.stability import rounding_to
from tt_precise.mechanics import thresholds as formulas
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion, Quantity
from tt_precise.mechanics.vectors import Vector, cross, dot
from tt_precise.runtime.values import Functions, Scalar

claim = claims_of("2.3")
COMPONENTS = ("tau_x", "tau_y", "tau_z")
PRINTED = {"D0": "9.381e-4", "D1": "-6.667e-4", "E0": "4.912e-2", "E1": "1.734e-2"}
TORQUE_SHARE = (
    "part of the time from 0 to 8 s in which each component in the frame (x, y, z) is negative, "
    "zeros between extrema found as events"
)
LARGEST = "the largest E~ - E, among its extrema (events)"
TREND = (
    "values at the ends of the climb (definition A); at every instant: no step the other way "
    "between extrema (events)"
)
# Quantities in the panels that are cited or should be, from the captions.
PANELS = {
    "3a": {"nu_x", "nu_y"}, "3b": {"omega_3", "omega_3_dot"}, "3c": {"g_n"}, "7c": {"E", "E_tilde"}
}  # fmt: skip
NEEDED = {
    "sizes of the terms in nu_x, nu_y": {"nu_x", "nu_y"},
    "difference E~ - E": {"E", "E_tilde"},
}
REFERRED = dict(zip(NEEDED, ("3b", "3c"), strict=True))
CORRECT_REFERENCE = dict(zip(NEEDED, ("3a", "7c"), strict=True))


@claim("FIG-09", control="refuted", sign="positive")
def predominantly_negative_torque(sign: str = "negative", run: Run = REFERENCE) -> Grounds:
    """The components of the torque are predominantly negative.

    Sec. 2.3: "These components are all predominantly negative"
    Definition: {TORQUE_SHARE}; predominantly: two thirds
    Note: In the climb alone they are negative for {in_climb} of the time; tau_x and tau_z have the
    sign of -nu_y.
    """
    return _sign_of_the_torque("for most of the time", 2 / 3, sign, run)


@claim("FIG-17", control="reproduced", limit=0.8)
def almost_always_negative_torque(limit: float = 0.95, run: Run = REFERENCE) -> Grounds:
    """The components of the torque are negative almost all the time.

    Fig. 6, caption: "All components are negative almost all the time"
    Definition: {TORQUE_SHARE}; almost all: 95 %
    Note: In the climb alone they are negative for {in_climb} of the time; tau_x and tau_z have the
    sign of -nu_y.
    """
    return _sign_of_the_torque("almost all the time", limit, "negative", run)


def _sign_of_the_torque(words: str, limit: float, sign: str, run: Run) -> Grounds:
    """Test whether each component of the torque has a sign for a part of the time."""
    shares = {name: run.share_below_zero(name) for name in COMPONENTS}
    climb = {name: run.share_below_zero(name, run.climb) for name in COMPONENTS}
    if sign == "positive":
        shares = {name: 1 - share for name, share in shares.items()}
    whole, in_climb = (
        tuple(f"{name} {100 * share:.2f} %" for name, share in each.items())
        for each in (shares, climb)
    )
    shown = f"{sign} for {', '.join(whole)} of the time"
    holds = min(shares.values()) > limit
    return statement(holds, f"{sign} {words}", shown), {"in_climb": in_climb}


def _asymptotic(
    name: str, quantity: str, time: str, unit: str, printed: str, run: Run = REFERENCE
) -> Grounds:
    values, fn = run.thresholds.quantities, run.thresholds.context
    body = run.loaded.body.numbers(rounding_to(fn))
    own = values["lambda"].value
    double = _formula(name, body, fn)(2 * values["lambda_thres"].value)
    implied = {
        each: _lambda_of(_formula(each, body, fn), fn.mpf(value), own, fn)
        for each, value in {**PRINTED, name: printed}.items()
    }
    every = tuple(decimal(implied[each], 3) for each in PRINTED)
    return {
        "lambda of the reference start": part.about(printed, values[name].value, unit),
        "lambda = 2 lambda_thres": part.about(printed, double, unit),
        f"the value at {time} s itself": part.about(printed, run.at(quantity, time), unit),
    }, {"implied": implied[name], "own": own, "every": every}


def _formula(name: str, body: Parameters, fn: Functions) -> Callable[[Scalar], Scalar]:
    more = (fn,) if name.startswith("D") else ()
    return lambda lambda_: getattr(formulas, name)(body, lambda_, *more)


def _lambda_of(
    formula: Callable[[Scalar], Scalar], value: Scalar, guess: Scalar, fn: Functions
) -> Scalar:
    """The lambda at which an asymptotic value would be ``value``."""
    return fn.findroot(lambda ratio: formula(ratio * guess) / value - 1, 1) * guess


# id, name, quote, a wrong number, subject of the statement, and the value of the solution itself
for id, name, quote, wrong, subject, quantity, time, unit in (
    ("NUM-26", "D0", "D0≈lambda sqrt(d(1))/(R(1-alpha))=9.381*10^-4", "7.239e-4",
     "Routh's function of the upright spin", "D", "0", "kg m^2/s"),
    ("NUM-27", "D1", "D1≈-lambda sqrt(d(-1))/(R(1+alpha))=-6.667*10^-4", "-6.024e-4",
     "Routh's function of the inverted spin", "D", "8", "kg m^2/s"),
    ("NUM-28", "E0", "E~0≈4.912*10^-2", "4.064e-2",
     "The modified energy of the upright spin", "E_tilde", "0", "J"),
    ("NUM-29", "E1", "E~1≈1.734*10^-2", "1.609e-2",
     "The modified energy of the inverted spin", "E_tilde", "8", "J"),
):  # fmt: skip
    words = f"""{subject} with the reference lambda is {PRINTED[name]} {unit}.

    Sec. 2.3: "{quote}"
    Definition: lambda is that of the reference start, or exactly 2 lambda_thres
    Note: The printed value belongs to lambda = {{implied:4}}, not to the reference start's
    {{own:4}} kg m^3/s. The four printed boundary values belong to {{every}}: no single lambda has
    all four.
    """
    judge = partial(_asymptotic, name, quantity, time, unit, printed=PRINTED[name])
    register = partial(claim, rule="interpretations", finding="NUM-26", control="ambiguous")
    register(id, words, printed=wrong)(judge)


@claim(
    "NUM-30",
    rule="interpretations",
    finding="NUM-26",
    control="ambiguous",
    printed=("7.301e-4", "4.215e-2", "-6.024e-4", "1.609e-2"),
)
def ends_of_the_curve(
    printed: tuple[str, ...] = ("9.381e-4", "4.912e-2", "-6.667e-4", "1.734e-2"),
    run: Run = REFERENCE,
) -> Grounds:
    """The curve (D(t), E~(t)) goes from the printed initial to the printed final point.

    Sec. 2.3, Fig. 7a: "goes from the initial boundary value (D0≈9.381*10^-4,E~0≈4.912*10^-2) to the
    final boundary value (D1≈-6.667*10^-4,E~1≈1.734*10^-2)"
    Definition: (D, E~) of the reference solution at 0 and 8 s, and the limits for its lambda
    Note: At the start, theta(0) = 0.1, D is {off[0]:.1%} and E~ {off[1]:.1%} off the limit for t to
    -infinity. For the printed limits see NUM-26 to NUM-29.
    """
    own = [run.at(name, t) for t in ("0", "8") for name in ("D", "E_tilde")]
    values = run.thresholds.quantities
    limits = [values[name].value for name in ("D0", "E0", "D1", "E1")]
    words, parts = "({}, {}) to ({}, {})", {}
    for meaning, numbers in (("the curve's own ends", own), ("the limits", limits)):
        ends = [part.about(text, number) for text, number in zip(printed, numbers, strict=True)]
        holds = all(end.holds for end in ends)
        parts[meaning] = holds, words.format(*(end.measured for end in ends))
    off = [float(abs(own[i].value / limits[i] - 1)) for i in (0, 1)]
    return statements(words.format(*printed), parts), {"off": off}


@claim("FIG-10", rule="interpretations", control="refuted", name="E_tilde")
def monotony_of_D(name: str = "D", run: Run = REFERENCE) -> Grounds:
    """D(t) decreases almost monotonically.

    Sec. 2.3, Fig. 7b: "D(t) (in Fig. 7b) is almost monotonously decreasing"
    Definition: rises between extrema found as events, relative to the whole fall of D: the largest
    single one (what a graph shows), and all of them together; almost: below 1 %
    Note: The paper's reason, D = I3 omega_3 sqrt(d(cos theta)), ignores the oscillation of d(cos
    theta), which is larger than the oscillation of omega_3.
    """
    values = run.extrema(name)[1]
    fall = float(values[0] - values[-1])
    rises = [float(b - a) for a, b in pairwise(values) if b > a]
    largest, every = max(rises, default=0.0) / fall, sum(rises) / fall
    shown = f"{len(rises)} rises, in sum {100 * every:.1f} % of the fall"
    parts = {
        "no rise that a graph shows": (
            largest < 0.01,
            f"largest rise {100 * largest:.2f} % of the fall",
        ),
        "all rises together": (every < 0.01, shown),
    }
    return statements("almost monotonously decreasing", parts)


@claim("FIG-11", control="refuted", pair=("E_pot", "E"))
def oscillation_of_the_modified_energy(
    pair: tuple[str, str] = ("E_tilde", "E"), run: Run = REFERENCE
) -> Grounds:
    """E~ oscillates relative to E.

    Sec. 2.3, Fig. 7a, c: "oscillatory behaviour of E~(t) in relation to the green curve E(t)"
    Definition: changes of sign of E~ - E and local extrema of E~ (events); many: {MANY}
    Note: E itself has {own} local extrema.
    """
    changes = len(run.zeros(_difference(pair)))
    turns = len(run.extrema(pair[0])[0]) - 2
    shown = f"{turns} local extrema, {changes} changes of sign of the difference"
    words = f"{pair[0]} oscillates relative to {pair[1]}"
    own = len(run.extrema("E")[0]) - 2
    return statement(min(changes, turns) >= MANY, words, shown), {"own": own}


@claim("FIG-12", rule="interpretations", control="refuted", pair=("E", "E_tilde"))
def modified_energy_is_larger(
    pair: tuple[str, str] = ("E_tilde", "E"), run: Run = REFERENCE
) -> Grounds:
    """During the inversion E~ is larger than E.

    Sec. 2.3: "The modified rotational energy E~(t) is consistently larger than E(t) during
    inversion"
    Definition: E~ - E at every instant of the climb (definition A; zeros found as events), and
    averaged over each nutation (from one maximum of theta to the next) and over the climb
    Note: The difference goes from {depth[1]:3} to {height[1]:3} J; around its maximum it is
    positive from {begin:4} to {until:4} s.
    """
    climb, excess = run.climb, _difference(pair)
    changes = run.zeros(excess, climb)
    below = run.share_below_zero(excess, climb)
    depth, height = (run.extremum(excess, largest=largest, span=climb) for largest in (False, True))
    averages = [run.mean(excess, span) for span in run.nutations(climb)]
    begin = max((t for t in changes if t < height[0]), default=climb.begin)
    until = min((t for t in changes if t > height[0]), default=climb.end)
    average = f"average difference from {decimal(min(averages), 2)} to "
    average += f"{decimal(max(averages), 2)} J"
    parts = {
        "at every instant": (below == 0, f"not for {100 * below:.1f} % of the climb"),
        "averaged over each nutation": (min(averages) > 0, average),
    }
    numbers = {"depth": depth, "height": height, "begin": begin, "until": until}
    return statements(f"{pair[0]} > {pair[1]}", parts), numbers


@claim("FIG-13", control="refuted", pair=("E", "E_tilde"))
def largest_in_the_middle(
    pair: tuple[str, str] = ("E_tilde", "E"), run: Run = REFERENCE
) -> Grounds:
    """E~ - E is largest in the middle of the inversion.

    Sec. 2.3: "the difference E~-E becomes largest in the middle of inversion"
    Definition: {LARGEST}; middle: the middle third of the climb (definition A)
    Note: There {pair[0]} exceeds {pair[1]} by {value:4} J.
    """
    climb = run.climb
    when, value = run.extremum(_difference(pair), largest=True)
    middle = climb.begin + climb.length / 3 < when < climb.end - climb.length / 3
    shown = f"at {decimal(when, 5)} s"
    return statement(middle, "in the middle of inversion", shown), {"value": value}


@claim("FIG-21", control="refuted", angle="1")
def largest_at_the_equator(angle: str = "", run: Run = REFERENCE) -> Grounds:
    """E~ - E is largest where theta is about pi/2.

    Sec. 2.3: "becomes largest in the middle of inversion when theta≈pi/2"
    Definition: {LARGEST}; theta about pi/2: within 0.2 rad
    Note: theta first passes pi/2 at {run.equator:5} s.
    """
    when, _ = run.extremum(_difference(("E_tilde", "E")), largest=True)
    theta = run.value("theta", when)
    near = abs(theta - float(angle or math.pi / 2)) < 0.2
    return statement(near, f"theta about {angle or 'pi/2'}", f"theta = {decimal(theta, 4)}")


def _difference(pair: tuple[str, str]) -> Quantity:
    first, second = (QUANTITIES[name].evaluate for name in pair)
    return Quantity.of(lambda q: first(q) - second(q), "J")


@claim("QUAL-27", rule="interpretations", control="refuted", side=-1)
def direction_of_omega_cross_a(side: int = 1, run: Run = REFERENCE) -> Grounds:
    """omega x a points to y-hat, behind the plane of Fig. 1.

    Sec. 2.3: "the product omega x a points behind the plane of the picture"
    Definition: (omega x a).y-hat = R sin(theta)(omega_3 + phi_dot (alpha - cos(theta))), where
    y-hat points behind the plane: its sign at every instant, and averaged over each nutation (from
    one maximum of theta to the next) and over the climb (definition A)
    Note: The component is R alpha omega_z sin(theta) > 0 where omega is exactly vertical. Near the
    pole the small horizontal part of omega decides its sign.
    """
    velocity = Quantity.of(lambda q: side * _along_y(cross(q.omega, q.a), q), "m/s")
    when, least = run.extremum(velocity, largest=False, span=run.climb)
    shown = f"least value {decimal(least, 4)} m/s at {decimal(when, 5)} s"
    parts = {"at every instant": (least > 0, shown), **_averages(velocity, run)}
    return statements("points behind the plane", parts)


@claim("QUAL-28", rule="interpretations", control="refuted", sign=-1)
def length_of_a(sign: int = 1, run: Run = REFERENCE) -> Grounds:
    """In the climb |a| grows.

    Sec. 2.3: "|a| is growing during inversion"
    Definition: {TREND}
    Note: It follows the nutation of the axis.
    """
    return trend(lambda q: dot(q.a, q.a), "m", sign, run, run.climb)


@claim("QUAL-40", rule="interpretations", finding="QUAL-28", control="refuted", sign=1)
def length_of_omega(sign: int = -1, run: Run = REFERENCE) -> Grounds:
    """In the climb |omega| decreases.

    Sec. 2.3: "|omega| is decreasing"
    Definition: {TREND}
    Note: It follows the nutation of the axis.
    """
    return trend(lambda q: dot(q.omega, q.omega), "rad/s", sign, run, run.climb)


@claim("QUAL-41", rule="interpretations", finding="QUAL-28", control="refuted", sign=-1)
def sine_of_theta(sign: int = 1, run: Run = REFERENCE) -> Grounds:
    """In the climb sin(theta) grows until pi/2.

    Sec. 2.3: "sin theta is growing until the axis 3 passes theta=pi/2"
    Definition: {TREND}; here from t_init until theta first passes pi/2
    Note: It follows the nutation of the axis.
    """
    span = Span(run.climb.begin, run.equator)
    return trend(lambda q: q.state.kx**2 + q.state.ky**2, "", sign, run, span)


def trend(
    square: Callable[[Motion], Scalar], unit: str, sign: int, run: Run, span: Span
) -> dict[str, Part]:
    """Test whether a length, whose square is given, grows (``sign`` 1) or falls in a span."""
    name = Quantity.of(lambda q: q.fn.sqrt(square(q)), unit.replace("rad", "1") or "1")
    begin, end = run.column(name, span)
    rise, fall = run.rises_and_falls(name, span)
    back = fall if sign > 0 else rise
    first, last = (f"{decimal(value, 4)} {unit}".strip() for value in (begin, end))
    instants = f"goes back by {decimal(back, 3)} {unit} in total".replace("  ", " ")
    parts = {
        "from one end to the other": (sign * (end - begin) > 0, f"from {first} to {last}"),
        "at every instant": (back == 0, instants),
    }
    return statements("growing" if sign > 0 else "decreasing", parts)


@claim("QUAL-29", control="refuted", factor=-2)
def sufficiently_large(factor: int = 2, run: Run = REFERENCE) -> Grounds:
    """2|omega x a| - nu_y may stay positive in the climb.

    Sec. 2.3: "This may altogether keep the term (2|omega x a|-nu_y) positive and sufficiently large
    to make (25) positive"
    Definition: 2|omega x a| - nu_y in the climb (definition A), averaged over each nutation (from
    one maximum of theta to the next) and over the climb: a sentence with may does not speak of
    every instant
    Note: At single instants it falls to {least:4} m/s, at {when:5} s.
    """

    def term(q: Motion) -> Scalar:
        arm = cross(q.omega, q.a)
        return factor * q.fn.sqrt(dot(arm, arm)) - _along_y(q.state.v, q)

    velocity = Quantity.of(term, "m/s")
    when, least = run.extremum(velocity, largest=False, span=run.climb)
    return statements("positive", _averages(velocity, run)), {"least": least, "when": when}


def _averages(velocity: Quantity, run: Run) -> dict[str, tuple[bool, str]]:
    """The sign of the averages of a velocity, as parts."""
    averages = [run.mean(velocity, span) for span in run.nutations(run.climb)]
    whole, lowest, highest = run.mean(velocity, run.climb), min(averages), max(averages)
    shown = f"averages from {decimal(lowest, 2)} to {decimal(highest, 2)} m/s"
    return {
        "averaged over each nutation": (lowest > 0, shown),
        "averaged over the climb": (whole > 0, f"average {decimal(whole, 3)} m/s"),
    }


def _along_y(vector: Vector, q: Motion) -> Scalar:
    """The component of a vector along y-hat, the horizontal direction across the axis."""
    return vector[1] * q.x_hat[0] - vector[0] * q.x_hat[1]


@claim("FIG-14", rule="misprint", control="reproduced", references=CORRECT_REFERENCE)
def cross_references(references: Mapping[str, str] = REFERRED) -> Grounds:
    """The last two references to figures name the panels that show the quantities discussed.

    Sec. 2.3, end: "In Fig. 3b we cannot estimate the size of each term ... the graph 3c where the
    difference E~-E becomes largest"
    Definition: the panel named must show, by its caption, what the sentence speaks about; labels
    total_plots2 b and c are panels b and c of Figure 3
    Note: Fig. 3b shows the spin and Fig. 3c the normal force.
    """

    def compare(panels: Mapping[str, str]) -> Part:
        right = all(NEEDED[what] <= PANELS[panel] for what, panel in panels.items())
        printed = ", ".join(f"Fig. {panel} for the {what}" for what, panel in panels.items())
        contents = ((panel, ", ".join(sorted(PANELS[panel]))) for panel in panels.values())
        shown = ", ".join(f"Fig. {panel} shows {content}" for panel, content in contents)
        return statement(right, printed, shown)

    return part.misprint(compare, references, CORRECT_REFERENCE)


@claim("FIG-16")
def colours() -> Grounds:
    """The figures show the curves in the colours that captions and text name.

    captions of Figs 2 to 7; Sec. 2.3: "(blue), (yellow), (grey), (green), (red); light blue line"
    Note: The available source has no pictures, so the colours cannot be checked. The captions of
    Figs 4 and 6 name no colour, and Fig. 7 names only the colour of E.
    """
    return part.untestable("colours of curves")
