"""Two spheres: against series in Cartesian coordinates, the law itself, momenta, energy, and what
may not be certified.
"""

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product

import pytest
from flint import arb, arb_series, ctx

from refdem.core import discovery
from refdem.errors import NotCertifiedError
from refdem.truth.balls import arb_of, precision
from refdem.truth.closed_forms.spinning_spheres import truth
from refdem.truth.closed_forms.two_spheres import NAMES, TwoSpheres
from refdem.truth.contact_motion import ContactMotion, TracedContact
from refdem.truth.contact_phases import ContactPhases
from refdem.truth.head_on_contact import HeadOnContact
from refdem.truth.refiner import Refiner
from refdem.truth.sphere_pair import SpherePair

ZERO = Fraction(0)
ONE = Fraction(1)
PAIR = SpherePair(
    masses=(ONE, Fraction(3)),
    radii=(Fraction(1, 2), Fraction(3, 4)),
    stiffness=Fraction(100),
    damping=ZERO,
    tangential_stiffness=ZERO,
    friction=ZERO,
    closing_speed=ONE,
    angle=ZERO,
    spins=(ZERO,) * 6,
    lever=Fraction(1, 2),
    ends_with_overlap=True,
)
SPINS = (ZERO, ZERO, Fraction(2), ZERO, ZERO, Fraction(-1))
OBLIQUE = replace(PAIR, angle=Fraction(3, 5))
SLIDING = replace(OBLIQUE, friction=Fraction(1, 20), spins=SPINS)
SCALE = {name: {"r": 0.1, "v": 1.0, "o": 2.0}[name[0]] for name in NAMES}


@cache
def spheres(pair):
    return TwoSpheres(Refiner.of(SCALE), pair)


def state(pair, t):
    balls = spheres(pair).at(Fraction(t))
    assert all(ball.radius <= Fraction(1, 10**40) for ball in balls.values())
    return {name: arb_of(ball.mid) for name, ball in balls.items()}


def relative(pair, t):
    """x, y, vx, vy, omega1, omega2 from the 18 quantities."""
    now = state(pair, t)
    return [now[f"{kind}1.{axis}"] - now[f"{kind}2.{axis}"] for kind in "rv" for axis in "xy"] + [
        now["omega1.z"],
        now["omega2.z"],
    ]


def cartesian(pair, side, pulls):
    """The rates of (x, y, vx, vy, omega1, omega2), from vectors: nothing polar, levers in the
    torques themselves.
    """
    mass, stiffness, damping, friction = (
        arb_of(v) for v in (pair.effective_mass, pair.stiffness, pair.damping, pair.friction)
    )
    radii = [arb_of(r) for r in pair.radii]
    moments = [arb_of(j) for j in pair.moments]

    def rates(y):
        x, z, vx, vz, _, _ = y
        distance = (x * x + z * z).sqrt()
        nx = x / distance
        nz = z / distance
        overlap = radii[0] + radii[1] - distance
        force = stiffness * overlap - damping * (nx * vx + nz * vz)
        if not pulls:
            rub = -side * friction * force
        else:
            rub = arb(0) * force
        fx = force * nx - rub * nz
        fz = force * nz + rub * nx
        turned = [-(radii[i] - arb_of(pair.lever) * overlap) * rub / moments[i] for i in (0, 1)]
        return [vx, vz, fx / mass, fz / mass, *turned]

    return rates


def stepped(rates, start, h, order=40):
    """One Taylor step on midpoints, without a remainder."""
    series = [arb_series([part.mid()], prec=1) for part in start]
    for length in range(2, order + 1):
        ctx.cap = length
        series = [
            part.mid() + rate.integral() for part, rate in zip(start, rates(series), strict=True)
        ]
    return [
        sum((c.mid() * h**n for n, c in enumerate(one.coeffs())), arb(0)).mid() for one in series
    ]


def witness(pair, t, side=0, steps=24, pulls=False, start=None):
    """The relative state at t while the contact lasts."""
    before = ctx.cap
    speed = arb_of(pair.closing_speed)
    angle = arb_of(pair.angle)
    now = start or [
        arb_of(-pair.reach),
        arb(0),
        speed * angle.cos(),
        speed * angle.sin(),
        *(arb_of(pair.spins[i]) for i in (2, 5)),
    ]
    rates = cartesian(pair, side, pulls)
    for _ in range(steps):
        now = stepped(rates, now, arb_of(t) / steps)
    ctx.cap = before
    return now


CONTACTS = [
    (OBLIQUE, 0),
    (replace(OBLIQUE, angle=Fraction(-7, 5)), 0),
    (replace(OBLIQUE, damping=Fraction(4)), 0),
    (replace(OBLIQUE, damping=Fraction(40)), 0),
    *((replace(SLIDING, lever=lever), -1) for lever in (ZERO, Fraction(1, 2), ONE)),
    (replace(SLIDING, damping=Fraction(2), ends_with_overlap=False), -1),
    (replace(SLIDING, tangential_stiffness=Fraction(100)), -1),
    (replace(SLIDING, angle=ZERO, spins=(ZERO, ZERO, Fraction(-9), ZERO, ZERO, ZERO)), 1),
]


@pytest.mark.parametrize(("pair", "side"), CONTACTS)
@pytest.mark.parametrize("t", [Fraction(1, 5)])
def test_contact_is_the_taylor_series_in_cartesian_coordinates(pair, side, t):
    with precision(256):
        found = relative(pair, t)
        expected = witness(pair, t, side)
        assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) < 1e-30


def motion(pair, bits=192):
    """From phase to phase, head-on or not, followed until the spheres part."""
    found = ContactMotion(TracedContact(ContactPhases(pair)), bits)
    found.part()
    return found


def test_a_pulling_contact_does_not_rub():
    pair = replace(SLIDING, damping=Fraction(6))
    times = {
        event.name: Fraction(float(event.time)) * ContactPhases(pair).time
        for event in motion(pair).events
    }
    released = times["pull"]
    gone = times["release"]
    with precision(256):
        at_release = relative(pair, released - Fraction(1, 1000))
        end = witness(pair, Fraction(1, 1000), -1, steps=2, start=at_release)
        assert abs(relative(pair, released)[4] - end[4]) < 1e-12
        assert relative(pair, (released + gone) / 2)[4].overlaps(relative(pair, gone + 1)[4])


@pytest.mark.parametrize(
    ("damping", "cut"), [(0, True), (4, True), (4, False), (30, False), (60, False)]
)
def test_the_head_on_form_is_the_integration_from_phase_to_phase(damping, cut):
    pair = replace(PAIR, damping=Fraction(damping), ends_with_overlap=cut)
    phases = ContactPhases(pair)
    found = motion(pair)
    with precision(256):
        for t in ("0.05", "0.2", "0.4", "1"):
            place = found.place(arb_of(Fraction(t) / phases.time))
            assert abs(place[0] * arb_of(phases.length) - relative(pair, Fraction(t))[0]) < 1e-30
            assert abs(place[2] * arb_of(phases.speed) - relative(pair, Fraction(t))[2]) < 1e-30
        forms = HeadOnContact(pair).constants()
        force = arb_of(pair.effective_mass * phases.speed / phases.time)
        assert abs(found.deepest() * arb_of(phases.length) - forms["max_overlap"]) < 1e-30
        assert abs(found.hardest() * force - forms["max_force"]) < 1e-30
        assert abs(found.events[-1].time * arb_of(phases.time) - forms["duration"]) < 1e-30


def numeric_extremes(pair):
    """Largest overlap and force of the head-on law over a fine grid, in doubles, by its own
    recurrence (velocity Verlet).
    """
    mass = float(pair.effective_mass)
    k = float(pair.stiffness)
    c = float(pair.damping)
    h = 1e-5
    d = 0.0
    v = float(pair.closing_speed)
    most = 0.0
    hardest = 0.0
    t = 0.0
    while (d >= 0.0 if pair.ends_with_overlap else k * d + c * v >= 0.0) and t < 3.0:
        most = max(most, d)
        hardest = max(hardest, k * d + c * v)
        half = v - h / 2 * (k * d + c * v) / mass
        d += h * half
        v = (half - h / 2 * k * d / mass) / (1 + h / 2 * c / mass)
        t += h
    return {
        "max_overlap": most,
        "max_force": hardest,
        "duration": t,
        "restitution": -v / float(pair.closing_speed),
    }


@pytest.mark.parametrize(("damping", "cut"), [*product([0, 4, 12, 30, 60], [True, False])])
def test_head_on_scalars_are_those_of_a_fine_simulation(damping, cut):
    pair = replace(PAIR, damping=Fraction(damping), ends_with_overlap=cut)
    scalars = spheres(pair).scalars()
    expected = numeric_extremes(pair)
    assert {"max_overlap", "max_force"} <= set(scalars)
    for name, ball in scalars.items():
        assert float(ball.mid) == pytest.approx(expected[name], rel=2e-4, abs=2e-4)


def test_critical_damping_joins_the_regimes_on_both_sides():
    # c = 2 sqrt(k m) = 30 with k = 300, m_eff = 3/4
    pair = replace(PAIR, stiffness=Fraction(300), damping=Fraction(30), ends_with_overlap=False)
    at = spheres(pair).scalars()
    for factor in (1 - Fraction(1, 10**8), 1 + Fraction(1, 10**8)):
        near = spheres(replace(pair, damping=30 * factor)).scalars()
        for name, ball in at.items():
            assert float(near[name].mid) == pytest.approx(float(ball.mid), rel=1e-6)
    assert float(at["duration"].mid) == pytest.approx(0.1, rel=1e-15)
    assert float(at["restitution"].mid) == pytest.approx(0.1353352832366127, rel=1e-14)


def test_a_sample_exactly_at_the_end_of_the_force_is_certified():
    # Critical: the force ends at 2/b = 2 m_eff 2/c = 3/8 with m_eff = 3/4, c = 8, k = c^2/(4 m_eff)
    # = 64/3.
    pair = replace(PAIR, stiffness=Fraction(64, 3), damping=Fraction(8), ends_with_overlap=False)
    with precision(256):
        before, at, after = (
            relative(pair, Fraction(3, 8) + by)
            for by in (-Fraction(1, 10**20), ZERO, Fraction(1, 10**20))
        )
        assert max(abs(2 * b - a - c) for a, b, c in zip(before, at, after, strict=True)) < 1e-17


def test_an_overlap_that_never_ends_has_no_duration():
    assert set(spheres(replace(PAIR, damping=Fraction(60))).scalars()) == {
        "max_overlap",
        "max_force",
    }


@pytest.mark.parametrize("pair", [OBLIQUE, SLIDING, replace(SLIDING, damping=Fraction(4))])
def test_momentum_stays_zero_and_angular_momentum_where_the_levers_add_up(pair):
    def momentum(t):
        now = state(pair, t)
        (m1, m2) = pair.masses
        (j1, j2) = pair.moments
        bodies = ((m1, j1, 1), (m2, j2, 2))
        orbit = sum(
            arb_of(m) * (now[f"r{i}.x"] * now[f"v{i}.y"] - now[f"r{i}.y"] * now[f"v{i}.x"])
            for m, _, i in bodies
        )
        line = [sum(arb_of(m) * now[f"v{i}.{axis}"] for m, _, i in bodies) for axis in "xy"]
        return [*line, orbit + sum(arb_of(j) * now[f"omega{i}.z"] for _, j, i in bodies)]

    with precision(256):
        start = momentum(0)
        for t in ("0.1", "0.25", "2"):
            assert (
                max(abs(a - b) for a, b in zip(momentum(Fraction(t)), start, strict=True)) < 1e-37
            )


def test_full_lever_arms_change_the_angular_momentum_by_the_integral_of_overlap_times_friction():
    pair = replace(SLIDING, lever=ZERO)
    step = Fraction(1, 256)
    with precision(256):
        drift = []
        samples = []
        for n in range(129):
            x, y, vx, vy, *omega = relative(pair, n * step)
            spin = sum((arb_of(j) * w for j, w in zip(pair.moments, omega, strict=True)), arb(0))
            drift.append(float(arb_of(pair.effective_mass) * (x * vy - y * vx) + spin))
            overlap = max(0.0, float(arb_of(pair.reach) - (x * x + y * y).sqrt()))
            samples.append(overlap * float(pair.friction * pair.stiffness) * overlap)
    assert abs(drift[-1] - drift[0]) == pytest.approx(float(step) * sum(samples), rel=1e-3)


def test_frictionless_undamped_collision_returns_its_energy():
    scalars = spheres(OBLIQUE).scalars()
    assert abs(scalars["restitution"].mid - 1) < Fraction(1, 10**39)
    with precision(256):
        _, _, vx, vy, *_ = relative(OBLIQUE, Fraction(3))
        assert abs(vx * vx + vy * vy - 1) < 1e-38


def test_oblique_scalars_are_those_of_the_motion():
    scalars = spheres(OBLIQUE).scalars()
    with precision(256):
        end = [
            relative(OBLIQUE, scalars["duration"].mid + by)
            for by in (-Fraction(1, 10**20), Fraction(1, 10**20))
        ]
        gaps = [(x * x + y * y).sqrt() - arb_of(OBLIQUE.reach) for x, y, *_ in end]
        assert gaps[0] < 0 < gaps[1]
        deepest = max(
            float(arb_of(OBLIQUE.reach) - (x * x + y * y).sqrt())
            for x, y, *_ in (relative(OBLIQUE, t) for t in GRID)
        )
    assert deepest <= float(scalars["max_overlap"].mid)
    assert deepest == pytest.approx(float(scalars["max_overlap"].mid), rel=1e-3)
    assert scalars["max_force"].mid == pytest.approx(100 * scalars["max_overlap"].mid)


GRID = [Fraction(n, 200) for n in range(60)]


def test_a_spring_exactly_at_its_limit_is_a_corner():
    # angle 0: slip R1 omega1 = 1/2, k_t slip = mu k v = 10: stick and slip meet
    spins = (ZERO, ZERO, Fraction(1), ZERO, ZERO, ZERO)
    pair = replace(PAIR, friction=Fraction(1, 10), tangential_stiffness=Fraction(20), spins=spins)
    with pytest.raises(NotCertifiedError, match="corner"):
        state(pair, Fraction(1, 8))
    assert state(replace(pair, tangential_stiffness=Fraction(21)), Fraction(1, 8))["omega1.z"] < 1


def test_start_is_as_the_conventions_say():
    parameters = {
        "masses": PAIR.masses,
        "radii": PAIR.radii,
        "stiffness": ONE,
        "damping": ZERO,
        "tangential_stiffness": ZERO,
        "friction": ZERO,
        "closing_speed": Fraction(2),
        "angle": ONE,
        "spins": tuple(map(Fraction, range(6))),
        "branch": "R-d",
        "cutoff": "zero_force",
    }
    start = {name: float(ball.mid) for name, ball in truth(parameters, SCALE).at(ZERO).items()}
    assert tuple(start) == NAMES
    assert start["r1.x"] == pytest.approx(-0.9375)
    assert start["r2.x"] == pytest.approx(0.3125)
    assert start["v1.x"] == pytest.approx(1.5 * 0.5403023058681398)
    assert start["v1.y"] == pytest.approx(1.5 * 0.8414709848078965)
    assert start["v2.y"] == pytest.approx(-0.5 * 0.8414709848078965)
    assert [start[f"omega{i}.{axis}"] for i in (1, 2) for axis in "xyz"] == [0, 1, 2, 3, 4, 5]


def test_a_wall_with_a_stiff_tangential_spring_has_scalars_with_the_duration_of_a_soft_one():
    """The normal spring goes its own way: its contact lasts as long and rebounds as fast, in many
    hundred times of the tangential spring.
    """
    soft, stiff = (
        discovery.case("impact-benchmarks")
        .at(member="co-4", tangential_stiffness=stiffness)
        .truth()
        .scalars()
        for stiffness in ("1.48e7", "1e11")
    )
    for name in ("duration", "restitution", "max_overlap"):
        apart = abs(soft[name].mid - stiff[name].mid)
        assert apart <= soft[name].radius + stiff[name].radius
        assert stiff[name].radius < Fraction(1, 10**40)
