"""Section 2.1: omega_3, its derivative, and the direction of the angular velocity."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.evidence import reference_series as series
from tt_precise.claims.evidence.proved import digits, proofs_of, settles
from tt_precise.claims.measured import decimal
from tt_precise.claims.statements.inversion_times import DEFINITIONS
from tt_precise.claims.verdicts import (
    Check,
    Finding,
    all_of,
    judged,
    readings,
    rounds_to,
    statement,
    within,
)
from tt_precise.integration import Trajectory
from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import Vector, cross, dot
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.scene.scene import load_scene

SECTION = "Sec. 2.1"
VECTORS = NewtonState._fields
CLOSE_DEG = 10


@claim(
    "NUM-09",
    quote="from the initial value of 155 rad/s to about -85 rad/s",
    where=SECTION,
    definition="omega_3 at 8 s, the end of the graphs; the value it tends to is "
    "-lambda/(R (1 + alpha) I3), which at 8 s it has reached to six digits",
    control={"printed": "-80"},
)
def final_spin(printed: str = "-85", scene: SceneLike = "reference") -> Finding:
    """omega_3 falls from 155 rad/s to about -85 rad/s."""

    def checks(spin: Scalar) -> list[Check]:
        return [rounds_to(printed, spin, "rad/s"), within(printed, spin, "2.5", "rad/s")]

    found, known = evidence.at("omega_3", "8", scene), proofs_of(scene)
    interval = known.at("omega_3", "8")
    exact, near = checks(found)
    proved = settles(exact, lambda spin: checks(spin)[0], interval) and settles(
        near, lambda spin: checks(spin)[1], interval
    )
    return readings(
        {"to the last printed digit": exact, "to the nearest multiple of 5": near},
        f"It ends at {decimal(found.value, 5)} rad/s."
        + known.sentence(proved, f"this value {digits([interval])}"),
        proved=proved,
    )


@claim(
    "NUM-10",
    quote="in the quotient omega_3(t) (about 154 rad/s) is close to omega_3(0) = 155 rad/s",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    definition="omega_3 at the initiation time in definitions A, B and C",
    control={"printed": "153"},
)
def spin_at_initiation(printed: str = "154", scene: SceneLike = "reference") -> Finding:
    """At the initiation time omega_3 is about 154 rad/s."""
    return readings(
        {
            reading: rounds_to(printed, evidence.settled(partial(_spin_at, name), scene), "rad/s")
            for name, reading in DEFINITIONS.items()
        },
        "Friction has taken little of the spin until then.",
    )


@claim(
    "QUAL-09",
    quote="the strong oscillations of phi_dot, psi_dot ... compensate each other",
    where=SECTION,
    definition="swings (largest minus least value, extrema as events) of phi_dot, psi_dot and "
    "omega_3 from 0.1 s before to 0.1 s after the initiation and the ending time; compensation: "
    "omega_3 swings less than a hundredth of either",
    control={"sum_": "psi_dot"},
)
def compensation(sum_: str = "omega_3", scene: SceneLike = "reference") -> Finding:
    """Near both moments the oscillations of phi_dot and psi_dot cancel in omega_3."""
    checks = {}
    for when, t in zip(("initiation", "ending"), series.climb(scene), strict=True):
        span = series.Span(t - 0.1, min(t + 0.1, series.whole(scene).end))
        phi, psi, both = (_swing(one, scene, span) for one in ("phi_dot", "psi_dot", sum_))
        checks[when] = statement(
            100 * both < min(phi, psi),
            printed="compensate each other",
            measured=f"phi_dot swings by {decimal(phi, 3)}, psi_dot by {decimal(psi, 3)}, "
            f"{sum_} by {decimal(both, 3)} rad/s",
        )
    return all_of(
        checks,
        "omega_3 = psi_dot + phi_dot cos(theta), and cos(theta) is near 1 and -1 there. The height "
        "of the peaks is ill conditioned, the compensation is not.",
    )


@claim(
    "QUAL-10",
    quote="omega_3(t) ... is (unexpectedly) an almost monotonously decreasing function",
    where=SECTION,
    definition="almost: all rises between its extrema (events) together are below 1 % of its fall",
    control={"name": "theta"},
)
def monotonous_spin(name: str = "omega_3", scene: SceneLike = "reference") -> Finding:
    """omega_3 decreases almost monotonously."""
    rise, fall = series.rises_and_falls(name, scene)
    values = series.extrema(name, scene)[1]
    return judged(
        statement(
            rise < 0.01 * (fall - rise),
            printed="almost monotonously decreasing",
            measured=f"rises sum up to {decimal(rise, 4)}, falls to {decimal(fall, 5)} rad/s",
        ),
        f"It has {len(values) - 2} local extrema, wherever nu_y vanishes, and starts with a "
        f"{'rise' if values[1] > values[0] else 'fall'}.",
    )


@claim(
    "QUAL-11",
    quote="the curve omega_3(t) is in the beginning and at the end almost horizontal",
    where=SECTION,
    definition="mean slope over the first and the last half second, against the steepest half "
    "second of the run; almost horizontal: below 2 % of that",
    control={"name": "nu_x"},
)
def horizontal_ends(name: str = "omega_3", scene: SceneLike = "reference") -> Finding:
    """omega_3 is almost constant in the beginning and at the end."""
    end = series.whole(scene).end
    times = [0.5 * k for k in range(int(2 * end) + 1)]
    values = series.columns([name], times, scene)[name]
    slopes = [(b - a) / 0.5 for a, b in pairwise(values)]
    steepest = max(map(abs, slopes))
    steep = times[[abs(slope) for slope in slopes].index(steepest)]
    return all_of(
        {
            when: statement(
                abs(slope) < 0.02 * steepest,
                printed="almost horizontal",
                measured=f"slope {decimal(slope, 3)} against {decimal(steepest, 4)} rad/s^2",
            )
            for when, slope in (("beginning", slopes[0]), ("end", slopes[-1]))
        },
        f"The steepest half second begins at {decimal(steep, 2)} s.",
    )


@claim(
    "QUAL-12",
    quote="the predominantly vertical angular velocity; remains close to be parallel with z",
    where="Sec. 2.1; 2.3",
    definition=f"angle between omega and the vertical; close to parallel: below {CLOSE_DEG} "
    "degrees at every instant (the largest angle is closed in on in the dense output)",
    control={"axis": "3"},
)
def vertical_angular_velocity(axis: str = "z", scene: SceneLike = "reference") -> Finding:
    """The angular velocity stays close to vertical."""
    body = load_scene(scene).body.numbers(float)

    def angle(columns: dict[str, Array]) -> Array:
        import numpy

        state = NewtonState(*(columns[name] for name in VECTORS))
        omega = newton.angular_velocity(body, state)
        to: Vector = (0, 0, 1) if axis == "z" else state.k
        across = cross(omega, to)
        return numpy.degrees(numpy.arctan2(numpy.sqrt(dot(across, across)), dot(omega, to)))

    when, largest = series.extreme_of(angle, VECTORS, scene, largest=True)
    return judged(
        statement(
            largest < CLOSE_DEG,
            printed=f"parallel to {axis}, within {CLOSE_DEG} degrees",
            measured=f"largest angle {decimal(largest, 5)} degrees, at {decimal(when, 5)} s",
        ),
        f"theta is {decimal(float(series.columns(['theta'], [when], scene)['theta'][0]), 3)} rad "
        "there.",
    )


@claim(
    "QUAL-13",
    quote="the projection of omega on 3 changes sign",
    where=SECTION,
    definition="zeros of omega_3 over the whole run",
    control={"name": "L_z"},
)
def spin_changes_sign(name: str = "omega_3", scene: SceneLike = "reference") -> Finding:
    """During the climb the projection of omega on the symmetry axis changes sign."""
    found = series.zeros(name, scene)
    climb = series.climb(scene)
    at = f", at {decimal(evidence.settled(_zero_of_spin, scene).value, 16)} s" if found else ""
    check = statement(
        len(found) == 1 and climb.has(found[0]),
        printed="changes sign during the climb",
        measured=f"{len(found)} change{'' if len(found) == 1 else 's'} of sign{at}",
    )
    known = proofs_of(scene)
    half = decimal(evidence.trajectory(scene).inversion.equator, 6)
    zeros = known.events("omega_3_zero") if name == "omega_3" else None
    begin, end = (known.moment("A", which) for which in ("t_init", "t_end"))
    proved = bool(
        check.holds
        and zeros and begin and end
        and len(zeros) == 1
        and begin.high < zeros[0]["t"].low <= zeros[0]["t"].high < end.low
    )  # fmt: skip
    return judged(
        check,
        f"theta first passes pi/2 at {half} s."
        + known.sentence(proved, "this one, and that there is no other"),
        proved=proved,
    )


@claim(
    "QUAL-14",
    quote="the graph for omega_3_dot acquires positive spikes in a neighborhood of t_init",
    where="Sec. 2.1, Fig. 3b",
    definition="positive local maxima of omega_3_dot (events) within 0.4 s of the initiation time, "
    "definition A",
    control={"name": "E_dot"},
)
def positive_spikes(name: str = "omega_3_dot", scene: SceneLike = "reference") -> Finding:
    """The derivative of omega_3 has positive spikes near the initiation time."""
    t_init = series.climb(scene).begin
    times, values = series.extrema(name, scene)
    near = [v for t, v in zip(times, values, strict=True) if abs(t - t_init) < 0.4 and v > 0]
    changes = series.zeros(name, scene)
    rest = [t for t in changes if series.climb(scene).has(t)]
    early = [t for t in rest if t < t_init + 2]
    return judged(
        statement(
            len(near) > 1,
            printed="positive spikes",
            measured=f"{len(near)} positive maxima, up to {decimal(max(near, default=0.0), 4)} "
            "rad/s^2",
        ),
        "omega_3_dot has the sign of -nu_y, as the paper says."
        + (
            f" The last positive spike before mid-climb ends at {early[-1]:.3f} s." if early else ""
        ),
    )


def _spin_at(definition: str, run: Trajectory) -> Scalar:
    t = getattr(run.inversion, definition).t_init
    return run.frame("omega_3", times=[t])["omega_3"].iloc[0]


def _zero_of_spin(run: Trajectory) -> Scalar:
    return run.events["t"][run.events["name"] == "omega_3_zero"].iloc[0]


def _swing(name: str, scene: SceneLike, span: series.Span) -> float:
    values = series.extrema(name, scene, span)[1]
    return float(values.max() - values.min())
