"""From Euler angles to vectors and back, at every distance from the poles, in every precision."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.extremes.case import Observation, case, finite, together, within
from tt_precise.extremes.tilt import tilt_error
from tt_precise.extremes.toy import varied
from tt_precise.integration import integrate
from tt_precise.integration.precision import BITS
from tt_precise.mechanics.conversion import euler_from_vectors, vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters
from tt_precise.scene.scene import load_scene

PRECISIONS = ("double", "extended", "quad", "mp")
RATES = {"theta_dot": "0.7", "phi_dot": "-1.9", "omega_3": "12.3", "nu_x": "0.11", "nu_y": "-0.23"}
FN = own_context(700)  # pi - 1e-300, and some digits more
Convert = Callable[..., Scalar]


class RoundTripArithmetic(NamedTuple):
    """A module of functions, numbers rounded into it and taken out exactly, and its eps."""

    fn: Functions
    into: Callable[[Scalar], Scalar]
    out: Callable[[Scalar], Scalar]
    eps: Scalar


class Trip(NamedTuple):
    """Relative errors in eps: of the tilt on the way there, of the worst rate on the way back."""

    tilt: Scalar
    rate: Scalar


def arithmetic(precision: str) -> RoundTripArithmetic:
    """The arithmetic that quantities of this precision are computed in."""
    bits = BITS[precision]
    eps = FN.ldexp(1, 1 - bits)
    if precision in ("quad", "mp"):
        context = own_context(15)
        context.prec = bits
        # converting keeps all digits of a number from a finer context; adding nothing rounds it
        return RoundTripArithmetic(context, lambda x: +context.convert(x), FN.convert, eps)
    import numpy

    if precision == "double":
        return RoundTripArithmetic(numpy, lambda x: numpy.float64(float(x)), FN.mpf, eps)

    def exactly(x: Scalar) -> Scalar:
        return FN.mpf(int(x.as_integer_ratio()[0])) / int(x.as_integer_ratio()[1])

    return RoundTripArithmetic(numpy, lambda x: numpy.longdouble(FN.nstr(x, 30)), exactly, eps)


def round_trip(
    precision: str, k: int, inverted: bool, known: bool, there: Convert, back: Convert
) -> Trip:
    """Convert a state 1e-k from a pole and back.

    ``known`` hands over sine and cosine with full digits, as a scene does; else theta alone.
    """
    fn, into, out, eps = arithmetic(precision)
    body = _body(precision)
    offset = FN.mpf(10) ** -k
    theta = FN.pi - offset if inverted else offset
    sine, cosine = FN.sin(offset), FN.cos(offset) * (-1 if inverted else 1)
    euler = EulerState(into(theta), *(into(FN.mpf(x)) for x in RATES.values()))
    sine_cosine = (into(sine), into(cosine)) if known else None
    vectors = there(body, euler, fn, sine_cosine=sine_cosine)
    finite([out(x) for x in vectors], "vectors")
    again = back(body, vectors, fn)
    finite([out(x) for x in again], "Euler state")
    tilted = FN.sqrt(out(vectors.kx) ** 2 + out(vectors.ky) ** 2)
    # beyond the rounding of pi itself x-hat may point the other way, and with it these signs
    changes = [
        abs(abs(out(getattr(again, name))) - abs(out(getattr(euler, name)))) / abs(FN.mpf(size))
        for name, size in RATES.items()
    ]
    return Trip(abs(tilted / sine - 1) / eps, max(changes) / eps)


def digits_of_the_tilt(precision: str, k: int, known: bool) -> float:
    """Decimal digits of the tilt that are right 1e-k rad from the inverted pole."""
    trip = round_trip(precision, k, True, known, vectors_from_euler, euler_from_vectors)
    eps = arithmetic(precision).eps
    # half an eps is what rounding leaves of a tilt that is exact
    return max(0.0, float(-FN.log10(max(trip.tilt, FN.mpf(1) / 2) * eps)))


@case(
    "Euler to vectors and back, 1e-k rad from the upright pole, in {precision}",
    expected="no digit lost at any k from 0 to 300",
    source="theta and sin theta have the same relative error there; some ten roundings",
    over={"precision": PRECISIONS},
    quick=True,
    control={"back": "printed"},
)
def beside_the_upright_pole(
    precision: str, back: Convert | str = euler_from_vectors
) -> Observation:
    """Both ways, every decade."""
    convert = _printed_back if isinstance(back, str) else back
    trips = [
        round_trip(precision, k, False, False, vectors_from_euler, convert) for k in range(0, 301)
    ]
    return together(
        within(max(trip.tilt for trip in trips), 4, "eps of the tilt"),
        within(max(trip.rate for trip in trips), 40, "eps of the rates"),
    )


@case(
    "Euler to vectors and back, 1e-k rad from the inverted pole, in {precision}",
    expected="no digit lost at any k from 0 to 300, where the distance from pi is what is given",
    source="as at the upright pole; a scene stores the distance from the nearer pole",
    over={"precision": PRECISIONS},
    quick=True,
    control={"known": False},
)
def beside_the_inverted_pole(precision: str, known: bool = True) -> Observation:
    """With the sine and cosine that a scene's ``pi - 1e-300`` leads to."""
    trips = [
        round_trip(precision, k, True, known, vectors_from_euler, euler_from_vectors)
        for k in range(0, 301)
    ]
    return together(
        within(max(trip.tilt for trip in trips), 4, "eps of the tilt"),
        within(max(trip.rate for trip in trips), 40, "eps of the rates"),
    )


@case(
    "theta alone, 1e-k rad from the inverted pole, in {precision}",
    expected="the tilt is off by up to eps 10^k, and by no more: digits are lost in proportion to "
    "the decades; the rates keep theirs",
    source="numbers near pi are 2 eps apart",
    over={"precision": PRECISIONS},
    quick=True,
    control={"known": True},
)
def digits_of_theta_near_pi(precision: str, known: bool = False) -> Observation:
    """The law by which the Euler form loses digits; it ends where no digit is left."""
    last = int(BITS[precision] * 0.30103) - 1
    there, back = vectors_from_euler, euler_from_vectors
    trips = {k: round_trip(precision, k, True, known, there, back) for k in range(1, last + 1)}
    share = max(trip.tilt * FN.mpf(10) ** -k for k, trip in trips.items())
    return together(
        within(share, 1.5, "eps 10^k"),
        Observation("reached in part" if share > 0.3 else "never reached", bool(share > 0.3)),
        within(max(trip.rate for trip in trips.values()), 40, "eps of the rates"),
    )


@case(
    "theta = 1e-{k} in double, where numbers have fewer digits",
    expected="the tilt keeps the digits that the number theta has",
    source="subnormal numbers are 2^-1074 apart",
    over={"k": (308, 312, 318, 323)},
    quick=True,
    control={"fewer": 100.0},
)
def subnormal_theta(k: int, fewer: float = 1.0) -> Observation:
    """No NaN and no lost digit beyond those that no number has."""
    trip = round_trip("double", k, False, False, vectors_from_euler, euler_from_vectors)
    spacing = FN.ldexp(1, -1074) * FN.mpf(10) ** k * FN.ldexp(1, 52)
    return within(fewer * (trip.tilt / (spacing + 1)), 1, "spacings of the numbers")


@case(
    "Euler form from theta(0) = {pole}1e-k",
    expected="beside the upright pole as good as Newton's; beside the inverted one off by "
    "eps 10^k, which is digits lost in proportion to the decades",
    source="the linear equations of the tilt, and the spacing of numbers near pi",
    over={"pole": ("", "pi - ")},
    quick=True,
    control={"pole_of_the_law": "other"},
)
def euler_against_newton(pole: str, pole_of_the_law: str = "") -> Observation:
    """Integrated in Euler form in double, against the linear theory."""
    errors = {}
    for k in range(8, 16):
        scene = varied(theta=f"{pole}1e-{k}", until="0.1")
        run = integrate(scene, formulation="euler", record=("phi",))
        errors[k] = tilt_error(run, scene)
    lost = bool(pole) != bool(pole_of_the_law)
    shares = [error * (10.0**-k if lost else 1) for k, error in errors.items()]
    visible = max(shares) > (0.1 if lost else 0)
    # each of 25 steps rounds theta again
    return together(
        within(max(shares), 30, "eps 10^k" if lost else "eps"),
        Observation("the law is reached in part" if visible else "the law is not reached", visible),
    )


@cache
def _body(precision: str) -> Parameters:
    top = load_scene("reference").body.dimensionless(FN, rounding_to(FN))
    into = arithmetic(precision).into
    return top.map(lambda x: into(FN.convert(x)))


def _printed_back(body: Parameters, state: NewtonState, fn: Functions) -> EulerState:
    """The textbook's phi_dot = (Lz - cos L.k)/(I1 sin^2), which cancels beside the poles."""
    right = euler_from_vectors(body, state, fn)
    sine_squared = state.kx * state.kx + state.ky * state.ky
    along = body.I3 * right.omega_3
    numerator = state.Lz - state.kz * along
    return right._replace(phi_dot=numerator / (body.I1 * sine_squared) if sine_squared else along)
