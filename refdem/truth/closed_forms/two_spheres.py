"""Two solid spheres that collide under a linear contact law, in the frame of their centre of mass.

Start: centres on x, body 1 at negative x, touching (zero overlap) at t = 0: r1 = -(m2/M)(R1 + R2) e_x, r2 = (m1/M)(R1 + R2) e_x,
M = m1 + m2. Relative velocity v1 - v2 = closing_speed (cos angle, sin angle, 0) [angle in rad], so that angle 0 is head-on and
closing_speed is its size, not its normal part; v1 = (m2/M)(v1 - v2), v2 = -(m1/M)(v1 - v2). `spins` are omega1 then omega2, in
space axes. Moments of inertia 2/5 m R^2.

Law, with overlap d = R1 + R2 - |r1 - r2|: normal force k d + c d'. cutoff zero_overlap: it acts, pulling too, until d = 0;
zero_force: max(0, k d + c d'), so that from t = 2 al/w on the spheres fly freely, overlapping still for a while; `duration` is then
the time at which the force ends. Friction of body i acts at the lever l_i = R_i (branch R), R_i - d (R-d) or R_i - d/2 (R-d/2) along
the normal, for torque and for slip alike, and only while the normal force presses: the limit is friction x max(0, k d + c d').

Proved: head-on (angle 0, and friction 0 or no surface velocity R1 omega1 + R2 omega2 across the normal) in closed form; oblique
without friction, and gross sliding with spins about z alone, by proven integration. Where the contact may stick: not certified.
Scalars: duration and restitution (of the normal velocity; neither if an overlap never ends), max_overlap, max_force.
"""

from collections.abc import Mapping
from copy import copy
from fractions import Fraction

from flint import arb

from refdem.core.parameters import Parameters
from refdem.core.truth import Truth
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_form import ClosedForm, per_precision
from refdem.truth.head_on_contact import HeadOnContact
from refdem.truth.sliding_contact import STILL, SlidingContact
from refdem.truth.sphere_pair import SpherePair, sphere_pair

NAMES = tuple(f"{kind}{body}.{axis}" for body in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz")
"""The 18 quantities: r1.x r1.y r1.z v1.x .. omega1.z r2.x .. omega2.z."""
BITS = 128
"""Working precision for S: with starts that are displaced by 2^-60 of a scale, 2^-30 of the response remain."""
IN_PLANE = ("r1.x", "r1.y", "v1.x", "v1.y", "r2.x", "r2.y", "v2.x", "v2.y")


class TwoSpheres(ClosedForm):
    """Positions [m], velocities [m/s] and angular velocities [rad/s] of both, NAMES, at t >= 0.

    S(t) is that of the motion in its plane; out of it a head-on collision grows as across the normal. Where nothing slips S leaves
    friction out: a slip that a small displacement starts is soon stuck again.
    """

    state = ("r1.x", "r1.y", "v1.x", "v1.y")

    def __init__(self, scale: Mapping[str, float], pair: SpherePair) -> None:
        super().__init__(scale)
        self.spheres, self.offset = pair, STILL
        self.method = "closed form" if pair.is_head_on else "interval-verified Taylor integration in polar coordinates"
        self.witness = "Taylor series in Cartesian coordinates, energy, momenta"

    @per_precision
    def motion(self) -> HeadOnContact | SlidingContact:
        """The relative motion at the current precision."""
        if self.spheres.is_head_on and not any(self.offset):
            return HeadOnContact(self.spheres)
        return SlidingContact(self.spheres, offset=self.offset)

    def displaced(self, axis: int, amount: Fraction) -> "TwoSpheres":
        """The collision with x, y, vx or vy (axis 0 .. 3) of body 1 against body 2 larger by `amount` at the start."""
        other = copy(self)
        other.kept = {}
        other.offset = tuple(by + amount * (i == axis) for i, by in enumerate(self.offset))
        return other

    def evaluate(self, t: arb) -> dict[str, arb]:
        """The 18 quantities at t."""
        if t < 0:
            raise NotCertifiedError("two-spheres: t < 0 is before the start")
        x, y, vx, vy, impulse, lost = self.relative(t)
        values: list[arb] = []
        for body in (0, 1):
            share = arb_of((1 - 2 * body) * self.spheres.masses[1 - body] / sum(self.spheres.masses))
            spin = [arb_of(part) for part in self.spheres.spins[3 * body : 3 * body + 3]]
            radius, moment = arb_of(self.spheres.radii[body]), arb_of(self.spheres.moments[body])
            spin[2] -= (radius * impulse - arb_of(self.spheres.lever) * lost) / moment
            values += [share * x, share * y, arb(0), share * vx, share * vy, arb(0), *spin]
        return dict(zip(NAMES, values, strict=True))

    def relative(self, t: arb) -> list[arb]:
        """x, y, vx, vy of body 1 against body 2, friction impulse J [N s] and integral of overlap x friction [N s m]."""
        if t == 0:
            start = [value + arb_of(by) for value, by in zip(self.spheres.start(), self.offset, strict=True)]
            return [*start, arb(0), arb(0)]
        found: list[arb] = self.motion().relative(t)
        return found

    def constants(self) -> dict[str, arb]:
        """Scalars of the collision."""
        found: dict[str, arb] = self.motion().constants()
        return found

    def _sensitivity(self, t: Fraction) -> float:
        """As in the base, with the relative motion displaced in its plane and the centre of mass moving uniformly."""
        with precision(BITS):
            columns = [self._relative_column(axis, t) for axis in range(4)]
        rows = [self._row(columns, t, body, component) for body in (0, 1) for component in range(4)]
        spins = [self._spin_row(columns, body) for body in (0, 1)]
        return max(1.0, *rows, *spins) * (1 + 2.0**-40)

    def _relative_column(self, axis: int, t: Fraction) -> list[float]:
        """d (x, y, vx, vy, J, lost)(t) / d start of one coordinate of the relative state."""
        amount = self.scale[self.state[axis]] / 2**60
        if ("displaced", axis) not in self.kept:
            self.kept["displaced", axis] = [self.displaced(axis, amount), self.displaced(axis, -amount)]
        plus, minus = (displaced.relative(arb_of(t)) for displaced in self.kept["displaced", axis])
        return [float((high - low) / arb_of(2 * amount)) for high, low in zip(plus, minus, strict=True)]

    def _row(self, columns: list[list[float]], t: Fraction, body: int, component: int) -> float:
        """Scaled response of x, y, vx or vy of one body to all that of both."""
        total = float(sum(self.spheres.masses))
        shares = [float(mass) / total for mass in self.spheres.masses]
        names = IN_PLANE[4 * body : 4 * body + 4]
        response = 0.0
        for of, sign in ((0, 1), (1, -1)):
            for axis in range(4):
                carried = 1.0 if axis == component else float(t) if axis == component + 2 else 0.0
                slope = shares[of] * carried + (1 - 2 * body) * shares[1 - body] * sign * columns[axis][component]
                response += abs(slope) * float(self.scale[IN_PLANE[4 * of + axis]])
        size = float(self.scale[names[component]])
        return response / size if size else 0.0

    def _spin_row(self, columns: list[list[float]], body: int) -> float:
        """Scaled response of one body's spin about z: its own start stays, and the friction impulse varies."""
        radius, moment, size = float(self.spheres.radii[body]), float(self.spheres.moments[body]), float(self.scale[f"omega{body + 1}.z"])
        if not size:
            return 0.0
        response = 0.0
        for axis, column in enumerate(columns):
            slope = (radius * column[4] - float(self.spheres.lever) * column[5]) / moment
            response += abs(slope) * sum(float(self.scale[IN_PLANE[4 * of + axis]]) for of in (0, 1))
        return 1.0 + response / size


def truth(p: Parameters, scale: Mapping[str, float]) -> Truth:
    """The truth of case two-spheres; `scale` of the 18 quantities NAMES."""
    return TwoSpheres(scale, sphere_pair(p))
