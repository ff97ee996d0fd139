"""Impacts of the rigid law: restitution, friction, effective masses, spins, and pairs that are met
twice or never.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults import impacts
from refdem.faults.change import (
    Inside,
    every_other,
    forgetting,
    of_arguments,
    of_bodies,
    of_elements,
    of_parts,
    of_results,
    scaled,
    within,
)
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene import Scene, Sphere
from refdem.scene.elements.contact import Contact

impact = partial(Fault, kind="impacts")


def _slimmer(request: Request) -> Request:
    """The request with spheres of 0.9 of their radii, and the same moments of inertia."""
    scene = request.problem.scene
    shapes = tuple(Sphere(radius=0.9 * radius) for radius in scene.bodies.radius.tolist())
    return request.with_scene(Scene(replace(scene.bodies, shape=shapes), scene.elements))


def _of_impact(**parts: Any) -> Inside:
    """Parts of impacts replaced by other functions."""
    return within("impacts", of_parts(**parts))


def _friction_without_restitution(law: Any, inverse_mass: Any, slip: Any, pressing: Any) -> Any:
    """The limit is mu times the impulse that stops the spheres, without the one that parts them."""
    stopping = pressing / (1 + law.restitution)
    return impacts.tangential_impulse(law, inverse_mass, slip, stopping)


def _unlimited(law: Any, inverse_mass: Any, slip: Any, pressing: Any) -> Any:
    """The impulse -(1 + b) m_t s that reverses the part b of the slip s, without a limit by
    friction.
    """
    return vec.times(-(1 + law.slip_restitution) / inverse_mass, slip)


def _always_cut(law: Any, inverse_mass: Any, slip: Any, pressing: Any) -> Any:
    """The impulse -mu P_n s/|s|: friction of full size, also where a smaller one stops the slip."""
    return vec.times(-law.friction * pressing / vec.size(slip), slip)


def _second_turns_back(sound: Parts) -> dict[str, Any]:
    """The torque on every second sphere, R n x P, has the wrong sign."""
    is_first = cycle((True, False))

    def torque_on(arm: Any, normal: Any, force: Any) -> Any:
        torque = sound.torque_on(arm, normal, force)
        if next(is_first):
            return torque
        return vec.times(-1.0, torque)

    return {"torque_on": torque_on}


def _elastic_after_the_first(sound: Parts) -> dict[str, Any]:
    """The restitution counts in the first impact of a run; all later ones lose nothing."""
    is_first = True

    def begin() -> None:
        nonlocal is_first
        is_first = True

    def normal_impulse(law: Any, inverse_mass: Any, closing: Any) -> Any:
        nonlocal is_first
        if is_first:
            is_first = False
            return impacts.normal_impulse(law, inverse_mass, closing)
        return 2.0 * closing / inverse_mass

    return forgetting(sound, begin, **_of_impact(normal_impulse=normal_impulse)(sound))


def _pairs_met_once(sound: Parts) -> dict[str, Any]:
    """A second impact of the same pair is ignored; pairs are distinguished by their inverse
    effective masses, which differ.
    """
    met: set[float] = set()

    def normal_impulse(law: Any, inverse_mass: Any, closing: Any) -> Any:
        if inverse_mass in met:
            return 0.0
        met.add(inverse_mass)
        return impacts.normal_impulse(law, inverse_mass, closing)

    return forgetting(sound, met.clear, **_of_impact(normal_impulse=normal_impulse)(sound))


def _velocity_before_the_kick(sound: Parts) -> dict[str, Any]:
    """The closing speed without the g h that the last kick of gravity in the step has added."""
    gained = 0.0

    def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
        nonlocal gained
        # An impulse is a kick of unit length.
        is_impulse = h == 1.0
        if not is_impulse:
            gained = vec.size(force) * abs(h) / mass
        return sound.kicked(v, force, mass, h)

    def normal_impulse(law: Any, inverse_mass: Any, closing: Any) -> Any:
        # At least half of the closing speed: in a step as long as the flight, g h may exceed it.
        too_slow = max(closing - gained, closing / 2)
        return impacts.normal_impulse(law, inverse_mass, too_slow)

    return {**_of_impact(normal_impulse=normal_impulse)(sound), "kicked": kicked}


def _friction_from_weight(law: Any, inverse_mass: Any, slip: Any, pressing: Any) -> Any:
    """Friction is cut at a thousandth of what the impulse allows, as if the weight pressed."""
    return impacts.tangential_impulse(law, inverse_mass, slip, pressing / 1000)


def _resting_below(threshold: float) -> Callable[..., Any]:
    """A normal impulse with restitution 0 below a closing speed `threshold` [m/s]."""

    def normal_impulse(law: Any, inverse_mass: Any, closing: Any) -> Any:
        if closing < threshold:
            return closing / inverse_mass
        return (1 + law.restitution) * closing / inverse_mass

    return normal_impulse


def _impulse_on_one_kilogram(sound: Parts) -> dict[str, Any]:
    """Impulses change the velocity of every sphere as if its mass were 1 kg."""

    def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
        # An impulse is a kick of unit length.
        if h == 1.0:
            mass = 1.0
        return sound.kicked(v, force, mass, h)

    return {"kicked": kicked}


def _turned_a_little(away: Any) -> Any:
    """A vector in the plane, turned by 1/1000 rad to first order."""
    x, y, z = away
    return (x - y / 1000, y + x / 1000, z)


def _none_if_slow(law: Any, inverse_mass: Any, closing: Any) -> Any:
    """A normal impulse that is 0 below a closing speed of 3/5 m/s."""
    if closing < 0.6:
        return 0.0
    return impacts.normal_impulse(law, inverse_mass, closing)


def _given_back_but_little(law: Any, inverse_mass: Any, closing: Any) -> Any:
    """A normal impulse with the restitution reduced by 1e-9."""
    return (1 + law.restitution - 1e-9) * closing / inverse_mass


def _thin_air(request: Request, run: Trajectory) -> Trajectory:
    """Velocities decay as exp(-1e-8 t), t [s] from the start."""
    fade = np.exp(-1e-8 * (run.t - run.t[0]))
    return replace(run, velocity=run.velocity * fade[:, None, None])


def _at_the_end_of_the_step(sound: Parts) -> dict[str, Any]:
    """Pairs that meet within a step are struck at its end, in the order of their list."""
    return {"located": lambda margin, first, last, resolution: 1.0}


FAULTS = (
    impact(
        name="restitution-twice",
        sentence="The closing speed is multiplied by the restitution twice.",
        on=("clash", "rub", "rebound", "break"),
        sees=("rigid-impact", "restitution"),
        before=of_elements(Contact, restitution=lambda e: e * e),
    ),
    impact(
        name="restitution-of-energy",
        sentence="The restitution is used as the ratio of energies instead of velocities.",
        on=("clash",),
        sees=("error", "v2.x"),
        before=of_elements(Contact, restitution=lambda e: e**0.5),
    ),
    impact(
        name="restitution-without-one",
        sentence="The normal impulse has the factor e instead of 1 + e.",
        on=("clash",),
        sees=("error", "v1.x"),
        inside=_of_impact(
            normal_impulse=lambda law, inverse_mass, closing: (
                law.restitution * closing / inverse_mass
            )
        ),
    ),
    impact(
        name="restitution-one-in-a-million",
        sentence="The restitution is too large by one part in 1e6.",
        on=("clash",),
        sees=("error", "v1.x"),
        levels=5,
        before=of_elements(Contact, restitution=scaled(1 + 1e-6)),
    ),
    impact(
        name="impact-has-no-way-back",
        sentence=(
            "Every impact removes one part in 1e9 of the closing speed, also when time is reversed."
        ),
        on=("elastic", "elastic-cradle", "elastic-drop", "elastic-corner"),
        sees=("reversal", "reversed"),
        inside=_of_impact(normal_impulse=_given_back_but_little),
    ),
    impact(
        name="impact-of-equal-masses",
        sentence=(
            "Both spheres change their velocities by the same amount, as if their masses were"
            " equal."
        ),
        on=("clash",),
        sees=("momentum", "total"),
        inside=_impulse_on_one_kilogram,
    ),
    impact(
        name="impact-without-reaction",
        sentence="The impulse acts on one sphere only.",
        on=("clash",),
        sees=("momentum", "total"),
        inside=of_parts(reaction=lambda force: vec.ZERO),
    ),
    impact(
        name="impact-by-friction-without-restitution",
        sentence="Friction is limited by mu m_n c, without the factor (1 + e).",
        on=("rub",),
        sees=("error", "omega1.x"),
        inside=_of_impact(tangential_impulse=_friction_without_restitution),
    ),
    impact(
        name="impact-friction-unlimited",
        sentence="Friction stops the slip, whatever its coefficient.",
        on=("rub", "rebound"),
        sees=("rigid-impact", "cone"),
        inside=_of_impact(tangential_impulse=_unlimited),
    ),
    impact(
        name="impact-friction-always-cut",
        sentence="Friction has the full size mu p_n where a smaller impulse stops the slip.",
        on=("grip",),
        sees=("error", "omega1.z"),
        inside=_of_impact(tangential_impulse=_always_cut),
    ),
    impact(
        name="impact-tangential-mass",
        sentence="The tangential effective mass is the normal one, as if nothing could turn.",
        on=("grip",),
        sees=("error", "omega1.x"),
        inside=_of_impact(tangential_ease=lambda inverse_mass, turn_i, turn_j: inverse_mass),
    ),
    impact(
        name="impact-turns-one-sphere",
        sentence=(
            "The tangential effective mass includes the moment of inertia of the first sphere only."
        ),
        on=("grip",),
        sees=("error", "omega2.x"),
        inside=_of_impact(
            tangential_ease=lambda inverse_mass, turn_i, turn_j: inverse_mass + turn_i
        ),
    ),
    impact(
        name="impact-of-solid-spheres",
        sentence=(
            "The tangential effective mass has the factor 7/2 of solid spheres for all spheres."
        ),
        on=("grip",),
        sees=("error", "omega1.y"),
        inside=_of_impact(tangential_ease=lambda inverse_mass, turn_i, turn_j: 3.5 * inverse_mass),
    ),
    impact(
        name="impact-spin-sign",
        sentence="The spin of the second sphere changes in the wrong direction.",
        on=("rub", "grip"),
        sees=("angular-momentum", "total"),
        inside=_second_turns_back,
    ),
    impact(
        name="impact-spin-of-one",
        sentence="The spin of the second sphere does not change.",
        on=("grip",),
        sees=("angular-momentum", "total"),
        inside=every_other("torque_on"),
    ),
    impact(
        name="impact-slip-of-centres",
        sentence="The slip ignores spins: it is that of the centres.",
        on=("grip",),
        sees=("error", "v1.y"),
        inside=of_arguments(slip=lambda velocity, spin, normal: (velocity, vec.ZERO, normal)),
    ),
    impact(
        name="impact-without-tangential-restitution",
        sentence="Friction stops the slip where it should reverse part of it.",
        on=("grip",),
        sees=("error", "omega1.x"),
        before=of_elements(Contact, tangential_restitution=scaled(0.0)),
    ),
    impact(
        name="impact-met-twice",
        sentence="The pair is in the list twice, and both impulses use the same velocities.",
        on=("clash", "rebound", "break"),
        sees=("rigid-impact", "restitution"),
        inside=within("impacts", of_results(normal_impulse=scaled(2.0))),
    ),
    impact(
        name="impact-never-met",
        sentence="The spheres pass through each other.",
        on=("clash", "rub", "rebound", "break"),
        sees=("rigid-impact", "restitution"),
        inside=_of_impact(meets=lambda closing: False),
    ),
    impact(
        name="impact-below-a-threshold",
        sentence="The restitution is 0 below a closing speed of 2 m/s.",
        on=("clash", "rebound"),
        sees=("rigid-impact", "restitution"),
        inside=_of_impact(normal_impulse=_resting_below(2.0)),
    ),
    impact(
        name="impact-of-the-larger-sphere",
        sentence="The spheres collide as if their radii were 1 % larger.",
        on=("clash",),
        levels=6,
        sees=("event-times", "contact"),
        inside=of_arguments(overlap=lambda a, b, distance: (1.01 * a, 1.01 * b, distance)),
    ),
    impact(
        name="impact-inertia-of-a-point",
        sentence="Moments of inertia are 1 % too large.",
        on=("grip", "rub"),
        sees=("error", "omega1.x"),
        before=of_bodies(inertia=scaled(1.01)),
    ),
    impact(
        name="impacts-elastic-after-the-first",
        sentence="The restitution is applied in the first impact only.",
        on=("cradle",),
        sees=("error", "v3.x"),
        inside=_elastic_after_the_first,
    ),
    impact(
        name="impacts-of-a-pair-once",
        sentence="A pair that has collided once is ignored afterwards.",
        on=("cradle",),
        sees=("error", "v1.x"),
        inside=_pairs_met_once,
    ),
    impact(
        name="impacts-at-the-ends-of-steps",
        sentence="Pairs that meet within a step collide at its end, in the order of their list.",
        on=("cradle", "break"),
        sees=("error", "r2.x"),
        levels=8,
        inside=_at_the_end_of_the_step,
    ),
    impact(
        name="corner-impulse-does-not-turn",
        sentence="The impulse at a corner acts on the centre: the body does not rotate.",
        on=("corner",),
        sees=("error", "omega"),
        inside=_of_impact(corner_torque=lambda arm, impulse: vec.ZERO),
    ),
    impact(
        name="corner-impulse-of-a-point",
        sentence=("The effective mass at a corner is that of the body, as if it could not rotate."),
        on=("corner",),
        sees=("error", "vy"),
        inside=_of_impact(corner_ease=lambda inverse_mass, lever, inertia: inverse_mass),
    ),
    impact(
        name="break-normal-is-turned",
        sentence="The normal of an impact is rotated by 0.001 rad from the line of centres.",
        on=("break",),
        sees=("angular-momentum", "total"),
        inside=of_results(away=_turned_a_little),
    ),
    impact(
        name="break-slow-impacts-are-missed",
        sentence="Pairs with a closing speed below 3/5 m/s pass through each other.",
        on=("break",),
        sees=("error", "v0.x"),
        inside=_of_impact(normal_impulse=_none_if_slow),
    ),
    impact(
        name="bounce-before-the-kick",
        sentence="The closing speed lacks the last change by gravity in the step.",
        on=("drop",),
        sees=("error", "y"),
        levels=6,
        inside=_velocity_before_the_kick,
    ),
    impact(
        name="bounce-friction-from-weight",
        sentence="Friction in a bounce is limited by the weight instead of the normal impulse.",
        on=("drop",),
        sees=("rigid-impact", "friction"),
        inside=_of_impact(tangential_impulse=_friction_from_weight),
    ),
    impact(
        name="bounce-in-thin-air",
        sentence="Velocities decay slowly, as by the drag of air.",
        on=("drop",),
        sees=("momentum", "flights"),
        after=_thin_air,
    ),
    impact(
        name="bounce-below-a-threshold",
        sentence="A ball with an impact speed below 4 m/s does not bounce, and creeps.",
        on=("drop",),
        sees=("rigid-impact", "restitution"),
        inside=_of_impact(normal_impulse=_resting_below(4.0)),
    ),
    Fault(
        name="restitution-of-energies",
        kind="gas",
        sentence=(
            "Restitution is read as a ratio of energies, so that velocities keep its square root."
        ),
        on=("gas",),
        sees=("cooling", "temperature"),
        method="impacts",
        levels=1,
        before=of_elements(Contact, restitution=lambda e: e**0.5),
    ),
    Fault(
        name="spheres-slimmer",
        kind="gas",
        sentence=(
            "Spheres collide at a distance of 0.9 of their diameter, so that some collisions"
            " are missed."
        ),
        on=("gas",),
        sees=("cooling", "collisions"),
        method="impacts",
        levels=1,
        before=_slimmer,
    ),
)
