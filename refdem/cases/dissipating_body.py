"""A free body that loses energy inside and ends about its third axis (chapter 1, section 1.7.3)."""

from dataclasses import replace

from numpy.linalg import norm

from refdem.cases import _attitude
from refdem.cases._attitude import Array
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.internal_damping import InternalDamping


class DissipatingBody(Case):
    """One free body with damping inside."""

    id = "dissipating-body"
    title = "Dissipating body"
    words = ("satellite", "fuel", "slosh", "nutation", "tumbling", "spacecraft")
    motion = "spinning"
    statement = (
        "A free body spins, and something inside it rubs. Its angular momentum stays, for nothing"
        " acts from outside; its energy falls, and from any start but exactly about its first or"
        " second axis it ends in a steady turn about the axis of largest inertia, where a given"
        " angular momentum has the least energy, L^2/(2 J3)."
    )
    latex = (
        r"\dot{\mathbf L}=\mathbf L\times\left(\omega+c\,\mathbf L\times\omega\right),\quad\dot"
        r" T=-c\,|\mathbf L\times\omega|^2"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, section 1.7.3 and fig. 1.36; the law: Bloch,"
        " Krishnaprasad, Marsden and Ratiu 1996"
    )
    parameters = (
        _attitude.INERTIA,
        Parameter(
            name="omega_body",
            default="1.3,0.7,0.4",
            unit="rad/s",
            doc="angular velocity in principal axes",
            shape=(3,),
        ),
        _attitude.ATTITUDE,
        Parameter(
            name="damping",
            default="1/8",
            unit="s/(kg m^2)",
            doc="c: the body turns with omega + c L x omega",
            at_least=0,
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for values that make no spinning body."""
        _attitude.refuse(p)

    def scene(self, p: Parameters) -> Scene:
        """The body, which starts with its centre at the origin."""
        free = _attitude.scene(p, p.omega_body)
        return Scene(free.bodies, (InternalDamping(a=0, coefficient=p.damping),))

    def scales(self, p: Parameters) -> Scales:
        """The scales of the free body, with tau = 1/(|omega| (1 + c |L|)).

        The body turns with omega + c L x omega, which is at most |omega| (1 + c |L|).
        """
        free = _attitude.scales(p, p.omega_body)
        speed_up = 1 + p.damping * float(norm(p.inertia * p.omega_body))
        return replace(free, tau=free.tau / speed_up)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The components of the angular velocity in principal axes."""
        rate = float(norm(p.omega_body))
        return tuple(Quantity(f"omega_body.{axis}", "rad/s", rate) for axis in "xyz")

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The angular velocity (T,) [rad/s] in principal axes, by component."""
        observed = _attitude.observe(trajectory)
        return {q.name: observed[q.name] for q in self.quantities(p)}

    def truth(self, p: Parameters) -> Truth:
        """The truth by validated integration of the equations of motion."""
        from refdem.truth.closed_forms.dissipating_body import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = DissipatingBody()
