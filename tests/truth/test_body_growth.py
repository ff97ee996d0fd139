"""S(t) of free bodies against impulses from outside: the variational equation by Runge-Kutta,
written anew, and powers of its period.

At random times a body is struck, in all directions at once: the largest growth over directions is a
singular value.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from flint import acb, arb

from refdem.core import discovery
from refdem.truth import midpoint_radius, rotation
from refdem.truth.balls import arb_of, precision
from refdem.truth.body_growth import Tumbling, rotating
from refdem.truth.closed_forms.free_rigid_body import FreeRigidBody
from refdem.truth.closed_forms.rigid_cluster import RigidCluster
from refdem.truth.midpoint_radius import exact as exact_doubles
from refdem.truth.refiner import Refiner

STEPS = 1500
"""Runge-Kutta steps of what is followed, one period or the whole time."""
IMPULSES = 10_000
"""Random times of impulses, each in every direction."""
LOOKS = 12
"""Times at which what is left of them is compared."""
MARGIN = 2e-3
"""What Runge and Kutta may be off."""
MAX_OVERESTIMATE = 1.4
"""S is at most so many times the largest growth that is found."""
ONE = (Fraction(1), Fraction(0), Fraction(0), Fraction(0))
TILTED = (Fraction(1), Fraction(2), Fraction(-3), Fraction(1, 2))

Array = np.ndarray


def exact(text: str) -> tuple[Fraction, ...]:
    """Rationals that are told one after another."""
    return tuple(Fraction(x) for x in text.split())


@dataclass(frozen=True)
class Numbers:
    """A body in doubles: its tensor, scales of turn and spin, omega at (n,) times and the matrix of
    its attitude at one.
    """

    truth: FreeRigidBody | RigidCluster
    tensor: Array
    turn: float
    spin: float

    def omegas(self, times: Sequence[float]) -> Array:
        with precision(192):
            return np.array([[float(x.mid()) for x in self.truth.spin(arb(t))] for t in times])

    def attitude(self, t: Fraction) -> Array:
        with precision(192):
            rows = rotation.matrix(self.truth.turned(arb_of(t)))
            return np.array([[float(x.mid()) for x in row] for row in rows])

    def slopes(self, omegas: Array) -> Array:
        """The variational equation (n, 6, 6) of (psi, d): psi' = d - omega x psi, J d' = J d x
        omega + J omega x d.
        """
        found = np.zeros((len(omegas), 6, 6))
        turning = crossed(omegas)
        found[:, :3, :3] = -turning
        found[:, :3, 3:] = np.eye(3)
        torque = crossed(omegas @ self.tensor) - turning @ self.tensor
        found[:, 3:, 3:] = np.linalg.inv(self.tensor) @ torque
        return found

    def readings(self, t: Fraction, omega: Array) -> Array:
        """Turn, omega in body axes and in space (9, 6)."""
        space = self.attitude(t)
        found = np.zeros((9, 6))
        found[:3, :3] = np.eye(3)
        found[3:6, 3:] = np.eye(3)
        found[6:, :3] = -space @ crossed(omega[None])[0]
        found[6:, 3:] = space
        found[:3] /= self.turn
        found[3:] /= self.spin
        return found

    def largest(self, matrices: Array) -> float:
        """The largest growth of a vector (the turn, omega in body axes, omega in space) by matrices
        (n, 9, 6), over all impulses of one scale in both parts.
        """
        return largest_of(matrices[..., :3] * self.turn, matrices[..., 3:] * self.spin)


def largest_of(by_turn: Array, by_spin: Array) -> float:
    """The same by matrices (n, 9, 3) each, on errors that are counted in scales."""
    largest = 0.0
    for rows in (slice(0, 3), slice(3, 6), slice(6, 9)):
        growths = [np.linalg.norm(one[:, rows], ord=2, axis=(-2, -1)) for one in (by_turn, by_spin)]
        largest = max(largest, float(sum(growths).max()))
    return largest


def crossed(vectors: Array) -> Array:
    """The matrices of v x (n, 3, 3)."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    return np.array([[none, -z, y], [z, none, -x], [-y, x, none]]).transpose(2, 0, 1)


def of_body(inertia: str, omega: str) -> Numbers:
    """A body in its principal axes; omega counts in its own size."""
    moments = exact(inertia)
    rates = exact(omega)
    size = Fraction(float(np.linalg.norm([float(x) for x in rates]))) or Fraction(1)
    names = [f"omega{kind}.{axis}" for kind in ("_body", "") for axis in "xyz"]
    scale = dict.fromkeys(names, size) | {"attitude.w": Fraction(1)}
    truth = FreeRigidBody(Refiner.of(scale), moments, rates, TILTED)
    return Numbers(truth, np.diag([float(x) for x in moments]), 1.0, float(size))


def steps_of(numbers: Numbers, end: float) -> tuple[Array, Array]:
    """omega at the ends of steps (STEPS + 1, 3), and what errors become during each step (STEPS, 6,
    6), by Runge and Kutta.
    """
    step = end / STEPS
    omegas = numbers.omegas(np.linspace(0.0, end, 2 * STEPS + 1))
    slopes = numbers.slopes(omegas)
    first = slopes[:-1:2]
    middle = slopes[1::2]
    last = slopes[2::2]
    one = np.eye(6)
    k1 = first
    k2 = middle @ (one + step / 2 * k1)
    k3 = middle @ (one + step / 2 * k2)
    k4 = last @ (one + step * k3)
    return omegas[::2], one + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def assert_sharp(numbers: Numbers, t: Fraction, growth: float) -> None:
    """S is not below the largest growth, and not above MAX_OVERESTIMATE times it."""
    bound = numbers.truth.sensitivity(t)
    assert growth <= bound * (1 + MARGIN), (
        f"t = {float(t)}: an impulse grows by {growth}, S is {bound}"
    )
    assert bound <= MAX_OVERESTIMATE * growth, (
        f"t = {float(t)}: S is {bound}, the largest growth {growth}"
    )


FOLLOWED = [
    ("1 2 3", "0.9 1.1 1.3", 9.0),
    # Up to the second time that it turns over, within two periods: S is 1e12.
    ("1 2 3", "0 1 1e-6", 100.0),
    ("1 2 3", "1e-9 2 0", 60.0),
    ("1 1 2", "0.9 1.1 1.3", 20.0),
    # Steady: about axes that are stable and one that is not, with equal moments, and of a sphere.
    ("1 2 3", "0 0 2", 40.0),
    ("1 2 3", "-1 0 0", 40.0),
    ("1 1.01 3", "1.5 0 0", 60.0),
    ("1 2 3", "0 1 0", 30.0),
    ("2 2 3", "0.3 0.4 0", 50.0),
    ("2 2 2", "0.9 1.1 1.3", 40.0),
    ("1 2 3", "0 0 0", 7.0),
    # On the separatrix, and past it without a period.
    ("1 3 6", "0.75 -0.125 0.25", 30.0),
]


@pytest.mark.parametrize(("inertia", "omega", "end"), FOLLOWED)
def test_s_of_a_body_is_not_below_the_largest_growth_and_at_most_1_4_times_it(inertia, omega, end):
    numbers = of_body(inertia, omega)
    rng = np.random.default_rng(1)
    omegas, passed = steps_of(numbers, end)
    looks = {STEPS, *rng.integers(1, STEPS + 1, LOOKS).tolist()}
    # D from every step so far to now, one step after another: no product is undone.
    grown = np.zeros((STEPS + 1, 6, 6))
    for k in range(STEPS + 1):
        grown[:k] = passed[k - 1] @ grown[:k]
        grown[k] = np.eye(6)
        if k in looks:
            t = Fraction(k * (end / STEPS))
            assert_sharp(
                numbers, t, numbers.largest(numbers.readings(t, omegas[k]) @ grown[: k + 1])
            )


MANY = (1, 3, 7, 2000)
REPEATED = [
    ("1 2 3", "0.9 1.1 1.3", MANY),
    ("1 2 3", "1.3 1.1 -0.2", MANY),
    # Powers of a matrix that grows errors thousandfold end soon in doubles.
    ("1 2 3", "0 1 1e-3", (1, 3, 7)),
    ("6 1 6.5", "1e-3 1 0", (1, 3, 7)),
    ("1 2 3", "0 1 1e-1", MANY),
    ("1 1 2", "0.9 1.1 1.3", MANY),
    ("3 2 2", "-0.9 1.1 0.3", MANY),
    ("1 2 2.01", "0.5 0.6 0.7", (1, 3, 100)),
    ("1e-6 1 1", "0.5 0.6 0.7", MANY),
    ("1 2 3", "1e-5 1e-6 1", MANY),
]


def assert_sharp_after_periods(numbers: Numbers, periods: Sequence[int]) -> None:
    """Impulses at random times of all periods so far, by powers of what a period makes of
    errors.
    """
    rng = np.random.default_rng(1)
    with precision(192):
        period = float(numbers.truth.body().period().mid())
    _, passed = steps_of(numbers, period)
    made = [np.eye(6)]
    for one in passed:
        made.append(one @ made[-1])
    since = np.array(made)
    back = np.linalg.inv(since)
    for count in periods:
        for k in rng.integers(1, STEPS, LOOKS // 2).tolist():
            seconds = k * (period / STEPS)
            readings = numbers.readings(
                Fraction(seconds) + count * Fraction(period), numbers.omegas([seconds])[0]
            )
            # Impulses of this period, of the first one, and of others.
            found = numbers.largest(readings @ since[k] @ back[: k + 1])
            for n in {count, *rng.integers(1, count + 1, 9).tolist()}:
                struck = rng.integers(0, STEPS, IMPULSES // 10)
                power = np.linalg.matrix_power(since[-1], n)
                found = max(found, numbers.largest(readings @ since[k] @ power @ back[struck]))
            assert_sharp(numbers, Fraction(seconds) + count * Fraction(period), found)


@pytest.mark.parametrize(("inertia", "omega", "periods"), REPEATED)
def test_so_it_is_after_many_periods(inertia, omega, periods):
    assert_sharp_after_periods(of_body(inertia, omega), periods)


POINTS = ["1,0,0,0,1,0,0,0,1,-1,-1/2,0", "1,0,1,-1,0,1,0,1,-1,0,-1,-1"]
"""With three principal moments, and with two, of equal masses."""


@pytest.mark.parametrize("positions", POINTS)
def test_so_it_is_of_points_in_axes_that_are_not_principal(positions):
    masses = {POINTS[0]: "1,2,1,3", POINTS[1]: "1,1,1,1"}[positions]
    truth = discovery.case("rigid-cluster").at(positions=positions, masses=masses).truth()
    axes = np.array([[float(x.mid()) for x in row] for row in truth.axes()])
    tensor = np.array([[float(x) for x in row] for row in truth.tensor])
    numbers = Numbers(
        truth,
        axes @ tensor @ axes.T,
        float(truth.scale["attitude.w"]),
        float(truth.scale["omega.x"]),
    )
    assert_sharp_after_periods(numbers, (1, 5, 500))


NEEDLE = f"{2**-40} 1 {1 + 2**-41}"


@pytest.mark.parametrize(
    ("inertia", "omega"), [("1 2 3", "0.9 1.1 1.3"), (NEEDLE, "0.9 1.1 1.3"), (NEEDLE, "1 0 0")]
)
def test_roundings_have_no_part_in_s(inertia, omega, monkeypatch):
    """By norms of matrices their bound was a seventh of S of a needle, whose J^-1 has 1e12."""
    times = [Fraction(2), Fraction(8), Fraction(400)]
    told = [of_body(inertia, omega).truth.sensitivity(t) for t in times]
    monkeypatch.setattr(midpoint_radius, "UNIT", 0.0)
    without = [of_body(inertia, omega).truth.sensitivity(t) for t in times]
    assert without == pytest.approx(told, rel=1e-3)


@pytest.mark.parametrize("inertia", ["1 2 3", "1e-3 1 1", "1 5 5.5"])
def test_what_turns_is_bounded_at_every_angle_and_sharply(inertia):
    """At one angle of q it may be half of what it is at others."""
    with precision(192):
        truth = of_body(inertia, "0.9 1.1 1.3").truth
        growth = truth.growth()
        assert isinstance(growth, Tumbling)
        growth.at(Fraction(2))
        instant = growth.instants[-1]
        t = growth.cells[len(growth.instants) - 1].middle
        read = growth.read(t, instant.axes, growth.body.omega(arb_of(t)), growth.length)
        nothing = np.zeros(1)
        sources = instant.sources[None]
        told = growth.largest(
            read, [exact_doubles(np.zeros((1, 6, 6)))], sources, nothing, turns_anyhow=True
        )
        growths = []
        for part in range(64):
            sine, cosine = (arb.pi() * part / 32).sin_cos()
            # The scale of a turn is 1.
            turned = read.midpoint @ rotating([acb(cosine, sine)]).midpoint
            turned[..., 3:] = turned[..., 3:] @ instant.sources.midpoint
            growths.append(largest_of(turned[..., :3], turned[..., 3:]))
    assert max(growths) <= told <= 1.1 * max(growths)


def test_a_motion_that_nearly_is_a_separatrix_is_known_for_ever():
    """Products of derivatives in doubles had lost it after two turns, and no working precision
    helped.
    """
    truth = discovery.case("intermediate-axis").at(offset="1e-12", direction="3").truth()
    early, late = (
        max(truth.sensitivity(Fraction(t) + 16 * n) for n in range(12)) for t in (1000, 100_000)
    )
    assert 1e24 < early < late < 1e30


def test_errors_of_an_unstable_spin_grow_until_doubles_end():
    numbers = of_body("1 3 6", "0.75 -0.125 0.25")
    assert numbers.truth.sensitivity(Fraction(10_000)) == 1e300
    steady = of_body("1 2 3", "0 1 0")
    assert steady.truth.sensitivity(Fraction(100_000)) == 1e300


def test_growth_of_equal_moments_about_any_axis_is_known():
    """Euler's equations have no Jacobian then, and balls about 0 that are raised to a power are
    NaN.
    """
    growths = []
    for moment in ("2e-05", "1"):
        case = discovery.case("free-rigid-body")
        instance = case.at(inertia=",".join([moment] * 3), omega_body="-31.4,-31.4,-31.4")
        growths.append(instance.truth().sensitivity(Fraction("0.01839")))
    assert growths[0] == pytest.approx(growths[1], rel=1e-12)
    # psi(t) = psi(s) + (t - s) d, seen in axes that turn: of the size of 1.
    assert 1 <= growths[0] < 3
