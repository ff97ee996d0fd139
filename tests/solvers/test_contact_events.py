"""Collisions to round-off: closed forms of head-on contact, certified truth of oblique contact."""

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.engines.reference import ENGINE
from refdem.scene import Body, Scene, Sphere
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

STATE = tuple(f"{kind}{i}.{axis}" for i in (1, 2) for kind in ("r", "v", "omega") for axis in "xyz")


def solved(**given: str) -> Trajectory:
    """The case two-spheres by extrapolation."""
    problem = discovery.case("two-spheres").at(**given).problem
    return ENGINE.run(Request(problem=problem, method="contact-events"))[0]


@pytest.mark.parametrize("cutoff", ["zero_overlap", "zero_force"])
@pytest.mark.parametrize("damping", [0.0, 1.0, 6.0, 10.0])
def test_duration_and_restitution_are_those_of_the_damped_sine(cutoff, damping):
    """t = pi/w or 2 arccos(b/w0)/w and exp(-b t), with b = c/(2 m_eff), w0^2 = k/m_eff; m_eff =
    1/2, k = 128 (Schwager 2007).
    """
    b = damping
    w0 = 16.0
    w = np.sqrt(w0 * w0 - b * b)
    if cutoff == "zero_overlap":
        duration = np.pi / w
    else:
        duration = 2 * np.arccos(b / w0) / w
    seen = solved(damping=str(damping), cutoff=cutoff)
    assert [event.kind for event in seen.events] == ["release"]
    assert seen.events[0].time == pytest.approx(duration, rel=2e-15)
    restitution = seen.velocity[-1, 1, 0] - seen.velocity[-1, 0, 0]
    assert restitution == pytest.approx(np.exp(-b * duration), rel=4e-15)


def test_overlap_and_force_are_those_of_the_damped_sine():
    """d = sin(w t) exp(-b t)/w and F = k d + c d' while it lasts, nothing afterwards."""
    seen = solved(damping="6")
    b = 6.0
    w = np.sqrt(16.0**2 - 36.0)
    t = np.minimum(seen.t, np.pi / w)
    overlap = np.sin(w * t) * np.exp(-b * t) / w
    force = 128.0 * overlap + 6.0 * np.exp(-b * t) * (np.cos(w * t) - b / w * np.sin(w * t))
    during = seen.t < np.pi / w
    assert np.abs(seen.channels["overlap"] - overlap).max() < 2e-15
    assert (
        np.abs(seen.channels["contact_force"] - np.where(during, force, 0.0))[seen.t != 0].max()
        < 2e-13
    )
    assert np.array_equal(seen.channels["contacts"], during.astype(float))


@pytest.mark.parametrize(
    "given",
    [
        {"damping": "1", "angle": "1", "friction": "0.1"},
        {"angle": "1", "friction": "0.1", "damping": "0", "branch": "R"},
        {
            "damping": "1",
            "angle": "1.2",
            "friction": "0.1",
            "cutoff": "zero_force",
            "spins": "0,0,2,0,0,-5",
            "masses": "1,3",
            "radii": "1/2,4/5",
        },
    ],
    ids=["damped", "elastic, arm R", "spinning, zero force"],
)
def test_gross_sliding_agrees_with_certified_truth(given, largest_error):
    assert largest_error("two-spheres", solved(**given), STATE, **given) < 3e-14


@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_friction_impulse_is_mu_times_the_normal_impulse_in_gross_sliding(stiffness):
    """Law-free but for the angle by which the normal turns meanwhile, v_t t/(R1 + R2), t = pi
    sqrt(m_eff/k).
    """
    seen = solved(angle="1", friction="0.05", damping="0", stiffness=str(stiffness))
    impulse = seen.velocity[-1, 0] - seen.velocity[0, 0]
    turned = np.sin(1.0) * np.pi * np.sqrt(0.5 / stiffness)
    assert impulse[1] / impulse[0] == pytest.approx(0.05, abs=turned)


def test_a_collision_turned_in_space_is_the_same_collision_turned():
    """Out of the plane too: axes permuted cyclically, the motion is permuted, to round-off."""
    given = {
        "damping": "1",
        "angle": "0.6",
        "friction": "0.3",
        "tangential_stiffness": "100",
        "spins": "1,3,2,4,-2,-5",
    }
    instance = discovery.case("two-spheres").at(**given)
    bodies = instance.scene.bodies
    cycled = {
        name: np.roll(getattr(bodies, name), 1, axis=1)
        for name in ("position", "velocity", "omega")
    }
    plain = Request(problem=instance.problem, method="contact-events")
    turned = ENGINE.run(plain.with_scene(instance.scene.with_state(**cycled)))[0]
    for name in cycled:
        assert (
            np.abs(
                np.roll(getattr(turned, name), -1, axis=2) - getattr(ENGINE.run(plain)[0], name)
            ).max()
            < 3e-14
        )


def test_it_is_the_cheapest_method_for_an_oblique_collision_and_refuses_what_cannot_touch():
    oblique = discovery.case("two-spheres").at(damping="1", angle="1", friction="0.3").problem
    assert ENGINE.best(oblique).name == "contact-events"
    assert ENGINE.unsupported_motion(
        discovery.case("harmonic-oscillator").at().problem, ENGINE.method("contact-events")
    )


@pytest.mark.parametrize("part", np.linspace(0.1, 0.9, 17))
def test_spheres_that_graze_within_a_step_meet_wherever_in_it_they_do(part):
    """Between samples a second apart they touch for 0.09 s, in the same way as between samples 1/64
    s apart.
    """
    spheres = [
        Body(
            mass=1.0,
            inertia=(0.1, 0.1, 0.1),
            position=(-part, 0.999, 0.0),
            velocity=(1.0, 0.0, 0.0),
            shape=Sphere(radius=0.5),
        ),
        Body(mass=2.0, inertia=(0.2, 0.2, 0.2), shape=Sphere(radius=0.5)),
    ]
    scene = Scene.of(spheres, [Contact(law="linear", stiffness=128.0, damping=0.25)])
    wide = ENGINE.run(Request(problem=Motion(scene, np.arange(3.0)), method="contact-events"))[0]
    fine = ENGINE.run(Request(problem=Motion(scene, np.arange(129) / 64), method="contact-events"))[
        0
    ]
    assert [event.kind for event in wide.events] == ["contact", "release"]
    assert [event.time for event in wide.events] == pytest.approx(
        [event.time for event in fine.events], abs=1e-13
    )
    assert np.abs(wide.velocity[-1] - fine.velocity[-1]).max() < 1e-14
    assert np.abs(wide.velocity[-1] - wide.velocity[0]).max() > 1e-4


@pytest.mark.parametrize(
    ("method", "allowed"), [("contact-events", 2e-15), ("rk4", 2e-15), ("velocity-verlet", 2e-15)]
)
def test_a_sliding_sphere_starts_to_roll_when_its_slip_ends_and_rolls_for_ever(method, allowed):
    """t = 2 v0/(7 mu g), then v = omega R = 5/7 v0: mu = 1/4, g = 8, v0 = 7/2, R = 1/2; pressed in
    by exactly m g/k.
    """
    ball = Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        position=(0.0, 0.0, 0.5 - 2.0**-7),
        velocity=(3.5, 0.0, 0.0),
        shape=Sphere(radius=0.5),
    )
    law = Contact(law="linear", stiffness=1024.0, friction=0.25, branch="R")
    scene = Scene.of([ball], [Plane(), UniformGravity(g=(0.0, 0.0, -8.0)), law])
    times = np.arange(33) * 2.0**-4
    seen = ENGINE.run(
        Request(
            problem=Motion(scene, times),
            method=method,
            step=None if method == "contact-events" else 2.0**-7,
        )
    )[0]
    onset = 2 * 3.5 / (7 * 0.25 * 8.0)
    speed = np.where(times < onset, 3.5 - 2.0 * times, 2.5)
    place = np.where(
        times < onset, 3.5 * times - times**2, 3.5 * onset - onset**2 + 2.5 * (times - onset)
    )
    assert np.abs(seen.velocity[:, 0, 0] - speed).max() < allowed
    assert np.abs(seen.position[:, 0, 0] - place).max() < 2 * allowed
    assert (
        np.abs(seen.omega[:, 0, 1] - np.where(times < onset, 10.0 * times, 5.0)).max() < 2 * allowed
    )
    assert np.ptp(seen.position[:, 0, 2]) == 0.0
    lost = 0.5 * (3.5**2 - 2.5**2) - 0.5 * 0.1 * 5.0**2
    assert seen.channels["dissipated_work"][-1] == pytest.approx(
        lost, rel=1e-14 if method != "velocity-verlet" else 1e-3
    )


@pytest.mark.parametrize("method", ["contact-events", "rk4", "velocity-verlet"])
def test_a_ball_on_a_steep_slope_slips_from_rest_the_way_it_is_pulled(method):
    """v = (g sin a - mu g cos a) t and omega = mu m g cos a R/J t: without a tangential spring, g =
    (0, 4, -8), mu = 1/8.
    """
    ball = Body(
        mass=1.0, inertia=(0.1,) * 3, position=(0.0, 0.0, 0.5 - 2.0**-7), shape=Sphere(radius=0.5)
    )
    law = Contact(law="linear", stiffness=1024.0, friction=0.125, branch="R")
    scene = Scene.of([ball], [Plane(), UniformGravity(g=(0.0, 4.0, -8.0)), law])
    times = np.arange(9) * 2.0**-3
    seen = ENGINE.run(
        Request(
            problem=Motion(scene, times),
            method=method,
            step=None if method == "contact-events" else 2.0**-7,
        )
    )[0]
    np.testing.assert_allclose(seen.velocity[:, 0], times[:, None] * [0.0, 3.0, 0.0], atol=1e-13)
    np.testing.assert_allclose(seen.omega[:, 0], times[:, None] * [-5.0, 0.0, 0.0], atol=1e-13)


def test_a_ball_on_a_slope_held_by_its_tangential_spring_swings_about_the_static_stretch():
    """No slip: friction alone spins the ball; for a large limit s'' = g sin a - (1/m + R^2/J) k_t
    s, from s = 0.
    """
    ball = Body(
        mass=1.0, inertia=(0.1,) * 3, position=(0.0, 0.0, 0.5 - 2.0**-7), shape=Sphere(radius=0.5)
    )
    law = Contact(
        law="linear", stiffness=1024.0, tangential_stiffness=64.0, friction=10.0, branch="R"
    )
    scene = Scene.of([ball], [Plane(), UniformGravity(g=(1.0, 0.0, -8.0)), law])
    times = np.arange(65) * 2.0**-5
    seen = ENGINE.run(Request(problem=Motion(scene, times), method="contact-events"))[0]
    ease = 1.0 + 0.25 / 0.1
    rate = np.sqrt(64.0 * ease)
    slip = np.sin(rate * times) / rate
    surface = seen.velocity[:, 0, 0] - 0.5 * seen.omega[:, 0, 1]
    assert np.abs(surface - slip).max() < 1e-14


def test_a_slip_that_friction_stops_at_once_leaves_the_normal_velocity_alone():
    """Friction 100 times the normal force: its direction, where the slip is all rounding, must stay
    in the plane of contact.
    """
    given = {
        "masses": "0.516849,2.55599",
        "stiffness": "133595000",
        "damping": "15005.6",
        "closing_speed": "74.2905",
    }
    given |= {"friction": "100", "angle": "-0.54975"}
    instance = discovery.case("two-spheres").at(**given)
    seen = ENGINE.run(Request(problem=instance.problem, method="contact-events"))[0]
    assert largest_gain(instance.scene, seen) < 4e-13


def largest_gain(scene, seen):
    """Largest change of energy plus lost work, in units of the energy at the start; from the
    definitions of both.
    """
    mass = scene.bodies.mass
    inertia = scene.bodies.inertia[:, 0]
    kinetic = 0.5 * ((seen.velocity**2).sum(axis=2) @ mass + (seen.omega**2).sum(axis=2) @ inertia)
    overlap = np.maximum(
        0.0,
        scene.bodies.radius.sum()
        - np.linalg.norm(seen.position[:, 0] - seen.position[:, 1], axis=1),
    )
    whole = (
        kinetic
        + 0.5 * scene.all(Contact)[0].stiffness * overlap**2
        + seen.channels["dissipated_work"]
    )
    return np.abs(whole - whole[0]).max() / whole[0]


STICKING = [
    {
        "damping": "1",
        "angle": "0.008727",
        "friction": "1/2",
        "tangential_stiffness": "256/7",
        "spins": "0,0,1,0,0,-2",
        "branch": "R",
    },
    {
        "damping": "1",
        "angle": "1/2",
        "friction": "1/4",
        "tangential_stiffness": "96",
        "masses": "1,3",
        "radii": "1/2,3/4",
        "branch": "R-d",
    },
    {"angle": "1.48", "friction": "2", "tangential_stiffness": "256/7", "damping": "0"},
    {
        "angle": "-1/2",
        "friction": "1/4",
        "damping": "4",
        "cutoff": "zero_force",
        "branch": "R-d",
        "masses": "1,1000000",
    },
]


@pytest.mark.parametrize(
    "given",
    STICKING,
    ids=["half a degree", "unequal", "85 degrees", "no spring, masses a million apart"],
)
def test_stick_and_slip_agree_with_certified_truth(given, largest_error):
    assert largest_error("two-spheres", solved(**given), STATE, **given) < 1e-13


def test_spheres_that_part_within_rounding_do_not_stick_and_slip_instead():
    """At the last bit of overlap the limit of friction is rounding: stick and slip took turns until
    a step went by without release.
    """
    from refdem.core import symmetry

    given = {
        "masses": "1,3",
        "radii": "1/2,3/4",
        "damping": "0",
        "tangential_stiffness": "96",
        "friction": "1/4",
        "angle": "1/2",
    }
    instance = discovery.case("two-spheres").at(**given, spins="0,0,1,0,0,1/2")
    reference = discovery.engine("reference")
    view, shown = symmetry.image(instance, "relabelled")
    plain, other = (
        reference.run(Request(problem=motion, method="contact-events"))[0]
        for motion in (instance.problem, shown)
    )
    assert np.abs(view.undone(other).omega - plain.omega).max() < 1e-13


@pytest.mark.parametrize("stiffness", ["1/2", "1/64", "3"])
def test_a_tangential_spring_of_any_stiffness_slips_the_way_it_pulls(stiffness):
    """Below 1 N/m as above: a spring is a spring however soft it is."""
    given = {
        "damping": "1",
        "friction": "1/256",
        "angle": "1/2",
        "tangential_stiffness": stiffness,
        "samples": "8",
    }
    problem = discovery.case("two-spheres").at(**given).problem
    seen, series = (
        ENGINE.run(Request(problem=problem, method=name))[0]
        for name in ("contact-events", "oblique-contact")
    )
    assert np.abs(seen.velocity - series.velocity).max() < 2e-13
    assert np.abs(seen.omega - series.omega).max() < 2e-13


@pytest.mark.parametrize("friction", ["1e6", "1e12"])
@pytest.mark.parametrize(
    "more", [{"damping": "1"}, {}, {"damping": "1", "cutoff": "zero_force"}], ids=str
)
def test_friction_without_measure_ends_with_its_force(friction, more):
    """The last slip lasts 1e-8 s and less, and a step that goes on beyond it overflows: what is no
    number has not settled.
    """
    problem = (
        discovery.case("two-spheres")
        .at(friction=friction, angle="1/2", tangential_stiffness="64", samples="8", **more)
        .problem
    )
    seen, series = (
        ENGINE.run(Request(problem=problem, method=name))[0]
        for name in ("contact-events", "oblique-contact")
    )
    assert np.abs(seen.velocity - series.velocity).max() < 2e-14
    assert np.abs(seen.omega - series.omega).max() < 2e-14


@pytest.mark.parametrize("far", [1e4, 1e8])
def test_far_from_the_origin_the_motion_is_the_same_from_its_own_middle(far):
    problem = (
        discovery.case("two-spheres")
        .at(damping="1", friction="1/4", angle="1/2", tangential_stiffness="64", samples="8")
        .problem
    )
    away = far * np.array([1.0, -0.375, 0.25])
    moved = problem.scene.with_state(position=problem.scene.bodies.position + away)
    near, seen = (
        ENGINE.run(Request(problem=Motion(scene, problem.times), method="contact-events"))[0]
        for scene in (problem.scene, moved)
    )
    assert np.array_equal(seen.position[0], moved.bodies.position)
    # sharp: the sum with the shift is rounded to half a unit far away, whatever the near motion is
    assert np.abs(seen.position - away - near.position).max() <= np.spacing(far)
    assert (
        np.abs(seen.velocity - near.velocity).max() < 1e-15
    )  # 7e-12 at 1e4 where places count from the origin, and far more steps


def test_planes_and_springs_move_with_the_middle():
    ball = Body(
        mass=1.0,
        inertia=(0.1,) * 3,
        position=(0.0, 0.0, 0.5),
        velocity=(1.0, 0.0, -1.0),
        shape=Sphere(radius=0.5),
    )
    law = Contact(
        law="linear", stiffness=1024.0, friction=0.25, tangential_stiffness=256.0, branch="R"
    )

    def seen(x: float) -> Trajectory:
        elements = [
            Plane(point=(x, 0.0, 0.0)),
            Spring(a=0, b=-1, stiffness=16.0, anchor_b=(x, 0.0, 0.75)),
            law,
        ]
        scene = Scene.of([ball], elements)
        scene = scene.with_state(position=scene.bodies.position + np.array([x, 0.0, 0.0]))
        return ENGINE.run(
            Request(problem=Motion(scene, np.arange(33) * 2.0**-5), method="contact-events")
        )[0]

    assert np.abs(seen(2.0**20).velocity - seen(0.0).velocity).max() < 1e-14


SLIPS_AGAIN = {
    "damping": "1",
    "masses": "1.796875,2.9375",
    "radii": "1.171875,0.5",
    "stiffness": "77.75",
    "closing_speed": "0.953125",
    "friction": "0.859375",
    "tangential_stiffness": "230.359375",
    "angle": "-0.109375",
    "spins": "0,0,1.484375,0,0,1.859375",
    "branch": "R-d",
}
SLIPS_BETWEEN = {
    "damping": "1",
    "masses": "0.703125,2.96875",
    "radii": "1,0.875",
    "stiffness": "118.046875",
    "closing_speed": "0.5625",
    "friction": "1.46875",
    "tangential_stiffness": "225.203125",
    "angle": "-0.734375",
    "spins": "0,0,0.625,0,0,-1.28125",
    "branch": "R-d",
}
TILTS = {
    "damping": "1",
    "masses": "1.21875,2.7421875",
    "radii": "1.265625,0.5625",
    "stiffness": "192",
    "closing_speed": "0.9375",
    "friction": "1",
    "tangential_stiffness": "103",
    "angle": "0.25",
    "spins": "0,0,1,0,0,0.75",
}


def drawn(seed: int) -> dict[str, str]:
    """A collision with friction, spins and any lever and end of the force, parameters of 64ths."""
    rng = np.random.default_rng([seed, 2101])

    def between(low: float, high: float) -> str:
        return str(float(np.round(64 * rng.uniform(low, high)) / 64))

    def pair(low: float, high: float) -> str:
        return f"{between(low, high)},{between(low, high)}"

    given = {
        "masses": pair(0.5, 3),
        "radii": pair(0.4, 1.5),
        "stiffness": between(50, 300),
        "damping": between(-2, 2).replace("-", ""),
    }
    given |= {
        "tangential_stiffness": between(40, 250),
        "friction": between(0.1, 1.5),
        "angle": between(-1, 1),
    }
    given |= {
        "spins": f"0,0,{between(-2, 2)},0,0,{between(-2, 2)}",
        "branch": str(rng.choice(["R", "R-d", "R-d/2"])),
    }
    return given | {
        "closing_speed": between(0.5, 2),
        "cutoff": str(rng.choice(["zero_overlap", "zero_force"])),
    }


@pytest.mark.parametrize("given", [SLIPS_AGAIN, SLIPS_BETWEEN, TILTS, *map(drawn, range(40))])
def test_it_agrees_with_the_taylor_series_of_the_plane_contact(given):
    """Stick that ends in its own first step, slip for a part of a step, a spring that trial steps
    tilt: none is left out.
    """
    instance = discovery.case("two-spheres").at(**given, samples="16")
    one, other = (
        ENGINE.run(Request(problem=instance.problem, method=name))[0]
        for name in ("contact-events", "oblique-contact")
    )
    scales = instance.scales
    for ours, theirs, unit in (
        (one.position, other.position, scales.length),
        (one.velocity, other.velocity, scales.speed),
    ):
        assert np.abs(ours - theirs).max() < 1e-13 * unit


@pytest.mark.parametrize("part", np.arange(3, 30) / 32)
def test_a_touch_that_lasts_a_twentieth_of_a_step_is_found_wherever_in_the_step_it_falls(part):
    """Sphere 2 flies past sphere 1, deepest at 1 + `part` steps; the impulse is the same for all.

    On a straight line the overlap is 1 - sqrt((1 - depth)^2 + (v t)^2), and the way is bent by
    less than 1e-5 of that.
    """
    speed = 4.0
    depth = 0.004
    stiffness = 0.012
    own = {"mass": 1.0, "inertia": (0.1, 0.1, 0.1), "shape": Sphere(radius=0.5)}
    start = (-speed * (1 + part), 1 - depth, 0.0)
    bodies = [Body(**own), Body(**own, position=start, velocity=(speed, 0.0, 0.0))]
    scene = Scene.of(bodies, [Contact(law="linear", stiffness=stiffness)])
    motion = Motion(scene, np.arange(4.0))
    run, cost = ENGINE.run(Request(problem=motion, method="contact-events"))
    assert cost.steps == 3  # one step from sample to sample
    half = np.sqrt(1 - (1 - depth) ** 2) / speed
    t = np.linspace(-half, half, 4097)
    distance = np.hypot(1 - depth, speed * t)
    impulse = np.trapezoid(stiffness * (1 - distance) * (1 - depth) / distance, t)
    assert 2 * half < 0.05
    assert run.velocity[-1, 1, 1] == pytest.approx(impulse, rel=1e-4)
