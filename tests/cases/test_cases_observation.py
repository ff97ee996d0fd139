"""What cases read off trajectories that are written down by hand, and starts in numbers."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.trajectory import Trajectory
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.slider import Slider

T = np.linspace(0.0, 3.0, 7)


def points(position: np.ndarray, velocity: np.ndarray, **channels: np.ndarray) -> Trajectory:
    """One point in the x-y plane, columns x and y."""
    pad = np.zeros((len(T), 1))
    place, rate = (
        np.concatenate([column, pad], axis=1)[:, None, :] for column in (position, velocity)
    )
    return Trajectory.of_points(T, place, rate, channels=channels)


def circle(rate: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """A steady turn from the downward vertical: theta = rate t."""
    angle = rate * T
    sine = np.sin(angle)
    cosine = np.cos(angle)
    return radius * np.stack([sine, -cosine], axis=1), radius * rate * np.stack(
        [cosine, sine], axis=1
    )


def test_a_steady_turn_shows_as_theta_equal_to_rate_times_t() -> None:
    seen = discovery.case("pendulum").at(length="2").observe(points(*circle(1.5, 2.0)))
    wrapped = np.remainder(1.5 * T + np.pi, 2 * np.pi) - np.pi
    np.testing.assert_allclose(seen["theta"], wrapped, atol=1e-14)
    np.testing.assert_allclose(seen["thetadot"], 1.5, rtol=1e-14)
    assert "rod_force" not in seen


def test_rod_force_is_read_from_its_channel_of_either_shape() -> None:
    force = np.arange(7.0)
    for channel in (force, force[:, None]):
        seen = discovery.case("pendulum").at().observe(points(*circle(1.0, 1.0), rod_force=channel))
        np.testing.assert_array_equal(seen["rod_force"], force)


def test_a_pendulum_starts_on_the_side_of_theta0_and_moves_with_thetadot0() -> None:
    bodies = discovery.case("pendulum").at(theta0="0.5", thetadot0="2", length="3").scene.bodies
    np.testing.assert_allclose(
        bodies.position[0], [3 * 0.479425538604203, -3 * 0.8775825618903728, 0.0], rtol=1e-15
    )
    np.testing.assert_allclose(
        bodies.velocity[0], [6 * 0.8775825618903728, 6 * 0.479425538604203, 0.0], rtol=1e-15
    )


def test_omega_in_body_axes_is_seen_through_a_quarter_turn_about_x() -> None:
    """The body's y axis points along space z: omega = (0, 0, 2) in space is (0, 2, 0) in the
    body.
    """
    half = np.sqrt(0.5)
    attitude = np.tile([-half, -half, 0.0, 0.0], (7, 1, 1))
    zero = np.zeros((7, 1, 3))
    omega = np.tile([0.0, 0.0, 2.0], (7, 1, 1))
    trajectory = Trajectory(t=T, position=zero, velocity=zero, attitude=attitude, omega=omega)
    seen = discovery.case("free-rigid-body").at().observe(trajectory)
    np.testing.assert_allclose(
        [seen[f"omega_body.{a}"][0] for a in "xyz"], [0.0, 2.0, 0.0], atol=1e-15
    )
    np.testing.assert_allclose(
        [seen[f"attitude.{a}"][0] for a in "wxyz"], [half, half, 0.0, 0.0], atol=1e-15
    )
    np.testing.assert_allclose(
        [seen["R.zy"][0], seen["R.yz"][0], seen["R.xx"][0]], [1.0, -1.0, 1.0], atol=1e-15
    )


def test_the_offset_is_a_part_of_the_spin_added_along_its_direction() -> None:
    instance = discovery.case("intermediate-axis").at(
        omega_body="0,-4,0", offset="1/1024", direction="3"
    )
    np.testing.assert_array_equal(instance.scene.bodies.omega[0], [0.0, -4.0, 4.0 / 1024])
    slanted = discovery.case("intermediate-axis").at(
        omega_body="0,3,4", offset="0.5", direction="1"
    )
    np.testing.assert_allclose(slanted.scene.bodies.omega[0], [2.5, 3.0, 4.0], rtol=1e-15)


def test_kepler_starts_at_periapsis_with_the_speed_of_vis_viva() -> None:
    bodies = (
        discovery.case("two-body-orbit").at(gm="3", semi_major="2", eccentricity="0.9").scene.bodies
    )
    distance = bodies.position[0, 0]
    speed = bodies.velocity[0, 1]
    assert distance == pytest.approx(0.2, rel=1e-15)
    assert speed**2 == pytest.approx(3 * (2 / distance - 1 / 2), rel=1e-14)
    assert not bodies.position[0, 1:].any()
    assert not bodies.velocity[0, [0, 2]].any()


def test_an_orbit_lasts_three_revolutions_by_default() -> None:
    assert discovery.case("two-body-orbit").at(stiffness="4").scales.duration == pytest.approx(
        3 * np.pi, rel=1e-15
    )


def test_the_coulomb_oscillator_rubs_with_exactly_the_friction_force() -> None:
    (slider,) = discovery.case("coulomb-oscillator").at(friction_force="0.3").scene.all(Slider)
    assert slider.friction * slider.normal_force == 0.3
    assert (
        "friction" not in discovery.case("coulomb-oscillator").at(friction_force="0").scene.features
    )


def test_gravity_is_in_the_scene_only_where_there_is_some() -> None:
    case = discovery.case("harmonic-oscillator")
    assert "uniform_gravity" not in case.at().scene.features
    assert case.at(gravity="-2").scene.elements[1].g == (-2.0, 0.0, 0.0)


def test_unequal_spheres_touch_without_overlap_and_have_no_momentum() -> None:
    bodies = (
        discovery.case("two-spheres")
        .at(masses="1,3", radii="1/4,1/2", angle="1/2", closing_speed="2")
        .scene.bodies
    )
    gap = bodies.position[1] - bodies.position[0]
    np.testing.assert_array_equal(gap, [0.75, 0.0, 0.0])
    np.testing.assert_allclose(bodies.mass @ bodies.position, 0.0, atol=1e-16)
    np.testing.assert_allclose(bodies.mass @ bodies.velocity, 0.0, atol=1e-15)
    approach = bodies.velocity[0] - bodies.velocity[1]
    np.testing.assert_allclose(
        [np.linalg.norm(approach), np.arctan2(approach[1], approach[0])], [2.0, 0.5], rtol=1e-15
    )
    np.testing.assert_allclose(bodies.inertia[1], 0.4 * 3 * 0.25, rtol=1e-15)


@pytest.mark.parametrize(
    "given",
    [
        {"damping": "4"},
        {"damping": "8", "cutoff": "zero_force"},
        {"damping": "40", "cutoff": "zero_force"},
    ],
)
def test_a_contact_lasts_as_long_as_scales_say(given: dict[str, str]) -> None:
    """Against the motion by Taylor steps: after half the duration the overlap, or the force, is
    back at zero and was not before.
    """
    instance = discovery.case("two-spheres").at(**given)
    k = 128.0
    c = float(given["damping"])
    m = 0.5
    steps = 20000
    end = instance.scales.duration / 2
    d = 0.0
    v = 1.0
    h = end / 20000
    force = []
    for _ in range(steps):
        a = -(k * d + c * v) / m
        jerk = -(k * v + c * a) / m
        d = d + h * v + h * h * a / 2 + h**3 * jerk / 6
        v = v + h * a + h * h * jerk / 2
        force.append(k * d + c * v if "cutoff" in given else d)
    assert min(force[: steps - 10]) > 0
    assert abs(force[-1]) < 1e-3 * max(force)


@pytest.mark.parametrize("damping", ["0", "8", "15.84", "16", "40"])
@pytest.mark.parametrize("cutoff", ["zero_overlap", "zero_force"])
def test_the_shortest_time_of_a_contact_is_no_longer_than_that_of_its_fastest_mode(
    damping: str, cutoff: str
) -> None:
    """Near critical damping the contact lasts far longer than its fastest mode, and steps by pi/w
    would miss it.
    """
    scales = discovery.case("two-spheres").at(damping=damping, cutoff=cutoff).scales
    fastest = np.abs(np.roots([0.5, float(damping), 128.0])).max()
    assert 0.25 < scales.tau * fastest <= 1 + 1e-7
    assert scales.duration >= 2 * np.pi * scales.tau * (1 - 1e-12)


def test_resting_bodies_show_displacements_from_their_places() -> None:
    instance = discovery.case("newtons-first-law").at(member="stack")
    bodies = instance.scene.bodies
    position = np.stack([bodies.position] * 7)
    position[3, 1, 2] += 0.25
    zero = np.zeros((7, 2, 3))
    seen = instance.observe(
        Trajectory(
            t=T,
            position=position,
            velocity=zero,
            attitude=np.stack([bodies.attitude] * 7),
            omega=zero,
        )
    )
    assert seen["r2.z"].tolist() == [0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0]
    assert not any(values.any() for name, values in seen.items() if name != "r2.z")


def test_spheres_in_balance_feel_no_force_to_the_last_bit() -> None:
    scene = discovery.case("newtons-first-law").at(member="spheres").scene
    (contact,) = scene.all(Contact)
    (_, _, low), (_, _, high) = scene.bodies.position
    radius = scene.bodies.radius[0]
    weight = scene.bodies.mass[0] * 9.8125
    below = contact.stiffness * (radius - low)
    between = contact.stiffness * (2 * radius - (high - low))
    assert between - weight == 0.0
    assert below - between - weight == 0.0


def test_time_reversal_takes_what_keeps_energy_and_names_what_does_not() -> None:
    selection = discovery.case("time-reversal")
    admitted = {
        "pendulum": {},
        "two-body-orbit": {},
        "free-rigid-body": {},
        "two-spheres": {},
    }
    for name, given in admitted.items():
        assert selection.admits(discovery.case(name).at(**given)) is None, name
    lossy = {"coulomb-oscillator": ({}, "slider"), "two-spheres": ({"damping": "1"}, "contact")}
    for name, (given, word) in lossy.items():
        assert word in selection.admits(discovery.case(name).at(**given))
    assert selection.check == "reversal"
