"""A scene in MuJoCo's words: an MjSpec with nothing in it that the scene does not say, compiled."""

from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.engines.mujoco import belts, contacts, options, solver
from refdem.engines.mujoco.ball import BallFreedom
from refdem.engines.mujoco.claims import is_tuned
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

STILL = (0.0, 0.0, 0.0)


def compiled(request: Request) -> tuple[Any, list[Freedom]]:
    """The compiled model and, body by body, how it moves."""
    import mujoco

    scene = request.problem.scene
    step = request.step or 0.0
    tuned = is_tuned(request.method)
    spec = mujoco.MjSpec()
    options.set_compiler(mujoco, spec)
    options.set_options(mujoco, spec, scene, request.method, step)
    freedoms = [_freedom(scene, number, step, tuned=tuned) for number in range(len(scene.bodies))]
    said = _said(mujoco, spec, freedoms)
    contacts.add(mujoco, spec, scene, said, step, tuned=tuned)
    belts.add(mujoco, spec, scene, said, step)
    for number, spring in enumerate(scene.all(Spring)):
        if not _is_of_joints(scene, spring) and not is_passive(spring, scene):
            _add_tendon(spec, scene, freedoms, said, spring, f"spring {number}")
    for rod in scene.all(Rod):
        spec.add_sensor(
            type=mujoco.mjtSensor.mjSENS_FORCE,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=f"rod on {rod.a}",
        )
    return spec.compile(), freedoms


def _said(mujoco: Any, spec: Any, freedoms: list[Freedom]) -> list[Any]:
    """The bodies of MuJoCo in the scene's order, each said after that from which it hangs."""
    said: dict[int, Any] = {}
    for number, freedom in sorted(enumerate(freedoms), key=lambda pair: len(pair[1].lineage)):
        above = next(
            (said[i] for i, other in enumerate(freedoms) if freedom.lineage[-2:-1] == (other,)),
            spec.worldbody,
        )
        said[number] = freedom.say(mujoco, above)
        said[number].name = f"body {number}"
    return [said[number] for number in range(len(freedoms))]


def _turns(scene: Scene, number: int) -> bool:
    """True if the body needs a free joint."""
    return "rotation" in scene.features and bool(scene.bodies.inertia[number].any())


def _hinge(scene: Scene, rod: Rod) -> Hinge:
    """The lower end of a rod, and what it hangs from."""
    above = next((_hinge(scene, other) for other in scene.all(Rod) if other.a == rod.b), None)
    return Hinge(scene.bodies.single()[rod.a], rod, above)


def _freedom(scene: Scene, number: int, step: float, *, tuned: bool) -> Freedom:
    """The degrees of freedom of body `number` in the model."""
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
    rubbed = any(belt.a == number for belt in belts.belts(scene))
    dimension = 3
    if not rubbed:
        dimension = next(n for n in (1, 2, 3) if f"dimension:{n}" in scene.features)
    springs = [
        spring
        for spring in scene.all(Spring)
        if spring.a == number and _is_of_joints(scene, spring)
    ]
    stiffness = STILL
    reference = STILL
    if springs:
        stiffness = (springs[0].stiffness, 0.0, 0.0)
        reference = springs[0].anchor_b
    friction, words = _dry_friction(scene, number, step, tuned=tuned)
    damping = sum(
        dashpot.damping
        for dashpot in scene.all(Dashpot)
        if dashpot.a == number and not is_passive(dashpot, scene)
    )
    return Slides(
        body,
        dimension,
        stiffness,
        reference,
        friction,
        words,
        damping,
    )


def _dry_friction(
    scene: Scene, number: int, step: float, *, tuned: bool
) -> tuple[tuple[float, ...], dict[str, Any]]:
    """Dry friction (3,) [N] of a body along each axis, and the solver's parameters for it, if there
    is any and MuJoCo's own are not meant.
    """
    sliders = [
        slider for slider in scene.all(Slider) if slider.a == number and not slider.belt_velocity
    ]
    friction = np.zeros(3)
    for slider in sliders:
        friction += np.abs(slider.axis) * slider.friction * slider.normal_force
    words = {}
    if sliders and tuned:
        words = solver.friction(step)
    return tuple(friction), words


def _is_of_joints(scene: Scene, spring: Spring) -> bool:
    """A linear spring of no length to the world is the same along every axis: the joints' own
    stiffness. One a body.
    """
    plain = [
        s
        for s in scene.all(Spring)
        if s.a == spring.a
        and s.b < 0
        and s.length == 0
        and s.exponent == 1
        and not s.cubic
        and not s.quadratic
    ]
    return (
        spring in plain
        and not any(spring.anchor_a)
        and not _turns(scene, spring.a)
        and plain[0] is spring
    )


def _add_tendon(
    spec: Any, scene: Scene, freedoms: list[Freedom], said: list[Any], spring: Spring, name: str
) -> None:
    """A spring as a spatial tendon between two sites."""
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
        place: Any = anchor
        if end >= 0 and not freedoms[end].turns:
            place = rotated(scene.bodies.attitude[end], np.array(anchor, float))
        if end < 0:
            body = spec.worldbody
        else:
            body = said[end]
        site = f"{name} at {end}"
        body.add_site(name=site, pos=place)
        tendon.wrap_site(site)
