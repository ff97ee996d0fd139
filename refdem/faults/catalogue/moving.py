"""Faults of the whole motion: nothing moves at all, or everything moves a per cent too far."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from refdem.core.problem import Request
from refdem.core.trajectory import STATE, Array, Event, Trajectory
from refdem.faults.fault import Fault
from refdem.mechanics.quaternion import conjugate, product

PER_CENT = 1.01
"""Every way from the start is so many times what it should be."""
moving = partial(Fault, kind="moving", on=("oscillator",), sees=("error", "x"))


def frozen(request: Request, run: Trajectory) -> Trajectory:
    """Every row is the first one, events are never reported."""
    changed: dict[str, Any] = {name: _held(getattr(run, name)) for name in STATE}
    changed["channels"] = {name: _held(values) for name, values in run.channels.items()}
    changed["values"] = {name: _held(values) for name, values in run.values.items()}
    return replace(run, events=(), **changed)


def one_per_cent(request: Request, run: Trajectory) -> Trajectory:
    """Every column is a per cent further from its start; attitudes have turned by a per cent more;
    events are a per cent late.
    """
    changed: dict[str, Any] = {name: _stretched(getattr(run, name)) for name in STATE}
    changed["attitude"] = _turned_further(run.attitude)
    changed["channels"] = {name: _stretched(values) for name, values in run.channels.items()}
    changed["values"] = {name: _stretched(values) for name, values in run.values.items()}
    start = float(run.t[0])
    late = tuple(
        Event(time=start + PER_CENT * (event.time - start), kind=event.kind, body=event.body)
        for event in run.events
    )
    return replace(run, events=late, **changed)


def _held(values: Array) -> Array:
    """The first row for all rows."""
    return np.broadcast_to(values[:1], values.shape).copy()


def _stretched(values: Array) -> Array:
    """Every row a per cent further from the first; the one answer to a question without time a per
    cent larger.
    """
    if len(values) == 1:
        return PER_CENT * values
    return values[:1] + PER_CENT * (values - values[:1])


def _turned_further(attitude: Array) -> Array:
    """Attitudes (T, N, 4) whose rotation from the first one, of half a turn at most, is a per cent
    larger.
    """
    # q q_0* = (cos a, n sin a) for a rotation by 2 a about n; further = (cos 1.01 a, n sin 1.01 a).
    start = np.broadcast_to(attitude[:1], attitude.shape)
    turn = product(attitude, conjugate(start))
    turn = np.where(turn[..., :1] < 0, -turn, turn)
    sine = np.linalg.norm(turn[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(sine, turn[..., :1])
    axis = np.divide(turn[..., 1:], sine, out=np.zeros_like(turn[..., 1:]), where=sine > 0)
    further = np.concatenate([np.cos(PER_CENT * half), np.sin(PER_CENT * half) * axis], axis=-1)
    return product(further, start)


def _flown_further(request: Request, run: Trajectory) -> Trajectory:
    """Places a per cent further from the start than velocities take them."""
    return replace(run, position=_stretched(run.position))


FAULTS = (
    moving(
        name="frozen", sentence="Nothing moves: every row repeats the initial state.", after=frozen
    ),
    moving(
        name="one-per-cent",
        sentence="Every displacement from the start is 1 % too large.",
        after=one_per_cent,
    ),
    moving(
        name="flown-further",
        sentence="Displacements are 1 % larger than the integral of the velocities.",
        on=("bounce",),
        sees=("flight", "way"),
        after=_flown_further,
    ),
)
