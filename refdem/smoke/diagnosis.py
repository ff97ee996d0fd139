"""Diagnosis of an adapter's error from its result of a probe.

Known slips (axes exchanged, another unit, a quaternion with w last, ...) are applied to the right
result. A slip explains the error if it gives nearly the observed result. A probe may also have
known mistakes, each with its own motion. All explanations are named.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product, starmap

import numpy as np
from numpy.typing import NDArray

from refdem.core.trajectory import STATE
from refdem.mechanics.quaternion import conjugate, matrix, rotated
from refdem.smoke.probes import ORDERS, Expected

Array = NDArray[np.float64]
Slip = Callable[[Expected], Expected]

MATCH_TOLERANCE = 0.02
"""Largest difference, relative to the scale, of an observed column and that of a slip which
explains it.
"""
MAX_RESIDUAL = 0.25
"""Largest fraction of an error that a mistake which explains it leaves."""
MAX_CAUSES = 4
"""Largest number of equally good explanations that are named."""
POINT_ERROR_RATIO = 10.0
"""Largest fraction of an error that a displaced point which explains it leaves."""


@dataclass(frozen=True)
class Mistake:
    """A slip in words, and as a function from the right columns to the wrong ones that it makes."""

    description: str
    slip: Slip


def _in_column(name: str, change: Callable[[Array], Array]) -> Slip:
    """A slip that changes one column, and nothing where there is no such column."""

    def slip(expected: Expected) -> Expected:
        if name not in expected:
            return {}
        return {name: change(expected[name])}

    return slip


def _constant(values: Array) -> Array:
    """The first row in place of every row."""
    return np.repeat(values[:1], len(values), axis=0)


def _previous_rows(values: Array) -> Array:
    """The rows, each replaced by the one before it; the first stays."""
    return np.concatenate([values[:1], values[:-1]])


def _next_rows(values: Array) -> Array:
    """The rows, each replaced by the one after it; the last stays."""
    return np.concatenate([values[1:], values[-1:]])


def _in_all_columns(change: Callable[[Array], Array]) -> Slip:
    """A slip in every column of the state."""
    return lambda expected: {
        name: change(values) for name, values in expected.items() if name in STATE
    }


def _in_body_axes(name: str) -> Slip:
    """The slip that a vector is in body axes where it should be in space axes: v -> q* v q."""

    def slip(expected: Expected) -> Expected:
        if name not in expected or "attitude" not in expected:
            return {}
        return {name: rotated(conjugate(expected["attitude"]), expected[name])}

    return slip


def _reordered(name: str, order: str) -> Mistake:
    """The slip that a column has its axes in another order, such as "xzy"."""
    numbers = ["xyz".index(axis) for axis in order]
    reorder = _in_column(name, lambda values: values[..., numbers])
    return Mistake(f"the axes of {name} are in the order {order} instead of xyz", reorder)


COLUMNS = ("position", "velocity", "omega")
MISTAKES = (
    Mistake(
        "the quaternion is in the order x, y, z, w instead of w, x, y, z",
        _in_column("attitude", lambda q: np.roll(q, -1, axis=-1)),
    ),
    Mistake(
        "the quaternion is in the order z, w, x, y instead of w, x, y, z",
        _in_column("attitude", lambda q: np.roll(q, 1, axis=-1)),
    ),
    Mistake(
        "the quaternion rotates space to body axes instead of body to space axes",
        _in_column("attitude", conjugate),
    ),
    Mistake("omega is in body axes instead of space axes", _in_body_axes("omega")),
    Mistake("velocity is in body axes instead of space axes", _in_body_axes("velocity")),
    Mistake("position is in body axes instead of space axes", _in_body_axes("position")),
    Mistake("omega is in degrees per second instead of rad/s", _in_column("omega", np.degrees)),
    Mistake(
        "omega is in revolutions per second instead of rad/s",
        _in_column("omega", lambda w: w / (2 * np.pi)),
    ),
    Mistake("omega has the opposite sign", _in_column("omega", np.negative)),
    Mistake("omega is always zero", _in_column("omega", lambda w: 0 * w)),
    Mistake("attitude keeps its initial value", _in_column("attitude", _constant)),
    Mistake(
        "position is in millimetres instead of metres", _in_column("position", lambda r: 1000 * r)
    ),
    Mistake(
        "position is in kilometres instead of metres", _in_column("position", lambda r: r / 1000)
    ),
    Mistake("position has the opposite sign", _in_column("position", np.negative)),
    Mistake("position keeps its initial value", _in_column("position", _constant)),
    Mistake("velocity is in mm/s instead of m/s", _in_column("velocity", lambda v: 1000 * v)),
    Mistake("velocity has the opposite sign", _in_column("velocity", np.negative)),
    *starmap(_reordered, product(COLUMNS, ORDERS)),
    Mistake("the bodies are in reverse order", _in_all_columns(lambda values: values[:, ::-1])),
    Mistake("each row is that of the previous sample", _in_all_columns(_previous_rows)),
    Mistake("each row is that of the next sample", _in_all_columns(_next_rows)),
)


def likely_causes(
    expected: Expected,
    observed: Expected,
    name: str,
    elapsed: Array,
    wrong_answers: Sequence[tuple[str, Expected]] = (),
) -> str:
    """The slips and mistakes that explain one column, as a clause; empty if no known one does.

    `expected` and `observed` have columns (T, N, ...) by name, `elapsed` (T,) [s] is the time
    since the start. `wrong_answers` has mistakes of the probe in words, with the columns that they
    would give.
    """
    explanations = []
    for mistake in MISTAKES:
        slipped = mistake.slip(expected)
        if name in slipped and distance(observed[name], slipped[name], name) <= MATCH_TOLERANCE:
            explanations.append(mistake.description)
    explanations += [
        description for description, wrong in wrong_answers if _explains(expected, observed, wrong)
    ]
    if not explanations:
        return _displaced_point_clause(expected, observed, name, elapsed)
    clause = " or ".join(explanations[:MAX_CAUSES])
    if len(explanations) > 1:
        clause += " (this probe cannot distinguish them)"
    return clause


def _explains(expected: Expected, observed: Expected, wrong: Expected) -> bool:
    """True if a mistake explains every column that it has, and most of what is not right there."""
    names = [name for name in wrong if name in observed and name in expected]
    if not names:
        return False
    residual = max(distance(observed[name], wrong[name], name) for name in names)
    error = max(distance(observed[name], expected[name], name) for name in names)
    return residual <= MATCH_TOLERANCE and residual <= MAX_RESIDUAL * error


def distance(values: Array, expected: Array, name: str) -> float:
    """The largest difference in units of the scale; q and -q are the same attitude."""
    difference = np.abs(values - expected)
    if name == "attitude":
        to_opposite = np.abs(values + expected)
        is_nearer = difference.max(axis=-1, keepdims=True) < to_opposite.max(axis=-1, keepdims=True)
        difference = np.where(is_nearer, difference, to_opposite)
    scale = max(1.0, float(np.abs(expected).max()))
    return float(difference.max() / scale)


def _displaced_point_clause(
    expected: Expected, observed: Expected, name: str, elapsed: Array
) -> str:
    """The clause that positions or velocities are those of a point displaced by d from the centre
    of mass; empty if no d explains the error.

    The error is linear in the displacement d (3,) in body axes, error(t) = M(t) d (`_error_maps`),
    so that d of each body is the least-squares solution over all samples.
    """
    needed = {"attitude", "omega", "position", "velocity"}
    if name not in ("position", "velocity") or not needed <= set(expected):
        return ""
    error = observed[name] - expected[name]
    for clause, maps in _error_maps(expected, name, elapsed):
        displacements = []
        for body in range(error.shape[1]):
            rows = maps[:, body].reshape(-1, 3)
            displacement, *_ = np.linalg.lstsq(rows, error[:, body].ravel(), rcond=None)
            displacements.append(displacement)
        explained = np.einsum("tnij,nj->tni", maps, np.array(displacements))
        if np.abs(error - explained).max() <= np.abs(error).max() / POINT_ERROR_RATIO:
            # Adding 0 turns -0 into 0.
            x, y, z = np.round(displacements[0], 3) + 0.0
            return f"{clause} by ({x:g}, {y:g}, {z:g}) m in body axes"
    return ""


def _error_maps(expected: Expected, name: str, elapsed: Array) -> list[tuple[str, Array]]:
    """Pairs of a clause and the matrices M (T, N, 3, 3) of the error M d that it makes.

    With the rotation R(t) and W v = omega x v:
    - another point of the body is at r + R d, with the velocity v + W R d;
    - a body whose centre of mass was put at d starts from there, with the velocity of that point,
      and the engine then moves the centre: its position is off by R(0) d + t W(0) R(0) d - R d and
      its velocity by W(0) R(0) d - W R d.
    """
    rotation = matrix(expected["attitude"])
    spin = _cross_matrix(expected["omega"])
    if name == "position":
        drift = rotation[0] + elapsed[:, None, None, None] * (spin[0] @ rotation[0])
        return [
            ("position is that of a point displaced from the centre of mass", rotation),
            ("the centre of mass is displaced from its place in the scene", drift - rotation),
        ]
    point_velocity = spin @ rotation
    return [
        ("velocity is that of a point displaced from the centre of mass", point_velocity),
        (
            "the centre of mass is displaced from its place in the scene",
            point_velocity[:1] - point_velocity,
        ),
    ]


def _cross_matrix(w: Array) -> Array:
    """The matrices (..., 3, 3) of v -> w x v."""
    x, y, z = np.moveaxis(w, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
