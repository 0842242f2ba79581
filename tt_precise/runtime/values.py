"""Shared names: an input error, numbers of an arithmetic, JSON, the result of a check.

The mechanics are written once, and run in floats, NumPy arrays, heyoka expressions, mpmath numbers,
SymPy expressions and balls. A static type that covers all of these would carry no information, so
these names document the intended type.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from numbers import Integral
from typing import Any, Literal, TypeAlias, TypeVar


class InputError(ValueError):
    """Unusable input; the message is one complete line, shown to the user unchanged."""


Json: TypeAlias = Any  # of JSON or TOML: None, a bool, a number, a str, a list or a dict of such
Adaptive: TypeAlias = Any  # an integrator of heyoka, one lane or a batch
ContinuousOutput: TypeAlias = Any  # dense output of heyoka, or what is called as one
Scalar: TypeAlias = Any  # a number, or an array or expression of numbers, in one arithmetic
Array: TypeAlias = Any  # a NumPy array; shape and entries are stated where it is used
# The functions of one arithmetic, such as sqrt and sin: a module, an mpmath context, an object.
Functions: TypeAlias = Any


def listed(names: str | Iterable[str]) -> tuple[str, ...]:
    """Return names given as separate texts, or as one text with commas."""
    if not isinstance(names, Iterable):
        raise InputError(f"got {shortened(names)}, expected names, such as 'mu' or ['mu', 'theta']")
    if not isinstance(names, str):
        return tuple(names)
    return tuple(name.strip() for name in names.split(",") if name.strip())


def nearest(name: str, names: Iterable[str]) -> str:
    """Return the name in ``names`` that resembles ``name``; "" if there is none."""
    import difflib  # for a wrong name only

    near = difflib.get_close_matches(name, list(names), n=1, cutoff=0.65)  # 0.6 proposes too many
    return near[0] if near else ""


def wrong_name(
    what: str,
    got: object,
    names: Iterable[str],
    also: str = "",
    *,
    expected: str = "one of: ",
    further: Iterable[str] = (),
) -> InputError:
    """The error of a name that is none of ``names``, with the nearest of these and ``further``."""
    names = list(names)
    near = nearest(got, [*names, *further]) if isinstance(got, str) else ""
    hint = f"; did you mean {near!r}?" if near else ""
    return InputError(
        f"{what}: got {shortened(got)}, expected {expected}{', '.join(names)}{also}{hint}"
    )


def require_name(what: str, got: object, names: Collection[str], **hints: Any) -> None:
    """Raise ``wrong_name`` unless ``got`` is one of ``names``."""
    if got not in names:
        raise wrong_name(what, got, names, **hints)


def whole(value: Any) -> int | None:
    """A whole number of Python or NumPy as an int; None for anything else."""
    return None if isinstance(value, bool) or not isinstance(value, Integral) else int(value)


def whole_number(value: Any, what: str, least: int, most: int) -> int:
    """A whole number of Python or NumPy as an int.

    Raises ``InputError``: it is no whole number between ``least`` and ``most``.
    """
    number = whole(value)
    if number is None or not least <= number <= most:
        got = shortened(value)
        raise InputError(f"{what}: got {got}, expected a whole number between {least} and {most}")
    return number


def shortened(value: Any) -> str:
    """The ``repr`` of a value in at most 60 characters."""
    try:
        text = repr(value)
    except ValueError:  # Python prints no integer of more than 4,300 digits.
        return "an integer of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."


def distinct(what: str, asked: Iterable[Any]) -> tuple[Any, ...]:
    """Return the requested items, given by name or as objects with a name, each once.

    Raises ``InputError``: two items have the same name, as two lambdas do.
    """
    by_name: dict[str, Any] = {}
    for item in asked:
        name = getattr(item, "name", item)
        if by_name.setdefault(name, item) != item:
            raise InputError(f"{what}: got two called {name}, expected each under its own name")
    return tuple(by_name.values())


@dataclass(frozen=True)
class Arithmetic:
    """An arithmetic to which exact numbers can be converted.

    ``fn`` has elementary functions; ``exact`` rounds a ``Fraction`` once into the arithmetic.
    """

    fn: Functions
    exact: Callable[[Fraction], Scalar]


Verdict = Literal["pass", "fail", "open", "skipped"]
Sense = Literal["at most", "above", "at least"]
ALLOWED = {"at most": "allowed", "above": "expected above", "at least": "expected at least"}


@dataclass(frozen=True)
class Check:
    """The result of a check of a trajectory.

    The verdict is "open" if the check could not be resolved or lacks input, "skipped" if the check
    does not apply. ``value`` is the worst of all rows, ``at`` its time in s, ``since`` the first
    time at which a value is beyond the limit, ``bound`` the largest error that would go unnoticed,
    ``note`` a reason or a remark. ``curve`` has times and values for a plot, ``parts`` the parts of
    the value (correct digits of every column), and ``history`` its course over time in words.
    """

    name: str
    verdict: Verdict
    value: float | None = None
    limit: float | None = None
    at: float | None = None
    note: str = ""
    meaning: str = ""
    sense: Sense = "at most"
    parts: dict[str, float] = field(default_factory=dict)
    history: str = ""
    bound: float | None = None
    since: float | None = None
    curve: tuple[Array, Array] | None = field(default=None, repr=False, compare=False)

    @property
    def holds(self) -> bool:
        """True unless the check failed."""
        return self.verdict != "fail"

    def words(self) -> str:
        """Return the value, the limit, the time and the note, in one line."""
        words = [] if self.value is None else [f"{self.value:.2g}"]
        if words and self.limit is not None:
            words.append(f"{ALLOWED[self.sense]} {self.limit:.2g}")
            if self.since is not None:
                words.append(f"from t = {self.since:.6g} s on")
            elif self.at is not None:
                words.append(f"at t = {self.at:.6g} s")
        return ": ".join(filter(None, [", ".join(words), self.note]))

    def sentence(self) -> str:
        """Return the name and the words."""
        return f"{self.name}: {self.words()}"


Result = TypeVar("Result")


class Memory:
    """A cache of results that depend only on the object itself and a key."""

    def once(self, key: Hashable, compute: Callable[[], Result]) -> Result:
        """Return the result of ``compute``, cached under ``key``."""
        results = vars(self).setdefault("_results", {})
        if key not in results:
            results[key] = compute()
        return results[key]


class Ring:
    """Operators that follow from the sum, product and negative of an operand."""

    __slots__ = ()

    def __radd__(self: Scalar, other: Scalar) -> Scalar:
        return self + other

    def __sub__(self: Scalar, other: Scalar) -> Scalar:
        return self + -other

    def __rsub__(self: Scalar, other: Scalar) -> Scalar:
        return -self + other

    def __rmul__(self: Scalar, other: Scalar) -> Scalar:
        return self * other
