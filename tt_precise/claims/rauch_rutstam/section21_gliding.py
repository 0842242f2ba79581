"""Section 2.1: gliding of the reference solution, and the numbers of its start."""

from __future__ import annotations

import math

from tt_precise.claims import verdicts as v
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.evidence.run import REFERENCE, Run, Span, variant
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.rauch_rutstam.section1_potential import CONDITION, CORRECT_CONDITION
from tt_precise.claims.verdicts import Finding
from tt_precise.runtime.values import Check
from tt_precise.scene.scene import load_scene

claim = claims_of(RAUCH_RUTSTAM, "2.1")
LAST_FALLING = "name == 'nu_crossing' and direction < 0"
LATER = "10"  # s, to see enough nutations behind the climb
PERIOD = "a nutation period is the time from one maximum of theta to the next"


@claim(
    "TH-19",
    counterexample={"printed": CORRECT_CONDITION},
    quote="1-alpha^2<gamma<1 ... They satisfy the rationality condition",
)
def toy_satisfies_the_condition(printed: str = CONDITION, run: Run = REFERENCE) -> Finding:
    """The toy has 1 - alpha^2 < gamma < 1 and satisfies the printed rationality condition."""
    body = run.loaded.body
    gamma, sigma, alpha = body.gamma, body.sigma, body.alpha
    between = 1 - alpha**2 < gamma < 1

    def satisfied(text: str) -> Check:
        value = f.read(text, {"gamma": gamma, "alpha": alpha})
        both = f"m R^2/I3 = {v.decimal(sigma, 6)}, {text} = {v.decimal(value, 6)}"
        return v.statement(between and sigma == value, f"m R^2/I3 = {text}", both)

    return v.misprint(
        map(satisfied, (printed, CORRECT_CONDITION)),
        f"m R^2/I3 = {CORRECT_CONDITION}",
        f"Exact: gamma = {gamma} lies between 1 - alpha^2 = {1 - alpha**2} and 1.",
        v.EXACT,
    )


@claim(
    "NUM-01",
    counterexample={"run": Run(variant(omega_3="200"))},
    quote="initial conditions (IC) with lambda approx 2 lambda_thres",
)
def reference_lambda(printed: str = "2", run: Run = REFERENCE) -> Finding:
    """lambda of the reference start is about twice the threshold."""
    known = run.thresholds.quantities
    ratio = known["lambda"].value / known["lambda_thres"].value
    check = known["lambda"].independent / known["lambda_thres"].independent
    return v.all_of(
        v.about(printed, v.Settled.of(ratio, check), "lambda_thres"),
        f"lambda = {v.decimal(known['lambda'].value, 12)} kg m^3/s and lambda_thres = "
        f"{v.decimal(known['lambda_thres'].value, 12)} kg m^3/s.",
    )


@claim(
    "NT-01",
    counterexample=None,
    quote="realistic values ... close to the parameter values used ... by other authors",
)
def realistic_values() -> Finding:
    """The parameters are those of a typical toy, close to other authors' values."""
    body = load_scene("reference").body
    inertia = body.m * body.R**2
    return v.all_of(
        v.untestable("realistic, close to [Coh, Ued]"),
        'The paper does not have the values of the cited authors, and "close" has no measure. The '
        f"body is possible: I1 = {v.decimal(body.I1 / inertia, 4)}, I3 = "
        f"{v.decimal(body.I3 / inertia, 4)} m R^2 with I3 < 2 I1, "
        f"m = {v.decimal(1000 * body.m, 2)} g, R = {v.decimal(100 * body.R, 2)} cm. mu = 0.3 lacks "
        "its unit, s/m.",
    )


@claim(
    "NUM-36",
    where="Sec. 2.1; Summary d)",
    counterexample={"orders": (3.5, 4.5), "summary": (3.5, 4.5)},
    definition="decimal logarithm of the ratio of nu_y in the climb (initiation to ending time, "
    "definition A) to nu_y before it: of the largest values of |nu_y|, of the means, and of the "
    "largest value in the climb to the first local maximum; 1-2 orders: 1 to 2; about two: 1.5 to "
    "2.5",
    quote="its values increase by about two orders of magnitude; by 1-2 orders of magnitude",
)
def growth_of_nu_y(
    orders: tuple[float, float] = (1.5, 2.5),
    summary: tuple[float, float] = (1, 2),
    run: Run = REFERENCE,
) -> Finding:
    """In the climb nu_y is one to two (summary), or about two (section 2.1), orders larger."""
    before, during = run.synchronisation, run.climb
    first = next(value for value in run.extrema("nu_y")[1] if value > 0)
    peak, earlier = (_largest_size("nu_y", run, span) for span in (during, before))
    means = [run.mean("nu_y", span) for span in (during, before)]
    ratios = {
        "largest values": peak / earlier,
        "means": means[0] / means[1],
        "largest against the first maximum": peak / first,
    }
    checks = {}
    for what, (low, high) in (("Summary", summary), ("section 2.1", orders)):
        for name, ratio in ratios.items():
            size = math.log10(ratio)
            shown = f"factor {v.decimal(ratio, 4)}, {size:.2f} orders"
            checks[f"{what}, {name}"] = v.statement(
                low <= size <= high, f"{low} to {high} orders", shown
            )
    return v.readings(checks, "The two sentences state different factors.")


@claim(
    "QUAL-19",
    counterexample={"larger": "nu_y", "smaller": "nu_x"},
    definition="initially: until nu_x first vanishes; larger: no crossing of the two before; "
    "close to 0: the mean of nu_y is below a fifth of that of nu_x and it changes sign",
    quote="initially nu_x is positive and has larger value than nu_y that oscillates close to 0",
)
def at_first(larger: str = "nu_x", smaller: str = "nu_y", run: Run = REFERENCE) -> Finding:
    """At first nu_x is positive and above nu_y, which oscillates close to zero."""
    until = float(run.events(f"{larger}_zero")["t"].iloc[0])
    crossing = float(run.events("nu_crossing")["t"].iloc[0])
    span = Span(0.0, until)
    means = {name: run.mean(name, span) for name in (larger, smaller)}
    changes = len(run.zeros(smaller, span))
    at, until_crossing = f"until {v.decimal(until, 5)} s", f"until {v.decimal(crossing, 5)} s"
    size = _largest_size(smaller, run, run.synchronisation)
    return v.all_of(
        {
            f"{larger} > 0": v.statement(means[larger] > 0, "positive", at),
            f"{larger} > {smaller}": v.statement(crossing > until, "larger", until_crossing),
            f"{smaller} close to 0": v.statement(
                changes > 1 and abs(means[smaller]) < means[larger] / 5,
                "oscillates close to 0",
                f"mean {v.decimal(means[smaller], 3)} against {v.decimal(means[larger], 3)} m/s "
                f"{at}, {changes} changes of sign",
            ),
        },
        f"The oscillation of {smaller} grows before the climb, to {v.decimal(size, 2)} m/s.",
    )


@claim(
    "QUAL-20",
    where="Sec. 2.1; Summary d)",
    counterexample={"printed": "3.5"},
    definition="events nu_y = nu_x at which nu_y - nu_x rises, before mid-climb",
    quote="the graph of nu_y(t) crosses the graph of nu_x(t) at about 3.2 s; from below",
)
def crossing_from_below(printed: str = "3.2", run: Run = REFERENCE) -> Finding:
    """nu_y crosses nu_x from below at the initiation time."""
    crossings = _crossings(run, rising=True, early=True)
    nearest = min(crossings, key=lambda t: abs(t - run.climb.begin))
    every = _crossings(run, early=True)
    return v.readings(
        {
            "the crossing nearest to t_init": v.about(printed, nearest, "s"),
            "the last crossing": v.about(printed, crossings[-1], "s"),
            "the first crossing": v.about(printed, crossings[0], "s"),
        },
        f"nu_y crosses nu_x {len(every)} times, both ways, between {v.decimal(every[0], 5)} "
        f"and {v.decimal(every[-1], 5)} s; from the last one on nu_y stays above until "
        f"{v.decimal(_crossings(run, early=False)[0], 5)} s.",
    )


@claim(
    "QUAL-21",
    counterexample={"higher": "nu_x", "lower": "nu_y"},
    definition=f"{PERIOD}; the least values of nu_x and nu_y in each period of the climb",
    quote="from this moment the minimal of nu_y(t) are consistently higher than the minima of nu_x",
)
def minima_in_the_climb(higher: str = "nu_y", lower: str = "nu_x", run: Run = REFERENCE) -> Finding:
    """During the climb the minima of nu_y lie above those of nu_x ("minimal": minima)."""
    spans = run.nutations(run.climb)
    above = _count_above(higher, lower, spans, run)
    check = v.statement(
        0 < above == len(spans),
        f"minima of {higher} above those of {lower}",
        f"in {above} of {len(spans)} nutations of the climb",
    )
    return v.all_of(
        {"in every nutation": check},
        'The sentence has "minimal of nu_y(t)" for "minima of nu_y(t)".',
    )


@claim(
    "QUAL-22",
    counterexample={"name": "nu_x"},
    definition=f"climb: initiation to ending time, definition A; {PERIOD}",
    quote="during the climbing phase the oscillatory function nu_y(t) is positive",
)
def positive_in_the_climb(name: str = "nu_y", run: Run = REFERENCE) -> Finding:
    """nu_y is positive during the climb."""
    climb = run.climb
    below = run.share_below_zero(name, climb)
    zeros = run.zeros(name, climb)
    least = min(run.least_in([climb], name))
    average = min(run.mean(name, span) for span in run.nutations(climb))
    early = [t for t in zeros if t < climb.middle]
    late = [t for t in zeros if t > climb.middle]
    parts = {
        "at every instant": (
            below == 0,
            f"negative for {100 * below:.3g} % of the climb, down to {v.decimal(least, 4)} m/s",
        ),
        "averaged over each nutation": (average > 0, f"least average {v.decimal(average, 3)} m/s"),
    }
    return v.readings(
        v.statements("positive", parts),
        "Positive at every instant only between "
        f"{v.decimal(max(early), 5)} and {v.decimal(min(late), 5)} s."
        if late
        else "It changes sign throughout.",
    )


@claim(
    "QUAL-23",
    counterexample={"name": "nu_y"},
    definition="oscillation: largest distance between consecutive extrema, among which the ends of "
    "both spans are; slightly: the mean over the climb is below a fifth of the largest oscillation",
    quote="oscillations of nu_x(t) also increase and the mean value becomes slightly negative",
)
def mean_of_nu_x(name: str = "nu_x", run: Run = REFERENCE) -> Finding:
    """In the climb the oscillations of nu_x grow, and their mean is slightly negative."""
    before, during = run.synchronisation, run.climb
    first, then = (run.largest_swing(name, span) for span in (before, during))
    average = run.mean(name, during)
    grown = v.statement(
        then > first, "increase", f"from {v.decimal(first, 3)} to {v.decimal(then, 3)} m/s"
    )
    mean = v.statement(-then / 5 < average < 0, "slightly negative", f"{v.decimal(average, 4)} m/s")
    return v.all_of(
        {"oscillations": grown, "mean": mean},
        f"Before the climb the mean is {v.decimal(run.mean(name, before), 3)} m/s.",
    )


@claim(
    "QUAL-24",
    counterexample={"printed": "7.84"},
    definition="the last event nu_y = nu_x at which nu_y - nu_x falls; least values in each "
    f"nutation after it; {PERIOD}",
    quote="at about 7.86 s nu_y again crosses nu_x from above and minima of nu_y become lower",
)
def crossing_from_above(printed: str = "7.86", run: Run = REFERENCE) -> Finding:
    """At the end of the climb nu_y crosses nu_x from above; afterwards its minima are lower."""
    falling = _crossings(run, rising=False, early=False)
    last = run.settled(lambda solution: solution.events.query(LAST_FALLING)["t"].iloc[-1])
    longer = Run(variant(run.scene, until=LATER))
    spans = longer.nutations(Span(falling[-1], float(LATER)))
    lower = _count_above("nu_x", "nu_y", spans, longer)
    shown = ", ".join(v.decimal(t, 5) for t in falling)
    return v.all_of(
        {
            "time": v.about(printed, last, "s"),
            "minima of nu_y": v.statement(
                0 < lower == len(spans),
                "lower than those of nu_x",
                f"in {lower} of {len(spans)} nutations from there to {LATER} s",
            ),
        },
        f"nu_y crosses nu_x from above at {shown} s; the last crossing is final.",
    )


def _crossings(run: Run, *, early: bool, rising: bool | None = None) -> list[float]:
    events = run.events("nu_crossing")
    return [
        float(t)
        for t, direction in zip(events["t"], events["direction"], strict=True)
        if (t < run.climb.middle) == early and (rising is None or (direction > 0) == rising)
    ]


def _count_above(higher: str, lower: str, spans: list[Span], run: Run) -> int:
    highs, lows = (run.least_in(spans, name) for name in (higher, lower))
    return sum(high > low for high, low in zip(highs, lows, strict=True))


def _largest_size(name: str, run: Run, span: Span) -> float:
    return float(abs(run.extrema(name, span)[1]).max())


@claim(
    "NUM-02",
    counterexample={"behind": "lambda_thres"},
    definition="the ratio of lambda of the reference start and the quantity after the 2",
    quote="inverting solutions with lambda about 2 lambda",
)
def lambda_is_twice_itself(behind: str = "lambda", run: Run = REFERENCE) -> Finding:
    """The universal behaviour belongs to solutions whose lambda is about twice something."""
    known = run.thresholds.quantities
    ours = known["lambda"]
    factors = {
        name: v.Settled.of(ours.value / threshold.value, ours.independent / threshold.independent)
        for name, threshold in known.items()
        if name in ("lambda", "lambda_thres")
    }
    return v.misprint(
        (v.rounds_to("2", factors[name]) for name in (behind, "lambda_thres")),
        "lambda about 2 lambda_thres",
        "No lambda is twice itself.",
    )


@claim(
    "NUM-14",
    where="Fig. 3, caption",
    counterexample={"printed": "0.3"},
    definition="m g of the toy top, N",
    quote="oscillates about mg = 0.2",
)
def weight(printed: str = "0.2", run: Run = REFERENCE) -> Finding:
    """The weight of the toy top is 0.2 (N)."""
    return v.all_of(
        v.rounds_to(printed, run.weight, "N"),
        "m g = 0.02 kg times 9.82 m/s^2; the caption omits the unit.",
    )


@claim(
    "NUM-35",
    quote="initially started with strong spin (here psi_dot(0) = 155 rad/s)",
    counterexample={"printed": "154"},
    definition="psi_dot = omega_3 - phi_dot cos(theta)",
)
def spin_at_the_start(printed: str = "155", run: Run = REFERENCE) -> Finding:
    """The spin about the axis is 155 rad/s at the start."""
    return v.all_of(
        v.rounds_to(printed, run.at("psi_dot", "0"), "rad/s"),
        "It equals omega_3(0), because phi_dot(0) = 0.",
    )


@claim(
    "SUM-01",
    where="Sec. 2.1, 2.2, Sec. 3",
    counterexample=None,
    quote="sychronisation, monotononous, They asks",
)
def spelling() -> Finding:
    """Wording and spelling of the text."""
    return v.all_of(
        v.untestable("as quoted"),
        "Nothing to compute. To correct: sychronisation, synchronatisation (synchronisation), "
        "monotononous, monotonously (monotonically), transfered (transferred), 'the minimal of "
        "nu_y' (minima), 'lambda approx 2 lambda' (2 lambda_thres), 'features that does not', 'its "
        "derivative satisfy', 'related to of', 'They asks', 'plot b show'.",
    )


@claim(
    "SUM-02",
    counterexample={"run": Run(variant(theta="1.2"))},
    definition="for |phi_dot(0)| up to 200 rad/s, the range of section 2.2, relative to omega_3(0)",
    quote="omega_3(0) approx phi_dot(0)+psi_dot(0) since ... cos theta approx 1",
)
def spin_as_a_sum(run: Run = REFERENCE, phi_dot: str = "200") -> Finding:
    """At the start omega_3 is about phi_dot + psi_dot, because cos theta is about 1."""
    start = run.loaded.start
    cosine = math.cos(float(start.theta.offset))
    error = float(phi_dot) * (1 - cosine)
    return v.all_of(
        {
            "omega_3": v.approximate("phi_dot + psi_dot", error, start.omega_3, "off by at most"),
            "cos theta": v.approximate("cos theta = 1", 1 - cosine, 1),
        },
        "omega_3 = psi_dot + phi_dot cos theta; at the reference start phi_dot(0) = 0 and both are "
        "equal.",
    )
