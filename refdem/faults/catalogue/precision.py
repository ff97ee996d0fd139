"""Precision: single where double is declared, constants with few digits."""

from functools import partial
from typing import Any

from refdem.faults.change import (
    of_arguments,
    of_bodies,
    of_columns,
    of_elements,
    of_force,
    of_results,
    rounded,
    scaled,
    single,
)
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.scene.elements.spring import Spring
from refdem.scene.elements.uniform_gravity import UniformGravity

precision = partial(Fault, kind="precision")


def _tabled(axis: int, inertia: Any, omega: Any, q: Any, h: Any) -> Any:
    """Sines from a table of 4096 entries: the angle is a whole multiple of 1/4096."""
    return axis, inertia, omega, q, round(h * omega[axis] * 4096) / 4096 / omega[axis]


def _fixed_point(r: Any) -> Any:
    """Positions far from the origin lose digits: kept as multiples of 1e-10 m."""
    return tuple(round(x * 1e10) / 1e10 for x in r)


def _loosely_normalised(sound: Parts) -> dict[str, Any]:
    """A quaternion is normalised only if |q|^2 differs from 1 by more than 1e-6."""

    def unit(q: Any) -> Any:
        square = sum(x * x for x in q)
        if abs(square - 1) > 1e-6:
            return sound.unit(q)
        return q

    return {"unit": unit}


FAULTS = (
    precision(
        name="velocity-single",
        sentence="Velocities are kept in single precision.",
        on=("ellipse",),
        sees=("angular-momentum", "total"),
        inside=of_results(kicked=rounded),
    ),
    precision(
        name="position-single",
        sentence="Positions are kept in single precision.",
        on=("swing",),
        sees=("constraint", "length"),
        inside=of_results(drifted=rounded),
    ),
    precision(
        name="position-single-orbit",
        sentence="Positions are kept in single precision.",
        on=("orbit",),
        sees=("angular-momentum", "total"),
        inside=of_results(drifted=rounded),
    ),
    precision(
        name="attitude-single",
        sentence="Attitudes are kept in single precision.",
        on=("tumbler",),
        sees=("quaternion-norm", "norm"),
        inside=of_results(unit=rounded),
    ),
    precision(
        name="momentum-single",
        sentence="Spins are kept in single precision.",
        on=("tumbler",),
        sees=("angular-momentum", "total"),
        inside=of_results(axis_turn=lambda found: (rounded(found[0]), found[1])),
    ),
    precision(
        name="force-single",
        sentence="Forces are computed in single precision.",
        on=("oscillator",),
        method="suzuki",
        levels=8,
        sees=("error", "x"),
        inside=of_force(Spring, lambda sound: lambda *given: rounded(sound(*given))),
    ),
    precision(
        name="out-single",
        sentence="The output file is in single precision.",
        on=("orbit",),
        sees=("angular-momentum", "total"),
        after=of_columns(position=single, velocity=single),
    ),
    precision(
        name="out-single-omega",
        sentence="Angular velocities are written in single precision.",
        on=("tumbler",),
        sees=("angular-momentum", "spin"),
        after=of_columns(omega=single),
    ),
    precision(
        name="start-single",
        sentence="The scene file is read in single precision.",
        on=("swing",),
        sees=("constraint", "length"),
        before=of_bodies(position=single),
    ),
    precision(
        name="gravity-truncated",
        sentence="Gravity is 9.81 m/s^2 instead of 9.8125 m/s^2.",
        on=("hanging",),
        method="suzuki",
        levels=6,
        sees=("error", "x"),
        before=of_elements(UniformGravity, g=scaled(9.81 / 9.8125)),
    ),
    precision(
        name="masses-five-digits",
        sentence="Masses are rounded to five digits when read.",
        on=("oscillator",),
        method="suzuki",
        levels=6,
        sees=("error", "x"),
        before=of_bodies(mass=lambda m: m * (1 + 3e-5)),
    ),
    precision(
        name="sine-table",
        sentence="Sine and cosine are taken from a table.",
        on=("tumbler",),
        sees=("error", "attitude"),
        levels=6,
        inside=of_arguments(axis_turn=_tabled),
    ),
    precision(
        name="fixed-point",
        sentence="Positions are rounded to ten decimals.",
        on=("circler",),
        sees=("constraint", "length"),
        inside=of_results(drifted=_fixed_point),
    ),
    precision(
        name="normalised-loosely",
        sentence="Attitudes are normalised only when their norm differs from 1 by 1e-6.",
        on=("tumbler",),
        method="rk4",
        sees=("quaternion-norm", "norm"),
        levels=4,
        inside=_loosely_normalised,
    ),
)
