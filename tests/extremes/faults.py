"""Wrong code, as controls of the extreme cases: each fault must make cases fail.

``python -m tests.extremes.faults NAME [CASE...]`` runs all or the named cases in a process with the
fault, and prints the names of the cases that fail.
"""

import math
import sys
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from tt_precise.extremes import cases, judges
from tt_precise.extremes.run import judge
from tt_precise.integration import equations, integrate
from tt_precise.mechanics import euler, newton, vectors


def patch(module: Any, name: str, wrong: Callable[..., Any]) -> None:
    """Replace a function wherever the package has imported it."""
    right = getattr(module, name)
    for other in [m for key, m in sys.modules.items() if key.startswith("tt_precise.")]:
        if vars(other).get(name) is right:
            setattr(other, name, lambda *args, **options: wrong(right, *args, **options))


def patch_numerator(change: Callable[[Any, Any], Any]) -> None:
    """Change the numerator of g_n, of which m g I1 is the largest term."""

    def wrong(right: Any, body: Any, state: Any) -> Any:
        numerator, denominator = right(body, state)
        return change(numerator, body.m * body.g * body.I1), denominator

    patch(newton, "contact_terms", wrong)


def no_longest_step() -> None:
    """Steps beside a pole have no limit."""
    patch(equations, "longest_step", lambda *_, **__: None)


def coarse_tolerance() -> None:
    judges.integrate = lambda scene, **options: integrate(scene, tolerance=1e-10, **options)


def start_through_float() -> None:
    """A float cannot hold pi - 1e-20."""
    judges.integrate = lambda scene, **options: integrate(
        scene.varied(theta=Fraction(scene.start.theta.radians(math, float))), **options
    )


def normal_force_too_small() -> None:
    patch_numerator(lambda numerator, largest: numerator - largest / 10**9)


def gyroscopic_sign() -> None:
    patch_numerator(lambda numerator, largest: 2 * largest - numerator)


def textbook_precession() -> None:
    """phi_dot = (L.z - cos theta L.k)/(I1 sin^2 theta)."""

    def textbook(right: Any, body: Any, state: Any, fn: Any) -> Any:
        sine = state.kx * state.kx + state.ky * state.ky
        phi_dot = (state.Lz - state.kz * vectors.dot(state.L, state.k)) / sine / body.I1
        return right(body, state, fn)._replace(phi_dot=phi_dot)

    patch(euler, "euler_from_vectors", textbook)


def early_singularity() -> None:
    equations.SINGULAR_DENOMINATOR = 1e-3


def centripetal_sign() -> None:
    """omega x (R alpha k_dot) has the wrong sign in the contact point's acceleration."""

    def wrong(right: Any, body: Any, state: Any, force: Any) -> Any:
        k_dot = newton.axis_rate(body, state)
        term = vectors.cross(newton.angular_velocity(body, state), k_dot)
        excess = vectors.scaled(-2 * body.R * body.alpha, term)
        return vectors.added(right(body, state, force), excess)

    patch(newton, "contact_acceleration", wrong)


# Each fault, and cases of its judges that must fail.
FAULTS: dict[Callable[[], None], tuple[str, ...]] = {
    no_longest_step: ("theta(0) = pi - 1e-20", "mu = 0 s/m at pi - 1e-20"),
    coarse_tolerance: ("past a pole, phi_dot + 1e-8", "frictionless for 100 s"),
    start_through_float: ("theta(0) = pi - 1e-100",),
    normal_force_too_small: ("theta(0) = 1e-12",),
    gyroscopic_sign: ("contact lost, mu = 1, double",),
    textbook_precession: ("theta(0) = 1e-9", "subnormal tilt pi - 1e-308"),
    early_singularity: ("blow-up of g_n, mu = 3",),
    centripetal_sign: ("elastic table without friction",),
}


def main(name: str, *names: str) -> None:
    (fault,) = (fault for fault in FAULTS if fault.__name__ == name)
    fault()
    for case in cases():
        if (not names or case.name in names) and not judge(case.name).passes:
            print(case.name)


if __name__ == "__main__":
    main(*sys.argv[1:])
