"""A cat's head carried through phase space by four flows: figs. 1.18 to 1.20 and 1.22, Liouville's
theorem and its failures.
"""

from refdem.cases import _cat, _flows, _line
from refdem.cases._cat import Array
from refdem.core.case import NEVER, EnsembleCase
from refdem.core.parameters import Parameter, Parameters
from refdem.core.problem import Ensemble
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth


class PhaseFlow(EnsembleCase):
    """Place and velocity of an oscillator, or angle and rate of a pendulum."""

    id = "phase-flow"
    title = "Flow in phase space"
    words = ("liouville", "volume", "ensemble", "symplectic")
    motion = "oscillating"
    statement = (
        "A closed outline, a cat's head, is carried along. Without friction its area is kept: the"
        " oscillator turns it, the pendulum shears it. In a fluid it falls as exp(-2 delta t), and"
        " the density grows in turn. Under dry friction it is kept between turning points, and at"
        " each times (k|x| - f)/(k|x| + f), until all of it lies on the segment |x| <= f/k, v = 0,"
        " part from above, part from below."
    )
    latex = (
        r"A(t)=\oint v\,dx=A_0,\quad A_0e^{-2\delta t},\quad"
        r" \frac{dA^+}{dA^-}=\frac{k|x|-f}{k|x|+f}\ \text{at}\ v=0"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, section 1.4.3, (1.107)-(1.111), figs. 1.18-1.20 and"
        " 1.22"
    )
    parameters = (
        Parameter(
            name="flow",
            default="harmonic",
            unit="",
            doc="which flow carries it",
            choices=_flows.FLOWS,
        ),
        Parameter(
            name="centre",
            default="3/4,-3/4",
            unit="m, m/s",
            doc="place and rate of the head's middle",
            shape=(2,),
        ),
        Parameter(
            name="size",
            default="1/4",
            unit="m, m/s",
            doc="half of the head's width, about",
            above=0,
        ),
        Parameter(
            name="points",
            default="1024",
            unit="1",
            doc="of the outline",
            at_least=32,
            at_most=1_000_000,
            whole=True,
        ),
        *(_line.MASS, _line.STIFFNESS, _line.DELTA),
        Parameter(
            name="friction_force", default="0.15", unit="N", doc="size of the dry friction", above=0
        ),
        Parameter(name="length", default="1", unit="m", doc="the pendulum's rod", above=0),
        Parameter(
            name="gravity", default="1", unit="m/s^2", doc="on the pendulum, along -y", above=0
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a head on both sides of v = 0, where dry friction changes sign."""
        _cat.refuse_crossing(p)

    def problem(self, p: Parameters) -> Ensemble:
        """Points evenly along the sides of the head."""
        return Ensemble(_flows.scene(p), self.times(p), *self.starts(p, _cat.points(p)))

    def starts(self, p: Parameters, outline: Array) -> tuple[Array, Array]:
        """The starts (M, 1, 3) of an outline: points on the line, or on the rod."""
        return _flows.starts(p, outline)

    def scales(self, p: Parameters) -> Scales:
        """L is the largest amplitude of a corner, tau the time of a radian, T two and a half
        periods.
        """
        return _flows.scales(p, _cat.corners(p))

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The position and velocity of every corner of the outline."""
        s = self.scales(p)
        is_pendulum = p.flow == "pendulum"
        if is_pendulum:
            unit = "rad"
        else:
            unit = "m"
        quantities = []
        for corner in range(len(_cat.HEAD)):
            quantities.append(Quantity(f"x_{corner}", unit, s.length, angle=is_pendulum))
            quantities.append(Quantity(f"v_{corner}", f"{unit}/s", s.speed))
        return tuple(quantities)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The place and the rate of every corner at the samples, each (T,)."""
        per_side = trajectory.values["position"].shape[1] // len(_cat.HEAD)
        x, v = self.outline(p, trajectory)
        observed = {}
        for corner in range(len(_cat.HEAD)):
            # The first of the points on the side that begins at the corner.
            point = corner * per_side
            observed[f"x_{corner}"] = x[:, point]
            observed[f"v_{corner}"] = v[:, point]
        return observed

    def outline(self, p: Parameters, trajectory: Trajectory) -> tuple[Array, Array]:
        """Position and velocity (T, M) of all points of the outline."""
        return _flows.phase_points(p, trajectory)

    def meant(self, p: Parameters) -> dict[str, object]:
        """The parameters, with the corners of the head that they give."""
        return {**p, "corners": _cat.corners(p)}

    def truth(self, p: Parameters) -> Truth:
        """The corners one by one, and the area between them."""
        from refdem.truth.closed_forms.phase_flow import truth

        return truth(p, _cat.corners(p), {q.name: q.scale for q in self.quantities(p)})


CASE = PhaseFlow()
