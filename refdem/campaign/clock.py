"""The first finding of a smoke test: a program counts its steps, and compares no times."""

import numpy as np
from numpy.typing import NDArray

from refdem.campaign.clock_probes import (
    ROUND,
    ROUNDED,
    SAMPLES,
    ClockScene,
    clock_scenes,
    request,
    times,
)
from refdem.core.engine import Engine, Method
from refdem.core.finding import Finding, Outcome
from refdem.core.problem import COUNT, Motion, Request
from refdem.core.trajectory import Trajectory
from refdem.errors import EngineError, UnsupportedError

Array = NDArray[np.float64]

QUANTITY = "clock: steps"
BOUND = 0.25
"""Steps.

One step is one; a method's own error and a lag of half a step that stays are not in it.
"""
BASIS = (
    "consecutive samples are exactly `stride` whole steps apart; summed step"
    " times are rounded and must not be compared"
)
PLAUSIBLE = (0.5, 2.0)
"""Time passed over time asked for. Outside these limits units are wrong, which other probes tell,
and steps are measured in the program's own pace."""


def counted(engine: Engine, method: Method) -> list[Finding]:
    """Whether the method takes the steps that were asked for; nothing for a method without steps,
    or without a scene.
    """
    if method.control != "step":
        return []
    for scene in clock_scenes():
        if engine.unsupported(Motion(scene.scene, times(ROUND[0], 1.0)), method) is not None:
            continue
        try:
            return [_judged(engine, method, scene)]
        except UnsupportedError:
            continue
        except Exception as error:  # whatever an adapter raises is its fault, and a finding
            sentence = f"{method.name} on a {scene.name}: {type(error).__name__}: {error}"
            return [Finding(check="smoke", quantity=QUANTITY, outcome="error", sentence=sentence)]
    return []


def _judged(engine: Engine, method: Method, scene: ClockScene) -> Finding:
    """The run whose steps are furthest from those asked for, forwards and (where claimed)
    backwards.
    """
    worst = 0.0
    says = f"{method.name} takes `stride` steps from each sample to the next"
    directions = [1.0]
    if method.backward:
        directions.append(-1.0)
    for direction in directions:
        plain, trajectory = _run(engine, method, scene, ROUND, direction)
        pace = _pace(scene.passed(trajectory), plain)
        for interval in (ROUND, *ROUNDED):
            asked, seen = _run(engine, method, scene, interval, direction)
            late = _steps_late(scene, asked, seen, pace)
            largest = float(np.max(np.abs(late)))
            is_worst_miscount = not largest <= max(BOUND, worst)
            worst = max(worst, largest)
            if is_worst_miscount:
                says = (
                    f"{method.name} {_miscount(late, asked.stride)}, with steps of"
                    f" {asked.signed_step!r} s: {COUNT}"
                )
    return bounded(QUANTITY, worst, BOUND, BASIS, says)


def bounded(quantity: str, value: float, bound: float, basis: str, says: str) -> Finding:
    """A finding of the smoke test: a pass if the value is within the bound."""
    outcome: Outcome = "fail"
    if value <= bound:
        outcome = "pass"
    return Finding(
        check="smoke",
        quantity=quantity,
        outcome=outcome,
        sentence=says,
        value=value,
        bound=bound,
        basis=basis,
    )


def _run(
    engine: Engine, method: Method, scene: ClockScene, interval: tuple[float, int], direction: float
) -> tuple[Request, Trajectory]:
    """The request and what came back."""
    asked = request(scene.scene, method.name, *interval, direction)
    trajectory, _ = engine.run(asked)
    refuse_other_shape(trajectory, asked)
    return asked, trajectory


def refuse_other_shape(trajectory: Trajectory, asked: Request) -> None:
    """Raises EngineError unless there is a row for each sample and body."""
    expected = (len(asked.problem.times), len(asked.problem.scene.bodies), 3)
    if trajectory.position.shape != expected:
        came = trajectory.position.shape
        raise EngineError(
            f"trajectory.position has shape {came}; expected {expected}: samples, bodies, axes"
        )


def _pace(passed: Array, asked: Request) -> float:
    """How many times too fast everything happens where that is a matter of units; else 1."""
    total = asked.problem.times[-1] - asked.problem.times[0]
    pace = abs(float(passed[-1] / total))
    slowest, fastest = PLAUSIBLE
    is_miscounted = slowest <= pace <= fastest or pace == 0
    if is_miscounted or not np.isfinite(pace):
        return 1.0
    return pace


def _steps_late(scene: ClockScene, asked: Request, seen: Trajectory, pace: float) -> Array:
    """Steps (T,) that were taken beyond those asked for, by the state or by the program's own
    time.
    """
    since = asked.problem.times - asked.problem.times[0]
    by_state = (scene.passed(seen) / pace - since) / asked.signed_step
    by_clock = (seen.t - seen.t[0] - since) / asked.signed_step
    late: Array = np.where(np.abs(by_state) >= np.abs(by_clock), by_state, by_clock)
    return late


def _miscount(late: Array, stride: int) -> str:
    """What the numbers of steps (T,) beyond those asked for show."""
    whole = np.round(late[1:])
    if np.all(whole == -stride):
        return (
            "shows every sample after the first one sample late: row n holds the state after n"
            " times `stride` steps"
        )
    sample = int(np.argmax(np.abs(late)))
    count = max(1, round(abs(float(late[sample]))))
    if count == 1:
        steps = "1 step"
    else:
        steps = f"{count} steps"
    if late[sample] > 0:
        side = "many"
    else:
        side = "few"
    return f"has taken {steps} too {side} at sample {sample} of {SAMPLES}"
