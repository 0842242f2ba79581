"""Section 2.3: the potential energy at both ends of the reference solution."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.proved import digits, proofs_of, settles
from tt_precise.claims.verdicts import Check, Finding, judged, readings, rounds_to
from tt_precise.golden.proofs import Interval
from tt_precise.runtime.arithmetic import Scalar

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

SECTION = "Sec. 2.3"
AT_8_S, AT_0_S, THEORY = "0.005106", "0.002755", "1.8571"


@claim("NUM-20", quote="0.005106", where=SECTION, control={"printed": "0.005107"})
def potential_energy_at_8_s(printed: str = AT_8_S, scene: str = "reference") -> Finding:
    """E_pot of the reference solution at 8 s."""
    return _energy(
        printed,
        "8",
        "m g R (1 - alpha cos theta) at the state that double-double and extended agree on.",
        scene,
    )


@claim("NUM-21", quote="0.002755", where=SECTION, control={"printed": "0.002756"})
def potential_energy_at_the_start(printed: str = AT_0_S, scene: str = "reference") -> Finding:
    """E_pot of the reference solution at the start."""
    return _energy(
        printed, "0", "m g R (1 - alpha cos 0.1): closed form in the start values.", scene
    )


@claim(
    "NUM-22",
    quote="0.005106/0.002755=1.8534",
    where=SECTION,
    control={"printed": "1.8544"},
)
def ratio_of_potential_energies(printed: str = "1.8534", scene: str = "reference") -> Finding:
    """E_pot(8 s)/E_pot(0) of the reference solution."""
    check = rounds_to(printed, evidence.settled(_ratio, scene))
    proved = settles(check, lambda ratio: rounds_to(printed, ratio), _proved_ratio(scene))
    return readings(
        {
            "ratio of the energies": check,
            "quotient of the two rounded numbers": rounds_to(
                printed, Fraction(AT_8_S) / Fraction(AT_0_S)
            ),
        },
        "The division of the printed, already rounded energies is right, but the fourth decimal "
        "is theirs, not the solution's." + _told_ratio(proved, scene),
        proved=proved,
    )


@claim("NUM-23", quote="1.3/0.7=1.8571", where=SECTION, control={"printed": "1.8572"})
def theoretical_ratio(printed: str = THEORY, alpha: str = "0.3") -> Finding:
    """In theory E_pot grows by the factor (1 + alpha)/(1 - alpha)."""
    exact = (1 + Fraction(alpha)) / (1 - Fraction(alpha))
    return judged(
        rounds_to(printed, exact), "(1 + alpha)/(1 - alpha) = 13/7 at alpha = 3/10: m, g, R cancel."
    )


@claim("NUM-24", quote="differs ... only by 0.2%", where=SECTION, control={"printed": "0.1"})
def difference_of_the_ratios(printed: str = "0.2", scene: str = "reference") -> Finding:
    """The ratio of potential energies at 8 s and 0 differs by 0.2 % from the theoretical one."""
    theory = Fraction(13, 7)

    def off(ratio: Scalar) -> Scalar:
        return 100 * (1 - ratio * 7 / 13)

    check = rounds_to(printed, evidence.settled(lambda run: off(_ratio(run)), scene), "%")
    proved = settles(check, lambda ratio: rounds_to(printed, off(ratio), "%"), _proved_ratio(scene))
    rounded = 100 * (1 - Fraction(AT_8_S) / Fraction(AT_0_S) / theory)
    return readings(
        {
            "difference of the solution's ratio": check,
            "difference of the printed ratio": rounds_to(printed, rounded, "%"),
        },
        "Relative to the theoretical ratio 13/7; what is missing is mostly the start at theta = "
        "0.1 instead of 0." + _told_ratio(proved, scene),
        proved=proved,
    )


def _energy(printed: str, t: str, note: str, scene: str) -> Finding:
    def check(energy: Scalar) -> Check:
        return rounds_to(printed, energy, "J")

    found, known = check(evidence.at("E_pot", t, scene)), proofs_of(scene)
    proved = settles(found, check, known.potential_energy(t))
    shown = known.sentence(proved, f"this energy {digits([known.potential_energy(t)])}")
    return judged(found, note + shown, proved=proved)


def _proved_ratio(scene: str) -> Interval | None:
    first, last = (proofs_of(scene).potential_energy(t) for t in ("0", "8"))
    return Interval(last.low / first.high, last.high / first.low) if first and last else None


def _told_ratio(proved: bool, scene: str) -> str:
    theorem = f"the ratio of the solution's energies {digits([_proved_ratio(scene)])}"
    return proofs_of(scene).sentence(proved, theorem)


def _ratio(run: Trajectory) -> Scalar:
    first, last = run.frame("E_pot", times=["0", "8"])["E_pot"]
    return last / first
