"""``InitialState``: conversion of a scene's exact numbers to those of an arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, Formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters, Units
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Arithmetic, Functions, Memory, Scalar
from tt_precise.scene.scene import Scene, Start
from tt_precise.scene.start import LIFTED, LiftedStart


@dataclass(frozen=True)
class InitialState(Memory):
    """Body and state of a scene at t = 0 in one arithmetic, the axis at azimuth 0.

    ``vectors`` and ``euler`` are the same state, each computed from the exact numbers: near the
    inverted pole the vectors do not use theta = pi - offset. They are a ``LiftedState`` if the
    scene gives the height of the lowest point. ``until`` is the scene's horizon. All values are in
    the units ``units``, which are given in SI. ``row`` is present where a run continues from an
    earlier segment: its first row, a state of its formulation, followed by quadratures (scaled).
    """

    model: str
    body: Parameters
    units: Units
    vectors: NewtonState
    euler: EulerState
    until: Scalar
    row: tuple[Scalar, ...] = ()

    @classmethod
    def of(cls, scene: Scene, arithmetic: Arithmetic) -> InitialState:
        """The start of ``scene``, dimensionless (m = R = g = 1)."""
        fn, exact = arithmetic.fn, arithmetic.exact
        body, units = scene.body.dimensionless(fn, exact), Units.of(scene.body, fn, exact)
        vectors, euler = _state(scene.start, arithmetic, body, units, {})
        return cls(scene.model, body, units, vectors, euler, exact(scene.until) / units.time)

    @classmethod
    def in_si(cls, scene: Scene, arithmetic: Arithmetic) -> InitialState:
        """The start of ``scene`` in SI."""
        body, until = scene.body.numbers(arithmetic.exact), arithmetic.exact(scene.until)
        vectors, euler = _state(scene.start, arithmetic, body, None, {})
        return cls(scene.model, body, Units(1, 1, 1), vectors, euler, until)

    def from_another(
        self, start: Start, arithmetic: Arithmetic, given: Mapping[str, Scalar]
    ) -> InitialState:
        """Return the initial state of another ``start`` of the same body, with the same horizon.

        ``given`` are components that are already numbers of the arithmetic, in SI.
        """
        vectors, euler = _state(start, arithmetic, self.body, self.units, given)
        return replace(self, vectors=vectors, euler=euler)

    def state(self, form: Formulation) -> tuple[Scalar, ...]:
        """The state of ``form``, in the order of its columns."""
        if self.row:
            return self.row[: len(form.columns)]
        q = Motion(self.body, self.vectors, None, self.model, euler=self.euler)
        return self.once(form.State, lambda: tuple(form.State.of(q)))

    def first_row(self, form: Formulation, record: tuple[str, ...]) -> tuple[Scalar, ...]:
        """The state, followed by the quadratures ``record``, which begin at zero."""
        zero = self.until * 0
        return self.row or (*self.state(form), *(zero for _ in record))

    def parameters(self, form: Formulation) -> tuple[Scalar, ...]:
        """The body's ``parameters`` that ``form`` leaves open."""
        numbers = self.body.numbers_by_name
        return tuple(numbers[name] for name in form.parameters)

    def motion(self, fn: Functions) -> Motion:
        """The motion at the start."""
        return Motion(self.body, self.vectors, fn, self.model)

    def map(self, convert: Callable[[Scalar], Scalar]) -> InitialState:
        """Convert every number of body and state; ``units`` and ``until`` stay."""
        return replace(
            self,
            body=self.body.numbers(convert),
            vectors=type(self.vectors)(*map(convert, self.vectors)),
            euler=EulerState(*map(convert, self.euler)),
            row=tuple(map(convert, self.row)),
        )


def _state(
    start: Start,
    arithmetic: Arithmetic,
    body: Parameters,
    units: Units | None,
    given: Mapping[str, Scalar],
) -> tuple[NewtonState, EulerState]:
    fn, exact = arithmetic.fn, arithmetic.exact
    if "theta" in given:
        theta = given["theta"]
        sine_cosine = fn.sin(theta), fn.cos(theta)
    else:
        theta = start.theta.radians(fn, exact)
        sine_cosine = start.theta.sine_cosine(fn, exact)

    def component(name: str) -> Scalar:
        value = given[name] if name in given else exact(getattr(start, name))
        return value if units is None else value / units.of_dimension(STATE_DIMENSIONS[name])

    euler = EulerState(theta, *map(component, EulerState._fields[1:]))
    vectors: Any = vectors_from_euler(body, euler, fn, sine_cosine=sine_cosine)
    if isinstance(start, LiftedStart):
        vectors = LiftedState(*vectors, *map(component, LIFTED))
    return vectors, euler
