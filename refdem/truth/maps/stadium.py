"""The stadium billiard (Bunimovich 1979): the collision map in balls, each bounce with its piece of
the wall proved.

Two straight walls y = +-r, |x| <= a, and half circles of radius r about (+-a, 0); `half` is a. The
table is convex, so a path along u leaves through the straight wall on its side if it meets that
line with |x| <= a, else through the half circle on the side on which it meets it. With the unit
normal n at the place of a bounce the direction becomes u - 2 (n . u) n.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_mat

from refdem.truth.balls import arb_of
from refdem.truth.dual import ball
from refdem.truth.maps.iterated import BoundaryError, Iterated, Stepped
from refdem.truth.refiner import Size

WALL = "wall"
ARC = "arc"
Exact2 = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Bounce:
    """The place (2) and unit direction (2) after a bounce, and the piece of the boundary it hit.

    The piece is (WALL, +-1) at y = +-r, (ARC, +-1) about (+-a, 0), or None at the start.
    """

    place: Sequence[arb]
    direction: Sequence[arb]
    piece: tuple[str, int] | None


def sign(value: arb, code: str) -> int:
    """1 or -1; BoundaryError if the ball has no sign."""
    if value > 0:
        return 1
    if value < 0:
        return -1
    raise BoundaryError(code, value)


class Stadium(Stepped, Iterated):
    """The truth of bounce n in a stadium of `size`, centred on the origin.

    A point starts at `start` along `direction`, which may have any length.
    """

    method = "the collision map in balls, the piece of the wall proved at every bounce"
    witness = (
        "chords of the circles and mirror images of them in multiprecision, without balls; reversal"
        " of the path"
    )
    word = "bounce"

    def __init__(
        self,
        size: Exact2,
        start: Exact2,
        direction: Exact2,
        scale: Mapping[str, Size],
        *,
        digits: int = 40,
    ) -> None:
        self.iterate(scale, digits=digits)
        self.size = size
        self.start = start
        self.direction = direction
        self.radius = size[1] / 2
        self.half = (size[0] - size[1]) / 2

    def first(self) -> Bounce:
        length = arb_of(self.direction[0] ** 2 + self.direction[1] ** 2).sqrt()
        return Bounce(
            [arb_of(x) for x in self.start], [arb_of(u) / length for u in self.direction], None
        )

    def piece(self, state: Bounce) -> tuple[str, int]:
        """The piece of the boundary that is met next; BoundaryError if balls do not decide it."""
        x, y = state.place
        u, v = state.direction
        r = arb_of(self.radius)
        a = arb_of(self.half)
        # The sign of v is not decided: the path is nearly along x, and meets the half circle ahead
        # if |y| < r where that begins, at x = side a.
        if not (v > 0 or v < 0):
            side = sign(u, "corner")
            sign(r - abs(ball(y + v * (side * a - x) / u)), "corner")
            return ARC, side
        if v > 0:
            up = 1
        else:
            up = -1
        # The path meets the line y = up r of the wall at x + (up r - y) u/v.
        x_on_line = x + (up * r - y) * u / v
        if self.half == 0:
            return ARC, sign(x_on_line, "corner")
        inside = a - abs(ball(x_on_line))
        if sign(inside, "corner") > 0:
            return (WALL, up)
        return (ARC, sign(x_on_line, "corner"))

    def step(self, state: Bounce) -> Bounce:
        """The next bounce: u becomes u - 2 (n . u) n at the piece that is met."""
        piece = self.piece(state)
        kind, side = piece
        x, y = state.place
        u, v = state.direction
        r = arb_of(self.radius)
        if kind == WALL:
            return Bounce([x + (side * r - y) * u / v, side * r], [u, -v], piece)
        t = self._chord(state, piece)
        centre = side * arb_of(self.half)
        place = [x + t * u, y + t * v]
        # n = (place - centre)/r, and u' = u - 2 (n . u) n.
        normal = [(place[0] - centre) / r, place[1] / r]
        along = normal[0] * u + normal[1] * v
        return Bounce(place, [u - 2 * along * normal[0], v - 2 * along * normal[1]], piece)

    def _chord(self, state: Bounce, piece: tuple[str, int]) -> arb:
        """The distance to the half circle along the path, the larger root of t^2 + 2 b t + c = 0.

        With q = place - centre: b = q . u and c = q^2 - r^2, which is exactly 0 from a point on it.
        """
        x, y = state.place
        u, v = state.direction
        q_x = x - piece[1] * arb_of(self.half)
        b = q_x * u + y * v
        if state.piece == piece:
            return -2 * b
        c = q_x * q_x + y * y - arb_of(self.radius) ** 2
        discriminant = b * b - c
        sign(discriminant, "tangent")
        return -b + discriminant.sqrt()

    def slope(self, state: Bounce, after: Bounce) -> arb_mat:
        """The derivative (4 x 4, in scales) of place and direction after a bounce by those before.

        With the normal n, the flight's length t, errors dp, du before it, and the curvature K = 1/r
        on a half circle, else 0:

            dr = (1 - u n^T/(n . u)) (dp + t du)             the flight, cut off by the boundary
            dn = K dr
            du' = du - 2 (dn . u + n . du) n - 2 (n . u) dn  the reflection u' = u - 2 (n . u) n
        """
        assert after.piece is not None
        kind, side = after.piece
        u = state.direction
        scale = arb_of(self.scale["position.x"])
        r = arb_of(self.radius)
        if kind == WALL:
            n = [arb(0), arb(side)]
        else:
            n = [(after.place[0] - side * arb_of(self.half)) / r, after.place[1] / r]
        along = n[0] * u[0] + n[1] * u[1]
        # t = (r' - r) . u, as u is a unit vector.
        t = (after.place[0] - state.place[0]) * u[0] + (after.place[1] - state.place[1]) * u[1]
        columns = []
        for axis in range(4):
            dp = [scale if axis == i else arb(0) for i in (0, 1)]
            du = [arb(1) if axis == 2 + i else arb(0) for i in (0, 1)]
            shifted = [dp[i] + t * du[i] for i in (0, 1)]
            # n . dr = 0: the flight becomes shorter by dt = n . (dp + t du)/(n . u).
            dt = (n[0] * shifted[0] + n[1] * shifted[1]) / along
            dr = [shifted[i] - u[i] * dt for i in (0, 1)]
            if kind == ARC:
                dn = [dr[i] / r for i in (0, 1)]
            else:
                dn = [arb(0), arb(0)]
            # d(n . u) = dn . u + n . du, and du' = du - 2 d(n . u) n - 2 (n . u) dn.
            d_along = dn[0] * u[0] + dn[1] * u[1] + n[0] * du[0] + n[1] * du[1]
            du_after = [du[i] - 2 * d_along * n[i] - 2 * along * dn[i] for i in (0, 1)]
            columns.append([dr[0] / scale, dr[1] / scale, *du_after])
        return arb_mat([[column[i] for column in columns] for i in range(4)])

    def values(self, state: Bounce) -> dict[str, arb]:
        """The position and direction of a bounce, by name."""
        x, y = state.place
        u, v = state.direction
        return {"position.x": x, "position.y": y, "direction.x": u, "direction.y": v}
