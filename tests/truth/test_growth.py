"""S(t) against impulses from outside: neighbouring motions of equations that are written anew here,
without a ball or a Jacobian.

At random times the motion is displaced by a small impulse in each coordinate, and how much of it is
left is compared with S. The sum over the coordinates of what one quantity answers is the most that
any impulse of one scale in every coordinate can do.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, arb_mat

from refdem.core import discovery
from refdem.core.discovery import truth_of
from refdem.truth.balls import arb_of
from refdem.truth.closed_forms.two_body_orbit import tidal
from refdem.truth.growth import WIDEST, Growth, Norm, most, smooth
from refdem.truth.line_growth import steepness

IMPULSES = 60
"""Random times of impulses; `make nightly` needs no more than a larger number here."""
STEPS = 3000
"""Runge-Kutta steps of the longest motion."""
SEEN = 24
"""Times at which what is left of the impulses is compared."""
SIZE = 1e-8
"""Of an impulse, in scales; what differences of doubles lose is a millionth of it."""
MARGIN = 2e-3
"""What differences of motions in doubles may be off, kinks of forces included."""
MAX_OVERESTIMATE = 2.0
"""S is at most so many times the largest growth that is found."""

State = np.ndarray


@dataclass(frozen=True)
class GrowthCase:
    """A case, the rates of its state (n, copies) at a time, and what is read of a state besides
    itself.
    """

    case: str
    names: tuple[str, ...]
    rates: Callable[[object, State, float], list[State]]
    given: Mapping[str, str] = field(default_factory=dict)
    read: Callable[[object, State], dict[str, State]] = lambda p, y: {}
    size: float = SIZE

    @property
    def label(self) -> str:
        return " ".join([self.case, *(f"{name}={value}" for name, value in self.given.items())])


def pendulum(p, y, t):
    return [y[1], -p.gravity / p.length * np.sin(y[0])]


def seen_pendulum(p, y):
    force = p.mass * (p.length * y[1] ** 2 + p.gravity * np.cos(y[0]))
    return {"x": p.length * np.sin(y[0]), "y": -p.length * np.cos(y[0]), "rod_force": force}


def oscillator(p, y, t):
    push = getattr(p, "f0", 0.0) * np.cos(getattr(p, "drive", 0.0) * t)
    return [
        y[1],
        -p.stiffness / p.mass * y[0] + p.gravity - 2 * getattr(p, "delta", 0.0) * y[1] + push,
    ]


def power(p, y, t):
    return [y[1], -p.stiffness / p.mass * np.abs(y[0]) ** p.exponent * np.sign(y[0])]


def duffing(p, y, t):
    return [y[1], -p.alpha * y[0] - p.beta * y[0] ** 3]


def driven_duffing(p, y, t):
    return [
        y[1],
        -2 * p.delta * y[1] - p.alpha * y[0] - p.beta * y[0] ** 3 + p.f0 * np.cos(p.drive * t),
    ]


def kepler(p, y, t):
    cube = (y[0] ** 2 + y[1] ** 2) ** 1.5
    return [y[2], y[3], -p.gm * y[0] / cube, -p.gm * y[1] / cube]


def spring(p, y, t):
    return [y[2], y[3], -p.stiffness * y[0], -p.stiffness * y[1]]


def whirl(p, y, t):
    x, y, vx, vy = y
    slip_x = vx + p.turning * y
    slip_y = vy - p.turning * x
    force_x = -p.stiffness * x - p.outer_damping * vx - p.inner_damping * slip_x
    force_y = -p.stiffness * y - p.outer_damping * vy - p.inner_damping * slip_y
    return [vx, vy, force_x / p.mass, force_y / p.mass]


def shaken(p, y, t):
    lift = p.gravity - p.drive_amplitude * p.drive**2 * np.cos(p.drive * t)
    return [y[1], lift * np.sin(y[0]) / p.length]


def hertz(p, y, t):
    return [y[1], -p.stiffness / p.effective_mass * np.maximum(y[0], 0.0) ** 1.5]


def wedge(p, y, t):
    overlap = np.maximum(y[0], 0.0)
    return [y[1], -np.where(y[1] > 0, p.k2 * overlap**2, p.k1 * overlap) / p.mass]


def hill(p, y, t):
    fall = p.k1 * -p.x1 / p.x2
    rising = p.k1 * (y[0] - p.x1)
    falling = -fall * (y[0] - p.x2)
    return [
        y[1],
        np.where(y[0] < p.x1, 0.0, np.where(y[0] < 0, rising, np.where(y[0] < p.x2, falling, 0.0)))
        / p.mass,
    ]


def wheel(p, y, t):
    r, theta, rdot, rate = y
    whole = (
        p.mass + p.counter_mass + (p.wheel_inertia / p.wheel_radius**2 if p.wheel_radius else 0.0)
    )
    string = (
        p.mass * r * rate**2 + p.mass * p.gravity * np.cos(theta) - p.counter_mass * p.gravity
    ) / whole
    turning = (p.wheel_radius * rate**2 - 2 * rdot * rate - p.gravity * np.sin(theta)) / r
    return [rdot, rate, string + turning * p.wheel_radius, turning]


def sliding(p, y, t):
    sine, cosine = (
        (p.slope / np.hypot(1, p.slope), 1 / np.hypot(1, p.slope))
        if p.angle is None
        else (np.sin(p.angle), np.cos(p.angle))
    )
    return [y[1], np.full_like(y[1], p.gravity * (sine - p.friction * cosine))]


LINE = ("x", "v")
ORBIT = ("x", "y", "vx", "vy")
ANGLE = ("theta", "thetadot")
TOUCH = ("overlap", "v")
MOTIONS = [
    GrowthCase("pendulum", ANGLE, pendulum, {}, seen_pendulum),
    GrowthCase("pendulum", ANGLE, pendulum, {"theta0": "0", "thetadot0": "7"}, seen_pendulum),
    GrowthCase(
        "pendulum",
        ANGLE,
        pendulum,
        {"theta0": "3.14", "gravity": "1", "duration": "34.087186", "samples": "2"},
        seen_pendulum,
    ),
    GrowthCase("pendulum", ANGLE, pendulum, {"theta0": "2", "duration": "12"}, seen_pendulum),
    GrowthCase("harmonic-oscillator", LINE, oscillator),
    GrowthCase("harmonic-oscillator", LINE, oscillator, {"stiffness": "7", "v0": "2"}),
    GrowthCase("viscous-oscillator", LINE, oscillator, {"duration": "10"}),
    GrowthCase("viscous-oscillator", LINE, oscillator, {"delta": "3", "duration": "10"}),
    GrowthCase("driven-oscillator", LINE, oscillator),
    GrowthCase("power-oscillator", LINE, power),
    GrowthCase("power-oscillator", LINE, power, {"exponent": "3", "duration": "40"}),
    GrowthCase("duffing", LINE, duffing),
    GrowthCase(
        "duffing", LINE, duffing, {"alpha": "-1", "beta": "1", "amplitude": "1.4", "duration": "20"}
    ),
    GrowthCase(
        "duffing",
        LINE,
        duffing,
        {"alpha": "1", "beta": "-1", "amplitude": "0.95", "duration": "30"},
    ),
    GrowthCase("driven-duffing", LINE, driven_duffing),
    GrowthCase("two-body-orbit", ORBIT, kepler),
    GrowthCase("two-body-orbit", ORBIT, kepler, {"eccentricity": "0"}),
    GrowthCase("two-body-orbit", ORBIT, spring, {"stiffness": "1"}),
    GrowthCase("whirling-shaft", ORBIT, whirl),
    GrowthCase("whirling-shaft", ORBIT, whirl, {"turning": "2"}),
    GrowthCase("whirling-shaft", ORBIT, whirl, {"turning": "3"}),
    GrowthCase("whirling-shaft", ORBIT, whirl, {"outer_damping": "12", "duration": "4"}),
    GrowthCase("kapitza-pendulum", ANGLE, shaken, {"duration": "3"}),
    GrowthCase("hertz-spheres", TOUCH, hertz),
    # Steps across the jump of its force need impulses that are larger than what they are off.
    GrowthCase("wedge-collision", TOUCH, wedge, size=2e-3),
    GrowthCase("asymmetric-field", LINE, hill),
    GrowthCase("pendulum-wheel-mass", ("r", "theta", "rdot", "thetadot"), wheel, {"duration": "2"}),
    GrowthCase("block-on-slope", ("s", "v"), sliding, {"friction": "1/2", "duration": "1/2"}),
]


def growths(motion: GrowthCase, seed: int = 1) -> tuple[list[Fraction], list[float], list[float]]:
    """Times, the largest growth of impulses by then, and S."""
    instance = discovery.case(motion.case).at(**motion.given)
    truth = instance.truth()
    p = instance.p
    end = float(instance.times[-1])
    rng = np.random.default_rng(seed)
    step = end / STEPS
    sizes = np.array([float(truth.scale[name]) for name in motion.names])
    begin = truth.at(Fraction(0))
    base = np.array([[float(begin[name].mid)] for name in motion.names])
    struck = {0, *rng.integers(0, STEPS, IMPULSES).tolist()}
    looks = sorted({STEPS, *rng.integers(1, STEPS, SEEN).tolist()})
    count = len(sizes)
    pairs = np.zeros((len(sizes), 0))
    found: list[float] = []

    def rates(y: State, t: float) -> State:
        return np.array(motion.rates(p, y, t))

    for k in range(STEPS + 1):
        if k in looks:
            found.append(left_of(motion, p, truth.scale, pairs, sizes))
        if k in struck:
            moved = np.concatenate(
                [base + motion.size * np.diag(sizes), base - motion.size * np.diag(sizes)], axis=1
            )
            pairs = np.concatenate([pairs, moved], axis=1)
        y = np.concatenate([base, pairs], axis=1)
        t = k * step
        k1 = rates(y, t)
        k2 = rates(y + step / 2 * k1, t + step / 2)
        k3 = rates(y + step / 2 * k2, t + step / 2)
        y = y + step / 6 * (k1 + 2 * k2 + 2 * k3 + rates(y + step * k3, t + step))
        base = y[:, :1]
        pairs = y[:, 1:]
    assert pairs.shape[1] == 2 * count * len(struck)
    times = [Fraction(k * step) for k in looks]
    return times, found, [truth.sensitivity(t) for t in times]


def left_of(
    motion: GrowthCase, p: object, scale: Mapping[str, Fraction], pairs: State, sizes: State
) -> float:
    """The largest sum, over the coordinates struck, of what a quantity answers."""
    count = len(sizes)
    answers = dict(zip(motion.names, pairs, strict=True)) | motion.read(p, pairs)
    largest = 0.0
    for name, values in answers.items():
        both = values.reshape(-1, 2, count)
        sums = np.abs(both[:, 0] - both[:, 1]).sum(axis=1) / (2 * motion.size * float(scale[name]))
        largest = max(largest, float(sums.max()))
    return largest


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.label)
def test_no_impulse_grows_by_more_than_s_and_s_is_at_most_twice_the_largest_growth(motion):
    times, found, told = growths(motion)
    for t, growth, bound in zip(times, found, told, strict=True):
        assert growth <= bound * (1 + MARGIN), (
            f"t = {float(t)}: an impulse grows by {growth}, S is {bound}"
        )
        assert bound <= MAX_OVERESTIMATE * max(1.0, growth), (
            f"t = {float(t)}: S is {bound}, the largest growth {growth}"
        )


ASKED = [
    "pendulum",
    "duffing",
    "two-body-orbit",
    "harmonic-oscillator",
    "free-rigid-body",
    "power-oscillator",
    "hertz-spheres",
    "van-der-pol",
]


@pytest.mark.parametrize(
    "case", [*ASKED, "stick-slip", "two-spheres", "captured-mass", "dissipating-body"]
)
def test_s_does_not_depend_on_what_else_is_asked(case):
    instance = discovery.case(case).at()
    times = [Fraction(float(t)) for t in instance.times][: len(instance.times) // 2]
    alone = truth_of(case)
    among = truth_of(case)
    all_of_them = among.sensitivities(times)
    backwards = truth_of(case)
    assert alone.sensitivities([times[-1]]) == all_of_them[-1:]
    assert [backwards.sensitivity(t) for t in reversed(times)] == all_of_them[::-1]


def test_a_pendulum_that_passes_the_top_slowly_is_seen_with_two_samples():
    truth = truth_of("pendulum", theta0="3.14", gravity="1", duration="34.087186", samples="2")
    assert 3767 < truth.sensitivity(Fraction(34.087186)) < 2 * 3767


def test_an_orbit_is_followed_for_ten_thousand_turns():
    truth = truth_of("two-body-orbit")
    near, far = (truth.sensitivity(Fraction(n) * 2 * Fraction(355, 113)) for n in (100, 10_000))
    assert 90 < far / near < 110


def test_a_bound_of_what_is_not_finite_is_infinite():
    """max(1.0, nan) is 1.0 in Python: a comet's field was bounded by 14 per second on balls that
    hold the centre.
    """
    assert most([arb(1), arb("nan")]) == most([arb(0).union(arb(1)) ** -1, arb(2)]) == float("inf")
    assert tidal(arb(1), arb(1), arb(99) / 100, arb(0).union(arb(1))) == float("inf")
    assert steepness(arb("nan"), arb(1)) == float("inf")


@pytest.mark.parametrize("ratio", ["1/100", "1", "1000"])
def test_the_ends_of_a_free_flight_stand_for_all_times_between(ratio):
    """S of cells that cover two flights, and S of their ends alone, at a bounce between them."""
    bounce = arb_mat([[arb(1), arb(0)], [arb(-3), arb(-1) / 2]])

    def flight(t):
        return arb_mat([[arb(1), t * arb_of(Fraction(ratio))], [arb(0), arb(1)]])

    def grown(*, affine):
        flights = [
            smooth(arb(0), arb(2), flight, jump=bounce, affine=affine),
            smooth(arb(2), None, flight, affine=affine),
        ]
        return Growth(flights, Norm([1, 1]))

    ends, cells = grown(affine=True), grown(affine=False)
    for t in (Fraction(1, 3), Fraction(2), Fraction(5, 2), Fraction(7)):
        assert ends.at(t) * 0.999999 <= cells.at(t) <= ends.at(t) / (1 - WIDEST)
