"""State that a program keeps from one request to the next.

Some requests are repeated, in a fresh process and in another order, and the answers must be
bitwise equal.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from refdem.core.answer_csv import most_rows
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Trajectory

Array = NDArray[np.float64]

EVERY = 16
"""One request in EVERY is repeated. Each repetition starts a process, which is a small part of the
starts that a program saves by staying alive.
"""
CHANGES = 4
"""Number of requests that are always repeated where the scene differs from that of the previous
request. A program that keeps a mass or a velocity shows it there, but not where the same scene is
requested with another step.
"""
MOST_ROWS = 100_000
"""Most rows of an answer that is kept for comparison with a later one."""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a program answered to a request: a trajectory, or else why it does not support it."""

    trajectory: Trajectory | None
    refusal: str = ""


@dataclass(kw_only=True)
class Sample:
    """The choice of requests to one method of a program that are repeated, in this process.

    `earlier` is a request that was answered before, with its answer. It is repeated after the next
    repeated request, so that the two are asked in reverse order. `leak` describes the difference
    that was found; it is empty if there was none.
    """

    changes: int = 0
    has_begun: bool = False
    earlier: tuple[Request, Answer] | None = None
    leak: str = ""

    def takes(self, request: Request, before: Request | None) -> bool:
        """Whether a request that followed `before` in its process is repeated.

        The first request of a process (`before` is None) was answered by a fresh one already.
        """
        if before is None:
            return False
        is_first = not self.has_begun
        self.has_begun = True
        if self.changes < CHANGES and is_of_another_scene(request, before):
            self.changes += 1
            return True
        return is_first or int(request.key(), 16) % EVERY == 0

    def keep(self, request: Request, answer: Answer) -> None:
        """Keeps a request and its answer, to repeat it after the next repeated request."""
        if most_rows(request.problem) <= MOST_ROWS:
            self.earlier = request, answer


def is_of_another_scene(request: Request, other: Request) -> bool:
    """Whether two requests are about different problems, whatever their steps and samples."""
    return bool(request.problem.document() != other.problem.document())


def difference(first: Answer, second: Answer) -> str:
    """The first difference between two answers to one request, in words; empty if their bits are
    the same.
    """
    if first.trajectory is None or second.trajectory is None:
        if first.trajectory is second.trajectory:
            return ""
        return f"{_kind(first)}, and then {_kind(second)}"
    return _difference(first.trajectory, second.trajectory)


def _kind(answer: Answer) -> str:
    """The kind of an answer: a trajectory or a refusal."""
    if answer.trajectory is None:
        return f"it was not supported ({answer.refusal})"
    return "it was answered with a trajectory"


def _difference(first: Trajectory, second: Trajectory) -> str:
    """The first difference between two trajectories, sample by sample."""
    one = _numbers(first)
    other = _numbers(second)
    if one.keys() != other.keys():
        return f"columns {', '.join(one)}, and then {', '.join(other)}"
    worst = ""
    earliest = np.inf
    for name, values in one.items():
        others = other[name]
        if values.shape != others.shape:
            return f"{name} has shape {values.shape}, and then {others.shape}"
        differs = _bits(values) != _bits(others)
        if name == "attitude":
            # q and -q are the same attitude.
            is_opposite = np.all(values == -others, axis=-1)
            differs &= ~is_opposite[..., None]
        places = np.argwhere(differs)
        if len(places) and places[0][0] < earliest:
            place = tuple(places[0])
            earliest = places[0][0]
            indices = "".join(f"[{index}]" for index in place)
            worst = (
                f"{name}{indices} at t = {first.t[place[0]]:.6g} s is {values[place]:.17g}, and"
                f" then {others[place]:.17g}"
            )
    if not worst and first.events != second.events:
        worst = f"{len(first.events)} events, and then {len(second.events)} or others"
    return worst


def _numbers(trajectory: Trajectory) -> dict[str, Array]:
    """All arrays of a trajectory by name."""
    channels = {f"channels.{name}": values for name, values in trajectory.channels.items()}
    derivatives = {f"derivatives[{key}]": of for key, of in trajectory.derivatives.items()}
    return {"t": trajectory.t} | trajectory.columns() | channels | derivatives


def _bits(values: Array) -> NDArray[np.int64]:
    """The bits of numbers, for which 0 and -0 differ."""
    return np.ascontiguousarray(values).view(np.int64)


def words(request: Request) -> str:
    """A short description of a request for the author of the program: method, step and scene."""
    step = ""
    if request.step is not None:
        step = f", step {request.step:.6g} s"
    if not isinstance(request.problem, Motion):
        return f"method {request.method} on {request.problem.words}{step}"
    scene = request.problem.scene
    bodies = f"{len(scene.bodies)} bodies"
    if len(scene.bodies) == 1:
        bodies = "1 body"
    features = ", ".join(sorted(scene.features))
    return f"method {request.method} on {bodies} with {features}{step}"
