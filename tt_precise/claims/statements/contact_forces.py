"""Sections 2.1 and 2.3: the normal force about m g, and the torque of the contact force."""

from __future__ import annotations

from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.evidence import reference_series as series
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Finding, all_of, readings, statement

COMPONENTS = ("tau_x", "tau_y", "tau_z")
MANY = 10


@claim(
    "QUAL-16",
    quote="oscillates strongly during the climbing phase ... oscillating about mg",
    where="Sec. 2.1, Fig. 3c",
    definition="extrema of g_n found as events; about m g: its mean over synchronisation and over "
    "climb (definition A) is m g within 1 %, and consecutive extrema lie on both sides of m g; "
    "strongly: half the largest distance of consecutive extrema exceeds that before the climb ten "
    "times",
    control={"about": "0.15"},
)
def normal_force_about_the_weight(about: str = "", scene: SceneLike = "reference") -> Finding:
    """g_n oscillates about m g, strongly in the climb."""
    weight = float(about or evidence.weight(scene))
    spans = {
        "synchronisation": series.synchronisation(scene),
        "climb": series.climb(scene),
    }
    amplitudes, checks = {}, {}
    for phase, span in spans.items():
        values = series.extrema("g_n", scene, span)[1]
        amplitudes[phase] = max(abs(b - a) for a, b in pairwise(values)) / 2
        crossings = sum((a - weight) * (b - weight) < 0 for a, b in pairwise(values))
        average = series.mean("g_n", scene, span)
        checks[phase] = statement(
            abs(average / weight - 1) < 0.01 and crossings >= MANY,
            printed="oscillates about m g",
            measured=f"mean {decimal(average / weight, 5)} m g, {crossings} crossings",
        )
    checks["amplitude"] = statement(
        amplitudes["climb"] > 10 * amplitudes["synchronisation"],
        printed="strongly in the climb",
        measured=" and ".join(f"{decimal(float(a), 2)} N in {p}" for p, a in amplitudes.items()),
    )
    return all_of(
        checks,
        "The mean has to be m g wherever the vertical velocity of the centre of mass ends as it "
        "began.",
    )


@claim(
    "FIG-09",
    quote="all components are negative almost all the time; predominantly negative",
    where="Fig. 6, caption; Sec. 2.3",
    definition="part of the time from 0 to 8 s in which each component in the frame (x, y, z) is "
    "negative, zeros between extrema found as events; almost all: 95 %; predominantly: two thirds",
    control={"sign": "positive"},
)
def torque_is_negative(sign: str = "negative", scene: SceneLike = "reference") -> Finding:
    """The components of the torque are negative almost all the time."""
    shares = {name: series.share_below_zero(name, scene) for name in COMPONENTS}
    climb = {name: series.share_below_zero(name, scene, series.climb(scene)) for name in COMPONENTS}
    if sign == "positive":
        shares = {name: 1 - share for name, share in shares.items()}
    shown = ", ".join(f"{name} {100 * share:.2f} %" for name, share in shares.items())
    in_climb = ", ".join(f"{name} {100 * share:.2f} %" for name, share in climb.items())
    return readings(
        {
            "almost all the time": statement(
                min(shares.values()) > 0.95,
                printed=f"{sign} almost all the time",
                measured=f"{sign} for {shown} of the time",
            ),
            "predominantly": statement(
                min(shares.values()) > 2 / 3,
                printed=f"predominantly {sign}",
                measured=f"{sign} for {shown} of the time",
            ),
        },
        f"In the climb alone they are negative for {in_climb} of the time; tau_x and tau_z "
        "have the sign of -nu_y.",
    )
