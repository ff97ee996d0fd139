"""From measured values to findings: errors against truth in units of each quantity's scale, and the verdict itself."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.check import Trial
from refdem.core.engine import Method
from refdem.core.finding import Finding, Series
from refdem.core.problem import Motion
from refdem.core.trajectory import Trajectory
from refdem.core.truth import SampledTruth
from refdem.errors import EngineError

Array = NDArray[np.float64]

PERTURBED = 64
"""A start moved by so many units in the last place shows how errors grow."""
MORE = 8.0
"""One perturbation stands for all: others may grow by this factor more."""
MOST_POINTS = 256
"""Points that a curve in a record keeps; the largest value of each stretch is the one that is kept."""


def judged(*, check: str, quantity: str, value: float, bound: float, unit: str, basis: str, what: str, **more: Any) -> Finding:
    """The finding for `value <= bound`; a value that is not a number fails. `what` says in words what was measured."""
    holds = bool(value <= bound)
    size = "exactly 0" if value == 0 else f"{value:.2g}" + (f" {unit}" if unit != "1" else "")
    limit = "0" if bound == 0 else f"{bound:.2g}"
    sentence = f"{what} is {size}, {'within' if holds else 'beyond'} the bound {limit}: {basis}."
    return Finding(
        check=check,
        quantity=quantity,
        outcome="pass" if holds else "fail",
        sentence=sentence,
        value=float(value),
        bound=float(bound),
        unit=unit,
        basis=basis,
        **more,
    )


def worst(*, check: str, quantity: str, t: Array, values: Array, allowed: Array | float, **more: Any) -> Finding:
    """The finding at the sample that comes nearest to its bound, with the whole curve."""
    bounds = np.broadcast_to(np.asarray(allowed, float), values.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(np.isnan(values), np.inf, np.where(values > 0, values / bounds, 0.0))
    point = int(np.argmax(ratio))
    series = curve(t, values, bounds)
    return judged(check=check, quantity=quantity, value=float(values[point]), bound=float(bounds[point]), series=series, **more)


def undecided(check: str, quantity: str, why: str) -> Finding:
    """A finding that decides nothing, with the reason."""
    return Finding(check=check, quantity=quantity, outcome="undecided", sentence=f"Not decided: {why}.")


MIXED = "every quantity mixes places with velocities, which are half a step early"


def certified(trial: Trial) -> SampledTruth | None:
    """The truth if at least two samples of it (or the only one) are certified."""
    least = min(2, len(trial.instance.times))
    return trial.truth if trial.truth is not None and trial.truth.until >= least else None


def no_truth(trial: Trial) -> str:
    """Why there is nothing to compare with."""
    return trial.truth_reason or (trial.truth.reason if trial.truth else "") or "no certified truth"


def errors(instance: Instance, trajectory: Trajectory, truth: SampledTruth, delay: float = 0.0) -> dict[str, Array]:
    """Error (until,) of every quantity against truth, in units of its scale, less the radius that truth itself has.

    Angles modulo 2 pi; the components of an attitude together as the angle of one rotation. Where velocities lag by
    `delay` [s], quantities made of them are compared with truth at their own time, and those that mix both are left out: none
    may be left. Raises EngineError if the trajectory shows nothing that can be compared.
    """
    observed = instance.observe(trajectory)
    if not delay:
        return _errors(instance, observed, truth)
    by_velocity, by_position = _made_of(instance, trajectory)
    placed = {name: values for name, values in observed.items() if name not in by_velocity}
    found = _errors(instance, placed, truth) if placed else {}
    late = {name: values for name, values in observed.items() if name in by_velocity - by_position}
    return found | (_errors(instance, late, truth.delayed(delay)) if late else {})


def _made_of(instance: Instance, trajectory: Trajectory) -> tuple[set[str], set[str]]:
    """Names of the quantities that change with velocities, and of those that change with positions."""
    from refdem.mechanics.quaternion import product

    plain, moved, turn = instance.observe(trajectory), [], np.array([0.4, 0.1, 0.5, 0.3]) / np.sqrt(0.51)
    for names in (("velocity", "omega"), ("position", "attitude")):
        columns = {name: getattr(trajectory, name) for name in names}
        other: dict[str, Any] = {
            name: product(turn, values) if name == "attitude" else 1.5 * values + 0.25 for name, values in columns.items()
        }
        moved.append(instance.observe(replace(trajectory, **other)))
    by_velocity, by_position = ({name for name in plain if np.any(plain[name] != seen[name])} for seen in moved)
    return by_velocity, by_position


def _errors(instance: Instance, observed: dict[str, Array], truth: SampledTruth) -> dict[str, Array]:
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
    parts = [f"attitude.{axis}" for axis in "wxyz"]
    if all(name in observed and name in truth.values for name in parts):
        found["attitude"] = _rotation_error(observed, truth, parts)
    if not found:
        raise EngineError("the trajectory shows none of the quantities of the case; expected " + ", ".join(instance.quantities))
    return found


def _rotation_error(observed: dict[str, Array], truth: SampledTruth, parts: list[str]) -> Array:
    """Angle (until,) [rad] between observed and true attitude, less the radius of the truth."""
    from refdem.mechanics.quaternion import angle_between

    seen = np.stack([observed[name][: truth.until] for name in parts], axis=-1)
    seen = seen / np.linalg.norm(seen, axis=-1, keepdims=True)
    true = np.stack([truth.value(name) for name in parts], axis=-1)
    radius = 2.0 * np.max([truth.radius(name) for name in parts], axis=0)
    error: Array = np.maximum(0.0, angle_between(seen, true) - radius)
    return error


def distances(instance: Instance, a: Trajectory, b: Trajectory) -> Array:
    """Largest difference (T,) of any state of any body between two runs, each column in its scale; of any quantity without a scene."""
    if not isinstance(instance.problem, Motion):
        one, other = instance.observe(a), instance.observe(b)
        apart: Array = np.maximum.reduce([np.abs(one[name] - other[name]) / q.scale for name, q in instance.quantities.items()])
        return apart
    scales, bodies = instance.scales, instance.scene.bodies
    spin = float(np.max(np.linalg.norm(bodies.omega, axis=1))) or 1.0 / scales.tau
    parts = [
        np.abs(a.position - b.position).max(axis=(1, 2)) / scales.length,
        np.abs(a.velocity - b.velocity).max(axis=(1, 2)) / scales.speed,
    ]
    if "rotation" in instance.scene.features:
        from refdem.mechanics.quaternion import angle_between

        turns = bodies.inertia.any(axis=1)
        parts.append(np.abs(a.omega - b.omega).max(axis=(1, 2)) / spin)
        parts.append(angle_between(a.attitude[:, turns], b.attitude[:, turns]).max(axis=1, initial=0.0))
    largest: Array = np.maximum.reduce(parts)
    return largest


def perturbation(method: Method) -> int:
    """Units in the last place by which a start is moved to show how errors grow: those of a double, a single one being 2^29."""
    return PERTURBED * round(method.round_off * 2.0**53)


def growth_shown(instance: Instance, method: Method, moved: Trajectory, base: Trajectory) -> Array:
    """How much an early error has grown (T,), as a start moved by `perturbation` shows it: what stands in for S without truth."""
    shown = distances(instance, moved, base) / (perturbation(method) * 2.0**-52)
    return np.maximum.accumulate(np.maximum(1.0, MORE * shown))


def curve(t: Array, value: Array, bound: Array | float) -> Series:
    """A curve of at most MOST_POINTS points that keeps the largest value of each stretch."""
    bound = np.broadcast_to(np.asarray(bound, float), value.shape)
    pick = np.arange(len(value))
    if len(value) > MOST_POINTS:
        pick = np.array([part[np.argmax(value[part])] for part in np.array_split(pick, MOST_POINTS)])
    return Series(t=t[pick].tolist(), value=value[pick].tolist(), bound=bound[pick].tolist())
