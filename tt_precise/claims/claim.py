"""Claims, their list, and the functions that judge one claim or all claims.

    claim = claims_of("2.3")

    @claim("NUM-25", control="refuted", printed="0.31")
    def translational_energy_at_the_start(printed: str = "0.34", run: Run = REFERENCE) -> Grounds:
        '''The translational energy at the start is about 0.34 of the potential energy there.

        Sec. 2.3: "is initially small, about 0.34E_pot(t=0)"
        Definition: E_trans(0)/E_pot(0) of the reference solution
        Note: The ratio is {ratio:2}, when rounded.
        '''
        ratio = ...
        return about(printed, ratio), {"ratio": ratio}

The docstring has all words of the claim. Its first paragraph is the statement, the second has the
place in the paper and the quote, and may have a definition and a note. Braces take a number by its
name: ``{x:3}`` has three significant digits, ``{x:.1%}`` is such as "12.3 %", and
``{rows[theta]:.4g}`` and ``{point.t:4}`` look into a value.

The keyword arguments are what the paper prints, and the run. The function returns its part, or its
parts by name, and the numbers of the note; the claim's rule makes the verdict. ``control`` is the
verdict that the claim must get with the changed arguments behind it.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
import string
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from types import FunctionType, MappingProxyType
from typing import Any, NamedTuple, TypeVar, cast

from tt_precise.claims.part import decimal
from tt_precise.claims.verdicts import Grounds, JudgedClaim, Rule, Verdict, conclude
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import Call, Failure, local_pool

T = TypeVar("T")
Function = Callable[..., Grounds]
CHAPTERS = "tt_precise.claims.rauch_rutstam"  # The package with a module for each chapter.

# ---- the paper -----------------------------------------------------------------------------------

PAPER = "Rauch-Wojciechowski and Rutstam"
CITATION = (
    "S. Rauch-Wojciechowski and N. Rutstam, Dynamics of the Tippe Top: properties of numerical "
    "solutions versus the dynamical equations"
)
SECTIONS = {
    "1": "Section 1: the model",
    "2.1": "Section 2.1: the reference solution",
    "2.2": "Section 2.2: other starts",
    "2.3": "Section 2.3: energy, torque, potential",
    "3": "Section 3: summary",
}
# Labels of the equations in the paper's source, in the order of their numbers.
EQUATIONS = ("TTequ", "ddth", "ddph", "dot_om", "nu_x", "nu_y", "equ_for_g_n")
# Printed numbers on the first screen of the report, by claim.
HEADLINES = {"NUM-22": "1.8534", "NUM-05": "7.87 s"}
# The paper's "precision of order 1e-6" of lambda, section 2.1, relative.
LAMBDA_KEPT = 1e-6
# Kinds of claims by the letters of their ids.
CLAIM_KINDS = {
    "EQ": "equation", "TH": "theorem", "NUM": "number", "QUAL": "quality", "FIG": "figure",
    "SWP": "sweep", "SUM": "summary", "NT": "setting",
}  # fmt: skip
_ID = re.compile(rf"({'|'.join(CLAIM_KINDS)})-[0-9]{{2}}")


# ---- words ---------------------------------------------------------------------------------------

_DOCSTRING = re.compile(
    r'(?P<statement>.+?)\n\n(?P<where>[^"]+): "(?P<quote>[^"]+)"'
    r"(\nDefinition: (?P<definition>.+?))?(\nNote: (?P<note>.+))?",
    re.DOTALL,
)


class Wording(NamedTuple):
    """Statement, place, quote, definition and note of a claim; the last two may be empty."""

    statement: str
    where: str
    quote: str
    definition: str
    note: str

    @classmethod
    def of(cls, docstring: str) -> Wording:
        """Read a docstring.

        Raises
        ------
        ValueError
            The docstring has another form.
        """
        words = _DOCSTRING.fullmatch(inspect.cleandoc(docstring))
        if words is None:
            raise ValueError(
                f"words: got {docstring!r}, expected a statement, and in the next paragraph "
                'where: "quote", Definition: ..., Note: ...'
            )
        return cls(
            **{name: " ".join((text or "").split()) for name, text in words.groupdict().items()}
        )


class _Filler(string.Formatter):
    def format_field(self, value: Any, spec: str) -> str:
        if spec.isdigit():
            return decimal(value, int(spec))
        if isinstance(value, tuple):  # of texts
            return ", ".join(value)
        text: str = super().format_field(value, spec)
        return text.replace("%", " %") if spec.endswith("%") else text


def fill(text: str, names: Mapping[str, Any]) -> str:
    """Return ``text`` with the numbers and texts of ``names`` in place of the braces.

    Raises
    ------
    ValueError
        A name in braces is not in ``names``.
    """
    try:
        return _Filler().vformat(text, (), names)
    except (LookupError, AttributeError, TypeError) as error:
        raise ValueError(
            f"got the name {error} in braces in {text!r}, expected a known one"
        ) from error


# ---- one claim -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Claim:
    """One checkable statement of the paper.

    Attributes
    ----------
    id
        A name such as "NUM-20"; its letters name the ``kind``.
    section
        The number of the section.
    words
        Statement, place, quote, definition and note. Braces in the note take numbers, arguments,
        or constants of the module.
    function
        Takes keyword arguments (defaults from the paper), returns parts and numbers of the note.
    rule
        The rule that makes the verdict of the parts.
    finding
        The id of the claim that represents the same finding in a count.
    control, changes
        The required verdict with changed arguments; empty if nothing can be computed.
    """

    id: str
    section: str
    words: Wording
    function: Function = field(repr=False)
    rule: Rule = "all of"
    finding: str = ""
    control: str = ""
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The kind: equation, theorem, number, quality, figure, sweep, summary or setting."""
        return CLAIM_KINDS[self.id.split("-")[0]]

    @property
    def group(self) -> str:
        """The module of the claim; claims of one group share their evidence."""
        return _defined(self.function).__module__

    @property
    def order(self) -> tuple[int, str]:
        """The key that sorts claims by kind and number."""
        return list(CLAIM_KINDS.values()).index(self.kind), self.id

    def judge(self, **changes: Any) -> JudgedClaim:
        """Judge the claim, with some of its arguments changed."""
        try:
            grounds = self.function(**changes)
            parts, numbers = grounds if isinstance(grounds, tuple) else (grounds, {})
            arguments = inspect.signature(self.function).bind(**changes)
            arguments.apply_defaults()
            names = {**_defined(self.function).__globals__, **arguments.arguments, **numbers}
            note = fill(self.words.note, names)
        except Exception as error:
            error.add_note(f"while judging {self.id}")
            raise
        identity = {"id": self.id, "kind": self.kind, "paper": PAPER, "section": self.section}
        words = self.words._asdict()
        del words["note"]
        return conclude(self.rule, parts, note, **identity, **words, finding=self.finding)


def _defined(function: Function) -> FunctionType:
    """The function as it is defined, without the arguments that ``partial`` fixes."""
    return cast(FunctionType, function.func if isinstance(function, partial) else function)


# ---- the list of claims --------------------------------------------------------------------------

_registered: dict[str, Claim] = {}


def claims_of(section: str) -> Callable[..., Callable[[Function], Function]]:
    """Return the decorator for the claims of a section."""

    def claim(
        id: str,
        text: str = "",
        *,
        rule: Rule = "all of",
        finding: str = "",
        control: str = "",
        **changes: Any,
    ) -> Callable[[Function], Function]:
        """``text`` are the words, by default the docstring; ``changes`` belong to the control."""

        def register(function: Function) -> Function:
            if id in _registered or not _ID.fullmatch(id):
                raise ValueError(f"claim: got {id!r}, expected an id such as 'NUM-20', each once")
            try:
                words = Wording.of(text or function.__doc__ or "")
                definition = fill(words.definition, _defined(function).__globals__)
            except ValueError as error:
                raise ValueError(f"claim {id}: {error}") from error
            words = words._replace(definition=definition.removesuffix("."))  # the page adds it
            _registered[id] = Claim(
                id, section, words, function, rule, finding or id, control, changes
            )
            return function

        return register

    return claim


@cache
def claims() -> Mapping[str, Claim]:
    """Return all claims by id, sorted, from the modules of the paper's chapters."""
    package = importlib.import_module(CHAPTERS)
    for module in pkgutil.iter_modules(package.__path__, f"{CHAPTERS}."):
        importlib.import_module(module.name)
    ordered = sorted(_registered.values(), key=lambda claim: claim.order)
    return MappingProxyType({claim.id: claim for claim in ordered})


def look_up(id: str, table: Mapping[str, T]) -> T:
    """The value of ``table`` for a claim's id (in any case).

    Raises ``InputError``: there is no such claim.
    """
    if id.upper() not in table:
        prefix = id.upper().split("-")[0]
        near = [other for other in table if other.startswith(f"{prefix}-")]
        some = f"{near[0]} to {near[-1]}" if near else "such as NUM-22"
        raise InputError(f"claim: got {id[:60]!r}, expected an id {some}; see `tt-precise claims`")
    return table[id.upper()]


def claim_named(id: str) -> Claim:
    """Return the claim with this id (in any case); raises ``InputError`` if there is none."""
    return look_up(id, claims())


# ---- judging -------------------------------------------------------------------------------------


def judge(id: str, **changes: Any) -> JudgedClaim:
    """Judge one claim; ``changes`` replace its arguments: a printed value, a formula, a scene.

    Raises
    ------
    InputError
        There is no such claim.
    """
    return claim_named(id).judge(**changes)


def judge_all(
    ids: Iterable[str] | None = None, progress: Progress = silent, workers: int = 1
) -> list[JudgedClaim]:
    """Judge claims (by default all), in the order of the list.

    One process judges the claims of a module, which share their evidence. With more than one of
    ``workers``, which are new processes, a script needs ``if __name__ == "__main__"``.

    Raises
    ------
    InputError
        One of the ids is unknown; nothing is judged.
    """
    calls = calls_for(ids)
    groups = {call.group for call in calls}
    judged: list[JudgedClaim] = []
    with local_pool(max(1, min(workers, len(groups)))) as pool:
        for _, result in pool.perform(judge, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            judged.append(result)
    return in_order(judged)


def calls_for(ids: Iterable[str] | None = None) -> list[Call]:
    """The calls of ``judge`` for claims (by default all), the largest modules first."""
    chosen = {claim.id: claim for claim in map(claim_named, claims() if ids is None else ids)}
    modules = Counter(claim.group for claim in chosen.values())
    ordered = sorted(chosen.values(), key=lambda claim: -modules[claim.group])
    return [Call(claim.id, (claim.id,), group=claim.group) for claim in ordered]


def in_order(judged: Iterable[JudgedClaim]) -> list[JudgedClaim]:
    """Sort judged claims in the order of the list of claims."""
    return sorted(judged, key=lambda claim: claim_named(claim.id).order)


def counts(judged: Iterable[JudgedClaim]) -> dict[str, int]:
    """Count the claims with each verdict."""
    number = Counter[str](claim.verdict for claim in judged)
    return {verdict.value: number[verdict] for verdict in Verdict}
