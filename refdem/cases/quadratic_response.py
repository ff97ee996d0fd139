"""An oscillator with a square in its force, under one or two drives (1.122): it doubles frequencies
and mixes them.
"""

import math
from dataclasses import replace

import numpy as np

from refdem.cases import _line, _nonlinear
from refdem.cases._line import Array
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene
from refdem.scene.elements.force import Force


class QuadraticResponse(Case):
    """A mass of 1 kg on a spring with a square along x, a dashpot of 2 delta, and forces f0
    cos(drive t).
    """

    id = "quadratic-response"
    title = "Quadratic response"
    words = ("nonlinear", "harmonics", "frequency", "vibration")
    motion = "oscillating"
    statement = (
        "The force of a spring has a quadratic part, so that it resists more on one side. Driven at"
        " w the motion has lines at 2 w and 0, driven at two frequencies also at their sum and"
        " their difference. Starts above the escape energy w0^6/(6 eps^2) are refused."
    )
    latex = r"\ddot x+2\delta\dot x+\omega_0^2x+\varepsilon x^2=f_1\cos\omega_1t+f_2\cos\omega_2t"
    source = "Matuttis and Chen 2014, chapter 1, (1.122), (1.123)"
    parameters = (
        Parameter(
            name="w0", default="1", unit="rad/s", doc="frequency of small oscillations", above=0
        ),
        Parameter(
            name="eps",
            default="1/10",
            unit="1/(m s^2)",
            doc="quadratic part of the spring per mass",
        ),
        _line.DELTA,
        Parameter(
            name="f0",
            default="1/5,1/5",
            unit="m/s^2",
            doc="amplitudes of the forces per mass",
            shape=(2,),
        ),
        Parameter(
            name="drive",
            default="3/10,1/2",
            unit="rad/s",
            doc="their angular frequencies",
            at_least=0,
            shape=(2,),
        ),
        *_line.START,
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError if the mass would stay at rest, or would escape without drives."""
        _line.refuse_nothing(self.scales(p).length)
        if _nonlinear.quadratic_escapes(*(p[name] for name in ("w0", "eps", "x0", "v0"))):
            raise UsageError(
                f"x0 {p.x0:g}, v0 {p.v0:g} with w0 {p.w0:g}, eps {p.eps:g}: {_nonlinear.ESCAPE}"
            )

    def _reach_outside(self, p: Parameters, duration: float) -> float:
        """The largest |x| [m] where the drives carry the mass over the rim, at x = -w0^2/eps; else
        0.
        """
        if p.eps == 0 or not np.any(p.f0):
            return 0.0
        stiffness = float(p.w0) ** 2
        eps = float(p.eps)
        forces = list(zip(p.f0.tolist(), p.drive.tolist(), strict=True))
        fastest = float(np.max(p.drive))

        def acceleration(x: float, t: float) -> float:
            # x'' = -(w0^2 + eps x) x + f1 cos(w1 t) + f2 cos(w2 t), without damping.
            pushes: float = sum(f * math.cos(w * t) for f, w in forces)
            return -(stiffness + eps * x) * x + pushes

        def rate(x: float) -> float:
            # The slope of the spring force per mass, w0^2 + 2 eps x, is at most w0^2 + 2 |eps x|.
            return max(fastest, math.sqrt(stiffness + 2.0 * abs(eps * x)))

        return _nonlinear.reach_outside(p, acceleration, rate, (-stiffness / eps,), duration)

    def scene(self, p: Parameters) -> Scene:
        """The mass with spring, dashpot and drives: x'' = -w0^2 x - eps x^2 - 2 delta x' + sum f_i
        cos(w_i t).
        """
        forces = [
            Force(a=0, amplitude=f, frequency=w) for f, w in zip(p.f0, p.drive, strict=True) if f
        ]
        # The sign of a spring's stretch is defined along its direction. With a quadratic term the
        # anchor must therefore be on one side of the whole motion. Its distance is a power of two,
        # so that sums with it are exact.
        if p.eps:
            length = 2.0 ** np.ceil(np.log2(4 * self.scales(p).length))
        else:
            length = 0.0
        return _nonlinear.scene(p, p.w0**2, *forces, quadratic=p.eps, length=float(length))

    def scales(self, p: Parameters) -> Scales:
        """L is the free amplitude plus those that the drives would have without the square term.

        The amplitude of a drive is the steady f/sqrt((w0^2 - w^2)^2 + (2 delta w)^2) (1.105), or f
        T/(2 w0), to which a drive at resonance rises in the duration T, if that is less. Where the
        drives carry the mass out of its well, L is the largest |x| that it reaches.
        """
        steady = np.hypot(p.w0**2 - p.drive**2, 2 * p.delta * p.drive)
        growth = (p.duration or 20 / p.w0) / (2 * p.w0)
        response = float(np.sum(np.abs(p.f0) / np.maximum(steady, 1 / growth)))
        # sqrt(x0^2 + (v0/w0)^2) + sum |f_i|/max(steady_i, 2 w0/T).
        length = float(np.hypot(p.x0, p.v0 / p.w0)) + response
        inside = _nonlinear.scales(p, p.w0**2, length, 2 * p.eps * length, *p.drive)
        outside = self._reach_outside(p, p.duration or inside.duration)
        if outside <= length:
            return inside
        scales = _nonlinear.scales(p, p.w0**2, outside, 2 * p.eps * outside, *p.drive)
        return replace(scales, duration=inside.duration)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: position [m] and velocity [m/s]."""
        return _line.quantities(self.scales(p))

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The position [m] and the velocity [m/s] at the samples, each (T,)."""
        return _line.observe(trajectory)

    def truth(self, p: Parameters) -> Truth:
        """The motion by validated integration of its equation."""
        from refdem.truth.closed_forms.quadratic_response import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = QuadraticResponse()
