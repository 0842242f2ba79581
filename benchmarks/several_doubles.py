"""What decided that several doubles are used: ``python -m benchmarks.several_doubles``.

Seeded gliding tops, 8 s each: what digits cost in double-double and triple-double, with their
estimate, beside bare loops of heyoka in wider arithmetics, and whether they are right. The truth is
heyoka's quad, which has 31 digits of the median scene itself. All in processor time, each call
measured just behind its yardstick.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import islice
from statistics import median

from benchmarks.calls import HORIZON_S
from benchmarks.estimates import right_throughout
from benchmarks.random_scenes import gliding_scenes
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.progress import Progress, silent
from tt_precise.scene.scene import Scene
from tt_precise.taylor import system
from tt_precise.tradeoff.bare_loop import bare_loop
from tt_precise.tradeoff.timing import Action, processor_time, timed

SCENES = 100


@dataclass(frozen=True)
class Question:
    """Digits, and the arithmetic beside which they may cost this share at most.

    ``tolerance`` is that of a run in it that has an estimate of about so many digits; 0 for none,
    where the estimate would be made in mp.
    """

    digits: int
    beside: str
    share: float
    tolerance: float


QUESTIONS = (Question(14, "extended", 1 / 3, 1e-17), Question(16, "extended", 1 / 3, 1e-17),
             Question(28, "quad", 1 / 20, 0.0))  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """Of one scene: what a call with its estimate costs, and what its run alone; digits.

    ``call`` and ``run`` beside the bare loop; ``alike`` the call beside a run with its estimate.
    """

    question: Question
    scene: str
    precision: str
    call: float
    run: float
    alike: float
    estimated: float
    right: float


def answers(scene: Scene, questions: Iterable[Question] = QUESTIONS) -> Iterator[Answer]:
    """What each question's digits cost on a scene, and how many are right at every sample."""
    truth = integrate(scene, "quad", events=(), record=())
    for one in questions:
        loop = bare_loop(scene, precision=one.beside)
        loop()
        found = integrate(scene, digits=one.digits)
        call = partial(integrate, scene, digits=one.digits)
        alone = partial(_again, found)
        actions: list[Action] = [loop, call, loop, alone]
        if one.tolerance:
            actions += [partial(_with_estimate, scene, one), call]
        seconds = [timed(action, processor_time) for action in actions]
        alike = seconds[-1] / seconds[-2] if one.tolerance else math.nan
        yield Answer(
            one, scene.name, found.precision.name, seconds[1] / seconds[0],
            seconds[3] / seconds[2], alike, found.digits_throughout,
            right_throughout(found, truth),
        )  # fmt: skip


def _again(run: Trajectory) -> Trajectory:
    return run.again(paired=False)


def _with_estimate(scene: Scene, question: Question) -> float:
    run = integrate(scene, question.beside, tolerance=question.tolerance, events=(), record=())
    return run.digits_throughout


def summary(found: Iterable[Answer]) -> str:
    """A line for each question."""
    by_question: dict[Question, list[Answer]] = {}
    for one in found:
        by_question.setdefault(one.question, []).append(one)
    return "\n".join(_line(question, mine) for question, mine in by_question.items())


def _line(question: Question, found: list[Answer]) -> str:
    calls = [one.call for one in found]
    within = sum(call <= question.share for call in calls)
    wide = sum(one.precision == "mp" for one in found)
    alike = median(one.alike for one in found)
    beside = "" if math.isnan(alike) else f" (1/{1 / alike:.3g} of a run there with its estimate)"
    right = sum(one.right >= question.digits for one in found)
    return (
        f"digits={question.digits}: in the median of {len(found)} scenes 1/{1 / median(calls):.3g} "
        f"of {question.beside}'s bare loop{beside}, in {within} within 1/{1 / question.share:.3g}; "
        f"the run alone 1/{1 / median(one.run for one in found):.3g}. {right} delivered as far as "
        f"quad can tell, {wide} of them in mp; estimate minus truth at most "
        f"{max(one.estimated - one.right for one in found):.2f}"
    )


def measured(scenes: int = SCENES, progress: Progress = silent) -> list[Answer]:
    """All answers of so many scenes."""
    system.WORTH_OPTIMISING = 1  # what many runs share is optimised; so it is from the first on
    found: list[Answer] = []
    for number, scene in enumerate(islice(gliding_scenes(HORIZON_S), scenes)):
        found += answers(scene)
        progress((number + 1) / scenes)
    return found


def main() -> None:
    """Measure, and print the summary."""
    from tt_precise.runtime.progress import progress_bar

    scenes = int(sys.argv[1]) if len(sys.argv) > 1 else SCENES
    with progress_bar("several doubles on scenes") as progress:
        print(summary(measured(scenes, progress)))


if __name__ == "__main__":
    main()
