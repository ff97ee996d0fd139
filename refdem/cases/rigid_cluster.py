"""Four points joined by six rods: a rigid body made of constraints."""

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.core.case import Case
from refdem.core.parameters import Parameter, Parameters
from refdem.core.quantity import Quantity, Scales
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError
from refdem.scene import Body, Scene
from refdem.scene.elements.rod import Rod

Array = NDArray[np.float64]
PAIRS = [(i, j) for i in range(4) for j in range(i)]


class RigidCluster(Case):
    """The centre of mass is at rest; the points start with omega x (r - centre)."""

    id = "rigid-cluster"
    title = "Rigid cluster"
    words = ("clump", "molecule", "rods", "constraint", "multisphere", "frame")
    motion = "spinning"
    statement = (
        "Four point masses that do not lie in a plane are joined, each with each, by six rigid"
        " rods, and spin freely. They move as the rigid body with their tensor of inertia does:"
        " rods keep their lengths, momentum and angular momentum stay."
    )
    latex = (
        r"m_i\ddot{\mathbf r}_i=-\sum_j\lambda_{ij}(\mathbf r_i-\mathbf r_j),\quad|\mathbf"
        r" r_i-\mathbf r_j|=l_{ij}"
    )
    source = "Matuttis and Chen 2014, chapter 1, section 1.1.2 (degrees of freedom), (1.35)-(1.37)"
    parameters = (
        Parameter(
            name="masses",
            default="1,2,1,3",
            unit="kg",
            doc="of the four points",
            shape=(4,),
            above=0,
        ),
        Parameter(
            name="positions",
            default="1,0,0,0,1,0,0,0,1,-1,-1/2,0",
            unit="m",
            doc="x, y, z of each at the start",
            shape=(4, 3),
        ),
        Parameter(
            name="omega",
            default="1/2,1,-1/4",
            unit="rad/s",
            doc="angular velocity at the start",
            shape=(3,),
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for points in a plane, which six rods do not hold, and for a cluster
        that does not spin.
        """
        exact: Any = p["positions"]
        points = np.array(exact, dtype=object).reshape(4, 3)
        a, b, c = points[1:] - points[0]
        # a . (b x c), in exact numbers.
        volume: Fraction = a @ np.cross(b, c)
        if volume == 0:
            raise UsageError(
                f"parameter positions: got {p.texts()['positions']}; expected four points that do"
                " not lie in a plane"
            )
        if not any(p.omega):
            raise UsageError(
                f"parameter omega: got {p.texts()['omega']}; expected a cluster that spins"
            )

    def scene(self, p: Parameters) -> Scene:
        """The four points and six rods; the velocities are omega x (r - centre of mass)."""
        centre = p.masses @ p.positions / p.masses.sum()
        velocity = np.cross(p.omega, p.positions - centre)
        columns = zip(p.masses, p.positions.tolist(), velocity.tolist(), strict=True)
        bodies = [Body(mass=m, position=tuple(r), velocity=tuple(v)) for m, r, v in columns]
        rods = []
        for i, j in PAIRS:
            length = float(np.linalg.norm(p.positions[i] - p.positions[j]))
            rods.append(Rod(a=i, b=j, length=length))
        return Scene.of(bodies, rods)

    def scales(self, p: Parameters) -> Scales:
        """L is the largest distance of a point from the centre of mass; tau = 1/|omega|, T = 20
        tau.
        """
        centre = p.masses @ p.positions / p.masses.sum()
        farthest = float(np.linalg.norm(p.positions - centre, axis=1).max())
        tau = 1.0 / float(np.linalg.norm(p.omega))
        return Scales(length=farthest, tau=tau, duration=20 * tau, mass=float(p.masses.sum()))

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """The quantities that are judged: the places [m] of the four points."""
        length = self.scales(p).length
        coordinates = []
        for number in range(1, 5):
            coordinates += [Quantity(f"r{number}.{axis}", "m", length) for axis in "xyz"]
        return tuple(coordinates)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The coordinates [m] of the four points at the samples, each (T,)."""
        names = [quantity.name for quantity in self.quantities(p)]
        columns = trajectory.position.reshape(len(trajectory.t), 12).T
        return dict(zip(names, columns, strict=True))

    def truth(self, p: Parameters) -> Truth:
        """The free rigid body's closed form, in the cluster's principal axes."""
        from refdem.truth.closed_forms.rigid_cluster import truth

        s = self.scales(p)
        return truth(p, {q.name: q.scale for q in self.quantities(p)}, 1.0 / s.tau)


CASE = RigidCluster()
