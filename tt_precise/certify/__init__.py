"""Proven digits: enclosures of exact solutions, in ball arithmetic, rounding included.

The problem is exact: y' = f(y), y(0) = y0 with the parameters and the start as the scene writes
them (dimensionless vectors k, L and the velocity of the centre of mass; irrational numbers such as
mu sqrt(g R) are balls as tight as the precision). heyoka's Taylor polynomials serve as an
approximate solution. Nothing is assumed about them: the proof holds for any polynomials.

**One step.** Let p be polynomials on 0 <= s <= S, time t = t0 + u s with an exact unit u; F = u f;
w > 0 weights, |x| = max |x_i|/w_i and ||.|| the operator norm that belongs to it. All bounds
below are verified at run time, by a ``TaylorModel`` (a polynomial with balls as coefficients that
contains a function at each s of the interval):

- **B** Balls contain the exact results of the operations. (Tested against rational arithmetic.)
- **S1** |F(p(s)) - p'(s)| <= d on [0, S].
- **S2** T is a tube that contains every p(s) + x with |x| <= r. On it F is defined and continuously
  differentiable (each division met a divisor that excludes zero), DF(y) lies in the band A(s) for
  every y of the tube at s, and every matrix in A has a logarithmic norm of at most a >= 0, the
  largest of M_ii + sum over j != i of |M_ij| w_j/w_i.
- **S3** P is a polynomial matrix, P(0) = 1, with ||M P - P'|| <= q for every matrix M in A(s).
- **S4** (|e0| + d S) exp(a S) < r for every e0 in the set of initial errors E0.

**Theorem.** Under B and S1 to S4 the solution y that starts at t0 from p(0) + e0, e0 in E0,
exists on the whole step and is unique. With G = (exp(a S) - 1)/a, or S where a = 0,

    |y - p(s)| <= (|e0| + d S) exp(a S)                      for all s in [0, S], and
    y(S) = p(S) + (P(S) + Q) e0 + x    with  ||Q|| <= q G  and  |x| <= d G.

*Proof.* f is continuously differentiable near p(0) + e0, so y exists and is unique as long as it
stays in the tube. There e = y - p obeys e' = F(p + e) - F(p) + (F(p) - p') = M(s) e + c(s), where
M(s), the integral of DF(p + h e) over 0 <= h <= 1, lies in A(s), which is convex, and |c| <= d. So
|e|' <= a |e| + d (Dahlquist and Lozinskii, 1958), and Gronwall gives |e(s)| <= |e0| exp(a s)
+ d (exp(a s) - 1)/a, which is at most (|e0| + d S) exp(a S) < r: e cannot be the first time at the
tube's wall, and y exists up to S. Let W be the fundamental matrix of M with W(0) = 1; the norm of
W(S) W(s)^-1 is at most exp(a (S - s)). (W - P)' = M (W - P) + (M P - P'), so W - P is the integral
of W(S) W(s)^-1 (M P - P') ds, at most q G; and e(S) = W(S) e0 + integral of W(S) W(s)^-1 c(s) ds,
where the integral is at most d G. ∎

Components that are zero identically (``exact_zeros``) are left out of all this and are exact. From
step to step the set of errors is represented as B z, z in a box (a Lohner set), and shifted by the
gap between the end of one polynomial and the start of the next. By induction every state is
enclosed at every time. A step that fails to verify is halved; if the halves fail too, the failure
ends the enclosure there and is reported as ``NotProved``.

Hypotheses other than bounds are verified too: polynomials, ends and units of time are exact numbers
(``Piece``), and the arithmetic rounds outward (``balls``, against rational arithmetic).

From it follow proved signs (g_n > 0 throughout, so E' = -mu g_n v^2 <= 0: the energy never grows),
proved zeros (``interval_newton``: existence, uniqueness, enclosure of time and state; at t = 0,
where many functions vanish, ``onset`` decides exactly), hence proved initiation and ending times,
and the count of proved printed digits (``comparison``). The motion after the horizon is the subject
of ``energy_well``; ``checker`` is a second, independent program.

    >>> import dataclasses
    >>> import tt_precise as tt
    >>> from tt_precise.certify import prove
    >>> proof = prove(dataclasses.replace(tt.load_scene("reference"), until="0.02"))
    >>> proof.state("0.02")["theta"].str(30)
    '[0.0974468621270673365519920016122 +/- 2.95e-32]'
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.runtime.process import lazy_names

if TYPE_CHECKING:
    from tt_precise.certify.balls import NotProved
    from tt_precise.certify.enclosure import Enclosure, enclose
    from tt_precise.certify.interval_newton import Zero, zeros
    from tt_precise.certify.proof import Proof, prove
    from tt_precise.certify.prover_problem import Problem, problem_of

__all__ = [
    "Enclosure", "NotProved", "Problem", "Proof", "Zero", "enclose", "problem_of", "prove", "zeros",
]  # fmt: skip

# proofs on disk can be read without python-flint, which the other modules import
__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "enclosure": ["Enclosure", "enclose"],
        "interval_newton": ["Zero", "zeros"],
        "prover_problem": ["Problem", "problem_of"],
        "proof": ["Proof", "prove"],
        "balls": ["NotProved"],
    },
)
