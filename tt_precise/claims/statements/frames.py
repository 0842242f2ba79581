"""Section 1: frames, the arm a, angular velocity, and the contact constraint."""

from __future__ import annotations

from functools import cache

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.verdicts import Finding, all_of, statement
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import added, cross, dot, scaled

OMEGA = ("-phi_dot*sin(theta)", "theta_dot", "psi_dot + phi_dot*cos(theta)")


@claim("EQ-01", quote="a=R(alpha 3 - z)", where="Sec. 1, Fig. 1", control={"along_3": "-R*alpha"})
def arm(along_3: str = "R*alpha", along_z: str = "-R") -> Finding:
    """The vector from the centre of mass to the contact point is a = R alpha 3 - R z."""
    q, body = f.motion(), f.chart().body
    printed = added(scaled(f.read(along_3), q.k), (0, 0, f.read(along_z)))
    from_centre = added(printed, scaled(-body.R * body.alpha, q.k))
    height = f.quantity("E_pot") / (body.m * body.g)
    shown = f"a = {along_3} 3 + ({along_z}) z"
    return all_of(
        {
            "A is the lowest point of the sphere": f.equal_vectors(
                from_centre, (0, 0, -body.R), shown
            ),
            "CM stands -a.z above the table, as in E_pot": f.equal(-printed[2], height, shown),
        },
        "O lies R alpha along 3 from the centre of mass, and A is the sphere's lowest point, R "
        "below O; -a.z is then the height R(1 - alpha cos theta) of the potential energy.",
        proved=True,
    )


@claim(
    "EQ-02",
    quote="omega=-phi_dot sin theta 1 + theta_dot 2 + (psi_dot+phi_dot cos theta) 3",
    where="Sec. 1",
    definition="the body is turned by phi about z, then theta about y, then psi about 3",
    control={"printed": ("phi_dot*sin(theta)", *OMEGA[1:])},
    slow=True,
)
def angular_velocity(printed: tuple[str, str, str] = OMEGA) -> Finding:
    """The angular velocity in the frame (1, 2, 3), from the Euler angles."""
    symbols = f.chart()
    c, s, C, S = symbols.c, symbols.s, symbols.C, symbols.S
    one, two, three = (c * C, c * S, -s), (-S, C, 0 * c), (s * C, s * S, c)
    turning = {axis: tuple(map(f.rate, axis)) for axis in (one, two, three)}
    derived = (
        dot(turning[two], three),
        dot(turning[three], one),
        dot(turning[one], two) + f.read("psi_dot"),
    )
    parts = zip("123", printed, derived, strict=True)
    return all_of(
        {axis: f.equal(text, value) for axis, text, value in parts},
        "The frame turns with (2_dot.3, 3_dot.1, 1_dot.2), and the body in it with psi_dot about "
        "3.",
        proved=True,
    )


@claim(
    "EQ-03",
    quote="3_dot=omega x 3=(L x 3)/I1",
    where="eq (1)",
    control={"inverse_inertia": "1/I3"},
)
def axis_turns(inverse_inertia: str = "1/I1") -> Finding:
    """The axis changes at the rate omega x 3 = L x 3/I1."""
    q = _at_any_azimuth()
    geometric = tuple(f.rate(component) for component in q.k)
    printed = scaled(f.read(inverse_inertia), cross(q.state.L, q.k))
    return all_of(
        {
            "omega x 3": f.equal_vectors(cross(q.omega, q.k), geometric, "3_dot = omega x 3"),
            "L x 3": f.equal_vectors(printed, geometric, f"3_dot = ({inverse_inertia}) L x 3"),
        },
        "The component of L along 3 drops out, and the others are I1 times those of omega.",
        proved=True,
    )


@claim(
    "EQ-07",
    quote="(s+a).z=0 and its derivative ... v_A.z=0",
    where="Sec. 1",
    control={"rate_of_a": "R"},
)
def contact_constraint(rate_of_a: str = "R*alpha") -> Finding:
    """The contact point stays on the table, and the derivative of that is v_A.z = 0."""
    q, body = _at_any_azimuth(), f.chart().body
    axis_rate = tuple(f.rate(component) for component in q.k)
    a_dot = scaled(f.read(rate_of_a), axis_rate)
    height = body.R * (1 - body.alpha * q.k[2])
    return all_of(
        {
            "(s+a).z": f.equal(height + q.a[2], 0 * height, "(s + a).z = 0"),
            "its derivative": f.equal(
                q.s_dot[2] + a_dot[2], q.state.v[2] + 0 * height, "s_dot.z + a_dot.z = v_A.z = 0"
            ),
        },
        "With s.z = R(1 - alpha cos theta). a_dot = R alpha 3_dot is not omega x a, but the two "
        "differ by the horizontal R omega x z.",
        proved=True,
    )


@cache
def _at_any_azimuth() -> Motion:
    symbols = f.chart()
    vectors = vectors_from_euler(symbols.body, symbols.state, symbols, symbols.phi)
    return Motion(symbols.body, vectors, symbols)


@claim(
    "NT-03",
    quote="The axis 2 points behind the plane of the picture",
    where="Sec. 1, Fig. 1",
    definition="a picture of the plane of CM, O, A with z up and the top leaning to the right, so "
    "that x points right and away from the viewer is z x x",
    control={"behind": (0, -1, 0)},
)
def frames(behind: tuple[int, int, int] = (0, 1, 0)) -> Finding:
    """The frames (x, y, z) and (1, 2, 3) are right-handed, lean as in Fig. 1, and 2 points back."""
    q, symbols = f.motion(), f.chart()
    one, two = (symbols.c, 0, -symbols.s), (0, 1, 0)
    plane = cross(q.a, q.k)
    return all_of(
        {
            "1 x 2 = 3": f.equal_vectors(cross(one, two), q.k, "1 x 2 = 3"),
            "CM, O, A lie in the plane of x and z": f.equal(
                dot(plane, (1, 0, 0)) + dot(plane, (0, 0, 1)), 0 * q.a[0], "a and 3 in the plane"
            ),
            "2 = z x x": statement(
                cross((0, 0, 1), (1, 0, 0)) == behind,
                printed="2 points behind the plane",
                measured="2 = y = z x x, behind the plane if the top leans to the right",
            ),
        },
        "The paper's figure was not at hand; its caption and text agree with each other. x, and "
        "with it 1 and 2, is undefined while the axis is vertical.",
        proved=True,
    )
