"""Energy, its exchange and its drift; gases, neighbours and pictures of a scene: values and bounds
as numbers that are computed on paper.

SCALES: L = 4 m, tau = 1/2 s, L/tau = 8 m/s, T = 8 s, m (L/tau)^2 = 128 J.
"""

from math import cos, log, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from refdem.checks import cooling, energy, lyapunov, symmetry
from refdem.core import discovery, refinement
from refdem.core import symmetry as pictures
from refdem.core.balance import kinetic_exchanged
from refdem.core.check import CompletedRun, Subject
from refdem.core.maps import RectangleBilliard, StadiumBilliard
from refdem.core.quantity import Scales
from refdem.core.trajectory import Cost
from refdem.core.variant import Variant
from refdem.mechanics.stability import Growth
from refdem.scene import Body, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.drag import Drag
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from tests.handmade import U, findings, instance, method, near, standing, truth

TIMES = (0.0, 2.0, 4.0, 6.0, 8.0)
LEVELS = (2.0**-3, 2.0**-4, 2.0**-5)
ROUND_OFF = 8 * U * 16
POINT = Body(mass=2.0, position=(3.0, 0.0, 0.0), velocity=(0.0, 8.0, 0.0))
BALL = Body(
    mass=2.0,
    inertia=(0.8,) * 3,
    position=(0, 0, 4.0),
    velocity=(0, 0, -4.0),
    shape=Sphere(radius=1.0),
)
SPRING = Spring(a=0, b=-1, stiffness=8.0)
SOFT = Contact(law="linear", stiffness=8.0)
CLAIMS = method(conserves=frozenset({"energy"}))
LIKE = {"rel": 1e-9}


def judged(of, run, claims=CLAIMS, levels=LEVELS, name="energy", known=None):
    """Findings of a check on a run, or on `run(variant)`."""
    return findings(discovery.check(name), Subject(of, claims, levels, known), run)


def with_speeds(of, *speeds, **more):
    """A run of one body that goes along y at these speeds."""
    return standing(of, velocity=[[[0, v, 0]] for v in speeds], **more)


def test_energy_that_is_claimed_changes_by_two_round_offs_in_units_of_the_start():
    of = instance([POINT], (SPRING,))
    # E = 64 + 36 = 100 J; then 81 + 36; m (L/tau)^2 is 128 J.
    run = with_speeds(of, 8.0, 9.0, 8.0, 8.0, 7.0)
    found = judged(of, run)["balance"]
    assert found.value == near(0.17, rel=1e-13)
    assert found.bound == near(2 * ROUND_OFF, rel=1e-13)
    assert found.sharpness == near(2 * ROUND_OFF / 0.17, rel=1e-12)


def test_energy_that_is_not_claimed_has_the_smaller_of_two_bounds_at_the_finest_level():
    of = instance([POINT], (SPRING,))
    coarse = with_speeds(of, 8.0, 8.0, 8.0625, 8.0, 8.0)
    fine = with_speeds(of, 8.0, 8.0, 8.0078125, 8.0, 8.0)
    found = judged(of, lambda v: coarse if v.level == LEVELS[0] else fine, method())
    change = (8.0625**2 - 64) / 100
    place = sqrt(128 / (2 * 100))
    assert place < 1
    assert found["finest"].value == near((8.0078125**2 - 64) / 100, rel=1e-12)
    expected = 4 * change / 16 + 2 * 20 * ROUND_OFF * place
    assert found["finest"].bound == near(expected, **LIKE)
    # The coarsest level has 9 (1/4)^2 of a relative change of 0.01: no level is sharp.
    assert "balance" not in found
    two = judged(of, fine, method(), levels=LEVELS[1:])
    assert two["finest"].bound == near(2 * (9 / 256 + ROUND_OFF), **LIKE)


def test_the_balance_is_judged_at_the_first_level_that_sees_a_tenth_of_what_is_exchanged():
    of = instance([POINT], (SPRING,))
    run = with_speeds(of, 8.0, 4.0, 4.0, 4.0, 4.0)
    levels = tuple(2.0**-k for k in range(3, 8))
    # 48 J of 100 are exchanged; 2 (1 + 4) (2 h)^2 is a tenth of it from 2 h = 1/16 on. At the next
    # level nothing is: a change of 0.48 leaves all of the bound.
    still = with_speeds(of, 8.0, 8.0, 8.0, 8.0, 8.0)
    found = judged(of, lambda v: still if v.level == 2.0**-6 else run, method(), levels)
    # The largest share of its bound is at the earliest sample.
    assert found["balance"].value == near(0.48)
    assert found["balance"].bound == near(2 * (5 / 256 + 8 * U * sqrt(256)), **LIKE)


def test_a_body_that_tumbles_exchanges_energy_between_its_axes():
    """Its kinetic energy is constant: what it could have lost is what its axes pass on."""
    body = Body(mass=1.0, inertia=(1.0, 2.0, 3.0), omega=(2.0, 0.0, 0.0))
    of = instance([body])
    # J omega^2/2 is 2 J about the first axis, and then about the second.
    run = standing(of, omega=[[[2, 0, 0]], [[1, 3**0.5 / 2**0.5, 0]], *[[[0, 2**0.5, 0]]] * 3])
    found = kinetic_exchanged(of.scene, run)
    np.testing.assert_allclose(found, [0, 1.5, 2, 2, 2], rtol=1e-14)
    # A sphere that turns about an axis of space exchanges nothing, however it is turned.
    sphere = instance([Body(mass=1.0, inertia=(2.0,) * 3, omega=(0.0, 0.0, 1.0))])
    turned = [[[cos(a), 0.0, sin(a), 0.0]] for a in (0.0, 0.5, 1.0, 1.5, 2.0)]
    spun = standing(sphere, attitude=turned, omega=[[[0.0, 0.0, 1.0]]] * 5)
    np.testing.assert_allclose(kinetic_exchanged(sphere.scene, spun), 0.0, atol=1e-15)
    # Of a circular orbit the axes of space exchange m v^2/2.
    orbit = instance([POINT])
    ways = [[[8.0, 0, 0]], [[0, 8.0, 0]], [[-8.0, 0, 0]], [[0, -8.0, 0]], [[8.0, 0, 0]]]
    half = 0.5 * POINT.mass * 64
    round_it = kinetic_exchanged(orbit.scene, standing(orbit, velocity=ways))
    np.testing.assert_allclose(round_it, [0, half, 0, half, 0])


def test_the_balance_of_the_finest_level_stands_alone_where_claims_decide_nothing():
    of = instance([POINT], (SPRING,))

    def turned(*speeds):
        """Speeds at the samples, the velocity turned by up to 16 degrees."""
        ways = ([1, 0, 0], [0.96, 0.28, 0], [0.96, -0.28, 0], [1, 0, 0], [0.96, 0.28, 0])
        pairs = zip(speeds, ways, strict=True)
        return standing(of, velocity=[[[v * x for x in way]] for v, way in pairs])

    def found(coarse, fine, levels=LEVELS):
        return judged(of, lambda v: coarse if v.level == levels[0] else fine, method(), levels)

    even = turned(8.0, 8.0, 8.0, 8.0, 8.0)
    uneven = turned(8.0, 8.0, 8.0625, 8.0, 8.0)
    # 0.28^2 64 = 5 J of 100 are exchanged between x and y; 2 (5/256) is more than a tenth of it.
    alone = found(uneven, even)
    assert set(alone) == {"finest"}
    assert alone["finest"].outcome == "pass"
    # With two levels nothing is extrapolated, and nothing decided: that is said once.
    assert found(uneven, even, LEVELS[1:])["finest"].outcome == "undecided"
    assert set(found(uneven, even, LEVELS[1:])) == {"finest"}


def test_the_change_at_the_next_halving_implies_the_error_of_the_energy():
    of = instance([POINT], (SPRING,))
    levels = (2.0**-6, 2.0**-7)

    def turned(fastest):
        """Velocities that turn by 37 degrees to either side, one of them a little faster."""
        ways = ([1, 0, 0], [0.8, 0.6, 0], [0.8, -0.6, 0], [1, 0, 0], [0.8, 0.6, 0])
        speeds = (8.0, 8.0, fastest, 8.0, 8.0)
        return standing(
            of, velocity=[[[v * x for x in w]] for v, w in zip(speeds, ways, strict=True)]
        )

    def found(coarse, fine):
        runs = {levels[0]: turned(coarse), levels[1]: turned(fine)}
        return judged(of, lambda v: runs[v.level], method(), levels)

    balance = found(8.0078125, 8.001953125)["balance"]
    # 4/(1 - 1/4) of the change of v^2/100, and twenty round-offs.
    implied = 4 / (3 / 4) * (8.0078125**2 - 8.001953125**2) / 100
    assert balance.bound == near(implied, rel=1e-6)
    assert balance.outcome == "pass"
    assert "of which the change at the next halving leaves 0.28" in balance.basis
    # An error that a halving hardly changes is none of the step.
    assert found(8.0078125, 8.0075)["balance"].outcome == "fail"


def test_places_far_away_and_slow_meetings_round_the_energy_of_contacts():
    slow = Body(
        mass=2.0,
        inertia=(0.8,) * 3,
        position=(0, 0, 40.0),
        velocity=(0, 0, -1.0),
        shape=Sphere(radius=1.0),
    )
    of = instance([slow], (SOFT, Plane()))
    found = judged(of, standing(of))["balance"]
    # |r|/L = 10, E_s/(2 E_0) = 128/(2 x 1).
    assert found.bound == near(2 * ROUND_OFF * 10 * 8, rel=1e-13)
    swinging = instance([Body(mass=2.0, position=(40.0, 0, 0))], (SPRING,))
    # Without contacts the distance is no factor; E_0 = 6400 J.
    assert judged(swinging, standing(swinging))["balance"].bound == near(2 * ROUND_OFF)


def test_what_falls_rounds_velocities_alike_at_every_step():
    falling = Body(mass=2.0, position=(0, 0, 1.0), velocity=(0, 0, 8.0))
    of = instance([falling], (UniformGravity(g=(0, 0, -2.0)),))
    # E_0 = 64 + 4 = 68 J, not less than 64; steps of 1/8 s.
    found = judged(of, standing(of))["balance"]
    expected = 2 * (ROUND_OFF * sqrt(128 / 136) + 64 * U)
    assert found.bound == near(max(expected, 2 * ROUND_OFF), rel=1e-13)


def test_work_that_is_reported_balances_energy_and_never_decreases():
    rubbing = Slider(a=0, friction=0.5, normal_force=2.0)
    of = instance([POINT], (SPRING, rubbing))
    run = with_speeds(
        of,
        8.0,
        6.0,
        6.0,
        6.0,
        6.0,
        channels={"dissipated_work": np.array([0.0, 28.0, 20.0, 31.0, 26.0])},
    )
    found = judged(of, run)
    # 36 + 36 + W against 100 J: 0, 8 too few, 3 too many.
    assert found["balance"].value == near(0.08)
    assert found["dissipation"].value == near(0.08)
    assert found["dissipation"].bound == near(2 * ROUND_OFF, rel=1e-13)
    lost = standing(of, velocity=run.velocity)
    silent = judged(of, lost)
    assert "dissipation" not in silent
    derived = method(conserves=frozenset({"energy"}), derived={"dissipated_work": "the rest"})
    assert "dissipation" not in judged(of, run, derived)


def test_without_work_energy_may_not_rise_above_any_earlier_value():
    rubbing = Slider(a=0, friction=0.5, normal_force=2.0)
    of = instance([POINT], (SPRING, rubbing))
    found = judged(of, with_speeds(of, 8.0, 6.0, 7.0, 5.0, 5.5))["balance"]
    # 49 - 36 of 100 J.
    assert found.value == near(0.13)
    assert "The rise of energy above any earlier value" in found.sentence


def test_springs_of_contacts_may_hold_energy_and_not_give_more():
    law = Contact(law="linear", stiffness=8.0, friction=0.5, tangential_stiffness=2.0)
    of = instance([BALL], (law, Plane()))
    rising = standing(of, velocity=[[[0, 0, v]] for v in (-4.0, 3.0, 5.0, 4.0, 4.0)])
    found = judged(of, rising)["balance"]
    # 25 - 16 of 16 J.
    assert found.value == near(9 / 16)
    hertz = Contact(law="hertz", stiffness=8.0, friction=0.5, tangential_stiffness=2.0)
    stiff = instance([BALL], (hertz, Plane()))
    assert judged(stiff, standing(stiff))["finest"].outcome == "undecided"


def test_work_of_a_drag_is_integrated_between_samples_as_far_as_they_show_it():
    of = instance([POINT], (SPRING, Drag(a=0, b=-1, coefficient=0.1)))
    # Samples 2 s apart are 4 rad of the fastest motion; nothing drives, and energy may not rise.
    found = judged(of, with_speeds(of, 8.0, 6.0, 7.0, 5.0, 5.5))["balance"]
    assert found.value == near(0.13)
    assert energy.MOST_RADIANS == 2.0


def test_a_symplectic_method_keeps_the_mean_energy_of_quarters():
    of = instance([POINT], (SPRING,), times=tuple(float(t) for t in range(9)))
    speeds = (8.0, 8.5, 8.0, 9.0, 3.0, 8.0, 8.0, 7.0, 6.0)
    run = standing(of, velocity=[[[0, v, 0]] for v in speeds])
    claims = method(symplectic=True, constant=3.0)
    found = judged(of, run, claims)["drift"]
    first = (64 + 72.25) / 2
    last = (49 + 36) / 2
    assert found.value == near((first - last) / 100)
    expected = 2 * (3 * (1 / 16) ** 2 + ROUND_OFF * sqrt(128 / 200))
    assert found.bound == near(expected, **LIKE)
    assert "drift" not in judged(of, run, method())


def test_the_energy_of_a_fall_without_end_drifts_with_the_velocity():
    of = instance([POINT], (UniformGravity(g=(0, -1, 0)),), times=tuple(float(t) for t in range(9)))
    run = standing(of, velocity=[[[0, v, 0]] for v in (8, 4, 0, -4, -8, -12, -16, -20, -24)])
    claims = method(symplectic=True, constant=3.0)
    found = judged(of, run, claims)["drift"]
    # The fall ends at 24 m/s, three times the scale of 8 m/s.
    truncation = 2 * 3 * (1 / 16) ** 2
    assert found.bound == near(3 * truncation, rel=1e-9)
    slow = standing(of, velocity=[[[0, v, 0]] for v in (2, 8, 2, 8, 2, 8, 2, 8, 2)])
    assert judged(of, slow, claims)["drift"].bound == near(truncation, rel=1e-9)


def test_energy_drifts_by_at_most_twice_what_the_coarsest_step_implies():
    of = instance([POINT], times=tuple(float(t) for t in range(9)))
    claims = method(symplectic=True, constant=3.0)
    speeds = (8.0, 8.0, 8.0, 8.0, 8.03125, 8.0, 8.0, 8.0, 8.0)
    run = standing(of, velocity=[[[0, v, 0]] for v in speeds])
    found = judged(of, run, claims)
    imbalance = (8.03125**2 - 64) / 64
    # Two halvings from the coarsest step, order 2; factor 4, and twice.
    assert found["drift"].bound == near(2 * 4 * imbalance / 16, rel=1e-6)
    assert "implied by that at the coarsest step" in found["drift"].basis


def test_rods_of_methods_with_a_tolerance_stretch_by_rounding_in_time():
    of = instance([POINT], (Rod(a=0, b=-1, length=3.0),))
    claims = method("tolerance")
    found = judged(of, standing(of), claims, (1e-6,))["balance"]
    # At t = 0: 1e3 tol; rods add 8 u sqrt(64) t/tau.
    bounds = 2 * (1e-3 + ROUND_OFF + 8 * U * 8 * 2 * np.array(TIMES))
    assert found.bound == near(bounds[0], rel=1e-13)
    subject = Subject(of, claims, (1e-6,), None)
    np.testing.assert_allclose(
        energy._rod_rounding(subject), 8 * U * 8 * 2 * np.array(TIMES), rtol=1e-13
    )
    held = Subject(of, method("tolerance", conserves=frozenset({"constraint"})), (1e-6,), None)
    assert energy._rod_rounding(held) == 0.0
    assert energy._rod_rounding(Subject(of, method(), LEVELS, None)) == 0.0


# Gases


def gas_of(temperatures, *, restitution=0.75, work=None, count=None, haff=4.0, n=101):
    """Findings on a gas of spheres whose temperature is that of samples, and its events."""
    gas = cooling.Gas(n, restitution, 0.0, 0.01, 2.0)
    run = SimpleNamespace(
        t=np.array([0.0, 1.0, 2.0]),
        channels={} if work is None else {"dissipated_work": np.array(work)},
    )
    return gas, run, np.array(temperatures), haff, count


def test_the_temperature_of_a_gas_follows_haff_to_four_standard_errors():
    gas, run, temperature, haff, _ = gas_of([4.0, 2.0, 1.5])
    found = cooling.CHECK._temperature(gas, run.t, temperature, haff, 1e-12)
    law = 4.0 / (1 + run.t / 4) ** 2
    # (n - 1)/2 w_c in the mean: 50 x 2/2 (sqrt T) integrated: 4 x 50 ln(1 + t/4) x 2.
    counted = 50 * 2.0 * 4 * np.log(1 + run.t / 4)
    scatter = 4 * 2 * (1 - 0.75**2) / (3 * 100) * np.sqrt(2 * counted)
    shift = 0.01 * 2 * (run.t / 4) / (1 + run.t / 4)
    allowed = scatter + shift + 1e-12
    values = np.abs(np.log(temperature / law))
    worst = int(np.argmax(values / allowed))
    assert found.value == near(values[worst], **LIKE)
    assert found.bound == near(allowed[worst], **LIKE)


def test_contacts_that_last_hold_a_part_of_the_energy():
    gas = cooling.Gas(100, 0.75, 0.01, 0.01, 4.0)
    assert gas.softness == 0.04
    found = cooling.CHECK._temperature(gas, np.array([0.0, 1.0]), np.array([4.0, 4.0]), np.inf, 0.0)
    assert found.series.bound[0] == near(0.04 + 4 * sqrt(0.04 / 100), **LIKE)


def test_collisions_are_counted_to_four_standard_errors_and_lose_what_the_law_says():
    gas = cooling.Gas(101, 0.5, 0.125, 0.01, 0.25)
    run = SimpleNamespace(
        t=np.array([0.0, 8.0, 16.0]),
        channels={"dissipated_work": np.array([[0.0, 0], [9, 9], [400.0, 250.0]])},
    )
    temperature = np.array([4.0, 4.0, 4.0])
    # 50 spheres meet 1/4 times a second for 16 s: 200.
    count, loss = cooling.CHECK._collision_findings(gas, run, temperature, 210)
    allowed = 4 / sqrt(200) + 0.01 + 0.125 * 0.25
    assert count.value == near(0.05)
    assert count.bound == near(allowed, **LIKE)
    assert loss.value == near(abs(650 / (210 * 0.75 * 4) - 1), **LIKE)
    assert loss.bound == near(allowed + 0.125 / 16, **LIKE)
    elastic = cooling.Gas(101, 1.0, 0.125, 0.01, 0.25)
    assert len(cooling.CHECK._collision_findings(elastic, run, temperature, 210)) == 1


@pytest.mark.parametrize(("frequency", "is_judged"), [(0.0374, False), (0.0376, True)])
def test_a_mean_is_taken_from_thirty_collisions(frequency, is_judged):
    gas = cooling.Gas(101, 0.5, 0.0, 0.01, frequency)
    run = SimpleNamespace(t=np.array([0.0, 16.0]), channels={})
    (found,) = cooling.CHECK._collision_findings(gas, run, np.array([4.0, 4.0]), 30)
    assert (found.outcome != "undecided") == is_judged


def test_velocities_of_an_elastic_gas_have_no_kurtosis_to_four_errors():
    gas = cooling.Gas(4, 1.0, 0.01, 0.01, 3.0)
    velocity = np.array([[[1.0, 1, 1], [-1, -1, -1], [1, 1, 1], [-1, -1, -1]]])
    found = cooling.CHECK._distribution(gas, SimpleNamespace(velocity=velocity))
    assert found.value == 2.0
    assert found.bound == near(4 * (sqrt(24 / 9) + 6 / 9) + 0.03, **LIKE)


# Bounces


def test_the_wall_of_a_stadium_and_of_a_rectangle():
    from refdem.checks.bounces import wall

    stadium = StadiumBilliard(width=4.0, height=2.0)
    distance, normal = wall(stadium, np.array([[0.5, 1.25], [1.6, 0.8], [-1.6, -0.8], [0.0, -0.5]]))
    np.testing.assert_allclose(distance, [0.25, 0.0, 0.0, -0.5], atol=1e-15)
    np.testing.assert_allclose(normal, [[0, 1], [0.6, 0.8], [-0.6, -0.8], [0, -1]], atol=1e-15)
    rectangle = RectangleBilliard(width=4.0, height=2.0)
    distance, normal = wall(
        rectangle, np.array([[2.25, 0.5], [-1.5, -1.125], [2.0, 1.0], [2.0, 1 - 3e-12]])
    )
    np.testing.assert_allclose(distance, [0.25, 0.125, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(normal, [[1, 0], [0, -1], [0, 0], [1, 0]])


# Neighbours


def exponent(observed, true, duration=10.0, bound=1.0):
    """The finding on an exponent against that of truth."""
    of = instance([POINT], times=(0.0, duration / 2, duration), quantities={"x": 1.0})
    known = truth(of.times, {"x": [0.0] * 3}, growth=[1.0, 1.0, bound / ROUND_OFF])
    subject = Subject(of, method("exact"), (0.0,), known)
    return lyapunov.CHECK._against_truth(subject, observed, true, of.times)


def test_an_exponent_is_off_by_three_errors_and_ln_ten_over_the_time():
    found = exponent(Growth(0.75, 0.01, 9.0), Growth(0.5, 0.02, 9.0))
    assert found.value == 0.25
    assert found.bound == near(3 * 0.03 + log(10) / 10, **LIKE)
    assert found.unit == "1/s"


def test_a_run_on_the_true_motion_grows_at_most_twice_and_at_least_a_thousandth():
    faster = exponent(Growth(0.75, 1.0, 9.0), Growth(0.5, 1.0, 9.0), bound=0.009)
    assert faster.bound == near(log(2) / 10, **LIKE)
    slower = exponent(Growth(0.25, 1.0, 9.0), Growth(0.5, 1.0, 9.0), bound=0.009)
    assert slower.bound == near(log(1000) / 10, **LIKE)
    sure = exponent(Growth(0.25, 0.01, 9.0), Growth(0.5, 0.02, 9.0), bound=0.009)
    assert sure.bound == near(3 * 0.03 + log(10) / 10, **LIKE)
    lost = exponent(Growth(0.75, 1.0, 9.0), Growth(0.5, 1.0, 9.0), bound=0.011)
    assert lost.bound == near(6 + log(10) / 10, **LIKE)


@pytest.mark.parametrize(
    ("exponent", "error", "power", "value"),
    [(0.5, 0.2499, 2.01, 0.0), (0.5, 0.2501, 2.01, 1.0), (0.5, 0.1, 2.0, 1.0)],
)
def test_a_motion_is_chaotic_by_two_errors_and_faster_than_the_square_of_time(
    exponent, error, power, value
):
    found = lyapunov.CHECK._positive(Growth(exponent, error, power))
    assert (found.value, found.bound) == (value, 0.0)


@pytest.mark.parametrize(
    ("power", "true", "octaves", "bound"),
    [
        (1.0, None, 0.0, 2.0),
        (3.0, 2.5, 0.0, 2.5),
        (3.0, 2.5, 0.5, 3.5),
        (2.25, 2.5, 0.5, 2.5),
        (3.0, 2.5, -0.5, 2.5),
        (-1.0, 1.5, 0.0, 2.0),
    ],
)
def test_neighbours_in_a_regular_motion_part_as_the_square_of_time_or_as_truth_does(
    power, true, octaves, bound
):
    known = None if true is None else Growth(0.0, 0.0, true)
    found = lyapunov.CHECK._regular(Growth(0.0, 0.0, power), known, octaves)
    assert (found.value, found.bound) == (max(0.0, power), bound)


@pytest.mark.parametrize(("duration", "applies"), [(49.99, False), (50.0, True)])
def test_a_regular_motion_is_told_after_a_hundred_tau(duration, applies):
    of = instance(
        [POINT], times=(0.0, duration), scales=Scales(4.0, 0.5, duration, 2.0), is_chaotic=False
    )
    said = lyapunov.CHECK.applies(Subject(of, method(), LEVELS, None))
    assert (said is None) == applies


def chaotic(power, rate):
    """The findings where truth grows with this exponent in the mean, over a time of 10 s."""
    times = np.linspace(0.0, 10.0, 17)
    of = instance([POINT], times=times, quantities={"x": 1.0}, is_chaotic=True)
    growth = np.exp(rate * times)
    known = truth(times, {"x": [0.0] * 17}, growth=growth.tolist())
    subject = Subject(of, method("exact"), (0.0,), known)
    observed = Growth(rate, 0.0, power)
    return {f.quantity: f for f in lyapunov.CHECK._of_chaotic_motion(subject, times, observed)}


def test_truth_is_clearly_chaotic_that_grows_faster_than_the_cube_of_time():
    # The power over the second half is rate 5/ln 2: 3 at 0.4159.
    assert set(chaotic(9.0, 0.42)) == {"class", "exponent"}
    assert chaotic(9.0, 0.41)["class"].outcome == "undecided"


# Pictures


def test_sizes_of_pictures_are_those_of_their_numbers():
    body = Body(mass=2.0, position=(8.0, 0, 0), velocity=(0, 24.0, 0))
    of = instance([body])
    none = pictures.Symmetry()
    # |x|/L = 2, |v| tau/L = 3.
    assert pictures.size(of, none) == 3.0
    assert pictures.size(of, pictures.Symmetry(shift=np.array([3.0, 4.0, 0.0]) * 4)) == 8.0
    # |u| T/L + |u| tau/L = 2 x 8/4 + 2/8
    boosted = pictures.Symmetry(boost=np.array([0.0, 2.0, 0.0]))
    assert pictures.size(of, boosted) == 3.0 + 4.0 + 0.25
    slow = instance([Body(mass=1.0)])
    assert pictures.size(slow, none) == 1.0


def test_moments_of_a_needle_are_rounded_to_another_rate():
    needle = Body(mass=1.0, inertia=(1.0, 4.0, 4.5))
    held = Body(mass=1.0, inertia=(0.001, 9.0, 9.0), fixed=True)
    of = instance([needle, held])
    # (4 + 4.5)/1 T/tau
    assert pictures.rounded_rates(of) == 8.5 * 16
    assert pictures.rounded_rates(instance([POINT])) == 0.0


def test_round_off_of_a_picture_is_that_of_both_runs_and_of_other_units():
    needle = Body(mass=1.0, inertia=(1.0, 4.0, 4.5), omega=(0, 0, 1.0))
    of = instance([needle], (SOFT,))
    subject = Subject(of, method(conserves=frozenset({"momentum"})), LEVELS, None)
    plain = pictures.of(of, "mirrored")
    level = symmetry.level_for(subject)
    expected = 2 * subject.noise(level)
    assert symmetry.round_off(subject, level, plain) == near(expected, rel=1e-13)
    # Velocities may be differences of places: tau/h times the round-off more.
    of_places = Subject(of, method(), LEVELS, None)
    of_differences = 2 * subject.round_off(level) * of.scales.tau / level
    rounding = symmetry.round_off(of_places, level, plain)
    assert rounding == near(expected + of_differences, rel=1e-13)
    rescaled = pictures.of(of, "rescaled")
    assert symmetry.round_off(subject, level, rescaled) == near(expected + U * 8.5 * 16, rel=1e-13)


def test_images_with_the_clock_of_the_scene_have_no_noise_of_a_clock():
    driven = Force(a=0, b=-1, amplitude=0.5, frequency=2.0)
    of = instance([POINT], (driven,))
    claims = method(conserves=frozenset({"momentum"}), summed_clock=True)
    subject = Subject(of, claims, LEVELS, None)
    level = symmetry.level_for(subject)
    of_clock = refinement.clock(of, claims, level)
    assert of_clock > 0
    without = 2 * (subject.noise(level) - of_clock)
    rounding = {
        name: symmetry.round_off(subject, level, pictures.of(of, name))
        for name in ("mirrored", "rotated", "delayed")
    }
    assert rounding["mirrored"] == near(without, rel=1e-13)
    assert rounding["rotated"] == near(without, rel=1e-13)
    delayed = 2 * subject.noise(level)
    size = pictures.size(of, pictures.of(of, "delayed"))
    assert rounding["delayed"] == near(delayed * size, rel=1e-13)


def test_what_a_rounding_decides_is_at_most_the_truncation_of_both_runs():
    of = instance([BALL], (Contact(law="linear", stiffness=8.0, damping=1.0), Plane()))
    first = method(order=2, order_with={"contact": 1})
    subject = Subject(of, first, LEVELS, None)
    assert symmetry.level_for(subject) == LEVELS[-1]
    growth = np.array([1.0, 1.0, 2.0, 2.0, 3.0])
    base = standing(of)
    truncation = 2 * (1 + 2 * np.array(TIMES)) * 2 * LEVELS[-1] * growth
    runs = {Variant(LEVELS[-1]): CompletedRun(base, Cost(seconds=0.0))}
    alone = symmetry._decided_by_rounding(subject, runs, growth, "mirrored")
    np.testing.assert_allclose(alone, truncation, rtol=1e-13)
    moved = np.array(base.position)
    moved[2:, 0, 0] += 4e-5
    near = CompletedRun(standing(of, position=moved), Cost(seconds=0.0))
    perturbed = {Variant(LEVELS[-1], "perturbed", 64): near}
    shown = symmetry._decided_by_rounding(subject, runs | perturbed, growth, "mirrored")
    # Eight times the largest difference so far, 1e-5 of L.
    np.testing.assert_allclose(shown, [0, 0, 8e-5, 8e-5, 8e-5], rtol=1e-9)
    spread = symmetry.allowed(subject, pictures.of(of, "mirrored"), growth)
    of_rounding = symmetry.round_off(subject, LEVELS[-1], pictures.of(of, "mirrored")) * growth
    np.testing.assert_allclose(spread, of_rounding + truncation, rtol=1e-13)
    located = Subject(of, method(order=2), LEVELS, None)
    assert not symmetry._decided_by_rounding(located, runs, growth, "mirrored").any()


def test_a_rotated_run_differs_by_truncation_that_falls_with_the_step():
    spinning = Body(mass=1.0, inertia=(1.0, 2.0, 2.5), omega=(0, 1.0, 1.0))
    of = instance([spinning])
    levels = (2.0**-4, 2.0**-5, 2.0**-6)
    subject = Subject(of, method(), levels, None)
    view = pictures.of(of, "rotated")
    base = standing(of)

    def off_by(value):
        """A rotated run that comes back off by a part of L at the last sample."""
        shown = view.applied(of.motion)
        place = np.repeat(shown.scene.bodies.position[None], 5, axis=0)
        place[-1, 0, 0] += 4 * value
        columns = {
            name: np.repeat(getattr(shown.scene.bodies, name)[None], 5, axis=0)
            for name in ("velocity", "attitude", "omega")
        }
        return CompletedRun(standing(of, position=place, **columns), Cost(seconds=0.0))

    size = abs(np.asarray(view.q)[0]).max()
    runs = {
        Variant(levels[0]): CompletedRun(base, Cost(seconds=0.0)),
        Variant(levels[-1]): CompletedRun(base, Cost(seconds=0.0)),
        Variant(levels[0], "rotated"): off_by(0.01),
        Variant(levels[-1], "rotated"): off_by(0.001),
    }
    found = symmetry.CHECK._rotated(subject, runs, np.ones(5), np.zeros(5))
    # A place off along x' comes back off along Q^T x': its largest component counts.
    assert found.value == near(0.001 * size, rel=1e-6)
    # Two octaves at order 2 less 1/2.
    assert found.bound == near(0.01 * size / 2.0**3, rel=1e-6)
    decided = symmetry.CHECK._rotated(subject, runs, np.ones(5), np.full(5, 1e-3))
    assert decided.bound == near(0.01 * size / 8 + 1e-3, rel=1e-6)
    wild = runs | {Variant(levels[0], "rotated"): off_by(9.0)}
    limit = symmetry.CHECK._rotated(subject, wild, np.ones(5), np.zeros(5))
    assert limit.bound == near(2 * 17 / 1024, rel=1e-6)
