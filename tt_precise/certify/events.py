"""All events of an enclosed solution: every zero of their functions, stretch by stretch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from flint import arb

from tt_precise.certify.enclosure import Stretch
from tt_precise.certify.interval_newton import Zero, zeros
from tt_precise.certify.observed import Observer
from tt_precise.certify.onset import onset
from tt_precise.certify.verdict import NotProved
from tt_precise.integration.events import event_named
from tt_precise.scene.scene import Scene


@dataclass(frozen=True)
class ProvedEvents:
    """All zeros of one event after t = 0, or why they are not proved."""

    name: str
    zeros: tuple[Zero, ...]
    failure: NotProved | None = None


class _Search:
    """The zeros of one event, as far as the stretches have been searched."""

    def __init__(self, scene: Scene, name: str, observer: Observer, touches: Sequence[arb]):
        event = event_named(name, scene.model)
        self.name, self.direction, self.touches = name, event.direction, touches
        self.function = observer.of(event.function)
        self.found: list[Zero] = []
        self.failure: NotProved | None = None
        try:
            self.begins = onset(scene, event.function)
        except NotProved as why:
            self.failure = why
        self.ended = self.failure is not None

    def through(self, stretch: Stretch, end: arb) -> None:
        """Add the zeros in a stretch, up to the end of the motion."""
        try:
            for zero in zeros([stretch], self.function, begins=self.begins, touches=self.touches):
                self.ended = zero.time > end
                if self.ended:
                    return
                if not zero.time < end:
                    raise NotProved(
                        "zeros", f"whether one of {self.name} is beyond the end is undecided"
                    )
                if self.direction in (0, zero.direction):
                    self.found.append(zero)
        except NotProved as why:
            self.failure, self.ended = why, True


def search(
    scene: Scene,
    stretches: Iterable[Stretch],
    end: arb,
    names: Mapping[str, Sequence[arb]],
) -> dict[str, ProvedEvents]:
    """The events called ``names`` between t = 0 and ``end``.

    ``names`` has for each event instants at which its function is known to touch zero
    (``interval_newton.zeros``).
    """
    observer = Observer(scene)
    searches = [_Search(scene, name, observer, touches) for name, touches in names.items()]
    # all events of a stretch in turn: they share what they are made of
    for stretch in stretches:
        for one in searches:
            if not one.ended:
                one.through(stretch, end)
    return {one.name: ProvedEvents(one.name, tuple(one.found), one.failure) for one in searches}
