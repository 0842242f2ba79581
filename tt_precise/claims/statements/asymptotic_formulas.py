"""Section 1: the values that lambda prescribes for t to minus and plus infinity."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.evidence.potential import minimum
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Check, Finding, all_of, statement
from tt_precise.exact.arithmetic import own_context
from tt_precise.mechanics import thresholds
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion, effective_potential
from tt_precise.scene.body import Parameters

WHERE = "Sec. 1"
PRINTED = {
    "lambda of the upright spin": "R*(1 - alpha)*L0",
    "lambda of the inverted spin": "R*(1 + alpha)*L1",
    "D0": "lambda_*sqrt(d(1))/(R*(1 - alpha))",
    "D1": "-lambda_*sqrt(d(-1))/(R*(1 + alpha))",
    "E~0": "lambda_**2/(2*R**2*I3*(1 - alpha)**2) + m*g*R*(1 - alpha)",
    "E~1": "lambda_**2/(2*R**2*I3*(1 + alpha)**2) + m*g*R*(1 + alpha)",
}
QUANTITY = {"l": "lambda", "D": "D", "E": "E_tilde"}
DIGITS = 70


@claim(
    "EQ-24",
    quote="lambda=R(1-alpha)L0=R(1+alpha)L1. So lim D(t)=D0=...",
    where=WHERE,
    control={"printed": {**PRINTED, "D1": PRINTED["D1"][1:]}},
)
def asymptotic_formulas(printed: Mapping[str, str] = PRINTED) -> Finding:
    """The formulas for lambda, D and E~ of the upright and the inverted spin."""
    return all_of(
        {name: _of_the_spin(name, text) for name, text in printed.items()},
        "Compared with -L.a, D and E~ of the vectors 3 = z, L = L0 z and 3 = -z, L = L1 z, for "
        "symbolic parameters.",
        proved=True,
    )


def _of_the_spin(name: str, text: str) -> Check:
    import sympy

    body = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
    spin = sympy.Symbol("L", positive=True)
    upright = name.endswith(("0", "upright spin"))
    state = NewtonState(0, 0, 1 if upright else -1, 0, 0, spin, 0, 0)
    q = Motion(body, state, sympy)
    lambda_ = QUANTITIES["lambda"].evaluate(q)
    value = f.evaluate(text, body, sympy, lambda_=lambda_, L0=spin, L1=spin)
    difference = sympy.simplify(value - QUANTITIES[QUANTITY[name[0]]].evaluate(q))
    return statement(
        difference == 0,
        printed=text.replace("lambda_", "lambda"),
        measured="equal, for every body" if difference == 0 else f"off by {difference}",
    )


@claim(
    "EQ-25",
    quote="E(t)->E1=lim V(z_min(t),D(t),lambda)",
    where=WHERE,
    definition="the toy with the reference lambda, D = D1 + e |D1| for e = 1e-4 ... 1e-12; E1 is "
    "the energy of the inverted spin",
    control={"limit": "E0"},
)
def energy_in_the_limit(limit: str = "E1", scene: str = "reference") -> Finding:
    """The minimum of V tends to the energy of the inverted spin as D tends to D1."""
    fn = own_context(DIGITS)
    body = evidence.body_in(fn, scene)
    lambda_ = fn.convert(evidence.lambda_of(scene))
    D1 = thresholds.D1(body, lambda_, fn)
    target = getattr(thresholds, limit)(body, lambda_)
    off = []
    for power in (4, 8, 12):
        D = D1 + fn.mpf(10) ** -power * abs(D1)
        z = minimum(body, D, lambda_, fn)
        off.append(abs(effective_potential(body, z, D, lambda_, fn) / target - 1))
    return all_of(
        {
            "V(z_min)": statement(
                all(10**3 * later < earlier for earlier, later in pairwise(off)),
                printed="lim V(z_min, D, lambda) = E1",
                measured="V(z_min)/E1 - 1 = " + ", ".join(decimal(one, 2) for one in off),
            )
        },
        "The distance falls in proportion to D - D1. In the limit z_min = -1, where V is of the "
        "form 0/0 and only the joint limit exists.",
    )
