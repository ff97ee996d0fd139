"""How a body that does not turn may move: not at all, or on slide joints along the axes that the
scene needs.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from refdem.scene import Body

Array = NDArray[np.float64]


class Columns(NamedTuple):
    """One body's samples: position, velocity (T, 3), attitude (T, 4), omega (T, 3) in space
    axes.
    """

    position: Array
    velocity: Array
    attitude: Array
    omega: Array


class Freedom(ABC):
    """One body with its joints: `nq` coordinates and `nv` velocities in MuJoCo's state."""

    body: Body
    nq: int
    nv: int

    @property
    def lineage(self) -> "tuple[Freedom, ...]":
        """The freedoms whose coordinates give the body's state: those of the bodies from which it
        hangs, then its own.
        """
        return (self,)

    @abstractmethod
    def add_body(self, mujoco: Any, parent: Any) -> Any:
        """Adds the body with its joints to `parent`, the world or the body from which it hangs, and
        returns it (MjsBody).
        """

    @abstractmethod
    def start(self) -> tuple[Array, Array]:
        """Coordinates (nq,) and velocities (nv,) of the scene's state."""

    @abstractmethod
    def read(self, q: Array, v: Array) -> Columns:
        """The body's columns from coordinates (T, nq) and velocities (T, nv)."""

    @property
    def turns(self) -> bool:
        """MuJoCo's body frame turns with the body; else its axes are those of space."""
        return False

    def still(self, count: int) -> tuple[Array, Array]:
        """Attitude (T, 4) and omega (T, 3) of a body that does not turn."""
        return np.tile(np.array(self.body.attitude, float), (count, 1)), np.zeros((count, 3))


@dataclass(frozen=True)
class Fixed(Freedom):
    """A body that is fixed to the world."""

    body: Body
    nq = 0
    nv = 0

    @property
    def turns(self) -> bool:
        return True

    def add_body(self, mujoco: Any, parent: Any) -> Any:
        return parent.add_body(pos=self.body.position, quat=self.body.attitude)

    def start(self) -> tuple[Array, Array]:
        return np.empty(0), np.empty(0)

    def read(self, q: Array, v: Array) -> Columns:
        count = len(q)
        position = np.tile(np.array(self.body.position, float), (count, 1))
        attitude, omega = self.still(count)
        return Columns(position, np.zeros((count, 3)), attitude, omega)


@dataclass(frozen=True)
class Slides(Freedom):
    """A body that does not turn: one slide joint an axis, whose coordinate is the position itself.

    `stiffness` (coefficients of the first, second and third power of the stretch) and `reference`
    (3,) [m] define a spring to the world. `friction` (3,) [N] is dry friction along each axis, with
    its solver parameters in `solver`. `damping` [N s/m] acts along every axis.
    """

    body: Body
    dimension: int
    stiffness: tuple[float, float, float]
    reference: tuple[float, ...]
    friction: tuple[float, ...]
    solver: dict[str, Any]
    damping: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "nq", self.dimension)
        object.__setattr__(self, "nv", self.dimension)

    def add_body(self, mujoco: Any, parent: Any) -> Any:
        # The body cannot turn, so that any inertia will do.
        mass = self.body.mass
        mj_body = parent.add_body(mass=mass, inertia=(1.0, 1.0, 1.0), explicitinertial=True)
        for k in range(self.dimension):
            forces = {
                "damping": (self.damping, 0.0, 0.0),
                "stiffness": self.stiffness,
                "springref": self.reference[k],
                "frictionloss": self.friction[k],
            }
            slide = mujoco.mjtJoint.mjJNT_SLIDE
            mj_body.add_joint(type=slide, axis=np.eye(3)[k], **forces, **self.solver)
        return mj_body

    def start(self) -> tuple[Array, Array]:
        return np.array(self.body.position[: self.nq]), np.array(self.body.velocity[: self.nv])

    def read(self, q: Array, v: Array) -> Columns:
        # Along axes without a joint the body is at 0 for good.
        missing_axes = ((0, 0), (0, 3 - self.dimension))
        attitude, omega = self.still(len(q))
        return Columns(np.pad(q, missing_axes), np.pad(v, missing_axes), attitude, omega)
