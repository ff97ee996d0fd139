"""pymunk (Chipmunk): planar rigid bodies, symplectic Euler, iterated impulses for joints and
contact.
"""

from dataclasses import replace
from importlib.metadata import version
from importlib.util import find_spec

from refdem import kernels
from refdem.core import fingerprint
from refdem.core.engine import Engine, Method
from refdem.core.problem import Motion, Request
from refdem.core.trajectory import Cost, Trajectory
from refdem.engines.pymunk.audit import AUDIT
from refdem.engines.pymunk.unsupported import reason

POSITION_CORRECTION = {"angular-momentum": frozenset({"contact:rigid"})}
"""Chipmunk separates overlapping rigid bodies along their normal and leaves their velocities
unchanged. Angular momentum then changes by p n x (v_a - v_b), in proportion to the overlap. A
friction impulse acts at the two surfaces, which do not coincide where bodies overlap. Soft contacts
are springs, which conserve angular momentum."""
UNIT_BY_ANGLE = {
    "attitude": "the adapter makes attitudes of Chipmunk's angles, so that their norm is always 1"
}
SEMI_IMPLICIT_EULER = Method(
    name="semi-implicit-euler",
    summary=(
        "Chipmunk's step: positions with the old velocities, forces there, then velocities with"
        " impulses for joints"
    ),
    control="step",
    order=1,
    conserves=frozenset({"momentum", "angular-momentum"}),
    broken_with=POSITION_CORRECTION,
    derived=UNIT_BY_ANGLE,
    symplectic=True,
)
AS_SHIPPED = replace(
    SEMI_IMPLICIT_EULER,
    name="semi-implicit-euler-as-shipped",
    summary=(
        "the same step with pymunk's defaults: shapes may overlap by 0.1 m, 10 iterations, joints"
        " of whose drift 0.9**60 is left after a second"
    ),
    as_shipped=True,
)
TURNS = frozenset({"identity:plane-turn", "identity:complex-turn"})
STATICS = (
    Method(
        name="moments",
        summary="area, centre and moment of convex polygons",
        control="exact",
        answers="solid",
        knows=frozenset({"solid:polygon"}),
    ),
    Method(
        name="vectors", summary="Vec2d's turns", control="exact", answers="identity", knows=TURNS
    ),
)


class Pymunk(Engine):
    """Chipmunk through pymunk, in the x-y plane; stepped by a compiled loop over `cpSpaceStep`."""

    name = "pymunk"
    title = "pymunk (Chipmunk)"
    methods = (SEMI_IMPLICIT_EULER, AS_SHIPPED, *STATICS)
    audit = AUDIT
    licence = "MIT"

    def missing(self) -> str | None:
        """None if pymunk is installed, else how to install it."""
        if find_spec("pymunk"):
            return None
        return "pymunk is not installed: pip install 'refdem[pymunk]'"

    def version(self) -> str:
        """The version of the package pymunk."""
        return version("pymunk")

    def fingerprint(self, method: Method) -> str:
        """Digest of the installed package (Chipmunk is in it), this adapter, the scene's
        vocabulary, the loop and the machine.
        """
        return "-".join(
            (
                fingerprint.of_package("pymunk"),
                fingerprint.of_source("engines/pymunk"),
                fingerprint.of_source("scene"),
                kernels.fingerprint("chipmunk"),
                fingerprint.of_machine(),
            )
        )

    def unsupported_motion(self, problem: Motion, method: Method) -> str | None:
        """None, or what the scene has that Chipmunk cannot express."""
        return reason(problem)

    def run(self, request: Request) -> tuple[Trajectory, Cost]:
        """Runs one request; the engine has no clock, so a time is its number of steps times h."""
        if not isinstance(request.problem, Motion):
            from refdem.engines.pymunk.statics import run

            return run(request)
        from refdem.engines.pymunk.run import recorded

        return recorded(request)


ENGINE = Pymunk()
