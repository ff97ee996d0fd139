"""What an adapter may have got wrong, told from how a probe came back: known slips, each tried on
what should have come.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product, starmap

import numpy as np
from numpy.typing import NDArray

from refdem.campaign.probes import Expected
from refdem.core.trajectory import STATE
from refdem.mechanics.quaternion import conjugate, matrix, rotated

Array = NDArray[np.float64]
Slip = Callable[[Expected], Expected]

NEAR = 0.02
"""A slip explains a column if what it makes of the right one is within this part of its scale."""
POINT_FACTOR = 10.0
"""A displaced point explains what came if it leaves less than a tenth of what was wrong."""


@dataclass(frozen=True)
class Suspect:
    """A slip in words, and what it makes of the right columns; only those that it changes."""

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
    """Every row is that before it; the first stays."""
    return np.concatenate([values[:1], values[:-1]])


def _a_row_after(values: Array) -> Array:
    """Every row is that after it; the last stays."""
    return np.concatenate([values[1:], values[-1:]])


def _in_all(change: Callable[[Array], Array]) -> Slip:
    """A slip in every column of the state."""
    return lambda right: {name: change(values) for name, values in right.items() if name in STATE}


def _from_body(name: str) -> Slip:
    """A vector in body axes that should be in space axes."""

    def slip(right: Expected) -> Expected:
        if name not in right or "attitude" not in right:
            return {}
        return {name: rotated(conjugate(right["attitude"]), right[name])}

    return slip


def _reordered(name: str, order: str) -> Suspect:
    """The axes of a column in another order."""
    numbers = ["xyz".index(axis) for axis in order]
    return Suspect(
        f"the axes of its {name} come in the order {order}",
        _of(name, lambda values: values[..., numbers]),
    )


ORDERS = ("xzy", "yxz", "zyx", "yzx", "zxy")
COLUMNS = ("position", "velocity", "omega")
SUSPECTS = (
    Suspect("its quaternion has w last", _of("attitude", lambda q: np.roll(q, -1, axis=-1))),
    Suspect(
        "its quaternion has w last and is read with w first",
        _of("attitude", lambda q: np.roll(q, 1, axis=-1)),
    ),
    Suspect("its quaternion takes space to body axes", _of("attitude", conjugate)),
    Suspect("its omega is in body axes", _from_body("omega")),
    Suspect("its velocity is in body axes", _from_body("velocity")),
    Suspect("its position is in body axes", _from_body("position")),
    Suspect("its omega is in degrees per second", _of("omega", np.degrees)),
    Suspect("its omega is in turns per second", _of("omega", lambda w: w / (2 * np.pi))),
    Suspect("its omega has the other sign", _of("omega", np.negative)),
    Suspect("its omega is zero", _of("omega", lambda w: 0 * w)),
    Suspect(
        "its attitude never changes", _of("attitude", lambda q: np.repeat(q[:1], len(q), axis=0))
    ),
    Suspect("its position is in millimetres", _of("position", lambda r: 1000 * r)),
    Suspect("its position is in kilometres", _of("position", lambda r: r / 1000)),
    Suspect("its position has the other sign", _of("position", np.negative)),
    Suspect(
        "its position never changes", _of("position", lambda r: np.repeat(r[:1], len(r), axis=0))
    ),
    Suspect("its velocity is in millimetres per second", _of("velocity", lambda v: 1000 * v)),
    Suspect("its velocity has the other sign", _of("velocity", np.negative)),
    *starmap(_reordered, product(COLUMNS, ORDERS)),
    Suspect("its bodies come in the other order", _in_all(lambda values: values[:, ::-1])),
    Suspect("every row is that of the sample before", _in_all(_a_row_before)),
    Suspect("every row is that of the sample after", _in_all(_a_row_after)),
)


def suspicion(right: Expected, seen: Expected, name: str, since: Array) -> str:
    """What is wrong with one column, as a clause; empty if no known slip makes it.

    `right` and `seen` have columns (T, N, ...) by name, `since` (T,) [s] is the time from the
    start.
    """
    found = []
    for suspect in SUSPECTS:
        slipped = suspect.slip(right)
        if name in slipped and _is_near(seen[name], slipped[name], name):
            found.append(suspect.says)
    if found:
        return " or ".join(found[:2])
    return _displaced(right, seen, name, since)


def _is_near(seen: Array, expected: Array, name: str) -> bool:
    """Within NEAR of the scale; q and -q are the same attitude."""
    off = np.abs(seen - expected)
    if name == "attitude":
        other = np.abs(seen + expected)
        is_nearer = off.max(axis=-1, keepdims=True) < other.max(axis=-1, keepdims=True)
        off = np.where(is_nearer, off, other)
    scale = max(1.0, float(np.abs(expected).max()))
    return bool(off.max() <= NEAR * scale)


def _displaced(right: Expected, seen: Expected, name: str, since: Array) -> str:
    """A point other than the centre of mass, by the displacement in body axes that explains what
    came; empty if none does.
    """
    needed = {"attitude", "omega", "position", "velocity"}
    if name not in ("position", "velocity") or not needed <= set(right):
        return ""
    off = seen[name] - right[name]
    for says, arms in _arms(right, name, since):
        # Of each body the displacement that explains most, by least squares over the samples.
        shifts = []
        for body in range(off.shape[1]):
            rows = arms[:, body].reshape(-1, 3)
            shift, *_ = np.linalg.lstsq(rows, off[:, body].ravel(), rcond=None)
            shifts.append(shift)
        made = np.einsum("tnij,nj->tni", arms, np.array(shifts))
        if np.abs(off - made).max() <= np.abs(off).max() / POINT_FACTOR:
            x, y, z = np.round(shifts[0], 3) + 0.0
            return f"{says}, displaced by ({x:g}, {y:g}, {z:g}) m in body axes"
    return ""


def _arms(right: Expected, name: str, since: Array) -> list[tuple[str, Array]]:
    """Matrices (T, N, 3, 3) that take a displacement in body axes to the error that it makes, with
    what would be wrong.
    """
    turn = matrix(right["attitude"])
    crossed = _cross_matrix(right["omega"])
    start = turn[0] + since[:, None, None, None] * (crossed[0] @ turn[0])
    if name == "position":
        # A point of the body is at r + R d; a body whose centre of mass is at d starts there and
        # moves on from there.
        return [
            ("its position is that of another point", turn),
            ("its centre of mass is not where the scene has it", start - turn),
        ]
    swept = crossed @ turn
    return [
        ("its velocity is that of another point", swept),
        ("its centre of mass is not where the scene has it", swept[:1] - swept),
    ]


def _cross_matrix(w: Array) -> Array:
    """The matrices (..., 3, 3) of v -> w x v."""
    x, y, z = np.moveaxis(w, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
