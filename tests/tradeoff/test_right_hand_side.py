"""Generated right-hand sides say what the one text of the equations says."""

import math
from typing import Any

import numpy
import pytest

from tt_precise.mechanics.formulations import CENTRE, FORMULATIONS, MODELS, Formulation
from tt_precise.tradeoff.methods import SHAPES, flat, source

FORMS = [form for (motion, _), form in FORMULATIONS.items() if motion in (*MODELS, CENTRE)]
VALUES = {"alpha": 3 / 10, "I1": 131 / 350, "I3": 2 / 5, "mu": 0.07}
STATE = (0.3, -0.2, 0.9, 1.5, -0.4, 2.5, 0.11, -0.23)
bound_eps = 200  # some 120 operations, each off by half an eps, in another order


@pytest.mark.parametrize("form", FORMS, ids=lambda f: f"{f.model}-{f.coordinates}-{f.columns[-1]}")
@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_gives_the_rates(form: Formulation, shape: str) -> None:
    state = STATE[: len(form.columns)]
    parameters = [VALUES[name] for name in form.parameters]
    body = form.body(parameters)
    expected = numpy.array(form.rates(body, form.State(*state), math))
    found = numpy.array(called(flat(form, shape, parameters), shape, state, parameters))
    scale = numpy.abs(expected).max()
    assert numpy.abs(found - expected).max() < bound_eps * numpy.finfo(float).eps * scale


def called(rates: Any, shape: str, state: Any, parameters: Any) -> Any:
    filled = [0.0] * len(state)
    if shape == "callback":
        rates(filled, 0.0, state, parameters)
        return filled
    if shape == "filling":
        rates(0.0, state, filled)
        return filled
    return rates(0.0, state)


def test_another_parameter_gives_other_rates() -> None:
    form = FORMULATIONS["gliding", "newton"]
    parameters = [VALUES[name] for name in form.parameters]
    right = flat(form, "list", parameters)(0.0, STATE)
    wrong = flat(form, "list", [*parameters[:-1], parameters[-1] * (1 + 1e-9)])(0.0, STATE)
    assert max(abs(a - b) for a, b in zip(right, wrong, strict=True)) > 1e-12


def test_common_subexpressions_are_taken_out() -> None:
    text = source(FORMULATIONS["gliding", "newton"], "callback")
    assert text.count("x0") > 2
    assert "p[3]" in text
