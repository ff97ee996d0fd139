"""A body that goes elsewhere when the products of angular velocities are left out of Euler's
equations (fig. 1.12).
"""

import numpy as np
from numpy.linalg import norm

from refdem.cases import _attitude, _tumbling
from refdem.cases._attitude import Array
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene

LASTS = 0.6
"""Duration [s] that figure 1.12 shows."""
TEN_PI = "31.41592653589793"


class NeglectedGyroscopic(Case):
    """A homogeneous box: its sides on the slope follow from its mass and moments of inertia."""

    id = "neglected-gyroscopic"
    title = "Neglected gyroscopic term"
    words = ("gyroscope", "euler", "satellite", "sign")
    motion = "spinning"
    statement = (
        "A box flies freely, or falls on a slope and tumbles down it on its corners. Whoever leaves"
        " the products of angular velocities out of Euler's equations gets another motion: that run"
        " is the fault no-gyroscopic-term, and it is flagged in both members."
    )
    latex = (
        r"J\dot\omega+\omega\times J\omega=\tau\quad\text{against the wrong"
        r" }\;J\dot\omega=\tau,\qquad m\dot v=F"
    )
    source = "Matuttis and Chen 2014, chapter 1, fig. 1.12 and (1.35)-(1.38)"
    parameters = (
        Parameter(
            name="member",
            default="free",
            unit="1",
            doc="flies, or tumbles",
            choices=(_tumbling.FREE, _tumbling.SLOPE),
        ),
        Parameter(
            name="inertia",
            default="2e-5,4e-5,5.2e-5",
            unit="kg m^2",
            doc=_attitude.INERTIA.doc,
            shape=(3,),
            above=0,
        ),
        Parameter(
            name="omega_body",
            default=f"{TEN_PI},{TEN_PI},{TEN_PI}",
            unit="rad/s",
            doc="in principal axes; 10 pi to 16 digits",
            shape=(3,),
        ),
        _attitude.ATTITUDE,
        Parameter(
            name="velocity",
            default="0,0,0.025",
            unit="m/s",
            doc="of the centre at the start",
            shape=(3,),
        ),
        *_tumbling.PARAMETERS,
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for values that make no spinning box above the slope."""
        _tumbling.refuse(p)

    def scene(self, p: Parameters) -> Scene:
        """The box alone, or above the slope."""
        return _tumbling.scene(p)

    def scales(self, p: Parameters) -> Scales:
        """L is the largest radius of gyration; 1/tau^2 = |omega|^2, plus 4 k/m on the slope, where
        up to four corners touch.
        """
        if p.member == _tumbling.SLOPE:
            contacts = 4 * p.stiffness / p.mass
        else:
            contacts = 0.0
        tau = float(1 / np.sqrt(norm(p.omega_body) ** 2 + contacts))
        gyration_radius = float(np.sqrt(p.inertia.max() / p.mass))
        return Scales(length=gyration_radius, tau=tau, duration=LASTS, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Angular velocity in both axes, attitude, and the position x, y, z of the centre."""
        length = self.scales(p).length
        return (
            *_attitude.quantities(float(norm(p.omega_body))),
            *(Quantity(axis, "m", length) for axis in "xyz"),
        )

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The angular velocity, the attitude and the position, by component."""
        return _attitude.observe(trajectory) | {
            axis: trajectory.position[:, 0, i] for i, axis in enumerate("xyz")
        }

    def truth(self, p: Parameters) -> Truth:
        """Jacobi's functions in flight; on the slope validated integration from corner to
        corner.
        """
        from refdem.truth.closed_forms.neglected_gyroscopic import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = NeglectedGyroscopic()
