"""Faults that act only now and then: after many steps, for one sign, one body, unequal masses, one
row, in other frames or units.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import (
    Inside,
    forgetting,
    of_bodies,
    of_columns,
    of_pace,
    of_parts,
    of_results,
    with_force,
)
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene.elements.spring import Spring

subtle = partial(Fault, kind="subtle")


def _after(calls: int, factor: float) -> Inside:
    """The spring is correct in the first `calls` evaluations of a run, then stiffer by a factor."""

    def inside(sound: Parts) -> dict[str, Any]:
        sound_force = sound.forces[Spring]
        made = 0

        def begin() -> None:
            nonlocal made
            made = 0

        def force(*arguments: Any) -> Any:
            nonlocal made
            made += 1
            if made <= calls:
                return sound_force(*arguments)
            return vec.times(factor, sound_force(*arguments))

        return forgetting(sound, begin, **with_force(sound, Spring, force))

    return inside


def _row(number: int, value: float) -> Any:
    """A change of a column (T, N, 3) that replaces row `number` by a value."""

    def change(values: Any) -> Any:
        changed = values.copy()
        changed[number] = value
        return changed

    return change


def _against_ground(sound: Parts) -> dict[str, Any]:
    """The dashpot of a pair in contact brakes each body against the ground, by -1e-3 v."""

    def loads(world: Any, state: Any, parts: Parts, before: Any = None, h: Any = 0.0) -> Any:
        loads_now = sound.loads(world, state, parts, before, h)
        for number, acts in enumerate(state.acting):
            if not acts:
                continue
            for i in world.pairs[number]:
                loads_now.force[i] = vec.moved(loads_now.force[i], -1e-3, state.v[i])
        return loads_now

    return {"loads": loads}


def _one_way(sound: Parts) -> dict[str, Any]:
    """No friction where the slip is negative."""

    def slider_force(slider: Any, side: Any, speed: Any) -> Any:
        if side >= 0:
            return sound.slider_force(slider, side, speed)
        return vec.ZERO

    return {"slider_force": slider_force}


def _sleeping(sound: Parts) -> dict[str, Any]:
    """A force that would leave a body slower than 1 mm/s does not act."""

    def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
        pushed = sound.kicked(v, force, mass, h)
        if vec.size(pushed) < 1e-3:
            return v
        return pushed

    return {"kicked": kicked}


def _none_below_threshold(depth: Any) -> Any:
    """Overlaps below 1 cm count as no overlap."""
    if 0 < depth < 0.01:
        return 0.0
    return depth


def _first_radius(sound: Parts) -> dict[str, Any]:
    """The first radius of a run is used for all levers."""
    kept: dict[str, Any] = {}

    def lever(radius: Any, depth: Any, shortening: Any) -> Any:
        return sound.lever(kept.setdefault("radius", radius), depth, shortening)

    return forgetting(sound, kept.clear, lever=lever)


def _work_late(request: Request, run: Trajectory) -> Trajectory:
    """The work of dissipation is that of the row before."""
    work = run.channels["dissipated_work"]
    late_work = np.concatenate([work[:1], work[:-1]])
    return replace(run, channels={**run.channels, "dissipated_work": late_work})


def _channel(name: str, factor: float) -> Callable[[Request, Trajectory], Trajectory]:
    """A change of a trajectory that multiplies one channel by a factor."""

    def after(request: Request, run: Trajectory) -> Trajectory:
        return replace(run, channels={**run.channels, name: factor * run.channels[name]})

    return after


def _row_twice(request: Request, run: Trajectory) -> Trajectory:
    """A row in the middle is written twice, the next one never."""
    rows = np.arange(len(run.t))
    rows[6] = 5
    return replace(run, t=run.t[rows], position=run.position[rows], velocity=run.velocity[rows])


FAULTS = (
    subtle(
        name="after-many-steps",
        sentence="From the 101st evaluation on the spring is 1 % stiffer.",
        on=("oscillator",),
        method="suzuki",
        levels=4,
        sees=("error", "x"),
        inside=_after(100, 1.01),
    ),
    subtle(
        name="torque-of-the-plane",
        sentence="The torque of friction is that of plane motion, about z only.",
        on=("tumbling-spheres",),
        sees=("angular-momentum", "total"),
        inside=of_results(torque_on=lambda found: (0.0, 0.0, found[2])),
    ),
    subtle(
        name="friction-one-way",
        sentence="Dry friction acts on slip in one direction only.",
        on=("rubbing",),
        sees=("error", "x"),
        inside=_one_way,
    ),
    subtle(
        name="inertia-of-the-first",
        sentence="The moments of inertia of the first body are used for all.",
        on=("sticker",),
        sees=("angular-momentum", "total"),
        before=of_bodies(inertia=lambda moments: moments[[0] * len(moments)]),
    ),
    subtle(
        name="masses-averaged",
        sentence="Both bodies have the mean mass: right for equal ones.",
        on=("knock",),
        sees=("momentum", "total"),
        before=of_bodies(mass=lambda m: np.full(len(m), m.mean())),
    ),
    subtle(
        name="not-a-number-as-zero",
        sentence="One velocity is NaN and is written as 0.",
        on=("oscillator",),
        sees=("error", "v"),
        after=of_columns(velocity=_row(7, 0.0)),
    ),
    subtle(
        name="row-twice",
        sentence="A row is written twice, the next one never.",
        on=("oscillator",),
        sees=("run", "trajectory"),
        after=_row_twice,
    ),
    subtle(
        name="stops-at-steps",
        sentence="A body that friction stops comes to rest at the end of a step.",
        on=("rubbing",),
        levels=8,
        sees=("error", "x"),
        inside=of_parts(located=lambda margin, first, last, resolution: 1.0),
    ),
    subtle(
        name="drift-of-the-clock",
        sentence="The step is too long by one part in 1e6.",
        on=("oscillator",),
        method="suzuki",
        levels=8,
        sees=("error", "x"),
        inside=of_pace(1 + 1e-6, "drifted", "kicked"),
    ),
    subtle(
        name="sleeps",
        sentence="Bodies slower than 1 mm/s are put to rest.",
        on=("oscillator",),
        method="suzuki",
        levels=6,
        sees=("reversal", "reversed"),
        inside=_sleeping,
    ),
    subtle(
        name="cells",
        sentence="Positions are rounded to a grid of 1e-9 m.",
        on=("bounce",),
        sees=("reversal", "reversed"),
        inside=of_results(drifted=lambda found: tuple(round(x, 9) for x in found)),
    ),
    subtle(
        name="braked-against-the-ground",
        sentence=(
            "The dashpot of a contact opposes velocities relative to the ground instead of"
            " the other body."
        ),
        on=("knock",),
        sees=("symmetry", "boosted"),
        inside=_against_ground,
    ),
    subtle(
        name="left-handed-below",
        sentence="The z component of the torque is replaced by its absolute value.",
        on=("scrape",),
        sees=("symmetry", "mirrored"),
        inside=of_results(torque_on=lambda found: (*found[:2], abs(found[2]))),
    ),
    subtle(
        name="radius-of-the-first",
        sentence="The radius of the first body is used for all in the lever arm.",
        on=("scrape",),
        sees=("symmetry", "relabelled"),
        inside=_first_radius,
    ),
    subtle(
        name="absolute-threshold",
        sentence="Overlaps below 1 cm count as no overlap.",
        on=("bounce",),
        sees=("symmetry", "rescaled"),
        inside=of_results(overlap=_none_below_threshold),
    ),
    subtle(
        name="work-late",
        sentence="The dissipated work is that of the previous row.",
        on=("rubbing",),
        sees=("energy", "balance"),
        after=_work_late,
    ),
    subtle(
        name="work-half",
        sentence="The dissipated work is halved.",
        on=("knock",),
        sees=("energy", "balance"),
        after=_channel("dissipated_work", 0.5),
    ),
    subtle(
        name="overlap-doubled",
        sentence="The overlap is written once for each body.",
        on=("bounce",),
        sees=("contact-channels", "overlap"),
        after=_channel("overlap", 2.0),
    ),
    subtle(
        name="contact-force-sign",
        sentence="The contact force is written with a negative sign.",
        on=("bounce",),
        sees=("contact-channels", "contact_force"),
        after=_channel("contact_force", -1.0),
    ),
)
