"""Mass and inertia: axes, factors, bodies mixed up."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from refdem.faults.change import of_bodies
from refdem.faults.fault import Fault

Array = NDArray[np.float64]

inertia = partial(Fault, kind="inertia")


def _mean(moments: Array) -> Array:
    """The mean moment of inertia for all three axes."""
    return np.repeat(moments.mean(axis=1, keepdims=True), 3, axis=1)


def _inverse(moments: Array) -> Array:
    """1/J, with a constant added: no moment of a body exceeds the sum of the other two."""
    inverse = 1 / moments
    shifted: Array = inverse + inverse.max()
    return shifted


FAULTS = (
    inertia(
        name="inertia-axes-turned",
        sentence="The principal axes are numbered differently.",
        on=("tumbler",),
        sees=("error", "omega_body.x"),
        before=of_bodies(inertia=lambda j: np.roll(j, 1, axis=1)),
    ),
    inertia(
        name="inertia-axes-swapped",
        sentence="Two principal axes are swapped.",
        on=("tumbler",),
        sees=("angular-momentum", "total"),
        before=of_bodies(inertia=lambda j: j[:, [1, 0, 2]]),
    ),
    inertia(
        name="inertia-inverse",
        sentence="The inverse of the inertia is used.",
        on=("tumbler",),
        sees=("error", "omega_body.y"),
        before=of_bodies(inertia=_inverse),
    ),
    inertia(
        name="inertia-one-percent",
        sentence="One moment of inertia is 1 % too large.",
        on=("tumbler",),
        method="suzuki",
        sees=("error", "omega_body.x"),
        levels=4,
        before=of_bodies(inertia=lambda j: j * [1.01, 1.0, 1.0]),
    ),
    inertia(
        name="inertia-of-a-sphere",
        sentence="The body rotates as if it were a sphere.",
        on=("flipper",),
        sees=("flips", "flips"),
        levels=4,
        before=of_bodies(inertia=_mean),
    ),
    inertia(
        name="inertia-of-a-shell",
        sentence="The moment of inertia is 2/3 m R^2 instead of 2/5 m R^2.",
        on=("scrape",),
        sees=("error", "omega1.z"),
        before=of_bodies(inertia=lambda j: j * 5 / 3),
    ),
    inertia(
        name="inertia-of-a-disc",
        sentence="The moment of inertia is 1/2 m R^2 instead of 2/5 m R^2.",
        on=("spinner",),
        sees=("error", "omega2.z"),
        levels=4,
        before=of_bodies(inertia=lambda j: j * 5 / 4),
    ),
    inertia(
        name="inertia-lost",
        sentence="Each sphere has the moment of inertia of the other one.",
        on=("spinner",),
        sees=("angular-momentum", "total"),
        before=of_bodies(inertia=lambda j: j[::-1]),
    ),
    inertia(
        name="masses-swapped",
        sentence="The masses are assigned to the wrong bodies.",
        on=("knock",),
        sees=("momentum", "total"),
        before=of_bodies(mass=lambda m: m[::-1]),
    ),
    inertia(
        name="masses-equal",
        sentence="All bodies have the mass of the first.",
        on=("bounce",),
        sees=("momentum", "total"),
        before=of_bodies(mass=lambda m: np.full_like(m, m[0])),
    ),
    inertia(
        name="mass-lossy",
        sentence="A model file rounds the mass to two digits (strands 181).",
        on=("oscillator",),
        method="suzuki",
        sees=("error", "x"),
        levels=4,
        before=of_bodies(mass=lambda m: m * 1.004),
    ),
    inertia(
        name="mass-forgotten",
        sentence="The acceleration equals the force: it is not divided by the mass.",
        on=("oscillator",),
        sees=("error", "v"),
        before=of_bodies(mass=lambda m: m**2),
    ),
)
