"""A block on a slope under Coulomb friction: it stays for ever, or slides with constant
acceleration (chapter 1, section 1.5).
"""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _slope
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Scene

Array = NDArray[np.float64]


class BlockOnSlope(Case):
    """x runs down the slope, unless `heading` turns its fall line; y is its normal, and gravity is
    tilted instead.
    """

    id = "block-on-slope"
    title = "Block on a slope"
    words = ("friction", "incline", "slide", "sliding", "ramp", "creep")
    motion = "rubbing"
    statement = (
        "A block is put on a slope and let go. Where the coefficient of friction is at least the"
        " slope's tangent, the boundary included, it does not move, however long one waits; where"
        " it is less, it slides down with constant acceleration."
    )
    latex = (
        r"s=\begin{cases}0&\mu\ge\tan\alpha\\"
        r" \tfrac12g(\sin\alpha-\mu\cos\alpha)t^2&\mu<\tan\alpha\end{cases}"
    )
    source = "Matuttis and Chen 2014, chapter 1, (1.98): Sgn(0) = [-1, 1]; Coulomb 1785"
    parameters = (
        Parameter(name="mass", default="3", unit="kg", doc="of the block", above=0),
        Parameter(
            name="friction",
            default="3/4",
            unit="1",
            doc="coefficient of static and sliding friction",
            at_least=0,
        ),
        Parameter(
            name="slope",
            default="3/4",
            unit="1",
            doc="tangent of the angle: 3 down and 4 along",
            at_least=0,
        ),
        Parameter(
            name="angle",
            default="",
            unit="rad",
            doc="of the slope; if given, `slope` does not count",
            at_least=0,
            at_most=1.4464,
        ),
        Parameter(name="gravity", default="9.8125", unit="m/s^2", doc="straight down", above=0),
        Parameter(
            name="heading",
            default="0",
            unit="rad",
            doc="angle between x and the fall line, in the plane, towards z",
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for slopes on which the block would tip: tan(angle) = 8 or more."""
        sine, cosine = _slope.tilt(p)
        if not sine < 8 * cosine:
            raise UsageError(
                f"parameter slope: got {p.slope:g}; expected less than 8, beyond which the block"
                " tips"
            )

    def scene(self, p: Parameters) -> Scene:
        """The block flat on the plane y = 0."""
        return _slope.scene(p)

    def scales(self, p: Parameters) -> Scales:
        """The block's height and the time in which it falls as far; 20 of them."""
        fall = float(np.sqrt(_slope.SIDES[1] / p.gravity))
        return Scales(length=_slope.SIDES[1], tau=fall, duration=20 * fall, mass=p.mass)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Displacement s [m] down the slope and its rate v [m/s]."""
        s = self.scales(p)
        return Quantity("s", "m", s.length), Quantity("v", "m/s", s.speed)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """Displacement [m] and velocity [m/s] down the slope at the samples, each (T,)."""
        along_x, along_z = _slope.downhill(p)
        position = trajectory.position[:, 0]
        velocity = trajectory.velocity[:, 0]
        return {
            "s": along_x * position[:, 0] + along_z * position[:, 2],
            "v": along_x * velocity[:, 0] + along_z * velocity[:, 2],
        }

    def truth(self, p: Parameters) -> Truth:
        """The certified motion: rest, decided exactly, or a parabola."""
        from refdem.truth.closed_forms.block_on_slope import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = BlockOnSlope()
