"""The adapter itself: what it refuses and why, its native loop, its clock, its silence, and faults
planted in it.
"""

import subprocess
import sys

import mujoco
import numpy as np
import pytest

from refdem.core.problem import Motion, Request
from refdem.engines.mujoco import session
from refdem.engines.mujoco.model import compiled
from refdem.engines.mujoco.turning import Free
from refdem.errors import EngineError
from refdem.scene import Body, Scene, Sphere, box
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity
from refdem.smoke.battery import smoke

TIMES = np.arange(9) / 8
POINT = Body(mass=1.0, position=(1.0, 0.0, 0.0))
TUMBLING = Scene.of([Body(mass=2.0, inertia=(1.0, 2.0, 2.5), omega=(0.9, 1.1, 1.3))])


def ball(x, **more):
    return Body(
        mass=1.0, inertia=(0.1, 0.1, 0.1), position=(x, 0.0, 0.0), shape=Sphere(radius=0.5), **more
    )


SOFT = {"law": "linear", "stiffness": 100.0}
DOWN = UniformGravity(g=(0.0, 0.0, -9.8))
REFUSED = {
    "spring off the centre": (
        [POINT],
        [Spring(a=0, stiffness=1.0, exponent=2.0, anchor_a=(0.5, 0.0, 0.0))],
        "off the centre",
    ),
    "central field on a pendulum": (
        [POINT],
        [Rod(a=0, length=1.0), CentralField(gm=1.0)],
        "beside rotating joints",
    ),
    "no inertia about one axis": (
        [Body(mass=1.0, inertia=(0.0, 1.0, 1.0), omega=(0.0, 1.0, 0.0))],
        [],
        "zero inertia",
    ),
    "friction on a slant": (
        [POINT],
        [Slider(a=0, friction=1.0, normal_force=1.0, axis=(0.6, 0.8, 0.0))],
        "other axes than x, y or z",
    ),
    "friction on a spinning body": (
        list(TUMBLING.bodies.single()),
        [Slider(a=0, friction=1.0, normal_force=1.0)],
        "free joint",
    ),
    "friction between bodies": (
        [POINT, POINT],
        [Slider(a=0, b=1, friction=1.0, normal_force=1.0)],
        "dry friction between bodies",
    ),
    "rod in space": (
        [Body(mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 0.0, 1.0))],
        [Rod(a=0, length=1.0)],
        "out of a plane",
    ),
    "rod between bodies": (
        [POINT, Body(mass=1.0)],
        [Rod(a=0, b=1, length=1.0)],
        "soft constraints",
    ),
    "rod that does not fit": ([POINT], [Rod(a=0, length=2.0)], "off the rod"),
    "rod that is being stretched": (
        [Body(mass=1.0, position=(1.0, 0, 0), velocity=(1.0, 0, 0))],
        [Rod(a=0, length=1.0)],
        "off the rod",
    ),
    "spring on a pendulum": (
        [POINT],
        [Rod(a=0, length=1.0), Spring(a=0, stiffness=1.0)],
        "hangs on a rod",
    ),
    "tangential spring": (
        [ball(-0.5), ball(0.5)],
        [Contact(**SOFT, friction=0.5, tangential_stiffness=50.0)],
        "tangential",
    ),
    "friction at another lever": (
        [ball(-0.5), ball(0.5)],
        [Contact(**SOFT, friction=0.5, branch="R")],
        "lever arm R",
    ),
    "contact that pulls": ([ball(-0.5), ball(0.5)], [Contact(**SOFT, damping=1.0)], "attractive"),
    "soft pairs": ([ball(-1.0), ball(0.0), ball(1.0)], [Contact(**SOFT)], "more than one pair"),
    "soft pair in gravity": (
        [ball(-0.5), ball(0.5)],
        [Contact(**SOFT), DOWN],
        "beside other forces",
    ),
    "restitution": (
        [ball(0.0)],
        [Plane(point=(0.0, 0.0, -1.0)), Contact(law="rigid", restitution=0.5), DOWN],
        "restitution",
    ),
    "soft box": (
        [Body(mass=1.0, inertia=(1.0, 1.0, 1.0), shape=box(1.0, 1.0, 1.0))],
        [Plane(), Contact(**SOFT)],
        "polyhedra",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_mujoco_cannot_say_is_refused_with_a_reason(engine, name):
    bodies, elements, words = REFUSED[name]
    reason = engine.unsupported_motion(Motion(Scene.of(bodies, elements), TIMES), engine.methods[0])
    assert reason is not None
    assert words in reason


def test_backward_motion_is_refused(engine):
    assert "negative time steps" in engine.unsupported_motion(
        Motion(Scene.of([POINT]), -TIMES), engine.methods[0]
    )


def test_an_undamped_contact_does_not_pull_and_needs_no_cutoff(engine):
    assert (
        engine.unsupported_motion(
            Motion(Scene.of([ball(-0.5), ball(0.5)], [Contact(**SOFT)]), TIMES), engine.methods[0]
        )
        is None
    )


@pytest.mark.parametrize("method", ["rk4", "euler", "implicitfast"])
def test_the_native_loop_is_mj_step_to_the_last_bit(engine, method):
    import mujoco

    request = Request(problem=Motion(TUMBLING, TIMES), method=method, step=1 / 64)
    run, cost = engine.run(request)
    model, freedoms = compiled(request)
    data = session._started(mujoco, model, freedoms, request)
    mujoco.mj_step(model, data, 64)
    assert np.array_equal(run.position[-1, 0], data.qpos[:3])
    assert np.array_equal(run.attitude[-1, 0], data.qpos[3:])
    assert cost.steps == 64
    assert np.array_equal(run.t, TIMES)


def test_no_default_of_mujoco_acts_on_a_body_left_alone(played):
    run, _ = played(
        Scene.of([Body(mass=1.0, inertia=(1.0, 1.0, 1.0), omega=(0.0, 0.0, 1.0))]),
        duration=64.0,
        step=2.0**-4,
    )
    assert np.abs(run.position).max() == 0
    np.testing.assert_allclose(run.omega[-1, 0], [0.0, 0.0, 1.0], atol=1e-13)


def test_mass_and_inertia_reach_the_engine_unchanged(engine):
    inertia = (0.6, 1.7, 1.3)
    scene = Scene.of([Body(mass=3.3, inertia=inertia, omega=(1.0, 2.0, 3.0))])
    model, _ = compiled(Request(problem=Motion(scene, TIMES), method="rk4", step=1 / 8))
    assert model.body_mass[1] == 3.3
    assert tuple(model.body_inertia[1]) == inertia
    assert tuple(model.body_iquat[1]) == (1.0, 0.0, 0.0, 0.0)


def test_a_run_goes_on_from_its_end_as_if_it_had_not_stopped(engine):
    """Warm starts are off: position and velocity are the whole state, also with friction."""
    scene = Scene.of(
        [POINT], [Spring(a=0, stiffness=1.0), Slider(a=0, friction=0.15, normal_force=1.0)]
    )
    for method in ("rk4", "euler"):
        whole, _ = engine.run(
            Request(problem=Motion(scene, np.arange(17) / 2), method=method, step=1 / 64)
        )
        half, _ = engine.run(
            Request(problem=Motion(scene, np.arange(9) / 2), method=method, step=1 / 64)
        )
        rest, _ = engine.run(
            Request(
                problem=Motion(scene.with_state(**half.end()), 4 + np.arange(9) / 2),
                method=method,
                step=1 / 64,
            )
        )
        assert np.array_equal(rest.position[-1], whole.position[-1])


def test_a_diverging_run_is_an_engine_error_without_a_word_on_the_terminal(
    engine, tmp_path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    stiff = Scene.of([POINT], [Spring(a=0, stiffness=20.0)])
    with pytest.raises(EngineError, match="unstable"):
        engine.run(Request(problem=Motion(stiff, TIMES * 800), method="rk4", step=1.0))
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


def test_the_adapter_is_imported_without_mujoco():
    code = (
        "import sys; from refdem.core import discovery; discovery.engine('mujoco'); print('mujoco'"
        " in sys.modules)"
    )
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout
        == "False\n"
    )


def test_smoke_finds_nothing_wrong_with_the_adapter(engine):
    findings = smoke(engine)
    assert {f.outcome for f in findings} == {"pass", "unsupported"}
    unsaid = {finding.quantity for finding in findings if finding.outcome == "unsupported"}
    rigid = {"impact on a line", "impact in a plane", "impact in space", "bounce from a wall"}
    of_contacts = {
        "resting on a fixed sphere",
        "surrounded",
        "many",
        "gripping two walls",
        "in a corner",
    }
    periodic = {"across a periodic boundary", "in a small periodic box"}
    off_centre = {"dashpot off the centre in a plane", "dashpot between two bodies"}
    planar = {
        "friction along another axis",
        "dumbbell",
        "drag",
        "damped knock",
        "three spheres fall",
    }
    others = {"tumble backwards"} | planar | {f"{name} in space" for name in planar}
    assert unsaid == others | rigid | of_contacts | periodic | off_centre


def _wrong_axis(free, mujoco, world):
    said = world.add_body(
        mass=free.body.mass, inertia=np.roll(free.body.inertia, 1), explicitinertial=True
    )
    said.add_freejoint()
    return said


def _space_omega(free):
    return np.array([*free.body.position, *free.body.attitude]), np.array(
        [*free.body.velocity, *free.body.omega]
    )


def _frequency(free):
    q, v = kept_start(free)
    return q, v / np.array([1, 1, 1, *[2 * np.pi] * 3])


kept_start = Free.start
FAULTS = {
    "inertia about the wrong axes": (
        "add_body",
        _wrong_axis,
        "wobble about x: omega_body",
        "the moments of inertia are in the order",
    ),
    "omega taken as the body's": (
        "start",
        _space_omega,
        "tipped body: omega",
        "omega in space axes",
    ),
    "turns a second for radians": ("start", _frequency, "quarter turn: attitude", "angles (rad)"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_smoke_blames_the_adapter_for_a_planted_fault(engine, monkeypatch, name):
    method, wrong, quantity, words = FAULTS[name]
    monkeypatch.setattr(Free, method, wrong)
    failed = {f.quantity: f.sentence for f in smoke(engine) if f.outcome == "fail"}
    assert words in failed[quantity]


def test_the_default_step_is_that_of_the_installed_engine(engine):
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    assert model.opt.timestep == engine.default_step
