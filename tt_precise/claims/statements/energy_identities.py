"""Section 2.3: formulas for the energy, its parts and their rates, and the torque."""

from __future__ import annotations

from collections.abc import Mapping

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.verdicts import (
    Check,
    Finding,
    all_of,
    approximate,
    judged,
    misprint,
    readings,
    statement,
)
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import load_scene

WHERE = "Sec. 2.3"
TRANSLATIONAL = (
    "m/2*((nu_x*cos(theta) - R*theta_dot*(alpha - cos(theta)))**2"
    " + (nu_y - R*sin(theta)*(omega_3 + phi_dot*(alpha - cos(theta))))**2"
    " + (nu_x*sin(theta) + R*theta_dot*sin(theta))**2)"
)
ROTATIONAL = "(I1*(theta_dot**2 + phi_dot**2*sin(theta)**2) + I3*omega_3**2)/2"
POTENTIAL = "m*g*R*(1 - alpha*cos(theta))"
CHAIN = (
    "dot(s_dot, F) - m*g*dot(s_dot, z_hat) + dot(omega, cross(a, F)) + m*g*dot(s_dot, z_hat)",
    "dot(v_A, F) - dot(cross(omega, a), F) - m*g*dot(s_dot, z_hat) + dot(omega, cross(a, F))"
    " + m*g*dot(s_dot, z_hat)",
    "dot(v_A, F_f) - dot(cross(omega, a), F) + dot(omega, cross(a, F))",
    "dot(v_A, F_f)",
    "-mu*g_n*dot(v_A, v_A)",
)
TORQUE = (
    "-R*(1 - alpha*cos(theta))*mu*g_n*nu_y",
    "-R*alpha*g_n*sin(theta) + R*mu*g_n*nu_x*(1 - alpha*cos(theta))",
    "-R*alpha*mu*g_n*nu_y*sin(theta)",
)
DIFFERENCE = "m*dot(v_A, cross(omega, a)) - m*dot(v_A, v_A)/2"


@claim(
    "EQ-31",
    quote="E=E_trans+E_rot+E_pot=...",
    where=f"{WHERE}, eq (22)",
    control={"translational": TRANSLATIONAL.replace("nu_x*sin(theta) +", "nu_x*sin(theta) -")},
)
def energy_split(
    translational: str = TRANSLATIONAL, rotational: str = ROTATIONAL, potential: str = POTENTIAL
) -> Finding:
    """The three parts of the energy in Euler angles."""
    printed = {"E_trans": translational, "E_rot": rotational, "E_pot": potential}
    return all_of(
        {name: f.equal(text, f.quantity(name)) for name, text in printed.items()},
        "The bracket of E_trans holds the components of s_dot = v_A - omega x a along 1, y, 3.",
        proved=True,
    )


@claim(
    "EQ-32",
    quote="E_dot=... (four lines)",
    where=f"{WHERE}, eq (23)",
    control={"lines": (CHAIN[0].replace("+ m*g", "- m*g"), *CHAIN[1:])},
    slow=True,
)
def chain_for_the_energy(lines: tuple[str, ...] = CHAIN) -> Finding:
    """Every step of the derivation of E_dot = -mu g_n v_A^2 is right."""
    derived, known = f.rate_of("E"), _vectors()
    return all_of(
        {
            f"step {n}": f.equal(f.read(line, known), derived, line)
            for n, line in enumerate(lines, start=1)
        },
        "Each expression of the chain equals E differentiated along the equations of motion.",
        proved=True,
    )


@claim(
    "EQ-33",
    quote="the equality omega_dot.L=omega.L_dot valid due to axial symmetry",
    where=WHERE,
    definition="for the second reading: any rigid body, three different moments of inertia",
    control={"factor": 2},
)
def symmetry_of_inertia(factor: int = 1) -> Finding:
    """omega_dot.L = omega.L_dot, and axial symmetry is why."""
    q, rates = f.motion(), f.vector_rates()
    L_dot = (rates.Lx, rates.Ly, rates.Lz)
    # (omega.L)_dot = 2 (E_rot)_dot, so omega_dot.L is what L_dot leaves of it
    omega_dot_L = 2 * f.rate_of("E_rot") - dot(q.omega, L_dot)
    top = f.equal(factor * omega_dot_L, dot(q.omega, L_dot), "omega_dot.L = omega.L_dot")
    needs_symmetry = top.holds and not _holds_for_any_body(factor)
    return readings(
        {
            "that the two are equal": top,
            "that it takes axial symmetry": statement(
                needs_symmetry,
                printed="valid due to axial symmetry",
                measured="needs axial symmetry" if needs_symmetry else "holds for every rigid body",
            ),
        },
        "The inertia tensor is a symmetric matrix in every rigid body, which is all that is used.",
        proved=True,
    )


def _holds_for_any_body(factor: int) -> bool:
    import sympy

    moments = sympy.symbols("A B C", positive=True)
    omega = sympy.Matrix(sympy.symbols("p q r"))
    omega_dot = sympy.Matrix(sympy.symbols("p_dot q_dot r_dot"))
    inertia = sympy.diag(*moments)
    L = inertia * omega
    L_dot = inertia * omega_dot + omega.cross(L)
    return bool(sympy.expand(omega_dot.dot(L) - factor * omega.dot(L_dot)) == 0)


@claim(
    "EQ-34",
    quote="m g s_dot.z is the rate of energy transfer ... into E_pot",
    where=WHERE,
    control={"weight": "m*g*dot(v_A, z_hat)"},
    slow=True,
)
def transfers(
    weight: str = "m*g*dot(s_dot, z_hat)", torque: str = "dot(omega, cross(a, F))"
) -> Finding:
    """m g s_dot.z passes from E_trans to E_pot, and omega.(a x F) between E_trans and E_rot."""
    known = _vectors()
    to_potential, to_rotation = f.read(weight, known), f.read(torque, known)
    loss = f.read("dot(v_A, F_f)", known)
    return all_of(
        {
            "E_pot gains": f.equal(to_potential, f.rate_of("E_pot"), weight),
            "E_rot gains": f.equal(to_rotation, f.rate_of("E_rot"), torque),
            "E_trans loses both, and what friction takes": f.equal(
                loss - to_potential - to_rotation,
                f.rate_of("E_trans"),
                f"dot(v_A, F_f) - {weight} - {torque}",
            ),
        },
        "E_trans changes by -m g s_dot.z - omega.(a x F) + v_A.F_f, so both terms pass through it.",
        proved=True,
    )


@claim(
    "EQ-35",
    quote="tau_x=..., tau_z=..., tau_y=...",
    where=WHERE,
    control={"printed": (TORQUE[0][1:], *TORQUE[1:])},
)
def torque(printed: tuple[str, str, str] = TORQUE) -> Finding:
    """The components of the torque a x F in the frame (x, y, z)."""
    parts = zip("xyz", printed, f.motion().torque, strict=True)
    return all_of(
        {f"tau_{axis}": f.equal(text, value) for axis, text, value in parts},
        "a x F with a = R(alpha 3 - z) and F = g_n(z - mu v_A).",
        proved=True,
    )


@claim(
    "EQ-36",
    quote="E~=E-m v_A^2/2+m v_A.(omega x a)",
    where=WHERE,
    control={"printed": DIFFERENCE.replace("/2", "")},
)
def modified_energy_from_energy(printed: str = DIFFERENCE) -> Finding:
    """E~ is E - m v_A^2/2 + m v_A.(omega x a)."""
    return judged(
        f.equal(
            f.read(printed, _vectors()),
            f.quantity("E_tilde") - f.quantity("E"),
            f"E~ - E = {printed}",
        ),
        "From m (v_A - omega x a)^2/2 with and without v_A.",
        proved=True,
    )


@claim(
    "EQ-37",
    quote="... approx -m nu_x^2/2 + m nu_y(2|omega x a| - nu_y)/2",
    where=f"{WHERE}, eq (25)",
    definition="root mean square over the climb (definition A) of the reference solution, every "
    "millisecond",
    control={"factor": 4},
)
def estimate_of_the_difference(
    factor: float = 2, scene: evidence.SceneLike = "reference"
) -> Finding:
    """E~ - E is approximately -m nu_x^2/2 + m nu_y (2 |omega x a| - nu_y)/2."""
    climb = evidence.during_the_climb(scene, ("nu_x", "nu_y", "E", "E_tilde", "E_pot", "E_rot"))
    mass = float(load_scene(scene).body.m)
    # E~ is the energy with s_dot = -omega x a
    length = (2 / mass * (climb["E_tilde"] - climb["E_pot"] - climb["E_rot"])) ** 0.5
    truth = climb["E_tilde"] - climb["E"]
    estimate = mass / 2 * (climb["nu_y"] * (factor * length - climb["nu_y"]) - climb["nu_x"] ** 2)
    error = float(((estimate - truth) ** 2).mean() ** 0.5)
    scale = float((truth**2).mean() ** 0.5)
    return judged(
        approximate("approximately equal", error, scale, "relative error"),
        "omega x a is taken to point along y. The line before it multiplies the vector omega x a "
        "by the vector y; |omega x a| y is meant.",
    )


@claim(
    "EQ-38",
    quote="2|omega x a|-nu_y=2|omega||a| sin theta-nu_y>0",
    where=f"{WHERE}, after eq (25)",
    definition="for omega parallel to z, which the paper assumes there",
    control={"printed": "R*alpha*sin(theta)"},
)
def length_of_omega_cross_a(printed: str = "absolute_a*sin(theta)") -> Finding:
    """|omega x a| is |omega||a| sin theta."""
    symbols, q = f.chart(), f.motion()
    spin = (0, 0, symbols.state.phi_dot)
    truth = dot(cross(spin, q.a), cross(spin, q.a)) / symbols.state.phi_dot**2
    correct = "R*alpha*sin(theta)"

    def squared(text: str) -> Check:
        # |a| is a root that is no rational function of the symbols: |a|^2 stands for it twice
        factor = f.read(text.replace("absolute_a*", ""))
        times = dot(q.a, q.a) if "absolute_a" in text else 1
        shown = f"|omega x a| = |omega|*{text.replace('absolute_a', '|a|')}"
        return f.equal(factor**2 * times, truth, shown)

    return misprint(
        squared(printed),
        squared(correct),
        f"|omega| {correct}",
        "theta is the angle between z and 3, not between omega and a. With a = R(alpha 3 - z) the "
        "part along omega drops out; |a| is between R(1 - alpha) and R(1 + alpha).",
        proved=True,
    )


@claim(
    "EQ-41",
    quote="negative whenever nu_y>0 ... whenever nu_x<0 or nu_x is sufficiently small",
    where=WHERE,
    definition="where g_n > 0 and 0 < theta < pi",
    control={"printed": (TORQUE[0], TORQUE[1].replace("-R*alpha", "R*alpha"), TORQUE[2])},
)
def signs_of_the_torque(printed: tuple[str, str, str] = TORQUE) -> Finding:
    """tau_x, tau_z < 0 where nu_y > 0, and tau_y < 0 where nu_x is negative or small."""
    factors = {
        "tau_x per nu_y": ("-mu*R*g_n*(1 - alpha*cos(theta))", printed[0], "nu_y"),
        "tau_z per nu_y": ("-mu*R*g_n*alpha*sin(theta)", printed[2], "nu_y"),
    }
    known = f.names()
    checks = {
        name: f.equal(f.read(f"({text})/{velocity}", known), f.read(negative, known), text)
        for name, (negative, text, velocity) in factors.items()
    }
    bound = "alpha*sin(theta)/(mu*(1 - alpha*cos(theta)))"
    slope = f.read("R*mu*g_n*(1 - alpha*cos(theta))")
    checks["tau_y < 0 below a bound on nu_x"] = f.equal(
        f.read(printed[1]), slope * (f.read("nu_x") - f.read(bound)), printed[1]
    )
    return all_of(
        checks,
        f"tau_y is a positive factor times nu_x - {bound}: negative for nu_x below that positive "
        "bound, which is what sufficiently small means.",
        proved=True,
    )


def _vectors() -> Mapping[str, Scalar]:
    q = f.motion()
    F = q.force
    return dict(f.names()) | {
        "dot": dot, "cross": cross, "s_dot": q.s_dot, "v_A": q.state.v, "omega": q.omega,
        "a": q.a, "F": F, "F_f": (F[0], F[1], 0), "z_hat": (0, 0, 1),
    }  # fmt: skip
