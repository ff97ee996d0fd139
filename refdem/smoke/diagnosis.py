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

NEAR = 0.02
"""Largest difference, relative to the scale, of an observed column and that of a slip which
explains it.
"""
LEFT = 0.25
"""Largest fraction of an error that a mistake which explains it leaves."""
MOST_NAMED = 4
"""Largest number of equally good explanations that are named."""
POINT_FACTOR = 10.0
"""Largest fraction of an error that a displaced point which explains it leaves."""


@dataclass(frozen=True)
class Mistake:
    """A slip in words, and as a function from the right columns to the wrong ones that it makes."""

    says: str
    slip: Slip


def _of(name: str, change: Callable[[Array], Array]) -> Slip:
    """A slip that changes one column, and nothing where there is no such column."""

    def slip(right: Expected) -> Expected:
        if name not in right:
            return {}
        return {name: change(right[name])}

    return slip


def _a_row_before(values: Array) -> Array:
    """The rows, each replaced by the one before it; the first stays."""
    return np.concatenate([values[:1], values[:-1]])


def _a_row_after(values: Array) -> Array:
    """The rows, each replaced by the one after it; the last stays."""
    return np.concatenate([values[1:], values[-1:]])


def _in_all(change: Callable[[Array], Array]) -> Slip:
    """A slip in every column of the state."""
    return lambda right: {name: change(values) for name, values in right.items() if name in STATE}


def _from_body(name: str) -> Slip:
    """The slip that a vector is in body axes where it should be in space axes: v -> q* v q."""

    def slip(right: Expected) -> Expected:
        if name not in right or "attitude" not in right:
            return {}
        return {name: rotated(conjugate(right["attitude"]), right[name])}

    return slip


def _reordered(name: str, order: str) -> Mistake:
    """The slip that a column has its axes in another order, such as "xzy"."""
    numbers = ["xyz".index(axis) for axis in order]
    reorder = _of(name, lambda values: values[..., numbers])
    return Mistake(f"the axes of its {name} come in the order {order}", reorder)


COLUMNS = ("position", "velocity", "omega")
MISTAKES = (
    Mistake("its quaternion has w last", _of("attitude", lambda q: np.roll(q, -1, axis=-1))),
    Mistake(
        "its quaternion has w last and is read with w first",
        _of("attitude", lambda q: np.roll(q, 1, axis=-1)),
    ),
    Mistake("its quaternion takes space to body axes", _of("attitude", conjugate)),
    Mistake("its omega is in body axes", _from_body("omega")),
    Mistake("its velocity is in body axes", _from_body("velocity")),
    Mistake("its position is in body axes", _from_body("position")),
    Mistake("its omega is in degrees per second", _of("omega", np.degrees)),
    Mistake("its omega is in turns per second", _of("omega", lambda w: w / (2 * np.pi))),
    Mistake("its omega has the other sign", _of("omega", np.negative)),
    Mistake("its omega is zero", _of("omega", lambda w: 0 * w)),
    Mistake(
        "its attitude never changes", _of("attitude", lambda q: np.repeat(q[:1], len(q), axis=0))
    ),
    Mistake("its position is in millimetres", _of("position", lambda r: 1000 * r)),
    Mistake("its position is in kilometres", _of("position", lambda r: r / 1000)),
    Mistake("its position has the other sign", _of("position", np.negative)),
    Mistake(
        "its position never changes", _of("position", lambda r: np.repeat(r[:1], len(r), axis=0))
    ),
    Mistake("its velocity is in millimetres per second", _of("velocity", lambda v: 1000 * v)),
    Mistake("its velocity has the other sign", _of("velocity", np.negative)),
    *starmap(_reordered, product(COLUMNS, ORDERS)),
    Mistake("its bodies come in the other order", _in_all(lambda values: values[:, ::-1])),
    Mistake("every row is that of the sample before", _in_all(_a_row_before)),
    Mistake("every row is that of the sample after", _in_all(_a_row_after)),
)


def diagnosed(
    right: Expected,
    observed: Expected,
    name: str,
    elapsed: Array,
    mistaken: Sequence[tuple[str, Expected]] = (),
) -> str:
    """The slips and mistakes that explain one column, as a clause; empty if no known one does.

    `right` and `observed` have columns (T, N, ...) by name, `elapsed` (T,) [s] is the time since
    the start. `mistaken` has mistakes of the probe in words, with the columns that they would give.
    """
    explanations = []
    for mistake in MISTAKES:
        slipped = mistake.slip(right)
        if name in slipped and distance(observed[name], slipped[name], name) <= NEAR:
            explanations.append(mistake.says)
    explanations += [says for says, wrong in mistaken if _explains(right, observed, wrong)]
    if not explanations:
        return _displaced(right, observed, name, elapsed)
    clause = " or ".join(explanations[:MOST_NAMED])
    if len(explanations) > 1:
        clause += " (this probe cannot tell these apart)"
    return clause


def _explains(right: Expected, observed: Expected, wrong: Expected) -> bool:
    """True if a mistake explains every column that it has, and most of what is not right there."""
    names = [name for name in wrong if name in observed and name in right]
    if not names:
        return False
    left = max(distance(observed[name], wrong[name], name) for name in names)
    error = max(distance(observed[name], right[name], name) for name in names)
    return left <= NEAR and left <= LEFT * error


def distance(values: Array, expected: Array, name: str) -> float:
    """The largest difference in units of the scale; q and -q are the same attitude."""
    difference = np.abs(values - expected)
    if name == "attitude":
        to_opposite = np.abs(values + expected)
        is_nearer = difference.max(axis=-1, keepdims=True) < to_opposite.max(axis=-1, keepdims=True)
        difference = np.where(is_nearer, difference, to_opposite)
    scale = max(1.0, float(np.abs(expected).max()))
    return float(difference.max() / scale)


def _displaced(right: Expected, observed: Expected, name: str, elapsed: Array) -> str:
    """The clause that positions or velocities are those of a point displaced by d from the centre
    of mass; empty if no d explains the error.

    The error is linear in the displacement d (3,) in body axes, error(t) = M(t) d (`_error_maps`),
    so that d of each body is the least-squares solution over all samples.
    """
    needed = {"attitude", "omega", "position", "velocity"}
    if name not in ("position", "velocity") or not needed <= set(right):
        return ""
    error = observed[name] - right[name]
    for clause, maps in _error_maps(right, name, elapsed):
        displacements = []
        for body in range(error.shape[1]):
            rows = maps[:, body].reshape(-1, 3)
            displacement, *_ = np.linalg.lstsq(rows, error[:, body].ravel(), rcond=None)
            displacements.append(displacement)
        explained = np.einsum("tnij,nj->tni", maps, np.array(displacements))
        if np.abs(error - explained).max() <= np.abs(error).max() / POINT_FACTOR:
            # Adding 0 turns -0 into 0.
            x, y, z = np.round(displacements[0], 3) + 0.0
            return f"{clause}, displaced by ({x:g}, {y:g}, {z:g}) m in body axes"
    return ""


def _error_maps(right: Expected, name: str, elapsed: Array) -> list[tuple[str, Array]]:
    """Pairs of a clause and the matrices M (T, N, 3, 3) of the error M d that it makes.

    With the rotation R(t) and W v = omega x v:
    - another point of the body is at r + R d, with the velocity v + W R d;
    - a body whose centre of mass was put at d starts from there, with the velocity of that point,
      and the engine then moves the centre: its position is off by R(0) d + t W(0) R(0) d - R d and
      its velocity by W(0) R(0) d - W R d.
    """
    rotation = matrix(right["attitude"])
    spin = _cross_matrix(right["omega"])
    if name == "position":
        drift = rotation[0] + elapsed[:, None, None, None] * (spin[0] @ rotation[0])
        return [
            ("its position is that of another point", rotation),
            ("its centre of mass is not where the scene has it", drift - rotation),
        ]
    point_velocity = spin @ rotation
    return [
        ("its velocity is that of another point", point_velocity),
        ("its centre of mass is not where the scene has it", point_velocity[:1] - point_velocity),
    ]


def _cross_matrix(w: Array) -> Array:
    """The matrices (..., 3, 3) of v -> w x v."""
    x, y, z = np.moveaxis(w, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
