"""The first finding of a smoke test: the program takes exactly `stride` steps from each sample to
the next.

A program that compares times instead of counting steps makes one step too many or too few because
of the rounding of its summed time. At each sample

    excess of steps = (elapsed time - requested time)/step.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.core.engine import Engine, Method
from refdem.core.finding import Finding, Outcome
from refdem.core.problem import COUNT, Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError, UnsupportedError
from refdem.smoke.clock_probes import (
    ROUND,
    ROUNDED,
    SAMPLES,
    ClockScene,
    clock_request,
    clock_scenes,
    times,
)

Array = NDArray[np.float64]

QUANTITY = "clock: steps"
BOUND = 0.25
"""Bound on the excess [steps], which is 1 for one step too many. It allows for the error of the
method; a constant lag of half a step does not contribute.
"""
BASIS = (
    "consecutive samples are exactly `stride` whole steps apart; summed step"
    " times are rounded and must not be compared"
)
PLAUSIBLE = (0.5, 2.0)
"""Limits of elapsed over requested time. Beyond them the unit of time is wrong, which other probes
detect, and steps are measured in the program's own unit."""


def step_count_findings(engine: Engine, method: Method) -> list[Finding]:
    """The finding on the steps that a method takes, on the first scene that it supports.

    The list is empty for a method without steps, or if it supports no scene.
    """
    if method.control != "step":
        return []
    for scene in clock_scenes():
        if engine.unsupported(Motion(scene.scene, times(ROUND[0], 1.0)), method) is not None:
            continue
        try:
            return [_step_count_finding(engine, method, scene)]
        except UnsupportedError:
            continue
        # Any exception of an adapter is its fault, and becomes a finding.
        except Exception as error:
            sentence = f"{method.name} on a {scene.name}: {type(error).__name__}: {error}"
            return [Finding(check="smoke", quantity=QUANTITY, outcome="error", sentence=sentence)]
    return []


def _step_count_finding(engine: Engine, method: Method, scene: ClockScene) -> Finding:
    """The finding on the largest excess of steps over all intervals, forwards and (where claimed)
    backwards.
    """
    worst = 0.0
    sentence = f"{method.name} takes `stride` steps from each sample to the next"
    directions = [1.0]
    if method.backward:
        directions.append(-1.0)
    for direction in directions:
        plain, trajectory = _run(engine, method, scene, ROUND, direction)
        time_ratio = _time_ratio(scene.passed(trajectory), plain)
        for interval in (ROUND, *ROUNDED):
            request, trajectory = _run(engine, method, scene, interval, direction)
            excess = _excess_steps(scene, request, trajectory, time_ratio)
            largest = float(np.max(np.abs(excess)))
            # Written so that an excess that is not a number counts as a miscount.
            is_worst_miscount = not largest <= max(BOUND, worst)
            worst = max(worst, largest)
            if is_worst_miscount:
                sentence = (
                    f"{method.name} {_miscount_text(excess, request.stride)}, with steps of"
                    f" {request.signed_step!r} s: {COUNT}"
                )
    return bounded_finding(QUANTITY, worst, BOUND, BASIS, sentence)


def bounded_finding(
    quantity: str, value: float, bound: float, basis: str, sentence: str
) -> Finding:
    """A finding of the smoke test: a pass if the value is within the bound."""
    outcome: Outcome = "fail"
    if value <= bound:
        outcome = "pass"
    return Finding(
        check="smoke",
        quantity=quantity,
        outcome=outcome,
        sentence=sentence,
        value=value,
        bound=bound,
        basis=basis,
    )


def _run(
    engine: Engine, method: Method, scene: ClockScene, interval: tuple[float, int], direction: float
) -> tuple[Request, Trajectory]:
    """The request for a scene over an interval (length [s], stride), and its trajectory."""
    request = clock_request(scene.scene, method.name, *interval, direction)
    trajectory, _ = engine.run(request)
    refuse_other_shape(trajectory, request)
    return request, trajectory


def refuse_other_shape(trajectory: Trajectory, request: Request) -> None:
    """Raises EngineError unless there is a row for each sample and body."""
    expected = (len(request.problem.times), len(request.problem.scene.bodies), 3)
    shape = trajectory.position.shape
    if shape != expected:
        raise EngineError(
            f"trajectory.position has shape {shape}; expected {expected}: samples, bodies, axes"
        )


def _time_ratio(passed: Array, request: Request) -> float:
    """The ratio of elapsed to requested time if it is explained by another unit, else 1.

    `passed` (T,) [s] is the time that the state shows. A ratio within PLAUSIBLE is a miscount of
    steps, not another unit.
    """
    total = request.problem.times[-1] - request.problem.times[0]
    time_ratio = abs(float(passed[-1] / total))
    slowest, fastest = PLAUSIBLE
    is_miscounted = slowest <= time_ratio <= fastest or time_ratio == 0
    if is_miscounted or not np.isfinite(time_ratio):
        return 1.0
    return time_ratio


def _excess_steps(scene: ClockScene, request: Request, run: Trajectory, time_ratio: float) -> Array:
    """The number of steps (T,) in excess of the requested ones, up to each sample.

    Measured by the state and by the program's own time, whichever deviates more.
    """
    elapsed = request.problem.times - request.problem.times[0]
    by_state = (scene.passed(run) / time_ratio - elapsed) / request.signed_step
    by_clock = (run.t - run.t[0] - elapsed) / request.signed_step
    excess: Array = np.where(np.abs(by_state) >= np.abs(by_clock), by_state, by_clock)
    return excess


def _miscount_text(excess: Array, stride: int) -> str:
    """The kind of miscount that an excess of steps (T,) shows, as the end of a sentence."""
    if np.all(np.round(excess[1:]) == -stride):
        return (
            "writes every sample after the first one sample late: row n must hold the state after n"
            " times `stride` steps"
        )
    sample = int(np.argmax(np.abs(excess)))
    count = max(1, round(abs(float(excess[sample]))))
    if count == 1:
        steps = "1 step"
    else:
        steps = f"{count} steps"
    if excess[sample] > 0:
        amount = "many"
    else:
        amount = "few"
    return f"has taken {steps} too {amount} at sample {sample} of {SAMPLES}"
