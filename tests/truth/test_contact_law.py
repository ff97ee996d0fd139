"""What follows from a contact's parameters is inside the proof: checked against the motion computed
here at four times the precision.
"""

from fractions import Fraction

import pytest
from flint import arb

from refdem.core import discovery
from refdem.errors import UsageError
from refdem.truth.balls import arb_of, precision
from refdem.truth.contact_law import damping_cosine, dashpot, mindlin_wall_stiffness, sphere_mass

BITS = 3000
CO_3 = {"member": "co-3"}
CO_4 = {"member": "co-4", "cutoff": "zero_force"}


def beyond_critical(places):
    """exp(-2) rounded up to so many decimal places."""
    with precision(BITS):
        scaled = (arb(-2).exp() * arb(10) ** places).floor().unique_fmpz()
    return Fraction(int(scaled) + 1, 10**places)


JUST_ENOUGH = f"0.{beyond_critical(58) * 10**58}"
"""Less than 1e-58 above exp(-2), as much as a parameter can say."""


def loss(angle, cutoff):
    """ln(1/e) = b t_c of a contact whose damping is cos(angle) of the critical one."""
    if cutoff == "zero_overlap":
        lasts = arb.pi()
    else:
        lasts = 2 * angle
    return lasts * angle.cos() / angle.sin()


def angle_of(restitution, cutoff):
    """The angle, between two whose losses are proved to lie on both sides."""
    goal = -arb_of(restitution).log()
    low = arb(0)
    high = arb.pi() / 2
    for _ in range(BITS):
        middle = ((low + high) / 2).mid()
        if loss(middle, cutoff) > goal:
            low = middle
        else:
            high = middle
    return low.union(high)


def normal_motion(instance, t):
    """r.x, v.x, and the scalars of the normal motion of a sphere on a wall: a damped sine, from the
    written parameters alone.
    """
    p = instance.case.meant(instance.p)
    radius, k, speed = (arb_of(p[name]) for name in ("radius", "stiffness", "speed"))
    mass = arb_of(p["density"]) * 4 * arb.pi() * radius**3 / 3
    cutoff = p["cutoff"]
    angle = angle_of(p["restitution"], cutoff)
    rate = (k / mass).sqrt()
    decay = rate * angle.cos()
    swing = rate * angle.sin()
    normal = speed * arb_of(p.get("angle", Fraction(0))).cos()
    lasts = (arb.pi() if cutoff == "zero_overlap" else 2 * angle) / swing

    def state(time):
        size = normal * (-decay * time).exp()
        depth = size * (swing * time).sin() / swing
        return depth, size * (swing * time).cos() - decay * depth

    depth, closing = state(arb_of(t))
    deepest, _ = state(angle / swing)
    scalars = {"duration": lasts, "max_overlap": deepest, "restitution": arb_of(p["restitution"])}
    return {"r.x": depth - radius, "v.x": closing}, scalars


def contains(ball, value):
    """The ball holds what was computed here."""
    apart = abs(arb_of(ball.mid) - value)
    return bool(apart <= arb_of(ball.radius) + arb(2) ** -1000)


@pytest.mark.parametrize(
    ("given", "digits"),
    [
        ({**CO_4, "restitution": "0.1353352832366127"}, 40),
        ({**CO_4, "restitution": "0.135336"}, 40),
        ({**CO_4, "restitution": JUST_ENOUGH}, 60),
        ({**CO_4, "restitution": "0.999999999999999"}, 40),
        ({**CO_4, "restitution": "0.73", "angle": "1.2"}, 200),
        (CO_3, 150),
        ({**CO_3, "restitution": "1e-9"}, 120),
    ],
)
def test_every_value_of_a_damped_contact_is_inside_its_ball(given, digits):
    """The dashpot came from 12 steps of Newton's rule to a nearly double root, and pi from 99
    digits: 7.7e-9 and 4.7e-101 off.
    """
    instance = discovery.case("impact-benchmarks").at(**given)
    truth = instance.truth().refined(digits)
    scalars = truth.scalars()
    t = Fraction(round(float(scalars["duration"].mid) / 3 * 2**60), 2**60)
    values = truth.at(t)
    with precision(BITS):
        expected, expected_scalars = normal_motion(instance, t)
        for name, value in expected.items():
            assert contains(values[name], value), name
        for name, value in expected_scalars.items():
            assert contains(scalars[name], value), name
    target = Fraction(1, 10**digits)
    assert all(ball.radius <= target for ball in [*values.values(), *scalars.values()])


def test_a_restitution_that_no_damping_makes_is_refused_to_the_last_digit():
    below = f"0.{beyond_critical(58) * 10**58 - 1}"
    with pytest.raises(UsageError, match=r"more than exp\(-2\)"):
        discovery.case("impact-benchmarks").at(**CO_4, restitution=below)


@pytest.mark.parametrize("digits", [1, 5, 20, 60, 200])
@pytest.mark.parametrize("ends_with_overlap", [False, True])
def test_a_dashpot_gives_back_its_restitution_however_near_to_the_critical_damping(
    digits, ends_with_overlap
):
    restitution = beyond_critical(digits)
    found = dashpot(restitution, Fraction(3), Fraction(7), ends_with_overlap=ends_with_overlap)
    with precision(BITS):
        cosine = found.ball() / (2 * arb(21).sqrt())
        angle = cosine.acos()
        if ends_with_overlap:
            cutoff = "zero_overlap"
        else:
            cutoff = "zero_force"
        again = (-loss(angle, cutoff)).exp()
        assert again.overlaps(arb_of(restitution))
        assert again.rad() < 1e-80


def test_a_scene_gets_the_rounded_values_of_the_proof():
    instance = discovery.case("impact-benchmarks").at(**CO_4, restitution="0.135336")
    p = instance.case.meant(instance.p)
    contact = next(
        element for element in instance.scene.elements if type(element).__name__ == "Contact"
    )
    with precision(BITS):
        mass = arb_of(p["density"]) * 4 * arb.pi() * arb_of(p["radius"]) ** 3 / 3
        damping = (
            2
            * (mass * arb_of(p["stiffness"])).sqrt()
            * angle_of(p["restitution"], "zero_force").cos()
        )
        assert instance.scene.bodies.mass[0] == float(mass)
        assert contact.damping == float(damping)


def test_masses_and_stiffnesses_of_spheres_are_their_formulas():
    with precision(300):
        assert (sphere_mass(Fraction(3), Fraction(2)).ball() - 32 * arb.pi()).contains(0)
        # 8 G sqrt(R)/(2 - nu) with G = E/(2 (1 + nu)), nu = 1/4, E = 10, R = 2
        expected = 8 * arb(4) / (arb(7) / 4) * arb(2).sqrt()
        assert (
            mindlin_wall_stiffness(Fraction(10), Fraction(1, 4), Fraction(2)).ball() - expected
        ).contains(0)


@pytest.mark.parametrize("bits", [53, 64, 128, 192, 193, 200, 256, 1000])
def test_the_cosine_of_a_damping_that_is_nearly_critical_is_enclosed_at_every_precision(bits):
    """Where 2 - ln(1/e) is lost in rounding Newton's rule has nothing to go by, and the ball was
    not a number.
    """
    restitution = beyond_critical(58)
    with precision(BITS):
        expected = angle_of(restitution, "zero_force").cos()
    with precision(bits):
        found = damping_cosine(-arb_of(restitution).log())
    with precision(BITS):
        assert found.overlaps(expected)
        assert found.rad() < arb(2) ** (8 - bits)
