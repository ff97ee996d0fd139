"""Constraints beside the pendulum's rod: chains, tops on their tips, hooks that catch, strings over
wheels, and equilibria.
"""

from dataclasses import replace
from functools import partial
from typing import Any

import msgspec
import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import of_bodies, of_elements, of_parts, of_results, scaled, within
from refdem.faults.fault import Fault
from refdem.faults.parts import HoldingParts
from refdem.mechanics import vectors as vec
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.elements.ball_joint import BallJoint
from refdem.scene.elements.rod import Rod
from refdem.scene.elements.uniform_gravity import UniformGravity

top = partial(Fault, kind="top", on=("top",))
chain = partial(Fault, kind="chain", on=("chain",))
coupled = partial(Fault, kind="coupled", on=("coupled",))
hook = partial(Fault, kind="hook", on=("captured",))
string = partial(Fault, kind="string", on=("machine",))
equilibrium = partial(Fault, kind="equilibrium")
HAIR = 1 + 1e-10
"""Factor on a length: far above round-off, far below any error of a method."""
holding = partial(within, "holding")


def _spun_by_weight(sound: HoldingParts) -> dict[str, Any]:
    """The torque arm x F with 0.05 |F| arm added: a torque about the top's own axis."""

    def tip_torque(arm: Any, force: Any) -> Any:
        return vec.moved(sound.tip_torque(arm, force), 0.05 * vec.size(force), arm)

    return {"tip_torque": tip_torque}


def _half_steiner(request: Request) -> Request:
    """Moments about the joint with half of what the distance of the centre of mass adds."""
    scene = request.problem.scene
    (joint,) = scene.all(BallJoint)
    # Steiner's theorem: m s^2 about the two axes across the arm s.
    steiner = float(scene.bodies.mass[0]) * sum(x * x for x in joint.anchor_a)
    missing = np.array([steiner / 2, steiner / 2, 0.0])
    return of_bodies(inertia=lambda moments: moments - missing)(request)


def _omega_body(request: Request, run: Trajectory) -> Trajectory:
    """omega is written in body axes."""
    return replace(run, omega=rotated(conjugate(run.attitude), run.omega))


def _printed(vector: tuple[float, ...]) -> tuple[float, ...]:
    """The vector rounded to three decimals."""
    return tuple(round(x, 3) for x in vector)


def _last_rod(request: Request, factor: float) -> Request:
    """The last rod longer by a factor."""
    scene = request.problem.scene
    elements = list(scene.elements)
    rods = {number: element for number, element in enumerate(elements) if isinstance(element, Rod)}
    last = max(rods)
    elements[last] = msgspec.structs.replace(rods[last], length=factor * rods[last].length)
    return request.with_scene(Scene(scene.bodies, tuple(elements)))


def _braked(request: Request, run: Trajectory) -> Trajectory:
    """Once a body is caught its velocity is written 1 % too small."""
    # On the circle about the hook r . v = 0.
    is_caught = np.abs(np.einsum("tnk,tnk->tn", run.position, run.velocity)) < 1e-6
    factor = np.where(is_caught, 0.99, 1.0)
    return replace(run, velocity=factor[..., None] * run.velocity)


FAULTS = (
    top(
        name="top-falls-up",
        sentence="The torque of the weight has the wrong sign.",
        sees=("error", "theta"),
        inside=holding(of_parts(tip_torque=lambda arm, force: vec.cross(force, arm))),
    ),
    top(
        name="top-half-steiner",
        sentence=(
            "The moments of inertia contain half of the term m s^2 of the parallel axis theorem."
        ),
        sees=("error", "theta"),
        levels=4,
        before=_half_steiner,
    ),
    top(
        name="top-swirls",
        sentence="A torque of 1e-6 N m acts about the vertical.",
        sees=("top", "L_z"),
        inside=holding(of_results(tip_torque=lambda torque: vec.plus(torque, (0.0, 0.0, 1e-6)))),
    ),
    top(
        name="top-spun-by-its-weight",
        method="suzuki",
        sentence=(
            "A torque of 0.05 times the weight times the lever arm acts about the axis of the top."
        ),
        sees=("top", "L_3"),
        levels=5,
        inside=holding(_spun_by_weight),
    ),
    top(
        name="top-tip-off",
        sentence="The tip is displaced by one part in 1e10.",
        sees=("top", "joint"),
        before=of_elements(BallJoint, anchor_a=scaled(HAIR)),
    ),
    top(
        name="top-omega-in-body-axes",
        sentence="omega is written in body axes.",
        sees=("top", "joint velocity"),
        after=_omega_body,
    ),
    chain(
        name="chain-end-too-long",
        sentence="The last rod is too long by one part in 1e10.",
        sees=("constraint", "length"),
        before=lambda request: _last_rod(request, HAIR),
    ),
    chain(
        name="chain-without-reaction",
        sentence="The lower rod exerts no force on the upper bob.",
        sees=("error", "theta1"),
        levels=4,
        inside=of_parts(reaction=lambda force: vec.ZERO),
    ),
    chain(
        name="chain-three-decimals",
        sentence="Positions and velocities are rounded to three decimals in every step.",
        on=("chaotic-chain",),
        sees=("lyapunov", "class"),
        inside=of_results(drifted=_printed, kicked=_printed),
    ),
    chain(
        name="chain-reaction-twice",
        sentence="The lower rod exerts its force on the upper bob twice.",
        sees=("error", "theta1"),
        levels=4,
        inside=of_parts(reaction=lambda force: vec.times(-2.0, force)),
    ),
    coupled(
        name="coupled-without-reaction",
        sentence="The spring between two bobs acts on one of them only.",
        sees=("error", "theta2"),
        levels=4,
        inside=of_parts(reaction=lambda force: vec.ZERO),
    ),
    coupled(
        name="coupled-rod-too-long",
        sentence="The rod of the second pendulum is too long by one part in 1e10.",
        sees=("constraint", "length"),
        before=lambda request: _last_rod(request, HAIR),
    ),
    hook(
        name="hook-lets-out",
        sentence="The line is 1 % longer than it was at closest approach.",
        sees=("capture", "inertia"),
        levels=5,
        inside=holding(of_results(line_caught=scaled(1.01))),
    ),
    hook(
        name="hook-misses",
        sentence="A mass that passes just within reach of the hook is not caught.",
        sees=("error", "x"),
        inside=holding(of_parts(line_caught=lambda *a: 0.0)),
    ),
    hook(
        name="hook-brakes",
        sentence="The mass loses 1 % of its speed when it is caught.",
        sees=("capture", "speed"),
        levels=5,
        after=_braked,
    ),
    string(
        name="string-counter-weight",
        method="suzuki",
        sentence="The mass on the other side is 2 % too heavy.",
        sees=("second-integral", "I"),
        levels=5,
        before=of_bodies(mass=lambda m: m * np.array([1.0, 1.02])),
    ),
    string(
        name="string-one-sided",
        sentence="The speed of the string is computed from the side of the pendulum alone.",
        sees=("error", "rdot"),
        inside=holding(of_parts(string_speed=lambda string, out_a, out_b: out_a)),
    ),
    equilibrium(
        name="equilibrium-attracts",
        method="suzuki",
        sentence="The upper equilibrium is stable: gravity has the wrong sign.",
        on=("above",),
        sees=("equilibrium", "departure"),
        before=of_elements(UniformGravity, g=scaled(-1.0)),
    ),
    equilibrium(
        name="equilibrium-departs-faster",
        method="suzuki",
        sentence="Gravity is 5 % too strong.",
        on=("above",),
        sees=("equilibrium", "departure"),
        levels=6,
        before=of_elements(UniformGravity, g=scaled(1.05)),
    ),
    equilibrium(
        name="equilibrium-repels",
        sentence="The lower equilibrium is unstable: gravity has the wrong sign.",
        on=("below",),
        sees=("equilibrium", "bounded"),
        before=of_elements(UniformGravity, g=scaled(-1.0)),
    ),
)
