"""Derivatives by the start: `mjd_transitionFD`, MuJoCo's differences of its own step, chained.

With the tangent x (2 nv,) of coordinates and velocities, and A_n the matrix of step n,

    x_{n+1} = A_n x_n,    A_n = d(state after the step)/d(state before it).

The tangent of a coordinate is a velocity; a rotation has three components, in body axes. The input
dx_0/ds and the output d(states)/dx are differences of order 6 of the smooth maps between MuJoCo's
coordinates and the states of a scene.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Request
from refdem.core.scene_numbers import APART, slope
from refdem.core.trajectory import STATE
from refdem.engines.mujoco.joints import Freedom
from refdem.engines.mujoco.model import freedoms_of
from refdem.scene import Scene
from refdem.scene.elements.rod import Rod

Array = NDArray[np.float64]
Start = Callable[[list[Freedom]], tuple[Array, Array]]
"""All coordinates (nq,) and velocities (nv,) of joints at the start."""
Read = Callable[[Array, Array], dict[str, Array]]
"""The states by column (T, N, ...) from coordinates (T, nq) and velocities (T, nv)."""

PART = 2.0**-17
"""MuJoCo's `eps` relative to the size of coordinates. A central difference has a truncation error
of PART^2/6 = 2^-36.6 times the third derivative, and a rounding error of about 2^-53/PART = 2^-36.
"""
DISTANCE = float(APART)
"""The size of the differences of order 6, in units of what is moved."""


def chained(mujoco: Any, model: Any, data: Any, request: Request, rows: Array) -> Array:
    """The products (T, 2 nv, 2 nv) of the matrices of all steps up to each sample.

    `rows` are those of the same run without derivatives; `data` is run once more from their first.
    """
    data.qpos[:] = rows[0, : model.nq]
    data.qvel[:] = rows[0, model.nq : -1]
    data.time = rows[0, -1]
    eps = PART * _size(model, rows)
    of_step = np.zeros((2 * model.nv, 2 * model.nv))
    product = np.eye(2 * model.nv)
    products = np.empty((len(rows), *product.shape))
    products[0] = product
    for sample in range(1, len(rows)):
        for _ in range(request.stride):
            mujoco.mjd_transitionFD(model, data, eps, True, of_step, None, None, None)
            mujoco.mj_step(model, data)
            product = after_step(of_step, product)
        products[sample] = product
    return products


def after_step(of_step: Array, product: Array) -> Array:
    """The product of the matrices of all steps, that of the last one included."""
    return of_step @ product


def _size(model: Any, rows: Array) -> float:
    """The size of coordinates: 1 of angles, the largest of the run of positions alone."""
    # Of the types of joints only slides (mjJNT_SLIDE = 2) have positions and no angle.
    if np.all(model.jnt_type == 2):
        return float(np.max(np.abs(rows[:, : model.nq]), initial=0.0)) or 1.0
    return 1.0


def of_states(
    mujoco: Any,
    model: Any,
    request: Request,
    rows: Array,
    products: Array,
    start: Start,
    read: Read,
) -> dict[str, Array]:
    """The derivatives (T, N, 13) of the reported states by each requested number."""
    derivatives = {}
    for key in request.sensitivities:
        tangents = products @ _of_start(mujoco, model, request, key, start)
        derivatives[key] = _state_derivatives(mujoco, model, rows, tangents, read)
    return derivatives


def _of_start(mujoco: Any, model: Any, request: Request, key: str, start: Start) -> Array:
    """The tangent (2 nv,) of the start by a number of it, dx_0/ds."""
    scene = request.problem.scene
    _, _, body, column, component = key.split(".")
    distance = DISTANCE * _reach(scene, column)

    def moved(k: int) -> tuple[Array, Array]:
        """The start with the number moved by k distances."""
        values = np.array(getattr(scene.bodies, column), float)
        values[int(body), int(component)] += k * distance
        if column == "attitude":
            values[int(body)] /= np.linalg.norm(values[int(body)])
        other = scene.with_state(**{column: values})
        return start(freedoms_of(other, request.method, request.step or 0.0))

    unmoved, _ = moved(0)

    def away(k: int) -> Array:
        """The displacement of that start from the given one, as a tangent."""
        q, v = moved(k)
        tangent = np.empty(model.nv)
        mujoco.mj_differentiatePos(model, tangent, 1.0, unmoved, q)
        return np.concatenate([tangent, v])

    slopes: Array = slope(away) / distance
    return slopes


def _reach(scene: Scene, column: str) -> float:
    """The size by which a number of the start is displaced: that of a column of the bodies.

    For positions at rods it is the shortest rod, as angles are no linear functions of positions.
    """
    rods = [rod.length for rod in scene.all(Rod)]
    if column == "position" and rods:
        return float(min(rods))
    return float(np.max(np.abs(getattr(scene.bodies, column)))) or 1.0


def _state_derivatives(mujoco: Any, model: Any, rows: Array, tangents: Array, read: Read) -> Array:
    """The derivative (T, N, 13) of the states along tangents (T, 2 nv) of all samples."""
    fastest = float(np.max(np.abs(tangents))) or 1.0
    distance = DISTANCE * _size(model, rows) / fastest

    def moved(k: int) -> Array:
        """The states k distances along the tangents."""
        q = np.array(rows[:, : model.nq])
        for coordinates, tangent in zip(q, tangents, strict=True):
            mujoco.mj_integratePos(model, coordinates, tangent[: model.nv], k * distance)
        v = rows[:, model.nq : -1] + k * distance * tangents[:, model.nv :]
        states = read(q, v)
        return np.concatenate([states[name] for name in STATE], axis=-1)

    slopes: Array = slope(moved) / distance
    return slopes
