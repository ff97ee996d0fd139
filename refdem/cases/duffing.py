"""Duffing's oscillator without a drive (1.114): a spring that hardens, softens, or has two
wells.
"""

import numpy as np

from refdem.cases import _line, _nonlinear
from refdem.cases._line import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene
from refdem.scene.elements.spring import Spring


class Duffing(Case):
    """A mass of 1 kg on a spring with a cube along x, let go at `amplitude`."""

    id = "duffing"
    title = "Duffing oscillator"
    words = ("nonlinear", "spring", "hardening", "cubic")
    motion = "oscillating"
    statement = (
        "The force of a spring has a cubic part. The frequency rises with the amplitude if beta > 0"
        " and falls if beta < 0; with alpha < 0 < beta there are two wells and a separatrix. With"
        " it comes a third harmonic, about beta A^3/(32 alpha)."
    )
    latex = (
        r"\ddot x+\alpha x+\beta x^3=0,\qquad x=A\,\mathrm{cn}(\Omega"
        r" t\,|\,m),\;\Omega^2=\alpha+\beta A^2,\;m=\frac{\beta A^2}{2\Omega^2}"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.114)-(1.116); the frequency rises: w = w0 (1 + 3"
        " beta A^2/(8 alpha)) in first order"
    )
    parameters = (
        _nonlinear.ALPHA,
        _nonlinear.BETA,
        Parameter(
            name="amplitude", default="1", unit="m", doc="place at the start, where it is at rest"
        ),
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move, or the motion would go to infinity."""
        _line.refuse_nothing(abs(p.amplitude), "amplitude")
        if _nonlinear.duffing_escapes(p, p["amplitude"]):
            raise UsageError(
                f"amplitude {p.amplitude:g} with alpha {p.alpha:g}, beta {p.beta:g}:"
                f" {_nonlinear.ESCAPE}"
            )

    def scene(self, p: Parameters) -> Scene:
        """The mass at rest on a spring of natural length 0: x'' = -alpha x - beta x^3."""
        point = Body(mass=1.0, position=(p.amplitude, 0.0, 0.0))
        return Scene.of([point], [Spring(a=0, stiffness=p.alpha, cubic=p.beta)])

    def scales(self, p: Parameters) -> Scales:
        """L is the farther turning point; 1/tau^2 the largest curvature |alpha + 3 beta x^2| of the
        potential on the way to it.

        The potential alpha x^2/2 + beta x^4/4 is the same at x and at the other turning point X of
        a motion in one well: X^2 = -2 alpha/beta - x^2.
        """
        square = p.amplitude**2
        # Let go nearer to the hill than the bottom of its well, the mass turns farther out.
        is_inner_point = p.beta > 0 and p.alpha + p.beta * square < 0
        if is_inner_point:
            square = -2 * p.alpha / p.beta - square
        curvature = max(abs(p.alpha), abs(p.alpha + 3 * p.beta * square))
        tau = float(1 / np.sqrt(curvature))
        return Scales(length=float(np.sqrt(square)), tau=tau, duration=20 * tau)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The truth in closed form, by Jacobi elliptic functions."""
        from refdem.truth.closed_forms.duffing import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = Duffing()
