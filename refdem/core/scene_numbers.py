"""The numbers of a scene by their keys, and how they change with a number of a case.

A program has the numbers of its scene: `scene.bodies.0.mass` and all others with a key in
`request.txt`. A case has numbers of its own, such as a height or a restitution, and truth is
differentiated by these. With s the numbers of the scene, x the states that a program reports, and
q(x, p) the quantities of a case,

    dq/dp = sum over s of dq/dx dx/ds ds/dp + dq/dp at fixed x.

The program reports dx/ds; ds/dp and the two derivatives of q are central differences of order 6.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.parameters import Exact, Parameters
from refdem.core.problem_kinds import Motion
from refdem.core.trajectory import STATE, Trajectory
from refdem.errors import RefdemError
from refdem.scene import Scene
from refdem.scene.scene import encoded

Array = NDArray[np.float64]

APART = Fraction(1, 2**9)
"""Relative displacement h of a number for differences. Their error by truncation is h^6/140 = 2^-61
times the seventh derivative, and by one rounding of each value about 2^-52/h = 2^-43.
"""
WEIGHTS = {1: 45.0, 2: -9.0, 3: 1.0}
"""60 h f' = sum of w_k (f(k h) - f(-k h)), with an error of order h^6."""
WIDTHS = {"position": 3, "velocity": 3, "attitude": 4, "omega": 3}
"""Components of each column of a state, in the order of the derivatives of a state."""
STATES = sum(WIDTHS.values())
"""Components of the state of a body."""
ROUNDINGS = 8.0 * 2.0**-53
"""Error of a difference of WEIGHTS by rounding, for numbers of size 1: 110/60 times the roundings
of a number that is observed, four of them.
"""
BEST_STEP = 2.0 ** (-53 / 3)
"""u^(1/3), the relative displacement at which a central difference of order 2 is most accurate."""


class CaseNumber(Protocol):
    """One number of a case, which may be set to other values."""

    @property
    def name(self) -> str:
        """The name of the number, for people."""

    def of(self, p: Mapping[str, Exact]) -> Fraction:
        """The exact value of the number."""

    def set_in(self, p: Parameters, value: Fraction) -> Parameters:
        """The parameters with another value of the number."""


def numbers_in(scene: Scene) -> dict[str, float]:
    """Every number of a scene that need not be whole, by its key in `request.txt`."""
    document = msgspec.json.decode(encoded(scene.document(np.inf)))
    return dict(_leaves("scene", document))


def _leaves(key: str, value: Any) -> list[tuple[str, float]]:
    """The floats at a key of a document and below it."""
    if isinstance(value, float):
        return [(key, value)]
    entries: Any = ()
    if isinstance(value, dict):
        entries = value.items()
    if isinstance(value, list):
        entries = enumerate(value)
    return [leaf for name, entry in entries for leaf in _leaves(f"{key}.{name}", entry)]


def slope(value_at: Callable[[int], Any]) -> Any:
    """The derivative at k = 0 of a function of k = -3 ... 3, by the central difference WEIGHTS."""
    # f' = (45 (f_1 - f_-1) - 9 (f_2 - f_-2) + (f_3 - f_-3))/60.
    total: Any = 0.0
    for k, weight in WEIGHTS.items():
        total = total + weight * (value_at(k) - value_at(-k))
    return total / 60.0


def scene_rates(instance: Instance, p: Parameters, number: CaseNumber) -> dict[str, float] | None:
    """The derivatives ds/dp of the numbers s of the scene by a number p of the case that are not 0,
    by the key of s.

    None if there is no scene for some of the displaced numbers p, or one with other keys.
    """
    value = number.of(p)
    distance = APART * Fraction(_unit(p, number))
    scenes = {}
    try:
        for k in range(-3, 4):
            problem = instance.case.problem(number.set_in(p, value + k * distance))
            assert isinstance(problem, Motion)
            scenes[k] = numbers_in(problem.scene)
    except (RefdemError, ArithmeticError, ValueError):
        return None
    keys = scenes[0].keys()
    if any(scene.keys() != keys for scene in scenes.values()):
        return None
    places = list(keys)
    table = {k: np.array([scene[key] for key in places]) for k, scene in scenes.items()}
    # ds/dp by the central difference of order 6 over p - 3 d, ..., p + 3 d.
    changes = slope(table.__getitem__) / float(distance)
    rates = dict(zip(places, changes.tolist(), strict=True))
    return {key: rate for key, rate in rates.items() if rate}


def known_rates(
    instance: Instance, p: Parameters, number: CaseNumber, *, start_only: bool
) -> dict[str, float] | None:
    """The derivatives ds/dp of `scene_rates`; None also if `start_only` and the number changes more
    than the initial states, by which alone the method then differentiates.
    """
    rates = scene_rates(instance, p, number)
    if rates is None:
        return None
    if start_only and not all(is_of_start(key) for key in rates):
        return None
    return rates


def is_of_start(key: str) -> bool:
    """True for a number of the state of a body, such as `scene.bodies.0.position.1`."""
    words = key.split(".")
    return words[1] == "bodies" and words[3] in STATE


def keys_of(rates: Mapping[str, Mapping[str, float] | None], scene: Scene) -> tuple[str, ...]:
    """The numbers of a scene on which some number of the case acts, in their order."""
    acting = {key for of_number in rates.values() for key in of_number or ()}
    return tuple(key for key in numbers_in(scene) if key in acting)


def tangent(run: Trajectory, rates: Mapping[str, float]) -> Array:
    """The derivative of the states (T, N, STATES) by a number of the case: sum dx/ds ds/dp."""
    total = np.zeros((*run.position.shape[:2], STATES))
    for key, rate in rates.items():
        total += rate * run.derivatives[key]
    return total


def observed_slopes(
    instance: Instance,
    p: Parameters,
    number: CaseNumber,
    run: Trajectory,
    rates: Mapping[str, float],
) -> dict[str, Array]:
    """The derivative (T,) of every quantity q that is computed from states x, from the derivatives
    dx/dp of the run: d/de of q(x + e dx/dp, p + e) at e = 0.
    """
    change = tangent(run, rates)
    value = number.of(p)
    distance = Fraction(_distance(instance, change, _unit(p, number)))

    def observed(k: int) -> dict[str, Array]:
        """The quantities at k distances from the run."""
        moved = number.set_in(p, value + k * distance)
        return instance.case.observe(moved, displaced(run, k * float(distance) * change))

    shown = {k: observed(k) for k in range(-3, 4)}
    slopes = {}
    for name, quantity in instance.quantities.items():
        if name not in shown[0]:
            continue
        away = {k: displaced_values[name] - shown[0][name] for k, displaced_values in shown.items()}
        if quantity.angle:
            # The representative of the difference in [-pi, pi).
            away = {k: np.remainder(by + np.pi, 2 * np.pi) - np.pi for k, by in away.items()}
        slopes[name] = slope(away.__getitem__) / float(distance)
    return slopes


def rounding_of_slopes(
    instance: Instance,
    p: Parameters,
    number: CaseNumber,
    run: Trajectory,
    rates: Mapping[str, float],
) -> float:
    """Error of observed slopes by rounding, in scales of a quantity over the unit of the number.

    With numbers of size X in units of their scales, rounded by u X, the error of a difference over
    a distance d is ROUNDINGS X/d. It is larger for a number that changes the motion by a small part
    of its scales only, and for positions far from the origin.
    """
    distance = _distance(instance, tangent(run, rates), _unit(p, number))
    return ROUNDINGS * _largest(instance, p, run) / distance


def rounding_of_differences(
    instance: Instance,
    p: Parameters,
    run: Trajectory,
    rates: Mapping[str, float],
    noise: float,
) -> float:
    """Error of derivatives that a program takes by central differences of its own runs, which have
    a relative `noise`, in scales of a quantity over the unit of a number with these `rates`.

    With the best displacement h = u^(1/3) |s| of a number s (u^(1/3) if s is 0), rounding and the
    third derivative cause an error noise X/h, where X is the largest state in units of its scale.
    """
    # noise X sum |ds/dp|/(u^(1/3) |s|).
    numbers = numbers_in(instance.scene)
    steps = sum(abs(rate) / (abs(numbers[key]) or 1.0) for key, rate in rates.items())
    return noise * _largest(instance, p, run) * steps / BEST_STEP


def _largest(instance: Instance, p: Parameters, run: Trajectory) -> float:
    """The largest number of a run, of its states and its quantities, in units of their scales; 1 if
    that is less.
    """
    scales = instance.scales
    sizes = [1.0]
    units = {"position": scales.length, "velocity": scales.speed, "omega": 1.0 / scales.tau}
    for name, unit in units.items():
        sizes.append(float(np.max(np.abs(getattr(run, name)), initial=0.0)) / unit)
    for name, values in instance.case.observe(p, run).items():
        if name in instance.quantities:
            sizes.append(float(np.max(np.abs(values))) / instance.quantities[name].scale)
    return max(sizes)


def displaced(run: Trajectory, change: Array) -> Trajectory:
    """The states of a run moved by a change (T, N, STATES); channels and derivatives are left
    out.
    """
    columns: dict[str, Any] = {"channels": {}, "derivatives": {}}
    first = 0
    for name in STATE:
        last = first + WIDTHS[name]
        columns[name] = getattr(run, name) + change[..., first:last]
        first = last
    return replace(run, **columns)


def _unit(p: Parameters, number: CaseNumber) -> float:
    """The size |p| of a number, or 1 if it is 0. That of an angle is at most 1 rad, since a
    function of an angle varies over a radian however many turns the angle has.
    """
    size = abs(float(number.of(p))) or 1.0
    if p.declared[number.name.split(".")[0]].unit == "rad":
        size = min(size, 1.0)
    return size


def _distance(instance: Instance, change: Array, unit: float) -> float:
    """The distance by which a number is moved for differences of what is observed: APART of the
    number, and less where states would move by more than APART of their scales.
    """
    # APART/max(1/|p|, max |dx/dp|/scale) = min(APART |p|, APART scale/max |dx/dp|).
    scales = instance.scales
    sizes = np.repeat(
        [scales.length, scales.speed, 1.0, 1.0 / scales.tau], [WIDTHS[name] for name in STATE]
    )
    fastest = float(np.max(np.abs(change) / sizes, initial=0.0))
    return float(APART) / max(1.0 / unit, fastest)
