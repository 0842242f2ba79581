"""Where the energy alone holds a solution for ever: a theorem for motions that contract too slowly.

With strong friction the contact point almost rolls, and what is left of gliding takes hours to
carry the axis to the vertical: no block of ``forever`` contracts where the enclosed solution is.
The energy falls, though, as E' = -mu g_n v^2 (regularised friction has a positive, smooth function
of v for mu), and lambda = -L.a is constant. Given both lambda and the inclination, with
z = cos theta, the energy is least, U(z), for L = L* = -lambda I a/(a.I a) and a centre of mass at
rest (``mechanics.thresholds.least_energy``), and

    E = U(z) + (L - L*).I^-1 (L - L*)/2 + m s'^2/2.

Let z0 = 1 or -1, w and v1 numbers and Y the states with this lambda, z between z1 and z0, E <= w
and |v| <= v1 (or any v, where that is not needed). Verified in balls, for z in slices from z0 to
z1:

- **W1** No tumbling motion (steady, without gliding, axis inclined) has this lambda
  (``mechanics.thresholds.tumbling_lambda_squared``: these are the stationary points of U).
- **W2** On Y the contact force is at least ``force`` > 0, and L.k is not zero.
- **W3** U(z1) > w.
- **W4** At some time t0 the solution is proved to have z between z1 and z0, E <= w and |v| < v1.
- **W5** v.v' < 0 on Y where |v| = v1: with strong friction all but slow gliding dies out.

**Theorem.** Under W1 to W5 the solution stays in Y and exists for all t >= t0, loses contact
nowhere, and tends to the vertical spin at z0: theta -> 0 or pi, v -> 0, L -> Lz z, and D, E
and E~ tend to their values there. A rate is not proved.

*Proof.* In Y E does not grow, so the solution reaches neither z1, where E >= U(z1) > w, nor |v| =
v1, and stays in the bounded set Y: it exists for ever, and by LaSalle's principle tends to the
largest invariant set in Y on which E' = 0, that is v = 0. Solutions in that set: F = g_n z, so
L' = alpha R g_n k x z, and Lz, L.k and with s'' also the horizontal velocity c of the centre of
mass are constant. In the direction e1 that the axis leans in, and e2 = z x e1, which turn with
phi_dot, v = 0 says c.e1 = R (1 - alpha cos theta) theta_dot and c.e2 = -B, with B = R sin theta
(omega_3 + (alpha - cos theta) phi_dot). As c is constant, (c.e2)' = -phi_dot c.e1, or
theta_dot (B'(theta) - phi_dot R (1 - alpha cos theta)) = 0, where phi_dot = (Lz - L.k cos theta)/
(I1 sin^2 theta). The bracket is omega_3 R (cos theta + (alpha - cos theta) I3/I1): zero in an
interval of theta only if omega_3 = 0, which W2 excludes. So theta is constant. Inclined, it needs
L' = phi_dot z x L, or phi_dot (L.k - I1 phi_dot cos theta) = -alpha m g R, hence phi_dot is not
zero; then (c.e1)' = phi_dot c.e2 = 0 makes c and B zero: a tumbling motion, which W1 excludes. So
it is vertical, at z0, with L parallel to k. ∎
"""

from __future__ import annotations

from flint import arb

from tt_precise.certify.balls import Balls, around, between, largest
from tt_precise.certify.verdict import NotProved
from tt_precise.certify.vertical_spin import Reduced, TrappingBlock, entries
from tt_precise.golden.enclosures import Enclosures
from tt_precise.mechanics.centre import CentreState
from tt_precise.mechanics.formulations import integrated
from tt_precise.mechanics.newton import NewtonState, arm
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.thresholds import least_energy, tumbling_lambda_squared
from tt_precise.mechanics.vectors import added, dot, scaled
from tt_precise.scene.scene import Scene

FORM = integrated("gliding", "newton")
SLICES, MOST_SLICES = 64, 1000  # from z0 to where the solution is, and to z1
WIDER = arb("1.04").mid()  # each slice than the one before, where the solution never comes
SPEEDS = (None, 0.05, 0.1, 0.2, 0.4)  # v1 in units of sqrt(g R), tried in turn
DIRECTIONS = 32  # of v, for W5


def held(scene: Scene, enclosures: Enclosures, row: int) -> TrappingBlock:
    """W1 to W5 with t0 at a row of an enclosure, for the pole that the axis is nearer to.

    Raises
    ------
    NotProved
        One of them could not be verified.
    """
    known = NewtonState(**entries(scene, enclosures, row))
    reduced = Reduced(scene, 1 if known.kz > 0 else -1)
    energy = arb(QUANTITIES["E"].evaluate(Motion(reduced.body, known, Balls)))
    force, tilt = Well(reduced, known, energy.upper()).held()
    since, limits = enclosures.rows.rows[row][0], reduced.limits()
    return TrappingBlock(reduced.pole, since, None, force, tilt, arb(1), limits)


class Well:
    """The states that a motion may still come to, with an energy no higher than it has now.

    ``now`` may be a whole set of states, ``highest`` bounds the energies that they have.
    """

    def __init__(self, reduced: Reduced, now: NewtonState, highest: arb):
        self.reduced, self.now, self.highest = reduced, now, highest
        self.step = ((1 - reduced.pole * now.kz) / SLICES).upper().mid()

    def held(self) -> tuple[arb, arb]:
        """Verify W1 to W5: a bound of the contact force from now on, and one of sin theta.

        Raises
        ------
        NotProved
            One of them could not be verified, with any of ``SPEEDS``.
        """
        why = NotProved("W2", "nothing was tried")
        for speed in SPEEDS:
            try:
                return self.bounds(None if speed is None else arb(speed))
            except NotProved as error:
                why = error
                if error.hypothesis not in ("W2", "W5"):
                    break
        raise why

    def bounds(self, speed: arb | None) -> tuple[arb, arb]:
        """A bound of the contact force in Y, and one of sin theta; v1 = ``speed``.

        Raises
        ------
        NotProved
            One of W1 to W5 could not be verified.
        """
        body, pole, lambda_ = self.reduced.body, self.reduced.pole, self.reduced.lambda_
        if speed is not None and not dot(self.now.v, self.now.v) < speed * speed:
            raise NotProved("W5", "it glides faster")
        forces: list[arb] = []
        depth, step = arb(0), self.step
        for i in range(MOST_SLICES):
            beyond = (depth + step).upper().mid()
            if not beyond < 1:
                break
            z = pole * (1 - between(depth, beyond))
            depth, step = beyond, step if i < SLICES else step * WIDER
            surplus = self.highest - arb(least_energy(body, z, lambda_))
            if surplus < 0 and i > SLICES:
                return -largest(-one for one in forces), (1 - z * z).sqrt().upper()
            if (tumbling_lambda_squared(body, z) - lambda_ * lambda_).contains(0):
                raise NotProved("W1", "a tumbling motion with this lambda is not excluded")
            forces.append(self._force(z, 2 * surplus.nonnegative_part().upper(), speed))
        raise NotProved("W3", "the energy is too high")

    def _force(self, z: arb, budget: arb, speed: arb | None) -> arb:
        """W2 and W5 in one slice, where 2 (E - U(z)) <= ``budget``.

        The axis may lean towards X: all turns about the vertical are alike.
        """
        body = self.reduced.body
        k = ((1 - z * z).nonnegative_part().sqrt(), arb(0), z)
        a = arm(body, k)
        # I a, for an inertia I1 across the axis and I3 along it
        turned = added(scaled(body.I1, a), scaled((body.I3 - body.I1) * dot(a, k), k))
        middle = scaled(-self.reduced.lambda_ / dot(a, turned), turned)
        spread = around((budget * largest([arb(body.I1), arb(body.I3)])).sqrt().upper())
        L = added(middle, (spread, spread, spread))
        if speed is None:
            any_speed = around(budget.sqrt().upper())
            state = FORM.motion(body, CentreState(*k, *L, any_speed, any_speed), Balls).state
        else:
            state = NewtonState(*k, *L, around(speed), around(speed))
        force = arb(self.reduced.force_of(state))
        if not force > 0 or dot(L, k).contains(0):
            raise NotProved("W2", "the contact force, or the spin, may vanish")
        for i in range(DIRECTIONS if speed is not None else 0):
            angle = between(arb(i) / DIRECTIONS, arb(i + 1) / DIRECTIONS) * 2 * arb.pi()
            state = state._replace(vx=speed * angle.cos(), vy=speed * angle.sin())
            rate = self.reduced.rates_of(state)
            if not rate.vx * state.vx + rate.vy * state.vy < 0:
                raise NotProved("W5", "gliding may become faster")
        return force.lower()
