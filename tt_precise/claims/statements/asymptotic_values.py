"""Section 2.3: the boundary values of the curve (D, E~) that lambda prescribes."""

from __future__ import annotations

from collections.abc import Callable

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.measured import decimal, fraction_of
from tt_precise.claims.verdicts import Finding, readings, rounds_to
from tt_precise.exact.arithmetic import rounding_to
from tt_precise.mechanics import thresholds as formulas
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters
from tt_precise.scene.scene import load_scene

WHERE = "Sec. 2.3"
DEFINITION = "lambda is that of the reference start, or exactly 2 lambda_thres"


@claim(
    "NUM-26",
    quote="D0 approx lambda sqrt(d(1))/(R(1-alpha))=9.381*10^-4",
    where=WHERE,
    definition=DEFINITION,
    control={"printed": "7.239e-4"},
)
def D0(printed: str = "9.381e-4", scene: str = "reference") -> Finding:
    """Routh's function of the upright spin with the reference lambda is 9.381e-4 kg m^2/s."""
    return _asymptotic("D0", printed, scene, "D", "0", "kg m^2/s")


@claim(
    "NUM-27",
    quote="D1 approx -lambda sqrt(d(-1))/(R(1+alpha))=-6.667*10^-4",
    where=WHERE,
    definition=DEFINITION,
    control={"printed": "-6.024e-4"},
)
def D1(printed: str = "-6.667e-4", scene: str = "reference") -> Finding:
    """Routh's function of the inverted spin with the reference lambda is -6.667e-4 kg m^2/s."""
    return _asymptotic("D1", printed, scene, "D", "8", "kg m^2/s")


@claim(
    "NUM-28",
    quote="E~0 approx 4.912*10^-2",
    where=WHERE,
    definition=DEFINITION,
    control={"printed": "4.064e-2"},
)
def E0(printed: str = "4.912e-2", scene: str = "reference") -> Finding:
    """The modified energy of the upright spin with the reference lambda is 4.912e-2 J."""
    return _asymptotic("E0", printed, scene, "E_tilde", "0", "J")


@claim(
    "NUM-29",
    quote="E~1 approx 1.734*10^-2",
    where=WHERE,
    definition=DEFINITION,
    control={"printed": "1.609e-2"},
)
def E1(printed: str = "1.734e-2", scene: str = "reference") -> Finding:
    """The modified energy of the inverted spin with the reference lambda is 1.734e-2 J."""
    return _asymptotic("E1", printed, scene, "E_tilde", "8", "J")


def _asymptotic(
    name: str, printed: str, scene: str, quantity: str, time: str, unit: str
) -> Finding:
    known = evidence.thresholds_of(scene)
    found, fn = known.quantities, known.context
    body = load_scene(scene).body.numbers(rounding_to(fn))
    formula = _of_lambda(name, body, fn)
    double = formula(2 * found["lambda_thres"].value)
    implied = _lambda_of(formula, fn.mpf(printed), found["lambda"].value, fn)
    return readings(
        {
            "lambda of the reference start": rounds_to(printed, found[name].value, unit),
            "lambda = 2 lambda_thres": rounds_to(printed, double, unit),
            f"the value at {time} s itself": rounds_to(
                printed, evidence.at(quantity, time, scene), unit
            ),
        },
        f"The printed value belongs to lambda = {decimal(implied, 4)}, not to the reference "
        f"start's {decimal(found['lambda'].value, 4)} kg m^3/s. The four printed boundary values "
        f"belong to {_all_implied(body, found['lambda'].value, fn)}: no one lambda has them all.",
    )


PRINTED = {"D0": "9.381e-4", "D1": "-6.667e-4", "E0": "4.912e-2", "E1": "1.734e-2"}


def _of_lambda(name: str, body: Parameters, fn: Functions) -> Callable[[Scalar], Scalar]:
    if name.startswith("D"):
        return lambda lambda_: getattr(formulas, name)(body, lambda_, fn)
    return lambda lambda_: getattr(formulas, name)(body, lambda_)


def _lambda_of(
    formula: Callable[[Scalar], Scalar], value: Scalar, guess: Scalar, fn: Functions
) -> Scalar:
    """The lambda at which an asymptotic value would be ``value``."""
    return fn.findroot(lambda ratio: formula(ratio * guess) / value - 1, 1) * guess


def _all_implied(body: Parameters, guess: Scalar, fn: Functions) -> str:
    implied = (
        _lambda_of(_of_lambda(name, body, fn), fn.mpf(value), guess, fn)
        for name, value in PRINTED.items()
    )
    return ", ".join(decimal(fraction_of(one), 3) for one in implied)
