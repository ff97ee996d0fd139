"""MuJoCo 4 (Google DeepMind, Apache-2.0): what the adapter claims, refuses and runs.

MuJoCo itself is imported when it runs.
"""

import hashlib
from importlib.metadata import version
from importlib.util import find_spec

from refdem import kernels
from refdem.core import fingerprint
from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.mujoco.audit import AUDIT
from refdem.engines.mujoco.claims import METHODS
from refdem.engines.mujoco.unsupported import unsupported

__all__ = ["ENGINE"]


class Mujoco(Engine):
    """Bodies on slide, hinge or free joints, stepped by `mj_step` in a compiled loop."""

    name = "mujoco"
    title = "MuJoCo"
    licence = "Apache-2.0"
    default_step = 0.002
    methods = METHODS
    audit = AUDIT

    def missing(self) -> str | None:
        """None if MuJoCo is installed."""
        if find_spec("mujoco"):
            return None
        return "pip install refdem[mujoco]"

    def version(self) -> str:
        """The version of the installed package."""
        return version("mujoco")

    def fingerprint(self, method: Method) -> str:
        """Digest of MuJoCo's packages, this adapter, the scene's own code, the recorder and the
        machine.
        """
        parts = (
            fingerprint.of_package("mujoco"),
            fingerprint.of_package("mujoco-core"),
            fingerprint.of_source("engines/mujoco", "scene", "mechanics"),
            kernels.fingerprint("recorder", "mujoco_forces"),
            fingerprint.of_machine(),
        )
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None if MuJoCo can express the scene, else what is missing."""
        return unsupported(problem, method.name)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Compiles the scene and steps it in MuJoCo's own loop.

        Static questions are answered by MuJoCo's compiler and its functions for rotations.
        """
        if isinstance(request.problem, Motion):
            from refdem.engines.mujoco.session import run
        else:
            from refdem.engines.mujoco.statics import run

        return run(request)


ENGINE = Mujoco()
