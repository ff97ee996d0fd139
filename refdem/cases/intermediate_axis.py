"""A body set spinning almost about its intermediate axis turns over, again and again: Euler's
equations (1.35)-(1.37), (1.134)-(1.136).
"""

import numpy as np

from refdem.cases import _attitude
from refdem.cases._attitude import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene


def _omega_body(p: Parameters) -> Array:
    """The angular velocity (3,) [rad/s] at the start: omega_body + offset |omega_body|
    e_direction.
    """
    start: Array = p.omega_body.copy()
    start[int(p.direction) - 1] += p.offset * np.linalg.norm(p.omega_body)
    return start


class IntermediateAxis(Case):
    """One body, no force, no torque, near the axis where rotation is unstable."""

    id = "intermediate-axis"
    title = "Intermediate axis"
    words = ("dzhanibekov", "tennis", "racket", "flip", "satellite", "tumbling")
    motion = "spinning"
    statement = (
        "A free body spins about its intermediate principal axis, a little off. The deviation grows"
        " exponentially until the body turns over, rests there, and turns back; near the other two"
        " axes the deviation stays bounded."
    )
    latex = (
        r"t_\text{flip}\approx\frac{2}{\lambda}\ln\frac{1}{\epsilon}+\text{const},\qquad "
        r"\lambda=\omega_2\sqrt{\frac{(J_2-J_1)(J_3-J_2)}{J_1J_3}}"
    )
    source = "Matuttis and Chen 2014, chapter 1, (1.134)-(1.138), fig. 1.36, section 1.7.3"
    parameters = (
        _attitude.INERTIA,
        Parameter(
            name="omega_body",
            default="0,1,0",
            unit="rad/s",
            doc="angular velocity before the offset",
            shape=(3,),
        ),
        _attitude.ATTITUDE,
        Parameter(
            name="offset",
            default="1/64",
            unit="1",
            doc="part of |omega_body| added along `direction`",
            above=0,
            at_most=1,
        ),
        Parameter(
            name="direction",
            default="1",
            unit="1",
            doc="principal axis of the offset",
            choices=("1", "3"),
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for values that make no spinning body."""
        _attitude.refuse(p)
        if not _omega_body(p).any():
            raise UsageError(
                f"parameter offset: got {p.offset:g} along {p.direction}, which stops the body;"
                " expected another size or direction"
            )

    def scene(self, p: Parameters) -> Scene:
        """The body, which starts with its centre at the origin."""
        return _attitude.scene(p, _omega_body(p))

    def scales(self, p: Parameters) -> Scales:
        """The scales of the motion, with tau = 1/|omega| at the start."""
        return _attitude.scales(p, _omega_body(p))

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The components of angular velocity and attitude."""
        return _attitude.quantities(float(np.linalg.norm(_omega_body(p))))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The angular velocity (T,) [rad/s] and the attitude, by component."""
        return _attitude.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Jacobi elliptic and theta functions; tanh and sech on the separatrix."""
        from refdem.truth.closed_forms.intermediate_axis import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = IntermediateAxis()
