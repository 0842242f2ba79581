"""Section 2.1: gliding of the reference solution, and the numbers of its start."""

from __future__ import annotations

import math

from msgspec.structs import replace

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import parse
from tt_precise.claims.evidence.run import REFERENCE, Run, Span, rows_of, variant
from tt_precise.claims.part import Part, Value, decimal, statement, statements
from tt_precise.claims.rauch_rutstam.section1_potential import CONDITION, CORRECT_CONDITION
from tt_precise.claims.verdicts import Grounds
from tt_precise.scene.scene import load_scene

claim = claims_of("2.1")
LATER = "10"  # Horizon in s, with enough nutations after the climb.
ORDERS = (
    "decimal logarithm of the ratio of nu_y in the climb (initiation to ending time, definition A) "
    "to nu_y before it: of the largest values of |nu_y|, of the means, and of the largest value in "
    "the climb to the first local maximum"
)
INITIALLY = "initially: until nu_x first vanishes"
OSCILLATION = (
    "oscillation: largest distance between consecutive extrema, among which the ends of both "
    "phases are (definition A)"
)
BOTH_ORDERS = "Section 2.1 says about two orders (NUM-37), the summary one to two (NUM-36)."
PERIOD = "a nutation period is the time from one maximum of theta to the next"


@claim("TH-19", rule="misprint", finding="EQ-26", control="reproduced", printed=CORRECT_CONDITION)
def toy_satisfies_the_condition(printed: str = CONDITION, run: Run = REFERENCE) -> Grounds:
    """The toy satisfies the printed rationality condition.

    Sec. 2.1: "They satisfy the rationality condition m R^2/I3=(1-alpha)/(gamma+alpha^2-1)"
    Note: Computed with exact fractions.
    """
    body = run.loaded.body

    def satisfied(text: str) -> Part:
        value = parse(text, {"gamma": body.gamma, "alpha": body.alpha})
        both = f"left {decimal(body.sigma, 6)}, right {decimal(value, 6)}"
        return part.formula(body.sigma == value, f"m*R**2/I3 = {text}", both, proved=True)

    return part.misprint(satisfied, printed, CORRECT_CONDITION)


@claim("TH-25", control="refuted", run=Run(variant(I1="2/5")))
def toy_lies_between(run: Run = REFERENCE) -> Grounds:
    """The toy has 1 - alpha^2 < gamma < 1.

    Sec. 1: "1-alpha^2<gamma<1 ... conditions that may be realized by parameters of a real toy TT"
    Definition: the toy of section 2.1
    Note: Computed with exact fractions. The condition on sigma is TH-19.
    """
    lower, gamma = 1 - run.loaded.body.alpha**2, run.loaded.body.gamma
    shown = f"{lower}, {gamma}, 1"
    return statement(lower < gamma < 1, "1-alpha^2 < gamma < 1", shown, proved=True)


@claim("NUM-01", control="refuted", run=Run(variant(omega_3="300")))
def reference_lambda(printed: str = "2", run: Run = REFERENCE) -> Grounds:
    """lambda of the reference start is about twice the threshold.

    Sec. 2.1: "initial conditions (IC) with lambda≈2lambda_thres"
    Note: lambda = {values[lambda].value:12} kg m^3/s and lambda_thres =
    {values[lambda_thres].value:12} kg m^3/s.
    """
    values = run.thresholds.quantities
    ratio = values["lambda"].value / values["lambda_thres"].value
    check = values["lambda"].independent / values["lambda_thres"].independent
    return part.about(printed, Value.of(ratio, check), "lambda_thres"), {"values": values}


@claim("NT-01")
def realistic_values() -> Grounds:
    """The parameters are those of a typical toy, close to other authors' values.

    Sec. 2.1: "realistic values of the physical parameters for a typical toy TT ... close to the
    parameter values used in simulations by other authors"
    Note: The paper does not have the values of the cited authors, and "close" has no measure. The
    body is possible: I1 = {I1:4}, I3 = {I3:4} m R^2 with I3 < 2 I1, m = {m:2} g, R = {R:2} cm. mu =
    0.3 lacks its unit, s/m.
    """
    body = load_scene("reference").body
    unit = body.m * body.R**2
    numbers = {"I1": body.I1 / unit, "I3": body.I3 / unit, "m": 1000 * body.m, "R": 100 * body.R}
    return part.untestable("realistic, close to [Coh, Ued]"), numbers


@claim("NUM-36", rule="interpretations", control="refuted", orders=(3.5, 4.5))
def growth_in_the_summary(orders: tuple[float, float] = (1, 2), run: Run = REFERENCE) -> Grounds:
    """At the initiation time nu_y increases by one to two orders of magnitude.

    Summary d): "increases by 1-2 orders of magnitude"
    Definition: {ORDERS}; 1-2 orders: 1 to 2
    Note: {BOTH_ORDERS}
    """
    return _growth_of_nu_y(*orders, run)


@claim("NUM-37", rule="interpretations", control="reproduced", orders=(0.5, 3))
def growth_in_the_climb(orders: tuple[float, float] = (1.5, 2.5), run: Run = REFERENCE) -> Grounds:
    """In the climb nu_y is about two orders of magnitude larger than before.

    Sec. 2.1: "its values increase by about two orders of magnitude in comparison with values during
    the synchronatisation phase"
    Definition: {ORDERS}; about two: 1.5 to 2.5
    Note: {BOTH_ORDERS}
    """
    return _growth_of_nu_y(*orders, run)


def _growth_of_nu_y(low: float, high: float, run: Run) -> dict[str, Part]:
    """Compare nu_y in the climb with nu_y before it, in orders of magnitude."""
    spans = run.climb, run.synchronisation
    first = next(value for value in run.extrema("nu_y")[1] if value > 0)
    peak, earlier = (_largest_size("nu_y", run, span) for span in spans)
    mean, mean_before = (run.mean("nu_y", span) for span in spans)
    ratios = {
        "largest values": peak / earlier,
        "means": mean / mean_before,
        "largest against the first maximum": peak / first,
    }
    parts = {}
    for name, ratio in ratios.items():
        size = math.log10(ratio)
        shown = f"factor {decimal(ratio, 4)}, {size:.2f} orders"
        parts[name] = low <= size <= high, shown
    return statements(f"{low} to {high} orders", parts)


@claim("QUAL-19", control="refuted", sign=-1)
def positive_at_first(sign: int = 1, run: Run = REFERENCE) -> Grounds:
    """At first nu_x is positive.

    Sec. 2.1: "initially nu_x (blue) is positive"
    Definition: {INITIALLY}
    Note: Its mean until then is {mean:3} m/s.
    """
    span = _initially(run)
    positive = sign * run.value("nu_x", span.middle) > 0
    shown = f"until {decimal(span.end, 5)} s"
    return statement(positive, "positive", shown), {"mean": run.mean("nu_x", span)}


@claim("QUAL-37", control="refuted", larger="nu_y", smaller="nu_x")
def larger_at_first(larger: str = "nu_x", smaller: str = "nu_y", run: Run = REFERENCE) -> Grounds:
    """At first nu_x is larger than nu_y.

    Sec. 2.1: "and has larger value than nu_y (green)"
    Definition: {INITIALLY}; larger: no crossing of the two before
    Note: nu_x first vanishes at {span.end:5} s.
    """
    span = _initially(run)
    crossing = float(run.events("nu_crossing")["t"].iloc[0])
    above = run.value(larger, span.middle) > run.value(smaller, span.middle)
    shown = f"no crossing until {decimal(crossing, 5)} s"
    return statement(above and crossing > span.end, f"{larger} > {smaller}", shown), {"span": span}


@claim("QUAL-38", control="refuted", name="nu_x")
def close_to_zero_at_first(name: str = "nu_y", run: Run = REFERENCE) -> Grounds:
    """At first nu_y oscillates close to zero.

    Sec. 2.1: "nu_y (green) that oscillates close to 0"
    Definition: {INITIALLY}; close to 0: the mean of nu_y is below a fifth of that of nu_x, and nu_y
    changes sign
    Note: The oscillation of {name} grows before the climb, to {size:2} m/s.
    """
    span = _initially(run)
    mean, other = run.mean(name, span), run.mean("nu_x", span)
    changes = len(run.zeros(name, span))
    shown = f"mean {decimal(mean, 3)} against {decimal(other, 3)} m/s until "
    shown += f"{decimal(span.end, 5)} s, {changes} changes of sign"
    close = statement(changes > 1 and abs(mean) < other / 5, "oscillates close to 0", shown)
    return close, {"size": _largest_size(name, run, run.synchronisation)}


def _initially(run: Run) -> Span:
    """The time until nu_x first vanishes."""
    return Span(0.0, float(run.events("nu_x_zero")["t"].iloc[0]))


@claim("QUAL-20", rule="interpretations", control="refuted", printed="3.5")
def crossing_from_below(printed: str = "3.2", run: Run = REFERENCE) -> Grounds:
    """nu_y crosses nu_x from below at the initiation time.

    Sec. 2.1; Summary d): "the graph of nu_y(t) crosses the graph of nu_x(t) at t_{theta≈0}≈3.2s"
    Definition: events nu_y = nu_x at which nu_y - nu_x rises, before mid-climb
    Note: nu_y crosses nu_x {count} times, both ways, between {first:5} and {last:5} s; from the
    last one on nu_y stays above until {until:5} s.
    """
    rising, every = _crossings(run, rising=True, early=True), _crossings(run, early=True)
    nearest = min(rising, key=lambda t: abs(t - run.climb.begin))
    until = _crossings(run, early=False)[0]
    return {
        "the crossing nearest to t_init": part.about(printed, nearest, "s"),
        "the last crossing": part.about(printed, rising[-1], "s"),
        "the first crossing": part.about(printed, rising[0], "s"),
    }, {"count": len(every), "first": every[0], "last": every[-1], "until": until}


@claim("QUAL-21", control="refuted", higher="nu_x", lower="nu_y")
def minima_in_the_climb(higher: str = "nu_y", lower: str = "nu_x", run: Run = REFERENCE) -> Grounds:
    """During the climb the minima of nu_y lie above those of nu_x ("minimal": minima).

    Sec. 2.1: "from this moment the minimal of nu_y(t) are consistently higher than the minima of
    nu_x(t)"
    Definition: {PERIOD}; the least values of nu_x and nu_y in each period of the climb
    Note: The sentence has "minimal of nu_y(t)" for "minima of nu_y(t)".
    """
    above, shown = _count_above(higher, lower, run, run.climb)
    words = f"minima of {higher} above those of {lower}"
    return {"in every nutation": statement(above, words, f"{shown} of the climb")}


@claim("QUAL-22", rule="interpretations", control="refuted", name="nu_x")
def positive_in_the_climb(name: str = "nu_y", run: Run = REFERENCE) -> Grounds:
    """nu_y is positive during the climb.

    Sec. 2.1: "During the climbing phase the oscillatory function nu_y(t) is positive"
    Definition: climb: initiation to ending time, definition A; {PERIOD}
    Note: Positive at every instant only between {first:5} and {last:5} s.
    """
    climb = run.climb
    below, zeros = run.share_below_zero(name, climb), run.zeros(name, climb)
    least = min(run.least_in([climb], name))
    average = min(run.mean(name, span) for span in run.nutations(climb))
    shown = f"negative for {100 * below:.3g} % of the climb, down to {decimal(least, 4)} m/s"
    parts = {
        "at every instant": (below == 0, shown),
        "averaged over each nutation": (average > 0, f"least average {decimal(average, 3)} m/s"),
    }
    return statements("positive", parts), {
        "first": max((t for t in zeros if t < climb.middle), default=climb.begin),
        "last": min((t for t in zeros if t > climb.middle), default=climb.end),
    }


@claim("QUAL-23", control="refuted", phases=("climb", "synchronisation"))
def oscillations_of_nu_x(
    phases: tuple[str, str] = ("synchronisation", "climb"), run: Run = REFERENCE
) -> Grounds:
    """In the climb the oscillations of nu_x grow.

    Sec. 2.1: "Oscillations of nu_x(t) also increase"
    Definition: {OSCILLATION}
    Note: From the phase of {phases[0]} to that of {phases[1]}.
    """
    first, then = (run.largest_swing("nu_x", getattr(run, phase)) for phase in phases)
    shown = f"from {decimal(first, 3)} to {decimal(then, 3)} m/s"
    return statement(then > first, "increase", shown)


@claim("QUAL-39", control="refuted", name="nu_y")
def mean_of_nu_x(name: str = "nu_x", run: Run = REFERENCE) -> Grounds:
    """In the climb the mean of nu_x is slightly negative.

    Sec. 2.1: "the mean value of nu_x becomes slightly negative"
    Definition: {OSCILLATION}; slightly: the mean over the climb is below a fifth of the largest
    oscillation
    Note: Before the climb the mean is {before:3} m/s.
    """
    average, swing = run.mean(name, run.climb), run.largest_swing(name, run.climb)
    slightly = -swing / 5 < average < 0
    before = run.mean(name, run.synchronisation)
    shown = f"{decimal(average, 4)} m/s"
    return statement(slightly, "slightly negative", shown), {"before": before}


@claim("QUAL-24", finding="NUM-05", control="rounded", printed="7.84")
def crossing_from_above(printed: str = "7.86", run: Run = REFERENCE) -> Grounds:
    """At 7.86 s, at the end of the climb, nu_y crosses nu_x from above.

    Sec. 2.1: "When the climbing is finished at t_{theta≈pi}≈7.86s the graph of nu_y again crosses
    the graph of nu_x from above"
    Definition: the last event nu_y = nu_x at which nu_y - nu_x falls
    Note: nu_y crosses nu_x from above at {falling} s; the last crossing is final. Only the time is
    wrong, like that of NUM-05.
    """
    last = run.confirm(lambda run: rows_of(run, "nu_crossing").query("direction < 0")["t"].iloc[-1])
    falling = tuple(decimal(t, 5) for t in _crossings(run, rising=False, early=False))
    return part.about(printed, last, "s"), {"falling": falling}


@claim("QUAL-30", control="refuted", higher="nu_y", lower="nu_x")
def minima_after_the_climb(
    higher: str = "nu_x", lower: str = "nu_y", run: Run = REFERENCE
) -> Grounds:
    """After the climb the minima of nu_y lie below those of nu_x.

    Sec. 2.1: "minima of nu_y(t) become consistently lower than minima of nu_x(t)"
    Definition: least values in each nutation from the last crossing to {LATER} s; {PERIOD}
    Note: From {last:5} s on.
    """
    last = _crossings(run, rising=False, early=False)[-1]
    longer = Run(variant(run.scene, until=LATER))
    above, shown = _count_above(higher, lower, longer, Span(last, float(LATER)))
    words = f"minima of {lower} below those of {higher}"
    return statement(above, words, shown), {"last": last}


def _crossings(run: Run, *, early: bool, rising: bool | None = None) -> list[float]:
    """The times of nu_y = nu_x before or after mid-climb, where nu_y - nu_x rises or falls."""
    return [
        float(t)
        for t, direction in run.events("nu_crossing")[["t", "direction"]].to_numpy()
        if (t < run.climb.middle) == early and (rising is None or (direction > 0) == rising)
    ]


def _count_above(higher: str, lower: str, run: Run, span: Span) -> tuple[bool, str]:
    """Compare the least values of two quantities in each nutation, and count."""
    spans = run.nutations(span)
    highs, lows = (run.least_in(spans, name) for name in (higher, lower))
    above = sum(high > low for high, low in zip(highs, lows, strict=True))
    return 0 < above == len(spans), f"in {above} of {len(spans)} nutations"


def _largest_size(name: str, run: Run, span: Span) -> float:
    return float(abs(run.extrema(name, span)[1]).max())


@claim("NUM-02", rule="misprint", control="rounded", behind="lambda_thres")
def lambda_is_twice_itself(behind: str = "lambda", run: Run = REFERENCE) -> Grounds:
    """The universal behaviour belongs to solutions whose lambda is about twice something.

    Sec. 2.1: "inverting solutions with lambda≈2lambda"
    Definition: the ratio of lambda of the reference start and the quantity after the 2
    Note: No lambda is twice itself.
    """
    values = run.thresholds.quantities

    def compare(name: str) -> Part:
        ours, other = values["lambda"], values[name]
        ratio = Value.of(ours.value / other.value, ours.independent / other.independent)
        return replace(part.rounds_to("2", ratio), printed=f"lambda about 2 {name}")

    return part.misprint(compare, behind, "lambda_thres")


@claim("NUM-14", control="refuted", printed="0.3")
def weight(printed: str = "0.2", run: Run = REFERENCE) -> Grounds:
    """The weight of the toy top is 0.2 (N).

    Fig. 3, caption: "oscillates about mg=0.2"
    Definition: m g of the toy top, N
    Note: m g = 0.02 kg times 9.82 m/s^2; the caption omits the unit.
    """
    return part.rounds_to(printed, run.weight, "N")


@claim("NUM-35", control="refuted", printed="154")
def spin_at_the_start(printed: str = "155", run: Run = REFERENCE) -> Grounds:
    """The spin about the axis is 155 rad/s at the start.

    Sec. 2.1: "initially started with strong spin (here psi_dot(0)=155 rad/s)"
    Definition: psi_dot = omega_3 - phi_dot cos(theta)
    Note: It equals omega_3(0), because phi_dot(0) = 0.
    """
    return part.rounds_to(printed, run.at("psi_dot", "0"), "rad/s")


@claim("SUM-01")
def spelling() -> Grounds:
    """Wording and spelling of the text.

    Sec. 2.1, 2.2, Sec. 3: "sychronisation, monotononous, They asks"
    Note: Nothing to compute. To correct: sychronisation, synchronatisation (synchronisation),
    monotononous, monotonously (monotonically), transfered (transferred), 'the minimal of nu_y'
    (minima), 'lambda approx 2 lambda' (2 lambda_thres), 'features that does not', 'its derivative
    satisfy', 'related to of', 'They asks', 'plot b show'.
    """
    return part.untestable("as quoted")


@claim("SUM-02", control="refuted", run=Run(variant(theta="1.2")))
def spin_as_a_sum(run: Run = REFERENCE, phi_dot: str = "200") -> Grounds:
    """At the start omega_3 is about phi_dot + psi_dot.

    Sec. 2.1: "initially omega_3(0)≈phi_dot(0)+psi_dot(0)"
    Definition: for |phi_dot(0)| up to 200 rad/s, the range of section 2.2, relative to omega_3(0)
    Note: omega_3 = psi_dot + phi_dot cos theta; at the reference start phi_dot(0) = 0 and both are
    equal.
    """
    start = run.loaded.start
    error = float(phi_dot) * (1 - math.cos(float(start.theta.offset)))
    return part.approximate("phi_dot + psi_dot", error, start.omega_3, "off by at most")


@claim("SUM-08", control="refuted", run=Run(variant(theta="1.2")))
def cosine_of_the_start(run: Run = REFERENCE) -> Grounds:
    """At the start cos theta is about 1.

    Sec. 2.1: "since theta(0)=0.1 and cos theta≈1"
    Note: omega_3 differs from phi_dot + psi_dot by phi_dot (1 - cos theta).
    """
    cosine = math.cos(float(run.loaded.start.theta.offset))
    return part.approximate("cos theta = 1", 1 - cosine, 1)
