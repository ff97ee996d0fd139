"""Iterated maps in plain Python, into which faults are planted: the logistic map and equation,
Lorenz' equations, billiards bounce by bounce.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, exp, hypot, inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.maps import Billiard, Logistic, LogisticFlow, LorenzFlow, StadiumBilliard
from refdem.core.problem import Iteration
from refdem.core.trajectory import Trajectory

State = tuple[float, ...]
Pair = tuple[float, float]
LORENZ_ORDER = 20
"""Order of the Taylor series of Lorenz' equations."""
LORENZ_STEP = 1 / 64
"""Longest step of the series. The terms beyond the order are below one unit in the last place; with
steps of 1/32 they are up to 600.
"""


def logistic(x: float, eta: float) -> float:
    """The next iterate of the logistic map: eta x (1 - x)."""
    return eta * x * (1.0 - x)


def logistic_flow(x: float, eta: float) -> float:
    """The solution of x' = eta x (1 - x) one unit of time later: x/(x + (1 - x) exp(-eta))."""
    return x / (x + (1.0 - x) * exp(-eta))


def lorenz_rates(state: State, xy: float, xz: float, flow: LorenzFlow) -> State:
    """The rates of x, y and z, from their values and the products x y and x z.

    x' = sigma (y - x), y' = rho x - x z - y, z' = x y - beta z. The rates are linear in these five
    numbers, so that coefficients of series may take the place of values.
    """
    x, y, z = state
    return flow.sigma * (y - x), flow.rho * x - xz - y, xy - flow.beta * z


def _cauchy(a: list[float], b: list[float]) -> float:
    """Coefficient n of the product of two series with coefficients 0 to n: sum a_k b_(n-k)."""
    return sum(left * right for left, right in zip(a, reversed(b), strict=True))


def _lorenz_step(state: State, h: float, flow: LorenzFlow, parts: "MapParts") -> State:
    """The state of Lorenz' equations a time h later, by a Taylor series."""
    x, y, z = ([value] for value in state)
    for k in range(LORENZ_ORDER):
        # (k + 1) x_(k+1) = coefficient k of the rate of x.
        at_k = (x[k], y[k], z[k])
        rates = parts.lorenz_rates(at_k, _cauchy(x, y), _cauchy(x, z), flow)
        for series, rate in zip((x, y, z), rates, strict=True):
            series.append(rate / (k + 1))
    after = []
    for series in (x, y, z):
        # Horner's rule.
        value = 0.0
        for coefficient in reversed(series):
            value = value * h + coefficient
        after.append(value)
    return tuple(after)


def _lorenz_flow(state: State, flow: LorenzFlow, parts: "MapParts") -> State:
    """The state of Lorenz' equations one interval later."""
    steps = ceil(flow.interval / LORENZ_STEP)
    for _ in range(steps):
        state = _lorenz_step(state, flow.interval / steps, flow, parts)
    return state


def ahead(place: Pair, direction: Pair, table: Billiard) -> float:
    """The distance along the path to the next straight wall, the smaller one of both axes."""
    to_side = _distance(place[0], direction[0], table.width / 2)
    to_end = _distance(place[1], direction[1], table.height / 2)
    return min(to_side, to_end)


def _distance(x: float, u: float, half: float) -> float:
    """The length of the path to the wall at +-`half` along one axis, from the coordinate x with the
    direction cosine u; infinite for u = 0.
    """
    if not u:
        return inf
    if u > 0:
        return (half - x) / u
    return (-half - x) / u


def straight_normal(place: Pair, table: Billiard) -> Pair:
    """The outward normal at a point on a straight wall, that of the nearest wall."""
    from_x = table.width / 2 - abs(place[0])
    from_y = table.height / 2 - abs(place[1])
    if from_x < from_y:
        return (_side(place[0]), 0.0)
    return (0.0, _side(place[1]))


def _side(x: float) -> float:
    """1 for a place on the positive side of the middle, -1 for any other."""
    if x > 0:
        return 1.0
    return -1.0


def centre(table: Billiard) -> float:
    """The x coordinate of the centre of the right half circle, (width - height)/2."""
    return (table.width - table.height) / 2


def reflected(direction: Pair, normal: Pair) -> Pair:
    """The direction after the bounce, u - 2 (u . n) n."""
    along = direction[0] * normal[0] + direction[1] * normal[1]
    return direction[0] - 2.0 * along * normal[0], direction[1] - 2.0 * along * normal[1]


def settled(state: State) -> State:
    """The state from which the next iterate is computed, with the direction normalised."""
    has_direction = len(state) == 4
    if not has_direction:
        return state
    x, y, u, v = state
    return x, y, u / hypot(u, v), v / hypot(u, v)


@dataclass(frozen=True)
class MapParts:
    """The parts of iterated maps, by name."""

    logistic: Callable[..., Any] = logistic
    logistic_flow: Callable[..., Any] = logistic_flow
    lorenz_rates: Callable[..., Any] = lorenz_rates
    ahead: Callable[..., Any] = ahead
    straight_normal: Callable[..., Any] = straight_normal
    centre: Callable[..., Any] = centre
    reflected: Callable[..., Any] = reflected
    settled: Callable[..., Any] = settled


CORRECT_MAPS = MapParts()


def iterated(problem: Iteration, parts: MapParts) -> Trajectory:
    """The requested iterates of the map, as a trajectory."""
    requested = set(problem.times.astype(int).tolist())
    state = tuple(problem.start.tolist())
    rows = []
    for n in range(problem.n + 1):
        if n:
            state = parts.settled(_next(state, problem.map, parts))
        if n in requested:
            rows.append(state)
    return Trajectory.of_values(problem.times, _values(np.array(rows), problem.map))


def _values(rows: NDArray[np.float64], rule: Any) -> dict[str, NDArray[np.float64]]:
    """The iterates (T, D) of a map, the `rule`, under the names that a trajectory has for them."""
    if isinstance(rule, Billiard):
        return {"position": rows[:, :2].copy(), "direction": rows[:, 2:].copy()}
    if isinstance(rule, LorenzFlow):
        return {"state": rows}
    return {"x": rows[:, 0].copy()}


def _next(state: State, rule: Any, parts: MapParts) -> State:
    """The next iterate of a map, the `rule`; of a billiard place and direction after the next
    bounce.
    """
    if isinstance(rule, LogisticFlow):
        return (parts.logistic_flow(state[0], rule.eta),)
    if isinstance(rule, LorenzFlow):
        return _lorenz_flow(state, rule, parts)
    if isinstance(rule, Logistic):
        return (parts.logistic(state[0], rule.eta),)
    place = (state[0], state[1])
    direction = (state[2], state[3])
    hit, normal = _bounce(place, direction, rule, parts)
    return (*hit, *parts.reflected(direction, normal))


def _bounce(place: Pair, direction: Pair, table: Billiard, parts: MapParts) -> tuple[Pair, Pair]:
    """The place on the wall that is met next, and the normal there."""
    # The point at which the path meets the straight walls or their extensions.
    distance = parts.ahead(place, direction, table)
    hit = (place[0] + distance * direction[0], place[1] + distance * direction[1])
    if isinstance(table, StadiumBilliard):
        # Beyond the ends of the straight walls of a stadium the path meets a half circle; a path
        # parallel to the walls always does.
        centre = parts.centre(table)
        if abs(hit[0]) > centre or not direction[1]:
            return _on_arc(place, direction, table, centre * _side(hit[0]))
    normal = parts.straight_normal(hit, table)
    # A straight wall runs along one axis: the other coordinate is that of the wall.
    if normal[0]:
        hit = (normal[0] * (table.width / 2), hit[1])
    if normal[1]:
        hit = (hit[0], normal[1] * (table.height / 2))
    return hit, normal


def _on_arc(place: Pair, direction: Pair, table: Billiard, middle: float) -> tuple[Pair, Pair]:
    """The point at which the path meets the half circle about (middle, 0), and the normal there."""
    r = table.height / 2
    x = place[0] - middle
    y = place[1]
    u, v = direction
    # |(x, y) + s (u, v)| = r has the larger root s = -b + sqrt(b^2 - c) for a unit direction, with
    # b = x u + y v and c = x^2 + y^2 - r^2. By rounding b^2 - c may be below 0 for a tangent.
    b = x * u + y * v
    c = x * x + y**2 - r * r
    s = -b + sqrt(max(0.0, b * b - c))
    n = ((x + s * u) / r, (y + s * v) / r)
    # Normalised, so that the point is on the circle to round-off.
    n = (n[0] / hypot(*n), n[1] / hypot(*n))
    return (middle + r * n[0], r * n[1]), n
