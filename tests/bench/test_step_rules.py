"""Steps that DEM codes choose or accept, by hand and from the motions of the cases."""

import math
from fractions import Fraction
from typing import cast

import pytest

from refdem.bench import step_rules
from refdem.core import discovery
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError, UsageError
from refdem.scene.bodies import Body
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.scene import Scene
from refdem.scene.shapes import Sphere
from refdem.truth.sampled import sampled


def ball(x: float = 0.0, vx: float = 0.0, mass: float = 1.0, *, fixed: bool = False) -> Body:
    """A solid sphere of radius 1 on the x axis."""
    return Body(
        mass=mass,
        inertia=(0.4 * mass,) * 3,
        shape=Sphere(radius=1.0),
        position=(x, 0.0, 0.0),
        velocity=(vx, 0.0, 0.0),
        fixed=fixed,
    )


def pair(law: Contact, *bodies: Body, planes: tuple[Plane, ...] = ()) -> step_rules.Pair:
    """The only pair of a scene."""
    (found,) = step_rules.pairs(Scene.of(list(bodies), [law, *planes]))
    return found


def test_a_linear_contact_lasts_half_a_damped_period() -> None:
    # m = 1/2, k/m - (c/(2 m))^2 = 20 - 4 = 16.
    found = pair(Contact(law="linear", stiffness=10.0, damping=2.0), ball(), ball(2.0))
    assert step_rules.collision_time(found) == pytest.approx(math.pi / 4)


def test_an_overdamped_contact_has_no_duration() -> None:
    found = pair(Contact(law="linear", stiffness=1.0, damping=2.0), ball(), ball(2.0))
    assert step_rules.collision_time(found) is None


def test_the_eigenperiod_is_that_of_the_lightest_sphere_or_of_its_rotation() -> None:
    law = Contact(law="linear", stiffness=16.0)
    assert step_rules.eigenperiod(pair(law, ball(), ball(2.0, mass=9.0))) == pytest.approx(
        math.sqrt(2) / 4
    )
    # I/(k_t R^2) = 0.4/16 is less than m/k = 1/16.
    rough = Contact(law="linear", stiffness=16.0, tangential_stiffness=16.0, friction=1.0)
    assert step_rules.eigenperiod(pair(rough, ball(), ball(2.0))) == pytest.approx(
        math.sqrt(2 * 0.4 / 16)
    )


def test_a_fixed_sphere_has_no_part_in_masses() -> None:
    law = Contact(law="linear", stiffness=4.0)
    found = pair(law, ball(mass=4.0), ball(2.0, mass=0.01, fixed=True))
    assert found.effective_mass == 4.0
    assert step_rules.wall_contact_time(found) == pytest.approx(math.pi)


def test_times_of_hertz_by_hand() -> None:
    # E = 1 from k = 4/3 and R = 1; rho = 1 from m = 4 pi/3; G = 3/4.
    law = Contact(law="hertz", stiffness=4 / 3)
    floor = Plane(point=(-1.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0))
    found = pair(law, ball(vx=-2.0, mass=4 * math.pi / 3), planes=(floor,))
    assert step_rules.rayleigh_time(found) == pytest.approx(3.9543, rel=1e-4)
    assert step_rules.hertz_time(found) == pytest.approx(4.4310, rel=1e-4)


def test_two_alike_spheres_have_half_the_radius() -> None:
    # k = (4/3) E sqrt(1/2).
    found = pair(Contact(law="hertz", stiffness=1.0), ball(), ball(2.0))
    assert step_rules.effective_modulus(found) == pytest.approx(0.75 * math.sqrt(2))


def test_a_pair_that_does_not_approach_has_no_hertz_time() -> None:
    found = pair(Contact(law="hertz", stiffness=1.0), ball(vx=-1.0), ball(2.0))
    assert found.speed == 0.0
    assert step_rules.hertz_time(found) is None


@pytest.mark.parametrize(
    ("case", "rule", "within"),
    [
        ("two-spheres", step_rules.collision_time, 1e-12),
        # 2.87 stands for 2.868.
        ("hertz-spheres", step_rules.hertz_time, 1e-3),
    ],
)
def test_durations_are_those_of_the_motions_of_the_cases(
    case: str, rule: step_rules.Rule, within: float
) -> None:
    instance = discovery.case(case).at()
    (touching,) = step_rules.pairs(instance.scene)
    assert rule(touching) == pytest.approx(math.pi * instance.scales.tau, rel=within)


def test_a_step_beyond_the_limit_is_wrong_altogether_and_errors_fall_with_the_step() -> None:
    found = step_rules.judged(discovery.case("two-spheres").at())
    by_part = sorted(found, key=lambda one: one.part, reverse=True)
    coarsest, *_, finest = by_part
    assert coarsest.advice.code == "exaDEM"
    # pi sqrt(m/k) over 2 sqrt(m/(2 k)).
    assert coarsest.part == pytest.approx(math.pi / math.sqrt(2))
    assert coarsest.error is not None
    assert coarsest.error > 1
    assert finest.error is not None
    # Order 2: 50 steps a contact.
    assert 1e-5 < finest.error < 1e-3


@pytest.mark.parametrize("case", ["pendulum", "hard-spheres", "lorenz"])
def test_a_scene_without_soft_contacts_is_refused(case: str) -> None:
    with pytest.raises(UsageError, match="two-spheres or hertz-spheres"):
        step_rules.judged(discovery.case(case).at())


def test_a_step_that_is_longer_than_the_run_has_no_error() -> None:
    # Damping far above critical: tau is m/c, and the run a few of these.
    found = step_rules.judged(discovery.case("two-spheres").at(damping="1000"))
    assert [one.advice.code for one in found] == ["exaDEM", "YADE", "exaDEM"]
    assert [one.error for one in found] == [None, None, None]


def test_a_truth_that_ends_before_the_run_is_refused() -> None:
    # Of main, and kept: the spheres part when a sample is due, as nearly as is proved.
    instance = discovery.case("two-spheres").at(damping="16", cutoff="zero_force", samples="16")
    with pytest.raises(UsageError, match="no certified truth of the whole run"):
        step_rules.judged(instance)


def test_a_proof_that_ends_before_the_run_is_refused() -> None:
    instance = discovery.case("two-spheres").at(samples="4")

    class Cut:
        """A proof of the first half of the run."""

        method = witness = ""

        def at(self, t: Fraction) -> dict[str, Ball]:
            if t > Fraction(instance.scales.duration) / 2:
                raise NotCertifiedError("it ends here")
            return {}

    with pytest.raises(UsageError, match=r"of the whole run.*: it ends here"):
        step_rules.certified_values(instance, cast("Truth", Cut()))


def test_values_are_those_of_the_sampled_truth() -> None:
    instance = discovery.case("two-spheres").at(samples="4")
    truth = step_rules.certified_values(instance, instance.truth())
    whole = sampled(instance.truth(), instance.times.tolist())
    assert (truth.t, truth.values, truth.radii) == (whole.t, whole.values, whole.radii)


def fixed_steps(stiffness: float, duration: float, steps: int) -> float:
    """The largest error of velocity Verlet of two spheres of 1 kg, one size of steps, that touch at
    the start and approach at 1 m/s: of place or velocity, over the scales of two-spheres.
    """
    # Half the overlap, of either sphere: x'' = -2 k x.
    omega = math.sqrt(2 * stiffness)
    scale = 1 / omega
    h = duration / steps
    x, v, force = 0.0, 0.5, 0.0
    largest = 0.0
    for step in range(1, steps + 1):
        v += h / 2 * force
        x += h * v
        force = -(omega**2) * max(x, 0.0)
        v += h / 2 * force
        t = step * h
        exact, exact_v = math.sin(omega * t) / (2 * omega), math.cos(omega * t) / 2
        if omega * t > math.pi:
            exact, exact_v = -(t - math.pi / omega) / 2, -0.5
        largest = max(largest, abs(x - exact) / scale, abs(v - exact_v))
    return largest


def test_errors_are_those_of_steps_of_one_size() -> None:
    instance = discovery.case("two-spheres").at()
    duration = instance.scales.duration
    for one in step_rules.judged(instance):
        steps = max(math.ceil(duration / one.step), 2)
        assert one.error == pytest.approx(fixed_steps(128.0, duration, steps), rel=1e-3)


@pytest.mark.parametrize(
    ("given", "words"),
    [({"friction": "0.5"}, "friction"), ({"spins": "0,0,1,0,0,0"}, "spin")],
)
def test_what_steps_of_one_size_do_not_cover_is_refused(given: dict[str, str], words: str) -> None:
    with pytest.raises(UsageError, match=f"with {words}.*friction=0"):
        step_rules.judged(discovery.case("two-spheres").at(**given))
