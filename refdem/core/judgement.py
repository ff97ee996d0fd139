"""From measured values to findings: errors against truth in units of each quantity's scale, and the
verdict itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.check import Subject
from refdem.core.engine import Method
from refdem.core.finding import Finding, Outcome, Series
from refdem.core.problem import Motion
from refdem.core.refinement import HORIZON, kinked
from refdem.core.statics import Static
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.errors import EngineError

Array = NDArray[np.float64]

PERTURBED = 64
"""A start moved by so many units in the last place shows how errors grow."""
SMALL = 0.25
"""Errors above this part of the scale have no order: the motion is another one."""
MORE = 8.0
"""One perturbation stands for all: others may grow by this factor more."""
MOST_POINTS = 256
"""Points that a curve in a record keeps; the largest value of each stretch is the one that is kept.
"""


ATTITUDE = tuple(f"attitude.{axis}" for axis in "wxyz")
"""The quantities that are compared together as one rotation."""
ROOM = 4.0
"""An error may be so many times what its order makes of it at another step. A pair of steps shows
an error to within a few per cent where it falls with order p; with ROOM a motion passes whose last
pair shows an order as low as 0.3, 0.8 and 2.2 for p = 1, 2, 4."""
ROOM_OF_KINKS = 64.0
"""ROOM where kinks scatter the error: two steps whose errors are alike to 1/64 by chance, and alike
to 1/64 of 2^p to those of the step before, are one in ten thousand if the scatter is an octave."""
ROOM_OF_CUTS = 16.0
"""The same of a method that cuts its steps at kinks: what is left to chance is the length of the
last piece.
"""
SHARP = 0.1
"""A bound above this part of the signal decides nothing: a body that never moves would pass it."""


@dataclass(frozen=True)
class Sight:
    """A bound and the signal beside it, in the same unit: how far the judged quantity moves.

    A signal of 0 is that of a law which holds the quantity to a constant; such a law always
    decides.
    """

    bound: float
    signal: float

    @property
    def sharpness(self) -> float | None:
        """The bound over the signal; None without a signal."""
        if self.signal > 0:
            return self.bound / self.signal
        return None

    @property
    def is_blind(self) -> bool:
        """The bound is above a tenth of the signal."""
        return self.bound > SHARP * self.signal > 0


def sharpest(bounds: Array, signal: Array) -> Sight:
    """The sight at the sample where the bound is the smallest part of what has moved so far.

    `bounds` and `signal` are (T,), in one unit; the signal counts as its largest value so far.
    """
    so_far = np.maximum.accumulate(signal)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(so_far > 0, bounds / so_far, np.inf)
    point = int(np.argmin(part))
    return Sight(float(bounds[point]), float(so_far[point]))


def judged(
    *,
    check: str,
    quantity: str,
    value: float,
    bound: float,
    unit: str,
    basis: str,
    what: str = "",
    statement: str = "",
    sight: Sight | None = None,
    **more: Any,
) -> Finding:
    """The finding for `value <= bound`; a value that is not a number fails.

    `what` names the measured value and is the subject of the sentence; `statement` replaces the
    whole comparison where the value reads better in other words. Where the bound is above a tenth
    of the signal, a value within it is undecided; one above it fails all the same.
    """
    holds = bool(value <= bound)
    blind = sight is not None and sight.is_blind
    statement = statement or f"{what} is {_compared(value, bound, unit)}"
    sentence = f"{statement}. Basis: {basis}."
    if holds:
        outcome: Outcome = "pass"
    else:
        outcome = "fail"
    if holds and sight is not None and blind:
        outcome = "undecided"
        sentence = (
            f"Not decided: the bound {sight.bound:.2g} exceeds a tenth of the signal"
            f" {sight.signal:.2g}. {sentence}"
        )
    sharpness = None
    if sight is not None:
        sharpness = sight.sharpness
    return Finding(
        check=check,
        quantity=quantity,
        outcome=outcome,
        sentence=sentence,
        value=float(value),
        bound=float(bound),
        unit=unit,
        basis=basis,
        sharpness=sharpness,
        **more,
    )


def _compared(value: float, bound: float, unit: str) -> str:
    """The value with its unit and how it compares with the bound, as the end of a sentence."""
    size = f"{value:.2g}"
    limit = f"{bound:.2g}"
    if unit != "1":
        size = f"{size} {unit}"
        limit = f"{limit} {unit}"
    if value <= bound:
        return f"{size}, within the bound {limit}"
    if value > bound:
        return f"{size}, above the bound {limit}"
    return f"not a number (the bound is {limit})"


def order_statement(
    seen: float, claimed: float, deficit: float, tolerance: float, detail: str
) -> str:
    """The comparison of an observed order with the claimed one, as a sentence without its stop.

    `deficit` is what decides: claimed less observed order, or its limit for small steps. `detail`
    says from what the order was observed.
    """
    observed = f"Observed order {seen:.2f} ({detail})"
    if not deficit <= tolerance:
        return (
            f"{observed} is below the claimed {claimed:g} by {deficit:.2g} (tolerance"
            f" {tolerance:.2g})"
        )
    if claimed - seen > tolerance:
        return (
            f"{observed} approaches the claimed {claimed:g} (extrapolated deficit {deficit:.2g},"
            f" tolerance {tolerance:.2g})"
        )
    return f"{observed} meets the claimed {claimed:g} (tolerance {tolerance:.2g})"


def worst(
    *,
    check: str,
    quantity: str,
    t: Array,
    values: Array,
    allowed: Array | float,
    signal: Array | float | None = None,
    **more: Any,
) -> Finding:
    """The finding at the sample that comes nearest to its bound, with the whole curve.

    `signal`, a number or (T,), is how far the quantity has moved; see `Sight`.
    """
    bounds = np.broadcast_to(np.asarray(allowed, float), values.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(np.isnan(values), np.inf, np.where(values > 0, values / bounds, 0.0))
    point = int(np.argmax(ratio))
    series = curve(t, values, bounds)
    if signal is None:
        sight = None
    else:
        sight = sharpest(bounds, np.broadcast_to(np.asarray(signal, float), values.shape))
    value = float(values[point])
    bound = float(bounds[point])
    return judged(
        check=check, quantity=quantity, value=value, bound=bound, series=series, sight=sight, **more
    )


def undecided(check: str, quantity: str, why: str) -> Finding:
    """A finding that decides nothing, with the reason."""
    return Finding(
        check=check, quantity=quantity, outcome="undecided", sentence=f"Not decided: {why}."
    )


MIXED = "every quantity combines positions with velocities, which are half a step early"


def certified(subject: Subject) -> SampledTruth | None:
    """The truth if at least two samples of it (or the only one) are certified."""
    least = min(2, len(subject.instance.times))
    if subject.truth is not None and subject.truth.until >= least:
        return subject.truth
    return None


def no_truth(subject: Subject) -> str:
    """The reason why there is no truth to compare with."""
    reason = subject.truth_reason
    if not reason and subject.truth:
        reason = subject.truth.reason
    return reason or "no certified truth"


def errors(
    instance: Instance, trajectory: Trajectory, truth: SampledTruth, delay: float = 0.0
) -> dict[str, Array]:
    """Error (until,) of every quantity against truth, in units of its scale, less the radius that
    truth itself has.

    Angles modulo 2 pi; the components of an attitude together as the angle of one rotation. Where
    velocities lag by
    `delay` [s], quantities made of them are compared with truth at their own time, and those that
    mix both are left out: none may be left. Raises EngineError if the trajectory shows nothing that
    can be compared.
    """
    observed = instance.observe(trajectory)
    if not delay:
        return _errors(instance, observed, truth)
    by_velocity, by_position = _made_of(instance, trajectory)
    placed = {name: values for name, values in observed.items() if name not in by_velocity}
    if placed:
        found = _errors(instance, placed, truth)
    else:
        found = {}
    late = {name: values for name, values in observed.items() if name in by_velocity - by_position}
    if late:
        found |= _errors(instance, late, truth.delayed(delay))
    return found


def _made_of(instance: Instance, trajectory: Trajectory) -> tuple[set[str], set[str]]:
    """Names of the quantities that change with velocities, and of those that change with
    positions.
    """
    from refdem.mechanics.quaternion import product

    plain = instance.observe(trajectory)
    moved = []
    turn = np.array([0.4, 0.1, 0.5, 0.3]) / np.sqrt(0.51)
    for names in (("velocity", "omega"), ("position", "attitude")):
        other: dict[str, Any] = {}
        for name in names:
            values = getattr(trajectory, name)
            if name == "attitude":
                other[name] = product(turn, values)
            else:
                other[name] = 1.5 * values + 0.25
        moved.append(instance.observe(replace(trajectory, **other)))
    by_velocity, by_position = (
        {name for name in plain if np.any(plain[name] != seen[name])} for seen in moved
    )
    return by_velocity, by_position


def _errors(
    instance: Instance, observed: dict[str, Array], truth: SampledTruth
) -> dict[str, Array]:
    """`errors` of what was observed, all of it at the samples of this truth."""
    until = truth.until
    found: dict[str, Array] = {}
    for name, values in observed.items():
        quantity = instance.quantities[name]
        if quantity.group or name not in truth.values:
            continue
        difference = values[:until] - truth.value(name)
        if quantity.angle:
            difference = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        found[name] = np.maximum(0.0, np.abs(difference) - truth.radius(name)) / quantity.scale
    if all(name in observed and name in truth.values for name in ATTITUDE):
        found["attitude"] = _rotation_error(observed, truth)
    if not found:
        raise EngineError(
            "the trajectory shows none of the quantities of the case; expected "
            + ", ".join(instance.quantities)
        )
    return found


def _rotation_error(observed: dict[str, Array], truth: SampledTruth) -> Array:
    """Angle (until,) [rad] between observed and true attitude, less the radius of the truth."""
    from refdem.mechanics.quaternion import angle_between

    seen = np.stack([observed[name][: truth.until] for name in ATTITUDE], axis=-1)
    seen = seen / np.linalg.norm(seen, axis=-1, keepdims=True)
    true = np.stack([truth.value(name) for name in ATTITUDE], axis=-1)
    radius = 2.0 * np.max([truth.radius(name) for name in ATTITUDE], axis=0)
    error: Array = np.maximum(0.0, angle_between(seen, true) - radius)
    return error


def movements(instance: Instance, truth: SampledTruth) -> dict[str, Array]:
    """How far the truth of every quantity is from its start (until,), in units of its scale: the
    signal beside `errors`.

    Angles modulo 2 pi, the components of an attitude together as the angle of one rotation [rad].
    The answer to a question without time does not move: there it is the size of the number itself.
    """
    found: dict[str, Array] = {}
    for name, quantity in instance.quantities.items():
        if quantity.group or name not in truth.values:
            continue
        values = truth.value(name)
        if isinstance(instance.problem, Static):
            away = values
        else:
            away = values - values[0]
        if quantity.angle:
            away = np.remainder(away + np.pi, 2 * np.pi) - np.pi
        found[name] = np.abs(away) / quantity.scale
    if all(name in truth.values for name in ATTITUDE):
        from refdem.mechanics.quaternion import angle_between

        true = np.stack([truth.value(name) for name in ATTITUDE], axis=-1)
        found["attitude"] = angle_between(true, np.broadcast_to(true[0], true.shape))
    return found


def predictable(scaled: Mapping[str, Array]) -> int:
    """Number of samples before any of these errors (until,) by quantity first exceeds SMALL."""
    largest = np.maximum.reduce(list(scaled.values()))
    beyond = np.flatnonzero(~(largest <= SMALL))
    if len(beyond):
        return int(beyond[0])
    return len(largest)


def followed(
    subject: Subject, level: float, run: Trajectory, truth: SampledTruth, within: float = HORIZON
) -> int:
    """Number of samples before a run first is that part of the scale from truth: S tells of the
    true motion, not of another.
    """
    off = errors(subject.instance, run, truth, subject.method.delay(level))
    largest = np.maximum.reduce([np.zeros(truth.until), *off.values()])
    beyond = np.flatnonzero(~(largest <= within))
    if len(beyond):
        return int(beyond[0])
    return len(largest)


def largest_so_far(subject: Subject, level: float, run: Trajectory, truth: SampledTruth) -> Array:
    """The largest error of any quantity against truth up to each sample (until,), in units of the
    scales.
    """
    off = errors(subject.instance, run, truth, subject.method.delay(level))
    largest = np.maximum.reduce([np.zeros(truth.until), *off.values()])
    so_far: Array = np.maximum.accumulate(largest)
    return so_far


def room_of(subject: Subject) -> float:
    """How many times an error may be what it is at another step: ROOM, and more where kinks scatter
    it.
    """
    if not kinked(subject.instance):
        return ROOM
    if subject.method.locates_events:
        return ROOM_OF_CUTS
    return ROOM_OF_KINKS


def signed(subject: Subject, run: Trajectory, truth: SampledTruth, count: int) -> Array:
    """Differences (parts, count) from truth with their signs, in units of their scales; angles
    modulo 2 pi.

    An attitude counts as the vector [rad] of the small turn from the true one, in body axes.
    """
    observed = subject.instance.observe(run)
    found = []
    for name, values in observed.items():
        quantity = subject.instance.quantities[name]
        if quantity.group or name not in truth.values:
            continue
        difference = values[:count] - truth.value(name)[:count]
        if quantity.angle:
            difference = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        found.append(difference / quantity.scale)
    parts = [f"attitude.{axis}" for axis in "wxyz"]
    if all(name in observed and name in truth.values for name in parts):
        found += list(_small_turns(observed, truth, parts, count))
    return np.array(found)


def _small_turns(
    observed: dict[str, Array], truth: SampledTruth, parts: list[str], count: int
) -> Array:
    """Vectors (3, count) [rad] of the turn from the true attitude to the observed one: 2 vec(q* p),
    of q and -q the nearer.
    """
    from refdem.mechanics.quaternion import product

    seen = np.stack([observed[name][:count] for name in parts], axis=-1)
    seen = seen / np.linalg.norm(seen, axis=-1, keepdims=True)
    true = np.stack([truth.value(name)[:count] for name in parts], axis=-1)
    conjugate = true * np.array([1.0, -1.0, -1.0, -1.0])
    between = product(conjugate, seen)
    nearer = np.where(between[:, :1] < 0, -between, between)
    turns: Array = 2.0 * nearer[:, 1:].T
    return turns


def left_at_finest(subject: Subject, coarse: Array) -> float:
    """What the claimed order leaves at the finest level of an error (T,) that the coarsest level
    shows; infinite if it says nothing.

    With an error C h^p it is 2^-p for every halving of the step, and ROOM times that where terms of
    higher order still count. Kinks scatter C from step to step; round-off, which does not fall, is
    the caller's to add.
    """
    if (
        subject.method.control != "step"
        or kinked(subject.instance)
        or not np.all(np.isfinite(coarse))
    ):
        return float(np.inf)
    order = subject.order
    octaves = float(np.log2(subject.levels[0] / subject.levels[-1]))
    return float(ROOM * np.max(coarse) / 2.0 ** (order * octaves))


def distances(instance: Instance, a: Trajectory, b: Trajectory) -> Array:
    """Largest difference (T,) of any state of any body between two runs, each column in its scale;
    of any quantity without a scene.
    """
    if not isinstance(instance.problem, Motion):
        one = instance.observe(a)
        other = instance.observe(b)
        apart: Array = np.maximum.reduce(
            [np.abs(one[name] - other[name]) / q.scale for name, q in instance.quantities.items()]
        )
        return apart
    scales = instance.scales
    bodies = instance.scene.bodies
    spin = float(np.max(np.linalg.norm(bodies.omega, axis=1))) or 1.0 / scales.tau
    parts = [
        np.abs(a.position - b.position).max(axis=(1, 2)) / scales.length,
        np.abs(a.velocity - b.velocity).max(axis=(1, 2)) / scales.speed,
    ]
    if "rotation" in instance.scene.features:
        from refdem.mechanics.quaternion import angle_between

        turns = bodies.inertia.any(axis=1)
        parts.append(np.abs(a.omega - b.omega).max(axis=(1, 2)) / spin)
        parts.append(
            angle_between(a.attitude[:, turns], b.attitude[:, turns]).max(axis=1, initial=0.0)
        )
    largest: Array = np.maximum.reduce(parts)
    return largest


def perturbation(method: Method) -> int:
    """Units in the last place by which a start is moved to show how errors grow: those of a double,
    a single one being 2^29.
    """
    return PERTURBED * round(method.round_off * 2.0**53)


def growth_shown(instance: Instance, method: Method, moved: Trajectory, base: Trajectory) -> Array:
    """How much an early error has grown (T,), as a start moved by `perturbation` shows it: what
    stands in for S without truth.
    """
    shown = distances(instance, moved, base) / (perturbation(method) * 2.0**-52)
    return np.maximum.accumulate(np.maximum(1.0, MORE * shown))


def curve(t: Array, value: Array, bound: Array | float) -> Series:
    """A curve of at most MOST_POINTS points that keeps the largest value of each stretch."""
    bound = np.broadcast_to(np.asarray(bound, float), value.shape)
    pick = np.arange(len(value))
    if len(value) > MOST_POINTS:
        pick = np.array(
            [part[np.argmax(value[part])] for part in np.array_split(pick, MOST_POINTS)]
        )
    return Series(t=t[pick].tolist(), value=value[pick].tolist(), bound=bound[pick].tolist())
