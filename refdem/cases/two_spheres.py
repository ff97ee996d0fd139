"""Two spheres collide under the linear contact law: head-on or oblique, unequal, spinning
(1.7.4).
"""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _collision
from refdem.core.case import Case
from refdem.core.parameters import Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene

Array = NDArray[np.float64]


class TwoSpheres(Case):
    """The spheres move in the centre-of-mass frame, with centres on x, touching without overlap at
    the start.
    """

    id = "two-spheres"
    title = "Two spheres"
    words = ("collision", "contact", "particle", "friction", "dem", "momentum", "spin")
    motion = "colliding"
    statement = (
        "Two solid spheres meet, press each other like a damped spring, rub, and part. Momentum"
        " stays, and so does total angular momentum where the lever arms add up to the distance of"
        " the centres; duration and restitution do not depend on the speed."
    )
    latex = (
        r"F_n=k\,d+c\,\dot d,\quad |F_t|=\min(k_t|s|,\mu F_n),\quad"
        r" b=\frac{c}{2m_\text{eff}},\ \omega_0^2=\frac{k}{m_\text{eff}},"
        r"\ \omega=\sqrt{\omega_0^2-b^2},\quad e=\mathrm{e}^{-bt_c}"
    )
    source = (
        "Matuttis and Chen 2014, chapter 1, section 1.7.4; Schwager and Poeschel 2007 for the force"
        " that must not pull"
    )
    parameters = _collision.PARAMETERS

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for spheres whose centres could meet."""
        _collision.refuse(p)

    def scene(self, p: Parameters) -> Scene:
        """The two spheres, which touch and close, and their contact."""
        return _collision.scene(p)

    def scales(self, p: Parameters) -> Scales:
        """tau = contact duration/pi; two contact durations."""
        return _collision.scales(p)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Position r, velocity v and angular velocity omega of spheres 1 and 2, by component."""
        s = self.scales(p)
        vectors = (
            ("r", "m", s.length),
            ("v", "m/s", s.speed),
            ("omega", "rad/s", _collision.spin_scale(p)),
        )
        components = []
        for number in (1, 2):
            for vector, unit, scale in vectors:
                components += [Quantity(f"{vector}{number}.{axis}", unit, scale) for axis in "xyz"]
        return tuple(components)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The components (T,) of `quantities`, by name and in their order."""
        state = (trajectory.position, trajectory.velocity, trajectory.omega)
        columns = [column[:, body] for body in (0, 1) for column in state]
        names = [quantity.name for quantity in self.quantities(p)]
        return dict(zip(names, np.concatenate(columns, axis=1).T, strict=True))

    def truth(self, p: Parameters) -> Truth:
        """Damped sine along the normal; sticking and gross sliding across it."""
        from refdem.truth.closed_forms.spinning_spheres import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = TwoSpheres()
