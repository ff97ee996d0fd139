"""Duffing's oscillator, damped and driven (1.118): its resonance leans over, and which amplitude it
has depends on the past.
"""

import math
from dataclasses import replace

from refdem.cases import _line, _nonlinear
from refdem.cases._line import Array
from refdem.core.case import Case, given
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.scene.elements.force import Force


class DrivenDuffing(Case):
    """A mass of 1 kg on a spring with a cube along x, a dashpot of 2 delta, and the force f0
    cos(drive t).
    """

    id = "driven-duffing"
    title = "Driven Duffing oscillator"
    words = ("chaos", "nonlinear", "resonance", "forcing")
    motion = "oscillating"
    statement = (
        "A periodic force drives a damped mass on a hardening spring. When its frequency is raised"
        " slowly the amplitude climbs and then falls off a fold; when it is lowered the amplitude"
        " jumps up elsewhere. With much damping there is no such hysteresis."
    )
    latex = r"\ddot x+2\delta\dot x+\alpha x+\beta x^3=f_0\cos\omega t"
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.117)-(1.121), figs. 1.23 and 1.24: beta = 0.4 alpha,"
        " f0 = 1.5 alpha"
    )
    parameters = (
        _nonlinear.ALPHA,
        Parameter(
            name="beta", default="2/5", unit="1/(m^2 s^2)", doc="cubic part of the spring per mass"
        ),
        _line.DELTA,
        Parameter(name="f0", default="3/2", unit="m/s^2", doc="amplitude of the force per mass"),
        Parameter(
            name="drive", default="3/2", unit="rad/s", doc="its angular frequency", at_least=0
        ),
        *_line.START,
    )
    chaotic_at = given(
        alpha="-1", beta="1", delta="1/8", f0="2/5", drive="1", duration="72", samples="144"
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move, or the start alone would go to infinity."""
        if _nonlinear.duffing_escapes(p, p["x0"], p["v0"]):
            raise UsageError(
                f"x0 {p.x0:g}, v0 {p.v0:g} with alpha {p.alpha:g}, beta {p.beta:g}:"
                f" {_nonlinear.ESCAPE}"
            )
        _line.refuse_nothing(self.scales(p).length)

    def scene(self, p: Parameters) -> Scene:
        """The mass with spring, dashpot and drive: x'' = -alpha x - beta x^3 - 2 delta x' + f0
        cos(w t).
        """
        if p.f0:
            elements = [Force(a=0, amplitude=p.f0, frequency=p.drive)]
        else:
            elements = []
        return _nonlinear.scene(p, p.alpha, *elements, cubic=p.beta)

    def scales(self, p: Parameters) -> Scales:
        """L is the free amplitude plus the driven one by harmonic balance, or the place to which a
        drive carries the mass out of its well; tau from the largest stiffness alpha + 3 beta L^2 on
        the way.
        """
        length = _nonlinear.duffing_reach(p) + _nonlinear.balanced_amplitude(p)
        inside = _nonlinear.scales(p, p.alpha, length, 3 * p.beta * length**2, p.drive)
        outside = self._reach_outside(p, p.duration or inside.duration)
        if outside <= length:
            return inside
        scales = _nonlinear.scales(p, p.alpha, outside, 3 * p.beta * outside**2, p.drive)
        return replace(scales, duration=inside.duration)

    def _reach_outside(self, p: Parameters, duration: float) -> float:
        """The largest |x| [m] where the drive carries the mass over a rim, at x^2 = -alpha/beta for
        beta < 0; else 0.
        """
        if p.beta >= 0 or p.f0 == 0:
            return 0.0
        alpha = float(p.alpha)
        beta = float(p.beta)
        f0 = float(p.f0)
        drive = float(p.drive)
        rim = math.sqrt(-alpha / beta)

        def acceleration(x: float, t: float) -> float:
            return -(alpha + beta * x * x) * x + f0 * math.cos(drive * t)

        def rate(x: float) -> float:
            return max(drive, math.sqrt(alpha - 3.0 * beta * x * x))

        return _nonlinear.reach_outside(p, acceleration, rate, (rim, -rim), duration)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The truth by validated integration of the equations of motion."""
        from refdem.truth.closed_forms.driven_duffing import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = DrivenDuffing()
