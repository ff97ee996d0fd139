"""Points of two Poincare sections of the mass on a belt (1.125): once a period of the drive, and
where v = 0 with x > 0 (figs. 1.30 and 1.31).
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from refdem.cases._algebra import AlgebraCase, Row
from refdem.core.parameters import Parameter, Parameters
from refdem.core.truth import Truth
from refdem.errors import UsageError

POWERS = {"quadratic": 2.0, "linear": 1.0}
"""The power of the speed in the last term of mu, by the name of the law."""
STROBES = 3
"""Number of periods of the drive at whose ends position and velocity are compared."""
PASSAGES = 4
"""Number of passages of v = 0 with x > 0 whose times and positions are compared."""


class PoincareSections(AlgebraCase):
    """Points of a mass of 1 kg on a spring of 1 N/m and a belt that moves forward, under the force
    gamma cos(eta t).
    """

    id = "poincare-sections"
    title = "Poincare sections"
    words = ("chaos", "friction", "belt", "stroboscopic", "map")
    motion = "formula"
    units = MappingProxyType(
        {
            **{f"strobe-{n}.0": "m" for n in range(1, STROBES + 1)},
            **{f"strobe-{n}.1": "m/s" for n in range(1, STROBES + 1)},
            **{f"passage-{n}.0": "s" for n in range(1, PASSAGES + 1)},
            **{f"passage-{n}.1": "m" for n in range(1, PASSAGES + 1)},
        }
    )
    statement = (
        "A section makes a list of points of a motion: place and velocity after each period of the"
        " drive, or the time and the place of every passage of v = 0 with x > 0, in either"
        " direction. A passage lies between samples: where a step ends after it, the place is that"
        " of another point of the orbit. At the start of the defaults the motion is chaotic."
    )
    latex = (
        r"\left(x,v\right)\!\left(\tfrac{2\pi n}{\eta}\right);\qquad"
        r" \left(t_n,x(t_n)\right):\;v(t_n)=0,\;x(t_n)>0"
    )
    source = "Matuttis and Chen 2014, section 1.6.2, (1.125), figs. 1.30 and 1.31"
    parameters = (
        Parameter(name="a", default="10", unit="N", doc="normal force", above=0),
        Parameter(name="mu0", default="0.4", unit="1", doc="static friction", above=0),
        Parameter(name="mu1", default="0.1", unit="1", doc="dynamic friction", at_least=0),
        Parameter(
            name="lambda0",
            default="1.42",
            unit="s/m",
            doc="how fast static friction fades",
            at_least=0,
        ),
        Parameter(
            name="lambda1",
            default="0.01",
            unit="s/m",
            doc="how fast friction grows (s^2/m^2 if quadratic)",
            at_least=0,
        ),
        Parameter(
            name="friction_law",
            default="linear",
            unit="",
            doc="last term of mu",
            choices=tuple(POWERS),
        ),
        Parameter(name="belt", default="1", unit="m/s", doc="velocity of the belt", above=0),
        Parameter(name="gamma", default="2", unit="N", doc="amplitude of the drive"),
        Parameter(name="eta", default="5/4", unit="rad/s", doc="frequency of the drive", above=0),
        Parameter(name="x0", default="1", unit="m", doc="place at the start"),
        Parameter(name="v0", default="1/2", unit="m/s", doc="velocity at the start"),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for a start with v = 0 and no force to leave it."""
        if p["v0"] == 0 and p["x0"] == p["gamma"]:
            raise UsageError(
                f"parameter x0: got {p.x0:g} with v0 = 0; expected another place than gamma, where"
                " the mass begins on the section without a force"
            )

    def rows(self, p: Parameters) -> list[Row]:
        """The points of both sections, in their order."""
        friction = [p.a, p.mu0, p.mu1, p.lambda0, p.lambda1]
        power = [POWERS[p.friction_law]]
        motion = [friction, power, [p.belt, p.gamma, p.eta], [p.x0, p.v0]]
        rows: list[Row] = []
        for n in range(1, STROBES + 1):
            rows.append((f"strobe-{n}", "belt-strobe", [*motion, [float(n)]]))
        for n in range(1, PASSAGES + 1):
            rows.append((f"passage-{n}", "belt-passage", [*motion, [float(n)]]))
        return rows

    def sizes(self, p: Parameters) -> dict[str, float]:
        """Places and velocities on the scales of the motion times its phase, and times on that of
        the section, PASSAGES periods.

        A frequency that is off by a rounding u is off in phase by u t: by 2 pi u a period of the
        drive, or 2 pi u/eta of the spring if that is faster.
        """
        of_motion = self.of_motion(p)
        phase_of_period = 2 * np.pi * max(1.0, 1 / p.eta)
        sizes = {}
        for n in range(1, STROBES + 1):
            sizes[f"strobe-{n}.0"] = of_motion["x"] * n * phase_of_period
            sizes[f"strobe-{n}.1"] = of_motion["v"] * n * phase_of_period
        for n in range(1, PASSAGES + 1):
            sizes[f"passage-{n}.0"] = PASSAGES * 2 * np.pi / p.eta
            sizes[f"passage-{n}.1"] = of_motion["x"] * PASSAGES * phase_of_period
        return sizes

    def of_motion(self, p: Parameters) -> Mapping[str, float]:
        """The stretch [m] that balances friction, drive and start; and the velocity [m/s] of as
        large a swing.
        """
        length = p.a * p.mu0 + abs(p.gamma) + abs(p.x0) + abs(p.v0)
        return {"x": float(length), "v": float(length * max(1.0, p.eta))}

    def truth(self, p: Parameters) -> Truth:
        """Validated integration from event to event, the passages among them."""
        from refdem.truth.closed_forms.poincare_sections import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)}, self.of_motion(p))


CASE = PoincareSections()
