"""The audit of defaults says what the installed MuJoCo comes with and what the adapter sets."""

from typing import Any

import msgspec
import mujoco
import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.problem import Motion, Request
from refdem.engines.mujoco.contacts import impedance_of, rubs
from refdem.engines.mujoco.model import compiled
from refdem.scene import Body, Scene, Sphere, box
from refdem.scene.elements.contact import Contact
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.plane import Plane
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

LINE = {setting.setting: setting for setting in discovery.engine("mujoco").audit}
STEP = 2.0**-6
FALL = UniformGravity(g=(0.5, -2.0, -9.0))
DOWN = UniformGravity(g=(0.0, 0.0, -9.0))
ALWAYS_OFF = {"LIMIT", "EQUALITY", "ACTUATION", "SENSOR", "WARMSTART", "AUTORESET"}
POINT = Body(mass=2.0, position=(0.5, 0.0, 0.0))
LINEAR = Contact(law="linear", stiffness=50.0, damping=3.0, friction=0.25, cutoff="zero_force")


def ball(x: float, mass: float = 2.0, speed: float = 0.0) -> Body:
    """A sphere that may turn."""
    return Body(
        mass=mass,
        inertia=(0.4 * mass,) * 3,
        position=(x, 0.0, 1.0),
        velocity=(0.0, speed, 0.0),
        shape=Sphere(radius=1.0),
    )


def cube() -> Body:
    """A cube that may turn, at rest on the ground."""
    shape = box(2.0, 2.0, 2.0)
    return Body(mass=2.0, inertia=(0.5, 0.5, 0.5), position=(0.0, 0.0, 1.0), shape=shape)


GROUND = Plane(normal=(0.0, 0.0, 1.0))
SCENES = {
    "spring": Scene.of([POINT], [Spring(a=0, stiffness=3.0)]),
    "dashpot": Scene.of([POINT], [Dashpot(a=0, damping=3.0)]),
    "drive": Scene.of([POINT], [Force(a=0, amplitude=3.0)]),
    "gravity": Scene.of([POINT], [FALL, FALL]),
    "slider": Scene.of([POINT], [Slider(a=0, friction=0.5, normal_force=3.0)]),
    "belt": Scene.of([POINT], [Slider(a=0, friction=0.5, normal_force=3.0, belt_velocity=-1.5)]),
    "rod": Scene.of([Body(mass=2.0, position=(0.0, -2.0, 0.0))], [Rod(a=0, length=2.0)]),
    "smooth cube": Scene.of([cube()], [GROUND, FALL, Contact(law="rigid")]),
    "rough cube": Scene.of([cube()], [GROUND, FALL, Contact(law="rigid", friction=0.25)]),
    "rough ball": Scene.of([ball(0.0)], [GROUND, FALL, Contact(law="rigid", friction=0.25)]),
    "linear pair": Scene.of(
        [ball(0.0), ball(1.5, 3.0)],
        [Contact(law="linear", stiffness=50.0, damping=3.0, cutoff="zero_force")],
    ),
    "linear pair that rubs": Scene.of([ball(0.0, speed=0.5), ball(1.5, 3.0)], [LINEAR]),
    "resting cube": Scene.of([cube()], [GROUND, DOWN, Contact(law="rigid", friction=0.25)]),
}
NEEDED = {
    "spring": {"SPRING"},
    "dashpot": {"DAMPER"},
    "drive": {"SPRING"},
    "gravity": {"GRAVITY"},
    "slider": {"CONSTRAINT", "FRICTIONLOSS"},
    "belt": {"CONSTRAINT", "CONTACT"},
    "rod": set(),
    "smooth cube": {"CONSTRAINT", "CONTACT", "GRAVITY"},
    "rough cube": {"CONSTRAINT", "CONTACT", "GRAVITY"},
    "rough ball": {"CONSTRAINT", "CONTACT", "GRAVITY"},
    "linear pair": {"CONSTRAINT", "CONTACT"},
    "linear pair that rubs": {"CONSTRAINT", "CONTACT"},
    "resting cube": {"CONSTRAINT", "CONTACT", "GRAVITY"},
}
"""The machinery of MuJoCo that a scene needs, of what may be switched off. A callback is called
only where springs or dampers are on.
"""


def model(name: str, method: str = "euler") -> Any:
    """The compiled MjModel of a scene."""
    problem = Motion(SCENES[name], STEP * np.arange(3))
    made, _ = compiled(Request(problem=problem, method=method, step=STEP))
    return made


def test_mujoco_comes_with_what_the_audit_says() -> None:
    option = mujoco.MjSpec().option
    assert option.gravity.tolist() == [0.0, 0.0, -9.81]
    assert (option.timestep, option.tolerance, option.iterations) == (0.002, 1e-8, 100)
    assert (option.ls_tolerance, option.noslip_iterations, option.impratio) == (0.01, 0, 1.0)
    assert LINE["timestep"].default == "0.002 s"
    assert LINE["line search tolerance"].default == "0.01"


@pytest.mark.parametrize("name", SCENES)
def test_what_a_scene_does_not_need_is_off(name: str) -> None:
    made = model(name)
    may_be_off = {"CONTACT", "CONSTRAINT", "FRICTIONLOSS", "SPRING", "DAMPER", "GRAVITY"}
    off = {
        flag
        for flag in (*ALWAYS_OFF, *may_be_off)
        if made.opt.disableflags & int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
    }
    assert off == ALWAYS_OFF | (may_be_off - NEEDED[name])
    assert made.opt.enableflags == int(mujoco.mjtEnableBit.mjENBL_DIAGEXACT)


@pytest.mark.parametrize("name", SCENES)
def test_the_solver_is_set_to_round_off(name: str) -> None:
    option = model(name).opt
    assert option.timestep == STEP
    assert (option.tolerance, option.noslip_tolerance, option.ls_tolerance) == (1e-15, 1e-15, 1e-6)
    assert (option.iterations, option.density, option.viscosity) == (100, 0.0, 0.0)
    assert option.solver == mujoco.mjtSolver.mjSOL_NEWTON
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    rubs = "rubs" in name or name in ("slider", "belt", "rough cube", "rough ball", "resting cube")
    assert option.noslip_iterations == (100 if rubs else 0)
    is_soft = name in ("rough ball", "linear pair that rubs")
    assert option.impratio == (2.0**-30 if is_soft else 1.0)


def test_gravity_is_the_sum_of_the_scenes_fields() -> None:
    assert model("gravity").opt.gravity.tolist() == [1.0, -4.0, -18.0]
    assert model("spring").opt.gravity.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("method", "integrator"), [("euler", "EULER"), ("rk4", "RK4"), ("implicitfast", "IMPLICITFAST")]
)
def test_the_integrator_is_that_of_the_method(method: str, integrator: str) -> None:
    wanted = int(getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}"))
    assert model("spring", method).opt.integrator == wanted


def test_as_shipped_the_solver_is_mujocos_own() -> None:
    option = model("rough cube", "euler-as-shipped").opt
    shipped = mujoco.MjSpec().option
    for name in ("tolerance", "iterations", "ls_tolerance", "noslip_iterations", "impratio"):
        assert getattr(option, name) == getattr(shipped, name)
    assert (option.disableflags, option.enableflags) == (0, 0)


def test_mass_and_inertia_are_those_of_the_scene() -> None:
    made = model("rough cube")
    body = made.body("body 0")
    assert (body.mass.tolist(), body.inertia.tolist()) == ([2.0], [0.5, 0.5, 0.5])


def test_a_point_on_a_rod_has_mass_and_inertia_of_a_point_about_its_hinge() -> None:
    """M a = m l and M a^2 + I = m l^2 with I = 1e-15 kg m^2."""
    body = model("rod").body("body 0")
    arm = -body.ipos[1]
    assert body.inertia.tolist() == [1e-15] * 3
    assert body.mass[0] * arm == pytest.approx(4.0, rel=1e-15)
    assert body.mass[0] * arm**2 + 1e-15 == pytest.approx(8.0, rel=1e-15)


def test_dry_friction_of_a_joint_is_as_hard_as_it_may_be() -> None:
    made = model("slider")
    assert made.dof_frictionloss.tolist() == [1.5]
    assert made.dof_solref[0].tolist() == [2 * STEP, 1.0]
    assert made.dof_solimp[0, :2].tolist() == [0.9999, 0.9999]


@pytest.mark.parametrize(("name", "friction"), [("smooth cube", 0.0), ("resting cube", 0.25)])
def test_rigid_contacts_that_do_not_slide_are_as_hard_as_they_may_be(
    name: str, friction: float
) -> None:
    made = model(name)
    assert (made.npair, made.ngeom) == (0, 2)
    assert made.geom_solref.tolist() == [[2 * STEP, 1.0]] * 2
    assert made.geom_solimp[:, :2].tolist() == [[0.9999] * 2] * 2
    assert made.geom_condim.tolist() == [3 if friction else 1] * 2
    assert made.geom_friction.tolist() == [[friction, 0.0, 0.0]] * 2
    check_margin(made.geom_margin)


def test_rigid_contacts_that_slide_are_as_the_audit_says() -> None:
    """-1/(4 h^2), -1/h; d = 2^-10; -d/h."""
    made = model("rough cube")
    assert made.pair_solref.tolist() == [[-1 / (4 * STEP**2), -1 / STEP]]
    assert made.pair_solimp[:, :2].tolist() == [[2.0**-10] * 2]
    assert made.pair_solreffriction[:, 1].tolist() == [-(2.0**-10) / STEP]
    assert made.pair_friction.tolist() == [[0.25, 0.25, 0.0, 0.0, 0.0]]
    assert made.pair_dim.tolist() == [3]
    check_margin(made.pair_margin)


def check_margin(margins: np.ndarray) -> None:
    """2^-50 of the size of the scene of a cube: its centre is 1 m and its corners sqrt(3) m away
    from that.
    """
    np.testing.assert_allclose(margins, 2.0**-50 * (1 + np.sqrt(3)), rtol=1e-14)


@pytest.mark.parametrize(
    ("g", "rests"),
    [
        ((0.0, 0.0, -9.0), True),
        ((0.0, 0.0, 9.0), True),
        ((1e-9, 0.0, -9.0), False),
        ((0.0, -1e-9, -9.0), False),
        ((9.0, 0.0, 0.0), False),
    ],
)
@pytest.mark.parametrize("moves", [(0, 0, 0), (0, 0, 1e-9), (1e-9, 0, 0)])
@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize("friction", [0.0, 0.25])
def test_what_moves_or_is_pulled_along_a_plane_may_rub(
    g: tuple[float, float, float],
    rests: bool,
    moves: tuple[float, float, float],
    turns: bool,
    friction: float,
) -> None:
    own = msgspec.structs.replace(cube(), velocity=moves, omega=(0.0, 1e-9 * turns, 0.0))
    law = Contact(law="rigid", friction=friction)
    scene = Scene.of([own], [GROUND, UniformGravity(g=g), law])
    expected = friction > 0 and (turns or any(moves) or not rests)
    assert rubs(scene, law) is expected
    assert impedance_of(scene, law) == (2.0**-10 if expected else 0.9999)


def test_what_a_spring_pulls_may_rub() -> None:
    law = Contact(law="rigid", friction=0.25)
    gravity = UniformGravity(g=(0.0, 0.0, -9.0))
    pull = Spring(a=0, stiffness=2.0, anchor_b=(3.0, 0.0, 1.0))
    assert not rubs(Scene.of([cube()], [GROUND, gravity, law]), law)
    assert rubs(Scene.of([cube()], [GROUND, gravity, pull, law]), law)


def test_a_linear_contact_is_in_direct_form_for_the_effective_mass() -> None:
    """-k/m_eff and -c/m_eff with 1/m_eff = 1/2 + 1/3."""
    effective = 1.2
    solref = [-50.0 / effective, -3.0 / effective]
    made = model("linear pair")
    np.testing.assert_allclose(made.geom_solref, [solref] * made.ngeom, rtol=1e-14)
    assert made.geom_solimp[:, :2].tolist() == [[0.5, 0.5]] * made.ngeom
    assert made.geom_condim.tolist() == [1] * made.ngeom
    made = model("linear pair that rubs")
    np.testing.assert_allclose(made.pair_solref, [solref], rtol=1e-14)
    assert made.pair_solimp[:, :2].tolist() == [[0.5, 0.5]]
    assert made.pair_solreffriction[:, 1].tolist() == [-0.5 / STEP]
    assert made.pair_friction.tolist() == [[0.25, 0.25, 0.0, 0.0, 0.0]]
    assert made.pair_dim.tolist() == [3]


def test_a_belt_is_a_plane_whose_surface_moves() -> None:
    made = model("belt")
    assert made.nv == 3
    assert made.pair_friction.tolist() == [[0.5, 0.5, 0.0, 0.0, 0.0]]
    assert made.pair_dim.tolist() == [3]
    assert made.pair_solref.tolist() == [[-1 / (4 * STEP**2), -1 / STEP]]
    assert made.pair_solreffriction[:, 1].tolist() == [-(2.0**-14) / STEP]
