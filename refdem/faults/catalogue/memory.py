"""State that leaks from run to run, numbers that were never set, caches that went stale."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults import vectors as vec
from refdem.faults.change import forgetting
from refdem.faults.fault import Fault
from refdem.faults.parts import Parts

memory = partial(Fault, kind="memory", on=("oscillator",))
AGAIN = ("determinism", "repeated")


def _counted(size: float) -> Callable[[Parts], dict[str, Any]]:
    """A number that was never set: another one in every run (imitated by counting runs)."""

    def inside(p: Parts) -> dict[str, Any]:
        runs: list[None] = []

        def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
            never_set = size * (len(runs) % 7)
            return p.kicked(v, (force[0] + never_set, *force[1:]), mass, h)

        return forgetting(p, lambda: runs.append(None), kicked=kicked)

    return inside


def _kept_spring(p: Parts) -> dict[str, Any]:
    """The tangential spring of the last contact of the run before is there at the first one of
    this.
    """
    last: dict[str, Any] = {"stretch": vec.ZERO}

    def stretched(stretch: Any, before: Any, now: Any, h: Any) -> Any:
        if last["new"]:
            stretch = last["stretch"]
            last["new"] = False
        last["stretch"] = p.stretched(stretch, before, now, h)
        return last["stretch"]

    return forgetting(p, lambda: last.update(new=True), stretched=stretched)


def _kept_late(p: Parts) -> dict[str, Any]:
    """The first force of a run is the last one of the run before."""
    kept: dict[str, Any] = {}

    def spring_force(spring: Any, a: Any, b: Any) -> Any:
        if kept.get("first"):
            kept["first"] = False
            return kept["last"]
        kept["last"] = p.spring_force(spring, a, b)
        return kept["last"]

    return forgetting(p, lambda: kept.update(first="last" in kept), spring_force=spring_force)


def _forwards(request: Request, run: Trajectory) -> Trajectory:
    """A run backwards is answered with its start, moved on forwards by twice the way."""
    if request.problem.interval > 0:
        return run
    ahead = (request.problem.times[0] - request.problem.times)[:, None, None]
    return replace(run, position=run.position + 2 * ahead * run.velocity)


def _first_kick(argument: str) -> Callable[[Parts], dict[str, Any]]:
    """An argument of the first kick ever made serves for all kicks of all runs."""

    def inside(p: Parts) -> dict[str, Any]:
        kept: dict[str, Any] = {}

        def kicked(v: Any, force: Any, mass: Any, h: Any) -> Any:
            asked = {"mass": mass, "h": h}
            asked[argument] = kept.setdefault(argument, asked[argument])
            return p.kicked(v, force, asked["mass"], asked["h"])

        return {"kicked": kicked}

    return inside


FAULTS = (
    memory(
        name="never-set",
        sentence="A force has a part of 1e-13 N that was never set.",
        sees=AGAIN,
        inside=_counted(1e-13),
    ),
    memory(
        name="never-set-large",
        sentence="A force has a part of 1e-3 N that was never set.",
        on=("orbit",),
        sees=AGAIN,
        inside=_counted(1e-3),
    ),
    memory(
        name="never-set-contact",
        sentence="A contact force has a part of 1e-12 N that was never set.",
        on=("knock",),
        sees=AGAIN,
        inside=_counted(1e-12),
    ),
    memory(
        name="spring-kept",
        sentence="The tangential spring is kept from run to run.",
        on=("sticker",),
        sees=AGAIN,
        inside=_kept_spring,
    ),
    memory(
        name="force-kept",
        sentence="The first force of a run is the last one of the run before.",
        sees=AGAIN,
        inside=_kept_late,
    ),
    memory(
        name="step-kept",
        sentence="Half of the first step of the first run is used in all kicks.",
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
        sentence="Time that runs backwards is taken for time that runs forwards.",
        sees=("reversal", "backward"),
        after=_forwards,
    ),
)
