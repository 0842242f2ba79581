"""A module that is called says what to call."""

import pytest

import tt_precise as tt


@pytest.mark.parametrize("module", [tt.check, tt.golden, tt.claims, tt.certify, tt.threshold])
def test_a_module_that_is_called_names_a_function_of_its_own(module: object) -> None:
    with pytest.raises(TypeError, match=r"is a module, expected tt\.") as refused:
        module("reference")  # type: ignore[operator]
    name = str(refused.value).split(" expected tt.")[1].split("(")[0]
    package, function = name.split(".")
    assert callable(getattr(getattr(tt, package), function))
    assert getattr(tt, package) is module
