"""The readers of scenes and trajectories against anything: an InputError in one line, or success.

Seeded and short by default; ``make fuzz`` takes as long as it is given.
"""

from collections.abc import Callable
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
from tt_precise.scene.scene import InitialState, load_scene, parse_scene

TEXT = load_scene("reference").text
SETTINGS = hypothesis.settings(deadline=None, derandomize=True, database=None)
several = pytest.mark.parametrize(
    "examples", [12, more(40), pytest.param(30_000, marks=pytest.mark.fuzz)]
)

SPECIAL = [
    "0", "-0", "1/0", "1e999", "-1e999", "1e-999", "1/7" + "3" * 1500, "nan", "inf", "0x1", "1_0",
    "", "pi",
]  # fmt: skip
NUMBERS = st.one_of(
    st.sampled_from(SPECIAL), st.fractions().map(str), st.decimals(allow_nan=True).map(str),
    st.text(max_size=12),
)  # fmt: skip
CELLS = st.one_of(NUMBERS, st.floats().map(repr), st.sampled_from(['"1"', '"', " 1 ", "1e5000"]))


@st.composite
def spoiled(draw: st.DrawFn) -> str:
    """The reference scene with lines whose value is replaced, doubled, or cut by other text."""
    lines = TEXT.splitlines()
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(lines) - 1))
        line, cut = lines[at], draw(st.integers(0, len(lines[at])))
        key, number = line.partition("=")[0], draw(NUMBERS)
        forms = (f'{key}= "{number}"', f"{key}= {number}", f"{line}\n{line}",
                 line[:cut] + number + line[cut:])  # fmt: skip
        lines[at] = draw(st.sampled_from(("", *forms)))
    return "\n".join(lines)


def refused(read: Callable[[], object]) -> bool:
    """True if the reader raises an InputError, whose message must be short."""
    message = None
    try:
        read()
    except InputError as error:
        message = str(error)
    assert message is None or 0 < len(message) < 1000
    return message is not None


def read_scene(text: str) -> None:
    scene = parse_scene(text, "fuzz", "fuzz.toml")
    double = precision_named("double")
    start = InitialState.of(scene, double.arithmetic)
    require_contact(scene.name, start, double.context, "unilateral")


@several
def test_scenes(examples: int) -> None:
    texts = st.one_of(spoiled(), st.text(), st.binary().map(lambda b: b.decode("latin-1")))

    @hypothesis.settings(SETTINGS, max_examples=examples)
    @hypothesis.given(spoiled() if examples < 100 else texts)
    def read(text: str) -> None:
        refused(lambda: read_scene(text))

    read()
    assert not refused(lambda: read_scene(TEXT))  # the control: not everything is refused


@several
def test_tables(examples: int, tmp_path: Path) -> None:
    @hypothesis.settings(SETTINGS, max_examples=examples)
    @hypothesis.given(st.lists(st.lists(CELLS, max_size=8), max_size=6))
    def check(rows: list[list[str]]) -> None:
        lines = ["t,kx,ky,kz,Lx,Ly,Lz", *(",".join(row) for row in rows)]
        (tmp_path / "f.csv").write_text("\n".join(lines), "utf-8", errors="replace")
        with numpy.errstate(all="ignore"):
            refused(lambda: tt.check.conservation(tmp_path / "f.csv", "reference"))

    check()
