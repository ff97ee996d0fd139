"""Newton's first law (1.7.4): free motion is uniform, and what rests in balance stays at rest; the
scenes are in _rest.
"""

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _rest
from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.scene import Scene

Array = NDArray[np.float64]


class NewtonsFirstLaw(Case):
    """One body left alone, or bodies in exact balance."""

    id = "newtons-first-law"
    title = "Newton's first law"
    words = ("rest", "inertia", "drift", "uniform", "free")
    motion = "flying"
    statement = (
        "If the forces on a body add up to zero its velocity is constant. A free body flies"
        " straight and spins steadily about its third principal axis; a block on the ground, a"
        " stack of two, and two spheres in elastic balance stay where they are."
    )
    latex = r"\sum_i\mathbf F_i=0\;\Rightarrow\;\dot{\mathbf v}=0"
    source = "Matuttis and Chen 2014, chapter 1, section 1.7.4; Newton 1687, law I"
    parameters = (
        Parameter(
            name="member",
            default="free",
            unit="1",
            doc="which scene",
            choices=("free", *_rest.SCENES),
        ),
        Parameter(
            name="velocity", default="1/2,1/4,1/8", unit="m/s", doc="of the free body", shape=(3,)
        ),
        Parameter(
            name="spin",
            default="1",
            unit="rad/s",
            doc="of the free body, about its third principal axis",
            above=0,
        ),
    )

    def scene(self, p: Parameters) -> Scene:
        """The scene of the selected member."""
        if p.member == "free":
            return _rest.free(p.velocity, p.spin)
        return _rest.SCENES[p.member]()

    def scales(self, p: Parameters) -> Scales:
        """For the free body tau = 1/spin, L the way in that time, but at least 1 m; for bodies at
        rest those of `_rest`.
        """
        if p.member != "free":
            return _rest.SCALES[p.member]
        length = max(1.0, float(np.linalg.norm(p.velocity)) / p.spin)
        return Scales(length=length, tau=1.0 / p.spin, duration=20.0 / p.spin)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """State of the free body; displacement r and velocity v of each body at rest."""
        s = self.scales(p)
        columns = []
        if p.member != "free":
            for body in range(1, len(self.scene(p).bodies) + 1):
                columns += [Quantity(f"r{body}.{axis}", "m", s.length) for axis in "xyz"]
                columns += [Quantity(f"v{body}.{axis}", "m/s", s.speed) for axis in "xyz"]
            return tuple(columns)
        columns += [Quantity(axis, "m", s.length) for axis in "xyz"]
        columns += [Quantity(f"v{axis}", "m/s", s.speed) for axis in "xyz"]
        columns += [Quantity(f"omega.{axis}", "rad/s", p.spin) for axis in "xyz"]
        columns += [Quantity(f"attitude.{axis}", "1", 1.0, group="attitude") for axis in "wxyz"]
        return tuple(columns)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The quantities (T,) by name, in their order; displacements are from the scene's start."""
        if p.member == "free":
            columns = [
                trajectory.position[:, 0],
                trajectory.velocity[:, 0],
                trajectory.omega[:, 0],
                trajectory.attitude[:, 0],
            ]
        else:
            displacement = trajectory.position - self.scene(p).bodies.position
            columns = []
            for body in range(displacement.shape[1]):
                columns += [displacement[:, body], trajectory.velocity[:, body]]
        names = [quantity.name for quantity in self.quantities(p)]
        return dict(zip(names, np.concatenate(columns, axis=1).T, strict=True))

    def meant(self, p: Parameters) -> dict[str, object]:
        """The parameters and, for bodies at rest, the numbers of their balance
        (`_rest.balance`).
        """
        if p.member == "free":
            return dict(p)
        return dict(p) | _rest.balance(p.member)

    def truth(self, p: Parameters) -> Truth:
        """A straight line and a steady turn; zeros."""
        from refdem.truth.closed_forms import newtons_first_law as law

        if p.member != "free":
            return law.resting(len(self.scene(p).bodies))
        scale = {q.name: q.scale for q in self.quantities(p)}
        return law.free(scale, position=(0, 0, 0), velocity=p["velocity"], omega=(0, 0, p["spin"]))  # type: ignore[arg-type]


CASE = NewtonsFirstLaw()
