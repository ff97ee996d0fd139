"""Faults of derivatives: of impacts that are differentiated, and of what is told of the matrix."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Request
from refdem.core.trajectory import Trajectory
from refdem.faults.change import of_parts, within
from refdem.faults.fault import Fault
from refdem.faults.tangent import value_of

Array = NDArray[np.float64]
Derivatives = dict[str, Array]

gradient = partial(Fault, kind="gradient", sees=("gradient", "matrix"), method="verlet-tangent")
SMOOTH = ("differentiated-oscillator",)
BOUNCING = ("differentiated-drop", "differentiated-wall")


def of_derivatives(
    change: Callable[[Derivatives], Derivatives],
) -> Callable[[Request, Trajectory], Trajectory]:
    """A trajectory with its derivatives changed, where it has some."""

    def after(request: Request, run: Trajectory) -> Trajectory:
        if not run.derivatives:
            return run
        return replace(run, derivatives=change(dict(run.derivatives)))

    return after


def _negative(derivatives: Derivatives) -> Derivatives:
    """All derivatives with the other sign."""
    return {key: -slopes for key, slopes in derivatives.items()}


def _plain_time(time: Any) -> float:
    """The time to an impact without its slopes."""
    return value_of(time)


def _plain_rest(left: Any, time: Any) -> Any:
    """What is left of a step, as if no impact time had slopes."""
    return left - value_of(time)


def _told_before(before: Any, after: Any) -> Any:
    """The state before the last step."""
    return before


FAULTS = (
    gradient(
        name="gradient-without-impact-time",
        sentence="The derivative of the impact time is left out.",
        on=BOUNCING,
        inside=within("tangent", of_parts(time_to_impact=_plain_time, time_left=_plain_rest)),
    ),
    gradient(
        name="gradient-of-unrolled-steps",
        sentence=(
            "The step that has an impact is differentiated as one whose second part has a length"
            " of its own."
        ),
        on=BOUNCING,
        inside=within("tangent", of_parts(time_left=_plain_rest)),
    ),
    gradient(
        name="gradient-without-last-step",
        sentence="The last step before a sample is not differentiated.",
        on=SMOOTH,
        sees=("gradient", "order"),
        inside=within("tangent", of_parts(told=_told_before)),
    ),
    gradient(
        name="gradient-of-other-sign",
        sentence="Every derivative has the other sign.",
        on=(*SMOOTH, *BOUNCING),
        after=of_derivatives(_negative),
    ),
)
