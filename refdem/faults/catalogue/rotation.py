"""Rotation: the gyroscopic term, quaternions, frames, angular velocity."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import (
    late,
    of_arguments,
    of_bodies,
    of_columns,
    of_parts,
    of_results,
    scaled,
)
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.mechanics.quaternion import conjugate, rotated

rotation = partial(Fault, kind="rotation")
OMEGA = ("error", "omega_body.x")
TURN = ("error", "attitude")


def _space_side(q: Any, omega: Any) -> Any:
    """q' = (0, omega) q/2, with omega in body axes: that is the rule for space axes."""
    return tuple(x / 2 for x in vec.product((0.0, *omega), q))


def _left_handed(q: Any, omega: Any) -> Any:
    """q' by the product of left-handed quaternions, (p q)_left = (p* q*)*."""
    product = vec.conjugate(vec.product((0.0, *omega), vec.conjugate(q)))
    return tuple(x / 2 for x in product)


def _back_about_second(axis: int, inertia: Any, omega: Any, q: Any, h: Any) -> Any:
    """The turn about one axis goes the wrong way."""
    if axis == 1:
        h = -h
    return axis, inertia, omega, q, h


def _leaning(g: Any) -> Any:
    """The vector 0.9 (x, y, z) + 0.1 (y, z, x): a tenth of each component is on another axis."""
    return vec.moved(vec.times(0.9, g), 0.1, (g[1], g[2], g[0]))


def _half_turn(sound: Parts) -> dict[str, Any]:
    """The quaternion turns by half of the angle by which the momentum does."""

    def axis_turn(axis: int, inertia: Any, omega: Any, q: Any, h: Any) -> Any:
        omega_after, _ = sound.axis_turn(axis, inertia, omega, q, h)
        _, q_after = sound.axis_turn(axis, inertia, omega, q, h / 2)
        return omega_after, q_after

    return {"axis_turn": axis_turn}


def _without_gyroscopic_term(sound: Parts) -> dict[str, Any]:
    """The body turns with the angular velocity that it has, which stays in body axes."""

    def axis_turn(axis: int, inertia: Any, omega: Any, q: Any, h: Any) -> Any:
        _, q_after = sound.axis_turn(axis, inertia, omega, q, h)
        return omega, q_after

    return {"gyroscopic": lambda inertia, omega: vec.ZERO, "axis_turn": axis_turn}


def _omega_in_body_axes(request: Request, run: Trajectory) -> Trajectory:
    """omega is written in body axes."""
    return replace(run, omega=rotated(conjugate(run.attitude), run.omega))


FAULTS = (
    rotation(
        name="no-gyroscopic-term",
        sentence="The gyroscopic term is missing (Brax 48, Godot 50173).",
        on=("tumbler",),
        method="rk4",
        sees=OMEGA,
        inside=_without_gyroscopic_term,
    ),
    rotation(
        name="no-gyroscopic-term-first-order",
        sentence="The gyroscopic term is missing in a first-order method.",
        on=("tumbler",),
        method="euler",
        sees=OMEGA,
        inside=of_parts(gyroscopic=lambda inertia, omega: vec.ZERO),
    ),
    rotation(
        name="gyroscopic-sign",
        sentence="The gyroscopic term has the wrong sign.",
        on=("tumbler",),
        method="rk4",
        sees=OMEGA,
        inside=of_results(gyroscopic=scaled(-1.0)),
    ),
    rotation(
        name="gyroscopic-half",
        sentence="The gyroscopic term is halved.",
        on=("tumbler",),
        method="rk4",
        sees=("error", "omega_body.y"),
        inside=of_results(gyroscopic=scaled(0.5)),
    ),
    rotation(
        name="gyroscopic-late",
        sentence="The gyroscopic term is that of the previous stage, and so explicit.",
        on=("tumbler",),
        method="rk4",
        sees=("order", "state"),
        inside=late("gyroscopic"),
    ),
    rotation(
        name="gyroscopic-never-flips",
        sentence="The gyroscopic term is missing, so that the body does not turn over.",
        on=("flipper",),
        method="rk4",
        sees=("flips", "flips"),
        levels=4,
        inside=of_parts(gyroscopic=lambda inertia, omega: vec.ZERO),
    ),
    rotation(
        name="gyroscopic-axis",
        sentence="One tenth of the gyroscopic torque acts about the next axis.",
        on=("tumbler",),
        method="rk4",
        sees=("energy", "finest"),
        inside=of_results(gyroscopic=_leaning),
    ),
    rotation(
        name="not-normalised",
        sentence="The quaternion is never normalised.",
        on=("tumbler",),
        method="rk4",
        sees=("quaternion-norm", "norm"),
        inside=of_parts(unit=lambda q: q),
    ),
    rotation(
        name="turn-side",
        sentence=(
            "omega in body axes multiplies the quaternion from the left, as omega in space"
            " axes would."
        ),
        on=("tumbler",),
        method="rk4",
        sees=TURN,
        inside=of_parts(turn_rate=_space_side),
    ),
    rotation(
        name="turn-left-handed",
        sentence="The quaternion product is that of left-handed axes.",
        on=("tumbler",),
        method="rk4",
        sees=TURN,
        inside=of_parts(turn_rate=_left_handed),
    ),
    rotation(
        name="turn-without-half",
        sentence="The rate of the quaternion is q omega, without the factor 1/2.",
        on=("tumbler",),
        method="rk4",
        sees=TURN,
        inside=of_parts(turn_rate=lambda q, w: vec.product(q, (0.0, *w))),
    ),
    rotation(
        name="turn-half-angle",
        sentence="The quaternion rotates by half the angle.",
        on=("tumbler",),
        sees=TURN,
        inside=_half_turn,
    ),
    rotation(
        name="turn-axis-2-back",
        sentence="One of three rotations has the wrong sense.",
        on=("tumbler",),
        sees=OMEGA,
        inside=of_arguments(axis_turn=_back_about_second),
    ),
    rotation(
        name="start-omega-as-body",
        sentence="omega in space axes is used as omega in body axes.",
        on=("tumbler",),
        sees=OMEGA,
        inside=of_parts(to_body=lambda q, a: a),
    ),
    rotation(
        name="out-omega-body",
        sentence="omega is written in body axes instead of space axes.",
        on=("tumbler",),
        sees=("error", "omega.x"),
        after=_omega_in_body_axes,
    ),
    rotation(
        name="out-omega-body-inside",
        sentence="omega is transformed from body to space axes by the inverse rotation.",
        on=("tumbler",),
        method="suzuki",
        sees=("error", "omega.x"),
        inside=of_arguments(to_space=lambda q, a: (vec.conjugate(q), a)),
    ),
    rotation(
        name="conjugated",
        sentence="The attitude maps space axes to body axes.",
        on=("tumbler",),
        sees=TURN,
        after=of_columns(attitude=conjugate),
    ),
    rotation(
        name="order-xyzw",
        sentence="The quaternion is written with its scalar last.",
        on=("tumbler",),
        sees=TURN,
        after=of_columns(attitude=lambda q: np.roll(q, -1, axis=-1)),
    ),
    rotation(
        name="order-xyzw-in",
        sentence="The attitude at the start is read with its scalar last.",
        on=("tumbler",),
        sees=TURN,
        before=of_bodies(attitude=lambda q: np.roll(q, 1, axis=-1)),
    ),
    rotation(
        name="conjugated-start",
        sentence="The attitude at the start is read as its inverse.",
        on=("tumbler",),
        sees=TURN,
        before=of_bodies(attitude=conjugate),
    ),
    rotation(
        name="attitude-stays",
        sentence="The attitude does not change.",
        on=("flyer",),
        sees=TURN,
        after=of_columns(attitude=lambda q: np.broadcast_to(q[:1], q.shape)),
    ),
    rotation(
        name="frequency-for-omega",
        sentence="The frequency f is used instead of omega = 2 pi f.",
        on=("tumbler",),
        sees=("error", "omega.x"),
        after=of_columns(omega=lambda w: w / (2 * np.pi)),
    ),
    rotation(
        name="omega-sign",
        sentence="omega has the wrong sign.",
        on=("tumbler",),
        sees=("error", "omega.y"),
        after=of_columns(omega=lambda w: -w),
    ),
    rotation(
        name="omega-axes-turned",
        sentence="The axes of omega are written in another order.",
        on=("tumbler",),
        sees=("error", "omega.z"),
        after=of_columns(omega=lambda w: np.roll(w, 1, axis=-1)),
    ),
)
