"""Faults of derivatives: of impacts that are differentiated, and of the reported matrix."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Request
from refdem.core.trajectory import STATE, Trajectory
from refdem.faults.change import of_parts, within
from refdem.faults.fault import Fault
from refdem.faults.tangent import value_of
from refdem.faults.transparent import Transparent
from refdem.mechanics.quaternion import conjugate, rotated
from refdem.scene import Scene
from refdem.scene.scene import encoded

Array = NDArray[np.float64]
Derivatives = dict[str, Array]

gradient = partial(Fault, kind="gradient", sees=("gradient", "matrix"), method="verlet-tangent")
SMOOTH = ("differentiated-oscillator",)
BOUNCING = ("differentiated-drop", "differentiated-wall")

TOO_CLOSE = 2.0**-46
"""Relative displacement of a number for central differences: so small that rounding leaves them
hardly a correct digit.
"""


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


def of_column(name: str, change: Callable[[Array], Array]) -> Callable[[Derivatives], Derivatives]:
    """The derivatives with those by the numbers of one name changed, such as all of a `mass`."""

    def changed(derivatives: Derivatives) -> Derivatives:
        return {
            key: change(slopes) if key.endswith(f".{name}") else slopes
            for key, slopes in derivatives.items()
        }

    return changed


def _of_other_column(one: str, other: str) -> Callable[[Derivatives], Derivatives]:
    """The derivatives by two numbers exchanged: each is reported as that of the other."""

    def changed(derivatives: Derivatives) -> Derivatives:
        return derivatives | {one: derivatives[other], other: derivatives[one]}

    return changed


def _transposed(derivatives: Derivatives) -> Derivatives:
    """The derivatives of states by the start with rows and columns of the matrix exchanged."""
    places = {f"scene.bodies.0.position.{axis}": axis for axis in range(3)}
    places |= {f"scene.bodies.0.velocity.{axis}": 3 + axis for axis in range(3)}
    requested = [key for key in places if key in derivatives]
    transposed = {key: np.array(slopes) for key, slopes in derivatives.items()}
    for key in requested:
        for other in requested:
            transposed[key][:, 0, places[other]] = derivatives[other][:, 0, places[key]]
    return transposed


def _of_sample_before(slopes: Array) -> Array:
    """Derivatives that are reported one sample late."""
    return np.concatenate([slopes[:1], slopes[:-1]])


def in_body_axes(request: Request, run: Trajectory) -> Trajectory:
    """The derivatives of positions and velocities in body axes."""
    to_body = conjugate(run.attitude)
    derivatives = {}
    for key, slopes in run.derivatives.items():
        # q* dr/ds q and q* dv/ds q.
        turned = np.array(slopes)
        turned[..., 0:3] = rotated(to_body, slopes[..., 0:3])
        turned[..., 3:6] = rotated(to_body, slopes[..., 3:6])
        derivatives[key] = turned
    return replace(run, derivatives=derivatives)


def by_differences(request: Request, run: Trajectory) -> Trajectory:
    """Central differences (x(s + d) - x(s - d))/(2 d) in place of the derivatives by each number s,
    with d = TOO_CLOSE |s|, or TOO_CLOSE where s is 0.
    """
    derivatives = {}
    for key in request.sensitivities:
        document = msgspec.json.decode(request.problem.scene.to_json())
        *way, last = [_index(word) for word in key.split(".")[1:]]
        holder = document
        for word in way:
            holder = holder[word]
        value = holder[last]
        distance = TOO_CLOSE * (abs(value) or 1.0)
        ends = []
        for side in (distance, -distance):
            holder[last] = value + side
            scene = Scene.from_json(encoded(document))
            moved, _ = Transparent().run(replace(request.with_scene(scene), sensitivities=()))
            ends.append(np.concatenate([getattr(moved, name) for name in STATE], axis=-1))
        derivatives[key] = (ends[0] - ends[1]) / (2 * distance)
    return replace(run, derivatives=derivatives)


def _index(word: str) -> Any:
    """A word of a key as the index of a list or the name of a field."""
    if word.isdigit():
        return int(word)
    return word


def _plain_time(time: Any) -> float:
    """The time to an impact without its derivatives, as if it were a constant."""
    return value_of(time)


def _plain_rest(left: Any, time: Any) -> Any:
    """The rest of a step after an impact, as if the time of the impact had no derivatives."""
    return left - value_of(time)


def _state_before_step(before: Any, after: Any) -> Any:
    """The state before the last step, in place of the state after it."""
    return before


FAULTS = (
    gradient(
        name="gradient-without-impact-time",
        sentence="The derivative of the impact time is omitted.",
        on=BOUNCING,
        inside=within("tangent", of_parts(time_to_impact=_plain_time, time_left=_plain_rest)),
    ),
    gradient(
        name="gradient-of-unrolled-steps",
        sentence=(
            "In a step with an impact, the derivative of the length of its second part is omitted."
        ),
        on=BOUNCING,
        inside=within("tangent", of_parts(time_left=_plain_rest)),
    ),
    gradient(
        name="gradient-without-last-step",
        sentence="The last step before a sample is not differentiated.",
        on=SMOOTH,
        sees=("gradient", "order"),
        inside=within("tangent", of_parts(reported_state=_state_before_step)),
    ),
    gradient(
        name="gradient-of-other-sign",
        sentence="Every derivative has the wrong sign.",
        on=(*SMOOTH, *BOUNCING),
        after=of_derivatives(_negative),
    ),
    gradient(
        name="gradient-transposed",
        sentence="The matrix of derivatives with respect to the initial state is transposed.",
        on=SMOOTH,
        after=of_derivatives(_transposed),
    ),
    gradient(
        name="gradient-in-body-axes",
        sentence="Derivatives of positions and velocities are reported in body axes.",
        on=("differentiated-drop",),
        after=in_body_axes,
    ),
    gradient(
        name="gradient-by-close-differences",
        sentence=(
            "Derivatives are finite differences over 2^-46 of a number, so that round-off"
            " dominates."
        ),
        on=(*SMOOTH, *BOUNCING),
        after=by_differences,
    ),
    gradient(
        name="gradient-by-grams",
        sentence="Derivatives with respect to the mass are reported per gram.",
        on=SMOOTH,
        after=of_derivatives(of_column("mass", lambda slopes: slopes / 1000.0)),
    ),
    gradient(
        name="gradient-of-swapped-columns",
        sentence="Derivatives with respect to the mass and to the stiffness are exchanged.",
        on=SMOOTH,
        after=of_derivatives(_of_other_column("scene.bodies.0.mass", "scene.elements.0.stiffness")),
    ),
    gradient(
        name="gradient-stale",
        sentence="Derivatives with respect to the stiffness are those of the previous sample.",
        on=SMOOTH,
        after=of_derivatives(of_column("stiffness", _of_sample_before)),
    ),
    gradient(
        name="gradient-zero",
        sentence="All derivatives with respect to the restitution are 0.",
        on=BOUNCING,
        after=of_derivatives(of_column("restitution", np.zeros_like)),
    ),
)
