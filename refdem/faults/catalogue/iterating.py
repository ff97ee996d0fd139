"""Maps: a wrong branch, wall, rate or reflection, state that is rounded between iterates; and
energy fed into a regular motion.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf
from typing import Any

import msgspec
import numpy as np

from refdem.core.maps import LorenzFlow
from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import Inside, of_arguments, of_parts, within
from refdem.faults.fault import Fault
from refdem.faults.iterating import CORRECT_MAPS
from refdem.mechanics import vectors as vec

mapped = partial(Fault, kind="map", method="iterated")
PLACE = ("error", "position.x")


def _with(**changed: Callable[..., Any]) -> Inside:
    """Some parts of the maps replaced."""
    return within("maps", of_parts(**changed))


def _late(request: Request, run: Trajectory) -> Trajectory:
    """Every iterate but the first is the one before it."""
    values = {name: np.concatenate((x[:1], x[:-1])) for name, x in run.values.items()}
    return replace(run, values=values)


def _rounded(state: tuple[float, ...]) -> tuple[float, ...]:
    """The state rounded to six decimals."""
    return tuple(round(x, 6) for x in CORRECT_MAPS.settled(state))


def _printed(state: tuple[float, ...]) -> tuple[float, ...]:
    """The state rounded to three decimals."""
    return tuple(round(x, 3) for x in state)


def _shrinking(state: tuple[float, ...]) -> tuple[float, ...]:
    """The direction is shortened by one part in 1e12 at every bounce."""
    x, y, u, v = state
    return x, y, u * (1 - 1e-12), v * (1 - 1e-12)


def _short_reflection(
    direction: tuple[float, float], normal: tuple[float, float]
) -> tuple[float, float]:
    """u - 1.9 (u . n) n in place of u - 2 (u . n) n."""
    along = direction[0] * normal[0] + direction[1] * normal[1]
    return direction[0] - 1.9 * along * normal[0], direction[1] - 1.9 * along * normal[1]


def _lossy_reflection(
    direction: tuple[float, float], normal: tuple[float, float]
) -> tuple[float, float]:
    """A reflection by a wall whose normal is along y reduces |vy| by a billionth."""
    u, v = CORRECT_MAPS.reflected(direction, normal)
    return u, v * (1.0 - 1e-9 * abs(normal[1]))


def _tilted_reflection(
    direction: tuple[float, float], normal: tuple[float, float]
) -> tuple[float, float]:
    """u - 2 (u . n) n with normals n that are turned by 1e-12 rad."""
    turned = (normal[0] - 1e-12 * normal[1], normal[1] + 1e-12 * normal[0])
    reflected: tuple[float, float] = CORRECT_MAPS.reflected(direction, turned)
    return reflected


def _bent(share: float) -> Callable[[tuple[float, ...]], tuple[float, ...]]:
    """After each bounce at (x, y) the direction (u, v) is turned by the angle share x y [rad], to
    first order: the walls y = +-b act as weakly curved mirrors, and so do the walls x = +-a, of the
    opposite curvature.
    """

    def turned(state: tuple[float, ...]) -> tuple[float, ...]:
        x, y, u, v = CORRECT_MAPS.settled(state)
        angle = share * x * y
        return CORRECT_MAPS.settled((x, y, u - angle * v, v + angle * u))  # type: ignore[no-any-return]

    return turned


def _nearest_only(place: tuple[float, float], direction: tuple[float, float], table: Any) -> float:
    """The time to the walls x = +-a alone: the point flies through the walls y = +-b."""
    u = direction[0]
    half: float = table.width / 2
    if not u:
        return inf
    if u > 0:
        return (half - place[0]) / u
    return (-half - place[0]) / u


def _pushed(v: Any, force: Any, mass: Any, h: Any) -> Any:
    """A force 0.1 m v along the velocity is added, so that v' = F/m + 0.1 v gains energy."""
    return v, vec.plus(force, vec.times(0.1 * mass, v)), mass, h


def _growing_y(
    state: tuple[float, ...], xy: float, xz: float, flow: LorenzFlow
) -> tuple[float, ...]:
    """Lorenz' equations with y' = x (rho - z) + y."""
    x_rate, y_rate, z_rate = CORRECT_MAPS.lorenz_rates(state, xy, xz, flow)
    return x_rate, y_rate + 2.0 * state[1], z_rate


def _double_product(
    state: tuple[float, ...], xy: float, xz: float, flow: LorenzFlow
) -> tuple[float, ...]:
    """Lorenz' equations with z' = 2 x y - beta z."""
    rates: tuple[float, ...] = CORRECT_MAPS.lorenz_rates(state, 2.0 * xy, xz, flow)
    return rates


def _rounded_beta(
    state: tuple[float, ...], xy: float, xz: float, flow: LorenzFlow
) -> tuple[float, ...]:
    """Lorenz' equations with beta in four decimals."""
    coarse = msgspec.structs.replace(flow, beta=round(flow.beta, 4))
    rates: tuple[float, ...] = CORRECT_MAPS.lorenz_rates(state, xy, xz, coarse)
    return rates


FAULTS = (
    mapped(
        name="map-slope",
        sentence="x (1 - x) is taken as x - x^2 with the square rounded to single precision.",
        on=("chaotic-map",),
        sees=("error", "x_n"),
        inside=_with(logistic=lambda x, eta: eta * (x - float(np.float32(x * x)))),
    ),
    mapped(
        name="equation-as-map",
        sentence="The differential equation is advanced with the map.",
        on=("growth",),
        sees=("error", "x_n"),
        inside=_with(logistic_flow=CORRECT_MAPS.logistic),
    ),
    mapped(
        name="iterate-late",
        sentence="Every iterate is the previous one.",
        on=("chaotic-map", "growth"),
        sees=("error", "x_n"),
        after=_late,
    ),
    mapped(
        name="lorenz-sign",
        sentence="The rate of y has +y instead of -y.",
        on=("lorenz",),
        sees=("error", "y"),
        inside=_with(lorenz_rates=_growing_y),
    ),
    mapped(
        name="lorenz-product-twice",
        sentence="The rate of z contains the product x y twice.",
        on=("lorenz",),
        sees=("error", "z"),
        inside=_with(lorenz_rates=_double_product),
    ),
    mapped(
        name="lorenz-beta-rounded",
        sentence="The parameter beta is rounded to four decimals.",
        on=("lorenz",),
        sees=("error", "z"),
        inside=_with(lorenz_rates=_rounded_beta),
    ),
    mapped(
        name="iterates-six-digits",
        sentence="The state is rounded to six digits at every iterate.",
        on=("chaotic-map",),
        sees=("lyapunov", "class"),
        inside=_with(settled=_rounded),
    ),
    mapped(
        name="flow-three-decimals",
        sentence=(
            "A flow continues from its state rounded to three decimals, as in Lorenz' printout."
        ),
        on=("chaotic-lorenz",),
        sees=("lyapunov", "class"),
        inside=_with(settled=_printed),
    ),
    mapped(
        name="reflection-short",
        sentence=("The reflection subtracts less than twice the normal component of the velocity."),
        on=("stadium",),
        sees=PLACE,
        inside=_with(reflected=_short_reflection),
    ),
    mapped(
        name="half-circle-displaced",
        sentence=(
            "The centres of the half circles of a stadium are one part in a thousand too far"
            " inside."
        ),
        on=("stadium",),
        sees=("bounces", "wall"),
        inside=_with(centre=lambda table: 0.999 * CORRECT_MAPS.centre(table)),
    ),
    mapped(
        name="direction-shrinks",
        sentence="The direction vector becomes shorter at every bounce.",
        on=("stadium",),
        sees=("bounces", "speed"),
        inside=_with(settled=_shrinking),
    ),
    mapped(
        name="reflected-twice",
        sentence="At a bounce the direction is reversed.",
        on=("rectangle",),
        sees=PLACE,
        inside=_with(reflected=lambda u, n: (-u[0], -u[1])),
    ),
    mapped(
        name="not-reflected",
        sentence="The point passes through the wall.",
        on=("rectangle",),
        sees=("bounces", "inward"),
        inside=_with(reflected=lambda u, n: u),
    ),
    mapped(
        name="reflection-lossy",
        sentence="Walls along the table reduce |vy| by one part in 1e9 at every bounce.",
        on=("rectangle",),
        sees=("bounces", "kept.y"),
        inside=_with(reflected=_lossy_reflection),
    ),
    mapped(
        name="reflection-tilted",
        sentence="Walls reflect as if they were turned by 1e-12.",
        on=("rectangle",),
        sees=("bounces", "kept.x"),
        inside=_with(reflected=_tilted_reflection),
    ),
    mapped(
        name="stadium-tilted",
        sentence="Walls reflect as if they were turned by 1e-12.",
        on=("stadium",),
        sees=("bounces", "reflection"),
        inside=_with(reflected=_tilted_reflection),
    ),
    mapped(
        name="walls-bent",
        sentence="Straight walls reflect as if they had a radius of curvature of about 20 km.",
        on=("rectangle",),
        sees=("beam", "rate"),
        inside=_with(settled=_bent(1e-4)),
    ),
    mapped(
        name="stadium-walls-bent",
        sentence=("All walls of a stadium reflect as if their curvature were slightly different."),
        on=("stadium",),
        sees=("beam", "rate"),
        inside=_with(settled=_bent(1e-3)),
    ),
    mapped(
        name="one-pair-of-walls",
        sentence="The walls along the table are ignored.",
        on=("rectangle",),
        sees=("error", "position.y"),
        inside=_with(ahead=_nearest_only),
    ),
    Fault(
        name="pushed-along",
        kind="energy",
        sentence="A force in the direction of the velocity adds energy.",
        on=("long-oscillator",),
        sees=("lyapunov", "power"),
        inside=of_arguments(kicked=_pushed),
    ),
)
