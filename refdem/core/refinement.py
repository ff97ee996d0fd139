"""Bounds and refinement: how large an error may be at a step, and which steps to take."""

import math

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Instance
from refdem.core.engine import Method
from refdem.core.problem import Motion
from refdem.core.smoothness import JUMP, Singularity, singularities
from refdem.core.truth import SampledTruth
from refdem.errors import UsageError
from refdem.scene.elements.rod import Rod

Array = NDArray[np.float64]

ROUND_OFF_FACTOR = 8.0
"""c in c u sqrt(n): a step rounds some ten times, errors of random sign add as the square root, and
three sigma are allowed.
"""
HORIZON = 0.1
"""A run is scored up to the first time at which its bound exceeds this part of the scale."""
COUNTING_FLOOR = 20.0
"""A level counts for the order while its bound is at least this many times round-off."""
TURN_ROUNDINGS = 3.0
"""Roundings by which the turns of a step stretch a vector: five of them, of half a rounding each,
all of one sign.

Measured: 0.8 a step for a sphere that spins about a tilted axis, turned in single precision about
its three axes in five turns.
"""
MOST_STEPS = 1e10
"""More steps than this are a slip of the caller's: no engine finishes them within a day."""
CLOCK_STEPS = 4.0
"""Steps that a method which chooses them takes in a shortest time: one of high order turns a
fraction of a radian a step.
"""
KINKS = frozenset({"contact", "friction", "catch", "piecewise_field", "wedge", "spring:exponent"})
"""What brings forces that are not smooth: a touch, a stop, the edge of a field, the square root of
a stretch.
"""
SOMETIMES = frozenset(
    {"contact", "catch", "wedge", "piecewise_field", "uniform_gravity", "plane", "periodic_box"}
)
"""Elements whose force is constant or acts only for a while: between, or all the time, bodies gain
the same at every step.
"""
SCATTER = 1.0
"""Standard deviation, in octaves, of the error constant of a motion with kinks from step to step.

What a step that holds a kink adds is h^p times a polynomial in the place of the kink within the
step, which is as good as random. Measured: 0.9 for velocity Verlet across a field with two edges,
18 steps.
"""
FURTHER = 2
"""Halvings of the finest step for the order of a motion with kinks: a mean over five octaves tells
orders apart that pairs do not.
"""
TOLERANCE_FACTOR = 1e3
"""A tolerance is local: its error may add up to this many times itself (design: 1e3 tol S)."""


def round_off(instance: Instance, method: Method, steps: float) -> float:
    """Relative round-off after `steps` steps: c u sqrt(n), and not less than c u T/tau.

    The second part is the rounding of the parameters themselves: a frequency that is off by u is
    off in phase by u t.
    """
    turns = instance.scales.duration / instance.scales.tau
    return ROUND_OFF_FACTOR * method.round_off * max(1.0, math.sqrt(steps), turns)


def sweeping(instance: Instance, method: Method) -> float:
    """How many times round-off grows where rods share bodies, at least 1: the impulses of every
    sweep over them are rounded.

    A sweep that halves what is left needs log2(1/u) of them; a body has its rods' impulses in each,
    in place of ten roundings a step.
    """
    scene = instance.scene
    rods = len(scene.all(Rod))
    if rods < 2 or method.control != "step":
        return 1.0
    return max(1.0, math.sqrt(-math.log2(method.round_off) * 2 * rods / len(scene.bodies) / 10.0))


def flight(instance: Instance, method: Method, level: float) -> float:
    """Relative round-off of what is added to again and again by the same amount: u a step; 0 where
    forces vary all the time.

    A body in free flight adds h v to its place at every step, and one that falls adds h g to its
    velocity. Sums of equal terms round alike, step after step, so that roundings do not add as the
    square root. Dry friction of constant size adds h f/m always against the motion: measured for
    velocity Verlet that applies it by itself, 0.2 to 0.5 u a step, beside any spring. Gravity
    beside a spring only moves the equilibrium: there the square root holds (measured: 3 u sqrt(n)
    up to 1e6 steps).
    """
    if method.control != "step" or not isinstance(instance.problem, Motion):
        return 0.0
    kinds = {element.kind for element in instance.scene.elements}
    is_even = kinds <= SOMETIMES or "slider" in kinds
    if is_even:
        return method.round_off * steps_at(instance, method, level)
    return 0.0


def turning(instance: Instance, method: Method, level: float) -> float:
    """Relative round-off of angular momentum where bodies turn by the same angles at every step:
    TURN_ROUNDINGS u a step.

    The squares of a rounded cosine and sine do not add to 1, so that a turn by them stretches what
    it turns a little, and the same turn stretches it alike, step after step. A body that spins
    steadily repeats its turns, one that tumbles comes back to them.
    """
    if method.control != "step" or "rotation" not in instance.problem.features:
        return 0.0
    return TURN_ROUNDINGS * method.round_off * steps_at(instance, method, level)


def clock(instance: Instance, method: Method, level: float) -> float:
    """Relative error of a clock that is summed plainly: u T/tau for each addition; else 0.

    One that chooses its steps adds one a sample and CLOCK_STEPS a tau. Of given steps the number is
    known, whatever the sum says, and the clock counts only where a drive reads it.
    """
    turns = instance.scales.duration / instance.scales.tau
    if not method.summed_clock:
        return 0.0
    if method.control != "step":
        return method.round_off * turns * (len(instance.times) + CLOCK_STEPS * turns)
    driven = any(element.reads_clock for element in instance.scene.elements)
    if driven:
        return method.round_off * turns * steps_at(instance, method, level)
    return 0.0


def order(instance: Instance, method: Method) -> float:
    """The order p to which a method is held: the one that it claims for the scene, or less where no
    fixed steps have that.
    """
    claimed = method.order_for(instance.problem.features)
    limit = smoothness(instance, method)
    if limit is None or limit.order >= claimed:
        return claimed
    return limit.order


def smoothness(instance: Instance, method: Method) -> Singularity | None:
    """What of the scene leaves fixed steps the lowest order, or None.

    A method that locates events may start a step on each. One whose `order_with` names a feature of
    that element claims an order for it with open eyes, and is held to that. A force that jumps is
    no news to the author of a code: an order above 1 there is a claim that steps are cut where it
    jumps, and is held as it stands.
    """
    if (
        method.control != "step"
        or method.locates_events
        or not isinstance(instance.problem, Motion)
    ):
        return None
    named = set(method.order_with)
    limits = [
        limit
        for element, limit in singularities(instance.scene)
        if limit.exponent > JUMP and not element.features() & named
    ]
    return min(limits, default=None)


def truncation(instance: Instance, method: Method, level: float, t: Array) -> Array:
    """Relative truncation error C (1 + t/tau) (h/tau)^p (T,) allowed at times t [s].

    C 1e3 tol for a tolerance; 0 if exact.
    """
    if method.control == "exact":
        return np.zeros(len(t))
    if method.control == "tolerance":
        if kinked(instance):
            constant = 1.0
        else:
            constant = method.constant
        return np.full(len(t), constant * TOLERANCE_FACTOR * level)
    tau = instance.scales.tau
    power = order(instance, method)
    allowed: Array = method.constant * (1.0 + np.abs(t - t[0]) / tau) * (level / tau) ** power
    return allowed


def kinked(instance: Instance) -> bool:
    """The motion may have kinks in the middle of a step, so that errors fall with the order on the
    whole and not from pair to pair.
    """
    return bool(KINKS & instance.problem.features)


def order_levels(instance: Instance, levels: tuple[float, ...]) -> tuple[float, ...]:
    """The levels from which an order is read: finer ones as well where kinks scatter the errors of
    each.
    """
    if not levels or not kinked(instance):
        return tuple(levels)
    further = (levels[-1] / 2**k for k in range(1, FURTHER + 1))
    return (*levels, *further)


def steps_at(instance: Instance, method: Method, level: float) -> float:
    """Steps taken over the whole duration; one a sample for exact methods and tolerances."""
    if method.control == "step":
        return float(instance.times[-1] / level)
    return float(len(instance.times))


def bound(instance: Instance, method: Method, level: float, truth: SampledTruth) -> Array:
    """Relative error allowed at every certified sample (until,): (truncation + round-off) times S
    so far.
    """
    t = instance.times[: truth.until]
    allowed = truncation(instance, method, level, t) + round_off(
        instance, method, steps_at(instance, method, level)
    )
    unremoved = clock(instance, method, level) + flight(instance, method, level)
    return (allowed + unremoved) * truth.growth()


def scored(allowed: Array) -> int:
    """Number of samples before the bound first exceeds a tenth of the scale: the predictability
    horizon.
    """
    beyond = np.flatnonzero(allowed > HORIZON)
    if len(beyond):
        return int(beyond[0])
    return len(allowed)


def levels(
    instance: Instance, method: Method, count: int, most_steps: float, step: float | None = None
) -> tuple[float, ...]:
    """Refinement levels, coarse to fine: steps (or tolerances), each a power of two below the
    sample interval.

    The first step is the largest with C (T/tau) (h/tau)^p <= 0.1, or the smallest that `most_steps`
    allow: such a run is scored up to its horizon. Then halves, while there are at most `most_steps`
    steps and the bound stays above round-off. With `step`, the levels start there; raises
    UsageError for one that no run could finish. None if `most_steps` make even tau, the shortest
    time, too short a step.
    """
    if method.control == "exact":
        return (0.0,)
    if method.control == "tolerance":
        tolerances = (10.0 ** -(4 + 2 * j) for j in range(count))
        return tuple(
            t for t in tolerances if t > COUNTING_FLOOR * method.round_off
        )  # below, step control never ends
    power = order(instance, method)
    scales = instance.scales
    first = step or scales.tau * (HORIZON * scales.tau / (method.constant * scales.duration)) ** (
        1.0 / power
    )
    interval = float(instance.times[1])
    if step is not None and instance.times[-1] / step > MOST_STEPS:
        raise UsageError(
            f"step is {step:g} s, which makes {instance.times[-1] / step:.1g} steps; expected at"
            f" most {MOST_STEPS:g}: take a longer step"
        )
    if step is None and instance.times[-1] / most_steps > scales.tau:
        return ()
    halvings = max(0, int(np.ceil(np.log2(interval / first) - 1e-9)))
    if step is None:
        halvings = min(halvings, max(0, int(np.log2(most_steps * interval / instance.times[-1]))))
    chosen = [interval * 2.0**-halvings]
    while len(chosen) < count:
        finer = chosen[-1] / 2
        allowed = method.constant * (scales.duration / scales.tau) * (finer / scales.tau) ** power
        steps = instance.times[-1] / finer
        if steps > most_steps or (
            len(chosen) >= 3 and allowed < COUNTING_FLOOR * round_off(instance, method, steps)
        ):
            break
        chosen.append(finer)
    return tuple(chosen)
