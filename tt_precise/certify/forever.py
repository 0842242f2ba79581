"""What a solution does for ever, once it has come near a vertical spin: a theorem.

Near the inverted spin k = -z (or the upright one k = +z) the state is determined by lambda, which
is constant, and x = (kx, ky, Lx, Ly, vx, vy): kz = -+ sqrt(1 - kx^2 - ky^2), and lambda is linear
in Lz. So x' = f(x). A turn by pi about the vertical maps x to -x and solutions to solutions, hence
f(-x) = -f(x): f has no constant and no quadratic term at x = 0, the vertical spin itself.

In coordinates z = S^-1 x, with a matrix S of exact numbers near real and imaginary parts of the
eigenvectors of Df(0), let |z_p| be the Euclidean length of the p-th of three pairs, F(z) =
S^-1 f(S z), L = DF(0). Let w_p > 0, and Z = {z: |z_p| <= w_p for each p}. Verified in balls:

- **F1** a_p bounds the logarithmic norm of the pair's own block of L, c_pq the norm of its blocks
  beside it, and b_pq those of the matrices with the entries sum over k of H_ijk z_k/2, where z is
  in Z and H_ijk contains the second derivatives of F_i on all of Z.
- **F2** a_p w_p + sum over q of (c_pq + b_pq) w_q <= -rate w_p with rate > 0, for each p.
- **F3** the contact force g_n is at least ``force`` > 0 on Z.
- **F4** At some time t0 the solution is proved to lie in Z: |z_p| <= r w_p with r <= 1.

**Theorem.** Under F1 to F4 the solution exists for all t >= t0, loses contact nowhere, and

    |z_p(t)| <= r w_p exp(-rate (t - t0)).

So theta -> pi (or 0), v -> 0 and L -> Lz z exponentially, where lambda determines the limit of Lz:
D, the energy E and the modified energy E~ tend to their values at that vertical spin.

*Proof.* By Taylor's theorem F(z) = L z + N(z), N_i = sum of (integral of (1 - h) H_ijk(h z) dh)
z_j z_k over j and k, as F(0) = 0, and Z is convex and contains h z; 1 - h integrates to 1/2. So
|N_p| <= sum over q of b_pq |z_q|, and |z_p|' <= a_p |z_p| + sum over q of (c_pq + b_pq) |z_q| as
long as z stays in Z (upper right derivatives). With m = max |z_p|/w_p this is m' <= -rate m by F2,
as the coefficients b and c are not negative. Then m falls, z never leaves Z, on which f is defined
and bounded, and the solution goes on for ever with m(t) <= m(t0) exp(-rate (t - t0)). ∎

(That H need only contain H(h z) - H(0) is not used; it is small because H(0) = 0 and Z is.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import flint
import numpy
from flint import arb, arb_mat

from tt_precise.certify.balls import around, largest
from tt_precise.certify.energy_well import held
from tt_precise.certify.slopes import Slope, variables
from tt_precise.certify.verdict import NotProved
from tt_precise.certify.vertical_spin import COLUMNS, Reduced, TrappingBlock, entries
from tt_precise.golden.enclosures import Enclosures
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

PAIRS = (slice(0, 2), slice(2, 4), slice(4, 6))
BITS = 128
ROOM = arb(1.01).mid()  # the block is this much larger than what has to lie in it
# of the largest: a pair that has died out needs room for what the others drive it to
SMALLEST = (0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)


def forever(scene: Scene, enclosures: Enclosures) -> dict[str, TrappingBlock]:
    """What holds the solution for ever, from rows of its enclosure on.

    ``held`` is where the energy alone does so first (``energy_well``), with the largest bounds and
    no rate; ``entered`` the first block that contracts, and slowly; ``at_the_end`` that of the
    last row, which comes close to the linear rates. What is not proved is absent.

    Raises
    ------
    NotProved
        Not even the last row is held; the scene may have to be proved for longer.
    """
    count = len(enclosures.rows.rows)
    if scene.model != "gliding" or not scene.body.mu:
        raise NotProved("F2", "without friction nothing tends to a vertical spin")
    if scene.start.theta.at_pole:
        raise NotProved("F4", "the axis is vertical from the start, and nothing tends to it")
    if not count:
        raise NotProved("F4", "no row is enclosed")
    with flint.ctx.workprec(BITS):
        last = count - 1
        pole = 1 if entries(scene, enclosures, last)["kz"] > 0 else -1
        found = {"held": _first(last, lambda row: held(scene, enclosures, row))}
        try:
            frame = _Frame(Reduced(scene, pole))
            final = frame.entered(scene, enclosures, last)
            found["entered"] = _first(last, lambda row: frame.entered(scene, enclosures, row))
            found["at_the_end"] = final
        except NotProved:
            pass
        return found


def _first(last: int, block: Callable[[int], TrappingBlock]) -> TrappingBlock:
    """The block of the first row that has one; rows after it have one, too."""
    found, low, high = block(last), -1, last
    while high - low > 1:
        middle = (low + high) // 2
        try:
            found, high = block(middle), middle
        except NotProved:
            low = middle
    return found


class _Frame:
    """Coordinates near the eigenvectors of Df(0)."""

    def __init__(self, reduced: Reduced):
        self.reduced = reduced
        linear = _jacobian(reduced.rates([*variables([arb(0)] * 6)]))
        floats = numpy.array([[float(x.mid()) for x in row] for row in linear])
        values, vectors = numpy.linalg.eig(floats)
        upper = [i for i in numpy.argsort(values.real) if values[i].imag > 0]
        if len(upper) != len(PAIRS):
            raise NotProved("F1", "the linear motion is not one of three oscillations")
        columns = [part for i in upper for part in (vectors[:, i].real, -vectors[:, i].imag)]
        self.basis = arb_mat(numpy.array(columns).T.tolist())
        try:
            self.inverse = self.basis.inv()
        except ZeroDivisionError:
            raise NotProved("F1", "no basis could be found") from None
        self.linear = self.inverse * arb_mat(linear) * self.basis

    def entered(self, scene: Scene, enclosures: Enclosures, row: int) -> TrappingBlock:
        known = entries(scene, enclosures, row)
        if not known["kz"] * self.reduced.pole > 0:
            raise NotProved("F4", "the axis is nearer to the other pole")
        x = arb_mat(6, 1, [known[name] for name in COLUMNS])
        z = (self.inverse * x).entries()
        lengths = [length(z[pair]) for pair in PAIRS]
        longest = largest(lengths)
        why = NotProved("F2", "nothing was tried")
        for smallest in SMALLEST:
            weights = [(largest([one, longest * smallest]) * ROOM).upper().mid() for one in lengths]
            try:
                rate, force = self._contraction(weights)
            except NotProved as error:
                why = error
                continue
            reached = largest(one / w for one, w in zip(lengths, weights, strict=True))
            box = self._box(weights)
            tilt = length([box[0].abs_upper(), box[1].abs_upper()])
            return TrappingBlock(
                self.reduced.pole,
                enclosures.rows.rows[row][0],
                rate / self.reduced.units.time,
                force,
                tilt,
                reached,
                self.reduced.limits(),
            )
        raise why

    def _box(self, weights: Sequence[arb]) -> list[arb]:
        each = [around(w) for w in weights for _ in range(2)]
        found: list[arb] = (self.basis * arb_mat(6, 1, each)).entries()
        return found

    def _contraction(self, weights: Sequence[arb]) -> tuple[arb, arb]:
        """F1 to F3: the rate at which all that is within the weights contracts, and a force."""
        force = self.reduced.force(self._box(weights))
        if not force > 0:
            raise NotProved("F3", "the contact force is not proved to be positive")
        bends = self._second(weights)
        rates = []
        for p, pair in enumerate(PAIRS):
            total = arb(0)
            for q, other in enumerate(PAIRS):
                block = [[self.linear[i, j] for j in _indices(other)] for i in _indices(pair)]
                if p == q:
                    (a, b), (c, d) = block
                    total += (largest([a, d]) + abs(b + c) / 2) * weights[p]
                else:
                    total += length([x for line in block for x in line]) * weights[q]
                bent = [
                    sum(
                        (bends[i][j][k].abs_upper() * weights[k // 2] for k in range(6)),
                        start=arb(0),
                    )
                    / 2
                    for i in _indices(pair)
                    for j in _indices(other)
                ]
                total += length(bent) * weights[q]
            rates.append(-total / weights[p])
        rate = -largest(-one for one in rates)
        if not rate > 0:
            raise NotProved("F2", "the block is not proved to contract")
        return rate, force.lower()

    def _second(self, weights: Sequence[arb]) -> list[list[list[arb]]]:
        """Balls around the second derivatives of F on the block."""
        inner = variables([around(w) for w in weights for _ in range(2)])
        outer = [Slope(one, {i: arb(1)}) for i, one in enumerate(inner)]
        zero = Slope(Slope(arb(0), {}), {})
        x = [sum((outer[j] * self.basis[i, j] for j in range(6)), start=zero) for i in range(6)]
        rates = self.reduced.rates(x)
        bends = [[[arb(0)] * 6 for _ in range(6)] for _ in range(6)]
        for n, rate in enumerate(rates):
            for j, slope in rate.partials.items():
                for k, bend in getattr(slope, "partials", {}).items():
                    for i in range(6):
                        bends[i][j][k] += self.inverse[i, n] * bend
        return bends


def _jacobian(rates: Sequence[Scalar]) -> list[list[arb]]:
    return [[arb(rate.partials.get(j, 0)) for j in range(6)] for rate in rates]


def _indices(pair: slice) -> range:
    return range(pair.start, pair.stop)


def length(numbers: Sequence[arb]) -> arb:
    """An upper bound of the Euclidean length."""
    return sum((x * x for x in numbers), start=arb(0)).sqrt().upper()
