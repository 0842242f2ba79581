"""The readers of scenes and trajectories against anything: an InputError in one line, or success.

Seeded and short by default; ``make fuzz`` takes as long as it is given.
"""

from __future__ import annotations

import re
from pathlib import Path

import hypothesis
import numpy
import pytest
from hypothesis import strategies as st

import tt_precise as tt
from tests.conftest import more
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import require_contact
from tt_precise.runtime.values import InputError
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene, load_scene, parse_scene

TEXT = load_scene("reference").text
SETTINGS = hypothesis.settings(deadline=None, derandomize=True, database=None)
several = pytest.mark.parametrize(
    "examples", [12, more(40), pytest.param(30_000, marks=pytest.mark.fuzz)]
)

NUMBERS = st.one_of(
    st.sampled_from(["0", "-0", "1/0", "1e999", "1e-999", "nan", "inf", "0x1", "1_0", "", "pi"]),
    st.fractions().map(str),
    st.decimals(allow_nan=True).map(str),
    st.text(max_size=12),
)  # fmt: skip
CELLS = st.one_of(NUMBERS, st.floats().map(repr), st.sampled_from(['"1"', '"', " 1 ", "1e5000"]))


@st.composite
def spoiled(draw: st.DrawFn) -> str:
    """The reference scene with a value replaced, a line moved, or characters changed."""
    lines = TEXT.splitlines()
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(lines) - 1))
        key, equals, _ = lines[at].partition("=")
        kind = draw(st.sampled_from(["value", "bare", "drop", "double", "splice"]))
        if kind == "value" and equals:
            lines[at] = f'{key}= "{draw(NUMBERS)}"'
        elif kind == "bare" and equals:
            lines[at] = f"{key}= {draw(NUMBERS)}"
        elif kind == "drop":
            lines[at] = ""
        elif kind == "double":
            lines.insert(draw(st.integers(0, len(lines))), lines[at])
        else:
            cut = draw(st.integers(0, len(lines[at])))
            lines[at] = lines[at][:cut] + draw(st.text(max_size=5)) + lines[at][cut:]
    return "\n".join(lines)


def one_line(error: InputError) -> None:
    """Assert that the command line's message is printable, and one readable line."""
    message = " ".join(str(error).split())
    assert message
    assert len(message) < 1000


def scene_or_error(text: str) -> Scene | None:
    try:
        scene = parse_scene(text, "fuzz", "fuzz.toml")
        double = precision_named("double")
        start = InitialState.of(scene, double.arithmetic)
        require_contact(scene.name, start, double.context, "unilateral")
    except InputError as error:
        one_line(error)
        return None
    return scene


@several
def test_scenes(examples: int) -> None:
    def read(text: str) -> None:
        scene_or_error(text)

    texts = st.one_of(spoiled(), st.text(), st.binary().map(lambda b: b.decode("latin-1")))
    anything = hypothesis.given(spoiled() if examples < 100 else texts)
    hypothesis.settings(SETTINGS, max_examples=examples)(anything(read))()


def test_the_fuzzer_meets_both_outcomes() -> None:
    """The control: neither everything nor nothing is refused."""
    assert scene_or_error(TEXT) is not None
    assert scene_or_error(TEXT.replace("0.3", "1/0")) is None


@pytest.mark.parametrize("key", ["I1", "m", "alpha", "until", "sample_every"])
@pytest.mark.parametrize("value", ["1e999", "-1e999", "-1/7" + "3" * 1500])
def test_astronomical_numbers_are_reported_briefly(key: str, value: str) -> None:
    text = re.sub(rf'^{key} = ".*"', f'{key} = "{value}"', TEXT, flags=re.MULTILINE)
    assert text != TEXT
    # no sample but the first and the last is a scene like another
    assert (scene_or_error(text) is None) == ((key, value) != ("sample_every", "1e999"))


@several
def test_tables(examples: int, tmp_path: Path) -> None:
    def table_or_error(rows: list[list[str]]) -> None:
        lines = ["t,kx,ky,kz,Lx,Ly,Lz", *(",".join(row) for row in rows)]
        path = tmp_path / "f.csv"
        path.write_text("\n".join(lines), "utf-8", errors="replace")
        try:
            with numpy.errstate(all="ignore"):
                tt.check.conservation(path, "reference")
        except InputError as error:
            one_line(error)

    anything = hypothesis.given(st.lists(st.lists(CELLS, max_size=8), max_size=6))
    hypothesis.settings(SETTINGS, max_examples=examples)(anything(table_or_error))()
