"""Section 2.1: Jellett's integral rewritten for phi_dot, eq (21)."""

from __future__ import annotations

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.verdicts import Check, Finding, judged, misprint

WHERE = "Sec. 2.1, eq (21)"
RIGHT = "lambda_/(R*I3) + omega_3*(alpha - cos(theta))"
CORRECT = "lambda_/(R*I1) + omega_3*(alpha - cos(theta))/gamma"
START = "-R*I3*omega_3*(alpha - cos(theta))"


@claim(
    "EQ-28",
    quote="phi_dot sin^2 theta=lambda/(R I3)+omega_3(alpha-cos theta)",
    where=WHERE,
    control={"printed": CORRECT},
)
def precession_from_jellett(printed: str = RIGHT) -> Finding:
    """Jellett's integral solved for phi_dot sin^2 theta."""
    known = dict(f.names()) | {"lambda_": f.quantity("lambda")}
    left = f.read("phi_dot*sin(theta)**2")

    def compared(text: str) -> Check:
        return f.equal(f.read(text, known), left, f"phi_dot*sin(theta)**2 = {text}")

    return misprint(
        compared(printed),
        compared(CORRECT),
        f"phi_dot*sin(theta)**2 = {CORRECT}",
        "The printed right side is gamma phi_dot sin^2 theta, gamma = I1/I3; the factor is "
        "positive, so what the paper says of signs stands.",
        proved=True,
    )


@claim(
    "EQ-29",
    quote="-omega_3(0)(alpha-cos theta(0))+... =omega_3(0)(alpha-cos theta(0))(1-quotient)",
    where=WHERE,
    definition="w0 = omega_3(0)(alpha - cos theta(0)), w = omega_3(alpha - cos theta), quotient "
    "w/w0",
    control={"printed": "-w0*(1 - w/w0)"},
)
def factored_form(printed: str = "w0*(1 - w/w0)") -> Finding:
    """The last step takes w0 out of -w0 + w."""
    correct = "-w0*(1 - w/w0)"
    # w and w0 are independent quantities: any two symbols of the chart stand for them
    symbols = f.chart()
    known = {"w": symbols.state.nu_x, "w0": symbols.state.nu_y}

    def compared(text: str) -> Check:
        return f.equal(f.read(text, known), f.read("-w0 + w", known), f"-w0 + w = {text}")

    return misprint(
        compared(printed),
        compared(correct),
        f"-w0 + w = {correct}",
        "The sign is lost. alpha - cos theta(0) < 0, so only with the minus does phi_dot have the "
        "sign of 1 - quotient, as the text goes on to say.",
        proved=True,
    )


@claim(
    "EQ-30",
    quote="since lambda=-R I3 omega_3(0)(alpha-cos theta(0))",
    where=f"{WHERE}, after it",
    definition="at the reference start, phi_dot(0) = 0",
    control={"printed": START.replace("I3", "I1")},
)
def jellett_of_the_start(printed: str = START) -> Finding:
    """lambda of a start with phi_dot(0) = 0."""
    symbols = f.chart()
    started = symbols.field(f.quantity("lambda"))
    phi_dot = symbols.symbol["phi_dot"].numer
    at_rest = symbols.field(started.numer.subs(phi_dot, 0)) / symbols.field(started.denom)
    return judged(
        f.equal(printed, at_rest, f"lambda = {printed}"),
        "Jellett's integral at phi_dot(0) = 0, for every theta(0) and omega_3(0).",
        proved=True,
    )
