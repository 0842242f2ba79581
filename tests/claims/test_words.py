"""The words of a claim in its docstring, and texts with numbers in braces."""

import pytest

from tt_precise.claims.words import Wording, fill

WHERE = '\n\n    Sec. 2.1, Fig. 3: "a\n    quote"\n'


def test_a_docstring_has_all_words_in_one_line_each() -> None:
    words = Wording.of(
        f'A claim\n    of two lines.{WHERE}    Definition: so: "x"\n    Note: A\n    note.\n'
    )
    assert words == ("A claim of two lines.", "Sec. 2.1, Fig. 3", "a quote", 'so: "x"', "A note.")
    assert Wording.of(f"A claim.{WHERE}") == ("A claim.", "Sec. 2.1, Fig. 3", "a quote", "", "")


@pytest.mark.parametrize("docstring", ["", "A claim.", f"A claim.{WHERE}\nRemark: so", WHERE])
def test_other_docstrings_are_refused(docstring: str) -> None:
    with pytest.raises(ValueError, match="expected a statement"):
        Wording.of(docstring)


NAMES = {"x": 2 / 3, "n": 12, "row": {"a": 1.2345}, "names": ("D", "E~")}


@pytest.mark.parametrize(
    ("text", "filled"),
    [
        ("{x:3} s, {x:.1%}", "0.667 s, 66.7 %"),
        ("{n} of {n:.0f}, {n:1}", "12 of 12, 1e1"),
        ("{point.real:2} at {row[a]:.3g}", "0.50 at 1.23"),
        ("{names}, {{x}}", "D, E~, {x}"),
    ],
)
def test_braces_take_numbers_and_texts(text: str, filled: str) -> None:
    assert fill(text, {**NAMES, "point": 0.5 + 2j}) == filled


@pytest.mark.parametrize("text", ["{y}", "{x.t}", "{x[a]}", "{names[9]}"])
def test_a_misspelt_name_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="expected a known one"):
        fill(text, NAMES)
