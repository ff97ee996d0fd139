"""REBOUND: particles in fields of force by leapfrog, WHFast, IAS15 and Bulirsch-Stoer.

GPL-3: imported only in this adapter.
"""

from importlib.metadata import version
from importlib.util import find_spec

from refdem import kernels
from refdem.core import fingerprint
from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.rebound.audit import AUDIT
from refdem.engines.rebound.methods import METHODS
from refdem.engines.rebound.unsupported import reason

KNOWN = frozenset(
    f"identity:{name}" for name in ("quaternion-about", "product", "inverse", "unit", "rotated")
)
ROTATION = Method(
    name="rotation",
    summary="unit quaternions, rebound.Rotation",
    control="exact",
    answers="identity",
    knows=KNOWN,
)


class Rebound(Engine):
    """REBOUND through its Python package; stepped by a compiled loop over its own steps."""

    name = "rebound"
    title = "REBOUND"
    methods = (*METHODS, ROTATION)
    audit = AUDIT
    licence = "GPL-3.0-or-later"
    default_step = 0.001

    def missing(self) -> str | None:
        """None if REBOUND is installed, else how to install it."""
        if find_spec("rebound"):
            return None
        return "REBOUND is not installed: pip install 'refdem[rebound]'"

    def version(self) -> str:
        """The version of the package rebound."""
        return version("rebound")

    def fingerprint(self, method: Method) -> str:
        """Digest of the installed package, this adapter, the scene's vocabulary, the callbacks and
        the machine.
        """
        return "-".join(
            (
                fingerprint.of_package("rebound"),
                fingerprint.of_source("engines/rebound"),
                fingerprint.of_source("scene"),
                kernels.fingerprint("rebound_forces"),
                fingerprint.of_machine(),
            )
        )

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None, or what the scene has that the method cannot run."""
        return reason(problem, method.name)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Runs one request; the times are the engine's own clock."""
        if not isinstance(request.problem, Motion):
            from refdem.engines.rebound.statics import run

            return run(request)
        from refdem.engines.rebound.run import recorded

        return recorded(request)


ENGINE = Rebound()
