"""Mass properties of solids: Table 1.1, points (1.14), the parallel axis theorem (1.28), the turned
tensor (1.30), hollow bodies (1.31).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from refdem.cases import _solids
from refdem.core.case import Canonical
from refdem.core.parameters import Parameter, Parameters
from refdem.core.problem import Solid
from refdem.core.quantity import Quantity, Scales
from refdem.core.static_problems import MASS_PROPERTIES, Points, SolidDocument
from refdem.core.trajectory import Trajectory
from refdem.core.truth import Truth
from refdem.errors import UsageError

Array = NDArray[np.float64]


class MomentsOfInertia(Canonical):
    """The sizes a, b, c go along x, y, z, but b along x and a along y for the isosceles wedge, as
    in Table 1.1.
    """

    id = "moments-of-inertia"
    title = "Moments of inertia"
    words = ("tensor", "mass", "ellipsoid", "cylinder", "density")
    motion = "formula"
    statement = (
        "Mass, centre of mass and inertia tensor of solids of uniform density: the six of Table"
        " 1.1, their limits (a sphere from the ellipsoid, a thin stick about its middle and its"
        " end, a hoop from the hollow cylinder), a tetrahedron straight and turned, an angle that"
        " is not convex, hollow bodies, a cuboid about its corner, flat plates, and four points. An"
        " engine's own mass properties are judged by them: a wrong tensor makes every tumbling"
        " wrong."
    )
    latex = (
        r"J=\int\left(r^2\mathbb 1-\mathbf r\mathbf r^T\right)\mathrm dm,\qquad"
        r" J_{ij}=J_{ij}^{cm}+m\left(|a|^2\delta_{ij}-a_ia_j\right)"
    )
    source = "Matuttis and Chen 2014, chapter 1, sections 1.3.2 and 1.3.5, Table 1.1"
    parameters = (
        Parameter(
            name="a",
            default="1",
            unit="m",
            doc="first size: a half axis of round solids, else a side",
            above=0,
        ),
        Parameter(name="b", default="2", unit="m", doc="second size", above=0),
        Parameter(name="c", default="3", unit="m", doc="third size, the height", above=0),
        Parameter(
            name="density",
            default="1/2",
            unit="kg/m^3",
            doc="of solids; of plates in kg/m^2",
            above=0,
        ),
        Parameter(
            name="hollow",
            default="1/2",
            unit="1",
            doc="size of a hollow over that of its body",
            above=0,
            at_most=0.99,
        ),
        Parameter(
            name="thin",
            default="1/1000",
            unit="1",
            doc="radius of a stick over its length, wall of a hoop over its radius",
            at_least=1e-4,
            at_most=0.5,
        ),
        Parameter(
            name="attitude",
            default="2,1,0,-1",
            unit="1",
            doc="quaternion of the turned tetrahedron, of any length",
            shape=(4,),
        ),
    )

    def refuse(self, p: Parameters) -> None:
        """Raises UsageError for the zero quaternion, which is no rotation."""
        attitude: Any = p["attitude"]
        if not any(attitude):
            raise UsageError(
                f"parameter attitude: got {p.texts()['attitude']}; expected a quaternion other than"
                " zero"
            )

    def problem(self, p: Parameters) -> Solid:
        """The problem of every solid at these parameters."""
        return Solid(SolidDocument(solids=_solids.solids(p)))

    def scales(self, p: Parameters) -> Scales:
        """The largest size and the mass of a cuboid of it; there is no time."""
        length = max(p.a, p.b, p.c)
        return Scales(length=length, tau=1.0, duration=1.0, mass=p.density * length**3)

    def quantities(self, p: Parameters) -> tuple[Quantity, ...]:
        """Every property of every solid: the scales are the solid's mass m, the largest size L, and
        m L^2, each times the spread of the sums that they may come from.
        """
        quantities = []
        length = self.scales(p).length
        for solid in _solids.solids(p):
            if isinstance(solid.shape, Points):
                mass = sum(solid.shape.mass)
            else:
                mass = p.density * _solids.volume(solid.name, p)
            spread = _solids.spread(solid.name, p)
            unit_and_scale = {
                "mass": ("kg", mass * spread),
                "centre": ("m", length * spread),
                "inertia": ("kg m^2", mass * spread * length**2),
            }
            for name in MASS_PROPERTIES:
                # Before the point: mass, centre or inertia.
                property_kind = name.partition(".")[0]
                unit, scale = unit_and_scale[property_kind]
                quantities.append(Quantity(f"{solid.name}.{name}", unit, scale))
        return tuple(quantities)

    def observe(self, p: Parameters, trajectory: Trajectory) -> dict[str, Array]:
        """The mass properties that the engine could give."""
        return trajectory.values

    def truth(self, p: Parameters) -> Truth:
        """The truth from integrals that are done by hand."""
        from refdem.truth.closed_forms.moments_of_inertia import truth

        return truth(p, {q.name: q.scale for q in self.quantities(p)})


CASE = MomentsOfInertia()
