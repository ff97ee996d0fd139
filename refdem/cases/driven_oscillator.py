"""The damped oscillator under a periodic force (1.101): transient, resonance, and growth without
damping.
"""

from dataclasses import replace

import numpy as np

from refdem.cases import _line
from refdem.cases._line import Array
from refdem.core.case import NEVER, Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene
from refdem.scene.elements.dashpot import Dashpot
from refdem.scene.elements.force import Force
from refdem.scene.elements.uniform_gravity import UniformGravity


class DrivenOscillator(Case):
    """A mass on a spring along x, a dashpot, gravity along +x, and the force m f0 cos(drive t)."""

    id = "driven-oscillator"
    title = "Driven oscillator"
    words = ("resonance", "vibration", "forcing", "shaker", "friction")
    motion = "oscillating"
    statement = (
        "A periodic force drives a damped mass on a spring. What the start has given decays; what"
        " stays has the drive's frequency and an amplitude that is largest at w^2 = w0^2 - 2"
        " delta^2. Without damping, driven at w0, the amplitude grows as f0 t/(2 w0)."
    )
    latex = (
        r"\ddot x+2\delta\dot x+\omega_0^2x=f_0\cos\omega t,\qquad"
        r" |A|=\frac{f_0}{\sqrt{(\omega_0^2-\omega^2)^2+4\delta^2\omega^2}}"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, (1.101)-(1.106), fig. 1.17; (1.106) only for delta <"
        " w0/sqrt 2; exercise 1.3"
    )
    parameters = (
        _line.MASS,
        _line.STIFFNESS,
        Parameter(name="gravity", default="0", unit="m/s^2", doc="along +x"),
        _line.DELTA,
        Parameter(name="f0", default="1", unit="m/s^2", doc="amplitude of the force per mass"),
        Parameter(name="drive", default="1", unit="rad/s", doc="its angular frequency", at_least=0),
        *_line.START,
    )
    chaotic_at = NEVER

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if nothing would ever move."""
        _line.refuse_nothing(self.scales(p).length)

    def scene(self, p: Parameters) -> Scene:
        """The mass with spring, drive, and dashpot and gravity where there are some: m x'' = -k x -
        2 m delta x' + m g + m f0 cos(w t).
        """
        if p.delta:
            dashpot = [Dashpot(a=0, damping=2 * p.mass * p.delta)]
        else:
            dashpot = []
        if p.gravity:
            gravity = [UniformGravity(g=(p.gravity, 0.0, 0.0))]
        else:
            gravity = []
        drive = Force(a=0, amplitude=p.mass * p.f0, frequency=p.drive)
        return _line.scene(p, drive, *dashpot, *gravity)

    def scales(self, p: Parameters) -> Scales:
        """L is the free amplitude plus the driven one; tau the shorter of the free motion's and
        1/drive.

        The driven amplitude is the steady one, f0/sqrt((w0^2 - w^2)^2 + (2 delta w)^2), or, near
        resonance, f0 T/(2 w0) if that is less: what grows in the duration T.
        """
        free = _line.scales(p, p.mass * p.gravity / p.stiffness)
        square = p.stiffness / p.mass
        steady = float(np.hypot(square - p.drive**2, 2 * p.delta * p.drive))
        growing = abs(p.f0) * (p.duration or free.duration) / (2 * np.sqrt(square))
        if steady:
            response = min(growing, abs(p.f0) / steady)
        else:
            response = growing
        tau = 1 / _line.damped_rate(square, p.delta)
        if p.drive:
            tau = min(tau, 1 / p.drive)
        return replace(free, length=free.length + float(response), tau=tau)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """Transient and steady motion, or linear growth."""
        from refdem.truth.closed_forms.driven_oscillator import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = DrivenOscillator()
