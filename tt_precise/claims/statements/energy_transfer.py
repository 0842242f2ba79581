"""Section 2.3: the three parts of the energy, and its rates (Figures 4 and 5)."""

from __future__ import annotations

from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.evidence import reference_series as series
from tt_precise.claims.measured import decimal, measured_text
from tt_precise.claims.verdicts import Finding, all_of, judged, readings, statement

SECTION = "Sec. 2.3"
PARTS = ("E_trans", "E_rot", "E_pot")


@claim(
    "FIG-01",
    quote="E_trans, E_rot and E_pot add up to the total energy E(t), monotonically decreasing",
    where="Sec. 2.3, Fig. 4",
    definition="E at 8 s from the sum of its parts there, against E(0) minus the work of friction "
    "(the integral of mu g_n v_A^2, Gauss's rule between extrema); monotonous: no event where E "
    "turns, and its rate has no zero",
    control={"parts": ("E_trans", "E_rot")},
)
def parts_of_the_energy(parts: tuple[str, ...] = PARTS, scene: SceneLike = "reference") -> Finding:
    """The three parts add up to the energy, which decreases monotonously."""
    span = series.whole(scene)
    first, last = (
        sum(column)
        for column in zip(
            *(series.columns([name], list(span), scene)[name] for name in parts), strict=True
        )
    )
    whole = series.columns(["E"], list(span), scene)["E"]
    work = series.mean("E_dot", scene, span) * span.length
    off = abs(last - (whole[0] + work)) / whole[0] + abs(first / whole[0] - 1)
    rise, fall = series.rises_and_falls("E", scene)
    turns = len(series.zeros("E_dot", scene))
    return all_of(
        {
            "sum": statement(
                off < 1e-9,
                printed="parts add up to E",
                measured=f"off by {decimal(off, 1)} E(0) from E(0) minus the work of friction",
            ),
            "monotony": statement(
                rise == 0 and turns == 0,
                printed="monotonically decreasing",
                measured=f"falls by {decimal(fall, 12)} J, and "
                + (f"rises by {decimal(rise, 3)} J" if rise else "never rises"),
            ),
        },
        "The work of friction comes from the contact force alone, so that it does not know the "
        "parts.",
    )  # fmt: skip


@claim(
    "FIG-02",
    quote="the potential energy E_pot (light blue line) increases",
    where=SECTION,
    definition="between 0 and 8 s; and at every instant, or averaged over each nutation (from one "
    "maximum of theta to the next)",
    control={"name": "E_rot"},
)
def potential_energy_increases(name: str = "E_pot", scene: SceneLike = "reference") -> Finding:
    """E_pot increases."""
    span, climb = series.whole(scene), series.climb(scene)
    first, last = (float(x) for x in series.columns([name], list(span), scene)[name])
    _, fall = series.rises_and_falls(name, scene)
    averages = [series.mean(name, scene, one) for one in series.nutations(scene, climb)]
    falling = sum(b < a for a, b in pairwise(averages))
    return readings(
        {
            "from start to end": statement(
                last > first,
                printed="increases",
                measured=f"from {decimal(first, 6)} to {decimal(last, 6)} J",
            ),
            "in the climb, averaged over each nutation": statement(
                falling == 0 and len(averages) > 1,
                printed="increases",
                measured=f"falls {falling} of {len(averages) - 1} times",
            ),
            "at every instant": statement(
                fall == 0, printed="increases", measured=f"all falls sum up to {decimal(fall, 4)} J"
            ),
        },
        "It oscillates with theta.",
    )


@claim(
    "FIG-03",
    quote="these oscillations are not directly seen in the main graph",
    where=SECTION,
    definition="the main graph shows 0 to E(0); the largest change of each part between "
    "consecutive extrema (events) against its course, that is the smaller of two neighbouring "
    "ones; not seen: below 1 % of the graph's height",
    control={"name": "E_tilde"},
)
def invisible_oscillations(name: str = "", scene: SceneLike = "reference") -> Finding:
    """The oscillations of the parts are too small to be seen in the main graph."""
    height = float(series.columns(["E"], [0.0], scene)["E"][0])
    checks = {}
    for part in (name,) if name else PARTS:
        values = series.extrema(part, scene)[1]
        swings = [abs(b - a) for a, b in pairwise(values)]
        largest = max(min(a, b) for a, b in pairwise(swings))
        checks[part] = statement(
            largest < 0.01 * height,
            printed="not seen",
            measured=f"swings of at most {100 * largest / height:.2f} % of the height",
        )
    return all_of(checks, "They are largest in the middle of the climb.")


@claim(
    "FIG-04",
    quote="E_trans ... goes to zero as TT inverts",
    where=SECTION,
    definition="E_trans at 8 s against E_trans(0); goes to zero: below 1 % of it",
    control={"name": "E_pot"},
)
def translational_energy_vanishes(name: str = "E_trans", scene: SceneLike = "reference") -> Finding:
    """E_trans tends to zero as the top inverts."""
    found = evidence.at(name, "8", scene)
    first = evidence.at(name, "0", scene)
    share = float(found.value / first.value)
    return judged(
        statement(
            share < 0.01,
            printed="goes to zero",
            measured=f"{measured_text(found)} J at 8 s, {decimal(share, 2)} of its first value",
        ),
        "It does not fall all the way: in the climb it oscillates up to "
        f"{decimal(float(series.extrema(name, scene, series.climb(scene))[1].max()), 3)} J.",
    )


@claim(
    "FIG-05",
    quote="the greatest part of the energy is contained in the rotational energy mode",
    where=SECTION,
    definition="E_rot against E_pot and E_trans at every instant: least E_rot minus the largest "
    "values of both others (events); so that it is more than half of E",
    control={"name": "E_pot"},
)
def rotational_energy_is_the_greatest(
    name: str = "E_rot", scene: SceneLike = "reference"
) -> Finding:
    """Most of the energy is rotational all the time."""
    others = [part for part in PARTS if part != name]
    least = series.extreme(name, scene, largest=False)
    largest = [series.extreme(part, scene, largest=True) for part in others]
    lost = 1 - float(least.value) / float(series.columns([name], [0.0], scene)[name][0])
    return judged(
        statement(
            float(least.value) > sum(float(one.value) for one in largest),
            printed=f"{name} is the greatest part",
            measured=f"least {name} {measured_text(least)} J; largest "
            + ", ".join(f"{part} {measured_text(one)} J"
                        for part, one in zip(others, largest, strict=True)),
        ),
        f"Until then it has lost {100 * lost:.0f} % of its first value.",
    )  # fmt: skip


@claim(
    "FIG-06",
    quote="E_dot becomes close to zero ... when both nu_x and nu_y are close to zero in a "
    "neighborhood of t_init = 3.2 s",
    where="Sec. 2.3, Fig. 5",
    definition="the smallest maximum of |v_A| and the largest of E_dot (events) within 0.2 s of "
    "t_init, definition A; close to zero: 1 % of the peaks between them",
    control={"moment": "5.5"},
)
def vanishing_rate(moment: str = "", scene: SceneLike = "reference") -> Finding:
    """Near t_init E_dot comes close to zero where nu_x and nu_y both do."""
    centre = float(moment) if moment else series.climb(scene).begin
    span = series.Span(centre - 0.2, centre + 0.2)
    times, rates = series.extrema("E_dot", scene, span)
    best = int(rates.argmax())
    there = series.columns(["nu_x", "nu_y", "gliding_speed"], [times[best]], scene)
    fastest = float(series.extrema("gliding_speed", scene, span)[1].max())
    speed = float(there["gliding_speed"][0])
    peak = float(rates.min())
    return all_of(
        {
            "E_dot": statement(
                abs(rates[best]) < 0.01 * abs(peak),
                printed="close to zero",
                measured=f"{decimal(float(rates[best]), 3)} W at {decimal(float(times[best]), 5)} "
                f"s, against peaks of {decimal(peak, 3)} W",
            ),
            "gliding velocity": statement(
                speed < 0.01 * fastest,
                printed="both close to zero",
                measured=f"nu_x = {decimal(float(there['nu_x'][0]), 2)}, "
                f"nu_y = {decimal(float(there['nu_y'][0]), 2)} m/s there, against speeds up to "
                f"{decimal(fastest, 3)} m/s",
            ),
        },
        "|v_A| has a minimum in each nutation; the deepest of them comes "
        f"{decimal(float(times[best]) - centre, 2)} s after t_init.",
    )


@claim(
    "FIG-07",
    quote="the graph of E_trans_dot is predominantly negative and has general shape similar to "
    "E_dot",
    where="Sec. 2.3, Fig. 5",
    definition="part of the time with a negative value (zeros between extrema found as events): "
    "predominantly means two thirds of the climb at least; similar shape: correlation over 0..8 s "
    "above 0.7",
    control={"name": "E_rot_dot"},
)
def shape_of_the_translational_rate(
    name: str = "E_trans_dot", scene: SceneLike = "reference"
) -> Finding:
    """E_trans_dot is mostly negative and shaped like E_dot."""
    climb = series.climb(scene)
    shares = [series.share_below_zero(name, scene, one) for one in (series.whole(scene), climb)]
    alike = _correlation(name, scene)
    return all_of(
        {
            "sign": statement(
                shares[1] > 2 / 3,
                printed="predominantly negative",
                measured=f"negative for {100 * shares[0]:.1f} % of the time, "
                f"{100 * shares[1]:.1f} % of the climb",
            ),
            "shape": statement(
                alike > 0.7,
                printed="similar to E_dot",
                measured=f"correlation {alike:.2f}",
            ),
        },
        "What fits both descriptions is E_rot_dot: negative for "
        f"{100 * series.share_below_zero('E_rot_dot', scene, climb):.1f} % of the climb, "
        f"correlation {_correlation('E_rot_dot', scene):.2f}.",
    )


@claim(
    "FIG-08",
    quote="most of the energy lost to friction comes from the rotational and the translational "
    "components",
    where=SECTION,
    definition="differences between 8 s and 0, relative to the loss of E",
    control={"from_": ("E_trans", "E_pot")},
)
def where_the_energy_comes_from(
    from_: tuple[str, str] = ("E_rot", "E_trans"), scene: SceneLike = "reference"
) -> Finding:
    """The energy lost to friction comes mostly from rotation and translation."""
    ends = series.columns(("E", *PARTS), list(series.whole(scene)), scene)
    loss = float(ends["E"][0] - ends["E"][1])
    share = {name: float(ends[name][0] - ends[name][1]) / loss for name in PARTS}
    shown = ", ".join(f"{name} {100 * value:.1f} %" for name, value in share.items())
    return judged(
        statement(
            sum(share[name] for name in from_) > 0.5,
            printed=f"most of it from {' and '.join(from_)}",
            measured=f"of {decimal(loss, 5)} J lost: {shown}",
        ),
        "Nearly all of it is rotational; E_pot gains.",
    )


def _correlation(name: str, scene: SceneLike) -> float:
    import numpy

    times = list(numpy.arange(0.0, series.whole(scene).end, 5e-4))
    columns = series.columns([name, "E_dot"], times, scene)
    return float(numpy.corrcoef(columns[name], columns["E_dot"])[0, 1])
