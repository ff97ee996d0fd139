"""A convex body whose corners press on a plane: certified truth, a bounce in closed form, energy,
momenta, refusals.
"""

import msgspec
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.balance import mechanical
from refdem.core.problem import Motion
from refdem.engines.reference import ENGINE
from refdem.mechanics import momentum
from refdem.scene import Body, Scene, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.uniform_gravity import UniformGravity

CASE = discovery.case("neglected-gyroscopic")
LONG = np.linspace(0.0, 0.6, 769)


def slope(**given):
    return CASE.at(member="slope", **given).scene


def test_motion_is_certified_through_a_contact(solved, largest_error):
    times = np.array([0.0, 0.0625, 0.129150390625])
    run = solved(slope(), times, "tumbling-body")
    assert run.channels["contact_force"][-1] > 1.0
    names = ("x", "y", "z", "omega_body.x", "omega_body.y", "omega.z", "R.xy", "R.zz")
    assert largest_error("neglected-gyroscopic", run, names, member="slope") < 2e-13


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"damping": "0"},
        {"friction": "0"},
        {"slope": "0", "friction": "1/8"},
        {"stiffness": "2e4"},
    ],
)
def test_energy_is_lost_by_the_work_that_is_told_and_by_no_other(solved, given):
    scene = slope(**given)
    run = solved(scene, LONG, "tumbling-body")
    work = run.channels["dissipated_work"]
    total = mechanical(scene, run) + work
    assert np.count_nonzero(run.channels["overlap"] > 0) > 10
    assert np.ptp(total) < 1e-13
    assert np.all(np.diff(work) > -1e-16)
    assert work[-1] > 1e-3


def test_without_friction_and_damping_nothing_is_lost(solved):
    run = solved(slope(friction="0", damping="0"), LONG, "tumbling-body")
    assert run.channels["overlap"].max() > 0
    assert run.channels["dissipated_work"][-1] == 0.0


def test_a_level_plane_without_friction_pushes_up_alone(solved):
    scene = slope(slope="0", friction="0", velocity="1/4,-1/8,0")
    run = solved(scene, LONG, "tumbling-body")
    assert np.abs(run.velocity[:, 0, :2] - run.velocity[0, 0, :2]).max() < 1e-14
    spin = momentum.spin(scene.bodies.inertia, run.attitude, run.omega)
    assert np.ptp(spin[:, 2]) < 1e-16
    assert np.ptp(spin[:, 0]) > 1e-4


def flat(**law):
    """A box of 1 kg that falls flat from 1/2 m under g = 8 m/s^2: it lands at 0.35 s with 2.8
    m/s.
    """
    body = Body(
        mass=1.0,
        inertia=(0.2, 0.3, 0.4),
        position=(0.0, 0.0, 0.49 + 0.125),
        shape=box(1.0, 0.5, 0.25),
    )
    given = {"law": "linear", "stiffness": 2500.0, "branch": "R", "cutoff": "zero_force"} | law
    return Scene.of([body], [Plane(), UniformGravity(g=(0.0, 0.0, -8.0)), Contact(**given)])


def test_four_corners_bounce_as_one_spring(solved):
    run = solved(flat(), np.linspace(0.0, 0.6, 97), "tumbling-body")
    begin = 0.35
    fall = 2.8
    rate = 100.0
    lasts = 2 / rate * (np.pi - np.arctan(fall * rate / 8.0))
    touched = [event.time for event in run.events if event.kind == "contact"]
    assert len(touched) == 4
    assert touched == pytest.approx([begin] * 4, abs=1e-14)
    since = run.t - begin - lasts
    flying = (since > 0) & (since < 0.2)
    expected = 0.125 + fall * since - 4.0 * since**2
    assert np.abs(run.position[:, 0, 2] - expected)[flying].max() < 1e-13
    assert not run.omega.any()


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ({"law": "rigid", "stiffness": 0.0}, "contact law rigid"),
        ({"friction": 0.5, "tangential_stiffness": 100.0}, "tangential spring"),
        ({"friction": 0.5, "branch": "R-d"}, "away from the corner"),
        ({"damping": 1.0, "cutoff": "zero_overlap"}, "corners that pull"),
    ],
)
def test_laws_that_it_does_not_have_are_refused(law, said):
    assert said in refused(flat(**law))


def test_what_friction_would_have_to_hold_is_refused():
    assert "comes to a stop" in refused(slope(friction="1/2", damping="2"))


def test_other_scenes_are_refused():
    scene = flat()
    (body,) = scene.bodies.single()
    many = msgspec.structs.replace(body.shape, vertices=body.shape.vertices * 5)
    points = [msgspec.structs.replace(body, shape=many)]
    assert "expected 1 to 32" in refused(Scene.of(points, scene.elements))
    assert "2 bodies; expected one" in refused(Scene.of(scene.bodies.single() * 2, scene.elements))


def refused(scene):
    return ENGINE.unsupported_motion(Motion(scene, LONG), ENGINE.method("tumbling-body"))


def test_time_that_runs_backwards_is_refused():
    # The kernel looked for events before the start and wrote beyond its buffers.
    scene = flat()
    times = np.linspace(0.0, -0.1, 5)
    reason = ENGINE.unsupported_motion(Motion(scene, times), ENGINE.method("tumbling-body"))
    assert "backwards" in str(reason)
