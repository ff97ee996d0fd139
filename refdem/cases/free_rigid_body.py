"""A free rigid body that tumbles: Euler's equations (1.35)-(1.37)."""

from numpy.linalg import norm

from refdem.cases import _attitude
from refdem.cases._attitude import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene


class FreeRigidBody(Case):
    """One body rotates freely, without force or torque."""

    id = "free-rigid-body"
    title = "Free rigid body"
    words = (
        "satellite",
        "spacecraft",
        "drone",
        "tumbling",
        "gyroscope",
        "asteroid",
        "euler",
        "rotation",
    )
    motion = "spinning"
    statement = (
        "A rigid body spins in space and nothing acts on it. Its angular momentum stays in space"
        " and its energy stays, yet its angular velocity wanders in periods given by Jacobi's"
        " elliptic functions unless it turns about a principal axis."
    )
    latex = (
        r"J_1\dot\omega_1=(J_2-J_3)\omega_2\omega_3,\quad"
        r" J_2\dot\omega_2=(J_3-J_1)\omega_3\omega_1,\quad "
        r"J_3\dot\omega_3=(J_1-J_2)\omega_1\omega_2,\quad \dot q=\tfrac12\,q\,\omega"
    )
    source = "Matuttis and Chen 2014, chapter 1, (1.35)-(1.37); conserved: (1.137), (1.138)"
    parameters = (
        _attitude.INERTIA,
        Parameter(
            name="omega_body",
            default="0.9,1.1,1.3",
            unit="rad/s",
            doc="angular velocity in principal axes",
            shape=(3,),
        ),
        _attitude.ATTITUDE,
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for values that make no spinning body."""
        _attitude.refuse(p)

    def scene(self, p: Parameters) -> Scene:
        """The body, which starts with its centre at the origin."""
        return _attitude.scene(p, p.omega_body)

    def scales(self, p: Parameters) -> Scales:
        """The scales of the motion, with tau = 1/|omega| at the start."""
        return _attitude.scales(p, p.omega_body)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The components of angular velocity and attitude."""
        return _attitude.quantities(float(norm(p.omega_body)))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The angular velocity (T,) [rad/s] and the attitude, by component."""
        return _attitude.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The certified motion, by Jacobi elliptic and theta functions."""
        from refdem.truth.closed_forms.free_rigid_body import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = FreeRigidBody()
