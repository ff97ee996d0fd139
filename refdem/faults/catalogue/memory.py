"""State that leaks from run to run, numbers that were never set, caches that went stale.

Each helper here makes `inside` of a fault: from the sound parts of the transparent engine it
makes the faulty ones by name. What the closures remember is the state that leaks.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import forgetting, with_force
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts
from refdem.mechanics import vectors as vec
from refdem.scene.elements.spring import Spring

memory = partial(Fault, kind="memory", on=("oscillator",))
AGAIN = ("determinism", "repeated")


def _differs_from_run_to_run(largest: float) -> Callable[[Parts], dict[str, Any]]:
    """A number that was never set: another one in every run.

    Memory that is never set cannot be made on purpose; it is imitated by the number of the run,
    modulo 7, times `largest` [N], which is added to the force along x.
    """

    def inside(sound: Parts) -> dict[str, Any]:
        runs = 0

        def count_run() -> None:
            nonlocal runs
            runs += 1

        def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
            never_set = largest * (runs % 7)
            return sound.kicked(v, (force[0] + never_set, *force[1:]), mass, h)

        return forgetting(sound, count_run, kicked=kicked)

    return inside


def _kept_spring(sound: Parts) -> dict[str, Any]:
    """The tangential spring at the end of a run is there when the next run begins."""
    last_stretch = vec.ZERO
    is_first_of_run = True

    def begin() -> None:
        nonlocal is_first_of_run
        is_first_of_run = True

    def stretched(stretch: Any, before: Any, now: Any, h: Any) -> Any:
        nonlocal last_stretch, is_first_of_run
        if is_first_of_run:
            stretch = last_stretch
            is_first_of_run = False
        last_stretch = sound.stretched(stretch, before, now, h)
        return last_stretch

    return forgetting(sound, begin, stretched=stretched)


def _kept_force(sound: Parts) -> dict[str, Any]:
    """The first force of a run is the last one of the run before."""
    last_force: Any = None
    is_first_of_run = False

    def begin() -> None:
        nonlocal is_first_of_run
        # The very first run has no run before it.
        is_first_of_run = last_force is not None

    sound_force = sound.forces[Spring]

    def force(*arguments: Any) -> Any:
        nonlocal last_force, is_first_of_run
        if is_first_of_run:
            is_first_of_run = False
        else:
            last_force = sound_force(*arguments)
        return last_force

    return forgetting(sound, begin, **with_force(sound, Spring, force))


def _forwards(request: Request, run: Trajectory) -> Trajectory:
    """A run backwards that is answered as if it were one forwards: free flight from the state at
    t - s, over twice the time s, x(t + s) = x(t - s) + 2 s v.
    """
    if request.problem.interval > 0:
        return run
    # Time from each sample to the start, which is later, shaped for (T, bodies, axes).
    times = request.problem.times
    elapsed = (times[0] - times)[:, None, None]
    return replace(run, position=run.position + 2 * elapsed * run.velocity)


def _first_kick(argument: str) -> Callable[[Parts], dict[str, Any]]:
    """An argument of the first kick ever made, `mass` or `h`, is used in all kicks of all runs."""

    def inside(sound: Parts) -> dict[str, Any]:
        cache: dict[str, Any] = {}

        def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
            arguments = {"mass": mass, "h": h}
            arguments[argument] = cache.setdefault(argument, arguments[argument])
            return sound.kicked(v, force, arguments["mass"], arguments["h"])

        return {"kicked": kicked}

    return inside


FAULTS = (
    memory(
        name="never-set",
        sentence="A force has a component of up to 1e-13 N from uninitialised memory.",
        sees=AGAIN,
        inside=_differs_from_run_to_run(1e-13),
    ),
    memory(
        name="never-set-large",
        sentence="A force has a component of up to 1e-3 N from uninitialised memory.",
        on=("orbit",),
        sees=AGAIN,
        inside=_differs_from_run_to_run(1e-3),
    ),
    memory(
        name="never-set-contact",
        sentence="A contact force has a component of up to 1e-12 N from uninitialised memory.",
        on=("knock",),
        sees=AGAIN,
        inside=_differs_from_run_to_run(1e-12),
    ),
    memory(
        name="spring-kept",
        sentence="The tangential spring is not reset between runs.",
        on=("sticker",),
        sees=AGAIN,
        inside=_kept_spring,
    ),
    memory(
        name="force-kept",
        sentence="The first force of a run is the last one of the previous run.",
        sees=AGAIN,
        inside=_kept_force,
    ),
    memory(
        name="step-kept",
        sentence="All kicks of all runs use half of the first step of the first run.",
        sees=("error", "x"),
        inside=_first_kick("h"),
    ),
    memory(
        name="mass-kept",
        sentence="The mass of the first body is used for all.",
        on=("bounce",),
        sees=("momentum", "total"),
        inside=_first_kick("mass"),
    ),
    memory(
        name="backwards-forwards",
        sentence="A run backward in time is made forward in time.",
        sees=("reversal", "backward"),
        after=_forwards,
    ),
)
