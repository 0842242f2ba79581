"""Section 2.1: the gliding velocities nu_x and nu_y, and the ranges of nu_x, nu_y, theta_dot."""

from __future__ import annotations

import math
from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.evidence import reference_series as series
from tt_precise.claims.measured import Settled, decimal, fraction_of, measured_text
from tt_precise.claims.verdicts import Finding, about, all_of, in_range, readings, statement
from tt_precise.integration import Trajectory
from tt_precise.runtime.arithmetic import Scalar

SECTION = "Sec. 2.1"
RANGES = (
    "least and largest value over 0..8 s: extrema found as events, values in double-double with "
    "the digits that extended arithmetic confirms"
)
LATER = "10"  # s, to see enough nutations behind the climb
PERIOD = "a nutation period is the time from one maximum of theta to the next"


@claim(
    "NUM-11", quote="nu_x(t) in [-0.3, 0.3]", where="Sec. 2.2", definition=RANGES,
    control={"printed": "0.2"},
)  # fmt: skip
def range_of_nu_x(printed: str = "0.3", scene: SceneLike = "reference") -> Finding:
    """The reference solution's nu_x varies within -0.3 to 0.3 m/s."""
    return _range("nu_x", printed, scene, "m/s")


@claim(
    "NUM-12", quote="nu_y(t) in [-0.8, 0.8]", where="Sec. 2.2", definition=RANGES,
    control={"printed": "0.9"},
)  # fmt: skip
def range_of_nu_y(printed: str = "0.8", scene: SceneLike = "reference") -> Finding:
    """The reference solution's nu_y varies within -0.8 to 0.8 m/s."""
    return _range("nu_y", printed, scene, "m/s")


@claim(
    "NUM-13", quote="theta_dot(t) in [-15, 15]", where="Sec. 2.2", definition=RANGES,
    control={"printed": "9"},
)  # fmt: skip
def range_of_theta_dot(printed: str = "15", scene: SceneLike = "reference") -> Finding:
    """The reference solution's theta_dot varies within -15 to 15 rad/s."""
    return _range("theta_dot", printed, scene, "rad/s")


def _range(name: str, printed: str, scene: SceneLike, unit: str) -> Finding:
    low = series.extreme(name, scene, largest=False)
    high = series.extreme(name, scene, largest=True)
    larger = max(low, high, key=lambda one: abs(fraction_of(one)))
    size = Settled(abs(larger.value), larger.digits)
    found = f"{measured_text(low)} to {measured_text(high)} {unit}"
    inside = (in_range(f"-{printed}", printed, one, unit).holds for one in (low, high))
    shown = f"-{printed} to {printed} {unit}"
    excess = 100 * (float(size.value) / float(printed) - 1)
    return readings(
        {
            "an interval that contains all values": statement(
                all(inside), printed=shown, measured=found
            ),
            "the largest absolute value, as printed": about(printed, size, unit),
        },
        f"The largest absolute value is {abs(excess):.1f} % "
        f"{'above' if excess > 0 else 'below'} the printed bound; the range is not symmetric.",
    )


@claim(
    "NUM-36",
    quote="its values increase by about two orders of magnitude; by 1-2 orders of magnitude",
    where="Sec. 2.1; Summary d)",
    definition="decimal logarithm of the ratio of nu_y in the climb (initiation to ending time, "
    "definition A) to nu_y before it: of the largest values of |nu_y|, of the means, and of the "
    "largest value in the climb to the first local maximum; 1-2 orders: 1 to 2; about two: 1.5 to "
    "2.5",
    control={"orders": (3.5, 4.5), "summary": (3.5, 4.5)},
)
def growth_of_nu_y(
    orders: tuple[float, float] = (1.5, 2.5),
    summary: tuple[float, float] = (1, 2),
    scene: SceneLike = "reference",
) -> Finding:
    """In the climb nu_y is one to two (summary), or about two (section 2.1), orders larger."""
    before, during = series.synchronisation(scene), series.climb(scene)
    first = next(value for value in series.extrema("nu_y", scene)[1] if value > 0)
    peak, earlier = (_largest_size("nu_y", scene, span) for span in (during, before))
    means = [series.mean("nu_y", scene, span) for span in (during, before)]
    ratios = {
        "largest values": peak / earlier,
        "means": means[0] / means[1],
        "largest against the first maximum": peak / first,
    }
    checks = {}
    for what, bounds in (("Summary", summary), ("section 2.1", orders)):
        for name, ratio in ratios.items():
            size = math.log10(ratio)
            checks[f"{what}, {name}"] = statement(
                bounds[0] <= size <= bounds[1],
                printed=f"{bounds[0]} to {bounds[1]} orders",
                measured=f"factor {decimal(ratio, 4)}, {size:.2f} orders",
            )
    return readings(checks, "The two sentences state different factors.")


@claim(
    "QUAL-19",
    quote="initially nu_x is positive and has larger value than nu_y that oscillates close to 0",
    where=SECTION,
    definition="initially: until nu_x first vanishes; larger: no crossing of the two before; "
    "close to 0: the mean of nu_y is below a fifth of that of nu_x and it changes sign",
    control={"larger": "nu_y", "smaller": "nu_x"},
)
def at_first(
    larger: str = "nu_x", smaller: str = "nu_y", scene: SceneLike = "reference"
) -> Finding:
    """At first nu_x is positive and above nu_y, which oscillates close to zero."""
    until = float(evidence.times_of(f"{larger}_zero", scene)["t"].iloc[0])
    crossing = float(evidence.times_of("nu_crossing", scene)["t"].iloc[0])
    span = series.Span(0.0, until)
    means = {name: series.mean(name, scene, span) for name in (larger, smaller)}
    changes = len(series.zeros(smaller, scene, span))
    at = decimal(until, 5)
    size = _largest_size(smaller, scene, series.synchronisation(scene))
    return all_of(
        {
            f"{larger} > 0": statement(
                means[larger] > 0, printed="positive", measured=f"until {at} s"
            ),
            f"{larger} > {smaller}": statement(
                crossing > until, printed="larger", measured=f"until {decimal(crossing, 5)} s"
            ),
            f"{smaller} close to 0": statement(
                changes > 1 and abs(means[smaller]) < means[larger] / 5,
                printed="oscillates close to 0",
                measured=f"mean {decimal(means[smaller], 3)} against {decimal(means[larger], 3)} "
                f"m/s until {at} s, {changes} changes of sign",
            ),
        },
        f"The oscillation of {smaller} grows before the climb, to {decimal(size, 2)} m/s.",
    )


@claim(
    "QUAL-20",
    quote="the graph of nu_y(t) crosses the graph of nu_x(t) at about 3.2 s; from below",
    where="Sec. 2.1; Summary d)",
    definition="events nu_y = nu_x at which nu_y - nu_x rises, before mid-climb",
    control={"printed": "3.5"},
)
def crossing_from_below(printed: str = "3.2", scene: SceneLike = "reference") -> Finding:
    """nu_y crosses nu_x from below at the initiation time."""
    crossings = _crossings(scene, rising=True, early=True)
    start = series.climb(scene).begin
    nearest = min(crossings, key=lambda t: abs(t - start))
    every = _crossings(scene, early=True)
    return readings(
        {
            "the crossing nearest to t_init": about(printed, nearest, "s"),
            "the last crossing": about(printed, crossings[-1], "s"),
            "the first crossing": about(printed, crossings[0], "s"),
        },
        f"There is not one crossing but {len(every)}, both ways, between {decimal(every[0], 5)} "
        f"and {decimal(every[-1], 5)} s; from the last one on nu_y stays above.",
    )


@claim(
    "QUAL-21",
    quote="from this moment the minimal of nu_y(t) are consistently higher than the minima of nu_x",
    where=SECTION,
    definition=f"{PERIOD}; the least values of nu_x and nu_y in each period of the climb",
    control={"higher": "nu_x", "lower": "nu_y"},
)
def minima_in_the_climb(
    higher: str = "nu_y", lower: str = "nu_x", scene: SceneLike = "reference"
) -> Finding:
    """During the climb the minima of nu_y lie above those of nu_x ("minimal": minima)."""
    spans = series.nutations(scene, series.climb(scene))
    above = _count_above(higher, lower, spans, scene)
    return all_of(
        {
            "in every nutation": statement(
                0 < above == len(spans),
                printed=f"minima of {higher} above those of {lower}",
                measured=f"in {above} of {len(spans)} nutations of the climb",
            )
        },
        'The sentence has "minimal of nu_y(t)" for "minima of nu_y(t)".',
    )


@claim(
    "QUAL-22",
    quote="during the climbing phase the oscillatory function nu_y(t) is positive",
    where=SECTION,
    definition=f"climb: initiation to ending time, definition A; {PERIOD}",
    control={"name": "nu_x"},
)
def positive_in_the_climb(name: str = "nu_y", scene: SceneLike = "reference") -> Finding:
    """nu_y is positive during the climb."""
    climb = series.climb(scene)
    below = series.share_below_zero(name, scene, climb)
    zeros = series.zeros(name, scene, climb)
    least = min(series.least_in([climb], name, scene))
    spans = series.nutations(scene, climb)
    averages = [series.mean(name, scene, span) for span in spans]
    middle = climb.begin + climb.length / 2
    early = [t for t in zeros if t < middle]
    late = [t for t in zeros if t > middle]
    between = f"between {decimal(max(early), 5)} and {decimal(min(late), 5)} s" if late else ""
    return readings(
        {
            "at every instant": statement(
                below == 0,
                printed="positive",
                measured=f"negative for {100 * below:.3g} % of the climb, down to "
                f"{decimal(least, 4)} m/s",
            ),
            "averaged over each nutation": statement(
                min(averages) > 0,
                printed="positive",
                measured=f"least average {decimal(min(averages), 3)} m/s",
            ),
        },
        f"Positive at every instant only {between}." if between else "It changes sign throughout.",
    )


@claim(
    "QUAL-23",
    quote="oscillations of nu_x(t) also increase and the mean value becomes slightly negative",
    where=SECTION,
    definition="oscillation: largest distance between consecutive extrema; slightly: the mean over "
    "the climb is below a fifth of the largest oscillation",
    control={"name": "nu_y"},
)
def mean_of_nu_x(name: str = "nu_x", scene: SceneLike = "reference") -> Finding:
    """In the climb the oscillations of nu_x grow, and their mean is slightly negative."""
    before, during = series.synchronisation(scene), series.climb(scene)
    swings = [_largest_swing(name, scene, span) for span in (before, during)]
    average = series.mean(name, scene, during)
    return all_of(
        {
            "oscillations": statement(
                swings[1] > swings[0],
                printed="increase",
                measured=f"from {decimal(swings[0], 3)} to {decimal(swings[1], 3)} m/s",
            ),
            "mean": statement(
                -swings[1] / 5 < average < 0,
                printed="slightly negative",
                measured=f"{decimal(average, 4)} m/s",
            ),
        },
        f"Before the climb the mean is {decimal(series.mean(name, scene, before), 3)} m/s.",
    )


@claim(
    "QUAL-24",
    quote="at about 7.86 s nu_y again crosses nu_x from above and minima of nu_y become lower",
    where=SECTION,
    definition="the last event nu_y = nu_x at which nu_y - nu_x falls; least values in each "
    f"nutation after it; {PERIOD}",
    control={"printed": "7.84"},
)
def crossing_from_above(printed: str = "7.86", scene: SceneLike = "reference") -> Finding:
    """At the end of the climb nu_y crosses nu_x from above, and its minima lie lower then."""
    falling = _crossings(scene, rising=False, early=False)
    last = evidence.settled(_last_falling_crossing, scene)
    longer = evidence.variant(scene, until=LATER)
    spans = series.nutations(longer, series.Span(falling[-1], float(LATER)))
    lower = _count_above("nu_x", "nu_y", spans, longer)
    shown = ", ".join(decimal(t, 5) for t in falling)
    return all_of(
        {
            "time": about(printed, last, "s"),
            "minima of nu_y": statement(
                0 < lower == len(spans),
                printed="lower than those of nu_x",
                measured=f"in {lower} of {len(spans)} nutations from there to {LATER} s",
            ),
        },
        f"nu_y crosses nu_x from above at {shown} s; the last one is final.",
    )


def _crossings(scene: SceneLike, *, early: bool, rising: bool | None = None) -> list[float]:
    events = evidence.times_of("nu_crossing", scene)
    climb = series.climb(scene)
    middle = climb.begin + climb.length / 2
    return [
        float(t)
        for t, direction in zip(events["t"], events["direction"], strict=True)
        if (t < middle) == early and (rising is None or (direction > 0) == rising)
    ]


def _last_falling_crossing(run: Trajectory) -> Scalar:
    events = run.events
    return events["t"][(events["name"] == "nu_crossing") & (events["direction"] < 0)].iloc[-1]


def _count_above(higher: str, lower: str, spans: list[series.Span], scene: SceneLike) -> int:
    highs, lows = (series.least_in(spans, name, scene) for name in (higher, lower))
    return sum(high > low for high, low in zip(highs, lows, strict=True))


def _largest_size(name: str, scene: SceneLike, span: series.Span) -> float:
    return float(abs(series.extrema(name, scene, span)[1]).max())


def _largest_swing(name: str, scene: SceneLike, span: series.Span) -> float:
    values = series.extrema(name, scene, span)[1]
    return max(abs(b - a) for a, b in pairwise(values))
