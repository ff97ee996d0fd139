"""S(t) where a tangential spring remembers: against impulses at random times, in motions that are
stepped anew with the law alone.

The spring keeps its stretch when the state is struck: whoever errs in a place has not erred in what
it was before.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from refdem.cases.impact_benchmarks import member
from refdem.core import discovery

IMPULSES = 40
"""Random times of impulses."""
STEPS = 3000
LOOKS = 12
"""Times at which what is left of the impulses is compared."""
MARGIN = 5e-3
"""What steps across switches, and differences of motions, may be off."""
MAX_OVERESTIMATE = 2.0
"""S is at most so many times the largest growth that is found."""

State = np.ndarray


@dataclass(frozen=True)
class Law:
    """The names of what is struck, the first coordinates of the state; the rates of a state (n,
    copies), those of them that vanish while nothing touches, what the end of a step does to a
    state, and what is read of it; `size` of an impulse in scales, well above the way of a step and
    well below the overlap, so that what a step across a switch is off averages out.
    """

    struck: Sequence[str]
    start: Sequence[float]
    rates: Callable[[State], State]
    forces: slice
    clipped: Callable[[State], State]
    read: Callable[[State], Mapping[str, State]]
    size: float


def mindlin(v) -> Law:
    """(x, y, vx, vy, omega, stretch) of a sphere that touches the wall x = 0."""
    radius = float(v.radius)
    mass = float(v.mass)
    hertz = float(v.hertz)
    ratio = float(v.stiffness_ratio)
    friction = float(v.friction)

    def held(y: State) -> State:
        limit = friction / ratio * np.maximum(y[0] + radius, 0.0)
        return np.clip(y[5], -limit, limit)

    def rates(y: State) -> State:
        overlap = np.maximum(y[0] + radius, 0.0)
        push = hertz / mass * np.sqrt(overlap)
        rub = ratio * push * held(y)
        slip = np.where(overlap > 0, y[3] + radius * y[4], 0.0)
        return np.array([y[2], y[3], -push * overlap, -rub, -2.5 * rub / radius, slip])

    def clipped(y: State) -> State:
        return np.concatenate([y[:5], held(y)[None]])

    start = [-radius, 0.0, float(v.normal), float(v.across), float(v.spin), 0.0]
    names = ("r.x", "r.y", "v.x", "v.y", "omega.z")

    def read(y: State) -> Mapping[str, State]:
        return dict(zip(names, y[:5], strict=True))

    return Law(names, start, rates, slice(2, 3), clipped, read, 1e-5)


def passing(v, frame) -> Law:
    """(x, y, vx, vy, stretch, impulses, turning) of a body that passes another one at the origin,
    in the plane of its path; seen in the axes of `frame`.
    """
    first = float(v.radius)
    second = float(v.partner_radius)
    lever = {"R": 0.0, "R-d/2": 0.5, "R-d": 1.0}[v.branch]
    k = float(v.stiffness)
    kt = float(v.tangential_stiffness)
    friction = float(v.friction)
    axes = np.array(frame, dtype=float)

    def held(y: State) -> tuple[State, State, State]:
        distance = np.hypot(y[0], y[1])
        overlap = np.maximum(first + second - distance, 0.0)
        limit = friction * k / kt * overlap
        return distance, overlap, np.clip(y[4], -limit, limit)

    def rates(y: State) -> State:
        distance, overlap, stretch = held(y)
        normal = y[:2] / distance
        along = np.array([-normal[1], normal[0]])
        spin = (second - lever * overlap) * float(v.partner_spin)
        slip = np.where(overlap > 0, spin - (along * y[2:4]).sum(axis=0), 0.0)
        force = -k * overlap * normal - kt * stretch * along
        torque = -kt * stretch * (first - lever * overlap)
        return np.array([*y[2:4], *np.zeros_like(y[2:4]), slip, *force, torque])

    def clipped(y: State) -> State:
        found = y.copy()
        found[4] = held(y)[2]
        return found

    def read(y: State) -> Mapping[str, State]:
        nothing = np.zeros_like(y[0])
        vectors = {
            "r": [y[0], y[1], nothing],
            "v": [y[2], y[3], nothing],
            "impulse": [y[5], y[6], nothing],
            "turning": [nothing, nothing, y[7]],
        }
        found = {}
        for kind, vector in vectors.items():
            found |= {f"{kind}.{axis}": axes[i] @ vector for i, axis in enumerate("xyz")}
        return found

    start = [-float(v.begin), float(v.off), float(v.speed), *[0.0] * 5]
    return Law(("r.x", "r.y", "v.x", "v.y"), start, rates, slice(5, None), clipped, read, 1e-3)


def growths(instance, law: Law, seed: int = 1) -> tuple[list[Fraction], list[float], list[float]]:
    """Times, the largest growth of impulses by then, and S."""
    truth = instance.truth()
    end = float(instance.times[-1])
    rng = np.random.default_rng(seed)
    step = end / STEPS
    # Most of the time nothing touches: half of the impulses and looks are during the contact.
    begin, last = contact_of(instance, law, step)
    struck = {0, *rng.integers(begin, last, IMPULSES // 2).tolist()}
    struck |= set(rng.integers(0, STEPS, IMPULSES // 2).tolist())
    looks = {STEPS, *rng.integers(begin + 1, last, LOOKS // 2).tolist()}
    looks |= set(rng.integers(1, STEPS, LOOKS // 2).tolist())
    sizes = np.array([float(truth.scale[name]) for name in law.struck])
    count = len(sizes)
    moves = np.zeros((len(law.start), count))
    moves[:count] = law.size * np.diag(sizes)
    base = np.array(law.start)[:, None]
    pairs = np.zeros((len(law.start), 0))
    found = []
    for k in range(STEPS + 1):
        if k in looks:
            found.append(left_of(law, truth.scale, pairs, count))
        if k in struck:
            pairs = np.concatenate([pairs, base + moves, base - moves], axis=1)
        y = stepped(law, np.concatenate([base, pairs], axis=1), step)
        base = y[:, :1]
        pairs = y[:, 1:]
    times = [Fraction(k * step) for k in sorted(looks)]
    return times, found, [truth.sensitivity(t) for t in times]


def contact_of(instance, law: Law, step: float) -> tuple[int, int]:
    """The first step of the contact and the one after its last: there velocities change."""
    y = np.array(law.start)[:, None]
    changes = []
    for _ in range(STEPS):
        after = stepped(law, y, step)
        changes.append(bool(np.abs(law.rates(y)[law.forces]).max() > 0))
        y = after
    touching = [k for k, changed in enumerate(changes) if changed]
    return touching[0], touching[-1] + 1


def stepped(law: Law, y: State, h: float) -> State:
    """A step of Runge and Kutta, at whose end the spring is clipped."""
    k1 = law.rates(y)
    k2 = law.rates(y + h / 2 * k1)
    k3 = law.rates(y + h / 2 * k2)
    k4 = law.rates(y + h * k3)
    return law.clipped(y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))


def left_of(law: Law, scale, pairs: State, count: int) -> float:
    """The largest sum, over the coordinates struck, of what a quantity answers."""
    largest = 1.0
    for name, values in law.read(pairs).items():
        both = values.reshape(-1, 2, count)
        answers = np.abs(both[:, 0] - both[:, 1]).sum(axis=1)
        largest = max(
            largest, float(answers.max(initial=0.0)) / (2 * law.size * float(scale[name]))
        )
    return largest


def compared(instance, law: Law) -> None:
    """S is not below the largest growth, and at most twice of it."""
    for t, growth, bound in zip(*growths(instance, law), strict=True):
        assert growth <= bound * (1 + MARGIN), (
            f"t = {float(t)}: an impulse grows by {growth}, S is {bound}"
        )
        assert bound <= MAX_OVERESTIMATE * growth, (
            f"t = {float(t)}: S is {bound}, the largest growth {growth}"
        )


@pytest.mark.parametrize("angle", ["1/4", "-0.05", "1/2", "1.2", "0"])
def test_s_of_mindlins_contact_covers_errors_at_all_times(angle):
    """Those of the start alone were a twentieth of it after a stick (angle -0.05)."""
    instance = discovery.case("impact-benchmarks").at(member="dem-05-mindlin", angle=angle)
    compared(instance, mindlin(member("dem-05-mindlin").values(instance.p)))


PATHS = [
    ("contact-path", {}),
    ("contact-path", {"partner_spin": "-0.985"}),
    ("contact-path", {"partner_spin": "3"}),
    ("contact-path", {"partner_spin": "-1.02"}),
    ("contact-path", {"branch": "R-d", "partner_radius": "1/2"}),
    ("contact-path", {"branch": "R", "friction": "3"}),
    ("contact-path-turned", {}),
]


@pytest.mark.parametrize(("name", "given"), PATHS)
def test_s_of_a_path_covers_errors_in_its_plane_at_all_times(name, given):
    instance = discovery.case("impact-benchmarks").at(member=name, **given)
    one = member(name)
    compared(instance, passing(one.values(instance.p), one.frame))
