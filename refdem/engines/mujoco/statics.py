"""Mass properties of solids from MuJoCo's compiler, and rotation algebra by its functions mju_*."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from refdem.core.problem import Identity, Request, Solid
from refdem.core.static_problems import (
    Cuboid,
    Cylinder,
    Ellipsoid,
    Piece,
    body,
    properties,
    results,
)
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.mujoco.unsupported import SMALLEST
from refdem.errors import UnsupportedError
from refdem.scene import Polyhedron

Array = NDArray[np.float64]


def run(request: Request) -> tuple[Trajectory, Cost]:
    """Mass properties by the compiler, or the results of operations."""
    problem = request.problem
    started = perf_counter()
    if isinstance(problem, Solid):
        if request.method == "mesh-compiler":
            values = properties(problem, meshed)
        else:
            values = properties(problem, compiled)
    else:
        assert isinstance(problem, Identity)
        values = results(problem, ANSWERS)
    return Trajectory.of_values(problem.times, values), Cost(seconds=perf_counter() - started)


def compiled(piece: Piece) -> dict[str, float] | None:
    """A geom of the solid's own kind."""
    shape = piece.shape
    if isinstance(shape, Cuboid):
        return _of_geom(
            piece, type=mujoco.mjtGeom.mjGEOM_BOX, size=[side / 2 for side in shape.sides]
        )
    if isinstance(shape, Ellipsoid):
        return _of_geom(piece, type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=list(shape.half_axes))
    if isinstance(shape, Cylinder) and shape.half_axes[0] == shape.half_axes[1]:
        return _of_geom(
            piece,
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[shape.half_axes[0], shape.height / 2, 0.0],
        )
    return None


def meshed(piece: Piece) -> dict[str, float] | None:
    """A mesh with exact inertia; faces are cut into triangles."""
    shape = piece.shape
    if not isinstance(shape, Polyhedron):
        return None
    triangles = [
        index
        for face in shape.faces
        for k in range(1, len(face) - 1)
        for index in (face[0], face[k], face[k + 1])
    ]
    mesh = {"uservert": np.array(shape.vertices).ravel().tolist(), "userface": triangles}
    return _of_geom(piece, mesh=mesh, type=mujoco.mjtGeom.mjGEOM_MESH, meshname="solid")


def _of_geom(
    piece: Piece, *, mesh: dict[str, Any] | None = None, **geom: Any
) -> dict[str, float] | None:
    """Mass, place and tensor of the compiled body.

    None for solids that no geom can represent: hollow ones, or a tensor about another point.
    """
    if piece.hollow is not None or piece.about is not None:
        return None
    specification = mujoco.MjSpec()
    if mesh is not None:
        specification.add_mesh(
            name="solid", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT, **mesh
        )
    holder = specification.worldbody.add_body()
    holder.add_freejoint()
    attitude = np.array(piece.attitude)
    holder.add_geom(density=piece.density, quat=attitude / np.linalg.norm(attitude), **geom)
    try:
        model = specification.compile()
    except ValueError as error:
        if "mjMINVAL" not in str(error):
            raise
        raise UnsupportedError(
            f"the mass [kg] or a principal inertia [kg m^2] of {piece.name} is below mjMINVAL ="
            f" {SMALLEST:g}, the least that MuJoCo's compiler takes of a body that moves"
        ) from error
    turn = _new(9, mujoco.mju_quat2Mat, model.body_iquat[1]).reshape(3, 3)
    return body(
        model.body_mass[1], model.body_ipos[1], turn @ np.diag(model.body_inertia[1]) @ turn.T
    )


def _new(size: int, function: Callable[..., None], *operands: Any) -> Array:
    """The array (size,) that a function of MuJoCo fills."""
    result = np.empty(size)
    function(result, *operands)
    return result


def _by(size: int, function: Callable[..., None]) -> Callable[..., Array]:
    return lambda *operands: _new(size, function, *operands)


def _quaternion(matrix: Array) -> Array:
    """The quaternion (4,) of a matrix: of the two, that with w >= 0."""
    q = _new(4, mujoco.mju_mat2Quat, matrix)
    if q[0] >= 0:
        return q
    return -q


def _nearest(matrix: Array) -> Array:
    """The rotation matrix (9,) nearest to a matrix, refined from the quaternion that is read from
    its entries.
    """
    q = _new(4, mujoco.mju_mat2Quat, matrix)
    mujoco.mju_mat2Rot(q, matrix)
    return _new(9, mujoco.mju_quat2Mat, q)


ANSWERS: dict[str, Callable[..., Any]] = {
    "quaternion-about": lambda axis, angle: _new(4, mujoco.mju_axisAngle2Quat, axis, angle[0]),
    "turn-about": lambda axis, angle: _new(
        9, mujoco.mju_quat2Mat, _new(4, mujoco.mju_axisAngle2Quat, axis, angle[0])
    ),
    "matrix-product": lambda m, n: _new(
        9, lambda out, *_: mujoco.mju_mulMatMat(out.reshape(3, 3), m.reshape(3, 3), n.reshape(3, 3))
    ),
    "matrix-vector": lambda m, v: _new(3, mujoco.mju_mulMatVec, m.reshape(3, 3), v),
    "sum": _by(4, mujoco.mju_add),
    "difference": _by(4, mujoco.mju_sub),
    "vector-sum": _by(3, mujoco.mju_add3),
    "vector-difference": _by(3, mujoco.mju_sub3),
    "matrix-difference": _by(9, mujoco.mju_sub),
    "transpose": lambda m: _new(
        9, lambda out: mujoco.mju_transpose(out.reshape(3, 3), m.reshape(3, 3))
    ),
    "nearest-turn": _nearest,
    "product": _by(4, mujoco.mju_mulQuat),
    "conjugate": _by(4, mujoco.mju_negQuat),
    "rotated": lambda q, v: _new(3, mujoco.mju_rotVecQuat, v, q),
    "matrix-of-quaternion": _by(9, mujoco.mju_quat2Mat),
    "quaternion-of-matrix": _quaternion,
    "quaternion-of-euler": lambda euler: _new(4, mujoco.mju_euler2Quat, euler, "zxz"),
    "rate": _by(4, mujoco.mju_derivQuat),
    "unit": lambda q: (u := q.copy(), mujoco.mju_normalize4(u))[0],
    "absolute": lambda q: mujoco.mju_norm(q),
    "dot": lambda p, q: mujoco.mju_dot(p, q),
}
"""MuJoCo's own function for each operation that it has."""
