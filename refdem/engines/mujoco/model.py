"""A scene as a compiled model of MuJoCo, by an MjSpec that holds nothing that is not in the scene.

MuJoCo moves bodies by joints. `Freedom` is the joint, or joints, of one body: fixed, on slides,
free, or about a hinge or ball. A body of the MjSpec (MjsBody) is called `mj_body` here.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.engines.mujoco import belts, contacts, options, solver
from refdem.engines.mujoco.ball import BallFreedom
from refdem.engines.mujoco.claims import differentiates, is_tuned
from refdem.engines.mujoco.joints import Fixed, Freedom, Slides
from refdem.engines.mujoco.passive import is_passive
from refdem.engines.mujoco.turning import Free, Hinge
from refdem.mechanics.quaternion import rotated
from refdem.scene import Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.slider import Slider
from refdem.scene.elements.spring import Spring

ZEROS = (0.0, 0.0, 0.0)


def compiled(request: Request) -> tuple[Any, list[Freedom]]:
    """The compiled model (MjModel), and the joints of each body in the scene's order."""
    import mujoco

    scene = request.problem.scene
    step = request.step or 0.0
    tuned = is_tuned(request.method)
    freedoms = freedoms_of(scene, request.method, step)
    spec = mujoco.MjSpec()
    options.set_compiler(mujoco, spec)
    options.set_options(mujoco, spec, scene, request.method, step)
    mj_bodies = _bodies(mujoco, spec, freedoms)
    contacts.add(mujoco, spec, scene, mj_bodies, step, tuned=tuned)
    belts.add(mujoco, spec, scene, mj_bodies, step)
    for number, spring in enumerate(scene.all(Spring)):
        if not _is_of_joints(scene, spring) and not is_passive(spring, scene):
            _add_tendon(spec, scene, freedoms, mj_bodies, spring, f"spring {number}")
    for rod in scene.all(Rod):
        spec.add_sensor(
            type=mujoco.mjtSensor.mjSENS_FORCE,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=f"rod on {rod.a}",
        )
    return spec.compile(), freedoms


def freedoms_of(scene: Scene, method: str, step: float) -> list[Freedom]:
    """The joints of each body.

    With derivatives, bodies on slides have all three axes, because the derivative by a component of
    the start that is 0 also moves the body.
    """
    tuned = is_tuned(method)
    freedoms = [_freedom(scene, number, step, tuned=tuned) for number in range(len(scene.bodies))]
    if not differentiates(method):
        return freedoms
    return [
        replace(freedom, dimension=3) if isinstance(freedom, Slides) else freedom
        for freedom in freedoms
    ]


def _bodies(mujoco: Any, spec: Any, freedoms: list[Freedom]) -> list[Any]:
    """Adds the bodies to the MjSpec, and returns them (MjsBody) in the scene's order.

    A body that hangs from another one is a child of it in MuJoCo's tree, so that it is added after
    it; the lineage of its joints, from the world down to its own, is longer by one.
    """
    mj_bodies: dict[int, Any] = {}
    from_the_world_down = sorted(
        range(len(freedoms)), key=lambda number: len(freedoms[number].lineage)
    )
    for number in from_the_world_down:
        freedom = freedoms[number]
        parent = spec.worldbody
        if len(freedom.lineage) > 1:
            parent = mj_bodies[freedoms.index(freedom.lineage[-2])]
        mj_bodies[number] = freedom.add_body(mujoco, parent)
        mj_bodies[number].name = f"body {number}"
    return [mj_bodies[number] for number in range(len(freedoms))]


def _turns(scene: Scene, number: int) -> bool:
    """True if the scene has rotation and the body moments of inertia: it needs a free joint."""
    return "rotation" in scene.features and bool(scene.bodies.inertia[number].any())


def _hinge(scene: Scene, rod: Rod) -> Hinge:
    """The hinge of the body at the lower end of a rod, with that of the rod from which it hangs."""
    above = None
    for other in scene.all(Rod):
        if other.a == rod.b:
            above = _hinge(scene, other)
    return Hinge(scene.bodies.single()[rod.a], rod, above)


def _freedom(scene: Scene, number: int, step: float, *, tuned: bool) -> Freedom:
    """The joints of body `number`: those of the element that holds it, or a free joint if it turns,
    or else slides along the axes of the scene.
    """
    body = scene.bodies.single()[number]
    if body.fixed:
        return Fixed(body)
    for rod in scene.all(Rod):
        if rod.a == number:
            return _hinge(scene, rod)
    for joint in scene.all(BallJoint):
        if joint.a == number:
            return BallFreedom(body, joint)
    if _turns(scene, number):
        return Free(body)
    stiffness, reference = _joint_spring(scene, number)
    friction, solver_parameters = _dry_friction(scene, number, step, tuned=tuned)
    damping = sum(
        dashpot.damping
        for dashpot in scene.all(Dashpot)
        if dashpot.a == number and not is_passive(dashpot, scene)
    )
    return Slides(
        body,
        _dimension(scene, number),
        stiffness,
        reference,
        friction,
        solver_parameters,
        damping,
    )


def _dimension(scene: Scene, number: int) -> int:
    """The number of axes along which a body may slide."""
    # A belt presses the body on a plane, so that it needs the axis across, too.
    is_on_belt = any(belt.a == number for belt in belts.belts(scene))
    if is_on_belt:
        return 3
    return next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)


def _joint_spring(
    scene: Scene, number: int
) -> tuple[tuple[float, float, float], tuple[float, ...]]:
    """The spring of the joints of a body: its stiffness in the first, second and third power of the
    coordinate, and the position (3,) [m] at which it is at rest; zeros without one.
    """
    for spring in scene.all(Spring):
        if spring.a == number and _is_of_joints(scene, spring):
            return (spring.stiffness, 0.0, 0.0), spring.anchor_b
    return ZEROS, ZEROS


def _dry_friction(
    scene: Scene, number: int, step: float, *, tuned: bool
) -> tuple[tuple[float, ...], dict[str, Any]]:
    """Dry friction (3,) [N] of a body along each axis, and the solver's parameters for it.

    The parameters are empty without friction and where MuJoCo's defaults are used.
    """
    sliders = [
        slider for slider in scene.all(Slider) if slider.a == number and not slider.belt_velocity
    ]
    friction = np.zeros(3)
    for slider in sliders:
        friction += np.abs(slider.axis) * slider.friction * slider.normal_force
    solver_parameters = {}
    if sliders and tuned:
        solver_parameters = solver.friction(step)
    return tuple(friction), solver_parameters


def _is_of_joints(scene: Scene, spring: Spring) -> bool:
    """True if the spring is the stiffness of the body's slide joints.

    A linear spring of no length to the world has the force -k (x - anchor), the same along every
    axis. The joints have one stiffness, so that only the first such spring of a body is theirs.
    """
    if any(spring.anchor_a) or _turns(scene, spring.a):
        return False
    candidates = [s for s in scene.all(Spring) if s.a == spring.a and _is_isotropic(s)]
    return bool(candidates) and candidates[0] is spring


def _is_isotropic(spring: Spring) -> bool:
    """True of a linear spring of no length between a body and the world."""
    is_linear = spring.exponent == 1 and not spring.cubic and not spring.quadratic
    return is_linear and spring.b < 0 and spring.length == 0


def _add_tendon(
    spec: Any,
    scene: Scene,
    freedoms: list[Freedom],
    mj_bodies: list[Any],
    spring: Spring,
    name: str,
) -> None:
    """Adds a spring as a spatial tendon between two sites, its ends, which `name` is a part of."""
    tendon = spec.add_tendon(name=name, springlength=(spring.length,) * 2)
    # F = linear s + cubic s^3 in the stretch s; the callback has other exponents.
    if spring.exponent == 1:
        linear = spring.stiffness
        cubic = spring.cubic
    else:
        linear = 0.0
        cubic = spring.stiffness + spring.cubic
    tendon.stiffness = (linear, 0.0, cubic)
    for end, anchor in ((spring.a, spring.anchor_a), (spring.b, spring.anchor_b)):
        position: Any = anchor
        mj_body = spec.worldbody
        if end >= 0:
            mj_body = mj_bodies[end]
            # A body on slides has axes of space: the anchor is turned as the body stands for good.
            if not freedoms[end].turns:
                position = rotated(scene.bodies.attitude[end], np.array(anchor, float))
        site = f"{name} at {end}"
        mj_body.add_site(name=site, pos=position)
        tendon.wrap_site(site)
