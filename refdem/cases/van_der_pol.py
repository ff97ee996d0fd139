"""Van der Pol's oscillator, free and driven (1.124): a limit cycle, and lines where it mixes with
the drive.
"""

import numpy as np

from refdem.cases import _line
from refdem.cases._line import Array
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Body, Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.spring import Spring


class VanDerPol(Case):
    """A mass of 1 kg on a spring of 1 N/m along x, damping mu (x^2 - 1), and the force p sin(drive
    t).
    """

    id = "van-der-pol"
    title = "Van der Pol oscillator"
    words = ("limit", "cycle", "relaxation", "stiff")
    motion = "oscillating"
    statement = (
        "Damping that is negative for small amplitudes and positive for large ones makes every"
        " motion tend to one cycle; for mu = 0.2 its amplitude is 2.00041 and its frequency"
        " 0.99751. A drive adds lines at 2 w - wd and 3 w - 2 wd, w being the cycle's."
    )
    latex = r"\ddot x-\mu(1-x^2)\dot x+x=p\sin\omega t"
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.124), fig. 1.25: mu = 0.2, p in {0, 0.04, 0.4}, w ="
        " 1.15"
    )
    parameters = (
        Parameter(name="mu", default="1/5", unit="1/s", doc="the nonlinearity", above=0),
        Parameter(name="p", default="1/25", unit="m/s^2", doc="amplitude of the force per mass"),
        Parameter(
            name="drive", default="23/20", unit="rad/s", doc="its angular frequency", above=0
        ),
        *_line.START,
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move."""
        if not p.p:
            _line.refuse_nothing(float(np.hypot(p.x0, p.v0)))

    def scene(self, p: Parameters) -> Scene:
        """The mass with spring, dashpot and drive: x'' = -x - mu (x^2 - 1) x' + p sin(w t)."""
        point = Body(mass=1.0, position=(p.x0, 0.0, 0.0), velocity=(p.v0, 0.0, 0.0))
        # sin(w t) = cos(w t - pi/2).
        if p.p:
            force = [Force(a=0, amplitude=p.p, frequency=p.drive, phase=-np.pi / 2)]
        else:
            force = []
        spring = Spring(a=0, stiffness=1.0)
        dashpot = Dashpot(a=0, damping=-p.mu, van_der_pol=p.mu)
        return Scene.of([point], [spring, dashpot, *force])

    def scales(self, p: Parameters) -> Scales:
        """L is the larger of the cycle's amplitude 2 and the start's, plus |p|; 1/tau the largest
        of w0 = 1, the drive, and the damping mu (L^2 - 1).
        """
        start = np.hypot(p.x0, p.v0 / max(1.0, p.mu))
        length = float(max(2.0, start) + abs(p.p))
        strongest_damping = p.mu * (length**2 - 1)
        tau = float(1 / max(1.0, p.drive, strongest_damping))
        return Scales(length, tau=tau, duration=20.0)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The truth by validated integration of the equations of motion."""
        from refdem.truth.closed_forms.van_der_pol import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = VanDerPol()
