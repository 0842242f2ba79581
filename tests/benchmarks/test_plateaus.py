"""The plateaus of check's constants: a constant that decides is seen to."""

import pytest

from benchmarks.plateaus import CONSTANTS, changes, files, verdicts, with_factor
from tt_precise.check import kinematics


def test_constants_exist_and_are_multiplied() -> None:
    for module, name in CONSTANTS:
        value = getattr(module, name)
        assert with_factor(value, 2) != value
    assert with_factor(3, 0.5) == 2
    assert with_factor({"axis": 0.1}, 2) == {"axis": 0.2}


def test_a_constant_that_decides_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.plateaus.HERTZ", (60,))
    monkeypatch.setattr("benchmarks.plateaus.scenes", lambda: ["reference"])
    monkeypatch.setattr("benchmarks.plateaus.faults", lambda: iter(()))
    of = files()
    before = verdicts(of)
    assert changes(kinematics, "GAP", 2.0, of, before) == []
    assert changes(kinematics, "RESOLUTION", 1e-6, of, before) == ["1 pass to open"]
