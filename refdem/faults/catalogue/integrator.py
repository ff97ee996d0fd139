"""Integrators: coefficients, time levels, first and last steps."""

from functools import partial
from itertools import count
from typing import Any

from refdem.faults.change import (
    Late,
    forgetting,
    late,
    of_elements,
    of_force,
    of_pace,
    of_parts,
    of_results,
    scaled,
    skipping,
    with_force,
)
from refdem.faults.correct_parts import S4
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene.elements.central_field import CentralField
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

integrator = partial(Fault, kind="integrator", on=("oscillator",))
ORDER = ("order", "state")


def _first_kick_twice(sound: Parts) -> dict[str, Any]:
    """The first kick of a run is a whole one, as if the velocity were half a step behind."""
    is_first = True

    def begin() -> None:
        nonlocal is_first
        is_first = True

    def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
        nonlocal is_first
        if is_first:
            is_first = False
            h = 2.0 * h
        return sound.kicked(v, force, mass, h)

    return forgetting(sound, begin, kicked=kicked)


def _old_velocity(sound: Parts) -> dict[str, Any]:
    """The drift x + h v with the velocity v of the drift in the step before."""
    previous = Late(lambda v: v)

    def drifted(r: Any, v: Any, h: Any) -> Any:
        return sound.drifted(r, previous(v), h)

    return forgetting(sound, previous.answers.clear, drifted=drifted)


def _lopsided(sound: Parts) -> dict[str, Any]:
    """The two half turns about axis 1 of a step as one whole turn at its start."""
    turns = count(1)

    def axis_turn(axis: int, inertia: Any, omega: Any, q: Any, h: Any) -> Any:
        if axis != 0:
            return sound.axis_turn(axis, inertia, omega, q, h)
        if next(turns) % 2:
            return sound.axis_turn(axis, inertia, omega, q, 2 * h)
        return omega, q

    return {"axis_turn": axis_turn}


def _averaged(sound: Parts) -> dict[str, Any]:
    """Attraction is the mean of the present one and the one before."""
    attraction = sound.forces[CentralField]
    previous = Late(attraction)

    def averaged(*arguments: Any) -> Any:
        return vec.times(0.5, vec.plus(attraction(*arguments), previous(*arguments)))

    return forgetting(sound, previous.answers.clear, **with_force(sound, CentralField, averaged))


FAULTS = (
    integrator(
        name="suzuki-coefficient",
        sentence="A coefficient of the composition is wrong, though their sum is 1.",
        method="suzuki",
        sees=ORDER,
        inside=of_parts(suzuki=(S4 + 0.02, S4, 1.0 - 4 * S4, S4, S4 - 0.02)),
    ),
    integrator(
        name="suzuki-third-digit",
        sentence="The outer coefficients of the composition are rounded to three digits.",
        method="suzuki",
        sees=ORDER,
        levels=6,
        inside=of_parts(suzuki=(0.414, 0.414, -0.656, 0.414, 0.414)),
    ),
    integrator(
        name="suzuki-sign",
        sentence=("The middle coefficient of the composition has the wrong sign (Principia 578)."),
        method="suzuki",
        sees=("error", "x"),
        inside=of_parts(suzuki=(S4, S4, 4.0 * S4 - 1.0, S4, S4)),
    ),
    integrator(
        name="suzuki-misses",
        sentence="The sum of the coefficients of the composition differs slightly from 1.",
        method="suzuki",
        sees=("error", "v"),
        levels=4,
        inside=of_parts(suzuki=(S4, S4, 1.0 - 4.0 * S4, S4, S4 + 0.001)),
    ),
    integrator(
        name="rk4-weights",
        sentence="Two weights of the Runge-Kutta method are exchanged.",
        method="rk4",
        sees=ORDER,
        inside=of_parts(rk4_weights=(1 / 3, 1 / 6, 1 / 6, 1 / 3)),
    ),
    integrator(
        name="rk4-weight-typo",
        sentence="The sum of the weights of the Runge-Kutta method is 5/6.",
        method="rk4",
        sees=("error", "x"),
        inside=of_parts(rk4_weights=(1 / 6, 1 / 3, 1 / 6, 1 / 6)),
    ),
    integrator(
        name="rk4-node",
        sentence="The third stage is evaluated at 1/3 of the step instead of 1/2.",
        method="rk4",
        sees=ORDER,
        on=("orbit",),
        inside=of_parts(rk4_nodes=(0.5, 1 / 3, 1.0)),
    ),
    integrator(
        name="rk4-node-turning",
        sentence=(
            "The third stage of a rotating body is evaluated at 1/3 of the step instead of 1/2."
        ),
        method="rk4",
        sees=ORDER,
        on=("tumbler",),
        inside=of_parts(rk4_nodes=(0.5, 1 / 3, 1.0)),
    ),
    integrator(
        name="rk4-weights-turning",
        sentence="Two weights of the Runge-Kutta method are exchanged for a rotating body.",
        method="rk4",
        sees=ORDER,
        on=("tumbler",),
        inside=of_parts(rk4_weights=(1 / 3, 1 / 6, 1 / 6, 1 / 3)),
    ),
    integrator(
        name="step-by-a-hair",
        sentence="Steps are too long by one part in 1e7.",
        sees=("limit", "state"),
        on=("oscillator", "orbit", "hardening"),
        levels=5,
        inside=of_pace(1 + 1e-7, "kicked", "drifted"),
    ),
    integrator(
        name="stiffness-by-a-hair",
        sentence="Springs are too stiff by one part in 1e6.",
        sees=("limit", "state"),
        on=("oscillator", "hanging"),
        levels=5,
        before=of_elements(Spring, stiffness=scaled(1 + 1e-6)),
    ),
    integrator(
        name="turning-by-a-hair",
        sentence="Bodies rotate too fast by one part in 1e6.",
        sees=("limit", "state"),
        on=("tumbler",),
        levels=5,
        inside=of_pace(1 + 1e-6, "axis_turn"),
    ),
    integrator(
        name="rk4-last-stage",
        sentence="The last stage is evaluated at the middle of the step.",
        method="rk4",
        sees=ORDER,
        inside=of_parts(rk4_nodes=(0.5, 0.5, 0.5)),
    ),
    integrator(
        name="one-sided-kick",
        sentence="Each step has one full kick instead of two half kicks.",
        sees=ORDER,
        inside=of_parts(verlet_kicks=(1.0, 0.0)),
    ),
    integrator(
        name="kick-too-short",
        sentence="The second kick is 1 % too short.",
        sees=("error", "v"),
        levels=4,
        inside=of_parts(verlet_kicks=(0.5, 0.495)),
    ),
    integrator(
        name="first-kick-whole",
        sentence="The first kick of a run is a full one.",
        sees=ORDER,
        inside=_first_kick_twice,
    ),
    integrator(
        name="loads-late",
        sentence="All forces are those of the previous step.",
        sees=ORDER,
        inside=late("loads"),
    ),
    integrator(
        name="drift-with-old-velocity",
        sentence="Positions are advanced with the velocity of the previous step.",
        sees=ORDER,
        inside=_old_velocity,
    ),
    integrator(
        name="kick-reversed",
        sentence="The second kick has the wrong sign.",
        sees=("error", "v"),
        inside=of_parts(verlet_kicks=(0.5, -0.5)),
    ),
    integrator(
        name="drift-double",
        sentence="Positions are advanced by two steps.",
        sees=("error", "x"),
        inside=of_pace(2.0, "drifted"),
    ),
    integrator(
        name="step-one-part-in-thousand",
        sentence="The step is 0.1 % too long.",
        method="suzuki",
        sees=("error", "x"),
        levels=4,
        inside=of_pace(1.001, "drifted", "kicked"),
    ),
    integrator(
        name="axis-order",
        sentence=(
            "The splitting of the free body is not symmetric: one half rotation is twice as long,"
            " and another one is missing."
        ),
        on=("tumbler",),
        sees=ORDER,
        inside=_lopsided,
    ),
    integrator(
        name="kick-forgets-gravity",
        sentence="Gravity acts in the first kick only.",
        on=("hanging",),
        sees=("error", "x"),
        inside=of_force(UniformGravity, skipping),
    ),
    integrator(
        name="force-at-the-middle",
        sentence="The force is evaluated at the positions of half a drift before.",
        sees=ORDER,
        levels=4,
        on=("orbit",),
        inside=_averaged,
    ),
    integrator(
        name="reversal-broken",
        sentence="Each kick is too small by one part in 1e11.",
        on=("oscillator", "bounce", "hertz", "wedge"),
        sees=("reversal", "reversed"),
        inside=of_results(kicked=scaled(1 - 1e-11)),
    ),
)
